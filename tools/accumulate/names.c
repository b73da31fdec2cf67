// SPDX-License-Identifier: BSD-3-Clause
// The frames of `weft accumulate`: operands become names.
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"

static enum weft_result add_name(struct accumulate_job *job, const char *path)
{
    const size_t size = (size_t)job->frame_count + 1;
    struct accumulate_frame *list = realloc(job->frame, size * sizeof *list);
    char *copy = list ? strdup(path) : NULL;
    if (list)
        job->frame = list;
    if (!copy) {
        report_error("out of memory for the names of %zu frames", size);
        return WEFT_ERR_MEMORY;
    }
    job->frame[job->frame_count++] = (struct accumulate_frame){.path = copy, .weight = 1.0};
    return WEFT_OK;
}

enum weft_result accumulate_list_frames(struct accumulate_job *job)
{
    enum weft_result res = WEFT_OK;
    for (const char *const *operand = job->operands; *operand && res == WEFT_OK; operand++)
        res = add_name(job, *operand);
    return res;
}

enum weft_result accumulate_check_files(const struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    const char *output = o[ACCUMULATE_OUTPUT].text;
    for (int64_t i = 0; output && i < job->frame_count; i++) {
        if (paths_same_file(output, job->frame[i].path)) {
            report_error("the output %s is the input %s", output, job->frame[i].path);
            return WEFT_ERR_ARGUMENT;
        }
    }
    return output && !o[ACCUMULATE_EXPLAIN].given
               ? paths_check_output(output, o[ACCUMULATE_NO_CLOBBER].given)
               : WEFT_OK;
}
