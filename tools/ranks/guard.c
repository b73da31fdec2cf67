// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/guard.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

enum { LIFE = 0, PATROL_MS = 500, GRACE_MS = 1000 };

// What the guard knows of its rank, and has as long as that lives.
struct watch {
    int rank, size;
    pid_t process, launcher;
    char host[256];
};

static volatile sig_atomic_t *farewell; // shared with the guard; NULL: there is none
static pid_t guard;
static int life = -1; // closed when the rank ends, however it does

// Of processes that are no children of this one. -1: the kernel has none.
static int open_process(pid_t process)
{
#ifdef SYS_pidfd_open
    return (int)syscall(SYS_pidfd_open, process, 0);
#else
    (void)process;
    return -1;
#endif
}

// Waits for the end of the rank, at most so long. Where `launcher` is no descriptor, poll ignores
// it.
static bool has_ended(struct pollfd watched[2], int timeout_ms)
{
    poll(watched, 2, timeout_ms);
    return watched[0].revents != 0;
}

static void tell(const struct watch *w, const char *what)
{
    char line[512];
    const int length =
        snprintf(line, sizeof line, "weft: error: rank %d of %d (%s, process %d) %s\n", w->rank,
                 w->size, w->host, (int)w->process, what);
    if (write(STDERR_FILENO, line, (size_t)length) < 0)
        _exit(1);
}

// A rank that is stopped sees no signal before it goes on.
static void end_rank(const struct watch *w, struct pollfd watched[2])
{
    watched[1].fd = -1;
    kill(w->process, SIGTERM);
    kill(w->process, SIGCONT);
    if (!has_ended(watched, GRACE_MS))
        kill(w->process, SIGKILL);
}

static bool is_gone(const struct watch *w, const struct pollfd *launcher)
{
    return launcher->fd < 0 ? kill(w->launcher, 0) != 0 : launcher->revents != 0;
}

static void stand_guard(const struct watch *w, int launcher)
{
    struct pollfd watched[2] = {{.fd = LIFE, .events = POLLIN}, {.fd = launcher, .events = POLLIN}};
    for (;;) {
        const bool ended = has_ended(watched, launcher < 0 ? PATROL_MS : -1);
        if (*farewell && ended)
            return;
        if (is_gone(w, &watched[1])) {
            if (w->rank == 0)
                tell(w, "has lost the launcher (mpirun): the job is ended");
            if (!ended)
                end_rank(w, watched);
            return;
        }
        if (ended) {
            tell(w, "died before its work was done: the job is ended");
            return;
        }
    }
}

// Nothing of the rank stays open here but its errors: the launcher waits for the end of what it
// reads.
static void be_guard(const struct watch *w, const int ends[2])
{
    close(ends[1]);
    const int launcher = open_process(w->launcher);
    signal(SIGPIPE, SIG_DFL);
    dup2(ends[0], LIFE);
    if (launcher >= 0 && launcher != 3)
        dup2(launcher, 3);
    close(STDOUT_FILENO);
    close_range(4, ~0u, 0);
    stand_guard(w, launcher >= 0 ? 3 : -1);
}

void guard_start(int rank, int size)
{
    int ends[2];
    struct watch w = {.rank = rank, .size = size, .process = getpid(), .launcher = getppid()};
    if (gethostname(w.host, sizeof w.host - 1) != 0)
        strcpy(w.host, "localhost");
    void *shared =
        mmap(NULL, sizeof *farewell, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED || pipe2(ends, O_CLOEXEC) != 0)
        return;
    farewell = shared;
    guard = fork();
    if (guard == 0) {
        be_guard(&w, ends);
        _exit(0);
    }
    close(ends[0]);
    life = ends[1];
}

void guard_farewell(void)
{
    if (farewell)
        *farewell = 1;
}

void guard_end(void)
{
    guard_farewell();
    if (guard <= 0)
        return;
    close(life);
    waitpid(guard, NULL, 0);
    guard = 0;
}
