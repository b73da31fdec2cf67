// SPDX-License-Identifier: BSD-3-Clause
// Cases of anti-aliasing that models no more than the scene needs: samples that count twice or not
// at all, edges that are not found, regions that are not the picture's, sums beyond their range.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/accumulative.h"
#include "passes/antialias/drawing/run.h"
#include "passes/antialias/supersample.h"
#include "passes/gl/target.h"
#include "passes/stability/cases.h"
#include "passes/stability/triangles.h"

enum { SIZE = 64, PIXELS = SIZE * SIZE, TRIANGLES = 40 };

// ---- scenes -------------------------------------------------------------------------------------

static double noise(int triangle, int which)
{
    return (double)weft_stability_noise(triangle, which, 16);
}

// About random places, each at a depth and of a colour of its own; `across` of a triangle that is
// 48 pixels long or less.
static void scatter(double across, bool tilted, struct weft_stability_triangle *out)
{
    for (int t = 0; t < TRIANGLES; t++) {
        const double angle = 3.0 * noise(t, 0), c = cos(angle), s = sin(angle);
        const double middle[2] = {32.0 + 32.0 * noise(t, 1), 32.0 + 32.0 * noise(t, 2)};
        const double along[3] = {-24.0, 24.0 * noise(t, 3), 24.0}, depth = (t + 1.0) / 64.0;
        for (int k = 0; k < 3; k++) {
            const double off = k == 1 ? across : 0.0;
            out[t].corner[k][0] = middle[0] + along[k] * c - off * s;
            out[t].corner[k][1] = middle[1] + along[k] * s + off * c;
            out[t].depth[k] = tilted ? depth + 0.1 * (1.0 + noise(t, 4 + k)) : depth;
        }
        for (int k = 0; k < 3; k++)
            out[t].colour[k] = (float)(0.5 + 0.5 * noise(t, 8 + k));
        out[t].surface = (uint32_t)t + 1;
    }
}

static enum weft_result scatter_scene(const struct weft_stability_params *params,
                                      struct weft_stability_scene *out)
{
    struct weft_stability_triangle triangles[TRIANGLES];
    scatter(12.0, true, triangles);
    return weft_stability_scene_create(params, SIZE, triangles, TRIANGLES, out);
}

// The first channel, and the report.
static enum weft_result accumulate(const struct weft_stability_params *params,
                                   struct weft_stability_scene *scene,
                                   enum weft_acaa_coincident coincident, float *out,
                                   struct weft_acaa_report *report)
{
    const struct weft_antialias_drawing drawing = {.draw = weft_stability_scene_draw,
                                                   .priv = scene};
    weft_acaa *acaa = NULL;
    enum weft_result res =
        weft_acaa_create(weft_acaa_params(.width = SIZE, .height = SIZE, .coincident = coincident,
                                          .context = params->context, .log = params->log),
                         &acaa);
    if (res == WEFT_OK)
        res = weft_acaa_run(acaa, &drawing, NULL);
    if (res == WEFT_OK)
        res = weft_acaa_read(acaa, 0, out, 0);
    if (res == WEFT_OK)
        weft_acaa_get_report(acaa, report);
    weft_acaa_destroy(&acaa);
    return res;
}

// A NAN counts.
static double largest_difference(const float *a, const float *b)
{
    double largest = 0.0;
    for (int p = 0; p < PIXELS; p++) {
        const double d = fabs((double)a[p] - (double)b[p]);
        largest = d <= largest ? largest : d;
    }
    return largest;
}

// ---- coincident surfaces ------------------------------------------------------------------------

