// SPDX-License-Identifier: BSD-3-Clause
// PNG (W3C, third edition): rows as their differences to the rows above, which takes no choosing
// and packs about as small as choosing does, in one stream that libdeflate makes at its fastest
// level.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <libdeflate.h>

#include "filter/check.h"
#include "filter/statistics.h"
#include "filter/threads.h"
#include "tiles/image/image.h"
#include "tiles/output/output_file.h"

enum {
    LEVEL = 1,
    FILTER_UP = 2,
    BAND = 32,          // rows that a thread makes at a time
    MOST_DATA = 1 << 30 // bytes of one chunk
};

struct preview {
    const struct weft_preview_params *params;
    const struct weft_colour_map *map; // NULL: grey
    double low, high;
    size_t row_bytes;
    uint8_t *rows;     // of each thread two: the one above, and its own
    uint8_t *filtered; // all rows, each behind the number of its filter
};

// ---- values to colours --------------------------------------------------------------------------

static void find_range(struct preview *w)
{
    const struct weft_preview_params *p = w->params;
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

static void fill_row(const struct preview *w, int32_t y, uint8_t *out)
{
    const float *v = w->params->plane + (size_t)y * (size_t)w->params->width;
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

// The first row is above none, which counts as 0.
static bool fill_band(void *priv, int thread, size_t band)
{
    const struct preview *w = priv;
    const size_t size = w->row_bytes;
    const int32_t first = (int32_t)band * BAND, left = w->params->height - first;
    uint8_t *above = w->rows + 2 * (size_t)thread * size, *row = above + size;
    if (first)
        fill_row(w, first - 1, above);
    else
        memset(above, 0, size);
    for (int32_t y = first; y < first + (left < BAND ? left : BAND); y++) {
        uint8_t *restrict out = w->filtered + (size_t)y * (size + 1);
        fill_row(w, y, row);
        *out++ = FILTER_UP;
        for (size_t i = 0; i < size; i++)
            out[i] = (uint8_t)(row[i] - above[i]);
        uint8_t *const other = above;
        above = row;
        row = other;
    }
    return true;
}

// ---- chunks -------------------------------------------------------------------------------------

struct writer {
    struct weft_output_file file;
    uint64_t written_bytes;
};

static void store(uint8_t *out, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(value >> (24 - 8 * i));
}

static enum weft_result write_bytes(struct writer *w, const void *data, size_t size)
{
    const uint64_t at = w->written_bytes;
    w->written_bytes += size;
    return weft_output_file_write(&w->file, at, data, size);
}

static enum weft_result write_chunk(struct writer *w, const char *type, const uint8_t *data,
                                    size_t size)
{
    uint8_t head[8], check[4];
    store(head, (uint32_t)size);
    memcpy(head + 4, type, 4);
    store(check, libdeflate_crc32(libdeflate_crc32(0, type, 4), data, size));
    enum weft_result res = write_bytes(w, head, sizeof head);
    if (res == WEFT_OK)
        res = write_bytes(w, data, size);
    return res == WEFT_OK ? write_bytes(w, check, sizeof check) : res;
}

static enum weft_result write_png(struct writer *w, const struct preview *p, const uint8_t *packed,
                                  size_t size)
{
    static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    uint8_t header[13] = {[8] = 8, [9] = p->map ? 2 : 0}; // bits, and RGB or grey
    store(header, (uint32_t)p->params->width);
    store(header + 4, (uint32_t)p->params->height);
    enum weft_result res = write_bytes(w, signature, sizeof signature);
    if (res == WEFT_OK)
        res = write_chunk(w, "IHDR", header, sizeof header);
    for (size_t at = 0; res == WEFT_OK && at < size; at += MOST_DATA)
        res = write_chunk(w, "IDAT", packed + at, size - at < MOST_DATA ? size - at : MOST_DATA);
    return res == WEFT_OK ? write_chunk(w, "IEND", (const uint8_t *)"", 0) : res;
}

// ---- all ----------------------------------------------------------------------------------------

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

// All rows, filtered. Returns false where there is no memory.
static bool fill(struct preview *p)
{
    const size_t height = (size_t)p->params->height, bands = (height - 1) / BAND + 1;
    const int asked = p->params->threads ? p->params->threads : weft_threads_available();
    const int threads = (size_t)asked < bands ? asked : (int)bands;
    p->row_bytes = (size_t)p->params->width * (p->map ? 3 : 1);
    p->rows = malloc(2 * (size_t)threads * p->row_bytes);
    p->filtered = malloc((p->row_bytes + 1) * height);
    if (p->rows && p->filtered)
        weft_threads_run(threads, bands, fill_band, p);
    free(p->rows);
    return p->rows && p->filtered;
}

// Returns a buffer to be freed, or NULL where there is no memory.
static uint8_t *pack(const struct preview *p, size_t *size)
{
    const size_t bytes = (p->row_bytes + 1) * (size_t)p->params->height;
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(LEVEL);
    if (!compressor)
        return NULL;
    const size_t room = libdeflate_zlib_compress_bound(compressor, bytes);
    uint8_t *out = malloc(room);
    if (out)
        *size = libdeflate_zlib_compress(compressor, p->filtered, bytes, out, room);
    libdeflate_free_compressor(compressor);
    return out;
}

enum weft_result weft_preview_save(const struct weft_preview_params *params, float range[2])
{
    struct preview preview = {.params = params};
    struct writer writer = {.file = {.fd = -1, .stream = -1}};
    size_t size = 0;
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    preview.map = params->colour_map == weft_colour_map_list[0] ? NULL : params->colour_map;
    find_range(&preview);

    uint8_t *packed = fill(&preview) ? pack(&preview, &size) : NULL;
    free(preview.filtered);
    if (!packed) {
        weft_error(params->log, "cannot write %s: out of memory", params->path);
        return WEFT_ERR_MEMORY;
    }
    res = weft_output_file_create(params->log, params->path, params->no_clobber, &writer.file);
    if (res == WEFT_OK)
        res = write_png(&writer, &preview, packed, size);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&writer.file);
    if (res == WEFT_OK && range) {
        range[0] = (float)preview.low;
        range[1] = (float)preview.high;
    }
    weft_output_file_discard(&writer.file);
    free(packed);
    return res;
}
