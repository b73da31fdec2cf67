// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/jitter.h - sets of sample positions, for effects by accumulation: where in a pixel,
// on a lens or on a light each frame takes its sample (Haeberli and Akeley, "The Accumulation
// Buffer", SIGGRAPH 1990; OpenGL Programming Guide, "Scene Antialiasing" and "Depth-of-Field
// Effect").
//
// A point is (x, y) in the square [-1/2, 1/2]^2 or, for lenses and round lights, in the disc of
// diameter 1 about the origin, times `size`. A set has no up or down but the standard multisample
// positions, whose y counts down the rows of an image, as their tables do.
//
// A set whose mean is not the origin shifts the picture by it. Either the mean is taken off
// (`centre`), which may carry points past the rim of the square or disc by as much, or it is told.
//
// Points of squares are the same bytes on every machine: sequences are integers, and each
// coordinate is rounded as it is written down here. Those of discs take the mathematical library's
// sine and cosine, whose last bit may differ.
#ifndef WEFT_PASSES_JITTER_JITTER_H
#define WEFT_PASSES_JITTER_JITTER_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Points of a set, at most.
enum { WEFT_JITTER_MAX = 1 << 20 };

// What the points fill, evenly.
enum weft_jitter_shape {
    WEFT_JITTER_SQUARE, // [-1/2, 1/2]^2
    // The disc of diameter 1: the points of the square, mapped so that equal areas stay equal and
    // rings of the square become circles (Shirley and Chiu, "A Low Distortion Map Between Disk and
    // Square", Journal of Graphics Tools 2(3), 1997).
    WEFT_JITTER_DISC,
    WEFT_JITTER_SHAPE_COUNT
};
// NULL-ended, in the order of the enum: "square", "disc".
WEFT_API extern const char *const weft_jitter_shape_names[];

// One kind of set: constant data and a short function. A user's own is such a record, too: fill
// one, and keep it as long as params refer to it.
struct weft_jitter_info {
    const char *name;        // "j8", "halton"
    const char *description; // one line
    const char *citation;    // authors, where it was published; NULL where it needs none
    const int *counts;       // the numbers of points that there are, ascending, 0-ended; NULL: any
    int default_count;       // points where none are asked for
    bool seeded;             // other points for another seed
    // The set of n points begins with that of n - 1, before centring: a sum can go on.
    bool extends;
    // Writes `count` points of the square, a count that there is. Pure.
    void (*compute)(const struct weft_jitter_info *info, int count, uint64_t seed,
                    double (*points)[2]);
    const void *data; // for the function; NULL if it needs none
};

// All sets, NULL-ended:
// - j2, j3, j4, j8, j15, j24, j66: the OpenGL Programming Guide's jitter.h (Silicon Graphics,
//   1993), of so many points each; the mean is 0 to 4e-7
// - msaa: the standard multisample positions of Direct3D 11 and Vulkan, 1, 2, 4, 8 or 16 points, in
//   sixteenths of a pixel; those of 16 have the mean (-1/32, -1/32)
// - grid: the middles of cells of equal area, in round(sqrt(n)) rows that differ by a cell at most;
//   k by k where n is k^2. The mean of the square's is 0
// - stratified: a point at random, by the seed, in each cell of `grid`
// - halton: (phi_2(i), phi_3(i)) - 1/2, i = 1 to n, by weft_jitter_radical_inverse (Halton 1960)
// - hammersley: ((i + 1/2) / n, phi_2(i)) - 1/2, i = 0 to n - 1 (Hammersley 1960)
// - sobol: the first two dimensions of Sobol's sequence (1967) less 1/2, i = 0 to n - 1: each
//   2^k points from a multiple of 2^k on have one in each box of sides 2^-j and 2^(j-k)
// - r2: frac(1/2 + i (1/g, 1/g^2)) - 1/2, i = 1 to n, g^3 = g + 1 (Roberts 2018)
WEFT_API extern const struct weft_jitter_info *const weft_jitter_list[];

// Finds a record of the list by its name, as it is spelt there. Returns NULL if there is none, or
// for a NULL name.
WEFT_API const struct weft_jitter_info *weft_jitter_find(const char *name);

// Which points to make.
struct weft_jitter_params {
    const struct weft_jitter_info *info; // of the list, or borrowed (required)
    int count;                           // points; 0: the record's default_count
    uint64_t seed;                       // of seeded sets (default 0)
    enum weft_jitter_shape shape;        // default: the square
    double size;                         // side of the square, diameter of the disc (default 1)
    bool centre;                         // takes the mean off every point
    const struct weft_log *log;          // borrowed until the call returns; may be NULL
};
#define WEFT_JITTER_DEFAULTS
#define weft_jitter_params(...) (&(struct weft_jitter_params){WEFT_JITTER_DEFAULTS __VA_ARGS__})

// Reads "NAME" or "NAME:N" as users write it ("j8", "halton:64") into the record and, 0 where there
// is none, the count; up to 63 bytes, whatever the locale. On failure both are zero. Returns
// WEFT_ERR_ARGUMENT: a name, which is logged with the list or with what may be meant, or a number
// of points that the set does not have.
WEFT_API enum weft_result weft_jitter_parse(const struct weft_log *log, const char *text,
                                            const struct weft_jitter_info **info, int *count);

// A set. All zero: none.
struct weft_jitter {
    const struct weft_jitter_info *info; // what it was made of
    int count;                           // points
    double (*points)[2];                 // owned; freed by weft_jitter_clear
    double mean[2];  // of the points: what they shift the picture by; 0 but for rounding if centred
    double shift[2]; // what centring took off every point; 0 if it was not asked for
};

// Makes a set. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (no record, a count that the
// set does not have, a shape, a size that is not in [2^-100, 2^100]) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_jitter_create(const struct weft_jitter_params *params,
                                             struct weft_jitter *out);
WEFT_API void weft_jitter_clear(struct weft_jitter *set); // accepts NULL, leaves zeros behind

// Returns the radical inverse phi_base(index): the index's digits mirrored at the point, in [0, 1),
// a quotient of integers rounded once to double. As many of the lowest digits count as fit 53 bits.
// NAN for bases that are not in 2 to 2^26. What more dimensions of Halton's sequence are made of.
WEFT_API double weft_jitter_radical_inverse(uint32_t base, uint64_t index);

WEFT_END_DECLS
#endif
