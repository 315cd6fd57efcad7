/* Times one generated model and ONNX Runtime's C library on the same points, in turns, single thread.
   Arguments: shared library of ONNX Runtime, ONNX file, the same in single precision, number of rounds. Prints lines
   "name batch nanoseconds", nanoseconds a point, one line a round; and the largest differences of mu from the first file's. */

#define _GNU_SOURCE /* clock_gettime */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "model.h"

#define MOST 1024
#define EACH 3e5 /* nanoseconds of one measurement, at least */

/* The slots used of ONNX Runtime's table of functions; their places are fixed since its first version. */
enum {
    ERROR_MESSAGE = 2,
    CREATE_ENVIRONMENT = 3,
    CREATE_SESSION_FROM_ARRAY = 8,
    RUN = 9,
    CREATE_OPTIONS = 10,
    INTRA_OP_THREADS = 24,
    INTER_OP_THREADS = 25,
    CREATE_TENSOR = 49,
    CPU_MEMORY = 69
};
enum { FATAL = 4, DEVICE_ALLOCATOR = 0, DEFAULT_MEMORY = 0, SINGLE = 1, DOUBLE = 11 };

typedef void *status;
typedef struct {
    void *const *(*table)(uint32_t version);
    const char *(*version)(void);
} ort_base;
typedef status (*create_environment)(int level, const char *name, void **out);
typedef status (*create_options)(void **out);
typedef status (*set_threads)(void *options, int threads);
typedef status (*create_session)(void *environment, const void *model, size_t size, void *options, void **out);
typedef status (*cpu_memory)(int allocator, int kind, void **out);
typedef status (*create_tensor)(void *memory, void *data, size_t size, const int64_t *shape, size_t dimensions,
                                int type, void **out);
typedef status (*run_session)(void *session, void *options, const char *const *inputs, void *const *values, size_t n,
                              const char *const *outputs, size_t m, void **results);

static void *const *ort;
static void *memory;

/* A network in ONNX Runtime with preallocated tensors, one for a single point and one for a batch. */
typedef struct {
    void *session, *one_in, *one_out, *many_in, *many_out;
} runtime;

static void good(status s) {
    if (!s) return;
    fprintf(stderr, "%s\n", ((const char *(*)(status))ort[ERROR_MESSAGE])(s));
    exit(1);
}

static void open_library(const char *path) {
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    const ort_base *base = ((const ort_base *(*)(void))dlsym(handle, "OrtGetApiBase"))();
    ort = base->table(1);
    good(((cpu_memory)ort[CPU_MEMORY])(DEVICE_ALLOCATOR, DEFAULT_MEMORY, &memory));
}

static void *open_session(const char *path) {
    void *environment, *options, *session;
    static char content[1 << 24];
    FILE *file = fopen(path, "rb");
    const size_t size = file ? fread(content, 1, sizeof content, file) : 0;
    if (file) fclose(file);
    good(((create_environment)ort[CREATE_ENVIRONMENT])(FATAL, "bench", &environment));
    good(((create_options)ort[CREATE_OPTIONS])(&options));
    good(((set_threads)ort[INTRA_OP_THREADS])(options, 1));
    good(((set_threads)ort[INTER_OP_THREADS])(options, 1));
    good(((create_session)ort[CREATE_SESSION_FROM_ARRAY])(environment, content, size, options, &session));
    return session;
}

static void *tensor(void *data, int type, int64_t rows, int64_t columns) {
    const int64_t shape[2] = {rows, columns};
    const size_t width = type == DOUBLE ? sizeof(double) : sizeof(float);
    void *value = NULL;
    good(((create_tensor)ort[CREATE_TENSOR])(memory, data, (size_t)(rows * columns) * width, shape, 2, type, &value));
    return value;
}

typedef void kernel(const double *, const double *, const double *, double *);

