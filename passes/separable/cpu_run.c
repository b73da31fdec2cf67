// SPDX-License-Identifier: BSD-3-Clause
// Compiled plans run on the CPU, part by part.
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/separable/cpu.h"

enum { MAX_LANES = 16 };

struct runner {
    struct weft_separable_cpu *c;
    const struct weft_separable_run_params *params;
    struct weft_separable_care care;
    void *border;                      // as a row of samples, of the boundary of that name
    int first_strip, bands, band_rows; // of the part of the pixels that is made
    size_t parts;
    bool cancelled;
};

// Those taps of a row of pixels that count, and their weights; for the rows' samples there is room.
struct taps {
    int count;
    const void **row, **at; // y first: where each begins, and where a span of it does
    void *weight, *all;     // numbers; all: of taps that do not count, too
    int32_t *tap;           // among those of all rows
};

// A strip by a band, and the memory of the thread that filters it.
struct part {
    const struct runner *r;
    const struct weft_separable_cpu *c;
    const struct weft_separable_strip *strip;
    // Columns that are made, and the one that filtering along x begins with: a whole number of
    // vectors from the strip's first.
    int from, columns, start;
    int taps[2];       // those columns': the first, and past the last, among the strip's
    int width, height; // of the kernel along x and along y
    char *lines, *rows, *out;
    struct taps row_taps;
    double *room;        // for a position's weights
    const char *weights; // of the strip's columns
    size_t row_bytes;    // from row to row of `rows` and `out`
    int32_t *block_in;   // x first: which interleaved rows are kept in each place; -1: none
    struct weft_statistics *pixels;
};

// ---- rows of samples ----------------------------------------------------------------------------

// Where the window's row of samples begins that a tap of rows is. Blocks have rows that no pixel of
// a part needs, and that are not there.
static const void *sample_row(const struct part *p, int tap)
{
    const struct weft_separable_run_params *params = p->r->params;
    const struct weft_rectangle *w = &params->window;
    const int wanted = p->c->row_sample[tap], last = w->y + w->height - 1;
    if (wanted < 0)
        return p->r->border;
    const int row = wanted < w->y ? w->y : wanted > last ? last : wanted;
    const size_t at = weft_separable_sample(params, w->x, row);
    return params->wide ? (const void *)(params->wide + at) : params->samples + at;
}

// What the columns need of the strip's span number i; false: nothing. *from: what is read of the
// rows for it, in order, whose samples are counted from the window's first, and of the border from
// 0.
static bool clip_span(const struct part *p, size_t i, struct weft_separable_span *out,
                      struct weft_separable_span *from)
{
    const struct weft_separable_span *span = &p->c->spans[p->strip->spans + i];
    const int first = span->at < p->taps[0] ? p->taps[0] : span->at;
    const int end = span->at + span->count < p->taps[1] ? span->at + span->count : p->taps[1];
    const int count = end - first, sample = span->sample + span->step * (first - span->at);
    const int low = span->step < 0 ? sample - (count - 1) : sample;
    *out = (struct weft_separable_span){first, sample, count, span->step};
    *from = (struct weft_separable_span){.at = first,
                                         .sample = low < 0 ? 0 : low - p->r->params->window.x,
                                         .count = span->step ? count : 1,
                                         .step = 1};
    return count > 0;
}

// Repeats or turns round what was made of a span's samples, `bytes` for each.
static void spread_span(const struct weft_separable_span *span, char *made, size_t bytes)
{
    char *at = made + (size_t)span->at * bytes, held[MAX_LANES * sizeof(double)];
    for (size_t i = 1; span->step == 0 && i < (size_t)span->count; i++)
        memcpy(at + i * bytes, at, bytes);
    for (size_t i = 0, k = (size_t)span->count - 1; span->step < 0 && i < k; i++, k--) {
        memcpy(held, at + i * bytes, bytes);
        memcpy(at + i * bytes, at + k * bytes, bytes);
        memcpy(at + k * bytes, held, bytes);
    }
}

// Whose samples are the border's value in every row.
static bool is_border(const struct part *p, size_t i)
{
    return p->c->spans[p->strip->spans + i].sample < 0;
}

static bool are_floats(const struct part *p)
{
    return !p->r->params->wide;
}

