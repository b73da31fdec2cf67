// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/engine_options.h"

#include <math.h>
#include <stdio.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/methods/cost_file.h"

const char *const engine_choices[] = {"auto", "gl", "cpu", NULL};

// ---- options ------------------------------------------------------------------------------------

// What of the options contradicts what.
static enum weft_result check(const struct option_value *o, const char *gl_option)
{
    const char *const gl = o[ENGINE_CONTEXT].given ? "--context" : gl_option;
    const bool cpu = o[ENGINE_ENGINE].integer[0] == 1 + WEFT_ENGINE_CPU;
    const bool gl_asked = o[ENGINE_ENGINE].integer[0] == 1 + WEFT_ENGINE_GL;
    const bool doubles = o[ENGINE_SUMS].integer[0] == WEFT_SUMS_DOUBLE;
    if (cpu && gl)
        report_error("%s is of OpenGL: it makes no sense with --engine cpu", gl);
    else if (doubles && (gl || gl_asked))
        report_error("OpenGL sums in single precision: %s makes no sense with --sums double",
                     gl ? gl : "--engine gl");
    else if (o[ENGINE_THREADS].given && gl_asked)
        report_error("--threads is of the CPU engine: it makes no sense with --engine gl");
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_threads(const struct option_value *o, int *out)
{
    const double n = o->number[0];
    if (o->given && !(n >= 1.0 && n <= WEFT_CPU_MAX_THREADS && n == floor(n))) {
        report_error("--threads %s: not a whole number from 1 to %d", o->text,
                     WEFT_CPU_MAX_THREADS);
        return WEFT_ERR_ARGUMENT;
    }
    *out = (int)n;
    return WEFT_OK;
}

enum weft_result engine_options_read(const struct option_value *o, const char *gl_option,
                                     struct engine *out)
{
    const bool gl = o[ENGINE_CONTEXT].given || gl_option;
    *out = (struct engine){.sums = (enum weft_sums)o[ENGINE_SUMS].integer[0]};
    out->automatic = o[ENGINE_ENGINE].integer[0] == 0 && !gl && out->sums == WEFT_SUMS_FLOAT;
    if (o[ENGINE_ENGINE].integer[0] == 1 + WEFT_ENGINE_CPU || out->sums == WEFT_SUMS_DOUBLE)
        out->engine = WEFT_ENGINE_CPU;
    enum weft_result res = check(o, gl_option);
    if (res == WEFT_OK)
        res = read_threads(&o[ENGINE_THREADS], &out->cpu.threads);
    if (res == WEFT_OK)
        res = weft_cpu_resolve(report_log(), &out->cpu, &out->cpu);
    if (res == WEFT_OK && o[ENGINE_CONTEXT].given)
        res = weft_context_kind_parse(report_log(), o[ENGINE_CONTEXT].text, &out->kind);
    out->model = weft_cost_default;
    return res;
}

// ---- decisions ----------------------------------------------------------------------------------

void engine_load_costs(struct engine *engine, const weft_context *context)
{
    const char *renderer = context ? weft_context_get_info(context)->renderer : NULL;
    if (!engine->loaded)
        engine->calibrated = cost_file_load(engine->kind, renderer, &engine->model);
    engine->loaded = true;
}

void engine_prefer(struct engine *engine, const weft_slice_plan *plan)
{
    if (!engine->automatic || engine->preferred)
        return;
    engine->preferred = true;
    engine_load_costs(engine, NULL);
    if (engine->calibrated)
        engine->engine = weft_choose_engine(&engine->model, plan, engine->cpu.threads);
}

static void tell(void *priv, enum weft_log_level level, const char *message)
{
    struct engine *engine = priv;
    if (engine->holds_errors && level == WEFT_LOG_ERROR)
        snprintf(engine->message, sizeof engine->message, "%s", message);
    else
        report_log()->write(report_log()->priv, level, message);
}

static enum weft_result begin(struct engine *engine)
{
    engine->log = (struct weft_log){tell, engine};
    return weft_context_begin(weft_context_params(.kind = engine->kind, .log = &engine->log),
                              &engine->making);
}

enum weft_result engine_begin_context(struct engine *engine)
{
    if (engine->automatic)
        engine_load_costs(engine, NULL);
    if (engine->engine == WEFT_ENGINE_CPU || (engine->automatic && engine->calibrated))
        return WEFT_OK;
    return begin(engine);
}

void engine_abandon_context(struct engine *engine)
{
    weft_context_abandon(&engine->making);
}

enum weft_result engine_create_context(struct engine *engine, weft_context **context)
{
    if (*context || engine->engine == WEFT_ENGINE_CPU)
        return WEFT_OK;
    enum weft_result res = engine->making ? WEFT_OK : begin(engine);
    if (res != WEFT_OK)
        return res;
    engine->holds_errors = engine->automatic;
    res = weft_context_await(&engine->making, context);
    engine->holds_errors = false;
    if (res == WEFT_OK || !engine->automatic)
        return res;
    if (res != WEFT_ERR_CONTEXT) {
        report_error("%s", engine->message);
        return res;
    }
    report_tell("%s: going on with the CPU engine", engine->message);
    engine->engine = WEFT_ENGINE_CPU;
    engine->automatic = false;
    return WEFT_OK;
}

unsigned engine_candidates(const struct engine *engine, const weft_context *context)
{
    const bool gpu = context && weft_context_get_info(context)->hardware;
    return engine->automatic && (engine->calibrated || !gpu) ? 0 : 1u << engine->engine;
}

bool engine_has_more_candidates(const struct engine *engine, unsigned *engines)
{
    const bool more = engine->automatic && *engines;
    if (more)
        *engines = 0;
    return more;
}

// ---- reports ------------------------------------------------------------------------------------

const char *engine_model_name(const struct engine *engine, char text[ENGINE_TEXT])
{
    const struct weft_cost_model *m = &engine->model;
    if (engine->calibrated)
        snprintf(text, ENGINE_TEXT, "%s%s%s, %d threads", m->renderer, m->renderer[0] ? "; " : "",
                 weft_instruction_set_names[m->instructions], m->threads);
    else
        snprintf(text, ENGINE_TEXT, "defaults");
    return text;
}

void engine_set_json(json_t *root, const struct engine *engine, enum weft_engine taken,
                     enum weft_sums sums)
{
    json_object_set_new(root, "engine", json_text(weft_engine_names[taken]));
    if (taken != WEFT_ENGINE_CPU)
        return;
    json_object_set_new(root, "instructions",
                        json_text(weft_instruction_set_names[engine->cpu.instructions]));
    json_object_set_new(root, "threads", json_integer(engine->cpu.threads));
    json_object_set_new(root, "sums", json_text(weft_sums_names[sums]));
}

const char *engine_format(const struct engine *engine, enum weft_engine taken, enum weft_sums sums,
                          char text[ENGINE_TEXT])
{
    if (taken == WEFT_ENGINE_CPU)
        snprintf(text, ENGINE_TEXT, "CPU engine, %s, %d thread%s, %s sums",
                 weft_instruction_set_names[engine->cpu.instructions], engine->cpu.threads,
                 engine->cpu.threads == 1 ? "" : "s", weft_sums_names[sums]);
    else
        snprintf(text, ENGINE_TEXT, "OpenGL");
    return text;
}

size_t engine_attributes(const struct engine *engine, enum weft_sums sums,
                         struct weft_metadata out[ENGINE_ATTRIBUTES])
{
    size_t count = 0;
    run_report_add(out, &count, "engine", "%s", weft_engine_names[WEFT_ENGINE_CPU]);
    run_report_add(out, &count, "instructions", "%s",
                   weft_instruction_set_names[engine->cpu.instructions]);
    run_report_add(out, &count, "sums", "%s", weft_sums_names[sums]);
    return count;
}
