// SPDX-License-Identifier: BSD-3-Clause
// Sums of weight * value in integers (sums/sums.h), divided by the sum of weights and rounded once.
//
// The bound. Let w' be the weights as they count, and W' their sum, scaled so that units are 2^-64.
// (1) A product is rounded to a unit only in wide sums, and there by 2^-65 at most: products of
//     integer weights with codes, integers and halves are whole units, those of floats are from
//     2^-41 on. Together: N 2^-65 / |W'|.
// (2) Weights are rounded to units, all together by `lost`. With v0 a pixel's exact mean,
//     sum w' v / W' - v0 = sum (w' - w) (v - v0) / W', and |v0| <= largest * sum |w| / |W|, which
//     makes lost * largest * (1 + sum |w| / |W|) / |W'|.
// (3) The quotient is rounded to a float, by half a unit of its last place: 2^-24 of the power of
//     two at or below it, or 2^-150 for the least floats.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/frame.h"
#include "passes/accumulate/sums/reach.h"
#include "passes/accumulate/sums/sums.h"

struct channel {
    struct weft_plane_sums sums;
    weft_uwide reach;   // sum over frames of |weight| * largest |value|, weights scaled (reach.h)
    weft_wide *missing; // weight of each pixel's values that were skipped; NULL: none was
    uint8_t *poisoned;  // pixels whose mean is NAN; NULL: none is
};

struct exact {
    struct channel *channel;
    double largest;  // of all |values|
    int64_t rounded; // frames whose own products may have been rounded
};

static size_t pixel_count(const weft_accumulator *a)
{
    return (size_t)a->params.width * (size_t)a->params.height;
}

static enum weft_result no_memory(const weft_accumulator *a)
{
    weft_error(a->params.log,
               "accumulate: not enough memory for sums of %" PRId32 " x %" PRId32
               " pixels with %d channels",
               a->params.width, a->params.height, a->params.channel_count);
    return WEFT_ERR_MEMORY;
}

static enum weft_result create(weft_accumulator *a)
{
    struct exact *own = a->own = calloc(1, sizeof *own);
    if (own)
        own->channel = calloc((size_t)a->params.channel_count, sizeof *own->channel);
    return own && own->channel ? WEFT_OK : no_memory(a);
}

static void destroy(weft_accumulator *a)
{
    struct exact *own = a->own;
    for (int c = 0; own && own->channel && c < a->params.channel_count; c++) {
        weft_sums_clear(&own->channel[c].sums);
        free(own->channel[c].missing);
        free(own->channel[c].poisoned);
    }
    if (own)
        free(own->channel);
    free(own);
    a->own = NULL;
}

// ---- frames -------------------------------------------------------------------------------------

struct addition {
    weft_accumulator *a;
    const struct weft_plane *planes;
    struct weft_weight weight;
    bool narrow; // the weights so far, and this one
};

static enum weft_sum_kind kind_for(const struct addition *add, int c)
{
    const struct exact *own = add->a->own;
    return weft_sums_common_kind(own->channel[c].sums.kind,
                                 weft_sums_kind_of(add->planes[c].type, add->narrow));
}

// What the frame alone adds to a channel's reach.
static double own_reach(const struct addition *add, int c)
{
    return fabs(add->weight.scaled) * add->a->scan[c].largest;
}

static double reach_with(const struct addition *add, int c)
{
    const struct exact *own = add->a->own;
    return weft_reach_read(own->channel[c].reach) + own_reach(add, c);
}

static enum weft_result refuse(const struct addition *add, int c)
{
    const weft_accumulator *a = add->a;
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    const double largest = nextafter(a->scan[c].largest, 0.0);
    const struct weft_place place = weft_scan_find(&shape, add->planes, c, largest);
    weft_error(a->params.log,
               "accumulate: frame %" PRId64 ", channel %d, pixel (%" PRId32 ", %" PRId32
               ") is %g: with its weight and the frames before it sums reach %g, the limit is %g",
               a->frames, c, place.x, place.y, place.value, reach_with(add, c),
               weft_sums_capacity(kind_for(add, c)));
    return WEFT_ERR_LIMIT;
}

