// SPDX-License-Identifier: BSD-3-Clause
// It is compiled once for each MPI.
#include "passes/distribute/mpi/distribute.h"

#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { TAG = 1 };

struct link {
    MPI_Comm all, node;
    // The one message that comes, whole before it is told of: what waits for more of it is not the
    // thread that tells others that it lives.
    MPI_Request coming;
    bool whole;
    int from, size;
    unsigned char *box; // WEFT_TRANSPORT_MAX bytes
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

// Begins to receive the next message, where there is one.
static bool begin_receive(struct link *link)
{
    int found = 0;
    MPI_Message message;
    MPI_Status status;
    if (MPI_Improbe(MPI_ANY_SOURCE, TAG, link->all, &found, &message, &status) != MPI_SUCCESS ||
        !found || MPI_Get_count(&status, MPI_BYTE, &link->size) != MPI_SUCCESS)
        return false;
    link->from = status.MPI_SOURCE;
    return MPI_Imrecv(link->box, link->size, MPI_BYTE, &message, &link->coming) == MPI_SUCCESS;
}

static int64_t probe(void *priv, int *from)
{
    struct link *link = priv;
    int done = link->whole;
    if (!done && link->coming == MPI_REQUEST_NULL && !begin_receive(link))
        return -1;
    if (!done && (MPI_Test(&link->coming, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS || !done))
        return -1;
    link->whole = true;
    *from = link->from;
    return link->size;
}

static bool take(void *priv, int from, void *data, size_t size)
{
    struct link *link = priv;
    if (!link->whole || from != link->from || size != (size_t)link->size)
        return false;
    link->whole = false;
    if (size)
        memcpy(data, link->box, size);
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

// A processor that several ranks of the node may use is shared by them: what is left over when all
// were given as many whole ones goes to the first.
static int count_threads(MPI_Comm node)
{
    int rank, size, users[CPU_SETSIZE] = {0}, mine[CPU_SETSIZE] = {0};
    cpu_set_t set;
    MPI_Comm_rank(node, &rank);
    MPI_Comm_size(node, &size);
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        CPU_SET(0, &set);
    for (int i = 0; i < CPU_SETSIZE; i++)
        mine[i] = CPU_ISSET(i, &set) ? 1 : 0;
    MPI_Allreduce(mine, users, CPU_SETSIZE, MPI_INT, MPI_SUM, node);
    double share = 0.0;
    for (int i = 0; i < CPU_SETSIZE; i++)
        share += mine[i] ? 1.0 / users[i] : 0.0;
    const int whole = (int)(share + 1e-6);
    const int left = (int)((share - whole) * size + 0.5);
    const int threads = whole + (rank < left);
    return threads > 0 ? threads : 1;
}

static void open_link(MPI_Comm communicator, struct link *link, struct weft_transport *out)
{
    int length = 0;
    MPI_Comm_dup(communicator, &link->all);
    MPI_Comm_set_errhandler(link->all, MPI_ERRORS_RETURN);
    MPI_Comm_split_type(link->all, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &link->node);
    MPI_Comm_rank(link->all, &out->rank);
    MPI_Comm_size(link->all, &out->size);
    MPI_Comm_rank(link->node, &out->node_rank);
    MPI_Comm_size(link->node, &out->node_size);
    MPI_Get_processor_name(link->host, &length);
    out->threads = count_threads(link->node);
    out->host = link->host;
}

static void close_link(struct link *link)
{
    MPI_Comm_free(&link->node);
    MPI_Comm_free(&link->all);
    free(link->box);
}

// All ranks have room, or none begins.
static bool all_have(MPI_Comm all, const void *memory)
{
    int mine = memory != NULL, least = 0;
    MPI_Allreduce(&mine, &least, 1, MPI_INT, MPI_MIN, all);
    return least;
}

enum weft_result weft_distribute(MPI_Comm communicator, const struct weft_distribute_params *params,
                                 weft_body body, void *priv)
{
    enum weft_result res = check_mpi(params->log);
    if (res != WEFT_OK)
        return res;
    struct link link = {.coming = MPI_REQUEST_NULL, .box = malloc(WEFT_TRANSPORT_MAX)};
    struct weft_transport transport = {.priv = &link,
                                       .send = begin_send,
                                       .sent = is_sent,
                                       .probe = probe,
                                       .take = take,
                                       .abort = end_all};
    open_link(communicator, &link, &transport);
    res = WEFT_ERR_MEMORY;
    if (all_have(link.all, link.box))
        res = weft_distribute_over(&transport, params, body, priv);
    else
        tell_error(params->log, "out of memory for messages between ranks");
    close_link(&link);
    return res;
}