static void run_across(const struct part *p, void *out)
{
    p->c->lines->across(&(struct weft_separable_across){
        .lines = p->lines,
        .weights = p->weights,
        .first = p->c->first[0] + p->start,
        .columns = p->from + p->columns - p->start,
        .taps = p->width,
        .skips_zeros = p->r->care.skips_zeros,
        .out = out,
        .pitch = p->row_bytes / p->c->lines->bytes,
    });
}

// Filters the rows of samples of a block of taps along x.
static void make_block(struct part *p, int block)
{
    const struct weft_separable_cpu *c = p->c;
    const int lanes = c->lines->lanes, slot = block % c->kept_blocks;
    const void *rows[MAX_LANES], *border[MAX_LANES];
    for (int l = 0; l < lanes; l++) {
        const int tap = block * lanes + l;
        rows[l] = sample_row(p, tap < c->row_taps ? tap : c->row_taps - 1);
        border[l] = p->r->border;
    }
    struct weft_separable_span span, from;
    for (size_t i = 0; i < p->strip->span_count; i++) {
        if (!clip_span(p, i, &span, &from))
            continue;
        c->lines->gather(is_border(p, i) ? border : rows, are_floats(p), &from,
                         ldexp(1.0, -p->r->care.scale_bits), p->lines);
        spread_span(&span, p->lines, (size_t)lanes * c->lines->bytes);
    }
    run_across(p, p->rows + (size_t)(slot * lanes) * p->row_bytes);
    p->block_in[slot] = block;
}

// Bytes from where filtering along x begins to the columns that are made.
static size_t lead_bytes(const struct part *p)
{
    return (size_t)(p->from - p->start) * p->c->lines->bytes;
}

// A filtered row of samples, of the columns that are made.
static const void *row_of(struct part *p, int tap)
{
    const int lanes = p->c->lines->lanes, block = tap / lanes, slot = block % p->c->kept_blocks;
    if (p->block_in[slot] != block)
        make_block(p, block);
    return p->rows + (size_t)(slot * lanes + tap % lanes) * p->row_bytes + lead_bytes(p);
}

// ---- weights of a row ---------------------------------------------------------------------------

static double number_at(const struct part *p, const void *numbers, int i)
{
    return p->c->lines->bytes == sizeof(double) ? ((const double *)numbers)[i]
                                                : (double)((const float *)numbers)[i];
}

static void set_number(const struct part *p, void *numbers, int i, double number)
{
    if (p->c->lines->bytes == sizeof(double))
        ((double *)numbers)[i] = number;
    else
        ((float *)numbers)[i] = (float)number;
}

static void find_taps(struct part *p, int y, double factor)
{
    const struct weft_separable_cpu *c = p->c;
    struct taps *out = &p->row_taps;
    const void *weights = out->all;
    if (c->weights[1])
        weights = (const char *)c->weights[1] + (size_t)y * (size_t)p->height * c->lines->bytes;
    else
        weft_separable_cpu_weights(c, 1, y, 1, p->room, out->all);
    out->count = 0;
    for (int t = 0; t < p->height; t++) {
        const double weight = number_at(p, weights, t);
        if (weight == 0.0)
            continue;
        out->tap[out->count] = c->first[1][y] + t;
        set_number(p, out->weight, out->count++, weight * factor);
    }
}

// ---- rows of pixels -----------------------------------------------------------------------------

static void measure(const struct part *p, const float *row, int count)
{
    float minimum, maximum;
    if (!p->c->lines->measure(row, count, &minimum, &maximum)) {
        weft_statistics_add(p->pixels, row, (size_t)count);
        return;
    }
    p->pixels->minimum = fmin(p->pixels->minimum, (double)minimum);
    p->pixels->maximum = fmax(p->pixels->maximum, (double)maximum);
    p->pixels->count += (uint64_t)count;
}

// Puts a row of sums where it belongs.
static void finish(const struct part *p, int y, const void *numbers)
{
    const struct runner *r = p->r;
    const int from[2] = {p->from, y}, size[2] = {p->columns, 1};
    float *row = weft_separable_pixel(r->params, p->from, y);
    if (numbers != row)
        p->c->lines->narrow(numbers, size[0], row);
    weft_separable_finish(&r->care, p->c->plan, r->params, from, size);
    measure(p, row, size[0]);
}

