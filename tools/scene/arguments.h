// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/arguments.h - numbers in what a user writes: behind a scene's name, in keyframes.
#ifndef WEFT_TOOLS_SCENE_ARGUMENTS_H
#define WEFT_TOOLS_SCENE_ARGUMENTS_H

#include "weft.h"

// Reads one finite decimal number and goes on to what follows it. false: there is none.
bool scene_read_number(const char **at, double *out);

// One of the numbers that stand behind a scene's name, with commas between them.
struct scene_argument {
    const char *name;          // "polygons"
    double least, most, value; // value: the default before, then what was read
    bool whole;                // it has no fraction
};
// Reads up to `count` numbers; those that are not there keep their values. NULL: none is there.
// Returns WEFT_ERR_ARGUMENT after a line that says what is wrong, and the range.
enum weft_result scene_read_arguments(const struct weft_log *log, const char *scene,
                                      const char *text, int count, struct scene_argument *argument);

#endif
