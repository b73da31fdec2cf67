// SPDX-License-Identifier: BSD-3-Clause
// How busy ranks are that divide frames of an animation, by each schedule, beside what the model
// (tests/passes/distribute/model.h) says from what regions take; and what it says of more ranks.
//     mpirun -n 2 bench_load_mpich [FRAMES [REGION [CLUSTERS [RUNS]]]]
// 4,000 polygons of 50 pixels at 512 x 512, 4 x 4 samples, at random places or in clusters, which
// move by two pixels a frame. Of each schedule RUNS runs are made, in turns; medians are shown.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/distribute/mpi/distribute.h"
#include "tests/passes/distribute/model.h"
#include "tools/render/drawing.h"
#include "tools/scene/scene.h"
#include "weft.h"

enum { SIDE = 512, MAX_RUNS = 9, MAX_FRAMES = 1000, FINE = 32, SPIN_ITEMS = 100 };

static const enum weft_schedule schedules[3] = {WEFT_SCHEDULE_STATIC, WEFT_SCHEDULE_DYNAMIC,
                                                WEFT_SCHEDULE_PULL};

struct bench {
    int frames, region, clusters, runs;
    weft_ranks *ranks;
    struct weft_ranks_info info;
    weft_context *context;
    struct scene scene;
    scene_drawing *drawing;
    weft_supersample *supersample;
    const weft_regions *regions; // of the frame that is drawn
    float *picture;              // [4][SIDE][SIDE]
    double spin;                 // seconds of an item that draws nothing
    size_t bytes;                // of its result
};

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}
static const struct weft_log to_stderr = {.write = say};

static double now(void)
{
    return MPI_Wtime();
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values, int count)
{
    double sorted[MAX_RUNS];
    memcpy(sorted, values, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, compare);
    return sorted[count / 2];
}

// ---- the scene ----------------------------------------------------------------------------------

static double random_number(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 40) / (1 << 24);
}

// Moves polygons, each as a whole, to places around some points: triangles that follow each other
// and share a vertex are one.
static void make_clusters(struct scene *scene, int clusters)
{
    uint64_t seed = 1997;
    double middle[16][2];
    for (int i = 0; i < clusters; i++)
        for (int axis = 0; axis < 2; axis++)
            middle[i][axis] = SIDE * (0.15 + 0.7 * random_number(&seed));
    uint32_t end = 0; // vertices that have been moved
    int polygon = 0;
    for (size_t i = 0; i < scene->index_count; i += 3) {
        uint32_t most = 0;
        for (int k = 0; k < 3; k++)
            most = scene->indices[i + (size_t)k] > most ? scene->indices[i + (size_t)k] : most;
        if (most < end)
            continue;
        uint32_t last = most;
        for (size_t n = i + 3; n < i + 6 && n < scene->index_count; n++) {
            const size_t first = n / 3 * 3;
            bool shares = false;
            for (size_t k = first; k < first + 3; k++)
                shares = shares || (scene->indices[k] >= end && scene->indices[k] <= most);
            if (shares && scene->indices[n] > last)
                last = scene->indices[n];
        }
        double target[2], shift[2];
        for (int axis = 0; axis < 2; axis++) {
            const double normal =
                2.0 * (random_number(&seed) + random_number(&seed) + random_number(&seed) - 1.5);
            target[axis] = middle[polygon % clusters][axis] + 60.0 * normal;
        }
        const struct weft_mesh_vertex *v = &scene->vertices[end];
        const double depth = -v->position[2];
        for (int axis = 0; axis < 2; axis++)
            shift[axis] = (target[axis] / SIDE - 0.5) - v->position[axis] / depth;
        for (uint32_t n = end; n <= last; n++)
            for (int axis = 0; axis < 2; axis++)
                scene->vertices[n].position[axis] +=
                    (float)(shift[axis] * -scene->vertices[n].position[2]);
        end = last + 1;
        polygon++;
    }
    scene_find_box(scene);
}

