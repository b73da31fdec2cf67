// SPDX-License-Identifier: BSD-3-Clause
// tools/options/saved.h - how verbs write image files, and what became of the values.
#ifndef WEFT_TOOLS_OPTIONS_SAVED_H
#define WEFT_TOOLS_OPTIONS_SAVED_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "weft.h"

// --type, of the first `count` of weft_pixel_type_names, and --compression.
#define SAVED_TYPE_OPTION(help, count)                                                             \
    {                                                                                              \
        .name = "type", 0, OPTION_CHOICE, NULL, help, weft_pixel_type_names, count,                \
        .group = OPTION_FILES                                                                      \
    }
#define SAVED_COMPRESSION_OPTION(help)                                                             \
    {                                                                                              \
        .name = "compression", 0, OPTION_CHOICE, NULL, help, weft_image_compression_names,         \
        WEFT_IMAGE_PIZ + 1, .group = OPTION_FILES                                                  \
    }

// Writes an image of one part, as TIFF where the name ends so and else as EXR, with progress, and warns as saved_warn does.
enum weft_result saved_write(const struct weft_image *image, const char *path, bool no_clobber,
                             int threads, struct weft_image_save_report *saved);

// What is wrong with --compression for an output, NULL: nothing. TIFF has not all of EXR's.
const char *saved_conflict(const struct option_value *compression,
                           const struct option_value *output);

json_t *saved_json(const struct weft_image_save_report *saved);
// With --verify: a line on stdout of what was read back; otherwise nothing.
void saved_print(const char *path, const struct weft_image_save_report *saved);
// A warning where values are beyond what halves hold, and one where they have no code.
void saved_warn(const char *path, const struct weft_image_save_report *saved);

#endif
