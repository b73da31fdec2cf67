// SPDX-License-Identifier: BSD-3-Clause
// tests/support/pass_lists.h - lists of passes and requests made at random, for what runs them.
// Include after common.h. A list need not make sense as a reconstruction; it keeps
// passes/plan/pass.h's rules, which is all that runners are told.
#ifndef WEFT_TESTS_SUPPORT_PASS_LISTS_H
#define WEFT_TESTS_SUPPORT_PASS_LISTS_H

#include <stdlib.h>
#include <string.h>

#include "passes/multipass/job.h"
#include "passes/verify/verifier.h"
#include "tests/support/plan_runs.h"

enum {
    HAND_MAX_GROUPS = 256,
    HAND_MAX_PASSES = 64,
    HAND_MAX_PIXELS = 2048,
    HAND_MAX_SAMPLES = 4096
};

static uint64_t hand_seed = 1;

static inline int random_below(int count)
{
    hand_seed = hand_seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (int)((hand_seed >> 33) % (uint64_t)count);
}

// Splitmix64: neighbouring cases have nothing in common.
static inline void start_case(int number)
{
    uint64_t h = (uint64_t)number * UINT64_C(0x9e3779b97f4a7c15) + UINT64_C(0x632be59bd9b4e019);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    hand_seed = h ^ h >> 31;
}

static inline double random_unit(void)
{
    return random_below(1 << 30) * 0x1p-30;
}

static inline bool one_in(int count)
{
    return random_below(count) == 0;
}

// ---- a list with all that it refers to ----------------------------------------------------------

struct hand_list {
    weft_kernel_tiles *tiles;
    struct weft_tap_group groups[HAND_MAX_GROUPS];
    struct weft_pass passes[HAND_MAX_PASSES];
    uint32_t log_table[2 * 65535 + 1];
    struct weft_pass_list list;
    struct weft_multipass_work work;
};

// Targets, tiles and nothing else: no group and no pass yet.
struct hand_params {
    const char *kernel;
    enum weft_target_format target;
    int dims, samples, bits, channels;
    enum weft_tile_signs signs;
    enum weft_tile_rounding rounding;
    enum weft_tile_scaling scaling;
    int extra_bits;
    double range; // 0: exact inside
    bool logarithms;
};
#define HAND_DEFAULTS                                                                              \
    .kernel = "catmull-rom", .dims = 2, .samples = 8, .bits = 8, .channels = 1,                    \
    .scaling = WEFT_TILE_SCALE_SET,

static inline enum weft_tile_format hand_tile_format(const struct hand_params *p)
{
    if (p->logarithms || p->target == WEFT_TARGET_FLOAT)
        return WEFT_TILE_FLOAT;
    return p->target == WEFT_TARGET_HALF ? WEFT_TILE_HALF : WEFT_TILE_UNORM;
}

// Table of products 2^(-(s + q) octaves / (T - 1)), in 2^-e codes.
static inline void hand_fill_log_table(struct hand_list *h)
{
    const int one = weft_target_one(h->list.target);
    for (int i = 0; i <= 2 * one; i++)
        h->log_table[i] = (uint32_t)lround(one * exp2(h->list.extra_bits) *
                                           exp2(-i * h->list.log_octaves / (one - 1)));
}

