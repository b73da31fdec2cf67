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

// ---- the head, which every document has: docs/json.md; json_head.c ------------------------------

// Whose documents are printed, and to which file; NULL: standard output. Borrowed. Names that were
// added before are forgotten, and seconds count from here.
void json_set_report(const char *verb, const char *path);
// The document is what an output of the verb is to hold: it goes there, and is not in its own list.
void json_report_to(const char *path);

// A file that is read, as the user named it, or one that was written. Copied; each name counts
// once.
void json_add_input(const char *path);
void json_add_output(const char *path);

// Whether a document of every verb has this member, whatever it tells.
bool json_is_head(const char *key);

// "path" and "bytes" of a file that was written, which are null where it is a stream; a list of
// it, or of nothing for NULL, for parts of a document that have outputs of their own.
json_t *json_file(const char *path);
json_t *json_files(const char *path);

// Prints the object's text with a line end where the document belongs, with "weft", "verb",
// "input", "output", "context", "seconds", "bytes", "error" and "bound" first; those after "output"
// are the root's own where it has them. A file appears whole or not at all. Releases it. Returns
// WEFT_ERR_MEMORY or WEFT_ERR_WRITE, with a log line.
enum weft_result json_print(json_t *root);

#endif
