// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_table.h - a kernel from samples of it.
#ifndef WEFT_FILTER_KERNELS_KERNEL_TABLE_H
#define WEFT_FILTER_KERNELS_KERNEL_TABLE_H

#include "kernel.h"

WEFT_BEGIN_DECLS

enum { WEFT_KERNEL_TABLE_MAX_SAMPLES = 1 << 20 };

enum weft_kernel_between {
    WEFT_KERNEL_BETWEEN_LINEAR,
    WEFT_KERNEL_BETWEEN_CUBIC, // Hermite with central differences as slopes (Catmull and Rom 1974)
};

struct weft_kernel_table_params {
    const char *name;      // of the record (default "table")
    const double *samples; // uniformly spaced, first and last at the ends; borrowed with the table
    size_t count;          // 2 to WEFT_KERNEL_TABLE_MAX_SAMPLES
    double support;        // half-width r, up to WEFT_KERNEL_MAX_WIDTH / 2
    bool whole; // samples span [-r, r]; default: [0, r], the other half is its mirror image
    enum weft_kernel_between between;
    const struct weft_log *log;
};

// The record refers to the struct around it: stay where you are.
struct weft_kernel_table {
    struct weft_kernel_info info; // for weft_kernel_create
    const double *samples;
    double support, last; // index of the last sample
    bool whole;
    enum weft_kernel_between between;
};

// The record says whether the table interpolates and whether it ends on zeros; order and unit_sum
// stay unknown (weft_analysis_order, weft_kernel_normalise). On failure `out` is all zero.
// Returns WEFT_ERR_ARGUMENT (also for samples that are not finite) or WEFT_ERR_LIMIT.
WEFT_API enum weft_result weft_kernel_table_init(const struct weft_kernel_table_params *params,
                                                 struct weft_kernel_table *out);

WEFT_END_DECLS
#endif
