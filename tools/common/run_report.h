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

// What every document has, where verbs have it (docs/json.md); parts of documents have the same.
// Where it ran; null for NULL, the CPU.
json_t *run_report_context(const weft_context *context);

struct run_stage {
    const char *name;
    double seconds;
};
// An object of the stages' seconds, and of the total.
json_t *run_report_seconds(const struct run_stage *stages, size_t count, double total);

// The same of one number.
json_t *run_report_total_seconds(double total);

// An object of bytes by what holds them, of one. More are set beside it.
json_t *run_report_bytes(const char *what, uint64_t bytes);

// "error" of so many values: max, rms, samples, unit and, in `dims` coordinates, where the largest
// is; NULL: it is not known. Verbs add what they know beside. run_report_verify_error: of what was
// compared with double precision, in the input's values, with the number of pixels and those that
// are finite on one side only.
json_t *run_report_error(double max, double rms, uint64_t samples, const char *unit,
                         const int32_t *where, int dims);
json_t *run_report_verify_error(const struct weft_verify_report *verify, const int32_t *where,
                                int dims);

// The image that a preview was written to, and the values that are black and white in it.
json_t *run_report_preview(const char *path, const float range[2]);
void run_report_print_preview(const char *path, const float range[2]); // not with -q

#endif
