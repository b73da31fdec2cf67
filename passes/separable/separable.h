// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/separable.h - planes of samples on axis-aligned grids of pixels, one axis after
// another. A tensor product of kernels along x and y (Hadwiger, Hauser, Moeller 2003, eq. 1) where
// all pixels of a column share the position along x, and all of a row that along y: width taps
// along one axis and then width along the other take the place of width^2. Weights are made in
// double, once for every column and row, and rounded to single precision, in which everything is
// summed, unless sums are to be in double. OpenGL does it in two passes, of which each computes
// four pixels of a row at a time; the CPU engine in one, by threads that share the rows and keep
// what lies between the axes in their caches.
#ifndef WEFT_PASSES_SEPARABLE_SEPARABLE_H
#define WEFT_PASSES_SEPARABLE_SEPARABLE_H

#include "../../filter/analysis/bound.h"
#include "../../filter/boundary.h"
#include "../../filter/rectangle.h"
#include "../../filter/statistics.h"
#include "../cpu/cpu.h"
#include "../gl/context.h"
#include "../gl/textures/texture.h"

WEFT_BEGIN_DECLS

// Samples and pixels along an axis, and weights of all its pixels where a kernel is stretched, at
// most.
enum { WEFT_SEPARABLE_MAX_SIZE = 1 << 24, WEFT_SEPARABLE_MAX_WEIGHTS = 1 << 28 };

// ---- plans --------------------------------------------------------------------------------------

// Which axis is filtered along first. Default: what fetches less.
enum weft_axis_order { WEFT_AXIS_ORDER_AUTO, WEFT_AXIS_ORDER_X_FIRST, WEFT_AXIS_ORDER_Y_FIRST };

// What is planned. Borrowed until the call returns, but for the log.
struct weft_separable_params {
    struct weft_kernel kernel; // default (info NULL): catmull-rom; not radial
    int size[2];               // samples along x and y (required)
    int width, height;         // pixels (required)
    const double *x, *y;       // the sample coordinate of every column and of every row (required);
                               // any order, any distance from the samples, finite; copied
    // What the kernel is stretched by along x and y (weft_stretch_weights), 1 to WEFT_STRETCH_MAX;
    // default 0: 1, the kernel as it is. Not of prefiltered kernels.
    double stretch[2];
    enum weft_boundary boundary; // what stands beyond the samples (default clamp)
    enum weft_axis_order order;  // default auto; roundings differ: parts of one picture have one
    enum weft_engine engine;     // that is to run it (default OpenGL)
    enum weft_sums sums;         // of products (default float); double: of the CPU engine alone
    // Textures, buffers and what is read back by way of; of the CPU engine weights, and what each
    // thread has at hand (default 1 GiB). The work is cut into rectangles that fit.
    uint64_t memory_bytes;
    const struct weft_log *log; // may be NULL; borrowed while the plan lives
};
#define WEFT_SEPARABLE_DEFAULTS
#define weft_separable_params(...)                                                                 \
    (&(struct weft_separable_params){WEFT_SEPARABLE_DEFAULTS __VA_ARGS__})

// What is filtered where: taps, and the order of the axes that fetches less for the whole. Pure; as
// many threads as like may read a plan at the same time.
typedef struct weft_separable_plan weft_separable_plan;

// Plans a filtering. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT (kernel, sizes, positions,
// stretches, enums), WEFT_ERR_UNSUPPORTED (radial kernels; prefiltered ones that are to
// be stretched; double sums on OpenGL), WEFT_ERR_LIMIT (weights: the log has their number) or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_separable_plan_create(const struct weft_separable_params *params,
                                                     weft_separable_plan **out);
WEFT_API void weft_separable_plan_destroy(weft_separable_plan **plan); // accepts &NULL, leaves NULL

// What a plan is: its parameters with their defaults filled in, and the order of the axes.
struct weft_separable_info {
    struct weft_kernel kernel;
    int size[2], width, height;
    double stretch[2]; // 1: the kernel as it is
    int taps[2];       // of every column, and of every row
    double gain[2];    // largest sum of |weights| of a column, and of a row; 1 at least
    enum weft_boundary boundary;
    enum weft_engine engine;
    enum weft_sums sums;
    int first_axis;           // that is filtered along: 0, x, or 1, y
    double fetches_per_pixel; // along both axes, without what rectangles repeat
};
// Valid while the plan lives.
WEFT_API const struct weft_separable_info *
weft_separable_plan_get_info(const weft_separable_plan *plan);

