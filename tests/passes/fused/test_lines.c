// SPDX-License-Identifier: BSD-3-Clause
// Lines of pixels with several outputs: every set of instructions that runs here, both precisions,
// positions that step and that are listed, against sums in double; and the value among them as the
// same bytes as the value alone.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/fused/lines/lines.h"
#include "tests/support/common.h"

enum {
    MOST_WIDTH = 12,
    SPAN = MOST_WIDTH + 7,
    PIXELS = 203, // no multiple of any vector
    LOW_BITS = 11,
    ALL_SETS = WEFT_INSTRUCTIONS_AVX512 + 1,
};

static uint64_t state = 1;

static uint32_t random_word(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 20);
}

static const struct weft_derivative all[WEFT_DERIVATIVES] = {
    {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{2, 0, 0}},
    {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}}, {{0, 1, 1}}, {{0, 0, 2}},
};

// A kernel, its derivatives as far as it has them, and their tiles.
struct family {
    int orders, width;
    struct weft_kernel kernel[WEFT_LINE_ORDERS];
    struct weft_polynomial_tiles tiles[WEFT_LINE_ORDERS];
    const struct weft_polynomial_tiles *list[WEFT_LINE_ORDERS];
    double error[WEFT_LINE_ORDERS], gain[WEFT_LINE_ORDERS]; // sums over a position's taps
    int output_count;
    struct weft_derivative output[WEFT_DERIVATIVES];
};

// Samples of a block, and past its end what must not count.
static float samples[SPAN * SPAN * SPAN + WEFT_LINE_SAMPLES];
static uint32_t words[3][PIXELS + WEFT_LINE_PAD];
static const float *start[PIXELS + WEFT_LINE_PAD];
static float stepped[WEFT_DERIVATIVES * PIXELS], listed[WEFT_DERIVATIVES * PIXELS], alone[PIXELS];

// What Horner's rule rounds, a product and a sum for each power, and coefficients: no more than 3
// units of the sum of all |coefficients| for each of them.
static void measure(struct family *f, int n, double unit)
{
    const struct weft_polynomial_tiles *t = &f->tiles[n];
    double most = 0.0;
    const size_t size = 4 * (size_t)t->groups * (size_t)(t->degree + 1);
    for (int s = 0; s < t->segments; s++) {
        double sum = 0.0;
        for (size_t i = 0; i < size; i++)
            sum += fabs(t->precise[(size_t)s * size + i]);
        most = fmax(most, sum);
    }
    f->gain[n] = most; // of fractions up to 1: no less than the sum of |weights|
    f->error[n] = t->sum_error + 3 * (t->degree + 1) * unit * most;
}

static void make_family(const char *name, enum weft_sums sums, struct family *f)
{
    memset(f, 0, sizeof *f);
    assert_int_equal(weft_kernel_parse(NULL, name, &f->kernel[0]), WEFT_OK);
    for (int n = 1; n < WEFT_LINE_ORDERS; n++, f->orders++)
        if (weft_kernel_derive(NULL, &f->kernel[n - 1], &f->kernel[n]) != WEFT_OK)
            break;
    f->orders++;
    f->width = f->kernel[0].width;
    for (int n = 0; n < f->orders; n++) {
        assert_int_equal(weft_polynomial_tiles_create(NULL, &f->kernel[n],
                                                      sums == WEFT_SUMS_FLOAT ? 1e-9 : 1e-12,
                                                      &f->tiles[n]),
                         WEFT_OK);
        f->list[n] = &f->tiles[n];
        measure(f, n, sums == WEFT_SUMS_FLOAT ? 0x1p-24 : 0x1p-53);
    }
    // In an order of their own.
    for (int o = 0; o < WEFT_DERIVATIVES; o++) {
        const struct weft_derivative *d = &all[(7 * o + 3) % WEFT_DERIVATIVES];
        if (d->along[0] < f->orders && d->along[1] < f->orders && d->along[2] < f->orders)
            f->output[f->output_count++] = *d;
    }
}

static void clear_family(struct family *f)
{
    for (int n = 0; n < f->orders; n++)
        weft_polynomial_tiles_destroy(&f->tiles[n]);
}

// The value and its own bound at fractions that single precision holds.
static double reference(const struct family *f, const struct weft_derivative *d, int pixel,
                        double unit, double *bound)
{
    double w[3][WEFT_KERNEL_MAX_WIDTH], sum = 0.0, off = 1.0, all_gain = 1.0;
    const float *first = start[pixel];
    const int pitch = f->width + 7;
    for (int a = 0; a < 3; a++) {
        const int n = d->along[a];
        const double t = (words[a][pixel] & 0x1fffffff) * 0x1p-29;
        first += (words[a][pixel] >> 29) * (a == 0   ? 1u
                                            : a == 1 ? (unsigned)pitch
                                                     : (unsigned)(pitch * pitch));
        for (int i = 0; i < f->width; i++)
            w[a][i] = weft_kernel_weight(&f->kernel[n], t + weft_kernel_offset(&f->kernel[n]) - i);
        off *= f->gain[n] + f->error[n];
        all_gain *= f->gain[n];
    }
    for (int z = 0; z < f->width; z++)
        for (int y = 0; y < f->width; y++)
            for (int x = 0; x < f->width; x++)
                sum += w[2][z] * w[1][y] * w[0][x] * (double)first[(z * pitch + y) * pitch + x];
    // Samples are within +-1. Results are rounded to floats once.
    *bound = off * (1.0 + 3 * f->width * unit) - all_gain + 0x1p-24 * fabs(sum) + 1e-30;
    return sum;
}

