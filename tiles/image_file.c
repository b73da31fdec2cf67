// SPDX-License-Identifier: BSD-3-Clause
// Whatever weft-read-exr says is checked again here: a damaged file may have taken it over.
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "tiles/image.h"
#include "tiles/readers/client.h"

static enum weft_result open_input(const struct weft_log *log, const char *path, int *out)
{
    struct stat st;
    // Without O_NONBLOCK a pipe would wait for a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &st)) {
        weft_error(log, "cannot open %s: %s", path, strerror(errno));
    } else if (S_ISDIR(st.st_mode)) {
        weft_error(log, "cannot open %s: %s", path, strerror(EISDIR));
    } else if (!S_ISREG(st.st_mode)) {
        weft_error(log, "cannot open %s: not a regular file", path);
    } else if (st.st_size == 0) {
        weft_error(log, "%s: the file is empty", path);
        close(fd);
        return WEFT_ERR_FORMAT;
    } else {
        *out = fd;
        return WEFT_OK;
    }
    if (fd >= 0)
        close(fd);
    return WEFT_ERR_OPEN;
}

// ---- the answer to IMAGE_INFO
// ---------------------------------------------------------------------

// Ended, and free of what could command a terminal.
static bool clean_text(char *text, size_t size)
{
    char *end = memchr(text, '\0', size);
    if (!end)
        return false;
    for (char *c = text; c < end; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = *c == '\n' || *c == '\t' ? ' ' : '?';
    memset(end, 0, size - (size_t)(end - text));
    return true;
}

static bool plausible_frame(const struct weft_image *image)
{
    unsigned char tiled;
    memcpy(&tiled, &image->tiled, 1);
    return tiled <= 1 && image->width > 0 && image->height > 0 &&
           (int64_t)image->x + image->width - 1 <= INT32_MAX &&
           (int64_t)image->y + image->height - 1 <= INT32_MAX &&
           image->display_min[0] <= image->display_max[0] &&
           image->display_min[1] <= image->display_max[1];
}

static bool plausible_counts(const struct weft_image *image, size_t payload_size)
{
    size_t channels, metadata, size;
    return image->channel_count > 0 && image->channel_count <= INT16_MAX &&
           weft_size_mul(image->channel_count, sizeof *image->channels, &channels) &&
           weft_size_mul(image->metadata_count, sizeof *image->metadata, &metadata) &&
           weft_size_add(channels, metadata, &size) &&
           weft_size_add(size, sizeof(struct weft_wire_image), &size) && size == payload_size;
}

static bool take_channels(struct weft_image *image, const void *data)
{
    bool good = true;
    memcpy(image->channels, data, image->channel_count * sizeof *image->channels);
    for (size_t c = 0; c < image->channel_count; c++) {
        struct weft_image_channel *channel = &image->channels[c];
        channel->plane = NULL;
        good = good && clean_text(channel->name, sizeof channel->name) && channel->name[0] &&
               clean_text(channel->type, sizeof channel->type) &&
               (!strcmp(channel->type, "half") || !strcmp(channel->type, "float") ||
                !strcmp(channel->type, "uint"));
    }
    return good;
}

static bool take_metadata(struct weft_image *image, const void *data)
{
    bool good = true;
    if (image->metadata_count)
        memcpy(image->metadata, data, image->metadata_count * sizeof *image->metadata);
    for (size_t m = 0; m < image->metadata_count; m++) {
        struct weft_metadata *entry = &image->metadata[m];
        good = good && clean_text(entry->key, sizeof entry->key) && entry->key[0] &&
               clean_text(entry->value, sizeof entry->value);
    }
    return good;
}

static enum weft_result take_info(const struct weft_payload *payload, struct weft_image *out)
{
    struct weft_wire_image wire;
    const char *data = payload->data;
    if (payload->size < sizeof wire)
        return WEFT_ERR_READER;
    memcpy(&wire, data, sizeof wire);
    data += sizeof wire;
    if (!plausible_frame(&wire.image) || !plausible_counts(&wire.image, payload->size) ||
        !clean_text(wire.image.compression, sizeof wire.image.compression))
        return WEFT_ERR_READER;

    struct weft_image image = wire.image;
    image.channels = calloc(image.channel_count, sizeof *image.channels);
    image.metadata = calloc(image.metadata_count + 1, sizeof *image.metadata);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (image.channels && image.metadata) {
        bool good = take_channels(&image, data);
        data += image.channel_count * sizeof *image.channels;
        good = take_metadata(&image, data) && good;
        res = good ? WEFT_OK : WEFT_ERR_READER;
    } else if (!image.channels) {
        image.channel_count = 0;
    }
    if (res == WEFT_OK)
        *out = image;
    else
        weft_image_clear(&image);
    return res;
}

// ---- the answer to IMAGE_PIXELS
// -------------------------------------------------------------------

static enum weft_result take_pixels(const struct weft_payload *payload, struct weft_image *image)
{
    size_t plane_bytes, size;
    if (!weft_size_mul((size_t)image->width, (size_t)image->height, &plane_bytes) ||
        !weft_size_mul(plane_bytes, sizeof(float), &plane_bytes) ||
        !weft_size_mul(plane_bytes, image->channel_count, &size) || size != payload->size)
        return WEFT_ERR_READER;
    for (size_t c = 0; c < image->channel_count; c++) {
        image->channels[c].plane = malloc(plane_bytes);
        if (!image->channels[c].plane)
            return WEFT_ERR_MEMORY;
        memcpy(image->channels[c].plane, (const char *)payload->data + c * plane_bytes,
               plane_bytes);
    }
    return WEFT_OK;
}

static enum weft_result ask(const struct weft_image_load_params *params, weft_reader *reader,
                            enum weft_wire_op op, struct weft_image *image)
{
    struct weft_wire_request request = {.op = op};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res = weft_reader_call(reader, &request, NULL, &answer, &payload);
    if (res != WEFT_OK)
        return res;
    res = op == WEFT_WIRE_IMAGE_INFO ? take_info(&payload, image) : take_pixels(&payload, image);
    if (res == WEFT_ERR_READER)
        weft_error(params->log, "%s: the answer of weft-read-exr contradicts itself", params->path);
    else if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "%s: out of memory for %zu bytes", params->path, payload.size);
    weft_payload_release(&payload);
    return res;
}

enum weft_result weft_image_load(const struct weft_image_load_params *params,
                                 struct weft_image *out)
{
    *out = (struct weft_image){0};
    weft_reader *reader = NULL;
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);

    res = open_input(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_reader_start(params->log, "weft-read-exr", params->path, fd, &params->limits,
                                &reader);
    if (res == WEFT_OK)
        res = ask(params, reader, WEFT_WIRE_IMAGE_INFO, out);
    if (res == WEFT_OK && !params->info_only)
        res = ask(params, reader, WEFT_WIRE_IMAGE_PIXELS, out);
fail:
    weft_reader_stop(&reader);
    if (fd >= 0)
        close(fd);
    if (res != WEFT_OK)
        weft_image_clear(out);
    return res;
}
