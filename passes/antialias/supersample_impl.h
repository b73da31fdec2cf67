// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/supersample_impl.h - what supersampling is made of (not installed): one target
// that moved pictures are drawn into, lists of the pixels that count, and passes over these lists.
// Functions that take a weft_supersample and no context of their own count on its context being
// current.
#ifndef WEFT_PASSES_ANTIALIAS_SUPERSAMPLE_IMPL_H
#define WEFT_PASSES_ANTIALIAS_SUPERSAMPLE_IMPL_H

#include "passes/antialias/drawing/run.h"
#include "passes/antialias/supersample.h"
#include "passes/gl/target.h"

// A sample that counts, and what it gives to a pixel from the pixels around it: weight[y * columns
// + x] times the sample of the pixel (first[0] + x, first[1] + y) further right and up. Over all
// samples these are the filter's weights times the number of samples that count, so that a picture
// is their plain mean; of a box all are 1.
struct weft_supersample_sample {
    double position[2]; // x to the right, y down the rows
    int first[2], columns, rows;
    float *weight; // in the supersample's
};

// Pixels of the scratch target in the order of a compact one, row by row. Where the last row has
// room left, the last pixel fills it.
struct weft_pixel_list {
    int64_t count;
    int32_t width, height; // of the compact target
    uint16_t (*at)[2];     // [y][x]; NULL: all pixels of the part, in its own order
    GLuint texture;        // the same, RG16UI; 0 likewise
};

struct weft_supersample {
    struct weft_supersample_params params; // without position
    struct weft_supersample_sample sample[WEFT_PATTERN_MAX];
    int used; // samples that count
    float *weight;
    int radius;
    double magnitude;   // of all weights
    int largest_window; // of all samples, in pixels
    bool copies;        // a picture's frames are samples as they are
    double discrepancy;

    struct weft_gl_target scratch; // of the picture with a rim of radius
    struct weft_depth_buffer depth;
    GLfloat background[4]; // as the format keeps it

    // Of the last picture.
    struct weft_rectangle part;     // that was asked for
    struct weft_rectangle window;   // of the scratch, that it takes: with the radius around it
    struct weft_pixel_list result;  // pixels that are supersampled
    struct weft_pixel_list sampled; // that are drawn; of sums no more than their count
    bool masked;                    // some are not drawn
    struct weft_marks mask;         // of the window: those that are, until the stencil has them
    struct weft_gl_target compact;  // a frame of the sums
    GLuint blocks, pointers;        // a layer a sample; where a pixel of the window is in them
    GLuint framebuffer;             // that draws into a layer
    void *picked, *band;            // pixels of the result, and rows of the scratch, in memory
    weft_accumulator *sums;
    bool drawn;
};

// ---- supersample_lists.c ------------------------------------------------------------------------

// Finds which pixels of the part count and which have to be drawn. Returns WEFT_ERR_MEMORY.
enum weft_result weft_supersample_list(weft_supersample *s, const struct weft_marks *marks);
void weft_pixel_list_clear(const GladGLContext *gl, struct weft_pixel_list *list);
// Makes a texture of places. Returns WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_places_load(const struct weft_log *log, const GladGLContext *gl,
                                  int32_t width, int32_t height, const uint16_t (*at)[2],
                                  GLuint *out);

// ---- supersample_scratch.c ----------------------------------------------------------------------

// Targets of the size that the params and the radius say. Returns WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_supersample_make_scratch(weft_supersample *s);
void weft_supersample_destroy_scratch(weft_supersample *s);
// Sets the stencil to 1 where pixels are to be drawn, and to 0 elsewhere; the mask has done then.
enum weft_result weft_supersample_mask(weft_supersample *s);
// Draws the picture of a sample.
enum weft_result weft_supersample_draw(weft_supersample *s,
                                       const struct weft_antialias_drawing *drawing, int index);

// ---- supersample_gather.c -----------------------------------------------------------------------

// Makes what the lists' pixels go into.
enum weft_result weft_supersample_make_compact(weft_supersample *s);
void weft_supersample_destroy_compact(weft_supersample *s);
// Keeps a sample's picture in its layer of the blocks.
enum weft_result weft_supersample_keep(weft_supersample *s, int index);
// A frame of a sample, from the scratch or from the blocks: *texture is the frame.
enum weft_result weft_supersample_gather(weft_supersample *s, int index, GLuint *texture);

// ---- supersample_pick.c -------------------------------------------------------------------------

// Whether frames are picked from memory: the list and the params tell.
bool weft_supersample_picks(const weft_supersample *s);
uint64_t weft_supersample_pick_bytes(const weft_supersample *s); // of memory; 0: it does not
enum weft_result weft_supersample_make_picked(weft_supersample *s);
void weft_supersample_destroy_picked(weft_supersample *s);
// A frame of the sample that was drawn last, as planes that are good until the next one.
enum weft_result weft_supersample_pick(weft_supersample *s, struct weft_plane planes[4]);

GLenum weft_supersample_format(const weft_supersample *s); // of the scratch
uint64_t weft_supersample_gl_bytes(const weft_supersample *s);

#endif
