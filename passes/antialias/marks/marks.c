// SPDX-License-Identifier: BSD-3-Clause
// Pixels with edges in them. Why none is missed (WEFT_MARK_COMPLETE), in this order: what a pixel
// without a mark can show; that lines and points reach every other; that the test of depth drops
// none of them; what this does not hold for.
//
// 1. Let surfaces be triangles, each with a number of its own, P the pixel about (0, 0), of side 1,
// and T the triangle that its middle shows. If no outline passes P, T covers it, and so does every
// triangle S that is seen at some q in P: S is in front of T there, and behind it in the middle. In
// the half-plane H, which has q and not the middle, S's plane is in front of T's. Say q is above
// and right of the middle: it is in the triangle of the middles (0, 0), (1, 0) and (0, 1), as its
// coordinates add up to at most 1, so that H has one of the latter two, say a = (1, 0). T's plane
// is at most z + |dz/dx| + |dz/dy| deep there. If a shows another surface that is not behind that,
// two surfaces may intersect in P, and it is marked. If it shows T, or what is behind, S cannot be
// at a: its outline crosses the way from q to a at some e. P is in reach of such an outline, too
// (2.). Where P shows the background, no S has its middle, so that an outline passes P. At the
// picture's rim there is no such a: pixels that show a surface are marked.
//
// 2. Lines of 2 pixels are drawn along an edge in columns (it is nearer to level) or rows (nearer
// to upright) as the two pixels whose middles are on either side of it, where it passes the middle
// of the column or row. An edge in P is less than a pixel from P's middle there, as it rises by at
// most 1/2 on its way. Only the column or row of an end may go without: the edge is not drawn if it
// ends in the diamond |x| + |y| < 1/2 of a pixel, or if it does not pass the middle. Points are 3
// pixels wide and lose their corners: what is left are the four pixels with the nearest middles and
// those with |x| + |y| < 3/2 from the end. The first have every pixel that an edge passes before it
// gets to the middle of its column; if the end is in its pixel's diamond, the pixels above and
// below that the edge can get to on its way through the column are among the second. e lies between
// q and (1, 0), not in P: e_x + e_y <= 1 and e_x > e_y >= 0. An edge nearer to upright is at x in
// (e_x - e_y, e_x + e_y), within (0, 1), where it passes y = 0: the two pixels of that row are P
// and the one beside it. If it ends before, or in a diamond of that row, P is among the pixels of
// its end's point. An edge nearer to level gets into P, or ends before x = 1/2 at a height that P
// has: likewise.
//
// 3. A line's fragment in P has the depth of S at a place u on the edge's line. Across that line q
// is less than 1.58 pixels from u (P's middle less than cos t, t being the line's angle to the axis
// that it is near, and q cos t / 2 + sin t / 2 from that), along it less than 1.42 (sin t between
// the middles of both pixels and the same again). The head takes 1.5 times the sum of the line's
// own two slopes off, which is more than the latter comes to. Polygon offset takes 2.25 times the
// triangle's m = max(|dz/dx|, |dz/dy|) off, which is more than the former, as m sqrt(2) is the most
// that a plane can slope. A point's fragment is less than 1.5 pixels from q along both axes: 3 m.
// What is left is less than S's depth at q, which is less than T's there, at most z + (|dz/dx| +
// |dz/dy|) / 2. All that is deeper may be dropped. For GL_LINES and GL_POINTS there is no m: 1.5
// times the steepest of the nine slopes around P is added to the limit, which is enough where S is
// seen around P, and not certain elsewhere.
//
// 4. It does not hold
// - for surfaces of several triangles with one number, of which only some edges are drawn: those in
//   one plane are as one, but of curved ones it is taken that the depth at the edges that are drawn
//   is within 1.5 pixels' slope, and where two surfaces intersect in less than a pixel, or one has
//   a hole or a fold there that is not drawn, it may be missed;
// - for triangles in one plane that are not the same triangle: rounding decides which one is seen;
// - where the near and the far plane cut: GL draws no outline along the cut;
// - for samples less than 1/256 of a pixel from its rim: GL moves vertices by up to half of that;
// - for a GL that leaves out more of a line than the pixels of its ends: fragments may be a pixel
//   from where the diamonds have them (OpenGL 4.6 core, 14.5.1.1).
#include "passes/antialias/marks/marks.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/marks/marks_impl.h"
#include "passes/gl/program.h"

