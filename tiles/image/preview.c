// SPDX-License-Identifier: BSD-3-Clause
// Several threads colour rows, and libpng is handed those that come next by whichever thread has
// them ready.
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <png.h>

#include "filter/check.h"
#include "filter/statistics.h"
#include "filter/threads.h"
#include "tiles/image/image.h"
#include "tiles/output/order.h"
#include "tiles/output/output_file.h"

enum {
    LEVEL = 1,
    BAND = 16,               // rows that a thread colours at a time
    PACKED_BYTES = 256 << 10 // of one chunk
};

struct writer {
    const char *path;
    bool no_clobber;
    int32_t width, height;
    int threads;
    const struct weft_log *log;
    int samples; // of a pixel: 1 is grey, 3 are colours
    void (*fill_row)(const struct writer *w, int32_t y, uint8_t *out);
    const float *plane;                // of what is one value a pixel
    const struct weft_colour_map *map; // of those; NULL: grey
    const float *colour[3];            // of what is red, green and blue
    double low, high;
    size_t row_bytes;
    uint8_t *rows; // of each slot a band
    struct weft_output_file file;
    uint64_t written_bytes;
    png_structp png;
    png_infop info;
    enum weft_result res; // of libpng, not yet logged
    int stream_errno;     // of the writes that it asked for
    char message[200];    // its first
};

// ---- values to colours --------------------------------------------------------------------------

static void find_range(struct writer *w, const struct weft_preview_params *p)
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
static inline double position(const struct writer *w, double v)
{
    if (w->low == w->high)
        return v < w->low ? 0.0 : v > w->low ? 1.0 : 0.5;
    const double t = (v - w->low) / (w->high - w->low);
    return t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
}

