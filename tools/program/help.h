// SPDX-License-Identifier: BSD-3-Clause
// tools/program/help.h - what weft says of itself: help, manual pages and completion, all from the
// verbs' own tables of options.
#ifndef WEFT_TOOLS_PROGRAM_HELP_H
#define WEFT_TOOLS_PROGRAM_HELP_H

#include "tools/verbs/verb.h"

extern const struct verb *const help_verbs[]; // all of them, NULL-ended, in the order of help
const struct verb *help_find_verb(const char *name); // NULL: there is none

// What holds for every verb. (help_texts.c)
struct help_entry {
    const char *name, *text;
};
extern const struct help_entry help_exit_codes[], help_environment[]; // both end with NULL
extern const char *const help_rules[];                                // NULL-ended
extern const char help_summary[];
extern const char *const help_group_names[VERB_GROUPS];

void help_print(bool all);
void help_print_verb(const struct verb *verb, bool all);

// "unknown verb", with what may be meant. "": none was given.
void help_report_unknown_verb(const char *name);

// A manual page in man(7): of the verb, or for NULL of weft. (help_manual.c)
void help_print_manual(const struct verb *verb);
// Completion for "bash", "zsh" or "fish". Returns false after an error line. (help_completion.c)
bool help_print_completion(const char *shell);

#endif
