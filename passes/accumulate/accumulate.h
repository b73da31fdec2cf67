// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/accumulate.h - the weighted mean of any number of frames, one after another:
//     create -> add, add, ... -> current -> finish
// Memory does not depend on the number of frames, but for the stack of a tree, which grows with its
// logarithm. Every method knows a bound of its error before and after, and has an emulation on the
// CPU with which its result on GL agrees bit for bit.
//
// Frame k counts w_k / sum w. Which weights are allowed depends on the method; a frame of weight 0
// counts as one that was added, is not looked at, and is not drawn, whatever was announced for it.
//
// Sources: trees are Lagae, Suykens, Dutre, "A Hardware Accelerated Alternative for the
// Accumulation Buffer", report CW 369, K.U.Leuven 2003; the buffer is OpenGL 1.1, section 4.2.4,
// after Haeberli and Akeley 1990.
#ifndef WEFT_PASSES_ACCUMULATE_ACCUMULATE_H
#define WEFT_PASSES_ACCUMULATE_ACCUMULATE_H

#include "../../tiles/image/plane.h"
#include "../cpu/cpu.h"
#include "../gl/context.h"
#include "../gl/textures/texture.h"
#include "tree/tree.h"

WEFT_BEGIN_DECLS

// How frames become a mean. Default: auto.
enum weft_accumulate_method {
    // The cheapest whose bound is within max_error: exact where frames lie in memory, GL is a
    // software renderer or frame_count is not known, on GPUs the first of float and trees of 8, 16
    // and 32 bits that is. Bounds are those of frames of equal weight with values from low to high.
    // The report says which, and why.
    WEFT_ACCUMULATE_AUTO,
    // On the CPU, without GL: sums in integers that lose nothing (see weft_accumulator_report).
    // Any real weights. The same bytes whatever the order of frames, the number of threads, or the
    // parts that were accumulated apart and joined.
    WEFT_ACCUMULATE_EXACT,
    // A stack of textures whose uppermost ones are averaged whenever a node is complete. Weights
    // >= 0.
    WEFT_ACCUMULATE_TREE,
    // OpenGL's accumulation buffer, in software: accum(w_k / sum w), or mult and accum where the
    // sum of weights is not known. Any real weights.
    WEFT_ACCUMULATE_BUFFER,
    // GL blends with a constant alpha: adds w_k / sum w times the frame, or where the sum is not
    // known mixes the frame in by w_k / (sum so far), which keeps a running mean. Weights >= 0.
    WEFT_ACCUMULATE_BLEND,
    // GL adds w_k times the frame to a float target, which is divided by the sum at the end. Any
    // real weights.
    WEFT_ACCUMULATE_FLOAT,
    WEFT_ACCUMULATE_METHOD_COUNT
};
// NULL-ended, in the order of the enum: "auto", "exact", "tree", "buffer", "blend", "float".
WEFT_API extern const char *const weft_accumulate_method_names[];

// What becomes of frames' values that are NaN or infinite. Default: an error.
enum weft_accumulate_nonfinite {
    // weft_accumulator_add refuses the frame and names channel and pixel. Textures and drawings of
    // floats are read back for it, which takes longer than to add them.
    WEFT_NONFINITE_ERROR,
    WEFT_NONFINITE_SKIP,      // the value does not count; the others of the pixel do (exact only)
    WEFT_NONFINITE_PROPAGATE, // the mean is NaN there (exact, float, tree and blend of 32 bits)
    WEFT_NONFINITE_COUNT
};
// NULL-ended, in the order of the enum: "error", "skip", "propagate".
WEFT_API extern const char *const weft_accumulate_nonfinite_names[];

// What is kept of frames beside their mean, to be added up with |. Each costs memory, and a frame
// that lies on GL is read back for it.
enum weft_accumulate_keep {
    WEFT_KEEP_VARIANCE = 1, // of every value: variance and standard error
    WEFT_KEEP_EXTREMES = 2, // the least and the largest value
};

// Limits of all accumulations.
enum {
    WEFT_ACCUMULATE_MAX_CHANNELS = 1024,
    WEFT_ACCUMULATE_MAX_FRAMES = 1 << 24, // that count, in one accumulation
};

