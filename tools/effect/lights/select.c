// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/lights/select.h"

#include <math.h>
#include <stdlib.h>

// ---- places -------------------------------------------------------------------------------------

enum { HILBERT_BITS = 16 };

// The number of a cell along the Hilbert curve through 2^16 cells along each axis (Skilling,
// "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004).
static uint64_t find_hilbert(uint32_t cell[3])
{
    const uint32_t top = UINT32_C(1) << (HILBERT_BITS - 1);
    for (uint32_t bit = top; bit > 1; bit >>= 1)
        for (int i = 0; i < 3; i++) {
            const uint32_t swapped = cell[i] & bit ? 0 : (cell[0] ^ cell[i]) & (bit - 1);
            cell[0] ^= cell[i] & bit ? bit - 1 : swapped;
            cell[i] ^= swapped;
        }
    uint32_t turned = 0;
    for (int i = 1; i < 3; i++)
        cell[i] ^= cell[i - 1];
    for (uint32_t bit = top; bit > 1; bit >>= 1)
        turned ^= cell[2] & bit ? bit - 1 : 0;
    uint64_t number = 0;
    for (int bit = HILBERT_BITS - 1; bit >= 0; bit--)
        for (int i = 0; i < 3; i++)
            number = number << 1 | ((cell[i] ^ turned) >> bit & 1);
    return number;
}

// Which of six sides a normal points to most; none: 6.
static uint64_t find_side(const double normal[3])
{
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(normal[i]) > fabs(normal[axis]))
            axis = i;
    if (normal[axis] == 0.0)
        return 6;
    return 2 * (uint64_t)axis + (normal[axis] > 0.0);
}

void select_find_places(struct virtual_light *lights, int64_t count)
{
    double low[3], high[3];
    for (int i = 0; i < 3; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
        for (int64_t k = 0; k < count; k++) {
            low[i] = fmin(low[i], lights[k].light.position[i]);
            high[i] = fmax(high[i], lights[k].light.position[i]);
        }
    }
    // The same unit along all axes, so that near places are near.
    const double size = fmax(fmax(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    const double cells = (1 << HILBERT_BITS) - 1;
    for (int64_t k = 0; k < count; k++) {
        uint32_t cell[3] = {0, 0, 0};
        for (int i = 0; i < 3 && size > 0.0; i++)
            cell[i] = (uint32_t)((lights[k].light.position[i] - low[i]) / size * cells);
        lights[k].place =
            find_side(lights[k].light.normal) << 3 * HILBERT_BITS | find_hilbert(cell);
    }
}

// ---- choosing -----------------------------------------------------------------------------------

// Of two in one place the one that appears earlier is first.
static int compare(const void *a, const void *b)
{
    const struct virtual_light *first = a, *second = b;
    if (first->place != second->place)
        return first->place < second->place ? -1 : 1;
    if (first->paths != second->paths)
        return first->paths < second->paths ? -1 : 1;
    return first->bounce - second->bounce;
}

// Where the i-th of `count` numbers is when they are sorted by their radical inverses in base 2:
// how many of the others have a lesser one.
static int64_t find_turn(int64_t i, int64_t count)
{
    int64_t before = 0;
    // Those that agree with i in the lower bits, and have 0 where i has 1, bit by bit upwards.
    for (int64_t bit = 1; bit < count; bit <<= 1)
        if (i & bit) {
            const int64_t first = i & (bit - 1);
            before += (count - 1 - first) / (2 * bit) + 1;
        }
    return before;
}

void select_lights(struct virtual_light *lights, int64_t count, double offset, int64_t wanted,
                   struct scene_point_light *out)
{
    qsort(lights, (size_t)count, sizeof *lights, compare);
    double all = 0.0, reached = 0.0;
    for (int64_t k = 0; k < count; k++)
        all += lights[k].weight;
    int64_t i = 0;
    for (int64_t k = 0; k < count; k++) {
        reached += lights[k].weight;
        // Both sums are the same: all that are wanted are found.
        for (; i < wanted && lights[k].weight > 0.0 &&
               fmin(((double)i + offset) / (double)wanted, 1.0 - 1e-12) * all < reached;
             i++) {
            struct scene_point_light *light = &out[find_turn(i, wanted)];
            *light = lights[k].light;
            for (int c = 0; c < 3; c++)
                light->intensity[c] *= all / lights[k].weight;
        }
    }
}