static enum weft_result begin(struct bench *b)
{
    enum weft_result res = weft_context_create(
        weft_context_params(.kind = WEFT_CONTEXT_AUTO, .log = &to_stderr), &b->context);
    if (res == WEFT_OK)
        res = scene_make(
            scene_params(.name = "polygons:4000,50", .size = {SIDE, SIDE}, .log = &to_stderr),
            &b->scene);
    if (res == WEFT_OK && b->clusters)
        make_clusters(&b->scene, b->clusters);
    if (res == WEFT_OK)
        res = scene_drawing_create(
            scene_drawing_params(.scene = &b->scene, .context = b->context, .log = &to_stderr),
            &b->drawing);
    if (res == WEFT_OK)
        res = weft_supersample_create(weft_supersample_params(.width = SIDE, .height = SIDE,
                                                              .context = b->context,
                                                              .log = &to_stderr),
                                      &b->supersample);
    b->picture = calloc((size_t)SIDE * SIDE * 4, sizeof *b->picture);
    return res == WEFT_OK && !b->picture ? WEFT_ERR_MEMORY : res;
}

static void end(struct bench *b)
{
    weft_supersample_destroy(&b->supersample);
    scene_drawing_destroy(&b->drawing);
    scene_clear(&b->scene);
    weft_context_destroy(&b->context);
    free(b->picture);
}

// ---- items --------------------------------------------------------------------------------------

struct prepared {
    struct bench *bench;
    struct scene_frame frame;
};

static enum weft_result prepare(void *priv)
{
    struct prepared *p = priv;
    return scene_drawing_prepare(p->bench->drawing, &p->frame);
}

static enum weft_result prepare_frame(struct bench *b, int frame)
{
    struct prepared p = {b, {.time = 0.0}};
    p.frame.camera.size[0] = p.frame.camera.size[1] = SIDE;
    p.frame.camera.move[0] = p.frame.camera.move[1] = 2.0 * frame;
    return weft_context_call(b->context, prepare, &p);
}

static enum weft_result draw_region(void *priv, int64_t item, void **data, size_t *size)
{
    struct bench *b = priv;
    const struct weft_rectangle r = weft_regions_get(b->regions, item);
    const struct weft_antialias_drawing drawing = {scene_drawing_pass, b->drawing, r};
    const size_t pixels = (size_t)r.width * (size_t)r.height;
    float *out = malloc(4 * pixels * sizeof *out);
    if (!out)
        return WEFT_ERR_MEMORY;
    enum weft_result res = weft_supersample_run(b->supersample, &drawing, NULL, NULL);
    for (int c = 0; c < 4 && res == WEFT_OK; c++)
        res = weft_supersample_read(b->supersample, c, out + (size_t)c * pixels, 0);
    *data = out;
    *size = 4 * pixels * sizeof *out;
    return res;
}

static enum weft_result take_region(void *priv, int64_t item, const void *data, size_t size)
{
    struct bench *b = priv;
    const struct weft_rectangle r = weft_regions_get(b->regions, item);
    const float *from = data;
    (void)size;
    for (int c = 0; c < 4; c++)
        for (int32_t y = 0; y < r.height; y++, from += r.width)
            memcpy(b->picture + ((size_t)c * SIDE + (size_t)(r.y + y)) * SIDE + r.x, from,
                   (size_t)r.width * sizeof *from);
    return WEFT_OK;
}

static enum weft_result spin(void *priv, int64_t item, void **data, size_t *size)
{
    const struct bench *b = priv;
    const double until = now() + b->spin;
    (void)item;
    while (now() < until)
        continue;
    *data = b->bytes ? calloc(b->bytes, 1) : NULL;
    *size = b->bytes;
    return b->bytes && !*data ? WEFT_ERR_MEMORY : WEFT_OK;
}

static enum weft_result take_nothing(void *priv, int64_t item, const void *data, size_t size)
{
    struct bench *b = priv;
    (void)item;
    memcpy(b->picture, data, size);
    return WEFT_OK;
}

// ---- runs ---------------------------------------------------------------------------------------

struct run {
    double wall, seconds, idle_share, busy, taking;
    uint64_t bytes;
};

