// SPDX-License-Identifier: BSD-3-Clause
// weft slice: a planar cut through a VDB volume as EXR and PNG.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/attributes.h"
#include "tools/common/kernels.h"
#include "tools/methods/plan_options.h"
#include "tools/draw/preview.h"
#include "tools/common/report.h"
#include "tools/slice/budget.h"
#include "tools/verbs/verb.h"

static const char *const axes[] = {"x", "y", "z", NULL};

static const char *const png_ending[] = {".png", NULL};
static const char *const exr_ending[] = {".exr", NULL};
static const struct option_spec options[SLICE_OPTION_COUNT] = {
    [SLICE_OUTPUT] = {.name = "output",
                      'o',
                      OPTION_OUTPUT,
                      "OUT.exr",
                      "the slice: one float channel, Y, with attributes that tell how it was made",
                      exr_ending},
    [SLICE_PREVIEW] =
        {.name = "preview", 0, OPTION_OUTPUT, "OUT.png", "the slice as 8-bit PNG", png_ending},
    [SLICE_GRID] = {.name = "grid",
                    0,
                    OPTION_TEXT,
                    "NAME",
                    "which grid of the file (default: the first scalar one)"},
    [SLICE_KERNEL] = {.name = "kernel",
                      0,
                      OPTION_TEXT,
                      "NAME[:p,q]|table:FILE",
                      "the reconstruction kernel (default catmull-rom), NAME+unit for weights "
                      "that add up to 1, table:FILE for one's own; 'help' lists them"},
    [SLICE_NORMALISE] = KERNELS_NORMALISE_OPTION,
    [SLICE_SIZE] = {.name = "size",
                    0,
                    OPTION_PIXELS,
                    "WxH",
                    "pixels (default: 1024 along the longer edge, square pixels)"},
    [SLICE_AXIS] = {.name = "axis",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "cut across this axis, the active box and half a voxel around it "
                    "(default z)",
                    axes},
    [SLICE_AT] = {.name = "at",
                  0,
                  OPTION_NUMBER,
                  "COORD",
                  "where on that axis (default: the middle of the active box)"},
    [SLICE_ORIGIN] = {.name = "origin",
                      0,
                      OPTION_POINT,
                      "X,Y,Z",
                      "instead of --axis and --at: the corner where pixel (0, 0) lies, with --u "
                      "and --v"},
    [SLICE_U] = {.name = "u", 0, OPTION_POINT, "X,Y,Z", "the edge along the rows"},
    [SLICE_V] = {.name = "v", 0, OPTION_POINT, "X,Y,Z", "the edge down the columns"},
    [SLICE_SPACE] = {.name = "space",
                     0,
                     OPTION_CHOICE,
                     NULL,
                     "what the coordinates above mean (default world)",
                     weft_space_names},
    [SLICE_CONTEXT] = {.name = "context",
                       0,
                       OPTION_TEXT,
                       "auto|osmesa|egl",
                       "where OpenGL runs (default auto: a GPU through EGL, else OSMesa, else "
                       "EGL in software)"},
    [SLICE_LAYOUT] = {.name = "layout",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how voxels lie in the texture buffer: fastest with 4 times the memory, "
                      "a row of four at a time, one by one (default auto, by memory)",
                      weft_layout_names},
    [SLICE_SOURCE] = {.name = "source",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how voxels are stored there (default 32f); the others hold the range of the "
                      "voxels in reach, or --source-range",
                      weft_source_format_names},
    [SLICE_LOOKUP] = {.name = "lookup",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how the kernel's weights are had: exactly (default), or from tiles of "
                      "--resolution M samples an axis",
                      weft_lookup_names},
    [SLICE_WITHOUT] = {.name = "without",
                       0,
                       OPTION_TEXT,
                       "NAME,...",
                       "do without what a scene need not pay for: constant, axis, separable, "
                       "smooth, or all; to compare"},
    [SLICE_CLAMP] = {.name = "clamp",
                     0,
                     OPTION_FLAG,
                     NULL,
                     "clamp each pixel to the range of the voxels next to it: no ringing"},
    [SLICE_MAX_ERROR] = {.name = "max-error",
                         0,
                         OPTION_TEXT,
                         "E|8bit|12bit|16bit",
                         "take the cheapest method whose error bound is at most E, or half a code "
                         "of the voxels' range; with --profile, the cheapest plan on that. "
                         "--explain lists what was considered"},
    [SLICE_MEMORY] = {.name = "memory",
                      0,
                      OPTION_BYTES,
                      "BYTES",
                      "bound for voxels, layouts and GL memory, K, M or G for powers of 1024 "
                      "(default 1G); the work is cut into tiles that fit"},
    PASS_OPTIONS(SLICE_PASSES, "slice in passes, as hardware of limited precision does"),
    [SLICE_RANGE] = {.name = "range",
                     0,
                     OPTION_RANGE,
                     "LO,HI",
                     "values shown as first and last colour of the preview (default: smallest "
                     "and largest)"},
    [SLICE_COLOUR_MAP] = {.name = "colour-map",
                          0,
                          OPTION_TEXT,
                          "NAME",
                          "colours of the preview (default grey); 'help' lists them"},
    [SLICE_EXPLAIN] =
        {.name = "explain", 0, OPTION_FLAG, NULL, "print the plan and exit: no OpenGL, no output"},
    [SLICE_VERIFY] = {.name = "verify",
                      0,
                      OPTION_FLAG,
                      NULL,
                      "recompute in double precision (a random sample of the pixels when all "
                      "would take over 10 s) and print the largest and RMS difference; fails if "
                      "that is beyond the plan's bound; with -o, read the file back and compare "
                      "every value"},
    [SLICE_JSON] = {.name = "json",
                    0,
                    OPTION_FLAG,
                    NULL,
                    "print geometry, plan, memory, times and errors as JSON on stdout"},
    [SLICE_NO_CLOBBER] =
        {.name = "no-clobber", 0, OPTION_FLAG, NULL, "refuse to replace an output"},
    [SLICE_QUIET] =
        {.name = "quiet", 'q', OPTION_FLAG, NULL, "only errors, and what was asked for"},
    [SLICE_VERBOSE] = {.name = "verbose", 'v', OPTION_FLAG, NULL, "say what is done"},
};

