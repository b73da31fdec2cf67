// SPDX-License-Identifier: BSD-3-Clause
// What ranks of `weft resample` read, measure and choose before they filter. Each has planes of all
// of the input, into which it reads the rows that it needs, and no others; what is of all samples
// is measured in shares and joined. Coefficients of prefiltered kernels depend on all samples of
// their rows and columns: all ranks read all rows then, and compute the same.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/resample/job.h"

// Parts for each rank; lines that are read at once, as many as most files pack together; and those
// that parts have a whole number of, which are all that weft packs together.
enum { GRANULARITY = 8, LINES_READ = 16, LINES_PACKED = 32 };

// What is joined of a group.
struct resample_shared {
    struct weft_resample_measured measured;
    struct weft_resample_survey survey;
    uint32_t range[2]; // of an exact group's integers; the first above the second: none
    uint64_t rounded[RESAMPLE_MAX_TOGETHER];
};

const struct weft_resample_survey *resample_survey_of(const struct resample_job *job, size_t g)
{
    return &job->divided.shared[g].survey;
}

const struct weft_resample_measured *resample_measured_of(const struct resample_job *job, size_t g)
{
    return &job->divided.shared[g].measured;
}

void resample_clear_divided(struct resample_divided *d)
{
    rank_division_clear(&d->division);
    weft_items_report_clear(&d->work);
    for (int64_t i = 0; i < d->band_count; i++)
        free((void *)(uintptr_t)d->bands[i].data);
    free(d->bands);
    free(d->order);
    free(d->lost);
    free(d->has_row);
    free(d->shared);
    *d = (struct resample_divided){.is = false};
}

// ---- options ------------------------------------------------------------------------------------

enum weft_result resample_read_ranks(struct resample_job *job)
{
    struct resample_divided *d = &job->divided;
    const enum weft_result res = rank_options_read(&job->option[RESAMPLE_RANKS], &d->request);
    d->is = (ranks_size() > 1 || d->request.given) && !job->option[RESAMPLE_EXPLAIN].given;
    // Parts of one size take one time, and a rank's own rows are there already.
    if (d->request.schedule == WEFT_SCHEDULE_AUTO)
        d->request.schedule = WEFT_SCHEDULE_STATIC;
    if (res != WEFT_OK || d->request.region[0] >= 0 || !d->is)
        return res;
    report_error("--region frame: there is one picture, of which a part at least is for each rank; "
                 "--region rows:N makes parts of N rows");
    return WEFT_ERR_ARGUMENT;
}

// ---- parts --------------------------------------------------------------------------------------

// Whole rows, unless something else is asked for: lines are what files have, so that nothing is
// read or unpacked twice but what neighbours share, and each part can be packed as it is.
static enum weft_result divide(struct resample_job *job)
{
    struct rank_request request = job->divided.request;
    const int size[2] = {job->result.width, job->result.height};
    if (!request.region[0] && !request.region[1]) {
        const int each = request.granularity ? request.granularity : GRANULARITY;
        const int64_t parts = (int64_t)each * ranks_size();
        const int64_t rows = (size[1] + parts - 1) / parts;
        request.region[1] = (int32_t)((rows + LINES_PACKED - 1) / LINES_PACKED * LINES_PACKED);
    }
    return rank_division_create(&request, size, GRANULARITY, 1, &job->divided.division);
}

// Whether all parts are whole rows from where the file packs lines together on.
static bool are_bands(const struct resample_job *job)
{
    const weft_regions *regions = weft_division_regions(job->divided.division.division);
    const int lines = weft_image_block_lines(job->result.compression);
    bool are = true;
    for (int64_t i = 0; are && i < weft_regions_count(regions); i++) {
        const struct weft_rectangle at = weft_regions_get(regions, i);
        are = at.width == job->result.width && at.y % lines == 0;
    }
    return are;
}

// What is made of the parts.
static void choose_outputs(struct resample_job *job)
{
    const struct option_value *o = job->option;
    struct resample_divided *d = &job->divided;
    resample_choose_compression(job);
    d->packs = o[RESAMPLE_OUTPUT].given && d->only && job->kind == WEFT_IMAGE_FILE_EXR &&
               !job->result.tiled && are_bands(job);
    d->sends = o[RESAMPLE_PREVIEW].given ||
               (o[RESAMPLE_OUTPUT].given && (o[RESAMPLE_VERIFY].given || !d->packs));
}

// The row of the input that a row of the result begins a share of all rows with.
static int share_at(const struct resample_job *job, int row)
{
    const double at = floor(weft_window_map_position(&job->map[1], row, 0));
    const double last = job->image.height;
    return row <= 0 ? 0 : at < 0.0 ? 0 : at > last ? (int)last : (int)at;
}

