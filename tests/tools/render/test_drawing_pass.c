// SPDX-License-Identifier: BSD-3-Clause
// Passes of anti-aliasing draw the picture that a frame is, with each pixel's surface, and lines
// wherever surfaces meet; every sample counts once.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/tools/render/pictures.h"
#include "tests/tools/render/traced.h"
#include "tools/render/edges.h"
#include "tools/render/gl/gl.h"
#include "tools/render/lamps.h"

enum { WIDTH = 80, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, SCENES = 8 };

static const char *const names[SCENES] = {
    "cube",  "cornell", "furnace",  "polygons:300",
    "plane", "moving",  "penumbra", WEFT_TEST_DATA "/mesh/spot.obj"};

// false: the mesh is not there.
static bool make_named(int i, struct scene *out)
{
    if (i == SCENES - 1 && access(names[i], R_OK) != 0) {
        print_message("[  SKIPPED ] %s: it is not there\n", names[i]);
        return false;
    }
    assert_int_equal(
        scene_make(scene_params(.name = names[i], .size = {WIDTH, HEIGHT}, .log = &log_to_stderr),
                   out),
        WEFT_OK);
    return true;
}

// ---- passes into a target of floats -------------------------------------------------------------

// Of a pixel: its colour, or its surface and a part of its colour.
static const char colour_head[] = "#version 330 core\n"
                                  "out vec4 colour_0;\n"
                                  "#define WEFT_AT(name) name\n"
                                  "void weft_write(vec4 colour, uint surface)\n"
                                  "{\n"
                                  "    colour_0 = colour;\n"
                                  "}\n";
static const char surface_head[] = "#version 400 core\n"
                                   "out vec4 colour_0;\n"
                                   "#define WEFT_AT(name) interpolateAtOffset(name, vec2(0.0))\n"
                                   "void weft_write(vec4 colour, uint surface)\n"
                                   "{\n"
                                   "    colour_0 = vec4(float(surface), colour.rg, 1.0);\n"
                                   "}\n";

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

struct drawn_pass {
    scene_drawing *drawing;
    const struct scene_frame *frame;
    enum weft_antialias_stage stage;
    const char *head;
    bool depths_first; // a pass of depths, then one where they are equal
    float *out;        // [y][x][4]
};

static void draw_stage(const GladGLContext *gl, const struct drawn_pass *d)
{
    struct weft_antialias_pass pass = {.stage = d->stage,
                                       .width = WIDTH,
                                       .height = HEIGHT,
                                       .part = {0, 0, WIDTH, HEIGHT},
                                       .head = d->head};
    memcpy(pass.place, identity, sizeof identity);
    if (d->depths_first) {
        struct weft_antialias_pass depths = pass;
        depths.stage = WEFT_STAGE_DEPTH;
        depths.head = "#version 330 core\n";
        gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        assert_int_equal(scene_drawing_pass(d->drawing, &depths), WEFT_OK);
        gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl->DepthMask(GL_FALSE);
        gl->DepthFunc(GL_EQUAL);
    }
    assert_int_equal(scene_drawing_pass(d->drawing, &pass), WEFT_OK);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
}

static enum weft_result draw_pass(void *priv)
{
    struct drawn_pass *d = priv;
    GladGLContext table = {0}, *gl = &table;
    GLuint buffer, target[2];
    assert_true(scene_gl_load(gl, contexts[0]));
    assert_int_equal(scene_drawing_prepare(d->drawing, d->frame), WEFT_OK);
    gl->GenFramebuffers(1, &buffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, buffer);
    gl->GenRenderbuffers(2, target);
    gl->BindRenderbuffer(GL_RENDERBUFFER, target[0]);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA32F, WIDTH, HEIGHT);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target[0]);
    gl->BindRenderbuffer(GL_RENDERBUFFER, target[1]);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, WIDTH, HEIGHT);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target[1]);
    gl->Viewport(0, 0, WIDTH, HEIGHT);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (d->stage <= WEFT_STAGE_COLOUR)
        gl->Enable(GL_DEPTH_TEST);
    gl->LineWidth(2.0f);
    gl->PointSize(3.0f);
    if (d->stage > WEFT_STAGE_COLOUR)
        gl->PolygonMode(GL_FRONT_AND_BACK, d->stage == WEFT_STAGE_LINES ? GL_LINE : GL_POINT);
    draw_stage(gl, d);
    gl->ReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_FLOAT, d->out);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl->DeleteFramebuffers(1, &buffer);
    gl->DeleteRenderbuffers(2, target);
    return gl->GetError() == GL_NO_ERROR ? WEFT_OK : WEFT_ERR_GL;
}

static scene_drawing *begin(const struct scene *scene, bool by_triangle, struct scene_frame *frame)
{
    scene_drawing *drawing = NULL;
    assert_int_equal(
        scene_drawing_create(scene_drawing_params(.scene = scene, .context = contexts[0],
                                                  .shadow_size = 128, .by_triangle = by_triangle,
                                                  .log = &log_to_stderr),
                             &drawing),
        WEFT_OK);
    *frame = (struct scene_frame){.camera = {.size = {WIDTH, HEIGHT}}, .time = 0.25};
    scene_lamps_in_middle(scene, frame);
    return drawing;
}

