// SPDX-License-Identifier: BSD-3-Clause
// Blending: GL beside its emulation, bit for bit; the bound, also on a GL that truncates; and what
// few bits do to many frames.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "passes/gl/context_backend.h"
#include "passes/gl/target.h"
#include "tests/passes/accumulate/gl_jobs.h"

static weft_accumulator *create(struct weft_accumulator_params p)
{
    weft_accumulator *a = NULL;
    p.method = WEFT_ACCUMULATE_BLEND;
    if (!p.log)
        p.log = &log_to_stderr;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_OK);
    return a;
}

static void add_plane(weft_accumulator *a, const struct weft_plane *plane, double weight)
{
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = plane}, weight),
                     WEFT_OK);
}

// ---- pairs of codes -----------------------------------------------------------------------------

// llvmpipe's product of two codes of n bits.
static uint32_t product(uint32_t a, uint32_t b, int n)
{
    const uint64_t ab = (uint64_t)a * b;
    return (uint32_t)((ab + (ab >> n) + (UINT64_C(1) << (n - 1))) >> n);
}

// Frame 0 has code y in row y, frame 1 code x in column x; mixed they are every pair.
static void all_pairs_are_as_emulated(void **state)
{
    (void)state;
    enum { N = 256 };
    static uint8_t codes[2][N * N];
    static float out[RUNS][N * N];
    static const double weights[] = {1.0, 0.5, 0.01, 0.001, 2.9, 254.0, 1000.0};
    int pairs = 0;
    for (int i = 0; i < N * N; i++) {
        codes[0][i] = (uint8_t)(i / N);
        codes[1][i] = (uint8_t)i;
    }
    for (size_t k = 0; k < WEFT_COUNT(weights); k++) {
        const double w = weights[k];
        const uint32_t c = (uint32_t)rint(w / (1.0 + w) * 255.0);
        for (int r = 0; r < RUNS; r++) {
            if (r > 0 && !contexts[r - 1])
                continue;
            weft_accumulator *a = create((struct weft_accumulator_params){
                .width = N,
                .height = N,
                .channel_count = 1,
                .emulate = r == 0,
                .context = r ? contexts[r - 1] : NULL,
            });
            for (int f = 0; f < 2; f++)
                add_plane(a, &(struct weft_plane){.values = codes[f], .type = WEFT_PLANE_UNORM8},
                          f ? w : 1.0);
            assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out[r], 0),
                             WEFT_OK);
            weft_accumulator_destroy(&a);
            for (uint32_t i = 0; i < N * N; i++, pairs++) {
                const uint32_t sum = product(i % N, c, 8) + product(i / N, 255 - c, 8);
                if (lrintf(out[r][i] * 255.0f) != (long)(sum < 255 ? sum : 255))
                    fail_msg("run %d, %u and %u by %u: %g instead of %u", r, i % N, i / N, c,
                             (double)out[r][i] * 255.0, sum);
            }
        }
    }
    assert_true(pairs >= (int)WEFT_COUNT(weights) * 2 * N * N);
}

// ---- sequences ----------------------------------------------------------------------------------

static void sequences_are_as_emulated_and_within_the_bound(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 7, 24, 61}, bits[] = {8, 16, WEFT_ACCUMULATE_HALF, 32};
    static const double ranges[][2] = {{0.0, 1.0}, {-3.0, 10.0}};
    for (size_t b = 0; b < WEFT_COUNT(bits); b++) {
        double worst = 0.0;
        int jobs = 0;
        for (size_t i = 0; i < WEFT_COUNT(counts); i++)
            for (int weighing = EQUAL; weighing < SIGNED; weighing++)
                for (int known = 0; known < 2; known++)
                    for (size_t r = 0; r < WEFT_COUNT(ranges); r++) {
                        const struct gl_job j = {
                            .method = WEFT_ACCUMULATE_BLEND,
                            .n = counts[i],
                            .channels = 1 + jobs % JOB_CHANNELS,
                            .bits = bits[b],
                            .type = r ? jobs % 2 ? WEFT_PLANE_HALF : WEFT_PLANE_FLOAT
                                      : (enum weft_plane_type)(jobs % WEFT_PLANE_TYPE_COUNT),
                            .weighing = (enum weighing)weighing,
                            .known = known,
                            .low = ranges[r][0],
                            .high = ranges[r][1],
                        };
                        worst = larger(worst, run_gl_job(&j, (uint64_t)(jobs++ + 1)));
                    }
        print_message("%d bits: %d jobs, at most %.3f of the bound\n", bits[b], jobs, worst);
        assert_int_equal(jobs, 6 * SIGNED * 2 * 2);
        assert_true(worst > 0.2);
    }
}

