// SPDX-License-Identifier: BSD-3-Clause
#include "passes/slice/slab.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

const char *const weft_combine_names[] = {"mean", "max", "min", "sum", NULL};

// In voxels, by default.
#define LARGEST_STEP 0.5

// Below this, cuts share nothing.
#define LEAST_MEMORY (UINT64_C(64) << 20)

// ---- where cuts lie -----------------------------------------------------------------------------

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double length_of(const double a[3])
{
    return hypot(hypot(a[0], a[1]), a[2]);
}

static void multiply(const double (*m)[4], const double a[3], double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = m[r][0] * a[0] + m[r][1] * a[1] + m[r][2] * a[2];
}

// The unit vector square to both edges in world space; false where there is none.
static bool find_normal(const struct weft_slab_params *p, double out[3])
{
    const double(*m)[4] = weft_volume_get_info(p->volume)->index_to_world;
    double edge[2][3];
    memcpy(edge[0], p->slice.geometry.u, sizeof edge[0]);
    memcpy(edge[1], p->slice.geometry.v, sizeof edge[1]);
    if (p->slice.space == WEFT_SPACE_INDEX) {
        multiply(m, p->slice.geometry.u, edge[0]);
        multiply(m, p->slice.geometry.v, edge[1]);
    }
    for (int e = 0; e < 2; e++) {
        const double length = length_of(edge[e]);
        for (int i = 0; i < 3; i++)
            edge[e][i] /= length;
    }
    cross(edge[0], edge[1], out);
    const double length = length_of(out);
    for (int i = 0; i < 3; i++)
        out[i] /= length;
    return length > 1e-9 && isfinite(length);
}

static enum weft_result count_cuts(const struct weft_slab_params *p, double voxels_in_unit,
                                   struct weft_slab_info *out)
{
    const double cuts =
        p->cuts ? (double)p->cuts
                : fmax(1.0, ceil(p->thickness * voxels_in_unit / LARGEST_STEP * (1.0 - 0x1p-40)));
    if (!(cuts <= WEFT_SLAB_MAX_CUTS)) {
        weft_error(p->slice.log,
                   "a slab of thickness %g, cut every %g, has %.3g cuts: there may be at most %d",
                   p->thickness, p->thickness / cuts, cuts, WEFT_SLAB_MAX_CUTS);
        return WEFT_ERR_LIMIT;
    }
    out->cuts = (int)cuts;
    out->spacing = p->thickness / cuts;
    out->voxels = out->spacing * voxels_in_unit;
    return WEFT_OK;
}

enum weft_result weft_slab_place(const struct weft_slab_params *p, struct weft_slab_info *out)
{
    struct weft_quantity_transform transform;
    double index[3];
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct weft_slab_info){0};
    weft_require(p->slice.log, p->volume != NULL && p->cuts >= 0);
    weft_require_enum(p->slice.log, p->combine, WEFT_COMBINE_COUNT - 1);
    weft_require_enum(p->slice.log, p->slice.space, WEFT_SPACE_INDEX);
    if (!(p->thickness > 0.0 && isfinite(p->thickness))) {
        weft_error(p->slice.log, "a slab's thickness is a length above 0, not %g", p->thickness);
        return res;
    }
    if (!find_normal(p, out->normal)) {
        weft_error(p->slice.log, "a slab's plane has edges of length 0, or parallel ones");
        goto fail;
    }
    res = weft_quantity_transform_create(
        p->slice.log, weft_volume_get_info(p->volume)->index_to_world, &transform);
    if (res != WEFT_OK)
        goto fail;
    for (int r = 0; r < 3; r++)
        index[r] = transform.inverse[r][0] * out->normal[0] +
                   transform.inverse[r][1] * out->normal[1] +
                   transform.inverse[r][2] * out->normal[2];
    res = count_cuts(p, length_of(index), out);
    if (res != WEFT_OK)
        goto fail;
    const double *along = p->slice.space == WEFT_SPACE_INDEX ? index : out->normal;
    for (int i = 0; i < 3; i++) {
        out->step[i] = along[i] * out->spacing;
        out->first[i] = -0.5 * (out->cuts - 1) * out->step[i];
    }
    out->output_count = p->quantities               ? p->quantities->channel_count
                        : p->slice.derivative_count ? p->slice.derivative_count
                                                    : 1;
    return WEFT_OK;
fail:
    *out = (struct weft_slab_info){0};
    return res;
}

// ---- cuts ---------------------------------------------------------------------------------------