// Along x, and then along y.
static void run_x_first(struct part *p, int from, int to)
{
    const struct taps *taps = &p->row_taps;
    for (int y = from; y < to; y++) {
        find_taps(p, y, 1.0);
        for (int t = 0; t < taps->count; t++)
            taps->row[t] = row_of(p, taps->tap[t]);
        void *out = p->c->lines->bytes == sizeof(float)
                        ? (void *)weft_separable_pixel(p->r->params, p->from, y)
                        : p->out;
        p->c->lines->along(taps->row, false, taps->weight, taps->count, p->columns, out);
        finish(p, y, out);
    }
}

// A row of pixels filtered along y, of all taps of the columns.
static void make_middle(struct part *p, int y, char *out)
{
    const struct weft_separable_cpu *c = p->c;
    const size_t sample = are_floats(p) ? sizeof(float) : sizeof(double);
    const struct taps *taps = &p->row_taps;
    find_taps(p, y, ldexp(1.0, -p->r->care.scale_bits));
    for (int t = 0; t < taps->count; t++)
        taps->row[t] = sample_row(p, taps->tap[t]);
    for (size_t i = 0; i < p->strip->span_count; i++) {
        struct weft_separable_span span, from;
        if (!clip_span(p, i, &span, &from))
            continue;
        for (int t = 0; t < taps->count; t++) {
            const char *row = is_border(p, i) ? p->r->border : taps->row[t];
            taps->at[t] = row + (size_t)from.sample * sample;
        }
        c->lines->along(taps->at, are_floats(p), taps->weight, taps->count, from.count,
                        out + (size_t)span.at * c->lines->bytes);
        spread_span(&span, out, c->lines->bytes);
    }
}

// Along y, and then along x: as many rows at once as are interleaved.
static void run_y_first(struct part *p, int from, int to)
{
    const struct weft_separable_cpu *c = p->c;
    const int lanes = c->lines->lanes;
    const size_t middle_bytes = (size_t)p->strip->taps * c->lines->bytes;
    const struct weft_separable_span all = {p->taps[0], p->taps[0], p->taps[1] - p->taps[0], 1};
    const void *rows[MAX_LANES];
    for (int y = from; y < to; y += lanes) {
        const int count = to - y < lanes ? to - y : lanes;
        for (int l = 0; l < lanes; l++) {
            char *row = p->rows + (size_t)(l < count ? l : 0) * middle_bytes;
            if (l < count)
                make_middle(p, y + l, row);
            rows[l] = row;
        }
        c->lines->gather(rows, c->lines->bytes == sizeof(float), &all, 1.0, p->lines);
        run_across(p, p->out);
        for (int l = 0; l < count; l++)
            finish(p, y + l, p->out + (size_t)l * p->row_bytes + lead_bytes(p));
    }
}

// ---- parts --------------------------------------------------------------------------------------

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

// What the run's part has of a strip.
static void set_columns(struct part *p)
{
    const struct weft_rectangle *part = &p->r->params->part;
    const int lanes = p->c->lines->lanes, end = p->strip->from + p->strip->columns;
    const int32_t *first = p->c->first[0];
    p->from = larger(part->x, p->strip->from);
    p->columns = smaller(part->x + part->width, end) - p->from;
    p->start = p->from - (p->from - p->strip->from) % lanes;
    p->taps[0] = p->strip->taps;
    p->taps[1] = 0;
    for (int x = p->from; x < p->from + p->columns; x++) {
        p->taps[0] = smaller(p->taps[0], first[x]);
        p->taps[1] = larger(p->taps[1], first[x] + p->width);
    }
}

static void set_room(struct part *p, char *memory)
{
    const size_t taps = (size_t)p->height;
    char *at = memory + p->c->taps_at;
    p->row_taps.row = (const void **)at;
    p->row_taps.at = p->row_taps.row + taps;
    at += taps * 2 * sizeof(void *);
    p->row_taps.weight = at;
    p->row_taps.all = at + taps * sizeof(double);
    p->row_taps.tap = (int32_t *)(at + taps * 2 * sizeof(double));
    p->block_in = (int32_t *)(memory + p->c->blocks_at);
    p->room = (double *)(memory + p->c->room_at);
}

