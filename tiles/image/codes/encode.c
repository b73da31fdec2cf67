// SPDX-License-Identifier: BSD-3-Clause
// A code is found by the first bits of a float, which lead to one near it, and the lights at which
// one code becomes the next: no powers are computed but for these.
#include "tiles/image/codes/encode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

enum {
    OCTAVES = 30,                    // below 1, that have buckets; smaller light is searched from 0
    BUCKET_BITS = 10,                // of a float's mantissa
    BUCKETS = OCTAVES << BUCKET_BITS // up to 1
};

struct weft_codes {
    const struct weft_image *image;
    struct weft_codes_shape shape;
    const struct weft_image_channel **order; // as they are written
    struct weft_transfer transfer;
    // Light from which on the code is i + 1, of `largest` + 1 of them: the last is the light that
    // has no code.
    float *threshold;
    float lowest;    // light below has none
    uint16_t *first; // code of each bucket's smallest light
    uint32_t largest;
};

// ---- channels -----------------------------------------------------------------------------------

static const struct weft_image_channel *channel_of(const struct weft_image *image,
                                                   enum weft_codes_role role)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (weft_codes_role(image->channels[c].name) == role)
            return &image->channels[c];
    return NULL;
}

// Red, green and blue, or grey, then alpha, then others; a single channel is grey by any name.
static enum weft_result order_channels(struct weft_codes *codes, enum weft_image_file_kind kind,
                                       const struct weft_log *log)
{
    const struct weft_image *image = codes->image;
    const struct weft_image_channel *rgb[] = {channel_of(image, WEFT_CODES_RED),
                                              channel_of(image, WEFT_CODES_GREEN),
                                              channel_of(image, WEFT_CODES_BLUE)};
    const struct weft_image_channel *grey = channel_of(image, WEFT_CODES_GREY),
                                    *alpha = channel_of(image, WEFT_CODES_ALPHA);
    struct weft_codes_shape *shape = &codes->shape;
    size_t at = 0;
    if (rgb[0] && rgb[1] && rgb[2]) {
        for (; at < 3; at++)
            codes->order[at] = rgb[at];
    } else if (grey || image->channel_count == 1) {
        codes->order[at++] = grey ? grey : &image->channels[0];
        alpha = image->channel_count == 1 ? NULL : alpha;
    }
    shape->colours = at;
    shape->alpha = at && alpha;
    if (shape->alpha)
        codes->order[at++] = alpha;
    for (size_t c = 0; at && c < image->channel_count; c++) {
        bool there = false;
        for (size_t i = 0; i < at; i++)
            there = there || codes->order[i] == &image->channels[c];
        if (there)
            continue;
        if (kind == WEFT_IMAGE_FILE_PNG) {
            weft_error(log,
                       "a PNG file has channels R, G, B and A, or Y and A, and no place for "
                       "channel %s",
                       image->channels[c].name);
            return WEFT_ERR_UNSUPPORTED;
        }
        codes->order[at++] = &image->channels[c];
    }
    shape->channels = at;
    if (at)
        return WEFT_OK;
    weft_error(log,
               "a %s file has channels R, G and B, or Y, or a single one: there are %zu, the first "
               "of them %s",
               weft_image_file_kind_names[kind], image->channel_count, image->channels[0].name);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result check_types(const struct weft_image *image, enum weft_image_file_kind kind,
                                    const struct weft_log *log)
{
    const enum weft_pixel_type type = image->channels[0].type;
    for (size_t c = 1; c < image->channel_count; c++) {
        if (image->channels[c].type == type)
            continue;
        weft_error(log, "channels of a %s file have one type: %s is %s, %s is %s",
                   weft_image_file_kind_names[kind], image->channels[0].name,
                   weft_pixel_type_names[type], image->channels[c].name,
                   weft_pixel_type_names[image->channels[c].type]);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (kind == WEFT_IMAGE_FILE_TIFF || weft_codes_is_integer(type))
        return WEFT_OK;
    weft_error(log, "a PNG file has channels of unorm8 or unorm16, not of %s",
               weft_pixel_type_names[type]);
    return WEFT_ERR_UNSUPPORTED;
}

// ---- tables -------------------------------------------------------------------------------------

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

// Of light from 0 to 1; what is below all buckets has the first one.
static size_t bucket_of(float light)
{
    const uint32_t base = (uint32_t)(127 - OCTAVES) << BUCKET_BITS;
    const uint32_t at = bits_of(light) >> (23 - BUCKET_BITS);
    return at > base ? at - base : 0;
}

static bool fill_tables(struct weft_codes *codes)
{
    const uint32_t largest = codes->largest = weft_codes_largest(codes->shape.type);
    codes->transfer = codes->image->transfer;
    if (codes->transfer.curve == WEFT_CURVE_AUTO)
        codes->transfer.curve = WEFT_CURVE_SRGB;
    codes->threshold = malloc((largest + 1) * sizeof *codes->threshold);
    codes->first = malloc((BUCKETS + 1) * sizeof *codes->first);
    if (!codes->threshold || !codes->first)
        return false;
    for (uint32_t i = 0; i <= largest; i++)
        codes->threshold[i] = (float)weft_transfer_light(&codes->transfer, (i + 0.5) / largest);
    codes->lowest = (float)weft_transfer_light(&codes->transfer, -0.5 / largest);
    uint32_t code = 0;
    for (uint32_t b = 0; b <= BUCKETS; b++) {
        const uint32_t bits = (((uint32_t)(127 - OCTAVES) << BUCKET_BITS) + b)
                              << (23 - BUCKET_BITS);
        float light;
        memcpy(&light, &bits, sizeof light);
        while (code < largest && light >= codes->threshold[code])
            code++;
        codes->first[b] = (uint16_t)(b ? code : 0);
    }
    return true;
}

static inline uint32_t code_of(const struct weft_codes *codes, float light, uint64_t *clamped)
{
    if (!(light > 0.0f)) {
        *clamped += !(light >= codes->lowest);
        return 0;
    }
    if (light >= 1.0f) {
        *clamped += light >= codes->threshold[codes->largest];
        return codes->largest;
    }
    uint32_t code = codes->first[bucket_of(light)];
    while (code < codes->largest && light >= codes->threshold[code])
        code++;
    return code;
}

static inline uint32_t linear_code(const struct weft_codes *codes, float value, uint64_t *clamped)
{
    const double code = rint((double)value * codes->largest);
    if (code >= 0.0 && code <= (double)codes->largest)
        return (uint32_t)code;
    ++*clamped;
    return code > 0.0 ? codes->largest : 0;
}

// ---- rows ---------------------------------------------------------------------------------------

static void put_code(const struct weft_codes *codes, char *out, uint32_t code)
{
    const uint16_t word = (uint16_t)code;
    if (codes->shape.value_bytes == 1)
        *out = (char)code;
    else
        memcpy(out, &word, sizeof word);
}

// A colour that the file has multiplied by alpha after it was coded.
static uint32_t associated_code(const struct weft_codes *codes, float light, float alpha,
                                uint64_t *clamped)
{
    const double a = (double)alpha;
    const double code = weft_transfer_code(&codes->transfer, (double)light / a);
    return linear_code(codes, (float)(a * code), clamped);
}

// Colours are divided by alpha where the file does not multiply them.
static void put_codes(const struct weft_codes *codes, const float *values, const float *alpha,
                      bool colour, char *out, uint64_t *clamped)
{
    const size_t step = codes->shape.channels * codes->shape.value_bytes;
    for (int32_t x = 0; x < codes->image->width; x++, out += step) {
        const float a = alpha && alpha[x] > 0.0f ? alpha[x] : 1.0f;
        put_code(codes, out,
                 !colour                   ? linear_code(codes, values[x], clamped)
                 : !alpha                  ? code_of(codes, values[x], clamped)
                 : codes->shape.associated ? associated_code(codes, values[x], a, clamped)
                                           : code_of(codes, values[x] / a, clamped));
    }
}

static void put_values(const struct weft_codes *codes, const struct weft_image_channel *channel,
                       size_t first, char *out, float *scratch, struct weft_codes_losses *losses)
{
    const size_t width = (size_t)codes->image->width, bytes = codes->shape.value_bytes;
    const size_t step = codes->shape.channels * bytes;
    const char *values = (const char *)(channel->plane + first);
    if (codes->shape.type == WEFT_PIXEL_UINT)
        values = (const char *)(channel->integers + first);
    if (codes->shape.type == WEFT_PIXEL_HALF) {
        weft_half_from_floats(channel->plane + first, width, (uint16_t *)(void *)scratch,
                              &losses->halves);
        values = (const char *)scratch;
    }
    for (size_t x = 0; x < width; x++, out += step, values += bytes)
        memcpy(out, values, bytes);
}

void weft_codes_row(const weft_codes *codes, int32_t y, void *out, float *scratch,
                    struct weft_codes_losses *losses)
{
    const struct weft_codes_shape *shape = &codes->shape;
    const size_t first = (size_t)y * (size_t)codes->image->width;
    const float *alpha = shape->alpha ? codes->order[shape->colours]->plane + first : NULL;
    for (size_t c = 0; c < shape->channels; c++) {
        char *to = (char *)out + c * shape->value_bytes;
        if (weft_codes_is_integer(shape->type))
            put_codes(codes, codes->order[c]->plane + first, alpha, c < shape->colours, to,
                      &losses->clamped);
        else
            put_values(codes, codes->order[c], first, to, scratch, losses);
    }
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result weft_codes_create(const struct weft_image *image, enum weft_image_file_kind kind,
                                   const struct weft_log *log, weft_codes **out)
{
    static const uint8_t bytes[] = {[WEFT_PIXEL_FLOAT] = 4,
                                    [WEFT_PIXEL_HALF] = 2,
                                    [WEFT_PIXEL_UINT] = 4,
                                    [WEFT_PIXEL_UNORM8] = 1,
                                    [WEFT_PIXEL_UNORM16] = 2};
    *out = NULL;
    enum weft_result res = check_types(image, kind, log);
    if (res != WEFT_OK)
        return res;
    struct weft_codes *codes = calloc(1, sizeof *codes);
    if (codes) {
        codes->image = image;
        codes->order = calloc(image->channel_count, sizeof *codes->order);
    }
    if (!codes || !codes->order)
        goto memory;
    res = order_channels(codes, kind, log);
    if (res != WEFT_OK)
        goto fail;
    struct weft_codes_shape *shape = &codes->shape;
    shape->type = image->channels[0].type;
    shape->associated = shape->alpha && kind == WEFT_IMAGE_FILE_TIFF &&
                        (image->codes.associated || !weft_codes_is_integer(shape->type));
    shape->value_bytes = bytes[shape->type];
    shape->row_bytes = shape->channels * shape->value_bytes * (size_t)image->width;
    if (weft_codes_is_integer(shape->type) && !fill_tables(codes))
        goto memory;
    *out = codes;
    return WEFT_OK;
memory:
    weft_error(log, "out of memory for the codes of %zu channels", image->channel_count);
    res = WEFT_ERR_MEMORY;
fail:
    weft_codes_destroy(&codes);
    return res;
}

void weft_codes_destroy(weft_codes **codes)
{
    if (!*codes)
        return;
    free((*codes)->order);
    free((*codes)->threshold);
    free((*codes)->first);
    free(*codes);
    *codes = NULL;
}

const struct weft_codes_shape *weft_codes_shape(const weft_codes *codes)
{
    return &codes->shape;
}
