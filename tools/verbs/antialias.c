// SPDX-License-Identifier: BSD-3-Clause
// weft antialias: pictures of scenes with smooth edges, by several ways.
#include <stddef.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/methods/engine_options.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"
#include "tools/verbs/verb.h"

static const char *const light_endings[] = {".exr", ".tif", ".tiff", NULL};
static const char *const png_ending[] = {".png", NULL};

static const struct option_spec options[ASK_OPTION_COUNT] = {
    [ASK_OUTPUT] = {.name = "output",
                    'o',
                    OPTION_OUTPUT,
                    "OUT.exr|.tif",
                    "the picture: linear light in R, G and B and how much of a pixel is covered in "
                    "A, with attributes that tell how it was made; of several a name with a "
                    "number, as out_%04d.exr",
                    light_endings,
                    .group = OPTION_FILES,
                    .brief = "the picture"},
    [ASK_PREVIEW] = {.name = "preview",
                     0,
                     OPTION_OUTPUT,
                     "OUT.png",
                     "the picture as 8-bit PNG in sRGB",
                     png_ending,
                     .group = OPTION_PICTURES,
                     .brief = "a picture to look at"},
    [ASK_WEIGHT_MAP] = {.name = "weight-map",
                        0,
                        OPTION_OUTPUT,
                        "MAP.exr|.png",
                        "acaa: the weight of each pixel as a share of the whole; as EXR in channel "
                        "weight, as 8-bit PNG from black, 0, over mid grey (128), what it should "
                        "be, to white, 2 and more",
                        antialias_map_endings,
                        .group = OPTION_PICTURES},
    SCENE_OPTIONS(ASK_SCENES, "help lists them (default: polygons)",
                  "in scenes, and in patterns that are random",
                  "of the scene, from 0 to 1 (default 0..1): its middle is shown, or of N pictures "
                  "the middles of its N parts",
                  "1024"),
    [ASK_FRAMES] = {.name = "frames",
                    0,
                    OPTION_NUMBER,
                    "N",
                    "draw N pictures over the time, with the same objects of OpenGL (default 1); "
                    "what one takes is told as their median. Without -o they are only timed",
                    .group = OPTION_GEOMETRY},
    [ASK_SAMPLES] = {.name = "samples",
                     0,
                     OPTION_NUMBER,
                     "N",
                     "of a pixel (default 4; adaptive, supersample: 16, which are 4 x 4). acaa "
                     "takes more than the device has in several passes",
                     .group = OPTION_TASK,
                     .brief = "of a pixel"},
    [ASK_FILTER] =
        {.name = "kernel",
         'k',
         OPTION_TEXT,
         "KERNEL",
         "acaa, adaptive, supersample: what a pixel sees, a product of two kernels; help "
         "lists them (default: a box of one pixel)",
         .group = OPTION_FILTER,
         .brief = "pixel filter",
         .names = OPTION_NAMES_KERNEL},
    [ASK_FILTER_WIDTH] = {.name = "kernel-width",
                          0,
                          OPTION_NUMBER,
                          "PIXELS",
                          "that the kernel's support is scaled to (default: as it is)",
                          .group = OPTION_FILTER},
    [ASK_FORM] = {.name = "form",
                  0,
                  OPTION_CHOICE,
                  NULL,
                  "acaa: how a fragment learns which of its samples are visible (default auto: the "
                  "first that the device has); jitter draws each sample as a picture of its own",
                  weft_acaa_form_names,
                  .group = OPTION_METHOD},
    [ASK_COINCIDENT] = {.name = "coincident",
                        0,
                        OPTION_CHOICE,
                        NULL,
                        "acaa: what is done about surfaces in the same place (default stencil: the "
                        "first one counts; mask: any one; alpha: weights are cut off; none: they "
                        "count more than once)",
                        weft_acaa_coincident_names,
                        .group = OPTION_TASK},
    [ASK_SUMS] = {.name = "sums",
                  0,
                  OPTION_CHOICE,
                  NULL,
                  "acaa: what colours are added up in (default integer, which is exact)",
                  weft_acaa_sums_names,
                  .group = OPTION_METHOD},
    [ASK_SUM_RANGE] = {.name = "sum-range",
                       0,
                       OPTION_NUMBER,
                       "R",
                       "acaa, msaa --resolve sum: the largest component of a colour, which "
                       "integers hold (default 1; acaa draws again with more where that is not "
                       "enough)",
                       .group = OPTION_METHOD},
    [ASK_ALLOW_WEIGHT] = {.name = "allow-weight",
                          0,
                          OPTION_FLAG,
                          NULL,
                          "acaa: end with 0 and a warning where pixels have not the weight of all "
                          "their samples, instead of with 1; pictures are written in any case",
                          .group = OPTION_TASK},
    [ASK_RESOLVE] = {.name = "resolve",
                     0,
                     OPTION_CHOICE,
                     NULL,
                     "msaa: how samples become a pixel: by OpenGL, or as the exact mean of "
                     "integers (default blit)",
                     weft_msaa_resolve_names,
                     .group = OPTION_METHOD},
    [ASK_DEPTH] = {.name = "depth",
                   0,
                   OPTION_CHOICE,
                   NULL,
                   "acaa, msaa, none: bits of depths, 32 are floats (default 24)",
                   antialias_depth_choices,
                   .group = OPTION_METHOD},
    [ASK_FORMAT] = {.name = "sample-format",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "all but acaa: what samples' colours are kept in (default 32f); 8 bits cut "
                    "light off at 1",
                    weft_antialias_format_names,
                    .group = OPTION_FILES},
    [ASK_MARK] = {.name = "mark",
                  0,
                  OPTION_CHOICE,
                  NULL,
                  "adaptive: pixels that edges may be in, or that visible edges are in (default "
                  "complete)",
                  weft_mark_names,
                  .group = OPTION_TASK,
                  .brief = "where pixels get more samples"},
    [ASK_CONTRAST] = {.name = "contrast",
                      0,
                      OPTION_NUMBER,
                      "C",
                      "adaptive: mark pixels, too, that differ by more from a neighbour",
                      .group = OPTION_TASK},
    [ASK_MAX_EDGE_SHARE] = {.name = "max-edge-share",
                            0,
                            OPTION_TEXT,
                            "P|P%",
                            "adaptive: mark no more than this share of the pixels, those of the "
                            "largest difference; what is left out is told with its error",
                            .group = OPTION_TASK},
    [ASK_STORE] = {.name = "store",
                   0,
                   OPTION_CHOICE,
                   NULL,
                   "adaptive, supersample: add samples up at once, or keep them in blocks as the "
                   "paper does (default sums); the same bytes",
                   weft_supersample_store_names,
                   .group = OPTION_FILES},
    [ASK_METHOD] = {.name = "method",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "adaptive, supersample: how samples are added up (default auto)",
                    weft_accumulate_method_names,
                    .group = OPTION_METHOD,
                    .brief = "of adding up"},
    [ASK_PATTERN] = {.name = "pattern",
                     0,
                     OPTION_TEXT,
                     "SET[:N]",
                     "adaptive, supersample: where in a pixel samples are, centred; help lists the "
                     "sets (default: a grid)",
                     .group = OPTION_TASK},
    [ASK_VERIFY] = {.name = "verify",
                    0,
                    OPTION_FLAG,
                    NULL,
                    "tell how far pictures are from exact ones, made by clipping of polygons; of "
                    "unlit scenes with one colour a triangle",
                    .group = OPTION_METHOD,
                    .brief = "against exact coverage"},
    [ASK_CONTEXT] = ENGINE_SPEC_CONTEXT,
    [ASK_THREADS] = OPTIONS_THREADS,
    [ASK_TYPE] =
        SAVED_TYPE_OPTION("of the picture's channels (default float)", WEFT_PIXEL_HALF + 1),
    [ASK_COMPRESSION] = SAVED_COMPRESSION_OPTION("of the EXR files (default zip)"),
    [ASK_RANGE] = {.name = "range",
                   0,
                   OPTION_RANGE,
                   "LO,HI",
                   "light shown as black and white in the preview (default 0,1)",
                   .group = OPTION_PICTURES},
    [ASK_EXPOSURE] = PREVIEW_EXPOSURE_OPTION,
    [ASK_ANNOTATE] = PREVIEW_ANNOTATE_OPTION,
    [ASK_TITLE] = PREVIEW_TITLE_OPTION,
    RANK_OPTIONS(ASK_RANKS),
    [ASK_EXPLAIN] = {.name = "explain",
                     0,
                     OPTION_FLAG,
                     NULL,
                     "print samples, passes, form, filter and bytes by formula, and exit: nothing "
                     "is drawn",
                     .group = OPTION_REPORTS,
                     .brief = "passes and bytes, without running"},
    [ASK_JSON] = OPTIONS_JSON("samples, weights, marks, bytes, statistics and times"),
    [ASK_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [ASK_QUIET] = OPTIONS_QUIET,
    [ASK_VERBOSE] = OPTIONS_VERBOSE,
};

// All ranks read the scene; rank 0 alone looks at what will be written. Then they agree.
static enum weft_result begin(struct antialias_job *job)
{
    enum weft_result res = antialias_job_read_options(job);
    if (res == WEFT_OK && ranks_tells())
        res = antialias_job_check_outputs(job);
    return ranks_agree(res == WEFT_OK ? antialias_job_begin(job) : res);
}

static enum weft_result run_stages(struct antialias_job *job)
{
    // What is planned alone is rank 0's.
    if (!ranks_tells() && job->option[ASK_EXPLAIN].given)
        return ranks_agree(WEFT_OK);
    enum weft_result res = begin(job);
    if (res != WEFT_OK || job->option[ASK_EXPLAIN].given)
        return res;
    if (!job->divided.is)
        return antialias_job_draw(job);
    res = ranks_check_alike(job->context, job->divided.request.mixed);
    return res == WEFT_OK ? antialias_job_draw_divided(job) : res;
}

static enum weft_result tell(const struct antialias_job *job)
{
    const char *chart = job->divided.request.chart;
    enum weft_result res = WEFT_OK;
    report_erase_progress();
    if (job->option[ASK_JSON].given)
        res = antialias_job_print_json(job);
    else if (job->option[ASK_EXPLAIN].given)
        antialias_job_explain(job);
    else
        antialias_job_print_text(job);
    return res == WEFT_OK && chart && job->divided.is ? load_report_plot(&job->divided.work, chart)
                                                      : res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    struct antialias_job job = {
        .option = values, .operands = operands, .prepared = -1, .start = report_now_seconds()};
    report_set_level(values[ASK_QUIET].given, values[ASK_VERBOSE].given);
    if (antialias_job_help(&job))
        return report_finish(WEFT_OK);
    enum weft_result res = run_stages(&job);
    if (res == WEFT_OK && ranks_tells())
        res = tell(&job);
    const bool whole = res != WEFT_OK || antialias_job_check_weights(&job);
    antialias_job_clear(&job);
    const int code = report_finish(res);
    return whole || code != EXIT_CODE_DONE ? code : EXIT_CODE_FAILED;
}

static const char *const epilogue[] = {
    "WAY is acaa (accumulative anti-aliasing: depths of many samples, one sum of colours), msaa "
    "(OpenGL's own), adaptive (supersampling of pixels with edges in them; the others have one "
    "sample), supersample (of all pixels) or none (one sample).",
    "acaa checks itself: the visible fragments of a pixel must have the weight of all its samples. "
    "Where surfaces lie in the same place and --coincident is none, or a scene's drawing differs "
    "between passes, they have more or less: such pixels are counted, the first is told, and the "
    "command ends with 1 unless --allow-weight.",
    "On several ranks (mpirun -n N weft antialias ...) parts of a picture are divided among them, "
    "or, of four pictures a rank and more, whole pictures: --region frame or a size asks for one "
    "or the other. The same bytes come of it. Marks of --max-edge-share are found by every rank "
    "for itself, and sums that depend on the order of fragments (--sums float, --coincident alpha) "
    "leave pictures whole. Seconds of a picture are then those of all its parts.",
    "An option that is not of the way is an error. Lamps are points in their middles. The same "
    "request gives the same bytes on one machine.",
    NULL,
};

static const char *const examples[] = {
    "weft antialias acaa --samples 16 -k mitchell -o edges.exr --preview edges.png",
    "weft antialias adaptive --scene model.obj --max-edge-share 20% -o model.exr --json",
    "weft antialias msaa --frames 20",
    NULL,
};

const struct verb verb_antialias = {
    .name = "antialias",
    .group = VERB_FRAMES,
    .summary = "smooth edges: accumulative, multisampled, adaptive anti-aliasing",
    .usage = "acaa|msaa|adaptive|supersample|none [-o OUT.exr] [options]",
    .description = "Draws a scene with smooth edges by one of five ways, and tells what it takes: "
                   "time, bytes, samples, marked pixels.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = ASK_OPTION_COUNT,
    .distributes = true,
    .run = run,
};
