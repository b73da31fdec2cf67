// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/exr/lines.h"

#include <string.h>

// Words in the machine's order become little-endian.
static void order_bytes(unsigned char *data, size_t count, size_t size)
{
    const uint16_t one = 1;
    unsigned char low;
    memcpy(&low, &one, 1);
    for (size_t i = 0; !low && i < count; i++, data += size) {
        for (size_t k = 0; k < size / 2; k++) {
            const unsigned char byte = data[k];
            data[k] = data[size - 1 - k];
            data[size - 1 - k] = byte;
        }
    }
}

// Lines lie at multiples of two bytes, which halves may be stored at.
static unsigned char *put_line(const struct weft_image_channel *channel, size_t first, size_t width,
                               unsigned char *out, struct weft_half_losses *losses)
{
    const size_t size = channel->type == WEFT_PIXEL_HALF ? 2 : 4;
    if (channel->type == WEFT_PIXEL_HALF)
        weft_half_from_floats(channel->plane + first, width, (uint16_t *)(void *)out, losses);
    else if (channel->type == WEFT_PIXEL_UINT)
        memcpy(out, channel->integers + first, width * size);
    else
        memcpy(out, channel->plane + first, width * size);
    order_bytes(out, width, size);
    return out + width * size;
}

void weft_lines_gather(const struct weft_image_channel *const *channels, size_t channel_count,
                       const struct weft_lines *lines, unsigned char *out,
                       struct weft_half_losses *losses)
{
    for (size_t y = lines->y; y < lines->y + lines->count; y++)
        for (size_t c = 0; c < channel_count; c++)
            out = put_line(channels[c], y * lines->stride + lines->x, lines->width, out, losses);
}
