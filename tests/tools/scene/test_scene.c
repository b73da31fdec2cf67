// SPDX-License-Identifier: BSD-3-Clause
// Scenes by name: what was published of them, what is analytic of them, and what is refused.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "tools/scene/build.h"
#include "tools/scene/rays.h"

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};
static const int size[2] = {512, 512};

static void make(const char *name, uint64_t seed, struct scene *out)
{
    assert_int_equal(scene_make(scene_params(.name = name, .seed = seed, .size = {size[0], size[1]},
                                             .log = &log_to_stderr),
                                out),
                     WEFT_OK);
}

static void triangles_of(const struct scene *scene, double time, struct scene_triangles *out)
{
    assert_int_equal(scene_triangles_make(scene, time, out), WEFT_OK);
}

// ---- all scenes ---------------------------------------------------------------------------------

// Everything that is said of scenes holds; the camera sees something, and all is in the box.
static void check_scene(const struct scene *s)
{
    size_t next = 0;
    assert_true(s->vertex_count > 0 && s->object_count > 0 && s->material_count > 0);
    for (int i = 0; i < s->object_count; i++) {
        const struct scene_object *o = &s->objects[i];
        assert_int_equal(o->first_index, next);
        assert_true(o->index_count > 0 && o->index_count % 3 == 0);
        assert_in_range(o->material, 0, s->material_count - 1);
        assert_true(o->name[0] != '\0');
        next += o->index_count;
        for (int k = 1; k < o->path.count; k++)
            assert_true(o->path.keys[k].time > o->path.keys[k - 1].time);
    }
    assert_int_equal(next, s->index_count);
    for (size_t i = 0; i < s->index_count; i++)
        assert_true(s->indices[i] < s->vertex_count);
    for (size_t i = 0; i < s->vertex_count; i++) {
        const float *n = s->vertices[i].normal;
        assert_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-6, "a normal's length");
    }
    for (int i = 0; i < s->material_count; i++)
        for (int k = 0; k < 3; k++) {
            assert_true(s->materials[i].reflectance[k] >= 0.0f);
            assert_true(s->materials[i].reflectance[k] <= 1.0f);
            assert_true(s->materials[i].emission[k] >= 0.0f);
        }
}

// Vertices' normals are the front's.
static void check_normals(const struct scene *s)
{
    struct scene_triangles triangles;
    triangles_of(s, 0.0, &triangles);
    assert_int_equal(triangles.count, s->index_count / 3); // all have an area
    for (size_t i = 0; i < triangles.count; i++)
        for (int k = 0; k < 3; k++) {
            const float *n = s->vertices[triangles.list[i].vertex[k]].normal;
            assert_true(scene_dot(triangles.list[i].normal, (double[]){n[0], n[1], n[2]}) > 0.9);
        }
    scene_triangles_clear(&triangles);
}

static void test_every_scene(void **state)
{
    (void)state;
    int ran = 0;
    for (; scene_list[ran]; ran++) {
        struct scene s;
        struct weft_camera camera;
        struct weft_camera_matrices matrices;
        double nearest, farthest;
        make(scene_list[ran]->name, 3, &s);
        assert_string_equal(s.name, scene_list[ran]->name);
        check_scene(&s);
        check_normals(&s);
        scene_camera_at(&s, 0.5, &camera);
        assert_int_equal(weft_camera_compute(&log_to_stderr, &camera,
                                             weft_camera_frame(.size = {512, 512}), &matrices),
                         WEFT_OK);
        scene_depths(&s, size, 0.5, &nearest, &farthest);
        assert_true(nearest >= camera.near_distance * (1.0 - 1e-9));
        assert_true(farthest <= camera.far_distance * (1.0 + 1e-9));
        scene_clear(&s);
        assert_null(s.vertices);
        scene_clear(&s);
    }
    assert_int_equal(ran, 7);
    scene_clear(NULL);
}

static void test_defaults_are_scenes(void **state)
{
    (void)state;
    static const char *const effects[] = {"fade", "motion-blur", "antialias",
                                          "dof",  "soft-shadow", "radiosity"};
    for (size_t i = 0; i < WEFT_COUNT(effects); i++) {
        const char *const *list = scene_find_default(effects[i]);
        assert_non_null(list);
        int count = 0;
        for (; list[count]; count++) {
            struct scene s;
            make(list[count], 0, &s);
            scene_clear(&s);
        }
        assert_int_equal(count, i == 0 ? 2 : 1);
    }
    assert_null(scene_find_default("bloom"));
}

