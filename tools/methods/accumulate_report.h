// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/accumulate_report.h - how verbs tell how frames were averaged.
#ifndef WEFT_TOOLS_METHODS_ACCUMULATE_REPORT_H
#define WEFT_TOOLS_METHODS_ACCUMULATE_REPORT_H

#include "tools/common/json.h"
#include "tools/methods/accumulate_options.h"

// "tree of 8 bits, branching 4", "exact".
const char *accumulation_format(const struct option_value *first,
                                const struct weft_accumulator_report *report,
                                char text[ACCUMULATION_TEXT]);
// Name, why, bits, bound, bias, textures, bytes and passes.
json_t *accumulation_json(const struct weft_accumulator_report *report);

// How it went with --until.
struct accumulation_stop {
    const char *asked;                   // the option's text
    int64_t frames, planned;             // that were added, of so many
    int64_t judged;                      // last, after so many; 0: never
    bool stopped;                        // before the last frame
    struct weft_convergence convergence; // as last judged
};
json_t *accumulation_stop_json(const struct accumulation_stop *stop);
// A line where it has ended the run, a warning where it was not met.
void accumulation_tell_stop(const struct accumulation_stop *stop);

// Prints passes of `groups` of four channels, and returns how many textures a tree's stack has.
int accumulation_explain_passes(const struct accumulation *a, enum weft_accumulate_method method,
                                int groups, int64_t frames);
// Prints method, why and bound.
void accumulation_explain(const struct option_value *first,
                          const struct weft_accumulator_report *planned);

#endif
