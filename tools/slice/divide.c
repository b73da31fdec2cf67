// SPDX-License-Identifier: BSD-3-Clause
// A slice that ranks make together: each plans, reads and computes regions of it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/numbered.h"
#include "tools/common/report.h"
#include "tools/ranks/division.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/budget.h"
#include "tools/slice/parcel.h"
#include "tools/slice/report.h"
#include "tools/slice/stages.h"
#include "tools/slice/sweep.h"

// Bands of whole rows, where nothing else is asked for: their lines are packed where they are made.
// All compressions' blocks of lines fit.
enum { BAND_ROWS = 32, GRANULARITY = 8 };

static bool is_given(const struct slice_job *job, int option)
{
    return job->setup->option[option].given;
}

// ---- what rank 0 finds for all ------------------------------------------------------------------

// What filters, and with frames where the first one lies.
struct choices {
    enum weft_engine engine;
    bool automatic, preferred, loaded, calibrated;
    struct weft_cost_model model;
    struct weft_slice_geometry plane;
    struct slice_frame frame;
};

static enum weft_result share_choices(struct slice_setup *setup)
{
    struct engine *e = &setup->engine;
    struct choices c = {e->engine,     e->automatic, e->preferred, e->loaded,
                        e->calibrated, e->model,     setup->plane, setup->frame};
    const enum weft_result res = ranks_share(&c, sizeof c);
    e->engine = c.engine;
    e->automatic = c.automatic;
    e->preferred = c.preferred;
    e->loaded = c.loaded;
    e->calibrated = c.calibrated;
    e->model = c.model;
    setup->plane = c.plane;
    setup->frame = c.frame;
    return res;
}

// The first slice that can be planned, on rank 0 alone; who makes it tells what is wrong with it.
static void try_first(struct slice_setup *setup)
{
    static struct report_held held;
    report_hold(&held);
    for (int i = 0, done = 0; i < setup->sweep.count && !done; i++) {
        struct slice_job *job = malloc(sizeof *job);
        enum weft_result res = job ? sweep_start(setup, i, job) : WEFT_ERR_MEMORY;
        if (!job)
            break;
        if (res == WEFT_OK)
            res = slice_open(job);
        if (res == WEFT_OK)
            res = slice_place(job);
        if (res == WEFT_OK)
            res = slice_plan(job);
        if (res == WEFT_OK && is_given(job, SLICE_MAX_ERROR) &&
            slice_create_context(job) == WEFT_OK)
            engine_load_costs(&setup->engine, setup->context);
        done = res == WEFT_OK || !is_given(job, SLICE_SKIP_BAD);
        slice_clear(job);
        free(job);
        if (res != WEFT_OK)
            slice_close(setup);
    }
    report_hold(NULL);
    report_set_part(NULL, NULL);
    held.count = 0;
}

enum weft_result slice_share_first(struct slice_setup *setup)
{
    const bool moves = numbered_is(setup->input) && !setup->sweep.planes;
    const bool asks = setup->option[SLICE_MAX_ERROR].given || setup->engine.automatic || moves;
    if (ranks_tells() && asks && ranks_size() > 1)
        try_first(setup);
    return share_choices(setup);
}

// ---- regions ------------------------------------------------------------------------------------

struct regions {
    struct slice_job *job;
    const weft_regions *of;
    bool packs; // lines where they are made: regions are bands of whole blocks of them
    bool sends; // pixels
    bool known; // something has come, on rank 0
    struct weft_bytes *bands; // on rank 0, by region
};

// What makes one region.
struct part_plans {
    weft_slice_plan *slice;
    weft_hardware_plan *hardware;
    weft_method_plan *method;
};

static void part_plans_destroy(struct part_plans *p)
{
    weft_hardware_plan_destroy(&p->hardware);
    weft_slice_plan_destroy(&p->slice);
    weft_method_plan_destroy(&p->method);
}

static enum weft_result plan_hardware(const struct slice_job *job, struct part_plans *p)
{
    struct weft_hardware_params params = {
        .slice = p->slice, .memory_bytes = slice_memory(job->setup), .log = report_log()};
    const enum weft_source_format source = weft_slice_plan_get_info(p->slice)->source;
    const enum weft_result res = weft_sampler_measure(job->setup->context, source, &params.sampler);
    return res == WEFT_OK ? weft_hardware_plan_create(&params, &p->hardware) : res;
}

// In the layout of the whole slice; separable ones have no other than their own.
static enum weft_result plan_part(const struct slice_job *job, const struct weft_rectangle *at,
                                  struct part_plans *out)
{
    const struct slice_divided *divided = &job->setup->divided;
    const struct weft_slice_plan_info *whole = weft_slice_plan_get_info(job->own_plan);
    struct weft_slice_params params = job->slice_params;
    params.part = *at;
    params.footprint = weft_slice_plan_get_footprint(job->own_plan);
    params.progress = NULL;
    *out = (struct part_plans){NULL, NULL, NULL};
    if (is_given(job, SLICE_MAX_ERROR)) {
        params.smooth_error = divided->smooth_error;
        return weft_method_plan_create(job->volume,
                                       weft_method_params(.method = divided->method,
                                                          .slice = params,
                                                          .statistics = divided->statistics),
                                       &out->method);
    }
    if (whole->engine == WEFT_ENGINE_GL && !(whole->savings & WEFT_SAVING_SEPARABLE))
        params.layout = whole->layout;
    const enum weft_result res = weft_slice_plan_create(job->volume, &params, &out->slice);
    return res == WEFT_OK && is_given(job, SLICE_HARDWARE) ? plan_hardware(job, out) : res;
}

