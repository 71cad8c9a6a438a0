/* Messages without a C library: text and numbers appended to a fixed buffer. */

/* What says that something is wrong stands apart, so that a call that is well does not make room for its message. */
#if defined(__GNUC__)
#define APART __attribute__((noinline, cold))
#else
#define APART
#endif

typedef struct { char text[400]; size_t n; } Message;

static void say(Message *m, const char *text) {
    while (*text && m->n + 1 < sizeof m->text) m->text[m->n++] = *text++;
    m->text[m->n] = 0;
}

/* Six significant digits, trailing zeros dropped, as in 1.5e-03. */
static void say_number(Message *m, double x) {
    char digits[16] = "0.", tail[2] = "0";
    int exponent = 0;
    if (x != x) { say(m, "NaN"); return; }
    if (x < 0) { say(m, "-"); x = -x; }
    if (x == 0) { say(m, "0"); return; }
    if (x > 1.7976931348623157e308) { say(m, "infinity"); return; }
    while (x >= 10) { x /= 10; exponent++; }
    while (x < 1) { x *= 10; exponent--; }
    long mantissa = (long)(x * 1e5 + 0.5);
    if (mantissa >= 1000000) { mantissa /= 10; exponent++; }
    for (int k = 5; k >= 0; k--) { digits[k ? k + 1 : 0] = (char)('0' + mantissa % 10); mantissa /= 10; }
    digits[1] = '.';
    int n = 7;
    while (n > 1 && (digits[n - 1] == '0' || digits[n - 1] == '.')) n--;
    digits[n] = 0;
    say(m, digits);
    if (exponent == 0) return;
    say(m, exponent < 0 ? "e-" : "e");
    if (exponent < 0) exponent = -exponent;
    for (int unit = exponent >= 100 ? 100 : exponent >= 10 ? 10 : 1; unit; unit /= 10) {
        tail[0] = (char)('0' + exponent / unit % 10);
        say(m, tail);
    }
}
