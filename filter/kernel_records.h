// SPDX-License-Identifier: BSD-3-Clause
// filter/kernel_records.h - the records behind weft_kernel_list, one file per family (not
// installed).
#ifndef WEFT_FILTER_KERNEL_RECORDS_H
#define WEFT_FILTER_KERNEL_RECORDS_H

#include "filter/kernel.h"

WEFT_BEGIN_DECLS

// kernel_cubic.c
extern const struct weft_kernel_info weft_kernel_cubic, weft_kernel_catmull_rom,
    weft_kernel_mitchell;

// kernel_bspline.c
extern const struct weft_kernel_info weft_kernel_nearest, weft_kernel_linear, weft_kernel_bspline;
extern const struct weft_kernel_info weft_kernel_bspline_degree[6];

WEFT_END_DECLS
#endif
