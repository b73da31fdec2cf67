// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/stages.h"

#include <stdlib.h>

#include "tools/slice/budget.h"

// What a method costs depends on where it would run.
static enum weft_result create_context_for_choice(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    return o[SLICE_MAX_ERROR].given && !o[SLICE_EXPLAIN].given ? slice_create_context(job)
                                                               : WEFT_OK;
}

// A volume that cannot be opened is reported before any GL context is made.
enum weft_result slice_make(struct slice_job *job)
{
    typedef enum weft_result (*stage)(struct slice_job * job);
    static const stage planning[] = {
        slice_open,   slice_place, slice_allocate, slice_plan, create_context_for_choice,
        slice_choose, NULL};
    static const stage computing[] = {slice_create_context, slice_run, slice_verify, slice_save,
                                      NULL};
    enum weft_result res = WEFT_OK;
    for (const stage *s = planning; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    if (job->setup->option[SLICE_EXPLAIN].given)
        return res;
    for (const stage *s = computing; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    return res;
}

void slice_clear(struct slice_job *job)
{
    free(job->pixels);
    weft_choice_clear(&job->choice);
    weft_pass_plan_destroy(&job->own_passes);
    weft_slice_plan_destroy(&job->own_plan);
    weft_volume_destroy(&job->volume);
}
