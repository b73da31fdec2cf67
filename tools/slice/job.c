// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/job.h"

#include "tools/slice/stages.h"

#include <stdlib.h>

uint64_t slice_memory(const struct slice_setup *setup)
{
    const struct option_value *memory = &setup->option[SLICE_MEMORY];
    return memory->given ? (uint64_t)memory->integer[0] : UINT64_C(1) << 30;
}

bool slice_writes_lines(const struct slice_job *job)
{
    return job->output != NULL;
}

bool slice_needs_pixels(const struct slice_job *job)
{
    return job->preview || (job->output && job->setup->option[SLICE_VERIFY].given);
}

void slice_release(struct slice_job *job)
{
    weft_choice_clear(&job->choice);
    weft_hardware_plan_destroy(&job->own_hardware);
    weft_slice_plan_destroy(&job->own_plan);
    job->plan = NULL;
    job->passes = NULL;
    job->hardware = NULL;
}

void slice_clear(struct slice_job *job)
{
    slice_release(job);
    slice_stream_end(job);
    json_decref(job->json);
    json_decref(job->outputs);
    free(job->channel);
    curve_clear(&job->curve);
    free(job->pixels);
    error_image_clear(&job->errors);
    for (int i = 0; i < job->band_count; i++)
        free((void *)(uintptr_t)job->bands[i].data);
    free(job->bands);
    for (int i = 0; i < 3; i++)
        free(job->numbered[i]);
}
