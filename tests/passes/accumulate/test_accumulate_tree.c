// SPDX-License-Identifier: BSD-3-Clause
// Trees as a method of accumulators, against exact means, and GL against the emulation, bit for
// bit. WEFT_TREE_FRAMES=300 sweeps all N up to that on GL, too.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/passes/accumulate/frames.h"
#include "tests/support/contexts.h"
#include "passes/accumulate/tree/stack.h"
#include "passes/gl/context_backend.h"

enum { WIDTH = 5, HEIGHT = 3, PIXELS = WIDTH * HEIGHT, MAX_CHANNELS = 6, FEW = 40, ALL = 300 };

static const enum weft_plane_type types_of_bits[] = {
    [8] = WEFT_PLANE_UNORM8, [16] = WEFT_PLANE_UNORM16, [32] = WEFT_PLANE_FLOAT};

// ---- runs ---------------------------------------------------------------------------------------

static struct weft_accumulator_params params_of(const struct frames *f, int bits, int branching)
{
    return (struct weft_accumulator_params){.width = WIDTH,
                                            .height = HEIGHT,
                                            .channel_count = f->channels,
                                            .method = WEFT_ACCUMULATE_TREE,
                                            .bits = bits,
                                            .branching = branching,
                                            .cpu = {.threads = 1},
                                            .log = &log_to_stderr};
}

static weft_accumulator *make(struct weft_accumulator_params params, weft_context *context)
{
    weft_accumulator *a = NULL;
    params.context = context;
    params.emulate = !context;
    assert_int_equal(weft_accumulator_create(&params, &a), WEFT_OK);
    return a;
}

static void add_frames(weft_accumulator *a, const struct frames *f, int first, int end)
{
    for (int i = first; i < end; i++)
        assert_int_equal(
            weft_accumulator_add(a, &(struct weft_frame){.plane = f->plane + i * f->channels},
                                 f->weight[i]),
            WEFT_OK);
}

static void read_mean(weft_accumulator *a, int channels, float out[][PIXELS])
{
    for (int c = 0; c < channels; c++)
        assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, out[c], 0), WEFT_OK);
}

// All frames, one after another, and what comes of them.
static struct weft_accumulator_report run(const struct weft_accumulator_params *params,
                                          const struct frames *f, weft_context *context,
                                          float out[][PIXELS])
{
    struct weft_accumulator_report report;
    weft_accumulator *a = make(*params, context);
    add_frames(a, f, 0, f->count);
    assert_int_equal(weft_accumulator_finish(a), WEFT_OK);
    read_mean(a, f->channels, out);
    weft_accumulator_get_report(a, &report);
    weft_accumulator_destroy(&a);
    return report;
}

static void sum_all(struct frames *f)
{
    for (int i = 0; i < f->count; i++)
        if (f->weight[i] != 0.0)
            sum_frame(f, i);
}

// The exact mean is of long doubles: itself within 2^-62 or so of values up to 1000.
static void check_bound(const struct frames *f, float out[][PIXELS], double bound)
{
    for (int c = 0; c < f->channels; c++) {
        const double error = mean_error(f, c, out[c]);
        if (!(error <= bound + 0x1p-52))
            fail_msg("%d frames: error %g, bound %g", f->count, error, bound);
    }
}

// ---- all N --------------------------------------------------------------------------------------

static const int lists[][WEFT_TREE_MAX_LEVELS] = {{0}, {2, 4, 4, 16}, {3, 2, 5, 16}, {16, 2, 2, 8}};
static const int branchings[] = {2, 3, 4, 8, 16};
enum { SHAPES = WEFT_COUNT(branchings) + WEFT_COUNT(lists) - 1 };

static void set_shape(struct weft_accumulator_params *p, size_t shape)
{
    p->branching = shape < WEFT_COUNT(branchings) ? branchings[shape] : 4;
    if (shape >= WEFT_COUNT(branchings))
        memcpy(p->level_branching, lists[shape - WEFT_COUNT(branchings) + 1],
               sizeof p->level_branching);
}

enum weights { ONES, INTEGERS, TENTHS, UNIFORM, HUGE_AND_TINY, KINDS };

static void weigh(struct frames *f, enum weights kind, uint64_t seed)
{
    for (int i = 0; i < f->count; i++) {
        const double u = next_uniform(&seed), v = next_uniform(&seed);
        f->weight[i] = kind == ONES       ? 1.0
                       : kind == INTEGERS ? (double)(1 + i % 5)
                       : kind == TENTHS   ? 0.1
                       : kind == UNIFORM  ? (v < 0.2 ? 0.0 : u)
                                          : (v < 0.2 ? 0.0 : pow(10.0, 12.0 * u - 6.0));
    }
    if (f->weight[f->count / 2] == 0.0)
        f->weight[f->count / 2] = 0.5;
}

static int count_weights(const struct frames *f)
{
    int count = 0;
    for (int i = 0; i < f->count; i++)
        count += f->weight[i] != 0.0;
    return count;
}

// The stack of the schedule that weft_tree_create makes for as many leaves.
static int stack_size_of(const struct weft_accumulator_params *p, int leaves)
{
    weft_tree *tree = NULL;
    struct weft_tree_params params = {.leaf_count = leaves, .branching = p->branching};
    memcpy(params.level_branching, p->level_branching, sizeof params.level_branching);
    assert_int_equal(weft_tree_create(&params, &tree), WEFT_OK);
    const int size = weft_tree_get_info(tree)->stack_size;
    weft_tree_destroy(&tree);
    return size;
}

