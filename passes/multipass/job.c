// SPDX-License-Identifier: BSD-3-Clause
#include "filter/statistics.h"
#include "filter/threads.h"
#include "passes/multipass/job.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- halves -------------------------------------------------------------------------------------

static uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

float weft_half_truncate(float x)
{
    const uint32_t bits = float_bits(x), magnitude = bits & 0x7fffffff;
    const uint32_t exponent = magnitude >> 23;
    if (exponent >= 0x8f) // from 65536 on; infinities and NANs stay
        return exponent == 0xff ? x : copysignf(65504.0f, x);
    // 2^-14 has exponent 113, and each binade below it one bit less.
    const uint32_t lost = exponent >= 113 ? 13 : 126 - exponent;
    const uint32_t kept = bits & (lost > 23 ? 0x80000000 : ~((UINT32_C(1) << lost) - 1));
    memcpy(&x, &kept, sizeof x);
    return x;
}

// To the nearest half, ties to even; of numbers in [0, 1]. What is added has the last place of the
// half's eleventh bit.
static inline double half_nearest(double x)
{
    const double least = x > 0x1p-14 ? x : 0x1p-14;
    uint64_t bits;
    memcpy(&bits, &least, sizeof bits);
    bits = (bits & UINT64_C(0x7ff0000000000000)) + (UINT64_C(42) << 52) + (UINT64_C(1) << 51);
    double shift;
    memcpy(&shift, &bits, sizeof shift);
    return (x + shift) - shift;
}

// ---- the source's range and layout --------------------------------------------------------------

static size_t sample_count(const struct weft_sample_box *box)
{
    return (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
}

static void find_range(const struct weft_multipass_job *job, double *low, double *high)
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    for (size_t b = 0; b < job->boxes.count; b++)
        for (int c = 0; c < job->compiled->work.channels; c++)
            weft_statistics_add(&s, job->boxes.box[b].plane[c], sample_count(&job->boxes.box[b]));
    *low = isnan(s.minimum) ? 0.0 : s.minimum;
    *high = isnan(s.maximum) ? 0.0 : s.maximum;
}

static enum weft_result set_range(struct weft_multipass_job *job)
{
    const struct weft_sample_boxes *s = &job->boxes;
    double low = 0.0, high = 0.0;
    const bool low_open = weft_range_is_open(s->low, s->low, s->high);
    const bool high_open = weft_range_is_open(s->high, s->low, s->high);
    if (low_open || high_open)
        find_range(job, &low, &high);
    low = low_open ? low : s->low;
    high = high_open ? high : s->high;
    // One was declared beyond all samples.
    if (low_open && low > high)
        low = high;
    if (high_open && high < low)
        high = low;
    job->low = low;
    job->high = high;
    job->width = high - low;
    if (job->compiled->passes->log_table && low < 0.0) {
        weft_error(job->log, "convolution: logarithms need a range from 0 on, not from %g", low);
        return WEFT_ERR_UNSUPPORTED;
    }
    return WEFT_OK;
}

// ---- the source's layout ------------------------------------------------------------------------

// A box's texels along an axis: from the least first tap and offset on.
static size_t padded(const struct weft_multipass_job *job, const struct weft_sample_box *box, int a)
{
    return weft_job_tap_count(job, box, a) +
           (size_t)(job->compiled->reach[1][a] - job->compiled->reach[0][a]);
}

// The texels from a box's first to its last one.
static size_t box_texels(const struct weft_multipass_job *job, const struct weft_sample_box *box)
{
    const size_t rows = (padded(job, box, 2) - 1) * job->pitch[1] + padded(job, box, 1) - 1;
    return rows * job->pitch[0] + padded(job, box, 0);
}

