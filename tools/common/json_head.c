// SPDX-License-Identifier: BSD-3-Clause
// What every document begins with, the same way in all verbs: docs/json.md.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tools/common/json.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

struct names {
    char **name;
    size_t count;
};

static struct {
    const char *verb, *path;
    double start;
    struct names input, output;
} report_to = {.verb = ""};

static const char *const heads[] = {"weft",    "verb",  "input", "output", "context",
                                    "seconds", "bytes", "error", "bound"};

static void clear(struct names *list)
{
    for (size_t i = 0; i < list->count; i++)
        free(list->name[i]);
    free(list->name);
    *list = (struct names){0};
}

// Each name once. What there is no memory for makes the document fail.
static void add(struct names *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++)
        if (strcmp(list->name[i], name) == 0)
            return;
    char **larger = realloc(list->name, (list->count + 1) * sizeof *larger);
    list->name = larger ? larger : list->name;
    if (larger && (larger[list->count] = strdup(name)))
        list->count++;
    else
        json_watch(NULL);
}

void json_set_report(const char *verb, const char *path)
{
    clear(&report_to.input);
    clear(&report_to.output);
    report_to.verb = verb;
    report_to.path = path;
    report_to.start = report_now_seconds();
}

void json_report_to(const char *path)
{
    struct names *list = &report_to.output;
    report_to.path = path;
    for (size_t i = 0; path && i < list->count; i++) {
        if (strcmp(list->name[i], path) != 0)
            continue;
        free(list->name[i]);
        list->name[i] = list->name[--list->count];
    }
}

void json_add_input(const char *path)
{
    add(&report_to.input, strcmp(path, "/dev/stdin") == 0 ? "-" : path);
}

void json_add_output(const char *path)
{
    add(&report_to.output, path);
}

bool json_is_head(const char *key)
{
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++)
        if (strcmp(key, heads[i]) == 0)
            return true;
    return false;
}

json_t *json_file(const char *path)
{
    struct stat status;
    const bool stream = paths_is_stdout(path);
    const bool known = !stream && stat(path, &status) == 0 && S_ISREG(status.st_mode);
    return json_pack("{s:o,s:o}", "path", json_text(stream ? "-" : path), "bytes",
                     known ? json_count((uint64_t)status.st_size) : json_null());
}

json_t *json_files(const char *path)
{
    json_t *list = json_array();
    if (path)
        json_array_append_new(list, json_file(path));
    return list;
}

static json_t *input_json(void)
{
    json_t *list = json_array();
    for (size_t i = 0; i < report_to.input.count; i++)
        json_array_append_new(list, json_text(report_to.input.name[i]));
    return list;
}

static json_t *output_json(void)
{
    json_t *list = json_array();
    for (size_t i = 0; i < report_to.output.count; i++)
        json_array_append_new(list, json_file(report_to.output.name[i]));
    return list;
}

// The most memory that this process has had.
static json_t *process_peak(void)
{
    struct rusage usage = {0};
    getrusage(RUSAGE_SELF, &usage);
    return json_count((uint64_t)usage.ru_maxrss * 1024);
}

// The root's own member, or what stands there where it has none.
static void take(json_t *whole, const json_t *root, const char *key, json_t *otherwise)
{
    json_t *own = json_object_get(root, key);
    if (own)
        json_decref(otherwise);
    json_object_set_new(whole, key, own ? json_incref(own) : otherwise);
}

// The members after "output" are the root's own where it has them.
static json_t *add_head(json_t *root)
{
    if (!root)
        return NULL;
    json_t *whole = json_pack("{s:s,s:s,s:o,s:o}", "weft", weft_version(), "verb", report_to.verb,
                              "input", input_json(), "output", output_json());
    take(whole, root, "context", json_null());
    take(whole, root, "seconds",
         json_pack("{s:o}", "total", json_number(report_now_seconds() - report_to.start)));
    take(whole, root, "bytes", json_object());
    json_object_set_new(json_object_get(whole, "bytes"), "process_peak", process_peak());
    take(whole, root, "error", json_null());
    take(whole, root, "bound", json_null());
    if (whole)
        json_watch_result(json_object_update_missing(whole, root));
    json_decref(root);
    return whole;
}

enum weft_result json_print(json_t *root)
{
    char *text = json_format(add_head(root));
    const char *path = report_to.path;
    enum weft_result res = text ? WEFT_OK : WEFT_ERR_MEMORY;
    if (text && path) {
        const size_t length = strlen(text);
        text[length] = '\n'; // instead of the end
        res = weft_file_save(report_log(), path, false, text, length + 1);
    } else if (text) {
        puts(text);
    }
    free(text);
    return res;
}
