// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/weights.h"

#include <math.h>
#include <stdlib.h>

#include "filter/analysis/analysis.h"
#include "passes/positions/footprint_impl.h"

// Polynomial tiles are to be as good as the sums.
static const double TILE_TOLERANCE[] = {[WEFT_SUMS_FLOAT] = 1e-9, [WEFT_SUMS_DOUBLE] = 1e-12};

static const double UNIT[] = {[WEFT_SUMS_FLOAT] = 0x1p-24, [WEFT_SUMS_DOUBLE] = 0x1p-53};

// What Horner's rule rounds for one tap at u in a segment: each step's product and sum by what they
// are there (a running error), and the coefficients by half a unit each.
static double horner_error(const struct weft_polynomial_tiles *t, const double *coefficients,
                           double u, double unit)
{
    const size_t stride = 4 * (size_t)t->groups;
    double value = coefficients[(size_t)t->degree * stride];
    double error = t->exact ? 0.0 : unit * fabs(value);
    for (int p = t->degree - 1; p >= 0; p--) {
        const double c = coefficients[(size_t)p * stride], product = value * u;
        value = product + c;
        error = error * u + unit * (fabs(product) + fabs(value) + (t->exact ? 0.0 : fabs(c)));
    }
    return error;
}

// The largest sum of these over the taps, found at points a little apart.
static double rounding_of_weights(const struct weft_polynomial_tiles *t, enum weft_sums sums)
{
    enum { POINTS = 512 };
    const size_t segment_size = 4 * (size_t)t->groups * (size_t)(t->degree + 1);
    const int points = t->segments < POINTS ? POINTS / t->segments : 1;
    double largest = 0.0;
    for (int i = 0; i <= t->segments * points - (points == 1); i++) {
        const int segment = i / points < t->segments ? i / points : t->segments - 1;
        const double u = points == 1 ? 1.0 : (double)(i - segment * points) / points;
        double sum = 0.0;
        for (int tap = 0; tap < t->width; tap++)
            sum +=
                horner_error(t, t->precise + (size_t)segment * segment_size + tap, u, UNIT[sums]);
        largest = fmax(largest, sum);
    }
    // Between two points it can be a little more.
    return 1.05 * largest;
}

// The slope at u of a tap's polynomial in a segment, by u.
static double slope_at(const struct weft_polynomial_tiles *t, const double *coefficients, double u)
{
    double slope = 0.0;
    for (int p = t->degree; p > 0; p--)
        slope = slope * u + p * coefficients[(size_t)p * 4 * (size_t)t->groups];
    return slope;
}

static double slope_of_weights(const struct weft_polynomial_tiles *t)
{
    const int points = t->segments > 16 ? 2 : 16;
    const size_t segment_size = 4 * (size_t)t->groups * (size_t)(t->degree + 1);
    double largest = 0.0;
    for (int i = 0; i < t->segments * (points + 1); i++) {
        const double *segment = t->precise + (size_t)(i / (points + 1)) * segment_size;
        double sum = 0.0;
        for (int tap = 0; tap < t->width; tap++)
            sum += fabs(slope_at(t, segment + tap, (double)(i % (points + 1)) / points));
        largest = fmax(largest, sum * t->segments);
    }
    // Between two points it can be a little more.
    return 1.05 * largest;
}

enum weft_result weft_kernel_facts_weights(const struct weft_log *log,
                                           struct weft_kernel_facts *facts, int samples,
                                           bool linear, enum weft_sums sums,
                                           const struct weft_slice_weights **out)
{
    const struct weft_kernel *kernel = &facts->kernel;
    *out = NULL;
    for (size_t i = 0; !*out && i < facts->weights_count; i++)
        if (facts->weights[i]->samples == samples && facts->weights[i]->linear == linear &&
            facts->weights[i]->sums == sums)
            *out = facts->weights[i];
    if (*out)
        return WEFT_OK;
    void *all = realloc(facts->weights, (facts->weights_count + 1) * sizeof *facts->weights);
    if (all)
        facts->weights = all;
    struct weft_slice_weights *own = all ? calloc(1, sizeof *own) : NULL;
    if (!own) {
        weft_error(log, "not enough memory for the weights of kernel %s", kernel->info->name);
        return WEFT_ERR_MEMORY;
    }
    own->samples = samples;
    own->linear = linear;
    own->sums = sums;
    const enum weft_result res =
        samples ? weft_polynomial_tiles_sample(log, kernel, samples, linear, &own->tiles)
                : weft_polynomial_tiles_create(log, kernel, TILE_TOLERANCE[sums], &own->tiles);
    if (res != WEFT_OK) {
        free(own);
        return res;
    }
    own->error = rounding_of_weights(&own->tiles, sums) + own->tiles.sum_error;
    own->slope = slope_of_weights(&own->tiles);
    facts->weights[facts->weights_count++] = own;
    *out = own;
    return res;
}

