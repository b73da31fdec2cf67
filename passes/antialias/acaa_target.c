// SPDX-License-Identifier: BSD-3-Clause
// What GL holds for accumulative anti-aliasing: depths at all samples, and sums in an array of
// textures.
#include <inttypes.h>
#include <math.h>

#include "filter/check.h"
#include "passes/antialias/acaa_impl.h"
#include "passes/gl/program.h"

// What is kept of a caller's context.
_Static_assert((int)WEFT_ACAA_PASS_BINDING == (int)WEFT_GL_STATE_UNIFORM, "another binding");
_Static_assert((int)WEFT_ACAA_TABLE_UNIT < (int)WEFT_GL_STATE_IMAGES, "more image units");

// As weft_pass in acaa_head.glsl has them.
struct pass_block {
    int32_t size[2], first[2];
    float scale, range;
    int32_t rows, unused;
};

// ---- creating -----------------------------------------------------------------------------------

static enum weft_result check_framebuffer(const struct weft_acaa *a, const char *what)
{
    const struct weft_log *log = a->params.log;
    const GladGLContext *gl = &a->params.context->gl;
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    const enum weft_result res = weft_gl_check(log, gl, what);
    if (res != WEFT_OK || status == GL_FRAMEBUFFER_COMPLETE)
        return res;
    weft_error(log,
               "acaa: GL makes no framebuffer (0x%04x) for %s of %" PRId32 " x %" PRId32
               " pixels with %d samples in a pass",
               status, what, a->target.width, a->target.height, a->plan.pattern.device_count);
    return WEFT_ERR_GL;
}

static enum weft_result make_depth(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    struct weft_acaa_target *t = &a->target;
    const enum weft_result res = weft_depth_buffer_create(
        p->log, gl, t->width, t->height, a->plan.pattern.device_count, p->depth_bits,
        p->coincident == WEFT_COINCIDENT_STENCIL, &t->depth);
    if (res != WEFT_OK)
        return res;
    gl->GenFramebuffers(1, &t->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, t->depth.attachment, GL_RENDERBUFFER,
                                t->depth.renderbuffer);
    gl->DrawBuffer(GL_NONE);
    gl->ReadBuffer(GL_NONE);
    return check_framebuffer(a, "depths");
}

// Of all layers: clearing it clears each.
static GLuint attach(const GladGLContext *gl, GLuint texture)
{
    GLuint framebuffer;
    gl->GenFramebuffers(1, &framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0);
    return framebuffer;
}

static enum weft_result make_sums(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    struct weft_acaa_target *t = &a->target;
    gl->GenTextures(1, &t->sums);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, t->sums);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R32UI, p->width, p->height, a->plan.layers.count, 0,
                   GL_RED_INTEGER, GL_UNSIGNED_INT, NULL);
    weft_texture_by_texel(gl, GL_TEXTURE_2D_ARRAY);
    gl->GenFramebuffers(1, &t->layer_framebuffer);
    t->sums_framebuffer = attach(gl, t->sums);
    const enum weft_result res = check_framebuffer(a, "sums");
    if (res != WEFT_OK || p->coincident != WEFT_COINCIDENT_MASK)
        return res;
    gl->GenTextures(1, &t->claims);
    gl->BindTexture(GL_TEXTURE_2D, t->claims);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R32UI, t->width, t->height, 0, GL_RED_INTEGER,
                   GL_UNSIGNED_INT, NULL);
    weft_texture_by_texel(gl, GL_TEXTURE_2D);
    t->claims_framebuffer = attach(gl, t->claims);
    return check_framebuffer(a, "claims");
}