// ---- checks that need no file contents ----------------------------------------------------------

static struct preview_options preview_options(const struct slice_job *job)
{
    const struct option_value *o = job->option;
    return (struct preview_options){.input = job->input,
                                    .output = &o[SLICE_OUTPUT],
                                    .preview = &o[SLICE_PREVIEW],
                                    .range = &o[SLICE_RANGE],
                                    .colour_map = &o[SLICE_COLOUR_MAP],
                                    .no_clobber = o[SLICE_NO_CLOBBER].given};
}

// Of the options that say how passes are planned, two go with fused slices too.
static const char *passes_conflict(const struct option_value *o)
{
    const bool profile = o[SLICE_PASSES + PASS_PROFILE].given;
    const bool chosen = o[SLICE_MAX_ERROR].given;
    const bool fused = o[SLICE_SOURCE].given || o[SLICE_LOOKUP].given;
    const bool sampled = o[SLICE_LOOKUP].given && o[SLICE_LOOKUP].integer[0] != 0;
    const bool stored = o[SLICE_SOURCE].given && o[SLICE_SOURCE].integer[0] != 0;
    if (profile && (fused || o[SLICE_CLAMP].given))
        return "--source, --lookup and --clamp are of slices without --profile";
    if (chosen && fused)
        return "--max-error chooses what --source and --lookup say";
    for (int i = PASS_PROFILE + 1; i < PASS_OPTION_COUNT; i++) {
        if (!o[SLICE_PASSES + i].given)
            continue;
        if (chosen)
            return "--max-error chooses what --technique, --resolution, --bits, --taps-per-pass, "
                   "--worst-case, --order and --source-range say";
        if (!profile && !(i == PASS_RESOLUTION && sampled) && !(i == PASS_SOURCE_RANGE && stored))
            return "--technique, --resolution, --bits, --taps-per-pass, --worst-case, --order and "
                   "--source-range need --profile NAME (--resolution: or --lookup; "
                   "--source-range: or --source)";
    }
    return NULL;
}

