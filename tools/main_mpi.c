// SPDX-License-Identifier: BSD-3-Clause
// What weft becomes under a launcher of MPI: the same command on several ranks. It is linked once
// with each MPI.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "passes/distribute/mpi/distribute.h"
#include "tools/command.h"
#include "tools/launcher.h"
#include "tools/ranks/guard.h"
#include "tools/ranks/ranks.h"

struct command_line {
    int argc;
    char **argv;
    int code;
};

static enum weft_result run(void *priv, weft_ranks *ranks)
{
    struct command_line *line = priv;
    ranks_set(ranks);
    line->code = ranks_end(command_main(line->argc, line->argv));
    ranks_set(NULL);
    return WEFT_OK;
}

// In the thread that talks to other ranks, whichever rank this is.
static void tell_lost(void *priv, const char *line)
{
    (void)priv;
    guard_farewell();
    report_erase_progress();
    fprintf(stderr, "weft: error: %s\n", line);
}

// Before anything asks, and unless the user has said it.
static void share_processors(void)
{
    char threads[16];
    snprintf(threads, sizeof threads, "%d", weft_distribute_threads(MPI_COMM_WORLD));
    setenv("WEFT_THREADS", threads, 0);
    setenv("LP_NUM_THREADS", threads, 0);
}

int main(int argc, char **argv)
{
    struct command_line line = {argc, argv, EXIT_CODE_FAILED};
    int level, size, rank = launcher_rank(&size);
    command_fill_streams();
    if (rank)
        report_mute();
    guard_start(rank, size);
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    share_processors();
    const struct weft_distribute_params *params =
        weft_distribute_params(.log = report_log(), .lost = tell_lost);
    const enum weft_result res = weft_distribute(MPI_COMM_WORLD, params, run, &line);
    guard_farewell();
    MPI_Finalize();
    guard_end();
    return res == WEFT_OK ? line.code : report_finish(res);
}
