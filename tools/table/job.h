// SPDX-License-Identifier: BSD-3-Clause
// tools/table/job.h - one `weft table`: what was asked and what came out.
#ifndef WEFT_TOOLS_TABLE_JOB_H
#define WEFT_TOOLS_TABLE_JOB_H

#include <stdio.h>

#include "tools/options/options.h"
#include "tools/common/report.h"

enum table_option {
    TABLE_KERNELS,
    TABLE_RESOLUTIONS,
    TABLE_DIMS,
    TABLE_BITS,
    TABLE_ROUNDING,
    TABLE_LOOKUP,
    TABLE_SCALE,
    TABLE_GRID,
    TABLE_CONVENTION,
    TABLE_FORMAT,
    TABLE_STATISTICS,
    TABLE_PLOT,
    TABLE_TARGET_ERROR,
    TABLE_OUTPUT,
    TABLE_QUIET,
    TABLE_VERBOSE,
    TABLE_OPTION_COUNT
};

enum table_format { TABLE_TEXT, TABLE_MARKDOWN, TABLE_CSV, TABLE_JSON, TABLE_LATEX };

enum {
    TABLE_MAX_LIST = 64,
    TABLE_DIMENSIONS = 3,
    TABLE_MAX_SAMPLES = 65536,
    TABLE_MAX_GRID = 4096
};

// A kernel whose weights are multiplied by a constant before they are quantised, as a record.
struct table_scaled {
    struct weft_kernel kernel;    // what is computed with
    struct weft_kernel_info info; // of it, where factor != 1
    const struct weft_kernel *plain;
    double axis_factor; // per axis
    double factor;      // of the product: errors are divided by it
};

struct table_kernel {
    char *text; // as given
    struct weft_kernel kernel;
    weft_kernel_file *file;
    struct table_scaled scaled[TABLE_DIMENSIONS]; // for 1, 2 and 3 dimensions
};

struct table_cell {
    int kernel, dims, samples, bits;
    enum weft_error_lookup lookup;
    struct weft_error_kernel error; // of the weights themselves, whatever the scale
    double published;               // where convention wscg2003 does not give it: what it is
    bool missed; // with --target-error: no resolution up to the largest reaches it with these bits
    bool least;  // with --target-error: no other bits take less memory
};

struct table_job {
    const struct option_value *option; // [TABLE_OPTION_COUNT]
    struct table_kernel kernel[TABLE_MAX_LIST];
    int kernel_count;
    int samples[TABLE_MAX_LIST], sample_count;
    int dims[TABLE_DIMENSIONS], dim_count;
    int bits[TABLE_MAX_LIST], bit_count; // several with --target-error only
    enum weft_error_lookup lookup[2];
    int lookup_count;
    enum weft_fixed_rounding rounding;
    enum weft_error_convention convention;
    enum table_format format;
    int locations; // 0: the default of the dimension
    struct table_cell *cell;
    int cell_count;
};

// What --scale asks for, of every kernel in every dimension. Returns WEFT_ERR_ARGUMENT after an
// error line.
enum weft_result table_set_scales(struct table_job *job);
// All cells: every kernel at every resolution, dimension and look-up. Returns WEFT_ERR_MEMORY, or
// what weft_error_kernel_compute returns.
enum weft_result table_cells_compute(struct table_job *job);

// Resampling locations per axis: as asked for, or the default of the dimension.
int table_locations(const struct table_job *job, int dims);

// One cell, divided by the scale; `locations` per axis.
enum weft_result table_cell_compute(const struct table_job *job, struct table_cell *cell,
                                    int locations, const struct weft_progress *progress);

// For every kernel, dimension and look-up the smallest resolution for each number of bits.
enum weft_result table_target_compute(struct table_job *job);

// As JSON, where -o says or on standard output; and in the other formats.
enum weft_result table_print_json(const struct table_job *job);
enum weft_result table_print(const struct table_job *job, FILE *out);

// eps_h over M.
enum exit_code table_draw(const struct table_job *job, const char *path);

#endif
