// SPDX-License-Identifier: BSD-3-Clause
// The tiles' values as runs read them, and what else they are told in buffers.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/multipass/compiled.h"

enum weft_result weft_job_check_texels(const struct weft_log *log, const char *what, double texels,
                                       int64_t limit)
{
    if (texels <= (double)limit)
        return WEFT_OK;
    weft_error(log, "convolution: the %s takes %.0f texels, over the limit of %lld", what, texels,
               (long long)limit);
    return WEFT_ERR_LIMIT;
}

enum weft_result weft_job_values_fit(const struct weft_log *log, const char *what,
                                     struct weft_job_values *values)
{
    const size_t texel = (size_t)values->components * weft_value_bytes(values->type);
    const bool fits = weft_size_mul(values->texels, texel, &values->bytes);
    if (!fits || values->bytes > values->room) {
        free(values->data);
        values->data = fits ? calloc(1, values->bytes) : NULL;
        values->room = values->data ? values->bytes : 0;
    }
    if (values->data)
        return WEFT_OK;
    weft_error(log, "convolution: not enough memory for %zu texels of the %s", values->texels,
               what);
    return WEFT_ERR_MEMORY;
}

double weft_job_log_code(const struct weft_multipass *m, double x)
{
    const double octaves = m->passes->log_octaves;
    return x < exp2(-octaves) ? m->one : fmax(0.0, round(-log2(x) * (m->one - 1) / octaves));
}

static double stored_value(const struct weft_multipass *m, const struct weft_kernel_tile *tile,
                           size_t i)
{
    const enum weft_tile_format format = weft_kernel_tiles_get_info(m->passes->tiles)->format;
    if (format == WEFT_TILE_UNORM)
        return ((const uint16_t *)tile->data)[i];
    const double value = (double)((const float *)tile->data)[i];
    return m->passes->log_table ? weft_job_log_code(m, fabs(value) / tile->scale) : value;
}

struct tile_axes {
    int32_t base, flip, step[3];
};

// Index of sample k in a tile's memory: base + sum over axes of step k.
static struct tile_axes tile_axes(const struct weft_multipass *m,
                                  const struct weft_kernel_tile *tile)
{
    struct tile_axes axes = {0};
    for (int a = 0, stride = 1; a < m->passes->dims; a++, stride *= m->samples_per_unit) {
        const bool mirrored = tile && tile->mirrored[a];
        axes.step[a] = mirrored ? -stride : stride;
        axes.base += mirrored ? (m->samples_per_unit - 1) * stride : 0;
    }
    axes.flip = axes.base;
    return axes;
}

// One of the four components of a group's block.
static void write_component(const struct weft_multipass *m, int32_t base, int component,
                            const struct weft_tap_group *group)
{
    const struct weft_kernel_tile *tile =
        weft_kernel_tiles_get(m->passes->tiles, group->tile[component]);
    const double sign = m->signed_tiles ? group->sign[component] : 1.0;
    const struct tile_axes axes = tile_axes(m, tile);
    const int side = m->samples_per_unit, dims = m->passes->dims;
    size_t out = 4 * (size_t)base + (size_t)component;
    for (int z = 0; z < (dims > 2 ? side : 1); z++) {
        for (int y = 0; y < (dims > 1 ? side : 1); y++) {
            int32_t in = axes.base + z * axes.step[2] + y * axes.step[1];
            for (int x = 0; x < side; x++, in += axes.step[0], out += 4)
                weft_job_put(&m->tiles, out, sign * stored_value(m, tile, (size_t)in));
        }
    }
}

// What one block of values holds: four tiles, or what the tile shares with its mirror images.
static bool same_block(const struct weft_multipass *m, const struct weft_tap_group *a,
                       const struct weft_tap_group *b)
{
    if (m->passes->dot4)
        return memcmp(a->tile, b->tile, sizeof a->tile) == 0 &&
               (!m->signed_tiles || memcmp(a->sign, b->sign, sizeof a->sign) == 0);
    const struct weft_kernel_tile *tile_a = weft_kernel_tiles_get(m->passes->tiles, a->tile[0]);
    const struct weft_kernel_tile *tile_b = weft_kernel_tiles_get(m->passes->tiles, b->tile[0]);
    return tile_a && tile_b ? tile_a->stored == tile_b->stored : tile_a == tile_b;
}

// Numbers the blocks; returns how many there are.
static size_t number_blocks(const struct weft_multipass *m, int *block)
{
    int count = 0;
    for (int g = 0; g < m->passes->group_count; g++) {
        int twin = 0;
        while (!same_block(m, &m->passes->groups[twin], &m->passes->groups[g]))
            twin++;
        block[g] = twin < g ? block[twin] : count++;
    }
    return (size_t)count;
}

