// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "filter/kernels/kernel_records.h"
#include "tiles/kernel/kernel_tiles_impl.h"

// ---- sampling -----------------------------------------------------------------------------------

double weft_kernel_tiles_position(const weft_kernel_tiles *tiles, int k)
{
    const double m = tiles->info.samples;
    if (k < 0 || k >= m)
        return NAN;
    return tiles->info.placement == WEFT_TILE_ENDS ? k / (m - 1.0) : (k + 0.5) / m;
}

// At a tile's end the limit from inside: the next knot belongs to the next tap. One step of a
// fraction below it, also where the knot is 0: kernels add to x, which rounds the least step away.
static double exact_weight(const weft_kernel_tiles *set, const struct weft_kernel *kernel, int k,
                           int tap)
{
    const double fraction = fmin(weft_kernel_tiles_position(set, k), 1.0 - 0x1p-53);
    return weft_kernel_weight(kernel,
                              weft_kernel_argument(fraction, weft_kernel_offset(kernel) - tap));
}

// The offset of a radial kernel's tap, from inside at both ends: its ball ends at the far one, and
// what jumps there would not be symmetric.
static double exact_offset(const weft_kernel_tiles *set, int k, int tap)
{
    const double shift = weft_kernel_offset(&set->info.kernel) - tap;
    const double x = weft_kernel_tiles_position(set, k) + shift;
    return fmax(nextafter(shift, INFINITY), fmin(nextafter(shift + 1.0, -INFINITY), x));
}

static double *axis_at(const weft_kernel_tiles *set, const struct weft_tiles_axis *axis, int k,
                       int tap)
{
    return &axis->weights[(size_t)k * (size_t)set->info.width + (size_t)tap];
}

static double *mirror_of(const weft_kernel_tiles *set, const struct weft_tiles_axis *axis, int k,
                         int tap)
{
    return axis_at(set, axis, set->info.samples - 1 - k, set->info.width - 1 - tap);
}

// Exactly odd, so that reflected taps are at the same distance.
static void sample_offsets(const weft_kernel_tiles *set, const struct weft_tiles_axis *axis)
{
    for (int k = 0; k < set->info.samples; k++) {
        for (int t = 0; t < set->info.width; t++) {
            const double x = exact_offset(set, k, t);
            *axis_at(set, axis, k, t) = x;
            *mirror_of(set, axis, k, t) = -x;
        }
    }
}

void weft_tiles_sample(const weft_kernel_tiles *set, struct weft_tiles_axis *axis)
{
    const int m = set->info.samples, width = set->info.width;
    axis->even = weft_kernel_is_radial(&axis->kernel, set->info.dims);
    if (axis->even) {
        sample_offsets(set, axis);
        return;
    }
    double largest = 0.0, even_error = 0.0, odd_error = 0.0;
    for (int k = 0; k < m; k++) {
        for (int t = 0; t < width; t++) {
            const double w = exact_weight(set, &axis->kernel, k, t);
            *axis_at(set, axis, k, t) = w;
            largest = fmax(largest, fabs(w));
        }
    }
    for (int k = 0; k < m; k++) {
        for (int t = 0; t < width; t++) {
            const double a = *axis_at(set, axis, k, t), b = *mirror_of(set, axis, k, t);
            even_error = fmax(even_error, fabs(a - b));
            odd_error = fmax(odd_error, fabs(a + b));
        }
    }
    // Derivatives lose digits near the knots, none that a tile could show.
    axis->even = even_error <= 1e-11 * largest;
    axis->odd = !axis->even && odd_error <= 1e-11 * largest;
    if (!axis->even && !axis->odd)
        return;
    for (int k = 0; k < m; k++) {
        for (int t = 0; t < width; t++) {
            double *a = axis_at(set, axis, k, t), *b = mirror_of(set, axis, k, t);
            if (axis->odd && a == b)
                *a = 0.0;
            else if (a < b)
                *b = axis->odd ? -*a : *a;
        }
    }
}

// ---- one value ----------------------------------------------------------------------------------

// Products a hair off an integer are that integer: 254.9999999999 is 255 to truncation too.
static double snap(double x)
{
    const double whole = nearbyint(x);
    return fabs(x - whole) < 1e-9 ? whole : x;
}

