// SPDX-License-Identifier: BSD-3-Clause
// The same effects by every method of accumulation: within its bound of the exact mean of the
// frames that were drawn, and as its emulation has it, bit for bit.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

enum { WIDTH = 40, HEIGHT = 24, PIXELS = WIDTH * HEIGHT, FRAMES = 24, VALUES = 4 * PIXELS };
static const int size[2] = {WIDTH, HEIGHT};
static struct scene scene;

// Coloured rectangles at several depths, some of which move.
static int make_scene(void **state)
{
    uint64_t seed = 21;
    struct scene_build build = empty_scene(&scene, size);
    for (int i = 0; i < 12; i++) {
        const double depth = random_in(&seed, 8.0, 20.0), half[2] = {4.0, 2.5};
        const double middle[2] = {random_in(&seed, -12.0, 12.0), random_in(&seed, -8.0, 8.0)};
        const float red = (float)random_in(&seed, 0.0, 1.0);
        const int colour = add_colour(&build, red, (float)random_in(&seed, 0.0, 1.0), 1.0f - red);
        add_rectangle(&build, colour, depth, middle, half, random_in(&seed, 0.0, M_PI));
        if (i % 2)
            move_last(&build, random_in(&seed, -6.0, 6.0), random_in(&seed, -6.0, 6.0));
    }
    end_scene(&build);
    return create_contexts(state);
}

static int clear_scene(void **state)
{
    scene_clear(&scene);
    return destroy_contexts(state);
}

// ---- frames -------------------------------------------------------------------------------------

// All frames as they are drawn into targets of so many bits, read back one by one; those of the
// same bits once.
struct frames {
    weft_context *context;
    const struct effect_plan *plan;
    scene_drawing *drawing;
    bool is_read[WEFT_ACCUMULATE_HALF + 16];
    float value[WEFT_ACCUMULATE_HALF + 16][FRAMES][VALUES];
};

static float (*read_frames(struct frames *frames, int bits))[VALUES]
{
    float(*out)[VALUES] = frames->value[bits];
    for (int64_t k = 0; k < frames->plan->count && !frames->is_read[bits]; k++) {
        memset(out[k], 0, sizeof out[k]);
        if (frames->plan->frames[k].weight == 0.0)
            continue;
        struct picture picture = accumulate_frames(
            frames->context, frames->plan, &frames->drawing,
            (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = bits},
            k, 1);
        memcpy(out[k], picture.value, sizeof out[k]);
        free(picture.value);
    }
    frames->is_read[bits] = true;
    return out;
}

// Codes stand for quotients that floats do not have.
static double find_value(float value, int bits)
{
    const double largest = bits == 8 ? 255.0 : 65535.0;
    return bits == 8 || bits == 16 ? rint(value * largest) / largest : value;
}

static double find_mean(const struct effect_plan *plan, float (*frames)[VALUES], int bits, int at)
{
    double sum = 0.0, all = 0.0;
    for (int64_t k = 0; k < plan->count; k++) {
        sum += plan->frames[k].weight * find_value(frames[k][at], bits);
        all += plan->frames[k].weight;
    }
    return sum / all;
}

// The same frames from memory, emulated.
static void emulate(const struct effect_plan *plan, float (*frames)[VALUES],
                    struct weft_accumulator_params params, float *out)
{
    weft_accumulator *accumulator;
    params.width = WIDTH;
    params.height = HEIGHT;
    params.channel_count = 4;
    params.emulate = true;
    params.log = &log_to_stderr;
    assert_int_equal(weft_accumulator_create(&params, &accumulator), WEFT_OK);
    for (int64_t k = 0; k < plan->count; k++) {
        struct weft_plane plane[4];
        for (int c = 0; c < 4; c++)
            plane[c] = (struct weft_plane){.values = frames[k] + c * PIXELS};
        assert_int_equal(weft_accumulator_add(accumulator, &(struct weft_frame){.plane = plane},
                                              plan->frames[k].weight),
                         WEFT_OK);
    }
    for (int c = 0; c < 4; c++)
        assert_int_equal(
            weft_accumulator_current(accumulator, WEFT_ACCUMULATED_MEAN, c, out + c * PIXELS, 0),
            WEFT_OK);
    weft_accumulator_destroy(&accumulator);
}

// ---- methods ------------------------------------------------------------------------------------

