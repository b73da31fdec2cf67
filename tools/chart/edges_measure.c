// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart --antialias` measures: ways of anti-aliasing one scene, against the exact
// coverage of its polygons.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"
#include "tools/render/drawing.h"
#include "tools/scene/exact.h"

enum { CHANNELS = 4, COLOURS = 3 };

// Random polygons of 50 pixels, as dense as 4,000 of them on 512 x 512 pixels: a scene of Lin, Lau,
// Lin and Cheung.
static const char default_scene[] = "polygons:1000,50", quick_scene[] = "polygons:250,50";
enum { DEFAULT_SIZE = 256, QUICK_SIZE = 128 };

// For the chart as a whole, and more runs of a way until then.
static const double BUDGET_SECONDS = 150.0, QUICK_BUDGET_SECONDS = 30.0;
static const double RUNS_SECONDS = 0.5, QUICK_RUNS_SECONDS = 0.05;
enum { LEAST_RUNS = 3 };

const char *const chart_edges_filters[CHART_EDGES_FILTERS] = {"nearest", "linear", "mitchell",
                                                              "lanczos:3"};

struct bench {
    struct chart_job *job;
    struct scene scene;
    scene_drawing *drawing;
    double *exact[CHART_EDGES_FILTERS]; // [y][x][CHANNELS]; NULL: not made yet
    float *pixels[CHANNELS];            // of the last picture
    char reason[CHART_REASON];          // why the last way failed
    double start, budget;
};

void chart_edges_read(struct chart_job *job)
{
    const struct option_value *o = job->option;
    struct chart_edges *e = &job->edges;
    const bool quick = o[CHART_QUICK].given;
    snprintf(e->scene, sizeof e->scene, "%s",
             o[CHART_SCENE].given ? o[CHART_SCENE].text
             : quick              ? quick_scene
                                  : default_scene);
    e->width = o[CHART_SIZE].given ? (int)o[CHART_SIZE].integer[0]
               : quick             ? QUICK_SIZE
                                   : DEFAULT_SIZE;
    e->height = o[CHART_SIZE].given ? (int)o[CHART_SIZE].integer[1] : e->width;
}

// ---- all ways -----------------------------------------------------------------------------------

static void list_way(struct chart_edges *e, struct antialias_params way, int filter)
{
    static const char *const names[ANTIALIAS_WAY_COUNT] = {[ANTIALIAS_NONE] = "none",
                                                           [ANTIALIAS_MSAA] = "MSAA",
                                                           [ANTIALIAS_ACAA] = "ACAA",
                                                           [ANTIALIAS_ADAPTIVE] = "adaptive"};
    struct chart_edges_point *point = &e->point[e->points++];
    *point = (struct chart_edges_point){.way = way, .filter = filter, .marked = NAN};
    const int side = (int)lround(sqrt(way.samples));
    const char *comma = filter ? ", " : "", *kernel = filter ? chart_edges_filters[filter] : "";
    if (way.way == ANTIALIAS_NONE)
        snprintf(point->label, CHART_TEXT, "none");
    else if (way.way == ANTIALIAS_SUPERSAMPLE)
        snprintf(point->label, CHART_TEXT, "%d x %d%s%s", side, side, comma, kernel);
    else if (way.way == ANTIALIAS_ADAPTIVE)
        snprintf(point->label, CHART_TEXT, "%s %d x %d%s%s%s", names[way.way], side, side,
                 way.mark == WEFT_MARK_VISIBLE ? ", visible" : "", comma, kernel);
    else
        snprintf(point->label, CHART_TEXT, "%s %d%s%s", names[way.way], way.samples, comma, kernel);
}

static void list_ways(struct chart_edges *e, weft_context *context)
{
    static const int sums[] = {4, 8, 16, 64}, grids[] = {4, 16, 64};
    list_way(e, (struct antialias_params){.way = ANTIALIAS_NONE, .samples = 1}, 0);
    for (int n = 2; n <= 16; n *= 2) { // as the device has
        double positions[WEFT_PATTERN_MAX][2];
        if (weft_msaa_positions(context, n, positions) == n)
            list_way(e, (struct antialias_params){.way = ANTIALIAS_MSAA, .samples = n}, 0);
    }
    for (int i = 0; i < 4; i++)
        list_way(e, (struct antialias_params){.way = ANTIALIAS_ACAA, .samples = sums[i]}, 0);
    for (int i = 0; i < 3; i++)
        list_way(e, (struct antialias_params){.way = ANTIALIAS_SUPERSAMPLE, .samples = grids[i]},
                 0);
    for (int i = 1; i < 3; i++)
        list_way(e, (struct antialias_params){.way = ANTIALIAS_ADAPTIVE, .samples = grids[i]}, 0);
    list_way(e,
             (struct antialias_params){
                 .way = ANTIALIAS_ADAPTIVE, .samples = 16, .mark = WEFT_MARK_VISIBLE},
             0);
    for (int f = 1; f < CHART_EDGES_FILTERS; f++) {
        list_way(e, (struct antialias_params){.way = ANTIALIAS_ACAA, .samples = 16}, f);
        list_way(e, (struct antialias_params){.way = ANTIALIAS_ADAPTIVE, .samples = 16}, f);
        list_way(e, (struct antialias_params){.way = ANTIALIAS_SUPERSAMPLE, .samples = 16}, f);
    }
}

