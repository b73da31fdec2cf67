// SPDX-License-Identifier: BSD-3-Clause
// Volumes at points, in turns beside Teem's gage: the value, the gradient, and the Hessian with
// both, by Catmull-Rom from one dense box in memory; points at random, and along lines, which gage
// keeps its taps for. bench_points [VOLUME.vdb [POINTS [THREADS]]]: medians of 5 runs, in
// core-seconds.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <teem/gage.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tests/support/slice_jobs.h"
#include "tiles/volume/block_layout.h"

enum { RUNS = 5, MOST_THREADS = 64, CHUNK = 4096, OUTPUTS = 10 };

static const struct weft_derivative all[OUTPUTS] = {
    {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{2, 0, 0}},
    {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}}, {{0, 1, 1}}, {{0, 0, 2}},
};
// Where gage's Hessian, 3 x 3, has the six.
static const int hessian_at[6] = {0, 1, 2, 4, 5, 8};

struct bench {
    int size[3], threads, outputs;
    float *box;
    size_t count;
    double (*position)[3];
    float *ours, *theirs;
    weft_volume *volume;
    gageContext *context[MOST_THREADS];
    const double *value[MOST_THREADS], *gradient[MOST_THREADS], *hessian[MOST_THREADS];
};

// Of all threads: other programs that run do not count, but for what they drive out of caches.
static double core_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void must(bool condition, const char *what)
{
    if (condition)
        return;
    fprintf(stderr, "bench_points: no %s\n", what);
    exit(1);
}

// A volume's active box, from the first voxel on.
static void load_box(struct bench *b, const char *path)
{
    weft_volume *file = NULL;
    must(weft_volume_open(weft_volume_open_params(.path = path), &file) == WEFT_OK, "volume");
    const struct weft_volume_info *info = weft_volume_get_info(file);
    struct weft_region region = {.slab_count = 0};
    struct weft_brick_list list;
    weft_brick_store *store = NULL;
    memcpy(region.min, info->active_min, sizeof region.min);
    memcpy(region.max, info->active_max, sizeof region.max);
    for (int a = 0; a < 3; a++)
        b->size[a] = info->active_max[a] - info->active_min[a] + 1;
    must(weft_volume_find(file, &region, &list) == WEFT_OK, "bricks");
    float *values = malloc(list.brick_count * WEFT_BRICK_VOXELS * sizeof *values);
    b->box = malloc((size_t)b->size[0] * (size_t)b->size[1] * (size_t)b->size[2] * sizeof(float));
    must(values && b->box, "memory");
    must(weft_volume_read(file, list.brick_count, (const int32_t(*)[3])list.brick_origin, values) ==
             WEFT_OK,
         "voxels");
    must(weft_brick_store_create(NULL, list.brick_count, info->background, &store) == WEFT_OK &&
             weft_brick_store_add_list(store, &list, values) == WEFT_OK,
         "store");
    weft_brick_store_copy_box(store, info->active_min, b->size, b->size, NULL, b->box);
    weft_brick_store_destroy(&store);
    weft_brick_list_clear(&list);
    free(values);
    weft_volume_destroy(&file);
    must(weft_volume_create(
             weft_volume_params(.size = {b->size[0], b->size[1], b->size[2]}, .data = b->box),
             &b->volume) == WEFT_OK,
         "volume in memory");
}

// Where all taps are voxels.
static void set_points(struct bench *b, bool lines)
{
    struct random r = {1};
    double at[3] = {0}, step[3] = {0};
    for (size_t i = 0; i < b->count; i++) {
        for (int a = 0; a < 3; a++) {
            const double from = 2.0, room = b->size[a] - 5.0;
            if (!lines || i % 256 == 0) {
                at[a] = from + room * uniform(&r);
                step[a] = 0.25 * (uniform(&r) - 0.5);
            } else {
                at[a] = fmin(fmax(at[a] + step[a], from), from + room);
            }
            b->position[i][a] = at[a];
        }
    }
}

// ---- gage ---------------------------------------------------------------------------------------

static void start_gage(struct bench *b, Nrrd *nrrd)
{
    const double cubic[3] = {1.0, 0.0, 0.5}; // scale, B, C
    must(!nrrdWrap_va(nrrd, b->box, nrrdTypeFloat, 3, (size_t)b->size[0], (size_t)b->size[1],
                      (size_t)b->size[2]),
         "nrrd");
    nrrdAxisInfoSet_va(nrrd, nrrdAxisInfoSpacing, 1.0, 1.0, 1.0);
    nrrdAxisInfoSet_va(nrrd, nrrdAxisInfoCenter, nrrdCenterNode, nrrdCenterNode, nrrdCenterNode);
    for (int i = 0; i < b->threads; i++) {
        gageContext *context = b->context[i] = gageContextNew();
        gagePerVolume *volume = gagePerVolumeNew(context, nrrd, gageKindScl);
        // Derivatives per voxel, not per half of the volume.
        gageParmSet(context, gageParmOrientationFromSpacing, AIR_TRUE);
        must(volume && !gagePerVolumeAttach(context, volume) &&
                 !gageKernelSet(context, gageKernel00, nrrdKernelBCCubic, cubic) &&
                 !gageKernelSet(context, gageKernel11, nrrdKernelBCCubicD, cubic) &&
                 !gageKernelSet(context, gageKernel22, nrrdKernelBCCubicDD, cubic) &&
                 !gageQueryItemOn(context, volume, gageSclValue),
             "gage");
        if (b->outputs > 1)
            must(!gageQueryItemOn(context, volume, gageSclGradVec), "gradient of gage");
        if (b->outputs > 4)
            must(!gageQueryItemOn(context, volume, gageSclHessian), "Hessian of gage");
        must(!gageUpdate(context), "gage");
        b->value[i] = gageAnswerPointer(context, volume, gageSclValue);
        b->gradient[i] = gageAnswerPointer(context, volume, gageSclGradVec);
        b->hessian[i] = gageAnswerPointer(context, volume, gageSclHessian);
    }
}

