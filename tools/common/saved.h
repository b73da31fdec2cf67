// SPDX-License-Identifier: BSD-3-Clause
// tools/common/saved.h - what became of the values that a verb wrote as EXR.
#ifndef WEFT_TOOLS_COMMON_SAVED_H
#define WEFT_TOOLS_COMMON_SAVED_H

#include "tools/common/json.h"

json_t *saved_json(const struct weft_image_save_report *saved);
// With --verify: a line on stdout of what was read back; otherwise nothing.
void saved_print(const char *path, const struct weft_image_save_report *saved);

#endif
