// SPDX-License-Identifier: BSD-3-Clause
// tools/common/standard_input.h - "-" for a file that is read: readers go to and fro in files,
// which pipes do not allow.
#ifndef WEFT_TOOLS_COMMON_STANDARD_INPUT_H
#define WEFT_TOOLS_COMMON_STANDARD_INPUT_H

#include "weft.h"

// Makes "/dev/stdin" a file that can be opened any number of times: what is no regular file is read
// to its end, into memory. Returns WEFT_ERR_OPEN (it is closed, or a terminal) or WEFT_ERR_MEMORY
// after an error line.
enum weft_result standard_input_take(void);

#endif
