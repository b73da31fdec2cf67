// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/compiled.h - a plan of passes made ready to run (not installed).
// It holds what neither samples nor positions change: the tiles' values and where each group finds
// its own, and on GL their buffer and the passes' programs. GL and the CPU look at the same values;
// what is left to each is passes/plan/pass.h's arithmetic.
#ifndef WEFT_PASSES_MULTIPASS_COMPILED_H
#define WEFT_PASSES_MULTIPASS_COMPILED_H

#include "filter/check.h"
#include "passes/multipass/reference.h"

enum weft_value_type { WEFT_VALUE_UINT8, WEFT_VALUE_UINT16, WEFT_VALUE_FLOAT };

// A buffer's content. {0} is none.
struct weft_job_values {
    enum weft_value_type type;
    int components; // of a texel: 1 or 4
    size_t texels;  // at least 1
    size_t bytes;
    void *data;
    size_t room; // bytes of data
};

static inline size_t weft_value_bytes(enum weft_value_type type)
{
    static const size_t bytes[] = {
        [WEFT_VALUE_UINT8] = 1, [WEFT_VALUE_UINT16] = 2, [WEFT_VALUE_FLOAT] = 4};
    return bytes[type];
}

static inline void weft_job_put(const struct weft_job_values *values, size_t i, double value)
{
    switch (values->type) {
    case WEFT_VALUE_UINT8:
        ((uint8_t *)values->data)[i] = (uint8_t)value;
        return;
    case WEFT_VALUE_UINT16:
        ((uint16_t *)values->data)[i] = (uint16_t)value;
        return;
    case WEFT_VALUE_FLOAT:
        break;
    }
    ((float *)values->data)[i] = (float)value;
}

// How an entry tells the tile sample position k of every axis, and where a group's weight is then.
enum weft_job_positions {
    WEFT_JOB_PACKED, // in position_bits per axis, x first: at tile_base + sum over axes of
                     // tile_step k
    WEFT_JOB_LINEAR, // x + M (y + M z): at tile_base + that; no tile is mirrored
    WEFT_JOB_FLIPS,  // linear, M is a power of two: at tile_base + (that with the bits of tile_flip
                     // turned), as M - 1 - k has all of k's bits turned
};

struct weft_job_group {
    int32_t tile_base, tile_flip, tile_step[3]; // steps are negative along mirrored axes
};

struct weft_job_limits {
    int64_t texels; // of one buffer
    int64_t target; // pixels along a side of the grid
};

struct weft_multipass_gl;

struct weft_multipass {
    const struct weft_log *log; // of compiling
    struct weft_multipass_work work;
    const struct weft_pass_list *passes; // the work's
    int threads;
    struct weft_axis_kernels axes;
    struct weft_job_limits limits;
    bool floats;          // half and float targets
    int one;              // T, 0 for floats
    int extra_bits;       // e
    int limit;            // sums inside stay within +-limit (2^-e codes); INT_MAX: not bounded
    int samples_per_unit; // M
    enum weft_job_positions positions;
    int position_bits;
    int reach[2][3];               // least and largest source offset of the groups
    struct weft_job_values tiles;  // without data once GL has it
    bool signed_tiles;             // floats with dot4: tiles have their groups' signs
    struct weft_job_group *groups; // of the list's
    struct weft_multipass_gl *gl;  // NULL: on the CPU
    struct weft_job_values source; // of the last run, whose memory is there for the next one
    struct weft_multipass_info info;
};

// The list by itself: work, tiles, groups and passes fit each other. Returns WEFT_ERR_ARGUMENT, or
// WEFT_ERR_LIMIT (samples per unit).
enum weft_result weft_multipass_check_list(const struct weft_log *log,
                                           const struct weft_multipass_work *work);
// Samples and grid by themselves, and that there are pixels. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_multipass_check_request(const struct weft_log *log,
                                              const struct weft_multipass_work *work,
                                              const struct weft_multipass_request *request);
// That no sum of a pass passes 32 bits, once tiles are laid out. Returns WEFT_ERR_LIMIT.
enum weft_result weft_multipass_check_sums(const struct weft_multipass *compiled);

// Lays the tiles out, and notes where each group finds its weights. Returns WEFT_ERR_LIMIT (texels
// and the limit in the log) or WEFT_ERR_MEMORY.
enum weft_result weft_multipass_create_tiles(struct weft_multipass *compiled);

// What weft_multipass_compile does once it has unwrapped the plan. The work's list is borrowed.
enum weft_result weft_multipass_compile_work(weft_context *context,
                                             const struct weft_multipass_work *work,
                                             const struct weft_log *log, weft_multipass **out);

// Makes sure of memory for values->type, components and texels: the one that is there where it is
// enough, else zeros. Returns WEFT_ERR_MEMORY, naming `what`; there is none then.
enum weft_result weft_job_values_fit(const struct weft_log *log, const char *what,
                                     struct weft_job_values *values);
// Returns WEFT_ERR_LIMIT, with `what` and both numbers in the log.
enum weft_result weft_job_check_texels(const struct weft_log *log, const char *what, double texels,
                                       int64_t limit);
// The code of a logarithm of x in [0, 1], passes/plan/pass.h.
double weft_job_log_code(const struct weft_multipass *compiled, double x);

static inline uint32_t weft_job_pack_position(const struct weft_multipass *m, const uint32_t k[3])
{
    const uint32_t per_unit = (uint32_t)m->samples_per_unit;
    uint32_t position = 0;
    for (int a = m->passes->dims - 1; a >= 0; a--)
        position =
            (m->positions == WEFT_JOB_PACKED ? position << m->position_bits : position * per_unit) +
            k[a];
    return position;
}

static inline size_t weft_job_tile_texel(const struct weft_multipass *m,
                                         const struct weft_job_group *group, uint32_t position)
{
    uint32_t at = (uint32_t)group->tile_base;
    if (m->positions != WEFT_JOB_PACKED)
        return at + (position ^ (uint32_t)group->tile_flip);
    const uint32_t mask = (UINT32_C(1) << m->position_bits) - 1;
    for (int a = 0; a < m->passes->dims; a++, position >>= m->position_bits)
        at += (position & mask) * (uint32_t)group->tile_step[a];
    return at;
}

// What a pass multiplies s q of a group's component by: its sign, turned where the pass subtracts,
// times 2^(shift + e).
static inline int weft_multipass_factor(const struct weft_multipass *m,
                                        const struct weft_pass *pass,
                                        const struct weft_tap_group *group, int component)
{
    const int sign = group->tile[component] < 0 ? 0 : m->signed_tiles ? 1 : group->sign[component];
    const int scale = 1 << (m->passes->log_table ? 0 : group->shift[component] + m->extra_bits);
    return (pass->subtract ? -sign : sign) * scale;
}
// The same of floats, exact for divisors that are powers of two.
static inline float weft_multipass_weight(const struct weft_pass *pass, int factor)
{
    return (float)((double)factor / pass->divisor);
}

// Of a combining pass: what an input's code is multiplied by, and what the sum starts from, half a
// denominator included. Where products are rounded inside, both are on the way to 2^-e codes.
static inline int weft_multipass_numerator(const struct weft_multipass *m,
                                           const struct weft_pass *pass, int input)
{
    return pass->numerator[input] * (m->passes->exact_inside ? 1 : 1 << m->extra_bits);
}
int weft_multipass_bias(const struct weft_multipass *m, const struct weft_pass *pass);

#endif
