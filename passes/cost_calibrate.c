// SPDX-License-Identifier: BSD-3-Clause
// Small jobs whose times tell one unknown of the cost model after the other.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/cost.h"

enum { SIDE = 64, PIXELS = 256, RUNS = 5, STEPS = 34 };

struct calibration {
    const struct weft_log *log;
    weft_context *context;
    const struct weft_progress *progress;
    weft_volume *volume;
    struct weft_slice_measure measure;
    float *pixels;
    int steps;
    enum weft_result result;
    struct weft_cost_model model;
};

// One job: medians of its parts, in nanoseconds, and what it had to do.
struct timed {
    double whole, read, layout, passes; // layout: with upload; passes: with reading back
    double bricks, texels, fetches;     // voxels of bricks
    int pass_count;
    double tile_bytes;
};

static float noise(int i)
{
    uint32_t h = (uint32_t)i * 2654435761u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    return (float)(h >> 8) * 0x1p-24f;
}

static enum weft_result create_volume(struct calibration *c)
{
    const size_t count = (size_t)SIDE * SIDE * SIDE;
    float *data = malloc(count * sizeof *data);
    c->pixels = malloc((size_t)4 * PIXELS * PIXELS * sizeof *c->pixels);
    if (!data || !c->pixels) {
        free(data);
        weft_error(c->log, "not enough memory to calibrate with %zu voxels", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        data[i] = noise((int)i);
    c->measure = (struct weft_slice_measure){.low = 0.0, .high = 1.0, .voxels = count};
    const struct weft_volume_params *params =
        weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data, .log = c->log);
    enum weft_result res = weft_volume_create(params, &c->volume);
    free(data);
    return res;
}

static struct weft_slice_geometry plane(bool oblique, int pixels)
{
    struct weft_slice_geometry g = {.origin = {6.0, 7.0, 8.0}, .width = pixels, .height = pixels};
    memcpy(g.u, oblique ? (double[3]){44, 14, 20} : (double[3]){50, 0, 0}, sizeof g.u);
    memcpy(g.v, oblique ? (double[3]){-5, 34, 28} : (double[3]){0, 50, 0}, sizeof g.v);
    if (!oblique)
        g.origin[2] = 31.3;
    return g;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, RUNS, sizeof *values, compare);
    return 1e9 * values[RUNS / 2];
}

static enum weft_result run(struct calibration *c, const weft_way_plan *plan, struct timed *out)
{
    double whole[RUNS], read[RUNS], layout[RUNS], passes[RUNS];
    enum weft_result res = weft_way_run(c->context, plan, c->volume, c->pixels, NULL, NULL);
    for (int i = 0; res == WEFT_OK && i < RUNS; i++) {
        struct weft_way_report report;
        res = weft_way_run(c->context, plan, c->volume, c->pixels, NULL, &report);
        if (res != WEFT_OK)
            break;
        whole[i] = report.seconds;
        read[i] = report.read_seconds;
        layout[i] = report.layout_seconds + report.upload_seconds;
        passes[i] = report.pass_seconds + report.readback_seconds;
    }
    if (res != WEFT_OK)
        return res;
    const struct weft_way_plan_info *info = weft_way_plan_get_info(plan);
    *out = (struct timed){
        .whole = median(whole),
        .read = median(read),
        .layout = median(layout),
        .passes = median(passes),
        .bricks = 512.0 * (double)info->slice->bricks_read,
        .texels = (double)info->slice->source_texels,
        .fetches = info->fetches,
        .pass_count = info->passes ? (int)info->passes->passes->pass_count : 1,
        .tile_bytes = info->passes ? (double)info->passes->tile_bytes : 0.0,
    };
    return res;
}

// After a failure everything is 0 and nothing runs any more.
static struct timed timed(struct calibration *c, struct weft_way way, const char *kernel,
                          bool oblique, int pixels)
{
    struct timed out = {0};
    struct weft_way_params params = {
        .way = way,
        .measure = c->measure,
        .slice = {.space = WEFT_SPACE_INDEX, .geometry = plane(oblique, pixels), .log = c->log},
    };
    weft_way_plan *plan = NULL;
    if (c->result == WEFT_OK && c->progress && c->progress->report &&
        !c->progress->report(c->progress->priv, fmin(1.0, (double)c->steps / STEPS)))
        c->result = WEFT_ERR_CANCELLED;
    c->steps++;
    if (c->result == WEFT_OK)
        c->result = weft_kernel_parse(c->log, kernel, &params.slice.kernel);
    if (c->result == WEFT_OK)
        c->result = weft_way_plan_create(c->volume, &params, &plan);
    if (c->result == WEFT_OK)
        c->result = run(c, plan, &out);
    weft_way_plan_destroy(&plan);
    return c->result == WEFT_OK ? out : (struct timed){0};
}

static double positive(double x)
{
    return fmax(x, 1e-3);
}

// ---- the methods --------------------------------------------------------------------------------

