// SPDX-License-Identifier: BSD-3-Clause
// weft probe: a volume's values and derivatives at any points.
#include <stdlib.h>
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/probe/job.h"
#include "tools/verbs/verb.h"

static const char *const table_endings[] = {".csv", ".tsv", ".txt", ".json", NULL};

static const struct option_spec options[PROBE_OPTION_COUNT] = {
    [PROBE_POINTS] = {.name = "points",
                      0,
                      OPTION_TEXT,
                      "FILE.csv|-",
                      "the points, a line each with x, y and z, separated by commas, semicolons, "
                      "tabs or spaces; - is standard input. Further columns are copied. A first "
                      "line of names is one, and where x, y and z are among them these columns "
                      "count; lines that begin with # do not",
                      .group = OPTION_FILES,
                      .brief = "a table of points x, y, z; - is stdin",
                      .names = OPTION_NAMES_FILE},
    [PROBE_OUTPUT] = {.name = "output",
                      'o',
                      OPTION_OUTPUT,
                      "OUT.csv|.tsv|.txt|.json",
                      "the points with their values in further columns, each the shortest text "
                      "that reads back as the same float (default: on stdout); .json: the report, with "
                      "the points",
                      table_endings,
                      .group = OPTION_FILES,
                      .brief = "values as CSV"},
    [PROBE_QUANTITY] = {.name = "quantity",
                        0,
                        OPTION_TEXT,
                        "NAME,...",
                        "what is computed (default value): value, gradient, gradient-magnitude, "
                        "normal, hessian, laplacian, mean-curvature, gaussian-curvature, "
                        "principal-curvatures; per unit of the space of the points",
                        .group = OPTION_FILTER,
                        .brief = "values, gradients, Hessians, curvatures"},
    [PROBE_RAW] = RAW_OPTION,
    [PROBE_GRID] = {.name = "grid",
                    0,
                    OPTION_TEXT,
                    "NAME",
                    "which grid of the file (default: the first scalar one); all components of a "
                    "grid of vectors",
                    .group = OPTION_FILES,
                    .brief = "which grids (the first one)",
                    .names = OPTION_NAMES_GRID},
    [PROBE_KERNEL] = {.name = "kernel",
                      'k',
                      OPTION_TEXT,
                      "NAME[:p,q]|table:FILE",
                      "the reconstruction kernel (default catmull-rom), as in weft slice; 'help' "
                      "lists them. Derivatives are its own",
                      .group = OPTION_FILTER,
                      .brief = "which kernel (catmull-rom); help lists them",
                      .names = OPTION_NAMES_KERNEL},
    [PROBE_NORMALISE] = KERNELS_NORMALISE_OPTION,
    [PROBE_SPACE] = {.name = "space",
                     0,
                     OPTION_CHOICE,
                     NULL,
                     "what the coordinates mean (default world)",
                     weft_space_names,
                     .group = OPTION_GEOMETRY,
                     .brief = "of the points: world or index"},
    [PROBE_SUMS] = {.name = "sums",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "what products are added up in (default float)",
                    weft_sums_names,
                    .group = OPTION_METHOD},
    [PROBE_THREADS] = OPTIONS_THREADS,
    [PROBE_MEMORY] = {.name = "memory",
                      0,
                      OPTION_BYTES,
                      "BYTES",
                      "bound for voxels and what points are sorted by (default 1G, at least 1M); "
                      "the text of the points and their values is kept in memory beside",
                      .group = OPTION_RESOURCES},
    [PROBE_EXPLAIN] = {.name = "explain",
                       0,
                       OPTION_FLAG,
                       NULL,
                       "print what would be computed, and its error bounds, and exit",
                       .group = OPTION_REPORTS},
    [PROBE_VERIFY] = {.name = "verify",
                      0,
                      OPTION_FLAG,
                      NULL,
                      "recompute derivatives at some of the points in double precision, and tell "
                      "on stderr the largest difference beside the bound",
                      .group = OPTION_METHOD,
                      .brief = "measure the error against double precision"},
    [PROBE_JSON] = OPTIONS_JSON("what was done, without -o with the points and their values"),
    [PROBE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [PROBE_QUIET] = OPTIONS_QUIET,
    [PROBE_VERBOSE] = OPTIONS_VERBOSE,
};

static enum weft_result read_kernel(struct probe_job *job)
{
    const struct option_value *o = job->option;
    const struct weft_quantities *q = &job->quantities;
    enum weft_result res =
        kernels_load_filter(o[PROBE_KERNEL].given ? o[PROBE_KERNEL].text : "catmull-rom", 3,
                            &job->kernel, &job->kernel_file);
    // Weights that are divided by their sum have no derivative: only where it is asked for.
    bool derived = false;
    for (int d = 0; d < q->derivative_count; d++) {
        const int *n = q->derivative[d].along;
        derived = derived || n[0] + n[1] + n[2] > 0;
    }
    if (res == WEFT_OK && !job->kernel.radial && (!derived || o[PROBE_NORMALISE].given))
        res = kernels_normalise(&o[PROBE_NORMALISE], 3, job->kernel_file, &job->kernel);
    return res;
}

static enum weft_result check_files(const struct probe_job *job)
{
    const struct option_value *o = job->option;
    const char *points = o[PROBE_POINTS].text;
    const struct paths_output output = {"-o", o[PROBE_OUTPUT].text};
    const char *const inputs[] = {job->input, strcmp(points, "-") ? points : NULL};
    enum weft_result res = paths_check_distinct(&output, 1, inputs, 2);
    if (res == WEFT_OK && o[PROBE_OUTPUT].given && !o[PROBE_EXPLAIN].given)
        res = paths_check_output(o[PROBE_OUTPUT].text, o[PROBE_NO_CLOBBER].given);
    return res;
}

static enum weft_result check_options(struct probe_job *job)
{
    const struct option_value *o = job->option;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    job->threads = weft_cpu_threads();
    if (o[PROBE_QUIET].given && o[PROBE_VERBOSE].given)
        report_error("-q and -v exclude each other");
    else if (!o[PROBE_POINTS].given)
        report_error("no points given: --points FILE.csv, or - for standard input");
    else if (strcmp(o[PROBE_POINTS].text, "-") == 0 && strcmp(job->input, "/dev/stdin") == 0)
        report_error("the volume and --points are both standard input");
    else if (probe_writes_json(job) && o[PROBE_JSON].given)
        report_error("--json and -o %s are the same report: give one of them",
                     o[PROBE_OUTPUT].text);
    else
        res = options_read_whole(&o[PROBE_THREADS], "threads", 1, WEFT_CPU_MAX_THREADS,
                                 &job->threads);
    if (res == WEFT_OK)
        res = weft_quantities_parse(report_log(),
                                    o[PROBE_QUANTITY].given ? o[PROBE_QUANTITY].text : "value",
                                    &job->quantities);
    if (res == WEFT_OK)
        res = read_kernel(job);
    return res == WEFT_OK ? check_files(job) : res;
}

static enum weft_result read_points(struct probe_job *job)
{
    const double start = report_now_seconds();
    const char *path = job->option[PROBE_POINTS].text;
    report_stage("reading", strcmp(path, "-") ? path : "standard input");
    const enum weft_result res = probe_table_read(path, job->threads, &job->table);
    report_erase_progress();
    job->read_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result write_results(struct probe_job *job)
{
    const struct option_value *o = job->option;
    const double start = report_now_seconds();
    const char *path = o[PROBE_OUTPUT].given ? o[PROBE_OUTPUT].text : "/dev/stdout";
    enum weft_result res = WEFT_OK;
    const bool json = probe_writes_json(job);
    if (!json && !paths_is_stdout(path))
        report_stage("writing", path);
    if (!json && (o[PROBE_OUTPUT].given || !o[PROBE_JSON].given))
        res = probe_write(job, path);
    report_erase_progress();
    job->write_seconds = report_now_seconds() - start;
    if (res == WEFT_OK)
        probe_report(job);
    if (json)
        json_report_to(o[PROBE_OUTPUT].text);
    return res == WEFT_OK && (json || o[PROBE_JSON].given) ? probe_print_json(job) : res;
}

static enum weft_result explain(struct probe_job *job)
{
    if (job->option[PROBE_JSON].given)
        return probe_print_json(job);
    probe_explain(job);
    return WEFT_OK;
}

// The reader starts while the points are read.
static enum weft_result run_stages(struct probe_job *job)
{
    const struct option_value *o = job->option;
    enum weft_result res = check_options(job);
    if (res == WEFT_OK)
        res = raw_read(&o[PROBE_RAW], &job->layout, &job->raw);
    if (res == WEFT_OK)
        res = weft_volume_begin(weft_volume_open_params(.path = job->input, .raw = job->raw,
                                                        .grid = o[PROBE_GRID].text,
                                                        .log = report_log()),
                                &job->opening);
    if (res == WEFT_OK)
        res = read_points(job);
    const double start = report_now_seconds();
    if (res == WEFT_OK)
        res = probe_sample(job);
    report_erase_progress();
    job->sample_seconds = report_now_seconds() - start;
    if (res != WEFT_OK)
        return res;
    return o[PROBE_EXPLAIN].given ? explain(job) : write_results(job);
}

static bool is_verified(const struct probe_job *job)
{
    bool good = true;
    for (int d = 0; job->option[PROBE_VERIFY].given && good && d < job->info.output_count; d++) {
        const struct weft_verify_report *e = &job->error[d];
        const int *n = job->quantities.derivative[d].along;
        char what[60];
        snprintf(what, sizeof what, "derivative %d%d%d", n[0], n[1], n[2]);
        good = report_verdict(what, e->maximum, e->bound, e->not_finite_mismatches);
    }
    return good;
}

static int run(const char *const *operands, const struct option_value *values)
{
    report_set_level(values[PROBE_QUIET].given, values[PROBE_VERBOSE].given);
    if (options_ask_for_help(&values[PROBE_KERNEL])) {
        kernels_print();
        return report_finish(WEFT_OK);
    }
    if (!operands[0]) {
        report_error("no volume given: weft probe VOLUME --points FILE.csv ... (see weft help "
                     "probe)");
        return EXIT_CODE_USAGE;
    }
    struct probe_job job = {.input = operands[0], .option = values, .start = report_now_seconds()};
    int code = report_finish(run_stages(&job));
    if (code == EXIT_CODE_DONE && !values[PROBE_EXPLAIN].given && !is_verified(&job))
        code = EXIT_CODE_FAILED;
    weft_volume_abandon(&job.opening);
    probe_table_clear(&job.table);
    weft_kernel_file_destroy(&job.kernel_file);
    free(job.channels);
    return code;
}

static const char *const epilogue[] = {
    "Values are those of weft slice at the same positions, within both error bounds. Outside the "
    "stored voxels the grid's background value holds, which one warning tells; points with a "
    "coordinate that is nan or infinite have the value nan.",
    "Gradients, Hessians and what is made of them are per unit of world space, or per voxel with "
    "--space index, and of the kernel's own derivatives: kernels that have none are refused. "
    "Weights that are divided by their sum have none, so that --normalise is off for them by "
    "default.",
    "The same points give the same bytes, whatever their order and the number of threads.",
    NULL,
};

static const char *const examples[] = {
    "weft probe smoke.vdb --points track.csv --quantity value,gradient -o values.csv",
    NULL,
};

const struct verb verb_probe = {
    .name = "probe",
    .group = VERB_VOLUMES,
    .summary = "a volume's values and derivatives at any points, as CSV or JSON",
    .usage = "VOLUME --points FILE.csv|- [--quantity value,gradient,...] [-o OUT.csv] [options]",
    .description = "Reconstructs a scalar grid, or each component of a grid of vectors, at points "
                   "that a table lists: its value, gradient, Hessian, curvatures. Only the bricks "
                   "that the points touch are read.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = PROBE_OPTION_COUNT,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
