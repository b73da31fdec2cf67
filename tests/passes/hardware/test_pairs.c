// SPDX-License-Identifier: BSD-3-Clause
// Pairs of taps: which there are, that their weights have one sign, and that bounds hold with
// samplers of 8 bits, emulated in integers.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/slice_jobs.h"
#include "passes/hardware/plan.h"

// Pairs as "0 1+2 3".
static void format_pairs(const struct weft_hardware_pairs *pairs, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < pairs->fetches; i++)
        used += (size_t)snprintf(text + used, size - used, pairs->paired[i] ? "%s%d+%d" : "%s%d",
                                 i ? " " : "", pairs->tap[i], pairs->tap[i] + 1);
}

static void find(const char *name, struct weft_polynomial_tiles *tiles,
                 struct weft_hardware_pairs *pairs)
{
    const struct weft_kernel kernel = kernel_named(name);
    assert_int_equal(weft_polynomial_tiles_create(NULL, &kernel, 1e-9, tiles), WEFT_OK);
    weft_hardware_pairs_find(tiles, pairs);
}

// By the signs of the kernels' lobes; a tap whose weight changes sign within [0, 1) stays alone
// where its neighbour's does not with it.
static void test_known(void **state)
{
    static const struct {
        const char *kernel, *pairs;
    } cases[] = {
        {"nearest", "0"},
        {"linear", "0+1"},
        {"bspline2", "0+1 2"},
        {"bspline3", "0+1 2+3"},
        {"bspline5", "0+1 2+3 4+5"},
        {"catmull-rom", "0 1+2 3"},
        {"mitchell", "0 1+2 3"},
        {"lanczos:2", "0 1+2 3"},
        {"lanczos:3", "0 1 2+3 4 5"},
        {"keys6", "0 1 2+3 4 5"},
        {"gaussian:1.5,0.6", "0+1 2"},
        {"d-bspline3", "0+1 2+3"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_polynomial_tiles tiles;
        struct weft_hardware_pairs pairs;
        char text[200];
        find(cases[i].kernel, &tiles, &pairs);
        format_pairs(&pairs, text, sizeof text);
        if (strcmp(text, cases[i].pairs) != 0)
            fail_msg("%s: taps %s instead of %s", cases[i].kernel, text, cases[i].pairs);
        weft_polynomial_tiles_destroy(&tiles);
    }
}

// By what most weights of a pair, or of two neighbours left alone, are on the other one's side.
static double wrong_side(const struct weft_kernel *kernel, int tap)
{
    enum { POSITIONS = 5000 };
    double largest = 0.0;
    for (int i = 0; i < POSITIONS; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH];
        weft_kernel_weights(kernel, (double)i / POSITIONS - (kernel->width % 2 ? 0.5 : 0.0),
                            weights);
        if (weights[tap] * weights[tap + 1] < 0.0)
            largest = fmax(largest, fmin(fabs(weights[tap]), fabs(weights[tap + 1])));
    }
    return largest;
}

// All of the catalogue: every tap is fetched once, pairs have one sign, and of two taps that are
// alone beside each other the signs differ.
static void test_catalogue(void **state)
{
    int paired = 0, alone = 0;
    (void)state;
    for (size_t k = 0; weft_kernel_list[k]; k++) {
        struct weft_kernel kernel;
        struct weft_polynomial_tiles tiles;
        struct weft_hardware_pairs pairs;
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[k], NULL, &kernel), WEFT_OK);
        assert_int_equal(weft_polynomial_tiles_create(NULL, &kernel, 1e-9, &tiles), WEFT_OK);
        weft_hardware_pairs_find(&tiles, &pairs);
        int next = 0;
        for (int i = 0; i < pairs.fetches; i++) {
            assert_int_equal(pairs.tap[i], next);
            next += 1 + pairs.paired[i];
            // Tiles are as good as single precision.
            if (pairs.paired[i]) {
                const double wrong = wrong_side(&kernel, pairs.tap[i]);
                if (!(wrong <= 0.5 * pairs.wrong_sign + tiles.error + 1e-7))
                    fail_msg("%s: taps %d and %d differ in sign by %g", kernel.info->name,
                             pairs.tap[i], pairs.tap[i] + 1, wrong);
                paired++;
            } else if (i + 1 < pairs.fetches && !pairs.paired[i + 1]) {
                if (!(wrong_side(&kernel, pairs.tap[i]) > 0.0))
                    fail_msg("%s: taps %d and %d could be a pair", kernel.info->name, pairs.tap[i],
                             pairs.tap[i] + 1);
                alone++;
            }
        }
        assert_int_equal(next, kernel.width);
        assert_true(pairs.wrong_sign <= 2.0 * pairs.pairs * WEFT_HARDWARE_WRONG_SIGN);
        weft_polynomial_tiles_destroy(&tiles);
    }
    assert_true(paired > 20 && alone > 5);
}