static void run(struct drawn_pass *d)
{
    assert_int_equal(weft_context_call(contexts[0], draw_pass, d), WEFT_OK);
}

// ---- colours and depths -------------------------------------------------------------------------

// What covers a pixel has the bytes that the frame has, with depths drawn first or not.
static void test_colours(void **state)
{
    (void)state;
    static float colour[4 * PIXELS], again[4 * PIXELS];
    for (int i = 0; i < SCENES; i++) {
        struct scene scene;
        struct scene_frame frame;
        int covered = 0;
        if (!make_named(i, &scene))
            continue;
        scene_drawing *drawing = begin(&scene, false, &frame);
        float *picture = draw_mean(contexts[0], drawing, 1, &frame);
        struct drawn_pass pass = {drawing, &frame, WEFT_STAGE_COLOUR, colour_head, false, colour};
        run(&pass);
        pass.depths_first = true;
        pass.out = again;
        run(&pass);
        assert_memory_equal(colour, again, sizeof colour);
        for (int k = 0; k < PIXELS; k++) {
            if (colour[4 * k + 3] == 1.0f)
                assert_memory_equal(&colour[4 * k], &picture[4 * k], 4 * sizeof *colour);
            covered += colour[4 * k + 3] == 1.0f;
        }
        assert_true(covered > PIXELS / 8);
        free(picture);
        scene_drawing_destroy(&drawing);
        scene_clear(&scene);
    }
}

// ---- surfaces -----------------------------------------------------------------------------------

// The place of a triangle in the scene's list.
static size_t find_triangle(const struct scene *scene, const uint32_t vertex[3])
{
    for (size_t i = 0; i < scene->index_count / 3; i++)
        if (memcmp(&scene->indices[3 * i], vertex, 3 * sizeof *vertex) == 0)
            return i;
    return SIZE_MAX;
}

static void check_surfaces(int i, const struct scene *scene, bool by_triangle)
{
    static float picture[4 * PIXELS];
    struct scene_frame frame;
    struct scene_triangles triangles;
    struct scene_edges edges;
    struct traced_camera camera;
    struct weft_camera moved;
    int count = 0;
    scene_drawing *drawing = begin(scene, by_triangle, &frame);
    struct drawn_pass pass = {drawing, &frame, WEFT_STAGE_COLOUR, surface_head, true, picture};
    run(&pass);
    assert_int_equal(scene_triangles_make(scene, frame.time, &triangles), WEFT_OK);
    assert_int_equal(scene_edges_find(scene, &edges), WEFT_OK);
    scene_camera_at(scene, frame.time, &moved);
    find_camera(&moved, frame.camera.size, frame.time, &camera);
    for (int k = 0; k < PIXELS; k += 7) {
        const double x = k % WIDTH + 0.5, y = k / WIDTH + 0.5;
        struct traced_point point;
        trace_pixel(&triangles, &camera, x, y, &point);
        if (!is_inside(&triangles, &camera, x, y, point.triangle))
            continue;
        size_t wanted = 0;
        if (point.triangle != SIZE_MAX) {
            const size_t t = find_triangle(scene, triangles.list[point.triangle].vertex);
            wanted = by_triangle ? t + 1 : edges.surface[t];
        }
        if (picture[4 * k] != (float)wanted)
            fail_msg("%s, pixel %d: surface %g instead of %zu", names[i], k, picture[4 * k],
                     wanted);
        count++;
    }
    assert_true(count > PIXELS / 12);
    scene_edges_clear(&edges);
    scene_triangles_clear(&triangles);
    scene_drawing_destroy(&drawing);
}

static void test_surfaces(void **state)
{
    (void)state;
    for (int i = 0; i < SCENES; i++) {
        struct scene scene;
        if (!make_named(i, &scene))
            continue;
        check_surfaces(i, &scene, i % 2);
        if (i < 2)
            check_surfaces(i, &scene, !(i % 2));
        scene_clear(&scene);
    }
}

// ---- lines --------------------------------------------------------------------------------------

