/* Runs a build over verify's batches, whose results are known: judge FILE SECONDS [FUNCTION ...]
 *
 * FILE: uint64 words - number of batches, then for each batch: function, n, number of lists, of arrays in, of arrays
 * out, each list's width, each array's size in bytes (in, then what has to come out) - and the arrays, each padded to
 * whole words; then for each function the number of its blocks, their seed, n, and the hash of each. The functions named
 * come first. Ends with 0 where nothing differs, 10 where the self-test fails, 11 where a case differs, 12 where a hash
 * does; by a signal where the C crashes, or takes longer than SECONDS for a batch.
 */
#define _POSIX_C_SOURCE 200112L
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include "batches.h"

enum { MOST = 64, FEW = 256 };

static unsigned seconds;

typedef struct {
    size_t function, n, lists, ins, outs;
    size_t widths[MOST], sizes[MOST];
    void *arrays[MOST];
} batch;

/* The first n cases: 1 where any comes out otherwise. */
static int differs(const batch *b, size_t n)
{
    void *outs[MOST];
    uint64_t at;
    size_t k;
    int found = 0;

    if (n == 0) {
        return 0;
    }
    for (k = 0; k < b->outs; ++k) {
        outs[k] = calloc(1, b->sizes[b->ins + k]);
        if (outs[k] == NULL) {
            exit(3);
        }
    }
    alarm(seconds);
    if (fuzzycharness_batches[b->function](n, b->widths, (const void *const *)b->arrays, outs, &at) != 0) {
        exit(3);
    }
    alarm(0);
    for (k = 0; k < b->outs; ++k) {
        found |= memcmp(outs[k], b->arrays[b->ins + k], b->sizes[b->ins + k] / b->n * n) != 0;
        free(outs[k]);
    }
    return found;
}

int main(int argc, char **argv)
{
    const int file = argc < 3 ? -1 : open(argv[1], O_RDONLY);
    struct stat about;
    uint64_t *word, *first;
    batch *all;
    size_t many, i, k, round;
    int a;

    if (file < 0 || fstat(file, &about) != 0) {
        return 3;
    }
    word = mmap(NULL, (size_t)about.st_size, PROT_READ | PROT_WRITE, MAP_PRIVATE, file, 0);
    if (word == MAP_FAILED) {
        return 3;
    }
    seconds = (unsigned)strtoul(argv[2], NULL, 10);
    alarm(seconds);
    if (fuzzycharness_selftest() != 0) {
        return 10;
    }
    alarm(0);
    first = word + 1;
    many = (size_t)*word;
    all = calloc(many, sizeof *all);
    for (i = 0; i < many; ++i) {
        batch *const b = &all[i];
        b->function = (size_t)*first++;
        b->n = (size_t)*first++;
        b->lists = (size_t)*first++;
        b->ins = (size_t)*first++;
        b->outs = (size_t)*first++;
        if (b->lists > MOST || b->ins + b->outs > MOST) {
            return 3;
        }
        for (k = 0; k < b->lists; ++k) {
            b->widths[k] = (size_t)*first++;
        }
        for (k = 0; k < b->ins + b->outs; ++k) {
            b->sizes[k] = (size_t)*first++;
        }
        for (k = 0; k < b->ins + b->outs; ++k) {
            b->arrays[k] = first;
            first += (b->sizes[k] + 7) / 8;
        }
    }
    /* A few cases of every batch, then all; of the functions named, then of all. */
    for (round = 0; round < 2; ++round) {
        for (a = 3; a < argc; ++a) {
            for (i = 0; i < many; ++i) {
                if (all[i].function == strtoul(argv[a], NULL, 10) && differs(&all[i], round == 0 && all[i].n > FEW ? FEW : all[i].n)) {
                    return 11;
                }
            }
        }
    }
    for (i = 0; i < many; ++i) {
        if (differs(&all[i], all[i].n)) {
            return 11;
        }
    }
    for (i = 0; i < fuzzycharness_functions; ++i) {
        const size_t blocks = (size_t)first[0];
        const uint64_t seed = first[1];
        const size_t n = (size_t)first[2];
        first += 3;
        for (k = 0; k < blocks; ++k) {
            uint64_t at;
            int failed;
            alarm(seconds);
            if (fuzzycharness_hash(i, seed, k, n, &at, &failed) != first[k]) {
                return 12;
            }
        }
        first += blocks;
    }
    return 0;
}