static inline struct hand_list *hand_list_create(const struct hand_params *p)
{
    struct hand_list *h = calloc(1, sizeof *h);
    assert_non_null(h);
    const struct weft_kernel kernel = kernel_named(p->kernel);
    struct weft_kernel_tiles_params tiles = {.kernel = kernel,
                                             .dims = p->dims,
                                             .samples = p->samples,
                                             .format = hand_tile_format(p),
                                             .bits = p->bits,
                                             .signs = p->signs,
                                             .rounding = p->rounding,
                                             .scaling = p->scaling,
                                             .store_all = false,
                                             .log = &log_to_stderr};
    if (p->logarithms)
        tiles.signs = WEFT_TILE_SEPARATE;
    if (tiles.format != WEFT_TILE_UNORM)
        tiles.scaling = WEFT_TILE_UNSCALED;
    assert_int_equal(weft_kernel_tiles_create(&tiles, &h->tiles), WEFT_OK);
    h->list = (struct weft_pass_list){
        .tiles = h->tiles,
        .target = p->target,
        .dims = p->dims,
        .dot_width = 4,
        .exact_inside = p->range == 0.0,
        .extra_bits = p->extra_bits,
        .range = p->range == 0.0 ? (double)INFINITY : p->range,
        .slot_count = 1,
        .groups = h->groups,
        .passes = h->passes,
        .result_scale = 1.0,
        .log_table = p->logarithms ? h->log_table : NULL,
        .log_octaves = p->logarithms ? 10.0 : 0.0,
    };
    if (p->logarithms)
        hand_fill_log_table(h);
    h->work =
        (struct weft_multipass_work){.passes = &h->list, .kernel = kernel, .channels = p->channels};
    return h;
}

static inline void hand_list_destroy(struct hand_list *h)
{
    weft_kernel_tiles_destroy(&h->tiles);
    free(h);
}

static inline struct weft_pass *hand_add_pass(struct hand_list *h, struct weft_pass pass)
{
    assert_true(h->list.pass_count < HAND_MAX_PASSES);
    pass.group_first = h->list.group_count;
    h->passes[h->list.pass_count] = pass;
    return &h->passes[h->list.pass_count++];
}

// Of the last pass.
static inline void hand_add_group(struct hand_list *h, struct weft_tap_group group)
{
    assert_true(h->list.group_count < HAND_MAX_GROUPS);
    h->groups[h->list.group_count++] = group;
    h->passes[h->list.pass_count - 1].group_count++;
}

// The tile's own tap, sign and place.
static inline struct weft_tap_group hand_tap_group(const struct hand_list *h, int tile)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(h->tiles, tile);
    return (struct weft_tap_group){.offset = {t->tap[0], t->tap[1], t->tap[2]},
                                   .tile = {tile, -1, -1, -1},
                                   .sign = {t->negated ? -1 : 1}};
}

// A pass for each tile, in their order: a reconstruction for the plain technique.
static inline void hand_add_all_tiles(struct hand_list *h, bool reads_target)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(h->tiles);
    for (int t = 0; t < info->tile_count; t++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(h->tiles, t);
        hand_add_pass(h, (struct weft_pass){.clears = t == 0,
                                            .subtract = !reads_target && tile->negated,
                                            .reads_target = reads_target,
                                            .divisor = (int)(info->one * tile->scale)});
        hand_add_group(h, hand_tap_group(h, t));
    }
}

// ---- a request ----------------------------------------------------------------------------------

struct hand_request {
    float samples[4][HAND_MAX_SAMPLES];
    float pixels[4][HAND_MAX_PIXELS];
    struct weft_samples source;
    struct weft_pixel_grid grid;
    struct weft_multipass_run_params params;
};

static inline struct hand_request *hand_request_create(const struct hand_list *h, int width,
                                                       int height, int size_x, int size_y,
                                                       int size_z)
{
    struct hand_request *r = calloc(1, sizeof *r);
    assert_non_null(r);
    r->source = (struct weft_samples){.size = {size_x, size_y, size_z}, .low = 0.0, .high = 1.0};
    r->grid = (struct weft_pixel_grid){.width = width, .height = height};
    r->params = (struct weft_multipass_run_params){
        .samples = &r->source, .grid = &r->grid, .log = &log_to_stderr};
    for (int c = 0; c < h->work.channels; c++) {
        r->source.plane[c] = r->samples[c];
        r->params.pixels[c] = r->pixels[c];
        for (int i = 0; i < size_x * size_y * size_z; i++)
            r->samples[c][i] = (float)random_unit();
    }
    return r;
}

