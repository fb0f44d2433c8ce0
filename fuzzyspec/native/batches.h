/* What a generated harness offers: each function of the module over arrays, and what these arrays hold. */
#ifndef FUZZYCHARNESS_BATCHES_H
#define FUZZYCHARNESS_BATCHES_H

#include <stddef.h>
#include <stdint.h>

typedef int fuzzycharness_batch(
    size_t n, const size_t *widths, const void *const *in, void *const *out, volatile uint64_t *at);

/* One array. Legal raws lie in lo .. hi, the C type's values in low .. high; list is -1 outside of lists. */
typedef struct {
    unsigned char bytes;
    unsigned char count;
    unsigned char state;
    int list;
    int64_t lo, hi, low, high;
} fuzzycharness_slot;

/* Arrays in, then arrays out. */
typedef struct {
    size_t ins, outs, lists;
    const fuzzycharness_slot *slots;
    const size_t *capacities;
} fuzzycharness_shape;

extern const size_t fuzzycharness_functions;
extern fuzzycharness_batch *const fuzzycharness_batches[];
extern const fuzzycharness_shape fuzzycharness_shapes[];

unsigned fuzzycharness_selftest(void);

void fuzzycharness_widths(size_t function, uint64_t block, size_t *widths);
void fuzzycharness_draw(size_t function, uint64_t seed, uint64_t block, size_t n, const size_t *widths, void *const *in);
uint64_t fuzzycharness_hash(size_t function, uint64_t seed, uint64_t block, size_t n, volatile uint64_t *at, int *failed);

#endif
