// SPDX-License-Identifier: BSD-3-Clause
// passes/resample/resample.h - the call for images: planes of floats at another size.
// Samples lie at the centres of square pixels; where the result's pixels lie among them is a map
// along each axis (passes/positions/window_map.h). What holds beyond the samples is a rule
// (filter/boundary.h), by default the nearest sample. Where pixels lie more than a sample apart
// along an axis the kernel is stretched by as much (filter/kernels/stretch.h), so that what they
// cannot show is filtered away.
//
// A request is made in four steps, of which each repeats nothing of the ones before:
//   plan     what is done: kernel, sizes, positions, engine; pure, tells its errors and its work
//   compile  a plan made ready for a context, or for the CPU
//   source   planes, with what is measured of them, and coefficients where the kernel reads those
//   run      source to pixels, as often as wanted: of any compiled plan and any source of its size
//            and kernel, so that the planes of one image, or many images, share one compiled plan
//
// The plan is always of the whole image and result. A run may make a part of the result's pixels,
// from a source that has a window of the image's samples: the pixels are those of the whole, bit
// for bit, whatever engine makes them. What is of all samples, their range and a survey, is
// measured part by part and joined.
//
// Two algorithms filter: passes/separable/separable.h, one axis after the other, on OpenGL in
// single precision or on the CPU engine in single or double precision; and the passes of a plan
// (passes/plan/plan.h), what targets of limited precision make of it, on GL or in the same integers
// on the CPU. Unsigned integers are moved exactly by kernels that take
// one sample (nearest). The same request gives the same bytes, whatever memory and threads there
// are.
#ifndef WEFT_PASSES_RESAMPLE_RESAMPLE_H
#define WEFT_PASSES_RESAMPLE_RESAMPLE_H

#include <math.h>

#include "../../filter/analysis/bound.h"
#include "../../filter/boundary.h"
#include "../../filter/rectangle.h"
#include "../../filter/statistics.h"
#include "../gl/context.h"
#include "../gl/textures/texture.h"
#include "../multipass/multipass.h"
#include "../plan/plan.h"
#include "../positions/window_map.h"
#include "../verify/verify.h"

WEFT_BEGIN_DECLS

// Channels of a source, and samples or pixels along an axis and in all, at most.
enum { WEFT_RESAMPLE_MAX_CHANNELS = 4, WEFT_RESAMPLE_MAX_SIZE = 1 << 20 };
#define WEFT_RESAMPLE_MAX_PIXELS (INT64_C(1) << 31)

// ---- plan ---------------------------------------------------------------------------------------

struct weft_resample_params {
    // The algorithm: passes of this plan, in 2D and without a derivative; NULL (default):
    // separable. Borrowed for the plan's life.
    const weft_pass_plan *passes;
    // Default (info NULL): that of `passes`, or catmull-rom. With passes it must be theirs;
    // without, it may not be radial.
    struct weft_kernel kernel;
    int size[2];       // samples along x and y (required, to WEFT_RESAMPLE_MAX_SIZE)
    int width, height; // pixels (required, likewise, and to WEFT_RESAMPLE_MAX_PIXELS)
    // Along x and y. Default (all 0): all samples become all pixels, weft_window_map_plain.
    struct weft_window_map map[2];
    // What stands beyond the samples, along both axes (default clamp); the source's.
    enum weft_boundary boundary;
    // Whether kernels stay as they are where pixels lie more than a sample apart, and the result
    // may alias (default false: they are stretched; those that take one sample, like nearest, never
    // are).
    bool unstretched;
    // Whether finite pixels are held between the smallest and the largest finite sample next to
    // them, which are those at most as far away along each axis as the kernel is stretched by: one
    // sample, where it is not (default false). Edges then do not ring, and do not overshoot.
    bool clamp;
    enum weft_engine engine; // that runs separable work (default OpenGL); passes run on what they
                             // are compiled for
    enum weft_sums sums;     // of separable work (default float); double: of the CPU engine alone
    // What a run may take beside planes and tiles of kernels (default 1 GiB): separable work is
    // cut into rectangles that fit, the tiles of passes are fixed by the sizes and refused.
    uint64_t memory_bytes;
    const struct weft_log *log; // may be NULL; borrowed for the plan's life
};
#define WEFT_RESAMPLE_DEFAULTS
#define weft_resample_params(...)                                                                  \
    (&(struct weft_resample_params){WEFT_RESAMPLE_DEFAULTS __VA_ARGS__})

