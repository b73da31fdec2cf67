// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/pattern/pattern.h"
#include "passes/jitter/points.h"
#include "passes/jitter/weights_impl.h"

// What stays the same of all weights of a spread.
struct shape {
    const struct weft_spread_params *params;
    struct weft_kernel kernel;
    double scale;
    int radius, side; // side = 2 radius + 1
};

// h of the pixel `pixel` at position p, along one axis. Where h jumps at its rims, what it covers is
// half open, as pixels are: the lower rim is in it and the upper one is not, so that each sample on
// a rim belongs to one of two pixels.
static double weigh(const struct shape *s, int pixel, double p)
{
    const double r = s->kernel.support, x = (pixel - p) / s->scale;
    if (s->kernel.continuity < 0 && fabs(fabs(x) - r) <= r * 0x1p-50)
        return x < 0.0 ? 0.0 : weft_kernel_weight(&s->kernel, nextafter(r, 0.0));
    return weft_kernel_weight(&s->kernel, x);
}

static int find_radius(const struct shape *s)
{
    double reach = 0.0;
    for (int i = 0; i < s->params->count; i++)
        for (int axis = 0; axis < 2; axis++) {
            const double p = fabs(s->params->position[i][axis]);
            reach = fmax(reach, floor(s->kernel.support * s->scale + p));
        }
    return reach > WEFT_PATTERN_MAX_RADIUS + 1 ? WEFT_PATTERN_MAX_RADIUS + 1 : (int)reach;
}

// Whether the outermost pixels get nothing.
static bool is_rim_empty(const struct shape *s)
{
    for (int i = 0; i < s->params->count; i++)
        for (int axis = 0; axis < 2; axis++) {
            const double p = s->params->position[i][axis];
            if (weigh(s, -s->radius, p) != 0.0 || weigh(s, s->radius, p) != 0.0)
                return false;
        }
    return true;
}

// Weights not yet of sum 1; returns the sum, *magnitude: of |weights|.
static double fill(const struct shape *s, double *weight, double *magnitude)
{
    const int count = s->params->count;
    double sum = 0.0;
    *magnitude = 0.0;
    for (int y = -s->radius; y <= s->radius; y++)
        for (int x = -s->radius; x <= s->radius; x++)
            for (int i = 0; i < count; i++, weight++) {
                const double *p = s->params->position[i];
                *weight = weigh(s, x, p[0]) * weigh(s, y, p[1]);
                sum += *weight;
                *magnitude += fabs(*weight);
            }
    return sum;
}

// ---- integers
// ------------------------------------------------------------------------------------

// A weight's share of the total, in 2^-20, in which rounding of the weights does not show.
enum { PART_BITS = 20 };

struct part {
    int64_t rest; // of the share, above the integer
    size_t index;
};

static int compare(const void *a, const void *b)
{
    const struct part *x = a, *y = b;
    if (x->rest != y->rest)
        return x->rest < y->rest ? 1 : -1;
    return (x->index > y->index) - (x->index < y->index);
}

// How many weights are not 0, where those are all the same but for rounding; else 0.
static size_t count_equal(const double *weight, size_t count)
{
    size_t equal = 0;
    double first = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (weight[i] == 0.0)
            continue;
        if (equal == 0)
            first = weight[i];
        if (fabs(weight[i] - first) > 1e-12 * fabs(first))
            return 0;
        equal++;
    }
    return equal;
}

// The largest remainders are rounded up, as many as the floors leave.
static bool round_weights(const double *weight, size_t count, int64_t total, int32_t *integer)
{
    struct part *parts = malloc(count * sizeof *parts);
    if (!parts)
        return false;
    int64_t left = total;
    for (size_t i = 0; i < count; i++) {
        const int64_t share = llrint(weight[i] * (double)total * (double)(1 << PART_BITS));
        const int64_t below = (share - (share & ((1 << PART_BITS) - 1))) / (1 << PART_BITS);
        parts[i] = (struct part){share & ((1 << PART_BITS) - 1), i};
        integer[i] = (int32_t)below;
        left -= below;
    }
    qsort(parts, count, sizeof *parts, compare);
    for (size_t i = 0; i < count && left > 0; i++, left--)
        integer[parts[i].index]++;
    free(parts);
    return true;
}

