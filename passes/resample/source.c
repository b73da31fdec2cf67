// SPDX-License-Identifier: BSD-3-Clause
// What is resampled: planes, what they measure, and what is read in their place.
#include <float.h>
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

static bool is_part(const struct weft_resample_source_params *p)
{
    return p->window.width != p->width || p->window.height != p->height;
}

// Fills the kernel's and the window's defaults in.
static enum weft_result check(struct weft_resample_source_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (!p->kernel.info)
        weft_kernel_parse(p->log, "catmull-rom", &p->kernel);
    if (p->width < 1 || p->height < 1 || p->width > WEFT_RESAMPLE_MAX_SIZE ||
        p->height > WEFT_RESAMPLE_MAX_SIZE ||
        (int64_t)p->width * p->height > WEFT_RESAMPLE_MAX_PIXELS) {
        weft_error(p->log, "a source of %d x %d samples: sides must be 1 to %d, and %lld in all",
                   p->width, p->height, WEFT_RESAMPLE_MAX_SIZE,
                   (long long)WEFT_RESAMPLE_MAX_PIXELS);
        goto fail;
    }
    res = weft_rectangle_within(p->log, &p->window, p->width, p->height, &p->window);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->threads >= 0 && p->threads <= WEFT_CPU_MAX_THREADS);
    weft_require_enum(p->log, p->boundary, WEFT_BOUNDARY_BORDER);
    weft_require(p->log, fabs(p->border) <= (double)FLT_MAX);
    if (p->channels < 0 || p->channels > WEFT_RESAMPLE_MAX_CHANNELS) {
        weft_error(p->log, "a source of %d channels: there may be 1 to %d", p->channels,
                   WEFT_RESAMPLE_MAX_CHANNELS);
        goto fail;
    }
    if (p->stride && p->stride < p->window.width) {
        weft_error(p->log, "a source with a stride of %lld floats and %d samples in a row",
                   (long long)p->stride, p->window.width);
        goto fail;
    }
    weft_require_enum(p->log, p->boundary, WEFT_BOUNDARY_BORDER);
    if (!(fabs(p->border) <= (double)FLT_MAX)) {
        weft_error(p->log, "a source with a border of %g: it must be a finite float", p->border);
        goto fail;
    }
    if (!is_range(p)) {
        weft_error(p->log, "a source's range of %g to %g: the first must be less, both finite",
                   p->low, p->high);
        goto fail;
    }
    weft_require(p->log, !p->texture || p->context);
    for (int c = 0; !p->texture && c < (p->channels ? p->channels : 1); c++)
        weft_require(p->log, p->plane[c]);
    res = weft_kernel_check(p->log, &p->kernel);
    if (res == WEFT_OK && p->kernel.prefiltered && is_part(p)) {
        weft_error(
            p->log,
            "%d x %d of %d x %d samples for %s, which is prefiltered: coefficients depend on "
            "all of them",
            p->window.width, p->window.height, p->width, p->height, p->kernel.info->name);
        res = WEFT_ERR_UNSUPPORTED;
    }
fail:
    return res;
}

// ---- what is read -------------------------------------------------------------------------------

// Whether coefficients go on beyond the samples as those do.
static bool repeats(enum weft_boundary boundary)
{
    return boundary == WEFT_BOUNDARY_MIRROR || boundary == WEFT_BOUNDARY_WRAP;
}

// Leaves the samples' coefficients of those with an overlap, in place.
static void crop(const weft_resample_source *s, float *values)
{
    const size_t row = (size_t)s->info.width, more = (size_t)s->overlap;
    for (size_t y = 0; y < (size_t)s->info.height; y++)
        memmove(values + y * row, values + (y + more) * (row + 2 * more) + more,
                row * sizeof *values);
}

static enum weft_result prefilter(const struct weft_log *log, weft_resample_source *s)
{
    struct weft_prefilter prefilter;
    const double start = weft_now_seconds();
    enum weft_result res = weft_prefilter_compute(log, &s->info.kernel, &prefilter);
    if (res == WEFT_OK)
        s->overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    for (int c = 0; res == WEFT_OK && c < s->info.channels; c++) {
        const struct weft_image_plane plane = {.samples = s->plane[c],
                                               .width = s->info.width,
                                               .height = s->info.height,
                                               .stride = s->stride,
                                               .boundary = s->info.boundary,
                                               .border = (float)s->info.border};
        res = weft_image_prefilter(log, &s->info.kernel, &plane, s->overlap, &s->own[c]);
        if (res == WEFT_OK && repeats(s->info.boundary))
            crop(s, s->own[c]);
    }
    if (repeats(s->info.boundary))
        s->overlap = 0;
    s->info.prefilter_seconds = weft_now_seconds() - start;
    return res;
}

static enum weft_result pack(const struct weft_log *log, weft_resample_source *s)
{
    const struct weft_rectangle *w = &s->info.window;
    const size_t row = (size_t)w->width, count = row * (size_t)w->height;
    for (int c = 0; c < s->info.channels; c++) {
        s->own[c] = malloc(count * sizeof(float));
        if (!s->own[c]) {
            weft_error(log, "out of memory for %zu samples", count);
            return WEFT_ERR_MEMORY;
        }
        for (int64_t y = 0; y < w->height; y++)
            memcpy(s->own[c] + (size_t)y * row, s->plane[c] + y * s->stride, row * sizeof(float));
    }
    return WEFT_OK;
}