static const struct {
    const char *name;
    enum weft_accumulate_method method;
    int bits, frame_bits;
    bool negative; // takes weights below 0
    double bound;  // that it keeps for frames of even weight
} methods[] = {
    {"exact", WEFT_ACCUMULATE_EXACT, 0, 32, true, 6e-8},
    {"exact of codes", WEFT_ACCUMULATE_EXACT, 0, 8, true, 6e-8},
    {"float", WEFT_ACCUMULATE_FLOAT, 0, 32, true, 4e-6},
    {"tree of 8 bits", WEFT_ACCUMULATE_TREE, 8, 8, false, 3.0 / 255.0},
    {"tree of 16 bits", WEFT_ACCUMULATE_TREE, 16, 16, false, 3.0 / 65535.0},
    {"tree of floats", WEFT_ACCUMULATE_TREE, 32, 32, false, 4e-6},
    {"blend of 8 bits", WEFT_ACCUMULATE_BLEND, 8, 8, false, 0.2},
    {"blend of 16 bits", WEFT_ACCUMULATE_BLEND, 16, 16, false, 1e-3},
    {"blend of halves", WEFT_ACCUMULATE_BLEND, WEFT_ACCUMULATE_HALF, WEFT_ACCUMULATE_HALF, false,
     0.03},
    {"blend of floats", WEFT_ACCUMULATE_BLEND, 32, 32, false, 4e-6},
    {"buffer of 16 bits", WEFT_ACCUMULATE_BUFFER, 16, 8, true, 2e-3},
};

// The largest error of a picture, to be within the report's bound; and the emulation is the same.
static void check_method(struct frames *all, size_t m, bool announced)
{
    static float emulated[VALUES];
    const struct effect_plan *plan = all->plan;
    double weights[FRAMES], worst = 0.0;
    struct weft_accumulator_params params = {
        .method = methods[m].method, .bits = methods[m].bits, .frame_bits = methods[m].frame_bits};
    effect_plan_get_weights(plan, weights);
    if (announced) {
        params.frame_count = plan->count;
        params.weight = weights;
    }
    float(*frames)[VALUES] = read_frames(all, methods[m].frame_bits);
    struct picture picture = accumulate_frames(all->context, plan, &all->drawing, params, 0, 0);
    for (int i = 0; i < VALUES; i++)
        worst = larger(worst,
                       fabs(picture.value[i] - find_mean(plan, frames, methods[m].frame_bits, i)));
    // The reference is rounded, too: 2 x 24 times, of values up to 1.
    if (!(worst <= picture.report.bound + 2 * FRAMES * 0x1p-53))
        fail_msg("%s: error %g, bound %g", methods[m].name, worst, picture.report.bound);
    assert_int_equal(picture.report.frames, plan->count);
    assert_int_equal(picture.report.counted, plan->count - plan->weights.zeros);
    if (plan->weights.largest * FRAMES < 1.0001 && announced) {
        print_message("%s: error %.2e, bound %.2e\n", methods[m].name, worst, picture.report.bound);
        assert_true(picture.report.bound <= methods[m].bound);
    }
    if (methods[m].method != WEFT_ACCUMULATE_EXACT && methods[m].method != WEFT_ACCUMULATE_BUFFER) {
        emulate(plan, frames, params, emulated);
        for (int i = 0; i < VALUES; i++)
            if (emulated[i] != picture.value[i])
                fail_msg("%s: value %d is %.9g, emulated %.9g", methods[m].name, i,
                         picture.value[i], emulated[i]);
    }
    free(picture.value);
}

static struct effect_plan plan_of(const char *filter, const char *shutter)
{
    struct effect_params params = {EFFECT_DEFAULTS};
    params.effects = EFFECT_ANTIALIAS | EFFECT_MOTION_BLUR | EFFECT_DOF;
    params.scene[0] = &scene;
    params.scene_count = 1;
    params.size[0] = WIDTH;
    params.size[1] = HEIGHT;
    params.frames = FRAMES;
    params.filter = kernel_named(filter);
    params.focus = 12.0;
    params.aperture = 3.0;
    assert_int_equal(weft_shutter_parse(&log_to_stderr, shutter, &params.shutter), WEFT_OK);
    return plan_made(&params);
}

