// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/accumulative.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/acaa_impl.h"

// ---- parameters ---------------------------------------------------------------------------------

static bool check_params(const struct weft_acaa_params *p)
{
    if (p->width <= 0 || p->height <= 0) {
        weft_error(p->log, "acaa: a picture of %" PRId32 " x %" PRId32 " pixels", p->width,
                   p->height);
        return false;
    }
    if (!(p->range == 0.0 || (p->range >= 0x1p-60 && p->range <= 0x1p127))) {
        weft_error(p->log, "acaa: a range of %g; there are 2^-60 to 2^127, or 0", p->range);
        return false;
    }
    if (p->depth_bits != 0 && p->depth_bits != 24 && p->depth_bits != 32) {
        weft_error(p->log, "acaa: depths of %d bits; there are 24 and 32", p->depth_bits);
        return false;
    }
    for (int c = 0; c < 4; c++)
        if (!(fabs(p->background[c]) <= 0x1p127)) {
            weft_error(p->log, "acaa: channel %d of the background is %g", c, p->background[c]);
            return false;
        }
    return true;
}

static enum weft_result check(const struct weft_acaa_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->log, p->form, WEFT_ACAA_FORM_COUNT - 1);
    weft_require_enum(p->log, p->coincident, WEFT_COINCIDENT_COUNT - 1);
    weft_require_enum(p->log, p->sums, WEFT_ACAA_SUMS_COUNT - 1);
    weft_require(p->log, p->context);
    if (!check_params(p))
        goto fail;
    if (p->samples < 0 || p->samples > WEFT_PATTERN_MAX) {
        weft_error(p->log, "acaa: %d samples of a pixel; there are 1 to %d", p->samples,
                   WEFT_PATTERN_MAX);
        return p->samples < 0 ? WEFT_ERR_ARGUMENT : WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
fail:
    return res;
}

// The range that pictures start with holds the background, too.
static double first_range(const struct weft_acaa_params *p)
{
    double range = p->range > 0.0 ? p->range : 1.0;
    for (int c = 0; c < 4; c++)
        range = fmax(range, fabs(p->background[c]));
    return range;
}

// ---- the object ---------------------------------------------------------------------------------

static enum weft_result make_memory(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    size_t count;
    if (weft_size_mul((size_t)p->width, (size_t)p->height, &count) &&
        weft_size_mul(count, (size_t)a->plan.layers.count * sizeof *a->words, &count))
        a->words = malloc(count);
    if (a->words)
        a->head = weft_acaa_head_make(p, &a->plan);
    if (a->words && a->head)
        return WEFT_OK;
    weft_error(p->log, "acaa: no memory for sums of %" PRId32 " x %" PRId32 " pixels", p->width,
               p->height);
    return WEFT_ERR_MEMORY;
}

static enum weft_result make(struct weft_acaa *a)
{
    enum weft_result res = weft_acaa_plan_make(&a->params, &a->plan);
    if (res == WEFT_OK && a->plan.form == WEFT_ACAA_JITTER)
        return weft_acaa_jitter_create(a);
    if (res == WEFT_OK)
        res = make_memory(a);
    if (res == WEFT_OK)
        res = weft_context_enter(a->params.context);
    if (res != WEFT_OK)
        return res;
    res = weft_acaa_target_create(a);
    weft_context_leave(a->params.context);
    return res;
}

// What is known before a picture.
static void fill_report(struct weft_acaa *a)
{
    const struct weft_acaa_plan *plan = &a->plan;
    enum { WORD = sizeof(uint32_t) };
    const int words = plan->layers.count + (a->params.coincident == WEFT_COINCIDENT_MASK);
    const bool wide = a->params.depth_bits == 32 && a->params.coincident == WEFT_COINCIDENT_STENCIL;
    a->report = (struct weft_acaa_report){
        .form = plan->form,
        .why = plan->why,
        .samples = plan->pattern.count,
        .device_samples = plan->pattern.device_count,
        .passes = plan->pattern.passes,
        .discrepancy = plan->pattern.discrepancy,
        .radius = plan->radius,
        .formula_bytes =
            weft_bytes_accumulative(a->params.width, a->params.height, plan->pattern.device_count,
                                    words * WORD, wide ? 2 * WORD : WORD),
        .bytes = a->target.bytes,
    };
}

