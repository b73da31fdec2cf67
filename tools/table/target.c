// SPDX-License-Identifier: BSD-3-Clause
// weft table --target-error: the smallest resolution at which eps_h is small enough.
#include <math.h>
#include <stdlib.h>

#include "tools/table/job.h"

// Resolutions are tried up to the largest of --resolutions, else to this.
enum { DEFAULT_LIMIT = 1024, COARSER = 8 };

struct search {
    const struct table_job *job;
    double target;
    const struct weft_progress *all;
    double done; // fraction of the searches
};

static bool report_search(void *priv, double fraction)
{
    (void)fraction;
    const struct search *search = priv;
    return search->all->report(search->all->priv, search->done);
}

// A coarser grid of locations that already has a larger error saves most of the work.
static enum weft_result reaches(struct search *search, struct table_cell *cell, int samples,
                                bool *out)
{
    const struct weft_progress progress = {.report = report_search, .priv = search};
    const int locations = table_locations(search->job, cell->dims);
    const int grids[] = {locations / COARSER, locations / 2, locations};
    cell->samples = samples;
    *out = true;
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < 3 && res == WEFT_OK && *out; i++) {
        if (grids[i] < 1)
            continue;
        res = table_cell_compute(search->job, cell, grids[i], &progress);
        *out = cell->error.maximum <= search->target;
    }
    return res;
}

// By doubling, then by bisection below the first power of two that reaches it.
static enum weft_result find_smallest(struct search *search, int limit, struct table_cell *cell)
{
    enum weft_result res = WEFT_OK;
    bool reached = false;
    int failed = 0, samples = 1;
    struct table_cell best = *cell;
    while (res == WEFT_OK) {
        res = reaches(search, cell, samples, &reached);
        if (reached || samples == limit)
            break;
        failed = samples;
        samples = samples > limit / 2 ? limit : 2 * samples;
    }
    best = *cell;
    best.missed = !reached;
    while (res == WEFT_OK && reached && best.samples - failed > 1) {
        bool smaller;
        const int middle = failed + (best.samples - failed) / 2;
        res = reaches(search, cell, middle, &smaller);
        if (smaller)
            best = *cell;
        else
            failed = middle;
    }
    *cell = best;
    return res;
}

static void mark_least(struct table_cell *cell, int count, int dims)
{
    int least = -1;
    double bits = INFINITY;
    for (int i = 0; i < count; i++) {
        double size = pow(cell[i].samples, dims) * cell[i].bits;
        if (!cell[i].missed && size < bits) {
            bits = size;
            least = i;
        }
    }
    if (least >= 0)
        cell[least].least = true;
}

static int find_limit(const struct table_job *job)
{
    int limit = job->option[TABLE_RESOLUTIONS].given ? 1 : DEFAULT_LIMIT;
    for (int i = 0; job->option[TABLE_RESOLUTIONS].given && i < job->sample_count; i++)
        limit = job->samples[i] > limit ? job->samples[i] : limit;
    return limit;
}

// The cells of one kernel, dimension and look-up, one for each number of bits.
static enum weft_result search_bits(struct search *search, struct table_job *job, int limit,
                                    int total, struct table_cell start)
{
    enum weft_result res = WEFT_OK;
    struct table_cell *first = &job->cell[job->cell_count];
    for (int b = 0; b < job->bit_count && res == WEFT_OK; b++) {
        struct table_cell *cell = &job->cell[job->cell_count++];
        *cell = start;
        cell->bits = job->bits[b];
        search->done = (double)(job->cell_count - 1) / total;
        res = find_smallest(search, limit, cell);
    }
    mark_least(first, job->bit_count, start.dims);
    return res;
}

enum weft_result table_target_compute(struct table_job *job)
{
    const int total = job->kernel_count * job->dim_count * job->lookup_count * job->bit_count;
    enum weft_result res = WEFT_OK;
    struct search search = {
        .job = job,
        .target = job->option[TABLE_TARGET_ERROR].number[0],
        .all = report_progress("searching resolutions"),
    };
    job->cell = calloc((size_t)total, sizeof *job->cell);
    if (!job->cell) {
        report_error("out of memory for %d cells", total);
        return WEFT_ERR_MEMORY;
    }
    for (int k = 0; k < job->kernel_count && res == WEFT_OK; k++)
        for (int d = 0; d < job->dim_count && res == WEFT_OK; d++)
            for (int l = 0; l < job->lookup_count && res == WEFT_OK; l++)
                res = search_bits(&search, job, find_limit(job), total,
                                  (struct table_cell){.kernel = k,
                                                      .dims = job->dims[d],
                                                      .lookup = job->lookup[l],
                                                      .published = NAN});
    return res;
}
