// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/transfer.h"

#include <math.h>

static double light_of_srgb(double code)
{
    const double c = fabs(code);
    return copysign(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4), code);
}

static double srgb_of_light(double light)
{
    const double v = fabs(light);
    return copysign(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055, light);
}

double weft_transfer_light(const struct weft_transfer *transfer, double code)
{
    switch (transfer->curve) {
    case WEFT_CURVE_SRGB:
        return light_of_srgb(code);
    case WEFT_CURVE_POWER:
        return copysign(pow(fabs(code), transfer->exponent), code);
    default:
        return code;
    }
}

double weft_transfer_code(const struct weft_transfer *transfer, double light)
{
    switch (transfer->curve) {
    case WEFT_CURVE_SRGB:
        return srgb_of_light(light);
    case WEFT_CURVE_POWER:
        return copysign(pow(fabs(light), 1.0 / transfer->exponent), light);
    default:
        return light;
    }
}

static struct weft_transfer power(double exponent)
{
    return fabs(exponent - 1.0) < 1e-6
               ? (struct weft_transfer){.curve = WEFT_CURVE_LINEAR}
               : (struct weft_transfer){.curve = WEFT_CURVE_POWER, .exponent = exponent};
}

// Transfer functions of ITU-T H.273.
static bool curve_of_cicp(int function, struct weft_transfer *out)
{
    switch (function) {
    case 4:
        *out = power(2.2);
        return true;
    case 5:
        *out = power(2.8);
        return true;
    case 8:
        *out = power(1.0);
        return true;
    case 13:
        *out = (struct weft_transfer){.curve = WEFT_CURVE_SRGB};
        return true;
    default:
        return false;
    }
}

bool weft_transfer_find(const struct weft_code_info *info, struct weft_transfer *out)
{
    const bool points = info->cicp[0] || info->cicp[1] || info->cicp[2] || info->cicp[3];
    *out = (struct weft_transfer){.curve = WEFT_CURVE_SRGB};
    if (points)
        return curve_of_cicp(info->cicp[1], out);
    if (!info->srgb && info->gamma > 0.0)
        *out = power(1.0 / info->gamma);
    return true;
}
