// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/divided.h - frames of files on several ranks. Rank 0 names them, looks at what
// is there and goes on from a state; every rank looks at the first one by itself, reads its own
// alone, and adds them to sums of its own. In the end, and whenever the mean so far is to be
// judged, saved or written, the sums become one on rank 0, which has then what one process has
// after as many frames.
#ifndef WEFT_TOOLS_ACCUMULATE_DIVIDED_H
#define WEFT_TOOLS_ACCUMULATE_DIVIDED_H

#include "tools/accumulate/job.h"

// Gives other ranks the frames that rank 0 has named, with their weights. Collective.
enum weft_result divided_share_frames(struct accumulate_job *job);
// That what frames have in common is the same everywhere; and gives other ranks the order of
// frames, of which a state may hold the first ones. Collective.
enum weft_result divided_share_order(struct accumulate_job *job);
// Reads all frames from job->next on. Collective; rank 0 has what came of them.
enum weft_result divided_read(struct accumulate_job *job);

#endif
