// SPDX-License-Identifier: BSD-3-Clause
// Boundaries by load (Lin et al. 1997, section 3.1.2; Whitman 1992). The load is a density that is
// constant in each region; along one axis its integral is divided into equal parts.
#include <math.h>
#include <stdlib.h>

#include "passes/distribute/schedule/regions_impl.h"
#include "passes/distribute/schedule/schedule.h"

// The share of the mean density that is added everywhere, so that there is a place for every part
// of the integral: where nothing was to be done regions are as large as they can be, not endless.
static const double floor_share = 1.0 / 1024.0;

// From `at` to where the next one begins. `order` makes equal places a fixed sequence.
struct piece {
    int32_t at, order;
    double density;
};

static int compare_pieces(const void *a, const void *b)
{
    const struct piece *p = a, *q = b;
    return p->at != q->at ? (p->at < q->at ? -1 : 1)
                          : (p->order > q->order) - (p->order < q->order);
}

// Where the integral over `count` pieces, ended by pieces[count].at, is i / parts of all of it,
// i = 0 to parts. Returns false where there is no load at all.
static bool divide_evenly(struct piece *pieces, size_t count, int32_t parts, double *target)
{
    double load = 0.0, sum = 0.0, total = 0.0;
    for (size_t i = 0; i < count; i++)
        load += pieces[i].density * (pieces[i + 1].at - pieces[i].at);
    const double least = load / pieces[count].at * floor_share;
    if (!(least > 0.0))
        return false;
    for (size_t i = 0; i < count; i++) {
        pieces[i].density = (pieces[i].density > 0.0 ? pieces[i].density : 0.0) + least;
        total += pieces[i].density * (pieces[i + 1].at - pieces[i].at);
    }
    size_t at = 0;
    for (int32_t k = 1; k < parts; k++) {
        const double wanted = total * k / parts;
        double part;
        while (sum + (part = pieces[at].density * (pieces[at + 1].at - pieces[at].at)) < wanted &&
               at + 1 < count)
            sum += part, at++;
        const double place = pieces[at].at + (wanted - sum) / pieces[at].density;
        target[k] = place < pieces[at + 1].at ? place : pieces[at + 1].at;
    }
    target[0] = 0.0, target[parts] = pieces[count].at;
    return true;
}

// Boundaries at whole pixels, none nearer to the next than `least`. Halves go down, and so do
// places that would be halves but for rounding: an even division stays where it was put.
static void settle(int32_t parts, int32_t least, int32_t *at, double *exact)
{
    const int32_t length = (int32_t)exact[parts];
    at[0] = 0, at[parts] = length;
    for (int32_t k = 1; k < parts; k++) {
        const int32_t nearest = (int32_t)floor(exact[k] + 0.5 - 0x1p-10);
        at[k] = nearest > at[k - 1] + least ? nearest : at[k - 1] + least;
    }
    for (int32_t k = parts - 1; k > 0; k--) {
        if (at[k] > at[k + 1] - least)
            at[k] = at[k + 1] - least;
        if (fabs(at[k] - exact[k]) > 0.75)
            exact[k] = at[k];
    }
}

// To target, but for the share `keep`, from where it was.
static void approach(int32_t parts, const double *old, double keep, double *exact)
{
    for (int32_t k = 0; k <= parts; k++)
        exact[k] = keep * old[k] + (1.0 - keep) * exact[k];
}

static void move_rows(const struct weft_regions *old, const double *seconds, double unit,
                      double keep, struct piece *pieces, struct weft_regions *out)
{
    for (int32_t r = 0; r < old->rows; r++) {
        double sum = 0.0;
        for (int32_t c = 0; c < old->columns; c++)
            sum += seconds[(int64_t)r * old->columns + c] / unit;
        pieces[r] = (struct piece){old->y[r], r, sum / (old->y[r + 1] - old->y[r])};
    }
    pieces[old->rows].at = old->height;
    if (divide_evenly(pieces, (size_t)old->rows, old->rows, out->exact_y))
        approach(old->rows, old->exact_y, keep, out->exact_y);
    else
        for (int32_t r = 0; r <= old->rows; r++)
            out->exact_y[r] = old->exact_y[r];
    settle(old->rows, old->least[1], out->y, out->exact_y);
}

// What the old rows that a row from y0 to y1 overlaps have there: the density's steps, and from
// them the density. *first: the first old row that can overlap. Returns how many pieces.
static size_t gather(const struct weft_regions *old, const double *seconds, double unit, int32_t y0,
                     int32_t y1, int32_t *first, struct piece *pieces)
{
    size_t count = 0;
    while (old->y[*first + 1] <= y0)
        (*first)++;
    for (int32_t r = *first; r < old->rows && old->y[r] < y1; r++) {
        const int32_t low = old->y[r] > y0 ? old->y[r] : y0;
        const int32_t high = old->y[r + 1] < y1 ? old->y[r + 1] : y1;
        const double share = (double)(high - low) / (old->y[r + 1] - old->y[r]);
        const int32_t *x = old->x + (int64_t)r * (old->columns + 1);
        double before = 0.0;
        for (int32_t c = 0; c < old->columns; c++) {
            const double density =
                seconds[(int64_t)r * old->columns + c] / unit * share / (x[c + 1] - x[c]);
            pieces[count] = (struct piece){x[c], (int32_t)count, density - before};
            before = density;
            count++;
        }
    }
    qsort(pieces, count, sizeof *pieces, compare_pieces);
    for (size_t i = 1; i < count; i++)
        pieces[i].density += pieces[i - 1].density;
    pieces[count].at = old->width;
    return count;
}

static void move_columns(const struct weft_regions *old, const double *seconds, double unit,
                         double keep, struct piece *pieces, struct weft_regions *out)
{
    int32_t first = 0;
    for (int32_t r = 0; r < old->rows; r++) {
        const int64_t row = (int64_t)r * (old->columns + 1);
        const size_t count = gather(old, seconds, unit, out->y[r], out->y[r + 1], &first, pieces);
        if (divide_evenly(pieces, count, old->columns, out->exact_x + row))
            approach(old->columns, old->exact_x + row, keep, out->exact_x + row);
        else
            for (int32_t c = 0; c <= old->columns; c++)
                out->exact_x[row + c] = old->exact_x[row + c];
        settle(old->columns, old->least[0], out->x + row, out->exact_x + row);
    }
}

enum weft_result weft_regions_balance(weft_regions *regions, const double *seconds, double keep)
{
    const int64_t count = weft_regions_count(regions);
    double largest = 0.0;
    if (!(keep >= 0.0 && keep < 1.0))
        return WEFT_ERR_ARGUMENT;
    for (int64_t i = 0; i < count; i++) {
        if (!(seconds[i] >= 0.0) || isinf(seconds[i]))
            return WEFT_ERR_ARGUMENT;
        largest = fmax(largest, seconds[i]);
    }
    if (largest == 0.0)
        return WEFT_OK;
    // A row may overlap all the old ones.
    struct piece *pieces = malloc(((size_t)count + 1) * sizeof *pieces);
    struct weft_regions next = *regions;
    if (!weft_regions_allocate(&next) || !pieces) {
        weft_regions_release(&next);
        free(pieces);
        return WEFT_ERR_MEMORY;
    }
    move_rows(regions, seconds, largest, keep, pieces, &next);
    move_columns(regions, seconds, largest, keep, pieces, &next);
    weft_regions_release(regions);
    *regions = next;
    free(pieces);
    return WEFT_OK;
}