const char *const weft_mark_names[] = {
    [WEFT_MARK_COMPLETE] = "complete",
    [WEFT_MARK_VISIBLE] = "visible",
    NULL,
};

// Pixels around the picture that lines and points are drawn in: GL cuts lines off where the
// framebuffer ends, and the pixel that a line is cut off in may be left out.
enum { RIM = 2 };

// ---- the object ---------------------------------------------------------------------------------

static GLenum colour_format(enum weft_antialias_format format)
{
    static const GLenum formats[] = {[WEFT_ANTIALIAS_RGBA8] = GL_RGBA8,
                                     [WEFT_ANTIALIAS_RGBA16F] = GL_RGBA16F,
                                     [WEFT_ANTIALIAS_RGBA32F] = GL_RGBA32F};
    return formats[format];
}

static GLuint make_texture(const GladGLContext *gl, const struct weft_marker_params *p,
                           GLenum internal, GLenum format)
{
    GLuint texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, p->width, p->height, 0, format,
                   GL_UNSIGNED_INT, NULL);
    weft_texture_by_texel(gl, GL_TEXTURE_2D);
    return texture;
}

// Of the framebuffer that is bound.
static enum weft_result check_framebuffer(const weft_marker *m, const GladGLContext *gl)
{
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    const enum weft_result res = weft_gl_check(m->params.log, gl, "making targets of marks");
    if (res != WEFT_OK || status == GL_FRAMEBUFFER_COMPLETE)
        return res;
    weft_error(m->params.log,
               "antialias: marks: targets of %" PRId32 " x %" PRId32
               " pixels cannot be had (0x%04x)",
               m->params.width, m->params.height, status);
    return WEFT_ERR_GL;
}

static enum weft_result make_picture(weft_marker *m, const GladGLContext *gl)
{
    const struct weft_marker_params *p = &m->params;
    const enum weft_result res = weft_gl_target_create(p->log, gl, colour_format(p->format),
                                                       p->width, p->height, &m->colours);
    if (res != WEFT_OK)
        return res;
    m->surfaces = make_texture(gl, p, GL_RG32UI, GL_RG_INTEGER);
    m->depths = make_texture(gl, p, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, m->surfaces, 0);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, m->depths, 0);
    return check_framebuffer(m, gl);
}

static enum weft_result make_marked(weft_marker *m, const GladGLContext *gl)
{
    const struct weft_marker_params *p = &m->params;
    enum weft_result res = weft_gl_target_create(p->log, gl, GL_R8, p->width + 2 * RIM,
                                                 p->height + 2 * RIM, &m->marked);
    if (res == WEFT_OK)
        res = weft_depth_buffer_create(p->log, gl, m->marked.width, m->marked.height, 1, 24, false,
                                       &m->limits);
    if (res != WEFT_OK)
        return res;
    gl->BindFramebuffer(GL_FRAMEBUFFER, m->marked.framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, m->limits.attachment, GL_RENDERBUFFER,
                                m->limits.renderbuffer);
    return check_framebuffer(m, gl);
}

static void measure(weft_marker *m, const GladGLContext *gl)
{
    const GLuint textures[] = {m->colours.texture, m->surfaces, m->depths, m->marked.texture};
    GLfloat range[2] = {1.0f, 1.0f};
    gl->GetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, range);
    m->line_width = fminf(range[1], 2.0f);
    gl->GetFloatv(GL_POINT_SIZE_RANGE, range);
    m->point_size = fminf(range[1], 3.0f);
    m->bytes = m->limits.bytes;
    for (size_t i = 0; i < WEFT_COUNT(textures); i++)
        m->bytes += weft_texture_bytes(gl, GL_TEXTURE_2D, textures[i]);
}

