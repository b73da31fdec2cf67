// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/sets.h - the records behind weft_jitter_list (not installed).
#ifndef WEFT_PASSES_JITTER_SETS_H
#define WEFT_PASSES_JITTER_SETS_H

#include "passes/jitter/jitter.h"

WEFT_BEGIN_DECLS

// tables.c: j2 to j66, in order, and the multisample positions.
enum { WEFT_JITTER_TABLES = 7 };
extern const struct weft_jitter_info weft_jitter_tables[WEFT_JITTER_TABLES];
extern const struct weft_jitter_info weft_jitter_msaa;

// cells.c
extern const struct weft_jitter_info weft_jitter_grid, weft_jitter_stratified;

// sequences.c
extern const struct weft_jitter_info weft_jitter_halton, weft_jitter_hammersley, weft_jitter_sobol,
    weft_jitter_r2;

WEFT_END_DECLS
#endif
