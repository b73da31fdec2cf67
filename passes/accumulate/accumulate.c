// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/accumulate.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/frame.h"
#include "passes/accumulate/moments.h"

// ---- checks -------------------------------------------------------------------------------------

static bool is_bits(int bits)
{
    return bits == 8 || bits == 16 || bits == 32 || bits == WEFT_ACCUMULATE_HALF;
}

static enum weft_result check_params(const struct weft_accumulator_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->channel_count > 0);
    weft_require(p->log, p->channel_count <= WEFT_ACCUMULATE_MAX_CHANNELS);
    weft_require_enum(p->log, p->method, WEFT_ACCUMULATE_METHOD_COUNT - 1);
    weft_require_enum(p->log, p->nonfinite, WEFT_NONFINITE_COUNT - 1);
    weft_require_enum(p->log, p->rounding, WEFT_TREE_ROUNDING_COUNT - 1);
    weft_require(p->log, p->frame_count >= 0 && p->frame_count <= WEFT_ACCUMULATE_MAX_FRAMES);
    weft_require(p->log, !p->weight || p->frame_count > 0);
    weft_require(p->log, p->bits == 0 || is_bits(p->bits));
    weft_require(p->log, p->frame_bits == 0 || is_bits(p->frame_bits));
    weft_require(p->log, isfinite(p->low) && isfinite(p->high) && p->low <= p->high);
    weft_require(p->log, (p->low == 0.0 && p->high == 0.0) || p->low < p->high);
    weft_require(p->log, p->max_error >= 0.0 && isfinite(p->max_error));
    weft_require(p->log, p->batch >= 0);
    weft_require(p->log, (p->keep & ~(unsigned)(WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES)) == 0);
    res = WEFT_OK;
fail:
    return res;
}

