// SPDX-License-Identifier: BSD-3-Clause
// What is the same of a request whichever engine runs it: checks, progress, sums.
#include <math.h>

#include "passes/resample/resample_impl.h"

// Their kernels were both checked; parameters that only E1 tells apart do not matter.
static bool reads_the_same(const struct weft_kernel *a, const struct weft_kernel *b)
{
    return a->prefiltered == b->prefiltered && (!a->prefiltered || a->info == b->info);
}

enum weft_result weft_resample_check_source(const struct weft_log *log,
                                            const weft_resample_plan *plan,
                                            const weft_resample_source *source)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, source);
    const struct weft_resample_source_info *from = &source->info;
    const struct weft_resample_info *to = &plan->info;
    if (from->width != to->size[0] || from->height != to->size[1]) {
        weft_error(log, "resampling a source of %d x %d samples by a plan for %d x %d", from->width,
                   from->height, to->size[0], to->size[1]);
        goto fail;
    }
    if (!reads_the_same(&from->kernel, &to->kernel)) {
        weft_error(log, "resampling with %s%s a source that was made for %s%s",
                   to->kernel.info->name, to->kernel.prefiltered ? ", prefiltered," : "",
                   from->kernel.info->name, from->kernel.prefiltered ? ", prefiltered" : "");
        goto fail;
    }
    if (from->boundary != to->boundary) {
        weft_error(log, "resampling with boundary %s a source that was made for %s",
                   weft_boundary_names[to->boundary], weft_boundary_names[from->boundary]);
        goto fail;
    }
    res = WEFT_OK;
fail:
    return res;
}

// ---- parts --------------------------------------------------------------------------------------

// Where a part's first and last taps along an axis lie. Tiles of passes round positions otherwise,
// by less than a sample.
static void find_reach(const weft_resample_plan *plan, int axis, int first, int count,
                       int32_t *from, int32_t *size)
{
    const int64_t last = plan->info.size[axis] - 1, more = plan->info.passes ? 1 : 0;
    const struct weft_kernel *kernel = &plan->info.kernel;
    const struct weft_window_map *map = &plan->info.map[axis];
    double fraction;
    int64_t low =
        weft_kernel_first_tap(kernel, weft_window_map_position(map, first, 0), &fraction) - more;
    int64_t high = weft_kernel_first_tap(
                       kernel, weft_window_map_position(map, first + count - 1, 0), &fraction) +
                   kernel->width - 1 + more;
    low = low < 0 ? 0 : low > last ? last : low;
    high = high > last ? last : high < 0 ? 0 : high;
    *from = (int32_t)low;
    *size = (int32_t)(high - low) + 1;
}

// What clamping looks at beside: of kernels narrower than that, more than they reach.
static struct weft_rectangle with_next(const weft_resample_plan *plan,
                                       const struct weft_rectangle *pixels,
                                       struct weft_rectangle reach)
{
    int columns[2], rows[2];
    if (!plan->info.clamp)
        return reach;
    weft_resample_next_reach(plan, 0, pixels->x, pixels->width, columns);
    weft_resample_next_reach(plan, 1, pixels->y, pixels->height, rows);
    const int x = reach.x < columns[0] ? reach.x : columns[0];
    const int y = reach.y < rows[0] ? reach.y : rows[0];
    const int right = reach.x + reach.width, bottom = reach.y + reach.height;
    return (struct weft_rectangle){x, y, (right > columns[1] ? right : columns[1] + 1) - x,
                                   (bottom > rows[1] ? bottom : rows[1] + 1) - y};
}

struct weft_rectangle weft_resample_reach(const weft_resample_plan *plan,
                                          const struct weft_rectangle *part)
{
    const struct weft_resample_info *info = &plan->info;
    struct weft_rectangle pixels, out;
    if (weft_rectangle_within(NULL, part, info->width, info->height, &pixels) != WEFT_OK)
        return (struct weft_rectangle){0};
    if (info->kernel.prefiltered)
        return (struct weft_rectangle){0, 0, info->size[0], info->size[1]};
    if (plan->separable)
        return with_next(plan, &pixels, weft_separable_reach(plan->separable, &pixels));
    find_reach(plan, 0, pixels.x, pixels.width, &out.x, &out.width);
    find_reach(plan, 1, pixels.y, pixels.height, &out.y, &out.height);
    return with_next(plan, &pixels, out);
}

enum weft_result weft_resample_check_reach(const struct weft_log *log,
                                           const weft_resample_plan *plan,
                                           const struct weft_rectangle *part,
                                           const struct weft_rectangle *window)
{
    const struct weft_rectangle reach = weft_resample_reach(plan, part);
    if (reach.x >= window->x && reach.y >= window->y &&
        reach.x + reach.width <= window->x + window->width &&
        reach.y + reach.height <= window->y + window->height)
        return WEFT_OK;
    weft_error(
        log,
        "resampling: %d x %d samples from (%d, %d) on, where the part's pixels reach %d x %d "
        "from (%d, %d) on",
        window->width, window->height, window->x, window->y, reach.width, reach.height, reach.x,
        reach.y);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_resample_check_request(const struct weft_log *log,
                                             const weft_resample_plan *plan,
                                             const weft_resample_source *source,
                                             struct weft_rectangle *part, const float *const *plane,
                                             int64_t *stride)
{
    enum weft_result res = weft_resample_check_source(log, plan, source);
    if (res == WEFT_OK)
        res = weft_rectangle_within(log, part, plan->info.width, plan->info.height, part);
    if (res == WEFT_OK)
        res = weft_resample_check_reach(log, plan, part, &source->info.window);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    *stride = *stride ? *stride : part->width;
    if (*stride < part->width) {
        weft_error(log, "resampling: a stride of %lld floats is less than the %d pixels of a row",
                   (long long)*stride, part->width);
        goto fail;
    }
    for (int c = 0; plane && c < source->info.channels; c++)
        weft_require(log, plane[c]);
    res = WEFT_OK;
fail:
    return res;
}

// ---- progress and sums --------------------------------------------------------------------------

bool weft_resample_report_step(void *priv, double fraction)
{
    const struct weft_resample_steps *s = priv;
    return !s->outer || !s->outer->report ||
           s->outer->report(s->outer->priv, (s->step + fraction) / s->steps);
}

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

void weft_resample_work_add(struct weft_resample_work *sum, const struct weft_resample_work *one)
{
    sum->tiles += one->tiles;
    sum->cpu = one->cpu;
    sum->prepare_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->source_bytes = larger(sum->source_bytes, one->source_bytes);
    sum->tile_bytes = larger(sum->tile_bytes, one->tile_bytes);
    sum->target_bytes = larger(sum->target_bytes, one->target_bytes);
    sum->position_bytes = larger(sum->position_bytes, one->position_bytes);
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = larger(sum->peak_bytes, one->peak_bytes);
    sum->draws += one->draws;
    sum->first_axis = one->draws ? one->first_axis : sum->first_axis;
    sum->fetches_per_pixel = fmax(sum->fetches_per_pixel, one->fetches_per_pixel);
}
