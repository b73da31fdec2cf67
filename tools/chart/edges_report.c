// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart --antialias` tells: CSV, JSON and a table.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "tools/chart/chart.h"

// ---- CSV ----------------------------------------------------------------------------------------

static const char *const columns[] = {
    "label", "way",           "samples", "filter",    "seconds",   "runs",
    "bytes", "formula_bytes", "marked",  "max_error", "rms_error", "front",
};
enum { COLUMNS = sizeof columns / sizeof *columns };

static bool fill_row(struct cells *cells, int row, const struct chart_edges_point *p)
{
    return cells_set(cells, row, 0, "%s", p->label) &&
           cells_set(cells, row, 1, "%s", antialias_way_names[p->way.way]) &&
           cells_set(cells, row, 2, "%d", p->way.samples) &&
           cells_set(cells, row, 3, "%s", chart_edges_filters[p->filter]) &&
           cells_set(cells, row, 4, "%.17g", p->seconds) &&
           cells_set(cells, row, 5, "%d", p->runs) &&
           cells_set(cells, row, 6, "%" PRIu64, p->bytes) &&
           cells_set(cells, row, 7, "%" PRIu64, p->formula_bytes) &&
           (isnan(p->marked) || cells_set(cells, row, 8, "%.17g", p->marked)) &&
           cells_set(cells, row, 9, "%.17g", p->max_error) &&
           cells_set(cells, row, 10, "%.17g", p->rms_error) &&
           cells_set(cells, row, 11, "%d", p->front);
}

bool chart_edges_fill_csv(const struct chart_job *job, struct cells *cells)
{
    const struct chart_edges *e = &job->edges;
    int row = 1;
    bool good = cells_create(cells, (int)e->measured + 1, COLUMNS);
    for (int i = 0; i < COLUMNS && good; i++)
        good = cells_set(cells, 0, i, "%s", columns[i]);
    for (size_t i = 0; i < e->points && good; i++)
        if (!*e->point[i].reason)
            good = fill_row(cells, row++, &e->point[i]);
    return good;
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *point_json(const struct chart_edges_point *p, uint64_t samples)
{
    json_t *object = json_pack("{s:o,s:s,s:i,s:s}", "label", json_text(p->label), "way",
                               antialias_way_names[p->way.way], "samples", p->way.samples, "filter",
                               chart_edges_filters[p->filter]);
    if (*p->reason) {
        json_object_set_new(object, "reason", json_text(p->reason));
        return object;
    }
    json_object_set_new(object, "seconds", run_report_total_seconds(p->seconds));
    json_object_set_new(object, "runs", json_integer(p->runs));
    json_object_set_new(object, "bytes",
                        json_pack("{s:o,s:o}", "held", json_count(p->bytes), "formula",
                                  json_count(p->formula_bytes)));
    if (!isnan(p->marked))
        json_object_set_new(object, "marked", json_number(p->marked));
    json_object_set_new(object, "error",
                        run_report_error(p->max_error, p->rms_error, samples, "light", NULL, 0));
    json_object_set_new(object, "front", json_boolean(p->front));
    return object;
}

json_t *chart_edges_json(const struct chart_job *job)
{
    const struct chart_edges *e = &job->edges;
    json_t *points = json_array(), *skipped = json_array();
    const uint64_t samples = 3 * (uint64_t)e->width * (uint64_t)e->height; // R, G and B
    for (size_t i = 0; i < e->points; i++)
        json_array_append_new(*e->point[i].reason ? skipped : points,
                              point_json(&e->point[i], samples));
    return json_pack("{s:o,s:i,s:i,s:o,s:o,s:o}", "scene", json_text(e->scene), "width", e->width,
                     "height", e->height, "exact_error", json_number(e->exact_error), "points",
                     points, "skipped", skipped);
}

// ---- text ---------------------------------------------------------------------------------------

static bool fill_table(const struct chart_edges *e, struct cells *cells)
{
    static const char *const heads[] = {"way",       "ms",  "largest error", "RMS error",
                                        "marked, %", "MiB", "MiB by formula"};
    int row = 1;
    bool good = cells_create(cells, (int)e->measured + 1, 7);
    cells->text_columns = 1;
    for (int i = 0; i < 7 && good; i++)
        good = cells_set(cells, 0, i, "%s", heads[i]);
    for (size_t i = 0; i < e->points && good; i++) {
        const struct chart_edges_point *p = &e->point[i];
        if (*p->reason)
            continue;
        good = cells_set(cells, row, 0, "%s%s", p->label, p->front ? " *" : "") &&
               cells_set(cells, row, 1, "%.3g", 1e3 * p->seconds) &&
               cells_set(cells, row, 2, "%.3g", p->max_error) &&
               cells_set(cells, row, 3, "%.3g", p->rms_error) &&
               (isnan(p->marked) || cells_set(cells, row, 4, "%.1f", 100.0 * p->marked)) &&
               cells_set(cells, row, 5, "%.2f", (double)p->bytes / 0x1p20) &&
               cells_set(cells, row, 6, "%.2f", (double)p->formula_bytes / 0x1p20);
        row++;
    }
    return good;
}

enum weft_result chart_edges_print(const struct chart_job *job)
{
    const struct chart_edges *e = &job->edges;
    struct cells cells = {0};
    const bool good = fill_table(e, &cells);
    if (good) {
        report_line("%s, %d x %d pixels: %zu ways measured, %zu skipped; of those with a star none "
                    "is faster and",
                    e->scene, e->width, e->height, e->measured, e->points - e->measured);
        printf("more accurate by the same filter. Errors are of values from 0 to 1, against exact "
               "coverage.\n");
        cells_print(&cells, CELLS_TEXT, stdout);
    }
    cells_destroy(&cells);
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}
