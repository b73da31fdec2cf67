// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/search.h - the search that every choice is: the cheapest candidate within a budget
// (not installed). Figures of candidates are exact, or the least that a plan could have. The
// cheapest one is looked at first; it is planned only when its least bound is within the budget,
// and taken when it is still the cheapest as planned: what is left costs more whatever its plan is.
// The plan that was made is the plan that is returned.
#ifndef WEFT_PASSES_CHOOSE_SEARCH_H
#define WEFT_PASSES_CHOOSE_SEARCH_H

#include "passes/choose/candidate.h"

// A log for what is only looked at: what keeps a candidate out is no error of the choice. Messages
// go to the loud one at debug level; the last error is kept, to be told after all.
struct weft_quiet_log {
    struct weft_log log; // for params structs
    const struct weft_log *loud;
    char failure[256];
};
void weft_quiet_log_init(struct weft_quiet_log *quiet, const struct weft_log *loud);
// Whether a result only refuses a candidate; what else went wrong is told to the loud log.
bool weft_quiet_log_refuses(struct weft_quiet_log *quiet, enum weft_result res);

struct weft_search {
    // The request's: names, methods and figures, state DEARER or REFUSED. In any order; where two
    // cost the same the first one is taken.
    struct weft_candidate *candidates;
    size_t count;
    double max_error; // in the candidates' units
    // Where nothing meets the budget, the candidate of the least bound is planned if it is
    // estimated, so that `best` tells about what there is. Else that is done only if all are
    // estimated.
    bool tells_best;
    struct weft_quiet_log *quiet; // that `plan` logs to
    void *priv;
    // Plans a candidate and sets its method and figures to the plan's. WEFT_ERR_UNSUPPORTED and
    // WEFT_ERR_LIMIT refuse the candidate, others end the search.
    enum weft_result (*plan)(void *priv, struct weft_candidate *candidate, void **plan);
    void (*destroy)(void *plan);
    // Told of each plan: may raise bounds of candidates that are estimated. NULL: does not.
    void (*learn)(void *priv, const struct weft_candidate *planned);
};

struct weft_search_result {
    int chosen;  // -1: none meets the budget
    int best;    // the one of the least bound among those whose figures are not estimated; -1: none
    void *plan;  // the chosen one's, the caller's to destroy; NULL: none
    int planned; // how many plans were made
};

// Searches, then sorts the candidates by seconds, refused ones last; no state is left that the
// budget contradicts. On failure no plan is left. Returns what `plan` does, WEFT_ERR_MEMORY.
enum weft_result weft_search_run(const struct weft_search *search, struct weft_search_result *out);

// What a plan of passes tells of estimated candidates that differ from it in having more samples a
// tile. Twice the samples make nearest positions half as far off, and `rest` of a bound, which is
// what else is in it (0: nothing is known of it), stays. Roundings of tiles differ a little between
// the two: 0.4 in place of 0.5, and 0.9 of the rest.
void weft_search_learn(struct weft_candidate *candidates, size_t count,
                       const struct weft_candidate *planned, double rest);

#endif
