// SPDX-License-Identifier: BSD-3-Clause
// Samples are the sums of batches of frames, without weights: their variance is that of the sums
// over the square of the batch's length. A batch of one frame is folded as it comes; longer ones
// are added up first.
#include "passes/accumulate/moments.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/sums/reach.h"
#include "passes/accumulate/sums/squares.h"

// Narrow sums take no more frames, and no longer batches.
enum { NARROW_FRAMES = 1 << 22, NARROW_BATCH = 1 << 10 };
// Samples that are missing where the policy makes results NAN.
static const uint32_t NEVER = UINT32_MAX;

static const struct weft_weight one = {
    .fixed = (weft_wide)1 << WEFT_WEIGHT_BITS, .scaled = 1.0, .integer = 1};

struct channel {
    struct weft_plane_sums first, open; // of whole batches, and of the one that is not whole
    struct weft_plane_squares square;   // of the sums of whole batches
    weft_uwide reach, reach_of_squares; // no sum exceeds these (reach.h)
    float *least, *largest;             // NULL: not kept
    uint32_t *missing;                  // whole batches that do not count; NULL: all do everywhere
    uint8_t *spoilt;                    // the open batch will not count; NULL likewise
};

struct weft_moments {
    struct channel *channel;
    int64_t batches;            // that are whole
    int64_t open;               // frames of the one that is not
    weft_wide weight;           // of the latter
    struct weft_wide256 square; // sum of squares of whole batches' weights
};

static size_t pixel_count(const weft_accumulator *a)
{
    return (size_t)a->params.width * (size_t)a->params.height;
}

static bool keeps_variance(const weft_accumulator *a)
{
    return a->params.keep & WEFT_KEEP_VARIANCE;
}

// ---- memory -------------------------------------------------------------------------------------

static enum weft_result no_memory(const weft_accumulator *a)
{
    weft_error(a->params.log,
               "accumulate: not enough memory for what is kept beside the mean of %" PRId32
               " x %" PRId32 " pixels with %d channels",
               a->params.width, a->params.height, a->params.channel_count);
    return WEFT_ERR_MEMORY;
}

static bool make_extremes(struct channel *channel, size_t count)
{
    channel->least = malloc(count * sizeof *channel->least);
    channel->largest = malloc(count * sizeof *channel->largest);
    for (size_t i = 0; channel->least && channel->largest && i < count; i++) {
        channel->least[i] = INFINITY;
        channel->largest[i] = -INFINITY;
    }
    return channel->least && channel->largest;
}

enum weft_result weft_moments_create(weft_accumulator *a)
{
    const size_t channels = (size_t)a->params.channel_count;
    struct weft_moments *m = a->moments = calloc(1, sizeof *m);
    if (m)
        m->channel = calloc(channels, sizeof *m->channel);
    if (!m || !m->channel)
        return no_memory(a);
    for (size_t c = 0; c < channels && a->params.keep & WEFT_KEEP_EXTREMES; c++)
        if (!make_extremes(&m->channel[c], pixel_count(a)))
            return no_memory(a);
    return WEFT_OK;
}

void weft_moments_destroy(weft_accumulator *a)
{
    struct weft_moments *m = a->moments;
    for (int c = 0; m && m->channel && c < a->params.channel_count; c++) {
        struct channel *channel = &m->channel[c];
        weft_sums_clear(&channel->first);
        weft_sums_clear(&channel->open);
        weft_squares_clear(&channel->square);
        free(channel->least);
        free(channel->largest);
        free(channel->missing);
        free(channel->spoilt);
    }
    if (m)
        free(m->channel);
    free(m);
    a->moments = NULL;
}

uint64_t weft_moments_bytes(const weft_accumulator *a)
{
    uint64_t bytes = 0;
    for (int c = 0; a->moments && c < a->params.channel_count; c++) {
        const struct channel *channel = &a->moments->channel[c];
        bytes += weft_sums_size(channel->first.kind) + weft_sums_size(channel->open.kind) +
                 weft_squares_size(channel->square.kind) +
                 (channel->least ? 2 * sizeof *channel->least : 0) +
                 (channel->missing ? sizeof *channel->missing : 0) +
                 (channel->spoilt ? sizeof *channel->spoilt : 0);
    }
    return bytes * pixel_count(a);
}

