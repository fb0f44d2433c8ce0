/* Runs one batch from a file: cases in, results out, the running case's number in a mapped file.
 *
 *     runner CASES RESULTS PROGRESS
 *     runner --hash FUNCTION SEED FIRST LAST N PROGRESS      (of the blocks FIRST .. LAST - 1, a line each)
 *     runner --selftest
 *     runner --probe          (does nothing: can it be started at all?)
 *
 * CASES: uint64 words - function, n, number of lists, number of arrays in, number of arrays out - then each list's
 * width, each array's size in bytes (in, then out), then the arrays in. RESULTS: the arrays out, one after another.
 */
#ifndef _WIN32
#define _POSIX_C_SOURCE 200112L
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "batches.h"

static void fail(const char *why)
{
    fprintf(stderr, "runner: %s\n", why);
    exit(3);
}

static void *take(size_t size)
{
    void *const taken = malloc(size == 0 ? 1 : size);
    if (taken == NULL) {
        fail("out of memory");
    }
    return taken;
}

static void get(void *into, size_t size, FILE *from)
{
    if (size != 0 && fread(into, 1, size, from) != size) {
        fail("short case file");
    }
}

static uint64_t word(FILE *from)
{
    uint64_t value;
    get(&value, sizeof value, from);
    return value;
}

static volatile uint64_t *progress(const char *path)
{
#ifdef _WIN32
    static volatile uint64_t at;
    (void)path;
    return &at;
#else
    const int file = open(path, O_RDWR);
    void *at;
    if (file < 0) {
        fail("no progress file");
    }
    at = mmap(NULL, sizeof(uint64_t), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (at == MAP_FAILED) {
        fail("cannot map the progress file");
    }
    return (volatile uint64_t *)at;
#endif
}

static int hash_blocks(char **argv)
{
    const size_t function = (size_t)strtoul(argv[0], NULL, 10);
    const uint64_t seed = strtoull(argv[1], NULL, 10);
    const uint64_t last = strtoull(argv[3], NULL, 10);
    const size_t n = (size_t)strtoul(argv[4], NULL, 10);
    volatile uint64_t *const at = progress(argv[5]);
    uint64_t block;
    int failed;

    for (block = strtoull(argv[2], NULL, 10); block < last; ++block) {
        const uint64_t hash = fuzzycharness_hash(function, seed, block, n, at, &failed);
        if (failed) {
            fail("out of memory");
        }
        printf("%016llx\n", (unsigned long long)hash);
        fflush(stdout);
    }
    return 0;
}

int main(int argc, char **argv)
{
    FILE *file;
    size_t function, n, lists, ins, outs, k;
    size_t *widths, *sizes;
    void **arrays;

    if (argc == 2 && strcmp(argv[1], "--probe") == 0) {
        return 0;
    }
    if (argc == 2 && strcmp(argv[1], "--selftest") == 0) {
        printf("%u\n", fuzzycharness_selftest());
        return 0;
    }
    if (argc == 8 && strcmp(argv[1], "--hash") == 0) {
        return hash_blocks(argv + 2);
    }
    if (argc != 4) {
        fail("wrong arguments");
    }
    file = fopen(argv[1], "rb");
    if (file == NULL) {
        fail("no case file");
    }
    function = (size_t)word(file);
    n = (size_t)word(file);
    lists = (size_t)word(file);
    ins = (size_t)word(file);
    outs = (size_t)word(file);
    if (function >= fuzzycharness_functions) {
        fail("no such function");
    }
    widths = take(lists * sizeof *widths);
    sizes = take((ins + outs) * sizeof *sizes);
    arrays = take((ins + outs) * sizeof *arrays);
    for (k = 0; k < lists; ++k) {
        widths[k] = (size_t)word(file);
    }
    for (k = 0; k < ins + outs; ++k) {
        sizes[k] = (size_t)word(file);
    }
    for (k = 0; k < ins + outs; ++k) {
        arrays[k] = take(sizes[k]);
        if (k < ins) {
            get(arrays[k], sizes[k], file);
        }
    }
    fclose(file);
    if (fuzzycharness_batches[function](n, widths, (const void *const *)arrays, arrays + ins, progress(argv[3])) != 0) {
        fail("out of memory");
    }
    file = fopen(argv[2], "wb");
    if (file == NULL) {
        fail("cannot write the results");
    }
    for (k = ins; k < ins + outs; ++k) {
        if (sizes[k] != 0 && fwrite(arrays[k], 1, sizes[k], file) != sizes[k]) {
            fail("cannot write the results");
        }
        free(arrays[k]);
    }
    for (k = 0; k < ins; ++k) {
        free(arrays[k]);
    }
    free(arrays);
    free(sizes);
    free(widths);
    return fclose(file) == 0 ? 0 : 3;
}
