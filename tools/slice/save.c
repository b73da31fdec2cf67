// SPDX-License-Identifier: BSD-3-Clause
// The files of a slice.
#include "tools/slice/stages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/attributes.h"
#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/slice/save.h"

struct preview_options slice_preview_options(const struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    return (struct preview_options){.input = job->input,
                                    .output = job->output,
                                    .preview = job->preview,
                                    .error_image = o[SLICE_ERROR_IMAGE].text,
                                    .range = &job->setup->range,
                                    .colour_map = &o[SLICE_COLOUR_MAP],
                                    .annotate = &o[SLICE_ANNOTATE],
                                    .title = &o[SLICE_TITLE],
                                    .annotation = job->annotated ? &job->annotation : NULL,
                                    .no_clobber = o[SLICE_NO_CLOBBER].given};
}

// ---- annotations --------------------------------------------------------------------------------

// The axis that an edge of the plane runs along, -1: along none.
static int axis_of(const double edge[3])
{
    const double length = hypot(hypot(edge[0], edge[1]), edge[2]);
    for (int a = 0; a < 3; a++)
        if (fabs(fabs(edge[a]) - length) <= 1e-9 * length)
            return a;
    return -1;
}

// Coordinates where the edge follows an axis, else the distance along it.
static struct annotation_axis edge_axis(const double origin[3], const double edge[3],
                                        const char *oblique)
{
    const int a = axis_of(edge);
    struct annotation_axis out = {.end = hypot(hypot(edge[0], edge[1]), edge[2])};
    snprintf(out.name, sizeof out.name, "%s", a < 0 ? oblique : (const char *[]){"x", "y", "z"}[a]);
    if (a >= 0) {
        out.start = origin[a];
        out.end = origin[a] + edge[a];
    }
    return out;
}

// Of the plane's upper edge, in the world.
static double world_length(const struct slice_job *job)
{
    const double *u = job->geometry.u;
    double sum = 0.0;
    if (job->setup->option[SLICE_SPACE].integer[0] == WEFT_SPACE_WORLD)
        return hypot(hypot(u[0], u[1]), u[2]);
    if (!job->volume)
        return 0.0;
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    for (int r = 0; r < 3; r++) {
        double along = 0.0;
        for (int c = 0; c < 3; c++)
            along += info->index_to_world[r][c] * u[c];
        sum += along * along;
    }
    return sqrt(sum);
}

// Where the plane lies: across an axis, or else its middle and which way it looks.
static void describe_plane(const struct slice_job *job, char *text, size_t size)
{
    const struct weft_slice_geometry *g = &job->geometry;
    double normal[3], middle[3];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        normal[a] = g->u[b] * g->v[c] - g->u[c] * g->v[b];
        middle[a] = g->origin[a] + 0.5 * (g->u[a] + g->v[a]);
    }
    const double length = hypot(hypot(normal[0], normal[1]), normal[2]);
    const int across = axis_of(normal);
    if (across >= 0)
        snprintf(text, size, "%c = %.6g", "xyz"[across], middle[across]);
    else
        snprintf(text, size, "through %.4g, %.4g, %.4g, normal %.3f, %.3f, %.3f", middle[0],
                 middle[1], middle[2], normal[0] / length, normal[1] / length, normal[2] / length);
}

static void set_plane(const struct slice_job *job, struct annotation *out, char *where, size_t size)
{
    const struct slice_setup *setup = job->setup;
    const struct weft_slice_geometry *g = &job->geometry;
    char plane[160], slab[80] = "";
    describe_plane(job, plane, sizeof plane);
    if (setup->option[SLICE_SLAB].given)
        snprintf(slab, sizeof slab, ", %s of a slab of %g",
                 weft_combine_names[setup->option[SLICE_COMBINE].integer[0]],
                 setup->option[SLICE_SLAB].number[0]);
    snprintf(where, size, "%s%s%s", plane, slab,
             setup->option[SLICE_SPACE].integer[0] == WEFT_SPACE_WORLD ? "" : ", index space");
    out->across = edge_axis(g->origin, g->u, "u");
    out->down = edge_axis(g->origin, g->v, "v");
    out->length = world_length(job);
    snprintf(out->unit, sizeof out->unit, "world units");
}

