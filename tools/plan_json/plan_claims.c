// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plan_json/plan_claims.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

enum { PATH_TEXT = 128, VALUE_TEXT = 48 };

// Where it is; behind what does not fit nothing is added.
struct place {
    const char *file;
    char path[PATH_TEXT];
};

// Of a plan, how long the search took is nobody's to judge.
static const char not_judged[] = "search_seconds";

static void print_value(const json_t *value, char text[VALUE_TEXT])
{
    char *whole = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
    snprintf(text, VALUE_TEXT, "%s", whole ? whole : "?");
    if (whole && strlen(whole) >= VALUE_TEXT)
        strcpy(text + VALUE_TEXT - 4, "...");
    free(whole);
}

static bool refuse(const struct place *at, const json_t *claim, const json_t *own)
{
    char is[VALUE_TEXT], should[VALUE_TEXT];
    print_value(claim, is);
    print_value(own, should);
    report_error("%s: %s is %s, not %s", at->file, at->path, is, should);
    return false;
}

// Sums of doubles differ in their last bits between machines.
static bool close_to(double a, double b)
{
    return fabs(a - b) <= 1e-9 * fmax(fabs(a), fabs(b)) + 1e-12;
}

static bool same(struct place *at, const json_t *claim, const json_t *own);

static bool same_member(const struct place *at, const char *key, size_t index, const json_t *claim,
                        const json_t *own)
{
    struct place inner = *at;
    const size_t used = strlen(inner.path);
    if (key)
        snprintf(inner.path + used, sizeof inner.path - used, "%s%.32s", used ? "." : "", key);
    else
        snprintf(inner.path + used, sizeof inner.path - used, "[%zu]", index);
    return same(&inner, claim, own);
}

static bool same_objects(const struct place *at, const json_t *claim, const json_t *own)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)own, key, value)
    {
        if (strcmp(key, not_judged) == 0)
            continue;
        const json_t *other = json_object_get(claim, key);
        if (!other) {
            report_error("%s: %s%s%s is missing", at->file, at->path, *at->path ? "." : "", key);
            return false;
        }
        if (!same_member(at, key, 0, other, value))
            return false;
    }
    json_object_foreach((json_t *)claim, key, value)
    {
        if (json_object_get(own, key) || (!*at->path && json_is_head(key)))
            continue;
        report_error("%s: %s%s%.32s is no member of a plan", at->file, at->path,
                     *at->path ? "." : "", key);
        return false;
    }
    return true;
}

static bool same_arrays(const struct place *at, const json_t *claim, const json_t *own)
{
    const size_t size = json_array_size(own);
    if (json_array_size(claim) != size) {
        report_error("%s: %s has %zu entries, not %zu", at->file, at->path, json_array_size(claim),
                     size);
        return false;
    }
    for (size_t i = 0; i < size; i++)
        if (!same_member(at, NULL, i, json_array_get(claim, i), json_array_get(own, i)))
            return false;
    return true;
}

static bool same(struct place *at, const json_t *claim, const json_t *own)
{
    if (json_is_number(claim) && json_is_number(own)) {
        const bool whole = json_is_integer(claim) && json_is_integer(own);
        const bool equal = whole ? json_integer_value(claim) == json_integer_value(own)
                                 : close_to(json_number_value(claim), json_number_value(own));
        return equal || refuse(at, claim, own);
    }
    if (json_is_object(claim) && json_is_object(own))
        return same_objects(at, claim, own);
    if (json_is_array(claim) && json_is_array(own))
        return same_arrays(at, claim, own);
    return json_equal(claim, own) || refuse(at, claim, own);
}

enum weft_result plan_claims_check(const char *file, const json_t *claims,
                                   const weft_pass_plan *plan)
{
    struct place at = {file, ""};
    json_t *own = plan_json(plan);
    if (!own) {
        report_error("out of memory for the plan's figures");
        return WEFT_ERR_MEMORY;
    }
    // What figures follow from is named before they are.
    static const char *const causes[] = {"profile", "tile_set", "targets"};
    bool good = true;
    for (int i = 0; good && i < 3; i++)
        good = same_member(&at, causes[i], 0, json_object_get(claims, causes[i]),
                           json_object_get(own, causes[i]));
    good = good && same(&at, claims, own);
    json_decref(own);
    return good ? WEFT_OK : WEFT_ERR_FORMAT;
}

enum weft_result plan_claims_judge(const char *path, const struct plan_file *file,
                                   const struct weft_progress *progress, struct plan_fault *fault,
                                   weft_pass_plan **plan)
{
    struct weft_pass_plan_params params = file->params;
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    *plan = NULL;
    enum weft_result res = plan_check(&file->list, fault);
    if (res != WEFT_OK || fault->kind != PLAN_FAULT_NONE)
        return res;
    params.progress = progress;
    res = weft_pass_plan_judge(&params, &file->list, plan);
    if (res == WEFT_OK && (weft_pass_plan_get_info(*plan)->valid ||
                           !json_is_true(json_object_get(file->root, "valid"))))
        res = plan_claims_check(name, file->root, *plan);
    return res == WEFT_ERR_ARGUMENT || res == WEFT_ERR_UNSUPPORTED ? WEFT_ERR_FORMAT : res;
}
