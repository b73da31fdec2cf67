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
    int32_t width, height;             // of the picture, each > 0 (required)
    int samples;                       // of a pixel, that the device has; 1: no anti-aliasing
                                       // (default 4)
    enum weft_antialias_format format; // of colours (default 8 bits)
    enum weft_msaa_resolve resolve;    // default GL's
    double range;                      // of sums: as struct weft_acaa_params, but > 0 (default 1)
    int depth_bits;                    // 24 or 32 (default 24)
    double background[4];              // linear, associated alpha
    weft_context *context;             // borrowed for the object's life (required)
    const struct weft_log *log;        // likewise; may be NULL
};
#define WEFT_MSAA_DEFAULTS
#define weft_msaa_params(...) (&(struct weft_msaa_params){WEFT_MSAA_DEFAULTS __VA_ARGS__})

// Thread-safety: one thread at a time, with its context.
typedef struct weft_msaa weft_msaa;

// Makes the targets. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT (size,
// samples; the log has both numbers), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_msaa_create(const struct weft_msaa_params *params, weft_msaa **out);
WEFT_API void weft_msaa_destroy(weft_msaa **msaa); // accepts &NULL, leaves NULL behind

// Draws a picture: one call of stage colour, with no depths drawn before. Returns what `draw`
// returned, WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_msaa_run(weft_msaa *msaa,
                                        const struct weft_antialias_drawing *drawing);

// Writes a channel (0 to 3) of the last picture, out[y * stride + x], rows upwards; stride 0:
// width. Returns WEFT_ERR_ARGUMENT (no picture, a channel).
WEFT_API enum weft_result weft_msaa_read(const weft_msaa *msaa, int channel, float *out,
                                         size_t stride);

struct weft_msaa_report {
    int samples;
    double discrepancy;            // of the samples in a pixel
    double scale;                  // of sums: integers for each unit of colour
    uint64_t formula_bytes, bytes; // weft_bytes_multisample; of all that GL holds for it
};
WEFT_API void weft_msaa_get_report(const weft_msaa *msaa, struct weft_msaa_report *out);

// Writes the positions of the samples that a pixel of so many has on this device, x to the right, y
// down the rows, in pixels from the middle, and returns how many those are: `samples` or the next
// larger number that the device has. 0: it has none that large, or the context fails.
WEFT_API int weft_msaa_positions(weft_context *context, int samples,
                                 double out[WEFT_PATTERN_MAX][2]);

WEFT_END_DECLS
#endif