static enum weft_result size_source(struct weft_multipass_job *job)
{
    const int64_t limit = job->compiled->limits.texels;
    const size_t count = job->boxes.count;
    job->base = malloc((count + 1) * sizeof *job->base);
    if (!job->base) {
        weft_error(job->log, "convolution: not enough memory for %zu boxes", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t b = 0; b < count; b++)
        for (int a = 0; a < 2; a++) {
            const size_t texels = padded(job, &job->boxes.box[b], a);
            job->pitch[a] = texels > job->pitch[a] ? texels : job->pitch[a];
        }
    double texels = 0.0;
    job->base[0] = 0;
    for (size_t b = 0; b < count; b++) {
        texels += (double)padded(job, &job->boxes.box[b], 2) * (double)job->pitch[1] *
                  (double)job->pitch[0];
        job->base[b + 1] = job->base[b] + box_texels(job, &job->boxes.box[b]);
    }
    // Also keeps offsets within 32 bits.
    const enum weft_result res =
        weft_job_check_texels(job->log, "source", texels, limit < INT32_MAX ? limit : INT32_MAX);
    return res;
}

static double mapped(const struct weft_multipass_job *job, double inside)
{
    if (job->compiled->passes->log_table)
        return weft_job_log_code(job->compiled, inside);
    if (!job->compiled->floats)
        return floor(inside * job->compiled->one + 0.5);
    return job->compiled->passes->target == WEFT_TARGET_HALF ? half_nearest(inside) : inside;
}

// A sample in [0, 1]; a NAN is 0.
static inline double inside_range(float sample, double low, double width)
{
    const double x = ((double)sample - low) / width;
    const double positive = x > 0.0 ? x : 0.0;
    return positive < 1.0 ? positive : 1.0;
}

// Loops of one kind each, for vectors.
static void map_codes(const float *in, size_t count, double low, double width, int one,
                      int32_t *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (int32_t)(inside_range(in[i], low, width) * one + 0.5);
}

static void map_floats(const float *in, size_t count, double low, double width, float *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (float)inside_range(in[i], low, width);
}

static void map_halves(const float *in, size_t count, double low, double width, float *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (float)half_nearest(inside_range(in[i], low, width));
}

// Samples that are out of range or not finite, and of those the latter.
struct outsiders {
    uint64_t clamped, not_finite;
};

static void count_outsiders(const float *in, size_t count, double low, double high,
                            struct outsiders *sum)
{
    uint32_t clamped = 0, not_finite = 0;
    const struct weft_float_range range = weft_float_range(low, high);
    for (size_t i = 0; i < count; i++)
        clamped += !((in[i] >= range.least) & (in[i] <= range.most));
    for (size_t i = 0; clamped && i < count; i++)
        not_finite += !isfinite(in[i]);
    sum->clamped += clamped;
    sum->not_finite += not_finite;
}

enum { MAP_CHUNK = 4096 };

// What samples are in the source, in the type that it has.
static void map_samples(const struct weft_multipass_job *job, const float *in, size_t count,
                        void *out, struct outsiders *sum)
{
    const struct weft_multipass *m = job->compiled;
    const bool halves = m->passes->target == WEFT_TARGET_HALF;
    int32_t codes[MAP_CHUNK];
    count_outsiders(in, count, job->low, job->high, sum);
    const struct weft_job_values values = {.type = job->source.type, .data = out};
    if (!(job->width > 0.0) || m->passes->log_table) {
        for (size_t i = 0; i < count; i++)
            weft_job_put(
                &values, i,
                mapped(job, job->width > 0.0 ? inside_range(in[i], job->low, job->width) : 0.0));
        return;
    }
    if (m->floats) {
        (halves ? map_halves : map_floats)(in, count, job->low, job->width, out);
        return;
    }
    map_codes(in, count, job->low, job->width, m->one, codes);
    for (size_t i = 0; values.type == WEFT_VALUE_UINT8 && i < count; i++)
        ((uint8_t *)out)[i] = (uint8_t)codes[i];
    for (size_t i = 0; values.type == WEFT_VALUE_UINT16 && i < count; i++)
        ((uint16_t *)out)[i] = (uint16_t)codes[i];
}

static void map_plane(const struct weft_multipass_job *job, const float *samples, size_t count,
                      char *out, struct outsiders *sum)
{
    for (size_t i = 0; i < count; i += MAP_CHUNK)
        map_samples(job, samples + i, count - i < MAP_CHUNK ? count - i : MAP_CHUNK,
                    out + i * weft_value_bytes(job->source.type), sum);
}

static int64_t nearest(int64_t i, int size)
{
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

static void put_row(const char *in, size_t bytes, size_t step, size_t count, char *out)
{
    for (size_t i = 0; bytes == 1 && i < count; i++)
        out[i * step] = in[i];
    for (size_t i = 0; bytes == 2 && i < count; i++)
        memcpy(out + 2 * i * step, in + 2 * i, 2);
    for (size_t i = 0; bytes == 4 && i < count; i++)
        memcpy(out + 4 * i * step, in + 4 * i, 4);
}

// A row of texels whose first sample is number `first` of `size`: beyond the ends the last one
// holds.
static void lay_out_row(const char *in, size_t bytes, int64_t first, int size, size_t step,
                        size_t count, char *out)
{
    const size_t before = first < 0 ? (size_t)-first : 0;
    const size_t head = before < count ? before : count;
    const int64_t left = size - (first + (int64_t)head);
    const size_t body = left <= 0 ? 0 : (size_t)left < count - head ? (size_t)left : count - head;
    for (size_t i = 0; i < head; i++)
        memcpy(out + i * step * bytes, in, bytes);
    if (step == 1)
        memcpy(out + head * bytes, in + (first + (int64_t)head) * (int64_t)bytes, body * bytes);
    else
        put_row(in + (first + (int64_t)head) * (int64_t)bytes, bytes, step, body,
                out + head * step * bytes);
    for (size_t i = head + body; i < count; i++)
        memcpy(out + i * step * bytes, in + (size_t)(size - 1) * bytes, bytes);
}

// Component c of a box's texels, from its samples as they are mapped.
static void lay_out(const struct weft_multipass_job *job, size_t number, const char *plane, int c,
                    const int shift[3])
{
    const struct weft_sample_box *box = &job->boxes.box[number];
    const size_t step = (size_t)job->source.components;
    const size_t bytes = weft_value_bytes(job->source.type);
    char *out = (char *)job->source.data + (job->base[number] * step + (size_t)c) * bytes;
    int64_t first[3];
    for (int a = 0; a < 3; a++)
        first[a] = weft_job_least_tap(job, a) + job->compiled->reach[0][a] + shift[a];
    for (size_t z = 0; z < padded(job, box, 2); z++) {
        for (size_t y = 0; y < padded(job, box, 1); y++) {
            const int64_t row = nearest(first[2] + (int64_t)z, box->size[2]) * box->size[1] +
                                nearest(first[1] + (int64_t)y, box->size[1]);
            lay_out_row(plane + (size_t)(row * box->size[0]) * bytes, bytes, first[0], box->size[0],
                        step, padded(job, box, 0),
                        out + (z * job->pitch[1] + y) * job->pitch[0] * step * bytes);
        }
    }
}

// Boxes that a part of the work has, and what each thread has for it.
enum { PART_BOXES = 64 };
struct layers {
    struct weft_multipass_job *job;
    char **planes;               // of each thread: the mapped samples of the largest box
    struct outsiders *outsiders; // of each thread
};

static void lay_out_box(const struct layers *l, int thread, size_t number)
{
    const struct weft_multipass_job *job = l->job;
    const struct weft_pass_list *passes = job->compiled->passes;
    const struct weft_sample_box *box = &job->boxes.box[number];
    for (int c = 0; c < job->source.components; c++) {
        if (c < job->compiled->work.channels)
            map_plane(job, box->plane[c], sample_count(box), l->planes[thread],
                      &l->outsiders[thread]);
        lay_out(job, number, l->planes[thread], c,
                passes->dot4 ? passes->pattern[c] : (const int[3]){0});
    }
}

static bool lay_out_part(void *priv, int thread, size_t part)
{
    const struct layers *l = priv;
    const size_t end = (part + 1) * PART_BOXES, count = l->job->boxes.count;
    for (size_t b = part * PART_BOXES; b < end && b < count; b++)
        lay_out_box(l, thread, b);
    return true;
}

static size_t largest_box(const struct weft_multipass_job *job)
{
    size_t largest = 0;
    for (size_t b = 0; b < job->boxes.count; b++) {
        const size_t count = sample_count(&job->boxes.box[b]);
        largest = count > largest ? count : largest;
    }
    return largest;
}

static enum weft_result lay_out_boxes(struct weft_multipass_job *job)
{
    const size_t parts = (job->boxes.count + PART_BOXES - 1) / PART_BOXES;
    const int threads =
        (size_t)job->compiled->threads < parts ? job->compiled->threads : (int)parts;
    const size_t bytes = largest_box(job) * weft_value_bytes(job->source.type);
    struct layers l = {.job = job,
                       .planes = calloc((size_t)threads, sizeof *l.planes),
                       .outsiders = calloc((size_t)threads, sizeof *l.outsiders)};
    bool whole = l.planes && l.outsiders;
    for (int t = 0; whole && t < threads; t++)
        whole = (l.planes[t] = malloc(bytes)) != NULL;
    if (whole)
        weft_threads_run(threads, parts, lay_out_part, &l);
    for (int t = 0; t < threads && l.planes; t++) {
        job->clamped += whole ? l.outsiders[t].clamped : 0;
        job->not_finite += whole ? l.outsiders[t].not_finite : 0;
        free(l.planes[t]);
    }
    free(l.planes);
    free(l.outsiders);
    if (whole)
        return WEFT_OK;
    weft_error(job->log, "convolution: not enough memory for %d times %zu bytes of mapped samples",
               threads, bytes);
    return WEFT_ERR_MEMORY;
}

static enum weft_result create_source(struct weft_multipass *m, struct weft_multipass_job *job)
{
    enum weft_result res = size_source(job);
    if (res != WEFT_OK)
        return res;
    m->source.type = m->floats        ? WEFT_VALUE_FLOAT
                     : m->one <= 0xff ? WEFT_VALUE_UINT8
                                      : WEFT_VALUE_UINT16;
    m->source.components = m->passes->dot4 ? 4 : m->work.channels;
    m->source.texels = job->base[job->boxes.count];
    res = weft_job_values_fit(job->log, "source", &m->source);
    job->source = m->source;
    return res == WEFT_OK ? lay_out_boxes(job) : res;
}

// ---- pixels -------------------------------------------------------------------------------------

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static void make_entry(const struct weft_multipass_job *job, int x, int y,
                       struct weft_job_entry *out)
{
    const int m = job->compiled->samples_per_unit;
    const size_t number = weft_job_box(job, (size_t)y * (size_t)job->grid->width + (size_t)x);
    const struct weft_sample_box *box = &job->boxes.box[number];
    const size_t pitch[3] = {job->pitch[0], job->pitch[1], 1};
    uint32_t k[3] = {0};
    double at[3];
    weft_job_position(job, box, x, y, at);
    size_t texel = 0;
    for (int a = job->compiled->passes->dims - 1; a >= 0; a--) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, box, a, at[a], &fraction);
        k[a] = (uint32_t)smaller(m - 1, (int)(fraction * m));
        // A group's offset is counted from here, so the least is in front.
        texel = texel * pitch[a] +
                (size_t)(first - weft_job_least_tap(job, a) - job->compiled->reach[0][a]);
    }
    *out = (struct weft_job_entry){(uint32_t)(job->base[number] + texel),
                                   weft_job_pack_position(job->compiled, k)};
}

