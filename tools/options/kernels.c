// SPDX-License-Identifier: BSD-3-Clause
#include "tools/options/kernels.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"

enum { SUM_STEPS = 4096, KERNELS_NAME = 256 };

// Whether the sum of the weights stays clear of zero, on one side of it.
static bool can_be_normalised(const struct weft_kernel *kernel, double *at)
{
    struct weft_kernel plain = *kernel;
    plain.normalised = false;
    double side = 0.0;
    for (int i = 0; i < SUM_STEPS; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0, gain = 0.0;
        *at = (double)i / SUM_STEPS;
        weft_kernel_weights(&plain, *at, weights);
        for (int j = 0; j < plain.width; j++) {
            sum += weights[j];
            gain += fabs(weights[j]);
        }
        if (!(fabs(sum) > 1e-9 * gain) || sum * side < 0.0)
            return false;
        side = sum;
    }
    return true;
}

// What another program's name is here, once.
static void tell_translation(const char *text)
{
    static char told[KERNELS_NAME];
    char name[KERNELS_NAME];
    const char *sentence = weft_kernel_translate(text, name, sizeof name);
    if (!sentence || strcmp(told, name) == 0)
        return;
    snprintf(told, sizeof told, "%s", name);
    report_tell("kernel '%s' is %s here: %s", text, name, sentence);
}

enum weft_result kernels_load(const char *text, struct weft_kernel *out, weft_kernel_file **file)
{
    double at;
    enum weft_result res = weft_kernel_load(report_log(), text, out, file);
    if (res == WEFT_OK)
        tell_translation(text);
    if (res != WEFT_OK || !out->normalised || can_be_normalised(out, &at))
        return res;
    report_error("kernel %s: the weights at fraction %g add up to 0, or to less than at others: "
                 "they cannot be divided by their sum",
                 text, at);
    res = *file ? WEFT_ERR_FORMAT : WEFT_ERR_ARGUMENT;
    weft_kernel_file_destroy(file);
    return res;
}

