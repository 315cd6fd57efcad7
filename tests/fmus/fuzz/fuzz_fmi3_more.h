/* Second part of fuzz_fmi3.c: life of an instance, states, derivatives, steps. */

static void one_call(slot *s);

/* ---- life ---- */

static void enter(slot *s, int mode) {
    s->mode = mode;
    s->in_domain = -1;
}

static void keep_none(slot *s) {
    for (int k = 0; k < KEPT; ++k) {
        if (s->kept[k] && !good(CALL(s, fmi3FreeFMUState, &s->kept[k]))) broken("a state cannot be freed");
        if (s->kept[k]) broken("a freed state is not set to NULL");
    }
}

static void end(slot *s) {
    if (!s->c) return;
    keep_none(s);
    fmi3FreeInstance(s->c);
    s->c = NULL;
    note("[%d] freed", (int)(s - slots));
}

static void begin(slot *s, int exchange, int tame) {
    const int odd = tame ? 99 : below(40);
    const char *name = odd == 2 ? NULL : odd == 3 ? "" : "friction %s%n", *token = odd == 0 ? NULL : odd == 1 ? "{no such}" : FUZZ_TOKEN;
    const char *resources = odd == 4 ? NULL : "/nowhere/";
    const fmi3ValueReference needed[2] = {1, 77};
    memset(s, 0, sizeof *s);
    s->exchange = exchange;
    s->n = FUZZ_N;
    enter(s, INSTANTIATED);
    before(s);
    if (tame) starve_in = -1;
    const int wrong = odd == 0 || odd == 1 || odd == 6 || (exchange && !FUZZ_EXCHANGE), mute = odd == 5 || odd == 7;
    if (odd == 6) s->c = fmi3InstantiateScheduledExecution(name, token, resources, 0, 0, s, logger, NULL, NULL, NULL);
    else if (exchange) s->c = fmi3InstantiateModelExchange(name, token, resources, chance(50), chance(50), odd == 7 ? NULL : s, odd == 5 ? NULL : logger);
    else s->c = fmi3InstantiateCoSimulation(name, token, resources, chance(50), chance(50), chance(20), chance(20), odd == 8 ? needed : NULL,
                                            odd == 8 ? 2 : 0, odd == 7 ? NULL : s, odd == 5 ? NULL : logger, NULL);
    starve_in = -1;
    note("[%d] instantiated %d, odd %d: %p", (int)(s - slots), exchange, odd, s->c);
    tally("fmi3Instantiate", s->c ? OK : ERROR);
    if (s->c && wrong) broken("instantiated with a wrong token or type");
    if (!s->c && !wrong && !starved && odd != 8) broken("not instantiated: %s", s->box.last);
    if (!s->c && s->box.count == seen && !mute) broken("not instantiated without a message");
    if (s->c && mute) { /* without a logger no messages are seen: freed at once */
        fmi3FreeInstance(s->c);
        s->c = NULL;
    }
}

static int initialize(slot *s, double first) {
    const int status = CALL(s, fmi3EnterInitializationMode, chance(50), chance(80) ? 1e-4 : nasty(), first, chance(50), chance(80) ? 1.0 : nasty());
    if (good(status)) {
        enter(s, INITIALIZATION);
        s->time = first;
    }
    return status;
}

