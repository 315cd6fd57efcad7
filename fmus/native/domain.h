/* Rules on the loads of one point, on plain arrays. Include after model.h.
   Every use of a model keeps to them: the FMUs, and the exported subroutines. */

#include <float.h>

#define TF_LOADS 5
#define TF_SIGMA_N 2
#define TF_AT_LEAST_ONE(n) ((n) > 0 ? (n) : 1)
#ifndef TF_UNUSED
#ifdef __GNUC__
#define TF_UNUSED __attribute__((unused))
#else
#define TF_UNUSED
#endif
#endif

TF_UNUSED static double tf_limit(double x, double lower, double upper) { return x < lower ? lower : x > upper ? upper : x; }

/* The loads inside the physical limits, and inside the trained domain too when `domain` is set. */
TF_UNUSED static void tf_limited(const double *loads, int domain, double *out) {
    for (int l = 0; l < TF_LOADS; ++l) {
        const double x = tf_limit(loads[l], tf_load_lower[l], tf_load_upper[l]);
        out[l] = domain ? tf_limit(x, tf_domain_lower[l], tf_domain_upper[l]) : x;
    }
}

/* Signed distance of one load from its trained range in units of the range's width; below 0 inside. */
TF_UNUSED static double tf_signed_distance(double x, int l) {
#if TF_HAS_DOMAIN
    const double below = tf_domain_lower[l] - x, above = x - tf_domain_upper[l];
    const double outside = below > above ? below : above;
    if (outside < -DBL_MAX) return -DBL_MAX; /* no range was recorded for this load */
    return tf_limit(outside / tf_domain_scale[l], -DBL_MAX, DBL_MAX);
#else
    (void)x; (void)l;
    return -1.0;
#endif
}

/* Largest exceedance of the trained domain over the loads, 0 inside; *load (may be NULL) is where it is found. */
TF_UNUSED static double tf_loads_distance(const double *loads, int *load) {
    double largest = 0.0;
    for (int l = 0; l < TF_LOADS; ++l) {
        const double d = tf_signed_distance(loads[l], l);
        if (d > largest) {
            largest = d;
            if (load) *load = l;
        }
    }
    return largest;
}

/* mu is never negative; a result that is no finite number becomes 0 and is refused (returns 0). */
TF_UNUSED static int tf_mu_rule(double *mu) {
    if (!isfinite(*mu)) {
        *mu = 0.0;
        return 0;
    }
    if (!(*mu > 0.0)) *mu = 0.0;
    return 1;
}