// ---- statistics ---------------------------------------------------------------------------------

static size_t value_count(const weft_resample_source *s)
{
    const struct weft_rectangle window = weft_resample_values_window(s);
    return (size_t)window.width * (size_t)window.height;
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
    size_t from, end;   // rows of the window
    int order;          // of differences; 0: range and counts in their place
    struct weft_statistics samples[WEFT_RESAMPLE_MAX_CHANNELS * BANDS];
};

static bool measure_band(void *priv, int thread, size_t i)
{
    struct measuring *m = priv;
    const weft_resample_source *s = m->source;
    const struct weft_rectangle *w = &s->info.window;
    const struct weft_statistics_plane plane = {s->plane[i / m->bands], (size_t)w->width,
                                                (size_t)w->height, (size_t)s->stride};
    const size_t from = m->from + i % m->bands * m->rows;
    const size_t end = from + m->rows < m->end ? from + m->rows : m->end;
    struct weft_statistics own = WEFT_STATISTICS_NONE;
    (void)thread;
    if (m->order)
        own.difference[m->order - 1] =
            weft_statistics_plane_difference(&plane, m->order, from, end);
    for (size_t y = from; !m->order && y < end; y++)
        weft_statistics_add(&own, plane.values + y * plane.stride, plane.width);
    m->samples[i] = own;
    return true;
}

