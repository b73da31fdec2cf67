// SPDX-License-Identifier: BSD-3-Clause
// The parts of the result of `weft resample`, made by ranks and put together on rank 0.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/resample/job.h"

// What a part shows of a group.
struct done {
    struct weft_statistics pixels;
    struct weft_verify_report error;
};

// What is sent of a part: this, struct done of each group, and of each channel of the result its
// pixels, tightly packed: floats, or the integers of exact groups.
struct made {
    struct weft_resample_work work;
    double verify_seconds;
};

// All parts: on rank 0 what they show together.
struct work {
    struct resample_job *job;
    struct done *all; // [group_count]
};

static size_t head_bytes(const struct resample_job *job)
{
    return sizeof(struct made) + job->group_count * sizeof(struct done);
}

static size_t part_bytes(const struct resample_job *job, const struct weft_rectangle *part)
{
    return head_bytes(job) +
           job->result.channel_count * sizeof(float) * (size_t)part->width * (size_t)part->height;
}

static struct weft_rectangle part_of(const struct resample_job *job, int64_t item)
{
    return weft_regions_get(weft_division_regions(job->divided.division.division), item);
}

// A part being made, or taken.
struct part {
    struct resample_job *job;
    struct weft_rectangle at, reach; // of the result and of the input's rows
    struct made *made;
    struct done *done;
    char *pixels;
};

static void *plane_of(const struct part *p, size_t channel)
{
    return p->pixels + channel * sizeof(float) * (size_t)p->at.width * (size_t)p->at.height;
}

static void open_part(struct resample_job *job, int64_t item, void *data, struct part *out)
{
    *out = (struct part){.job = job, .at = part_of(job, item), .made = data};
    out->done = (struct done *)(out->made + 1);
    out->pixels = (char *)data + head_bytes(job);
}

// ---- making -------------------------------------------------------------------------------------

static enum weft_result verify_group(const struct part *p, const struct resample_group *group,
                                     const weft_resample_source *source, struct done *done)
{
    struct weft_resample_verify_params params = {
        .source = source, .part = p->at, .how = {.max_seconds = INFINITY}, .log = report_log()};
    const double start = report_now_seconds();
    for (int c = 0; c < group->count; c++)
        params.plane[c] = plane_of(p, group->channel[c]);
    const enum weft_result res = weft_resample_verify(group->plan, &params, &done->error);
    p->made->verify_seconds += report_now_seconds() - start;
    return res;
}

static enum weft_result run_source(const struct part *p, size_t g,
                                   const weft_resample_source *source)
{
    const struct resample_group *group = &p->job->group[g];
    struct done *done = &p->done[g];
    struct weft_resample_run_params params = {.source = source,
                                              .part = p->at,
                                              .survey = resample_survey_of(p->job, g),
                                              .log = report_log()};
    struct weft_resample_report report;
    weft_resample_compiled *compiled;
    enum weft_result res = resample_compile_group(p->job, group, &compiled);
    for (int c = 0; c < group->count; c++)
        params.plane[c] = plane_of(p, group->channel[c]);
    if (res == WEFT_OK)
        res = weft_resample_run(compiled, &params, &report);
    if (res != WEFT_OK)
        return res;
    weft_resample_work_add(&p->made->work, &report.work);
    done->pixels = report.pixels;
    return p->job->option[RESAMPLE_VERIFY].given ? verify_group(p, group, source, done) : WEFT_OK;
}

static enum weft_result run_group(const struct part *p, size_t g)
{
    const struct resample_group *group = &p->job->group[g];
    if (p->job->kernel.prefiltered)
        return run_source(p, g, group->source);
    weft_resample_source *source = NULL;
    struct weft_resample_source_params params =
        resample_source_params(p->job, group, p->reach.y, p->reach.height);
    params.measured = resample_measured_of(p->job, g);
    enum weft_result res = weft_resample_source_create(&params, &source);
    if (res == WEFT_OK)
        res = run_source(p, g, source);
    weft_resample_source_destroy(&source);
    return res;
}

static enum weft_result move_group(const struct part *p, size_t g)
{
    const struct resample_group *group = &p->job->group[g];
    const struct weft_resample_integers source =
        resample_integers(p->job, group, p->reach.y, p->reach.height);
    uint32_t *pixels = plane_of(p, group->channel[0]);
    const struct weft_resample_integers result = {
        .width = p->at.width, .height = p->at.height, .plane = pixels};
    const struct weft_verify_params how = {.max_seconds = INFINITY};
    struct done *done = &p->done[g];
    uint32_t range[2];
    const enum weft_result res = weft_resample_move(group->plan, &source, &p->at, pixels, 0);
    if (res != WEFT_OK)
        return res;
    weft_resample_integer_range(&result, range);
    done->pixels.minimum = range[0];
    done->pixels.maximum = range[1];
    return p->job->option[RESAMPLE_VERIFY].given
               ? weft_resample_move_verify(group->plan, &source, &p->at, pixels, 0, &how,
                                           &done->error)
               : WEFT_OK;
}

// Rows that any group's plan reaches.
static struct weft_rectangle find_reach(const struct part *p)
{
    struct weft_rectangle reach = weft_resample_reach(p->job->group[0].plan, &p->at);
    for (int i = 0; i < 2; i++) {
        if (!p->job->plan[i])
            continue;
        const struct weft_rectangle other = weft_resample_reach(p->job->plan[i], &p->at);
        const int end = reach.y + reach.height, other_end = other.y + other.height;
        reach.y = other.y < reach.y ? other.y : reach.y;
        reach.height = (other_end > end ? other_end : end) - reach.y;
    }
    return reach;
}