static double quantise_integer(double x, enum weft_tile_rounding rounding)
{
    const double s = snap(x);
    return rounding == WEFT_TILE_TRUNCATED ? trunc(s) : trunc(s + copysign(0.5, s));
}

// Halves: 11 significant bits, steps of 2^-24 below 2^-14.
static double quantise_half(double x, bool truncated)
{
    if (x == 0.0)
        return 0.0;
    const int exponent = ilogb(x) < -14 ? -14 : ilogb(x);
    const double steps = ldexp(x, 10 - exponent);
    return ldexp(truncated ? trunc(steps) : nearbyint(steps), exponent - 10);
}

static double quantise_float(double x, bool truncated)
{
    const float f = (float)x;
    return (double)(truncated && fabs((double)f) > fabs(x) ? nextafterf(f, 0.0f) : f);
}

static double quantise(const weft_kernel_tiles *set, double x)
{
    const bool truncated = set->info.rounding == WEFT_TILE_TRUNCATED;
    switch (set->info.format) {
    case WEFT_TILE_UNORM:
    case WEFT_TILE_SNORM:
        return quantise_integer(x, set->info.rounding);
    case WEFT_TILE_HALF:
        return quantise_half(x, truncated);
    case WEFT_TILE_FLOAT:
        break;
    }
    return quantise_float(x, truncated);
}

// ---- all taps of a position ---------------------------------------------------------------------

struct position_values {
    int count;
    double *value, *rest, *scratch;
};

// The k-th largest (from 1) of `count` values, which are reordered (Hoare).
static double kth_largest(double *v, int count, int k)
{
    int low = 0, high = count - 1;
    while (low < high) {
        const double pivot = v[(low + high) / 2];
        int i = low, j = high;
        while (i <= j) {
            while (v[i] > pivot)
                i++;
            while (v[j] < pivot)
                j--;
            if (i <= j) {
                const double swapped = v[i];
                v[i++] = v[j];
                v[j--] = swapped;
            }
        }
        if (k - 1 <= j)
            high = j;
        else if (k - 1 >= i)
            low = i;
        else
            break;
    }
    return v[k - 1];
}

// Sums that are 1 or 0 but for rounding are so at every position, or the total would flicker.
static double clean_sum(double sum)
{
    return fabs(sum - 1.0) < 1e-9 ? 1.0 : fabs(sum) < 1e-9 ? 0.0 : sum;
}

// Largest remainder: all are rounded down, then those that lose most go one up until the sum is
// right. A value that is an integer already is never touched, so that signs and zeros stay.
static void quantise_together(struct position_values *p, double unit)
{
    double sum = 0.0, floors = 0.0;
    for (int i = 0; i < p->count; i++) {
        sum += p->value[i];
        const double x = snap(p->value[i] * unit), down = floor(x);
        p->rest[i] = p->scratch[i] = x - down;
        p->value[i] = down;
        floors += down;
    }
    int missing = (int)(quantise_integer(clean_sum(sum) * unit, WEFT_TILE_NEAREST) - floors);
    if (missing <= 0)
        return;
    missing = missing < p->count ? missing : p->count;
    const double level = kth_largest(p->scratch, p->count, missing);
    for (int i = 0; i < p->count; i++) {
        if (p->rest[i] > level) {
            p->value[i] += 1.0;
            missing--;
        }
    }
    for (int i = 0; i < p->count && missing > 0; i++) {
        if (p->rest[i] == level) {
            p->value[i] += 1.0;
            missing--;
        }
    }
}

int weft_tiles_weights(const weft_kernel_tiles *set, const int position[3], double *weights)
{
    const double *axis[3] = {NULL};
    for (int a = 0; a < set->info.dims; a++)
        axis[a] = axis_at(set, weft_tiles_axis_of(set, a), position[a], 0);
    return weft_kernel_combine(&set->info.kernel, set->info.dims, axis, weights);
}

// ---- into the stored tiles ----------------------------------------------------------------------

// Which kept taps a reflection brings there, along one axis, and their order.
struct axis_writes {
    int sample, sign;
    int first, step; // kept tap t comes from tap first + step * t
};

