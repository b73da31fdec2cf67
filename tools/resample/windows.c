// SPDX-License-Identifier: BSD-3-Clause
// The windows of the result of `weft resample`, and what stands beyond the samples.
#include <ctype.h>
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

// ---- --size and --boundary ----------------------------------------------------------------------

static bool read_whole(const char *text, char **end, int64_t *out)
{
    errno = 0;
    *out = strtoll(text, end, 10);
    return isdigit((unsigned char)*text) && errno == 0;
}

static bool read_factor(const char *text, char **end, double *out)
{
    *out = strtod(text, end);
    return (isdigit((unsigned char)*text) || *text == '.') && isfinite(*out);
}

// "x2", "50%", "640", the longer side, or "640x480", of which one may be 0.
static bool read_size(const char *text, struct resample_size *out)
{
    char *end;
    *out = (struct resample_size){.factor = 0.0};
    if (*text == 'x')
        return read_factor(text + 1, &end, &out->factor) && *end == '\0';
    if (read_factor(text, &end, &out->factor) && strcmp(end, "%") == 0) {
        out->factor /= 100.0;
        return true;
    }
    if (read_whole(text, &end, &out->longer) && *end == '\0')
        return true;
    out->longer = 0;
    return read_whole(text, &end, &out->pixels[0]) && *end == 'x' &&
           read_whole(end + 1, &end, &out->pixels[1]) && *end == '\0';
}

enum weft_result resample_read_size(struct resample_job *job)
{
    const struct option_value *given = &job->option[RESAMPLE_SIZE];
    const struct resample_size *size = &job->size;
    job->size = (struct resample_size){.factor = 2.0};
    if (!given->given)
        return WEFT_OK;
    if (!read_size(given->text, &job->size)) {
        report_error("--size %s: needs WxH, as 1024x768, Wx0 or 0xH, N, the longer side, a factor, "
                     "as x2, or a percentage, as 50%%",
                     given->text);
        return WEFT_ERR_ARGUMENT;
    }
    const bool factor = size->pixels[0] == 0 && size->pixels[1] == 0 && !size->longer;
    if (factor && !(size->factor > 0.0)) {
        report_error("--size %s: %s", given->text,
                     strchr(given->text, '%') || *given->text == 'x'
                         ? "the factor must be more than 0"
                         : "one of width and height must be more than 0");
        return WEFT_ERR_ARGUMENT;
    }
    if (size->pixels[0] <= WEFT_RESAMPLE_MAX_SIZE && size->pixels[1] <= WEFT_RESAMPLE_MAX_SIZE &&
        size->longer <= WEFT_RESAMPLE_MAX_SIZE)
        return WEFT_OK;
    report_error("--size %s: width and height must be from 1 to %d", given->text,
                 WEFT_RESAMPLE_MAX_SIZE);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result resample_read_boundary(struct resample_job *job)
{
    const struct option_value *given = &job->option[RESAMPLE_BOUNDARY];
    const char *text = given->given ? given->text : "clamp", *border = "border:";
    char *end;
    for (int i = 0; i < WEFT_BOUNDARY_BORDER; i++) {
        job->boundary = (enum weft_boundary)i;
        if (strcmp(text, weft_boundary_names[i]) == 0)
            return WEFT_OK;
    }
    job->boundary = WEFT_BOUNDARY_BORDER;
    if (strncmp(text, border, strlen(border)) == 0) {
        job->border = strtod(text + strlen(border), &end);
        if (end != text + strlen(border) && *end == '\0' && fabs(job->border) <= (double)FLT_MAX)
            return WEFT_OK;
    }
    report_error("--boundary %s: needs clamp, mirror, wrap or border:V, V a finite number, as "
                 "border:0",
                 text);
    return WEFT_ERR_ARGUMENT;
}

// ---- sizes --------------------------------------------------------------------------------------

// A side by a factor: the nearest whole number, 1 at least.
static int64_t scaled(int64_t from, double factor)
{
    const double to = floor((double)from * factor + 0.5), most = WEFT_WINDOW_MAX;
    return to < 1.0 ? 1 : to > most ? WEFT_WINDOW_MAX : (int64_t)to;
}

static int64_t side_of(const struct resample_size *size, const int64_t from[2], int a)
{
    if (size->pixels[a])
        return size->pixels[a];
    const int64_t other = size->pixels[!a], longest = from[0] > from[1] ? from[0] : from[1];
    if (size->longer)
        return scaled(from[a], (double)size->longer / (double)longest);
    return scaled(from[a], other ? (double)other / (double)from[!a] : size->factor);
}

// What cannot be stretched, before anything is read that a lower room would refuse.
static enum weft_result check_smaller(const struct resample_job *job, const int64_t from[2],
                                      const int64_t to[2])
{
    const struct option_value *o = job->option;
    const bool passes = o[RESAMPLE_EMULATE].given || resample_passes_option(job);
    if (job->warp.is || (to[0] >= from[0] && to[1] >= from[1])) // a map has its own scales
        return WEFT_OK;
    if (resample_is_unstretched(job) || job->kernel.info->moves) {
        report_warning("%lld x %lld pixels become %lld x %lld: a smaller image is not filtered "
                       "for it, and may alias",
                       (long long)from[0], (long long)from[1], (long long)to[0], (long long)to[1]);
        return WEFT_OK;
    }
    if (!passes && !job->kernel.prefiltered)
        return WEFT_OK;
    report_error("%lld x %lld pixels become %lld x %lld, for which the kernel is stretched: %s; "
                 "or give --antialias off",
                 (long long)from[0], (long long)from[1], (long long)to[0], (long long)to[1],
                 passes ? "passes do not do that, filter without --profile and --emulate"
                        : "one that interpolates by a prefilter cannot be, take mitchell or "
                          "lanczos:3");
    return WEFT_ERR_UNSUPPORTED;
}

// Where the input's pixels are square, and both sides make those of the result something else.
static void find_aspect(struct resample_job *job, const int64_t from[2])
{
    const struct weft_image_attribute *aspect = weft_image_find(&job->image, "pixelAspectRatio");
    float ratio = 1.0f;
    if (aspect && aspect->size == sizeof ratio)
        memcpy(&ratio, aspect->data, sizeof ratio);
    if (job->size.pixels[0] && job->size.pixels[1] && !job->warp.is && ratio == 1.0f)
        framing_format_aspect((double[]){(double)from[0], (double)from[1]},
                              (int)job->size.pixels[0], (int)job->size.pixels[1], "", job->aspect);
}

enum weft_result resample_choose_size(struct resample_job *job)
{
    int64_t from[2], to[2];
    for (int a = 0; a < 2; a++)
        from[a] = display_size(&job->image, a);
    for (int a = 0; a < 2; a++) {
        to[a] = side_of(&job->size, from, a);
        job->map[a] = (struct weft_window_map){.from = from[a], .to = to[a]};
    }
    const enum weft_result res = check_size(to[0], to[1], "");
    if (res == WEFT_OK)
        find_aspect(job, from);
    return res == WEFT_OK ? check_smaller(job, from, to) : res;
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
