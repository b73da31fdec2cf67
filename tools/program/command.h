// SPDX-License-Identifier: BSD-3-Clause
// tools/program/command.h - the weft command: finds the verb, parses its options, prints help. Both
// weft and what it becomes under a launcher of MPI call it.
#ifndef WEFT_TOOLS_PROGRAM_COMMAND_H
#define WEFT_TOOLS_PROGRAM_COMMAND_H

#include <stdbool.h>

// Fills standard streams that are closed, before anything is opened: a file would take the place of
// one, and get its text. What fills them is of no use in their direction.
void command_fill_streams(void);

// Signals end the process at once, with nothing left behind (tools/common/ending.h). A command line
// with a verb asks for it by itself.
void command_catch_signals(void);

// Runs a command line on the ranks that were set (tools/ranks/ranks.h), once per process. Returns
// the exit code; on other ranks than 0 at once EXIT_CODE_DONE, where the verb does not distribute.
int command_main(int argc, char **argv);

// Whether its verb divides its work among ranks; false where there is none.
bool command_distributes(int argc, char **argv);

#endif
