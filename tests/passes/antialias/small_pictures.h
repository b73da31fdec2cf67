// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/antialias/small_pictures.h - small pictures by accumulative anti-aliasing, to
// compare. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_ANTIALIAS_SMALL_PICTURES_H
#define WEFT_TESTS_PASSES_ANTIALIAS_SMALL_PICTURES_H

#include <string.h>

#include "tests/support/common.h"
#include "tests/passes/antialias/samples.h"
#include "passes/antialias/accumulative.h"
#include "passes/antialias/drawing/run.h"

enum { WIDTH = 24, HEIGHT = 18, PIXELS = WIDTH * HEIGHT, TRIANGLES = 24, VERTICES = 3 * TRIANGLES };
static const int size[2] = {WIDTH, HEIGHT};
static const double background[4] = {0.25, 0.0, 0.75, 0.5};

typedef float picture[4][PIXELS];

static inline weft_acaa *create_acaa(weft_context *context, struct weft_acaa_params params)
{
    weft_acaa *acaa;
    params.width = WIDTH;
    params.height = HEIGHT;
    memcpy(params.background, background, sizeof background);
    params.context = context;
    params.log = &log_to_stderr;
    assert_int_equal(weft_acaa_create(&params, &acaa), WEFT_OK);
    return acaa;
}

static inline void run_acaa(weft_acaa *acaa, struct triangles *t, picture out)
{
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(t), NULL), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_acaa_read(acaa, c, out[c], 0), WEFT_OK);
}

// NAN stays.
static inline double pixel_distance(const picture a, const picture b, int i)
{
    double largest = 0.0;
    for (int c = 0; c < 4; c++)
        largest = larger(largest, fabs((double)a[c][i] - (double)b[c][i]));
    return largest;
}

static inline double distance(const picture a, const picture b)
{
    double largest = 0.0;
    for (int i = 0; i < PIXELS; i++)
        largest = larger(largest, pixel_distance(a, b, i));
    return largest;
}

// Pixels that are neither of surfaces alone nor background.
static inline int count_mixed(const picture p)
{
    int mixed = 0;
    for (int i = 0; i < PIXELS; i++)
        mixed += p[3][i] > 0.5f && p[3][i] < 1.0f;
    return mixed;
}

static inline bool has_forms(const weft_context *context)
{
    return context && context->gl.VERSION_4_2 &&
           weft_drawing_has_extension(&context->gl, "GL_ARB_post_depth_coverage");
}

// Whether it is there and has all forms.
static inline bool enter_and_ask(weft_context *context)
{
    if (!context || weft_context_enter(context) != WEFT_OK)
        return false;
    const bool has = has_forms(context);
    weft_context_leave(context);
    return has;
}

#endif
