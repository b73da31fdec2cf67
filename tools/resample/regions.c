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

// What is sent of a part: this, struct done of each group, a count of values that are no integers
// of each channel of the result, and as they are wanted the pixels of each channel, tightly packed:
// floats, or the integers of exact groups; and lines as a file has them.
struct made {
    struct weft_resample_work work;
    double verify_seconds;
    struct weft_image_save_report packing;
    uint64_t packed_bytes;
};

// All parts: on rank 0 what they show together.
struct work {
    struct resample_job *job;
    struct done *all; // [group_count]
};

static size_t head_bytes(const struct resample_job *job)
{
    return sizeof(struct made) + job->group_count * sizeof(struct done) +
           job->result.channel_count * sizeof(uint64_t);
}

static size_t pixel_bytes(const struct resample_job *job, const struct weft_rectangle *part)
{
    return job->result.channel_count * sizeof(float) * (size_t)part->width * (size_t)part->height;
}

static struct weft_rectangle part_of(const struct resample_job *job, int64_t item)
{
    return weft_regions_get(weft_division_regions(job->divided.division.division),
                            job->divided.order[item]);
}

// A part being made, or taken.
struct part {
    struct resample_job *job;
    struct weft_rectangle at, reach; // of the result and of the input's rows
    struct made *made;
    struct done *done;
    uint64_t *lost;
    char *pixels;
    struct weft_image_packed packed;
};

static void *plane_of(const struct part *p, size_t channel)
{
    return p->pixels + channel * sizeof(float) * (size_t)p->at.width * (size_t)p->at.height;
}