// Of all channels, rows `from` to `end` of the window: the largest difference of an order, or with
// 0 range and counts.
static struct weft_statistics measure_samples(const weft_resample_source *s, size_t from,
                                              size_t end, int order, int threads)
{
    const size_t height = end - from, least = BAND_SAMPLES / (size_t)s->info.window.width + 1;
    struct measuring m = {.source = s,
                          .rows = (height + BANDS - 1) / BANDS,
                          .from = from,
                          .end = end,
                          .order = order};
    m.rows = m.rows > least ? m.rows : least;
    m.bands = (height + m.rows - 1) / m.rows;
    const size_t parts = m.bands * (size_t)s->info.channels;
    struct weft_statistics all = WEFT_STATISTICS_NONE;
    weft_threads_run(threads ? threads : weft_threads_available(), parts, measure_band, &m);
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

static bool has_range(const struct weft_resample_source_params *params)
{
    return !weft_range_is_open(params->low, params->low, params->high) &&
           !weft_range_is_open(params->high, params->low, params->high);
}

// What is read are the samples, but for prefiltered kernels.
static void measure_values(weft_resample_source *s,
                           const struct weft_resample_source_params *params)
{
    struct weft_resample_statistics *out = &s->info.statistics;
    const bool given = has_range(params), coefficients = s->info.kernel.prefiltered;
    struct weft_statistics values = WEFT_STATISTICS_NONE;
    for (int c = 0; c < s->info.channels; c++) {
        const float *of = weft_resample_values(s, c);
        if (given && (coefficients || !params->measured))
            out->clamped += count_outside(of, value_count(s), params->low, params->high);
        else if (!given && coefficients)
            weft_statistics_add(&values, of, value_count(s));
    }
    if (given && params->measured && !coefficients)
        out->clamped = params->measured->outside;
    if (given) {
        out->low = params->low;
        out->high = params->high;
        return;
    }
    const struct weft_statistics *read = coefficients ? &values : &s->samples;
    set_ends(read, &out->low, &out->high);
    out->clamped = read->not_finite;
}

// A border's value is read as samples are.
static void include_border(weft_resample_source *s, bool given)
{
    struct weft_resample_statistics *out = &s->info.statistics;
    const double border = s->info.border;
    if (s->info.boundary != WEFT_BOUNDARY_BORDER)
        return;
    out->sample_low = fmin(out->sample_low, border);
    out->sample_high = fmax(out->sample_high, border);
    out->low = given ? out->low : fmin(out->low, border);
    out->high = given ? out->high : fmax(out->high, border);
}

// ---- sources ------------------------------------------------------------------------------------

static void take_planes(weft_resample_source *s, const struct weft_resample_source_params *params)
{
    s->info =
        (struct weft_resample_source_info){.kernel = params->kernel,
                                           .width = params->width,
                                           .height = params->height,
                                           .channels = params->channels ? params->channels : 1,
                                           .boundary = params->boundary,
                                           .border = (double)(float)params->border,
                                           .window = params->window};
    memcpy(s->plane, params->plane, sizeof s->plane);
    s->stride = params->stride ? params->stride : params->window.width;
}

static void measure(weft_resample_source *s, const struct weft_resample_source_params *p)
{
    s->samples = p->measured ? p->measured->samples
                             : measure_samples(s, 0, (size_t)p->window.height, 0, p->threads);
    s->has_differences = p->measured != NULL;
    set_ends(&s->samples, &s->info.statistics.sample_low, &s->info.statistics.sample_high);
    measure_values(s, p);
    include_border(s, has_range(p));
}

// Planes in the place of a texture.
static enum weft_result read_texture(struct weft_resample_source_params *p, weft_resample_source *s)
{
    const int channels = p->channels ? p->channels : 1;
    const size_t count = (size_t)p->window.width * (size_t)p->window.height;
    float *plane[WEFT_RESAMPLE_MAX_CHANNELS];
    s->texels = malloc(count * (size_t)channels * sizeof *s->texels);
    if (!s->texels) {
        weft_error(p->log, "out of memory for a texture of %d x %d texels", p->window.width,
                   p->window.height);
        return WEFT_ERR_MEMORY;
    }
    for (int c = 0; c < channels; c++)
        p->plane[c] = plane[c] = s->texels + (size_t)c * count;
    p->stride = p->window.width;
    return weft_texture_read(p->context, p->texture, p->window.width, p->window.height, channels,
                             plane, 0);
}

enum weft_result weft_resample_source_create(const struct weft_resample_source_params *params,
                                             weft_resample_source **out)
{
    struct weft_resample_source_params p = *params;
    *out = NULL;
    weft_resample_source *source = NULL;
    enum weft_result res = check(&p);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(p.log, p.measured || !is_part(&p));
    res = WEFT_ERR_MEMORY;
    source = calloc(1, sizeof *source);
    if (!source) {
        weft_error(p.log, "out of memory for a source");
        goto fail;
    }
    res = p.texture ? read_texture(&p, source) : WEFT_OK;
    if (res != WEFT_OK)
        goto fail;
    take_planes(source, &p);
    res = p.kernel.prefiltered               ? prefilter(p.log, source)
          : source->stride != p.window.width ? pack(p.log, source)
                                             : WEFT_OK;
    if (res == WEFT_OK) {
        measure(source, &p);
        *out = source;
        source = NULL;
    }
fail:
    weft_resample_source_destroy(&source);
    return res;
}

void weft_resample_source_destroy(weft_resample_source **source)
{
    if (!source || !*source)
        return;
    for (int c = 0; c < WEFT_RESAMPLE_MAX_CHANNELS; c++)
        free((*source)->own[c]);
    free((*source)->texels);
    free(*source);
    *source = NULL;
}

const struct weft_resample_source_info *
weft_resample_source_get_info(const weft_resample_source *source)
{
    return &source->info;
}

// ---- parts of the samples -----------------------------------------------------------------------

// Rows whose differences begin before row `end` of the image.
static bool has_rows_for(const struct weft_resample_source_params *p, int order, int first, int end)
{
    const int past = end < p->height - order ? end + order : p->height;
    return first >= p->window.y && past <= p->window.y + p->window.height;
}

enum weft_result weft_resample_measure(const struct weft_resample_source_params *params, int first,
                                       int rows, bool differences,
                                       struct weft_resample_measured *out)
{
    struct weft_resample_source_params p = *params;
    weft_resample_source view = {.overlap = 0};
    *out = (struct weft_resample_measured)WEFT_RESAMPLE_MEASURED_NONE;
    enum weft_result res = check(&p);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    const bool ordered = p.kernel.order >= 1 && p.kernel.order <= WEFT_STATISTICS_DIFFERENCES;
    const int order = differences && ordered ? p.kernel.order : 0;
    weft_require(p.log, !p.texture);
    weft_require(p.log, first >= 0 && rows >= 1 && rows <= p.height - first);
    weft_require(p.log, p.window.width == p.width && has_rows_for(&p, order, first, first + rows));
    take_planes(&view, &p);
    const size_t from = (size_t)(first - p.window.y), end = from + (size_t)rows;
    out->samples = measure_samples(&view, from, end, 0, p.threads);
    if (order)
        out->samples.difference[order - 1] =
            measure_samples(&view, from, end, order, p.threads).difference[order - 1];
    for (int c = 0; has_range(&p) && c < view.info.channels; c++)
        for (size_t y = from; y < end; y++)
            out->outside += count_outside(view.plane[c] + y * (size_t)view.stride, (size_t)p.width,
                                          p.low, p.high);
    res = WEFT_OK;
fail:
    return res;
}

void weft_resample_measured_join(struct weft_resample_measured *sum,
                                 const struct weft_resample_measured *other)
{
    weft_statistics_join(&sum->samples, &other->samples);
    sum->outside += other->outside;
}

// ---- errors -------------------------------------------------------------------------------------

double weft_resample_e1(const weft_resample_source *source)
{
    const struct weft_kernel *kernel = &source->info.kernel;
    if (kernel->order < 1 || kernel->order > WEFT_STATISTICS_DIFFERENCES)
        return (double)NAN;
    const struct weft_statistics samples =
        source->has_differences
            ? source->samples
            : measure_samples(source, 0, (size_t)source->info.height, kernel->order, 0);
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
        terms = weft_separable_plan_bound(plan->separable, largest, WEFT_VOLUME_PREFILTER_ERROR);
    return weft_resample_bound_of(&terms, statistics, result);
}