// Every triangle is drawn twice. Sums are of integers, and both have the same colour: where each
// sample counts for the first of both, the picture has the bytes of the one where it is drawn once.
static enum weft_result measure_drawn_twice(const struct weft_stability_params *params,
                                            struct weft_stability_result *result)
{
    float *out = malloc(3 * PIXELS * sizeof *out), *once = out, *twice = out + PIXELS;
    float *counted = out + 2 * PIXELS;
    struct weft_stability_scene scene = {0};
    struct weft_acaa_report report, doubled;
    enum weft_result res = out ? scatter_scene(params, &scene) : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = accumulate(params, &scene, WEFT_COINCIDENT_STENCIL, once, &report);
    scene.copies = 2;
    if (res == WEFT_OK)
        res = accumulate(params, &scene, WEFT_COINCIDENT_NONE, twice, &doubled);
    if (res == WEFT_OK)
        res = accumulate(params, &scene, WEFT_COINCIDENT_STENCIL, counted, &report);
    if (res == WEFT_OK) {
        result->naive = largest_difference(twice, once);
        result->ours = largest_difference(counted, once);
        result->limit = 0.0;
        weft_stability_say(result, "of 1.0",
                           "%lld pixels of %d weigh more than they should, up to %.0f times",
                           (long long)doubled.more, PIXELS, 1.0 + doubled.largest);
    }
    weft_stability_scene_destroy(&scene);
    free(out);
    return res;
}

const struct weft_stability_case weft_stability_drawn_twice = {
    .name = "drawn-twice",
    .failure = "accumulative anti-aliasing of coincident surfaces: their samples count for each",
    .naive = "every fragment at the depth of the first pass adds its samples",
    .ours = "a bit of the stencil lets each sample count for the first fragment only",
    .source = "Enderton and others, Accumulative Anti-Aliasing, 2015, section 2",
    .needs_context = true,
    .measure = measure_drawn_twice,
};

// ---- a first pass with a shader of its own ------------------------------------------------------

static enum weft_result measure_shader_apart(const struct weft_stability_params *params,
                                             struct weft_stability_result *result)
{
    float *out = malloc(PIXELS * sizeof *out);
    struct weft_stability_scene scene = {0};
    struct weft_acaa_report naive, ours;
    enum weft_result res = out ? scatter_scene(params, &scene) : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = accumulate(params, &scene, WEFT_COINCIDENT_STENCIL, out, &ours);
    scene.depths_apart = true;
    if (res == WEFT_OK)
        res = accumulate(params, &scene, WEFT_COINCIDENT_STENCIL, out, &naive);
    if (res == WEFT_OK) {
        // The same shader object and `invariant` give the same bits: every sample's depth is met.
        result->naive = (double)(naive.less + naive.more);
        result->ours = (double)(ours.less + ours.more);
        result->limit = 0.0;
        weft_stability_say(result, "pixels",
                           "%lld of %d pixels have samples whose depth no colour meets again",
                           (long long)naive.less, PIXELS);
    }
    weft_stability_scene_destroy(&scene);
    free(out);
    return res;
}

const struct weft_stability_case weft_stability_shader_apart = {
    .name = "shader-apart",
    .failure = "a depth pass whose shader is another one: depths differ in the last bits",
    .naive = "the depth pass multiplies by one matrix, the colour pass by two",
    .ours = "one vertex shader object for both passes, invariant, and weights that are checked",
    .source = "OpenGL 4.6 core, appendix A: invariance",
    .needs_context = true,
    .measure = measure_shader_apart,
};

// ---- edges between samples ----------------------------------------------------------------------

// Edges within 1/128 of a pixel of a sample leave open what it shows: GL moves corners by 1/512.
static const double unsure = 1.0 / 128.0;
enum { UNSURE = -1, BACKGROUND = 0 };

// Of a triangle: its edges' unit normals inwards, and their offsets.
struct sides {
    double normal[3][2], offset[3];
};

static void find_sides(const struct weft_stability_triangle *t, struct sides *out)
{
    for (int k = 0; k < 3; k++) {
        const double *a = t->corner[k], *b = t->corner[(k + 1) % 3], *c = t->corner[(k + 2) % 3];
        const double dx = b[0] - a[0], dy = b[1] - a[1];
        const double across = dx * (c[1] - a[1]) - dy * (c[0] - a[0]);
        const double scale = copysign(1.0 / hypot(dx, dy), across);
        out->normal[k][0] = -dy * scale;
        out->normal[k][1] = dx * scale;
        out->offset[k] = -(out->normal[k][0] * a[0] + out->normal[k][1] * a[1]);
    }
}