static void set_positions(struct weft_line *line)
{
    // Steps and firsts are multiples of 2^-24 voxels.
    for (int a = 0; a < 3; a++) {
        line->position[a] = (uint32_t)random_word() & ~31u;
        line->step[a] = (uint32_t)random_word() & 0x00ffffe0u;
        line->low[a] = 0;
        line->low_step[a] = 0;
        for (int i = 0; i < PIXELS + WEFT_LINE_PAD; i++)
            words[a][i] =
                line->position[a] + (uint32_t)(i < PIXELS ? i : PIXELS - 1) * line->step[a];
        line->listed[a] = NULL;
    }
    line->low_bits = LOW_BITS;
}

static void run(const struct family *f, enum weft_instruction_set set, enum weft_sums sums,
                struct weft_line *line, bool list, int outputs, float *out)
{
    struct weft_line_kernel kernel = {0};
    assert_int_equal(weft_line_kernel_create(NULL, sums, f->list, &kernel), WEFT_OK);
    kernel.pitch_y = (uint32_t)f->width + 7;
    kernel.pitch_z = kernel.pitch_y * kernel.pitch_y;
    kernel.output_count = outputs;
    memcpy(kernel.output, f->output, sizeof f->output);
    line->kernel = &kernel;
    line->start = start;
    line->count = PIXELS;
    line->plane = PIXELS;
    line->out = out;
    for (int a = 0; a < 3; a++)
        line->listed[a] = list ? words[a] : NULL;
    weft_line_find(set, &kernel)(line);
    weft_line_kernel_destroy(&kernel);
}

static int check(const char *name, enum weft_instruction_set set, enum weft_sums sums)
{
    struct family f;
    struct weft_line line;
    const double unit = sums == WEFT_SUMS_FLOAT ? 0x1p-24 : 0x1p-53;
    int checked = 0;
    make_family(name, sums, &f);
    set_positions(&line);
    run(&f, set, sums, &line, false, f.output_count, stepped);
    run(&f, set, sums, &line, true, f.output_count, listed);
    assert_memory_equal(stepped, listed, sizeof *stepped * PIXELS * (size_t)f.output_count);
    run(&f, set, sums, &line, true, 0, alone);
    for (int o = 0; o < f.output_count; o++) {
        const int *along = f.output[o].along;
        if (along[0] + along[1] + along[2] == 0)
            assert_memory_equal(stepped + o * PIXELS, alone, sizeof alone);
        for (int i = 0; i < PIXELS; i++, checked++) {
            double bound;
            const double exact = reference(&f, &f.output[o], i, unit, &bound);
            const double off = fabs((double)stepped[o * PIXELS + i] - exact);
            if (!(off <= bound))
                fail_msg("%s, %s, %s sums, d %d%d%d of pixel %d: %.9g, not %.9g: off by %.3g of "
                         "%.3g",
                         name, weft_instruction_set_names[set], weft_sums_names[sums], along[0],
                         along[1], along[2], i, (double)stepped[o * PIXELS + i], exact, off, bound);
        }
    }
    clear_family(&f);
    return checked;
}

static void fill_samples(int width)
{
    const size_t count = (size_t)(width + 7) * (size_t)(width + 7) * (size_t)(width + 7);
    for (size_t i = 0; i < count + WEFT_LINE_SAMPLES; i++)
        samples[i] = i < count ? (float)(random_word() % 20001) * 1e-4f - 1.0f : NAN;
    for (int i = 0; i < PIXELS + WEFT_LINE_PAD; i++)
        start[i] = samples;
}

static void several_outputs_are_sums(void **unused)
{
    static const char *const names[] = {"catmull-rom", "bspline3",  "bspline2",  "linear",
                                        "bspline5",    "lanczos:3", "lanczos:6", "nearest"};
    int checked = 0, outputs = 0;
    (void)unused;
    for (size_t k = 0; k < WEFT_COUNT(names); k++) {
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_parse(NULL, names[k], &kernel), WEFT_OK);
        fill_samples(kernel.width);
        for (int set = WEFT_INSTRUCTIONS_PLAIN; set < ALL_SETS; set++) {
            if (!weft_instruction_set_runs((enum weft_instruction_set)set))
                continue;
            outputs = check(names[k], (enum weft_instruction_set)set, WEFT_SUMS_FLOAT);
            outputs += check(names[k], (enum weft_instruction_set)set, WEFT_SUMS_DOUBLE);
            assert_true(outputs >= 2 * PIXELS);
            checked += outputs;
        }
    }
    print_message("%d values of several outputs\n", checked);
    assert_true(checked >= 8 * 2 * PIXELS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(several_outputs_are_sums),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
