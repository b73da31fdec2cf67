// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/job.h - one `weft accumulate`: what was asked, what was read, what came of it.
#ifndef WEFT_TOOLS_ACCUMULATE_JOB_H
#define WEFT_TOOLS_ACCUMULATE_JOB_H

#include "tools/common/json.h"
#include "tools/common/options.h"
#include "tools/common/paths.h"

enum accumulate_option {
    ACCUMULATE_OUTPUT,
    ACCUMULATE_TYPE,
    ACCUMULATE_COMPRESSION,
    ACCUMULATE_SKIP_BAD,
    ACCUMULATE_THREADS,
    ACCUMULATE_EXPLAIN,
    ACCUMULATE_JSON,
    ACCUMULATE_NO_CLOBBER,
    ACCUMULATE_QUIET,
    ACCUMULATE_VERBOSE,
    ACCUMULATE_OPTION_COUNT
};

// A frame that was named, in the order in which frames count.
struct accumulate_frame {
    char *path;
    double weight;
    bool bad; // left out by --skip-bad, as `problem` says
    char *problem;
};

// A channel of the frames.
struct accumulate_channel {
    bool copied;                 // not averaged: it is the first counting frame's
    int averaged;                // its place among those that are averaged; -1: copied
    enum weft_pixel_type widest; // of the frames that were added
};

struct accumulate_job {
    const struct option_value *option; // [ACCUMULATE_OPTION_COUNT]
    const char *const *operands;       // NULL-ended
    int threads;                       // 0: as many as run at once

    struct accumulate_frame *frame;
    int64_t frame_count;
    // Frames are read in order. `next` is the first one that was not looked at yet, `first` the
    // first one that was added, -1: none.
    int64_t next, first;
    int64_t added, skipped; // counting frames that were added, and bad ones that were left out

    // What the frames have in common: of the first readable one. Its planes are those of the
    // channels that are copied, of frame `first`.
    struct weft_image image;
    struct accumulate_channel *channel; // [image.channel_count]
    int averaged_count;
    weft_accumulator *accumulator;
    struct weft_accumulator_report report; // once all is added

    struct weft_image result;
    struct weft_metadata *texts;
    struct weft_image_save_report saved;
    double start; // monotonic seconds
    double read_seconds, add_seconds, result_seconds, write_seconds;
};

// ---- stages, in this order; all return a result after one error line ----------------------------

// Names of frames from operands, patterns and lists; their weights. (names.c, weights.c)
enum weft_result accumulate_list_frames(struct accumulate_job *job);
// That outputs can be written and are no inputs. (names.c)
enum weft_result accumulate_check_files(const struct accumulate_job *job);
// What frames have in common, without their pixels, and the accumulator for them. (begin.c)
enum weft_result accumulate_begin(struct accumulate_job *job);
// Adds all frames from job->next on. (read.c)
enum weft_result accumulate_read(struct accumulate_job *job);
// The mean so far as job->result, with attributes: may be called at any time after the first frame
// was added, again and again. (result.c)
enum weft_result accumulate_make_result(struct accumulate_job *job);
// Writes the outputs. (result.c)
enum weft_result accumulate_save(struct accumulate_job *job);

void accumulate_clear(struct accumulate_job *job);

#endif
