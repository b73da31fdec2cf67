// SPDX-License-Identifier: BSD-3-Clause
// weft accumulate: the weighted mean of any number of frames.
#include <stddef.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"
#include "tools/common/saved.h"
#include "tools/verbs/verb.h"

static const char *const exr_ending[] = {".exr", NULL};

static const struct option_spec options[ACCUMULATE_OPTION_COUNT] = {
    [ACCUMULATE_OUTPUT] = {.name = "output",
                           'o',
                           OPTION_OUTPUT,
                           "OUT.exr",
                           "the mean: channels of the frames' names, in the widest of their types",
                           exr_ending},
    [ACCUMULATE_TYPE] = SAVED_TYPE_OPTION("of the channels that are averaged", WEFT_PIXEL_HALF + 1),
    [ACCUMULATE_COMPRESSION] = SAVED_COMPRESSION_OPTION(
        "of the file (default: the first frame's, or zip where weft does not write it)"),
    [ACCUMULATE_SKIP_BAD] = {.name = "skip-bad",
                             0,
                             OPTION_FLAG,
                             NULL,
                             "go on without frames that are missing or cannot be read"},
    [ACCUMULATE_THREADS] =
        {.name = "threads", 0, OPTION_NUMBER, "N", "at once (default: one a core)"},
    [ACCUMULATE_EXPLAIN] = {.name = "explain",
                            0,
                            OPTION_FLAG,
                            NULL,
                            "print what would be done and exit: no pixel is read"},
    [ACCUMULATE_JSON] = {.name = "json", 0, OPTION_FLAG, NULL, "print a report as JSON on stdout"},
    [ACCUMULATE_NO_CLOBBER] =
        {.name = "no-clobber", 0, OPTION_FLAG, NULL, "refuse to replace an output"},
    [ACCUMULATE_QUIET] =
        {.name = "quiet", 'q', OPTION_FLAG, NULL, "only errors, and what was asked for"},
    [ACCUMULATE_VERBOSE] = {.name = "verbose", 'v', OPTION_FLAG, NULL, "say what is done"},
};

typedef enum weft_result (*stage)(struct accumulate_job *job);

static enum weft_result run_stages(struct accumulate_job *job)
{
    static const stage stages[] = {accumulate_begin, accumulate_read, accumulate_make_result,
                                   accumulate_save, NULL};
    enum weft_result res = accumulate_list_frames(job);
    if (res == WEFT_OK)
        res = accumulate_check_files(job);
    for (const stage *s = stages; *s && res == WEFT_OK; s++)
        res = (*s)(job);
    return res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    struct accumulate_job job = {.option = values,
                                 .operands = operands,
                                 .first = -1,
                                 .threads = (int)values[ACCUMULATE_THREADS].number[0],
                                 .start = report_now_seconds()};
    report_set_level(values[ACCUMULATE_QUIET].given, values[ACCUMULATE_VERBOSE].given);
    if (!operands[0]) {
        report_error("no frames given: weft accumulate FRAMES... -o OUT.exr (see weft help "
                     "accumulate)");
        return EXIT_CODE_USAGE;
    }
    const enum weft_result res = run_stages(&job);
    accumulate_clear(&job);
    return report_finish(res);
}

static const char *const epilogue[] = {"weft accumulate frame_*.exr -o mean.exr", NULL};

const struct verb verb_accumulate = {
    .name = "accumulate",
    .summary = "the weighted mean of any number of frames",
    .usage = "FRAMES... -o OUT.exr [options]",
    .description = "Averages EXR images of one size, any number of them, in memory that does not "
                   "depend on how many there are.",
    .epilogue = epilogue,
    .options = options,
    .option_count = ACCUMULATE_OPTION_COUNT,
    .many = true,
    .run = run,
};
