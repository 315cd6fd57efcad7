/* Fuzzer of an FMI 3.0 friction FMU: calls in random order, several instances in turn. Usage: fuzz SEED CALLS [SPOIL]
   Linked with the files of the FMU's sources/; ends with code 3 and the last calls when a promise is broken. */
#include "fuzz.h"
#include "fmi3Functions.h"

#define INSTANCES 4
#define KEPT 5
#define MOST 9 /* variables in one call */

enum { UNKNOWN_MODE = -1, INSTANTIATED, CONFIGURATION, INITIALIZATION, STEP, EVENT, CONTINUOUS, ENDED };
enum { MUST_FAIL = 0, MUST_SUCCEED, EITHER };

typedef struct {
    fmi3Instance c;
    int exchange, mode, in_domain; /* in_domain: what it was in this continuous-time mode, -1 before it was read */
    double time;
    size_t n; /* contact points */
    mailbox box;
    fmi3FMUState kept[KEPT];
    int kept_mode[KEPT];
    size_t kept_n[KEPT];
} slot;

static slot slots[INSTANCES + 1]; /* the last is used for comparisons */
static long seen;                 /* messages of the slot before the call */

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    if (!environment) return;
    if ((int)status < OK || status > fmi3Fatal) broken("a message with status %d", (int)status);
    if (!category || !*category) broken("a message without category");
    deliver(&((slot *)environment)->box, message);
}

/* Before a call, and after it: errors come with a message, nothing is fatal. */
static void before(slot *s) {
    seen = s->box.count;
    starved = 0;
    starve_in = chance(2) ? below(3) : -1;
}

static int after(slot *s, const char *call, int status) {
    starve_in = -1;
    tally(call, status);
    note("%s[%d] n %zu %s -> %d %s", s->exchange ? "ME" : "CS", (int)(s - slots), s->n, call, status, s->box.count > seen ? s->box.last : "");
    if (status < OK || status >= FATAL) broken("%s returned status %d", call, status);
    if (status == ERROR && s->box.count == seen) broken("%s failed without a message", call);
    return status;
}

#define CALL(s, function, ...) (before(s), after(s, #function, (int)function((s)->c, __VA_ARGS__)))
#define BARE(s, function) (before(s), after(s, #function, (int)function((s)->c)))

static int good(int status) { return status == OK || status == WARNING; }

static void expect(const slot *s, int status, int wanted, const char *what) {
    if (wanted == MUST_FAIL && good(status)) broken("accepted: %s", what);
    if (wanted == MUST_SUCCEED && !good(status) && !starved) broken("refused: %s (%s)", what, s->box.last);
}

static int live(const slot *s) { return s->mode >= INITIALIZATION && s->mode < ENDED; }
static size_t length(const slot *s, const variable *v) { return v->array ? s->n : 1; }

/* ---- values ---- */

typedef struct {
    size_t n, count;
    fmi3ValueReference *vr;
    const variable *of[MOST]; /* NULL: there is no such variable */
} list;

static list pick(const slot *s, int type, int causality) {
    list l;
    l.n = (size_t)below(MOST);
    l.count = 0;
    l.vr = (fmi3ValueReference *)exactly(l.n, sizeof *l.vr);
    const int none = type == 'U' && !FUZZ_SIZED; /* without arrays there is no number of points */
    for (size_t k = 0; k < l.n; ++k) {
        const variable *v = &variables[below(VARIABLES)];
        while (!none && (v->type != type || (causality && v->causality != causality))) v = &variables[below(VARIABLES)];
        l.of[k] = !none && (causality || chance(97)) ? v : NULL;
        l.vr[k] = l.of[k] ? v->vr : chance(50) ? 0xffffffffu - (unsigned)below(3) : 100u + (unsigned)below(1000000);
        l.count += l.of[k] ? length(s, v) : 1;
    }
    return l;
}

static int bad_references(const list *l) {
    int bad = 0;
    for (size_t k = 0; k < l->n; ++k) bad |= !l->of[k];
    return bad;
}

static void check_value(const variable *v, double value) {
    if (SPOILT("negative") && strncmp(v->name, "domain_distance", 15) == 0) value = -1.0;
    if (!isfinite(value)) broken("%s is %g", v->name, value);
    if (v->causality == OUTPUT && value < 0.0) broken("%s is negative: %g", v->name, value);
}

static void check_values(const slot *s, const list *l, const double *value) {
    for (size_t k = 0; k < l->n; ++k)
        for (size_t i = length(s, l->of[k]); i > 0; --i) check_value(l->of[k], *value++);
}

