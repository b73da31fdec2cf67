// SPDX-License-Identifier: BSD-3-Clause
// tiles/image.h - EXR images as planes of float, and PNG previews.
// Pixel (x, y) of the data window is centred at (x + 0.5, y + 0.5), row 0 on top. Planes are
// [y][x], x fastest, tightly packed.
#ifndef WEFT_TILES_IMAGE_H
#define WEFT_TILES_IMAGE_H

#include <math.h>

#include "../filter/base.h"
#include "../tiles/limits.h"
#include "../tiles/volume.h" // struct weft_metadata

WEFT_BEGIN_DECLS

struct weft_image_channel {
    char name[256]; // "R", "left.Z", ... any EXR channel name
    char type[8];   // as stored: "half", "float", "uint"
    float *plane;   // width * height; NULL in an image that only informs
};

struct weft_image {
    int32_t x, y; // first pixel of the data window, may be negative
    int32_t width, height;
    int32_t display_min[2],
        display_max[2];   // display window, inclusive (to save: all 0 = data window)
    char compression[16]; // as stored: "none", "rle", "zips", "zip", "piz", ...
    bool tiled;
    size_t channel_count;
    struct weft_image_channel *channels; // in the file's order
    size_t metadata_count;
    struct weft_metadata *metadata; // attributes of known types as text
};

struct weft_image_load_params {
    const char *path;
    bool info_only; // header only: planes stay NULL
    struct weft_limits limits;
    const struct weft_log *log;
};

// Reads a flat scanline or tiled image (level 0 of the first part) through weft-read-exr; half and
// uint become float (uint above 2^24 is rounded). DWAA and DWAB are unsupported. Ownership: clear
// it with weft_image_clear. Returns WEFT_ERR_OPEN, _FORMAT, _UNSUPPORTED (deep, subsampled
// channels), _LIMIT, _READER.
WEFT_API enum weft_result weft_image_load(const struct weft_image_load_params *params,
                                          struct weft_image *out);
WEFT_API void weft_image_clear(struct weft_image *image);

struct weft_image_save_params {
    const char *path;
    bool no_clobber; // an existing file is an error
    const struct weft_log *log;
};

// Writes float channels, ZIP compressed, with each metadata entry as a string attribute (except
// names that the format reserves, as "compression"); to a temporary file in the same folder, then
// renamed. Channel names must differ. Devices and pipes are written directly.
// Returns WEFT_ERR_ARGUMENT, _MEMORY, _WRITE.
WEFT_API enum weft_result weft_image_save(const struct weft_image *image,
                                          const struct weft_image_save_params *params);

// Colour maps for previews, a NULL-ended list: "grey" (the first), "viridis" (perceptually uniform)
// and "cool-warm" (diverging).
struct weft_colour_map {
    const char *name;
    const char *citation;
    // sRGB in [0, 255] at t in [0, 1].
    void (*colour)(double t, uint8_t rgb[3]);
};
WEFT_API extern const struct weft_colour_map *const weft_colour_map_list[];
WEFT_API const struct weft_colour_map *weft_colour_map_find(const char *name);

struct weft_preview_params {
    const char *path; // required
    bool no_clobber;
    int32_t width, height; // required
    const float *plane;    // required; width * height
    // Values shown as first and last colour. NAN, or both 0: the finite minimum, maximum.
    float low, high;
    const struct weft_colour_map *colour_map; // default grey
    const struct weft_log *log;
};
#define weft_preview_params(...) (&(struct weft_preview_params){__VA_ARGS__})

// Writes an 8-bit PNG (grey or RGB); NaN is shown as magenta in colour maps, as black in grey.
// Values beyond the range take its end colours; a range of no width shows its value in the middle
// colour. low > high reverses the colours. Without a finite value the range is 0 to 1.
// range[2], if not NULL, receives the values shown as first and last colour.
// Returns WEFT_ERR_ARGUMENT, _MEMORY, _WRITE.
WEFT_API enum weft_result weft_preview_save(const struct weft_preview_params *params,
                                            float range[2]);

WEFT_END_DECLS
#endif
