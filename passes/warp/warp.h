// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/warp.h - the call for images under any map: rotated, sheared, in perspective, or with
// a position given for every pixel; planes of floats to planes of floats.
//
// Coordinates. Sample (i, j) of the source is the unit square from (i, j) to (i + 1, j + 1), with
// its centre at (i + 0.5, j + 0.5), x to the right, y down: row 0 is on top. Pixels of the result
// lie likewise. A map may count from elsewhere: `source_corner` is where the first sample's square
// begins in its coordinates, `result_corner` where the first pixel's does.
//
// Maps. A matrix takes points of the source to points of the result, as people mean it: (x', y',
// w') = M (x, y, 1), and the point is (x' / w', y' / w'). It is inverted once, in double; that
// inverse is the definition of where pixels lie. Or two planes give, for every pixel, the point of
// the source that it shows.
//
// Filtering. Where neighbouring pixels lie more than a sample apart the kernel is stretched
// (filter/kernels/stretch.h) along each axis of the source by itself: by sx = sqrt((dx/du)^2 +
// (dx/dv)^2) along x and likewise along y, u and v being the axes of the result, and never less
// than 1. The footprint of a pixel is thus a rectangle along the source's axes, not an ellipse:
// where a map turns and minifies unequally it is the one around it, which blurs a little more than
// an ellipse would and does not alias. Of matrices the derivatives are those of the map at the
// pixel's centre; of positions half the difference between its two neighbours along a row and along
// a column, at the borders the difference to the one neighbour, 0 where there is none. Scales of up
// to WEFT_WARP_SCALE_NONE count as 1.
//
// A request is made in steps, as those of passes/resample/resample.h: plan, compile, source (that
// room's weft_resample_source), run, verify. Where each axis of the result follows one of the
// source (matrices of scales, flips, translations and quarter turns) pixels are filtered along one
// axis after the other, channel by channel, by passes/separable; where the axes are swapped its
// pixels are transposed. All others are filtered one by one, all channels with the same weights, on
// OpenGL (channels in one texel) or on the CPU engine. All read the same positions, formed in
// double on the CPU. Where an interpolating kernel's pixels lie on samples (quarter turns, flips,
// whole translations) they are the samples, bit for bit; and a mere change of size has the bytes
// that passes/resample makes where both have the same positions and scales.
//
// The same request gives the same bytes, whatever part of the pixels is made, and whatever memory
// and threads there are.
#ifndef WEFT_PASSES_WARP_WARP_H
#define WEFT_PASSES_WARP_WARP_H

#include "../../filter/boundary.h"
#include "../resample/resample.h"

WEFT_BEGIN_DECLS

// Points of the source lie within this of 0, in samples; and samples that a stretched kernel may
// meet along an axis, at most.
enum { WEFT_WARP_MAX_POSITION = 1 << 28, WEFT_WARP_MAX_TAPS = 4096 };
// Scales up to this are none: what rounding makes of 1 in a rotation's.
#define WEFT_WARP_SCALE_NONE (1.0 + 0x1p-20)

// ---- maps ---------------------------------------------------------------------------------------

enum weft_warp_kind {
    WEFT_WARP_MATRIX,    // the default
    WEFT_WARP_POSITIONS, // a point of the source for every pixel
};

// Where the pixels of a result lie in a source. All zero: each pixel is the sample of its place.
struct weft_warp_map {
    enum weft_warp_kind kind;
    // Row by row, source to result. Default (all 0): the identity. It must have an inverse, and
    // its horizon (the points of the result that show what is infinitely far away) may not meet the
    // result's pixels.
    double matrix[9];
    // Of positions: x and y of the point that pixel (u, v) shows, at [v * stride + u]. Finite, and
    // within WEFT_WARP_MAX_POSITION. Borrowed for the plan's life.
    const float *position[2];
    int64_t stride; // floats from row to row (default: the result's width)
    double source_corner[2], result_corner[2];
};