static bool make_marks(struct channel *channel, enum weft_accumulate_nonfinite policy, size_t count)
{
    if (policy == WEFT_NONFINITE_SKIP && !channel->missing)
        channel->missing = calloc(count, sizeof *channel->missing);
    if (policy == WEFT_NONFINITE_PROPAGATE && !channel->poisoned)
        channel->poisoned = calloc(count, sizeof *channel->poisoned);
    return policy == WEFT_NONFINITE_SKIP ? channel->missing != NULL : channel->poisoned != NULL;
}

// Nothing is changed before all channels take the frame.
static enum weft_result prepare(const struct addition *add)
{
    const weft_accumulator *a = add->a;
    struct exact *own = a->own;
    for (int c = 0; c < a->params.channel_count; c++)
        if (!(reach_with(add, c) <= weft_sums_capacity(kind_for(add, c))))
            return refuse(add, c);
    for (int c = 0; c < a->params.channel_count; c++) {
        struct channel *channel = &own->channel[c];
        if (!weft_sums_raise(&channel->sums, kind_for(add, c), pixel_count(a)) ||
            (a->scan[c].nonfinite > 0 && !make_marks(channel, a->params.nonfinite, pixel_count(a))))
            return no_memory(a);
    }
    return WEFT_OK;
}

static bool add_block(void *priv, int thread, const struct weft_block *block)
{
    const struct addition *add = priv;
    const weft_accumulator *a = add->a;
    const struct exact *own = a->own;
    const struct channel *channel = &own->channel[block->channel];
    const struct weft_sums_addend addend = {block->values, block->type, block->at, block->count,
                                            a->scan[block->channel].largest};
    (void)thread;
    weft_sums_add(&channel->sums, &addend, &add->weight, a->params.cpu.instructions);
    for (size_t i = 0; i < block->bad_count; i++) {
        const size_t at = block->at + block->bad[i];
        if (channel->missing)
            channel->missing[at] += add->weight.fixed;
        if (channel->poisoned)
            channel->poisoned[at] = 1;
    }
    return true;
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    struct exact *own = a->own;
    struct addition add = {.a = a};
    enum weft_result res = weft_frame_planes(a, frame, &add.planes);
    weft_weight_make(&a->weights, weight, &add.weight);
    add.narrow = weft_weights_are_narrow(&a->weights, &add.weight);
    if (res == WEFT_OK)
        res = prepare(&add);
    if (res != WEFT_OK)
        return res;
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    const bool integer = weft_weight_is_integer(&add.weight);
    bool rounded = false;
    weft_blocks_run(&shape, add.planes, a->scan, add_block, &add);
    for (int c = 0; c < a->params.channel_count; c++) {
        own->channel[c].reach += weft_reach_make(own_reach(&add, c));
        own->largest = fmax(own->largest, a->scan[c].largest);
        rounded |= weft_sums_kind_of(add.planes[c].type, integer) >= WEFT_SUM_WIDE;
    }
    own->rounded += rounded;
    return WEFT_OK;
}

// ---- results ------------------------------------------------------------------------------------

struct reading {
    const weft_accumulator *a;
    const struct channel *channel;
    float *out;
    size_t stride;
};

static weft_wide weight_at(const struct reading *r, size_t i)
{
    return r->a->weights.total - (r->channel->missing ? r->channel->missing[i] : 0);
}

static float *place_of(const struct reading *r, size_t i)
{
    const size_t width = (size_t)r->a->params.width;
    return &r->out[i / width * r->stride + i % width];
}

static float mean_at(const struct reading *r, size_t i)
{
    const enum weft_sum_kind kind = weft_sums_widened(r->channel->sums.kind);
    const int factor = kind == WEFT_SUM_MIXED ? WEFT_SUM_LARGEST_CODE : 1;
    if (r->channel->poisoned && r->channel->poisoned[i])
        return NAN;
    return weft_wide_quotient(weft_sums_get(&r->channel->sums, i, kind), weight_at(r, i) * factor);
}

// Most are sure from a product of doubles, which is off by 6 * 2^-53 at most.
static bool read_mean(void *priv, int thread, size_t first, size_t end)
{
    enum { CHUNK = 512 };
    const struct reading *r = priv;
    const struct weft_plane_sums *sums = &r->channel->sums;
    const bool marked = r->channel->missing || r->channel->poisoned;
    const double factor =
        weft_sums_widened(sums->kind) == WEFT_SUM_MIXED ? WEFT_SUM_LARGEST_CODE : 1.0;
    const double unit = weft_sums_widening(sums->kind) / ((double)r->a->weights.total * factor);
    double read[CHUNK];
    (void)thread;
    for (size_t at = first; at < end; at += CHUNK) {
        const size_t count = end - at < CHUNK ? end - at : CHUNK;
        weft_sums_read(sums, at, count, read);
        for (size_t i = 0; i < count; i++) {
            float *out = place_of(r, at + i);
            if (marked || !weft_wide_is_near(read[i] * unit, out))
                *out = mean_at(r, at + i);
        }
    }
    return true;
}

