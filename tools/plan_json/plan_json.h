// SPDX-License-Identifier: BSD-3-Clause
// tools/plan_json/plan_json.h - plans as JSON: what `weft plan --json` prints and `weft validate`
// reads.
#ifndef WEFT_TOOLS_PLAN_JSON_PLAN_JSON_H
#define WEFT_TOOLS_PLAN_JSON_PLAN_JSON_H

#include "tools/common/json.h"
#include "weft.h"

// Everything of a plan; NULL: no memory.
json_t *plan_json(const weft_pass_plan *plan);

// Reads a file, or standard input for "-"; *out is a new reference. Returns WEFT_ERR_OPEN,
// WEFT_ERR_FORMAT, WEFT_ERR_LIMIT (64 MiB of text, or memory_bytes of values), WEFT_ERR_MEMORY or
// WEFT_ERR_CANCELLED after an error line.
enum weft_result plan_json_load(const char *path, uint64_t memory_bytes, json_t **out);

// Positions are as many numbers as there are dimensions.
json_t *plan_range_json(const struct weft_range *range, int dims);
json_t *plan_integers_json(const int *value, int count);

// A plan that was read: what is needed to check it.
struct plan_file {
    json_t *root;                        // all that it says
    struct weft_pass_plan_params params; // for weft_pass_plan_judge; splits are owned
    struct weft_pass_plan_split *splits;
    weft_kernel_tiles *tiles;
    struct weft_profile profile;
    enum weft_worst_case worst_case;
    struct weft_pass_list list; // points into what follows
    struct weft_tap_group *groups;
    struct weft_pass *passes;
    uint32_t *log_table;
};

// Nothing in the file is trusted: sizes and ranges are checked before anything is allocated or
// computed, and tiles take at most memory_bytes (0: 1 GiB). Returns what plan_json_load does, with
// WEFT_ERR_FORMAT for what is wrong in the plan, and where.
enum weft_result plan_file_load(const char *path, uint64_t memory_bytes, struct plan_file *out);
void plan_file_clear(struct plan_file *file); // {0} is fine

#endif
