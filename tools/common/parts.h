// SPDX-License-Identifier: BSD-3-Clause
// tools/common/parts.h - which part of an EXR file: --part NAME|INDEX.
#ifndef WEFT_TOOLS_COMMON_PARTS_H
#define WEFT_TOOLS_COMMON_PARTS_H

#include "weft.h"

// The number that is the whole of a text, or -1.
int parts_number(const char *text);

// Finds a part by its name, or else by its number. Returns WEFT_ERR_ARGUMENT after an error line
// that lists those that there are.
enum weft_result parts_find(const char *input, const struct weft_image_list *list, const char *text,
                            size_t *out);

#endif
