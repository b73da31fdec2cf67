// SPDX-License-Identifier: BSD-3-Clause
#include "filter/statistics.h"
#include "passes/multipass/job.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- halves -------------------------------------------------------------------------------------

static uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

float weft_half_truncate(float x)
{
    const uint32_t bits = float_bits(x), magnitude = bits & 0x7fffffff;
    const uint32_t exponent = magnitude >> 23;
    if (exponent >= 0x8f) // from 65536 on; infinities and NANs stay
        return exponent == 0xff ? x : copysignf(65504.0f, x);
    // 2^-14 has exponent 113, and each binade below it one bit less.
    const uint32_t lost = exponent >= 113 ? 13 : 126 - exponent;
    const uint32_t kept = bits & (lost > 23 ? 0x80000000 : ~((UINT32_C(1) << lost) - 1));
    memcpy(&x, &kept, sizeof x);
    return x;
}

// To the nearest half, ties to even; of numbers in [0, 1].
static double half_nearest(double x)
{
    const int exponent = x < 0x1p-14 ? -14 : ilogb(x);
    return ldexp(nearbyint(ldexp(x, 10 - exponent)), exponent - 10);
}

// ---- the source's range and layout --------------------------------------------------------------

static size_t sample_count(const struct weft_samples *s)
{
    return (size_t)s->size[0] * (size_t)s->size[1] * (size_t)s->size[2];
}

// Returns whether all samples are finite.
static bool find_range(const struct weft_multipass_job *job, double *low, double *high)
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    for (int c = 0; c < job->compiled->work.channels; c++)
        weft_statistics_add(&s, job->samples->plane[c], sample_count(job->samples));
    *low = isnan(s.minimum) ? 0.0 : s.minimum;
    *high = isnan(s.maximum) ? 0.0 : s.maximum;
    return s.not_finite == 0;
}

static enum weft_result mark_not_finite(struct weft_multipass_job *job)
{
    const size_t count = sample_count(job->samples);
    job->not_finite = calloc(count, 1);
    if (!job->not_finite) {
        weft_error(job->log, "convolution: not enough memory for %zu marks", count);
        return WEFT_ERR_MEMORY;
    }
    for (int c = 0; c < job->compiled->work.channels; c++)
        for (size_t i = 0; i < count; i++)
            if (!isfinite(job->samples->plane[c][i]))
                job->not_finite[i] |= (uint8_t)(1 << c);
    return WEFT_OK;
}

