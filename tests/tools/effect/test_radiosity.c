// SPDX-License-Identifier: BSD-3-Clause
// Instant radiosity, drawn and accumulated: the furnace against its analytic value, the Cornell box
// against a path tracer, and what clamping loses. WEFT_RADIOSITY=full takes larger pictures and
// more seeds.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/tools/effect/path_tracer.h"
#include "tests/tools/effect/pictures.h"
#include "tools/effect/lights/lights.h"

static bool is_full(void)
{
    const char *text = getenv("WEFT_RADIOSITY");
    return text && strcmp(text, "full") == 0;
}

static struct scene named(const char *name)
{
    struct scene scene;
    assert_int_equal(
        scene_make(scene_params(.name = name, .size = {64, 64}, .log = &log_to_stderr), &scene),
        WEFT_OK);
    return scene;
}

// What is drawn.
struct request {
    const struct scene *scene;
    int side, shadow_size;
    int64_t lights;
    uint64_t seed;
    double clamp;
    bool clamped_share;
};

static struct picture draw(const struct request *request)
{
    struct picture out = {.size = {request->side, request->side}};
    struct effect_plan plan = plan_made(
        effect_params(.effects = EFFECT_RADIOSITY, .scene = {request->scene}, .scene_count = 1,
                      .size = {request->side, request->side}, .frames = request->lights,
                      .seed = request->seed, .clamp = request->clamp));
    scene_drawing *drawing = NULL;
    weft_accumulator *accumulator = NULL;
    assert_int_equal(plan.count, request->lights);
    assert_int_equal(
        scene_drawing_create(scene_drawing_params(.scene = request->scene, .context = contexts[0],
                                                  .shadow_size = request->shadow_size,
                                                  .log = &log_to_stderr),
                             &drawing),
        WEFT_OK);
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(.width = request->side, .height = request->side,
                                    .channel_count = 4, .method = WEFT_ACCUMULATE_FLOAT,
                                    .context = contexts[0], .log = &log_to_stderr,
                                    .nonfinite = WEFT_NONFINITE_PROPAGATE),
            &accumulator),
        WEFT_OK);
    assert_int_equal(
        effect_run(effect_run_params(.plan = &plan, .drawing = &drawing, .accumulator = accumulator,
                                     .clamped_share = request->clamped_share),
                   NULL),
        WEFT_OK);
    read_picture(accumulator, &out);
    weft_accumulator_destroy(&accumulator);
    scene_drawing_destroy(&drawing);
    effect_plan_clear(&plan);
    return out;
}

static double mean_of(const struct picture *picture, int channel)
{
    double sum = 0.0;
    for (int y = 0; y < picture->size[1]; y++)
        for (int x = 0; x < picture->size[0]; x++)
            sum += pixel_at(picture, channel, x, y);
    return sum / ((double)picture->size[0] * picture->size[1]);
}

// ---- the furnace --------------------------------------------------------------------------------

// The mean of the picture is E / (1 - rho): over 8 seeds within 2 %, and within 4 standard errors
// as the seeds tell them, which are below 1 %.
static void test_furnace(void **state)
{
    (void)state;
    enum { SEEDS = 8 };
    static const double reflectances[] = {0.3, 0.5, 0.7};
    for (size_t r = 0; r < WEFT_COUNT(reflectances); r++) {
        char name[32];
        snprintf(name, sizeof name, "furnace:%g", reflectances[r]);
        struct scene scene = named(name);
        double sum = 0.0, squares = 0.0;
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            struct picture picture = draw(&(struct request){.scene = &scene,
                                                            .side = is_full() ? 128 : 32,
                                                            .shadow_size = 128,
                                                            .lights = is_full() ? 1024 : 128,
                                                            .seed = seed});
            const double mean = mean_of(&picture, 1);
            sum += mean / SEEDS;
            squares += mean * mean / SEEDS;
            free(picture.value);
        }
        const double expected = 1.0 / (1.0 - (float)reflectances[r]);
        const double error = sqrt(fmax(squares - sum * sum, 0.0) / (SEEDS - 1));
        print_message("furnace of %g: %.4f +- %.4f instead of %.4f\n", reflectances[r], sum, error,
                      expected);
        assert_near(sum, expected, 0.02 * expected, "mean");
        assert_near(sum, expected, 4.0 * error, "mean, by its standard error");
        assert_true(error < 0.01 * expected);
        scene_clear(&scene);
    }
}

// ---- the Cornell box ----------------------------------------------------------------------------

// Pixels of two pictures that agree, of those farther away from all other surfaces than the side of
// the patch that a light stands for.
struct agreement {
    int pixels, within;
    double mean[3], reference[3]; // of all pixels
    double error;                 // of the reference: standard error of a pixel, relative, mean
};

