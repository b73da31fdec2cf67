// SPDX-License-Identifier: BSD-3-Clause
// weft effect: pictures of scenes, by accumulation of frames.
#include <stddef.h>

#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/effect/job.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"
#include "tools/verbs/verb.h"

static const char *const light_endings[] = {".exr", ".tif", ".tiff", NULL};
static const char *const png_ending[] = {".png", NULL};
static const char *const centre_choices[] = {"on", "off", NULL};

static const struct option_spec options[ASK_OPTION_COUNT] = {
    [ASK_OUTPUT] = {.name = "output",
                    'o',
                    OPTION_OUTPUT,
                    "OUT.exr|.tif",
                    "the picture: linear light in R, G and B and how much of a pixel is covered in "
                    "A, with attributes that tell how it was made",
                    light_endings,
                    .group = OPTION_FILES,
                    .brief = "the picture"},
    [ASK_STDERR] = {.name = "stderr",
                    0,
                    OPTION_OUTPUT,
                    "OUT.exr|.tif",
                    "the standard error of that mean, for each pixel and channel, in floats",
                    light_endings,
                    .group = OPTION_METHOD},
    [ASK_PREVIEW] = {.name = "preview",
                     0,
                     OPTION_OUTPUT,
                     "OUT.png",
                     "the picture as 8-bit PNG in sRGB",
                     png_ending,
                     .group = OPTION_PICTURES,
                     .brief = "a picture to look at"},
    SCENE_OPTIONS(ASK_SCENES,
                  "of a fade several, with commas between them, or semicolons where there is one; "
                  "help lists them (default: one that shows the effect)",
                  "in scenes, in sets of samples, in how they are joined",
                  "the shutter is open from A to B, and scenes move from 0 to 1 (default 0..1); "
                  "without motion-blur the middle is shown",
                  "1024; of radiosity, which has many, 512"),
    [ASK_FRAMES] = {.name = "frames",
                    0,
                    OPTION_TEXT,
                    "N|auto",
                    "so many, of a fade for each scene; of radiosity so many virtual lights "
                    "(default auto: as many as motion, circles of confusion and penumbrae are "
                    "pixels wide, up to 1024)",
                    .group = OPTION_GEOMETRY,
                    .brief = "how many are accumulated"},
    [ASK_WEIGHTS] = {.name = "weights",
                     0,
                     OPTION_TEXT,
                     "W,W,...",
                     "fade: what each scene counts; they are divided by their sum (default: all "
                     "alike)",
                     .group = OPTION_METHOD},
    [ASK_AT] = {.name = "fade",
                0,
                OPTION_NUMBER,
                "T",
                "fade: the weights at a time from 0, all the first scene, to 1, all the last",
                .group = OPTION_GEOMETRY},
    [ASK_SHUTTER] = {.name = "shutter",
                     0,
                     OPTION_TEXT,
                     "box|tent|gauss[:S]|OPEN:CLOSE",
                     "motion-blur: how much light passes over that time (default box); "
                     "OPEN:CLOSE: it opens until OPEN and closes from CLOSE on, of 1",
                     .group = OPTION_TASK,
                     .brief = "when it is open"},
    [ASK_JITTER] = {.name = "jitter",
                    0,
                    OPTION_TEXT,
                    "SET[:N]",
                    "places in the pixel, on the lens and on lamps, one a frame; help lists the "
                    "sets (default: the Programming Guide's table of as many points where there "
                    "is one, else sobol)",
                    .group = OPTION_TASK},
    [ASK_CENTRE] = {.name = "centre",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "take the mean of a set off its points, so that the picture stays where it is "
                    "(default on)",
                    centre_choices,
                    .group = OPTION_GEOMETRY},
    [ASK_FILTER] = {.name = "kernel",
                    'k',
                    OPTION_TEXT,
                    "KERNEL",
                    "antialias: what a pixel sees, a product of two kernels; help lists them "
                    "(default: a box of one pixel)",
                    .group = OPTION_FILTER,
                    .names = OPTION_NAMES_KERNEL},
    [ASK_FILTER_WIDTH] = {.name = "kernel-width",
                          0,
                          OPTION_NUMBER,
                          "PIXELS",
                          "that the kernel's support is scaled to (default: as it is)",
                          .group = OPTION_FILTER},
    [ASK_APERTURE] = {.name = "aperture",
                      0,
                      OPTION_NUMBER,
                      "A",
                      "dof: the lens's diameter in the scene's unit (default: focus / 20)",
                      .group = OPTION_TASK,
                      .brief = "of the lens, for dof"},
    [ASK_FOCUS] = {.name = "focus",
                   0,
                   OPTION_NUMBER,
                   "D",
                   "dof: distance of what is in focus, along the direction of sight (default: that "
                   "of the camera's target)",
                   .group = OPTION_TASK,
                   .brief = "distance that is sharp"},
    [ASK_LIGHT_SIZE] = {.name = "light-size",
                        0,
                        OPTION_NUMBER,
                        "S",
                        "soft-shadow, radiosity: the longer side, or diameter, of lamps in the "
                        "scene's unit; their power stays",
                        .group = OPTION_TASK},
    [ASK_PATHS] = {.name = "paths",
                   0,
                   OPTION_TEXT,
                   "N",
                   "radiosity: paths from the lamps, in place of --frames: each makes several "
                   "virtual lights",
                   .group = OPTION_TASK},
    [ASK_CLAMP] = {.name = "light-clamp",
                   0,
                   OPTION_TEXT,
                   "auto|off|C",
                   "radiosity: the factor cos cos / distance^2 of a virtual light counts up to C "
                   "(default auto: a quarter of that of a patch, one of so many that all surfaces "
                   "are cut into); "
                   "what is lost is told",
                   .group = OPTION_FILTER},
    ACCUMULATION_OPTIONS(ASK_ADDING,
                         "exact where OpenGL is software, on a GPU the first of float and trees "
                         "that is within --max-error",
                         "before frames are drawn and, as bounds grow with values, after that",
                         "1, which tells rather too large an error, as the places of all frames "
                         "are spread together",
                         "average on the CPU what was drawn on OpenGL: the same bytes",
                         "that average and write (default: one a core)"),
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
                     "print frames and why so many, samples, weights, method, bound, memory and "
                     "passes, and exit: nothing is drawn",
                     .group = OPTION_REPORTS,
                     .brief = "bound, memory and passes, without running"},
    [ASK_JSON] = OPTIONS_JSON("frames, samples, weights, method, bound, statistics and times"),
    [ASK_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [ASK_QUIET] = OPTIONS_QUIET,
    [ASK_VERBOSE] = OPTIONS_VERBOSE,
};

