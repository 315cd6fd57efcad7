/* One use of an FMI 2.0 instance from creation to its end, as co-simulation. */
#include "fmi2FunctionTypes.h"
#ifdef LINKED
#include "fmi2Functions.h"
#endif

static void refused(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String message, ...) {
    (void)environment; (void)name; (void)status; (void)category;
    ++*(int *)environment;
    if (!strstr(message, "nan")) fprintf(stderr, "host: %s\n", message);
}

static void use(unsigned seed, double *result) {
    int messages = 0;
    const fmi2CallbackFunctions functions = {refused, NULL, NULL, NULL, &messages};
    const fmi2Component c = FUNCTION(fmi2Instantiate)("host", fmi2CoSimulation, FUZZ_TOKEN, "file:///", &functions, 0, 0);
    need(c != NULL, "no instance");
    fmi2ValueReference inputs[VARIABLES], outputs[VARIABLES];
    double values[VARIABLES], seen[VARIABLES], seeds[VARIABLES];
    size_t in = 0, out = 0;
    for (int k = 0; k < VARIABLES; ++k) {
        if (variables[k].type == REAL && variables[k].causality == INPUT) inputs[in++] = variables[k].vr;
        if (variables[k].type == REAL && variables[k].causality == OUTPUT) outputs[out++] = variables[k].vr;
    }
    need(FUNCTION(fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK, "set up");
    need(FUNCTION(fmi2EnterInitializationMode)(c) == fmi2OK, "initialization");
    need(FUNCTION(fmi2ExitInitializationMode)(c) == fmi2OK, "end of initialization");
    fmi2FMUstate state = NULL, read = NULL;
    for (unsigned step = 0; step < 4; ++step) {
        in = 0;
        for (int k = 0; k < VARIABLES; ++k)
            if (variables[k].type == REAL && variables[k].causality == INPUT) {
                seeds[in] = 1.0;
                values[in++] = load(&variables[k], 16 * seed + step);
            }
        need(FUNCTION(fmi2SetReal)(c, inputs, in, values) == fmi2OK, "set");
        if (step == 2) need(FUNCTION(fmi2GetFMUstate)(c, &state) == fmi2OK, "state");
        need(FUNCTION(fmi2DoStep)(c, 0.01 * step, 0.01, 0) == fmi2OK, "step");
        need(FUNCTION(fmi2GetReal)(c, outputs, out, seen) == fmi2OK, "get");
        for (size_t k = 0; k < out; ++k) result[(step * out + k) % RESULTS] += seen[k];
    }
    values[0] = NAN;
    need(FUNCTION(fmi2SetReal)(c, inputs, 1, values) == fmi2Error && messages == 1, "not a number is refused");
    size_t size = 0;
    need(FUNCTION(fmi2SerializedFMUstateSize)(c, state, &size) == fmi2OK, "size");
    fmi2Byte *bytes = (fmi2Byte *)malloc(size);
    need(bytes && FUNCTION(fmi2SerializeFMUstate)(c, state, bytes, size) == fmi2OK, "to bytes");
    need(FUNCTION(fmi2DeSerializeFMUstate)(c, bytes, size, &read) == fmi2OK, "from bytes");
    free(bytes);
    need(FUNCTION(fmi2SetFMUstate)(c, read) == fmi2OK, "set state");
    need(FUNCTION(fmi2GetDirectionalDerivative)(c, outputs, out, inputs, in, seeds, seen) == fmi2OK, "derivative");
    for (size_t k = 0; k < out; ++k) result[k % RESULTS] += seen[k];
    need(FUNCTION(fmi2FreeFMUstate)(c, &state) == fmi2OK && FUNCTION(fmi2FreeFMUstate)(c, &read) == fmi2OK, "free state");
    FUNCTION(fmi2FreeInstance)(c);
}
