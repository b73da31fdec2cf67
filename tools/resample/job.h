// SPDX-License-Identifier: BSD-3-Clause
// tools/resample/job.h - one `weft resample`: what was asked, what was made, what it cost.
#ifndef WEFT_TOOLS_RESAMPLE_JOB_H
#define WEFT_TOOLS_RESAMPLE_JOB_H

#include "tools/draw/error_image.h"
#include "tools/framing/framing.h"
#include "tools/methods/budget.h"
#include "tools/methods/engine_options.h"
#include "tools/methods/pass_options.h"
#include "tools/ranks/division.h"
#include "tools/resample/warp.h"

enum resample_option {
    RESAMPLE_OUTPUT,
    RESAMPLE_PREVIEW,
    RESAMPLE_SIZE,
    RESAMPLE_MATRIX,
    RESAMPLE_ROTATE,
    RESAMPLE_PERSPECTIVE,
    RESAMPLE_POSITIONS,
    RESAMPLE_KERNEL,
    RESAMPLE_BOUNDARY,
    RESAMPLE_ANTIALIAS,
    RESAMPLE_CLAMP,
    RESAMPLE_NORMALISE,
    RESAMPLE_PASSES, // the first of enum pass_option
    RESAMPLE_CHANNELS = RESAMPLE_PASSES + PASS_OPTION_COUNT,
    RESAMPLE_PART,
    RESAMPLE_TYPE,
    RESAMPLE_COMPRESSION,
    RESAMPLE_TRANSFER,
    RESAMPLE_MIP,
    RESAMPLE_MAX_ERROR,
    RESAMPLE_TOGETHER,
    RESAMPLE_ENGINE, // the first of enum engine_option
    RESAMPLE_EMULATE = RESAMPLE_ENGINE + ENGINE_OPTION_COUNT,
    RESAMPLE_RANGE,
    RESAMPLE_COLOUR_MAP,
    RESAMPLE_EXPOSURE,
    RESAMPLE_ANNOTATE,
    RESAMPLE_TITLE,
    RESAMPLE_ERROR_IMAGE,
    RESAMPLE_EXPLAIN,
    RESAMPLE_VERIFY,
    RESAMPLE_JSON,
    RESAMPLE_NO_CLOBBER,
    RESAMPLE_RANKS, // the first of enum rank_option
    RESAMPLE_QUIET = RESAMPLE_RANKS + RANK_OPTION_COUNT,
    RESAMPLE_VERBOSE,
    RESAMPLE_OPTION_COUNT
};

enum { RESAMPLE_MAX_TOGETHER = WEFT_RESAMPLE_MAX_CHANNELS };

// Channels that go through the passes together: one, or four.
struct resample_group {
    int count;
    size_t channel[RESAMPLE_MAX_TOGETHER]; // of the result
    weft_resample_source *source;          // NULL when only explained, without a budget
    struct weft_resample_statistics statistics;
    double e1;                      // weft_resample_e1; NAN where nothing tells it
    const weft_resample_plan *plan; // the job's; of a warp NULL
    const weft_warp_plan *warp;     // the job's, of a warp
    bool exact;                     // unsigned integers that are moved: one channel, no error
    double max_error;               // with --max-error
    uint64_t rounded[RESAMPLE_MAX_TOGETHER]; // integers of each channel that are no floats
    double minimum, maximum;                 // of the finite pixels; NAN if there are none
    uint64_t not_finite;                     // values of pixels
    struct weft_bound bound;
    struct weft_verify_report error; // with --verify
};

// What ranks know of an image that they share: each has planes of all of it, of whose memory only
// the rows that it read are used.
struct resample_divided {
    bool is; // work is divided, among ranks or, with an option of theirs, into parts for one
    struct rank_request request;
    struct rank_division division; // of the result
    struct weft_items_report work; // items in the order of regions
    int64_t *order;                // of each item: its region, so that a rank's in turn adjoin
    // Ranks pack the lines that they make, where these are parts of the file's only part, and send
    // pixels where rank 0 wants them itself.
    bool only, packs, sends;
    // Rank 0's: what came packed, in order, and what became of the values.
    struct weft_bytes *bands;
    int64_t band_count, bands_given;
    struct weft_image_save_report packing;
    uint64_t *lost;                 // [channels of the result]: values that are no integers
    unsigned char *has_row;         // [height] of the input
    struct resample_shared *shared; // [group_count]
};

// --size: pixels of the display window, or how many times the input's.
struct resample_size {
    int64_t pixels[2]; // 0: by the other side and the display window's aspect; both: by the factor
    int64_t longer;    // side, by which the other follows; 0: not given
    double factor;
};

