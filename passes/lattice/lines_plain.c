// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_lattice_lines_plain
#define WEFT_DOUBLES 2
#include "passes/lattice/lines_body.h"
