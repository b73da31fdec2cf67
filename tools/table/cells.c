// SPDX-License-Identifier: BSD-3-Clause
// The cells of `weft table`: kernels, scaled as was asked, and their errors.
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/table/job.h"

// ---- the scale ----------------------------------------------------------------------------------

static double scaled_weight(const struct weft_kernel *kernel, double x)
{
    const struct table_scaled *scaled = kernel->info->data;
    return scaled->axis_factor * weft_kernel_weight(scaled->plain, x);
}

// Kernels have their extremes at multiples of these steps or close to them.
static double largest_weight(const struct weft_kernel *kernel)
{
    double largest = 0.0;
    for (int i = -4096; i <= 4096; i++)
        largest = fmax(largest, fabs(weft_kernel_weight(kernel, kernel->support * i / 4096)));
    for (int i = -WEFT_KERNEL_MAX_WIDTH; i <= WEFT_KERNEL_MAX_WIDTH; i++)
        largest = fmax(largest, fabs(weft_kernel_weight(kernel, 0.5 * i)));
    return largest;
}

static enum weft_result find_scale(const struct option_value *value, double largest, double *out)
{
    const char *text = value->text;
    char *end;
    *out = 1.0;
    if (!value->given)
        return WEFT_OK;
    if (strcmp(text, "full") == 0) {
        *out = 1.0 / largest;
    } else if (strcmp(text, "power-of-two") == 0) {
        *out = exp2(floor(-log2(largest)));
    } else if (*out = strtod(text, &end),
               *end || isspace((unsigned char)*text) || !(*out > 0.0) || !isfinite(*out)) {
        report_error("--scale %s: not a number above 0, full or power-of-two", text);
        return WEFT_ERR_ARGUMENT;
    } else if (*out * largest > 1.0 + 1e-12) {
        report_error("--scale %s: the largest weight would be %.6g, texels hold up to 1", text,
                     *out * largest);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result set_scale(const struct table_job *job, struct table_kernel *kernel,
                                  int dims)
{
    struct table_scaled *scaled = &kernel->scaled[dims - 1];
    scaled->kernel = kernel->kernel;
    scaled->plain = &kernel->kernel;
    double largest = pow(largest_weight(&kernel->kernel), dims);
    enum weft_result res = find_scale(&job->option[TABLE_SCALE], largest, &scaled->factor);
    if (res != WEFT_OK || scaled->factor == 1.0)
        return res;
    scaled->axis_factor = pow(scaled->factor, 1.0 / dims);
    scaled->info = (struct weft_kernel_info){
        .name = kernel->text,
        .description = "scaled",
        .radius = kernel->kernel.support,
        .weight = scaled_weight,
        .data = scaled,
        .degree = -1,
        .continuity = kernel->kernel.continuity,
    };
    res = weft_kernel_create(report_log(), &scaled->info, NULL, &scaled->kernel);
    scaled->kernel.radial = kernel->kernel.radial;
    return res;
}

enum weft_result table_set_scales(struct table_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int k = 0; k < job->kernel_count; k++)
        for (int d = 0; d < job->dim_count && res == WEFT_OK; d++)
            res = set_scale(job, &job->kernel[k], job->dims[d]);
    return res;
}

// ---- the cells ----------------------------------------------------------------------------------

int table_locations(const struct table_job *job, int dims)
{
    return job->locations ? job->locations : dims > 2 ? 256 : 1024;
}

enum weft_result table_cell_compute(const struct table_job *job, struct table_cell *cell,
                                    int locations, const struct weft_progress *progress)
{
    const struct table_scaled *scaled = &job->kernel[cell->kernel].scaled[cell->dims - 1];
    const struct weft_error_kernel_params params = {
        .kernel = scaled->kernel,
        .dims = cell->dims,
        .samples = cell->samples,
        .bits = cell->bits,
        .rounding = job->rounding,
        .lookup = cell->lookup,
        .convention = job->convention,
        .locations = locations,
        .log = report_log(),
        .progress = progress,
    };
    struct weft_error_kernel *e = &cell->error;
    enum weft_result res = weft_error_kernel_compute(&params, e);
    double *errors[] = {&e->maximum,       &e->mean,          &e->rms,        &e->median,
                        &e->percentile_90, &e->percentile_99, &e->signed_min, &e->signed_max,
                        &e->signed_mean,   &e->single};
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
        *errors[i] /= scaled->factor;
    return res;
}

// What the paper prints in the seven cells that its recovered conventions do not give.
static double published(const struct table_job *job, const struct table_cell *cell)
{
    static const struct {
        const char *kernel;
        int dims, samples;
        double value;
    } cells[] = {
        {"bspline", 2, 64, 3.3165},
        {"bspline", 3, 16, 7.2346},
        {"bspline", 3, 32, 5.4758},
        {"bspline", 3, 64, 7.0751},
        {"bspline", 3, 128, 4.1687},
        {"catmull-rom", 3, 16, 19.1470},
        {"kaiser-sinc:2,5.36", 3, 64, 12.0028},
    };
    const bool same = job->convention == WEFT_ERROR_WSCG2003 && job->rounding == WEFT_FIXED_ROUND &&
                      cell->bits == 8 && cell->lookup == WEFT_ERROR_LINEAR &&
                      table_locations(job, cell->dims) == (cell->dims > 2 ? 256 : 1024) &&
                      job->kernel[cell->kernel].scaled[cell->dims - 1].factor == 1.0;
    for (size_t i = 0; same && i < sizeof cells / sizeof *cells; i++) {
        if (strcmp(job->kernel[cell->kernel].text, cells[i].kernel) == 0 &&
            cell->dims == cells[i].dims && cell->samples == cells[i].samples)
            return cells[i].value;
    }
    return NAN;
}

// Work before, in and after a cell, for a progress over all of them.
struct share {
    double start, size;
    const struct weft_progress *all;
};

static bool report_share(void *priv, double fraction)
{
    const struct share *share = priv;
    return share->all->report(share->all->priv, share->start + share->size * fraction);
}

static double cell_work(const struct table_job *job, const struct table_cell *cell)
{
    const double texels = cell->lookup == WEFT_ERROR_LINEAR ? 2.0 : 1.0;
    const double locations = fmin(cell->samples, 0.5 * table_locations(job, cell->dims));
    return pow(job->kernel[cell->kernel].kernel.width * texels *
                   (cell->lookup == WEFT_ERROR_LINEAR ? 0.5 * table_locations(job, cell->dims)
                                                      : locations),
               cell->dims);
}

static enum weft_result create_cells(struct table_job *job)
{
    const int count = job->kernel_count * job->sample_count * job->dim_count * job->lookup_count;
    job->cell = calloc((size_t)count, sizeof *job->cell);
    if (!job->cell) {
        report_error("out of memory for %d cells", count);
        return WEFT_ERR_MEMORY;
    }
    for (int k = 0; k < job->kernel_count; k++)
        for (int m = 0; m < job->sample_count; m++)
            for (int d = 0; d < job->dim_count; d++)
                for (int l = 0; l < job->lookup_count; l++)
                    job->cell[job->cell_count++] = (struct table_cell){
                        .kernel = k,
                        .samples = job->samples[m],
                        .dims = job->dims[d],
                        .bits = job->bits[0],
                        .lookup = job->lookup[l],
                    };
    return WEFT_OK;
}

enum weft_result table_cells_compute(struct table_job *job)
{
    enum weft_result res = create_cells(job);
    double total = 0.0, start = report_now_seconds();
    for (int i = 0; i < job->cell_count; i++)
        total += cell_work(job, &job->cell[i]);
    struct share share = {.all = report_progress("computing the table")};
    const struct weft_progress progress = {.report = report_share, .priv = &share};
    for (int i = 0; i < job->cell_count && res == WEFT_OK; i++) {
        struct table_cell *cell = &job->cell[i];
        share.size = cell_work(job, cell) / total;
        res = table_cell_compute(job, cell, table_locations(job, cell->dims), &progress);
        cell->published = published(job, cell);
        share.start += share.size;
    }
    report_note("%d cells in %.3f s", job->cell_count, report_now_seconds() - start);
    return res;
}
