// SPDX-License-Identifier: BSD-3-Clause
// What can be known of the files of `weft effect` before anything is read.
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/effect/job.h"

static const struct {
    enum effect_option option;
    const char *name;
} outputs[] = {{ASK_OUTPUT, "-o"}, {ASK_STDERR, "--stderr"}, {ASK_PREVIEW, "--preview"}};
enum { OUTPUTS = sizeof outputs / sizeof *outputs };

static const char *path_of(const struct effect_job *job, int output)
{
    return job->option[outputs[output].option].text; // NULL unless it is given
}

static enum weft_result check_input(const struct effect_job *job, const char *path)
{
    for (int i = 0; i < OUTPUTS; i++) {
        if (!path_of(job, i) || !paths_same_file(path_of(job, i), path))
            continue;
        report_error("the output %s is the input %s", path_of(job, i), path);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result check_each_other(const struct effect_job *job)
{
    for (int i = 0; i < OUTPUTS; i++)
        for (int j = 0; j < i; j++) {
            const char *a = path_of(job, j), *b = path_of(job, i);
            if (!a || !b || !paths_same_file(a, b))
                continue;
            report_error("%s %s and %s %s are the same file", outputs[j].name, a, outputs[i].name,
                         b);
            return WEFT_ERR_ARGUMENT;
        }
    return WEFT_OK;
}

enum weft_result effect_job_check_outputs(struct effect_job *job)
{
    const struct option_value *o = job->option;
    enum weft_result res = check_each_other(job);
    for (int i = 0; i < job->scene_count && res == WEFT_OK; i++)
        res = check_input(job, job->scene[i].name);
    if (res == WEFT_OK && o[ASK_SCENES + SCENE_OPTION_KEYFRAMES].given)
        res = check_input(job, o[ASK_SCENES + SCENE_OPTION_KEYFRAMES].text);
    for (int i = 0; i < OUTPUTS && res == WEFT_OK && !o[ASK_EXPLAIN].given; i++)
        if (path_of(job, i))
            res = paths_check_output(path_of(job, i), o[ASK_NO_CLOBBER].given);
    return res;
}
