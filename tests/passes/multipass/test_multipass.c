// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/support/pass_lists.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"

// Of a list and request that emulation takes: GL gives the same. Returns the largest difference,
// in units of the result; NAN where emulation refuses.
static double largest_difference(weft_context *context, const struct hand_list *h,
                                 struct hand_request *r)
{
    static float emulated[4][HAND_MAX_PIXELS];
    struct weft_multipass_report report;
    struct message refusal = {0};
    const struct weft_log log = {keep_message, &refusal};
    r->params.log = &log;
    if (hand_run(NULL, h, r, NULL) != WEFT_OK)
        return NAN;
    memcpy(emulated, r->pixels, sizeof emulated);
    memset(r->pixels, 0xff, sizeof r->pixels);
    r->params.log = &log_to_stderr;
    assert_int_equal(hand_run(context, h, r, &report), WEFT_OK);
    double largest = 0.0;
    for (int c = 0; c < h->work.channels; c++) {
        for (int p = 0; p < r->grid.width * r->grid.height; p++) {
            const double a = (double)emulated[c][p], b = (double)r->pixels[c][p];
            assert_int_equal(isnan(a), isnan(b));
            if (!isnan(a) && a != b) // the same infinity is none
                largest = larger(largest, fabs(a - b));
        }
    }
    return largest;
}

// ---- what blending does with whole codes --------------------------------------------------------

static const char constant_fragment[] = "uniform float code_over_one;\n"
                                        "out float value;\n"
                                        "void main() { value = code_over_one; }\n";
static const char ramp_fragment[] = "uniform int first;\n"
                                    "out float value;\n"
                                    "void main()\n"
                                    "{\n"
                                    "    value = float(first + int(gl_FragCoord.x)) / float(ONE);\n"
                                    "}\n";

struct blend_test {
    const GladGLContext *gl;
    GLuint ramp, constant;
    struct weft_gl_target target;
    int one, width;
    GLenum type;
};

static void create_blend_test(weft_context *context, int bits, struct blend_test *t)
{
    char defines[32];
    *t = (struct blend_test){.gl = &context->gl, .one = (1 << bits) - 1, .width = 256};
    t->type = bits == 8 ? GL_UNSIGNED_BYTE : GL_UNSIGNED_SHORT;
    const GladGLContext *gl = t->gl;
    snprintf(defines, sizeof defines, "#define ONE %d\n", t->one);
    assert_int_equal(weft_program_get(context, "ramp", defines, weft_shader_full_target,
                                      ramp_fragment, &t->ramp),
                     WEFT_OK);
    assert_int_equal(weft_program_get(context, "constant", "", weft_shader_full_target,
                                      constant_fragment, &t->constant),
                     WEFT_OK);
    assert_int_equal(weft_gl_target_create(&log_to_stderr, gl, bits == 8 ? GL_R8 : GL_R16, t->width,
                                           1, &t->target),
                     WEFT_OK);
    weft_gl_target_bind(gl, &t->target, t->width, 1);
    gl->BlendFunc(GL_ONE, GL_ONE);
}

static void destroy_blend_test(struct blend_test *t)
{
    const GladGLContext *gl = t->gl;
    gl->Disable(GL_BLEND);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->BlendFunc(GL_ONE, GL_ZERO);
    weft_gl_target_destroy(gl, &t->target);
    assert_int_equal(weft_gl_check(&log_to_stderr, gl, "a blend test"), WEFT_OK);
}

static void read_codes(const struct blend_test *t, int count, void *codes)
{
    const struct weft_gl_pixels out = {.width = count, .height = 1, .type = t->type, .data = codes};
    assert_int_equal(weft_gl_target_read(&log_to_stderr, t->gl, &t->target, &out), WEFT_OK);
}

