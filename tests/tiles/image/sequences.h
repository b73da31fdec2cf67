// SPDX-License-Identifier: BSD-3-Clause
// tests/tiles/image/sequences.h - what tests of sequences share. Include after cmocka.h and
// files.h.
#ifndef WEFT_TESTS_TILES_IMAGE_SEQUENCES_H
#define WEFT_TESTS_TILES_IMAGE_SEQUENCES_H

#include <ctype.h>

#include "tiles/image/sequence.h"

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, test_enter_folder, test_leave_folder)

struct names {
    const char *const *name;
    int64_t asked; // so far: each once, in their order
    bool stop;
};

static inline const char *name_of(void *priv, int64_t i)
{
    struct names *names = priv;
    assert_int_equal(i, names->asked);
    names->asked++;
    return names->name[i];
}

static inline weft_image_sequence *begin(struct names *names, int count, int readers)
{
    weft_image_sequence *sequence = NULL;
    test_forget();
    assert_int_equal(weft_image_sequence_create(
                         weft_image_sequence_params(.count = count, .name = name_of, .priv = names,
                                                    .readers = readers, .log = &test_log),
                         &sequence),
                     WEFT_OK);
    return sequence;
}

static inline void next_frame(weft_image_sequence *sequence, int64_t index,
                              const struct weft_image_frame **frame)
{
    const enum weft_result res = weft_image_sequence_next(sequence, frame);
    if (res != WEFT_OK || !*frame)
        fail_msg("frame %lld: %s, %s", (long long)index, weft_result_text(res), test_message);
    assert_int_equal((*frame)->index, index);
}

static inline const struct weft_image_frame *good_frame(weft_image_sequence *sequence,
                                                        int64_t index)
{
    const struct weft_image_frame *frame;
    next_frame(sequence, index, &frame);
    if (frame->result != WEFT_OK)
        fail_msg("%s", frame->message);
    assert_string_equal(frame->message, "");
    return frame;
}

// Returns its message, which names it.
static inline const char *bad_frame(weft_image_sequence *sequence, int64_t index,
                                    enum weft_result result)
{
    const struct weft_image_frame *frame;
    next_frame(sequence, index, &frame);
    if (frame->result != result)
        fail_msg("%s: %s instead of %s: %s", frame->name, weft_result_text(frame->result),
                 weft_result_text(result), frame->message);
    assert_non_null(strstr(frame->message, frame->name));
    assert_null(strchr(frame->message, '\n'));
    return frame->message;
}

// Nothing follows, and nothing was logged.
static inline void finish(weft_image_sequence **sequence)
{
    const struct weft_image_frame *frame = NULL;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(weft_image_sequence_next(*sequence, &frame), WEFT_OK);
        assert_null(frame);
    }
    weft_image_sequence_destroy(sequence);
    assert_null(*sequence);
    assert_string_equal(test_message, "");
}

// The processes that are children of this one; the last one in *pid where that is given.
static inline int children(pid_t *pid)
{
    int count = 0;
    DIR *folder = opendir("/proc");
    for (struct dirent *e; folder && (e = readdir(folder));) {
        char path[300], line[512];
        int parent = 0;
        snprintf(path, sizeof path, "/proc/%s/stat", e->d_name);
        FILE *f = isdigit((unsigned char)*e->d_name) ? fopen(path, "r") : NULL;
        const char *end = f && fgets(line, sizeof line, f) ? strrchr(line, ')') : NULL;
        if (f)
            fclose(f);
        if (!end || sscanf(end + 1, " %*c %d", &parent) != 1 || parent != (int)getpid())
            continue;
        count++;
        if (pid)
            *pid = atoi(e->d_name);
    }
    if (folder)
        closedir(folder);
    return count;
}

static inline int count_children(void)
{
    return children(NULL);
}

#endif
