// SPDX-License-Identifier: BSD-3-Clause
// Images for the verifier: a grid's positions, samples and pixels in memory.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "filter/kernels/stretch.h"
#include "passes/separable/separable_impl.h"
#include "passes/verify/planes.h"
#include "filter/kernels/kernel_axes.h"
#include "passes/verify/verifier.h"

struct subject {
    struct weft_pixels_verify_params p; // with its defaults filled in
    bool derived;                       // kernels differ between axes
    bool stretched;
    int channel;                        // that is fetched
    weft_cardinal *cardinal;            // where it is asked for
    struct weft_verify_plane planes[4]; // its samples; but for clamp continued ones
    int size[2];
    void *continued[4]; // those with `pad` of the boundary's on every side, but for clamp
    int pad;
    double *room; // for the weights of stretched kernels
};

// ---- positions, samples and pixels --------------------------------------------------------------

static void position(void *priv, int x, int y, const double moved[3], double out[3])
{
    const struct subject *s = priv;
    (void)moved; // engines take these positions as they are
    weft_multipass_position(s->p.grid, x, y, out);
}

static double pixel(void *priv, int channel, int x, int y)
{
    const struct subject *s = priv;
    const struct weft_verify_plane *plane = &s->p.pixels[channel];
    return weft_verify_value(plane, (y - s->p.part.y) * plane->stride + (x - s->p.part.x));
}

static double fetch(void *priv, const int64_t index[3])
{
    const struct subject *s = priv;
    const struct weft_verify_plane *plane = &s->p.samples[s->channel];
    int64_t at[3];
    for (int a = 0; a < 3; a++) {
        at[a] = weft_boundary_index(s->p.boundary, index[a], s->p.size[a]);
        if (at[a] < 0)
            return s->p.border;
    }
    const int64_t row = at[2] * s->p.size[1] + at[1];
    return weft_verify_value(plane, (row - s->p.window.y) * plane->stride + at[0] - s->p.window.x);
}

// Between the samples next to a position.
static double clamped(struct subject *s, const double at[3], double value)
{
    double low = INFINITY, high = -INFINITY;
    int64_t from[2], to[2];
    for (int a = 0; a < 2; a++) {
        from[a] = (int64_t)ceil(at[a] - s->p.stretch[a]);
        to[a] = (int64_t)floor(at[a] + s->p.stretch[a]);
    }
    for (int64_t y = from[1]; y <= to[1]; y++) {
        for (int64_t x = from[0]; x <= to[0]; x++) {
            const double sample = fetch(s, (int64_t[3]){x, y, 0});
            low = isfinite(sample) ? fmin(low, sample) : low;
            high = isfinite(sample) ? fmax(high, sample) : high;
        }
    }
    return low <= high && isfinite(value) ? fmin(fmax(value, low), high) : value;
}

static enum weft_result refer(void *priv, int channel, const double at[3], bool finite,
                              struct weft_reference_value *out)
{
    struct subject *s = priv;
    s->channel = channel;
    const double padded[2] = {at[0] + s->pad, at[1] + s->pad};
    if (s->cardinal)
        *out = weft_cardinal_compute(s->cardinal, channel, padded, finite);
    else if (s->stretched)
        *out =
            weft_reference_compute_stretched(s->p.kernel, s->p.stretch, 2, at, s->room, fetch, s);
    else if (s->derived)
        *out = weft_reference_compute_axes(s->p.kernel, s->p.dims, at, fetch, s);
    else
        *out = weft_reference_compute(s->p.kernel, s->p.dims, at, fetch, s);
    if (s->p.clamp)
        out->value = clamped(s, at, out->value);
    return WEFT_OK;
}

// ---- the request --------------------------------------------------------------------------------

static void fill_defaults(struct subject *s)
{
    struct weft_pixels_verify_params *p = &s->p;
    p->dims = p->dims ? p->dims : 2;
    p->channels = p->channels ? p->channels : 1;
    for (int a = 1; a < 3; a++) {
        s->derived = s->derived || (a < p->dims && p->kernel[a].info);
        p->kernel[a] = p->kernel[a].info ? p->kernel[a] : p->kernel[0];
    }
    for (int a = p->dims > 0 ? p->dims : 1; a < 3; a++)
        p->size[a] = 1;
    for (int a = 0; a < 2; a++) {
        p->stretch[a] = p->stretch[a] == 0.0 ? 1.0 : p->stretch[a];
        s->stretched = s->stretched || p->stretch[a] != 1.0;
    }
}

static void fill_strides(struct weft_pixels_verify_params *p)
{
    for (int c = 0; c < 4; c++) {
        p->samples[c].stride = p->samples[c].stride ? p->samples[c].stride : p->window.width;
        p->pixels[c].stride = p->pixels[c].stride ? p->pixels[c].stride : p->part.width;
    }
}

static bool is_part(const struct weft_rectangle *window, const int size[3])
{
    return window->width != size[0] || window->height != size[1];
}

