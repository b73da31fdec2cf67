// SPDX-License-Identifier: BSD-3-Clause
// States: a header, what the params were, counts and weights, what the method has, what is kept
// beside it. Numbers are as they lie in memory.
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "passes/accumulate/accumulate_impl.h"
#include "passes/accumulate/moments.h"

enum { VERSION = 2, ORDER_MARK = 0x01020304 };
static const char magic[8] = {'W', 'E', 'F', 'T', 'S', 'U', 'M', 'S'};

struct header {
    char magic[sizeof magic];
    uint32_t version, order;
    uint64_t size;     // of all
    uint64_t checksum; // XXH3 of what follows
};

// ---- params -------------------------------------------------------------------------------------

// As numbers that are equal where states fit. Parts that are joined may differ from FRAME_COUNT on.
enum { LEVELS = 12, FRAME_COUNT = LEVELS + WEFT_TREE_MAX_LEVELS, WEIGHTS, RECORD };
static const char *const record_names[RECORD] = {"width",
                                                 "height",
                                                 "channel_count",
                                                 "method",
                                                 "branching",
                                                 "rounding",
                                                 "bits",
                                                 "low",
                                                 "high",
                                                 "nonfinite",
                                                 "keep",
                                                 "batch",
                                                 [LEVELS] = "level_branching",
                                                 [FRAME_COUNT] = "frame_count",
                                                 [WEIGHTS] = "hash of weights"};

static void make_record(const weft_accumulator *a, double record[RECORD])
{
    const struct weft_accumulator_params *p = &a->params;
    const double first[LEVELS] = {p->width,     p->height,    p->channel_count, p->method,
                                  p->branching, p->rounding,  p->bits,          p->low,
                                  p->high,      p->nonfinite, p->keep,          p->batch};
    memcpy(record, first, sizeof first);
    for (int i = 0; i < WEFT_TREE_MAX_LEVELS; i++)
        record[LEVELS + i] = p->level_branching[i];
    record[FRAME_COUNT] = (double)p->frame_count;
    record[WEIGHTS] = 0.0;
    if (a->weight) // 53 bits of the hash
        record[WEIGHTS] =
            (double)(XXH3_64bits(a->weight, (size_t)p->frame_count * sizeof *a->weight) >> 11);
}

