/* FMI 3.0 of a friction model: co-simulation, and model exchange unless the memory is no differential equation.
   The quantities of a point are scalars (TF_FIXED_NODES), or arrays whose length is the structural parameter n.
   Compile this file alone (C99); it includes the generated model.h and the other headers beside it. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "model.h"
#include "domain.h"
#include "instance.h"
#include "values.h"
#include "sensitivity.h"
#include "snapshot.h"

/* Value references: the Float64 variables are 1 + their group; friction_variables.py numbers them so. */
enum {
    VR_TIME = 0,
    VR_FIRST = 1,
    VR_INDICATOR = VR_FIRST + TF_GROUPS,
    VR_IN_DOMAIN,
    VR_CLAMP,
    VR_N
};

#define STATUS(good) ((good) ? fmi3OK : fmi3Error)
/* A handle that is NULL cannot log, it can be refused. */
#define INSTANCE(c)                      \
    tf_instance *m = (tf_instance *)(c); \
    if (!m) return fmi3Error
#define NEED(good) \
    if (!(good)) return fmi3Error

static void report(const tf_instance *m, const char *text) {
    fmi3LogMessageCallback logger;
    memcpy(&logger, &m->logger, sizeof logger); /* C has no cast between pointers to data and to functions */
    if (logger) logger(m->environment, fmi3Error, "logStatusError", text);
}

static int unknown(const tf_instance *m, const char *type, fmi3ValueReference vr) {
    char text[TF_MESSAGE];
    snprintf(text, sizeof text, "there is no %s variable with value reference %lu", type, (unsigned long)vr);
    return tf_fail(m, text);
}

/* Arrays of a call may be missing only when they are empty. */
static int given(const tf_instance *m, size_t n, const void *a, const void *b) {
    return n == 0 || (a && b) ? 1 : tf_fail(m, "an array of the call is missing");
}

/* An array of system variables has the value reference of its first element; those of the others are not used. Its
   element e is a group of its own. */
#define IS_SYSTEM(group) ((group) >= TF_FIRST_SYSTEM && (group) < TF_FIRST_DER)
#define GROUP_OF(group, e) (IS_SYSTEM(group) ? (group) + (int)(e) : (group))
#define POINT_OF(group, e) (IS_SYSTEM(group) ? 0 : (size_t)(e))

static int is_group(fmi3ValueReference vr) {
    const int group = (int)vr - VR_FIRST;
    if (vr < VR_FIRST || vr >= VR_FIRST + TF_GROUPS) return 0;
    return !IS_SYSTEM(group) || tf_system_length[group - TF_FIRST_SYSTEM];
}

/* Number of values of a variable. */
static size_t length_of(const tf_instance *m, int group) {
    (void)m; /* one point is a constant */
    return IS_SYSTEM(group) ? (size_t)tf_system_length[group - TF_FIRST_SYSTEM] : TF_N(m);
}

static int get_variable(tf_instance *m, int group, double *values) {
    const size_t count = length_of(m, group);
    if (!IS_SYSTEM(group)) return tf_get(m, group, 0, count, values);
    for (size_t e = 0; e < count; ++e)
        if (!tf_get(m, group + (int)e, 0, 1, values + e)) return 0;
    return 1;
}

/* Nothing is set when one of the values is refused. The sampling points of a map rise. */
static int set_variable(tf_instance *m, int group, const double *values) {
    const size_t count = length_of(m, group);
    if (!IS_SYSTEM(group)) return tf_set(m, group, 0, count, values);
    for (size_t e = 0; e < count; ++e) {
        if (!isfinite(values[e])) return tf_fail_value(m, "", group + (int)e, 0, values[e]);
        if (e && tf_system_rises[group - TF_FIRST_SYSTEM] && !(values[e] > values[e - 1])) {
            char after[120];
            snprintf(after, sizeof after, " = %g is not above the sampling point before it, %g", values[e], values[e - 1]);
            return tf_fail_at(m, "", group + (int)e, 0, after);
        }
    }
    for (size_t e = 0; e < count; ++e)
        if (!tf_set(m, group + (int)e, 0, 1, values + e)) return 0;
    return 1;
}

/* Whether the variables have `count` values together, so that nothing outside the arrays of the call is touched. */
static int fits(const tf_instance *m, const fmi3ValueReference vr[], size_t n, size_t count) {
    size_t sum = 0;
    for (size_t k = 0; k < n; ++k) {
        sum += is_group(vr[k]) ? length_of(m, (int)vr[k] - VR_FIRST) : 1;
        if (sum > count) break;
    }
    return sum == count ? 1 : tf_fail(m, "the number of values is not the number of elements of the variables");
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    INSTANCE(c);
    (void)on; (void)n; (void)categories; /* only refused calls are logged, always */
    return fmi3OK;
}

/* ---- life of an instance ---- */

