// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/report.h"
#include "tools/slice/save.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/json.h"
#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/slice/budget.h"
#include "tools/slice/stages.h"

static uint64_t sum_cells(const struct weft_slice_plan_info *plan, bool laid_out)
{
    uint64_t sum = 0;
    for (int i = 0; i < plan->tile_count; i++)
        sum += laid_out ? plan->tiles[i].cells_laid_out : plan->tiles[i].cells;
    return sum;
}

// ---- EXR attributes -----------------------------------------------------------------------------

// 17 digits: the geometry can be repeated to the last bit.
static void add_point(struct weft_metadata *list, size_t *count, const char *key, const double p[3])
{
    run_report_add(list, count, key, "%.17g,%.17g,%.17g", p[0], p[1], p[2]);
}

static size_t passes_attributes(const struct slice_job *job, struct weft_metadata *out)
{
    const struct weft_pass_plan_info *plan = weft_pass_plan_get_info(job->passes);
    const struct weft_slice_report *r = &job->report;
    char summary[PASS_TEXT];
    size_t count = 0;
    run_report_add(out, &count, "plan", "%s", pass_plan_summary(job->passes, summary));
    run_report_add(out, &count, "profile", "%s", plan->profile.name);
    run_report_add(out, &count, "technique", "%s", weft_technique_names[plan->technique]);
    run_report_add(out, &count, "source_range", "%.17g,%.17g", r->low, r->high);
    run_report_add(out, &count, "bound", "%.3g", job->bound.total);
    return count;
}

// Cut where there is no more room.
static void append(char *list, size_t size, const char *name)
{
    if (list[0])
        strncat(list, ",", size - strlen(list) - 1);
    strncat(list, name, size - strlen(list) - 1);
}

static void add_names(const struct slice_job *job, struct weft_metadata *out, size_t *count)
{
    const struct slice_setup *setup = job->setup;
    const struct weft_quantities *list = &setup->quantities;
    char grids[192] = "", quantities[192] = "";
    for (int i = 0; i < setup->source_count; i++)
        if (setup->source[i].component == 0 && setup->source[i].grid[0])
            append(grids, sizeof grids, setup->source[i].grid);
    for (int i = 0; i < list->count; i++)
        append(quantities, sizeof quantities, weft_quantity_names[list->quantity[i]]);
    run_report_add(out, count, "grid", "%s",
                   setup->source_count > 1 && grids[0] ? grids
                                                       : weft_volume_get_info(job->volume)->name);
    if (job->derived_count)
        run_report_add(out, count, "quantity", "%s", quantities);
}

// Of points: there is no plan.
static size_t curve_attributes(const struct slice_job *job, struct weft_metadata *out)
{
    const struct option_value *o = job->setup->option;
    const bool along = o[SLICE_ALONG].given;
    char kernel[128];
    size_t count = 0;
    weft_kernel_format(&job->slice_params.kernel, kernel, sizeof kernel);
    run_report_add(out, &count, "version", "%s", weft_version());
    run_report_add(out, &count, "volume", "%s", paths_base_name(job->input));
    add_names(job, out, &count);
    run_report_add(out, &count, "kernel", "%s", kernel);
    run_report_add(out, &count, "space", "%s", weft_space_names[o[SLICE_SPACE].integer[0]]);
    run_report_add(out, &count, "size", "%dx%d", job->geometry.width, job->geometry.height);
    run_report_add(out, &count, along ? "along" : "positions", "%s",
                   paths_base_name(o[along ? SLICE_ALONG : SLICE_POSITIONS].text));
    if (along)
        run_report_add(out, &count, "width", "%.17g", o[SLICE_WIDTH].number[0]);
    run_report_add_renderer(out, &count, NULL);
    count += engine_attributes(&job->setup->engine, job->setup->engine.sums, out + count);
    return count;
}

static void add_slab(const struct slice_job *job, struct weft_metadata *out, size_t *count)
{
    const struct option_value *o = job->setup->option;
    if (job->slab.cuts)
        run_report_add(out, count, "slab", "%s of %.17g in %d cuts, %.3g voxels apart",
                       weft_combine_names[o[SLICE_COMBINE].integer[0]], o[SLICE_SLAB].number[0],
                       job->slab.cuts, job->slab.voxels);
}

