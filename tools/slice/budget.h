// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/budget.h - `weft slice --max-error`: which method, and why.
#ifndef WEFT_TOOLS_SLICE_BUDGET_H
#define WEFT_TOOLS_SLICE_BUDGET_H

#include "tools/common/json.h"
#include "tools/slice/job.h"

// The stage: measures the voxels in reach, chooses, and makes the chosen method's plans the job's.
// Nothing to do without --max-error. Returns WEFT_ERR_LIMIT, after an error line with what the best
// method's bound is, where none meets the budget.
enum weft_result slice_choose(struct slice_job *job);

json_t *slice_budget_json(const struct slice_job *job);
// The candidates as a table, and why the winner won.
void slice_budget_print(const struct slice_job *job);

#endif
