// SPDX-License-Identifier: BSD-3-Clause
// Which form the context has, how many of its samples a pass takes, and what they count.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/acaa_impl.h"
#include "passes/antialias/multisample.h"

// ---- form ---------------------------------------------------------------------------------------

static bool has_form(const GladGLContext *gl, const struct weft_acaa_params *p,
                     enum weft_acaa_form form)
{
    if (form == WEFT_ACAA_JITTER)
        return true;
    return (p->sums == WEFT_ACAA_FLOAT ? gl->VERSION_4_5 : gl->VERSION_4_2) &&
           (form != WEFT_ACAA_POST_DEPTH ||
            weft_drawing_has_extension(gl, "GL_ARB_post_depth_coverage"));
}

static enum weft_result choose_form(const struct weft_acaa_params *p, struct weft_acaa_plan *plan)
{
    static const char *const why[WEFT_ACAA_FORM_COUNT] = {
        [WEFT_ACAA_POST_DEPTH] = "the context has ARB_post_depth_coverage and image atomics",
        [WEFT_ACAA_SAMPLE_ID] = "the context has image atomics, but no ARB_post_depth_coverage",
        [WEFT_ACAA_JITTER] = "the context has no image atomics (GL 4.2; of floats 4.5)",
    };
    const GladGLContext *gl = &p->context->gl;
    const enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    enum weft_acaa_form form = p->form == WEFT_ACAA_AUTO ? WEFT_ACAA_POST_DEPTH : p->form;
    while (p->form == WEFT_ACAA_AUTO && !has_form(gl, p, form))
        form++;
    const bool has = has_form(gl, p, form);
    weft_context_leave(p->context);
    plan->form = form;
    plan->why = p->form == WEFT_ACAA_AUTO ? why[form] : "it was asked for";
    if (has)
        return WEFT_OK;
    weft_error(p->log, "acaa: form %s needs %s, which the context (%s) has not",
               weft_name(weft_acaa_form_names, form),
               p->sums == WEFT_ACAA_FLOAT     ? "GL 4.5 for sums of floats"
               : form == WEFT_ACAA_POST_DEPTH ? "GL 4.2 and ARB_post_depth_coverage"
                                              : "GL 4.2",
               p->context->info.version);
    return WEFT_ERR_UNSUPPORTED;
}

// ---- samples ------------------------------------------------------------------------------------

// The largest number of samples that the device has exactly, and that a pass can have so that all
// have as many.
static int find_device_samples(const struct weft_acaa_params *p, double position[][2])
{
    int samples = p->samples < WEFT_PATTERN_MAX_DEVICE ? p->samples : WEFT_PATTERN_MAX_DEVICE;
    while (samples > 0 && (p->samples % samples != 0 ||
                           weft_msaa_positions(p->context, samples, position) != samples))
        samples--;
    return samples;
}

static enum weft_result make_pattern(const struct weft_acaa_params *p, struct weft_acaa_plan *plan)
{
    double position[WEFT_PATTERN_MAX][2];
    const int device = find_device_samples(p, position);
    if (device == 0) {
        weft_error(p->log, "acaa: GL does not say where its samples are");
        return WEFT_ERR_GL;
    }
    return weft_pattern_create(weft_pattern_params(.device = (const double(*)[2])position,
                                                   .device_count = device, .count = p->samples,
                                                   .log = p->log),
                               &plan->pattern);
}

// ---- weights ------------------------------------------------------------------------------------

size_t weft_acaa_pass_rows(const struct weft_acaa_plan *plan)
{
    return (size_t)plan->side * (size_t)plan->side * (size_t)(plan->pattern.device_count + 1);
}

// The row of a pass for the pixel (x, y), y down the rows, from the target's own.
static int32_t *find_row(const struct weft_acaa_plan *plan, int pass, int x, int y)
{
    const int column = x + plan->radius, line = plan->radius + plan->wrap - y;
    return plan->table + (size_t)pass * weft_acaa_pass_rows(plan) +
           (size_t)(line * plan->side + column) * (size_t)(plan->pattern.device_count + 1);
}