static bool find_integers(int bits, size_t count, struct weft_spread *out)
{
    const size_t equal = count_equal(out->weight, count);
    out->integer = malloc(count * sizeof *out->integer);
    if (!out->integer)
        return false;
    out->total = equal ? (int64_t)equal : INT64_C(1) << bits;
    if (equal)
        for (size_t i = 0; i < count; i++)
            out->integer[i] = out->weight[i] != 0.0;
    else if (!round_weights(out->weight, count, out->total, out->integer))
        return false;
    for (size_t i = 0; i < count; i++)
        out->error += fabs((double)out->integer[i] / (double)out->total - out->weight[i]);
    return true;
}

// ---- the whole
// -----------------------------------------------------------------------------------

static enum weft_result plan(const struct weft_spread_params *p, struct shape *s)
{
    s->params = p;
    s->kernel = p->filter;
    const enum weft_result res =
        weft_weights_resolve(p->log, p->filter_width, &s->kernel, &s->scale);
    if (res != WEFT_OK)
        return res;
    s->radius = find_radius(s);
    while (s->radius > 0 && is_rim_empty(s))
        s->radius--;
    s->side = 2 * s->radius + 1;
    if (s->radius > WEFT_PATTERN_MAX_RADIUS) {
        weft_error(p->log, "kernel %s, %g pixels wide, reaches further than %d pixels",
                   s->kernel.info->name, 2.0 * s->kernel.support * s->scale,
                   WEFT_PATTERN_MAX_RADIUS);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

// Divides by the sum. Returns whether there is one.
static bool normalise(const struct shape *s, size_t count, struct weft_spread *out)
{
    double magnitude;
    const double sum = fill(s, out->weight, &magnitude);
    if (!(sum > 0.0 && sum >= 1e-3 * magnitude && isfinite(magnitude))) {
        weft_error(s->params->log,
                   "the weights of %d samples by kernel %s add up to %g, their magnitudes to %g",
                   s->params->count, s->kernel.info->name, sum, magnitude);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        out->weight[i] /= sum;
        out->negative += out->weight[i] < 0.0 ? -out->weight[i] : 0.0;
    }
    return true;
}

static bool check(const struct weft_spread_params *p)
{
    if (p->count < 1 || p->count > WEFT_PATTERN_MAX || p->bits < 0 || p->bits > 30) {
        weft_error(p->log, "weights of %d samples with %d bits: 1 to %d samples, 0 to 30 bits",
                   p->count, p->bits, WEFT_PATTERN_MAX);
        return false;
    }
    if (!weft_points_check(p->log, p->position, p->count))
        return false;
    for (int i = 0; i < p->count; i++)
        if (!(fabs(p->position[i][0]) <= 0.5 && fabs(p->position[i][1]) <= 0.5)) {
            weft_error(p->log, "sample %d of %d at (%g, %g) is not in its pixel", i + 1, p->count,
                       p->position[i][0], p->position[i][1]);
            return false;
        }
    return true;
}

enum weft_result weft_spread_create(const struct weft_spread_params *params,
                                    struct weft_spread *out)
{
    const struct weft_log *log = params ? params->log : NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct shape s;
    *out = (struct weft_spread){0};
    weft_require(log, params && params->position);
    if (!check(params))
        goto fail;
    res = plan(params, &s);
    if (res != WEFT_OK)
        goto fail;
    const size_t count = (size_t)s.side * (size_t)s.side * (size_t)params->count;
    out->count = params->count;
    out->radius = s.radius;
    res = WEFT_ERR_MEMORY;
    out->weight = malloc(count * sizeof *out->weight);
    if (!out->weight)
        goto memory;
    res = WEFT_ERR_ARGUMENT;
    if (!normalise(&s, count, out))
        goto fail;
    res = WEFT_ERR_MEMORY;
    if (params->bits > 0 && !find_integers(params->bits, count, out))
        goto memory;
    return WEFT_OK;
memory:
    weft_error(log, "no memory for what %d samples count in %d x %d pixels", params->count, s.side,
               s.side);
fail:
    weft_spread_clear(out);
    return res;
}

void weft_spread_clear(struct weft_spread *spread)
{
    if (!spread)
        return;
    free(spread->weight);
    free(spread->integer);
    *spread = (struct weft_spread){0};
}
