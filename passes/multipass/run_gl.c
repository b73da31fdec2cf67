// SPDX-License-Identifier: BSD-3-Clause
#include <stdlib.h>

#include "passes/multipass/gl.h"

enum { UNIT_SOURCE, UNIT_TILES, UNIT_ENTRIES, UNIT_LOG_TABLE, UNIT_TARGET };

// llvmpipe takes all passes that are queued up through 64 x 64 pixels before it goes on to the next
// ones. Where the passes' tiles together are more than a core's cache, a pass at a time is faster:
// up to three times with dot4 on float targets.
enum { CACHE_BYTES = 1 << 20 };

// A run; g is the compiled plan's m->gl.
struct runner {
    const struct weft_multipass_job *job;
    const struct weft_multipass *m;
    struct weft_multipass_gl *g;
    const GladGLContext *gl;
    struct weft_multipass_report *report;
};

static const struct {
    GLenum format[2], type; // of 1 and 4 channels; of their texels that are read back
    size_t bytes;           // of a channel
} target_formats[] = {
    [WEFT_TARGET_UNORM8] = {{GL_R8, GL_RGBA8}, GL_UNSIGNED_BYTE, 1},
    [WEFT_TARGET_UNORM16] = {{GL_R16, GL_RGBA16}, GL_UNSIGNED_SHORT, 2},
    [WEFT_TARGET_HALF] = {{GL_R16F, GL_RGBA16F}, GL_FLOAT, 2},
    [WEFT_TARGET_FLOAT] = {{GL_R32F, GL_RGBA32F}, GL_FLOAT, 4},
};

// ---- set-up -------------------------------------------------------------------------------------

static enum weft_result upload(const struct runner *r)
{
    const struct weft_multipass_job *job = r->job;
    const size_t bytes = job->pixels * sizeof *job->entries;
    enum weft_result res = weft_multipass_gl_load(r->job->log, r->gl, &job->source, &r->g->source);
    if (res == WEFT_OK)
        res =
            weft_gl_buffer_load(r->job->log, r->gl, GL_RG32UI, job->entries, bytes, &r->g->entries);
    r->report->uploaded_bytes = job->source.bytes + bytes;
    return res;
}

static enum weft_result fit_targets(const struct runner *r)
{
    const int channels = r->m->work.channels;
    const GLenum format = target_formats[r->m->passes->target].format[channels == 4];
    const size_t texel = (size_t)channels * target_formats[r->m->passes->target].bytes;
    enum weft_result res = WEFT_OK;
    for (int t = 0; res == WEFT_OK && t < r->g->target_count; t++) {
        const struct weft_gl_target *target = &r->g->targets[t];
        res = weft_gl_target_fit(r->job->log, r->gl, format, r->job->grid->width,
                                 r->job->grid->height, &r->g->targets[t]);
        r->report->target_bytes += (uint64_t)target->width * (uint64_t)target->height * texel;
    }
    return res;
}

static void set_state(const struct runner *r)
{
    const GladGLContext *gl = r->gl;
    gl->Disable(GL_BLEND);
    gl->Disable(GL_DITHER);
    gl->BlendFunc(GL_ONE, GL_ONE);
    gl->Viewport(0, 0, r->job->grid->width, r->job->grid->height);
}

