/* Directional derivatives of mu, domain_distance and the derivatives of the memory, along loads, memory and system
   variables. Included after values.h. A clamped load does not move; mu does not move where it is held at 0. */

typedef struct { /* derivatives of the outputs of one point */
    double mu, distance, rates[TF_AT_LEAST_ONE(TF_STATES)];
#if TF_INTERVAL
    double bound;
#endif /* TF_INTERVAL */
} tf_tangent;
#if TF_INTERVAL

static int tf_differentiate(const tf_instance *m, int group, size_t i, const double *dL, const double *dS,
                            const double *dP, tf_tangent *out);

/* The same for TF_LOW and TF_HIGH; a bound does not move where it is held at 0. */
static int tf_differentiate_bound(const tf_instance *m, int group, size_t i, const double *dL, const double *dS,
                                  const double *dP, tf_tangent *out) {
    double raw[TF_LOADS], loads[TF_LOADS], direction[TF_LOADS], state[TF_AT_LEAST_ONE(TF_STATES)];
    double mu, margin, slope;
    if (!tf_differentiate(m, TF_MU, i, dL, dS, dP, out)) return 0;
    tf_loads_of(m, i, raw);
    tf_state_of(m, i, state);
    tf_limited(raw, m->head.clamp, loads);
    tf_model_mu(loads, state, m->head.system, &mu);
    (void)tf_mu_rule(&mu);
    tf_limited(raw, 0, loads);
    for (int l = 0; l < TF_LOADS; ++l) direction[l] = loads[l] == raw[l] ? dL[l] : 0.0;
    tf_model_margin_d(loads, state, m->head.system, direction, dS, dP, &margin, &slope);
    out->bound = group == TF_HIGH ? out->mu + slope : mu > margin ? out->mu - slope : 0.0;
    return isfinite(out->bound) ? 1 : tf_fail_at(m, "the derivative of ", group, i, " is not a finite number");
}
#endif /* TF_INTERVAL */

/* Differentiate what `group` names at point i (TF_MU, TF_DISTANCE or a derivative group); the rest stays 0. */
static int tf_differentiate(const tf_instance *m, int group, size_t i, const double *dL, const double *dS,
                            const double *dP, tf_tangent *out) {
    double raw[TF_LOADS], loads[TF_LOADS], direction[TF_LOADS], state[TF_AT_LEAST_ONE(TF_STATES)];
    double value[TF_AT_LEAST_ONE(TF_STATES)], result = 0.0;
    memset(out, 0, sizeof *out);
#if TF_INTERVAL
    if (group >= TF_LOW) return tf_differentiate_bound(m, group, i, dL, dS, dP, out);
#endif /* TF_INTERVAL */
    tf_loads_of(m, i, raw);
    tf_state_of(m, i, state);
    if (group == TF_DISTANCE) {
        int l = -1;
        if (tf_loads_distance(raw, &l) > 0.0) result = (raw[l] > tf_domain_upper[l] ? 1.0 : -1.0) * dL[l] / tf_domain_scale[l];
        out->distance = result;
    } else {
        tf_limited(raw, group == TF_MU && m->head.clamp, loads);
        for (int l = 0; l < TF_LOADS; ++l) direction[l] = loads[l] == raw[l] ? dL[l] : 0.0;
        if (group == TF_MU) {
            tf_model_mu_d(loads, state, m->head.system, direction, dS, dP, value, &result);
            if (!(value[0] > 0.0)) result = 0.0;
            out->mu = result;
        }
#if TF_ODE
        else if (loads[TF_SIGMA_N] > 0.0) {
            tf_model_der_d(loads, state, m->head.system, direction, dS, dP, value, out->rates);
            result = out->rates[group - TF_FIRST_DER];
        }
#endif
    }
    return isfinite(result) ? 1 : tf_fail_at(m, "the derivative of ", group, i, " is not a finite number");
}

static double tf_tangent_of(const tf_tangent *t, int group) {
#if TF_INTERVAL
    if (group >= TF_LOW) return t->bound;
#endif /* TF_INTERVAL */
    return group == TF_MU ? t->mu : group == TF_DISTANCE ? t->distance : t->rates[group - TF_FIRST_DER];
}

/* Where the direction of a known variable is collected. */
static double *tf_seed_place(tf_instance *m, double *dP, int group, size_t i) {
    const size_t n = TF_N(m);
    if (group < TF_LOADS) return m->seed + (size_t)group * n + i;
    if (group >= TF_FIRST_STATE && group < TF_FIRST_SYSTEM) return m->seed + (size_t)(TF_LOADS + group - TF_FIRST_STATE) * n + i;
    if (group >= TF_FIRST_SYSTEM && group < TF_FIRST_DER) return dP + (group - TF_FIRST_SYSTEM);
    tf_fail_at(m, "derivatives are not given with respect to ", group, i, ": it is calculated");
    return NULL;
}

static int tf_add_seed(tf_instance *m, double *dP, int group, size_t i, double value) {
    double *place = tf_seed_place(m, dP, group, i);
    if (!place) return 0;
    if (!isfinite(*place + value)) return tf_fail_value(m, "the seed of ", group, i, *place + value);
    *place += value;
    return 1;
}

/* Derivative of one output along the collected direction. What is no output follows its own direction: some
   environments ask for more than the model description offers, and this answer is the right one. */
static int tf_forward(const tf_instance *m, const double *dP, int group, size_t i, double *out) {
    double dL[TF_LOADS], dS[TF_AT_LEAST_ONE(TF_STATES)] = {0.0};
    const size_t n = TF_N(m);
    tf_tangent t;
    if (group < TF_LOADS) *out = m->seed[(size_t)group * n + i];
    else if (group >= TF_FIRST_STATE && group < TF_FIRST_SYSTEM) *out = m->seed[(size_t)(TF_LOADS + group - TF_FIRST_STATE) * n + i];
    else if (group >= TF_FIRST_SYSTEM && group < TF_FIRST_DER) *out = dP[group - TF_FIRST_SYSTEM];
    else {
        for (int l = 0; l < TF_LOADS; ++l) dL[l] = m->seed[(size_t)l * n + i];
        for (int s = 0; s < TF_STATES; ++s) dS[s] = m->seed[(size_t)(TF_LOADS + s) * n + i];
        if (!tf_differentiate(m, group, i, dL, dS, dP, &t)) return 0;
        *out = tf_tangent_of(&t, group);
    }
    return 1;
}
