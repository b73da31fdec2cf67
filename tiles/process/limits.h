// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/limits.h - what a reader process may use before it is stopped.
#ifndef WEFT_TILES_PROCESS_LIMITS_H
#define WEFT_TILES_PROCESS_LIMITS_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// File decoders run in their own processes (weft-read-vdb, weft-read-exr), because a damaged file
// may make them crash, run forever or ask for any amount of memory. A process that exceeds a limit
// is ended, and the call that it worked for returns WEFT_ERR_LIMIT, or WEFT_ERR_READER where it
// crashed on the way. Zero means the default. For OBJ, PLY and GLB files the default of
// memory_bytes is 256 MiB and 256 times the file's bytes, at most 4 GiB.
struct weft_limits {
    uint64_t memory_bytes; // address space beside the mapped file (default 4 GiB; VDB files: see
                           // weft_volume_open)
    uint64_t output_bytes; // that one answer may have             (default 4 GiB)
    uint32_t cpu_seconds;  // processor time over its whole life   (default 600)
    uint32_t wall_seconds; // that any one answer may take         (default 300)
};

WEFT_END_DECLS
#endif