// ---- compiled plans -----------------------------------------------------------------------------

// A plan cut into rectangles for what runs it, with its programs, buffers and target, or its
// weights and its threads' memory. Thread-safety: one thread at a time, and of plans for OpenGL one
// at a time with whatever else uses the context.
typedef struct weft_separable weft_separable;

// Where a plan runs. Borrowed until the call returns, but for the context.
struct weft_separable_compile_params {
    weft_context *context; // of plans for OpenGL (required), which must outlive the result; of
                           // plans for the CPU engine NULL
    struct weft_cpu cpu;   // how those run (default: as fast as they can)
};
#define WEFT_SEPARABLE_COMPILE_DEFAULTS
#define weft_separable_compile_params(...)                                                         \
    (&(struct weft_separable_compile_params){WEFT_SEPARABLE_COMPILE_DEFAULTS __VA_ARGS__})

// Compiles a plan, which is borrowed and must outlive the result. Rectangles on software GLs and on
// the CPU are smaller than memory_bytes allows where that is faster, and fewer threads run where it
// does not hold what all of them need. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT (a
// context for a plan of the CPU engine, or none for one of OpenGL; threads, instructions),
// WEFT_ERR_UNSUPPORTED (instructions that do not run here), WEFT_ERR_LIMIT (what a rectangle needs,
// memory_bytes and the context's texels are in the log), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_separable_compile(const weft_separable_plan *plan,
                                                 const struct weft_separable_compile_params *params,
                                                 weft_separable **out);
WEFT_API void weft_separable_destroy(weft_separable **compiled); // accepts &NULL, leaves NULL

// ---- runs ---------------------------------------------------------------------------------------

// What decides how samples are summed: of all samples in reach of any of a plan's pixels, so that a
// part of them is made as the whole is. Parts of the samples are surveyed apart and joined, in any
// order.
struct weft_separable_survey {
    double largest;  // |finite sample|; of samples in double 0, whose sums leave no range
    bool not_finite; // a sample is NAN or infinite
};

// Samples in, pixels out. Borrowed until the call returns.
struct weft_separable_run_params {
    const float *samples; // [y][x], x fastest, tightly packed, at integer coordinates (required)
    const double *wide;   // in their place, of plans that sum in double: the same (default NULL)
    double border; // the value beyond all samples of the boundary of that name, finite (default 0)
    // The samples that are there, the first of which is sample (window.x, window.y) (default: all);
    // at least weft_separable_reach's of the part.
    struct weft_rectangle window;
    struct weft_rectangle part; // of the pixels that are made (default: all)
    // Required where the window lacks samples that any of the plan's pixels reach; default (NULL):
    // of the samples in reach of all pixels, which a caller of many parts surveys once.
    const struct weft_separable_survey *survey;
    // Pixel (x, y) is [(y - part.y) * stride + x - part.x] (required without a texture).
    float *pixels;
    int64_t stride; // floats from row to row (default the part's width)
    // Of plans for OpenGL: where pixels are drawn to, in the place of memory or as well, pixel (x,
    // y) to texel (x - part.x, y - part.y) of the rectangle. Nothing is read back for it, unless
    // samples are so large that sums are scaled (2^64 and more). Of pixels that are samples -0 may
    // have become 0, and what is below 2^-126 too (default NULL: none). Borrowed until the call
    // returns.
    const struct weft_texture *texture;
    // May be NULL. Asked by the calling thread, before every rectangle that is its own.
    const struct weft_progress *progress;
    const struct weft_log *log; // may be NULL
};
#define WEFT_SEPARABLE_RUN_DEFAULTS
#define weft_separable_run_params(...)                                                             \
    (&(struct weft_separable_run_params){WEFT_SEPARABLE_RUN_DEFAULTS __VA_ARGS__})

// What a run did. Of the CPU engine uploads, read-back, draws and programs are 0.
struct weft_separable_report {
    double prepare_seconds; // a look at the samples
    double upload_seconds;  // weights and samples
    double pass_seconds, readback_seconds;
    uint64_t uploaded_bytes; // samples, and weights that were not there from before
    uint64_t peak_bytes;     // of what memory_bytes limits
    int rectangles;
    int passes; // draws
    // 0, and 2 where samples that are not finite come for the first time.
    int programs_linked;
    struct weft_cpu cpu;           // what the CPU engine ran with; threads 0: OpenGL did
    struct weft_statistics pixels; // range and counts; no differences; count 0 without memory
};