static enum weft_result make_all(weft_marker *m)
{
    weft_context *context = m->params.context;
    const GladGLContext *gl = &context->gl;
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = weft_program_get(context, "limits of marks", "", weft_shader_full_target,
                           weft_shader_marks_limit, &m->program);
    weft_program_hold(context, m->program);
    if (res == WEFT_OK)
        res = weft_background_kept(m->params.log, gl, colour_format(m->params.format),
                                   m->params.background, m->background);
    if (res == WEFT_OK)
        res = make_picture(m, gl);
    if (res == WEFT_OK)
        res = make_marked(m, gl);
    if (res == WEFT_OK)
        measure(m, gl);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    weft_context_leave(context);
    return res;
}

static bool is_finite(const double *values, int count)
{
    bool finite = true;
    for (int i = 0; i < count; i++)
        finite = finite && isfinite(values[i]);
    return finite;
}

static enum weft_result check_size(const struct weft_marker_params *p)
{
    const int most = weft_context_get_info(p->context)->max_target_size;
    if (p->width <= most - 2 * RIM && p->height <= most - 2 * RIM)
        return WEFT_OK;
    weft_error(p->log,
               "antialias: marks of %" PRId32 " x %" PRId32
               " pixels and a rim of %d; targets have at "
               "most %d along a side",
               p->width, p->height, RIM, most);
    return WEFT_ERR_LIMIT;
}

static size_t pixels_of(const weft_marker *m)
{
    return (size_t)m->params.width * (size_t)m->params.height;
}

