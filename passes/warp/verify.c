// SPDX-License-Identifier: BSD-3-Clause
// Warped pixels beside the samples themselves, whatever engine made them.
#include <math.h>
#include <stdlib.h>

#include "filter/kernels/stretch.h"
#include "passes/verify/planes.h"
#include "passes/verify/verifier.h"
#include "passes/warp/careful.h"

// A fraction that single precision rounds may be on the other side of a tap's border.
static const double MARGIN = 0x1p-24;

struct subject {
    const struct weft_warp_plan *plan;
    const struct weft_resample_verify_params *p;
    struct weft_warp_values samples[WEFT_RESAMPLE_MAX_CHANNELS];
    struct weft_verify_plane planes[WEFT_RESAMPLE_MAX_CHANNELS]; // the same
    weft_cardinal *cardinal;                                     // of prefiltered kernels
    double scale[2]; // of the pixel whose position was asked for last
    double *weights[2];
};

static void position(void *priv, int x, int y, const double moved[3], double out[3])
{
    struct subject *s = priv;
    weft_warp_position(s->plan, x, y, out, s->scale);
    out[2] = 0.0;
    for (int a = 0; moved && a < 2; a++)
        out[a] += moved[a];
}

static double margin(void *priv, const double at[3])
{
    (void)priv;
    (void)at;
    return MARGIN;
}

static double pixel(void *priv, int channel, int x, int y)
{
    const struct subject *s = priv;
    return (double)s->p->plane[channel][(y - s->p->part.y) * s->p->stride + (x - s->p->part.x)];
}

static int64_t weigh(const struct weft_kernel *kernel, double scale, double at, double *weights,
                     int64_t *count)
{
    *count = kernel->width;
    if (scale == 1.0)
        return weft_kernel_weights(kernel, at, weights);
    *count = weft_stretch_width(kernel, scale);
    return weft_stretch_weights(kernel, scale, at, weights);
}

// By compensated sums (Neumaier 1974), over what filter/kernels/stretch.h says.
static struct weft_reference_value sum_up(struct subject *s, const struct weft_warp_values *v,
                                          const double at[3])
{
    int64_t first[2], count[2];
    for (int a = 0; a < 2; a++)
        first[a] = weigh(&s->plan->plain, s->scale[a], at[a], s->weights[a], &count[a]);
    double sum = 0.0, rest = 0.0, magnitude = 0.0;
    for (int64_t j = 0; j < count[1]; j++)
        for (int64_t i = 0; i < count[0]; i++) {
            const double value =
                weft_warp_value(v, weft_boundary_index(v->boundary, first[0] + i, v->size[0]),
                                weft_boundary_index(v->boundary, first[1] + j, v->size[1]));
            const double weight = s->weights[0][i] * s->weights[1][j];
            if (isfinite(value))
                magnitude = fmax(magnitude, fabs(value));
            if (weight == 0.0)
                continue;
            const double term = weight * value, next = sum + term;
            rest += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
            sum = next;
        }
    return (struct weft_reference_value){isfinite(sum) ? sum + rest : sum, magnitude};
}

static enum weft_result refer(void *priv, int channel, const double at[3], bool finite,
                              struct weft_reference_value *out)
{
    struct subject *s = priv;
    const struct weft_warp_values *v = &s->samples[channel];
    *out = s->cardinal ? weft_cardinal_compute(s->cardinal, channel, at, finite) : sum_up(s, v, at);
    if (s->plan->info.clamp)
        out->value = weft_warp_held(v, at, s->scale, out->value);
    return WEFT_OK;
}

static enum weft_result prepare(struct subject *s)
{
    const struct weft_warp_plan *plan = s->plan;
    const struct weft_resample_source *source = s->p->source;
    for (int c = 0; c < source->info.channels; c++) {
        s->samples[c] = weft_warp_samples(plan, source, c);
        s->planes[c] =
            (struct weft_verify_plane){.values = source->plane[c], .stride = source->stride};
    }
    if (plan->info.kernel.prefiltered) {
        const struct weft_kernel kernels[2] = {plan->info.kernel, plan->info.kernel};
        return weft_cardinal_create(s->p->log, kernels, source->info.channels, s->planes,
                                    plan->info.size, &s->cardinal);
    }
    for (int a = 0; a < 2; a++) {
        const int64_t taps = weft_stretch_width(&plan->plain, plan->info.scale[a]);
        s->weights[a] = calloc((size_t)taps + WEFT_KERNEL_MAX_WIDTH, sizeof *s->weights[a]);
    }
    if (s->weights[0] && s->weights[1])
        return WEFT_OK;
    weft_error(s->p->log, "out of memory for the weights of a warp");
    return WEFT_ERR_MEMORY;
}

static double seconds_of(const struct subject *s)
{
    const struct weft_warp_info *info = &s->plan->info;
    return s->cardinal ? weft_cardinal_seconds(s->cardinal)
                       : 3e-7 + 2.5e-8 * info->taps[0] * info->taps[1];
}

enum weft_result weft_warp_verify(const weft_warp_plan *plan,
                                  const struct weft_resample_verify_params *params,
                                  struct weft_verify_report *out)
{
    struct weft_resample_verify_params p = *params;
    struct subject s = {.plan = plan, .p = &p};
    *out = (struct weft_verify_report){0};
    enum weft_result res = weft_warp_check(plan, p.source, &p.part, p.plane, &p.stride, p.log);
    if (res == WEFT_OK)
        res = prepare(&s);
    if (res == WEFT_OK) {
        const struct weft_kernel *kernel = &plan->info.kernel;
        const struct weft_verifier v = {
            .width = plan->info.width,
            .height = plan->info.height,
            .channels = p.source->info.channels,
            .pixels = p.part,
            .priv = &s,
            .position = position,
            .margin = margin,
            .refer = refer,
            .pixel = pixel,
            .jumps = kernel->continuity < 0 && kernel->width > 1,
            .far = s.cardinal != NULL,
            .seconds = seconds_of(&s),
            .bound_absolute = weft_warp_bound(plan, &p.source->info.statistics, 0.0).total,
            .how = p.how,
            .log = p.log,
        };
        res = weft_verifier_run(&v, out);
    }
    weft_cardinal_destroy(&s.cardinal);
    free(s.weights[0]);
    free(s.weights[1]);
    return res;
}