static enum weft_result set_range(struct weft_multipass_job *job)
{
    const struct weft_samples *s = job->samples;
    double low, high;
    const bool finite = find_range(job, &low, &high);
    const bool low_open = weft_range_is_open(s->low, s->low, s->high);
    const bool high_open = weft_range_is_open(s->high, s->low, s->high);
    low = low_open ? low : s->low;
    high = high_open ? high : s->high;
    // One was declared beyond all samples.
    if (low_open && low > high)
        low = high;
    if (high_open && high < low)
        high = low;
    job->low = low;
    job->high = high;
    job->width = high - low;
    if (job->compiled->passes->log_table && low < 0.0) {
        weft_error(job->log, "convolution: logarithms need a range from 0 on, not from %g", low);
        return WEFT_ERR_UNSUPPORTED;
    }
    return finite ? WEFT_OK : mark_not_finite(job);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

// First taps go from 1 - width, where all taps read the first sample or what is before it, to the
// last sample.
static enum weft_result size_source(struct weft_multipass_job *job)
{
    const int64_t limit = job->compiled->limits.texels;
    double texels = 1.0;
    for (int a = 0; a < 3; a++) {
        const size_t taps =
            a < job->compiled->passes->dims ? (size_t)job->compiled->work.kernel.width : 1;
        job->padded[a] = (size_t)job->samples->size[a] + taps - 1 +
                         (size_t)(job->compiled->reach[1][a] - job->compiled->reach[0][a]);
        texels *= (double)job->padded[a];
    }
    // Also keeps offsets within 32 bits.
    const enum weft_result res =
        weft_job_check_texels(job->log, "source", texels, limit < INT32_MAX ? limit : INT32_MAX);
    if (res == WEFT_OK)
        job->source.texels = job->padded[0] * job->padded[1] * job->padded[2];
    return res;
}

// The sample that lies at a padded texel's place (moved by `shift`) along an axis.
static size_t sample_at(const struct weft_multipass_job *job, int a, size_t texel, int shift)
{
    const int64_t taps = a < job->compiled->passes->dims ? job->compiled->work.kernel.width : 1;
    const int64_t i = (int64_t)texel + 1 - taps + job->compiled->reach[0][a] + shift;
    return i < 0 ? 0 : i >= job->samples->size[a] ? (size_t)job->samples->size[a] - 1 : (size_t)i;
}

static double mapped(const struct weft_multipass_job *job, float sample)
{
    const double x = job->width > 0.0 ? ((double)sample - job->low) / job->width : 0.0;
    const double inside = x > 0.0 ? fmin(x, 1.0) : 0.0; // a NAN is 0
    if (job->compiled->passes->log_table)
        return weft_job_log_code(job->compiled, inside);
    if (!job->compiled->floats)
        return floor(inside * job->compiled->one + 0.5);
    return job->compiled->passes->target == WEFT_TARGET_HALF ? half_nearest(inside) : inside;
}

// Component c of the padded source, from a plane that is mapped already: [z][y][x] as the samples.
static void lay_out(const struct weft_multipass_job *job, const struct weft_job_values *plane,
                    int c, const int shift[3])
{
    const size_t size_x = (size_t)job->samples->size[0], size_y = (size_t)job->samples->size[1];
    const size_t texel = (size_t)job->source.components, bytes = weft_value_bytes(plane->type);
    char *out = (char *)job->source.data + (size_t)c * bytes;
    for (size_t z = 0; z < job->padded[2]; z++) {
        for (size_t y = 0; y < job->padded[1]; y++) {
            const size_t row =
                sample_at(job, 2, z, shift[2]) * size_y + sample_at(job, 1, y, shift[1]);
            const char *in = (const char *)plane->data + row * size_x * bytes;
            for (size_t x = 0; x < job->padded[0]; x++, out += texel * bytes)
                memcpy(out, in + sample_at(job, 0, x, shift[0]) * bytes, bytes);
        }
    }
}

static void map_plane(struct weft_multipass_job *job, const float *samples,
                      const struct weft_job_values *out)
{
    for (size_t i = 0; i < out->texels; i++) {
        const double v = (double)samples[i];
        weft_job_put(out, i, mapped(job, samples[i]));
        job->clamped += !(v >= job->low && v <= job->high);
    }
}

static enum weft_result create_source(struct weft_multipass_job *job)
{
    const struct weft_pass_list *l = job->compiled->passes;
    enum weft_result res = size_source(job);
    if (res != WEFT_OK)
        return res;
    job->source.type = job->compiled->floats        ? WEFT_VALUE_FLOAT
                       : job->compiled->one <= 0xff ? WEFT_VALUE_UINT8
                                                    : WEFT_VALUE_UINT16;
    job->source.components = l->dot4 ? 4 : job->compiled->work.channels;
    struct weft_job_values plane = {
        .type = job->source.type, .components = 1, .texels = sample_count(job->samples)};
    res = weft_job_values_create(job->log, "source", &job->source);
    if (res == WEFT_OK)
        res = weft_job_values_create(job->log, "mapped samples", &plane);
    for (int c = 0; res == WEFT_OK && c < job->source.components; c++) {
        if (c < job->compiled->work.channels)
            map_plane(job, job->samples->plane[c], &plane);
        lay_out(job, &plane, c, l->dot4 ? l->pattern[c] : (const int[3]){0});
    }
    free(plane.data);
    return res;
}

// ---- pixels -------------------------------------------------------------------------------------

static void make_entry(const struct weft_multipass_job *job, int x, int y,
                       struct weft_job_entry *out)
{
    const int m = job->compiled->samples_per_unit;
    uint32_t k[3] = {0};
    double at[3];
    weft_multipass_position(job->grid, x, y, at);
    size_t texel = 0;
    for (int a = job->compiled->passes->dims - 1; a >= 0; a--) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, a, at[a], &fraction);
        k[a] = (uint32_t)smaller(m - 1, (int)floor(fraction * m));
        // A group's offset is counted from here, so the least is in front.
        texel = texel * job->padded[a] +
                (size_t)(first + job->compiled->work.kernel.width - 1 - job->compiled->reach[0][a]);
    }
    *out = (struct weft_job_entry){(uint32_t)texel, weft_job_pack_position(job->compiled, k)};
}

