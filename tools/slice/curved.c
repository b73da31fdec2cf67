// SPDX-License-Identifier: BSD-3-Clause
// Slices that lie on no plane: their pixels are points, of an image of positions or along a line.
#include "tools/slice/stages.h"

#include <math.h>

#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/slice/report.h"

bool slice_is_curved(const struct slice_setup *setup)
{
    return setup->option[SLICE_POSITIONS].given || setup->option[SLICE_ALONG].given;
}

// ---- options ------------------------------------------------------------------------------------

// What is of planes, or of engines that slice planes.
static const char *find_plane_option(const struct option_value *o)
{
    static const struct {
        enum slice_option option;
        const char *name;
    } options[] = {{SLICE_AXIS, "--axis"},
                   {SLICE_AT, "--at"},
                   {SLICE_ORIGIN, "--origin"},
                   {SLICE_U, "--u"},
                   {SLICE_V, "--v"},
                   {SLICE_UP, "--up"},
                   {SLICE_FLIP, "--flip"},
                   {SLICE_BOX, "--box"},
                   {SLICE_FRAMES, "--frames"},
                   {SLICE_SLAB, "--slab"},
                   {SLICE_LAYOUT, "--layout"},
                   {SLICE_SOURCE, "--source"},
                   {SLICE_LOOKUP, "--lookup"},
                   {SLICE_HARDWARE, "--hardware"},
                   {SLICE_WITHOUT, "--without"},
                   {SLICE_CLAMP, "--clamp"},
                   {SLICE_MAX_ERROR, "--max-error"},
                   {SLICE_PASSES + PASS_PROFILE, "--profile"},
                   {SLICE_ENGINE + ENGINE_CONTEXT, "--context"},
                   {SLICE_EXPLAIN, "--explain"},
                   {SLICE_VERIFY, "--verify"}};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        if (o[options[i].option].given)
            return options[i].name;
    return NULL;
}

