// SPDX-License-Identifier: BSD-3-Clause
// Which samples the taps of positions are.
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "passes/separable/separable_impl.h"

enum weft_result weft_separable_taps_create(const struct weft_log *log,
                                            const struct weft_separable_axis *axis,
                                            struct weft_separable_taps *out)
{
    const size_t taps = (size_t)axis->span;
    *out = (struct weft_separable_taps){
        .sample = malloc(taps * sizeof *out->sample),
        .place = malloc(taps * sizeof *out->place),
    };
    if (out->sample && out->place)
        return WEFT_OK;
    weft_error(log, "not enough memory for the taps of %d pixels and %d samples", axis->positions,
               axis->size);
    weft_separable_taps_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_separable_taps_destroy(struct weft_separable_taps *taps)
{
    free(taps->sample);
    free(taps->place);
    *taps = (struct weft_separable_taps){0};
}

// From the first tap of positions `from` to `to`, exclusive, to past their last one.
static void find_ends(const struct weft_separable_axis *axis, int from, int to, int32_t ends[2])
{
    ends[0] = INT32_MAX;
    ends[1] = INT32_MIN;
    for (int i = from; i < to; i++) {
        ends[0] = axis->first[i] < ends[0] ? axis->first[i] : ends[0];
        ends[1] = axis->first[i] > ends[1] ? axis->first[i] : ends[1];
    }
    ends[1] += axis->width;
}

void weft_separable_taps_number(const struct weft_separable_axis *axis, int from, int to,
                                struct weft_separable_taps *taps)
{
    int32_t ends[2];
    find_ends(axis, from, to, ends);
    int32_t *place = taps->place - axis->low; // of tap 0
    for (int32_t tap = ends[0]; tap < ends[1]; tap++)
        place[tap] = 0;
    for (int i = from; i < to; i++)
        place[axis->first[i]] = 1;
    taps->count = 0;
    int left = 0; // taps that a position before needs
    for (int32_t tap = ends[0]; tap < ends[1]; tap++) {
        left = place[tap] ? axis->width : left - 1;
        place[tap] = taps->count;
        if (left > 0)
            taps->sample[taps->count++] =
                (int32_t)weft_boundary_index(axis->boundary, tap, axis->size);
    }
}

int weft_separable_most_taps(const struct weft_separable_axis *axis, int cut,
                             struct weft_separable_taps *taps)
{
    int most = 0;
    for (int from = 0; from < axis->positions; from += cut) {
        const int left = axis->positions - from;
        weft_separable_taps_number(axis, from, from + (left < cut ? left : cut), taps);
        most = taps->count > most ? taps->count : most;
    }
    return most;
}

float weft_separable_single_weight(bool skips_zeros, double weight)
{
    const bool vanishes = fabs(weight) < FLT_MIN && weight != 0.0;
    return skips_zeros && vanishes ? (float)copysign(FLT_MIN, weight) : (float)weight;
}

// ---- what a part reads --------------------------------------------------------------------------

static void add_to_reach(int64_t sample, int reach[2])
{
    if (sample < 0) // the border's value
        return;
    reach[0] = sample < reach[0] ? (int)sample : reach[0];
    reach[1] = sample > reach[1] ? (int)sample : reach[1];
}

// Taps from the first to the last one; where all are the border's the first sample alone.
void weft_separable_axis_reach(const struct weft_separable_axis *axis, int from, int to,
                               int reach[2])
{
    const int32_t size = axis->size;
    int32_t ends[2];
    find_ends(axis, from, to, ends);
    reach[0] = INT32_MAX;
    reach[1] = -1;
    for (int32_t tap = ends[0]; tap < ends[1]; tap++) {
        if (tap > 0 && tap < size - 1 && tap < ends[1] - 1 && tap > ends[0])
            tap = (size - 1 < ends[1] - 1 ? size - 1 : ends[1] - 1) - 1; // none of these is an end
        else
            add_to_reach(weft_boundary_index(axis->boundary, tap, size), reach);
    }
    if (reach[1] < 0)
        reach[0] = reach[1] = 0;
}

struct weft_rectangle weft_separable_reach(const weft_separable_plan *plan,
                                           const struct weft_rectangle *part)
{
    struct weft_rectangle pixels;
    int x[2], y[2];
    if (weft_rectangle_within(NULL, part, plan->info.width, plan->info.height, &pixels) != WEFT_OK)
        return (struct weft_rectangle){0};
    weft_separable_axis_reach(&plan->axis[0], pixels.x, pixels.x + pixels.width, x);
    weft_separable_axis_reach(&plan->axis[1], pixels.y, pixels.y + pixels.height, y);
    return (struct weft_rectangle){x[0], y[0], x[1] - x[0] + 1, y[1] - y[0] + 1};
}
