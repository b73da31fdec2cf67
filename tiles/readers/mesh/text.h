// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/text.h - bytes that grow (not installed).
#ifndef WEFT_TILES_READERS_MESH_TEXT_H
#define WEFT_TILES_READERS_MESH_TEXT_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// All zero: none. Once memory was short nothing is added any more.
struct weft_mesh_text {
    char *data;
    size_t size, room;
    bool failed;
};

void weft_mesh_text_add(struct weft_mesh_text *text, const void *data, size_t size);
void weft_mesh_text_print(struct weft_mesh_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void weft_mesh_text_clear(struct weft_mesh_text *text);

WEFT_END_DECLS
#endif
