// SPDX-License-Identifier: BSD-3-Clause
// Rays: what they hit against a test of each triangle in long double, and watertight surfaces.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tools/scene/build.h"
#include "tools/scene/rays.h"

// The plane through three corners, then the side of each edge: the distance, or INFINITY; NAN where
// it passes an edge too closely to tell.
static long double meet(const struct scene_triangle *t, const double origin[3],
                        const double direction[3])
{
    long double u[3], v[3], n[3], up = 0.0L, down = 0.0L, at[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (long double)t->corner[1][i] - t->corner[0][i];
        v[i] = (long double)t->corner[2][i] - t->corner[0][i];
    }
    for (int i = 0; i < 3; i++)
        n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    for (int i = 0; i < 3; i++) {
        up += n[i] * ((long double)t->corner[0][i] - origin[i]);
        down += n[i] * direction[i];
    }
    const long double distance = up / down;
    if (!(down != 0.0L && distance > 0.0L))
        return INFINITY;
    for (int i = 0; i < 3; i++)
        at[i] = origin[i] + distance * direction[i];
    bool close = false;
    for (int k = 0; k < 3; k++) {
        const double *a = t->corner[k], *b = t->corner[(k + 1) % 3];
        long double side = 0.0L, size = 0.0L;
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, l = (i + 2) % 3;
            side += n[i] * (((long double)b[j] - a[j]) * (at[l] - a[l]) -
                            ((long double)b[l] - a[l]) * (at[j] - a[j]));
            size += n[i] * n[i];
        }
        if (side < -1e-9L * size)
            return INFINITY;
        close |= side < 1e-9L * size;
    }
    return close ? NAN : distance;
}

// The nearest by all triangles, but one; NAN where it cannot be told.
static long double meet_all(const struct scene_triangles *triangles, const double origin[3],
                            const double direction[3], size_t from, bool *culled)
{
    long double nearest = INFINITY;
    for (size_t t = 0; t < triangles->count; t++) {
        const struct scene_triangle *triangle = &triangles->list[t];
        const bool back = scene_dot(direction, triangle->normal) > 0.0;
        const long double distance = meet(triangle, origin, direction);
        if (t == from || isinf(distance))
            continue;
        if (back && triangles->scene->materials[triangle->material].single_sided)
            *culled = true;
        else
            nearest = isnan(distance) || distance < nearest ? distance : nearest;
        if (isnan(nearest))
            return nearest;
    }
    return nearest;
}

static void check_scene(const char *name, int rays, int *met, int *missed, int *culled)
{
    struct scene s;
    struct scene_triangles triangles;
    uint64_t random = 9;
    assert_int_equal(
        scene_make(scene_params(.name = name, .size = {64, 64}, .seed = 2, .log = &log_to_stderr),
                   &s),
        WEFT_OK);
    for (int i = 0; i < s.material_count; i += 2)
        s.materials[i].single_sided = true;
    assert_int_equal(scene_triangles_make(&s, 0.25, &triangles), WEFT_OK);
    for (int r = 0; r < rays; r++) {
        double origin[3], direction[3];
        struct scene_hit hit = {0};
        for (int i = 0; i < 3; i++) {
            const double low = fmax(s.low[i], -20.0), high = fmin(s.high[i], 600.0);
            origin[i] = low + (high - low) * (1.4 * random_unit(&random) - 0.2);
            direction[i] = r % 7 == i ? 0.0 : random_unit(&random) - 0.5;
        }
        const size_t from = r % 3 ? SIZE_MAX : random_next(&random) % triangles.count;
        bool was_culled = false;
        const long double expected = meet_all(&triangles, origin, direction, from, &was_culled);
        if (isnan(expected))
            continue;
        const bool found = scene_triangles_hit(&triangles, origin, direction, from, INFINITY, &hit);
        assert_int_equal(found, !isinf(expected));
        assert_int_equal(scene_triangles_hit(&triangles, origin, direction, from, INFINITY, NULL),
                         found);
        *culled += was_culled;
        *(found ? met : missed) += 1;
        if (!found)
            continue;
        assert_near(hit.distance, (double)expected, 1e-9 * (double)expected, "the distance");
        // It is the nearest: nothing is before it, and it is there a little further on.
        assert_false(scene_triangles_hit(&triangles, origin, direction, from,
                                         hit.distance * (1.0 - 1e-9), NULL));
        assert_true(scene_triangles_hit(&triangles, origin, direction, from,
                                        hit.distance * (1.0 + 1e-9), NULL));
        double point[3];
        scene_triangle_point(&triangles.list[hit.triangle], hit.weight, point);
        for (int i = 0; i < 3; i++)
            assert_near(point[i], origin[i] + hit.distance * direction[i],
                        1e-5 * (1.0 + fabs(point[i])), "the point");
    }
    scene_triangles_clear(&triangles);
    scene_clear(&s);
}

static void test_hits_are_the_nearest_of_all(void **state)
{
    (void)state;
    int met = 0, missed = 0, culled = 0;
    check_scene("cornell", 3000, &met, &missed, &culled);
    check_scene("moving", 1000, &met, &missed, &culled);
    check_scene("penumbra", 2000, &met, &missed, &culled);
    check_scene("polygons:200", 1000, &met, &missed, &culled);
    check_scene("plane", 60, &met, &missed, &culled);
    assert_true(met > 2000 && missed > 2000 && culled > 200);
    assert_true(met + missed > 6000);
}

// From within, rays to the corners, along the edges and through the diagonals of a box come nowhere
// through, of a ball neither.
static void test_closed_surfaces_are_closed(void **state)
{
    (void)state;
    struct scene s = {0};
    struct scene_build build = {.scene = &s};
    struct scene_triangles triangles;
    scene_build_object(&build, "box", scene_build_material(&build, &(struct scene_material){0}));
    scene_build_box(&build, (double[]){-1.0, -0.7, -1.3}, (double[]){1.0, 0.9, 1.1});
    scene_build_ball(&build, (double[]){0.1, 0.2, 0.3}, 0.5, 24);
    assert_int_equal(scene_build_end(&build, &log_to_stderr), WEFT_OK);
    assert_int_equal(scene_triangles_make(&s, 0.0, &triangles), WEFT_OK);
    uint64_t random = 4;
    int ran = 0;
    for (int k = 0; k < 12; k++) {
        double origin[3];
        for (int i = 0; i < 3; i++)
            origin[i] = (double[]){0.1, 0.2, 0.3}[i] + 0.4 * (random_unit(&random) - 0.5);
        for (size_t t = 0; t < triangles.count; t += k % 5 + 1)
            for (int share = 0; share <= 4; share++, ran++) {
                const struct scene_triangle *triangle = &triangles.list[t];
                double direction[3];
                for (int i = 0; i < 3; i++)
                    direction[i] = triangle->corner[0][i] +
                                   share / 4.0 * (triangle->corner[1][i] - triangle->corner[0][i]) -
                                   origin[i];
                assert_true(
                    scene_triangles_hit(&triangles, origin, direction, SIZE_MAX, 1.0 + 1e-6, NULL));
            }
    }
    assert_true(ran > 5000);
    scene_triangles_clear(&triangles);
    scene_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hits_are_the_nearest_of_all),
        cmocka_unit_test(test_closed_surfaces_are_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