enum weft_result slice_check_curve(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    const struct option_value *engine = &o[SLICE_ENGINE + ENGINE_ENGINE];
    if (!slice_is_curved(setup)) {
        if (!o[SLICE_WIDTH].given)
            return WEFT_OK;
        report_error("--width is how wide a slice --along a line is; --size WxH is the picture's");
        return WEFT_ERR_ARGUMENT;
    }
    const char *const which = o[SLICE_ALONG].given ? "--along" : "--positions";
    const char *plane = find_plane_option(o);
    if (o[SLICE_POSITIONS].given && o[SLICE_ALONG].given)
        report_error("--positions and --along exclude each other");
    else if (o[SLICE_ALONG].given != o[SLICE_WIDTH].given)
        report_error("--along FILE and --width W go together");
    else if (o[SLICE_WIDTH].given && !(o[SLICE_WIDTH].number[0] > 0.0))
        report_error("--width %s: a length above 0", o[SLICE_WIDTH].text);
    else if (o[SLICE_POSITIONS].given && setup->framing.size.longer)
        report_error("--size %s: of --positions it is WxH, and tells what their image must be",
                     o[SLICE_SIZE].text);
    else if (plane)
        report_error("%s is of planes, and not of %s", plane, which);
    else if (engine->given && engine->integer[0] == 1 + WEFT_ENGINE_GL)
        report_error("%s is of the CPU engine, and not of --engine gl", which);
    else if (setup->divided.is)
        report_error("%s is not divided; run it without mpirun", which);
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

// ---- the pixels ---------------------------------------------------------------------------------

static enum weft_result load_line(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    const struct framing_size *size = &job->setup->framing.size;
    const int width = size->longer ? size->longer : size->side[0];
    enum weft_result res = curve_load_line(o[SLICE_ALONG].text, o[SLICE_WIDTH].number[0], width,
                                           size->side[1], &job->curve);
    if (res != WEFT_OK || !size->longer || job->curve.height <= size->longer)
        return res;
    curve_clear(&job->curve);
    return curve_load_line(o[SLICE_ALONG].text, o[SLICE_WIDTH].number[0], 0, size->longer,
                           &job->curve);
}

enum weft_result slice_load_curve(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    const struct framing_size *size = &job->setup->framing.size;
    const double start = report_now_seconds();
    const enum weft_result res =
        o[SLICE_ALONG].given
            ? load_line(job)
            : curve_load_positions(o[SLICE_POSITIONS].text, job->setup->engine.cpu.threads,
                                   size->side[0], size->side[1], &job->curve);
    job->geometry =
        (struct weft_slice_geometry){.width = job->curve.width, .height = job->curve.height};
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

static void take_report(struct slice_job *job, const weft_points *points,
                        const struct weft_points_report *r)
{
    const struct weft_points_info *info = weft_points_get_info(points);
    struct weft_slice_report *sum = &job->report;
    job->slice_params.kernel = info->kernel; // a default is filled in
    sum->read_seconds += r->read_seconds;
    sum->layout_seconds += r->sort_seconds;
    sum->pass_seconds += r->pass_seconds;
    sum->bricks_read += r->bricks_read;
    sum->exact_pixels += r->exact_points;
    sum->peak_bytes = r->peak_bytes > sum->peak_bytes ? r->peak_bytes : sum->peak_bytes;
    job->bad_positions = r->bad_positions;
    job->outside =
        job->source == job->setup->source || r->outside < job->outside ? r->outside : job->outside;
    for (int i = 0; i < info->output_count; i++)
        job->output_bound[i] = weft_bound_compute(&info->bound[i], &r->values).total;
}

enum weft_result slice_compute_points(struct slice_job *job)
{
    const struct slice_setup *setup = job->setup;
    const size_t count = (size_t)job->curve.width * (size_t)job->curve.height;
    struct weft_points_report report;
    weft_points *points = NULL;
    enum weft_result res = weft_points_create(
        weft_points_params(.volume = job->volume, .kernel = setup->kernel,
                           .space = (enum weft_space)setup->option[SLICE_SPACE].integer[0],
                           .derivative = setup->quantities.derivative,
                           .derivative_count = job->derived_count, .sums = setup->engine.sums,
                           .cpu = setup->engine.cpu, .memory_bytes = slice_memory(setup),
                           .log = report_log()),
        &points);
    if (res == WEFT_OK)
        res = weft_points_run(
            points,
            weft_points_run_params(.count = count,
                                   .position = (const double(*)[3])job->curve.position,
                                   .out = slice_planes(job), .stride = count,
                                   .measure = setup->option[SLICE_JSON].given,
                                   .progress = report_progress("sampling")),
            &report);
    if (res == WEFT_OK)
        take_report(job, points, &report);
    weft_points_destroy(&points);
    if (res == WEFT_OK)
        res = slice_make_channels(job);
    if (res == WEFT_OK && setup->option[SLICE_JSON].given)
        slice_bound_channels(job, job->output_bound);
    job->made = true;
    return res;
}

// ---- told ---------------------------------------------------------------------------------------

void slice_warn_of_positions(const struct slice_job *job)
{
    const unsigned long long count =
        (unsigned long long)job->curve.width * (unsigned long long)job->curve.height;
    if (job->bad_positions)
        report_warning("%llu of %llu positions are not finite, or beyond index range: NaN",
                       (unsigned long long)job->bad_positions, count);
    if (job->outside == count - job->bad_positions && job->outside)
        report_warning("no position is near an active voxel: all that have one are background");
}

json_t *slice_curve_json(const struct slice_job *job)
{
    const struct slice_setup *setup = job->setup;
    const struct option_value *o = setup->option;
    char kernel[KERNELS_TEXT];
    weft_kernel_format(&job->slice_params.kernel, kernel, sizeof kernel);
    json_t *root = json_pack(
        "{s:o,s:s,s:s,s:s,s:i,s:i,s:o,s:o,s:o,s:o,s:o}", "kernel", json_text(kernel), "space",
        weft_space_names[o[SLICE_SPACE].integer[0]], "engine", "cpu", "sums",
        weft_sums_names[setup->engine.sums], "width", job->curve.width, "height", job->curve.height,
        "bad_positions", json_count(job->bad_positions), "outside", json_count(job->outside),
        "bricks_read", json_count(job->report.bricks_read), "bytes",
        run_report_bytes("peak", job->report.peak_bytes), "seconds", json_null());
    json_object_set_new(root, o[SLICE_ALONG].given ? "along" : "positions",
                        json_text(o[o[SLICE_ALONG].given ? SLICE_ALONG : SLICE_POSITIONS].text));
    if (o[SLICE_ALONG].given)
        json_object_set_new(root, "length", json_number(job->curve.length));
    json_object_set_new(root, "channels", slice_channels_json(job));
    if (job->output)
        json_object_set_new(root, "file", json_null());
    if (job->preview)
        json_object_set_new(root, "preview", json_null());
    return root;
}
