// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/codes/decode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/plane.h"

enum { BAND = 16 }; // rows that a thread takes at a time

enum weft_codes_role weft_codes_role(const char *name)
{
    static const char *const names[] = {
        [WEFT_CODES_RED] = "R",  [WEFT_CODES_GREEN] = "G", [WEFT_CODES_BLUE] = "B",
        [WEFT_CODES_GREY] = "Y", [WEFT_CODES_ALPHA] = "A",
    };
    const char *dot = strrchr(name, '.'), *last = dot ? dot + 1 : name;
    for (unsigned i = 0; i < WEFT_COUNT(names); i++)
        if (!strcmp(last, names[i]))
            return (enum weft_codes_role)i;
    return WEFT_CODES_OTHER;
}

bool weft_codes_is_integer(enum weft_pixel_type type)
{
    return type == WEFT_PIXEL_UNORM8 || type == WEFT_PIXEL_UNORM16;
}

uint32_t weft_codes_largest(enum weft_pixel_type type)
{
    return type == WEFT_PIXEL_UNORM8 ? 255 : 65535;
}

struct decoder {
    struct weft_image *image;
    const char *values;
    enum weft_pixel_type type;
    enum weft_plane_type plane_type;
    size_t value_bytes;
    size_t alpha; // the channel; channel_count: none
    float *light; // of each code; NULL where values are no codes
    bool associates;
};

static bool is_colour(const struct decoder *d, size_t channel)
{
    return weft_codes_role(d->image->channels[channel].name) < WEFT_CODES_ALPHA;
}

// By the curve: colours that a file has multiplied were coded before, or after; as OpenEXR files
// have them, the colour that is multiplied is the coded one.
static void decode_associated(const struct decoder *d, const float *alpha, float *out)
{
    for (int32_t x = 0; x < d->image->width; x++) {
        const double a = alpha[x] > 0.0f ? (double)alpha[x] : 1.0;
        out[x] = (float)(a * weft_transfer_light(&d->image->transfer, (double)out[x] / a));
    }
}

static void decode_codes(const struct decoder *d, const struct weft_plane *plane, float *out)
{
    const size_t width = (size_t)d->image->width, step = plane->step;
    const uint8_t *bytes = plane->values;
    const uint16_t *words = plane->values;
    for (size_t x = 0; x < width && d->type == WEFT_PIXEL_UNORM8; x++)
        out[x] = d->light[bytes[x * step]];
    for (size_t x = 0; x < width && d->type == WEFT_PIXEL_UNORM16; x++)
        out[x] = d->light[words[x * step]];
}

static void decode_channel(const struct decoder *d, const struct weft_plane *plane, size_t c,
                           const float *alpha, float *out)
{
    const struct weft_image *image = d->image;
    const bool colour = is_colour(d, c), coded = colour && d->light;
    if (coded && !(alpha && image->codes.associated))
        decode_codes(d, plane, out);
    else
        weft_plane_row(plane, 0, image->width, out, 1);
    if (coded && alpha && image->codes.associated)
        decode_associated(d, alpha, out);
    for (int32_t x = 0; colour && alpha && d->associates && x < image->width; x++)
        out[x] *= alpha[x];
}

static void decode_row(const struct decoder *d, int32_t row)
{
    struct weft_image *image = d->image;
    const size_t width = (size_t)image->width, count = image->channel_count;
    const char *line =
        d->values + (size_t)(image->first_row + row) * width * count * d->value_bytes;
    const float *alpha =
        d->alpha < count ? image->channels[d->alpha].plane + (size_t)row * width : NULL;
    for (size_t i = 0; i < count; i++) {
        // Alpha first.
        const size_t c = d->alpha == count ? i : i == 0 ? d->alpha : i <= d->alpha ? i - 1 : i;
        struct weft_image_channel *channel = &image->channels[c];
        const struct weft_plane plane = {.values = line + c * d->value_bytes,
                                         .type = d->plane_type,
                                         .stride = width * count,
                                         .step = count};
        decode_channel(d, &plane, c, alpha, channel->plane + (size_t)row * width);
        const uint32_t *integers = plane.values;
        for (size_t x = 0; channel->integers && x < width; x++)
            channel->integers[(size_t)row * width + x] = integers[x * count];
    }
}

static bool decode_band(void *priv, int thread, size_t band)
{
    const struct decoder *d = priv;
    const int32_t first = (int32_t)band * BAND, left = d->image->rows - first;
    (void)thread;
    for (int32_t i = 0; i < (left < BAND ? left : BAND); i++)
        decode_row(d, first + i);
    return true;
}

static bool fill_table(struct decoder *d)
{
    const uint32_t largest = weft_codes_largest(d->type);
    if (!weft_codes_is_integer(d->type))
        return true;
    d->light = malloc((largest + 1) * sizeof *d->light);
    for (uint32_t i = 0; d->light && i <= largest; i++)
        d->light[i] = (float)weft_transfer_light(&d->image->transfer, (double)i / largest);
    return d->light != NULL;
}

enum weft_result weft_codes_decode(const void *values, int threads, struct weft_image *image)
{
    static const enum weft_plane_type types[] = {
        [WEFT_PIXEL_FLOAT] = WEFT_PLANE_FLOAT,     [WEFT_PIXEL_HALF] = WEFT_PLANE_HALF,
        [WEFT_PIXEL_UINT] = WEFT_PLANE_UINT,       [WEFT_PIXEL_UNORM8] = WEFT_PLANE_UNORM8,
        [WEFT_PIXEL_UNORM16] = WEFT_PLANE_UNORM16,
    };
    struct decoder d = {.image = image, .values = values, .type = image->channels[0].type};
    d.plane_type = types[d.type];
    d.value_bytes = weft_plane_type_size(d.plane_type);
    d.associates = !image->codes.associated && d.type != WEFT_PIXEL_UINT;
    while (d.alpha < image->channel_count &&
           weft_codes_role(image->channels[d.alpha].name) != WEFT_CODES_ALPHA)
        d.alpha++;
    if (!fill_table(&d))
        return WEFT_ERR_MEMORY;
    const size_t bands = ((size_t)image->rows - 1) / BAND + 1;
    weft_threads_run(bands > 4 ? threads : 1, bands, decode_band, &d);
    free(d.light);
    return WEFT_OK;
}
