// SPDX-License-Identifier: BSD-3-Clause
// Compiled plans, of whichever engine they are for.
#include <stdlib.h>

#include "passes/separable/cpu.h"
#include "passes/separable/gl.h"

static enum weft_result compile(const struct weft_separable_compile_params *params,
                                weft_separable *c)
{
    const weft_separable_plan *plan = c->plan;
    const bool gl = plan->info.engine == WEFT_ENGINE_GL;
    struct weft_cpu cpu;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(plan->log, gl == (params->context != NULL));
    if (gl)
        return weft_separable_gl_compile(params->context, plan, &c->gl);
    res = weft_cpu_resolve(plan->log, &params->cpu, &cpu);
    if (res == WEFT_OK)
        res = weft_separable_cpu_compile(plan, &cpu, &c->cpu);
fail:
    return res;
}

enum weft_result weft_separable_compile(const weft_separable_plan *plan,
                                        const struct weft_separable_compile_params *params,
                                        weft_separable **out)
{
    *out = NULL;
    weft_separable *c = calloc(1, sizeof *c);
    if (!c) {
        weft_error(plan->log, "not enough memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    c->plan = plan;
    const enum weft_result res = compile(params, c);
    if (res == WEFT_OK)
        *out = c;
    else
        weft_separable_destroy(&c);
    return res;
}

void weft_separable_destroy(weft_separable **compiled)
{
    if (!compiled || !*compiled)
        return;
    weft_separable_gl_destroy(&(*compiled)->gl);
    weft_separable_cpu_destroy(&(*compiled)->cpu);
    free(*compiled);
    *compiled = NULL;
}

enum weft_result weft_separable_run(weft_separable *compiled,
                                    const struct weft_separable_run_params *params,
                                    struct weft_separable_report *report)
{
    struct weft_separable_run_params p;
    struct weft_separable_report own;
    enum weft_result res = weft_separable_check_run(compiled->plan, params, &p);
    if (res != WEFT_OK)
        return res;
    res = compiled->gl ? weft_separable_gl_run(compiled->gl, &p, &own)
                       : weft_separable_cpu_run(compiled->cpu, &p, &own);
    if (res == WEFT_OK && report)
        *report = own;
    return res;
}