enum weft_result weft_acaa_create(const struct weft_acaa_params *params, weft_acaa **out)
{
    enum { SAMPLES = 4, DEPTH_BITS = 24 };
    *out = NULL;
    enum weft_result res = check(params);
    if (res != WEFT_OK)
        return res;
    weft_acaa *a = calloc(1, sizeof *a);
    if (!a) {
        weft_error(params->log, "acaa: no memory");
        return WEFT_ERR_MEMORY;
    }
    a->params = *params;
    a->params.samples = params->samples ? params->samples : SAMPLES;
    a->params.depth_bits = params->depth_bits ? params->depth_bits : DEPTH_BITS;
    res = make(a);
    if (res == WEFT_OK && !a->jitter && !weft_acaa_set_range(a, first_range(params), 1.0)) {
        weft_error(params->log, "acaa: sums cannot hold components of %g", first_range(params));
        res = WEFT_ERR_LIMIT;
    }
    if (res != WEFT_OK) {
        weft_acaa_destroy(&a);
        return res;
    }
    fill_report(a);
    if (a->jitter)
        weft_acaa_jitter_report(a, &a->report);
    *out = a;
    return WEFT_OK;
}

void weft_acaa_destroy(weft_acaa **acaa)
{
    if (!acaa || !*acaa)
        return;
    weft_acaa *a = *acaa;
    weft_supersample_destroy(&a->jitter);
    if (weft_context_enter(a->params.context) == WEFT_OK) {
        weft_acaa_target_destroy(a);
        weft_context_leave(a->params.context);
    }
    weft_acaa_plan_clear(&a->plan);
    free(a->head);
    free(a->words);
    free(a);
    *acaa = NULL;
}

// ---- pictures -----------------------------------------------------------------------------------

// The least power of two that is not below.
static double power_above(double value)
{
    int exponent;
    const double part = frexp(value, &exponent);
    return ldexp(1.0, part == 0.5 ? exponent - 1 : exponent);
}

static enum weft_result judge_floats(const struct weft_acaa *a, double weight)
{
    const double most = (double)a->plan.total * a->plan.magnitude * weight;
    if (a->largest * most <= (double)FLT_MAX)
        return WEFT_OK;
    weft_error(a->params.log, "acaa: floats cannot hold components of %g with weights of %g",
               a->largest, most);
    return WEFT_ERR_LIMIT;
}

// Whether the sums held what was drawn. *again: they do with the range that is set now.
static enum weft_result judge(struct weft_acaa *a, bool *again)
{
    const double weight = weft_acaa_check(a);
    *again = false;
    if (!isfinite(a->largest)) {
        weft_error(a->params.log, "acaa: colours are not finite");
        return WEFT_ERR_FORMAT;
    }
    if (a->params.sums == WEFT_ACAA_FLOAT)
        return judge_floats(a, weight);
    if (a->largest <= a->range && weight <= a->weight)
        return WEFT_OK;
    *again = true;
    const double range = a->largest > a->range ? power_above(a->largest) : a->range;
    if (weft_acaa_set_range(a, range, weight > a->weight ? power_above(weight) : a->weight))
        return WEFT_OK;
    weft_error(a->params.log, "acaa: sums cannot hold components of %g with %g times their weights",
               a->range, weight);
    return WEFT_ERR_LIMIT;
}

static enum weft_result draw(struct weft_acaa *a, const struct weft_antialias_drawing *drawing,
                             const struct weft_progress *progress)
{
    enum { MOST_REDONE = 2 };
    bool again = true;
    a->report.redone = -1;
    while (again) {
        enum weft_result res = weft_acaa_draw(a, drawing, progress);
        if (res == WEFT_OK)
            res = judge(a, &again);
        if (res != WEFT_OK)
            return res;
        if (++a->report.redone == MOST_REDONE && again) {
            weft_error(a->params.log,
                       "acaa: components of %g after those of before: the scene is another one "
                       "each time",
                       a->largest);
            return WEFT_ERR_LIMIT;
        }
    }
    return WEFT_OK;
}

// ---- room ---------------------------------------------------------------------------------------

static bool has_room(const weft_acaa *a)
{
    return !a->jitter && a->params.sums == WEFT_ACAA_INTEGER;
}

void weft_acaa_get_room(const weft_acaa *a, struct weft_acaa_room *out)
{
    *out = (struct weft_acaa_room){0};
    if (has_room(a))
        *out = (struct weft_acaa_room){a->range, a->weight};
}