// Images: the stack, and one more where there are nodes; one for a node of what is left at the end.
static void check_gl(const struct weft_accumulator_params *params, const struct frames *f,
                     const struct weft_accumulator_report *emulated, float expected[][PIXELS])
{
    static float out[MAX_CHANNELS][PIXELS];
    for (int k = 0; k < 2 && contexts[k]; k++) {
        const struct weft_accumulator_report report = run(params, f, contexts[k], out);
        const int groups = (f->channels + 3) / 4;
        assert_memory_equal(out, expected, (size_t)f->channels * sizeof out[0]);
        assert_true(report.bound == emulated->bound && report.bias == emulated->bias);
        assert_true(report.textures <= groups * (stack_size_of(params, (int)report.counted) + 2));
    }
}

struct sweep {
    int runs, on_gl, inexact;
};

static void check_case(struct sweep *sweep, const struct weft_accumulator_params *given,
                       struct frames *f, enum weights kind, bool gl)
{
    static float out[MAX_CHANNELS][PIXELS], known[MAX_CHANNELS][PIXELS];
    struct weft_accumulator_params params = *given;
    const struct weft_accumulator_report report = run(&params, f, NULL, out);
    check_bound(f, out, report.bound);
    assert_int_equal(report.frames, f->count);
    assert_int_equal(report.counted, count_weights(f));
    if (kind <= TENTHS && params.bits != 32)
        assert_true(report.weight_change == 0.0);
    sweep->inexact += report.weight_change > 0.0;
    sweep->runs++;
    if (gl) {
        check_gl(&params, f, &report, out);
        sweep->on_gl++;
    }
    params.frame_count = f->count;
    params.weight = f->weight;
    run(&params, f, NULL, known);
    assert_memory_equal(known, out, (size_t)f->channels * sizeof out[0]);
}

static void sweep_frames(struct sweep *sweep, int n, bool all)
{
    static const int bits[] = {8, 16, 32};
    const bool prime = n == 2 || n == 3 || n == 5 || n == 7 || n == 31 || n == 97 || n == 257;
    for (size_t b = 0; b < WEFT_COUNT(bits); b++)
        for (size_t shape = 0; shape < SHAPES; shape++)
            for (int kind = 0; kind < KINDS; kind++) {
                const int turn = n + (int)shape + kind;
                // Types that are the target's, and others in turn.
                const enum weft_plane_type type =
                    turn % 2 ? types_of_bits[bits[b]] : (enum weft_plane_type)(turn / 2 % 4);
                struct frames f;
                struct weft_accumulator_params params;
                if (!all && (n > FEW && !prime) && turn % 7)
                    continue;
                make_frames(&f, n, turn % 3 ? 3 : MAX_CHANNELS, PIXELS, type, 0.0, 1.0,
                            1 + (uint64_t)turn);
                weigh(&f, kind, 77 + (uint64_t)turn);
                sum_all(&f);
                params = params_of(&f, bits[b], 0);
                params.rounding = turn % WEFT_TREE_ROUNDING_COUNT;
                set_shape(&params, shape);
                check_case(sweep, &params, &f, kind, turn % (all ? 11 : n > 16 ? 41 : 17) == 0);
                free_frames(&f);
            }
}

static void test_any_number_of_frames(void **state)
{
    static const int counts[] = {47, 64, 81, 97, 128, 200, 256, 257, 300};
    const char *text = getenv("WEFT_TREE_FRAMES");
    const int most = text ? atoi(text) : 0;
    struct sweep sweep = {0};
    (void)state;
    for (int n = 1; n <= (most ? most : FEW); n += most || n < 10 ? 1 : 3)
        sweep_frames(&sweep, n, most > 0);
    for (size_t i = 0; i < WEFT_COUNT(counts) && !most; i++)
        sweep_frames(&sweep, counts[i], false);
    print_message("%d trees, %d of them on GL, %d with inexact shares\n", sweep.runs, sweep.on_gl,
                  sweep.inexact);
    assert_true(sweep.runs >= 1000 && sweep.on_gl >= 80 && sweep.inexact >= 100);
}

// (b - 1) log_b N + 1 images for N = b^levels, and the scratch.
static void test_textures(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(branchings); i++) {
        const int b = branchings[i];
        for (int levels = 1, n = b; n <= 300; levels++, n *= b) {
            static float out[MAX_CHANNELS][PIXELS];
            struct frames f;
            make_frames(&f, n, 4, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0, 3);
            weigh(&f, ONES, 1);
            const struct weft_accumulator_params params = params_of(&f, 8, b);
            const struct weft_accumulator_report report = run(&params, &f, contexts[0], out);
            assert_int_equal(report.textures, (b - 1) * levels + 1 + 1);
            // Planes of the target's own type are no pass, so what is drawn are the nodes.
            assert_int_equal(report.passes, (n - 1) / (b - 1));
            free_frames(&f);
        }
    }
}

// What was so far is looked at again and again, and nothing is changed by it.
static void test_current(void **state)
{
    static float out[MAX_CHANNELS][PIXELS], expected[MAX_CHANNELS][PIXELS];
    struct frames f;
    (void)state;
    make_frames(&f, 70, 5, PIXELS, WEFT_PLANE_UNORM16, 0.0, 1.0, 5);
    weigh(&f, UNIFORM, 5);
    f.weight[0] = 0.25;
    for (int bits = 8; bits <= 32; bits *= 2) {
        const struct weft_accumulator_params params = params_of(&f, bits, 4);
        for (int k = 0; k < 3; k++) {
            weft_context *context = k < 2 ? contexts[k] : NULL;
            if (k == 1 && !context)
                continue;
            weft_accumulator *a = make(params, context);
            for (int i = 0; i < f.count; i++) {
                struct frames part = f;
                struct weft_accumulator_report report;
                add_frames(a, &f, i, i + 1);
                if (i % 9 && i != f.count - 1)
                    continue;
                part.count = i + 1;
                part.sum = calloc((size_t)f.channels * PIXELS, sizeof *part.sum);
                assert_non_null(part.sum);
                sum_all(&part);
                read_mean(a, f.channels, out);
                weft_accumulator_get_report(a, &report);
                check_bound(&part, out, report.bound);
                run(&params, &part, NULL, expected);
                assert_memory_equal(out, expected, (size_t)f.channels * sizeof out[0]);
                free(part.sum);
            }
            weft_accumulator_destroy(&a);
        }
    }
    free_frames(&f);
}

