// SPDX-License-Identifier: BSD-3-Clause
#include "passes/choose/search.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"

const char *const weft_candidate_state_names[] = {"chosen", "dearer", "exceeds", "refused", NULL};

struct searcher {
    const struct weft_search *search;
    void **plans; // that were made of the candidates, by number; kept until one is chosen
    struct weft_search_result *out;
};

// ---- logs ---------------------------------------------------------------------------------------

static void write_quietly(void *priv, enum weft_log_level level, const char *message)
{
    struct weft_quiet_log *quiet = priv;
    if (level == WEFT_LOG_ERROR)
        snprintf(quiet->failure, sizeof quiet->failure, "%s", message);
    weft_log_write(quiet->loud, WEFT_LOG_DEBUG, "%s", message);
}

void weft_quiet_log_init(struct weft_quiet_log *quiet, const struct weft_log *loud)
{
    *quiet = (struct weft_quiet_log){.log = {write_quietly, quiet}, .loud = loud};
}

bool weft_quiet_log_refuses(struct weft_quiet_log *quiet, enum weft_result res)
{
    if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT)
        return true;
    if (res != WEFT_OK && quiet->failure[0])
        weft_error(quiet->loud, "%s", quiet->failure);
    return false;
}

// ---- candidates ---------------------------------------------------------------------------------

static bool is_within(const struct searcher *s, const struct weft_candidate *candidate)
{
    return candidate->bound <= s->search->max_error;
}

static bool is_open(const struct weft_candidate *candidate)
{
    return candidate->state == WEFT_CANDIDATE_DEARER;
}

// The cheapest that still may meet the budget; -1: none.
static int find_cheapest(const struct searcher *s)
{
    const struct weft_candidate *candidates = s->search->candidates;
    int best = -1;
    for (size_t i = 0; i < s->search->count; i++)
        if (is_open(&candidates[i]) &&
            (best < 0 || candidates[i].seconds < candidates[best].seconds))
            best = (int)i;
    return best;
}

// The one of the least bound, estimated or not, the last of several; -1: none.
static int find_least(const struct searcher *s)
{
    const struct weft_candidate *candidates = s->search->candidates;
    int least = -1;
    for (size_t i = 0; i < s->search->count; i++)
        if (candidates[i].state != WEFT_CANDIDATE_REFUSED &&
            (least < 0 || candidates[i].bound <= candidates[least].bound))
            least = (int)i;
    return least;
}

static void drop(struct searcher *s, size_t i)
{
    if (s->plans[i])
        s->search->destroy(s->plans[i]);
    s->plans[i] = NULL;
}

static enum weft_result plan(struct searcher *s, int i)
{
    struct weft_candidate *candidate = &s->search->candidates[i];
    const enum weft_result res = s->search->plan(s->search->priv, candidate, &s->plans[i]);
    s->out->planned++;
    candidate->estimated = false;
    if (weft_quiet_log_refuses(s->search->quiet, res)) {
        candidate->state = WEFT_CANDIDATE_REFUSED;
        candidate->bound = NAN;
        return WEFT_OK;
    }
    if (res == WEFT_OK && s->search->learn)
        s->search->learn(s->search->priv, candidate);
    return res;
}

static bool is_finer(const struct weft_candidate *candidate, const struct weft_candidate *planned)
{
    const struct weft_method *a = &candidate->method, *b = &planned->method;
    return a->algorithm == b->algorithm && a->technique == b->technique && a->bits == b->bits &&
           a->profile.target == b->profile.target && a->samples > b->samples;
}

void weft_search_learn(struct weft_candidate *candidates, size_t count,
                       const struct weft_candidate *planned, double rest)
{
    for (size_t i = 0; i < count; i++) {
        struct weft_candidate *other = &candidates[i];
        if (!other->estimated || !is_finer(other, planned))
            continue;
        const double doublings = log2((double)other->method.samples / planned->method.samples);
        const double sampled = (planned->bound - rest) * pow(0.4, doublings);
        other->bound = fmax(other->bound, sampled + 0.9 * rest);
    }
}

// ---- the search ---------------------------------------------------------------------------------

static enum weft_result find(struct searcher *s)
{
    enum weft_result res = WEFT_OK;
    int i;
    while (res == WEFT_OK && s->out->chosen < 0 && (i = find_cheapest(s)) >= 0) {
        struct weft_candidate *candidate = &s->search->candidates[i];
        if (!is_within(s, candidate)) {
            candidate->state = WEFT_CANDIDATE_EXCEEDS;
            drop(s, (size_t)i);
        } else if (!s->plans[i]) {
            res = plan(s, i);
        } else {
            s->out->chosen = i;
        }
    }
    if (s->out->chosen < 0)
        return res;
    s->search->candidates[s->out->chosen].state = WEFT_CANDIDATE_CHOSEN;
    s->out->plan = s->plans[s->out->chosen];
    s->plans[s->out->chosen] = NULL;
    return res;
}

static bool all_estimated(const struct searcher *s)
{
    for (size_t i = 0; i < s->search->count; i++)
        if (s->search->candidates[i].state != WEFT_CANDIDATE_REFUSED &&
            !s->search->candidates[i].estimated)
            return false;
    return true;
}

// About what the best would be, where nothing is within.
static enum weft_result find_best(struct searcher *s)
{
    const bool tells = s->out->chosen < 0 && (s->search->tells_best || all_estimated(s));
    const int least = tells ? find_least(s) : -1;
    return least >= 0 && s->search->candidates[least].estimated ? plan(s, least) : WEFT_OK;
}

static int compare(const void *a, const void *b)
{
    const struct weft_candidate *x = a, *y = b;
    const int refused = (x->state == WEFT_CANDIDATE_REFUSED) - (y->state == WEFT_CANDIDATE_REFUSED);
    return refused ? refused : (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

static void sort(struct searcher *s)
{
    struct weft_search_result *out = s->out;
    struct weft_candidate *candidates = s->search->candidates;
    qsort(candidates, s->search->count, sizeof *candidates, compare);
    for (size_t i = 0; i < s->search->count; i++) {
        struct weft_candidate *candidate = &candidates[i];
        if (candidate->state == WEFT_CANDIDATE_CHOSEN)
            out->chosen = (int)i;
        if (is_open(candidate) && !is_within(s, candidate))
            candidate->state = WEFT_CANDIDATE_EXCEEDS;
        if (candidate->state != WEFT_CANDIDATE_REFUSED && !candidate->estimated &&
            (out->best < 0 || candidate->bound < candidates[out->best].bound))
            out->best = (int)i;
    }
}

enum weft_result weft_search_run(const struct weft_search *search, struct weft_search_result *out)
{
    struct searcher s = {.search = search, .out = out};
    *out = (struct weft_search_result){.chosen = -1, .best = -1};
    s.plans = calloc(search->count + 1, sizeof *s.plans);
    if (!s.plans) {
        weft_error(search->quiet->loud, "not enough memory for the plans of %zu candidates",
                   search->count);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res = find(&s);
    if (res == WEFT_OK)
        res = find_best(&s);
    for (size_t i = 0; i < search->count; i++)
        drop(&s, i);
    free(s.plans);
    if (res == WEFT_OK) {
        sort(&s);
        return res;
    }
    if (out->plan)
        search->destroy(out->plan);
    *out = (struct weft_search_result){.chosen = -1, .best = -1};
    return res;
}