// How deep inside of a triangle (x, y) is: negative outside.
static double inside(const struct sides *s, double x, double y)
{
    double least = (double)INFINITY;
    for (int k = 0; k < 3; k++)
        least = fmin(least, s->normal[k][0] * x + s->normal[k][1] * y + s->offset[k]);
    return least;
}

// What is seen at (x, y) of a list of triangles, the first one in front; or UNSURE.
static int seen_at(const struct sides *sides, const int *list, int count, double x, double y)
{
    for (int i = 0; i < count; i++) {
        const double depth = inside(&sides[list[i]], x, y);
        if (depth > unsure)
            return list[i] + 1;
        if (depth > -unsure)
            return UNSURE;
    }
    return BACKGROUND;
}

// Triangles that may have a part of the pixel.
static int list_near(const struct sides *sides, int x, int y, int *list)
{
    int count = 0;
    for (int t = 0; t < TRIANGLES; t++)
        if (inside(&sides[t], x + 0.5, y + 0.5) > -0.75)
            list[count++] = t;
    return count;
}

// What the middle shows, and whether 16 x 16 samples show more than one surface for sure.
static bool is_mixed(const struct sides *sides, int x, int y, int *middle)
{
    int list[TRIANGLES], first = UNSURE;
    const int count = list_near(sides, x, y, list);
    bool mixed = false;
    *middle = seen_at(sides, list, count, x + 0.5, y + 0.5);
    for (int s = 0; s < 256 && !mixed; s++) {
        const int seen =
            seen_at(sides, list, count, x + (s % 16 + 0.5) / 16.0, y + (s / 16 + 0.5) / 16.0);
        mixed = first != UNSURE && seen != UNSURE && seen != first;
        first = seen == UNSURE ? first : seen;
    }
    return mixed;
}

static bool neighbours_differ(const int *seen, int x, int y)
{
    bool differ = false;
    for (int j = y - 1; j <= y + 1; j++)
        for (int i = x - 1; i <= x + 1; i++)
            if (i >= 0 && j >= 0 && i < SIZE && j < SIZE)
                differ = differ || seen[j * SIZE + i] != seen[y * SIZE + x];
    return differ;
}

static enum weft_result mark(const struct weft_stability_params *params,
                             const struct weft_stability_triangle *triangles,
                             struct weft_marks *out)
{
    struct weft_stability_scene scene;
    const struct weft_antialias_drawing drawing = {.draw = weft_stability_scene_draw,
                                                   .priv = &scene};
    weft_marker *marker = NULL;
    *out = (struct weft_marks){0};
    enum weft_result res = weft_stability_scene_create(params, SIZE, triangles, TRIANGLES, &scene);
    if (res == WEFT_OK)
        res = weft_marker_create(weft_marker_params(.width = SIZE, .height = SIZE,
                                                    .context = params->context, .log = params->log),
                                 &marker);
    if (res == WEFT_OK)
        res = weft_marker_run(marker, &drawing, out);
    weft_marker_destroy(&marker);
    weft_stability_scene_destroy(&scene);
    return res;
}

static enum weft_result measure_edge_ids(const struct weft_stability_params *params,
                                         struct weft_stability_result *result)
{
    struct weft_stability_triangle triangles[TRIANGLES];
    struct sides sides[TRIANGLES];
    struct weft_marks marks;
    bool is[PIXELS];
    int seen[PIXELS], mixed = 0, naive = 0, ours = 0;
    scatter(0.7, false, triangles);
    const enum weft_result res = mark(params, triangles, &marks);
    if (res != WEFT_OK)
        return res;
    for (int t = 0; t < TRIANGLES; t++)
        find_sides(&triangles[t], &sides[t]);
    for (int p = 0; p < PIXELS; p++)
        is[p] = is_mixed(sides, p % SIZE, p / SIZE, &seen[p]);
    for (int p = 0; p < PIXELS; p++) {
        mixed += is[p];
        naive += is[p] && !neighbours_differ(seen, p % SIZE, p / SIZE);
        ours += is[p] && !marks.marked[p];
    }
    weft_marks_clear(&marks);
    result->naive = naive;
    result->ours = ours;
    result->limit = 0.0; // passes/antialias/marks/marks.c says why
    weft_stability_say(result, "pixels", "of %d pixels with edges %d are missed", mixed, naive);
    return WEFT_OK;
}

