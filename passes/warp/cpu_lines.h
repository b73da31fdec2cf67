// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/cpu_lines.h - the loops of the CPU engine (not installed). Included by cpu_body.h
// once for each precision, with
//   NUMBER     what sums are made in
//   NAME(x)    x, with what makes it one of its kind
// Vectors are those of GCC and Clang, of as many lanes as a kernel has taps; whether products and
// sums are rounded once or twice is up to the file's flags, the same for every pixel.

#define LANES 4
#define SIZED(x) NAME(x##_of_4)
#include "passes/warp/cpu_pixels.h"
#undef LANES
#undef SIZED
#define LANES 8
#define SIZED(x) NAME(x##_of_8)
#include "passes/warp/cpu_pixels.h"
#undef LANES
#undef SIZED
#define LANES 16
#define SIZED(x) NAME(x##_of_16)
#include "passes/warp/cpu_pixels.h"
#undef LANES
#undef SIZED

// The taps of most kernels are constants of a loop of their own.
static void NAME(line)(const struct weft_warp_line *line)
{
    switch (line->taps->width) {
    case 2:
        NAME(pixels_of_4)(line, 2);
        break;
    case 4:
        NAME(pixels_of_4)(line, 4);
        break;
    case 6:
        NAME(pixels_of_8)(line, 6);
        break;
    case 8:
        NAME(pixels_of_8)(line, 8);
        break;
    default:
        if (line->taps->lanes == 4)
            NAME(pixels_of_4)(line, line->taps->width);
        else if (line->taps->lanes == 8)
            NAME(pixels_of_8)(line, line->taps->width);
        else
            NAME(pixels_of_16)(line, line->taps->width);
    }
}

static void NAME(box)(const struct weft_warp_box *box)
{
    const NUMBER *wx = box->weights[0], *wy = box->weights[1];
    for (int c = 0; c < box->channels; c++) {
        const float *row = box->values[c] + box->start;
        NAME(vector_of_8) sum = {0};
        for (int j = 0; j < box->rows; j++, row += box->pitch) {
            NAME(vector_of_8) along = {0};
            for (int i = 0; i < box->columns; i += 8)
                along += NAME(load_of_8)(row + i) * NAME(numbers_of_8)(wx + i);
            sum += along * wy[j];
        }
        *box->out[c] = (float)NAME(add_up_of_8)(sum);
    }
}

static const struct weft_warp_lines NAME(lines) = {sizeof(NUMBER), NAME(line), NAME(box)};

#undef NUMBER
#undef NAME
