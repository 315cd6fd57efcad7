/* Last part of fuzz_fmi3.c: model exchange, status functions, and the loop. */

static void exchange_modes(slot *s) {
    fmi3Boolean flag[5];
    fmi3Float64 next = 0.0;
    unsigned char bytes[5];
    int status;
    memset(flag, 7, sizeof flag);
    switch (below(7)) {
    case 0:
        status = BARE(s, fmi3EnterEventMode);
        expect(s, status, s->mode == CONTINUOUS ? MUST_SUCCEED : EITHER, "event mode");
        if (good(status)) enter(s, s->mode == CONTINUOUS || s->mode == EVENT ? EVENT : UNKNOWN_MODE);
        return;
    case 1:
        status = CALL(s, fmi3UpdateDiscreteStates, &flag[0], &flag[1], &flag[2], &flag[3], &flag[4], &next);
        expect(s, status, s->mode == EVENT ? MUST_SUCCEED : EITHER, "new discrete states");
        memcpy(bytes, flag, 5);
        if (!good(status)) return;
        s->in_domain = -1;
        if ((bytes[0] | bytes[1] | bytes[2] | bytes[3] | bytes[4]) > 1) broken("event information is not filled in");
        return;
    case 4: expect(s, BARE(s, fmi3EvaluateDiscreteStates), s->mode == EVENT ? MUST_SUCCEED : EITHER, "discrete states"); return;
    case 5: expect(s, BARE(s, fmi3EnterStepMode), EITHER, "step mode"); return;
    case 2:
        status = BARE(s, fmi3EnterContinuousTimeMode);
        expect(s, status, s->mode == EVENT ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "continuous-time mode");
        if (good(status)) enter(s, CONTINUOUS);
        return;
    case 3:
        status = CALL(s, fmi3CompletedIntegratorStep, chance(50), &flag[0], &flag[1]);
        expect(s, status, s->mode == CONTINUOUS ? MUST_SUCCEED : EITHER, "a completed step");
        memcpy(bytes, flag, 2);
        if (good(status) && (bytes[0] | bytes[1]) > 1) broken("flags of a completed step are not filled in");
        return;
    default: {
        const double time = chance(80) ? uniform() : nasty();
        status = CALL(s, fmi3SetTime, time);
        expect(s, status, !isfinite(time) ? MUST_FAIL : s->mode == CONTINUOUS || s->mode == EVENT ? MUST_SUCCEED : EITHER, "time");
    }
    }
}

static void continuous(slot *s) {
    const size_t right = s->exchange ? FUZZ_STATES * s->n : 0, n = chance(85) ? right : chance(30) ? 0 : (size_t)below(20);
    double *x = (double *)exactly(n, sizeof *x);
    const int what = below(5), here = s->mode == CONTINUOUS || (s->mode == EVENT && what != 0);
    int status, finite = 1;
    int wanted = n != right ? MUST_FAIL : here ? MUST_SUCCEED : EITHER;
    if (!s->exchange) wanted = EITHER; /* co-simulation has no business here; it may be told the states all the same */
    switch (what) {
    case 0:
        for (size_t k = 0; k < n; ++k) {
            x[k] = chance(95) ? uniform() * 10.0 : nasty();
            finite &= isfinite(x[k]) != 0;
        }
        status = CALL(s, fmi3SetContinuousStates, x, n);
        expect(s, status, finite || n != right ? wanted : MUST_FAIL, "continuous states");
        if (!good(status) && !finite && n == right && !starved && !about_mode(s->box.last)) {
            int found = 0;
            for (int k = 0; k < VARIABLES; ++k) found |= variables[k].causality == LOCAL && names(s->box.last, variables[k].name);
            if (!found) broken("the message names no state: %s", s->box.last);
        }
        break;
    case 1:
        status = CALL(s, fmi3GetContinuousStateDerivatives, x, n);
        expect(s, status, wanted == MUST_SUCCEED ? EITHER : wanted, "derivatives of the states");
        break;
    case 2: status = CALL(s, fmi3GetContinuousStates, x, n); expect(s, status, wanted, "reading the states"); break;
    case 3: status = CALL(s, fmi3GetNominalsOfContinuousStates, x, n); expect(s, status, wanted, "nominal values"); break;
    default: {
        double *z = (double *)exactly(FUZZ_INDICATORS, sizeof *z);
        status = CALL(s, fmi3GetEventIndicators, z, FUZZ_INDICATORS);
        for (int k = 0; k < FUZZ_INDICATORS && good(status); ++k)
            if (!isfinite(z[k])) broken("event indicator %d is %g", k, z[k]);
        free(z);
    }
    }
    for (size_t k = 0; k < n && good(status) && what > 0 && what < 4; ++k)
        if (!isfinite(x[k]) || (what == 3 && x[k] <= 0.0)) broken("state or derivative %zu is %g", k, x[k]);
    free(x);
}

