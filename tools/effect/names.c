// SPDX-License-Identifier: BSD-3-Clause
#include <string.h>

#include "tools/common/log.h"
#include "tools/effect/effect.h"

const char *const effect_names[] = {"fade",        "motion-blur", "antialias", "dof",
                                    "soft-shadow", "radiosity",   NULL};

// The bit of the first `length` bytes of a text; 0: there is no such name.
static unsigned find_bit(const char *text, size_t length)
{
    for (int i = 0; effect_names[i]; i++)
        if (strlen(effect_names[i]) == length && !memcmp(effect_names[i], text, length))
            return 1u << i;
    return 0;
}

enum weft_result effect_parse(const struct weft_log *log, const char *text, unsigned *out)
{
    *out = 0;
    unsigned effects = 0;
    for (const char *at = text;; at++) {
        const size_t length = strcspn(at, "+");
        const unsigned bit = find_bit(at, length);
        if (!bit) {
            char explanation[256];
            log_error(log, "no effect '%.*s'%s, several in one run with + between them",
                      length > 48 ? 48 : (int)length, at,
                      weft_closest_explain(at, length, effect_names, explanation,
                                           sizeof explanation));
            return WEFT_ERR_ARGUMENT;
        }
        if (effects & bit) {
            log_error(log, "effect %.*s is named twice", (int)length, at);
            return WEFT_ERR_ARGUMENT;
        }
        effects |= bit;
        at += length;
        if (!*at)
            break;
    }
    if ((effects & EFFECT_SOFT_SHADOW) && (effects & EFFECT_RADIOSITY)) {
        log_error(log, "radiosity has soft shadows: leave soft-shadow out");
        return WEFT_ERR_ARGUMENT;
    }
    *out = effects;
    return WEFT_OK;
}