static void every_method_is_within_its_bound(void **state)
{
    (void)state;
    static const struct {
        const char *filter, *shutter;
    } cases[] = {{"nearest", "box"}, {"nearest", "tent"}, {"linear", "gauss"}, {"mitchell", "box"}};
    static struct frames frames;
    const struct scene *const scenes = &scene;
    int checked = 0, negative = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct effect_plan plan = plan_of(cases[i].filter, cases[i].shutter);
        frames.context = contexts[contexts[1] && i % 2];
        frames.plan = &plan;
        memset(frames.is_read, 0, sizeof frames.is_read);
        create_drawings(frames.context, &scenes, 1, &frames.drawing);
        for (size_t m = 0; m < WEFT_COUNT(methods); m++) {
            if (plan.weights.negative > 0.0 && !methods[m].negative)
                continue;
            for (int announced = 0; announced < 2; announced++, checked++)
                check_method(&frames, m, announced);
            negative += plan.weights.negative > 0.0;
        }
        scene_drawing_destroy(&frames.drawing);
        effect_plan_clear(&plan);
    }
    assert_int_equal(negative, 4);
    assert_int_equal(checked, 2 * (3 * (int)WEFT_COUNT(methods) + 4));
}

// Methods that take no negative weights say so, before a frame is drawn.
static void trees_refuse_negative_lobes(void **state)
{
    (void)state;
    struct effect_plan plan = plan_of("mitchell", "box");
    double weights[FRAMES];
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_accumulator *accumulator;
    effect_plan_get_weights(&plan, weights);
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(.width = WIDTH, .height = HEIGHT, .channel_count = 4,
                                    .method = WEFT_ACCUMULATE_TREE, .frame_count = FRAMES,
                                    .weight = weights, .context = contexts[0], .log = &log),
            &accumulator),
        WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 1);
    effect_plan_clear(&plan);
}

// ---- running ------------------------------------------------------------------------------------

struct watched {
    int calls, stop_at; // 0: never
    double last;
};

static bool watch(void *priv, double fraction)
{
    struct watched *watched = priv;
    assert_true(fraction >= watched->last && fraction <= 1.0);
    watched->last = fraction;
    return ++watched->calls != watched->stop_at;
}

static void runs_go_on_where_they_stopped(void **state)
{
    (void)state;
    struct effect_plan plan = plan_of("mitchell", "tent");
    const struct scene *const scenes = &scene;
    const struct weft_accumulator_params exact = {.method = WEFT_ACCUMULATE_EXACT,
                                                  .frame_bits = 32};
    struct picture whole = draw_frames(contexts[0], &plan, &scenes, exact, 0, 0), parts = whole;
    scene_drawing *drawing;
    weft_accumulator *accumulator;
    struct watched watched = {.stop_at = 7};
    const struct weft_progress progress = {watch, &watched};
    int64_t added;
    assert_int_equal(
        scene_drawing_create(
            scene_drawing_params(.scene = &scene, .context = contexts[0], .log = &log_to_stderr),
            &drawing),
        WEFT_OK);
    assert_int_equal(
        weft_accumulator_create(weft_accumulator_params(.width = WIDTH, .height = HEIGHT,
                                                        .channel_count = 4, .context = contexts[0],
                                                        .method = WEFT_ACCUMULATE_EXACT,
                                                        .frame_bits = 32, .log = &log_to_stderr),
                                &accumulator),
        WEFT_OK);
    struct effect_run_params run = {
        .plan = &plan, .drawing = &drawing, .accumulator = accumulator, .progress = &progress};
    assert_int_equal(effect_run(&run, &added), WEFT_ERR_CANCELLED);
    assert_int_equal(added, 6);
    run.first = added;
    run.count = 10;
    watched = (struct watched){.stop_at = 0};
    assert_int_equal(effect_run(&run, &added), WEFT_OK);
    assert_int_equal(added, 10);
    assert_int_equal(watched.calls, 11);
    assert_true(watched.last == 1.0);
    // Frames that there are not.
    run.first = 16;
    run.count = FRAMES - 15;
    assert_int_equal(effect_run(&run, &added), WEFT_ERR_ARGUMENT);
    assert_int_equal(added, 0);
    run.count = 0;
    run.progress = NULL;
    assert_int_equal(effect_run(&run, NULL), WEFT_OK);
    read_picture(accumulator, &parts);
    assert_memory_equal(whole.value, parts.value, sizeof(float) * VALUES);
    assert_int_equal(parts.report.frames, FRAMES);
    weft_accumulator_destroy(&accumulator);
    scene_drawing_destroy(&drawing);
    free(whole.value);
    free(parts.value);
    effect_plan_clear(&plan);
}

