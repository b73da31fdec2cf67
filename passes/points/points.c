// SPDX-License-Identifier: BSD-3-Clause
#include "passes/points/points_impl.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "passes/positions/grid.h"

// The least that memory_bytes can be: bricks around a cell, and some points.
enum { LEAST_MEMORY = 1 << 20 };
static const uint64_t default_memory = UINT64_C(1) << 30;

// ---- checks -------------------------------------------------------------------------------------

static enum weft_result check_derivatives(const struct weft_points_params *p)
{
    if (p->derivative_count < 0 || p->derivative_count > WEFT_DERIVATIVES ||
        (p->derivative_count && !p->derivative)) {
        weft_error(p->log, "%d derivatives: there must be 0 to %d", p->derivative_count,
                   WEFT_DERIVATIVES);
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < p->derivative_count; i++) {
        const int *n = p->derivative[i].along;
        for (int a = 0; a < 3; a++) {
            if (n[a] >= 0 && n[a] <= 2 && n[0] + n[1] + n[2] <= 2)
                continue;
            weft_error(p->log,
                       "derivative %d is (%d, %d, %d) times along x, y, z: at most 2 in all", i,
                       n[0], n[1], n[2]);
            return WEFT_ERR_ARGUMENT;
        }
    }
    return WEFT_OK;
}

static enum weft_result check_params(const struct weft_points_params *p)
{
    const struct weft_log *log = p->log;
    const enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, p->volume);
    weft_require_enum(log, p->space, WEFT_SPACE_INDEX);
    weft_require_enum(log, p->sums, WEFT_SUMS_DOUBLE);
    if (p->memory_bytes && p->memory_bytes < LEAST_MEMORY) {
        weft_error(log, "%llu bytes of memory for points: there must be %d or more",
                   (unsigned long long)p->memory_bytes, LEAST_MEMORY);
        return WEFT_ERR_LIMIT;
    }
    return check_derivatives(p);
fail:
    return res;
}

// ---- kernels ------------------------------------------------------------------------------------

// The highest order along one axis that some output has.
static int highest_order(const struct weft_points_info *info)
{
    int most = 0;
    for (int o = 0; o < info->output_count; o++)
        for (int a = 0; a < 3; a++)
            if (info->output[o].along[a] > most)
                most = info->output[o].along[a];
    return most;
}

static enum weft_result set_kernels(weft_points *p)
{
    p->kernel[0] = p->info.kernel;
    p->orders = 1 + highest_order(&p->info);
    for (int n = 1; n < p->orders; n++) {
        if (weft_kernel_derive(NULL, &p->kernel[n - 1], &p->kernel[n]) == WEFT_OK)
            continue;
        char name[160];
        weft_kernel_format(&p->info.kernel, name, sizeof name);
        weft_error(p->log, "kernel %s has no %s derivative, which is asked for%s", name,
                   n == 1 ? "first" : "second",
                   p->info.kernel.normalised ? ": its weights are divided by their sum" : "");
        return WEFT_ERR_UNSUPPORTED;
    }
    return WEFT_OK;
}

static enum weft_result set_weights(weft_points *p)
{
    const struct weft_polynomial_tiles *tiles[WEFT_LINE_ORDERS] = {NULL};
    for (int n = 0; n < p->orders; n++) {
        struct weft_kernel_facts *facts = weft_kernel_facts_find(&p->facts, &p->kernel[n]);
        if (!facts) {
            weft_error(p->log, "not enough memory for the kernel of points");
            return WEFT_ERR_MEMORY;
        }
        const enum weft_result res =
            weft_kernel_facts_weights(p->log, facts, 0, false, p->info.sums, &p->weights[n]);
        if (res != WEFT_OK)
            return res;
        tiles[n] = &p->weights[n]->tiles;
    }
    const enum weft_result res = weft_line_kernel_create(p->log, p->info.sums, tiles, &p->lines);
    if (res != WEFT_OK)
        return res;
    p->span = p->info.kernel.width + WEFT_BRICK_SIZE - 1;
    p->lines.pitch_y = (uint32_t)p->span;
    p->lines.pitch_z = (uint32_t)(p->span * p->span);
    const int *first = p->info.output[0].along;
    if (p->info.output_count > 1 || first[0] + first[1] + first[2] > 0) {
        p->lines.output_count = p->info.output_count;
        memcpy(p->lines.output, p->info.output, sizeof p->lines.output);
    }
    p->line = weft_line_find(p->info.cpu.instructions, &p->lines);
    return WEFT_OK;
}

static enum weft_result set_transform(weft_points *p)
{
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const struct weft_volume_info *volume = weft_volume_get_info(p->volume);
    const int width = p->info.kernel.width;
    p->tap_shift = width % 2 ? UINT32_C(1) << (WEFT_LINE_FRACTION - 1) : 0;
    p->tap_offset = width % 2 ? (width - 1) / 2 : width / 2 - 1;
    memcpy(p->to_index, identity, sizeof identity);
    if (p->info.space == WEFT_SPACE_INDEX ||
        weft_affine_invert(volume->index_to_world, p->to_index))
        return WEFT_OK;
    weft_error(p->log, "grid %s has a transform without an inverse", volume->name);
    return WEFT_ERR_FORMAT;
}

static enum weft_result set_voxels(weft_points *p)
{
    p->voxels = p->volume;
    if (!p->info.kernel.prefiltered)
        return WEFT_OK;
    struct weft_prefilter prefilter;
    enum weft_result res =
        weft_volume_prefilter(p->log, p->volume, &p->info.kernel, &p->coefficients);
    if (res == WEFT_OK)
        res = weft_prefilter_compute(p->log, &p->info.kernel, &prefilter);
    if (res == WEFT_OK)
        p->info.prefilter_overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    p->voxels = p->coefficients;
    return res;
}

