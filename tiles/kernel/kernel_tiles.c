// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/kernel/kernel_tiles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_axes.h"
#include "tiles/kernel/kernel_tiles_impl.h"

const char *const weft_tile_format_names[] = {"unorm", "snorm", "half", "float", NULL};
const char *const weft_tile_rounding_names[] = {"nearest", "truncated", "sum-preserving", NULL};
const char *const weft_tile_placement_names[] = {"centres", "ends", NULL};
const char *const weft_tile_signs_names[] = {"auto", "signed", "separate", NULL};
const char *const weft_tile_scaling_names[] = {"none", "set", "each", NULL};
const char *const weft_tile_part_names[] = {"whole", "+", "-", NULL};

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
static const double HALF_MAX = 65504.0;

static const int part_sign[2] = {1, -1};

// ---- what is asked ------------------------------------------------------------------------------

static bool check_bits(const struct weft_kernel_tiles_params *p)
{
    if (p->format == WEFT_TILE_UNORM && (p->bits < 4 || p->bits > 16)) {
        weft_error(p->log, "tiles: unorm takes 4 to 16 bits, not %d", p->bits);
        return false;
    }
    if (p->format == WEFT_TILE_SNORM && p->bits != 8 && p->bits != 16) {
        weft_error(p->log, "tiles: snorm takes 8 or 16 bits, not %d", p->bits);
        return false;
    }
    return true;
}

static bool check_derivative(const struct weft_kernel_tiles_params *p)
{
    const int order = weft_derivative_order(&p->derivative), *along = p->derivative.along;
    if (order < 0 || (p->dims < 2 && along[1]) || (p->dims < 3 && along[2])) {
        weft_error(p->log, "tiles: no derivative in %dD: %d times along x, %d along y, %d along z",
                   p->dims, along[0], along[1], along[2]);
        return false;
    }
    if (order && p->normalise) {
        weft_error(p->log, "tiles: the weights of a derivative add up to 0, not to 1");
        return false;
    }
    return true;
}

static bool check_max_scale(const struct weft_kernel_tiles_params *p)
{
    int exponent;
    if (p->max_scale == 0.0 || frexp(p->max_scale, &exponent) == 0.5)
        return true;
    weft_error(p->log, "tiles: the largest scale is a power of two, or 0, not %g", p->max_scale);
    return false;
}

static bool check_params(const struct weft_kernel_tiles_params *p)
{
    weft_require_enum(p->log, p->format, WEFT_TILE_FLOAT);
    weft_require_enum(p->log, p->rounding, WEFT_TILE_SUM_PRESERVING);
    weft_require_enum(p->log, p->placement, WEFT_TILE_ENDS);
    weft_require_enum(p->log, p->signs, WEFT_TILE_SEPARATE);
    weft_require_enum(p->log, p->scaling, WEFT_TILE_SCALE_EACH);
    if (p->dims < 1 || p->dims > 3) {
        weft_error(p->log, "tiles: dimension 1 to 3, not %d", p->dims);
        return false;
    }
    const int least = p->placement == WEFT_TILE_ENDS ? 2 : 1;
    if (p->samples < least || p->samples > WEFT_TILES_MAX_SAMPLES) {
        weft_error(p->log, "tiles: %d to %d samples per unit, not %d", least,
                   WEFT_TILES_MAX_SAMPLES, p->samples);
        return false;
    }
    const bool integer = p->format == WEFT_TILE_UNORM || p->format == WEFT_TILE_SNORM;
    if (p->rounding == WEFT_TILE_SUM_PRESERVING && !integer) {
        weft_error(p->log, "tiles: sum-preserving rounding is for integer formats");
        return false;
    }
    if (p->rounding == WEFT_TILE_SUM_PRESERVING && p->scaling == WEFT_TILE_SCALE_EACH) {
        weft_error(p->log, "tiles: no sum is preserved between tiles of different scales");
        return false;
    }
    return check_bits(p) && check_max_scale(p) && check_derivative(p);
fail:
    return false;
}

