// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "filter/half.h"
#include "passes/accumulate/frame.h"

// Sums in units of 2^-64 / 65535, in which floats from 2^-41 on, halves, integers and codes are
// whole numbers.
__extension__ typedef __int128 wide;
__extension__ typedef unsigned __int128 unsigned_wide;

enum { UNIT_BITS = 64, LARGEST_CODE = 65535 };

struct exact {
    wide *sum;      // [channel][y][x]
    double largest; // of all |values|
};

static size_t pixel_count(const weft_accumulator *a)
{
    return (size_t)a->params.width * (size_t)a->params.height;
}

static enum weft_result create(weft_accumulator *a)
{
    struct exact *own = a->own = calloc(1, sizeof *own);
    if (own)
        own->sum = calloc(pixel_count(a) * (size_t)a->params.channel_count, sizeof *own->sum);
    if (!own || !own->sum) {
        weft_error(a->params.log,
                   "accumulate: not enough memory for the sums of %" PRId32 " x %" PRId32 " pixels",
                   a->params.width, a->params.height);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

static void destroy(weft_accumulator *a)
{
    struct exact *own = a->own;
    if (own)
        free(own->sum);
    free(own);
    a->own = NULL;
}

// Code as 1 / 65535; what is none, as a double.
static bool is_code(const struct weft_plane *plane, size_t at, double *out)
{
    const void *values = plane->values;
    switch (plane->type) {
    case WEFT_PLANE_UNORM8:
        *out = ((const uint8_t *)values)[at] * 257.0;
        return true;
    case WEFT_PLANE_UNORM16:
        *out = ((const uint16_t *)values)[at];
        return true;
    case WEFT_PLANE_HALF:
        *out = (double)weft_half_to_float(((const uint16_t *)values)[at]);
        return false;
    case WEFT_PLANE_UINT:
        *out = ((const uint32_t *)values)[at];
        return false;
    default:
        *out = (double)((const float *)values)[at];
        return false;
    }
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    const size_t width = (size_t)a->params.width, count = pixel_count(a);
    const struct weft_plane *planes;
    struct exact *own = a->own;
    enum weft_result res = weft_frame_planes(a, frame, &planes);
    if (res != WEFT_OK)
        return res;
    for (int check = 1; check >= 0; check--)
        for (int c = 0; c < a->params.channel_count; c++) {
            const struct weft_plane *plane = &planes[c];
            const size_t step = plane->step ? plane->step : 1;
            const size_t stride = plane->stride ? plane->stride : width * step;
            for (size_t i = 0; i < count; i++) {
                double value;
                const bool code = is_code(plane, i / width * stride + i % width * step, &value);
                if (check && (!isfinite(value) || !(fabs(value * weight) < 0x1p22))) {
                    weft_error(a->params.log,
                               "accumulate: frame %" PRId64
                               ", channel %d, pixel (%zu, %zu) is %g%s",
                               a->frames, c, i % width, i / width, value,
                               isfinite(value) ? ": beyond what sums take" : "");
                    return isfinite(value) ? WEFT_ERR_LIMIT : WEFT_ERR_FORMAT;
                }
                if (check) {
                    own->largest = fmax(own->largest, code ? value / LARGEST_CODE : fabs(value));
                    continue;
                }
                const wide term = (wide)nearbyint(ldexp(value * weight, UNIT_BITS));
                own->sum[(size_t)c * count + i] += code ? term : term * LARGEST_CODE;
            }
        }
    return WEFT_OK;
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const struct exact *own = a->own;
    const size_t width = (size_t)a->params.width, count = pixel_count(a);
    const wide *sum = own->sum + (size_t)channel * count;
    const double unit = ldexp(a->total_weight * LARGEST_CODE, UNIT_BITS);
    for (size_t i = 0; i < count; i++)
        out[i / width * stride + i % width] = (float)((double)sum[i] / unit);
    return WEFT_OK;
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct exact *own = a->own;
    out->bound = own->largest * 0x1p-24;
    out->bytes = pixel_count(a) * (size_t)a->params.channel_count * sizeof *own->sum;
}

const struct weft_accumulate_way weft_accumulate_exact = {
    .method = WEFT_ACCUMULATE_EXACT,
    .negative = true,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .report = report,
};
