/* FMI 2.0 of a friction model: co-simulation, and model exchange unless the memory is no differential equation.
   Compile this file alone (C99); it includes the generated model.h and the other headers beside it. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TF_FIXED_NODES
#include "fmi2Functions.h"
#include "model.h"
#include "domain.h"
#include "instance.h"
#include "values.h"
#include "sensitivity.h"
#include "snapshot.h"

/* Value references: groups of TF_NODES each, the system variables in between one each, then the Boolean variables. */
enum {
    FIRST_SYSTEM_VR = TF_FIRST_SYSTEM * TF_NODES,
    FIRST_DER_VR = FIRST_SYSTEM_VR + TF_SYSTEM,
    VR_COUNT = FIRST_DER_VR + TF_CONTINUOUS_STATES * TF_NODES
#if TF_INTERVAL
               + 2 * TF_NODES /* the bounds of the prediction interval */
#endif /* TF_INTERVAL */
    ,
    IN_DOMAIN = VR_COUNT,
    CLAMP_TO_DOMAIN
};

#define STATUS(good) ((good) ? fmi2OK : fmi2Error)
/* A handle that is NULL cannot log, it can be refused. */
#define INSTANCE(c)                          \
    tf_instance *m = (tf_instance *)(c);     \
    if (!m) return fmi2Error
#define NEED(good) \
    if (!(good)) return fmi2Error

static void report(const tf_instance *m, const char *text) {
    fmi2CallbackLogger logger;
    memcpy(&logger, &m->logger, sizeof logger); /* C has no cast between pointers to data and to functions */
    if (logger) logger(m->environment, m->name, fmi2Error, "logStatusError", text);
}

static int unknown(const tf_instance *m, const char *type, unsigned vr) {
    char text[TF_MESSAGE];
    snprintf(text, sizeof text, "there is no %s variable with value reference %u", type, vr);
    return tf_fail(m, text);
}

/* Arrays of a call may be missing only when they are empty. */
static int given(const tf_instance *m, size_t n, const void *a, const void *b) {
    return n == 0 || (a && b) ? 1 : tf_fail(m, "an array of the call is missing");
}

/* Group and point of a Real variable. */
static int place_of(const tf_instance *m, unsigned vr, int *group, size_t *point) {
    if (vr < FIRST_SYSTEM_VR) {
        *group = (int)(vr / TF_NODES);
        *point = vr % TF_NODES;
    } else if (vr < FIRST_DER_VR) {
        *group = TF_FIRST_SYSTEM + (int)(vr - FIRST_SYSTEM_VR);
        *point = 0;
    } else if (vr < VR_COUNT) {
        *group = TF_FIRST_DER + (int)((vr - FIRST_DER_VR) / TF_NODES);
        *point = (vr - FIRST_DER_VR) % TF_NODES;
    } else return unknown(m, "Real", vr);
    return 1;
}

/* How many of the references from vr[0] on are neighbouring points of its group: they are handled together. */
static size_t run_of(const fmi2ValueReference vr[], size_t n, int group, size_t point) {
    size_t length = 1;
    if (group >= TF_FIRST_SYSTEM && group < TF_FIRST_DER) return 1;
    while (length < n && point + length < TF_NODES && vr[length] == vr[0] + length) ++length;
    return length;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    INSTANCE(c);
    (void)on; (void)n; (void)categories; /* only refused calls are logged, always */
    return fmi2OK;
}

/* ---- life of an instance ---- */

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    static char empty[] = "";
    tf_instance prototype;
    (void)resources; (void)visible; (void)logging;
    memset(&prototype, 0, sizeof prototype);
    prototype.name = name ? (char *)name : empty;
    prototype.report = report;
    prototype.head.model_exchange = type == fmi2ModelExchange;
    if (functions) {
        fmi2CallbackLogger logger = functions->logger;
        memcpy(&prototype.logger, &logger, sizeof logger);
        prototype.environment = functions->componentEnvironment;
    }
    return tf_create(&prototype, guid);
}

void fmi2FreeInstance(fmi2Component c) { tf_free((tf_instance *)c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stopDefined, fmi2Real stop) {
    INSTANCE(c);
    (void)toleranceDefined; (void)tolerance; (void)stopDefined; (void)stop;
    NEED(tf_allowed(m, "fmi2SetupExperiment", TF_IN(TF_INSTANTIATED)));
    if (!isfinite(start)) return STATUS(tf_fail(m, "startTime is not a finite number"));
    m->head.time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2EnterInitializationMode", TF_IN(TF_INSTANTIATED)));
    m->head.mode = TF_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2ExitInitializationMode", TF_IN(TF_INITIALIZATION)));
    m->head.mode = m->head.model_exchange ? TF_EVENT : TF_STEP;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi2Terminate", TF_RUNNING));
    m->head.mode = TF_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    INSTANCE(c);
    tf_reset(m);
    return fmi2OK;
}

/* ---- values ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    INSTANCE(c);
    NEED(given(m, n, vr, value));
    for (size_t k = 0, length; k < n; k += length) {
        int group = 0;
        size_t point = 0;
        if (vr[k] == IN_DOMAIN) { /* some importers read all outputs so, and know no events */
            value[k] = tf_in_domain(m);
            length = 1;
            continue;
        }
        NEED(place_of(m, vr[k], &group, &point));
        length = run_of(vr + k, n - k, group, point);
        NEED(tf_get(m, group, point, length, value + k));
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    INSTANCE(c);
    NEED(given(m, n, vr, value));
    for (size_t k = 0, length; k < n; k += length) {
        int group = 0;
        size_t point = 0;
        NEED(place_of(m, vr[k], &group, &point));
        length = run_of(vr + k, n - k, group, point);
        NEED(tf_set(m, group, point, length, value + k));
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    INSTANCE(c);
    NEED(given(m, n, vr, value));
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == CLAMP_TO_DOMAIN) value[k] = m->head.clamp;
        else if (vr[k] == IN_DOMAIN) value[k] = tf_shown_in_domain(m);
        else return STATUS(unknown(m, "Boolean", vr[k]));
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    INSTANCE(c);
    NEED(given(m, n, vr, value));
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == IN_DOMAIN) return STATUS(tf_fail(m, "in_domain is an output and cannot be set"));
        if (vr[k] != CLAMP_TO_DOMAIN) return STATUS(unknown(m, "Boolean", vr[k]));
        NEED(tf_set_clamp(m, value[k] != fmi2False));
    }
    return fmi2OK;
}

/* There are no variables of the other types. */
#define NO_VARIABLES(function, name, values)                                                 \
    fmi2Status function(fmi2Component c, const fmi2ValueReference vr[], size_t n, values) { \
        INSTANCE(c);                                                                         \
        (void)value;                                                                         \
        if (n == 0) return fmi2OK;                                                           \
        return STATUS(vr ? unknown(m, name, vr[0]) : given(m, n, NULL, NULL));               \
    }
NO_VARIABLES(fmi2GetInteger, "Integer", fmi2Integer value[])
NO_VARIABLES(fmi2SetInteger, "Integer", const fmi2Integer value[])
NO_VARIABLES(fmi2GetString, "String", fmi2String value[])
NO_VARIABLES(fmi2SetString, "String", const fmi2String value[])

#include "fmi2_more.h"
