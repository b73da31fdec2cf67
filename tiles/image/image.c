// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image.h"

#include <stdlib.h>

const char *const weft_pixel_type_names[] = {"float", "half", "uint", NULL};
const char *const weft_image_compression_names[] = {"zip", "zips", "rle",  "none", "piz", "pxr24",
                                                    "b44", "b44a", "dwaa", "dwab", NULL};

bool weft_image_is_writable(enum weft_image_compression compression)
{
    return (unsigned)compression <= WEFT_IMAGE_PIZ;
}

void weft_image_clear(struct weft_image *image)
{
    if (!image)
        return;
    for (size_t c = 0; c < image->channel_count; c++) {
        free(image->channels[c].plane);
        free(image->channels[c].integers);
    }
    free(image->channels);
    free(image->attributes);
    *image = (struct weft_image){0};
}

void weft_image_list_clear(struct weft_image_list *list)
{
    if (!list)
        return;
    for (size_t p = 0; p < list->count; p++)
        weft_image_clear(&list->images[p]);
    free(list->images);
    *list = (struct weft_image_list){0};
}
