// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/range_impl.h - inside the range simulator (not installed). Values are in codes; half
// and float targets: in units of 1.
#ifndef WEFT_PASSES_PLAN_RANGE_IMPL_H
#define WEFT_PASSES_PLAN_RANGE_IMPL_H

#include "filter/check.h"
#include "passes/plan/range.h"

// A pass, over all positions so far. Positions are numbered, x fastest.
struct weft_range_observed {
    bool settled; // combining: no floors are owed any more, the sums are whole again
    double minimum, maximum;
    double excursion, value; // how far, by which value
    size_t minimum_at, maximum_at, excursion_at;
};

static inline void weft_range_note(struct weft_range_observed *o, double value, double excursion,
                                   size_t at)
{
    if (excursion <= o->excursion)
        return;
    o->excursion = excursion;
    o->value = value;
    o->excursion_at = at;
}

static inline void weft_range_note_stored(struct weft_range_observed *o, double low, double high,
                                          size_t at)
{
    if (low < o->minimum) {
        o->minimum = low;
        o->minimum_at = at;
    }
    if (high > o->maximum) {
        o->maximum = high;
        o->maximum_at = at;
    }
}

// Taps of one group: four with dot4.
static inline int weft_range_components(const struct weft_pass_list *list)
{
    return list->dot4 ? 4 : 1;
}

// ---- range_load.c -------------------------------------------------------------------------------

// Sums inside stay within +- this, in 2^-e codes; INFINITY: they are not bounded.
double weft_range_limit(const struct weft_pass_list *list);

// What a tile's memory holds at `count` positions from `first`, and the codes of the logarithms of
// that (T where there is none).
void weft_range_load(const struct weft_pass_list *list, int tile, size_t first, int count,
                     double *out);
void weft_range_load_codes(const struct weft_pass_list *list, int tile, size_t first, int count,
                           double *out);

// ---- range.c ------------------------------------------------------------------------------------

// weft_range_simulate at every so many positions, in groups of neighbours.
enum weft_result weft_range_simulate_some(const struct weft_log *log,
                                          const struct weft_pass_list *passes,
                                          enum weft_worst_case worst_case, size_t every,
                                          const struct weft_progress *progress,
                                          struct weft_range *ranges,
                                          struct weft_range_report *report);

// ---- range_check.c ------------------------------------------------------------------------------

// Checks the list and finds which combinations are settled. Returns WEFT_ERR_ARGUMENT or
// WEFT_ERR_MEMORY.
enum weft_result weft_range_check(const struct weft_log *log, const struct weft_pass_list *list,
                                  struct weft_range_observed *observed);

// ---- range_levels.c: constants of every level, in the integers that passes compute --------------

typedef struct weft_levels weft_levels;

// *out stays NULL where levels are not followed one by one: other targets than unorm8, and lists
// whose numbers no plan has. Returns WEFT_ERR_MEMORY.
enum weft_result weft_levels_create(const struct weft_log *log, const struct weft_pass_list *list,
                                    weft_levels **out);
void weft_levels_destroy(weft_levels **levels); // accepts &NULL, leaves NULL behind

// Follows all passes at positions from `first`. False where something is out of all proportion; the
// passes are not noted then.
bool weft_levels_run(weft_levels *levels, size_t first, int count,
                     struct weft_range_observed *observed);

#endif
