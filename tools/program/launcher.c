// SPDX-License-Identifier: BSD-3-Clause
#include "tools/program/launcher.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/report.h"

enum { LONGEST = 4096 };

// Slurm and others speak as MPICH's launcher does (srun --mpi=pmi2).
static const struct mpi {
    const char *size, *rank, *program, *name;
} mpis[] = {
    {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "weft-openmpi", "Open MPI"},
    {"PMI_SIZE", "PMI_RANK", "weft-mpich", "MPICH"},
    {NULL, NULL, NULL, NULL},
};

static int number_in(const char *variable)
{
    const char *text = getenv(variable);
    return text ? atoi(text) : 0;
}

static const struct mpi *find_mpi(void)
{
    for (const struct mpi *mpi = mpis; mpi->size; mpi++)
        if (number_in(mpi->size) > 1)
            return mpi;
    return NULL;
}

int launcher_rank(int *size)
{
    const struct mpi *mpi = find_mpi();
    *size = mpi ? number_in(mpi->size) : 1;
    return mpi ? number_in(mpi->rank) : 0;
}

// Goes on only where it could not; false: it is not there.
static bool become(const char *folder, const char *program, char **argv)
{
    char path[LONGEST];
    if (snprintf(path, sizeof path, "%s/%s", folder, program) >= LONGEST || access(path, F_OK) != 0)
        return false;
    execv(path, argv);
    report_error("%s cannot be run: %s", path, strerror(errno));
    return true;
}

// The folder that this program is in.
static void own_folder(char folder[LONGEST])
{
    const ssize_t length = readlink("/proc/self/exe", folder, LONGEST - 1);
    folder[length > 0 ? length : 0] = 0;
    char *slash = strrchr(folder, '/');
    if (slash)
        *slash = 0;
}

static void try_folders(const struct mpi *mpi, char **argv)
{
    char own[LONGEST], moved[LONGEST + sizeof WEFT_LIBEXEC_FROM_BIN];
    const char *forced = secure_getenv("WEFT_LIBEXEC");
    own_folder(own);
    snprintf(moved, sizeof moved, "%s/" WEFT_LIBEXEC_FROM_BIN, own);
    if (forced ? become(forced, mpi->program, argv)
               : become(own, mpi->program, argv) || become(moved, mpi->program, argv))
        return;
    report_error(
        "started by %s with several ranks, but %s, which weft then becomes, is not in %s%s%s:"
        " weft was built or installed without it (-DWEFT_MPI=ON)",
        mpi->name, mpi->program, forced ? forced : own, forced ? "" : " or ", forced ? "" : moved);
}

int launcher_become(char **argv)
{
    const struct mpi *mpi = find_mpi();
    if (!mpi)
        return -1;
    if (number_in(mpi->rank))
        report_mute();
    try_folders(mpi, argv);
    return EXIT_CODE_FAILED;
}
