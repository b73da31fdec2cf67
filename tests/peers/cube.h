// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/cube.h - the frames that accumulation is measured with: the RGB colour cube, turned a
// little further from frame to frame, drawn on GL with a depth test.
#ifndef WEFT_TESTS_PEERS_CUBE_H
#define WEFT_TESTS_PEERS_CUBE_H

#include "passes/accumulate/accumulate.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/target.h"

struct cube {
    weft_context *context;
    const GladGLContext *gl;
    GLuint program;
    bool turns; // otherwise all frames are alike
};

// Links the program. false after a line on stderr.
bool cube_create(weft_context *context, bool turns, struct cube *out);

// As a frame's `draw`: priv is the cube, the context is current, the target is cleared.
enum weft_result cube_draw(void *cube, int64_t index, const struct weft_draw_target *target);

// A target as accumulators have them for frames that are drawn: RGBA8 and a depth of 24 bits.
struct cube_target {
    struct weft_gl_target colour;
    GLuint depth;
    struct weft_draw_target drawn;
};
bool cube_target_create(const struct cube *cube, int width, int height, struct cube_target *out);
void cube_target_destroy(const struct cube *cube, struct cube_target *target);

// Clears, and draws frame `index`; the context is current.
void cube_target_draw(const struct cube *cube, const struct cube_target *target, int64_t index);

// Frame 0 as codes [y][x][4], row 0 on top; to be freed. NULL after a line on stderr.
uint8_t *cube_codes(const struct cube *cube, int width, int height);

#endif