// Up to 300 frames, emulated: primes and others, known and not.
static void many_frames_are_within_the_bound(void **state)
{
    (void)state;
    static const int bits[] = {8, 16, WEFT_ACCUMULATE_HALF, 32};
    int jobs = 0;
    weft_context *const kept[2] = {contexts[0], contexts[1]};
    contexts[0] = contexts[1] = NULL;
    for (int n = 67; n <= 300; n += n < 200 ? 33 : 17)
        for (size_t b = 0; b < WEFT_COUNT(bits); b++)
            for (int known = 0; known < 2; known++, jobs++) {
                const struct gl_job j = {
                    .method = WEFT_ACCUMULATE_BLEND,
                    .n = n,
                    .channels = 1,
                    .bits = bits[b],
                    .type = n % 2 ? WEFT_PLANE_FLOAT : WEFT_PLANE_UNORM16,
                    .weighing = (enum weighing)(jobs % SIGNED),
                    .known = known,
                    .high = 1.0,
                };
                run_gl_job(&j, (uint64_t)(jobs + 1));
            }
    contexts[0] = kept[0];
    contexts[1] = kept[1];
    assert_true(jobs >= 80);
}

// ---- any GL -------------------------------------------------------------------------------------

// A blending unit that cuts off whatever it can: the value, the constant's complement (which is
// exact), both products.
static void blend_truncating(int bits, bool add, double constant, double t, double *d)
{
    const double one = bits == 8 ? 255.0 : 65535.0, s = floor(t * one);
    const double sum =
        add ? floor(s * constant) + *d : floor(s * constant) + floor(*d * (1.0 - constant));
    *d = fmin(sum, one);
}

// The constants that the method chooses, as its source says.
static void bound_holds_where_everything_truncates(void **state)
{
    (void)state;
    enum { N = 100, PIXELS = 64 };
    static double target[PIXELS], sum[PIXELS];
    static float pixels[PIXELS];
    const struct weft_plane plane = {.values = pixels};
    for (int bits = 8; bits <= 16; bits += 8)
        for (int add = 0; add < 2; add++) {
            const double one = bits == 8 ? 255.0 : 65535.0;
            uint64_t seed = 77;
            double placed = 0.0, worst = 0.0;
            struct weft_accumulator_report report;
            weft_accumulator *a = create((struct weft_accumulator_params){
                .width = PIXELS,
                .height = 1,
                .channel_count = 1,
                .bits = bits,
                .frame_count = add ? N : 0,
                .emulate = true,
            });
            memset(target, 0, sizeof target);
            memset(sum, 0, sizeof sum);
            for (int k = 0; k < N; k++) {
                const double c = add ? rint((k + 1.0) / N * one) - placed : rint(one / (k + 1.0));
                placed += c;
                for (int i = 0; i < PIXELS; i++) {
                    pixels[i] = (float)next_uniform(&seed);
                    sum[i] += (double)pixels[i];
                    blend_truncating(bits, add, c / one, (double)pixels[i], &target[i]);
                }
                add_plane(a, &plane, 1.0);
            }
            weft_accumulator_get_report(a, &report);
            weft_accumulator_destroy(&a);
            for (int i = 0; i < PIXELS; i++)
                worst = larger(worst, fabs(target[i] / one - sum[i] / N));
            print_message("%d bits, %s: a GL that truncates errs by %.3g of a bound of %.3g\n",
                          bits, add ? "added" : "mixed", worst, report.bound);
            assert_true(worst <= report.bound && worst > 0.3 * report.bound);
        }
}

