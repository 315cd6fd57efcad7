/* Included before every file of an FMU's sources/: allocations that can be made to fail, and are counted. */
#ifndef STARVING_H
#define STARVING_H
#include <stdlib.h>
#include <string.h>

void *fuzz_allocate(void *old, size_t count, size_t size, int clear);
void fuzz_free(void *block);

#ifndef STARVING_HOST
#define malloc(n) fuzz_allocate(NULL, 1, n, 0)
#define calloc(n, size) fuzz_allocate(NULL, n, size, 1)
#define realloc(p, n) fuzz_allocate(p, 1, n, 0)
#define free(p) fuzz_free(p)
#endif
#endif
