// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/job.h - one `weft accumulate`: what was asked, what was read, what came of it.
#ifndef WEFT_TOOLS_ACCUMULATE_JOB_H
#define WEFT_TOOLS_ACCUMULATE_JOB_H

#include "tools/accumulate/state_file.h"
#include "tools/common/json.h"
#include "tools/options/kernels.h"
#include "tools/options/options.h"
#include "tools/draw/preview.h"
#include "tools/methods/accumulate_report.h"
#include "tools/ranks/frames.h"

enum accumulate_option {
    ACCUMULATE_OUTPUT,
    ACCUMULATE_STDERR,
    ACCUMULATE_PREVIEW,
    ACCUMULATE_FRAMES,
    ACCUMULATE_SKIP_BAD,
    ACCUMULATE_RESUME,
    ACCUMULATE_EVERY,
    ACCUMULATE_PART,
    ACCUMULATE_WEIGHTS,
    ACCUMULATE_ADDING, // the first of enum accumulation_option
    ACCUMULATE_UNTIL = ACCUMULATE_ADDING + ACCUMULATION_UNTIL,
    ACCUMULATE_NONFINITE = ACCUMULATE_ADDING + ACCUMULATION_OPTION_COUNT,
    ACCUMULATE_TRANSFER,
    ACCUMULATE_AVERAGE_ALL,
    ACCUMULATE_TYPE,
    ACCUMULATE_COMPRESSION,
    ACCUMULATE_RANGE,
    ACCUMULATE_COLOUR_MAP,
    ACCUMULATE_EXPOSURE,
    ACCUMULATE_ANNOTATE,
    ACCUMULATE_TITLE,
    ACCUMULATE_RANKS, // the first of enum rank_option
    ACCUMULATE_EXPLAIN = ACCUMULATE_RANKS + RANK_OPTION_COUNT,
    ACCUMULATE_JSON,
    ACCUMULATE_NO_CLOBBER,
    ACCUMULATE_QUIET,
    ACCUMULATE_VERBOSE,
    ACCUMULATE_OPTION_COUNT
};

// What the options say, read once.
struct accumulate_request {
    struct accumulation how;
    enum weft_accumulate_nonfinite nonfinite;
    struct weft_transfer transfer;
    const struct weft_colour_map *colour_map;
    int part; // of each file
};

// A frame that was named, in the order in which frames count.
struct accumulate_frame {
    char *path;
    double weight;
    char *problem;            // why it was left out by --skip-bad; NULL: it was not
    bool done;                // it was looked at: added, or left out
    struct state_stamp stamp; // of its file, then
    int state;                // of joined states that which has it
};

// A channel of the frames.
struct accumulate_channel {
    bool alpha;                  // a share of the pixel, which no transfer function is applied to
    bool data;                   // it holds no colour
    int averaged;                // its place among the channels that are averaged; -1: it is copied
    int alpha_of;                // the channel that is its layer's alpha; -1: there is none
    enum weft_pixel_type widest; // of the frames that were added
};

// Frames' planes as light with associated alpha. (transfer.c)
struct accumulate_decoder {
    struct weft_transfer table_of; // what `table` has
    int table_bits;                // 0: nothing yet
    float *table;                  // of codes of 8 or 16 bits
    float *decoded, *alpha;        // of all averaged channels; of a row
    bool told_profile;             // that ICC profiles are not applied
};

// Frames of several ranks. (divided.c)
struct accumulate_divided {
    bool is; // there are several, or a rank option says how it would be
    struct rank_request request;
    struct rank_frames_report report;
};

// What --resume needs between its stages. (state.c)
struct accumulate_kept {
    struct state_file file; // as it was read, until its sums are taken over
    char *first;
    size_t first_size;              // the file of the first frame; NULL: it was not read yet
    int64_t held;                   // frames that the file holds, added and left out
    int64_t resumed;                // of these, from an earlier run
    int64_t saves;                  // in this one
    double saved_at, cost, seconds; // monotonic; of the last time it was saved, and of all
    bool warned;                    // that it cannot be
};

