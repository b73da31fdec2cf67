// SPDX-License-Identifier: BSD-3-Clause
// Warps on the CPU: tiles of pixels by threads.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/warp/careful.h"
#include "passes/warp/cpu.h"

struct weft_warp_cpu {
    const struct weft_warp_plan *plan;
    struct weft_cpu cpu;
    const struct weft_warp_lines *lines;
    struct weft_warp_taps taps;
};

// ---- compile ------------------------------------------------------------------------------------

static const struct weft_warp_lines *find_lines(enum weft_instruction_set set, enum weft_sums sums)
{
#ifdef __x86_64__
    switch (set) {
    case WEFT_INSTRUCTIONS_SSE2:
        return weft_warp_lines_sse2(sums);
    case WEFT_INSTRUCTIONS_AVX2:
        return weft_warp_lines_avx2(sums);
    case WEFT_INSTRUCTIONS_AVX512:
        return weft_warp_lines_avx512(sums);
    default:
        break;
    }
#endif
    (void)set;
    return weft_warp_lines_plain(sums);
}

static enum weft_result copy_coefficients(struct weft_warp_cpu *c)
{
    const struct weft_polynomial_tiles *tiles = &c->plan->weights->tiles;
    const bool single = c->lines->bytes == sizeof(float);
    c->taps = (struct weft_warp_taps){.width = tiles->width,
                                      .degree = tiles->degree,
                                      .segments = tiles->segments,
                                      .lanes = tiles->width <= 4   ? 4
                                               : tiles->width <= 8 ? 8
                                                                   : 16};
    const size_t powers = (size_t)tiles->segments * (size_t)(tiles->degree + 1);
    const size_t lanes = (size_t)c->taps.lanes, stride = 4 * (size_t)tiles->groups;
    void *out = calloc(powers * lanes, c->lines->bytes);
    if (!out) {
        weft_error(c->plan->log, "out of memory for %zu coefficients", powers * lanes);
        return WEFT_ERR_MEMORY;
    }
    for (size_t p = 0; p < powers; p++)
        for (size_t k = 0; k < (size_t)tiles->width; k++) {
            if (single)
                ((float *)out)[p * lanes + k] = tiles->coefficients[p * stride + k];
            else
                ((double *)out)[p * lanes + k] = tiles->precise[p * stride + k];
        }
    c->taps.coefficients = out;
    return WEFT_OK;
}

enum weft_result weft_warp_cpu_compile(const struct weft_warp_plan *plan,
                                       const struct weft_cpu *cpu, struct weft_warp_cpu **out)
{
    struct weft_cpu resolved;
    *out = NULL;
    enum weft_result res = weft_cpu_resolve(plan->log, cpu, &resolved);
    if (res != WEFT_OK)
        return res;
    struct weft_warp_cpu *c = calloc(1, sizeof *c);
    if (!c) {
        weft_error(plan->log, "out of memory for a compiled warp");
        return WEFT_ERR_MEMORY;
    }
    *c = (struct weft_warp_cpu){
        .plan = plan, .cpu = resolved, .lines = find_lines(resolved.instructions, plan->info.sums)};
    res = copy_coefficients(c);
    if (res == WEFT_OK)
        *out = c;
    else
        weft_warp_cpu_destroy(&c);
    return res;
}

void weft_warp_cpu_destroy(struct weft_warp_cpu **compiled)
{
    if (!*compiled)
        return;
    free((void *)(*compiled)->taps.coefficients);
    free(*compiled);
    *compiled = NULL;
}

// ---- a thread -----------------------------------------------------------------------------------

struct thread {
    struct weft_warp_scratch scratch;
    void *numbers[2]; // the weights of a pixel, along x padded to whole vectors
    struct weft_statistics pixels;
};

struct runner {
    const struct weft_warp_cpu *c;
    const struct weft_warp_plan *plan;
    const struct weft_warp_run_params *params;
    int channels;
    struct weft_warp_values values[WEFT_RESAMPLE_MAX_CHANNELS];
    bool plain;
    int columns, rows; // of tiles
    struct thread *threads;
    bool cancelled;
};

