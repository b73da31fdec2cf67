// SPDX-License-Identifier: BSD-3-Clause
// passes/stability/stability.h - known failures of reconstruction, accumulation and anti-aliasing,
// each as a case that runs the naive way beside weft's own and measures both. The command (weft
// stability) and the tests walk the same list. Every case states a limit that weft's way must keep:
// a bound that its plan gives or that follows from roundings, not a number that was seen to be
// enough. Where it comes from stands beside the case (passes/stability/*.c).
#ifndef WEFT_PASSES_STABILITY_STABILITY_H
#define WEFT_PASSES_STABILITY_STABILITY_H

#include "../gl/context.h"

WEFT_BEGIN_DECLS

// What a case came to: a case shows something where the naive way fails and ours does not.
enum weft_stability_verdict {
    WEFT_STABILITY_HOLDS,           // ours <= limit < naive
    WEFT_STABILITY_OURS_FAILS,      // ours > limit, or it is NAN
    WEFT_STABILITY_NAIVE_HOLDS_TOO, // both <= limit: the case shows nothing on this GL
    WEFT_STABILITY_SKIPPED,         // what it needs is missing; the text says what
};

// "holds", "ours fails", "naive holds too", "skipped"; "unknown" for other values. Static storage.
WEFT_API const char *weft_stability_verdict_text(enum weft_stability_verdict verdict);

// What was measured. All zero before a run.
struct weft_stability_result {
    enum weft_stability_verdict verdict;
    // Errors in the unit named; INFINITY where pixels are not finite that should be, or the other
    // way round. NAN (all three) if the case was skipped.
    double naive, ours, limit;
    char unit[16];  // "LSB" (codes of an 8-bit target), "relative", "pixels", ...
    char text[160]; // one line: what was seen
};

// What cases run with. All zero is allowed: cases that need a context or images are skipped or
// make do.
struct weft_stability_params {
    weft_context *context;      // NULL: what needs one is skipped, passes of plans are emulated
    const char *data_folder;    // with the test images of the OpenEXR project; NULL, or without an
                                // image that a case names: one is generated, and the text says so
    const struct weft_log *log; // may be NULL
};
#define WEFT_STABILITY_DEFAULTS
#define weft_stability_params(...)                                                                 \
    (&(struct weft_stability_params){WEFT_STABILITY_DEFAULTS __VA_ARGS__})

// A known failure. Records are const and static; a program of its own may make one.
struct weft_stability_case {
    const char *name;         // "order-2d"
    const char *failure;      // what fails
    const char *naive, *ours; // what either way does, in a few words
    const char *source;       // where the failure is described; NULL: nowhere in particular
    const char *image;        // file in the data folder; NULL: it needs none
    bool needs_context;       // without one it is skipped
    // Measures: all of the result but the verdict. Called by weft_stability_run, which checks.
    enum weft_result (*measure)(const struct weft_stability_params *params,
                                struct weft_stability_result *result);
};

// All cases that weft knows, NULL-ended.
WEFT_API extern const struct weft_stability_case *const weft_stability_list[];
WEFT_API const struct weft_stability_case *weft_stability_find(const char *name); // NULL if none

// Runs a case, most of them in less than a second. A failed verdict is no error. Returns
// WEFT_ERR_MEMORY, WEFT_ERR_GL and what the ways that it compares return.
WEFT_API enum weft_result weft_stability_run(const struct weft_stability_case *subject,
                                             const struct weft_stability_params *params,
                                             struct weft_stability_result *result);

WEFT_END_DECLS
#endif
