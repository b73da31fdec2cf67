// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart --accumulate` measures: averages of frames by every method, over their number.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"
#include "tools/common/ending.h"

enum { DEFAULT_SIZE = 256, QUICK_SIZE = 128, CHANNELS = 4, MAX_METHODS = 32 };

// Frames that differ, a prime: more of them are these over again, and no node of a tree has the
// same ones below it as another.
enum { DIFFERENT = 61 };

// For the chart as a whole, and more runs of a method with so many frames until then.
static const double BUDGET_SECONDS = 150.0, QUICK_BUDGET_SECONDS = 30.0;
static const double RUNS_SECONDS = 0.3, QUICK_RUNS_SECONDS = 0.05;
enum { LEAST_RUNS = 3 };

struct bench {
    struct chart_job *job;
    uint8_t *codes;            // [DIFFERENT][y][x][CHANNELS]
    double *sums;              // [y][x][CHANNELS] of codes of the frames in hand
    float *pixels[CHANNELS];   // of the last run
    char reason[CHART_REASON]; // why the last run failed
    double start, budget;
    size_t done, total;
};

// ---- what was asked -----------------------------------------------------------------------------

static const char default_counts[] = "4,16,64,256,1024", quick_counts[] = "4,16,64";

static bool read_counts(struct chart_frames *f, const char *text)
{
    for (char *end; f->counts < CHART_MAX_COUNTS; text = end + 1) {
        const long long n = strtoll(text, &end, 10);
        if (end == text || n < 1 || n > WEFT_ACCUMULATE_MAX_FRAMES ||
            (f->counts && n <= f->count[f->counts - 1]))
            return false;
        f->count[f->counts++] = n;
        if (*end != ',')
            return !*end;
    }
    return false;
}

enum weft_result chart_frames_read(struct chart_job *job)
{
    const struct option_value *o = job->option;
    struct chart_frames *f = &job->frames;
    const bool quick = o[CHART_QUICK].given;
    const char *counts = o[CHART_FRAMES].given ? o[CHART_FRAMES].text
                         : quick               ? quick_counts
                                               : default_counts;
    f->width = o[CHART_SIZE].given ? (int)o[CHART_SIZE].integer[0]
               : quick             ? QUICK_SIZE
                                   : DEFAULT_SIZE;
    f->height = o[CHART_SIZE].given ? (int)o[CHART_SIZE].integer[1] : f->width;
    if (read_counts(f, counts))
        return WEFT_OK;
    report_error("--frames %s: not up to %d ascending numbers from 1 to %d, separated by commas",
                 counts, CHART_MAX_COUNTS, (int)WEFT_ACCUMULATE_MAX_FRAMES);
    return WEFT_ERR_ARGUMENT;
}

// ---- frames -------------------------------------------------------------------------------------

static size_t value_count(const struct chart_frames *f)
{
    return (size_t)f->width * (size_t)f->height * CHANNELS;
}

// A ramp, and on it noise as of a path tracer with few samples.
static void fill_codes(struct bench *b)
{
    const struct chart_frames *f = &b->job->frames;
    uint64_t state = 1;
    for (int i = 0; i < DIFFERENT; i++) {
        uint8_t *codes = b->codes + (size_t)i * value_count(f);
        for (size_t v = 0; v < value_count(f); v++) {
            const double x = (double)(v / CHANNELS % (size_t)f->width) / f->width;
            state = state * 6364136223846793005u + 1442695040888963407u;
            const double noise = (double)(state >> 40) / 0x1p24;
            codes[v] = (uint8_t)(191.0 * x + 64.0 * noise);
        }
    }
}

static void add_up(struct bench *b, int64_t count)
{
    const size_t values = value_count(&b->job->frames);
    memset(b->sums, 0, values * sizeof *b->sums);
    for (int i = 0; i < DIFFERENT && i < count; i++) {
        const uint8_t *codes = b->codes + (size_t)i * values;
        const double times = (double)((count - i + DIFFERENT - 1) / DIFFERENT);
        for (size_t v = 0; v < values; v++)
            b->sums[v] += times * codes[v];
    }
}

// ---- one method ---------------------------------------------------------------------------------

static void keep_reason(void *priv, enum weft_log_level level, const char *message)
{
    struct bench *b = priv;
    if (level == WEFT_LOG_ERROR && !*b->reason)
        snprintf(b->reason, sizeof b->reason, "%s", message);
}

static bool go_on(const struct bench *b)
{
    const struct weft_progress *all = report_progress("measuring");
    return all->report(all->priv, (double)b->done / (double)b->total);
}

