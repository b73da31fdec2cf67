// SPDX-License-Identifier: BSD-3-Clause
// tests/support/contexts.h - the GL contexts that are to be had, for tests that run on all of them.
// Include after cmocka.h.
#ifndef WEFT_TESTS_SUPPORT_CONTEXTS_H
#define WEFT_TESTS_SUPPORT_CONTEXTS_H

#include <stdlib.h>

#include "passes/gl/context.h"

// OSMesa and EGL; the first is there, the second may be NULL.
static weft_context *contexts[2];

// ctest's word for a test that was skipped.
enum { EXIT_SKIPPED = 77 };

static inline int create_contexts(void **state)
{
    static const enum weft_context_kind kinds[2] = {WEFT_CONTEXT_OSMESA, WEFT_CONTEXT_EGL};
    (void)state;
    for (int c = 0; c < 2; c++)
        weft_context_create(&(struct weft_context_params){.kind = kinds[c]}, &contexts[c]);
    if (!contexts[0]) {
        contexts[0] = contexts[1];
        contexts[1] = NULL;
    }
    if (!contexts[0]) {
        print_message("[  SKIPPED ] no GL context is to be had here\n");
        exit(EXIT_SKIPPED);
    }
    if (!contexts[1])
        print_message("[  SKIPPED ] what the second GL context would do: it is not to be had\n");
    return 0;
}

static inline int destroy_contexts(void **state)
{
    (void)state;
    for (int c = 0; c < 2; c++)
        weft_context_destroy(&contexts[c]);
    return 0;
}

#endif
