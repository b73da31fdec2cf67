// SPDX-License-Identifier: BSD-3-Clause
// tests/support/json.h - what the command prints as JSON; a test fails where it is none.
#ifndef WEFT_TESTS_SUPPORT_JSON_H
#define WEFT_TESTS_SUPPORT_JSON_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <jansson.h>

// A new reference.
static inline json_t *parse(const char *text)
{
    json_error_t error;
    json_t *root = json_loads(text, 0, &error);
    if (!root)
        fail_msg("line %d: %s in: %.200s", error.line, error.text, text);
    return root;
}

static inline double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value))
        fail_msg("no number %s", key);
    return json_number_value(value);
}

#endif
