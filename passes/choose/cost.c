// SPDX-License-Identifier: BSD-3-Clause
#include "passes/choose/cost.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

// ---- predictions --------------------------------------------------------------------------------

static bool is_known(const struct weft_work *w)
{
    if ((unsigned)w->engine > WEFT_ENGINE_CPU || (unsigned)w->sums > WEFT_SUMS_DOUBLE ||
        w->threads < 0)
        return false;
    if (w->engine == WEFT_ENGINE_CPU)
        return (unsigned)w->algorithm <= WEFT_ALGORITHM_SEPARABLE;
    switch (w->algorithm) {
    case WEFT_ALGORITHM_FUSED:
        return (unsigned)w->of.fused.layout <= WEFT_LAYOUT_PLAIN &&
               (unsigned)w->of.fused.source <= WEFT_SOURCE_UNORM8;
    case WEFT_ALGORITHM_HARDWARE:
        return (unsigned)w->of.hardware.source <= WEFT_SOURCE_UNORM8;
    case WEFT_ALGORITHM_SEPARABLE:
        return true;
    case WEFT_ALGORITHM_MULTIPASS:
        return (unsigned)w->of.passes.plan.target <= WEFT_TARGET_FLOAT;
    }
    return false;
}

static double fused_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_fused_work *w = &work->of.fused;
    const int layout = w->layout > WEFT_LAYOUT_AUTO ? (int)w->layout - 1 : 0;
    const double weights = w->weights_fetched ? m->weights_fetched : m->weights;
    return w->texels * m->texel[layout][w->source] +
           work->pixels * (m->entry + m->pixel + w->fetches * m->fetch[layout][w->source] +
                           w->weights * weights);
}

static double hardware_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_hardware_work *w = &work->of.hardware;
    const double weights = w->weights_fetched ? m->weights_fetched : m->weights;
    return w->texels * m->hardware_texel[w->source] +
           work->pixels * (m->entry + m->pixel + w->fetches * m->hardware_fetch[w->source] +
                           w->weights * weights);
}

static double separable_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_separable_work *w = &work->of.separable;
    return w->summed * m->summed + w->taps * m->tap + work->pixels * m->separable_pixel;
}

static double passes_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_pass_work *w = &work->of.passes.plan;
    const double octaves = fmax(0.0, log2(w->tile_bytes / WEFT_COST_NEAR_BYTES));
    const double fetch = m->pass_fetch[w->target][w->dot4] * (1.0 + m->pass_far * octaves);
    return work->of.passes.samples * m->pass_sample[w->target][w->dot4] +
           w->tile_bytes * m->tile_byte[w->target][w->dot4] +
           work->pixels * (m->pass_pixel + w->exact_weights * m->pass_weight +
                           w->passes * m->pass[w->target] + w->fetches * fetch);
}

static double gl_ns(const struct weft_cost_model *m, const struct weft_work *w)
{
    const double algorithm = w->algorithm == WEFT_ALGORITHM_FUSED       ? fused_ns(m, w)
                             : w->algorithm == WEFT_ALGORITHM_SEPARABLE ? separable_ns(m, w)
                             : w->algorithm == WEFT_ALGORITHM_HARDWARE  ? hardware_ns(m, w)
                                                                        : passes_ns(m, w);
    return m->start[w->algorithm] + algorithm;
}

// Between the widths that were measured; narrower and wider ones are as the nearest.
static double by_width(const double values[WEFT_COST_WIDTHS], int width)
{
    const double at = fmin(fmax(0.5 * width - 1.0, 0.0), WEFT_COST_WIDTHS - 1.0);
    const int below = at < WEFT_COST_WIDTHS - 2.0 ? (int)at : WEFT_COST_WIDTHS - 2;
    return values[below] + (at - below) * (values[below + 1] - values[below]);
}

static double cpu_fused_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_fused_cpu_work *w = &work->of.fused_cpu;
    const double longer = fmax(1.0, w->width / (2.0 * WEFT_COST_WIDTHS));
    const double row = longer * by_width(m->cpu_row[work->sums], w->width);
    return w->samples * m->cpu_sample[work->sums] +
           work->pixels * (m->cpu_pixel[work->sums] + w->rows * row);
}

static double cpu_separable_ns(const struct weft_cost_model *m, const struct weft_work *work)
{
    const struct weft_separable_work *w = &work->of.separable;
    return w->summed * m->cpu_summed[work->sums] +
           w->taps * by_width(m->cpu_separable_tap[work->sums], w->width);
}

