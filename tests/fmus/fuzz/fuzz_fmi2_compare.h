/* Third part of fuzz_fmi2.c: the same inputs give the same values, in a copy, after a reset, in a repeated step. */

/* All Real variables: one by one, or first in one call, where blocks of points take another way through the code. */
static void read_all(slot *s, double *value, int *status, int together) {
    fmi2ValueReference vr[VARIABLES];
    double block[VARIABLES];
    size_t n = 0;
    for (int k = 0; k < VARIABLES; ++k)
        if (variables[k].type == REAL) vr[n++] = variables[k].vr;
    const int whole = together && good((int)fmi2GetReal(s->c, vr, n, block));
    n = 0;
    for (int i = 0; i < VARIABLES; ++i) {
        const int k = together ? i : VARIABLES - 1 - i, real = variables[k].type == REAL;
        value[k] = 0.0;
        status[k] = real ? (int)fmi2GetReal(s->c, &variables[k].vr, 1, &value[k]) : OK;
        if (good(status[k]) && real) check_value(&variables[k], value[k]);
        if (whole && real && (!good(status[k]) || memcmp(&block[n++], &value[k], sizeof(double)) != 0))
            broken("%s alone is %.17g (status %d) and together %.17g", variables[k].name, value[k], status[k], block[n - 1]);
    }
}

static void compare(slot *a, slot *b, const char *what) {
    double x[VARIABLES], y[VARIABLES];
    int sx[VARIABLES], sy[VARIABLES];
    read_all(a, x, sx, chance(50));
    read_all(b, y, sy, chance(50));
    if (SPOILT("stale")) x[0] += 1e-9;
    for (int k = 0; k < VARIABLES; ++k)
        if (sx[k] != sy[k] || (good(sx[k]) && memcmp(&x[k], &y[k], sizeof(double)) != 0))
            broken("%s: %s is %.17g (status %d), and %.17g (status %d)", what, variables[k].name, x[k], sx[k], y[k], sy[k]);
}

static size_t to_bytes(slot *s, fmi2FMUstate state, fmi2Byte **bytes) {
    size_t size = 0;
    *bytes = NULL;
    if (!good(CALL(s, fmi2SerializedFMUstateSize, state, &size))) return 0;
    if (size > 100000000u) broken("a serialized state of %zu bytes", size);
    *bytes = (fmi2Byte *)exactly(size + 1, 1); /* one more: handed over at an odd address */
    if (good(CALL(s, fmi2SerializeFMUstate, state, *bytes + 1, size))) return size;
    if (!starved) broken("a state cannot be serialized");
    free(*bytes);
    *bytes = NULL;
    return 0;
}

static void copy_and_compare(slot *s) {
    slot *copy = &slots[INSTANCES];
    fmi2FMUstate state = NULL, read = NULL;
    fmi2Byte *bytes = NULL;
    begin(copy, s->exchange, 1);
    if (good(CALL(s, fmi2GetFMUstate, &state))) {
        const size_t size = to_bytes(s, state, &bytes);
        if (size && good(CALL(copy, fmi2DeSerializeFMUstate, bytes + 1, size, &read)) && good(CALL(copy, fmi2SetFMUstate, read)))
            compare(s, copy, "a copy through bytes");
        else if (size && !starved) broken("a state is not accepted by another instance: %s", copy->box.last);
    }
    free(bytes);
    fmi2FreeFMUstate(s->c, &state);
    fmi2FreeFMUstate(copy->c, &read);
    end(copy);
}

static void reset_and_compare(slot *s) {
    slot *fresh = &slots[INSTANCES];
    begin(fresh, s->exchange, 1);
    expect(s, BARE(s, fmi2Reset), MUST_SUCCEED, "reset");
    s->time = 0.0;
    for (int k = 0; k < 2; ++k) {
        slot *x = k ? fresh : s;
        enter(x, INITIALIZATION);
        while (!good(BARE(x, fmi2EnterInitializationMode)))
            if (!starved) broken("initialization mode after a reset: %s", x->box.last);
    }
    compare(s, fresh, "after a reset");
    end(fresh);
}

static void step_twice(slot *s) {
    fmi2FMUstate state = NULL;
    double x[VARIABLES], y[VARIABLES];
    int sx[VARIABLES], sy[VARIABLES];
    const double h = chance(20) ? 0.0 : 0.1 * uniform();
    if (s->mode != STEP || !good(CALL(s, fmi2GetFMUstate, &state))) return;
    const int first = CALL(s, fmi2DoStep, s->time, h, fmi2False);
    const int excused = starved;
    read_all(s, x, sx, 1);
    set_real(s, 1);
    if (!good(CALL(s, fmi2SetFMUstate, state)) && !starved) broken("a state cannot be set: %s", s->box.last);
    if (!starved) {
        const int second = CALL(s, fmi2DoStep, s->time, h, fmi2False);
        read_all(s, y, sy, 0);
        for (int k = 0; k < VARIABLES && !starved && !excused; ++k)
            if (first != second || sx[k] != sy[k] || (good(sx[k]) && memcmp(&x[k], &y[k], sizeof(double)) != 0))
                broken("a repeated step: %s is %.17g, then %.17g", variables[k].name, x[k], y[k]);
        if (good(second)) s->time += h;
    }
    fmi2FreeFMUstate(s->c, &state);
}
