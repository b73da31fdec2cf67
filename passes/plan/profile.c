// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/profile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"

enum { MAX_INTERNAL_BITS = 24, MAX_TAPS = 16, MAX_SCALE = 256 };

static const struct weft_profile fp32 = {
    .name = "fp32",
    .description = "a modern shader and a float target",
    .target = WEFT_TARGET_FLOAT,
    .internal_range = INFINITY,
    .taps_per_pass = 8,
    .dot_width = 4,
    .ping_pong = true,
};
static const struct weft_profile fp16 = {
    .name = "fp16",
    .description = "a modern shader and a half float target",
    .target = WEFT_TARGET_HALF,
    .internal_range = INFINITY,
    .taps_per_pass = 8,
    .dot_width = 4,
    .ping_pong = true,
};
static const struct weft_profile unorm16 = {
    .name = "unorm16",
    .description = "a modern shader and a target of 16 bits in [0, 1]",
    .target = WEFT_TARGET_UNORM16,
    .internal_range = INFINITY,
    .taps_per_pass = 8,
    .dot_width = 4,
    .ping_pong = true,
};
static const struct weft_profile unorm8 = {
    .name = "unorm8",
    .description = "a modern shader and a target of 8 bits in [0, 1]",
    .target = WEFT_TARGET_UNORM8,
    .internal_range = INFINITY,
    .taps_per_pass = 8,
    .dot_width = 4,
    .ping_pong = true,
};
// Register combiners scale by 2 and 4 (GL_NV_register_combiners).
static const struct weft_profile geforce3 = {
    .name = "geforce3",
    .description = "NVIDIA GeForce 3 and 4: 9 bits in [-1, 1], RGB dot product and alpha apart",
    .target = WEFT_TARGET_UNORM8,
    .internal_bits = 9,
    .internal_range = 1.0,
    .taps_per_pass = 2,
    .dot_width = 3,
    .max_scale = 4,
};
static const struct weft_profile radeon8500 = {
    .name = "radeon8500",
    .description = "ATI Radeon 8500: 12 fraction bits in [-8, 8], dot product of four",
    .target = WEFT_TARGET_UNORM8,
    .internal_bits = 12,
    .internal_range = 8.0,
    .taps_per_pass = 3,
    .dot_width = 4,
    .max_scale = 8,
};

const struct weft_profile *const weft_profile_list[] = {&fp32,     &fp16,       &unorm16, &unorm8,
                                                        &geforce3, &radeon8500, NULL};

const struct weft_profile *weft_profile_find(const char *name)
{
    for (int i = 0; weft_profile_list[i]; i++)
        if (strcmp(weft_profile_list[i]->name, name) == 0)
            return weft_profile_list[i];
    return NULL;
}

// ---- targets ------------------------------------------------------------------------------------

const char *const weft_target_names[] = {"unorm8", "unorm16", "half", "float", NULL};

int weft_target_bits(enum weft_target_format target)
{
    return target == WEFT_TARGET_UNORM8 ? 8 : target == WEFT_TARGET_UNORM16 ? 16 : 0;
}

int weft_target_one(enum weft_target_format target)
{
    return (1 << weft_target_bits(target)) - 1;
}

const char *weft_target_name(enum weft_target_format target)
{
    return weft_name(weft_target_names, (unsigned)target);
}

// ---- a user's own -------------------------------------------------------------------------------

struct reader {
    const struct weft_log *log;
    struct weft_profile *profile;
};

static bool read_number(const struct reader *r, const char *key, const char *text, double low,
                        double high, double *out)
{
    const char *end = weft_number_parse(text, out);
    if (end && !*end && *out >= low && *out <= high)
        return true;
    weft_error(r->log, "profile: %s takes a number from %g to %g, not '%.32s'", key, low, high,
               text);
    return false;
}

static bool read_integer(const struct reader *r, const char *key, const char *text, int low,
                         int high, int *out)
{
    double value;
    if (!read_number(r, key, text, low, high, &value))
        return false;
    *out = (int)value;
    if (*out == value)
        return true;
    weft_error(r->log, "profile: %s takes a whole number, not '%.32s'", key, text);
    return false;
}

static bool read_target(const struct reader *r, const char *key, const char *text)
{
    for (int i = 0; weft_target_names[i]; i++) {
        if (strcmp(text, weft_target_names[i]) == 0) {
            r->profile->target = (enum weft_target_format)i;
            return true;
        }
    }
    weft_error(r->log, "profile: %s takes unorm8, unorm16, half or float, not '%.32s'", key, text);
    return false;
}

static bool read_internal_bits(const struct reader *r, const char *key, const char *text)
{
    return read_integer(r, key, text, 0, MAX_INTERNAL_BITS, &r->profile->internal_bits);
}

static bool read_range(const struct reader *r, const char *key, const char *text)
{
    if (strcmp(text, "inf") != 0)
        return read_number(r, key, text, 1.0, 1024.0, &r->profile->internal_range);
    r->profile->internal_range = INFINITY;
    return true;
}

static bool read_taps(const struct reader *r, const char *key, const char *text)
{
    return read_integer(r, key, text, 1, MAX_TAPS, &r->profile->taps_per_pass);
}

