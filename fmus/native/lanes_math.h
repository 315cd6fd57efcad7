/* exp, log, tanh and the logistic function, without branches and tables, so that compilers make vectors of them.
   At most 2 ulp from the exact value in both builds (measured: exp 0.9, log 0.9, tanh 1.5, sigmoid 1.8); zeros,
   infinities, NaN, overflow and subnormal numbers as in the C library. The polynomials are minimax fits by the
   Remez algorithm; tests/fmus/remez.py computes them anew and the tests compare. */

#define TF_SHIFT 0x1.8p52 /* adding it rounds to an integer, which is then found in the lowest bits */

TF_INLINE uint64_t tf_bits(double x) {
    uint64_t u;
    memcpy(&u, &x, sizeof u);
    return u;
}

TF_INLINE double tf_double(uint64_t u) {
    double x;
    memcpy(&x, &u, sizeof x);
    return x;
}

/* 2^k from k + TF_SHIFT, for a normal result. */
TF_INLINE double tf_power_of_two(double shifted) { return tf_double((tf_bits(shifted) + 1023) << 52); }

/* exp(x) = 2^k exp(r) with |r| <= ln(2)/2: give k and r, return exp(r) - 1 - r; the rounding error of r is in it. */
TF_INLINE double tf_exp_parts(double x, double *k, double *r, const int fused) {
    const double whole = TF_FMA(x, 0x1.71547652b82fep0, TF_SHIFT) - TF_SHIFT;
    const double first = TF_FMA(-whole, 0x1.62e42fefa3800p-1, x); /* ln(2) in two parts; this product is exact */
    const double rest = TF_FMA(-whole, 0x1.ef35793c76730p-45, first);
    const double error = TF_FMA(-whole, 0x1.ef35793c76730p-45, first - rest);
    const double square = rest * rest;
    double even = TF_FMA(0x1.1f8b3c311193bp-29, square, 0x1.27e4ccd8df555p-22);
    double odd = TF_FMA(0x1.af4de9eb12930p-26, square, 0x1.71de023165f8ap-19);
    even = TF_FMA(even, square, 0x1.a01a01acf5b14p-16);
    odd = TF_FMA(odd, square, 0x1.a01a01abe80a5p-13);
    even = TF_FMA(even, square, 0x1.6c16c16c1520cp-10);
    odd = TF_FMA(odd, square, 0x1.11111111100dcp-7);
    even = TF_FMA(even, square, 0x1.5555555555558p-5);
    odd = TF_FMA(odd, square, 0x1.5555555555557p-3);
    *k = whole;
    *r = rest;
    return TF_FMA(square, TF_FMA(TF_FMA(even, rest, odd), rest, 0.5), error);
}

TF_INLINE double tf_exp_body(double x, const int fused) {
    double y = x > 710.0 ? 710.0 : x, k, r; /* beyond: infinity and 0 come out all the same; NaN stays */
    y = y < -746.0 ? -746.0 : y;
    const double more = tf_exp_parts(y, &k, &r, fused);
    const double half = TF_FMA(k, 0.5, TF_SHIFT); /* two factors: k reaches beyond the normal exponents */
    return (1.0 + (r + more)) * tf_power_of_two(half) * tf_power_of_two((k - (half - TF_SHIFT)) + TF_SHIFT);
}

TF_INLINE double tf_tanh_body(double x, const int fused) {
    /* (e - 1)/(e + 1) with e = exp(2|x|); e - 1 as sum of two numbers, so that small x keep their digits. */
    double y = fabs(x), k, r;
    y = y > 20.0 ? 20.0 : y;
    const double more = tf_exp_parts(y + y, &k, &r, fused);
    const double scale = tf_power_of_two(k + TF_SHIFT), whole = scale - 1.0, part = scale * r;
    const double sum = whole + part;
    const double tail = TF_FMA(scale, more, part - (sum - whole));
    const double top = sum + tail, bottom = top + 2.0;
    const int small = top < 2.0;
    const double quotient = (small ? top : -2.0) / bottom; /* large: 1 - 2/(e + 1) */
    /* What rounding took from top and bottom; 1/bottom is (1 - tanh)/2. */
    const double lost = TF_FMA(-quotient, (2.0 - bottom) + top, (sum - top) + tail);
    const double repaired = quotient + lost * (small ? 0.5 - 0.5 * quotient : 0.0);
    return copysign((small ? 0.0 : 1.0) + repaired, x);
}

