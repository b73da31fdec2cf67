// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/life.h - signs of life, round in a ring: each rank tells the next one that it
// lives, and watches the one before (not installed). Silence is counted while this process is awake
// itself, so that a job that is stopped as a whole and goes on loses no rank; whatever comes from
// the rank before is a sign. Thread-safety: the thread that talks, under the ranks' lock.
#ifndef WEFT_PASSES_DISTRIBUTE_LIFE_H
#define WEFT_PASSES_DISTRIBUTE_LIFE_H

#include "passes/distribute/talk.h"

struct weft_life {
    struct weft_talk *talk;
    int next;       // rank
    double looked;  // when silence was counted last
    double silence; // seconds
    double told;    // when the last sign was sent
    bool ended;     // the rank before has said its last
    long process;   // of the rank before; 0: not known yet
    char host[64];
    struct weft_outgoing message;
};

void weft_life_init(struct weft_life *life, struct weft_talk *talk, double now);
// A message has come.
void weft_life_hear(struct weft_life *life, int from, const struct weft_incoming *in);
// Tells the next rank, if it is time, unless that is `silent` from now on. Returns whether the rank
// before is lost: nothing came of it for longer than the time-out.
bool weft_life_step(struct weft_life *life, double now, double timeout, bool silent);

#endif
