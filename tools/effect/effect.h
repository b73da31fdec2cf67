// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/effect.h - the effects that accumulation makes (Haeberli and Akeley, "The
// Accumulation Buffer", SIGGRAPH 1990; Keller, "Instant Radiosity", SIGGRAPH 1997), by name. What
// their frames show is planned in plan.h, and drawn in run.h.
#ifndef WEFT_TOOLS_EFFECT_EFFECT_H
#define WEFT_TOOLS_EFFECT_EFFECT_H

#include "weft.h"

// What is asked for, to be added up with |.
enum effect_bit {
    EFFECT_FADE = 1,
    EFFECT_MOTION_BLUR = 2,
    EFFECT_ANTIALIAS = 4,
    EFFECT_DOF = 8,
    EFFECT_SOFT_SHADOW = 16,
    EFFECT_RADIOSITY = 32,
    EFFECT_COUNT = 6
};
extern const char *const effect_names[]; // "fade", "motion-blur", "antialias", "dof",
                                         // "soft-shadow", "radiosity"; NULL-ended, in bits' order

// Reads "antialias+dof" as bits. On failure *out is 0. Returns WEFT_ERR_ARGUMENT after a line: a
// name that there is not, with the list; one that is there twice; soft-shadow
// with radiosity, whose lights lie all over the lamps already.
enum weft_result effect_parse(const struct weft_log *log, const char *text, unsigned *out);

#endif
