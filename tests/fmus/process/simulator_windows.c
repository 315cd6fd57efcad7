/* A simulator for Windows that makes three steps with the library of a solver FMU and prints what it sees. */

#include <windows.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    (void)environment; (void)name; (void)status; (void)category;
    printf("log %s\n", message);
}

#define FUNCTION(name) name##TYPE *name##_ = (name##TYPE *)(void *)GetProcAddress(library, #name)

int main(int argc, char **argv) {
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    const fmi2ValueReference reference = 0;
    HMODULE library = LoadLibraryA(argv[1]);
    fmi2Component c;
    if (argc != 3 || !library) return 2;
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2FreeInstance);
    c = fmi2Instantiate_("a", fmi2CoSimulation, argv[2], "file:///C:/no%20where", &callbacks, fmi2False, fmi2False);
    if (!c) return 3;
    fmi2ExitInitializationMode_(c);
    for (int k = 0; k < 3; ++k) {
        fmi2Real value = 0.0;
        const fmi2Status status = fmi2DoStep_(c, 0.01 * k, 0.01, fmi2True);
        fmi2GetReal_(c, &reference, 1, &value);
        printf("step %d %g\n", status, value);
    }
    fmi2FreeInstance_(c);
    printf("freed\n");
    return 0;
}