enum weft_result kernels_load_filter(const char *text, int axes, struct weft_kernel *out,
                                     weft_kernel_file **file)
{
    const enum weft_result res = kernels_load(text, out, file);
    if (res != WEFT_OK || !out->info->derivation)
        return res;
    report_error("kernel %s along %d axes at once is the mixed derivative of order %d, not a slope "
                 "along one: use %s for the values, and for derivatives weft slice --quantity "
                 "gradient, hessian, ... or weft plan --derivative x, xy, ...",
                 text, axes, axes * out->info->derivation, out->info->primitive->name);
    weft_kernel_file_destroy(file);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result kernels_read_filter(const struct option_value *filter,
                                     const struct option_value *width, struct weft_kernel *kernel,
                                     weft_kernel_file **file, double *pixels)
{
    const enum weft_result res =
        filter->given ? kernels_load_filter(filter->text, 2, kernel, file) : WEFT_OK;
    return res == WEFT_OK ? options_read_number(width, "kernel-width", 0x1p-20, 0x1p20,
                                                "not a width in pixels, from 2^-20 to 2^20", pixels)
                          : res;
}

const char *const kernels_normalise_choices[] = {"on", "off", NULL};

static bool has_sums(const struct weft_kernel *kernel, int dims)
{
    double at;
    if (!weft_kernel_is_radial(kernel, dims))
        return can_be_normalised(kernel, &at);
    const struct weft_kernel_sums sums = weft_kernel_radial_sums(kernel, dims);
    return sums.least > 0.0 || sums.largest < 0.0;
}

enum weft_result kernels_normalise(const struct option_value *option, int dims,
                                   const weft_kernel_file *file, struct weft_kernel *kernel)
{
    const bool on = option->given && option->integer[0] == 0;
    if (kernel->unit_sum || !(option->given ? on : !file))
        return WEFT_OK;
    if (has_sums(kernel, dims))
        return weft_kernel_normalise(report_log(), kernel);
    char name[KERNELS_TEXT], line[KERNELS_TEXT + 100];
    weft_kernel_format(kernel, name, sizeof name);
    snprintf(line, sizeof line, "kernel %s: the weights add up to 0 at some positions: they %s",
             name, on ? "cannot be divided by their sum" : "are taken as they are");
    if (on)
        report_error("%s", line);
    else
        report_log()->write(report_log()->priv, WEFT_LOG_WARNING, line);
    return on ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

size_t kernels_list_length(const char *text, bool semicolons)
{
    if (semicolons)
        return strcspn(text, ";");
    const char *at = text;
    while ((at += strcspn(at, ",")), *at) {
        if (!(isdigit((unsigned char)at[1]) || (at[1] && strchr("+-.", at[1]))))
            break;
        at++;
    }
    return (size_t)(at - text);
}

// The interpolating kernel that a record has by way of a prefilter ("bspline3i").
static bool make_interpolating(const struct weft_kernel_info *info, struct weft_kernel *out)
{
    return !info->derivation && weft_kernel_create(NULL, info, NULL, out) == WEFT_OK &&
           weft_kernel_make_prefiltered(NULL, out) == WEFT_OK;
}

static void print_line(const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    char name[128];
    weft_kernel_format(kernel, name, sizeof name);
    printf("  %-18s %s; %d tap%s, order %d%s%s%s", name, info->description, kernel->width,
           kernel->width == 1 ? "" : "s", kernel->order,
           kernel->interpolating || kernel->prefiltered ? ", interpolating" : "",
           kernel->prefiltered ? " by a prefilter" : "", kernel->unit_sum ? ", unit sum" : "");
    for (int p = 0; p < WEFT_KERNEL_PARAMS && info->params[p].name; p++)
        printf("%s%s in [%g, %g]", p ? ", " : "; ", info->params[p].name, info->params[p].min,
               info->params[p].max);
    if (info->citation)
        printf(" (%s)", info->citation);
    putchar('\n');
}

void kernels_print(void)
{
    puts("kernels:");
    for (int i = 0; weft_kernel_list[i]; i++) {
        struct weft_kernel kernel;
        if (weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel) == WEFT_OK)
            print_line(&kernel);
        if (make_interpolating(weft_kernel_list[i], &kernel))
            print_line(&kernel);
    }
    puts("  table:FILE         samples in a text file: `support R`, then h at equal steps from 0 "
         "to R,\n                     or with `whole` from -R to R; `cubic` instead of linear "
         "between them\n"
         "\nNAME+unit divides the weights at every position by their sum; NAME+radial is h of the "
         "distance\nin 2D and 3D, for tiles, not for slices. NAMEi (bspline3i, omomsi) first "
         "replaces the samples by\n"
         "coefficients, so that B-splines of degree 2 and more interpolate instead of blurring.\n"
         "Trailing parameters may be left out.");
}

static json_t *params_json(const struct weft_kernel_info *info)
{
    json_t *params = json_array();
    for (int p = 0; p < WEFT_KERNEL_PARAMS && info->params[p].name; p++)
        json_array_append_new(params, json_pack("{s:s,s:o,s:o,s:o}", "name", info->params[p].name,
                                                "default", json_number(info->params[p].initial),
                                                "min", json_number(info->params[p].min), "max",
                                                json_number(info->params[p].max)));
    return params;
}

static json_t *kernel_json(const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    char name[64];
    snprintf(name, sizeof name, "%s%s", info->name, kernel->prefiltered ? "i" : "");
    return json_pack("{s:s,s:o,s:o,s:o,s:i,s:i,s:i,s:b,s:b,s:b,s:i,s:o}", "name", name,
                     "description", json_text(info->description), "parameters", params_json(info),
                     "support", json_number(kernel->support), "taps", kernel->width, "order",
                     kernel->order, "order_prefiltered", kernel->order_prefiltered, "interpolating",
                     kernel->interpolating || kernel->prefiltered, "prefiltered",
                     kernel->prefiltered, "unit_sum", kernel->unit_sum, "derivative",
                     info->derivation, "citation",
                     info->citation ? json_text(info->citation) : json_null());
}

json_t *kernels_json(void)
{
    json_t *list = json_array();
    for (int i = 0; weft_kernel_list[i]; i++) {
        struct weft_kernel kernel;
        if (weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel) == WEFT_OK)
            json_array_append_new(list, kernel_json(&kernel));
        if (make_interpolating(weft_kernel_list[i], &kernel))
            json_array_append_new(list, kernel_json(&kernel));
    }
    return json_pack("{s:o}", "kernels", list);
}