// Returns how many.
static size_t list_attributes(const struct slice_job *job, struct weft_metadata *out)
{
    if (!job->plan)
        return curve_attributes(job, out);
    const struct weft_slice_plan_info *plan = weft_slice_plan_get_info(job->plan);
    const struct weft_slice_geometry *g = &plan->geometry, *index = &plan->index_geometry;
    char kernel[128];
    weft_kernel_format(&plan->kernel, kernel, sizeof kernel);
    size_t count = 0;
    run_report_add(out, &count, "version", "%s", weft_version());
    run_report_add(out, &count, "volume", "%s", paths_base_name(job->input));
    add_names(job, out, &count);
    run_report_add(out, &count, "kernel", "%s", kernel);
    run_report_add(out, &count, "space", "%s", weft_space_names[plan->space]);
    run_report_add(out, &count, "size", "%dx%d", g->width, g->height);
    add_point(out, &count, "origin", g->origin);
    add_point(out, &count, "u", g->u);
    add_point(out, &count, "v", g->v);
    add_slab(job, out, &count);
    add_point(out, &count, "index_origin", index->origin);
    add_point(out, &count, "index_u", index->u);
    add_point(out, &count, "index_v", index->v);
    if (job->passes)
        count += passes_attributes(job, out + count);
    else if (job->hardware)
        run_report_add(out, &count, "plan",
                       "hardware filtering, %d fetches per pixel, error bound %.3g of the range",
                       job->hardware->fetches_per_pixel, job->hardware->bound.e3);
    else
        run_report_add(out, &count, "plan", "%s layout, %d fetches per pixel, error bound %.3g",
                       weft_layout_name(plan->layout), plan->fetches_per_pixel,
                       plan->output[0].error_bound);
    run_report_add_renderer(out, &count,
                            plan->engine == WEFT_ENGINE_GL ? job->setup->context : NULL);
    if (plan->engine == WEFT_ENGINE_CPU)
        count += engine_attributes(&job->setup->engine, plan->sums, out + count);
    return count;
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *geometry_json(const struct weft_slice_geometry *g)
{
    return json_pack("{s:o,s:o,s:o,s:i,s:i}", "origin", json_numbers(g->origin, 3), "u",
                     json_numbers(g->u, 3), "v", json_numbers(g->v, 3), "width", g->width, "height",
                     g->height);
}

static json_t *tiles_json(const struct weft_slice_plan_info *plan)
{
    json_t *tiles = json_array();
    for (int i = 0; i < plan->tile_count; i++) {
        const struct weft_slice_tile *t = &plan->tiles[i];
        json_array_append_new(tiles,
                              json_pack("{s:i,s:i,s:i,s:i,s:o,s:o,s:o,s:o}", "x", t->x, "y", t->y,
                                        "width", t->width, "height", t->height, "bricks_read",
                                        json_count(t->bricks_read), "cells", json_count(t->cells),
                                        "cells_laid_out", json_count(t->cells_laid_out), "bytes",
                                        run_report_bytes("memory", t->memory_bytes)));
    }
    return tiles;
}

static json_t *savings_json(const struct slice_job *job)
{
    const struct weft_slice_plan_info *plan = weft_slice_plan_get_info(job->plan);
    const struct weft_slice_report *r = &job->report;
    json_t *names = json_array();
    for (int i = 0; weft_saving_names[i]; i++)
        if (plan->savings & 1u << i)
            json_array_append_new(names, json_text(weft_saving_names[i]));
    return json_pack("{s:o,s:i,s:i,s:o,s:o,s:o,s:o}", "kinds", names, "summed_axis",
                     plan->summed_axis, "summed_taps", plan->summed_taps, "source_texels",
                     json_count(plan->source_texels), "cells_constant",
                     json_count(r->cells_constant), "cells_smooth", json_count(r->cells_smooth),
                     "fetches", json_count(r->fetches));
}

// What of the grid's values a float does not hold.
static void set_values(json_t *root, const struct weft_volume_info *info)
{
    json_object_set_new(root, "values_rounded", json_count(info->values_rounded));
    json_object_set_new(root, "largest_rounding", json_number(info->largest_rounding));
    json_object_set_new(root, "values_infinite", json_count(info->values_infinite));
    json_object_set_new(root, "values_tiny", json_count(info->values_tiny));
}

static void set_plan(json_t *root, const struct slice_job *job)
{
    const struct weft_slice_plan_info *plan = weft_slice_plan_get_info(job->plan);
    char kernel[KERNELS_TEXT];
    weft_kernel_format(&plan->kernel, kernel, sizeof kernel);
    json_object_set_new(root, "grid", json_text(weft_volume_get_info(job->volume)->name));
    set_values(root, weft_volume_get_info(job->volume));
    json_object_set_new(root, "kernel", json_text(kernel));
    json_object_set_new(root, "space", json_text(weft_space_names[plan->space]));
    engine_set_json(root, &job->setup->engine, plan->engine, plan->sums);
    json_object_set_new(root, "geometry", geometry_json(&plan->geometry));
    json_object_set_new(root, "index_geometry", geometry_json(&plan->index_geometry));
    json_object_set_new(root, "misses_volume", json_boolean(plan->misses_volume));
    json_object_set_new(root, "error_rounding",
                        json_number(plan->output[0].bound.absolute_rounding));
    if (plan->kernel.prefiltered)
        json_object_set_new(root, "prefilter_overlap", json_integer(plan->prefilter_overlap));
    if (job->choice.plan)
        json_object_set_new(root, "budget", slice_budget_json(job));
    if (job->passes) {
        json_object_set_new(root, "pass_plan", pass_plan_json(job->passes));
        return;
    }
    if (job->hardware)
        json_object_set_new(root, "hardware", slice_hardware_json(job->hardware));
    json_object_set_new(root, "source", json_text(weft_source_format_name(plan->source)));
    json_object_set_new(root, "lookup", json_text(weft_lookup_names[plan->lookup]));
    json_object_set_new(root, "savings", savings_json(job));
    json_object_set_new(root, "error_absolute", json_number(plan->output[0].error_absolute));
    json_object_set_new(root, "error_beyond", json_number(plan->output[0].error_beyond));
    json_object_set_new(root, "layout", json_text(weft_layout_name(plan->layout)));
    json_object_set_new(root, "fetches_per_pixel", json_integer(plan->fetches_per_pixel));
    json_object_set_new(root, "relative_bound", json_number(plan->output[0].error_bound));
    json_object_set_new(root, "bricks_read", json_count(plan->bricks_read));
    json_object_set_new(root, "cells", json_count(sum_cells(plan, false)));
    json_object_set_new(root, "cells_laid_out", json_count(sum_cells(plan, true)));
    json_object_set_new(root, "bytes", run_report_bytes("tiles", plan->memory_bytes));
    json_object_set_new(root, "tiles", tiles_json(plan));
}

static double mpixels_per_second(const struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    return 1e-6 * g->width * g->height / job->report.pass_seconds;
}

void slice_stages(const struct slice_job *job, struct run_stage out[SLICE_STAGES])
{
    const struct weft_slice_report *r = &job->report;
    const struct run_stage stages[SLICE_STAGES] = {
        {"open", job->open_seconds},       {"plan", job->plan_seconds},
        {"context", job->context_seconds}, {"read", r->read_seconds},
        {"layout", r->layout_seconds},     {"upload", r->upload_seconds},
        {"passes", r->pass_seconds},       {"readback", r->readback_seconds},
        {"verify", job->verify_seconds},   {"write", job->write_seconds},
    };
    memcpy(out, stages, sizeof stages);
}

static json_t *error_json(const struct slice_job *job)
{
    const struct weft_verify_report *e = &job->error;
    json_t *object = run_report_verify_error(
        e, e->pixels_checked ? (const int32_t[]){e->at_x, e->at_y} : NULL, 2);
    json_object_update_new(
        object, json_pack("{s:o,s:o,s:o,s:o}", "relative_max", json_number(e->relative_maximum),
                          "magnitude", json_number(e->magnitude), "value", json_number(e->at_value),
                          "reference", json_number(e->at_reference)));
    return object;
}

static void set_passes_run(json_t *root, const struct slice_job *job)
{
    const struct weft_slice_report *r = &job->report;
    json_object_set_new(root, "source_range",
                        json_pack("{s:o,s:o,s:o}", "low", json_number(r->low), "high",
                                  json_number(r->high), "clamped", json_count(r->clamped)));
    json_object_set_new(root, "bound", json_number(job->bound.total));
    json_object_set_new(root, "bound_parts", pass_bound_json(&job->bound));
    json_object_set_new(root, "rectangles", json_integer(r->rectangles));
}

// What is saved later has its place here.
static void set_run(json_t *root, const struct slice_job *job)
{
    const struct weft_slice_report *r = &job->report;
    const struct weft_footprint_info *reach =
        weft_footprint_get_info(weft_slice_plan_get_footprint(job->plan));
    json_object_set_new(root, "passes", json_integer(r->passes));
    const struct slice_divided *divided = &job->setup->divided;
    const bool of_parts = divided->is && !divided->frames;
    json_object_set_new(root, "bricks_read",
                        json_count(of_parts ? job->report.bricks_read : reach->bricks_read));
    if (job->passes)
        set_passes_run(root, job);
    else
        json_object_set_new(root, "exact_pixels", json_count(r->exact_pixels));
    json_t *bytes = json_object_get(root, "bytes");
    if (!bytes)
        json_object_set_new(root, "bytes", bytes = json_object());
    json_object_set_new(bytes, "uploaded", json_count(r->uploaded_bytes));
    json_object_set_new(bytes, "peak", json_count(r->peak_bytes));
    json_object_set_new(root, "seconds", json_null());
    json_object_set_new(root, "mpixels_per_second", json_number(mpixels_per_second(job)));
    json_object_set_new(root, "minimum", json_number(r->minimum));
    json_object_set_new(root, "maximum", json_number(r->maximum));
    json_object_set_new(root, "not_finite", json_count(r->not_finite));
    if (job->setup->context)
        json_object_set_new(root, "context", run_report_context(job->setup->context));
    if (job->output)
        json_object_set_new(root, "file", json_null());
    if (job->preview)
        json_object_set_new(root, "preview", json_null());
    if (!job->setup->option[SLICE_VERIFY].given)
        return;
    json_object_set_new(root, "error", error_json(job));
    if (!job->passes)
        json_object_set_new(root, "bound", json_number(job->error.bound));
}

// "value", "x", "xy": a derivative along the axes of index space.
static const char *derivative_name(const struct weft_derivative *d, char out[8])
{
    int end = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < d->along[axis] && end < 7; i++)
            out[end++] = "xyz"[axis];
    out[end] = 0;
    return end ? out : strcpy(out, "value");
}

