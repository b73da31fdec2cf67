// SPDX-License-Identifier: BSD-3-Clause
// tools/common/json.h - JSON values from C ones, and their printing.
// Include it instead of jansson.h. A value that cannot be had, or put where it belongs, is
// remembered, and nothing is printed then: what builds documents need not look at every result.
#ifndef WEFT_TOOLS_COMMON_JSON_H
#define WEFT_TOOLS_COMMON_JSON_H

#include <jansson.h>

#include "weft.h"

// jansson's own builders, watched.
json_t *json_watch(json_t *value);
int json_watch_result(int result);
#define json_pack(...) json_watch(json_pack(__VA_ARGS__))
#define json_object_set_new(...) json_watch_result(json_object_set_new(__VA_ARGS__))
#define json_object_update_new(...) json_watch_result(json_object_update_new(__VA_ARGS__))
#define json_array_append_new(...) json_watch_result(json_array_append_new(__VA_ARGS__))

// New references. NaN and infinities become null; texts are cleaned (weft_text_clean), their line
// ends and tabs kept.
json_t *json_number(double value);
json_t *json_numbers(const double *value, int count);
json_t *json_count(uint64_t value);
json_t *json_counts(const int32_t *value, int count);
json_t *json_text(const char *text);
json_t *json_metadata(const struct weft_metadata *metadata, size_t count);
json_t *json_attributes(const struct weft_image *image); // name: value in words, whole

// The document as text, to be freed; releases it. NULL after an error line, for a NULL root or one
// that is not whole.
char *json_format(json_t *root);

// Whose documents are printed, and to which file; NULL: standard output. Borrowed.
void json_set_report(const char *verb, const char *path);

// Whether a document of every verb has this member, whatever it tells.
bool json_is_head(const char *key);

// Prints the object's text with a line end there, with "weft", the version, and "verb" first; a
// file appears whole or not at all. Releases it. Returns WEFT_ERR_MEMORY or WEFT_ERR_WRITE, with a
// log line.
enum weft_result json_print(json_t *root);

#endif
