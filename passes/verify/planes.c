// SPDX-License-Identifier: BSD-3-Clause
#include "passes/verify/planes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "filter/kernels/prefilter.h"

static const double WEIGHTS_ERROR = 0x1p-32;

enum { KEPT_AXES = 1 << 13 };

// So many columns of samples are summed along y at once.
enum { STRIP = 16 };
struct strip {
    uint64_t row; // that it is made for
    double value[STRIP], depends[STRIP], reaches[STRIP], largest[STRIP];
    bool missing; // a sample is not finite
};

// Weights along x, as struct weft_prefilter_axis has them.
struct across {
    double at; // NAN: none
    int64_t first;
    int count;
};

struct weft_cardinal {
    struct weft_kernel kernel[2];
    struct weft_prefilter prefilter[2];
    int overlap[2], size[2], most; // weights along x
    const struct weft_verify_plane *planes;
    double whole; // largest sum of the plain kernels' |weights|
    double y;     // of the row
    uint64_t row; // counts rows, from 1 on
    struct weft_prefilter_axis down, scratch;
    size_t strip_count;    // of a channel
    struct strip *strips;  // [channel][x / STRIP]
    struct across *across; // by a hash of the position: neighbouring rows have the same
    double *weights;       // of each: `most` weights, then as many of `reach`
};

void weft_cardinal_destroy(weft_cardinal **cardinal)
{
    if (!cardinal || !*cardinal)
        return;
    free((*cardinal)->strips);
    free((*cardinal)->across);
    free((*cardinal)->weights);
    free(*cardinal);
    *cardinal = NULL;
}

static enum weft_result allocate(const struct weft_log *log, weft_cardinal *c, int channels)
{
    c->most = c->kernel[0].width + 2 * c->overlap[0];
    c->strip_count = ((size_t)c->size[0] + STRIP - 1) / STRIP;
    c->strips = calloc((size_t)channels * c->strip_count, sizeof *c->strips);
    c->across = malloc(KEPT_AXES * sizeof *c->across);
    c->weights = malloc((size_t)KEPT_AXES * 2 * (size_t)c->most * sizeof *c->weights);
    if (!c->strips || !c->across || !c->weights) {
        weft_error(log, "not enough memory to verify %d channels of %d x %d samples", channels,
                   c->size[0], c->size[1]);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < KEPT_AXES; i++)
        c->across[i].at = NAN;
    return WEFT_OK;
}

enum weft_result weft_cardinal_create(const struct weft_log *log,
                                      const struct weft_kernel kernel[2], int channels,
                                      const struct weft_verify_plane *planes, const int size[2],
                                      weft_cardinal **out)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    weft_cardinal *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c) {
        weft_error(log, "not enough memory to verify an image");
        goto fail;
    }
    *c = (weft_cardinal){.planes = planes, .whole = 1.0, .y = NAN};
    for (int a = 0; a < 2; a++) {
        struct weft_kernel plain = kernel[a];
        plain.prefiltered = false;
        res = weft_prefilter_compute(log, &kernel[a], &c->prefilter[a]);
        if (res != WEFT_OK)
            goto fail;
        c->kernel[a] = kernel[a];
        c->size[a] = size[a];
        c->overlap[a] = weft_prefilter_overlap(&c->prefilter[a], WEIGHTS_ERROR);
        c->whole *= weft_analysis_gain(&plain);
    }
    res = allocate(log, c, channels);
    if (res != WEFT_OK)
        goto fail;
    *out = c;
    return WEFT_OK;
fail:
    weft_cardinal_destroy(&c);
    return res;
}

double weft_cardinal_seconds(const weft_cardinal *c)
{
    return 4e-9 * (c->most + c->kernel[1].width + 2 * c->overlap[1]);
}

static void set_axis(const weft_cardinal *c, int a, double at, struct weft_prefilter_axis *out)
{
    weft_prefilter_axis_set(&c->prefilter[a], &c->kernel[a], c->overlap[a], at, 0, c->size[a] - 1,
                            out);
}

static size_t find_across(weft_cardinal *c, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const size_t i = (size_t)(bits * UINT64_C(0x9e3779b97f4a7c15) >> 51); // the topmost 13 bits
    struct across *across = &c->across[i];
    if (across->at == x)
        return i;
    double *weights = c->weights + i * 2 * (size_t)c->most;
    set_axis(c, 0, x, &c->scratch);
    *across = (struct across){.at = x, .first = c->scratch.first, .count = c->scratch.count};
    memcpy(weights, c->scratch.weight, (size_t)across->count * sizeof *weights);
    memcpy(weights + c->most, c->scratch.reach, (size_t)across->count * sizeof *weights);
    return i;
}

static void add_sample(struct strip *strip, int x, double sample, double weight, double reach)
{
    if (isfinite(sample)) {
        strip->value[x] += weight * sample;
        strip->largest[x] = fabs(sample) > strip->largest[x] ? fabs(sample) : strip->largest[x];
        return;
    }
    strip->missing = true;
    strip->depends[x] += fabs(weight);
    strip->reaches[x] += reach;
}

static const struct strip *find_strip(const weft_cardinal *c, int channel, size_t number)
{
    const struct weft_verify_plane *plane = &c->planes[channel];
    struct strip *strip = &c->strips[(size_t)channel * c->strip_count + number];
    const int64_t from = (int64_t)number * STRIP, left = c->size[0] - from;
    const int count = left < STRIP ? (int)left : STRIP;
    if (strip->row == c->row)
        return strip;
    *strip = (struct strip){.row = c->row};
    for (int k = 0; k < c->down.count; k++) {
        const int64_t at = (c->down.first + k) * plane->stride + from;
        for (int x = 0; x < count; x++)
            add_sample(strip, x, weft_verify_value(plane, at + x), c->down.weight[k],
                       c->down.reach[k]);
    }
    return strip;
}

struct sum {
    double value, depends, reaches, largest;
};

// Columns of a strip from `from` on, with their weights.
static void add_strip(struct sum *sum, const struct strip *strip, int from, int count,
                      const double *weight, const double *reach)
{
    for (int k = 0; k < count; k++) {
        const double largest = strip->largest[from + k];
        sum->value += weight[k] * strip->value[from + k];
        sum->largest = largest > sum->largest ? largest : sum->largest;
    }
    for (int k = 0; strip->missing && k < count; k++) {
        sum->depends += fabs(weight[k]) * strip->depends[from + k];
        sum->reaches += reach[k] * strip->reaches[from + k];
    }
}

struct weft_reference_value weft_cardinal_compute(weft_cardinal *c, int channel,
                                                  const double position[2], bool finite)
{
    const size_t i = find_across(c, position[0]);
    const double *weight = c->weights + i * 2 * (size_t)c->most, *reach = weight + c->most;
    struct sum sum = {0};
    if (c->y != position[1]) {
        c->y = position[1];
        c->row++;
        set_axis(c, 1, position[1], &c->down);
    }
    for (int k = 0, count; k < c->across[i].count; k += count) {
        const int64_t x = c->across[i].first + k;
        const int from = (int)(x % STRIP), left = c->across[i].count - k;
        count = STRIP - from < left ? STRIP - from : left;
        add_strip(&sum, find_strip(c, channel, (size_t)(x / STRIP)), from, count, weight + k,
                  reach + k);
    }
    const bool missing = weft_prefilter_is_missing(sum.depends, sum.reaches, c->whole, finite);
    return (struct weft_reference_value){.value = missing ? (double)NAN : sum.value,
                                         .magnitude = sum.largest};
}
