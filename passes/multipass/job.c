// SPDX-License-Identifier: BSD-3-Clause
#include "filter/statistics.h"
#include "passes/multipass/job.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t value_bytes(enum weft_value_type type)
{
    static const size_t bytes[] = {
        [WEFT_VALUE_UINT8] = 1, [WEFT_VALUE_UINT16] = 2, [WEFT_VALUE_FLOAT] = 4};
    return bytes[type];
}

static void put(const struct weft_job_values *values, size_t i, double value)
{
    switch (values->type) {
    case WEFT_VALUE_UINT8:
        ((uint8_t *)values->data)[i] = (uint8_t)value;
        return;
    case WEFT_VALUE_UINT16:
        ((uint16_t *)values->data)[i] = (uint16_t)value;
        return;
    case WEFT_VALUE_FLOAT:
        break;
    }
    ((float *)values->data)[i] = (float)value;
}

// The code of a logarithm, passes/plan/pass.h.
static double log_code(const struct weft_multipass_job *job, double x)
{
    const int one = job->one;
    const double octaves = job->passes->log_octaves;
    return x < exp2(-octaves) ? one : fmax(0.0, round(-log2(x) * (one - 1) / octaves));
}

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
    for (int c = 0; c < job->work->channels; c++)
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
    for (int c = 0; c < job->work->channels; c++)
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
    if (job->passes->log_table && low < 0.0) {
        weft_error(job->log, "convolution: logarithms need a range from 0 on, not from %g", low);
        return WEFT_ERR_UNSUPPORTED;
    }
    return finite ? WEFT_OK : mark_not_finite(job);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static void find_reach(struct weft_multipass_job *job)
{
    for (int g = 0; g < job->passes->group_count; g++) {
        for (int a = 0; a < job->passes->dims; a++) {
            const int offset = job->passes->groups[g].offset[a];
            job->reach[0][a] = smaller(job->reach[0][a], offset);
            job->reach[1][a] = larger(job->reach[1][a], offset);
        }
    }
}

static enum weft_result check_texels(const struct weft_multipass_job *job, const char *what,
                                     double texels, int64_t limit)
{
    if (texels <= (double)limit)
        return WEFT_OK;
    weft_error(job->log, "convolution: the %s takes %.0f texels, over the limit of %lld", what,
               texels, (long long)limit);
    return WEFT_ERR_LIMIT;
}

static enum weft_result allocate(const struct weft_multipass_job *job, const char *what,
                                 struct weft_job_values *values)
{
    const size_t texel = (size_t)values->components * value_bytes(values->type);
    if (weft_size_mul(values->texels, texel, &values->bytes))
        values->data = calloc(1, values->bytes);
    if (values->data)
        return WEFT_OK;
    weft_error(job->log, "convolution: not enough memory for %zu texels of the %s", values->texels,
               what);
    return WEFT_ERR_MEMORY;
}

// First taps go from 1 - width, where all taps read the first sample or what is before it, to the
// last sample.
static enum weft_result size_source(struct weft_multipass_job *job, int64_t limit)
{
    double texels = 1.0;
    find_reach(job);
    for (int a = 0; a < 3; a++) {
        const size_t taps = a < job->passes->dims ? (size_t)job->work->kernel.width : 1;
        job->padded[a] = (size_t)job->samples->size[a] + taps - 1 +
                         (size_t)(job->reach[1][a] - job->reach[0][a]);
        texels *= (double)job->padded[a];
    }
    // Also keeps offsets within 32 bits.
    const enum weft_result res =
        check_texels(job, "source", texels, limit < INT32_MAX ? limit : INT32_MAX);
    if (res == WEFT_OK)
        job->source.texels = job->padded[0] * job->padded[1] * job->padded[2];
    return res;
}

// The sample that lies at a padded texel's place (moved by `shift`) along an axis.
static size_t sample_at(const struct weft_multipass_job *job, int a, size_t texel, int shift)
{
    const int64_t taps = a < job->passes->dims ? job->work->kernel.width : 1;
    const int64_t i = (int64_t)texel + 1 - taps + job->reach[0][a] + shift;
    return i < 0 ? 0 : i >= job->samples->size[a] ? (size_t)job->samples->size[a] - 1 : (size_t)i;
}

