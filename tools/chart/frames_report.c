// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart --accumulate` tells: CSV, JSON and the front as a table.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"

static const char *rounding_name(const struct chart_frames_point *p)
{
    const bool rounds = p->method.method == WEFT_ACCUMULATE_TREE && p->method.bits < 32;
    return rounds ? weft_tree_rounding_names[p->method.rounding] : "";
}

// ---- CSV ----------------------------------------------------------------------------------------

static const char *const columns[] = {
    "label", "method", "bits",      "branching", "rounding",   "frames", "seconds", "runs",
    "bytes", "passes", "max_error", "rms_error", "mean_error", "bound",  "bias",    "front",
};
enum { COLUMNS = sizeof columns / sizeof *columns };

static bool fill_row(struct cells *cells, int row, const struct chart_frames_point *p)
{
    const double numbers[] = {p->max_error, p->rms_error, p->mean_error, p->bound, p->bias};
    bool good = cells_set(cells, row, 0, "%s", p->label) &&
                cells_set(cells, row, 1, "%s", weft_accumulate_method_names[p->method.method]) &&
                cells_set(cells, row, 2, "%d", p->method.bits) &&
                cells_set(cells, row, 3, "%d", p->method.branching) &&
                cells_set(cells, row, 4, "%s", rounding_name(p)) &&
                cells_set(cells, row, 5, "%" PRId64, p->frames) &&
                cells_set(cells, row, 6, "%.17g", p->seconds) &&
                cells_set(cells, row, 7, "%d", p->runs) &&
                cells_set(cells, row, 8, "%" PRIu64, p->bytes) &&
                cells_set(cells, row, 9, "%" PRIu64, p->passes) &&
                cells_set(cells, row, COLUMNS - 1, "%d", p->front);
    for (int i = 0; i < 5 && good; i++)
        good = cells_set(cells, row, 10 + i, "%.17g", numbers[i]);
    return good;
}

bool chart_frames_fill_csv(const struct chart_job *job, struct cells *cells)
{
    const struct chart_frames *f = &job->frames;
    int row = 1;
    bool good = cells_create(cells, (int)f->measured + 1, COLUMNS);
    for (int i = 0; i < COLUMNS && good; i++)
        good = cells_set(cells, 0, i, "%s", columns[i]);
    for (size_t i = 0; i < f->points && good; i++)
        if (!*f->point[i].reason)
            good = fill_row(cells, row++, &f->point[i]);
    return good;
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *point_json(const struct chart_frames_point *p, uint64_t samples)
{
    json_t *object = json_pack("{s:o,s:s,s:i,s:I}", "label", json_text(p->label), "method",
                               weft_accumulate_method_names[p->method.method], "bits",
                               p->method.bits, "frames", (json_int_t)p->frames);
    if (p->method.method == WEFT_ACCUMULATE_TREE)
        json_object_set_new(object, "branching", json_integer(p->method.branching));
    if (*rounding_name(p))
        json_object_set_new(object, "rounding", json_text(rounding_name(p)));
    if (*p->reason) {
        json_object_set_new(object, "reason", json_text(p->reason));
        return object;
    }
    const struct run_stage frame = {"frame", p->seconds / (double)p->frames};
    json_object_set_new(object, "seconds", run_report_seconds(&frame, 1, p->seconds));
    json_object_set_new(object, "runs", json_integer(p->runs));
    json_object_set_new(object, "bytes", run_report_bytes("held", p->bytes));
    json_object_set_new(object, "passes", json_count(p->passes));
    json_t *error = run_report_error(p->max_error, p->rms_error, samples, "value", NULL, 0);
    json_object_set_new(error, "mean", json_number(p->mean_error));
    json_object_set_new(object, "error", error);
    json_object_set_new(object, "bound", json_number(p->bound));
    json_object_set_new(object, "bias", json_number(p->bias));
    json_object_set_new(object, "front", json_boolean(p->front));
    return object;
}

json_t *chart_frames_json(const struct chart_job *job)
{
    const struct chart_frames *f = &job->frames;
    json_t *points = json_array(), *skipped = json_array();
    const uint64_t samples = 4 * (uint64_t)f->width * (uint64_t)f->height; // channels
    for (size_t i = 0; i < f->points; i++)
        json_array_append_new(*f->point[i].reason ? skipped : points,
                              point_json(&f->point[i], samples));
    return json_pack("{s:i,s:i,s:o,s:o}", "width", f->width, "height", f->height, "points", points,
                     "skipped", skipped);
}

// ---- text ---------------------------------------------------------------------------------------

static int compare_points(const void *a, const void *b)
{
    const struct chart_frames_point *x = *(struct chart_frames_point *const *)a;
    const struct chart_frames_point *y = *(struct chart_frames_point *const *)b;
    if (x->frames != y->frames)
        return x->frames > y->frames ? 1 : -1;
    return (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

static bool fill_front(struct chart_frames_point **front, size_t count, struct cells *cells)
{
    static const char *const heads[] = {"method", "frames",     "ms",   "ms/frame",
                                        "error",  "mean error", "bound"};
    bool good = cells_create(cells, (int)count + 1, 7);
    cells->text_columns = 1;
    for (int i = 0; i < 7 && good; i++)
        good = cells_set(cells, 0, i, "%s", heads[i]);
    for (size_t i = 0; i < count && good; i++) {
        const struct chart_frames_point *p = front[i];
        const int row = (int)i + 1;
        good = cells_set(cells, row, 0, "%s", p->label) &&
               cells_set(cells, row, 1, "%" PRId64, p->frames) &&
               cells_set(cells, row, 2, "%.3g", 1e3 * p->seconds) &&
               cells_set(cells, row, 3, "%.3g", 1e3 * p->seconds / (double)p->frames) &&
               cells_set(cells, row, 4, "%.3g", 255.0 * p->max_error) &&
               cells_set(cells, row, 5, "%.3g", 255.0 * p->mean_error) &&
               cells_set(cells, row, 6, "%.3g", 255.0 * p->bound);
    }
    return good;
}

// All methods of the largest number of frames, and the front of the others.
enum weft_result chart_frames_print(const struct chart_job *job)
{
    const struct chart_frames *f = &job->frames;
    struct chart_frames_point **shown = calloc(f->points + 1, sizeof(struct chart_frames_point *));
    struct cells cells = {0};
    size_t count = 0;
    for (size_t i = 0; shown && i < f->points; i++)
        if (!*f->point[i].reason &&
            (f->point[i].front || f->point[i].frames == f->count[f->counts - 1]))
            shown[count++] = &f->point[i];
    if (shown)
        qsort(shown, count, sizeof(struct chart_frames_point *), compare_points);
    const bool good = shown && fill_front(shown, count, &cells);
    if (good) {
        printf("%zu averages of frames of %d x %d pixels measured, %zu skipped; of the largest "
               "number of\nframes all, of others what nothing beats in both time and error. Errors "
               "are in codes of 8 bits.\n",
               f->measured, f->width, f->height, f->points - f->measured);
        cells_print(&cells, CELLS_TEXT, stdout);
    }
    cells_destroy(&cells);
    free(shown);
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}
