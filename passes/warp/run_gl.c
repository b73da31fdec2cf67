// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/warp/gl.h"

// Pixels of a tile, at most, on software GLs and on others.
enum { TILE_COLUMNS = 1024, SOFTWARE_PIXELS = 1 << 16, HARDWARE_PIXELS = 1 << 20 };

// Samples from one to before another, along both axes.
struct area {
    int from[2], end[2];
};

struct runner {
    struct weft_warp_gl *c;
    const struct weft_warp_plan *plan;
    const struct weft_warp_run_params *params;
    const GladGLContext *gl;
    int channels, many; // many: 1 where there are more than one, four to a texel
    struct weft_warp_values values[WEFT_RESAMPLE_MAX_CHANNELS];
    bool plain;
    int scale_bits;       // samples are divided by 2^this, and pixels multiplied
    bool whole, uploaded; // all samples at once, and once for all tiles
    struct area loaded;
    double done, total; // pixels
    struct weft_resample_report *report;
};

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

// ---- pixels' entries ----------------------------------------------------------------------------

struct filling {
    struct runner *r;
    const struct weft_rectangle *tile;
    float *entries, *weights;
    struct area *areas; // of each thread
};

// What taps from one on reach, once the boundary has brought them back.
static void reach(const struct weft_warp_plan *plan, int axis, int first, int count,
                  struct area *area)
{
    const int size = plan->values[axis], last = first + count - 1;
    const bool near =
        plan->info.boundary == WEFT_BOUNDARY_CLAMP || plan->info.boundary == WEFT_BOUNDARY_BORDER;
    const bool out = first < 0 || last >= size;
    const int from = !out ? first : near ? smaller(larger(first, 0), size - 1) : 0;
    const int to = !out ? last : near ? smaller(larger(last, 0), size - 1) : size - 1;
    area->from[axis] = smaller(area->from[axis], from);
    area->end[axis] = larger(area->end[axis], to + 1);
}

static void fill_plain(const struct runner *r, const struct weft_warp_row *row, int count,
                       float *entry, struct area *area)
{
    const int width = r->plan->info.kernel.width;
    for (int i = 0; i < count; i++, entry += 4)
        for (int a = 0; a < 2; a++) {
            entry[a] = (float)row->first[a][i];
            entry[2 + a] = (float)row->fraction[a][i];
            reach(r->plan, a, row->first[a][i], width, area);
        }
}

static void fill_stretched(const struct runner *r, struct weft_warp_scratch *scratch,
                           const struct weft_warp_row *row, int count, float *entry, float *weights,
                           struct area *area)
{
    const int stride = r->plan->info.taps[0] + r->plan->info.taps[1];
    for (int i = 0; i < count; i++, entry += 4, weights += stride) {
        float *weight = weights;
        weft_warp_scratch_set(scratch, row, i);
        for (int a = 0; a < 2; a++) {
            entry[a] = (float)scratch->first[a];
            entry[2 + a] = (float)scratch->count[a];
            for (int k = 0; k < scratch->count[a]; k++)
                *weight++ = (float)scratch->weights[a][k];
            reach(r->plan, a, scratch->first[a], scratch->count[a], area);
        }
    }
}

static bool fill_row(void *priv, int thread, size_t number)
{
    const struct filling *f = priv;
    const struct runner *r = f->r;
    const struct weft_rectangle *t = f->tile;
    const size_t stride = (size_t)(r->plan->info.taps[0] + r->plan->info.taps[1]);
    for (int x = 0; x < t->width; x += WEFT_WARP_ROW) {
        const int count = smaller(WEFT_WARP_ROW, t->width - x);
        const size_t at = number * (size_t)t->width + (size_t)x;
        struct weft_warp_row row;
        weft_warp_row_set(r->plan, t->x + x, t->y + (int)number, count, &row);
        if (r->plan->stretches)
            fill_stretched(r, &r->c->scratch[thread], &row, count, f->entries + 4 * at,
                           f->weights + stride * at, &f->areas[thread]);
        else
            fill_plain(r, &row, count, f->entries + 4 * at, &f->areas[thread]);
    }
    return true;
}

// Writes what of a tile is uploaded; *area becomes what it reaches.
static enum weft_result fill(struct runner *r, const struct weft_rectangle *tile, float *entries,
                             float *weights, struct area *area)
{
    struct area *areas = calloc((size_t)r->c->threads, sizeof *areas);
    struct filling f = {r, tile, entries, weights, areas};
    if (!areas) {
        weft_error(r->params->log, "out of memory for %d threads of a warp", r->c->threads);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < r->c->threads; i++)
        areas[i] = (struct area){{INT_MAX, INT_MAX}, {0, 0}};
    weft_threads_run(r->c->threads, (size_t)tile->height, fill_row, &f);
    *area = areas[0];
    for (int i = 1; i < r->c->threads; i++)
        for (int a = 0; a < 2; a++) {
            area->from[a] = smaller(area->from[a], areas[i].from[a]);
            area->end[a] = larger(area->end[a], areas[i].end[a]);
        }
    free(areas);
    return WEFT_OK;
}