typedef enum weft_result (*stage)(struct effect_job *job);

static enum weft_result draw(struct effect_job *job)
{
    return job->divided.is ? effect_job_draw_divided(job) : effect_job_draw(job);
}

// Of rank 0 alone, or of all ranks that have a part in the work.
struct step {
    stage call;
    bool alone;
};

// Up to the first one that fails; then ranks agree on what came of it.
static enum weft_result run_steps(struct effect_job *job, const struct step *step)
{
    enum weft_result res = WEFT_OK;
    for (; step->call && res == WEFT_OK; step++)
        if (ranks_tells() || !step->alone)
            res = step->call(job);
    return ranks_agree(res);
}

static enum weft_result run_stages(struct effect_job *job)
{
    static const struct step planning[] = {{effect_job_read_options, false},
                                           {effect_job_check_outputs, true},
                                           {effect_job_make_scenes, false},
                                           {effect_job_make_plan, false},
                                           {effect_job_begin, false},
                                           {NULL, false}},
                             drawing[] = {{draw, false},
                                          {effect_job_measure_lost, false},
                                          {effect_job_make_result, true},
                                          {effect_job_save, true},
                                          {NULL, false}};
    // What is planned alone is rank 0's.
    if (!ranks_tells() && job->option[ASK_EXPLAIN].given)
        return ranks_agree(WEFT_OK);
    const enum weft_result res = run_steps(job, planning);
    return res == WEFT_OK && !job->option[ASK_EXPLAIN].given ? run_steps(job, drawing) : res;
}

