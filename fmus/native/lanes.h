/* Two builds of the same kernels: one for every processor, one for AVX2 + FMA, chosen once by the processor.
   Every kernel is one inlined body with the constant argument `fused`; the wide build passes 1 and is compiled
   with the wider instructions. Multiplication and addition are fused only where TF_FMA says so, in the same way
   for one point as for a block of points: a point has the same value alone and anywhere in a block. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#define TF_UNUSED __attribute__((unused)) /* a program need not use everything */
#else
#define TF_UNUSED
#endif

#if defined(__GNUC__) && !defined(TF_PLAIN_ONLY) /* TF_PLAIN_ONLY: the language standard and nothing else */
#define TF_ALIGNED __attribute__((aligned(64)))
#define TF_INLINE TF_UNUSED static inline __attribute__((always_inline))
#define TF_APART TF_UNUSED static __attribute__((noinline))
#define TF_FMA(a, b, c) (fused ? __builtin_fma(a, b, c) : (a) * (b) + (c))
#else
#define TF_ALIGNED
#define TF_INLINE TF_UNUSED static
#define TF_APART TF_UNUSED static
#define TF_FMA(a, b, c) ((void)fused, (a) * (b) + (c))
#endif

#if defined(__GNUC__) && defined(__x86_64__) && !defined(TF_PLAIN_ONLY)
#define TF_WIDE_BUILD 1
#define TF_WIDE TF_APART __attribute__((target("avx2,fma")))
#define TF_INLINE_WIDE TF_INLINE __attribute__((target("avx2,fma")))

/* AVX2, FMA, and an operating system that saves the wide registers. */
static int tf_detect(void) {
    unsigned a, b, c, d;
    __asm__ volatile("cpuid" : "=a"(a), "=b"(b), "=c"(c), "=d"(d) : "a"(0), "c"(0));
    if (a < 7) return 0;
    __asm__ volatile("cpuid" : "=a"(a), "=b"(b), "=c"(c), "=d"(d) : "a"(1), "c"(0));
    const unsigned fma_osxsave_avx = 1u << 12 | 1u << 27 | 1u << 28;
    if ((c & fma_osxsave_avx) != fma_osxsave_avx) return 0;
    __asm__ volatile("cpuid" : "=a"(a), "=b"(b), "=c"(c), "=d"(d) : "a"(7), "c"(0));
    if (!(b & 1u << 5)) return 0;
    __asm__ volatile(".byte 0x0f, 0x01, 0xd0" /* xgetbv */ : "=a"(a), "=d"(d) : "c"(0));
    return (a & 6u) == 6u;
}

static int tf_wide(void) {
    static int known; /* 0: not asked yet; threads that ask at the same time write the same answer */
    int answer = __atomic_load_n(&known, __ATOMIC_RELAXED);
    if (!answer) {
        answer = tf_detect() ? 2 : 1;
        __atomic_store_n(&known, answer, __ATOMIC_RELAXED);
    }
    return answer == 2;
}
#else
#define TF_WIDE_BUILD 0
#define TF_WIDE TF_APART
static int tf_wide(void) { return 0; }
#endif