// Two pixels side by side that show different surfaces have a line or a point on one of them at
// least; most of what is inside of surfaces has none. Nothing here goes through anything else.
static void check_lines(int i, const struct scene *scene, bool by_triangle)
{
    static float surface[4 * PIXELS], line[4 * PIXELS], point[4 * PIXELS];
    struct scene_frame frame;
    int edges = 0, marked = 0;
    scene_drawing *drawing = begin(scene, by_triangle, &frame);
    run(&(struct drawn_pass){drawing, &frame, WEFT_STAGE_COLOUR, surface_head, false, surface});
    run(&(struct drawn_pass){drawing, &frame, WEFT_STAGE_LINES, surface_head, false, line});
    run(&(struct drawn_pass){drawing, &frame, WEFT_STAGE_POINTS, surface_head, false, point});
    for (int k = 0; k < PIXELS; k++) {
        const bool here = line[4 * k] > 0.0f || point[4 * k] > 0.0f;
        marked += here;
        for (int way = 0; way < 2; way++) {
            const int next = k + (way ? WIDTH : 1);
            if ((way ? next >= PIXELS : next % WIDTH == 0) || surface[4 * k] == surface[4 * next])
                continue;
            edges++;
            if (!here && !(line[4 * next] > 0.0f || point[4 * next] > 0.0f))
                fail_msg("%s: no line between pixels %d and %d, of surfaces %g and %g", names[i], k,
                         next, surface[4 * k], surface[4 * next]);
        }
    }
    assert_true(edges > 50);
    if (i != 3 && !by_triangle)
        assert_true(marked < PIXELS * 6 / 10);
    scene_drawing_destroy(&drawing);
}

static void test_lines(void **state)
{
    (void)state;
    static const int list[] = {0, 1, 3, 4, 5, 6, 7};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        struct scene scene;
        if (!make_named(list[i], &scene))
            continue;
        check_lines(list[i], &scene, false);
        check_lines(list[i], &scene, true);
        scene_clear(&scene);
    }
}

// ---- accumulative anti-aliasing -----------------------------------------------------------------

struct prepared {
    scene_drawing *drawing;
    const struct scene_frame *frame;
};

static enum weft_result prepare(void *priv)
{
    const struct prepared *p = priv;
    return scene_drawing_prepare(p->drawing, p->frame);
}

// Draws a scene by a form and a remedy; returns how many weights are wrong.
static int64_t count_wrong(const struct scene *scene, enum weft_acaa_form form,
                           enum weft_acaa_coincident coincident, int samples, float *red)
{
    struct scene_frame frame;
    struct weft_acaa_report report;
    weft_acaa *acaa = NULL;
    scene_drawing *drawing = begin(scene, false, &frame);
    assert_int_equal(weft_context_call(contexts[0], prepare, &(struct prepared){drawing, &frame}),
                     WEFT_OK);
    assert_int_equal(
        weft_acaa_create(weft_acaa_params(.width = WIDTH, .height = HEIGHT, .samples = samples,
                                          .form = form, .coincident = coincident,
                                          .context = contexts[0], .log = &log_to_stderr),
                         &acaa),
        WEFT_OK);
    assert_int_equal(
        weft_acaa_run(acaa,
                      &(struct weft_antialias_drawing){.draw = scene_drawing_pass, .priv = drawing},
                      NULL),
        WEFT_OK);
    weft_acaa_get_report(acaa, &report);
    assert_int_equal(weft_acaa_read(acaa, 0, red, 0), WEFT_OK);
    weft_acaa_destroy(&acaa);
    scene_drawing_destroy(&drawing);
    return report.less + report.more;
}

// Every sample of every built-in scene counts once; both forms give the same bytes.
static void test_weights(void **state)
{
    (void)state;
    static float red[2][PIXELS];
    for (int i = 0; i < SCENES; i++) {
        struct scene scene;
        if (!make_named(i, &scene))
            continue;
        const int samples = i == 1 ? 16 : 4;
        for (int form = 0; form < 2; form++)
            assert_int_equal(count_wrong(&scene, form ? WEFT_ACAA_SAMPLE_ID : WEFT_ACAA_POST_DEPTH,
                                         WEFT_COINCIDENT_STENCIL, samples, red[form]),
                             0);
        assert_memory_equal(red[0], red[1], sizeof red[0]);
        scene_clear(&scene);
    }
}

// Cornell's blocks stand on the floor without bottoms and the lamp lies in a hole: nothing of it is
// in one place. With the lamp twice its samples count twice, without a remedy.
static void test_coincident(void **state)
{
    (void)state;
    static float red[2][PIXELS];
    struct scene scene;
    assert_true(make_named(1, &scene));
    assert_int_equal(count_wrong(&scene, WEFT_ACAA_AUTO, WEFT_COINCIDENT_NONE, 4, red[0]), 0);
    struct scene_object *grown =
        realloc(scene.objects, (size_t)(scene.object_count + 1) * sizeof *grown);
    assert_non_null(grown);
    scene.objects = grown;
    grown[scene.object_count] = grown[scene.object_count - 1];
    scene.object_count++;
    assert_true(count_wrong(&scene, WEFT_ACAA_AUTO, WEFT_COINCIDENT_NONE, 4, red[1]) > 20);
    assert_int_equal(count_wrong(&scene, WEFT_ACAA_AUTO, WEFT_COINCIDENT_STENCIL, 4, red[1]), 0);
    assert_memory_equal(red[0], red[1], sizeof red[0]);
    scene_clear(&scene);
}

int main(void)
{
    if (WITHOUT_GL)
        return EXIT_SKIPPED;
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colours),    cmocka_unit_test(test_surfaces),
        cmocka_unit_test(test_lines),      cmocka_unit_test(test_weights),
        cmocka_unit_test(test_coincident),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
