// SPDX-License-Identifier: BSD-3-Clause
// Values and light as the colours that they are shown in.
#include <math.h>
#include <string.h>

#include "filter/check.h"
#include "filter/statistics.h"
#include "filter/threads.h"
#include "tiles/image/codes/png.h"

struct preview {
    int32_t width, height;
    const float *plane;                // of what is one value a pixel
    const struct weft_colour_map *map; // of those; NULL: grey
    const float *colour[3];            // of what is red, green and blue
    double low, high;
};

// How it is written.
struct output {
    const char *path;
    bool no_clobber;
    int threads;
    const struct weft_log *log;
    const struct weft_preview_frame *frame; // NULL: none
    struct weft_png_writer png;             // of the preview
};

// ---- values to colours --------------------------------------------------------------------------

static void find_range(struct preview *w, const struct weft_preview_params *p)
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    const bool low_open = weft_range_is_open(p->low, p->low, p->high);
    const bool high_open = weft_range_is_open(p->high, p->low, p->high);
    if (low_open || high_open)
        weft_statistics_add(&s, p->plane, (size_t)p->width * (size_t)p->height);
    const bool none = isnan(s.minimum);
    w->low = !low_open ? p->low : none ? 0.0 : s.minimum;
    w->high = !high_open ? p->high : none ? 1.0 : s.maximum;
}

// A range of no width shows its value in the middle, and what is below or above it at the ends.
static inline double position(const struct preview *w, double v)
{
    if (w->low == w->high)
        return v < w->low ? 0.0 : v > w->low ? 1.0 : 0.5;
    const double t = (v - w->low) / (w->high - w->low);
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

static void fill_values(const void *priv, int thread, int32_t y, uint8_t *out)
{
    const struct preview *w = priv;
    (void)thread;
    const float *v = w->plane + (size_t)y * (size_t)w->width;
    for (int32_t x = 0; x < w->width; x++) {
        if (!w->map) {
            *out++ = isnan(v[x]) ? 0 : (uint8_t)lrint(255.0 * position(w, v[x]));
            continue;
        }
        if (isnan(v[x])) {
            out[0] = out[2] = 255;
            out[1] = 0;
        } else {
            w->map->colour(position(w, v[x]), out);
        }
        out += 3;
    }
}

static uint8_t srgb_of_light(double light)
{
    static const struct weft_transfer srgb = {.curve = WEFT_CURVE_SRGB};
    return (uint8_t)lrint(255.0 * weft_transfer_code(&srgb, light));
}

static void fill_colours(const void *priv, int thread, int32_t y, uint8_t *out)
{
    const struct preview *w = priv;
    (void)thread;
    const size_t first = (size_t)y * (size_t)w->width;
    for (size_t i = first; i < first + (size_t)w->width; i++, out += 3) {
        const float v[3] = {w->colour[0][i], w->colour[1][i], w->colour[2][i]};
        const bool none = isnan(v[0]) || isnan(v[1]) || isnan(v[2]);
        for (int c = 0; c < 3; c++)
            out[c] = none ? (uint8_t)(c == 1 ? 0 : 255) : srgb_of_light(position(w, v[c]));
    }
}

// ---- frames -------------------------------------------------------------------------------------

static enum weft_result check_frame(const struct weft_log *log, const struct weft_preview_frame *f,
                                    int32_t width, int32_t height)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, f->left >= 0 && f->right >= 0 && f->top >= 0 && f->bottom >= 0);
    weft_require(log, (int64_t)width + f->left + f->right <= INT32_MAX);
    weft_require(log, (int64_t)height + f->top + f->bottom <= INT32_MAX);
    res = WEFT_OK;
fail:
    return res;
}

// A preview with what is around it.
struct framed {
    const struct weft_preview_frame *frame;
    const struct preview *preview;
    void (*fill_row)(const void *priv, int thread, int32_t y, uint8_t *out);
    size_t row_bytes;
};

