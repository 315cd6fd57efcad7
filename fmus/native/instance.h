/* One instance of a friction FMU: its values, names, messages. Independent of the FMI version.
   Included after model.h and domain.h; everything is static, nothing global is written, instances are independent.
   A function that returns int returns 1 when it did its work, and 0 when it refused and has said why. */

#define TF_MAX_NODES 100000
#define TF_MESSAGE 512
/* One event indicator tells where in_domain changes; without a recorded domain it never does. */
#define TF_INDICATORS TF_HAS_DOMAIN
#define TF_MODEL_EXCHANGE (TF_STATES == 0 || TF_ODE)
#define TF_CONTINUOUS_STATES (TF_ODE ? TF_STATES : 0)

/* FMI 2.0, and FMI 3.0 without arrays, fix the number of points when the FMU is made; a constant lets the compiler drop
   the loops of one point. */
#ifdef TF_FIXED_NODES
#define TF_N(m) ((size_t)TF_NODES)
#define TF_IS_SIZED 0
#else
#define TF_N(m) ((m)->n)
#define TF_IS_SIZED 1
#endif

enum { TF_INSTANTIATED = 0, TF_CONFIGURATION, TF_INITIALIZATION, TF_EVENT, TF_CONTINUOUS, TF_STEP, TF_TERMINATED, TF_MODES };

/* Groups of Float64 variables. Those before the system variables, and the derivatives, have one value a point. */
enum {
    TF_MU = TF_LOADS,
    TF_DISTANCE,
    TF_FIRST_STATE,
    TF_FIRST_SYSTEM = TF_FIRST_STATE + TF_STATES,
    TF_FIRST_DER = TF_FIRST_SYSTEM + TF_SYSTEM,
#if TF_INTERVAL
    TF_LOW = TF_FIRST_DER + TF_CONTINUOUS_STATES, /* bounds of the prediction interval */
    TF_HIGH,
#endif /* TF_INTERVAL */
    TF_GROUPS = TF_FIRST_DER + TF_CONTINUOUS_STATES
#if TF_INTERVAL
                + 2
#endif /* TF_INTERVAL */
};

typedef struct { /* with loads and state, all that getting and setting the FMU state moves */
    double time;
    double system[TF_AT_LEAST_ONE(TF_SYSTEM)];
    int clamp;
    int latched_in_domain; /* what model exchange shows between events */
    int mode;
    int model_exchange;
} tf_head;

typedef struct tf_instance {
    tf_head head;
    size_t n, capacity;  /* points, points that the arrays have room for */
    double *loads;       /* loads[l * n + i] */
    double *state;       /* state[s * n + i]; directly after the loads */
    double *next;        /* states after a step until all points are known to be good */
    double *mu;          /* mu[i] belongs to the present inputs where fresh[i] is set */
    double *seed;        /* directions of loads and states, kept at 0 between calls */
    unsigned char *fresh;
    char *name;
    void *environment, *logger;
    void (*report)(const struct tf_instance *, const char *text);
} tf_instance;

/* ---- names and messages ---- */

/* Write the name of one element of a group. */
static void tf_name(const tf_instance *m, char *text, int group, size_t i) {
#if TF_INTERVAL
    const int derivative = group >= TF_FIRST_DER && group < TF_LOW;
#else
    const int derivative = group >= TF_FIRST_DER;
#endif /* TF_INTERVAL */
    const size_t points = TF_N(m);
    (void)m;
    const char *name = group < TF_LOADS          ? tf_load_names[group]
#if TF_INTERVAL
                       : group == TF_LOW         ? "mu_low"
                       : group == TF_HIGH        ? "mu_high"
#endif /* TF_INTERVAL */
                       : group == TF_MU          ? "mu"
                       : group == TF_DISTANCE    ? "domain_distance"
                       : group < TF_FIRST_SYSTEM ? tf_state_names[group - TF_FIRST_STATE]
                       : !derivative             ? tf_system_names[group - TF_FIRST_SYSTEM]
                                                 : tf_state_names[group - TF_FIRST_DER];
    char index[32] = "";
#if TF_INTERVAL
    if (points > 1 && group >= TF_LOW) snprintf(index, sizeof index, "[%lu]", (unsigned long)i + 1);
#endif /* TF_INTERVAL */
    if (points > 1 && (derivative || group < TF_FIRST_SYSTEM)) snprintf(index, sizeof index, "[%lu]", (unsigned long)i + 1);
    snprintf(text, TF_MESSAGE / 2, "%s%.200s%s%s", derivative ? "der(" : "", name, index, derivative ? ")" : "");
}

/* The text is given to environments that take it for a format: percent signs never occur in it. */
static int tf_fail(const tf_instance *m, const char *text) {
    m->report(m, text);
    return 0;
}

