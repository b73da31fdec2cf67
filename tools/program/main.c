// SPDX-License-Identifier: BSD-3-Clause
// The weft command: alone, or until it knows that it is not.
#include "tools/program/command.h"
#include "tools/program/launcher.h"
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
    line->code = command_main(line->argc, line->argv);
    ranks_set(NULL);
    return WEFT_OK;
}

static int run_alone(int argc, char **argv)
{
    struct command_line line = {argc, argv, EXIT_CODE_FAILED};
    const struct weft_distribute_params *params = weft_distribute_params(.log = report_log());
    const enum weft_result res = weft_distribute_over(NULL, params, run, &line);
    return res == WEFT_OK ? line.code : report_finish(res);
}

int main(int argc, char **argv)
{
    int size, rank = launcher_rank(&size), code = -1;
    command_fill_streams();
    if (command_distributes(argc, argv))
        code = launcher_become(argv);
    else if (rank)
        code = EXIT_CODE_DONE; // rank 0 does it, alone
    return code >= 0 ? code : run_alone(argc, argv);
}
