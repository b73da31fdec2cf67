// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "filter/check.h"

const char *const weft_pixel_type_names[] = {"float", "half", "uint", "unorm8", "unorm16", NULL};
const char *const weft_image_file_kind_names[] = {"EXR", "PNG", "TIFF", NULL};
const char *const weft_image_compression_names[] = {"zip", "zips", "rle",  "none", "piz", "pxr24",
                                                    "b44", "b44a", "dwaa", "dwab", "lzw", NULL};

bool weft_image_is_writable(enum weft_image_compression compression)
{
    return (unsigned)compression <= WEFT_IMAGE_PIZ;
}

bool weft_image_file_kind_find(const char *path, enum weft_image_file_kind *out)
{
    static const struct {
        const char *ending;
        enum weft_image_file_kind kind;
    } endings[] = {{".exr", WEFT_IMAGE_FILE_EXR},
                   {".png", WEFT_IMAGE_FILE_PNG},
                   {".tif", WEFT_IMAGE_FILE_TIFF},
                   {".tiff", WEFT_IMAGE_FILE_TIFF}};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < WEFT_COUNT(endings); i++) {
        if (strcasecmp(dot, endings[i].ending))
            continue;
        *out = endings[i].kind;
        return true;
    }
    return false;
}

int weft_image_level_count(int32_t width, int32_t height)
{
    int count = 1;
    for (int32_t size = width > height ? width : height; size > 1; size /= 2)
        count++;
    return count;
}

int32_t weft_image_level_size(int32_t size, int level)
{
    const int32_t smaller = level < 31 ? size >> level : 0;
    return smaller > 1 ? smaller : 1;
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
