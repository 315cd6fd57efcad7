/* Fuzzer of an FMI 2.0 friction FMU: calls in random order, several instances in turn. Usage: fuzz SEED CALLS [SPOIL]
   Linked with the files of the FMU's sources/; ends with code 3 and the last calls when a promise is broken. */
#include "fuzz.h"
#include "fmi2Functions.h"

#define INSTANCES 4
#define KEPT 5
#define MOST 14 /* values in one call */

enum { UNKNOWN_MODE = -1, INSTANTIATED, INITIALIZATION, STEP, EVENT, CONTINUOUS, ENDED };
enum { MUST_FAIL = 0, MUST_SUCCEED, EITHER };

typedef struct {
    fmi2Component c;
    int exchange, mode, in_domain; /* in_domain: what it was in this continuous-time mode, -1 before it was read */
    double time;
    char name[40];
    mailbox box;
    fmi2FMUstate kept[KEPT];
    int kept_mode[KEPT];
} slot;

static slot slots[INSTANCES + 1]; /* the last is used for comparisons */
static long seen;                 /* messages of the slot before the call */

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    slot *s = (slot *)environment;
    if (!name || strcmp(name, s->name) != 0) broken("a message of '%s' arrived at '%s'", name ? name : "", s->name);
    if (status < fmi2OK || status > fmi2Fatal) broken("a message with status %d", (int)status);
    if (!category || !*category) broken("a message without category");
    deliver(&s->box, message);
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
    note("%s[%d] %s -> %d %s", s->exchange ? "ME" : "CS", (int)(s - slots), call, status, s->box.count > seen ? s->box.last : "");
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

/* ---- values ---- */

typedef struct {
    size_t n;
    fmi2ValueReference *vr;
    const variable *of[MOST]; /* NULL: there is no such variable */
} list;

static list pick(int type) {
    list l;
    l.n = (size_t)below(MOST);
    l.vr = (fmi2ValueReference *)exactly(l.n, sizeof *l.vr);
    for (size_t k = 0; k < l.n; ++k) {
        const variable *v = &variables[below(VARIABLES)];
        while (v->type != type) v = &variables[below(VARIABLES)]; /* every FMU here has Real and Boolean variables */
        l.of[k] = chance(97) ? v : NULL;
        l.vr[k] = l.of[k] ? v->vr : chance(50) ? 0xffffffffu - (unsigned)below(3) : 1000u + (unsigned)below(1000000);
    }
    return l;
}

static void check_value(const variable *v, double value) {
    if (SPOILT("negative") && strncmp(v->name, "domain_distance", 15) == 0) value = -1.0;
    if (!isfinite(value)) broken("%s is %g", v->name, value);
    if (v->causality == OUTPUT && value < 0.0) broken("%s is negative: %g", v->name, value);
}

/* A failing call about several variables must name one that it can be about, unless it is about the mode. */
static void check_names(slot *s, const list *l, const unsigned char *suspect) {
    char number[16];
    if (starved || about_mode(s->box.last)) return;
    for (size_t k = 0; k < l->n; ++k) {
        snprintf(number, sizeof number, "%u", l->vr[k]);
        if (suspect[k] && names(s->box.last, l->of[k] && !SPOILT("message") ? l->of[k]->name : number)) return;
    }
    broken("the message names no variable at fault: %s", s->box.last);
}

static void get_real(slot *s) {
    list l = pick(REAL);
    double *value = (double *)exactly(l.n, sizeof *value);
    unsigned char suspect[MOST] = {0};
    int wanted = live(s) ? MUST_SUCCEED : EITHER;
    const int status = CALL(s, fmi2GetReal, l.vr, l.n, value);
    for (size_t k = 0; k < l.n; ++k) {
        suspect[k] = !l.of[k] || l.of[k]->causality == OUTPUT || l.of[k]->causality == DERIVATIVE;
        if (!l.of[k]) wanted = MUST_FAIL;
        else if (suspect[k] && wanted == MUST_SUCCEED) wanted = EITHER; /* mu may overflow far outside the domain */
        if (good(status) && l.of[k]) check_value(l.of[k], value[k]);
    }
    expect(s, status, wanted, "reading variables");
    if (!good(status)) check_names(s, &l, suspect);
    free(l.vr);
    free(value);
}

