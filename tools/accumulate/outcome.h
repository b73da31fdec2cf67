// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/outcome.h - what came of frames that some rank has read, on their way to rank 0,
// where they are counted and told in the order of the frames.
#ifndef WEFT_TOOLS_ACCUMULATE_OUTCOME_H
#define WEFT_TOOLS_ACCUMULATE_OUTCOME_H

#include "tools/accumulate/job.h"

struct outcome {
    struct state_stamp stamp;      // of its file
    struct weft_transfer transfer; // that its codes had; curve auto: none was looked for
    // Owned; NULL: there is none. Why it is left out; and that its profile is not applied, which is
    // told of the first frame alone.
    char *problem, *warning;
};
struct outcomes {
    int64_t count;
    struct outcome *list; // owned
};

// All of them empty. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result outcomes_create(int64_t count, struct outcomes *out);
void outcomes_clear(struct outcomes *outcomes); // accepts {0}

// As bytes, with the types that channels are widened to so far, to be freed; and the same as
// outcomes first to first + count - 1 of others, types being widened. Return WEFT_ERR_MEMORY after
// an error line, and the latter WEFT_ERR_FORMAT (cut).
enum weft_result outcomes_pack(const struct outcomes *outcomes, const struct accumulate_job *job,
                               void **data, size_t *size);
enum weft_result outcomes_take(struct outcomes *outcomes, struct accumulate_job *job, int64_t first,
                               int64_t count, const void *data, size_t size);

#endif
