// SPDX-License-Identifier: BSD-3-Clause
// The pictures of `weft antialias` on several ranks: parts of one picture after the other, or whole
// pictures. Each part has the bytes of the whole picture, whoever draws it; rank 0 puts them
// together, checks, and writes.
//
// Only one thing hangs together: what sums of integers have room for (weft_acaa_room) grows from
// picture to picture, and is one for all of a picture. A rank's own room is never more than that of
// one process would be: it draws pictures in their order. What was drawn with less than the
// picture's is drawn again.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/ranks/division.h"
#include "tools/ranks/ranks.h"

// Parts of a picture for each rank where nothing is asked for.
enum { GRANULARITY = 8 };

// ---- what comes of an item ----------------------------------------------------------------------

// Ranks are the same program: what they tell each other is as it lies in memory. Behind it are the
// planes of the part, and its weights where there is a map.
struct part {
    struct weft_rectangle of; // rows upwards, as OpenGL has them
    double seconds;           // until it was read back
    struct weft_acaa_room room;
    // Of its report:
    int passes, redone;
    double bound;
    uint64_t bytes, callbacks; // callbacks: of this part
    double range, scale, largest;
    int64_t less, more, pixels, sampled;
    int32_t first_less[2], first_more[2];
    enum weft_accumulate_method method;
    int64_t marked, by_edges, by_contrast, left;
    double left_error;
    struct scene_shadow_info shadow;
};

static size_t pixels_of(const struct weft_rectangle *part)
{
    return (size_t)part->width * (size_t)part->height;
}

static size_t planes_of(const struct antialias_job *job)
{
    return PICTURE_CHANNELS + (job->option[ASK_WEIGHT_MAP].given ? 1u : 0u);
}

static size_t size_of(const struct antialias_job *job, const struct weft_rectangle *part)
{
    return sizeof(struct part) + planes_of(job) * pixels_of(part) * sizeof(float);
}

// ---- a picture on its way -----------------------------------------------------------------------

// On rank 0.
struct pending {
    int64_t left; // parts that are to come; -1: none has
    float *plane; // [planes][y][x], rows upwards
    struct part *part;
};

// An item that is drawn again, and the room that it has then.
struct again {
    int64_t item;
    struct weft_acaa_room room;
};

// Items are parts of pictures, or whole ones: `regions` of each.
struct work {
    struct antialias_job *job;
    const weft_regions *division; // NULL: pictures are not divided
    int first, frames;
    int64_t regions;
    const struct again *now; // the second time: what is drawn again; else NULL
    // On rank 0:
    struct pending *pending; // [frames]
    int decided;             // pictures whose room is known: all up to there
    struct weft_acaa_room room;
    struct again *again; // [again_count], room for all items
    int64_t again_count;
};

static struct weft_rectangle region_of(const struct work *w, int64_t item)
{
    const int *size = w->job->params.size;
    struct weft_rectangle region = {0, 0, size[0], size[1]};
    if (w->division) // has row 0 on top
        region = weft_regions_get(w->division, item % w->regions);
    region.y = size[1] - region.y - region.height;
    return region;
}

// ---- drawing ------------------------------------------------------------------------------------

static enum weft_result run_and_read(struct antialias_job *job, int frame, struct part *part)
{
    const struct weft_antialias_drawing drawing = {
        .draw = scene_drawing_pass, .priv = job->drawing, .part = part->of};
    float *plane = (float *)(part + 1);
    const size_t pixels = pixels_of(&part->of);
    const double start = report_now_seconds();
    enum weft_result res = antialias_drawer_run(job->drawer, &drawing, frame, NULL);
    for (int c = 0; c < PICTURE_CHANNELS && res == WEFT_OK; c++)
        res = antialias_drawer_read(job->drawer, c, plane + (size_t)c * pixels);
    part->seconds = report_now_seconds() - start;
    if (res == WEFT_OK && job->option[ASK_WEIGHT_MAP].given)
        res = antialias_drawer_read_weight(job->drawer, plane + PICTURE_CHANNELS * pixels);
    return res;
}

static void tell(struct antialias_job *job, uint64_t callbacks, struct part *part)
{
    struct antialias_report r;
    antialias_drawer_get_report(job->drawer, &r);
    antialias_drawer_get_room(job->drawer, &part->room);
    part->passes = r.passes;
    part->redone = r.acaa.redone;
    part->bound = r.bound;
    part->bytes = r.bytes;
    part->callbacks = r.acaa.callbacks - callbacks;
    part->range = r.acaa.range;
    part->scale = r.acaa.scale;
    part->largest = r.acaa.largest;
    part->less = r.acaa.less;
    part->more = r.acaa.more;
    part->pixels = r.supersample.pixels;
    part->sampled = r.supersample.sampled;
    memcpy(part->first_less, r.acaa.first_less, sizeof part->first_less);
    memcpy(part->first_more, r.acaa.first_more, sizeof part->first_more);
    part->method = r.supersample.method;
    if (r.marks) {
        part->marked = r.marks->count;
        part->by_edges = r.marks->by_edges;
        part->by_contrast = r.marks->by_contrast;
        part->left = r.marks->left;
        part->left_error = r.marks->left_error;
    }
    scene_drawing_get_shadow(job->drawing, &part->shadow);
}

