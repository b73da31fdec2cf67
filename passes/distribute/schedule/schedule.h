// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/schedule/schedule.h - who does which part of a picture: the regions that a
// picture is divided into, and how they are given to ranks (Lin, Lau, Lin, Cheung 1997,
// section 3.1: screen subdivision, static and dynamic load balance; Whitman 1992).
#ifndef WEFT_PASSES_DISTRIBUTE_SCHEDULE_SCHEDULE_H
#define WEFT_PASSES_DISTRIBUTE_SCHEDULE_SCHEDULE_H

#include "../../../filter/rectangle.h"

WEFT_BEGIN_DECLS

enum weft_schedule {
    WEFT_SCHEDULE_AUTO,   // pull where there are at least twice as many items as ranks, else static
    WEFT_SCHEDULE_STATIC, // round robin
    WEFT_SCHEDULE_DYNAMIC, // round robin, of regions whose boundaries move from frame to frame with
                           // the load of the frame before (section 3.1.2)
    WEFT_SCHEDULE_PULL,    // whoever is free asks rank 0
    WEFT_SCHEDULE_COUNT
};
// NULL-ended, in the order of the enum: "auto", "static", "dynamic", "pull".
WEFT_API extern const char *const weft_schedule_names[];

enum { WEFT_REGIONS_MAX = 1 << 22 };

// How a picture is divided. Regions are numbered by rows.
struct weft_regions_params {
    int32_t width, height; // pixels (required, > 0)
    // Of a region, whatever `least` is; the last ones of a row and the last row have what is left.
    // width 0: all of the picture's (whole rows), height 0: likewise. Both 0 (default): at least
    // ranks * granularity regions of nearly the same size, as near to squares as they can be, or as
    // many as `least` lets there be.
    int32_t region_width, region_height;
    int ranks;       // >= 1 (default 1)
    int granularity; // regions a rank, where no size is given, >= 1 (default 8: the paper's ratio)
    int32_t least;   // pixels of the sides of regions that weft chooses itself, here or by moving
                     // boundaries: what filters reach; a picture may be smaller (default 1)
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define WEFT_REGIONS_DEFAULTS
#define weft_regions_params(...) (&(struct weft_regions_params){WEFT_REGIONS_DEFAULTS __VA_ARGS__})

// Regions that cover every pixel once. Thread-safety: read-only once made; balancing changes it.
typedef struct weft_regions weft_regions;

// Returns WEFT_ERR_ARGUMENT (a size), WEFT_ERR_LIMIT (more than WEFT_REGIONS_MAX) or
// WEFT_ERR_MEMORY; *out is then NULL.
WEFT_API enum weft_result weft_regions_create(const struct weft_regions_params *params,
                                              weft_regions **out);
WEFT_API void weft_regions_destroy(weft_regions **regions); // accepts &NULL, leaves NULL behind
WEFT_API int64_t weft_regions_count(const weft_regions *regions);
// A region; where there is none of this number one with sides of -1, which nothing takes.
WEFT_API struct weft_rectangle weft_regions_get(const weft_regions *regions, int64_t index);

// Moves the boundaries so that regions would have taken the same time in the frame before: seconds
// [count], each >= 0, of the regions as they are. A region's load is taken to be the same all over
// it. Rows of regions stay rows, of as many regions: first the boundaries between rows are moved,
// then in each row those between its regions. They go the share 1 - `keep` of the way (0 <= keep <
// 1), so that what frames before told fades away. No side becomes shorter than params.least, or
// where so many regions do not fit then, than an even division's. Where all seconds are 0 nothing
// moves. The same seconds give the same regions on every rank. Returns WEFT_ERR_ARGUMENT or
// WEFT_ERR_MEMORY, and leaves them as they were.
WEFT_API enum weft_result weft_regions_balance(weft_regions *regions, const double *seconds,
                                               double keep);

WEFT_END_DECLS
#endif
