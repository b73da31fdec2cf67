// SPDX-License-Identifier: BSD-3-Clause
// Facts of several kernels, side by side.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/kernel/facts.h"

enum { CELL = 40, NAMES = 22 };

typedef void (*cell)(const struct kernel_facts *f, char text[CELL]);

static void put(char text[CELL], const char *words)
{
    snprintf(text, CELL, "%s", words);
}

static void support(const struct kernel_facts *f, char text[CELL])
{
    snprintf(text, CELL, "%g", f->kernel.support);
}

static void taps(const struct kernel_facts *f, char text[CELL])
{
    snprintf(text, CELL, "%d", f->kernel.width);
}

static void continuity(const struct kernel_facts *f, char text[CELL])
{
    if (f->kernel.continuity < 0)
        put(text, "jumps");
    else
        snprintf(text, CELL, "C%d", f->kernel.continuity);
}

static void reconstructs(const struct kernel_facts *f, char text[CELL])
{
    if (f->kernel.info->derivation)
        snprintf(text, CELL, "derivative %d", f->kernel.info->derivation);
    else
        put(text, "the signal");
}

static void interpolating(const struct kernel_facts *f, char text[CELL])
{
    put(text, f->kernel.interpolating || f->kernel.prefiltered ? "yes" : "no");
}

static void prefilter(const struct kernel_facts *f, char text[CELL])
{
    put(text, f->kernel.prefiltered                                ? "applied"
              : kernel_needs_prefilter(f) && f->interpolator.order ? "needed"
                                                                   : "none");
}

static void unit_sum(const struct kernel_facts *f, char text[CELL])
{
    put(text, f->kernel.info->derivation ? "0"
              : f->kernel.normalised     ? "divided"
              : f->unit_sum              ? "yes"
                                         : "no");
}

// Prefiltered kernels' order is the interpolator's.
static void order(const struct kernel_facts *f, char text[CELL])
{
    snprintf(text, CELL, "%d", f->order.order);
}

static void constant(const struct kernel_facts *f, char text[CELL])
{
    if (f->order.order)
        snprintf(text, CELL, "%.4g", f->order.constant);
    else
        put(text, "-");
}

static void at_frequency(const struct kernel_facts *f, double frequency, char text[CELL])
{
    snprintf(text, CELL, "%.2f", kernel_decibel(weft_analysis_response(&f->kernel, frequency)));
}

static void at_quarter(const struct kernel_facts *f, char text[CELL])
{
    at_frequency(f, 0.25, text);
}

static void at_nyquist(const struct kernel_facts *f, char text[CELL])
{
    at_frequency(f, 0.5, text);
}

static void at_three_quarters(const struct kernel_facts *f, char text[CELL])
{
    at_frequency(f, 0.75, text);
}

// Of a derivative of the signal these say nothing.
static void quality(const struct kernel_facts *f, double value, char text[CELL])
{
    if (f->kernel.info->derivation)
        put(text, "-");
    else
        snprintf(text, CELL, "%.4g", kernel_tidy(value));
}

static void smoothing(const struct kernel_facts *f, char text[CELL])
{
    quality(f, f->metrics[0].smoothing, text);
}

static void postaliasing(const struct kernel_facts *f, char text[CELL])
{
    quality(f, f->metrics[0].postaliasing, text);
}

static void overshoot(const struct kernel_facts *f, char text[CELL])
{
    quality(f, f->overshoot.above, text);
}

static void gain(const struct kernel_facts *f, char text[CELL])
{
    snprintf(text, CELL, "%.4g", f->gain);
}

static const struct {
    const char *name;
    cell write;
} rows[] = {
    {"reconstructs", reconstructs},
    {"support (half-width)", support},
    {"taps per axis", taps},
    {"continuity", continuity},
    {"interpolating", interpolating},
    {"prefilter", prefilter},
    {"unit sum", unit_sum},
    {"order", order},
    {"RMS constant", constant},
    {"|H(0.25)|, dB", at_quarter},
    {"|H(0.5)|, dB", at_nyquist},
    {"|H(0.75)|, dB", at_three_quarters},
    {"smoothing, 1D", smoothing},
    {"post-aliasing, 1D", postaliasing},
    {"overshoot of a step", overshoot},
    {"sum of |weights|", gain},
};

// A column is as wide as its name, and wide enough for what stands in it.
static int width_of(const struct kernel_facts *f)
{
    const int name = (int)strlen(f->name);
    return name < 12 ? 12 : name;
}

void kernel_compare(const struct kernel_facts *const *facts, int count)
{
    printf("%-*s", NAMES, "");
    for (int k = 0; k < count; k++)
        printf("  %*s", width_of(facts[k]), facts[k]->name);
    puts("");
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        printf("%-*s", NAMES, rows[r].name);
        for (int k = 0; k < count; k++) {
            char text[CELL];
            rows[r].write(facts[k], text);
            printf("  %*s", width_of(facts[k]), text);
        }
        puts("");
    }
}
