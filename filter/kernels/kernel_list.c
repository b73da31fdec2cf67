// SPDX-License-Identifier: BSD-3-Clause
// The catalogue, and what its records have in common.
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

#define WITH_1(record) &weft_kernel_##record[0], &weft_kernel_##record[1]
#define WITH_2(record) WITH_1(record), &weft_kernel_##record[2]

const struct weft_kernel_info *const weft_kernel_list[] = {
    &weft_kernel_nearest[0],
    &weft_kernel_area[0],
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

// 'B_Spline' is 'b-spline'.
static int fold(char c)
{
    return c == '_' || c == ' ' ? '-' : tolower((unsigned char)c);
}

bool weft_kernel_names_alike(const char *name, const char *text, size_t length)
{
    size_t i = 0;
    while (i < length && name[i] && fold(name[i]) == fold(text[i]))
        i++;
    return i == length && !name[i];
}

size_t weft_kernel_derivative_prefix(const char *text)
{
    const size_t d = strspn(text, "d");
    return d >= 1 && d <= 2 && text[d] == '-' ? d + 1 : 0;
}

const struct weft_kernel_info *weft_kernel_find_word(const char *name, size_t length)
{
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (weft_kernel_names_alike(weft_kernel_list[i]->name, name, length))
            return weft_kernel_list[i];
    return NULL;
}

const struct weft_kernel_info *weft_kernel_find(const char *name)
{
    return name ? weft_kernel_find_word(name, strlen(name)) : NULL;
}

size_t weft_kernel_param_count(const struct weft_kernel_info *info)
{
    size_t count = 0;
    while (count < WEFT_KERNEL_PARAMS && info->params[count].name)
        count++;
    return count;
}

bool weft_kernel_is_listed(const struct weft_kernel_info *info)
{
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (weft_kernel_list[i] == info)
            return true;
    return false;
}

const struct weft_kernel_info *weft_kernel_primitive(const struct weft_kernel_info *info)
{
    return info->primitive ? info->primitive : info;
}

// Splines of the highest order that their degree allows; interpolating ones need no filter.
static bool has_prefilter(const struct weft_kernel_info *info)
{
    const struct weft_kernel_info *spline = weft_kernel_primitive(info);
    return !spline->interpolating && spline->degree >= 2 &&
           spline->order_prefiltered == spline->degree + 1;
}

void weft_kernel_list_names(bool prefiltered, char *text, size_t size)
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
    weft_kernel_list_names(true, names, sizeof names);
    weft_error(log, "kernel %s has no prefilter; %s and their derivatives have", info->name, names);
    return WEFT_ERR_ARGUMENT;
}
