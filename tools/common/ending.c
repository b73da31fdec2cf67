// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/ending.h"

#include <signal.h>
#include <stddef.h>
#include <unistd.h>

#include "weft.h"

static const int ending_signals[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE,   SIGALRM, SIGTERM,
                                     SIGUSR1, SIGUSR2, SIGXCPU, SIGVTALRM, SIGPROF, SIGXFSZ};

static volatile sig_atomic_t child, deferred, due, noting, requested;
static void (*clean_up_screen)(void);

static void die(int number)
{
    sigset_t only;
    signal(number, SIG_DFL);
    sigemptyset(&only);
    sigaddset(&only, number);
    sigprocmask(SIG_UNBLOCK, &only, NULL);
    raise(number);
}

static void on_signal(int number)
{
    if (number == SIGINT && deferred && !due) {
        due = 1;
        return;
    }
    if (number == SIGUSR1 && noting) {
        requested = 1;
        return;
    }
    if (child)
        kill(-(pid_t)child, SIGKILL);
    weft_unfinished_discard();
    clean_up_screen();
    die(number);
}

void ending_start(void (*clean_up)(void))
{
    clean_up_screen = clean_up;
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART}, old;
    sigfillset(&action.sa_mask);
    for (size_t i = 0; i < sizeof ending_signals / sizeof *ending_signals; i++)
        if (sigaction(ending_signals[i], NULL, &old) == 0 && old.sa_handler == SIG_DFL)
            sigaction(ending_signals[i], &action, NULL);
}

bool ending_start_thread(pthread_t *thread, void *(*call)(void *priv), void *priv)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const bool started = pthread_create(thread, NULL, call, priv) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

void ending_set_child(pid_t leader)
{
    child = (sig_atomic_t)leader;
}

void ending_defer_interrupt(void)
{
    deferred = 1;
}

bool ending_is_due(void)
{
    return due;
}

void ending_note_requests(void)
{
    noting = 1;
}

bool ending_has_request(void)
{
    return requested;
}

bool ending_take_request(void)
{
    const bool had = requested;
    requested = 0;
    return had;
}

void ending_finish(void)
{
    if (!due)
        return;
    clean_up_screen();
    die(SIGINT);
}