// Codes first to first + 255 by clearing or drawing, then one more code by blending. Returns how
// many are not what integers give.
static int count_wrong(const struct blend_test *t, int first, int code, GLenum equation)
{
    const GladGLContext *gl = t->gl;
    uint16_t words[256];
    uint8_t bytes[256];
    int wrong = 0;
    gl->Disable(GL_BLEND);
    gl->UseProgram(t->ramp);
    gl->Uniform1i(gl->GetUniformLocation(t->ramp, "first"), first);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Enable(GL_BLEND);
    gl->BlendEquation(equation);
    gl->UseProgram(t->constant);
    gl->Uniform1f(gl->GetUniformLocation(t->constant, "code_over_one"),
                  (float)code / (float)t->one);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    read_codes(t, t->width, t->one > 255 ? (void *)words : bytes);
    for (int i = 0; i < t->width; i++) {
        const int y = first + i > t->one ? t->one : first + i;
        const int sum = equation == GL_FUNC_ADD ? y + code : y - code;
        const int expected = sum < 0 ? 0 : sum > t->one ? t->one : sum;
        wrong += (t->one > 255 ? words[i] : bytes[i]) != expected;
    }
    return wrong;
}

// All pairs of 8-bit codes, a sample of 16-bit ones with all that is near either end.
static void blending_adds_whole_codes(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int bits = 8; bits <= 16; bits += 8) {
            struct blend_test t;
            int wrong[2] = {0, 0};
            assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
            create_blend_test(contexts[c], bits, &t);
            for (int i = 0; i < 512; i++) {
                const int near = i < 128 ? i : t.one - (i - 128);
                const int code = bits == 8 ? i / 2 : i < 256 ? near : i * 128 + random_below(128);
                const int first = bits == 8 ? 0 : i % 4 * 21760 + random_below(256);
                wrong[i % 2] +=
                    count_wrong(&t, first, code, i % 2 ? GL_FUNC_REVERSE_SUBTRACT : GL_FUNC_ADD);
            }
            destroy_blend_test(&t);
            weft_context_leave(contexts[c]);
            print_message("%-16s R%d: of 65536 pairs, %d sums and %d differences are not whole\n",
                          weft_context_get_info(contexts[c])->platform, bits, wrong[0], wrong[1]);
            assert_int_equal(wrong[0], 0);
            assert_int_equal(wrong[1], 0);
        }
    }
}

static void clearing_stores_every_code(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int bits = 8; bits <= 16; bits += 8) {
            struct blend_test t;
            int wrong = 0;
            assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
            create_blend_test(contexts[c], bits, &t);
            for (int i = 0; i <= t.one; i += bits == 8 ? 1 : 37) {
                uint16_t word = 0;
                uint8_t byte = 0;
                t.gl->ClearColor((float)((double)i / t.one), 0.0f, 0.0f, 0.0f);
                t.gl->Clear(GL_COLOR_BUFFER_BIT);
                read_codes(&t, 1, bits > 8 ? (void *)&word : &byte);
                wrong += (bits > 8 ? word : byte) != i;
            }
            destroy_blend_test(&t);
            weft_context_leave(contexts[c]);
            assert_int_equal(wrong, 0);
        }
    }
}

// ---- GL and emulation ---------------------------------------------------------------------------

// Cases take turns on the contexts: compiling their shaders takes most of the time.
static weft_context *context_of(int turn)
{
    return contexts[contexts[1] ? turn % 2 : 0];
}

static void gl_agrees_in_every_bit(void **state)
{
    (void)state;
    enum { CASES = 80 };
    int compared = 0;
    for (int i = 0; i < CASES; i++) {
        weft_context *context = context_of(i / 2);
        start_case(i);
        struct hand_list *h = hand_random_list(i % 2 ? WEFT_TARGET_UNORM16 : WEFT_TARGET_UNORM8);
        struct hand_request *r = hand_random_request(h);
        const double difference = largest_difference(context, h, r);
        if (difference > 0.0)
            fail_msg("case %d on %s: %.3g codes", i, weft_context_get_info(context)->platform,
                     difference * weft_target_one(h->list.target));
        compared += !isnan(difference);
        free(r);
        hand_list_destroy(h);
    }
    print_message("%d of %d runs agree in every bit, emulation refuses the others\n", compared,
                  (int)CASES);
    assert_true(compared > CASES * 3 / 4);
}

