// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "passes/accumulate/accumulate_impl.h"
#include "passes/accumulate/frame.h"

static const struct weft_accumulate_way *const ways[WEFT_ACCUMULATE_METHOD_COUNT] = {
    [WEFT_ACCUMULATE_EXACT] = &weft_accumulate_exact,
    [WEFT_ACCUMULATE_TREE] = &weft_accumulate_tree,
    [WEFT_ACCUMULATE_BUFFER] = &weft_accumulate_buffer,
    [WEFT_ACCUMULATE_BLEND] = &weft_accumulate_blend,
    [WEFT_ACCUMULATE_FLOAT] = &weft_accumulate_float,
};

// What runs on a GPU, the cheapest first.
static const struct candidate {
    enum weft_accumulate_method method;
    int bits;
    const char *why;
} candidates[] = {
    {WEFT_ACCUMULATE_FLOAT, 32, "on a GPU the cheapest whose bound is within max_error"},
    {WEFT_ACCUMULATE_TREE, 8, "on a GPU the cheapest whose bound is within max_error"},
    {WEFT_ACCUMULATE_TREE, 16, "on a GPU the cheapest whose bound is within max_error"},
    {WEFT_ACCUMULATE_TREE, 32, "on a GPU the cheapest whose bound is within max_error"},
};

const struct weft_accumulate_way *weft_accumulate_way_of(enum weft_accumulate_method method)
{
    return ways[method];
}

void weft_accumulate_fill_in(struct weft_accumulator_params *p)
{
    if (p->bits == 0)
        p->bits = p->method == WEFT_ACCUMULATE_BUFFER ? 16 : 8;
    if (p->frame_bits == 0)
        p->frame_bits = p->method == WEFT_ACCUMULATE_FLOAT ? 32 : p->bits;
    if (p->low == 0.0 && p->high == 0.0)
        p->high = 1.0;
    if (p->batch == 0)
        p->batch = 1;
}

// Why the CPU is to do it, whatever the bounds; NULL: the GPU may.
static const char *reason_for_exact(const struct weft_accumulator_params *p, bool hardware)
{
    if (!p->frames_on_gl)
        return "frames lie in memory";
    if (!p->context || p->emulate)
        return "there is no context";
    if (!hardware)
        return "GL is a software renderer, on which sums in memory are faster";
    if (p->channel_count > WEFT_FRAME_GROUP)
        return "frames have more channels than a texture";
    if (p->frame_count == 0)
        return "of any number of frames no other method has a bound";
    if (p->nonfinite == WEFT_NONFINITE_SKIP)
        return "no other method skips values that are not finite";
    return NULL;
}

static bool takes(const struct weft_accumulator_params *p, const struct candidate *candidate)
{
    if (p->nonfinite == WEFT_NONFINITE_PROPAGATE && candidate->bits != 32)
        return false;
    for (int64_t i = 0; p->weight && i < p->frame_count; i++)
        if (!(p->weight[i] >= 0.0) && !ways[candidate->method]->negative)
            return false;
    return true;
}

static double bound_of(const struct weft_accumulator_params *params,
                       enum weft_accumulate_method method, int bits)
{
    struct weft_accumulator_params p = *params;
    p.method = method;
    p.bits = bits;
    weft_accumulate_fill_in(&p);
    return ways[method]->expect ? ways[method]->expect(&p, p.frame_count) : INFINITY;
}

enum weft_result weft_accumulate_choose(const struct weft_accumulator_params *p, bool hardware,
                                        struct weft_accumulate_choice *out)
{
    const double best = bound_of(p, WEFT_ACCUMULATE_EXACT, 0);
    const double wanted = p->max_error > 0.0 ? p->max_error : best;
    const char *why = reason_for_exact(p, hardware);
    if (best > wanted) {
        weft_error(
            p->log,
            "accumulate: no method is within %g for values from %g to %g: exact sums, rounded "
            "to floats, are within %g",
            wanted, p->low, p->high > p->low ? p->high : 1.0, best);
        return WEFT_ERR_UNSUPPORTED;
    }
    for (size_t i = 0; i < WEFT_COUNT(candidates) && !why; i++) {
        const struct candidate *c = &candidates[i];
        if (!takes(p, c) || bound_of(p, c->method, c->bits) > wanted)
            continue;
        *out = (struct weft_accumulate_choice){c->method, c->bits, c->why};
        return WEFT_OK;
    }
    *out = (struct weft_accumulate_choice){WEFT_ACCUMULATE_EXACT, 0,
                                           why ? why : "no method on the GPU is within max_error"};
    return WEFT_OK;
}
