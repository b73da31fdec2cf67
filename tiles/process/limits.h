// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/limits.h - what a reader process may use before it is stopped.
#ifndef WEFT_TILES_PROCESS_LIMITS_H
#define WEFT_TILES_PROCESS_LIMITS_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// File decoders run in their own processes (weft-read-vdb, weft-read-exr), because a damaged file
// may make them crash, run forever or ask for any amount of memory. Zero means the default.
struct weft_limits {
    uint64_t memory_bytes; // address space beside the mapped file (default 4 GiB)
    uint64_t output_bytes; // handed over in one answer            (default 4 GiB)
    uint32_t cpu_seconds;  // processor time over its whole life   (default 600)
    uint32_t wall_seconds; // for any one answer                   (default 300)
};

WEFT_END_DECLS
#endif
