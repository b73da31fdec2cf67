// SPDX-License-Identifier: BSD-3-Clause
// tiles/kernel/kernel_file.h - kernels by their text, those in files included.
// A kernel file is text: words and numbers separated by white space, '#' to the end of a line is a
// comment. The words are `support R` (half-width, required), `half` (default) or `whole`, `linear`
// (default) or `cubic`, as in filter/kernels/kernel_table.h; the numbers are the samples. A half
// tent:
//     support 1  linear
//     1 0.5 0
#ifndef WEFT_TILES_KERNEL_KERNEL_FILE_H
#define WEFT_TILES_KERNEL_KERNEL_FILE_H

#include "../../filter/kernels/kernel.h"

WEFT_BEGIN_DECLS

// The longest kernel file; longer ones are refused with WEFT_ERR_LIMIT.
enum { WEFT_KERNEL_FILE_MAX_BYTES = 32 << 20 };

// The samples of a kernel file. Thread-safety: read-only once loaded.
typedef struct weft_kernel_file weft_kernel_file;

// Reads "table:FILE", with "+radial" and "+unit" behind it as weft_kernel_parse has them, and
// everything that weft_kernel_parse reads. Kernels from files refer to *file, which must outlive
// them and which the caller destroys; *file is NULL for other kernels, and on failure, when *out is
// all zero. Returns WEFT_ERR_ARGUMENT, _OPEN (also for what is not a regular file), _FORMAT (the
// log has the line), _LIMIT or _MEMORY.
WEFT_API enum weft_result weft_kernel_load(const struct weft_log *log, const char *text,
                                           struct weft_kernel *out, weft_kernel_file **file);
// Frees what weft_kernel_load made. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_kernel_file_destroy(weft_kernel_file **file);

WEFT_END_DECLS
#endif
