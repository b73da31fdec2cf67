// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart` tells: CSV, JSON and the front as a table.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/cells.h"
#include "tools/chart/chart.h"
#include "tools/common/json.h"
#include "tools/common/paths.h"

const char *chart_name(const struct chart_job *job, const struct chart *chart)
{
    return chart == &job->methods ? "methods" : "truth";
}

const char *chart_kernel_text(const struct chart *chart, const struct chart_point *point)
{
    return chart->kernel[point->kernel < 0 ? 0 : point->kernel].text;
}

const char *chart_source_name(const struct chart_job *job)
{
    return job->signal ? job->signal->name : paths_base_name(job->path);
}

// ---- CSV ----------------------------------------------------------------------------------------

static const char *const columns[] = {
    "chart",     "technique",    "label",        "kernel",  "voxels",
    "seconds",   "read_seconds", "pass_seconds", "runs",    "bytes",
    "max_error", "rms_error",    "bound",        "checked", "front",
};
enum { COLUMNS = sizeof columns / sizeof *columns };

// An empty cell where there is no number.
static bool set_number(struct cells *cells, int row, int column, double value)
{
    return isnan(value) || cells_set(cells, row, column, "%.17g", value);
}

static bool fill_row(struct cells *cells, int row, const char *name, const struct chart *chart,
                     const struct chart_point *p)
{
    return cells_set(cells, row, 0, "%s", name) && cells_set(cells, row, 1, "%s", p->technique) &&
           cells_set(cells, row, 2, "%s", p->label) &&
           cells_set(cells, row, 3, "%s", chart_kernel_text(chart, p)) &&
           cells_set(cells, row, 4, "%d", p->voxels) && set_number(cells, row, 5, p->seconds) &&
           set_number(cells, row, 6, p->read_seconds) &&
           set_number(cells, row, 7, p->pass_seconds) && cells_set(cells, row, 8, "%d", p->runs) &&
           cells_set(cells, row, 9, "%llu", (unsigned long long)p->bytes) &&
           set_number(cells, row, 10, p->max_error) && set_number(cells, row, 11, p->rms_error) &&
           set_number(cells, row, 12, p->bound) &&
           cells_set(cells, row, 13, "%llu", (unsigned long long)p->pixels_checked) &&
           cells_set(cells, row, 14, "%d", p->front);
}

static bool fill_csv(const struct chart_job *job, struct cells *cells)
{
    if (job->has_frames)
        return chart_frames_fill_csv(job, cells);
    if (job->has_edges)
        return chart_edges_fill_csv(job, cells);
    const struct chart *const charts[] = {&job->methods, &job->truth};
    int row = 1;
    bool good = cells_create(cells, (int)(job->methods.count + job->truth.count) + 1, COLUMNS);
    for (int i = 0; i < COLUMNS && good; i++)
        good = cells_set(cells, 0, i, "%s", columns[i]);
    for (int c = 0; c < 2; c++)
        for (size_t i = 0; i < charts[c]->count && good; i++)
            good =
                fill_row(cells, row++, chart_name(job, charts[c]), charts[c], &charts[c]->point[i]);
    return good;
}