TF_INLINE double tf_sigmoid_body(double x, const int fused) {
    /* 1/(1 + exp(-x)), from the exponential that does not overflow. */
    const double e = tf_exp_body(-fabs(x), fused), bottom = 1.0 + e;
    const double quotient = (x < 0.0 ? e : 1.0) / bottom;
    const double inverse = x < 0.0 ? 1.0 - quotient : quotient;
    return quotient - quotient * ((1.0 - bottom) + e) * inverse;
}

TF_INLINE double tf_log_body(double x, const int fused) {
    /* x = 2^k (1 + f) with 1 + f from sqrt(1/2) to sqrt(2); log(1 + f) = 2 atanh(s), s = f/(2 + f). */
    const int tiny = x < 0x1p-1022;
    const uint64_t u = tf_bits(tiny ? x * 0x1p54 : x);
    const uint64_t exponent = (u - 0x3fe6a09e667f3bcdu + 0x3ff0000000000000u) >> 52;
    const double k = tf_double(exponent | 0x4330000000000000u) - 0x1p52 - (tiny ? 1077.0 : 1023.0);
    const double f = tf_double(u - (exponent << 52) + 0x3ff0000000000000u) - 1.0;
    const double s = f / (2.0 + f), z = s * s, w = z * z;
    const double odd = z * TF_FMA(w, TF_FMA(w, TF_FMA(w, 0x1.2b5fbf99bdf98p-3, 0x1.7462ba295f4f1p-3), 0x1.2492492e03e8ap-2), 0x1.5555555555558p-1);
    const double even = w * TF_FMA(w, TF_FMA(w, 0x1.39fdb92a21270p-3, 0x1.c71c62d037d4ep-3), 0x1.9999999995223p-2);
    const double square = 0.5 * f * f;
    const double small = square - TF_FMA(k, 0x1.a39ef35793c76p-33, s * (square + (odd + even)));
    double result = k * 0x1.62e42fee00000p-1 - (small - f);
    result = x < INFINITY ? result : x; /* infinity, NaN */
    result = x == 0.0 ? -INFINITY : result;
    return x < 0.0 ? NAN : result;
}

/* Each function for one number and for n numbers in place; the loops are what the compiler makes vectors of. */
#define TF_FUNCTION(name)                                                                                    \
    TF_WIDE double name##_wide(double x) { return name##_body(x, 1); }                                       \
    TF_APART double name##_plain(double x) { return name##_body(x, 0); }                                     \
    TF_INLINE double name(double x, const int fused) { return fused ? name##_wide(x) : name##_plain(x); }    \
    TF_WIDE void name##_wide_n(double *x, int n) {                                                           \
        for (int i = 0; i < n; ++i) x[i] = name##_body(x[i], 1);                                             \
    }                                                                                                        \
    TF_APART void name##_plain_n(double *x, int n) {                                                         \
        for (int i = 0; i < n; ++i) x[i] = name##_body(x[i], 0);                                             \
    }                                                                                                        \
    TF_INLINE void name##_n(double *x, int n, const int fused) {                                             \
        if (fused) name##_wide_n(x, n);                                                                      \
        else name##_plain_n(x, n);                                                                           \
    }
TF_FUNCTION(tf_exp)
TF_FUNCTION(tf_log)
TF_FUNCTION(tf_tanh)
TF_FUNCTION(tf_sigmoid)
