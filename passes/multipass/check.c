// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "passes/multipass/compiled.h"

// ---- the list -----------------------------------------------------------------------------------

static bool tile_format_fits(const struct weft_pass_list *l)
{
    const enum weft_tile_format format = weft_kernel_tiles_get_info(l->tiles)->format;
    const bool real = format == WEFT_TILE_HALF || format == WEFT_TILE_FLOAT;
    return weft_target_one(l->target) == 0 || l->log_table ? real : format == WEFT_TILE_UNORM;
}

static enum weft_result check_whole(const struct weft_log *log, const struct weft_multipass_work *w)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_pass_list *l = w->passes;
    const struct weft_kernel_tiles_info *t = weft_kernel_tiles_get_info(l->tiles);
    const bool floats = weft_target_one(l->target) == 0;
    weft_require(log, w->kernel.info && w->kernel.width == t->width);
    weft_require(log, w->channels == 1 || (w->channels == 4 && !l->dot4));
    weft_require(log, weft_derivative_order(&w->derivative) >= 0);
    weft_require(log, l->dims == 3 || !w->derivative.along[2]);
    weft_require(log, tile_format_fits(l));
    weft_require(log, !floats || (l->extra_bits == 0 && !l->log_table));
    weft_require(log, l->result_scale > 0.0 && isfinite(l->result_scale));
    if (l->dims == 3 && t->samples > 1024) {
        weft_error(log, "convolution: %d samples per unit in 3D, over the limit of 1024",
                   t->samples);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

enum weft_result weft_multipass_check_list(const struct weft_log *log,
                                           const struct weft_multipass_work *work)
{
    const struct weft_pass_list *l = work->passes;
    enum weft_result res = weft_pass_list_check(log, l);
    if (res == WEFT_OK)
        res = check_whole(log, work);
    // Integers are shifted up only, and keep to 32 bits.
    for (int g = 0; res == WEFT_OK && g < l->group_count; g++) {
        for (int c = 0; c < (l->dot4 ? 4 : 1); c++) {
            const int shift = l->groups[g].shift[c];
            if (shift >= 0 && shift + l->extra_bits <= 30)
                continue;
            weft_error(log, "convolution: group %d has a shift of %d, not 0 to %d", g, shift,
                       30 - l->extra_bits);
            return WEFT_ERR_ARGUMENT;
        }
    }
    return res;
}

// ---- the request --------------------------------------------------------------------------------

static bool all_finite(const double *values, int count)
{
    for (int i = 0; values && i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

static bool positions_finite(const struct weft_pixel_grid *grid)
{
    for (int corner = 0; corner < 4; corner++) {
        double at[3];
        weft_multipass_position(grid, (corner & 1) * (grid->width - 1),
                                (corner >> 1) * (grid->height - 1), at);
        if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2]))
            return false;
    }
    return all_finite(grid->columns, grid->width) && all_finite(grid->rows, grid->height);
}

enum weft_result weft_multipass_check_request(const struct weft_log *log,
                                              const struct weft_multipass_work *work,
                                              const struct weft_multipass_request *request)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_samples *s = request->samples;
    const struct weft_pixel_grid *g = request->grid;
    weft_require(log, s && g);
    weft_require(log, g->width > 0 && g->height > 0);
    weft_require(log, s->size[0] > 0 && s->size[1] > 0 && s->size[2] > 0);
    weft_require(log, work->passes->dims > 2 || s->size[2] == 1);
    weft_require(log, work->passes->dims > 1 || s->size[1] == 1);
    for (int c = 0; c < work->channels; c++)
        weft_require(log, s->plane[c] && request->pixels[c]);
    weft_require(log, !isinf(s->low) && !isinf(s->high) && !isinf(s->high - s->low));
    if (weft_multipass_stride(request) < g->width) {
        weft_error(log, "convolution: a stride of %lld floats is less than the %d pixels",
                   (long long)request->stride, g->width);
        goto fail;
    }
    if (s->low > s->high || !positions_finite(g)) {
        weft_error(log, "convolution: a range of %g to %g, or positions that are not finite",
                   s->low, s->high);
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

// ---- sums that 32 bits must hold ----------------------------------------------------------------

struct sums {
    double positive, negative;
};

static double tile_value_at(const struct weft_multipass *m, int group, int component,
                            uint32_t position)
{
    const size_t i =
        weft_job_tile_texel(m, &m->groups[group], position) * (size_t)m->tiles.components +
        (size_t)component;
    return m->tiles.type == WEFT_VALUE_UINT8 ? ((const uint8_t *)m->tiles.data)[i]
                                             : ((const uint16_t *)m->tiles.data)[i];
}

static struct sums sums_at(const struct weft_multipass *m, const struct weft_pass *p,
                           uint32_t position)
{
    struct sums s = {0.0, 0.0};
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        for (int c = 0; c < m->tiles.components; c++) {
            const double factor = weft_multipass_factor(m, p, &m->passes->groups[g], c);
            const double product = factor * m->one * tile_value_at(m, g, c, position);
            s.positive += fmax(product, 0.0);
            s.negative += fmax(-product, 0.0);
        }
    }
    return s;
}