enum { PART_ROWS = 16 };

static bool make_rows(void *priv, int thread, size_t part)
{
    struct weft_multipass_job *job = priv;
    const struct weft_pixel_grid *g = job->grid;
    const int end = smaller(g->height, ((int)part + 1) * PART_ROWS);
    (void)thread;
    for (int y = (int)part * PART_ROWS; y < end; y++)
        for (int x = 0; x < g->width; x++)
            make_entry(job, x, y, &job->own_entries[(size_t)y * (size_t)g->width + (size_t)x]);
    return true;
}

static enum weft_result make_entries(struct weft_multipass_job *job)
{
    struct weft_box_entries *kept = job->boxes.kept;
    const size_t parts = (size_t)((job->grid->height + PART_ROWS - 1) / PART_ROWS);
    job->entries = job->own_entries = malloc(job->pixels * sizeof *job->own_entries);
    if (!job->entries) {
        weft_error(job->log, "convolution: not enough memory for %zu pixels", job->pixels);
        return WEFT_ERR_MEMORY;
    }
    weft_threads_run(job->compiled->threads, parts, make_rows, job);
    if (kept) {
        kept->entry = job->own_entries;
        job->own_entries = NULL;
    }
    return WEFT_OK;
}

static enum weft_result create_entries(struct weft_multipass_job *job)
{
    const struct weft_job_limits *limits = &job->compiled->limits;
    const struct weft_pixel_grid *g = job->grid;
    if (g->width > limits->target || g->height > limits->target) {
        weft_error(job->log, "convolution: %d x %d pixels, over the limit of %lld along a side",
                   g->width, g->height, (long long)limits->target);
        return WEFT_ERR_LIMIT;
    }
    const enum weft_result res = weft_job_check_texels(
        job->log, "grid", (double)g->width * (double)g->height, limits->texels);
    if (res != WEFT_OK)
        return res;
    job->pixels = (size_t)g->width * (size_t)g->height;
    if (job->boxes.kept && job->boxes.kept->entry) {
        job->entries = job->boxes.kept->entry;
        return WEFT_OK;
    }
    return make_entries(job);
}

