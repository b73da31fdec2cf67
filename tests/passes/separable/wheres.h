// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/separable/wheres.h - all that separable filtering runs on here: the GL contexts that
// are to be had, and the CPU engine with every set of instructions that runs and both kinds of
// sums. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_SEPARABLE_WHERES_H
#define WEFT_TESTS_PASSES_SEPARABLE_WHERES_H

#include "tests/support/common.h"
#include "weft.h"

struct where {
    char name[48];
    enum weft_engine engine;
    enum weft_sums sums;
    struct weft_separable_compile_params compile;
};

// OSMesa and EGL where they are to be had, and then the CPU engine: at least plain C in both sums.
static struct where wheres[2 + 2 * 4];
static int where_count, first_cpu;

static inline void add_context(enum weft_context_kind kind, const char *name)
{
    weft_context *context = NULL;
    if (!WITHOUT_GL)
        weft_context_create(&(struct weft_context_params){.kind = kind}, &context);
    if (!context) {
        print_message("[  SKIPPED ] what %s would do: it is not to be had\n", name);
        return;
    }
    struct where *where = &wheres[where_count++];
    *where = (struct where){.compile = {.context = context}};
    snprintf(where->name, sizeof where->name, "%s", name);
}

static inline void add_cpu(enum weft_instruction_set set, enum weft_sums sums)
{
    struct where *where = &wheres[where_count++];
    *where = (struct where){.engine = WEFT_ENGINE_CPU,
                            .sums = sums,
                            .compile = {.cpu = {.instructions = set, .threads = 1 + (int)set}}};
    snprintf(where->name, sizeof where->name, "cpu %s %s", weft_instruction_set_names[set],
             weft_sums_names[sums]);
}

static inline int create_wheres(void **state)
{
    (void)state;
    add_context(WEFT_CONTEXT_OSMESA, "osmesa");
    add_context(WEFT_CONTEXT_EGL, "egl");
    first_cpu = where_count;
    for (int set = WEFT_INSTRUCTIONS_PLAIN; weft_instruction_set_names[set]; set++)
        for (int sums = 0; weft_sums_names[sums]; sums++)
            if (weft_instruction_set_runs((enum weft_instruction_set)set))
                add_cpu((enum weft_instruction_set)set, (enum weft_sums)sums);
    assert_true(where_count >= first_cpu + 2);
    return 0;
}

static inline int destroy_wheres(void **state)
{
    (void)state;
    for (int w = 0; w < first_cpu; w++)
        weft_context_destroy(&wheres[w].compile.context);
    return 0;
}

#endif
