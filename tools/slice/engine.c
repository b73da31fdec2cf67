// SPDX-License-Identifier: BSD-3-Clause
// What filters slices: OpenGL or the CPU engine, as it is asked for, or as it turns out.
#include "tools/slice/stages.h"

#include "tools/common/report.h"

// What only OpenGL has.
static const char *find_gl_option(const struct option_value *o)
{
    return o[SLICE_PASSES + PASS_PROFILE].given ? "--profile"
           : o[SLICE_LAYOUT].given              ? "--layout"
           : o[SLICE_SOURCE].given              ? "--source"
           : o[SLICE_LOOKUP].given              ? "--lookup"
           : o[SLICE_HARDWARE].given            ? "--hardware"
                                                : NULL;
}

enum weft_result slice_read_engine(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    if (o[SLICE_MAX_ERROR].given && o[SLICE_ENGINE + ENGINE_SUMS].given) {
        report_error("--max-error chooses what --sums says");
        return WEFT_ERR_ARGUMENT;
    }
    return engine_options_read(&o[SLICE_ENGINE], find_gl_option(o), &setup->engine);
}

enum weft_result slice_create_context(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const double start = report_now_seconds();
    if (setup->context)
        return WEFT_OK;
    const enum weft_result res = engine_create_context(&setup->engine, &setup->context);
    job->context_seconds += report_now_seconds() - start;
    // Where a budget chooses, it does so from here on.
    return res == WEFT_OK && !setup->option[SLICE_MAX_ERROR].given ? slice_plan_anew(job) : res;
}
