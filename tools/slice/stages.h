// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/stages.h - what a slice is made in, one after the other: each stage takes what those
// before it left in the job and adds to it. All return what failed, after an error line.
#ifndef WEFT_TOOLS_SLICE_STAGES_H
#define WEFT_TOOLS_SLICE_STAGES_H

#include "tools/slice/job.h"

// sources.c: the volumes, unless they are open: of the first one sources are made, and of others
// the same. The first source's reader is begun before all else, and what goes wrong with it is told
// when the volume is needed; the others are opened when it is their turn.
enum weft_result slice_begin(struct slice_setup *setup);
enum weft_result slice_open(struct slice_job *job);
enum weft_result slice_take_source(struct slice_job *job, int index);
void slice_close(struct slice_setup *setup);         // volumes; which sources there are stays known
void slice_clear_sources(struct slice_setup *setup); // all of it

// plane.c: the options that frame the picture, without a file; and the plane with its size, by the
// first source's volume.
enum weft_result slice_read_framing(struct slice_setup *setup);
enum weft_result slice_place(struct slice_job *job);

// channels.c: the options of what is shown of a source. What does not go with more than the value
// of one grid is an error line.
enum weft_result slice_read_quantities(struct slice_setup *setup);
enum weft_result slice_check_channels(const struct slice_setup *setup);
// Where the pixels go, and what they are called. Memory for them comes before planning, which takes
// its time for a size that cannot be held anyway.
enum weft_result slice_allocate(struct slice_job *job);
// Planes that a source's run fills in, one after the other: of its derivatives, or of channels.
float *slice_planes(const struct slice_job *job);
float *slice_channel_planes(const struct slice_job *job); // the latter
// With --slab: what the library is to make of the source, as it was planned; and what goes with it.
struct weft_slab_params slice_slab_params(const struct slice_job *job);
enum weft_result slice_check_slab(const struct slice_setup *setup);
// Where the cuts of a planned source lie; nothing without --slab.
enum weft_result slice_place_slab(struct slice_job *job);
// Channels of what was computed of a source; the range of each.
enum weft_result slice_make_channels(struct slice_job *job);
// With --verify: how far each may be off where derivatives may by their own bounds.
void slice_bound_channels(struct slice_job *job, const double *error);
json_t *slice_channels_json(const struct slice_job *job);
// The first three channels where they are one vector; their preview is a colour. false: they are
// not, and the first one is shown. range: what is shown as least and most of each.
bool slice_shows_vector(const struct slice_job *job, float range[2]);

// range.c: the one range of all frames' previews, where --range does not say it: that of all the
// grid's voxels, tiles and background.
enum weft_result slice_find_range(struct slice_job *job);

// curved.c: slices of points. The options that go with them, without a file; positions, which are
// the geometry's size; pixels of the source whose turn it is; and what is told of them.
bool slice_is_curved(const struct slice_setup *setup);
enum weft_result slice_check_curve(const struct slice_setup *setup);
enum weft_result slice_load_curve(struct slice_job *job);
enum weft_result slice_compute_points(struct slice_job *job);
void slice_warn_of_positions(const struct slice_job *job);
json_t *slice_curve_json(const struct slice_job *job);

// plan.c: the slice's plan, and with --profile that of its passes, but where --max-error chooses.
enum weft_result slice_plan(struct slice_job *job);

// The slice planned anew, of the same footprint, where the setup's engine or resident volume is not
// the plan's any more.
enum weft_result slice_plan_anew(struct slice_job *job);

// resident.c: what stays of the volume from frame to frame, made for the first one in three
// quarters of --memory; plans have the rest.
enum weft_result slice_keep_volume(struct slice_job *job);
json_t *slice_resident_json(const struct slice_setup *setup); // null where nothing stays

// hardware.c: with --hardware its plan, for the context's sampler or, where there is no context,
// for one as most are.
enum weft_result slice_plan_hardware(struct slice_job *job);
// What is promised of a slice that was filtered so, for its verification; else nothing is done.
enum weft_result slice_bound_hardware(struct slice_job *job);
json_t *slice_hardware_json(const struct weft_hardware_plan_info *info);

// engine.c: the options of what filters, and the context where OpenGL does, once for a command.
// Where none can be had, the slice is planned for the CPU engine if that was left open.
enum weft_result slice_read_engine(struct slice_setup *setup);
enum weft_result slice_create_context(struct slice_job *job);

// run.c: the pixels.
enum weft_result slice_run(struct slice_job *job);
enum weft_result slice_verify(struct slice_job *job);
// Both, and the channels of the source whose turn it is.
enum weft_result slice_compute(struct slice_job *job);
// The same of a plan of the slice's, or of a part of it, into memory that is not the job's.
enum weft_result slice_run_plan(const struct slice_job *job, const weft_slice_plan *plan,
                                const weft_hardware_plan *hardware, float *pixels,
                                const struct weft_progress *progress,
                                struct weft_slice_report *out);
enum weft_result slice_run_method(const struct slice_job *job, const weft_method_plan *plan,
                                  float *pixels, const struct weft_progress *progress,
                                  struct weft_slice_report *out);
// out: of each output of the plan.
enum weft_result slice_verify_plan(struct slice_job *job, const weft_slice_plan *plan,
                                   const float *pixels, const struct weft_progress *progress,
                                   struct weft_verify_report *out);
// What is left to do once the job has the report of its pixels, and of their verification.
enum weft_result slice_finish_run(struct slice_job *job);
enum weft_result slice_finish_verify(struct slice_job *job);

// measure.c: the statistics of what a footprint reaches, measured by all ranks that share the
// slice's regions. `before`: how it went so far on this rank, agreed upon first.
enum weft_result slice_measure(struct slice_job *job, enum weft_result before,
                               weft_footprint *footprint, struct weft_slice_statistics *out);
// divide.c: the whole slice from opening its volume to its verification, by all ranks: what there
// is to save and to tell is on rank 0. The setup's engine is rank 0's choice then. Collective.
enum weft_result slice_make_divided(struct slice_job *job);
// Before frames that ranks divide: what is found out with the first one, once for all. Collective.
enum weft_result slice_share_first(struct slice_setup *setup);

// stream.c: the file of a slice, written in a thread while ranks make its bands. Begun before the
// first band is there, by `write`; false: there is no thread, and the file is written when the
// slice is saved. What it says of how it was made must be known (slice_list_attributes).
bool slice_stream_begin(struct slice_job *job, enum weft_result (*write)(struct slice_job *job));
// A band that has come, whose data is taken; also where nothing is streamed.
void slice_stream_put(struct slice_job *job, int64_t band, struct weft_bytes data);
// All is well: the last band may be written. Before that no file appears.
void slice_stream_allow(struct slice_job *job);
// Waits for the file, which is there then, and returns how it went. Gives it up where it was not
// allowed. Nothing to do where nothing is streamed.
enum weft_result slice_stream_end(struct slice_job *job);
// Band by band, for struct weft_image_save_params.
enum weft_result slice_stream_give(void *job, int line, struct weft_bytes *out);

// save.c: the files, from what the job has told (report.h): neither plans nor the volume are looked
// at, and another thread may do it while the next slice is made.
enum weft_result slice_save(struct slice_job *job);
// The first of them alone.
enum weft_result slice_write_exr(struct slice_job *job);

#endif
