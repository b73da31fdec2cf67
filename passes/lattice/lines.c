// SPDX-License-Identifier: BSD-3-Clause
#include "passes/lattice/lattice_impl.h"

struct weft_lattice_lines weft_lattice_lines_find(enum weft_instruction_set instructions)
{
    switch (instructions) {
#if defined(__x86_64__)
    case WEFT_INSTRUCTIONS_AVX512:
        return weft_lattice_lines_avx512;
    case WEFT_INSTRUCTIONS_AVX2:
        return weft_lattice_lines_avx2;
    case WEFT_INSTRUCTIONS_SSE2:
        return weft_lattice_lines_sse2;
#endif
    default:
        return weft_lattice_lines_plain;
    }
}