static double cpu_ns(const struct weft_cost_model *m, const struct weft_work *w)
{
    const double slower = w->threads && m->threads ? (double)m->threads / w->threads : 1.0;
    return w->algorithm == WEFT_ALGORITHM_FUSED
               ? m->cpu_fused_start[w->sums] + slower * cpu_fused_ns(m, w)
               : m->cpu_separable_start[w->sums] + slower * cpu_separable_ns(m, w);
}

double weft_cost_of(const struct weft_cost_model *m, const struct weft_work *w)
{
    if (!is_known(w))
        return NAN;
    const double engine = w->engine == WEFT_ENGINE_CPU ? cpu_ns(m, w) : gl_ns(m, w);
    return 1e-9 * (m->voxel * w->voxels + engine);
}

// ---- text ---------------------------------------------------------------------------------------

enum { VERSION = 2 };

struct field {
    const char *name;
    size_t offset;
    int count;
};
#define FIELD(name, count)                                                                         \
    {                                                                                              \
#name, offsetof(struct weft_cost_model, name), count                                       \
    }

static const struct field fields[] = {
    FIELD(start, WEFT_COST_ALGORITHMS),
    FIELD(voxel, 1),
    FIELD(entry, 1),
    FIELD(pixel, 1),
    FIELD(weights, 1),
    FIELD(weights_fetched, 1),
    FIELD(fetch, WEFT_COST_LAYOUTS * 4),
    FIELD(texel, WEFT_COST_LAYOUTS * 4),
    FIELD(hardware_fetch, 4),
    FIELD(hardware_texel, 4),
    FIELD(summed, 1),
    FIELD(tap, 1),
    FIELD(separable_pixel, 1),
    FIELD(pass_pixel, 1),
    FIELD(pass_weight, 1),
    FIELD(pass_far, 1),
    FIELD(pass, WEFT_COST_TARGETS),
    FIELD(pass_fetch, WEFT_COST_TARGETS * 2),
    FIELD(pass_sample, WEFT_COST_TARGETS * 2),
    FIELD(tile_byte, WEFT_COST_TARGETS * 2),
    FIELD(cpu_fused_start, WEFT_COST_SUMS),
    FIELD(cpu_separable_start, WEFT_COST_SUMS),
    FIELD(cpu_sample, WEFT_COST_SUMS),
    FIELD(cpu_pixel, WEFT_COST_SUMS),
    FIELD(cpu_row, WEFT_COST_SUMS *WEFT_COST_WIDTHS),
    FIELD(cpu_summed, WEFT_COST_SUMS),
    FIELD(cpu_separable_tap, WEFT_COST_SUMS *WEFT_COST_WIDTHS),
};

static double *values_of(struct weft_cost_model *model, const struct field *field)
{
    return (double *)(void *)((char *)model + field->offset);
}

