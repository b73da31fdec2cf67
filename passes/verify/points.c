// SPDX-License-Identifier: BSD-3-Clause
// Points for the verifier: pixels of one row, and a volume's voxels as they are needed.
#include <limits.h>
#include <math.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "passes/points/points_impl.h"
#include "passes/verify/verifier.h"

// What bricks may take, and about how long one takes to come.
enum { MOST_KEPT = 1 << 28 };
static const double brick_seconds = 1e-4;
// As far as samples count beside coefficients.
static const double cut = 0x1p-40;

struct subject {
    const weft_points *points;
    const struct weft_points_run_params *run;
    int output;
    size_t stride;
    struct weft_kernel kernel[3]; // of the output, by axis
    int overlap;                  // of prefiltered ones
    struct weft_prefilter prefilter;
    struct weft_brick_reader bricks; // of the volume itself
    struct weft_brick_cursor cursor;
    bool lost; // the last position asked for is none
};

static void position(void *priv, int x, int y, const double moved[3], double out[3])
{
    struct subject *s = priv;
    const weft_points *p = s->points;
    const double *at = s->run->position[x];
    double index[3];
    (void)y;
    s->lost = false;
    for (int a = 0; a < 3; a++) {
        const double *m = p->to_index[a];
        index[a] = p->info.space == WEFT_SPACE_INDEX
                       ? at[a]
                       : m[0] * at[0] + m[1] * at[1] + m[2] * at[2] + m[3];
        s->lost = s->lost || !(fabs(index[a]) <= WEFT_INDEX_LIMIT - 64.0);
    }
    for (int a = 0; a < 3; a++) {
        const double whole = s->lost ? 0.0 : floor(index[a]);
        const double rest = s->lost ? 0.0 : index[a] - whole + (moved ? moved[a] : 0.0);
        out[a] = whole + ldexp(floor(ldexp(rest, WEFT_LINE_FRACTION) + 0.5), -WEFT_LINE_FRACTION);
    }
}

// Jumps are met by fractions of 24 bits.
static double margin(void *priv, const double at[3])
{
    const struct subject *s = priv;
    (void)at;
    for (int a = 0; a < 3; a++)
        if (s->kernel[a].continuity < 0)
            return 0x1p-23;
    return 0.0;
}

static double pixel(void *priv, int channel, int x, int y)
{
    const struct subject *s = priv;
    (void)channel;
    (void)y;
    return (double)s->run->out[(size_t)s->output * s->stride + (size_t)x];
}

// ---- voxels -------------------------------------------------------------------------------------

static double fetch(void *priv, const int64_t index[3])
{
    struct subject *s = priv;
    return (double)weft_brick_cursor_voxel(&s->cursor, (int32_t)index[0], (int32_t)index[1],
                                           (int32_t)index[2]);
}

static enum weft_result load(struct subject *s, const double at[3])
{
    struct weft_cell_map bricks = {0};
    int32_t min[3], max[3];
    double fraction;
    for (int a = 0; a < 3; a++) {
        min[a] = (int32_t)weft_kernel_first_tap(&s->kernel[a], at[a], &fraction) - s->overlap;
        max[a] = min[a] + s->kernel[a].width - 1 + 2 * s->overlap;
    }
    if (s->bricks.borrowed) {
        s->cursor = (struct weft_brick_cursor){.store = s->bricks.store};
        return WEFT_OK;
    }
    if (s->bricks.kept_bytes > MOST_KEPT)
        weft_brick_reader_drop(&s->bricks);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (weft_brick_reader_note(&s->bricks, min, max, &bricks))
        res = weft_brick_reader_load(&s->bricks, &bricks);
    else
        weft_error(s->points->log, "not enough memory to verify points");
    s->cursor = (struct weft_brick_cursor){.store = s->bricks.store};
    weft_cell_map_destroy(&bricks);
    return res;
}