static enum weft_result upload_entries(struct runner *r, const struct weft_rectangle *tile,
                                       struct area *area)
{
    const double start = weft_now_seconds();
    const size_t pixels = (size_t)tile->width * (size_t)tile->height;
    const size_t stride =
        r->plan->stretches ? (size_t)(r->plan->info.taps[0] + r->plan->info.taps[1]) : 0;
    const struct weft_log *log = r->params->log;
    enum weft_result res = weft_gl_buffer_fit(log, r->gl, GL_RGBA32F, pixels, &r->c->entries);
    if (res == WEFT_OK && stride)
        res = weft_gl_buffer_fit(log, r->gl, GL_R32F, pixels * stride, &r->c->weights);
    if (res != WEFT_OK)
        return res;
    float *entries = weft_gl_buffer_map(r->gl, &r->c->entries, 16 * pixels);
    float *weights = stride ? weft_gl_buffer_map(r->gl, &r->c->weights, 4 * stride * pixels) : NULL;
    const bool mapped = entries && (weights || !stride);
    if (mapped)
        res = fill(r, tile, entries, weights, area);
    bool done = entries && weft_gl_buffer_unmap(r->gl, &r->c->entries);
    if (weights)
        done = weft_gl_buffer_unmap(r->gl, &r->c->weights) && done;
    r->report->work.prepare_seconds += weft_now_seconds() - start;
    r->report->work.uploaded_bytes += (16 + 4 * stride) * pixels;
    if (res == WEFT_OK)
        res = weft_gl_check(log, r->gl, "uploading positions");
    if (res != WEFT_OK || (mapped && done))
        return res;
    weft_error(log, "the positions of %zu pixels could not be handed to GL", pixels);
    return WEFT_ERR_GL;
}

// ---- samples ------------------------------------------------------------------------------------

static size_t area_texels(const struct area *area)
{
    return (size_t)(area->end[0] - area->from[0]) * (size_t)(area->end[1] - area->from[1]);
}

// Of samples, a quarter of what a run may take is left to the rest of it.
static bool fits(const struct runner *r, const struct area *area)
{
    const size_t texels = area_texels(area), bytes = texels * (r->many ? 16 : 4);
    return (int64_t)texels <= weft_context_get_info(r->c->context)->max_buffer_texels &&
           bytes <= r->plan->memory_bytes - r->plan->memory_bytes / 4;
}

struct packing {
    const struct runner *r;
    const struct area *area;
    float *out;
    float factor;
};

static bool pack_row(void *priv, int thread, size_t number)
{
    const struct packing *p = priv;
    const struct runner *r = p->r;
    const int columns = p->area->end[0] - p->area->from[0], step = r->many ? 4 : 1;
    const int64_t at = (p->area->from[1] + (int64_t)number) * r->values->stride + p->area->from[0];
    float *out = p->out + number * (size_t)columns * (size_t)step;
    (void)thread;
    for (int c = 0; c < step; c++)
        for (int i = 0; i < columns; i++)
            out[i * step + c] = c < r->channels ? r->values[c].plane[at + i] * p->factor : 0.0f;
    return true;
}

