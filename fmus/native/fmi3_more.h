/* Second part of fmi3.c: FMU state, dependencies, derivatives, steps, model exchange. */

/* ---- state of the whole FMU ---- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    INSTANCE(c);
    return STATUS(tf_save(m, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    INSTANCE(c);
    return STATUS(tf_restore(m, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    (void)c;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    INSTANCE(c);
    if (!state || !size) return STATUS(tf_fail(m, "the FMU state is empty"));
    *size = tf_byte_count(((tf_snapshot *)state)->n);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    INSTANCE(c);
    return STATUS(tf_serialize(m, state, (unsigned char *)bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    INSTANCE(c);
    return STATUS(tf_deserialize(m, (const unsigned char *)bytes, size, state));
}

/* ---- dependencies: an output of a point depends on the loads and the continuous states of that point, and on the
   parameters: in this order, mu on clamp_to_domain too ---- */

static size_t dependencies_a_point(fmi3ValueReference vr) {
    const int group = (int)vr - VR_FIRST;
    if (vr == VR_IN_DOMAIN || (vr == VR_INDICATOR && TF_INDICATORS)) return TF_LOADS;
    if (!is_group(vr)) return 0;
    if (group == TF_DISTANCE) return TF_LOADS;
    if (group == TF_MU) return TF_LOADS + TF_CONTINUOUS_STATES + TF_SYSTEM + 1;
#if TF_INTERVAL
    if (group >= TF_LOW) return TF_LOADS + TF_CONTINUOUS_STATES + TF_SYSTEM + 1;
#endif /* TF_INTERVAL */
    return group >= TF_FIRST_DER ? TF_LOADS + TF_CONTINUOUS_STATES + TF_SYSTEM : 0;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference vr, size_t *count) {
    INSTANCE(c);
    if (!dependencies_a_point(vr)) return STATUS(unknown(m, "calculated", vr));
    if (!count) return STATUS(tf_fail(m, "an array of the call is missing"));
    *count = dependencies_a_point(vr) * TF_N(m);
    return fmi3OK;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference vr, size_t dependents[], fmi3ValueReference independents[],
                                       size_t elements[], fmi3DependencyKind kinds[], size_t count) {
    INSTANCE(c);
    const size_t each = dependencies_a_point(vr);
    if (!each) return STATUS(unknown(m, "calculated", vr));
    if (count != each * TF_N(m)) return STATUS(tf_fail(m, "the number of dependencies is not the one that was told"));
    NEED(given(m, count, dependents, independents) && given(m, count, elements, kinds));
    for (size_t k = 0; k < count; ++k) {
        const size_t i = k / each, what = k % each;
        const int state = (int)what - TF_LOADS, parameter = state - TF_CONTINUOUS_STATES;
        const int own = parameter < 0; /* of this point */
        int first = parameter;         /* element of the array of system variables, which has one value reference */
        while (!own && parameter < TF_SYSTEM && !tf_system_length[first]) --first;
        dependents[k] = is_group(vr) ? i + 1 : 1; /* elements are numbered from 1 */
        independents[k] = (fmi3ValueReference)(state < 0               ? VR_FIRST + (int)what
                                               : own                   ? VR_FIRST + TF_FIRST_STATE + state
                                               : parameter < TF_SYSTEM ? VR_FIRST + TF_FIRST_SYSTEM + first
                                                                       : VR_CLAMP);
        elements[k] = own ? i + 1 : (size_t)(parameter - first) + 1;
        kinds[k] = fmi3Dependent;
    }
    return fmi3OK;
}

/* ---- derivatives ---- */