// What an effect is for is to be seen in its scene.
static void test_defaults_show_their_effects(void **state)
{
    (void)state;
    struct scene s;
    double nearest, farthest;
    make(scene_find_default("motion-blur")[0], 0, &s);
    assert_true(scene_longest_motion(&s, size, 0.0, 1.0) > 30.0);
    scene_clear(&s);
    make(scene_find_default("soft-shadow")[0], 0, &s);
    assert_true(scene_widest_penumbra(&s, size, 0.5) > 20.0);
    scene_clear(&s);
    make(scene_find_default("dof")[0], 0, &s);
    scene_depths(&s, size, 0.5, &nearest, &farthest);
    assert_true(farthest > 100.0 * nearest);
    scene_clear(&s);
}

// ---- the Cornell box ----------------------------------------------------------------------------

// The published list, all of it, the block's sides too: four corners each.
static const double published[][4][3] = {
    // floor, light, ceiling, back, right, left
    {{552.8, 0, 0}, {0, 0, 0}, {0, 0, 559.2}, {549.6, 0, 559.2}},
    {{343, 548.8, 227}, {343, 548.8, 332}, {213, 548.8, 332}, {213, 548.8, 227}},
    {{556, 548.8, 0}, {556, 548.8, 559.2}, {0, 548.8, 559.2}, {0, 548.8, 0}},
    {{549.6, 0, 559.2}, {0, 0, 559.2}, {0, 548.8, 559.2}, {556, 548.8, 559.2}},
    {{0, 0, 559.2}, {0, 0, 0}, {0, 548.8, 0}, {0, 548.8, 559.2}},
    {{552.8, 0, 0}, {549.6, 0, 559.2}, {556, 548.8, 559.2}, {556, 548.8, 0}},
    // short block
    {{130, 165, 65}, {82, 165, 225}, {240, 165, 272}, {290, 165, 114}},
    {{290, 0, 114}, {290, 165, 114}, {240, 165, 272}, {240, 0, 272}},
    {{130, 0, 65}, {130, 165, 65}, {290, 165, 114}, {290, 0, 114}},
    {{82, 0, 225}, {82, 165, 225}, {130, 165, 65}, {130, 0, 65}},
    {{240, 0, 272}, {240, 165, 272}, {82, 165, 225}, {82, 0, 225}},
    // tall block
    {{423, 330, 247}, {265, 330, 296}, {314, 330, 456}, {472, 330, 406}},
    {{423, 0, 247}, {423, 330, 247}, {472, 330, 406}, {472, 0, 406}},
    {{472, 0, 406}, {472, 330, 406}, {314, 330, 456}, {314, 0, 456}},
    {{314, 0, 456}, {314, 330, 456}, {265, 330, 296}, {265, 0, 296}},
    {{265, 0, 296}, {265, 330, 296}, {423, 330, 247}, {423, 0, 247}},
};
enum { LIGHT = 1, CEILING = 2 };

static void make_normal(const double quad[4][3], double normal[3], double *area)
{
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = quad[2][i] - quad[0][i];
        v[i] = quad[3][i] - quad[1][i];
    }
    scene_cross(u, v, normal);
    *area = 0.5 * scene_normalise(normal);
}

// Whether all corners of a triangle are in the quad's plane and its front is the quad's. The left
// wall is twisted: its corners are up to 3.2 out of a plane.
static bool belongs(const struct scene_triangle *t, const double quad[4][3], const double normal[3])
{
    bool in_plane = scene_dot(t->normal, normal) > 0.999;
    for (int k = 0; k < 3; k++)
        in_plane &= fabs(scene_dot(t->corner[k], normal) - scene_dot(quad[0], normal)) < 4.0;
    return in_plane;
}

static bool has_corner(const struct scene_triangles *triangles, const double corner[3])
{
    bool found = false;
    for (size_t t = 0; t < triangles->count; t++)
        for (int k = 0; k < 3; k++) {
            const double *p = triangles->list[t].corner[k];
            // Corners are floats: of up to 559.2, by 3e-5 away at most.
            found |= fabs(p[0] - corner[0]) < 4e-5 && fabs(p[1] - corner[1]) < 4e-5 &&
                     fabs(p[2] - corner[2]) < 4e-5;
        }
    return found;
}