// All frames. costs: where seconds of the items of each frame go, on rank 0; may be NULL.
static enum weft_result run_frames(struct bench *b, enum weft_schedule schedule, int region,
                                   int frames, double *costs, struct run *out)
{
    weft_division *division = NULL;
    struct weft_load load;
    const double begun = now();
    enum weft_result res = weft_load_create(b->info.size, &load);
    if (res == WEFT_OK)
        res = weft_division_create(b->ranks,
                                   weft_division_params(.regions = {.width = SIDE,
                                                                    .height = SIDE,
                                                                    .region_width = region,
                                                                    .region_height = region,
                                                                    .log = &to_stderr},
                                                        .schedule = schedule),
                                   &division);
    for (int frame = 0; frame < frames && res == WEFT_OK; frame++) {
        struct weft_items_report report;
        b->regions = weft_division_regions(division);
        const int64_t count = weft_regions_count(b->regions);
        res = prepare_frame(b, frame);
        if (res == WEFT_OK)
            res = weft_ranks_do_items(b->ranks,
                                      &(struct weft_items){.count = count,
                                                           .schedule = schedule,
                                                           .cost = weft_division_costs(division),
                                                           .run = draw_region,
                                                           .take = take_region,
                                                           .priv = b},
                                      &report);
        if (res != WEFT_OK)
            break;
        weft_load_add(&load, &report.load);
        if (costs && b->info.rank == 0)
            memcpy(costs + frame * count, report.item_seconds, (size_t)count * sizeof *costs);
        res = weft_division_learn(division, &report);
        weft_items_report_clear(&report);
    }
    struct weft_load_figures figures;
    weft_load_compute(&load, &figures);
    *out = (struct run){.wall = now() - begun,
                        .seconds = load.seconds,
                        .idle_share = figures.idle_share,
                        .busy = figures.mean_busy * b->info.size,
                        .taking = load.rank[0].taking};
    for (int r = 1; r < b->info.size; r++)
        out->bytes += load.rank[r].bytes;
    weft_load_clear(&load);
    weft_division_destroy(&division);
    return res;
}

// What a message takes: of works of two items, which take as long as regions do, nobody is busy
// while the last result comes, and while all are told that it is over.
static enum weft_result measure_latency(struct bench *b, double item, double *latency)
{
    enum weft_result res = WEFT_OK;
    double each[MAX_RUNS];
    b->spin = item;
    b->bytes = sizeof(float) * SIDE * 16;
    for (int i = 0; i < MAX_RUNS && res == WEFT_OK; i++) {
        struct weft_items_report report;
        res = weft_ranks_do_items(b->ranks,
                                  &(struct weft_items){.count = b->info.size,
                                                       .schedule = WEFT_SCHEDULE_STATIC,
                                                       .run = spin,
                                                       .take = take_nothing,
                                                       .priv = b},
                                  &report);
        struct weft_load_figures figures;
        weft_load_compute(&report.load, &figures);
        each[i] = (report.load.seconds - figures.largest_busy) / 2.0;
        weft_items_report_clear(&report);
    }
    *latency = b->info.size > 1 && res == WEFT_OK ? median(each, MAX_RUNS) : 0.0;
    return res;
}

// ---- the model ----------------------------------------------------------------------------------

struct measured {
    struct model_grid coarse, fine; // of all frames by `region`; of one frame by SIDE / FINE
    struct model_machine machine;
};

static double fine_cost(const void *priv, int frame, const struct weft_rectangle *region)
{
    (void)frame;
    return model_grid_cost(priv, 0, region);
}

static struct model model_of(const struct bench *b, const struct measured *m, int processors,
                             enum weft_schedule schedule)
{
    return (struct model){.processors = processors,
                          .frames = b->frames,
                          .schedule = schedule,
                          .params = {.width = SIDE,
                                     .height = SIDE,
                                     .region_width = b->region,
                                     .region_height = b->region},
                          .keep = 0.5,
                          .bytes = 16.0,
                          .cost = model_grid_cost,
                          .priv = &m->coarse,
                          .machine = m->machine};
}

static bool show_model(const struct bench *b, const struct measured *measured, double latency)
{
    struct measured own = *measured;
    const struct measured *m = &own;
    own.machine.latency = latency;
    static const int processors[] = {2, 8, 64, 1024}, sides[] = {128, 64, 32, 16, 8};
    printf("\nThe model with messages that take %.3f ms, of one frame's costs by regions of %d:\n"
           "idle share of static, dynamic, pull; T of a frame of pull; list scheduling's bound by "
           "the mean\n",
           1e3 * latency, SIDE / FINE);
    for (size_t p = 0; p < sizeof processors / sizeof *processors; p++)
        for (size_t s = 0; s < sizeof sides / sizeof *sides; s++) {
            struct model_result r = {.work = 0.0};
            const int64_t count = (int64_t)(SIDE / sides[s]) * (SIDE / sides[s]);
            if (count < processors[p] || count > 64 * processors[p])
                continue;
            printf("  %4d ranks, regions of %3d (%5lld):", processors[p], sides[s],
                   (long long)count);
            for (int k = 0; k < 3; k++) {
                struct model model = model_of(b, m, processors[p], schedules[k]);
                model.frames = 20;
                model.params.region_width = model.params.region_height = sides[s];
                model.cost = fine_cost, model.priv = &m->fine;
                if (!model_run(&model, &r))
                    return false;
                weft_load_clear(&r.load);
                printf(" %5.1f %%", 100.0 * r.idle_share);
            }
            struct model pull = model_of(b, m, processors[p], WEFT_SCHEDULE_PULL);
            pull.frames = 20;
            pull.params.region_width = pull.params.region_height = sides[s];
            pull.cost = fine_cost, pull.priv = &m->fine;
            if (!model_run(&pull, &r))
                return false;
            printf("  %8.2f ms  %.2f\n", 1e3 * r.load.seconds / pull.frames,
                   r.bound * processors[p] / r.work);
            weft_load_clear(&r.load);
        }
    return true;
}

