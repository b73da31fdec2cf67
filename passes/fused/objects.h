// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/objects.h - what GL holds while a slice is run: made for one, or kept from one to
// the next (not installed).
#ifndef WEFT_PASSES_FUSED_OBJECTS_H
#define WEFT_PASSES_FUSED_OBJECTS_H

#include "passes/fused/plan.h"
#include "passes/gl/target.h"
#include "tiles/volume/layout.h"

// {0} is nothing.
struct weft_fused_objects {
    struct weft_gl_buffer source; // blocks of the slice's own
    struct weft_gl_buffer entries, constants, kernel[WEFT_LINE_ORDERS];
    struct weft_gl_target target; // of values alone
    struct weft_gl_target targets[WEFT_FUSED_TARGETS];
};

// What they have to be at least. 0 texels: a buffer that is not needed.
struct weft_fused_sizes {
    GLenum source_format;
    size_t source_texels, entries, constants;
    int width, height; // pixels of the targets
    int targets;       // of four outputs each; 0: of values alone
};

// Makes what is missing or too small. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_fused_objects_fit(const struct weft_log *log, const GladGLContext *gl,
                                        const struct weft_fused_sizes *sizes,
                                        struct weft_fused_objects *objects);
void weft_fused_objects_destroy(const GladGLContext *gl, struct weft_fused_objects *objects);

// The texels of blocks of this format and layout.
GLenum weft_fused_source_format(enum weft_source_format format, enum weft_layout layout);

#endif
