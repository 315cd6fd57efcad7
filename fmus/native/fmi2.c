/* FMI 2.0 of a friction model: co-simulation, and model exchange when the model has no memory.
   Compile this file alone (C99); it includes the generated model.h and instance.h. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "model.h"
#include "instance.h"

enum { INSTANTIATED = 0, INITIALIZATION, EVENT, CONTINUOUS, STEP, ENDED };
enum { IN_DOMAIN = 0, CLAMP_TO_DOMAIN = 1 };

static const char *const mode_names[] = {"instantiated", "initialization", "event", "continuous-time", "step", "terminated"};

/* Hand a message to the environment. The text is no format: percent signs never occur in it. */
static fmi2Status fail(tf_instance *m, const char *text) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)m->logger;
    if (logger) logger(m->environment, m->name, fmi2Error, "logStatusError", text);
    return fmi2Error;
}

static fmi2Status wrong_mode(tf_instance *m, const char *call) {
    char text[TF_MESSAGE];
    snprintf(text, sizeof text, "%s is not allowed in %s mode", call, mode_names[m->data.mode]);
    return fail(m, text);
}

static fmi2Status unknown(tf_instance *m, const char *type, unsigned vr) {
    char text[TF_MESSAGE];
    snprintf(text, sizeof text, "there is no %s variable with value reference %u", type, vr);
    return fail(m, text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c; (void)on; (void)n; (void)categories; /* only refused calls are logged, always */
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources; (void)visible; (void)logging;
    tf_instance probe;
    memset(&probe, 0, sizeof probe);
    probe.name = (char *)(name ? name : "");
    if (functions) {
        probe.logger = (void *)functions->logger;
        probe.environment = functions->componentEnvironment;
    }
    if (!guid || strcmp(guid, TF_GUID) != 0) {
        fail(&probe, "the GUID does not belong to this FMU, expected " TF_GUID);
        return NULL;
    }
    if (type == fmi2ModelExchange && TF_STATES) {
        fail(&probe, "a model with memory is not offered for model exchange");
        return NULL;
    }
    tf_instance *m = (tf_instance *)malloc(sizeof *m);
    char *copy = (char *)malloc(strlen(probe.name) + 1);
    if (!m || !copy) {
        free(m);
        free(copy);
        fail(&probe, "out of memory");
        return NULL;
    }
    *m = probe;
    m->name = strcpy(copy, probe.name);
    m->model_exchange = type == fmi2ModelExchange;
    tf_reset(m);
    return m;
}

void fmi2FreeInstance(fmi2Component c) {
    tf_instance *m = (tf_instance *)c;
    if (!m) return;
    free(m->name);
    free(m);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stopDefined, fmi2Real stop) {
    tf_instance *m = (tf_instance *)c;
    (void)toleranceDefined; (void)tolerance; (void)stopDefined; (void)stop;
    if (!isfinite(start)) return fail(m, "startTime is not a finite number");
    m->data.time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    tf_instance *m = (tf_instance *)c;
    if (m->data.mode != INSTANTIATED) return wrong_mode(m, "fmi2EnterInitializationMode");
    m->data.mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    tf_instance *m = (tf_instance *)c;
    if (m->data.mode != INITIALIZATION) return wrong_mode(m, "fmi2ExitInitializationMode");
    m->data.mode = m->model_exchange ? EVENT : STEP;
    m->data.latched_in_domain = tf_in_domain(m);
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    ((tf_instance *)c)->data.mode = ENDED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    tf_reset((tf_instance *)c);
    return fmi2OK;
}

/* ---- values ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    tf_instance *m = (tf_instance *)c;
    for (size_t k = 0; k < n; ++k) {
        const unsigned group = vr[k] / TF_NODES, node = vr[k] % TF_NODES;
        const unsigned first_system = (TF_FIRST_STATE + TF_STATES) * TF_NODES;
        if (vr[k] >= first_system + TF_SYSTEM) return unknown(m, "Real", vr[k]);
        if (vr[k] >= first_system) value[k] = m->data.system[vr[k] - first_system];
        else if (group < TF_LOADS) value[k] = m->data.loads[node * TF_LOADS + group];
        else if (group == TF_DISTANCE) value[k] = tf_distance(m, (int)node, NULL);
        else if (group != TF_MU) value[k] = m->data.state[node * TF_STATES + group - TF_FIRST_STATE];
        else {
            const int good = tf_evaluate(m, (int)node);
            value[k] = m->mu[node];
            if (!good) {
                char name[64], text[TF_MESSAGE];
                tf_name(name, sizeof name, vr[k]);
                snprintf(text, sizeof text, "%s is not a finite number at the given loads", name);
                return fail(m, text);
            }
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    tf_instance *m = (tf_instance *)c;
    for (size_t k = 0; k < n; ++k) {
        const unsigned group = vr[k] / TF_NODES, node = vr[k] % TF_NODES;
        const unsigned first_system = (TF_FIRST_STATE + TF_STATES) * TF_NODES;
        if (vr[k] >= first_system + TF_SYSTEM) return unknown(m, "Real", vr[k]);
        if (!isfinite(value[k])) {
            char name[64], text[TF_MESSAGE];
            tf_name(name, sizeof name, vr[k]);
            snprintf(text, sizeof text, "%s = %g is not a finite number", name, value[k]);
            return fail(m, text);
        }
        if (vr[k] >= first_system) {
            m->data.system[vr[k] - first_system] = value[k];
            tf_stale(m);
        } else if (group < TF_LOADS) {
            double *place = &m->data.loads[node * TF_LOADS + group];
            if (*place != value[k]) m->fresh[node] = 0;
            *place = value[k];
        } else if (group == TF_MU || group == TF_DISTANCE) {
            return fail(m, "mu and domain_distance are outputs and cannot be set");
        } else {
            if (m->data.mode > INITIALIZATION) return wrong_mode(m, "setting the memory of a point");
            m->data.state[node * TF_STATES + group - TF_FIRST_STATE] = value[k];
            m->fresh[node] = 0;
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    tf_instance *m = (tf_instance *)c;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == CLAMP_TO_DOMAIN) value[k] = m->data.clamp;
        else if (vr[k] != IN_DOMAIN) return unknown(m, "Boolean", vr[k]);
        else value[k] = m->data.mode == CONTINUOUS ? m->data.latched_in_domain : tf_in_domain(m);
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    tf_instance *m = (tf_instance *)c;
    for (size_t k = 0; k < n; ++k) {
        if (vr[k] == IN_DOMAIN) return fail(m, "in_domain is an output and cannot be set");
        if (vr[k] != CLAMP_TO_DOMAIN) return unknown(m, "Boolean", vr[k]);
        m->data.clamp = value[k] != fmi2False;
        tf_stale(m);
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    (void)value;
    return n ? unknown((tf_instance *)c, "Integer", vr[0]) : fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    (void)value;
    return n ? unknown((tf_instance *)c, "Integer", vr[0]) : fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)value;
    return n ? unknown((tf_instance *)c, "String", vr[0]) : fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)value;
    return n ? unknown((tf_instance *)c, "String", vr[0]) : fmi2OK;
}

#include "fmi2_more.h"
