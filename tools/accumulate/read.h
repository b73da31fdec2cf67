// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/read.h - what reading frames one after another (read.c) and on several ranks
// (divided.c) share.
#ifndef WEFT_TOOLS_ACCUMULATE_READ_H
#define WEFT_TOOLS_ACCUMULATE_READ_H

#include "tools/accumulate/job.h"

// Frames of a sequence of so many, by `name`, which gets the job; `stop` may be NULL.
enum weft_result read_open(struct accumulate_job *job, int64_t count,
                           const char *(*name)(void *priv, int64_t i), bool (*stop)(void *priv),
                           weft_image_sequence **out);

// Adds a frame that was read, and takes over its types. Returns what it was read with, or why it is
// not taken, after an error line.
enum weft_result read_add(struct accumulate_job *job, const struct weft_image_frame *frame,
                          double weight);
// Whether a frame is left out with --skip-bad, as others may do better.
bool read_is_bad(enum weft_result res);
// The next frame of the sequence was added, or is left out for what the error line says.
enum weft_result read_count(struct accumulate_job *job, const struct state_stamp *stamp);
enum weft_result read_skip(struct accumulate_job *job, const struct state_stamp *stamp);

// How far it is, as progress and last words. False once an interrupt has come.
bool read_tell(struct accumulate_job *job);
// The number of frames at which --until is judged next.
int64_t read_next_judged(const struct accumulate_job *job);
// Judges where that is due; sets job->stopped.
enum weft_result read_judge(struct accumulate_job *job);
// What an earlier run has added is taken for read; it may be enough.
enum weft_result read_go_on(struct accumulate_job *job);

#endif
