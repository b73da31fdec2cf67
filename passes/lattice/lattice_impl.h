// SPDX-License-Identifier: BSD-3-Clause
// passes/lattice/lattice_impl.h - what the files of passes/lattice share (not installed).
#ifndef WEFT_PASSES_LATTICE_LATTICE_IMPL_H
#define WEFT_PASSES_LATTICE_LATTICE_IMPL_H

#include <math.h>

#include "filter/check.h"
#include "filter/kernels/stretch.h"
#include "filter/threads.h"
#include "passes/lattice/lattice.h"
#include "tiles/volume/brick_reader.h"

// Orders of derivatives along an axis.
enum { WEFT_LATTICE_ORDERS = 3 };

// A box of voxels, inclusive.
struct weft_lattice_box {
    int64_t min[3], max[3];
};

struct weft_lattice_plan {
    struct weft_lattice_info info;
    const struct weft_log *log;
    weft_volume *filtered;                          // coefficients, of prefiltered kernels
    weft_volume *volume;                            // the params'
    weft_volume *source;                            // what is read: one of both
    struct weft_brick_reader reader;                // of all of it
    struct weft_cell_map below[2];                  // cells of 128 and 4096 voxels that hold
                                                    // bricks or tiles smaller than they are
    struct weft_kernel kernel[WEFT_LATTICE_ORDERS]; // and its derivatives, where there are any
    double reach[3];                                // of a position, along the source's axes
    struct weft_quantities quantities;
    struct weft_quantity_transform transform;
    bool plain;   // the value alone: derivatives are channels
    bool clamped; // the source is, to its edge
    bool boxed;   // voxels beyond info's box are left as the background
    float background;
    double prune;
    uint64_t memory_bytes;
    char (*name)[sizeof((struct weft_volume_info *)0)->name + 64]; // of each grid
    char *text;
};

// ---- maps ---------------------------------------------------------------------------------------

// Returns false where there is no inverse.
bool weft_lattice_invert(const double m[3][4], double out[3][4]);
// a after b. out may be neither.
void weft_lattice_multiply(const double a[3][4], const double b[3][4], double out[3][4]);

// Where along one of the source's axes a voxel lies, rounded.
static inline double weft_lattice_round(double x)
{
    return rint(x * 0x1p32) * 0x1p-32;
}
static inline double weft_lattice_at(const double row[4], const int64_t r[3])
{
    return weft_lattice_round(row[0] * (double)r[0] + row[1] * (double)r[1] +
                              row[2] * (double)r[2] + row[3]);
}

// The box around what a map makes of a box of points.
void weft_lattice_map_box(const double m[3][4], const double min[3], const double max[3],
                          double out_min[3], double out_max[3]);

// ---- what lies where ----------------------------------------------------------------------------

// Finds what the source has. *bounds is around all that is not of the background's value.
enum weft_result weft_lattice_find(struct weft_lattice_plan *plan, struct weft_lattice_box *bounds);
// The source's voxels that the kernels of a box of the result's meet, none too few.
struct weft_lattice_box weft_lattice_footprint(const struct weft_lattice_plan *plan,
                                               const struct weft_lattice_box *box);

// Bricks of the result to be computed, and tiles.
struct weft_lattice_list {
    int32_t (*brick)[3];
    size_t brick_count, brick_capacity;
    struct weft_volume_tile *tile;
    size_t tile_count, tile_capacity;
};
void weft_lattice_list_clear(struct weft_lattice_list *list);
// Columns of bricks that are listed, and computed, together; voxels along y, and x.
enum { WEFT_LATTICE_STRIP = 32 };
// Appends what lies in the layer of 8 voxels from z on, and in the strip of rows from y on, sorted
// by y, then x. Returns WEFT_ERR_MEMORY.
enum weft_result weft_lattice_walk(const struct weft_lattice_plan *plan, int32_t z, int32_t y,
                                   struct weft_lattice_list *list);

// ---- weights ------------------------------------------------------------------------------------

// Of 8 positions along one of the result's axes, of every order that is needed.
struct weft_lattice_weights {
    int64_t first[WEFT_BRICK_SIZE];
    double *weight[WEFT_LATTICE_ORDERS]; // [position][tap]; NULL: not needed
};
// Those of blocks that were asked for. {0} has none.
struct weft_lattice_memo {
    struct weft_cell_map known; // axis, block
    struct weft_lattice_weights **weights;
    size_t capacity;
};
void weft_lattice_memo_clear(struct weft_lattice_memo *memo);
// The weights of the 8 positions from `origin` on; NULL: out of memory.
const struct weft_lattice_weights *weft_lattice_memo_get(const struct weft_lattice_plan *plan,
                                                         struct weft_lattice_memo *memo, int axis,
                                                         int32_t origin);