// ---- few bits -----------------------------------------------------------------------------------

// The paper's example: N identical frames. With 8 bits a share of 1 / 256 leaves a code's highest
// bit at most, so that the picture is black, and white from half on; with a share below half a code
// it is black altogether.
static void frames_that_go_black(void **state)
{
    (void)state;
    enum { CODES = 256 };
    static uint8_t codes[CODES];
    static float out[CODES];
    const struct weft_plane plane = {.values = codes, .type = WEFT_PLANE_UNORM8};
    for (int i = 0; i < CODES; i++)
        codes[i] = (uint8_t)i;
    for (int r = 0; r < RUNS; r++)
        for (int n = 256; n <= 1024; n *= 4) {
            struct weft_accumulator_report report;
            if (r > 0 && !contexts[r - 1])
                continue;
            weft_accumulator *a = create((struct weft_accumulator_params){
                .width = CODES,
                .height = 1,
                .channel_count = 1,
                .frame_count = n,
                .emulate = r == 0,
                .context = r ? contexts[r - 1] : NULL,
            });
            for (int k = 0; k < n; k++)
                add_plane(a, &plane, 1.0);
            assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0),
                             WEFT_OK);
            weft_accumulator_get_report(a, &report);
            weft_accumulator_destroy(&a);
            for (int i = 0; i < CODES; i++) {
                assert_true(fabs((double)out[i] - i / 255.0) <= report.bound);
                assert_true(i < 128 ? out[i] == 0.0f : out[i] == 1.0f);
            }
            // 255 frames have a code of weight, the others none.
            assert_near(report.weight_change, n == 256 ? 1.0 : n / 255.0 - 1.0, 1e-9, "change");
            assert_true(report.bound > 0.5);
        }
}

// Of 16 bits and of floats the same frames come back.
static void frames_that_stay(void **state)
{
    (void)state;
    enum { CODES = 256, N = 256 };
    static const struct {
        int bits;
        double codes; // that are lost at most
    } targets[] = {{16, 1.0}, {32, 0.01}};
    static uint8_t codes[CODES];
    static float out[CODES];
    const struct weft_plane plane = {.values = codes, .type = WEFT_PLANE_UNORM8};
    for (int i = 0; i < CODES; i++)
        codes[i] = (uint8_t)i;
    for (size_t t = 0; t < WEFT_COUNT(targets); t++)
        for (int known = 0; known < 2; known++) {
            weft_accumulator *a = create((struct weft_accumulator_params){
                .width = CODES,
                .height = 1,
                .channel_count = 1,
                .bits = targets[t].bits,
                .frame_count = known ? N : 0,
                .context = contexts[0],
            });
            for (int k = 0; k < N; k++)
                add_plane(a, &plane, 1.0);
            assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0),
                             WEFT_OK);
            for (int i = 0; i < CODES; i++)
                assert_near((double)out[i] * 255.0, i, targets[t].codes, "code");
            weft_accumulator_destroy(&a);
        }
}

