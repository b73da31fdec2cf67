// SPDX-License-Identifier: BSD-3-Clause
// tools/resample/warp.h - `weft resample` under a map of one's own: --matrix, --rotate,
// --perspective, --positions.
#ifndef WEFT_TOOLS_RESAMPLE_WARP_H
#define WEFT_TOOLS_RESAMPLE_WARP_H

#include "tools/common/json.h"
#include "weft.h"

struct resample_job;

// The map of a job; all 0 where none is asked for.
struct resample_warp {
    bool is;
    double matrix[9];            // as it is asked for; of --rotate once the image is there
    struct weft_image positions; // of --positions
    const float *position[2];    // its planes X and Y
    weft_warp_plan *plan;
    weft_warp_compiled *compiled; // where it runs
};

// Whether a map is asked for.
bool resample_is_warp(const struct resample_job *job);
// Reads the options, and refuses what does not go with them. Returns WEFT_ERR_ARGUMENT or
// WEFT_ERR_UNSUPPORTED after an error line.
enum weft_result resample_read_warp(struct resample_job *job);
// The result's windows: those of the positions' file; else of --size pixels from the input's corner
// on, or the input's. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_set_warp_windows(struct resample_job *job);
// Channels of a layer's R, G, B and A are warped together.
enum weft_result resample_make_warp_groups(struct resample_job *job);
enum weft_result resample_plan_warp(struct resample_job *job);
enum weft_result resample_compute_warp(struct resample_job *job);
void resample_clear_warp(struct resample_warp *warp);

// What the file says of the map: --matrix 1,0,... as it was asked for.
void resample_warp_text(const struct resample_job *job, char *text, size_t size);
json_t *resample_warp_json(const struct resample_job *job);

#endif
