// SPDX-License-Identifier: BSD-3-Clause
// tools/slice/save.h - a slice's files: their names and the preview's options, to be checked before
// anything runs.
#ifndef WEFT_TOOLS_SLICE_SAVE_H
#define WEFT_TOOLS_SLICE_SAVE_H

#include "tools/draw/preview.h"
#include "tools/slice/job.h"

struct preview_options slice_preview_options(const struct slice_job *job);

// With --annotate: what is around the preview, which saving takes from the job.
void slice_annotate(struct slice_job *job);

#endif