// Both sum in the same order in floats; the shader's compiler may keep that or not. Each rounding
// is up to 2^-24 of a partial sum, which is at most 16 times the largest value (a combination's
// factors are), and a pass has up to 5 groups of 4 products of 2 roundings each. A half store may
// go one step, 2^-10, the other way in every pass.
static void floats_agree_within_roundings(void **state)
{
    (void)state;
    enum { CASES = 30 };
    double largest[2] = {0.0, 0.0};
    for (int i = 0; i < CASES; i++) {
        const bool half = i % 2;
        start_case(i);
        struct hand_list *h = hand_random_list(half ? WEFT_TARGET_HALF : WEFT_TARGET_FLOAT);
        struct hand_request *r = hand_random_request(h);
        const double difference = largest_difference(context_of(i / 2), h, r);
        double magnitude = 1.0;
        for (int p = 0; p < r->grid.width * r->grid.height; p++)
            magnitude = larger(magnitude, fabs((double)r->pixels[0][p]));
        const double step = half ? 0x1p-10 : 3.0 * 20.0 * 0x1p-24;
        const double bound = 16.0 * magnitude * h->list.pass_count * step;
        assert_true(isfinite(bound) && difference <= bound);
        largest[half] = fmax(largest[half], difference / magnitude);
        free(r);
        hand_list_destroy(h);
    }
    print_message("floats differ by %.3g, halves by %.3g of the largest value\n", largest[0],
                  largest[1]);
}

// A plain list as reconstruction, by blending and by ping-pong: the same.
static void blending_and_ping_pong_agree(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int target = WEFT_TARGET_UNORM8; target <= WEFT_TARGET_UNORM16; target++) {
            float pixels[2][20 * 30];
            for (int reads = 0; reads < 2; reads++) {
                start_case(target);
                struct hand_list *h = hand_list_create(
                    &(struct hand_params){HAND_DEFAULTS.target = (enum weft_target_format)target,
                                          .signs = WEFT_TILE_SEPARATE, .dims = 3});
                hand_add_all_tiles(h, reads);
                h->passes[0].initial = weft_target_one(h->list.target) / 2;
                struct hand_request *r = hand_request_create(h, 20, 30, 6, 7, 8);
                for (int a = 0; a < 3; a++) {
                    r->grid.du[a] = 0.2 + 0.03 * a;
                    r->grid.dv[a] = 0.2 - 0.03 * a;
                }
                // Values that keep all sums within the range.
                for (int s = 0; s < 6 * 7 * 8; s++)
                    r->samples[0][s] = 0.3f * r->samples[0][s];
                assert_true(largest_difference(contexts[c], h, r) == 0.0);
                memcpy(pixels[reads], r->pixels[0], sizeof pixels[reads]);
                free(r);
                hand_list_destroy(h);
            }
            assert_memory_equal(pixels[0], pixels[1], sizeof pixels[0]);
        }
    }
}

// ---- plans --------------------------------------------------------------------------------------

struct plan_case {
    const char *kernel, *profile;
    enum weft_technique technique;
    int dims;
    const char *derivative;
    int channels;
    bool blend_only;
};

static const struct plan_case plan_cases[] = {
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 2, "none", 4, false},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_DOT4, 3, "none", 1, false},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_DOT4, 2, "none", 1, true},
    {"bspline", "unorm8", WEFT_TECHNIQUE_SPLIT_PRECISION, 2, "none", 1, true},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_SPLIT_PRECISION, 3, "none", 1, false},
    {"bspline", "unorm8", WEFT_TECHNIQUE_HIERARCHICAL, 3, "none", 1, false},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_HIERARCHICAL, 2, "none", 1, true},
    {"bspline", "unorm16", WEFT_TECHNIQUE_LOG, 2, "none", 1, false},
    {"mitchell", "geforce3", WEFT_TECHNIQUE_DOT4, 2, "none", 1, false},
    {"bspline", "radeon8500", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"blackman-sinc:2", "unorm16", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"gaussian:1.5", "unorm16", WEFT_TECHNIQUE_DOT4, 3, "none", 1, false},
    {"catmull-rom", "unorm16", WEFT_TECHNIQUE_DOT4, 2, "x", 1, false},
    {"bspline", "unorm16", WEFT_TECHNIQUE_PLAIN, 3, "z", 1, false},
    {"d-catmull-rom", "unorm16", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"catmull-rom", "fp16", WEFT_TECHNIQUE_DOT4, 3, "none", 1, false},
    {"lanczos:2", "fp32", WEFT_TECHNIQUE_PLAIN, 2, "none", 4, false},
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_DOT4, 3, "y", 1, false},
    {"bspline", "unorm16", WEFT_TECHNIQUE_PLAIN, 2, "xy", 1, false},
    {"bspline", "unorm16", WEFT_TECHNIQUE_DOT4, 3, "xz", 1, false},
    {"bspline", "unorm16", WEFT_TECHNIQUE_PLAIN, 2, "yy", 1, false},
    {"bspline", "unorm16", WEFT_TECHNIQUE_SPLIT_PRECISION, 2, "xx", 1, false},
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_PLAIN, 3, "zz", 1, false},
};

