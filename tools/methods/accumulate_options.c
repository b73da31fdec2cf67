// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/accumulate_options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

const char *const accumulation_bits_choices[] = {"8", "16", "32", "half", NULL};

// ---- what contradicts what ----------------------------------------------------------------------

// Bits of the methods that have an option.
enum { EXACT = 1, TREE = 2, BUFFER = 4, BLEND = 8, FLOAT = 16 };
static const struct {
    enum accumulation_option option;
    const char *name;
    unsigned methods;
    const char *text;
} method_options[] = {
    {ACCUMULATION_BRANCHING, "--branching", TREE, "tree"},
    {ACCUMULATION_ROUNDING, "--rounding", TREE, "tree"},
    {ACCUMULATION_BITS, "--bits", TREE | BUFFER | BLEND, "tree, buffer or blend"},
    {ACCUMULATION_SOURCE_RANGE, "--source-range", TREE | BUFFER | BLEND, "tree, buffer or blend"},
    {ACCUMULATION_CONTEXT, "--context", TREE | BLEND | FLOAT, "tree, blend or float"},
    {ACCUMULATION_EMULATE, "--emulate", TREE | BLEND | FLOAT, "tree, blend or float"},
};

// An option that is of other methods than the one asked for.
static const char *method_conflict(const struct option_value *o, unsigned uses,
                                   const struct accumulation *a, char text[ACCUMULATION_TEXT])
{
    const unsigned bit = a->method == WEFT_ACCUMULATE_AUTO ? 0 : 1u << (a->method - 1);
    for (size_t i = 0; i < sizeof method_options / sizeof *method_options; i++) {
        const enum accumulation_option option = method_options[i].option;
        const bool drawn = option == ACCUMULATION_CONTEXT && (uses & ACCUMULATION_DRAWS_FRAMES);
        if (!o[option].given || drawn || (method_options[i].methods & bit))
            continue;
        snprintf(text, ACCUMULATION_TEXT, "%s needs --method %s", method_options[i].name,
                 method_options[i].text);
        return text;
    }
    if (a->bits == WEFT_ACCUMULATE_HALF && a->method != WEFT_ACCUMULATE_BLEND)
        return "--bits half needs --method blend";
    if (o[ACCUMULATION_SOURCE_RANGE].given && a->bits > 16)
        return "--source-range is of targets of 8 and 16 bits: floats need none";
    return NULL;
}

static const char *find_conflict(const struct option_value *o, unsigned uses,
                                 const struct accumulation *a, char text[ACCUMULATION_TEXT])
{
    if (!(uses & ACCUMULATION_TELLS_ERROR) && !o[ACCUMULATION_UNTIL].given &&
        o[ACCUMULATION_BATCH].given)
        return "--batch is of the standard error: it needs --stderr or --until";
    return method_conflict(o, uses, a, text);
}

// ---- single options -----------------------------------------------------------------------------