static void calibrate_fused(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS;
    struct weft_way way = {.layout = WEFT_LAYOUT_INTERLEAVED};
    const struct timed linear = timed(c, way, "linear", true, PIXELS);
    const struct timed cubic = timed(c, way, "catmull-rom", true, PIXELS);
    const struct timed larger = timed(c, way, "catmull-rom", true, 2 * PIXELS);
    way.lookup = WEFT_LOOKUP_NEAREST;
    way.samples = 1;
    const struct timed flat = timed(c, way, "catmull-rom", true, PIXELS);
    way.samples = 64;
    const struct timed sampled = timed(c, way, "catmull-rom", true, PIXELS);
    way.lookup = WEFT_LOOKUP_POLYNOMIAL;
    m->voxel = positive(cubic.read / cubic.bricks);
    m->entry = positive((larger.layout - cubic.layout) / (3.0 * pixels));
    // Four coefficients against one, along three axes.
    m->weights = positive((cubic.passes - flat.passes) / (9.0 * pixels));
    m->weights_fetched = positive(m->weights + (sampled.passes - flat.passes) / (3.0 * pixels));
    const double fetch = ((cubic.passes - linear.passes) / pixels - 6.0 * m->weights) /
                         (cubic.fetches - linear.fetches);
    m->pixel = positive(cubic.passes / pixels - cubic.fetches * fetch - 12.0 * m->weights);
    for (int layout = 0; layout < WEFT_COST_LAYOUTS; layout++) {
        for (int source = 0; source < WEFT_SOURCE_FORMATS; source++) {
            way.layout = (enum weft_layout)(layout + 1);
            way.source = (enum weft_source_format)source;
            const struct timed t = timed(c, way, "catmull-rom", true, PIXELS);
            m->fetch[layout][source] =
                positive((t.passes / pixels - m->pixel - 12.0 * m->weights) / t.fetches);
            m->texel[layout][source] = positive((t.layout - pixels * m->entry) / t.texels);
        }
    }
    m->start = positive(cubic.whole - cubic.read - cubic.layout - cubic.passes);
}

static void calibrate_separable(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS, across = PIXELS;
    const struct weft_way way = {.method = WEFT_METHOD_SEPARABLE};
    const struct timed cubic = timed(c, way, "catmull-rom", false, 2 * PIXELS);
    const struct timed wide = timed(c, way, "bspline7", false, 2 * PIXELS);
    const double taps = 4.0 * pixels + 2.0 * across * sqrt(cubic.texels);
    m->summed = positive(0.5 * cubic.layout / (4.0 * cubic.texels));
    m->tap = positive((wide.passes - cubic.passes) / (4.0 * taps));
    m->separable_pixel = positive(
        (cubic.layout + cubic.passes - 4.0 * taps * m->tap - 4.0 * cubic.texels * m->summed) /
        (4.0 * pixels));
}

static void calibrate_passes(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    static const char *const profiles[WEFT_COST_TARGETS] = {
        [WEFT_TARGET_UNORM8] = "unorm8",
        [WEFT_TARGET_UNORM16] = "unorm16",
        [WEFT_TARGET_HALF] = "fp16",
        [WEFT_TARGET_FLOAT] = "fp32",
    };
    const double pixels = (double)PIXELS * PIXELS;
    double bytes = 0.0, tiles = 0.0;
    for (int t = 0; t < WEFT_COST_TARGETS; t++) {
        struct weft_way way = {.method = WEFT_METHOD_PASSES,
                               .samples = 16,
                               .profile = *weft_profile_find(profiles[t])};
        const struct timed many = timed(c, way, "catmull-rom", true, PIXELS);
        way.profile.taps_per_pass = 1;
        const struct timed one = timed(c, way, "catmull-rom", true, PIXELS);
        way.profile.taps_per_pass = weft_profile_find(profiles[t])->taps_per_pass;
        way.technique = WEFT_TECHNIQUE_DOT4;
        const struct timed dot4 = timed(c, way, "catmull-rom", true, PIXELS);
        // passes a + fetches b, for two plans.
        const double determinant = one.pass_count * many.fetches - many.pass_count * one.fetches;
        const double a =
            (one.passes * many.fetches - many.passes * one.fetches) / (pixels * determinant);
        m->pass[t] = positive(a);
        m->pass_fetch[t][0] =
            positive((many.passes / pixels - many.pass_count * m->pass[t]) / many.fetches);
        m->pass_fetch[t][1] =
            positive((dot4.passes / pixels - dot4.pass_count * m->pass[t]) / dot4.fetches);
        bytes += many.tile_bytes + dot4.tile_bytes;
        tiles += many.layout + dot4.layout;
    }
    m->tile_byte = positive(tiles / bytes);
}

enum weft_result weft_cost_calibrate(const struct weft_log *log, weft_context *context,
                                     const struct weft_progress *progress,
                                     struct weft_cost_model *out)
{
    struct calibration c = {.log = log, .context = context, .progress = progress};
    *out = (struct weft_cost_model){0};
    c.result = create_volume(&c);
    if (c.result == WEFT_OK) {
        calibrate_fused(&c);
        calibrate_separable(&c);
        calibrate_passes(&c);
    }
    if (c.result == WEFT_OK) {
        snprintf(c.model.renderer, sizeof c.model.renderer, "%s",
                 weft_context_get_info(context)->renderer);
        *out = c.model;
        if (progress && progress->report)
            progress->report(progress->priv, 1.0);
    }
    weft_volume_destroy(&c.volume);
    free(c.pixels);
    return c.result;
}
