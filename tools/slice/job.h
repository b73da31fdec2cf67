// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/job.h - one `weft slice`: what was asked, what was made, what it cost.
#ifndef WEFT_TOOLS_SLICE_JOB_H
#define WEFT_TOOLS_SLICE_JOB_H

#include "tools/common/json.h"
#include "tools/methods/budget.h"
#include "tools/options/options.h"
#include "tools/common/report.h"
#include "tools/methods/engine_options.h"
#include "tools/methods/pass_options.h"
#include "tools/curve/curve.h"
#include "tools/draw/error_image.h"
#include "tools/framing/framing.h"
#include "tools/ranks/options.h"
#include "tools/volumes/raw.h"
#include "weft.h"

enum slice_option {
    SLICE_OUTPUT,
    SLICE_TYPE,
    SLICE_COMPRESSION,
    SLICE_PREVIEW,
    SLICE_GRID,
    SLICE_RAW,
    SLICE_QUANTITY,
    SLICE_KERNEL,
    SLICE_NORMALISE,
    SLICE_SIZE,
    SLICE_AXIS,
    SLICE_AT,
    SLICE_ORIGIN,
    SLICE_U,
    SLICE_V,
    SLICE_UP,
    SLICE_FLIP,
    SLICE_BOX,
    SLICE_SLAB,
    SLICE_COMBINE,
    SLICE_POSITIONS,
    SLICE_ALONG,
    SLICE_WIDTH,
    SLICE_FRAMES,
    SLICE_STEP,
    SLICE_PLANES,
    SLICE_SKIP_BAD,
    SLICE_SPACE,
    SLICE_ENGINE, // the first of enum engine_option
    SLICE_LAYOUT = SLICE_ENGINE + ENGINE_OPTION_COUNT,
    SLICE_SOURCE,
    SLICE_LOOKUP,
    SLICE_HARDWARE,
    SLICE_WITHOUT,
    SLICE_CLAMP,
    SLICE_MAX_ERROR,
    SLICE_MEMORY,
    SLICE_PASSES, // the first of enum pass_option
    SLICE_RANGE = SLICE_PASSES + PASS_OPTION_COUNT,
    SLICE_COLOUR_MAP,
    SLICE_ANNOTATE,
    SLICE_TITLE,
    SLICE_ERROR_IMAGE,
    SLICE_EXPLAIN,
    SLICE_VERIFY,
    SLICE_JSON,
    SLICE_NO_CLOBBER,
    SLICE_RANKS, // the first of enum rank_option
    SLICE_QUIET = SLICE_RANKS + RANK_OPTION_COUNT,
    SLICE_VERBOSE,
    SLICE_OPTION_COUNT
};

// Where a plane lies, in the space of --space.
struct slice_plane {
    double origin[3], u[3], v[3];
};

// A scalar volume of the file that is shown: a grid, or a component of one of vectors; and what its
// channels are called: `name` its value, and `prefix` with a quantity's own name others.
struct slice_source {
    char grid[256]; // that is asked for; "": the file's first one that can be sliced
    int component;  // of a grid of vectors, else 0
    bool vector;    // the grid is one; its components follow each other
    char name[288], prefix[290];
    weft_volume *volume; // NULL: not open
    weft_volume *rest;   // what floats lack of it; NULL: not asked for yet
};

// Which slices are made. Frame f of --frames FIRST-LAST:STEP is one of FIRST, FIRST + STEP, ... up
// to LAST. Where its plane lies depends on f, FIRST and LAST and not on STEP.
struct slice_sweep {
    bool given; // --frames; else there is one slice, which has no number
    int64_t first, last, step;
    int count;                  // of frames
    struct slice_plane *planes; // of frames FIRST to LAST, with --planes; NULL
};

// What planes of --axis show: a box, and where --at says, on the axis.
struct slice_frame {
    double low[3], high[3];
    double at[2]; // of FIRST and of LAST; NAN: the middle of the box
};

// How ranks divide the work: whole frames where there are at least two for each rank and no region
// is asked for, or where frames are asked for; else the regions of each slice.
struct slice_divided {
    bool is;     // several ranks, or a rank option
    bool frames; // are the items
    struct rank_request request;
    struct weft_items_report work; // so far
    // With --max-error, of regions: what rank 0 chose.
    struct weft_method method;
    double smooth_error;
    struct weft_slice_statistics statistics;
};

// What a command asks for, and what is made once for it.
struct slice_setup {
    const char *input; // as given, like all options
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw; // of all volumes; NULL: they are what they are by content
    const struct option_value *option; // [SLICE_OPTION_COUNT]
    double start;                      // monotonic seconds
    struct slice_sweep sweep;
    struct framing framing;
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file;     // NULL for kernels of the catalogue
    struct weft_quantities quantities; // of every source; default: the value
    unsigned without;                  // enum weft_saving, as bits
    struct engine engine;
    struct slice_divided divided;
    const struct weft_colour_map *colour_map; // NULL: none is named
    // Of the first slice that comes so far, kept for all.
    weft_volume_opening *opening; // of the input, begun before all else; NULL: taken, or not begun
    char *volume_path;            // which is open
    struct slice_source *source;  // what is shown of it; of the first volume for all
    int source_count;             // 0: not known yet
    weft_resident
        *resident; // what stays of the only source (resident.c); NULL: nothing, or not yet
    struct weft_slice_geometry plane; // that --axis or --origin say; no pixels: not known yet
    struct slice_frame frame;         // of --axis, likewise
    bool volume_grew;                 // beyond the plane, which was told
    char aspect[FRAMING_TEXT];        // what is told in the end of pixels that are not square
    struct option_value range;        // of previews: --range, or with --frames the whole grid's
    weft_context *context;            // NULL when only explained, and on the CPU engine
    weft_pass_plan *passes[WEFT_DERIVATIVES]; // of --profile without --max-error: of the value, or
                                              // of each derivative that quantities are made of
};