static void set_real(slot *s, int tame) {
    list l = pick(REAL);
    double *value = (double *)exactly(l.n, sizeof *value);
    unsigned char suspect[MOST] = {0};
    int wanted = MUST_SUCCEED;
    for (size_t k = 0; k < l.n; ++k) {
        const variable *v = l.of[k];
        if (tame) {
            while (!v || (v->causality != INPUT && v->causality != PARAMETER)) v = &variables[below(VARIABLES)];
            while (v->type != REAL || (v->causality != INPUT && v->causality != PARAMETER)) v = &variables[below(VARIABLES)];
            l.of[k] = v;
            l.vr[k] = v->vr;
        }
        value[k] = v ? some_value(v) : uniform();
        if (tame) value[k] = v->lower + uniform() * (fmin(v->upper, 3000.0) - v->lower);
        if (!v || !isfinite(value[k]) || v->causality == OUTPUT) {
            suspect[k] = 1;
            wanted = MUST_FAIL;
            continue;
        }
        suspect[k] = value[k] < v->lower || value[k] > v->upper || (v->causality != INPUT && s->mode != INITIALIZATION)
                     || v->causality == DERIVATIVE;
        if ((suspect[k] || s->mode < INSTANTIATED || s->mode == ENDED) && wanted == MUST_SUCCEED) wanted = EITHER;
    }
    const int status = CALL(s, fmi2SetReal, l.vr, l.n, value);
    expect(s, status, wanted, "setting variables");
    if (!good(status)) check_names(s, &l, suspect);
    else if (l.n && live(s)) { /* the last of a variable counts */
        double back;
        const size_t last = l.n - 1;
        if (good(CALL(s, fmi2GetReal, l.vr + last, 1, &back)) && memcmp(&back, value + last, sizeof back) != 0 && back != value[last])
            broken("%s was set to %g and is %g", l.of[last]->name, value[last], back);
    }
    free(l.vr);
    free(value);
}

static void booleans(slot *s) {
    list l = pick(BOOLEAN);
    fmi2Boolean *value = (fmi2Boolean *)exactly(l.n, sizeof *value);
    unsigned char suspect[MOST] = {0};
    const int set = chance(40);
    int wanted = live(s) && s->mode != CONTINUOUS ? MUST_SUCCEED : EITHER;
    for (size_t k = 0; k < l.n; ++k) {
        suspect[k] = !l.of[k] || (set && l.of[k]->causality == OUTPUT);
        if (suspect[k]) wanted = MUST_FAIL;
        if (set) value[k] = chance(90) ? below(2) : (int)next_random();
    }
    const int status = set ? CALL(s, fmi2SetBoolean, l.vr, l.n, value) : CALL(s, fmi2GetBoolean, l.vr, l.n, value);
    expect(s, status, wanted, set ? "setting Booleans" : "reading Booleans");
    if (!good(status)) check_names(s, &l, suspect);
    for (size_t k = 0; k < l.n && !set && good(status); ++k) {
        if (value[k] != fmi2False && value[k] != fmi2True) broken("%s is %d", l.of[k]->name, value[k]);
        if (s->mode != CONTINUOUS || strcmp(l.of[k]->name, "in_domain") != 0) continue;
        if (s->in_domain >= 0 && s->in_domain != value[k]) broken("in_domain changed outside an event");
        s->in_domain = value[k];
    }
    free(l.vr);
    free(value);
}

/* There are no variables of these types. */
static void other_types(slot *s) {
    fmi2ValueReference vr[2] = {(unsigned)below(3), 7};
    fmi2Integer whole[2] = {1, 2};
    fmi2String text[2] = {"a", NULL};
    const size_t n = (size_t)below(3);
    const int status = chance(25)   ? CALL(s, fmi2GetInteger, n ? vr : NULL, n, n ? whole : NULL)
                       : chance(33) ? CALL(s, fmi2SetInteger, n ? vr : NULL, n, n ? whole : NULL)
                       : chance(50) ? CALL(s, fmi2GetString, n ? vr : NULL, n, n ? text : NULL)
                                    : CALL(s, fmi2SetString, n ? vr : NULL, n, n ? text : NULL);
    expect(s, status, n ? MUST_FAIL : live(s) ? MUST_SUCCEED : EITHER, "variables of types that there are not");
}

#include "fuzz_fmi2_more.h"