// In memory, on any number of threads, and on GL: more pixels than a thread does at once.
static void test_threads(void **state)
{
    enum { WIDE = 211, HIGH = 23, MANY = WIDE * HIGH, CHANNELS = 5 };
    static float out[MANY], expected[CHANNELS][MANY];
    struct frames f;
    (void)state;
    make_frames(&f, 13, CHANNELS, MANY, WEFT_PLANE_HALF, 0.0, 1.0, 71);
    weigh(&f, UNIFORM, 3);
    for (int bits = 8; bits <= 32; bits *= 2)
        for (int threads = 1; threads <= 6; threads++) {
            struct weft_accumulator_params params = params_of(&f, bits, 3);
            params.width = WIDE;
            params.height = HIGH;
            params.cpu.threads = threads;
            weft_accumulator *a = make(params, threads == 6 ? contexts[0] : NULL);
            add_frames(a, &f, 0, f.count);
            for (int c = 0; c < CHANNELS; c++) {
                assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c,
                                                          threads == 1 ? expected[c] : out, 0),
                                 WEFT_OK);
                if (threads > 1)
                    assert_memory_equal(out, expected[c], sizeof out);
            }
            weft_accumulator_destroy(&a);
        }
    free_frames(&f);
}

// ---- shares -------------------------------------------------------------------------------------

// A stack's nodes, followed leaf by leaf.
struct walk {
    struct weft_tree_stack stack;
    int first[WEFT_TREE_MAX_PARTS + 1]; // leaf of each part
    double share[ALL];                  // of each leaf below its part
};

static void walk_node(struct walk *w, int count)
{
    struct weft_tree_node node;
    const int at = w->stack.count - count;
    uint64_t sum = 0;
    weft_tree_stack_combine(&w->stack, count, &node);
    assert_int_equal(node.input_count, count);
    for (int k = 0; k < count; k++) {
        for (int i = w->first[at + k]; i < w->first[at + k + 1]; i++)
            w->share[i] *= (double)node.numerator[k] / node.denominator;
        sum += node.numerator[k];
    }
    assert_int_equal(sum, node.denominator);
    assert_true(node.denominator <= w->stack.shape.largest_denominator);
    assert_true((uint64_t)node.denominator * w->stack.shape.largest_code + node.add <= UINT32_MAX);
    w->first[at + 1] = w->first[at + count];
}

// Every leaf's weight, and least and most of them; shares that are off cost at most half the sum of
// what they are off by, in largest codes: that is in the error, beside the roundings.
static bool check_shares(struct walk *w, const struct frames *f)
{
    long double total = 0.0L, off = 0.0L;
    double least = INFINITY, most = 0.0;
    int leaf = 0;
    for (int i = 0; i < f->count; i++)
        total += (long double)f->weight[i];
    for (int i = 0; i < f->count; i++) {
        if (f->weight[i] == 0.0)
            continue;
        const double exact = (double)((long double)f->weight[i] / total);
        const double ratio = w->share[leaf] / exact;
        off += fabsl(w->share[leaf++] - (long double)exact) / 2;
        least = fmin(least, ratio);
        most = fmax(most, ratio);
    }
    const struct weft_tree_part *part = &w->stack.part[0];
    assert_near(part->least, least, 1e-12 * (1.0 + least), "least");
    assert_near(part->most, most, 1e-12 * (1.0 + most), "most");
    assert_true((double)off * w->stack.shape.largest_code <= part->error * (1.0 + 1e-9) + 1e-9);
    return part->least == 1.0 && part->most == 1.0;
}

static void test_shares(void **state)
{
    int exact = 0, inexact = 0;
    (void)state;
    for (int n = 1; n <= ALL; n++)
        for (int kind = 0; kind < KINDS; kind++)
            for (int bits = 8; bits <= 16; bits += 8) {
                const uint32_t one = bits == 8 ? 255 : 65535;
                struct walk w = {.stack = {.shape = {.branching = branchings[n % 5],
                                                     .rounding = n % 3,
                                                     .largest_code = one,
                                                     .largest_denominator = 0xffffffffu / one}}};
                struct frames f;
                int count, leaves = 0;
                make_frames(&f, n, 1, 1, WEFT_PLANE_UNORM8, 0.0, 1.0, 1);
                weigh(&f, kind, (uint64_t)n);
                w.stack.shape.largest_denominator = (uint32_t)(0x100000000u / (one + 1));
                for (int i = 0; i < n; i++) {
                    if (f.weight[i] == 0.0)
                        continue;
                    w.first[w.stack.count] = leaves;
                    w.share[leaves++] = 1.0;
                    w.first[w.stack.count + 1] = leaves;
                    weft_tree_stack_push(&w.stack, weft_tree_weight_from(f.weight[i]), 0.0);
                    while ((count = weft_tree_stack_ready(&w.stack)) > 0)
                        walk_node(&w, count);
                }
                while ((count = weft_tree_stack_carry(&w.stack)) > 0)
                    walk_node(&w, count);
                const bool is_exact = check_shares(&w, &f);
                assert_true(is_exact || kind > TENTHS);
                exact += is_exact;
                inexact += !is_exact;
                free_frames(&f);
            }
    assert_true(exact >= 1800 && inexact >= 1000);
}

