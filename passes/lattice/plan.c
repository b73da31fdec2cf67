// SPDX-License-Identifier: BSD-3-Clause
// Plans of volumes on another lattice.
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/lattice/lattice_impl.h"

static enum weft_result out_of_memory(const struct weft_log *log)
{
    weft_error(log, "not enough memory for a plan");
    return WEFT_ERR_MEMORY;
}

// ---- what is asked for --------------------------------------------------------------------------

static bool all_zero(const double m[3][4])
{
    for (int i = 0; i < 12; i++)
        if (m[i / 4][i % 4] != 0.0)
            return false;
    return true;
}

static enum weft_result set_maps(struct weft_lattice_plan *plan,
                                 const struct weft_lattice_params *params)
{
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    struct weft_lattice_info *info = &plan->info;
    const struct weft_volume_info *volume = weft_volume_get_info(params->volume);
    const bool stays = all_zero(params->index_to_world);
    const double(*to_source)[4] = all_zero(params->to_source) ? identity : params->to_source;
    double inverse[3][4], world[3][4];
    memcpy(info->to_source, to_source, sizeof info->to_source);
    if (stays)
        weft_lattice_multiply(volume->index_to_world, to_source, info->index_to_world);
    else
        memcpy(info->index_to_world, params->index_to_world, sizeof info->index_to_world);
    // Checks that both are regular, and finds where the source's voxels are in the result's world.
    enum weft_result res =
        weft_lattice_map_compute(plan->log, identity, NULL, info->to_source, inverse);
    if (res != WEFT_OK)
        return res;
    if (!weft_lattice_invert(info->index_to_world, world)) {
        weft_error(plan->log, "the result's transform is singular or not finite");
        return WEFT_ERR_ARGUMENT;
    }
    weft_lattice_invert(info->to_source, inverse);
    weft_lattice_multiply(info->index_to_world, inverse, world);
    return weft_quantity_transform_create(
        plan->log, params->index_space ? NULL : (const double(*)[4])world, &plan->transform);
}

