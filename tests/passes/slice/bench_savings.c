// SPDX-License-Identifier: BSD-3-Clause
// What a scene does not need: each saving of weft_slice_run with it and without, in turns. Both
// results are verified against the double reference, and their largest difference is told.
// Usage: bench_savings [--bench] [--context osmesa|egl] [--runs N] [VOLUME.vdb]
// Without --bench small slices of a generated ball are made once; errors beyond bounds fail.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

enum { MAX_RUNS = 31, SIDE = 64 };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "bench_savings: error: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

enum plane { PLANE_OBLIQUE, PLANE_TURNED, PLANE_ALONG };

struct saving {
    const char *name;
    unsigned saving, never; // the one that is measured, and those that neither run makes
    enum plane plane;
    bool on_lattice;
    double budget; // of smooth pieces, of the voxels' range
    int larger;    // times the pixels along each side
};

static const struct saving savings[] = {
    {"constant", WEFT_SAVING_CONSTANT, WEFT_SAVING_SMOOTH, PLANE_OBLIQUE, false, 0.0, 1},
    {"axis", WEFT_SAVING_AXIS, WEFT_SAVING_SEPARABLE, PLANE_TURNED, false, 0.0, 1},
    {"axis, on the lattice", WEFT_SAVING_AXIS, WEFT_SAVING_SEPARABLE, PLANE_TURNED, true, 0.0, 1},
    {"separable", WEFT_SAVING_SEPARABLE, 0, PLANE_ALONG, false, 0.0, 1},
    {"axis and separable", WEFT_SAVING_SEPARABLE | WEFT_SAVING_AXIS, 0, PLANE_ALONG, false, 0.0, 1},
    {"smooth, 8 bit", WEFT_SAVING_SMOOTH, 0, PLANE_OBLIQUE, false, 0.5 / 255, 1},
    {"the same, 9 x pixels", WEFT_SAVING_SMOOTH, 0, PLANE_OBLIQUE, false, 0.5 / 255, 3},
    {"6 bit, 9 x pixels", WEFT_SAVING_SMOOTH, 0, PLANE_OBLIQUE, false, 0.5 / 63, 3},
};

struct bench {
    weft_context *context;
    weft_volume *volume;
    struct weft_kernel kernel;
    int runs, side; // pixels
    int failures;
};

// One of the two runs.
struct method {
    weft_slice_plan *plan;
    float *pixels;
    double seconds[MAX_RUNS];
    struct weft_slice_report report;
    struct weft_verify_report error;
};

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, compare);
    return values[count / 2];
}

// ---- volumes and planes -------------------------------------------------------------------------

static weft_volume *make_ball(void)
{
    float *data = malloc((size_t)SIDE * SIDE * SIDE * sizeof *data);
    weft_volume *volume = NULL;
    for (int i = 0; data && i < SIDE * SIDE * SIDE; i++) {
        const double x = i % SIDE - 30.0, y = i / SIDE % SIDE - 31.0, z = i / (SIDE * SIDE) - 32.0;
        const double square = (x * x + y * y + z * z) / (24.0 * 24.0);
        data[i] = square < 1.0 ? (float)((1.0 - square) * (1.0 - square)) : 0.0f;
    }
    if (data)
        weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .background = 0.0f,
                                              .data = data, .log = &log_to_stderr),
                           &volume);
    free(data);
    return volume;
}

static size_t pixel_count(const struct bench *b, const struct saving *s)
{
    return (size_t)(b->side * s->larger) * (size_t)(b->side * s->larger);
}

// Through the middle of the active box.
static struct weft_slice_geometry make_plane(const struct bench *b, const struct saving *s)
{
    static const double edges[][2][3] = {
        [PLANE_OBLIQUE] = {{0.9, 0.1, 0.3}, {-0.2, 0.9, 0.2}},
        [PLANE_TURNED] = {{0.9, 0.3, 0.0}, {-0.3, 0.9, 0.0}},
        [PLANE_ALONG] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}},
    };
    const struct weft_volume_info *info = weft_volume_get_info(b->volume);
    struct weft_slice_geometry g = {.width = b->side * s->larger, .height = b->side * s->larger};
    for (int a = 0; a < 3; a++) {
        const double low = info->active_min[a], high = info->active_max[a];
        g.u[a] = edges[s->plane][0][a] * (info->active_max[0] - info->active_min[0]);
        g.v[a] = edges[s->plane][1][a] * (info->active_max[1] - info->active_min[1]);
        g.origin[a] = 0.5 * (low + high - g.u[a] - g.v[a]);
    }
    if (s->plane != PLANE_OBLIQUE)
        g.origin[2] = floor(g.origin[2]) + (s->on_lattice ? 0.0 : 0.3);
    return g;
}

// ---- one saving ---------------------------------------------------------------------------------

static enum weft_result plan_method(const struct bench *b, const struct saving *s, bool with,
                                    struct method *method)
{
    struct weft_slice_params params = {
        .kernel = b->kernel,
        .space = WEFT_SPACE_INDEX,
        .geometry = make_plane(b, s),
        .without = s->never | (with ? 0 : s->saving),
        .log = &log_to_stderr,
    };
    struct weft_slice_statistics statistics;
    enum weft_result res = weft_slice_plan_create(b->volume, &params, &method->plan);
    if (res == WEFT_OK && s->budget > 0.0) {
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(method->plan), NULL,
                                        &statistics);
        params.smooth_error = s->budget * (statistics.high - statistics.low);
        weft_slice_plan_destroy(&method->plan);
        if (res == WEFT_OK)
            res = weft_slice_plan_create(b->volume, &params, &method->plan);
    }
    method->pixels = malloc(pixel_count(b, s) * sizeof *method->pixels);
    return res == WEFT_OK && !method->pixels ? WEFT_ERR_MEMORY : res;
}

