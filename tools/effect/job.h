// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/job.h - one `weft effect`: what was asked, what was planned, what came of it.
#ifndef WEFT_TOOLS_EFFECT_JOB_H
#define WEFT_TOOLS_EFFECT_JOB_H

#include "tools/common/json.h"
#include "tools/options/kernels.h"
#include "tools/options/options.h"
#include "tools/draw/picture.h"
#include "tools/draw/preview.h"
#include "tools/effect/run.h"
#include "tools/methods/accumulate_report.h"
#include "tools/ranks/frames.h"
#include "tools/render/scene_options.h"

enum effect_option {
    ASK_OUTPUT,
    ASK_STDERR,
    ASK_PREVIEW,
    ASK_SCENES, // the first of enum scene_option
    ASK_SCENE = ASK_SCENES + SCENE_OPTION_SCENE,
    ASK_FRAMES = ASK_SCENES + SCENE_OPTION_COUNT,
    ASK_WEIGHTS,
    ASK_AT,
    ASK_SHUTTER,
    ASK_JITTER,
    ASK_CENTRE,
    ASK_FILTER,
    ASK_FILTER_WIDTH,
    ASK_APERTURE,
    ASK_FOCUS,
    ASK_LIGHT_SIZE,
    ASK_PATHS,
    ASK_CLAMP,
    ASK_ADDING, // the first of enum accumulation_option
    ASK_UNTIL = ASK_ADDING + ACCUMULATION_UNTIL,
    ASK_TYPE = ASK_ADDING + ACCUMULATION_OPTION_COUNT,
    ASK_COMPRESSION,
    ASK_RANGE,
    ASK_EXPOSURE,
    ASK_ANNOTATE,
    ASK_TITLE,
    ASK_RANKS, // the first of enum rank_option
    ASK_EXPLAIN = ASK_RANKS + RANK_OPTION_COUNT,
    ASK_JSON,
    ASK_NO_CLOBBER,
    ASK_QUIET,
    ASK_VERBOSE,
    ASK_OPTION_COUNT
};

enum { EFFECT_TEXT = 256 };

// A scene that was asked for.
struct effect_scene {
    char *name;         // as it was written, owned
    struct scene scene; // with keyframes, camera and lamp as asked for
    scene_drawing *drawing;
};

// What clamping took away of a radiosity's light, by some of its frames in a smaller picture.
struct effect_lost {
    int64_t frames; // that were drawn for it; 0: it was not looked for
    int size[2];    // of their pictures
    double share;   // of all light that there would be, red, green and blue alike
};

// What each stage took, in seconds.
struct effect_seconds {
    double scene, plan, context, prepare, draw, judge, lost, result, write;
};

// Frames of several ranks. (job_divided.c)
struct effect_divided {
    bool is; // there are several, or a rank option says how it would be
    struct rank_request request;
    struct rank_frames_report report;
    int64_t shadow_of; // the last frame that job->shadow is of; -1: none
};

struct effect_job {
    const struct option_value *option; // [ASK_OPTION_COUNT]
    const char *const *operands;       // NULL-ended

    struct scene_request request;
    struct effect_params params; // of the plan
    struct accumulation how;
    struct weft_kernel filter;
    weft_kernel_file *filter_file; // NULL: it is of no file

    struct effect_scene *scene; // [scene_count]
    int scene_count;

    struct effect_plan plan;
    double depth[2];  // nearest and farthest in sight in the middle of the time; NAN: nothing is
    double circle[2]; // of dof: of confusion, in pixels, there
    double brightest; // light that the scenes hold: lamps and surfaces that are seen
    struct effect_divided divided;
    weft_context *context; // NULL: nothing was drawn
    weft_accumulator *accumulator;
    struct weft_accumulator_report planned, report; // before the first frame; of all that are in
    int64_t added;                                  // frames
    int64_t judged;                                 // after so many; 0: never
    bool stopped;                                   // by --until
    struct weft_convergence convergence;            // as last judged
    double low, high;                // light that the targets hold, or the bound is of
    struct scene_shadow_info shadow; // of the first scene
    struct effect_lost lost;

    struct picture mean, error;
    struct weft_statistics statistics[PICTURE_CHANNELS]; // of the mean
    float preview_range[2];
    bool over_budget; // the bound is beyond --max-error, which an error line has told
    double start;     // monotonic
    struct effect_seconds seconds;
};

// ---- stages, in this order; all return a result after one error line ----------------------------

// Lists what an option's value "help" asks for. False: none has it.
bool effect_job_help(const struct effect_job *job);
// The operand and all options, as far as no scene is needed. (job_options.c)
enum weft_result effect_job_read_options(struct effect_job *job);
// That outputs differ, are no inputs, and can be written. (job_files.c)
enum weft_result effect_job_check_outputs(struct effect_job *job);
// The scenes, changed as asked for. (job_scenes.c)
enum weft_result effect_job_make_scenes(struct effect_job *job);
// The frames. (job_plan.c)
enum weft_result effect_job_make_plan(struct effect_job *job);
// The context, the accumulator, and with frames to be drawn the drawings. (job_draw.c)
enum weft_result effect_job_begin(struct effect_job *job);
// Another accumulator for them.
enum weft_result effect_job_create(struct effect_job *job, weft_accumulator **out);
// Draws and adds frames, until --until is met. (job_draw.c)
enum weft_result effect_job_draw(struct effect_job *job);
// The same on several ranks, of which each draws some; rank 0 has then what one process has.
// Collective. (job_divided.c)
enum weft_result effect_job_draw_divided(struct effect_job *job);
// Of radiosity that is clamped: how much light is lost. Collective. (job_lost.c)
enum weft_result effect_job_measure_lost(struct effect_job *job);
// The mean and its standard error as images. (job_result.c)
enum weft_result effect_job_make_result(struct effect_job *job);
enum weft_result effect_job_save(struct effect_job *job);

void effect_job_clear(struct effect_job *job);

// ---- parts of them ------------------------------------------------------------------------------

// Draws and adds so many frames from `first` on. (job_draw.c)
enum weft_result effect_job_draw_range(struct effect_job *job, int64_t first, int64_t count,
                                       const struct weft_progress *progress);
// After how many frames, of all, --until is judged next; and judges then. (job_draw.c)
int64_t effect_job_next_end(const struct effect_job *job);
enum weft_result effect_job_judge(struct effect_job *job);

// Refuses a bound that is beyond --max-error: sets over_budget. Returns WEFT_ERR_UNSUPPORTED after
// an error line. (job_draw.c)
enum weft_result effect_job_check_bound(struct effect_job *job, double bound);
// Warns where the mean, or what the scenes hold, is beyond the range that the method's targets hold
// or that its bound is of. (job_draw.c)
void effect_job_check_range(const struct effect_job *job);

// The preview's options. (job_result.c)
struct preview_options effect_job_preview(const struct effect_job *job);

// What a result's attributes say; what: it is, NULL for the mean. Returns how many. (job_report.c)
size_t effect_job_attributes(const struct effect_job *job, const char *what,
                             struct weft_metadata out[PICTURE_ATTRIBUTES]);
struct accumulation_stop effect_job_stop(const struct effect_job *job); // with --until
// The plan as text on standard output, and in short what came of it; with -v the plan goes where
// messages go. (job_report.c)
void effect_job_explain(const struct effect_job *job);
void effect_job_print_text(const struct effect_job *job);
enum weft_result effect_job_print_json(const struct effect_job *job); // job_json.c

#endif
