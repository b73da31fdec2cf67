// SPDX-License-Identifier: BSD-3-Clause
// tools/kernel/facts.h - what `weft kernel` finds out about a kernel, and ways to show it.
#ifndef WEFT_TOOLS_KERNEL_FACTS_H
#define WEFT_TOOLS_KERNEL_FACTS_H

#include "tools/common/json.h"
#include "tools/common/report.h"
#include "tools/options/kernels.h"

enum {
    KERNEL_MOMENTS = 6,
    KERNEL_TAYLOR_ORDERS = 5,
    KERNEL_TAYLOR_POSITIONS = 4,
    KERNEL_FREQUENCIES = 9,
    KERNEL_DIMS = 3,
    KERNEL_MOST = 8, // kernels that are compared, each with a colour of its own
};

extern const double kernel_taylor_positions[KERNEL_TAYLOR_POSITIONS];
extern const double kernel_frequencies[KERNEL_FREQUENCIES]; // cycles per sample distance

struct kernel_facts {
    struct weft_kernel kernel;
    char name[KERNELS_TEXT];
    const char *symmetry; // "even", "odd" or "none"
    bool unit_sum;
    struct weft_analysis_order order;
    struct weft_analysis_order interpolator; // with weft's prefilter; order 0 where there is none
    double moment[KERNEL_MOMENTS];
    double taylor[KERNEL_TAYLOR_ORDERS][KERNEL_TAYLOR_POSITIONS];
    struct weft_analysis_response response[KERNEL_FREQUENCIES];
    struct weft_analysis_metrics metrics[KERNEL_DIMS];
    struct weft_analysis_overshoot overshoot;
    double gain;
};

// Fills in all but the kernel, which is there.
void kernel_facts_gather(struct kernel_facts *facts);
// Whether a prefilter would raise its order, and it has none.
bool kernel_needs_prefilter(const struct kernel_facts *facts);

double kernel_magnitude(struct weft_analysis_response h);
// The integrals are good to about 1e-12: what is below is zero, -INFINITY.
double kernel_decibel(struct weft_analysis_response h);
// What rounding leaves of a zero is one.
double kernel_tidy(double x);

// Facts side by side on standard output, a column each. (compare.c)
void kernel_compare(const struct kernel_facts *const *facts, int count);

// The curves of a kernel in its document; and kernels, slopes and spectra of several in one plot,
// with a legend where they are more than one. (plot.c)
void kernel_set_curves(json_t *root, const struct weft_kernel *kernel);
enum exit_code kernel_draw(const struct kernel_facts *const *facts, int count, const char *path);

#endif