static json_t *output_json(const struct slice_job *job, int index)
{
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const struct weft_slice_plan_info *plan = weft_slice_plan_get_info(job->plan);
    const struct weft_derivative value = {{0, 0, 0}};
    char name[8];
    json_t *out = json_pack(
        "{s:o,s:i,s:s}", "grid", json_text(info->name), "component", info->component, "derivative",
        derivative_name(job->derived_count ? &job->setup->quantities.derivative[index] : &value,
                        name));
    if (!job->passes)
        json_object_set_new(out, "relative_bound", json_number(plan->output[index].error_bound));
    if (job->verified) {
        const struct weft_verify_report *e = &job->output_error[index];
        json_object_set_new(out, "error", run_report_verify_error(e, NULL, 0));
        json_object_set_new(out, "bound", json_number(job->output_bound[index]));
    }
    return out;
}

void slice_tell_source(struct slice_job *job)
{
    if (slice_is_plain(job->setup) || !job->setup->option[SLICE_JSON].given)
        return;
    if (!job->outputs)
        job->outputs = json_array();
    const int count = job->derived_count ? job->derived_count : 1;
    for (int i = 0; i < count; i++)
        json_array_append_new(job->outputs, output_json(job, i));
}

static json_t *slab_json(const struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    return json_pack("{s:o,s:s,s:i,s:o,s:o,s:o}", "thickness", json_number(o[SLICE_SLAB].number[0]),
                     "combine", weft_combine_names[o[SLICE_COMBINE].integer[0]], "cuts",
                     job->slab.cuts, "spacing", json_number(job->slab.spacing), "spacing_voxels",
                     json_number(job->slab.voxels), "normal", json_numbers(job->slab.normal, 3));
}