static int named(const slot *s, const list *l, const unsigned char *suspect) {
    char number[16];
    for (size_t k = 0; k < l->n; ++k) {
        snprintf(number, sizeof number, "%u", l->vr[k]);
        if (suspect && !suspect[k]) continue;
        if (l->of[k] && !SPOILT("message") && names(s->box.last, l->of[k]->name)) return 1;
        if ((!l->of[k] || !suspect) && names(s->box.last, number)) return 1;
    }
    return 0;
}

/* A failing call about several variables must name one that it can be about, unless it is about mode or lengths. */
static void check_names(const slot *s, const list *l, const unsigned char *suspect, size_t told) {
    if (starved || told != l->count || about_mode(s->box.last) || named(s, l, suspect)) return;
    broken("the message names no variable at fault: %s", s->box.last);
}

/* How many values the call is told to have: mostly as many as there are. */
static size_t told_count(const list *l) {
    if (chance(96)) return l->count;
    return chance(50) ? l->count + 1 + (size_t)below(3) : l->count ? l->count - 1 : 1;
}

static void get_floats(slot *s) {
    list l = pick(s, REAL, 0);
    const size_t told = told_count(&l);
    double *value = (double *)exactly(told, sizeof *value);
    unsigned char suspect[MOST] = {0};
    int wanted = live(s) ? MUST_SUCCEED : EITHER;
    const int status = CALL(s, fmi3GetFloat64, l.vr, l.n, value, told);
    for (size_t k = 0; k < l.n; ++k) {
        suspect[k] = !l.of[k] || l.of[k]->causality == OUTPUT || l.of[k]->causality == DERIVATIVE;
        if (suspect[k] && wanted == MUST_SUCCEED) wanted = EITHER; /* mu may overflow far outside the domain */
    }
    if (bad_references(&l) || told != l.count) wanted = MUST_FAIL;
    expect(s, status, wanted, "reading variables");
    if (good(status)) check_values(s, &l, value);
    else check_names(s, &l, suspect, told);
    free(l.vr);
    free(value);
}

static void set_floats(slot *s, int tame) {
    list l = pick(s, REAL, tame ? INPUT : 0);
    const size_t told = tame ? l.count : told_count(&l);
    double *value = (double *)exactly(told, sizeof *value);
    unsigned char suspect[MOST] = {0};
    int wanted = MUST_SUCCEED;
    size_t at = 0;
    for (size_t k = 0; k < l.n; ++k) {
        const variable *v = l.of[k];
        const size_t count = v ? length(s, v) : 1;
        if (!v || v->causality == OUTPUT || v->causality == TIME) suspect[k] = 1, wanted = MUST_FAIL;
        else if (v->causality == LOCAL || v->causality == DERIVATIVE || (v->causality == PARAMETER && s->mode != INITIALIZATION)) {
            suspect[k] = 1;
            if (wanted == MUST_SUCCEED) wanted = EITHER;
        }
        for (size_t i = 0; i < count && at < told; ++i, ++at) {
            value[at] = !v ? uniform() : tame || !chance(20) ? v->lower + uniform() * (fmin(v->upper, 3000.0) - v->lower) : some_value(v);
            if (!isfinite(value[at]) && !(v && isinf(v->lower))) suspect[k] = 1, wanted = MUST_FAIL;
            else if (!isfinite(value[at])) { /* variables without limits: the middle above is no number */
                value[at] = chance(90) ? uniform() * 100.0 : nasty();
                if (!isfinite(value[at])) suspect[k] = 1, wanted = MUST_FAIL;
            }
            if (v && (value[at] < v->lower || value[at] > v->upper)) suspect[k] = 1, wanted = wanted == MUST_SUCCEED ? EITHER : wanted;
        }
    }
    for (; at < told; ++at) value[at] = 1.0;
    if (told != l.count) wanted = MUST_FAIL;
    if (!live(s) && s->mode != INSTANTIATED && wanted == MUST_SUCCEED) wanted = EITHER;
    const int status = CALL(s, fmi3SetFloat64, l.vr, l.n, value, told);
    expect(s, status, wanted, "setting variables");
    if (!good(status)) check_names(s, &l, suspect, told);
    else if (l.n && live(s)) { /* the last of a variable counts */
        const variable *v = l.of[l.n - 1];
        const size_t count = length(s, v);
        double *back = (double *)exactly(count, sizeof *back);
        if (good(CALL(s, fmi3GetFloat64, l.vr + l.n - 1, 1, back, count)))
            for (size_t i = 0; i < count; ++i)
                if (back[i] != value[told - count + i]) broken("%s was set to %g and is %g", v->name, value[told - count + i], back[i]);
        free(back);
    }
    free(l.vr);
    free(value);
}