static fmi3Instance instantiate(fmi3String name, fmi3String token, int model_exchange, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback logger) {
    static char empty[] = "";
    tf_instance prototype;
    memset(&prototype, 0, sizeof prototype);
    prototype.name = name ? (char *)name : empty;
    prototype.report = report;
    prototype.head.model_exchange = model_exchange;
    prototype.environment = environment;
    memcpy(&prototype.logger, &logger, sizeof logger);
    return tf_create(&prototype, token);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)resources; (void)visible; (void)logging;
    return instantiate(name, token, 1, environment, logger);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference intermediate[], size_t nIntermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    /* No event mode, no early return, no intermediate update: the capability flags say so, and asking changes nothing. */
    (void)resources; (void)visible; (void)logging; (void)eventModeUsed; (void)earlyReturnAllowed;
    (void)intermediate; (void)nIntermediate; (void)update;
    return instantiate(name, token, 0, environment, logger);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)update; (void)lock; (void)unlock;
    if (logger) logger(environment, fmi3Error, "logStatusError", "scheduled execution is not offered");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c) { tf_free((tf_instance *)c); }

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3EnterConfigurationMode (n is fixed after instantiation)", TF_IN(TF_INSTANTIATED)));
    m->head.mode = TF_CONFIGURATION;
    return fmi3OK;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3ExitConfigurationMode", TF_IN(TF_CONFIGURATION)));
    m->head.mode = TF_INSTANTIATED;
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stopDefined, fmi3Float64 stop) {
    INSTANCE(c);
    (void)toleranceDefined; (void)tolerance; (void)stopDefined; (void)stop;
    NEED(tf_allowed(m, "fmi3EnterInitializationMode", TF_IN(TF_INSTANTIATED)));
    if (!isfinite(start)) return STATUS(tf_fail(m, "startTime is not a finite number"));
    m->head.time = start;
    m->head.mode = TF_INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3ExitInitializationMode", TF_IN(TF_INITIALIZATION)));
    m->head.mode = m->head.model_exchange ? TF_EVENT : TF_STEP;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    INSTANCE(c);
    NEED(tf_allowed(m, "fmi3Terminate", TF_RUNNING));
    m->head.mode = TF_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
    INSTANCE(c);
    tf_reset(m);
    return fmi3OK;
}

/* ---- values ---- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        const int group = (int)vr[k] - VR_FIRST;
        if (is_group(vr[k])) {
            NEED(get_variable(m, group, values));
            values += length_of(m, group);
        } else if (vr[k] == VR_TIME) *values++ = m->head.time;
        else if (vr[k] == VR_INDICATOR && TF_INDICATORS) *values++ = tf_indicator(m);
        else if (vr[k] == VR_IN_DOMAIN) *values++ = tf_in_domain(m); /* some importers read all outputs so, and know no events */
        else return STATUS(unknown(m, "Float64", vr[k]));
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        const int group = (int)vr[k] - VR_FIRST;
        if (vr[k] == VR_TIME) return STATUS(tf_fail(m, "time is the independent variable and cannot be set so"));
        if (vr[k] == VR_INDICATOR && TF_INDICATORS) return STATUS(tf_fail(m, "domain_indicator is calculated and cannot be set"));
        if (!is_group(vr[k])) return STATUS(unknown(m, "Float64", vr[k]));
        NEED(set_variable(m, group, values));
        values += length_of(m, group);
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == VR_CLAMP) values[k] = m->head.clamp != 0;
        else if (vr[k] == VR_IN_DOMAIN) values[k] = tf_shown_in_domain(m) != 0;
        else return STATUS(unknown(m, "Boolean", vr[k]));
    }
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        unsigned char byte; /* a caller's byte may be neither 0 nor 1, which reading it as bool would not survive */
        memcpy(&byte, values + k, 1);
        if (vr[k] == VR_IN_DOMAIN) return STATUS(tf_fail(m, "in_domain is an output and cannot be set"));
        if (vr[k] != VR_CLAMP) return STATUS(unknown(m, "Boolean", vr[k]));
        NEED(tf_set_clamp(m, byte != 0));
    }
    return fmi3OK;
}

fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        if (!TF_IS_SIZED || vr[k] != VR_N) return STATUS(unknown(m, "UInt64", vr[k]));
        values[k] = m->n;
    }
    return fmi3OK;
}

/* The number of points: all of them come back to their start values when it changes. */
fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 values[], size_t count) {
    INSTANCE(c);
    NEED(given(m, n, vr, values) && fits(m, vr, n, count));
    for (size_t k = 0; k < n; ++k) {
        if (!TF_IS_SIZED || vr[k] != VR_N) return STATUS(unknown(m, "UInt64", vr[k]));
        NEED(tf_allowed(m, "setting n", TF_IN(TF_CONFIGURATION)));
        if (values[k] < 1 || values[k] > TF_MAX_NODES) {
            char text[TF_MESSAGE];
            snprintf(text, sizeof text, "n = %llu, allowed: 1 to %d", (unsigned long long)values[k], TF_MAX_NODES);
            return STATUS(tf_fail(m, text));
        }
        if (values[k] != m->n) {
            NEED(tf_resize(m, (size_t)values[k]));
            tf_start(m);
        }
    }
    return fmi3OK;
}

#include "fmi3_more.h"
#include "fmi3_rest.h"