// The sum is in every weight: a set of a kernel whose sum vanishes is of no use.
static bool check_sums(const struct weft_kernel_tiles_params *p)
{
    if (!p->kernel.normalised || !weft_kernel_is_radial(&p->kernel, p->dims))
        return true;
    const struct weft_kernel_sums sums = weft_kernel_radial_sums(&p->kernel, p->dims);
    if (sums.least * sums.largest > 0.0)
        return true;
    weft_error(p->log,
               "tiles: radial weights of kernel %s add up to %g to %g in %dD: they cannot be "
               "divided by their sum",
               p->kernel.info->name, sums.least, sums.largest, p->dims);
    return false;
}

static void init_info(weft_kernel_tiles *set)
{
    const struct weft_kernel_tiles_params *p = &set->params;
    struct weft_kernel_tiles_info *info = &set->info;
    *info = (struct weft_kernel_tiles_info){.kernel = p->kernel,
                                            .derivative = p->derivative,
                                            .dims = p->dims,
                                            .samples = p->samples,
                                            .bits = p->bits,
                                            .format = p->format,
                                            .rounding = p->rounding,
                                            .placement = p->placement,
                                            .width = p->kernel.width,
                                            .one = 1.0,
                                            .value_bytes = sizeof(float),
                                            .tile_values = 1};
    if (weft_tiles_integer_format(set)) {
        info->value_bytes = sizeof(uint16_t);
        info->one = (double)((1 << (p->bits - (p->format == WEFT_TILE_SNORM))) - 1);
    } else {
        info->bits = p->format == WEFT_TILE_HALF ? 16 : 32;
    }
    for (int a = 0; a < p->dims; a++)
        info->tile_values *= (size_t)p->samples; // at most 2^36
    set->separate = p->signs == WEFT_TILE_SEPARATE ||
                    (p->signs == WEFT_TILE_SIGNS_AUTO && p->format == WEFT_TILE_UNORM);
}

// ---- what the weights need ----------------------------------------------------------------------

// The largest positive weight and the largest magnitude of a negative one.
struct range {
    double side[2];
};

// Taps of one half of an axis.
enum { HALF_WIDTH = WEFT_KERNEL_MAX_WIDTH / 2 };

struct ranges {
    struct range axis[3][WEFT_KERNEL_MAX_WIDTH];               // separable: of each tap of an axis
    struct range radial[HALF_WIDTH * HALF_WIDTH * HALF_WIDTH]; // of the taps of one octant
    struct range whole;                                        // of all taps
    bool is_radial;
};

static const struct range no_factor = {{1.0, 0.0}};

static void widen(struct range *r, double weight)
{
    r->side[weight < 0.0] =
        fmax(r->side[weight < 0.0], isfinite(weight) ? fabs(weight) : (double)INFINITY);
}

// Of all products: the largest of either sign is one of the largest of the factors.
static struct range product(struct range a, struct range b)
{
    return (struct range){{fmax(a.side[0] * b.side[0], a.side[1] * b.side[1]),
                           fmax(a.side[0] * b.side[1], a.side[1] * b.side[0])}};
}

static void find_product_ranges(const weft_kernel_tiles *set, struct ranges *out)
{
    out->whole = no_factor;
    for (int a = 0; a < set->info.dims; a++) {
        const double *weight = weft_tiles_axis_of(set, a)->weights;
        struct range any = {{0.0, 0.0}};
        for (int k = 0; k < set->info.samples; k++) {
            for (int t = 0; t < set->info.width; t++) {
                widen(&out->axis[a][t], *weight);
                widen(&any, *weight++);
            }
        }
        out->whole = product(out->whole, any);
    }
}

// A radial kernel's tap and its reflections have the same range.
static struct range *radial_range(const weft_kernel_tiles *set, struct ranges *ranges,
                                  const int tap[3])
{
    int index = 0;
    for (int a = set->info.dims - 1; a >= 0; a--) {
        const int mirrored = set->info.width - 1 - tap[a];
        index = index * HALF_WIDTH + (tap[a] < mirrored ? tap[a] : mirrored);
    }
    return &ranges->radial[index];
}

