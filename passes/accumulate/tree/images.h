// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/tree/images.h - the images of a stack of parts: textures of GL, or the same in
// memory, where integers and floats do what the shaders do, bit for bit (not installed).
//
// An image has groups of four channels, interleaved: codes of 8 or 16 bits, or floats. A node draws
// into an image that is none of its inputs, so one more is alive than there are parts: the paper's
// colour buffer. Images are given back, and used again.
#ifndef WEFT_PASSES_ACCUMULATE_TREE_IMAGES_H
#define WEFT_PASSES_ACCUMULATE_TREE_IMAGES_H

#include "passes/accumulate/tree/stack.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/target.h"
#include "tiles/image/plane.h"

WEFT_BEGIN_DECLS

enum {
    WEFT_TREE_GROUP = 4,                            // channels of a texel
    WEFT_TREE_MAX_IMAGES = WEFT_TREE_MAX_PARTS + 3, // a scratch, and two to look at what is so far
};

// What comes into the images: v as it is in floats; in codes floor(t one + 1/2), clamped, with
// t = v, or t = (v - low) * scale if `ranged`; each operation in single precision.
struct weft_tree_images_params {
    int32_t width, height;
    int groups;
    int bits; // 8 or 16: codes; 32: floats
    bool ranged;
    float low, scale;
    int threads;           // of what is done in memory
    weft_context *context; // NULL: in memory
    const struct weft_log *log;
};

struct weft_tree_image {
    struct weft_gl_target *targets; // of each group
    void *texels;                   // or these, group after group, row after row
    bool used;
};

struct weft_tree_program;

struct weft_tree_images {
    struct weft_tree_images_params params;
    uint32_t one;      // the largest code; 0: floats
    size_t texel_size; // bytes
    size_t group_size; // bytes of a group of an image
    struct weft_tree_image image[WEFT_TREE_MAX_IMAGES];
    int alive, most; // that exist, used or not, now and at most so far
    uint64_t passes; // that were drawn
    struct weft_tree_program *programs;
};

// The context is current in all of these, if there is one. Those that fail have logged one line,
// and return WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_tree_images_create(const struct weft_tree_images_params *params,
                                         struct weft_tree_images **out);
void weft_tree_images_destroy(struct weft_tree_images **images); // accepts &NULL

// Another image, of undefined content, for as long as it is not given back.
enum weft_result weft_tree_images_take(struct weft_tree_images *images, int *out);
void weft_tree_images_give(struct weft_tree_images *images, int image);

// Makes an image of the inputs. `out` is none of them.
enum weft_result weft_tree_images_combine(struct weft_tree_images *images, const int *inputs,
                                          const struct weft_tree_node *node, int out);

// A group of a frame from a texture, and in memory a row of it from texels of four values of
// `type`: float, half, unorm8 or unorm16.
enum weft_result weft_tree_images_load(struct weft_tree_images *images, int image, int group,
                                       const struct weft_gl_target *texture);
void weft_tree_images_load_row(struct weft_tree_images *images, int image, int group, int32_t y,
                               enum weft_plane_type type, const void *texels);

// A group of an image as it is: group_size bytes of codes or floats, and back.
enum weft_result weft_tree_images_read(struct weft_tree_images *images, int image, int group,
                                       void *out);
enum weft_result weft_tree_images_write(struct weft_tree_images *images, int image, int group,
                                        const void *texels);

// ---- what GL does of these (images_gl.c) --------------------------------------------------------

enum weft_result weft_tree_gl_create(struct weft_tree_images *images);
void weft_tree_gl_destroy(struct weft_tree_images *images);
enum weft_result weft_tree_gl_combine(struct weft_tree_images *images, const int *inputs,
                                      const struct weft_tree_node *node, int out);
enum weft_result weft_tree_gl_load(struct weft_tree_images *images,
                                   const struct weft_gl_target *out,
                                   const struct weft_gl_target *texture);

WEFT_END_DECLS
#endif
