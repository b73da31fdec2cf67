// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/job.h - what running passes on GL and on the CPU share (not installed).
// A job holds what both read: the mapped source, the tiles' values and an entry per pixel. Both so
// look at the same samples and weights; what is left to them is passes/plan/pass.h's arithmetic.
#ifndef WEFT_PASSES_MULTIPASS_JOB_H
#define WEFT_PASSES_MULTIPASS_JOB_H

#include "filter/check.h"
#include "passes/multipass/multipass.h"

// What of a plan is run; a list of passes made by hand does as well.
struct weft_multipass_work {
    const struct weft_pass_list *passes;
    struct weft_kernel kernel;
    int derivative; // as in struct weft_pass_plan_info
    int channels;   // 1 or 4
    bool portable;  // GL: no extensions (tests)
};

enum weft_value_type { WEFT_VALUE_UINT8, WEFT_VALUE_UINT16, WEFT_VALUE_FLOAT };

struct weft_job_values {
    enum weft_value_type type;
    int components; // of a texel: 1 or 4
    size_t texels;  // at least 1
    size_t bytes;
    void *data;
};

// How an entry tells the tile sample position k of every axis, and where a group's weight is then.
enum weft_job_positions {
    WEFT_JOB_PACKED, // in position_bits per axis, x first: at tile_base + sum over axes of
                     // tile_step k
    WEFT_JOB_LINEAR, // x + M (y + M z): at tile_base + that; no tile is mirrored
    WEFT_JOB_FLIPS,  // linear, M is a power of two: at tile_base + (that with the bits of tile_flip
                     // turned), as M - 1 - k has all of k's bits turned
};

struct weft_job_entry {
    uint32_t texel; // of the source, at the first tap
    uint32_t position;
};

struct weft_job_group {
    int32_t source_offset;                      // texels from the entry's
    int32_t tile_base, tile_flip, tile_step[3]; // steps are negative along mirrored axes
};

struct weft_job_limits {
    int64_t texels; // of one buffer
    int64_t target; // pixels along a side of the grid
};

struct weft_multipass_job {
    const struct weft_multipass_work *work;
    const struct weft_pass_list *passes;
    const struct weft_samples *samples;
    const struct weft_pixel_grid *grid;
    const struct weft_log *log;
    bool floats;      // half and float targets
    int one;          // T, 0 for floats
    int extra_bits;   // e
    int limit;        // sums inside stay within +-limit (2^-e codes); INT_MAX: they are not bounded
    double low, high; // the mapped range
    double width;     // high - low
    uint64_t clamped; // samples outside it
    int samples_per_unit; // M
    enum weft_job_positions positions;
    int position_bits;
    int reach[2][3];               // least and largest source offset of the groups
    size_t padded[3];              // texels of the source along the axes
    struct weft_job_values source; // dot4: component c of texel i is the sample at i + pattern[c]
    struct weft_job_values tiles;
    bool signed_tiles;             // floats with dot4: tiles have their groups' signs
    struct weft_job_group *groups; // of the list's
    size_t pixels;
    struct weft_job_entry *entries;
    uint8_t *not_finite; // of samples, a bit per channel; NULL: all are finite
};

static inline void weft_multipass_position(const struct weft_pixel_grid *grid, int x, int y,
                                           double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = grid->origin[a] + x * grid->du[a] + y * grid->dv[a];
    if (grid->columns)
        out[0] = grid->columns[x];
    if (grid->rows)
        out[1] = grid->rows[y];
    const double units = grid->fraction_bits ? ldexp(1.0, grid->fraction_bits) : 0.0;
    for (int a = 0; units > 0.0 && a < 3; a++)
        out[a] = floor(out[a] * units + 0.5) / units;
}

// The kernel of each axis: the derivative's along one, where the plan says so.
struct weft_axis_kernels {
    struct weft_kernel kernel[3];
    bool sums_are_one;
};
void weft_multipass_axis_kernels(const struct weft_multipass_work *work,
                                 struct weft_axis_kernels *out);

// The exact weights at a position, as weft_kernel_weights_nd gives them, derivatives' too.
int weft_multipass_weights(const struct weft_multipass_work *work,
                           const struct weft_axis_kernels *axes, const double position[3],
                           double *weights, int64_t first[3]);

// The sample that a tap reads: the nearest, beyond all.
static inline size_t weft_multipass_sample(const struct weft_samples *samples,
                                           const int64_t index[3])
{
    size_t at = 0;
    for (int a = 2; a >= 0; a--) {
        const int64_t last = samples->size[a] - 1;
        const int64_t i = index[a] < 0 ? 0 : index[a] > last ? last : index[a];
        at = at * (size_t)samples->size[a] + (size_t)i;
    }
    return at;
}

// The value at a position, in double: the reference's, or a derivative's.
double weft_multipass_refer(const struct weft_multipass_work *work,
                            const struct weft_axis_kernels *axes,
                            const struct weft_samples *samples, int channel,
                            const double position[3]);

// The request and the list by themselves, without limits. Returns WEFT_ERR_ARGUMENT or
// WEFT_ERR_LIMIT.
enum weft_result weft_multipass_work_check(const struct weft_multipass_work *work,
                                           const struct weft_multipass_params *params);

