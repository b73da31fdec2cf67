// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/accumulative.h - accumulative anti-aliasing: depths at many samples of a pixel,
// but one sum of colours. A first pass finds the depths; then every fragment that is visible adds
// its colour, weighted by how many samples it has. Enderton, Lum, Rouet, Kuznetsov, "Accumulative
// Anti-Aliasing", 2015.
#ifndef WEFT_PASSES_ANTIALIAS_ACCUMULATIVE_H
#define WEFT_PASSES_ANTIALIAS_ACCUMULATIVE_H

#include "drawing/drawing.h"
#include "pattern/bytes.h"
#include "pattern/pattern.h"

WEFT_BEGIN_DECLS

// How a fragment learns which of its samples are visible. Default: auto. The first two give the
// same bytes.
enum weft_acaa_form {
    WEFT_ACAA_AUTO,       // the first of those below that the context has
    WEFT_ACAA_POST_DEPTH, // ARB_post_depth_coverage, image atomics (GL 4.2)
    WEFT_ACAA_SAMPLE_ID,  // a call of the shader for each sample, early tests and image atomics (GL
                          // 4.2): the shading of MSAA times the samples
    // GL 3.3: a picture of one sample for each of them (weft_supersample), at the same places,
    // moved and added up. Every sample is shaded where it is, not in the pixel's middle. Vertices
    // are snapped to 1/256 of a pixel anew in every picture, so that samples within 1/128 of an
    // edge may lie on its other side; all others show the same surface. `coincident` and
    // `depth_bits` have nothing to do, and weights are not counted: they are reported as right.
    WEFT_ACAA_JITTER,
    WEFT_ACAA_FORM_COUNT
};
// NULL-ended, in the order of the enum: "auto", "post-depth", "sample-id", "jitter".
WEFT_API extern const char *const weft_acaa_form_names[];

// What is done about surfaces in the same place, whose samples would count once for each of them.
// Default: stencil.
enum weft_acaa_coincident {
    WEFT_COINCIDENT_STENCIL, // each sample counts for the first that is drawn: stencil bits, and
                             // the same picture every time
    WEFT_COINCIDENT_MASK,    // a mask of claimed samples for each pixel: any one of them, not
                             // always the same one on GPUs
    WEFT_COINCIDENT_ALPHA,   // a pixel's weight is cut off at all its samples, as with saturated
                             // alpha (section 2 of the paper): what comes later counts less, though
                             // its samples may be nobody else's
    WEFT_COINCIDENT_NONE,    // they count more than once
    WEFT_COINCIDENT_COUNT
};
// NULL-ended, in the order of the enum: "stencil", "mask", "alpha", "none".
WEFT_API extern const char *const weft_acaa_coincident_names[];

// What colours are added up in.
enum weft_acaa_sums {
    WEFT_ACAA_INTEGER, // colours as integers of a scale: the sum is exact, in any order
    WEFT_ACAA_FLOAT,   // floats, by compare and exchange (GL 4.5); rounded at each addition, in any
                       // order
    WEFT_ACAA_SUMS_COUNT
};
// NULL-ended, in the order of the enum: "integer", "float".
WEFT_API extern const char *const weft_acaa_sums_names[];

struct weft_acaa_params {
    int32_t width, height;    // of the picture, each > 0 (required)
    int samples;              // of a pixel, 1 to WEFT_PATTERN_MAX (default 4). More than the
                              // device has come from several passes of as many as it has
    enum weft_acaa_form form; // default auto
    enum weft_acaa_coincident coincident; // default stencil
    struct weft_kernel filter;            // of a pixel (default nearest, a box of one pixel)
    double filter_width;      // pixels that its support is scaled to (default: as it is)
    enum weft_acaa_sums sums; // default integer
    // Of integers: the largest |component| of a colour. What is beyond is found while drawing, and
    // the picture is drawn again with the range that it needs. Default 0: 1 at first, then that of
    // the picture before.
    double range;
    int depth_bits;             // 24 or 32 (floats) (default 24)
    double background[4];       // linear, associated alpha: what samples without a surface have
    weft_context *context;      // borrowed for the object's life (required)
    const struct weft_log *log; // likewise; may be NULL
};
#define WEFT_ACAA_DEFAULTS
#define weft_acaa_params(...) (&(struct weft_acaa_params){WEFT_ACAA_DEFAULTS __VA_ARGS__})

