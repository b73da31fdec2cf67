// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/codes/write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/codes/encode.h"
#include "tiles/image/codes/png.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/client.h"

// ---- rows by several threads --------------------------------------------------------------------

// What each thread works with, and what its rows lost.
struct lane {
    float *scratch;
    struct weft_codes_losses losses;
};

struct rows {
    const struct weft_image *image;
    weft_codes *codes;
    struct lane *lanes;
    int threads;
    char *out; // all of them, of what is not written row by row
};

static void free_rows(struct rows *r)
{
    for (int t = 0; r->lanes && t < r->threads; t++)
        free(r->lanes[t].scratch);
    free(r->lanes);
    weft_codes_destroy(&r->codes);
}

static enum weft_result make_rows(const struct weft_image *image, enum weft_image_file_kind kind,
                                  int threads, const struct weft_log *log, struct rows *out)
{
    *out = (struct rows){.image = image, .threads = threads};
    const enum weft_result res = weft_codes_create(image, kind, log, &out->codes);
    if (res != WEFT_OK)
        return res;
    bool whole = (out->lanes = calloc((size_t)threads, sizeof *out->lanes)) != NULL;
    for (int t = 0; whole && t < threads; t++)
        whole = (out->lanes[t].scratch = malloc((size_t)image->width * sizeof(float))) != NULL;
    if (whole)
        return WEFT_OK;
    weft_error(log, "out of memory for rows of %d pixels", image->width);
    free_rows(out);
    return WEFT_ERR_MEMORY;
}

static void add_losses(const struct rows *r, struct weft_image_save_report *report)
{
    for (int t = 0; t < r->threads; t++) {
        report->clamped += r->lanes[t].losses.clamped;
        report->overflows += r->lanes[t].losses.halves.overflows;
        report->rounding = fmax(report->rounding, r->lanes[t].losses.halves.rounding);
    }
    report->values +=
        (uint64_t)r->image->width * (uint64_t)r->image->height * r->image->channel_count;
}

// ---- PNG ----------------------------------------------------------------------------------------

static void fill_row(const void *priv, int thread, int32_t y, uint8_t *out)
{
    const struct rows *r = priv;
    struct lane *lane = &r->lanes[thread];
    weft_codes_row(r->codes, y, out, lane->scratch, &lane->losses);
}

static enum weft_result write_png(const struct weft_image *image, int threads,
                                  const struct weft_image_save_params *params,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report)
{
    struct rows rows;
    enum weft_result res = make_rows(image, params->kind, threads, params->log, &rows);
    if (res != WEFT_OK)
        return res;
    const struct weft_codes_shape *shape = weft_codes_shape(rows.codes);
    const struct weft_png_writer png = {.width = image->width,
                                        .height = image->height,
                                        .samples = (int)shape->channels,
                                        .bits = 8 * (int)shape->value_bytes,
                                        .threads = threads,
                                        .says = image,
                                        .fill_row = fill_row,
                                        .priv = &rows,
                                        .progress = params->progress};
    res = weft_png_write(&png, file);
    add_losses(&rows, report);
    free_rows(&rows);
    return res;
}

// ---- TIFF ---------------------------------------------------------------------------------------

enum { BAND = 16 }; // rows that a thread makes at a time

static bool make_band(void *priv, int thread, size_t band)
{
    struct rows *r = priv;
    const int32_t first = (int32_t)band * BAND, left = r->image->height - first;
    const size_t row_bytes = weft_codes_shape(r->codes)->row_bytes;
    for (int32_t y = first; y < first + (left < BAND ? left : BAND); y++)
        weft_codes_row(r->codes, y, r->out + (size_t)y * row_bytes, r->lanes[thread].scratch,
                       &r->lanes[thread].losses);
    return true;
}

// A part on its way to the writer.
struct tiff_part {
    struct weft_wire_tiff head;
    struct weft_attribute_list texts;
    char *values;
};

