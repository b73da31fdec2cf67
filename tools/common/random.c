// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/random.h"

static const uint64_t step = UINT64_C(0x9e3779b97f4a7c15);

uint64_t random_next(uint64_t *state)
{
    uint64_t z = *state += step;
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

double random_unit(uint64_t *state)
{
    return (double)(random_next(state) >> 11) * 0x1p-53;
}

double random_unit_at(uint64_t seed, uint64_t n)
{
    uint64_t state = seed + n * step;
    return random_unit(&state);
}
