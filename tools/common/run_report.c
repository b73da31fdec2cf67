// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/run_report.h"

#include <stdarg.h>
#include <stdio.h>

#include "tools/common/report.h"

void run_report_add(struct weft_metadata *list, size_t *count, const char *key, const char *format,
                    ...)
{
    struct weft_metadata *entry = &list[(*count)++];
    snprintf(entry->key, sizeof entry->key, "weft.%s", key);
    va_list args;
    va_start(args, format);
    vsnprintf(entry->value, sizeof entry->value, format, args);
    va_end(args);
}

void run_report_add_renderer(struct weft_metadata *list, size_t *count, const weft_context *context)
{
    if (!context) {
        run_report_add(list, count, "renderer", "CPU");
        return;
    }
    const struct weft_context_info *info = weft_context_get_info(context);
    run_report_add(list, count, "renderer", "%s, %s, OpenGL %s", info->platform, info->renderer,
                   info->version);
}

json_t *run_report_context(const weft_context *context)
{
    if (!context)
        return json_null();
    const struct weft_context_info *info = weft_context_get_info(context);
    return json_pack("{s:o,s:o,s:o,s:o,s:b}", "platform", json_text(info->platform), "vendor",
                     json_text(info->vendor), "renderer", json_text(info->renderer), "version",
                     json_text(info->version), "hardware", info->hardware);
}

json_t *run_report_seconds(const struct run_stage *stages, size_t count, double total)
{
    json_t *object = json_object();
    for (size_t i = 0; i < count; i++)
        json_object_set_new(object, stages[i].name, json_number(stages[i].seconds));
    json_object_set_new(object, "total", json_number(total));
    return object;
}

json_t *run_report_total_seconds(double total)
{
    return run_report_seconds(NULL, 0, total);
}

json_t *run_report_bytes(const char *what, uint64_t bytes)
{
    return json_pack("{s:o}", what, json_count(bytes));
}

json_t *run_report_error(double max, double rms, uint64_t samples, const char *unit,
                         const int32_t *where, int dims)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:s}", "max", json_number(max), "rms", json_number(rms),
                     "where", where ? json_counts(where, dims) : json_null(), "samples",
                     json_count(samples), "unit", unit);
}

json_t *run_report_verify_error(const struct weft_verify_report *verify, const int32_t *where,
                                int dims)
{
    json_t *error = run_report_error(verify->maximum, verify->rms, verify->pixels_checked, "value",
                                     where, dims);
    json_object_set_new(error, "samples_total", json_count(verify->pixels_total));
    json_object_set_new(error, "not_finite_mismatches", json_count(verify->not_finite_mismatches));
    return error;
}

json_t *run_report_preview(const char *path, const float range[2])
{
    return json_pack("{s:o,s:o,s:o}", "path", json_text(path), "low", json_number((double)range[0]),
                     "high", json_number((double)range[1]));
}

void run_report_print_preview(const char *path, const float range[2])
{
    if (!report_is_quiet())
        report_line("%s: values from %.9g to %.9g", path, (double)range[0], (double)range[1]);
}
