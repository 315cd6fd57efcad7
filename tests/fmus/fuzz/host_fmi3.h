/* One use of an FMI 3.0 instance from creation to its end, as co-simulation, at several contact points. */
#include "fmi3FunctionTypes.h"
#ifdef LINKED
#include "fmi3Functions.h"
#endif
#define POINTS 9 /* a block of points and a rest */

static void refused(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)status; (void)category;
    ++*(int *)environment;
    if (!strstr(message, "nan")) fprintf(stderr, "host: %s\n", message);
}

static void use(unsigned seed, double *result) {
    int messages = 0;
    const fmi3Instance c = FUNCTION(fmi3InstantiateCoSimulation)("host", FUZZ_TOKEN, "", 0, 0, 0, 0, NULL, 0, &messages, refused, NULL);
    need(c != NULL, "no instance");
    fmi3ValueReference n_vr[1], inputs[VARIABLES], outputs[VARIABLES];
    const fmi3UInt64 points = POINTS;
    double values[VARIABLES * POINTS], seen[VARIABLES * POINTS], seeds[VARIABLES * POINTS];
    size_t in = 0, out = 0;
    for (int k = 0; k < VARIABLES; ++k) {
        if (variables[k].causality == STRUCTURAL) n_vr[0] = variables[k].vr;
        if (variables[k].type == REAL && variables[k].causality == INPUT) inputs[in++] = variables[k].vr;
        if (variables[k].type == REAL && variables[k].causality == OUTPUT) outputs[out++] = variables[k].vr;
    }
    need(FUNCTION(fmi3EnterConfigurationMode)(c) == fmi3OK, "configuration");
    need(FUNCTION(fmi3SetUInt64)(c, n_vr, 1, &points, 1) == fmi3OK, "number of points");
    need(FUNCTION(fmi3ExitConfigurationMode)(c) == fmi3OK, "end of configuration");
    need(FUNCTION(fmi3EnterInitializationMode)(c, 0, 0.0, 0.0, 0, 0.0) == fmi3OK, "initialization");
    need(FUNCTION(fmi3ExitInitializationMode)(c) == fmi3OK, "end of initialization");
    fmi3FMUState state = NULL, read = NULL;
    const size_t many = in * POINTS, results = out * POINTS;
    for (unsigned step = 0; step < 4; ++step) {
        size_t at = 0;
        for (int k = 0; k < VARIABLES; ++k)
            for (unsigned i = 0; i < POINTS && variables[k].type == REAL && variables[k].causality == INPUT; ++i) {
                seeds[at] = 1.0;
                values[at++] = load(&variables[k], 64 * seed + 16 * step + i);
            }
        fmi3Boolean event, stop, early;
        fmi3Float64 last;
        need(FUNCTION(fmi3SetFloat64)(c, inputs, in, values, many) == fmi3OK, "set");
        if (step == 2) need(FUNCTION(fmi3GetFMUState)(c, &state) == fmi3OK, "state");
        need(FUNCTION(fmi3DoStep)(c, 0.01 * step, 0.01, 0, &event, &stop, &early, &last) == fmi3OK, "step");
        need(FUNCTION(fmi3GetFloat64)(c, outputs, out, seen, results) == fmi3OK, "get");
        for (size_t k = 0; k < results; ++k) result[(step * results + k) % RESULTS] += seen[k];
    }
    values[0] = NAN;
    need(FUNCTION(fmi3SetFloat64)(c, inputs, 1, values, POINTS) == fmi3Error && messages == 1, "not a number is refused");
    size_t size = 0;
    need(FUNCTION(fmi3SerializedFMUStateSize)(c, state, &size) == fmi3OK, "size");
    fmi3Byte *bytes = (fmi3Byte *)malloc(size);
    need(bytes && FUNCTION(fmi3SerializeFMUState)(c, state, bytes, size) == fmi3OK, "to bytes");
    need(FUNCTION(fmi3DeserializeFMUState)(c, bytes, size, &read) == fmi3OK, "from bytes");
    free(bytes);
    need(FUNCTION(fmi3SetFMUState)(c, read) == fmi3OK, "set state");
    need(FUNCTION(fmi3GetDirectionalDerivative)(c, outputs, out, inputs, in, seeds, many, seen, results) == fmi3OK, "derivative");
    for (size_t k = 0; k < results; ++k) result[k % RESULTS] += seen[k];
    need(FUNCTION(fmi3GetAdjointDerivative)(c, outputs, out, inputs, in, seeds, results, values, many) == fmi3OK, "adjoint");
    for (size_t k = 0; k < many; ++k) result[k % RESULTS] += values[k];
    need(FUNCTION(fmi3FreeFMUState)(c, &state) == fmi3OK && FUNCTION(fmi3FreeFMUState)(c, &read) == fmi3OK, "free state");
    FUNCTION(fmi3FreeInstance)(c);
}
