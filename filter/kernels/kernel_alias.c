// SPDX-License-Identifier: BSD-3-Clause
// What other programs call kernels.
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

enum { TEXT_SIZE = 256 };

const struct weft_kernel_alias weft_kernel_aliases[] = {
    {"bilinear", "linear", true, "along two axes"},
    {"trilinear", "linear", true, "along three axes"},
    {"triangle", "linear", true, "a tent of half-width 1"},
    {"tent", "linear", true, "a tent of half-width 1"},
    {"hat", "linear", true, "a tent of half-width 1"},
    {"point", "nearest", true, "one sample as it is"},
    {"nn", "nearest", true, "one sample as it is"},
    {"neighbor", "nearest", true, "one sample as it is"},
    {"neighbour", "nearest", true, "one sample as it is"},
    {"nearest-neighbor", "nearest", true, "one sample as it is"},
    {"nearest-neighbour", "nearest", true, "one sample as it is"},
    {"catrom", "catmull-rom", true, "cubic convolution with a = -0.5"},
    {"catmull", "catmull-rom", true, "cubic convolution with a = -0.5"},
    {"catmullrom", "catmull-rom", true, "cubic convolution with a = -0.5"},
    {"ctmr", "catmull-rom", true, "cubic convolution with a = -0.5"},
    {"keys", "catmull-rom", true, "Keys's four points with a = -0.5; keys6 takes six"},
    {"simon", "cardinal:0.75", true, "cubic convolution with a = -0.75"},
    {"rifman", "cardinal:1", true, "cubic convolution with a = -1"},
    {"hermite", "cubic:0,0", true, "B = C = 0"},
    {"mitchell-netravali", "mitchell", true, "B = C = 1/3"},
    {"robidoux", "cubic:0.3782157550939987,0.3108921224530007", true, "B and C of ImageMagick's"},
    {"b-spline", "bspline", true, "it blurs; bspline3i passes through the samples"},
    {"cubic-b-spline", "bspline", true, "it blurs; bspline3i passes through the samples"},
    {"cubic-bspline", "bspline", true, "it blurs; bspline3i passes through the samples"},
    {"bspl3", "bspline", true, "it blurs; bspline3i passes through the samples"},
    {"bspl5", "bspline5", true, "it blurs; bspline5i passes through the samples"},
    {"bspl7", "bspline7", true, "it blurs; bspline7i passes through the samples"},
    {"bspl3ai", "bspline3i", true, "a prefilter makes it pass through the samples"},
    {"bspl5ai", "bspline5i", true, "a prefilter makes it pass through the samples"},
    {"bspl7ai", "bspline7i", true, "a prefilter makes it pass through the samples"},
    {"quadric", "bspline2", true, "it blurs; bspline2i passes through the samples"},
    {"o-moms", "omoms", true, "it blurs; omomsi passes through the samples"},
    {"gauss", "gaussian", true, "radius and sigma are its parameters"},
    {"hann", "hann-sinc", true, "a sinc with this window"},
    {"hanning", "hann-sinc", true, "a sinc with this window"},
    {"hamming", "hamming-sinc", true, "a sinc with this window"},
    {"blackman", "blackman-sinc", true, "a sinc with this window"},
    {"black", "blackman-sinc", true, "a sinc with this window"},
    {"kaiser", "kaiser-sinc", true, "a sinc with this window"},
    {"welch", "welch-sinc", true, "a sinc with this window"},

    {"bicubic", "catmull-rom", false,
     "catmull-rom (a = -0.5: MATLAB, Pillow), cardinal:0.75 (a = -0.75: OpenCV, PyTorch) or "
     "mitchell (B = C = 1/3)"},
    {"tricubic", "catmull-rom", false,
     "catmull-rom (it passes through the samples), bspline (it blurs) or bspline3i (a spline "
     "through the samples)"},
    {"cubic-convolution", "catmull-rom", false,
     "catmull-rom (a = -0.5) or cardinal:0.75 (a = -0.75)"},
    {"box", "nearest", false, "nearest (one sample) or area (the mean of what a pixel covers)"},
    {"average", "area", false, "area (the mean of what a pixel covers)"},
    {"spline", "bspline3i", false,
     "bspline3i (it passes through the samples) or bspline (it blurs)"},
    {"cubic-spline", "bspline3i", false,
     "bspline3i (it passes through the samples) or bspline (it blurs)"},
    {"quadratic", "bspline2", false,
     "bspline2i (it passes through the samples) or bspline2 (it blurs)"},
    {"spline16", "catmull-rom", false, "catmull-rom (four points, too, but not the same cubic)"},
    {"spline36", "keys6", false, "keys6 (six points, too, but not the same cubics)"},
    {"spline64", "lanczos", false, "lanczos:4 (eight points, too; weft has no spline64)"},
    {"sinc", "lanczos", false, "lanczos:3 or rect-sinc:3 (without a window)"},
    {"windowed-sinc", "lanczos", false, "lanczos:3, hann-sinc:3 or kaiser-sinc"},
    {"cosine", "hann-sinc", false, "hann-sinc (weft has no cosine window)"},
    {"blackman-harris", "blackman-sinc", false, "blackman-sinc (three terms, not four)"},
    {"blackman-nuttall", "blackman-sinc", false, "blackman-sinc (three terms, not four)"},
    {"jinc", "lanczos", false, "lanczos:3+radial (a sinc of the distance, not a jinc)"},
    {"bessel", "lanczos", false, "lanczos:3+radial (a sinc of the distance, not a jinc)"},
    {"lagrange", "lagrange3", false, "lagrange3 or lagrange5"},
    {NULL, NULL, false, NULL},
};

