// SPDX-License-Identifier: BSD-3-Clause
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/image_impl.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/client.h"

enum { PIECE = 1 << 20 }; // bytes of a plane, copied by one thread

// ---- the answer to IMAGE_PIXELS -----------------------------------------------------------------

// Planes as they came, to be copied in pieces.
struct copy {
    struct weft_image *image;
    const char *data;           // the rows that are wanted of the first plane
    size_t given_bytes;         // from plane to plane
    size_t plane_bytes, pieces; // of each plane
};

static bool copy_piece(void *priv, int thread, size_t i)
{
    const struct copy *copy = priv;
    struct weft_image_channel *channel = &copy->image->channels[i / copy->pieces];
    const size_t from = i % copy->pieces * PIECE, left = copy->plane_bytes - from;
    const size_t bytes = left < PIECE ? left : PIECE, first = from / sizeof *channel->plane;
    const char *data = copy->data + i / copy->pieces * copy->given_bytes + from;
    (void)thread;
    if (channel->type != WEFT_PIXEL_UINT) {
        memcpy(channel->plane + first, data, bytes);
        return true;
    }
    memcpy(channel->integers + first, data, bytes);
    for (size_t k = first; k < first + bytes / sizeof *channel->plane; k++)
        channel->plane[k] = (float)channel->integers[k];
    return true;
}

static bool make_planes(struct weft_image *image, size_t plane_bytes)
{
    for (size_t c = 0; c < image->channel_count; c++) {
        struct weft_image_channel *channel = &image->channels[c];
        const bool integers = channel->type == WEFT_PIXEL_UINT;
        channel->plane = malloc(plane_bytes);
        channel->integers = integers ? malloc(plane_bytes) : NULL;
        if (!channel->plane || (integers && !channel->integers))
            return false;
    }
    return true;
}

// Of rows from `first` on, `rows` of them, where the image's are wanted.
static enum weft_result take_pixels(const struct weft_payload *payload, uint64_t first,
                                    uint64_t rows, int threads, struct weft_image *image)
{
    size_t row_bytes, given_bytes, size;
    const uint64_t wanted = (uint64_t)image->first_row;
    if (first > wanted || rows > INT32_MAX || wanted - first + (uint64_t)image->rows > rows ||
        !weft_size_mul((size_t)image->width, sizeof(float), &row_bytes) ||
        !weft_size_mul(row_bytes, (size_t)rows, &given_bytes) ||
        !weft_size_mul(given_bytes, image->channel_count, &size) || size != payload->size)
        return WEFT_ERR_READER;
    const size_t plane_bytes = row_bytes * (size_t)image->rows;
    if (!make_planes(image, plane_bytes))
        return WEFT_ERR_MEMORY;
    struct copy copy = {image, (const char *)payload->data + (wanted - first) * row_bytes,
                        given_bytes, plane_bytes, (plane_bytes - 1) / PIECE + 1};
    const size_t pieces = copy.pieces * image->channel_count;
    weft_threads_run(pieces > 1 ? threads : 1, pieces, copy_piece, &copy);
    return WEFT_OK;
}

// ---- asking -------------------------------------------------------------------------------------

// Of part `part` of the file.
static enum weft_result ask(const struct weft_image_load_params *params, const char *program,
                            weft_reader *reader, enum weft_wire_op op, int part,
                            struct weft_image *image)
{
    const int threads = params->threads ? params->threads : weft_threads_available();
    struct weft_wire_request request = {
        .op = op, .part = (uint32_t)part, .threads = (uint32_t)threads};
    if (op == WEFT_WIRE_IMAGE_PIXELS) {
        request.first_row = (uint32_t)image->first_row;
        request.rows = (uint32_t)image->rows;
    }
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res = weft_reader_call(reader, &request, NULL, &answer, &payload);
    if (res != WEFT_OK)
        return res;
    res = op == WEFT_WIRE_IMAGE_INFO
              ? weft_image_take_info(payload.data, payload.size, part, image)
              : take_pixels(&payload, answer.count[0], answer.count[1], threads, image);
    if (res == WEFT_ERR_READER)
        weft_error(params->log, "%s: the answer of %s contradicts itself", params->path, program);
    else if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "%s: out of memory for %zu bytes", params->path, payload.size);
    weft_payload_release(&payload);
    return res;
}

