// SPDX-License-Identifier: BSD-3-Clause
// tools/program/version.h - what this weft is: what it was built of, and what runs here.
#ifndef WEFT_TOOLS_PROGRAM_VERSION_H
#define WEFT_TOOLS_PROGRAM_VERSION_H

// Prints "weft X.Y.Z" on the first line; below it commit, compiler, libraries, contexts, engines and
// ranks, a line each, without starting any. For scripts the first line stays as it is. Words that
// stand behind "version", which end with NULL, ask for help or are refused. Returns the exit code.
int version_run(char **words);
void version_print_help(void);

#endif
