// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/preview.h - what verbs that write a picture share: its colours, range and file
// names.
#ifndef WEFT_TOOLS_DRAW_PREVIEW_H
#define WEFT_TOOLS_DRAW_PREVIEW_H

#include "tools/draw/annotation.h"
#include "tools/options/options.h"
#include "weft.h"

// What such a verb is asked for: files by their names, outputs that are not as NULL.
struct preview_options {
    const char *input, *output, *preview;
    const char *error_image; // as preview_check_outputs looks at it
    const struct option_value *range, *colour_map;
    const struct option_value *exposure;         // NULL: the verb has none
    const struct option_value *annotate, *title; // NULL: it has neither
    const struct annotation *annotation;         // what --annotate shows, but for the legend
    bool no_clobber;
};

// For the verbs' tables.
// clang-format off
#define PREVIEW_EXPOSURE_OPTION                                                                    \
    {.name = "exposure", 0, OPTION_NUMBER, "STOPS",                                                \
     "show light in the preview so many stops brighter, times 2^STOPS (default 0)",                \
     .group = OPTION_PICTURES}
#define PREVIEW_ANNOTATE_OPTION                                                                    \
    {.name = "annotate", 0, OPTION_FLAG, NULL,                                                     \
     "put a title, what lies along the edges, and a legend around the preview",                    \
     .group = OPTION_PICTURES}
#define PREVIEW_TITLE_OPTION                                                                       \
    {.name = "title", 0, OPTION_TEXT, "TEXT",                                                      \
     "with --annotate: the title (default: what the picture is of)", .group = OPTION_PICTURES}
// clang-format on

// What contradicts what among them, as an error line; NULL: nothing. given: a preview is asked for.
const char *preview_conflict(const struct preview_options *options, bool given);
// Whether the picture is asked for as light, which grey is, too, then.
bool preview_shows_light(const struct preview_options *options);

// An annotation with a title, that of --title where it is given, and a caption. Returns whether one
// is asked for.
bool preview_annotate(const struct preview_options *options, const char *title, const char *caption,
                      struct annotation *out);

// Colour map, range and exposure, and with --annotate that there is a font. *out is NULL where no
// map is named. Returns WEFT_ERR_ARGUMENT after an error line, with the list of names for an
// unknown one, and what text_font_create returns.
enum weft_result preview_check(const struct preview_options *options,
                               const struct weft_colour_map **out);
// Whether the value is "help", and so the list of colour maps was printed.
bool preview_help(const struct option_value *colour_map);

// That all three outputs differ from each other and from the input, and with `writes` that they
// could be written. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_WRITE after an error line.
enum weft_result preview_check_outputs(const struct preview_options *options, bool writes);

// range[2] receives the values shown as first and last colour.
enum weft_result preview_save(const struct preview_options *options,
                              const struct weft_colour_map *colour_map, int32_t width,
                              int32_t height, const float *plane, float range[2]);

// The same of red, green and blue light, as sRGB, from 0 to 2^-exposure where there is no range.
// `threads` as struct weft_colour_preview_params.
enum weft_result preview_save_colour(const struct preview_options *options, int threads,
                                     int32_t width, int32_t height, const float *const plane[3],
                                     float range[2]);

#endif
