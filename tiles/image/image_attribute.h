// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_attribute.h - attributes as an EXR header holds them (not installed).
// A header is a sequence of name 0 type 0 size:int32 data[size], ended by an empty name.
#ifndef WEFT_TILES_IMAGE_IMAGE_ATTRIBUTE_H
#define WEFT_TILES_IMAGE_IMAGE_ATTRIBUTE_H

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

enum { WEFT_ATTRIBUTE_NAME_MAX = 255 };

enum weft_attribute_step { WEFT_ATTRIBUTE_TAKEN, WEFT_ATTRIBUTE_END, WEFT_ATTRIBUTE_BROKEN };

// Takes the attribute at header[*at], or the header's end, and moves *at behind it. *out points
// into the header. BROKEN: it reaches beyond size, or a text is longer than the format has it.
enum weft_attribute_step weft_attribute_next(const unsigned char *header, size_t size, size_t *at,
                                             struct weft_image_attribute *out);

// Whether struct weft_image says in other members what an attribute of that name does, or it is
// about the file's layout.
bool weft_attribute_is_structure(const char *name);

WEFT_END_DECLS
#endif
