// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/buffer_impl.h - what the method needs of accumulation buffers beside OpenGL's
// operations (not installed).
#ifndef WEFT_PASSES_ACCUMULATE_BUFFER_IMPL_H
#define WEFT_PASSES_ACCUMULATE_BUFFER_IMPL_H

#include "passes/accumulate/buffer.h"

WEFT_BEGIN_DECLS

struct weft_value_range; // values.h

// weft_accum_buffer_accum of where the values lie in a range (may be NULL: of the values).
enum weft_result weft_accum_buffer_accum_within(weft_accum_buffer *buffer,
                                                const struct weft_plane *planes,
                                                const struct weft_value_range *range, double value);

// All that a buffer holds, to be saved and loaded; channel after channel, int16_t or float.
void *weft_accum_buffer_values(const weft_accum_buffer *buffer, size_t *bytes);

WEFT_END_DECLS
#endif