static const char *option_conflict(const struct option_value *o)
{
    bool plane = o[SLICE_ORIGIN].given || o[SLICE_U].given || o[SLICE_V].given;
    if (plane && (o[SLICE_AXIS].given || o[SLICE_AT].given))
        return "--axis and --at exclude --origin, --u and --v";
    if (plane && !(o[SLICE_ORIGIN].given && o[SLICE_U].given && o[SLICE_V].given))
        return "--origin, --u and --v must be given together";
    if (o[SLICE_QUIET].given && o[SLICE_VERBOSE].given)
        return "-q and -v exclude each other";
    if (!o[SLICE_PREVIEW].given && (o[SLICE_RANGE].given || o[SLICE_COLOUR_MAP].given))
        return "--range and --colour-map need --preview OUT.png";
    if (o[SLICE_PASSES + PASS_PROFILE].given && o[SLICE_LAYOUT].given)
        return "--layout is of slices without --profile";
    const char *conflict = passes_conflict(o);
    if (conflict)
        return conflict;
    if (!o[SLICE_OUTPUT].given && !o[SLICE_PREVIEW].given && !o[SLICE_EXPLAIN].given &&
        !o[SLICE_VERIFY].given && !o[SLICE_JSON].given)
        return "nothing to do: give -o OUT.exr, --preview OUT.png, --verify, --json or --explain";
    return NULL;
}

static enum weft_result check_options(struct slice_job *job)
{
    const struct preview_options preview = preview_options(job);
    const struct option_value *o = job->option;
    const char *conflict = option_conflict(o);
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; o[SLICE_SIZE].given && i < 2; i++) {
        if (o[SLICE_SIZE].integer[i] < 1 || o[SLICE_SIZE].integer[i] > WEFT_SLICE_MAX_SIZE) {
            report_error("--size %s: width and height must be from 1 to %d", o[SLICE_SIZE].text,
                         WEFT_SLICE_MAX_SIZE);
            return WEFT_ERR_ARGUMENT;
        }
    }
    if (o[SLICE_SIZE].given &&
        o[SLICE_SIZE].integer[0] * o[SLICE_SIZE].integer[1] > WEFT_SLICE_MAX_PIXELS) {
        report_error("--size %s: there may be at most %lld pixels in all", o[SLICE_SIZE].text,
                     (long long)WEFT_SLICE_MAX_PIXELS);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = pass_options_check(&o[SLICE_PASSES]);
    if (res == WEFT_OK && o[SLICE_KERNEL].given)
        res = kernels_load_filter(o[SLICE_KERNEL].text, 3, &job->kernel, &job->kernel_file);
    if (res == WEFT_OK && o[SLICE_KERNEL].given && !job->kernel.radial) // which slices refuse
        res = kernels_normalise(&o[SLICE_NORMALISE], 3, job->kernel_file, &job->kernel);
    if (res == WEFT_OK && o[SLICE_CONTEXT].given)
        res = weft_context_kind_parse(report_log(), o[SLICE_CONTEXT].text, &job->context_kind);
    if (res == WEFT_OK)
        res = preview_check(&preview, &job->colour_map);
    return res;
}

static enum weft_result check_outputs(struct slice_job *job)
{
    const struct preview_options preview = preview_options(job);
    return preview_check_outputs(&preview, !job->option[SLICE_EXPLAIN].given);
}

// ---- the stages ---------------------------------------------------------------------------------

static enum weft_result open_volume(struct slice_job *job)
{
    double start = report_now_seconds();
    const struct weft_volume_open_params params = {
        .path = job->input,
        .grid = job->option[SLICE_GRID].text,
        .log = report_log(),
    };
    report_stage("reading", job->input);
    enum weft_result res = weft_volume_open(&params, &job->volume);
    job->open_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result choose_geometry(struct slice_job *job)
{
    const struct option_value *o = job->option;
    const enum weft_space space = (enum weft_space)o[SLICE_SPACE].integer[0];
    struct weft_slice_geometry *out = &job->geometry;
    int width = (int)o[SLICE_SIZE].integer[0], height = (int)o[SLICE_SIZE].integer[1];
    if (!o[SLICE_ORIGIN].given) {
        int axis = o[SLICE_AXIS].given ? (int)o[SLICE_AXIS].integer[0] : 2;
        double at = o[SLICE_AT].given ? o[SLICE_AT].number[0] : NAN;
        return weft_slice_axis_geometry(report_log(), job->volume, space, axis, at, width, height,
                                        out);
    }
    *out = (struct weft_slice_geometry){.width = width, .height = height};
    memcpy(out->origin, o[SLICE_ORIGIN].number, sizeof out->origin);
    memcpy(out->u, o[SLICE_U].number, sizeof out->u);
    memcpy(out->v, o[SLICE_V].number, sizeof out->v);
    return weft_slice_size_compute(report_log(), job->volume, space, out);
}

// "constant,smooth" as bits.
static enum weft_result read_without(const char *text, unsigned *out)
{
    for (*out = 0; text && *text; text += strcspn(text, ",") + (strchr(text, ',') != NULL)) {
        const size_t length = strcspn(text, ",");
        int i = 0;
        while (weft_saving_names[i] && (strlen(weft_saving_names[i]) != length ||
                                        strncmp(weft_saving_names[i], text, length) != 0))
            i++;
        const bool all = length == 3 && strncmp(text, "all", 3) == 0;
        if (!weft_saving_names[i] && !all) {
            report_error("--without %.*s: there are constant, axis, separable, smooth and all",
                         (int)length, text);
            return WEFT_ERR_ARGUMENT;
        }
        *out |= all ? WEFT_SAVING_ALL : 1u << i;
    }
    return WEFT_OK;
}

// A source that is not float needs the voxels' range before it is planned.
static enum weft_result find_range(struct slice_job *job, struct weft_slice_params *params)
{
    const struct option_value *range = &job->option[SLICE_PASSES + PASS_SOURCE_RANGE];
    struct weft_slice_params plain = *params;
    weft_slice_plan *plan = NULL;
    if (params->source == WEFT_SOURCE_FLOAT)
        return WEFT_OK;
    if (range->given) {
        params->low = range->number[0];
        params->high = range->number[1];
        return WEFT_OK;
    }
    plain.source = WEFT_SOURCE_FLOAT;
    enum weft_result res = weft_slice_plan_create(job->volume, &plain, &plan);
    struct weft_slice_statistics statistics = {0};
    if (res == WEFT_OK)
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(plan),
                                        report_progress("measuring"), &statistics);
    weft_slice_plan_destroy(&plan);
    params->low = statistics.low;
    params->high = statistics.high > statistics.low ? statistics.high : statistics.low + 1.0;
    return res;
}