// Every quad is there with its corners, its area and its side; the ceiling without the lamp's. The
// light is on both sides of it one plane: what is of it is told from the ceiling by its emission.
static void test_cornell_is_as_published(void **state)
{
    (void)state;
    struct scene s;
    struct scene_triangles triangles;
    make("cornell", 0, &s);
    triangles_of(&s, 0.0, &triangles);
    assert_int_equal(triangles.count, 2 * WEFT_COUNT(published) + 6); // a ceiling of 4 quads
    size_t used = 0;
    for (size_t q = 0; q < WEFT_COUNT(published); q++) {
        double normal[3], area, sum = 0.0, light_area;
        make_normal(published[LIGHT], normal, &light_area);
        make_normal(published[q], normal, &area);
        for (int k = 0; k < 4; k++)
            assert_true(has_corner(&triangles, published[q][k]));
        for (size_t t = 0; t < triangles.count; t++) {
            const bool emits = s.materials[triangles.list[t].material].emission[0] > 0.0f;
            if (belongs(&triangles.list[t], published[q], normal) && emits == (q == LIGHT)) {
                sum += triangles.list[t].area;
                used++;
            }
        }
        // Corners are floats; a twist of 0.0057 makes 4e-6 of the area.
        assert_near(sum, area - (q == CEILING ? light_area : 0.0), 1e-5 * area, "a quad's area");
    }
    assert_int_equal(used, triangles.count);
    scene_triangles_clear(&triangles);
    scene_clear(&s);
}

static void assert_reflectance(const struct scene *s, const char *object, double r, double g,
                               double b)
{
    int found = 0;
    for (int i = 0; i < s->object_count; i++)
        if (strcmp(s->objects[i].name, object) == 0) {
            const float *f = s->materials[s->objects[i].material].reflectance;
            assert_near(f[0], r, 1e-7, object);
            assert_near(f[1], g, 1e-7, object);
            assert_near(f[2], b, 1e-7, object);
            found++;
        }
    assert_int_equal(found, 1);
}

static void test_cornell_colours_camera_and_light(void **state)
{
    (void)state;
    struct scene s;
    make("cornell", 0, &s);
    assert_reflectance(&s, "white walls", 0.725, 0.71, 0.68);
    assert_reflectance(&s, "tall block", 0.725, 0.71, 0.68);
    assert_reflectance(&s, "short block", 0.725, 0.71, 0.68);
    assert_reflectance(&s, "right wall", 0.14, 0.45, 0.091);
    assert_reflectance(&s, "left wall", 0.63, 0.065, 0.05);
    assert_reflectance(&s, "light", 0.0, 0.0, 0.0);
    assert_non_null(strstr(s.source, "Cornell"));
    assert_non_null(strstr(s.source, "Tungsten"));
    // Film 0.025 wide, focal length 0.035.
    assert_near(tan(s.camera.fovy_degrees * M_PI / 360.0), 0.0125 / 0.035, 1e-15, "the angle");
    assert_near(s.camera.fovy_degrees, 39.3077, 1e-4, "the angle, as others write it");
    const double eye[3] = {278.0, 273.0, -800.0}, radiance[3] = {17.0, 12.0, 4.0};
    const double down[3] = {0.0, -1.0, 0.0};
    double normal[3];
    assert_int_equal(s.light_count, 1);
    assert_true(s.lights[0].seen && s.lights[0].shape == SCENE_LIGHT_SQUARE);
    scene_cross(s.lights[0].u, s.lights[0].v, normal);
    assert_near(scene_normalise(normal), 130.0 * 105.0, 1e-9, "the lamp's area");
    for (int i = 0; i < 3; i++) {
        assert_near(s.camera.eye[i], eye[i], 0.0, "the eye");
        assert_near(s.camera.target[i] - eye[i], i == 2 ? 800.0 : 0.0, 0.0, "the sight");
        assert_near(s.lights[0].radiance[i], radiance[i], 0.0, "the radiance");
        assert_near(s.materials[s.objects[s.object_count - 1].material].emission[i], radiance[i],
                    0.0, "the emission");
        assert_near(normal[i], down[i], 1e-12, "the lamp's side");
    }
    const struct scene_object *light = &s.objects[s.object_count - 1];
    for (uint32_t i = 0; i < light->index_count; i++)
        assert_near(s.vertices[s.indices[light->first_index + i]].position[1],
                    s.lights[0].middle[1], 0.0, "the lamp in the plane of its corners");
    scene_clear(&s);
}

