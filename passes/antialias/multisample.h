// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/multisample.h - multisampling as GL has it, with a colour and a depth for every
// sample: what accumulative anti-aliasing is compared with; and with 1 sample, no anti-aliasing.
#ifndef WEFT_PASSES_ANTIALIAS_MULTISAMPLE_H
#define WEFT_PASSES_ANTIALIAS_MULTISAMPLE_H

#include "drawing/drawing.h"
#include "pattern/bytes.h"
#include "pattern/pattern.h"

WEFT_BEGIN_DECLS

// How samples become a pixel. Default: GL's own way.
enum weft_msaa_resolve {
    WEFT_MSAA_BLIT, // glBlitFramebuffer
    WEFT_MSAA_SUM,  // the exact mean of all samples' colours as integers, round(colour * scale)
    WEFT_MSAA_RESOLVE_COUNT
};
// NULL-ended, in the order of the enum: "blit", "sum".
WEFT_API extern const char *const weft_msaa_resolve_names[];

struct weft_msaa_params {
    int32_t width, height; // of the picture, each > 0 (required)
    // Of a pixel, or the next larger number that the device has (default 4). 1: no anti-aliasing.
    int samples;
    enum weft_antialias_format format; // of samples' colours (default 8 bits)
    enum weft_msaa_resolve resolve;    // default GL's
    // Of sums: the largest |component| of a colour, 2^-60 to 2^60 (default 1); the background's are
    // within it in any case. Colours beyond are an error.
    double range;
    int depth_bits;             // 24, or 32 (floats) (default 24)
    double background[4];       // linear, associated alpha: what samples without a surface have
    weft_context *context;      // borrowed for the object's life (required)
    const struct weft_log *log; // likewise; may be NULL
};
#define WEFT_MSAA_DEFAULTS
#define weft_msaa_params(...) (&(struct weft_msaa_params){WEFT_MSAA_DEFAULTS __VA_ARGS__})

// Targets for pictures of one size. Thread-safety: one thread at a time, with its context.
typedef struct weft_msaa weft_msaa;

// Makes the targets. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT (size,
// samples; the log has both numbers), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_msaa_create(const struct weft_msaa_params *params, weft_msaa **out);
WEFT_API void weft_msaa_destroy(weft_msaa **msaa); // accepts &NULL, leaves NULL behind

// Draws a picture: one call of stage colour, with no depths drawn before; of surfaces in the same
// place the first that is drawn is seen. It may be called again and again; on failure there is no
// picture. Of a part of the picture the errors are those of its own pixels. Returns what `draw`
// returned, of sums WEFT_ERR_LIMIT (colours beyond the range) or
// WEFT_ERR_FORMAT (some that are not finite), WEFT_ERR_ARGUMENT (nothing to draw, a part),
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_msaa_run(weft_msaa *msaa,
                                        const struct weft_antialias_drawing *drawing);

// Writes a channel (0 to 3: R, G, B, alpha) of the last picture, or of the part that was drawn,
// out[y * stride + x], rows upwards as GL has them; stride 0: its width. Sums are divided in double
// and rounded once. Returns WEFT_ERR_ARGUMENT (no picture, a channel).
WEFT_API enum weft_result weft_msaa_read(const weft_msaa *msaa, int channel, float *out,
                                         size_t stride);

// What pictures come to.
struct weft_msaa_report {
    int samples;        // of a pixel, that GL has
    double discrepancy; // of the samples in a pixel (passes/jitter/discrepancy.h)
    double scale;       // of sums: integers for each unit of colour, a power of two; 0 of a blit
    // weft_bytes_multisample with depths of 4 bytes; of all that GL holds for it, by its own sizes,
    // with what samples are resolved into.
    uint64_t formula_bytes, bytes;
};
WEFT_API void weft_msaa_get_report(const weft_msaa *msaa, struct weft_msaa_report *out);

// Writes the positions of the samples that a pixel of so many has on this device, x to the right, y
// down the rows, in pixels from the middle, and returns how many those are: `samples` or the next
// larger number that the device has. 0: it has none that large, or the context fails.
WEFT_API int weft_msaa_positions(weft_context *context, int samples,
                                 double out[WEFT_PATTERN_MAX][2]);

WEFT_END_DECLS
#endif