// What is kept from cut to cut.
struct slab {
    const struct weft_slab_params *params;
    const struct weft_slice_compile_params *where;
    struct weft_slab_info info;
    struct weft_slice_params slice; // of a cut
    struct weft_quantity_transform transform;
    weft_resident *resident; // of the slab's own; NULL: the caller's, or none
    size_t count;            // pixels
    int made;                // planes that a cut has
    float *planes;           // these, and channels of them
    double *sums;            // of outputs, by pixel
    int missed;              // cuts that see the background alone
    struct weft_slice_report report;
};

static enum weft_result allocate(struct slab *s)
{
    const size_t outputs = (size_t)s->info.output_count;
    const size_t planes = (size_t)s->made + (s->params->quantities ? outputs : 0);
    size_t bytes[2];
    if (!weft_size_mul(s->count, planes * sizeof *s->planes, &bytes[0]) ||
        !weft_size_mul(s->count, outputs * sizeof *s->sums, &bytes[1])) {
        weft_error(s->slice.log, "a slab of %zu pixels and %zu outputs is too large", s->count,
                   outputs);
        return WEFT_ERR_LIMIT;
    }
    s->planes = malloc(bytes[0]);
    s->sums = malloc(bytes[1]);
    if (s->planes && s->sums)
        return WEFT_OK;
    weft_error(s->slice.log, "not enough memory for a slab of %zu pixels: %zu bytes", s->count,
               bytes[0] + bytes[1]);
    return WEFT_ERR_MEMORY;
}

// Where outputs of a cut are, one after the other.
static float *make_outputs(struct slab *s)
{
    const struct weft_quantities *list = s->params->quantities;
    const float *from[WEFT_DERIVATIVES];
    float *to[WEFT_QUANTITY_CHANNELS];
    if (!list)
        return s->planes;
    for (int i = 0; i < s->made; i++)
        from[i] = s->planes + (size_t)i * s->count;
    for (int i = 0; i < list->channel_count; i++)
        to[i] = s->planes + (size_t)(s->made + i) * s->count;
    weft_quantities_compute_planes(list, &s->transform, s->count, from, to);
    return to[0];
}

// Comparisons are written so that a NaN stays.
static void combine(struct slab *s, const float *outputs, bool first)
{
    const size_t count = s->count * (size_t)s->info.output_count;
    double *sum = s->sums;
    if (first) {
        for (size_t i = 0; i < count; i++)
            sum[i] = (double)outputs[i];
        return;
    }
    switch (s->params->combine) {
    case WEFT_COMBINE_MAX:
        for (size_t i = 0; i < count; i++)
            sum[i] = (double)outputs[i] <= sum[i] || sum[i] != sum[i] ? sum[i] : (double)outputs[i];
        break;
    case WEFT_COMBINE_MIN:
        for (size_t i = 0; i < count; i++)
            sum[i] = (double)outputs[i] >= sum[i] || sum[i] != sum[i] ? sum[i] : (double)outputs[i];
        break;
    default:
        for (size_t i = 0; i < count; i++)
            sum[i] += (double)outputs[i];
    }
}

static enum weft_result make_cut(struct slab *s, int index)
{
    const struct weft_slice_geometry *middle = &s->params->slice.geometry;
    struct weft_slice_report report;
    weft_slice_plan *plan = NULL;
    for (int i = 0; i < 3; i++)
        s->slice.geometry.origin[i] =
            middle->origin[i] + s->info.first[i] + index * s->info.step[i];
    enum weft_result res = weft_slice_plan_create(s->params->volume, &s->slice, &plan);
    if (res == WEFT_OK)
        res = weft_slice_run_once(plan, s->where, weft_slice_run_params(.pixels = s->planes),
                                  &report);
    s->missed += res == WEFT_OK && weft_slice_plan_get_info(plan)->misses_volume;
    weft_slice_plan_destroy(&plan);
    if (res != WEFT_OK)
        return res;
    combine(s, make_outputs(s), index == 0);
    weft_slice_report_add(&s->report, &report);
    s->report.cpu = report.cpu;
    return WEFT_OK;
}

// ---- the slab -----------------------------------------------------------------------------------