// Rows of parts, and parts in a row.
static int64_t count_rows(const struct resample_job *job, int64_t *across)
{
    const weft_regions *regions = weft_division_regions(job->divided.division.division);
    const int64_t count = weft_regions_count(regions);
    const int32_t first = weft_regions_get(regions, 0).y;
    for (*across = 1; *across < count && weft_regions_get(regions, *across).y == first;)
        ++*across;
    return count / *across;
}

// The first row of parts of a rank's share: shares are side by side, so that what they reach beyond
// themselves is little.
static int64_t share_of(int64_t rows, int rank)
{
    return rows * rank / ranks_size();
}

// This rank's share of the input's rows; false: none.
static bool find_share(const struct resample_job *job, int *first, int *end)
{
    const weft_regions *regions = weft_division_regions(job->divided.division.division);
    int64_t across;
    const int64_t rows = count_rows(job, &across);
    const int64_t from = share_of(rows, ranks_rank()), to = share_of(rows, ranks_rank() + 1);
    *first = share_at(job, weft_regions_get(regions, from * across).y);
    *end = to < rows ? share_at(job, weft_regions_get(regions, to * across).y) : job->image.height;
    return from < to && *first < *end;
}

// The parts of each rank's share in turn: where all are done in turn they are of their rank.
static enum weft_result set_order(struct resample_job *job)
{
    int64_t across, at = 0;
    const int64_t rows = count_rows(job, &across), count = rows * across;
    int64_t *order = job->divided.order = malloc((size_t)count * sizeof *order);
    if (!order) {
        report_error("out of memory for %lld parts", (long long)count);
        return WEFT_ERR_MEMORY;
    }
    for (int64_t k = 0; at < count; k++)
        for (int r = 0; r < ranks_size(); r++)
            if (share_of(rows, r) * across + k < share_of(rows, r + 1) * across)
                order[at++] = share_of(rows, r) * across + k;
    return WEFT_OK;
}

// ---- rows ---------------------------------------------------------------------------------------

static enum weft_result allocate_rows(struct resample_job *job)
{
    const size_t count = (size_t)job->image.width * (size_t)job->image.height;
    struct resample_divided *d = &job->divided;
    bool whole = (d->has_row = calloc((size_t)job->image.height, 1)) != NULL;
    whole = (d->shared = calloc(job->group_count, sizeof *d->shared)) != NULL && whole;
    for (size_t i = 0; whole && i < job->image.channel_count; i++) {
        struct weft_image_channel *channel = &job->image.channels[i];
        const bool integers = channel->type == WEFT_PIXEL_UINT;
        channel->plane = malloc(count * sizeof *channel->plane);
        channel->integers = integers ? malloc(count * sizeof *channel->integers) : NULL;
        whole = channel->plane && (channel->integers || !integers);
    }
    if (whole)
        return WEFT_OK;
    report_error("out of memory for %zu channels of %d x %d samples", job->image.channel_count,
                 job->image.width, job->image.height);
    return WEFT_ERR_MEMORY;
}