static void reset_state(const GladGLContext *gl)
{
    gl->Disable(GL_BLEND);
    gl->Enable(GL_DITHER);
    gl->BlendFunc(GL_ONE, GL_ZERO);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->UseProgram(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

// ---- passes that add taps -----------------------------------------------------------------------

static void set_places(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    GLint offset[WEFT_PASS_MAX_GROUPS] = {0}, base[WEFT_PASS_MAX_GROUPS] = {0};
    GLint step[WEFT_PASS_MAX_GROUPS][3] = {{0}}, flip[WEFT_PASS_MAX_GROUPS] = {0};
    const int count = weft_multipass_shader_groups(pass);
    for (int g = 0; g < pass->group_count; g++) {
        const struct weft_job_group *place = &r->m->groups[pass->group_first + g];
        offset[g] = r->job->source_offset[pass->group_first + g];
        base[g] = place->tile_base;
        flip[g] = place->tile_flip;
        for (int a = 0; a < 3; a++)
            step[g][a] = place->tile_step[a];
    }
    gl->Uniform1i(weft_gl_location(gl, program, "row_entries"), r->job->grid->width);
    gl->Uniform1iv(weft_gl_location(gl, program, "source_offset"), count, offset);
    gl->Uniform1iv(weft_gl_location(gl, program, "tile_base"), count, base);
    gl->Uniform1iv(weft_gl_location(gl, program, "tile_flip"), count, flip);
    gl->Uniform3iv(weft_gl_location(gl, program, "tile_step"), count, step[0]);
}

static void set_factors(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    GLint factor[4 * WEFT_PASS_MAX_GROUPS] = {0};
    GLfloat weight[4 * WEFT_PASS_MAX_GROUPS];
    const int count = weft_multipass_shader_groups(pass),
              components = weft_multipass_has_one_factor(r->m, pass) ? 1 : 4;
    for (int g = 0; g < pass->group_count; g++) {
        const struct weft_tap_group *group = &r->m->passes->groups[pass->group_first + g];
        if (!weft_multipass_common_factor(r->m, pass, group, &factor[components * g]) ||
            components == 4)
            for (int c = 0; c < 4; c++)
                factor[4 * g + c] = weft_multipass_factor(r->m, pass, group, c);
    }
    for (int i = 0; i < components * count; i++)
        weight[i] = weft_multipass_weight(pass, factor[i]);
    const GladGLContext *gl = r->gl;
    const GLint at = weft_gl_location(gl, program, "factor");
    if (r->m->floats && components == 1)
        gl->Uniform1fv(at, count, weight);
    else if (r->m->floats)
        gl->Uniform4fv(at, count, weight);
    else if (components == 1)
        gl->Uniform1iv(at, count, factor);
    else
        gl->Uniform4iv(at, count, factor);
}

static void set_numbers(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const bool divides = !r->m->floats && r->m->passes->exact_inside && !r->m->passes->log_table;
    const int bias = pass->subtract ? -pass->bias : pass->bias;
    const GLint at = weft_gl_location(r->gl, program, "bias");
    r->gl->Uniform1i(weft_gl_location(r->gl, program, "divisor"), pass->divisor);
    if (r->m->floats)
        r->gl->Uniform1f(at, (GLfloat)bias);
    else
        r->gl->Uniform1i(at, divides ? bias * pass->divisor : bias);
}

static void clear(const struct runner *r, const struct weft_pass *pass)
{
    const int one = r->m->floats ? 1 : r->m->one;
    const GLfloat value = (GLfloat)((double)pass->initial / one);
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->g->targets[pass->target].framebuffer);
    r->gl->ClearColor(value, value, value, value);
    r->gl->Clear(GL_COLOR_BUFFER_BIT);
}

static void swap_with_scratch(const struct runner *r, int slot)
{
    const struct weft_gl_target old = r->g->targets[slot];
    r->g->targets[slot] = r->g->targets[r->m->passes->slot_count];
    r->g->targets[r->m->passes->slot_count] = old;
}

static void draw_beside(const struct runner *r, int slot)
{
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->g->targets[r->m->passes->slot_count].framebuffer);
    r->gl->DrawArrays(GL_TRIANGLES, 0, 3);
    swap_with_scratch(r, slot);
}

static void draw_over(const struct runner *r, int slot)
{
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->g->targets[slot].framebuffer);
    r->gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

static void draw_blended(const struct runner *r, const struct weft_pass *pass)
{
    const bool falls = pass->subtract && pass->part != WEFT_PASS_LOW;
    r->gl->Enable(GL_BLEND);
    r->gl->BlendEquation(falls ? GL_FUNC_REVERSE_SUBTRACT : GL_FUNC_ADD);
    draw_over(r, pass->target);
    r->gl->Disable(GL_BLEND);
}

static void add_taps(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    if (pass->clears)
        clear(r, pass);
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, UNIT_SOURCE, "source", &r->g->source);
    weft_gl_bind_buffer(gl, program, UNIT_TILES, "tiles", &r->g->tiles);
    weft_gl_bind_buffer(gl, program, UNIT_ENTRIES, "entries", &r->g->entries);
    if (r->m->passes->log_table)
        weft_gl_bind_buffer(gl, program, UNIT_LOG_TABLE, "log_table", &r->g->log_table);
    set_places(r, program, pass);
    set_factors(r, program, pass);
    set_numbers(r, program, pass);
    if (pass->reads_target && r->g->fetches_targets) {
        draw_over(r, pass->target);
    } else if (pass->reads_target) {
        weft_gl_bind_texture(gl, program, UNIT_TARGET, "target", GL_TEXTURE_2D,
                             r->g->targets[pass->target].texture);
        draw_beside(r, pass->target);
    } else {
        draw_blended(r, pass);
    }
}

