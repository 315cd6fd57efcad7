/* Shared by the fuzzers of both FMI versions: random numbers by seed, nasty values, the trace of calls, allocations
   that fail, and messages. `variables.h` is written from modelDescription.xml, not from the sources under test. */
#ifndef FUZZ_H
#define FUZZ_H
#define STARVING_HOST
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include "starving.h"

enum { OK = 0, WARNING, DISCARD, ERROR, FATAL };
enum { REAL = 'R', BOOLEAN = 'B', COUNT = 'U' };
enum { INPUT = 'i', OUTPUT = 'o', PARAMETER = 'p', LOCAL = 'l', STRUCTURAL = 's', TIME = 't', DERIVATIVE = 'd' };

typedef struct {
    const char *name;
    unsigned vr;
    int type, causality;
    int array; /* sized by the structural parameter */
    double lower, upper, start;
} variable;

#include "variables.h"
#define VARIABLES ((int)(sizeof variables / sizeof variables[0]))

/* ---- random numbers ---- */

static uint64_t random_state;
static uint64_t first_seed;
static long call_number;

static uint64_t next_random(void) { /* splitmix64 */
    uint64_t z = (random_state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static int below(int n) { return (int)(next_random() % (uint64_t)n); }
static int chance(int percent) { return below(100) < percent; }
static double uniform(void) { return (double)(next_random() >> 11) * 0x1p-53; }

static double nasty(void) {
    static const double values[] = {0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, DBL_MIN, DBL_MAX, -DBL_MAX, 1e300, -1e300, 1e20,
                                    -1e20, 709.8, -745.2, 1e-300, 0x1p53, 0x1p31, -0x1p31, 0x1p63, 4294967296.0};
    union { uint64_t bits; double value; } any;
    switch (below(4)) {
    case 0: return chance(50) ? NAN : chance(50) ? INFINITY : -INFINITY;
    case 1: any.bits = next_random(); return any.value;
    default: return values[below((int)(sizeof values / sizeof values[0]))];
    }
}

/* A value for a variable: mostly one that is meant, sometimes at or beyond its limits, sometimes anything. */
static double some_value(const variable *v) {
    const double lower = isfinite(v->lower) ? v->lower : -100.0, upper = isfinite(v->upper) ? v->upper : 3000.0;
    if (chance(12)) return nasty();
    if (chance(10)) return chance(50) ? nextafter(lower, chance(50) ? -INFINITY : INFINITY) : upper;
    if (chance(20)) return v->start;
    if (chance(50)) return lower + uniform() * (upper - lower);
    return v->start * (0.5 + uniform());
}

/* A fault put in on purpose after some calls, to show that the harness sees it. */
static const char *spoil = "";
#define SPOILT(what) (call_number > 500 && strcmp(spoil, what) == 0)

/* ---- what happened ---- */

#define TRACE 24
static char trace[TRACE][160];

static void note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(trace[++call_number % TRACE], sizeof trace[0], format, arguments);
    va_end(arguments);
}

static void broken(const char *format, ...) {
    va_list arguments;
    for (long i = call_number >= TRACE ? call_number - TRACE + 1 : 1; i <= call_number; ++i)
        fprintf(stderr, "  call %ld: %s\n", i, trace[i % TRACE]);
    fprintf(stderr, "BROKEN at seed %llu, call %ld: ", (unsigned long long)first_seed, call_number);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    fflush(NULL);
    _Exit(3); /* what is not freed then is no leak of the FMU */
}

/* ---- allocations of the FMU ---- */

static int starve_in = -1; /* allocations until one fails; negative: none fails */
static int starved;        /* one has failed since the flag was cleared */
static long allocated;

void *fuzz_allocate(void *old, size_t count, size_t size, int clear) {
    void *block;
    if (starve_in == 0 || (size && count > SIZE_MAX / size)) {
        starved = 1;
        return NULL;
    }
    if (starve_in > 0) --starve_in;
    block = old ? realloc(old, count * size) : clear ? calloc(count, size) : malloc(count * size);
    if (block && !old) ++allocated;
    if (block && !clear && !old) memset(block, 0xa5, count * size); /* nothing may be read before it is written */
    return block;
}

void fuzz_free(void *block) {
    if (block) --allocated;
    free(block);
}

/* Memory of exactly the size that the call may use, so that AddressSanitizer sees one step beyond it. */
static void *exactly(size_t count, size_t size) {
    void *block = count ? malloc(count * size) : NULL;
    if (count && !block) exit(4);
    if (block) memset(block, 0xa5, count * size);
    return block;
}

/* Damage with a check sum that fits (FNV-1a at the end): what is believed then must be safe all the same. */
static void seal(void *place, size_t size) {
    unsigned char *bytes = (unsigned char *)place;
    uint64_t h = 14695981039346656037u;
    if (size < 8) return;
    for (size_t i = 0; i < size - 8; ++i) h = (h ^ bytes[i]) * 1099511628211u;
    memcpy(bytes + size - 8, &h, 8);
}

/* ---- messages ---- */

typedef struct {
    long count;
    char last[2048];
} mailbox;

static void deliver(mailbox *box, const char *text) {
    if (!text || !*text) broken("an empty message");
    if (strlen(text) >= sizeof box->last) broken("a message of %zu characters", strlen(text));
    if (strchr(text, '%')) broken("a percent sign in a message: %s", text);
    for (const char *c = text; *c; ++c)
        if ((unsigned char)*c < 32 || (unsigned char)*c > 126) broken("a character that is not plain in: %s", text);
    strcpy(box->last, text);
    ++box->count;
}

/* Whether a message is about the mode of the instance rather than about a variable. */
static int about_mode(const char *text) { return strstr(text, "mode") != NULL || strstr(text, "allowed in") != NULL; }

static int in_word(int c) { return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/* Whether a message names a variable, as a whole word; der(age[1]) is good enough for der(age). */
static int names(const char *text, const char *name) {
    char inner[128];
    if (sscanf(name, "der(%127[^)]", inner) == 1) name = inner;
    for (const char *at = strstr(text, name); at; at = strstr(at + 1, name))
        if ((at == text || !in_word((unsigned char)at[-1])) && !in_word((unsigned char)at[strlen(name)])) return 1;
    return 0;
}

/* ---- how often what was called, with which result ---- */

static struct { const char *name; long count[2]; } calls[96];

static void tally(const char *name, int status) {
    int i = 0;
    while (calls[i].name && strcmp(calls[i].name, name) != 0) ++i;
    calls[i].name = name;
    ++calls[i].count[status > WARNING];
}

static void print_tally(void) {
    for (int i = 0; calls[i].name; ++i) printf("%s %ld %ld\n", calls[i].name, calls[i].count[0], calls[i].count[1]);
}

#endif
