// SPDX-License-Identifier: BSD-3-Clause
// tools/lattice/job.h - one `weft lattice`: what was asked, what was made, what it cost.
#ifndef WEFT_TOOLS_LATTICE_JOB_H
#define WEFT_TOOLS_LATTICE_JOB_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "tools/volumes/raw.h"

enum lattice_option {
    LATTICE_OUTPUT,
    LATTICE_SCALE,
    LATTICE_VOXEL,
    LATTICE_LIKE,
    LATTICE_MATRIX,
    LATTICE_GRID,
    LATTICE_RAW,
    LATTICE_KERNEL,
    LATTICE_NORMALISE,
    LATTICE_ANTIALIAS,
    LATTICE_QUANTITY,
    LATTICE_SPACE,
    LATTICE_PRUNE,
    LATTICE_MEMORY,
    LATTICE_OUTPUT_MEMORY,
    LATTICE_THREADS,
    LATTICE_EXPLAIN,
    LATTICE_VERIFY,
    LATTICE_JSON,
    LATTICE_NO_CLOBBER,
    LATTICE_QUIET,
    LATTICE_VERBOSE,
    LATTICE_OPTION_COUNT
};

// A grid of the input, and what becomes of it.
struct lattice_grid {
    weft_volume *volume;
    weft_lattice_plan *plan;
    int first; // of the output's grids, its first
    struct weft_lattice_report report;
};

struct lattice_job {
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw; // NULL: the input is what it is by its content
    const char *input;
    const struct option_value *option; // [LATTICE_OPTION_COUNT]
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file; // NULL for kernels of the catalogue
    struct weft_quantities quantities;
    bool moved;          // by --matrix
    double matrix[3][4]; // of world space
    weft_volume *like;   // of --like
    size_t grid_count;
    struct lattice_grid *grid;
    weft_volume_writer *writer; // while it is written
    uint64_t file_bytes;
    double start, plan_seconds, write_seconds;
};

// place.c: the map and the box of a grid's result. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result lattice_read_matrix(struct lattice_job *job);
enum weft_result lattice_place(const struct lattice_job *job, weft_volume *volume,
                               struct weft_lattice_params *params);

// run.c: all grids, planned; then made, and written where there is an output.
enum weft_result lattice_plan(struct lattice_job *job);
enum weft_result lattice_run(struct lattice_job *job);
void lattice_clear(struct lattice_job *job);

// report.c
void lattice_explain(const struct lattice_job *job);
void lattice_print_text(const struct lattice_job *job);
enum weft_result lattice_print_json(const struct lattice_job *job);
// With --verify: false, after an error line, where a voxel is beyond its bound.
bool lattice_verdict(const struct lattice_job *job);

#endif
