// SPDX-License-Identifier: BSD-3-Clause
// weft resample: an EXR image at another size, filtered along its axes or in passes.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/common/parts.h"
#include "tools/methods/plan_options.h"
#include "tools/draw/preview.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"
#include "tools/resample/job.h"
#include "tools/options/saved.h"
#include "tools/verbs/verb.h"

static const char *const png_ending[] = {".png", NULL};
static const char *const image_endings[] = {".exr", ".png", ".tif", ".tiff", NULL};
static const char *const transfer_names[] = {"auto", "srgb", "none", NULL};
static const char *const switch_names[] = {"on", "off", NULL};

static const struct option_spec options[RESAMPLE_OPTION_COUNT] = {
    [RESAMPLE_OUTPUT] = {.name = "output",
                         'o',
                         OPTION_OUTPUT,
                         "OUT.exr|.png|.tif",
                         "the image: channels of the same names and types, with the input's "
                         "attributes and attributes that tell how it was made",
                         image_endings,
                         .group = OPTION_FILES,
                         .brief = "the image: EXR, PNG or TIFF"},
    [RESAMPLE_PREVIEW] =
        {.name = "preview",
         0,
         OPTION_OUTPUT,
         "OUT.png",
         "the luminance of R, G and B, or else the first channel, of the first part, "
         "as 8-bit PNG",
         png_ending,
         .group = OPTION_PICTURES,
         .brief = "a picture to look at"},
    [RESAMPLE_SIZE] =
        {.name = "size",
         0,
         OPTION_TEXT,
         "WxH|Wx0|N|x2|50%",
         "the display window: pixels, of which 0 follows by the aspect, N, the longer side, or a "
         "factor or percentage "
         "of the input's, to the nearest whole pixel (default x2); the data window, which may be "
         "smaller or larger, takes part",
         .group = OPTION_GEOMETRY,
         .brief = "WxH, x2, 50% or Wx0"},
    [RESAMPLE_MATRIX] = {.name = "matrix",
                         0,
                         OPTION_TEXT,
                         "a,b,c,d,e,f",
                         "warp: x' = a x + c y + e and y' = b x + d y + f, from the image to the "
                         "result (as in SVG), y down, pixels' centres at halves; of the input's "
                         "size unless --size says otherwise",
                         .group = OPTION_GEOMETRY,
                         .brief = "an affine map of the picture"},
    [RESAMPLE_ROTATE] = {.name = "rotate",
                         0,
                         OPTION_NUMBER,
                         "DEG",
                         "warp: counter-clockwise by so many degrees about the display window's "
                         "centre, which stays the centre with --size",
                         .group = OPTION_GEOMETRY,
                         .brief = "by degrees about the middle"},
    [RESAMPLE_PERSPECTIVE] = {.name = "perspective",
                              0,
                              OPTION_TEXT,
                              "9 NUMBERS",
                              "warp: a matrix row by row, (x', y', w') = M (x, y, 1), and x' / w', "
                              "y' / w' is the point",
                              .group = OPTION_GEOMETRY},
    [RESAMPLE_POSITIONS] =
        {.name = "positions",
         0,
         OPTION_TEXT,
         "P.exr",
         "warp: channels X and Y say for every pixel of a result of P's windows which point of the "
         "image it shows",
         .group = OPTION_GEOMETRY,
         .names = OPTION_NAMES_FILE},
    [RESAMPLE_KERNEL] = {.name = "kernel",
                         'k',
                         OPTION_TEXT,
                         "NAME[:p,q]|table:FILE",
                         "the reconstruction kernel (default catmull-rom), as in weft slice; "
                         "'help' lists them",
                         .group = OPTION_FILTER,
                         .brief = "which kernel (catmull-rom); help lists them",
                         .names = OPTION_NAMES_KERNEL},
    [RESAMPLE_BOUNDARY] = {.name = "boundary",
                           0,
                           OPTION_TEXT,
                           "clamp|mirror|wrap|border:V",
                           "what stands beyond the samples (default clamp: the nearest one)",
                           .group = OPTION_FILTER,
                           .brief = "beyond the edges: clamp, mirror, wrap, border"},
    [RESAMPLE_ANTIALIAS] = {.name = "antialias",
                            0,
                            OPTION_CHOICE,
                            NULL,
                            "stretch the kernel where the image becomes smaller, so that it does "
                            "not alias (default on; never of nearest)",
                            .choices = switch_names,
                            .group = OPTION_FILTER},
    [RESAMPLE_CLAMP] = {.name = "clamp",
                        0,
                        OPTION_FLAG,
                        NULL,
                        "hold pixels between the samples next to them: no ringing, no overshoots",
                        .group = OPTION_FILTER,
                        .brief = "hold edges from ringing"},
    [RESAMPLE_NORMALISE] = KERNELS_NORMALISE_OPTION,
    PASS_OPTIONS(RESAMPLE_PASSES, "filter in the passes of a plan: what a pass may do"),
    [RESAMPLE_CHANNELS] = {.name = "channels",
                           0,
                           OPTION_TEXT,
                           "NAME,NAME,...",
                           "which channels (default: all)",
                           .group = OPTION_FILES},
    [RESAMPLE_PART] = {.name = "part",
                       0,
                       OPTION_TEXT,
                       "NAME|INDEX",
                       "which part of a file of several, from 0 (default: all that are not deep)",
                       .group = OPTION_FILES},
    [RESAMPLE_TYPE] =
        SAVED_TYPE_OPTION("of the channels written: float, half or uint in EXR, unorm8 or unorm16 "
                          "in PNG, any in TIFF (default: as they are; uint stays so with "
                          "kernel nearest, and becomes float where it is filtered; else half for "
                          "8 bits and float for 16 in EXR, 8 bits in PNG)",
                          WEFT_PIXEL_TYPE_COUNT),
    [RESAMPLE_COMPRESSION] = SAVED_COMPRESSION_OPTION(
        "of the file (default: the input's, or zip where weft does not write it)"),
    [RESAMPLE_TRANSFER] = {.name = "transfer",
                           0,
                           OPTION_CHOICE,
                           NULL,
                           "what integer codes of PNG and TIFF stand for: as the file says, or "
                           "sRGB; sRGB; or codes are filtered as they are (default auto)",
                           transfer_names,
                           3,
                           .group = OPTION_FILES},
    [RESAMPLE_MIP] = {.name = "mip",
                      0,
                      OPTION_FLAG,
                      NULL,
                      "write an EXR file in tiles with mip levels, each by the kernel, stretched, "
                      "over the whole result (default: where the input has levels)",
                      .group = OPTION_FILES},
    [RESAMPLE_MAX_ERROR] =
        {.name = "max-error",
         0,
         OPTION_TEXT,
         "E|8bit|12bit|16bit",
         "how wrong pixels may be, or half a code value of so many bits of the channel's range: "
         "without --profile checked before anything runs; with it the cheapest passes within it "
         "are chosen, by what weft calibrate measured",
         .group = OPTION_METHOD,
         .brief = "the fastest way that is as exact as this"},
    [RESAMPLE_TOGETHER] = {.name = "together",
                           0,
                           OPTION_FLAG,
                           NULL,
                           "filter four channels of one type (R, G, B and A, of each layer) in the "
                           "same passes, mapped by one range (not with dot4)",
                           .group = OPTION_GEOMETRY},
    ENGINE_OPTIONS(RESAMPLE_ENGINE, ENGINE_AUTOMATIC, ENGINE_SUMS_HELP),
    [RESAMPLE_EMULATE] = {.name = "emulate",
                          0,
                          OPTION_FLAG,
                          NULL,
                          "run the passes on the CPU, without OpenGL: on unorm targets the same "
                          "bytes",
                          .group = OPTION_METHOD},
    [RESAMPLE_RANGE] = {.name = "range",
                        0,
                        OPTION_RANGE,
                        "LO,HI",
                        "values shown as first and last colour of the preview (default: in colour "
                        "0 and 1, or else the smallest and the largest)",
                        .group = OPTION_PICTURES},
    [RESAMPLE_COLOUR_MAP] = {.name = "colour-map",
                             0,
                             OPTION_TEXT,
                             "NAME",
                             "show luminance, or the first channel, in these colours (default: R, "
                             "G and B as they are, or grey), as in weft slice",
                             .group = OPTION_PICTURES,
                             .names = OPTION_NAMES_MAP},
    [RESAMPLE_EXPOSURE] = PREVIEW_EXPOSURE_OPTION,
    [RESAMPLE_ANNOTATE] = PREVIEW_ANNOTATE_OPTION,
    [RESAMPLE_TITLE] = PREVIEW_TITLE_OPTION,
    [RESAMPLE_ERROR_IMAGE] = ERROR_IMAGE_OPTION,
    [RESAMPLE_EXPLAIN] =
        {.name = "explain",
         0,
         OPTION_FLAG,
         NULL,
         "print the plan and exit: no OpenGL (but to know its costs, with --max-error), no output",
         .group = OPTION_REPORTS,
         .brief = "the plan, without running it"},
    [RESAMPLE_VERIFY] =
        {.name = "verify",
         0,
         OPTION_FLAG,
         NULL,
         "recompute in double precision and print the largest and RMS difference "
         "beside the plan's bound; with -o, read the file back and compare every value",
         .group = OPTION_METHOD,
         .brief = "measure the error against double precision"},
    [RESAMPLE_JSON] = OPTIONS_JSON("sizes, plan, ranges, times, errors and bounds"),
    [RESAMPLE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    RANK_OPTIONS(RESAMPLE_RANKS),
    [RESAMPLE_QUIET] = OPTIONS_QUIET,
    [RESAMPLE_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- checks that need no file contents ----------------------------------------------------------

static const char *option_conflict(const struct option_value *o)
{
    if (o[RESAMPLE_QUIET].given && o[RESAMPLE_VERBOSE].given)
        return "-q and -v exclude each other";
    if (!o[RESAMPLE_PREVIEW].given && (o[RESAMPLE_RANGE].given || o[RESAMPLE_COLOUR_MAP].given))
        return "--range and --colour-map need --preview OUT.png";
    if (o[RESAMPLE_ERROR_IMAGE].given && !o[RESAMPLE_VERIFY].given)
        return "--error-image is of --verify";
    if (!o[RESAMPLE_OUTPUT].given && o[RESAMPLE_COMPRESSION].given)
        return "--compression needs -o OUT.exr";
    if (!o[RESAMPLE_OUTPUT].given && o[RESAMPLE_MIP].given)
        return "--mip needs -o OUT.exr";
    if (!o[RESAMPLE_OUTPUT].given && !o[RESAMPLE_PREVIEW].given && !o[RESAMPLE_EXPLAIN].given &&
        !o[RESAMPLE_VERIFY].given && !o[RESAMPLE_JSON].given)
        return "nothing to do: give -o OUT.exr, --preview OUT.png, --verify, --json or --explain";
    return NULL;
}

static struct preview_options preview_options(const struct resample_job *job)
{
    const struct option_value *o = job->option;
    return (struct preview_options){.input = job->input,
                                    .output = o[RESAMPLE_OUTPUT].text,
                                    .preview = o[RESAMPLE_PREVIEW].text,
                                    .error_image = o[RESAMPLE_ERROR_IMAGE].text,
                                    .range = &o[RESAMPLE_RANGE],
                                    .colour_map = &o[RESAMPLE_COLOUR_MAP],
                                    .exposure = &o[RESAMPLE_EXPOSURE],
                                    .annotate = &o[RESAMPLE_ANNOTATE],
                                    .title = &o[RESAMPLE_TITLE],
                                    .no_clobber = o[RESAMPLE_NO_CLOBBER].given};
}

static enum weft_result check_options(struct resample_job *job)
{
    const struct option_value *o = job->option;
    const struct preview_options preview = preview_options(job);
    const char *conflict = option_conflict(o);
    if (!conflict)
        conflict = preview_conflict(&preview, o[RESAMPLE_PREVIEW].given);
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = resample_read_size(job);
    if (res == WEFT_OK)
        res = resample_read_boundary(job);
    if (res == WEFT_OK)
        res = resample_choose_kind(job);
    if (res == WEFT_OK)
        res = pass_options_check(&o[RESAMPLE_PASSES]);
    if (res == WEFT_OK)
        res =
            kernels_load_filter(o[RESAMPLE_KERNEL].given ? o[RESAMPLE_KERNEL].text : "catmull-rom",
                                2, &job->kernel, &job->kernel_file);
    if (res == WEFT_OK)
        res = kernels_normalise(&o[RESAMPLE_NORMALISE], 2, job->kernel_file, &job->kernel);
    if (res == WEFT_OK && o[RESAMPLE_MAX_ERROR].given)
        res = budget_parse(o[RESAMPLE_MAX_ERROR].text, &job->budget);
    if (res == WEFT_OK)
        res = resample_read_engine(job);
    if (res == WEFT_OK)
        res = resample_read_ranks(job);
    if (res == WEFT_OK && o[RESAMPLE_ERROR_IMAGE].given && job->divided.is) {
        report_error("--error-image is not divided; run it without mpirun and rank options");
        return WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK)
        res = resample_read_warp(job);
    return res == WEFT_OK ? preview_check(&preview, &job->colour_map) : res;
}

static enum weft_result check_outputs(struct resample_job *job)
{
    const struct preview_options preview = preview_options(job);
    return preview_check_outputs(&preview, !job->option[RESAMPLE_EXPLAIN].given);
}

// ---- the image and its channels -----------------------------------------------------------------

// Budgets are of the samples' range.
static bool needs_samples(const struct resample_job *job)
{
    return !job->option[RESAMPLE_EXPLAIN].given || job->option[RESAMPLE_MAX_ERROR].given;
}

// While the image is read, where it is clear that OpenGL will be needed.
static enum weft_result begin_context(struct resample_job *job)
{
    const bool none =
        job->context || job->option[RESAMPLE_EXPLAIN].given || job->option[RESAMPLE_EMULATE].given;
    return none ? WEFT_OK : engine_begin_context(&job->engine);
}

static enum weft_result load_image(struct resample_job *job)
{
    double start = report_now_seconds();
    const struct weft_image_load_params params = {
        .path = job->input,
        .part = job->part,
        .info_only = !needs_samples(job) || job->divided.is,
        .transfer = resample_transfer(job),
        .threads = job->engine.cpu.threads,
        .log = report_log(),
    };
    report_stage("reading", job->input);
    enum weft_result res = weft_image_load(&params, &job->image);
    if (res == WEFT_OK && job->image.codes.icc && params.transfer.curve == WEFT_CURVE_AUTO &&
        job->image.transfer.curve == WEFT_CURVE_SRGB)
        report_warning("%s has an ICC profile, which is not applied: its codes are taken for sRGB",
                       job->input);
    job->load_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result allocate_pixels(struct resample_job *job)
{
    const bool none = job->option[RESAMPLE_EXPLAIN].given || !ranks_tells() ||
                      (job->divided.is && !job->divided.sends);
    return none ? WEFT_OK : resample_allocate(job);
}

// ---- groups -------------------------------------------------------------------------------------

static enum weft_result make_groups(struct resample_job *job)
{
    job->separable =
        !job->warp.is && !job->option[RESAMPLE_EMULATE].given && !resample_passes_option(job);
    const enum weft_result res =
        job->warp.is ? resample_make_warp_groups(job) : resample_make_groups(job);
    if (res == WEFT_OK)
        resample_set_types(job);
    return res;
}

static enum weft_result measure(struct resample_job *job)
{
    return job->divided.is      ? resample_measure_parts(job)
           : needs_samples(job) ? resample_measure(job)
                                : WEFT_OK;
}

static enum weft_result plan(struct resample_job *job)
{
    return job->warp.is      ? resample_plan_warp(job)
           : job->divided.is ? resample_plan_alike(job)
                             : resample_plan(job);
}

static enum weft_result compute(struct resample_job *job)
{
    return job->warp.is      ? resample_compute_warp(job)
           : job->divided.is ? resample_compute_parts(job)
                             : resample_compute(job);
}

// ---- running and writing ------------------------------------------------------------------------

static const float *plane_named(const struct weft_image *image, const char *name)
{
    for (size_t i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0)
            return image->channels[i].plane;
    return NULL;
}

// Luminance by Rec. 709, OpenEXR's default primaries; NULL where there is no R, G and B.
static float *make_luminance(const struct weft_image *image)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    const float *r = plane_named(image, "R"), *g = plane_named(image, "G"),
                *b = plane_named(image, "B");
    float *out = r && g && b ? malloc(count * sizeof *out) : NULL;
    for (size_t i = 0; out && i < count; i++)
        out[i] = (float)(0.2126 * (double)r[i] + 0.7152 * (double)g[i] + 0.0722 * (double)b[i]);
    return out;
}

// Its name, kernel and sizes.
static bool annotate(const struct resample_job *job, const struct preview_options *preview,
                     struct annotation *out)
{
    char kernel[KERNELS_TEXT], caption[ANNOTATION_TEXT];
    weft_kernel_format(&job->kernel, kernel, sizeof kernel);
    snprintf(caption, sizeof caption, "%.200s, %d x %d to %d x %d pixels", kernel, job->image.width,
             job->image.height, job->result.width, job->result.height);
    return preview_annotate(preview, paths_base_name(job->input), caption, out);
}

// What is shown of an image: its colours, where it has any and no map is named for their luminance,
// or else luminance or the first channel, as light where --exposure asks for that.
static enum weft_result write_preview(struct resample_job *job)
{
    struct preview_options preview = preview_options(job);
    const struct weft_image *image = &job->result;
    const float *colour[3] = {plane_named(image, "R"), plane_named(image, "G"),
                              plane_named(image, "B")};
    const bool coloured = colour[0] && colour[1] && colour[2];
    struct annotation annotation;
    if (annotate(job, &preview, &annotation))
        preview.annotation = &annotation;
    snprintf(annotation.quantity, sizeof annotation.quantity, "%.60s",
             coloured ? "luminance" : image->channels[0].name);
    for (int c = 0; c < 3 && !coloured; c++)
        colour[c] = image->channels[0].plane;
    if (preview_shows_light(&preview) || (coloured && !job->colour_map))
        return preview_save_colour(&preview, job->engine.cpu.threads, image->width, image->height,
                                   colour, job->preview_range);
    float *luminance = make_luminance(image);
    enum weft_result res =
        preview_save(&preview, job->colour_map, image->width, image->height,
                     luminance ? luminance : image->channels[0].plane, job->preview_range);
    free(luminance);
    return res;
}

// Of all groups' errors the largest, beside its bound.
static enum weft_result write_errors(struct resample_job *job)
{
    const struct option_value *o = job->option;
    const struct preview_options preview = preview_options(job);
    struct annotation annotation;
    double most = 0.0;
    for (size_t g = 0; g < job->group_count; g++)
        most = fmax(most, job->group[g].error.maximum);
    annotate(job, &preview, &annotation);
    char kept[160];
    snprintf(kept, sizeof kept, "%.150s", annotation.caption);
    if (!o[RESAMPLE_TITLE].given)
        snprintf(annotation.title, sizeof annotation.title, "error of %.380s",
                 paths_base_name(job->input));
    snprintf(annotation.caption, sizeof annotation.caption, "at most %.3g%s; %s", most,
             job->result.channel_count > 1 ? " (of all channels the largest)" : "", kept);
    const struct error_image_save_params params = {.output = &o[RESAMPLE_ERROR_IMAGE],
                                                   .no_clobber = o[RESAMPLE_NO_CLOBBER].given,
                                                   .threads = job->engine.cpu.threads,
                                                   .channels = job->result.channels,
                                                   .annotation = &annotation};
    return error_image_save(&job->errors, &params, job->errors_range);
}

// The preview is of the first part, as are errors.
static enum weft_result write_outputs(struct resample_job *jobs, size_t count)
{
    double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (jobs->option[RESAMPLE_OUTPUT].given)
        res = resample_save(jobs, count);
    if (res == WEFT_OK && jobs->option[RESAMPLE_PREVIEW].given)
        res = write_preview(jobs);
    if (res == WEFT_OK && jobs->errors.plane)
        res = write_errors(jobs);
    jobs->write_seconds = report_now_seconds() - start;
    return res;
}

typedef enum weft_result (*stage)(struct resample_job *job);

// Where work is divided ranks agree on each stage.
static enum weft_result run_list(struct resample_job *job, const stage *stages)
{
    enum weft_result res = WEFT_OK;
    for (const stage *s = stages; *s && res == WEFT_OK; s++) {
        res = (*s)(job);
        res = job->divided.is ? ranks_agree(res) : res;
    }
    return res;
}

static enum weft_result set_windows(struct resample_job *job)
{
    if (job->warp.is)
        return resample_set_warp_windows(job);
    const enum weft_result res = resample_choose_size(job);
    return res == WEFT_OK ? resample_set_windows(job) : res;
}

static enum weft_result run_stages(struct resample_job *job)
{
    static const stage planning[] = {
        check_options, begin_context, load_image, set_windows,     resample_choose_channels,
        make_groups,   measure,       plan,       allocate_pixels, NULL};
    static const stage computing[] = {resample_create_context, compute, NULL};
    enum weft_result res = run_list(job, planning);
    if (res == WEFT_OK && !job->option[RESAMPLE_EXPLAIN].given)
        res = run_list(job, computing);
    return res;
}

static void destroy(struct resample_job *job)
{
    resample_clear_divided(&job->divided);
    resample_clear_mips(job);
    engine_abandon_context(&job->engine);
    for (int i = 0; i < 2; i++) {
        weft_resample_compiled_destroy(&job->compiled[i]);
        weft_resample_plan_destroy(&job->plan[i]);
        weft_resample_choice_clear(&job->choices[i]);
    }
    resample_clear_warp(&job->warp);
    weft_pass_plan_destroy(&job->single);
    weft_pass_plan_destroy(&job->together);
    for (size_t g = 0; g < job->group_count; g++)
        weft_resample_source_destroy(&job->group[g].source);
    weft_image_clear(&job->image);
    weft_image_clear(&job->result);
    error_image_clear(&job->errors);
    weft_kernel_file_destroy(&job->kernel_file);
    free(job->texts);
    free(job->source);
    free(job->group);
}

// The first group that is not within its bound is told.
static bool check_groups(const struct resample_job *job)
{
    const bool ranged = job->option[RESAMPLE_PASSES + PASS_SOURCE_RANGE].given;
    bool good = true;
    for (size_t g = 0; good && g < job->group_count; g++) {
        const struct resample_group *group = &job->group[g];
        const double bound = ranged && group->statistics.clamped ? NAN : group->bound.total;
        char name[128], what[160];
        resample_group_name(job, group, name, sizeof name);
        snprintf(what, sizeof what, "channels %s", name);
        good =
            report_verdict(what, group->error.maximum, bound, group->error.not_finite_mismatches);
    }
    return good;
}

// ---- parts --------------------------------------------------------------------------------------

static void warn_of_deep_parts(const char *input, const struct weft_image_list *list)
{
    char names[700] = "";
    for (size_t p = 0; p < list->count; p++) {
        const size_t used = strlen(names);
        if (list->images[p].deep)
            snprintf(names + used, sizeof names - used, "%s%zu '%s'", used ? ", " : "", p,
                     list->images[p].name);
    }
    if (*names)
        report_warning("%s: not kept: deep parts, which weft does not filter: %s", input, names);
}

static bool is_wanted(const struct option_value *values, const struct weft_image *part)
{
    const struct option_value *channels = &values[RESAMPLE_CHANNELS];
    bool named = !channels->given;
    for (size_t i = 0; !named && i < part->channel_count; i++)
        named = resample_names_channel(channels->text, part->channels[i].name);
    return named && !part->deep;
}

// One job for each part that is to be resampled: the one that is named, or all that have a channel
// that is asked for and are not deep.
static enum weft_result choose_parts(const char *input, const struct option_value *values,
                                     struct resample_job **jobs, size_t *count)
{
    const struct option_value *named = &values[RESAMPLE_PART];
    const struct weft_image_load_params params = {.path = input, .log = report_log()};
    struct weft_image_list list;
    size_t first = 0, end = 0;
    enum weft_result res = weft_image_list_load(&params, &list);
    end = list.count;
    if (res == WEFT_OK && named->given) {
        res = parts_find(input, &list, named->text, &first);
        end = first + 1;
    }
    if (res == WEFT_OK && values[RESAMPLE_CHANNELS].given)
        res = resample_check_names(input, list.images + first, end - first,
                                   values[RESAMPLE_CHANNELS].text);
    if (res == WEFT_OK && !(*jobs = calloc(list.count, sizeof **jobs)))
        res = WEFT_ERR_MEMORY;
    for (size_t p = first; res == WEFT_OK && p < end; p++)
        if (is_wanted(values, &list.images[p]))
            (*jobs)[(*count)++].part = (int)p;
    if (res == WEFT_OK && *count == 0)
        (*jobs)[(*count)++].part = (int)first; // loading it says why not
    else if (res == WEFT_OK && !named->given)
        warn_of_deep_parts(input, &list);
    weft_image_list_clear(&list);
    return res;
}

// Before the input is looked at.
static enum weft_result check_usage(const char *input, const struct option_value *values)
{
    struct resample_job job = {.input = input, .option = values};
    enum weft_result res = check_options(&job);
    if (res == WEFT_OK && ranks_tells())
        res = check_outputs(&job);
    destroy(&job);
    return ranks_agree(res);
}

// In turn, on one context.
static enum weft_result run_parts(const char *input, const struct option_value *values,
                                  struct resample_job *jobs, size_t count)
{
    jobs->input = input;
    jobs->option = values;
    enum weft_result res = resample_choose_kind(jobs);
    if (res == WEFT_OK)
        res = resample_check_parts(jobs, count);
    for (size_t i = 0; res == WEFT_OK && i < count; i++) {
        jobs[i].input = input;
        jobs[i].option = values;
        jobs[i].start = report_now_seconds();
        jobs[i].divided.only = count == 1;
        jobs[i].context = i ? jobs[i - 1].context : NULL;
        if (i) {
            jobs[i].engine = jobs[i - 1].engine;
            jobs[i].engine_is_read = true;
        }
        res = run_stages(&jobs[i]);
    }
    if (res == WEFT_OK && !values[RESAMPLE_EXPLAIN].given && ranks_tells())
        res = write_outputs(jobs, count);
    if (!jobs->divided.is)
        return res;
    res = ranks_agree(res);
    return res == WEFT_OK ? rank_division_save(&jobs->divided.division) : res;
}

static void print_parts(const struct resample_job *jobs, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (count > 1 &&
            (jobs[i].option[RESAMPLE_EXPLAIN].given || jobs[i].option[RESAMPLE_VERIFY].given))
            report_line("part %d '%s'", jobs[i].part, jobs[i].image.name);
        resample_print_text(&jobs[i]);
    }
    if (count)
        saved_print(jobs->option[RESAMPLE_OUTPUT].text, &jobs->saved);
    for (size_t i = 0; i < count; i++)
        load_report_print(&jobs[i].divided.work);
}

static void destroy_parts(struct resample_job *jobs, size_t count)
{
    weft_context *context = NULL;
    for (size_t i = 0; i < count; i++) {
        context = jobs[i].context ? jobs[i].context : context;
        destroy(&jobs[i]);
    }
    weft_context_destroy(&context);
    free(jobs);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[RESAMPLE_QUIET].given, values[RESAMPLE_VERBOSE].given);
    if (pass_options_help(&values[RESAMPLE_KERNEL], &values[RESAMPLE_PASSES]) ||
        preview_help(&values[RESAMPLE_COLOUR_MAP]))
        return report_finish(WEFT_OK);
    if (!operand) {
        report_error("no image given: weft resample IMAGE.exr ... (see weft help resample)");
        return EXIT_CODE_USAGE;
    }
    struct resample_job *jobs = NULL;
    size_t count = 0;
    enum weft_result res = check_usage(operand, values);
    if (!ranks_tells() && values[RESAMPLE_EXPLAIN].given) // what is only planned is rank 0's
        return report_finish(res);
    if (res == WEFT_OK)
        res = choose_parts(operand, values, &jobs, &count);
    if (!values[RESAMPLE_EXPLAIN].given)
        res = ranks_agree(res);
    if (res == WEFT_OK)
        res = run_parts(operand, values, jobs, count);
    report_erase_progress();
    bool over_budget = false;
    for (size_t i = 0; i < count; i++) {
        over_budget = over_budget || jobs[i].over_budget;
        if (res != WEFT_OK && values[RESAMPLE_EXPLAIN].given)
            resample_print_choices(&jobs[i]);
    }
    if (res == WEFT_OK && values[RESAMPLE_JSON].given && ranks_tells())
        res = resample_print_json(jobs, count);
    else if (res == WEFT_OK && ranks_tells())
        print_parts(jobs, count);
    // Of the first part.
    if (res == WEFT_OK && ranks_tells() && jobs->divided.request.chart && jobs->divided.is)
        res = load_report_plot(&jobs->divided.work, jobs->divided.request.chart);
    if (res == WEFT_OK && count && jobs->aspect[0])
        report_tell("%s", jobs->aspect);
    bool verified = true;
    for (size_t i = 0; verified && i < count && ranks_tells(); i++)
        verified = res != WEFT_OK || !values[RESAMPLE_VERIFY].given ||
                   values[RESAMPLE_EXPLAIN].given || check_groups(&jobs[i]);
    destroy_parts(jobs, count);
    const int code = report_finish(res);
    return over_budget || !verified ? EXIT_CODE_FAILED : code;
}

static const char *const epilogue[] = {
    "Pixel (x, y) of the W x H result samples the w x h input at ((x + 0.5) w / W - 0.5, "
    "(y + 0.5) h / H - 0.5) in pixel indices, which are exact where they are whole; both are "
    "counted from the display windows' corners, and W, H, w and h are those windows' sizes. Beyond "
    "the border of the data the nearest pixel's value holds. "
    "A smaller size is no more than that: nothing is filtered away, and a warning says so.",
    "Each channel is filtered along one axis and then the other, on OpenGL in single precision or "
    "by the CPU engine in single or double precision. With "
    "--profile, another option of plans, --together, --emulate or a radial kernel it is mapped to "
    "[0, 1] by its range, filtered in the passes that weft plan plans (for fp32 by default), and "
    "mapped back. --verify tells the bound beside the error, and E1, what the kernel itself does "
    "to a signal that changes as the samples do. Pixels in reach of NaN or infinities are not "
    "finite, and no others.",
    "--matrix, --rotate, --perspective and --positions put the image under a map, in pixels of the "
    "file's own coordinates, where pixel (0, 0) is from 0 to 1: the result has the input's windows "
    "unless --size says otherwise. Where its pixels lie more than a sample apart the kernel is "
    "stretched along each axis of the image by the local scale along it. A layer's R, G, B and A "
    "are "
    "filtered together, by the CPU engine unless --engine gl is given. Singular matrices, horizons "
    "that meet the result's pixels and positions that are not finite are refused.",
    "With --max-error nothing runs whose bound is larger: the error line says what the best is, "
    "and the exit code is 1. --explain then lists what was compared.",
    "With a kernel that interpolates by a prefilter (bspline3i) coefficients take the place of "
    "the pixels first; ranges and --verify are then of coefficients.",
    "The data window, which may reach beyond the display window (overscan), grows with it and then "
    "to whole pixels: the picture keeps its place in the display window. --preview shows the data "
    "window. Attributes are kept whole with their types, without those of an earlier weft; "
    "pixelAspectRatio and xDensity follow the scale. Half channels are rounded to nearest even. "
    "With -o, --verify reads the file back and compares every value. The same request gives the "
    "same bytes, "
    "whatever the number of threads. Outputs appear whole or not at all.",
    NULL,
};

static const char *const examples[] = {
    "weft resample photo.exr -o large.exr --size 2048x1536 --kernel mitchell --profile radeon8500 "
    "--verify",
    NULL,
};

const struct verb verb_resample = {
    .name = "resample",
    .group = VERB_IMAGES,
    .summary = "an EXR image at another size",
    .usage = "IMAGE.exr [-o OUT.exr] [--size WxH] [options]",
    .description = "Magnifies the channels of an EXR image with a reconstruction kernel, in single "
                   "precision, or in the rendering passes of a planned target: what hardware of "
                   "limited precision has.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = RESAMPLE_OPTION_COUNT,
    .distributes = true,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
