// SPDX-License-Identifier: BSD-3-Clause
// The form for contexts without image atomics: supersampling at the places that the other forms'
// samples have.
#include "passes/antialias/acaa_impl.h"

enum weft_result weft_acaa_jitter_create(struct weft_acaa *a)
{
    const struct weft_acaa_params *p = &a->params;
    struct weft_supersample_params s = {
        WEFT_SUPERSAMPLE_DEFAULTS.width = p->width,
        .height = p->height,
        .position = (const double(*)[2])a->plan.pattern.position,
        .count = a->plan.pattern.count,
        .filter = p->filter,
        .filter_width = p->filter_width,
        .format = WEFT_ANTIALIAS_RGBA32F,
        .method = p->sums == WEFT_ACAA_FLOAT ? WEFT_ACCUMULATE_FLOAT : WEFT_ACCUMULATE_EXACT,
        .context = p->context,
        .log = p->log,
    };
    for (int c = 0; c < 4; c++)
        s.background[c] = p->background[c];
    return weft_supersample_create(&s, &a->jitter);
}

// The supersampler counts its own passes.
struct counted {
    const struct weft_antialias_drawing *drawing;
    uint64_t *callbacks;
};

static enum weft_result draw(void *priv, const struct weft_antialias_pass *pass)
{
    const struct counted *c = priv;
    ++*c->callbacks;
    return c->drawing->draw(c->drawing->priv, pass);
}

enum weft_result weft_acaa_jitter_run(struct weft_acaa *a,
                                      const struct weft_antialias_drawing *drawing,
                                      const struct weft_progress *progress)
{
    struct counted counted = {drawing, &a->report.callbacks};
    return weft_supersample_run(
        a->jitter,
        &(struct weft_antialias_drawing){.draw = draw, .priv = &counted, .part = a->part}, NULL,
        progress);
}

void weft_acaa_jitter_report(const struct weft_acaa *a, struct weft_acaa_report *r)
{
    struct weft_supersample_report s;
    weft_supersample_get_report(a->jitter, &s);
    r->passes = s.passes;
    r->device_samples = 1;
    r->discrepancy = s.discrepancy;
    r->radius = s.radius;
    for (int i = 0; i < 2; i++)
        r->first_less[i] = r->first_more[i] = -1;
    r->range = a->params.range > 0.0 ? a->params.range : 1.0;
    r->bound = s.bound + s.filter_bound * r->range;
    // One sample of depths and four floats, and where those are added up.
    r->formula_bytes = weft_bytes_accumulative(a->params.width, a->params.height, 1, 16, 4);
    r->bytes = s.bytes;
}