// As one after another.
static void test_filled_stacks(void **state)
{
    (void)state;
    for (size_t i = 0; i < SHAPES; i++) {
        struct weft_accumulator_params p = {0};
        set_shape(&p, i);
        struct weft_tree_shape shape = {
            .branching = p.branching, .largest_code = 255, .largest_denominator = 1 << 24};
        memcpy(shape.level_branching, p.level_branching, sizeof shape.level_branching);
        struct weft_tree_stack one_by_one = {.shape = shape};
        const int64_t most = weft_tree_shape_capacity(&shape);
        for (int64_t n = 1; n <= 1000 && n <= most; n++) {
            struct weft_tree_stack filled = {.shape = shape};
            struct weft_tree_node node;
            int count;
            weft_tree_stack_push(&one_by_one, weft_tree_weight_from(1.0), 0.25);
            while ((count = weft_tree_stack_ready(&one_by_one)) > 0)
                weft_tree_stack_combine(&one_by_one, count, &node);
            weft_tree_stack_fill(&filled, n, 0.25);
            assert_int_equal(filled.count, one_by_one.count);
            const struct weft_tree_part a = weft_tree_stack_preview(&filled),
                                        b = weft_tree_stack_preview(&one_by_one);
            assert_true(a.error == b.error && a.bias == b.bias && a.level == b.level);
        }
    }
}

// ---- the paper's figures ------------------------------------------------------------------------

// Figure 3: the same frame any number of times is that frame.
static void test_identical_frames(void **state)
{
    static const int counts[] = {32, 64, 128, 256, 1024};
    static float out[MAX_CHANNELS][PIXELS];
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        for (int b = 2; b <= 4; b++)
            for (int rounding = 0; rounding < WEFT_TREE_ROUNDING_COUNT; rounding++) {
                struct frames f;
                make_frames(&f, counts[i], 4, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0, 9);
                weigh(&f, ONES, 1);
                for (int k = 4; k < 4 * counts[i]; k++)
                    f.plane[k] = f.plane[k % 4];
                struct weft_accumulator_params params = params_of(&f, 8, b);
                params.rounding = rounding;
                run(&params, &f, counts[i] <= 256 ? contexts[0] : NULL, out);
                for (int c = 0; c < 4; c++)
                    for (size_t x = 0; x < PIXELS; x++)
                        assert_true(out[c][x] == (float)plane_value(&f.plane[c], x));
                free_frames(&f);
            }
}

// Section 3.4: 256 frames of a truncating binary tree are within 4 codes; and the mean error of
// random codes is what the report says. Of 240 results that scatter by about 0.35 codes, the mean
// of 8 runs scatters by less than 0.01.
static void test_bias(void **state)
{
    static const struct {
        int branching, frames;
    } cases[] = {{2, 256}, {3, 243}, {4, 256}, {16, 256}, {4, 300}};
    static float out[MAX_CHANNELS][PIXELS];
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        for (int rounding = 0; rounding < WEFT_TREE_ROUNDING_COUNT; rounding++) {
            struct weft_accumulator_report report = {0};
            double sum = 0.0, worst = 0.0;
            enum { RUNS = 40, CHANNELS = 6 };
            for (int k = 0; k < RUNS; k++) {
                struct frames f;
                make_frames(&f, cases[i].frames, CHANNELS, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0,
                            1000 + (uint64_t)k);
                weigh(&f, ONES, 1);
                sum_all(&f);
                struct weft_accumulator_params params = params_of(&f, 8, cases[i].branching);
                params.rounding = rounding;
                report = run(&params, &f, NULL, out);
                for (int c = 0; c < CHANNELS; c++)
                    for (int x = 0; x < PIXELS; x++) {
                        const double error = out[c][x] - (double)(f.sum[c * PIXELS + x] / f.total);
                        sum += 255.0 * error;
                        worst = fmax(worst, 255.0 * fabs(error));
                    }
                free_frames(&f);
            }
            const double mean = sum / (RUNS * CHANNELS * PIXELS);
            print_message("%d frames by %d, %s: bias %.4f codes, reported %.4f; worst %.2f\n",
                          cases[i].frames, cases[i].branching, weft_tree_rounding_names[rounding],
                          mean, 255.0 * report.bias, worst);
            assert_near(mean, 255.0 * report.bias, 0.03, "bias");
            if (cases[i].branching == 2)
                assert_true(worst <= 4.0 + 1e-4);
        }
}

// ---- kinds of frames ----------------------------------------------------------------------------

struct painter {
    const GladGLContext *gl;
    const struct frames *f;
    int calls;
    enum weft_result result;
};

// A frame of RGBA, texel by texel, and leaves much behind.
static enum weft_result paint(void *priv, int64_t index, const struct weft_draw_target *target)
{
    struct painter *p = priv;
    (void)target;
    p->gl->Enable(GL_SCISSOR_TEST);
    for (int i = 0; i < PIXELS; i++) {
        float v[4];
        for (int c = 0; c < 4; c++)
            v[c] = (float)plane_value(&p->f->plane[4 * index + c], (size_t)i);
        p->gl->Scissor(i % WIDTH, i / WIDTH, 1, 1);
        p->gl->ClearColor(v[0], v[1], v[2], v[3]);
        p->gl->Clear(GL_COLOR_BUFFER_BIT);
    }
    p->gl->Scissor(0, 0, 1, 1);
    p->gl->Enable(GL_BLEND);
    p->gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    p->calls++;
    return p->result;
}

