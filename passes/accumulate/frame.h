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

// The frame as one plane a channel, valid until the next frame: its own, or textures and drawings
// read back (as unorm8, unorm16 or floats, as their texels are). The context
// is not current. A frame is drawn once, whichever of the two is asked for first.
enum weft_result weft_frame_planes(weft_accumulator *a, const struct weft_frame *frame,
                                   const struct weft_plane **out);

// The frame as one texture for each group of channels, fetched by texel, valid until the next
// frame: its own texture, what it draws, or planes that are uploaded: RGBA8, RGBA16, RGBA16F or
// RGBA32F, the smallest that holds the planes' types exactly. The context is current.
enum weft_result weft_frame_textures(weft_accumulator *a, const struct weft_frame *frame,
                                     const GLuint **out);

// Row y of a plane as floats, exactly but for uint beyond 2^24; codes as code / largest code
// rounded once.
void weft_frame_row(const struct weft_plane *plane, int32_t y, int32_t width, float *out);

void weft_frame_source_destroy(weft_accumulator *a); // the context is current where there is one

WEFT_END_DECLS
#endif
