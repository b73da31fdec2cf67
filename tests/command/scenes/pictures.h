// SPDX-License-Identifier: BSD-3-Clause
// tests/command/scenes/pictures.h - the pictures that verbs of scenes write, as tests look at them.
#ifndef WEFT_TESTS_COMMAND_SCENES_PICTURES_H
#define WEFT_TESTS_COMMAND_SCENES_PICTURES_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include <cmocka.h>
#include <png.h>

#include "tests/support/command.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

enum { WIDTH = 48, HEIGHT = 32, PIXELS = WIDTH * HEIGHT };
#define SIZE "--size", "48x32"

static const char *const channel_names[] = {"R", "G", "B", "A", NULL};

static inline void put(const char *path, const char *text)
{
    command_write_file(path, text, strlen(text));
}

static inline const float *plane_of(const struct weft_image *image, const char *name)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (strcmp(image->channels[c].name, name) == 0)
            return image->channels[c].plane;
    fail_msg("no channel %s", name);
    return NULL;
}

// To be cleared.
static inline void load(const char *path, struct weft_image *out)
{
    assert_int_equal(weft_image_load(weft_image_load_params(.path = path), out), WEFT_OK);
    assert_int_equal(out->channel_count, 4);
}

static inline const char *attribute(const struct weft_image *image, const char *name,
                                    char text[300])
{
    const struct weft_image_attribute *a = weft_image_find(image, name);
    if (!a)
        fail_msg("no attribute %s", name);
    weft_image_attribute_format(a, text, 300);
    return text;
}

static inline void assert_same_bytes(const char *a, const char *b, bool same)
{
    size_t size[2];
    char *bytes[2] = {command_read_file(a, &size[0]), command_read_file(b, &size[1])};
    const bool equal = size[0] == size[1] && memcmp(bytes[0], bytes[1], size[0]) == 0;
    if (equal != same)
        fail_msg("%s and %s are %s", a, b, equal ? "the same" : "not the same");
    free(bytes[0]);
    free(bytes[1]);
}

// The code of IEC 61966-2-1, in double precision; both neighbours where it is on an edge.
static inline bool is_code_of(double light, int code)
{
    const double v = fmin(fmax(light, 0.0), 1.0);
    const double srgb = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
    return fabs(255.0 * srgb - code) <= 0.5 + 1e-4;
}

// Reads a PNG file of WIDTH x HEIGHT pixels.
static inline void load_codes(const char *path, png_uint_32 format, png_byte *codes)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, path));
    assert_int_equal(png.width, WIDTH);
    assert_int_equal(png.height, HEIGHT);
    png.format = format;
    assert_true(png_image_finish_read(&png, NULL, codes, 0, NULL));
}

static inline void check_preview(const char *path, const struct weft_image *image)
{
    static png_byte codes[3 * PIXELS];
    load_codes(path, PNG_FORMAT_RGB, codes);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < PIXELS; i++)
            if (!is_code_of((double)plane_of(image, channel_names[c])[i], codes[3 * i + c]))
                fail_msg("%s: %s of pixel %d: code %d of %g", path, channel_names[c], i,
                         codes[3 * i + c], (double)plane_of(image, channel_names[c])[i]);
}

// That all is finite, there is something to be seen, and coverage is a share.
static inline void check_values(const char *what, const struct weft_image *image)
{
    double least = INFINITY, most = -INFINITY;
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < PIXELS; i++) {
            const double v = (double)plane_of(image, channel_names[c])[i];
            if (!isfinite(v) || v < -1e-6 || (c == 3 && v > 1.0 + 1e-6))
                fail_msg("%s: %s of pixel %d is %g", what, channel_names[c], i, v);
            least = c < 3 ? fmin(least, v) : least;
            most = c < 3 ? fmax(most, v) : most;
        }
    if (!(most > least + 0.05))
        fail_msg("%s shows nothing: from %g to %g", what, least, most);
}

// Of scene plane: the sky is blue, and above.
static inline void check_sky(const char *path)
{
    struct weft_image image;
    double blueness[2] = {0.0, 0.0};
    load(path, &image);
    for (int x = 0; x < WIDTH; x++)
        for (int end = 0; end < 2; end++) {
            const int at = x + end * (HEIGHT - 1) * WIDTH;
            blueness[end] += (double)(plane_of(&image, "B")[at] - plane_of(&image, "R")[at]);
        }
    assert_true(blueness[0] > 0.1 * WIDTH);
    assert_true(blueness[1] < 0.02 * WIDTH);
    weft_image_clear(&image);
}

// Sends a signal to weft, which dies of it soon and leaves nothing behind.
static inline void assert_dies(pid_t pid, int signal)
{
    int status, before = command_folder_size();
    const double seconds = command_signal(pid, signal, &status);
    if (!WIFSIGNALED(status) || WTERMSIG(status) != signal || seconds > 2.0)
        fail_msg("signal %d: status %x after %.2f s", signal, (unsigned)status, seconds);
    assert_int_equal(command_folder_size(), before);
}

// Nothing is drawn without OpenGL.
static inline int set_up(void **state)
{
    const int failed = command_setup_folder(state);
    if (failed || command_has_gl())
        return failed;
    command_teardown(state);
    exit(77);
}

#endif