static void take_texts(const struct weft_image *image, struct tiff_part *out)
{
    float aspect = 1.0f, density = 0.0f;
    weft_attribute_float(weft_image_find(image, "xDensity"), &density);
    weft_attribute_float(weft_image_find(image, "pixelAspectRatio"), &aspect);
    if (aspect > 1e-3f && aspect < 1e3f)
        out->head.aspect = aspect;
    if (density > 0.01f && density < 1e6f)
        out->head.density = density;
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        if (!strcmp(a->type, "string") || !strcmp(a->name, WEFT_ATTRIBUTE_ICC))
            weft_attribute_add(&out->texts, a->name, a->type, a->data, a->size);
    }
    if (*image->name)
        weft_attribute_add(&out->texts, "name", "string", image->name, strlen(image->name));
}

static enum weft_result fill_part(struct rows *rows, struct tiff_part *out)
{
    const struct weft_image *image = rows->image;
    const struct weft_codes_shape *shape = weft_codes_shape(rows->codes);
    size_t bytes;
    out->head = (struct weft_wire_tiff){.width = (uint32_t)image->width,
                                        .height = (uint32_t)image->height,
                                        .type = shape->type,
                                        .channels = (uint32_t)shape->channels,
                                        .colours = (uint32_t)shape->colours,
                                        .alpha = shape->alpha,
                                        .associated = shape->associated,
                                        .compression = image->compression,
                                        .tile = {image->tiled ? (uint32_t)image->tile[0] : 0,
                                                 image->tiled ? (uint32_t)image->tile[1] : 0},
                                        .aspect = 1.0f};
    take_texts(image, out);
    if (!weft_size_mul(shape->row_bytes, (size_t)image->height, &bytes) ||
        !weft_attribute_end(&out->texts) || !(rows->out = out->values = malloc(bytes)))
        return WEFT_ERR_MEMORY;
    out->head.header_bytes = out->texts.size;
    out->head.value_bytes = bytes;
    weft_threads_run(rows->threads, ((size_t)image->height - 1) / BAND + 1, make_band, rows);
    return WEFT_OK;
}

static enum weft_result make_tiff_part(const struct weft_image *image, int threads,
                                       const struct weft_image_save_params *params,
                                       struct tiff_part *out, struct weft_image_save_report *report)
{
    struct rows rows;
    enum weft_result res = make_rows(image, params->kind, threads, params->log, &rows);
    if (res != WEFT_OK)
        return res;
    res = fill_part(&rows, out);
    if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "out of memory for %d x %d pixels of %zu channels", image->width,
                   image->height, image->channel_count);
    add_losses(&rows, report);
    free_rows(&rows);
    return res;
}

// The writer has what it takes, whatever the image is.
static struct weft_limits limits_for(const struct tiff_part *parts, size_t count)
{
    uint64_t bytes = 0;
    for (size_t p = 0; p < count; p++)
        bytes += parts[p].head.value_bytes + parts[p].head.header_bytes;
    return (struct weft_limits){
        .memory_bytes = (UINT64_C(1) << 30) + 2 * bytes,
        .output_bytes = (UINT64_C(1) << 30) + 2 * bytes,
        .cpu_seconds = 600 + (uint32_t)(bytes / 10000000),
        .wall_seconds = 600 + (uint32_t)(bytes / 10000000),
    };
}

// That the writer left what it says.
static enum weft_result check_written(const struct weft_output_file *file, uint64_t told)
{
    struct stat st;
    if (fstat(file->fd, &st))
        return weft_output_file_fail(file);
    if ((uint64_t)st.st_size == told && told > 8)
        return WEFT_OK;
    weft_error(file->log, "cannot write %s: weft-write-tiff tells of %llu bytes, and left %llu",
               file->path, (unsigned long long)told, (unsigned long long)st.st_size);
    return WEFT_ERR_WRITE;
}

