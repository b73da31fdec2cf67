// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/frames.h - frames that ranks divide among each other. Every rank adds its own to
// exact sums of its own, and these become one on rank 0: exact sums have no order, so that it has
// the bytes of one process, whichever rank adds which frames, in blocks of whatever size.
//
// Samples of several frames (weft_accumulator_params.batch) must lie in one block, and of sums that
// are joined only one may end in a sample that is not whole. So blocks are whole samples, but for
// the last one, and what a sample of rank 0's sums lacks is added there before anything else.
#ifndef WEFT_TOOLS_RANKS_FRAMES_H
#define WEFT_TOOLS_RANKS_FRAMES_H

#include "tools/common/json.h"
#include "tools/ranks/options.h"
#include "weft.h"

// Blocks a rank has where --granularity does not say it. Where ranks ask for work the last ones are
// smaller, down to one sample.
enum { RANK_FRAMES_GRANULARITY = 16 };

// Frames that are added one after the other in one process: all that there are, or those up to
// where the mean is looked at. All ranks give the same, but for priv.
struct rank_frames {
    int64_t count;   // > 0
    int64_t counted; // frames that are in the sums of all ranks before, and count
    int batch;       // frames of a sample, >= 1
    const struct rank_request *request;
    // Whether a frame counts; others are no part of a sample. NULL: all do.
    bool (*counts)(void *priv, int64_t frame);
    // Adds frames to this rank's sums. What is to be told of them is data, as struct weft_items has
    // it, which rank 0 takes, in any order.
    enum weft_result (*run)(void *priv, int64_t first, int64_t count, void **data, size_t *size);
    enum weft_result (*take)(void *priv, int64_t first, int64_t count, const void *data,
                             size_t size);
    void *priv;
    const struct weft_progress *progress; // of all of them; may be NULL
};

// What a command's ranks did. Starts as {0}.
struct rank_frames_report {
    struct weft_items_report work; // of all rounds together; items of the last one
    int64_t rounds;
    int64_t states; // sums of other ranks that were joined
    uint64_t bytes; // of them
    double seconds; // that this took rank 0
};
void rank_frames_clear(struct rank_frames_report *report);

// Adds the frames, each on one rank. Collective; returns on all ranks alike. Adds to *report.
enum weft_result rank_frames_add(const struct rank_frames *frames,
                                 struct rank_frames_report *report);

// Makes the sums of all ranks one, on rank 0: eight ranks' states come there at a time, and are
// joined as they come. Others begin new ones by `create`. Collective; returns on all ranks alike.
enum weft_result rank_frames_join(weft_accumulator **sums,
                                  enum weft_result (*create)(void *priv, weft_accumulator **out),
                                  void *priv, struct rank_frames_report *report);

// Refuses what cannot be divided so: options of parts of pictures, and methods that add frames up
// in their order. `method` as it was asked for. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result rank_frames_check(const struct rank_request *request,
                                   enum weft_accumulate_method method);

// The object "ranks", with what was joined; NULL where nothing was divided. And as a line or two.
json_t *rank_frames_json(const struct rank_frames_report *report);
void rank_frames_print(const struct rank_frames_report *report);

#endif
