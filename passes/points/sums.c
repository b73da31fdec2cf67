// SPDX-License-Identifier: BSD-3-Clause
// Sums of points whose bricks are there: blocks of voxels around cells, and lines of points.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/points/points_impl.h"
#include "tiles/volume/block_layout.h"

// Points of a part; and blocks that a line's points may lie in, small enough together for the
// second cache. Places lie in the points' order, not in the sorted one: they are asked for so many
// points before.
enum { PART = 4096, BLOCKS = 16, AHEAD = 24 };

// What a thread has.
struct worker {
    const struct weft_point_job *job;
    struct weft_brick_memo memo;
    float *memory;        // of blocks: span^3 each, and samples past the last one
    float *block[BLOCKS]; // those that the line's points lie in come first
    int used;
    // The line that is being gathered.
    int count;
    uint32_t number[WEFT_LINE_PIXELS]; // of the batch's points
    const float *start[WEFT_LINE_PIXELS + WEFT_LINE_PAD];
    uint32_t word[3][WEFT_LINE_PIXELS + WEFT_LINE_PAD];
    float out[WEFT_DERIVATIVES * WEFT_LINE_PIXELS];
    bool exactly[PART]; // points of the part that are not for lines
    uint64_t not_finite, exact;
    float low, high; // of the finite voxels that were gathered
};

struct sums {
    const struct weft_point_job *job;
    struct worker *workers;
    size_t first, end; // of the sorted points
};

static void put(struct worker *w, int output, size_t number, float value)
{
    const struct weft_point_job *job = w->job;
    job->params->out[(size_t)output * job->params->stride + job->batch->first + number] = value;
    w->not_finite += !isfinite(value);
}

static void end_line(struct worker *w)
{
    const weft_points *p = w->job->points;
    if (w->count) {
        const int last = w->count - 1;
        for (int i = 0; i < WEFT_LINE_PAD; i++) {
            w->start[w->count + i] = w->start[last];
            for (int a = 0; a < 3; a++)
                w->word[a][w->count + i] = w->word[a][last];
        }
        p->line(&(struct weft_line){.kernel = &p->lines,
                                    .start = w->start,
                                    .listed = {w->word[0], w->word[1], w->word[2]},
                                    .count = w->count,
                                    .out = w->out,
                                    .plane = WEFT_LINE_PIXELS});
    }
    for (int o = 0; o < p->info.output_count; o++)
        for (int i = 0; i < w->count; i++)
            put(w, o, w->number[i], w->out[o * WEFT_LINE_PIXELS + i]);
    w->count = w->used = 0;
}

// ---- voxels that floats do not stand ------------------------------------------------------------

static bool unfit(const weft_points *p, float voxel)
{
    return !(voxel >= -p->largest_fit && voxel <= p->largest_fit);
}

static const float *first_tap(const weft_points *p, const float *block,
                              const struct weft_point_place *place)
{
    const size_t pitch = (size_t)p->span;
    return block + (place->word[0] >> WEFT_LINE_FRACTION) +
           ((place->word[2] >> WEFT_LINE_FRACTION) * pitch +
            (place->word[1] >> WEFT_LINE_FRACTION)) *
               pitch;
}

static bool reaches_unfit(const weft_points *p, const float *first)
{
    const int width = p->info.kernel.width;
    for (int z = 0; z < width; z++)
        for (int y = 0; y < width; y++)
            for (int x = 0; x < width; x++)
                if (unfit(p, first[(z * p->span + y) * p->span + x]))
                    return true;
    return false;
}

// Taps whose weight is exactly 0 do not count.
static double convolve(const weft_points *p, const float *first, double w[3][WEFT_KERNEL_MAX_WIDTH])
{
    const int width = p->info.kernel.width;
    double sum = 0.0;
    for (int z = 0; z < width; z++) {
        for (int y = 0; y < width; y++) {
            const float *row = first + (z * p->span + y) * p->span;
            double line = 0.0;
            if (w[2][z] == 0.0 || w[1][y] == 0.0)
                continue;
            for (int x = 0; x < width; x++)
                line += w[0][x] == 0.0 ? 0.0 : w[0][x] * (double)row[x];
            sum += w[2][z] * w[1][y] * line;
        }
    }
    return sum;
}

