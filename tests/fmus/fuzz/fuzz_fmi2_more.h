/* Second part of fuzz_fmi2.c: life of an instance, states, derivatives, steps. */

static void one_call(slot *s);

/* ---- life ---- */

static void enter(slot *s, int mode) {
    s->mode = mode;
    s->in_domain = -1;
}

static void keep_none(slot *s) {
    for (int k = 0; k < KEPT; ++k) {
        if (s->kept[k] && !good(CALL(s, fmi2FreeFMUstate, &s->kept[k]))) broken("a state cannot be freed");
        if (s->kept[k]) broken("a freed state is not set to NULL");
    }
}

static void end(slot *s) {
    if (!s->c) return;
    keep_none(s);
    fmi2FreeInstance(s->c);
    s->c = NULL;
    note("[%d] freed", (int)(s - slots));
}

static void begin(slot *s, int exchange, int tame) {
    fmi2CallbackFunctions functions = {logger, NULL, NULL, NULL, s};
    const int odd = tame ? 99 : below(40);
    memset(s, 0, sizeof *s);
    s->exchange = exchange;
    snprintf(s->name, sizeof s->name, odd == 3 ? "" : "friction %%s%%n %d", (int)(s - slots));
    enter(s, INSTANTIATED);
    before(s);
    if (tame) starve_in = -1;
    const int wrong = odd == 0 || odd == 1 || (exchange && !FUZZ_EXCHANGE);
    s->c = fmi2Instantiate(odd == 2 ? NULL : s->name, exchange ? fmi2ModelExchange : fmi2CoSimulation,
                           odd == 0 ? NULL : odd == 1 ? "{no such}" : FUZZ_TOKEN, odd == 4 ? NULL : "file:///nowhere",
                           odd == 5 || odd == 2 ? NULL : &functions, chance(50), chance(50));
    starve_in = -1;
    note("[%d] instantiated %d, odd %d: %p", (int)(s - slots), exchange, odd, s->c);
    tally("fmi2Instantiate", s->c ? OK : ERROR);
    if (s->c && wrong) broken("instantiated with a wrong GUID or type");
    if (!s->c && !wrong && !starved) broken("not instantiated: %s", s->box.last);
    if (!s->c && s->box.count == seen && odd != 5 && odd != 2) broken("not instantiated without a message");
    if (s->c && (odd == 5 || odd == 2)) { /* without a logger no messages are seen: freed at once */
        fmi2FreeInstance(s->c);
        s->c = NULL;
    }
}

static void start(slot *s) {
    const int defined = chance(50);
    const double first = chance(85) ? 0.0 : nasty();
    const int status = CALL(s, fmi2SetupExperiment, defined, chance(80) ? 1e-4 : nasty(), first, chance(50), chance(80) ? 1.0 : nasty());
    if (!isfinite(first)) expect(s, status, MUST_FAIL, "a start time that is not finite");
    if (good(status)) s->time = first;
}

static void change_mode(slot *s) {
    int status;
    switch (below(9)) {
    case 0:
        status = BARE(s, fmi2EnterInitializationMode);
        expect(s, status, s->mode == INSTANTIATED ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "initialization mode");
        if (good(status)) enter(s, INITIALIZATION);
        break;
    case 1:
        status = BARE(s, fmi2ExitInitializationMode);
        expect(s, status, s->mode == INITIALIZATION ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "end of initialization");
        if (good(status)) enter(s, s->exchange ? EVENT : STEP);
        break;
    case 2:
        if (!chance(20)) break;
        status = BARE(s, fmi2Terminate);
        expect(s, status, s->mode >= STEP && s->mode < ENDED ? MUST_SUCCEED : EITHER, "terminate");
        if (good(status)) enter(s, ENDED);
        break;
    case 3:
        if (!chance(30)) break;
        expect(s, BARE(s, fmi2Reset), MUST_SUCCEED, "reset");
        enter(s, INSTANTIATED);
        s->time = 0.0;
        break;
    default:
        if (s->mode == INSTANTIATED && good(BARE(s, fmi2EnterInitializationMode))) enter(s, INITIALIZATION);
        if (s->mode == INITIALIZATION && good(BARE(s, fmi2ExitInitializationMode))) enter(s, s->exchange ? EVENT : STEP);
        if (s->mode == EVENT && good(BARE(s, fmi2EnterContinuousTimeMode))) enter(s, CONTINUOUS);
    }
}