// Oblique, and beyond the samples by about as much again on every side.
static inline struct hand_request *hand_random_request(const struct hand_list *h)
{
    const int dims = h->list.dims;
    const int size[3] = {1 + random_below(12), dims > 1 ? 1 + random_below(12) : 1,
                         dims > 2 ? 1 + random_below(12) : 1};
    struct hand_request *r = hand_request_create(h, 1 + random_below(40), 1 + random_below(40),
                                                 size[0], size[1], size[2]);
    for (int a = 0; a < dims; a++) {
        r->grid.origin[a] = size[a] * (2.0 * random_unit() - 1.0);
        r->grid.du[a] = size[a] * (3.0 * random_unit() - 1.0) / r->grid.width;
        r->grid.dv[a] = size[a] * (3.0 * random_unit() - 1.0) / r->grid.height;
    }
    return r;
}

// Compiles a list, for GL or without (NULL), and runs it once.
static inline enum weft_result hand_run(weft_context *context, const struct hand_list *h,
                                        const struct hand_request *r,
                                        struct weft_multipass_report *report)
{
    weft_multipass *compiled = NULL;
    enum weft_result res = weft_multipass_compile_work(context, &h->work, r->params.log, &compiled);
    if (res == WEFT_OK)
        res = weft_multipass_run(compiled, &r->params, report);
    weft_multipass_destroy(&compiled);
    return res;
}

static inline enum weft_result hand_verify(const struct hand_list *h, const struct hand_request *r,
                                           struct weft_verify_report *error)
{
    const struct weft_multipass_verify_params params = verify_params(NULL, &r->params);
    return weft_multipass_verify_work(&h->work, &params, error);
}

// ---- random lists -------------------------------------------------------------------------------

static inline struct weft_tap_group random_group(const struct hand_list *h, bool one_sign, int sign)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(h->tiles);
    struct weft_tap_group group = {.tile = {-1, -1, -1, -1}};
    for (int a = 0; a < h->list.dims; a++)
        group.offset[a] = random_below(info->width + 1) - one_in(5);
    for (int c = 0; c < (h->list.dot4 ? 4 : 1); c++) {
        if (one_in(8))
            continue;
        group.tile[c] = random_below(info->tile_count);
        group.sign[c] = one_sign ? sign : one_in(2) ? -1 : 1;
        group.shift[c] = one_in(4) ? random_below(3) : 0;
    }
    return group;
}

// holds: by slot, whether there is something in it; a slot that was combined is free.
static inline void add_random_taps(struct hand_list *h, bool ping_pong, bool *holds)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(h->tiles);
    const bool reads = ping_pong && one_in(2), floats = weft_target_bits(h->list.target) == 0;
    const int one = floats ? 1 : weft_target_one(h->list.target);
    const bool subtract = one_in(3);
    const int sign = subtract ? -1 : 1;
    int bias = one_in(3) ? random_below((one << h->list.extra_bits) / 4 + 1) * sign : 0;
    if (reads && one_in(2))
        bias = -bias;
    static const int divisors[5][2] = {{1, 1}, {2, 1}, {1, 2}, {4, 3}, {9, 8}};
    const int *share = divisors[random_below(one_in(2) ? 5 : 2)];
    struct weft_pass pass = {
        .target = random_below(h->list.slot_count),
        .clears = one_in(6),
        .initial = one_in(2) ? random_below(one + 1) : 0,
        .part = floats ? WEFT_PASS_WHOLE : (enum weft_pass_part)random_below(3),
        .subtract = subtract,
        .reads_target = reads,
        .bias = bias,
        .divisor = floats ? 1 << random_below(2) : 1 + (int)info->one * share[0] / share[1],
    };
    pass.clears = pass.clears || !holds[pass.target];
    holds[pass.target] = true;
    hand_add_pass(h, pass);
    const int count = one_in(10) ? 0 : 1 + random_below(one_in(3) ? 5 : 2);
    for (int g = 0; g < count; g++)
        hand_add_group(h, random_group(h, !reads, sign));
}

static inline int random_held(const struct hand_list *h, const bool *holds)
{
    int slot;
    do
        slot = random_below(h->list.slot_count);
    while (!holds[slot]);
    return slot;
}

