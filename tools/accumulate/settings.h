// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/settings.h - what a state (state_file.h) has beside frames and sums: the
// arguments that decide the result, in words, and what a job carries from frame to frame.
#ifndef WEFT_TOOLS_ACCUMULATE_SETTINGS_H
#define WEFT_TOOLS_ACCUMULATE_SETTINGS_H

#include "tools/accumulate/job.h"

enum { SETTINGS_MOST = 16 };
// Name and value of each, in an order of their own.
struct settings {
    size_t count;
    struct state_setting setting[SETTINGS_MOST];
    char *shape; // one's value
};
// Of a job that has looked at its frames. False: no memory. To be cleared.
bool settings_make(const struct accumulate_job *job, struct settings *out);
void settings_clear(struct settings *settings);

// The value of a name; "nothing" where there is none of that name.
const char *settings_find(const struct state_content *content, const char *name);
// The first of `b` that `a` has not, or of another value; NULL: there is none.
const struct state_setting *settings_find_other(const struct state_content *a,
                                                const struct state_content *b);
// That a state's are the job's. Returns WEFT_ERR_ARGUMENT (after a line that names the difference)
// or WEFT_ERR_MEMORY.
enum weft_result settings_compare(const struct accumulate_job *job, const char *path,
                                  const struct state_content *content);
// Makes a state's arguments the job's, for a job that has read none yet. Returns WEFT_ERR_ARGUMENT
// after an error line: an option is given that is of frames.
enum weft_result settings_adopt(struct accumulate_job *job, const struct state_content *content);

// Types of channels, the transfer function that was read last, what weights are called: as bytes to
// be freed. NULL data: no memory.
struct weft_bytes settings_save_carried(const struct accumulate_job *job);
// Takes them over. add: types that are wider than the job's alone. Returns WEFT_ERR_FORMAT after an
// error line.
enum weft_result settings_load_carried(struct accumulate_job *job, const char *path,
                                       const struct weft_bytes *carried, bool add);

#endif
