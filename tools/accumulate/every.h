// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/every.h - the mean so far, while frames are still to come: with `--every
// SECONDS` so often, and whenever SIGUSR1 comes. All outputs that are asked for are written, each
// whole or not at all, in place of those of the last time. What fails is told as a warning: the run
// goes on.
#ifndef WEFT_TOOLS_ACCUMULATE_EVERY_H
#define WEFT_TOOLS_ACCUMULATE_EVERY_H

#include "tools/accumulate/job.h"

// --every's value: a number of seconds > 0, and outputs that can be replaced. Returns
// WEFT_ERR_ARGUMENT after an error line.
enum weft_result every_check(struct accumulate_job *job);
// From now on time counts.
void every_begin(struct accumulate_job *job);
// Whether the mean is to be written. Cheap; asked after each frame and while one is waited for.
bool every_is_due(const struct accumulate_job *job);
void every_write(struct accumulate_job *job);

#endif
