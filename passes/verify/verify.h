// SPDX-License-Identifier: BSD-3-Clause
// passes/verify/verify.h - how far pixels are from what they are meant to be, for every engine.
// One verifier goes through pixels, finds each one's exact value in double and writes one report.
// It trusts nothing of what it verifies but the request and its samples: it finds positions and
// weights anew and adds up as filter/analysis/reference.h does. weft_slice_verify,
// weft_separable_verify and weft_multipass_verify take what the engines take;
// weft_pixels_verify takes positions, samples and pixels in memory, whatever made them;
// weft_verify_add compares values that a caller knows himself.
//
// The rule, one for all. Values that are finite in the pixel and in the reference are compared.
// A reference that is finite, but beyond the range of floats, counts as that range's end; a pixel
// that is infinite with the same sign is right there, too. Where neither is finite they agree:
// which of NaN and the infinities it is does not count. Where one is finite and the other is not,
// that is a mismatch, and the error is infinite. Taps whose weight is exactly 0 do not count,
// whatever their sample holds. Where engines may round a position the other way, onto the other
// side of a jump or of a tap's border, the side that comes closer is the reference.
//
// Which pixels. All, if that takes no longer than max_seconds; else a sample: each pixel has a
// fixed number in [0, 1), a hash of its place and the seed (splitmix64: Steele, Lea and Flood,
// OOPSLA 2014), and those below a share are checked. The share follows from the work that the
// references are, counted, not timed: the same request checks the same pixels, in any cut of the
// image, on any machine, and a smaller share's pixels are among a larger one's. At least 64 are
// expected.
#ifndef WEFT_PASSES_VERIFY_VERIFY_H
#define WEFT_PASSES_VERIFY_VERIFY_H

#include <math.h>

#include "../../filter/analysis/reference.h"
#include "../multipass/multipass.h"
#include "../points/points.h"
#include "../separable/separable.h"
#include "../slice/slice.h"

WEFT_BEGIN_DECLS

// What a verification found. It is whole after every weft_verify_add.
struct weft_verify_report {
    uint64_t pixels_total, pixels_checked;
    uint64_t values_compared;       // of all channels of those: finite on both sides
    uint64_t not_finite_mismatches; // values that are finite on one side only
    // |pixel - reference|. maximum is INFINITY where there is a mismatch; squares, and rms, which
    // is sqrt(squares / values_compared), are over what was compared (0 where nothing was).
    double maximum, rms, squares;
    // Largest |pixel - reference| / largest |sample| in that pixel's reach; INFINITY likewise, and
    // where a pixel is off though all samples in reach are 0.
    double relative_maximum;
    double magnitude; // largest |sample| in reach of anything compared; prefiltered slices: by
                      // whole bricks
    // Of the maximum: where, the pixel and the reference. The first mismatch, if there is one.
    int at_x, at_y, at_channel;
    double at_value, at_reference;
    // What was promised of a pixel: |pixel - reference| <= bound_relative * largest |sample| in its
    // reach + bound_absolute, which is set before anything is added. NAN: nothing, or the caller
    // knows.
    double bound_relative, bound_absolute;
    double bound; // the same with `magnitude` for the largest |sample|
    double share; // largest |pixel - reference| / that pixel's own bound
};

// Adds a value: a pixel's channel beside its reference, whose magnitude is the largest |sample| in
// reach. Counts no pixel. Thread-safe for different reports.
WEFT_API void weft_verify_add(struct weft_verify_report *report, int x, int y, int channel,
                              double value, const struct weft_reference_value *reference);

// Adds what another part of the same pixels showed: the report of both is the one of all that was
// added to either, but that squares may be rounded otherwise. Of equal errors the first in rows is
// told. *sum starts as {0}, or as any report with the same bounds.
WEFT_API void weft_verify_join(struct weft_verify_report *sum,
                               const struct weft_verify_report *other);