/* Whether the arrays of a derivative call fit, and all variables are Float64 variables of groups, or the output in_domain. */
static int derivative_call(const tf_instance *m, const fmi3ValueReference vr[], size_t n, const void *values, size_t count,
                           int outputs) {
    if (!given(m, n, vr, values)) return 0;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == VR_TIME) return tf_fail(m, "derivatives of time and with respect to it are not given");
        if (vr[k] == VR_INDICATOR && TF_INDICATORS) return tf_fail(m, "derivatives of domain_indicator are not given");
        if (!is_group(vr[k]) && !(outputs && vr[k] == VR_IN_DOMAIN)) return unknown(m, "differentiable", vr[k]);
    }
    return fits(m, vr, n, count);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    INSTANCE(c);
    double dP[TF_AT_LEAST_ONE(TF_SYSTEM)] = {0.0};
    size_t at = 0;
    int good;
    NEED(derivative_call(m, unknowns, nUnknowns, sensitivity, nSensitivity, 1) && derivative_call(m, knowns, nKnowns, seed, nSeed, 0));
    good = 1;
    for (size_t k = 0; good && k < nKnowns; ++k) {
        const int group = (int)knowns[k] - VR_FIRST;
        for (size_t i = 0; good && i < length_of(m, group); ++i)
            good = tf_add_seed(m, dP, GROUP_OF(group, i), POINT_OF(group, i), seed[at++]);
    }
    at = 0;
    for (size_t k = 0; good && k < nUnknowns; ++k) {
        const int group = (int)unknowns[k] - VR_FIRST;
        if (unknowns[k] == VR_IN_DOMAIN) sensitivity[at++] = 0.0; /* it jumps, and is constant in between */
        else
            for (size_t i = 0; good && i < length_of(m, group); ++i)
                good = tf_forward(m, dP, GROUP_OF(group, i), POINT_OF(group, i), sensitivity + at++);
    }
    memset(m->seed, 0, (TF_LOADS + TF_STATES) * TF_N(m) * sizeof(double));
    return STATUS(good);
}

static int is_output(const tf_instance *m, int group) {
    if (group == TF_MU || group == TF_DISTANCE || group >= TF_FIRST_DER) return 1;
    return tf_fail_at(m, "adjoint derivatives of ", group, 0, " are not given: it is no output");
}

/* Sum over the unknowns of their seeds times their derivative by one known of point i. */
static int adjoint_at(const tf_instance *m, const fmi3ValueReference unknowns[], size_t n, const fmi3Float64 seed[], int group,
                      size_t i, double *sum) {
    double dL[TF_LOADS] = {0.0}, dS[TF_AT_LEAST_ONE(TF_STATES)] = {0.0}, dP[TF_AT_LEAST_ONE(TF_SYSTEM)] = {0.0};
    size_t at = 0;
    if (group < TF_LOADS) dL[group] = 1.0;
    else if (group < TF_FIRST_SYSTEM) dS[group - TF_FIRST_STATE] = 1.0;
    else dP[group - TF_FIRST_SYSTEM] = 1.0;
    for (size_t k = 0; k < n; ++k) {
        const int wanted = (int)unknowns[k] - VR_FIRST;
        double weight;
        tf_tangent t;
        if (unknowns[k] == VR_IN_DOMAIN) { /* one value, whose derivatives are 0 */
            ++at;
            continue;
        }
        weight = seed[at + i];
        at += TF_N(m); /* every other unknown is an array over the points */
        if (weight == 0.0) continue;
        if (!isfinite(weight)) return tf_fail_value(m, "the seed of ", wanted, i, weight);
        if (!tf_differentiate(m, wanted, i, dL, dS, dP, &t)) return 0;
        *sum += weight * tf_tangent_of(&t, wanted);
    }
    return isfinite(*sum) ? 1 : tf_fail_at(m, "the adjoint derivative with respect to ", group, i, " is not a finite number");
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity) {
    INSTANCE(c);
    size_t at = 0;
    NEED(derivative_call(m, unknowns, nUnknowns, seed, nSeed, 1) && derivative_call(m, knowns, nKnowns, sensitivity, nSensitivity, 0));
    for (size_t k = 0; k < nUnknowns; ++k) NEED(unknowns[k] == VR_IN_DOMAIN || is_output(m, (int)unknowns[k] - VR_FIRST));
    for (size_t k = 0; k < nKnowns; ++k) {
        const int group = (int)knowns[k] - VR_FIRST;
        double unused[TF_AT_LEAST_ONE(TF_SYSTEM)];
        NEED(tf_seed_place(m, unused, group, 0) != NULL);
        if (!IS_SYSTEM(group)) {
            for (size_t i = 0; i < TF_N(m); ++i, ++at) {
                double sum = 0.0;
                NEED(adjoint_at(m, unknowns, nUnknowns, seed, group, i, &sum));
                sensitivity[at] = sum;
            }
        } else { /* a system variable acts on all points */
            for (size_t e = 0; e < length_of(m, group); ++e, ++at) {
                double sum = 0.0;
                for (size_t i = 0; i < TF_N(m); ++i)
                    NEED(adjoint_at(m, unknowns, nUnknowns, seed, GROUP_OF(group, e), i, &sum));
                sensitivity[at] = sum;
            }
        }
    }
    return fmi3OK;
}