static enum weft_result fail_branching(const char *text, const char *why)
{
    report_error("--branching %s: %s; it is the inputs of a node, 2 to %d, or of each level's "
                 "nodes from the frames up, as 2x4x4, at most %d levels",
                 text, why, WEFT_TREE_MAX_INPUTS, WEFT_TREE_MAX_LEVELS);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_branching(const struct option_value *o, struct accumulation *out)
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

static enum weft_result read_range(const struct option_value *o, struct accumulation *out)
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

static enum weft_result read_max_error(const struct option_value *o, struct accumulation *out)
{
    out->max_error = o->number[0];
    if (!o->given || out->max_error > 0.0)
        return WEFT_OK;
    report_error("--max-error %s: it must be above 0", o->text);
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

int64_t accumulation_next_judged(const struct weft_until *until, int64_t judged)
{
    const int64_t least = until->least ? until->least : 16;
    return judged < least ? least : judged + judged / 16 + 1;
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result read_choices(const struct option_value *o, struct accumulation *out)
{
    static const int bits[] = {8, 16, 32, WEFT_ACCUMULATE_HALF};
    out->method = (enum weft_accumulate_method)o[ACCUMULATION_METHOD].integer[0];
    out->rounding = (enum weft_tree_rounding)o[ACCUMULATION_ROUNDING].integer[0];
    out->bits = o[ACCUMULATION_BITS].given ? bits[o[ACCUMULATION_BITS].integer[0]] : 0;
    out->emulate = o[ACCUMULATION_EMULATE].given;
    return o[ACCUMULATION_CONTEXT].given
               ? weft_context_kind_parse(report_log(), o[ACCUMULATION_CONTEXT].text, &out->context)
               : WEFT_OK;
}

static enum weft_result read_numbers(const struct option_value *o, struct accumulation *out)
{
    enum weft_result res = read_branching(&o[ACCUMULATION_BRANCHING], out);
    if (res == WEFT_OK)
        res = read_range(&o[ACCUMULATION_SOURCE_RANGE], out);
    if (res == WEFT_OK)
        res = read_max_error(&o[ACCUMULATION_MAX_ERROR], out);
    if (res == WEFT_OK)
        res = read_until(&o[ACCUMULATION_UNTIL], &out->until);
    if (res == WEFT_OK)
        res = options_read_whole(&o[ACCUMULATION_BATCH], "batch", 1, WEFT_ACCUMULATE_MAX_FRAMES,
                                 &out->batch);
    if (res == WEFT_OK)
        res = options_read_whole(&o[ACCUMULATION_THREADS], "threads", 1, WEFT_CPU_MAX_THREADS,
                                 &out->threads);
    return res;
}

enum weft_result accumulation_read(const struct option_value *first, unsigned uses,
                                   struct accumulation *out)
{
    char text[ACCUMULATION_TEXT];
    *out = (struct accumulation){.method = WEFT_ACCUMULATE_AUTO};
    const enum weft_result res = read_choices(first, out);
    const char *conflict = res == WEFT_OK ? find_conflict(first, uses, out, text) : NULL;
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    return res == WEFT_OK ? read_numbers(first, out) : res;
}

// ---- what comes of them -------------------------------------------------------------------------

enum weft_result accumulation_check_branching(const struct accumulation *a, const char *text,
                                              int64_t frames)
{
    const int *level = a->level_branching;
    int64_t product = 1;
    for (int i = 0; i < WEFT_TREE_MAX_LEVELS && level[i] && product < frames; i++)
        product *= level[i];
    if (!level[0] || product >= frames)
        return WEFT_OK;
    report_error("--branching %s: such a tree has %lld leaves, for %lld frames", text,
                 (long long)product, (long long)frames);
    return WEFT_ERR_ARGUMENT;
}

bool accumulation_draws(enum weft_accumulate_method method)
{
    return method == WEFT_ACCUMULATE_TREE || method == WEFT_ACCUMULATE_BLEND ||
           method == WEFT_ACCUMULATE_FLOAT;
}

void accumulation_set(const struct accumulation *a, struct weft_accumulator_params *params)
{
    params->method = a->method;
    params->branching = a->branching;
    memcpy(params->level_branching, a->level_branching, sizeof params->level_branching);
    params->rounding = a->rounding;
    params->bits = a->bits;
    params->low = a->low;
    params->high = a->high;
    params->max_error = a->max_error;
    params->batch = a->batch;
    params->emulate = a->emulate;
    params->cpu.threads = a->threads;
}

enum weft_result accumulation_check_bound(const struct accumulation *a,
                                          enum weft_accumulate_method method, double bound)
{
    if (!(a->max_error > 0.0) || bound <= a->max_error)
        return WEFT_OK;
    report_error("--max-error %g: the bound of --method %s is %.3g", a->max_error,
                 weft_accumulate_method_names[method], bound);
    return WEFT_ERR_UNSUPPORTED;
}