static void change_mode(slot *s) {
    const double first = chance(85) ? 0.0 : nasty();
    int status;
    switch (below(11)) {
    case 0:
        status = s->mode;
        expect(s, initialize(s, first), !isfinite(first) ? MUST_FAIL : status == INSTANTIATED ? MUST_SUCCEED : status == UNKNOWN_MODE ? EITHER : MUST_FAIL, "initialization mode");
        break;
    case 1:
        status = BARE(s, fmi3ExitInitializationMode);
        expect(s, status, s->mode == INITIALIZATION ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "end of initialization");
        if (good(status)) enter(s, s->exchange ? EVENT : STEP);
        break;
    case 2:
        if (!chance(20)) break;
        status = BARE(s, fmi3Terminate);
        expect(s, status, s->mode >= STEP && s->mode < ENDED ? MUST_SUCCEED : EITHER, "terminate");
        if (good(status)) enter(s, ENDED);
        break;
    case 3:
        if (!chance(30)) break;
        expect(s, BARE(s, fmi3Reset), MUST_SUCCEED, "reset");
        enter(s, INSTANTIATED);
        s->time = 0.0;
        s->n = FUZZ_N;
        break;
    case 4:
        status = BARE(s, fmi3EnterConfigurationMode);
        expect(s, status, s->mode == INSTANTIATED ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "configuration mode");
        if (good(status)) enter(s, CONFIGURATION);
        break;
    case 5:
        status = BARE(s, fmi3ExitConfigurationMode);
        expect(s, status, s->mode == CONFIGURATION ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "end of configuration");
        if (good(status)) enter(s, INSTANTIATED);
        break;
    default:
        if (s->mode == INSTANTIATED && chance(30) && good(BARE(s, fmi3EnterConfigurationMode))) enter(s, CONFIGURATION);
        if (s->mode == CONFIGURATION) points(s);
        if (s->mode == CONFIGURATION && good(BARE(s, fmi3ExitConfigurationMode))) enter(s, INSTANTIATED);
        if (s->mode == INSTANTIATED) initialize(s, 0.0);
        if (s->mode == INITIALIZATION && good(BARE(s, fmi3ExitInitializationMode))) enter(s, s->exchange ? EVENT : STEP);
        if (s->mode == EVENT && good(BARE(s, fmi3EnterContinuousTimeMode))) enter(s, CONTINUOUS);
    }
}

#include "fuzz_fmi3_compare.h"

/* ---- states of the FMU, whole and corrupted ---- */

/* The state of another instance: one of the same interface type can be taken over. */
static void borrow(slot *s) {
    const slot *other = &slots[below(INSTANCES)];
    const int k = below(KEPT);
    if (!other->c || !other->kept[k]) return;
    const int status = CALL(s, fmi3SetFMUState, other->kept[k]);
    expect(s, status, other->exchange == s->exchange ? MUST_SUCCEED : MUST_FAIL, "the state of another instance");
    if (!good(status)) return;
    enter(s, other->kept_mode[k]);
    s->n = other->kept_n[k];
}

static void states(slot *s) {
    const int k = below(KEPT);
    fmi3Byte *bytes = NULL;
    fmi3FMUState read = NULL;
    size_t size;
    switch (below(7)) {
    case 6: borrow(s); return;
    case 0:
        if (!good(CALL(s, fmi3GetFMUState, &s->kept[k]))) {
            if (!starved) broken("the state is not saved: %s", s->box.last);
            return;
        }
        s->kept_mode[k] = s->mode;
        s->kept_n[k] = s->n;
        return;
    case 1:
        expect(s, CALL(s, fmi3SetFMUState, s->kept[k]), s->kept[k] ? MUST_SUCCEED : MUST_FAIL, "setting a state");
        if (s->kept[k] && !starved) {
            enter(s, s->kept_mode[k]);
            s->n = s->kept_n[k];
        }
        return;
    case 2:
        expect(s, CALL(s, fmi3FreeFMUState, chance(5) ? NULL : &s->kept[k]), MUST_SUCCEED, "freeing a state");
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
    case 2: bytes[1 + below(8)] ^= (fmi3Byte)(1 << below(8)); break;
    case 3: for (size_t i = 24; i < size; ++i) bytes[i + 1] = (fmi3Byte)next_random(); break;
    case 4: { const double bad = nasty(); if (size > 80) memcpy(bytes + 1 + size - 8 * (size_t)(1 + below(9)), &bad, 8); } break;
    default: for (int i = below(8); i >= 0; --i) bytes[1 + below((int)size)] ^= (fmi3Byte)(1 << below(8));
    }
    if (told == size && chance(60)) seal(bytes + 1, size);
    fmi3Byte *exact = (fmi3Byte *)exactly(told, 1);
    if (told) memcpy(exact, bytes + 1, told);
    const int status = CALL(s, fmi3DeserializeFMUState, exact, told, &read);
    expect(s, status, wanted, "a truncated state");
    if (good(status) && good(CALL(s, fmi3SetFMUState, read))) {
        fmi3UInt64 now = 0;
        fmi3ValueReference vr = FUZZ_POINTS;
        enter(s, UNKNOWN_MODE);
        if (FUZZ_SIZED && (fmi3GetUInt64(s->c, &vr, 1, &now, 1) != fmi3OK || now < 1)) broken("n cannot be read in a state from bytes");
        if (FUZZ_SIZED) s->n = (size_t)now;
    }
    fmi3FreeFMUState(s->c, &read);
    if (chance(50)) { /* a buffer of another size */
        fmi3Byte few[4];
        if (size != sizeof few) expect(s, CALL(s, fmi3SerializeFMUState, s->kept[k], few, sizeof few), MUST_FAIL, "a short buffer");
    }
    free(exact);
    free(bytes);
    if (s->mode != UNKNOWN_MODE) return;
    for (int i = below(6); i > 0 && s->c; --i) one_call(s); /* whatever was accepted must be safe to use */
    if (s->c) reset_and_compare(s);
}