// A texture of floats in a range that is not 0 to 1: what is beyond it clamps, on GL and emulated,
// where the same values in memory are refused.
static void textures_clamp_to_the_range(void **state)
{
    (void)state;
    static const float pixels[8][4] = {{-2.0f}, {-1.0f}, {-0.5f}, {0.0f},
                                       {1.5f},  {3.0f},  {3.5f},  {1e30f}};
    float out[2][8];
    for (int bits = 8; bits <= 16; bits += 8)
        for (int emulate = 0; emulate < 2; emulate++) {
            weft_context *context = contexts[0];
            const GladGLContext *gl = &context->gl;
            struct weft_gl_target texture;
            weft_accumulator *a = create((struct weft_accumulator_params){
                .width = 8,
                .height = 1,
                .channel_count = 1,
                .bits = bits,
                .low = -1.0,
                .high = 3.0,
                .emulate = emulate,
                .context = context,
            });
            assert_int_equal(weft_context_enter(context), WEFT_OK);
            assert_int_equal(weft_gl_target_create(&log_to_stderr, gl, GL_RGBA32F, 8, 1, &texture),
                             WEFT_OK);
            gl->BindTexture(GL_TEXTURE_2D, texture.texture);
            gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 8, 1, GL_RGBA, GL_FLOAT, pixels);
            weft_context_leave(context);
            for (int k = 0; k < 3; k++)
                assert_int_equal(
                    weft_accumulator_add(a, &(struct weft_frame){.texture = texture.texture}, 1.0),
                    WEFT_OK);
            assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out[emulate], 0),
                             WEFT_OK);
            for (int i = 0; i < 8; i++) {
                const double v = fmax(-1.0, fmin(3.0, (double)pixels[i][0]));
                assert_near((double)out[emulate][i], v, 4.0 * 3.0 / (bits == 8 ? 255.0 : 65535.0),
                            "clamped value");
            }
            weft_accumulator_destroy(&a);
            assert_int_equal(weft_context_enter(context), WEFT_OK);
            weft_gl_target_destroy(gl, &texture);
            weft_context_leave(context);
            if (emulate)
                assert_memory_equal(out[0], out[1], sizeof out[0]);
        }
}

// ---- numbers at the ends ------------------------------------------------------------------------

// What is below a target's smallest numbers, or at its largest, is on GL as it is emulated.
static void smallest_and_largest_numbers(void **state)
{
    (void)state;
    enum { PIXELS = 512, N = 6 };
    static const int bits[] = {WEFT_ACCUMULATE_HALF, 32};
    static float pixels[N][PIXELS], out[RUNS][PIXELS];
    int compared = 0;
    uint64_t seed = 4;
    for (size_t b = 0; b < 2; b++) {
        for (int k = 0; k < N; k++)
            for (int i = 0; i < PIXELS; i++) {
                const double sign = next_random(&seed) & 1 ? -1.0 : 1.0;
                const int exponent = bits[b] == 32 ? (int)(next_random(&seed) % 30) - 149
                                                   : (int)(next_random(&seed) % 45) - 30;
                pixels[k][i] = (float)(sign * ldexp(1.0 + next_uniform(&seed), exponent));
                if (fabsf(pixels[k][i]) > WEFT_HALF_MAX)
                    pixels[k][i] = WEFT_HALF_MAX;
            }
        for (int known = 0; known < 2; known++)
            for (int r = 0; r < RUNS; r++) {
                if (r > 0 && !contexts[r - 1])
                    continue;
                weft_accumulator *a = create((struct weft_accumulator_params){
                    .width = PIXELS,
                    .height = 1,
                    .channel_count = 1,
                    .bits = bits[b],
                    .frame_count = known ? N : 0,
                    .emulate = r == 0,
                    .context = r ? contexts[r - 1] : NULL,
                });
                for (int k = 0; k < N; k++)
                    add_plane(a, &(struct weft_plane){.values = pixels[k]}, 1.0);
                assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out[r], 0),
                                 WEFT_OK);
                weft_accumulator_destroy(&a);
                for (int i = 0; i < PIXELS; i++, compared++)
                    if (memcmp(&out[0][i], &out[r][i], sizeof(float)) != 0)
                        fail_msg("%d bits, run %d, pixel %d: %a, emulated %a", bits[b], r, i,
                                 (double)out[r][i], (double)out[0][i]);
            }
    }
    assert_true(compared >= 4 * PIXELS);
}

// ---- frames on GL, and what is refused ----------------------------------------------------------