typedef struct weft_resample_plan weft_resample_plan; // Thread-safety: read-only once made.

struct weft_resample_info {
    struct weft_kernel kernel;
    const struct weft_pass_plan_info *passes; // NULL: separable
    int size[2], width, height;
    struct weft_window_map map[2];
    enum weft_boundary boundary;
    double stretch[2]; // of the kernel along x and y; 1: as it is
    bool clamp;
    enum weft_engine engine; // of separable work, as are its sums
    enum weft_sums sums;
    bool moves; // integers, by weft_resample_move: weft_resample_moves(&kernel), and no passes
    // Coefficients beyond the samples that are read on every side; 0 but for prefiltered kernels.
    int overlap;
    int tiles;      // that passes cut a channel's pixels into; of separable work 0: memory decides
    double fetches; // per pixel and channel: of passes over all, of separable work along both axes
    // The terms of |result - exact|. Separable: where the largest |value read| is below 2^100, and
    // not 0; weft_resample_bound knows of any.
    struct weft_bound_terms bound;
    const char *text; // the plan in words, lines ended
};

// Plans. Returns WEFT_ERR_ARGUMENT (sizes, maps, kernel, passes of another kernel, of 3D or of a
// derivative, enums), WEFT_ERR_UNSUPPORTED (a radial kernel without passes; double sums of passes
// or on OpenGL; a kernel to be stretched that is prefiltered, radial or in passes; boundaries other
// than clamp in passes), WEFT_ERR_LIMIT (the largest tile of passes needs more than memory_bytes:
// the log has both) or WEFT_ERR_MEMORY; *out is then NULL.
WEFT_API enum weft_result weft_resample_plan_create(const struct weft_resample_params *params,
                                                    weft_resample_plan **out);
WEFT_API void weft_resample_plan_destroy(weft_resample_plan **plan); // accepts &NULL
WEFT_API const struct weft_resample_info *
weft_resample_plan_get_info(const weft_resample_plan *plan);

// Returns samples that hold all that a part of a plan's pixels (all 0: all of them) reads, whatever
// engine makes them: of prefiltered kernels all, since a coefficient depends on every sample of its
// row and column. All 0 for a part that is not within the pixels. Pure.
WEFT_API struct weft_rectangle weft_resample_reach(const weft_resample_plan *plan,
                                                   const struct weft_rectangle *part);

// ---- compile ------------------------------------------------------------------------------------

// A plan ready to run. Thread-safety: one thread at a time, the one of its context where it has
// one.
typedef struct weft_resample_compiled weft_resample_compiled;

// Where a plan runs. Borrowed until the call returns, but for the context.
struct weft_resample_compile_params {
    // Of separable plans for OpenGL (required; of those for the CPU engine NULL), and of passes
    // (default the CPU: in the same integers, half targets rounded towards zero). It must outlive
    // the result.
    weft_context *context;
    struct weft_cpu cpu; // how the CPU engine runs separable plans (default: as fast as it can)
};
#define WEFT_RESAMPLE_COMPILE_DEFAULTS
#define weft_resample_compile_params(...)                                                          \
    (&(struct weft_resample_compile_params){WEFT_RESAMPLE_COMPILE_DEFAULTS __VA_ARGS__})

// Makes a plan ready, which is borrowed for the life of *out. Returns WEFT_ERR_ARGUMENT (a context
// that separable work lacks, or has no use for; threads, instructions), WEFT_ERR_UNSUPPORTED
// (instructions that do not run here), WEFT_ERR_LIMIT, WEFT_ERR_MEMORY, WEFT_ERR_GL; *out is then
// NULL.
WEFT_API enum weft_result weft_resample_compile(const weft_resample_plan *plan,
                                                const struct weft_resample_compile_params *params,
                                                weft_resample_compiled **out);
WEFT_API void weft_resample_compiled_destroy(weft_resample_compiled **compiled); // accepts &NULL

// What compiling cost; valid while the compiled plan lives.
struct weft_resample_compiled_info {
    double seconds;
    uint64_t tile_bytes; // of the kernel's tiles; separable: 0
    int programs;        // on GL; of the CPU engine 0
};
WEFT_API const struct weft_resample_compiled_info *
weft_resample_compiled_get_info(const weft_resample_compiled *compiled);

