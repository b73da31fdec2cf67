// SPDX-License-Identifier: BSD-3-Clause
// Sums in float targets on GL: beside their emulation, bit for bit, and beside the exact mean.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <float.h>

#include "passes/gl/context_backend.h"
#include "passes/gl/target.h"
#include "tests/passes/accumulate/gl_jobs.h"

static void sums_are_as_emulated_and_within_the_bound(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 7, 24, 61, 130};
    static const double ranges[][2] = {{0.0, 1.0}, {-3.0, 10.0}};
    double worst = 0.0;
    int jobs = 0;
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        for (int weighing = 0; weighing < WEIGHINGS; weighing++)
            for (int known = 0; known < 2; known++)
                for (size_t r = 0; r < WEFT_COUNT(ranges); r++) {
                    const struct gl_job j = {
                        .method = WEFT_ACCUMULATE_FLOAT,
                        .n = counts[i],
                        .channels = 1 + jobs % JOB_CHANNELS,
                        .type = r ? jobs % 2 ? WEFT_PLANE_HALF : WEFT_PLANE_FLOAT
                                  : (enum weft_plane_type)(jobs % WEFT_PLANE_TYPE_COUNT),
                        .weighing = (enum weighing)weighing,
                        .known = known,
                        .low = ranges[r][0],
                        .high = ranges[r][1],
                    };
                    worst = larger(worst, run_gl_job(&j, (uint64_t)(jobs++ + 1)));
                }
    print_message("%d jobs, at most %.3f of the bound\n", jobs, worst);
    assert_int_equal(jobs, 7 * WEIGHINGS * 2 * 2);
    assert_true(worst > 0.1);
}

static weft_accumulator *create(struct weft_accumulator_params p)
{
    weft_accumulator *a = NULL;
    p.method = WEFT_ACCUMULATE_FLOAT;
    p.channel_count = p.channel_count ? p.channel_count : 1;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_OK);
    return a;
}

// Sums of codes and of integer weights below 2^24 lose nothing but the last rounding.
static void integers_are_exact(void **state)
{
    (void)state;
    enum { PIXELS = 256, N = 200 };
    static uint32_t codes[PIXELS];
    static float out[PIXELS];
    double sum[PIXELS] = {0.0}, total = 0.0;
    const struct weft_plane plane = {.values = codes, .type = WEFT_PLANE_UINT};
    uint64_t seed = 6;
    for (int emulate = 0; emulate < 2; emulate++) {
        weft_accumulator *a = create((struct weft_accumulator_params){
            .width = PIXELS,
            .height = 1,
            .emulate = emulate,
            .context = contexts[0],
            .log = &log_to_stderr,
        });
        memset(sum, 0, sizeof sum);
        total = 0.0;
        for (int k = 0; k < N; k++) {
            const double weight = (double)(next_random(&seed) % 64) - 8.0;
            for (int i = 0; i < PIXELS; i++) {
                codes[i] = (uint32_t)(next_random(&seed) % 1000);
                sum[i] += weight * codes[i];
            }
            total += weight;
            assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, weight),
                             WEFT_OK);
        }
        assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
        for (int i = 0; i < PIXELS; i++)
            assert_true(out[i] == (float)(sum[i] / total));
        weft_accumulator_destroy(&a);
    }
}

// A frame that is drawn, and the same one in a texture: one colour a pixel.
struct scene {
    weft_context *context;
    const GladGLContext *gl;
    struct weft_gl_target texture;
    float pixels[4][4]; // 2 x 2, RGBA
    int drawn;
    enum weft_result result;
};

static enum weft_result draw(void *priv, int64_t index, const struct weft_draw_target *target)
{
    struct scene *s = priv;
    assert_int_equal(index, s->drawn);
    assert_true(target->width == 2 && target->height == 2);
    s->gl->Enable(GL_SCISSOR_TEST); // which is put right again
    for (int i = 0; i < 4; i++) {
        s->gl->Scissor(i % 2, i / 2, 1, 1);
        s->gl->ClearColor(s->pixels[i][0], s->pixels[i][1], s->pixels[i][2], s->pixels[i][3]);
        s->gl->Clear(GL_COLOR_BUFFER_BIT);
    }
    s->drawn += s->result == WEFT_OK;
    return s->result;
}

static void make_scene(struct scene *s, weft_context *context)
{
    *s = (struct scene){.context = context, .gl = &context->gl};
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    assert_int_equal(weft_gl_target_create(&log_to_stderr, s->gl, GL_RGBA32F, 2, 2, &s->texture),
                     WEFT_OK);
    weft_context_leave(context);
}

