/* An instance, its messages, and its modes: the state machines of FMI 2.0.4, sections 3.2.3 (model exchange) and 4.2.4
 * (co-simulation). The generated tables stand before this text: FMU_GUID, fmu_name[], fmu_role[], fmu_min[], fmu_max[], fmu_start[],
 * fmu_order[][2], fmu_mass[], FMU_SWITCH.
 *
 * A call that is refused changes nothing, the mode included: after fmi2Error the standard lets a host read, restore, reset and free
 * an instance, and here it may also put right what was wrong. */

enum { HIDDEN, INPUT, STATE, PARAMETER, OUTPUT, DERIVATIVE, SLOPE, SENSITIVITY, STEP };
enum { INSTANTIATED = 1, INITIALIZING = 2, STEP_FAILED = 4, TERMINATED = 8, IN_EVENT = 16, IN_CONTINUOUS = 32, IN_STEP = 64 };
enum {
    BEFORE = INSTANTIATED | INITIALIZING,
    GOING = IN_EVENT | IN_CONTINUOUS | IN_STEP,
    SETTABLE = BEFORE | GOING,
    READABLE = INITIALIZING | GOING | STEP_FAILED | TERMINATED,
    ANY = BEFORE | GOING | STEP_FAILED | TERMINATED
};
static const struct { int mode; const char *name; } mode_names[] = {
    {INSTANTIATED, "instantiated"}, {INITIALIZING, "initialization"}, {IN_EVENT, "event"}, {IN_CONTINUOUS, "continuous-time"},
    {IN_STEP, "step complete"}, {STEP_FAILED, "step failed"}, {TERMINATED, "terminated"}};
enum { MODES = sizeof mode_names / sizeof *mode_names };

typedef struct {
    double *v; /* all that a run needs to go on stands in these five */
    double time;
    int tangent, mode, set_up; /* the last: whether the host has set up the experiment */
    int unchecked, stale_outputs, stale_derivatives; /* all that follows can be had from the above, or does not change */
    int stop_given;
    double stop;
    fmi2Type type;
    fmi2Boolean logging;
    fmi2CallbackFunctions call;
    void *slave; /* what the kernel needs beside the buffer v */
    char name[128];
} Instance;

/* Hand a text to the host's logger, which reads it as printf does, and "#r5#" in it as the variable with that reference: a per cent
 * sign or a # of a path, or of another's text, stands twice (FMI 2.0.4, section 2.1.5). */
APART static void log_text(const fmi2CallbackFunctions *call, const char *name, fmi2Status status, const char *category, const char *text) {
    char format[2048];
    size_t n = 0;
    if (!call->logger) return;
    for (; *text && n + 2 < sizeof format; text++) {
        if (*text == '%' || *text == '#') format[n++] = *text;
        format[n++] = *text;
    }
    format[n] = 0;
    call->logger(call->componentEnvironment, name, status, category, format);
}

static fmi2Status tell_host(Instance *s, fmi2Status status, const Message *m) {
    log_text(&s->call, s->name, status, status == fmi2Discard ? "logStatusDiscard" : "logStatusError", m->text);
    return status;
}

static fmi2Status refuse(Instance *s, const Message *m) { return tell_host(s, fmi2Error, m); }

APART static fmi2Status answer_text(Instance *s, fmi2Status status, const char *where, const char *what) {
    Message m = {{0}, 0};
    say(&m, where);
    say(&m, ": ");
    say(&m, what);
    return tell_host(s, status, &m);
}

APART static fmi2Status refuse_text(Instance *s, const char *where, const char *what) { return answer_text(s, fmi2Error, where, what); }

/* Append the names of some modes. */
static void say_modes(Message *m, int modes) {
    const char *between = " ";
    for (int k = 0; k < MODES; k++) {
        if (!(mode_names[k].mode & modes)) continue;
        say(m, between);
        say(m, mode_names[k].name);
        between = " or ";
    }
}

/* Say in which modes the call may come, and that this is none of them. */
APART static int refuse_mode(Instance *s, const char *function, int modes) {
    Message m = {{0}, 0};
    say(&m, function);
    say(&m, ": expected in mode");
    say_modes(&m, modes);
    say(&m, ", got mode");
    say_modes(&m, s->mode);
    refuse(s, &m);
    return 0;
}

/* Whether the call may come in this mode. */
static inline int allowed(Instance *s, const char *function, int modes) {
    return s && (s->mode & modes || refuse_mode(s, function, modes));
}

/* Whether the call may come in this mode, to an instance of this interface. */
static inline int allowed_for(Instance *s, const char *function, fmi2Type type, int modes) {
    if (!s) return 0;
    if (s->type == type) return allowed(s, function, modes);
    refuse_text(s, function, type == fmi2CoSimulation ? "expected an instance for co-simulation, got one for model exchange"
                                                      : "expected an instance for model exchange, got one for co-simulation");
    return 0;
}

/* Whether an array that a host gives is there. */
static inline int given(Instance *s, const char *function, size_t n, const void *references, const void *values) {
    if (!n || (references && values)) return 1;
    refuse_text(s, function, "expected arrays, got none");
    return 0;
}

static int same(const char *a, const char *b) {
    while (*a && *a == *b) { a++; b++; }
    return *a == *b;
}

static int is_finite(double x) { return x - x == 0; }
