// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/attributes.h"

#include <string.h>

void attributes_of_texts(const struct weft_metadata *texts, size_t count,
                         struct weft_image_attribute *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (struct weft_image_attribute){.name = texts[i].key,
                                               .type = "string",
                                               .data = texts[i].value,
                                               .size = strlen(texts[i].value)};
}

static float load_float(const unsigned char *data)
{
    const uint32_t bits =
        data[0] | (uint32_t)data[1] << 8 | (uint32_t)data[2] << 16 | (uint32_t)data[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void store_float(float value, unsigned char out[4])
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++)
        out[i] = (unsigned char)(bits >> 8 * i);
}

static bool is_float(const struct weft_image_attribute *a, const char *name)
{
    return strcmp(a->name, name) == 0 && strcmp(a->type, "float") == 0 && a->size == 4;
}

// A value, scaled by a factor that is not 1, kept in `number`.
static void correct(struct weft_image_attribute *a, double factor, unsigned char number[4])
{
    if (factor == 1.0)
        return;
    store_float((float)(factor * (double)load_float(a->data)), number);
    a->data = number;
}

size_t attributes_scaled(const struct weft_image *image, const double scale[2],
                         struct weft_image_attribute *out, unsigned char numbers[2][4])
{
    static const unsigned char one[4] = {0, 0, 0x80, 0x3f};
    const double aspect = scale[1] / scale[0]; // a pixel is as wide as it was / scale[0]
    size_t count = 0;
    for (size_t i = 0; i < image->attribute_count; i++) {
        if (strncmp(image->attributes[i].name, "weft.", 5) == 0)
            continue;
        struct weft_image_attribute *a = &out[count++];
        *a = image->attributes[i];
        if (is_float(a, "pixelAspectRatio"))
            correct(a, aspect, numbers[0]);
        else if (is_float(a, "xDensity")) // pixels per inch
            correct(a, scale[0], numbers[1]);
    }
    if (!weft_image_find(image, "pixelAspectRatio")) {
        out[count] = (struct weft_image_attribute){"pixelAspectRatio", "float", one, 4};
        correct(&out[count++], aspect, numbers[0]);
    }
    return count;
}
