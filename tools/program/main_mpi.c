// SPDX-License-Identifier: BSD-3-Clause
// What weft becomes under a launcher of MPI: the same command on several ranks. It is linked once
// with each MPI.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/program/command.h"
#include "tools/program/launcher.h"
#include "tools/ranks/guard.h"
#include "tools/ranks/ranks.h"
#include "weft_mpi.h"

struct command_line {
    int argc;
    char **argv;
    int code;
};

// What a rank's share of its node's processors is told to, unless the user has said it: weft's own
// loops and readers, and Mesa's software renderer. Other threads read the environment once MPI is
// initialised, and the share is known after that: so the variables are there before, and are
// written into.
static char weft_threads[32] = "WEFT_THREADS=", mesa_threads[32] = "LP_NUM_THREADS=";

static void threads_reserve(void)
{
    char *const variables[] = {weft_threads, mesa_threads};
    for (int i = 0; i < 2; i++) {
        char name[32];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(variables[i], "="), variables[i]);
        if (!getenv(name))
            putenv(variables[i]);
    }
}

static void threads_share(const weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    char *const variables[] = {weft_threads, mesa_threads};
    for (int i = 0; i < 2; i++)
        snprintf(strchr(variables[i], '=') + 1, 12, "%d", info.threads);
}

// A rank's guard, and where it is.
struct posted {
    int node;
    struct guard_peer peer;
};

static void meet_neighbours(const struct posted *all, int size, int node)
{
    static struct guard_peer peers[GUARD_MOST_PEERS];
    int count = 0;
    for (int r = 0; r < size; r++) {
        if (all[r].node != node)
            continue;
        if (count == GUARD_MOST_PEERS)
            return;
        peers[count++] = all[r].peer;
    }
    guard_meet(peers, count);
}

// Collective. Without memory guards stay by themselves.
static void meet_guards(weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    const struct posted own = {info.node, guard_self()};
    struct weft_ranks_part parts[info.rank ? 1 : info.size];
    struct posted *all = info.rank ? NULL : calloc((size_t)info.size, sizeof *all);
    size_t size = all ? (size_t)info.size * sizeof *all : 0;
    void *shared = all;
    enum weft_result res = weft_ranks_gather(ranks, &own, sizeof own, parts);
    for (int r = 0; all && res == WEFT_OK && r < info.size; r++)
        all[r] = *(const struct posted *)parts[r].data;
    if (res == WEFT_OK && info.rank == 0)
        weft_ranks_free_parts(info.size, parts);
    if (res == WEFT_OK)
        res = weft_ranks_share(ranks, &shared, &size);
    if (res == WEFT_OK && size)
        meet_neighbours(shared, info.size, info.node);
    free(shared);
}

static enum weft_result run(void *priv, weft_ranks *ranks)
{
    struct command_line *line = priv;
    meet_guards(ranks);
    ranks_set(ranks);
    threads_share(ranks);
    line->code = ranks_end(command_main(line->argc, line->argv));
    ranks_set(NULL);
    return WEFT_OK;
}

// In the thread that talks to other ranks, whichever rank this is.
static void tell_lost(void *priv, const char *line)
{
    (void)priv;
    if (!guard_dismiss_all())
        return;
    report_erase_progress();
    fprintf(stderr, "weft: error: %s\n", line);
}

int main(int argc, char **argv)
{
    struct command_line line = {argc, argv, EXIT_CODE_FAILED};
    int level, size, rank = launcher_rank(&size);
    command_fill_streams();
    if (rank)
        report_mute();
    threads_reserve();
    guard_start(rank, size);
    command_catch_signals();
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    const struct weft_distribute_params *params =
        weft_distribute_params(.log = report_log(), .lost = tell_lost);
    const enum weft_result res = weft_distribute(MPI_COMM_WORLD, params, run, &line);
    guard_farewell();
    MPI_Finalize();
    guard_end();
    return res == WEFT_OK ? line.code : report_finish(res);
}
