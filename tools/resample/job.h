// SPDX-License-Identifier: BSD-3-Clause
// tools/resample/job.h - one `weft resample`: what was asked, what was made, what it cost.
#ifndef WEFT_TOOLS_RESAMPLE_JOB_H
#define WEFT_TOOLS_RESAMPLE_JOB_H

#include "tools/common/budget.h"
#include "tools/common/pass_options.h"

enum resample_option {
    RESAMPLE_OUTPUT,
    RESAMPLE_PREVIEW,
    RESAMPLE_SIZE,
    RESAMPLE_KERNEL,
    RESAMPLE_NORMALISE,
    RESAMPLE_PLAN, // the first of enum resample_plan_option
    RESAMPLE_CHANNELS = RESAMPLE_PLAN + RESAMPLE_PLAN_OPTION_COUNT,
    RESAMPLE_PART,
    RESAMPLE_TYPE,
    RESAMPLE_COMPRESSION,
    RESAMPLE_MAX_ERROR,
    RESAMPLE_TOGETHER,
    RESAMPLE_CONTEXT,
    RESAMPLE_EMULATE,
    RESAMPLE_RANGE,
    RESAMPLE_COLOUR_MAP,
    RESAMPLE_EXPLAIN,
    RESAMPLE_VERIFY,
    RESAMPLE_JSON,
    RESAMPLE_NO_CLOBBER,
    RESAMPLE_QUIET,
    RESAMPLE_VERBOSE,
    RESAMPLE_OPTION_COUNT
};

enum { RESAMPLE_MAX_TOGETHER = 4 };

// Channels that go through the passes together: one, or four.
struct resample_group {
    int count;
    size_t channel[RESAMPLE_MAX_TOGETHER]; // of the result
    const weft_pass_plan *plan;            // the job's; NULL: separable, or exact
    bool exact;                     // unsigned integers that are moved: one channel, no error
    double low, high;               // of the samples, or coefficients; passes map it
    double sample_low, sample_high; // of the samples themselves
    uint64_t clamped;               // samples outside it, or not finite
    double e1;        // weft_error_e1, with the samples' differences as derivatives; NAN: unknown
    double max_error; // with --max-error
    double minimum, maximum; // of the finite pixels; NAN if there are none
    uint64_t not_finite;     // values of pixels
    struct weft_bound bound;
    struct weft_multipass_error error; // with --verify
};

// One plan that --max-error was compared with.
struct resample_choice {
    enum weft_technique technique;
    int samples, bits;
    int channels;    // 1 or 4
    double seconds;  // predicted
    uint64_t bytes;  // of tiles
    double relative; // bound of the error, to the range's width
    double part;     // of --max-error that the bound takes
    bool good, chosen;
};

// Where pixels lie along an axis, in whole numbers: see resample_position.
struct resample_place {
    int64_t from, to; // pixels of the display windows of the input and of the result
    int64_t pixel;    // the result's first, from its display window's
    int64_t sample;   // of the input at its display window's first pixel, from its data's first
};

struct resample_job {
    const char *input;
    int part;                          // of the input
    const struct option_value *option; // [RESAMPLE_OPTION_COUNT]
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file; // NULL for kernels of the catalogue
    enum weft_context_kind context_kind;
    const struct weft_colour_map *colour_map;

    struct budget budget; // with --max-error

    struct weft_image image;             // the input; without planes when only explained
    struct weft_image result;            // the channels asked for, in the input's order
    struct weft_metadata *texts;         // the result's own attributes
    unsigned char corrected[2][4];       // attributes_scaled's numbers
    struct weft_image_save_report saved; // the first part's job has it of all
    struct resample_place place[2];
    size_t *source; // of each, its channel of the input
    // Prefiltered kernels: what is sampled in place of the input, by the result's channels, with
    // `pad` more values on every side. NULL and 0 for others.
    float **coefficients;
    int pad;
    struct resample_group *group;
    size_t group_count;
    bool separable;                    // one axis after the other, and no plans
    weft_pass_plan *single, *together; // of one channel and of four; NULL where none needs it
    struct resample_choice *choices;   // what a plan was chosen from; NULL where it was not
    size_t choice_count;
    bool over_budget;      // nothing is within --max-error, which an error line has told
    weft_context *context; // NULL when only explained or emulated

