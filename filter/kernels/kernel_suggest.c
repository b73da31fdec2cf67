// SPDX-License-Identifier: BSD-3-Clause
// What an unknown kernel's name was meant to be: other programs' names, and slips of the finger.
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_NAMES = 256, NAME_SIZE = 32 };

// What other programs call them; more than one kernel goes by some of these names.
static const struct alias {
    const char *name, *meant;
} aliases[] = {
    {"bicubic", "catmull-rom (a = -0.5; cardinal:0.75 has a = -0.75)"},
    {"tricubic", "catmull-rom (bspline is the smooth one)"},
    {"cubic-convolution", "catmull-rom (a = -0.5; cardinal:0.75 has a = -0.75)"},
    {"keys", "catmull-rom (Keys's a = -0.5; keys6 takes six points)"},
    {"catrom", "catmull-rom"},
    {"catmull", "catmull-rom"},
    {"catmullrom", "catmull-rom"},
    {"hermite", "cubic:0,0"},
    {"robidoux", "cubic:0.3782,0.3109"},
    {"bilinear", "linear"},
    {"trilinear", "linear"},
    {"triangle", "linear"},
    {"tent", "linear"},
    {"hat", "linear"},
    {"box", "nearest"},
    {"point", "nearest"},
    {"nn", "nearest"},
    {"nearest-neighbour", "nearest"},
    {"nearest-neighbor", "nearest"},
    {"mitchell-netravali", "mitchell"},
    {"b-spline", "bspline (it smooths; bspline3i interpolates)"},
    {"cubic-b-spline", "bspline (it smooths; bspline3i interpolates)"},
    {"cubic-bspline", "bspline (it smooths; bspline3i interpolates)"},
    {"spline16", "catmull-rom (it is not the same cubic)"},
    {"spline36", "keys6 (it is not the same piecewise cubic)"},
    {"spline", "bspline3i (it interpolates; bspline smooths)"},
    {"cubic-spline", "bspline3i (it interpolates; bspline smooths)"},
    {"quadratic", "bspline2 (bspline2i interpolates)"},
    {"gauss", "gaussian"},
    {"sinc", "lanczos:3 (or rect-sinc:3, without a window)"},
    {"jinc", "lanczos:3+radial"},
    {"hann", "hann-sinc"},
    {"hanning", "hann-sinc"},
    {"hamming", "hamming-sinc"},
    {"blackman", "blackman-sinc"},
    {"kaiser", "kaiser-sinc"},
    {"welch", "welch-sinc"},
    {"cosine", "hann-sinc"},
    {"lagrange", "lagrange3"},
    {"o-moms", "omoms"},
};

struct names {
    const char *list[MAX_NAMES];
    char prefiltered[MAX_NAMES / 8][NAME_SIZE]; // "bspline3i"
    size_t count;
};

static void add(struct names *names, const char *name)
{
    if (names->count + 1 < MAX_NAMES)
        names->list[names->count++] = name;
}

// The catalogue comes first: of names equally near it wins.
static void collect(struct names *names)
{
    size_t prefiltered = 0;
    *names = (struct names){.count = 0};
    for (size_t i = 0; weft_kernel_list[i]; i++)
        add(names, weft_kernel_list[i]->name);
    for (size_t i = 0; weft_kernel_list[i] && prefiltered < WEFT_COUNT(names->prefiltered); i++) {
        const struct weft_kernel_info *info = weft_kernel_list[i];
        if (info->primitive || weft_kernel_check_prefilter(NULL, info) != WEFT_OK)
            continue;
        char *name = names->prefiltered[prefiltered++];
        snprintf(name, NAME_SIZE, "%si", info->name);
        add(names, name);
    }
    for (size_t i = 0; i < WEFT_COUNT(aliases); i++)
        add(names, aliases[i].name);
}

static const char *meaning(const char *name)
{
    for (size_t i = 0; i < WEFT_COUNT(aliases); i++)
        if (!strcmp(aliases[i].name, name))
            return aliases[i].meant;
    return name;
}

// "lanczos3" and "hann4" are a name and its radius elsewhere.
static bool suggest_radius(const struct names *names, const char *text, size_t length, char *out,
                           size_t size)
{
    size_t stem = length;
    while (stem > 1 && text[stem - 1] >= '0' && text[stem - 1] <= '9')
        stem--;
    const char *name = stem < length ? weft_closest_find(text, stem, names->list) : NULL;
    if (!name || strlen(name) != stem)
        return false;
    const struct weft_kernel_info *info = weft_kernel_find(meaning(name));
    if (!info || !info->params[0].name || strcmp(info->params[0].name, "radius") != 0)
        return false;
    snprintf(out, size, "%s:%.*s%.*s", info->name, (int)(length - stem), text + stem,
             text[length] == '+' ? NAME_SIZE : 0, text + length);
    return true;
}

static bool suggest(const char *text, char *out, size_t size)
{
    struct names names;
    const size_t length = strcspn(text, ":+");
    collect(&names);
    if (suggest_radius(&names, text, length, out, size))
        return true;
    const char *name = weft_closest_find(text, length, names.list);
    if (!name)
        return false;
    // What stands behind a slip of the finger stays; another program's parameters are not ours.
    const char *meant = meaning(name);
    const bool keep = meant == name || (text[length] == '+' && !strchr(meant, ' '));
    snprintf(out, size, "%s%.*s", meant, keep ? NAME_SIZE : 0, text + length);
    return true;
}

bool weft_kernel_suggest(const char *text, char *out, size_t size)
{
    const size_t d = strspn(text, "d");
    const size_t prefix = d >= 1 && d <= 2 && text[d] == '-' ? d + 1 : 0;
    snprintf(out, size, "%.*s", (int)prefix, text);
    return suggest(text + prefix, out + prefix, size - prefix);
}
