// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

#include <png.h>

#include "filter/check.h"
#include "filter/statistics.h"
#include "tiles/image/image.h"
#include "tiles/output/output_file.h"

struct writer {
    const struct weft_preview_params *params;
    const struct weft_colour_map *map; // NULL: grey
    double low, high;
    struct weft_output_file file;
    uint64_t written_bytes;
    uint8_t *row;
    enum weft_result res; // already logged when it is not WEFT_OK
};

// ---- values to colours --------------------------------------------------------------------------

static void find_range(struct writer *w)
{
    const struct weft_preview_params *p = w->params;
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    weft_statistics_add(&s, p->plane, (size_t)p->width * (size_t)p->height);
    const bool none = isnan(s.minimum);
    w->low = !weft_range_is_open(p->low, p->low, p->high) ? p->low : none ? 0.0 : s.minimum;
    w->high = !weft_range_is_open(p->high, p->low, p->high) ? p->high : none ? 1.0 : s.maximum;
}

// A range of no width shows its value in the middle, and what is below or above it at the ends.
static double position(const struct writer *w, double v)
{
    if (w->low == w->high)
        return v < w->low ? 0.0 : v > w->low ? 1.0 : 0.5;
    double t = (v - w->low) / (w->high - w->low);
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

static void fill_row(const struct writer *w, int32_t y)
{
    const float *v = w->params->plane + (size_t)y * (size_t)w->params->width;
    uint8_t *out = w->row;
    for (int32_t x = 0; x < w->params->width; x++) {
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

// ---- libpng -------------------------------------------------------------------------------------

static void fail_png(png_structp png, png_const_charp message)
{
    struct writer *w = png_get_error_ptr(png);
    if (w->res == WEFT_OK) {
        weft_error(w->params->log, "cannot write %s: %s", w->file.path, message);
        w->res = WEFT_ERR_WRITE;
    }
    png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static png_voidp allocate(png_structp png, png_alloc_size_t size)
{
    struct writer *w = png_get_mem_ptr(png);
    void *memory = malloc(size);
    if (!memory && w->res == WEFT_OK) {
        weft_error(w->params->log, "cannot write %s: out of memory", w->file.path);
        w->res = WEFT_ERR_MEMORY;
    }
    return memory;
}

static void release(png_structp png, png_voidp memory)
{
    (void)png;
    free(memory);
}

static void write_bytes(png_structp png, png_bytep data, png_size_t size)
{
    struct writer *w = png_get_io_ptr(png);
    w->res = weft_output_file_write(&w->file, w->written_bytes, data, size);
    w->written_bytes += size;
    if (w->res != WEFT_OK)
        png_longjmp(png, 1);
}

static void flush(png_structp png)
{
    (void)png;
}

// Jumps back to write_png on any failure.
static void write_image(struct writer *w, png_structp png, png_infop info)
{
    const struct weft_preview_params *p = w->params;
    png_set_write_fn(png, w, write_bytes, flush);
    png_set_user_limits(png, INT_MAX, INT_MAX);
    png_set_IHDR(png, info, (png_uint_32)p->width, (png_uint_32)p->height, 8,
                 w->map ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int32_t y = 0; y < p->height; y++) {
        fill_row(w, y);
        png_write_row(png, w->row);
    }
    png_write_end(png, info);
}

static enum weft_result write_png(struct writer *w)
{
    png_structp png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, w, fail_png, ignore_warning,
                                                w, allocate, release);
    if (!png)
        return w->res == WEFT_OK ? WEFT_ERR_MEMORY : w->res;
    png_infop info = png_create_info_struct(png);
    if (!info)
        w->res = WEFT_ERR_MEMORY;
    else if (!setjmp(png_jmpbuf(png)))
        write_image(w, png, info);
    png_destroy_write_struct(&png, &info);
    return w->res;
}

static enum weft_result check_params(const struct weft_preview_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->path != NULL);
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->plane != NULL);
    weft_require(p->log, !isinf(p->low) && !isinf(p->high));
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_preview_save(const struct weft_preview_params *params, float range[2])
{
    struct writer w = {.params = params};
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    w.map = params->colour_map == weft_colour_map_list[0] ? NULL : params->colour_map;
    find_range(&w);

    w.row = malloc((size_t)params->width * 3);
    if (!w.row) {
        weft_error(params->log, "cannot write %s: out of memory", params->path);
        return WEFT_ERR_MEMORY;
    }
    res = weft_output_file_create(params->log, params->path, params->no_clobber, &w.file);
    if (res == WEFT_OK)
        res = write_png(&w);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&w.file);
    if (res == WEFT_OK && range) {
        range[0] = (float)w.low;
        range[1] = (float)w.high;
    }
    weft_output_file_discard(&w.file);
    free(w.row);
    return res;
}