static bool raise(const weft_accumulator *a, struct channel *channel, enum weft_sum_kind kind)
{
    const size_t count = pixel_count(a);
    return weft_sums_raise(&channel->first, kind, count) &&
           weft_squares_raise(&channel->square, kind, count) &&
           (a->params.batch == 1 || weft_sums_raise(&channel->open, kind, count));
}

static bool make_marks(const weft_accumulator *a, struct channel *channel)
{
    if (!channel->missing)
        channel->missing = calloc(pixel_count(a), sizeof *channel->missing);
    if (!channel->spoilt)
        channel->spoilt = calloc(pixel_count(a), sizeof *channel->spoilt);
    return channel->missing && channel->spoilt;
}

// ---- limits -------------------------------------------------------------------------------------

static bool is_narrow(const weft_accumulator *a, int64_t counted)
{
    return counted < NARROW_FRAMES && a->params.batch < NARROW_BATCH;
}

// A batch's sum is at most that of its frames' largest values, so its square at most `batch` times
// that of these values' squares.
static double reach_of_squares(const weft_accumulator *a, double largest)
{
    return a->params.batch * largest * largest;
}

static bool fits(const struct channel *channel, enum weft_sum_kind kind, double reach,
                 double squares)
{
    return weft_reach_read(channel->reach) + reach <= weft_sums_capacity(kind) &&
           weft_reach_read_squares(channel->reach_of_squares) + squares <=
               weft_squares_capacity(kind);
}

static enum weft_sum_kind kind_for(const weft_accumulator *a, const struct channel *channel,
                                   enum weft_plane_type type)
{
    return weft_sums_common_kind(channel->first.kind,
                                 weft_sums_kind_of(type, is_narrow(a, a->counted)));
}

enum weft_result weft_moments_check(const weft_accumulator *a, const struct weft_plane *planes)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    for (int c = 0; c < shape.channel_count && keeps_variance(a); c++) {
        const struct channel *channel = &a->moments->channel[c];
        const double largest = a->scan[c].largest;
        const enum weft_sum_kind kind = kind_for(a, channel, planes[c].type);
        if (fits(channel, kind, largest, reach_of_squares(a, largest)))
            continue;
        const struct weft_place place = weft_scan_find(&shape, planes, c, nextafter(largest, 0.0));
        weft_error(a->params.log,
                   "accumulate: frame %" PRId64 ", channel %d, pixel (%" PRId32 ", %" PRId32
                   ") is %g: with the frames before it sums of squares reach %g, the limit is %g",
                   a->frames, c, place.x, place.y, place.value,
                   weft_reach_read_squares(channel->reach_of_squares) +
                       reach_of_squares(a, largest),
                   weft_squares_capacity(kind));
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

// ---- adding -------------------------------------------------------------------------------------

static void add_to_batch(const weft_accumulator *a, const struct channel *channel,
                         const struct weft_block *block)
{
    const enum weft_sum_kind kind = channel->first.kind;
    weft_wide terms[WEFT_BLOCK_VALUES];
    const bool whole = a->params.batch == 1;
    const struct weft_plane_sums sums =
        whole ? (struct weft_plane_sums){kind, terms} : channel->open;
    const struct weft_sums_addend addend = {block->values, block->type, whole ? 0 : block->at,
                                            block->count, a->scan[block->channel].largest};
    if (whole)
        memset(terms, 0, block->count * weft_sums_size(kind));
    weft_sums_add(&sums, &addend, &one, a->params.cpu.instructions);
    if (whole)
        weft_squares_fold(&channel->square, &channel->first, block->at, terms, block->count);
}

// A half's exponent and mantissa, where a float has them, are the half but for the exponents' bias.
static void read_halves(const uint16_t *half, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = (uint32_t)(half[i] & 0x7fff) << 13;
        float size;
        memcpy(&size, &bits, sizeof size);
        size *= 0x1p112f;
        out[i] = half[i] & 0x8000 ? -size : size;
    }
}

