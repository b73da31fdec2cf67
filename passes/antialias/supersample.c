// SPDX-License-Identifier: BSD-3-Clause
// Supersampling: a moved picture for each sample, whose pixels that count become a frame of a mean.
//
// The bound of what a filter makes, for samples up to 1: a frame's value is sum_q W_q v_q over a
// window of n pixels, W_q being the weights times the samples that count. GL's products, sums and
// texels are one of the two floats nearest to the exact ones: 2^-23 of them. Weights are rounded to
// floats (2^-24), 8-bit texels to floats (2^-23), products (2^-23), and each is in n - 1 sums at
// most, the first of which is with 0 and exact: together (n + 2) 2^-23 of |W_q v_q|. Over all
// frames the mean of sum |W_q| is the magnitude of all weights. Floats below 2^-126 may be 0.
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/marks/marks_impl.h"
#include "passes/antialias/supersample_impl.h"
#include "passes/jitter/discrepancy.h"

const char *const weft_supersample_store_names[] = {"sums", "blocks", NULL};

// ---- samples and what they count ----------------------------------------------------------------

// The part of a sample's weights that is not 0, as a window: the pixel (x, y) further right and
// down gets weight[y][x]; so a pixel gets it from the one as far to the left and up.
static bool find_window(const struct weft_spread *spread, int index,
                        struct weft_supersample_sample *out)
{
    const int r = spread->radius, side = 2 * r + 1;
    int low[2] = {side, side}, high[2] = {-1, -1};
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            if (spread->weight[(y * side + x) * spread->count + index] == 0.0)
                continue;
            low[0] = x < low[0] ? x : low[0];
            low[1] = y < low[1] ? y : low[1];
            high[0] = x > high[0] ? x : high[0];
            high[1] = y > high[1] ? y : high[1];
        }
    out->first[0] = r - high[0];
    out->first[1] = low[1] - r;
    out->columns = high[0] - low[0] + 1;
    out->rows = high[1] - low[1] + 1;
    return high[0] >= 0;
}

static void fill_window(const struct weft_spread *spread, int index, double scale,
                        const struct weft_supersample_sample *sample)
{
    const int r = spread->radius, side = 2 * r + 1;
    for (int y = 0; y < sample->rows; y++)
        for (int x = 0; x < sample->columns; x++) {
            const int from_x = r - sample->first[0] - x, from_y = sample->first[1] + y + r;
            sample->weight[y * sample->columns + x] =
                (float)(scale * spread->weight[(from_y * side + from_x) * spread->count + index]);
        }
}

static bool are_copies(const weft_supersample *s)
{
    for (int i = 0; i < s->used; i++)
        if (s->radius > 0 || s->sample[i].weight[0] != 1.0f)
            return false;
    return true;
}

static enum weft_result make_weights(weft_supersample *s, const double (*position)[2],
                                     const struct weft_spread *spread)
{
    const int side = 2 * spread->radius + 1;
    int index[WEFT_PATTERN_MAX];
    float *next = s->weight = malloc((size_t)(side * side * spread->count) * sizeof *s->weight);
    if (!s->weight) {
        weft_error(s->params.log, "supersample: not enough memory for weights");
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < spread->count; i++) {
        struct weft_supersample_sample *sample = &s->sample[s->used];
        if (!find_window(spread, i, sample))
            continue;
        sample->position[0] = position[i][0];
        sample->position[1] = position[i][1];
        index[s->used++] = i;
    }
    for (int i = 0; i < s->used; i++) {
        struct weft_supersample_sample *sample = &s->sample[i];
        const int window = sample->columns * sample->rows;
        sample->weight = next;
        next += window;
        fill_window(spread, index[i], s->used, sample);
        s->largest_window = window > s->largest_window ? window : s->largest_window;
    }
    s->radius = spread->radius;
    s->magnitude = 1.0 + 2.0 * spread->negative;
    s->copies = are_copies(s);
    return WEFT_OK;
}

static bool takes_negative(enum weft_accumulate_method method)
{
    return method == WEFT_ACCUMULATE_AUTO || method == WEFT_ACCUMULATE_EXACT ||
           method == WEFT_ACCUMULATE_FLOAT;
}