static GLuint make_texture(weft_context *context, const struct frames *f, int frame)
{
    static float texels[4 * PIXELS];
    const GladGLContext *gl = &context->gl;
    GLuint texture;
    for (int i = 0; i < 4 * PIXELS; i++)
        texels[i] = (float)plane_value(&f->plane[4 * frame + i % 4], (size_t)i / 4);
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0,
                   f->type == WEFT_PLANE_UNORM8    ? GL_RGBA8
                   : f->type == WEFT_PLANE_UNORM16 ? GL_RGBA16
                                                   : GL_RGBA32F,
                   WIDTH, HEIGHT, 0, GL_RGBA, GL_FLOAT, texels);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    weft_context_leave(context);
    return texture;
}

// From memory, from textures and drawn: the same bytes. What is drawn takes no pass but nodes.
static void test_kinds_of_frames(void **state)
{
    static float expected[MAX_CHANNELS][PIXELS], out[MAX_CHANNELS][PIXELS];
    enum { FRAMES = 23 };
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (int bits = 8; bits <= 32; bits *= 2)
            for (int ranged = 0; ranged < 2; ranged++) {
                struct frames f;
                make_frames(&f, FRAMES, 4, PIXELS, types_of_bits[bits], 0.0, 1.0, 11);
                weigh(&f, UNIFORM, 3);
                struct weft_accumulator_params params = params_of(&f, bits, 4);
                params.low = ranged ? -0.25 : 0.0;
                params.high = ranged ? 1.5 : 1.0;
                const struct weft_accumulator_report in_memory =
                    run(&params, &f, contexts[k], expected);
                weft_accumulator *textures = make(params, contexts[k]),
                                 *drawn = make(params, contexts[k]), *emulated = NULL;
                struct painter p = {.gl = &contexts[k]->gl, .f = &f};
                for (int i = 0; i < FRAMES; i++) {
                    const GLuint texture = make_texture(contexts[k], &f, i);
                    assert_int_equal(weft_accumulator_add(textures,
                                                          &(struct weft_frame){.texture = texture},
                                                          f.weight[i]),
                                     WEFT_OK);
                    assert_int_equal(
                        weft_accumulator_add(drawn, &(struct weft_frame){.draw = paint, .priv = &p},
                                             f.weight[i]),
                        WEFT_OK);
                    assert_int_equal(weft_context_enter(contexts[k]), WEFT_OK);
                    contexts[k]->gl.DeleteTextures(1, &texture);
                    weft_context_leave(contexts[k]);
                }
                // Read back, and then as in memory.
                struct painter other = p;
                params.emulate = true;
                params.context = contexts[k];
                assert_int_equal(weft_accumulator_create(&params, &emulated), WEFT_OK);
                for (int i = 0; i < FRAMES; i++)
                    assert_int_equal(
                        weft_accumulator_add(emulated,
                                             &(struct weft_frame){.draw = paint, .priv = &other},
                                             f.weight[i]),
                        WEFT_OK);
                read_mean(emulated, 4, out);
                assert_memory_equal(out, expected, 4 * sizeof out[0]);
                weft_accumulator_destroy(&emulated);
                struct weft_accumulator_report reports[2];
                read_mean(textures, 4, out);
                assert_memory_equal(out, expected, 4 * sizeof out[0]);
                read_mean(drawn, 4, out);
                assert_memory_equal(out, expected, 4 * sizeof out[0]);
                assert_int_equal(p.calls, count_weights(&f));
                weft_accumulator_get_report(textures, &reports[0]);
                weft_accumulator_get_report(drawn, &reports[1]);
                // A texture of the images' format is copied, by a pass before GL 4.3.
                const bool pass = !(ranged && bits < 32) && !contexts[k]->gl.CopyImageSubData;
                assert_int_equal(reports[0].passes,
                                 reports[1].passes + (pass ? (uint64_t)p.calls : 0));
                assert_int_equal(reports[1].passes, in_memory.passes);
                assert_true(reports[1].textures <= stack_size_of(&params, p.calls) + 2);
                weft_accumulator_destroy(&textures);
                weft_accumulator_destroy(&drawn);
                free_frames(&f);
            }
}

// Frames of 8 bits, drawn for sums of more: the bytes of the same frames in memory.
static void test_frame_bits(void **state)
{
    static const struct {
        enum weft_accumulate_method method;
        int bits;
    } cases[] = {{WEFT_ACCUMULATE_TREE, 16},   {WEFT_ACCUMULATE_TREE, 32},
                 {WEFT_ACCUMULATE_FLOAT, 0},   {WEFT_ACCUMULATE_BLEND, 32},
                 {WEFT_ACCUMULATE_BUFFER, 16}, {WEFT_ACCUMULATE_EXACT, 0}};
    static float expected[MAX_CHANNELS][PIXELS], out[MAX_CHANNELS][PIXELS];
    enum { FRAMES = 11 };
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            struct frames f;
            make_frames(&f, FRAMES, 4, PIXELS, types_of_bits[8], 0.0, 1.0, 12);
            weigh(&f, UNIFORM, 3);
            struct weft_accumulator_params params = params_of(&f, cases[i].bits, 4);
            params.method = cases[i].method;
            params.frame_bits = 8;
            run(&params, &f, contexts[k], expected);
            weft_accumulator *drawn = make(params, contexts[k]);
            struct painter p = {.gl = &contexts[k]->gl, .f = &f};
            for (int frame = 0; frame < FRAMES; frame++)
                assert_int_equal(
                    weft_accumulator_add(drawn, &(struct weft_frame){.draw = paint, .priv = &p},
                                         f.weight[frame]),
                    WEFT_OK);
            read_mean(drawn, 4, out);
            assert_memory_equal(out, expected, 4 * sizeof out[0]);
            weft_accumulator_destroy(&drawn);
            free_frames(&f);
        }
}

