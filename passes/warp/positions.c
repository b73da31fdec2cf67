// SPDX-License-Identifier: BSD-3-Clause
// Where pixels lie, by how much kernels are stretched there, and by which weights. All in double,
// by one piece of code for every engine and the verifier.
#include <math.h>

#include "passes/warp/warp_impl.h"

// ---- positions ----------------------------------------------------------------------------------

static void set_affine(const struct weft_warp_plan *plan, int x, int y, int count,
                       struct weft_warp_row *row)
{
    for (int a = 0; a < 2; a++) {
        const double *m = plan->info.inverse + 3 * a;
        const double start = m[1] * y + m[2];
        for (int i = 0; i < count; i++)
            row->at[a][i] = m[0] * (x + i) + start;
        for (int i = 0; plan->stretches && i < count; i++)
            row->scale[a][i] = plan->info.scale[a];
    }
}

static void set_projective(const struct weft_warp_plan *plan, int x, int y, int count,
                           struct weft_warp_row *row)
{
    const double *w = plan->info.inverse + 6;
    for (int a = 0; a < 2; a++) {
        const double *m = plan->info.inverse + 3 * a;
        const double start = m[1] * y + m[2], start_w = w[1] * y + w[2];
        for (int i = 0; i < count; i++)
            row->at[a][i] = (m[0] * (x + i) + start) / (w[0] * (x + i) + start_w);
        for (int i = 0; plan->stretches && i < count; i++) {
            const double at = row->at[a][i], u = m[0] - at * w[0], v = m[1] - at * w[1];
            row->scale[a][i] = sqrt(u * u + v * v) / (w[0] * (x + i) + start_w);
        }
    }
}

static double given(const struct weft_warp_plan *plan, int a, int x, int y)
{
    return (double)plan->map.position[a][y * plan->map.stride + x];
}

// Half the difference of two neighbours, or the whole one to the only one.
static double difference(const struct weft_warp_plan *plan, int a, int x, int y, int along)
{
    const int at = along ? y : x, last = (along ? plan->info.height : plan->info.width) - 1;
    const int from = at > 0 ? at - 1 : at, to = at < last ? at + 1 : at;
    if (from == to)
        return 0.0;
    const double low = along ? given(plan, a, x, from) : given(plan, a, from, y);
    const double high = along ? given(plan, a, x, to) : given(plan, a, to, y);
    return (high - low) / (to - from);
}

static double given_scale(const struct weft_warp_plan *plan, int a, int x, int y)
{
    const double u = difference(plan, a, x, y, 0), v = difference(plan, a, x, y, 1);
    return sqrt(u * u + v * v);
}

static void set_given(const struct weft_warp_plan *plan, int x, int y, int count,
                      struct weft_warp_row *row)
{
    for (int a = 0; a < 2; a++) {
        const double corner = plan->map.source_corner[a] + 0.5;
        for (int i = 0; i < count; i++)
            row->at[a][i] = given(plan, a, x + i, y) - corner;
        for (int i = 0; plan->stretches && i < count; i++)
            row->scale[a][i] = given_scale(plan, a, x + i, y);
    }
}

// ---- first taps ---------------------------------------------------------------------------------

static int32_t modulo(int64_t index, int64_t period)
{
    const int64_t rest = index % period;
    return (int32_t)(rest < 0 ? rest + period : rest);
}

int32_t weft_warp_reduce(const struct weft_warp_plan *plan, int axis, int64_t first, int taps)
{
    const int64_t size = plan->values[axis];
    if (first >= 0 && first + taps <= size)
        return (int32_t)first;
    switch (plan->info.boundary) {
    case WEFT_BOUNDARY_MIRROR:
        return size > 1 ? modulo(first, 2 * (size - 1)) : 0;
    case WEFT_BOUNDARY_WRAP:
        return modulo(first, size);
    default:
        return (int32_t)(first < -taps ? -taps : first > size ? size : first);
    }
}

// weft_kernel_first_tap without its calls: positions are small numbers.
static void set_taps(const struct weft_warp_plan *plan, int count, struct weft_warp_row *row)
{
    const int width = plan->info.kernel.width;
    const double half = width % 2 ? 0.5 : 0.0;
    const int32_t before = width % 2 ? (width - 1) / 2 : width / 2 - 1;
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < count; i++) {
            const double at = row->at[a][i] + plan->info.overlap, moved = at + half;
            int32_t floor = (int32_t)moved;
            floor -= (double)floor > moved;
            row->fraction[a][i] = moved - (double)floor;
            row->first[a][i] = floor - before;
        }
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < count; i++)
            row->first[a][i] = weft_warp_reduce(plan, a, row->first[a][i], width);
}

// Scales that are none are told apart here, for all who ask; rounding makes none larger than what
// the plan has room for.
static void settle_scales(const struct weft_warp_plan *plan, int count, struct weft_warp_row *row)
{
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < count; i++) {
            const double scale = fmin(row->scale[a][i], plan->info.scale[a]);
            row->scale[a][i] = scale > WEFT_WARP_SCALE_NONE ? scale : 1.0;
        }
}

