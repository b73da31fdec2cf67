// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/antialias/pictures.h - pictures by accumulative anti-aliasing, in memory, for tests.
// Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_ANTIALIAS_PICTURES_H
#define WEFT_TESTS_PASSES_ANTIALIAS_PICTURES_H

#include <stdlib.h>

#include "passes/antialias/accumulative.h"
#include "tests/passes/antialias/samples.h"
#include "tests/support/common.h"

enum { PICTURE_PIXELS = 333 * 17 };

struct picture {
    float channel[4][PICTURE_PIXELS], weight[PICTURE_PIXELS];
    struct weft_acaa_report report;
};

static const double identity_place[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double grey[4] = {0.3, 0.1, 0.7, 0.25};

// The forms that must be equal in every byte.
static const enum weft_acaa_form exact_forms[2] = {WEFT_ACAA_POST_DEPTH, WEFT_ACAA_SAMPLE_ID};

static inline bool has_exact_forms(const weft_context *context)
{
    return context->gl.VERSION_4_2;
}

// Draws the next picture of an object.
static inline void picture_next(weft_acaa *acaa, struct triangles *triangles, struct picture *out)
{
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_acaa_read(acaa, c, out->channel[c], 0), WEFT_OK);
    assert_int_equal(weft_acaa_read_weight(acaa, out->weight, 0), WEFT_OK);
    weft_acaa_get_report(acaa, &out->report);
}

// Draws one picture with an object of its own, in the context of the triangles.
static inline void picture_draw(struct triangles *triangles, const struct weft_acaa_params *params,
                                struct picture *out)
{
    struct weft_acaa_params p = *params;
    weft_acaa *acaa;
    p.context = triangles->context;
    p.log = &log_to_stderr;
    assert_true(p.width * p.height <= PICTURE_PIXELS);
    assert_int_equal(weft_acaa_create(&p, &acaa), WEFT_OK);
    picture_next(acaa, triangles, out);
    weft_acaa_destroy(&acaa);
}

// Every weight is the total.
static inline void picture_check_weights(const struct picture *picture, int pixels)
{
    if (picture->report.less || picture->report.more)
        fail_msg("%d weights less, first at (%d, %d); %d more, first at (%d, %d)",
                 (int)picture->report.less, picture->report.first_less[0],
                 picture->report.first_less[1], (int)picture->report.more,
                 picture->report.first_more[0], picture->report.first_more[1]);
    assert_true(picture->report.largest == 0.0);
    assert_int_equal(picture->report.first_less[0], -1);
    for (int i = 0; i < pixels; i++)
        assert_true(picture->weight[i] == 1.0f);
}

static inline void picture_check_value(const struct picture *picture, int channel, int x, int y,
                                       int width, float expected)
{
    const float actual = picture->channel[channel][y * width + x];
    if (!(actual == expected))
        fail_msg("channel %d at (%d, %d): %.9g instead of %.9g", channel, x, y, (double)actual,
                 (double)expected);
}

#endif
