// SPDX-License-Identifier: BSD-3-Clause
// tools/output.h - texts and plots as files that appear whole or not at all.
#ifndef WEFT_TOOLS_OUTPUT_H
#define WEFT_TOOLS_OUTPUT_H

#include "weft.h"

// Through a temporary file in the target's folder and a rename. A symbolic link stays and what it
// leads to is replaced; devices and pipes are written to. Returns WEFT_ERR_WRITE after an error
// line.
enum weft_result output_save(const char *path, const void *data, size_t size);

#endif
