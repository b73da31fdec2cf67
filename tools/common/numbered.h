// SPDX-License-Identifier: BSD-3-Clause
// tools/common/numbered.h - names of files that are numbered: "smoke_%04d.vdb" is smoke_0007.vdb
// and smoke_12345.vdb. A name has one conversion, %d or %0Nd (N digits at least, 1 to 9), and %% is
// a percent sign.
#ifndef WEFT_TOOLS_COMMON_NUMBERED_H
#define WEFT_TOOLS_COMMON_NUMBERED_H

#include "weft.h"

// Whether a number belongs into the name: it has %d or %0Nd somewhere.
bool numbered_is(const char *name);

// Whether it can be numbered. Otherwise returns WEFT_ERR_ARGUMENT after an error line, which starts
// with `option` ("-o ", or "" for what has no option). required: a conversion must be there.
enum weft_result numbered_check(const char *option, const char *name, bool required);

// The name of a number, for one that was checked; to be freed, NULL where memory ran out.
char *numbered_format(const char *name, int64_t number);

#endif