// Returns the samples that a part of a plan's pixels (all 0: all of them) reads; all 0 for a part
// that is not within the pixels. Pure.
WEFT_API struct weft_rectangle weft_separable_reach(const weft_separable_plan *plan,
                                                    const struct weft_rectangle *part);

// Surveys those samples of a run's window that any of the plan's pixels reaches; of the params only
// samples or wide, window and log are looked at. Returns WEFT_ERR_ARGUMENT (pointers, a window that
// is not within the samples).
WEFT_API enum weft_result
weft_separable_survey_samples(const weft_separable_plan *plan,
                              const struct weft_separable_run_params *params,
                              struct weft_separable_survey *out);
// Adds what another part of the samples has; starts as {0}.
WEFT_API void weft_separable_survey_join(struct weft_separable_survey *sum,
                                         const struct weft_separable_survey *other);

// Whether finite samples of which the largest |sample| is this are summed as they are, whatever the
// plan: a survey then tells no more.
static inline bool weft_separable_is_safe(double largest)
{
    return largest < 0x1p64;
}

// Filters samples with a compiled plan. Only samples in reach of a pixel are uploaded; weights stay
// for the next run where one rectangle holds all of an axis. The pixels are the same for every
// memory_bytes, every number of threads and every part that they are in, bit for bit. A tap whose
// weight is exactly 0 does not count: pixels are not finite where a sample that counts is not, or
// where the result is beyond the range of floats, and nowhere else; sums do not leave that range on
// the way. Where both weights are 1 and all others 0 the pixel is the sample, bit by bit. Returns
// WEFT_ERR_ARGUMENT (stride, pointers, a part, a window without what the part or the survey needs,
// a texture that does not do, or one for the CPU engine), WEFT_ERR_MEMORY, WEFT_ERR_GL or
// WEFT_ERR_CANCELLED; pixels may then be written in part. report may be NULL.
WEFT_API enum weft_result weft_separable_run(weft_separable *compiled,
                                             const struct weft_separable_run_params *params,
                                             struct weft_separable_report *report);

// ---- errors -------------------------------------------------------------------------------------

// |pixel - exact| is at most this times the largest |sample| in reach, where sums stay within the
// range of floats and GL rounds to nearest. With u = 2^-24, n = the kernel's width and g = its gain
// (weft_analysis_gain), a weight is off by u, a product by another u and a sum of n terms by n
// - 1 more, so that each term of the two passes together carries 2 (n + 1) factors of up to 1 + u:
// the bound is g^2 ((1 + u)^(2 n + 2) - 1), and less where products and sums are rounded once. With
// sums in double u is 2^-53, and the pixel is rounded to a float: it is at most g^2 times the
// largest |sample| and what was off, of which that loses 2^-24.
// What is below 2^-126 GL may flush to zero: add
// 2^-125 (n + g) (1 + g) if samples are that small, and where some are so large that sums are
// scaled (g^2 times the largest is 2^127 or more), that times 4 g^2.
// Of prefiltered kernels samples are coefficients, and g is the kernel's own gain;
// weft_prefilter_error has the rest.
WEFT_API double weft_separable_error_bound(const struct weft_kernel *kernel, enum weft_sums sums);

// All terms of the bound, for weft_bound_compute: the above, what GL flushes to zero where the
// largest |sample| is `largest`, and weft_prefilter_error in 2D for coefficients whose filters are
// cut off at `cut`. With double sums what pixels are rounded by is a term of its own, 2^-24 of the
// largest result: where none overshoots the samples, within 6e-8 of the largest. Thread-safe; NAN
// for kernels that weft_kernel_check refuses.
WEFT_API struct weft_bound_terms weft_separable_bound_terms(const struct weft_kernel *kernel,
                                                            enum weft_sums sums, double largest,
                                                            double cut);

// The same of a plan, of which either axis may be stretched: n + 1 and g become the means of both
// axes' taps and the product of their gains, the largest sums of |weights| that the plan has.
WEFT_API double weft_separable_plan_error(const weft_separable_plan *plan);
WEFT_API struct weft_bound_terms weft_separable_plan_bound(const weft_separable_plan *plan,
                                                           double largest, double cut);

WEFT_END_DECLS
#endif
