// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/volumes/cut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/analysis/reference.h"
#include "filter/kernels/signal.h"
#include "tiles/volume/volume.h"

enum { MAX_CHECKED = 1 << 20 };
#define MAX_VOXELS (INT64_C(1) << 30)

static void to_stderr(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_peers: %s\n", message);
}

static const struct weft_log console = {to_stderr, NULL};

const char *cut_reference_name(enum cut_reference reference)
{
    static const char *const names[] = {"catmull-rom", "bspline", "cubic spline"};
    return names[reference];
}

static size_t voxel_count(const struct cut *cut)
{
    return (size_t)cut->size[0] * (size_t)cut->size[1] * (size_t)cut->size[2];
}

// A file in memory: children read it, and nothing is left behind however this ends.
static bool make_box(struct cut *cut)
{
    if ((int64_t)cut->size[0] * cut->size[1] > MAX_VOXELS / cut->size[2]) {
        weft_error(&console, "%d x %d x %d voxels are more than %lld", cut->size[0], cut->size[1],
                   cut->size[2], (long long)MAX_VOXELS);
        return false;
    }
    const size_t bytes = voxel_count(cut) * sizeof *cut->box;
    cut->box_fd = memfd_create("box", 0);
    if (cut->box_fd < 0 || ftruncate(cut->box_fd, (off_t)bytes) != 0)
        return false;
    void *map = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, cut->box_fd, 0);
    cut->box = map == MAP_FAILED ? NULL : map;
    return cut->box != NULL;
}

static bool fill_from_signal(struct cut *cut)
{
    char name[sizeof cut->name];
    int size = 256;
    snprintf(name, sizeof name, "%s", cut->name);
    char *colon = strchr(name, ':');
    if (colon) {
        size = atoi(colon + 1);
        *colon = '\0';
    }
    const struct weft_signal_info *signal = weft_signal_find(name);
    if (!signal || size < 8 || size > 1024) {
        weft_error(&console, "%s: neither a .vdb file nor SIGNAL[:N], N from 8 to 1024", cut->name);
        return false;
    }
    cut->size[0] = cut->size[1] = cut->size[2] = size;
    if (!make_box(cut))
        return false;
    float *out = cut->box;
    for (int z = 0; z < size; z++)
        for (int y = 0; y < size; y++)
            for (int x = 0; x < size; x++)
                *out++ = (float)signal->value((double[3]){weft_signal_coordinate(x, size),
                                                          weft_signal_coordinate(y, size),
                                                          weft_signal_coordinate(z, size)});
    return true;
}

// A cube of `side` voxels: `values` [z][y][x], or one value where stride is 0. What lies outside
// the box, whose first voxel is `first`, is left out.
static void put_cube(struct cut *cut, const int32_t first[3], const int32_t origin[3], int side,
                     const float *values, size_t stride)
{
    int low[3], high[3];
    for (int a = 0; a < 3; a++) {
        low[a] = origin[a] < first[a] ? first[a] - origin[a] : 0;
        high[a] = first[a] + cut->size[a] - origin[a];
        high[a] = high[a] < side ? high[a] : side;
    }
    for (int z = low[2]; z < high[2]; z++)
        for (int y = low[1]; y < high[1]; y++)
            for (int x = low[0]; x < high[0]; x++) {
                size_t row = (size_t)(origin[2] + z - first[2]) * (size_t)cut->size[1] +
                             (size_t)(origin[1] + y - first[1]);
                size_t from = ((size_t)z * (size_t)side + (size_t)y) * (size_t)side + (size_t)x;
                cut->box[row * (size_t)cut->size[0] + (size_t)(origin[0] + x - first[0])] =
                    values[from * stride];
            }
}