static enum weft_result make_samples(weft_supersample *s, const double (*position)[2])
{
    const struct weft_supersample_params *p = &s->params;
    struct weft_discrepancy discrepancy;
    struct weft_spread spread;
    enum weft_result res = weft_spread_create(
        weft_spread_params(.position = position, .count = p->count, .filter = p->filter,
                           .filter_width = p->filter_width, .log = p->log),
        &spread);
    if (res == WEFT_OK && spread.negative > 0.0 && !takes_negative(p->method)) {
        weft_error(p->log,
                   "supersample: the kernel %s has weights below 0, which %s cannot add up: exact "
                   "and float can",
                   p->filter.info->name, weft_accumulate_method_names[p->method]);
        res = WEFT_ERR_UNSUPPORTED;
    }
    if (res == WEFT_OK)
        res = make_weights(s, position, &spread);
    weft_spread_clear(&spread);
    if (res != WEFT_OK)
        return res;
    res = weft_discrepancy_compute(
        weft_discrepancy_params(.points = position, .count = p->count, .log = p->log),
        &discrepancy);
    s->discrepancy = discrepancy.value;
    return res;
}

// The middles of k x k squares.
static enum weft_result make_grid(weft_supersample *s)
{
    const int count = s->params.count, side = (int)lround(sqrt(count));
    double position[WEFT_PATTERN_MAX][2];
    if (side * side != count) {
        weft_error(s->params.log, "supersample: %d samples are no k x k grid", count);
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < count; i++) {
        position[i][0] = (i % side + 0.5) / side - 0.5;
        position[i][1] = (i / side + 0.5) / side - 0.5;
    }
    return make_samples(s, position);
}

// ---- objects ------------------------------------------------------------------------------------

static enum weft_result check_params(const struct weft_supersample_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->context != NULL);
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->count > 0 && p->count <= WEFT_PATTERN_MAX);
    weft_require_enum(p->log, p->store, WEFT_STORE_COUNT - 1);
    weft_require_enum(p->log, p->format, WEFT_ANTIALIAS_FORMAT_COUNT - 1);
    weft_require_enum(p->log, p->method, WEFT_ACCUMULATE_METHOD_COUNT - 1);
    for (int i = 0; i < 4; i++)
        weft_require(p->log, isfinite(p->background[i]));
    res = WEFT_OK;
fail:
    return res;
}

static enum weft_result check_size(const weft_supersample *s)
{
    const struct weft_supersample_params *p = &s->params;
    const int64_t most = weft_context_get_info(p->context)->max_target_size;
    const int64_t limit = most < UINT16_MAX ? most : UINT16_MAX;
    if (p->width + 2 * (int64_t)s->radius <= limit && p->height + 2 * (int64_t)s->radius <= limit)
        return WEFT_OK;
    weft_error(p->log,
               "supersample: %" PRId32 " x %" PRId32 " pixels with a rim of %d, the limit is "
               "%" PRId64 " along a side",
               p->width, p->height, s->radius, limit);
    return WEFT_ERR_LIMIT;
}

static enum weft_result create(const struct weft_supersample_params *params, weft_supersample *s)
{
    weft_context *context = params->context;
    s->params = *params;
    s->params.position = NULL;
    if (s->params.count == 0)
        s->params.count = 16;
    enum weft_result res = check_params(&s->params);
    if (res == WEFT_OK)
        res = params->position ? make_samples(s, params->position) : make_grid(s);
    if (res == WEFT_OK)
        res = check_size(s);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = weft_supersample_make_scratch(s);
    weft_context_leave(context);
    return res;
}

