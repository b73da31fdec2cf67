// SPDX-License-Identifier: BSD-3-Clause
// weft table: the error of sampled and quantised kernels (filter/analysis/error.h) over kernels,
// resolutions, dimensions and look-ups.
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/draw/plot.h"
#include "tools/table/job.h"
#include "tools/verbs/verb.h"

// weft_error_lookup_names, or both.
static const char *const lookups[] = {"nearest", "linear", "both", NULL};
static const char *const formats[] = {"text", "markdown", "csv", "json", "latex", NULL};

static const char *const format_endings[] = {".txt", ".md", ".csv", ".json", ".tex", NULL};
static const struct option_spec options[TABLE_OPTION_COUNT] = {
    [TABLE_KERNELS] = {.name = "kernels",
                       'k',
                       OPTION_TEXT,
                       "NAME;NAME;...",
                       "the kernels (default bspline;catmull-rom;blackman-sinc:2). A comma "
                       "separates them too, where no number follows it: "
                       "'cubic:0,0.5,kaiser-sinc:2,5.36' are two; in a list with a semicolon only "
                       "that separates",
                       .group = OPTION_FILTER,
                       .brief = "which; help lists them",
                       .names = OPTION_NAMES_KERNEL},
    [TABLE_RESOLUTIONS] = {.name = "resolutions",
                           'm',
                           OPTION_TEXT,
                           "M,M,...",
                           "samples per unit and axis, 1 to 65536 (default "
                           "16,32,64,128,256,512)",
                           .group = OPTION_FILTER,
                           .brief = "samples of a tile"},
    [TABLE_DIMS] = {.name = "dims",
                    'd',
                    OPTION_TEXT,
                    "D,D,...",
                    "dimensions of the tensor product, 1 to 3 (default 2,3)",
                    .group = OPTION_TASK,
                    .brief = "of the source: 1, 2 or 3"},
    [TABLE_BITS] = {.name = "bits",
                    'b',
                    OPTION_TEXT,
                    "B",
                    "of the texels, 1 to 24 (default 8); with --target-error a list (default "
                    "4,8,10,12,16)",
                    .group = OPTION_METHOD,
                    .brief = "of a tile"},
    [TABLE_ROUNDING] = {.name = "rounding",
                        0,
                        OPTION_CHOICE,
                        NULL,
                        "how weights are quantised (default nearest)",
                        weft_fixed_rounding_names,
                        .group = OPTION_METHOD},
    [TABLE_LOOKUP] = {.name = "lookup",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how weights are looked up (default both)",
                      lookups,
                      .group = OPTION_FILTER},
    [TABLE_SCALE] = {.name = "scale",
                     0,
                     OPTION_TEXT,
                     "S|full|power-of-two",
                     "what weights are multiplied by before they are quantised, and divided by "
                     "after the look-up (default 1); full: so that the largest is 1; "
                     "power-of-two: the largest power of two below that",
                     .group = OPTION_GEOMETRY},
    [TABLE_GRID] = {.name = "locations",
                    0,
                    OPTION_TEXT,
                    "L",
                    "resampling locations per axis, 1 to 4096 (default 1024, in 3D 256)",
                    .group = OPTION_FILES,
                    .names = OPTION_NAMES_GRID},
    [TABLE_CONVENTION] = {.name = "convention",
                          0,
                          OPTION_CHOICE,
                          NULL,
                          "eq. 4 of the paper by its plain definition, or what reproduces the "
                          "published table 1 (default eq4)",
                          weft_error_convention_names,
                          .group = OPTION_FILES},
    [TABLE_FORMAT] = {.name = "format",
                      'f',
                      OPTION_CHOICE,
                      NULL,
                      "of the table (default: as -o ends in .txt, .md, .csv, .json or .tex, else "
                      "text); csv and json have one line or object for "
                      "each cell",
                      formats,
                      .group = OPTION_FILES,
                      .brief = "text, markdown, csv, json or latex"},
    [TABLE_STATISTICS] = {.name = "statistics",
                          0,
                          OPTION_FLAG,
                          NULL,
                          "beyond the maximum: where it is, mean, RMS, percentiles, and the signed "
                          "sum, which is the ripple on a constant signal",
                          .group = OPTION_FILES},
    [TABLE_PLOT] = {.name = "plot",
                    'p',
                    OPTION_OUTPUT,
                    PLOT_VALUE,
                    "eps_h over the resolution as a picture (needs gnuplot)",
                    plot_endings,
                    .group = OPTION_PICTURES,
                    .brief = "as a picture"},
    [TABLE_TARGET_ERROR] = {.name = "target-error",
                            0,
                            OPTION_NUMBER,
                            "E",
                            "instead: the smallest resolution for each number of bits at which "
                            "eps_h is at most E, found by doubling and bisection (eps_h wavers a "
                            "little with M), where 1 is the range of samples and weights "
                            "(4 / 255 = 0.0157 is what the paper found good enough)",
                            .group = OPTION_METHOD},
    [TABLE_OUTPUT] = {.name = "output",
                      'o',
                      OPTION_OUTPUT,
                      "FILE",
                      "write the table there instead of to standard output",
                      format_endings,
                      .group = OPTION_FILES,
                      .brief = "the table"},
    [TABLE_QUIET] = OPTIONS_QUIET,
    [TABLE_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- what was asked -----------------------------------------------------------------------------

// "16,32,64": whole numbers from low to high.
static enum weft_result parse_list(const struct option_spec *spec, const char *text, int low,
                                   int high, int max_count, int *out, int *count)
{
    *count = 0;
    for (const char *at = text;; at++) {
        char *end = NULL;
        errno = 0;
        long value = isdigit((unsigned char)*at) ? strtol(at, &end, 10) : 0;
        if (!end || (*end && *end != ',')) {
            report_error("--%s %s: not %s", spec->name, text,
                         max_count > 1 ? "whole numbers, as 1,2,3" : "one whole number");
            return WEFT_ERR_ARGUMENT;
        }
        if (errno || value < low || value > high) {
            report_error("--%s %s: %.*s is not from %d to %d", spec->name, text,
                         (int)strcspn(at, ","), at, low, high);
            return WEFT_ERR_ARGUMENT;
        }
        if (*count == max_count) {
            report_error("--%s %s: more than %d", spec->name, text, max_count);
            return WEFT_ERR_ARGUMENT;
        }
        for (int i = 0; i < *count; i++) {
            if (out[i] == value) {
                report_error("--%s %s: %ld is there twice", spec->name, text, value);
                return WEFT_ERR_ARGUMENT;
            }
        }
        out[(*count)++] = (int)value;
        at = end;
        if (!*at)
            return WEFT_OK;
    }
}

static enum weft_result read_list(const struct table_job *job, enum table_option index,
                                  const char *initial, int low, int high, int max_count, int *out,
                                  int *count)
{
    const char *text = job->option[index].given ? job->option[index].text : initial;
    return parse_list(&options[index], text, low, high, max_count, out, count);
}

static enum weft_result add_kernel(struct table_job *job, const char *text, size_t length)
{
    while (length && isspace((unsigned char)*text)) {
        text++;
        length--;
    }
    while (length && isspace((unsigned char)text[length - 1]))
        length--;
    if (length == 0) {
        report_error("--kernels %s: a name is missing", job->option[TABLE_KERNELS].text);
        return WEFT_ERR_ARGUMENT;
    }
    if (job->kernel_count == TABLE_MAX_LIST) {
        report_error("--kernels: more than %d", TABLE_MAX_LIST);
        return WEFT_ERR_ARGUMENT;
    }
    struct table_kernel *kernel = &job->kernel[job->kernel_count++];
    kernel->text = strndup(text, length);
    if (!kernel->text) {
        report_error("out of memory");
        return WEFT_ERR_MEMORY;
    }
    return kernels_load(kernel->text, &kernel->kernel, &kernel->file);
}

static enum weft_result read_kernels(struct table_job *job)
{
    const bool given = job->option[TABLE_KERNELS].given;
    const char *text = given ? job->option[TABLE_KERNELS].text
                       : job->convention == WEFT_ERROR_WSCG2003
                           ? "bspline;catmull-rom;kaiser-sinc:2,5.36"
                           : "bspline;catmull-rom;blackman-sinc:2";
    const bool semicolons = strchr(text, ';');
    for (;;) {
        size_t length = kernels_list_length(text, semicolons);
        enum weft_result res = add_kernel(job, text, length);
        if (res != WEFT_OK || !text[length])
            return res;
        text += length + 1;
        if (semicolons && !*text) // "table:a,b;" is one
            return WEFT_OK;
    }
}

// ---- checks -------------------------------------------------------------------------------------

static enum weft_result check_target(const struct table_job *job)
{
    const struct option_value *o = job->option;
    if (!o[TABLE_TARGET_ERROR].given)
        return WEFT_OK;
    if (!(o[TABLE_TARGET_ERROR].number[0] > 0.0)) {
        report_error("--target-error %s: must be above 0", o[TABLE_TARGET_ERROR].text);
        return WEFT_ERR_ARGUMENT;
    }
    if (o[TABLE_STATISTICS].given || o[TABLE_PLOT].given) {
        report_error("--target-error excludes --statistics and --plot");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// The ending of the output tells it, too.
static enum weft_result read_format(struct table_job *job)
{
    const struct option_value *format = &job->option[TABLE_FORMAT];
    const struct option_value *output = &job->option[TABLE_OUTPUT];
    const bool told = output->given && output->integer[0] >= 0;
    job->format = (enum table_format)(told ? output->integer[0] : format->integer[0]);
    if (!told || !format->given || format->integer[0] == output->integer[0])
        return WEFT_OK;
    report_error("-o %s: the name of a table in %s must end in %s", output->text, format->text,
                 format_endings[format->integer[0]]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_options(struct table_job *job)
{
    const struct option_value *o = job->option;
    const bool target = o[TABLE_TARGET_ERROR].given;
    int count;
    job->rounding = (enum weft_fixed_rounding)o[TABLE_ROUNDING].integer[0];
    job->convention = (enum weft_error_convention)o[TABLE_CONVENTION].integer[0];
    const int64_t lookup = o[TABLE_LOOKUP].given ? o[TABLE_LOOKUP].integer[0] : 2;
    job->lookup_count = lookup == 2 ? 2 : 1;
    job->lookup[0] = lookup == 1 ? WEFT_ERROR_LINEAR : WEFT_ERROR_NEAREST;
    job->lookup[1] = WEFT_ERROR_LINEAR;
    enum weft_result res = read_format(job);
    if (res == WEFT_OK)
        res = check_target(job);
    if (res == WEFT_OK)
        res = read_list(job, TABLE_RESOLUTIONS, "16,32,64,128,256,512", 1, TABLE_MAX_SAMPLES,
                        TABLE_MAX_LIST, job->samples, &job->sample_count);
    if (res == WEFT_OK)
        res = read_list(job, TABLE_DIMS, "2,3", 1, TABLE_DIMENSIONS, TABLE_DIMENSIONS, job->dims,
                        &job->dim_count);
    if (res == WEFT_OK)
        res = read_list(job, TABLE_BITS, target ? "4,8,10,12,16" : "8", 1, WEFT_FIXED_MAX_BITS,
                        target ? WEFT_FIXED_MAX_BITS : 1, job->bits, &job->bit_count);
    if (res == WEFT_OK && o[TABLE_GRID].given)
        res = read_list(job, TABLE_GRID, "", 1, TABLE_MAX_GRID, 1, &job->locations, &count);
    if (res == WEFT_OK)
        res = read_kernels(job);
    return res == WEFT_OK ? table_set_scales(job) : res;
}

static enum weft_result check_outputs(const struct option_value *o)
{
    if (o[TABLE_OUTPUT].given && o[TABLE_PLOT].given &&
        paths_same_file(o[TABLE_OUTPUT].text, o[TABLE_PLOT].text)) {
        report_error("-o %s and --plot %s are the same file", o[TABLE_OUTPUT].text,
                     o[TABLE_PLOT].text);
        return WEFT_ERR_ARGUMENT;
    }
    return o[TABLE_OUTPUT].given ? paths_check_output(o[TABLE_OUTPUT].text, false) : WEFT_OK;
}

// ---- the verb -----------------------------------------------------------------------------------

static enum weft_result write_table(const struct table_job *job)
{
    if (job->format == TABLE_JSON)
        return table_print_json(job);
    if (!job->option[TABLE_OUTPUT].given)
        return table_print(job, stdout);
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    enum weft_result res = out ? table_print(job, out) : WEFT_ERR_MEMORY;
    if (out && !report_close(out))
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_file_save(report_log(), job->option[TABLE_OUTPUT].text, false, text, size);
    free(text);
    return res;
}

static int run_stages(struct table_job *job)
{
    const struct option_value *o = job->option;
    enum exit_code code = EXIT_CODE_DONE;
    enum weft_result res = read_options(job);
    if (res == WEFT_OK)
        res = check_outputs(o);
    if (res == WEFT_OK && o[TABLE_PLOT].given)
        code = plot_check("--plot", o[TABLE_PLOT].text, "--format csv");
    if (code != EXIT_CODE_DONE)
        return code;
    if (res == WEFT_OK)
        res = o[TABLE_TARGET_ERROR].given ? table_target_compute(job) : table_cells_compute(job);
    if (res == WEFT_OK && o[TABLE_PLOT].given)
        code = table_draw(job, o[TABLE_PLOT].text);
    if (code != EXIT_CODE_DONE)
        return code;
    return report_finish(res == WEFT_OK ? write_table(job) : res);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[TABLE_QUIET].given, values[TABLE_VERBOSE].given);
    if (operand) {
        report_error("'%s': weft table takes options only, as --kernels %s", operand, operand);
        return EXIT_CODE_USAGE;
    }
    struct table_job *job = calloc(1, sizeof *job);
    if (!job)
        return report_finish(WEFT_ERR_MEMORY);
    job->option = values;
    int code = run_stages(job);
    for (int k = 0; k < job->kernel_count; k++) {
        weft_kernel_file_destroy(&job->kernel[k].file);
        free(job->kernel[k].text);
    }
    free(job->cell);
    free(job);
    return code;
}

static const char *const epilogue[] = {
    "The numbers are (2^bits - 1) eps_h, eps_h = max_i sum_j |error of weight j at location i| "
    "(eq. 4): box looks weights up in the nearest texel, lin interpolates linearly. Convention "
    "wscg2003 multiplies by 2^bits, has a Kaiser window where the paper says Blackman, and marks "
    "what it does not reproduce.",
    "Kernels are named as in weft slice --kernel; weft kernel --list lists them.",
    NULL,
};

static const char *const examples[] = {
    "weft table --kernels 'mitchell;kaiser-sinc:2,5.36' --dims 2 --resolutions 64,128 -s",
    "weft table --kernels catmull-rom --dims 3 --target-error 0.02",
    NULL,
};

const struct verb verb_table = {
    .name = "table",
    .group = VERB_METHODS,
    .summary = "the error that sampled and quantised kernels make",
    .usage = "[--kernels NAME;NAME;...] [options]",
    .description =
        "Computes the filter kernel error eps_h of Hadwiger, Hauser and Moeller (Quality Issues of "
        "Hardware-Accelerated High-Quality Filtering, WSCG 2003): without options, the cells of "
        "their table 1 by their eq. 4, those included that they left out.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = TABLE_OPTION_COUNT,
    .run = run,
};
