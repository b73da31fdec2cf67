// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/sampler_rows.h"

#include <math.h>
#include <stdio.h>

enum { PLACE_POINTS = WEFT_SAMPLER_POINTS * WEFT_SAMPLER_PARTS };

static const int spacing_bits[WEFT_SAMPLER_SPACINGS] = {6, 8, 9, 10, 12, 16, 20};

// Both directions, at both ends and in the middle.
static int place_at(int size, int number)
{
    const int places[WEFT_SAMPLER_PLACES] = {0, 1, size / 2, size / 2 + 1, size - 3, size - 2};
    return places[number];
}

static int place_row(int place, int part)
{
    return 1 + place * WEFT_SAMPLER_PARTS + part;
}

static int spacing_row(int spacing)
{
    return place_row(WEFT_SAMPLER_PLACES, spacing);
}

// Points of a row of spacings: they stay within half a texel.
static int spacing_points(int spacing)
{
    const int points = 1 << (spacing_bits[spacing] - 1);
    return points < WEFT_SAMPLER_POINTS ? points : WEFT_SAMPLER_POINTS;
}

void weft_sampler_rows_set(int size, struct weft_sampler_row out[WEFT_SAMPLER_ROWS])
{
    out[0] = (struct weft_sampler_row){0.5f, 1.0f};
    for (int place = 0; place < WEFT_SAMPLER_PLACES; place++)
        for (int part = 0; part < WEFT_SAMPLER_PARTS; part++)
            out[place_row(place, part)] = (struct weft_sampler_row){
                (float)place_at(size, place) + 0.5f + (float)part / WEFT_SAMPLER_PARTS,
                1.0f / PLACE_POINTS};
    for (int spacing = 0; spacing < WEFT_SAMPLER_SPACINGS; spacing++)
        out[spacing_row(spacing)] =
            (struct weft_sampler_row){0.75f, (float)ldexp(1.0, -spacing_bits[spacing])};
}

// The fraction that was used at point k of a place: texels rise from even numbers and fall from odd
// ones. The last point is the next texel's centre, which has been checked.
static double fraction_at(const struct weft_sampler_found *f, int place, int k)
{
    if (k == PLACE_POINTS)
        return 1.0;
    const double value = f->contrast[(size_t)place_row(place, 0) * WEFT_SAMPLER_POINTS + (size_t)k];
    return place_at(f->size, place) % 2 ? 1.0 - value : value;
}

static bool check_centres(const struct weft_sampler_found *f, char *why, size_t why_size)
{
    for (int i = 0; i < f->size; i++) {
        if (f->contrast[i] == (float)(i % 2))
            continue;
        snprintf(why, why_size, "texel %d of %d is %d, and %.9g at its centre", i, f->size, i % 2,
                 f->contrast[i]);
        return false;
    }
    return true;
}

// The spacing of the finest row whose points all gave a greater fraction than the one before;
// INFINITY where none did.
static double find_step(const struct weft_sampler_found *f)
{
    double step = INFINITY;
    for (int spacing = 0; spacing < WEFT_SAMPLER_SPACINGS; spacing++) {
        const float *row = f->contrast + (size_t)spacing_row(spacing) * WEFT_SAMPLER_POINTS;
        bool rising = true;
        for (int i = 1; i < spacing_points(spacing); i++)
            rising = rising && row[i] > row[i - 1];
        if (rising)
            step = ldexp(1.0, -spacing_bits[spacing]);
    }
    return step;
}

// Both bounds of a place. false: fractions fall, or are none.
static bool find_fraction(const struct weft_sampler_found *f, int place, double step, double *out,
                          char *why, size_t why_size)
{
    double between = 0.0, at = 0.0;
    for (int k = 0; k < PLACE_POINTS; k++) {
        const double here = (double)k / PLACE_POINTS, next = (k + 1.0) / PLACE_POINTS;
        const double low = fraction_at(f, place, k), high = fraction_at(f, place, k + 1);
        if (!(low <= high && low >= 0.0 && high <= 1.0)) {
            snprintf(why, why_size,
                     "between texels %d and %d of %d the fraction goes from %g to %g",
                     place_at(f->size, place), place_at(f->size, place) + 1, f->size, low, high);
            return false;
        }
        at = fmax(at, fabs(low - here));
        between = fmax(between, fmax(next - low, high - here));
    }
    *out = fmax(*out, fmin(between, at + step));
    return true;
}

// What values are rounded by, over all places; between two points they change by next to nothing.
static double find_rounding(const struct weft_sampler_found *f)
{
    const double difference = 1.0 - f->low;
    double largest = 0.0;
    for (int place = 0; place < WEFT_SAMPLER_PLACES; place++) {
        const float *value = f->code + (size_t)place_row(place, 0) * WEFT_SAMPLER_POINTS;
        for (int k = 0; k < PLACE_POINTS; k++) {
            const double x = (double)k / PLACE_POINTS;
            const double exact =
                place_at(f->size, place) % 2 ? 1.0 - x * difference : f->low + x * difference;
            largest = fmax(largest, fabs(value[k] - exact));
        }
    }
    return largest + difference / PLACE_POINTS;
}

bool weft_sampler_rows_judge(const struct weft_sampler_found *found, struct weft_sampler *out,
                             char *why, size_t why_size)
{
    const double step = find_step(found);
    if (!check_centres(found, why, why_size))
        return false;
    for (int place = 0; place < WEFT_SAMPLER_PLACES; place++)
        if (!find_fraction(found, place, step, &out->fraction, why, why_size))
            return false;
    out->rounding = fmax(out->rounding, find_rounding(found));
    out->max_size = found->size;
    return true;
}