#include "fuzz_fmi2_compare.h"

/* ---- states of the FMU, whole and corrupted ---- */

/* The state of another instance: one of the same interface type can be taken over. */
static void borrow(slot *s) {
    const slot *other = &slots[below(INSTANCES)];
    const int k = below(KEPT);
    if (!other->c || !other->kept[k]) return;
    const int status = CALL(s, fmi2SetFMUstate, other->kept[k]);
    expect(s, status, other->exchange == s->exchange ? MUST_SUCCEED : MUST_FAIL, "the state of another instance");
    if (!good(status)) return;
    enter(s, other->kept_mode[k]);
}

static void states(slot *s) {
    const int k = below(KEPT);
    fmi2Byte *bytes = NULL;
    fmi2FMUstate read = NULL;
    size_t size;
    switch (below(7)) {
    case 6: borrow(s); return;
    case 0:
        if (!good(CALL(s, fmi2GetFMUstate, &s->kept[k]))) {
            if (!starved) broken("the state is not saved: %s", s->box.last);
            return;
        }
        s->kept_mode[k] = s->mode;
        return;
    case 1:
        expect(s, CALL(s, fmi2SetFMUstate, s->kept[k]), s->kept[k] ? MUST_SUCCEED : MUST_FAIL, "setting a state");
        if (s->kept[k] && !starved) enter(s, s->kept_mode[k]);
        return;
    case 2:
        expect(s, CALL(s, fmi2FreeFMUstate, chance(5) ? NULL : &s->kept[k]), MUST_SUCCEED, "freeing a state");
        return;
    case 3: copy_and_compare(s); return;
    default: break;
    }
    if (!s->kept[k] || !(size = to_bytes(s, s->kept[k], &bytes))) return;
    size_t told = size;
    int wanted = EITHER;
    switch (below(6)) {
    case 0: told = (size_t)below((int)size); wanted = MUST_FAIL; break;
    case 1: told = chance(50) ? 0 : size - 1; wanted = MUST_FAIL; break;
    case 2: bytes[1 + below(8)] ^= (fmi2Byte)(1 << below(8)); break;
    case 3: for (size_t i = 24; i < size; ++i) bytes[i + 1] = (fmi2Byte)next_random(); break;
    case 4: { const double bad = nasty(); if (size > 80) memcpy(bytes + 1 + size - 8 * (size_t)(1 + below(9)), &bad, 8); } break;
    default: for (int i = below(8); i >= 0; --i) bytes[1 + below((int)size)] ^= (fmi2Byte)(1 << below(8));
    }
    if (told == size && chance(60)) seal(bytes + 1, size);
    fmi2Byte *exact = (fmi2Byte *)exactly(told, 1);
    if (told) memcpy(exact, bytes + 1, told);
    const int status = CALL(s, fmi2DeSerializeFMUstate, exact, told, &read);
    expect(s, status, wanted, "a truncated state");
    if (good(status) && good(CALL(s, fmi2SetFMUstate, read))) enter(s, UNKNOWN_MODE);
    fmi2FreeFMUstate(s->c, &read);
    if (chance(50)) { /* a buffer of another size */
        fmi2Byte few[4];
        if (size != sizeof few) expect(s, CALL(s, fmi2SerializeFMUstate, s->kept[k], few, sizeof few), MUST_FAIL, "a short buffer");
    }
    free(exact);
    free(bytes);
    if (s->mode != UNKNOWN_MODE) return;
    for (int i = below(6); i > 0 && s->c; --i) one_call(s); /* whatever was accepted must be safe to use */
    if (s->c) reset_and_compare(s);
}

