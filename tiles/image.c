// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

#include "filter/check.h"
#include "tiles/output_file.h"

// What the C++ library accepts in a window; names of 32 characters and more need a flag in the
// file.
enum { COORDINATE_LIMIT = INT_MAX / 2, SHORT_NAME = 31, LINES_PER_CHUNK = 16, ZIP_LEVEL = 4 };

void weft_image_clear(struct weft_image *image)
{
    if (!image)
        return;
    for (size_t c = 0; c < image->channel_count; c++)
        free(image->channels[c].plane);
    free(image->channels);
    free(image->metadata);
    *image = (struct weft_image){0};
}

struct saver {
    const struct weft_image *image;
    const struct weft_image_channel **sorted; // EXR stores channels by name
    const struct weft_log *log;
    struct weft_output_file file;
    exr_context_t exr;
    enum weft_result write_result; // already logged when it is not WEFT_OK
    char message[256];             // the first that OpenEXRCore told
};

// ---- checks ------------------------------------------------------------------------------------

static bool is_terminated(const char *text, size_t size)
{
    return memchr(text, '\0', size) != NULL;
}

static bool window_fits(const struct weft_image *image)
{
    int64_t x1 = (int64_t)image->x + image->width - 1, y1 = (int64_t)image->y + image->height - 1;
    return image->x > -COORDINATE_LIMIT && image->y > -COORDINATE_LIMIT && x1 < COORDINATE_LIMIT &&
           y1 < COORDINATE_LIMIT;
}

static enum weft_result check_image(const struct weft_image *image, const struct weft_log *log)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, image->width > 0 && image->height > 0);
    weft_require(log, window_fits(image));
    weft_require(log, image->width <= INT_MAX / (int)sizeof(float)); // strides are int in the codec
    weft_require(log, image->channel_count > 0 && image->channel_count <= INT16_MAX);
    weft_require(log, image->channels != NULL);
    weft_require(log, image->metadata_count == 0 || image->metadata != NULL);
    for (size_t c = 0; c < image->channel_count; c++) {
        const struct weft_image_channel *channel = &image->channels[c];
        weft_require(log, channel->plane != NULL);
        weft_require(log, channel->name[0] && is_terminated(channel->name, sizeof channel->name));
    }
    for (size_t m = 0; m < image->metadata_count; m++) {
        const struct weft_metadata *entry = &image->metadata[m];
        weft_require(log, entry->key[0] && is_terminated(entry->key, sizeof entry->key));
        weft_require(log, is_terminated(entry->value, sizeof entry->value));
    }
    res = WEFT_OK;
fail:
    return res;
}

static int compare_names(const void *a, const void *b)
{
    const struct weft_image_channel *const *p = a, *const *q = b;
    return strcmp((*p)->name, (*q)->name);
}

static enum weft_result sort_channels(struct saver *s)
{
    size_t count = s->image->channel_count;
    s->sorted = calloc(count, sizeof *s->sorted);
    if (!s->sorted) {
        weft_error(s->log, "cannot write %s: out of memory", s->file.path);
        return WEFT_ERR_MEMORY;
    }
    for (size_t c = 0; c < count; c++)
        s->sorted[c] = &s->image->channels[c];
    qsort(s->sorted, count, sizeof *s->sorted, compare_names);
    for (size_t c = 1; c < count; c++) {
        if (strcmp(s->sorted[c - 1]->name, s->sorted[c]->name))
            continue;
        weft_error(s->log, "two channels are named \"%s\"", s->sorted[c]->name);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// ---- OpenEXRCore --------------------------------------------------------------------------------

// The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold the context's
// lock.
static _Thread_local struct saver *current;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message);
}

static int64_t write_bytes(exr_const_context_t exr, void *priv, const void *data, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct saver *s = priv;
    if (s->write_result == WEFT_OK)
        s->write_result = weft_output_file_write(&s->file, offset, data, size);
    if (s->write_result == WEFT_OK)
        return (int64_t)size;
    error(exr, EXR_ERR_WRITE_IO, "write failed");
    return -1;
}

static enum weft_result report(struct saver *s, exr_result_t code)
{
    if (code == EXR_ERR_SUCCESS)
        return WEFT_OK;
    if (s->write_result != WEFT_OK)
        return s->write_result;
    weft_error(s->log, "cannot write %s: %s", s->file.path,
               s->message[0] ? s->message : exr_get_default_error_message(code));
    return code == EXR_ERR_OUT_OF_MEMORY ? WEFT_ERR_MEMORY : WEFT_ERR_WRITE;
}

static exr_result_t start(struct saver *s)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.alloc_fn = malloc;
    init.free_fn = free;
    init.user_data = s;
    init.write_fn = write_bytes;
    init.zip_level = ZIP_LEVEL;
    return exr_start_write(&s->exr, s->file.path, EXR_WRITE_FILE_DIRECTLY, &init);
}

