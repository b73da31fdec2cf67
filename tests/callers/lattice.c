// SPDX-License-Identifier: BSD-3-Clause
// passes/lattice, and files written brick by brick.
#include "tests/callers/callers.h"

static enum weft_result drop(void *priv, const struct weft_volume_lot *lot)
{
    (void)priv;
    (void)lot;
    return WEFT_OK;
}

static enum weft_result make(const struct weft_lattice_params *params)
{
    weft_lattice_plan *plan = NULL;
    const struct weft_lattice_run_params run = {.sink = drop};
    enum weft_result res = weft_lattice_plan_create(params, &plan);
    if (res == WEFT_OK) {
        weft_lattice_plan_get_info(plan);
        res = weft_lattice_run(plan, &run, NULL);
    }
    weft_lattice_plan_destroy(&plan);
    return res;
}

static void plans(void)
{
    weft_volume *v = volume();
    struct weft_lattice_params good = {.volume = v, .log = &logger};
    struct weft_lattice_params boxed = {.volume = v, .log = &logger, .boxed = true};
    struct weft_quantities none = {.count = 0}, wrong = {.count = 99};
    KERNELS_REFUSED(good, 1, make(&p));
    for (int a = 0; a < 3; a++) {
        struct weft_lattice_params scaled = good;
        for (int i = 0; i < 3; i++)
            scaled.to_source[i][i] = scaled.index_to_world[i][i] = 1.0;
        ANY_NUMBER(scaled, to_source[a][a], make(&p));
        ANY_NUMBER(scaled, to_source[a][3], make(&p));
        ANY_NUMBER(scaled, index_to_world[a][a], make(&p));
        SET_REFUSED(scaled, to_source[a][a], 0.0, make(&p));
        SET_REFUSED(scaled, index_to_world[a][a], (double)NAN, make(&p));
        SET_REFUSED(boxed, box_min[a], 1, make(&p));
        ANY_INT(boxed, box_max[a], make(&p));
    }
    ANY_NUMBER(good, prune, make(&p));
    SET_REFUSED(good, prune, -1.0, make(&p));
    SET_REFUSED(good, volume, NULL, make(&p));
    SET_REFUSED(good, quantities, &none, make(&p));
    SET_REFUSED(good, quantities, &wrong, make(&p));
    ANY_INT(good, memory_bytes, make(&p));
    weft_lattice_plan_destroy(NULL);
    weft_volume_destroy(&v);
}

static void runs(void)
{
    weft_volume *v = volume();
    weft_lattice_plan *plan = NULL;
    const struct weft_lattice_params params = {.volume = v, .log = &logger};
    struct weft_lattice_run_params good = {.sink = drop};
    TRUE(weft_lattice_plan_create(&params, &plan) == WEFT_OK);
    SET_REFUSED(good, sink, NULL, weft_lattice_run(plan, &p, NULL));
    SET_REFUSED(good, verify.share, -0.5, weft_lattice_run(plan, &p, NULL));
    SET_REFUSED(good, verify.share, 1.5, weft_lattice_run(plan, &p, NULL));
    SET_REFUSED(good, verify.share, (double)NAN, weft_lattice_run(plan, &p, NULL));
    BAD_ENUM(good, cpu.instructions, weft_lattice_run(plan, &p, NULL));
    SET_REFUSED(good, cpu.threads, -1, weft_lattice_run(plan, &p, NULL));
    weft_lattice_plan_destroy(&plan);
    weft_volume_destroy(&v);
}

static void maps(void)
{
    double one[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, bad[3][4], out[3][4];
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        memcpy(bad, one, sizeof bad);
        bad[1][1] = numbers[i];
        const double(*given)[4] = (const double(*)[4])bad, (*good)[4] = (const double(*)[4])one;
        SURVIVED(weft_lattice_map_compute(&logger, given, NULL, good, out));
        SURVIVED(weft_lattice_map_compute(&logger, good, given, good, out));
        SURVIVED(weft_lattice_map_compute(&logger, good, NULL, given, out));
    }
    bad[1][1] = 0.0;
    REFUSED(weft_lattice_map_compute(&logger, (const double(*)[4])bad, NULL,
                                     (const double(*)[4])one, out));
}

static enum weft_result open_writer(const struct weft_volume_writer_params *params)
{
    weft_volume_writer *writer = NULL;
    const enum weft_result res = weft_volume_writer_create(params, &writer);
    weft_volume_writer_discard(&writer);
    return res;
}

static void writers(void)
{
    char path[] = "/tmp/weft_callers_XXXXXX";
    TRUE(mkdtemp(path) != NULL);
    char file[64];
    snprintf(file, sizeof file, "%s/x.vdb", path);
    struct weft_volume_grid grid[2] = {{.name = "a"}, {.name = "a"}};
    struct weft_volume_writer_params good = {
        .path = file, .grid_count = 1, .grid = grid, .log = &logger};
    SET_REFUSED(good, path, NULL, open_writer(&p));
    SET_REFUSED(good, path, "/nonexistent/x.vdb", open_writer(&p));
    SET_REFUSED(good, grid, NULL, open_writer(&p));
    SET_REFUSED(good, grid_count, 0, open_writer(&p));
    SET_REFUSED(good, grid_count, 65, open_writer(&p));
    SET_REFUSED(good, grid_count, 2, open_writer(&p)); // of one name
    grid[0].components = 2;
    REFUSED(open_writer(&good));
    grid[0].components = 3;
    grid[0].index_to_world[0][0] = 1.0;
    REFUSED(open_writer(&good));
    memset(grid[0].index_to_world, 0, sizeof grid[0].index_to_world);
    weft_volume_writer *writer = NULL;
    int32_t origin[1][3] = {{8, 0, 0}};
    static const float values[3 * WEFT_BRICK_VOXELS];
    const struct weft_volume_tile tile = {.size = 8};
    struct weft_volume_lot lot = {
        .brick_count = 1, .brick_origin = (const int32_t(*)[3])origin, .values = values};
    struct weft_volume_lot wrong[5] = {lot, lot, lot, lot, lot};
    wrong[0].grid = 1;
    wrong[1].values = NULL;
    wrong[2].brick_count = SIZE_MAX;
    wrong[3].tile_count = 1; // of vectors
    wrong[3].tiles = &tile;
    origin[0][0] = 7;
    for (int i = 0; i < 5; i++) {
        TRUE(weft_volume_writer_create(&good, &writer) == WEFT_OK);
        REFUSED(weft_volume_writer_add(writer, &wrong[i]));
        TRUE(weft_volume_writer_add(writer, &(struct weft_volume_lot){.grid = 0}) != WEFT_OK);
        TRUE(weft_volume_writer_finish(&writer, NULL) != WEFT_OK && !writer);
        callers_lines = 0;
    }
    weft_volume_writer_discard(NULL);
    rmdir(path);
}

const struct caller_case callers_lattice[] = {
    {plans, {F(lattice_plan_create), F(lattice_plan_destroy), F(lattice_plan_get_info)}},
    {runs, {F(lattice_run)}},
    {maps, {F(lattice_map_compute)}},
    {writers,
     {F(volume_writer_create), F(volume_writer_add), F(volume_writer_finish),
      F(volume_writer_discard)}},
    {0},
};
