// SPDX-License-Identifier: BSD-3-Clause
// tools/antialias/job.h - one `weft antialias`: what was asked, what was drawn, what came of it.
#ifndef WEFT_TOOLS_ANTIALIAS_JOB_H
#define WEFT_TOOLS_ANTIALIAS_JOB_H

#include "tools/antialias/drawer.h"
#include "tools/options/kernels.h"
#include "tools/options/options.h"
#include "tools/draw/picture.h"
#include "tools/draw/preview.h"
#include "tools/ranks/options.h"
#include "tools/render/scene_options.h"

enum antialias_option {
    ASK_OUTPUT,
    ASK_PREVIEW,
    ASK_WEIGHT_MAP,
    ASK_SCENES, // the first of enum scene_option
    ASK_SCENE = ASK_SCENES + SCENE_OPTION_SCENE,
    ASK_FRAMES = ASK_SCENES + SCENE_OPTION_COUNT,
    ASK_SAMPLES,
    ASK_FILTER,
    ASK_FILTER_WIDTH,
    ASK_FORM,
    ASK_COINCIDENT,
    ASK_SUMS,
    ASK_SUM_RANGE,
    ASK_ALLOW_WEIGHT,
    ASK_RESOLVE,
    ASK_DEPTH,
    ASK_FORMAT,
    ASK_MARK,
    ASK_CONTRAST,
    ASK_MAX_EDGE_SHARE,
    ASK_STORE,
    ASK_METHOD,
    ASK_PATTERN,
    ASK_VERIFY,
    ASK_CONTEXT,
    ASK_THREADS,
    ASK_TYPE,
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
extern const char *const antialias_depth_choices[]; // "24", "32"; NULL-ended
extern const char *const antialias_map_endings[];   // ".exr", ".png"; NULL-ended

enum { ANTIALIAS_MAX_FRAMES = 10000, ANTIALIAS_TEXT = 256 };

// What the self-checks of all pictures found.
struct antialias_weights {
    int64_t less, more;               // pixels
    int frames;                       // pictures that have any of them
    int first_frame;                  // of which places are told
    int first_less[2], first_more[2]; // row 0 on top; -1, -1: there is none
    double largest;                   // departure, as a share of the whole weight
};

// How far all pictures are from exact ones.
struct antialias_exactness {
    double largest, square;    // |difference| of a value; sum of its squares
    int at[2], channel, frame; // where the largest is, row 0 on top
    uint64_t values;           // that were compared; 0: none
    double known_to;           // of the exact values themselves, estimated
};

// What each stage took, in seconds.
struct antialias_seconds {
    double scene, context, prepare, draw, verify, write;
};

// What ranks divide among each other: parts of one picture after the other, or whole pictures.
struct antialias_divided {
    bool is; // there are several ranks, or an option asks for parts
    bool by_frame;
    struct rank_request request;
    struct weft_items_report work; // of all works together; items of the last one
    // On rank 0: marks of all parts of the last picture, without `marked`; calls of all ranks.
    struct weft_marks marks;
    uint64_t callbacks;
};

struct antialias_job {
    const struct option_value *option; // [ASK_OPTION_COUNT]
    const char *const *operands;       // NULL-ended

    struct scene_request request;
    struct antialias_params params; // of the drawer
    enum weft_context_kind kind;
    int frames;
    weft_kernel_file *filter_file; // NULL: the filter is of no file
    struct antialias_divided divided;

    const char *scene_name; // as it was written
    struct scene scene;
    scene_drawing *drawing;
    weft_context *context;
    antialias_drawer *drawer;

    // Of the last picture, until it is written.
    struct picture picture;
    float *weight; // of its pixels; NULL: no map is asked for
    struct weft_image_save_report weight_saved;
    double *exact; // [y][x][4], rows upwards; NULL: it is not verified
    float preview_range[2];
    struct weft_statistics statistics[PICTURE_CHANNELS];

    int prepared;         // picture whose places and shadows the drawing has; -1: none
    int drawn;            // pictures
    double *seconds_each; // [frames]
    struct antialias_report report;
    struct antialias_weights weights;
    struct antialias_exactness exactness;
    struct scene_shadow_info shadow;
    double start; // monotonic
    struct antialias_seconds seconds;
};

// ---- stages, in this order; all return a result after one error line ----------------------------

// Lists what an option's value "help" asks for. False: none has it.
bool antialias_job_help(const struct antialias_job *job);
// The operand and all options, as far as no scene is needed. (job_options.c)
enum weft_result antialias_job_read_options(struct antialias_job *job);
// That outputs differ, are no inputs, and can be written. (job_files.c)
enum weft_result antialias_job_check_outputs(struct antialias_job *job);
// The scene, changed as asked for; context and drawer, and with pictures to be drawn the drawing.
// (job_draw.c)
enum weft_result antialias_job_begin(struct antialias_job *job);
// Draws, checks and writes all pictures. (job_draw.c)
enum weft_result antialias_job_draw(struct antialias_job *job);
// The same by all ranks together. Collective. (job_divided.c)
enum weft_result antialias_job_draw_divided(struct antialias_job *job);

void antialias_job_clear(struct antialias_job *job);

// ---- parts of them ------------------------------------------------------------------------------

// Finds where all is in a picture, and draws its shadow maps, if that is not done. (job_draw.c)
enum weft_result antialias_job_prepare(struct antialias_job *job, int frame);
// Checks and writes the picture whose planes, weights and report are there. (job_draw.c)
enum weft_result antialias_job_finish(struct antialias_job *job, int frame);

// The time of the scene that a picture shows. (job_options.c)
double antialias_job_time(const struct antialias_job *job, int frame);

// An option that was given and that form jitter of acaa has no use for; NULL: none.
// (job_options.c)
const char *antialias_job_form_option(const struct antialias_job *job);

// An output's name for a picture, to be freed; *out is NULL where it is not asked for. Returns
// WEFT_ERR_MEMORY after an error line. (job_files.c)
enum weft_result antialias_job_name(const struct antialias_job *job, enum antialias_option output,
                                    int frame, char **out);
// Writes the picture that was drawn last, as often as it is asked for. (job_files.c)
enum weft_result antialias_job_save(struct antialias_job *job, int frame);

// The exact picture of a frame, before it is drawn, and what the drawn one differs by. Without
// --verify nothing. (job_verify.c)
enum weft_result antialias_job_make_exact(struct antialias_job *job, int frame);
void antialias_job_compare(struct antialias_job *job, int frame);

// Whether all pixels have their weight, or may do without it; otherwise false after an error line.
// (job_weights.c)
void antialias_job_add_weights(struct antialias_job *job, int frame); // of the last picture
bool antialias_job_check_weights(const struct antialias_job *job);

// The preview's options, for any name. (job_options.c)
struct preview_options antialias_job_preview(const struct antialias_job *job);

// What a picture's attributes say; what: it is, NULL for the picture. Returns how many.
// (job_report.c)
size_t antialias_job_attributes(const struct antialias_job *job, const char *what, int frame,
                                struct weft_metadata out[PICTURE_ATTRIBUTES]);
// The median of what pictures took until they were read back, in seconds.
double antialias_job_median(const struct antialias_job *job);
const char *antialias_job_filter(const struct antialias_job *job, char text[KERNELS_TEXT]);
// What would be drawn as text on standard output, and in short what came of it.
void antialias_job_explain(const struct antialias_job *job);
void antialias_job_print_text(const struct antialias_job *job);
enum weft_result antialias_job_print_json(const struct antialias_job *job); // job_json.c

#endif