static enum weft_result run(void *priv, int64_t i, void **data, size_t *size)
{
    struct work *w = priv;
    struct antialias_job *job = w->job;
    const int64_t item = w->now ? w->now[i].item : i;
    const int frame = w->first + (int)(item / w->regions);
    const struct weft_rectangle of = region_of(w, item);
    struct antialias_report before;
    antialias_drawer_get_report(job->drawer, &before);
    struct part *part = calloc(1, size_of(job, &of));
    if (!part) {
        report_error("out of memory for a part of %d x %d pixels", of.width, of.height);
        return WEFT_ERR_MEMORY;
    }
    part->of = of;
    enum weft_result res = antialias_job_prepare(job, frame);
    if (res == WEFT_OK && w->now)
        res = antialias_drawer_set_room(job->drawer, &w->now[i].room);
    if (res == WEFT_OK)
        res = run_and_read(job, frame, part);
    if (res != WEFT_OK) {
        free(part);
        return res;
    }
    tell(job, before.acaa.callbacks, part);
    *data = part;
    *size = size_of(job, &of);
    return WEFT_OK;
}

// ---- putting together ---------------------------------------------------------------------------

// The first one row by row.
static void note_first(const int32_t at[2], int32_t first[2])
{
    if (at[0] >= 0 && (first[0] < 0 || at[1] < first[1] || (at[1] == first[1] && at[0] < first[0])))
        memcpy(first, at, 2 * sizeof *at);
}

static void merge_acaa(const struct part *part, struct weft_acaa_report *out)
{
    out->less += part->less;
    out->more += part->more;
    note_first(part->first_less, out->first_less);
    note_first(part->first_more, out->first_more);
    out->largest = fmax(out->largest, part->largest);
    out->range = part->range;
    out->scale = part->scale;
    out->redone = part->redone > out->redone ? part->redone : out->redone;
}

// Those of a share of the picture are of all of it.
static void merge_marks(const struct antialias_job *job, const struct part *part,
                        struct weft_marks *out)
{
    const bool whole = job->params.max_share > 0.0;
    out->count = part->marked + (whole ? 0 : out->count);
    out->by_edges = part->by_edges + (whole ? 0 : out->by_edges);
    out->by_contrast = part->by_contrast + (whole ? 0 : out->by_contrast);
    out->left = part->left;
    out->left_error = part->left_error;
}

static void merge_part(struct antialias_job *job, const struct part *part)
{
    struct antialias_report *r = &job->report;
    struct weft_supersample_report *s = &r->supersample;
    merge_acaa(part, &r->acaa);
    merge_marks(job, part, &job->divided.marks);
    r->bound = fmax(r->bound, part->bound); // NAN: none of either
    r->bytes = part->bytes > r->bytes ? part->bytes : r->bytes;
    r->passes = part->passes > r->passes ? part->passes : r->passes;
    s->pixels += part->pixels;
    s->sampled += part->sampled;
    if (part->pixels)
        s->method = part->method;
}

static void merge(struct work *w, const struct pending *p, int frame)
{
    struct antialias_job *job = w->job;
    struct weft_acaa_report *acaa = &job->report.acaa;
    antialias_drawer_get_report(job->drawer, &job->report);
    job->report.bound = NAN;
    acaa->less = acaa->more = 0;
    acaa->largest = 0.0;
    acaa->redone = 0;
    acaa->callbacks = job->divided.callbacks;
    for (int i = 0; i < 2; i++)
        acaa->first_less[i] = acaa->first_more[i] = -1;
    job->report.supersample.pixels = job->report.supersample.sampled = 0;
    job->divided.marks =
        (struct weft_marks){.width = job->params.size[0], .height = job->params.size[1]};
    job->seconds_each[frame] = 0.0;
    for (int64_t i = 0; i < w->regions; i++) {
        merge_part(job, &p->part[i]);
        job->seconds_each[frame] += p->part[i].seconds;
    }
    job->report.acaa.bound = job->report.bound;
    job->seconds.draw += job->seconds_each[frame];
    if (job->params.way == ANTIALIAS_ADAPTIVE)
        antialias_report_set_marks(&job->params, &job->divided.marks, &job->report);
    job->shadow = p->part[w->regions - 1].shadow;
}

static void clear_pending(struct pending *p)
{
    free(p->plane);
    free(p->part);
    *p = (struct pending){.left = -1};
}