static bool fill_from_volume(struct cut *cut, weft_volume *volume)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region region = {.slab_count = 0};
    struct weft_brick_list list = {0};
    float *values = NULL;
    bool ok = false;
    for (int a = 0; a < 3; a++) {
        region.min[a] = info->active_min[a];
        region.max[a] = info->active_max[a];
        cut->size[a] = info->active_max[a] - info->active_min[a] + 1;
    }
    if (info->empty || !make_box(cut) || weft_volume_find(volume, &region, &list) != WEFT_OK)
        goto done;
    values = malloc(list.brick_count * WEFT_BRICK_VOXELS * sizeof *values + 1);
    if (!values || weft_volume_read(volume, list.brick_count,
                                    (const int32_t(*)[3])list.brick_origin, values) != WEFT_OK)
        goto done;
    for (size_t i = 0, count = voxel_count(cut); i < count; i++)
        cut->box[i] = info->background;
    for (size_t i = 0; i < list.tile_count; i++)
        put_cube(cut, info->active_min, list.tiles[i].origin, list.tiles[i].size,
                 &list.tiles[i].value, 0);
    for (size_t i = 0; i < list.brick_count; i++)
        put_cube(cut, info->active_min, list.brick_origin[i], WEFT_BRICK_SIZE,
                 values + i * WEFT_BRICK_VOXELS, 1);
    ok = true;
done:
    free(values);
    weft_brick_list_clear(&list);
    return ok;
}

static bool fill_from_file(struct cut *cut, const char *path)
{
    weft_volume *volume = NULL;
    const struct weft_volume_open_params params = {.path = path, .log = &console};
    bool ok = weft_volume_open(&params, &volume) == WEFT_OK && fill_from_volume(cut, volume);
    weft_volume_destroy(&volume);
    return ok;
}

// The same planes as bench_slice's, in fractions of the box. The axis-aligned one lies off the
// voxels' own planes, so that all taps count.
static void place(struct cut *cut, enum cut_plane plane)
{
    static const double edges[][2][3] = {
        [CUT_OBLIQUE] = {{0.62, 0.28, 0.12}, {-0.25, 0.55, 0.30}},
        [CUT_AXIS] = {{0.87, 0.0, 0.0}, {0.0, 0.87, 0.0}},
    };
    for (int a = 0; a < 3; a++) {
        const double u = edges[plane][0][a] * cut->size[a], v = edges[plane][1][a] * cut->size[a];
        cut->du[a] = u / cut->width;
        cut->dv[a] = v / cut->height;
        cut->origin[a] = 0.5 * (cut->size[a] - u - v + cut->du[a] + cut->dv[a]);
    }
    if (plane == CUT_AXIS)
        cut->origin[2] = floor(cut->origin[2]) - 0.3;
}

static void position_of(const struct cut *cut, uint32_t pixel, double position[3])
{
    const int x = (int)(pixel % (uint32_t)cut->width), y = (int)(pixel / (uint32_t)cut->width);
    for (int a = 0; a < 3; a++)
        position[a] = cut->origin[a] + x * cut->du[a] + y * cut->dv[a];
}

static bool taps_inside(const struct cut *cut, uint32_t pixel)
{
    double p[3];
    position_of(cut, pixel, p);
    for (int a = 0; a < 3; a++)
        if (!(p[a] >= 1.0 && p[a] < cut->size[a] - 2.0))
            return false;
    return true;
}

// All pixels, or as many at random as fit; the seed is fixed.
static bool choose_pixels(struct cut *cut)
{
    const uint32_t total = (uint32_t)cut->width * (uint32_t)cut->height;
    const uint32_t tries = total < MAX_CHECKED ? total : MAX_CHECKED;
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15);
    cut->checked = malloc(tries * sizeof *cut->checked);
    if (!cut->checked)
        return false;
    for (uint32_t i = 0; i < tries; i++) {
        uint32_t pixel = i;
        if (total > tries) {
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            pixel = (uint32_t)((state >> 32) * total >> 32);
        }
        if (taps_inside(cut, pixel))
            cut->checked[cut->checked_count++] = pixel;
    }
    return cut->checked_count > 0;
}

bool cut_make(struct cut *cut, const char *source, enum cut_plane plane, int width, int height)
{
    const size_t length = strlen(source);
    *cut = (struct cut){.width = width, .height = height, .box_fd = -1};
    snprintf(cut->name, sizeof cut->name, "%s", source);
    const bool file = length > 4 && strcmp(source + length - 4, ".vdb") == 0;
    if (!(file ? fill_from_file(cut, source) : fill_from_signal(cut)))
        return false;
    for (size_t i = 0, count = voxel_count(cut); i < count; i++)
        cut->largest = fmax(cut->largest, fabs((double)cut->box[i]));
    place(cut, plane);
    return choose_pixels(cut);
}