// What creating is made of: checks and numbers that need the request only, and once tiles are laid
// out, that no sum of a pass passes 32 bits (WEFT_ERR_LIMIT).
enum weft_result weft_multipass_job_start(const struct weft_multipass_work *work,
                                          const struct weft_multipass_params *params,
                                          struct weft_multipass_job *job);
enum weft_result weft_multipass_job_check_sums(const struct weft_multipass_job *job);

// Checks everything, so that running can trust the job. `params` must outlive it; its plan is not
// looked at. On failure there is nothing to destroy. Errors as of weft_multipass_run.
enum weft_result weft_multipass_job_create(const struct weft_multipass_work *work,
                                           const struct weft_multipass_params *params,
                                           const struct weft_job_limits *limits,
                                           struct weft_multipass_job *out);
void weft_multipass_job_destroy(struct weft_multipass_job *job); // {0} is fine

// The result's codes (uint8_t or uint16_t by the target) or floats, `channels` for every pixel, in
// the samples' own range. Fills the report's counts and sizes of what the job holds.
void weft_multipass_job_finish(const struct weft_multipass_job *job, const void *result,
                               float *const pixels[4], struct weft_multipass_report *report);

// Where positions lie far from the samples, all taps read the edge's value.
static inline int64_t weft_job_first_tap(const struct weft_multipass_job *job, int a, double x,
                                         double *fraction)
{
    const int64_t first = weft_kernel_first_tap(&job->work->kernel, x, fraction);
    const int64_t low = 1 - job->work->kernel.width, high = job->samples->size[a] - 1;
    return first < low ? low : first > high ? high : first;
}

static inline uint32_t weft_job_pack_position(const struct weft_multipass_job *job,
                                              const uint32_t k[3])
{
    const uint32_t m = (uint32_t)job->samples_per_unit;
    uint32_t position = 0;
    for (int a = job->passes->dims - 1; a >= 0; a--)
        position =
            (job->positions == WEFT_JOB_PACKED ? position << job->position_bits : position * m) +
            k[a];
    return position;
}

static inline size_t weft_job_tile_texel(const struct weft_multipass_job *job,
                                         const struct weft_job_group *group, uint32_t position)
{
    uint32_t at = (uint32_t)group->tile_base;
    if (job->positions != WEFT_JOB_PACKED)
        return at + (position ^ (uint32_t)group->tile_flip);
    const uint32_t mask = (UINT32_C(1) << job->position_bits) - 1;
    for (int a = 0; a < job->passes->dims; a++, position >>= job->position_bits)
        at += (position & mask) * (uint32_t)group->tile_step[a];
    return at;
}

// What a pass multiplies s q of a group's component by: its sign, turned where the pass subtracts,
// times 2^(shift + e).
static inline int weft_multipass_job_factor(const struct weft_multipass_job *job,
                                            const struct weft_pass *pass,
                                            const struct weft_tap_group *group, int component)
{
    const int sign = group->tile[component] < 0 ? 0
                     : job->signed_tiles        ? 1
                                                : group->sign[component];
    const int scale = 1 << (job->passes->log_table ? 0 : group->shift[component] + job->extra_bits);
    return (pass->subtract ? -sign : sign) * scale;
}
// The same of floats, exact for divisors that are powers of two.
static inline float weft_multipass_job_weight(const struct weft_pass *pass, int factor)
{
    return (float)((double)factor / pass->divisor);
}

// Of a combining pass: what an input's code is multiplied by, and what the sum starts from, half a
// denominator included. Where products are rounded inside, both are on the way to 2^-e codes.
static inline int weft_multipass_job_numerator(const struct weft_multipass_job *job,
                                               const struct weft_pass *pass, int input)
{
    return pass->numerator[input] * (job->passes->exact_inside ? 1 : 1 << job->extra_bits);
}
int weft_multipass_job_bias(const struct weft_multipass_job *job, const struct weft_pass *pass);

// To the nearest, halves away from zero.
static inline int32_t weft_divide_nearest(int32_t x, int32_t divisor)
{
    const uint32_t magnitude = x < 0 ? 0u - (uint32_t)x : (uint32_t)x;
    const int32_t result = (int32_t)((magnitude + (uint32_t)divisor / 2) / (uint32_t)divisor);
    return x < 0 ? -result : result;
}

static inline bool weft_job_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

// Halves: 11 significant bits, steps of 2^-24 below 2^-14. Toward zero, as llvmpipe stores them.
float weft_half_truncate(float x);

// What the calls of passes/multipass/multipass.h do once they have unwrapped the plan.
enum weft_result weft_multipass_plan_work(const struct weft_multipass_params *params,
                                          struct weft_multipass_work *out);
enum weft_result weft_multipass_run_work(weft_context *context,
                                         const struct weft_multipass_work *work,
                                         const struct weft_multipass_params *params,
                                         struct weft_multipass_report *report);
enum weft_result weft_multipass_emulate_work(const struct weft_multipass_work *work,
                                             const struct weft_multipass_params *params,
                                             struct weft_multipass_report *report);
enum weft_result weft_multipass_verify_work(const struct weft_multipass_work *work,
                                            const struct weft_multipass_params *params,
                                            struct weft_multipass_error *out);

#endif