// ---- closed and analytic ------------------------------------------------------------------------

// Rays from the camera, all around, meet the front of a wall; walls emit 1 and reflect rho.
static void test_furnace_is_closed(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double rho;
    } cases[] = {{"furnace", 0.5}, {"furnace:0", 0.0}, {"furnace:0.75", 0.75}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct scene s;
        struct scene_triangles triangles;
        uint64_t random = 1;
        make(cases[i].name, 0, &s);
        triangles_of(&s, 0.0, &triangles);
        for (int k = 0; k < 2000; k++) {
            double along[3];
            struct scene_hit hit;
            for (int axis = 0; axis < 3; axis++)
                along[axis] = random_unit(&random) - 0.5;
            assert_true(
                scene_triangles_hit(&triangles, s.camera.eye, along, SIZE_MAX, INFINITY, &hit));
            assert_false(hit.back);
        }
        assert_int_equal(s.light_count, 0);
        assert_int_equal(s.material_count, 1);
        for (int k = 0; k < 3; k++) {
            assert_near(s.materials[0].emission[k], 1.0, 0.0, "the emission");
            assert_near(s.materials[0].reflectance[k], cases[i].rho, 0.0, "the reflectance");
            assert_near(s.ambient[k], 0.0, 0.0, "no light else");
        }
        scene_triangles_clear(&triangles);
        scene_clear(&s);
    }
}

static void test_cube_has_the_colours_of_its_places(void **state)
{
    (void)state;
    struct scene s;
    struct scene_triangles triangles;
    make("cube", 0, &s);
    assert_int_equal(s.index_count, 36);
    assert_true(s.materials[0].unlit);
    for (size_t i = 0; i < s.vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            const float p = s.vertices[i].position[k];
            assert_true(p == 0.0f || p == 1.0f);
            assert_true(s.vertices[i].colour[k] == p);
        }
    // Fronts are outside; three of the six faces are turned to the camera.
    triangles_of(&s, 0.0, &triangles);
    int seen = 0;
    for (size_t i = 0; i < triangles.count; i++) {
        const struct scene_triangle *t = &triangles.list[i];
        const double half[3] = {0.5, 0.5, 0.5};
        assert_near(scene_dot(t->normal, t->corner[0]) - scene_dot(t->normal, half), 0.5, 1e-12,
                    "the way out");
        seen += scene_dot(t->normal, s.camera.eye) > scene_dot(t->normal, t->corner[0]);
    }
    assert_int_equal(seen, 6);
    scene_triangles_clear(&triangles);
    scene_clear(&s);
}

// ---- polygons -----------------------------------------------------------------------------------

// Area on the picture of all triangles that share the first corner: one polygon.
static double find_pixels(const struct scene *s, const struct weft_camera_matrices *m,
                          size_t triangle)
{
    double at[3][2];
    for (int k = 0; k < 3; k++) {
        const float *f = s->vertices[s->indices[3 * triangle + (size_t)k]].position;
        double clip[4];
        for (int i = 0; i < 4; i++)
            clip[i] =
                m->clip[i] * f[0] + m->clip[4 + i] * f[1] + m->clip[8 + i] * f[2] + m->clip[12 + i];
        for (int i = 0; i < 2; i++)
            at[k][i] = 0.5 * size[i] * clip[i] / clip[3];
    }
    return 0.5 * ((at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) -
                  (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]));
}

