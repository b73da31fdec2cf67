// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/job.h - one `weft slice`: what was asked, what was made, what it cost.
#ifndef WEFT_TOOLS_SLICE_JOB_H
#define WEFT_TOOLS_SLICE_JOB_H

#include "tools/methods/budget.h"
#include "tools/common/options.h"
#include "tools/methods/pass_options.h"
#include "weft.h"

enum slice_option {
    SLICE_OUTPUT,
    SLICE_PREVIEW,
    SLICE_GRID,
    SLICE_KERNEL,
    SLICE_NORMALISE,
    SLICE_SIZE,
    SLICE_AXIS,
    SLICE_AT,
    SLICE_ORIGIN,
    SLICE_U,
    SLICE_V,
    SLICE_SPACE,
    SLICE_CONTEXT,
    SLICE_LAYOUT,
    SLICE_SOURCE,
    SLICE_LOOKUP,
    SLICE_WITHOUT,
    SLICE_CLAMP,
    SLICE_MAX_ERROR,
    SLICE_MEMORY,
    SLICE_PASSES, // the first of enum pass_option
    SLICE_RANGE = SLICE_PASSES + PASS_OPTION_COUNT,
    SLICE_COLOUR_MAP,
    SLICE_EXPLAIN,
    SLICE_VERIFY,
    SLICE_JSON,
    SLICE_NO_CLOBBER,
    SLICE_QUIET,
    SLICE_VERBOSE,
    SLICE_OPTION_COUNT
};

// What a command asks for, and what is made once for it.
struct slice_setup {
    const char *input;                 // as given, like all options
    const struct option_value *option; // [SLICE_OPTION_COUNT]
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file; // NULL for kernels of the catalogue
    unsigned without;              // enum weft_saving, as bits
    enum weft_context_kind context_kind;
    const struct weft_colour_map *colour_map; // NULL: none is named
    weft_context *context;                    // NULL when only explained
};

// One slice, made from the setup.
struct slice_job {
    struct slice_setup *setup;
    const char *input, *output, *preview; // files' names; outputs may be NULL: none
    struct weft_slice_geometry geometry;  // as asked, with the size chosen
    weft_volume *volume;
    struct weft_slice_params slice_params; // as planned
    weft_slice_plan *own_plan;
    weft_pass_plan *own_passes;
    const weft_slice_plan *plan;  // the job's own, or the chosen method's
    const weft_pass_plan *passes; // likewise; NULL: none
    // With --max-error.
    double max_error; // in the volume's values
    struct weft_cost_model model;
    struct weft_choice choice;
    bool over_budget; // no method is within it
    float *pixels;    // NULL when only explained

    struct weft_slice_report report;
    struct weft_bound bound;             // with --profile
    struct weft_verify_report error;     // with --verify
    float preview_range[2];              // with a preview
    struct weft_image_save_report saved; // with an output
    double start;                        // monotonic seconds
    double open_seconds, plan_seconds, context_seconds, verify_seconds, write_seconds;
};

enum { SLICE_ATTRIBUTES = 24 };

// What the EXR file says about itself; returns how many.
size_t slice_attributes(const struct slice_job *job, struct weft_metadata out[SLICE_ATTRIBUTES]);

// What |pixel - reference| may be by the plan; NAN where voxels outside --source-range were
// clamped.
double slice_verify_bound(const struct slice_job *job);

// Everything, on stdout.
enum weft_result slice_print_json(const struct slice_job *job);
// What was asked for in words: plan (with --explain), preview range, verification.
void slice_print_text(const struct slice_job *job);

#endif
