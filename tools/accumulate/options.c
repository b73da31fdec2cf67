// SPDX-License-Identifier: BSD-3-Clause
// The options of `weft accumulate`.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"
#include "tools/ranks/ranks.h"

static bool is_given(const struct accumulate_job *job, enum accumulate_option option)
{
    return job->option[option].given;
}

// ---- what contradicts what ----------------------------------------------------------------------

static const char *find_conflict(const struct accumulate_job *job)
{
    if (!job->operands[0])
        return "no frames given: weft accumulate FRAMES... -o OUT.exr (see weft help accumulate)";
    if (is_given(job, ACCUMULATE_QUIET) && is_given(job, ACCUMULATE_VERBOSE))
        return "-q and -v exclude each other";
    if (!is_given(job, ACCUMULATE_PREVIEW) &&
        (is_given(job, ACCUMULATE_RANGE) || is_given(job, ACCUMULATE_COLOUR_MAP)))
        return "--range and --colour-map need --preview OUT.png";
    if (!is_given(job, ACCUMULATE_OUTPUT) && is_given(job, ACCUMULATE_TYPE))
        return "--type needs -o OUT.exr";
    if (!is_given(job, ACCUMULATE_OUTPUT) && !is_given(job, ACCUMULATE_STDERR) &&
        is_given(job, ACCUMULATE_COMPRESSION))
        return "--compression needs -o OUT.exr or --stderr OUT.exr";
    if (!is_given(job, ACCUMULATE_OUTPUT) && !is_given(job, ACCUMULATE_STDERR) &&
        !is_given(job, ACCUMULATE_PREVIEW) && !is_given(job, ACCUMULATE_EXPLAIN) &&
        !is_given(job, ACCUMULATE_JSON) && !is_given(job, ACCUMULATE_RESUME))
        return "nothing to do: give -o OUT.exr, --stderr OUT.exr, --preview OUT.png, --resume "
               "STATE, --json or --explain";
    return NULL;
}

static enum weft_result check_conflicts(const struct accumulate_job *job)
{
    const struct preview_options preview = accumulate_preview_options(job);
    const char *conflict = find_conflict(job);
    if (!conflict)
        conflict = preview_conflict(&preview, is_given(job, ACCUMULATE_PREVIEW));
    if (conflict)
        report_error("%s", conflict);
    return conflict ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

// ---- single options -----------------------------------------------------------------------------

static enum weft_result read_nonfinite(const struct option_value *o, struct accumulate_request *out)
{
    out->nonfinite = (enum weft_accumulate_nonfinite)o->integer[0];
    if (out->nonfinite != WEFT_NONFINITE_SKIP || out->how.method == WEFT_ACCUMULATE_AUTO ||
        out->how.method == WEFT_ACCUMULATE_EXACT)
        return WEFT_OK;
    report_error("--nonfinite skip needs --method exact");
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_transfer(const struct option_value *o, struct weft_transfer *out)
{
    char *end;
    *out = (struct weft_transfer){.curve = WEFT_CURVE_AUTO};
    if (!o->given || strcmp(o->text, "auto") == 0)
        return WEFT_OK;
    out->curve = strcmp(o->text, "linear") == 0 ? WEFT_CURVE_LINEAR
                 : strcmp(o->text, "srgb") == 0 ? WEFT_CURVE_SRGB
                                                : WEFT_CURVE_POWER;
    if (out->curve != WEFT_CURVE_POWER)
        return WEFT_OK;
    if (strncmp(o->text, "gamma:", 6) == 0) {
        out->exponent = strtod(o->text + 6, &end);
        if (end != o->text + 6 && !*end && out->exponent >= 0.1 && out->exponent <= 10.0)
            return WEFT_OK;
    }
    report_error("--transfer %s: not auto, linear, srgb, or gamma:G with G from 0.1 to 10, as "
                 "gamma:2.2, by which light is code ^ G",
                 o->text);
    return WEFT_ERR_ARGUMENT;
}

// Samples are whole in the blocks that ranks are given, if no frame is missing from them.
static enum weft_result read_ranks(struct accumulate_job *job)
{
    const struct accumulate_request *r = &job->request;
    struct accumulate_divided *d = &job->divided;
    enum weft_result res = rank_options_read(&job->option[ACCUMULATE_RANKS], &d->request);
    d->is =
        (ranks_size() > 1 || d->request.given) && !job->joins && !is_given(job, ACCUMULATE_EXPLAIN);
    if (res != WEFT_OK || !d->is)
        return res;
    if (r->how.batch > 1 && is_given(job, ACCUMULATE_SKIP_BAD)) {
        report_error("--batch and --skip-bad exclude each other on several ranks: a frame that is "
                     "left out would move the samples behind it, which other ranks have");
        return WEFT_ERR_ARGUMENT;
    }
    return rank_frames_check(&d->request, r->how.method);
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result accumulate_read_options(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    struct accumulate_request *r = &job->request;
    const struct preview_options preview = accumulate_preview_options(job);
    enum weft_result res = check_conflicts(job);
    if (res == WEFT_OK)
        res = accumulation_read(&o[ACCUMULATE_ADDING],
                                is_given(job, ACCUMULATE_STDERR) ? ACCUMULATION_TELLS_ERROR : 0,
                                &r->how);
    if (res == WEFT_OK && !r->how.threads)
        r->how.threads = ranks_threads();
    if (res == WEFT_OK)
        res = read_ranks(job);
    if (res == WEFT_OK)
        res = read_nonfinite(&o[ACCUMULATE_NONFINITE], r);
    if (res == WEFT_OK)
        res = read_transfer(&o[ACCUMULATE_TRANSFER], &r->transfer);
    return res == WEFT_OK ? preview_check(&preview, &r->colour_map) : res;
}
