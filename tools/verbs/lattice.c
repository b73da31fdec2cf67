// SPDX-License-Identifier: BSD-3-Clause
// weft lattice: a volume on another lattice, sparse in, sparse out.
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/lattice/job.h"
#include "tools/verbs/verb.h"

static const char *const vdb_ending[] = {".vdb", NULL};
static const char *const on_off[] = {"on", "off", NULL};

static const struct option_spec options[LATTICE_OPTION_COUNT] = {
    [LATTICE_OUTPUT] = {.name = "output",
                        'o',
                        OPTION_OUTPUT,
                        "OUT.vdb",
                        "the volume, with the grids' names, classes and metadata",
                        vdb_ending,
                        .group = OPTION_FILES,
                        .brief = "the volume"},
    [LATTICE_SCALE] = {.name = "scale",
                       0,
                       OPTION_SPACING,
                       "S|SX,SY,SZ",
                       "so many voxels for one of the source, along each index axis: 2 doubles, "
                       "0.5 halves. Voxel (0, 0, 0) stays where it is",
                       .group = OPTION_GEOMETRY,
                       .brief = "so many voxels for one"},
    [LATTICE_VOXEL] = {.name = "voxel",
                       0,
                       OPTION_SPACING,
                       "SIZE|SX,SY,SZ",
                       "instead of --scale: the result's voxel size, in the world's unit",
                       .group = OPTION_GEOMETRY,
                       .brief = "or the result's voxel size"},
    [LATTICE_LIKE] =
        {.name = "like",
         0,
         OPTION_TEXT,
         "OTHER.vdb",
         "instead of --scale: the lattice of another file's first grid, and its box of "
         "active voxels; beyond it the background holds",
         .group = OPTION_FILES,
         .brief = "or another file's lattice",
         .names = OPTION_NAMES_FILE},
    [LATTICE_MATRIX] = {.name = "matrix",
                        0,
                        OPTION_TEXT,
                        "a,b,...,l",
                        "move the volume by an affine matrix of world space: what is at (x, y, z) "
                        "comes to (a x + b y + c z + d, e x + f y + g z + h, i x + j y + k z + l), "
                        "on the lattice that it had, or the one that is asked for",
                        .group = OPTION_GEOMETRY,
                        .brief = "move it in the world"},
    [LATTICE_RAW] = RAW_OPTION,
    [LATTICE_GRID] = {.name = "grid",
                      0,
                      OPTION_TEXT,
                      "NAME|all",
                      "which grid of the file (default: the first scalar one), or all of numbers",
                      .group = OPTION_FILES,
                      .brief = "which grid, or all",
                      .names = OPTION_NAMES_GRID},
    [LATTICE_KERNEL] = {.name = "kernel",
                        'k',
                        OPTION_TEXT,
                        "NAME[:p,q]|table:FILE",
                        "the reconstruction kernel (default catmull-rom), as in weft slice; 'help' "
                        "lists them",
                        .group = OPTION_FILTER,
                        .brief = "which kernel (catmull-rom); help lists them",
                        .names = OPTION_NAMES_KERNEL},
    [LATTICE_NORMALISE] = KERNELS_NORMALISE_OPTION,
    [LATTICE_ANTIALIAS] = {.name = "antialias",
                           0,
                           OPTION_CHOICE,
                           NULL,
                           "stretch the kernel along axes on which voxels lie farther apart than "
                           "the source's (default on)",
                           on_off,
                           .group = OPTION_FILTER},
    [LATTICE_QUANTITY] = {.name = "quantity",
                          0,
                          OPTION_TEXT,
                          "NAME,...",
                          "a grid for each of value (default), gradient, gradient-magnitude, "
                          "normal, hessian (six), laplacian, mean-curvature, gaussian-curvature, "
                          "principal-curvatures (two); gradients and normals are grids of vectors",
                          .group = OPTION_FILTER,
                          .brief = "grids of derivatives"},
    [LATTICE_SPACE] = {.name = "space",
                       0,
                       OPTION_CHOICE,
                       NULL,
                       "of derivatives: per unit of the world, or per voxel of the source (default "
                       "world)",
                       weft_space_names,
                       .group = OPTION_GEOMETRY},
    [LATTICE_PRUNE] = {.name = "prune",
                       0,
                       OPTION_NUMBER,
                       "T",
                       "voxels within T of the background become the background (default 0)",
                       .group = OPTION_FILTER},
    [LATTICE_MEMORY] = {.name = "memory",
                        0,
                        OPTION_BYTES,
                        "BYTES",
                        "bound for voxels of both lattices in weft, K, M or G for powers of 1024 "
                        "(default 1G)",
                        .group = OPTION_RESOURCES},
    [LATTICE_OUTPUT_MEMORY] = {.name = "output-memory",
                               0,
                               OPTION_BYTES,
                               "BYTES",
                               "bound for the result's voxels in the program that writes them, "
                               "which holds all of them (default 4G)",
                               .group = OPTION_RESOURCES},
    [LATTICE_EXPLAIN] = {.name = "explain",
                         0,
                         OPTION_FLAG,
                         NULL,
                         "print the plan and exit: no voxel is read",
                         .group = OPTION_REPORTS,
                         .brief = "the plan, without running it"},
    [LATTICE_VERIFY] = {.name = "verify",
                        0,
                        OPTION_FLAG,
                        NULL,
                        "recompute a random sample of the voxels in double precision, all where "
                        "that takes less than about 10 s; fails where one is beyond its bound",
                        .group = OPTION_METHOD,
                        .brief = "measure the error against double precision"},
    [LATTICE_THREADS] = OPTIONS_THREADS,
    [LATTICE_JSON] = OPTIONS_JSON("plan, counts, memory and times"),
    [LATTICE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [LATTICE_QUIET] = OPTIONS_QUIET,
    [LATTICE_VERBOSE] = OPTIONS_VERBOSE,
};

static const char *option_conflict(const struct option_value *o)
{
    const int ways = o[LATTICE_SCALE].given + o[LATTICE_VOXEL].given + o[LATTICE_LIKE].given;
    if (ways > 1)
        return "--scale, --voxel and --like exclude each other";
    if (ways == 0 && !o[LATTICE_MATRIX].given && !o[LATTICE_QUANTITY].given)
        return "no lattice given: --scale S, --voxel SIZE, --like OTHER.vdb or --matrix a,...,l "
               "(or --quantity, on the volume's own)";
    if (o[LATTICE_QUIET].given && o[LATTICE_VERBOSE].given)
        return "-q and -v exclude each other";
    if (o[LATTICE_PRUNE].given && o[LATTICE_PRUNE].number[0] < 0.0)
        return "--prune: it is a distance, 0 or more";
    if (!o[LATTICE_OUTPUT].given && !o[LATTICE_EXPLAIN].given && !o[LATTICE_VERIFY].given &&
        !o[LATTICE_JSON].given)
        return "nothing to do: give -o OUT.vdb, --verify, --json or --explain";
    return NULL;
}

static enum weft_result check_output(const struct lattice_job *job)
{
    const struct option_value *o = job->option;
    if (!o[LATTICE_OUTPUT].given || o[LATTICE_EXPLAIN].given)
        return WEFT_OK;
    const struct paths_output output = {"-o", o[LATTICE_OUTPUT].text};
    const char *const input[] = {job->input, o[LATTICE_LIKE].text};
    const enum weft_result res = paths_check_distinct(&output, 1, input, 2);
    return res == WEFT_OK ? paths_check_output(output.path, o[LATTICE_NO_CLOBBER].given) : res;
}

static enum weft_result read_options(struct lattice_job *job)
{
    const struct option_value *o = job->option;
    const char *conflict = option_conflict(o);
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = raw_read(&o[LATTICE_RAW], &job->layout, &job->raw);
    if (res == WEFT_OK)
        res = lattice_read_matrix(job);
    if (res == WEFT_OK && o[LATTICE_KERNEL].given) {
        res = kernels_load_filter(o[LATTICE_KERNEL].text, 3, &job->kernel, &job->kernel_file);
        if (res == WEFT_OK && !job->kernel.radial) // which lattices refuse
            res = kernels_normalise(&o[LATTICE_NORMALISE], 3, job->kernel_file, &job->kernel);
    }
    if (res == WEFT_OK && o[LATTICE_QUANTITY].given)
        res = weft_quantities_parse(report_log(), o[LATTICE_QUANTITY].text, &job->quantities);
    return res == WEFT_OK ? check_output(job) : res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    struct lattice_job job = {
        .input = operands[0], .option = values, .start = report_now_seconds()};
    report_set_level(values[LATTICE_QUIET].given, values[LATTICE_VERBOSE].given);
    if (options_ask_for_help(&values[LATTICE_KERNEL])) {
        kernels_print();
        return report_finish(WEFT_OK);
    }
    if (!job.input) {
        report_error("no volume given: weft lattice VOLUME ... (see weft help lattice)");
        return EXIT_CODE_USAGE;
    }
    const bool explain = values[LATTICE_EXPLAIN].given;
    enum weft_result res = read_options(&job);
    if (res == WEFT_OK)
        res = lattice_plan(&job);
    if (res == WEFT_OK && !explain)
        res = lattice_run(&job);
    report_erase_progress();
    if (res == WEFT_OK && values[LATTICE_JSON].given)
        res = lattice_print_json(&job);
    else if (res == WEFT_OK && explain)
        lattice_explain(&job);
    else if (res == WEFT_OK)
        lattice_print_text(&job);
    const bool verified = res != WEFT_OK || explain || lattice_verdict(&job);
    lattice_clear(&job);
    const int code = report_finish(res);
    return verified ? code : EXIT_CODE_FAILED;
}

static const char *const epilogue[] = {
    "Voxels are points at integer coordinates, in both lattices: with --scale 2 every second voxel "
    "lies on one of the source's, and nothing is shifted. Where the volume lies in the world stays "
    "as it is, but for --matrix.",
    "Sparse in, sparse out: only bricks whose kernels meet a brick of the source, or a tile that "
    "is "
    "not the background, are computed; everywhere else the background holds, exactly, and constant "
    "tiles stay tiles. Level sets stay level sets: values are distances in the world's unit, "
    "within "
    "the background's, whatever the lattice.",
    "Where the result's axes run along the source's, in any order and direction, one axis is "
    "filtered after another; else all taps at once. Sums are in double. Where voxels lie farther "
    "apart than the source's the kernel is stretched, so that nothing aliases.",
    "The same request gives the same bytes, whatever the number of threads and the memory. The "
    "output appears whole or not at all.",
    NULL,
};

static const char *const examples[] = {
    "weft lattice smoke.vdb --scale 2 -o double.vdb --verify",
    "weft lattice mri.vdb --like other.vdb --kernel bspline3i -o matched.vdb",
    "weft lattice smoke.vdb --quantity gradient,laplacian -o derivatives.vdb",
    NULL,
};

const struct verb verb_lattice = {
    .name = "lattice",
    .group = VERB_VOLUMES,
    .summary = "a volume on another lattice: scaled, moved, or like another one",
    .usage = "VOLUME --scale S|--voxel SIZE|--like OTHER.vdb|--matrix a,...,l -o OUT.vdb "
             "[options]",
    .description = "Reconstructs the grids of a volume on another lattice, and what their "
                   "derivatives make, sparse, in bounded memory.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = LATTICE_OPTION_COUNT,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