// ---- passes that combine ------------------------------------------------------------------------

static void set_inputs(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    GLint unit[WEFT_PASS_MAX_INPUTS], factor[WEFT_PASS_MAX_INPUTS];
    GLfloat weight[WEFT_PASS_MAX_INPUTS];
    for (int i = 0; i < pass->input_count; i++) {
        unit[i] = i;
        factor[i] = weft_multipass_numerator(r->m, pass, i);
        weight[i] = (GLfloat)((double)pass->numerator[i] / pass->denominator);
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        gl->BindTexture(GL_TEXTURE_2D, r->g->targets[pass->input[i]].texture);
    }
    gl->ActiveTexture(GL_TEXTURE0);
    gl->Uniform1iv(weft_gl_location(gl, program, "targets"), pass->input_count, unit);
    if (r->m->floats) {
        gl->Uniform1fv(weft_gl_location(gl, program, "factor"), pass->input_count, weight);
        gl->Uniform1f(weft_gl_location(gl, program, "bias"),
                      (GLfloat)((double)pass->bias / pass->denominator));
    } else {
        gl->Uniform1iv(weft_gl_location(gl, program, "factor"), pass->input_count, factor);
        gl->Uniform1i(weft_gl_location(gl, program, "bias"), weft_multipass_bias(r->m, pass));
    }
}

static void combine(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    r->gl->UseProgram(program);
    set_inputs(r, program, pass);
    draw_beside(r, pass->target);
}

// ---- running ------------------------------------------------------------------------------------

static enum weft_result draw_passes(const struct runner *r)
{
    const struct weft_pass_list *l = r->m->passes;
    for (int p = 0; p < l->pass_count; p++) {
        if (!weft_job_go_on(r->job->params->progress, (double)p / l->pass_count))
            return WEFT_ERR_CANCELLED;
        (l->passes[p].kind == WEFT_PASS_COMBINE ? combine : add_taps)(r, r->g->programs[p],
                                                                      &l->passes[p]);
        if (r->m->tiles.bytes > CACHE_BYTES)
            r->gl->Flush();
    }
    r->gl->Finish();
    return weft_gl_check(r->job->log, r->gl, "drawing the passes");
}

static enum weft_result read_back(const struct runner *r)
{
    const size_t channels = (size_t)r->m->work.channels;
    void *result = calloc(r->job->pixels, channels * sizeof(float));
    if (!result) {
        weft_error(r->job->log, "convolution: not enough memory for %zu pixels", r->job->pixels);
        return WEFT_ERR_MEMORY;
    }
    const struct weft_gl_pixels out = {
        .width = r->job->grid->width,
        .height = r->job->grid->height,
        .type = target_formats[r->m->passes->target].type,
        .data = result,
    };
    const enum weft_result res =
        weft_gl_target_read(r->job->log, r->gl, &r->g->targets[r->m->passes->result], &out);
    if (res == WEFT_OK)
        weft_multipass_job_finish(r->job, result, r->report);
    free(result);
    return res;
}

static enum weft_result run(const struct runner *r)
{
    const double start = weft_now_seconds();
    set_state(r);
    enum weft_result res = upload(r);
    if (res == WEFT_OK)
        res = fit_targets(r);
    const double uploaded = weft_now_seconds();
    if (res == WEFT_OK)
        res = draw_passes(r);
    const double drawn = weft_now_seconds();
    if (res == WEFT_OK)
        res = read_back(r);
    reset_state(r->gl);
    r->report->upload_seconds = uploaded - start;
    r->report->pass_seconds = drawn - uploaded;
    r->report->readback_seconds = weft_now_seconds() - drawn;
    return res;
}

enum weft_result weft_multipass_gl_run(const struct weft_multipass_job *job,
                                       struct weft_multipass_report *report)
{
    const struct weft_multipass *m = job->compiled;
    weft_context *context = m->gl->context;
    const struct runner r = {.job = job, .m = m, .g = m->gl, .gl = &context->gl, .report = report};
    const int linked = context->programs_linked;
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = run(&r);
    weft_context_leave(context);
    report->programs_linked = context->programs_linked - linked;
    return res;
}