// No product tells: all weights at all positions, less those that are reflections.
static void find_radial_ranges(const weft_kernel_tiles *set, struct ranges *out)
{
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int at[3] = {0};
    out->is_radial = true;
    do {
        weft_tiles_weights(set, at, weights);
        int tap[3] = {0}, i = 0;
        do {
            widen(radial_range(set, out, tap), weights[i]);
            widen(&out->whole, weights[i++]);
        } while (weft_tiles_next(set->info.dims, set->info.width, tap));
    } while (weft_tiles_next(set->info.dims, (set->info.samples + 1) / 2, at));
}

static struct range tile_range(const weft_kernel_tiles *set, struct ranges *ranges,
                               const int tap[3])
{
    if (ranges->is_radial)
        return *radial_range(set, ranges, tap);
    struct range r = no_factor;
    for (int a = 0; a < set->info.dims; a++)
        r = product(r, ranges->axis[a][tap[a]]);
    return r;
}

static double full_range_scale(const weft_kernel_tiles *set, double largest)
{
    const double full = largest > 0.0 ? 1.0 / largest : 1.0;
    return fmin(set->params.max_scale, set->params.exact_scale ? full : exp2(floor(log2(full))));
}

// How often is derived along an axis at most.
static int highest(const weft_kernel_tiles *set)
{
    const int *along = set->info.derivative.along;
    const int first = along[0] > along[1] ? along[0] : along[1];
    return first > along[2] ? first : along[2];
}

static bool check_range(const weft_kernel_tiles *set, struct range whole)
{
    const struct weft_kernel_tiles_params *p = &set->params;
    const char *name = set->axes[highest(set)].kernel.info->name;
    const double largest = fmax(whole.side[0], whole.side[1]);
    const double limit = p->format == WEFT_TILE_FLOAT  ? (double)INFINITY
                         : p->format == WEFT_TILE_HALF ? HALF_MAX
                                                       : 1.0;
    if (!isfinite(largest)) {
        weft_error(p->log, "tiles: kernel %s has weights that are not finite, or add up to 0",
                   name);
        return false;
    }
    if (p->scaling == WEFT_TILE_UNSCALED && largest > limit * (1.0 + 1e-12)) {
        weft_error(p->log, "tiles: kernel %s has weights up to %g, over %g: scale them", name,
                   largest, limit);
        return false;
    }
    if (!set->separate && p->format == WEFT_TILE_UNORM && whole.side[1] > 0.0) {
        weft_error(p->log,
                   "tiles: kernel %s has weights down to %g, which one unorm tile per tap "
                   "cannot hold",
                   name, -whole.side[1]);
        return false;
    }
    return true;
}

// ---- storage ------------------------------------------------------------------------------------

static int power(int base, int exponent)
{
    return exponent ? base * power(base, exponent - 1) : 1;
}

// Numbers the parts that each of `count`^dims taps has; returns how many there are.
static int number_parts(const weft_kernel_tiles *set, struct ranges *ranges, int count,
                        double set_scale, int *number, double *scale)
{
    int tap[3] = {0}, parts = 0;
    do {
        const struct range r = tile_range(set, ranges, tap);
        for (int side = 0; side < 2; side++) {
            const bool there = set->separate ? r.side[side] > 0.0 : side == 0;
            const double largest = set->separate ? r.side[side] : fmax(r.side[0], r.side[1]);
            if (number)
                number[2 * weft_tiles_tap_index(set, tap, count) + side] = there ? parts : -1;
            if (scale && there)
                scale[parts] = set->params.scaling == WEFT_TILE_SCALE_EACH
                                   ? full_range_scale(set, largest)
                                   : set_scale;
            parts += there;
        }
    } while (weft_tiles_next(set->info.dims, count, tap));
    return parts;
}

// false when bytes for so many tiles overflow or are over the limit.
static bool check_memory(const weft_kernel_tiles *set, size_t stored, size_t *bytes)
{
    const uint64_t limit = set->params.memory_bytes;
    *bytes = SIZE_MAX;
    if (weft_size_mul(set->info.tile_values, stored, bytes) &&
        weft_size_mul(*bytes, set->info.value_bytes, bytes) && *bytes <= limit)
        return true;
    weft_error(set->params.log,
               "tiles: %zu tiles of %d^%d samples take %.0f bytes, over the limit of %.0f", stored,
               set->info.samples, set->info.dims,
               (double)set->info.tile_values * (double)stored * (double)set->info.value_bytes,
               (double)limit);
    return false;
}