const struct weft_lattice_weights *weft_lattice_memo_find(const struct weft_lattice_memo *memo,
                                                          int axis, int32_t origin);

// ---- blocks -------------------------------------------------------------------------------------

// Neighbouring bricks that are computed together: of one layer and strip.
struct weft_lattice_block {
    size_t count, *brick;          // their places in the list of bricks
    struct weft_lattice_box box;   // around them
    struct weft_lattice_box reach; // of the source's voxels
};

// Rows of doubles, a multiple of 8 long.
struct weft_lattice_lines {
    // out[i] = sum of weight[t] * row[t][i]
    void (*sum)(double *out, const double *const *row, const double *weight, int64_t taps,
                size_t count);
    // out[i] += weight * row[i]
    void (*add)(double *out, const double *row, double weight, size_t count);
};
struct weft_lattice_lines weft_lattice_lines_find(enum weft_instruction_set instructions);
extern const struct weft_lattice_lines weft_lattice_lines_plain;
#if defined(__x86_64__)
extern const struct weft_lattice_lines weft_lattice_lines_sse2, weft_lattice_lines_avx2,
    weft_lattice_lines_avx512;
#endif

// What a thread needs. {0} has nothing.
struct weft_lattice_scratch {
    double *values;
    size_t capacity; // of values
    const double **rows;
    double *row_weights;
    size_t row_capacity;
};
void weft_lattice_scratch_clear(struct weft_lattice_scratch *scratch);
// Room for so many doubles; NULL: out of memory. What was there is lost.
double *weft_lattice_scratch_values(struct weft_lattice_scratch *scratch, size_t count);
// Copies the source's voxels of a box to out; stride: doubles from voxel to voxel along each of its
// axes.
void weft_lattice_fetch(const struct weft_lattice_plan *plan, const struct weft_lattice_box *box,
                        double *out, const size_t stride[3]);

// Computes the derivatives of a block's voxels: derivative o of voxel (x, y, z) of the box is
// out[o][z][x][y], as long as the box in each. The engines.
struct weft_lattice_work {
    const struct weft_lattice_plan *plan;
    const struct weft_lattice_memo *memo;
    const struct weft_lattice_lines *lines;
    struct weft_lattice_scratch *scratch;
    const struct weft_lattice_block *block;
};
// Returns false where memory runs out.
bool weft_lattice_compute_separable(const struct weft_lattice_work *work, const double **out,
                                    size_t pitch[3]);
bool weft_lattice_compute_direct(const struct weft_lattice_work *work, const double **out,
                                 size_t pitch[3]);

// ---- bricks -------------------------------------------------------------------------------------

// What became of a brick in a grid.
enum weft_lattice_kind { WEFT_LATTICE_NONE, WEFT_LATTICE_VALUES, WEFT_LATTICE_TILE };
struct weft_lattice_made {
    enum weft_lattice_kind kind;
    float constant; // of a tile
    uint32_t active, not_finite, clamped;
};

// Which voxels a thread verifies, and what it found.
struct weft_lattice_checked {
    struct weft_verify_report report;
    int32_t at[3];
};

// Rounds the block's derivatives of the brick at `origin` and makes the channels of them:
// channel[c] is 512 floats of voxels, those beyond what is asked for being NAN.
void weft_lattice_channels(const struct weft_lattice_work *work, const double *derivative,
                           const size_t pitch[3], const int32_t origin[3], float *const *channel);
// Whether a voxel is made, and not left as the background.
bool weft_lattice_is_made(const struct weft_lattice_plan *plan, const int64_t r[3]);
// Finishes a grid's values of a brick, of as many blocks as it has components: clamps, prunes and
// counts.
struct weft_lattice_made weft_lattice_finish(const struct weft_lattice_plan *plan, int grid,
                                             const int32_t origin[3], float *values);
// Verifies a share of the voxels of a finished brick.
bool weft_lattice_verify_brick(const struct weft_lattice_work *work,
                               const struct weft_lattice_verify *how, int grid,
                               const int32_t origin[3], const float *values,
                               struct weft_lattice_checked *out);

#endif
