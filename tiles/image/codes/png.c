// SPDX-License-Identifier: BSD-3-Clause
// Several threads make rows, and libpng is handed those that come next by whichever thread has
// them ready.
#include "tiles/image/codes/png.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <png.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/output/order.h"

enum {
    LEVEL = 1,
    BAND = 16,                // rows that a thread makes at a time
    PACKED_BYTES = 256 << 10, // of one chunk
    KEYWORD = 79              // bytes of a text's name, at most
};

struct writer {
    const struct weft_png_writer *params;
    size_t row_bytes;
    uint8_t *rows; // of each slot a band
    char *text;    // that is being said; here, since libpng leaves functions by longjmp
    struct weft_output_file *file;
    uint64_t written_bytes;
    png_structp png;
    png_infop info;
    enum weft_result res; // of libpng, not yet logged
    int stream_errno;     // of the writes that it asked for
    char message[200];    // its first
};

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
    if (!weft_output_file_put(w->file, w->written_bytes, data, size)) {
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

// ---- what the file says -------------------------------------------------------------------------

static void say_profile(struct writer *w, const struct weft_image *image)
{
    const struct weft_image_attribute *icc = weft_image_find(image, WEFT_ATTRIBUTE_ICC);
    if (icc && icc->size && icc->size <= INT_MAX)
        png_set_iCCP(w->png, w->info, "ICC profile", PNG_COMPRESSION_TYPE_BASE, icc->data,
                     (png_uint_32)icc->size);
}

// libpng 1.6.39 does not know cICP.
static void say_points(struct writer *w, const uint8_t cicp[4])
{
    png_unknown_chunk chunk = {.name = "cICP", .size = 4, .location = PNG_HAVE_IHDR};
    uint8_t data[4];
    memcpy(data, cicp, sizeof data);
    chunk.data = data;
    png_set_keep_unknown_chunks(w->png, PNG_HANDLE_CHUNK_ALWAYS, chunk.name, 1);
    png_set_unknown_chunks(w->png, w->info, &chunk, 1);
}

static void say_curve(struct writer *w, const struct weft_image *image)
{
    const struct weft_code_info *codes = &image->codes;
    const bool points = codes->cicp[0] || codes->cicp[1] || codes->cicp[2] || codes->cicp[3];
    const bool silent = !points && !codes->srgb && !(codes->gamma > 0.0) && !codes->icc;
    const enum weft_curve curve = image->transfer.curve;
    if (codes->gamma > 0.0)
        png_set_gAMA_fixed(w->png, w->info, (png_fixed_point)lrint(codes->gamma * 100000.0));
    if (codes->srgb || (silent && (curve == WEFT_CURVE_SRGB || curve == WEFT_CURVE_AUTO)))
        png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    else if (codes->icc)
        say_profile(w, image);
    if (points)
        say_points(w, codes->cicp);
}

// Pixels per inch, or else how many pixels one is high where it is one wide.
static void say_density(struct writer *w, const struct weft_image *image)
{
    float density = 0.0f, aspect = 1.0f;
    const bool dense = weft_attribute_float(weft_image_find(image, "xDensity"), &density) &&
                       density > 0.01f && density < 1e6f;
    weft_attribute_float(weft_image_find(image, "pixelAspectRatio"), &aspect);
    if (!(aspect > 1e-3f && aspect < 1e3f) || (!dense && aspect == 1.0f))
        return;
    const double across = dense ? (double)density / 0.0254 : 100000.0;
    png_set_pHYs(w->png, w->info, (png_uint_32)lrint(across),
                 (png_uint_32)lrint(across * (double)aspect),
                 dense ? PNG_RESOLUTION_METER : PNG_RESOLUTION_UNKNOWN);
}

// libpng copies it.
static void say_text(struct writer *w, const struct weft_image_attribute *a)
{
    char key[KEYWORD + 1];
    w->text = png_malloc(w->png, a->size + 1);
    png_text line = {.compression = PNG_TEXT_COMPRESSION_NONE, .key = key, .text = w->text};
    snprintf(key, sizeof key, "%s", weft_attribute_png_name(a->name));
    memcpy(w->text, a->data, a->size);
    w->text[a->size] = '\0';
    png_set_text(w->png, w->info, &line, 1);
    png_free(w->png, w->text);
    w->text = NULL;
}

static void say_all(struct writer *w)
{
    const struct weft_image *image = w->params->says;
    if (!image)
        return;
    say_curve(w, image);
    say_density(w, image);
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        if (!strcmp(a->type, "string") && a->size && strlen(a->name) <= KEYWORD)
            say_text(w, a);
    }
}