static bool probe_chunk(void *priv, int thread, size_t chunk)
{
    struct bench *b = priv;
    const size_t from = chunk * CHUNK, end = from + CHUNK < b->count ? from + CHUNK : b->count;
    for (size_t i = from; i < end; i++) {
        gageProbe(b->context[thread], b->position[i][0], b->position[i][1], b->position[i][2]);
        b->theirs[i] = (float)*b->value[thread];
        for (int a = 0; a < 3 && b->outputs > 1; a++)
            b->theirs[(size_t)(1 + a) * b->count + i] = (float)b->gradient[thread][a];
        for (int a = 0; a < 6 && b->outputs > 4; a++)
            b->theirs[(size_t)(4 + a) * b->count + i] = (float)b->hessian[thread][hessian_at[a]];
    }
    return true;
}

static double run_gage(struct bench *b)
{
    const double start = core_seconds();
    weft_threads_run(b->threads, (b->count + CHUNK - 1) / CHUNK, probe_chunk, b);
    return core_seconds() - start;
}

// ---- weft ---------------------------------------------------------------------------------------

static double run_weft(struct bench *b)
{
    weft_points *points = NULL;
    const double start = core_seconds();
    const struct weft_points_params *params =
        weft_points_params(.volume = b->volume, .space = WEFT_SPACE_INDEX, .derivative = all,
                           .derivative_count = b->outputs, .cpu.threads = b->threads);
    must(weft_points_create(params, &points) == WEFT_OK, "points");
    must(weft_points_run(points,
                         weft_points_run_params(.count = b->count,
                                                .position = (const double(*)[3])b->position,
                                                .out = b->ours),
                         NULL) == WEFT_OK,
         "values");
    weft_points_destroy(&points);
    return core_seconds() - start;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void compare(struct bench *b, const char *what)
{
    double ours[RUNS], theirs[RUNS], difference = 0.0;
    Nrrd *nrrd = nrrdNew();
    start_gage(b, nrrd);
    for (int i = -1; i < RUNS; i++) { // the first ones do not count
        const double weft = run_weft(b), gage = run_gage(b);
        if (i < 0)
            continue;
        ours[i] = weft;
        theirs[i] = gage;
    }
    for (size_t i = 0; i < (size_t)b->outputs * b->count; i++)
        difference = fmax(difference, fabs((double)b->ours[i] - (double)b->theirs[i]));
    qsort(ours, RUNS, sizeof *ours, by_size);
    qsort(theirs, RUNS, sizeof *theirs, by_size);
    printf("%-28s weft %7.1f ns  gage %7.1f ns  ratio %5.2f  largest difference %.2g\n", what,
           1e9 * ours[RUNS / 2] / (double)b->count, 1e9 * theirs[RUNS / 2] / (double)b->count,
           theirs[RUNS / 2] / ours[RUNS / 2], difference);
    for (int i = 0; i < b->threads; i++)
        gageContextNix(b->context[i]);
    nrrdNix(nrrd);
}

int main(int argc, char **argv)
{
    static const struct {
        int outputs;
        const char *name;
    } kinds[] = {{1, "value"}, {4, "+ gradient"}, {10, "+ gradient + Hessian"}};
    struct bench b = {.count = argc > 2 ? strtoul(argv[2], NULL, 10) : 1000000,
                      .threads = argc > 3 ? atoi(argv[3]) : 1};
    must(b.count > 0 && b.threads > 0 && b.threads <= MOST_THREADS, "such points or threads");
    load_box(&b, argc > 1 ? argv[1] : WEFT_TEST_DATA "/mri.vdb");
    b.position = malloc(b.count * sizeof *b.position);
    b.ours = calloc(OUTPUTS * b.count, sizeof *b.ours);
    b.theirs = calloc(OUTPUTS * b.count, sizeof *b.theirs);
    must(b.position && b.ours && b.theirs, "memory");
    printf("%d x %d x %d voxels, %zu points, %d threads, %s, gage of Teem %s; core-seconds of a "
           "point\n",
           b.size[0], b.size[1], b.size[2], b.count, b.threads,
           weft_instruction_set_names[weft_instruction_set_best()], TEEM_VERSION_STRING);
    for (int lines = 0; lines < 2; lines++) {
        set_points(&b, lines);
        for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
            char what[60];
            b.outputs = kinds[k].outputs;
            snprintf(what, sizeof what, "%s: %s", lines ? "lines" : "random", kinds[k].name);
            compare(&b, what);
        }
    }
    weft_volume_destroy(&b.volume);
    free(b.box);
    free(b.position);
    free(b.ours);
    free(b.theirs);
    return 0;
}