// Adding 0 makes the negative one positive, so that it does not matter which of them came first.
static void widen_extremes(const struct channel *channel, const struct weft_block *block)
{
    const struct weft_plane plane = {block->values, block->type, 0, 0};
    float *least = channel->least + block->at, *largest = channel->largest + block->at;
    float values[WEFT_BLOCK_VALUES];
    if (block->type == WEFT_PLANE_HALF)
        read_halves(block->values, block->count, values);
    else
        weft_plane_row(&plane, 0, (int32_t)block->count, values, 1);
    for (size_t i = 0; i < block->bad_count; i++)
        values[block->bad[i]] = NAN; // compares as false
    for (size_t i = 0; i < block->count; i++) {
        const float value = values[i] + 0.0f;
        least[i] = value < least[i] ? value : least[i];
        largest[i] = value > largest[i] ? value : largest[i];
    }
}

static bool add_block(void *priv, int thread, const struct weft_block *block)
{
    const weft_accumulator *a = priv;
    const struct channel *channel = &a->moments->channel[block->channel];
    (void)thread;
    if (keeps_variance(a))
        add_to_batch(a, channel, block);
    if (channel->least)
        widen_extremes(channel, block);
    for (size_t i = 0; i < block->bad_count; i++)
        channel->spoilt[block->at + block->bad[i]] = 1;
    return true;
}

// What is spoilt does not count.
static bool close_pixels(void *priv, int thread, size_t first, size_t end)
{
    const weft_accumulator *a = priv;
    (void)thread;
    for (int c = 0; c < a->params.channel_count; c++) {
        const struct channel *channel = &a->moments->channel[c];
        const size_t size = weft_sums_size(channel->open.kind);
        char *terms = (char *)channel->open.sum + first * size;
        for (size_t i = first; channel->spoilt && i < end; i++)
            if (channel->spoilt[i])
                memset(terms + (i - first) * size, 0, size);
        weft_squares_fold(&channel->square, &channel->first, first, terms, end - first);
        memset(terms, 0, (end - first) * size);
    }
    return true;
}

static void count_spoilt(const weft_accumulator *a, struct channel *channel)
{
    const bool never = a->params.nonfinite == WEFT_NONFINITE_PROPAGATE;
    for (size_t i = 0; channel->spoilt && i < pixel_count(a); i++) {
        if (channel->spoilt[i])
            channel->missing[i] = never ? NEVER : channel->missing[i] + 1;
        channel->spoilt[i] = 0;
    }
}

static void close_batch(weft_accumulator *a)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    struct weft_moments *m = a->moments;
    const weft_uwide weight = weft_wide_magnitude(m->weight);
    if (a->params.batch > 1 && keeps_variance(a))
        weft_pixels_run(&shape, close_pixels, a);
    for (int c = 0; c < shape.channel_count; c++)
        count_spoilt(a, &m->channel[c]);
    m->square = weft_wide256_sum(m->square, weft_wide256_product(weight, weight));
    m->batches++;
    m->open = 0;
    m->weight = 0;
}

enum weft_result weft_moments_add(weft_accumulator *a, const struct weft_plane *planes,
                                  double weight)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    struct weft_moments *m = a->moments;
    struct weft_weight counted;
    weft_weight_make(&a->weights, weight, &counted);
    for (int c = 0; c < shape.channel_count; c++) {
        struct channel *channel = &m->channel[c];
        if ((keeps_variance(a) && !raise(a, channel, kind_for(a, channel, planes[c].type))) ||
            (a->scan[c].nonfinite > 0 && !make_marks(a, channel)))
            return no_memory(a);
        if (!keeps_variance(a))
            continue;
        channel->reach += weft_reach_make(a->scan[c].largest);
        channel->reach_of_squares +=
            weft_reach_make_squares(reach_of_squares(a, a->scan[c].largest));
    }
    weft_blocks_run(&shape, planes, a->scan, add_block, a);
    m->weight += counted.fixed;
    m->open++;
    if (m->open == a->params.batch)
        close_batch(a);
    return WEFT_OK;
}

// ---- results ------------------------------------------------------------------------------------

struct reading {
    const weft_accumulator *a;
    const struct channel *channel;
    enum weft_accumulated what;
    double weights; // sum of squares of batches' weights / square of their sum
    float *out;
    size_t stride;
};