static enum weft_result load_table(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    struct weft_acaa_target *t = &a->target;
    const GLsizeiptr bytes = (GLsizeiptr)(a->plan.table_size * sizeof *a->plan.table);
    const enum weft_result res =
        weft_gl_buffer_create(p->log, gl, GL_R32I, a->plan.table_size + 1, &t->table);
    if (res != WEFT_OK)
        return res;
    gl->BindBuffer(GL_TEXTURE_BUFFER, t->table.buffer);
    gl->BufferSubData(GL_TEXTURE_BUFFER, sizeof(int32_t), bytes, a->plan.table);
    gl->GenBuffers(1, &t->pass);
    gl->BindBuffer(GL_UNIFORM_BUFFER, t->pass);
    gl->BufferData(GL_UNIFORM_BUFFER, sizeof(struct pass_block), NULL, GL_DYNAMIC_DRAW);
    gl->BindBuffer(GL_UNIFORM_BUFFER, 0);
    return weft_gl_check(p->log, gl, "loading weights");
}

static enum weft_result check_size(const struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    GLint most = p->context->info.max_target_size, renderbuffer = 0;
    gl->GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbuffer);
    most = renderbuffer < most ? renderbuffer : most;
    if (p->width <= most - 2 * a->plan.rim && p->height <= most - 2 * a->plan.rim)
        return WEFT_OK;
    weft_error(p->log,
               "acaa: %" PRId32 " x %" PRId32 " pixels and a rim of %d; targets have at most %d a "
               "side",
               p->width, p->height, a->plan.rim, most);
    return WEFT_ERR_LIMIT;
}

enum weft_result weft_acaa_target_create(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    struct weft_acaa_target *t = &a->target;
    enum weft_result res = check_size(a);
    if (res != WEFT_OK)
        return res;
    t->width = p->width + 2 * a->plan.rim;
    t->height = p->height + 2 * a->plan.rim;
    res = make_depth(a);
    if (res == WEFT_OK)
        res = make_sums(a);
    if (res == WEFT_OK)
        res = load_table(a);
    if (res == WEFT_OK)
        res = weft_program_get(p->context, "background", a->head, weft_shader_full_target,
                               weft_shader_acaa_background, &t->background);
    if (res != WEFT_OK)
        return res;
    weft_program_hold(p->context, t->background);
    t->bytes = t->depth.bytes + weft_texture_bytes(gl, GL_TEXTURE_2D_ARRAY, t->sums) +
               t->table.size_bytes + sizeof(struct pass_block);
    if (t->claims)
        t->bytes += weft_texture_bytes(gl, GL_TEXTURE_2D, t->claims);
    return WEFT_OK;
}

void weft_acaa_target_destroy(struct weft_acaa *a)
{
    const GladGLContext *gl = &a->params.context->gl;
    struct weft_acaa_target *t = &a->target;
    const GLuint framebuffers[] = {t->framebuffer, t->sums_framebuffer, t->layer_framebuffer,
                                   t->claims_framebuffer};
    const GLuint textures[] = {t->sums, t->claims};
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->DeleteFramebuffers(WEFT_COUNT(framebuffers), framebuffers);
    gl->DeleteTextures(WEFT_COUNT(textures), textures);
    gl->DeleteBuffers(1, &t->pass);
    weft_gl_buffer_destroy(gl, &t->table);
    weft_depth_buffer_destroy(gl, &t->depth);
    weft_program_release(a->params.context, t->background);
    *t = (struct weft_acaa_target){0};
}

// ---- a picture ----------------------------------------------------------------------------------

// A pixel counts where samples of those within the radius reach it. What is drawn in the rim beyond
// is looked at for its range, too: parts at the picture's rim have it.
struct weft_rectangle weft_acaa_target_part(const struct weft_acaa *a)
{
    const struct weft_acaa_plan *plan = &a->plan;
    const struct weft_acaa_params *p = &a->params;
    const struct weft_rectangle *r = &a->part;
    const int reach = plan->rim + plan->radius;
    const int32_t low[2] = {r->x == 0 ? 0 : r->x, r->y == 0 ? 0 : r->y + plan->wrap};
    const int32_t high[2] = {
        r->x + r->width == p->width ? a->target.width : r->x + r->width + reach,
        r->y + r->height == p->height ? a->target.height : r->y + r->height + reach + plan->wrap};
    return (struct weft_rectangle){low[0], low[1], high[0] - low[0], high[1] - low[1]};
}

