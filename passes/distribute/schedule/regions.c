// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/schedule/schedule.h"

#include <stdlib.h>

#include "filter/check.h"
#include "passes/distribute/schedule/regions_impl.h"

const char *const weft_schedule_names[] = {"auto", "static", "dynamic", "pull", NULL};

static int32_t least_of(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int64_t divide_up(int64_t a, int64_t b)
{
    return a / b + (a % b != 0);
}

// How many regions a row and a column have. The rows that are tried are all that can be; the best
// have the least product of what regions are too many and of their sides' ratio.
static void choose_counts(const struct weft_regions_params *p, int64_t wanted, int64_t count[2])
{
    const int64_t most[2] = {p->width / p->least > 1 ? p->width / p->least : 1,
                             p->height / p->least > 1 ? p->height / p->least : 1};
    count[0] = most[0], count[1] = most[1];
    double best = 0.0;
    for (int64_t rows = divide_up(wanted, most[0]); rows <= most[1] && rows <= wanted; rows++) {
        const int64_t columns = divide_up(wanted, rows);
        const double ratio =
            ((double)p->width * (double)rows) / ((double)p->height * (double)columns);
        const double cost =
            (double)(rows * columns) / (double)wanted * (ratio < 1.0 ? 1.0 / ratio : ratio);
        if (best == 0.0 || cost < best) {
            best = cost;
            count[0] = columns, count[1] = rows;
        }
    }
}

// size: of the regions, 0 where they are to be of nearly the same size.
static enum weft_result divide(const struct weft_regions_params *p, int64_t count[2],
                               int32_t size[2])
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->region_width >= 0 && p->region_height >= 0);
    weft_require(p->log, p->ranks > 0 && p->granularity > 0 && p->least > 0);
    size[0] = size[1] = 0;
    if (p->region_width || p->region_height) {
        size[0] = p->region_width ? least_of(p->region_width, p->width) : p->width;
        size[1] = p->region_height ? least_of(p->region_height, p->height) : p->height;
        count[0] = divide_up(p->width, size[0]), count[1] = divide_up(p->height, size[1]);
    } else {
        const int64_t wanted = (int64_t)p->ranks * p->granularity;
        choose_counts(p, wanted <= WEFT_REGIONS_MAX ? wanted : WEFT_REGIONS_MAX + 1, count);
    }
    if (count[0] * count[1] > WEFT_REGIONS_MAX) {
        weft_error(p->log, "%lld x %lld regions of a picture of %d x %d: there may be %d",
                   (long long)count[0], (long long)count[1], p->width, p->height, WEFT_REGIONS_MAX);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
fail:
    return res;
}

// count + 1 boundaries: multiples of size, or at i length / count, the nearest, of two the lower.
static void place(int32_t length, int64_t count, int32_t size, int32_t *at, double *exact)
{
    for (int64_t i = 0; i <= count; i++) {
        const int64_t even = (2 * i * length + count - 1) / (2 * count);
        const int64_t place = size && i < count ? i * size : size ? length : even;
        at[i] = (int32_t)place;
        exact[i] = size ? (double)place : (double)i * length / (double)count;
    }
}

bool weft_regions_allocate(struct weft_regions *r)
{
    const size_t y_count = (size_t)r->rows + 1, x_count = (size_t)r->rows * (r->columns + 1u);
    r->x = malloc(x_count * sizeof *r->x);
    r->exact_x = malloc(x_count * sizeof *r->exact_x);
    r->y = malloc(y_count * sizeof *r->y);
    r->exact_y = malloc(y_count * sizeof *r->exact_y);
    return r->x && r->exact_x && r->y && r->exact_y;
}

void weft_regions_release(struct weft_regions *r)
{
    free(r->x), free(r->exact_x);
    free(r->y), free(r->exact_y);
}

static enum weft_result fail(const struct weft_regions_params *p, const int64_t count[2],
                             weft_regions *regions)
{
    weft_error(p->log, "not enough memory for %lld x %lld regions", (long long)count[0],
               (long long)count[1]);
    weft_regions_destroy(&regions);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_regions_create(const struct weft_regions_params *params, weft_regions **out)
{
    struct weft_regions_params p = *params;
    p.ranks = p.ranks ? p.ranks : 1;
    p.granularity = p.granularity ? p.granularity : 8;
    p.least = p.least ? p.least : 1;
    *out = NULL;
    int64_t count[2];
    int32_t size[2];
    enum weft_result res = divide(&p, count, size);
    if (res != WEFT_OK)
        return res;
    weft_regions *r = malloc(sizeof *r);
    if (!r)
        return fail(&p, count, NULL);
    *r = (struct weft_regions){.width = p.width,
                               .height = p.height,
                               .columns = (int32_t)count[0],
                               .rows = (int32_t)count[1]};
    r->least[0] = least_of(p.least, p.width / r->columns);
    r->least[1] = least_of(p.least, p.height / r->rows);
    if (!weft_regions_allocate(r))
        return fail(&p, count, r);
    place(p.height, count[1], size[1], r->y, r->exact_y);
    for (int64_t row = 0; row < count[1]; row++) {
        const int64_t first = row * (count[0] + 1);
        place(p.width, count[0], size[0], r->x + first, r->exact_x + first);
    }
    *out = r;
    return WEFT_OK;
}

void weft_regions_destroy(weft_regions **regions)
{
    weft_regions *r = *regions;
    if (r) {
        weft_regions_release(r);
        free(r);
    }
    *regions = NULL;
}

int64_t weft_regions_count(const weft_regions *regions)
{
    return (int64_t)regions->rows * regions->columns;
}

struct weft_rectangle weft_regions_get(const weft_regions *regions, int64_t index)
{
    if (index < 0 || index >= weft_regions_count(regions))
        return (struct weft_rectangle){0, 0, -1, -1};
    const int64_t row = index / regions->columns;
    const int32_t *y = regions->y + row;
    const int32_t *x = regions->x + row * (regions->columns + 1) + index % regions->columns;
    return (struct weft_rectangle){x[0], y[0], x[1] - x[0], y[1] - y[0]};
}
