/* Values of an instance: lazy evaluation, getting and setting groups of variables, steps, the trained domain.
   Part of instance.h, included after it. */

/* ---- evaluation ---- */

static void tf_loads_of(const tf_instance *m, size_t i, double *out) {
    const size_t n = TF_N(m);
    for (int l = 0; l < TF_LOADS; ++l) out[l] = m->loads[(size_t)l * n + i];
}

static void tf_state_of(const tf_instance *m, size_t i, double *out) {
    out[0] = 0.0; /* a model without memory has no states, the array has one element still */
    for (int s = 0; s < TF_STATES; ++s) out[s] = m->state[(size_t)s * TF_N(m) + i];
}

/* Note the result of point i; return 0 when it is not a finite number (it stays stale, so every reading says so). */
static int tf_keep(tf_instance *m, size_t i, double mu) {
    const int good = tf_mu_rule(&mu);
    m->mu[i] = mu;
    m->fresh[i] = (unsigned char)good;
    return good;
}

static int tf_evaluate_point(tf_instance *m, size_t i) {
    double raw[TF_LOADS], loads[TF_LOADS], state[TF_AT_LEAST_ONE(TF_STATES)], mu;
    tf_loads_of(m, i, raw);
    tf_limited(raw, m->head.clamp, loads);
    tf_state_of(m, i, state);
    tf_model_mu(loads, state, m->head.system, &mu);
    return tf_keep(m, i, mu);
}

/* Evaluate `count` stale points together; the rest of a block repeats the last of them. */
static int tf_evaluate_block(tf_instance *m, const size_t *points, int count) {
    double L[TF_LOADS * TF_BLOCK], S[TF_AT_LEAST_ONE(TF_STATES) * TF_BLOCK], mu[TF_BLOCK];
    int good = 1;
    S[0] = 0.0;
    for (int b = 0; b < TF_BLOCK; ++b) {
        double raw[TF_LOADS], loads[TF_LOADS];
        const size_t i = points[b < count ? b : count - 1];
        tf_loads_of(m, i, raw);
        tf_limited(raw, m->head.clamp, loads);
        for (int l = 0; l < TF_LOADS; ++l) L[l * TF_BLOCK + b] = loads[l];
        for (int s = 0; s < TF_STATES; ++s) S[s * TF_BLOCK + b] = m->state[(size_t)s * TF_N(m) + i];
    }
    tf_model_mu_block(L, S, m->head.system, mu);
    for (int b = 0; b < count; ++b) good &= tf_keep(m, points[b], mu[b]);
    return good;
}

/* Bring mu of the points first ... first + count - 1 up to date; only those with a changed input are evaluated. */
static int tf_evaluate(tf_instance *m, size_t first, size_t count) {
    size_t points[TF_BLOCK];
    int waiting = 0, good = 1;
    for (size_t i = first; i < first + count; ++i) {
        if (m->fresh[i]) continue;
        points[waiting++] = i;
        if (waiting == TF_BLOCK) {
            good &= tf_evaluate_block(m, points, waiting);
            waiting = 0;
        }
    }
    if (waiting >= TF_BLOCK_LEAST) return good & tf_evaluate_block(m, points, waiting); /* fewer are quicker one by one */
    for (int k = 0; k < waiting; ++k) good &= tf_evaluate_point(m, points[k]);
    return good;
}

/* ---- domain and derivatives of the memory ---- */

static double tf_distance(const tf_instance *m, size_t i) {
    double loads[TF_LOADS];
    tf_loads_of(m, i, loads);
    return tf_loads_distance(loads, NULL);
}

/* Above 0 where a point in contact is outside the trained domain, below 0 elsewhere: continuous in the loads but
   for a small jump over 0, so that no search for its root ever meets a value that stays exactly 0 on the border. */
static double tf_indicator(const tf_instance *m) {
    double largest = -DBL_MAX;
    for (size_t i = 0; i < TF_N(m); ++i) {
        double loads[TF_LOADS], z = -DBL_MAX;
        tf_loads_of(m, i, loads);
        for (int l = 0; l < TF_LOADS; ++l) {
            const double d = tf_signed_distance(loads[l], l);
            if (d > z) z = d;
        }
        if (loads[TF_SIGMA_N] * 1e-3 < z) z = loads[TF_SIGMA_N] * 1e-3; /* no contact below 0 MPa */
        if (z > largest) largest = z;
    }
    return largest > 0.0 ? largest + 1e-9 : largest - 1e-9;
}

