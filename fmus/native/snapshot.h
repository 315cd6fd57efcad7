/* The FMU state: a copy in memory, and as bytes. Included after values.h.
   Bytes come from outside: they are believed only after every value of them was checked. */

typedef struct {
    size_t n;
    tf_head head;
    double values[1]; /* loads and states, (5 + TF_STATES) n of them */
} tf_snapshot;

static const char tf_mark[] = "tribofmu 2 " TF_GUID;

static size_t tf_value_count(size_t n) { return (TF_LOADS + TF_STATES) * n; }

static size_t tf_byte_count(size_t n) {
    return sizeof tf_mark + 2 * sizeof(uint64_t) + (4 + TF_SYSTEM + tf_value_count(n)) * sizeof(double);
}

/* Room for n points in *place; what is there is used again when it fits. */
static tf_snapshot *tf_room(const tf_instance *m, void **place, size_t n) {
    tf_snapshot *s = (tf_snapshot *)*place;
    if (s && s->n == n) return s;
    s = (tf_snapshot *)malloc(sizeof *s + tf_value_count(n) * sizeof(double));
    if (!s) {
        tf_fail(m, "out of memory");
        return NULL;
    }
    free(*place);
    s->n = n;
    *place = s;
    return s;
}

static int tf_save(const tf_instance *m, void **place) {
    tf_snapshot *s;
    if (!place) return tf_fail(m, "there is no place for the FMU state");
    s = tf_room(m, place, TF_N(m));
    if (!s) return 0;
    s->head = m->head;
    memcpy(s->values, m->loads, tf_value_count(s->n) * sizeof(double));
    return 1;
}

static int tf_restore(tf_instance *m, const void *state) {
    const tf_snapshot *s = (const tf_snapshot *)state;
    if (!s) return tf_fail(m, "the FMU state to be set is empty");
    if (s->head.model_exchange != m->head.model_exchange)
        return tf_fail(m, "the FMU state belongs to the other interface type (model exchange or co-simulation)");
    if (s->n != TF_N(m) && !tf_resize(m, s->n)) return 0;
    m->head = s->head;
    memcpy(m->loads, s->values, tf_value_count(s->n) * sizeof(double));
    tf_stale(m);
    return 1;
}

/* FNV-1a: finds damage, not malice. */
static uint64_t tf_checksum(const unsigned char *bytes, size_t count) {
    uint64_t h = 14695981039346656037u;
    for (size_t i = 0; i < count; ++i) h = (h ^ bytes[i]) * 1099511628211u;
    return h;
}

/* The numbers of the head as doubles, in the order of the bytes. */
static void tf_pack_head(const tf_head *head, double *out) {
    out[0] = head->time;
    out[1] = head->clamp;
    out[2] = head->latched_in_domain;
    out[3] = head->mode + TF_MODES * head->model_exchange;
    for (int p = 0; p < TF_SYSTEM; ++p) out[4 + p] = head->system[p];
}

static int tf_serialize(const tf_instance *m, const void *state, unsigned char *bytes, size_t size) {
    const tf_snapshot *s = (const tf_snapshot *)state;
    double head[4 + TF_SYSTEM];
    uint64_t n, sum;
    size_t at = sizeof tf_mark;
    if (!s || !bytes || size != tf_byte_count(s->n)) return tf_fail(m, "the FMU state is empty or its buffer has the wrong size");
    n = s->n;
    tf_pack_head(&s->head, head);
    memcpy(bytes, tf_mark, sizeof tf_mark);
    memcpy(bytes + at, &n, sizeof n);
    at += sizeof n;
    memcpy(bytes + at, head, sizeof head);
    at += sizeof head;
    memcpy(bytes + at, s->values, tf_value_count(s->n) * sizeof(double));
    at += tf_value_count(s->n) * sizeof(double);
    sum = tf_checksum(bytes, at);
    memcpy(bytes + at, &sum, sizeof sum);
    return 1;
}

/* Whether x is one of the whole numbers 0 ... limit - 1. */
static int tf_whole(double x, int limit) { return x >= 0.0 && x < limit && x == (double)(int)x; }

static int tf_deserialize(const tf_instance *m, const unsigned char *bytes, size_t size, void **place) {
    double head[4 + TF_SYSTEM];
    uint64_t n = 0, sum = 0;
    size_t at = sizeof tf_mark;
    tf_snapshot *s;
    if (!place || !bytes || size < tf_byte_count(1) || memcmp(bytes, tf_mark, sizeof tf_mark) != 0)
        return tf_fail(m, "the serialized state does not belong to this FMU");
    memcpy(&n, bytes + at, sizeof n);
    memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
#ifdef TF_FIXED_NODES
    if (n != TF_NODES) return tf_fail(m, "the serialized state has another number of points");
#endif
    if (n < 1 || n > TF_MAX_NODES || size != tf_byte_count((size_t)n) || sum != tf_checksum(bytes, size - sizeof sum))
        return tf_fail(m, "the serialized state is damaged");
    at += sizeof n;
    memcpy(head, bytes + at, sizeof head);
    at += sizeof head;
    for (size_t i = 0; i < 4 + TF_SYSTEM + tf_value_count((size_t)n); ++i) {
        double x;
        memcpy(&x, bytes + sizeof tf_mark + sizeof n + i * sizeof x, sizeof x);
        if (!isfinite(x)) return tf_fail(m, "the serialized state holds a value that is not a finite number");
    }
    if (!tf_whole(head[1], 2) || !tf_whole(head[2], 2) || !tf_whole(head[3], TF_MODES * (1 + TF_MODEL_EXCHANGE)))
        return tf_fail(m, "the serialized state is damaged");
    s = tf_room(m, place, (size_t)n);
    if (!s) return 0;
    memset(&s->head, 0, sizeof s->head);
    s->head.time = head[0];
    s->head.clamp = (int)head[1];
    s->head.latched_in_domain = (int)head[2];
    s->head.mode = (int)head[3] % TF_MODES;
    s->head.model_exchange = (int)head[3] / TF_MODES;
    for (int p = 0; p < TF_SYSTEM; ++p) s->head.system[p] = head[4 + p];
    memcpy(s->values, bytes + at, tf_value_count((size_t)n) * sizeof(double));
    return 1;
}
