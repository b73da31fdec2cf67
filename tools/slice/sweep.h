// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/sweep.h - which slices a command makes: frames, their planes and their files' names.
#ifndef WEFT_TOOLS_SLICE_SWEEP_H
#define WEFT_TOOLS_SLICE_SWEEP_H

#include "tools/slice/job.h"

enum { SWEEP_MAX_FRAMES = 10000 };

// What options contradict each other, as an error line; NULL: none. All that --frames needs, and
// what needs it.
const char *sweep_conflict(const struct slice_setup *setup);

// Reads --frames and --planes; one slice without a number if there are none, which this allows to
// have been asked for (sweep_conflict). Returns WEFT_ERR_ARGUMENT, WEFT_ERR_OPEN or
// WEFT_ERR_FORMAT (the file) or WEFT_ERR_MEMORY after an error line.
enum weft_result sweep_read(struct slice_setup *setup);
void sweep_clear(struct slice_sweep *sweep);

// Starts the job of a frame, 0 to count - 1: its number and files. It is to be cleared with
// slice_clear whatever comes of it. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result sweep_start(struct slice_setup *setup, int index, struct slice_job *job);

// That no file is written twice or is an input too, and unless it is only explained that all could
// be written now. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_WRITE or WEFT_ERR_MEMORY after an error line.
enum weft_result sweep_check_files(struct slice_setup *setup);

// The planes of a file, of which there must be `count`: a line each, with origin, u and v as X,Y,Z
// and blanks between them. Lines that are empty or start with # do not count. To be freed. Returns
// WEFT_ERR_OPEN, WEFT_ERR_FORMAT or WEFT_ERR_MEMORY after an error line.
enum weft_result sweep_load_planes(const char *path, int64_t count, struct slice_plane **out);

// Makes all slices, and tells of each. Returns the exit code.
int sweep_run(struct slice_setup *setup);

#endif
