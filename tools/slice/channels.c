// SPDX-License-Identifier: BSD-3-Clause
// What a slice's channels are: of each source the value, or quantities of it.
#include "tools/slice/stages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static bool is_value(const struct weft_quantities *list)
{
    return list->count == 1 && list->quantity[0] == WEFT_QUANTITY_VALUE;
}

bool slice_is_plain(const struct slice_setup *setup)
{
    return setup->source_count == 1 && is_value(&setup->quantities);
}

// ---- options ------------------------------------------------------------------------------------

enum weft_result slice_read_quantities(struct slice_setup *setup)
{
    const struct option_value *quantity = &setup->option[SLICE_QUANTITY];
    return weft_quantities_parse(report_log(), quantity->given ? quantity->text : "value",
                                 &setup->quantities);
}

// What is of values alone, and what is of one plane of them.
static const char *find_conflict(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    const bool derives = setup->quantities.derivative_count > 1 || !is_value(&setup->quantities);
    if (derives && o[SLICE_CLAMP].given)
        return "--clamp is of values, and not of --quantity";
    if (derives && o[SLICE_HARDWARE].given)
        return "--hardware filters values, and not --quantity: texture samplers have no weights of "
               "derivatives";
    if (o[SLICE_ERROR_IMAGE].given)
        return "--error-image is of the value of one grid, and not of --quantity, several grids or "
               "grids of vectors";
    if (o[SLICE_MAX_ERROR].given)
        return "--max-error chooses a method for the value of one grid, and not for --quantity, "
               "several grids or grids of vectors";
    if (setup->divided.is)
        return "--quantity, several grids and grids of vectors are not divided; run it without "
               "mpirun";
    if (o[SLICE_FRAMES].given && o[SLICE_PREVIEW].given && !o[SLICE_RANGE].given &&
        setup->quantities.quantity[0] != WEFT_QUANTITY_NORMAL)
        return "--frames with a --preview of --quantity, several grids or grids of vectors needs "
               "--range LO,HI: else each frame had its own";
    return NULL;
}

enum weft_result slice_check_channels(const struct slice_setup *setup)
{
    const char *conflict =
        slice_is_plain(setup) || (!setup->source_count && is_value(&setup->quantities))
            ? NULL
            : find_conflict(setup);
    if (!conflict)
        return WEFT_OK;
    report_error("%s", conflict);
    return WEFT_ERR_ARGUMENT;
}

// ---- memory -------------------------------------------------------------------------------------

static size_t plane_size(const struct slice_job *job)
{
    return (size_t)job->geometry.width * (size_t)job->geometry.height;
}

enum weft_result slice_allocate(struct slice_job *job)
{
    const struct slice_setup *setup = job->setup;
    const struct weft_quantities *list = &setup->quantities;
    const struct weft_slice_geometry *g = &job->geometry;
    const int derived = job->derived_count = is_value(list) ? 0 : list->derivative_count;
    job->channel_count = setup->source_count * list->channel_count;
    job->channel = calloc((size_t)job->channel_count, sizeof *job->channel);
    if (!job->channel)
        return WEFT_ERR_MEMORY;
    if (slice_is_plain(setup)) // where ranks make it, too
        snprintf(job->channel[0].name, sizeof job->channel[0].name, "Y");
    if (setup->option[SLICE_EXPLAIN].given)
        return WEFT_OK;
    const size_t planes = (size_t)(job->channel_count + derived), count = plane_size(job);
    if (!slice_is_plain(setup) && count > (size_t)WEFT_SLICE_MAX_PIXELS / planes) {
        report_error("%d x %d pixels in %d channels%s are %.3g values: there may be at most %lld",
                     g->width, g->height, job->channel_count,
                     derived ? ", and derivatives that they are made of," : "",
                     (double)count * (double)planes, (long long)WEFT_SLICE_MAX_PIXELS);
        return WEFT_ERR_LIMIT;
    }
    const size_t bytes = count * planes * sizeof *job->pixels;
    job->pixels = malloc(bytes);
    if (!job->pixels) {
        report_error("out of memory: %zu bytes for %d x %d pixels", bytes, g->width, g->height);
        return WEFT_ERR_MEMORY;
    }
    if (derived)
        job->derived = job->pixels + (size_t)job->channel_count * count;
    return WEFT_OK;
}

