// SPDX-License-Identifier: BSD-3-Clause
#include <stdio.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "passes/multipass/job.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"

enum unit { UNIT_SOURCE, UNIT_TILES, UNIT_ENTRIES, UNIT_LOG_TABLE, UNIT_TARGET };

// Programs of one plan that differ in nothing else: more would drive each other from the cache.
enum { MAX_DIVISORS = 3 };

// llvmpipe takes all passes that are queued up through 64 x 64 pixels before it goes on to the next
// ones. Where the passes' tiles together are more than a core's cache, a pass at a time is faster:
// up to three times with dot4 on float targets.
enum { CACHE_BYTES = 1 << 20 };

struct runner {
    const struct weft_multipass_job *job;
    const struct weft_pass_list *passes;
    weft_context *context;
    const GladGLContext *gl;
    const struct weft_log *log;
    int channels;
    bool divisor_is_uniform, has_bias;
    bool fetches_targets; // GL_EXT_shader_framebuffer_fetch: no copy of what is read
    struct weft_gl_buffer source, tiles, entries, log_table;
    int target_count; // the slots' and, if any pass needs it, one more to write beside them
    struct weft_gl_target *targets;
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

static enum weft_result create_buffer(const struct runner *r, GLenum format, const void *data,
                                      size_t bytes, struct weft_gl_buffer *out)
{
    const GladGLContext *gl = r->gl;
    *out = (struct weft_gl_buffer){.format = format, .size_bytes = bytes};
    gl->GenBuffers(1, &out->buffer);
    gl->BindBuffer(GL_TEXTURE_BUFFER, out->buffer);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, data, GL_STATIC_DRAW);
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(GL_TEXTURE_BUFFER, out->texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, format, out->buffer);
    return weft_gl_check(r->log, gl, "creating a texture buffer");
}

static enum weft_result create_values(const struct runner *r, const struct weft_job_values *values,
                                      struct weft_gl_buffer *out)
{
    static const GLenum formats[][2] = {
        [WEFT_VALUE_UINT8] = {GL_R8UI, GL_RGBA8UI},
        [WEFT_VALUE_UINT16] = {GL_R16UI, GL_RGBA16UI},
        [WEFT_VALUE_FLOAT] = {GL_R32F, GL_RGBA32F},
    };
    return create_buffer(r, formats[values->type][values->components == 4], values->data,
                         values->bytes, out);
}

static enum weft_result upload(struct runner *r)
{
    const struct weft_multipass_job *job = r->job;
    enum weft_result res = create_values(r, &job->source, &r->source);
    if (res == WEFT_OK)
        res = create_values(r, &job->tiles, &r->tiles);
    if (res == WEFT_OK)
        res = create_buffer(r, GL_RG32UI, job->entries, job->pixels * sizeof *job->entries,
                            &r->entries);
    if (res == WEFT_OK && r->passes->log_table)
        res =
            create_buffer(r, GL_R32UI, r->passes->log_table,
                          (2 * (size_t)job->one + 1) * sizeof *r->passes->log_table, &r->log_table);
    return res;
}

static bool has_framebuffer_fetch(const GladGLContext *gl)
{
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        const char *name = (const char *)gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (name && strcmp(name, "GL_EXT_shader_framebuffer_fetch") == 0)
            return true;
    }
    return false;
}

static bool writes_beside(const struct runner *r)
{
    for (int p = 0; p < r->passes->pass_count; p++) {
        const struct weft_pass *pass = &r->passes->passes[p];
        if (pass->kind == WEFT_PASS_COMBINE || (pass->reads_target && !r->fetches_targets))
            return true;
    }
    return false;
}

static enum weft_result create_targets(struct runner *r)
{
    const GLenum format = target_formats[r->passes->target].format[r->channels == 4];
    enum weft_result res = WEFT_OK;
    r->target_count = r->passes->slot_count + writes_beside(r);
    r->targets = calloc((size_t)r->target_count, sizeof *r->targets);
    if (!r->targets) {
        weft_error(r->log, "convolution: not enough memory for %d targets", r->target_count);
        return WEFT_ERR_MEMORY;
    }
    for (int t = 0; res == WEFT_OK && t < r->target_count; t++)
        res = weft_gl_target_create(r->log, r->gl, format, r->job->grid->width,
                                    r->job->grid->height, &r->targets[t]);
    return res;
}