// Distance of the result's voxels along the source's axes: the kernel is stretched by it.
static enum weft_result set_kernel(struct weft_lattice_plan *plan,
                                   const struct weft_lattice_params *params)
{
    struct weft_lattice_info *info = &plan->info;
    info->kernel = params->kernel;
    enum weft_result res = WEFT_OK;
    if (!info->kernel.info)
        res = weft_kernel_parse(plan->log, "catmull-rom", &info->kernel);
    if (res == WEFT_OK)
        res = weft_kernel_check(plan->log, &info->kernel);
    if (res != WEFT_OK)
        return res;
    if (info->kernel.radial) {
        weft_error(plan->log, "kernel %s: radial kernels have no place on lattices",
                   info->kernel.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    for (int a = 0; a < 3; a++) {
        const double *row = info->to_source[a];
        const double apart = hypot(hypot(row[0], row[1]), row[2]);
        info->stretch[a] = params->no_stretch || apart <= 1.0 + 0x1p-20
                               ? 1.0
                               : weft_stretch_scale(&info->kernel, apart);
        if (apart > WEFT_STRETCH_MAX) {
            weft_error(plan->log, "voxels %g of the source apart; kernels are stretched up to %g",
                       apart, WEFT_STRETCH_MAX);
            return WEFT_ERR_LIMIT;
        }
        if (info->kernel.prefiltered && info->stretch[a] > 1.0) {
            weft_error(plan->log,
                       "kernel %s of prefiltered voxels is not stretched for voxels %g apart: take "
                       "one that is not prefiltered, or no stretching",
                       info->kernel.info->name, apart);
            return WEFT_ERR_UNSUPPORTED;
        }
        info->width[a] = weft_stretch_width(&info->kernel, info->stretch[a]);
        plan->reach[a] = info->stretch[a] == 1.0 ? 0.5 * info->kernel.width
                                                 : info->kernel.support * info->stretch[a] +
                                                       (info->kernel.width == 1 ? 1.0 : 0.0);
    }
    return WEFT_OK;
}

static enum weft_result derive_kernels(struct weft_lattice_plan *plan)
{
    const struct weft_lattice_info *info = &plan->info;
    int most = 0;
    for (int d = 0; d < info->derivative_count; d++)
        for (int a = 0; a < 3; a++)
            most = info->derivative[d].along[a] > most ? info->derivative[d].along[a] : most;
    plan->kernel[0] = info->kernel;
    for (int order = 1; order <= most; order++) {
        const enum weft_result res =
            weft_kernel_derive(plan->log, &plan->kernel[order - 1], &plan->kernel[order]);
        if (res != WEFT_OK)
            return res;
    }
    return WEFT_OK;
}

// ---- grids that come out ------------------------------------------------------------------------

static int components_of(enum weft_quantity quantity)
{
    return quantity == WEFT_QUANTITY_GRADIENT || quantity == WEFT_QUANTITY_NORMAL ? 3 : 1;
}

static int channels_of(enum weft_quantity quantity)
{
    return quantity == WEFT_QUANTITY_HESSIAN                ? 6
           : quantity == WEFT_QUANTITY_PRINCIPAL_CURVATURES ? 2
                                                            : components_of(quantity);
}

static void add_grid(struct weft_lattice_plan *plan, const struct weft_volume_info *volume,
                     enum weft_quantity quantity, int channel)
{
    struct weft_lattice_info *info = &plan->info;
    struct weft_lattice_grid *out = &info->grid[info->grid_count];
    char *name = plan->name[info->grid_count++];
    const bool value = quantity == WEFT_QUANTITY_VALUE;
    const int components = components_of(quantity);
    snprintf(name, sizeof *plan->name, "%s%s%s", volume->name, value ? "" : ".",
             value            ? ""
             : components > 1 ? weft_quantity_names[quantity]
                              : plan->quantities.channel[channel]);
    *out = (struct weft_lattice_grid){
        .quantity = quantity,
        .channel = channel,
        .components = components,
        .grid = {.name = name,
                 .grid_class = value ? volume->grid_class : "fog volume",
                 .components = components,
                 .vector_type = quantity == WEFT_QUANTITY_NORMAL     ? "covariant normalize"
                                : quantity == WEFT_QUANTITY_GRADIENT ? "covariant"
                                                                     : "invariant",
                 .background = value ? plan->background : 0.0f,
                 .metadata_count = volume->metadata_count,
                 .metadata = volume->metadata}};
    memcpy(out->grid.index_to_world, info->index_to_world, sizeof info->index_to_world);
}

static enum weft_result set_grids(struct weft_lattice_plan *plan,
                                  const struct weft_lattice_params *params)
{
    static const enum weft_quantity value = WEFT_QUANTITY_VALUE;
    const struct weft_volume_info *volume = weft_volume_get_info(params->volume);
    struct weft_lattice_info *info = &plan->info;
    const struct weft_quantities *given = params->quantities;
    // A list is made anew: one by hand may be wrong.
    enum weft_result res =
        given ? weft_quantities_create(plan->log, given->quantity, given->count, &plan->quantities)
              : weft_quantities_create(plan->log, &value, 1, &plan->quantities);
    if (res != WEFT_OK)
        return res;
    plan->name = calloc(WEFT_LATTICE_GRIDS, sizeof *plan->name);
    if (!plan->name)
        return out_of_memory(plan->log);
    plan->plain = plan->quantities.count == 1 && plan->quantities.quantity[0] == value;
    plan->clamped = volume->clamp_to_edge;
    plan->background = plan->clamped ? 0.0f : volume->background;
    int channel = 0;
    for (int q = 0; q < plan->quantities.count; q++) {
        const enum weft_quantity quantity = plan->quantities.quantity[q];
        for (int c = 0; c < channels_of(quantity); c += components_of(quantity))
            add_grid(plan, volume, quantity, channel + c);
        channel += channels_of(quantity);
        if (quantity == value)
            info->clamps = !plan->clamped && !strcmp(volume->grid_class, "level set");
    }
    info->derivative_count = plan->quantities.derivative_count;
    memcpy(info->derivative, plan->quantities.derivative, sizeof info->derivative);
    return WEFT_OK;
}

// ---- the result's lattice -----------------------------------------------------------------------

static enum weft_result check_index(const struct weft_log *log, const double low[3],
                                    const double high[3])
{
    for (int a = 0; a < 3; a++) {
        const double far = fmax(fabs(low[a]), fabs(high[a]));
        if (far < (double)WEFT_INDEX_LIMIT)
            continue;
        weft_error(log,
                   "the result would have voxels up to %.4g along %c; indices are limited to "
                   "+-%d",
                   far, "xyz"[a], WEFT_INDEX_LIMIT);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

// Positions in a clamped volume's box, and half a voxel around it.
static void clamped_bounds(const struct weft_lattice_plan *plan, double low[3], double high[3])
{
    const struct weft_volume_info *info = weft_volume_get_info(plan->volume);
    for (int a = 0; a < 3; a++) {
        low[a] = info->active_min[a] - 0.5;
        high[a] = info->active_max[a] + 0.5;
    }
}

static enum weft_result set_box(struct weft_lattice_plan *plan,
                                const struct weft_lattice_params *params,
                                const struct weft_lattice_box *bounds)
{
    struct weft_lattice_info *info = &plan->info;
    double inverse[3][4], low[3], high[3], from[3], to[3];
    weft_lattice_invert(info->to_source, inverse);
    for (int a = 0; a < 3; a++) {
        low[a] = (double)bounds->min[a] - plan->reach[a];
        high[a] = (double)bounds->max[a] + plan->reach[a];
    }
    if (plan->clamped)
        clamped_bounds(plan, low, high);
    weft_lattice_map_box(inverse, low, high, from, to);
    for (int a = 0; a < 3; a++) {
        if (params->boxed) {
            from[a] = fmax(from[a], params->box_min[a]);
            to[a] = fmin(to[a], params->box_max[a]);
        }
        from[a] = ceil(from[a] - 0x1p-20);
        to[a] = floor(to[a] + 0x1p-20);
        info->empty = info->empty || from[a] > to[a];
    }
    if (info->empty)
        return WEFT_OK;
    const enum weft_result res = check_index(plan->log, from, to);
    for (int a = 0; res == WEFT_OK && a < 3; a++) {
        info->box_min[a] = (int32_t)from[a];
        info->box_max[a] = (int32_t)to[a];
    }
    return res;
}

// Entries that move no voxel of the box are what rounding left: axes run along each other without
// them.
static void set_axes(struct weft_lattice_plan *plan)
{
    struct weft_lattice_info *info = &plan->info;
    bool taken[3] = {false};
    info->separable = true;
    for (int c = 0; c < 3; c++) {
        const double far =
            fmax(1.0, fmax(fabs((double)info->box_min[c]), fabs((double)info->box_max[c])));
        int along = 0, count = 0;
        for (int r = 0; r < 3; r++) {
            if (fabs(info->to_source[r][c]) * far < 0x1p-34)
                info->to_source[r][c] = 0.0;
            count += info->to_source[r][c] != 0.0;
            along = info->to_source[r][c] != 0.0 ? r : along;
        }
        info->separable = info->separable && count == 1 && !taken[along];
        info->axis[c] = along;
        taken[along] = true;
    }
    for (int c = 0; !info->separable && c < 3; c++)
        info->axis[c] = c;
}

static double determinant(const double m[3][4])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static enum weft_result check_size(struct weft_lattice_plan *plan)
{
    struct weft_lattice_info *info = &plan->info;
    double box = 1.0, taps = 1.0;
    for (int a = 0; a < 3; a++) {
        box *= (double)info->box_max[a] - info->box_min[a] + 1.0;
        taps *= (double)info->width[a];
    }
    info->voxels = (double)info->bricks_in * WEFT_BRICK_VOXELS / fabs(determinant(info->to_source));
    info->voxels = info->empty ? 0.0 : fmin(info->voxels, box);
    if (info->voxels > (double)WEFT_LATTICE_MAX_VOXELS) {
        weft_error(plan->log, "the result would have about %.3g voxels; at most %.3g are made",
                   info->voxels, (double)WEFT_LATTICE_MAX_VOXELS);
        return WEFT_ERR_LIMIT;
    }
    if (!info->separable && taps > (double)WEFT_LATTICE_MAX_TAPS) {
        weft_error(plan->log, "each voxel would be a sum of %.3g products; at most %.3g are made",
                   taps, (double)WEFT_LATTICE_MAX_TAPS);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static enum weft_result check_constants(const struct weft_lattice_plan *plan)
{
    const struct weft_kernel *kernel = &plan->info.kernel;
    if (kernel->unit_sum || kernel->normalised || plan->clamped ||
        (plan->background == 0.0f && plan->info.tiles_in == 0))
        return WEFT_OK;
    weft_error(
        plan->log,
        "kernel %s: its weights do not add up to 1, and the grid's background %g or its %llu "
        "tiles would not stay what they are",
        kernel->info->name, (double)plan->background, (unsigned long long)plan->info.tiles_in);
    return WEFT_ERR_UNSUPPORTED;
}

// ---- errors -------------------------------------------------------------------------------------

// The largest sum of |weights| along an axis, of positions throughout a voxel, and a little more.
static double gain_along(const struct weft_lattice_plan *plan, int axis, int order, double *weights)
{
    enum { STEPS = 256 };
    double gain = 0.0;
    for (int i = 0; i < STEPS; i++) {
        double sum = 0.0;
        weft_stretch_weights(&plan->kernel[order], plan->info.stretch[axis], (double)i / STEPS,
                             weights);
        for (int64_t t = 0; t < plan->info.width[axis]; t++)
            sum += fabs(weights[t]);
        gain = fmax(gain, sum);
    }
    return gain * (1.0 + 1.0 / STEPS);
}

// Each product carries a few roundings of its weights, and one for each tap along each axis.
static enum weft_result set_bounds(struct weft_lattice_plan *plan)
{
    struct weft_lattice_info *info = &plan->info;
    double gain[3][WEFT_LATTICE_ORDERS] = {{0.0}}, taps = 0.0;
    int64_t width = 0;
    for (int a = 0; a < 3; a++) {
        width = info->width[a] > width ? info->width[a] : width;
        taps += (double)info->width[a];
    }
    double *weights = malloc((size_t)width * sizeof *weights);
    if (!weights)
        return out_of_memory(plan->log);
    for (int d = 0; d < info->derivative_count; d++) {
        double product = 1.0;
        for (int a = 0; a < 3; a++) {
            const int order = info->derivative[d].along[a];
            if (gain[a][order] == 0.0)
                gain[a][order] = gain_along(plan, a, order, weights);
            product *= gain[a][order];
        }
        info->bound[d] = (struct weft_bound_terms){
            .relative = product * (taps + 64.0) * 0x1p-52,
            .rounded_gain = product,
            .absolute = 0x1p-149,
        };
    }
    free(weights);
    return WEFT_OK;
}

// ---- in words -----------------------------------------------------------------------------------

__attribute__((format(printf, 2, 3))) static void say(FILE *text, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vfprintf(text, format, list);
    va_end(list);
}

static void say_axes(FILE *text, const struct weft_lattice_info *info)
{
    for (int a = 0; a < 3; a++) {
        const double *row = info->to_source[a];
        say(text, "source %c = %.9g x + %.9g y + %.9g z + %.9g: %lld taps", "xyz"[a], row[0],
            row[1], row[2], row[3], (long long)info -> width[a]);
        if (info->stretch[a] > 1.0)
            say(text, ", stretched by %.6g", info->stretch[a]);
        say(text, "\n");
    }
}

static enum weft_result write_text(struct weft_lattice_plan *plan)
{
    const struct weft_lattice_info *info = &plan->info;
    size_t size = 0;
    FILE *text = open_memstream(&plan->text, &size);
    if (!text)
        return out_of_memory(plan->log);
    char kernel[256];
    weft_kernel_format(&info->kernel, kernel, sizeof kernel);
    say(text, "kernel %s, %s\n", kernel,
        info->separable ? "one axis after another" : "all taps at once");
    say_axes(text, info);
    say(text, "source: %llu bricks, %llu tiles\n", (unsigned long long)info->bricks_in,
        (unsigned long long)info->tiles_in);
    if (info->empty)
        say(text, "result: empty\n");
    else
        say(text, "result: within (%d, %d, %d) to (%d, %d, %d), about %.3g voxels in bricks\n",
            info->box_min[0], info->box_min[1], info->box_min[2], info->box_max[0],
            info->box_max[1], info->box_max[2], info->voxels);
    if (info->band_voxels > 0.0)
        say(text, "level set: half the band is %.3g voxels wide\n", info->band_voxels);
    for (int g = 0; g < info->grid_count; g++)
        say(text, "grid %s: %s\n", info->grid[g].grid.name,
            info->grid[g].components > 1 ? "vectors" : "floats");
    say(text, "bound: %.3g of the largest value in reach\n",
        info->bound[0].relative + info->bound[0].rounded_gain * 0x1p-24);
    const bool failed = ferror(text) != 0;
    if (fclose(text) || failed)
        return out_of_memory(plan->log);
    plan->info.text = plan->text;
    return WEFT_OK;
}

static void set_band(struct weft_lattice_plan *plan)
{
    const double(*m)[4] = (const double(*)[4])plan->info.index_to_world;
    double longest = 0.0;
    for (int c = 0; c < 3; c++)
        longest = fmax(longest, hypot(hypot(m[0][c], m[1][c]), m[2][c]));
    if (plan->info.clamps)
        plan->info.band_voxels = fabs((double)plan->background) / longest;
}

// ---- life ---------------------------------------------------------------------------------------

static enum weft_result check(const struct weft_lattice_params *params)
{
    const struct weft_log *log = params->log;
    weft_require(log, params->volume != NULL);
    weft_require(log, params->prune >= 0.0 && isfinite(params->prune));
    for (int a = 0; a < 3; a++)
        weft_require(log, !params->boxed || params->box_min[a] <= params->box_max[a]);
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result set_source(struct weft_lattice_plan *plan, weft_volume *volume)
{
    plan->source = plan->volume = volume;
    if (!plan->info.kernel.prefiltered)
        return WEFT_OK;
    const enum weft_result res =
        weft_volume_prefilter(plan->log, volume, &plan->info.kernel, &plan->filtered);
    plan->source = plan->filtered;
    return res;
}

static enum weft_result look(struct weft_lattice_plan *plan,
                             const struct weft_lattice_params *params)
{
    struct weft_lattice_box bounds = {{0}, {0}};
    enum weft_result res = weft_lattice_find(plan, &bounds);
    plan->boxed = params->boxed;
    if (res == WEFT_OK)
        res = set_box(plan, params, &bounds);
    if (res != WEFT_OK)
        return res;
    if (!plan->info.empty)
        set_axes(plan);
    res = check_size(plan);
    if (res == WEFT_OK)
        res = check_constants(plan);
    if (res == WEFT_OK)
        res = set_bounds(plan);
    set_band(plan);
    return res == WEFT_OK ? write_text(plan) : res;
}

enum weft_result weft_lattice_plan_create(const struct weft_lattice_params *params,
                                          weft_lattice_plan **out)
{
    *out = NULL;
    enum weft_result res = check(params);
    if (res != WEFT_OK)
        return res;
    weft_lattice_plan *plan = calloc(1, sizeof *plan);
    if (!plan)
        return out_of_memory(params->log);
    plan->log = params->log;
    plan->prune = params->prune;
    plan->memory_bytes = params->memory_bytes ? params->memory_bytes : UINT64_C(1) << 30;
    res = set_maps(plan, params);
    if (res == WEFT_OK)
        res = set_kernel(plan, params);
    if (res == WEFT_OK)
        res = set_grids(plan, params);
    if (res == WEFT_OK)
        res = derive_kernels(plan);
    if (res == WEFT_OK)
        res = set_source(plan, params->volume);
    if (res == WEFT_OK)
        res = look(plan, params);
    if (res != WEFT_OK)
        weft_lattice_plan_destroy(&plan);
    *out = plan;
    return res;
}

void weft_lattice_plan_destroy(weft_lattice_plan **plan)
{
    if (!plan || !*plan)
        return;
    if ((*plan)->reader.volume)
        weft_brick_reader_close(&(*plan)->reader);
    for (int i = 0; i < 2; i++)
        weft_cell_map_destroy(&(*plan)->below[i]);
    weft_volume_destroy(&(*plan)->filtered);
    free((*plan)->name);
    free((*plan)->text);
    free(*plan);
    *plan = NULL;
}

const struct weft_lattice_info *weft_lattice_plan_get_info(const weft_lattice_plan *plan)
{
    return &plan->info;
}
