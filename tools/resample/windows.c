// SPDX-License-Identifier: BSD-3-Clause
// The windows of the result of `weft resample`.
#include "tools/common/report.h"
#include "tools/resample/job.h"

static int64_t display_size(const struct weft_image *image, int a)
{
    return (int64_t)image->display_max[a] - image->display_min[a] + 1;
}

static enum weft_result check_size(int64_t width, int64_t height, const char *what)
{
    if (width <= WEFT_RESAMPLE_MAX_SIZE && height <= WEFT_RESAMPLE_MAX_SIZE &&
        width * height <= WEFT_RESAMPLE_MAX_PIXELS)
        return WEFT_OK;
    report_error("%lld x %lld pixels%s: there may be at most %d along a side and %lld in all",
                 (long long)width, (long long)height, what, WEFT_RESAMPLE_MAX_SIZE,
                 (long long)WEFT_RESAMPLE_MAX_PIXELS);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result resample_choose_size(struct resample_job *job)
{
    const struct option_value *size = &job->option[RESAMPLE_SIZE];
    int64_t from[2], to[2];
    for (int a = 0; a < 2; a++) {
        from[a] = display_size(&job->image, a);
        to[a] = size->given ? size->integer[a] : 2 * from[a];
        job->map[a] = (struct weft_window_map){.from = from[a], .to = to[a]};
    }
    const enum weft_result res = check_size(to[0], to[1], "");
    if (res == WEFT_OK && (to[0] < from[0] || to[1] < from[1]))
        report_warning("%lld x %lld pixels become %lld x %lld: a smaller image is not filtered "
                       "for it, and may alias",
                       (long long)from[0], (long long)from[1], (long long)to[0], (long long)to[1]);
    return res;
}

enum weft_result resample_set_windows(struct resample_job *job)
{
    const struct weft_image *in = &job->image;
    struct weft_image *out = &job->result;
    const int32_t corner[2] = {in->x, in->y}, size[2] = {in->width, in->height};
    struct weft_window data[2], display;
    for (int a = 0; a < 2; a++) {
        const int64_t first = in->display_min[a], end = first + display_size(in, a);
        const enum weft_result res = weft_window_map_scale(
            report_log(), (struct weft_window){corner[a], (int64_t)corner[a] + size[a]},
            (struct weft_window){first, end}, job->map[a].to, &data[a], &display, &job->map[a]);
        if (res != WEFT_OK)
            return res;
        out->display_min[a] = (int32_t)display.first;
        out->display_max[a] = (int32_t)(display.end - 1);
    }
    out->x = (int32_t)data[0].first;
    out->y = (int32_t)data[1].first;
    const int64_t width = data[0].end - data[0].first, height = data[1].end - data[1].first;
    const enum weft_result res = check_size(width, height, " in the data window");
    out->width = (int32_t)width;
    out->height = (int32_t)height;
    return res;
}
