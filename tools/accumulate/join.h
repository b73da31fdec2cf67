// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/join.h - `weft accumulate A.state B.state -o OUT`: states in the place of
// frames. What they hold is added up, to the bytes of one run over their frames in that order; of
// one state the result is written as it stands. The states' arguments hold, and must be the same in
// all; options that decide what is accumulated cannot be given again. With --resume NEW the sums go
// into a state of their own.
#ifndef WEFT_TOOLS_ACCUMULATE_JOIN_H
#define WEFT_TOOLS_ACCUMULATE_JOIN_H

#include "tools/accumulate/job.h"

// Sets job->joins where the operands are states, and takes over their arguments and frames, of the
// first one what frames have in common, too. Returns WEFT_ERR_ARGUMENT (states and frames, an
// option of frames, frames that two states hold, or other arguments) or as state_file_read, after
// an error line.
enum weft_result join_open(struct accumulate_job *job);
// Adds up their sums, once there is an accumulator. Returns as weft_accumulator_load and
// weft_accumulator_join, after an error line.
enum weft_result join_take(struct accumulate_job *job);

void join_clear(struct accumulate_job *job);

#endif