// ---- samplers of 8 bits -------------------------------------------------------------------------

struct emulated {
    bool rounds; // fractions; else they are cut off
    bool codes;  // values are cut off to codes of 8 bits, along each axis
};

// The shader's weights of an axis, in single precision.
static void horner(const struct weft_polynomial_tiles *tiles, float t, float *weights)
{
    const size_t stride = 4 * (size_t)tiles->groups;
    const float scaled = t * (float)tiles->segments;
    const int segment = (int)scaled < tiles->segments ? (int)scaled : tiles->segments - 1;
    const float u = scaled - (float)segment;
    const float *c = tiles->coefficients + (size_t)segment * stride * (size_t)(tiles->degree + 1);
    for (int tap = 0; tap < tiles->width; tap++) {
        float sum = c[(size_t)tiles->degree * stride + (size_t)tap];
        for (int p = tiles->degree - 1; p >= 0; p--)
            sum = sum * u + c[(size_t)p * stride + (size_t)tap];
        weights[tap] = sum;
    }
}

struct fetch {
    float weight;
    int tap;
    int fraction; // in 1/256, as the sampler has it: 0 to 256
};

// The fetches of an axis whose texels begin at `first` in a texture.
static void set_fetches(const struct weft_hardware_plan *plan, const struct emulated *e, float t,
                        int first, struct fetch *out)
{
    float weights[4 * WEFT_KERNEL_MAX_WIDTH];
    horner(&plan->slice->weights[0]->tiles, t, weights);
    for (int i = 0; i < plan->pairs.fetches; i++) {
        const int tap = plan->pairs.tap[i];
        float sum = weights[tap], place = (float)(first + tap) + 0.5f;
        if (plan->pairs.paired[i]) {
            const float second = weights[tap + 1];
            sum += second;
            const float between = sum != 0.0f ? fminf(fmaxf(second / sum, 0.0f), 1.0f) : 0.0f;
            place += floorf(between * 32768.0f + 0.5f) / 32768.0f;
        }
        const double fixed = floor(((double)place - 0.5) * 256.0 + (e->rounds ? 0.5 : 0.0));
        out[i] = (struct fetch){sum, tap, (int)fixed - 256 * (first + tap)};
        assert_true(out[i].fraction >= 0 && out[i].fraction <= 256);
    }
}

static double blend(const struct emulated *e, double a, double b, int fraction)
{
    const double value = a + (b - a) * fraction / 256.0;
    return e->codes ? floor(value * 255.0) / 255.0 : value;
}

// Voxels in a range, as texels: floats, or codes of 8 bits.
struct texels {
    const struct weft_hardware_plan *plan;
    double value[VOXELS];
};

static int clamp_voxel(int i)
{
    return i < 0 ? 0 : i < SIDE ? i : SIDE - 1;
}

static double texel_at(const struct texels *t, const int at[3])
{
    return t->value[(clamp_voxel(at[2]) * SIDE + clamp_voxel(at[1])) * SIDE + clamp_voxel(at[0])];
}

static double sample(const struct texels *t, const struct emulated *e, const int first[3],
                     const struct fetch *x, const struct fetch *y, const struct fetch *z)
{
    double corner[8];
    for (int i = 0; i < 8; i++)
        corner[i] =
            texel_at(t, (const int[]){first[0] + x->tap + (i & 1), first[1] + y->tap + (i >> 1 & 1),
                                      first[2] + z->tap + (i >> 2)});
    for (int i = 0; i < 4; i++)
        corner[i] = blend(e, corner[2 * i], corner[2 * i + 1], x->fraction);
    for (int i = 0; i < 2; i++)
        corner[i] = blend(e, corner[2 * i], corner[2 * i + 1], y->fraction);
    return blend(e, corner[0], corner[1], z->fraction);
}

