// SPDX-License-Identifier: BSD-3-Clause
// weft accumulate: the weighted mean of any number of frames.
#include <stddef.h>

#include "tools/accumulate/divided.h"
#include "tools/accumulate/every.h"
#include "tools/accumulate/join.h"
#include "tools/accumulate/state.h"
#include "tools/common/ending.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"
#include "tools/verbs/verb.h"

static const char *const exr_ending[] = {".exr", NULL}, *const png_ending[] = {".png", NULL};

static const struct option_spec options[ACCUMULATE_OPTION_COUNT] = {
    [ACCUMULATE_OUTPUT] =
        {.name = "output",
         'o',
         OPTION_OUTPUT,
         "OUT.exr",
         "the mean: channels of the frames' names in the widest of their types, with the first "
         "frame's attributes and attributes that tell how it was made",
         exr_ending,
         .group = OPTION_FILES,
         .brief = "the mean"},
    [ACCUMULATE_STDERR] = {.name = "stderr",
                           0,
                           OPTION_OUTPUT,
                           "OUT.exr",
                           "the standard error of that mean, for each pixel and averaged channel, "
                           "in floats",
                           exr_ending,
                           .group = OPTION_METHOD,
                           .brief = "how well the mean is known, pixel by pixel"},
    [ACCUMULATE_PREVIEW] = {.name = "preview",
                            0,
                            OPTION_OUTPUT,
                            "OUT.png",
                            "the mean as 8-bit PNG: R, G and B in sRGB, or else one channel in a "
                            "colour map",
                            png_ending,
                            .group = OPTION_PICTURES,
                            .brief = "a picture to look at"},
    [ACCUMULATE_FRAMES] = {.name = "frames",
                           0,
                           OPTION_TEXT,
                           "FIRST-LAST[:STEP]",
                           "which numbers stand for %04d in a name (default: from the lowest to "
                           "the highest that a file has)",
                           .group = OPTION_GEOMETRY,
                           .brief = "which numbers of render_%04d.exr"},
    [ACCUMULATE_SKIP_BAD] = {.name = "skip-bad",
                             0,
                             OPTION_FLAG,
                             NULL,
                             "go on without frames that are missing, cannot be read, have another "
                             "size or other channels, or values that are refused; the exit code "
                             "is then 3",
                             .group = OPTION_FILES,
                             .brief = "leave out frames that cannot be read"},
    [ACCUMULATE_RESUME] =
        {.name = "resume",
         0,
         OPTION_TEXT,
         "STATE",
         "keep what was accumulated in this file, saved now and then and at the end, and go on "
         "from "
         "it where it is there already: the bytes of one run, whatever ended those before",
         .group = OPTION_FILES,
         .brief = "a state to go on from",
         .names = OPTION_NAMES_FILE},
    [ACCUMULATE_EVERY] = {.name = "every",
                          0,
                          OPTION_NUMBER,
                          "SECONDS",
                          "write the mean so far into the outputs, so often; SIGUSR1 does it at "
                          "once",
                          .group = OPTION_FILES,
                          .brief = "save the state so often"},
    [ACCUMULATE_PART] = {.name = "part",
                         0,
                         OPTION_TEXT,
                         "NAME|INDEX",
                         "which part of EXR files of several, from 0 (default: the first)",
                         .group = OPTION_FILES},
    [ACCUMULATE_WEIGHTS] = {.name = "weights",
                            0,
                            OPTION_TEXT,
                            "FILE|uniform|gauss[:S]|tent|KERNEL",
                            "what each frame counts (default uniform): numbers of a file, one a "
                            "line; or a shape over all frames: a Gaussian whose sigma is S of "
                            "their time (default 1/6), a tent, or a kernel over its support",
                            .group = OPTION_METHOD,
                            .brief = "of the frames: box, gauss:S, ..."},
    ACCUMULATION_OPTIONS(ACCUMULATE_ADDING, "exact, for frames of files",
                         "before the frames are read and, as bounds grow with values, after that",
                         "1",
                         "run tree, blend and float on the CPU, without OpenGL: the same bytes",
                         "and reader programs, at once (default: one a core)"),
    [ACCUMULATE_NONFINITE] = {.name = "nonfinite",
                              0,
                              OPTION_CHOICE,
                              NULL,
                              "what NaN and infinities do: end the run (default), not count, or "
                              "make the mean NaN",
                              weft_accumulate_nonfinite_names,
                              .group = OPTION_FILES},
    [ACCUMULATE_TRANSFER] = {.name = "transfer",
                             0,
                             OPTION_TEXT,
                             "auto|linear|srgb|gamma:G",
                             "what colours' codes stand for (default auto: EXR is linear; PNG is "
                             "what it says, sRGB where it says nothing); gamma: light is code ^ G",
                             .group = OPTION_FILES},
    [ACCUMULATE_AVERAGE_ALL] = {.name = "average-all",
                                0,
                                OPTION_FLAG,
                                NULL,
                                "average channels that hold no colour, too",
                                .group = OPTION_METHOD},
    [ACCUMULATE_TYPE] =
        SAVED_TYPE_OPTION("of the channels that are averaged (default: the widest of the frames')",
                          WEFT_PIXEL_HALF + 1),
    [ACCUMULATE_COMPRESSION] = SAVED_COMPRESSION_OPTION(
        "of the EXR files (default: the first frame's, or zip where weft does not write it)"),
    [ACCUMULATE_RANGE] = {.name = "range",
                          0,
                          OPTION_RANGE,
                          "LO,HI",
                          "values shown as black and white in the preview (default: in colour 0 "
                          "and 1, or else the smallest and the largest)",
                          .group = OPTION_PICTURES},
    [ACCUMULATE_COLOUR_MAP] = {.name = "colour-map",
                               0,
                               OPTION_TEXT,
                               "NAME",
                               "colours of a preview of one channel, as in weft slice",
                               .group = OPTION_PICTURES,
                               .names = OPTION_NAMES_MAP},
    [ACCUMULATE_EXPOSURE] = PREVIEW_EXPOSURE_OPTION,
    [ACCUMULATE_ANNOTATE] = PREVIEW_ANNOTATE_OPTION,
    [ACCUMULATE_TITLE] = PREVIEW_TITLE_OPTION,
    RANK_OPTIONS(ACCUMULATE_RANKS),
    [ACCUMULATE_EXPLAIN] = {.name = "explain",
                            0,
                            OPTION_FLAG,
                            NULL,
                            "print method, bound, memory and passes, and exit: no output, no "
                            "OpenGL",
                            .group = OPTION_REPORTS,
                            .brief = "bound, memory and passes, without running"},
    [ACCUMULATE_JSON] = OPTIONS_JSON("frames, weights, method, bound, statistics and times"),
    [ACCUMULATE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [ACCUMULATE_QUIET] = OPTIONS_QUIET,
    [ACCUMULATE_VERBOSE] = OPTIONS_VERBOSE,
};

typedef enum weft_result (*stage)(struct accumulate_job *job);

// A state that cannot be saved costs no result.
static enum weft_result save(struct accumulate_job *job)
{
    const enum weft_result state = state_save(job);
    job->writing = true;
    state_set_last_words(job);
    const enum weft_result res = accumulate_save(job);
    return res == WEFT_OK ? state : res;
}

// It is known now for the frames' own values, and nothing is written where it is too large.
static enum weft_result check_bound(struct accumulate_job *job)
{
    return accumulate_check_bound(job, job->report.bound);
}

// What is not refused may still be too little.
static enum weft_result read_frames(struct accumulate_job *job)
{
    const enum weft_result res = job->divided.is ? divided_read(job) : accumulate_read(job);
    report_erase_progress();
    if (res != WEFT_OK || job->added > 0 || !ranks_tells())
        return res;
    report_error("none of %lld frames could be averaged", (long long)job->counting);
    return WEFT_ERR_FORMAT;
}

// Of rank 0 alone, or of all ranks that have a part in the work.
struct step {
    stage call;
    bool alone;
};

// Up to the first one that fails; then ranks agree on what came of it.
static enum weft_result run_steps(struct accumulate_job *job, bool takes_part,
                                  const struct step *step)
{
    enum weft_result res = WEFT_OK;
    for (; step->call && res == WEFT_OK; step++)
        if (ranks_tells() || (takes_part && !step->alone))
            res = step->call(job);
    return ranks_agree(res);
}

static enum weft_result plan(struct accumulate_job *job)
{
    static const struct step naming[] = {{join_open, true},
                                         {accumulate_read_options, false},
                                         {every_check, false},
                                         {accumulate_list_frames, true},
                                         {accumulate_set_weights, true},
                                         {accumulate_check_outputs, true},
                                         {state_open, true},
                                         {accumulate_check_frames, true},
                                         {NULL, false}},
                             beginning[] = {{accumulate_look, false},
                                            {accumulate_begin, false},
                                            {join_take, true},
                                            {state_take, true},
                                            {NULL, false}};
    enum weft_result res = run_steps(job, true, naming);
    if (res == WEFT_OK) // states are joined, and plans told, by rank 0 alone
        res = ranks_share(&job->divided.is, sizeof job->divided.is);
    if (res == WEFT_OK && job->divided.is)
        res = divided_share_frames(job);
    if (res == WEFT_OK)
        res = run_steps(job, job->divided.is, beginning);
    return res == WEFT_OK && job->divided.is ? divided_share_order(job) : res;
}

static enum weft_result run_stages(struct accumulate_job *job)
{
    static const struct step computing[] = {{read_frames, false},
                                            {accumulate_make_result, true},
                                            {check_bound, true},
                                            {save, true},
                                            {NULL, false}};
    const enum weft_result res = plan(job);
    job->plan_seconds = report_now_seconds() - job->start;
    return res == WEFT_OK && !job->option[ACCUMULATE_EXPLAIN].given
               ? run_steps(job, job->divided.is, computing)
               : res;
}

static enum weft_result tell(const struct accumulate_job *job)
{
    const bool explain = job->option[ACCUMULATE_EXPLAIN].given;
    const char *chart = job->divided.request.chart;
    report_erase_progress();
    if (job->skipped)
        report_warning("%lld of %lld frames were left out", (long long)job->skipped,
                       (long long)job->counting);
    if (!explain)
        accumulate_print_text(job);
    else if (!job->option[ACCUMULATE_JSON].given)
        accumulate_explain(job);
    const enum weft_result res =
        job->option[ACCUMULATE_JSON].given ? accumulate_print_json(job) : WEFT_OK;
    return res == WEFT_OK && chart && job->divided.is
               ? load_report_plot(&job->divided.report.work, chart)
               : res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    struct accumulate_job job = {.option = values,
                                 .spec = options,
                                 .operands = operands,
                                 .first = -1,
                                 .start = report_now_seconds()};
    ending_note_requests();
    report_set_level(values[ACCUMULATE_QUIET].given, values[ACCUMULATE_VERBOSE].given);
    if (preview_help(&values[ACCUMULATE_COLOUR_MAP]))
        return report_finish(WEFT_OK);
    enum weft_result res = run_stages(&job);
    if (res == WEFT_OK && ranks_tells())
        res = tell(&job);
    const bool over_budget = job.over_budget, skipped = job.skipped > 0;
    join_clear(&job);
    state_clear(&job);
    accumulate_clear(&job);
    const int code = report_finish(res);
    return over_budget ? EXIT_CODE_FAILED : res == WEFT_OK && skipped ? EXIT_CODE_INPUT : code;
}

static const char *const epilogue[] = {
    "FRAMES are EXR or PNG files in the order in which they count: names; a name with the frame's "
    "number, as shot_%04d.exr, for all numbers from the lowest to the highest that a file has, or "
    "those of --frames; or -, a list of names on standard input, each ended by NUL or by a line "
    "end. A file whose name is written with a percent sign is that file. A number without a file "
    "is an error, unless --skip-bad is given; it keeps its place among the weights. A name that "
    "is given twice counts twice, and a warning says so.",
    "EXR is linear light with associated alpha, as it is. PNG is what its cICP, sRGB or gAMA chunk "
    "says, or sRGB, with alpha that is not associated: it becomes linear light with associated "
    "alpha before it is added. ICC profiles are not applied, and a warning says so. All frames "
    "must be of one kind, and have the same windows and channels.",
    "Channels that hold no colour are those of unsigned integers, those of a Cryptomatte, and "
    "those "
    "whose name, or a layer's name in it, is Z, ZBack, depth, id, objectId, materialId, motion, "
    "velocity, vector, forward, backward, flow or the like; Z beside X and Y in one layer is a "
    "coordinate, and averaged, as normals and positions are. They are copied from the first frame "
    "that counts, and a line says which.",
    "A file of weights has one number a line, for each frame; what follows # does not count, nor "
    "do empty lines. Frames of weight 0 are not read.",
    "The exact method adds up integers: the result is the same whatever the order of frames and "
    "the number of threads, and the bound tells the rounding of the result to a float. The bounds "
    "of the other methods are told by --explain and --json before anything runs. With --skip-bad "
    "or --until, blend and buffer keep running means, as they do not know all weights beforehand.",
    "--until looks at the frames at numbers that depend on nothing but the numbers: after the "
    "least, and whenever a sixteenth has come on top.",
    "--resume saves the state whenever 50 times the seconds that this takes have passed, and at "
    "the "
    "end, whole or not at all. A run goes on from it where the options that decide the mean, "
    "weft's "
    "version, and name, size, time of change and weight of the frames that it holds are as they "
    "were; "
    "otherwise it says what differs, and the state stays as it is. Frames may be added behind "
    "those "
    "that it holds, for exact sums anywhere behind the first. What is complete stays, and the same "
    "command then writes the result alone.",
    "States in the place of FRAMES are joined, to the bytes of one run over their frames in that "
    "order: exact sums only, of disjoint frames and one set of options, which are not given again; "
    "with --resume NEW into a state of their own. States and frames cannot be mixed.",
    "mpirun -n N weft accumulate ... divides the frames among ranks, in blocks; each reads its "
    "own, "
    "and "
    "their exact sums become one in the end: the bytes of one process. With --until, --resume and "
    "--every that is done whenever the mean so far is looked at. Methods that add frames up in "
    "their "
    "order are refused there. States are joined by one rank alone.",
    NULL,
};

static const char *const examples[] = {
    "weft accumulate render_%04d.exr -o mean.exr --stderr error.exr --preview mean.png",
    "weft accumulate a.state b.state -o mean.exr",
    NULL,
};

const struct verb verb_accumulate = {
    .name = "accumulate",
    .group = VERB_FRAMES,
    .summary = "the weighted mean of any number of frames",
    .usage = "FRAMES... [-o OUT.exr] [options]",
    .description = "Averages EXR or PNG frames of one size, any number of them, in memory that "
                   "does not depend on how many there are, with a bound of the error.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = ACCUMULATE_OPTION_COUNT,
    .many = true,
    .distributes = true,
    .operand_names = OPTION_NAMES_FILE,
    .run = run,
};