// Those of the last batch count as if it were whole: of frames that do not depend on each other,
// fewer ones vary more.
static double share_of_squares(const weft_accumulator *a)
{
    const struct weft_moments *m = a->moments;
    const double open = (double)m->weight, total = (double)a->weights.total;
    double square = weft_wide256_to_double(m->square);
    if (m->open > 0)
        square += open * open * a->params.batch / (double)m->open;
    return square / (total * total);
}

static double variance_at(const struct reading *r, size_t i)
{
    const struct channel *channel = r->channel;
    const uint32_t missing = channel->missing ? channel->missing[i] : 0;
    const int64_t n = r->a->moments->batches - missing;
    const double batch = r->a->params.batch;
    if (missing == NEVER || n < 2)
        return (double)NAN;
    const double spread = weft_squares_spread(&channel->square, &channel->first, i, (uint64_t)n);
    const double variance = spread / ((double)n * (double)(n - 1) * batch * batch);
    if (r->what == WEFT_ACCUMULATED_VARIANCE)
        return variance;
    return sqrt(variance * r->weights * (double)r->a->moments->batches / (double)n);
}

static float extreme_at(const struct reading *r, size_t i)
{
    const struct channel *channel = r->channel;
    const bool never = r->a->params.nonfinite == WEFT_NONFINITE_PROPAGATE && channel->missing &&
                       (channel->missing[i] == NEVER || channel->spoilt[i]);
    if (never || channel->least[i] > channel->largest[i])
        return NAN;
    return r->what == WEFT_ACCUMULATED_MINIMUM ? channel->least[i] : channel->largest[i];
}

static bool read_pixels(void *priv, int thread, size_t first, size_t end)
{
    const struct reading *r = priv;
    const size_t width = (size_t)r->a->params.width;
    const bool extreme = r->what == WEFT_ACCUMULATED_MINIMUM || r->what == WEFT_ACCUMULATED_MAXIMUM;
    (void)thread;
    for (size_t i = first; i < end; i++)
        r->out[i / width * r->stride + i % width] =
            extreme ? extreme_at(r, i) : (float)variance_at(r, i);
    return true;
}

enum weft_result weft_moments_read(weft_accumulator *a, enum weft_accumulated what, int channel,
                                   float *out, size_t stride)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    struct reading reading = {a,     &a->moments->channel[channel], what, share_of_squares(a), out,
                              stride};
    weft_pixels_run(&shape, read_pixels, &reading);
    return WEFT_OK;
}

// ---- states -------------------------------------------------------------------------------------

typedef bool transfer(weft_state *state, void *bytes, size_t size);

static bool put(weft_state *state, void *bytes, size_t size)
{
    weft_state_put(state, bytes, size);
    return true;
}

static void move_counts(struct weft_moments *m, weft_state *state, transfer *move)
{
    move(state, &m->batches, sizeof m->batches);
    move(state, &m->open, sizeof m->open);
    move(state, &m->weight, sizeof m->weight);
    move(state, &m->square, sizeof m->square);
}

// What a channel has is there already.
static void move_channel(const weft_accumulator *a, struct channel *channel, weft_state *state,
                         transfer *move)
{
    const size_t count = pixel_count(a);
    move(state, &channel->reach, sizeof channel->reach);
    move(state, &channel->reach_of_squares, sizeof channel->reach_of_squares);
    move(state, channel->first.sum, count * weft_sums_size(channel->first.kind));
    move(state, channel->square.sum, count * weft_squares_size(channel->square.kind));
    move(state, channel->open.sum, count * weft_sums_size(channel->open.kind));
    move(state, channel->least, channel->least ? count * sizeof *channel->least : 0);
    move(state, channel->largest, channel->largest ? count * sizeof *channel->largest : 0);
    move(state, channel->missing, channel->missing ? count * sizeof *channel->missing : 0);
    move(state, channel->spoilt, channel->spoilt ? count * sizeof *channel->spoilt : 0);
}

void weft_moments_save(const weft_accumulator *a, weft_state *state)
{
    struct weft_moments *m = a->moments;
    move_counts(m, state, put);
    for (int c = 0; c < a->params.channel_count; c++) {
        const uint32_t has[] = {m->channel[c].first.kind, m->channel[c].missing != NULL};
        weft_state_put(state, has, sizeof has);
        move_channel(a, &m->channel[c], state, put);
    }
}