enum { SLICE_ATTRIBUTES = 24, SLICE_STAGES = 10 };

// A channel of what is saved: its name, and of its finite pixels the range, NAN where there are
// none.
struct slice_channel {
    char name[320];
    double minimum, maximum;
    uint64_t not_finite;
    double bound; // with --verify, of quantities: the largest of its pixels that have one, else NAN
    uint64_t unbounded; // pixels that have none, as of normals where the gradient may be 0
};

// One slice, made from the setup.
struct slice_job {
    struct slice_setup *setup;
    int index;                             // among the command's slices
    int64_t frame;                         // its number; 0 without --frames
    const char *input, *output, *preview;  // files' names; outputs may be NULL: none
    char *numbered[3];                     // those that belong to the job
    struct weft_slice_geometry geometry;   // as asked, with the size chosen
    struct slice_source *source;           // the setup's whose turn it is
    weft_volume *volume;                   // its own
    struct curve curve;                    // positions of pixels that lie on no plane; {0}: none
    struct weft_slab_info slab;            // with --slab; else {0}
    uint64_t bad_positions, outside;       // of a curve: struct weft_points_report
    struct weft_slice_params slice_params; // as planned
    weft_slice_plan *own_plan;
    const weft_slice_plan *plan;      // the job's own, or the chosen method's
    const weft_pass_plan *passes;     // the setup's first, or the chosen method's; NULL: none
    weft_hardware_plan *own_hardware; // with --hardware
    const struct weft_hardware_plan_info *hardware; // its, or the chosen method's; NULL: none
    // With --max-error.
    double max_error; // in the volume's values
    struct weft_choice choice;
    bool over_budget; // no method is within it
    // Of each source in turn, its channels, a plane each. NULL when only explained, and where ranks
    // packed what is saved.
    float *pixels;
    struct slice_channel *channel; // of these planes, in order
    int channel_count;
    int derived_count; // derivatives that channels are computed of; 0: they are the values
    float *derived;    // these of a source, a plane each; NULL: channels are what is computed
    bool made;         // they are, here or on other ranks
    // Lines as they are saved, packed by ranks, in order: NULL: they are packed when they are.
    struct weft_bytes *bands; // each to be freed
    int band_count, bands_given;
    struct slice_stream *stream; // by which they are written while others are made (stream.c)
    struct weft_image_save_report packing; // of these

    struct weft_slice_report report; // of the run that is on, and then of all
    struct weft_slice_report total;  // of runs so far
    int run, runs; // of a source, where passes make one derivative each; and so far
    bool by_passes;
    struct weft_bound bound; // with --profile
    // With --verify, of what is computed: the only source's value, or of all derivatives of all
    // sources the one that comes nearest to its bound.
    int verified;                                             // runs' outputs so far
    struct weft_verify_report output_error[WEFT_DERIVATIVES]; // of a source, and their bounds
    double output_bound[WEFT_DERIVATIVES];
    struct weft_verify_report error;
    double error_bound;     // its own: NAN where voxels outside --source-range count
    json_t *outputs;        // with --json, unless it is plain: what is computed of each source
    float preview_range[2]; // with a preview
    bool annotated;         // it has what is around it
    struct annotation annotation;
    struct error_image errors;           // with --error-image
    float errors_range[2];               // that it shows
    struct weft_image_save_report saved; // with an output
    double start;                        // monotonic seconds
    double open_seconds, plan_seconds, context_seconds, verify_seconds, write_seconds;
    double seconds; // all of it, once it is saved
    // What the slice tells; plans and volume are not needed any more.
    struct weft_metadata attributes[SLICE_ATTRIBUTES];
    size_t attribute_count;
    json_t *json;                 // with --json
    enum weft_result save_result; // of a thread that saved it
    struct report_held held;      // what that told
    char problem[1024];           // the error line of a frame that is skipped
};

// Whether nothing but the value of one grid is shown.
bool slice_is_plain(const struct slice_setup *setup);
// Whether the pixels themselves are wanted where a slice is saved, when its lines are packed.
bool slice_needs_pixels(const struct slice_job *job);
// Whether it writes a file whose lines can be packed.
bool slice_writes_lines(const struct slice_job *job);

// What --memory says, or its default.
uint64_t slice_memory(const struct slice_setup *setup);

// Gives up the plans, which hold voxels and must be gone before their volume is: once the job has
// told what it is (report.h), saving needs none.
void slice_release(struct slice_job *job);
// Gives up everything.
void slice_clear(struct slice_job *job);

#endif