static bool is_dwa(const struct weft_image *image)
{
    return !image->deep &&
           (image->compression == WEFT_IMAGE_DWAA || image->compression == WEFT_IMAGE_DWAB);
}

// The rows that are wanted.
static enum weft_result set_rows(const struct weft_image_load_params *params,
                                 struct weft_image *image)
{
    image->first_row = params->first_row;
    image->rows = params->first_row || params->rows ? params->rows : image->height;
    if (image->first_row >= 0 && image->rows >= 1 &&
        image->rows <= image->height - image->first_row)
        return WEFT_OK;
    weft_error(params->log, "%s: there are no %d rows from row %d on: it has %d", params->path,
               params->rows, params->first_row, image->height);
    return WEFT_ERR_ARGUMENT;
}

// DWA has a program of its own, which knows channels in the order of their names only.
static enum weft_result read_dwa(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *image)
{
    static const char program[] = "weft-read-dwa";
    weft_reader *reader = NULL;
    for (size_t c = 1; c < image->channel_count; c++) {
        if (strcmp(image->channels[c - 1].name, image->channels[c].name) < 0)
            continue;
        weft_error(params->log, "%s: its channels are not in the order of their names",
                   params->path);
        return WEFT_ERR_FORMAT;
    }
    enum weft_result res =
        weft_reader_start(params->log, program, params->path, fd, &params->limits, &reader);
    if (res == WEFT_OK)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_PIXELS, params->part, image);
    weft_reader_stop(&reader);
    return res;
}

enum weft_result weft_image_read(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out)
{
    static const char program[] = "weft-read-exr";
    weft_reader *reader = NULL;
    *out = (struct weft_image){0};
    enum weft_result res =
        weft_reader_start(params->log, program, params->path, fd, &params->limits, &reader);
    if (res == WEFT_OK)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_INFO, params->part, out);
    if (res == WEFT_OK && !params->info_only)
        res = set_rows(params, out);
    if (res == WEFT_OK && !params->info_only && is_dwa(out))
        res = read_dwa(params, fd, out);
    else if (res == WEFT_OK && !params->info_only)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_PIXELS, params->part, out);
    weft_reader_stop(&reader);
    if (res != WEFT_OK)
        weft_image_clear(out);
    return res;
}

enum weft_result weft_image_load(const struct weft_image_load_params *params,
                                 struct weft_image *out)
{
    *out = (struct weft_image){0};
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);
    weft_require(params->log, params->part >= 0);
    weft_require(params->log, params->threads >= 0 && params->threads <= WEFT_IMAGE_MAX_THREADS);

    res = weft_reader_open(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_image_read(params, fd, out);
fail:
    if (fd >= 0)
        close(fd);
    return res;
}

static enum weft_result ask_parts(const struct weft_image_load_params *params, weft_reader *reader,
                                  struct weft_image_list *out)
{
    struct weft_image first = {0};
    enum weft_result res = ask(params, "weft-read-exr", reader, WEFT_WIRE_IMAGE_INFO, 0, &first);
    if (res == WEFT_OK)
        out->images = calloc((size_t)first.part_count, sizeof *out->images);
    if (res == WEFT_OK && !out->images) {
        weft_error(params->log, "%s: out of memory for %d parts", params->path, first.part_count);
        res = WEFT_ERR_MEMORY;
    }
    if (res != WEFT_OK) {
        weft_image_clear(&first);
        return res;
    }
    out->images[out->count++] = first;
    for (int part = 1; res == WEFT_OK && part < first.part_count; part++)
        res = ask(params, "weft-read-exr", reader, WEFT_WIRE_IMAGE_INFO, part,
                  &out->images[out->count++]);
    return res;
}

enum weft_result weft_image_list_load(const struct weft_image_load_params *params,
                                      struct weft_image_list *out)
{
    *out = (struct weft_image_list){0};
    weft_reader *reader = NULL;
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);

    res = weft_reader_open(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_reader_start(params->log, "weft-read-exr", params->path, fd, &params->limits,
                                &reader);
    if (res == WEFT_OK)
        res = ask_parts(params, reader, out);
fail:
    weft_reader_stop(&reader);
    if (fd >= 0)
        close(fd);
    if (res != WEFT_OK)
        weft_image_list_clear(out);
    return res;
}