// Each run beside the model of what regions took in the static run of the same turn.
static bool show_schedule(const struct bench *b, const struct measured *m, double *const costs[],
                          int k, const struct run *run)
{
    double wall[MAX_RUNS], seconds[MAX_RUNS], idle[MAX_RUNS], ratio[MAX_RUNS], modelled[MAX_RUNS],
        work[MAX_RUNS];
    for (int i = 0; i < b->runs; i++) {
        struct measured turn = *m;
        struct model_result r;
        turn.coarse.seconds = costs[i];
        const struct model model = model_of(b, &turn, b->info.size, schedules[k]);
        if (!model_run(&model, &r))
            return false;
        weft_load_clear(&r.load);
        wall[i] = run[i].wall, seconds[i] = run[i].seconds, idle[i] = run[i].idle_share;
        ratio[i] = r.completion / run[i].wall, modelled[i] = r.idle_share;
        work[i] = r.work / run[i].busy;
    }
    printf("%-8s %8.3f s, T %8.3f s, idle %5.1f %%; model: idle %5.1f %%, completion / measured "
           "%.3f (busy / measured %.3f)\n",
           weft_schedule_names[schedules[k]], median(wall, b->runs), median(seconds, b->runs),
           100.0 * median(idle, b->runs), 100.0 * median(modelled, b->runs), median(ratio, b->runs),
           median(work, b->runs));
    return true;
}

static bool show(const struct bench *b, const struct measured *m, double *const costs[],
                 struct run run[3][MAX_RUNS])
{
    printf("latency %.3f ms, taking %.2f ns a byte, between frames %.3f ms\n",
           1e3 * m->machine.latency, 1e9 * m->machine.take_byte, 1e3 * m->machine.frame);
    for (int k = 0; k < 3; k++)
        if (!show_schedule(b, m, costs, k, run[k]))
            return false;
    // As it was, and with processors of their own for messages.
    return show_model(b, m, m->machine.latency) && show_model(b, m, 1e-4);
}

static double sum_of(const double *values, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++)
        sum += values[i];
    return sum;
}

static int cells_of(const struct bench *b)
{
    const int side = (SIDE + b->region - 1) / b->region;
    return side * side;
}

// A picture as a whole, in regions of FINE x FINE, and what a region takes that is no part of it.
static enum weft_result measure_regions(struct bench *b, struct measured *m, double *whole)
{
    struct run run;
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < 2 && res == WEFT_OK; i++) // the first one warms up
        res = run_frames(b, WEFT_SCHEDULE_STATIC, SIDE, 1, whole, &run);
    // The least of three, which others' work disturbed least.
    for (int i = 0; i < 3 && res == WEFT_OK; i++) {
        double seconds[FINE * FINE] = {0.0};
        res = run_frames(b, WEFT_SCHEDULE_STATIC, SIDE / FINE, 1, seconds, &run);
        for (int k = 0; k < FINE * FINE; k++)
            if (i == 0 || seconds[k] < m->fine.seconds[k])
                m->fine.seconds[k] = seconds[k];
    }
    m->fine.fixed = fmax(0.0, (sum_of(m->fine.seconds, FINE * FINE) - *whole) / (FINE * FINE - 1));
    return res;
}

