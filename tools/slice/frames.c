// SPDX-License-Identifier: BSD-3-Clause
// The slices of a command, one after the other: while one is written, the next one is made. Frames
// that ranks divide come to rank 0 in any order, are saved as they come and told in theirs.
#include "tools/slice/sweep.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/ending.h"
#include "tools/common/numbered.h"
#include "tools/common/report.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/budget.h"
#include "tools/slice/parcel.h"
#include "tools/slice/report.h"
#include "tools/slice/stages.h"

// Of slices that ranks make, so many may be saved at once: while one waits for the disk, others are
// packed.
enum { SAVES = 4 };

// A slice that a thread saves.
struct saving {
    struct slice_job *job;
    pthread_t thread;
};

struct frames {
    struct slice_setup *setup;
    struct saving saving[SAVES]; // [(first_saving + i) % SAVES], i < savings, in their order
    int first_saving, savings;
    int complete, skipped;
    int64_t last;               // that is complete
    bool failed;                // no method within the budget, or beyond the bound
    struct slice_job **waiting; // by index: saved or skipped, and to be told once those before are
    int told;
    bool json;
    json_t *array; // of frames, with --json and --frames
    double seconds[SLICE_STAGES];
};

// ---- one slice ----------------------------------------------------------------------------------

// What a method costs depends on where it would run.
static enum weft_result create_context_for_choice(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    return o[SLICE_MAX_ERROR].given && !o[SLICE_EXPLAIN].given ? slice_create_context(job)
                                                               : WEFT_OK;
}

typedef enum weft_result (*stage)(struct slice_job *job);

