// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/drawn.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}
const struct weft_log drawn_log = {.write = say};

static size_t pixels_of(const struct drawn *drawn)
{
    return (size_t)drawn->size[0] * (size_t)drawn->size[1];
}

static bool add_scene(struct drawn *drawn, const char *name, int shadow_size)
{
    const int i = drawn->count++;
    const struct scene_params *params =
        scene_params(.name = name, .size = {drawn->size[0], drawn->size[1]}, .log = &drawn_log);
    return scene_make(params, &drawn->scene[i]) == WEFT_OK &&
           scene_drawing_create(scene_drawing_params(.scene = &drawn->scene[i],
                                                     .context = drawn->context,
                                                     .shadow_size = shadow_size, .log = &drawn_log),
                                &drawn->drawing[i]) == WEFT_OK;
}

bool drawn_create(weft_context *context, unsigned effect, const char *name, const int size[2],
                  int shadow_size, struct drawn *out)
{
    *out = (struct drawn){.context = context, .size = {size[0], size[1]}};
    if (name)
        return add_scene(out, name, shadow_size);
    bool ok = true;
    const char *const *names = scene_find_default(effect_names[__builtin_ctz(effect)]);
    for (; *names && ok; names++)
        ok = add_scene(out, *names, shadow_size);
    return ok;
}

void drawn_clear(struct drawn *drawn)
{
    for (int i = 0; i < drawn->count; i++) {
        scene_drawing_destroy(&drawn->drawing[i]);
        scene_clear(&drawn->scene[i]);
    }
    *drawn = (struct drawn){0};
}

enum weft_result drawn_plan(const struct drawn *drawn, struct effect_params asked,
                            struct effect_plan *out)
{
    for (int i = 0; i < drawn->count; i++)
        asked.scene[i] = &drawn->scene[i];
    asked.scene_count = drawn->count;
    asked.size[0] = drawn->size[0];
    asked.size[1] = drawn->size[1];
    asked.log = &drawn_log;
    return effect_plan_make(&asked, out);
}

enum weft_result drawn_average(const struct drawn *drawn, const struct effect_plan *plan,
                               struct weft_accumulator_params how, float *out,
                               struct weft_accumulator_report *report)
{
    weft_accumulator *a = NULL;
    double *weights = malloc((size_t)plan->count * sizeof *weights);
    if (!weights)
        return WEFT_ERR_MEMORY;
    effect_plan_get_weights(plan, weights);
    how.width = drawn->size[0];
    how.height = drawn->size[1];
    how.channel_count = DRAWN_CHANNELS;
    how.frame_count = plan->count;
    how.weight = weights;
    how.context = drawn->context;
    how.log = &drawn_log;
    enum weft_result res = weft_accumulator_create(&how, &a);
    free(weights);
    if (res == WEFT_OK)
        res = effect_run(
            effect_run_params(.plan = plan, .drawing = drawn->drawing, .accumulator = a), NULL);
    for (int c = 0; c < DRAWN_CHANNELS && res == WEFT_OK; c++)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c,
                                       out + (size_t)c * pixels_of(drawn), 0);
    if (res == WEFT_OK && report)
        weft_accumulator_get_report(a, report);
    weft_accumulator_destroy(&a);
    return res;
}

enum weft_result drawn_average_exactly(const struct drawn *drawn, const struct effect_plan *plan,
                                       float *out)
{
    return drawn_average(drawn, plan,
                         (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT,
                                                          .frame_bits = 32,
                                                          .nonfinite = WEFT_NONFINITE_PROPAGATE},
                         out, NULL);
}

struct drawn_error drawn_compare(const struct drawn *drawn, const float *a, const float *b)
{
    const size_t count = 3 * pixels_of(drawn);
    struct drawn_error e = {0};
    for (size_t i = 0; i < count; i++) {
        const double d = fabs((double)a[i] - (double)b[i]);
        e.largest = d <= e.largest ? e.largest : isnan(d) ? (double)INFINITY : d;
        e.rms += isnan(d) ? (double)INFINITY : d * d / (double)count;
    }
    e.rms = sqrt(e.rms);
    return e;
}
