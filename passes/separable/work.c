// SPDX-License-Identifier: BSD-3-Clause
#include "passes/separable/work.h"

#include <math.h>

struct weft_separable_work weft_separable_work_of(int width, double sample_columns,
                                                  double sample_rows, double columns, double rows)
{
    const double between = fmin(columns * sample_rows, sample_columns * rows);
    return (struct weft_separable_work){
        .width = width,
        .summed = sample_columns * sample_rows,
        .taps = width * (columns * rows + between),
    };
}
