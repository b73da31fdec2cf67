// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/report.h - what slices tell: attributes, JSON, text.
#ifndef WEFT_TOOLS_SLICE_REPORT_H
#define WEFT_TOOLS_SLICE_REPORT_H

#include "tools/common/run_report.h"
#include "tools/slice/job.h"

// Unless the slice is plain, what is computed of the source whose turn it is: for its JSON.
void slice_tell_source(struct slice_job *job);
// What the slice's plan and run tell: its attributes, and with --json its JSON, but for what saving
// adds.
void slice_tell(struct slice_job *job);
// The attributes alone; of slices that are not made in passes, also before they are run.
void slice_list_attributes(struct slice_job *job);
// Adds what is known once it is saved.
void slice_tell_saved(struct slice_job *job);

// What was asked for in words: plan (with --explain), preview range, verification.
void slice_print_explained(const struct slice_job *job);
void slice_print_made(const struct slice_job *job);

// Whether the error is within the plan's bound, if that was asked for; else after an error line.
bool slice_is_verified(const struct slice_job *job);

// What its stages took.
void slice_stages(const struct slice_job *job, struct run_stage out[SLICE_STAGES]);

#endif
