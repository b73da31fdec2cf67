// SPDX-License-Identifier: BSD-3-Clause
// weft_mpi.h - weft on ranks of MPI: weft.h, and what libweft-openmpi and libweft-mpich have.
#ifndef WEFT_MPI_H
#define WEFT_MPI_H

#include "passes/distribute/mpi/distribute.h"
#include "weft.h"

#endif
