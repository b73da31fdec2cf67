// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/fused.h - plans of cuts through volumes in one pass over all taps, or one axis after
// the other.
// Pixel (x, y) of a W x H slice samples origin + (x+0.5) u / W + (y+0.5) v / H. Positions are
// formed in double and rounded to multiples of 2^-29 voxels, half-way up: what is whole, or
// half-way between two voxels, in exact arithmetic is so in every engine, and exactly the same for
// every tiling of the output. With one layout pixels are, too, in every bit; aligned rows sum their
// taps in another order than the other two, and the automatic layout depends on memory_bytes: name
// one where the bytes must not. The kernel's weights come from polynomial tiles made in double;
// sums are single precision. One pass reads a row of four samples per fetch where the layout allows
// (dot4; Hadwiger, Hauser, Moeller 2003, section 6). On the lattice an interpolating kernel so
// gives the voxels, bit by bit (below 2^-126 GL may flush to 0). Where a kernel jumps, the value at
// the jump is that from the right: nearest takes the voxel toward +infinity half-way between two,
// along every axis. Values that floats do not stand: a tap whose weight is exactly 0 does not
// count, whatever the voxel holds, and any other one that is NaN or infinite makes its pixels NaN
// or infinite. Sums do not overflow where the result is a float; where it is none, the pixel is
// infinite. Pixels near such voxels are computed in double on the CPU.
#ifndef WEFT_PASSES_FUSED_FUSED_H
#define WEFT_PASSES_FUSED_FUSED_H

#include "../../filter/analysis/bound.h"
#include "../../filter/quantity.h"
#include "../../filter/rectangle.h"
#include "../../tiles/volume/layout.h"
#include "../cpu/cpu.h"
#include "../positions/footprint.h"
#include "resident.h"

WEFT_BEGIN_DECLS

// How the kernel's weights are had for a fraction: from polynomial tiles, exact to single
// precision, or from tiles of `samples` samples.
enum weft_lookup { WEFT_LOOKUP_POLYNOMIAL, WEFT_LOOKUP_LINEAR, WEFT_LOOKUP_NEAREST };
// NULL-ended, in the order of the enum: "polynomial", "linear", "nearest".
WEFT_API extern const char *const weft_lookup_names[];

// What a slice may save, as bits. All is saved that can be unless it is asked to do without.
enum weft_saving {
    WEFT_SAVING_CONSTANT = 1,  // cells whose voxels in reach are all the same are not convolved,
                               // where the kernel's weights add up to one: the value is exact
    WEFT_SAVING_AXIS = 2,      // where all pixels have one coordinate along an axis, voxels are
                               // summed along it once; the rest is 2D. Planes beyond the first and
                               // last one with a weight are not read
    WEFT_SAVING_SEPARABLE = 4, // where moreover rows and columns run along the other two axes, the
                               // slice is magnified along one after the other
    WEFT_SAVING_SMOOTH = 8,    // cells that linear interpolation, or one value, does within
                               // smooth_error, by a bound from their second differences (range)
    WEFT_SAVING_ALL = 15,
};
// NULL-ended, in the order of the bits: "constant", "axis", "separable", "smooth".
WEFT_API extern const char *const weft_saving_names[];

// Which slice is planned, and what it may cost. Borrowed until the call returns, but for the log
// and the footprint.
struct weft_slice_params {
    struct weft_kernel kernel;           // default (info NULL): catmull-rom
    enum weft_space space;               // of the geometry (default world)
    struct weft_slice_geometry geometry; // required; weft_slice_axis_geometry helps
    // What these three and the volume reach, made before and shared with other plans, which so read
    // voxels once (default NULL: the plan makes its own). It is held for the plan's life.
    weft_footprint *footprint;
    // What stays of the volume from slice to slice, made for the engine and its context (default
    // NULL: the slice has its voxels to itself). Held until the plan is destroyed: blocks are read
    // where they are, or added, and bricks likewise where no blocks are read. Layout, source, low
    // and high are then its own: what is given here must be the default, or the same.
    weft_resident *resident;
    // Which pixels are planned, and then run (default all 0: all). They are those of the whole
    // slice, bit for bit: the automatic layout, the order of axes and what cells need are the whole
    // slice's. Bricks beyond what these pixels' cells reach are not read. With the automatic layout
    // on OpenGL the whole slice is planned as well, to choose: name the layout that another plan of
    // it chose where there are many parts.
    struct weft_rectangle part;
    // What is made of every pixel: partial derivatives, in index space whatever `space` is (filter/
    // quantity.h), all in one pass over the same voxels; borrowed until the call returns. Default
    // count 0: the value alone.
    const struct weft_derivative *derivative;
    int derivative_count;           // to WEFT_DERIVATIVES
    enum weft_engine engine;        // that is to run it (default OpenGL)
    enum weft_sums sums;            // of products (default float); double: of the CPU engine alone
    enum weft_layout layout;        // of voxels in the texture buffer (default auto, which goes by
                                    // memory_bytes; pixels differ by rounding)
    enum weft_source_format source; // how voxels are stored there (default float)
    double low, high; // of a source that is not float: the range it holds, finite and low < high;
                      // voxels outside are clamped to it (see weft_footprint_statistics)
    enum weft_lookup lookup; // of weights (default polynomial)
    int samples;             // M of the tiles of linear and nearest look-up, 1 to 1024 (default 64)
    unsigned without;        // savings to do without, bits of enum weft_saving (default: none)
    double smooth_error;   // by which cheaper pieces may be off, in the volume's values (default 0:
                           // no such pieces)
    bool clamp_to_samples; // each pixel to the range of the samples next to it (2 along each axis,
                           // 3 for kernels of odd width): no ringing. Not with savings along axes
    bool may_miss;         // no warning where all pixels are background (default: there is one)
    uint64_t memory_bytes; // voxels, layouts and GL memory while running (default 1 GiB); the
                           // caller's pixels are not counted
    int max_target_size;   // of the GL to run on, pixels along a side (default 4096)
    int64_t max_buffer_texels;            // likewise; see struct weft_context_info (default 2^26)
    const struct weft_progress *progress; // of planning, which visits every pixel; may be NULL
    const struct weft_log *log;           // borrowed for the plan's life
};
#define WEFT_SLICE_DEFAULTS
#define weft_slice_params(...) (&(struct weft_slice_params){WEFT_SLICE_DEFAULTS __VA_ARGS__})

