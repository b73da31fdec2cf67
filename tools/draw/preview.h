// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/preview.h - what verbs that write a picture share: its colours, range and file
// names.
#ifndef WEFT_TOOLS_DRAW_PREVIEW_H
#define WEFT_TOOLS_DRAW_PREVIEW_H

#include "tools/options/options.h"
#include "weft.h"

// What such a verb is asked for: files by their names, outputs that are not as NULL.
struct preview_options {
    const char *input, *output, *preview;
    const struct option_value *range, *colour_map;
    bool no_clobber;
};

// Colour map and range. *out is NULL where none is named. Returns WEFT_ERR_ARGUMENT after an error
// line, with the list of names for an unknown one.
enum weft_result preview_check(const struct preview_options *options,
                               const struct weft_colour_map **out);
// Whether the value is "help", and so the list of colour maps was printed.
bool preview_help(const struct option_value *colour_map);

// That outputs differ from each other and from the input, and with `writes` that they could be
// written. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_WRITE after an error line.
enum weft_result preview_check_outputs(const struct preview_options *options, bool writes);

// range[2] receives the values shown as first and last colour.
enum weft_result preview_save(const struct preview_options *options,
                              const struct weft_colour_map *colour_map, int32_t width,
                              int32_t height, const float *plane, float range[2]);

// The same of red, green and blue light, as sRGB. `threads` as struct weft_colour_preview_params.
enum weft_result preview_save_colour(const struct preview_options *options, int threads,
                                     int32_t width, int32_t height, const float *const plane[3],
                                     float range[2]);

#endif