static int tf_fail_at(const tf_instance *m, const char *before, int group, size_t i, const char *after) {
    char name[TF_MESSAGE / 2], text[TF_MESSAGE];
    tf_name(m, name, group, i);
    snprintf(text, sizeof text, "%.100s%.200s%.200s", before, name, after);
    return tf_fail(m, text);
}

static int tf_fail_value(const tf_instance *m, const char *before, int group, size_t i, double value) {
    char after[80];
    snprintf(after, sizeof after, " = %g is not a finite number", value);
    return tf_fail_at(m, before, group, i, after);
}

/* Refuse a call unless the instance is in one of the modes of the mask (1 << mode). */
static int tf_allowed(const tf_instance *m, const char *call, unsigned modes) {
    static const char *const names[TF_MODES] = {"instantiated", "configuration", "initialization", "event", "continuous-time", "step", "terminated"};
    char text[TF_MESSAGE];
    if (modes & (1u << m->head.mode)) return 1;
    snprintf(text, sizeof text, "%.300s is not allowed in %s mode", call, names[m->head.mode]);
    return tf_fail(m, text);
}

#define TF_IN(mode) (1u << (mode))
#define TF_BEFORE (TF_IN(TF_INSTANTIATED) | TF_IN(TF_INITIALIZATION))
#define TF_RUNNING (TF_IN(TF_EVENT) | TF_IN(TF_CONTINUOUS) | TF_IN(TF_STEP))

/* ---- life of an instance ---- */

static void tf_stale(tf_instance *m) { memset(m->fresh, 0, TF_N(m)); }

/* Give the arrays room for n points and lay them out; the values are not set. */
static int tf_resize(tf_instance *m, size_t n) {
    const size_t doubles = 2 * TF_LOADS + 3 * TF_STATES + 1;
    if (n > m->capacity) {
        double *block = (double *)calloc(n, doubles * sizeof(double) + 1);
        if (!block) return tf_fail(m, "out of memory");
        free(m->loads);
        m->loads = block;
        m->capacity = n;
    }
    m->n = n;
    m->state = m->loads + TF_LOADS * n;
    m->next = m->state + TF_STATES * n;
    m->mu = m->next + TF_STATES * n;
    m->seed = m->mu + n;
    m->fresh = (unsigned char *)(m->loads + doubles * m->capacity);
    memset(m->seed, 0, (TF_LOADS + TF_STATES) * n * sizeof(double));
    tf_stale(m);
    return 1;
}

/* All points at their start values. */
static void tf_start(tf_instance *m) {
    const size_t n = TF_N(m);
    for (int l = 0; l < TF_LOADS; ++l)
        for (size_t i = 0; i < n; ++i) m->loads[(size_t)l * n + i] = tf_load_start[l];
    for (int s = 0; s < TF_STATES; ++s)
        for (size_t i = 0; i < n; ++i) m->state[(size_t)s * n + i] = tf_state_start[s];
    tf_stale(m);
}

/* As after instantiation; never needs memory, because the default number of points fitted before. */
static void tf_reset(tf_instance *m) {
    const int model_exchange = m->head.model_exchange;
    memset(&m->head, 0, sizeof m->head);
    m->head.model_exchange = model_exchange;
    m->head.clamp = 1;
    m->head.latched_in_domain = 1;
    for (int p = 0; p < TF_SYSTEM; ++p) m->head.system[p] = tf_system_start[p];
    (void)tf_resize(m, TF_NODES);
    tf_start(m);
}

static void tf_free(tf_instance *m) {
    if (!m) return;
    free(m->loads);
    free(m->name);
    free(m);
}

/* A new instance, or NULL with a message through the report function of the prototype. */
static tf_instance *tf_create(const tf_instance *prototype, const char *token) {
    tf_instance *m;
    if (!token || strcmp(token, TF_GUID) != 0) {
        tf_fail(prototype, "the GUID (instantiation token) does not belong to this FMU, expected " TF_GUID);
        return NULL;
    }
    if (prototype->head.model_exchange && !TF_MODEL_EXCHANGE) {
        tf_fail(prototype, "a model whose memory is no differential equation is not offered for model exchange");
        return NULL;
    }
    m = (tf_instance *)malloc(sizeof *m);
    if (m) {
        *m = *prototype;
        m->name = (char *)malloc(strlen(prototype->name) + 1);
        if (m->name) {
            strcpy(m->name, prototype->name);
            if (tf_resize(m, TF_NODES)) {
                tf_reset(m);
                return m;
            }
            tf_free(m);
            return NULL;
        }
        free(m);
    }
    tf_fail(prototype, "out of memory");
    return NULL;
}