// Where what is sent begins.
static void open_part(struct resample_job *job, int64_t item, void *data, struct part *out)
{
    *out = (struct part){.job = job, .at = part_of(job, item), .made = data};
    out->done = (struct done *)(out->made + 1);
    out->lost = (uint64_t *)(out->done + job->group_count);
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

// ---- packing ------------------------------------------------------------------------------------

// A channel as it is saved, with memory of its own where that is not what was made; `floats` and
// `integers` are freed.
struct saved_channel {
    struct weft_image_channel channel;
    float *floats;
    uint32_t *integers;
};

static bool set_saved(const struct part *p, const struct resample_group *group, size_t channel,
                      struct saved_channel *out)
{
    const size_t count = (size_t)p->at.width * (size_t)p->at.height;
    const uint32_t *codes = plane_of(p, channel);
    const bool is_uint = p->job->result.channels[channel].type == WEFT_PIXEL_UINT;
    *out = (struct saved_channel){.channel = p->job->result.channels[channel]};
    out->channel.plane = plane_of(p, channel);
    out->channel.integers = plane_of(p, channel);
    if (group->exact == is_uint)
        return true;
    if (is_uint) {
        out->channel.integers = out->integers = malloc(count * sizeof *out->integers);
        if (out->integers)
            p->lost[channel] = resample_round_plane(plane_of(p, channel), count, out->integers);
        return out->integers != NULL;
    }
    out->channel.plane = out->floats = malloc(count * sizeof *out->floats);
    for (size_t i = 0; out->floats && i < count; i++)
        out->floats[i] = (float)codes[i];
    return out->floats != NULL;
}

static enum weft_result pack(struct part *p)
{
    const struct resample_job *job = p->job;
    const size_t count = job->result.channel_count;
    struct saved_channel *saved = calloc(count, sizeof *saved);
    struct weft_image_channel *channels = calloc(count, sizeof *channels);
    bool whole = saved && channels;
    for (size_t g = 0; whole && g < job->group_count; g++)
        for (int c = 0; whole && c < job->group[g].count; c++)
            whole = set_saved(p, &job->group[g], job->group[g].channel[c],
                              &saved[job->group[g].channel[c]]);
    for (size_t i = 0; whole && i < count; i++)
        channels[i] = saved[i].channel;
    const struct weft_image image = {.width = p->at.width,
                                     .height = p->at.height,
                                     .display_max = {p->at.width - 1, p->at.height - 1},
                                     .compression = job->result.compression,
                                     .channel_count = count,
                                     .channels = channels};
    enum weft_result res = WEFT_ERR_MEMORY;
    if (whole)
        res = weft_image_pack(&image, job->engine.cpu.threads, report_log(), &p->packed);
    else
        report_error("out of memory for %zu channels of %d x %d pixels", count, p->at.width,
                     p->at.height);
    for (size_t i = 0; saved && i < count; i++) {
        free(saved[i].floats);
        free(saved[i].integers);
    }
    free(saved);
    free(channels);
    return res;
}

// ---- a part -------------------------------------------------------------------------------------

static enum weft_result make_part(struct part *p)
{
    struct resample_job *job = p->job;
    *p->made = (struct made){.verify_seconds = 0.0};
    memset(p->lost, 0, job->result.channel_count * sizeof *p->lost);
    for (size_t g = 0; g < job->group_count; g++)
        p->done[g] = (struct done){.pixels = WEFT_STATISTICS_NONE};
    p->reach = find_reach(p);
    enum weft_result res = resample_load_rows(job, p->reach.y, p->reach.y + p->reach.height);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = job->group[g].exact ? move_group(p, g) : run_group(p, g);
    if (res == WEFT_OK && job->divided.packs)
        res = pack(p);
    p->made->packing = p->packed.report;
    p->made->packed_bytes = p->packed.size;
    return res;
}

static enum weft_result out_of_memory(size_t bytes, const struct weft_rectangle *at)
{
    report_error("out of memory: %zu bytes for a part of %d x %d pixels", bytes, at->width,
                 at->height);
    return WEFT_ERR_MEMORY;
}

// Pixels that are not sent make room for what is packed.
static enum weft_result run(void *priv, int64_t item, void **data, size_t *size)
{
    struct resample_job *job = ((const struct work *)priv)->job;
    const struct weft_rectangle at = part_of(job, item);
    const size_t head = head_bytes(job), bytes = head + pixel_bytes(job, &at);
    struct part p;
    char *memory = malloc(bytes);
    if (!memory)
        return out_of_memory(bytes, &at);
    open_part(job, item, memory, &p);
    enum weft_result res = make_part(&p);
    const size_t kept = job->divided.sends ? bytes : head;
    char *sent = res == WEFT_OK ? realloc(memory, kept + p.packed.size) : NULL;
    if (res == WEFT_OK && !sent)
        res = out_of_memory(kept + p.packed.size, &at);
    if (sent && p.packed.size)
        memcpy(sent + kept, p.packed.data, p.packed.size);
    if (!sent)
        free(memory);
    *data = sent;
    *size = kept + p.packed.size;
    weft_image_packed_clear(&p.packed);
    return res;
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

static enum weft_result take_band(const struct part *p, int64_t item, const char *packed)
{
    struct resample_divided *d = &p->job->divided;
    const struct weft_image_save_report *of = &p->made->packing;
    const size_t size = (size_t)p->made->packed_bytes;
    void *copy = malloc(size ? size : 1);
    if (!copy)
        return out_of_memory(size, &p->at);
    memcpy(copy, packed, size);
    d->bands[d->order[item]] = (struct weft_bytes){copy, size};
    d->packing.overflows += of->overflows;
    d->packing.rounding = fmax(d->packing.rounding, of->rounding);
    for (size_t i = 0; i < p->job->result.channel_count; i++)
        d->lost[i] += p->lost[i];
    return WEFT_OK;
}

static void take_pixels(const struct part *p)
{
    for (size_t g = 0; g < p->job->group_count; g++) {
        const struct resample_group *group = &p->job->group[g];
        for (int c = 0; c < group->count; c++) {
            if (group->exact)
                take_integers(p, group->channel[c]);
            else
                take_floats(p, group->channel[c]);
        }
    }
}

static enum weft_result take(void *priv, int64_t item, const void *data, size_t size)
{
    struct work *t = priv;
    struct part p;
    open_part(t->job, item, (void *)(uintptr_t)data, &p);
    const size_t head = head_bytes(t->job),
                 kept = head + (t->job->divided.sends ? pixel_bytes(t->job, &p.at) : 0);
    if (size < head || size != kept + p.made->packed_bytes) {
        report_error("a part of %d x %d pixels came as %zu bytes", p.at.width, p.at.height, size);
        return WEFT_ERR_FORMAT;
    }
    weft_resample_work_add(&t->job->work, &p.made->work);
    t->job->verify_seconds += p.made->verify_seconds;
    for (size_t g = 0; g < t->job->group_count; g++) {
        weft_statistics_join(&t->all[g].pixels, &p.done[g].pixels);
        weft_verify_join(&t->all[g].error, &p.done[g].error);
    }
    if (t->job->divided.sends)
        take_pixels(&p);
    return t->job->divided.packs ? take_band(&p, item, (const char *)data + kept) : WEFT_OK;
}

// Rank 0's.
static enum weft_result make_room(struct resample_job *job)
{
    struct resample_divided *d = &job->divided;
    const int64_t count = weft_regions_count(weft_division_regions(d->division.division));
    if (!ranks_tells() || !d->packs)
        return WEFT_OK;
    d->bands = calloc((size_t)count, sizeof *d->bands);
    d->band_count = d->bands ? count : 0;
    d->lost = calloc(job->result.channel_count, sizeof *d->lost);
    if (d->bands && d->lost)
        return WEFT_OK;
    report_error("out of memory for %lld parts", (long long)count);
    return WEFT_ERR_MEMORY;
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

// What was expected of parts, or what is told of them, from one order to the other.
static enum weft_result sort_report(const struct resample_job *job,
                                    struct weft_items_report *report)
{
    const size_t count = (size_t)report->count;
    double *seconds = malloc(count * sizeof *seconds);
    int *rank = malloc(count * sizeof *rank);
    const bool whole = seconds && rank;
    if (whole && report->item_seconds && report->item_rank) {
        for (size_t i = 0; i < count; i++) {
            seconds[job->divided.order[i]] = report->item_seconds[i];
            rank[job->divided.order[i]] = report->item_rank[i];
        }
        memcpy(report->item_seconds, seconds, count * sizeof *seconds);
        memcpy(report->item_rank, rank, count * sizeof *rank);
    }
    free(seconds);
    free(rank);
    return whole ? WEFT_OK : WEFT_ERR_MEMORY;
}

// NULL where nothing is expected, or there is no memory.
static double *sort_costs(const struct resample_job *job, const double *costs, int64_t count)
{
    double *sorted = costs ? malloc((size_t)count * sizeof *sorted) : NULL;
    for (int64_t i = 0; sorted && i < count; i++)
        sorted[i] = costs[job->divided.order[i]];
    return sorted;
}

static enum weft_result do_parts(struct work *t)
{
    struct resample_job *job = t->job;
    weft_division *division = job->divided.division.division;
    const int64_t count = weft_regions_count(weft_division_regions(division));
    const double *costs = weft_division_costs(division);
    double *sorted = sort_costs(job, costs, count);
    const struct weft_items items = {
        .count = count,
        .schedule = job->divided.request.schedule,
        .cost = sorted,
        .run = run,
        .take = take,
        .priv = t,
        .progress = report_progress("resampling"),
    };
    enum weft_result res = ranks_agree(!costs || sorted ? WEFT_OK : WEFT_ERR_MEMORY);
    if (res == WEFT_OK)
        res = ranks_agree(weft_ranks_do_items(ranks_get(), &items, &job->divided.work));
    if (res == WEFT_OK)
        res = ranks_agree(sort_report(job, &job->divided.work));
    if (res == WEFT_OK)
        res = ranks_agree(weft_division_learn(division, &job->divided.work));
    free(sorted);
    return res;
}

enum weft_result resample_compute_parts(struct resample_job *job)
{
    struct work t = {job, calloc(job->group_count, sizeof *t.all)};
    enum weft_result res = ranks_agree(t.all ? make_room(job) : WEFT_ERR_MEMORY);
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
