// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/shutter.h - how much light a shutter lets through while it is open, for motion blur
// by accumulation. Time t runs from 0, when it begins to open, to 1, when it is closed; how long
// that is in the scene is the caller's affair.
// Everything is pure, allocates nothing, and may be called from any thread.
#ifndef WEFT_PASSES_JITTER_SHUTTER_H
#define WEFT_PASSES_JITTER_SHUTTER_H

#include "weights.h"

WEFT_BEGIN_DECLS

// The shape of a shutter's light over time.
enum weft_shutter_shape {
    // Grows linearly from 0 at t = 0 to 1 at t = open, stays, and falls linearly from t = close to
    // 0 at t = 1. A box is 0:1, a tent 1/2:1/2, 1 - |2 t - 1|.
    WEFT_SHUTTER_RAMPS,
    // exp(-((t - 1/2) / sigma)^2 / 2), cut at 0 and 1.
    WEFT_SHUTTER_GAUSS,
    WEFT_SHUTTER_SHAPE_COUNT
};

// A shutter. All zero closes from the beginning on, 0:0; a box is WEFT_SHUTTER_BOX.
struct weft_shutter {
    enum weft_shutter_shape shape; // default: ramps
    double open, close;            // of ramps: 0 <= open <= close <= 1
    double sigma;                  // of the Gaussian: 1/100 to 100; ramps leave it alone
};
// Initialisers: open and shut at once, and opening for one half, closing for the other.
#define WEFT_SHUTTER_BOX                                                                           \
    {                                                                                              \
        .close = 1.0                                                                               \
    }
#define WEFT_SHUTTER_TENT                                                                          \
    {                                                                                              \
        .open = 0.5, .close = 0.5                                                                  \
    }

// Reads "box", "tent", "gauss", "gauss:SIGMA" (1/5 without) or "OPEN:CLOSE" ("0.25:0.75"), numbers
// whatever the locale. On failure *out is a box. Returns WEFT_ERR_ARGUMENT; the log says what there
// is.
WEFT_API enum weft_result weft_shutter_parse(const struct weft_log *log, const char *text,
                                             struct weft_shutter *out);

// Returns the light at time t, 0 to 1; where ramps jump, at 0 and 1, the larger value; 0 outside of
// [0, 1]. NAN for a shutter that is none, or where t is NAN.
WEFT_API double weft_shutter_light(const struct weft_shutter *shutter, double t);

// Returns the share of all its light that a shutter has let through by time t, 0 to 1: what an edge
// that passes a point at time t leaves of what was there before, so that a moving edge is blurred
// into this ramp. NAN as above.
WEFT_API double weft_shutter_share(const struct weft_shutter *shutter, double t);

// Writes the times of `count` frames, the middles of as many parts of the shutter's time,
// t_k = (k + 1/2) / count, and their weights, the light there divided by the sum of all. A moving
// edge then has the ramp weft_shutter_share within half the largest weight, 1 / (2 count) for a
// box, and, for others, 2 / A times what the middles of parts miss of their light: 1 / (8 count^2)
// over its length for each ramp; 1 / (24 sigma^2 count^2) for a Gaussian. A is the integral of the
// light, of ramps (1 + close - open) / 2. `times` may be NULL.
// On failure nothing is written, and the report (NULL: not wanted) is all NAN with no zeros.
// Returns WEFT_ERR_ARGUMENT: a shutter that is none, a count that is not above 0.
WEFT_API enum weft_result weft_shutter_weights(const struct weft_log *log,
                                               const struct weft_shutter *shutter, int count,
                                               double *times, double *weights,
                                               struct weft_weights_report *report);

WEFT_END_DECLS
#endif