static enum weft_result add_frames(struct bench *b, weft_accumulator *a, int64_t count)
{
    const size_t values = value_count(&b->job->frames);
    enum weft_result res = WEFT_OK;
    for (int64_t i = 0; i < count && res == WEFT_OK; i++) {
        struct weft_plane planes[CHANNELS];
        for (int c = 0; c < CHANNELS; c++)
            planes[c] =
                (struct weft_plane){.values = b->codes + (size_t)(i % DIFFERENT) * values + c,
                                    .type = WEFT_PLANE_UNORM8,
                                    .step = CHANNELS};
        res = weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, 1.0);
        if (res == WEFT_OK && i % 16 == 15 && !go_on(b))
            res = WEFT_ERR_CANCELLED;
    }
    return res;
}

// From frames in memory to floats in memory, once.
static enum weft_result run_once(struct bench *b, const struct chart_frames_point *point,
                                 struct weft_accumulator_report *report)
{
    const struct weft_log log = {.write = keep_reason, .priv = b};
    weft_accumulator *a = NULL;
    struct weft_accumulator_params params = point->method;
    params.width = b->job->frames.width;
    params.height = b->job->frames.height;
    params.channel_count = CHANNELS;
    params.frame_count = point->frames;
    params.context = b->job->context;
    params.cpu = b->job->engine.cpu;
    params.log = &log;
    b->reason[0] = 0;
    enum weft_result res = weft_accumulator_create(&params, &a);
    if (res == WEFT_OK)
        res = add_frames(b, a, point->frames);
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, b->pixels[c], 0);
    if (res == WEFT_OK)
        weft_accumulator_get_report(a, report);
    weft_accumulator_destroy(&a);
    return res;
}