// A line's length runs to the right, and what is across it from one side to the other.
static void set_curve(const struct slice_job *job, struct annotation *out, char *where, size_t size)
{
    const struct option_value *o = job->setup->option;
    snprintf(where, size, "%s",
             paths_base_name(o[o[SLICE_ALONG].given ? SLICE_ALONG : SLICE_POSITIONS].text));
    if (!o[SLICE_ALONG].given)
        return;
    const double half = 0.5 * o[SLICE_WIDTH].number[0];
    out->across = (struct annotation_axis){.name = "along", .end = job->curve.length};
    out->down = (struct annotation_axis){.name = "w", .start = -half, .end = half};
    if (o[SLICE_SPACE].integer[0] == WEFT_SPACE_WORLD) {
        out->length = job->curve.length;
        snprintf(out->unit, sizeof out->unit, "world units");
    }
}

void slice_annotate(struct slice_job *job)
{
    const struct preview_options options = slice_preview_options(job);
    const char *grid = job->volume ? weft_volume_get_info(job->volume)->name : "";
    const char *what = slice_is_plain(job->setup) || !job->channel ? grid : job->channel[0].name;
    float range[2];
    const bool vector = slice_shows_vector(job, range);
    char title[ANNOTATION_TEXT], caption[ANNOTATION_TEXT], kernel[KERNELS_TEXT], where[300];
    if (!job->made || !(job->setup->option[SLICE_ANNOTATE].given || job->errors.plane))
        return;
    struct annotation plane = {.length = 0.0};
    (slice_is_curved(job->setup) ? set_curve : set_plane)(job, &plane, where, sizeof where);
    weft_kernel_format(job->plan ? &weft_slice_plan_get_info(job->plan)->kernel
                                 : &job->slice_params.kernel,
                       kernel, sizeof kernel);
    // "gradient.X" is the first of three.
    const int length = (int)strlen(what) - (vector && strlen(what) > 2 ? 2 : 0);
    snprintf(title, sizeof title, "%.200s%s%.*s", paths_base_name(job->input), *what ? ": " : "",
             length < 150 ? length : 150, what);
    snprintf(caption, sizeof caption, "%.120s, %.160s, %d x %d pixels%s", kernel, where,
             job->geometry.width, job->geometry.height,
             vector ? "; X, Y, Z as red, green, blue" : "");
    job->annotated = preview_annotate(&options, title, caption, &job->annotation);
    job->annotation.across = plane.across;
    job->annotation.down = plane.down;
    job->annotation.length = plane.length;
    memcpy(job->annotation.unit, plane.unit, sizeof plane.unit);
    snprintf(job->annotation.quantity, sizeof job->annotation.quantity, "%.60s", what);
}

// ---- files --------------------------------------------------------------------------------------

// To be freed; NULL: out of memory. What ranks made is one plane.
static struct weft_image_channel *make_channels(const struct slice_job *job, int *count)
{
    *count = job->channel ? job->channel_count : 1;
    const size_t size = (size_t)job->geometry.width * (size_t)job->geometry.height;
    struct weft_image_channel *out = calloc((size_t)*count, sizeof *out);
    for (int i = 0; out && i < *count; i++) {
        out[i].type = (enum weft_pixel_type)job->setup->option[SLICE_TYPE].integer[0];
        out[i].plane = job->pixels ? job->pixels + (size_t)i * size : NULL;
        snprintf(out[i].name, sizeof out[i].name, "%.255s",
                 job->channel ? job->channel[i].name : "Y");
    }
    return out;
}