// ---- source -------------------------------------------------------------------------------------

// What is measured of an image's samples, of all its channels together. What parts of them show is
// joined; parts that have no sample in common, and together have all, show what all do, exactly.
// Starts as WEFT_RESAMPLE_MEASURED_NONE.
struct weft_resample_measured {
    struct weft_statistics samples; // where differences are asked for, of the kernel's order
    uint64_t outside;               // values outside a range that is asked for, or not finite
};
#define WEFT_RESAMPLE_MEASURED_NONE                                                                \
    {                                                                                              \
        .samples = WEFT_STATISTICS_NONE                                                            \
    }

struct weft_resample_source_params {
    struct weft_kernel kernel; // default (info NULL): catmull-rom; the plan's
    int width, height;         // samples of the image (required): the plan's size
    int channels;              // 1 to 4 (default 1), which share one range
    // The samples that planes have (default: all), of kernels that are not prefiltered. A run needs
    // those that its part reaches (weft_resample_reach).
    struct weft_rectangle window;
    // As many as channels (required without a texture): sample (x, y) is plane[c][(y - window.y) *
    // stride + x - window.x]. Borrowed for the source's life; may overlap each other, but not a
    // run's pixels.
    const float *plane[WEFT_RESAMPLE_MAX_CHANNELS];
    // In their place, the window's samples as texels of a texture, and the context that has it,
    // both required: they are read once, when the source is made, and are the source's own then,
    // as they have to be measured (default NULL: planes).
    weft_context *context;
    const struct weft_texture *texture;
    int64_t stride; // floats from row to row, at least the window's width (default that)
    // What stands beyond the samples (default clamp), the plan's; and of a border the value, finite
    // (default 0). Coefficients of prefiltered kernels are those of the samples continued so.
    enum weft_boundary boundary;
    double border;
    // What all samples of the image show (required where planes have a window of them; default
    // NULL: it is measured). Borrowed until the call returns.
    const struct weft_resample_measured *measured;
    int threads; // that measure at once (default 0: one a processor)
    // What passes map to [0, 1] and back; what lies outside is clamped to it, and bounds do not
    // hold then. low < high. NAN, or both 0 (default): the finite minimum and maximum of what is
    // read.
    double low, high;
    const struct weft_log *log; // may be NULL
};
#define WEFT_RESAMPLE_SOURCE_DEFAULTS
#define weft_resample_source_params(...)                                                           \
    (&(struct weft_resample_source_params){WEFT_RESAMPLE_SOURCE_DEFAULTS __VA_ARGS__})

typedef struct weft_resample_source weft_resample_source; // Thread-safety: read-only once made.

// What was measured of a source, of all its channels together; once, when it was made.
struct weft_resample_statistics {
    double sample_low, sample_high; // of the finite samples, and a border's value; both 0 where
                                    // there are none
    // What passes map to [0, 1]: as asked for, or of the finite values that are read, which are
    // coefficients of prefiltered kernels and samples else; both 0 where there are none.
    double low, high;
    uint64_t clamped; // values read that are outside it, or not finite
};

struct weft_resample_source_info {
    struct weft_kernel kernel;
    int width, height, channels;
    enum weft_boundary boundary;
    double border;
    struct weft_rectangle window; // of the samples, that planes have
    struct weft_resample_statistics statistics;
    double prefilter_seconds;
};

// Takes planes: measures them, and computes the coefficients of a prefiltered kernel, which takes
// as much memory as the planes and the kernel's overlap around them. Coefficients that depend on
// samples that are not finite are missing, as filter/kernels/prefilter.h says. Returns
// WEFT_ERR_ARGUMENT (sizes, stride, range, pointers, kernel), WEFT_ERR_LIMIT (coefficients leave
// the range of floats), WEFT_ERR_UNSUPPORTED (a window, and a kernel that is prefiltered),
// WEFT_ERR_MEMORY or what weft_texture_read returns; *out is then NULL.
WEFT_API enum weft_result
weft_resample_source_create(const struct weft_resample_source_params *params,
                            weft_resample_source **out);
WEFT_API void weft_resample_source_destroy(weft_resample_source **source); // accepts &NULL
WEFT_API const struct weft_resample_source_info *
weft_resample_source_get_info(const weft_resample_source *source);