// The sum over the samples themselves. Samples that are not finite count as 0 in it; whether they
// are worth so much that the result is missing is not verified.
static void sum_samples(struct subject *s, const double at[3], struct weft_reference_value *out)
{
    double weight[3][WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    int64_t first[3], index[3];
    const int count = s->kernel[0].width + 2 * s->overlap;
    *out = (struct weft_reference_value){0};
    for (int a = 0; a < 3; a++)
        first[a] =
            weft_prefilter_weights(&s->prefilter, &s->kernel[a], s->overlap, at[a], weight[a]);
    for (int z = 0; z < count; z++) {
        index[2] = first[2] + z;
        for (int y = 0; y < count; y++) {
            double line = 0.0;
            index[1] = first[1] + y;
            for (int x = 0; x < count; x++) {
                index[0] = first[0] + x;
                const double sample = fetch(s, index);
                if (!isfinite(sample))
                    continue;
                line += weight[0][x] * sample;
                out->magnitude = fmax(out->magnitude, fabs(sample));
            }
            sum += weight[2][z] * weight[1][y] * line;
        }
    }
    out->value = sum;
}

static enum weft_result refer(void *priv, int channel, const double at[3], bool finite,
                              struct weft_reference_value *out)
{
    struct subject *s = priv;
    (void)channel;
    *out = (struct weft_reference_value){.value = NAN};
    if (s->lost || (s->overlap && !finite))
        return WEFT_OK;
    const enum weft_result res = load(s, at);
    if (res == WEFT_OK && s->overlap)
        sum_samples(s, at, out);
    else if (res == WEFT_OK)
        *out = weft_reference_compute_axes(s->kernel, 3, at, fetch, s);
    return res;
}

// ---- the call -----------------------------------------------------------------------------------

// Of voxels up to m: proportional to m, but for what is absolute. Prefiltered kernels: of what was
// measured.
static void set_bound(const struct subject *s, const struct weft_points_report *report,
                      struct weft_verifier *v)
{
    static const struct weft_bound_values none, one = {-1.0, 1.0, -1.0, 1.0, 0.0, 0.0};
    struct weft_bound_terms terms = s->points->info.bound[s->output];
    if (s->overlap) {
        v->bound_absolute = weft_bound_compute(&terms, &report->values).total;
        return;
    }
    v->bound_absolute = weft_bound_compute(&terms, &none).total;
    terms.absolute = terms.absolute_rounding = 0.0;
    v->bound_relative = weft_bound_compute(&terms, &one).total;
}

static enum weft_result verify_output(struct subject *s, const struct weft_points_report *report,
                                      const struct weft_verify_params *params,
                                      struct weft_verify_report *out)
{
    const int count = (int)s->run->count;
    struct weft_verifier v = {
        .width = count,
        .height = 1,
        .pixels = {0, 0, count, 1},
        .channels = 1,
        .priv = s,
        .position = position,
        .margin = margin,
        .refer = refer,
        .pixel = pixel,
        .part_count = 1,
        .seconds = weft_verifier_seconds(&s->points->info.kernel, 3) + brick_seconds,
        .how = *params,
        .log = s->points->log,
    };
    for (int a = 0; a < 3; a++) {
        s->kernel[a] = s->points->kernel[s->points->info.output[s->output].along[a]];
        v.jumps = v.jumps || s->kernel[a].continuity < 0;
    }
    if (s->overlap) {
        const double reach = s->points->info.kernel.width + 2 * s->overlap;
        v.far = true;
        v.seconds = 1e-8 * reach * reach * reach + 64 * brick_seconds;
    }
    set_bound(s, report, &v);
    return weft_verifier_run(&v, out);
}

enum weft_result weft_points_verify(const weft_points *points,
                                    const struct weft_points_run_params *run,
                                    const struct weft_points_report *report,
                                    const struct weft_verify_params *params,
                                    struct weft_verify_report *out)
{
    static const struct weft_verify_params defaults;
    struct weft_verify_params how = params ? *params : defaults;
    struct subject s = {
        .points = points, .run = run, .stride = run->stride ? run->stride : run->count};
    struct weft_region all = {.min = {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
                              .max = {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT}};
    const int outputs = points->info.output_count;
    enum weft_result res = WEFT_OK;
    memset(out, 0, (size_t)outputs * sizeof *out);
    if (run->count > INT_MAX) {
        weft_error(points->log, "%zu points to verify: at most %d are", run->count, INT_MAX);
        return WEFT_ERR_ARGUMENT;
    }
    if (!run->count)
        return WEFT_OK;
    how.max_seconds = (how.max_seconds > 0.0 ? how.max_seconds : 10.0) / outputs;
    if (points->info.kernel.prefiltered) {
        res = weft_prefilter_compute(points->log, &points->info.kernel, &s.prefilter);
        s.overlap = weft_prefilter_overlap(&s.prefilter, cut);
    }
    if (res == WEFT_OK && !weft_brick_reader_borrow(points->log, points->volume, &s.bricks))
        res = weft_brick_reader_open(points->log, points->volume, &all, &s.bricks);
    for (s.output = 0; res == WEFT_OK && s.output < outputs; s.output++)
        res = verify_output(&s, report, &how, &out[s.output]);
    if (s.bricks.volume)
        weft_brick_reader_close(&s.bricks);
    return res;
}
