// SPDX-License-Identifier: BSD-3-Clause
// What is resampled: planes, what they measure, and what is read in their place.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/error.h"
#include "filter/kernels/prefilter.h"
#include "filter/threads.h"
#include "passes/resample/resample_impl.h"
#include "passes/separable/separable.h"
#include "tiles/image/image_prefilter.h"
#include "tiles/volume/volume.h"

// ---- the request --------------------------------------------------------------------------------

static bool is_range(const struct weft_resample_source_params *p)
{
    return weft_range_is_open(p->low, p->low, p->high) ||
           weft_range_is_open(p->high, p->low, p->high) ||
           (isfinite(p->low) && isfinite(p->high) && p->low < p->high);
}

static enum weft_result check(const struct weft_resample_source_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (p->width < 1 || p->height < 1 || p->width > WEFT_RESAMPLE_MAX_SIZE ||
        p->height > WEFT_RESAMPLE_MAX_SIZE ||
        (int64_t)p->width * p->height > WEFT_RESAMPLE_MAX_PIXELS) {
        weft_error(p->log, "a source of %d x %d samples: sides must be 1 to %d, and %lld in all",
                   p->width, p->height, WEFT_RESAMPLE_MAX_SIZE,
                   (long long)WEFT_RESAMPLE_MAX_PIXELS);
        goto fail;
    }
    if (p->channels < 0 || p->channels > WEFT_RESAMPLE_MAX_CHANNELS) {
        weft_error(p->log, "a source of %d channels: there may be 1 to %d", p->channels,
                   WEFT_RESAMPLE_MAX_CHANNELS);
        goto fail;
    }
    if (p->stride && p->stride < p->width) {
        weft_error(p->log, "a source with a stride of %lld floats and %d samples in a row",
                   (long long)p->stride, p->width);
        goto fail;
    }
    if (!is_range(p)) {
        weft_error(p->log, "a source's range of %g to %g: the first must be less, both finite",
                   p->low, p->high);
        goto fail;
    }
    for (int c = 0; c < (p->channels ? p->channels : 1); c++)
        weft_require(p->log, p->plane[c]);
    res = weft_kernel_check(p->log, &p->kernel);
fail:
    return res;
}

// ---- what is read -------------------------------------------------------------------------------

static enum weft_result prefilter(const struct weft_log *log, weft_resample_source *s)
{
    struct weft_prefilter prefilter;
    const double start = weft_now_seconds();
    enum weft_result res = weft_prefilter_compute(log, &s->info.kernel, &prefilter);
    if (res == WEFT_OK)
        s->overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    for (int c = 0; res == WEFT_OK && c < s->info.channels; c++) {
        const struct weft_image_plane plane = {s->plane[c], s->info.width, s->info.height,
                                               s->stride};
        res = weft_image_prefilter(log, &s->info.kernel, &plane, s->overlap, &s->own[c]);
    }
    s->info.prefilter_seconds = weft_now_seconds() - start;
    return res;
}

static enum weft_result pack(const struct weft_log *log, weft_resample_source *s)
{
    const size_t row = (size_t)s->info.width, count = row * (size_t)s->info.height;
    for (int c = 0; c < s->info.channels; c++) {
        s->own[c] = malloc(count * sizeof(float));
        if (!s->own[c]) {
            weft_error(log, "out of memory for %zu samples", count);
            return WEFT_ERR_MEMORY;
        }
        for (int64_t y = 0; y < s->info.height; y++)
            memcpy(s->own[c] + (size_t)y * row, s->plane[c] + y * s->stride, row * sizeof(float));
    }
    return WEFT_OK;
}

// ---- statistics ---------------------------------------------------------------------------------

static size_t value_count(const weft_resample_source *s)
{
    return (size_t)weft_resample_values_along(s, 0) * (size_t)weft_resample_values_along(s, 1);
}

// Of the finite values; 0 to 0 where there are none.
static void set_ends(const struct weft_statistics *of, double *low, double *high)
{
    *low = isnan(of->minimum) ? 0.0 : of->minimum;
    *high = isnan(of->maximum) ? 0.0 : of->maximum;
}

// Parts of a channel that are measured by threads, and the samples that one is worth.
enum { BANDS = 16, BAND_SAMPLES = 1 << 16 };

struct measuring {
    const weft_resample_source *source;
    size_t bands, rows; // of a channel, and of a band
    int order;          // of differences; 0: range and counts in their place
    struct weft_statistics samples[WEFT_RESAMPLE_MAX_CHANNELS * BANDS];
};

static bool measure_band(void *priv, int thread, size_t i)
{
    struct measuring *m = priv;
    const weft_resample_source *s = m->source;
    const struct weft_statistics_plane plane = {s->plane[i / m->bands], (size_t)s->info.width,
                                                (size_t)s->info.height, (size_t)s->stride};
    const size_t from = i % m->bands * m->rows;
    struct weft_statistics own = WEFT_STATISTICS_NONE;
    (void)thread;
    if (m->order)
        own.difference[m->order - 1] =
            weft_statistics_plane_difference(&plane, m->order, from, from + m->rows);
    for (size_t y = from; !m->order && y < from + m->rows && y < plane.height; y++)
        weft_statistics_add(&own, plane.values + y * plane.stride, plane.width);
    m->samples[i] = own;
    return true;
}

