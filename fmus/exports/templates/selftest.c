/* Compares @P@.c with values that ONNX Runtime computed from model.onnx:
       cc -std=c99 -O2 selftest.c @P@.c -lm -o selftest && ./selftest
   prints "ok" and the largest deviation, or what went wrong, and then ends with 1. */

#include <math.h>
#include <stdio.h>

#include "@P@.h"

#define POINTS @POINTS@
#define STEPS @STEPS@

@DATA@
static double worst = 0.0;
static int wrong = 0;

static void compare(const char *what, int k, double value, double expected) {
    const double difference = fabs(value - expected);
    if (!(difference <= @RELATIVE@ * fabs(expected) + @ABSOLUTE@)) {
        printf("%s %d: %.17g, expected %.17g\n", what, k, value, expected);
        wrong = 1;
    }
    if (difference > worst) worst = difference;
}

int main(void) {
    double by_load[@UP@_LOADS * POINTS], many[POINTS], mu, gradient[@UP@_LOADS];
    for (int k = 0; k < POINTS; ++k) {
        double unclamped;
        if (@P@_mu(points[k], NULL, NULL, 1, &mu) != @UP@_OK) wrong = 1;
        compare("mu at point", k, mu, clamped_mu[k]);
        if (@P@_mu(points[k], NULL, NULL, 0, &unclamped) != @UP@_OK) wrong = 1;
        compare("extrapolated mu at point", k, unclamped, free_mu[k]);
        if (@P@_mu_gradient(points[k], NULL, NULL, 1, &mu, gradient) != @UP@_OK) wrong = 1;
        compare("mu beside its derivatives at point", k, mu, clamped_mu[k]);
        compare("domain distance of point", k, @P@_domain_distance(points[k], NULL), distance[k]);
        for (int l = 0; l < @UP@_LOADS; ++l) by_load[l * POINTS + k] = points[k][l];
    }
    if (@P@_mu_many(POINTS, by_load, NULL, NULL, 1, many) != 0) wrong = 1;
    for (int k = 0; k < POINTS; ++k) compare("mu of many, point", k, many[k], clamped_mu[k]);
    double state[@STATES_OR_1@];
    @P@_start(NULL, state, NULL);
    for (int k = 0; k < STEPS; ++k) {
        if (@P@_step(points[k], NULL, time_step[k], state) != @UP@_OK) wrong = 1;
        if (@P@_mu(points[k], state, NULL, 1, &mu) != @UP@_OK) wrong = 1;
        compare("mu after step", k, mu, stepped_mu[k]);
    }
    if (@P@_mu(not_a_number, NULL, NULL, 1, &mu) != @UP@_NOT_FINITE || mu != 0.0) {
        printf("a load that is not a number is not refused\n");
        wrong = 1;
    }
    if (wrong) return 1;
    printf("ok: %d points and %d steps, largest deviation %.1e\n", POINTS, STEPS, worst);
    return 0;
}
