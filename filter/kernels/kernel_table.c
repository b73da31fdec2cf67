// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/kernel_table.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"

// The interval between two samples that x is in, on a sample the one to its right.
struct place {
    int64_t index;
    double t;    // 0 to 1 in it
    double rate; // of t by x
};

static struct place find_place(const struct weft_kernel_table *table, double x)
{
    const bool mirrored = !table->whole && x < 0.0;
    const double length = table->whole ? 2.0 * table->support : table->support;
    const double from_start = table->whole ? x + table->support : fabs(x);
    const double at = from_start / length * table->last;
    const double index = mirrored ? ceil(at) - 1.0 : floor(at);
    const double clamped = fmax(0.0, fmin(index, table->last - 1.0));
    return (struct place){
        .index = (int64_t)clamped,
        .t = at - clamped,
        .rate = (mirrored ? -table->last : table->last) / length,
    };
}

// By index; the mirror image is flat at its middle, other ends go on as they come.
static double slope(const struct weft_kernel_table *table, int64_t i)
{
    const double *f = table->samples;
    if (i == 0)
        return table->whole ? f[1] - f[0] : 0.0;
    if (i == (int64_t)table->last)
        return f[i] - f[i - 1];
    return 0.5 * (f[i + 1] - f[i - 1]);
}

static double table_value(const struct weft_kernel *kernel, double x, int n)
{
    const struct weft_kernel_table *table = kernel->info->data;
    if (!(x >= -table->support && x < table->support))
        return 0.0;
    const struct place p = find_place(table, x);
    const double a = table->samples[p.index], b = table->samples[p.index + 1], t = p.t;
    if (table->between == WEFT_KERNEL_BETWEEN_LINEAR)
        return n == 0 ? a + t * (b - a) : p.rate * (b - a);
    const double u = slope(table, p.index), v = slope(table, p.index + 1);
    const double c2 = 3.0 * (b - a) - 2.0 * u - v, c3 = u + v - 2.0 * (b - a);
    return n == 0 ? a + t * (u + t * (c2 + t * c3)) : p.rate * (u + t * (2.0 * c2 + 3.0 * t * c3));
}

static double weight(const struct weft_kernel *kernel, double x)
{
    return table_value(kernel, x, 0);
}

static double derivative(const struct weft_kernel *kernel, double x)
{
    return table_value(kernel, x, 1);
}

static bool interpolates(const struct weft_kernel_table *table)
{
    const struct weft_kernel kernel = {.info = &table->info};
    for (int k = 0; k < table->support; k++)
        if (weight(&kernel, k) != (k == 0) || (k > 0 && weight(&kernel, -k) != 0.0))
            return false;
    return weight(&kernel, -table->support) == 0.0 || table->support != floor(table->support);
}

static const struct weft_kernel_info record = {
    .description = "samples of a kernel",
    .citation = "the user",
    .weight = weight,
    .derivative = derivative,
    .degree = -1,
    .continuity = -1,
};

enum weft_result weft_kernel_table_init(const struct weft_kernel_table_params *params,
                                        struct weft_kernel_table *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_log *log = params->log;
    *out = (struct weft_kernel_table){0};
    weft_require(log, params->samples && params->count >= 2);
    weft_require(log, params->support > 0.0 && params->support <= 0.5 * WEFT_KERNEL_MAX_WIDTH);
    weft_require(log, params->between == WEFT_KERNEL_BETWEEN_LINEAR ||
                          params->between == WEFT_KERNEL_BETWEEN_CUBIC);
    if (params->count > WEFT_KERNEL_TABLE_MAX_SAMPLES) {
        weft_error(log, "kernel table: %zu samples, the limit is %d", params->count,
                   WEFT_KERNEL_TABLE_MAX_SAMPLES);
        return WEFT_ERR_LIMIT;
    }
    for (size_t i = 0; i < params->count; i++) {
        if (!isfinite(params->samples[i])) {
            weft_error(log, "kernel table: sample %zu is not finite", i);
            goto fail;
        }
    }
    out->info = record;
    out->info.name = params->name ? params->name : "table";
    out->info.radius = params->support;
    out->info.data = out;
    out->samples = params->samples;
    out->support = params->support;
    out->last = (double)(params->count - 1);
    out->whole = params->whole;
    out->between = params->between;
    const bool ends_on_zero =
        params->samples[params->count - 1] == 0.0 && (!params->whole || params->samples[0] == 0.0);
    out->info.continuity = ends_on_zero ? 0 : -1;
    out->info.interpolating = interpolates(out);
    res = WEFT_OK;
fail:
    return res;
}