char *weft_cost_format(const struct weft_cost_model *model)
{
    struct weft_cost_model copy = *model;
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fprintf(out, "weft-cost %d\nrenderer %s\ncpu %s %d\n", VERSION, model->renderer,
            weft_name(weft_instruction_set_names, model->instructions), model->threads);
    for (size_t f = 0; f < WEFT_COUNT(fields); f++) {
        fprintf(out, "%s", fields[f].name);
        for (int i = 0; i < fields[f].count; i++)
            fprintf(out, " %.6g", values_of(&copy, &fields[f])[i]);
        fprintf(out, "\n");
    }
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

// Reads a field's numbers from a line behind its name.
static bool read_values(const char *at, const struct field *field, struct weft_cost_model *model)
{
    double *values = values_of(model, field);
    for (int i = 0; i < field->count; i++) {
        if (*at++ != ' ')
            return false;
        at = weft_number_parse(at, &values[i]);
        if (!at || !(values[i] >= 0.0 && values[i] <= 1e12))
            return false;
    }
    return *at == '\n' || *at == '\0';
}

static const struct field *find_field(const char *line)
{
    for (size_t f = 0; f < WEFT_COUNT(fields); f++) {
        const size_t length = strlen(fields[f].name);
        if (strncmp(line, fields[f].name, length) == 0 && line[length] == ' ')
            return &fields[f];
    }
    return NULL;
}

// Whether a line starts with a word and a blank; *text is then behind them.
static bool skip_word(const char **text, const char *word)
{
    const size_t length = strlen(word);
    if (strncmp(*text, word, length) != 0 || (*text)[length] != ' ')
        return false;
    *text += length + 1;
    return true;
}

// "INSTRUCTIONS THREADS", to the line's end.
static bool read_cpu(const char *at, struct weft_cost_model *model)
{
    double threads;
    int set = 0;
    while (weft_instruction_set_names[set] && !skip_word(&at, weft_instruction_set_names[set]))
        set++;
    const char *end = weft_instruction_set_names[set] ? weft_number_parse(at, &threads) : NULL;
    if (!end || *end != '\n' || !(threads >= 0.0 && threads <= WEFT_CPU_MAX_THREADS) ||
        threads != floor(threads))
        return false;
    model->instructions = (enum weft_instruction_set)set;
    model->threads = (int)threads;
    return true;
}

// The first three lines; *text is then at the third one's end.
static enum weft_result read_head(const struct weft_log *log, const char **text,
                                  struct weft_cost_model *out)
{
    const char *at = *text;
    double version;
    if (!skip_word(&at, "weft-cost") || !(at = weft_number_parse(at, &version)) || *at++ != '\n') {
        weft_error(log, "the cost model does not begin with \"weft-cost %d\"", VERSION);
        return WEFT_ERR_FORMAT;
    }
    if (version != VERSION) {
        weft_error(log, "the cost model is of another version of weft, weft-cost %g in place of %d",
                   version, VERSION);
        return WEFT_ERR_FORMAT;
    }
    if (!skip_word(&at, "renderer")) {
        weft_error(log, "the cost model names no renderer");
        return WEFT_ERR_FORMAT;
    }
    const size_t length = strcspn(at, "\n");
    snprintf(out->renderer, sizeof out->renderer, "%.*s", (int)(length < 127 ? length : 127), at);
    weft_text_clean(out->renderer, false);
    at += length + (at[length] != 0);
    if (!skip_word(&at, "cpu") || !read_cpu(at, out)) {
        weft_error(log, "the cost model names no instruction set and threads");
        return WEFT_ERR_FORMAT;
    }
    *text = at + strcspn(at, "\n");
    return WEFT_OK;
}

enum weft_result weft_cost_parse(const struct weft_log *log, const char *text,
                                 struct weft_cost_model *out)
{
    unsigned found = 0;
    int number = 3;
    *out = (struct weft_cost_model){0};
    const enum weft_result res = read_head(log, &text, out);
    if (res != WEFT_OK)
        return res;
    for (; *text == '\n' && text[1]; text += strcspn(text, "\n")) {
        const struct field *field = find_field(++text);
        number++;
        if (!field || !read_values(text + strlen(field->name), field, out)) {
            weft_error(log, "line %d of the cost model is none: %.*s", number,
                       (int)(strcspn(text, "\n") < 60 ? strcspn(text, "\n") : 60), text);
            return WEFT_ERR_FORMAT;
        }
        found |= 1u << (field - fields);
    }
    if (found == (1u << WEFT_COUNT(fields)) - 1)
        return WEFT_OK;
    weft_error(log, "the cost model lacks some of its %zu lines", WEFT_COUNT(fields) + 3);
    return WEFT_ERR_FORMAT;
}

// ---- defaults -----------------------------------------------------------------------------------

const struct weft_cost_model weft_cost_default = {
    .start = {6e4, 8e4, 7e4, 7e4},
    .voxel = 0.85,
    .entry = 7.5,
    .pixel = 11.0,
    .weights = 0.42,
    .weights_fetched = 1.0,
    .fetch = {{0.71, 0.92, 0.87, 0.66}, {0.86, 1.0, 1.1, 0.84}, {0.6, 0.65, 0.61, 0.77}},
    .texel = {{5.2, 6.0, 5.5, 5.7}, {8.0, 12.7, 9.5, 9.3}, {1.8, 3.5, 3.0, 2.9}},
    .hardware_fetch = {3.0, 3.0, 3.2, 4.6},
    .hardware_texel = {2.4, 3.0, 2.6, 2.0},
    .summed = 1.9,
    .tap = 0.39,
    .separable_pixel = 5.0,
    .pass_pixel = 50.0,
    .pass_weight = 64.0,
    .pass_far = 0.095,
    .pass = {2.2, 2.1, 2.2, 1.5},
    .pass_fetch = {{1.44, 1.88}, {1.35, 1.88}, {1.26, 1.82}, {1.29, 1.85}},
    .pass_sample = {{8.7, 18.3}, {8.8, 18.5}, {23.4, 35.3}, {8.4, 26.0}},
    .tile_byte = {{2.2, 2.1}, {1.05, 3.4}, {0.8, 1.6}, {0.6, 1.6}},
    .cpu_fused_start = {4e4, 4e4},
    .cpu_separable_start = {7e3, 7e3},
    .cpu_sample = {2.4, 2.5},
    .cpu_pixel = {3.2, 5.8},
    .cpu_row = {{0.05, 0.1, 0.28, 0.3}, {0.1, 0.3, 1.05, 1.1}},
    .cpu_summed = {1.0, 1.1},
    .cpu_separable_tap = {{0.6, 0.34, 0.42, 0.5}, {0.8, 0.45, 0.55, 0.65}},
};