static void destroy_scene(struct scene *s)
{
    assert_int_equal(weft_context_enter(s->context), WEFT_OK);
    weft_gl_target_destroy(s->gl, &s->texture);
    weft_context_leave(s->context);
}

static void upload(struct scene *s)
{
    assert_int_equal(weft_context_enter(s->context), WEFT_OK);
    s->gl->BindTexture(GL_TEXTURE_2D, s->texture.texture);
    s->gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 2, 2, GL_RGBA, GL_FLOAT, s->pixels);
    weft_context_leave(s->context);
}

enum { KINDS = 3 };

static void compare_kinds(weft_accumulator *a[KINDS])
{
    float out[KINDS][4];
    for (int channel = 0; channel < 4; channel++)
        for (int k = 0; k < KINDS; k++) {
            assert_int_equal(
                weft_accumulator_current(a[k], WEFT_ACCUMULATED_MEAN, channel, out[k], 0), WEFT_OK);
            assert_memory_equal(out[0], out[k], sizeof out[0]);
        }
}

// What is refused leaves no trace: values that are not finite in planes and textures, and frames
// that their owner does not draw.
static void refuse_kinds(struct scene *s, weft_accumulator *a[KINDS],
                         const struct weft_frame *frames, struct message *message)
{
    struct weft_accumulator_report report;
    s->pixels[3][1] = NAN;
    upload(s);
    s->result = WEFT_ERR_CANCELLED;
    for (int k = 0; k < KINDS; k++) {
        const int before = s->drawn;
        assert_int_equal(weft_accumulator_add(a[k], &frames[k], 1.0),
                         k == 2 ? WEFT_ERR_CANCELLED : WEFT_ERR_FORMAT);
        if (k < 2)
            assert_non_null(strstr(message->text, "frame 9, channel 1, pixel (1, 1): nan"));
        assert_int_equal(s->drawn, before);
        weft_accumulator_get_report(a[k], &report);
        assert_int_equal(report.frames, 9);
    }
    s->result = WEFT_OK;
    compare_kinds(a);
}

// Planes, textures and drawings of the same values: the same bits.
static void run_kinds(weft_context *context, enum weft_accumulate_method method, bool emulate)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct scene s;
    struct weft_plane planes[4];
    weft_accumulator *a[KINDS];
    uint64_t seed = 12;
    make_scene(&s, context);
    for (int k = 0; k < KINDS; k++)
        assert_int_equal(
            weft_accumulator_create(weft_accumulator_params(.width = 2, .height = 2,
                                                            .channel_count = 4, .method = method,
                                                            .bits = 32, .emulate = emulate,
                                                            .context = context, .log = &log),
                                    &a[k]),
            WEFT_OK);
    for (int channel = 0; channel < 4; channel++)
        planes[channel] = (struct weft_plane){.values = &s.pixels[0][channel], .step = 4};
    const struct weft_frame frames[KINDS] = {
        {.plane = planes}, {.texture = s.texture.texture}, {.draw = draw, .priv = &s}};
    for (int n = 0; n < 9; n++) {
        for (int i = 0; i < 16; i++)
            s.pixels[i / 4][i % 4] = (float)(next_uniform(&seed) * 3.0 - 1.0);
        upload(&s);
        for (int k = 0; k < KINDS; k++)
            assert_int_equal(weft_accumulator_add(a[k], &frames[k], 1.0 + n), WEFT_OK);
    }
    assert_int_equal(s.drawn, 9);
    compare_kinds(a);
    refuse_kinds(&s, a, frames, &message);
    // A frame of weight 0 is not drawn.
    for (int k = 0; k < KINDS; k++)
        assert_int_equal(weft_accumulator_add(a[k], &frames[k], 0.0), WEFT_OK);
    assert_int_equal(s.drawn, 9);
    compare_kinds(a);
    for (int k = 0; k < KINDS; k++)
        weft_accumulator_destroy(&a[k]);
    destroy_scene(&s);
}

static void kinds_of_frames_agree(void **state)
{
    (void)state;
    static const enum weft_accumulate_method methods[] = {
        WEFT_ACCUMULATE_FLOAT, WEFT_ACCUMULATE_BLEND, WEFT_ACCUMULATE_BUFFER};
    for (int c = 0; c < 2; c++)
        for (size_t m = 0; m < WEFT_COUNT(methods) && contexts[c]; m++)
            for (int emulate = 0; emulate < 2; emulate++)
                run_kinds(contexts[c], methods[m], emulate);
}