// Targets, images and heads for pictures of one size. Thread-safety: one thread at a time, with its
// context.
typedef struct weft_acaa weft_acaa;

// Makes what pictures need. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT
// (size, samples; the log has both numbers), WEFT_ERR_UNSUPPORTED (a form that the context has not;
// kernels as weft_spread_create), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_acaa_create(const struct weft_acaa_params *params, weft_acaa **out);
WEFT_API void weft_acaa_destroy(weft_acaa **acaa); // accepts &NULL, leaves NULL behind

// Draws a picture. It may be called again and again. progress: NULL: nobody asks. Of a part of the
// picture the report tells of its own pixels. Its sums of integers have the whole picture's bytes
// if they had room for the same (weft_acaa_set_room); those of floats, and weights that are cut off
// (WEFT_COINCIDENT_ALPHA), depend on the order of fragments, which GL keeps for fragments of one
// pixel only. Returns WEFT_ERR_ARGUMENT (nothing to draw, a part), WEFT_ERR_CANCELLED, what `draw`
// returned, WEFT_ERR_LIMIT (colours beyond what sums hold),
// WEFT_ERR_FORMAT (colours that are not finite), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_acaa_run(weft_acaa *acaa,
                                        const struct weft_antialias_drawing *drawing,
                                        const struct weft_progress *progress);

// What sums of integers have room for, from which their scale follows. It grows from picture to
// picture with what is drawn, and never shrinks. That of a whole picture is the largest of its
// parts', each drawn with the room that there was before; parts that had less are drawn again with
// it. Form jitter and floats need none: theirs is {0}.
struct weft_acaa_room {
    double range;  // largest |component| of a colour, at first params.range
    double weight; // of a pixel, as a share of all its samples, at first 1
};
WEFT_API void weft_acaa_get_room(const weft_acaa *acaa, struct weft_acaa_room *out);
// For pictures from now on, be it less than before. Returns WEFT_ERR_ARGUMENT (less than at first,
// or what is not finite) or WEFT_ERR_LIMIT (sums cannot); it is then as before.
WEFT_API enum weft_result weft_acaa_set_room(weft_acaa *acaa, const struct weft_acaa_room *room);

// Writes a channel (0 to 3: R, G, B, alpha) of the last picture, or of the part that was drawn,
// out[y * stride + x], rows upwards as GL has them; stride 0: its width. Each value is the exact
// mean of integers, rounded once; samples that nobody counted show the background. Returns
// WEFT_ERR_ARGUMENT (no picture, a channel).
WEFT_API enum weft_result weft_acaa_read(const weft_acaa *acaa, int channel, float *out,
                                         size_t stride);

// Writes each pixel's weight as a share of what it is to be: 1 everywhere unless something is
// wrong. Rows and stride as above. Returns WEFT_ERR_ARGUMENT (no picture).
WEFT_API enum weft_result weft_acaa_read_weight(const weft_acaa *acaa, float *out, size_t stride);

// What the last picture came to.
struct weft_acaa_report {
    enum weft_acaa_form form; // never auto
    const char *why;          // why this one, in words
    int samples, device_samples, passes;
    double discrepancy; // of the samples in a pixel
    int radius;         // pixels that a sample reaches to each side
    // The self-check: pixels whose weights are less than they should be (discard, alpha below 1,
    // depths that differ between passes) or more (coincident surfaces), before any cutting off;
    // where the first of each are, x and y, rows upwards (-1: none), and the largest departure, as
    // a share of what it should be.
    int64_t less, more;
    int32_t first_less[2], first_more[2];
    double largest;
    double range, scale; // of integers: of a colour; integers for each unit of it (0 of floats)
    int redone;          // times that it was drawn again for its range
    // Of |picture - exact mean of the colours that were written, by weights of the filter|, where
    // the self-check finds nothing: half a unit of the integers, what weights' rounding makes, the
    // float that is read; of form jitter of colours up to `range`.
    double bound;
    uint64_t formula_bytes, bytes; // weft_bytes_accumulative; of all that GL holds for it
    uint64_t callbacks;            // so far
};
WEFT_API void weft_acaa_get_report(const weft_acaa *acaa, struct weft_acaa_report *out);

WEFT_END_DECLS
#endif