static void fill_framed(const void *priv, int thread, int32_t y, uint8_t *out)
{
    const struct framed *w = priv;
    const int32_t inner = y - w->frame->top;
    memset(out, 255, w->row_bytes);
    if (inner >= 0 && inner < w->preview->height)
        w->fill_row(w->preview, thread, inner, out + 3 * (size_t)w->frame->left);
    if (w->frame->draw)
        w->frame->draw(w->frame->priv, y, out);
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result save(const struct output *o)
{
    struct weft_output_file file = {.fd = -1, .stream = -1};
    struct weft_png_writer png = o->png;
    const struct weft_preview_frame *f = o->frame;
    struct framed framed = {.frame = f, .preview = png.priv, .fill_row = png.fill_row};
    png.threads = o->threads ? o->threads : weft_threads_available();
    png.bits = 8;
    if (f) {
        png.width += f->left + f->right;
        png.height += f->top + f->bottom;
        png.fill_row = fill_framed;
        png.priv = &framed;
        framed.row_bytes = 3 * (size_t)png.width;
    }
    enum weft_result res = weft_output_file_create(o->log, o->path, o->no_clobber, &file);
    if (res == WEFT_OK)
        res = weft_png_write(&png, &file);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&file);
    weft_output_file_discard(&file);
    return res;
}

static enum weft_result check_params(const struct weft_preview_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->path != NULL);
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->plane != NULL);
    weft_require(p->log, !isinf(p->low) && !isinf(p->high));
    weft_require(p->log, p->threads >= 0 && p->threads <= WEFT_IMAGE_MAX_THREADS);
    res = p->frame ? check_frame(p->log, p->frame, p->width, p->height) : WEFT_OK;
fail:
    return res;
}

enum weft_result weft_preview_save(const struct weft_preview_params *params, float range[2])
{
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    const struct weft_colour_map *map =
        params->colour_map ? params->colour_map : weft_colour_map_list[0];
    const bool grey = map == weft_colour_map_list[0] && !params->frame;
    struct preview w = {.width = params->width,
                        .height = params->height,
                        .plane = params->plane,
                        .map = grey ? NULL : map};
    find_range(&w, params);
    res = save(&(struct output){.path = params->path,
                                .no_clobber = params->no_clobber,
                                .threads = params->threads,
                                .log = params->log,
                                .frame = params->frame,
                                .png = {.width = params->width,
                                        .height = params->height,
                                        .samples = grey ? 1 : 3,
                                        .fill_row = fill_values,
                                        .priv = &w}});
    if (res == WEFT_OK && range) {
        range[0] = (float)w.low;
        range[1] = (float)w.high;
    }
    return res;
}

static enum weft_result check_colours(const struct weft_colour_preview_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->path != NULL);
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->red && p->green && p->blue);
    weft_require(p->log, isfinite(p->low) && isfinite(p->high));
    weft_require(p->log, (p->low == 0.0f && p->high == 0.0f) || p->low < p->high);
    weft_require(p->log, p->threads >= 0 && p->threads <= WEFT_IMAGE_MAX_THREADS);
    res = p->frame ? check_frame(p->log, p->frame, p->width, p->height) : WEFT_OK;
fail:
    return res;
}

enum weft_result weft_colour_preview_save(const struct weft_colour_preview_params *params)
{
    const enum weft_result res = check_colours(params);
    if (res != WEFT_OK)
        return res;
    const struct preview w = {.width = params->width,
                              .height = params->height,
                              .colour = {params->red, params->green, params->blue},
                              .low = params->low,
                              .high = params->low < params->high ? params->high : 1.0};
    return save(&(struct output){.path = params->path,
                                 .no_clobber = params->no_clobber,
                                 .threads = params->threads,
                                 .log = params->log,
                                 .frame = params->frame,
                                 .png = {.width = params->width,
                                         .height = params->height,
                                         .samples = 3,
                                         .fill_row = fill_colours,
                                         .priv = &w}});
}