static void sums_that_are_no_floats(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    float value = 1e30f, out;
    const struct weft_plane plane = {.values = &value};
    const struct weft_frame frame = {.plane = &plane};
    weft_accumulator *a = create(
        (struct weft_accumulator_params){.width = 1, .height = 1, .emulate = true, .log = &log});
    assert_int_equal(weft_accumulator_add(a, &frame, 1e-10), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 1e-5), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 0.25), WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "frame 2 of weight 0.25"));
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, &out, 0), WEFT_OK);
    assert_near((double)out, 1e30, 1e24, "mean");
    weft_accumulator_destroy(&a);
    // The largest weight is known: what is far below it counts for nothing.
    const double weights[] = {1e-300, 1e300};
    a = create((struct weft_accumulator_params){.width = 1,
                                                .height = 1,
                                                .emulate = true,
                                                .frame_count = 2,
                                                .weight = weights,
                                                .log = &log});
    assert_int_equal(weft_accumulator_add(a, &frame, weights[0]), WEFT_OK);
    value = 0.5f;
    assert_int_equal(weft_accumulator_add(a, &frame, weights[1]), WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, &out, 0), WEFT_OK);
    assert_true(out == 0.5f);
    weft_accumulator_destroy(&a);
}

static void smallest_numbers(void **state)
{
    (void)state;
    enum { PIXELS = 512, N = 5 };
    static float pixels[N][PIXELS], out[RUNS][PIXELS];
    int compared = 0;
    uint64_t seed = 4;
    for (int k = 0; k < N; k++)
        for (int i = 0; i < PIXELS; i++)
            pixels[k][i] =
                (float)ldexp(next_uniform(&seed) - 0.5, (int)(next_random(&seed) % 30) - 148);
    for (int r = 0; r < RUNS; r++) {
        struct weft_accumulator_report report;
        if (r > 0 && !contexts[r - 1])
            continue;
        weft_accumulator *a = create((struct weft_accumulator_params){
            .width = PIXELS,
            .height = 1,
            .emulate = r == 0,
            .context = r ? contexts[r - 1] : NULL,
            .log = &log_to_stderr,
        });
        for (int k = 0; k < N; k++)
            assert_int_equal(
                weft_accumulator_add(
                    a, &(struct weft_frame){.plane = &(struct weft_plane){.values = pixels[k]}},
                    k % 2 ? -0.375 : 1.0),
                WEFT_OK);
        assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out[r], 0), WEFT_OK);
        weft_accumulator_get_report(a, &report);
        weft_accumulator_destroy(&a);
        for (int i = 0; i < PIXELS; i++, compared++) {
            double sum = 0.0;
            for (int k = 0; k < N; k++)
                sum += (k % 2 ? -0.375 : 1.0) * (double)pixels[k][i];
            assert_true(fabs((double)out[r][i] - sum / 2.25) <= report.bound);
            if (memcmp(&out[0][i], &out[r][i], sizeof(float)) != 0)
                fail_msg("run %d, pixel %d: %a, emulated %a", r, i, (double)out[r][i],
                         (double)out[0][i]);
        }
    }
    assert_true(compared >= 2 * PIXELS);
}

static void not_finite(void **state)
{
    (void)state;
    float pixels[4] = {0.25f, 0.5f, 0.75f, 1.0f}, out[4];
    const struct weft_plane plane = {.values = pixels};
    for (int r = 0; r < 2; r++) {
        weft_accumulator *a = create((struct weft_accumulator_params){
            .width = 2,
            .height = 2,
            .nonfinite = WEFT_NONFINITE_PROPAGATE,
            .emulate = r == 0,
            .context = r ? contexts[0] : NULL,
            .log = &log_to_stderr,
        });
        for (int k = 0; k < 3; k++) {
            pixels[2] = k == 1 ? NAN : 0.75f;
            pixels[3] = k == 0 ? INFINITY : k == 2 ? -INFINITY : 1.0f;
            assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                             WEFT_OK);
        }
        assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
        assert_true(out[0] == 0.25f && out[1] == 0.5f && isnan(out[2]) && isnan(out[3]));
        weft_accumulator_destroy(&a);
        pixels[2] = 0.75f;
        pixels[3] = 1.0f;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_as_emulated_and_within_the_bound),
        cmocka_unit_test(integers_are_exact),
        cmocka_unit_test(kinds_of_frames_agree),
        cmocka_unit_test(sums_that_are_no_floats),
        cmocka_unit_test(smallest_numbers),
        cmocka_unit_test(not_finite),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
