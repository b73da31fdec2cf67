// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/frames.h"

#include <inttypes.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"

void rank_frames_clear(struct rank_frames_report *report)
{
    weft_items_report_clear(&report->work);
    *report = (struct rank_frames_report){.rounds = 0};
}

// ---- what is refused ----------------------------------------------------------------------------

enum weft_result rank_frames_check(const struct rank_request *request,
                                   enum weft_accumulate_method method)
{
    if (request->region[0] || request->region[1])
        report_error("--region is of pictures that are divided: here frames are, in blocks by "
                     "--granularity");
    else if (request->cost_map)
        report_error("--cost-map is of parts of a picture: here whole frames are divided");
    else if (method != WEFT_ACCUMULATE_EXACT && method != WEFT_ACCUMULATE_AUTO)
        report_error("--method %s adds frames up in their order, which ranks cannot divide: "
                     "--method exact has none",
                     weft_accumulate_method_names[method]);
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

// ---- blocks -------------------------------------------------------------------------------------

struct blocks {
    const struct rank_frames *frames;
    int64_t *end; // of each block; the first one begins at `first`
    int64_t first, count;
};

static bool counts(const struct rank_frames *frames, int64_t i)
{
    return !frames->counts || frames->counts(frames->priv, i);
}

// The end of frames from `first` on of which so many count; those that follow and do not count are
// left to what comes behind.
static int64_t find_end(const struct rank_frames *frames, int64_t first, int64_t wanted)
{
    while (wanted > 0 && first < frames->count)
        wanted -= counts(frames, first++);
    return first;
}

// Frames by which rank 0's sums end in a whole sample.
static int64_t find_lead(const struct rank_frames *frames)
{
    const int64_t open = frames->counted % frames->batch;
    return open ? find_end(frames, 0, frames->batch - open) : 0;
}

// So many samples a block that each rank has as many blocks as are asked for. Where ranks ask for
// them, the last ones become smaller, down to a sample: half of what each rank would have of those
// that are left, so that all end at about the same time.
static bool make_blocks(const struct rank_frames *frames, struct blocks *out)
{
    const enum weft_schedule schedule = frames->request->schedule;
    const bool shrink = schedule == WEFT_SCHEDULE_AUTO || schedule == WEFT_SCHEDULE_PULL;
    const int asked = frames->request->granularity;
    const int64_t left = frames->count - out->first,
                  parts = (int64_t)ranks_size() * (asked ? asked : RANK_FRAMES_GRANULARITY),
                  each = (left + parts - 1) / parts,
                  samples = (each + frames->batch - 1) / frames->batch;
    out->end = malloc((size_t)left * sizeof *out->end + 1);
    for (int64_t at = out->first; out->end && at < frames->count;) {
        const int64_t rest = (frames->count - at) / (2 * (int64_t)ranks_size() * frames->batch),
                      least = rest > 1 ? rest : 1,
                      some = shrink && least < samples ? least : samples;
        out->end[out->count++] = at = find_end(frames, at, some * frames->batch);
    }
    return out->end != NULL;
}

static int64_t begin_of(const struct blocks *blocks, int64_t i)
{
    return i ? blocks->end[i - 1] : blocks->first;
}

static enum weft_result run_block(void *priv, int64_t i, void **data, size_t *size)
{
    const struct blocks *b = priv;
    const int64_t first = begin_of(b, i);
    return b->frames->run(b->frames->priv, first, b->end[i] - first, data, size);
}

static enum weft_result take_block(void *priv, int64_t i, const void *data, size_t size)
{
    const struct blocks *b = priv;
    const int64_t first = begin_of(b, i);
    return b->frames->take(b->frames->priv, first, b->end[i] - first, data, size);
}

static enum weft_result add_lead(const struct rank_frames *frames, int64_t count)
{
    void *data = NULL;
    size_t size = 0;
    if (!ranks_tells())
        return WEFT_OK;
    enum weft_result res = frames->run(frames->priv, 0, count, &data, &size);
    if (res == WEFT_OK && data)
        res = frames->take(frames->priv, 0, count, data, size);
    free(data);
    return res;
}

// Works follow each other: what they took adds up, and the items are those of the last one.
static void take_report(struct rank_frames_report *report, struct weft_items_report *work)
{
    if (!work->load.ranks)
        return;
    if (report->work.load.ranks)
        weft_load_add(&work->load, &report->work.load);
    weft_items_report_clear(&report->work);
    report->work = *work;
    report->rounds++;
}

enum weft_result rank_frames_add(const struct rank_frames *frames,
                                 struct rank_frames_report *report)
{
    struct blocks blocks = {.frames = frames, .first = find_lead(frames)};
    struct weft_items_report work = {.count = 0};
    enum weft_result res = WEFT_OK;
    if (blocks.first)
        res = ranks_agree(add_lead(frames, blocks.first));
    if (res == WEFT_OK)
        res = ranks_agree(make_blocks(frames, &blocks) ? WEFT_OK : WEFT_ERR_MEMORY);
    // In their order, so that the last block, whose sample may not be whole, is its rank's last
    // one.
    if (res == WEFT_OK && blocks.count) {
        res = ranks_agree(weft_ranks_do_items(ranks_get(),
                                              &(struct weft_items){
                                                  .count = blocks.count,
                                                  .schedule = frames->request->schedule,
                                                  .run = run_block,
                                                  .take = take_block,
                                                  .priv = &blocks,
                                                  .progress = frames->progress,
                                              },
                                              &work));
        take_report(report, &work);
    }
    free(blocks.end);
    return res;
}

// ---- sums ---------------------------------------------------------------------------------------

// The sums of some ranks on their way.
struct joining {
    weft_accumulator **sums;
    enum weft_result (*create)(void *priv, weft_accumulator **out);
    void *priv;
    int group; // ranks of this group are at it
    struct rank_frames_report *report;
};
enum { GROUP = 8 };

// Item r is of rank r.
static enum weft_result give_sums(void *priv, int64_t item, void **data, size_t *size)
{
    const struct joining *j = priv;
    struct weft_accumulator_report report;
    weft_accumulator_get_report(*j->sums, &report);
    if (item == 0 || item / GROUP != j->group || report.frames == 0)
        return WEFT_OK;
    const enum weft_result res = weft_accumulator_save(*j->sums, data, size);
    if (res != WEFT_OK)
        return res;
    weft_accumulator_destroy(j->sums);
    return j->create(j->priv, j->sums);
}

static enum weft_result take_sums(void *priv, int64_t item, const void *data, size_t size)
{
    const struct joining *j = priv;
    weft_accumulator *other = NULL;
    (void)item;
    enum weft_result res = j->create(j->priv, &other);
    if (res == WEFT_OK)
        res = weft_accumulator_load(other, data, size);
    if (res == WEFT_OK)
        res = weft_accumulator_join(*j->sums, other);
    weft_accumulator_destroy(&other);
    j->report->states++;
    j->report->bytes += size;
    return res;
}

enum weft_result rank_frames_join(weft_accumulator **sums,
                                  enum weft_result (*create)(void *priv, weft_accumulator **out),
                                  void *priv, struct rank_frames_report *report)
{
    const double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    for (int first = 0; first < ranks_size() && ranks_size() > 1 && res == WEFT_OK;
         first += GROUP) {
        struct joining joining = {sums, create, priv, first / GROUP, report};
        res = ranks_agree(weft_ranks_do_items(ranks_get(),
                                              &(struct weft_items){
                                                  .count = ranks_size(),
                                                  .schedule = WEFT_SCHEDULE_STATIC,
                                                  .run = give_sums,
                                                  .take = take_sums,
                                                  .priv = &joining,
                                              },
                                              NULL));
    }
    report->seconds += report_now_seconds() - start;
    return res;
}

// ---- told ---------------------------------------------------------------------------------------

json_t *rank_frames_json(const struct rank_frames_report *report)
{
    json_t *object = load_report_json(&report->work, true);
    if (object)
        json_object_update_new(object, json_pack("{s:I,s:{s:I,s:o,s:o}}", "rounds",
                                                 (json_int_t)report->rounds, "joined", "states",
                                                 (json_int_t)report->states, "bytes",
                                                 run_report_bytes("sent", report->bytes), "seconds",
                                                 run_report_total_seconds(report->seconds)));
    return object;
}

void rank_frames_print(const struct rank_frames_report *report)
{
    if (!report->work.load.ranks)
        return;
    load_report_print(&report->work);
    if (report->states)
        report_note("%" PRId64 " sums of other ranks, %.3g MB, were joined in %.3f s",
                    report->states, 1e-6 * (double)report->bytes, report->seconds);
}