static json_t *slice_json(struct slice_job *job)
{
    if (slice_is_curved(job->setup))
        return slice_curve_json(job);
    json_t *root = json_object();
    if (job->setup->sweep.given)
        json_object_update_new(root, json_pack("{s:o,s:[o]}", "frame", json_integer(job->frame),
                                               "input", json_text(job->input)));
    set_plan(root, job);
    if (job->slab.cuts)
        json_object_set_new(root, "slab", slab_json(job));
    if (!slice_is_plain(job->setup)) {
        json_object_set_new(root, "outputs", job->outputs);
        job->outputs = NULL;
        json_object_set_new(root, "channels", slice_channels_json(job));
    }
    if (job->made)
        set_run(root, job);
    else
        json_object_set_new(root, "plan", json_text(weft_slice_plan_get_info(job->plan)->text));
    return root;
}

void slice_tell(struct slice_job *job)
{
    if (job->setup->option[SLICE_JSON].given)
        job->json = slice_json(job);
    slice_list_attributes(job);
    slice_annotate(job);
}

void slice_list_attributes(struct slice_job *job)
{
    if (job->output)
        job->attribute_count = list_attributes(job, job->attributes);
}

// Of a frame, whose names have its number.
static json_t *outputs_json(const struct slice_job *job)
{
    json_t *list = json_files(job->output);
    if (job->preview)
        json_array_append_new(list, json_file(job->preview));
    return list;
}

