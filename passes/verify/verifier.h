// SPDX-License-Identifier: BSD-3-Clause
// passes/verify/verifier.h - the verifier behind passes/verify/verify.h: what positions, samples
// and pixels of any kind are to it (not installed).
#ifndef WEFT_PASSES_VERIFY_VERIFIER_H
#define WEFT_PASSES_VERIFY_VERIFIER_H

#include "filter/check.h"
#include "passes/multipass/compiled.h"
#include "passes/verify/verify.h"

// Every callback gets `priv`.
struct weft_verifier {
    int width, height, channels;
    int first_channel;            // what the first one is called when it is told of
    struct weft_rectangle pixels; // of those the ones that are verified
    void *priv;
    // Of a pixel; moved (NULL: not) is added before the position is rounded, if it is.
    void (*position)(void *priv, int x, int y, const double moved[3], double out[3]);
    // By how much engines may have a position otherwise before they round it. NULL: as it is.
    double (*margin)(void *priv, const double position[3]);
    // The reference there; `finite`: whether the pixel is, which decides where both would be right.
    enum weft_result (*refer)(void *priv, int channel, const double position[3], bool finite,
                              struct weft_reference_value *out);
    double (*pixel)(void *priv, int channel, int x, int y);
    // Makes ready for a part of the pixels, one after another; NULL: there is one, of all.
    enum weft_result (*enter)(void *priv, int part, struct weft_rectangle *out);
    int part_count;
    bool jumps;     // by more than rounding between positions that are within the margin
    bool far;       // references reach so far that their magnitude is the same there
    double seconds; // that one reference is worth
    double bound_relative, bound_absolute;
    struct weft_verify_params how;
    const struct weft_log *log;
};

// About how long one weft_reference_compute takes.
double weft_verifier_seconds(const struct weft_kernel *kernel, int dims);

// Verifies. Returns WEFT_ERR_CANCELLED, WEFT_ERR_ARGUMENT (a position that is not finite), and what
// enter and refer return; *out is then all zero.
enum weft_result weft_verifier_run(const struct weft_verifier *verifier,
                                   struct weft_verify_report *out);

// weft_multipass_verify of a list of passes made by hand as of a plan's; the params' plan is not
// looked at.
enum weft_result weft_multipass_verify_work(const struct weft_multipass_work *work,
                                            const struct weft_multipass_verify_params *params,
                                            struct weft_verify_report *out);

#endif