static bool read_dot(const struct reader *r, const char *key, const char *text)
{
    if (!read_integer(r, key, text, 1, 4, &r->profile->dot_width))
        return false;
    if (r->profile->dot_width != 2)
        return true;
    weft_error(r->log, "profile: %s takes 1, 3 or 4, not 2", key);
    return false;
}

static bool read_max_scale(const struct reader *r, const char *key, const char *text)
{
    int *scale = &r->profile->max_scale;
    if (!read_integer(r, key, text, 0, MAX_SCALE, scale))
        return false;
    if ((*scale & (*scale - 1)) == 0)
        return true;
    weft_error(r->log, "profile: %s takes a power of two or 0, not %d", key, *scale);
    return false;
}

static bool read_ping_pong(const struct reader *r, const char *key, const char *text)
{
    r->profile->ping_pong = strcmp(text, "yes") == 0;
    if (r->profile->ping_pong || strcmp(text, "no") == 0)
        return true;
    weft_error(r->log, "profile: %s takes yes or no, not '%.32s'", key, text);
    return false;
}

static const struct {
    const char *key;
    bool (*read)(const struct reader *r, const char *key, const char *text);
} keys[] = {
    {"target", read_target},
    {"internal-bits", read_internal_bits},
    {"range", read_range},
    {"taps", read_taps},
    {"dot", read_dot},
    {"max-scale", read_max_scale},
    {"ping-pong", read_ping_pong},
};

static bool read_pair(const struct reader *r, const char *pair)
{
    const char *equals = strchr(pair, '=');
    const size_t length = equals ? (size_t)(equals - pair) : strlen(pair);
    for (size_t i = 0; equals && i < WEFT_COUNT(keys); i++)
        if (strlen(keys[i].key) == length && strncmp(keys[i].key, pair, length) == 0)
            return keys[i].read(r, keys[i].key, equals + 1);
    const char *names[WEFT_COUNT(keys) + 1] = {NULL};
    char explanation[256];
    for (size_t i = 0; i < WEFT_COUNT(keys); i++)
        names[i] = keys[i].key;
    weft_error(
        r->log, "profile: no KEY=VALUE '%.64s'%s", pair,
        weft_closest_explain(pair, equals ? length : 0, names, explanation, sizeof explanation));
    return false;
}

static bool check_inside(const struct weft_log *log, const struct weft_profile *p)
{
    const int bits = weft_target_bits(p->target);
    if (!p->internal_bits || (bits && p->internal_bits >= bits))
        return true;
    if (bits)
        weft_error(log, "profile: %d bits inside a pass are fewer than the target's %d",
                   p->internal_bits, bits);
    else
        weft_error(log, "profile: a %s target has no fraction bits inside, give 0 instead of %d",
                   weft_target_name(p->target), p->internal_bits);
    return false;
}

enum weft_result weft_profile_check(const struct weft_log *log, const struct weft_profile *profile)
{
    weft_require(log, memchr(profile->name, '\0', sizeof profile->name));
    weft_require(log, memchr(profile->description, '\0', sizeof profile->description));
    weft_require_enum(log, profile->target, WEFT_TARGET_FLOAT);
    weft_require(log, profile->internal_bits >= 0 && profile->internal_bits <= MAX_INTERNAL_BITS);
    weft_require(log, profile->internal_range >= 1.0);
    weft_require(log, profile->taps_per_pass >= 1 && profile->taps_per_pass <= MAX_TAPS);
    weft_require(log,
                 profile->dot_width == 1 || profile->dot_width == 3 || profile->dot_width == 4);
    weft_require(log, profile->max_scale >= 0 && profile->max_scale <= MAX_SCALE);
    return check_inside(log, profile) ? WEFT_OK : WEFT_ERR_ARGUMENT;
fail:
    return WEFT_ERR_ARGUMENT;
}

enum { MAX_NAMES = 32 };

static void log_unknown(const struct weft_log *log, const char *name)
{
    const char *names[MAX_NAMES + 1] = {NULL};
    char explanation[256];
    for (int i = 0; i < MAX_NAMES && weft_profile_list[i]; i++)
        names[i] = weft_profile_list[i]->name;
    weft_error(log, "no profile '%.64s'%s", name,
               weft_closest_explain(name, strlen(name), names, explanation, sizeof explanation));
}

enum weft_result weft_profile_parse(const struct weft_log *log, const char *text,
                                    struct weft_profile *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct reader reader = {log, out};
    char copy[sizeof out->name], *rest = copy;
    *out = unorm8;
    if (strlen(text) >= sizeof copy) {
        weft_error(log, "profile: '%.16s...' is longer than %zu bytes", text, sizeof copy - 1);
        goto fail;
    }
    strcpy(copy, text);
    for (char *part = strsep(&rest, ","); part; part = strsep(&rest, ",")) {
        if (part == copy && !strchr(part, '=')) {
            const struct weft_profile *named = weft_profile_find(part);
            if (!named) {
                log_unknown(log, part);
                goto fail;
            }
            *out = *named;
        } else if (!read_pair(&reader, part)) {
            goto fail;
        }
    }
    if (!check_inside(log, out))
        goto fail;
    if (strchr(text, '='))
        snprintf(out->description, sizeof out->description, "a user's own");
    strcpy(out->name, text);
    res = WEFT_OK;
fail:
    return res;
}