void weft_box_entries_destroy(struct weft_box_entries *entries)
{
    free(entries->entry);
    *entries = (struct weft_box_entries){.entry = NULL};
}

// ---- creation -----------------------------------------------------------------------------------

static enum weft_result find_offsets(struct weft_multipass_job *job)
{
    const struct weft_pass_list *l = job->compiled->passes;
    job->source_offset = calloc((size_t)l->group_count + 1, sizeof *job->source_offset);
    if (!job->source_offset) {
        weft_error(job->log, "convolution: not enough memory for %d groups", l->group_count);
        return WEFT_ERR_MEMORY;
    }
    const int row = (int)job->pitch[0], slice = row * (int)job->pitch[1];
    for (int g = 0; g < l->group_count; g++) {
        const int *offset = l->groups[g].offset;
        job->source_offset[g] = offset[0] + offset[1] * row + offset[2] * slice;
    }
    return WEFT_OK;
}

// The whole of the params' samples is one box.
static void take_samples(struct weft_multipass_job *job)
{
    const struct weft_samples *s = job->params->samples;
    memcpy(job->whole.size, s->size, sizeof job->whole.size);
    memcpy(job->whole.plane, s->plane, sizeof job->whole.plane);
    job->boxes =
        (struct weft_sample_boxes){.count = 1, .box = &job->whole, .low = s->low, .high = s->high};
}