static double mapped(const struct weft_multipass_job *job, float sample)
{
    const double x = job->width > 0.0 ? ((double)sample - job->low) / job->width : 0.0;
    const double inside = x > 0.0 ? fmin(x, 1.0) : 0.0; // a NAN is 0
    if (job->passes->log_table)
        return log_code(job, inside);
    if (!job->floats)
        return floor(inside * job->one + 0.5);
    return job->passes->target == WEFT_TARGET_HALF ? half_nearest(inside) : inside;
}

// Component c of the padded source, from a plane that is mapped already: [z][y][x] as the samples.
static void lay_out(const struct weft_multipass_job *job, const struct weft_job_values *plane,
                    int c, const int shift[3])
{
    const size_t size_x = (size_t)job->samples->size[0], size_y = (size_t)job->samples->size[1];
    const size_t texel = (size_t)job->source.components, bytes = value_bytes(plane->type);
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
        put(out, i, mapped(job, samples[i]));
        job->clamped += !(v >= job->low && v <= job->high);
    }
}

static enum weft_result create_source(struct weft_multipass_job *job, int64_t limit)
{
    const struct weft_pass_list *l = job->passes;
    enum weft_result res = size_source(job, limit);
    if (res != WEFT_OK)
        return res;
    job->source.type = job->floats        ? WEFT_VALUE_FLOAT
                       : job->one <= 0xff ? WEFT_VALUE_UINT8
                                          : WEFT_VALUE_UINT16;
    job->source.components = l->dot4 ? 4 : job->work->channels;
    struct weft_job_values plane = {
        .type = job->source.type, .components = 1, .texels = sample_count(job->samples)};
    res = allocate(job, "source", &job->source);
    if (res == WEFT_OK)
        res = allocate(job, "mapped samples", &plane);
    for (int c = 0; res == WEFT_OK && c < job->source.components; c++) {
        if (c < job->work->channels)
            map_plane(job, job->samples->plane[c], &plane);
        lay_out(job, &plane, c, l->dot4 ? l->pattern[c] : (const int[3]){0});
    }
    free(plane.data);
    return res;
}

// ---- the tiles ----------------------------------------------------------------------------------

static double stored_value(const struct weft_multipass_job *job,
                           const struct weft_kernel_tile *tile, size_t i)
{
    const enum weft_tile_format format = weft_kernel_tiles_get_info(job->passes->tiles)->format;
    if (format == WEFT_TILE_UNORM)
        return ((const uint16_t *)tile->data)[i];
    const double value = (double)((const float *)tile->data)[i];
    return job->passes->log_table ? log_code(job, fabs(value) / tile->scale) : value;
}

struct tile_axes {
    int32_t base, flip, step[3];
};

// Index of sample k in a tile's memory: base + sum over axes of step k.
static struct tile_axes tile_axes(const struct weft_multipass_job *job,
                                  const struct weft_kernel_tile *tile)
{
    struct tile_axes axes = {0};
    for (int a = 0, stride = 1; a < job->passes->dims; a++, stride *= job->samples_per_unit) {
        const bool mirrored = tile && tile->mirrored[a];
        axes.step[a] = mirrored ? -stride : stride;
        axes.base += mirrored ? (job->samples_per_unit - 1) * stride : 0;
    }
    axes.flip = axes.base;
    return axes;
}

// One of the four components of a group's block.
static void write_component(const struct weft_multipass_job *job, int32_t base, int component,
                            const struct weft_tap_group *group)
{
    const struct weft_kernel_tile *tile =
        weft_kernel_tiles_get(job->passes->tiles, group->tile[component]);
    const double sign = job->signed_tiles ? group->sign[component] : 1.0;
    const struct tile_axes axes = tile_axes(job, tile);
    const int m = job->samples_per_unit, dims = job->passes->dims;
    size_t out = 4 * (size_t)base + (size_t)component;
    for (int z = 0; z < (dims > 2 ? m : 1); z++) {
        for (int y = 0; y < (dims > 1 ? m : 1); y++) {
            int32_t in = axes.base + z * axes.step[2] + y * axes.step[1];
            for (int x = 0; x < m; x++, in += axes.step[0], out += 4)
                put(&job->tiles, out, sign * stored_value(job, tile, (size_t)in));
        }
    }
}