static inline void add_random_combination(struct hand_list *h, bool *holds)
{
    const int one = weft_target_bits(h->list.target) ? weft_target_one(h->list.target) : 1;
    struct weft_pass pass = {.kind = WEFT_PASS_COMBINE,
                             .target = random_below(h->list.slot_count),
                             .input_count = 1 + random_below(one_in(4) ? 16 : 3),
                             .denominator = 1 + random_below(one_in(2) ? 4 : 100)};
    for (int i = 0; i < pass.input_count; i++) {
        pass.input[i] = random_held(h, holds);
        do
            pass.numerator[i] = random_below(2 * pass.denominator) - pass.denominator / 2;
        while (pass.numerator[i] == 0);
    }
    for (int i = 0; i < pass.input_count; i++)
        holds[pass.input[i]] = false;
    holds[pass.target] = true;
    pass.bias = one_in(2) ? (random_below(one + 1) - one / 2) * pass.denominator / 2 : 0;
    hand_add_pass(h, pass);
}

static inline struct hand_params random_params(enum weft_target_format target)
{
    static const char *const kernels[] = {"nearest",      "linear",   "catmull-rom", "bspline",
                                          "gaussian:1.5", "mitchell", "lanczos:2.5"};
    static const int samples[] = {1, 2, 3, 5, 8, 16, 31};
    struct hand_params p = {HAND_DEFAULTS};
    p.target = target;
    p.dims = 2 + one_in(3);
    p.kernel = kernels[random_below(p.dims > 2 ? 4 : 7)];
    p.samples = samples[random_below(p.dims > 2 ? 5 : 7)];
    p.channels = one_in(4) ? 4 : 1;
    p.signs = WEFT_TILE_SEPARATE;
    p.rounding = (enum weft_tile_rounding)random_below(3);
    if (weft_target_bits(target) == 0) {
        p.signs = one_in(2) ? WEFT_TILE_SIGNED : WEFT_TILE_SEPARATE;
        p.rounding = WEFT_TILE_NEAREST;
        return p;
    }
    static const double ranges[] = {1.0, 1.5, 8.0, INFINITY};
    p.bits = target == WEFT_TARGET_UNORM8 ? 4 + random_below(5) : 4 + random_below(11);
    p.extra_bits = one_in(2) ? 0 : random_below(target == WEFT_TARGET_UNORM8 ? 7 : 5);
    p.range = one_in(2) ? 0.0 : ranges[random_below(4)];
    p.logarithms = one_in(6);
    if (p.logarithms)
        p.rounding = WEFT_TILE_NEAREST;
    return p;
}

static inline struct hand_list *hand_random_list(enum weft_target_format target)
{
    const struct hand_params p = random_params(target);
    struct hand_list *h = hand_list_create(&p);
    h->work.portable = one_in(2);
    bool holds[4] = {true, true, true, true};
    h->list.slot_count = 1 + random_below(4);
    h->list.dot4 = p.channels == 1 && one_in(2);
    h->list.dot_width = one_in(3) ? 3 : 4;
    for (int c = 0; h->list.dot4 && c < 4; c++)
        for (int a = 0; a < p.dims; a++)
            h->list.pattern[c][a] = one_in(8) ? random_below(5) - 2 : c >> a & 1;
    const bool ping_pong = one_in(2);
    for (int s = 0; s < h->list.slot_count; s++)
        hand_add_pass(h, (struct weft_pass){
                             .target = s,
                             .clears = true,
                             .initial = target == WEFT_TARGET_UNORM8 ? random_below(256) : 0,
                             .divisor = 1,
                         });
    for (int n = 3 + random_below(10); n > 0; n--) {
        if (one_in(5))
            add_random_combination(h, holds);
        else
            add_random_taps(h, ping_pong, holds);
    }
    h->list.result = random_held(h, holds);
    return h;
}

// ---- interrupts ---------------------------------------------------------------------------------

// A progress callback that cancels at its Nth call; priv: N as an int, which it counts down.
static inline bool cancel_at_call(void *priv, double fraction)
{
    (void)fraction;
    return --*(int *)priv > 0;
}

#endif
