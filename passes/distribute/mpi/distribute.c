// SPDX-License-Identifier: BSD-3-Clause
// It is compiled once for each MPI.
#include "passes/distribute/mpi/distribute.h"

#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { TAG = 1 };

// A message of one rank, whole before it is told of: what waits for more of it is not the thread
// that tells others that it lives.
struct coming {
    MPI_Request request; // MPI_REQUEST_NULL: none comes
    bool whole;
    int size;
    unsigned char *box; // WEFT_TRANSPORT_MAX bytes; NULL: no message has come yet
};

struct link {
    MPI_Comm all;
    int ranks, begun;     // messages that have begun to come and are not whole
    struct coming *from;  // [ranks]: who stops in the middle of a message keeps nobody else's back
    unsigned char *spare; // the box of whoever sends for the first time; NULL: none is there
    char host[MPI_MAX_PROCESSOR_NAME];
};

static bool begin_send(void *priv, int to, const void *data, size_t size, void **request)
{
    struct link *link = priv;
    MPI_Request *sending = malloc(sizeof *sending);
    *request = sending;
    if (sending && MPI_Isend(data, (int)size, MPI_BYTE, to, TAG, link->all, sending) == MPI_SUCCESS)
        return true;
    free(sending);
    return false;
}

static bool is_sent(void *priv, void *request)
{
    (void)priv;
    int done = 0;
    if (MPI_Test(request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done)
        return false;
    free(request);
    return true;
}

static bool has_spare(struct link *link)
{
    if (!link->spare)
        link->spare = malloc(WEFT_TRANSPORT_MAX);
    return link->spare;
}

// Begins to receive the next message of a rank, or of any, where there is one, and room.
static void begin_receive(struct link *link, int source)
{
    int found = 0, size = 0;
    MPI_Message message;
    MPI_Status status;
    if (!has_spare(link) ||
        MPI_Improbe(source, TAG, link->all, &found, &message, &status) != MPI_SUCCESS || !found ||
        MPI_Get_count(&status, MPI_BYTE, &size) != MPI_SUCCESS)
        return;
    struct coming *from = &link->from[status.MPI_SOURCE];
    if (!from->box) {
        from->box = link->spare;
        link->spare = NULL;
    }
    from->size = size;
    if (MPI_Imrecv(from->box, size, MPI_BYTE, &message, &from->request) == MPI_SUCCESS)
        link->begun++;
}

// Messages of one rank stay in their order: the next one begins when the one before was taken.
static void begin_receives(struct link *link)
{
    if (link->begun == 0) {
        begin_receive(link, MPI_ANY_SOURCE);
        return;
    }
    for (int r = 0; r < link->ranks; r++)
        if (link->from[r].request == MPI_REQUEST_NULL)
            begin_receive(link, r);
}

static int64_t probe(void *priv, int *from)
{
    struct link *link = priv;
    begin_receives(link);
    for (int r = 0; r < link->ranks && link->begun > 0; r++) {
        struct coming *coming = &link->from[r];
        int done = 0;
        if (coming->request == MPI_REQUEST_NULL ||
            MPI_Test(&coming->request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS || !done)
            continue;
        link->begun--;
        coming->whole = true;
        *from = r;
        return coming->size;
    }
    return -1;
}

static bool take(void *priv, int from, void *data, size_t size)
{
    struct coming *coming = &((struct link *)priv)->from[from];
    if (!coming->whole || size != (size_t)coming->size)
        return false;
    coming->whole = false;
    if (size)
        memcpy(data, coming->box, size);
    return true;
}

static void *end_this(void *exit_code)
{
    const struct timespec patience = {.tv_sec = 1};
    nanosleep(&patience, NULL);
    _exit((int)(intptr_t)exit_code);
}

// MPICH's waits for messages to ranks that are stopped, for ever. A rank that is gone with an error
// and has not said so to MPI ends the job as well.
static void end_all(void *priv, int exit_code)
{
    struct link *link = priv;
    pthread_t thread;
    if (pthread_create(&thread, NULL, end_this, (void *)(intptr_t)exit_code) != 0)
        _exit(exit_code);
    MPI_Abort(link->all, exit_code);
}

static void tell_error(const struct weft_log *log, const char *line)
{
    if (log && log->write)
        log->write(log->priv, WEFT_LOG_ERROR, line);
}

static enum weft_result check_mpi(const struct weft_log *log)
{
    int initialised = 0, finalised = 0, level = 0;
    MPI_Initialized(&initialised);
    MPI_Finalized(&finalised);
    if (initialised && !finalised)
        MPI_Query_thread(&level);
    if (!initialised)
        tell_error(log, "MPI is not initialised: MPI_Init_thread comes before");
    else if (finalised)
        tell_error(log, "MPI was finalised");
    else if (level < MPI_THREAD_FUNNELED)
        tell_error(log, "MPI was initialised for one thread: MPI_THREAD_FUNNELED is needed");
    else
        return WEFT_OK;
    return WEFT_ERR_UNSUPPORTED;
}

// ---- who is where -------------------------------------------------------------------------------

// What ranks tell each other before they begin.
struct introduction {
    char host[MPI_MAX_PROCESSOR_NAME], machine[40]; // the kernel's name of this run of it; "": none
    cpu_set_t processors;                           // that the rank may run on
};

static void introduce(struct introduction *own)
{
    int length = 0;
    memset(own, 0, sizeof *own);
    MPI_Get_processor_name(own->host, &length);
    FILE *file = fopen("/proc/sys/kernel/random/boot_id", "r");
    if (file && !fgets(own->machine, sizeof own->machine, file))
        own->machine[0] = 0;
    if (file)
        fclose(file);
    if (sched_getaffinity(0, sizeof own->processors, &own->processors) != 0)
        CPU_SET(0, &own->processors);
}

static bool are_neighbours(const struct introduction *a, const struct introduction *b)
{
    return strcmp(a->host, b->host) == 0 && strcmp(a->machine, b->machine) == 0;
}

// A processor that several ranks of the node may use is shared by them: what is left over when all
// were given as many whole ones goes to the first.
static int count_threads(const struct introduction *all, const struct weft_transport *t)
{
    const struct introduction *own = &all[t->rank];
    double share = 0.0;
    for (int i = 0; i < CPU_SETSIZE; i++) {
        int users = 0;
        for (int r = 0; CPU_ISSET(i, &own->processors) && r < t->size; r++)
            users += are_neighbours(&all[r], own) && CPU_ISSET(i, &all[r].processors);
        share += users ? 1.0 / users : 0.0;
    }
    const int whole = (int)(share + 1e-6);
    const int left = (int)((share - whole) * t->node_size + 0.5);
    const int threads = whole + (t->node_rank < left);
    return threads > 0 ? threads : 1;
}

static void find_neighbours(const struct introduction *all, struct weft_transport *out)
{
    out->node = -1;
    for (int r = 0; r < out->size; r++) {
        if (!are_neighbours(&all[r], &all[out->rank]))
            continue;
        out->node = out->node < 0 ? r : out->node;
        out->node_rank += r < out->rank;
        out->node_size++;
    }
    out->threads = count_threads(all, out);
}

// ---- the whole ----------------------------------------------------------------------------------

// Who waits within MPI keeps a processor busy, which the rank that is waited for may need.
static void wait_for(MPI_Request *request)
{
    const struct timespec nap = {.tv_nsec = 100000};
    int done = 0;
    while (MPI_Test(request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done)
        nanosleep(&nap, NULL);
}

// All ranks have room, or none begins.
static bool all_have(MPI_Comm all, bool room)
{
    int mine = room, least = 0;
    MPI_Request request;
    MPI_Iallreduce(&mine, &least, 1, MPI_INT, MPI_MIN, all, &request);
    wait_for(&request);
    return least;
}

static bool open_link(MPI_Comm communicator, struct link *link, struct weft_transport *out)
{
    MPI_Request request;
    MPI_Comm_idup(communicator, &link->all, &request);
    wait_for(&request);
    MPI_Comm_set_errhandler(link->all, MPI_ERRORS_RETURN);
    MPI_Comm_rank(link->all, &out->rank);
    MPI_Comm_size(link->all, &out->size);
    link->ranks = out->size;
    link->from = calloc((size_t)link->ranks, sizeof *link->from);
    for (int r = 0; link->from && r < link->ranks; r++)
        link->from[r].request = MPI_REQUEST_NULL;
    struct introduction own, *all = calloc((size_t)link->ranks, sizeof *all);
    const bool room = all_have(link->all, has_spare(link) && link->from && all);
    if (room) {
        introduce(&own);
        MPI_Iallgather(&own, sizeof own, MPI_BYTE, all, sizeof own, MPI_BYTE, link->all, &request);
        wait_for(&request);
        find_neighbours(all, out);
        memcpy(link->host, own.host, sizeof link->host);
        out->host = link->host;
    }
    free(all);
    return room;
}

static void close_link(struct link *link)
{
    MPI_Comm_free(&link->all);
    for (int r = 0; link->from && r < link->ranks; r++)
        free(link->from[r].box);
    free(link->from);
    free(link->spare);
}

enum weft_result weft_distribute(MPI_Comm communicator, const struct weft_distribute_params *params,
                                 weft_body body, void *priv)
{
    enum weft_result res = check_mpi(params->log);
    if (res != WEFT_OK)
        return res;
    struct link link = {.begun = 0};
    struct weft_transport transport = {.priv = &link,
                                       .send = begin_send,
                                       .sent = is_sent,
                                       .probe = probe,
                                       .take = take,
                                       .abort = end_all};
    res = WEFT_ERR_MEMORY;
    if (open_link(communicator, &link, &transport))
        res = weft_distribute_over(&transport, params, body, priv);
    else
        tell_error(params->log, "out of memory for messages between ranks");
    close_link(&link);
    return res;
}
