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
    char names[600], interpolating[200], meant[200];
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
    *prefiltered = !info && length > 0 && (name[length - 1] == 'i' || name[length - 1] == 'I');
    return *prefiltered ? weft_kernel_find_word(name, length - 1) : info;
}

// B and C are what people hand to the cubics that have names.
static void log_too_many(const struct weft_log *log, const struct weft_kernel_info *info,
                         size_t count, const char *text)
{
    const bool is_cubic = info == weft_kernel_mitchell || info == weft_kernel_catmull_rom;
    weft_error(log, "kernel %s takes %s parameter%s, more are given: ':%s'%s%s", info->name,
               count == 0   ? "no"
               : count == 1 ? "1"
                            : "2",
               count == 1 ? "" : "s", text, is_cubic ? "; with B and C: cubic:" : "",
               is_cubic ? text : "");
}

// "cubic:-0.5" is B = -0.5 by our order, and a = -0.5 to everyone.
static bool asks_for_a(const struct weft_kernel_info *info, const double param[WEFT_KERNEL_PARAMS])
{
    return weft_kernel_primitive(info) == weft_kernel_cubic && param[0] < 0.0 && isnan(param[1]);
}

static void log_question(const struct weft_log *log, const struct weft_kernel_info *info, double a)
{
    const int d = (int)weft_kernel_derivative_prefix(info->name);
    char meant[64];
    snprintf(meant, sizeof meant, a == -0.5 ? "catmull-rom" : "cardinal:%g", -a);
    weft_error(log,
               "kernel %s:%g: is a = %g meant, which is %.*s%s, or B = %g, which is %s:%g,0.5?",
               info->name, a, a, d, info->name, meant, a, info->name, a);
}

static enum weft_result parse_params(const struct weft_log *log,
                                     const struct weft_kernel_info *info, const char *text,
                                     double param[WEFT_KERNEL_PARAMS],
                                     struct weft_kernel_flags *flags)
{
    const size_t count = weft_kernel_param_count(info);
    const char *const all = text;
    for (size_t i = 0;; i++) {
        if (i == count) {
            log_too_many(log, info, count, all);
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
    char translated[MAX_TEXT + 1];
    if (weft_kernel_translate(text, translated, sizeof translated))
        text = translated;
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
    if (!res && asks_for_a(info, param)) {
        log_question(log, info, param[0]);
        res = WEFT_ERR_ARGUMENT;
    }
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
