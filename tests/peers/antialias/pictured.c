// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/antialias/pictured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tools/render/lamps.h"
#include "tools/scene/exact.h"

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}
const struct weft_log pictured_log = {.write = say};

static size_t pixels_of(const struct pictured *p)
{
    return (size_t)p->size[0] * (size_t)p->size[1];
}

// ---- flat scenes --------------------------------------------------------------------------------

// What a triangle reflects of a light from above, the left and the front, and of light from
// everywhere.
static void set_colour(struct weft_mesh_vertex corner[3], const struct scene_material *material)
{
    static const double light[3] = {-0.39, 0.78, 0.47};
    double edge[2][3], normal[3], length = 0.0, shade = 0.0;
    for (int i = 0; i < 3; i++) {
        edge[0][i] = (double)corner[1].position[i] - (double)corner[0].position[i];
        edge[1][i] = (double)corner[2].position[i] - (double)corner[0].position[i];
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = edge[0][j] * edge[1][k] - edge[0][k] * edge[1][j];
        length = hypot(length, normal[i]);
    }
    for (int i = 0; i < 3 && length > 0.0; i++)
        shade += normal[i] / length * light[i];
    shade = 0.15 + 0.75 * fmax(shade, 0.0);
    for (int i = 0; i < 3; i++) {
        const double of = (double)corner[0].colour[i] * (double)material->reflectance[i];
        corner[0].colour[i] = corner[1].colour[i] = corner[2].colour[i] =
            (float)fmin(of * shade + (double)material->emission[i], 1.0);
    }
}

// Every triangle gets corners of its own, where objects are at time 0.
static bool flatten(struct scene *s)
{
    struct weft_mesh_vertex *corners = calloc(s->index_count, sizeof *corners);
    if (!corners)
        return false;
    for (int o = 0; o < s->object_count; o++) {
        const struct scene_object *object = &s->objects[o];
        for (uint32_t i = object->first_index; i < object->first_index + object->index_count; i++)
            corners[i] = s->vertices[s->indices[i]];
        for (uint32_t i = object->first_index; i < object->first_index + object->index_count;
             i += 3)
            if (!s->materials[object->material].unlit)
                set_colour(corners + i, &s->materials[object->material]);
    }
    for (size_t i = 0; i < s->index_count; i++)
        s->indices[i] = (uint32_t)i;
    free(s->vertices);
    s->vertices = corners;
    s->vertex_count = s->index_count;
    for (int m = 0; m < s->material_count; m++)
        s->materials[m] = (struct scene_material){.reflectance = {1.0f, 1.0f, 1.0f},
                                                  .unlit = true,
                                                  .single_sided = s->materials[m].single_sided};
    s->light_count = 0;
    return true;
}

// ---- scenes -------------------------------------------------------------------------------------

static enum weft_result prepare(void *priv)
{
    const struct pictured *p = priv;
    struct scene_frame frame = {.camera = {.size = {p->size[0], p->size[1]}}};
    scene_lamps_in_middle(&p->scene, &frame);
    return scene_drawing_prepare(p->drawing, &frame);
}

bool pictured_create(weft_context *context, const char *name, bool flat, const int size[2],
                     struct pictured *out)
{
    *out = (struct pictured){.context = context, .size = {size[0], size[1]}};
    enum weft_result res = scene_make(
        scene_params(.name = name, .size = {size[0], size[1]}, .log = &pictured_log), &out->scene);
    if (res == WEFT_OK && flat && !flatten(&out->scene))
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = scene_drawing_create(
            scene_drawing_params(.scene = &out->scene, .context = context, .log = &pictured_log),
            &out->drawing);
    if (res == WEFT_OK)
        res = weft_context_call(context, prepare, out);
    if (res != WEFT_OK)
        fprintf(stderr, "%s: %s\n", name, weft_result_text(res));
    return res == WEFT_OK;
}

void pictured_clear(struct pictured *pictured)
{
    scene_drawing_destroy(&pictured->drawing);
    scene_clear(&pictured->scene);
    *pictured = (struct pictured){0};
}

// ---- pictures -----------------------------------------------------------------------------------

antialias_drawer *pictured_make_drawer(const struct pictured *pictured, struct antialias_params how)
{
    antialias_drawer *drawer;
    memcpy(how.size, pictured->size, sizeof how.size);
    how.background = pictured->scene.background;
    how.context = pictured->context;
    how.log = &pictured_log;
    const enum weft_result res = antialias_drawer_create(&how, &drawer);
    if (res != WEFT_OK)
        fprintf(stderr, "%s: %s\n", pictured->scene.name, weft_result_text(res));
    return drawer;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double pictured_draw(const struct pictured *pictured, antialias_drawer *drawer,
                     float *const planes[4])
{
    const struct weft_antialias_drawing drawing = {.draw = scene_drawing_pass,
                                                   .priv = pictured->drawing};
    const double start = now();
    enum weft_result res = antialias_drawer_run(drawer, &drawing, 0, NULL);
    for (int c = 0; c < PICTURED_CHANNELS && res == WEFT_OK; c++)
        res = antialias_drawer_read(drawer, c, planes[c]);
    if (res == WEFT_OK)
        return now() - start;
    fprintf(stderr, "%s: %s\n", pictured->scene.name, weft_result_text(res));
    return -1.0;
}

bool pictured_allocate(const struct pictured *pictured, float *planes[4])
{
    bool good = true;
    for (int c = 0; c < PICTURED_CHANNELS; c++) {
        planes[c] = malloc(pixels_of(pictured) * sizeof *planes[c]);
        good = good && planes[c];
    }
    if (!good)
        fprintf(stderr, "out of memory for a picture of %d x %d pixels\n", pictured->size[0],
                pictured->size[1]);
    return good;
}

void pictured_free(float *planes[4])
{
    for (int c = 0; c < PICTURED_CHANNELS; c++)
        free(planes[c]);
}

double *pictured_make_exact(const struct pictured *pictured)
{
    double *exact = malloc(pixels_of(pictured) * PICTURED_CHANNELS * sizeof *exact);
    double error;
    struct weft_kernel kernel;
    enum weft_result res = exact ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_kernel_parse(&pictured_log, "nearest", &kernel);
    if (res == WEFT_OK)
        res = scene_exact_draw(scene_exact_params(.scene = &pictured->scene,
                                                  .size = {pictured->size[0], pictured->size[1]},
                                                  .filter = kernel, .log = &pictured_log),
                               exact, &error);
    if (res == WEFT_OK)
        return exact;
    fprintf(stderr, "%s: %s\n", pictured->scene.name, weft_result_text(res));
    free(exact);
    return NULL;
}

struct pictured_error pictured_compare(const struct pictured *pictured, float *const planes[4],
                                       const double *exact)
{
    const size_t pixels = pixels_of(pictured);
    struct pictured_error e = {0};
    for (size_t i = 0; i < pixels * PICTURED_COLOURS; i++) {
        const size_t c = i / pixels, p = i % pixels;
        const double d = fabs((double)planes[c][p] - exact[PICTURED_CHANNELS * p + c]);
        e.largest = d <= e.largest ? e.largest : isnan(d) ? (double)INFINITY : d;
        e.rms += isnan(d) ? (double)INFINITY : d * d;
    }
    e.rms = sqrt(e.rms / (double)(pixels * PICTURED_COLOURS));
    return e;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double pictured_median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}
