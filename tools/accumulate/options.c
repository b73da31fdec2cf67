// SPDX-License-Identifier: BSD-3-Clause
// The options of `weft accumulate`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"
#include "tools/methods/engine_options.h"

static bool is_given(const struct accumulate_job *job, enum accumulate_option option)
{
    return job->option[option].given;
}

// ---- what contradicts what ----------------------------------------------------------------------

// Bits of the methods that have an option.
enum { EXACT = 1, TREE = 2, BUFFER = 4, BLEND = 8, FLOAT = 16 };
static const struct {
    enum accumulate_option option;
    const char *name;
    unsigned methods;
    const char *text;
} method_options[] = {
    {ACCUMULATE_BRANCHING, "--branching", TREE, "tree"},
    {ACCUMULATE_ROUNDING, "--rounding", TREE, "tree"},
    {ACCUMULATE_BITS, "--bits", TREE | BUFFER | BLEND, "tree, buffer or blend"},
    {ACCUMULATE_SOURCE_RANGE, "--source-range", TREE | BUFFER | BLEND, "tree, buffer or blend"},
    {ACCUMULATE_CONTEXT, "--context", TREE | BLEND | FLOAT, "tree, blend or float"},
    {ACCUMULATE_EMULATE, "--emulate", TREE | BLEND | FLOAT, "tree, blend or float"},
};

// An option that is of other methods than the one asked for.
static const char *method_conflict(const struct accumulate_job *job, char text[ACCUMULATE_TEXT])
{
    const enum weft_accumulate_method method = job->request.method;
    const unsigned bit = method == WEFT_ACCUMULATE_AUTO ? 0 : 1u << (method - 1);
    for (size_t i = 0; i < sizeof method_options / sizeof *method_options; i++) {
        if (!is_given(job, method_options[i].option) || (method_options[i].methods & bit))
            continue;
        snprintf(text, ACCUMULATE_TEXT, "%s needs --method %s", method_options[i].name,
                 method_options[i].text);
        return text;
    }
    if (job->request.bits == WEFT_ACCUMULATE_HALF && method != WEFT_ACCUMULATE_BLEND)
        return "--bits half needs --method blend";
    if (is_given(job, ACCUMULATE_SOURCE_RANGE) && job->request.bits > 16)
        return "--source-range is of targets of 8 and 16 bits: floats need none";
    if (job->request.nonfinite == WEFT_NONFINITE_SKIP && bit & ~(unsigned)EXACT)
        return "--nonfinite skip needs --method exact";
    return NULL;
}

const char *accumulate_conflict(const struct accumulate_job *job, char text[ACCUMULATE_TEXT])
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
    if (!is_given(job, ACCUMULATE_STDERR) && !is_given(job, ACCUMULATE_UNTIL) &&
        is_given(job, ACCUMULATE_BATCH))
        return "--batch is of the standard error: it needs --stderr or --until";
    if (!is_given(job, ACCUMULATE_OUTPUT) && !is_given(job, ACCUMULATE_STDERR) &&
        !is_given(job, ACCUMULATE_PREVIEW) && !is_given(job, ACCUMULATE_EXPLAIN) &&
        !is_given(job, ACCUMULATE_JSON) && !is_given(job, ACCUMULATE_RESUME))
        return "nothing to do: give -o OUT.exr, --stderr OUT.exr, --preview OUT.png, --resume "
               "STATE, --json or --explain";
    return method_conflict(job, text);
}

// ---- single options -----------------------------------------------------------------------------