enum weft_result weft_moments_load(weft_accumulator *a, weft_state *state)
{
    struct weft_moments *m = a->moments;
    uint32_t has[2];
    move_counts(m, state, weft_state_take);
    if (m->batches < 0 || m->open < 0 || m->open >= a->params.batch ||
        m->batches > WEFT_ACCUMULATE_MAX_FRAMES) {
        weft_error(a->params.log, "accumulate: the state is damaged: its batches cannot be");
        return WEFT_ERR_FORMAT;
    }
    for (int c = 0; c < a->params.channel_count && !state->failed; c++) {
        struct channel *channel = &m->channel[c];
        weft_state_take(state, has, sizeof has);
        if (has[0] >= WEFT_SUM_KIND_COUNT || has[1] > 1) {
            weft_error(a->params.log, "accumulate: the state is damaged: a channel cannot be");
            return WEFT_ERR_FORMAT;
        }
        if (!raise(a, channel, (enum weft_sum_kind)has[0]) || (has[1] && !make_marks(a, channel)))
            return no_memory(a);
        move_channel(a, channel, state, weft_state_take);
    }
    return WEFT_OK;
}

// ---- joining ------------------------------------------------------------------------------------

static enum weft_sum_kind joined_kind(const weft_accumulator *a, const weft_accumulator *other,
                                      int c)
{
    const enum weft_sum_kind kind = weft_sums_common_kind(a->moments->channel[c].first.kind,
                                                          other->moments->channel[c].first.kind);
    return is_narrow(a, a->counted + other->counted) ? kind : weft_sums_widened(kind);
}

enum weft_result weft_moments_check_join(const weft_accumulator *a, const weft_accumulator *other)
{
    if (a->moments->open > 0 && other->moments->open > 0) {
        weft_error(a->params.log,
                   "accumulate: both parts end in a batch that is not whole, of %" PRId64
                   " and %" PRId64 " frames instead of %d",
                   a->moments->open, other->moments->open, a->params.batch);
        return WEFT_ERR_ARGUMENT;
    }
    for (int c = 0; c < a->params.channel_count; c++) {
        const struct channel *to = &a->moments->channel[c], *from = &other->moments->channel[c];
        const enum weft_sum_kind kind = joined_kind(a, other, c);
        const double squares = weft_reach_read_squares(from->reach_of_squares);
        if (fits(to, kind, weft_reach_read(from->reach), squares))
            continue;
        weft_error(a->params.log,
                   "accumulate: sums of squares of channel %d reach %g together, the limit is %g",
                   c, weft_reach_read_squares(to->reach_of_squares) + squares,
                   weft_squares_capacity(kind));
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static void join_channel(const weft_accumulator *a, struct channel *to, const struct channel *from)
{
    const size_t count = pixel_count(a);
    weft_sums_join(&to->first, &from->first, 0, count);
    weft_sums_join(&to->open, &from->open, 0, count);
    weft_squares_join(&to->square, &from->square, count);
    to->reach += from->reach;
    to->reach_of_squares += from->reach_of_squares;
    for (size_t i = 0; to->least && i < count; i++) {
        to->least[i] = fminf(to->least[i], from->least[i]);
        to->largest[i] = fmaxf(to->largest[i], from->largest[i]);
    }
    for (size_t i = 0; from->missing && i < count; i++) {
        const bool never = to->missing[i] == NEVER || from->missing[i] == NEVER;
        to->missing[i] = never ? NEVER : to->missing[i] + from->missing[i];
        to->spoilt[i] |= from->spoilt[i];
    }
}

enum weft_result weft_moments_join(weft_accumulator *a, const weft_accumulator *other)
{
    struct weft_moments *m = a->moments;
    const struct weft_moments *theirs = other->moments;
    for (int c = 0; c < a->params.channel_count; c++) {
        struct channel *to = &m->channel[c];
        const struct channel *from = &theirs->channel[c];
        if (!raise(a, to, joined_kind(a, other, c)) || (from->missing && !make_marks(a, to)))
            return no_memory(a);
        join_channel(a, to, from);
    }
    m->batches += theirs->batches;
    m->open += theirs->open;
    m->weight += theirs->weight;
    m->square = weft_wide256_sum(m->square, theirs->square);
    return WEFT_OK;
}