static enum weft_result check_parts(struct weft_pixels_verify_params *p)
{
    enum weft_result res =
        weft_rectangle_within(p->log, &p->part, p->grid->width, p->grid->height, &p->part);
    if (res == WEFT_OK)
        res = weft_rectangle_within(p->log, &p->window, p->size[0], p->size[1], &p->window);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->dims <= 2 || !is_part(&p->window, p->size));
    weft_require(p->log, !p->cardinal || !is_part(&p->window, p->size));
    res = WEFT_OK;
fail:
    return res;
}

static enum weft_result check(struct subject *s)
{
    struct weft_pixels_verify_params *p = &s->p;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->dims >= 1 && p->dims <= 3);
    weft_require(p->log, p->channels >= 1 && p->channels <= 4);
    weft_require(p->log, p->grid->width > 0 && p->grid->height > 0);
    weft_require_enum(p->log, p->boundary, WEFT_BOUNDARY_BORDER);
    weft_require(p->log, isfinite(p->border));
    weft_require(p->log, p->dims == 2 || !(s->stretched || p->clamp));
    weft_require(p->log, !s->stretched || !(s->derived || p->cardinal));
    for (int a = 0; a < 3; a++) {
        weft_require(p->log, p->size[a] > 0);
        weft_require(p->log, p->kernel[a].width == p->kernel[0].width);
        weft_require(p->log, !p->cardinal || p->kernel[a].prefiltered);
        res = weft_kernel_check(p->log, &p->kernel[a]);
        if (res != WEFT_OK)
            return res;
        res = WEFT_ERR_ARGUMENT;
    }
    res = check_parts(p);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    fill_strides(p);
    for (int c = 0; c < p->channels; c++) {
        weft_require(p->log, p->samples[c].values && p->pixels[c].values);
        weft_require_enum(p->log, p->samples[c].type, WEFT_VERIFY_UINT32);
        weft_require_enum(p->log, p->pixels[c].type, WEFT_VERIFY_UINT32);
        weft_require(p->log, p->samples[c].stride >= p->window.width);
        weft_require(p->log, p->pixels[c].stride >= p->part.width);
    }
    if (p->cardinal && p->dims != 2) {
        weft_error(p->log, "verifying: cardinal splines are for 2D here, not %dD", p->dims);
        return WEFT_ERR_UNSUPPORTED;
    }
    res = WEFT_OK;
fail:
    return res;
}

static double seconds_of(const struct subject *s)
{
    double more = 1.0;
    for (int a = 0; s->stretched && a < 2; a++)
        more *= (double)weft_stretch_width(s->p.kernel, s->p.stretch[a]) / s->p.kernel[0].width;
    return s->cardinal ? weft_cardinal_seconds(s->cardinal)
                       : more * weft_verifier_seconds(s->p.kernel, s->p.dims);
}

// ---- what references need -----------------------------------------------------------------------

static enum weft_result make_room(struct subject *s)
{
    int64_t width[2];
    for (int a = 0; a < 2; a++) {
        width[a] = weft_stretch_width(s->p.kernel, s->p.stretch[a]);
        if (width[a] == 0) {
            weft_error(s->p.log, "verifying: %s cannot be stretched by %g",
                       s->p.kernel[0].info->name, s->p.stretch[a]);
            return WEFT_ERR_ARGUMENT;
        }
    }
    s->room = malloc((size_t)(width[0] + width[1]) * sizeof *s->room);
    if (s->room)
        return WEFT_OK;
    weft_error(s->p.log, "out of memory for %lld weights", (long long)(width[0] + width[1]));
    return WEFT_ERR_MEMORY;
}

// A channel's samples continued by the boundary as far as they count, as floats.
static enum weft_result continue_samples(struct subject *s, int channel)
{
    const int64_t width = s->p.size[0] + 2 * (int64_t)s->pad,
                  height = s->p.size[1] + 2 * (int64_t)s->pad;
    float *out = malloc((size_t)(width * height) * sizeof *out);
    s->channel = channel;
    s->continued[channel] = out;
    if (!out) {
        weft_error(s->p.log, "out of memory for %lld samples", (long long)(width * height));
        return WEFT_ERR_MEMORY;
    }
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++)
            out[y * width + x] = (float)fetch(s, (int64_t[3]){x - s->pad, y - s->pad, 0});
    return WEFT_OK;
}

// Cardinal splines hold the nearest sample beyond what they are given.
static enum weft_result make_cardinal(struct subject *s)
{
    enum weft_result res = WEFT_OK;
    memcpy(s->planes, s->p.samples, sizeof s->planes);
    s->pad = s->p.boundary == WEFT_BOUNDARY_CLAMP ? 0 : WEFT_PREFILTER_MAX_OVERLAP;
    for (int c = 0; s->pad && res == WEFT_OK && c < s->p.channels; c++) {
        res = continue_samples(s, c);
        s->planes[c] = (struct weft_verify_plane){.values = s->continued[c],
                                                  .stride = s->p.size[0] + 2 * s->pad};
    }
    for (int a = 0; a < 2; a++)
        s->size[a] = s->p.size[a] + 2 * s->pad;
    return res == WEFT_OK ? weft_cardinal_create(s->p.log, s->p.kernel, s->p.channels, s->planes,
                                                 s->size, &s->cardinal)
                          : res;
}

