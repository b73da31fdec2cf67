// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/outputs.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

__attribute__((format(printf, 2, 3))) static void add(char *defines, const char *format, ...)
{
    const size_t length = strlen(defines);
    va_list list;
    va_start(list, format);
    vsnprintf(defines + length, WEFT_FUSED_DEFINES - length, format, list);
    va_end(list);
}

// What outputs need: orders along each axis, and pairs of those along x and y.
struct needs {
    bool order[3][WEFT_LINE_ORDERS], pair[WEFT_LINE_ORDERS][WEFT_LINE_ORDERS];
};

static struct needs find_needs(const struct weft_slice_plan *plan)
{
    struct needs needs = {0};
    for (int o = 0; o < plan->info.output_count; o++) {
        const int *along = plan->info.output[o].derivative.along;
        for (int a = 0; a < 3; a++)
            needs.order[a][along[a]] = true;
        needs.pair[along[0]][along[1]] = true;
    }
    return needs;
}

// Tiles of orders 1 and 2, where there are some.
static void add_tiles(const struct weft_slice_plan *plan, char *defines)
{
    for (int n = 1; n < WEFT_LINE_ORDERS; n++)
        if (plan->weights[n])
            add(defines, "#define DEGREE_%d %d\n#define SEGMENTS_%d %d\n", n,
                plan->weights[n]->tiles.degree, n, plan->weights[n]->tiles.segments);
}

static void add_weights(const struct needs *needs, char *defines)
{
    static const char *const functions[WEFT_LINE_ORDERS] = {"kernel_weights", "kernel_weights_1",
                                                            "kernel_weights_2"};
    add(defines, "#define EACH_WEIGHTS(F)");
    for (int a = 0; a < 3; a++)
        for (int n = 0; n < WEFT_LINE_ORDERS; n++)
            if (needs->order[a][n])
                add(defines, " F(%s, t.%c, %c%d)", functions[n], "xyz"[a], "xyz"[a], n);
    add(defines, "\n#define EACH_SHIFT(F)");
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        if (needs->order[0][n])
            add(defines, " F(x%d, shifted%d)", n, n);
    add(defines, "\n#define EACH_ROW(F)");
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        if (needs->order[0][n])
            add(defines, " F(row%d, ROW_WEIGHTS_%d)", n, n);
    add(defines, "\n");
}

static void add_sums(const struct weft_slice_plan *plan, const struct needs *needs, char *defines)
{
    add(defines, "#define EACH_PLANE(F)");
    for (int x = 0; x < WEFT_LINE_ORDERS; x++)
        for (int y = 0; y < WEFT_LINE_ORDERS; y++)
            if (needs->pair[x][y])
                add(defines, " F(plane%d%d, row%d, y%d)", x, y, x, y);
    add(defines, "\n#define EACH_SUM(F)");
    for (int o = 0; o < plan->info.output_count; o++) {
        const int *n = plan->info.output[o].derivative.along;
        add(defines, " F(sum%d, plane%d%d, x%d, y%d, z%d, %d.0)", o, n[0], n[1], n[0], n[1], n[2],
            n[0] + n[1] + n[2] == 0);
    }
    add(defines, "\n");
}

// Four outputs to a target, zeros behind the last one; of constant cells, the value `c` and what
// derivatives are, `d`.
static void add_stores(const struct weft_slice_plan *plan, bool constants, char *defines)
{
    const int count = plan->info.output_count;
    add(defines, "#define STORE_%s", constants ? "CONSTANTS" : "SUMS");
    for (int o = 0; o < 4 * weft_fused_target_count(count); o++) {
        const int *n = plan->info.output[o < count ? o : 0].derivative.along;
        if (o % 4 == 0)
            add(defines, " value[%d] = vec4(", o / 4);
        if (o >= count)
            add(defines, "0.0");
        else if (constants)
            add(defines, n[0] + n[1] + n[2] == 0 ? "c" : "d");
        else
            add(defines, "sum%d", o);
        add(defines, o % 4 == 3 ? ");" : ", ");
    }
    add(defines, "\n");
}

void weft_fused_define_outputs(const struct weft_slice_plan *plan, char *defines)
{
    const struct needs needs = find_needs(plan);
    add(defines, "#define TARGETS %d\n", weft_fused_target_count(plan->info.output_count));
    add_tiles(plan, defines);
    add_weights(&needs, defines);
    add_sums(plan, &needs, defines);
    add_stores(plan, false, defines);
    add_stores(plan, true, defines);
}