static weft_pass_plan *make_plan(const struct plan_case *k)
{
    weft_pass_plan *plan = NULL;
    struct weft_pass_plan_params p = {.kernel = kernel_named(k->kernel),
                                      .dims = k->dims,
                                      .derivative = derivative_named(k->derivative),
                                      .technique = k->technique,
                                      .channels = k->channels,
                                      .samples = k->dims > 2 ? 8 : 16,
                                      .blend_only = k->blend_only,
                                      .log = &log_to_stderr};
    assert_int_equal(weft_profile_parse(&log_to_stderr, k->profile, &p.profile), WEFT_OK);
    assert_int_equal(weft_pass_plan_create(&p, &plan), WEFT_OK);
    return plan;
}

// Samples in [2, 5], so that the range's foot and width show.
static struct hand_request *make_plan_request(const struct weft_pass_plan_info *info)
{
    const struct hand_list h = {.work = {.channels = info->channels}};
    struct hand_request *r = hand_request_create(&h, 40, 30, 9, 8, info->dims > 2 ? 7 : 1);
    for (int c = 0; c < info->channels; c++)
        for (int i = 0; i < HAND_MAX_SAMPLES; i++)
            r->samples[c][i] = 2.0f + 3.0f * r->samples[c][i];
    r->source.low = info->technique == WEFT_TECHNIQUE_LOG ? 0.0 : 2.0;
    r->source.high = 5.0;
    for (int a = 0; a < info->dims; a++) {
        r->grid.origin[a] = -0.6;
        r->grid.du[a] = 0.15 + 0.07 * a;
        r->grid.dv[a] = 0.25 - 0.1 * a;
    }
    return r;
}

// Through the calls that everybody uses: GL as emulation, and both within the plan's own bound.
static void plans_keep_their_bounds(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(plan_cases); i++) {
        weft_pass_plan *plan = make_plan(&plan_cases[i]);
        const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
        struct hand_request *r = make_plan_request(info);
        struct weft_verify_report error;
        static float emulated[4][HAND_MAX_PIXELS];
        assert_int_equal(run_plan(NULL, plan, &r->params, NULL), WEFT_OK);
        memcpy(emulated, r->pixels, sizeof emulated);
        assert_int_equal(verify_plan(plan, &r->params, &error), WEFT_OK);
        const double width = r->source.high - r->source.low;
        const double bound = info->error.bound_any * width;
        print_message("%-15s %dD' %-4s %-10s %-15s %3d passes: error %.4f, rms %.4f, bound %.4f\n",
                      plan_cases[i].kernel, info->dims, plan_cases[i].derivative,
                      info->profile.name, weft_technique_names[info->technique],
                      info->passes->pass_count, error.maximum, error.rms, bound);
        assert_true(error.maximum <= bound && error.not_finite_mismatches == 0);
        for (int c = 0; c < 2 && contexts[c]; c++) {
            const bool exact = weft_target_bits(info->profile.target) > 0;
            assert_int_equal(run_plan(contexts[c], plan, &r->params, NULL), WEFT_OK);
            for (int p = 0; p < 40 * 30 && exact; p++)
                for (int n = 0; n < info->channels; n++)
                    assert_true(r->pixels[n][p] == emulated[n][p]);
            assert_int_equal(verify_plan(plan, &r->params, &error), WEFT_OK);
            assert_true(error.maximum <= bound && error.not_finite_mismatches == 0);
        }
        free(r);
        weft_pass_plan_destroy(&plan);
    }
}

// ---- edges --------------------------------------------------------------------------------------

static void smallest_sizes(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
        hand_add_all_tiles(h, true);
        struct hand_request *r = hand_request_create(h, 1, 1, 1, 1, 1);
        assert_true(largest_difference(contexts[c], h, r) == 0.0);
        // Far away: the edge's value holds, however far.
        r->grid.origin[0] = 1e300;
        r->grid.origin[1] = -1e18;
        assert_true(largest_difference(contexts[c], h, r) == 0.0);
        free(r);
        hand_list_destroy(h);
    }
}