static void choose_defines(struct runner *r)
{
    int divisors[MAX_DIVISORS], count = 0;
    for (int p = 0; p < r->passes->pass_count; p++) {
        const struct weft_pass *pass = &r->passes->passes[p];
        if (pass->kind != WEFT_PASS_TAPS)
            continue;
        r->has_bias = r->has_bias || pass->bias != 0;
        int i = 0;
        while (i < count && divisors[i] != pass->divisor)
            i++;
        r->divisor_is_uniform = r->divisor_is_uniform || i == MAX_DIVISORS;
        if (i == count && count < MAX_DIVISORS)
            divisors[count++] = pass->divisor;
    }
}

static void set_state(struct runner *r)
{
    const GladGLContext *gl = r->gl;
    gl->Disable(GL_BLEND);
    gl->Disable(GL_DITHER);
    gl->BlendFunc(GL_ONE, GL_ONE);
    gl->Viewport(0, 0, r->job->grid->width, r->job->grid->height);
}

static void destroy(struct runner *r)
{
    const GladGLContext *gl = r->gl;
    gl->Disable(GL_BLEND);
    gl->Enable(GL_DITHER);
    gl->BlendFunc(GL_ONE, GL_ZERO);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->UseProgram(0);
    for (int t = 0; r->targets && t < r->target_count; t++)
        weft_gl_target_destroy(gl, &r->targets[t]);
    free(r->targets);
    weft_gl_buffer_destroy(gl, &r->source);
    weft_gl_buffer_destroy(gl, &r->tiles);
    weft_gl_buffer_destroy(gl, &r->entries);
    weft_gl_buffer_destroy(gl, &r->log_table);
}

// ---- passes that add taps -----------------------------------------------------------------------

static int shader_groups(const struct weft_pass *pass)
{
    return pass->group_count > 0 ? pass->group_count : 1; // GLSL has no empty arrays
}

// Of the components that have a tile. With logarithms those without need their zero, elsewhere
// their weights are 0.
static bool common_factor(const struct runner *r, const struct weft_pass *pass,
                          const struct weft_tap_group *group, int *out)
{
    bool any = false;
    *out = 0;
    for (int c = 0; c < (r->passes->dot4 ? 4 : 1); c++) {
        const int factor = weft_multipass_job_factor(r->job, pass, group, c);
        if (group->tile[c] < 0 && !r->passes->log_table)
            continue;
        if (any && factor != *out)
            return false;
        any = true;
        *out = factor;
    }
    return true;
}

static bool has_one_factor(const struct runner *r, const struct weft_pass *pass)
{
    int factor;
    for (int g = pass->group_first; g < pass->group_first + pass->group_count; g++)
        if (!common_factor(r, pass, &r->passes->groups[g], &factor))
            return false;
    return true;
}

// Blending whole passes that subtract differ from others by factors and blend equation only.
static bool shader_subtracts(const struct weft_pass *pass)
{
    return pass->subtract && (pass->reads_target || pass->part != WEFT_PASS_WHOLE);
}