struct resample_job {
    const char *input;
    int part;                          // of the input
    const struct option_value *option; // [RESAMPLE_OPTION_COUNT]
    struct resample_size size;         // of the display window
    char aspect[FRAMING_TEXT];         // what is told in the end of pixels that are not square
    enum weft_boundary boundary;
    double border; // of the boundary of that name
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file; // NULL for kernels of the catalogue
    struct engine engine;          // of separable work; passes run on OpenGL, or are emulated
    bool engine_is_read;
    const struct weft_colour_map *colour_map;
    enum weft_image_file_kind kind; // of the output

    struct resample_warp warp;
    struct budget budget; // with --max-error
    struct resample_divided divided;

    struct weft_image image;  // the input; without planes when only explained
    struct weft_image result; // the channels asked for, in the input's order
    struct weft_image *mips;  // the result's, which borrows them
    int mip_count;
    struct weft_metadata *texts;         // the result's own attributes
    unsigned char corrected[2][4];       // attributes_scaled's numbers
    struct weft_image_save_report saved; // the first part's job has it of all
    struct weft_window_map map[2];
    size_t *source; // of each channel, that of the input
    struct resample_group *group;
    size_t group_count;
    bool separable;                      // one axis after the other, and no passes
    weft_pass_plan *single, *together;   // of one channel and of four; NULL where none needs it
    weft_resample_plan *plan[2];         // likewise; separable: the first
    weft_resample_compiled *compiled[2]; // likewise, of those that run
    // What they were chosen from; {0} where they were not. Separable: the first, engine and sums.
    struct weft_resample_choice choices[2];
    bool over_budget;      // nothing is within --max-error, which an error line has told
    weft_context *context; // NULL when only explained or emulated, and on the CPU engine

    struct weft_resample_work work; // over all groups
    float preview_range[2];         // with --preview
    struct error_image errors;      // with --error-image
    float errors_range[2];          // that it shows
    double start;                   // monotonic seconds
    double load_seconds, plan_seconds, context_seconds, verify_seconds, write_seconds;
};

// Reads --size and --boundary, or their defaults. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_read_size(struct resample_job *job);
enum weft_result resample_read_boundary(struct resample_job *job);

// Whether kernels stay as they are where the image becomes smaller: --antialias off.
static inline bool resample_is_unstretched(const struct resample_job *job)
{
    return job->option[RESAMPLE_ANTIALIAS].given && job->option[RESAMPLE_ANTIALIAS].integer[0] == 1;
}

// The display windows' sizes. Returns WEFT_ERR_ARGUMENT (too many pixels) after an error line.
enum weft_result resample_choose_size(struct resample_job *job);
// The result's windows and size. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_LIMIT after an error line.
enum weft_result resample_set_windows(struct resample_job *job);

// Whether a list of --channels has a name.
bool resample_names_channel(const char *list, const char *name);
// Every name of --channels is in some part, and not twice in the list. Returns WEFT_ERR_ARGUMENT
// after an error line.
enum weft_result resample_check_names(const char *input, const struct weft_image *images,
                                      size_t count, const char *list);
// The result's channels, without planes. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result resample_choose_channels(struct resample_job *job);
// Which of them go together. Returns WEFT_ERR_ARGUMENT (--together, and no four that could).
enum weft_result resample_make_groups(struct resample_job *job);
// "R G B".
void resample_group_name(const struct resample_job *job, const struct resample_group *group,
                         char *text, size_t size);

// What the output is to be, by its name, and whether the options say nothing else. Returns
// WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_choose_kind(struct resample_job *job);
// Whether one file of the output's kind holds so many parts of an input. Returns WEFT_ERR_ARGUMENT
// after an error line.
enum weft_result resample_check_parts(const struct resample_job *job, size_t count);
// What integer codes stand for, as --transfer has it.
struct weft_transfer resample_transfer(const struct resample_job *job);

// Sets the result's types, and which groups are exact.
void resample_set_types(struct resample_job *job);
// How many integers of a channel of the input, in rows from `first` to before `end`, are no floats.
uint64_t resample_count_rounded(const struct resample_job *job, size_t channel, int first, int end);
// Warns of integers that become floats, once they are counted.
void resample_warn_of_rounding(const struct resample_job *job);
// The result's planes. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result resample_allocate(struct resample_job *job);
// Fills the integers of --type uint from planes that were filtered, where there are planes, and
// warns of what is lost.
void resample_round_integers(struct resample_job *job);
// To nearest, halves up to even; returns how many are none: NaN, negative or too large ones.
uint64_t resample_round_plane(const float *plane, size_t count, uint32_t *out);
// The result's compression, as it is asked for or as the input's is.
void resample_choose_compression(struct resample_job *job);

