// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/separable/job.h"

// Columns that a pass computes at a time, in a texel of its target.
enum { LANES = 4 };

// On software GLs, rectangles that take more than this are up to twice as slow: fresh memory costs
// as much as filtering does, and caches hold less of it. None is made lower than LOW_ROWS for that
// while it is wide.
enum { CACHE_BYTES = 12 << 20, LOW_ROWS = 64 };

// One axis of the pixels and of the samples, and the part of it that a rectangle has.
struct axis {
    const double *at;
    int positions, size; // pixels, samples
    int32_t *first;      // of every position: the first tap, clamped to where all are the edge's
    int cut;             // positions of a rectangle at most
    int most_taps;       // different taps of all positions of a rectangle, at most
    int all_taps;        // of all positions

    // Of the current part, counted from the least tap that is possible.
    int tap_count;
    int32_t *sample; // of the different taps in order: which sample
    int32_t *place;  // of every tap that there is: its number among those
};

struct rectangle {
    int from[2], size[2];
};

// Of the largest rectangle, and together.
struct sizes {
    size_t source_texels, middle_texels, weight_texels[2], first_texels[2];
    int target_width, target_height;
    size_t staging_floats;
    uint64_t bytes;
};

struct runner {
    struct weft_separable_params params;
    weft_context *context;
    const GladGLContext *gl;
    const struct weft_log *log;
    int width, groups; // taps, and texels of four weights
    int first_axis;    // that is filtered along
    struct axis axis[2];
    struct sizes sizes;
    struct weft_separable_care care;
    struct weft_gl_buffer source, middle; // middle: what the first pass made
    struct weft_gl_buffer weights[2], first_taps[2];
    GLuint programs[2]; // along x and along y; the context's
    struct weft_gl_target target;
    float *staging; // rows that GL cannot write where they belong
    struct weft_separable_report report;
};