static enum weft_result find_program(const struct runner *r, const struct weft_pass *pass,
                                     GLuint *out)
{
    const struct weft_multipass_job *job = r->job;
    const struct weft_pass_list *l = r->passes;
    const int reads = !pass->reads_target ? 0 : r->fetches_targets ? 2 : 1;
    char divisor[16] = "divisor", limit[32] = "", defines[768];
    if (!r->divisor_is_uniform)
        snprintf(divisor, sizeof divisor, "%d", pass->divisor);
    if (job->limit < INT_MAX)
        snprintf(limit, sizeof limit, "#define LIMIT %d\n", job->limit);
    snprintf(defines, sizeof defines,
             "%s#define FLOATS %d\n#define ONE %d\n#define EXTRA_BITS %d\n#define DIVISOR %s\n"
             "#define GROUPS %d\n#define DOT4 %d\n#define SPLIT_DOT %d\n#define FACTORS %d\n"
             "#define CHANNELS %d\n#define DIMS %d\n#define PART %d\n#define SUBTRACT %d\n"
             "#define READS_TARGET %d\n#define EXACT %d\n#define HAS_BIAS %d\n"
             "#define LOGARITHMS %d\n#define POSITIONS %d\n#define POSITION_BITS %d\n%s",
             reads > 1 ? "#extension GL_EXT_shader_framebuffer_fetch : require\n" : "", job->floats,
             job->one, job->extra_bits, divisor, shader_groups(pass), l->dot4, l->dot_width == 3,
             has_one_factor(r, pass) ? 1 : 4, r->channels, l->dims, (int)pass->part,
             shader_subtracts(pass), reads, l->exact_inside, r->has_bias, l->log_table != NULL,
             (int)job->positions, job->position_bits, limit);
    return weft_program_get(r->context, "convolve", defines, weft_shader_full_target,
                            weft_shader_convolve, out);
}

static void set_places(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    GLint offset[WEFT_PASS_MAX_GROUPS] = {0}, base[WEFT_PASS_MAX_GROUPS] = {0};
    GLint step[WEFT_PASS_MAX_GROUPS][3] = {{0}}, flip[WEFT_PASS_MAX_GROUPS] = {0};
    const int count = shader_groups(pass);
    for (int g = 0; g < pass->group_count; g++) {
        const struct weft_job_group *place = &r->job->groups[pass->group_first + g];
        offset[g] = place->source_offset;
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
    const int count = shader_groups(pass), components = has_one_factor(r, pass) ? 1 : 4;
    for (int g = 0; g < pass->group_count; g++) {
        const struct weft_tap_group *group = &r->passes->groups[pass->group_first + g];
        if (!common_factor(r, pass, group, &factor[components * g]) || components == 4)
            for (int c = 0; c < 4; c++)
                factor[4 * g + c] = weft_multipass_job_factor(r->job, pass, group, c);
    }
    for (int i = 0; i < components * count; i++)
        weight[i] = weft_multipass_job_weight(pass, factor[i]);
    const GladGLContext *gl = r->gl;
    const GLint at = weft_gl_location(gl, program, "factor");
    if (r->job->floats && components == 1)
        gl->Uniform1fv(at, count, weight);
    else if (r->job->floats)
        gl->Uniform4fv(at, count, weight);
    else if (components == 1)
        gl->Uniform1iv(at, count, factor);
    else
        gl->Uniform4iv(at, count, factor);
}

static void set_numbers(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const bool divides = !r->job->floats && r->passes->exact_inside && !r->passes->log_table;
    const int bias = pass->subtract ? -pass->bias : pass->bias;
    const GLint at = weft_gl_location(r->gl, program, "bias");
    r->gl->Uniform1i(weft_gl_location(r->gl, program, "divisor"), pass->divisor);
    if (r->job->floats)
        r->gl->Uniform1f(at, (GLfloat)bias);
    else
        r->gl->Uniform1i(at, divides ? bias * pass->divisor : bias);
}

static void clear(const struct runner *r, const struct weft_pass *pass)
{
    const int one = r->job->floats ? 1 : r->job->one;
    const GLfloat value = (GLfloat)((double)pass->initial / one);
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->targets[pass->target].framebuffer);
    r->gl->ClearColor(value, value, value, value);
    r->gl->Clear(GL_COLOR_BUFFER_BIT);
}

static void swap_with_scratch(struct runner *r, int slot)
{
    const struct weft_gl_target old = r->targets[slot];
    r->targets[slot] = r->targets[r->passes->slot_count];
    r->targets[r->passes->slot_count] = old;
}

