// SPDX-License-Identifier: BSD-3-Clause
// What supersampling of marked pixels takes, in masked passes and in blocks, beside that of all
// pixels: time and bytes for shares of marked pixels, for plain and for heavy shading, of few large
// triangles and of many small ones. Marks lie in stripes of 4 pixels, as along edges.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/supersample.h"
#include "tests/passes/antialias/triangles.h"

enum { STRIPE = 4, MAX_RUNS = 5 };

static const char heavy[] = "flat in vec4 flat_colour;\n"
                            "flat in uint surface;\n"
                            "void main()\n"
                            "{\n"
                            "    float a = 0.01 * gl_FragCoord.x;\n"
                            "    for (int i = 0; i < 48; i++)\n"
                            "        a = sin(1.7 * a + 0.1 * float(i) + flat_colour.y);\n"
                            "    weft_write(flat_colour * (0.6 + 0.4 * a), surface);\n"
                            "}\n";

struct bench {
    weft_context *context;
    int size, runs;
    float *all, *marked; // pictures' red, for what must be equal
};

static uint64_t state_of_random = 7;

static double random_number(void)
{
    state_of_random = state_of_random * 6364136223846793005u + 1442695040888963407u;
    return (double)(state_of_random >> 40) / (1 << 24);
}

static void make_scene(const struct bench *b, int count, double area, struct triangles *out)
{
    const int size[2] = {b->size, b->size};
    const double radius = sqrt(area / 1.299);
    struct triangle_vertex *vertices = malloc(3 * (size_t)count * sizeof *vertices);
    for (int i = 0; vertices && i < count; i++) {
        const double x = b->size * random_number(), y = b->size * random_number(),
                     turn = 6.283 * random_number();
        const float colour[4] = {(float)random_number(), (float)random_number(),
                                 (float)random_number(), 1.0f};
        double corner[3][2];
        for (int k = 0; k < 3; k++) {
            corner[k][0] = x + radius * cos(turn + 2.0944 * k);
            corner[k][1] = y + radius * sin(turn + 2.0944 * k);
        }
        triangle_at(size, (const double(*)[2])corner, random_number(), colour, (uint32_t)i + 1,
                    &vertices[3 * i]);
    }
    triangles_create(b->context, vertices, 3 * count, out);
    free(vertices);
}

static void make_marks(const struct bench *b, double share, struct weft_marks *out)
{
    const int period = (int)lround(STRIPE / share);
    *out = (struct weft_marks){.width = b->size, .height = b->size};
    out->marked = malloc((size_t)b->size * (size_t)b->size);
    for (int i = 0; out->marked && i < b->size * b->size; i++)
        out->count += out->marked[i] =
            (i % b->size + i / b->size * 2 / 3) % period < STRIPE ? 1 : 0;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Returns the median time in milliseconds, after one picture that nobody times; < 0: it fails.
static double measure(const struct bench *b, struct triangles *t, const struct weft_marks *marks,
                      enum weft_supersample_store store, float *out, uint64_t *bytes)
{
    struct weft_supersample_report report;
    double seconds[MAX_RUNS];
    weft_supersample *s = NULL;
    enum weft_result res =
        weft_supersample_create(weft_supersample_params(.width = b->size, .height = b->size,
                                                        .store = store, .context = b->context),
                                &s);
    for (int i = -1; res == WEFT_OK && i < b->runs; i++) {
        const double begin = weft_now_seconds();
        res = weft_supersample_run(s, triangles_drawing(t), marks, NULL);
        if (i >= 0)
            seconds[i] = weft_now_seconds() - begin;
    }
    if (res == WEFT_OK)
        res = weft_supersample_read(s, 0, out, 0);
    if (res == WEFT_OK)
        weft_supersample_get_report(s, &report);
    weft_supersample_destroy(&s);
    if (res != WEFT_OK)
        return -1.0;
    qsort(seconds, (size_t)b->runs, sizeof *seconds, compare);
    *bytes = report.bytes;
    return 1e3 * seconds[b->runs / 2];
}

static bool are_equal(const struct bench *b, const struct weft_marks *marks)
{
    for (int i = 0; i < b->size * b->size; i++)
        if (marks->marked[i] && memcmp(&b->all[i], &b->marked[i], sizeof *b->all) != 0)
            return false;
    return true;
}

// One line a share; false: something failed, or marked pixels are not those of the whole picture.
static bool compare_shares(const struct bench *b, struct triangles *t, const double *shares,
                           size_t count)
{
    uint64_t all_bytes = 0, bytes = 0;
    const double all = measure(b, t, NULL, WEFT_STORE_SUMS, b->all, &all_bytes);
    bool good = all > 0.0;
    for (size_t i = 0; good && i < count; i++) {
        struct weft_marks marks;
        make_marks(b, shares[i], &marks);
        printf("  %5.1f %%  all %8.2f ms %6.1f MB",
               100.0 * (double)marks.count / ((double)b->size * b->size), all,
               1e-6 * (double)all_bytes);
        for (int store = 0; good && store < WEFT_STORE_COUNT; store++) {
            const double ms =
                measure(b, t, &marks, (enum weft_supersample_store)store, b->marked, &bytes);
            good = ms > 0.0 && are_equal(b, &marks);
            printf("   %s %8.2f ms (%.2f) %6.1f MB", weft_supersample_store_names[store], ms,
                   ms / all, 1e-6 * (double)bytes);
        }
        printf("\n");
        weft_marks_clear(&marks);
    }
    return good;
}

static bool compare_scenes(const struct bench *b)
{
    static const double shares[] = {0.05, 0.1, 0.2, 0.5};
    static const struct {
        int count;
        double area; // pixels of 512 x 512
    } scenes[] = {{20, 60000.0}, {4000, 50.0}, {32000, 50.0}};
    const size_t scene_count = b->runs > 1 ? WEFT_COUNT(scenes) : 1;
    bool good = true;
    for (size_t i = 0; good && i < scene_count; i++) {
        for (int shading = 0; good && shading < 2; shading++) {
            struct triangles t;
            make_scene(b, scenes[i].count, scenes[i].area * b->size * b->size / (512.0 * 512.0),
                       &t);
            if (shading)
                t.fragment[WEFT_STAGE_COLOUR] = heavy;
            printf("%d triangles of %g pixels, %s shading, %d x %d, 4 x 4 samples\n",
                   scenes[i].count, scenes[i].area, shading ? "heavy" : "plain", b->size, b->size);
            good = compare_shares(b, &t, shares, b->runs > 1 ? WEFT_COUNT(shares) : 1);
            triangles_destroy(&t);
        }
    }
    return good;
}

int main(int argc, char **argv)
{
    const bool bench = argc > 1 && strcmp(argv[1], "--bench") == 0;
    struct bench b = {.size = bench ? 512 : 48, .runs = bench ? 3 : 1};
    if (weft_context_create(weft_context_params(0), &b.context) != WEFT_OK) {
        printf("no GL context is to be had here\n");
        return 77;
    }
    printf("%s\n", weft_context_get_info(b.context)->renderer);
    b.all = calloc((size_t)b.size * (size_t)b.size, sizeof *b.all);
    b.marked = calloc((size_t)b.size * (size_t)b.size, sizeof *b.marked);
    const bool good = b.all && b.marked && compare_scenes(&b);
    free(b.all);
    free(b.marked);
    weft_context_destroy(&b.context);
    return good ? 0 : 1;
}
