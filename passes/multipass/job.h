// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/job.h - one run of a compiled plan (not installed): the mapped source and an
// entry per pixel, which GL and the CPU both read.
#ifndef WEFT_PASSES_MULTIPASS_JOB_H
#define WEFT_PASSES_MULTIPASS_JOB_H

#include "passes/multipass/boxes.h"
#include "passes/multipass/compiled.h"

struct weft_job_entry {
    uint32_t texel; // of the source, at the first tap
    uint32_t position;
};

struct weft_multipass_job {
    const struct weft_multipass *compiled;
    const struct weft_multipass_run_params *params;
    struct weft_sample_boxes boxes;
    struct weft_sample_box whole; // the params' samples, where those are all
    const struct weft_pixel_grid *grid;
    const struct weft_log *log;
    double low, high;    // the mapped range
    double width;        // high - low
    uint64_t clamped;    // samples outside it
    uint64_t not_finite; // samples of those
    // The source: each box's texels from its base on, in rows and slices of the largest one's size.
    size_t *base;
    size_t pitch[2]; // texels from row to row, and rows from slice to slice
    // The compiled plan's memory; dot4: component c of texel i is the sample at i + pattern[c].
    // Between boxes' rows there is whatever codes were before.
    struct weft_job_values source;
    int32_t *source_offset; // of the list's groups: texels from the entry's
    size_t pixels;
    const struct weft_job_entry *entries; // the boxes' kept ones, or own_entries
    struct weft_job_entry *own_entries;
};

// Checks everything, so that running can trust the job. `params` must outlive it, and so must
// `boxes`, NULL for the params' samples; out stays where it is. On failure there is nothing to
// destroy. Errors as of weft_multipass_run.
enum weft_result weft_multipass_job_create(struct weft_multipass *compiled,
                                           const struct weft_multipass_run_params *params,
                                           const struct weft_sample_boxes *boxes,
                                           struct weft_multipass_job *out);
void weft_multipass_job_destroy(struct weft_multipass_job *job); // {0} is fine

// The result's codes (uint8_t or uint16_t by the target) or floats, `channels` for every pixel, to
// the params' pixels in the samples' own range. Fills the report's counts.
void weft_multipass_job_finish(const struct weft_multipass_job *job, const void *result,
                               struct weft_multipass_report *report);

// The box that a pixel reads.
static inline size_t weft_job_box(const struct weft_multipass_job *job, size_t pixel)
{
    return job->boxes.of_pixel ? job->boxes.of_pixel[pixel] : 0;
}

// The first tap that lies farthest in front of a box's first sample.
static inline int64_t weft_job_least_tap(const struct weft_multipass_job *job, int a)
{
    const bool edge = !job->boxes.of_pixel && a < job->compiled->passes->dims;
    return edge ? 1 - job->compiled->work.kernel.width : 0;
}

// How many first taps a box has along an axis.
static inline size_t weft_job_tap_count(const struct weft_multipass_job *job,
                                        const struct weft_sample_box *box, int a)
{
    const int more = a < job->compiled->passes->dims ? job->compiled->work.kernel.width - 1 : 0;
    const int count = box->size[a] + (job->boxes.of_pixel ? -more : more);
    return count > 1 ? (size_t)count : 1;
}

// The first tap of a position, both counted from the box's first sample. Where positions lie far
// from the samples, all taps read the edge's value.
static inline int64_t weft_job_first_tap(const struct weft_multipass_job *job,
                                         const struct weft_sample_box *box, int a, double x,
                                         double *fraction)
{
    const int64_t first = weft_kernel_first_tap(&job->compiled->work.kernel, x, fraction);
    const int64_t low = weft_job_least_tap(job, a);
    const int64_t high = low + (int64_t)weft_job_tap_count(job, box, a) - 1;
    return first < low ? low : first > high ? high : first;
}

// A pixel's position from its box's first sample; exact.
static inline void weft_job_position(const struct weft_multipass_job *job,
                                     const struct weft_sample_box *box, int x, int y, double out[3])
{
    weft_multipass_position(job->grid, x, y, out);
    for (int a = 0; a < 3; a++)
        out[a] -= box->min[a];
}

// The two ways to run a job. Both fill pixels and report. On the CPU half targets are rounded
// toward zero, as llvmpipe stores them.
enum weft_result weft_multipass_gl_run(const struct weft_multipass_job *job,
                                       struct weft_multipass_report *report);
enum weft_result weft_multipass_cpu_run(const struct weft_multipass_job *job,
                                        struct weft_multipass_report *report);

// To the nearest, halves away from zero.
static inline int32_t weft_divide_nearest(int32_t x, int32_t divisor)
{
    const uint32_t magnitude = x < 0 ? 0u - (uint32_t)x : (uint32_t)x;
    const int32_t result = (int32_t)((magnitude + (uint32_t)divisor / 2) / (uint32_t)divisor);
    return x < 0 ? -result : result;
}

// Halves: 11 significant bits, steps of 2^-24 below 2^-14. Toward zero, as llvmpipe stores them.
float weft_half_truncate(float x);

#endif