void weft_warp_row_set(const struct weft_warp_plan *plan, int x, int y, int count,
                       struct weft_warp_row *row)
{
    if (plan->info.method == WEFT_WARP_PLANES)
        set_given(plan, x, y, count, row);
    else if (plan->info.method == WEFT_WARP_PROJECTIVE)
        set_projective(plan, x, y, count, row);
    else
        set_affine(plan, x, y, count, row);
    if (plan->stretches)
        settle_scales(plan, count, row);
    else
        set_taps(plan, count, row);
}

void weft_warp_position(const weft_warp_plan *plan, int x, int y, double position[2],
                        double scale[2])
{
    struct weft_warp_row row;
    const bool is = x >= 0 && y >= 0 && x < plan->info.width && y < plan->info.height;
    if (is)
        weft_warp_row_set(plan, x, y, 1, &row);
    for (int a = 0; a < 2; a++) {
        position[a] = is ? row.at[a][0] : (double)NAN;
        scale[a] = !is ? (double)NAN : plan->stretches ? row.scale[a][0] : 1.0;
    }
}

// ---- positions that are given -------------------------------------------------------------------

static enum weft_result refuse(const struct weft_warp_plan *plan, int x, int y, uint64_t count)
{
    weft_error(plan->log,
               "a warp whose pixel (%d, %d) shows the point (%g, %g): positions must be finite and "
               "within %d; %llu of %d x %d are not",
               x, y, given(plan, 0, x, y), given(plan, 1, x, y), WEFT_WARP_MAX_POSITION,
               (unsigned long long)count, plan->info.width, plan->info.height);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_warp_set_positions(struct weft_warp_plan *plan)
{
    struct weft_warp_info *info = &plan->info;
    int bad[2] = {0, 0};
    uint64_t count = 0;
    info->method = WEFT_WARP_PLANES;
    for (int y = 0; y < info->height; y++)
        for (int x = 0; x < info->width; x++) {
            bool good = true;
            for (int a = 0; a < 2; a++)
                good = good && fabs(given(plan, a, x, y)) <= WEFT_WARP_MAX_POSITION;
            if (!good && count++ == 0) {
                bad[0] = x;
                bad[1] = y;
            }
        }
    if (count)
        return refuse(plan, bad[0], bad[1], count);
    for (int a = 0; a < 2; a++) {
        info->scale[a] = 1.0;
        for (int y = 0; !info->unstretched && y < info->height; y++)
            for (int x = 0; x < info->width; x++)
                info->scale[a] = fmax(info->scale[a], given_scale(plan, a, x, y));
    }
    return WEFT_OK;
}

// ---- stretched kernels --------------------------------------------------------------------------

// What of each sample's unit square lies within scale / 2 of a position.
static void cover(double at, double scale, int64_t first, int count, double *weights)
{
    const double from = at - 0.5 * scale, to = at + 0.5 * scale;
    for (int i = 0; i < count; i++) {
        const double middle = (double)(first + i);
        weights[i] = fmax(fmin(to, middle + 0.5) - fmax(from, middle - 0.5), 0.0) / scale;
    }
}

// h at a distance: tap j = ceil(c - d) has it at the fraction j - (c - d).
static double look_up(const struct weft_polynomial_tiles *tiles, double below)
{
    const double tap = ceil(below);
    if (!(tap >= 0.0 && tap < tiles->width))
        return 0.0;
    const double scaled = (tap - below) * tiles->segments;
    const int segment = scaled < tiles->segments ? (int)scaled : tiles->segments - 1;
    const int stride = 4 * tiles->groups;
    const double *c =
        tiles->precise + (size_t)segment * (size_t)((tiles->degree + 1) * stride) + (int)tap;
    const double u = scaled - segment;
    double sum = c[tiles->degree * stride];
    for (int p = tiles->degree - 1; p >= 0; p--)
        sum = sum * u + c[p * stride];
    return sum;
}

static void normalise(const struct weft_kernel *kernel, double scale, int count, double *weights)
{
    double divisor = 0.0;
    if (kernel->unit_sum && kernel->info->derivation == 0)
        for (int i = 0; i < count; i++)
            divisor += weights[i];
    else
        divisor = pow(scale, 1 + kernel->info->derivation);
    for (int i = 0; i < count; i++)
        weights[i] /= divisor;
}

int weft_warp_weights(const struct weft_warp_plan *plan, double at, double scale, int64_t *first,
                      double *weights)
{
    const struct weft_kernel *kernel = &plan->plain;
    const struct weft_polynomial_tiles *tiles = &plan->weights->tiles;
    double fraction;
    if (scale == 1.0) {
        *first = weft_kernel_first_tap(kernel, at, &fraction);
        for (int i = 0; i < kernel->width; i++)
            weights[i] = look_up(tiles, i - fraction);
        return kernel->width;
    }
    const int count = (int)ceil(2.0 * kernel->support * scale) + (kernel->width == 1);
    if (kernel->width == 1) {
        *first = (int64_t)floor(at - 0.5 * scale + 0.5);
        cover(at, scale, *first, count, weights);
        return count;
    }
    const double offset = weft_kernel_offset(kernel), step = 1.0 / scale;
    *first = (int64_t)floor(at - kernel->support * scale) + 1;
    for (int i = 0; i < count; i++)
        weights[i] = look_up(tiles, offset - (at - (double)(*first + i)) * step);
    normalise(kernel, scale, count, weights);
    return count;
}
