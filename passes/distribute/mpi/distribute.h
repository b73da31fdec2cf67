// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/mpi/distribute.h - ranks of MPI (passes/distribute/ranks.h). It is no part of
// weft.h and libweft: a library of its own for each MPI that was there when weft was built
// (libweft-openmpi, libweft-mpich; -DWEFT_MPI=OFF: neither).
#ifndef WEFT_PASSES_DISTRIBUTE_MPI_DISTRIBUTE_H
#define WEFT_PASSES_DISTRIBUTE_MPI_DISTRIBUTE_H

#include <mpi.h>

#include "../items.h"

WEFT_BEGIN_DECLS

// Calls body on every rank of the caller's communicator, as weft_distribute_over. Collective. The
// communicator is duplicated, and the duplicate freed at the end: no message of the caller's is
// touched, and its error handler stays. MPI must have been initialised by the caller with
// MPI_THREAD_FUNNELED or more, and only the calling thread calls it; weft never initialises or
// finalises it. Returns as weft_distribute_over, and WEFT_ERR_UNSUPPORTED (MPI is not initialised,
// was finalised, or has fewer threads; the log says which).
WEFT_API enum weft_result weft_distribute(MPI_Comm communicator,
                                          const struct weft_distribute_params *params,
                                          weft_body body, void *priv);

WEFT_END_DECLS
#endif