// Sets a matrix to (a c e; b d f; 0 0 1) of numbers a to f: x' = a x + c y + e, y' = b x + d y + f,
// the order of SVG, CSS, PostScript and of ImageMagick's AffineProjection. Pure.
WEFT_API void weft_warp_matrix_affine(const double numbers[6], double out[9]);
// Sets a matrix to a rotation about a point: counter-clockwise as seen with row 0 on top, in
// degrees. Multiples of 90 degrees are exact. An angle that is not finite makes a matrix that is
// none. Pure.
WEFT_API void weft_warp_matrix_rotate(double degrees, const double centre[2], double out[9]);

// ---- plan ---------------------------------------------------------------------------------------

struct weft_warp_params {
    struct weft_warp_map map;
    struct weft_kernel kernel;   // default (info NULL): catmull-rom; not radial
    int size[2];                 // samples along x and y (required, as in weft_resample_params)
    int width, height;           // pixels (default: as many as samples; likewise)
    enum weft_boundary boundary; // what stands beyond the samples (default clamp); the source's
    // Whether kernels stay as they are where pixels lie more than a sample apart (default false).
    bool unstretched;
    // Whether pixels are held between the smallest and the largest finite sample next to them,
    // which are those at most one sample away along each axis, or the scale where that is larger
    // (default false).
    bool clamp;
    enum weft_engine engine;    // default OpenGL
    enum weft_sums sums;        // default float; double: of the CPU engine alone
    uint64_t memory_bytes;      // what a run may take beside planes (default 1 GiB)
    const struct weft_log *log; // may be NULL; borrowed for the plan's life
};
#define WEFT_WARP_DEFAULTS
#define weft_warp_params(...) (&(struct weft_warp_params){WEFT_WARP_DEFAULTS __VA_ARGS__})

typedef struct weft_warp_plan weft_warp_plan; // Thread-safety: read-only once made.

// What kind of map it is.
enum weft_warp_method {
    WEFT_WARP_ALIGNED,    // a matrix, each axis of the result following one of the source
    WEFT_WARP_AFFINE,     // another matrix, steps from pixel to pixel being all alike
    WEFT_WARP_PROJECTIVE, // a matrix, with a horizon
    WEFT_WARP_PLANES,     // positions that are given
};
// NULL-ended, in the order of the enum: "aligned", "affine", "projective", "positions".
WEFT_API extern const char *const weft_warp_method_names[];

struct weft_warp_info {
    struct weft_kernel kernel;
    int size[2], width, height;
    enum weft_boundary boundary;
    bool unstretched, clamp;
    enum weft_engine engine;
    enum weft_sums sums;
    enum weft_warp_method method;
    bool moves; // a kernel that takes one sample, and is not stretched: pixels are samples
    // Of matrices: result to source, from pixel indices to sample indices, whose centres are whole
    // numbers: x = (m[0] u + m[1] v + m[2]) / w, y = (m[3] u + m[4] v + m[5]) / w, w = m[6] u +
    // m[7] v + m[8]. Of positions all 0.
    double inverse[9];
    // Along x and y of the source: the largest scale by which kernels are stretched (1: none is),
    // of projective maps at most that; and samples that meet at a pixel, at most.
    double scale[2];
    int taps[2];
    // Coefficients beyond the samples that are read on every side; 0 but for prefiltered kernels.
    int overlap;
    struct weft_bound_terms bound; // of |result - exact|
    const char *text;              // the plan in words, lines ended
};

// Plans. Returns WEFT_ERR_ARGUMENT (sizes, enums; a matrix that is not finite, singular, or whose
// horizon the result's pixels meet; positions that are not finite or too far away: the log has the
// numbers), WEFT_ERR_UNSUPPORTED (radial kernels; prefiltered ones that would be stretched, or with
// another boundary than clamp; double sums on OpenGL), WEFT_ERR_LIMIT (more than WEFT_WARP_MAX_TAPS
// samples, or of aligned maps what weft_separable_plan_create says) or WEFT_ERR_MEMORY; *out is
// then NULL.
WEFT_API enum weft_result weft_warp_plan_create(const struct weft_warp_params *params,
                                                weft_warp_plan **out);
