// SPDX-License-Identifier: BSD-3-Clause
// tools/common/paths.h - checks of file names before long work.
#ifndef WEFT_TOOLS_COMMON_PATHS_H
#define WEFT_TOOLS_COMMON_PATHS_H

#include <sys/types.h>

#include "weft.h"

// What a name leads to, through links too: names of one file are equal, also where it does not
// exist yet.
struct paths_identity {
    dev_t device; // of the file, or where there is none yet of its folder
    ino_t inode;
    const char *base; // "", or its name in that folder: part of the path, which is borrowed
};
struct paths_identity paths_identify(const char *path);
// As strcmp, in an order of its own.
int paths_compare(const struct paths_identity *a, const struct paths_identity *b);
// Whether both names lead to one file, or would once it exists.
bool paths_same_file(const char *a, const char *b);

// Whether an output could be written now: its folder exists and is writable, it is not a folder
// itself, and with no_clobber it does not exist. Returns WEFT_ERR_WRITE after an error line.
enum weft_result paths_check_output(const char *path, bool no_clobber);

// An output that a user named.
struct paths_output {
    const char *option; // "--preview"
    const char *path;   // NULL: it was not given
};
// That outputs differ from each other and from inputs, of which some may be NULL. Returns
// WEFT_ERR_ARGUMENT after an error line.
enum weft_result paths_check_distinct(const struct paths_output *output, int output_count,
                                      const char *const *input, int input_count);

// Whether the name stands for standard output, as "/dev/stdout" does. NULL does not.
bool paths_is_stdout(const char *path);

// Whether it is a descriptor, a device or a pipe: nothing that is made anew and has a folder.
bool paths_is_special(const char *path);

// From the last '.' in the part after the last '/' on; "" where there is none, or it comes first or
// last.
const char *paths_ending(const char *path);

// The part after the last '/'.
const char *paths_base_name(const char *path);

#endif
