// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/sequence.h - the values of many image files, one after another, as the files have
// them: EXR, PNG and TIFF. Reader processes decode ahead; memory and file descriptors do not grow
// with the number of files.
//
// A process reads up to 256 files. One that crashes, is over a limit or contradicts itself costs
// the file that it worked on alone, and no file is given up for what files before it did to its
// process: it is judged by what a fresh one makes of it. A file that takes a process over without
// being noticed may make up the values of the files that this process reads after it, never those
// of other processes, nor change values that were handed out; processor time is then limited for
// all of its files together, the time of each answer as ever.
#ifndef WEFT_TILES_IMAGE_SEQUENCE_H
#define WEFT_TILES_IMAGE_SEQUENCE_H

#include "image.h"
#include "plane.h"

WEFT_BEGIN_DECLS

// One file of a sequence. Valid until the next call for the sequence.
struct weft_image_frame {
    int64_t index;    // of its name
    const char *name; // as it was given
    // WEFT_OK, or why it has no values: WEFT_ERR_OPEN (missing, a folder, a pipe), _FORMAT (empty,
    // damaged, cut, none of these), _UNSUPPORTED (deep, subsampled), _ARGUMENT (no such
    // part), _LIMIT, _READER (its reader crashed). The sequence goes on with the next file.
    enum weft_result result;
    char message[1024]; // one line that says why and names the file; "" where it was read
    // What the members below say counts only where result is WEFT_OK.
    enum weft_image_file_kind kind;
    uint64_t file_bytes; // size and time of the last change (nanoseconds since 1970), of the file
    int64_t changed_ns;  // that was opened
    // Windows, channels and attributes, without planes. Of PNG and TIFF as weft_image_load has
    // them, but that channels of codes are of type float, and without attributes.
    struct weft_image image;
    // One for each of image's channels, in the same order, read-only and never changed by anybody:
    // as the file has them: float, half, uint, unorm8 or unorm16, codes and alpha as they are.
    const struct weft_plane *plane;
    struct weft_code_info codes; // of PNG and TIFF files
};

// Processes that decode at once, at most.
enum { WEFT_IMAGE_SEQUENCE_MAX_READERS = 32 };

struct weft_image_sequence_params {
    int64_t count; // of names, >= 1 (required)
    // Returns the name of file i, or NULL for one that is left out: nothing is read of it, and no
    // frame comes of it. Called in the order of i, once each and ahead of the frame, in the thread
    // that calls weft. The text is copied before name is called again. Required.
    const char *(*name)(void *priv, int64_t i);
    // Asked while a call waits, at least ten times a second and after every signal: true ends the
    // call, which returns WEFT_ERR_CANCELLED. Default NULL: waits go on.
    bool (*stop)(void *priv);
    void *priv; // handed to both as it is
    // Up to WEFT_IMAGE_SEQUENCE_MAX_READERS (default 0: one for each core). Fewer start where the
    // limit of open files leaves no two for each.
    int readers;
    // Of frames that are decoded before they are asked for; the one that is asked for and the one
    // that the caller has come on top. Default 0: 256 MiB.
    uint64_t memory_bytes;
    int part;                   // of each file, from 0
    bool info_only;             // headers only: frames have no planes (default: values, too)
    struct weft_limits limits;  // of a reader process, for one file (default: see limits.h)
    const struct weft_log *log; // borrowed for the sequence's life; may be NULL
};
#define WEFT_IMAGE_SEQUENCE_DEFAULTS
#define weft_image_sequence_params(...)                                                            \
    (&(struct weft_image_sequence_params){WEFT_IMAGE_SEQUENCE_DEFAULTS __VA_ARGS__})

// Thread-safety: one thread at a time.
typedef struct weft_image_sequence weft_image_sequence;

// Opens no file yet. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT (a range) or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result
weft_image_sequence_create(const struct weft_image_sequence_params *params,
                           weft_image_sequence **out);

// So many more names follow those that there were, also after the last frame was handed out: its
// processes go on with them. For what is given out a few files at a time. Returns WEFT_ERR_ARGUMENT
// (count < 1, or more names in all than numbers).
WEFT_API enum weft_result weft_image_sequence_extend(weft_image_sequence *sequence, int64_t count);

// Ends the readers, and the last frame with them. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_image_sequence_destroy(weft_image_sequence **sequence);

// Hands out the next frame, in the order of the names whatever is decoded first; *frame is NULL
// after the last one. What makes a single file unreadable is told in its frame alone, not in the
// log. Returns WEFT_ERR_CANCELLED (stop said so: the next call waits for the same frame),
// WEFT_ERR_READER (a reader program is missing) or WEFT_ERR_MEMORY; after the last two nothing more
// can be had.
WEFT_API enum weft_result weft_image_sequence_next(weft_image_sequence *sequence,
                                                   const struct weft_image_frame **frame);

WEFT_END_DECLS
#endif