static void fill_values(const struct writer *w, int32_t y, uint8_t *out)
{
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

// IEC 61966-2-1, of light from 0 to 1.
static uint8_t srgb_of_light(double light)
{
    const double code = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
    return (uint8_t)lrint(255.0 * code);
}

static void fill_colours(const struct writer *w, int32_t y, uint8_t *out)
{
    const size_t first = (size_t)y * (size_t)w->width;
    for (size_t i = first; i < first + (size_t)w->width; i++, out += 3) {
        const float v[3] = {w->colour[0][i], w->colour[1][i], w->colour[2][i]};
        const bool none = isnan(v[0]) || isnan(v[1]) || isnan(v[2]);
        for (int c = 0; c < 3; c++)
            out[c] = none ? (uint8_t)(c == 1 ? 0 : 255) : srgb_of_light(position(w, v[c]));
    }
}

static int32_t rows_of(const struct writer *w, size_t band)
{
    const int32_t left = w->height - (int32_t)band * BAND;
    return left < BAND ? left : BAND;
}

static uint8_t *row_at(const struct writer *w, size_t slot, int32_t row)
{
    return w->rows + (slot * BAND + (size_t)row) * w->row_bytes;
}

static bool colour_band(void *priv, int thread, size_t band, size_t slot)
{
    const struct writer *w = priv;
    (void)thread;
    for (int32_t i = 0; i < rows_of(w, band); i++)
        w->fill_row(w, (int32_t)band * BAND + i, row_at(w, slot, i));
    return true;
}

// ---- libpng -------------------------------------------------------------------------------------
// In any thread: what went wrong is told later, in the caller's.

static void fail_png(png_structp png, png_const_charp message)
{
    struct writer *w = png_get_error_ptr(png);
    if (w->res == WEFT_OK) {
        w->res = WEFT_ERR_WRITE;
        snprintf(w->message, sizeof w->message, "%s", message);
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
    if (!memory && w->res == WEFT_OK)
        w->res = WEFT_ERR_MEMORY;
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
    if (!weft_output_file_put(&w->file, w->written_bytes, data, size)) {
        w->stream_errno = errno;
        w->res = WEFT_ERR_WRITE;
        png_longjmp(png, 1);
    }
    w->written_bytes += size;
}

static void flush(png_structp png)
{
    (void)png;
}

// Rows as their differences to the rows above, and zlib's fastest level: of slices of 4096^2, grey
// and in colours, 0.14 and 0.41 s on one core, 2.42 and 7.95 MB; at level 2 0.17 and 0.56 s, 2.31
// and 7.59 MB; differences within rows 0.16 and 0.45 s, 2.54 and 8.39 MB; what libpng does by
// itself 0.86 and 3.08 s, 1.67 and 5.71 MB.
static bool begin(struct writer *w)
{
    w->png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, w, fail_png, ignore_warning, w,
                                       allocate, release);
    w->info = w->png ? png_create_info_struct(w->png) : NULL;
    if (!w->info) {
        w->res = WEFT_ERR_MEMORY;
        return false;
    }
    if (setjmp(png_jmpbuf(w->png)))
        return false;
    png_set_write_fn(w->png, w, write_bytes, flush);
    png_set_user_limits(w->png, INT_MAX, INT_MAX);
    png_set_filter(w->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_set_compression_level(w->png, LEVEL);
    png_set_compression_buffer_size(w->png, PACKED_BYTES);
    png_set_IHDR(w->png, w->info, (png_uint_32)w->width, (png_uint_32)w->height, 8,
                 w->samples == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(w->png, w->info);
    return true;
}

static bool write_band(void *priv, size_t band, size_t slot)
{
    struct writer *w = priv;
    if (setjmp(png_jmpbuf(w->png)))
        return false;
    for (int32_t i = 0; i < rows_of(w, band); i++)
        png_write_row(w->png, row_at(w, slot, i));
    return true;
}

static bool end(struct writer *w)
{
    if (setjmp(png_jmpbuf(w->png)))
        return false;
    png_write_end(w->png, w->info);
    return true;
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result fail(struct writer *w)
{
    if (w->stream_errno) {
        errno = w->stream_errno;
        return weft_output_file_fail(&w->file);
    }
    const bool memory = w->res != WEFT_ERR_WRITE;
    weft_error(w->log, "cannot write %s: %s", w->file.path, memory ? "out of memory" : w->message);
    return memory ? WEFT_ERR_MEMORY : WEFT_ERR_WRITE;
}

static enum weft_result write_png(struct writer *w)
{
    const size_t bands = ((size_t)w->height - 1) / BAND + 1;
    const int asked = w->threads ? w->threads : weft_threads_available();
    const int threads = (size_t)asked < bands ? asked : (int)bands;
    const struct weft_order order = {.threads = threads,
                                     .count = bands,
                                     .slots = threads > 1 ? 2 * (size_t)threads : 1,
                                     .make = colour_band,
                                     .take = write_band,
                                     .priv = w};
    w->row_bytes = (size_t)w->width * (size_t)w->samples;
    w->rows = malloc(order.slots * BAND * w->row_bytes);
    const bool whole = w->rows && begin(w) && weft_order_run(&order) && end(w);
    png_destroy_write_struct(&w->png, &w->info);
    free(w->rows);
    return whole ? WEFT_OK : fail(w);
}

static enum weft_result save(struct writer *w)
{
    w->file = (struct weft_output_file){.fd = -1, .stream = -1};
    enum weft_result res = weft_output_file_create(w->log, w->path, w->no_clobber, &w->file);
    if (res == WEFT_OK)
        res = write_png(w);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&w->file);
    weft_output_file_discard(&w->file);
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
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_preview_save(const struct weft_preview_params *params, float range[2])
{
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    const bool grey = !params->colour_map || params->colour_map == weft_colour_map_list[0];
    struct writer w = {.path = params->path,
                       .no_clobber = params->no_clobber,
                       .width = params->width,
                       .height = params->height,
                       .threads = params->threads,
                       .log = params->log,
                       .samples = grey ? 1 : 3,
                       .fill_row = fill_values,
                       .plane = params->plane,
                       .map = grey ? NULL : params->colour_map};
    find_range(&w, params);
    res = save(&w);
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
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_colour_preview_save(const struct weft_colour_preview_params *params)
{
    const enum weft_result res = check_colours(params);
    if (res != WEFT_OK)
        return res;
    struct writer w = {.path = params->path,
                       .no_clobber = params->no_clobber,
                       .width = params->width,
                       .height = params->height,
                       .threads = params->threads,
                       .log = params->log,
                       .samples = 3,
                       .fill_row = fill_colours,
                       .colour = {params->red, params->green, params->blue},
                       .low = params->low,
                       .high = params->low < params->high ? params->high : 1.0};
    return save(&w);
}