enum weft_result weft_supersample_create(const struct weft_supersample_params *params,
                                         weft_supersample **out)
{
    *out = NULL;
    weft_supersample *s = calloc(1, sizeof *s);
    if (!s) {
        weft_error(params->log, "supersample: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res = create(params, s);
    if (res == WEFT_OK)
        *out = s;
    else
        weft_supersample_destroy(&s);
    return res;
}

static void forget_picture(weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    weft_accumulator_destroy(&s->sums);
    weft_marks_clear(&s->mask);
    s->drawn = false;
    if (weft_context_enter(s->params.context) != WEFT_OK)
        return;
    weft_supersample_destroy_compact(s);
    weft_pixel_list_clear(gl, &s->result);
    weft_pixel_list_clear(gl, &s->sampled);
    weft_context_leave(s->params.context);
}

void weft_supersample_destroy(weft_supersample **supersample)
{
    weft_supersample *s = supersample ? *supersample : NULL;
    if (!s)
        return;
    *supersample = NULL;
    if (s->params.context) {
        forget_picture(s);
        if (weft_context_enter(s->params.context) == WEFT_OK) {
            weft_supersample_destroy_scratch(s);
            weft_context_leave(s->params.context);
        }
    }
    free(s->weight);
    free(s);
}

// ---- pictures -----------------------------------------------------------------------------------

static enum weft_result prepare(weft_supersample *s, const struct weft_marks *marks)
{
    const struct weft_supersample_params *p = &s->params;
    enum weft_result res = weft_supersample_list(s, marks);
    if (res != WEFT_OK || s->result.count == 0)
        return res;
    res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    res = weft_supersample_mask(s);
    if (res == WEFT_OK)
        res = weft_supersample_make_compact(s);
    weft_context_leave(p->context);
    // Codes are enough where frames are codes.
    const int bits = s->copies && p->format == WEFT_ANTIALIAS_RGBA8 ? 0 : 32;
    if (res == WEFT_OK)
        res = weft_accumulator_create(
            weft_accumulator_params(.width = s->result.width, .height = s->result.height,
                                    .channel_count = 4, .method = p->method,
                                    .bits = p->method == WEFT_ACCUMULATE_BUFFER ? 0 : bits,
                                    .frame_count = s->used, .frames_on_gl = true,
                                    .context = p->context, .log = p->log),
            &s->sums);
    return res;
}

static enum weft_result report_progress(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction)
               ? WEFT_OK
               : WEFT_ERR_CANCELLED;
}

// Draws a sample; into its layer of the blocks, or to be gathered at once.
static enum weft_result draw_sample(weft_supersample *s,
                                    const struct weft_antialias_drawing *drawing, int index)
{
    enum weft_result res = weft_context_enter(s->params.context);
    if (res != WEFT_OK)
        return res;
    res = weft_supersample_draw(s, drawing, index);
    if (res == WEFT_OK && s->params.store == WEFT_STORE_BLOCKS)
        res = weft_supersample_keep(s, index);
    weft_context_leave(s->params.context);
    return res;
}

static enum weft_result add_sample(weft_supersample *s, int index)
{
    struct weft_plane planes[4];
    struct weft_frame frame = {0};
    enum weft_result res = weft_context_enter(s->params.context);
    if (res != WEFT_OK)
        return res;
    if (weft_supersample_picks(s)) {
        frame.plane = planes;
        res = weft_supersample_pick(s, planes);
    } else {
        res = weft_supersample_gather(s, index, &frame.texture);
    }
    weft_context_leave(s->params.context);
    return res == WEFT_OK ? weft_accumulator_add(s->sums, &frame, 1.0) : res;
}

static enum weft_result draw_picture(weft_supersample *s,
                                     const struct weft_antialias_drawing *drawing,
                                     const struct weft_progress *progress)
{
    const bool blocks = s->params.store == WEFT_STORE_BLOCKS;
    const int steps = blocks ? 2 * s->used : s->used;
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < steps && res == WEFT_OK; i++) {
        res = report_progress(progress, (double)i / steps);
        if (res == WEFT_OK && i < s->used)
            res = draw_sample(s, drawing, i);
        if (res == WEFT_OK && (!blocks || i >= s->used))
            res = add_sample(s, i % s->used);
    }
    return res == WEFT_OK ? report_progress(progress, 1.0) : res;
}

// The last picture is kept where there is something wrong with them.
static enum weft_result find_part(weft_supersample *s, const struct weft_rectangle *asked,
                                  const struct weft_marks *marks)
{
    const struct weft_supersample_params *p = &s->params;
    struct weft_rectangle part;
    const enum weft_result res = weft_rectangle_within(p->log, asked, p->width, p->height, &part);
    if (res != WEFT_OK)
        return res;
    if (marks) {
        const struct weft_rectangle of = weft_marks_part(marks),
                                    needed = weft_part_grown(&part, s->radius, p->width, p->height),
                                    both = weft_rectangle_common(&of, &needed);
        if (weft_part_pixels(&both) < weft_part_pixels(&needed)) {
            weft_error(p->log,
                       "supersample: marks of %d x %d pixels from (%d, %d) on, for %d x %d from "
                       "(%d, %d) on",
                       of.width, of.height, of.x, of.y, needed.width, needed.height, needed.x,
                       needed.y);
            return WEFT_ERR_ARGUMENT;
        }
    }
    s->part = part;
    s->window = (struct weft_rectangle){part.x, part.y, part.width + 2 * s->radius,
                                        part.height + 2 * s->radius};
    return WEFT_OK;
}