enum weft_result weft_acaa_set_room(weft_acaa *a, const struct weft_acaa_room *room)
{
    const double range = a->range, weight = a->weight;
    if (!has_room(a))
        return WEFT_OK;
    if (!(room->range >= first_range(&a->params) && room->weight >= 1.0 && isfinite(room->range) &&
          isfinite(room->weight))) {
        weft_error(a->params.log, "acaa: room for components of %g with %g times their weights",
                   room->range, room->weight);
        return WEFT_ERR_ARGUMENT;
    }
    if (weft_acaa_set_range(a, room->range, room->weight))
        return WEFT_OK;
    weft_acaa_set_range(a, range, weight);
    weft_error(a->params.log, "acaa: sums cannot hold components of %g with %g times their weights",
               room->range, room->weight);
    return WEFT_ERR_LIMIT;
}

// ---- the last picture ---------------------------------------------------------------------------

// Of |picture - exact mean of the colours by weights of the filter|. A colour is rounded to an
// integer, off by half a unit at most, and so is their mean by weights, times the sum of the
// weights' magnitudes; weights are off by `error` in all, of colours up to the range; the float
// that is read is off by 2^-24 of itself, which the range bounds likewise. Floats are rounded where
// they are multiplied and at each addition, by 2^-24 of the sum so far.
static double find_bound(const struct weft_acaa *a)
{
    const struct weft_acaa_plan *plan = &a->plan;
    const double unit = 0x1p-24;
    double largest = a->range;
    if (a->params.sums != WEFT_ACAA_FLOAT)
        return plan->magnitude * ldexp(0.5, -a->scale_log2) + plan->error * largest +
               plan->magnitude * largest * unit;
    largest = a->largest;
    for (int c = 0; c < 3; c++)
        largest = fmax(largest, fabs(a->params.background[c]));
    const double rounded = (plan->entries + 2) * unit;
    return plan->magnitude * largest * rounded / (1.0 - rounded) + plan->error * largest;
}

static enum weft_result run(weft_acaa *a, const struct weft_antialias_drawing *drawing,
                            const struct weft_progress *progress)
{
    enum weft_result res = weft_context_enter(a->params.context);
    if (res != WEFT_OK)
        return res;
    res = draw(a, drawing, progress);
    a->params.context->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    weft_context_leave(a->params.context);
    a->report.range = a->range;
    a->report.scale = a->params.sums == WEFT_ACAA_FLOAT ? 0.0 : ldexp(1.0, a->scale_log2);
    a->report.bound = find_bound(a);
    return res;
}

enum weft_result weft_acaa_run(weft_acaa *a, const struct weft_antialias_drawing *drawing,
                               const struct weft_progress *progress)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    a->has_picture = false;
    a->reported = 0.0;
    weft_require(a->params.log, drawing && drawing->draw);
    res = weft_rectangle_within(a->params.log, &drawing->part, a->params.width, a->params.height,
                                &a->part);
    if (res != WEFT_OK)
        goto fail;
    res = a->jitter ? weft_acaa_jitter_run(a, drawing, progress) : run(a, drawing, progress);
    if (res == WEFT_OK && a->jitter)
        weft_acaa_jitter_report(a, &a->report);
    a->has_picture = res == WEFT_OK;
fail:
    return res;
}

static bool check_read(const weft_acaa *a, int channel, const float *out, size_t stride)
{
    enum { CHANNELS = 4 };
    if (a->has_picture && channel >= 0 && channel < CHANNELS && out &&
        (stride == 0 || stride >= (size_t)a->part.width))
        return true;
    weft_error(a->params.log, "acaa: channel %d, rows of %zu: %s", channel, stride,
               a->has_picture ? "there are channels 0 to 3, and rows are as wide as the picture"
                              : "there is no picture yet");
    return false;
}

enum weft_result weft_acaa_read(const weft_acaa *a, int channel, float *out, size_t stride)
{
    if (!check_read(a, channel, out, stride))
        return WEFT_ERR_ARGUMENT;
    if (a->jitter)
        return weft_supersample_read(a->jitter, channel, out, stride);
    if (stride == 0)
        stride = (size_t)a->part.width;
    for (int32_t y = 0; y < a->part.height; y++)
        weft_acaa_read_row(a, channel, y, out + (size_t)y * stride);
    return WEFT_OK;
}

enum weft_result weft_acaa_read_weight(const weft_acaa *a, float *out, size_t stride)
{
    if (!check_read(a, 0, out, stride))
        return WEFT_ERR_ARGUMENT;
    const size_t width = (size_t)a->part.width;
    for (size_t y = 0; y < (size_t)a->part.height; y++)
        for (size_t x = 0; x < width; x++)
            out[y * (stride ? stride : width) + x] =
                a->jitter ? 1.0f : weft_acaa_weight(a, y * width + x);
    return WEFT_OK;
}

void weft_acaa_get_report(const weft_acaa *a, struct weft_acaa_report *out)
{
    *out = a->report;
}