static enum weft_result check_weight(const weft_accumulator *a, int64_t index, double weight)
{
    const struct weft_log *log = a->params.log;
    if (!isfinite(weight) || (weight < 0.0 && !a->way->negative)) {
        weft_error(log, "accumulate: frame %" PRId64 " has the weight %g: %s takes %s", index,
                   weight, weft_accumulate_method_names[a->way->method],
                   a->way->negative ? "finite ones" : "finite ones that are not negative");
        return WEFT_ERR_ARGUMENT;
    }
    if (fabs(ldexp(weight, a->weights.scale_log2)) > ldexp(1.0, WEFT_WEIGHT_LARGEST_LOG2)) {
        weft_error(log,
                   "accumulate: frame %" PRId64 " has the weight %g: those above %g have to be "
                   "announced",
                   index, weight, ldexp(1.0, WEFT_WEIGHT_LARGEST_LOG2 - a->weights.scale_log2));
        return WEFT_ERR_ARGUMENT;
    }
    if (a->weight && !a->params.part && index < a->params.frame_count && weight != 0.0 &&
        weight != a->weight[index]) {
        weft_error(log, "accumulate: frame %" PRId64 " has the weight %g: %g was announced", index,
                   weight, a->weight[index]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result copy_weights(weft_accumulator *a)
{
    const struct weft_accumulator_params *p = &a->params;
    enum weft_result res = WEFT_OK;
    double magnitude = 0.0, largest = 0.0;
    if (p->frame_count == 0)
        return WEFT_OK;
    a->weight = malloc((size_t)p->frame_count * sizeof *a->weight);
    if (!a->weight) {
        weft_error(p->log, "accumulate: not enough memory for %" PRId64 " weights", p->frame_count);
        return WEFT_ERR_MEMORY;
    }
    for (int64_t i = 0; i < p->frame_count; i++) {
        const double weight = p->weight ? p->weight[i] : 1.0;
        a->weight[i] = weight;
        a->known_total += weight;
        magnitude += fabs(weight);
        largest = fmax(largest, fabs(weight));
    }
    weft_weights_scale(&a->weights, largest);
    for (int64_t i = 0; i < p->frame_count && res == WEFT_OK; i++)
        res = check_weight(a, i, a->weight[i]);
    if (res == WEFT_OK && !(fabs(a->known_total) > 0x1p-40 * magnitude)) {
        weft_error(p->log, "accumulate: %" PRId64 " weights add up to %g", p->frame_count,
                   a->known_total);
        res = WEFT_ERR_ARGUMENT;
    }
    a->params.weight = NULL;
    return res;
}

// ---- accumulators -------------------------------------------------------------------------------

static enum weft_result choose(weft_accumulator *a)
{
    const weft_context *context = a->params.context;
    struct weft_accumulate_choice choice;
    a->why = "asked for";
    if (a->params.method == WEFT_ACCUMULATE_AUTO) {
        const enum weft_result res = weft_accumulate_choose(
            &a->params, context && weft_context_get_info(context)->hardware, &choice);
        if (res != WEFT_OK)
            return res;
        a->params.method = choice.method;
        a->params.bits = choice.bits;
        a->why = choice.why;
    }
    weft_accumulate_fill_in(&a->params);
    a->way = weft_accumulate_way_of(a->params.method);
    return WEFT_OK;
}

// What the method cannot do with frames.
static enum weft_result check_method(const weft_accumulator *a)
{
    const char *method = weft_accumulate_method_names[a->way->method];
    if (a->way->method == WEFT_ACCUMULATE_EXACT)
        return WEFT_OK;
    if (a->params.part)
        weft_error(a->params.log,
                   "accumulate: parts of the frames cannot be joined where %s adds them up: exact "
                   "can",
                   method);
    else if (a->params.nonfinite == WEFT_NONFINITE_SKIP)
        weft_error(a->params.log,
                   "accumulate: %s cannot skip values that are not finite: exact can", method);
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result make_scan(weft_accumulator *a)
{
    a->scan = calloc((size_t)a->params.channel_count, sizeof *a->scan);
    if (a->scan)
        return WEFT_OK;
    weft_error(a->params.log, "accumulate: not enough memory");
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_accumulator_create(const struct weft_accumulator_params *params,
                                         weft_accumulator **out)
{
    *out = NULL;
    weft_accumulator *a = NULL;
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    a = calloc(1, sizeof *a);
    if (!a) {
        weft_error(params->log, "accumulate: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    a->params = *params;
    res = choose(a);
    if (res != WEFT_OK) {
        free(a);
        return res;
    }
    res = weft_cpu_resolve(params->log, &params->cpu, &a->params.cpu);
    if (res == WEFT_OK)
        res = check_method(a);
    if (res == WEFT_OK)
        res = copy_weights(a);
    if (res == WEFT_OK && (a->way->scans || params->keep))
        res = make_scan(a);
    if (res == WEFT_OK && params->keep)
        res = weft_moments_create(a);
    if (res == WEFT_OK)
        res = a->way->create(a);
    if (res != WEFT_OK) {
        weft_accumulator_destroy(&a);
        return res;
    }
    *out = a;
    return WEFT_OK;
}

void weft_accumulator_destroy(weft_accumulator **accumulator)
{
    if (!accumulator || !*accumulator)
        return;
    weft_accumulator *a = *accumulator;
    a->way->destroy(a);
    weft_moments_destroy(a);
    weft_frame_source_destroy(a);
    free(a->scan);
    free(a->weight);
    free(a);
    *accumulator = NULL;
}

// ---- frames -------------------------------------------------------------------------------------

static enum weft_result check_frame(const weft_accumulator *a, const struct weft_frame *frame)
{
    const struct weft_accumulator_params *p = &a->params;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, !a->broken && !a->finished);
    weft_require(p->log,
                 frame &&
                     (frame->plane != NULL) + (frame->texture != 0) + (frame->draw != NULL) == 1);
    weft_require(p->log, frame->plane || (p->context && p->channel_count <= WEFT_FRAME_GROUP));
    const int64_t most = p->frame_count ? p->frame_count : WEFT_ACCUMULATE_MAX_FRAMES;
    if (a->frames >= most) {
        weft_error(p->log, "accumulate: one frame more than %" PRId64, most);
        return WEFT_ERR_LIMIT;
    }
    for (int c = 0; frame->plane && c < p->channel_count; c++) {
        weft_require(p->log, frame->plane[c].values != NULL);
        weft_require_enum(p->log, frame->plane[c].type, WEFT_PLANE_TYPE_COUNT - 1);
    }
    res = WEFT_OK;
fail:
    return res;
}

// Looks at a frame in memory before anything is changed.
static enum weft_result scan_frame(weft_accumulator *a, const struct weft_frame *frame,
                                   const struct weft_plane **planes)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    enum weft_result res = weft_frame_planes(a, frame, planes);
    if (res == WEFT_OK && !weft_scan_frame(&shape, *planes, a->scan)) {
        weft_error(a->params.log, "accumulate: not enough memory to look at a frame");
        res = WEFT_ERR_MEMORY;
    }
    for (int c = 0; res == WEFT_OK && c < shape.channel_count; c++)
        if (a->scan[c].nonfinite > 0 && a->params.nonfinite == WEFT_NONFINITE_ERROR) {
            const struct weft_place place = weft_scan_find(&shape, *planes, c, INFINITY);
            weft_error(a->params.log,
                       "accumulate: frame %" PRId64 ", channel %d, pixel (%" PRId32 ", %" PRId32
                       ") is %g, which is not finite",
                       a->frames, c, place.x, place.y, place.value);
            res = WEFT_ERR_FORMAT;
        }
    if (res == WEFT_OK && a->moments)
        res = weft_moments_check(a, *planes);
    return res;
}

static void count(weft_accumulator *a, double weight)
{
    struct weft_weight counted;
    weft_weight_make(&a->weights, weight, &counted);
    weft_weights_add(&a->weights, &counted);
    a->counted++;
    a->total_weight = weft_weights_total(&a->weights);
    for (int c = 0; a->scan && c < a->params.channel_count; c++)
        a->nonfinite += a->scan[c].nonfinite;
}

static enum weft_result add_counting(weft_accumulator *a, const struct weft_frame *frame,
                                     double weight)
{
    const struct weft_plane *planes = NULL;
    enum weft_result res = WEFT_OK;
    weft_frame_begin(a);
    if (a->scan)
        res = scan_frame(a, frame, &planes);
    if (res == WEFT_OK)
        res = a->way->add(a, frame, weight);
    if (res == WEFT_OK && a->moments) {
        res = weft_moments_add(a, planes, weight);
        a->broken = res != WEFT_OK;
    }
    if (res == WEFT_OK)
        count(a, weight);
    a->broken = a->broken || res == WEFT_ERR_MEMORY || res == WEFT_ERR_GL;
    return res;
}

enum weft_result weft_accumulator_add(weft_accumulator *a, const struct weft_frame *frame,
                                      double weight)
{
    enum weft_result res = check_frame(a, frame);
    if (res == WEFT_OK)
        res = check_weight(a, a->frames, weight);
    if (res == WEFT_OK && weight != 0.0)
        res = add_counting(a, frame, weight);
    if (res == WEFT_OK)
        a->frames++;
    return res;
}

// ---- results ------------------------------------------------------------------------------------

static enum weft_result check_results(const weft_accumulator *a)
{
    if (a->broken || a->counted == 0 || a->weights.total == 0) {
        weft_error(a->params.log, "accumulate: %s",
                   a->broken         ? "an earlier failure left no result"
                   : a->counted == 0 ? "no frame that counts yet"
                                     : "the weights add up to 0");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static bool is_kept(const weft_accumulator *a, enum weft_accumulated what)
{
    const unsigned keep = a->params.keep;
    switch (what) {
    case WEFT_ACCUMULATED_VARIANCE:
    case WEFT_ACCUMULATED_STANDARD_ERROR:
        return keep & WEFT_KEEP_VARIANCE;
    case WEFT_ACCUMULATED_MINIMUM:
    case WEFT_ACCUMULATED_MAXIMUM:
        return keep & WEFT_KEEP_EXTREMES;
    default:
        return true;
    }
}

static enum weft_result fill(const weft_accumulator *a, float value, float *out, size_t stride)
{
    for (size_t y = 0; y < (size_t)a->params.height; y++)
        for (size_t x = 0; x < (size_t)a->params.width; x++)
            out[y * stride + x] = value;
    return WEFT_OK;
}

enum weft_result weft_accumulator_current(weft_accumulator *a, enum weft_accumulated what,
                                          int channel, float *out, size_t stride)
{
    const struct weft_log *log = a->params.log;
    const size_t step = stride ? stride : (size_t)a->params.width;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(log, what, WEFT_ACCUMULATED_COUNT - 1);
    weft_require(log, channel >= 0 && channel < a->params.channel_count);
    weft_require(log, out && step >= (size_t)a->params.width);
    weft_require(log, is_kept(a, what));
    res = check_results(a);
    if (res != WEFT_OK)
        return res;
    if (what == WEFT_ACCUMULATED_MEAN)
        res = a->way->mean(a, channel, out, step);
    else if (what == WEFT_ACCUMULATED_WEIGHT)
        res = a->way->share ? a->way->share(a, channel, out, step) : fill(a, 1.0f, out, step);
    else
        res = weft_moments_read(a, what, channel, out, step);
fail:
    return res;
}

static enum weft_result upload_current(weft_accumulator *a, enum weft_accumulated what, int channel,
                                       int channels, const struct weft_texture *texture)
{
    const size_t pixels = (size_t)a->params.width * (size_t)a->params.height;
    const float *plane[WEFT_FRAME_GROUP];
    float *values = malloc(pixels * (size_t)channels * sizeof *values);
    enum weft_result res = WEFT_OK;
    if (!values) {
        weft_error(a->params.log, "accumulate: not enough memory for %d channels", channels);
        return WEFT_ERR_MEMORY;
    }
    for (int c = 0; res == WEFT_OK && c < channels; c++) {
        plane[c] = values + (size_t)c * pixels;
        res = weft_accumulator_current(a, what, channel + c, values + (size_t)c * pixels, 0);
    }
    if (res == WEFT_OK)
        res = weft_texture_write(a->params.context, texture, a->params.width, a->params.height,
                                 channels, plane, 0);
    free(values);
    return res;
}

enum weft_result weft_accumulator_current_texture(weft_accumulator *a, enum weft_accumulated what,
                                                  int channel, int channels,
                                                  const struct weft_texture *texture)
{
    const struct weft_log *log = a->params.log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(log, what, WEFT_ACCUMULATED_COUNT - 1);
    weft_require(log, texture && a->params.context);
    weft_require(log, channels >= 1 && channels <= WEFT_FRAME_GROUP);
    weft_require(log, channel >= 0 && channel <= a->params.channel_count - channels);
    weft_require(log, is_kept(a, what));
    res = check_results(a);
    if (res != WEFT_OK)
        return res;
    const bool grouped = channel / WEFT_FRAME_GROUP == (channel + channels - 1) / WEFT_FRAME_GROUP;
    if (what == WEFT_ACCUMULATED_MEAN && a->way->draw_mean && grouped && !a->params.emulate)
        res = a->way->draw_mean(a, channel, channels, texture);
    else
        res = upload_current(a, what, channel, channels, texture);
fail:
    return res;
}

enum weft_result weft_accumulator_finish(weft_accumulator *a)
{
    enum weft_result res = check_results(a);
    if (res == WEFT_OK && !a->finished && a->way->finish)
        res = a->way->finish(a);
    a->finished = a->finished || res == WEFT_OK;
    return res;
}

void weft_accumulator_get_report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    *out = (struct weft_accumulator_report){
        .method = a->way->method,
        .why = a->why,
        .bits = a->way->method == WEFT_ACCUMULATE_EXACT ? 0 : a->params.bits,
        .frames = a->frames,
        .counted = a->counted,
        .total_weight = a->total_weight,
        .nonfinite = a->nonfinite,
    };
    a->way->report(a, out);
    out->bytes += weft_moments_bytes(a) + weft_frame_bytes(a);
}
