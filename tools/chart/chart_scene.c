// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart` slices: a volume or a sampled signal, and the plane through it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"

enum { WAYS_VOXELS = 128, QUICK_WAYS_VOXELS = 64, DEFAULT_SIZE = 512, QUICK_SIZE = 256 };

// Edges of the oblique plane in units of a box's edges: along no axis, and within the box.
static const double oblique_u[3] = {0.80, 0.15, 0.25};
static const double oblique_v[3] = {-0.15, 0.80, 0.35};

static const char *const axes = "xyz";

static int axis_of(const char *plane)
{
    const char *axis = strlen(plane) == 1 ? strchr(axes, *plane) : NULL;
    return axis ? (int)(axis - axes) : -1;
}

// Nine finite numbers.
static bool parse_edges(const char *text, double out[9])
{
    for (int i = 0; i < 9; i++) {
        char *end;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || *end != (i < 8 ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

enum weft_result chart_plane_check(const struct option_value *plane)
{
    double edges[9];
    if (!plane->given || strcmp(plane->text, "oblique") == 0 || axis_of(plane->text) >= 0 ||
        parse_edges(plane->text, edges))
        return WEFT_OK;
    report_error("--plane %s: not oblique, x, y, z or nine finite numbers OX,OY,OZ,UX,UY,UZ,"
                 "VX,VY,VZ",
                 plane->text);
    return WEFT_ERR_ARGUMENT;
}

static void set_oblique(const double centre[3], const double edge[3],
                        struct weft_slice_geometry *out)
{
    for (int a = 0; a < 3; a++) {
        out->u[a] = oblique_u[a] * edge[a];
        out->v[a] = oblique_v[a] * edge[a];
        out->origin[a] = centre[a] - 0.5 * (out->u[a] + out->v[a]);
    }
}

static void set_size(const struct chart_job *job, struct weft_slice_geometry *geometry)
{
    const struct option_value *size = &job->option[CHART_SIZE];
    const int initial = job->option[CHART_QUICK].given ? QUICK_SIZE : DEFAULT_SIZE;
    geometry->width = size->given ? (int)size->integer[0] : initial;
    geometry->height = size->given ? (int)size->integer[1] : initial;
}

enum weft_result chart_sample(const struct weft_signal_info *signal, int voxels, weft_volume **out)
{
    const size_t n = (size_t)voxels;
    float *data = malloc(n * n * n * sizeof *data);
    if (!data) {
        report_error("out of memory for %d^3 voxels", voxels);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < n * n * n; i++) {
        const double position[3] = {weft_signal_coordinate((int64_t)(i % n), voxels),
                                    weft_signal_coordinate((int64_t)(i / n % n), voxels),
                                    weft_signal_coordinate((int64_t)(i / n / n), voxels)};
        data[i] = (float)signal->value(position);
    }
    enum weft_result res =
        weft_volume_create(weft_volume_params(.size = {voxels, voxels, voxels}, .data = data,
                                              .name = signal->name, .log = report_log()),
                           out);
    free(data);
    return res;
}

static enum weft_result open_volume(const struct chart_job *job, struct chart_scene *out)
{
    if (job->signal) {
        out->signal = job->signal;
        out->voxels = job->option[CHART_QUICK].given ? QUICK_WAYS_VOXELS : WAYS_VOXELS;
        return chart_sample(job->signal, out->voxels, &out->volume);
    }
    const struct weft_volume_open_params params = {
        .path = job->path,
        .grid = job->option[CHART_GRID].text,
        .raw = job->raw,
        .log = report_log(),
    };
    return weft_volume_open(&params, &out->volume);
}

static enum weft_result choose_plane(struct chart_job *job, struct chart_scene *scene)
{
    const struct option_value *plane = &job->option[CHART_PLANE];
    const struct weft_volume_info *info = weft_volume_get_info(scene->volume);
    struct weft_slice_geometry *g = &scene->geometry;
    set_size(job, g);
    const int axis = plane->given ? axis_of(plane->text) : -1;
    if (axis >= 0) {
        snprintf(job->plane, sizeof job->plane, "slice across %c", axes[axis]);
        return weft_slice_axis_geometry(report_log(), scene->volume, WEFT_SPACE_INDEX, axis, NAN,
                                        g->width, g->height, g);
    }
    double edges[9];
    if (plane->given && parse_edges(plane->text, edges)) {
        snprintf(job->plane, sizeof job->plane, "slice as given");
        memcpy(g->origin, edges, sizeof g->origin);
        memcpy(g->u, edges + 3, sizeof g->u);
        memcpy(g->v, edges + 6, sizeof g->v);
        return WEFT_OK;
    }
    snprintf(job->plane, sizeof job->plane, "oblique slice");
    double centre[3], edge[3];
    for (int a = 0; a < 3; a++) {
        centre[a] = 0.5 * ((double)info->active_min[a] + info->active_max[a]);
        edge[a] = (double)info->active_max[a] - info->active_min[a] + 1.0;
    }
    set_oblique(centre, edge, g);
    return WEFT_OK;
}

enum weft_result chart_scene_create(struct chart_job *job, struct chart_scene *out)
{
    *out = (struct chart_scene){0};
    enum weft_result res = open_volume(job, out);
    if (res == WEFT_OK)
        res = choose_plane(job, out);
    if (res != WEFT_OK)
        chart_scene_destroy(out);
    job->geometry = out->geometry;
    return res;
}

enum weft_result chart_truth_scene_create(const struct chart_job *job, int voxels, double margin,
                                          struct chart_scene *out)
{
    *out = (struct chart_scene){.voxels = voxels, .signal = job->signal};
    set_size(job, &out->geometry);
    // Where position 0 and an edge of 2 (1 - margin) lie in index space: see
    // weft_signal_coordinate.
    const double centre = 0.5 * voxels - 0.5, edge = voxels * (1.0 - margin);
    set_oblique((const double[3]){centre, centre, centre}, (const double[3]){edge, edge, edge},
                &out->geometry);
    return chart_sample(job->signal, voxels, &out->volume);
}

void chart_scene_destroy(struct chart_scene *scene)
{
    weft_volume_destroy(&scene->volume);
    *scene = (struct chart_scene){0};
}

double chart_scene_truth(const struct chart_scene *scene, int x, int y)
{
    const struct weft_slice_geometry *g = &scene->geometry;
    double position[3];
    for (int a = 0; a < 3; a++) {
        const double index =
            g->origin[a] + (x + 0.5) / g->width * g->u[a] + (y + 0.5) / g->height * g->v[a];
        position[a] = -1.0 + (2.0 * index + 1.0) / scene->voxels;
    }
    return scene->signal->value(position);
}
