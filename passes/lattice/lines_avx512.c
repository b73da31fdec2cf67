// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_lattice_lines_avx512
#define WEFT_DOUBLES 8
#ifdef __x86_64__
#include "passes/lattice/lines_body.h"
#else
typedef int weft_no_avx512_lattice; // of other processors
#endif
