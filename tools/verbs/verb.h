// SPDX-License-Identifier: BSD-3-Clause
// tools/verbs/verb.h - the verbs of the command, one const record each.
#ifndef WEFT_TOOLS_VERBS_VERB_H
#define WEFT_TOOLS_VERBS_VERB_H

#include "tools/options/options.h"

enum { VERB_MAX_OPTIONS = 80 };

// What verbs are for, as help and the manual list them.
enum verb_group { VERB_VOLUMES, VERB_IMAGES, VERB_FRAMES, VERB_METHODS, VERB_GROUPS };

struct verb {
    const char *name;
    enum verb_group group;
    const char *summary;           // one line
    const char *usage;             // without "weft NAME"
    const char *description;       // wrapped when printed
    const char *const *examples;   // NULL-ended command lines; the first ones are in the short help
    const char *const *epilogue;   // NULL-ended paragraphs after the options; NULL: none
    void (*print_catalogue)(void); // what names there are to choose from; NULL: none
    const struct option_spec *options;
    int option_count;
    bool many;              // operands: any number of them; otherwise one at most
    unsigned operand_names; // enum option_names, for completion and reports
    bool writes_last;       // the last of several operands is an output
    bool reads_stdin;       // an operand "-" is a file on standard input
    // Its work is divided among the ranks of a launcher: all of them run it (tools/ranks/ranks.h).
    // Otherwise rank 0 alone does.
    bool distributes;
    // Operands end with NULL. Returns the exit code.
    int (*run)(const char *const *operands, const struct option_value *values);
};

extern const struct verb verb_slice, verb_info, verb_make, verb_resample, verb_kernel, verb_table,
    verb_plan, verb_validate, verb_stability, verb_chart, verb_calibrate, verb_accumulate,
    verb_effect, verb_antialias, verb_convert, verb_probe, verb_lattice;

#endif
