// SPDX-License-Identifier: BSD-3-Clause
// weft slice: a planar cut through a volume as EXR and PNG.
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/methods/plan_options.h"
#include "tools/draw/preview.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/save.h"
#include "tools/slice/stages.h"
#include "tools/slice/sweep.h"
#include "tools/verbs/verb.h"

static const char *const axes[] = {"x", "y", "z", NULL};
static const char *const flips[] = {"x", "y", "xy", NULL};

static const char *const png_ending[] = {".png", NULL};
static const char *const exr_ending[] = {".exr", NULL};
static const struct option_spec options[SLICE_OPTION_COUNT] = {
    [SLICE_OUTPUT] =
        {.name = "output",
         'o',
         OPTION_OUTPUT,
         "OUT.exr",
         "the slice: the channel Y, or those of --grid and --quantity, with attributes that tell "
         "how it was made",
         exr_ending,
         .group = OPTION_FILES,
         .brief = "the slice, as floats"},
    [SLICE_TYPE] = SAVED_TYPE_OPTION(
        "of its channels (default float); half is rounded to nearest even, and a warning tells "
        "what it does not hold",
        WEFT_PIXEL_HALF + 1),
    [SLICE_COMPRESSION] = SAVED_COMPRESSION_OPTION("of that file (default zip)"),
    [SLICE_PREVIEW] = {.name = "preview",
                       0,
                       OPTION_OUTPUT,
                       "OUT.png",
                       "the slice as 8-bit PNG",
                       png_ending,
                       .group = OPTION_PICTURES,
                       .brief = "a picture to look at"},
    [SLICE_GRID] = {.name = "grid",
                    0,
                    OPTION_TEXT,
                    "NAME,...|all",
                    "which grids of the file (default: the first scalar one, or of vectors): of "
                    "one of vectors the channels X, Y and Z; of several, channels by their names",
                    .group = OPTION_FILES,
                    .brief = "which grids (the first one)",
                    .names = OPTION_NAMES_GRID},
    [SLICE_RAW] = RAW_OPTION,
    [SLICE_QUANTITY] = {.name = "quantity",
                        0,
                        OPTION_TEXT,
                        "NAME,...",
                        "what is shown of each grid, in world units (default value): value, "
                        "gradient, gradient-magnitude, normal, hessian, laplacian, mean-curvature, "
                        "gaussian-curvature, principal-curvatures; channels by these names",
                        .group = OPTION_FILTER,
                        .brief = "values, gradients, normals, curvatures"},
    [SLICE_KERNEL] = {.name = "kernel",
                      'k',
                      OPTION_TEXT,
                      "NAME[:p,q]|table:FILE",
                      "the reconstruction kernel (default catmull-rom), NAME+unit for weights "
                      "that add up to 1, table:FILE for one's own; 'help' lists them",
                      .group = OPTION_FILTER,
                      .brief = "which kernel (catmull-rom); help lists them",
                      .names = OPTION_NAMES_KERNEL},
    [SLICE_NORMALISE] = KERNELS_NORMALISE_OPTION,
    [SLICE_SIZE] = {.name = "size",
                    0,
                    OPTION_TEXT,
                    "WxH|Wx0|0xH|N",
                    "pixels; 0 follows from the other so that pixels are square in world space, N "
                    "is the longer side (default 1024)",
                    .group = OPTION_GEOMETRY,
                    .brief = "pixels; N: the longer side (1024)"},
    [SLICE_AXIS] = {.name = "axis",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "cut across this axis, the active box and half a voxel around it "
                    "(default z)",
                    axes,
                    .group = OPTION_GEOMETRY,
                    .brief = "across which axis (z)"},
    [SLICE_AT] =
        {.name = "at",
         0,
         OPTION_TEXT,
         "COORD|P%|A..B",
         "where on that axis, or how far through the box (default 50%); with --frames from "
         "A at FIRST to B at LAST",
         .group = OPTION_GEOMETRY,
         .brief = "where on the axis, or how far through (50%)"},
    [SLICE_ORIGIN] = {.name = "origin",
                      0,
                      OPTION_POINT,
                      "X,Y,Z",
                      "instead of --axis and --at: the corner where pixel (0, 0) lies, with --u "
                      "and --v",
                      .group = OPTION_GEOMETRY,
                      .brief = "a corner, and then --u and --v, for any plane"},
    [SLICE_U] = {.name = "u",
                 0,
                 OPTION_POINT,
                 "X,Y,Z",
                 "the edge along the rows",
                 .group = OPTION_GEOMETRY},
    [SLICE_V] = {.name = "v",
                 0,
                 OPTION_POINT,
                 "X,Y,Z",
                 "the edge down the columns",
                 .group = OPTION_GEOMETRY},
    [SLICE_UP] = {.name = "up",
                  0,
                  OPTION_TEXT,
                  "x|-x|y|-y|z|-z|X,Y,Z",
                  "the direction that points up in the picture. Of --axis the other axis then "
                  "grows to the right; of --origin, --u and --v the nearest edge is turned up. By "
                  "itself row 0, on top, is where v begins, as scanners store slices: up is -y "
                  "across z, else -z",
                  .group = OPTION_GEOMETRY,
                  .brief = "what points up in the picture: y, -z, ..."},
    [SLICE_FLIP] = {.name = "flip",
                    0,
                    OPTION_CHOICE,
                    NULL,
                    "then mirror the picture: left and right, top and bottom, or both",
                    flips,
                    .group = OPTION_GEOMETRY},
    [SLICE_BOX] = {.name = "box",
                   0,
                   OPTION_TEXT,
                   "all|first|X0,Y0,Z0,X1,Y1,Z1",
                   "what planes of --axis show: the active box of the volume, with --frames and a "
                   "volume each of all of them (default) or of the first, or the box that is given",
                   .group = OPTION_GEOMETRY},
    [SLICE_SLAB] =
        {.name = "slab",
         0,
         OPTION_NUMBER,
         "THICKNESS",
         "cut a slab so thick, in world units, centred on the plane: cuts at most half a "
         "voxel apart are combined",
         .group = OPTION_GEOMETRY,
         .brief = "of a slab that is so thick: mean, max, min, sum"},
    [SLICE_COMBINE] = {.name = "combine",
                       0,
                       OPTION_CHOICE,
                       NULL,
                       "what is made of a slab's cuts (default mean); sum: the integral over the "
                       "thickness, the mean times it",
                       weft_combine_names,
                       .group = OPTION_GEOMETRY},
    [SLICE_POSITIONS] = {.name = "positions",
                         0,
                         OPTION_TEXT,
                         "P.exr",
                         "a curved slice: where each pixel lies, in channels X, Y and Z; NaN gives "
                         "NaN",
                         .group = OPTION_GEOMETRY,
                         .names = OPTION_NAMES_FILE},
    [SLICE_ALONG] = {.name = "along",
                     0,
                     OPTION_TEXT,
                     "FILE",
                     "a straightened slice: along a line through the points of a file, X,Y,Z a "
                     "line, and --width across it",
                     .group = OPTION_GEOMETRY,
                     .names = OPTION_NAMES_FILE},
    [SLICE_WIDTH] = {.name = "width",
                     0,
                     OPTION_NUMBER,
                     "W",
                     "how wide a slice --along a line is, in the points' unit",
                     .group = OPTION_GEOMETRY},
    [SLICE_FRAMES] =
        {.name = "frames",
         0,
         OPTION_TEXT,
         "FIRST-LAST[:STEP]",
         "make a slice for each of these numbers, which stands in the outputs' names as %04d, "
         "along --at A..B, --step or --planes, or of a volume each, with %04d in its name",
         .group = OPTION_GEOMETRY,
         .brief = "many slices, or one of each of many files"},
    [SLICE_STEP] = {.name = "step",
                    0,
                    OPTION_POINT,
                    "X,Y,Z",
                    "with --frames: --origin moves by this from number to number",
                    .group = OPTION_GEOMETRY},
    [SLICE_PLANES] =
        {.name = "planes",
         0,
         OPTION_TEXT,
         "FILE",
         "with --frames: a line for each number from FIRST to LAST, with origin, u and "
         "v as X,Y,Z X,Y,Z X,Y,Z; # starts a comment",
         .group = OPTION_GEOMETRY,
         .names = OPTION_NAMES_FILE},
    [SLICE_SKIP_BAD] = {.name = "skip-bad",
                        0,
                        OPTION_FLAG,
                        NULL,
                        "go on after a frame that cannot be read, and end with 3",
                        .group = OPTION_FILES},
    [SLICE_SPACE] = {.name = "space",
                     0,
                     OPTION_CHOICE,
                     NULL,
                     "what the coordinates above mean (default world)",
                     weft_space_names,
                     .group = OPTION_GEOMETRY},
    ENGINE_OPTIONS(SLICE_ENGINE, ENGINE_AUTOMATIC, ENGINE_SUMS_HELP),
    [SLICE_LAYOUT] = {.name = "layout",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how voxels lie in the texture buffer: fastest with 4 times the memory, "
                      "a row of four at a time, one by one (default auto, by memory)",
                      weft_layout_names,
                      .group = OPTION_METHOD},
    [SLICE_SOURCE] = {.name = "source",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how voxels are stored there (default 32f); the others hold the range of the "
                      "voxels in reach, or --source-range",
                      weft_source_format_names,
                      .group = OPTION_METHOD},
    [SLICE_LOOKUP] = {.name = "lookup",
                      0,
                      OPTION_CHOICE,
                      NULL,
                      "how the kernel's weights are had: exactly (default), or from tiles of "
                      "--resolution M samples an axis",
                      weft_lookup_names,
                      .group = OPTION_FILTER},
    [SLICE_HARDWARE] = {.name = "hardware",
                        0,
                        OPTION_FLAG,
                        NULL,
                        "let the texture sampler filter, neighbouring taps at once: fast on GPUs, "
                        "and as inexact as their samplers (about 8 bits)",
                        .group = OPTION_METHOD},
    [SLICE_WITHOUT] = {.name = "without",
                       0,
                       OPTION_TEXT,
                       "NAME,...",
                       "do without what a scene need not pay for: constant, axis, separable, "
                       "smooth, or all; to compare",
                       .group = OPTION_METHOD},
    [SLICE_CLAMP] = {.name = "clamp",
                     0,
                     OPTION_FLAG,
                     NULL,
                     "clamp each pixel to the range of the voxels next to it: no ringing",
                     .group = OPTION_FILTER},
    [SLICE_MAX_ERROR] = {.name = "max-error",
                         0,
                         OPTION_TEXT,
                         "E|8bit|12bit|16bit",
                         "take the cheapest method whose error bound is at most E, or half a code "
                         "of the voxels' range; with --profile, the cheapest plan on that. "
                         "--explain lists what was considered",
                         .group = OPTION_METHOD,
                         .brief = "the fastest way that is as exact as this"},
    [SLICE_MEMORY] = {.name = "memory",
                      0,
                      OPTION_BYTES,
                      "BYTES",
                      "bound for voxels, layouts and GL memory, K, M or G for powers of 1024 "
                      "(default 1G); the work is cut into tiles that fit",
                      .group = OPTION_RESOURCES},
    PASS_OPTIONS(SLICE_PASSES, "slice in passes, as hardware of limited precision does"),
    [SLICE_RANGE] = {.name = "range",
                     0,
                     OPTION_RANGE,
                     "LO,HI",
                     "values shown as first and last colour of the preview (default: smallest "
                     "and largest; with --frames those of the whole grid)",
                     .group = OPTION_PICTURES},
    [SLICE_COLOUR_MAP] = {.name = "colour-map",
                          0,
                          OPTION_TEXT,
                          "NAME",
                          "colours of the preview (default grey); 'help' lists them",
                          .group = OPTION_PICTURES,
                          .names = OPTION_NAMES_MAP},
    [SLICE_ANNOTATE] = PREVIEW_ANNOTATE_OPTION,
    [SLICE_TITLE] = PREVIEW_TITLE_OPTION,
    [SLICE_ERROR_IMAGE] = ERROR_IMAGE_OPTION,
    [SLICE_EXPLAIN] = {.name = "explain",
                       0,
                       OPTION_FLAG,
                       NULL,
                       "print the plan and exit: no OpenGL, no output",
                       .group = OPTION_REPORTS},
    [SLICE_VERIFY] = {.name = "verify",
                      0,
                      OPTION_FLAG,
                      NULL,
                      "recompute in double precision (a random sample of the pixels when all "
                      "would take over 10 s) and print the largest and RMS difference; fails if "
                      "that is beyond the plan's bound; with -o, read the file back and compare "
                      "every value",
                      .group = OPTION_METHOD,
                      .brief = "measure the error against double precision"},
    [SLICE_JSON] = OPTIONS_JSON("geometry, plan, memory, times and errors"),
    [SLICE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    RANK_OPTIONS(SLICE_RANKS),
    [SLICE_QUIET] = OPTIONS_QUIET,
    [SLICE_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- checks that need no file contents ----------------------------------------------------------

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
    if (o[SLICE_HARDWARE].given &&
        (profile || chosen || o[SLICE_LAYOUT].given || o[SLICE_CLAMP].given))
        return "--hardware excludes --profile, --max-error, --layout and --clamp";
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

static const char *option_conflict(const struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    const char *conflict = sweep_conflict(setup);
    if (conflict)
        return conflict;
    bool plane = o[SLICE_ORIGIN].given || o[SLICE_U].given || o[SLICE_V].given;
    if (plane && (o[SLICE_AXIS].given || o[SLICE_AT].given))
        return "--axis and --at exclude --origin, --u and --v";
    if (plane && !(o[SLICE_ORIGIN].given && o[SLICE_U].given && o[SLICE_V].given))
        return "--origin, --u and --v must be given together";
    if (o[SLICE_QUIET].given && o[SLICE_VERBOSE].given)
        return "-q and -v exclude each other";
    if (!o[SLICE_OUTPUT].given && (o[SLICE_TYPE].given || o[SLICE_COMPRESSION].given))
        return "--type and --compression need -o OUT.exr";
    if (!o[SLICE_PREVIEW].given && (o[SLICE_RANGE].given || o[SLICE_COLOUR_MAP].given))
        return "--range and --colour-map need --preview OUT.png";
    const struct slice_job job = {.setup = (struct slice_setup *)setup};
    const struct preview_options preview = slice_preview_options(&job);
    conflict = preview_conflict(&preview, o[SLICE_PREVIEW].given);
    if (conflict)
        return conflict;
    if (o[SLICE_ERROR_IMAGE].given && (!o[SLICE_VERIFY].given || o[SLICE_FRAMES].given))
        return "--error-image is of one slice with --verify, and not of --frames";
    if (o[SLICE_PASSES + PASS_PROFILE].given && o[SLICE_LAYOUT].given)
        return "--layout is of slices without --profile";
    conflict = passes_conflict(o);
    if (conflict)
        return conflict;
    if (!o[SLICE_OUTPUT].given && !o[SLICE_PREVIEW].given && !o[SLICE_EXPLAIN].given &&
        !o[SLICE_VERIFY].given && !o[SLICE_JSON].given)
        return "nothing to do: give -o OUT.exr, --preview OUT.png, --verify, --json or --explain";
    return NULL;
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

static enum weft_result load_kernel(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    if (!o[SLICE_KERNEL].given)
        return WEFT_OK;
    enum weft_result res =
        kernels_load_filter(o[SLICE_KERNEL].text, 3, &setup->kernel, &setup->kernel_file);
    if (res == WEFT_OK && !setup->kernel.radial) // which slices refuse
        res = kernels_normalise(&o[SLICE_NORMALISE], 3, setup->kernel_file, &setup->kernel);
    return res;
}

// Who does what: frames, where each rank has two at least.
static enum weft_result read_ranks(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    struct slice_divided *divided = &setup->divided;
    const struct rank_request *request = &divided->request;
    const enum weft_result res = rank_options_read(&o[SLICE_RANKS], &divided->request);
    if (res != WEFT_OK)
        return res;
    const bool whole = request->region[0] < 0;
    const bool asked = request->region[1] || request->granularity || request->cost_map ||
                       request->schedule == WEFT_SCHEDULE_DYNAMIC;
    // A plan that is only told needs no other ranks.
    divided->is = (ranks_size() > 1 || request->given) && !o[SLICE_EXPLAIN].given;
    if (divided->is && o[SLICE_ERROR_IMAGE].given) {
        report_error("--error-image is not divided; run it without mpirun and rank options");
        return WEFT_ERR_ARGUMENT;
    }
    divided->frames = divided->is && setup->sweep.given &&
                      (whole || (!asked && setup->sweep.count >= 2 * ranks_size()));
    if (divided->frames && request->cost_map) {
        report_error("--cost-map is of the regions of a slice: here whole frames are divided");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result check_preview(struct slice_setup *setup)
{
    const struct slice_job job = {.setup = setup};
    const struct preview_options preview = slice_preview_options(&job);
    return preview_check(&preview, &setup->colour_map);
}

// Nothing is opened before all of this is right.
static enum weft_result check_setup(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    enum weft_result res = slice_read_framing(setup);
    const char *conflict = res == WEFT_OK ? option_conflict(setup) : NULL;
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK)
        res = pass_options_check(&o[SLICE_PASSES]);
    if (res == WEFT_OK)
        res = read_without(o[SLICE_WITHOUT].text, &setup->without);
    if (res == WEFT_OK)
        res = slice_read_quantities(setup);
    if (res == WEFT_OK)
        res = load_kernel(setup);
    if (res == WEFT_OK)
        res = slice_read_engine(setup);
    if (res == WEFT_OK)
        res = check_preview(setup);
    if (res == WEFT_OK)
        res = sweep_read(setup);
    if (res == WEFT_OK)
        res = read_ranks(setup);
    if (res == WEFT_OK)
        res = slice_check_channels(setup);
    if (res == WEFT_OK)
        res = slice_check_slab(setup);
    if (res == WEFT_OK)
        res = slice_check_curve(setup);
    if (res == WEFT_OK)
        res = sweep_check_files(setup);
    // While the first volume is opened, planned and read.
    return res == WEFT_OK && !o[SLICE_EXPLAIN].given && !slice_is_curved(setup)
               ? engine_begin_context(&setup->engine)
               : res;
}

// ---- the run ------------------------------------------------------------------------------------

static void clear_setup(struct slice_setup *setup)
{
    weft_volume_abandon(&setup->opening);
    slice_clear_sources(setup);
    sweep_clear(&setup->sweep);
    for (int i = 0; i < WEFT_DERIVATIVES; i++)
        weft_pass_plan_destroy(&setup->passes[i]);
    engine_abandon_context(&setup->engine);
    weft_context_destroy(&setup->context);
    weft_kernel_file_destroy(&setup->kernel_file);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[SLICE_QUIET].given, values[SLICE_VERBOSE].given);
    if (pass_options_help(&values[SLICE_KERNEL], &values[SLICE_PASSES]) ||
        preview_help(&values[SLICE_COLOUR_MAP]))
        return report_finish(WEFT_OK);
    if (!operand) {
        report_error("no volume given: weft slice VOLUME ... (see weft help slice)");
        return EXIT_CODE_USAGE;
    }
    struct slice_setup setup = {.input = operand,
                                .option = values,
                                .start = report_now_seconds(),
                                .range = values[SLICE_RANGE]};
    if (values[SLICE_EXPLAIN].given && !ranks_tells())
        return EXIT_CODE_DONE;
    enum weft_result res = raw_read(&values[SLICE_RAW], &setup.layout, &setup.raw);
    if (res == WEFT_OK)
        res = slice_begin(&setup);
    if (res == WEFT_OK)
        res = check_setup(&setup);
    if (!values[SLICE_EXPLAIN].given)
        res = ranks_agree(res);
    const int code = res == WEFT_OK ? sweep_run(&setup) : report_finish(res);
    clear_setup(&setup);
    weft_items_report_clear(&setup.divided.work);
    return code;
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
    "Under mpirun ranks share the work: whole frames where there are at least two for each rank, "
    "or with --region frame; else bands of rows of each slice, or what --region says. A schedule "
    "that is dynamic moves the boundaries of regions from frame to frame, and of a single slice "
    "by --cost-map.",
    NULL,
};

static const char *const examples[] = {
    "weft slice smoke.vdb -o smoke.exr --preview smoke.png --kernel mitchell --axis y --verify",
    NULL,
};

const struct verb verb_slice = {
    .name = "slice",
    .group = VERB_VOLUMES,
    .summary = "a planar cut through a volume, as EXR and PNG",
    .usage = "VOLUME [-o OUT.exr] [--preview OUT.png] [options]",
    .description = "Reconstructs a planar cut of any orientation through a scalar grid of a VDB, "
                   "NRRD, NIfTI or raw "
                   "file with a reconstruction kernel, reading only the bricks it touches.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = SLICE_OPTION_COUNT,
    .distributes = true,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
