// SPDX-License-Identifier: BSD-3-Clause
// What the self-check of accumulative anti-aliasing found in the pictures of `weft antialias`.
#include <stdio.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"

static void place(const struct antialias_job *job, int64_t count, const int32_t at[2], int out[2])
{
    out[0] = count ? at[0] : -1;
    out[1] = count ? job->params.size[1] - 1 - at[1] : -1;
}

void antialias_job_add_weights(struct antialias_job *job, int frame)
{
    const struct weft_acaa_report *r = &job->report.acaa;
    struct antialias_weights *w = &job->weights;
    if (job->params.way != ANTIALIAS_ACAA || (r->less == 0 && r->more == 0))
        return;
    if (w->frames++ == 0) {
        w->first_frame = frame;
        place(job, r->less, r->first_less, w->first_less);
        place(job, r->more, r->first_more, w->first_more);
    }
    w->less += r->less;
    w->more += r->more;
    w->largest = r->largest > w->largest ? r->largest : w->largest;
}

// ", 12 less (the first at 3,4)".
static void tell(char text[ANTIALIAS_TEXT], int64_t count, const char *what, const int at[2])
{
    const size_t used = strlen(text);
    if (count && at[0] >= 0)
        snprintf(text + used, ANTIALIAS_TEXT - used, ", %lld have %s, the first at %d,%d",
                 (long long)count, what, at[0], at[1]);
    else if (count)
        snprintf(text + used, ANTIALIAS_TEXT - used, ", %lld have %s", (long long)count, what);
}

bool antialias_job_check_weights(const struct antialias_job *job)
{
    const struct antialias_weights *w = &job->weights;
    char text[ANTIALIAS_TEXT], frames[64] = "";
    if (w->frames == 0)
        return true;
    snprintf(text, sizeof text, "%lld pixels have not the weight of their %d samples",
             (long long)(w->less + w->more), job->report.samples);
    tell(text, w->less, "less", w->first_less);
    tell(text, w->more, "more", w->first_more);
    if (job->frames > 1)
        snprintf(frames, sizeof frames, " of picture %d, in %d of %d pictures", w->first_frame,
                 w->frames, job->frames);
    if (job->option[ASK_ALLOW_WEIGHT].given) {
        report_warning("%s%s; by up to %.3g of it", text, frames, w->largest);
        return true;
    }
    report_error("%s%s; by up to %.3g of it: --allow-weight takes that, --weight-map shows it",
                 text, frames, w->largest);
    return false;
}