static void clear_words(const GladGLContext *gl, GLuint framebuffer,
                        const struct weft_rectangle *part, int32_t width, int32_t height)
{
    static const GLuint zero[4] = {0};
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->Viewport(0, 0, width, height);
    weft_part_scissor(gl, part, width, height);
    gl->ClearBufferuiv(GL_COLOR, 0, zero);
    gl->Disable(GL_SCISSOR_TEST);
}

enum weft_result weft_acaa_target_clear(struct weft_acaa *a)
{
    static const int32_t none = 0;
    const GladGLContext *gl = &a->params.context->gl;
    clear_words(gl, a->target.sums_framebuffer, &a->part, a->params.width, a->params.height);
    gl->BindBuffer(GL_TEXTURE_BUFFER, a->target.table.buffer);
    gl->BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof none, &none);
    return weft_gl_check(a->params.log, gl, "clearing sums");
}

// A component that is not noted; all but 0 are, where colours are not integers.
static float noted_range(const struct weft_acaa *a)
{
    return a->params.sums == WEFT_ACAA_FLOAT ? 0.0f : (float)a->range;
}

void weft_acaa_target_begin(struct weft_acaa *a, int pass)
{
    const struct weft_acaa_plan *plan = &a->plan;
    const GladGLContext *gl = &a->params.context->gl;
    struct weft_acaa_target *t = &a->target;
    const struct pass_block block = {
        .size = {a->params.width, a->params.height},
        .first = {-plan->radius - plan->rim, -plan->radius - plan->wrap - plan->rim},
        .scale = ldexpf(1.0f, a->scale_log2),
        .range = noted_range(a),
        .rows = 1 + (int32_t)((size_t)pass * weft_acaa_pass_rows(plan)),
    };
    const struct weft_rectangle part = weft_acaa_target_part(a);
    if (t->claims)
        clear_words(gl, t->claims_framebuffer, &part, t->width, t->height);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    weft_part_scissor(gl, &part, t->width, t->height);
    gl->Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    gl->BindBuffer(GL_UNIFORM_BUFFER, t->pass);
    gl->BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, WEFT_ACAA_PASS_BINDING, t->pass);
    if (t->claims)
        gl->BindImageTexture(WEFT_ACAA_CLAIMS_UNIT, t->claims, 0, GL_FALSE, 0, GL_READ_WRITE,
                             GL_R32UI);
    gl->BindImageTexture(WEFT_ACAA_SUMS_UNIT, t->sums, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
    gl->BindImageTexture(WEFT_ACAA_TABLE_UNIT, t->table.texture, 0, GL_FALSE, 0, GL_READ_WRITE,
                         GL_R32I);
    gl->MemoryBarrier(GL_ALL_BARRIER_BITS);
}

void weft_acaa_target_end(struct weft_acaa *a)
{
    const GladGLContext *gl = &a->params.context->gl;
    for (GLuint unit = WEFT_ACAA_CLAIMS_UNIT; unit <= WEFT_ACAA_TABLE_UNIT; unit++)
        gl->BindImageTexture(unit, 0, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R32UI);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, WEFT_ACAA_PASS_BINDING, 0);
    gl->MemoryBarrier(GL_ALL_BARRIER_BITS);
}

enum weft_result weft_acaa_target_read(struct weft_acaa *a)
{
    const GladGLContext *gl = &a->params.context->gl;
    const struct weft_rectangle *r = &a->part;
    float largest = 0.0f;
    gl->BindFramebuffer(GL_FRAMEBUFFER, a->target.layer_framebuffer);
    for (int i = 0; i < a->plan.layers.count; i++) {
        gl->FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, a->target.sums, 0, i);
        gl->ReadPixels(r->x, r->y, r->width, r->height, GL_RED_INTEGER, GL_UNSIGNED_INT,
                       a->words + (size_t)i * weft_part_pixels(r));
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, a->target.table.buffer);
    gl->GetBufferSubData(GL_TEXTURE_BUFFER, 0, sizeof largest, &largest);
    a->largest = (double)largest;
    return weft_gl_check(a->params.log, gl, "reading sums");
}