static void check_polygons(const char *name, int expected, double area)
{
    struct scene s;
    struct weft_camera_matrices matrices;
    make(name, 11, &s);
    assert_int_equal(weft_camera_compute(&log_to_stderr, &s.camera,
                                         weft_camera_frame(.size = {512, 512}), &matrices),
                     WEFT_OK);
    int polygons = 0, quads = 0;
    for (size_t t = 0; t < s.index_count / 3; polygons++) {
        double sum = 0.0;
        const uint32_t first = s.indices[3 * t];
        const size_t start = t;
        for (; t < s.index_count / 3 && s.indices[3 * t] == first; t++)
            sum += find_pixels(&s, &matrices, t);
        quads += t - start == 2;
        // Corners are floats: 2^-24 of up to 15 is 0.0001 of a pixel at the least depth.
        assert_near(sum, area, 2e-4 * sqrt(area) * 4.0, "a polygon's pixels");
    }
    assert_int_equal(polygons, expected);
    // Half of them: within 4 standard deviations.
    assert_true(fabs(quads - 0.5 * expected) <= 2.0 * sqrt(expected) + 1.0);
    scene_clear(&s);
}

static void test_polygons_have_the_pixels_asked_for(void **state)
{
    (void)state;
    check_polygons("polygons", 4000, 50.0);
    check_polygons("polygons:300", 300, 50.0);
    check_polygons("polygons:500,12.5", 500, 12.5);
    check_polygons("polygons:1,1000", 1, 1000.0);
}

static bool same_bytes(uint64_t a, uint64_t b)
{
    struct scene s, t;
    make("polygons:200", a, &s);
    make("polygons:200", b, &t);
    const bool same = s.vertex_count == t.vertex_count && s.index_count == t.index_count &&
                      memcmp(s.vertices, t.vertices, s.vertex_count * sizeof *s.vertices) == 0 &&
                      memcmp(s.indices, t.indices, s.index_count * sizeof *s.indices) == 0;
    scene_clear(&s);
    scene_clear(&t);
    return same;
}

// SplitMix64's first numbers from the seed 1234567, as published with it (Vigna's splitmix64.c).
static void test_random_numbers_and_seeds(void **state)
{
    (void)state;
    static const uint64_t published_numbers[] = {
        UINT64_C(6457827717110365317), UINT64_C(3203168211198807973), UINT64_C(9817491932198370423),
        UINT64_C(4593380528125082431)};
    uint64_t random = 1234567;
    for (size_t i = 0; i < WEFT_COUNT(published_numbers); i++)
        assert_true(random_next(&random) == published_numbers[i]);
    assert_true(same_bytes(5, 5));
    assert_true(same_bytes(0, 0));
    assert_false(same_bytes(5, 6));
    assert_false(same_bytes(0, 1));
}

// ---- the motions of `moving` --------------------------------------------------------------------

// The bar's front is 4.95 away, and goes 0.48 evenly.
static void test_moving_bar(void **state)
{
    (void)state;
    struct scene s;
    make("moving", 0, &s);
    for (int i = 1; i < s.object_count; i++)
        s.objects[i].path.count = 0;
    const double expected = 0.48 / 4.95 * 512.0 / (2.0 * tan(M_PI / 9.0));
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), expected, 1e-4, "the bar's way");
    scene_clear(&s);
}

// ---- files --------------------------------------------------------------------------------------

// All corners are in the picture, between the near and far planes; tall and wide pictures.
static void check_fit(const char *path, const int picture[2])
{
    struct scene s;
    struct weft_camera_matrices m;
    const struct scene_params params = {
        .name = path, .size = {picture[0], picture[1]}, .log = &log_to_stderr};
    assert_int_equal(scene_make(&params, &s), WEFT_OK);
    check_scene(&s);
    assert_int_equal(weft_camera_compute(&log_to_stderr, &s.camera,
                                         weft_camera_frame(.size = {picture[0], picture[1]}), &m),
                     WEFT_OK);
    double widest = 0.0;
    for (size_t i = 0; i < s.index_count; i++) {
        const float *f = s.vertices[s.indices[i]].position;
        double clip[4];
        for (int k = 0; k < 4; k++)
            clip[k] =
                m.clip[k] * f[0] + m.clip[4 + k] * f[1] + m.clip[8 + k] * f[2] + m.clip[12 + k];
        for (int k = 0; k < 3; k++)
            assert_true(fabs(clip[k]) <= clip[3]);
        widest = fmax(widest, fmax(fabs(clip[0]), fabs(clip[1])) / clip[3]);
    }
    assert_near(widest, 0.9, 1e-6, "the share of the picture that it has");
    assert_int_equal(s.light_count, 1);
    scene_clear(&s);
}