static int whole_vectors(int taps)
{
    return (taps + WEFT_WARP_LANES - 1) / WEFT_WARP_LANES * WEFT_WARP_LANES;
}

static enum weft_result create_threads(struct runner *r)
{
    const struct weft_warp_plan *plan = r->plan;
    const size_t bytes = r->c->lines->bytes;
    r->threads = calloc((size_t)r->c->cpu.threads, sizeof *r->threads);
    bool whole = r->threads != NULL;
    for (int i = 0; whole && i < r->c->cpu.threads; i++) {
        struct thread *t = &r->threads[i];
        t->pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
        const enum weft_result res = weft_warp_scratch_create(plan, &t->scratch);
        if (res != WEFT_OK)
            return res;
        for (int a = 0; whole && a < 2; a++) {
            t->numbers[a] = calloc((size_t)whole_vectors(plan->info.taps[a]), bytes);
            whole = t->numbers[a] != NULL;
        }
    }
    if (whole)
        return WEFT_OK;
    weft_error(r->params->log, "out of memory for %d threads of a warp", r->c->cpu.threads);
    return WEFT_ERR_MEMORY;
}

static void destroy_threads(struct runner *r)
{
    for (int i = 0; r->threads && i < r->c->cpu.threads; i++) {
        weft_warp_scratch_destroy(&r->threads[i].scratch);
        free(r->threads[i].numbers[0]);
        free(r->threads[i].numbers[1]);
    }
    free(r->threads);
}

// ---- rows of pixels -----------------------------------------------------------------------------

// Pixels that are samples, whatever those are.
static void move(const struct runner *r, const struct weft_warp_row *row, int count,
                 float *const *out)
{
    for (int i = 0; i < count; i++) {
        const struct weft_warp_values *v = r->values;
        const int64_t x = weft_boundary_index(v->boundary, row->first[0][i], v->size[0]);
        const int64_t y = weft_boundary_index(v->boundary, row->first[1][i], v->size[1]);
        for (int c = 0; c < r->channels; c++)
            out[c][i] = x < 0 || y < 0 ? v->border : r->values[c].plane[y * v->stride + x];
    }
}

static void filter_plainly(const struct runner *r, struct thread *t,
                           const struct weft_warp_row *row, int count, float *const *out)
{
    const struct weft_warp_taps *taps = &r->c->taps;
    struct weft_warp_line line = {.taps = taps,
                                  .count = count,
                                  .channels = r->channels,
                                  .size = {r->plan->values[0], r->plan->values[1]},
                                  .row = row};
    for (int c = 0; c < r->channels; c++) {
        line.values[c] = r->values[c].plane;
        line.out[c] = out[c];
    }
    if (r->plain)
        r->c->lines->line(&line);
    for (int i = 0; i < count; i++) {
        if (r->plain && weft_warp_is_inside(row->first[0][i], row->first[1][i], taps->lanes,
                                            taps->width, line.size))
            continue;
        weft_warp_scratch_set(&t->scratch, row, i);
        for (int c = 0; c < r->channels; c++)
            out[c][i] = weft_warp_careful(&t->scratch, &r->values[c]);
    }
}

static void copy_weights(const struct runner *r, struct thread *t, int columns)
{
    for (int a = 0; a < 2; a++) {
        const int count = t->scratch.count[a], end = a == 0 ? columns : count;
        for (int k = 0; k < end; k++) {
            const double weight = k < count ? t->scratch.weights[a][k] : 0.0;
            if (r->c->lines->bytes == sizeof(float))
                ((float *)t->numbers[a])[k] = (float)weight;
            else
                ((double *)t->numbers[a])[k] = weight;
        }
    }
}

