/* FMI 2.0 co-simulation in front of a solver that runs in a Python process of its own.
   Compile this file alone (C99); it includes the generated front_model.h and the other headers beside it.

   What is allowed when, and the messages, are those of the PythonFMU form (fmus/slaves/base.py). */

#ifdef _WIN32
#ifndef _WIN32_WINNT
#define _WIN32_WINNT 0x0601
#endif
#else
#define _GNU_SOURCE 1
#define _DARWIN_C_SOURCE 1
#endif

#include "front.h"

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static fmi2Status unknown(tf_front *f, const char *type, unsigned vr) {
    return tf_say(f, fmi2Error, "there is no %s variable with value reference %u", type, vr);
}

/* A variable, so that compilers do not warn of the comparison where there are none. */
static unsigned flag_count(void) { return TF_FLAGS; }

/* Value references: outputs, inputs, parameters, flags, further outputs. The values keep the further outputs behind the
 * others; TF_REALS is no place. */
static unsigned further_count(void) { return TF_FURTHER; }
static unsigned first_flag(void) { return TF_REALS - further_count(); }

static unsigned place(fmi2ValueReference vr) {
    const unsigned head = TF_FIRST_INPUT - further_count(), after = first_flag() + flag_count();
    if (vr < head) return vr;
    if (vr < first_flag()) return vr + further_count();
    if (vr >= after && vr - after < further_count()) return head + (vr - after);
    return TF_REALS;
}

static void reset_data(tf_front *f) {
    memset(&f->data, 0, sizeof f->data);
    memcpy(f->data.values, tf_start, sizeof tf_start);
}

/* Path of a file URI, in any of the forms that hosts write; 0: it does not fit. */
static int path_of(const char *uri, char *path, size_t size) {
    size_t k = 0;
    if (strncmp(uri, "file:", 5) == 0) {
        uri += 5;
        if (strncmp(uri, "//localhost/", 12) == 0) uri += 11;
        else if (strncmp(uri, "///", 3) == 0) uri += 2;
#ifdef _WIN32
        if (uri[0] == '/' && uri[1] && uri[2] == ':') uri += 1;
#endif
    }
    while (*uri && k + 1 < size) {
        char digits[3] = {0, 0, 0}, *end = digits;
        long code = 0;
        if (*uri == '%' && uri[1] && uri[2]) {
            memcpy(digits, uri + 1, 2);
            code = strtol(digits, &end, 16);
        }
        if (end == digits + 2 && code > 0) {
            path[k++] = (char)code;
            uri += 3;
        } else path[k++] = *uri++;
    }
    path[k] = '\0';
    return *uri == '\0';
}

/* First line of resources/python.txt; no such file is the rule. */
static void read_hint(tf_front *f, const char *resources) {
    const char *file = "/python.txt";
    char path[TF_PATH];
    FILE *stream;
    if (!resources || !path_of(resources, path, sizeof path - strlen(file) - 1)) return;
    stream = tf_open(strcat(path, file));
    if (!stream) return;
    if (!fgets(f->hint, sizeof f->hint, stream)) f->hint[0] = '\0';
    f->hint[strcspn(f->hint, "\r\n")] = '\0';
    fclose(stream);
}

static int read_limit(tf_front *f) {
    char text[64], *end;
    f->limit = TF_TIME_LIMIT;
    if (!tf_environment("TRIBOFMU_TIMEOUT", text, sizeof text)) return 1;
    f->limit = strtod(text, &end);
    if (*end == '\0' && f->limit >= 0.0 && f->limit <= 1e8) return 1;
    tf_say(f, fmi2Error, "TRIBOFMU_TIMEOUT = '%s', allowed: seconds from 0 (no limit) to 1e8", text);
    return 0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    tf_front *f = (tf_front *)calloc(1, sizeof *f);
    const char *own = name ? name : "";
    int good = 0;
    (void)visible; (void)logging; /* only refused calls are logged, always */
    if (!f) return NULL;
    f->name = (char *)malloc(strlen(own) + 1);
    if (functions) {
        f->logger = functions->logger;
        f->environment = functions->componentEnvironment;
    }
    if (f->name) {
        strcpy(f->name, own);
        reset_data(f);
        if (!guid || strcmp(guid, TF_GUID) != 0)
            tf_say(f, fmi2Error, "the GUID does not belong to this FMU, expected " TF_GUID);
        else if (type != fmi2CoSimulation) tf_say(f, fmi2Error, "the FMU is for co-simulation only");
        else {
            read_hint(f, resources);
            good = read_limit(f) && tf_start_process(f);
        }
    }
    if (good) return f;
    free(f->name);
    free(f->buffer);
    free(f);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
    tf_front *f = (tf_front *)c;
    if (!f) return;
    if (f->alive) tf_child_end(&f->child, TF_LEAVE_TIME);
    free(f->name);
    free(f->buffer);
    free(f);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stopDefined, fmi2Real stop) {
    tf_front *f = (tf_front *)c;
    (void)toleranceDefined; (void)tolerance; (void)stopDefined; (void)stop;
    if (!f) return fmi2Error;
    if (!isfinite(start)) return tf_say(f, fmi2Error, "startTime is not a finite number");
    f->data.begin = f->data.now = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    tf_front *f = (tf_front *)c;
    const fmi2Status status = f ? tf_ensure_started(f) : fmi2Error;
    if (status == fmi2OK) f->data.initialized = 1;
    return status;
}

