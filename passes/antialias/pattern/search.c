// SPDX-License-Identifier: BSD-3-Clause
// The search for moves. It starts from the best of a family of lattices, over the whole pixel and
// over as small a part of it as each of the device's samples has for itself, and then moves one
// pass at a time, as long as the discrepancy falls. What it takes grows as the square of the
// samples, so that more samples are given fewer tries.
#include "passes/antialias/pattern/search.h"

#include <math.h>
#include <string.h>

#include "passes/jitter/discrepancy_impl.h"

// Discrepancies that differ by less are the same: which of two is found must not hang on rounding.
static const double same = 1e-9;

// Of the search after the lattices: tries times samples squared.
enum { WORK = 1 << 16, MOVES = WEFT_PATTERN_MAX };

struct search {
    const double (*device)[2];
    int device_count, passes;
    struct weft_pattern pattern; // that is looked at
    struct weft_discrepancy_event events[WEFT_PATTERN_MAX];
    uint8_t best[MOVES][2];
    double value; // of the best
};

void weft_pattern_place(const double (*device)[2], int device_count, int passes,
                        const uint8_t (*moves)[2], struct weft_pattern *out)
{
    out->count = passes * device_count;
    out->passes = passes;
    out->device_count = device_count;
    for (int pass = 0; pass < passes; pass++)
        for (int axis = 0; axis < 2; axis++) {
            const double move = (double)moves[pass][axis] / WEFT_PATTERN_PARTS;
            out->offset[pass][axis] = move;
            for (int i = 0; i < device_count; i++) {
                const int sample = pass * device_count + i;
                const double p = device[i][axis] + move;
                const bool leaves = move > 0.0 && p >= 0.5;
                out->pixel[sample][axis] = leaves;
                out->position[sample][axis] = leaves ? p - 1.0 : p;
            }
        }
}

// Keeps moves that are better than the best so far.
static bool try(struct search *s, const uint8_t (*moves)[2])
{
    weft_pattern_place(s->device, s->device_count, s->passes, moves, &s->pattern);
    const double value =
        weft_discrepancy_find(
            weft_discrepancy_params(.points = (const double(*)[2])s->pattern.position,
                                    .count = s->pattern.count),
            s->events)
            .value;
    if (!(value < s->value - same))
        return false;
    s->value = value;
    memcpy(s->best, moves, sizeof s->best);
    return true;
}

// Parts of a pixel, whichever pixel it is.
static uint8_t part_of(double move)
{
    return (uint8_t)(llrint(move * WEFT_PATTERN_PARTS) & (WEFT_PATTERN_PARTS - 1));
}

// Points (i, step i mod passes) / passes of a square of side `size` about the middle.
static void try_lattice(struct search *s, int step, double size)
{
    uint8_t moves[MOVES][2] = {{0, 0}};
    for (int i = 0; i < s->passes; i++) {
        const int place[2] = {i, step * i % s->passes};
        for (int axis = 0; axis < 2; axis++)
            moves[i][axis] = part_of(size * ((place[axis] + 0.5) / s->passes - 0.5));
    }
    try(s, (const uint8_t(*)[2])moves);
}

static uint32_t random_below(uint64_t *state, uint32_t limit)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((*state >> 33) % limit);
}

// One pass, anywhere or near where it was.
static void try_move(struct search *s, uint64_t *state)
{
    uint8_t moves[MOVES][2];
    memcpy(moves, s->best, sizeof moves);
    const uint32_t pass = random_below(state, (uint32_t)s->passes);
    const uint32_t reach = random_below(state, 2) ? 12 : WEFT_PATTERN_PARTS / 2;
    for (int axis = 0; axis < 2; axis++)
        moves[pass][axis] = (uint8_t)(moves[pass][axis] + random_below(state, 2 * reach) - reach);
    try(s, (const uint8_t(*)[2])moves);
}

void weft_pattern_search(const double (*device)[2], int device_count, int passes,
                         uint8_t (*moves)[2])
{
    struct search s = {
        .device = device, .device_count = device_count, .passes = passes, .value = INFINITY};
    const int samples = passes * device_count;
    const int tries = WORK / (samples * samples), steps = passes < 16 ? passes : 16;
    uint64_t state = 1;
    for (int step = 1; step < steps; step++) {
        try_lattice(&s, step, 1.0);
        try_lattice(&s, step, 1.0 / sqrt(device_count));
    }
    for (int i = 0; i < tries; i++)
        try_move(&s, &state);
    memcpy(moves, s.best, (size_t)passes * sizeof *moves);
}
