// SPDX-License-Identifier: BSD-3-Clause
// tiles/kernel/kernel_tiles.h - kernels sampled, quantised and split.
// A tile is one unit-wide piece of a kernel, sampled at M positions per axis: the weight of one tap
// for all fractional positions. In 2D and 3D it is the product of 1D weights, quantised after the
// multiplication (Hadwiger, Hauser, Moeller, WSCG 2003), or for radial kernels
// (weft_kernel_make_radial) the weight of the distance. One factor of the product may be the
// kernel's first or second derivatives, for a component of the gradient or of the Hessian. A set
// holds the tiles of all width^dims taps; adding the tiles of a tap gives its weight. Arrays are
// [z][y][x], x fastest, M values along an axis.
#ifndef WEFT_TILES_KERNEL_KERNEL_TILES_H
#define WEFT_TILES_KERNEL_KERNEL_TILES_H

#include "../../filter/kernels/kernel.h"
#include "../../filter/quantity.h"

WEFT_BEGIN_DECLS

// The most samples of a tile along an axis.
enum { WEFT_TILES_MAX_SAMPLES = 4096 };

// How a tile holds weights. Default: unorm.
enum weft_tile_format {
    WEFT_TILE_UNORM, // 4 to 16 bits, 2^bits - 1 stands for 1.0; held as uint16_t
    WEFT_TILE_SNORM, // 8 or 16 bits, 2^(bits - 1) - 1 stands for 1.0; held as int16_t
    WEFT_TILE_HALF,  // held as float, each value a half
    WEFT_TILE_FLOAT, // held as float
};
// NULL-ended, in the order of the enum: "unorm", "snorm", "half", "float".
WEFT_API extern const char *const weft_tile_format_names[];

// How weights become what the format holds. Default: to the nearest.
enum weft_tile_rounding {
    WEFT_TILE_NEAREST,   // each weight by itself, halves away from zero (half and float: to even)
    WEFT_TILE_TRUNCATED, // each weight by itself, towards zero
    // Integer formats: the weights at one sample position add up to their exact sum, rounded; those
    // with the largest remainder are rounded up. A weight may be off by up to one step, not half
    // one.
    WEFT_TILE_SUM_PRESERVING,
};
// Likewise: "nearest", "truncated", "sum-preserving".
WEFT_API extern const char *const weft_tile_rounding_names[];

// Where the M samples of a tile lie in it, along an axis. Default: in the middles of M equal cells,
// as texels do.
enum weft_tile_placement {
    WEFT_TILE_CENTRES, // sample k at (k + 0.5) / M
    WEFT_TILE_ENDS,    // sample k at k / (M - 1), the limits from inside the tile; M >= 2
};
// Likewise: "centres", "ends".
WEFT_API extern const char *const weft_tile_placement_names[];

// What becomes of weights of both signs. Default: what the format asks for.
enum weft_tile_signs {
    WEFT_TILE_SIGNS_AUTO, // separate for unorm, else signed
    WEFT_TILE_SIGNED,     // one tile per tap; unorm then takes no negative weights
    WEFT_TILE_SEPARATE,   // a tile of the positive and one of the negative weights, as magnitudes;
                          // one that is zero everywhere before quantisation is left out
};
// Likewise: "auto", "signed", "separate".
WEFT_API extern const char *const weft_tile_signs_names[];

// What weights are multiplied by before they are rounded, so that small ones keep bits. Default:
// by 1.
enum weft_tile_scaling {
    WEFT_TILE_UNSCALED,
    WEFT_TILE_SCALE_SET,  // one factor makes the largest weight of the set full range
    WEFT_TILE_SCALE_EACH, // a factor for every tile; not with WEFT_TILE_SUM_PRESERVING
};
// Likewise: "none", "set", "each".
WEFT_API extern const char *const weft_tile_scaling_names[];

// Which of a tap's weights a tile has: all, those above 0 or those below.
enum weft_tile_part { WEFT_TILE_WHOLE, WEFT_TILE_POSITIVE, WEFT_TILE_NEGATIVE };
// Likewise: "whole", "+", "-".
WEFT_API extern const char *const weft_tile_part_names[];

// What tiles to make. All zero but for the kernel: 2D, 64 samples an axis in 8 bits, each weight
// rounded by itself, mirrored where the kernel allows.
struct weft_kernel_tiles_params {
    struct weft_kernel kernel; // required
    int dims;                  // 1 (weights for separable use), 2 or 3   (default 2)
    int samples;               // M, 1 to WEFT_TILES_MAX_SAMPLES          (default 64)
    enum weft_tile_format format;
    int bits; // of the integer formats                  (default 8)
    enum weft_tile_rounding rounding;
    enum weft_tile_placement placement;
    enum weft_tile_signs signs;
    enum weft_tile_scaling scaling;
    bool exact_scale; // the factor that uses all of the range; default: a power of two below it
    double max_scale; // a power of two: scaled tiles are so by no more (default 0: no such limit)
    // Weights are those of h' or h'' along each axis that is derived along, with the h' of
    // weft_kernel_derive, and of h along the others (default: h along all); none past dims
    struct weft_derivative derivative;
    // Else of even and odd kernels only the taps of one half per axis are stored, the others
    // fetched mirrored. Other kernels, and sum-preserving sets with an odd M, whose middle sample
    // would need an even sum, are stored whole; radial kernels are even in 2D and 3D: see struct
    // weft_kernel_tiles_info.
    bool store_all;
    bool normalise; // weights at every position add up to 1 (weft_kernel_normalise); not with
                    // `derivative`
    uint64_t memory_bytes; // what the set may hold, parts of split tiles included (default 1 GiB)
    const struct weft_log *log; // borrowed for the set's life
};
#define WEFT_KERNEL_TILES_DEFAULTS
#define weft_kernel_tiles_params(...)                                                              \
    (&(struct weft_kernel_tiles_params){WEFT_KERNEL_TILES_DEFAULTS __VA_ARGS__})

