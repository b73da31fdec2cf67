// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/cpu.h - filtering without OpenGL (not installed).
//
// Pixels are made in parts: a strip of columns by a band of rows, of which each is one thread's.
// "Numbers" are floats or doubles, as the plan's sums are. Along x, each column has weights of its
// own: as many rows as a vector has lanes are interleaved, [tap][row], so that a column is a sum of
// whole vectors whatever its taps are, and columns then become rows again. Along y a row's pixels
// share their weights, and are sums of rows. Where x goes first, filtered rows of samples are kept
// until no row of pixels needs them, in the order in which those need them; where y does, the rows
// of as many pixels as there are lanes are made and filtered together.
// Every number is a lane of a whole vector, by the same operations in the same order: what a pixel
// is does not depend on parts, threads or where it is in a row.
#ifndef WEFT_PASSES_SEPARABLE_CPU_H
#define WEFT_PASSES_SEPARABLE_CPU_H

#include "passes/separable/separable_impl.h"

// ---- loops --------------------------------------------------------------------------------------

// Taps of a strip whose samples lie side by side, or are all the same.
struct weft_separable_span {
    int32_t at;     // the first one, among the strip's taps
    int32_t sample; // that it is; -1: the border's value, as are all of the span
    int32_t count;
    int32_t step; // from one's sample to the next one's: 1, 0 or -1
};

// Filtering along x. Columns are whole vectors.
struct weft_separable_across {
    const void *lines;    // interleaved
    const void *weights;  // numbers, [column][tap]
    const int32_t *first; // of every column: its first tap
    int columns, taps;
    bool skips_zeros; // taps whose weight is 0 do not count
    void *out;        // of as many rows as there are lanes
    size_t pitch;     // numbers from row to row
};

// The loops for one set of instructions and one kind of numbers. Lines are of floats or of numbers.
struct weft_separable_lines {
    int lanes;    // numbers in a vector, and rows that are interleaved
    size_t bytes; // of a number
    // Interleaves a span of as many lines, multiplied by a factor.
    void (*gather)(const void *const *lines, bool floats, const struct weft_separable_span *span,
                   double factor, void *out);
    void (*across)(const struct weft_separable_across *across);
    // Sums `taps` lines by their weights (numbers) to `count` numbers; 0 of no taps.
    void (*along)(const void *const *lines, bool floats, const void *weights, int taps, int count,
                  void *out);
    void (*narrow)(const void *numbers, int count, float *out); // to floats
    // Returns whether all of `count` > 0 pixels are finite, and the ends of their range if they
    // are.
    bool (*measure)(const float *pixels, int count, float *minimum, float *maximum);
};

// Those of each set, by what sums are made in.
const struct weft_separable_lines *weft_separable_lines_plain(enum weft_sums sums);
#ifdef __x86_64__
const struct weft_separable_lines *weft_separable_lines_sse2(enum weft_sums sums);
const struct weft_separable_lines *weft_separable_lines_avx2(enum weft_sums sums);
const struct weft_separable_lines *weft_separable_lines_avx512(enum weft_sums sums);
#endif

// ---- compiled plans -----------------------------------------------------------------------------

struct weft_separable_strip {
    int from, columns;
    int taps;                 // different ones
    size_t spans, span_count; // of them, from number `spans` on
};

struct weft_separable_cpu {
    const weft_separable_plan *plan;
    struct weft_cpu cpu; // defaults filled in
    const struct weft_separable_lines *lines;
    int columns; // of a strip, at most
    int strip_count;
    bool keeps_weights;
    struct weft_separable_strip *strips;
    struct weft_separable_span *spans;
    int32_t *first[2];   // of every column: its first tap among its strip's; of every row: all
                         // rows'
    int32_t *row_sample; // of every tap of rows: its sample
    int row_taps;
    void *weights[2]; // numbers, [column or row][tap], zeros past the last; NULL: made as needed
    int kept_blocks;  // x first: interleaved rows of samples whose filtered rows are kept
    // A thread's memory, and where in it what lies, in bytes.
    size_t thread_bytes, lines_at, rows_at, out_at, taps_at, blocks_at, room_at, weights_at;
    char *memory;                       // of all threads
    struct weft_statistics *statistics; // of each thread's pixels, while it runs
    uint64_t bytes;
};

// Writes the weights of `count` columns (axis 0) or rows as numbers, [position][tap]. There is room
// for a position's in double.
void weft_separable_cpu_weights(const struct weft_separable_cpu *compiled, int axis, int from,
                                int count, double *room, void *out);

// Rows of a band, so that so many rows of so many strips are parts for all threads.
int weft_separable_cpu_band(const struct weft_separable_cpu *compiled, int strips, int rows);

// `resolved` has its defaults filled in. Returns WEFT_ERR_LIMIT or WEFT_ERR_MEMORY.
enum weft_result weft_separable_cpu_compile(const weft_separable_plan *plan,
                                            const struct weft_cpu *resolved,
                                            struct weft_separable_cpu **out);
void weft_separable_cpu_destroy(struct weft_separable_cpu **compiled); // accepts &NULL

// The request is checked. Returns WEFT_ERR_CANCELLED.
enum weft_result weft_separable_cpu_run(struct weft_separable_cpu *compiled,
                                        const struct weft_separable_run_params *params,
                                        struct weft_separable_report *report);

#endif