/* ---- derivatives, steps ---- */

static void derivatives(slot *s) {
    list known = pick(REAL), unknown = pick(REAL);
    double *seed = (double *)exactly(known.n, sizeof *seed), *result = (double *)exactly(unknown.n, sizeof *result);
    const int tame = chance(60), huge = chance(20);
    int wanted = live(s) ? MUST_SUCCEED : EITHER;
    for (size_t k = 0; k < known.n; ++k) {
        while (tame && (!known.of[k] || known.of[k]->type != REAL || known.of[k]->causality != INPUT)) known.of[k] = &variables[below(VARIABLES)];
        if (known.of[k]) known.vr[k] = known.of[k]->vr;
        seed[k] = huge ? DBL_MAX : tame ? 1.0 : chance(20) ? nasty() : uniform();
        if (!isfinite(seed[k]) || !known.of[k]) { if (unknown.n) wanted = MUST_FAIL; else wanted = EITHER; }
        else if (known.of[k]->causality != INPUT && wanted == MUST_SUCCEED) wanted = EITHER;
    }
    for (size_t k = 0; k < unknown.n; ++k) {
        while (tame && (!unknown.of[k] || unknown.of[k]->type != REAL || unknown.of[k]->causality != OUTPUT)) unknown.of[k] = &variables[below(VARIABLES)];
        if (unknown.of[k]) unknown.vr[k] = unknown.of[k]->vr;
        if (!unknown.of[k]) wanted = MUST_FAIL;
        else if (wanted == MUST_SUCCEED) wanted = EITHER; /* may overflow; other variables may be offered or not */
    }
    const int status = CALL(s, fmi2GetDirectionalDerivative, unknown.vr, unknown.n, known.vr, known.n, seed, result);
    expect(s, status, wanted, "a directional derivative");
    for (size_t k = 0; k < unknown.n && good(status); ++k)
        if (!isfinite(result[k])) broken("the derivative of %s is %g", unknown.of[k]->name, result[k]);
    if (!good(status) && !starved && !about_mode(s->box.last)) { /* one of the two lists must be named */
        int found = 0;
        for (int side = 0; side < 2; ++side) {
            const list *l = side ? &known : &unknown;
            for (size_t k = 0; k < l->n; ++k) {
                char number[16];
                snprintf(number, sizeof number, "%u", l->vr[k]);
                found |= names(s->box.last, l->of[k] ? l->of[k]->name : number);
            }
        }
        if (!found) broken("the message names no variable: %s", s->box.last);
    }
    free(known.vr);
    free(unknown.vr);
    free(seed);
    free(result);
}

static void step(slot *s) {
    const double time = chance(95) ? s->time : nasty(), h = chance(70) ? 0.1 * uniform() : chance(30) ? 0.0 : chance(30) ? -0.1 : nasty();
    int wanted = s->mode == STEP && time == s->time && h < 1.0 ? (FUZZ_MEMORY ? EITHER : MUST_SUCCEED) : EITHER;
    if (!isfinite(time) || !isfinite(h) || h < 0.0 || (s->mode != STEP && s->mode != UNKNOWN_MODE)) wanted = MUST_FAIL;
    const int status = CALL(s, fmi2DoStep, time, h, chance(50));
    expect(s, status, wanted, "a step");
    if (good(status)) s->time = isfinite(time + h) ? time + h : 0.0;
    else if (wanted == EITHER && !starved && !about_mode(s->box.last)) {
        int found = strstr(s->box.last, "time") != NULL || strstr(s->box.last, "step") != NULL;
        for (int k = 0; k < VARIABLES; ++k) {
            char base[64];
            snprintf(base, sizeof base, "%s", variables[k].name);
            base[strcspn(base, "[")] = '\0';
            found |= names(s->box.last, base);
        }
        if (!found) broken("the message names no variable: %s", s->box.last);
    }
}

#include "fuzz_fmi2_exchange.h"
