// SPDX-License-Identifier: BSD-3-Clause
// tools/plan_json/plan_names.h - lists of tiles as users write them (weft_tile_name_parse).
#ifndef WEFT_TOOLS_PLAN_JSON_PLAN_NAMES_H
#define WEFT_TOOLS_PLAN_JSON_PLAN_NAMES_H

#include "weft.h"

// "1,0 1,2- 1,2-/1", separated by blanks or semicolons, and the same with "@T" behind each.
// *out is malloc'ed, never empty. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY after an error line.
enum weft_result plan_names_parse(const char *text, int dims, struct weft_tile_name **out,
                                  size_t *count);
enum weft_result plan_splits_parse(const char *text, int dims, struct weft_pass_plan_split **out,
                                   size_t *count);

#endif