static struct axis_writes axis_writes(const weft_kernel_tiles *set, int a, int sample,
                                      bool reflected)
{
    if (!reflected)
        return (struct axis_writes){sample, 1, 0, 1};
    return (struct axis_writes){set->info.samples - 1 - sample,
                                weft_tiles_axis_of(set, a)->odd ? -1 : 1, set->info.width - 1, -1};
}

static void write_value(const weft_kernel_tiles *set, const int *stored_of, size_t sample, double q)
{
    if (!set->separate) {
        weft_tiles_store(set, set->stored[stored_of[0]].data, sample, q);
        return;
    }
    const int stored = stored_of[q < 0.0];
    if (q != 0.0 && stored >= 0)
        weft_tiles_store(set, set->stored[stored].data, sample, fabs(q));
}

static void write_reflection(const weft_kernel_tiles *set, const struct axis_writes axis[3],
                             const double *value)
{
    const int dims = set->info.dims, width = set->info.width;
    int at[3] = {0}, tap[3] = {0}, from[3] = {0}, sign = 1;
    for (int a = 0; a < dims; a++) {
        at[a] = axis[a].sample;
        sign *= axis[a].sign;
    }
    const size_t sample = weft_tiles_sample_index(set, at);
    const int *stored_of = set->stored_of;
    do {
        for (int a = 0; a < dims; a++)
            from[a] = axis[a].first + axis[a].step * tap[a];
        write_value(set, stored_of, sample, sign * value[weft_tiles_tap_index(set, from, width)]);
        stored_of += 2;
    } while (weft_tiles_next(dims, set->kept, tap));
}

// A position and, in a mirrored set, its reflections along every combination of axes.
static void write_position(const weft_kernel_tiles *set, const int position[3], const double *value)
{
    const int reflections = set->info.mirrored ? 1 << set->info.dims : 1;
    for (int r = 0; r < reflections; r++) {
        struct axis_writes axis[3] = {{0}};
        for (int a = 0; a < set->info.dims; a++)
            axis[a] = axis_writes(set, a, position[a], r >> a & 1);
        write_reflection(set, axis, value);
    }
}

// The factor of every tap and sign, where it is not the same for all.
static double scale_of(const weft_kernel_tiles *set, const int tap[3], double value)
{
    int kept[3];
    const int sign = weft_tiles_kept_tap(set, tap, kept);
    const int side = set->separate && sign * value < 0.0;
    const int stored = set->stored_of[2 * weft_tiles_tap_index(set, kept, set->kept) + side];
    return stored < 0 ? 1.0 : set->stored[stored].scale;
}

static void quantise_apart(const weft_kernel_tiles *set, struct position_values *p)
{
    const bool each = set->params.scaling == WEFT_TILE_SCALE_EACH;
    const double common = set->info.stored_count ? set->stored[0].scale : 1.0;
    int tap[3] = {0};
    for (int i = 0; i < p->count; i++) {
        const double scale = each ? scale_of(set, tap, p->value[i]) : common;
        p->value[i] = quantise(set, p->value[i] * scale * set->info.one);
        if (each)
            weft_tiles_next(set->info.dims, set->info.width, tap);
    }
}

enum weft_result weft_tiles_quantise(weft_kernel_tiles *set)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    struct position_values p = {.count = 1};
    for (int a = 0; a < set->info.dims; a++)
        p.count *= set->info.width;
    p.value = malloc(3 * (size_t)p.count * sizeof *p.value);
    if (!p.value) {
        weft_error(set->params.log, "tiles: not enough memory for %d weights", p.count);
        goto fail;
    }
    p.rest = p.value + p.count;
    p.scratch = p.rest + p.count;
    const int span = set->info.mirrored ? (set->info.samples + 1) / 2 : set->info.samples;
    const bool together = set->info.rounding == WEFT_TILE_SUM_PRESERVING && set->info.stored_count;
    int at[3] = {0};
    do {
        weft_tiles_weights(set, at, p.value);
        if (together)
            quantise_together(&p, set->stored[0].scale * set->info.one);
        else
            quantise_apart(set, &p);
        write_position(set, at, p.value);
    } while (weft_tiles_next(set->info.dims, span, at));
    res = WEFT_OK;
fail:
    free(p.value);
    return res;
}