/* ---- co-simulation ---- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 h, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn,
                      fmi3Float64 *lastSuccessfulTime) {
    INSTANCE(c);
    const int good = tf_step(m, time, h);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (eventHandlingNeeded) *eventHandlingNeeded = fmi3False;
    if (terminateSimulation) *terminateSimulation = fmi3False;
    if (earlyReturn) *earlyReturn = fmi3False;
    if (lastSuccessfulTime) *lastSuccessfulTime = m->head.time;
    return STATUS(good);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    INSTANCE(c);
    return STATUS(tf_fail(m, "fmi3EnterStepMode is for co-simulation with event mode, which is not offered (hasEventMode is false)"));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t count) {
    INSTANCE(c);
    (void)vr; (void)orders; (void)values; (void)count;
    return STATUS(n == 0 || tf_fail(m, "output derivatives are not offered (maxOutputDerivativeOrder is 0)"));
}

/* ---- model exchange: the memory is the continuous state, in_domain is the only discrete variable ---- */

#define SIZE(n, expected, what) \
    if ((n) != (size_t)(expected)) return STATUS(tf_fail(m, "the number of " what " is not the one of the model description"))

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3EnterEventMode", TF_IN(TF_CONTINUOUS) | TF_IN(TF_EVENT)));
    m->head.mode = TF_EVENT;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needUpdate, fmi3Boolean *terminate, fmi3Boolean *nominalsChanged,
                                    fmi3Boolean *valuesChanged, fmi3Boolean *nextTimeDefined, fmi3Float64 *nextTime) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3UpdateDiscreteStates", TF_IN(TF_EVENT)));
    /* nothing changes by itself, no time event, no end */
    if (needUpdate) *needUpdate = fmi3False;
    if (terminate) *terminate = fmi3False;
    if (nominalsChanged) *nominalsChanged = fmi3False;
    if (valuesChanged) *valuesChanged = fmi3False;
    if (nextTimeDefined) *nextTimeDefined = fmi3False;
    if (nextTime) *nextTime = 0.0;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    INSTANCE(c);
    return STATUS(tf_allowed(m, "fmi3EvaluateDiscreteStates", TF_IN(TF_EVENT) | TF_IN(TF_INITIALIZATION)));
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3EnterContinuousTimeMode", TF_IN(TF_EVENT)));
    m->head.latched_in_domain = tf_in_domain(m);
    m->head.mode = TF_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
                                       fmi3Boolean *terminateSimulation) {
    INSTANCE(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    NEED(tf_allowed(m, "fmi3CompletedIntegratorStep", TF_IN(TF_CONTINUOUS)));
    /* The event indicator finds the place where in_domain changes; this is for environments that passed over it. */
    if (enterEventMode) *enterEventMode = m->head.latched_in_domain != tf_in_domain(m);
    if (terminateSimulation) *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    INSTANCE(c);
    return STATUS(tf_set_time(m, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3SetContinuousStates", TF_IN(TF_CONTINUOUS)));
    SIZE(n, TF_CONTINUOUS_STATES * TF_N(m), "continuous states");
    return STATUS(given(m, n, x, x) && tf_set_states(m, x));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_N(m), "continuous states");
    NEED(given(m, n, x, x));
    if (n) memcpy(x, m->state, n * sizeof *x);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_N(m), "continuous states");
    return STATUS(given(m, n, derivatives, derivatives) && tf_all_rates(m, derivatives));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_CONTINUOUS_STATES * TF_N(m), "continuous states");
    NEED(given(m, n, nominals, nominals));
    for (size_t k = 0; k < n; ++k) nominals[k] = tf_nominal((int)(k / TF_N(m)));
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 indicators[], size_t n) {
    INSTANCE(c);
    SIZE(n, TF_INDICATORS, "event indicators");
    NEED(given(m, n, indicators, indicators));
    if (n) indicators[0] = tf_indicator(m);
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
    INSTANCE(c);
    if (n) *n = TF_INDICATORS;
    return STATUS(n || tf_fail(m, "there is no place for the number"));
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
    INSTANCE(c);
    if (n) *n = TF_CONTINUOUS_STATES * TF_N(m);
    return STATUS(n || tf_fail(m, "there is no place for the number"));
}