static bool read_share(void *priv, int thread, size_t first, size_t end)
{
    const struct reading *r = priv;
    (void)thread;
    for (size_t i = first; i < end; i++)
        *place_of(r, i) = weft_wide_quotient(weight_at(r, i), r->a->weights.total);
    return true;
}

static enum weft_result read(const weft_accumulator *a, int channel, float *out, size_t stride,
                             bool (*part)(void *priv, int thread, size_t first, size_t end))
{
    const struct exact *own = a->own;
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    struct reading reading = {a, &own->channel[channel], out, stride};
    weft_pixels_run(&shape, part, &reading);
    return WEFT_OK;
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    return read(a, channel, out, stride, read_mean);
}

static enum weft_result share(weft_accumulator *a, int channel, float *out, size_t stride)
{
    return read(a, channel, out, stride, read_share);
}

// ---- reports ------------------------------------------------------------------------------------

// Half a unit in the last place of floats up to `largest`.
static double half_unit(double largest)
{
    return largest >= 0x1p-126 ? ldexp(1.0, ilogb(largest) - 24) : 0x1p-150;
}

// What the weights that were skipped leave is not known pixel by pixel: the bound is then for
// pixels without any.
static double bound(const weft_accumulator *a)
{
    const struct exact *own = a->own;
    const struct weft_weights *w = &a->weights;
    const double total = fabs(ldexp((double)w->total, -WEFT_WEIGHT_BITS));
    const double spread = ldexp((double)w->magnitude, -WEFT_WEIGHT_BITS) / total;
    const double units = (double)own->rounded * 0x1p-65 / total;
    const double lost = ldexp((double)w->lost, -WEFT_WEIGHT_LOST_BITS);
    const double weights = lost * own->largest * (1.0 + spread) / total;
    return half_unit(own->largest * spread + units + weights) + units + weights;
}

static double expect(const struct weft_accumulator_params *params, int64_t frames)
{
    (void)frames;
    return half_unit(fmax(fabs(params->low), fabs(params->high))) + 0x1p-65;
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct exact *own = a->own;
    out->weight_change = a->weights.change;
    out->bound = a->counted > 0 ? bound(a) : expect(&a->params, a->params.frame_count);
    for (int c = 0; c < a->params.channel_count; c++) {
        const struct channel *channel = &own->channel[c];
        const size_t bytes = weft_sums_size(channel->sums.kind) +
                             (channel->missing ? sizeof *channel->missing : 0) +
                             (channel->poisoned ? sizeof *channel->poisoned : 0);
        out->bytes += pixel_count(a) * bytes;
    }
}

// ---- states -------------------------------------------------------------------------------------

enum { MISSING = 1, POISONED = 2 }; // which marks a channel has

static enum weft_result save(weft_accumulator *a, weft_state *state)
{
    const struct exact *own = a->own;
    const size_t count = pixel_count(a);
    weft_state_put(state, &own->largest, sizeof own->largest);
    weft_state_put(state, &own->rounded, sizeof own->rounded);
    for (int c = 0; c < a->params.channel_count; c++) {
        const struct channel *channel = &own->channel[c];
        const uint32_t kind = channel->sums.kind;
        const uint32_t marks =
            (channel->missing ? MISSING : 0u) | (channel->poisoned ? POISONED : 0u);
        weft_state_put(state, &kind, sizeof kind);
        weft_state_put(state, &marks, sizeof marks);
        weft_state_put(state, &channel->reach, sizeof channel->reach);
        weft_state_put(state, channel->sums.sum, count * weft_sums_size(channel->sums.kind));
        if (channel->missing)
            weft_state_put(state, channel->missing, count * sizeof *channel->missing);
        if (channel->poisoned)
            weft_state_put(state, channel->poisoned, count * sizeof *channel->poisoned);
    }
    return WEFT_OK;
}