static enum weft_result make_part(struct part *p)
{
    struct resample_job *job = p->job;
    p->made->work = (struct weft_resample_work){.tiles = 0};
    p->made->verify_seconds = 0.0;
    for (size_t g = 0; g < job->group_count; g++)
        p->done[g] = (struct done){.pixels = WEFT_STATISTICS_NONE};
    p->reach = find_reach(p);
    enum weft_result res = resample_load_rows(job, p->reach.y, p->reach.y + p->reach.height);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = job->group[g].exact ? move_group(p, g) : run_group(p, g);
    return res;
}

static enum weft_result run(void *priv, int64_t item, void **data, size_t *size)
{
    struct resample_job *job = ((const struct work *)priv)->job;
    const struct weft_rectangle at = part_of(job, item);
    const size_t bytes = part_bytes(job, &at);
    struct part p;
    void *memory = malloc(bytes);
    if (!memory) {
        report_error("out of memory: %zu bytes for a part of %d x %d pixels", bytes, at.width,
                     at.height);
        return WEFT_ERR_MEMORY;
    }
    open_part(job, item, memory, &p);
    const enum weft_result res = make_part(&p);
    if (res != WEFT_OK) {
        free(memory);
        return res;
    }
    *data = memory;
    *size = bytes;
    return WEFT_OK;
}

// ---- taking -------------------------------------------------------------------------------------

static void take_floats(const struct part *p, size_t channel)
{
    const float *from = plane_of(p, channel);
    float *to = p->job->result.channels[channel].plane;
    for (int y = 0; y < p->at.height; y++)
        memcpy(to + (size_t)(p->at.y + y) * (size_t)p->job->result.width + p->at.x,
               from + (size_t)y * (size_t)p->at.width, (size_t)p->at.width * sizeof *to);
}

static void take_integers(const struct part *p, size_t channel)
{
    const uint32_t *from = plane_of(p, channel);
    const struct weft_image_channel *to = &p->job->result.channels[channel];
    for (int y = 0; y < p->at.height; y++) {
        const size_t at = (size_t)(p->at.y + y) * (size_t)p->job->result.width + (size_t)p->at.x;
        for (int x = 0; x < p->at.width; x++, from++) {
            to->integers[at + (size_t)x] = *from;
            to->plane[at + (size_t)x] = (float)*from;
        }
    }
}

static enum weft_result take(void *priv, int64_t item, const void *data, size_t size)
{
    struct work *t = priv;
    struct part p;
    const struct weft_rectangle at = part_of(t->job, item);
    if (size != part_bytes(t->job, &at)) {
        report_error("a part of the result came as %zu bytes instead of %zu", size,
                     part_bytes(t->job, &at));
        return WEFT_ERR_FORMAT;
    }
    open_part(t->job, item, (void *)(uintptr_t)data, &p);
    weft_resample_work_add(&t->job->work, &p.made->work);
    t->job->verify_seconds += p.made->verify_seconds;
    for (size_t g = 0; g < t->job->group_count; g++) {
        const struct resample_group *group = &t->job->group[g];
        weft_statistics_join(&t->all[g].pixels, &p.done[g].pixels);
        weft_verify_join(&t->all[g].error, &p.done[g].error);
        for (int c = 0; c < group->count; c++) {
            if (group->exact)
                take_integers(&p, group->channel[c]);
            else
                take_floats(&p, group->channel[c]);
        }
    }
    return WEFT_OK;
}

static void set_groups(const struct work *t)
{
    for (size_t g = 0; g < t->job->group_count; g++) {
        struct resample_group *group = &t->job->group[g];
        group->minimum = t->all[g].pixels.minimum;
        group->maximum = t->all[g].pixels.maximum;
        group->not_finite = t->all[g].pixels.not_finite;
        group->error = t->all[g].error;
        if (!group->exact)
            group->bound =
                resample_group_bound(group, weft_statistics_magnitude(&t->all[g].pixels));
    }
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result do_parts(struct work *t)
{
    struct resample_job *job = t->job;
    weft_division *division = job->divided.division.division;
    const struct weft_items items = {
        .count = weft_regions_count(weft_division_regions(division)),
        .schedule = job->divided.request.schedule,
        .cost = weft_division_costs(division),
        .run = run,
        .take = take,
        .priv = t,
        .progress = report_progress("resampling"),
    };
    enum weft_result res =
        ranks_agree(weft_ranks_do_items(ranks_get(), &items, &job->divided.work));
    if (res == WEFT_OK)
        res = ranks_agree(weft_division_learn(division, &job->divided.work));
    return res;
}

enum weft_result resample_compute_parts(struct resample_job *job)
{
    struct work t = {job, calloc(job->group_count, sizeof *t.all)};
    enum weft_result res = ranks_agree(t.all ? WEFT_OK : WEFT_ERR_MEMORY);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        t.all[g].pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    if (res == WEFT_OK)
        res = ranks_check_alike(job->context, job->divided.request.mixed);
    if (res == WEFT_OK)
        res = resample_survey_parts(job);
    if (res == WEFT_OK)
        res = do_parts(&t);
    if (res == WEFT_OK && ranks_tells())
        set_groups(&t);
    free(t.all);
    return res;
}
