// SPDX-License-Identifier: BSD-3-Clause
// filter/closest.h - "did you mean": the name that a mistyped one stands for.
// Two names are compared by the least number of letters that are put in, left out, replaced or
// swapped with their neighbour (optimal string alignment); capitals and small letters are alike,
// and so are '-', '_' and ' '. Pure and thread-safe.
#ifndef WEFT_FILTER_CLOSEST_H
#define WEFT_FILTER_CLOSEST_H

#include "base.h"

WEFT_BEGIN_DECLS

// Finds the name nearest to the first `length` bytes of `text` in a NULL-ended list. A name counts
// as near when at most a third of its letters differ (one may where it has three to five, none
// where it has fewer), or when `text` is its beginning, of three letters or more. Of names equally
// near the first one is returned; NULL where none is near. Texts and names of more than 63 bytes
// are near to nothing. The result points into `names`.
WEFT_API const char *weft_closest_find(const char *text, size_t length, const char *const *names);

// Writes what stands behind a name in a message that it is none of a list's: "; did you mean NAME?
// There are NAME, NAME, ..." where one is near, else "; there are NAME, NAME, ...". Cut to size and
// NUL-terminated when size > 0. Returns out.
WEFT_API const char *weft_closest_explain(const char *text, size_t length, const char *const *names,
                                          char *out, size_t size);

WEFT_END_DECLS
#endif
