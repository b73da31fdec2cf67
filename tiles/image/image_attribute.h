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

// The value of a "float"; false where it is none or NULL.
bool weft_attribute_float(const struct weft_image_attribute *attribute, float *out);

// Of the bytes of an ICC profile, which images from PNG and TIFF files have, of type "icc".
#define WEFT_ATTRIBUTE_ICC "ICCProfile"

// What PNG calls the text of an attribute ("comments": "Description"), and the reverse; names that
// differ in nothing are returned as they are.
const char *weft_attribute_png_name(const char *name);
const char *weft_attribute_of_png(const char *keyword);

// A header that is made. Starts as {0}; whoever makes it frees data.
struct weft_attribute_list {
    unsigned char *data;
    size_t size, room;
    bool failed; // there was no memory
};
// Adds an attribute; "name" is the part's. One that has no name, too long a name, the name of one
// that is there, or over 2^31 - 1 bytes is left out.
void weft_attribute_add(struct weft_attribute_list *list, const char *name, const char *type,
                        const void *data, size_t size);
void weft_attribute_add_float(struct weft_attribute_list *list, const char *name, float value);
// Ends the header. Returns false where there was no memory for it.
bool weft_attribute_end(struct weft_attribute_list *list);

WEFT_END_DECLS
#endif