const struct weft_stability_case weft_stability_edge_ids = {
    .name = "edge-ids",
    .failure = "edges found by neighbours' surfaces alone: what is thinner than a pixel is missed",
    .naive = "pixels whose 3 x 3 neighbours show several surfaces",
    .ours = "lines along all edges, points at their ends, and neighbours that may intersect",
    .source = "Lin, Lau, Lin, Cheung, A Parallel Rendering Approach to the Adaptive Supersampling "
              "Method, 1997",
    .needs_context = true,
    .measure = measure_edge_ids,
};

// ---- regions with a frustum of their own --------------------------------------------------------

enum { ROW = 4, REGION = 24, FROM = 20, ZOOMED = REGION * ROW };

// Samples of 4 x 4 a pixel.
static enum weft_result supersample(const struct weft_stability_params *params,
                                    struct weft_stability_scene *scene,
                                    const struct weft_marks *marks, float *out)
{
    const struct weft_antialias_drawing drawing = {.draw = weft_stability_scene_draw,
                                                   .priv = scene};
    weft_supersample *s = NULL;
    enum weft_result res = weft_supersample_create(
        weft_supersample_params(.width = SIZE, .height = SIZE, .count = ROW * ROW,
                                .method = WEFT_ACCUMULATE_EXACT, .context = params->context,
                                .log = params->log),
        &s);
    if (res == WEFT_OK)
        res = weft_supersample_run(s, &drawing, marks, NULL);
    if (res == WEFT_OK)
        res = weft_supersample_read(s, 0, out, 0);
    weft_supersample_destroy(&s);
    return res;
}

// Draws a pass of stage colour into a target of one sample, with depths where they are asked for.
static enum weft_result draw_once(const struct weft_stability_params *params,
                                  struct weft_stability_scene *scene,
                                  const struct weft_gl_target *target, bool depths,
                                  const double place[16])
{
    const GladGLContext *gl = &params->context->gl;
    const struct weft_antialias_drawing drawing = {.draw = weft_stability_scene_draw,
                                                   .priv = scene};
    const struct weft_pass_state state = {
        .colours = 1, .depth_func = depths ? GL_LESS : 0, .depth_write = depths};
    struct weft_antialias_pass pass = {.stage = WEFT_STAGE_COLOUR,
                                       .framebuffer = target->framebuffer,
                                       .width = target->width,
                                       .height = target->height,
                                       .part = {0, 0, target->width, target->height},
                                       .head = weft_head_colour(gl, false)};
    memcpy(pass.place, place, sizeof pass.place);
    return weft_drawing_run(params->log, params->context, &drawing, &pass, &state);
}

// The region alone, four times as large, so that its pixels' middles are those samples.
static void zoom_in(double out[16])
{
    const double scale = (double)SIZE / REGION, middle = 2.0 * (FROM + 0.5 * REGION) / SIZE - 1.0;
    memset(out, 0, 16 * sizeof *out);
    out[0] = out[5] = scale;
    out[12] = out[13] = -scale * middle;
    out[10] = out[15] = 1.0;
}

