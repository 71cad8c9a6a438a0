/* The resource location that a host gives, as the plain path that pythonfmu's loader can take.
 *
 * The loader drops "file://" and turns %20 into a blank, no more, and it crashes the host where it then finds no module. So the URI
 * (RFC 8089) is decoded here, and the two files that the loader opens are looked for before it is called. */

#define LONGEST_PATH 4096
static Message location_fault;

#if defined(_WIN32)
__declspec(dllimport) void *__stdcall CreateFileA(const char *, unsigned long, unsigned long, void *, unsigned long, unsigned long, void *);
__declspec(dllimport) int __stdcall ReadFile(void *, void *, unsigned long, unsigned long *, void *);
__declspec(dllimport) int __stdcall CloseHandle(void *);
/* Read the first bytes of a file; -1 where it cannot be opened. */
static long first_bytes(const char *path, char *text, size_t n) {
    unsigned long got = 0;
    void *file = CreateFileA(path, 0x80000000ul /* GENERIC_READ */, 1 /* shared */, 0, 3 /* OPEN_EXISTING */, 0, 0);
    if (file == (void *)(long long)-1) return -1;
    int well = ReadFile(file, text, (unsigned long)n, &got, 0);
    CloseHandle(file);
    return well ? (long)got : -1;
}
#else
int open(const char *, int, ...);
long read(int, void *, size_t);
int close(int);
static long first_bytes(const char *path, char *text, size_t n) {
    int file = open(path, 0 /* O_RDONLY */);
    if (file < 0) return -1;
    long got = read(file, text, n);
    close(file);
    return got;
}
#endif

static int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    c |= 32;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static int begins(const char *text, const char *with) {
    while (*with && *text == *with) { text++; with++; }
    return !*with;
}

/* Join text to what stands in to from at on; return its new end, 0 where there is no room. */
static size_t joined(char *to, size_t at, const char *text) {
    while (*text && at + 1 < LONGEST_PATH) to[at++] = *text++;
    to[at] = 0;
    return *text ? 0 : at;
}

/* Write the path that the URI means; its length, 0 where it means no path on this machine. */
static size_t decoded(const char *uri, char *path) {
    size_t n = 0;
    int encoded = begins(uri, "file:");
    if (encoded) {
        uri += 5;
        if (begins(uri, "//localhost/")) uri += 11;
        else if (begins(uri, "///")) uri += 2;
        if (uri[0] == '/' && uri[1] && uri[2] == ':') uri++; /* the letter of a drive: /C:/folder */
    }
    int absolute = uri[0] == '/' || uri[0] == '\\' || (uri[0] && uri[1] == ':');
    for (; absolute && *uri; uri++) {
        char c = *uri;
        int code = encoded && c == '%' && digit(uri[1]) >= 0 ? digit(uri[2]) : -1;
        if (code >= 0) {
            c = (char)(16 * digit(uri[1]) + code);
            uri += 2;
        }
        if (c == '/' && n > 1 && path[n - 1] == '/') continue; /* no "//", which the loader could take for a URI's */
        if (!c || n + 1 >= LONGEST_PATH) return 0;
        path[n++] = c;
    }
    path[n] = 0;
    return n;
}

static const char *no_location(const char *expected, const char *got) {
    location_fault.n = 0;
    say(&location_fault, "resource location: expected ");
    say(&location_fault, expected);
    say(&location_fault, ", got ");
    say(&location_fault, got);
    return location_fault.text;
}

/* Write the plain path of the resources; NULL where all is well, else what is wrong. */
static const char *locate(const char *uri, char *path) {
    char file[LONGEST_PATH], module[200] = {0};
    size_t n = decoded(uri, path), end = 0;
    if (!n) return no_location("the URI of a folder on this machine (file:///...)", uri);
    for (size_t i = 0; path[i]; i++)
        if (begins(path + i, "%20")) return no_location("a path without %20, which pythonfmu reads as a blank", path);
    joined(file, 0, path);
    long got = joined(file, n, "/slavemodule.txt") ? first_bytes(file, module, sizeof module - 1) : -1;
    while (got > 0 && end < (size_t)got && module[end] != '\n') end++;
    module[end] = 0;
    if (!end) return no_location("the FMU's resources there", file);
    n = joined(file, n, "/");
    n = n ? joined(file, n, module) : 0;
    if (!n || !joined(file, n, ".py") || first_bytes(file, module, 1) < 1) return no_location("the FMU's resources there", file);
    return NULL;
}
