// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/kernel.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_TEXT = 255 };

#define WITH_1(record) &weft_kernel_##record[0], &weft_kernel_##record[1]
#define WITH_2(record) WITH_1(record), &weft_kernel_##record[2]

const struct weft_kernel_info *const weft_kernel_list[] = {
    &weft_kernel_nearest[0],
    WITH_1(linear),
    WITH_2(cubic),
    WITH_2(cardinal),
    WITH_2(catmull_rom),
    WITH_2(mitchell),
    WITH_2(notch),
    WITH_2(bspline),
    &weft_kernel_bspline0[0],
    WITH_1(bspline1),
    WITH_2(bspline2),
    WITH_2(bspline3),
    WITH_2(bspline4),
    WITH_2(bspline5),
    WITH_2(bspline6),
    WITH_2(bspline7),
    WITH_1(omoms),
    WITH_1(lagrange3),
    WITH_1(lagrange5),
    WITH_2(keys6),
    WITH_2(lanczos),
    WITH_2(hann),
    WITH_2(hamming),
    WITH_2(blackman),
    WITH_2(kaiser),
    WITH_2(gauss_sinc),
    WITH_2(welch),
    WITH_2(rect),
    WITH_2(gaussian),
    NULL,
};

static const struct {
    const char *text;
    struct weft_kernel_flags flags;
} suffixes[] = {
    {"", {0}},
    {"+unit", {.unit = true}},
    {"+radial", {.radial = true}},
    {"+radial+unit", {.radial = true, .unit = true}},
    {"+unit+radial", {.radial = true, .unit = true}},
};

bool weft_kernel_read_flags(const char *text, struct weft_kernel_flags *flags)
{
    for (size_t i = 0; i < WEFT_COUNT(suffixes); i++) {
        *flags = suffixes[i].flags;
        if (!strcmp(text, suffixes[i].text))
            return true;
    }
    return false;
}

enum weft_result weft_kernel_apply_flags(const struct weft_log *log, struct weft_kernel_flags flags,
                                         struct weft_kernel *kernel)
{
    enum weft_result res = flags.radial ? weft_kernel_make_radial(log, kernel) : WEFT_OK;
    return !res && flags.unit ? weft_kernel_normalise(log, kernel) : res;
}

static const struct weft_kernel_info *find(const char *name, size_t length)
{
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (strlen(weft_kernel_list[i]->name) == length &&
            !memcmp(weft_kernel_list[i]->name, name, length))
            return weft_kernel_list[i];
    return NULL;
}

const struct weft_kernel_info *weft_kernel_find(const char *name)
{
    return name ? find(name, strlen(name)) : NULL;
}

static size_t param_count(const struct weft_kernel_info *info)
{
    size_t count = 0;
    while (count < WEFT_KERNEL_PARAMS && info->params[count].name)
        count++;
    return count;
}

static bool is_in_catalogue(const struct weft_kernel_info *info)
{
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (weft_kernel_list[i] == info)
            return true;
    return false;
}

enum weft_result weft_kernel_create(const struct weft_log *log, const struct weft_kernel_info *info,
                                    const double *param, struct weft_kernel *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, out);
    *out = (struct weft_kernel){0};
    weft_require(log, info);
    const bool own = !is_in_catalogue(info);
    if (own && !weft_kernel_check_info(log, info))
        goto fail;
    struct weft_kernel kernel = {.info = info};
    for (size_t i = 0; i < param_count(info); i++) {
        const struct weft_kernel_param *p = &info->params[i];
        const double value = param && !isnan(param[i]) ? param[i] : p->initial;
        if (!(value >= p->min && value <= p->max)) {
            weft_error(log, "kernel %s: %s = %g is not in [%g, %g]", info->name, p->name, value,
                       p->min, p->max);
            goto fail;
        }
        kernel.param[i] = value;
    }
    kernel.support = info->radius > 0.0 ? info->radius : kernel.param[0];
    if (!(kernel.support > 0.0 && kernel.support <= 0.5 * WEFT_KERNEL_MAX_WIDTH)) {
        weft_error(log, "kernel %s: half-width %g is not in (0, %g]", info->name, kernel.support,
                   0.5 * WEFT_KERNEL_MAX_WIDTH);
        goto fail;
    }
    kernel.width = (int)ceil(2.0 * kernel.support);
    kernel.continuity = info->continuity;
    kernel.order = info->order;
    kernel.order_prefiltered = info->order_prefiltered;
    kernel.interpolating = info->interpolating;
    kernel.unit_sum = info->unit_sum;
    if (info->refine)
        info->refine(&kernel);
    res = own ? weft_kernel_check(log, &kernel) : WEFT_OK;
    if (res == WEFT_OK)
        *out = kernel;