// Of all channels: the largest difference of an order, or with 0 range and counts.
static struct weft_statistics measure_samples(const weft_resample_source *s, int order)
{
    const size_t height = (size_t)s->info.height, least = BAND_SAMPLES / (size_t)s->info.width + 1;
    struct measuring m = {.source = s, .rows = (height + BANDS - 1) / BANDS, .order = order};
    m.rows = m.rows > least ? m.rows : least;
    m.bands = (height + m.rows - 1) / m.rows;
    const size_t parts = m.bands * (size_t)s->info.channels;
    struct weft_statistics all = WEFT_STATISTICS_NONE;
    weft_threads_run(weft_threads_available(), parts, measure_band, &m);
    for (size_t i = 0; i < parts; i++)
        weft_statistics_join(&all, &m.samples[i]);
    return all;
}

static uint64_t count_outside(const float *values, size_t count, double low, double high)
{
    uint64_t outside = 0;
    for (size_t i = 0; i < count; i++)
        outside += !((double)values[i] >= low && (double)values[i] <= high);
    return outside;
}

// What is read are the samples, but for prefiltered kernels.
static void measure_values(weft_resample_source *s, const struct weft_statistics *samples,
                           const struct weft_resample_source_params *params)
{
    struct weft_resample_statistics *out = &s->info.statistics;
    const bool given = !weft_range_is_open(params->low, params->low, params->high) &&
                       !weft_range_is_open(params->high, params->low, params->high);
    const bool coefficients = s->info.kernel.prefiltered;
    struct weft_statistics values = WEFT_STATISTICS_NONE;
    for (int c = 0; c < s->info.channels; c++) {
        const float *of = weft_resample_values(s, c);
        if (given)
            out->clamped += count_outside(of, value_count(s), params->low, params->high);
        else if (coefficients)
            weft_statistics_add(&values, of, value_count(s));
    }
    if (given) {
        out->low = params->low;
        out->high = params->high;
        return;
    }
    const struct weft_statistics *read = coefficients ? &values : samples;
    set_ends(read, &out->low, &out->high);
    out->clamped = read->not_finite;
}

// ---- sources ------------------------------------------------------------------------------------

static void take_planes(weft_resample_source *s, const struct weft_resample_source_params *params)
{
    s->info =
        (struct weft_resample_source_info){.kernel = params->kernel,
                                           .width = params->width,
                                           .height = params->height,
                                           .channels = params->channels ? params->channels : 1};
    memcpy(s->plane, params->plane, sizeof s->plane);
    s->stride = params->stride ? params->stride : params->width;
}

enum weft_result weft_resample_source_create(const struct weft_resample_source_params *params,
                                             weft_resample_source **out)
{
    struct weft_resample_source_params p = *params;
    *out = NULL;
    if (!p.kernel.info)
        weft_kernel_parse(p.log, "catmull-rom", &p.kernel);
    enum weft_result res = check(&p);
    if (res != WEFT_OK)
        return res;
    weft_resample_source *source = calloc(1, sizeof *source);
    if (!source) {
        weft_error(p.log, "out of memory for a source");
        return WEFT_ERR_MEMORY;
    }
    take_planes(source, &p);
    if (p.kernel.prefiltered)
        res = prefilter(p.log, source);
    else if (source->stride != p.width)
        res = pack(p.log, source);
    if (res == WEFT_OK) {
        const struct weft_statistics samples = measure_samples(source, 0);
        set_ends(&samples, &source->info.statistics.sample_low,
                 &source->info.statistics.sample_high);
        measure_values(source, &samples, &p);
        *out = source;
    } else {
        weft_resample_source_destroy(&source);
    }
    return res;
}

void weft_resample_source_destroy(weft_resample_source **source)
{
    if (!source || !*source)
        return;
    for (int c = 0; c < WEFT_RESAMPLE_MAX_CHANNELS; c++)
        free((*source)->own[c]);
    free(*source);
    *source = NULL;
}

const struct weft_resample_source_info *
weft_resample_source_get_info(const weft_resample_source *source)
{
    return &source->info;
}

// ---- errors -------------------------------------------------------------------------------------

double weft_resample_e1(const weft_resample_source *source)
{
    const struct weft_kernel *kernel = &source->info.kernel;
    if (kernel->order < 1 || kernel->order > WEFT_STATISTICS_DIFFERENCES)
        return (double)NAN;
    const struct weft_statistics samples = measure_samples(source, kernel->order);
    return weft_error_e1(kernel, 2, samples.difference[kernel->order - 1]);
}

// The border's samples hold beyond it: none are out of reach.
struct weft_bound weft_resample_bound_of(const struct weft_bound_terms *terms,
                                         const struct weft_resample_statistics *s, double result)
{
    const struct weft_bound_values values = {.low = s->low,
                                             .high = s->high,
                                             .sample_low = s->sample_low,
                                             .sample_high = s->sample_high,
                                             .result = result};
    return weft_bound_compute(terms, &values);
}

struct weft_bound weft_resample_bound(const weft_resample_plan *plan,
                                      const struct weft_resample_statistics *statistics,
                                      double result)
{
    const double largest = fmax(fabs(statistics->low), fabs(statistics->high));
    struct weft_bound_terms terms = plan->info.bound;
    if (!plan->passes && !(largest > 0.0 && largest < 0x1p100))
        terms = weft_separable_bound_terms(&plan->info.kernel, plan->info.sums, largest,
                                           WEFT_VOLUME_PREFILTER_ERROR);
    return weft_resample_bound_of(&terms, statistics, result);
}
