/* Second part of fmi2.c: FMU state, derivatives, co-simulation steps, model exchange. */

/* ---- state of the whole FMU ---- */

static const char serial_mark[] = "tribofmu 1 " TF_GUID;

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    tf_instance *m = (tf_instance *)c;
    if (!*state) *state = malloc(sizeof(tf_data));
    if (!*state) return fail(m, "out of memory");
    memcpy(*state, &m->data, sizeof(tf_data));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    tf_instance *m = (tf_instance *)c;
    if (!state) return fail(m, "the FMU state to be set is empty");
    memcpy(&m->data, state, sizeof(tf_data));
    tf_stale(m);
    return fmi2OK;
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
    (void)c; (void)state;
    *size = sizeof serial_mark + sizeof(tf_data);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (!state || size != sizeof serial_mark + sizeof(tf_data))
        return fail((tf_instance *)c, "the buffer for the FMU state has the wrong size");
    memcpy(bytes, serial_mark, sizeof serial_mark);
    memcpy(bytes + sizeof serial_mark, state, sizeof(tf_data));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    tf_instance *m = (tf_instance *)c;
    if (size != sizeof serial_mark + sizeof(tf_data) || memcmp(bytes, serial_mark, sizeof serial_mark) != 0)
        return fail(m, "the serialized state does not belong to this FMU");
    if (!*state) *state = malloc(sizeof(tf_data));
    if (!*state) return fail(m, "out of memory");
    memcpy(*state, bytes + sizeof serial_mark, sizeof(tf_data));
    return fmi2OK;
}

/* ---- directional derivative: d(mu, domain_distance) along d(loads, system variables) ---- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n,
                                        const fmi2ValueReference knowns[], size_t nKnown, const fmi2Real seed[],
                                        fmi2Real result[]) {
    tf_instance *m = (tf_instance *)c;
    const unsigned first_system = (TF_FIRST_STATE + TF_STATES) * TF_NODES;
    double *dL = (double *)calloc(TF_NODES * TF_LOADS, sizeof(double));
    double dP[TF_AT_LEAST_ONE(TF_SYSTEM)] = {0.0}, dS[TF_AT_LEAST_ONE(TF_STATES)] = {0.0};
    fmi2Status status = fmi2OK;
    if (!dL) return fail(m, "out of memory");
    for (size_t k = 0; k < nKnown && status == fmi2OK; ++k) {
        const unsigned group = knowns[k] / TF_NODES, node = knowns[k] % TF_NODES;
        if (group < TF_LOADS) dL[node * TF_LOADS + group] += seed[k];
        else if (knowns[k] >= first_system && knowns[k] < first_system + TF_SYSTEM) dP[knowns[k] - first_system] += seed[k];
        else status = fail(m, "derivatives are given with respect to loads and system variables only");
    }
    for (size_t k = 0; k < n && status == fmi2OK; ++k) {
        const unsigned group = unknowns[k] / TF_NODES, node = unknowns[k] % TF_NODES;
        const double *x = m->data.loads + node * TF_LOADS;
        if (group == TF_DISTANCE) {
            int l = -1;
            result[k] = 0.0;
            if (tf_distance(m, (int)node, &l) > 0.0) {
                result[k] = (x[l] > tf_domain_upper[l] ? 1.0 : -1.0) * dL[node * TF_LOADS + l] / tf_domain_scale[l];
            }
        } else if (group == TF_MU) {
            double loads[TF_LOADS], direction[TF_LOADS], mu, dmu;
            tf_loads_of(m, (int)node, m->data.clamp, loads);
            for (int l = 0; l < TF_LOADS; ++l) /* a clamped load does not move */
                direction[l] = loads[l] == x[l] ? dL[node * TF_LOADS + l] : 0.0;
            tf_model_mu_d(loads, m->data.state + node * TF_STATES, m->data.system, direction, dS, dP, &mu, &dmu);
            result[k] = mu > 0.0 ? dmu : 0.0;
            if (!isfinite(result[k])) status = fail(m, "the derivative of mu is not a finite number");
        } else {
            status = fail(m, "derivatives are given of mu and domain_distance only");
        }
    }
    free(dL);
    return status;
}

/* ---- co-simulation ---- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    tf_instance *m = (tf_instance *)c;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (m->data.mode != STEP) return wrong_mode(m, "fmi2DoStep");
    if (!isfinite(time) || !isfinite(h) || h < 0.0) return fail(m, "the communication step is negative or not a finite number");
    if (h > 0.0) { /* a step of length zero, which some masters make, moves nothing */
        const int bad = tf_advance(m, h);
        if (bad) {
            char text[TF_MESSAGE];
            snprintf(text, sizeof text, "%s of point %d is not a finite number after the step",
                     tf_state_names[(bad - 1) % TF_AT_LEAST_ONE(TF_STATES)], (bad - 1) / TF_AT_LEAST_ONE(TF_STATES) + 1);
            return fail(m, text);
        }
    }
    m->data.time = time + h;
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr; (void)order; (void)value;
    return n ? fail((tf_instance *)c, "input derivatives are not used (canInterpolateInputs is false)") : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    (void)vr; (void)order; (void)value;
    return n ? fail((tf_instance *)c, "output derivatives are not offered") : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) { return fail((tf_instance *)c, "no step runs in the background"); }

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c; (void)kind;
    *value = fmi2OK;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((tf_instance *)c)->data.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

/* ---- model exchange: a model without memory has no states and no event indicators ---- */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    ((tf_instance *)c)->data.mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    tf_instance *m = (tf_instance *)c;
    m->data.latched_in_domain = tf_in_domain(m);
    memset(info, 0, sizeof *info);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    tf_instance *m = (tf_instance *)c;
    if (m->data.mode != EVENT) return wrong_mode(m, "fmi2EnterContinuousTimeMode");
    m->data.latched_in_domain = tf_in_domain(m);
    m->data.mode = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation) {
    tf_instance *m = (tf_instance *)c;
    (void)noSetFMUStatePriorToCurrentPoint;
    *enterEventMode = m->data.latched_in_domain != tf_in_domain(m); /* so that in_domain changes at an event */
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    tf_instance *m = (tf_instance *)c;
    if (!isfinite(time)) return fail(m, "time is not a finite number");
    m->data.time = time;
    return fmi2OK;
}

#define NO_STATES(m, n, what) ((n) == 0 ? fmi2OK : fail((tf_instance *)(m), what))

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    (void)x;
    return NO_STATES(c, n, "the model has no continuous states");
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    (void)derivatives;
    return NO_STATES(c, n, "the model has no continuous states");
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    (void)indicators;
    return NO_STATES(c, n, "the model has no event indicators");
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)x;
    return NO_STATES(c, n, "the model has no continuous states");
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    (void)nominals;
    return NO_STATES(c, n, "the model has no continuous states");
}