static void test_files_are_all_in_sight(void **state)
{
    (void)state;
    static const char *const names[] = {"spot.obj",    "teapot.obj",  "suzanne.obj",
                                        "suzanne.ply", "suzanne.glb", "spot_triangulated.obj"};
    int ran = 0;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/mesh/%s", WEFT_TEST_DATA, names[i]);
        if (access(path, R_OK) != 0)
            continue;
        check_fit(path, (const int[2]){256, 256});
        check_fit(path, (const int[2]){400, 100});
        check_fit(path, (const int[2]){100, 400});
        ran++;
    }
    if (ran == 0)
        skip();
}

// ---- what is refused ----------------------------------------------------------------------------

static void test_bad_names(void **state)
{
    (void)state;
    static const struct {
        const char *name, *says;
    } cases[] = {
        {"", "there are cube, cornell, furnace[:RHO], polygons[:N[,PIXELS]], plane, moving"},
        {"cubes", "no scene 'cubes'"},
        {"cub", "no scene 'cub'"},
        {"Cube", "no scene 'Cube'"},
        {"obj", "no scene 'obj'"},
        {"cu\x1b"
         "be",
         "no scene 'cu?be'"},
        {"cube:", "the scene cube has no arguments"},
        {"cornell:1", "the scene cornell has no arguments"},
        {"polygons:", "the count must be a whole number from 1 to 1000000"},
        {"polygons:0", "the count"},
        {"polygons:-3", "the count"},
        {"polygons:2.5", "the count"},
        {"polygons:1000001", "the count"},
        {"polygons:1e300", "the count"},
        {"polygons:nan", "the count"},
        {"polygons:0x10", "the count"},
        {"polygons: 5", "the count"},
        {"polygons:5,", "the area in pixels must be a number from 0.01 to 1000000"},
        {"polygons:5,0", "the area"},
        {"polygons:5,inf", "the area"},
        {"polygons:5,6,7", "more than the scene's 2 numbers: 7"},
        {"furnace:1", "reflectance must be a number from 0 to 0.99"},
        {"furnace:-0.1", "reflectance"},
        {"furnace:0.5;", "reflectance"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct scene s;
        last = (struct message){0};
        assert_int_equal(
            scene_make(scene_params(.name = cases[i].name, .size = {64, 64}, .log = &remember_log),
                       &s),
            WEFT_ERR_ARGUMENT);
        if (last.count != 1 || !strstr(last.text, cases[i].says))
            fail_msg("%s: %d lines, %s", cases[i].name, last.count, last.text);
        assert_memory_equal(&s, &(struct scene){0}, sizeof s);
    }
}

static void test_bad_sizes_and_files(void **state)
{
    (void)state;
    static const int sizes[][2] = {{0, 64}, {64, 0}, {-1, 64}, {65537, 1}};
    struct scene s;
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++) {
        last = (struct message){0};
        assert_int_equal(scene_make(scene_params(.name = "cube", .log = &remember_log,
                                                 .size = {sizes[i][0], sizes[i][1]}),
                                    &s),
                         WEFT_ERR_ARGUMENT);
        assert_int_equal(last.count, 1);
        assert_non_null(strstr(last.text, "1 to 65536"));
    }
    last = (struct message){0};
    assert_int_not_equal(
        scene_make(scene_params(.name = "/nowhere/a.OBJ", .size = {64, 64}, .log = &remember_log),
                   &s),
        WEFT_OK);
    assert_int_equal(last.count, 1);
    assert_memory_equal(&s, &(struct scene){0}, sizeof s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_scene),
        cmocka_unit_test(test_defaults_are_scenes),
        cmocka_unit_test(test_defaults_show_their_effects),
        cmocka_unit_test(test_cornell_is_as_published),
        cmocka_unit_test(test_cornell_colours_camera_and_light),
        cmocka_unit_test(test_furnace_is_closed),
        cmocka_unit_test(test_cube_has_the_colours_of_its_places),
        cmocka_unit_test(test_polygons_have_the_pixels_asked_for),
        cmocka_unit_test(test_random_numbers_and_seeds),
        cmocka_unit_test(test_moving_bar),
        cmocka_unit_test(test_files_are_all_in_sight),
        cmocka_unit_test(test_bad_names),
        cmocka_unit_test(test_bad_sizes_and_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