static enum weft_result finish(struct work *w, int k)
{
    struct antialias_job *job = w->job;
    struct pending *p = &w->pending[k];
    const int frame = w->first + k;
    const size_t pixels = (size_t)job->params.size[0] * (size_t)job->params.size[1];
    for (int c = 0; c < PICTURE_CHANNELS; c++)
        memcpy(job->picture.channel[c].plane, p->plane + (size_t)c * pixels,
               pixels * sizeof *p->plane);
    if (job->weight)
        memcpy(job->weight, p->plane + PICTURE_CHANNELS * pixels, pixels * sizeof *p->plane);
    merge(w, p, frame);
    clear_pending(p);
    const enum weft_result res = antialias_job_make_exact(job, frame);
    return res == WEFT_OK ? antialias_job_finish(job, frame) : res;
}

static bool has_room(const struct part *part, const struct weft_acaa_room *room)
{
    return part->room.range == room->range && part->room.weight == room->weight;
}

// Lists the parts of a picture that had less room than it has. Whole pictures give their memory
// back.
static void list_again(struct work *w, int k, struct pending *p)
{
    p->left = 0;
    for (int64_t i = 0; i < w->regions; i++)
        if (!has_room(&p->part[i], &w->room)) {
            w->again[w->again_count++] = (struct again){k * w->regions + i, w->room};
            p->left++;
        }
    if (p->left == w->regions) {
        clear_pending(p);
        p->left = w->regions;
    }
}

// Pictures in their order, as far as all of each is there.
static enum weft_result decide(struct work *w)
{
    enum weft_result res = WEFT_OK;
    for (; w->decided < w->frames && w->pending[w->decided].left == 0 && res == WEFT_OK;
         w->decided++) {
        struct pending *p = &w->pending[w->decided];
        for (int64_t i = 0; i < w->regions; i++) {
            w->room.range = fmax(w->room.range, p->part[i].room.range);
            w->room.weight = fmax(w->room.weight, p->part[i].room.weight);
        }
        list_again(w, w->decided, p);
        if (p->left == 0)
            res = finish(w, w->decided);
    }
    return res;
}

static enum weft_result make_pending(const struct work *w, struct pending *p)
{
    const int *size = w->job->params.size;
    const size_t pixels = (size_t)size[0] * (size_t)size[1];
    if (p->left < 0)
        p->left = w->regions;
    if (p->plane)
        return WEFT_OK;
    p->plane = malloc(planes_of(w->job) * pixels * sizeof *p->plane);
    p->part = calloc((size_t)w->regions, sizeof *p->part);
    if (p->plane && p->part)
        return WEFT_OK;
    report_error("out of memory for a picture of %d x %d pixels", size[0], size[1]);
    return WEFT_ERR_MEMORY;
}

static void put(const struct work *w, const struct part *part, float *plane)
{
    const size_t width = (size_t)w->job->params.size[0],
                 pixels = width * (size_t)w->job->params.size[1];
    const float *from = (const float *)(part + 1);
    const size_t columns = (size_t)part->of.width;
    for (size_t c = 0; c < planes_of(w->job); c++)
        for (size_t y = 0; y < (size_t)part->of.height; y++, from += columns)
            memcpy(plane + c * pixels + ((size_t)part->of.y + y) * width + (size_t)part->of.x, from,
                   columns * sizeof *from);
}

static enum weft_result take(void *priv, int64_t i, const void *data, size_t size)
{
    struct work *w = priv;
    const struct part *part = data;
    const int64_t item = w->now ? w->now[i].item : i;
    const int k = (int)(item / w->regions);
    struct pending *p = &w->pending[k];
    const struct weft_rectangle of = region_of(w, item);
    if (size != size_of(w->job, &of) || memcmp(&of, &part->of, sizeof of) != 0)
        return WEFT_ERR_FORMAT;
    enum weft_result res = make_pending(w, p);
    if (res != WEFT_OK)
        return res;
    put(w, part, p->plane);
    p->part[item % w->regions] = *part;
    w->job->divided.callbacks += part->callbacks;
    if (--p->left > 0)
        return WEFT_OK;
    return w->now ? finish(w, k) : decide(w);
}

// ---- works --------------------------------------------------------------------------------------

static enum weft_result begin_work(struct work *w, int first, int frames,
                                   const weft_regions *division)
{
    w->division = division;
    w->first = first;
    w->frames = frames;
    w->regions = division ? weft_regions_count(division) : 1;
    w->now = NULL;
    w->decided = 0;
    w->again_count = 0;
    if (!ranks_tells())
        return WEFT_OK;
    w->pending = calloc((size_t)frames, sizeof *w->pending);
    w->again = calloc((size_t)frames * (size_t)w->regions, sizeof *w->again);
    for (int i = 0; i < frames && w->pending; i++)
        w->pending[i].left = -1;
    if (w->pending && w->again)
        return WEFT_OK;
    report_error("out of memory for %" PRId64 " parts of %d pictures", w->regions, frames);
    return WEFT_ERR_MEMORY;
}

