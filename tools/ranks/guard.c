// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/guard.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

// Milliseconds: between looks at a launcher without a descriptor; that a rank has to end by itself.
enum { PATROL = 500, GRACE = 1000 };

// What a rank and its guard share.
struct pact {
    volatile sig_atomic_t farewell;
    int peers;
    struct guard_peer peer[GUARD_MOST_PEERS];
};
static struct pact *pact; // NULL: there is no guard
static pid_t guard;
static int life = -1; // closed when the rank ends, however it does

struct watch {
    int rank, size;
    pid_t process, launcher;
    char host[256];
    int life, events, launcher_fd; // descriptors
};
static struct watch watch; // both have it; only the guard's changes

bool guard_dismiss_all(void)
{
    if (!pact)
        return true;
    if (pact->farewell)
        return false;
    pact->farewell = 1;
    for (int i = 0; i < pact->peers; i++)
        if (pact->peer[i].guard > 0 && pact->peer[i].rank != watch.process)
            kill(pact->peer[i].guard, SIGUSR1);
    return true;
}

static void tell(const struct watch *w, const char *what)
{
    char line[512];
    const int length =
        snprintf(line, sizeof line, "weft: error: rank %d of %d (%s, process %d) %s\n", w->rank,
                 w->size, w->host, (int)w->process, what);
    if (write(STDERR_FILENO, line, (size_t)length) < 0)
        return;
}

static void tell_death(const struct watch *w)
{
    if (!guard_dismiss_all())
        return;
    tell(w, "died before its work was done: the job is ended");
}

// ---- the guard ----------------------------------------------------------------------------------

// What it waits for: the end of the rank's side of the pipe, of the launcher, of one of the ranks.
enum { LIFE = -1, LAUNCHER = -2, NOTHING = -3 };

// Events are told in the order in which they come.
static void add_event(const struct watch *w, int fd, unsigned events, int what)
{
    struct epoll_event event = {.events = events, .data.fd = what};
    epoll_ctl(w->events, EPOLL_CTL_ADD, fd, &event);
}

static int next_event(const struct watch *w, int milliseconds)
{
    struct epoll_event event;
    return epoll_wait(w->events, &event, 1, milliseconds) == 1 ? event.data.fd : NOTHING;
}

// A second reader of other ranks' pipes is told when those end. That comes close to what the
// launcher sees, and long before it has ended others.
static void meet(const struct watch *w)
{
    char path[64];
    for (int i = 0; i < pact->peers; i++) {
        const struct guard_peer *peer = &pact->peer[i];
        snprintf(path, sizeof path, "/proc/%d/fd/%d", (int)peer->guard, w->life);
        const int fd = peer->guard <= 0 || peer->rank == w->process
                           ? -1
                           : open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
        if (fd >= 0)
            add_event(w, fd, EPOLLONESHOT, i);
    }
}

// Where the launcher is gone. A rank that is stopped sees no signal before it goes on.
static void end_rank(const struct watch *w)
{
    char byte;
    if (w->rank == 0)
        tell(w, "has lost its launcher (mpirun): the job is ended");
    kill(w->process, SIGTERM);
    kill(w->process, SIGCONT);
    for (int event; (event = next_event(w, GRACE)) != NOTHING;)
        if (event == LIFE && read(w->life, &byte, 1) <= 0)
            return;
    kill(w->process, SIGKILL);
}

static bool is_launcher_gone(const struct watch *w, int event)
{
    return event == LAUNCHER || (w->launcher_fd < 0 && kill(w->launcher, 0) != 0);
}

static void be_silent(int signal)
{
    (void)signal;
    pact->farewell = 1;
}

static void stand_guard(const struct watch *w)
{
    char byte;
    bool first = true; // none of the node's ranks ended before
    for (;;) {
        const int event = next_event(w, w->launcher_fd < 0 ? PATROL : -1);
        if (event == LIFE && read(w->life, &byte, 1) == 1) {
            meet(w);
        } else if (event == LIFE) {
            if (first)
                tell_death(w);
            return;
        } else if (event >= 0) {
            first = false;
        } else if (is_launcher_gone(w, event)) {
            end_rank(w);
            return;
        }
    }
}

// Nothing of the rank stays open here but its errors: the launcher waits for the end of what it
// reads. It ends the processes of the rank's group.
static void be_guard(struct watch *w, const int ends[2])
{
    setpgid(0, 0);
    signal(SIGUSR1, be_silent);
    w->life = STDIN_FILENO;
    dup2(ends[0], w->life);
    close(STDOUT_FILENO);
    close_range(3, ~0u, 0);
    w->events = epoll_create1(0);
    add_event(w, w->life, EPOLLIN, LIFE);
    w->launcher_fd = (int)syscall(SYS_pidfd_open, w->launcher, 0);
    if (w->launcher_fd >= 0)
        add_event(w, w->launcher_fd, EPOLLIN | EPOLLONESHOT, LAUNCHER);
    stand_guard(w);
}

// ---- the rank -----------------------------------------------------------------------------------

void guard_start(int rank, int size)
{
    int ends[2];
    watch = (struct watch){.rank = rank, .size = size};
    watch.process = getpid();
    watch.launcher = getppid();
    if (gethostname(watch.host, sizeof watch.host - 1) != 0)
        strcpy(watch.host, "localhost");
    void *shared =
        mmap(NULL, sizeof *pact, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED || pipe2(ends, O_CLOEXEC) != 0)
        return;
    pact = shared;
    guard = fork();
    if (guard == 0) {
        be_guard(&watch, ends);
        _exit(0);
    }
    close(ends[0]);
    life = ends[1];
}

struct guard_peer guard_self(void)
{
    return (struct guard_peer){getpid(), guard > 0 ? guard : 0};
}

// A library ends the process: the guard hears of it before the launcher does, who hears of it from
// what is done on the way out.
static void end_guard(void)
{
    if (getpid() != watch.process || guard <= 0)
        return;
    close(life);
    waitpid(guard, NULL, 0);
}

void guard_meet(const struct guard_peer *peers, int count)
{
    if (guard <= 0)
        return;
    pact->peers = count;
    memcpy(pact->peer, peers, (size_t)pact->peers * sizeof *peers);
    if (write(life, "", 1) != 1)
        pact->peers = 0;
    atexit(end_guard);
}

void guard_farewell(void)
{
    if (pact)
        pact->farewell = 1;
}

void guard_end(void)
{
    guard_farewell();
    end_guard();
    guard = 0;
}
