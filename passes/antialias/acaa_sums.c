// SPDX-License-Identifier: BSD-3-Clause
// What was added up: the room that sums need, the check of all weights, and values.
#include <math.h>

#include "filter/check.h"
#include "passes/accumulate/sums/wide.h"
#include "passes/antialias/acaa_impl.h"

static size_t pixel_count(const struct weft_acaa *a)
{
    return weft_part_pixels(&a->part);
}

// ---- room ---------------------------------------------------------------------------------------

// The scale is a power of two, so that multiplying by it rounds nothing. Of one word sums stay
// below 2^30 in magnitude; of two, colours do, and sums below 2^61.
bool weft_acaa_set_range(struct weft_acaa *a, double range, double weight)
{
    enum { LARGEST_SCALE = 100 }; // a float's exponents go further
    const struct weft_acaa_plan *plan = &a->plan;
    const double sum = range * (double)plan->total * plan->magnitude * weight;
    double log2_scale = plan->layers.sum_words == 1
                            ? floor(log2(0x1p30 / sum))
                            : fmin(floor(log2(0x1p30 / range)), floor(log2(0x1p61 / sum)));
    log2_scale = fmin(log2_scale, LARGEST_SCALE);
    a->range = range;
    a->weight = weight;
    a->scale_log2 = (int)log2_scale;
    return log2_scale >= -126.0;
}

// ---- words --------------------------------------------------------------------------------------

static int64_t read_words(const struct weft_acaa *a, int layer, int words, size_t pixel)
{
    const uint32_t *low = a->words + (size_t)layer * pixel_count(a) + pixel;
    if (words == 1)
        return (int32_t)*low;
    return (int64_t)(((uint64_t)low[pixel_count(a)] << 32) | *low);
}

struct weights {
    int64_t surfaces, background;
};

static struct weights read_weights(const struct weft_acaa *a, size_t pixel)
{
    const struct weft_acaa_layers *l = &a->plan.layers;
    if (l->weight_shift) {
        const uint32_t both = a->words[(size_t)l->weight * pixel_count(a) + pixel];
        return (struct weights){both >> l->weight_shift, both & ((1u << l->weight_shift) - 1u)};
    }
    return (struct weights){read_words(a, l->weight, l->weight_words, pixel),
                            read_words(a, l->background, 1, pixel)};
}

// The weight that shows the background: of its own samples, as far as nothing was cut off for
// surfaces, and what nobody counted.
static int64_t background_weight(const struct weft_acaa *a, struct weights w)
{
    const int64_t total = a->plan.total, missing = total - w.surfaces - w.background;
    if (missing >= 0)
        return w.background + missing;
    if (a->params.coincident != WEFT_COINCIDENT_ALPHA)
        return w.background;
    return w.surfaces < total ? total - w.surfaces : 0;
}

// ---- the check ----------------------------------------------------------------------------------

static void note_weight(struct weft_acaa_report *r, int64_t weight, int64_t total, int32_t x,
                        int32_t y)
{
    int64_t *count = weight < total ? &r->less : &r->more;
    int32_t *first = weight < total ? r->first_less : r->first_more;
    if (weight == total)
        return;
    if (*count == 0) {
        first[0] = x;
        first[1] = y;
    }
    *count += 1;
    r->largest = fmax(r->largest, fabs((double)(weight - total)) / (double)total);
}

double weft_acaa_check(struct weft_acaa *a)
{
    struct weft_acaa_report *r = &a->report;
    const int64_t total = a->plan.total;
    int64_t most = total;
    r->less = r->more = 0;
    r->largest = 0.0;
    for (int i = 0; i < 2; i++)
        r->first_less[i] = r->first_more[i] = -1;
    for (int32_t y = 0; y < a->part.height; y++)
        for (int32_t x = 0; x < a->part.width; x++) {
            const struct weights w = read_weights(a, (size_t)y * (size_t)a->part.width + (size_t)x);
            note_weight(r, w.surfaces + w.background, total, a->part.x + x, a->part.y + y);
            most = w.surfaces + w.background > most ? w.surfaces + w.background : most;
        }
    return a->params.coincident == WEFT_COINCIDENT_NONE ? (double)most / (double)total : 1.0;
}

float weft_acaa_weight(const struct weft_acaa *a, size_t pixel)
{
    const struct weights w = read_weights(a, pixel);
    return (float)((double)(w.surfaces + w.background) / (double)a->plan.total);
}

// ---- values -------------------------------------------------------------------------------------

enum { ALPHA = 3 };

static float float_value(const struct weft_acaa *a, int channel, size_t pixel, int64_t background)
{
    union {
        uint32_t bits;
        float value;
    } sum = {a->words[(size_t)channel * pixel_count(a) + pixel]};
    return (float)(((double)sum.value + (double)background * a->params.background[channel]) /
                   (double)a->plan.total);
}

static void read_float_row(const struct weft_acaa *a, int channel, size_t first, float *out)
{
    for (size_t x = 0; x < (size_t)a->part.width; x++) {
        const int64_t background = background_weight(a, read_weights(a, first + x));
        out[x] = channel == ALPHA ? (float)(1.0 - (double)background / (double)a->plan.total *
                                                      (1.0 - a->params.background[ALPHA]))
                                  : float_value(a, channel, first + x, background);
    }
}

// Rounded once: what a division of doubles has is exact where a total is a power of two and the
// sum has no more digits than a double; mostly it tells elsewhere, too.
static float divide(weft_wide sum, int64_t total)
{
    const weft_wide exact = (weft_wide)1 << 53;
    if ((total & (total - 1)) == 0 && sum >= -exact && sum <= exact)
        return (float)((double)(int64_t)sum / (double)total) + 0.0f; // no negative zero
    const double quotient = (double)sum / (double)total;
    float value;
    return weft_wide_is_near(quotient, &value) ? value : weft_wide_quotient(sum, total);
}

// As integers the background counts as a colour does; alpha is that of opaque surfaces but where
// it shows.
static void read_integer_row(const struct weft_acaa *a, int channel, size_t first, float *out)
{
    const int64_t total = a->plan.total, one = llrint(ldexp(1.0, a->scale_log2));
    const int64_t colour = llrint(ldexp(a->params.background[channel], a->scale_log2));
    const int words = a->plan.layers.sum_words;
    const float unit = ldexpf(1.0f, -a->scale_log2);
    for (size_t x = 0; x < (size_t)a->part.width; x++) {
        const int64_t background = background_weight(a, read_weights(a, first + x));
        const weft_wide sum = channel == ALPHA ? (weft_wide)(total - background) * one
                                               : read_words(a, words * channel, words, first + x);
        out[x] = divide(sum + (weft_wide)background * colour, total) * unit;
    }
}

void weft_acaa_read_row(const struct weft_acaa *a, int channel, int32_t y, float *out)
{
    const size_t first = (size_t)y * (size_t)a->part.width;
    if (a->params.sums == WEFT_ACAA_FLOAT)
        read_float_row(a, channel, first, out);
    else
        read_integer_row(a, channel, first, out);
}
