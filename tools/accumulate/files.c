// SPDX-License-Identifier: BSD-3-Clause
// What can be known of the files of `weft accumulate` before any is opened.
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "tools/accumulate/job.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

// ---- frames -------------------------------------------------------------------------------------

// Why a file is none that frames are read from; NULL: it may be one.
static const char *problem_of(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return strerror(errno);
    if (S_ISDIR(status.st_mode))
        return "it is a folder; name its files, as FOLDER/*.exr or FOLDER/%04d.exr";
    if (!S_ISREG(status.st_mode))
        return "it is no regular file";
    return NULL;
}

// Names the first that is not there, and tells how many are not.
enum weft_result accumulate_check_frames(struct accumulate_job *job)
{
    const char *first = NULL;
    char why[ACCUMULATE_TEXT] = "";
    int64_t problems = 0;
    if (job->joins || job->option[ACCUMULATE_SKIP_BAD].given)
        return WEFT_OK;
    for (int64_t i = 0; i < job->counting; i++) {
        const char *path = job->frame[job->sequence[i]].path;
        const char *problem = problem_of(path);
        if (problem && !first) {
            first = path;
            snprintf(why, sizeof why, "%s", problem);
        }
        problems += problem != NULL;
    }
    if (problems == 1)
        report_error("%s cannot be read: %s", first, why);
    else if (problems)
        report_error("%s cannot be read: %s; nor can %lld others of %lld frames (--skip-bad goes "
                     "on without them)",
                     first, why, (long long)problems - 1, (long long)job->counting);
    return problems ? WEFT_ERR_OPEN : WEFT_OK;
}

// ---- outputs ------------------------------------------------------------------------------------

struct output {
    const char *option, *path;
    bool goes_on; // from what is there
    struct paths_identity identity;
};
enum { OUTPUTS = 4 };

static size_t list_outputs(const struct accumulate_job *job, struct output out[OUTPUTS])
{
    static const struct {
        enum accumulate_option option;
        const char *name;
    } outputs[OUTPUTS] = {{ACCUMULATE_OUTPUT, "-o"},
                          {ACCUMULATE_STDERR, "--stderr"},
                          {ACCUMULATE_PREVIEW, "--preview"},
                          {ACCUMULATE_RESUME, "--resume"}};
    size_t count = 0;
    for (int i = 0; i < OUTPUTS; i++) {
        const struct option_value *value = &job->option[outputs[i].option];
        if (value->given)
            out[count++] = (struct output){outputs[i].name, value->text,
                                           outputs[i].option == ACCUMULATE_RESUME,
                                           paths_identify(value->text)};
    }
    return count;
}

static enum weft_result check_input(const struct output *output, size_t count, const char *path)
{
    const struct paths_identity input = paths_identify(path);
    for (size_t i = 0; i < count; i++) {
        if (paths_compare(&output[i].identity, &input) != 0)
            continue;
        report_error("the output %s is the input %s", output[i].path, path);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result accumulate_check_outputs(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    struct output output[OUTPUTS];
    const size_t count = list_outputs(job, output);
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < i; j++) {
            if (paths_compare(&output[i].identity, &output[j].identity) != 0)
                continue;
            report_error("%s %s and %s %s are the same file", output[j].option, output[j].path,
                         output[i].option, output[i].path);
            return WEFT_ERR_ARGUMENT;
        }
    }
    for (int64_t i = 0; i < job->frame_count && res == WEFT_OK; i++)
        res = check_input(output, count, job->frame[i].path);
    for (int i = 0; job->joins && job->operands[i] && res == WEFT_OK; i++)
        res = check_input(output, count, job->operands[i]);
    if (res == WEFT_OK && o[ACCUMULATE_WEIGHTS].given)
        res = check_input(output, count, o[ACCUMULATE_WEIGHTS].text);
    for (size_t i = 0; i < count && res == WEFT_OK && !o[ACCUMULATE_EXPLAIN].given; i++)
        res = paths_check_output(output[i].path,
                                 o[ACCUMULATE_NO_CLOBBER].given && !output[i].goes_on);
    return res;
}
