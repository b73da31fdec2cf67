// SPDX-License-Identifier: BSD-3-Clause
// weft convert: grids of a VDB, NRRD, NIfTI or raw file, as a VDB or NRRD file.
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/json.h"
#include "tools/volumes/convert.h"
#include "tools/verbs/verb.h"
#include "tools/volumes/raw.h"

static const char *const endings[] = {".vdb", ".nrrd", NULL};

static const struct option_spec options[CONVERT_OPTION_COUNT] = {
    [CONVERT_OUTPUT] = {.name = "output",
                        'o',
                        OPTION_OUTPUT,
                        "OUT.vdb|OUT.nrrd",
                        "the volume, in place of a second name",
                        endings,
                        .group = OPTION_FILES},
    [CONVERT_GRID] = {.name = "grid",
                      0,
                      OPTION_TEXT,
                      "NAME[,NAME...]|all",
                      "which grids of the file (default: the first one that weft reads); an NRRD "
                      "file holds one",
                      .group = OPTION_FILES,
                      .brief = "which grids (all of numbers)",
                      .names = OPTION_NAMES_GRID},
    [CONVERT_RAW] = RAW_OPTION,
    [CONVERT_TYPE] = {.name = "type",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "samples of an NRRD file (default: the input's where weft's floats hold "
                      "them, else float); integers are rounded to nearest even, and warnings tell "
                      "what they do not hold",
                      weft_sample_type_names,
                      WEFT_SAMPLE_TYPE_COUNT,
                      .group = OPTION_FILES,
                      .brief = "of the voxels written"},
    [CONVERT_BACKGROUND] = {.name = "background",
                            0,
                            OPTION_NUMBER,
                            "V",
                            "of a dense grid in a VDB file: voxels of this value are background, "
                            "and bricks of nothing else are left out (default: all voxels of the "
                            "box are kept and active, and the background is 0)",
                            .group = OPTION_FILES},
    [CONVERT_PRUNE] = {.name = "prune",
                       0,
                       OPTION_NUMBER,
                       "T",
                       "with --background: so are those within T of it (default 0)",
                       .group = OPTION_METHOD},
    [CONVERT_THREADS] = OPTIONS_THREADS,
    [CONVERT_JSON] = OPTIONS_JSON("grids, files and times"),
    [CONVERT_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [CONVERT_QUIET] = OPTIONS_QUIET,
    [CONVERT_VERBOSE] = OPTIONS_VERBOSE,
};

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), wanted = strlen(end);
    return length > wanted && !strcmp(text + length - wanted, end);
}

static enum weft_result check(const struct convert_job *job)
{
    const struct option_value *tolerance = &job->option[CONVERT_PRUNE];
    if (tolerance->given && !job->option[CONVERT_BACKGROUND].given) {
        report_error("--prune says how near to --background V voxels are; it is missing");
        return WEFT_ERR_ARGUMENT;
    }
    if (tolerance->number[0] < 0.0) {
        report_error("--prune %s: it is 0 or more", tolerance->text);
        return WEFT_ERR_ARGUMENT;
    }
    if (!ends_with(job->output, ".vdb") && !ends_with(job->output, ".nrrd")) {
        report_error("%s: an output ends in .vdb or .nrrd", job->output);
        return WEFT_ERR_ARGUMENT;
    }
    if (ends_with(job->output, ".nrrd") && job->option[CONVERT_BACKGROUND].given) {
        report_error("--background is for VDB files; NRRD files have none");
        return WEFT_ERR_ARGUMENT;
    }
    const struct paths_output output = {"OUT", job->output};
    const enum weft_result res = paths_check_distinct(&output, 1, &job->input, 1);
    if (res != WEFT_OK)
        return res;
    return paths_check_output(job->output, job->option[CONVERT_NO_CLOBBER].given);
}

static enum weft_result print_json(const struct convert_job *job)
{
    json_t *grids = json_array();
    for (size_t i = 0; i < job->grid_count; i++) {
        const struct weft_volume_info *info = weft_volume_get_info(job->grid[i].volume[0]);
        json_array_append_new(grids, json_pack("{s:o,s:i,s:o,s:o}", "name", json_text(info->name),
                                               "components", info->components, "active_min",
                                               json_counts(info->active_min, 3), "active_max",
                                               json_counts(info->active_max, 3)));
    }
    return json_print(
        json_pack("{s:s,s:o}", "format", job->whole ? "nrrd" : "vdb", "grids", grids));
}

static enum weft_result convert(struct convert_job *job)
{
    enum weft_result res = check(job);
    if (res == WEFT_OK)
        res = raw_read(&job->option[CONVERT_RAW], &job->layout, &job->raw);
    job->whole = ends_with(job->output, ".nrrd");
    if (res == WEFT_OK)
        res = convert_open(job);
    if (res == WEFT_OK)
        res = !job->whole ? convert_write_vdb(job) : convert_write_nrrd(job);
    if (res == WEFT_OK && job->option[CONVERT_JSON].given)
        res = print_json(job);
    convert_clear(job);
    return res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    int count = 0;
    report_set_level(values[CONVERT_QUIET].given, values[CONVERT_VERBOSE].given);
    while (operands[count])
        count++;
    const bool named = values[CONVERT_OUTPUT].given;
    if (count + named != 2 || !count) {
        report_error("%d file%s given: weft convert IN OUT, or IN -o OUT (see weft help convert)",
                     count + named, count + named == 1 ? "" : "s");
        return EXIT_CODE_USAGE;
    }
    struct convert_job job = {.input = operands[0],
                              .output = named ? values[CONVERT_OUTPUT].text : operands[1],
                              .option = values};
    return report_finish(convert(&job));
}

static const char *const epilogue[] = {
    "Directions, spacing, origin and metadata are kept; values are floats on the way, and integers "
    "of 32 bits are written whole. A sparse grid's box of active voxels becomes an NRRD file's "
    "samples. A grid of vectors stays one: in NRRD files components are the fastest axis.",
    NULL,
};

const struct verb verb_convert = {
    .name = "convert",
    .group = VERB_VOLUMES,
    .summary = "a volume as a VDB or NRRD file",
    .usage = "IN OUT.vdb|OUT.nrrd [options]",
    .description = "Writes grids of a VDB, NRRD, NIfTI or raw file as a VDB or NRRD file. No verb "
                   "needs it: all of them read these files.",
    .epilogue = epilogue,
    .options = options,
    .option_count = CONVERT_OPTION_COUNT,
    .many = true,
    .operand_names = OPTION_NAMES_FILE,
    .writes_last = true,
    .reads_stdin = true,
    .run = run,
};
