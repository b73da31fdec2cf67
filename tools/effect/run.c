// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/run.h"

// What one frame's callback draws.
struct drawn {
    scene_drawing *drawing;
    struct scene_frame show;
};

static enum weft_result draw(void *priv, int64_t index, const struct weft_draw_target *target)
{
    (void)index;
    const struct drawn *drawn = priv;
    return scene_drawing_draw(drawn->drawing, &drawn->show, target);
}

static enum weft_result add(const struct effect_run_params *params, int64_t index)
{
    const struct effect_frame *frame = &params->plan->frames[index];
    struct drawn drawn = {params->drawing[frame->scene], frame->show};
    drawn.show.clamped_share = params->clamped_share;
    const struct weft_frame source = {.draw = draw, .priv = &drawn};
    return weft_accumulator_add(params->accumulator, &source, frame->weight);
}

static bool goes_on(const struct weft_progress *progress, int64_t done, int64_t count)
{
    return !progress || !progress->report ||
           progress->report(progress->priv, (double)done / (double)count);
}

enum weft_result effect_run(const struct effect_run_params *params, int64_t *added)
{
    const int64_t left = params->plan->count - params->first;
    const int64_t count = params->count ? params->count : left;
    enum weft_result res = WEFT_OK;
    int64_t done = 0;
    if (params->first < 0 || count < 1 || count > left)
        res = WEFT_ERR_ARGUMENT;
    while (res == WEFT_OK && done < count) {
        res = goes_on(params->progress, done, count) ? add(params, params->first + done)
                                                     : WEFT_ERR_CANCELLED;
        done += res == WEFT_OK;
    }
    if (res == WEFT_OK && !goes_on(params->progress, done, count))
        res = WEFT_ERR_CANCELLED;
    if (added)
        *added = done;
    return res;
}