fail:
    return res;
}

enum weft_result weft_kernel_normalise(const struct weft_log *log, struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s: the weights of a derivative add up to 0, not to 1",
                   kernel->info->name);
        goto fail;
    }
    if (!kernel->unit_sum) {
        kernel->normalised = kernel->unit_sum = true;
        kernel->order = kernel->order > 1 ? kernel->order : 1;
        kernel->order_prefiltered = kernel->order_prefiltered > 1 ? kernel->order_prefiltered : 1;
    }
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_kernel_make_radial(const struct weft_log *log, struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s: a derivative along one axis cannot be radial",
                   kernel->info->name);
        goto fail;
    }
    if (kernel->prefiltered) {
        weft_error(log, "kernel %si: prefiltered splines are products, not radial",
                   kernel->info->name);
        goto fail;
    }
    kernel->radial = true;
    kernel->unit_sum = kernel->normalised;
    kernel->order = kernel->order_prefiltered = kernel->normalised ? 1 : 0;
    // At a sample, the nearest tap that h(k) = 0 says nothing about is sqrt(2) away.
    kernel->interpolating = kernel->interpolating && kernel->support <= M_SQRT2;
    res = WEFT_OK;
fail:
    return res;
}

// What a record is, or is the derivative of.
static const struct weft_kernel_info *primitive_of(const struct weft_kernel_info *info)
{
    return info->primitive ? info->primitive : info;
}

// Splines of the highest order that their degree allows; interpolating ones need no filter.
static bool has_prefilter(const struct weft_kernel_info *info)
{
    const struct weft_kernel_info *spline = primitive_of(info);
    return !spline->interpolating && spline->degree >= 2 &&
           spline->order_prefiltered == spline->degree + 1;
}

// Names of the catalogue, with a comma between them: `prefiltered` ones alone, with their "i", or
// all that are no derivatives.
static void list_names(bool prefiltered, char *text, size_t size)
{
    size_t used = 0;
    *text = '\0';
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        const struct weft_kernel_info *info = weft_kernel_list[i];
        if (info->primitive || (prefiltered && !has_prefilter(info)))
            continue;
        const int n = snprintf(text + used, size - used, "%s%s%s", used ? ", " : "", info->name,
                               prefiltered ? "i" : "");
        used += (size_t)n < size - used ? (size_t)n : size - used - 1;
    }
}

