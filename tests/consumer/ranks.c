// SPDX-License-Identifier: BSD-3-Clause
// What a user's program with MPI does with weft: it has a communicator of its own, a part of
// MPI_COMM_WORLD, messages of its own under way, and an error handler; weft does items of work on
// the communicator's ranks. Run with 3 ranks: two are of the part.
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <weft_mpi.h>

enum { ITEMS = 25, TAG = 1 };

static int handled; // errors that came to the user's own handler

static void handle(MPI_Comm *communicator, int *code, ...)
{
    (void)communicator;
    (void)code;
    handled++;
}

static void must(int good, const char *what)
{
    if (good)
        return;
    fprintf(stderr, "not so: %s\n", what);
    MPI_Abort(MPI_COMM_WORLD, 1);
}

static enum weft_result square(void *priv, int64_t item, void **data, size_t *size)
{
    int64_t *result = malloc(sizeof *result);
    (void)priv;
    if (!result)
        return WEFT_ERR_MEMORY;
    *result = item * item;
    *data = result;
    *size = sizeof *result;
    return WEFT_OK;
}

static enum weft_result add(void *priv, int64_t item, const void *data, size_t size)
{
    (void)item;
    (void)size;
    *(int64_t *)priv += *(const int64_t *)data;
    return WEFT_OK;
}

static enum weft_result body(void *priv, weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    must(info.size == 2, "two ranks");
    must(info.threads >= 1, "a thread each");
    const struct weft_items work = {.count = ITEMS, .run = square, .take = add, .priv = priv};
    return weft_ranks_do_items(ranks, &work, NULL);
}

static void distribute(MPI_Comm part)
{
    int64_t sum = 0;
    int rank;
    MPI_Comm_rank(part, &rank);
    for (int i = 0; i < 2; i++) { // again, as a program does that goes on
        sum = 0;
        must(weft_distribute(part, weft_distribute_params(), body, &sum) == WEFT_OK,
             "weft_distribute");
        must(rank ? sum == 0 : sum == ITEMS * (ITEMS - 1) * (2 * ITEMS - 1) / 6,
             "the sum of squares");
    }
    if (rank == 0)
        printf("a sum of squares by two ranks: %lld\n", (long long)sum);
}

// The part's error handler is the user's before and after.
static void check_handler(MPI_Comm part, MPI_Errhandler own)
{
    MPI_Errhandler now;
    MPI_Comm_get_errhandler(part, &now);
    must(now == own, "the error handler is the user's");
    MPI_Errhandler_free(&now);
    MPI_Send(NULL, 0, MPI_BYTE, 99, TAG, part);
    must(handled == 1, "it hears of errors");
}

static enum weft_result no_body(void *priv, weft_ranks *ranks)
{
    (void)priv;
    (void)ranks;
    return WEFT_OK;
}

int main(int argc, char **argv)
{
    int level, rank, sent = 42, got = 0, initialised = 0;
    MPI_Request requests[2];
    must(weft_distribute(MPI_COMM_WORLD, weft_distribute_params(), no_body, NULL) ==
             WEFT_ERR_UNSUPPORTED,
         "refused before MPI is initialised");
    MPI_Initialized(&initialised);
    must(!initialised, "weft initialises nothing");
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm part;
    MPI_Errhandler own;
    MPI_Comm_split(MPI_COMM_WORLD, rank == 1, -rank, &part); // ranks 2 and 0, in this order
    MPI_Comm_create_errhandler(handle, &own);
    MPI_Comm_set_errhandler(part, own);
    // Of the user, with any tag, on the same communicator, while weft works.
    int place, size;
    MPI_Comm_rank(part, &place);
    MPI_Comm_size(part, &size);
    MPI_Irecv(&got, 1, MPI_INT, MPI_ANY_SOURCE, MPI_ANY_TAG, part, &requests[0]);
    if (rank != 1)
        distribute(part);
    MPI_Isend(&sent, 1, MPI_INT, (place + 1) % size, TAG, part, &requests[1]);
    MPI_Waitall(2, requests, MPI_STATUSES_IGNORE);
    must(got == 42, "the user's message came to the user");
    check_handler(part, own);
    MPI_Errhandler_free(&own);
    MPI_Comm_free(&part);
    int finalised = 1;
    MPI_Finalized(&finalised);
    must(!finalised, "weft finalises nothing");
    MPI_Finalize();
    return 0;
}
