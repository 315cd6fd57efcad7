/* Third part of fuzz_fmi3.c: the same inputs give the same values, in a copy, after a reset, in a repeated step. */

/* Everything that can be read, variable by variable; where one fails, that. */
static double *read_all(slot *s, int *status, int together) {
    double *value = (double *)exactly(VARIABLES * s->n, sizeof *value), *at = value;
    for (int k = 0; k < VARIABLES; ++k, at += s->n) {
        const int real = variables[k].type == REAL;
        memset(at, 0, s->n * sizeof *at);
        status[k] = real ? (int)fmi3GetFloat64(s->c, &variables[k].vr, 1, at, length(s, &variables[k])) : OK;
        if (!good(status[k])) memset(at, 0, s->n * sizeof *at);
        for (size_t i = 0; real && good(status[k]) && i < length(s, &variables[k]); ++i) check_value(&variables[k], at[i]);
    }
    if (!together) return value;
    fmi3ValueReference vr[VARIABLES];
    size_t n = 0, count = 0;
    double *block = (double *)exactly(VARIABLES * s->n, sizeof *block);
    for (int k = 0; k < VARIABLES; ++k)
        if (variables[k].type == REAL && good(status[k])) vr[n++] = variables[k].vr, count += length(s, &variables[k]);
    if (!good((int)fmi3GetFloat64(s->c, vr, n, block, count))) broken("values that can be read alone cannot be read together");
    for (int k = 0, from = 0; k < VARIABLES; ++k) {
        const size_t here = length(s, &variables[k]);
        if (variables[k].type != REAL || !good(status[k])) continue;
        if (memcmp(block + from, value + (size_t)k * s->n, here * sizeof *block) != 0) broken("%s alone is not what it is together", variables[k].name);
        from += (int)here;
    }
    free(block);
    return value;
}

static void compare(slot *a, slot *b, const char *what) {
    int sx[VARIABLES], sy[VARIABLES];
    if (a->n != b->n) broken("%s: %zu and %zu points", what, a->n, b->n);
    double *x = read_all(a, sx, chance(50)), *y = read_all(b, sy, chance(50));
    if (SPOILT("stale")) y[a->n] += 1e-9;
    for (int k = 0; k < VARIABLES; ++k)
        for (size_t i = 0; i < a->n; ++i)
            if (sx[k] != sy[k] || memcmp(x + (size_t)k * a->n + i, y + (size_t)k * a->n + i, sizeof *x) != 0)
                broken("%s: %s at point %zu is %.17g (status %d), and %.17g (status %d)", what, variables[k].name, i + 1,
                       x[(size_t)k * a->n + i], sx[k], y[(size_t)k * a->n + i], sy[k]);
    free(x);
    free(y);
}

static size_t to_bytes(slot *s, fmi3FMUState state, fmi3Byte **bytes) {
    size_t size = 0;
    *bytes = NULL;
    if (!good(CALL(s, fmi3SerializedFMUStateSize, state, &size))) return 0;
    if (size > 100000000u) broken("a serialized state of %zu bytes", size);
    *bytes = (fmi3Byte *)exactly(size + 1, 1); /* one more: handed over at an odd address */
    if (good(CALL(s, fmi3SerializeFMUState, state, *bytes + 1, size))) return size;
    if (!starved) broken("a state cannot be serialized");
    free(*bytes);
    *bytes = NULL;
    return 0;
}

static void copy_and_compare(slot *s) {
    slot *copy = &slots[INSTANCES];
    fmi3FMUState state = NULL, read = NULL;
    fmi3Byte *bytes = NULL;
    begin(copy, s->exchange, 1);
    if (good(CALL(s, fmi3GetFMUState, &state))) {
        const size_t size = to_bytes(s, state, &bytes);
        if (size && good(CALL(copy, fmi3DeserializeFMUState, bytes + 1, size, &read)) && good(CALL(copy, fmi3SetFMUState, read))) {
            copy->n = s->n;
            compare(s, copy, "a copy through bytes");
        }
        else if (size && !starved) broken("a state is not accepted by another instance: %s", copy->box.last);
    }
    free(bytes);
    fmi3FreeFMUState(s->c, &state);
    fmi3FreeFMUState(copy->c, &read);
    end(copy);
}

static void reset_and_compare(slot *s) {
    slot *fresh = &slots[INSTANCES];
    begin(fresh, s->exchange, 1);
    expect(s, BARE(s, fmi3Reset), MUST_SUCCEED, "reset");
    s->n = FUZZ_N;
    enter(s, INSTANTIATED);
    while (!good(initialize(s, 0.0)))
        if (!starved) broken("initialization mode after a reset: %s", s->box.last);
    while (!good(initialize(fresh, 0.0)))
        if (!starved) broken("initialization mode: %s", fresh->box.last);
    compare(s, fresh, "after a reset");
    end(fresh);
}

static int do_step(slot *s, double time, double h) {
    fmi3Boolean flags[3];
    fmi3Float64 last = NAN;
    memset(flags, 7, sizeof flags);
    const int status = CALL(s, fmi3DoStep, time, h, chance(50), &flags[0], &flags[1], &flags[2], &last);
    unsigned char bytes[3];
    memcpy(bytes, flags, 3);
    if (good(status) && (bytes[0] > 1 || bytes[1] > 1 || bytes[2] > 1 || !isfinite(last))) broken("results of a step are not filled in");
    return status;
}

static void step_twice(slot *s) {
    fmi3FMUState state = NULL;
    int sx[VARIABLES], sy[VARIABLES];
    const double h = chance(20) ? 0.0 : 0.1 * uniform();
    if (s->mode != STEP || !good(CALL(s, fmi3GetFMUState, &state))) return;
    const int first = do_step(s, s->time, h), excused = starved;
    double *x = read_all(s, sx, 1);
    set_floats(s, 1);
    if (!good(CALL(s, fmi3SetFMUState, state)) && !starved) broken("a state cannot be set: %s", s->box.last);
    if (!starved) {
        const int second = do_step(s, s->time, h);
        double *y = read_all(s, sy, 0);
        if (!starved && !excused && (first != second || memcmp(sx, sy, sizeof sx) != 0 || memcmp(x, y, VARIABLES * s->n * sizeof *x) != 0))
            broken("a repeated step gives other values");
        if (good(second)) s->time += h;
        free(y);
    }
    free(x);
    fmi3FreeFMUState(s->c, &state);
}
