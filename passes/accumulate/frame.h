// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/frame.h - frames of all kinds as planes in memory or as textures (not
// installed). What is made for a frame is kept for the next one, and belongs to the accumulator.
#ifndef WEFT_PASSES_ACCUMULATE_FRAME_H
#define WEFT_PASSES_ACCUMULATE_FRAME_H

#include "passes/accumulate/accumulate_impl.h"
#include "passes/gl/target.h"

WEFT_BEGIN_DECLS

// Channels that go through GL together, in one texture.
enum { WEFT_FRAME_GROUP = 4 };
static inline int weft_frame_groups(const weft_accumulator *a)
{
    return (a->params.channel_count + WEFT_FRAME_GROUP - 1) / WEFT_FRAME_GROUP;
}
// Of targets of so many bits: 8, 16, 32 or WEFT_ACCUMULATE_HALF.
static inline GLenum weft_frame_format(int bits)
{
    return bits == 8 ? GL_RGBA8 : bits == 16 ? GL_RGBA16 : bits == 32 ? GL_RGBA32F : GL_RGBA16F;
}

// Another frame comes: what was made of the one before is no longer good.
void weft_frame_begin(weft_accumulator *a);

// The frame as one plane a channel, valid until the next frame: its own, or textures and drawings
// read back, in the type of their texels. The context is not current. A frame is drawn once,
// whichever of these functions is called first. Returns WEFT_ERR_ARGUMENT (a texture that is none,
// of another size or format), what `draw` returned, WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_frame_planes(weft_accumulator *a, const struct weft_frame *frame,
                                   const struct weft_plane **out);

// The frame as one texture for each group of channels, fetched by texel, valid until the next
// frame: its own texture, what it draws, or planes that are uploaded: RGBA8, RGBA16, RGBA16F or
// RGBA32F, the smallest that holds the types of the group's planes exactly (integers: to 2^24, and
// codes beside floats: rounded once), channels that are none being 0. Of the caller's texture,
// framebuffer is 0. What was drawn has the format of params.frame_bits. The context is current;
// state of GL that weft's passes count on is as they do, also after a callback. Returns as
// weft_frame_planes does.
enum weft_result weft_frame_textures(weft_accumulator *a, const struct weft_frame *frame,
                                     const struct weft_gl_target **out);

// Draws a frame that is drawn straight into a target of the accumulator's size. Only where nothing
// was made of the frame yet: nobody looks at frames before they are added (a->scan is NULL). The
// context is current. Returns what `draw` returned, WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_frame_draw(weft_accumulator *a, const struct weft_frame *frame,
                                 const struct weft_gl_target *target);

// Exchanges what planes were uploaded into, of one group, with a target of the same size and
// format, so that it need not be copied. The context is current, and weft_frame_textures was
// called.
void weft_frame_swap(weft_accumulator *a, int group, struct weft_gl_target *target);

uint64_t weft_frame_bytes(const weft_accumulator *a); // of what is kept for frames

// ---- rows of texels -----------------------------------------------------------------------------

// The smallest of unorm8, unorm16, half and float that holds the types of `count` planes.
enum weft_plane_type weft_frame_common_type(const struct weft_plane *planes, int count);
// Row y of 1 to WEFT_FRAME_GROUP planes as texels of WEFT_FRAME_GROUP values of their common type;
// what has no plane is 0.
void weft_frame_pack_row(const struct weft_plane *planes, int count, enum weft_plane_type type,
                         int32_t y, int32_t width, void *out);

void weft_frame_source_destroy(weft_accumulator *a); // the context is not current

WEFT_END_DECLS
#endif