void cut_clear(struct cut *cut)
{
    if (cut->box)
        munmap(cut->box, voxel_count(cut) * sizeof *cut->box);
    if (cut->box_fd >= 0)
        close(cut->box_fd);
    for (int i = 0; i < CUT_REFERENCES; i++)
        free(cut->reference[i]);
    free(cut->checked);
}

// ---- references ---------------------------------------------------------------------------------

// The coefficients of the cubic spline through n samples, mirrored at both ends (Unser, Aldroubi
// and Eden 1993; the causal filter's start is the sum over all mirrored periods).
static void prefilter_line(double *c, int n, size_t stride)
{
    const double pole = sqrt(3.0) - 2.0, gain = 6.0;
    if (n < 2)
        return;
    const double last = c[(size_t)(n - 1) * stride];
    double power = pole, sum = c[0] + pow(pole, n - 1) * last;
    for (int i = 1; i < n - 1; i++, power *= pole)
        sum += (power + pow(pole, 2 * n - 2 - i)) * c[(size_t)i * stride];
    c[0] = sum / (1.0 - pow(pole, 2 * n - 2));
    for (int i = 1; i < n; i++)
        c[(size_t)i * stride] += pole * c[(size_t)(i - 1) * stride];
    double *end = c + (size_t)(n - 1) * stride;
    *end = pole / (pole * pole - 1.0) * (*end + pole * *(end - stride));
    for (int i = n - 2; i >= 0; i--)
        c[(size_t)i * stride] = pole * (c[(size_t)(i + 1) * stride] - c[(size_t)i * stride]);
    for (int i = 0; i < n; i++)
        c[(size_t)i * stride] *= gain;
}

static double *prefilter(const struct cut *cut)
{
    const size_t count = voxel_count(cut), sx = (size_t)cut->size[0], sy = (size_t)cut->size[1];
    const size_t stride[3] = {1, sx, sx * sy};
    double *c = malloc(count * sizeof *c);
    if (!c)
        return NULL;
    for (size_t i = 0; i < count; i++)
        c[i] = (double)cut->box[i];
    for (int a = 0; a < 3; a++)
        for (size_t i = 0; i < count; i++)
            if (i / stride[a] % (size_t)cut->size[a] == 0)
                prefilter_line(c + i, cut->size[a], stride[a]);
    return c;
}

struct source {
    const struct cut *cut;
    const double *coefficients; // NULL: the samples
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct source *source = priv;
    const struct cut *cut = source->cut;
    const size_t at = (size_t)((index[2] * cut->size[1] + index[1]) * cut->size[0] + index[0]);
    return source->coefficients ? source->coefficients[at] : (double)cut->box[at];
}

static bool make_reference(struct cut *cut, enum cut_reference reference)
{
    struct weft_kernel kernel;
    const char *name = reference == CUT_CATMULL_ROM ? "catmull-rom" : "bspline";
    double *coefficients = NULL, *values = malloc(cut->checked_count * sizeof *values);
    bool ok = values && weft_kernel_parse(&console, name, &kernel) == WEFT_OK;
    if (ok && reference == CUT_SPLINE) {
        coefficients = prefilter(cut);
        ok = coefficients != NULL;
    }
    struct source source = {cut, coefficients};
    for (size_t i = 0; ok && i < cut->checked_count; i++) {
        double p[3];
        position_of(cut, cut->checked[i], p);
        values[i] = weft_reference_compute(&kernel, 3, p, fetch, &source).value;
    }
    free(coefficients);
    if (!ok) {
        free(values);
        return false;
    }
    cut->reference[reference] = values;
    return true;
}

bool cut_compare(struct cut *cut, enum cut_reference reference, const float *pixels,
                 struct cut_error *out)
{
    *out = (struct cut_error){0};
    if (!cut->reference[reference] && !make_reference(cut, reference))
        return false;
    for (size_t i = 0; i < cut->checked_count; i++) {
        const double value = (double)pixels[cut->checked[i]];
        const double difference = fabs(value - cut->reference[reference][i]);
        out->not_finite += !isfinite(value);
        out->maximum = isnan(difference) ? INFINITY : fmax(out->maximum, difference);
        out->rms += difference * difference;
    }
    out->rms = sqrt(out->rms / (double)cut->checked_count);
    return true;
}