// ---- one way ------------------------------------------------------------------------------------

static void keep_reason(void *priv, enum weft_log_level level, const char *message)
{
    struct bench *b = priv;
    if (level == WEFT_LOG_ERROR && !*b->reason)
        snprintf(b->reason, sizeof b->reason, "%s", message);
}

static bool go_on(const struct bench *b, size_t done)
{
    const struct weft_progress *all = report_progress("measuring");
    return all->report(all->priv, (double)done / (double)b->job->edges.points);
}

static int compare_numbers(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum weft_result draw(struct bench *b, antialias_drawer *drawer)
{
    const struct weft_antialias_drawing drawing = {.draw = scene_drawing_pass, .priv = b->drawing};
    enum weft_result res = antialias_drawer_run(drawer, &drawing, 0, NULL);
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++)
        res = antialias_drawer_read(drawer, c, b->pixels[c]);
    return res;
}

// A picture that makes shaders first, then those that count.
static enum weft_result run_way(struct bench *b, antialias_drawer *drawer,
                                struct chart_edges_point *point)
{
    const double wanted = b->job->option[CHART_QUICK].given ? QUICK_RUNS_SECONDS : RUNS_SECONDS;
    enum weft_result res = draw(b, drawer);
    double spent = 0.0;
    while (res == WEFT_OK && point->runs < CHART_RUNS &&
           (spent < wanted || (point->runs < LEAST_RUNS && spent < 4.0 * wanted))) {
        const double start = report_now_seconds();
        res = draw(b, drawer);
        point->run[point->runs] = report_now_seconds() - start;
        spent += point->run[point->runs++];
    }
    if (res != WEFT_OK)
        return res;
    double sorted[CHART_RUNS];
    memcpy(sorted, point->run, (size_t)point->runs * sizeof *sorted);
    qsort(sorted, (size_t)point->runs, sizeof *sorted, compare_numbers);
    point->seconds = 0.5 * (sorted[(point->runs - 1) / 2] + sorted[point->runs / 2]);
    return WEFT_OK;
}

static size_t pixels_of(const struct chart_edges *e)
{
    return (size_t)e->width * (size_t)e->height;
}

static void set_errors(const struct bench *b, struct chart_edges_point *point)
{
    const size_t pixels = pixels_of(&b->job->edges);
    const double *exact = b->exact[point->filter];
    double squares = 0.0, most = 0.0;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < COLOURS; c++) {
            const double error = (double)b->pixels[c][i] - exact[CHANNELS * i + (size_t)c];
            squares += error * error;
            most = fabs(error) <= most ? most : fabs(error); // NAN stays
        }
    point->max_error = most;
    point->rms_error = sqrt(squares / (double)(COLOURS * pixels));
}

static enum weft_result make_exact(struct bench *b, int filter)
{
    struct chart_edges *e = &b->job->edges;
    struct weft_kernel kernel;
    double error = 0.0;
    if (b->exact[filter])
        return WEFT_OK;
    b->exact[filter] = malloc(pixels_of(e) * CHANNELS * sizeof *b->exact[filter]);
    enum weft_result res = b->exact[filter] ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_kernel_parse(report_log(), chart_edges_filters[filter], &kernel);
    if (res == WEFT_OK)
        res = scene_exact_draw(scene_exact_params(.scene = &b->scene, .size = {e->width, e->height},
                                                  .filter = kernel, .log = report_log(),
                                                  .progress = report_progress("exact coverage")),
                               b->exact[filter], &error);
    e->exact_error = fmax(e->exact_error, error);
    return res;
}

static enum weft_result create_drawer(struct bench *b, const struct chart_edges_point *point,
                                      const struct weft_log *log, antialias_drawer **out)
{
    struct antialias_params params = point->way;
    params.size[0] = b->job->edges.width;
    params.size[1] = b->job->edges.height;
    params.background = b->scene.background;
    params.context = b->job->context;
    params.log = log;
    b->reason[0] = 0;
    *out = NULL;
    const enum weft_result res =
        weft_kernel_parse(log, chart_edges_filters[point->filter], &params.filter);
    return res == WEFT_OK ? antialias_drawer_create(&params, out) : res;
}