enum weft_result weft_multipass_job_create(struct weft_multipass *compiled,
                                           const struct weft_multipass_run_params *params,
                                           const struct weft_sample_boxes *boxes,
                                           struct weft_multipass_job *job)
{
    const struct weft_multipass_request request = {
        .samples = params->samples,
        .grid = params->grid,
        .pixels = {params->pixels[0], params->pixels[1], params->pixels[2], params->pixels[3]},
        .stride = params->stride,
    };
    enum weft_result res = WEFT_OK;
    *job = (struct weft_multipass_job){
        .compiled = compiled,
        .params = params,
        .grid = params->grid,
        .log = params->log,
    };
    if (boxes) {
        job->boxes = *boxes;
    } else {
        res = weft_multipass_check_request(params->log, &compiled->work, &request);
        if (res == WEFT_OK)
            take_samples(job);
    }
    if (res == WEFT_OK)
        res = set_range(job);
    if (res == WEFT_OK)
        res = create_source(compiled, job);
    if (res == WEFT_OK)
        res = find_offsets(job);
    if (res == WEFT_OK)
        res = create_entries(job);
    if (res != WEFT_OK)
        weft_multipass_job_destroy(job);
    return res;
}

void weft_multipass_job_destroy(struct weft_multipass_job *job)
{
    free(job->base);
    free(job->source_offset);
    free(job->own_entries);
    *job = (struct weft_multipass_job){0};
}