static enum weft_result make_plan(struct slice_job *job)
{
    double start = report_now_seconds();
    const struct option_value *o = job->option;
    struct weft_slice_params *params = &job->slice_params;
    *params = (struct weft_slice_params){
        .kernel = job->kernel,
        .space = (enum weft_space)o[SLICE_SPACE].integer[0],
        .geometry = job->geometry,
        .layout = (enum weft_layout)o[SLICE_LAYOUT].integer[0],
        .source = (enum weft_source_format)o[SLICE_SOURCE].integer[0],
        .lookup = (enum weft_lookup)o[SLICE_LOOKUP].integer[0],
        .samples = (int)o[SLICE_PASSES + PASS_RESOLUTION].number[0],
        .clamp_to_samples = o[SLICE_CLAMP].given,
        .memory_bytes = (uint64_t)o[SLICE_MEMORY].integer[0],
        .progress = report_progress("planning"),
        .log = report_log(),
    };
    enum weft_result res = read_without(o[SLICE_WITHOUT].text, &params->without);
    // Passes take every tap's voxels, whatever its weight.
    if (o[SLICE_PASSES + PASS_PROFILE].given)
        params->without |= WEFT_SAVING_AXIS;
    if (res == WEFT_OK)
        res = find_range(job, params);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(job->volume, params, &job->own_plan);
    job->plan = job->own_plan;
    job->plan_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result plan_passes(struct slice_job *job)
{
    if (!job->option[SLICE_PASSES + PASS_PROFILE].given || job->option[SLICE_MAX_ERROR].given)
        return WEFT_OK;
    double start = report_now_seconds();
    const struct weft_kernel *kernel = &weft_slice_plan_get_info(job->plan)->kernel;
    enum weft_result res =
        pass_plan_create(&job->option[SLICE_PASSES], NULL, kernel, 3, 1, &job->own_passes);
    job->passes = job->own_passes;
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

// Before planning, which takes its time for a size that cannot be held anyway.
static enum weft_result allocate_pixels(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    if (job->option[SLICE_EXPLAIN].given)
        return WEFT_OK;
    size_t bytes = (size_t)g->width * (size_t)g->height * sizeof *job->pixels;
    job->pixels = malloc(bytes);
    if (!job->pixels) {
        report_error("out of memory: %zu bytes for %d x %d pixels", bytes, g->width, g->height);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

static enum weft_result create_context(struct slice_job *job)
{
    if (job->context)
        return WEFT_OK;
    double start = report_now_seconds();
    const struct weft_context_params params = {.kind = job->context_kind, .log = report_log()};
    enum weft_result res = weft_context_create(&params, &job->context);
    job->context_seconds = report_now_seconds() - start;
    return res;
}

// What a method costs depends on where it would run.
static enum weft_result create_context_for_choice(struct slice_job *job)
{
    const struct option_value *o = job->option;
    return o[SLICE_MAX_ERROR].given && !o[SLICE_EXPLAIN].given ? create_context(job) : WEFT_OK;
}

// The part of the grid's integers that floats lack, so that they are verified as they are stored.
static enum weft_result open_rest(const struct slice_job *job, weft_volume **out)
{
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const struct weft_volume_open_params params = {
        .path = job->input, .grid = info->name, .rest = true, .log = report_log()};
    return info->values_rounded ? weft_volume_open(&params, out) : WEFT_OK;
}

static enum weft_result verify(struct slice_job *job)
{
    if (!job->option[SLICE_VERIFY].given)
        return WEFT_OK;
    double start = report_now_seconds();
    struct weft_slice_verify_params params = {.progress = report_progress("verifying")};
    enum weft_result res = open_rest(job, &params.rest);
    if (res == WEFT_OK)
        res = weft_slice_verify(job->plan, job->pixels, &params, &job->error);
    weft_volume_destroy(&params.rest);
    job->verify_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result write_exr(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    struct weft_metadata texts[SLICE_ATTRIBUTES];
    struct weft_image_attribute attributes[SLICE_ATTRIBUTES];
    struct weft_image_channel channel = {.name = "Y", .plane = job->pixels};
    const size_t count = slice_attributes(job, texts);
    attributes_of_texts(texts, count, attributes);
    const struct weft_image image = {
        .width = g->width,
        .height = g->height,
        .display_max = {g->width - 1, g->height - 1},
        .channel_count = 1,
        .channels = &channel,
        .attribute_count = count,
        .attributes = attributes,
    };
    const struct weft_image_save_params params = {
        .path = job->option[SLICE_OUTPUT].text,
        .no_clobber = job->option[SLICE_NO_CLOBBER].given,
        .verify = job->option[SLICE_VERIFY].given,
        .progress = report_writing(job->option[SLICE_OUTPUT].text),
        .log = report_log(),
    };
    return weft_image_save_parts(&image, 1, &params, &job->saved);
}

static enum weft_result write_preview(struct slice_job *job)
{
    const struct preview_options preview = preview_options(job);
    return preview_save(&preview, job->colour_map, job->geometry.width, job->geometry.height,
                        job->pixels, job->preview_range);
}

static enum weft_result write_outputs(struct slice_job *job)
{
    double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (job->option[SLICE_OUTPUT].given)
        res = write_exr(job);
    if (res == WEFT_OK && job->option[SLICE_PREVIEW].given)
        res = write_preview(job);
    job->write_seconds = report_now_seconds() - start;
    return res;
}

// What both kinds of run tell, and the plan's bound for what it was run on, which for prefiltered
// kernels are the voxels themselves, too.
static enum weft_result set_passes_report(struct slice_job *job)
{
    const struct weft_slice_report *r = &job->report;
    struct weft_slice_statistics statistics = job->choice.statistics;
    const bool measured = job->choice.plan || job->kernel.prefiltered;
    enum weft_result res = WEFT_OK;
    if (!job->choice.plan && job->kernel.prefiltered)
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(job->plan),
                                        report_progress("measuring"), &statistics);
    const struct weft_bound_terms terms = weft_slice_multipass_bound_terms(job->plan, job->passes);
    const struct weft_bound_values values = {
        .low = r->low,
        .high = r->high,
        .sample_low = measured ? statistics.voxel_low : r->low,
        .sample_high = measured ? statistics.voxel_high : r->high,
        .beyond = statistics.beyond,
        .result = fmax(0.0, fmax(-r->minimum, r->maximum)), // both are NAN if none is finite
    };
    job->bound = weft_bound_compute(&terms, &values);
    return res;
}

static enum weft_result run_chosen(struct slice_job *job)
{
    struct weft_method_report report;
    const enum weft_result res = weft_method_run(job->context, job->choice.plan, job->volume,
                                                 job->pixels, report_progress("slicing"), &report);
    job->report = report.slice;
    return res;
}

static enum weft_result run_planned(struct slice_job *job)
{
    const struct option_value *range = &job->option[SLICE_PASSES + PASS_SOURCE_RANGE];
    const struct weft_slice_passes passes = {
        .plan = job->passes,
        .low = range->given ? range->number[0] : NAN,
        .high = range->given ? range->number[1] : NAN,
        .memory_bytes = (uint64_t)job->option[SLICE_MEMORY].integer[0],
        .log = report_log(),
    };
    return weft_slice_run_once(
        job->plan,
        weft_slice_compile_params(.context = job->context, .passes = job->passes ? &passes : NULL),
        weft_slice_run_params(.pixels = job->pixels, .progress = report_progress("slicing")),
        &job->report);
}

static enum weft_result run_slice(struct slice_job *job)
{
    const enum weft_result res = job->choice.plan ? run_chosen(job) : run_planned(job);
    return res == WEFT_OK && job->passes ? set_passes_report(job) : res;
}

// Where no float holds the values, nothing is left to be shown.
static enum weft_result check_values(struct slice_job *job)
{
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const struct weft_slice_geometry *g = &weft_slice_plan_get_info(job->plan)->geometry;
    if (!info->values_infinite || job->report.not_finite < (uint64_t)g->width * (uint64_t)g->height)
        return WEFT_OK;
    report_error("%s: no pixel is finite: %llu values of grid '%s' are beyond the range of floats "
                 "(3.4e38)",
                 job->input, (unsigned long long)info->values_infinite, info->name);
    return WEFT_ERR_UNSUPPORTED;
}

// A volume that cannot be opened is reported before any GL context is made.
static enum weft_result run_stages(struct slice_job *job)
{
    typedef enum weft_result (*stage)(struct slice_job * job);
    static const stage planning[] = {
        check_options,   check_outputs, open_volume, choose_geometry,
        allocate_pixels, make_plan,     plan_passes, create_context_for_choice,
        slice_choose,    NULL};
    static const stage computing[] = {create_context, run_slice,     check_values,
                                      verify,         write_outputs, NULL};
    enum weft_result res = WEFT_OK;
    for (const stage *s = planning; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    if (job->option[SLICE_EXPLAIN].given)
        return res;
    for (const stage *s = computing; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    return res;
}

static int run(const char *operand, const struct option_value *values)
{
    report_set_level(values[SLICE_QUIET].given, values[SLICE_VERBOSE].given);
    if (pass_options_help(&values[SLICE_KERNEL], &values[SLICE_PASSES]) ||
        preview_help(&values[SLICE_COLOUR_MAP]))
        return report_finish(WEFT_OK);
    if (!operand) {
        report_error("no volume given: weft slice VOLUME.vdb ... (see weft help slice)");
        return EXIT_CODE_USAGE;
    }
    struct slice_job job = {.input = operand, .option = values, .start = report_now_seconds()};
    enum weft_result res = run_stages(&job);
    report_erase_progress();
    if (res == WEFT_OK && values[SLICE_JSON].given)
        res = slice_print_json(&job);
    else if (res == WEFT_OK)
        slice_print_text(&job);
    const bool verified = res != WEFT_OK || !job.context || !values[SLICE_VERIFY].given ||
                          report_verdict("the slice", job.error.maximum, slice_verify_bound(&job),
                                         job.error.not_finite_mismatches);
    free(job.pixels);
    weft_context_destroy(&job.context);
    weft_choice_clear(&job.choice);
    weft_pass_plan_destroy(&job.own_passes);
    weft_slice_plan_destroy(&job.own_plan);
    weft_volume_destroy(&job.volume);
    weft_kernel_file_destroy(&job.kernel_file);
    const int code = report_finish(res);
    return job.over_budget || !verified ? EXIT_CODE_FAILED : code;
}

static const char *const epilogue[] = {
    "Pixel (x, y) of a W x H slice samples the volume at origin + (x + 0.5) / W * u + (y + 0.5) / "
    "H * v; row 0 is on top. Voxel values sit at integer index coordinates; outside the stored "
    "voxels the grid's background value holds.",
    "With --profile the slice runs in the passes that weft plan --dims 3 plans: the voxels in "
    "reach "
    "are mapped to [0, 1], filtered with what the profile's hardware has, and mapped back; "
    "--verify "
    "then tells the plan's bound beside the error.",
    "The same request gives the same bytes, whatever the number of threads. Outputs appear whole "
    "or not at all.",
    "weft slice smoke.vdb -o smoke.exr --preview smoke.png --kernel mitchell --axis y --verify",
    NULL,
};

const struct verb verb_slice = {
    .name = "slice",
    .summary = "a planar cut through a VDB volume, as EXR and PNG",
    .usage = "VOLUME.vdb [-o OUT.exr] [--preview OUT.png] [options]",
    .description = "Reconstructs a planar cut of any orientation through a scalar grid of a VDB "
                   "file with a reconstruction kernel, reading only the bricks it touches.",
    .epilogue = epilogue,
    .options = options,
    .option_count = SLICE_OPTION_COUNT,
    .run = run,
};
