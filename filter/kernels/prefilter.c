// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/prefilter.h"

#include <math.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_TERMS = 2 * WEFT_PREFILTER_MAX_POLES + 1 };

// z^poles B(z), B(z) = sum_k h(k) z^-k: its coefficients are the same from both ends.
struct polynomial {
    int degree;
    double c[MAX_TERMS];
};

static double evaluate(const struct polynomial *p, double z)
{
    double sum = 0.0;
    for (int i = p->degree; i >= 0; i--)
        sum = sum * z + p->c[i];
    return sum;
}

static double slope(const struct polynomial *p, double z)
{
    double sum = 0.0;
    for (int i = p->degree; i > 0; i--)
        sum = sum * z + i * p->c[i];
    return sum;
}

static double bisect(const struct polynomial *p, double a, double b)
{
    const bool rises = evaluate(p, b) > 0.0;
    for (;;) {
        const double middle = 0.5 * (a + b);
        if (middle == a || middle == b)
            return middle;
        if ((evaluate(p, middle) > 0.0) == rises)
            b = middle;
        else
            a = middle;
    }
}

// All roots inside the unit circle are real and negative (Schoenberg), at ratios far above a step.
static void find_poles(const struct polynomial *p, struct weft_prefilter *out)
{
    enum { STEPS_PER_OCTAVE = 4, OCTAVES = 12 };
    double z = -1.0;
    for (int i = 1; i <= OCTAVES * STEPS_PER_OCTAVE && out->poles < p->degree / 2; i++) {
        const double next = -exp2((double)-i / STEPS_PER_OCTAVE);
        if ((evaluate(p, z) > 0.0) != (evaluate(p, next) > 0.0))
            out->pole[out->poles++] = bisect(p, z, next);
        z = next;
    }
}

enum weft_result weft_prefilter_compute(const struct weft_log *log,
                                        const struct weft_kernel *kernel,
                                        struct weft_prefilter *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, kernel && kernel->info && out);
    *out = (struct weft_prefilter){0};
    if (!weft_kernel_check_info(log, kernel->info))
        goto fail;
    res = weft_kernel_check_prefilter(log, kernel->info);
    if (res != WEFT_OK)
        goto fail;
    const struct weft_kernel_info *info =
        kernel->info->primitive ? kernel->info->primitive : kernel->info;
    struct weft_kernel spline;
    res = weft_kernel_create(log, info, kernel->param, &spline);
    if (res != WEFT_OK)
        goto fail;
    struct polynomial p = {.degree = 2 * ((int)ceil(spline.support) - 1)};
    weft_require(log, p.degree < MAX_TERMS);
    for (int i = 0; i <= p.degree; i++)
        p.c[i] = weft_kernel_weight(&spline, i - p.degree / 2);
    find_poles(&p, out);
    // The residues of z^(k - 1) / B(z).
    for (int i = 0; i < out->poles; i++)
        out->factor[i] = pow(out->pole[i], p.degree / 2 - 1) / slope(&p, out->pole[i]);
    out->gain = 1.0 / fabs(evaluate(&p, -1.0));
fail:
    return res;
}

// Whether it can have come from weft_prefilter_compute.
static bool is_filter(const struct weft_prefilter *prefilter)
{
    bool good = prefilter->poles >= 0 && prefilter->poles <= WEFT_PREFILTER_MAX_POLES;
    for (int i = 0; good && i < prefilter->poles; i++)
        good = prefilter->pole[i] > -1.0 && prefilter->pole[i] < 0.0;
    return good;
}

static bool are_weights(const struct weft_prefilter *prefilter, const struct weft_kernel *kernel,
                        int overlap)
{
    return weft_kernel_usable(kernel) && is_filter(prefilter) && overlap >= 0 &&
           overlap <= WEFT_PREFILTER_MAX_OVERLAP;
}

// ---- lines --------------------------------------------------------------------------------------

// The signal past an end, m = 0, 1, ... samples beyond it: constant + sum_j term[j] pole[j]^m, with
// as many terms as poles were filtered by.
struct extension {
    double constant, term[WEFT_PREFILTER_MAX_POLES];
};

// Filters by pole i both ways; (1 - z)^2 makes the gain at frequency 0 one. w is the signal after
// the causal recursion, v after the anticausal one; at every end the sums without end are closed.
static void filter_by(const struct weft_prefilter *prefilter, int i, double *values, size_t count,
                      ptrdiff_t stride, struct extension *left, struct extension *right)
{
    const double *pole = prefilter->pole, z = pole[i], scale = (1.0 - z) * (1.0 - z);
    double *at = values, w = left->constant / (1.0 - z);
    for (int j = 0; j < i; j++) {
        left->term[j] /= 1.0 - z * pole[j];
        w += left->term[j];
    }
    const double w_left = w;
    for (size_t k = 0; k < count; k++, at += stride)
        *at = w = *at + z * w;

    // w past the right end solves its recursion: the inputs' terms, and one of z^m that fits w.
    double v = right->constant / scale;
    right->term[i] = z * w + right->constant - right->constant / (1.0 - z);
    for (int j = 0; j < i; j++) {
        const double a = right->term[j] * pole[j] / (pole[j] - z);
        right->term[i] += right->term[j] - a;
        right->term[j] = a / (1.0 - z * pole[j]);
        v += right->term[j];
    }
    right->term[i] /= 1.0 - z * z;
    v += right->term[i];
    for (size_t k = 0; k < count; k++) {
        at -= stride;
        v = *at + z * v;
        *at = scale * v;
    }

    left->term[i] = w_left + z * v - left->constant / scale;
    for (int j = 0; j < i; j++) {
        left->term[j] *= pole[j] / (pole[j] - z);
        left->term[i] -= left->term[j];
    }
    for (int j = 0; j <= i; j++) {
        left->term[j] *= scale;
        right->term[j] *= scale;
    }
}

