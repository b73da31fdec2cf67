// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static bool failed;

json_t *json_watch(json_t *value)
{
    failed = failed || !value;
    return value;
}

int json_watch_result(int result)
{
    failed = failed || result != 0;
    return result;
}

json_t *json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *json_numbers(const double *value, int count)
{
    json_t *array = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(array, json_number(value[i]));
    return array;
}

json_t *json_count(uint64_t value)
{
    return json_integer((json_int_t)value);
}

json_t *json_counts(const int32_t *value, int count)
{
    json_t *array = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(array, json_integer(value[i]));
    return array;
}

json_t *json_text(const char *text)
{
    char *clean = strdup(text);
    json_t *string = clean ? json_string(weft_text_clean(clean, true)) : NULL;
    free(clean);
    return string;
}

json_t *json_metadata(const struct weft_metadata *metadata, size_t count)
{
    json_t *object = json_object();
    for (size_t i = 0; i < count; i++) {
        json_t *key = json_text(metadata[i].key);
        json_object_set_new(object, json_string_value(key), json_text(metadata[i].value));
        json_decref(key);
    }
    return object;
}

static json_t *attribute_text(const struct weft_image_attribute *attribute)
{
    const size_t size = weft_image_attribute_format(attribute, NULL, 0) + 1;
    char *text = malloc(size);
    if (!text)
        return NULL;
    weft_image_attribute_format(attribute, text, size);
    json_t *value = json_text(text);
    free(text);
    return value;
}

json_t *json_attributes(const struct weft_image *image)
{
    json_t *object = json_object();
    for (size_t i = 0; i < image->attribute_count; i++) {
        json_t *key = json_text(image->attributes[i].name);
        json_object_set_new(object, json_string_value(key), attribute_text(&image->attributes[i]));
        json_decref(key);
    }
    return object;
}

static int append(const char *text, size_t size, void *out)
{
    return fwrite(text, 1, size, out) == size ? 0 : -1;
}

// Not by json_dumps, which leaves out keys that it has no memory for (jansson 2.14).
char *json_format(json_t *root)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = root && !failed ? open_memstream(&text, &size) : NULL;
    bool whole = out && json_dump_callback(root, append, out, JSON_INDENT(2)) == 0;
    json_decref(root);
    if (out && report_close(out) && whole)
        return text;
    free(text);
    report_error("out of memory for the JSON text");
    return NULL;
}

static struct {
    const char *verb, *path;
} report_to = {"", NULL};

void json_set_report(const char *verb, const char *path)
{
    report_to.verb = verb;
    report_to.path = path;
}

bool json_is_head(const char *key)
{
    static const char *const heads[] = {"weft",    "verb",  "input", "output", "context",
                                        "seconds", "bytes", "error", "bound"};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++)
        if (strcmp(key, heads[i]) == 0)
            return true;
    return false;
}

// What every document begins with.
static json_t *add_head(json_t *root)
{
    json_t *whole =
        root ? json_pack("{s:s,s:s}", "weft", weft_version(), "verb", report_to.verb) : NULL;
    if (whole)
        json_watch_result(json_object_update_missing(whole, root));
    json_decref(root);
    return whole;
}

enum weft_result json_print(json_t *root)
{
    char *text = json_format(add_head(root));
    enum weft_result res = text ? WEFT_OK : WEFT_ERR_MEMORY;
    if (text && report_to.path) {
        const size_t length = strlen(text);
        text[length] = '\n'; // instead of the end
        res = weft_file_save(report_log(), report_to.path, false, text, length + 1);
    } else if (text) {
        puts(text);
    }
    free(text);
    return res;
}
