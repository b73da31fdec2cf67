// SPDX-License-Identifier: BSD-3-Clause
// Where the result of `weft resample` lies: its windows, and what its pixels sample.
#include "tools/common/report.h"
#include "tools/resample/job.h"

static int64_t divide_down(int64_t a, int64_t b)
{
    return a / b - (a % b != 0 && a < 0);
}

double resample_position(const struct resample_place *p, int pixel, int shift)
{
    const int64_t places =
        (2 * (pixel + p->pixel) + 1) * p->from + (2 * (p->sample + shift) - 1) * p->to;
    return (double)places / (double)(2 * p->to);
}

static int64_t display_size(const struct weft_image *image, int a)
{
    return (int64_t)image->display_max[a] - image->display_min[a] + 1;
}

static enum weft_result check_size(int64_t width, int64_t height, const char *what)
{
    if (width <= WEFT_SLICE_MAX_SIZE && height <= WEFT_SLICE_MAX_SIZE &&
        width * height <= WEFT_SLICE_MAX_PIXELS)
        return WEFT_OK;
    report_error("%lld x %lld pixels%s: there may be at most %d along a side and %lld in all",
                 (long long)width, (long long)height, what, WEFT_SLICE_MAX_SIZE,
                 (long long)WEFT_SLICE_MAX_PIXELS);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result resample_choose_size(struct resample_job *job)
{
    const struct option_value *size = &job->option[RESAMPLE_SIZE];
    int64_t from[2], to[2];
    for (int a = 0; a < 2; a++) {
        from[a] = display_size(&job->image, a);
        to[a] = size->given ? size->integer[a] : 2 * from[a];
        job->place[a].from = from[a];
        job->place[a].to = to[a];
    }
    const enum weft_result res = check_size(to[0], to[1], "");
    if (res == WEFT_OK && (to[0] < from[0] || to[1] < from[1]))
        report_warning("%lld x %lld pixels become %lld x %lld: a smaller image is not filtered "
                       "for it, and may alias",
                       (long long)from[0], (long long)from[1], (long long)to[0], (long long)to[1]);
    return res;
}

// Edges along an axis, exclusive at the end.
struct window {
    int64_t first, end;
};

static enum weft_result check_windows(const struct resample_job *job, struct window data,
                                      struct window display)
{
    const int64_t limit = INT32_MAX / 2; // EXR's
    const int64_t low = data.first < display.first ? data.first : display.first;
    const int64_t high = data.end > display.end ? data.end : display.end;
    if (low > -limit && high < limit)
        return WEFT_OK;
    report_error("the windows of %s, enlarged, reach from %lld to %lld: the limit is +-%lld",
                 job->input, (long long)low, (long long)high, (long long)limit);
    return WEFT_ERR_LIMIT;
}

// The display window's first edge stays on a whole pixel, the nearest, and all edges are counted
// from it; the data window grows to whole pixels.
enum weft_result resample_set_windows(struct resample_job *job)
{
    const struct weft_image *in = &job->image;
    struct weft_image *out = &job->result;
    const int32_t corner[2] = {in->x, in->y};
    const int64_t size[2] = {in->width, in->height};
    struct window data[2];
    for (int a = 0; a < 2; a++) {
        struct resample_place *p = &job->place[a];
        const int64_t origin = in->display_min[a], first = corner[a] - origin;
        const int64_t display = divide_down(2 * origin * p->to + p->from, 2 * p->from);
        data[a].first = display + divide_down(first * p->to, p->from);
        data[a].end = display - divide_down(-(first + size[a]) * p->to, p->from);
        const enum weft_result res =
            check_windows(job, data[a], (struct window){display, display + p->to});
        if (res != WEFT_OK)
            return res;
        p->pixel = data[a].first - display;
        p->sample = -first;
        out->display_min[a] = (int32_t)display;
        out->display_max[a] = (int32_t)(display + p->to - 1);
    }
    out->x = (int32_t)data[0].first;
    out->y = (int32_t)data[1].first;
    const int64_t width = data[0].end - data[0].first, height = data[1].end - data[1].first;
    const enum weft_result res = check_size(width, height, " in the data window");
    out->width = (int32_t)width;
    out->height = (int32_t)height;
    return res;
}
