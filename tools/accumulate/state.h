// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/state.h - `--resume STATE`: what was accumulated, in a file that a later run
// goes on from. It is saved now and then, at the end, and whole or not at all: whatever ends the
// run, the file has the frames of the last time it was saved.
//
// A run goes on where all that decides its result is as it was: the arguments, weft's version, and
// of each frame that the state holds the name, size, time of change and weight. Frames may have
// been added since, for exact sums anywhere behind the first one, for other methods behind the last
// one. A frame that was left out as unreadable is looked at again where it has changed and order
// does not matter. The results' files, types and looks, --until, --skip-bad, --threads and --every
// may be other ones: they decide nothing of what was accumulated.
#ifndef WEFT_TOOLS_ACCUMULATE_STATE_H
#define WEFT_TOOLS_ACCUMULATE_STATE_H

#include "tools/accumulate/job.h"

// The state is saved when so many times the seconds that this takes have passed since the last
// time: about 2 % of the run.
enum { STATE_PATIENCE = 50 };

// Reads STATE where it exists, and marks the frames that it holds as done. Returns
// WEFT_ERR_ARGUMENT (other frames or weights), WEFT_ERR_OPEN (a frame is gone or has changed) or as
// state_file_read, after an error line.
enum weft_result state_open(struct accumulate_job *job);
// Takes over what it holds, once there is an accumulator: job->next is then the first frame that it
// does not hold. Returns WEFT_ERR_ARGUMENT (other
// arguments) or as weft_accumulator_load, after an error line.
enum weft_result state_take(struct accumulate_job *job);

// Seconds after which it is due again.
double state_patience(const struct accumulate_job *job);
// Saves it where that is due, after a frame. Where it cannot be written a warning says so, once,
// and the run goes on.
void state_save_now_and_then(struct accumulate_job *job);
// Saves it at the end, where it does not hold all yet. Returns as state_file_write.
enum weft_result state_save(struct accumulate_job *job);

// Keeps the bytes of the first frame's file, which a state is saved with. Returns WEFT_ERR_MEMORY.
enum weft_result state_take_first(struct accumulate_job *job, const struct weft_bytes *first);

// What is said if a signal comes: how many frames were looked at, and how many of them the state
// holds.
void state_set_last_words(const struct accumulate_job *job);

void state_clear(struct accumulate_job *job);

#endif