static enum weft_result fail_branching(const char *text, const char *why)
{
    report_error("--branching %s: %s; it is the inputs of a node, 2 to %d, or of each level's "
                 "nodes from the frames up, as 2x4x4, at most %d levels",
                 text, why, WEFT_TREE_MAX_INPUTS, WEFT_TREE_MAX_LEVELS);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_branching(const struct option_value *o, struct accumulate_request *out)
{
    int levels = 0;
    char why[64];
    for (const char *at = o->text; o->given; at++) {
        const size_t length = strspn(at, "0123456789");
        const long inputs = length && length < 9 ? strtol(at, NULL, 10) : -1;
        if (!length || (at[length] && at[length] != 'x'))
            return fail_branching(o->text, "not a whole number, or several with x between them");
        snprintf(why, sizeof why, "a node cannot have %.*s inputs",
                 (int)(length < 20 ? length : 20), at);
        if (inputs < 2 || inputs > WEFT_TREE_MAX_INPUTS)
            return fail_branching(o->text, why);
        if (levels == WEFT_TREE_MAX_LEVELS)
            return fail_branching(o->text, "too many levels");
        out->level_branching[levels++] = (int)inputs;
        at += length;
        if (!*at)
            break;
    }
    if (levels == 1) {
        out->branching = out->level_branching[0];
        out->level_branching[0] = 0;
    }
    return WEFT_OK;
}

static enum weft_result read_whole(const struct option_value *o, const char *name, int64_t least,
                                   int64_t most, int *out)
{
    const double n = o->number[0];
    if (o->given && !(n >= (double)least && n <= (double)most && n == floor(n))) {
        report_error("--%s %s: not a whole number from %lld to %lld", name, o->text,
                     (long long)least, (long long)most);
        return WEFT_ERR_ARGUMENT;
    }
    *out = (int)n;
    return WEFT_OK;
}

static enum weft_result read_range(const struct option_value *o, struct accumulate_request *out)
{
    if (!o->given)
        return WEFT_OK;
    out->low = o->number[0];
    out->high = o->number[1];
    if (out->low < out->high)
        return WEFT_OK;
    report_error("--source-range %s: LO must be less than HI", o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_max_error(const struct option_value *o, struct accumulate_request *out)
{
    out->max_error = o->number[0];
    if (!o->given || out->max_error > 0.0)
        return WEFT_OK;
    report_error("--max-error %s: it must be above 0", o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_transfer(const struct option_value *o, struct accumulate_transfer *out)
{
    char *end;
    *out = (struct accumulate_transfer){.curve = ACCUMULATE_CURVE_AUTO};
    if (!o->given || strcmp(o->text, "auto") == 0)
        return WEFT_OK;
    out->curve = strcmp(o->text, "linear") == 0 ? ACCUMULATE_CURVE_LINEAR
                 : strcmp(o->text, "srgb") == 0 ? ACCUMULATE_CURVE_SRGB
                                                : ACCUMULATE_CURVE_POWER;
    if (out->curve != ACCUMULATE_CURVE_POWER)
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

// ---- --until ------------------------------------------------------------------------------------

static enum weft_result fail_until(const char *text, const char *item, int length)
{
    report_error("--until %s: '%.*s' is not a standard error above 0, one relative to the mean as "
                 "2%%, share=95%%, least=N (frames, from 2) or radius=N (pixels, 0 to 64)",
                 text, length, item);
    return WEFT_ERR_ARGUMENT;
}

// A number, or a percentage, that is all of an item.
static bool read_amount(const char *text, size_t length, double *out, bool *percent)
{
    char copy[64], *end;
    if (length == 0 || length >= sizeof copy || strspn(text, "0123456789.eE+-%") < length)
        return false;
    memcpy(copy, text, length);
    copy[length] = 0;
    *out = strtod(copy, &end);
    *percent = *end == '%';
    if (*percent)
        *out *= 0.01;
    return end != copy && !end[*percent] && isfinite(*out);
}

static bool read_until_item(const char *item, size_t length, struct weft_until *out)
{
    double value;
    bool percent;
    const char *equals = memchr(item, '=', length);
    const size_t name = equals ? (size_t)(equals - item) : 0, start = equals ? name + 1 : 0;
    if (!read_amount(item + start, length - start, &value, &percent) || value < 0.0)
        return false;
    const bool whole = !percent && value == floor(value);
    if (!equals && percent)
        out->relative = value;
    else if (!equals)
        out->absolute = value;
    else if (name == 5 && memcmp(item, "share", 5) == 0)
        out->share = value;
    else if (name == 5 && memcmp(item, "least", 5) == 0)
        out->least = whole && value <= WEFT_ACCUMULATE_MAX_FRAMES ? (int64_t)value : 1;
    else if (name == 6 && memcmp(item, "radius", 6) == 0)
        out->radius = !whole || value > 64 ? -2 : value > 0.0 ? (int)value : -1;
    else
        return false;
    return (equals || value > 0.0) && out->share <= 1.0 && out->least != 1 && out->radius >= -1 &&
           (!equals || value > 0.0 || name == 6);
}

static enum weft_result read_until(const struct option_value *o, struct weft_until *out)
{
    for (const char *at = o->text; o->given;) {
        const size_t length = strcspn(at, ",");
        if (!read_until_item(at, length, out))
            return fail_until(o->text, at, (int)length);
        at += length;
        if (!*at++)
            break;
    }
    if (!o->given || out->absolute > 0.0 || out->relative > 0.0)
        return WEFT_OK;
    report_error("--until %s: neither a standard error, as 0.001, nor one relative to the mean, as "
                 "2%%",
                 o->text);
    return WEFT_ERR_ARGUMENT;
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result read_choices(struct accumulate_job *job)
{
    static const int bits[] = {8, 16, 32, WEFT_ACCUMULATE_HALF};
    const struct option_value *o = job->option;
    struct accumulate_request *r = &job->request;
    r->method = (enum weft_accumulate_method)o[ACCUMULATE_METHOD].integer[0];
    r->rounding = (enum weft_tree_rounding)o[ACCUMULATE_ROUNDING].integer[0];
    r->nonfinite = (enum weft_accumulate_nonfinite)o[ACCUMULATE_NONFINITE].integer[0];
    r->bits = o[ACCUMULATE_BITS].given ? bits[o[ACCUMULATE_BITS].integer[0]] : 0;
    return o[ACCUMULATE_CONTEXT].given
               ? weft_context_kind_parse(report_log(), o[ACCUMULATE_CONTEXT].text, &r->context)
               : WEFT_OK;
}

enum weft_result accumulate_read_options(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    struct accumulate_request *r = &job->request;
    const struct preview_options preview = {.range = &o[ACCUMULATE_RANGE],
                                            .colour_map = &o[ACCUMULATE_COLOUR_MAP]};
    char text[ACCUMULATE_TEXT];
    enum weft_result res = read_choices(job);
    const char *conflict = res == WEFT_OK ? accumulate_conflict(job, text) : NULL;
    if (conflict) {
        report_error("%s", conflict);
        res = WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK)
        res = read_branching(&o[ACCUMULATE_BRANCHING], r);
    if (res == WEFT_OK)
        res = read_range(&o[ACCUMULATE_SOURCE_RANGE], r);
    if (res == WEFT_OK)
        res = read_max_error(&o[ACCUMULATE_MAX_ERROR], r);
    if (res == WEFT_OK)
        res = read_until(&o[ACCUMULATE_UNTIL], &r->until);
    if (res == WEFT_OK)
        res = read_transfer(&o[ACCUMULATE_TRANSFER], &r->transfer);
    if (res == WEFT_OK)
        res = read_whole(&o[ACCUMULATE_BATCH], "batch", 1, WEFT_ACCUMULATE_MAX_FRAMES, &r->batch);
    if (res == WEFT_OK)
        res = read_whole(&o[ACCUMULATE_THREADS], "threads", 1, WEFT_CPU_MAX_THREADS, &r->threads);
    return res == WEFT_OK ? preview_check(&preview, &r->colour_map) : res;
}