static enum weft_result run_stages(struct slice_job *job, const stage *stages)
{
    enum weft_result res = WEFT_OK;
    for (const stage *s = stages; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    return res;
}

static enum weft_result make_source(struct slice_job *job)
{
    static const stage planning[] = {slice_plan, create_context_for_choice, slice_choose, NULL};
    static const stage computing[] = {slice_create_context, slice_keep_volume, slice_plan_hardware,
                                      slice_find_range,     slice_compute,     NULL};
    const struct option_value *o = job->setup->option;
    enum weft_result res = run_stages(job, planning);
    if (res == WEFT_OK)
        res = o[SLICE_EXPLAIN].given ? slice_plan_hardware(job) : run_stages(job, computing);
    if (res == WEFT_OK)
        slice_tell_source(job);
    if (res == WEFT_OK && o[SLICE_EXPLAIN].given)
        report_erase_progress();
    if (res == WEFT_OK && o[SLICE_EXPLAIN].given && !o[SLICE_JSON].given)
        slice_print_explained(job);
    return res;
}

// A volume that cannot be opened is reported before any GL context is made.
static enum weft_result make_slice(struct slice_job *job)
{
    static const stage placing[] = {slice_open, slice_place, slice_allocate, NULL};
    static const stage curving[] = {slice_open, slice_load_curve, slice_allocate, NULL};
    const bool curved = slice_is_curved(job->setup);
    enum weft_result res = run_stages(job, curved ? curving : placing);
    for (int i = 0; i < job->setup->source_count && res == WEFT_OK; i++) {
        res = slice_take_source(job, i);
        if (res == WEFT_OK)
            res = curved ? slice_compute_points(job) : make_source(job);
    }
    if (res == WEFT_OK && curved)
        slice_warn_of_positions(job);
    if (res == WEFT_OK)
        slice_tell(job);
    return res;
}

static void destroy_job(struct slice_job *job)
{
    if (job)
        slice_clear(job);
    free(job);
}

// ---- told ---------------------------------------------------------------------------------------

// Messages and progress are about a slice from now on.
static void set_part(const struct slice_job *job)
{
    char name[64], place[64];
    snprintf(name, sizeof name, "frame %lld", (long long)job->frame);
    snprintf(place, sizeof place, "frame %d of %d", job->index + 1, job->setup->sweep.count);
    if (job->setup->sweep.given)
        report_set_part(name, place);
}

// What is said if a signal comes.
static void set_last_words(const struct frames *f)
{
    const struct slice_setup *setup = f->setup;
    if (!setup->sweep.given || setup->option[SLICE_EXPLAIN].given)
        return;
    if (f->complete)
        report_set_last_words("weft: ended with %d of %d frames complete, the last is %lld",
                              f->complete, setup->sweep.count, (long long)f->last);
    else
        report_set_last_words("weft: ended with none of %d frames complete", setup->sweep.count);
}

static void note_sum(const struct frames *f)
{
    const double seconds = report_now_seconds() - f->setup->start;
    report_note("%d of %d frames, %d skipped, in %.3f s", f->complete, f->setup->sweep.count,
                f->skipped, seconds);
}

static enum weft_result print_json(struct frames *f)
{
    static const struct slice_job none;
    struct run_stage stages[SLICE_STAGES];
    slice_stages(&none, stages);
    for (int i = 0; i < SLICE_STAGES; i++)
        stages[i].seconds = f->seconds[i];
    json_t *array = f->array, *ranks = load_report_json(&f->setup->divided.work, false);
    f->array = NULL;
    json_t *root =
        json_pack("{s:o,s:i,s:i,s:o,s:o,s:o}", "frames", array, "complete", f->complete, "skipped",
                  f->skipped, "resident", slice_resident_json(f->setup), "context",
                  run_report_context(f->setup->context), "seconds",
                  run_report_seconds(stages, SLICE_STAGES, report_now_seconds() - f->setup->start));
    if (ranks)
        json_object_set_new(root, "ranks", ranks);
    return json_print(root);
}

// ---- saving -------------------------------------------------------------------------------------

// What a frame has written, whoever wrote it, is in the list of all.
static void add_outputs(const json_t *frame)
{
    size_t i;
    json_t *file;
    json_array_foreach(json_object_get(frame, "output"), i, file)
        json_add_output(json_string_value(json_object_get(file, "path")));
}

// What is told of one slice by itself: its JSON, or text.
static enum weft_result tell_made(struct frames *f, struct slice_job *job)
{
    json_t *json = job->json;
    job->json = NULL;
    if (f->json && f->setup->sweep.given) {
        add_outputs(json);
        json_array_append_new(f->array, json);
        return WEFT_OK;
    }
    if (!f->json && job->made)
        slice_print_made(job);
    if (!f->json)
        return WEFT_OK;
    json_t *ranks = load_report_json(&f->setup->divided.work, false);
    if (ranks)
        json_object_set_new(json, "ranks", ranks);
    return json_print(json);
}

static void tell_skipped(struct frames *f, const struct slice_job *job)
{
    if (f->json)
        json_array_append_new(f->array,
                              json_pack("{s:I,s:[o],s:o}", "frame", (json_int_t)job->frame, "input",
                                        json_text(job->input), "problem", json_text(job->problem)));
    f->skipped++;
}

// Takes the job.
static enum weft_result tell(struct frames *f, struct slice_job *job)
{
    enum weft_result res = WEFT_OK;
    set_part(job);
    report_release(&job->held);
    if (job->problem[0])
        tell_skipped(f, job);
    else
        res = tell_made(f, job);
    f->failed = f->failed || (!job->problem[0] && !slice_is_verified(job));
    destroy_job(job);
    return res;
}

// Takes a job that is done with; those whose turn has come are told.
static enum weft_result put(struct frames *f, struct slice_job *job)
{
    enum weft_result res = WEFT_OK;
    f->waiting[job->index] = job;
    while (res == WEFT_OK && f->told < f->setup->sweep.count && f->waiting[f->told]) {
        job = f->waiting[f->told];
        f->waiting[f->told++] = NULL;
        res = tell(f, job);
    }
    return res;
}

// A slice that is whole: counted, and told in its turn. Takes the job.
static enum weft_result finish(struct frames *f, struct slice_job *job)
{
    struct run_stage stages[SLICE_STAGES];
    set_part(job);
    slice_tell_saved(job);
    slice_stages(job, stages);
    for (int i = 0; i < SLICE_STAGES; i++)
        f->seconds[i] += stages[i].seconds;
    f->complete++;
    f->last = job->frame;
    set_last_words(f);
    report_erase_progress();
    // Until it is told, it needs no pixels any more.
    free(job->pixels);
    job->pixels = NULL;
    return put(f, job);
}

static void *save_in_thread(void *priv)
{
    struct slice_job *job = priv;
    report_hold(&job->held);
    job->save_result = slice_save(job);
    return NULL;
}

static bool start_saving(struct frames *f, struct slice_job *job)
{
    struct saving *saving = &f->saving[(f->first_saving + f->savings) % SAVES];
    if (f->savings == SAVES || !ending_start_thread(&saving->thread, save_in_thread, job))
        return false;
    saving->job = job;
    f->savings++;
    return true;
}

static enum weft_result finish_saving(struct frames *f)
{
    const struct saving *saving = &f->saving[f->first_saving];
    struct slice_job *job = saving->job;
    pthread_join(saving->thread, NULL);
    f->first_saving = (f->first_saving + 1) % SAVES;
    f->savings--;
    if (job->save_result == WEFT_OK)
        return finish(f, job);
    const enum weft_result res = job->save_result;
    set_part(job);
    report_release(&job->held);
    destroy_job(job);
    return res;
}

// Until no more than so many are on their way. All that have begun are waited for after a failure,
// whose result counts.
static enum weft_result wait_for_saving(struct frames *f, int most)
{
    enum weft_result res = WEFT_OK;
    while (f->savings > (res == WEFT_OK ? most : 0)) {
        const enum weft_result one = finish_saving(f);
        res = res == WEFT_OK ? one : res;
    }
    return res;
}

// Takes the job. The last one is saved here, where progress is shown.
static enum weft_result save(struct frames *f, struct slice_job *job, bool last)
{
    const bool writes = job->made && (job->output || job->preview || job->errors.plane);
    if (writes && !last && start_saving(f, job))
        return WEFT_OK;
    set_part(job);
    const enum weft_result res = writes ? slice_save(job) : WEFT_OK;
    if (res == WEFT_OK)
        return finish(f, job);
    destroy_job(job);
    return res;
}

// ---- all of them --------------------------------------------------------------------------------

// Whether what failed is this frame's input, so that others may do better: its file, or what is
// read from there. A grid that is not in the file is the frame's fault too.
static bool is_bad(const struct slice_job *job, enum weft_result res)
{
    if (!job->volume && !numbered_is(job->setup->input))
        return false;
    return res == WEFT_ERR_OPEN || res == WEFT_ERR_FORMAT || res == WEFT_ERR_READER ||
           res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT ||
           (!job->volume && res == WEFT_ERR_ARGUMENT);
}

// Whether the sweep goes on without the frame; its error line is kept then, and its volume closed:
// who knows what state that is in.
static bool can_skip(struct slice_job *job, enum weft_result res)
{
    if (!job->setup->option[SLICE_SKIP_BAD].given || job->over_budget || !is_bad(job, res))
        return false;
    if (!report_get_error()[0])
        report_error("%s", weft_result_text(res));
    snprintf(job->problem, sizeof job->problem, "%s", report_get_error());
    slice_close(job->setup);
    return true;
}

// Of slices that all ranks make together: what rank 0 has found counts.
static enum weft_result agree(const struct frames *f, enum weft_result res, bool *skips)
{
    if (!f->setup->divided.is)
        return res;
    res = ranks_agree(res);
    const enum weft_result shared = ranks_share(skips, sizeof *skips);
    return shared == WEFT_OK ? res : shared;
}

static enum weft_result make_frame(struct frames *f, int index)
{
    struct slice_job *job = malloc(sizeof *job);
    const bool together = f->setup->divided.is;
    bool ends = false;
    if (!job)
        return WEFT_ERR_MEMORY;
    enum weft_result res = sweep_start(f->setup, index, job);
    set_part(job);
    if (res == WEFT_OK)
        res = together ? slice_make_divided(job) : make_slice(job);
    if (res == WEFT_OK && together && ranks_tells())
        slice_tell(job);
    f->failed = f->failed || job->over_budget;
    slice_release(job);
    bool skips = res != WEFT_OK && can_skip(job, res);
    // The one before comes first.
    enum weft_result before = wait_for_saving(f, 0);
    ends = before != WEFT_OK || f->failed;
    before = agree(f, before, &skips);
    if (together && ranks_share(&ends, sizeof ends) != WEFT_OK)
        ends = true;
    if (ends || (res != WEFT_OK && !skips)) {
        destroy_job(job);
        return before != WEFT_OK ? before : res != WEFT_OK || ranks_tells() ? res : WEFT_ERR_LIMIT;
    }
    if (skips)
        return put(f, job);
    if (ranks_tells())
        return save(f, job, index == f->setup->sweep.count - 1);
    destroy_job(job);
    return WEFT_OK;
}

static enum weft_result make_frames(struct frames *f)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < f->setup->sweep.count && res == WEFT_OK && !f->failed; i++)
        res = make_frame(f, i);
    const enum weft_result saved = wait_for_saving(f, 0);
    return res == WEFT_OK ? saved : res;
}

