/* Last part of fuzz_fmi2.c: model exchange, status functions, and the loop. */

static void exchange_modes(slot *s) {
    fmi2EventInfo info;
    fmi2Boolean flag[2] = {7, 7};
    int status;
    memset(&info, 0x5a, sizeof info);
    switch (below(5)) {
    case 0:
        status = BARE(s, fmi2EnterEventMode);
        expect(s, status, s->mode == CONTINUOUS ? MUST_SUCCEED : EITHER, "event mode");
        if (good(status)) enter(s, s->mode == CONTINUOUS || s->mode == EVENT ? EVENT : UNKNOWN_MODE);
        return;
    case 1:
        status = CALL(s, fmi2NewDiscreteStates, &info);
        expect(s, status, s->mode == EVENT ? MUST_SUCCEED : EITHER, "new discrete states");
        if (!good(status)) return;
        s->in_domain = -1;
        if ((info.newDiscreteStatesNeeded | info.terminateSimulation | info.nominalsOfContinuousStatesChanged
             | info.valuesOfContinuousStatesChanged | info.nextEventTimeDefined) & ~1) broken("event information is not filled in");
        return;
    case 2:
        status = BARE(s, fmi2EnterContinuousTimeMode);
        expect(s, status, s->mode == EVENT ? MUST_SUCCEED : s->mode == UNKNOWN_MODE ? EITHER : MUST_FAIL, "continuous-time mode");
        if (good(status)) enter(s, CONTINUOUS);
        return;
    case 3:
        status = CALL(s, fmi2CompletedIntegratorStep, chance(50), &flag[0], &flag[1]);
        expect(s, status, s->mode == CONTINUOUS ? MUST_SUCCEED : EITHER, "a completed step");
        if (good(status) && ((flag[0] | flag[1]) & ~1)) broken("flags of a completed step are not filled in");
        return;
    default: {
        const double time = chance(80) ? uniform() : nasty();
        status = CALL(s, fmi2SetTime, time);
        expect(s, status, !isfinite(time) ? MUST_FAIL : s->mode == CONTINUOUS || s->mode == EVENT ? MUST_SUCCEED : EITHER, "time");
    }
    }
}

static void continuous(slot *s) {
    const size_t right = s->exchange ? FUZZ_STATES : 0, n = chance(85) ? right : chance(30) ? 0 : (size_t)below(20);
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
        status = CALL(s, fmi2SetContinuousStates, x, n);
        expect(s, status, finite || n != right ? wanted : MUST_FAIL, "continuous states");
        if (!good(status) && !finite && n == right && !starved && !about_mode(s->box.last)) {
            int found = 0;
            for (int k = 0; k < VARIABLES; ++k) found |= variables[k].causality == LOCAL && names(s->box.last, variables[k].name);
            if (!found) broken("the message names no state: %s", s->box.last);
        }
        break;
    case 1:
        status = CALL(s, fmi2GetDerivatives, x, n);
        expect(s, status, wanted == MUST_SUCCEED ? EITHER : wanted, "derivatives of the states");
        break;
    case 2: status = CALL(s, fmi2GetContinuousStates, x, n); expect(s, status, wanted, "reading the states"); break;
    case 3: status = CALL(s, fmi2GetNominalsOfContinuousStates, x, n); expect(s, status, wanted, "nominal values"); break;
    default: {
        double *z = (double *)exactly(FUZZ_INDICATORS, sizeof *z);
        status = CALL(s, fmi2GetEventIndicators, z, FUZZ_INDICATORS);
        for (int k = 0; k < FUZZ_INDICATORS && good(status); ++k)
            if (!isfinite(z[k])) broken("event indicator %d is %g", k, z[k]);
        free(z);
    }
    }
    for (size_t k = 0; k < n && good(status) && what > 0 && what < 4; ++k)
        if (!isfinite(x[k]) || (what == 3 && x[k] <= 0.0)) broken("state or derivative %zu is %g", k, x[k]);
    free(x);
}

static void odds_and_ends(slot *s) {
    fmi2Status status;
    fmi2Real real = NAN;
    fmi2Integer integer;
    fmi2Boolean boolean = 7;
    fmi2String text = NULL, categories[2] = {"logStatusError", "no such category"};
    fmi2ValueReference vr = (unsigned)below(8);
    const fmi2StatusKind kind = (fmi2StatusKind)below(4);
    const size_t n = (size_t)below(3);
    switch (below(10)) {
    case 0: CALL(s, fmi2SetDebugLogging, chance(50), n, n ? categories : NULL); break;
    case 1: CALL(s, fmi2GetStatus, kind, &status); break;
    case 2: if (good(CALL(s, fmi2GetRealStatus, kind, &real)) && !isfinite(real)) broken("the last time is %g", real); break;
    case 3: CALL(s, fmi2GetIntegerStatus, kind, &integer); break;
    case 4: if (good(CALL(s, fmi2GetBooleanStatus, kind, &boolean)) && (boolean & ~1)) broken("a status of %d", boolean); break;
    case 5: CALL(s, fmi2GetStringStatus, kind, &text); break;
    case 6: BARE(s, fmi2CancelStep); break;
    case 7: integer = below(3); CALL(s, fmi2SetRealInputDerivatives, n ? &vr : NULL, n ? 1 : 0, &integer, &real); break;
    case 8: integer = below(3); CALL(s, fmi2GetRealOutputDerivatives, n ? &vr : NULL, n ? 1 : 0, &integer, &real); break;
    default:
        if (!fmi2GetVersion() || strcmp(fmi2GetVersion(), "2.0") != 0) broken("version");
        if (!fmi2GetTypesPlatform() || strcmp(fmi2GetTypesPlatform(), "default") != 0) broken("platform of types");
        fmi2FreeInstance(NULL);
    }
}

static void one_call(slot *s) {
    const int which = below(100);
    if (!s->c) begin(s, FUZZ_EXCHANGE ? below(2) : chance(2), 0);
    else if (which < 1) end(s);
    else if (which < 3) start(s);
    else if (which < 15) change_mode(s);
    else if (which < 33) set_real(s, chance(70));
    else if (which < 48) get_real(s);
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
