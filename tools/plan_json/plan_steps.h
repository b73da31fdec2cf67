// SPDX-License-Identifier: BSD-3-Clause
// tools/plan_json/plan_steps.h - tiles of a plan as users name them: "x,y[,z]" is a tap, counted
// from 0;
// "+" or "-" behind it is its part of one sign, "/N" a piece of a split tile.
#ifndef WEFT_TOOLS_PLAN_JSON_PLAN_STEPS_H
#define WEFT_TOOLS_PLAN_JSON_PLAN_STEPS_H

#include "weft.h"

enum { PLAN_STEP_TEXT = 64 };

// "1,0 1,2- 1,2-/1", separated by blanks or semicolons, and the same with "@T" behind each.
// *out is malloc'ed, never empty. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY after an error line.
enum weft_result plan_steps_parse(const char *text, int dims, struct weft_tile_name **out,
                                  size_t *count);
enum weft_result plan_splits_parse(const char *text, int dims, struct weft_pass_plan_split **out,
                                   size_t *count);

// "(1,2)-/1".
const char *plan_step_format(const struct weft_tile_name *step, int dims,
                             char text[PLAN_STEP_TEXT]);

// The steps of all tiles of a set, malloc'ed; NULL: no memory. Shortened ones are for messages: the
// part of a tap that has no other is WEFT_TILE_WHOLE.
struct weft_tile_name *plan_steps_of(const weft_kernel_tiles *tiles);
struct weft_tile_name *plan_steps_shortened(const weft_kernel_tiles *tiles);

#endif
