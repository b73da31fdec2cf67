// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/codes/decode.h"
#include "tiles/image/image_impl.h"
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
              ? weft_image_take_info(payload.data, payload.size, WEFT_IMAGE_FILE_EXR, part, image)
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

static enum weft_result read_exr(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out)
{
    static const char program[] = "weft-read-exr";
    weft_reader *reader = NULL;
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
    return res;
}

// ---- PNG and TIFF -------------------------------------------------------------------------------

// What the reader says of a part, and where its values are in its answer.
static enum weft_result find_values(const struct weft_payload *payload,
                                    enum weft_image_file_kind kind, int part, bool info_only,
                                    const void **values, struct weft_image *image)
{
    struct weft_wire_frame wire;
    size_t count, bytes = 0;
    if (payload->size < sizeof wire)
        return WEFT_ERR_READER;
    memcpy(&wire, payload->data, sizeof wire);
    if (wire.planes_offset > payload->size || wire.planes_offset < sizeof wire ||
        wire.info_bytes > wire.planes_offset - sizeof wire)
        return WEFT_ERR_READER;
    enum weft_result res = weft_image_take_info((const char *)payload->data + sizeof wire,
                                                wire.info_bytes, kind, part, image);
    if (res == WEFT_OK)
        res = weft_image_take_codes(&wire, image);
    if (res != WEFT_OK)
        return res;
    const size_t value = weft_wire_pixel_size(image->channels[0].type);
    if (!info_only && (!weft_size_mul((size_t)image->width, image->channel_count * value, &count) ||
                       !weft_size_mul(count, (size_t)image->height, &bytes)))
        return WEFT_ERR_READER;
    *values = (const char *)payload->data + wire.planes_offset;
    return bytes == payload->size - wire.planes_offset ? WEFT_OK : WEFT_ERR_READER;
}

static enum weft_result take_frame(const struct weft_image_load_params *params,
                                   const struct weft_payload *payload,
                                   enum weft_image_file_kind kind, int part, const void **values,
                                   struct weft_image *image)
{
    const enum weft_result res = find_values(payload, kind, part, params->info_only, values, image);
    if (res == WEFT_ERR_READER)
        weft_error(params->log, "%s: the answer of %s contradicts itself", params->path,
                   weft_image_program(kind));
    else if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "%s: out of memory for its header", params->path);
    return res;
}

