/* An instance of a solver FMU: its variables, and requests to the solver process (protocol.py says which).

   Variables are kept here: setting and getting costs no message, a communication step costs one. */

#ifndef TF_FRONT_H
#define TF_FRONT_H

#include <math.h>

#include "fmi2Functions.h"
#include "front_model.h"
#include "front_child.h"

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the messages are little-endian"
#endif

enum { TF_HELLO = 1, TF_CONFIGURE, TF_START, TF_STEP, TF_SAVE, TF_RESTORE, TF_FREE, TF_QUIT, TF_SERIALIZE, TF_DESERIALIZE, TF_REMARKS };
enum { TF_PROTOCOL = 1 };
#define TF_AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1)

/* Seconds that one request may take before the process counts as hanging; TRIBOFMU_TIMEOUT sets another limit. */
#define TF_TIME_LIMIT 1800.0
/* Seconds that a process has for its own end. */
#define TF_LEAVE_TIME 2.0

/* All that an FMU state holds beside the solver's own. */
typedef struct {
    double values[TF_REALS];
    unsigned char flags[TF_AT_LEAST_ONE(TF_FLAGS)];
    double begin, now;
    int running, initialized;
} tf_data;

typedef struct {
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
    char hint[TF_PATH], program[TF_PATH];
    tf_child child;
    int alive;
    unsigned long long life; /* states belong to one process */
    double limit;
    unsigned char *buffer; /* request or reply: one byte of code or status, then the content */
    size_t room, length;
    tf_data data;
} tf_front;

/* Hand a message to the environment. The standard calls it a format: percent signs are doubled. */
static fmi2Status tf_say(tf_front *f, fmi2Status status, const char *format, ...) {
    char text[TF_TEXT], safe[2 * TF_TEXT];
    size_t k = 0;
    const int warns = status == fmi2Warning;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *c = text; *c; ++c) {
        if (*c == '%') safe[k++] = '%';
        safe[k++] = *c;
    }
    safe[k] = '\0';
    if (f && f->logger)
        f->logger(f->environment, f->name, warns ? fmi2Warning : fmi2Error,
                  warns ? "logStatusWarning" : "logStatusError", safe);
    return status;
}

static int tf_reserve(tf_front *f, size_t size) {
    if (size > f->room) {
        unsigned char *larger = (unsigned char *)realloc(f->buffer, size);
        if (!larger) return 0;
        f->buffer = larger;
        f->room = size;
    }
    return 1;
}

/* Begin a request; numbers are added to it. */
static int tf_begin(tf_front *f, int code, size_t content) {
    f->length = 1;
    if (!tf_reserve(f, 1 + content)) return 0;
    f->buffer[0] = (unsigned char)code;
    return 1;
}

static void tf_add(tf_front *f, const void *bytes, size_t n) {
    memcpy(f->buffer + f->length, bytes, n);
    f->length += n;
}

/* The process is lost: say why, with what it said last. */
static fmi2Status tf_lost(tf_front *f, int result) {
    const int code = tf_child_end(&f->child, result == TF_LATE ? 0.0 : 1.0);
    const char *last = tf_tail_line(&f->child.tail);
    f->alive = 0;
    if (result == TF_LATE)
        return tf_say(f, fmi2Error, "the solver process (%s) has not answered within %g s and was ended; "
                      "TRIBOFMU_TIMEOUT sets another limit [s], 0 none%s%s", f->program, f->limit,
                      *last ? "; its last lines: " : "", last);
    if (code == TF_LACKS_PACKAGE && *last)
        return tf_say(f, fmi2Error, "%s", last);
    return tf_say(f, fmi2Error, "the solver process (%s) %s%s%s", f->program, f->child.ending,
                  *last ? "; its last lines: " : "", last);
}

/* Send the request, take the reply: `length` bytes in `buffer`, the status first, a zero behind them. */
static int tf_transfer(tf_front *f) {
    const double until = f->limit > 0.0 ? tf_now() + f->limit : 0.0;
    unsigned char head[4];
    size_t length = f->length;
    int result;
    for (int i = 0; i < 4; ++i) head[i] = (unsigned char)(length >> (8 * i));
    result = tf_child_send(&f->child, head, 4, until);
    if (result == TF_DONE) result = tf_child_send(&f->child, f->buffer, length, until);
    if (result == TF_DONE) result = tf_child_receive(&f->child, head, 4, until);
    if (result != TF_DONE) return result;
    length = head[0] | (size_t)head[1] << 8 | (size_t)head[2] << 16 | (size_t)head[3] << 24;
    if (length < 1 || length > 64u * 1024u * 1024u || !tf_reserve(f, length + 1)) return TF_GONE;
    result = tf_child_receive(&f->child, f->buffer, length, until);
    f->buffer[length] = 0;
    f->length = length;
    return result;
}

/* A request and its reply, or an error. */
static fmi2Status tf_exchange(tf_front *f) {
    int result;
    if (!f->alive)
        return tf_say(f, fmi2Error, "the solver process is gone; fmi2Reset starts another one");
    result = tf_transfer(f);
    if (result != TF_DONE) return tf_lost(f, result);
    if (f->buffer[0] == fmi2OK) return fmi2OK;
    return tf_say(f, f->buffer[0] == fmi2Discard ? fmi2Discard : fmi2Error, "%s", (const char *)f->buffer + 1);
}