enum weft_result chart_save_csv(const struct chart_job *job, const char *path)
{
    struct cells cells = {0};
    char *text = NULL;
    size_t size = 0;
    enum weft_result res = WEFT_ERR_MEMORY;
    FILE *out = fill_csv(job, &cells) ? open_memstream(&text, &size) : NULL;
    if (out)
        cells_print(&cells, CELLS_CSV, out);
    if (out && report_close(out))
        res = weft_file_save(report_log(), path, false, text, size);
    free(text);
    cells_destroy(&cells);
    return res;
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *point_json(const struct chart *chart, const struct chart_point *p)
{
    json_t *object =
        json_pack("{s:o,s:o,s:o}", "technique", json_text(p->technique), "label",
                  json_text(p->label), "kernel", json_text(chart_kernel_text(chart, p)));
    if (p->voxels)
        json_object_set_new(object, "voxels", json_integer(p->voxels));
    if (*p->reason) {
        json_object_set_new(object, "reason", json_text(p->reason));
        return object;
    }
    const struct run_stage stages[] = {{"read", p->read_seconds}, {"passes", p->pass_seconds}};
    json_object_set_new(object, "seconds", run_report_seconds(stages, 2, p->seconds));
    json_object_set_new(object, "runs", json_integer(p->runs));
    json_object_set_new(object, "bytes", run_report_bytes("held", p->bytes));
    json_object_set_new(
        object, "error",
        run_report_error(p->max_error, p->rms_error, p->pixels_checked, "value", NULL, 0));
    json_object_set_new(object, "bound", json_number(p->bound));
    json_object_set_new(object, "front", json_boolean(p->front));
    return object;
}

static json_t *chart_json(const struct chart *chart)
{
    json_t *points = json_array(), *skipped = json_array();
    for (size_t i = 0; i < chart->count; i++)
        json_array_append_new(points, point_json(chart, &chart->point[i]));
    for (size_t i = 0; i < chart->skipped_count; i++)
        json_array_append_new(skipped, point_json(chart, &chart->skipped[i]));
    return json_pack("{s:o,s:o}", "points", points, "skipped", skipped);
}

static json_t *slice_json(const struct chart_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    return json_pack("{s:o,s:o,s:o,s:o,s:i,s:i,s:o,s:o}", "plane", json_text(job->plane), "origin",
                     json_numbers(g->origin, 3), "u", json_numbers(g->u, 3), "v",
                     json_numbers(g->v, 3), "width", g->width, "height", g->height, "low",
                     json_number(job->statistics.voxel_low), "high",
                     json_number(job->statistics.voxel_high));
}

enum weft_result chart_print_json(const struct chart_job *job)
{
    json_t *root =
        json_pack("{s:o,s:b}", "machine", json_text(job->machine), "interrupted", job->interrupted);
    if (job->has_methods || job->has_truth)
        json_object_set_new(root, "source", json_text(chart_source_name(job)));
    json_object_set_new(root, "context", run_report_context(job->context));
    json_object_set_new(root, "instructions",
                        json_text(weft_instruction_set_names[job->engine.cpu.instructions]));
    json_object_set_new(root, "threads", json_integer(job->engine.cpu.threads));
    if (job->has_methods) {
        json_object_set_new(root, "slice", slice_json(job));
        json_object_set_new(root, "methods", chart_json(&job->methods));
    }
    if (job->has_truth)
        json_object_set_new(root, "truth", chart_json(&job->truth));
    if (job->has_frames)
        json_object_set_new(root, "frames", chart_frames_json(job));
    if (job->has_edges)
        json_object_set_new(root, "antialias", chart_edges_json(job));
    return json_print(root);
}

// ---- text ---------------------------------------------------------------------------------------

static int compare_seconds(const void *a, const void *b)
{
    const struct chart_point *x = *(struct chart_point *const *)a;
    const struct chart_point *y = *(struct chart_point *const *)b;
    return (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

static bool fill_front(const struct chart *chart, bool truth, struct chart_point **front,
                       size_t count, struct cells *cells)
{
    static const char *const heads[] = {"method", "kernel", "ms", "max error", "rms error", "MiB"};
    bool good = cells_create(cells, (int)count + 1, truth ? 7 : 6);
    cells->text_columns = 2;
    for (int i = 0; i < 6 && good; i++)
        good = cells_set(cells, 0, i, "%s", heads[i]);
    if (good && truth)
        good = cells_set(cells, 0, 6, "voxels");
    for (size_t i = 0; i < count && good; i++) {
        const struct chart_point *p = front[i];
        const int row = (int)i + 1;
        good = cells_set(cells, row, 0, "%s", p->label) &&
               cells_set(cells, row, 1, "%s", chart_kernel_text(chart, p)) &&
               cells_set(cells, row, 2, "%.3g", 1e3 * p->seconds) &&
               cells_set(cells, row, 3, "%.3g", p->max_error) &&
               cells_set(cells, row, 4, "%.3g", p->rms_error) &&
               cells_set(cells, row, 5, "%.1f", (double)p->bytes / 0x1p20) &&
               (!truth || cells_set(cells, row, 6, "%d^3", p->voxels));
    }
    return good;
}

static enum weft_result print_front(const struct chart *chart, bool truth)
{
    struct chart_point **front = calloc(chart->count + 1, sizeof(struct chart_point *));
    struct cells cells = {0};
    size_t count = 0;
    for (size_t i = 0; front && i < chart->count; i++)
        if (chart->point[i].front)
            front[count++] = &chart->point[i];
    if (front)
        qsort(front, count, sizeof(struct chart_point *), compare_seconds);
    bool good = front && fill_front(chart, truth, front, count, &cells);
    if (good)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
    free(front);
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}

enum weft_result chart_print(const struct chart_job *job)
{
    enum weft_result res = WEFT_OK;
    if (job->has_methods && job->methods.count) {
        printf("%zu methods measured, %zu skipped; none is faster and more accurate than:\n",
               job->methods.count, job->methods.skipped_count);
        res = print_front(&job->methods, false);
    }
    if (job->has_truth && job->truth.count && res == WEFT_OK) {
        printf("%s%zu measured against the signal itself, %zu skipped; on the front are:\n",
               job->has_methods ? "\n" : "", job->truth.count, job->truth.skipped_count);
        res = print_front(&job->truth, true);
    }
    if (job->has_frames && job->frames.measured && res == WEFT_OK)
        res = chart_frames_print(job);
    if (job->has_edges && job->edges.measured && res == WEFT_OK)
        res = chart_edges_print(job);
    return res;
}
