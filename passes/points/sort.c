// SPDX-License-Identifier: BSD-3-Clause
// Where points lie, and in which order they are added up.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/points/points_impl.h"

// Points that a thread rounds at once; and from how many on in a cell its whole block is gathered.
enum { CHUNK = 8192, DENSE = 64 };
enum { NUMBER_BITS = 20, KEY_BITS = 64 - NUMBER_BITS, DIGIT_BITS = 9, DIGITS = 1 << DIGIT_BITS };

const size_t weft_point_batch_bytes =
    sizeof(struct weft_point_place) + 2 * sizeof(uint64_t) + sizeof(struct weft_point_run);

enum weft_result weft_point_batch_create(const struct weft_log *log, size_t capacity,
                                         struct weft_point_batch *out)
{
    *out = (struct weft_point_batch){.capacity = capacity};
    out->cell = malloc(capacity * sizeof *out->cell);
    out->place = malloc(capacity * sizeof *out->place);
    out->sorted = malloc(capacity * sizeof *out->sorted);
    out->spare = malloc(capacity * sizeof *out->spare);
    out->run = malloc(capacity * sizeof *out->run);
    if (out->cell && out->place && out->sorted && out->spare && out->run)
        return WEFT_OK;
    weft_error(log, "not enough memory to sort %zu points", capacity);
    weft_point_batch_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_point_batch_destroy(struct weft_point_batch *batch)
{
    free(batch->cell);
    free(batch->place);
    free(batch->sorted);
    free(batch->spare);
    free(batch->run);
    *batch = (struct weft_point_batch){0};
}

// ---- rounding -----------------------------------------------------------------------------------

// What threads find of a chunk of points.
struct chunk {
    int32_t low[3], high[3]; // of cells
    uint32_t bad, outside;
};

struct rounding {
    const weft_points *points;
    const struct weft_points_run_params *params;
    struct weft_point_batch *batch;
    struct chunk *chunks;
};

enum { BAD = INT32_MIN }; // cell[0] of a point without a position

// false: not finite, or beyond index range.
static bool place_point(const weft_points *p, const double position[3],
                        struct weft_point_place *out, int32_t whole[3])
{
    for (int a = 0; a < 3; a++) {
        const double *m = p->to_index[a];
        const double at = p->info.space == WEFT_SPACE_INDEX
                              ? position[a]
                              : m[0] * position[0] + m[1] * position[1] + m[2] * position[2] + m[3];
        if (!(fabs(at) <= WEFT_INDEX_LIMIT - 64.0))
            return false;
        const double floor_at = floor(at);
        // Exact but for the rounding itself, half-way up.
        const uint32_t units = (uint32_t)((at - floor_at) * 0x1p29 + 0.5) + p->tap_shift;
        whole[a] = (int32_t)floor_at + (int32_t)(units >> WEFT_LINE_FRACTION);
        out->word[a] = (uint32_t)(whole[a] & 7) << WEFT_LINE_FRACTION |
                       (units & ((UINT32_C(1) << WEFT_LINE_FRACTION) - 1));
    }
    return true;
}

static bool is_outside(const weft_points *p, const struct weft_volume_info *volume,
                       const int32_t whole[3])
{
    bool outside = volume->empty;
    for (int a = 0; a < 3; a++) {
        const int32_t first = whole[a] - p->tap_offset;
        outside |= first > volume->active_max[a] ||
                   first + p->info.kernel.width - 1 < volume->active_min[a];
    }
    return outside;
}

static void set_bad(const struct rounding *r, size_t i)
{
    r->batch->cell[i][0] = BAD;
    for (int o = 0; o < r->points->info.output_count; o++)
        r->params->out[(size_t)o * r->params->stride + r->batch->first + i] = NAN;
}

static bool round_chunk(void *priv, int thread, size_t number)
{
    struct rounding *r = priv;
    const struct weft_volume_info *volume = weft_volume_get_info(r->points->voxels);
    struct chunk *chunk = &r->chunks[number];
    const size_t from = number * CHUNK;
    const size_t end = from + CHUNK < r->batch->count ? from + CHUNK : r->batch->count;
    (void)thread;
    *chunk = (struct chunk){.low = {INT32_MAX, INT32_MAX, INT32_MAX},
                            .high = {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (size_t i = from; i < end; i++) {
        int32_t whole[3], *cell = r->batch->cell[i];
        if (!place_point(r->points, r->params->position[r->batch->first + i], &r->batch->place[i],
                         whole)) {
            set_bad(r, i);
            chunk->bad++;
            continue;
        }
        chunk->outside += is_outside(r->points, volume, whole);
        for (int a = 0; a < 3; a++) {
            cell[a] = whole[a] >> 3;
            chunk->low[a] = cell[a] < chunk->low[a] ? cell[a] : chunk->low[a];
            chunk->high[a] = cell[a] > chunk->high[a] ? cell[a] : chunk->high[a];
        }
    }
    return true;
}

static struct chunk join_chunks(const struct chunk *chunks, size_t count)
{
    struct chunk all = chunks[0];
    for (size_t i = 1; i < count; i++) {
        all.bad += chunks[i].bad;
        all.outside += chunks[i].outside;
        for (int a = 0; a < 3; a++) {
            all.low[a] = chunks[i].low[a] < all.low[a] ? chunks[i].low[a] : all.low[a];
            all.high[a] = chunks[i].high[a] > all.high[a] ? chunks[i].high[a] : all.high[a];
        }
    }
    return all;
}

// ---- sorting ------------------------------------------------------------------------------------

// How cells become keys: x in the lowest bits. Where the cells of a batch lie so far apart that
// keys have no room for their numbers, `coarse` low bits of each are left out.
struct key_form {
    int32_t low[3];
    int bits[3], coarse;
};

static int bits_of(uint32_t value)
{
    return value ? 32 - __builtin_clz(value) : 0;
}

static struct key_form form_of(const struct chunk *all)
{
    struct key_form form = {.coarse = 0};
    int sum;
    form.coarse = -1;
    do {
        sum = 0;
        form.coarse++;
        for (int a = 0; a < 3; a++) {
            form.low[a] = all->low[a];
            form.bits[a] = bits_of(((uint32_t)all->high[a] - (uint32_t)all->low[a]) >> form.coarse);
            sum += form.bits[a];
        }
    } while (sum > KEY_BITS);
    return form;
}

static uint64_t key_of(const struct key_form *form, const int32_t cell[3])
{
    uint64_t key = 0;
    for (int a = 2; a >= 0; a--)
        key = key << form->bits[a] | ((uint32_t)cell[a] - (uint32_t)form->low[a]) >> form->coarse;
    return key;
}

// One digit of all keys, from the lowest one on: equal ones stay in order.
static void sort_digit(struct weft_point_batch *b, int shift)
{
    uint32_t start[DIGITS] = {0};
    for (size_t i = 0; i < b->good; i++)
        start[b->sorted[i] >> shift & (DIGITS - 1)]++;
    uint32_t sum = 0;
    for (int d = 0; d < DIGITS; d++) {
        const uint32_t count = start[d];
        start[d] = sum;
        sum += count;
    }
    for (size_t i = 0; i < b->good; i++)
        b->spare[start[b->sorted[i] >> shift & (DIGITS - 1)]++] = b->sorted[i];
    uint64_t *swap = b->sorted;
    b->sorted = b->spare;
    b->spare = swap;
}

static void sort_points(struct weft_point_batch *b, const struct key_form *form)
{
    bool in_order = true;
    b->good = 0;
    for (size_t i = 0; i < b->count; i++) {
        if (b->cell[i][0] == BAD)
            continue;
        b->sorted[b->good] = key_of(form, b->cell[i]) << NUMBER_BITS | i;
        in_order = in_order && (!b->good || b->sorted[b->good] > b->sorted[b->good - 1]);
        b->good++;
    }
    const int bits = form->bits[0] + form->bits[1] + form->bits[2];
    for (int shift = 0; !in_order && shift < bits; shift += DIGIT_BITS)
        sort_digit(b, shift + NUMBER_BITS);
}

// ---- runs ---------------------------------------------------------------------------------------

static void widen_run(struct weft_point_run *run, const struct weft_point_place *place)
{
    for (int a = 0; a < 3; a++) {
        const uint8_t at = (uint8_t)(place->word[a] >> WEFT_LINE_FRACTION);
        run->low[a] = at < run->low[a] ? at : run->low[a];
        run->high[a] = at > run->high[a] ? at : run->high[a];
    }
}

// Points of one cell from `first` on. Equal keys are equal cells, unless keys are coarse.
static uint32_t run_length(const struct weft_point_batch *b, size_t first, bool coarse)
{
    const uint64_t key = b->sorted[first] >> NUMBER_BITS;
    const int32_t *cell = b->cell[weft_point_number(b->sorted[first])];
    size_t end = first + 1;
    while (end < b->good && b->sorted[end] >> NUMBER_BITS == key &&
           (!coarse ||
            memcmp(cell, b->cell[weft_point_number(b->sorted[end])], sizeof b->cell[0]) == 0))
        end++;
    return (uint32_t)(end - first);
}

static void find_runs(struct weft_point_batch *b, bool coarse)
{
    b->run_count = 0;
    for (size_t first = 0; first < b->good; first += b->run[b->run_count++].count) {
        struct weft_point_run *run = &b->run[b->run_count];
        *run = (struct weft_point_run){
            .first = (uint32_t)first, .count = run_length(b, first, coarse), .high = {7, 7, 7}};
        memcpy(run->cell, b->cell[weft_point_number(b->sorted[first])], sizeof run->cell);
        if (run->count >= DENSE)
            continue;
        memset(run->low, 7, sizeof run->low);
        memset(run->high, 0, sizeof run->high);
        for (uint32_t i = 0; i < run->count; i++)
            widen_run(run, &b->place[weft_point_number(b->sorted[first + i])]);
    }
}

void weft_point_run_box(const weft_points *p, const struct weft_point_run *run, int32_t min[3],
                        int32_t max[3])
{
    for (int a = 0; a < 3; a++) {
        const int32_t first = run->cell[a] * WEFT_BRICK_SIZE - p->tap_offset;
        min[a] = first + run->low[a];
        max[a] = first + run->high[a] + p->info.kernel.width - 1;
    }
}

void weft_point_batch_sort(const weft_points *points, const struct weft_points_run_params *params,
                           struct weft_point_batch *batch, struct weft_points_report *report)
{
    struct chunk chunks[WEFT_POINTS_BATCH / CHUNK];
    const size_t count = (batch->count + CHUNK - 1) / CHUNK;
    struct rounding rounding = {points, params, batch, chunks};
    weft_threads_run(points->info.cpu.threads, count, round_chunk, &rounding);
    const struct chunk all = join_chunks(chunks, count);
    report->bad_positions += all.bad;
    report->outside += all.outside;
    batch->good = batch->run_count = 0;
    if (all.bad == batch->count)
        return;
    const struct key_form form = form_of(&all);
    sort_points(batch, &form);
    find_runs(batch, form.coarse > 0);
}