// What is kept beside the mean sees the frame that was drawn, although its image is used on.
static void test_drawn_and_kept(void **state)
{
    static float out[PIXELS], expected[PIXELS];
    struct frames f;
    (void)state;
    make_frames(&f, 9, 4, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0, 13);
    weigh(&f, ONES, 3);
    struct weft_accumulator_params params = params_of(&f, 8, 2);
    struct painter p = {.gl = &contexts[0]->gl, .f = &f};
    params.keep = WEFT_KEEP_EXTREMES;
    weft_accumulator *drawn = make(params, contexts[0]), *given = make(params, NULL);
    for (int i = 0; i < f.count; i++)
        assert_int_equal(
            weft_accumulator_add(drawn, &(struct weft_frame){.draw = paint, .priv = &p}, 1.0),
            WEFT_OK);
    add_frames(given, &f, 0, f.count);
    for (int c = 0; c < 4; c++) {
        assert_int_equal(weft_accumulator_current(drawn, WEFT_ACCUMULATED_MAXIMUM, c, out, 0),
                         WEFT_OK);
        assert_int_equal(weft_accumulator_current(given, WEFT_ACCUMULATED_MAXIMUM, c, expected, 0),
                         WEFT_OK);
        assert_memory_equal(out, expected, sizeof out);
    }
    assert_int_equal(p.calls, f.count);
    weft_accumulator_destroy(&drawn);
    weft_accumulator_destroy(&given);
    free_frames(&f);
}

// Values in a range of their own.
static void test_range(void **state)
{
    static const struct {
        double low, high;
    } ranges[] = {{0.0, 4.0}, {-1.0, 1.0}, {1000.0, 1001.0}, {0.1, 0.3}};
    static float out[MAX_CHANNELS][PIXELS];
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(ranges); i++)
        for (int bits = 8; bits <= 16; bits += 8) {
            struct frames f;
            make_frames(&f, 19, 3, PIXELS, WEFT_PLANE_FLOAT, ranges[i].low, ranges[i].high, 21);
            weigh(&f, UNIFORM, 3);
            sum_all(&f);
            struct weft_accumulator_params params = params_of(&f, bits, 3);
            params.low = ranges[i].low;
            params.high = ranges[i].high;
            const struct weft_accumulator_report report = run(&params, &f, NULL, out);
            check_bound(&f, out, report.bound);
            assert_true(report.bound <
                        5.0 * (params.high - params.low) / (bits == 8 ? 255 : 65535) +
                            3.0 * 0x1p-24 * fabs(params.high) * 3.0);
            check_gl(&params, &f, &report, out);
            free_frames(&f);
        }
}

// Values so small that GL may take them, or what becomes of them, for 0: within the bound.
static void test_small_values(void **state)
{
    static const double sizes[] = {0x1p-100, 0x1p-124, 0x1p-130, 0x1p-140};
    static float out[MAX_CHANNELS][PIXELS], expected[MAX_CHANNELS][PIXELS];
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++)
        for (int k = 0; k < 3; k++) {
            weft_context *context = k < 2 ? contexts[k] : NULL;
            struct frames f;
            if (k == 1 && !context)
                continue;
            make_frames(&f, 29, 3, PIXELS, WEFT_PLANE_FLOAT, -sizes[i], sizes[i], 61);
            weigh(&f, UNIFORM, 3);
            sum_all(&f);
            const struct weft_accumulator_params params = params_of(&f, 32, 4);
            const struct weft_accumulator_report report = run(&params, &f, context, out);
            assert_true(report.bound < 1e-6 * sizes[i] + 0x1p-115);
            for (int c = 0; c < 3; c++)
                assert_true(mean_error(&f, c, out[c]) <= report.bound);
            run(&params, &f, NULL, expected);
            assert_memory_equal(out, expected, 3 * sizeof out[0]);
            free_frames(&f);
        }
}

// Small halves are not lost on their way.
static void test_small_halves(void **state)
{
    static float out[MAX_CHANNELS][PIXELS], expected[MAX_CHANNELS][PIXELS];
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++) {
        struct frames f;
        make_frames(&f, 3, 3, PIXELS, WEFT_PLANE_HALF, -0x1p-15, 0x1p-15, 61);
        weigh(&f, ONES, 3);
        sum_all(&f);
        const struct weft_accumulator_params params = params_of(&f, 32, 4);
        const struct weft_accumulator_report report = run(&params, &f, contexts[k], out);
        assert_true(report.bound < 1e-6 * 0x1p-15);
        check_bound(&f, out, report.bound);
        run(&params, &f, NULL, expected);
        assert_memory_equal(out, expected, 3 * sizeof out[0]);
        free_frames(&f);
    }
}

// ---- states -------------------------------------------------------------------------------------