// Medians of what was measured of each region and frame in the runs of static schedules.
static void take_costs(const struct bench *b, double whole, double *const costs[],
                       struct measured *m)
{
    const int cells = cells_of(b);
    for (int i = 0; i < cells * b->frames; i++) {
        double each[MAX_RUNS];
        for (int r = 0; r < b->runs; r++)
            each[r] = costs[r][i];
        m->coarse.seconds[i] = median(each, b->runs);
    }
    const double sum = sum_of(m->coarse.seconds, cells * b->frames) / b->frames;
    if (cells > 1)
        m->coarse.fixed = fmax(0.0, (sum - whole) / (cells - 1));
    printf("a frame: %.1f ms as a whole, %.1f ms in %d regions, %.1f ms in %d; a region's own %.3f "
           "and %.3f ms\n",
           1e3 * whole, 1e3 * sum, cells, 1e3 * sum_of(m->fine.seconds, FINE * FINE), FINE * FINE,
           1e3 * m->coarse.fixed, 1e3 * m->fine.fixed);
}

// What the machine does besides, by the runs of static schedules.
static void take_machine(const struct bench *b, double latency, const struct run *run,
                         struct model_machine *out)
{
    double frame[MAX_RUNS], byte[MAX_RUNS];
    for (int i = 0; i < b->runs; i++) {
        frame[i] = (run[i].wall - run[i].seconds) / b->frames;
        byte[i] = run[i].taking / (16.0 * SIDE * SIDE * b->frames);
    }
    *out = (struct model_machine){.latency = latency,
                                  .ahead = 20e-3,
                                  .frame = median(frame, b->runs),
                                  .take_byte = median(byte, b->runs)};
}

static enum weft_result allocate(const struct bench *b, struct measured *m, double *costs[])
{
    const int cells = cells_of(b), side = (SIDE + b->region - 1) / b->region;
    const size_t count = (size_t)cells * (size_t)b->frames;
    m->coarse = (struct model_grid){side * b->region,
                                    side * b->region,
                                    side,
                                    side,
                                    b->frames,
                                    0.0,
                                    calloc(count, sizeof(double))};
    m->fine =
        (struct model_grid){SIDE, SIDE, FINE, FINE, 1, 0.0, calloc(FINE * FINE, sizeof(double))};
    bool good = m->coarse.seconds && m->fine.seconds;
    for (int i = 0; i < b->runs; i++)
        good = (costs[i] = calloc(count, sizeof(double))) != NULL && good;
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}

static enum weft_result run_all(struct bench *b, double *costs[], struct run run[3][MAX_RUNS])
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < b->runs && res == WEFT_OK; i++)
        for (int k = 0; k < 3 && res == WEFT_OK; k++)
            res = run_frames(b, schedules[k], b->region, b->frames, k == 0 ? costs[i] : NULL,
                             &run[k][i]);
    return res;
}

static enum weft_result body(void *priv, weft_ranks *ranks)
{
    struct bench *b = priv;
    struct measured m = {.machine = {.latency = 0.0}};
    static struct run run[3][MAX_RUNS];
    double *costs[MAX_RUNS] = {NULL}, latency = 0.0, whole = 0.0;
    b->ranks = ranks;
    weft_ranks_get_info(ranks, &b->info);
    enum weft_result res = allocate(b, &m, costs);
    if (res == WEFT_OK)
        res = begin(b);
    if (res == WEFT_OK)
        res = measure_regions(b, &m, &whole);
    if (res == WEFT_OK)
        res = measure_latency(b, 3e-3, &latency);
    if (res == WEFT_OK)
        res = run_all(b, costs, run);
    if (res == WEFT_OK && b->info.rank == 0) {
        take_costs(b, whole, costs, &m);
        take_machine(b, latency, run[0], &m.machine);
        if (!show(b, &m, costs, run))
            res = WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < b->runs; i++)
        free(costs[i]);
    free(m.coarse.seconds);
    free(m.fine.seconds);
    end(b);
    return res;
}

static int number(int argc, char **argv, int i, int least, int most, int otherwise)
{
    const int value = i < argc ? atoi(argv[i]) : otherwise;
    return value < least ? least : value > most ? most : value;
}

int main(int argc, char **argv)
{
    int threads;
    setenv("LP_NUM_THREADS", "0", 0); // each rank one thread
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads);
    struct bench b = {
        .frames = number(argc, argv, 1, 1, MAX_FRAMES, 50),
        .region = number(argc, argv, 2, 4, SIDE, 64),
        .clusters = number(argc, argv, 3, 0, 16, 0),
        .runs = number(argc, argv, 4, 1, MAX_RUNS, 5),
    };
    const enum weft_result res =
        weft_distribute(MPI_COMM_WORLD, weft_distribute_params(.log = &to_stderr), body, &b);
    if (res != WEFT_OK)
        fprintf(stderr, "%s\n", weft_result_text(res));
    MPI_Finalize();
    return res != WEFT_OK;
}