enum weft_result weft_supersample_run(weft_supersample *s,
                                      const struct weft_antialias_drawing *drawing,
                                      const struct weft_marks *marks,
                                      const struct weft_progress *progress)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(s->params.log, drawing && drawing->draw);
    weft_require(s->params.log, !marks || marks->marked);
    if (marks && (marks->width != s->params.width || marks->height != s->params.height)) {
        weft_error(s->params.log,
                   "supersample: marks of %" PRId32 " x %" PRId32 " pixels, not %" PRId32
                   " x %" PRId32,
                   marks->width, marks->height, s->params.width, s->params.height);
        goto fail;
    }
    res = find_part(s, &drawing->part, marks);
    if (res != WEFT_OK)
        goto fail;
    forget_picture(s);
    res = prepare(s, marks);
    if (res == WEFT_OK && s->result.count > 0)
        res = draw_picture(s, drawing, progress);
    if (res == WEFT_OK)
        s->drawn = true;
    else
        forget_picture(s);
fail:
    return res;
}

// ---- results ------------------------------------------------------------------------------------

static enum weft_result read_listed(weft_supersample *s, int channel, float *out, size_t stride)
{
    const struct weft_pixel_list *list = &s->result;
    float *compact = malloc((size_t)list->width * (size_t)list->height * sizeof *compact);
    if (!compact) {
        weft_error(s->params.log, "supersample: not enough memory for %" PRId64 " pixels",
                   list->count);
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res =
        weft_accumulator_current(s->sums, WEFT_ACCUMULATED_MEAN, channel, compact, 0);
    for (int64_t i = 0; res == WEFT_OK && i < list->count; i++)
        out[(size_t)(list->at[i][1] - s->radius - s->part.y) * stride +
            (size_t)(list->at[i][0] - s->radius - s->part.x)] = compact[i];
    free(compact);
    return res;
}

enum weft_result weft_supersample_read(weft_supersample *s, int channel, float *out, size_t stride)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(s->params.log, s->drawn);
    weft_require(s->params.log, channel >= 0 && channel < 4);
    if (stride == 0)
        stride = (size_t)s->part.width;
    if (s->result.count == 0)
        return WEFT_OK;
    if (!s->result.at)
        return weft_accumulator_current(s->sums, WEFT_ACCUMULATED_MEAN, channel, out, stride);
    return read_listed(s, channel, out, stride);
fail:
    return res;
}

static uint64_t bytes_of(const weft_supersample *s)
{
    const struct weft_pixel_list *lists[] = {&s->result, &s->sampled};
    uint64_t bytes = weft_supersample_pick_bytes(s);
    if (weft_context_enter(s->params.context) == WEFT_OK) {
        bytes += weft_supersample_gl_bytes(s);
        weft_context_leave(s->params.context);
    }
    for (size_t i = 0; i < WEFT_COUNT(lists); i++)
        if (lists[i]->at)
            bytes += (uint64_t)lists[i]->width * (uint64_t)lists[i]->height * sizeof *lists[i]->at;
    return bytes;
}

void weft_supersample_get_report(const weft_supersample *s, struct weft_supersample_report *out)
{
    const struct weft_supersample_params *p = &s->params;
    const uint64_t all = (uint64_t)p->width * (uint64_t)p->height * (uint64_t)p->count * (3 + 4);
    *out = (struct weft_supersample_report){
        .samples = p->count,
        .passes = s->used,
        .discrepancy = s->discrepancy,
        .radius = s->radius,
        .method = p->method,
        .pixels = s->result.count,
        .sampled = s->sampled.count,
        .formula_bytes =
            s->masked ? weft_bytes_adaptive(p->width, p->height, s->result.count, p->count, 3, 4)
                      : all,
        .bytes = bytes_of(s),
    };
    if (!s->copies)
        out->filter_bound = (s->largest_window + 2) * (1.01 * 0x1p-23) * s->magnitude +
                            s->largest_window * (double)FLT_MIN;
    if (!s->sums)
        return;
    struct weft_accumulator_report sums;
    weft_accumulator_get_report(s->sums, &sums);
    out->method = sums.method;
    out->bound = sums.bound;
    out->bytes += sums.bytes;
}