static enum weft_result send_parts(const struct tiff_part *parts, size_t count,
                                   struct weft_output_file *file)
{
    const struct weft_wire_request request = {.op = WEFT_WIRE_IMAGE_WRITE, .part = (uint32_t)count};
    const struct weft_limits limits = limits_for(parts, count);
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    weft_reader *writer = NULL;
    struct iovec *pieces = calloc(3 * count, sizeof *pieces);
    if (!pieces) {
        weft_error(file->log, "out of memory for %zu parts", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t p = 0; p < count; p++) {
        pieces[3 * p] = (struct iovec){(void *)(uintptr_t)&parts[p].head, sizeof parts[p].head};
        pieces[3 * p + 1] = (struct iovec){parts[p].texts.data, parts[p].texts.size};
        pieces[3 * p + 2] = (struct iovec){parts[p].values, parts[p].head.value_bytes};
    }
    enum weft_result res =
        weft_reader_start(file->log, "weft-write-tiff", file->path, file->fd, &limits, &writer);
    if (res == WEFT_OK)
        res = weft_reader_call_parts(writer, &request, pieces, (int)(3 * count), &answer, &payload);
    if (res == WEFT_OK)
        res = check_written(file, answer.count[0]);
    weft_payload_release(&payload);
    weft_reader_stop(&writer);
    free(pieces);
    return res;
}

static bool report_step(const struct weft_image_save_params *params, size_t done, size_t all)
{
    const struct weft_progress *progress = params->progress;
    return !progress || !progress->report ||
           progress->report(progress->priv, (double)done / (double)all);
}

static enum weft_result write_tiff(const struct weft_image *images, size_t count, int threads,
                                   const struct weft_image_save_params *params,
                                   struct weft_output_file *file,
                                   struct weft_image_save_report *report)
{
    struct tiff_part *parts = calloc(count, sizeof *parts);
    enum weft_result res = WEFT_OK;
    if (!parts) {
        weft_error(params->log, "out of memory for %zu parts", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t p = 0; res == WEFT_OK && p < count; p++) {
        res = make_tiff_part(&images[p], threads, params, &parts[p], report);
        if (res == WEFT_OK && !report_step(params, p, count))
            res = WEFT_ERR_CANCELLED;
    }
    if (res == WEFT_OK)
        res = send_parts(parts, count, file);
    for (size_t p = 0; p < count; p++) {
        free(parts[p].values);
        free(parts[p].texts.data);
    }
    free(parts);
    return res;
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result weft_codes_write(const struct weft_image *parts, size_t count, int threads,
                                  const struct weft_image_save_params *params,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report)
{
    enum weft_result res = params->kind == WEFT_IMAGE_FILE_PNG
                               ? write_png(parts, threads, params, file, report)
                               : write_tiff(parts, count, threads, params, file, report);
    if (res == WEFT_OK && !report_step(params, 1, 1))
        res = WEFT_ERR_CANCELLED;
    return res;
}

enum weft_result weft_codes_compare(const struct weft_image *image, enum weft_image_file_kind kind,
                                    const struct weft_log *log, const void *values, char what[200])
{
    struct rows rows;
    enum weft_result res = make_rows(image, kind, 1, log, &rows);
    if (res != WEFT_OK)
        return res;
    const struct weft_codes_shape *shape = weft_codes_shape(rows.codes);
    char *row = malloc(shape->row_bytes);
    res = row ? WEFT_OK : WEFT_ERR_MEMORY;
    for (int32_t y = 0; res == WEFT_OK && y < image->height; y++) {
        const char *read = (const char *)values + (size_t)y * shape->row_bytes;
        weft_codes_row(rows.codes, y, row, rows.lanes[0].scratch, &rows.lanes[0].losses);
        if (!memcmp(row, read, shape->row_bytes))
            continue;
        size_t i = 0;
        while (row[i] == read[i])
            i++;
        const size_t value = i / shape->value_bytes;
        snprintf(what, 200, "value (%zu, %d) of channel %zu is another", value / shape->channels,
                 (int)y, value % shape->channels);
        res = WEFT_ERR_WRITE;
    }
    free(row);
    free_rows(&rows);
    return res;
}