static enum weft_result allocate(weft_kernel_tiles *set, const double *scale, int stored)
{
    struct weft_kernel_tiles_info *info = &set->info;
    // At least one of each: malloc(0) may be NULL.
    set->stored = calloc((size_t)stored + 1, sizeof *set->stored);
    set->tiles = calloc((size_t)info->tile_count + 1, sizeof *set->tiles);
    if (!set->stored || !set->tiles)
        goto fail;
    for (int i = 0; i < stored; i++) {
        set->stored[i].scale = scale[i];
        set->stored[i].data = calloc(info->tile_values, info->value_bytes);
        info->stored_count = i + 1;
        if (!set->stored[i].data)
            goto fail;
    }
    return WEFT_OK;
fail:
    weft_error(set->params.log, "tiles: not enough memory for %d tiles of %zu bytes", stored,
               info->tile_values * info->value_bytes);
    return WEFT_ERR_MEMORY;
}

static enum weft_result lay_out(weft_kernel_tiles *set)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_kernel_tiles_info *info = &set->info;
    struct ranges ranges = {0};
    if (weft_kernel_is_radial(&info->kernel, info->dims))
        find_radial_ranges(set, &ranges);
    else
        find_product_ranges(set, &ranges);
    const struct range whole = ranges.whole;
    const double set_scale = set->params.scaling == WEFT_TILE_SCALE_SET
                                 ? full_range_scale(set, fmax(whole.side[0], whole.side[1]))
                                 : 1.0;
    double *scale = NULL;
    if (!check_range(set, whole))
        goto fail;
    info->tile_count = number_parts(set, &ranges, info->width, set_scale, NULL, NULL);
    const int stored = number_parts(set, &ranges, set->kept, set_scale, NULL, NULL);
    res = WEFT_ERR_LIMIT;
    if (!check_memory(set, (size_t)stored, &info->memory_bytes))
        goto fail;
    info->saved_bytes = (size_t)(info->tile_count - stored) * info->tile_values * info->value_bytes;
    res = WEFT_ERR_MEMORY;
    set->stored_of = malloc(2 * (size_t)power(set->kept, info->dims) * sizeof *set->stored_of);
    scale = malloc(((size_t)stored + 1) * sizeof *scale);
    if (!set->stored_of || !scale) {
        weft_error(set->params.log, "tiles: not enough memory for a list of %d tiles", stored);
        goto fail;
    }
    number_parts(set, &ranges, set->kept, set_scale, set->stored_of, scale);
    res = allocate(set, scale, stored);
fail:
    free(scale);
    return res;
}

// ---- tiles as views of what is stored -----------------------------------------------------------

void weft_tiles_measure(const weft_kernel_tiles *set, struct weft_stored_tile *stored)
{
    stored->minimum = INFINITY;
    stored->maximum = -INFINITY;
    for (size_t i = 0; i < set->info.tile_values; i++) {
        const double q = weft_tiles_load(set, stored->data, i);
        stored->minimum = q < stored->minimum ? q : stored->minimum;
        stored->maximum = q > stored->maximum ? q : stored->maximum;
    }
}

void weft_tiles_refresh(const weft_kernel_tiles *set, struct weft_kernel_tile *tile)
{
    const struct weft_stored_tile *s = &set->stored[tile->stored];
    const double unit = (tile->negated ? -1.0 : 1.0) / (set->info.one * s->scale);
    const double a = s->minimum * unit + 0.0, b = s->maximum * unit + 0.0; // no -0
    tile->scale = s->scale;
    tile->minimum = fmin(a, b);
    tile->maximum = fmax(a, b);
    tile->data = s->data;
}

