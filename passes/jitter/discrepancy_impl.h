// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/discrepancy_impl.h - discrepancies for searches, which look at many sets of as many
// points (not installed).
#ifndef WEFT_PASSES_JITTER_DISCREPANCY_IMPL_H
#define WEFT_PASSES_JITTER_DISCREPANCY_IMPL_H

#include "passes/jitter/discrepancy.h"

WEFT_BEGIN_DECLS

// Another point as the edge turns about p: the direction, in [0, pi), of the edge through both. A
// point `ahead` is on the left of the edge before and on its right after that; others the reverse.
struct weft_discrepancy_event {
    double direction;
    int ahead;
};

// weft_discrepancy_compute of params that are right, with room for an event of each point. It stops
// once it has found an edge whose error is `enough` or more (INFINITY: it does not).
struct weft_discrepancy weft_discrepancy_find(const struct weft_discrepancy_params *params,
                                              struct weft_discrepancy_event *events, double enough);

WEFT_END_DECLS
#endif
