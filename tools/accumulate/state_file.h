// SPDX-License-Identifier: BSD-3-Clause
// tools/accumulate/state_file.h - the file that `weft accumulate --resume` keeps.
// It holds what decides the result, what was consumed, and the sums; of this machine's byte order:
//     magic "WEFTMEAN", format (uint32), byte order (uint32), size of the file (uint64),
//     XXH3 (64 bits) of all that follows, weft's version (32 bytes), sizes of five parts (uint64),
//     settings  name and value of each, all ended by NUL, after the folder in which weft was run
//     frames    of each size, time, weight, lengths of name and problem, and these two
//     first     the file of the first frame that was added, as it was
//     carried   what the command carries from frame to frame (settings.h)
//     sums      weft_accumulator_save's bytes
// Each part starts at a multiple of 8 bytes.
#ifndef WEFT_TOOLS_ACCUMULATE_STATE_FILE_H
#define WEFT_TOOLS_ACCUMULATE_STATE_FILE_H

#include "weft.h"

// An argument that decides the result, in words.
struct state_setting {
    const char *name, *value; // "--method", "exact"
};

// What a file was when it was consumed: other bytes under its name are told by these.
struct state_stamp {
    int64_t size;       // -1: there was no file
    int64_t changed_ns; // since 1970
};
struct state_frame {
    const char *name; // as it was given
    struct state_stamp stamp;
    double weight;
    const char *problem; // why it was left out, with --skip-bad; "": it was added
};

// All of a state; what it points to is borrowed.
struct state_content {
    const char *folder; // in which relative names are
    size_t setting_count, frame_count;
    const struct state_setting *settings;
    const struct state_frame *frames; // in the order in which they were given
    struct weft_bytes first, carried, sums;
};

// Returns whether the file is a state, by its magic. Names of what is no file are none.
bool state_file_is(const char *path);

// The file's stamp now; size -1 where there is none.
struct state_stamp state_file_stamp(const char *path);
bool state_file_same_stamp(const struct state_stamp *a, const struct state_stamp *b);

// Writes it, whole or not at all, in place of one that is there. Returns WEFT_ERR_WRITE or
// WEFT_ERR_MEMORY after an error line.
enum weft_result state_file_write(const char *path, const struct state_content *content);

// A state that was read.
struct state_file {
    struct state_content content; // points into what follows
    char *bytes;
    struct state_setting *settings;
    struct state_frame *frames;
};
// Reads and checks it. Returns WEFT_ERR_OPEN, WEFT_ERR_FORMAT (no state, cut, damaged),
// WEFT_ERR_UNSUPPORTED (of another version of weft or its format, or another byte order) or
// WEFT_ERR_MEMORY, after an error line that names the file.
enum weft_result state_file_read(const char *path, struct state_file *out);
void state_file_clear(struct state_file *file); // accepts {0}

#endif