struct accumulate_job {
    const struct option_value *option; // [ACCUMULATE_OPTION_COUNT]
    const struct option_spec *spec;    // likewise
    const char *const *operands;       // NULL-ended
    struct accumulate_request request;

    struct accumulate_frame *frame;
    int64_t frame_count, frame_room;
    int64_t counting;  // frames whose weight is not 0: the others are not read
    int64_t *sequence; // their numbers, [counting]
    struct {
        char text[KERNELS_TEXT]; // as asked: "uniform", "gauss:0.2", a file's name
        bool file;               // it was read from there
        double total, least, largest;
    } weights;

    // What the frames have in common: of the first readable one, frame number `reference`. Its
    // planes are those of the channels that are copied, from frame `first` on.
    struct weft_image image;
    enum weft_image_file_kind kind;
    int64_t reference;
    struct accumulate_channel *channel; // [image.channel_count]
    int averaged_count;
    struct weft_plane *plane; // [averaged_count], of the frame that is added

    struct accumulate_divided divided;
    bool keeps_variance; // of the frames, for --stderr and --until
    struct accumulate_kept kept;
    struct {
        double at;     // monotonic seconds: the mean so far was written, or reading began
        int64_t added; // of so many frames; 0: not yet
    } every;
    bool writing;     // outputs, just now
    unsigned written; // outputs that this run has written, as 1 << option
    // The operands are states: their options hold, and the first frame's file is the first one's.
    bool joins;
    struct option_value adopted[ACCUMULATE_OPTION_COUNT];
    int substitute_fd;   // + 1; 0: none
    char substitute[32]; // its path

    weft_context *context; // NULL: the method needs none
    weft_accumulator *accumulator;
    struct weft_accumulator_report planned; // before the first frame
    struct accumulate_decoder decoder;
    struct weft_transfer transfer; // of the frame that was read last
    struct weft_log log;           // the accumulator's
    bool adding;                   // its errors are the frame's: they go to `message`
    char message[1024], doing[64];
    int64_t begun; // the place in `sequence` that is being read from

    // Frames are read in the order of `sequence`. `next` is the place there of the first one that
    // was not looked at yet; `first` the number of the first frame that was added, -1: none.
    int64_t next, first;
    int64_t added, skipped; // counting frames that were added, and bad ones that were left out
    bool stopped;           // by --until
    struct weft_convergence convergence; // as last judged
    int64_t judged;                      // when: frames added then; 0: never

    struct weft_accumulator_report report;     // of the frames that were added
    struct weft_image result;                  // the mean
    struct weft_image error;                   // the standard error, with --stderr
    struct weft_metadata *texts, *error_texts; // their own attributes
    struct weft_statistics *statistics;        // of the result, [image.channel_count]
    struct weft_image_save_report saved, error_saved;
    float preview_range[2];
    bool over_budget; // the bound is beyond --max-error, which an error line has told
    double start;     // monotonic seconds
    double plan_seconds, context_seconds, read_seconds, decode_seconds, add_seconds, judge_seconds,
        result_seconds, write_seconds;
};

// ---- stages, in this order; all return a result after one error line ----------------------------