static struct agreement compare(const struct picture *picture, const struct traced_pixel *pixels,
                                double clearance)
{
    struct agreement out = {0};
    const int count = picture->size[0] * picture->size[1];
    for (int i = 0; i < count; i++) {
        const struct traced_pixel *pixel = &pixels[i];
        double drawn = 0.0, traced = 0.0, error = 0.0;
        for (int c = 0; c < 3; c++) {
            const double value = pixel_at(picture, c, i % picture->size[0], i / picture->size[0]);
            const double mean = pixel->triangle == SIZE_MAX ? 0.0 : pixel->radiance.mean[c];
            out.mean[c] += value / count;
            out.reference[c] += mean / count;
            drawn += value / 3.0;
            traced += mean / 3.0;
            error += pixel->triangle == SIZE_MAX ? 0.0 : pixel->radiance.error[c] / 3.0;
        }
        if (pixel->triangle == SIZE_MAX || !(pixel->clearance > clearance))
            continue;
        out.pixels++;
        out.within += fabs(drawn - traced) <= 0.1 * traced;
        out.error += error / traced;
    }
    out.error /= out.pixels;
    return out;
}

// 1,024 virtual lights, not clamped, against the path tracer: means within 2 %, and 95 % of the
// pixels away from corners within 10 %. A 16th of the lights does not do that.
static void test_cornell(void **state)
{
    (void)state;
    const int side = is_full() ? 64 : 24, samples = is_full() ? 6000 : 4000;
    static const int64_t lights = 1024;
    struct scene scene = named("cornell");
    struct tracer tracer;
    struct traced_pixel *pixels = calloc((size_t)(side * side), sizeof *pixels);
    assert_non_null(pixels);
    tracer_make(&scene, 0.0, &tracer);
    tracer_picture(&tracer, &scene.camera, (int[]){side, side}, samples, 1, 2, pixels);
    double area = 0.0;
    for (size_t t = 0; t < tracer.triangles.count; t++)
        area += tracer.triangles.list[t].area;
    const double clearance = sqrt(area / (double)lights);
    const int seeds = is_full() ? 8 : 1;
    for (int seed = 0; seed <= seeds; seed++) {
        const bool is_enough = seed < seeds;
        struct picture picture = draw(&(struct request){.scene = &scene,
                                                        .side = side,
                                                        .shadow_size = 128,
                                                        .lights = is_enough ? lights : lights / 16,
                                                        .seed = (uint64_t)seed});
        const struct agreement found = compare(&picture, pixels, clearance);
        const double share = (double)found.within / found.pixels;
        print_message(
            "cornell, seed %d: %.1f %% of %d pixels farther than %.1f within 10 %%; means "
            "%.4f %.4f %.4f of %.4f %.4f %.4f; the reference's pixels +- %.1f %%\n",
            seed, 100.0 * share, found.pixels, clearance, found.mean[0], found.mean[1],
            found.mean[2], found.reference[0], found.reference[1], found.reference[2],
            100.0 * found.error);
        // More than half of those that see the box, which is all of the picture but its rim.
        assert_true(found.pixels > side * side / 2);
        assert_true(is_enough ? share >= 0.95 : share < 0.95);
        for (int c = 0; c < 3 && is_enough; c++)
            assert_near(found.mean[c], found.reference[c], 0.02 * found.reference[c], "mean");
        free(picture.value);
    }
    tracer_clear(&tracer);
    scene_clear(&scene);
    free(pixels);
}

// ---- clamping -----------------------------------------------------------------------------------

// What is clamped and what that takes away are together the picture without clamping, in every
// pixel; the looser the clamp, the less is lost.
static void test_lost(void **state)
{
    (void)state;
    static const double clamps[] = {1e-6, 1e-5, 1e-4, 0.0};
    struct scene scene = named("cornell");
    struct request request = {.scene = &scene, .side = 32, .shadow_size = 128, .lights = 64};
    struct picture whole = draw(&request);
    double before = 1.0;
    for (size_t k = 0; k < WEFT_COUNT(clamps); k++) {
        request.clamp = clamps[k];
        request.clamped_share = false;
        struct picture kept = draw(&request);
        request.clamped_share = true;
        struct picture lost = draw(&request);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 32 * 32; i++) {
                const double all = pixel_at(&whole, c, i % 32, i / 32);
                const double sum =
                    (double)pixel_at(&kept, c, i % 32, i / 32) + pixel_at(&lost, c, i % 32, i / 32);
                // 64 sums of floats, of terms that are all positive.
                assert_near(sum, all, 64.0 * 0x1p-23 * all, "kept and lost");
            }
        const double share = mean_of(&lost, 1) / mean_of(&whole, 1);
        print_message("clamped to %g: %.3f %% of the light is lost\n", clamps[k], 100.0 * share);
        assert_true(share >= 0.0 && share < before);
        assert_true(clamps[k] > 0.0 ? share > 0.0 : share == 0.0);
        before = share;
        free(kept.value);
        free(lost.value);
    }
    free(whole.value);
    scene_clear(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_cornell),
        cmocka_unit_test(test_lost),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