static enum weft_result tell(const struct effect_job *job)
{
    const bool explain = job->option[ASK_EXPLAIN].given;
    const char *chart = job->divided.request.chart;
    report_erase_progress();
    if (!explain)
        effect_job_print_text(job);
    else if (!job->option[ASK_JSON].given)
        effect_job_explain(job);
    const enum weft_result res = job->option[ASK_JSON].given ? effect_job_print_json(job) : WEFT_OK;
    return res == WEFT_OK && chart && job->divided.is
               ? load_report_plot(&job->divided.report.work, chart)
               : res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    struct effect_job job = {.option = values, .operands = operands, .start = report_now_seconds()};
    report_set_level(values[ASK_QUIET].given, values[ASK_VERBOSE].given);
    if (effect_job_help(&job))
        return report_finish(WEFT_OK);
    enum weft_result res = run_stages(&job);
    if (res == WEFT_OK && ranks_tells())
        res = tell(&job);
    const bool over_budget = job.over_budget;
    effect_job_clear(&job);
    const int code = report_finish(res);
    return over_budget ? EXIT_CODE_FAILED : code;
}

static const char *const epilogue[] = {
    "NAME is fade (scenes mixed in linear light), motion-blur (what moves while a shutter is "
    "open), "
    "antialias (places in a pixel, weighed by a filter), dof (a thin lens with a plane in focus), "
    "soft-shadow (lamps that have an area) or radiosity (light that surfaces throw at each other, "
    "by "
    "virtual lights, after Keller's instant radiosity). Several, as antialias+dof+motion-blur, are "
    "one integral over all their dimensions: each frame is one sample of it, and there are no more "
    "frames than one of them needs.",
    "An option of an effect that is not named is an error. Without motion-blur the middle of "
    "--time "
    "is shown, without antialias the middle of each pixel, without dof all is in focus, without "
    "soft-shadow each lamp is a point in its middle, and without radiosity there is the lamps' "
    "light and an even one from everywhere. soft-shadow and radiosity exclude each other, as the "
    "latter has soft shadows.",
    "Frames are linear light in floats, but for trees and blends of 8 and 16 bits, where light "
    "beyond --source-range is cut off. --until judges after numbers of frames that depend on "
    "nothing but the numbers, as weft accumulate does. The same request gives the same bytes on "
    "one "
    "machine.",
    "mpirun -n N weft effect ... divides the frames among ranks, in blocks, and their exact sums "
    "become one in the end, or whenever --until judges: the bytes of one process. Methods that add "
    "frames up in their order are refused there.",
    NULL,
};

static const char *const examples[] = {
    "weft effect antialias --scene polygons --frames 66 -o edges.exr --preview edges.png",
    "weft effect dof+antialias --scene teapot.obj --focus 12 --aperture 0.5 -o teapot.exr",
    "weft effect radiosity --frames 1024 --size 256x256 --preview cornell.png --json",
    NULL,
};

const struct verb verb_effect = {
    .name = "effect",
    .group = VERB_FRAMES,
    .summary = "motion blur, depth of field, soft shadows, by accumulating frames",
    .usage = "NAME[+NAME...] [-o OUT.exr] [options]",
    .description = "Draws a scene many times and averages the frames: a fade, motion blur, "
                   "anti-aliasing, depth of field, soft shadows, radiosity, or several at once.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = ASK_OPTION_COUNT,
    .distributes = true,
    .run = run,
};