enum weft_result weft_kernel_check_prefilter(const struct weft_log *log,
                                             const struct weft_kernel_info *info)
{
    if (has_prefilter(info))
        return WEFT_OK;
    char names[200];
    list_names(true, names, sizeof names);
    weft_error(log, "kernel %s has no prefilter; %s and their derivatives have", info->name, names);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_kernel_make_prefiltered(const struct weft_log *log,
                                              struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    res = weft_kernel_check_prefilter(log, kernel->info);
    if (res != WEFT_OK)
        goto fail;
    if (kernel->radial) {
        weft_error(log, "kernel %s: radial kernels have no prefilter", kernel->info->name);
        res = WEFT_ERR_ARGUMENT;
        goto fail;
    }
    kernel->prefiltered = true;
    kernel->order = primitive_of(kernel->info)->order_prefiltered - kernel->info->derivation;
fail:
    return res;
}

static const struct weft_kernel_info *find_derivative(const struct weft_kernel_info *info)
{
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (weft_kernel_list[i]->primitive == info && weft_kernel_list[i]->derivation == 1)
            return weft_kernel_list[i];
    return NULL;
}

enum weft_result weft_kernel_derive(const struct weft_log *log, const struct weft_kernel *kernel,
                                    struct weft_kernel *out)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(log, out);
    const struct weft_kernel given = *kernel;
    const struct weft_kernel_info *info = find_derivative(given.info);
    *out = (struct weft_kernel){0};
    if (given.radial) {
        weft_error(log, "kernel %s: the slope of a radial kernel is no product of weights",
                   given.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (given.normalised) {
        weft_error(log, "kernel %s: divided by the sum of its weights, it has no derived record",
                   given.info->name);
        goto fail;
    }
    if (!info) {
        weft_error(log, "kernel %s: the catalogue has no record of its derivative",
                   given.info->name);
        goto fail;
    }
    struct weft_kernel derived;
    if (weft_kernel_create(log, info, given.param, &derived) != WEFT_OK)
        goto fail;
    weft_require(log, derived.width == given.width);
    res = given.prefiltered ? weft_kernel_make_prefiltered(log, &derived) : WEFT_OK;
    if (!res)
        *out = derived;
fail:
    return res;
}

static void log_unknown(const struct weft_log *log, const char *text, size_t length)
{
    const int shown = (int)(length < 32 ? length : 32);
    char names[600], interpolating[200], meant[120];
    if (weft_kernel_suggest(text, meant, sizeof meant)) {
        weft_error(log, "no kernel '%.*s'; did you mean %s?", shown, text, meant);
        return;
    }
    list_names(false, names, sizeof names);
    list_names(true, interpolating, sizeof interpolating);
    weft_error(log,
               "no kernel '%.*s'; there are %s; interpolating by a prefilter %s; for derivatives "
               "d-NAME, dd-NAME",
               shown, text, names, interpolating);
}

static const struct weft_kernel_info *find_or_prefiltered(const char *name, size_t length,
                                                          bool *prefiltered)
{
    const struct weft_kernel_info *info = find(name, length);
    *prefiltered = !info && length > 0 && name[length - 1] == 'i';
    return *prefiltered ? find(name, length - 1) : info;
}

static enum weft_result parse_params(const struct weft_log *log,
                                     const struct weft_kernel_info *info, const char *text,
                                     double param[WEFT_KERNEL_PARAMS],
                                     struct weft_kernel_flags *flags)
{
    const size_t count = param_count(info);
    for (size_t i = 0;; i++) {
        if (i == count) {
            weft_error(log, "kernel %s takes %zu parameters, more are given: ':%s'", info->name,
                       count, text);
            return WEFT_ERR_ARGUMENT;
        }
        const char *end = weft_number_parse(text, &param[i]);
        const bool last = end && weft_kernel_read_flags(end, flags);
        if (!end || !(last || *end == ',')) {
            weft_error(log, "kernel %s: %s = '%s' is not a finite number", info->name,
                       info->params[i].name, text);
            return WEFT_ERR_ARGUMENT;
        }
        if (last)
            return WEFT_OK;
        text = end + 1;
    }
}

enum weft_result weft_kernel_parse(const struct weft_log *log, const char *text,
                                   struct weft_kernel *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, text && out);
    *out = (struct weft_kernel){0};
    if (strnlen(text, MAX_TEXT + 1) > MAX_TEXT) {
        weft_error(log, "kernel text is longer than %d bytes: '%.32s...'", MAX_TEXT, text);
        goto fail;
    }
    const size_t length = strcspn(text, ":+");
    struct weft_kernel_flags flags = {0};
    bool prefiltered;
    const struct weft_kernel_info *info = find_or_prefiltered(text, length, &prefiltered);
    if (!info || (text[length] == '+' && !weft_kernel_read_flags(text + length, &flags))) {
        log_unknown(log, text, length);
        goto fail;
    }
    double param[WEFT_KERNEL_PARAMS];
    for (size_t i = 0; i < WEFT_KERNEL_PARAMS; i++)
        param[i] = NAN;
    res = text[length] == ':' ? parse_params(log, info, text + length + 1, param, &flags) : WEFT_OK;
    if (!res && info == weft_kernel_cubic && param[0] < 0.0 && isnan(param[1]))
        weft_warn(
            log,
            "cubic:%g is B = %g and C = 0.5; was cubic convolution with a = %g meant, which is "
            "cardinal:%g (a = -0.5: catmull-rom)?",
            param[0], param[0], param[0], -param[0]);
    if (!res)
        res = weft_kernel_create(log, info, param, out);
    if (!res && prefiltered)
        res = weft_kernel_make_prefiltered(log, out);
    if (!res)
        res = weft_kernel_apply_flags(log, flags, out);
fail:
    if (res && out)
        *out = (struct weft_kernel){0};
    return res;
}

// The shortest decimal that reads back as the same double.
static int format_number(double value, char *text, size_t size)
{
    int length = 0;
    for (int digits = 1; digits <= 17; digits++) {
        length = snprintf(text, size, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    return length;
}

int weft_kernel_format(const struct weft_kernel *kernel, char *text, size_t size)
{
    if (!kernel->info || !kernel->info->name)
        return snprintf(text, size, "no kernel");
    char list[WEFT_KERNEL_PARAMS * 32] = "";
    size_t used = 0;
    const locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    const locale_t before = uselocale(c_locale);
    for (size_t i = 0; i < param_count(kernel->info); i++) {
        list[used++] = i > 0 ? ',' : ':';
        used += (size_t)format_number(kernel->param[i], list + used, sizeof list - used);
    }
    uselocale(before);
    freelocale(c_locale);
    return snprintf(text, size, "%s%s%s%s%s", kernel->info->name, kernel->prefiltered ? "i" : "",
                    list, kernel->radial ? "+radial" : "", kernel->normalised ? "+unit" : "");
}

// Splits x into an integer and the distance past it in [0, 1): x - floor(x) rounds to 1 where x is
// a tiny negative number.
static double split(double x, double *fraction)
{
    const double base = floor(x);
    *fraction = x - base;
    if (*fraction < 1.0)
        return base;
    *fraction = 0.0;
    return base + 1.0;
}

int64_t weft_kernel_first_tap(const struct weft_kernel *kernel, double x, double *fraction)
{
    const double limit = 0x1p62, below_one = 1.0 - 0x1p-53;
    if (kernel->width < 1 || kernel->width > WEFT_KERNEL_MAX_WIDTH) {
        *fraction = NAN;
        return 0;
    }
    double base = split(isnan(x) ? 0.0 : fmax(-limit, fmin(limit, x)), fraction);
    if (kernel->width % 2 == 0)
        return (int64_t)base - kernel->width / 2 + 1;
    // Not floor(x + 1/2): that sum rounds the double below 1/2 up to 1.
    if (*fraction >= 0.5) {
        base += 1.0;
        *fraction -= 0.5;
    } else {
        *fraction = fmin(*fraction + 0.5, below_one);
    }
    return (int64_t)base - (kernel->width - 1) / 2;
}

double weft_kernel_offset(const struct weft_kernel *kernel)
{
    return 0.5 * kernel->width - 1.0;
}

// Radial kernels lose the flag for what they are in 2D and 3D; along one axis h is what it was.
static bool value_interpolates(const struct weft_kernel *kernel)
{
    struct weft_kernel plain = *kernel;
    if (!kernel->radial)
        return kernel->interpolating;
    plain.interpolating = kernel->info->interpolating;
    if (kernel->info->refine)
        kernel->info->refine(&plain);
    return plain.interpolating;
}

double weft_kernel_value(const struct weft_kernel *kernel, double x)
{
    if (x == rint(x) && value_interpolates(kernel))
        return x == 0.0 ? 1.0 : 0.0;
    return kernel->info->weight(kernel, x);
}

double weft_kernel_argument(double fraction, double shift)
{
    const double x = fraction + shift, knot = shift + 1.0;
    return x < knot ? x : nextafter(knot, -INFINITY);
}

static int64_t plain_weights(const struct weft_kernel *kernel, double x, double *weights)
{
    double fraction;
    const int64_t first = weft_kernel_first_tap(kernel, x, &fraction);
    const double offset = weft_kernel_offset(kernel);
    for (int j = 0; j < kernel->width; j++)
        weights[j] = weft_kernel_value(kernel, weft_kernel_argument(fraction, offset - j));
    return first;
}

static double sum(const double *values, int count)
{
    double total = 0.0;
    for (int i = 0; i < count; i++)
        total += values[i];
    return total;
}

int64_t weft_kernel_weights(const struct weft_kernel *kernel, double x, double *weights)
{
    if (!weft_kernel_usable(kernel))
        return 0;
    const int64_t first = plain_weights(kernel, x, weights);
    if (kernel->normalised) {
        const double total = sum(weights, kernel->width);
        for (int j = 0; j < kernel->width; j++)
            weights[j] /= total;
    }
    return first;
}

double weft_kernel_weight(const struct weft_kernel *kernel, double x)
{
    if (!weft_kernel_usable(kernel))
        return NAN;
    const double h = weft_kernel_value(kernel, x);
    if (!kernel->normalised || h == 0.0)
        return h;
    double weights[WEFT_KERNEL_MAX_WIDTH];
    plain_weights(kernel, x, weights);
    return h / sum(weights, kernel->width);
}

// (h / s)' = (h' - h s' / s) / s.
double weft_kernel_derivative(const struct weft_kernel *kernel, double x)
{
    if (!weft_kernel_usable(kernel) || !kernel->info->derivative)
        return NAN;
    const double slope = kernel->info->derivative(kernel, x);
    if (!kernel->normalised || !(fabs(x) <= kernel->support))
        return slope;
    double weights[WEFT_KERNEL_MAX_WIDTH], slopes[WEFT_KERNEL_MAX_WIDTH];
    const int64_t first = plain_weights(kernel, x, weights);
    for (int j = 0; j < kernel->width; j++)
        slopes[j] = kernel->info->derivative(kernel, x - (double)(first + j));
    const double total = sum(weights, kernel->width);
    return (slope - weft_kernel_value(kernel, x) * sum(slopes, kernel->width) / total) / total;
}