// Means are of the sum of all samples, and integrals the means times the thickness.
static void write_outputs(struct slab *s, const struct weft_slice_run_params *run)
{
    const int64_t width = s->slice.geometry.width, height = s->slice.geometry.height;
    const int64_t stride = run->stride ? run->stride : width;
    const int64_t plane = run->plane_stride ? run->plane_stride : height * stride;
    const bool adds =
        s->params->combine == WEFT_COMBINE_MEAN || s->params->combine == WEFT_COMBINE_SUM;
    const double factor = s->params->combine == WEFT_COMBINE_SUM ? s->params->thickness : 1.0;
    struct weft_statistics pixels = WEFT_STATISTICS_NONE;
    for (int o = 0; o < s->info.output_count; o++)
        for (int64_t y = 0; y < height; y++) {
            const double *from = s->sums + (size_t)o * s->count + (size_t)(y * width);
            float *to = run->pixels + o * plane + y * stride;
            for (int64_t x = 0; x < width; x++)
                to[x] = (float)(adds ? factor * (from[x] / s->info.cuts) : from[x]);
            weft_statistics_add(&pixels, to, (size_t)width);
        }
    s->report.minimum = (float)pixels.minimum;
    s->report.maximum = (float)pixels.maximum;
    s->report.not_finite = pixels.not_finite;
}

static bool tell(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

// What stays of the volume from cut to cut, unless the caller has that.
static enum weft_result keep_volume(struct slab *s)
{
    const struct weft_slice_params *p = &s->params->slice;
    const uint64_t memory = p->memory_bytes ? p->memory_bytes : UINT64_C(1) << 30;
    if (p->resident || s->info.cuts == 1 || memory < LEAST_MEMORY)
        return WEFT_OK;
    const struct weft_resident_params params = {
        .volume = s->params->volume,
        .context = p->engine == WEFT_ENGINE_GL ? s->where->context : NULL,
        .kernel = p->kernel,
        .layout = p->layout,
        .source = p->source,
        .low = p->low,
        .high = p->high,
        .memory_bytes = memory / 4,
        .brick_bytes = memory / 4,
        .log = p->log,
    };
    const enum weft_result res = weft_resident_create(&params, &s->resident);
    s->slice.resident = s->resident;
    s->slice.memory_bytes = memory / 4;
    return res;
}

// What cannot be planned is refused before anything is allocated for it.
static enum weft_result try_plane(const struct slab *s)
{
    weft_slice_plan *plan = NULL;
    const enum weft_result res = weft_slice_plan_create(s->params->volume, &s->slice, &plan);
    weft_slice_plan_destroy(&plan);
    return res;
}

// Where no cut meets the volume, what is told of the plane in the middle.
static enum weft_result warn_of_miss(struct slab *s)
{
    if (s->missed < s->info.cuts || s->params->slice.may_miss)
        return WEFT_OK;
    s->slice.geometry = s->params->slice.geometry;
    s->slice.may_miss = false;
    return try_plane(s);
}

static enum weft_result start(struct slab *s)
{
    const struct weft_slab_params *p = s->params;
    enum weft_result res = weft_slab_place(p, &s->info);
    if (res == WEFT_OK)
        res = weft_quantity_transform_create(
            p->slice.log, weft_volume_get_info(p->volume)->index_to_world, &s->transform);
    if (res != WEFT_OK)
        return res;
    s->slice = p->slice;
    s->slice.footprint = NULL;
    s->slice.progress = NULL;
    s->slice.may_miss = true;
    if (p->quantities) {
        s->slice.derivative = p->quantities->derivative;
        s->slice.derivative_count = p->quantities->derivative_count;
    }
    s->made = s->slice.derivative_count ? s->slice.derivative_count : 1;
    s->count = (size_t)p->slice.geometry.width * (size_t)p->slice.geometry.height;
    res = try_plane(s);
    if (res == WEFT_OK)
        res = allocate(s);
    return res == WEFT_OK ? keep_volume(s) : res;
}

enum weft_result weft_slab_run(const struct weft_slab_params *params,
                               const struct weft_slice_compile_params *where,
                               const struct weft_slice_run_params *run,
                               struct weft_slice_report *report)
{
    struct slab s = {.params = params, .where = where};
    const struct weft_slice_geometry *g = &params->slice.geometry;
    const struct weft_rectangle *part = &params->slice.part;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->slice.log, run->pixels && !where->passes && !where->hardware);
    weft_require(params->slice.log, g->width > 0 && g->height > 0);
    weft_require(params->slice.log, !part->x && !part->y && !part->width && !part->height);
    weft_require(params->slice.log, !run->stride || run->stride >= g->width);
    res = start(&s);
    for (int i = 0; i < s.info.cuts && res == WEFT_OK; i++) {
        res = make_cut(&s, i);
        if (res == WEFT_OK && !tell(run->progress, (double)(i + 1) / s.info.cuts))
            res = WEFT_ERR_CANCELLED;
    }
    if (res == WEFT_OK)
        res = warn_of_miss(&s);
    if (res == WEFT_OK)
        write_outputs(&s, run);
    if (res == WEFT_OK && report)
        *report = s.report;
fail:
    weft_resident_destroy(&s.resident);
    free(s.planes);
    free(s.sums);
    return res;
}