// How pixels are verified. All zero is fine.
struct weft_verify_params {
    double max_seconds; // about so long on one core of 2020 (default 10); INFINITY: all pixels
    uint64_t seed;      // of the sample (default 0)
    const struct weft_progress *progress; // NULL is fine
    // Is told each value that is checked, with the reference that it was compared with: for
    // pictures of errors. In the calling thread. NULL: nobody asks. In slices `channel` is the
    // output's number.
    void (*tell)(void *priv, int x, int y, int channel, double value, double reference);
    void *tell_priv;
};
#define WEFT_VERIFY_DEFAULTS
#define weft_verify_params(...) (&(struct weft_verify_params){WEFT_VERIFY_DEFAULTS __VA_ARGS__})

// ---- slices -------------------------------------------------------------------------------------

// weft_verify_params, and what only volumes have.
struct weft_slice_verify_params {
    double max_seconds; // as in weft_verify_params
    uint64_t seed;
    const struct weft_progress *progress;
    // As in weft_verify_params, of each output in turn.
    void (*tell)(void *priv, int x, int y, int output, double value, double reference);
    void *tell_priv;
    weft_volume *rest; // the same grid opened with .rest: the reference is of both sums then, that
                       // is of the stored values (default NULL: of floats; prefiltered kernels:
                       // always)
};
#define WEFT_SLICE_VERIFY_DEFAULTS
#define weft_slice_verify_params(...)                                                              \
    (&(struct weft_slice_verify_params){WEFT_SLICE_VERIFY_DEFAULTS __VA_ARGS__})

// Verifies pixels[y * width + x] of a slice, or of the plan's part of it, from its corner on and of
// its width, of which the same pixels are checked; of several outputs, pixels[(o * height + y) *
// width + x]. `out` is an array, a report of each of the plan's outputs (of the value alone, one).
// Pixels are compared with what the volume's voxels make, without layouts or the GPU's positions;
// voxels that the plan's footprint keeps are not read again. Where a position is within 2^-32
// voxels of being rounded the other way, a pixel may be on either side of a jump, or of where a tap
// counts that is not finite. For prefiltered kernels the reference trusts no coefficient: it is the
// sum over the volume's voxels with the weights of the cardinal spline (weft_prefilter_weights, cut
// off at 2^-32, or farther out where voxels there are so much larger that they count), which takes
// hundreds of times as long. The bound is the plan's, for prefiltered kernels from what is measured
// of coefficients and voxels; bricks that the plan's footprint keeps are not read again for them
// either. params may be NULL. Returns WEFT_ERR_CANCELLED, WEFT_ERR_MEMORY and what weft_volume_read
// returns.
WEFT_API enum weft_result weft_slice_verify(const weft_slice_plan *plan, const float *pixels,
                                            const struct weft_slice_verify_params *params,
                                            struct weft_verify_report *out);

// ---- points -------------------------------------------------------------------------------------

// Verifies run->out, as weft_points_run wrote it, against direct sums over the volume's voxels at
// the points, which are read as they are needed. Point i is pixel (i, 0); `out` is an array, a
// report of each output, and max_seconds is of all of them. `report` is the run's: prefiltered
// kernels' bounds are of its values, which a run with `measure` has; their reference is a sum over
// samples (weft_prefilter_weights, cut off at 2^-40). params may be NULL. Returns
// WEFT_ERR_ARGUMENT (over 2^31 points), WEFT_ERR_CANCELLED, WEFT_ERR_MEMORY and what
// weft_volume_find and weft_volume_read return.
WEFT_API enum weft_result weft_points_verify(const weft_points *points,
                                             const struct weft_points_run_params *run,
                                             const struct weft_points_report *report,
                                             const struct weft_verify_params *params,
                                             struct weft_verify_report *out);

// ---- images -------------------------------------------------------------------------------------

