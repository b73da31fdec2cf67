// SPDX-License-Identifier: BSD-3-Clause
// The search for moves: from the best of some sets of samples, and then from random ones, one pass
// is moved at a time and stays where the discrepancy falls. Steps of all sizes are needed, as edges
// change both with single samples and with all.
#include "passes/antialias/pattern/search.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"
#include "passes/jitter/discrepancy_impl.h"

// Discrepancies that differ by less are the same: which of two is found must not hang on rounding.
static const double same = 1e-9;

enum { MOVES = WEFT_PATTERN_MAX };

struct search {
    const struct weft_pattern_search *params;
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
    const struct weft_pattern_search *p = s->params;
    weft_pattern_place(p->device, p->device_count, p->passes, moves, &s->pattern);
    const double value =
        weft_discrepancy_find(
            weft_discrepancy_params(.points = (const double(*)[2])s->pattern.position,
                                    .count = s->pattern.count),
            s->events, s->value - same)
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

// A set of samples as moves: over the whole pixel, or over as small a part of it as each of the
// device's samples has for itself, centred so.
static void try_set(struct search *s, const char *name, double size)
{
    const struct weft_jitter_info *info = weft_jitter_find(name);
    double points[MOVES][2];
    uint8_t moves[MOVES][2] = {{0, 0}};
    info->compute(info, s->params->passes, 0, points);
    for (int i = 0; i < s->params->passes; i++)
        for (int axis = 0; axis < 2; axis++)
            moves[i][axis] = part_of(size * points[i][axis]);
    try(s, (const uint8_t(*)[2])moves);
}

static uint32_t random_below(uint64_t *state, uint32_t limit)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((*state >> 33) % limit);
}

static void try_random(struct search *s, uint64_t *state)
{
    uint8_t moves[MOVES][2] = {{0, 0}};
    for (int i = 0; i < s->params->passes; i++)
        for (int axis = 0; axis < 2; axis++)
            moves[i][axis] = (uint8_t)random_below(state, WEFT_PATTERN_PARTS);
    try(s, (const uint8_t(*)[2])moves);
}

// One pass, near where it was, less near or anywhere.
static void try_move(struct search *s, uint64_t *state)
{
    static const uint32_t reaches[] = {2, 8, 32, 128};
    uint8_t moves[MOVES][2];
    memcpy(moves, s->best, sizeof moves);
    const uint32_t pass = random_below(state, (uint32_t)s->params->passes);
    const uint32_t reach = reaches[random_below(state, WEFT_COUNT(reaches))];
    for (int axis = 0; axis < 2; axis++)
        moves[pass][axis] =
            (uint8_t)(moves[pass][axis] + random_below(state, 2 * reach + 1) - reach);
    try(s, (const uint8_t(*)[2])moves);
}

double weft_pattern_search(const struct weft_pattern_search *params, uint8_t (*moves)[2])
{
    static const char *const sets[] = {"grid", "hammersley", "sobol", "r2"};
    struct search s = {.params = params};
    double least = INFINITY;
    for (int start = 0; start < params->starts; start++) {
        uint64_t state = (uint64_t)start;
        s.value = INFINITY;
        for (size_t i = 0; start == 0 && i < WEFT_COUNT(sets); i++) {
            try_set(&s, sets[i], 1.0);
            try_set(&s, sets[i], 1.0 / sqrt(params->device_count));
        }
        if (start > 0)
            try_random(&s, &state);
        for (int i = 0; i < params->tries; i++)
            try_move(&s, &state);
        if (s.value < least - same)
            memcpy(moves, s.best, (size_t)params->passes * sizeof *moves);
        least = s.value < least - same ? s.value : least;
    }
    return least;
}
