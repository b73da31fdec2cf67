// SPDX-License-Identifier: BSD-3-Clause
// The accumulator of `weft accumulate`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"

static enum weft_result create_context(struct accumulate_job *job)
{
    const double start = report_now_seconds();
    if (!accumulation_draws(job->request.how.method) || job->request.how.emulate ||
        job->option[ACCUMULATE_EXPLAIN].given)
        return WEFT_OK;
    const enum weft_result res = weft_context_create(
        weft_context_params(.kind = job->request.how.context, .log = report_log()), &job->context);
    job->context_seconds = report_now_seconds() - start;
    return res;
}

// What a frame's fault is goes to job->message, to be told with the frame's name.
static void tell(void *priv, enum weft_log_level level, const char *message)
{
    struct accumulate_job *job = priv;
    if (job->adding && level == WEFT_LOG_ERROR)
        snprintf(job->message, sizeof job->message, "%s", message);
    else
        report_log()->write(report_log()->priv, level, message);
}

static double *copy_weights(const struct accumulate_job *job)
{
    double *weight = malloc((size_t)job->counting * sizeof *weight);
    for (int64_t i = 0; weight && i < job->counting; i++)
        weight[i] = job->frame[job->sequence[i]].weight;
    return weight;
}

// Whether which frames will come is said beforehand. Where some may be left out, methods that make
// use of it keep running means. Where others may come in a later run, those that need not know are
// not told.
static bool is_known(const struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    const enum weft_accumulate_method method = job->request.how.method;
    const bool grows = job->joins || o[ACCUMULATE_RESUME].given;
    return !o[ACCUMULATE_SKIP_BAD].given && !o[ACCUMULATE_UNTIL].given &&
           !(grows && method != WEFT_ACCUMULATE_BLEND && method != WEFT_ACCUMULATE_BUFFER);
}

enum weft_result accumulate_create(struct accumulate_job *job, weft_accumulator **out)
{
    const struct option_value *o = job->option;
    const struct accumulate_request *r = &job->request;
    const bool known = is_known(job);
    double *weight = copy_weights(job);
    if (!weight) {
        report_error("out of memory for %lld weights", (long long)job->counting);
        return WEFT_ERR_MEMORY;
    }
    job->log = (struct weft_log){tell, job};
    struct weft_accumulator_params params = {
        .width = job->image.width,
        .height = job->image.height,
        .channel_count = job->averaged_count,
        .frame_count = known ? job->counting : 0,
        .weight = known ? weight : NULL,
        .nonfinite = r->nonfinite,
        .part = job->divided.is,
        .keep = job->keeps_variance ? WEFT_KEEP_VARIANCE : 0,
        .context = job->context,
        .log = &job->log,
    };
    accumulation_set(&r->how, &params);
    params.emulate = r->how.emulate || o[ACCUMULATE_EXPLAIN].given;
    const enum weft_result res = weft_accumulator_create(&params, out);
    free(weight);
    return res;
}

enum weft_result accumulate_check_bound(struct accumulate_job *job, double bound)
{
    const enum weft_result res =
        accumulation_check_bound(&job->request.how, job->planned.method, bound);
    job->over_budget |= res != WEFT_OK;
    return res;
}

enum weft_result accumulate_begin(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    if (!job->joins)
        job->keeps_variance = o[ACCUMULATE_STDERR].given || o[ACCUMULATE_UNTIL].given;
    enum weft_result res = accumulation_check_branching(
        &job->request.how, o[ACCUMULATE_ADDING + ACCUMULATION_BRANCHING].text, job->counting);
    if (res == WEFT_OK)
        res = create_context(job);
    if (res == WEFT_OK)
        res = accumulate_create(job, &job->accumulator);
    if (res != WEFT_OK) {
        job->over_budget = res == WEFT_ERR_UNSUPPORTED && job->request.how.max_error > 0.0 &&
                           job->request.how.method == WEFT_ACCUMULATE_AUTO;
        return res;
    }
    weft_accumulator_get_report(job->accumulator, &job->planned);
    // It is looked at again once the frames are known.
    return isfinite(job->planned.bound) ? accumulate_check_bound(job, job->planned.bound) : WEFT_OK;
}