static void add_exactly(struct worker *w, const float *first, size_t number)
{
    const weft_points *p = w->job->points;
    const struct weft_point_place *place = &w->job->batch->place[number];
    const double shift = ldexp((double)p->tap_shift, -WEFT_LINE_FRACTION);
    for (int o = 0; o < p->info.output_count; o++) {
        double weight[3][WEFT_KERNEL_MAX_WIDTH];
        for (int a = 0; a < 3; a++) {
            const uint32_t fraction = place->word[a] & ((UINT32_C(1) << WEFT_LINE_FRACTION) - 1);
            weft_kernel_weights(&p->kernel[p->info.output[o].along[a]],
                                ldexp((double)fraction, -WEFT_LINE_FRACTION) - shift, weight[a]);
        }
        put(w, o, number, (float)convolve(p, first, weight));
    }
    w->exact++;
}

// ---- runs ---------------------------------------------------------------------------------------

// A run's box within its block.
struct box {
    float *block, *at;
    int size[3];
};

static struct box gather(struct worker *w, const struct weft_point_run *run)
{
    const weft_points *p = w->job->points;
    const int span = p->span, width = p->info.kernel.width;
    int32_t min[3], max[3];
    struct box box = {.block = w->block[w->used++]};
    weft_point_run_box(p, run, min, max);
    for (int a = 0; a < 3; a++)
        box.size[a] = max[a] - min[a] + 1;
    box.at = box.block + (run->low[2] * span + run->low[1]) * span + run->low[0];
    if (box.size[0] == span && box.size[1] == span && box.size[2] == span) {
        const int32_t origin[3] = {min[0] + p->tap_offset, min[1] + p->tap_offset,
                                   min[2] + p->tap_offset};
        weft_brick_store_copy_block(p->bricks.store, origin, p->tap_offset,
                                    width - 1 - p->tap_offset, box.block);
    } else {
        const int pitch[3] = {span, span, span};
        weft_brick_store_copy_box(p->bricks.store, min, box.size, pitch, &w->memo, box.at);
    }
    return box;
}

// Lanes of a vector, whatever the machine's.
enum { LANES = 8 };

// Widens a range by values; false: some are not fit.
static bool scan(const float *values, size_t count, float fit, float *low, float *high)
{
    float least[LANES], most[LANES];
    int32_t all[LANES];
    size_t i = 0;
    for (int l = 0; l < LANES; l++) {
        least[l] = *low;
        most[l] = *high;
        all[l] = -1;
    }
    for (; i + LANES <= count; i += LANES) {
        for (int l = 0; l < LANES; l++) {
            const float v = values[i + (size_t)l];
            least[l] = v < least[l] ? v : least[l];
            most[l] = v > most[l] ? v : most[l];
            all[l] &= v >= -fit && v <= fit ? -1 : 0;
        }
    }
    for (; i < count; i++) {
        least[0] = values[i] < least[0] ? values[i] : least[0];
        most[0] = values[i] > most[0] ? values[i] : most[0];
        all[0] &= values[i] >= -fit && values[i] <= fit ? -1 : 0;
    }
    for (int l = 0; l < LANES; l++) {
        *low = least[l] < *low ? least[l] : *low;
        *high = most[l] > *high ? most[l] : *high;
        all[0] &= all[l];
    }
    return all[0] != 0;
}

