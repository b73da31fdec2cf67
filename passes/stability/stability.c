// SPDX-License-Identifier: BSD-3-Clause
#include "passes/stability/stability.h"

#include <math.h>
#include <string.h>

#include "passes/stability/cases.h"

const struct weft_stability_case *const weft_stability_list[] = {
    &weft_stability_order_2d,      &weft_stability_order_3d,
    &weft_stability_gradient_bias, &weft_stability_ripple_2d,
    &weft_stability_ripple_3d,     &weft_stability_blend_8,
    &weft_stability_mean_8,        &weft_stability_half_sum,
    &weft_stability_buffer_16,     &weft_stability_tree_bias,
    &weft_stability_float_mean,    &weft_stability_srgb_mean,
    &weft_stability_id_mean,       &weft_stability_nan_frame,
    &weft_stability_jitter_shift,  &weft_stability_few_frames,
    &weft_stability_lens_outside,  &weft_stability_light_corner,
    &weft_stability_drawn_twice,   &weft_stability_shader_apart,
    &weft_stability_edge_ids,      &weft_stability_own_frustum,
    &weft_stability_bright_sum,    &weft_stability_half_passes,
    &weft_stability_half_overflow, &weft_stability_filter_weights,
    &weft_stability_texel_centres, &weft_stability_same_size,
    &weft_stability_odd_width,     &weft_stability_far_away,
    &weft_stability_one_voxel,     &weft_stability_wide_kernel,
    &weft_stability_wide_range,    &weft_stability_no_data,
    &weft_stability_not_finite,    &weft_stability_zero_weight,
    &weft_stability_ringing,       NULL,
};

const struct weft_stability_case *weft_stability_find(const char *name)
{
    for (int i = 0; weft_stability_list[i]; i++)
        if (strcmp(weft_stability_list[i]->name, name) == 0)
            return weft_stability_list[i];
    return NULL;
}

const char *weft_stability_verdict_text(enum weft_stability_verdict verdict)
{
    static const char *const texts[] = {
        [WEFT_STABILITY_HOLDS] = "holds",
        [WEFT_STABILITY_OURS_FAILS] = "ours fails",
        [WEFT_STABILITY_NAIVE_HOLDS_TOO] = "naive holds too",
        [WEFT_STABILITY_SKIPPED] = "skipped",
    };
    return (size_t)verdict < WEFT_COUNT(texts) ? texts[verdict] : "unknown";
}

// A NAN of ours fails, one of the naive way is beyond any limit.
static enum weft_stability_verdict judge(const struct weft_stability_result *r)
{
    if (!(r->ours <= r->limit))
        return WEFT_STABILITY_OURS_FAILS;
    return r->naive <= r->limit ? WEFT_STABILITY_NAIVE_HOLDS_TOO : WEFT_STABILITY_HOLDS;
}

enum weft_result weft_stability_run(const struct weft_stability_case *subject,
                                    const struct weft_stability_params *params,
                                    struct weft_stability_result *result)
{
    *result = (struct weft_stability_result){.verdict = WEFT_STABILITY_SKIPPED,
                                             .naive = (double)NAN,
                                             .ours = (double)NAN,
                                             .limit = (double)NAN};
    if (subject->needs_context && !params->context) {
        weft_stability_say(result, "", "it needs an OpenGL context");
        return WEFT_OK;
    }
    const enum weft_result res = subject->measure(params, result);
    if (res == WEFT_OK)
        result->verdict = judge(result);
    return res;
}
