// SPDX-License-Identifier: BSD-3-Clause
// tools/plan_json/plan_check.h - whether passes compute what the tiles say: every tile of the set
// once, at one scale. Ranges are passes/plan/range.h's.
#ifndef WEFT_TOOLS_PLAN_JSON_PLAN_CHECK_H
#define WEFT_TOOLS_PLAN_JSON_PLAN_CHECK_H

#include "weft.h"

enum plan_fault_kind { PLAN_FAULT_NONE, PLAN_FAULT_TILE, PLAN_FAULT_SCALE, PLAN_FAULT_BIAS };

struct plan_fault {
    enum plan_fault_kind kind; // the first one, tiles by their number
    int tile;
    // How often the result has the tile (0: it is missing; -1: its sign is wrong), of its high and
    // its low part where the two differ the one that is not 1; where all tiles are there as often,
    // that; or the bias, 1 being full range.
    double times;
};

// Returns WEFT_ERR_FORMAT (weft_pass_list_check) or WEFT_ERR_MEMORY after an error line.
enum weft_result plan_check(const struct weft_pass_list *list, struct plan_fault *out);

#endif