// Means of the region's samples, as codes of 8 bits.
static enum weft_result draw_region(const struct weft_stability_params *params,
                                    struct weft_stability_scene *scene, double *out)
{
    uint8_t codes[ZOOMED * ZOOMED][4];
    const GladGLContext *gl = &params->context->gl;
    const struct weft_gl_pixels pixels = {
        .width = ZOOMED, .height = ZOOMED, .type = GL_UNSIGNED_BYTE, .data = codes};
    struct weft_gl_target target = {0};
    struct weft_depth_buffer depths = {0};
    double place[16];
    zoom_in(place);
    enum weft_result res =
        weft_gl_target_create(params->log, gl, GL_RGBA8, ZOOMED, ZOOMED, &target);
    if (res == WEFT_OK)
        res = weft_depth_buffer_create(params->log, gl, ZOOMED, ZOOMED, 1, 24, true, &depths);
    if (res == WEFT_OK) {
        gl->BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
        gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, depths.attachment, GL_RENDERBUFFER,
                                    depths.renderbuffer);
        gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        res = draw_once(params, scene, &target, true, place);
    }
    if (res == WEFT_OK)
        res = weft_gl_target_read(params->log, gl, &target, &pixels);
    memset(out, 0, REGION * REGION * sizeof *out);
    for (int i = 0; i < ZOOMED * ZOOMED && res == WEFT_OK; i++)
        out[i / ZOOMED / ROW * REGION + i % ZOOMED / ROW] += codes[i][0] / 255.0 / (ROW * ROW);
    weft_depth_buffer_destroy(gl, &depths);
    weft_gl_target_destroy(gl, &target);
    return res;
}

// out: two pictures.
static enum weft_result draw_regions(const struct weft_stability_params *params,
                                     struct weft_stability_scene *scene, struct weft_marks *marks,
                                     float *out, double *region)
{
    for (int i = 0; i < REGION * REGION; i++)
        marks->marked[(FROM + i / REGION) * SIZE + FROM + i % REGION] = 1;
    marks->count = REGION * REGION;
    enum weft_result res = supersample(params, scene, NULL, out);
    if (res == WEFT_OK)
        res = supersample(params, scene, marks, out + PIXELS);
    if (res == WEFT_OK)
        res = weft_context_enter(params->context);
    if (res != WEFT_OK)
        return res;
    res = draw_region(params, scene, region);
    weft_context_leave(params->context);
    return res;
}

// Pixels of the region that are not the picture's: ours have its bytes; means of other samples are
// off by a 16th of a code at least, those of the same by roundings alone.
static void count_regions(const float *full, const float *marked, const double *region,
                          struct weft_stability_result *result)
{
    const double step = 1.0 / 255.0 / (ROW * ROW);
    result->naive = result->ours = 0.0;
    for (int i = 0; i < REGION * REGION; i++) {
        const int p = (FROM + i / REGION) * SIZE + FROM + i % REGION;
        result->naive += !(fabs((double)full[p] - region[i]) < 0.5 * step);
        result->ours += full[p] != marked[p];
    }
    result->limit = 0.0;
    weft_stability_say(result, "pixels",
                       "%.0f of %d pixels of a region with a frustum of its own are others than "
                       "the picture's: corners are moved to 1/256 of its own pixels",
                       result->naive, REGION * REGION);
}

static enum weft_result measure_own_frustum(const struct weft_stability_params *params,
                                            struct weft_stability_result *result)
{
    float *out = calloc(2 * PIXELS, sizeof *out);
    struct weft_marks marks = {.width = SIZE, .height = SIZE, .marked = calloc(PIXELS, 1)};
    double region[REGION * REGION];
    struct weft_stability_scene scene = {0};
    enum weft_result res = out && marks.marked ? scatter_scene(params, &scene) : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = draw_regions(params, &scene, &marks, out, region);
    if (res == WEFT_OK)
        count_regions(out, out + PIXELS, region, result);
    weft_stability_scene_destroy(&scene);
    weft_marks_clear(&marks);
    free(out);
    return res;
}

const struct weft_stability_case weft_stability_own_frustum = {
    .name = "own-frustum",
    .failure = "regions drawn anew with a frustum of their own: they do not fit the picture",
    .naive = "a region of 24 x 24 pixels, 4 x 4 times as large",
    .ours = "the picture's own 16 passes, cut to the region by the stencil",
    .source = "OpenGL 4.6 core, 14.5: corners are kept with SUBPIXEL_BITS",
    .needs_context = true,
    .measure = measure_own_frustum,
};

// ---- sums of bright colours ---------------------------------------------------------------------

static const double bright = 40000.0, dim = 0.5;

