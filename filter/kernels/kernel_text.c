// SPDX-License-Identifier: BSD-3-Clause
// Kernels as texts: "mitchell", "lanczos:3+unit", "d-bspline3i".
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_TEXT = 255 };

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

static void log_unknown(const struct weft_log *log, const char *text, size_t length)
{
    const int shown = (int)(length < 32 ? length : 32);
    char names[600], interpolating[200], meant[120];
    if (weft_kernel_suggest(text, meant, sizeof meant)) {
        weft_error(log, "no kernel '%.*s'; did you mean %s?", shown, text, meant);
        return;
    }
    weft_kernel_list_names(false, names, sizeof names);
    weft_kernel_list_names(true, interpolating, sizeof interpolating);
    weft_error(log,
               "no kernel '%.*s'; there are %s; interpolating by a prefilter %s; for derivatives "
               "d-NAME, dd-NAME",
               shown, text, names, interpolating);
}

static const struct weft_kernel_info *find_or_prefiltered(const char *name, size_t length,
                                                          bool *prefiltered)
{
    const struct weft_kernel_info *info = weft_kernel_find_word(name, length);
    *prefiltered = !info && length > 0 && name[length - 1] == 'i';
    return *prefiltered ? weft_kernel_find_word(name, length - 1) : info;
}

static enum weft_result parse_params(const struct weft_log *log,
                                     const struct weft_kernel_info *info, const char *text,
                                     double param[WEFT_KERNEL_PARAMS],
                                     struct weft_kernel_flags *flags)
{
    const size_t count = weft_kernel_param_count(info);
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
    for (size_t i = 0; i < weft_kernel_param_count(kernel->info); i++) {
        list[used++] = i > 0 ? ',' : ':';
        used += (size_t)format_number(kernel->param[i], list + used, sizeof list - used);
    }
    uselocale(before);
    freelocale(c_locale);
    return snprintf(text, size, "%s%s%s%s%s", kernel->info->name, kernel->prefiltered ? "i" : "",
                    list, kernel->radial ? "+radial" : "", kernel->normalised ? "+unit" : "");
}
