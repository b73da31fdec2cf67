// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/counts.h - numbers of frames as benches take them: "8,64,1024".
#ifndef WEFT_TESTS_PEERS_COUNTS_H
#define WEFT_TESTS_PEERS_COUNTS_H

#include <stdint.h>
#include <stdlib.h>

enum { MAX_COUNTS = 16 };

// Returns how many there are; 0: not numbers from 1 to `most` with commas between them, or more
// than there is room for.
static inline int parse_counts(const char *text, int64_t most, int64_t out[MAX_COUNTS])
{
    int counts = 0;
    for (char *end; counts < MAX_COUNTS; text = end + 1) {
        const long long n = strtoll(text, &end, 10);
        if (end == text || n < 1 || n > most)
            return 0;
        out[counts++] = n;
        if (*end != ',')
            return *end ? 0 : counts;
    }
    return 0;
}

#endif