// Adds what was gathered to the range, and says whether all of it is fit.
static bool measure(struct worker *w, const struct box *box)
{
    const weft_points *p = w->job->points;
    const int span = p->span;
    float low = w->low, high = w->high;
    bool fit = true;
    if (box->size[0] == span && box->size[1] == span) {
        fit = scan(box->at, (size_t)(box->size[2] * span * span), p->largest_fit, &low, &high);
    } else {
        for (int z = 0; z < box->size[2]; z++)
            for (int y = 0; y < box->size[1]; y++)
                fit &= scan(box->at + (z * span + y) * span, (size_t)box->size[0], p->largest_fit,
                            &low, &high);
    }
    if (fit) {
        w->low = low;
        w->high = high;
    }
    return fit;
}

// Of what is not fit, what is finite counts.
static void measure_finite(struct worker *w, float voxel)
{
    if (!isfinite(voxel))
        return;
    w->low = voxel < w->low ? voxel : w->low;
    w->high = voxel > w->high ? voxel : w->high;
}

static void replace_unfit(struct worker *w, const struct box *box)
{
    const weft_points *p = w->job->points;
    for (int z = 0; z < box->size[2]; z++)
        for (int y = 0; y < box->size[1]; y++)
            for (int x = 0; x < box->size[0]; x++) {
                float *voxel = box->at + (z * p->span + y) * p->span + x;
                measure_finite(w, *voxel);
                *voxel = unfit(p, *voxel) ? 0.0f : *voxel;
            }
}

// Whether all that the taps of a cell's points may reach is one value; by bricks and tiles, so that
// it does not depend on where in the cell points are.
static bool is_constant(const struct worker *w, const struct weft_point_run *run, float *value)
{
    const weft_points *p = w->job->points;
    const struct weft_volume_info *volume = weft_volume_get_info(p->voxels);
    struct weft_point_run whole = *run;
    int32_t min[3], max[3];
    if (!p->info.kernel.unit_sum || volume->clamp_to_edge)
        return false;
    const float *values;
    const int32_t origin[3] = {run->cell[0] * WEFT_BRICK_SIZE, run->cell[1] * WEFT_BRICK_SIZE,
                               run->cell[2] * WEFT_BRICK_SIZE};
    if (weft_brick_store_find(p->bricks.places, origin, &values, value) != WEFT_BRICK_CONSTANT)
        return false;
    memset(whole.low, 0, sizeof whole.low);
    memset(whole.high, 7, sizeof whole.high);
    weft_point_run_box(p, &whole, min, max);
    return weft_brick_store_box_constant(p->bricks.places, min, max, value) && !unfit(p, *value);
}

static void fill(struct worker *w, size_t from, size_t to, float value)
{
    const weft_points *p = w->job->points;
    for (int o = 0; o < p->info.output_count; o++) {
        const int *n = p->info.output[o].along;
        const float own = n[0] + n[1] + n[2] ? 0.0f : value;
        for (size_t i = from; i < to; i++)
            put(w, o, weft_point_number(w->job->batch->sorted[i]), own);
    }
    measure_finite(w, value);
}

static void add_point(struct worker *w, const float *block, size_t number)
{
    const struct weft_point_place *place = &w->job->batch->place[number];
    w->number[w->count] = (uint32_t)number;
    w->start[w->count] = block;
    for (int a = 0; a < 3; a++)
        w->word[a][w->count] = place->word[a];
    w->count++;
}

// Points that reach voxels that are not fit are made while those are there; then others do not see
// them any more.
static void add_unfit(struct worker *w, const struct box *box, size_t from, size_t to)
{
    const struct weft_point_job *job = w->job;
    for (size_t i = from; i < to; i++) {
        const size_t number = weft_point_number(job->batch->sorted[i]);
        const float *first = first_tap(job->points, box->block, &job->batch->place[number]);
        w->exactly[i - from] = reaches_unfit(job->points, first);
        if (w->exactly[i - from])
            add_exactly(w, first, number);
    }
    replace_unfit(w, box);
}

// Ends a line whose last block goes on into the next.
static void go_on(struct worker *w)
{
    float *last = w->block[w->used - 1];
    w->block[w->used - 1] = w->block[0];
    w->block[0] = last;
    end_line(w);
    w->used = 1;
}