// The options, as far as no file is needed. (options.c)
enum weft_result accumulate_read_options(struct accumulate_job *job);
// Names of frames from operands, patterns and lists. (names.c)
enum weft_result accumulate_list_frames(struct accumulate_job *job);
// Their weights. (weights.c)
enum weft_result accumulate_set_weights(struct accumulate_job *job);
// Which frames count, and what they weigh together, where the weights are known.
enum weft_result accumulate_sum_weights(struct accumulate_job *job);
// That outputs can be written and are no inputs. (files.c)
enum weft_result accumulate_check_outputs(struct accumulate_job *job);
// That frames are there. (files.c)
enum weft_result accumulate_check_frames(struct accumulate_job *job);
// What frames have in common, by the first readable one. (channels.c)
enum weft_result accumulate_look(struct accumulate_job *job);
// The accumulator for them, and a context where it needs one. (begin.c)
enum weft_result accumulate_begin(struct accumulate_job *job);
// Another accumulator for them.
enum weft_result accumulate_create(struct accumulate_job *job, weft_accumulator **out);
// Adds all frames from job->next on, one after another. (read.c)
enum weft_result accumulate_read(struct accumulate_job *job);
// The mean so far as job->result: may be called at any time after the first frame was added, again
// and again. (result.c)
enum weft_result accumulate_make_result(struct accumulate_job *job);
// Writes the outputs. (result.c)
enum weft_result accumulate_save(struct accumulate_job *job);

void accumulate_clear(struct accumulate_job *job);

// ---- parts of them ------------------------------------------------------------------------------

enum { ACCUMULATE_TEXT = 256, ACCUMULATE_AHEAD_MB = 256 }; // the latter of frames read ahead

// Whether a channel holds no colour, by its name and those beside it. (channels.c)
bool accumulate_is_data(const struct weft_image *image, size_t channel);
// The image's number of a channel; image.channel_count where it has none of that name.
size_t accumulate_find_channel(const struct weft_image *image, const char *name);
// That a frame is of one kind, size and shape with the first. Returns WEFT_ERR_ARGUMENT (its kind)
// or WEFT_ERR_FORMAT after a line that names both.
enum weft_result accumulate_match(const struct accumulate_job *job,
                                  const struct weft_image_frame *frame);
// Takes over the types of a frame that counts.
void accumulate_widen(struct accumulate_job *job, const struct weft_image *image);
enum weft_pixel_type accumulate_wider(enum weft_pixel_type a, enum weft_pixel_type b);
// Copies the channels that are not averaged, once. Returns WEFT_ERR_MEMORY.
enum weft_result accumulate_copy(struct accumulate_job *job, const struct weft_image_frame *frame);
// The same of the first frame that was added, by an earlier run.
enum weft_result accumulate_copy_again(struct accumulate_job *job);

// Fills job->plane from a frame that matches: its own planes, or what they stand for. Returns
// WEFT_ERR_UNSUPPORTED (a transfer function) or WEFT_ERR_MEMORY. (transfer.c)
enum weft_result accumulate_decode(struct accumulate_job *job,
                                   const struct weft_image_frame *frame);
void accumulate_clear_decoder(struct accumulate_decoder *decoder);
// "sRGB", "linear light", "code ^ 2.2"
const char *accumulate_transfer_text(const struct weft_transfer *transfer,
                                     char text[ACCUMULATE_TEXT]);

// Refuses a bound that is beyond --max-error: sets over_budget. Returns WEFT_ERR_UNSUPPORTED after
// an error line. (begin.c)
enum weft_result accumulate_check_bound(struct accumulate_job *job, double bound);

// Whether what has the output's name already is kept: not what this run has written.
bool accumulate_keeps(const struct accumulate_job *job, enum accumulate_option output);
// The preview's options. (preview.c)
struct preview_options accumulate_preview_options(const struct accumulate_job *job);
// In colour where there are R, G and B. (preview.c)
enum weft_result accumulate_save_preview(struct accumulate_job *job);

// What a result's attributes say; what: it is, NULL for the mean. Returns how many. (report.c)
enum { ACCUMULATE_ATTRIBUTES = 20 };
size_t accumulate_attributes(const struct accumulate_job *job, const char *what,
                             struct weft_metadata out[ACCUMULATE_ATTRIBUTES]);
void accumulate_explain(const struct accumulate_job *job);
enum weft_result accumulate_print_json(const struct accumulate_job *job);
void accumulate_print_text(const struct accumulate_job *job);

#endif
