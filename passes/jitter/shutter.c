// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/shutter.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"
#include "passes/jitter/weights_impl.h"

static const double default_sigma = 0.2;

static bool is_good(const struct weft_shutter *s)
{
    if (s->shape == WEFT_SHUTTER_GAUSS)
        return s->sigma >= 0.01 && s->sigma <= 100.0;
    return s->shape == WEFT_SHUTTER_RAMPS && s->open >= 0.0 && s->open <= s->close &&
           s->close <= 1.0;
}

// Logs what is wrong with a shutter.
static bool check(const struct weft_log *log, const struct weft_shutter *s)
{
    if (is_good(s))
        return true;
    if (s->shape == WEFT_SHUTTER_GAUSS)
        weft_error(log, "a shutter's sigma is %g: it must be in 0.01 to 100", s->sigma);
    else if (s->shape == WEFT_SHUTTER_RAMPS)
        weft_error(log, "a shutter is open from %g to %g: 0 <= open <= close <= 1 is required",
                   s->open, s->close);
    else
        weft_error(log, "a shutter's shape is %d: its enum has 0 to %d", (int)s->shape,
                   WEFT_SHUTTER_SHAPE_COUNT - 1);
    return false;
}

// ---- texts
// ----------------------------------------------------------------------------------------

// All of `text` is a number.
static bool parse_number(const char *text, char end, double *out)
{
    const char *rest = weft_number_parse(text, out);
    return rest && *rest == end;
}

static bool parse(const char *text, struct weft_shutter *s)
{
    *s = (struct weft_shutter)WEFT_SHUTTER_BOX;
    if (strcmp(text, "box") == 0)
        return true;
    if (strcmp(text, "tent") == 0) {
        *s = (struct weft_shutter)WEFT_SHUTTER_TENT;
        return true;
    }
    if (strncmp(text, "gauss", 5) == 0) {
        *s = (struct weft_shutter){.shape = WEFT_SHUTTER_GAUSS, .sigma = default_sigma};
        return !text[5] || (text[5] == ':' && parse_number(text + 6, 0, &s->sigma));
    }
    const char *colon = strchr(text, ':');
    return colon && parse_number(text, ':', &s->open) && parse_number(colon + 1, 0, &s->close);
}

enum weft_result weft_shutter_parse(const struct weft_log *log, const char *text,
                                    struct weft_shutter *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, text && out);
    if (!parse(text, out)) {
        weft_error(log,
                   "no shutter '%.48s'; there are box, tent, gauss[:SIGMA] and OPEN:CLOSE, such as "
                   "0.25:0.75",
                   text);
        goto fail;
    }
    res = check(log, out) ? WEFT_OK : WEFT_ERR_ARGUMENT;
fail:
    if (res && out)
        *out = (struct weft_shutter)WEFT_SHUTTER_BOX;
    return res;
}

// ---- light
// ----------------------------------------------------------------------------------------

static double ramps_light(const struct weft_shutter *s, double t)
{
    if (t < s->open)
        return t / s->open;
    return t > s->close ? (1.0 - t) / (1.0 - s->close) : 1.0;
}

// The integral of the light from 0 to t.
static double ramps_sum(const struct weft_shutter *s, double t)
{
    if (t < s->open)
        return 0.5 * t * t / s->open;
    const double flat = 0.5 * s->open + fmin(t, s->close) - s->open;
    return t > s->close ? flat + 0.5 * (t - s->close) * (1.0 + ramps_light(s, t)) : flat;
}

static double gauss_light(const struct weft_shutter *s, double t)
{
    const double u = (t - 0.5) / s->sigma;
    return exp(-0.5 * u * u);
}

static double gauss_share(const struct weft_shutter *s, double t)
{
    const double scale = s->sigma * M_SQRT2;
    return 0.5 + 0.5 * erf((t - 0.5) / scale) / erf(0.5 / scale);
}

double weft_shutter_light(const struct weft_shutter *shutter, double t)
{
    if (!is_good(shutter) || isnan(t))
        return NAN;
    if (!(t >= 0.0 && t <= 1.0))
        return 0.0;
    return shutter->shape == WEFT_SHUTTER_GAUSS ? gauss_light(shutter, t) : ramps_light(shutter, t);
}

double weft_shutter_share(const struct weft_shutter *shutter, double t)
{
    if (!is_good(shutter) || isnan(t))
        return NAN;
    const double within = fmin(fmax(t, 0.0), 1.0);
    if (shutter->shape == WEFT_SHUTTER_GAUSS)
        return gauss_share(shutter, within);
    return ramps_sum(shutter, within) / ramps_sum(shutter, 1.0);
}

enum weft_result weft_shutter_weights(const struct weft_log *log,
                                      const struct weft_shutter *shutter, int count, double *times,
                                      double *weights, struct weft_weights_report *report)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (report)
        *report = WEFT_WEIGHTS_NONE;
    weft_require(log, shutter && weights && count > 0);
    if (!check(log, shutter))
        goto fail;
    for (int k = 0; k < count; k++) {
        const double t = (k + 0.5) / count;
        weights[k] = weft_shutter_light(shutter, t);
        if (times)
            times[k] = t;
    }
    res = weft_weights_normalise(log, count, weights, report);
fail:
    return res;
}