static void set_part(struct part *p, int thread)
{
    const struct weft_separable_cpu *c = p->c;
    const size_t lanes = (size_t)c->lines->lanes, one = (size_t)p->width * c->lines->bytes;
    char *memory = c->memory + (size_t)thread * c->thread_bytes;
    set_columns(p);
    const size_t columns = (size_t)(p->from + p->columns - p->start);
    p->lines = memory + c->lines_at;
    p->rows = memory + c->rows_at;
    p->out = memory + c->out_at;
    p->row_bytes = (columns + lanes - 1) / lanes * lanes * c->lines->bytes;
    p->weights = (const char *)c->weights[0] + (size_t)p->start * one;
    set_room(p, memory);
    if (!c->weights[0]) {
        weft_separable_cpu_weights(c, 0, p->start, (int)columns, p->room, memory + c->weights_at);
        p->weights = memory + c->weights_at;
    }
    for (int i = 0; i < c->kept_blocks; i++)
        p->block_in[i] = -1;
}

static bool run_part(void *priv, int thread, size_t i)
{
    struct runner *r = priv;
    const struct weft_separable_cpu *c = r->c;
    const size_t bands = (size_t)r->bands;
    if (thread == 0 && !weft_separable_go_on(r->params->progress, (double)i / (double)r->parts)) {
        r->cancelled = true;
        return false;
    }
    struct part p = {.r = r,
                     .c = c,
                     .strip = &c->strips[(size_t)r->first_strip + i / bands],
                     .width = c->plan->axis[0].width,
                     .height = c->plan->axis[1].width,
                     .pixels = &c->statistics[thread]};
    const int end = r->params->part.y + r->params->part.height;
    const int from = r->params->part.y + (int)(i % bands) * r->band_rows;
    const int to = end - from < r->band_rows ? end : from + r->band_rows;
    set_part(&p, thread);
    if (c->plan->info.first_axis == 0)
        run_x_first(&p, from, to);
    else
        run_y_first(&p, from, to);
    return true;
}

static void cut_part(struct runner *r)
{
    const struct weft_rectangle *part = &r->params->part;
    r->first_strip = part->x / r->c->columns;
    const int strips = (part->x + part->width - 1) / r->c->columns - r->first_strip + 1;
    r->band_rows = weft_separable_cpu_band(r->c, strips, part->height);
    r->bands = (part->height - 1) / r->band_rows + 1;
    r->parts = (size_t)r->bands * (size_t)strips;
}

// As long as a row of samples, and as all that a strip can have beyond them.
static enum weft_result make_border(struct runner *r)
{
    const struct weft_separable_run_params *p = r->params;
    const int taps = r->c->plan->axis[0].all_taps;
    const int count = p->window.width > taps ? p->window.width : taps;
    if (r->c->plan->info.boundary != WEFT_BOUNDARY_BORDER)
        return WEFT_OK;
    r->border = malloc((size_t)count * sizeof(double));
    for (int i = 0; r->border && i < count; i++) {
        if (p->wide)
            ((double *)r->border)[i] = p->border;
        else
            ((float *)r->border)[i] = (float)p->border;
    }
    if (r->border)
        return WEFT_OK;
    weft_error(p->log, "not enough memory for %d samples of the border", count);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_separable_cpu_run(struct weft_separable_cpu *c,
                                        const struct weft_separable_run_params *params,
                                        struct weft_separable_report *report)
{
    struct runner r = {.c = c, .params = params};
    const double start = weft_now_seconds();
    const enum weft_result res = make_border(&r);
    if (res != WEFT_OK)
        return res;
    r.care = weft_separable_take_care(c->plan, params);
    cut_part(&r);
    *report = (struct weft_separable_report){.peak_bytes = c->bytes,
                                             .rectangles = (int)r.parts,
                                             .cpu = c->cpu,
                                             .pixels = WEFT_STATISTICS_NONE};
    for (int i = 0; i < c->cpu.threads; i++)
        c->statistics[i] = report->pixels;
    report->prepare_seconds = weft_now_seconds() - start;
    weft_threads_run(c->cpu.threads, r.parts, run_part, &r);
    free(r.border);
    if (r.cancelled) {
        weft_note(params->log, "separable filtering was cancelled");
        return WEFT_ERR_CANCELLED;
    }
    for (int i = 0; i < c->cpu.threads; i++)
        weft_statistics_join(&report->pixels, &c->statistics[i]);
    report->pass_seconds = weft_now_seconds() - start - report->prepare_seconds;
    weft_separable_go_on(params->progress, 1.0);
    return WEFT_OK;
}
