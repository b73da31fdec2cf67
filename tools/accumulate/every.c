// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/every.h"

#include "tools/accumulate/state.h"
#include "tools/common/ending.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

static const enum accumulate_option outputs[] = {ACCUMULATE_OUTPUT, ACCUMULATE_STDERR,
                                                 ACCUMULATE_PREVIEW};
enum { OUTPUTS = sizeof outputs / sizeof *outputs };

// An output that is none that can be replaced: a pipe would get one image after another. NULL:
// none.
static const char *special_output(const struct accumulate_job *job)
{
    for (int i = 0; i < OUTPUTS; i++) {
        const struct option_value *value = &job->option[outputs[i]];
        if (value->given && paths_is_special(value->text))
            return value->text;
    }
    return NULL;
}

static bool has_output(const struct accumulate_job *job)
{
    for (int i = 0; i < OUTPUTS; i++)
        if (job->option[outputs[i]].given)
            return true;
    return false;
}

enum weft_result every_check(struct accumulate_job *job)
{
    const struct option_value *every = &job->option[ACCUMULATE_EVERY];
    const char *special = special_output(job);
    if (!every->given)
        return WEFT_OK;
    if (!(every->number[0] > 0.0))
        report_error("--every %s: seconds must be more than 0", every->text);
    else if (special)
        report_error("--every replaces outputs again and again, which %s cannot be", special);
    else if (!has_output(job))
        report_error("--every needs -o OUT.exr, --stderr OUT.exr or --preview OUT.png");
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

void every_begin(struct accumulate_job *job)
{
    job->every.at = report_now_seconds();
}

bool every_is_due(const struct accumulate_job *job)
{
    const struct option_value *every = &job->option[ACCUMULATE_EVERY];
    return ending_has_request() || (every->given && job->added > job->every.added &&
                                    report_now_seconds() - job->every.at >= every->number[0]);
}

static enum weft_result write_outputs(struct accumulate_job *job)
{
    struct report_held held = {.count = 0};
    job->writing = true;
    state_set_last_words(job);
    report_hold(&held);
    enum weft_result res = accumulate_make_result(job);
    if (res == WEFT_OK)
        res = accumulate_save(job);
    report_hold(NULL);
    job->writing = false;
    if (res == WEFT_OK)
        job->every.added = job->added;
    state_set_last_words(job);
    if (res != WEFT_OK)
        report_warning("the mean so far is not written: %s",
                       held.count ? held.line[held.count - 1] : weft_result_text(res));
    return res;
}

void every_write(struct accumulate_job *job)
{
    const bool requested = ending_take_request();
    const char *special = special_output(job);
    const char *what = "its mean is written";
    if (job->added == 0)
        what = "there is no mean yet";
    else if (special)
        what = "a pipe or device gets the mean of all alone";
    else if (!has_output(job))
        what = "there is no output to be written";
    else if (write_outputs(job) != WEFT_OK)
        what = NULL;
    if (what && requested)
        report_tell("%lld frames are accumulated, %lld are left: %s", (long long)job->added,
                    (long long)(job->counting - job->next), what);
    job->every.at = report_now_seconds();
}
