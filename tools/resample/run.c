// SPDX-License-Identifier: BSD-3-Clause
// Runs the plans of `weft resample` over the tiles of the result. The tiles are fixed by the sizes
// alone, so that the result does not depend on anything else.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// Pixels along a tile's side, and samples that it reaches: what does not fit is cut.
enum { MAX_TILE = 1024, MAX_REACH = 2048, MIN_TILE = 16 };

// One tile of one group.
struct tile {
    int x, y, width, height; // of the result
    int from[2], size[2];    // of the input that it reaches
    double *at[2];           // of its columns and rows, in those samples
    float *plane[RESAMPLE_MAX_TOGETHER], *pixels[RESAMPLE_MAX_TOGETHER];
};

struct runner {
    struct resample_job *job;
    struct resample_group *group;
    bool verify;
    double steps, step;        // of the progress: a tile of a group, run or verified
    double square_sum, finite; // of the errors of a group
};

static const float *source_plane(const struct runner *r, int c)
{
    return resample_source_plane(r->job, r->group->channel[c]);
}

static float *result_plane(const struct runner *r, int c)
{
    return r->job->result.channels[r->group->channel[c]].plane;
}

static size_t image_pixels(const struct weft_image *image)
{
    return (size_t)image->width * (size_t)image->height;
}

// Samples of a source plane along an axis.
static int source_size(const struct runner *r, int axis)
{
    return (axis ? r->job->image.height : r->job->image.width) + 2 * r->job->pad;
}

// ---- progress -----------------------------------------------------------------------------------

static bool report_step(void *priv, double fraction)
{
    const struct runner *r = priv;
    const struct weft_progress *outer = report_progress(r->verify ? "verifying" : "resampling");
    return outer->report(outer->priv, (r->step + fraction) / r->steps);
}

// ---- tiles --------------------------------------------------------------------------------------

// Of the result's pixel, from the source's first sample on.
static double position(const struct runner *r, int axis, int pixel)
{
    return resample_position(&r->job->place[axis], pixel, r->job->pad);
}

static int tile_side(const struct runner *r, int axis)
{
    const struct resample_place *place = &r->job->place[axis];
    const double side = floor(MAX_REACH * (double)place->to / (double)place->from);
    return side > MAX_TILE ? MAX_TILE : side < MIN_TILE ? MIN_TILE : (int)side;
}

static int tile_count(const struct runner *r, int axis)
{
    const int size = axis ? r->job->result.height : r->job->result.width;
    return (size + tile_side(r, axis) - 1) / tile_side(r, axis);
}

// Samples from the first pixel's first tap to the last one's last, or the edge's if there are none.
static void set_reach(const struct runner *r, int axis, int first, int count, struct tile *tile)
{
    const int64_t last = source_size(r, axis) - 1;
    const struct weft_kernel *kernel = &weft_pass_plan_get_info(r->group->plan)->kernel;
    double fraction;
    int64_t from = weft_kernel_first_tap(kernel, position(r, axis, first), &fraction);
    int64_t to = weft_kernel_first_tap(kernel, position(r, axis, first + count - 1), &fraction) +
                 kernel->width - 1;
    from = from < 0 ? 0 : from > last ? last : from;
    to = to > last ? last : to < 0 ? 0 : to;
    tile->from[axis] = (int)from;
    tile->size[axis] = (int)(to - from) + 1;
}

static bool allocate_tile(const struct runner *r, struct tile *tile)
{
    const size_t samples = (size_t)tile->size[0] * (size_t)tile->size[1];
    bool done = true;
    for (int a = 0; a < 2; a++)
        done = (tile->at[a] = malloc((size_t)(a ? tile->height : tile->width) *
                                     sizeof *tile->at[a])) != NULL &&
               done;
    for (int c = 0; c < r->group->count; c++) {
        tile->plane[c] = malloc(samples * sizeof(float));
        tile->pixels[c] = malloc((size_t)tile->width * (size_t)tile->height * sizeof(float));
        done = done && tile->plane[c] && tile->pixels[c];
    }
    if (!done)
        report_error("out of memory: a tile of %d x %d pixels from %d x %d samples", tile->width,
                     tile->height, tile->size[0], tile->size[1]);
    return done;
}

