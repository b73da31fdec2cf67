// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/gl/textures/delivery.h"
#include "passes/separable/gl.h"

enum { LANES = WEFT_SEPARABLE_LANES };

struct rectangle {
    int from[2], size[2];
};

struct runner {
    struct weft_separable_gl *c;
    const weft_separable_plan *plan; // the compiled one
    const GladGLContext *gl;
    struct weft_separable_run_params params; // with defaults filled in
    struct weft_separable_care care;
    struct weft_separable_report report;
    struct weft_gl_delivery to;
};

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

// ---- a rectangle's data -------------------------------------------------------------------------

// Weights in groups of four, zeros behind the last; past the last position weights are all zero.
static void write_weights(const struct runner *r, int which,
                          const struct weft_separable_loaded *part, double *exact, float *weights,
                          int32_t *first_taps)
{
    const struct weft_separable_axis *axis = &r->plan->axis[which];
    const int width = axis->width, groups = r->c->groups[which];
    const size_t texels = (size_t)weft_separable_round_up(part->count);
    memset(weights, 0, texels * (size_t)groups * 4 * sizeof *weights);
    memset(first_taps, 0, texels * sizeof *first_taps);
    for (int i = 0; i < part->count; i++, weights += 4 * groups) {
        weft_separable_weights(&r->plan->info.kernel, axis, part->from + i, exact);
        for (int j = 0; j < width; j++)
            weights[j] = weft_separable_single_weight(part->skips_zeros, exact[j]);
        first_taps[i] = weft_separable_first_tap(axis, &r->c->taps[which], part->from + i);
    }
}

static enum weft_result upload_weights(struct runner *r, int which,
                                       const struct weft_separable_loaded *part)
{
    struct weft_separable_gl *c = r->c;
    const size_t texels = (size_t)weft_separable_round_up(part->count);
    const size_t weight_bytes = texels * (size_t)c->groups[which] * 16, first_bytes = texels * 4;
    double *exact = malloc((size_t)r->plan->axis[which].width * sizeof *exact);
    if (!exact) {
        weft_error(r->params.log, "not enough memory for %d weights", r->plan->axis[which].width);
        return WEFT_ERR_MEMORY;
    }
    float *weights = weft_gl_buffer_map(r->gl, &c->weights[which], weight_bytes);
    int32_t *first_taps = weft_gl_buffer_map(r->gl, &c->first_taps[which], first_bytes);
    bool done = weights && first_taps;
    if (done)
        write_weights(r, which, part, exact, weights, first_taps);
    free(exact);
    done = weights && weft_gl_buffer_unmap(r->gl, &c->weights[which]) && done;
    done = first_taps && weft_gl_buffer_unmap(r->gl, &c->first_taps[which]) && done;
    r->report.uploaded_bytes += weight_bytes + first_bytes;
    const enum weft_result res = weft_gl_check(r->params.log, r->gl, "uploading weights");
    if (res != WEFT_OK || done)
        return res;
    weft_error(r->params.log, "%zu bytes of weights could not be handed to GL", weight_bytes);
    return WEFT_ERR_GL;
}

// Weights and taps of a part of an axis, unless they are there from before.
static enum weft_result load_axis(struct runner *r, int which, int from, int count)
{
    const struct weft_separable_loaded part = {from, count, r->care.skips_zeros};
    struct weft_separable_loaded *loaded = &r->c->loaded[which];
    if (loaded->from == from && loaded->count == count && loaded->skips_zeros == part.skips_zeros)
        return WEFT_OK;
    const double start = weft_now_seconds();
    *loaded = (struct weft_separable_loaded){.count = 0};
    weft_separable_taps_number(&r->plan->axis[which], from, from + count, &r->c->taps[which]);
    const enum weft_result res = upload_weights(r, which, &part);
    if (res == WEFT_OK)
        *loaded = part;
    r->report.upload_seconds += weft_now_seconds() - start;
    return res;
}

static void write_samples(const struct runner *r, float *out)
{
    const struct weft_separable_taps *x = &r->c->taps[0], *y = &r->c->taps[1];
    const int row_floats = weft_separable_round_up(x->count);
    const float factor = (float)ldexp(1.0, -r->care.scale_bits);
    for (int j = 0; j < y->count; j++) {
        const int line = y->sample[j];
        const float border = (float)r->params.border * factor;
        const float *row =
            r->params.samples + weft_separable_sample(&r->params, r->params.window.x,
                                                      line < 0 ? r->params.window.y : line);
        for (int i = 0; i < x->count; i++)
            out[i] = line < 0 || x->sample[i] < 0 ? border
                                                  : row[x->sample[i] - r->params.window.x] * factor;
        for (int i = x->count; i < row_floats; i++)
            out[i] = 0.0f;
        out += row_floats;
    }
}