static int round_up(int columns)
{
    return (columns + LANES - 1) / LANES * LANES;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// ---- taps ---------------------------------------------------------------------------------------

static int32_t clamp_tap(const struct runner *r, const struct axis *a, int64_t tap)
{
    const int64_t low = 1 - r->width, high = a->size - 1;
    return (int32_t)(tap < low ? low : tap > high ? high : tap);
}

// Numbers the different taps of positions `from` to `to`, exclusive.
static void number_taps(const struct runner *r, struct axis *a, int from, int to)
{
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (int i = from; i < to; i++) {
        low = a->first[i] < low ? a->first[i] : low;
        high = a->first[i] > high ? a->first[i] : high;
    }
    int32_t *place = a->place + (r->width - 1); // of tap 0
    const int32_t end = high + r->width;
    memset(place + low, 0, (size_t)(end - low) * sizeof *place);
    for (int i = from; i < to; i++)
        place[a->first[i]] = 1;
    a->tap_count = 0;
    int left = 0; // taps that a position before needs
    for (int32_t tap = low; tap < end; tap++) {
        left = place[tap] ? r->width : left - 1;
        place[tap] = a->tap_count;
        if (left > 0)
            a->sample[a->tap_count++] = tap < 0 ? 0 : tap >= a->size ? a->size - 1 : tap;
    }
}

static int most_taps(const struct runner *r, struct axis *a)
{
    int most = 0;
    for (int from = 0; from < a->positions; from += a->cut) {
        number_taps(r, a, from, from + smaller(a->cut, a->positions - from));
        most = a->tap_count > most ? a->tap_count : most;
    }
    return most;
}

static enum weft_result find_taps(struct runner *r, struct axis *a)
{
    // Taps from 1 - width to size + width - 2.
    const size_t taps = (size_t)a->size + 2 * (size_t)r->width - 2;
    a->first = malloc((size_t)a->positions * sizeof *a->first);
    a->sample = malloc(taps * sizeof *a->sample);
    a->place = malloc(taps * sizeof *a->place);
    if (!a->first || !a->sample || !a->place) {
        weft_error(r->log, "not enough memory for the taps of %d pixels and %d samples",
                   a->positions, a->size);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < a->positions; i++) {
        double fraction;
        a->first[i] =
            clamp_tap(r, a, weft_kernel_first_tap(&r->params.kernel, a->at[i], &fraction));
    }
    a->cut = a->positions;
    a->all_taps = a->most_taps = most_taps(r, a);
    return WEFT_OK;
}

// ---- the order of the axes, and the cut ---------------------------------------------------------

// For all pixels, by texels of four columns: along x, each of the four has its own weights and
// taps.
static double count_fetches(const struct runner *r, int first_axis)
{
    const struct axis *x = &r->axis[0], *y = &r->axis[1];
    const double along_y = 1.0 + r->groups + r->width, along_x = LANES * along_y;
    const double columns = round_up(x->positions) / LANES;
    return first_axis == 0 ? columns * y->all_taps * along_x + columns * y->positions * along_y
                           : (double)(round_up(x->all_taps) / LANES) * y->positions * along_y +
                                 columns * y->positions * along_x;
}

static void choose_order(struct runner *r)
{
    const double fetches[2] = {count_fetches(r, 0), count_fetches(r, 1)};
    r->first_axis = fetches[1] < fetches[0];
    r->report.first_axis = r->first_axis;
    r->report.fetches_per_pixel =
        fetches[r->first_axis] / r->axis[0].positions / r->axis[1].positions;
}

// Whether GL can write a rectangle's rows of so many columns straight to the caller's.
static bool reads_in_place(const struct runner *r, int columns)
{
    return columns % LANES == 0 && r->params.stride % LANES == 0 &&
           r->params.stride / LANES <= INT_MAX;
}

static void measure(struct runner *r)
{
    const struct axis *x = &r->axis[0], *y = &r->axis[1];
    const size_t columns = (size_t)round_up(x->cut) / LANES;
    const size_t source_columns = (size_t)round_up(x->most_taps) / LANES;
    const size_t rows = (size_t)y->cut, source_rows = (size_t)y->most_taps;
    const size_t middle_columns = r->first_axis == 0 ? columns : source_columns;
    const size_t middle_rows = r->first_axis == 0 ? source_rows : rows;
    struct sizes *s = &r->sizes;
    s->source_texels = source_columns * source_rows * (r->first_axis == 0 ? LANES : 1);
    s->middle_texels = middle_columns * middle_rows * (r->first_axis == 0 ? 1 : LANES);
    s->target_width = (int)larger(columns, middle_columns);
    s->target_height = (int)larger(rows, middle_rows);
    for (int a = 0; a < 2; a++) {
        s->first_texels[a] = (size_t)round_up(r->axis[a].cut);
        s->weight_texels[a] = s->first_texels[a] * (size_t)r->groups;
    }
    s->staging_floats = reads_in_place(r, x->positions) ? 0 : columns * LANES * rows;
    s->bytes = 16 * (uint64_t)source_columns * source_rows +
               16 * (uint64_t)middle_columns * middle_rows +
               16 * (uint64_t)s->target_width * (uint64_t)s->target_height +
               4 * (uint64_t)s->staging_floats;
    for (int a = 0; a < 2; a++)
        s->bytes += 16 * (uint64_t)s->weight_texels[a] + 4 * (uint64_t)s->first_texels[a];
}

static bool fits(const struct runner *r)
{
    const struct sizes *s = &r->sizes;
    const struct weft_context_info *info = &r->context->info;
    const size_t texels = larger(larger(s->source_texels, s->middle_texels),
                                 larger(s->weight_texels[0], s->weight_texels[1]));
    return s->bytes <= r->params.memory_bytes && (info->hardware || s->bytes <= CACHE_BYTES) &&
           (int64_t)texels <= info->max_buffer_texels && s->target_width <= info->max_target_size &&
           s->target_height <= info->max_target_size;
}

// Makes rectangles lower, and where they are low halves their longer side, until they fit. Rows are
// cut first: the columns' weights then need not be made again. Columns are cut between texels.
static enum weft_result choose_cut(struct runner *r)
{
    struct axis *x = &r->axis[0], *y = &r->axis[1];
    for (measure(r); !fits(r); measure(r)) {
        const bool rows = y->cut > LOW_ROWS || y->cut >= x->cut || x->cut <= LANES;
        struct axis *a = rows ? y : x;
        if (a->cut == 1) {
            weft_error(r->log,
                       "separable filtering: %llu bytes for %d pixels with %d x %d samples in "
                       "reach, over the limit of %llu bytes, or the context's of %lld texels",
                       (unsigned long long)r->sizes.bytes, x->cut, x->most_taps, y->most_taps,
                       (unsigned long long)r->params.memory_bytes,
                       (long long)r->context->info.max_buffer_texels);
            return WEFT_ERR_LIMIT;
        }
        a->cut = rows ? (a->cut + 1) / 2 : round_up((a->cut + 1) / 2);
        a->most_taps = most_taps(r, a);
    }
    return WEFT_OK;
}

// ---- what GL holds ------------------------------------------------------------------------------

static enum weft_result find_programs(struct runner *r)
{
    enum weft_result res = WEFT_OK;
    for (int a = 0; res == WEFT_OK && a < 2; a++) {
        char defines[128];
        snprintf(defines, sizeof defines,
                 "#define WIDTH %d\n#define GROUPS %d\n#define ALONG_X %d\n"
                 "#define SKIPS_ZEROS %d\n",
                 r->width, r->groups, a == 0, r->care.skips_zeros);
        res = weft_program_get(r->context, "separable", defines, weft_shader_full_target,
                               weft_shader_separable, &r->programs[a]);
    }
    return res;
}

static enum weft_result create_buffers(struct runner *r)
{
    const struct sizes *s = &r->sizes;
    const GLenum formats[2] = {GL_R32F, GL_RGBA32F}; // read along x, along y
    enum weft_result res =
        weft_gl_buffer_create(r->log, r->gl, formats[r->first_axis], s->source_texels, &r->source);
    if (res == WEFT_OK)
        res = weft_gl_buffer_create(r->log, r->gl, formats[!r->first_axis], s->middle_texels,
                                    &r->middle);
    for (int a = 0; res == WEFT_OK && a < 2; a++) {
        res = weft_gl_buffer_create(r->log, r->gl, GL_RGBA32F, s->weight_texels[a], &r->weights[a]);
        if (res == WEFT_OK)
            res = weft_gl_buffer_create(r->log, r->gl, GL_R32I, s->first_texels[a],
                                        &r->first_taps[a]);
    }
    return res;
}

static enum weft_result create_staging(struct runner *r)
{
    if (!r->sizes.staging_floats)
        return WEFT_OK;
    r->staging = malloc(r->sizes.staging_floats * sizeof *r->staging);
    if (r->staging)
        return WEFT_OK;
    weft_error(r->log, "not enough memory for %zu pixels", r->sizes.staging_floats);
    return WEFT_ERR_MEMORY;
}

static void destroy(struct runner *r)
{
    const GladGLContext *gl = r->gl;
    weft_gl_buffer_destroy(gl, &r->source);
    weft_gl_buffer_destroy(gl, &r->middle);
    for (int a = 0; a < 2; a++) {
        weft_gl_buffer_destroy(gl, &r->weights[a]);
        weft_gl_buffer_destroy(gl, &r->first_taps[a]);
        free(r->axis[a].first);
        free(r->axis[a].sample);
        free(r->axis[a].place);
    }
    weft_gl_target_destroy(gl, &r->target);
    free(r->staging);
    weft_separable_care_destroy(&r->care);
}

// ---- a rectangle's data -------------------------------------------------------------------------

// Where zeros are left out, only those are zero that are so in double.
static float single_weight(const struct runner *r, double weight)
{
    const bool vanishes = fabs(weight) < FLT_MIN && weight != 0.0;
    return r->care.skips_zeros && vanishes ? (float)copysign(FLT_MIN, weight) : (float)weight;
}

// Weights in groups of four, zeros behind the last; past the last position weights are all zero.
static void write_weights(const struct runner *r, const struct axis *a, int from, int count,
                          float *weights, int32_t *first_taps)
{
    memset(weights, 0, (size_t)round_up(count) * (size_t)r->groups * 4 * sizeof *weights);
    memset(first_taps, 0, (size_t)round_up(count) * sizeof *first_taps);
    for (int i = 0; i < count; i++, weights += 4 * r->groups) {
        double exact[WEFT_KERNEL_MAX_WIDTH];
        weft_kernel_weights(&r->params.kernel, a->at[from + i], exact);
        for (int j = 0; j < r->width; j++)
            weights[j] = single_weight(r, exact[j]);
        first_taps[i] = a->place[a->first[from + i] + r->width - 1];
    }
}

static enum weft_result load_axis(struct runner *r, int which, int from, int count)
{
    struct axis *a = &r->axis[which];
    const size_t texels = (size_t)round_up(count);
    const size_t weight_bytes = texels * (size_t)r->groups * 16, first_bytes = texels * 4;
    const double start = weft_now_seconds();
    number_taps(r, a, from, from + count);
    float *weights = weft_gl_buffer_map(r->gl, &r->weights[which], weight_bytes);
    int32_t *first_taps = weft_gl_buffer_map(r->gl, &r->first_taps[which], first_bytes);
    bool done = weights && first_taps;
    if (done)
        write_weights(r, a, from, count, weights, first_taps);
    done = weights && weft_gl_buffer_unmap(r->gl, &r->weights[which]) && done;
    done = first_taps && weft_gl_buffer_unmap(r->gl, &r->first_taps[which]) && done;
    r->report.uploaded_bytes += weight_bytes + first_bytes;
    r->report.upload_seconds += weft_now_seconds() - start;
    const enum weft_result res = weft_gl_check(r->log, r->gl, "uploading weights");
    if (res != WEFT_OK || done)
        return res;
    weft_error(r->log, "%zu bytes of weights could not be handed to GL", weight_bytes);
    return WEFT_ERR_GL;
}

static void write_samples(const struct runner *r, float *out)
{
    const struct axis *x = &r->axis[0], *y = &r->axis[1];
    const int row_floats = round_up(x->tap_count);
    const float factor = (float)ldexp(1.0, -r->care.scale_bits);
    for (int j = 0; j < y->tap_count; j++) {
        const float *row = r->params.samples + (size_t)y->sample[j] * (size_t)x->size;
        for (int i = 0; i < x->tap_count; i++)
            out[i] = row[x->sample[i]] * factor;
        for (int i = x->tap_count; i < row_floats; i++)
            out[i] = 0.0f;
        out += row_floats;
    }
}

static enum weft_result load_samples(struct runner *r)
{
    const size_t bytes =
        (size_t)round_up(r->axis[0].tap_count) * (size_t)r->axis[1].tap_count * sizeof(float);
    const double start = weft_now_seconds();
    float *source = weft_gl_buffer_map(r->gl, &r->source, bytes);
    if (source)
        write_samples(r, source);
    const bool done = source && weft_gl_buffer_unmap(r->gl, &r->source);
    r->report.uploaded_bytes += bytes;
    r->report.upload_seconds += weft_now_seconds() - start;
    const enum weft_result res = weft_gl_check(r->log, r->gl, "uploading samples");
    if (res != WEFT_OK || done)
        return res;
    weft_error(r->log, "%zu bytes of samples could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// ---- passes -------------------------------------------------------------------------------------

// From rows of `pitch` texels to `width` x `height` texels of the target.
static void draw(struct runner *r, int axis, const struct weft_gl_buffer *source, int pitch,
                 int width, int height)
{
    const GladGLContext *gl = r->gl;
    const GLuint program = r->programs[axis];
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, 0, "source", source);
    weft_gl_bind_buffer(gl, program, 1, "weights", &r->weights[axis]);
    weft_gl_bind_buffer(gl, program, 2, "first_taps", &r->first_taps[axis]);
    gl->Uniform1i(weft_gl_location(gl, program, "pitch"), pitch);
    weft_gl_target_bind(gl, &r->target, width, height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    r->report.passes++;
}

// Texture buffers are read several times faster than 2D textures on llvmpipe.
static enum weft_result copy_to_middle(const struct runner *r, int width, int height)
{
    const struct weft_gl_pixels out = {.width = width, .height = height, .type = GL_FLOAT};
    r->gl->BindBuffer(GL_PIXEL_PACK_BUFFER, r->middle.buffer);
    const enum weft_result res = weft_gl_target_read(r->log, r->gl, &r->target, &out);
    r->gl->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    return res;
}

static enum weft_result draw_rectangle(struct runner *r, int columns, int rows)
{
    const double start = weft_now_seconds();
    const int width = round_up(columns) / LANES;
    const int source_width = round_up(r->axis[0].tap_count) / LANES;
    enum weft_result res;
    if (r->first_axis == 0) {
        draw(r, 0, &r->source, source_width * LANES, width, r->axis[1].tap_count);
        res = copy_to_middle(r, width, r->axis[1].tap_count);
        draw(r, 1, &r->middle, width, width, rows);
    } else {
        draw(r, 1, &r->source, source_width, source_width, rows);
        res = copy_to_middle(r, source_width, rows);
        draw(r, 0, &r->middle, source_width * LANES, width, rows);
    }
    r->gl->Finish();
    r->report.pass_seconds += weft_now_seconds() - start;
    return res == WEFT_OK ? weft_gl_check(r->log, r->gl, "filtering") : res;
}

static enum weft_result read_back(struct runner *r, const struct rectangle *rectangle)
{
    const int columns = rectangle->size[0], rows = rectangle->size[1];
    const int width = round_up(columns) / LANES;
    const bool in_place = reads_in_place(r, columns);
    const double start = weft_now_seconds();
    float *out =
        r->params.pixels + (int64_t)rectangle->from[1] * r->params.stride + rectangle->from[0];
    const struct weft_gl_pixels to = {
        .width = width,
        .height = rows,
        .type = GL_FLOAT,
        .stride = in_place ? (int)(r->params.stride / LANES) : 0,
        .data = in_place ? out : r->staging,
    };
    const enum weft_result res = weft_gl_target_read(r->log, r->gl, &r->target, &to);
    for (int y = 0; !in_place && y < rows; y++)
        memcpy(out + y * r->params.stride, r->staging + (size_t)y * (size_t)width * LANES,
               (size_t)columns * sizeof *out);
    weft_separable_care_finish(&r->care, &r->params, rectangle->from, rectangle->size);
    r->report.readback_seconds += weft_now_seconds() - start;
    return res;
}

static enum weft_result run_rectangle(struct runner *r, const struct rectangle *rectangle)
{
    enum weft_result res = load_samples(r);
    if (res == WEFT_OK)
        res = draw_rectangle(r, rectangle->size[0], rectangle->size[1]);
    if (res == WEFT_OK)
        res = read_back(r, rectangle);
    r->report.rectangles++;
    return res;
}

static enum weft_result run_rectangles(struct runner *r)
{
    const struct axis *x = &r->axis[0], *y = &r->axis[1];
    const int strips = (x->positions + x->cut - 1) / x->cut;
    const double total = (double)strips * ((y->positions + y->cut - 1) / y->cut);
    enum weft_result res = WEFT_OK;
    for (int from_x = 0; from_x < x->positions; from_x += x->cut) {
        const int columns = smaller(x->cut, x->positions - from_x);
        res = load_axis(r, 0, from_x, columns);
        for (int from_y = 0; res == WEFT_OK && from_y < y->positions; from_y += y->cut) {
            const int rows = smaller(y->cut, y->positions - from_y);
            if (!weft_separable_go_on(r->params.progress, r->report.rectangles / total)) {
                weft_note(r->log, "separable filtering was cancelled at rectangle %d of %.0f",
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

static struct weft_separable_reach reach_of(const struct axis *a)
{
    // All taps are numbered, in order.
    return (struct weft_separable_reach){a->sample[0], a->sample[a->tap_count - 1]};
}

static enum weft_result prepare(struct runner *r)
{
    const double start = weft_now_seconds();
    enum weft_result res = find_taps(r, &r->axis[0]);
    if (res == WEFT_OK)
        res = find_taps(r, &r->axis[1]);
    if (res != WEFT_OK)
        return res;
    const struct weft_separable_reach reach[2] = {reach_of(&r->axis[0]), reach_of(&r->axis[1])};
    res = weft_separable_care_create(&r->params, reach, &r->care);
    if (res != WEFT_OK)
        return res;
    choose_order(r);
    res = choose_cut(r);
    if (res == WEFT_OK)
        res = find_programs(r);
    if (res == WEFT_OK)
        res = create_buffers(r);
    if (res == WEFT_OK)
        res = weft_gl_target_create(r->log, r->gl, GL_RGBA32F, r->sizes.target_width,
                                    r->sizes.target_height, &r->target);
    if (res == WEFT_OK)
        res = create_staging(r);
    r->report.peak_bytes = r->sizes.bytes;
    r->report.prepare_seconds = weft_now_seconds() - start;
    return res;
}

enum weft_result weft_separable_run(weft_context *context,
                                    const struct weft_separable_params *params,
                                    struct weft_separable_report *report)
{
    struct runner r = {.context = context, .gl = &context->gl, .log = params->log};
    enum weft_result res = weft_separable_check(params, &r.params);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    r.width = r.params.kernel.width;
    r.groups = (r.width + 3) / 4;
    r.axis[0] =
        (struct axis){.at = r.params.x, .positions = r.params.width, .size = r.params.size[0]};
    r.axis[1] =
        (struct axis){.at = r.params.y, .positions = r.params.height, .size = r.params.size[1]};
    res = prepare(&r);
    if (res == WEFT_OK)
        res = run_rectangles(&r);
    destroy(&r);
    weft_context_leave(context);
    if (res == WEFT_OK && report)
        *report = r.report;
    return res;
}