static void clear(struct subject *s)
{
    weft_cardinal_destroy(&s->cardinal);
    for (int c = 0; c < 4; c++)
        free(s->continued[c]);
    free(s->room);
}

enum weft_result weft_pixels_verify(const struct weft_pixels_verify_params *params,
                                    struct weft_verify_report *out)
{
    struct subject s = {.p = *params};
    *out = (struct weft_verify_report){0};
    fill_defaults(&s);
    enum weft_result res = check(&s);
    if (res == WEFT_OK && s.p.cardinal)
        res = make_cardinal(&s);
    if (res == WEFT_OK && s.stretched)
        res = make_room(&s);
    const struct weft_verifier v = {
        .width = s.p.grid->width,
        .height = s.p.grid->height,
        .channels = s.p.channels,
        .pixels = s.p.part,
        .priv = &s,
        .position = position,
        .refer = refer,
        .pixel = pixel,
        .seconds = seconds_of(&s),
        .bound_relative = s.p.bound_relative,
        .bound_absolute = s.p.bound_absolute,
        .how = s.p.how,
        .log = s.p.log,
    };
    if (res == WEFT_OK)
        res = weft_verifier_run(&v, out);
    clear(&s);
    return res;
}

// ---- the engines' own requests ------------------------------------------------------------------

static struct weft_verify_params how_of(const struct weft_verify_params *params,
                                        const struct weft_progress *progress)
{
    struct weft_verify_params how = params ? *params : (struct weft_verify_params){0};
    how.progress = how.progress ? how.progress : progress;
    return how;
}

enum weft_result weft_separable_verify(const weft_separable_plan *plan,
                                       const struct weft_separable_run_params *run,
                                       const struct weft_verify_params *params,
                                       struct weft_verify_report *out)
{
    const struct weft_separable_info *info = &plan->info;
    struct weft_separable_run_params r;
    *out = (struct weft_verify_report){0};
    enum weft_result res = weft_separable_check_run(plan, run, &r);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(r.log, r.samples && !r.wide);
    const struct weft_pixel_grid grid = {.width = info->width,
                                         .height = info->height,
                                         .columns = plan->axis[0].at,
                                         .rows = plan->axis[1].at};
    return weft_pixels_verify(
        weft_pixels_verify_params(.kernel = {info->kernel}, .grid = &grid, .part = r.part,
                                  .size = {info->size[0], info->size[1]},
                                  .stretch = {info->stretch[0], info->stretch[1]},
                                  .boundary = info->boundary, .border = r.border,
                                  .window = r.window, .samples = {{.values = r.samples}},
                                  .pixels = {{.values = r.pixels, .stride = r.stride}},
                                  .bound_relative = weft_separable_plan_error(plan),
                                  .bound_absolute = 0.0, .how = how_of(params, r.progress),
                                  .log = r.log),
        out);
fail:
    return res;
}

enum weft_result weft_multipass_verify_work(const struct weft_multipass_work *work,
                                            const struct weft_multipass_verify_params *params,
                                            struct weft_verify_report *out)
{
    const struct weft_multipass_request request = {
        .samples = params->samples,
        .grid = params->grid,
        .pixels = {params->pixels[0], params->pixels[1], params->pixels[2], params->pixels[3]},
        .stride = params->stride,
    };
    *out = (struct weft_verify_report){0};
    enum weft_result res = weft_multipass_check_list(params->log, work);
    if (res == WEFT_OK)
        res = weft_multipass_check_request(params->log, work, &request);
    if (res != WEFT_OK)
        return res;
    struct weft_pixels_verify_params p =
        *weft_pixels_verify_params(.kernel = {work->kernel}, .dims = work->passes->dims,
                                   .grid = params->grid, .channels = work->channels,
                                   .how = params->how, .log = params->log);
    for (int a = 0; a < 3; a++)
        p.size[a] = params->samples->size[a];
    for (int c = 0; c < work->channels; c++) {
        p.samples[c].values = params->samples->plane[c];
        p.pixels[c] =
            (struct weft_verify_plane){.values = params->pixels[c], .stride = params->stride};
    }
    for (int a = 0; a < 3 && weft_derivative_order(&work->derivative) && res == WEFT_OK; a++)
        res = weft_kernel_derive_times(params->log, &work->kernel, work->derivative.along[a],
                                       &p.kernel[a]);
    return res == WEFT_OK ? weft_pixels_verify(&p, out) : res;
}

enum weft_result weft_multipass_verify(const struct weft_multipass_verify_params *params,
                                       struct weft_verify_report *out)
{
    struct weft_multipass_work work;
    *out = (struct weft_verify_report){0};
    const enum weft_result res = weft_multipass_plan_work(params->log, params->plan, &work);
    return res == WEFT_OK ? weft_multipass_verify_work(&work, params, out) : res;
}