// What is accumulated, and how.
struct weft_accumulator_params {
    int32_t width, height; // of every frame in pixels, each > 0 (required)
    int channel_count;     // of every frame, 1 to WEFT_ACCUMULATE_MAX_CHANNELS (required)
    enum weft_accumulate_method method; // default auto
    // How many frames will come, those of weight 0 too, and what they weigh: borrowed until
    // weft_accumulator_create returns. Default (0 and NULL): not known; then trees are the same,
    // and blending and the buffer keep running means, which costs them accuracy. Frames beyond
    // frame_count, and other weights than those given here, are refused.
    int64_t frame_count;
    const double *weight;
    // A part of these frames comes, to be joined with the others (weft_accumulator_join): any of
    // them, in any order. What is announced is that of all frames, so that all parts have weights
    // of one scale, and is not compared with what comes. Exact only; auto is refused where it takes
    // another method (default: all of them come).
    bool part;
    // Of trees: inputs of a node, or of the nodes of each level; see weft_tree_params. Frames
    // beyond the product of level_branching are refused.
    int branching; // default 4
    int level_branching[WEFT_TREE_MAX_LEVELS];
    enum weft_tree_rounding rounding; // of trees on 8 and 16 bits, and to nearest or truncating of
                                      // the buffer on 16 (default: to nearest)
    // Of targets of tree, blend and buffer: 8, 16 (normalised codes; of the buffer 16 signed bits)
    // or 32 (floats); blend also WEFT_ACCUMULATE_HALF. Default 8; for the buffer 16.
    int bits;
    // Of what frames are drawn into, which the methods read: 8, 16, 32 or WEFT_ACCUMULATE_HALF, as
    // above. Default: bits; of exact sums 8, of float ones 32. Trees have frames drawn straight
    // into their stack where both are the same.
    int frame_bits;
    // What codes 0 and the largest one stand for, in targets of 8 and 16 bits. Values beyond it are
    // refused where frames lie in memory, and clamp in textures. Of floats it says where values of
    // frames on GL are, so that there is a bound. Default (both 0): 0 to 1.
    double low, high;
    double max_error;  // of auto: the bound that is wanted, in the frames' values (default 0: the
                       // exact method's, half a unit in the last place of a float)
    bool frames_on_gl; // of auto: where frames will come from
    enum weft_accumulate_nonfinite nonfinite; // default error
    unsigned keep;                            // of enum weft_accumulate_keep (default 0)
    // Frames that follow each other and are one sample of the variance together (default 1). For
    // frames that depend on each other, as those of a jitter table do, choose the table's length.
    int batch;
    weft_context *context; // borrowed for the accumulator's life; required by tree, blend, float
    bool emulate;          // run GL's methods in the CPU's integers and floats, without a context
    struct weft_cpu cpu;   // how the CPU's part runs
    const struct weft_log *log; // borrowed likewise; may be NULL
};
enum { WEFT_ACCUMULATE_HALF = 17 }; // bits of a target of half floats
#define WEFT_ACCUMULATOR_DEFAULTS
#define weft_accumulator_params(...)                                                               \
    (&(struct weft_accumulator_params){WEFT_ACCUMULATOR_DEFAULTS __VA_ARGS__})

// A framebuffer that a frame is drawn into: RGBA with a depth buffer of 24 bits and no stencil,
// cleared to 0 and depth 1. Row 0 of the frame is the lowest one of GL: y goes up.
struct weft_draw_target {
    unsigned framebuffer; // bound for drawing, with the viewport set
    int32_t width, height;
};

// One frame, of one of three kinds; borrowed until weft_accumulator_add returns.
struct weft_frame {
    // In memory: channel_count planes, of any types.
    const struct weft_plane *plane;
    // On GL: a complete 2D texture of the accumulator's context and size, at least channel_count
    // (1 to 4) channels: GL_R or GL_RGBA with 8, 16, 16F or 32F, its channels not swizzled. Row 0
    // is texel row 0.
    unsigned texture;
    // Drawn by the caller: called while the context is current, as it leaves it, with GL's default
    // state otherwise. It may change any of that state, but not the objects of others, ends what it
    // begins (queries, transform feedback), and calls nothing of weft with this context. Anything
    // but WEFT_OK ends the call, which returns it; an error of GL is WEFT_ERR_GL.
    enum weft_result (*draw)(void *priv, int64_t index, const struct weft_draw_target *target);
    void *priv;
};