static enum weft_result run_turns(const struct bench *b, struct method methods[2])
{
    enum weft_result res = WEFT_OK;
    for (int run = -1; res == WEFT_OK && run < b->runs; run++) {
        for (int w = 0; res == WEFT_OK && w < 2; w++) {
            const double start = weft_now_seconds();
            res = weft_slice_run_once(
                methods[w].plan, weft_slice_compile_params(.context = b->context),
                weft_slice_run_params(.pixels = methods[w].pixels), &methods[w].report);
            if (run >= 0)
                methods[w].seconds[run] = weft_now_seconds() - start;
        }
    }
    for (int w = 0; res == WEFT_OK && w < 2; w++)
        res = weft_slice_verify(methods[w].plan, methods[w].pixels,
                                &(struct weft_slice_verify_params){.max_seconds = 2.0},
                                &methods[w].error);
    return res;
}

static void print_saving(struct bench *b, const struct saving *s, struct method methods[2])
{
    double difference = 0.0;
    for (size_t i = 0; i < pixel_count(b, s); i++)
        difference =
            fmax(difference, fabs((double)methods[0].pixels[i] - (double)methods[1].pixels[i]));
    for (int w = 0; w < 2; w++) {
        const struct weft_slice_output *value = weft_slice_plan_get_info(methods[w].plan)->output;
        const double bound =
            value->error_bound * methods[w].error.magnitude + value->error_absolute;
        b->failures +=
            !(methods[w].error.maximum <= bound) || methods[w].error.not_finite_mismatches;
    }
    const double with = median(methods[0].seconds, b->runs),
                 without = median(methods[1].seconds, b->runs);
    const double pixels = (double)pixel_count(b, s);
    printf("%-21s %8.2f %8.2f %6.2f %8.2f %8.2f %8.1f %8.1f %10.2e %10.2e %10.2e\n", s->name,
           1e3 * with, 1e3 * without, without / with,
           1e-6 * (double)methods[0].report.uploaded_bytes,
           1e-6 * (double)methods[1].report.uploaded_bytes,
           (double)methods[0].report.fetches / pixels, (double)methods[1].report.fetches / pixels,
           methods[0].error.maximum, methods[1].error.maximum, difference);
}

static enum weft_result run_saving(struct bench *b, const struct saving *s)
{
    struct method methods[2] = {{0}};
    enum weft_result res = plan_method(b, s, true, &methods[0]);
    if (res == WEFT_OK)
        res = plan_method(b, s, false, &methods[1]);
    if (res == WEFT_OK)
        res = run_turns(b, methods);
    if (res == WEFT_OK)
        print_saving(b, s, methods);
    for (int w = 0; w < 2; w++) {
        weft_slice_plan_destroy(&methods[w].plan);
        free(methods[w].pixels);
    }
    return res;
}

static int run(struct bench *b, const char *path)
{
    const struct weft_context_info *info = weft_context_get_info(b->context);
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 0);
    enum weft_result res = weft_kernel_parse(&log_to_stderr, "catmull-rom", &b->kernel);
    if (res == WEFT_OK && path)
        res = weft_volume_open(
            &(struct weft_volume_open_params){.path = path, .log = &log_to_stderr}, &b->volume);
    else if (res == WEFT_OK)
        b->volume = make_ball();
    if (res != WEFT_OK || !b->volume)
        return 1;
    printf("%s, %s; %s, Catmull-Rom, %d x %d pixels, medians of %d turns of whole runs\n",
           info->platform, info->renderer, path ? path : "a ball of 64^3", b->side, b->side,
           b->runs);
    printf("%-21s %8s %8s %6s %8s %8s %8s %8s %10s %10s %10s\n", "saving", "ms with", "without",
           "ratio", "MB with", "without", "fetches", "without", "max error", "without",
           "difference");
    for (size_t i = 0; res == WEFT_OK && i < WEFT_COUNT(savings); i++)
        res = run_saving(b, &savings[i]);
    weft_volume_destroy(&b->volume);
    return res != WEFT_OK || b->failures;
}

int main(int argc, char **argv)
{
    struct bench b = {.runs = 1, .side = 96};
    enum weft_context_kind kind = WEFT_CONTEXT_OSMESA;
    const char *path = NULL;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            b.runs = 9;
            b.side = 1024;
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            b.runs = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc &&
                   weft_context_kind_parse(&log_to_stderr, argv[i + 1], &kind) == WEFT_OK) {
            i++;
        } else if (argv[i][0] != '-' && !path) {
            path = argv[i];
        } else {
            fprintf(stderr, "usage: bench_savings [--bench] [--context osmesa|egl] [--runs N] "
                            "[VOLUME.vdb]\n");
            return 2;
        }
    }
    if (b.runs < 1 || b.runs > MAX_RUNS) {
        fprintf(stderr, "bench_savings: runs must be 1 to %d\n", MAX_RUNS);
        return 2;
    }
    if (weft_context_create(&(struct weft_context_params){.kind = kind, .log = &log_to_stderr},
                            &b.context) != WEFT_OK)
        return 77; // skipped
    const int status = run(&b, path);
    weft_context_destroy(&b.context);
    return status;
}