/* Types without variables, clocks, dependencies, functions for what is not offered. */
#define NONE(type)                                                                                                      \
    {                                                                                                                   \
        fmi3##type value[3];                                                                                            \
        memset(value, 0, sizeof value);                                                                                 \
        status = set ? CALL(s, fmi3Set##type, n ? vr : NULL, n, n ? value : NULL, n) : CALL(s, fmi3Get##type, n ? vr : NULL, n, n ? value : NULL, n); \
    }                                                                                                                   \
    break

static void other_types(slot *s) {
    const fmi3ValueReference vr[3] = {(unsigned)below(VARIABLES), 1, 0xffffffffu};
    const size_t n = (size_t)below(3);
    const int set = chance(50);
    fmi3Binary binary[3] = {NULL, NULL, NULL};
    fmi3Clock clock[3] = {0, 0, 0};
    fmi3Float64 real[3];
    fmi3UInt64 whole[3];
    fmi3IntervalQualifier qualifier[3];
    size_t sizes[3] = {0, 0, 0};
    int status;
    switch (below(15)) {
    case 0: NONE(Float32);
    case 1: NONE(Int8);
    case 2: NONE(UInt8);
    case 3: NONE(Int16);
    case 4: NONE(UInt16);
    case 5: NONE(Int32);
    case 6: NONE(UInt32);
    case 7: NONE(Int64);
    case 8: NONE(String);
    case 9: status = set ? CALL(s, fmi3SetBinary, vr, n, sizes, binary, n) : CALL(s, fmi3GetBinary, vr, n, sizes, binary, n); break;
    case 10: status = set ? CALL(s, fmi3SetClock, vr, n, clock) : CALL(s, fmi3GetClock, vr, n, clock); break;
    case 11: status = CALL(s, fmi3GetIntervalDecimal, vr, n, real, qualifier); break;
    case 12: status = CALL(s, fmi3GetIntervalFraction, vr, n, whole, whole, qualifier); break;
    case 13: status = CALL(s, fmi3GetShiftDecimal, vr, n, real); break;
    default: status = CALL(s, fmi3GetShiftFraction, vr, n, whole, whole);
    }
    expect(s, status, n ? MUST_FAIL : EITHER, "variables of types that there are not");
}

static void dependencies(slot *s) {
    const variable *v = &variables[below(VARIABLES)];
    const fmi3ValueReference vr = chance(80) ? v->vr : 4000000000u;
    size_t count = 0;
    const int status = CALL(s, fmi3GetNumberOfVariableDependencies, vr, &count);
    expect(s, status, vr != v->vr ? MUST_FAIL : v->causality == OUTPUT ? MUST_SUCCEED : EITHER, "dependencies");
    if (!good(status)) return;
    if (count > 1000000) broken("%zu dependencies", count);
    const size_t told = chance(90) ? count : count + 1;
    size_t *dependents = (size_t *)exactly(told, sizeof(size_t)), *elements = (size_t *)exactly(told, sizeof(size_t));
    fmi3ValueReference *on = (fmi3ValueReference *)exactly(told, sizeof *on);
    fmi3DependencyKind *kinds = (fmi3DependencyKind *)exactly(told, sizeof *kinds);
    const int listed = CALL(s, fmi3GetVariableDependencies, vr, dependents, on, elements, kinds, told);
    expect(s, listed, told == count ? MUST_SUCCEED : MUST_FAIL, "the list of dependencies");
    for (size_t k = 0; k < told && good(listed); ++k)
        if (dependents[k] < 1 || dependents[k] > s->n || elements[k] < 1 || elements[k] > s->n) broken("a dependency on element %zu", elements[k]);
    free(dependents);
    free(elements);
    free(on);
    free(kinds);
}

static void odds_and_ends(slot *s) {
    const char *categories[2] = {"logStatusError", "no such category"};
    const size_t n = (size_t)below(3);
    const fmi3Int32 order = below(3);
    fmi3ValueReference vr = (unsigned)below(8);
    double value = 0.0;
    size_t number = 77;
    switch (below(6)) {
    case 0: CALL(s, fmi3SetDebugLogging, chance(50), n, n ? categories : NULL); break;
    case 1: CALL(s, fmi3GetOutputDerivatives, n ? &vr : NULL, n ? 1 : 0, &order, &value, n ? 1 : 0); break;
    case 2:
        if (good(CALL(s, fmi3GetNumberOfContinuousStates, &number)) && number != FUZZ_STATES * s->n) broken("%zu continuous states", number);
        break;
    case 3:
        if (good(CALL(s, fmi3GetNumberOfEventIndicators, &number)) && s->exchange && number != FUZZ_INDICATORS) broken("%zu event indicators", number);
        break;
    case 4: dependencies(s); break;
    default:
        if (!fmi3GetVersion() || strncmp(fmi3GetVersion(), "3.0", 3) != 0) broken("version");
        fmi3FreeInstance(NULL);
    }
}

static void one_call(slot *s) {
    const int which = below(100);
    if (!s->c) begin(s, FUZZ_EXCHANGE ? below(2) : chance(2), 0);
    else if (which < 1) end(s);
    else if (which < 3) points(s);
    else if (which < 15) change_mode(s);
    else if (which < 33) set_floats(s, chance(70));
    else if (which < 48) get_floats(s);
    else if (which < 56) booleans(s);
    else if (which < 58) other_types(s);
    else if (which < 68) states(s);
    else if (which < 76) derivatives(s);
    else if (which < 82) step(s);
    else if (which < 86) step_twice(s);
    else if (which < 87) reset_and_compare(s), enter(s, INITIALIZATION);
    else if (which < 92) exchange_modes(s);
    else if (which < 97) continuous(s);
    else odds_and_ends(s);
}

int main(int count, char **arguments) {
    if (count < 3) return 2;
    random_state = first_seed = strtoull(arguments[1], NULL, 10);
    const long rounds = strtol(arguments[2], NULL, 10);
    if (count > 3) spoil = arguments[3];
    for (long i = 0; i < rounds; ++i) one_call(&slots[below(INSTANCES)]);
    for (int i = 0; i < INSTANCES; ++i) end(&slots[i]);
    if (allocated) broken("%ld blocks of memory are not freed", allocated);
    print_tally();
    return 0;
}