// ---- frames that ranks divide -------------------------------------------------------------------

// Messages are held until the frame's turn to be told, but for those of a failure that ends all.
static enum weft_result make_held(struct slice_job *job)
{
    report_hold(&job->held);
    const enum weft_result res = make_slice(job);
    report_hold(NULL);
    slice_release(job);
    if (res == WEFT_OK)
        return res;
    // This rank has its error then, and rank 0 has shown it; what others hold goes there.
    const int count = job->held.count;
    report_release(&job->held);
    job->held.count = ranks_tells() ? 0 : count;
    return res;
}

static enum weft_result run_frame(void *priv, int64_t index, void **data, size_t *size)
{
    struct frames *f = priv;
    struct slice_job *job = malloc(sizeof *job);
    enum parcel_kind kind = PARCEL_MADE;
    if (!job)
        return WEFT_ERR_MEMORY;
    enum weft_result res = sweep_start(f->setup, (int)index, job);
    set_part(job);
    if (res == WEFT_OK)
        res = make_held(job);
    if (job->over_budget)
        kind = PARCEL_OVER_BUDGET;
    else if (res != WEFT_OK && can_skip(job, res))
        kind = PARCEL_SKIPPED;
    if (res == WEFT_OK || kind != PARCEL_MADE)
        res = parcel_write_slice(job, kind, data, size);
    destroy_job(job);
    return res;
}

