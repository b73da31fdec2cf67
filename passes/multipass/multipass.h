// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/multipass.h - runs plans of passes: on GL, and on the CPU in the same integers.
// A plan (passes/plan/plan.h) is compiled once and run often: compiling lays its tiles out, makes
// its programs and hands both to GL; a run takes samples on a lattice and the positions of a planar
// grid of pixels, and gives values in the samples' own range. On unorm targets GL and CPU agree in
// every bit on every GL that keeps to GL's rules: passes compute in integers and hand over whole
// codes.
// Samples f are mapped to (f - low) / (high - low), so that a result r of the plan's arithmetic,
// (y / T - bias) / scale of its last target, is the value low S + (high - low) r, where S is the
// sum of the kernel's weights: 1 where they add up to one everywhere, about 0 for derivatives, and
// else the exact sum at the pixel's position.
#ifndef WEFT_PASSES_MULTIPASS_MULTIPASS_H
#define WEFT_PASSES_MULTIPASS_MULTIPASS_H

#include <math.h>

#include "../gl/context.h"
#include "../plan/plan.h"

WEFT_BEGIN_DECLS

// ---- compiling ----------------------------------------------------------------------------------

// What is compiled.
struct weft_multipass_params {
    const weft_pass_plan *plan; // required; borrowed while the compiled plan lives
    int threads; // that lay samples out and form results (default 0: one a processor)
    const struct weft_log *log; // may be NULL
};
#define WEFT_MULTIPASS_DEFAULTS
#define weft_multipass_params(...)                                                                 \
    (&(struct weft_multipass_params){WEFT_MULTIPASS_DEFAULTS __VA_ARGS__})

// A plan made ready to run. Thread-safety: one thread at a time, and one at a time with whatever
// else uses its context.
typedef struct weft_multipass weft_multipass;

// Compiles a plan for a context, which must outlive it, or without one (NULL) for the CPU. Targets
// that a pass both reads and writes need no second texture where GL has
// GL_EXT_shader_framebuffer_fetch. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT (no plan),
// WEFT_ERR_LIMIT (texels of the tiles and the context's limit, or sums past 32 bits, in the log),
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_multipass_compile(weft_context *context,
                                                 const struct weft_multipass_params *params,
                                                 weft_multipass **out);
WEFT_API void weft_multipass_destroy(weft_multipass **compiled); // accepts &NULL, leaves NULL

// What compiling cost.
struct weft_multipass_info {
    double seconds;      // all of it
    uint64_t tile_bytes; // of the tiles' texture, or of their values on the CPU
    int programs;        // different ones of the passes; 0 on the CPU
};
// Valid while the compiled plan lives.
WEFT_API const struct weft_multipass_info *weft_multipass_get_info(const weft_multipass *compiled);

// ---- running ------------------------------------------------------------------------------------

// Samples (of a prefiltered kernel, coefficients) [z][y][x], x fastest, tightly packed, at integer
// coordinates; beyond them the nearest sample's value holds. Sizes along axes past the plan's dims
// are 1.
struct weft_samples {
    int size[3];
    const float *plane[4]; // as many as the plan has channels; borrowed
    // The range mapped to [0, 1], one for all channels. NAN, or both 0: the finite minimum and
    // maximum. What lies outside is clamped to it. Where both are the same, all samples count as
    // that.
    double low, high;
};

// Pixel (x, y) lies at origin + x du + y dv, in the samples' coordinates, as doubles; where columns
// are given, at columns[x] along the first axis, and where rows are, at rows[y] along the second:
// for scales whose multiples doubles do not hold. Its first tap and fraction are those of
// weft_kernel_first_tap, and of a tile's M samples along an axis number floor(fraction M) is taken.
struct weft_pixel_grid {
    int width, height;
    double origin[3], du[3], dv[3];
    const double *columns, *rows; // [width], [height]; borrowed; NULL: as above
    int fraction_bits; // positions are rounded to so many, half-way up; 0: they stay as they are
};

// Samples in, pixels out. Borrowed until the call returns.
struct weft_multipass_run_params {
    const struct weft_samples *samples;   // required
    const struct weft_pixel_grid *grid;   // required
    float *pixels[4];                     // [y * stride + x], as many as the plan has channels; all
                                          // are written
    int64_t stride;                       // floats from row to row (default the grid's width)
    const struct weft_progress *progress; // may be NULL; asked before every pass
    const struct weft_log *log;           // may be NULL
};
#define WEFT_MULTIPASS_RUN_DEFAULTS
#define weft_multipass_run_params(...)                                                             \
    (&(struct weft_multipass_run_params){WEFT_MULTIPASS_RUN_DEFAULTS __VA_ARGS__})

// What a run did.
struct weft_multipass_report {
    double low, high; // the range that was mapped
    uint64_t clamped; // samples outside it, or not finite, of all channels
    // Pixels with a tap whose sample is not finite, and whose exact weight is not 0: they are NAN,
    // in the channels where that is so.
    uint64_t not_finite;
    double prepare_seconds, upload_seconds, pass_seconds, readback_seconds;
    uint64_t uploaded_bytes; // by this run: source and positions, never tiles; 0 on the CPU
    int programs_linked;     // by this run: 0
    // In textures and buffers, or in memory; the tiles' are the compiled plan's.
    uint64_t source_bytes, tile_bytes, target_bytes, position_bytes;
    // On the CPU only: clamped stores over all passes, and by how many codes at most.
    uint64_t clamps;
    double largest_clamp;
};

// Runs a compiled plan. What the same samples and grid give is the same in every run; targets and
// buffers stay for the next one, and grow where that needs larger ones. On the CPU half targets are
// rounded towards zero, as llvmpipe does it. Returns WEFT_ERR_ARGUMENT (sizes, ranges, strides,
// positions that are not finite), WEFT_ERR_UNSUPPORTED (log with a range below 0), WEFT_ERR_LIMIT
// (pixels or texels and the context's limit in the log), WEFT_ERR_MEMORY, WEFT_ERR_GL or
// WEFT_ERR_CANCELLED; pixels are then as they were. report may be NULL.
WEFT_API enum weft_result weft_multipass_run(weft_multipass *compiled,
                                             const struct weft_multipass_run_params *params,
                                             struct weft_multipass_report *report);

WEFT_END_DECLS
#endif