// Thread-safety: one thread at a time, with its context.
typedef struct weft_accumulator weft_accumulator;

// Chooses the method, checks all of the request and makes what frames go into. On failure *out is
// NULL. Returns WEFT_ERR_ARGUMENT (a range; weights that the method does not allow, or that add up
// to 0; what the method cannot keep), WEFT_ERR_LIMIT, WEFT_ERR_UNSUPPORTED (auto: nothing is within
// max_error; the log has the best bound), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_accumulator_create(const struct weft_accumulator_params *params,
                                                  weft_accumulator **out);
WEFT_API void weft_accumulator_destroy(weft_accumulator **accumulator); // accepts &NULL

// Adds a frame. A frame that is refused leaves the accumulation as it was: others may follow.
// Returns WEFT_ERR_ARGUMENT (a weight that is not allowed, no or two kinds of frame, one too many),
// WEFT_ERR_FORMAT (a value that is not finite, below or beyond the range: the log names index,
// channel and pixel), what `draw` returned, WEFT_ERR_MEMORY or WEFT_ERR_GL; after the last two
// nothing more can be added.
WEFT_API enum weft_result weft_accumulator_add(weft_accumulator *accumulator,
                                               const struct weft_frame *frame, double weight);

// Per-pixel results.
enum weft_accumulated {
    WEFT_ACCUMULATED_MEAN,           // sum w v / sum w
    WEFT_ACCUMULATED_VARIANCE,       // of one sample of weight 1, unbiased: NAN below two samples
    WEFT_ACCUMULATED_STANDARD_ERROR, // of the mean, sqrt(variance * sum w^2) / sum w
    WEFT_ACCUMULATED_MINIMUM,        // of the values that count
    WEFT_ACCUMULATED_MAXIMUM,
    WEFT_ACCUMULATED_WEIGHT, // share of all weight that counts here: below 1 where values were
                             // skipped
    WEFT_ACCUMULATED_COUNT
};
// NULL-ended, in the order of the enum: "mean", "variance", "standard error", ...
WEFT_API extern const char *const weft_accumulated_names[];

// Writes a result of the frames so far: channel `channel` as floats, means rounded once to nearest
// and the others within a unit in the last place, out[y * stride + x]; stride 0: width. What is
// accumulated is not changed, and frames may follow.
// Pixels without any value that counts are NAN. Returns WEFT_ERR_ARGUMENT (no frame that counts, a
// result that was not kept, a channel), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_accumulator_current(weft_accumulator *accumulator,
                                                   enum weft_accumulated what, int channel,
                                                   float *out, size_t stride);

// Draws a result of `channels` channels from `channel` on to a texture of params.context, the first
// one to the texture's channel `channel`. Means of the methods blend and float are where they were
// summed up, and are not read back; they are scaled and divided in single precision, within 2^-21
// of the largest |value| of the range or the mean from what weft_accumulator_current writes. All
// others go through memory. Channels that are drawn lie in one group of four. Returns what
// weft_accumulator_current and weft_texture_write do.
WEFT_API enum weft_result weft_accumulator_current_texture(weft_accumulator *accumulator,
                                                           enum weft_accumulated what, int channel,
                                                           int channels,
                                                           const struct weft_texture *texture);

// Ends it: no frame can follow, and all but the results is given back. Harmless a second time.
// Returns WEFT_ERR_ARGUMENT (no frame that counts), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_accumulator_finish(weft_accumulator *accumulator);