// ---- planes -------------------------------------------------------------------------------------

// Of the source whose turn it is.
static int first_channel(const struct slice_job *job)
{
    return (int)(job->source - job->setup->source) * job->setup->quantities.channel_count;
}

static float *plane_of(const struct slice_job *job, int channel)
{
    return job->pixels + (size_t)channel * plane_size(job);
}

float *slice_channel_planes(const struct slice_job *job)
{
    return plane_of(job, first_channel(job));
}

float *slice_planes(const struct slice_job *job)
{
    return job->derived ? job->derived : slice_channel_planes(job);
}

static void name_channel(const struct slice_job *job, int index, struct slice_channel *out)
{
    const struct weft_quantities *list = &job->setup->quantities;
    const char *own = list->channel[index];
    if (strcmp(own, "Y") == 0)
        snprintf(out->name, sizeof out->name, "%s", job->source->name);
    else
        snprintf(out->name, sizeof out->name, "%s%s", job->source->prefix, own);
}

static void measure(const struct slice_job *job, int channel)
{
    struct slice_channel *out = &job->channel[channel];
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    weft_statistics_add(&s, plane_of(job, channel), plane_size(job));
    out->minimum = s.minimum;
    out->maximum = s.maximum;
    out->not_finite = s.not_finite;
}

static enum weft_result find_transform(const struct slice_job *job,
                                       struct weft_quantity_transform *out)
{
    return weft_quantity_transform_create(report_log(),
                                          weft_volume_get_info(job->volume)->index_to_world, out);
}

enum weft_result slice_make_channels(struct slice_job *job)
{
    const struct weft_quantities *list = &job->setup->quantities;
    const int first = first_channel(job);
    const float *from[WEFT_DERIVATIVES];
    float *to[WEFT_QUANTITY_CHANNELS];
    struct weft_quantity_transform transform;
    for (int i = 0; i < list->channel_count; i++) {
        name_channel(job, i, &job->channel[first + i]);
        to[i] = plane_of(job, first + i);
    }
    if (job->derived && !job->slab.cuts) {
        const enum weft_result res = find_transform(job, &transform);
        if (res != WEFT_OK)
            return res;
        for (int i = 0; i < list->derivative_count; i++)
            from[i] = job->derived + (size_t)i * plane_size(job);
        weft_quantities_compute_planes(list, &transform, plane_size(job), from, to);
    }
    for (int i = 0; i < list->channel_count && !slice_is_plain(job->setup); i++)
        measure(job, first + i);
    return WEFT_OK;
}

// ---- slabs --------------------------------------------------------------------------------------

enum weft_result slice_check_slab(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    const char *conflict = NULL;
    if (!o[SLICE_SLAB].given && o[SLICE_COMBINE].given)
        conflict = "--combine is of a --slab";
    else if (!o[SLICE_SLAB].given)
        return WEFT_OK;
    else if (o[SLICE_PASSES + PASS_PROFILE].given || o[SLICE_HARDWARE].given ||
             o[SLICE_MAX_ERROR].given)
        conflict = "--slab excludes --profile, --hardware and --max-error, which are of one plane";
    else if (o[SLICE_VERIFY].given)
        conflict = "--slab excludes --verify, which is of one plane: verify its cuts one by one";
    else if (o[SLICE_SOURCE].given && o[SLICE_SOURCE].integer[0] &&
             !o[SLICE_PASSES + PASS_SOURCE_RANGE].given)
        conflict = "--slab with --source needs --source-range: all cuts have one";
    else if (setup->divided.is)
        conflict = "--slab is not divided; run it without mpirun";
    if (!conflict)
        return WEFT_OK;
    report_error("%s", conflict);
    return WEFT_ERR_ARGUMENT;
}

