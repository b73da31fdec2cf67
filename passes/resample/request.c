// SPDX-License-Identifier: BSD-3-Clause
// What is the same of a request whichever engine runs it: checks, progress, sums.
#include <math.h>

#include "passes/resample/resample_impl.h"

// Their kernels were both checked; parameters that only E1 tells apart do not matter.
static bool reads_the_same(const struct weft_kernel *a, const struct weft_kernel *b)
{
    return a->prefiltered == b->prefiltered && (!a->prefiltered || a->info == b->info);
}

enum weft_result weft_resample_check_request(const struct weft_log *log,
                                             const weft_resample_plan *plan,
                                             const weft_resample_source *source,
                                             const float *const *plane, int64_t *stride)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, source);
    const struct weft_resample_source_info *from = &source->info;
    const struct weft_resample_info *to = &plan->info;
    *stride = *stride ? *stride : to->width;
    if (from->width != to->size[0] || from->height != to->size[1]) {
        weft_error(log, "resampling a source of %d x %d samples by a plan for %d x %d", from->width,
                   from->height, to->size[0], to->size[1]);
        goto fail;
    }
    if (!reads_the_same(&from->kernel, &to->kernel)) {
        weft_error(log, "resampling with %s%s a source that was made for %s%s",
                   to->kernel.info->name, to->kernel.prefiltered ? ", prefiltered," : "",
                   from->kernel.info->name, from->kernel.prefiltered ? ", prefiltered" : "");
        goto fail;
    }
    if (*stride < to->width) {
        weft_error(log, "resampling: a stride of %lld floats is less than the %d pixels of a row",
                   (long long)*stride, to->width);
        goto fail;
    }
    for (int c = 0; c < from->channels; c++)
        weft_require(log, plane[c]);
    res = WEFT_OK;
fail:
    return res;
}

bool weft_resample_report_step(void *priv, double fraction)
{
    const struct weft_resample_steps *s = priv;
    return !s->outer || !s->outer->report ||
           s->outer->report(s->outer->priv, (s->step + fraction) / s->steps);
}

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

void weft_resample_work_add(struct weft_resample_work *sum, const struct weft_resample_work *one)
{
    sum->tiles += one->tiles;
    sum->cpu = one->cpu;
    sum->prepare_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->source_bytes = larger(sum->source_bytes, one->source_bytes);
    sum->tile_bytes = larger(sum->tile_bytes, one->tile_bytes);
    sum->target_bytes = larger(sum->target_bytes, one->target_bytes);
    sum->position_bytes = larger(sum->position_bytes, one->position_bytes);
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = larger(sum->peak_bytes, one->peak_bytes);
    sum->draws += one->draws;
    sum->first_axis = one->draws ? one->first_axis : sum->first_axis;
    sum->fetches_per_pixel = fmax(sum->fetches_per_pixel, one->fetches_per_pixel);
}
