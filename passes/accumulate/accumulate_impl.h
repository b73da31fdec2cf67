// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/accumulate_impl.h - what an accumulator is made of (not installed).
// accumulate.c checks requests, counts and dispatches; each method is a table of functions in a
// file of its own; frames of all kinds become planes or textures in frame.h. Methods add to their
// own state, and what is kept beside the mean is one struct weft_moments for all of them.
#ifndef WEFT_PASSES_ACCUMULATE_ACCUMULATE_IMPL_H
#define WEFT_PASSES_ACCUMULATE_ACCUMULATE_IMPL_H

#include "filter/check.h"
#include "passes/accumulate/accumulate.h"
#include "passes/accumulate/sums/blocks.h"
#include "passes/accumulate/sums/state.h"
#include "passes/accumulate/sums/weights.h"

WEFT_BEGIN_DECLS

// One method. `a` is checked: frames are of one kind, of a weight that it takes and not 0. Where a
// function fails it has logged one line.
struct weft_accumulate_way {
    enum weft_accumulate_method method;
    bool negative; // weights may be
    bool scans;    // needs a->scan when it adds
    // Makes a->own. On failure destroy is called.
    enum weft_result (*create)(weft_accumulator *a);
    void (*destroy)(weft_accumulator *a);
    // A frame that is refused (WEFT_ERR_FORMAT, what `draw` returned) leaves the state as it was.
    enum weft_result (*add)(weft_accumulator *a, const struct weft_frame *frame, double weight);
    // The mean of one channel so far, each value rounded once to a float; the state is as before.
    enum weft_result (*mean)(weft_accumulator *a, int channel, float *out, size_t stride);
    // The mean of channels of one group, on GL; NULL: through memory. Not where params.emulate.
    enum weft_result (*draw_mean)(weft_accumulator *a, int channel, int channels,
                                  const struct weft_texture *texture);
    // The share of all weight that counts, likewise; NULL: 1 everywhere.
    enum weft_result (*share)(weft_accumulator *a, int channel, float *out, size_t stride);
    enum weft_result (*finish)(weft_accumulator *a); // NULL: nothing to give back
    // The bound for so many frames of equal weight, with values from low to high, before any of
    // them; INFINITY where there is none. Pure: `params` are checked and filled in, but for the
    // method. NULL: no bound.
    double (*expect)(const struct weft_accumulator_params *params, int64_t frames);
    // bound, weight_change, textures, bytes, passes and bias, for the frames so far or expected.
    void (*report)(const weft_accumulator *a, struct weft_accumulator_report *out);
    // Puts what a->own has, and takes it back. Whether there was room, or enough bytes, is looked
    // at once behind: a failure of `load` is one of memory or GL, or a content that cannot be.
    enum weft_result (*save)(weft_accumulator *a, weft_state *state);
    enum weft_result (*load)(weft_accumulator *a, weft_state *state);
    // NULL: refused. `other` has the same params but for weights and frame_count, and its weights
    // are still to be added to a->weights.
    enum weft_result (*join)(weft_accumulator *a, const weft_accumulator *other);
};
extern const struct weft_accumulate_way weft_accumulate_exact, weft_accumulate_tree,
    weft_accumulate_buffer, weft_accumulate_blend, weft_accumulate_float;

// ---- choosing (choose.c) ------------------------------------------------------------------------

const struct weft_accumulate_way *weft_accumulate_way_of(enum weft_accumulate_method method);
// Fills in the defaults, once the method is known.
void weft_accumulate_fill_in(struct weft_accumulator_params *params);

// What auto comes to.
struct weft_accumulate_choice {
    enum weft_accumulate_method method;
    int bits; // of its targets; 0: none
    const char *why;
};
// Chooses for checked params, by bounds of frame_count frames of equal weight. `hardware`: the
// context is on a GPU. Returns WEFT_ERR_UNSUPPORTED, with the best bound in the log.
enum weft_result weft_accumulate_choose(const struct weft_accumulator_params *params, bool hardware,
                                        struct weft_accumulate_choice *out);

// ---- accumulators -------------------------------------------------------------------------------

struct weft_moments; // moments.h

struct weft_accumulator {
    struct weft_accumulator_params params; // with defaults filled in; method: the chosen one
    double *weight;                        // of every frame, a copy; NULL: not known
    double known_total;                    // their sum; 0: not known
    const struct weft_accumulate_way *way;
    const char *why;                  // the method was chosen
    void *own;                        // the method's
    struct weft_moments *moments;     // NULL: nothing is kept beside the mean
    struct weft_frame_source *source; // frame.h's buffers and textures
    struct weft_scan *scan; // of the frame that is added, of each channel; NULL: nobody needs it
    int64_t frames, counted;
    struct weft_weights weights; // so far
    double total_weight;         // of them
    uint64_t nonfinite;
    bool finished, broken; // broken: only to be destroyed
};

static inline struct weft_frame_shape weft_accumulator_shape(const weft_accumulator *a)
{
    return (struct weft_frame_shape){a->params.width, a->params.height, a->params.channel_count,
                                     a->params.cpu.threads};
}

WEFT_END_DECLS
#endif
