// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/output/unfinished.h"

#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

enum { SLOTS = 64 };

static _Atomic(const char *) files[SLOTS];
static _Atomic pid_t leaders[SLOTS];
static _Atomic pid_t owner;

// A child that was forked has a copy of what is its parent's.
static void own(void)
{
    const pid_t self = getpid(), before = atomic_exchange(&owner, self);
    if (before == self || before == 0)
        return;
    for (int i = 0; i < SLOTS; i++) {
        atomic_store(&files[i], NULL);
        atomic_store(&leaders[i], 0);
    }
}

void weft_unfinished_add_file(const char *path)
{
    own();
    for (int i = 0; i < SLOTS; i++) {
        const char *none = NULL;
        if (atomic_compare_exchange_strong(&files[i], &none, path))
            return;
    }
}

void weft_unfinished_remove_file(const char *path)
{
    for (int i = 0; i < SLOTS; i++) {
        const char *mine = path;
        if (atomic_compare_exchange_strong(&files[i], &mine, NULL))
            return;
    }
}

void weft_unfinished_add_process(pid_t leader)
{
    own();
    for (int i = 0; i < SLOTS; i++) {
        pid_t none = 0;
        if (atomic_compare_exchange_strong(&leaders[i], &none, leader))
            return;
    }
}

void weft_unfinished_remove_process(pid_t leader)
{
    for (int i = 0; i < SLOTS; i++) {
        pid_t mine = leader;
        if (atomic_compare_exchange_strong(&leaders[i], &mine, 0))
            return;
    }
}

void weft_unfinished_discard(void)
{
    if (atomic_load(&owner) != getpid())
        return;
    for (int i = 0; i < SLOTS; i++) {
        const char *path = atomic_load(&files[i]);
        pid_t leader = atomic_load(&leaders[i]);
        if (path)
            unlink(path);
        if (leader)
            kill(-leader, SIGKILL);
    }
}