static void write_block(const struct weft_multipass *m, const struct weft_tap_group *group,
                        int32_t base)
{
    const size_t values = weft_kernel_tiles_get_info(m->passes->tiles)->tile_values;
    if (m->passes->dot4) {
        for (int c = 0; c < 4; c++)
            if (group->tile[c] >= 0)
                write_component(m, base, c, group);
        return;
    }
    const struct weft_kernel_tile *tile = weft_kernel_tiles_get(m->passes->tiles, group->tile[0]);
    for (size_t i = 0; tile && i < values; i++)
        weft_job_put(&m->tiles, (size_t)base + i, stored_value(m, tile, i));
}

static void set_groups(struct weft_multipass *m, const int *block)
{
    const size_t values = weft_kernel_tiles_get_info(m->passes->tiles)->tile_values;
    for (int g = 0, written = 0; g < m->passes->group_count; g++) {
        const struct weft_tap_group *group = &m->passes->groups[g];
        struct weft_job_group *out = &m->groups[g];
        out->tile_base = (int32_t)((size_t)block[g] * values);
        if (block[g] == written) {
            write_block(m, group, out->tile_base);
            written++;
        }
        if (m->positions != WEFT_JOB_LINEAR) {
            const struct tile_axes axes =
                tile_axes(m, weft_kernel_tiles_get(m->passes->tiles, group->tile[0]));
            memcpy(out->tile_step, axes.step, sizeof out->tile_step);
            out->tile_flip = axes.flip;
            out->tile_base += m->positions == WEFT_JOB_PACKED ? axes.base : 0;
        }
    }
}

static enum weft_job_positions choose_positions(const struct weft_multipass *m)
{
    const int side = m->samples_per_unit;
    bool mirrored = false;
    for (int g = 0; !m->passes->dot4 && g < m->passes->group_count; g++) {
        const int tile = m->passes->groups[g].tile[0];
        mirrored =
            mirrored || tile_axes(m, weft_kernel_tiles_get(m->passes->tiles, tile)).flip != 0;
    }
    return !mirrored                  ? WEFT_JOB_LINEAR
           : (side & (side - 1)) == 0 ? WEFT_JOB_FLIPS
                                      : WEFT_JOB_PACKED;
}

static void find_reach(struct weft_multipass *m)
{
    for (int g = 0; g < m->passes->group_count; g++) {
        for (int a = 0; a < m->passes->dims; a++) {
            const int offset = m->passes->groups[g].offset[a];
            m->reach[0][a] = offset < m->reach[0][a] ? offset : m->reach[0][a];
            m->reach[1][a] = offset > m->reach[1][a] ? offset : m->reach[1][a];
        }
    }
}

enum weft_result weft_multipass_create_tiles(struct weft_multipass *m)
{
    const struct weft_pass_list *l = m->passes;
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(l->tiles);
    enum weft_result res = WEFT_ERR_MEMORY;
    int *block = calloc((size_t)l->group_count + 1, sizeof *block);
    m->groups = calloc((size_t)l->group_count + 1, sizeof *m->groups);
    if (!block || !m->groups) {
        weft_error(m->log, "convolution: not enough memory for %d groups", l->group_count);
        goto fail;
    }
    find_reach(m);
    m->samples_per_unit = info->samples;
    m->position_bits = l->dims == 3 ? 10 : 16;
    m->signed_tiles = m->floats && l->dot4;
    const size_t blocks = number_blocks(m, block);
    const int64_t limit = m->limits.texels;
    res = weft_job_check_texels(m->log, "tiles", (double)blocks * (double)info->tile_values,
                                limit < INT32_MAX ? limit : INT32_MAX);
    if (res != WEFT_OK)
        goto fail;
    const int largest = m->floats || l->log_table ? m->one : (1 << info->bits) - 1;
    m->tiles.type = m->floats         ? WEFT_VALUE_FLOAT
                    : largest <= 0xff ? WEFT_VALUE_UINT8
                                      : WEFT_VALUE_UINT16;
    m->tiles.components = l->dot4 ? 4 : 1;
    m->tiles.texels = (blocks ? blocks : 1) * info->tile_values;
    m->positions = choose_positions(m);
    res = weft_job_values_fit(m->log, "tiles", &m->tiles);
    if (res == WEFT_OK)
        set_groups(m, block);
fail:
    free(block);
    return res;
}

int weft_multipass_bias(const struct weft_multipass *m, const struct weft_pass *pass)
{
    if (m->passes->exact_inside)
        return pass->bias + pass->denominator / 2;
    const int64_t unit = INT64_C(1) << m->extra_bits;
    const int64_t twice = 2 * llabs(pass->bias * unit) + pass->denominator;
    const int magnitude = (int)(twice / (2 * (int64_t)pass->denominator));
    return (pass->bias < 0 ? -magnitude : magnitude) + (int)(unit / 2);
}