const struct weft_slice_kernel *weft_kernel_facts_compute(struct weft_kernel_facts *of)
{
    struct weft_slice_kernel *facts = &of->facts;
    const struct weft_kernel *kernel = &of->kernel;
    struct weft_kernel plain = *kernel;
    if (facts->known)
        return facts;
    plain.prefiltered = false;
    *facts = (struct weft_slice_kernel){
        .known = true,
        .gain = weft_analysis_gain(&plain),
        .slope = weft_analysis_slope(kernel),
        .along = weft_prefilter_error(kernel, 1, WEFT_VOLUME_PREFILTER_ERROR),
    };
    if (kernel->prefiltered)
        facts->prefilter = weft_prefilter_error_join(
            (const struct weft_prefilter_error[3]){facts->along, facts->along, facts->along}, 3);
    // The first of two taps is known from that of an even number of taps only.
    if (plain.unit_sum && plain.width % 2 == 0 && plain.width > 2)
        facts->curvature = weft_analysis_curvature(&plain);
    return facts;
}

enum weft_result weft_footprint_weights(const struct weft_log *log,
                                        struct weft_footprint *footprint, int samples, bool linear,
                                        enum weft_sums sums, const struct weft_slice_weights **out)
{
    return weft_kernel_facts_weights(log, footprint->facts, samples, linear, sums, out);
}

const struct weft_slice_kernel *weft_footprint_kernel(struct weft_footprint *footprint)
{
    return weft_kernel_facts_compute(footprint->facts);
}

enum weft_result weft_footprint_derive(const struct weft_log *log, struct weft_footprint *footprint,
                                       int order, struct weft_kernel_facts **out)
{
    struct weft_kernel kernel = footprint->facts->kernel;
    *out = footprint->facts;
    for (int i = 0; i < order; i++) {
        if (weft_kernel_derive(NULL, &kernel, &kernel) == WEFT_OK)
            continue;
        weft_error(log, "kernel %s%s has no derivative of order %d along an axis",
                   footprint->facts->kernel.info->name,
                   footprint->facts->kernel.normalised ? "+unit" : "", order);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (order)
        *out = weft_kernel_facts_find(&footprint->facts->next, &kernel);
    if (*out)
        return WEFT_OK;
    weft_error(log, "not enough memory for the derivative of kernel %s", kernel.info->name);
    return WEFT_ERR_MEMORY;
}

bool weft_kernel_same(const struct weft_kernel *a, const struct weft_kernel *b)
{
    bool same = a->info == b->info && a->normalised == b->normalised && a->radial == b->radial &&
                a->prefiltered == b->prefiltered;
    for (int i = 0; i < WEFT_KERNEL_PARAMS; i++)
        same = same && (!a->info->params[i].name || a->param[i] == b->param[i]);
    return same;
}

struct weft_kernel_facts *weft_kernel_facts_find(struct weft_kernel_facts **list,
                                                 const struct weft_kernel *kernel)
{
    struct weft_kernel_facts *facts = *list;
    while (facts && !weft_kernel_same(&facts->kernel, kernel))
        facts = facts->next;
    if (facts)
        return facts;
    facts = calloc(1, sizeof *facts);
    if (!facts)
        return NULL;
    facts->kernel = *kernel;
    facts->next = *list;
    *list = facts;
    return facts;
}

void weft_kernel_facts_destroy(struct weft_kernel_facts **list)
{
    while (*list) {
        struct weft_kernel_facts *facts = *list;
        *list = facts->next;
        for (size_t i = 0; i < facts->weights_count; i++) {
            weft_polynomial_tiles_destroy(&facts->weights[i]->tiles);
            free(facts->weights[i]);
        }
        free(facts->weights);
        free(facts);
    }
}