static enum weft_result load_channel(const weft_accumulator *a, struct channel *channel,
                                     weft_state *state)
{
    const size_t count = pixel_count(a);
    uint32_t kind, marks;
    weft_state_take(state, &kind, sizeof kind);
    weft_state_take(state, &marks, sizeof marks);
    weft_state_take(state, &channel->reach, sizeof channel->reach);
    if (kind >= WEFT_SUM_KIND_COUNT || marks > (MISSING | POISONED) ||
        !weft_reach_can_be(channel->reach)) {
        weft_error(a->params.log, "accumulate: the state is damaged: a channel cannot be");
        return WEFT_ERR_FORMAT;
    }
    if (!weft_sums_raise(&channel->sums, (enum weft_sum_kind)kind, count) ||
        (marks & MISSING && !make_marks(channel, WEFT_NONFINITE_SKIP, count)) ||
        (marks & POISONED && !make_marks(channel, WEFT_NONFINITE_PROPAGATE, count)))
        return no_memory(a);
    weft_state_take(state, channel->sums.sum, count * weft_sums_size(channel->sums.kind));
    if (channel->missing)
        weft_state_take(state, channel->missing, count * sizeof *channel->missing);
    if (channel->poisoned)
        weft_state_take(state, channel->poisoned, count * sizeof *channel->poisoned);
    return WEFT_OK;
}

static enum weft_result load(weft_accumulator *a, weft_state *state)
{
    struct exact *own = a->own;
    enum weft_result res = WEFT_OK;
    weft_state_take(state, &own->largest, sizeof own->largest);
    weft_state_take(state, &own->rounded, sizeof own->rounded);
    for (int c = 0; c < a->params.channel_count && res == WEFT_OK && !state->failed; c++)
        res = load_channel(a, &own->channel[c], state);
    return res;
}

static enum weft_sum_kind joined_kind(const weft_accumulator *a, const weft_accumulator *other,
                                      int c)
{
    const struct exact *own = a->own, *theirs = other->own;
    struct weft_weights weights = a->weights;
    weft_weights_join(&weights, &other->weights);
    const enum weft_sum_kind kind =
        weft_sums_common_kind(own->channel[c].sums.kind, theirs->channel[c].sums.kind);
    return weights.integers < 0 ? weft_sums_widened(kind) : kind;
}

static enum weft_result check_join(const weft_accumulator *a, const weft_accumulator *other)
{
    const struct exact *own = a->own, *theirs = other->own;
    for (int c = 0; c < a->params.channel_count; c++) {
        const double reach = weft_reach_read(own->channel[c].reach + theirs->channel[c].reach);
        const double limit = weft_sums_capacity(joined_kind(a, other, c));
        if (reach <= limit)
            continue;
        weft_error(a->params.log,
                   "accumulate: sums of channel %d reach %g together, the limit is %g", c, reach,
                   limit);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static void join_marks(struct channel *channel, const struct channel *other, size_t count)
{
    for (size_t i = 0; other->missing && i < count; i++)
        channel->missing[i] += other->missing[i];
    for (size_t i = 0; other->poisoned && i < count; i++)
        channel->poisoned[i] |= other->poisoned[i];
}

static enum weft_result join(weft_accumulator *a, const weft_accumulator *other)
{
    struct exact *own = a->own;
    const struct exact *theirs = other->own;
    const size_t count = pixel_count(a);
    enum weft_result res = check_join(a, other);
    for (int c = 0; c < a->params.channel_count && res == WEFT_OK; c++) {
        const struct channel *from = &theirs->channel[c];
        struct channel *to = &own->channel[c];
        if (!weft_sums_raise(&to->sums, joined_kind(a, other, c), count) ||
            ((from->missing || from->poisoned) && !make_marks(to, a->params.nonfinite, count)))
            return no_memory(a);
        weft_sums_join(&to->sums, &from->sums, 0, count);
        join_marks(to, from, count);
        to->reach += from->reach;
    }
    if (res != WEFT_OK)
        return res;
    own->largest = fmax(own->largest, theirs->largest);
    own->rounded += theirs->rounded;
    return WEFT_OK;
}

const struct weft_accumulate_way weft_accumulate_exact = {
    .method = WEFT_ACCUMULATE_EXACT,
    .negative = true,
    .scans = true,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .share = share,
    .expect = expect,
    .report = report,
    .save = save,
    .load = load,
    .join = join,
};
