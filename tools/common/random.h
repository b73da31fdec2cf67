// SPDX-License-Identifier: BSD-3-Clause
// tools/common/random.h - random numbers, the same on every machine: SplitMix64 (Steele, Lea and
// Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
#ifndef WEFT_TOOLS_COMMON_RANDOM_H
#define WEFT_TOOLS_COMMON_RANDOM_H

#include <stdint.h>

// The next number; *state is the seed at first.
uint64_t random_next(uint64_t *state);
// The next one in [0, 1), of 53 bits.
double random_unit(uint64_t *state);
// The n-th one after a seed, from 0, in [0, 1).
double random_unit_at(uint64_t seed, uint64_t n);

#endif