// What one block of values holds: four tiles, or what the tile shares with its mirror images.
static bool same_block(const struct weft_multipass_job *job, const struct weft_tap_group *a,
                       const struct weft_tap_group *b)
{
    if (job->passes->dot4)
        return memcmp(a->tile, b->tile, sizeof a->tile) == 0 &&
               (!job->signed_tiles || memcmp(a->sign, b->sign, sizeof a->sign) == 0);
    const struct weft_kernel_tile *tile_a = weft_kernel_tiles_get(job->passes->tiles, a->tile[0]);
    const struct weft_kernel_tile *tile_b = weft_kernel_tiles_get(job->passes->tiles, b->tile[0]);
    return tile_a && tile_b ? tile_a->stored == tile_b->stored : tile_a == tile_b;
}

// Numbers the blocks; returns how many there are.
static size_t number_blocks(const struct weft_multipass_job *job, int *block)
{
    int count = 0;
    for (int g = 0; g < job->passes->group_count; g++) {
        int twin = 0;
        while (!same_block(job, &job->passes->groups[twin], &job->passes->groups[g]))
            twin++;
        block[g] = twin < g ? block[twin] : count++;
    }
    return (size_t)count;
}

static void write_block(const struct weft_multipass_job *job, const struct weft_tap_group *group,
                        int32_t base)
{
    const size_t values = weft_kernel_tiles_get_info(job->passes->tiles)->tile_values;
    if (job->passes->dot4) {
        for (int c = 0; c < 4; c++)
            if (group->tile[c] >= 0)
                write_component(job, base, c, group);
        return;
    }
    const struct weft_kernel_tile *tile = weft_kernel_tiles_get(job->passes->tiles, group->tile[0]);
    for (size_t i = 0; tile && i < values; i++)
        put(&job->tiles, (size_t)base + i, stored_value(job, tile, i));
}

static void set_groups(struct weft_multipass_job *job, const int *block)
{
    const size_t values = weft_kernel_tiles_get_info(job->passes->tiles)->tile_values;
    for (int g = 0, written = 0; g < job->passes->group_count; g++) {
        const struct weft_tap_group *group = &job->passes->groups[g];
        struct weft_job_group *out = &job->groups[g];
        out->tile_base = (int32_t)((size_t)block[g] * values);
        if (block[g] == written) {
            write_block(job, group, out->tile_base);
            written++;
        }
        if (job->positions != WEFT_JOB_LINEAR) {
            const struct tile_axes axes =
                tile_axes(job, weft_kernel_tiles_get(job->passes->tiles, group->tile[0]));
            memcpy(out->tile_step, axes.step, sizeof out->tile_step);
            out->tile_flip = axes.flip;
            out->tile_base += job->positions == WEFT_JOB_PACKED ? axes.base : 0;
        }
        for (int a = 0, stride = 1; a < 3; stride *= (int)job->padded[a++])
            out->source_offset += group->offset[a] * stride;
    }
}

static enum weft_job_positions choose_positions(const struct weft_multipass_job *job)
{
    const int m = job->samples_per_unit;
    bool mirrored = false;
    for (int g = 0; !job->passes->dot4 && g < job->passes->group_count; g++) {
        const int tile = job->passes->groups[g].tile[0];
        mirrored =
            mirrored || tile_axes(job, weft_kernel_tiles_get(job->passes->tiles, tile)).flip != 0;
    }
    return !mirrored ? WEFT_JOB_LINEAR : (m & (m - 1)) == 0 ? WEFT_JOB_FLIPS : WEFT_JOB_PACKED;
}

static enum weft_result create_tiles(struct weft_multipass_job *job, int64_t limit)
{
    const struct weft_pass_list *l = job->passes;
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(l->tiles);
    enum weft_result res = WEFT_ERR_MEMORY;
    int *block = calloc((size_t)l->group_count + 1, sizeof *block);
    job->groups = calloc((size_t)l->group_count + 1, sizeof *job->groups);
    if (!block || !job->groups) {
        weft_error(job->log, "convolution: not enough memory for %d groups", l->group_count);
        goto fail;
    }
    job->signed_tiles = job->floats && l->dot4;
    const size_t blocks = number_blocks(job, block);
    const double texels = (double)blocks * (double)info->tile_values;
    res = check_texels(job, "tiles", texels, limit < INT32_MAX ? limit : INT32_MAX);
    if (res != WEFT_OK)
        goto fail;
    const int largest = job->floats || l->log_table ? job->one : (1 << info->bits) - 1;
    job->tiles.type = job->floats       ? WEFT_VALUE_FLOAT
                      : largest <= 0xff ? WEFT_VALUE_UINT8
                                        : WEFT_VALUE_UINT16;
    job->tiles.components = l->dot4 ? 4 : 1;
    job->tiles.texels = (blocks ? blocks : 1) * info->tile_values;
    job->positions = choose_positions(job);
    res = allocate(job, "tiles", &job->tiles);
    if (res == WEFT_OK)
        set_groups(job, block);
fail:
    free(block);
    return res;
}

