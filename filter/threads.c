// SPDX-License-Identifier: BSD-3-Clause
#include "filter/threads.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

struct work {
    bool (*part)(void *priv, int thread, size_t i);
    void *priv;
    size_t count;
    atomic_size_t next;
    atomic_bool stopped;
};

struct worker {
    struct work *work;
    int number;
    pthread_t thread;
};

static int processors(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (int)online : 1;
}

int weft_threads_available(void)
{
    const char *most = getenv("WEFT_THREADS");
    const long wanted = most ? strtol(most, NULL, 10) : 0;
    const int count = processors();
    return wanted > 0 && wanted < count ? (int)wanted : count;
}

static void *work_on(void *argument)
{
    const struct worker *worker = argument;
    struct work *work = worker->work;
    while (!atomic_load(&work->stopped)) {
        const size_t i = atomic_fetch_add(&work->next, 1);
        if (i >= work->count)
            break;
        if (!work->part(work->priv, worker->number, i))
            atomic_store(&work->stopped, true);
    }
    return NULL;
}

// Returns how many of the workers past the first run.
static int start(struct worker *workers, struct work *work, int threads)
{
    sigset_t all, old;
    int started = 1;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    while (started < threads) {
        workers[started] = (struct worker){.work = work, .number = started};
        if (pthread_create(&workers[started].thread, NULL, work_on, &workers[started]) != 0)
            break;
        started++;
    }
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    return started;
}

bool weft_threads_run(int threads, size_t count, bool (*part)(void *priv, int thread, size_t i),
                      void *priv)
{
    struct work work = {.part = part, .priv = priv, .count = count};
    if ((size_t)threads > count)
        threads = (int)count;
    struct worker *workers = threads > 1 ? calloc((size_t)threads, sizeof *workers) : NULL;
    const int started = workers ? start(workers, &work, threads) : 1;
    work_on(&(struct worker){.work = &work});
    for (int i = 1; i < started; i++)
        pthread_join(workers[i].thread, NULL);
    free(workers);
    return !atomic_load(&work.stopped);
}