// ---- standard errors ----------------------------------------------------------------------------

static struct effect_plan plan_many(int count)
{
    return plan_made(effect_params(.effects = EFFECT_ANTIALIAS | EFFECT_MOTION_BLUR | EFFECT_DOF,
                                   .scene = {&scene}, .scene_count = 1, .size = {WIDTH, HEIGHT},
                                   .frames = count, .focus = 12.0, .aperture = 3.0,
                                   .jitter = weft_jitter_find("sobol"), .centre = true, .seed = 4));
}

// Draws until the standard errors are below `absolute` in 99 % of the pixels, a quarter more frames
// at a time. Writes mean and standard error of the first channel. Returns the frames.
static int64_t draw_until(const struct effect_plan *plan, double absolute, float *mean,
                          float *error)
{
    const struct scene *const scenes = &scene;
    const struct weft_until until = {.absolute = absolute};
    struct weft_convergence convergence = {.enough = false};
    scene_drawing *drawing;
    weft_accumulator *accumulator;
    int64_t done = 0, added;
    create_drawings(contexts[0], &scenes, 1, &drawing);
    assert_int_equal(weft_accumulator_create(
                         weft_accumulator_params(.width = WIDTH, .height = HEIGHT,
                                                 .channel_count = 4, .context = contexts[0],
                                                 .method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32,
                                                 .keep = WEFT_KEEP_VARIANCE, .log = &log_to_stderr),
                         &accumulator),
                     WEFT_OK);
    while (!convergence.enough && done < plan->count) {
        const int64_t more = done < 32 ? 32 : done / 4, left = plan->count - done;
        assert_int_equal(effect_run(effect_run_params(.plan = plan, .drawing = &drawing,
                                                      .accumulator = accumulator, .first = done,
                                                      .count = more < left ? more : left),
                                    &added),
                         WEFT_OK);
        done += added;
        assert_int_equal(weft_accumulator_judge(accumulator, &until, &convergence), WEFT_OK);
    }
    assert_int_equal(weft_accumulator_current(accumulator, WEFT_ACCUMULATED_MEAN, 0, mean, 0),
                     WEFT_OK);
    assert_int_equal(
        weft_accumulator_current(accumulator, WEFT_ACCUMULATED_STANDARD_ERROR, 0, error, 0),
        WEFT_OK);
    weft_accumulator_destroy(&accumulator);
    scene_drawing_destroy(&drawing);
    return done;
}

// Stopped where the standard errors are small enough, the picture is as far from one of many
// frames as they say, over all pixels. All pixels share places and times, so that their errors go
// together: one run may be off by twice as much, or by less.
static void standard_errors_hold(void **state)
{
    (void)state;
    enum { MANY = 2048 };
    static float mean[PIXELS], error[PIXELS], many[PIXELS], rest[PIXELS];
    struct effect_plan plan = plan_many(MANY);
    assert_int_equal(draw_until(&plan, 1e-9, many, rest), MANY);
    double last = INFINITY;
    static const double wanted[] = {0.05, 0.025};
    for (size_t i = 0; i < WEFT_COUNT(wanted); i++) {
        const int64_t frames = draw_until(&plan, wanted[i], mean, error);
        double off = 0.0, said = 0.0;
        for (int p = 0; p < PIXELS; p++) {
            off += (mean[p] - many[p]) * (double)(mean[p] - many[p]);
            said += error[p] * (double)error[p];
        }
        off = sqrt(off / PIXELS);
        said = sqrt(said / PIXELS);
        print_message("standard errors of %g wanted: %d frames, error %.4f, said %.4f\n", wanted[i],
                      (int)frames, off, said);
        assert_true(frames > 16 && frames < MANY / 4);
        assert_true(said <= wanted[i]);
        assert_true(off <= 2.0 * said && off >= 0.2 * said);
        assert_true(off < last);
        last = off;
    }
    effect_plan_clear(&plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_is_within_its_bound),
        cmocka_unit_test(trees_refuse_negative_lobes),
        cmocka_unit_test(runs_go_on_where_they_stopped),
        cmocka_unit_test(standard_errors_hold),
    };
    return cmocka_run_group_tests(tests, make_scene, clear_scene);
}