// ---- pixels -------------------------------------------------------------------------------------

static void make_entry(const struct weft_multipass_job *job, int x, int y,
                       struct weft_job_entry *out)
{
    const int m = job->samples_per_unit;
    uint32_t k[3] = {0};
    double at[3];
    weft_multipass_position(job->grid, x, y, at);
    size_t texel = 0;
    for (int a = job->passes->dims - 1; a >= 0; a--) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, a, at[a], &fraction);
        k[a] = (uint32_t)smaller(m - 1, (int)floor(fraction * m));
        // A group's offset is counted from here, so the least is in front.
        texel = texel * job->padded[a] +
                (size_t)(first + job->work->kernel.width - 1 - job->reach[0][a]);
    }
    *out = (struct weft_job_entry){(uint32_t)texel, weft_job_pack_position(job, k)};
}

static enum weft_result create_entries(struct weft_multipass_job *job,
                                       const struct weft_job_limits *limits)
{
    const struct weft_pixel_grid *g = job->grid;
    if (g->width > limits->target || g->height > limits->target) {
        weft_error(job->log, "convolution: %d x %d pixels, over the limit of %lld along a side",
                   g->width, g->height, (long long)limits->target);
        return WEFT_ERR_LIMIT;
    }
    const enum weft_result res =
        check_texels(job, "grid", (double)g->width * (double)g->height, limits->texels);
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

enum weft_result weft_multipass_job_create(const struct weft_multipass_work *work,
                                           const struct weft_multipass_params *params,
                                           const struct weft_job_limits *limits,
                                           struct weft_multipass_job *out)
{
    struct weft_multipass_job job;
    *out = (struct weft_multipass_job){0};
    enum weft_result res = weft_multipass_job_start(work, params, &job);
    if (res != WEFT_OK)
        goto fail;
    job.samples_per_unit = weft_kernel_tiles_get_info(job.passes->tiles)->samples;
    job.position_bits = job.passes->dims == 3 ? 10 : 16;
    res = set_range(&job);
    if (res == WEFT_OK)
        res = create_source(&job, limits->texels);
    if (res == WEFT_OK)
        res = create_tiles(&job, limits->texels);
    if (res == WEFT_OK)
        res = weft_multipass_job_check_sums(&job);
    if (res == WEFT_OK)
        res = create_entries(&job, limits);
    if (res != WEFT_OK)
        goto fail;
    *out = job;
    return WEFT_OK;
fail:
    weft_multipass_job_destroy(&job);
    return res;
}

void weft_multipass_job_destroy(struct weft_multipass_job *job)
{
    free(job->source.data);
    free(job->tiles.data);
    free(job->groups);
    free(job->entries);
    free(job->not_finite);
    *job = (struct weft_multipass_job){0};
}

int weft_multipass_job_bias(const struct weft_multipass_job *job, const struct weft_pass *pass)
{
    if (job->passes->exact_inside)
        return pass->bias + pass->denominator / 2;
    const int64_t unit = INT64_C(1) << job->extra_bits;
    const int64_t twice = 2 * llabs(pass->bias * unit) + pass->denominator;
    const int magnitude = (int)(twice / (2 * (int64_t)pass->denominator));
    return (pass->bias < 0 ? -magnitude : magnitude) + (int)(unit / 2);
}

enum weft_result weft_multipass_plan_work(const struct weft_multipass_params *params,
                                          struct weft_multipass_work *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct weft_multipass_work){0};
    weft_require(params->log, params->plan);
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(params->plan);
    *out = (struct weft_multipass_work){.passes = info->passes,
                                        .kernel = info->kernel,
                                        .derivative = info->derivative,
                                        .channels = info->channels};
    return WEFT_OK;
fail:
    return res;
}
