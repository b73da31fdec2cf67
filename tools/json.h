// SPDX-License-Identifier: BSD-3-Clause
// tools/json.h - JSON values from C ones, and their printing.
#ifndef WEFT_TOOLS_JSON_H
#define WEFT_TOOLS_JSON_H

#include <jansson.h>

#include "weft.h"

// New references. NaN and infinities become null; texts are cleaned (weft_text_clean), their line
// ends and tabs kept.
json_t *json_number(double value);
json_t *json_numbers(const double *value, int count);
json_t *json_count(uint64_t value);
json_t *json_counts(const int32_t *value, int count);
json_t *json_text(const char *text);
json_t *json_metadata(const struct weft_metadata *metadata, size_t count);

// Prints on stdout with a line end, and releases it. Returns WEFT_ERR_MEMORY, with a log line.
enum weft_result json_print(json_t *root);

#endif