void weft_prefilter_line(const struct weft_prefilter *prefilter, double *values, size_t count,
                         ptrdiff_t stride, double before, double after)
{
    if (count == 0 || !is_filter(prefilter))
        return;
    struct extension left = {.constant = isnan(before) ? values[0] : before};
    struct extension right = {.constant =
                                  isnan(after) ? values[(ptrdiff_t)(count - 1) * stride] : after};
    for (int i = 0; i < prefilter->poles; i++)
        filter_by(prefilter, i, values, count, stride, &left, &right);
}

// ---- the impulse response -----------------------------------------------------------------------

int weft_prefilter_overlap(const struct weft_prefilter *prefilter, double error)
{
    for (int n = 0; is_filter(prefilter) && n < WEFT_PREFILTER_MAX_OVERLAP; n++) {
        double rest = 0.0;
        for (int i = 0; i < prefilter->poles; i++)
            rest += 2.0 * fabs(prefilter->factor[i] * pow(prefilter->pole[i], n + 1)) /
                    (1.0 + prefilter->pole[i]);
        if (rest <= error)
            return n;
    }
    return WEFT_PREFILTER_MAX_OVERLAP;
}

void weft_prefilter_taps(const struct weft_prefilter *prefilter, int overlap, double *taps)
{
    double sum = 0.0;
    if (!is_filter(prefilter) || overlap > WEFT_PREFILTER_MAX_OVERLAP)
        return;
    for (int k = overlap; k >= 0; k--) {
        taps[k] = 0.0;
        for (int i = 0; i < prefilter->poles; i++)
            taps[k] += prefilter->factor[i] * pow(prefilter->pole[i], k);
        sum += k > 0 ? 2.0 * taps[k] : taps[k];
    }
    for (int k = 0; k <= overlap; k++)
        taps[k] /= sum;
}

int64_t weft_prefilter_weights(const struct weft_prefilter *prefilter,
                               const struct weft_kernel *kernel, int overlap, double x,
                               double *weights)
{
    double plain[WEFT_KERNEL_MAX_WIDTH], taps[WEFT_PREFILTER_MAX_OVERLAP + 1];
    if (!are_weights(prefilter, kernel, overlap))
        return 0;
    const int64_t first = weft_kernel_weights(kernel, x, plain) - overlap;
    const int count = kernel->width + 2 * overlap;
    weft_prefilter_taps(prefilter, overlap, taps);
    for (int k = 0; k < count; k++)
        weights[k] = 0.0;
    for (int j = 0; j < kernel->width; j++)
        for (int k = -overlap; k <= overlap; k++)
            weights[j + overlap + k] += plain[j] * taps[k < 0 ? -k : k];
    return first;
}

// ---- the truth ----------------------------------------------------------------------------------

static int64_t clamp(int64_t x, int64_t low, int64_t high)
{
    return x < low ? low : x > high ? high : x;
}

void weft_prefilter_axis_set(const struct weft_prefilter *prefilter,
                             const struct weft_kernel *kernel, int overlap, double x, int64_t low,
                             int64_t high, struct weft_prefilter_axis *out)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], taps[WEFT_PREFILTER_MAX_OVERLAP + 1];
    out->first = out->count = 0;
    if (!are_weights(prefilter, kernel, overlap) || high < low)
        return;
    const int64_t first = weft_prefilter_weights(prefilter, kernel, overlap, x, weights);
    const int count = kernel->width + 2 * overlap, last_tap = overlap + kernel->width - 1;
    weft_prefilter_taps(prefilter, overlap, taps);
    out->first = clamp(first, low, high);
    out->count = (int)(clamp(first + count - 1, low, high) - out->first) + 1;
    for (int k = 0; k < out->count; k++)
        out->weight[k] = out->reach[k] = 0.0;
    for (int k = 0; k < count; k++) {
        const int64_t at = clamp(first + k, low, high) - out->first;
        out->weight[at] += weights[k];
        out->reach[at] += fabs(taps[k < overlap ? overlap - k : k > last_tap ? k - last_tap : 0]);
    }
}

// Coefficients' weights are cut off nearer than those here, by up to 3 gain^2 2^-28 in sum, the
// cardinal spline's gain being below 1.9: two thirds of what may be missing.
bool weft_prefilter_is_missing(double depends, double reaches, double whole, bool finite)
{
    return depends > 2.0 * WEFT_PREFILTER_MISSING * whole ||
           (reaches > 0.99 * WEFT_PREFILTER_MISSING && !finite);
}
