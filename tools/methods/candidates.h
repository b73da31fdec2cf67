// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/candidates.h - what --max-error compared, of `weft slice` and `weft resample`
// alike.
#ifndef WEFT_TOOLS_METHODS_CANDIDATES_H
#define WEFT_TOOLS_METHODS_CANDIDATES_H

#include "tools/common/json.h"
#include "weft.h"

// One candidate: name, state, estimated, seconds, bytes, bound; of passes technique, resolution and
// bits, too. NULL: out of memory.
json_t *candidate_json(const struct weft_candidate *candidate);

// A table of candidates, a row each, on stdout: name, ms, MB, the bound and the state. ">" stands
// before the least figures of those that were not planned. `bound` heads the bounds.
void candidates_print(const struct weft_candidate *candidates, size_t count, const char *bound);

#endif