static enum weft_result create_entries(struct weft_multipass_job *job)
{
    const struct weft_job_limits *limits = &job->compiled->limits;
    const struct weft_pixel_grid *g = job->grid;
    if (g->width > limits->target || g->height > limits->target) {
        weft_error(job->log, "convolution: %d x %d pixels, over the limit of %lld along a side",
                   g->width, g->height, (long long)limits->target);
        return WEFT_ERR_LIMIT;
    }
    const enum weft_result res = weft_job_check_texels(
        job->log, "grid", (double)g->width * (double)g->height, limits->texels);
    if (res != WEFT_OK)
        return res;
    job->pixels = (size_t)g->width * (size_t)g->height;
    job->entries = calloc(job->pixels, sizeof *job->entries);
    if (!job->entries) {
        weft_error(job->log, "convolution: not enough memory for %zu pixels", job->pixels);
        return WEFT_ERR_MEMORY;
    }
    struct weft_job_entry *entry = job->entries;
    for (int y = 0; y < g->height; y++)
        for (int x = 0; x < g->width; x++)
            make_entry(job, x, y, entry++);
    return WEFT_OK;
}

// ---- creation -----------------------------------------------------------------------------------

static enum weft_result find_offsets(struct weft_multipass_job *job)
{
    const struct weft_pass_list *l = job->compiled->passes;
    job->source_offset = calloc((size_t)l->group_count + 1, sizeof *job->source_offset);
    if (!job->source_offset) {
        weft_error(job->log, "convolution: not enough memory for %d groups", l->group_count);
        return WEFT_ERR_MEMORY;
    }
    for (int g = 0; g < l->group_count; g++)
        for (int a = 0, stride = 1; a < 3; stride *= (int)job->padded[a++])
            job->source_offset[g] += l->groups[g].offset[a] * stride;
    return WEFT_OK;
}

enum weft_result weft_multipass_job_create(const struct weft_multipass *compiled,
                                           const struct weft_multipass_run_params *params,
                                           struct weft_multipass_job *out)
{
    const struct weft_multipass_request request = {
        .samples = params->samples,
        .grid = params->grid,
        .pixels = {params->pixels[0], params->pixels[1], params->pixels[2], params->pixels[3]},
        .stride = params->stride,
    };
    struct weft_multipass_job job = {
        .compiled = compiled,
        .params = params,
        .samples = params->samples,
        .grid = params->grid,
        .log = params->log,
    };
    *out = (struct weft_multipass_job){0};
    enum weft_result res = weft_multipass_check_request(params->log, &compiled->work, &request);
    if (res == WEFT_OK)
        res = set_range(&job);
    if (res == WEFT_OK)
        res = create_source(&job);
    if (res == WEFT_OK)
        res = find_offsets(&job);
    if (res == WEFT_OK)
        res = create_entries(&job);
    if (res == WEFT_OK)
        *out = job;
    else
        weft_multipass_job_destroy(&job);
    return res;
}

void weft_multipass_job_destroy(struct weft_multipass_job *job)
{
    free(job->source.data);
    free(job->source_offset);
    free(job->entries);
    free(job->not_finite);
    *job = (struct weft_multipass_job){0};
}