static void not_finite(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    float pixels[4] = {0.25f, 0.5f, 0.75f, 1.0f}, out[4];
    const struct weft_plane plane = {.values = pixels};
    for (int r = 0; r < 2; r++) {
        struct weft_accumulator_params p = {
            .width = 2,
            .height = 2,
            .channel_count = 1,
            .bits = 32,
            .nonfinite = WEFT_NONFINITE_PROPAGATE,
            .emulate = r == 0,
            .context = r ? contexts[0] : NULL,
            .log = &log,
        };
        weft_accumulator *a = create(p);
        struct weft_accumulator_report report;
        add_plane(a, &plane, 1.0);
        pixels[2] = NAN;
        pixels[3] = INFINITY;
        add_plane(a, &plane, 1.0);
        pixels[2] = pixels[3] = 0.5f;
        add_plane(a, &plane, 1.0);
        assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
        weft_accumulator_get_report(a, &report);
        assert_int_equal(report.nonfinite, 2);
        assert_true(fabsf(out[0] - 0.25f) < 1e-6f && fabsf(out[1] - 0.5f) < 1e-6f);
        assert_true(isnan(out[2]) && !isfinite(out[3]));
        weft_accumulator_destroy(&a);
        // By default it is an error.
        p.nonfinite = WEFT_NONFINITE_ERROR;
        a = create(p);
        pixels[1] = NAN;
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                         WEFT_ERR_FORMAT);
        assert_non_null(strstr(message.text, "frame 0, channel 0, pixel (1, 0): nan"));
        pixels[1] = 0.5f;
        add_plane(a, &plane, 1.0);
        weft_accumulator_destroy(&a);
    }
}

static void refuses_what_it_cannot_take(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    const struct weft_accumulator_params good = {.width = 1,
                                                 .height = 1,
                                                 .channel_count = 1,
                                                 .method = WEFT_ACCUMULATE_BLEND,
                                                 .emulate = true,
                                                 .log = &log};
    static const struct {
        int bits;
        enum weft_accumulate_nonfinite nonfinite;
    } refused[] = {{8, WEFT_NONFINITE_PROPAGATE},
                   {16, WEFT_NONFINITE_PROPAGATE},
                   {WEFT_ACCUMULATE_HALF, WEFT_NONFINITE_PROPAGATE},
                   {32, WEFT_NONFINITE_SKIP}};
    weft_accumulator *a = NULL;
    for (size_t i = 0; i < WEFT_COUNT(refused); i++) {
        struct weft_accumulator_params p = good;
        p.bits = refused[i].bits;
        p.nonfinite = refused[i].nonfinite;
        assert_int_equal(weft_accumulator_create(&p, &a), WEFT_ERR_ARGUMENT);
    }
    struct weft_accumulator_params nowhere = good;
    nowhere.emulate = false;
    assert_int_equal(weft_accumulator_create(&nowhere, &a), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 5);
    // Values beyond the range, or beyond a half.
    static const struct {
        int bits;
        float good, bad;
    } values[] = {
        {8, 1.0f, 1.001f}, {16, -0.0f, -0.001f}, {WEFT_ACCUMULATE_HALF, 65504.0f, 65505.0f}};
    for (size_t i = 0; i < WEFT_COUNT(values); i++) {
        struct weft_accumulator_params p = good;
        p.bits = values[i].bits;
        a = create(p);
        add_plane(a, &(struct weft_plane){.values = &values[i].good}, 1.0);
        const struct weft_plane bad = {.values = &values[i].bad};
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &bad}, 1.0),
                         WEFT_ERR_FORMAT);
        assert_non_null(strstr(message.text, "frame 1, channel 0, pixel (0, 0)"));
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &bad}, -1.0),
                         WEFT_ERR_ARGUMENT);
        weft_accumulator_destroy(&a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_pairs_are_as_emulated),
        cmocka_unit_test(sequences_are_as_emulated_and_within_the_bound),
        cmocka_unit_test(many_frames_are_within_the_bound),
        cmocka_unit_test(bound_holds_where_everything_truncates),
        cmocka_unit_test(frames_that_go_black),
        cmocka_unit_test(frames_that_stay),
        cmocka_unit_test(textures_clamp_to_the_range),
        cmocka_unit_test(smallest_and_largest_numbers),
        cmocka_unit_test(not_finite),
        cmocka_unit_test(refuses_what_it_cannot_take),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