// Ends the work where the command fails by what pixels are.
static enum weft_result take_frame(void *priv, int64_t index, const void *data, size_t size)
{
    struct frames *f = priv;
    struct slice_job *job = malloc(sizeof *job);
    enum parcel_kind kind = PARCEL_MADE;
    if (!job)
        return WEFT_ERR_MEMORY;
    enum weft_result res = sweep_start(f->setup, (int)index, job);
    if (res == WEFT_OK)
        res = parcel_read_slice(data, size, job, &kind);
    const enum weft_result before = wait_for_saving(f, SAVES - 1);
    if (res != WEFT_OK || before != WEFT_OK || kind == PARCEL_OVER_BUDGET) {
        f->failed = f->failed || kind == PARCEL_OVER_BUDGET;
        set_part(job);
        report_release(&job->held);
        destroy_job(job);
        return before != WEFT_OK ? before : res != WEFT_OK ? res : WEFT_ERR_LIMIT;
    }
    res = kind == PARCEL_SKIPPED ? put(f, job) : save(f, job, false);
    return res == WEFT_OK && f->failed ? WEFT_ERR_LIMIT : res;
}

static enum weft_result divide_frames(struct frames *f)
{
    struct slice_divided *divided = &f->setup->divided;
    enum weft_result res = ranks_agree(slice_share_first(f->setup));
    if (res == WEFT_OK && f->setup->engine.engine == WEFT_ENGINE_GL)
        res = slice_create_context(&(struct slice_job){.setup = f->setup});
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_check_alike(f->setup->context, divided->request.mixed);
    if (res == WEFT_OK)
        res = ranks_agree(weft_ranks_do_items(ranks_get(),
                                              &(struct weft_items){
                                                  .count = f->setup->sweep.count,
                                                  .schedule = divided->request.schedule,
                                                  .run = run_frame,
                                                  .take = take_frame,
                                                  .priv = f,
                                                  .progress = report_progress("slicing"),
                                              },
                                              &divided->work));
    const enum weft_result saved = wait_for_saving(f, 0);
    return ranks_agree(res == WEFT_OK ? saved : res);
}

// ---- the command --------------------------------------------------------------------------------

static int exit_code(const struct frames *f, enum weft_result res)
{
    const int code = report_finish(res);
    return f->failed ? EXIT_CODE_FAILED : res == WEFT_OK && f->skipped ? EXIT_CODE_INPUT : code;
}

// How busy ranks were, as text and chart.
static enum weft_result tell_ranks(const struct frames *f)
{
    const struct slice_divided *divided = &f->setup->divided;
    if (!divided->is)
        return WEFT_OK;
    if (!f->json)
        load_report_print(&divided->work);
    return divided->request.chart ? load_report_plot(&divided->work, divided->request.chart)
                                  : WEFT_OK;
}

int sweep_run(struct slice_setup *setup)
{
    const struct slice_sweep *sweep = &setup->sweep;
    struct frames f = {.setup = setup, .json = setup->option[SLICE_JSON].given};
    if (sweep->given && f.json)
        f.array = json_array();
    f.waiting = calloc((size_t)sweep->count, sizeof *f.waiting);
    set_last_words(&f);
    enum weft_result res = !f.waiting              ? WEFT_ERR_MEMORY
                           : setup->divided.frames ? divide_frames(&f)
                                                   : make_frames(&f);
    report_erase_progress();
    report_set_part(NULL, NULL);
    if (res == WEFT_OK && ranks_tells())
        res = tell_ranks(&f);
    if (res == WEFT_OK && f.json && sweep->given)
        res = print_json(&f);
    if (sweep->given && f.complete && (res != WEFT_OK || f.failed))
        report_warning("%d of %d frames are complete, the last is %lld", f.complete, sweep->count,
                       (long long)f.last);
    else if (f.skipped)
        report_warning("%d of %d frames were skipped", f.skipped, sweep->count);
    if (sweep->given)
        note_sum(&f);
    if (res == WEFT_OK && setup->aspect[0])
        report_tell("%s", setup->aspect);
    json_decref(f.array);
    for (int i = 0; f.waiting && i < sweep->count; i++)
        destroy_job(f.waiting[i]);
    free(f.waiting);
    return exit_code(&f, res);
}