static enum weft_result measure_point(struct bench *b, struct chart_edges_point *point)
{
    if (report_now_seconds() - b->start > b->budget) {
        snprintf(point->reason, sizeof point->reason, "the chart's %g s are over", b->budget);
        return WEFT_OK;
    }
    const struct weft_log log = {.write = keep_reason, .priv = b};
    antialias_drawer *drawer;
    enum weft_result res = make_exact(b, point->filter);
    if (res != WEFT_OK)
        return res;
    res = create_drawer(b, point, &log, &drawer);
    if (res == WEFT_OK)
        res = run_way(b, drawer, point);
    if (res == WEFT_OK) {
        struct antialias_report report;
        antialias_drawer_get_report(drawer, &report);
        point->bytes = report.bytes;
        point->formula_bytes = report.formula_bytes;
        if (point->way.way == ANTIALIAS_ADAPTIVE)
            point->marked = (double)report.marks->count / (double)pixels_of(&b->job->edges);
        set_errors(b, point);
    } else if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT) {
        snprintf(point->reason, sizeof point->reason, "%s", b->reason);
        res = WEFT_OK;
    } else if (res != WEFT_ERR_CANCELLED) {
        report_error("%s: %s", point->label, *b->reason ? b->reason : weft_result_text(res));
    }
    antialias_drawer_destroy(&drawer);
    return res;
}

// ---- the chart ----------------------------------------------------------------------------------

static bool beats(const struct chart_edges_point *a, const struct chart_edges_point *b)
{
    return a->filter == b->filter && !*a->reason && a->seconds <= b->seconds &&
           a->rms_error <= b->rms_error && (a->seconds < b->seconds || a->rms_error < b->rms_error);
}

static void find_front(struct chart_edges *e)
{
    for (size_t i = 0; i < e->points; i++) {
        e->point[i].front = !*e->point[i].reason;
        for (size_t j = 0; j < e->points && e->point[i].front; j++)
            e->point[i].front = !beats(&e->point[j], &e->point[i]);
    }
}

static enum weft_result prepare(void *priv)
{
    struct bench *b = priv;
    const struct scene_frame frame = {
        .camera = {.size = {b->job->edges.width, b->job->edges.height}}};
    return scene_drawing_prepare(b->drawing, &frame);
}

static enum weft_result set_up(struct bench *b)
{
    const struct chart_edges *e = &b->job->edges;
    enum weft_result res = scene_make(
        scene_params(.name = e->scene, .size = {e->width, e->height}, .log = report_log()),
        &b->scene);
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++) {
        b->pixels[c] = malloc(pixels_of(e) * sizeof *b->pixels[c]);
        res = b->pixels[c] ? WEFT_OK : WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = make_exact(b, 0);
    if (res == WEFT_OK)
        res = scene_drawing_create(scene_drawing_params(.scene = &b->scene,
                                                        .context = b->job->context,
                                                        .log = report_log()),
                                   &b->drawing);
    return res == WEFT_OK ? weft_context_call(b->job->context, prepare, b) : res;
}

static void clear(struct bench *b)
{
    scene_drawing_destroy(&b->drawing);
    scene_clear(&b->scene);
    for (int i = 0; i < CHART_EDGES_FILTERS; i++)
        free(b->exact[i]);
    for (int c = 0; c < CHANNELS; c++)
        free(b->pixels[c]);
}

enum weft_result chart_edges_measure(struct chart_job *job)
{
    const bool quick = job->option[CHART_QUICK].given;
    struct chart_edges *e = &job->edges;
    struct bench b = {.job = job,
                      .start = report_now_seconds(),
                      .budget = quick ? QUICK_BUDGET_SECONDS : BUDGET_SECONDS};
    if (!job->context) {
        report_error("--antialias draws on OpenGL, which is not to be had with these options");
        return WEFT_ERR_CONTEXT;
    }
    enum weft_result res = set_up(&b);
    if (res == WEFT_OK)
        list_ways(e, job->context);
    for (size_t i = 0; i < e->points && res == WEFT_OK; i++) {
        res = go_on(&b, i) ? measure_point(&b, &e->point[i]) : WEFT_ERR_CANCELLED;
        if (res != WEFT_OK)
            e->points = i;
        else
            e->measured += !*e->point[i].reason;
    }
    find_front(e);
    clear(&b);
    return res;
}
