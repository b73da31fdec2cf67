// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/volumes/child.h - the programs that run a peer, as bench_peers sees them (peer.h
// is theirs).
#ifndef WEFT_TESTS_PEERS_CHILD_H
#define WEFT_TESTS_PEERS_CHILD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>

#include "tests/peers/volumes/cut.h"

struct child {
    pid_t pid; // 0: not running
    FILE *in, *out;
    char text[512]; // its version, or why it does not run
};

// Starts a program and waits until it is set up. false: child->text says why not; a program that is
// not there counts as not built. argv[0] is its path.
bool child_start(struct child *child, char *const argv[], const struct cut *cut, int threads);

// One run; *again is NAN where the program tells none. false: it is gone, child->text says so.
bool child_run(struct child *child, double *seconds, double *again);

// The pixels of the last run.
bool child_pixels(struct child *child, float *pixels, size_t count);

// Peak resident bytes since set-up (where the kernel lets it be reset, else since the start).
uint64_t child_peak_bytes(const struct child *child);

// Accepts children that never ran. `kill_it`: does not wait for what it is doing.
void child_stop(struct child *child, bool kill_it);

#endif