/* Whether every point in contact (with a contact pressure) is inside the trained domain. */
static int tf_in_domain(const tf_instance *m) {
    const size_t n = TF_N(m);
    for (size_t i = 0; i < n; ++i)
        if (m->loads[TF_SIGMA_N * n + i] > 0.0 && tf_distance(m, i) > 0.0) return 0;
    return 1;
}

static int tf_shown_in_domain(const tf_instance *m) {
    return m->head.mode == TF_CONTINUOUS ? m->head.latched_in_domain : tf_in_domain(m);
}

#if TF_ODE
/* Derivatives of the memory of point i, on the unclamped loads; 0 without contact. */
static int tf_rates(const tf_instance *m, size_t i, double *out) {
    double raw[TF_LOADS], loads[TF_LOADS], state[TF_STATES];
    tf_loads_of(m, i, raw);
    tf_limited(raw, 0, loads);
    tf_state_of(m, i, state);
    for (int s = 0; s < TF_STATES; ++s) out[s] = 0.0;
    if (!(loads[TF_SIGMA_N] > 0.0)) return 1;
    tf_model_der(loads, state, m->head.system, out);
    for (int s = 0; s < TF_STATES; ++s)
        if (!isfinite(out[s])) return tf_fail_value(m, "", TF_FIRST_DER + s, i, out[s]);
    return 1;
}
#endif
#if TF_INTERVAL

/* A bound of the prediction interval around a mu that is up to date, never below 0. The margin is that of the unclamped
   loads: it knows the trained domain, and grows outside of it. */
static int tf_bound(const tf_instance *m, int group, size_t i, double *out) {
    double raw[TF_LOADS], loads[TF_LOADS], state[TF_AT_LEAST_ONE(TF_STATES)], margin;
    tf_loads_of(m, i, raw);
    tf_limited(raw, 0, loads);
    tf_state_of(m, i, state);
    tf_model_margin(loads, state, m->head.system, &margin);
    *out = group == TF_LOW ? m->mu[i] - margin : m->mu[i] + margin;
    return tf_mu_rule(out) ? 1 : tf_fail_at(m, "", group, i, " is not a finite number at the given loads");
}
#endif /* TF_INTERVAL */

/* ---- getting and setting ---- */

/* Get `count` values of a group from point `first` on; system variables ignore the points. */
static int tf_get(tf_instance *m, int group, size_t first, size_t count, double *out) {
    const size_t n = TF_N(m);
    if (group < TF_LOADS) memcpy(out, m->loads + (size_t)group * n + first, count * sizeof *out);
    else if (group == TF_MU) {
        const int good = tf_evaluate(m, first, count);
        memcpy(out, m->mu + first, count * sizeof *out);
        for (size_t i = first; !good && i < first + count; ++i)
            if (!m->fresh[i]) return tf_fail_at(m, "", TF_MU, i, " is not a finite number at the given loads");
    } else if (group == TF_DISTANCE) {
        for (size_t i = 0; i < count; ++i) out[i] = tf_distance(m, first + i);
    } else if (group < TF_FIRST_SYSTEM) {
        memcpy(out, m->state + (size_t)(group - TF_FIRST_STATE) * n + first, count * sizeof *out);
    } else if (group < TF_FIRST_DER) {
        out[0] = m->head.system[group - TF_FIRST_SYSTEM];
    }
#if TF_INTERVAL
    else if (group >= TF_LOW) {
        if (!tf_get(m, TF_MU, first, count, out)) return 0;
        for (size_t i = 0; i < count; ++i)
            if (!tf_bound(m, group, first + i, out + i)) return 0;
    }
#endif /* TF_INTERVAL */
#if TF_ODE
    else {
        for (size_t i = 0; i < count; ++i) {
            double rates[TF_STATES];
            if (!tf_rates(m, first + i, rates)) return 0;
            out[i] = rates[group - TF_FIRST_DER];
        }
    }
#endif
    return 1;
}

