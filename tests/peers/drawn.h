// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/drawn.h - scenes whose frames a bench or a figure draws and averages.
#ifndef WEFT_TESTS_PEERS_DRAWN_H
#define WEFT_TESTS_PEERS_DRAWN_H

#include "tools/effect/run.h"

enum { DRAWN_CHANNELS = 4, DRAWN_SCENES = 2 };

// Scenes on a context. All zero: none.
struct drawn {
    weft_context *context; // borrowed
    int size[2];
    struct scene scene[DRAWN_SCENES];
    scene_drawing *drawing[DRAWN_SCENES];
    int count;
};

extern const struct weft_log drawn_log; // warnings and errors, to stderr

// The scenes that show an effect (EFFECT_FADE: two of them), or one by its name. To be cleared in
// any case. false, after a line: it failed.
bool drawn_create(weft_context *context, unsigned effect, const char *name, const int size[2],
                  int shadow_size, struct drawn *out);
void drawn_clear(struct drawn *drawn);

// Plans frames of the scenes: of `asked` scenes and size are filled in.
enum weft_result drawn_plan(const struct drawn *drawn, struct effect_params asked,
                            struct effect_plan *out);

// Draws all frames and averages them by `how`, of which size, channels, weights and context are
// filled in. out: 4 planes, rows upwards; report: NULL where nobody asks.
enum weft_result drawn_average(const struct drawn *drawn, const struct effect_plan *plan,
                               struct weft_accumulator_params how, float *out,
                               struct weft_accumulator_report *report);

// By exact sums of floats.
enum weft_result drawn_average_exactly(const struct drawn *drawn, const struct effect_plan *plan,
                                       float *out);

// How far two pictures are apart, over R, G and B. A NaN in either counts as INFINITY.
struct drawn_error {
    double largest, rms;
};
struct drawn_error drawn_compare(const struct drawn *drawn, const float *a, const float *b);

#endif
