// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/parcel.h - what a rank made of a slice, or of a region of one, on its way to rank 0,
// which saves and tells it: pixels, or their lines as a file has them; what the run was; and of
// whole slices what is told of them. Ranks are the same program: numbers lie as they are in memory.
#ifndef WEFT_TOOLS_SLICE_PARCEL_H
#define WEFT_TOOLS_SLICE_PARCEL_H

#include "tools/slice/job.h"

enum parcel_kind { PARCEL_MADE, PARCEL_SKIPPED, PARCEL_OVER_BUDGET };

// Packs the lines of a slice's region, whose pixels lie without gaps between rows, as its file has
// them. Returns as weft_image_pack, after an error line.
enum weft_result parcel_pack_lines(const struct slice_job *job, int width, int height,
                                   const float *pixels, struct weft_image_packed *out);

// A region: what job has of it, in report, error and verify_seconds. pixels may be NULL, packed
// {0}. *data is the caller's to free. Returns WEFT_ERR_MEMORY.
enum weft_result parcel_write_region(const struct slice_job *job, size_t pixel_count,
                                     const float *pixels, const struct weft_image_packed *packed,
                                     void **data, size_t *size);
// A whole slice that was made, with its attributes, JSON and messages, or that was not: `kind`.
enum weft_result parcel_write_slice(struct slice_job *job, enum parcel_kind kind, void **data,
                                    size_t *size);

// The region's report and error are added to the job's, of which `known` tells whether it has any.
// *packed and *pixels point into the data. Returns WEFT_ERR_FORMAT after an error line (another
// version's).
struct parcel_region {
    struct weft_bytes packed;
    const float *pixels; // NULL: none
};
enum weft_result parcel_read_region(const void *data, size_t size, struct slice_job *job,
                                    bool known, struct parcel_region *out);
// Fills in a job that sweep_start has begun.
enum weft_result parcel_read_slice(const void *data, size_t size, struct slice_job *job,
                                   enum parcel_kind *kind);

#endif