static void test_states(void **state)
{
    static float expected[MAX_CHANNELS][PIXELS], out[MAX_CHANNELS][PIXELS];
    struct frames f;
    (void)state;
    make_frames(&f, 37, 5, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0, 31);
    weigh(&f, UNIFORM, 9);
    for (int bits = 8; bits <= 32; bits *= 2) {
        struct weft_accumulator_params params = params_of(&f, bits, 3);
        params.rounding = WEFT_TREE_UNBIASED;
        const struct weft_accumulator_report whole = run(&params, &f, NULL, expected);
        for (int cut = 0; cut <= f.count; cut++) {
            // On GL, goes on in memory, and the other way round.
            weft_accumulator *first = make(params, cut % 2 ? contexts[0] : NULL),
                             *second = make(params, cut % 3 ? NULL : contexts[0]);
            struct weft_accumulator_report report;
            void *bytes = NULL;
            size_t size;
            add_frames(first, &f, 0, cut);
            assert_int_equal(weft_accumulator_save(first, &bytes, &size), WEFT_OK);
            assert_int_equal(weft_accumulator_load(second, bytes, size), WEFT_OK);
            add_frames(second, &f, cut, f.count);
            read_mean(second, f.channels, out);
            assert_memory_equal(out, expected, (size_t)f.channels * sizeof out[0]);
            weft_accumulator_get_report(second, &report);
            assert_true(report.bound == whole.bound && report.bias == whole.bias);
            assert_true(report.weight_change == whole.weight_change);
            // Cut anywhere: refused, and the accumulator is as it was.
            weft_accumulator_destroy(&second);
            params.log = NULL;
            second = make(params, NULL);
            params.log = &log_to_stderr;
            assert_int_equal(weft_accumulator_load(second, bytes, size - 1), WEFT_ERR_FORMAT);
            add_frames(second, &f, 0, f.count);
            read_mean(second, f.channels, out);
            assert_memory_equal(out, expected, (size_t)f.channels * sizeof out[0]);
            weft_accumulator_destroy(&first);
            weft_accumulator_destroy(&second);
            free(bytes);
        }
    }
    free_frames(&f);
}

// What no accumulator could have left is not taken for a stack.
static void test_unsound_stacks(void **state)
{
    struct weft_tree_stack stack = {.shape = {.branching = 3, .level_branching = {2, 3, 2}}};
    struct weft_tree_node node;
    int sound = 0, unsound = 0, count;
    (void)state;
    for (int n = 1; n <= 12; n++) {
        weft_tree_stack_push(&stack, weft_tree_weight_from(n), 0.0);
        while ((count = weft_tree_stack_ready(&stack)) > 0)
            weft_tree_stack_combine(&stack, count, &node);
        assert_true(weft_tree_stack_is_sound(&stack));
        sound++;
        for (int i = 0; i < stack.count; i++)
            for (int level = -1; level <= WEFT_TREE_MAX_DEPTH + 1; level++) {
                struct weft_tree_stack other = stack;
                other.part[i].level = level;
                if (level == stack.part[i].level)
                    continue;
                assert_false(weft_tree_stack_is_sound(&other));
                unsound++;
            }
        for (int kind = 0; kind < 7; kind++) {
            struct weft_tree_stack other = stack;
            other.leaves += kind == 0 ? 1 : kind == 1 ? -1 : 0;
            other.count += kind == 2 ? 1 : 0;
            other.nodes[2] = kind == 3 ? INT64_MAX : kind == 4 ? -1 : other.nodes[2];
            other.part[0].weight.value = kind == 5 ? 0 : other.part[0].weight.value;
            other.part[0].weight.exponent = kind == 6 ? INT32_MAX : 0;
            assert_false(weft_tree_stack_is_sound(&other));
            unsound++;
        }
    }
    assert_true(sound == 12 && unsound >= 500);
}

// ---- what is refused ----------------------------------------------------------------------------

static void test_params_refused(void **state)
{
    static const struct {
        struct weft_accumulator_params params;
        const char *text;
    } cases[] = {
        {{.bits = WEFT_ACCUMULATE_HALF}, "8, 16 or 32 bits, not half floats"},
        {{.bits = 8, .nonfinite = WEFT_NONFINITE_PROPAGATE}, "8 bits hold no NaN"},
        {{.bits = 8, .branching = 1}, "branching (1)"},
        {{.bits = 8, .branching = 17}, "branching (17)"},
        {{.bits = 8, .level_branching = {2, 1}}, "level_branching are from 2 to 16"},
        {{.bits = 8, .level_branching = {2, 4}, .frame_count = 9}, "9 frames, but the branching"},
        {{.bits = 8, .emulate = false}, "need a context"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_accumulator_params params = cases[i].params;
        weft_accumulator *a = NULL;
        params.width = params.height = params.channel_count = 1;
        params.method = WEFT_ACCUMULATE_TREE;
        params.emulate = i + 1 < WEFT_COUNT(cases);
        params.log = &log;
        assert_int_equal(weft_accumulator_create(&params, &a), WEFT_ERR_ARGUMENT);
        assert_null(a);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].text))
            fail_msg("no \"%s\" in: %s", cases[i].text, message.text);
    }
}

// Frames of weight 0 are no leaves.
static void test_leaves_are_frames_that_count(void **state)
{
    static const double weight[9] = {1, 1, 0, 1, 1, 1, 1, 1, 1};
    static float out[MAX_CHANNELS][PIXELS];
    struct frames f;
    (void)state;
    make_frames(&f, 9, 1, PIXELS, WEFT_PLANE_UNORM8, 0.0, 1.0, 41);
    memcpy(f.weight, weight, sizeof weight);
    sum_all(&f);
    struct weft_accumulator_params params = params_of(&f, 8, 0);
    params.level_branching[0] = 2;
    params.level_branching[1] = 4;
    params.frame_count = f.count;
    params.weight = f.weight;
    const struct weft_accumulator_report report = run(&params, &f, NULL, out);
    check_bound(&f, out, report.bound);
    assert_int_equal(report.counted, 8);
    free_frames(&f);
}