// What an accumulation is and has come to.
struct weft_accumulator_report {
    enum weft_accumulate_method method; // never auto
    const char *why;                    // auto: in words; "asked for" otherwise
    int bits;                           // of its targets; exact: 0
    int64_t frames;                     // that were added
    int64_t counted;                    // of those, how many had another weight than 0
    double total_weight;
    // Of |mean - exact mean of the frames as they were given|, in the frames' values, for the
    // frames so far, all of them finite and within the range; before the first one for frame_count
    // of equal weight, INFINITY where that is not known. It includes the result's rounding to a
    // float. How each method comes by it stands beside it in its source file.
    double bound;
    // Largest |w - w'| / w of the weights as they were given and as they count: trees have integers
    // by the largest remainder, blending on codes has 8 or 16 bits of them.
    double weight_change;
    uint64_t nonfinite; // values that were not finite
    // Alive at most so far, beside frames that the caller has; of trees the stack, what a node is
    // drawn into, and one more where results so far were read.
    int textures;
    uint64_t bytes;  // of textures and memory now
    uint64_t passes; // that were drawn
    double bias;     // of trees: expected mean of result - exact mean over random codes, in
                     // the frames' values
};
WEFT_API void weft_accumulator_get_report(const weft_accumulator *accumulator,
                                          struct weft_accumulator_report *out);

// ---- stopping early -----------------------------------------------------------------------------

// When the mean is good enough. A pixel's standard error is judged by the mean variance of its
// neighbourhood, as its own is not known well from few frames: a pixel that saw no light yet has
// none. It has converged where standard error <= max(absolute, relative * |mean of the
// neighbourhood|) in every channel. What no frame has shown in a whole neighbourhood cannot be
// known: let `least` and `radius` grow with how rare what matters is.
struct weft_until {
    double absolute; // in the frames' values, >= 0 (default 0)
    double relative; // to the mean, >= 0 (default 0); one of the two is > 0
    double share;    // of pixels that must have converged, in (0, 1] (default 0.99)
    int64_t least;   // frames that count before it is judged, >= 2 (default 16)
    int radius;      // of the neighbourhood, a square of 2 radius + 1 pixels, to
                     // WEFT_UNTIL_MAX_RADIUS (default 2; -1: the pixel alone)
};
enum { WEFT_UNTIL_MAX_RADIUS = 64 };
// What was found, of the pixels that have a mean in every channel.
struct weft_convergence {
    bool enough;            // until is met
    double share;           // of pixels that have converged
    double largest, median; // standard errors of the pixels' worst channels, in the frames' values;
                            // NAN where none is known
};
// Judges what was accumulated with WEFT_KEEP_VARIANCE. It costs about as much as adding ten frames:
// judge when the number of frames has grown by a twentieth or so, since errors fall with its square
// root. Returns WEFT_ERR_ARGUMENT (a range, no variance is kept, no frame that counts),
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_accumulator_judge(weft_accumulator *accumulator,
                                                 const struct weft_until *until,
                                                 struct weft_convergence *out);

// ---- states -------------------------------------------------------------------------------------

// Everything that was accumulated, as bytes that go on elsewhere: same results, bit for bit. They
// are of this machine's byte order, with a version and a checksum.
// Writes a state into *out, to be freed by the caller. Returns WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_accumulator_save(weft_accumulator *accumulator, void **out,
                                                size_t *size);
// Takes a state into an accumulator that was created with the same params and has no frames yet.
// Returns WEFT_ERR_FORMAT (damaged, cut, a newer version), WEFT_ERR_ARGUMENT (of other params: the
// log has both), WEFT_ERR_MEMORY or WEFT_ERR_GL; the accumulator then has no frames.
WEFT_API enum weft_result weft_accumulator_load(weft_accumulator *accumulator, const void *state,
                                                size_t size);
// Adds all that another accumulator has, of the same params but for frame_count and weight: the
// same bytes as if its frames had been added here, in any order, of results, states and bounds. Of
// the exact method only; with batches that are
// not whole in one of the two at most, and weights of the same scale, as all are but those of which
// the largest that was announced is below 2^-8 or not below 2^20.
// Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT (sums that together are too large) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_accumulator_join(weft_accumulator *accumulator,
                                                const weft_accumulator *other);

WEFT_END_DECLS
#endif