// The left half is bright, the right one is not.
static enum weft_result bright_scene(const struct weft_stability_params *params,
                                     struct weft_stability_scene *out)
{
    struct weft_stability_triangle t[4];
    for (int i = 0; i < 4; i++) {
        const double left = i / 2 * (SIZE / 2), right = left + SIZE / 2;
        const double odd[2] = {i % 2 ? right : left, i % 2 ? SIZE : 0.0};
        const float value = (float)(i / 2 ? dim : bright);
        t[i] = (struct weft_stability_triangle){
            .corner = {{left, SIZE}, {right, 0.0}, {odd[0], odd[1]}},
            .depth = {0.5, 0.5, 0.5},
            .colour = {value, value, value},
            .surface = 1};
    }
    return weft_stability_scene_create(params, SIZE, t, 4, out);
}

// Relative to the bright one; a NAN counts.
static double bright_error(const float *out, int step)
{
    double largest = 0.0;
    for (int p = 0; p < PIXELS; p++) {
        const double exact = p % SIZE < SIZE / 2 ? bright : dim;
        const double error = fabs((double)out[(ptrdiff_t)p * step] - exact) / bright;
        largest = error <= largest ? largest : error;
    }
    return largest;
}

// Four samples, added up in halves and divided afterwards.
static enum weft_result blend_samples(const struct weft_stability_params *params,
                                      struct weft_stability_scene *scene, float *out)
{
    const GladGLContext *gl = &params->context->gl;
    const struct weft_gl_pixels pixels = {
        .width = SIZE, .height = SIZE, .type = GL_FLOAT, .data = out};
    struct weft_gl_target target = {0};
    enum weft_result res = weft_gl_target_create(params->log, gl, GL_RGBA16F, SIZE, SIZE, &target);
    if (res == WEFT_OK)
        gl->Clear(GL_COLOR_BUFFER_BIT);
    for (int s = 0; s < 4 && res == WEFT_OK; s++) {
        double place[16];
        weft_drawing_place(SIZE, SIZE, 0, (const double[2]){s % 2 * 0.5 - 0.25, s / 2 * 0.5 - 0.25},
                           place);
        gl->Enable(GL_BLEND);
        gl->BlendFunc(GL_ONE, GL_ONE);
        res = draw_once(params, scene, &target, false, place);
    }
    if (res == WEFT_OK)
        res = weft_gl_target_read(params->log, gl, &target, &pixels);
    for (int i = 0; i < 4 * PIXELS && res == WEFT_OK; i++)
        out[i] /= 4.0f;
    weft_gl_target_destroy(gl, &target);
    return res;
}

static enum weft_result measure_bright_sum(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    float *out = malloc(4 * PIXELS * sizeof *out);
    struct weft_stability_scene scene = {0};
    struct weft_acaa_report report;
    enum weft_result res = out ? bright_scene(params, &scene) : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_context_enter(params->context);
    if (res == WEFT_OK) {
        res = blend_samples(params, &scene, out);
        weft_context_leave(params->context);
    }
    if (res == WEFT_OK) {
        result->naive = bright_error(out, 4);
        const float first = out[0];
        res = accumulate(params, &scene, WEFT_COINCIDENT_STENCIL, out, &report);
        weft_stability_say(result, "relative",
                           "4 samples of %.0f add up to a mean of %.0f in halves; integers find a "
                           "range of %.0f, redone %d times",
                           bright, (double)first, report.range, report.redone);
    }
    if (res == WEFT_OK) {
        result->ours = bright_error(out, 1);
        result->limit = report.bound / bright;
    }
    weft_stability_scene_destroy(&scene);
    free(out);
    return res;
}

const struct weft_stability_case weft_stability_bright_sum = {
    .name = "bright-sum",
    .failure = "sums of bright colours that are beyond what they are kept in",
    .naive = "samples added up in a target of halves, and divided afterwards",
    .ours = "integers whose range is found while drawing, and the picture drawn again",
    .source = "IEEE 754 binary16: the largest finite number is 65,504",
    .needs_context = true,
    .measure = measure_bright_sum,
};