static bool has_long_names(const struct weft_image *image)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (strlen(image->channels[c].name) > SHORT_NAME)
            return true;
    for (size_t m = 0; m < image->metadata_count; m++)
        if (strlen(image->metadata[m].key) > SHORT_NAME)
            return true;
    return false;
}

static exr_result_t set_windows(struct saver *s)
{
    const struct weft_image *image = s->image;
    exr_attr_box2i_t data = {0}, display = {0};
    data.min.x = image->x;
    data.min.y = image->y;
    data.max.x = image->x + image->width - 1;
    data.max.y = image->y + image->height - 1;
    display.min.x = image->display_min[0];
    display.min.y = image->display_min[1];
    display.max.x = image->display_max[0];
    display.max.y = image->display_max[1];
    static const exr_attr_box2i_t unset;
    static const exr_attr_v2f_t centre;
    if (!memcmp(&display, &unset, sizeof display))
        display = data;
    return exr_initialize_required_attr(s->exr, 0, &display, &data, 1.0f, &centre, 1.0f,
                                        EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
}

// The format's own attributes, of other types than string, are made from the image itself.
static bool is_reserved(const char *name)
{
    static const char *const reserved[] = {
        "channels",  "chunkCount", "compression",      "dataWindow",        "displayWindow",
        "lineOrder", "name",       "pixelAspectRatio", "screenWindowWidth", "screenWindowCenter",
        "tiles",     "type",       "version",
    };
    for (size_t i = 0; i < WEFT_COUNT(reserved); i++)
        if (!strcmp(name, reserved[i]))
            return true;
    return false;
}

static exr_result_t set_header(struct saver *s)
{
    int part;
    exr_result_t rv = exr_add_part(s->exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!rv && has_long_names(s->image))
        rv = exr_set_longname_support(s->exr, 1);
    if (!rv)
        rv = set_windows(s);
    for (size_t c = 0; !rv && c < s->image->channel_count; c++)
        rv = exr_add_channel(s->exr, 0, s->sorted[c]->name, EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (size_t m = 0; !rv && m < s->image->metadata_count; m++) {
        const struct weft_metadata *entry = &s->image->metadata[m];
        if (!is_reserved(entry->key))
            rv = exr_attr_set_string(s->exr, 0, entry->key, entry->value);
    }
    return rv ? rv : exr_write_header(s->exr);
}

static void point_to_lines(const struct saver *s, exr_encode_pipeline_t *encode, int32_t line)
{
    size_t stride_bytes = (size_t)s->image->width * sizeof(float);
    for (int c = 0; c < encode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encode->channels[c];
        channel->encode_from_ptr = (const uint8_t *)s->sorted[c]->plane + line * stride_bytes;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)stride_bytes;
    }
}

static exr_result_t write_pixels(struct saver *s)
{
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t rv = EXR_ERR_SUCCESS;
    for (int32_t line = 0; !rv && line < s->image->height; line += LINES_PER_CHUNK) {
        exr_chunk_info_t chunk;
        rv = exr_write_scanline_chunk_info(s->exr, 0, s->image->y + line, &chunk);
        if (!rv)
            rv = line ? exr_encoding_update(s->exr, 0, &chunk, &encode)
                      : exr_encoding_initialize(s->exr, 0, &chunk, &encode);
        if (rv)
            break;
        point_to_lines(s, &encode, line);
        if (!line)
            rv = exr_encoding_choose_default_routines(s->exr, 0, &encode);
        if (!rv)
            rv = exr_encoding_run(s->exr, 0, &encode);
    }
    exr_encoding_destroy(s->exr, &encode);
    return rv;
}

static exr_result_t write_exr(struct saver *s)
{
    current = s;
    exr_result_t rv = start(s);
    if (!rv)
        rv = set_header(s);
    if (!rv)
        rv = write_pixels(s);
    if (s->exr) {
        exr_result_t finished = exr_finish(&s->exr);
        rv = rv ? rv : finished;
    }
    current = NULL;
    return rv;
}

enum weft_result weft_image_save(const struct weft_image *image,
                                 const struct weft_image_save_params *params)
{
    struct saver s = {.image = image, .log = params->log};
    enum weft_result res = check_image(image, params->log);
    if (res == WEFT_OK)
        res = weft_output_file_create(params->log, params->path, params->no_clobber, &s.file);
    if (res == WEFT_OK)
        res = sort_channels(&s);
    if (res == WEFT_OK)
        res = report(&s, write_exr(&s));
    if (res == WEFT_OK)
        res = weft_output_file_commit(&s.file);
    free(s.sorted);
    weft_output_file_discard(&s.file);
    return res;
}
