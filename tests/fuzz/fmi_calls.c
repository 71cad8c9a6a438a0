/* Calls of FMI 2.0 in any order with any arguments, as the bytes on the standard input say, on a native FMU that is included before
 * this text. It must not matter what they are: the sanitizers that this is compiled with are silent, a call that is refused changes
 * nothing, a step that succeeds leaves finite states, and no memory is left. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static unsigned char script[1 << 16];
static size_t script_length, place;
static long blocks;

static unsigned next(void) { return place < script_length ? script[place++] : 0; }

static double next_value(unsigned vr) {
    static const double odd[] = {0, -0.0, 1e-3, -1e-3, 0.005, 0.01, 0.1, 1, 1e9, 1e300, -1e300, 5e-324, 1.7976931348623157e308};
    const double zero = 0;
    unsigned k = next();
    if (k == 255) return zero / zero;
    if (k == 254 || k == 253) return (k == 254 ? 1 : -1) / zero;
    if (k > 128 && vr < HF_END) return fmu_start[vr] * (1 + ((double)k - 190) / 100);
    return odd[k % (sizeof odd / sizeof *odd)];
}

static void *give_memory(size_t n, size_t size) { blocks++; return calloc(n, size); }
static void take_memory(void *memory) { blocks -= memory != NULL; free(memory); }

static void hear(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)e; (void)status;
    if (!strlen(name) || !strlen(category) || !strlen(text)) abort();
}

typedef struct { double v[HF_Y + 1], time; int tangent, mode; } Seen;
static Seen look(const Instance *s) {
    Seen seen;
    memset(&seen, 0, sizeof seen);
    memcpy(seen.v, s->v, HF_Y * sizeof *s->v);
    seen.time = s->time;
    seen.tangent = s->tangent;
    seen.mode = s->mode;
    return seen;
}

enum { SLOTS = 3, MANY = 4 };
static fmi2FMUstate slots[SLOTS];
static fmi2Byte bytes[sizeof(Saved) + 8];
static fmi2ValueReference vr[MANY];
static double value[HK_NX + MANY];
static int whole[MANY];
static size_t size;

static size_t draw(void) {
    size_t n = next() % MANY;
    for (size_t i = 0; i < n; i++) {
        vr[i] = next() % (HF_END + 2);
        value[i] = next_value(vr[i]);
        whole[i] = (int)next() % 3;
    }
    return n;
}

static fmi2Status one_call(Instance *s, unsigned which) {
    fmi2EventInfo info;
    fmi2Status status;
    fmi2String text;
    size_t n, slot;
    switch (which) {
    case 0: return fmi2SetupExperiment(s, 0, 0, next_value(HF_END), next() & 1, next_value(HF_END));
    case 1: return fmi2EnterInitializationMode(s);
    case 2: return fmi2ExitInitializationMode(s);
    case 3: return next() % 8 ? fmi2OK : fmi2Terminate(s);
    case 4: return next() % 8 ? fmi2OK : fmi2Reset(s);
    case 5: n = draw(); return fmi2GetReal(s, next() % 16 ? vr : NULL, n, value);
    case 6: case 7: n = draw(); return fmi2SetReal(s, vr, n, next() % 16 ? value : NULL);
    case 8: n = draw(); return fmi2GetBoolean(s, vr, n, whole);
    case 9: n = draw(); return fmi2SetBoolean(s, vr, n, whole);
    case 10: n = draw(); return fmi2SetRealInputDerivatives(s, vr, n, whole, value);
    case 11: return fmi2GetFMUstate(s, next() % 16 ? &slots[next() % SLOTS] : NULL);
    case 12: return fmi2SetFMUstate(s, slots[next() % SLOTS]);
    case 13: return fmi2FreeFMUstate(s, next() % 16 ? &slots[next() % SLOTS] : NULL);
    case 14: slot = next() % SLOTS; size = sizeof bytes - next() % 16; return fmi2SerializeFMUstate(s, slots[slot], bytes, size);
    case 15: bytes[(next() * 256 + next()) % sizeof bytes] ^= (fmi2Byte)next(); return fmi2OK;
    case 16: return fmi2DeSerializeFMUstate(s, bytes, sizeof(Saved) - (next() % 8 == 0), &slots[next() % SLOTS]);
    case 17: n = draw(); return fmi2GetDirectionalDerivative(s, vr, n, vr, n, value, value);
    case 18: return fmi2EnterEventMode(s);
    case 19: return fmi2NewDiscreteStates(s, next() % 16 ? &info : NULL);
    case 20: return fmi2EnterContinuousTimeMode(s);
    case 21: return fmi2CompletedIntegratorStep(s, 1, whole, next() % 16 ? whole + 1 : NULL);
    case 22: return fmi2SetTime(s, next_value(HF_END));
    case 23: for (int i = 0; i < HK_NX; i++) value[i] = next_value(HF_END); return fmi2SetContinuousStates(s, value, next() % 16 ? HK_NX : 1);
    case 24: return fmi2GetDerivatives(s, value, next() % 16 ? HK_NX : 1);
    case 25: return fmi2GetContinuousStates(s, value, HK_NX);
    case 26: return fmi2GetNominalsOfContinuousStates(s, value, HK_NX);
    case 27: return fmi2GetRealStatus(s, (fmi2StatusKind)(next() % 4), next() % 16 ? value : NULL);
    case 28: return fmi2GetStringStatus(s, (fmi2StatusKind)(next() % 4), &text);
    case 29: n = draw(); return fmi2SetInteger(s, vr, n, whole);
    default:
        /* steps are short, or so long that they are refused: the time is for many scripts */
        value[1] = next_value(HF_END);
        if (value[1] > 0.1 && value[1] < 1e6) value[1] = 0.02;
        status = fmi2DoStep(s, next() % 8 ? s->time : next_value(HF_END), value[1], 1);
        for (int i = 0; status == fmi2OK && i < HK_NX; i++) if (!is_finite(s->v[HF_X + i])) abort();
        return status;
    }
}

static void checked_call(Instance *s) {
    const Seen before = look(s);
    const unsigned which = next() % 36;
    const fmi2Status status = one_call(s, which);
    Seen after = look(s);
    if (status == fmi2Discard) after.mode = before.mode; /* a failed step changes the mode, and nothing else */
    if (status != fmi2OK && status != fmi2Discard && status != fmi2Error) abort();
    if (status != fmi2OK && memcmp(&before, &after, sizeof before)) abort();
}

int main(void) {
    const fmi2CallbackFunctions call = {hear, give_memory, take_memory, NULL, NULL};
    script_length = fread(script, 1, sizeof script, stdin);
    fmi2Component c = fmi2Instantiate("fuzzed", (fmi2Type)(next() & 1), FMU_GUID, "", &call, 0, 1);
    if (!c) abort();
    while (place < script_length) checked_call(c);
    for (int k = 0; k < SLOTS; k++) fmi2FreeFMUstate(c, &slots[k]);
    fmi2FreeInstance(c);
    if (blocks) abort();
    puts("done");
    return 0;
}
