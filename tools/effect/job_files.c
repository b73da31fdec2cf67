// SPDX-License-Identifier: BSD-3-Clause
// Where `weft effect` writes.
#include "tools/common/paths.h"
#include "tools/effect/job.h"

enum { OUTPUTS = 3 };

enum weft_result effect_job_check_outputs(struct effect_job *job)
{
    const struct option_value *o = job->option; // paths are NULL unless they are given
    const struct paths_output output[OUTPUTS] = {{"-o", o[ASK_OUTPUT].text},
                                                 {"--stderr", o[ASK_STDERR].text},
                                                 {"--preview", o[ASK_PREVIEW].text}};
    const char *input[EFFECT_MAX_SCENES + 1] = {o[ASK_SCENES + SCENE_OPTION_KEYFRAMES].text};
    for (int i = 0; i < job->scene_count; i++)
        input[1 + i] = job->scene[i].name;
    enum weft_result res = paths_check_distinct(output, OUTPUTS, input, 1 + job->scene_count);
    for (int i = 0; i < OUTPUTS && res == WEFT_OK && !o[ASK_EXPLAIN].given; i++)
        if (output[i].path)
            res = paths_check_output(output[i].path, o[ASK_NO_CLOBBER].given);
    return res;
}
