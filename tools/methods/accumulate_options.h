// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/accumulate_options.h - the options that say how frames are averaged, as verbs share
// them, and what they come to.
#ifndef WEFT_TOOLS_METHODS_ACCUMULATE_OPTIONS_H
#define WEFT_TOOLS_METHODS_ACCUMULATE_OPTIONS_H

#include "tools/options/options.h"
#include "tools/methods/engine_options.h"
#include "weft.h"

// A verb's own enum has these side by side, from a `first` on.
enum accumulation_option {
    ACCUMULATION_METHOD,
    ACCUMULATION_BRANCHING,
    ACCUMULATION_ROUNDING,
    ACCUMULATION_BITS,
    ACCUMULATION_SOURCE_RANGE,
    ACCUMULATION_MAX_ERROR,
    ACCUMULATION_UNTIL,
    ACCUMULATION_BATCH,
    ACCUMULATION_CONTEXT,
    ACCUMULATION_EMULATE,
    ACCUMULATION_THREADS,
    ACCUMULATION_OPTION_COUNT
};

extern const char *const accumulation_bits_choices[]; // "8", "16", "32", "half"

// For the verbs' tables. automatic: what auto takes; refused: when a bound is looked at; batches:
// how many frames depend on each other where --batch is not given; emulated: what --emulate does;
// threads: whose, and how many.
#define ACCUMULATION_OPTIONS(first, automatic, refused, batches, emulated, threads_help)           \
    [first + ACCUMULATION_METHOD] = {.name = "method",                                             \
                                     0,                                                            \
                                     OPTION_CHOICE,                                                \
                                     NULL,                                                         \
                                     "how frames are added up (default auto: " automatic ")",      \
                                     weft_accumulate_method_names,                                 \
                                     .group = OPTION_METHOD,                                       \
                                     .brief = "exact, or as hardware does it"},                    \
             [first + ACCUMULATION_BRANCHING] = {.name = "branching",                              \
                                                 0,                                                \
                                                 OPTION_TEXT,                                      \
                                                 "N|NxNx...",                                      \
                                                 "tree: inputs of a node (default 4), or of each " \
                                                 "level's nodes from the frames up, as 2x4x4",     \
                                                 .group = OPTION_METHOD},                          \
             [first + ACCUMULATION_ROUNDING] = {.name = "rounding",                                \
                                                0,                                                 \
                                                OPTION_CHOICE,                                     \
                                                NULL,                                              \
                                                "tree of 8 or 16 bits: how a node becomes a code " \
                                                "(default nearest)",                               \
                                                weft_tree_rounding_names,                          \
                                                .group = OPTION_METHOD},                           \
             [first + ACCUMULATION_BITS] = {.name = "bits",                                        \
                                            0,                                                     \
                                            OPTION_CHOICE,                                         \
                                            NULL,                                                  \
                                            "of the targets of tree, buffer and blend (default "   \
                                            "8; buffer 16)",                                       \
                                            accumulation_bits_choices,                             \
                                            .group = OPTION_METHOD},                               \
             [first + ACCUMULATION_SOURCE_RANGE] = {.name = "source-range",                        \
                                                    0,                                             \
                                                    OPTION_RANGE,                                  \
                                                    "LO,HI",                                       \
                                                    "values that codes of 8 and 16 bits span "     \
                                                    "(default 0,1)",                               \
                                                    .group = OPTION_METHOD},                       \
             [first + ACCUMULATION_MAX_ERROR] = {.name = "max-error",                              \
                                                 0,                                                \
                                                 OPTION_NUMBER,                                    \
                                                 "E",                                              \
                                                 "how wrong the mean may be, in the frames' "      \
                                                 "values: a method whose bound is larger is "      \
                                                 "refused, " refused "; nothing is written then",  \
                                                 .group = OPTION_METHOD,                           \
                                                 .brief = "refuse a method beyond this bound"},    \
             [first + ACCUMULATION_UNTIL] =                                                        \
                 {.name = "until",                                                                 \
                  0,                                                                               \
                  OPTION_TEXT,                                                                     \
                  "E|R%[,share=S%][,least=N][,radius=N]",                                          \
                  "stop once a share of the pixels (default 99%) has a standard error below E, "   \
                  "or below R percent of the mean, or of both the larger; not before N frames "    \
                  "(default 16); judged over pixels around (default 2)",                           \
                  .group = OPTION_METHOD},                                                         \
             [first + ACCUMULATION_BATCH] = {.name = "batch",                                      \
                                             0,                                                    \
                                             OPTION_NUMBER,                                        \
                                             "N",                                                  \
                                             "so many frames in a row depend on each other, as "   \
                                             "those of a jitter table do, and are one sample of "  \
                                             "the standard error (default " batches ")",           \
                                             .group = OPTION_METHOD},                              \
             [first + ACCUMULATION_CONTEXT] = ENGINE_SPEC_CONTEXT,                                 \
             [first + ACCUMULATION_EMULATE] =                                                      \
                 {.name = "emulate", 0, OPTION_FLAG, NULL, emulated, .group = OPTION_METHOD},      \
             [first + ACCUMULATION_THREADS] = {.name = "threads",                                  \
                                               'j',                                                \
                                               OPTION_NUMBER,                                      \
                                               "N",                                                \
                                               threads_help                                        \
                                               "; the result does not depend on them",             \
                                               .group = OPTION_RESOURCES}

enum { ACCUMULATION_TEXT = 256 };

// What the options say.
struct accumulation {
    enum weft_accumulate_method method;
    int branching; // 0: the default
    int level_branching[WEFT_TREE_MAX_LEVELS];
    int bits;         // as struct weft_accumulator_params
    double low, high; // of targets; both 0: the default
    enum weft_tree_rounding rounding;
    double max_error; // 0: none was given
    struct weft_until until;
    int batch; // 0: was not given
    enum weft_context_kind context;
    bool emulate;
    int threads; // 0: as many as run at once
};

// What a verb does beside, to be added up with |.
enum accumulation_use {
    ACCUMULATION_TELLS_ERROR = 1,  // it is asked for the standard error, which --batch is of
    ACCUMULATION_DRAWS_FRAMES = 2, // on OpenGL, so that --context is of all methods
};

// Fills *out. Where options contradict each other, or what a method has not, returns
// WEFT_ERR_ARGUMENT after an error line, as for values. uses: of enum accumulation_use.
enum weft_result accumulation_read(const struct option_value *first, unsigned uses,
                                   struct accumulation *out);
// That a tree of the levels that --branching names has leaves for so many frames. Returns
// WEFT_ERR_ARGUMENT after an error line.
enum weft_result accumulation_check_branching(const struct accumulation *a, const char *text,
                                              int64_t frames);
// Whether the method runs on OpenGL.
bool accumulation_draws(enum weft_accumulate_method method);

// Sets what the options say in params, and leaves the rest.
void accumulation_set(const struct accumulation *a, struct weft_accumulator_params *params);

// Refuses a bound that is beyond --max-error. Returns WEFT_ERR_UNSUPPORTED after an error line.
enum weft_result accumulation_check_bound(const struct accumulation *a,
                                          enum weft_accumulate_method method, double bound);

// After which number of frames --until is judged next, where it was judged after so many, 0: not
// yet. The numbers depend on nothing but each other: the least one, and whenever a sixteenth has
// come on top.
int64_t accumulation_next_judged(const struct weft_until *until, int64_t judged);

#endif