// Fills in report, error and seconds of `part`, which is a copy of the job.
static enum weft_result make_part(struct slice_job *part, const struct weft_rectangle *at,
                                  float *pixels)
{
    struct part_plans plans;
    enum weft_result res = plan_part(part, at, &plans);
    if (res == WEFT_OK)
        res = plans.method
                  ? slice_run_method(part, plans.method, pixels, NULL, &part->report)
                  : slice_run_plan(part, plans.slice, plans.hardware, pixels, NULL, &part->report);
    const double start = report_now_seconds();
    if (res == WEFT_OK && is_given(part, SLICE_VERIFY))
        res = slice_verify_plan(
            part, plans.method ? weft_method_plan_get_slice(plans.method) : plans.slice, pixels,
            NULL, &part->error);
    part->verify_seconds = report_now_seconds() - start;
    part_plans_destroy(&plans);
    return res;
}

static enum weft_result run_region(void *priv, int64_t item, void **data, size_t *size)
{
    const struct regions *r = priv;
    const struct weft_rectangle at = weft_regions_get(r->of, item);
    const size_t count = (size_t)at.width * (size_t)at.height;
    struct slice_job *part = malloc(sizeof *part);
    float *pixels = malloc(count * sizeof *pixels);
    struct weft_image_packed packed = {.data = NULL};
    enum weft_result res = part && pixels ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK) {
        *part = *r->job;
        res = make_part(part, &at, pixels);
    }
    if (res == WEFT_OK && r->packs)
        res = parcel_pack_lines(part, at.width, at.height, pixels, &packed);
    if (res == WEFT_OK)
        res = parcel_write_region(part, count, r->sends ? pixels : NULL, &packed, data, size);
    weft_image_packed_clear(&packed);
    free(pixels);
    free(part);
    return res;
}

static enum weft_result take_region(void *priv, int64_t item, const void *data, size_t size)
{
    struct regions *r = priv;
    const struct weft_rectangle at = weft_regions_get(r->of, item);
    struct parcel_region own;
    const enum weft_result res = parcel_read_region(data, size, r->job, r->known, &own);
    if (res != WEFT_OK)
        return res;
    r->known = true;
    for (int y = 0; own.pixels && y < at.height; y++)
        memcpy(r->job->pixels + (size_t)(at.y + y) * (size_t)r->job->geometry.width + at.x,
               own.pixels + (size_t)y * (size_t)at.width, (size_t)at.width * sizeof *own.pixels);
    if (!own.packed.size)
        return WEFT_OK;
    void *copy = malloc(own.packed.size);
    if (!copy)
        return WEFT_ERR_MEMORY;
    memcpy(copy, own.packed.data, own.packed.size);
    slice_stream_put(r->job, item, (struct weft_bytes){copy, own.packed.size});
    return WEFT_OK;
}

// Bands by default: as many as ranks have parts, of whole blocks of lines.
static struct rank_request request_of(const struct slice_job *job)
{
    struct rank_request request = job->setup->divided.request;
    const int granularity = request.granularity ? request.granularity : GRANULARITY;
    const int64_t parts = (int64_t)granularity * ranks_size();
    const int64_t rows = (job->geometry.height + parts - 1) / parts;
    if (!request.region[1])
        request.region[1] = (int32_t)((rows + BAND_ROWS - 1) / BAND_ROWS * BAND_ROWS);
    return request;
}

// Whether all regions are of whole rows, and begin where a block of lines does.
static bool are_bands(const struct slice_job *job, const weft_regions *of)
{
    const struct option_value *o = job->setup->option;
    const int lines =
        weft_image_block_lines((enum weft_image_compression)o[SLICE_COMPRESSION].integer[0]);
    for (int64_t i = 0; i < weft_regions_count(of); i++) {
        const struct weft_rectangle at = weft_regions_get(of, i);
        if (at.width != job->geometry.width || at.y % lines)
            return false;
    }
    return true;
}

static enum weft_result make_room(struct regions *r)
{
    struct slice_job *job = r->job;
    const size_t count = (size_t)weft_regions_count(r->of);
    if (!ranks_tells())
        return WEFT_OK;
    if (r->packs) {
        job->bands = calloc(count, sizeof *job->bands);
        job->band_count = job->bands ? (int)count : 0;
        if (!job->bands)
            return WEFT_ERR_MEMORY;
    }
    return r->sends ? slice_allocate(job) : WEFT_OK;
}

