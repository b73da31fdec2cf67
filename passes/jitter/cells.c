// SPDX-License-Identifier: BSD-3-Clause
// Cells of equal area that fill the square, and points in them.
#include <math.h>

#include "passes/jitter/sets.h"

struct cell {
    double low[2], size[2];
};

// Rows of the square that n cells of equal area stand in: as many as a row has cells, about.
static int count_rows(int count)
{
    return (int)lround(sqrt(count));
}

// Row r of R has the cells floor(r n / R) to floor((r + 1) n / R); its height is their share of n,
// so that all cells have the area 1 / n, and their middles the mean of the square.
static struct cell find_cell(int count, int rows, int row, int at)
{
    const int64_t from = (int64_t)row * count / rows, to = (int64_t)(row + 1) * count / rows;
    const double columns = (double)(to - from);
    return (struct cell){
        .low = {at / columns, (double)from / count},
        .size = {1.0 / columns, columns / count},
    };
}

// 53 bits of SplitMix64's n-th number (Steele, Lea and Flood, OOPSLA 2014), in [0, 1).
static double random_number(uint64_t seed, uint64_t n)
{
    uint64_t z = seed + (n + 1) * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static void fill(int count, bool at_random, uint64_t seed, double (*points)[2])
{
    const int rows = count_rows(count);
    int i = 0;
    for (int row = 0; row < rows; row++) {
        const int end = (int)((int64_t)(row + 1) * count / rows);
        for (int at = 0; i < end; at++, i++) {
            const struct cell cell = find_cell(count, rows, row, at);
            for (int axis = 0; axis < 2; axis++) {
                const uint64_t n = 2 * (uint64_t)i + (uint64_t)axis;
                const double within = at_random ? random_number(seed, n) : 0.5;
                points[i][axis] = cell.low[axis] + within * cell.size[axis] - 0.5;
            }
        }
    }
}

static void compute_grid(const struct weft_jitter_info *info, int count, uint64_t seed,
                         double (*points)[2])
{
    (void)info;
    fill(count, false, seed, points);
}

static void compute_stratified(const struct weft_jitter_info *info, int count, uint64_t seed,
                               double (*points)[2])
{
    (void)info;
    fill(count, true, seed, points);
}

const struct weft_jitter_info weft_jitter_grid = {
    .name = "grid",
    .description = "the middles of cells of equal area, k by k for k^2 points",
    .default_count = 16,
    .compute = compute_grid,
};

const struct weft_jitter_info weft_jitter_stratified = {
    .name = "stratified",
    .description = "a random point in each cell of the grid",
    .citation = "Cook, Porter and Carpenter, SIGGRAPH 1984; SplitMix64: Steele et al., OOPSLA 2014",
    .default_count = 16,
    .seeded = true,
    .compute = compute_stratified,
};
