// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/drawing/drawing.h - how an application draws its scene for anti-aliasing: a
// callback that is called once for each pass, and a head for each fragment shader, which says what
// becomes of the fragments.
//
// A fragment shader's text has no #version and no `out` of its own. It is compiled as two strings,
// pass->head and the text, which ends with
//     weft_write(colour, surface);     // void weft_write(vec4 colour, uint surface)
// colour: linear light, of opaque surfaces (alpha 1); surface: any number but 0 that neighbouring
// triangles share where no edge is to be smoothed between them, and others do not. Inputs are read
// as WEFT_AT(name), so that a pixel has one colour wherever its samples are: forms that shade once
// a sample take them in the pixel's middle, too. The vertex shader is one object, shared by all
// programs, declares `invariant gl_Position`, and multiplies by pass->place.
#ifndef WEFT_PASSES_ANTIALIAS_DRAWING_DRAWING_H
#define WEFT_PASSES_ANTIALIAS_DRAWING_DRAWING_H

#include "../../../filter/rectangle.h"
#include "../../gl/context.h"

WEFT_BEGIN_DECLS

// What a pass draws.
enum weft_antialias_stage {
    // Every triangle that is seen in the picture, for its depth alone: with the head, or any
    // fragment shader without outputs. What is cut out (alpha tests) is discarded here.
    WEFT_STAGE_DEPTH,
    // The same triangles with their colours. No discarding, no depth of one's own: the depth pass
    // has decided.
    WEFT_STAGE_COLOUR,
    // The lines along which a picture can have an edge, those that are hidden too, and their ends
    // as points. Polygons are drawn as their outlines and corners, so that an application may draw
    // its triangles again; one that knows which edges do not show (within smooth surfaces) draws
    // GL_LINES and GL_POINTS.
    WEFT_STAGE_LINES,
    WEFT_STAGE_POINTS,
    WEFT_STAGE_COUNT
};

// One call of the callback.
struct weft_antialias_pass {
    enum weft_antialias_stage stage;
    int index, count;      // of this pass, and how many there will be in all; 0: not known yet
    unsigned framebuffer;  // bound for drawing, with the viewport set
    int32_t width, height; // of the framebuffer: the picture with a rim where filters reach beyond
    // Of the framebuffer, rows upwards, what counts: all of it, or the part that is drawn with what
    // filters and neighbours reach. The scissor is set to it. Objects of which no pixel's middle or
    // sample can be within it, be it by an edge that is drawn wider, may be left out; all others
    // are drawn in the order in which they are for the whole.
    struct weft_rectangle part;
    // Clip coordinates are to be multiplied by it from the left, in the application's matrix
    // (place * projection * view), column by column: it moves the picture by parts of a pixel, and
    // makes room for the rim.
    double place[16];
    // The fragment shader's first string, with #version. It lives as long as what calls. The same
    // text may come at other addresses: programs are told apart by the text.
    const char *head;
};

// How a scene is drawn, and what of the picture. The callback finds the context current, weft's own
// vertex array bound, and GL's default state but for the viewport, the scissor, tests of depth and
// stencil, masks, polygon mode and offset, samples, blending, image units 5 to 7 and binding 35 of
// uniform buffers: those it leaves alone, as well as queries and transform feedback. It may set all
// else (programs, vertex arrays, texture units 0 to 15, culling), and calls nothing of weft with
// this context but weft_context_find_function. Passes of one picture draw the same scene: what they
// have in common (shadow maps) is made before. Anything but WEFT_OK ends the work, which returns
// it; an error of GL is WEFT_ERR_GL.
struct weft_antialias_drawing {
    enum weft_result (*draw)(void *priv, const struct weft_antialias_pass *pass);
    void *priv;
    // Of the picture, rows upwards (all 0, default: all of it). What is drawn, added up and read
    // back are these pixels, which have the bytes that they have in the whole picture: vertices and
    // viewport are the whole picture's, and pixels of the part are cut out by the scissor.
    struct weft_rectangle part;
};

WEFT_END_DECLS
#endif
