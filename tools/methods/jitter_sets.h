// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/jitter_sets.h - sets of sample positions as the command's users name them.
#ifndef WEFT_TOOLS_METHODS_JITTER_SETS_H
#define WEFT_TOOLS_METHODS_JITTER_SETS_H

// Prints the names that weft_jitter_parse knows on stdout, a line for each.
void jitter_sets_print(void);

#endif