// ---- rows ---------------------------------------------------------------------------------------

// Rows as their differences to the rows above, and zlib's fastest level: of slices of 4096^2, grey
// and in colours, 0.14 and 0.41 s on one core, 2.42 and 7.95 MB; at level 2 0.17 and 0.56 s, 2.31
// and 7.59 MB; differences within rows 0.16 and 0.45 s, 2.54 and 8.39 MB; what libpng does by
// itself 0.86 and 3.08 s, 1.67 and 5.71 MB.
static bool begin(struct writer *w)
{
    static const int types[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    const struct weft_png_writer *p = w->params;
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
    png_set_IHDR(w->png, w->info, (png_uint_32)p->width, (png_uint_32)p->height, p->bits,
                 types[p->samples], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    say_all(w);
    png_write_info(w->png, w->info);
    if (p->bits == 16 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
        png_set_swap(w->png);
    return true;
}

static int32_t rows_of(const struct writer *w, size_t band)
{
    const int32_t left = w->params->height - (int32_t)band * BAND;
    return left < BAND ? left : BAND;
}

static uint8_t *row_at(const struct writer *w, size_t slot, int32_t row)
{
    return w->rows + (slot * BAND + (size_t)row) * w->row_bytes;
}

static bool make_band(void *priv, int thread, size_t band, size_t slot)
{
    const struct writer *w = priv;
    for (int32_t i = 0; i < rows_of(w, band); i++)
        w->params->fill_row(w->params->priv, thread, (int32_t)band * BAND + i, row_at(w, slot, i));
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

static bool ask(void *priv, size_t taken)
{
    struct writer *w = priv;
    const struct weft_progress *progress = w->params->progress;
    const double all = (double)(((size_t)w->params->height - 1) / BAND + 1);
    if (!progress || !progress->report || progress->report(progress->priv, (double)taken / all))
        return true;
    w->res = WEFT_ERR_CANCELLED;
    return false;
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
        return weft_output_file_fail(w->file);
    }
    if (w->res == WEFT_ERR_CANCELLED)
        return w->res;
    const bool memory = w->res != WEFT_ERR_WRITE;
    weft_error(w->file->log, "cannot write %s: %s", w->file->path,
               memory ? "out of memory" : w->message);
    return memory ? WEFT_ERR_MEMORY : WEFT_ERR_WRITE;
}

enum weft_result weft_png_write(const struct weft_png_writer *writer, struct weft_output_file *file)
{
    struct writer w = {.params = writer, .file = file};
    const size_t bands = ((size_t)writer->height - 1) / BAND + 1;
    const int threads = (size_t)writer->threads < bands ? writer->threads : (int)bands;
    const struct weft_order order = {.threads = threads,
                                     .count = bands,
                                     .slots = threads > 1 ? 2 * (size_t)threads : 1,
                                     .make = make_band,
                                     .take = write_band,
                                     .ask = ask,
                                     .priv = &w};
    w.row_bytes = (size_t)writer->width * (size_t)writer->samples * (size_t)writer->bits / 8;
    w.rows = malloc(order.slots * BAND * w.row_bytes);
    const bool whole = w.rows && begin(&w) && weft_order_run(&order) && end(&w);
    png_destroy_write_struct(&w.png, &w.info);
    free(w.text);
    free(w.rows);
    return whole ? WEFT_OK : fail(&w);
}