enum weft_result slice_write_exr(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    const struct option_value *o = job->setup->option;
    struct weft_image_attribute attributes[SLICE_ATTRIBUTES];
    int channel_count;
    struct weft_image_channel *channels = make_channels(job, &channel_count);
    if (!channels)
        return WEFT_ERR_MEMORY;
    attributes_of_texts(job->attributes, job->attribute_count, attributes);
    const struct weft_image image = {
        .width = g->width,
        .height = g->height,
        .display_max = {g->width - 1, g->height - 1},
        .compression = (enum weft_image_compression)o[SLICE_COMPRESSION].integer[0],
        .channel_count = channel_count,
        .channels = channels,
        .attribute_count = job->attribute_count,
        .attributes = attributes,
    };
    const struct weft_image_save_params params = {
        .path = job->output,
        .no_clobber = o[SLICE_NO_CLOBBER].given,
        .verify = o[SLICE_VERIFY].given,
        .threads = job->setup->engine.cpu.threads,
        .packed = job->bands ? slice_stream_give : NULL,
        .packed_priv = job,
        .progress = report_writing(job->output),
        .log = report_log(),
    };
    const enum weft_result res = weft_image_save_parts(&image, 1, &params, &job->saved);
    free(channels);
    job->saved.overflows += job->packing.overflows;
    job->saved.rounding = fmax(job->saved.rounding, job->packing.rounding);
    if (res == WEFT_OK)
        saved_warn(job->output, &job->saved);
    return res;
}

// Light whose code in sRGB is the value's share of the range, so that codes are linear in values.
static float light_of(double share)
{
    return (float)(share <= 0.04045 ? share / 12.92 : pow((share + 0.055) / 1.055, 2.4));
}

static enum weft_result write_colours(struct slice_job *job, const struct preview_options *preview)
{
    const size_t size = (size_t)job->geometry.width * (size_t)job->geometry.height;
    const double low = job->preview_range[0], span = job->preview_range[1] - low;
    float *light = malloc(3 * size * sizeof *light), range[2];
    struct option_value none = {.given = false};
    struct preview_options options = *preview;
    if (!light)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < 3 * size; i++)
        light[i] = light_of(((double)job->pixels[i] - low) / span);
    options.range = &none; // is in the light
    const float *const planes[3] = {light, light + size, light + 2 * size};
    const enum weft_result res =
        preview_save_colour(&options, job->setup->engine.cpu.threads, job->geometry.width,
                            job->geometry.height, planes, range);
    free(light);
    return res;
}

static enum weft_result write_preview(struct slice_job *job)
{
    const struct preview_options preview = slice_preview_options(job);
    if (slice_shows_vector(job, job->preview_range))
        return write_colours(job, &preview);
    return preview_save(&preview, job->setup->colour_map, job->geometry.width, job->geometry.height,
                        job->pixels, job->preview_range);
}

static enum weft_result write_errors(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    struct annotation annotation = job->annotation;
    char bound[40] = "", kept[300];
    snprintf(kept, sizeof kept, "%.290s", job->annotation.caption);
    if (isfinite(job->error_bound))
        snprintf(bound, sizeof bound, ", bound %.3g", job->error_bound);
    if (!o[SLICE_TITLE].given)
        snprintf(annotation.title, sizeof annotation.title, "error of %.380s",
                 job->annotation.title);
    snprintf(annotation.caption, sizeof annotation.caption, "at most %.3g, RMS %.3g%s; %s",
             job->error.maximum, job->error.rms, bound, kept);
    const struct error_image_save_params params = {.output = &o[SLICE_ERROR_IMAGE],
                                                   .no_clobber = o[SLICE_NO_CLOBBER].given,
                                                   .threads = job->setup->engine.cpu.threads,
                                                   .annotation = &annotation};
    return error_image_save(&job->errors, &params, job->errors_range);
}

enum weft_result slice_save(struct slice_job *job)
{
    double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (job->stream)
        res = slice_stream_end(job);
    else if (job->output)
        res = slice_write_exr(job);
    if (res == WEFT_OK && job->preview)
        res = write_preview(job);
    if (res == WEFT_OK && job->errors.plane)
        res = write_errors(job);
    job->write_seconds = report_now_seconds() - start;
    return res;
}