static void samples_that_are_not_finite_show(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct hand_list *h = hand_list_create(
            &(struct hand_params){HAND_DEFAULTS.kernel = "bspline", .samples = 32, .channels = 4});
        hand_add_all_tiles(h, true);
        struct hand_request *r = hand_request_create(h, 30, 30, 9, 9, 1);
        r->samples[0][0] = NAN;
        r->samples[1][40] = INFINITY;
        r->samples[3][80] = -INFINITY;
        r->source.low = r->source.high = NAN;
        r->grid.origin[0] = r->grid.origin[1] = -1.0;
        r->grid.du[0] = r->grid.dv[1] = 10.0 / 30.0;
        assert_true(largest_difference(contexts[c], h, r) == 0.0);
        struct weft_verify_report error;
        assert_int_equal(hand_verify(h, r, &error), WEFT_OK);
        assert_int_equal(error.not_finite_mismatches, 0);
        assert_true(error.maximum < 0.1);
        free(r);
        hand_list_destroy(h);
    }
}

// Kernels and profiles by turns, 11 x 9 samples thrice as large: every third position is whole.
enum { FEW_X = 11, FEW_Y = 9, THRICE = 3 };

static struct hand_request *make_thrice(const double columns[], const double rows[])
{
    struct hand_request *r = hand_request_create(&(struct hand_list){.work.channels = 1},
                                                 THRICE * FEW_X, THRICE * FEW_Y, FEW_X, FEW_Y, 1);
    r->grid.columns = columns;
    r->grid.rows = rows;
    r->source.low = r->source.high = NAN;
    return r;
}

static void set_thirds(double *at, int count)
{
    for (int i = 0; i < count; i++)
        at[i] = (i - 1) / 3.0; // whole where it is
}