const struct weft_kernel_alias *weft_kernel_find_alias(const char *text, size_t length)
{
    for (const struct weft_kernel_alias *alias = weft_kernel_aliases; alias->name; alias++)
        if (weft_kernel_names_alike(alias->name, text, length))
            return alias;
    return NULL;
}

// The record that a name or a synonym is of.
static const struct weft_kernel_info *find_either(const char *text, size_t length)
{
    const struct weft_kernel_info *info = weft_kernel_find_word(text, length);
    const struct weft_kernel_alias *alias = weft_kernel_find_alias(text, length);
    return info || !alias || !alias->taken ? info : weft_kernel_find(alias->kernel);
}

// "lanczos3" and "hann4" are a name and its radius.
static bool translate_radius(const char *text, size_t length, char *out, size_t size)
{
    size_t stem = length;
    while (stem > 1 && isdigit((unsigned char)text[stem - 1]))
        stem--;
    const struct weft_kernel_info *info = stem < length ? find_either(text, stem) : NULL;
    if (!info || !info->params[0].name || strcmp(info->params[0].name, "radius") != 0)
        return false;
    snprintf(out, size, "%s:%.*s", info->name, (int)(length - stem), text + stem);
    return true;
}

static const char *translate(const char *text, char *out, size_t size)
{
    const size_t length = strcspn(text, ":+");
    const struct weft_kernel_alias *alias = weft_kernel_find_alias(text, length);
    if (weft_kernel_find_word(text, length))
        return NULL;
    if (alias && alias->taken)
        snprintf(out, size, "%s", alias->kernel);
    else if (!translate_radius(text, length, out, size))
        return NULL;
    // Parameters stand behind those that the name stands for, and are too many then.
    const bool more = text[length] == ':';
    const char *separator = !more ? "" : strchr(out, ':') ? "," : ":";
    const size_t used = strlen(out);
    snprintf(out + used, size - used, "%s%s", separator, text + length + more);
    return alias && alias->taken ? alias->sentence : "the number is its radius";
}

const char *weft_kernel_translate(const char *text, char *out, size_t size)
{
    char first[TEXT_SIZE];
    const size_t d = weft_kernel_derivative_prefix(text);
    const char *sentence = NULL;
    if (strnlen(text, TEXT_SIZE) < TEXT_SIZE)
        sentence = translate(text + d, first, sizeof first);
    snprintf(out, size, "%.*s%s", sentence ? (int)d : 0, text, sentence ? first : "");
    return sentence;
}
