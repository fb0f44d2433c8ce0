/* Cases by the million, made and hashed where they run: two builds that agree on every block's hash agree on every case.
 *
 * Block b of a function is the same everywhere: legal raws mostly, now and then anything that the C type holds. Where a
 * function has few legal inputs and no list, the first blocks hold each of them once instead, in an order that is spread
 * over all of them.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "batches.h"

static uint64_t next(uint64_t *state)
{
    /* xorshift64*, Vigna 2016 */
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * UINT64_C(2685821657736338717);
}

static void put(void *array, size_t index, size_t bytes, int64_t value)
{
    if (bytes == 1) {
        ((uint8_t *)array)[index] = (uint8_t)value;
    } else if (bytes == 2) {
        ((uint16_t *)array)[index] = (uint16_t)value;
    } else {
        ((uint32_t *)array)[index] = (uint32_t)value;
    }
}

/* Legal inputs that are tried one by one, at most; and a prime by which their order is spread. */
#define EVERY UINT64_C(9961472)
#define SPREAD UINT64_C(1000000007)

/* How many legal inputs there are; EVERY where there are as many or more, or lists. */
static uint64_t inputs(const fuzzycharness_shape *shape)
{
    uint64_t many = 1;
    size_t k;
    for (k = 0; k < shape->ins; ++k) {
        const fuzzycharness_slot *const slot = &shape->slots[k];
        if (slot->list >= 0) {
            return EVERY;
        }
        if (!slot->state) {
            many *= (uint64_t)(slot->hi - slot->lo + 1);
            if (many >= EVERY) {
                return EVERY;
            }
        }
    }
    return many;
}

static int64_t draw(const fuzzycharness_slot *slot, size_t width, uint64_t *state)
{
    const uint64_t r = next(state);
    const int wild = (r & 31u) == 0 && !slot->state;
    int64_t low = wild ? slot->low : slot->lo;
    int64_t high = wild ? slot->high : slot->hi;
    if (slot->count) {
        /* A count beyond the records is fine only where the capacity is what stops the reading. */
        low = 0;
        high = wild && (int64_t)width >= slot->hi ? slot->high : (int64_t)width;
    }
    return low + (int64_t)(((r >> 32) * (uint64_t)(high - low + 1)) >> 32);
}

/* Widths of a block: two elements mostly, among which one element's fault shows; the whole capacity now and then. */
void fuzzycharness_widths(size_t function, uint64_t block, size_t *widths)
{
    const fuzzycharness_shape *const shape = &fuzzycharness_shapes[function];
    size_t k;
    for (k = 0; k < shape->lists; ++k) {
        const size_t capacity = shape->capacities[k];
        widths[k] = (block & 7u) == 7u || capacity < 2 ? capacity : 2;
    }
}

void fuzzycharness_draw(size_t function, uint64_t seed, uint64_t block, size_t n, const size_t *widths, void *const *in)
{
    const fuzzycharness_shape *const shape = &fuzzycharness_shapes[function];
    uint64_t state = (seed + 1u) * UINT64_C(0x9E3779B97F4A7C15) ^ (block + 1u) * UINT64_C(0xD1B54A32D192ED03);
    const uint64_t many = inputs(shape);
    const uint64_t first = block * n;
    uint64_t below = 1;
    size_t k, i;
    if (state == 0) {
        state = 1;
    }
    for (k = 0; k < shape->ins; ++k) {
        const fuzzycharness_slot *const slot = &shape->slots[k];
        const uint64_t legal = (uint64_t)(slot->hi - slot->lo + 1);
        const size_t width = slot->list < 0 ? 1 : widths[slot->list];
        const size_t values = n * (slot->count ? 1 : width);
        for (i = 0; i < values; ++i) {
            int64_t value = draw(slot, width, &state);
            if (many < EVERY && !slot->state && first + i < many) {
                value = slot->lo + (int64_t)((first + i) * SPREAD % many / below % legal);
            }
            put(in[k], i, slot->bytes, value);
        }
        below *= slot->state || many >= EVERY ? 1 : legal;
    }
}

static uint64_t hashed(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    size_t at;
    for (at = 0; at < size; at += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + at, size - at < 8 ? size - at : 8);
        hash = (hash ^ word) * UINT64_C(0x9FB21C651E98DF25);
        hash ^= hash >> 32;
    }
    return hash;
}

/* Hash of one block's results; *failed is set where there is no memory. */
uint64_t fuzzycharness_hash(size_t function, uint64_t seed, uint64_t block, size_t n, volatile uint64_t *at, int *failed)
{
    const fuzzycharness_shape *const shape = &fuzzycharness_shapes[function];
    const size_t many = shape->ins + shape->outs;
    void **const arrays = calloc(many, sizeof *arrays);
    size_t *const sizes = calloc(many, sizeof *sizes);
    size_t *const widths = calloc(shape->lists + 1, sizeof *widths);
    uint64_t hash = 0;
    size_t k;

    *failed = arrays == NULL || sizes == NULL || widths == NULL;
    if (!*failed) {
        fuzzycharness_widths(function, block, widths);
    }
    for (k = 0; k < many && !*failed; ++k) {
        const fuzzycharness_slot *const slot = &shape->slots[k];
        sizes[k] = n * slot->bytes * (slot->list < 0 || slot->count ? 1 : widths[slot->list]);
        arrays[k] = malloc(sizes[k] + 1);
        *failed = arrays[k] == NULL;
    }
    if (!*failed) {
        fuzzycharness_draw(function, seed, block, n, widths, arrays);
        *failed = fuzzycharness_batches[function](n, widths, (const void *const *)arrays, arrays + shape->ins, at);
        for (k = shape->ins; k < many; ++k) {
            hash = hashed(hash, arrays[k], sizes[k]);
        }
    }
    for (k = 0; k < many && arrays != NULL; ++k) {
        free(arrays[k]);
    }
    free(arrays);
    free(sizes);
    free(widths);
    return hash;
}
