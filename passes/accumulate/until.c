// SPDX-License-Identifier: BSD-3-Clause
// Standard errors are averaged as squares. Sums over a neighbourhood are made anew for every pixel,
// by columns of sums over rows: nothing is subtracted, so that a bright pixel leaves no error in
// the sums that it has left.
#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/accumulate_impl.h"

enum { DEFAULT_RADIUS = 2, DEFAULT_LEAST = 16 };
static const double DEFAULT_SHARE = 0.99;

// Sums over a part of a neighbourhood, of those pixels that have values.
struct sums {
    double square, mean; // of standard errors, of means
    int32_t squares, means;
};

struct judging {
    struct weft_until until;
    int32_t width, height;
    float *deviation, *mean; // of a channel
    struct sums *row;        // over 2 radius + 1 pixels of the row
    float *worst;            // standard error of each pixel, NAN where none is known; < 0: no mean
    uint8_t *converged;      // in all channels so far
};

// ---- one channel --------------------------------------------------------------------------------

static int32_t clamp(int32_t x, int32_t end)
{
    return x < 0 ? 0 : x < end ? x : end;
}

static bool sum_rows(void *priv, int thread, size_t first, size_t end)
{
    const struct judging *j = priv;
    (void)thread;
    for (size_t i = first; i < end; i++) {
        const int32_t x = (int32_t)(i % (size_t)j->width), r = j->until.radius;
        const int32_t to = clamp(x + r + 1, j->width);
        const size_t start = i - (size_t)x;
        struct sums sums = {0};
        for (int32_t k = clamp(x - r, j->width); k < to; k++) {
            const double deviation = (double)j->deviation[start + (size_t)k];
            const double mean = (double)j->mean[start + (size_t)k];
            if (!isnan(deviation)) {
                sums.square += deviation * deviation;
                sums.squares++;
            }
            if (!isnan(mean)) {
                sums.mean += mean;
                sums.means++;
            }
        }
        j->row[i] = sums;
    }
    return true;
}

static struct sums sum_columns(const struct judging *j, size_t i)
{
    const int32_t x = (int32_t)(i % (size_t)j->width), y = (int32_t)(i / (size_t)j->width);
    const int32_t to = clamp(y + j->until.radius + 1, j->height);
    struct sums sums = {0};
    for (int32_t k = clamp(y - j->until.radius, j->height); k < to; k++) {
        const struct sums *row = &j->row[(size_t)k * (size_t)j->width + (size_t)x];
        sums.square += row->square;
        sums.mean += row->mean;
        sums.squares += row->squares;
        sums.means += row->means;
    }
    return sums;
}

static bool judge_pixels(void *priv, int thread, size_t first, size_t end)
{
    const struct judging *j = priv;
    (void)thread;
    for (size_t i = first; i < end; i++) {
        if (isnan(j->mean[i]))
            j->worst[i] = -1.0f;
        if (j->worst[i] < 0.0f)
            continue;
        const struct sums sums = sum_columns(j, i);
        const double deviation = sqrt(sums.square / sums.squares); // NAN where there are none
        const double limit =
            fmax(j->until.absolute, j->until.relative * fabs(sums.mean / sums.means));
        j->converged[i] = j->converged[i] && deviation <= limit;
        if (!(deviation <= (double)j->worst[i])) // NAN stays
            j->worst[i] = isnan(j->worst[i]) ? NAN : (float)deviation;
    }
    return true;
}

static enum weft_result judge_channel(weft_accumulator *a, struct judging *j, int channel)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    enum weft_result res =
        weft_accumulator_current(a, WEFT_ACCUMULATED_STANDARD_ERROR, channel, j->deviation, 0);
    if (res == WEFT_OK)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, channel, j->mean, 0);
    if (res != WEFT_OK)
        return res;
    weft_pixels_run(&shape, sum_rows, j);
    weft_pixels_run(&shape, judge_pixels, j);
    return WEFT_OK;
}

// ---- all of them --------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// Of the pixels that have a mean; their standard errors are sorted on the way.
static void summarise(const struct judging *j, struct weft_convergence *out)
{
    const size_t count = (size_t)j->width * (size_t)j->height;
    size_t judged = 0, known = 0, converged = 0;
    for (size_t i = 0; i < count; i++) {
        if (j->worst[i] < 0.0f)
            continue;
        judged++;
        converged += j->converged[i];
        if (!isnan(j->worst[i]))
            j->worst[known++] = j->worst[i];
    }
    qsort(j->worst, known, sizeof *j->worst, compare);
    out->share = judged > 0 ? (double)converged / (double)judged : 0.0;
    out->largest = known > 0 ? (double)j->worst[known - 1] : (double)NAN;
    out->median = known > 0 ? (double)j->worst[(known - 1) / 2] : (double)NAN;
}

static enum weft_result fill_in(const weft_accumulator *a, const struct weft_until *until,
                                struct weft_until *out)
{
    const struct weft_log *log = a->params.log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = *until;
    weft_require(log, a->params.keep & WEFT_KEEP_VARIANCE);
    weft_require(log, until->absolute >= 0.0 && isfinite(until->absolute));
    weft_require(log, until->relative >= 0.0 && isfinite(until->relative));
    weft_require(log, until->absolute > 0.0 || until->relative > 0.0);
    weft_require(log, until->share >= 0.0 && until->share <= 1.0);
    weft_require(log, until->least == 0 || until->least >= 2);
    weft_require(log, until->radius >= -1 && until->radius <= WEFT_UNTIL_MAX_RADIUS);
    if (until->share == 0.0)
        out->share = DEFAULT_SHARE;
    if (until->least == 0)
        out->least = DEFAULT_LEAST;
    if (until->radius <= 0)
        out->radius = until->radius < 0 ? 0 : DEFAULT_RADIUS;
    res = WEFT_OK;
fail:
    return res;
}

static bool make(const weft_accumulator *a, struct judging *j)
{
    const size_t count = (size_t)a->params.width * (size_t)a->params.height;
    j->width = a->params.width;
    j->height = a->params.height;
    j->deviation = malloc(count * sizeof *j->deviation);
    j->mean = malloc(count * sizeof *j->mean);
    j->row = malloc(count * sizeof *j->row);
    j->worst = calloc(count, sizeof *j->worst);
    j->converged = malloc(count);
    for (size_t i = 0; j->converged && i < count; i++)
        j->converged[i] = 1;
    return j->deviation && j->mean && j->row && j->worst && j->converged;
}

static void clear(struct judging *j)
{
    free(j->deviation);
    free(j->mean);
    free(j->row);
    free(j->worst);
    free(j->converged);
}

enum weft_result weft_accumulator_judge(weft_accumulator *a, const struct weft_until *until,
                                        struct weft_convergence *out)
{
    struct judging j = {0};
    *out = (struct weft_convergence){.largest = (double)NAN, .median = (double)NAN};
    enum weft_result res = fill_in(a, until, &j.until);
    if (res != WEFT_OK)
        return res;
    if (!make(a, &j)) {
        weft_error(a->params.log, "accumulate: not enough memory to judge %d channels",
                   a->params.channel_count);
        res = WEFT_ERR_MEMORY;
    }
    for (int c = 0; c < a->params.channel_count && res == WEFT_OK; c++)
        res = judge_channel(a, &j, c);
    if (res == WEFT_OK) {
        summarise(&j, out);
        out->enough = a->counted >= j.until.least && out->share >= j.until.share;
    }
    clear(&j);
    return res;
}