// ---- creating -----------------------------------------------------------------------------------

static enum weft_result set_info(weft_points *p, const struct weft_points_params *params)
{
    struct weft_points_info *info = &p->info;
    p->log = params->log;
    p->volume = params->volume;
    p->memory_bytes = params->memory_bytes ? params->memory_bytes : default_memory;
    info->kernel = params->kernel;
    info->space = params->space;
    info->sums = params->sums;
    info->output_count = params->derivative_count ? params->derivative_count : 1;
    if (params->derivative_count)
        memcpy(info->output, params->derivative,
               (size_t)params->derivative_count * sizeof *info->output);
    enum weft_result res = WEFT_OK;
    if (!info->kernel.info)
        res = weft_kernel_create(p->log, weft_kernel_find("catmull-rom"), NULL, &info->kernel);
    if (res == WEFT_OK)
        res = weft_kernel_check(p->log, &info->kernel);
    if (res == WEFT_OK && info->kernel.radial) {
        weft_error(p->log, "points are not sampled with radial kernels such as %s",
                   info->kernel.info->name);
        res = WEFT_ERR_UNSUPPORTED;
    }
    return res == WEFT_OK ? weft_cpu_resolve(p->log, &params->cpu, &info->cpu) : res;
}

enum weft_result weft_points_create(const struct weft_points_params *params, weft_points **out)
{
    *out = NULL;
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    weft_points *p = calloc(1, sizeof *p);
    if (!p) {
        weft_error(params->log, "not enough memory to sample points");
        return WEFT_ERR_MEMORY;
    }
    res = set_info(p, params);
    if (res == WEFT_OK)
        res = set_kernels(p);
    if (res == WEFT_OK)
        res = set_transform(p);
    if (res == WEFT_OK)
        res = set_weights(p);
    if (res == WEFT_OK)
        res = set_voxels(p);
    if (res == WEFT_OK) {
        weft_points_set_bounds(p);
        *out = p;
    } else {
        weft_points_destroy(&p);
    }
    return res;
}

void weft_points_destroy(weft_points **points)
{
    weft_points *p = points ? *points : NULL;
    if (!p)
        return;
    if (p->bricks.volume)
        weft_brick_reader_close(&p->bricks);
    weft_line_kernel_destroy(&p->lines);
    weft_kernel_facts_destroy(&p->facts);
    weft_volume_destroy(&p->coefficients);
    free(p);
    *points = NULL;
}

const struct weft_points_info *weft_points_get_info(const weft_points *points)
{
    return &points->info;
}

// ---- bounds -------------------------------------------------------------------------------------

// Positions are rounded to multiples of 2^-29; their fractions, for sums in single precision, to
// 24 bits.
static double position_error(const weft_points *p, const struct weft_polynomial_tiles *tiles)
{
    const bool precise = p->info.sums == WEFT_SUMS_DOUBLE;
    const double unit = precise ? 0x1p-53 : 0x1p-24;
    return 0x1p-30 + (precise ? 0.0 : 0x1p-25) +
           (tiles->segments & (tiles->segments - 1) ? unit : 0.0);
}

static void set_bound(weft_points *p, int output)
{
    const struct weft_volume_info *volume = weft_volume_get_info(p->volume);
    const bool precise = p->info.sums == WEFT_SUMS_DOUBLE;
    const double unit = precise ? 0x1p-53 : 0x1p-24;
    struct weft_kernel kernel[3];
    double whole = 1.0, off = 1.0, levels = 0.0, largest = 1.0;
    for (int a = 0; a < 3; a++) {
        const int n = p->info.output[output].along[a];
        struct weft_kernel plain = kernel[a] = p->kernel[n];
        plain.prefiltered = false;
        const double gain = weft_analysis_gain(&plain);
        const struct weft_slice_weights *w = p->weights[n];
        whole *= gain;
        off *= gain + w->error + position_error(p, &w->tiles) * w->slope;
        largest = fmax(largest, gain);
        levels = levels * fmax(gain, 1.0) + 1.0;
    }
    // A product and the additions after it, on each of three levels: passes/fused/lines/lines.h.
    const double sums = 3 * p->info.kernel.width * unit;
    struct weft_bound_terms *bound = &p->info.bound[output];
    *bound = (struct weft_bound_terms){
        .relative = off * (1.0 + sums) - whole,
        // What is below 2^-126 has fewer bits.
        .absolute = 0x1p-125 * (p->info.kernel.width + largest) * levels,
        .rounded_gain = precise ? whole : 0.0,
        .prefilter = weft_prefilter_error_axes(kernel, 3, WEFT_VOLUME_PREFILTER_ERROR),
    };
    const double samples = p->coefficients ? bound->prefilter.gain : whole;
    bound->sample_rounding = strcmp(volume->type, "double") ? 0.0 : 1.0001 * 0x1p-24 * samples;
    bound->absolute_rounding = samples * volume->largest_rounding;
}

void weft_points_set_bounds(weft_points *p)
{
    double gain = 1.0;
    for (int n = 0; n < p->orders; n++) {
        struct weft_kernel plain = p->kernel[n];
        plain.prefiltered = false;
        gain = fmax(gain, weft_analysis_gain(&plain));
    }
    // Sums of these stay within a quarter of what floats hold.
    p->largest_fit = (float)(0.25 * FLT_MAX / pow(gain, 3));
    for (int o = 0; o < p->info.output_count; o++)
        set_bound(p, o);
}