static enum weft_result no_memory(const weft_marker *m)
{
    weft_error(m->params.log,
               "antialias: not enough memory for marks of %" PRId32 " x %" PRId32 " pixels",
               m->params.width, m->params.height);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_marker_create(const struct weft_marker_params *params, weft_marker **out)
{
    *out = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_marker *m = NULL;
    weft_require(params->log, params->width > 0 && params->height > 0);
    weft_require_enum(params->log, params->format, WEFT_ANTIALIAS_FORMAT_COUNT - 1);
    weft_require_enum(params->log, params->mark, WEFT_MARK_COUNT - 1);
    weft_require(params->log, params->contrast >= 0.0);
    weft_require(params->log, params->max_share >= 0.0 && params->max_share <= 1.0);
    weft_require(params->log, params->reach >= 0 && params->reach <= WEFT_MARKS_MAX_RADIUS);
    weft_require(params->log, is_finite(params->background, 4));
    weft_require(params->log, params->context);
    res = check_size(params);
    if (res != WEFT_OK)
        goto fail;
    m = calloc(1, sizeof *m);
    if (!m) {
        weft_error(params->log, "antialias: not enough memory for marks");
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    m->params = *params;
    m->picture = malloc(pixels_of(m) * (size_t)weft_antialias_format_bytes(params->format));
    res = m->picture ? make_all(m) : no_memory(m);
    if (res != WEFT_OK)
        goto fail;
    *out = m;
    return WEFT_OK;
fail:
    weft_marker_destroy(&m);
    return res;
}

static void destroy_targets(weft_marker *m)
{
    weft_context *context = m->params.context;
    const GladGLContext *gl = &context->gl;
    if (weft_context_enter(context) != WEFT_OK)
        return;
    weft_gl_target_destroy(gl, &m->colours);
    weft_gl_target_destroy(gl, &m->marked);
    weft_depth_buffer_destroy(gl, &m->limits);
    gl->DeleteTextures(2, (const GLuint[2]){m->surfaces, m->depths});
    weft_program_release(context, m->program);
    weft_context_leave(context);
}

void weft_marker_destroy(weft_marker **marker)
{
    if (!marker || !*marker)
        return;
    destroy_targets(*marker);
    free((*marker)->picture);
    free(*marker);
    *marker = NULL;
}

uint64_t weft_marker_bytes(const weft_marker *marker)
{
    return marker ? marker->bytes : 0;
}

// ---- passes -------------------------------------------------------------------------------------

static const char picture_head[] =
    WEFT_HEAD_33 "layout(location = 0) out vec4 weft_colour;\n"
                 "layout(location = 1) out uvec2 weft_surface;\n"
                 "void weft_write(vec4 colour, uint surface)\n"
                 "{\n"
                 "    weft_colour = colour;\n"
                 "    weft_surface = uvec2(surface, floatBitsToUint(fwidth(gl_FragCoord.z)));\n"
                 "}\n";

// Of visible marks.
static const char plain_head[] = WEFT_HEAD_33 "layout(location = 0) out float weft_marked;\n"
                                              "void weft_write(vec4 colour, uint surface)\n"
                                              "{\n"
                                              "    weft_marked = 1.0;\n"
                                              "}\n";

// Of complete ones: lines take off what their own depth changes by.
static const char line_head[] =
    WEFT_HEAD_33 "layout(location = 0) out float weft_marked;\n"
                 "void weft_write(vec4 colour, uint surface)\n"
                 "{\n"
                 "    weft_marked = 1.0;\n"
                 "    gl_FragDepth = gl_FragCoord.z - 1.5 * fwidth(gl_FragCoord.z);\n"
                 "}\n";

static const char point_head[] =
    WEFT_HEAD_33 "layout(location = 0) out float weft_marked;\n"
                 "void weft_write(vec4 colour, uint surface)\n"
                 "{\n"
                 "    vec2 away = abs(3.0 * gl_PointCoord - 1.5);\n"
                 "    if (max(away.x, away.y) >= 1.0 && away.x + away.y >= 1.5)\n"
                 "        discard;\n"
                 "    weft_marked = 1.0;\n"
                 "}\n";

// Thinner lines and points moved so that together they are 2 and 3 pixels wide.
static const double in_place[][2] = {{0.0, 0.0}};
static const double to_sides[][2] = {{-0.5, 0.0}, {0.5, 0.0}, {0.0, -0.5}, {0.0, 0.5}};
static const double around[][2] = {{-1.0, -1.0}, {0.0, -1.0}, {1.0, -1.0}, {-1.0, 0.0}, {0.0, 0.0},
                                   {1.0, 0.0},   {-1.0, 1.0}, {0.0, 1.0},  {1.0, 1.0}};

struct moves {
    const double (*by)[2];
    int count;
};

static struct moves moves_of(const weft_marker *m, enum weft_antialias_stage stage)
{
    if (stage == WEFT_STAGE_LINES && m->line_width < 2.0f)
        return (struct moves){to_sides, WEFT_COUNT(to_sides)};
    if (stage == WEFT_STAGE_POINTS && m->point_size < 3.0f)
        return (struct moves){around, WEFT_COUNT(around)};
    return (struct moves){in_place, WEFT_COUNT(in_place)};
}

// Of the picture's own target, or of the one with the rim.
static struct weft_rectangle part_of(const weft_marker *m, enum weft_antialias_stage stage)
{
    if (stage == WEFT_STAGE_COLOUR)
        return m->seen;
    return weft_part_pixels(&m->found) == pixels_of(m)
               ? (struct weft_rectangle){0, 0, m->marked.width, m->marked.height}
               : weft_part_moved(&m->found, RIM, RIM);
}

static struct weft_antialias_pass pass_of(const weft_marker *m, enum weft_antialias_stage stage,
                                          const struct weft_gl_target *target, const char *head)
{
    return (struct weft_antialias_pass){.stage = stage,
                                        .count = 1 + moves_of(m, WEFT_STAGE_LINES).count +
                                                 moves_of(m, WEFT_STAGE_POINTS).count,
                                        .framebuffer = target->framebuffer,
                                        .width = target->width,
                                        .height = target->height,
                                        .part = part_of(m, stage),
                                        .head = head};
}

static enum weft_result draw_picture(const weft_marker *m,
                                     const struct weft_antialias_drawing *drawing)
{
    const GladGLContext *gl = &m->params.context->gl;
    const struct weft_pass_state state = {.colours = 2, .depth_func = GL_LESS, .depth_write = true};
    struct weft_antialias_pass pass = pass_of(m, WEFT_STAGE_COLOUR, &m->colours, picture_head);
    weft_drawing_place(pass.width, pass.height, 0, in_place[0], pass.place);
    weft_pass_state_begin(gl, pass.framebuffer, pass.width, pass.height, &pass.part, &state);
    gl->ClearBufferfv(GL_COLOR, 0, m->background);
    gl->ClearBufferuiv(GL_COLOR, 1, (const GLuint[4]){0});
    gl->ClearBufferfv(GL_DEPTH, 0, &(const GLfloat){1.0f});
    return weft_drawing_run(m->params.log, m->params.context, drawing, &pass, &state);
}

static void find_limits(const weft_marker *m)
{
    const GladGLContext *gl = &m->params.context->gl;
    const struct weft_pass_state state = {
        .colours = 1, .depth_func = GL_ALWAYS, .depth_write = true};
    const struct weft_rectangle part = part_of(m, WEFT_STAGE_LINES);
    weft_pass_state_begin(gl, m->marked.framebuffer, m->marked.width, m->marked.height, &part,
                          &state);
    gl->UseProgram(m->program);
    weft_gl_bind_texture(gl, m->program, 0, "surfaces", GL_TEXTURE_2D, m->surfaces);
    weft_gl_bind_texture(gl, m->program, 1, "depths", GL_TEXTURE_2D, m->depths);
    gl->Uniform1i(weft_gl_location(gl, m->program, "complete"),
                  m->params.mark == WEFT_MARK_COMPLETE);
    gl->Uniform1i(weft_gl_location(gl, m->program, "rim"), RIM);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    weft_pass_state_end(gl);
}

// How an edge is drawn.
struct edge_drawing {
    const char *head;
    float nearer; // slopes of a triangle that its depth may differ by: 3. above. Visible: half a
                  // pixel either way
};

static struct edge_drawing drawing_of(const weft_marker *m, enum weft_antialias_stage stage)
{
    if (m->params.mark == WEFT_MARK_VISIBLE)
        return (struct edge_drawing){stage == WEFT_STAGE_POINTS ? point_head : plain_head, 1.0f};
    if (stage == WEFT_STAGE_POINTS)
        return (struct edge_drawing){point_head, 3.0f};
    return (struct edge_drawing){line_head, 2.25f};
}

static enum weft_result draw_edges(const weft_marker *m,
                                   const struct weft_antialias_drawing *drawing,
                                   enum weft_antialias_stage stage, int *index)
{
    const struct moves moves = moves_of(m, stage);
    const struct edge_drawing how = drawing_of(m, stage);
    const struct weft_pass_state state = {.colours = 1,
                                          .depth_func = GL_LEQUAL,
                                          .polygon = stage == WEFT_STAGE_LINES ? GL_LINE : GL_POINT,
                                          .nearer = how.nearer,
                                          .line = m->line_width,
                                          .point = m->point_size};
    struct weft_antialias_pass pass = pass_of(m, stage, &m->marked, how.head);
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < moves.count && res == WEFT_OK; i++) {
        pass.index = ++*index;
        weft_drawing_place(m->params.width, m->params.height, RIM, moves.by[i], pass.place);
        res = weft_drawing_run(m->params.log, m->params.context, drawing, &pass, &state);
    }
    return res;
}

// ---- in memory ----------------------------------------------------------------------------------

static void count(const weft_marker *m, struct weft_marks *marks)
{
    uint8_t *next = marks->marked;
    for (int32_t y = 0; y < m->found.height; y++)
        for (int32_t x = 0; x < m->found.width; x++, next++) {
            *next = *next != 0;
            marks->count += *next && weft_marker_counts(m, x, y);
        }
}

static enum weft_result read_back(weft_marker *m, struct weft_marks *marks)
{
    static const GLenum types[] = {[WEFT_ANTIALIAS_RGBA8] = GL_UNSIGNED_BYTE,
                                   [WEFT_ANTIALIAS_RGBA16F] = GL_HALF_FLOAT,
                                   [WEFT_ANTIALIAS_RGBA32F] = GL_FLOAT};
    const GladGLContext *gl = &m->params.context->gl;
    struct weft_gl_pixels pixels = {.x = m->seen.x,
                                    .y = m->seen.y,
                                    .width = m->seen.width,
                                    .height = m->seen.height,
                                    .type = types[m->params.format],
                                    .data = m->picture};
    enum weft_result res = weft_gl_target_read(m->params.log, gl, &m->colours, &pixels);
    pixels = (struct weft_gl_pixels){.x = m->found.x + RIM,
                                     .y = m->found.y + RIM,
                                     .width = m->found.width,
                                     .height = m->found.height,
                                     .type = GL_UNSIGNED_BYTE,
                                     .data = marks->marked};
    if (res == WEFT_OK)
        res = weft_gl_target_read(m->params.log, gl, &m->marked, &pixels);
    if (res == WEFT_OK)
        count(m, marks);
    return res;
}

static enum weft_result find_edges(weft_marker *m, const struct weft_antialias_drawing *drawing,
                                   struct weft_marks *marks)
{
    int index = 0;
    enum weft_result res = weft_context_enter(m->params.context);
    if (res != WEFT_OK)
        return res;
    res = draw_picture(m, drawing);
    if (res == WEFT_OK) {
        find_limits(m);
        res = draw_edges(m, drawing, WEFT_STAGE_LINES, &index);
    }
    if (res == WEFT_OK)
        res = draw_edges(m, drawing, WEFT_STAGE_POINTS, &index);
    if (res == WEFT_OK)
        res = read_back(m, marks);
    m->params.context->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    weft_context_leave(m->params.context);
    return res;
}

// What is asked for, what is to be marked, and the neighbours that this takes.
static enum weft_result find_parts(weft_marker *m, const struct weft_rectangle *part)
{
    const struct weft_marker_params *p = &m->params;
    const enum weft_result res = weft_rectangle_within(p->log, part, p->width, p->height, &m->part);
    if (res != WEFT_OK)
        return res;
    if (p->max_share > 0.0 && weft_part_pixels(&m->part) < pixels_of(m)) {
        weft_error(p->log,
                   "antialias: which pixels are the share of %g that is marked is known of "
                   "the whole picture only",
                   p->max_share);
        return WEFT_ERR_UNSUPPORTED;
    }
    m->found = weft_part_grown(&m->part, p->reach, p->width, p->height);
    m->seen = weft_part_grown(&m->found, 1, p->width, p->height);
    return WEFT_OK;
}

enum weft_result weft_marker_run(weft_marker *marker, const struct weft_antialias_drawing *drawing,
                                 struct weft_marks *out)
{
    *out = (struct weft_marks){.width = marker->params.width, .height = marker->params.height};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    marker->drawn = false;
    weft_require(marker->params.log, drawing && drawing->draw);
    res = find_parts(marker, &drawing->part);
    if (res != WEFT_OK)
        goto fail;
    out->part = marker->found;
    out->marked = malloc(weft_part_pixels(&out->part));
    res = out->marked ? find_edges(marker, drawing, out) : no_memory(marker);
    if (res != WEFT_OK)
        goto fail;
    marker->drawn = true;
    res = weft_marks_choose(marker, out);
    if (res == WEFT_OK)
        return WEFT_OK;
    no_memory(marker);
fail:
    weft_marks_clear(out);
    return res;
}
