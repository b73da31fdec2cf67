// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/numbered.h"
#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/save.h"

// ---- options ------------------------------------------------------------------------------------

static const char *conflict_of_one(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    if (setup->framing.at.moves)
        return "--at A..B needs --frames FIRST-LAST";
    if (o[SLICE_STEP].given || o[SLICE_PLANES].given || o[SLICE_SKIP_BAD].given)
        return "--step, --planes and --skip-bad need --frames FIRST-LAST";
    const char *const names[] = {setup->input, o[SLICE_OUTPUT].text, o[SLICE_PREVIEW].text};
    for (int i = 0; i < 3; i++)
        if (names[i] && numbered_is(names[i]))
            return "a name with a frame's number, as %04d, needs --frames FIRST-LAST";
    return NULL;
}

static const char *conflict_of_frames(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option, *step = &o[SLICE_STEP];
    if (o[SLICE_PLANES].given &&
        (o[SLICE_AXIS].given || o[SLICE_AT].given || o[SLICE_ORIGIN].given || step->given))
        return "--planes excludes --axis, --at, --origin, --u, --v and --step";
    if (step->given && !o[SLICE_ORIGIN].given)
        return "--step goes with --origin, --u and --v; with --axis, --at A..B moves the plane";
    const bool steps =
        step->given && (step->number[0] != 0.0 || step->number[1] != 0.0 || step->number[2] != 0.0);
    if (step->given && !steps)
        return "--step 0,0,0 does not move the plane";
    if (!steps && !o[SLICE_PLANES].given && !setup->framing.at.moves && !numbered_is(setup->input))
        return "all frames would be the same: give --at A..B, --origin with --step, --planes FILE, "
               "or a volume's name with the frame's number, as smoke_%04d.vdb";
    return NULL;
}

const char *sweep_conflict(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    if (o[SLICE_PLANES].given && (o[SLICE_U].given || o[SLICE_V].given))
        return "--planes excludes --axis, --at, --origin, --u, --v and --step";
    return o[SLICE_FRAMES].given ? conflict_of_frames(setup) : conflict_of_one(setup);
}

enum weft_result sweep_read(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    struct slice_sweep *sweep = &setup->sweep;
    *sweep = (struct slice_sweep){.given = o[SLICE_FRAMES].given, .step = 1, .count = 1};
    if (!sweep->given)
        return WEFT_OK;
    struct numbered_span span;
    enum weft_result res = numbered_read_span(o[SLICE_FRAMES].text, SWEEP_MAX_FRAMES, &span);
    if (res == WEFT_OK)
        res = numbered_check("", setup->input, false);
    if (res == WEFT_OK && o[SLICE_OUTPUT].given)
        res = numbered_check("-o ", o[SLICE_OUTPUT].text, true);
    if (res == WEFT_OK && o[SLICE_PREVIEW].given)
        res = numbered_check("--preview ", o[SLICE_PREVIEW].text, true);
    if (res != WEFT_OK)
        return res;
    sweep->first = span.first;
    sweep->last = span.last;
    sweep->step = span.step;
    sweep->count = (int)((sweep->last - sweep->first) / sweep->step) + 1;
    return o[SLICE_PLANES].given ? sweep_load_planes(o[SLICE_PLANES].text,
                                                     sweep->last - sweep->first + 1, &sweep->planes)
                                 : WEFT_OK;
}

void sweep_clear(struct slice_sweep *sweep)
{
    free(sweep->planes);
    sweep->planes = NULL;
}

// ---- frames -------------------------------------------------------------------------------------

enum weft_result sweep_start(struct slice_setup *setup, int index, struct slice_job *job)
{
    const struct slice_sweep *sweep = &setup->sweep;
    const struct option_value *o = setup->option;
    const char *const names[] = {setup->input, o[SLICE_OUTPUT].text, o[SLICE_PREVIEW].text};
    const char **const out[] = {&job->input, &job->output, &job->preview};
    *job = (struct slice_job){.setup = setup,
                              .index = index,
                              .frame = sweep->first + index * sweep->step,
                              .start = index ? report_now_seconds() : setup->start};
    for (int i = 0; i < 3; i++) {
        *out[i] = names[i];
        if (!names[i] || !sweep->given)
            continue;
        *out[i] = job->numbered[i] = numbered_format(names[i], job->frame);
        if (!*out[i]) {
            report_error("out of memory for the name of frame %lld", (long long)job->frame);
            return WEFT_ERR_MEMORY;
        }
    }
    return WEFT_OK;
}

// ---- files --------------------------------------------------------------------------------------

// Moves the job's names into the list.
static void add_files(struct slice_job *job, struct numbered_file *files, size_t *count)
{
    for (int i = 0; i < 3; i++) {
        if (!job->numbered[i])
            continue;
        files[(*count)++] =
            (struct numbered_file){.path = job->numbered[i], .frame = job->frame, .input = i == 0};
        job->numbered[i] = NULL;
    }
}

enum weft_result sweep_check_files(struct slice_setup *setup)
{
    const bool writes = !setup->option[SLICE_EXPLAIN].given && ranks_tells();
    struct numbered_file *files = calloc(3 * (size_t)setup->sweep.count, sizeof *files);
    enum weft_result res = files ? WEFT_OK : WEFT_ERR_MEMORY;
    size_t count = 0;
    for (int i = 0; i < setup->sweep.count && res == WEFT_OK; i++) {
        struct slice_job job;
        res = sweep_start(setup, i, &job);
        const struct preview_options preview = slice_preview_options(&job);
        if (res == WEFT_OK)
            res = preview_check_outputs(&preview, writes);
        add_files(&job, files, &count);
        slice_clear(&job);
    }
    if (res == WEFT_OK)
        res = numbered_check_files(files, count);
    for (size_t i = 0; i < count; i++)
        free(files[i].path);
    free(files);
    return res;
}