static double emulate(const struct texels *t, const struct emulated *e, const int32_t whole[3],
                      const double fraction[3])
{
    const struct weft_hardware_plan *plan = t->plan;
    struct fetch fetches[3][WEFT_KERNEL_MAX_WIDTH];
    int first[3];
    float sum = 0.0f;
    for (int a = 0; a < 3; a++) {
        // Rounded to 24 bits, half-way up, as the shader has it; somewhere in the largest texture.
        const float rounded = (float)(floor(fraction[a] * 0x1p24 + 0.5) * 0x1p-24);
        first[a] = whole[a] - plan->slice->footprint->grid.tap_offset;
        set_fetches(plan, e, rounded, 12 * a + 5 + (plan->info.texture_size[a] - 64), fetches[a]);
    }
    for (int k = 0; k < plan->pairs.fetches; k++) {
        float plane = 0.0f;
        for (int j = 0; j < plan->pairs.fetches; j++) {
            float row = 0.0f;
            for (int i = 0; i < plan->pairs.fetches; i++)
                row += fetches[0][i].weight *
                       (float)sample(t, e, first, &fetches[0][i], &fetches[1][j], &fetches[2][k]);
            plane += fetches[1][j].weight * row;
        }
        sum += fetches[2][k].weight * plane;
    }
    double scale = 1.0, offset = 0.0;
    if (plan->slice->info.source != WEFT_SOURCE_FLOAT)
        weft_source_range_mapping(plan->slice->info.source, &plan->slice->range, &scale, &offset);
    for (int a = 0; a < 3 && !plan->slice->info.kernel.unit_sum; a++) {
        double total = 0.0;
        for (int i = 0; i < plan->pairs.fetches; i++)
            total += (double)fetches[a][i].weight;
        offset *= total;
    }
    return sum * scale + offset;
}

static double exact(const struct texels *t, const float *voxels, const int32_t whole[3],
                    const double fraction[3])
{
    const struct weft_slice_plan *slice = t->plan->slice;
    const struct weft_kernel *kernel = &slice->info.kernel;
    double weights[3][WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
    for (int a = 0; a < 3; a++)
        weft_kernel_weights(kernel, fraction[a] - slice->footprint->grid.tap_shift, weights[a]);
    for (int k = 0; k < kernel->width; k++)
        for (int j = 0; j < kernel->width; j++)
            for (int i = 0; i < kernel->width; i++) {
                const int tap[3] = {i, j, k};
                int at[3];
                for (int a = 0; a < 3; a++)
                    at[a] = clamp_voxel(whole[a] - slice->footprint->grid.tap_offset + tap[a]);
                sum += weights[0][i] * weights[1][j] * weights[2][k] *
                       (double)voxels[(at[2] * SIDE + at[1]) * SIDE + at[0]];
            }
    return sum;
}

// A cut through voxels of noise, or of extremes, whose samples are at both ends of their range.
static float *make_voxels(struct random *r, bool extremes)
{
    float *voxels = malloc(VOXELS * sizeof *voxels);
    const double scale = ldexp(1.0, below(r, 21) - 10), offset = scale * 4.0 * (uniform(r) - 0.5);
    assert_non_null(voxels);
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = (float)(offset + scale * (extremes ? below(r, 2) : uniform(r)));
    return voxels;
}

static void set_texels(const struct weft_hardware_plan *plan, const float *voxels,
                       struct texels *out)
{
    double scale = 1.0, offset = 0.0;
    const bool coded = plan->slice->info.source == WEFT_SOURCE_UNORM8;
    out->plan = plan;
    if (coded)
        weft_source_range_mapping(WEFT_SOURCE_UNORM8, &plan->slice->range, &scale, &offset);
    for (int i = 0; i < VOXELS; i++) {
        const double mapped = (voxels[i] - offset) / scale;
        out->value[i] = coded ? floor(255.0 * fmin(fmax(mapped, 0.0), 1.0) + 0.5) / 255.0 : mapped;
    }
}

// Plans a cut for a sampler of 8 bits. NULL where the kernel has no pairs.
static weft_hardware_plan *plan_cut(struct random *r, weft_volume *volume, const char *kernel,
                                    const struct emulated *e, weft_slice_plan **slice,
                                    struct weft_slice_statistics *statistics)
{
    struct weft_slice_params params = {.kernel = kernel_named(kernel),
                                       .space = WEFT_SPACE_INDEX,
                                       .geometry = random_plane(r),
                                       .without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE};
    weft_hardware_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, slice), WEFT_OK);
    assert_int_equal(
        weft_footprint_statistics(weft_slice_plan_get_footprint(*slice), NULL, statistics),
        WEFT_OK);
    if (e->codes) {
        weft_slice_plan_destroy(slice);
        params.source = WEFT_SOURCE_UNORM8;
        params.low = statistics->low;
        params.high = fmax(statistics->high, statistics->low + 1e-3);
        assert_int_equal(weft_slice_plan_create(volume, &params, slice), WEFT_OK);
    }
    const enum weft_result res = weft_hardware_plan_create(
        weft_hardware_params(.slice = *slice, .sampler = {.fraction = e->rounds ? 0x1p-9 : 0x1p-8,
                                                          .rounding = e->codes ? 1.0 / 255 : 0.0,
                                                          .max_size = 512}),
        &plan);
    assert_int_equal(res, strcmp(kernel, "nearest") ? WEFT_OK : WEFT_ERR_UNSUPPORTED);
    return plan;
}

