// SPDX-License-Identifier: BSD-3-Clause
// How a plan is cut for threads and their caches, and its weights.
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_nd.h"
#include "passes/separable/cpu.h"

// What a thread has at hand is to stay near it, in its second-level cache and its share of the
// third: strips that are narrower write shorter pieces of rows, which costs more than it saves.
// Parts of fewer pixels than a thread is worth starting for are not made.
enum { CACHE_BYTES = 1 << 20, PART_PIXELS = 1 << 15, PARTS_PER_THREAD = 4, ALIGNMENT = 64 };

static size_t aligned(size_t bytes)
{
    return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static int round_up(int count, int to)
{
    return (count + to - 1) / to * to;
}

static int parts_of(int count, int most)
{
    return count / most + (count % most != 0);
}

// ---- the cut ------------------------------------------------------------------------------------

// Interleaved rows that taps next to each other can lie in.
static int blocks_of(const struct weft_separable_axis *y, int lanes)
{
    const int reached = (y->width - 2 + lanes) / lanes + 1, all = parts_of(y->all_taps, lanes);
    return reached < all ? reached : all;
}

// Lays a thread's memory out for strips of so many columns and different taps.
static void lay_out(struct weft_separable_cpu *c, int columns, int taps)
{
    const size_t lanes = (size_t)c->lines->lanes, number = c->lines->bytes;
    const size_t width = (size_t)c->plan->axis[0].width, height = (size_t)c->plan->axis[1].width;
    const size_t pitch = (size_t)round_up(columns, c->lines->lanes);
    const bool x_first = c->plan->info.first_axis == 0;
    const size_t rows = x_first ? (size_t)c->kept_blocks * lanes * pitch : lanes * (size_t)taps;
    const size_t out = x_first ? pitch : lanes * pitch;
    c->lines_at = 0;
    c->rows_at = aligned((size_t)taps * lanes * number);
    c->out_at = c->rows_at + aligned(rows * number);
    c->taps_at = c->out_at + aligned(out * number);
    c->blocks_at = c->taps_at + aligned(height * (2 * sizeof(void *) + 2 * sizeof(double) + 4));
    c->room_at = c->blocks_at + aligned((size_t)c->kept_blocks * sizeof(int32_t));
    c->weights_at = c->room_at + aligned((width > height ? width : height) * sizeof(double));
    c->thread_bytes = c->weights_at;
    if (!c->keeps_weights)
        c->thread_bytes += aligned(pitch * width * number);
}

static uint64_t kept_weight_bytes(const struct weft_separable_cpu *c)
{
    uint64_t weights = 0;
    for (int a = 0; a < 2; a++)
        weights += ((uint64_t)c->plan->axis[a].positions + 16) * (uint64_t)c->plan->axis[a].width;
    return weights * c->lines->bytes;
}

// Makes strips narrower until a thread's memory is what a cache holds, and then until all of it is
// within the limit: without weights that are kept, and at last with fewer threads.
static enum weft_result choose_columns(struct weft_separable_cpu *c,
                                       struct weft_separable_taps *taps)
{
    const struct weft_separable_axis *x = &c->plan->axis[0];
    const int lanes = c->lines->lanes;
    const uint64_t limit = c->plan->memory_bytes, kept = kept_weight_bytes(c);
    int most = x->all_taps;
    c->keeps_weights = kept <= limit / 2;
    for (c->columns = x->positions;;) {
        lay_out(c, c->columns, most);
        c->bytes =
            (uint64_t)c->thread_bytes * (uint64_t)c->cpu.threads + (c->keeps_weights ? kept : 0);
        const bool wide = c->thread_bytes > CACHE_BYTES && c->columns > 16 * lanes;
        if (c->bytes <= limit && !wide)
            return WEFT_OK;
        if (c->columns > lanes) {
            c->columns = round_up((c->columns + 1) / 2, lanes);
            most = weft_separable_most_taps(x, c->columns, taps);
        } else if (c->keeps_weights) {
            c->keeps_weights = false;
        } else if (c->cpu.threads > 1) {
            c->cpu.threads /= 2;
        } else {
            weft_error(
                c->plan->log,
                "separable filtering: %llu bytes for %d pixels with %d samples in reach, over "
                "the limit of %llu bytes",
                (unsigned long long)c->bytes, c->columns, most, (unsigned long long)limit);
            return WEFT_ERR_LIMIT;
        }
    }
}

int weft_separable_cpu_band(const struct weft_separable_cpu *c, int strips, int height)
{
    const int per_strip =
        parts_of((c->keeps_weights ? PARTS_PER_THREAD : 1) * c->cpu.threads, strips);
    const int least = parts_of(PART_PIXELS, c->columns), rows = parts_of(height, per_strip);
    return round_up(rows > least ? rows : least, c->lines->lanes);
}

// ---- taps ---------------------------------------------------------------------------------------

static enum weft_result out_of_memory(const struct weft_separable_cpu *c)
{
    weft_error(c->plan->log, "not enough memory to filter %d x %d pixels", c->plan->info.width,
               c->plan->info.height);
    return WEFT_ERR_MEMORY;
}

// Whether a tap's sample is a step from the one before, which those of the border's value are from
// no other.
static bool find_step(const struct weft_separable_taps *taps, int i, int32_t *step)
{
    const int32_t before = taps->sample[i - 1], sample = taps->sample[i];
    *step = sample - before;
    return (before < 0) == (sample < 0) && *step >= -1 && *step <= 1;
}

// Returns how many spans there are, and sets them where there is room.
static size_t set_spans(const struct weft_separable_taps *taps, struct weft_separable_span *room)
{
    struct weft_separable_span one = {.count = 0};
    size_t count = 0;
    for (int i = 0; i < taps->count; i++) {
        int32_t step;
        const bool steps = i > 0 && find_step(taps, i, &step);
        if (!steps || (one.count > 1 && step != one.step)) {
            one = (struct weft_separable_span){.at = i, .sample = taps->sample[i], .step = 1};
            count++;
        }
        if (one.count++ == 1)
            one.step = step;
        if (room)
            room[count - 1] = one;
    }
    return count;
}

// Numbers the taps of a strip, and adds their spans to those of the strips before.
static enum weft_result set_strip(struct weft_separable_cpu *c, int number, size_t *spans,
                                  struct weft_separable_taps *taps)
{
    const struct weft_separable_axis *x = &c->plan->axis[0];
    const int from = number * c->columns;
    const int left = x->positions - from, columns = left < c->columns ? left : c->columns;
    weft_separable_taps_number(x, from, from + columns, taps);
    const size_t count = set_spans(taps, NULL);
    struct weft_separable_span *grown = realloc(c->spans, (*spans + count) * sizeof *grown);
    if (!grown)
        return out_of_memory(c);
    c->spans = grown;
    set_spans(taps, c->spans + *spans);
    c->strips[number] = (struct weft_separable_strip){.from = from,
                                                      .columns = columns,
                                                      .taps = taps->count,
                                                      .spans = *spans,
                                                      .span_count = count};
    for (int i = from; i < from + columns; i++)
        c->first[0][i] = weft_separable_first_tap(x, taps, i);
    *spans += count;
    return WEFT_OK;
}

static enum weft_result set_strips(struct weft_separable_cpu *c, struct weft_separable_taps *taps)
{
    size_t spans = 0;
    enum weft_result res = WEFT_OK;
    c->strip_count = parts_of(c->plan->axis[0].positions, c->columns);
    c->strips = calloc((size_t)c->strip_count, sizeof *c->strips);
    // Whole vectors of the last strip's columns read this.
    c->first[0] = calloc((size_t)c->strip_count * (size_t)round_up(c->columns, c->lines->lanes),
                         sizeof *c->first[0]);
    if (!c->strips || !c->first[0])
        return out_of_memory(c);
    for (int i = 0; res == WEFT_OK && i < c->strip_count; i++)
        res = set_strip(c, i, &spans, taps);
    return res;
}

static enum weft_result set_rows(struct weft_separable_cpu *c)
{
    const struct weft_separable_axis *y = &c->plan->axis[1];
    struct weft_separable_taps taps;
    const enum weft_result res = weft_separable_taps_create(c->plan->log, y, &taps);
    if (res != WEFT_OK)
        return res;
    c->first[1] = malloc((size_t)y->positions * sizeof *c->first[1]);
    weft_separable_taps_number(y, 0, y->positions, &taps);
    for (int i = 0; c->first[1] && i < y->positions; i++)
        c->first[1][i] = weft_separable_first_tap(y, &taps, i);
    c->row_taps = taps.count;
    c->row_sample = taps.sample;
    free(taps.place);
    return c->first[1] ? WEFT_OK : out_of_memory(c);
}

// ---- weights ------------------------------------------------------------------------------------

void weft_separable_cpu_weights(const struct weft_separable_cpu *c, int axis, int from, int count,
                                double *room, void *out)
{
    const struct weft_separable_axis *of = &c->plan->axis[axis];
    const size_t width = (size_t)of->width;
    for (int i = 0; i < count; i++) {
        double *wide = (double *)out + (size_t)i * width;
        float *narrow = (float *)out + (size_t)i * width;
        weft_separable_weights(&c->plan->info.kernel, of, from + i, room);
        for (size_t t = 0; t < width; t++) {
            if (c->plan->info.sums == WEFT_SUMS_DOUBLE)
                wide[t] = room[t];
            else
                narrow[t] = weft_separable_single_weight(true, room[t]);
        }
    }
}

// Weights of columns past the last are read with whole vectors.
static enum weft_result keep_weights(struct weft_separable_cpu *c)
{
    for (int a = 0; a < 2; a++) {
        const struct weft_separable_axis *axis = &c->plan->axis[a];
        const size_t width = (size_t)axis->width;
        double *room = malloc(width * sizeof *room);
        c->weights[a] =
            calloc((size_t)round_up(axis->positions, c->lines->lanes), width * c->lines->bytes);
        if (room && c->weights[a])
            weft_separable_cpu_weights(c, a, 0, axis->positions, room, c->weights[a]);
        free(room);
        if (!room || !c->weights[a])
            return out_of_memory(c);
    }
    return WEFT_OK;
}

// ---- compiled plans -----------------------------------------------------------------------------

static const struct weft_separable_lines *lines_of(enum weft_instruction_set set,
                                                   enum weft_sums sums)
{
    switch (set) {
#ifdef __x86_64__
    case WEFT_INSTRUCTIONS_SSE2:
        return weft_separable_lines_sse2(sums);
    case WEFT_INSTRUCTIONS_AVX2:
        return weft_separable_lines_avx2(sums);
    case WEFT_INSTRUCTIONS_AVX512:
        return weft_separable_lines_avx512(sums);
#endif
    default:
        return weft_separable_lines_plain(sums);
    }
}

static enum weft_result cut(struct weft_separable_cpu *c)
{
    struct weft_separable_taps taps;
    enum weft_result res = weft_separable_taps_create(c->plan->log, &c->plan->axis[0], &taps);
    if (res != WEFT_OK)
        return res;
    res = choose_columns(c, &taps);
    if (res == WEFT_OK)
        res = set_strips(c, &taps);
    weft_separable_taps_destroy(&taps);
    return res == WEFT_OK ? set_rows(c) : res;
}

static enum weft_result create(struct weft_separable_cpu *c)
{
    enum weft_result res = cut(c);
    if (res == WEFT_OK && c->keeps_weights)
        res = keep_weights(c);
    if (res != WEFT_OK)
        return res;
    c->memory = aligned_alloc(ALIGNMENT, c->thread_bytes * (size_t)c->cpu.threads);
    c->statistics = malloc((size_t)c->cpu.threads * sizeof *c->statistics);
    if (!c->memory || !c->statistics)
        return out_of_memory(c);
    // Columns past the last are filtered with whole vectors, from what is here.
    memset(c->memory, 0, c->thread_bytes * (size_t)c->cpu.threads);
    return WEFT_OK;
}

enum weft_result weft_separable_cpu_compile(const weft_separable_plan *plan,
                                            const struct weft_cpu *resolved,
                                            struct weft_separable_cpu **out)
{
    *out = NULL;
    struct weft_separable_cpu *c = calloc(1, sizeof *c);
    if (!c) {
        weft_error(plan->log, "not enough memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    c->plan = plan;
    c->cpu = *resolved;
    c->lines = lines_of(resolved->instructions, plan->info.sums);
    c->kept_blocks = blocks_of(&plan->axis[1], c->lines->lanes);
    const enum weft_result res = create(c);
    if (res == WEFT_OK)
        *out = c;
    else
        weft_separable_cpu_destroy(&c);
    return res;
}

void weft_separable_cpu_destroy(struct weft_separable_cpu **compiled)
{
    struct weft_separable_cpu *c = *compiled;
    if (!c)
        return;
    free(c->strips);
    free(c->spans);
    free(c->row_sample);
    for (int a = 0; a < 2; a++) {
        free(c->first[a]);
        free(c->weights[a]);
    }
    free(c->statistics);
    free(c->memory);
    free(c);
    *compiled = NULL;
}