// A sample's weights, which are those of the pixel that it lies in, seen from the one that is
// drawn.
static void fill_rows(struct weft_acaa_plan *plan, const struct weft_spread *spread, int sample)
{
    const struct weft_pattern *pattern = &plan->pattern;
    const int side = 2 * spread->radius + 1, i = sample % pattern->device_count;
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            const int32_t weight =
                spread->integer[(size_t)(y * side + x) * (size_t)spread->count + (size_t)sample];
            int32_t *row = find_row(plan, sample / pattern->device_count,
                                    x - spread->radius + pattern->pixel[sample][0],
                                    y - spread->radius + pattern->pixel[sample][1]);
            if (weight == 0)
                continue;
            row[0] |= (int32_t)(1u << i);
            row[1 + i] = weight;
            plan->box = plan->box && weight == 1;
            plan->magnitude += fabs((double)weight) / (double)plan->total;
            plan->entries++;
        }
}

static enum weft_result fill_table(const struct weft_acaa_params *p, struct weft_acaa_plan *plan,
                                   const struct weft_spread *spread)
{
    const struct weft_pattern *pattern = &plan->pattern;
    plan->radius = spread->radius;
    for (int i = 0; i < pattern->count; i++)
        if (pattern->pixel[i][0] || pattern->pixel[i][1])
            plan->wrap = 1;
    plan->side = 2 * plan->radius + 1 + plan->wrap;
    plan->rim = plan->radius + plan->wrap;
    plan->total = spread->total;
    plan->error = spread->error;
    plan->box = true;
    plan->table_size = (size_t)pattern->passes * weft_acaa_pass_rows(plan);
    plan->table = calloc(plan->table_size, sizeof *plan->table);
    if (!plan->table) {
        weft_error(p->log, "acaa: no memory for %zu weights", plan->table_size);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < pattern->count; i++)
        fill_rows(plan, spread, i);
    return WEFT_OK;
}

// Weights of kernels are integers of sum 2^24: rounding them changes the picture by less than
// colours of 16 bits show, and sums have 2^9 times the room that they need.
static enum weft_result make_weights(const struct weft_acaa_params *p, struct weft_acaa_plan *plan)
{
    enum { WEIGHT_BITS = 24 };
    struct weft_spread spread;
    enum weft_result res = weft_spread_create(
        weft_spread_params(.position = (const double(*)[2])plan->pattern.position,
                           .count = plan->pattern.count, .filter = p->filter,
                           .filter_width = p->filter_width, .bits = WEIGHT_BITS, .log = p->log),
        &spread);
    if (res != WEFT_OK)
        return res;
    if (spread.negative > 0.0 && p->coincident == WEFT_COINCIDENT_ALPHA) {
        weft_error(p->log, "acaa: weights below 0 cannot be cut off: coincident surfaces by alpha "
                           "need a kernel without such");
        res = WEFT_ERR_UNSUPPORTED;
    }
    if (res == WEFT_OK)
        res = fill_table(p, plan, &spread);
    weft_spread_clear(&spread);
    return res;
}

static struct weft_acaa_layers choose_layers(const struct weft_acaa_params *p,
                                             const struct weft_acaa_plan *plan)
{
    // 256 samples without a surface are below 2^9, and the rest holds them 2^15 times.
    enum { BACKGROUND_BITS = 9 };
    const bool box = plan->box;
    struct weft_acaa_layers l = {.sum_words = box || p->sums == WEFT_ACAA_FLOAT ? 1 : 2,
                                 .weight_words = box ? 1 : 2,
                                 .weight_shift = box ? BACKGROUND_BITS : 0};
    l.weight = 3 * l.sum_words;
    l.background = box ? l.weight : l.weight + l.weight_words;
    l.count = l.background + 1;
    return l;
}

enum weft_result weft_acaa_plan_make(const struct weft_acaa_params *params,
                                     struct weft_acaa_plan *out)
{
    *out = (struct weft_acaa_plan){0};
    enum weft_result res = choose_form(params, out);
    if (res == WEFT_OK)
        res = make_pattern(params, out);
    if (res != WEFT_OK || out->form == WEFT_ACAA_JITTER)
        return res;
    res = make_weights(params, out);
    if (res == WEFT_OK)
        out->layers = choose_layers(params, out);
    return res;
}

void weft_acaa_plan_clear(struct weft_acaa_plan *plan)
{
    free(plan->table);
    *plan = (struct weft_acaa_plan){0};
}