// Measures `rows` rows of samples from row `first` of the image on, which the params' planes have
// whole; a texture has to be read before (weft_texture_read). Differences, where they are asked for, are those that begin in these rows: the window must
// have as many rows past them as the kernel's order, but where the image ends. Returns
// WEFT_ERR_ARGUMENT, and WEFT_ERR_UNSUPPORTED as weft_resample_source_create.
WEFT_API enum weft_result weft_resample_measure(const struct weft_resample_source_params *params,
                                                int first, int rows, bool differences,
                                                struct weft_resample_measured *out);
// Adds what other rows show.
WEFT_API void weft_resample_measured_join(struct weft_resample_measured *sum,
                                          const struct weft_resample_measured *other);

// Returns the leading term of the kernel's own error, which no engine is to blame for:
// weft_error_e1 for a signal whose derivative of the kernel's order is the largest difference of
// that order between neighbours along x and along y, in all channels. NAN for kernels of order 0 or
// above WEFT_STATISTICS_DIFFERENCES, and for radial ones. Of a source that was given what was
// measured by the differences of that; else every call looks at all samples, with threads. It
// analyses the kernel anew, which takes milliseconds.
WEFT_API double weft_resample_e1(const weft_resample_source *source);

// Returns how far results may be off, the largest of which is `result` (0: not known yet), in the
// source's values: the plan's terms, by weft_bound_compute. Integers that are moved have no error.
WEFT_API struct weft_bound weft_resample_bound(const weft_resample_plan *plan,
                                               const struct weft_resample_statistics *statistics,
                                               double result);

// ---- run ----------------------------------------------------------------------------------------

// What decides how separable sums are made: of all samples in reach of any of a plan's pixels, each
// channel by itself (passes/separable/separable.h). Windows are surveyed apart and joined; they may
// have samples in common. Starts as {0}. Passes have no use for it.
struct weft_resample_survey {
    struct weft_separable_survey channel[WEFT_RESAMPLE_MAX_CHANNELS];
};
// Surveys what a source has. Returns WEFT_ERR_ARGUMENT (a source of another size or kernel).
WEFT_API enum weft_result weft_resample_survey_source(const weft_resample_plan *plan,
                                                      const weft_resample_source *source,
                                                      struct weft_resample_survey *out);
WEFT_API void weft_resample_survey_join(struct weft_resample_survey *sum,
                                        const struct weft_resample_survey *other);

struct weft_resample_run_params {
    const weft_resample_source *source; // required: of the plan's size and kernel
    struct weft_rectangle part;         // of the pixels that are made (default: all)
    // Required of separable plans where the source lacks samples that any pixel reaches; default
    // (NULL): made for this run, which a caller of many parts does once.
    const struct weft_resample_survey *survey;
    // As many as the source's channels (required without a texture): pixel (x, y) is plane[c][(y -
    // part.y) * stride + x - part.x]. What lies between rows is left as it is. They may not overlap
    // each other or the source's planes.
    float *plane[WEFT_RESAMPLE_MAX_CHANNELS];
    int64_t stride; // floats from row to row, at least the part's width (default that)
    // Of plans that are compiled with a context: where pixels are drawn to, in the place of planes
    // or as well, channel c to channel `channel` + c (default NULL: none). Separable plans without
    // clamp read nothing back for it, with what passes/separable/separable.h says of -0; others
    // make pixels in memory, from where they are uploaded. Borrowed until the call returns.
    const struct weft_texture *texture;
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;           // may be NULL
};
#define WEFT_RESAMPLE_RUN_DEFAULTS
#define weft_resample_run_params(...)                                                              \
    (&(struct weft_resample_run_params){WEFT_RESAMPLE_RUN_DEFAULTS __VA_ARGS__})

// What a run did. Sizes are of the largest tile, times of all.
struct weft_resample_work {
    int tiles; // of passes; of separable work rectangles; over all channels
    double prepare_seconds, upload_seconds, pass_seconds, readback_seconds;
    uint64_t uploaded_bytes; // of all: samples and positions; separable: weights
    // Passes: bytes in textures and buffers.
    uint64_t source_bytes, tile_bytes, target_bytes, position_bytes;
    // Passes on the CPU: stores that clamped, and by how many codes at most.
    uint64_t clamps;
    double largest_clamp;
    // Separable: as in struct weft_separable_report.
    uint64_t peak_bytes;
    int draws, first_axis;
    double fetches_per_pixel;
    struct weft_cpu cpu; // what the CPU engine ran with; threads 0: it did not run
};
// Adds what another run did: times and counts are summed up, sizes are the larger ones.
WEFT_API void weft_resample_work_add(struct weft_resample_work *sum,
                                     const struct weft_resample_work *one);

