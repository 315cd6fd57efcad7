/* A simulator without anything: loads an FMI 2.0 library of one point, sets loads, prints mu. On Windows it has no
   C library of a compiler either. LIBRARY, GUID and POINTS (rows of v_rel T sigma_n sd psi) are defined outside. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#if defined _WIN32
typedef void *handle;
__declspec(dllimport) handle __stdcall LoadLibraryA(const char *name);
__declspec(dllimport) void *__stdcall GetProcAddress(handle library, const char *name);
__declspec(dllimport) handle __stdcall GetStdHandle(unsigned long which);
__declspec(dllimport) int __stdcall WriteFile(handle file, const void *text, unsigned long size, unsigned long *done,
                                              void *overlapped);
__declspec(dllimport) void __stdcall ExitProcess(unsigned code);
#define OPEN(name) LoadLibraryA(name)
#define FIND(library, name) GetProcAddress(library, name)
static void print(const char *text)
{
    unsigned long done;
    WriteFile(GetStdHandle((unsigned long)-11), text, (unsigned long)strlen(text), &done, 0);
}
#else
#include <dlfcn.h>
#define OPEN(name) dlopen(name, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
static void print(const char *text)
{
    fputs(text, stdout);
}
#endif

static void logger(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{
    (void)e;
    (void)n;
    (void)s;
    (void)c;
    print(m);
    print("\n");
}

static const double points[][5] = {POINTS};

static int run(void)
{
    fmi2CallbackFunctions callbacks = {logger, calloc, free, 0, 0};
    fmi2ValueReference loads[5] = {0, 1, 2, 3, 4}, mu = 5;
    fmi2Component c;
    unsigned k;
    void *library = OPEN(LIBRARY);
    if (!library) return 2;
#define CALL(name) ((name##TYPE *)(size_t)FIND(library, #name))
    c = CALL(fmi2Instantiate)("other", fmi2CoSimulation, GUID, "", &callbacks, fmi2False, fmi2True);
    if (!c) return 3;
    if (CALL(fmi2SetupExperiment)(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) > fmi2Warning) return 4;
    if (CALL(fmi2EnterInitializationMode)(c) > fmi2Warning) return 5;
    if (CALL(fmi2ExitInitializationMode)(c) > fmi2Warning) return 6;
    for (k = 0; k < sizeof points / sizeof *points; ++k) {
        char text[64];
        double value = 0.0;
        if (CALL(fmi2SetReal)(c, loads, 5, points[k]) > fmi2Warning) return 7;
        if (CALL(fmi2DoStep)(c, 0.1 * k, 0.1, fmi2False) > fmi2Warning) return 8;
        if (CALL(fmi2GetReal)(c, &mu, 1, &value) > fmi2Warning) return 9;
        snprintf(text, sizeof text, "%.17g\n", value);
        print(text);
    }
    CALL(fmi2FreeInstance)(c);
    return 0;
}

#if defined _WIN32
void start(void);
void start(void)
{
    ExitProcess((unsigned)run());
}
#else
int main(void)
{
    return run();
}
#endif