static double check_cut(struct random *r, const struct weft_hardware_plan *plan,
                        const struct weft_slice_statistics *s, const float *voxels,
                        const struct emulated *e)
{
    static struct texels texels;
    const struct weft_slice_grid *grid = &plan->slice->footprint->grid;
    const struct weft_bound_values values = {.low = s->low,
                                             .high = s->high,
                                             .sample_low = s->voxel_low,
                                             .sample_high = s->voxel_high,
                                             .beyond = s->beyond};
    const double bound = weft_bound_compute(&plan->info.bound, &values).total;
    double largest = 0.0;
    set_texels(plan, voxels, &texels);
    for (int i = 0; i < 40; i++) {
        struct weft_slice_block block;
        int32_t whole[3];
        double fraction[3];
        weft_slice_grid_block(grid, 0, 0, &block);
        weft_slice_grid_pixel(grid, &block, below(r, grid->index.width),
                              below(r, grid->index.height), whole, fraction);
        const double off =
            fabs(emulate(&texels, e, whole, fraction) - exact(&texels, voxels, whole, fraction));
        if (!(off <= bound))
            fail_msg("%s, sampler that %s%s: off by %g of %g", plan->slice->info.kernel.info->name,
                     e->rounds ? "rounds" : "cuts", e->codes ? ", codes" : "", off, bound);
        largest = larger(largest, off / bound);
    }
    return largest;
}

static void test_bounds(void **state)
{
    static const struct emulated samplers[] = {{true, false}, {false, false}, {false, true}};
    static const char *const kernels[] = {"bspline3", "catmull-rom", "linear",         "bspline2",
                                          "mitchell", "lanczos:3",   "lanczos:2+unit", "bspline5",
                                          "keys6",    "nearest",     "gaussian"};
    struct random r = {3};
    double largest = 0.0;
    int ran = 0;
    (void)state;
    for (size_t i = 0; i < 3 * WEFT_COUNT(samplers) * WEFT_COUNT(kernels); i++) {
        const struct emulated *e = &samplers[i % WEFT_COUNT(samplers)];
        const char *kernel = kernels[i / WEFT_COUNT(samplers) % WEFT_COUNT(kernels)];
        float *voxels = make_voxels(&r, i % 2);
        weft_volume *volume = NULL;
        weft_slice_plan *slice = NULL;
        struct weft_slice_statistics statistics;
        assert_int_equal(
            weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = voxels),
                               &volume),
            WEFT_OK);
        weft_hardware_plan *plan = plan_cut(&r, volume, kernel, e, &slice, &statistics);
        if (plan) {
            largest = larger(largest, check_cut(&r, plan, &statistics, voxels, e));
            ran++;
        }
        weft_hardware_plan_destroy(&plan);
        weft_slice_plan_destroy(&slice);
        weft_volume_destroy(&volume);
        free(voxels);
    }
    print_message("%d cuts; at most %.2g of the bound\n", ran, largest);
    assert_int_equal(ran, 3 * WEFT_COUNT(samplers) * (WEFT_COUNT(kernels) - 1));
    assert_true(largest > 0.05); // it bounds what is there
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known),
        cmocka_unit_test(test_catalogue),
        cmocka_unit_test(test_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