// What the codes stand for.
static enum weft_result choose_transfer(const struct weft_image_load_params *params,
                                        struct weft_image *image)
{
    image->transfer = params->transfer;
    if (!weft_codes_is_integer(image->channels[0].type))
        image->transfer = (struct weft_transfer){.curve = WEFT_CURVE_LINEAR};
    if (image->transfer.curve != WEFT_CURVE_AUTO ||
        weft_transfer_find(&image->codes, &image->transfer))
        return WEFT_OK;
    weft_error(params->log,
               "%s has the transfer function %d of H.273 (cICP), which weft does not know: what "
               "its codes are must be said",
               params->path, image->codes.cicp[1]);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result fill_planes(const struct weft_image_load_params *params, const void *values,
                                    struct weft_image *image)
{
    const int threads = params->threads ? params->threads : weft_threads_available();
    enum weft_result res = choose_transfer(params, image);
    if (res == WEFT_OK)
        res = set_rows(params, image);
    if (res != WEFT_OK)
        return res;
    // Rows and columns are of an answer that is there.
    const size_t bytes = sizeof(float) * (size_t)image->width * (size_t)image->rows;
    res = make_planes(image, bytes) ? weft_codes_decode(values, threads, image) : WEFT_ERR_MEMORY;
    if (res != WEFT_OK)
        weft_error(params->log, "%s: out of memory for %d x %d pixels", params->path, image->width,
                   image->rows);
    return res;
}

static enum weft_result ask_frame(const struct weft_image_load_params *params, weft_reader *reader,
                                  int part, struct weft_payload *payload)
{
    const struct weft_wire_request request = {
        .op = WEFT_WIRE_IMAGE_FRAME, .part = (uint32_t)part, .info_only = params->info_only};
    struct weft_wire_answer answer;
    return weft_reader_call(reader, &request, NULL, &answer, payload);
}

enum weft_result weft_image_read_values(const struct weft_image_load_params *params, int fd,
                                        enum weft_image_file_kind kind,
                                        struct weft_image_values *values, struct weft_image *image)
{
    weft_reader *reader = NULL;
    enum weft_result res = weft_reader_start(params->log, weft_image_program(kind), params->path,
                                             fd, &params->limits, &reader);
    if (res == WEFT_OK)
        res = ask_frame(params, reader, params->part, &values->payload);
    if (res == WEFT_OK)
        res = take_frame(params, &values->payload, kind, params->part, &values->values, image);
    weft_reader_stop(&reader);
    return res;
}

static enum weft_result read_codes(const struct weft_image_load_params *params, int fd,
                                   enum weft_image_file_kind kind, struct weft_image *out)
{
    struct weft_image_values values = {.values = NULL};
    enum weft_result res = weft_image_read_values(params, fd, kind, &values, out);
    if (res == WEFT_OK && !params->info_only)
        res = fill_planes(params, values.values, out);
    weft_payload_release(&values.payload);
    return res;
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result weft_image_read(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out)
{
    enum weft_image_file_kind kind;
    *out = (struct weft_image){0};
    enum weft_result res = weft_image_find_kind(params->log, params->path, fd, &kind);
    if (res == WEFT_OK)
        res = kind == WEFT_IMAGE_FILE_EXR ? read_exr(params, fd, out)
                                          : read_codes(params, fd, kind, out);
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
    weft_require(params->log, (unsigned)params->transfer.curve < WEFT_CURVE_COUNT);
    weft_require(params->log,
                 params->transfer.curve != WEFT_CURVE_POWER ||
                     (params->transfer.exponent > 0.0 && isfinite(params->transfer.exponent)));

    res = weft_reader_open(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_image_read(params, fd, out);
fail:
    if (fd >= 0)
        close(fd);
    return res;
}

// ---- all parts ----------------------------------------------------------------------------------

struct lister {
    const struct weft_image_load_params *params; // info_only
    enum weft_image_file_kind kind;
    weft_reader *reader;
};

static enum weft_result ask_part(const struct lister *l, int part, struct weft_image *out)
{
    const struct weft_image_load_params *params = l->params;
    struct weft_payload payload = {0};
    const void *values;
    if (l->kind == WEFT_IMAGE_FILE_EXR)
        return ask(params, weft_image_program(l->kind), l->reader, WEFT_WIRE_IMAGE_INFO, part, out);
    enum weft_result res = ask_frame(params, l->reader, part, &payload);
    if (res == WEFT_OK)
        res = take_frame(params, &payload, l->kind, part, &values, out);
    weft_payload_release(&payload);
    return res;
}

static enum weft_result ask_parts(const struct lister *l, struct weft_image_list *out)
{
    const struct weft_image_load_params *params = l->params;
    struct weft_image first = {0};
    enum weft_result res = ask_part(l, 0, &first);
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
        res = ask_part(l, part, &out->images[out->count++]);
    return res;
}

enum weft_result weft_image_list_load(const struct weft_image_load_params *params,
                                      struct weft_image_list *out)
{
    *out = (struct weft_image_list){0};
    const struct weft_image_load_params only = {
        .path = params->path, .info_only = true, .limits = params->limits, .log = params->log};
    struct lister lister = {.params = &only};
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);

    res = weft_reader_open(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_image_find_kind(params->log, params->path, fd, &lister.kind);
    if (res == WEFT_OK)
        res = weft_reader_start(params->log, weft_image_program(lister.kind), params->path, fd,
                                &params->limits, &lister.reader);
    if (res == WEFT_OK)
        res = ask_parts(&lister, out);
fail:
    weft_reader_stop(&lister.reader);
    if (fd >= 0)
        close(fd);
    if (res != WEFT_OK)
        weft_image_list_clear(out);
    return res;
}
