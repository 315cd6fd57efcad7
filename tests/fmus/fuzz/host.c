/* A simulator in one file: create, use and free instances many times, load and unload the library, use it in threads.
   Usage: host cycles|loads|threads LIBRARY COUNT; LIBRARY "-" where the FMU's sources are linked in (-DLINKED). */
#define _GNU_SOURCE
#define STARVING_HOST
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { REAL = 'R', BOOLEAN = 'B', COUNT = 'U' };
enum { INPUT = 'i', OUTPUT = 'o', PARAMETER = 'p', LOCAL = 'l', STRUCTURAL = 's', TIME = 't', DERIVATIVE = 'd' };
typedef struct {
    const char *name;
    unsigned vr;
    int type, causality, array;
    double lower, upper, start;
} variable;
#include "variables.h"
#define VARIABLES ((int)(sizeof variables / sizeof variables[0]))
#define RESULTS 64 /* numbers that one use of an instance gives */
#define THREADS 8

static void need(int good, const char *what) {
    if (good) return;
    fprintf(stderr, "host: %s\n", what);
    exit(3);
}

static void *library;
#ifdef LINKED
#define FUNCTION(name) (name)
#else
static void *find(const char *name) {
    void *function = dlsym(library, name);
    need(function != NULL, name);
    return function;
}
#define FUNCTION(name) ((name##TYPE *)find(#name))
#endif

/* A load between what is slow, cold and light and what is fast, hot and heavy. */
static double load(const variable *v, unsigned seed) {
    seed = seed * 1664525u + 1013904223u + v->vr * 2654435761u;
    seed ^= seed >> 15;
    return v->lower + (seed % 10007u) / 10007.0 * (fmin(v->upper, 3000.0) - v->lower);
}

#if FMI == 2
#include "host_fmi2.h"
#else
#include "host_fmi3.h"
#endif

static long resident(void) { /* pages in memory, in bytes; 0 where the system does not say */
    long pages = 0, all = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    if (!f) return 0;
    if (fscanf(f, "%ld %ld", &all, &pages) != 2) pages = 0;
    fclose(f);
    return pages * sysconf(_SC_PAGESIZE);
}

static void open_library(const char *path) {
    if (strcmp(path, "-") == 0) return;
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    need(library != NULL, path);
}

static void close_library(void) {
    if (library) need(dlclose(library) == 0, "the library cannot be unloaded");
    library = NULL;
}

static double results[THREADS][RESULTS];
static int rounds;

static void *work(void *place) {
    double *mine = (double *)place;
    const unsigned t = (unsigned)((double (*)[RESULTS])place - results);
    for (int k = 0; k < rounds; ++k) {
        double again[RESULTS] = {0};
        use(t, k ? again : mine);
        need(k == 0 || memcmp(again, mine, sizeof again) == 0, "a thread got other numbers at another time");
    }
    return NULL;
}

/* The threads come first: what the library does once, at its first use, they do at the same time. */
static void threads(int n) {
    pthread_t thread[THREADS];
    rounds = n;
    for (int t = 0; t < THREADS; ++t) need(pthread_create(&thread[t], NULL, work, results[t]) == 0, "no thread");
    for (int t = 0; t < THREADS; ++t) pthread_join(thread[t], NULL);
    for (int t = 0; t < THREADS; ++t) {
        double alone[RESULTS] = {0};
        use((unsigned)t, alone);
        need(memcmp(alone, results[t], sizeof alone) == 0, "a thread got other numbers than the same calls alone");
    }
}

int main(int count, char **arguments) {
    need(count == 4, "usage: host cycles|loads|threads LIBRARY COUNT");
    const char *path = arguments[2];
    const int n = atoi(arguments[3]);
    double first[RESULTS] = {0}, again[RESULTS];
    if (strcmp(arguments[1], "threads") == 0) {
        open_library(path);
        threads(n);
        return 0;
    }
    const int loads = strcmp(arguments[1], "loads") == 0;
    if (!loads) open_library(path);
    long warm = 0;
    for (int k = 0; k < n; ++k) {
        if (loads) open_library(path);
        memset(again, 0, sizeof again);
        use(1, k ? again : first);
        if (k) need(memcmp(first, again, sizeof first) == 0, "another use of the same kind gave other numbers");
        if (loads) close_library();
        if (k == n / 10 || k == n / 5) warm = resident(); /* the first reading brings in pages of its own */
    }
    printf("%ld\n", resident() - warm);
    return 0;
}
