/* One instance of a friction FMU: its values, lazy evaluation, messages. Independent of the FMI version.
   Included after model.h; everything is static, there is no global state, instances are independent. */

#define TF_LOADS 5
#define TF_SIGMA_N 2
#define TF_AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1)
#define TF_MESSAGE 512

typedef struct {
    double time;
    double loads[TF_NODES * TF_LOADS]; /* point by point */
    double state[TF_AT_LEAST_ONE(TF_NODES * TF_STATES)];
    double system[TF_AT_LEAST_ONE(TF_SYSTEM)];
    int clamp;
    int latched_in_domain; /* what model exchange shows between events */
    int mode;
} tf_data;

typedef struct {
    tf_data data; /* all that getting and setting the FMU state moves */
    double mu[TF_NODES];
    unsigned char fresh[TF_NODES]; /* mu[i] belongs to the present inputs */
    int model_exchange;
    char *name;
    void *logger, *environment;
} tf_instance;

/* Groups of Real value references: five loads, mu, domain_distance, states, each TF_NODES long; then the system. */
enum { TF_MU = TF_LOADS, TF_DISTANCE, TF_FIRST_STATE };

static void tf_stale(tf_instance *m) { memset(m->fresh, 0, sizeof m->fresh); }

static void tf_reset(tf_instance *m) {
    memset(&m->data, 0, sizeof m->data);
    for (int i = 0; i < TF_NODES; ++i) {
        for (int l = 0; l < TF_LOADS; ++l) m->data.loads[i * TF_LOADS + l] = tf_load_start[l];
        for (int s = 0; s < TF_STATES; ++s) m->data.state[i * TF_STATES + s] = tf_state_start[s];
    }
    for (int p = 0; p < TF_SYSTEM; ++p) m->data.system[p] = tf_system_start[p];
    m->data.clamp = 1;
    m->data.latched_in_domain = 1;
    tf_stale(m);
}

/* Write the name of a Real variable into text. */
static void tf_name(char *text, size_t size, unsigned vr) {
    const unsigned group = vr / TF_NODES, node = vr % TF_NODES;
    const unsigned first_system = (TF_FIRST_STATE + TF_STATES) * TF_NODES;
    if (vr >= first_system + TF_SYSTEM) {
        snprintf(text, size, "value reference %u", vr);
        return;
    }
    if (vr >= first_system) {
        snprintf(text, size, "%s", tf_system_names[vr - first_system]);
        return;
    }
    const char *name = group < TF_LOADS         ? tf_load_names[group]
                       : group == TF_MU         ? "mu"
                       : group == TF_DISTANCE   ? "domain_distance"
                                                : tf_state_names[group - TF_FIRST_STATE];
    if (TF_NODES == 1) snprintf(text, size, "%s", name);
    else snprintf(text, size, "%s[%u]", name, node + 1);
}

static double tf_limit(double x, double lower, double upper) { return x < lower ? lower : x > upper ? upper : x; }

/* The loads of point i inside the physical limits, and inside the trained domain when `domain` is set. */
static void tf_loads_of(const tf_instance *m, int i, int domain, double *out) {
    for (int l = 0; l < TF_LOADS; ++l) {
        double x = tf_limit(m->data.loads[i * TF_LOADS + l], tf_load_lower[l], tf_load_upper[l]);
        out[l] = domain ? tf_limit(x, tf_domain_lower[l], tf_domain_upper[l]) : x;
    }
}

/* Exceedance of one load in units of the width of its trained range. */
static double tf_exceedance(const tf_instance *m, int i, int l) {
#if TF_HAS_DOMAIN
    const double x = m->data.loads[i * TF_LOADS + l], lower = tf_domain_lower[l], upper = tf_domain_upper[l];
    const double outside = x < lower ? lower - x : x > upper ? x - upper : 0.0;
    return outside == 0.0 ? 0.0 : outside / tf_domain_scale[l];
#else
    (void)m; (void)i; (void)l;
    return 0.0;
#endif
}

static double tf_distance(const tf_instance *m, int i, int *load) {
    double largest = 0.0;
    for (int l = 0; l < TF_LOADS; ++l) {
        const double e = tf_exceedance(m, i, l);
        if (e > largest) {
            largest = e;
            if (load) *load = l;
        }
    }
    return largest;
}

/* Whether every point in contact (with a contact pressure) is inside the trained domain. */
static int tf_in_domain(const tf_instance *m) {
    for (int i = 0; i < TF_NODES; ++i)
        if (m->data.loads[i * TF_LOADS + TF_SIGMA_N] > 0.0 && tf_distance(m, i, NULL) > 0.0) return 0;
    return 1;
}

/* Evaluate mu of point i if an input changed; return 0 when the result is not a number. */
static int tf_evaluate(tf_instance *m, int i) {
    if (m->fresh[i]) return 1;
    double loads[TF_LOADS], mu;
    tf_loads_of(m, i, m->data.clamp, loads);
    tf_model_mu(loads, m->data.state + i * TF_STATES, m->data.system, &mu);
    if (!isfinite(mu)) {
        m->mu[i] = 0.0;
        return 0;
    }
    m->mu[i] = mu > 0.0 ? mu : 0.0;
    m->fresh[i] = 1;
    return 1;
}

/* Advance the memory of every point in contact by h, on the unclamped loads; return the failing state + 1, or 0. */
static int tf_advance(tf_instance *m, double h) {
#if TF_STATES
    for (int i = 0; i < TF_NODES; ++i) {
        double loads[TF_LOADS], next[TF_STATES];
        tf_loads_of(m, i, 0, loads);
        if (!(loads[TF_SIGMA_N] > 0.0)) continue; /* no contact: the point keeps its memory */
        tf_model_step(loads, m->data.state + i * TF_STATES, m->data.system, h, next);
        for (int s = 0; s < TF_STATES; ++s)
            if (!isfinite(next[s])) return i * TF_STATES + s + 1;
        memcpy(m->data.state + i * TF_STATES, next, sizeof next);
        m->fresh[i] = 0;
    }
#else
    (void)m; (void)h;
#endif
    return 0;
}
