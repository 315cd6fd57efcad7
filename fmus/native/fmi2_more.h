/* Second part of fmi2.c: FMU state, derivatives, co-simulation steps, model exchange. */

/* ---- state of the whole FMU ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    INSTANCE(c);
    return STATUS(tf_save(m, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    INSTANCE(c);
    return STATUS(tf_restore(m, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    INSTANCE(c);
    if (!state || !size) return STATUS(tf_fail(m, "the FMU state is empty"));
    *size = tf_byte_count(((tf_snapshot *)state)->n);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    INSTANCE(c);
    return STATUS(tf_serialize(m, state, (unsigned char *)bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    INSTANCE(c);
    return STATUS(tf_deserialize(m, (const unsigned char *)bytes, size, state));
}

/* ---- directional derivative ---- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n,
                                        const fmi2ValueReference knowns[], size_t nKnown, const fmi2Real seed[],
                                        fmi2Real result[]) {
    INSTANCE(c);
    double dP[TF_AT_LEAST_ONE(TF_SYSTEM)] = {0.0};
    int good = given(m, n, unknowns, result) && given(m, nKnown, knowns, seed), group = 0;
    size_t point = 0, seeded = 0;
    if (n == 0) return STATUS(good); /* nothing is asked for, so no seed can be wrong */
    for (; good && seeded < nKnown; seeded += (size_t)good)
        good = place_of(m, knowns[seeded], &group, &point) && tf_add_seed(m, dP, group, point, seed[seeded]);
    for (size_t k = 0; good && k < n; ++k) {
        if (unknowns[k] == IN_DOMAIN) result[k] = 0.0; /* it jumps, and is constant in between */
        else good = place_of(m, unknowns[k], &group, &point) && tf_forward(m, dP, group, point, result + k);
    }
    for (size_t k = 0; k < seeded; ++k) /* only what was accepted above: these calls cannot fail */
        if (place_of(m, knowns[k], &group, &point)) *tf_seed_place(m, dP, group, point) = 0.0;
    return STATUS(good);
}

/* ---- co-simulation ---- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    INSTANCE(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    return STATUS(tf_step(m, time, h));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    INSTANCE(c);
    (void)vr; (void)order; (void)value;
    return STATUS(n == 0 || tf_fail(m, "input derivatives are not used (canInterpolateInputs is false)"));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    INSTANCE(c);
    (void)vr; (void)order; (void)value;
    return STATUS(n == 0 || tf_fail(m, "output derivatives are not offered"));
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    INSTANCE(c);
    return STATUS(tf_fail(m, "no step runs in the background"));
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    INSTANCE(c);
    if (kind != fmi2DoStepStatus || !value) return fmi2Discard;
    *value = fmi2OK; /* a step is finished when fmi2DoStep returns */
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    INSTANCE(c);
    if (kind != fmi2LastSuccessfulTime || !value) return fmi2Discard;
    *value = m->head.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    INSTANCE(c);
    (void)kind; (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    INSTANCE(c);
    if (kind != fmi2Terminated || !value) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    INSTANCE(c);
    (void)kind; (void)value;
    return fmi2Discard;
}

/* ---- model exchange: the memory is the continuous state, in_domain is the only discrete variable ---- */

#define SIZE(n, expected, what) \
    if ((n) != (size_t)(expected)) return STATUS(tf_fail(m, "the number of " what " is not the one of the model description"))

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2EnterEventMode", TF_IN(TF_CONTINUOUS) | TF_IN(TF_EVENT)));
    m->head.mode = TF_EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2NewDiscreteStates", TF_IN(TF_EVENT)));
    if (info) memset(info, 0, sizeof *info); /* nothing changes by itself, no time event, no end */
    return STATUS(info || tf_fail(m, "there is no place for the event information"));
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2EnterContinuousTimeMode", TF_IN(TF_EVENT)));
    m->head.latched_in_domain = tf_in_domain(m);
    m->head.mode = TF_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation) {
    INSTANCE(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    NEED(tf_allowed(m, "fmi2CompletedIntegratorStep", TF_IN(TF_CONTINUOUS)));
    /* The event indicator finds the place where in_domain changes; this is for environments that passed over it. */
    if (enterEventMode) *enterEventMode = m->head.latched_in_domain != tf_in_domain(m);
    if (terminateSimulation) *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    INSTANCE(c);
    return STATUS(tf_set_time(m, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2SetContinuousStates", TF_IN(TF_CONTINUOUS)));
    SIZE(n, TF_CONTINUOUS_STATES * TF_NODES, "continuous states");
    return STATUS(given(m, n, x, x) && tf_set_states(m, x));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_NODES, "continuous states");
    return STATUS(given(m, n, derivatives, derivatives) && tf_all_rates(m, derivatives));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_INDICATORS, "event indicators");
    NEED(given(m, n, indicators, indicators));
    if (n) indicators[0] = tf_indicator(m);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_NODES, "continuous states");
    NEED(given(m, n, x, x));
    if (n) memcpy(x, m->state, n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_NODES, "continuous states");
    NEED(given(m, n, nominals, nominals));
    for (size_t k = 0; k < n; ++k) nominals[k] = tf_nominal((int)(k / TF_NODES));
    return fmi2OK;
}
