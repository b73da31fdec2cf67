// SPDX-License-Identifier: BSD-3-Clause
// tools/common/run_report.h - what every verb tells that made pixels: attributes, JSON, text.
#ifndef WEFT_TOOLS_COMMON_RUN_REPORT_H
#define WEFT_TOOLS_COMMON_RUN_REPORT_H

#include "tools/common/json.h"

// Appends "weft.KEY" to a list that has room for it.
void run_report_add(struct weft_metadata *list, size_t *count, const char *key, const char *format,
                    ...) __attribute__((format(printf, 4, 5)));
// Appends the renderer; "CPU" without a context.
void run_report_add_renderer(struct weft_metadata *list, size_t *count,
                             const weft_context *context);

json_t *run_report_context(const weft_context *context);

struct run_stage {
    const char *name;
    double seconds;
};
// An object of the stages' seconds, and of the total.
json_t *run_report_seconds(const struct run_stage *stages, size_t count, double total);

// The most memory that this process has had.
json_t *run_report_process_peak(void);

// The image that a preview was written to, and the values that are black and white in it.
json_t *run_report_preview(const char *path, const float range[2]);
void run_report_print_preview(const char *path, const float range[2]); // not with -q

#endif
