/* What a Windows library needs around the generated C, linked in place of the start-up code and the C
 * library of a compiler: functions come from ucrtbase.dll, which every Windows 10 carries. This keeps a
 * library small, and free of code that nobody here wrote or tested.
 */
#include <stdarg.h>
#include <stddef.h>

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved);
__declspec(dllimport) int __stdio_common_vsprintf(unsigned long long options, char *out, size_t size,
                                                  const char *format, void *locale, va_list arguments);
int vsnprintf(char *out, size_t size, const char *format, va_list arguments);
int snprintf(char *out, size_t size, const char *format, ...);
int __isnan(double x);
int __fpclassify(double x);
double sin(double x);
double cos(double x);
void sincos(double x, double *sine, double *cosine);

/* The compiler refers to it from every file with floating-point numbers. */
int _fltused = 0;

/* There is nothing to start: no constructors, no thread-local storage. */
int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void)library;
    (void)reason;
    (void)reserved;
    return 1;
}

/* The runtime has these two only as inline functions of its headers. Option 2: behave as C99 does. */
int vsnprintf(char *out, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(2ULL, out, size, format, NULL, arguments);
}

int snprintf(char *out, size_t size, const char *format, ...)
{
    va_list arguments;
    int length;
    va_start(arguments, format);
    length = vsnprintf(out, size, format, arguments);
    va_end(arguments);
    return length;
}

/* Behind the macros isnan, isfinite and fpclassify of math.h, with its numbers. */
int __isnan(double x)
{
    return x != x;
}

int __fpclassify(double x)
{
    if (x != x) return 0x0100;
    if (x - x != 0.0) return 0x0500;
    if (x == 0.0) return 0x4000;
    return x < 0x1p-1022 && x > -0x1p-1022 ? 0x4400 : 0x0400;
}

/* Compilers make one call of sin and cos of the same value; the runtime does not have it. */
void sincos(double x, double *sine, double *cosine)
{
    *sine = sin(x);
    *cosine = cos(x);
}

/* Functions with more than a page of local variables call this to touch their stack page by page, as
 * Windows asks for; rax holds the bytes, and every register is kept.
 */
#if defined __x86_64__
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "\tpushq %rcx\n"
        "\tpushq %rax\n"
        "\tleaq 24(%rsp), %rcx\n"
        "1:\n"
        "\tcmpq $0x1000, %rax\n"
        "\tjbe 2f\n"
        "\tsubq $0x1000, %rcx\n"
        "\ttestq %rcx, (%rcx)\n"
        "\tsubq $0x1000, %rax\n"
        "\tjmp 1b\n"
        "2:\n"
        "\tsubq %rax, %rcx\n"
        "\ttestq %rcx, (%rcx)\n"
        "\tpopq %rax\n"
        "\tpopq %rcx\n"
        "\tretq\n");
#endif