static void fill_tile(const struct runner *r, struct tile *tile)
{
    for (int x = 0; x < tile->width; x++)
        tile->at[0][x] =
            resample_position(&r->job->place[0], tile->x + x, r->job->pad - tile->from[0]);
    for (int y = 0; y < tile->height; y++)
        tile->at[1][y] =
            resample_position(&r->job->place[1], tile->y + y, r->job->pad - tile->from[1]);
    for (int c = 0; c < r->group->count; c++)
        for (int y = 0; y < tile->size[1]; y++)
            memcpy(tile->plane[c] + (size_t)y * (size_t)tile->size[0],
                   source_plane(r, c) + (size_t)(tile->from[1] + y) * (size_t)source_size(r, 0) +
                       tile->from[0],
                   (size_t)tile->size[0] * sizeof(float));
}

static enum weft_result create_tile(const struct runner *r, int column, int row, struct tile *out)
{
    const struct weft_image *result = &r->job->result;
    const int side[2] = {tile_side(r, 0), tile_side(r, 1)};
    *out = (struct tile){.x = column * side[0], .y = row * side[1]};
    out->width = result->width - out->x < side[0] ? result->width - out->x : side[0];
    out->height = result->height - out->y < side[1] ? result->height - out->y : side[1];
    set_reach(r, 0, out->x, out->width, out);
    set_reach(r, 1, out->y, out->height, out);
    if (!allocate_tile(r, out))
        return WEFT_ERR_MEMORY;
    fill_tile(r, out);
    return WEFT_OK;
}

static void destroy_tile(struct tile *tile)
{
    free(tile->at[0]);
    free(tile->at[1]);
    for (int c = 0; c < RESAMPLE_MAX_TOGETHER; c++) {
        free(tile->plane[c]);
        free(tile->pixels[c]);
    }
}

// Between the tile's own pixels and the result's.
static void copy_pixels(const struct runner *r, const struct tile *tile, bool to_result)
{
    const size_t width = (size_t)r->job->result.width, row = (size_t)tile->width;
    for (int c = 0; c < r->group->count; c++) {
        for (int y = 0; y < tile->height; y++) {
            float *at = result_plane(r, c) + (size_t)(tile->y + y) * width + tile->x;
            float *own = tile->pixels[c] + (size_t)y * row;
            memcpy(to_result ? at : own, to_result ? own : at, row * sizeof(float));
        }
    }
}

static void add_report(struct weft_multipass_report *sum, const struct weft_multipass_report *one)
{
    const struct {
        uint64_t *largest, value;
    } sizes[] = {
        {&sum->source_bytes, one->source_bytes},
        {&sum->tile_bytes, one->tile_bytes},
        {&sum->target_bytes, one->target_bytes},
        {&sum->position_bytes, one->position_bytes},
    };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        if (sizes[i].value > *sizes[i].largest)
            *sizes[i].largest = sizes[i].value;
    sum->prepare_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
}

// RMS is over all tiles; the maximum is told with its place in the result.
static void add_error(struct runner *r, const struct tile *tile,
                      const struct weft_multipass_error *one)
{
    struct weft_multipass_error *sum = &r->group->error;
    double finite = 0.0;
    for (int c = 0; c < r->group->count; c++)
        for (size_t i = 0; i < (size_t)tile->width * (size_t)tile->height; i++)
            finite += isfinite(tile->pixels[c][i]) ? 1.0 : 0.0;
    r->square_sum += one->rms * one->rms * finite;
    r->finite += finite;
    sum->rms = r->finite > 0.0 ? sqrt(r->square_sum / r->finite) : 0.0;
    sum->not_finite_mismatches += one->not_finite_mismatches;
    if (one->maximum > sum->maximum) {
        sum->maximum = one->maximum;
        sum->at_x = tile->x + one->at_x;
        sum->at_y = tile->y + one->at_y;
        sum->channel = one->channel;
    }
}