void slice_tell_saved(struct slice_job *job)
{
    struct run_stage stages[SLICE_STAGES];
    slice_stages(job, stages);
    job->seconds = report_now_seconds() - job->start;
    if (!job->json || !job->made)
        return;
    json_object_set_new(job->json, "seconds",
                        run_report_seconds(stages, SLICE_STAGES, job->seconds));
    if (job->output)
        json_object_set_new(job->json, "file", saved_json(&job->saved));
    if (job->preview)
        json_object_set_new(job->json, "preview",
                            run_report_preview(job->preview, job->preview_range));
    if (job->errors.plane)
        json_object_set_new(
            job->json, "error_image",
            run_report_preview(job->setup->option[SLICE_ERROR_IMAGE].text, job->errors_range));
    if (job->setup->sweep.given)
        json_object_set_new(job->json, "output", outputs_json(job));
}

// ---- text ---------------------------------------------------------------------------------------

static void print_error(const struct weft_verify_report *e)
{
    printf("verified: %llu of %llu pixels against double precision\n"
           "max error: %.3g (%.3g of the largest |voxel| in reach) at pixel (%d, %d): %.9g instead "
           "of %.9g\n"
           "rms error: %.3g\n",
           (unsigned long long)e->pixels_checked, (unsigned long long)e->pixels_total, e->maximum,
           e->relative_maximum, e->at_x, e->at_y, e->at_value, e->at_reference, e->rms);
    if (e->not_finite_mismatches)
        printf("finite on one side only: %llu pixels\n",
               (unsigned long long)e->not_finite_mismatches);
}

static void print_bound(const struct slice_job *job)
{
    if (!job->by_passes) {
        printf("bound: %.3g\n", job->error.bound);
        return;
    }
    const struct weft_slice_report *r = &job->report;
    char text[PASS_TEXT];
    printf("bound: %s, for voxels from %.9g to %.9g\n", pass_bound_format(&job->bound, text),
           r->low, r->high);
}

static void note_times(const struct slice_job *job)
{
    const struct weft_slice_report *r = &job->report;
    report_note("open %.3f s, plan %.3f, context %.3f, read %.3f, layout %.3f, upload %.3f, passes "
                "%.3f (%.1f Mpixel/s), read-back %.3f, verify %.3f, write %.3f, total %.3f s",
                job->open_seconds, job->plan_seconds, job->context_seconds, r->read_seconds,
                r->layout_seconds, r->upload_seconds, r->pass_seconds, mpixels_per_second(job),
                r->readback_seconds, job->verify_seconds, job->write_seconds, job->seconds);
    report_note("values from %.9g to %.9g, peak of voxels, layouts and GL %llu bytes", r->minimum,
                r->maximum, (unsigned long long)r->peak_bytes);
}

bool slice_is_verified(const struct slice_job *job)
{
    return !job->made || !job->setup->option[SLICE_VERIFY].given ||
           report_verdict("the slice", job->error.maximum, job->error_bound,
                          job->error.not_finite_mismatches);
}

static void print_heading(const struct slice_job *job)
{
    if (job->setup->sweep.given)
        printf("frame %lld\n", (long long)job->frame);
    if (!job->made && !slice_is_plain(job->setup))
        printf("channel %s%s\n", job->source->name, job->derived_count ? ", quantities" : "");
}

void slice_print_explained(const struct slice_job *job)
{
    const struct weft_slice_plan_info *plan = weft_slice_plan_get_info(job->plan);
    const char *text = plan->text;
    size_t size = strlen(text);
    char engine[ENGINE_TEXT];
    print_heading(job);
    if (job->choice.plan)
        slice_budget_print(job);
    printf("%s\n", engine_format(&job->setup->engine, plan->engine, plan->sums, engine));
    printf("%s%s", text, size && text[size - 1] == '\n' ? "" : "\n");
    if (job->passes)
        pass_plan_print(job->passes);
    if (job->hardware)
        printf("%s", job->hardware->text);
}

// All frames' previews have one range, which is told before the first.
void slice_print_made(const struct slice_job *job)
{
    if (job->preview && !job->setup->sweep.given)
        run_report_print_preview(job->preview, job->preview_range);
    if (job->errors.plane)
        run_report_print_preview(job->setup->option[SLICE_ERROR_IMAGE].text, job->errors_range);
    if (job->setup->option[SLICE_VERIFY].given) {
        print_heading(job);
        print_error(&job->error);
        print_bound(job);
    }
    saved_print(job->output, &job->saved);
    note_times(job);
}
