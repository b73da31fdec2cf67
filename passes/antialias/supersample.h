// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/supersample.h - supersampling: a picture of one sample, moved, for each sample
// of a pixel, of all pixels or only of those that are marked (adaptive supersampling: Lin, Lau,
// Lin, Cheung 1997). Samples are filtered down by any kernel, shared by the pixels that they reach.
#ifndef WEFT_PASSES_ANTIALIAS_SUPERSAMPLE_H
#define WEFT_PASSES_ANTIALIAS_SUPERSAMPLE_H

#include "../accumulate/accumulate.h"
#include "drawing/drawing.h"
#include "marks/marks.h"
#include "pattern/pattern.h"

WEFT_BEGIN_DECLS

// Where samples are until they are filtered. Default: sums. Both give the same bytes.
enum weft_supersample_store {
    WEFT_STORE_SUMS,   // nowhere: each pass's are added up at once. The memory of one sample more
    WEFT_STORE_BLOCKS, // all samples of a marked pixel in a block of its own, at most one a pixel,
                       // in a compact list, as in the paper
    WEFT_STORE_COUNT
};
// NULL-ended, in the order of the enum: "sums", "blocks".
WEFT_API extern const char *const weft_supersample_store_names[];

struct weft_supersample_params {
    int32_t width, height; // of the picture, each > 0 (required)
    // Places of the samples in a pixel, x to the right, y down the rows, from the middle, and how
    // many; borrowed until weft_supersample_create returns. NULL: a grid of `count`, which is then
    // k^2: 4 x 4 of 16.
    const double (*position)[2];
    int count;                          // 1 to WEFT_PATTERN_MAX (default 16)
    struct weft_kernel filter;          // of a pixel (default nearest, a box of one pixel)
    double filter_width;                // pixels that its support is scaled to (default: as it is)
    enum weft_supersample_store store;  // default sums
    enum weft_antialias_format format;  // of what samples are drawn into (default 8 bits)
    enum weft_accumulate_method method; // how they are added up (default auto); weights below 0
                                        // need exact or float
    double background[4];               // linear, associated alpha
    weft_context *context;              // borrowed for the object's life (required)
    const struct weft_log *log;         // likewise; may be NULL
};
#define WEFT_SUPERSAMPLE_DEFAULTS
#define weft_supersample_params(...)                                                               \
    (&(struct weft_supersample_params){WEFT_SUPERSAMPLE_DEFAULTS __VA_ARGS__})

// Thread-safety: one thread at a time, with its context.
typedef struct weft_supersample weft_supersample;

// On failure *out is NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT, WEFT_ERR_UNSUPPORTED,
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_supersample_create(const struct weft_supersample_params *params,
                                                  weft_supersample **out);
WEFT_API void weft_supersample_destroy(weft_supersample **supersample); // accepts &NULL

// Draws a picture: one pass of stage colour a sample. marks: of this size; NULL: all pixels. Of a
// part of the picture they are to have the part and the filter's radius around it, as far as that
// is within the picture. Pixels are supersampled that are marked, or that a marked one is within
// the filter's radius of (weft_marks_dilate); they have the bytes that they have without marks. The
// others are left alone. progress: NULL: nobody asks. Returns WEFT_ERR_ARGUMENT (a part; marks of
// another size or part), WEFT_ERR_CANCELLED, what `draw` returned, WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_supersample_run(weft_supersample *supersample,
                                               const struct weft_antialias_drawing *drawing,
                                               const struct weft_marks *marks,
                                               const struct weft_progress *progress);

// Writes a channel (0 to 3) of the last picture, or of the part that was drawn, out[y * stride +
// x], rows upwards; stride 0: its width. Pixels that were not supersampled keep what stands in
// `out`. Returns WEFT_ERR_ARGUMENT (no picture, a channel), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_supersample_read(weft_supersample *supersample, int channel,
                                                float *out, size_t stride);

// What the last picture came to.
struct weft_supersample_report {
    int samples;
    int passes;                         // samples that the filter gives a weight: those are drawn
    double discrepancy;                 // of the samples in a pixel
    int radius;                         // pixels that a sample reaches to each side
    enum weft_accumulate_method method; // never auto
    int64_t pixels;                     // that were supersampled
    int64_t sampled; // pixels whose samples were drawn: those, and what the filter reaches, beyond
                     // a part, too
    // |value - exact filtered samples| <= bound + filter_bound * the largest |sample| (of 8 bits,
    // 1): what the sums make of frames, and what GL's floats make of samples in the filter; 0 of a
    // box.
    double bound, filter_bound;
    // By the paper's accounting with 3 bytes of colour and 4 of depth (weft_bytes_adaptive; of all
    // pixels full supersampling); of all that GL and memory hold for it.
    uint64_t formula_bytes, bytes;
};
WEFT_API void weft_supersample_get_report(const weft_supersample *supersample,
                                          struct weft_supersample_report *out);

WEFT_END_DECLS
#endif
