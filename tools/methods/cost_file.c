// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/cost_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tools/common/report.h"

enum { MAX_FILE = 1 << 16, TEXT = 256 };

// ---- paths --------------------------------------------------------------------------------------

char *cost_file_path(enum weft_context_kind kind)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    const char *name = weft_context_kind_names[kind];
    char *path = NULL;
    int size = -1;
    if (cache && *cache == '/') // others are to be ignored, says the specification
        size = asprintf(&path, "%s/weft/cost-%s.txt", cache, name);
    else if (home && *home == '/')
        size = asprintf(&path, "%s/.cache/weft/cost-%s.txt", home, name);
    return size < 0 ? NULL : path;
}

enum weft_result cost_file_make_folders(const char *path)
{
    char *folder = strdup(path);
    enum weft_result res = folder ? WEFT_OK : WEFT_ERR_MEMORY;
    for (char *at = folder ? strchr(folder + 1, '/') : NULL; res == WEFT_OK && at;
         at = strchr(at + 1, '/')) {
        *at = 0;
        if (mkdir(folder, 0700) != 0 && errno != EEXIST) {
            report_error("folder %s cannot be made: %s", folder, strerror(errno));
            res = WEFT_ERR_WRITE;
        }
        *at = '/';
    }
    free(folder);
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static void keep(void *priv, enum weft_log_level level, const char *message)
{
    if (level == WEFT_LOG_ERROR)
        snprintf(priv, TEXT, "%s", message);
}

// Why a file cannot be used goes to `why`.
static bool parse(const char *text, const char *renderer, struct weft_cost_model *out,
                  char why[TEXT])
{
    const struct weft_log log = {keep, why};
    if (weft_cost_parse(&log, text, out) != WEFT_OK)
        return false;
    if (renderer && strncmp(out->renderer, renderer, sizeof out->renderer - 1) != 0)
        snprintf(why, TEXT, "it is of another renderer, %.100s",
                 out->renderer[0] ? out->renderer : "none");
    else if (out->instructions != weft_instruction_set_best())
        snprintf(why, TEXT, "it is of another processor, with %s instructions",
                 weft_instruction_set_names[out->instructions]);
    else
        return true;
    return false;
}

// false without a word where there is none.
static bool read_file(const char *path, const char *renderer, struct weft_cost_model *out)
{
    char why[TEXT] = "", line[2 * TEXT], *text = calloc(1, MAX_FILE);
    FILE *file = text ? fopen(path, "r") : NULL;
    bool good = false;
    if (file) {
        const size_t size = fread(text, 1, MAX_FILE - 1, file);
        if (strlen(text) != size)
            snprintf(why, sizeof why, "it is no text");
        else
            good = parse(text, renderer, out, why);
        fclose(file);
    }
    if (file && !good) {
        snprintf(line, sizeof line, "%.200s cannot be used (%s): weft calibrate makes it anew",
                 path, why);
        report_log()->write(report_log()->priv, WEFT_LOG_WARNING, line);
    }
    free(text);
    return good;
}

bool cost_file_load(enum weft_context_kind kind, const char *renderer, struct weft_cost_model *out)
{
    char *path = cost_file_path(kind);
    const bool good = path && read_file(path, renderer, out);
    if (!good) {
        report_note("costs are weft's defaults: weft calibrate measures those of this machine");
        *out = weft_cost_default;
    }
    free(path);
    return good;
}

enum weft_result cost_file_save(const struct weft_cost_model *model, const char *path)
{
    char *text = weft_cost_format(model);
    if (!text) {
        report_error("out of memory for %s", path);
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res = weft_file_save(report_log(), path, false, text, strlen(text));
    free(text);
    return res;
}
