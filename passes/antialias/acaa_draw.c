// SPDX-License-Identifier: BSD-3-Clause
// The passes of accumulative anti-aliasing: depths, then colours of what is at those depths, then
// what is at none.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/acaa_impl.h"
#include "passes/gl/program.h"

char *weft_acaa_head_make(const struct weft_acaa_params *params, const struct weft_acaa_plan *plan)
{
    const struct weft_acaa_layers *l = &plan->layers;
    const bool post_depth = plan->form == WEFT_ACAA_POST_DEPTH;
    char *head = NULL;
    const int length = asprintf(
        &head,
        "%s%s"
        "#define POST_DEPTH %d\n#define COINCIDENT %d\n#define FLOATS %d\n#define SUM_WORDS %d\n"
        "#define WEIGHT_WORDS %d\n#define DEVICE %d\n#define SIDE %d\n#define TOTAL %" PRId64 "\n"
        "#define BOX %d\n#define WEIGHT_LAYER %d\n#define WEIGHT_SHIFT %d\n"
        "#define BACKGROUND_LAYER %d\n#define CLAIMS_UNIT %d\n#define SUMS_UNIT %d\n"
        "#define TABLE_UNIT %d\n#define PASS_BINDING %d\n%s",
        params->sums == WEFT_ACAA_FLOAT ? WEFT_HEAD_45 : WEFT_HEAD_42,
        post_depth ? "#extension GL_ARB_post_depth_coverage : require\n" : "", post_depth,
        (int)params->coincident, params->sums == WEFT_ACAA_FLOAT, l->sum_words, l->weight_words,
        plan->pattern.device_count, plan->side, plan->total, plan->box, l->weight, l->weight_shift,
        l->background, WEFT_ACAA_CLAIMS_UNIT, WEFT_ACAA_SUMS_UNIT, WEFT_ACAA_TABLE_UNIT,
        WEFT_ACAA_PASS_BINDING, weft_shader_acaa_head);
    return length < 0 ? NULL : head;
}

static struct weft_pass_state visible_state(const struct weft_acaa *a)
{
    struct weft_pass_state state = {.depth_func = GL_EQUAL};
    // Samples are counted up from 0 by the first surface that they are of.
    if (a->params.coincident == WEFT_COINCIDENT_STENCIL) {
        state.stencil.func = GL_EQUAL;
        state.stencil.read = state.stencil.write = 1;
        state.stencil.pass = GL_INCR;
    }
    return state;
}

static enum weft_result draw_background(struct weft_acaa *a)
{
    const GladGLContext *gl = &a->params.context->gl;
    const struct weft_acaa_target *t = &a->target;
    const struct weft_pass_state state = visible_state(a);
    const struct weft_rectangle part = weft_acaa_target_part(a);
    weft_pass_state_begin(gl, t->framebuffer, t->width, t->height, &part, &state);
    gl->DepthRange(1.0, 1.0); // exactly what depths are cleared with
    gl->UseProgram(t->background);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->UseProgram(0);
    gl->DepthRange(0.0, 1.0);
    weft_pass_state_end(gl);
    return weft_gl_check(a->params.log, gl, "counting samples without a surface");
}

// A picture that is drawn again reports what is done only where that is more than before.
static enum weft_result report_progress(struct weft_acaa *a, const struct weft_progress *progress,
                                        int done, int count)
{
    const double fraction = (double)done / count;
    a->reported = fraction > a->reported ? fraction : a->reported;
    if (!progress || !progress->report || progress->report(progress->priv, a->reported))
        return WEFT_OK;
    weft_note(a->params.log, "acaa: stopped after %d of %d passes", done, count);
    return WEFT_ERR_CANCELLED;
}

static enum weft_result call(struct weft_acaa *a, const struct weft_antialias_drawing *drawing,
                             struct weft_antialias_pass *pass, enum weft_antialias_stage stage)
{
    const struct weft_pass_state depth = {.depth_func = GL_LESS, .depth_write = true};
    const struct weft_pass_state colour = visible_state(a);
    const bool depths = stage == WEFT_STAGE_DEPTH;
    pass->stage = stage;
    pass->head = depths ? weft_head_depth : a->head;
    const enum weft_result res = weft_drawing_run(a->params.log, a->params.context, drawing, pass,
                                                  depths ? &depth : &colour);
    pass->index++;
    a->report.callbacks++;
    return res;
}

static enum weft_result draw_pass(struct weft_acaa *a, const struct weft_antialias_drawing *drawing,
                                  struct weft_antialias_pass *pass, int number)
{
    weft_drawing_place(a->params.width, a->params.height, a->plan.rim,
                       a->plan.pattern.offset[number], pass->place);
    weft_acaa_target_begin(a, number);
    enum weft_result res = call(a, drawing, pass, WEFT_STAGE_DEPTH);
    if (res == WEFT_OK)
        res = call(a, drawing, pass, WEFT_STAGE_COLOUR);
    if (res == WEFT_OK)
        res = draw_background(a);
    weft_acaa_target_end(a);
    return res;
}

enum weft_result weft_acaa_draw(struct weft_acaa *a, const struct weft_antialias_drawing *drawing,
                                const struct weft_progress *progress)
{
    const int passes = a->plan.pattern.passes;
    struct weft_antialias_pass pass = {.count = 2 * passes,
                                       .framebuffer = a->target.framebuffer,
                                       .width = a->target.width,
                                       .height = a->target.height,
                                       .part = weft_acaa_target_part(a)};
    enum weft_result res = weft_acaa_target_clear(a);
    for (int i = 0; res == WEFT_OK && i < passes; i++) {
        res = draw_pass(a, drawing, &pass, i);
        if (res == WEFT_OK)
            res = report_progress(a, progress, i + 1, passes);
    }
    return res == WEFT_OK ? weft_acaa_target_read(a) : res;
}