static const struct plan_case thrice_cases[] = {
    {"linear", "fp32", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"linear", "unorm8", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_DOT4, 2, "none", 1, false},
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_PLAIN, 2, "x", 1, false},
    {"catmull-rom+radial+unit", "fp32", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"catmull-rom", "unorm16", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
    {"bspline", "fp16", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
};

// Emulated and on every context; verified, NANs counted.
static void check_thrice(const weft_pass_plan *plan, struct hand_request *r, const char *what,
                         int nans)
{
    for (int c = -1; c < 2; c++) {
        struct weft_verify_report error;
        int count = 0;
        if (c >= 0 && !contexts[c])
            continue;
        assert_int_equal(run_plan(c < 0 ? NULL : contexts[c], plan, &r->params, NULL), WEFT_OK);
        assert_int_equal(verify_plan(plan, &r->params, &error), WEFT_OK);
        for (int p = 0; p < THRICE * FEW_X * THRICE * FEW_Y; p++)
            count += isnan(r->pixels[0][p]);
        if (error.not_finite_mismatches || (nans >= 0 && count != nans))
            fail_msg("%s: %d not finite on one side only, %d NANs, not %d", what,
                     (int)error.not_finite_mismatches, count, nans);
    }
}

static void weights_of_zero_spread_nothing(void **state)
{
    (void)state;
    double columns[THRICE * FEW_X], rows[THRICE * FEW_Y];
    set_thirds(columns, THRICE * FEW_X);
    set_thirds(rows, THRICE * FEW_Y);
    for (size_t i = 0; i < WEFT_COUNT(thrice_cases); i++) {
        const struct plan_case *k = &thrice_cases[i];
        weft_pass_plan *plan = make_plan(k);
        struct hand_request *r = make_thrice(columns, rows);
        const bool linear = strcmp(k->kernel, "linear") == 0;
        const bool cubic =
            strcmp(k->kernel, "catmull-rom") == 0 && strcmp(k->derivative, "none") == 0;
        r->samples[0][4 * FEW_X + 5] = NAN;
        // Around a sample, fractions of two thirds and less on both sides of it; and a sample's
        // own place, where the weights of all others are 0.
        check_thrice(plan, r, k->kernel, linear ? 5 * 5 : cubic ? 9 * 9 : -1);
        free(r);
        weft_pass_plan_destroy(&plan);
    }
}

static void the_largest_floats_stay_finite(void **state)
{
    (void)state;
    double columns[THRICE * FEW_X], rows[THRICE * FEW_Y];
    set_thirds(columns, THRICE * FEW_X);
    set_thirds(rows, THRICE * FEW_Y);
    int inside = 0;
    for (size_t i = 0; i < 2 * WEFT_COUNT(thrice_cases); i++) {
        const struct plan_case *k = &thrice_cases[i / 2];
        weft_pass_plan *plan = make_plan(k);
        struct hand_request *r = make_thrice(columns, rows);
        for (int s = 0; s < FEW_X * FEW_Y; s++)
            r->samples[0][s] = s % 5 < 3 ? FLT_MAX : i % 2 ? 1.0f : -FLT_MAX;
        check_thrice(plan, r, k->kernel, 0);
        for (int p = 0; p < THRICE * FEW_X * THRICE * FEW_Y; p++)
            inside += isfinite(r->pixels[0][p]);
        free(r);
        weft_pass_plan_destroy(&plan);
    }
    assert_true(inside > 2000);
}

static void limits_are_checked(void **state)
{
    (void)state;
    weft_context *context = contexts[0];
    const struct weft_context_info info = context->info;
    struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
    hand_add_all_tiles(h, true);
    struct hand_request *r = hand_request_create(h, 30, 20, 13, 13, 1);
    static const struct {
        int side, texels;
        const char *text;
    } cases[] = {
        {29, 100000, "30 x 20 pixels, over the limit of 29"},
        {30, 300, "source takes 361 texels, over the limit of 300"}, // (13 + 2 * 3)^2
        {30, 240, "tiles takes 256 texels, over the limit of 240"},  // 4 of 64
        {30, 599, "grid takes 600 texels, over the limit of 599"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {0};
        const struct weft_log log = {keep_message, &message};
        r->params.log = &log;
        context->info.max_target_size = cases[i].side;
        context->info.max_buffer_texels = cases[i].texels;
        assert_int_equal(hand_run(context, h, r, NULL), WEFT_ERR_LIMIT);
        if (!strstr(message.text, cases[i].text))
            fail_msg("'%s' instead of '%s'", message.text, cases[i].text);
    }
    context->info = info;
    weft_multipass *compiled = NULL;
    assert_int_equal(
        weft_multipass_compile(context, weft_multipass_params(.plan = NULL), &compiled),
        WEFT_ERR_ARGUMENT);
    assert_null(compiled);
    free(r);
    hand_list_destroy(h);
}

// ---- once means once ----------------------------------------------------------------------------

enum { STRIDE = 37, FEW = 20, MANY = 33 };

// Runs on a grid of side x side pixels and returns a copy of them; tiles and programs stay.
static float *run_again(weft_multipass *compiled, struct hand_request *r, int side, int stride)
{
    struct weft_multipass_report report;
    float *out = calloc(MANY * STRIDE, sizeof *out);
    assert_non_null(out);
    for (int i = 0; i < HAND_MAX_PIXELS; i++)
        r->pixels[0][i] = -7.0f;
    r->grid = (struct weft_pixel_grid){
        .width = side, .height = side, .du = {0.31, 0.02, 0.0}, .dv = {-0.03, 0.29, 0.0}};
    r->params.stride = stride;
    assert_int_equal(weft_multipass_run(compiled, &r->params, &report), WEFT_OK);
    assert_int_equal(report.programs_linked, 0);
    if (weft_multipass_get_info(compiled)->programs) // on GL
        assert_int_equal(report.uploaded_bytes, report.source_bytes + report.position_bytes);
    assert_int_equal(report.tile_bytes, weft_multipass_get_info(compiled)->tile_bytes);
    const int row = stride ? stride : side;
    for (int i = 0; i < HAND_MAX_PIXELS; i++)
        if (i % row >= side || i / row >= side)
            assert_true(r->pixels[0][i] == -7.0f); // between the rows, and behind
        else
            out[i / row * STRIDE + i % row] = r->pixels[0][i];
    return out;
}

// Drives from the cache what nobody holds.
static void fill_program_cache(weft_context *context)
{
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    for (int i = 0; i < WEFT_PROGRAM_CACHE + 3; i++) {
        char defines[32];
        GLuint program;
        snprintf(defines, sizeof defines, "#define UNUSED %d\n", i);
        assert_int_equal(weft_program_get(context, "constant", defines, weft_shader_full_target,
                                          constant_fragment, &program),
                         WEFT_OK);
    }
    weft_context_leave(context);
}

static void assert_same(float *a, float *b)
{
    assert_memory_equal(a, b, MANY * STRIDE * sizeof *a);
    free(b);
}

static void runs_repeat_nothing_and_agree(void **state)
{
    static const struct plan_case cases[] = {
        {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 2, "none", 1, false},
        {"catmull-rom", "fp32", WEFT_TECHNIQUE_DOT4, 2, "none", 1, false},
        {"bspline", "unorm16", WEFT_TECHNIQUE_HIERARCHICAL, 2, "none", 1, false},
        {"linear", "unorm8", WEFT_TECHNIQUE_LOG, 2, "none", 1, false},
    };
    int ran = 0;
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(cases); k++) {
        for (int c = -1; c < 2; c++) {
            if (c >= 0 && !contexts[c])
                continue;
            weft_context *context = c < 0 ? NULL : contexts[c];
            weft_pass_plan *plan = make_plan(&cases[k]);
            weft_multipass *compiled = NULL;
            struct hand_request *r =
                hand_request_create(&(struct hand_list){.work.channels = 1}, 1, 1, 9, 9, 1);
            assert_int_equal(
                weft_multipass_compile(
                    context, weft_multipass_params(.plan = plan, .log = &log_to_stderr), &compiled),
                WEFT_OK);
            assert_int_equal(weft_multipass_get_info(compiled)->programs > 0, context != NULL);
            float *few = run_again(compiled, r, FEW, 0);
            assert_same(few, run_again(compiled, r, FEW, 0));
            float *many = run_again(compiled, r, MANY, STRIDE); // larger targets
            if (context)
                fill_program_cache(context);
            assert_same(many, run_again(compiled, r, MANY, STRIDE));
            assert_same(few, run_again(compiled, r, FEW, STRIDE));
            free(few);
            free(many);
            weft_multipass_destroy(&compiled);
            weft_pass_plan_destroy(&plan);
            free(r);
            ran++;
        }
    }
    assert_int_equal(ran, (contexts[1] ? 3 : 2) * (int)WEFT_COUNT(cases));
}

// Another module's draws are as ever after a run: blending is off.
static void state_is_left_clean(void **state)
{
    (void)state;
    weft_context *context = contexts[0];
    struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
    hand_add_all_tiles(h, false);
    struct hand_request *r = hand_request_create(h, 3, 3, 3, 3, 1);
    assert_int_equal(hand_run(context, h, r, NULL), WEFT_OK);
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    GLint equation = 0, framebuffer = -1, alignment = 0;
    context->gl.GetIntegerv(GL_BLEND_EQUATION_RGB, &equation);
    context->gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer);
    context->gl.GetIntegerv(GL_PACK_ALIGNMENT, &alignment);
    assert_false(context->gl.IsEnabled(GL_BLEND));
    assert_true(context->gl.IsEnabled(GL_DITHER));
    assert_int_equal(equation, GL_FUNC_ADD);
    assert_int_equal(framebuffer, 0);
    assert_int_equal(alignment, 4);
    weft_context_leave(context);
    free(r);
    hand_list_destroy(h);
}