/* Points row by row, as ONNX Runtime takes them, into blocks and back: what a caller of the kernels does too. */
static void in_blocks(kernel *block, const double *loads, double *mu, int n) {
    double columns[5 * TF_BLOCK], values[TF_BLOCK];
    for (int start = 0; start < n; start += TF_BLOCK) {
        for (int i = 0; i < TF_BLOCK; ++i)
            for (int k = 0; k < 5; ++k) columns[k * TF_BLOCK + i] = loads[5 * (start + i) + k];
        block(columns, NULL, NULL, values);
        memcpy(mu + start, values, sizeof values);
    }
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double loads[5 * MOST], mu[MOST], expected[MOST], one[5], result;
static float loads32[5 * MOST], mu32[MOST], one32[5], result32;
static runtime full, single;

static void by_runtime(const runtime *network, void *in, void **out) {
    static const char *const inputs[] = {"loads"}, *const outputs[] = {"mu"};
    good(((run_session)ort[RUN])(network->session, NULL, inputs, &in, 1, outputs, 1, out));
}

/* One pass over n points, or over 64 points one by one. */
static void pass(int who, int n) {
    static kernel *const alone[] = {tf_model_mu_plain, tf_model_mu_wide};
    static kernel *const block[] = {tf_model_mu_block_plain, tf_model_mu_block_wide};
    runtime *network = who == 2 ? &full : &single;
    if (n > 1) {
        if (who >= 2) by_runtime(network, network->many_in, &network->many_out);
        else in_blocks(block[who], loads, mu, n);
        return;
    }
    for (int i = 0; i < 64; ++i) {
        if (who < 2) {
            alone[who](loads + 5 * i, NULL, NULL, mu + i);
            continue;
        }
        memcpy(one, loads + 5 * i, sizeof one);
        memcpy(one32, loads32 + 5 * i, sizeof one32);
        by_runtime(network, network->one_in, &network->one_out);
        if (who == 2) expected[i] = result;
        else mu32[i] = result32;
    }
}

static double measure(int who, int n) {
    const double began = now();
    double taken;
    long points = 0;
    do {
        pass(who, n);
        points += n > 1 ? n : 64;
    } while ((taken = now() - began) < EACH);
    return taken / (double)points;
}

int main(int argc, char **argv) {
    static const char *const names[] = {"baseline", "avx2", "runtime", "runtime32"};
    static const int batches[] = {1, 64, MOST};
    if (argc != 5) return 2;
    open_library(argv[1]);
    full.session = open_session(argv[2]);
    single.session = open_session(argv[3]);
    const int rounds = atoi(argv[4]);
    unsigned seed = 1;
    static const double low[5] = {5.0, 20.0, 500.0, 0.0, 1.0}, high[5] = {500.0, 400.0, 2750.0, 60.0, 20.0};
    for (int i = 0; i < 5 * MOST; ++i) {
        seed = seed * 1664525u + 1013904223u;
        loads[i] = low[i % 5] + (high[i % 5] - low[i % 5]) * (seed >> 8) / 16777216.0;
        loads32[i] = (float)loads[i];
    }
    full.one_in = tensor(one, DOUBLE, 1, 5);
    full.one_out = tensor(&result, DOUBLE, 1, 1);
    single.one_in = tensor(one32, SINGLE, 1, 5);
    single.one_out = tensor(&result32, SINGLE, 1, 1);
    for (int b = 2; b >= 0; --b) {
        const int n = batches[b], points = n > 1 ? n : 64;
        full.many_in = tensor(loads, DOUBLE, n, 5);
        full.many_out = tensor(expected, DOUBLE, n, 1);
        single.many_in = tensor(loads32, SINGLE, n, 5);
        single.many_out = tensor(mu32, SINGLE, n, 1);
        for (int r = 0; r < rounds; ++r)
            for (int who = 0; who < 4; ++who)
                if (who != 1 || tf_wide()) printf("%s %d %.3f\n", names[who], n, measure(who, n));
        if (n > 1) in_blocks(tf_model_mu_block, loads, mu, n);
        else
            for (int i = 0; i < points; ++i) tf_model_mu(loads + 5 * i, NULL, NULL, mu + i);
        double worst = 0.0, worst32 = 0.0;
        for (int i = 0; i < points; ++i) {
            worst = fmax(worst, fabs(mu[i] - expected[i]));
            worst32 = fmax(worst32, fabs((double)mu32[i] - expected[i]));
        }
        printf("difference %d %.3g\ndifference32 %d %.3g\n", n, worst, n, worst32);
    }
    return 0;
}