// The largest sum of a pass over all sample positions; inputs may be anything.
static double largest_sum(const struct weft_multipass *m, const struct weft_pass *p)
{
    const size_t positions = weft_kernel_tiles_get_info(m->passes->tiles)->tile_values;
    const uint32_t side = (uint32_t)m->samples_per_unit;
    double largest = 0.0;
    for (uint32_t i = 0; i < positions; i++) {
        const uint32_t k[3] = {i % side, i / side % side, i / side / side};
        const struct sums s = sums_at(m, p, weft_job_pack_position(m, k));
        largest = fmax(largest, fmax(s.positive, s.negative));
    }
    return largest;
}

// The same with every tile's largest value, at a glance.
static double sum_bound(const struct weft_multipass *m, const struct weft_pass *p)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(m->passes->tiles);
    double bound = 0.0;
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        const struct weft_tap_group *group = &m->passes->groups[g];
        for (int c = 0; c < m->tiles.components; c++) {
            const struct weft_kernel_tile *t =
                weft_kernel_tiles_get(m->passes->tiles, group->tile[c]);
            if (t)
                bound += fabs((double)weft_multipass_factor(m, p, group, c)) * m->one *
                         fmax(fabs(t->minimum), fabs(t->maximum)) * info->one * t->scale;
        }
    }
    return bound;
}

static double log_bound(const struct weft_multipass *m, const struct weft_pass *p)
{
    uint32_t largest = 0;
    for (int i = 0; i <= 2 * m->one; i++)
        largest = m->passes->log_table[i] > largest ? m->passes->log_table[i] : largest;
    return (double)largest * p->group_count * m->tiles.components;
}

static double combine_bound(const struct weft_multipass *m, const struct weft_pass *p)
{
    const bool exact = m->passes->exact_inside;
    const double scale = exact ? 1.0 : exp2(m->extra_bits);
    const double bias = fabs((double)p->bias) * scale / (exact ? 1.0 : p->denominator);
    double bound = 0.0;
    for (int i = 0; i < p->input_count; i++)
        bound += fabs((double)p->numerator[i]) * m->one * scale;
    return bound + bias + p->denominator;
}

enum weft_result weft_multipass_check_sums(const struct weft_multipass *m)
{
    for (int i = 0; !m->floats && i < m->passes->pass_count; i++) {
        const struct weft_pass *p = &m->passes->passes[i];
        const bool combines = p->kind == WEFT_PASS_COMBINE, log = m->passes->log_table;
        // Without exact sums, those of rounded products are smaller.
        const double divisor = log ? 1.0 : p->divisor;
        const double rest = combines ? 0.0 : (fabs((double)p->bias) + 1.0) * divisor;
        double bound = combines ? combine_bound(m, p) : log ? log_bound(m, p) : sum_bound(m, p);
        if (bound + rest > INT_MAX && !combines && !log)
            bound = largest_sum(m, p);
        if (bound + rest <= INT_MAX)
            continue;
        weft_error(m->log, "convolution: sums up to %.0f in pass %d, over 32 bits' %d",
                   bound + rest, i, INT_MAX);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}
