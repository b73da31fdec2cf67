// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/points.h"

#include <math.h>

#include "filter/check.h"

bool weft_points_check(const struct weft_log *log, const double (*points)[2], int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(points[i][0]) || !isfinite(points[i][1])) {
            weft_error(log, "sample %d of %d is (%g, %g): not finite", i, count, points[i][0],
                       points[i][1]);
            return false;
        }
    return true;
}
