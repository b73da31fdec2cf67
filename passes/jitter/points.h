// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/points.h - checks of samples that a caller gives (not installed).
#ifndef WEFT_PASSES_JITTER_POINTS_H
#define WEFT_PASSES_JITTER_POINTS_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Whether all coordinates are finite; a line in the log names the first sample that is not.
bool weft_points_check(const struct weft_log *log, const double (*points)[2], int count);

WEFT_END_DECLS
#endif
