// SPDX-License-Identifier: BSD-3-Clause
// tools/antialias/drawer.h - the ways of anti-aliasing behind one interface: what draws pictures of
// a size, one after the other, and tells what they took.
#ifndef WEFT_TOOLS_ANTIALIAS_DRAWER_H
#define WEFT_TOOLS_ANTIALIAS_DRAWER_H

#include "tools/antialias/adaptive.h"

enum antialias_way {
    ANTIALIAS_ACAA,
    ANTIALIAS_MSAA,
    ANTIALIAS_ADAPTIVE,
    ANTIALIAS_SUPERSAMPLE,
    ANTIALIAS_NONE, // one sample in the pixel's middle
    ANTIALIAS_WAY_COUNT
};
extern const char *const antialias_way_names[]; // "acaa", "msaa", "adaptive", "supersample",
                                                // "none"; NULL-ended, in that order

// What draws. Of the members that follow the context each is of some ways only, as its comment
// says; the others leave it alone. What they mean is told by the library's headers.
struct antialias_params {
    enum antialias_way way;
    int size[2];              // of the pictures (required)
    int samples;              // of a pixel, > 0; none: 1 (required)
    const double *background; // 4 numbers, linear (required)
    weft_context *context;    // borrowed for the drawer's life (required)
    const struct weft_log *log;
    struct weft_kernel filter; // acaa, adaptive, supersample (default a box)
    double filter_width;       // likewise; 0: as it is
    enum weft_acaa_form form;  // acaa, like the next two
    enum weft_acaa_coincident coincident;
    enum weft_acaa_sums sums;
    double sum_range;                  // acaa; msaa by sums; 0: the default
    enum weft_msaa_resolve resolve;    // msaa
    int depth_bits;                    // acaa, msaa, none; 0: the default
    enum weft_antialias_format format; // all but acaa
    enum weft_mark mark;               // adaptive, like the next two
    double contrast, max_share;
    enum weft_supersample_store store;      // adaptive, supersample, like the next two
    enum weft_accumulate_method method;     // ..
    const struct weft_jitter_info *pattern; // positions; NULL: a grid. msaa's and acaa's are the
                                            // device's
    uint64_t seed;                          // of patterns that are random
};

// Thread-safety: one thread at a time, with its context.
typedef struct antialias_drawer antialias_drawer;

// On failure *out is NULL. Returns what the way's own object does, or WEFT_ERR_ARGUMENT (a pattern
// that has not so many samples), after a line.
enum weft_result antialias_drawer_create(const struct antialias_params *params,
                                         antialias_drawer **out);
void antialias_drawer_destroy(antialias_drawer **drawer); // accepts &NULL, leaves NULL behind

// Draws a picture, or a part of it; picture: its number, which is another one for another picture.
// Returns what the way's own object does.
enum weft_result antialias_drawer_run(antialias_drawer *drawer,
                                      const struct weft_antialias_drawing *drawing, int picture,
                                      const struct weft_progress *progress);
// What sums have room for (weft_acaa_room); {0} where that is nothing to them.
void antialias_drawer_get_room(const antialias_drawer *drawer, struct weft_acaa_room *out);
enum weft_result antialias_drawer_set_room(antialias_drawer *drawer,
                                           const struct weft_acaa_room *room);

// Writes a channel (0 to 3) of the last picture or part, rows upwards and tightly packed.
enum weft_result antialias_drawer_read(antialias_drawer *drawer, int channel, float *out);
// Writes the weight of each pixel of the last picture or part, 1 being whole: of acaa.
enum weft_result antialias_drawer_read_weight(antialias_drawer *drawer, float *out);

// What the drawer is, and what the last picture came to.
struct antialias_report {
    int samples;        // of a pixel
    int passes;         // that a picture takes
    double discrepancy; // of the samples in a pixel, from half-planes
    int radius;         // pixels that a sample reaches to each side
    double bound;       // of |value - exact sum of the colours as they were written|; NAN: none
    uint64_t formula_bytes, bytes; // by the formula of the way, and of all that is held for it
    // By formula: of acaa MSAA with colours of each format; of adaptive and supersample full
    // supersampling, by the paper's accounting with 3 bytes of colour and 4 of depth. Else 0.
    uint64_t multisample_bytes[WEFT_ANTIALIAS_FORMAT_COUNT], full_bytes;
    struct weft_acaa_report acaa;               // of acaa
    struct weft_msaa_report msaa;               // of msaa and none
    struct weft_supersample_report supersample; // of adaptive, where anything is marked, and
                                                // supersample
    const struct weft_marks *marks; // of adaptive, as long as the drawer draws no more; else NULL
};
void antialias_drawer_get_report(const antialias_drawer *drawer, struct antialias_report *out);
// Sets the marks of adaptive supersampling, and what follows from their number.
void antialias_report_set_marks(const struct antialias_params *params,
                                const struct weft_marks *marks, struct antialias_report *out);

#endif