// What a file of passes tells is not known before they have run.
static void begin_file(const struct regions *r)
{
    if (!ranks_tells() || !r->packs || r->job->passes)
        return;
    slice_list_attributes(r->job);
    slice_stream_begin(r->job, slice_write_exr);
}

// Works follow each other: what they took adds up.
static void keep_work(struct slice_divided *divided, struct weft_items_report *work)
{
    if (!work->load.ranks)
        return;
    if (divided->work.load.ranks)
        weft_load_add(&work->load, &divided->work.load);
    weft_items_report_clear(&divided->work);
    divided->work = *work;
}

static enum weft_result do_regions(struct regions *r, struct rank_division *division)
{
    struct slice_divided *divided = &r->job->setup->divided;
    struct weft_items_report work = {.count = 0};
    enum weft_result res = ranks_agree(
        weft_ranks_do_items(ranks_get(),
                            &(struct weft_items){.count = weft_regions_count(r->of),
                                                 .schedule = divided->request.schedule,
                                                 .cost = weft_division_costs(division->division),
                                                 .run = run_region,
                                                 .take = take_region,
                                                 .priv = r,
                                                 .progress = report_progress("slicing")},
                            &work));
    if (res == WEFT_OK)
        res = ranks_agree(weft_division_learn(division->division, &work));
    keep_work(divided, &work);
    return res == WEFT_OK ? rank_division_save(division) : res;
}

static enum weft_result make_regions(struct slice_job *job)
{
    const struct rank_request request = request_of(job);
    const int size[2] = {job->geometry.width, job->geometry.height};
    struct rank_division division = {.division = NULL};
    struct regions r = {.job = job};
    enum weft_result res = rank_division_create(&request, size, GRANULARITY, 1, &division);
    if (res != WEFT_OK)
        return res;
    r.of = weft_division_regions(division.division);
    r.packs = slice_writes_lines(job) && are_bands(job, r.of);
    r.sends = slice_needs_pixels(job) || (job->output && !r.packs);
    res = ranks_agree(make_room(&r));
    if (res == WEFT_OK) {
        begin_file(&r);
        res = do_regions(&r, &division);
    }
    rank_division_clear(&division);
    return res;
}

// ---- the slice ----------------------------------------------------------------------------------

// What a part of --max-error's method needs to know.
static enum weft_result share_method(struct slice_job *job, enum weft_result chosen)
{
    struct slice_divided *divided = &job->setup->divided;
    if (!is_given(job, SLICE_MAX_ERROR))
        return chosen;
    if (job->choice.plan) {
        const struct weft_method_plan_info *info = weft_method_plan_get_info(job->choice.plan);
        divided->method = job->choice.candidates[job->choice.chosen].method;
        divided->smooth_error = info->slice->smooth_error;
        divided->statistics = job->choice.statistics;
    }
    enum weft_result res = ranks_agree(chosen);
    if (res == WEFT_OK)
        res = ranks_share(&divided->method, sizeof divided->method);
    if (res == WEFT_OK)
        res = ranks_share(&divided->smooth_error, sizeof divided->smooth_error);
    return res == WEFT_OK ? ranks_share(&divided->statistics, sizeof divided->statistics) : res;
}

static enum weft_result plan_together(struct slice_job *job)
{
    enum weft_result res = slice_open(job);
    if (res == WEFT_OK)
        res = slice_place(job);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_agree(slice_plan(job));
    if (res == WEFT_OK)
        res = share_choices(job->setup);
    if (res == WEFT_OK)
        res = slice_plan_anew(job);
    if (res == WEFT_OK)
        res = slice_create_context(job);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_check_alike(job->setup->context, job->setup->divided.request.mixed);
    return res == WEFT_OK ? share_method(job, slice_choose(job)) : res;
}

// Where all ranks must know the voxels' range beforehand, or rank 0 afterwards.
static enum weft_result measure_for_runs(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    struct weft_slice_statistics statistics;
    const bool passes = o[SLICE_PASSES + PASS_PROFILE].given && !o[SLICE_MAX_ERROR].given &&
                        !o[SLICE_PASSES + PASS_SOURCE_RANGE].given;
    const bool bounds = o[SLICE_HARDWARE].given && o[SLICE_VERIFY].given;
    return passes || bounds
               ? slice_measure(job, WEFT_OK, weft_slice_plan_get_footprint(job->own_plan),
                               &statistics)
               : WEFT_OK;
}

enum weft_result slice_make_divided(struct slice_job *job)
{
    enum weft_result res = plan_together(job);
    if (res == WEFT_OK)
        res = measure_for_runs(job);
    if (res == WEFT_OK && ranks_tells()) {
        res = slice_plan_hardware(job);
        if (res == WEFT_OK)
            res = slice_find_range(job);
    }
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = make_regions(job);
    if (res == WEFT_OK && ranks_tells())
        res = slice_finish_run(job);
    if (res == WEFT_OK && ranks_tells() && is_given(job, SLICE_VERIFY))
        res = slice_finish_verify(job);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        slice_stream_allow(job);
    return res;
}