static enum weft_result load_samples(struct runner *r)
{
    const size_t bytes = (size_t)weft_separable_round_up(r->c->taps[0].count) *
                         (size_t)r->c->taps[1].count * sizeof(float);
    const double start = weft_now_seconds();
    float *source = weft_gl_buffer_map(r->gl, &r->c->source, bytes);
    if (source)
        write_samples(r, source);
    const bool done = source && weft_gl_buffer_unmap(r->gl, &r->c->source);
    r->report.uploaded_bytes += bytes;
    r->report.upload_seconds += weft_now_seconds() - start;
    const enum weft_result res = weft_gl_check(r->params.log, r->gl, "uploading samples");
    if (res != WEFT_OK || done)
        return res;
    weft_error(r->params.log, "%zu bytes of samples could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// ---- passes -------------------------------------------------------------------------------------

// From rows of `pitch` texels to `width` x `height` texels of the target.
static void draw(struct runner *r, int axis, const struct weft_gl_buffer *source, int pitch,
                 int width, int height)
{
    const GladGLContext *gl = r->gl;
    const GLuint program = r->c->programs[r->care.skips_zeros][axis];
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, 0, "source", source);
    weft_gl_bind_buffer(gl, program, 1, "weights", &r->c->weights[axis]);
    weft_gl_bind_buffer(gl, program, 2, "first_taps", &r->c->first_taps[axis]);
    gl->Uniform1i(weft_gl_location(gl, program, "pitch"), pitch);
    weft_gl_target_bind(gl, &r->c->target, width, height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    r->report.passes++;
}

// Texture buffers are read several times faster than 2D textures on llvmpipe.
static enum weft_result copy_to_middle(const struct runner *r, int width, int height)
{
    const struct weft_gl_pixels out = {.width = width, .height = height, .type = GL_FLOAT};
    r->gl->BindBuffer(GL_PIXEL_PACK_BUFFER, r->c->middle.buffer);
    const enum weft_result res = weft_gl_target_read(r->params.log, r->gl, &r->c->target, &out);
    r->gl->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    return res;
}

static enum weft_result draw_rectangle(struct runner *r, int columns, int rows)
{
    const double start = weft_now_seconds();
    const int width = weft_separable_round_up(columns) / LANES;
    const int source_width = weft_separable_round_up(r->c->taps[0].count) / LANES;
    enum weft_result res;
    if (r->plan->info.first_axis == 0) {
        draw(r, 0, &r->c->source, source_width * LANES, width, r->c->taps[1].count);
        res = copy_to_middle(r, width, r->c->taps[1].count);
        draw(r, 1, &r->c->middle, width, width, rows);
    } else {
        draw(r, 1, &r->c->source, source_width, source_width, rows);
        res = copy_to_middle(r, source_width, rows);
        draw(r, 0, &r->c->middle, source_width * LANES, width, rows);
    }
    r->gl->Finish();
    r->report.pass_seconds += weft_now_seconds() - start;
    return res == WEFT_OK ? weft_gl_check(r->params.log, r->gl, "filtering") : res;
}

// Whether GL can write a rectangle's rows of so many columns straight to the caller's.
static bool reads_in_place(const struct runner *r, int columns)
{
    return columns % LANES == 0 && r->params.stride % LANES == 0 &&
           r->params.stride / LANES <= INT_MAX;
}

static enum weft_result create_staging(const struct runner *r)
{
    const size_t count = r->c->sizes.staging_floats;
    if (!r->c->staging)
        r->c->staging = malloc(count * sizeof *r->c->staging);
    if (r->c->staging)
        return WEFT_OK;
    weft_error(r->params.log, "not enough memory for %zu pixels", count);
    return WEFT_ERR_MEMORY;
}

static enum weft_result read_back(struct runner *r, const struct rectangle *rectangle)
{
    const int columns = rectangle->size[0], rows = rectangle->size[1];
    const int width = weft_separable_round_up(columns) / LANES;
    const bool in_place = reads_in_place(r, columns);
    const double start = weft_now_seconds();
    enum weft_result res = in_place ? WEFT_OK : create_staging(r);
    if (res != WEFT_OK)
        return res;
    float *out = weft_separable_pixel(&r->params, rectangle->from[0], rectangle->from[1]);
    const struct weft_gl_pixels to = {
        .width = width,
        .height = rows,
        .type = GL_FLOAT,
        .stride = in_place ? (int)(r->params.stride / LANES) : 0,
        .data = in_place ? out : r->c->staging,
    };
    res = weft_gl_target_read(r->params.log, r->gl, &r->c->target, &to);
    for (int y = 0; res == WEFT_OK && !in_place && y < rows; y++)
        memcpy(out + y * r->params.stride, r->c->staging + (size_t)y * (size_t)width * LANES,
               (size_t)columns * sizeof *out);
    weft_separable_finish(&r->care, r->plan, &r->params, rectangle->from, rectangle->size);
    for (int y = 0; res == WEFT_OK && y < rows; y++)
        weft_statistics_add(&r->report.pixels, out + y * r->params.stride, (size_t)columns);
    r->report.readback_seconds += weft_now_seconds() - start;
    return res;
}

static enum weft_result hand_over(struct runner *r, const struct rectangle *rectangle)
{
    const struct weft_rectangle at = {rectangle->from[0] - r->params.part.x,
                                      rectangle->from[1] - r->params.part.y, rectangle->size[0],
                                      rectangle->size[1]};
    const struct weft_gl_drawn drawn = {.texture = r->c->target.texture,
                                        .texels = WEFT_TEXELS_PACKED};
    return r->care.scale_bits ? weft_gl_delivery_upload(&r->to, &at)
                              : weft_gl_delivery_draw(&r->to, &drawn, &at);
}

static enum weft_result run_rectangle(struct runner *r, const struct rectangle *rectangle)
{
    enum weft_result res = load_samples(r);
    if (res == WEFT_OK)
        res = draw_rectangle(r, rectangle->size[0], rectangle->size[1]);
    if (res == WEFT_OK && r->params.pixels)
        res = read_back(r, rectangle);
    if (res == WEFT_OK)
        res = hand_over(r, rectangle);
    r->report.rectangles++;
    return res;
}

// Where the cut after a position is.
static int next_cut(int from, int cut)
{
    return (from / cut + 1) * cut;
}

// A part's rectangles are what it has of those that all pixels are cut into, for which there is
// room.
static enum weft_result run_rectangles(struct runner *r)
{
    const struct weft_rectangle *part = &r->params.part;
    const int end_x = part->x + part->width, end_y = part->y + part->height;
    const int *cut = r->c->cut;
    const int strips = (end_x - 1) / cut[0] - part->x / cut[0] + 1;
    const double total = (double)strips * ((end_y - 1) / cut[1] - part->y / cut[1] + 1);
    enum weft_result res = WEFT_OK;
    for (int from_x = part->x; from_x < end_x; from_x = next_cut(from_x, cut[0])) {
        const int columns = smaller(next_cut(from_x, cut[0]), end_x) - from_x;
        res = load_axis(r, 0, from_x, columns);
        for (int from_y = part->y; res == WEFT_OK && from_y < end_y;
             from_y = next_cut(from_y, cut[1])) {
            const int rows = smaller(next_cut(from_y, cut[1]), end_y) - from_y;
            if (!weft_separable_go_on(r->params.progress, r->report.rectangles / total)) {
                weft_note(r->params.log,
                          "separable filtering was cancelled at rectangle %d of %.0f",
                          r->report.rectangles, total);
                return WEFT_ERR_CANCELLED;
            }
            res = load_axis(r, 1, from_y, rows);
            if (res == WEFT_OK)
                res = run_rectangle(r, &(struct rectangle){{from_x, from_y}, {columns, rows}});
        }
        if (res != WEFT_OK)
            return res;
    }
    weft_separable_go_on(r->params.progress, 1.0);
    return WEFT_OK;
}

// ---- the whole ----------------------------------------------------------------------------------

// Pixels of sums that were scaled are not as they were drawn.
static enum weft_result begin_delivery(struct runner *r)
{
    const struct weft_separable_run_params *p = &r->params;
    r->to = (struct weft_gl_delivery){.width = p->part.width,
                                      .height = p->part.height,
                                      .outputs = 1,
                                      .at = p->pixels,
                                      .stride = p->stride};
    enum weft_result res = weft_gl_delivery_begin(r->c->context, p->log, p->texture, &r->to);
    if (res == WEFT_OK && r->care.scale_bits)
        res = weft_gl_delivery_room(p->log, &r->to);
    r->params.pixels = r->to.at;
    r->params.stride = r->to.stride;
    return res;
}

static enum weft_result run(struct runner *r)
{
    const double start = weft_now_seconds();
    r->care = weft_separable_take_care(r->plan, &r->params);
    enum weft_result res = weft_separable_find_programs(r->c, r->care.skips_zeros);
    r->report.prepare_seconds = weft_now_seconds() - start;
    if (res == WEFT_OK)
        res = begin_delivery(r);
    if (res == WEFT_OK)
        res = run_rectangles(r);
    weft_gl_delivery_end(&r->to);
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return res;
}

enum weft_result weft_separable_gl_run(struct weft_separable_gl *compiled,
                                       const struct weft_separable_run_params *params,
                                       struct weft_separable_report *report)
{
    weft_context *context = compiled->context;
    struct runner r = {.c = compiled,
                       .plan = compiled->plan,
                       .gl = &context->gl,
                       .params = *params,
                       .report = {.pixels = WEFT_STATISTICS_NONE}};
    const int linked = context->programs_linked;
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = run(&r);
    weft_context_leave(context);
    r.report.programs_linked = context->programs_linked - linked;
    r.report.peak_bytes = compiled->sizes.bytes;
    *report = r.report;
    return res;
}