WEFT_API void weft_warp_plan_destroy(weft_warp_plan **plan); // accepts &NULL
WEFT_API const struct weft_warp_info *weft_warp_plan_get_info(const weft_warp_plan *plan);

// Writes where a pixel lies among the samples, whose centres are whole numbers here, and by what
// the kernel is stretched there along x and y; NAN for pixels that are none. Pure.
WEFT_API void weft_warp_position(const weft_warp_plan *plan, int x, int y, double position[2],
                                 double scale[2]);

// ---- compile ------------------------------------------------------------------------------------

// A plan ready to run. Thread-safety: one thread at a time, the one of its context where it has
// one.
typedef struct weft_warp_compiled weft_warp_compiled;

// Makes a plan ready, which is borrowed for the life of *out, where weft_resample_compile_params
// says. Returns what weft_resample_compile does.
WEFT_API enum weft_result weft_warp_compile(const weft_warp_plan *plan,
                                            const struct weft_resample_compile_params *params,
                                            weft_warp_compiled **out);
WEFT_API void weft_warp_compiled_destroy(weft_warp_compiled **compiled); // accepts &NULL

// ---- run ----------------------------------------------------------------------------------------

struct weft_warp_run_params {
    const weft_resample_source *source; // required: of all samples, of the plan's size, kernel and
                                        // boundary
    struct weft_rectangle part;         // of the pixels that are made (default: all)
    // As many as the source's channels (required): pixel (x, y) is plane[c][(y - part.y) * stride +
    // x - part.x]. They may not overlap each other or the source's planes.
    float *plane[WEFT_RESAMPLE_MAX_CHANNELS];
    int64_t stride; // floats from row to row, at least the part's width (default that)
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;           // may be NULL
};
#define WEFT_WARP_RUN_DEFAULTS
#define weft_warp_run_params(...)                                                                  \
    (&(struct weft_warp_run_params){WEFT_WARP_RUN_DEFAULTS __VA_ARGS__})

// Fills the part's pixels of every channel. Pixels with a tap whose sample is not finite, and whose
// weight is not 0, are not finite, and no others. Returns WEFT_ERR_ARGUMENT (a source of another
// size, kernel or boundary, or of a window; a part, stride, pointers), WEFT_ERR_LIMIT
// (memory_bytes), WEFT_ERR_MEMORY, WEFT_ERR_GL or WEFT_ERR_CANCELLED; pixels may then be written in
// part. report may be NULL: of its work tiles, times, uploaded_bytes, peak_bytes, draws and cpu are
// set.
WEFT_API enum weft_result weft_warp_run(weft_warp_compiled *compiled,
                                        const struct weft_warp_run_params *params,
                                        struct weft_resample_report *report);

// Returns how far results may be off, the largest of which is `result` (0: not known yet), in the
// source's values: the plan's terms, by weft_bound_compute.
WEFT_API struct weft_bound weft_warp_bound(const weft_warp_plan *plan,
                                           const struct weft_resample_statistics *statistics,
                                           double result);

// ---- verify -------------------------------------------------------------------------------------

// Verifies pixels against the source's samples, in double: positions as weft_warp_position gives
// them, weights of weft_stretch_weights, and for prefiltered kernels the cardinal spline over the
// samples themselves. The bound is weft_warp_bound's for any result. Returns WEFT_ERR_ARGUMENT,
// WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_warp_verify(const weft_warp_plan *plan,
                                           const struct weft_resample_verify_params *params,
                                           struct weft_verify_report *out);

WEFT_END_DECLS
#endif