// Verifies run->pixels, as weft_separable_run wrote them with a compiled `plan`, against the run's
// samples, which are floats (of prefiltered kernels, coefficients). The bound is
// weft_separable_plan_error's, without what GL flushes to 0. params may be NULL. Returns as
// weft_separable_run.
WEFT_API enum weft_result weft_separable_verify(const weft_separable_plan *plan,
                                                const struct weft_separable_run_params *run,
                                                const struct weft_verify_params *params,
                                                struct weft_verify_report *out);

struct weft_multipass_verify_params {
    const weft_pass_plan *plan; // required, as are samples and grid: those of the run
    const struct weft_samples *samples;
    const struct weft_pixel_grid *grid;
    const float *pixels[4]; // as a run left them
    int64_t stride;         // floats from row to row (default the grid's width)
    struct weft_verify_params how;
    const struct weft_log *log; // may be NULL
};
#define WEFT_MULTIPASS_VERIFY_DEFAULTS
#define weft_multipass_verify_params(...)                                                          \
    (&(struct weft_multipass_verify_params){WEFT_MULTIPASS_VERIFY_DEFAULTS __VA_ARGS__})

// Verifies pixels that weft_multipass_run wrote against its samples (of prefiltered kernels,
// coefficients), with the derived kernel along an axis where the plan has a derivative. The bound
// is NAN: it is the plan's, in units of the range. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT or
// WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_multipass_verify(const struct weft_multipass_verify_params *params,
                                                struct weft_verify_report *out);

// Values in memory, [z][y][x], borrowed.
enum weft_verify_type { WEFT_VERIFY_FLOAT, WEFT_VERIFY_UINT32 };
struct weft_verify_plane {
    const void *values; // required
    enum weft_verify_type type;
    int64_t stride; // values from row to row (default: as many as a row has)
};

// Positions, samples and pixels.
struct weft_pixels_verify_params {
    struct weft_kernel kernel[3]; // of each axis, of one width: a derivative along one of them,
                                  // say. Required is the first; info NULL: as the first
    int dims;                     // of the samples (default 2)
    const struct weft_pixel_grid *grid; // where the pixels lie, in the samples' coordinates
    // Of the grid's pixels those that are there and verified, of which pixels' first is number
    // (part.x, part.y) (default: all).
    struct weft_rectangle part;
    int size[3]; // samples along the axes that there are
    // What the first kernel is stretched by along x and y (weft_stretch_weights; default 0: 1), in
    // 2D and without a derivative.
    double stretch[2];
    enum weft_boundary boundary; // what stands beyond the samples (default clamp)
    double border;               // the value of the boundary of that name (default 0)
    // Whether references are held between the smallest and the largest finite sample at most as far
    // away along x and y as the kernel is stretched by (default false), in 2D.
    bool clamp;
    // Those that samples have, of which the first is number (window.x, window.y): at least what the
    // pixels reach (default: all, as in 3D and of cardinal splines they are).
    struct weft_rectangle window;
    int channels;                                   // 1 to 4 (default 1)
    struct weft_verify_plane samples[4], pixels[4]; // of each channel
    // Samples of a prefiltered kernel are the image's own, and the reference is the cardinal spline
    // (weft_prefilter_axis_set, cut off at 2^-32), in 2D alone. Else they are coefficients.
    bool cardinal;
    double bound_relative, bound_absolute; // for the report (default NAN)
    struct weft_verify_params how;
    const struct weft_log *log;
};
#define WEFT_PIXELS_VERIFY_DEFAULTS .bound_relative = NAN, .bound_absolute = NAN,
#define weft_pixels_verify_params(...)                                                             \
    (&(struct weft_pixels_verify_params){WEFT_PIXELS_VERIFY_DEFAULTS __VA_ARGS__})

// Verifies pixels against samples. Returns WEFT_ERR_ARGUMENT (kernels, sizes, strides, positions
// that are not finite, pointers), WEFT_ERR_UNSUPPORTED (cardinal splines other than in 2D),
// WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_pixels_verify(const struct weft_pixels_verify_params *params,
                                             struct weft_verify_report *out);

WEFT_END_DECLS
#endif
