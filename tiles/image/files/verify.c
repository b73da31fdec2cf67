// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/half.h"
#include "tiles/image/codes/write.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_impl.h"

struct verifier {
    const struct weft_image *given, *read;
    const struct weft_image_save_params *params;
};

__attribute__((format(printf, 2, 3))) static enum weft_result differs(const struct verifier *v,
                                                                      const char *format, ...)
{
    char what[400];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    weft_error(v->params->log, "cannot write %s: read back, %s", v->params->path, what);
    return WEFT_ERR_WRITE;
}

static enum weft_result compare_frame(const struct verifier *v)
{
    const struct weft_image *a = v->given, *b = v->read;
    static const int32_t unset[2];
    const bool display = memcmp(a->display_min, unset, 8) || memcmp(a->display_max, unset, 8);
    if (a->x != b->x || a->y != b->y || a->width != b->width || a->height != b->height ||
        (display &&
         (memcmp(a->display_min, b->display_min, 8) || memcmp(a->display_max, b->display_max, 8))))
        return differs(v, "a window is another");
    if (a->compression != b->compression || strcmp(a->name, b->name))
        return differs(v, "the compression or the part's name is another");
    return WEFT_OK;
}

static enum weft_result compare_attributes(const struct verifier *v)
{
    for (size_t i = 0; i < v->given->attribute_count; i++) {
        const struct weft_image_attribute *a = &v->given->attributes[i];
        const struct weft_image_attribute *b = weft_image_find(v->read, a->name);
        if (weft_attribute_is_structure(a->name))
            continue;
        if (!b || strcmp(a->type, b->type) || a->size != b->size ||
            (a->size && memcmp(a->data, b->data, a->size)))
            return differs(v, "attribute %.256s is %s", a->name, b ? "another" : "missing");
    }
    return WEFT_OK;
}

// What a reader must make of a value: half floats as floats.
static uint32_t stored_bits(const struct weft_image_channel *channel, size_t i)
{
    uint32_t bits;
    float value = channel->plane ? channel->plane[i] : 0.0f;
    if (channel->type == WEFT_PIXEL_UINT)
        return channel->integers[i];
    if (channel->type == WEFT_PIXEL_HALF)
        value = weft_half_to_float(weft_half_from_float(value));
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static uint32_t read_bits(const struct weft_image_channel *channel, size_t i)
{
    uint32_t bits;
    if (channel->type == WEFT_PIXEL_UINT)
        return channel->integers[i];
    memcpy(&bits, channel->plane + i, sizeof bits);
    return bits;
}

static enum weft_result compare_channel(const struct verifier *v,
                                        const struct weft_image_channel *a,
                                        struct weft_image_save_report *report)
{
    const struct weft_image_channel *b = NULL;
    const size_t width = (size_t)v->given->width, count = width * (size_t)v->given->height;
    for (size_t c = 0; !b && c < v->read->channel_count; c++)
        if (!strcmp(v->read->channels[c].name, a->name))
            b = &v->read->channels[c];
    if (!b || a->type != b->type || a->linear != b->linear)
        return differs(v, "channel %.256s is %s", a->name, b ? "of another type" : "missing");
    for (size_t i = 0; i < count; i++)
        if (stored_bits(a, i) != read_bits(b, i))
            return differs(v, "value (%zu, %zu) of channel %.256s is 0x%08x, not 0x%08x", i % width,
                           i / width, a->name, read_bits(b, i), stored_bits(a, i));
    report->verified += count;
    return WEFT_OK;
}

static enum weft_result compare(const struct verifier *v, struct weft_image_save_report *report)
{
    enum weft_result res = compare_frame(v);
    if (res == WEFT_OK)
        res = compare_attributes(v);
    if (res == WEFT_OK && v->given->channel_count != v->read->channel_count)
        res = differs(v, "it has %zu channels, not %zu", v->read->channel_count,
                      v->given->channel_count);
    for (size_t c = 0; res == WEFT_OK && c < v->given->channel_count; c++)
        res = compare_channel(v, &v->given->channels[c], report);
    return res;
}

// For images of any size that could be written: a slow machine still unpacks 10 MB a second.
static struct weft_limits limits_for(const struct weft_image *image)
{
    const uint64_t bytes =
        UINT64_C(4) * (uint64_t)image->width * (uint64_t)image->height * image->channel_count;
    return (struct weft_limits){
        .memory_bytes = (UINT64_C(4) << 30) + 3 * bytes,
        .output_bytes = (UINT64_C(4) << 30) + bytes,
        .cpu_seconds = 600 + (uint32_t)(bytes / 10000000),
        .wall_seconds = 600 + (uint32_t)(bytes / 10000000),
    };
}

// Of PNG and TIFF files the values, as they are stored.
static enum weft_result compare_values(const struct verifier *v, const void *values,
                                       struct weft_image_save_report *report)
{
    const struct weft_image *a = v->given, *b = v->read;
    char what[200];
    if (a->width != b->width || a->height != b->height || a->channel_count != b->channel_count ||
        a->channels[0].type != b->channels[0].type)
        return differs(v, "its size, its channels or their type are others");
    const enum weft_result res =
        weft_codes_compare(a, v->params->kind, v->params->log, values, what);
    if (res == WEFT_ERR_WRITE)
        return differs(v, "%s", what);
    report->verified += (uint64_t)a->width * (uint64_t)a->height * a->channel_count;
    return res;
}

static enum weft_result verify_codes(const struct verifier *v,
                                     const struct weft_image_load_params *load, int fd,
                                     struct weft_image *read, struct weft_image_save_report *report)
{
    struct weft_image_values values = {.values = NULL};
    enum weft_result res = weft_image_read_values(load, fd, v->params->kind, &values, read);
    res = res == WEFT_OK ? compare_values(v, values.values, report) : WEFT_ERR_WRITE;
    weft_payload_release(&values.payload);
    return res;
}

static enum weft_result verify_exr(const struct verifier *v,
                                   const struct weft_image_load_params *load, int fd,
                                   struct weft_image *read, struct weft_image_save_report *report)
{
    const enum weft_result res = weft_image_read(load, fd, read);
    return res == WEFT_OK ? compare(v, report) : WEFT_ERR_WRITE;
}

enum weft_result weft_image_verify(const struct weft_image *parts, size_t count, int fd,
                                   const struct weft_image_save_params *params,
                                   struct weft_image_save_report *report)
{
    enum weft_result res = WEFT_OK;
    for (size_t p = 0; res == WEFT_OK && p < count; p++) {
        struct weft_image read = {.name = ""};
        const struct verifier v = {&parts[p], &read, params};
        const struct weft_image_load_params load = {.path = params->path,
                                                    .part = (int)p,
                                                    .threads = params->threads,
                                                    .limits = limits_for(&parts[p]),
                                                    .log = params->log};
        res = params->kind == WEFT_IMAGE_FILE_EXR ? verify_exr(&v, &load, fd, &read, report)
                                                  : verify_codes(&v, &load, fd, &read, report);
        if (res == WEFT_OK && read.part_count != (int)count)
            res = differs(&v, "it has %d parts, not %zu", read.part_count, count);
        weft_image_clear(&read);
    }
    return res;
}