// The groups' sources and statistics, and what --max-error allows them. Returns as
// weft_resample_source_create.
enum weft_result resample_measure(struct resample_job *job);
// A group's samples, of `rows` rows of the input from `first` on.
struct weft_resample_source_params resample_source_params(const struct resample_job *job,
                                                          const struct resample_group *group,
                                                          int first, int rows);
// Likewise the integers of one that is exact.
struct weft_resample_integers resample_integers(const struct resample_job *job,
                                                const struct resample_group *group, int first,
                                                int rows);
// Whether E1 is told.
bool resample_tells_e1(const struct resample_job *job);
// What is known once samples are measured: warns, and sets the group's error.
void resample_set_budget(struct resample_job *job, struct resample_group *group);
// Of a planned group's results, the largest of which is `result`; 0: any.
struct weft_bound resample_group_bound(const struct resample_group *group, double result);

// The groups' plans. Those of passes are the cheapest within --max-error where that is given: by
// the options that are given, techniques, resolutions and bits otherwise. Returns WEFT_ERR_ARGUMENT
// after an error line, with over_budget set, where nothing is.
enum weft_result resample_plan(struct resample_job *job);
// What a plan has whatever runs it.
struct weft_resample_params resample_plan_params(const struct resample_job *job);
// Of separable work the one plan: on the engine and in the sums that are asked for, or the fastest
// within --max-error. Returns likewise.
enum weft_result resample_plan_separable(struct resample_job *job);
// What asks for passes, which run on OpenGL, in words; NULL: nothing does.
const char *resample_passes_option(const struct resample_job *job);
// The options of what filters. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_read_engine(struct resample_job *job);
// The context where OpenGL is needed. Where none can be had, separable work is planned for the CPU
// engine if that was left open.
enum weft_result resample_create_context(struct resample_job *job);

// With --error-image: room for it, of as many channels as the result has; and how a group is
// verified, which fills its channels in. *part stays until that is done. (measure.c)
enum weft_result resample_create_errors(struct resample_job *job);
struct weft_verify_params resample_verify_how(struct resample_job *job,
                                              const struct resample_group *group,
                                              const struct weft_progress *progress,
                                              struct error_image_part *part);

// Fills the result's planes and the groups, and verifies them where that is asked for.
enum weft_result resample_compute(struct resample_job *job);
// The group's plan, compiled by the first group that has it.
enum weft_result resample_compile_group(struct resample_job *job,
                                        const struct resample_group *group,
                                        weft_resample_compiled **out);

// ---- on ranks -----------------------------------------------------------------------------------

// Each is collective where the work is divided, and ends with the same result on all ranks.
// Reads the options of ranks. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_read_ranks(struct resample_job *job);
// resample_measure of parts: each rank reads and measures its share of the rows, and all get what
// all samples show.
enum weft_result resample_measure_parts(struct resample_job *job);
// What rank 0 knows of costs, so that all choose alike; then resample_plan.
enum weft_result resample_plan_alike(struct resample_job *job);
// resample_compute of parts, put together on rank 0.
enum weft_result resample_compute_parts(struct resample_job *job);
// Reads those rows of the input from `first` to before `end` that are not there. Not collective.
enum weft_result resample_load_rows(struct resample_job *job, int first, int end);
// Surveys what this rank has read, and joins it: of group g in *resample_survey_of(job, g).
enum weft_result resample_survey_parts(struct resample_job *job);
const struct weft_resample_survey *resample_survey_of(const struct resample_job *job, size_t g);
const struct weft_resample_measured *resample_measured_of(const struct resample_job *job, size_t g);
void resample_clear_divided(struct resample_divided *divided);

// The result's mip levels, where it has some. Returns as weft_resample_run, after an error line.
enum weft_result resample_make_mips(struct resample_job *job);
void resample_clear_mips(struct resample_job *job);

// Writes the results as one file, and warns of what it does not keep.
enum weft_result resample_save(struct resample_job *jobs, size_t count);

enum { RESAMPLE_ATTRIBUTES = 15 + ENGINE_ATTRIBUTES };

// What the EXR file says about itself; returns how many.
size_t resample_attributes(const struct resample_job *job,
                           struct weft_metadata out[RESAMPLE_ATTRIBUTES]);

// Everything, of one part or several, on stdout.
enum weft_result resample_print_json(const struct resample_job *jobs, size_t count);
// The plans that --max-error was compared with, as a table.
void resample_print_choices(const struct resample_job *job);
// What was asked for in words: plans (with --explain), preview range, verification.
void resample_print_text(const struct resample_job *job);

#endif