static void progress_can_cancel(void **state)
{
    (void)state;
    int calls = 3;
    const struct weft_progress progress = {cancel_at_call, &calls};
    struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
    hand_add_all_tiles(h, false);
    struct hand_request *r = hand_request_create(h, 3, 3, 4, 4, 1);
    r->params.progress = &progress;
    assert_int_equal(hand_run(contexts[0], h, r, NULL), WEFT_ERR_CANCELLED);
    free(r);
    hand_list_destroy(h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blending_adds_whole_codes),
        cmocka_unit_test(clearing_stores_every_code),
        cmocka_unit_test(gl_agrees_in_every_bit),
        cmocka_unit_test(floats_agree_within_roundings),
        cmocka_unit_test(blending_and_ping_pong_agree),
        cmocka_unit_test(plans_keep_their_bounds),
        cmocka_unit_test(smallest_sizes),
        cmocka_unit_test(samples_that_are_not_finite_show),
        cmocka_unit_test(weights_of_zero_spread_nothing),
        cmocka_unit_test(the_largest_floats_stay_finite),
        cmocka_unit_test(limits_are_checked),
        cmocka_unit_test(runs_repeat_nothing_and_agree),
        cmocka_unit_test(state_is_left_clean),
        cmocka_unit_test(progress_can_cancel),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
