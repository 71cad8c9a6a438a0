/* Scripts of FMI calls: bytes say which call comes next and with which arguments. Scripts stand one after another on the standard
 * input, each behind its length, and are played one by one; each begins with nothing left of the one before, so that it does the same
 * alone. It must not matter what the bytes are: the sanitizers that this is compiled with are silent, and no memory is left.
 *
 * The native FMU stands before this text, its calloc and free renamed to the two below; the calls of one version of FMI follow. */
#undef calloc
#undef free
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_SECONDS = 30 };
static unsigned char script[1 << 16];
static size_t script_length, place;
static long blocks;

void *give_memory(size_t n, size_t size) { blocks++; return calloc(n, size); }
void take_memory(void *memory) { blocks -= memory != NULL; free(memory); }

static unsigned next(void) { return place < script_length ? script[place++] : 0; }

/* Seldom none: a place that is absent. */
#define SELDOM(absent, there) (next() % 16 ? (there) : (absent))

static double next_value(unsigned vr) {
    static const double odd[] = {0, -0.0, 1e-3, -1e-3, 0.005, 0.01, 0.1, 1, 1e9, 1e300, -1e300, 5e-324, 1.7976931348623157e308};
    const double zero = 0;
    unsigned k = next();
    if (k == 255) return zero / zero;
    if (k == 254 || k == 253) return (k == 254 ? 1 : -1) / zero;
    if (k > 128 && vr < HF_END) return fmu_start[vr] * (1 + ((double)k - 190) / 100);
    return odd[k % (sizeof odd / sizeof *odd)];
}

/* Steps are short, or so long that they are refused: the time is for many scripts. */
static double next_step(void) {
    const double dt = next_value(HF_END);
    return dt > 0.1 && dt < 1e6 ? 0.02 : dt;
}

/* Everything of an instance that a refused call must leave as it is. */
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

static void states_are_finite(const Instance *s) {
    for (int i = 0; i < HK_NX; i++) if (!is_finite(s->v[HF_X + i])) abort();
}

/* Arguments, as the script draws them. */
enum { SLOTS = 3, MANY = 4 };
static struct {
    void *slots[SLOTS];
    unsigned char bytes[sizeof(Saved) + 8];
    unsigned vr[MANY];
    double value[HK_NX + MANY];
    int whole[MANY];
} drawn;

static size_t draw(void) {
    size_t n = next() % MANY;
    for (size_t i = 0; i < n; i++) {
        drawn.vr[i] = next() % (HF_END + 2);
        drawn.value[i] = next_value(drawn.vr[i]);
        drawn.whole[i] = (int)next() % 3;
    }
    return n;
}

static void draw_states(void) {
    for (int i = 0; i < HK_NX; i++) drawn.value[i] = next_value(HF_END);
}

static void flip_bits(void) {
    const unsigned at = next() * 256 + next();
    drawn.bytes[at % sizeof drawn.bytes] ^= (unsigned char)next();
}

static void play(void);

int main(void) {
    unsigned char length[4];
    while (fread(length, 1, 4, stdin) == 4) {
        const size_t sent = length[0] | length[1] << 8 | length[2] << 16 | (size_t)length[3] << 24;
        script_length = 0;
        for (size_t i = 0; i < sent; i++) {
            const int byte = getchar();
            if (i < sizeof script) script[script_length++] = (unsigned char)byte;
        }
        place = 0;
        memset(&drawn, 0, sizeof drawn);
        alarm(MOST_SECONDS);
        play();
        alarm(0);
        if (blocks) abort();
        puts("done");
        fflush(stdout);
    }
    return 0;
}
