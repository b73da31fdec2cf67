// SPDX-License-Identifier: BSD-3-Clause
// tools/program/launcher.h - weft under a launcher of MPI (mpirun), as its environment tells: it
// becomes the program that is linked with that MPI, and nothing of MPI is loaded before.
#ifndef WEFT_TOOLS_PROGRAM_LAUNCHER_H
#define WEFT_TOOLS_PROGRAM_LAUNCHER_H

// Returns the place among the ranks of a launcher and sets their number: 0 of 1 without one.
int launcher_rank(int *size);

// Where there are several ranks becomes weft-openmpi or weft-mpich, and does not return: it is
// looked for in $WEFT_LIBEXEC if set, else beside the program, else in the installed libexec
// folder. Returns -1 without a launcher, and EXIT_CODE_FAILED, after one line of rank 0, where that
// program is not there or cannot be run.
int launcher_become(char **argv);

#endif