static void draw_beside(struct runner *r, int slot)
{
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->targets[r->passes->slot_count].framebuffer);
    r->gl->DrawArrays(GL_TRIANGLES, 0, 3);
    swap_with_scratch(r, slot);
}

static void draw_over(const struct runner *r, int slot)
{
    r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->targets[slot].framebuffer);
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

static enum weft_result add_taps(struct runner *r, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    GLuint program;
    const enum weft_result res = find_program(r, pass, &program);
    if (res != WEFT_OK)
        return res;
    if (pass->clears)
        clear(r, pass);
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, UNIT_SOURCE, "source", &r->source);
    weft_gl_bind_buffer(gl, program, UNIT_TILES, "tiles", &r->tiles);
    weft_gl_bind_buffer(gl, program, UNIT_ENTRIES, "entries", &r->entries);
    if (r->passes->log_table)
        weft_gl_bind_buffer(gl, program, UNIT_LOG_TABLE, "log_table", &r->log_table);
    set_places(r, program, pass);
    set_factors(r, program, pass);
    set_numbers(r, program, pass);
    if (pass->reads_target && r->fetches_targets) {
        draw_over(r, pass->target);
    } else if (pass->reads_target) {
        weft_gl_bind_texture(gl, program, UNIT_TARGET, "target", GL_TEXTURE_2D,
                             r->targets[pass->target].texture);
        draw_beside(r, pass->target);
    } else {
        draw_blended(r, pass);
    }
    return WEFT_OK;
}

// ---- passes that combine ------------------------------------------------------------------------

static enum weft_result find_combining_program(const struct runner *r, const struct weft_pass *pass,
                                               GLuint *out)
{
    char defines[256];
    snprintf(defines, sizeof defines,
             "#define FLOATS %d\n#define INPUTS %d\n#define ONE %d\n#define EXTRA_BITS %d\n"
             "#define EXACT %d\n#define DENOMINATOR %d\n#define CHANNELS %d\n",
             r->job->floats, pass->input_count, r->job->one, r->job->extra_bits,
             r->passes->exact_inside, pass->denominator, r->channels);
    return weft_program_get(r->context, "combine", defines, weft_shader_full_target,
                            weft_shader_combine, out);
}

static void set_inputs(const struct runner *r, GLuint program, const struct weft_pass *pass)
{
    const GladGLContext *gl = r->gl;
    GLint unit[WEFT_PASS_MAX_INPUTS], factor[WEFT_PASS_MAX_INPUTS];
    GLfloat weight[WEFT_PASS_MAX_INPUTS];
    for (int i = 0; i < pass->input_count; i++) {
        unit[i] = i;
        factor[i] = weft_multipass_job_numerator(r->job, pass, i);
        weight[i] = (GLfloat)((double)pass->numerator[i] / pass->denominator);
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        gl->BindTexture(GL_TEXTURE_2D, r->targets[pass->input[i]].texture);
    }
    gl->ActiveTexture(GL_TEXTURE0);
    gl->Uniform1iv(weft_gl_location(gl, program, "targets"), pass->input_count, unit);
    if (r->job->floats) {
        gl->Uniform1fv(weft_gl_location(gl, program, "factor"), pass->input_count, weight);
        gl->Uniform1f(weft_gl_location(gl, program, "bias"),
                      (GLfloat)((double)pass->bias / pass->denominator));
    } else {
        gl->Uniform1iv(weft_gl_location(gl, program, "factor"), pass->input_count, factor);
        gl->Uniform1i(weft_gl_location(gl, program, "bias"), weft_multipass_job_bias(r->job, pass));
    }
}

static enum weft_result combine(struct runner *r, const struct weft_pass *pass)
{
    GLuint program;
    const enum weft_result res = find_combining_program(r, pass, &program);
    if (res != WEFT_OK)
        return res;
    r->gl->UseProgram(program);
    set_inputs(r, program, pass);
    draw_beside(r, pass->target);
    return WEFT_OK;
}

// ---- running ------------------------------------------------------------------------------------