struct weft_resample_report {
    struct weft_statistics pixels; // of all channels; no differences; count 0 without planes
    struct weft_resample_work work;
};

// Fills the part's pixels of every channel. Pixels with a tap whose sample is not finite, and whose
// weight is not 0, are not finite, and no others. A plan of passes of four channels filters up to
// four together, with one of one channel they come in turn, as separable ones do. Returns
// WEFT_ERR_ARGUMENT (a source of another size or kernel, a part, a window without what it reaches,
// stride, pointers), WEFT_ERR_UNSUPPORTED
// (the technique log with a range below 0), WEFT_ERR_LIMIT, WEFT_ERR_MEMORY, WEFT_ERR_GL or
// WEFT_ERR_CANCELLED; pixels may then be written in part. report may be NULL.
WEFT_API enum weft_result weft_resample_run(weft_resample_compiled *compiled,
                                            const struct weft_resample_run_params *params,
                                            struct weft_resample_report *report);

// ---- verify -------------------------------------------------------------------------------------

struct weft_resample_verify_params {
    const weft_resample_source *source; // required
    struct weft_rectangle part;         // of the pixels (default: all)
    // What a run made of it, as in struct weft_resample_run_params; borrowed until the call
    // returns.
    const float *plane[WEFT_RESAMPLE_MAX_CHANNELS];
    int64_t stride;                // default the part's width
    struct weft_verify_params how; // for how long, with what progress
    const struct weft_log *log;    // may be NULL
};
#define WEFT_RESAMPLE_VERIFY_DEFAULTS
#define weft_resample_verify_params(...)                                                           \
    (&(struct weft_resample_verify_params){WEFT_RESAMPLE_VERIFY_DEFAULTS __VA_ARGS__})

// Verifies pixels against the source's samples (passes/verify/verify.h): of prefiltered kernels by
// the cardinal spline over the samples themselves, so that what coefficients got wrong is found,
// too. The bound is weft_resample_bound's for any result; it does not hold where a range that was
// asked for clamps. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_resample_verify(const weft_resample_plan *plan,
                                               const struct weft_resample_verify_params *params,
                                               struct weft_verify_report *out);

// ---- integers -----------------------------------------------------------------------------------

struct weft_resample_integers {
    int width, height;            // of the image, required
    struct weft_rectangle window; // of its samples, that the plane has (default: all)
    // Required: [(y - window.y) * stride + x - window.x]; borrowed until the call returns.
    const uint32_t *plane;
    int64_t stride; // from row to row, at least the window's width (default that)
};

// Returns whether a kernel takes one sample, with a weight of 1, at every position: nearest, by
// whatever name. It then moves integers without passes.
WEFT_API bool weft_resample_moves(const struct weft_kernel *kernel);

// Writes the smallest and the largest integer of the window; 0 and 0 of sizes or a stride that are
// out of their ranges.
WEFT_API void weft_resample_integer_range(const struct weft_resample_integers *integers,
                                          uint32_t range[2]);

// Moves integers: each pixel of a part (NULL: all), [(y - part.y) * stride + x - part.x] of
// `pixels` (stride 0: the part's width), becomes the one that the kernel takes. No float hides
// their last bits. Returns WEFT_ERR_ARGUMENT (sizes that are not the plan's, a part, a window
// without what it reaches, strides, a plan that does not move) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_resample_move(const weft_resample_plan *plan,
                                             const struct weft_resample_integers *source,
                                             const struct weft_rectangle *part, uint32_t *pixels,
                                             int64_t stride);

// Verifies what was moved against the sample in whose square each pixel's centre lies, found in
// whole numbers. The bound is 0. how may be NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_MEMORY or
// WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_resample_move_verify(const weft_resample_plan *plan,
                                                    const struct weft_resample_integers *source,
                                                    const struct weft_rectangle *part,
                                                    const uint32_t *pixels, int64_t stride,
                                                    const struct weft_verify_params *how,
                                                    struct weft_verify_report *out);

WEFT_END_DECLS
#endif