/* ---- derivatives, steps ---- */

static void derivatives(slot *s) {
    const int tame = chance(60), adjoint = chance(40);
    list known = pick(s, REAL, tame ? INPUT : 0), unknown = pick(s, REAL, tame ? OUTPUT : 0);
    const list *from = adjoint ? &unknown : &known, *to = adjoint ? &known : &unknown;
    const size_t seeds = tame ? from->count : told_count(from), results = tame ? to->count : told_count(to);
    double *seed = (double *)exactly(seeds, sizeof *seed), *result = (double *)exactly(results, sizeof *result);
    int wanted = EITHER; /* may overflow; other variables may be offered or not */
    if (bad_references(&known) || bad_references(&unknown) || seeds != from->count || results != to->count) wanted = MUST_FAIL;
    const double all = chance(50) ? DBL_MAX : -1e307;
    const int huge = chance(20);
    for (size_t k = 0; k < seeds; ++k) {
        seed[k] = huge ? all : tame ? 1.0 : chance(5) ? nasty() : uniform();
        if (!isfinite(seed[k]) && to->n) wanted = MUST_FAIL;
    }
    const int status = adjoint ? CALL(s, fmi3GetAdjointDerivative, unknown.vr, unknown.n, known.vr, known.n, seed, seeds, result, results)
                               : CALL(s, fmi3GetDirectionalDerivative, unknown.vr, unknown.n, known.vr, known.n, seed, seeds, result, results);
    expect(s, status, wanted, adjoint ? "an adjoint derivative" : "a directional derivative");
    for (size_t k = 0; k < results && good(status); ++k)
        if (!isfinite(result[k])) broken("a derivative is %g", result[k]);
    if (!good(status) && !starved && seeds == from->count && results == to->count && !about_mode(s->box.last) && !named(s, &known, NULL)
        && !named(s, &unknown, NULL))
        broken("the message names no variable: %s", s->box.last);
    free(known.vr);
    free(unknown.vr);
    free(seed);
    free(result);
}

static void step(slot *s) {
    const double time = chance(95) ? s->time : nasty(), h = chance(70) ? 0.1 * uniform() : chance(30) ? 0.0 : chance(30) ? -0.1 : nasty();
    int wanted = s->mode == STEP && time == s->time && h < 1.0 ? (FUZZ_MEMORY ? EITHER : MUST_SUCCEED) : EITHER;
    if (!isfinite(time) || !isfinite(h) || h < 0.0 || (s->mode != STEP && s->mode != UNKNOWN_MODE)) wanted = MUST_FAIL;
    const int status = do_step(s, time, h);
    expect(s, status, wanted, "a step");
    if (good(status)) s->time = isfinite(time + h) ? time + h : 0.0;
    else if (wanted == EITHER && !starved && !about_mode(s->box.last)) {
        int found = strstr(s->box.last, "time") != NULL || strstr(s->box.last, "step") != NULL;
        for (int k = 0; k < VARIABLES; ++k) found |= names(s->box.last, variables[k].name);
        if (!found) broken("the message names no variable: %s", s->box.last);
    }
}

#include "fuzz_fmi3_exchange.h"