static enum weft_result draw_passes(struct runner *r, const struct weft_progress *progress)
{
    for (int p = 0; p < r->passes->pass_count; p++) {
        const struct weft_pass *pass = &r->passes->passes[p];
        if (!weft_job_go_on(progress, (double)p / r->passes->pass_count))
            return WEFT_ERR_CANCELLED;
        const enum weft_result res =
            pass->kind == WEFT_PASS_COMBINE ? combine(r, pass) : add_taps(r, pass);
        if (res != WEFT_OK)
            return res;
        if (r->job->tiles.bytes > CACHE_BYTES)
            r->gl->Flush();
    }
    r->gl->Finish();
    return weft_gl_check(r->log, r->gl, "drawing the passes");
}

static enum weft_result read_back(const struct runner *r, float *const pixels[4],
                                  struct weft_multipass_report *report)
{
    void *result = calloc(r->job->pixels, (size_t)r->channels * sizeof(float));
    if (!result) {
        weft_error(r->log, "convolution: not enough memory for %zu pixels", r->job->pixels);
        return WEFT_ERR_MEMORY;
    }
    const struct weft_gl_pixels out = {
        .width = r->job->grid->width,
        .height = r->job->grid->height,
        .type = target_formats[r->passes->target].type,
        .data = result,
    };
    const enum weft_result res =
        weft_gl_target_read(r->log, r->gl, &r->targets[r->passes->result], &out);
    if (res == WEFT_OK)
        weft_multipass_job_finish(r->job, result, pixels, report);
    free(result);
    return res;
}

static enum weft_result run(struct runner *r, const struct weft_multipass_params *params,
                            struct weft_multipass_report *report)
{
    const double start = weft_now_seconds();
    set_state(r);
    r->fetches_targets = !r->job->work->portable && has_framebuffer_fetch(r->gl);
    enum weft_result res = upload(r);
    if (res == WEFT_OK)
        res = create_targets(r);
    const double uploaded = weft_now_seconds();
    if (res == WEFT_OK)
        res = draw_passes(r, params->progress);
    const double drawn = weft_now_seconds();
    if (res == WEFT_OK)
        res = read_back(r, params->pixels, report);
    report->upload_seconds = uploaded - start;
    report->pass_seconds = drawn - uploaded;
    report->readback_seconds = weft_now_seconds() - drawn;
    report->target_bytes = (uint64_t)r->target_count * r->job->pixels * (uint64_t)r->channels *
                           target_formats[r->passes->target].bytes;
    return res;
}

enum weft_result weft_multipass_run_work(weft_context *context,
                                         const struct weft_multipass_work *work,
                                         const struct weft_multipass_params *params,
                                         struct weft_multipass_report *report)
{
    const struct weft_job_limits limits = {context->info.max_buffer_texels,
                                           context->info.max_target_size};
    struct weft_multipass_report figures = {0};
    struct weft_multipass_job job;
    const double start = weft_now_seconds();
    enum weft_result res = weft_multipass_job_create(work, params, &limits, &job);
    if (res != WEFT_OK)
        return res;
    figures.prepare_seconds = weft_now_seconds() - start;
    struct runner r = {
        .job = &job,
        .passes = job.passes,
        .context = context,
        .gl = &context->gl,
        .log = params->log,
        .channels = work->channels,
    };
    choose_defines(&r);
    res = weft_context_enter(context);
    if (res != WEFT_OK)
        goto fail;
    res = run(&r, params, &figures);
    destroy(&r);
    weft_context_leave(context);
    if (res == WEFT_OK)
        weft_job_go_on(params->progress, 1.0);
    if (res == WEFT_OK && report)
        *report = figures;
fail:
    weft_multipass_job_destroy(&job);
    return res;
}

enum weft_result weft_multipass_run(weft_context *context,
                                    const struct weft_multipass_params *params,
                                    struct weft_multipass_report *report)
{
    struct weft_multipass_work work;
    const enum weft_result res = weft_multipass_plan_work(params, &work);
    return res == WEFT_OK ? weft_multipass_run_work(context, &work, params, report) : res;
}