/* A reply of the right length, or an error. */
static fmi2Status tf_ask(tf_front *f, size_t expected) {
    const fmi2Status status = tf_exchange(f);
    if (status == fmi2OK && f->length != 1 + expected)
        return tf_say(f, fmi2Error, "the solver process sent %lu bytes, expected: %lu", (unsigned long)f->length,
                      1ul + (unsigned long)expected);
    return status;
}

/* What the process publishes: outputs and flags. */
static fmi2Status tf_published(tf_front *f) {
    const size_t outputs = TF_FIRST_INPUT * sizeof(double), flags = TF_FLAGS;
    const fmi2Status status = tf_ask(f, outputs + flags);
    if (status != fmi2OK) return status;
    for (size_t i = 0; i < TF_FIRST_INPUT; ++i) {
        double value;
        memcpy(&value, f->buffer + 1 + i * sizeof value, sizeof value);
        if (!isfinite(value)) return tf_say(f, fmi2Error, "%s is not a finite number after the step", tf_names[i]);
    }
    memcpy(f->data.values, f->buffer + 1, outputs);
    for (size_t i = 0; i < flags; ++i) f->data.flags[i] = f->buffer[1 + outputs + i] != 0;
    return fmi2OK;
}

static fmi2Status tf_number_request(tf_front *f, int code, unsigned long long number) {
    if (!tf_begin(f, code, sizeof number)) return tf_say(f, fmi2Error, "out of memory");
    tf_add(f, &number, sizeof number);
    return tf_ask(f, 0);
}

/* Build the process from the parameters, on first use. */
static fmi2Status tf_ensure_started(tf_front *f) {
    const size_t given = (TF_REALS - TF_FIRST_INPUT) * sizeof(double);
    fmi2Status status;
    if (f->data.running) return fmi2OK;
    if (!tf_begin(f, TF_START, given)) return tf_say(f, fmi2Error, "out of memory");
    tf_add(f, f->data.values + TF_FIRST_INPUT, given);
    status = tf_published(f);
    f->data.running = status == fmi2OK;
    return status;
}

static int tf_hello(tf_front *f) {
    const unsigned version = TF_PROTOCOL;
    unsigned theirs;
    if (!tf_begin(f, TF_HELLO, 8)) return 0;
    tf_add(f, "TFMU", 4);
    tf_add(f, &version, 4);
    if (tf_exchange(f) != fmi2OK) return 0;
    if (f->length < 9 || memcmp(f->buffer + 1, "TFMU", 4) != 0) {
        tf_say(f, fmi2Error, "%s answers, but not as a solver process", f->program);
        return 0;
    }
    memcpy(&theirs, f->buffer + 5, 4);
    if (theirs == TF_PROTOCOL) return 1;
    tf_say(f, fmi2Error, "tribofmu %s in %s speaks version %u of the solver protocol, this FMU version %u; "
           "pack the FMU again with it, or set TRIBOFMU_PYTHON to an interpreter that has %s",
           (const char *)f->buffer + 9, f->program, theirs, version, "tribofmu " TF_PACKED_BY);
    return 0;
}

static int tf_configure(tf_front *f) {
    const unsigned char length = (unsigned char)strlen(TF_SOLVER);
    if (!tf_begin(f, TF_CONFIGURE, 1 + (size_t)length + sizeof tf_config)) return 0;
    tf_add(f, &length, 1);
    tf_add(f, TF_SOLVER, length);
    tf_add(f, tf_config, sizeof tf_config);
    return tf_ask(f, 0) == fmi2OK;
}

/* Start the process: TRIBOFMU_PYTHON, or what the FMU's resources/python.txt says, or Python on PATH. */
static int tf_start_process(tf_front *f) {
    const int count = (int)(sizeof tf_interpreters / sizeof *tf_interpreters);
    char why[256] = "";
    int told = tf_environment("TRIBOFMU_PYTHON", f->program, sizeof f->program), result = TF_NOT_FOUND;
    if (!told && f->hint[0]) {
        memcpy(f->program, f->hint, sizeof f->program);
        told = 1;
    }
    for (int i = 0; result == TF_NOT_FOUND && i < (told ? 1 : count); ++i) {
        if (!told) snprintf(f->program, sizeof f->program, "%s", tf_interpreters[i]);
        result = tf_child_start(&f->child, f->program, why, sizeof why);
    }
    if (result == TF_NOT_FOUND && !told)
        tf_say(f, fmi2Error, "there is no Python on PATH (%s); set TRIBOFMU_PYTHON to an interpreter that has the "
               "package tribofmu", why);
    else if (result != TF_STARTED)
        tf_say(f, fmi2Error, "the Python interpreter %s cannot be started (%s); set TRIBOFMU_PYTHON to an interpreter "
               "that has the package tribofmu", f->program, why);
    if (result != TF_STARTED) return 0;
    f->alive = 1;
    f->life += 1;
    if (tf_hello(f) && tf_configure(f)) return 1;
    if (f->alive) tf_child_end(&f->child, TF_LEAVE_TIME);
    f->alive = 0;
    return 0;
}

#endif
