// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_axes.h - a kernel's derivatives along the axes (not installed).
#ifndef WEFT_FILTER_KERNELS_KERNEL_AXES_H
#define WEFT_FILTER_KERNELS_KERNEL_AXES_H

#include "filter/kernels/kernel.h"

// The kernel of an axis along which is derived 0, 1 or 2 times; `out` may be `kernel`. Returns as
// weft_kernel_derive.
static inline enum weft_result weft_kernel_derive_times(const struct weft_log *log,
                                                        const struct weft_kernel *kernel, int times,
                                                        struct weft_kernel *out)
{
    enum weft_result res = WEFT_OK;
    if (out != kernel)
        *out = *kernel;
    for (int i = 0; i < times && res == WEFT_OK; i++)
        res = weft_kernel_derive(log, out, out);
    return res;
}

#endif
