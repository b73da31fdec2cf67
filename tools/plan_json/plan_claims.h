// SPDX-License-Identifier: BSD-3-Clause
// tools/plan_json/plan_claims.h - whether all that a plan's file says of it is what the plan is.
#ifndef WEFT_TOOLS_PLAN_JSON_PLAN_CLAIMS_H
#define WEFT_TOOLS_PLAN_JSON_PLAN_CLAIMS_H

#include "tools/plan_json/plan_check.h"
#include "tools/plan_json/plan_json.h"

// Compares every member with plan_json of the plan that was made anew from the file's passes:
// errors, ranges, counts, costs. Reals may differ by 1e-9 of themselves, and search_seconds in any
// way. Returns WEFT_ERR_FORMAT after a line that names the first member that differs, and both
// values.
enum weft_result plan_claims_check(const char *file, const json_t *claims,
                                   const weft_pass_plan *plan);

// Judges a plan that was read by its profile, tiles and passes alone: fault, where passes do not
// compute the kernel, or else *plan, what it is, all of the file's claims being so. Of a plan that
// says it is valid and is not, claims are not compared. progress may be NULL. Returns
// WEFT_ERR_FORMAT, WEFT_ERR_LIMIT, WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED after an error line.
enum weft_result plan_claims_judge(const char *path, const struct plan_file *file,
                                   const struct weft_progress *progress, struct plan_fault *fault,
                                   weft_pass_plan **plan);

#endif