/* Set `count` values of a group from point `first` on; nothing is set when one of them is refused. */
static int tf_set(tf_instance *m, int group, size_t first, size_t count, const double *values) {
    const int is_state = group >= TF_FIRST_STATE && group < TF_FIRST_SYSTEM;
    /* In model exchange the memory is a continuous state; some environments set it by value reference too. */
    const unsigned modes = is_state ? TF_BEFORE | TF_IN(TF_EVENT) | TF_IN(TF_CONTINUOUS) : TF_BEFORE | TF_RUNNING;
    double *place;
    if (group == TF_MU || group == TF_DISTANCE) return tf_fail_at(m, "", group, first, " is an output and cannot be set");
    if (group >= TF_FIRST_DER) return tf_fail_at(m, "", group, first, " is calculated and cannot be set");
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(values[i])) return tf_fail_value(m, "", group, first + i, values[i]);
    if (!(modes & TF_IN(m->head.mode))) {
        char name[TF_MESSAGE / 2], call[TF_MESSAGE];
        tf_name(m, name, group, first);
        snprintf(call, sizeof call, "setting %.200s%s", name, is_state ? " (memory of a point)" : "");
        return tf_allowed(m, call, modes);
    }
    if (group >= TF_FIRST_SYSTEM) {
        if (m->head.system[group - TF_FIRST_SYSTEM] != values[0]) tf_stale(m);
        m->head.system[group - TF_FIRST_SYSTEM] = values[0];
        return 1;
    }
    place = (is_state ? m->state + (size_t)(group - TF_FIRST_STATE) * TF_N(m) : m->loads + (size_t)group * TF_N(m)) + first;
    for (size_t i = 0; i < count; ++i) {
        if (place[i] != values[i]) m->fresh[first + i] = 0;
        place[i] = values[i];
    }
    return 1;
}

/* The continuous states in the order of the model description: state after state, each with all its points. */
static int tf_set_states(tf_instance *m, const double *x) {
    const size_t n = TF_N(m);
    (void)n; (void)x;
    for (int s = 0; s < TF_CONTINUOUS_STATES; ++s)
        if (!tf_set(m, TF_FIRST_STATE + s, 0, n, x + (size_t)s * n)) return 0;
    return 1;
}

/* Size that a state is expected to have; interface.py writes the same into the model description. */
static double tf_nominal(int s) { return tf_state_start[s] == 0.0 ? 1.0 : fabs(tf_state_start[s]); }

/* Their derivatives in the same order; one evaluation a point. */
static int tf_all_rates(const tf_instance *m, double *out) {
#if TF_ODE
    const size_t n = TF_N(m);
    for (size_t i = 0; i < n; ++i) {
        double rates[TF_STATES];
        if (!tf_rates(m, i, rates)) return 0;
        for (int s = 0; s < TF_STATES; ++s) out[(size_t)s * n + i] = rates[s];
    }
#else
    (void)m; (void)out;
#endif
    return 1;
}

static int tf_set_clamp(tf_instance *m, int clamp) {
    if (!tf_allowed(m, "setting clamp_to_domain", TF_BEFORE | TF_IN(TF_EVENT) | TF_IN(TF_STEP))) return 0;
    if (m->head.clamp != clamp) tf_stale(m);
    m->head.clamp = clamp;
    return 1;
}

/* ---- time ---- */

/* Make a communication step: the memory of every point in contact advances by h, on the unclamped loads.
   A step that fails at one point changes no point; a step of length zero, which some masters make, moves nothing. */
static int tf_step(tf_instance *m, double time, double h) {
    if (!tf_allowed(m, "a step", TF_IN(TF_STEP))) return 0;
    if (!isfinite(time) || !isfinite(h) || h < 0.0 || !isfinite(time + h))
        return tf_fail(m, "the communication step or its time is negative or not a finite number");
#if TF_STATES
    if (h > 0.0) {
        const size_t n = TF_N(m);
        memcpy(m->next, m->state, TF_STATES * n * sizeof(double));
        for (size_t i = 0; i < n; ++i) {
            double raw[TF_LOADS], loads[TF_LOADS], state[TF_STATES], next[TF_STATES];
            tf_loads_of(m, i, raw);
            tf_limited(raw, 0, loads);
            if (!(loads[TF_SIGMA_N] > 0.0)) continue; /* no contact: the point keeps its memory */
            tf_state_of(m, i, state);
            tf_model_step(loads, state, m->head.system, h, next);
            for (int s = 0; s < TF_STATES; ++s) {
                if (!isfinite(next[s])) return tf_fail_at(m, "", TF_FIRST_STATE + s, i, " is not a finite number after the step");
                m->next[(size_t)s * n + i] = next[s];
            }
        }
        for (size_t i = 0; i < n; ++i)
            for (int s = 0; s < TF_STATES; ++s)
                if (m->next[(size_t)s * n + i] != m->state[(size_t)s * n + i]) m->fresh[i] = 0;
        memcpy(m->state, m->next, TF_STATES * n * sizeof(double));
    }
#endif
    m->head.time = time + h;
    return 1;
}

static int tf_set_time(tf_instance *m, double time) {
    if (!tf_allowed(m, "setting the time", TF_IN(TF_CONTINUOUS) | TF_IN(TF_EVENT))) return 0;
    if (!isfinite(time)) return tf_fail(m, "time is not a finite number");
    m->head.time = time;
    return 1;
}
