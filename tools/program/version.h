// SPDX-License-Identifier: BSD-3-Clause
// tools/program/version.h - what this weft is: what it was built of, and what runs here.
#ifndef WEFT_TOOLS_PROGRAM_VERSION_H
#define WEFT_TOOLS_PROGRAM_VERSION_H

// Prints "weft X.Y.Z" on the first line; below it commit, compiler, libraries, contexts, engines and
// ranks, a line each, without starting any. For scripts the first line stays as it is.
void version_print(void);

#endif