static void end_work(struct work *w)
{
    for (int i = 0; i < w->frames && w->pending; i++)
        clear_pending(&w->pending[i]);
    free(w->pending);
    free(w->again);
    w->pending = NULL;
    w->again = NULL;
}

// Of all pictures, where some of them are drawn.
struct drawn {
    int first, count, all;
    const struct weft_progress *progress;
};

static bool report_drawn(void *priv, double fraction)
{
    const struct drawn *d = priv;
    return d->progress->report(d->progress->priv, (d->first + fraction * d->count) / d->all);
}

static enum weft_result do_items(struct work *w, int64_t count, const double *cost,
                                 struct weft_items_report *report)
{
    struct antialias_job *job = w->job;
    char doing[64];
    snprintf(doing, sizeof doing, "drawing %d picture%s", job->frames, job->frames == 1 ? "" : "s");
    struct drawn drawn = {w->first, w->frames, job->frames, report_progress(doing)};
    const struct weft_progress progress = {report_drawn, &drawn};
    return ranks_agree(weft_ranks_do_items(ranks_get(),
                                           &(struct weft_items){
                                               .count = count,
                                               .schedule = job->divided.request.schedule,
                                               .cost = cost,
                                               .run = run,
                                               .take = take,
                                               .priv = w,
                                               .progress = &progress,
                                           },
                                           report));
}

// Works follow each other: what they took adds up, and the items are those of the last one.
static void add_report(struct antialias_job *job, struct weft_items_report *report)
{
    struct weft_items_report *sum = &job->divided.work;
    if (!report->load.ranks)
        return;
    if (sum->load.ranks)
        weft_load_add(&report->load, &sum->load);
    weft_items_report_clear(sum);
    *sum = *report;
}

// What had not the room of its picture. Later pictures begin with that of all.
static enum weft_result draw_again(struct work *w, struct weft_items_report *report)
{
    void *list = w->again;
    size_t size = (size_t)w->again_count * sizeof *w->again;
    enum weft_result res = ranks_share(&w->room, sizeof w->room);
    if (res == WEFT_OK)
        res = weft_ranks_share(ranks_get(), &list, &size);
    if (res != WEFT_OK)
        return res;
    w->now = list;
    if (size)
        res = do_items(w, (int64_t)(size / sizeof *w->again), NULL, report);
    w->now = NULL;
    if (!ranks_tells())
        free(list);
    return res == WEFT_OK ? antialias_drawer_set_room(w->job->drawer, &w->room) : res;
}

// Collective. What is drawn again are parts as they are before the division learns.
static enum weft_result draw_work(struct work *w, weft_division *division)
{
    struct antialias_job *job = w->job;
    struct weft_items_report report = {.count = 0}, again = {.count = 0};
    enum weft_result res = do_items(w, w->frames * w->regions,
                                    division ? weft_division_costs(division) : NULL, &report);
    if (res == WEFT_OK && job->params.way == ANTIALIAS_ACAA)
        res = ranks_agree(draw_again(w, &again));
    if (res == WEFT_OK && division)
        res = ranks_agree(weft_division_learn(division, &report));
    if (again.count)
        weft_load_add(&report.load, &again.load);
    weft_items_report_clear(&again);
    add_report(job, &report);
    return res;
}

static enum weft_result draw_whole(struct work *w)
{
    enum weft_result res = ranks_agree(begin_work(w, 0, w->job->frames, NULL));
    if (res == WEFT_OK)
        res = draw_work(w, NULL);
    end_work(w);
    return res;
}

// A picture after the other, since each tells what the next one's parts are.
static enum weft_result draw_parts(struct work *w)
{
    const struct antialias_job *job = w->job;
    const int reach = job->report.radius;
    struct rank_division parts;
    enum weft_result res = rank_division_create(&job->divided.request, job->params.size,
                                                GRANULARITY, reach > 1 ? reach : 1, &parts);
    for (int frame = 0; frame < job->frames && res == WEFT_OK; frame++) {
        res = ranks_agree(begin_work(w, frame, 1, weft_division_regions(parts.division)));
        if (res == WEFT_OK)
            res = draw_work(w, parts.division);
        end_work(w);
    }
    if (res == WEFT_OK)
        res = rank_division_save(&parts);
    rank_division_clear(&parts);
    return res;
}

enum weft_result antialias_job_draw_divided(struct antialias_job *job)
{
    struct work work = {.job = job};
    antialias_drawer_get_room(job->drawer, &work.room);
    const enum weft_result res = job->divided.by_frame ? draw_whole(&work) : draw_parts(&work);
    report_erase_progress();
    return res;
}