// A frame that is refused leaves all as it was.
static void test_frames_refused(void **state)
{
    static float expected[MAX_CHANNELS][PIXELS], out[MAX_CHANNELS][PIXELS];
    static const float values[] = {NAN, INFINITY, -0.001f, 1.001f};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct frames f;
    (void)state;
    make_frames(&f, 8, 4, PIXELS, WEFT_PLANE_FLOAT, 0.0, 1.0, 41);
    weigh(&f, ONES, 1);
    for (int k = 0; k < 3; k++) {
        weft_context *context = k < 2 ? contexts[k] : NULL;
        if (k == 1 && !context)
            continue;
        for (int bits = 8; bits <= 32; bits *= 4) {
            struct weft_accumulator_params params = params_of(&f, bits, 2);
            const int level_branching[] = {2, 4};
            memcpy(params.level_branching, level_branching, sizeof level_branching);
            run(&params, &f, context, expected);
            params.log = &log;
            weft_accumulator *a = make(params, context);
            struct painter p = {
                .gl = context ? &context->gl : NULL, .f = &f, .result = WEFT_ERR_CANCELLED};
            for (int i = 0; i < f.count; i++) {
                float bad[PIXELS];
                struct weft_plane planes[4];
                memcpy(planes, f.plane, sizeof planes);
                memcpy(bad, f.plane[2].values, sizeof bad);
                bad[7] = values[i % (bits == 32 ? 2 : 4)];
                planes[2].values = bad;
                message.text[0] = '\0';
                assert_int_equal(
                    weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, 1.0),
                    WEFT_ERR_FORMAT);
                assert_non_null(strstr(message.text, "channel 2, pixel (2, 1)"));
                if (context)
                    assert_int_equal(weft_accumulator_add(
                                         a, &(struct weft_frame){.draw = paint, .priv = &p}, 1.0),
                                     WEFT_ERR_CANCELLED);
                add_frames(a, &f, i, i + 1);
            }
            assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = f.plane}, 1.0),
                             WEFT_ERR_LIMIT);
            assert_non_null(strstr(message.text, "product, 8"));
            read_mean(a, 4, out);
            assert_memory_equal(out, expected, 4 * sizeof out[0]);
            weft_accumulator_destroy(&a);
        }
    }
    free_frames(&f);
}

// Where they may pass, they stay in their pixel.
static void test_nan_propagates(void **state)
{
    static float out[MAX_CHANNELS][PIXELS], expected[MAX_CHANNELS][PIXELS];
    (void)state;
    for (int k = 0; k < 3; k++) {
        weft_context *context = k < 2 ? contexts[k] : NULL;
        struct frames f;
        if (k == 1 && !context)
            continue;
        make_frames(&f, 11, 3, PIXELS, WEFT_PLANE_FLOAT, 0.0, 1.0, 41);
        weigh(&f, ONES, 1);
        struct weft_accumulator_params params = params_of(&f, 32, 4);
        run(&params, &f, context, expected);
        ((float *)f.values)[3 * PIXELS + 4] = NAN;
        params.nonfinite = WEFT_NONFINITE_PROPAGATE;
        params.keep = WEFT_KEEP_EXTREMES;
        assert_int_equal(run(&params, &f, context, out).nonfinite, 1);
        params.keep = 0;
        assert_int_equal(run(&params, &f, context, out).nonfinite, 1);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < PIXELS; i++)
                assert_true(c == 0 && i == 4 ? isnan(out[c][i]) : out[c][i] == expected[c][i]);
        free_frames(&f);
    }
}

// What is promised before any frame holds for frames of any type in the range.
static void test_expected_bound(void **state)
{
    static float out[MAX_CHANNELS][PIXELS];
    (void)state;
    for (int bits = 8; bits <= 32; bits *= 2)
        for (int n = 1; n <= 70; n += 23) {
            struct frames f;
            struct weft_accumulator_report before;
            make_frames(&f, n, 3, PIXELS, WEFT_PLANE_FLOAT, 0.0, 1.0, 51);
            weigh(&f, ONES, 1);
            struct weft_accumulator_params params = params_of(&f, bits, 4);
            weft_accumulator *a = make(params, NULL);
            weft_accumulator_get_report(a, &before);
            assert_true(isinf(before.bound));
            weft_accumulator_destroy(&a);
            params.frame_count = n;
            a = make(params, NULL);
            weft_accumulator_get_report(a, &before);
            weft_accumulator_destroy(&a);
            const struct weft_accumulator_report report = run(&params, &f, NULL, out);
            assert_true(report.bound <= before.bound && before.bound < 2.0 * report.bound + 1e-6);
            free_frames(&f);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_number_of_frames),
        cmocka_unit_test(test_textures),
        cmocka_unit_test(test_current),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_shares),
        cmocka_unit_test(test_filled_stacks),
        cmocka_unit_test(test_identical_frames),
        cmocka_unit_test(test_bias),
        cmocka_unit_test(test_kinds_of_frames),
        cmocka_unit_test(test_frame_bits),
        cmocka_unit_test(test_drawn_and_kept),
        cmocka_unit_test(test_range),
        cmocka_unit_test(test_small_values),
        cmocka_unit_test(test_small_halves),
        cmocka_unit_test(test_states),
        cmocka_unit_test(test_unsound_stacks),
        cmocka_unit_test(test_params_refused),
        cmocka_unit_test(test_leaves_are_frames_that_count),
        cmocka_unit_test(test_frames_refused),
        cmocka_unit_test(test_nan_propagates),
        cmocka_unit_test(test_expected_bound),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
