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