// One rectangle of the output, with the data it needs resident at once. With cheaper pieces on
// OpenGL, which draws squares of 32 x 32 pixels, it may reach beyond the part that was asked for.
struct weft_slice_tile {
    int x, y, width, height;
    uint64_t bricks_read;    // handed over by the reader
    uint64_t cells;          // 8x8x8 cells with at least one pixel's tap origin in them
    uint64_t cells_laid_out; // of those, the ones that need voxels (others are constant)
    uint64_t memory_bytes;   // voxels + layout + table + target; not what is resident
};

// A planned slice. Thread-safety: one thread at a time, for a plan and its footprint together.
typedef struct weft_slice_plan weft_slice_plan;

// One of the results that a plan makes of every pixel.
struct weft_slice_output {
    struct weft_derivative derivative;
    // The terms of |result - exact| that weft_bound_compute adds up for values that were measured.
    // Exact is the result of the numbers that the grid stores: doubles are half a unit of a float
    // off, integers up to weft_volume_info.largest_rounding.
    struct weft_bound_terms bound;
    // The same of voxels alone, whatever their coefficients: |result - exact| <= error_bound *
    // largest |voxel| in reach + error_beyond * largest |voxel| farther away + error_absolute.
    // Prefiltered kernels read coefficients, which may be much larger than voxels, and mostly are
    // not: error_bound is far above weft_bound_compute's for them.
    double error_bound, error_beyond, error_absolute;
};

// What a plan is: the parameters with their defaults filled in, and what they came to. It belongs
// to the plan and lives as long.
struct weft_slice_plan_info {
    struct weft_kernel kernel;
    struct weft_slice_geometry geometry; // as asked for
    enum weft_space space;
    struct weft_slice_geometry index_geometry; // the same in index space
    struct weft_rectangle part;                // that is planned; never all 0
    enum weft_engine engine;
    enum weft_sums sums;
    enum weft_layout layout;
    int fetches_per_pixel; // of the source
    int tile_count;
    const struct weft_slice_tile *tiles;
    uint64_t bricks_read;  // sum over tiles
    uint64_t memory_bytes; // of the largest tile
    bool misses_volume;    // no pixel comes near an active voxel; of parts no warning tells it
    // Prefiltered kernels: voxels on either side of the taps that count as in reach too, since
    // their coefficients depend on them; 0 for others.
    int prefilter_overlap;
    int output_count; // the params' derivatives, in their order; 1: the value alone
    struct weft_slice_output output[WEFT_DERIVATIVES];
    enum weft_source_format source;
    enum weft_lookup lookup;
    int samples;        // of tiles that are sampled, else segments of polynomials
    int weight_vectors; // of four coefficients, that a pixel's weights along an axis are made of
    uint64_t source_texels; // laid out, or summed samples of planes; over all tiles
    unsigned savings;       // bits of enum weft_saving: those that can save something here
    double smooth_error;    // the params', 0 where cheaper pieces cannot save anything
    int summed_axis;        // 0 to 2: voxels are summed along it before; -1: none
    int summed_taps;        // of the kernel's along that axis, those with a weight
    const char *text;       // the plan as --explain prints it, one line per tile and pass
};

// A prefiltered kernel (weft_kernel_make_prefiltered) reads coefficients in place of voxels, which
// weft_volume_prefilter computes: bricks, ranges and memory are then those of coefficients,
// `volume` must outlive the plan, and runs take up to 64 MiB more. NaN and infinity stay in their
// voxel. Not with clamp_to_samples; source formats hold a range of coefficients.
//
// Finds what the slice touches, cuts it into tiles that fit, and chooses the layout. Reads no
// voxel. Returns WEFT_ERR_ARGUMENT (sizes, edge vectors zero, parallel or not finite, part, kernel,
// range of the source, samples of tiles, smooth_error; a resident volume of other voxels, layout or
// engine, or for other kernels), WEFT_ERR_LIMIT (memory, index range; a resident volume that does
// not hold the smallest tile's blocks), WEFT_ERR_UNSUPPORTED (radial kernels; double sums on
// OpenGL; layouts and sources that the CPU engine has not; see above), WEFT_ERR_MEMORY,
// WEFT_ERR_CANCELLED, and what weft_volume_find returns.
WEFT_API enum weft_result weft_slice_plan_create(weft_volume *volume,
                                                 const struct weft_slice_params *params,
                                                 weft_slice_plan **out);
WEFT_API void weft_slice_plan_destroy(weft_slice_plan **plan); // accepts &NULL
WEFT_API const struct weft_slice_plan_info *weft_slice_plan_get_info(const weft_slice_plan *plan);
// What the plan's slice reaches, with the statistics of the voxels there: the plan's own, to be
// used and not destroyed.
WEFT_API weft_footprint *weft_slice_plan_get_footprint(const weft_slice_plan *plan);

WEFT_END_DECLS
#endif
