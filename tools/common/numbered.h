// SPDX-License-Identifier: BSD-3-Clause
// tools/common/numbered.h - names of files that are numbered: "smoke_%04d.vdb" is smoke_0007.vdb
// and smoke_12345.vdb. A name has one conversion, %d or %0Nd (N digits at least, 1 to 9), and %% is
// a percent sign.
#ifndef WEFT_TOOLS_COMMON_NUMBERED_H
#define WEFT_TOOLS_COMMON_NUMBERED_H

#include "weft.h"

// Whether a number belongs into the name: it has %d or %0Nd somewhere.
bool numbered_is(const char *name);

// Whether it can be numbered. Otherwise returns WEFT_ERR_ARGUMENT after an error line, which starts
// with `option` ("-o ", or "" for what has no option). required: a conversion must be there.
enum weft_result numbered_check(const char *option, const char *name, bool required);

// FIRST-LAST or FIRST-LAST:STEP, as --frames has it.
struct numbered_span {
    int64_t first, last, step; // 0 <= first <= last <= NUMBERED_MAX, step >= 1
};
enum { NUMBERED_MAX = 999999999 };
// Reads a span of `most` numbers at most. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result numbered_read_span(const char *text, int64_t most, struct numbered_span *out);

// A file that a frame reads or writes.
struct numbered_file {
    char *path; // owned by whoever made the list
    int64_t frame;
    bool input;
};
// That no file is written twice, or is read by one frame and written by another; frames may read
// the same. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY after an error line.
enum weft_result numbered_check_files(const struct numbered_file *file, size_t count);

// The name of a number, for one that was checked; to be freed, NULL where memory ran out.
char *numbered_format(const char *name, int64_t number);

#endif
