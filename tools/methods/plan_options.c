// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/plan_options.h"

#include "tools/options/kernels.h"
#include "tools/common/report.h"

const char *const plan_dims_choices[] = {"2", "3", NULL};
const char *const plan_channels_choices[] = {"1", "4", NULL};

enum weft_result plan_options_read(const struct option_value *o, struct weft_pass_plan_params *p,
                                   weft_kernel_file **file)
{
    p->dims = o[PLAN_DIMS].given ? (int)o[PLAN_DIMS].integer[0] + 2 : 2;
    p->round_singly = o[PLAN_ROUND_SINGLY].given;
    p->single_bias = o[PLAN_SINGLE_BIAS].given;
    p->no_scale = o[PLAN_NO_SCALE].given;
    p->blend_only = o[PLAN_BLEND_ONLY].given;
    p->channels = o[PLAN_CHANNELS].integer[0] ? 4 : 1;
    p->memory_bytes = (uint64_t)o[PLAN_MEMORY].integer[0];
    enum weft_result res = pass_options_read(&o[PLAN_PASSES], NULL, p);
    if (res == WEFT_OK && o[PLAN_DERIVATIVE].given)
        res = weft_derivative_parse(report_log(), o[PLAN_DERIVATIVE].text, &p->derivative);
    if (res == WEFT_OK && p->derivative.along[2] && p->dims < 3) {
        report_error("--derivative %s needs --dims 3", o[PLAN_DERIVATIVE].text);
        return WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK && o[PLAN_KERNEL].given)
        res = kernels_load(o[PLAN_KERNEL].text, &p->kernel, file);
    return res;
}