// The part of `side` at a tap; false if there is none.
static bool view(weft_kernel_tiles *set, const int tap[3], int side, struct weft_kernel_tile *out)
{
    int kept[3];
    const int sign = weft_tiles_kept_tap(set, tap, kept);
    *out = (struct weft_kernel_tile){.part = WEFT_TILE_WHOLE};
    for (int a = 0; a < set->info.dims; a++) {
        out->tap[a] = tap[a];
        out->mirrored[a] = kept[a] != tap[a];
    }
    // Mirroring along an odd axis turns positive parts into negative ones.
    const int stored_side = set->separate && sign < 0 ? 1 - side : side;
    out->negated = set->separate ? part_sign[side] < 0 : sign < 0;
    if (set->separate)
        out->part = side ? WEFT_TILE_NEGATIVE : WEFT_TILE_POSITIVE;
    out->stored = set->stored_of[2 * weft_tiles_tap_index(set, kept, set->kept) + stored_side];
    return out->stored >= 0;
}

static void list_tiles(weft_kernel_tiles *set)
{
    int tap[3] = {0}, count = 0;
    for (int i = 0; i < set->info.stored_count; i++)
        weft_tiles_measure(set, &set->stored[i]);
    do {
        for (int side = 0; side < 2; side++) {
            struct weft_kernel_tile tile;
            if (!view(set, tap, side, &tile))
                continue;
            set->stored[tile.stored].users++;
            weft_tiles_refresh(set, &tile);
            set->tiles[count++] = tile;
        }
    } while (weft_tiles_next(set->info.dims, set->info.width, tap));
}

// The weights of the kernel, and of its derivatives up to the highest that an axis has.
static enum weft_result fill_axes(weft_kernel_tiles *set)
{
    const int kinds = highest(set) + 1;
    const size_t count = (size_t)set->info.samples * (size_t)set->info.width;
    for (int i = 0; i < kinds; i++) {
        const enum weft_result res =
            weft_kernel_derive_times(set->params.log, &set->info.kernel, i, &set->axes[i].kernel);
        if (res != WEFT_OK)
            return res;
    }
    double *weights = malloc((size_t)kinds * count * sizeof *weights);
    if (!weights) {
        weft_error(set->params.log, "tiles: not enough memory for %d x %zu weights", kinds, count);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < kinds; i++) {
        set->axes[i].weights = weights + (size_t)i * count;
        weft_tiles_sample(set, &set->axes[i]);
    }
    return WEFT_OK;
}

static void choose_mirroring(weft_kernel_tiles *set)
{
    const bool unpaired = set->info.rounding == WEFT_TILE_SUM_PRESERVING && set->info.samples % 2;
    set->info.mirrored = !set->params.store_all && !unpaired;
    for (int a = 0; a < set->info.dims; a++) {
        const struct weft_tiles_axis *axis = weft_tiles_axis_of(set, a);
        set->info.mirrored = set->info.mirrored && (axis->even || axis->odd);
    }
    set->kept = set->info.mirrored ? (set->info.width + 1) / 2 : set->info.width;
}