static void filter_stretched(const struct runner *r, struct thread *t,
                             const struct weft_warp_row *row, int i, float *const *out)
{
    weft_warp_scratch_set(&t->scratch, row, i);
    const struct weft_warp_scratch *s = &t->scratch;
    const int columns = whole_vectors(s->count[0]);
    if (!r->plain ||
        !weft_warp_is_inside(s->first[0], s->first[1], columns, s->count[1], r->plan->values)) {
        for (int c = 0; c < r->channels; c++)
            out[c][i] = weft_warp_careful(&t->scratch, &r->values[c]);
        return;
    }
    copy_weights(r, t, columns);
    struct weft_warp_box box = {.channels = r->channels,
                                .columns = columns,
                                .rows = s->count[1],
                                .pitch = r->plan->values[0],
                                .start = (int64_t)s->first[1] * r->plan->values[0] + s->first[0],
                                .weights = {t->numbers[0], t->numbers[1]}};
    for (int c = 0; c < r->channels; c++) {
        box.values[c] = r->values[c].plane;
        box.out[c] = out[c] + i;
    }
    r->c->lines->box(&box);
}

static void make_row(const struct runner *r, struct thread *t, int x, int y, int count)
{
    const struct weft_rectangle *part = &r->params->part;
    struct weft_warp_row row;
    float *out[WEFT_RESAMPLE_MAX_CHANNELS];
    for (int c = 0; c < r->channels; c++)
        out[c] = r->params->plane[c] + (y - part->y) * r->params->stride + (x - part->x);
    weft_warp_row_set(r->plan, x, y, count, &row);
    if (r->plan->info.moves)
        move(r, &row, count, out);
    else if (!r->plan->stretches)
        filter_plainly(r, t, &row, count, out);
    for (int i = 0; r->plan->stretches && i < count; i++)
        filter_stretched(r, t, &row, i, out);
    for (int c = 0; c < r->channels; c++) {
        if (r->plan->info.clamp)
            weft_warp_clamp(r->plan, r->params->source, c, &row, count, out[c]);
        weft_statistics_add(&t->pixels, out[c], (size_t)count);
    }
}

// ---- tiles --------------------------------------------------------------------------------------

// Tiles are squares of a row's pixels: what they read is near together, however the map turns.
enum { SIDE = WEFT_WARP_ROW };

static bool make_tile(void *priv, int thread, size_t number)
{
    struct runner *r = priv;
    const struct weft_rectangle *part = &r->params->part;
    const int x = part->x + (int)(number % (size_t)r->columns) * SIDE;
    const int y = part->y + (int)(number / (size_t)r->columns) * SIDE;
    const int end_x = x + SIDE < part->x + part->width ? x + SIDE : part->x + part->width;
    const int end_y = y + SIDE < part->y + part->height ? y + SIDE : part->y + part->height;
    if (thread == 0 &&
        !weft_warp_go_on(r->params->progress, (double)number / ((double)r->columns * r->rows))) {
        r->cancelled = true;
        return false;
    }
    for (int row = y; row < end_y; row++)
        make_row(r, &r->threads[thread], x, row, end_x - x);
    return true;
}

static void set_report(const struct runner *r, double start, struct weft_resample_report *report)
{
    report->pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    for (int i = 0; i < r->c->cpu.threads; i++)
        weft_statistics_join(&report->pixels, &r->threads[i].pixels);
    report->work = (struct weft_resample_work){.tiles = r->columns * r->rows,
                                               .pass_seconds = weft_now_seconds() - start,
                                               .cpu = r->c->cpu};
}

enum weft_result weft_warp_cpu_run(struct weft_warp_cpu *compiled,
                                   const struct weft_warp_run_params *params,
                                   struct weft_resample_report *report)
{
    struct runner r = {.c = compiled,
                       .plan = compiled->plan,
                       .params = params,
                       .channels = params->source->info.channels,
                       .plain = weft_warp_is_plain(compiled->plan, params->source),
                       .columns = (params->part.width + SIDE - 1) / SIDE,
                       .rows = (params->part.height + SIDE - 1) / SIDE};
    const double start = weft_now_seconds();
    for (int c = 0; c < r.channels; c++)
        r.values[c] = weft_warp_values(compiled->plan, params->source, c);
    enum weft_result res = create_threads(&r);
    if (res == WEFT_OK &&
        !weft_threads_run(compiled->cpu.threads, (size_t)r.columns * (size_t)r.rows, make_tile, &r))
        res = WEFT_ERR_CANCELLED;
    if (res == WEFT_OK) {
        weft_warp_go_on(params->progress, 1.0);
        set_report(&r, start, report);
    }
    destroy_threads(&r);
    return res;
}