    struct weft_multipass_report report;           // times summed up, sizes of the largest tile
    struct weft_separable_report separable_report; // its sizes, likewise
    int tiles;                                     // over all groups; of separable ones: rectangles
    float preview_range[2];                        // with --preview
    double start;                                  // monotonic seconds
    double load_seconds, plan_seconds, context_seconds, verify_seconds, write_seconds;
};

// The display windows' sizes. Returns WEFT_ERR_ARGUMENT (too many pixels) after an error line.
enum weft_result resample_choose_size(struct resample_job *job);
// The result's windows and size. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_LIMIT after an error line.
enum weft_result resample_set_windows(struct resample_job *job);
// What a pixel of the result samples along an axis, counted from the input's first sample, plus
// `shift`: (x + 0.5) from / to - 0.5 between the display windows. Whole where that is whole.
double resample_position(const struct resample_place *place, int pixel, int shift);

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

// Fills the coefficients where the kernel asks for them; those that depend on samples that are not
// finite are missing, as filter/kernels/prefilter.h says. Returns WEFT_ERR_MEMORY, or
// WEFT_ERR_LIMIT where they leave the range of floats, after an error line.
enum weft_result resample_prefilter(struct resample_job *job);
void resample_prefilter_clear(struct resample_job *job); // before the result's channels are

// The groups' ranges, E1 and what --max-error allows them.
enum weft_result resample_measure(struct resample_job *job);
// The samples of a channel of the result: the input's, or coefficients.
const float *resample_source_plane(const struct resample_job *job, size_t channel);

// The cheapest plans within --max-error, by the options that are given, techniques, resolutions and
// bits otherwise. Returns WEFT_ERR_ARGUMENT after an error line, with over_budget set, where there
// are none.
enum weft_result resample_choose_plans(struct resample_job *job);

// Tiles, passes, error: fills the result's planes and the groups.
enum weft_result resample_run(struct resample_job *job);
// The same along one axis and then the other.
enum weft_result resample_separable_run(struct resample_job *job);

// Sets the result's types, and which groups are exact. Warns of integers that become floats.
void resample_set_types(struct resample_job *job);
// Of a group's results, the largest of which is `result`; 0: any.
struct weft_bound resample_bound(const struct resample_job *job, const struct resample_group *group,
                                 double result);
// The same, had the group this plan.
struct weft_bound resample_bound_of(const struct weft_pass_plan_info *plan,
                                    const struct resample_group *group, double result);
bool resample_needs_gl(const struct resample_job *job);
// The result's planes. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result resample_allocate(struct resample_job *job);
// The smallest and largest integer of an exact group.
void resample_exact_range(const struct resample_job *job, struct resample_group *group);
// Moves the exact groups, and verifies them where that is asked for.
enum weft_result resample_exact_run(struct resample_job *job);
// Fills the integers of --type uint from planes that were filtered.
void resample_round_integers(struct resample_job *job);
// Verifies groups of prefiltered kernels against the image's samples, by the cardinal spline: finds
// what coefficients got wrong, too. Returns WEFT_ERR_MEMORY after an error line,
// WEFT_ERR_CANCELLED.
enum weft_result resample_verify_samples(struct resample_job *job);
// A group's minimum, maximum, not_finite and bound, of its pixels.
void resample_measure_result(const struct resample_job *job, struct resample_group *group);

// Writes the results as one file, and warns of what it does not keep.
enum weft_result resample_save(struct resample_job *jobs, size_t count);

enum { RESAMPLE_ATTRIBUTES = 12 };

// What the EXR file says about itself; returns how many.
size_t resample_attributes(const struct resample_job *job,
                           struct weft_metadata out[RESAMPLE_ATTRIBUTES]);

// "R G B".
void resample_group_name(const struct resample_job *job, const struct resample_group *group,
                         char *text, size_t size);

// Everything, of one part or several, on stdout.
enum weft_result resample_print_json(const struct resample_job *jobs, size_t count);
// The plans that --max-error was compared with, as a table.
void resample_print_choices(const struct resample_job *job);
// What was asked for in words: plans (with --explain), preview range, verification.
void resample_print_text(const struct resample_job *job);

#endif