static enum weft_result convolve_tile(struct runner *r, struct tile *tile)
{
    const struct weft_progress progress = {report_step, r};
    struct weft_samples samples = {
        .size = {tile->size[0], tile->size[1], 1}, .low = r->group->low, .high = r->group->high};
    const struct weft_pixel_grid grid = {
        .width = tile->width,
        .height = tile->height,
        .columns = tile->at[0],
        .rows = tile->at[1],
    };
    struct weft_multipass_params params = {.plan = r->group->plan,
                                           .samples = &samples,
                                           .grid = &grid,
                                           .progress = &progress,
                                           .log = report_log()};
    for (int c = 0; c < r->group->count; c++) {
        samples.plane[c] = tile->plane[c];
        params.pixels[c] = tile->pixels[c];
    }
    struct weft_multipass_report report = {0};
    struct weft_multipass_error error = {0};
    enum weft_result res;
    if (r->verify) {
        copy_pixels(r, tile, false);
        res = weft_multipass_verify(&params, &error);
        if (res == WEFT_OK)
            add_error(r, tile, &error);
        return res;
    }
    res = r->job->option[RESAMPLE_EMULATE].given
              ? weft_multipass_emulate(&params, &report)
              : weft_multipass_run(r->job->context, &params, &report);
    if (res != WEFT_OK)
        return res;
    copy_pixels(r, tile, true);
    add_report(&r->job->report, &report);
    r->job->tiles++;
    return res;
}

static enum weft_result run_tile(struct runner *r, int column, int row)
{
    struct tile tile;
    enum weft_result res = create_tile(r, column, row, &tile);
    if (res == WEFT_OK)
        res = convolve_tile(r, &tile);
    destroy_tile(&tile);
    r->step++;
    return res;
}

static enum weft_result each_tile(struct runner *r)
{
    const int columns = tile_count(r, 0), count = columns * tile_count(r, 1);
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < count; i++)
        res = report_step(r, 0.0) ? run_tile(r, i % columns, i / columns) : WEFT_ERR_CANCELLED;
    return res;
}

// ---- groups -------------------------------------------------------------------------------------

void resample_measure_result(const struct resample_job *job, struct resample_group *g)
{
    const size_t count = image_pixels(&job->result);
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    for (int c = 0; c < g->count; c++)
        weft_statistics_add(&s, job->result.channels[g->channel[c]].plane, count);
    g->minimum = s.minimum;
    g->maximum = s.maximum;
    g->not_finite = s.not_finite;
    g->bound = resample_bound(job, g, weft_statistics_magnitude(&s));
}

static enum weft_result verify_groups(struct runner *r)
{
    enum weft_result res = WEFT_OK;
    if (r->job->coefficients)
        return resample_verify_samples(r->job);
    r->verify = true;
    r->step = 0.0;
    for (size_t g = 0; res == WEFT_OK && g < r->job->group_count; g++) {
        r->group = &r->job->group[g];
        r->square_sum = r->finite = 0.0;
        res = each_tile(r);
    }
    return res;
}

enum weft_result resample_run(struct resample_job *job)
{
    struct runner r = {.job = job, .group = job->group};
    enum weft_result res = WEFT_OK;
    r.steps = (double)tile_count(&r, 0) * tile_count(&r, 1) * (double)job->group_count;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++) {
        r.group = &job->group[g];
        res = each_tile(&r);
        if (res == WEFT_OK)
            resample_measure_result(job, r.group);
    }
    double start = report_now_seconds();
    if (res == WEFT_OK && job->option[RESAMPLE_VERIFY].given)
        res = verify_groups(&r);
    job->verify_seconds = report_now_seconds() - start;
    return res;
}