static enum weft_result upload_samples(struct runner *r, const struct area *area)
{
    const double start = weft_now_seconds();
    const size_t texels = area_texels(area), bytes = texels * (r->many ? 16 : 4);
    struct weft_gl_buffer *source = &r->c->source[r->many];
    enum weft_result res =
        weft_gl_buffer_fit(r->params->log, r->gl, r->many ? GL_RGBA32F : GL_R32F, texels, source);
    if (res != WEFT_OK)
        return res;
    struct packing p = {.r = r, .area = area, .factor = (float)ldexp(1.0, -r->scale_bits)};
    p.out = weft_gl_buffer_map(r->gl, source, bytes);
    if (p.out)
        weft_threads_run(r->c->threads, (size_t)(area->end[1] - area->from[1]), pack_row, &p);
    const bool done = p.out && weft_gl_buffer_unmap(r->gl, source);
    r->loaded = *area;
    r->uploaded = true;
    r->report->work.upload_seconds += weft_now_seconds() - start;
    r->report->work.uploaded_bytes += bytes;
    r->report->work.peak_bytes =
        bytes > r->report->work.peak_bytes ? bytes : r->report->work.peak_bytes;
    res = weft_gl_check(r->params->log, r->gl, "uploading samples");
    if (res != WEFT_OK || done)
        return res;
    weft_error(r->params->log, "%zu bytes of samples could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// ---- tiles --------------------------------------------------------------------------------------

static enum weft_result draw(struct runner *r, const struct weft_rectangle *tile)
{
    const double start = weft_now_seconds();
    const GladGLContext *gl = r->gl;
    const GLuint program = r->c->programs[!r->plain];
    struct weft_gl_target *target = &r->c->target[r->many];
    const float border = r->values->border * (float)ldexp(1.0, -r->scale_bits);
    enum weft_result res = weft_gl_target_fit(r->params->log, gl, r->many ? GL_RGBA32F : GL_R32F,
                                              tile->width, tile->height, target);
    if (res != WEFT_OK)
        return res;
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, 0, "source", &r->c->source[r->many]);
    weft_gl_bind_buffer(gl, program, 1, "entries", &r->c->entries);
    if (r->plan->stretches)
        weft_gl_bind_buffer(gl, program, 2, "weights", &r->c->weights);
    else
        weft_gl_kernel_bind(gl, program, 2, "kernel", &r->plan->weights->tiles, &r->c->kernel);
    gl->Uniform4i(weft_gl_location(gl, program, "area"), r->loaded.from[0], r->loaded.from[1],
                  r->loaded.end[0] - r->loaded.from[0], 0);
    gl->Uniform2i(weft_gl_location(gl, program, "size"), r->plan->values[0], r->plan->values[1]);
    gl->Uniform4f(weft_gl_location(gl, program, "border"), border, border, border, border);
    gl->Uniform1i(weft_gl_location(gl, program, "row_entries"), tile->width);
    weft_gl_target_bind(gl, target, tile->width, tile->height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Finish();
    r->report->work.draws++;
    r->report->work.pass_seconds += weft_now_seconds() - start;
    return weft_gl_check(r->params->log, gl, "warping");
}

static void unpack_row(const struct runner *r, const struct weft_rectangle *tile, int y)
{
    const struct weft_rectangle *part = &r->params->part;
    const int step = r->many ? 4 : 1;
    const float factor = (float)ldexp(1.0, r->scale_bits);
    const float *from = r->c->staging + (size_t)y * (size_t)tile->width * (size_t)step;
    for (int c = 0; c < r->channels; c++) {
        float *out =
            r->params->plane[c] + (tile->y + y - part->y) * r->params->stride + (tile->x - part->x);
        for (int i = 0; i < tile->width; i++)
            out[i] = from[i * step + c] * factor;
        for (int x = 0; r->plan->info.clamp && x < tile->width; x += WEFT_WARP_ROW) {
            const int count = smaller(WEFT_WARP_ROW, tile->width - x);
            struct weft_warp_row row;
            weft_warp_row_set(r->plan, tile->x + x, tile->y + y, count, &row);
            weft_warp_clamp(r->plan, r->params->source, c, &row, count, out + x);
        }
        weft_statistics_add(&r->report->pixels, out, (size_t)tile->width);
    }
}

static enum weft_result read_back(struct runner *r, const struct weft_rectangle *tile)
{
    const double start = weft_now_seconds();
    const size_t floats = (size_t)tile->width * (size_t)tile->height * (size_t)(r->many ? 4 : 1);
    if (floats > r->c->staging_floats) {
        free(r->c->staging);
        r->c->staging = malloc(floats * sizeof(float));
        r->c->staging_floats = r->c->staging ? floats : 0;
    }
    if (!r->c->staging) {
        weft_error(r->params->log, "out of memory for %zu pixels", floats);
        return WEFT_ERR_MEMORY;
    }
    const struct weft_gl_pixels to = {
        .width = tile->width, .height = tile->height, .type = GL_FLOAT, .data = r->c->staging};
    const enum weft_result res =
        weft_gl_target_read(r->params->log, r->gl, &r->c->target[r->many], &to);
    for (int y = 0; res == WEFT_OK && y < tile->height; y++)
        unpack_row(r, tile, y);
    r->report->work.readback_seconds += weft_now_seconds() - start;
    return res;
}

static enum weft_result make_tile(struct runner *r, const struct weft_rectangle *tile);

// Where a tile reaches more samples than there is room for, halves of it reach fewer.
static enum weft_result split(struct runner *r, const struct weft_rectangle *tile,
                              const struct area *area)
{
    struct weft_rectangle half[2] = {*tile, *tile};
    if (tile->width == 1 && tile->height == 1) {
        weft_error(
            r->params->log,
            "a warp whose pixel (%d, %d) reaches %zu samples: there is room for less in %llu "
            "bytes, or in one buffer of the context",
            tile->x, tile->y, area_texels(area), (unsigned long long)r->plan->memory_bytes);
        return WEFT_ERR_LIMIT;
    }
    if (tile->width >= tile->height) {
        half[0].width = tile->width / 2;
        half[1].x += half[0].width;
        half[1].width -= half[0].width;
    } else {
        half[0].height = tile->height / 2;
        half[1].y += half[0].height;
        half[1].height -= half[0].height;
    }
    const enum weft_result res = make_tile(r, &half[0]);
    return res == WEFT_OK ? make_tile(r, &half[1]) : res;
}

static enum weft_result make_tile(struct runner *r, const struct weft_rectangle *tile)
{
    struct area area;
    if (!weft_warp_go_on(r->params->progress, r->done / r->total)) {
        weft_note(r->params->log, "a warp was cancelled after %.0f of %.0f pixels", r->done,
                  r->total);
        return WEFT_ERR_CANCELLED;
    }
    enum weft_result res = upload_entries(r, tile, &area);
    if (res == WEFT_OK && !r->whole && !fits(r, &area))
        return split(r, tile, &area);
    if (res == WEFT_OK && !(r->whole && r->uploaded))
        res = upload_samples(
            r, r->whole ? &(struct area){{0, 0}, {r->plan->values[0], r->plan->values[1]}} : &area);
    if (res == WEFT_OK)
        res = draw(r, tile);
    if (res == WEFT_OK)
        res = read_back(r, tile);
    r->done += (double)tile->width * tile->height;
    r->report->work.tiles++;
    return res;
}

// As many columns and rows of tiles as there is room for: an entry, a texel that is drawn and one
// that is read back, and weights, of each pixel.
static enum weft_result choose_tile(const struct runner *r, int side[2])
{
    const struct weft_context_info *info = weft_context_get_info(r->c->context);
    const int64_t stride = r->plan->info.taps[0] + r->plan->info.taps[1];
    const int64_t bytes = 48 + (r->plan->stretches ? 4 * stride : 0);
    int64_t pixels = info->hardware ? HARDWARE_PIXELS : SOFTWARE_PIXELS;
    const int64_t room = (int64_t)(r->plan->memory_bytes / 4) / bytes;
    const int64_t texels = info->max_buffer_texels / (r->plan->stretches ? stride : 1);
    pixels = pixels < room ? pixels : room;
    pixels = pixels < texels ? pixels : texels;
    if (pixels < 1) {
        weft_error(
            r->params->log,
            "a warp with %lld weights a pixel: there is no room for one in %llu bytes, or in "
            "a buffer of %lld texels",
            (long long)stride, (unsigned long long)r->plan->memory_bytes,
            (long long)info->max_buffer_texels);
        return WEFT_ERR_LIMIT;
    }
    side[0] = smaller(smaller(TILE_COLUMNS, r->params->part.width),
                      smaller((int)pixels, info->max_target_size));
    side[1] =
        smaller(smaller((int)pixels / side[0], r->params->part.height), info->max_target_size);
    return WEFT_OK;
}

static enum weft_result run(struct runner *r)
{
    const struct weft_rectangle *part = &r->params->part;
    int side[2];
    r->whole = fits(r, &(struct area){{0, 0}, {r->plan->values[0], r->plan->values[1]}});
    enum weft_result res = weft_warp_find_program(r->c, !r->plain);
    if (res == WEFT_OK)
        res = choose_tile(r, side);
    for (int y = 0; res == WEFT_OK && y < part->height; y += side[1])
        for (int x = 0; res == WEFT_OK && x < part->width; x += side[0])
            res = make_tile(r, &(struct weft_rectangle){part->x + x, part->y + y,
                                                        smaller(side[0], part->width - x),
                                                        smaller(side[1], part->height - y)});
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (res == WEFT_OK)
        weft_warp_go_on(r->params->progress, 1.0);
    return res;
}

enum weft_result weft_warp_gl_run(struct weft_warp_gl *compiled,
                                  const struct weft_warp_run_params *params,
                                  struct weft_resample_report *report)
{
    struct runner r = {.c = compiled,
                       .plan = compiled->plan,
                       .params = params,
                       .gl = &compiled->context->gl,
                       .channels = params->source->info.channels,
                       .many = params->source->info.channels > 1,
                       .plain = weft_warp_is_plain(compiled->plan, params->source),
                       .scale_bits =
                           weft_warp_scale_bits(compiled->plan, &params->source->info.statistics),
                       .total = (double)params->part.width * params->part.height,
                       .report = report};
    for (int c = 0; c < r.channels; c++)
        r.values[c] = weft_warp_values(compiled->plan, params->source, c);
    enum weft_result res = weft_context_enter(compiled->context);
    if (res != WEFT_OK)
        return res;
    res = run(&r);
    weft_context_leave(compiled->context);
    return res;
}