static enum weft_result load(struct resample_job *job, int first, int rows)
{
    const struct weft_image_load_params params = {.path = job->input,
                                                  .part = job->part,
                                                  .first_row = first,
                                                  .rows = rows,
                                                  .transfer = resample_transfer(job),
                                                  .threads = job->engine.cpu.threads,
                                                  .log = report_log()};
    const size_t width = (size_t)job->image.width, at = (size_t)first * width,
                 count = (size_t)rows * width;
    struct weft_image image;
    enum weft_result res = weft_image_load(&params, &image);
    if (res == WEFT_OK && (image.width != job->image.width || image.height != job->image.height ||
                           image.channel_count != job->image.channel_count)) {
        report_error("%s has changed while it was read", job->input);
        res = WEFT_ERR_FORMAT;
    }
    for (size_t i = 0; res == WEFT_OK && i < image.channel_count; i++) {
        struct weft_image_channel *to = &job->image.channels[i], *from = &image.channels[i];
        memcpy(to->plane + at, from->plane, count * sizeof *to->plane);
        if (to->integers && from->integers)
            memcpy(to->integers + at, from->integers, count * sizeof *to->integers);
    }
    if (res == WEFT_OK)
        memset(job->divided.has_row + first, 1, (size_t)rows);
    weft_image_clear(&image);
    return res;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

enum weft_result resample_load_rows(struct resample_job *job, int first, int end)
{
    const double start = report_now_seconds();
    const unsigned char *has = job->divided.has_row;
    enum weft_result res = WEFT_OK;
    for (int y = first; res == WEFT_OK && y < end;) {
        int to = y;
        while (to < end && !has[to])
            to++;
        // What is packed together is read together.
        const int from = y / LINES_READ * LINES_READ;
        const int all = smaller((to + LINES_READ - 1) / LINES_READ * LINES_READ, job->image.height);
        if (to > y)
            res = load(job, from, all - from);
        y = to > y ? all : y + 1;
    }
    job->load_seconds += report_now_seconds() - start;
    return res;
}

// ---- measuring ----------------------------------------------------------------------------------

static void join(struct resample_shared *sum, const struct resample_shared *other)
{
    weft_resample_measured_join(&sum->measured, &other->measured);
    weft_resample_survey_join(&sum->survey, &other->survey);
    sum->range[0] = other->range[0] < sum->range[0] ? other->range[0] : sum->range[0];
    sum->range[1] = other->range[1] > sum->range[1] ? other->range[1] : sum->range[1];
    for (int c = 0; c < RESAMPLE_MAX_TOGETHER; c++)
        sum->rounded[c] += other->rounded[c];
}

// Collective: all get what all have.
static enum weft_result join_all(struct resample_job *job)
{
    struct weft_ranks_part *parts = calloc((size_t)ranks_size(), sizeof *parts);
    const size_t size = job->group_count * sizeof *job->divided.shared;
    enum weft_result res = ranks_agree(parts ? WEFT_OK : WEFT_ERR_MEMORY);
    if (res == WEFT_OK)
        res = weft_ranks_gather(ranks_get(), job->divided.shared, size, parts);
    for (int r = 1; res == WEFT_OK && ranks_tells() && r < ranks_size(); r++)
        for (size_t g = 0; g < job->group_count; g++)
            join(&job->divided.shared[g], (const struct resample_shared *)parts[r].data + g);
    if (res == WEFT_OK && ranks_tells())
        weft_ranks_free_parts(ranks_size(), parts);
    free(parts);
    return res == WEFT_OK ? ranks_share(job->divided.shared, size) : res;
}

// Rows that a share's differences and pixels may read beside its own.
static int margin_of(const struct resample_job *job)
{
    return job->kernel.width + WEFT_STATISTICS_DIFFERENCES;
}

static enum weft_result measure_group(struct resample_job *job, size_t g, int first, int end)
{
    const struct resample_group *group = &job->group[g];
    struct resample_shared one = {.range = {UINT32_MAX, 0}};
    const int past = smaller(end + WEFT_STATISTICS_DIFFERENCES, job->image.height);
    struct weft_resample_source_params params =
        resample_source_params(job, group, first, past - first);
    const enum weft_result res =
        weft_resample_measure(&params, first, end - first, resample_tells_e1(job), &one.measured);
    if (group->exact) {
        const struct weft_resample_integers integers =
            resample_integers(job, group, first, end - first);
        weft_resample_integer_range(&integers, one.range);
    }
    for (int c = 0; c < group->count; c++)
        one.rounded[c] = resample_count_rounded(job, job->source[group->channel[c]], first, end);
    join(&job->divided.shared[g], &one);
    return res;
}

// A prefiltered kernel's are measured whole, of all samples that every rank has.
static enum weft_result measure_share(struct resample_job *job)
{
    const int height = job->image.height, margin = margin_of(job);
    int first, end;
    if (job->kernel.prefiltered)
        return resample_load_rows(job, 0, height);
    if (!find_share(job, &first, &end))
        return WEFT_OK;
    enum weft_result res =
        resample_load_rows(job, first > margin ? first - margin : 0, smaller(end + margin, height));
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = measure_group(job, g, first, end);
    return res;
}

// Of one row where what all have was joined: it stands for its statistics alone.
static enum weft_result create_source(struct resample_job *job, size_t g)
{
    struct resample_group *group = &job->group[g];
    const struct resample_shared *shared = &job->divided.shared[g];
    struct weft_resample_source_params params =
        resample_source_params(job, group, 0, job->kernel.prefiltered ? job->image.height : 1);
    if (!job->kernel.prefiltered)
        params.measured = &shared->measured;
    const enum weft_result res = weft_resample_source_create(&params, &group->source);
    if (res != WEFT_OK)
        return res;
    const struct weft_resample_source_info *info = weft_resample_source_get_info(group->source);
    group->statistics = info->statistics;
    group->e1 = resample_tells_e1(job) ? weft_resample_e1(group->source) : (double)NAN;
    job->work.prepare_seconds += info->prefilter_seconds;
    if (group->exact) {
        group->statistics.low = group->statistics.sample_low = shared->range[0];
        group->statistics.high = group->statistics.sample_high = shared->range[1];
    }
    for (int c = 0; c < group->count; c++)
        group->rounded[c] = shared->rounded[c];
    if (job->kernel.prefiltered)
        for (int c = 0; c < group->count; c++)
            group->rounded[c] =
                resample_count_rounded(job, job->source[group->channel[c]], 0, job->image.height);
    return WEFT_OK;
}

enum weft_result resample_measure_parts(struct resample_job *job)
{
    enum weft_result res = ranks_agree(allocate_rows(job));
    if (res == WEFT_OK)
        res = divide(job);
    if (res == WEFT_OK)
        res = ranks_agree(set_order(job));
    if (res == WEFT_OK)
        choose_outputs(job);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        job->divided.shared[g] = (struct resample_shared){.measured = WEFT_RESAMPLE_MEASURED_NONE,
                                                          .range = {UINT32_MAX, 0}};
    if (res == WEFT_OK)
        res = ranks_agree(measure_share(job));
    if (res == WEFT_OK)
        res = join_all(job);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = create_source(job, g);
    if (res != WEFT_OK)
        return res;
    resample_warn_of_rounding(job);
    for (size_t g = 0; g < job->group_count; g++)
        resample_set_budget(job, &job->group[g]);
    return WEFT_OK;
}

// ---- choosing -----------------------------------------------------------------------------------

// What choices depend on, besides what is measured.
struct chosen_by {
    bool automatic, calibrated;
    enum weft_engine engine;
    int threads;
    struct weft_cost_model model;
};

enum weft_result resample_plan_alike(struct resample_job *job)
{
    struct engine *engine = &job->engine;
    const bool budget = job->option[RESAMPLE_MAX_ERROR].given;
    const int own = engine->cpu.threads;
    enum weft_result res = WEFT_OK;
    if (budget && !job->separable) // whose costs count
        res = ranks_agree(resample_create_context(job));
    if (res != WEFT_OK)
        return res;
    if (budget || engine->automatic)
        engine_load_costs(engine, job->context);
    struct chosen_by by = {engine->automatic, engine->calibrated, engine->engine, own,
                           engine->model};
    res = ranks_share(&by, sizeof by);
    if (res != WEFT_OK)
        return res;
    engine->automatic = by.automatic;
    engine->calibrated = by.calibrated;
    engine->engine = by.engine;
    engine->model = by.model;
    engine->cpu.threads = by.threads;
    res = resample_plan(job);
    engine->cpu.threads = own;
    return res;
}

// ---- surveying ----------------------------------------------------------------------------------

static enum weft_result survey_group(struct resample_job *job, size_t g, int first, int end)
{
    const struct resample_group *group = &job->group[g];
    struct weft_resample_source_params params =
        resample_source_params(job, group, first, end - first);
    struct weft_resample_survey one;
    weft_resample_source *source = NULL;
    params.measured = &job->divided.shared[g].measured;
    enum weft_result res = weft_resample_source_create(&params, &source);
    if (res == WEFT_OK)
        res = weft_resample_survey_source(group->plan, source, &one);
    if (res == WEFT_OK)
        weft_resample_survey_join(&job->divided.shared[g].survey, &one);
    weft_resample_source_destroy(&source);
    return res;
}

static enum weft_result survey_share(struct resample_job *job)
{
    enum weft_result res = WEFT_OK;
    int first, end;
    if (!find_share(job, &first, &end))
        return WEFT_OK;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = job->group[g].exact ? WEFT_OK : survey_group(job, g, first, end);
    return res;
}

enum weft_result resample_survey_parts(struct resample_job *job)
{
    enum weft_result res = WEFT_OK;
    if (!job->separable)
        return WEFT_OK;
    if (job->kernel.prefiltered) {
        for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
            if (!job->group[g].exact)
                res = weft_resample_survey_source(job->group[g].plan, job->group[g].source,
                                                  &job->divided.shared[g].survey);
        return ranks_agree(res);
    }
    res = ranks_agree(survey_share(job));
    struct resample_shared *kept = malloc(job->group_count * sizeof *kept);
    res = res == WEFT_OK ? ranks_agree(kept ? WEFT_OK : WEFT_ERR_MEMORY) : res;
    // Counts are joined already.
    if (res == WEFT_OK) {
        memcpy(kept, job->divided.shared, job->group_count * sizeof *kept);
        res = join_all(job);
    }
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        job->divided.shared[g].measured = kept[g].measured;
    free(kept);
    return res;
}