// One tile, which belongs to its set: weight = sign * stored / (one * scale), where sign is -1
// where `negated`, `one` is in the set's info.
struct weft_kernel_tile {
    int tap[3]; // 0 to width - 1, counted from weft_kernel_first_tap; 0 along axes past dims
    enum weft_tile_part part;
    bool mirrored[3]; // sample k of the tile is stored at M - 1 - k of this axis
    bool negated;     // negative parts, and those mirrored along an odd number of odd axes
    double scale;
    double minimum, maximum; // of the weights as stored, over all samples
    int stored;              // tiles with the same number share their memory
    const void *data;        // M^dims values of the format
};

// What a set is: the parameters with their defaults filled in, and what they came to.
struct weft_kernel_tiles_info {
    struct weft_kernel kernel;
    struct weft_derivative derivative;
    int dims, samples, bits;
    enum weft_tile_format format;
    enum weft_tile_rounding rounding;
    enum weft_tile_placement placement;
    int width;           // taps along an axis
    int tile_count;      // tiles to draw, split parts included
    int stored_count;    // tiles in memory
    bool mirrored;       // only one half per axis is stored
    size_t tile_values;  // M^dims
    size_t value_bytes;  // 2 or 4
    double one;          // what stands for 1.0 in an integer format; 1 for half and float
    size_t memory_bytes; // held
    size_t saved_bytes;  // that the set would hold in addition if nothing were mirrored
};

typedef struct weft_kernel_tiles weft_kernel_tiles; // Thread-safety: read-only once made and split.

// Makes the tiles of all taps; destroy the set when it is no longer used. Bytes are counted before
// any tile is allocated. Returns WEFT_ERR_ARGUMENT (a range, weights that
// the format cannot hold unscaled, or a kernel without a derivative), WEFT_ERR_UNSUPPORTED (the
// derivative of a radial kernel), WEFT_ERR_LIMIT (bytes needed and allowed in the log) or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_kernel_tiles_create(const struct weft_kernel_tiles_params *params,
                                                   weft_kernel_tiles **out);
WEFT_API void weft_kernel_tiles_destroy(weft_kernel_tiles **tiles); // accepts &NULL, leaves NULL

// Tells what a set is; lives as long as the set, and splits change its counts.
WEFT_API const struct weft_kernel_tiles_info *
weft_kernel_tiles_get_info(const weft_kernel_tiles *tiles);
// Returns tile 0 to tile_count - 1, NULL for other numbers; valid until the next split.
WEFT_API const struct weft_kernel_tile *weft_kernel_tiles_get(const weft_kernel_tiles *tiles,
                                                              int tile);
// Returns the number of the first tile of that tap and part, -1 if there is none. The part of a
// tile that is not separated is WEFT_TILE_WHOLE.
WEFT_API int weft_kernel_tiles_find(const weft_kernel_tiles *tiles, const int tap[3],
                                    enum weft_tile_part part);

// Returns the position of sample k in its tile, 0 to 1.
WEFT_API double weft_kernel_tiles_position(const weft_kernel_tiles *tiles, int k);
// Returns what a tile adds to its tap's weight at a sample position, each 0 to M - 1 (0 past dims).
// NAN, like all of these, where there is no such tile, tap or position.
WEFT_API double weft_kernel_tiles_value(const weft_kernel_tiles *tiles, int tile,
                                        const int position[3]);
// Returns the same as an integer, sign included, at the tile's own scale; integer formats only,
// else 0.
WEFT_API int weft_kernel_tiles_integer(const weft_kernel_tiles *tiles, int tile,
                                       const int position[3]);
// Returns the exact weight that a tap has there, in double.
WEFT_API double weft_kernel_tiles_exact(const weft_kernel_tiles *tiles, const int tap[3],
                                        const int position[3]);

// Splits a tile (section 4): the tile keeps the values >= threshold and is zero elsewhere, a new
// last tile has the values below it; they add up exactly. Threshold NAN: the middle of the tile's
// range. Tiles that share its memory stay as they are. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT or
// WEFT_ERR_MEMORY, the set being as before.
WEFT_API enum weft_result weft_kernel_tiles_split(weft_kernel_tiles *tiles, int tile,
                                                  double threshold);

WEFT_END_DECLS
#endif