static enum weft_result compare_records(const weft_accumulator *a, const double *own,
                                        const double *other, int count, const char *what)
{
    const char *name = "level_branching";
    for (int i = 0; i < count; i++) {
        if (own[i] == other[i])
            continue;
        if (record_names[i])
            name = record_names[i];
        weft_error(a->params.log, "accumulate: %s of other params: %s is %.16g, here %.16g", what,
                   name, other[i], own[i]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// ---- saving -------------------------------------------------------------------------------------

#define EACH_COUNT(call, a, state)                                                                 \
    do {                                                                                           \
        call(state, &(a)->frames, sizeof(a)->frames);                                              \
        call(state, &(a)->counted, sizeof(a)->counted);                                            \
        call(state, &(a)->nonfinite, sizeof(a)->nonfinite);                                        \
        call(state, &(a)->weights.scale_log2, sizeof(a)->weights.scale_log2);                      \
        call(state, &(a)->weights.total, sizeof(a)->weights.total);                                \
        call(state, &(a)->weights.square, sizeof(a)->weights.square);                              \
        call(state, &(a)->weights.integers, sizeof(a)->weights.integers);                          \
        call(state, &(a)->weights.magnitude, sizeof(a)->weights.magnitude);                        \
        call(state, &(a)->weights.change, sizeof(a)->weights.change);                              \
        call(state, &(a)->weights.lost, sizeof(a)->weights.lost);                                  \
    } while (0)

static enum weft_result put_all(weft_accumulator *a, weft_state *state)
{
    struct header header = {.version = VERSION, .order = ORDER_MARK};
    double record[RECORD];
    enum weft_result res = WEFT_OK;
    make_record(a, record);
    weft_state_put(state, &header, sizeof header);
    weft_state_put(state, record, sizeof record);
    EACH_COUNT(weft_state_put, a, state);
    res = a->way->save(a, state);
    if (res == WEFT_OK && a->moments)
        weft_moments_save(a, state);
    if (res != WEFT_OK || state->failed)
        return res != WEFT_OK ? res : WEFT_ERR_MEMORY;
    memcpy(header.magic, magic, sizeof magic);
    header.size = state->size;
    header.checksum = XXH3_64bits(state->bytes + sizeof header, state->size - sizeof header);
    memcpy(state->bytes, &header, sizeof header);
    return WEFT_OK;
}

enum weft_result weft_accumulator_save(weft_accumulator *a, void **out, size_t *size)
{
    weft_state state = {0};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = NULL;
    *size = 0;
    weft_require(a->params.log, !a->broken && !a->finished);
    if (!a->way->save) {
        weft_error(a->params.log, "accumulate: states of %s are not supported",
                   weft_accumulate_method_names[a->way->method]);
        return WEFT_ERR_UNSUPPORTED;
    }
    res = put_all(a, &state);
    if (state.failed)
        weft_error(a->params.log, "accumulate: not enough memory for a state");
    if (res != WEFT_OK)
        goto fail;
    *out = state.bytes;
    *size = state.size;
    return WEFT_OK;
fail:
    free(state.bytes);
    return res;
}

// ---- loading ------------------------------------------------------------------------------------

static enum weft_result refuse(const weft_accumulator *a, const char *why)
{
    weft_error(a->params.log, "accumulate: the state is %s", why);
    return WEFT_ERR_FORMAT;
}

static enum weft_result check_header(const weft_accumulator *a, const unsigned char *bytes,
                                     size_t size)
{
    struct header header;
    if (size < sizeof header)
        return refuse(a, "cut: its header is not whole");
    memcpy(&header, bytes, sizeof header);
    if (memcmp(header.magic, magic, sizeof magic) != 0)
        return refuse(a, "none of an accumulation");
    if (header.order != ORDER_MARK)
        return refuse(a, "of a machine with another order of bytes");
    if (header.version != VERSION) {
        weft_error(a->params.log,
                   "accumulate: the state is of version %" PRIu32 ", this weft reads version %d",
                   header.version, VERSION);
        return WEFT_ERR_FORMAT;
    }
    if (header.size != size) {
        weft_error(a->params.log, "accumulate: the state has %zu bytes instead of %" PRIu64, size,
                   header.size);
        return WEFT_ERR_FORMAT;
    }
    if (header.checksum != XXH3_64bits(bytes + sizeof header, size - sizeof header))
        return refuse(a, "damaged: its checksum does not fit");
    return WEFT_OK;
}

static bool counts_can_be(const weft_accumulator *a)
{
    const int64_t most = a->params.frame_count ? a->params.frame_count : WEFT_ACCUMULATE_MAX_FRAMES;
    return a->frames >= 0 && a->frames <= most && a->counted >= 0 && a->counted <= a->frames &&
           a->weights.integers >= -1 && a->weights.integers < WEFT_WEIGHT_NARROW_TOTAL &&
           a->weights.scale_log2 > -2000 && a->weights.scale_log2 < 2000;
}

static enum weft_result take_all(weft_accumulator *a, weft_state *state)
{
    double record[RECORD], own[RECORD];
    enum weft_result res = WEFT_OK;
    make_record(a, own);
    state->at = sizeof(struct header);
    weft_state_take(state, record, sizeof record);
    if (state->failed)
        return refuse(a, "cut");
    res = compare_records(a, own, record, RECORD, "the state is");
    if (res != WEFT_OK)
        return res;
    EACH_COUNT(weft_state_take, a, state);
    if (!state->failed && !counts_can_be(a))
        return refuse(a, "damaged: its counts cannot be");
    if (!state->failed)
        res = a->way->load(a, state);
    if (res == WEFT_OK && !state->failed && a->moments)
        res = weft_moments_load(a, state);
    if (res == WEFT_OK && (state->failed || state->at != state->size))
        res = refuse(a, "damaged: its content is not as long as it has to be");
    return res;
}

// Without frames, as it was created.
static void start_again(weft_accumulator *a)
{
    const int32_t scale = a->weights.scale_log2;
    a->frames = a->counted = 0;
    a->nonfinite = 0;
    a->weights = (struct weft_weights){.scale_log2 = scale};
    a->way->destroy(a);
    weft_moments_destroy(a);
    a->broken =
        (a->params.keep && weft_moments_create(a) != WEFT_OK) || a->way->create(a) != WEFT_OK;
}

enum weft_result weft_accumulator_load(weft_accumulator *a, const void *bytes, size_t size)
{
    const int32_t scale = a->weights.scale_log2;
    weft_state state = {.bytes = (unsigned char *)(uintptr_t)bytes, .size = size};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(a->params.log, bytes);
    weft_require(a->params.log, !a->broken && !a->finished && a->frames == 0);
    if (!a->way->load) {
        weft_error(a->params.log, "accumulate: states of %s are not supported",
                   weft_accumulate_method_names[a->way->method]);
        return WEFT_ERR_UNSUPPORTED;
    }
    res = check_header(a, bytes, size);
    if (res != WEFT_OK)
        return res;
    res = take_all(a, &state);
    if (res == WEFT_OK && a->weights.scale_log2 != scale)
        res = refuse(a, "damaged: its weights have another scale");
    if (res != WEFT_OK) {
        a->weights.scale_log2 = scale;
        start_again(a);
        return res;
    }
    a->total_weight = weft_weights_total(&a->weights);
    return WEFT_OK;
fail:
    return res;
}

// ---- joining ------------------------------------------------------------------------------------

static enum weft_result check_join(const weft_accumulator *a, const weft_accumulator *other)
{
    double own[RECORD], others[RECORD];
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(a->params.log, other && other != a);
    weft_require(a->params.log, !a->broken && !a->finished && !other->broken);
    if (!a->way->join) {
        weft_error(a->params.log, "accumulate: %s cannot be joined: exact can",
                   weft_accumulate_method_names[a->way->method]);
        return WEFT_ERR_ARGUMENT;
    }
    make_record(a, own);
    make_record(other, others);
    res = compare_records(a, own, others, FRAME_COUNT, "what is joined is");
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    if (a->weights.scale_log2 != other->weights.scale_log2)
        weft_error(a->params.log,
                   "accumulate: what is joined has weights of another scale: 2^%d, here 2^%d",
                   -other->weights.scale_log2, -a->weights.scale_log2);
    else if (a->frames + other->frames > WEFT_ACCUMULATE_MAX_FRAMES)
        weft_error(a->params.log, "accumulate: %" PRId64 " and %" PRId64 " frames are more than %d",
                   a->frames, other->frames, WEFT_ACCUMULATE_MAX_FRAMES);
    else
        res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_accumulator_join(weft_accumulator *a, const weft_accumulator *other)
{
    enum weft_result res = check_join(a, other);
    if (res == WEFT_OK && a->moments)
        res = weft_moments_check_join(a, other);
    if (res == WEFT_OK)
        res = a->way->join(a, other);
    if (res == WEFT_OK && a->moments)
        res = weft_moments_join(a, other);
    a->broken = a->broken || res == WEFT_ERR_MEMORY;
    if (res != WEFT_OK)
        return res;
    weft_weights_join(&a->weights, &other->weights);
    a->total_weight = weft_weights_total(&a->weights);
    a->frames += other->frames;
    a->counted += other->counted;
    a->nonfinite += other->nonfinite;
    return WEFT_OK;
}