enum weft_result weft_kernel_tiles_create(const struct weft_kernel_tiles_params *params,
                                          weft_kernel_tiles **out)
{
    *out = NULL;
    weft_kernel_tiles *set = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_kernel_tiles_params p = *params;
    p.dims = p.dims ? p.dims : 2;
    p.samples = p.samples ? p.samples : 64;
    p.bits = p.bits ? p.bits : 8;
    if (weft_kernel_check(p.log, &p.kernel) != WEFT_OK)
        goto fail;
    if (!check_params(&p) || (p.normalise && weft_kernel_normalise(p.log, &p.kernel) != WEFT_OK))
        goto fail;
    if (!check_sums(&p))
        goto fail;
    p.memory_bytes = p.memory_bytes ? p.memory_bytes : DEFAULT_MEMORY;
    p.max_scale = p.max_scale > 0.0 ? p.max_scale : (double)INFINITY;
    set = calloc(1, sizeof *set);
    if (!set) {
        weft_error(p.log, "tiles: not enough memory for a set");
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    set->params = p;
    init_info(set);
    res = fill_axes(set);
    if (res != WEFT_OK)
        goto fail;
    choose_mirroring(set);
    res = lay_out(set);
    if (res == WEFT_OK)
        res = weft_tiles_quantise(set);
    if (res != WEFT_OK)
        goto fail;
    list_tiles(set);
    *out = set;
    return WEFT_OK;
fail:
    weft_kernel_tiles_destroy(&set);
    return res;
}

void weft_kernel_tiles_destroy(weft_kernel_tiles **tiles)
{
    weft_kernel_tiles *set = tiles ? *tiles : NULL;
    if (!set)
        return;
    for (int i = 0; i < set->info.stored_count; i++)
        free(set->stored[i].data);
    free(set->stored);
    free(set->stored_of);
    free(set->tiles);
    free(set->axes[0].weights); // those of all
    free(set);
    *tiles = NULL;
}

// ---- questions ----------------------------------------------------------------------------------

const struct weft_kernel_tiles_info *weft_kernel_tiles_get_info(const weft_kernel_tiles *tiles)
{
    return &tiles->info;
}

const struct weft_kernel_tile *weft_kernel_tiles_get(const weft_kernel_tiles *tiles, int tile)
{
    return tile >= 0 && tile < tiles->info.tile_count ? &tiles->tiles[tile] : NULL;
}

int weft_kernel_tiles_find(const weft_kernel_tiles *tiles, const int tap[3],
                           enum weft_tile_part part)
{
    for (int i = 0; i < tiles->info.tile_count; i++)
        if (tiles->tiles[i].part == part && memcmp(tiles->tiles[i].tap, tap, 3 * sizeof *tap) == 0)
            return i;
    return -1;
}

static bool is_position(const struct weft_kernel_tiles_info *info, const int position[3])
{
    for (int a = 0; a < info->dims; a++)
        if (position[a] < 0 || position[a] >= info->samples)
            return false;
    return true;
}

static bool is_tile(const weft_kernel_tiles *tiles, int tile, const int position[3])
{
    return tile >= 0 && tile < tiles->info.tile_count && is_position(&tiles->info, position);
}

static bool is_tap(const struct weft_kernel_tiles_info *info, const int tap[3])
{
    for (int a = 0; a < info->dims; a++)
        if (tap[a] < 0 || tap[a] >= info->width)
            return false;
    return true;
}

static double stored_at(const weft_kernel_tiles *set, int tile, const int position[3])
{
    const struct weft_kernel_tile *t = &set->tiles[tile];
    int at[3] = {0};
    for (int a = 0; a < set->info.dims; a++)
        at[a] = t->mirrored[a] ? set->info.samples - 1 - position[a] : position[a];
    const double q = weft_tiles_load(set, t->data, weft_tiles_sample_index(set, at));
    return t->negated ? 0.0 - q : q;
}

double weft_kernel_tiles_value(const weft_kernel_tiles *tiles, int tile, const int position[3])
{
    if (!is_tile(tiles, tile, position))
        return NAN;
    return stored_at(tiles, tile, position) / (tiles->info.one * tiles->tiles[tile].scale);
}

int weft_kernel_tiles_integer(const weft_kernel_tiles *tiles, int tile, const int position[3])
{
    return is_tile(tiles, tile, position) && weft_tiles_integer_format(tiles)
               ? (int)stored_at(tiles, tile, position)
               : 0;
}

double weft_kernel_tiles_exact(const weft_kernel_tiles *tiles, const int tap[3],
                               const int position[3])
{
    const size_t width = (size_t)tiles->info.width;
    if (!is_tap(&tiles->info, tap) || !is_position(&tiles->info, position))
        return NAN;
    if (!weft_kernel_is_radial(&tiles->info.kernel, tiles->info.dims)) {
        double w = 1.0;
        for (int a = 0; a < tiles->info.dims; a++) {
            const double *weights = weft_tiles_axis_of(tiles, a)->weights;
            w *= weights[(size_t)position[a] * width + (size_t)tap[a]];
        }
        return w;
    }
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    weft_tiles_weights(tiles, position, weights);
    return weights[weft_tiles_tap_index(tiles, tap, tiles->info.width)];
}