// The sorted points from `from` to `to`, exclusive, which are a run's.
static void add_run(struct worker *w, const struct weft_point_run *run, size_t from, size_t to)
{
    const struct weft_point_batch *s = w->job->batch;
    float value;
    if (is_constant(w, run, &value)) {
        fill(w, from, to, value);
        return;
    }
    if (w->used == BLOCKS)
        end_line(w);
    const struct box box = gather(w, run);
    const bool fit = measure(w, &box);
    if (!fit)
        add_unfit(w, &box, from, to);
    for (size_t i = from; i < to; i++) {
        if (!fit && w->exactly[i - from])
            continue;
        if (w->count == WEFT_LINE_PIXELS)
            go_on(w);
        if (i + AHEAD < s->good)
            __builtin_prefetch(&s->place[weft_point_number(s->sorted[i + AHEAD])]);
        add_point(w, box.block, weft_point_number(s->sorted[i]));
    }
}

// ---- parts --------------------------------------------------------------------------------------

// The last run of the job that begins at a sorted point or before it.
static size_t find_run(const struct weft_point_job *job, size_t sorted)
{
    size_t low = job->from, high = job->to;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (job->batch->run[middle].first <= sorted)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static bool add_part(void *priv, int thread, size_t i)
{
    struct sums *s = priv;
    struct worker *w = &s->workers[thread];
    size_t at = s->first + i * PART;
    const size_t end = at + PART < s->end ? at + PART : s->end;
    for (size_t r = find_run(s->job, at); at < end; r++) {
        const struct weft_point_run *run = &s->job->batch->run[r];
        const size_t last = (size_t)run->first + run->count;
        add_run(w, run, at, last < end ? last : end);
        at = last;
    }
    end_line(w);
    return true;
}

static void report_workers(const struct sums *s, int threads)
{
    struct weft_points_report *report = s->job->report;
    struct weft_bound_values *values = &report->values;
    for (int i = 0; i < threads; i++) {
        const struct worker *w = &s->workers[i];
        report->not_finite += w->not_finite;
        report->exact_points += w->exact;
        if (w->low > w->high)
            continue;
        values->low = fmin(values->low, (double)w->low);
        values->high = fmax(values->high, (double)w->high);
    }
}

static bool create_worker(struct worker *w, const struct weft_point_job *job)
{
    const size_t size = (size_t)(job->points->span * job->points->span * job->points->span);
    w->job = job;
    w->low = INFINITY;
    w->high = -INFINITY;
    w->memory = calloc(BLOCKS * size + WEFT_LINE_SAMPLES, sizeof *w->memory);
    for (size_t i = 0; w->memory && i < BLOCKS; i++)
        w->block[i] = w->memory + i * size;
    return w->memory != NULL;
}

enum weft_result weft_point_job_run(const struct weft_point_job *job)
{
    const struct weft_point_run *last = &job->batch->run[job->to - 1];
    struct sums s = {.job = job, .first = job->batch->run[job->from].first};
    s.end = (size_t)last->first + last->count;
    const size_t parts = (s.end - s.first + PART - 1) / PART;
    const int most = job->points->info.cpu.threads;
    const int threads = parts < (size_t)most ? (int)parts : most;
    bool enough = true;
    s.workers = calloc((size_t)threads, sizeof *s.workers);
    for (int i = 0; s.workers && enough && i < threads; i++)
        enough = create_worker(&s.workers[i], job);
    enough = enough && s.workers;
    if (enough) {
        weft_threads_run(threads, parts, add_part, &s);
        report_workers(&s, threads);
    } else {
        weft_error(job->points->log, "not enough memory for %d threads of points", threads);
    }
    for (int i = 0; s.workers && i < threads; i++)
        free(s.workers[i].memory);
    free(s.workers);
    return enough ? WEFT_OK : WEFT_ERR_MEMORY;
}