static int compare_numbers(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Each after a short one that compiles shaders; the longest of them are run once.
static enum weft_result run_method(struct bench *b, struct chart_frames_point *point,
                                   struct weft_accumulator_report *report)
{
    const double wanted = b->job->option[CHART_QUICK].given ? QUICK_RUNS_SECONDS : RUNS_SECONDS;
    struct chart_frames_point first = *point;
    first.frames = first.frames < 8 ? first.frames : 8;
    enum weft_result res = run_once(b, &first, report);
    double spent = 0.0;
    while (res == WEFT_OK && point->runs < CHART_RUNS &&
           (spent < wanted || (point->runs < LEAST_RUNS && spent < 4.0 * wanted))) {
        const double start = report_now_seconds();
        res = run_once(b, point, report);
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

// Against the codes' exact mean.
static void set_errors(const struct bench *b, struct chart_frames_point *point)
{
    const size_t values = value_count(&b->job->frames);
    double squares = 0.0, sum = 0.0, most = 0.0;
    for (size_t v = 0; v < values; v++) {
        const double exact = b->sums[v] / (255.0 * (double)point->frames);
        const double error = (double)b->pixels[v % CHANNELS][v / CHANNELS] - exact;
        squares += error * error;
        sum += error;
        most = fabs(error) <= most ? most : fabs(error); // NAN stays
    }
    point->max_error = most;
    point->rms_error = sqrt(squares / (double)values);
    point->mean_error = sum / (double)values;
}

static enum weft_result measure_point(struct bench *b, struct chart_frames_point *point)
{
    struct weft_accumulator_report report = {0};
    if (report_now_seconds() - b->start > b->budget) {
        snprintf(point->reason, sizeof point->reason, "the chart's %g s are over", b->budget);
        return WEFT_OK;
    }
    const enum weft_result res = run_method(b, point, &report);
    if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT) {
        snprintf(point->reason, sizeof point->reason, "%s", b->reason);
        return WEFT_OK;
    }
    if (res != WEFT_OK) {
        if (res != WEFT_ERR_CANCELLED)
            report_error("%s: %s", point->label, *b->reason ? b->reason : weft_result_text(res));
        return res;
    }
    set_errors(b, point);
    point->bytes = report.bytes;
    point->passes = report.passes;
    point->bound = report.bound;
    point->bias = report.bias;
    return WEFT_OK;
}

// ---- all methods --------------------------------------------------------------------------------

static void list_method(struct chart_frames_point *methods, int *count,
                        enum chart_frames_family family, struct weft_accumulator_params method)
{
    methods[*count] = (struct chart_frames_point){.family = family, .method = method};
    char *label = methods[(*count)++].label;
    const char *name = weft_accumulate_method_names[method.method];
    if (method.method == WEFT_ACCUMULATE_TREE)
        snprintf(label, CHART_TEXT, "%s %d, %d bits%s", name, method.branching, method.bits,
                 method.rounding == WEFT_TREE_UNBIASED ? ", unbiased" : "");
    else if (method.bits == WEFT_ACCUMULATE_HALF)
        snprintf(label, CHART_TEXT, "%s half", name);
    else if (method.bits)
        snprintf(label, CHART_TEXT, "%s %d bits", name, method.bits);
    else
        snprintf(label, CHART_TEXT, "%s", name);
}

static void list_trees(struct chart_frames_point *methods, int *count)
{
    static const int bits[] = {8, 16, 32};
    for (int i = 0; i < 3; i++)
        for (int b = 2; b <= WEFT_TREE_MAX_INPUTS; b *= 2)
            for (int r = 0; r < (i == 0 ? 2 : 1); r++)
                list_method(methods, count, CHART_TREE_8 + (enum chart_frames_family)i,
                            (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_TREE,
                                                             .branching = b,
                                                             .bits = bits[i],
                                                             .rounding = r ? WEFT_TREE_UNBIASED
                                                                           : WEFT_TREE_NEAREST});
}

static int list_methods(const struct chart_job *job, struct chart_frames_point *methods)
{
    static const int blends[] = {8, WEFT_ACCUMULATE_HALF, 16, 32};
    int count = 0;
    list_method(methods, &count, CHART_EXACT,
                (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT});
    for (int bits = 16; bits <= 32; bits += 16)
        list_method(
            methods, &count, CHART_BUFFER,
            (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_BUFFER, .bits = bits});
    if (!job->context)
        return count;
    list_method(methods, &count, CHART_FLOAT,
                (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_FLOAT});
    for (int i = 0; i < 4; i++)
        list_method(
            methods, &count, CHART_BLEND,
            (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_BLEND, .bits = blends[i]});
    list_trees(methods, &count);
    return count;
}

static bool beats(const struct chart_frames_point *a, const struct chart_frames_point *b)
{
    return a->frames == b->frames && !*a->reason && a->seconds <= b->seconds &&
           a->max_error <= b->max_error && (a->seconds < b->seconds || a->max_error < b->max_error);
}

static void find_front(struct chart_frames *f)
{
    for (size_t i = 0; i < f->points; i++) {
        f->point[i].front = !*f->point[i].reason;
        for (size_t j = 0; j < f->points && f->point[i].front; j++)
            f->point[i].front = !beats(&f->point[j], &f->point[i]);
    }
}

static enum weft_result allocate(struct bench *b, size_t points)
{
    struct chart_frames *f = &b->job->frames;
    const size_t values = value_count(f);
    b->codes = malloc(DIFFERENT * values);
    b->sums = malloc(values * sizeof *b->sums);
    f->point = calloc(points, sizeof *f->point);
    bool good = b->codes && b->sums && f->point;
    for (int c = 0; c < CHANNELS; c++) {
        b->pixels[c] = malloc(values / CHANNELS * sizeof *b->pixels[c]);
        good = good && b->pixels[c];
    }
    if (!good)
        report_error("out of memory for %d frames of %d x %d pixels", DIFFERENT, f->width,
                     f->height);
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}

static void clear(struct bench *b)
{
    free(b->codes);
    free(b->sums);
    for (int c = 0; c < CHANNELS; c++)
        free(b->pixels[c]);
}

enum weft_result chart_frames_measure(struct chart_job *job)
{
    struct chart_frames *f = &job->frames;
    const bool quick = job->option[CHART_QUICK].given;
    struct chart_frames_point methods[MAX_METHODS];
    const int count = list_methods(job, methods);
    struct bench b = {.job = job,
                      .start = report_now_seconds(),
                      .budget = quick ? QUICK_BUDGET_SECONDS : BUDGET_SECONDS,
                      .total = (size_t)(count * f->counts)};
    enum weft_result res = allocate(&b, b.total);
    if (res == WEFT_OK)
        fill_codes(&b);
    for (int n = 0; n < f->counts && res == WEFT_OK; n++) {
        add_up(&b, f->count[n]);
        for (int m = 0; m < count && res == WEFT_OK; m++, b.done++) {
            struct chart_frames_point *point = &f->point[f->points];
            *point = methods[m];
            point->frames = f->count[n];
            res = measure_point(&b, point);
            f->points += res == WEFT_OK;
            f->measured += res == WEFT_OK && !*point->reason;
        }
    }
    find_front(f);
    clear(&b);
    return res;
}
