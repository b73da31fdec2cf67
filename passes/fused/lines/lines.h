// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/lines/lines.h - sums over all taps for pixels of a row, on the CPU (not installed).
// One body of C, lines_body.h and lines_rows.h, is compiled once for each set of instructions. It
// makes the weights of many pixels at once, in vectors across pixels. Each pixel's samples are then
// weighed in vectors along the rows of its block, where neighbours are one load: products with the
// weights along the third axis are added up first, then those along the second. What the lanes hold
// is turned into vectors across four pixels, one for each tap along a row, and added up by the
// weights along it. Lanes past the last tap are not used, whatever is there.
//
// Several outputs, derivatives of different orders, are sums over the same samples, which are read
// once: sums along the third axis are made once for each order along it, those along the second for
// each pair of orders. The value among them is the same bytes as the value alone.
//
// A pixel's operations are the same and in the same order wherever it lies in a row: a product and
// the addition after it are rounded once where the set has such an instruction and it is written
// down, else twice; the compiler has no say in it (-ffp-contract=off).
//
// Roundings: of n taps along an axis there are a product and n - 1 products that are added to it,
// at most n roundings of each term on each of the levels.
#ifndef WEFT_PASSES_FUSED_LINES_LINES_H
#define WEFT_PASSES_FUSED_LINES_LINES_H

#include "filter/quantity.h"
#include "passes/cpu/cpu.h"
#include "tiles/kernel/polynomial_tiles.h"

enum {
    WEFT_LINE_PIXELS = 256,  // of a line, at most
    WEFT_LINE_PAD = 16,      // entries past the last pixel's in `start` and `listed`, copies of it
    WEFT_LINE_SAMPLES = 16,  // samples past a block's end that are read and do not count
    WEFT_LINE_COPIES = 16,   // of a coefficient: a vector of them is one load
    WEFT_LINE_FRACTION = 29, // fraction bits of a position; three whole ones before them
    WEFT_LINE_ORDERS = 3,    // of derivatives along an axis: 0 to 2
};

// Weights of one order along an axis, whichever it is: filled in by weft_line_kernel_create.
struct weft_line_weights {
    int degree, segments;
    int stride;         // coefficients of one power of a segment: taps, then zeros
    void *coefficients; // floats or doubles, [segment][power][stride], or, of a single segment,
                        // [power][tap][WEFT_LINE_COPIES], all of these the same
};

// Of a compiled plan: weights, and how blocks lie.
struct weft_line_kernel {
    int width;                 // taps along an axis
    bool summed;               // none along the third axis of blocks; not with several outputs
    uint32_t pitch_y, pitch_z; // samples from row to row and from slice to slice of a block
    int clamp_from, clamp_to;  // taps along each axis to whose samples' range pixels are clamped;
                               // both 0: they are not. Not with several outputs
    // What is made of each pixel, in this order; along the axes of blocks, which need not be the
    // volume's. 0: the value alone.
    int output_count;
    struct weft_derivative output[WEFT_DERIVATIVES];
    // Filled in by weft_line_kernel_create.
    enum weft_sums sums;
    struct weft_line_weights weights[WEFT_LINE_ORDERS];
};

// Copies the polynomials of each order, all of one width. tiles[0] is required; NULL: no output has
// that order. The fields before that are the caller's to set, and may be
// afterwards. Returns WEFT_ERR_MEMORY.
enum weft_result
weft_line_kernel_create(const struct weft_log *log, enum weft_sums sums,
                        const struct weft_polynomial_tiles *const tiles[WEFT_LINE_ORDERS],
                        struct weft_line_kernel *out);
void weft_line_kernel_destroy(struct weft_line_kernel *kernel); // {0} is fine

// Pixels that are made alike: neighbours of a row, which lie a step apart, or any points. A
// position along an axis of blocks is a word of 3 whole and 29 fraction bits, modulo 8 voxels, past
// the first tap of a pixel at the cell's start.
struct weft_line {
    const struct weft_line_kernel *kernel;
    const float *const *start; // by pixel: its first tap's sample, if it were at its cell's start
    // Of neighbours, pixel i's: position + i * step + ((low + i * low_step) >> low_bits).
    uint32_t position[3], step[3], low[3], low_step[3];
    int low_bits;
    const uint32_t *listed[3]; // of points: their words along each axis; all NULL: of neighbours
    int count;                 // pixels, 1 to WEFT_LINE_PIXELS
    float *out;                // output o of pixel i is out[o * plane + i]
    size_t plane;
};
typedef void (*weft_line_fn)(const struct weft_line *line);

// The fastest for a kernel, all fields of which are set. `instructions` is one that runs here, not
// AUTO.
weft_line_fn weft_line_find(enum weft_instruction_set instructions,
                            const struct weft_line_kernel *kernel);

// The same of one set.
weft_line_fn weft_line_find_plain(const struct weft_line_kernel *kernel);
#if defined(__x86_64__)
weft_line_fn weft_line_find_sse2(const struct weft_line_kernel *kernel);
weft_line_fn weft_line_find_avx2(const struct weft_line_kernel *kernel);
weft_line_fn weft_line_find_avx512(const struct weft_line_kernel *kernel);
#endif

#endif
