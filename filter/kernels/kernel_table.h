// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_table.h - a kernel from samples of it: for measured filters, and for
// formulas that the catalogue does not have. tiles/kernel/kernel_file.h reads such tables from
// files.
#ifndef WEFT_FILTER_KERNELS_KERNEL_TABLE_H
#define WEFT_FILTER_KERNELS_KERNEL_TABLE_H

#include "kernel.h"

WEFT_BEGIN_DECLS

enum { WEFT_KERNEL_TABLE_MAX_SAMPLES = 1 << 20 }; // of one table

// What a kernel is between two samples of its table. Default: linear.
enum weft_kernel_between {
    WEFT_KERNEL_BETWEEN_LINEAR,
    WEFT_KERNEL_BETWEEN_CUBIC, // Hermite with central differences as slopes (Catmull and Rom 1974)
};

// A kernel h of one's own, by its values. All zero but for the required members: a table of the
// right half, interpolated linearly.
struct weft_kernel_table_params {
    const char *name; // of the record (default "table"); borrowed with the table
    // Required, finite: uniformly spaced, first and last at the ends. Borrowed as long as a kernel
    // is made of the table.
    const double *samples;
    size_t count;   // required: 2 to WEFT_KERNEL_TABLE_MAX_SAMPLES
    double support; // required: half-width r, above 0, up to WEFT_KERNEL_MAX_WIDTH / 2
    bool whole;     // samples span [-r, r]; default: [0, r], the other half is its mirror image
    enum weft_kernel_between between; // default linear
    const struct weft_log *log;       // may be NULL
};
#define WEFT_KERNEL_TABLE_DEFAULTS
#define weft_kernel_table_params(...)                                                              \
    (&(struct weft_kernel_table_params){WEFT_KERNEL_TABLE_DEFAULTS __VA_ARGS__})

// A table as a record. The record refers to the struct around it, so that this must neither move
// nor end while a kernel is made of it. Allocates nothing: there is nothing to destroy. Read-only
// once initialised, and then thread-safe; all members but info are private.
struct weft_kernel_table {
    struct weft_kernel_info info; // for weft_kernel_create, which takes no parameters of it
    const double *samples;        // borrowed from the params
    double support, last;         // index of the last sample
    bool whole;
    enum weft_kernel_between between;
};

// Makes the record; tables that end on other than zero jump there, as nearest does. The record says
// whether the table interpolates and whether it ends on zeros; order and unit_sum stay unknown
// (weft_analysis_order, weft_kernel_normalise). On failure `out` is all zero. Returns
// WEFT_ERR_ARGUMENT (also for samples that are not finite) or WEFT_ERR_LIMIT.
WEFT_API enum weft_result weft_kernel_table_init(const struct weft_kernel_table_params *params,
                                                 struct weft_kernel_table *out);

WEFT_END_DECLS
#endif