static void booleans(slot *s) {
    list l = pick(s, BOOLEAN, 0);
    const size_t told = told_count(&l);
    fmi3Boolean *value = (fmi3Boolean *)exactly(told, sizeof *value);
    unsigned char suspect[MOST] = {0};
    const int set = chance(40);
    int wanted = live(s) && s->mode != CONTINUOUS ? MUST_SUCCEED : EITHER;
    for (size_t k = 0; k < l.n; ++k) {
        suspect[k] = !l.of[k] || (set && l.of[k]->causality == OUTPUT);
        if (suspect[k]) wanted = MUST_FAIL;
    }
    if (told != l.count) wanted = MUST_FAIL;
    for (size_t k = 0; k < told && set; ++k) {
        const unsigned char byte = (unsigned char)(chance(90) ? below(2) : below(256)); /* other languages hand over any byte */
        memcpy(value + k, &byte, 1);
    }
    const int status = set ? CALL(s, fmi3SetBoolean, l.vr, l.n, value, told) : CALL(s, fmi3GetBoolean, l.vr, l.n, value, told);
    expect(s, status, wanted, set ? "setting Booleans" : "reading Booleans");
    if (!good(status)) check_names(s, &l, suspect, told);
    for (size_t k = 0; k < l.n && !set && good(status); ++k) {
        unsigned char byte;
        memcpy(&byte, value + k, 1);
        if (byte > 1) broken("%s is %d", l.of[k]->name, byte);
        if (s->mode != CONTINUOUS || strcmp(l.of[k]->name, "in_domain") != 0) continue;
        if (s->in_domain >= 0 && s->in_domain != byte) broken("in_domain changed outside an event");
        s->in_domain = byte;
    }
    free(l.vr);
    free(value);
}

/* The number of points: in configuration mode only, within its limits; all else must be refused. */
static void points(slot *s) {
    static const fmi3UInt64 odd[] = {0, 100001, 1u << 31, (fmi3UInt64)1 << 32, (fmi3UInt64)1 << 60, UINT64_MAX / 8, UINT64_MAX / 40 + 1,
                                     UINT64_MAX, ((fmi3UInt64)1 << 32) + 4};
    list l = pick(s, COUNT, 0);
    fmi3UInt64 *value = (fmi3UInt64 *)exactly(l.n, sizeof *value);
    unsigned char suspect[MOST] = {0};
    const int set = chance(60);
    size_t n = s->n;
    int wanted = set && s->mode != CONFIGURATION && s->mode != UNKNOWN_MODE && l.n ? MUST_FAIL : live(s) || s->mode == CONFIGURATION ? MUST_SUCCEED : EITHER;
    if (set && !l.n) wanted = EITHER;
    for (size_t k = 0; k < l.n; ++k) {
        value[k] = chance(25) ? odd[below((int)(sizeof odd / sizeof odd[0]))] : chance(98) ? 1 + (fmi3UInt64)below(40) : 1000;
        suspect[k] = !l.of[k] || (set && (value[k] < 1 || value[k] > 100000));
        if (suspect[k]) wanted = MUST_FAIL;
    }
    const int status = set ? CALL(s, fmi3SetUInt64, l.vr, l.n, value, l.n) : CALL(s, fmi3GetUInt64, l.vr, l.n, value, l.n);
    expect(s, status, wanted, set ? "setting the number of points" : "reading the number of points");
    if (!good(status)) check_names(s, &l, suspect, l.count);
    for (size_t k = 0; k < l.n && good(status); ++k) n = (size_t)value[k];
    if (good(status) && !set && n != s->n) broken("n is %zu instead of %zu", n, s->n);
    if (FUZZ_SIZED && set && l.n) { /* a refused list may have been set in part: asked, not assumed */
        fmi3UInt64 now = 0;
        fmi3ValueReference vr = FUZZ_POINTS;
        if (fmi3GetUInt64(s->c, &vr, 1, &now, 1) != fmi3OK || now < 1 || now > 100000) broken("n cannot be read after it was set");
        if (good(status) && now != n) broken("n was set to %zu and is %zu", n, (size_t)now);
        s->n = (size_t)now;
    }
    free(l.vr);
    free(value);
}

#include "fuzz_fmi3_more.h"