struct weft_slab_params slice_slab_params(const struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    struct weft_slab_params params = {.volume = job->volume,
                                      .slice = job->slice_params,
                                      .thickness = o[SLICE_SLAB].number[0],
                                      .combine = (enum weft_combine)o[SLICE_COMBINE].integer[0]};
    params.slice.may_miss = false;
    if (job->derived_count) {
        params.slice.derivative = NULL;
        params.slice.derivative_count = 0;
        params.quantities = &job->setup->quantities;
    }
    return params;
}

enum weft_result slice_place_slab(struct slice_job *job)
{
    const struct weft_slab_params params = slice_slab_params(job);
    return job->setup->option[SLICE_SLAB].given ? weft_slab_place(&params, &job->slab) : WEFT_OK;
}

// ---- bounds -------------------------------------------------------------------------------------

// Quantities are rounded to floats once more.
static void add_bounds(const struct slice_job *job, size_t pixel, const double *bound)
{
    for (int i = 0; i < job->setup->quantities.channel_count; i++) {
        struct slice_channel *c = &job->channel[first_channel(job) + i];
        const double value = fabs((double)plane_of(job, first_channel(job) + i)[pixel]);
        const double own = bound[i] + 0x1p-24 * value;
        if (!isfinite(own))
            c->unbounded++;
        else if (!(c->bound >= own))
            c->bound = own;
    }
}

void slice_bound_channels(struct slice_job *job, const double *error)
{
    const struct weft_quantities *list = &job->setup->quantities;
    struct weft_quantity_transform transform;
    const size_t count = plane_size(job);
    for (int i = 0; i < list->channel_count; i++)
        job->channel[first_channel(job) + i].bound = job->derived ? NAN : error[0];
    if (!job->derived || find_transform(job, &transform) != WEFT_OK)
        return;
    for (size_t pixel = 0; pixel < count; pixel++) {
        double derivative[WEFT_DERIVATIVES], bound[WEFT_QUANTITY_CHANNELS];
        for (int i = 0; i < list->derivative_count; i++)
            derivative[i] = (double)job->derived[(size_t)i * count + pixel];
        weft_quantities_bound(list, &transform, derivative, error, bound);
        add_bounds(job, pixel, bound);
    }
}

// ---- told ---------------------------------------------------------------------------------------

json_t *slice_channels_json(const struct slice_job *job)
{
    json_t *list = json_array();
    for (int i = 0; i < job->channel_count; i++) {
        const struct slice_channel *c = &job->channel[i];
        json_t *one = json_pack("{s:o,s:o,s:o,s:o}", "name", json_text(c->name), "minimum",
                                json_number(c->minimum), "maximum", json_number(c->maximum),
                                "not_finite", json_count(c->not_finite));
        if (job->setup->option[SLICE_VERIFY].given || job->curve.position) {
            json_object_set_new(one, "bound", json_number(c->bound));
            json_object_set_new(one, "unbounded", json_count(c->unbounded));
        }
        json_array_append_new(list, one);
    }
    return list;
}

// Of unit vectors, colours are those of normal maps; of others each frame's own, as far as the
// largest component reaches either way.
bool slice_shows_vector(const struct slice_job *job, float range[2])
{
    const struct slice_setup *setup = job->setup;
    const enum weft_quantity first = setup->quantities.quantity[0];
    const bool of_quantity = first == WEFT_QUANTITY_GRADIENT || first == WEFT_QUANTITY_NORMAL;
    double most = 0.0;
    if (!job->channel) // made by ranks
        return false;
    const bool of_grid = is_value(&setup->quantities) && setup->source[0].vector;
    for (int i = 0; i < 3 && i < job->channel_count; i++)
        most = fmax(most, fmax(fabs(job->channel[i].minimum), fabs(job->channel[i].maximum)));
    if (first == WEFT_QUANTITY_NORMAL || !(most > 0.0))
        most = 1.0;
    range[0] = setup->range.given ? (float)setup->range.number[0] : -(float)most;
    range[1] = setup->range.given ? (float)setup->range.number[1] : (float)most;
    return of_quantity || of_grid;
}
