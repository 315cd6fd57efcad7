/* Second part of front_fmi2.c: FMU states, and what this FMU does not offer. */

/* The solver's own state stays in the process, under a number. */
typedef struct {
    const tf_front *owner;
    unsigned long long life, number;
    tf_data data;
    unsigned char *bytes; /* once serialized */
    size_t size;
} tf_state;

static const char serial_mark[] = "tribofmu 1 " TF_GUID;

static fmi2Status belongs(tf_front *f, const tf_state *s) {
    if (!f) return fmi2Error;
    if (!s) return tf_say(f, fmi2Error, "the FMU state is empty");
    if (s->owner != f) return tf_say(f, fmi2Error, "the FMU state belongs to another instance");
    if (s->life != f->life) return tf_say(f, fmi2Error, "the FMU state was in a solver process that is gone");
    return fmi2OK;
}

/* Free the number in the process; a process that is gone has taken its states along, and the number of
   another instance's state means nothing to this one's process. */
static fmi2Status forget(tf_front *f, const tf_state *s) {
    const int ours = s->owner == f && s->life == f->life;
    return ours && s->number && f->alive ? tf_number_request(f, TF_FREE, s->number) : fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    tf_front *f = (tf_front *)c;
    tf_state *s;
    unsigned long long number;
    fmi2Status status = f && state ? tf_ensure_started(f) : fmi2Error;
    if (status == fmi2OK && !tf_begin(f, TF_SAVE, 0)) status = tf_say(f, fmi2Error, "out of memory");
    if (status == fmi2OK) status = tf_ask(f, sizeof number);
    if (status != fmi2OK) return status;
    memcpy(&number, f->buffer + 1, sizeof number);
    s = (tf_state *)*state;
    if (s) status = forget(f, s);
    else s = (tf_state *)calloc(1, sizeof *s);
    if (!s) {
        tf_number_request(f, TF_FREE, number);
        return tf_say(f, fmi2Error, "out of memory");
    }
    free(s->bytes);
    s->bytes = NULL;
    s->owner = f;
    s->life = f->life;
    s->number = number;
    s->data = f->data;
    *state = s;
    return status;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    tf_front *f = (tf_front *)c;
    const tf_state *s = (const tf_state *)state;
    fmi2Status status = belongs(f, s);
    if (status == fmi2OK) status = tf_number_request(f, TF_RESTORE, s->number);
    if (status == fmi2OK) f->data = s->data;
    return status;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    fmi2Status status = fmi2OK;
    if (state && *state) {
        const tf_state *s = (const tf_state *)*state;
        if (c) status = forget((tf_front *)c, s);
        free(s->bytes);
        free(*state);
        *state = NULL;
    }
    return status;
}

/* Have the process write the state, with the front's own part in it, under one check sum. */
static fmi2Status serialize(tf_front *f, tf_state *s) {
    fmi2Status status = belongs(f, s);
    if (status != fmi2OK || s->bytes) return status;
    if (!tf_begin(f, TF_SERIALIZE, sizeof s->number + sizeof serial_mark + sizeof s->data))
        return tf_say(f, fmi2Error, "out of memory");
    tf_add(f, &s->number, sizeof s->number);
    tf_add(f, serial_mark, sizeof serial_mark);
    tf_add(f, &s->data, sizeof s->data);
    status = tf_exchange(f);
    if (status != fmi2OK) return status;
    s->size = f->length - 1;
    s->bytes = (unsigned char *)malloc(s->size + 1);
    if (!s->bytes) return tf_say(f, fmi2Error, "out of memory");
    memcpy(s->bytes, f->buffer + 1, s->size);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    const fmi2Status status = serialize((tf_front *)c, (tf_state *)state);
    if (status == fmi2OK && !size) return tf_say((tf_front *)c, fmi2Error, "there is no place for the size");
    if (status == fmi2OK) *size = ((tf_state *)state)->size;
    return status;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    tf_state *s = (tf_state *)state;
    const fmi2Status status = serialize((tf_front *)c, s);
    if (status != fmi2OK) return status;
    if (!bytes || size < s->size)
        return tf_say((tf_front *)c, fmi2Error, "the buffer for the FMU state has %lu bytes, allowed: at least %lu",
                      (unsigned long)size, (unsigned long)s->size);
    memcpy(bytes, s->bytes, s->size);
    return fmi2OK;
}

/* Whether the front's own part can be what this FMU has written. */
static int credible(const tf_data *d) {
    int good = isfinite(d->begin) && isfinite(d->now) && (d->running | 1) == 1 && (d->initialized | 1) == 1;
    for (size_t i = 0; good && i < TF_REALS; ++i) good = isfinite(d->values[i]);
    for (size_t i = 0; good && i < sizeof d->flags; ++i) good = d->flags[i] <= 1;
    return good;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    tf_front *f = (tf_front *)c;
    tf_state read, *s;
    fmi2Status status;
    if (!f || !state) return fmi2Error;
    memset(&read, 0, sizeof read);
    if (!bytes || size > 64u * 1024u * 1024u - 1) return tf_say(f, fmi2Error, "the serialized state has no such size");
    if (!tf_begin(f, TF_DESERIALIZE, size)) return tf_say(f, fmi2Error, "out of memory");
    tf_add(f, bytes, size);
    status = tf_ask(f, sizeof read.number + sizeof serial_mark + sizeof read.data);
    if (status != fmi2OK) return status;
    memcpy(&read.number, f->buffer + 1, sizeof read.number);
    memcpy(&read.data, f->buffer + 1 + sizeof read.number + sizeof serial_mark, sizeof read.data);
    read.owner = f;
    read.life = f->life;
    if (memcmp(f->buffer + 1 + sizeof read.number, serial_mark, sizeof serial_mark) != 0 || !credible(&read.data)) {
        forget(f, &read);
        return tf_say(f, fmi2Error, "the serialized state does not belong to this FMU");
    }
    s = (tf_state *)*state;
    if (s) {
        status = forget(f, s);
        free(s->bytes);
    } else s = (tf_state *)malloc(sizeof *s);
    if (!s) {
        forget(f, &read);
        return tf_say(f, fmi2Error, "out of memory");
    }
    *s = read;
    *state = s;
    return status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    (void)vr; (void)value;
    return n ? tf_say((tf_front *)c, fmi2Error, "Boolean variables of this FMU are outputs and cannot be set") : fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    (void)value;
    return n ? unknown((tf_front *)c, "Integer", vr[0]) : fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    (void)value;
    return n ? unknown((tf_front *)c, "Integer", vr[0]) : fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)value;
    return n ? unknown((tf_front *)c, "String", vr[0]) : fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)value;
    return n ? unknown((tf_front *)c, "String", vr[0]) : fmi2OK;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c; (void)on; (void)n; (void)categories;
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n,
                                        const fmi2ValueReference knowns[], size_t nKnown, const fmi2Real seed[],
                                        fmi2Real result[]) {
    (void)unknowns; (void)n; (void)knowns; (void)nKnown; (void)seed; (void)result;
    return tf_say((tf_front *)c, fmi2Error, "derivatives are not offered (providesDirectionalDerivative is false)");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr; (void)order; (void)value;
    return n ? tf_say((tf_front *)c, fmi2Error, "input derivatives are not used (canInterpolateInputs is false)") : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    (void)vr; (void)order; (void)value;
    return n ? tf_say((tf_front *)c, fmi2Error, "output derivatives are not offered") : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    return tf_say((tf_front *)c, fmi2Error, "no step runs in the background");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (!c || kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((tf_front *)c)->data.now;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated || !c) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c; (void)kind; (void)value;
    return fmi2Discard;
}