/* Warnings about the run, one a line; an older solver does not know the question. */
fmi2Status fmi2Terminate(fmi2Component c) {
    tf_front *f = (tf_front *)c;
    int result;
    if (!f || !f->alive || !f->data.running || !tf_begin(f, TF_REMARKS, 0)) return fmi2OK;
    result = tf_transfer(f);
    if (result != TF_DONE) return tf_lost(f, result);
    if (f->buffer[0] != fmi2OK) return fmi2OK;
    for (char *line = (char *)f->buffer + 1; *line;) {
        const size_t n = strcspn(line, "\n");
        tf_say(f, fmi2Warning, "%.*s", (int)n, line);
        line += n + (line[n] == '\n');
    }
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    tf_front *f = (tf_front *)c;
    if (!f) return fmi2Error;
    reset_data(f);
    return f->alive || tf_start_process(f) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    tf_front *f = (tf_front *)c;
    const size_t inputs = (TF_FIRST_PARAMETER - TF_FIRST_INPUT) * sizeof(double);
    double span[2];
    fmi2Status status;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!f) return fmi2Error;
    if (!f->data.initialized)
        return tf_say(f, fmi2Error, "fmi2DoStep is not allowed before fmi2ExitInitializationMode");
    if (!isfinite(time + h) || h < 0.0)
        return tf_say(f, fmi2Discard, "communication step %g s at %g s is negative or not a finite number", h, time);
    span[0] = time - f->data.begin;
    span[1] = h;
    if (!tf_begin(f, TF_STEP, sizeof span + inputs)) return tf_say(f, fmi2Error, "out of memory");
    tf_add(f, span, sizeof span);
    tf_add(f, f->data.values + TF_FIRST_INPUT, inputs);
    status = tf_published(f);
    if (status == fmi2OK) f->data.now = time + h;
    return status;
}

/* ---- values ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    tf_front *f = (tf_front *)c;
    if (!f) return fmi2Error;
    for (size_t k = 0; k < n; ++k) {
        const unsigned at = place(vr[k]);
        if (at >= TF_REALS) return unknown(f, "Real", vr[k]);
        if (at < TF_FIRST_INPUT) {
            const fmi2Status status = tf_ensure_started(f);
            if (status != fmi2OK) return status;
        }
        value[k] = f->data.values[at];
    }
    return fmi2OK;
}

/* All or nothing: a call that is refused has set nothing. */
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    tf_front *f = (tf_front *)c;
    if (!f) return fmi2Error;
    for (size_t k = 0; k < n; ++k) {
        const unsigned at = place(vr[k]);
        if (at >= TF_REALS) return unknown(f, "Real", vr[k]);
        if (!isfinite(value[k]))
            return tf_say(f, fmi2Error, "%s = %s is not a finite number", tf_names[at],
                          isnan(value[k]) ? "nan" : value[k] > 0.0 ? "inf" : "-inf");
        if (at < TF_FIRST_INPUT)
            return tf_say(f, fmi2Error, "%s is an output and cannot be set", tf_names[at]);
        if (at >= TF_FIRST_PARAMETER && f->data.initialized)
            return tf_say(f, fmi2Error, "parameter %s cannot be set after initialization", tf_names[at]);
    }
    for (size_t k = 0; k < n; ++k) {
        const unsigned at = place(vr[k]);
        f->data.values[at] = value[k];
        if (at >= TF_FIRST_PARAMETER) f->data.running = 0;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    tf_front *f = (tf_front *)c;
    const fmi2Status status = !f ? fmi2Error : n ? tf_ensure_started(f) : fmi2OK;
    for (size_t k = 0; status == fmi2OK && k < n; ++k) {
        if (vr[k] < first_flag() || vr[k] - first_flag() >= flag_count()) return unknown(f, "Boolean", vr[k]);
        value[k] = f->data.flags[vr[k] - first_flag()] ? fmi2True : fmi2False;
    }
    return status;
}

#include "front_more.h"
