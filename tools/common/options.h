// SPDX-License-Identifier: BSD-3-Clause
// tools/common/options.h - one option parser for all verbs: each verb declares its options as a
// table, and the same table prints its help. Written as `--name value`, `--name=value`, or `-n
// value` where the option has a letter. An option given twice is an error, so that nothing is
// ignored in silence; flags may be repeated. So are two outputs, or an output and a flag --json,
// for standard output. A value that starts with '-' and is not a number is taken only as
// `--name=value`. `--` ends the options.
#ifndef WEFT_TOOLS_COMMON_OPTIONS_H
#define WEFT_TOOLS_COMMON_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "weft.h"

enum option_type {
    OPTION_FLAG,
    OPTION_TEXT,
    OPTION_CHOICE,  // one of a NULL-ended list of words -> integer[0], its place in the list
    OPTION_BYTES,   // 1048576, 1024K, 512M, 2G (powers of 1024) -> integer[0] > 0
    OPTION_NUMBER,  // one finite number -> number[0]
    OPTION_SPAN,    // A, or A..B -> number[0], number[1] (A again), integer[0]: 1 for A..B
    OPTION_POINT,   // X,Y,Z -> number[3]
    OPTION_RANGE,   // LO,HI -> number[2]
    OPTION_SPACING, // S (all three alike) or SX,SY,SZ -> number[3]
    OPTION_PIXELS,  // WxH -> integer[2]
    OPTION_VOXELS,  // N (all three alike) or NxNxN -> integer[3]
    OPTION_INDEX,   // I,J,K -> integer[3]
    OPTION_OUTPUT,  // a file's name, "-" for standard output (text is then /dev/stdout); the ending
                    // is one of the list or there is none -> integer[0], its place, or -1
};

struct option_spec {
    const char *name; // without the dashes
    char letter;      // 0: none
    enum option_type type;
    const char *value; // how help writes the value: "OUT.exr"; NULL for flags, and for choices,
                       // which are written "x|y|z"
    const char *help;  // wrapped when printed
    const char *const *choices; // words, or endings as ".exr"
    int choice_count;           // the first so many of them; 0: all
};

struct option_value {
    bool given;
    const char *text;   // as written, for messages; NULL unless given
    int64_t integer[3]; // within +-2^62
    double number[3];   // finite
};

// Fills values[option_count] and positional[positional_max]. Returns false after one error line.
// *help is set, and nothing else is looked at, when -h or --help is among the options.
struct option_parse {
    const char *verb; // for messages
    const struct option_spec *options;
    int option_count;
    struct option_value *values;
    const char **positional;
    int positional_max;
    int positional_count; // out
    bool help;            // out
    bool writes_stdout;   // out: one of the outputs is standard output
};
bool options_parse(struct option_parse *parse, int argc, char **argv);

// The value of a number that is given; otherwise *out stays as it is. Where it is not from low to
// high returns WEFT_ERR_ARGUMENT after a line "--NAME VALUE: " and `what`.
enum weft_result options_read_number(const struct option_value *value, const char *name, double low,
                                     double high, const char *what, double *out);
// The same of a number that must be a whole one, which the line says by itself.
enum weft_result options_read_whole(const struct option_value *value, const char *name,
                                    int64_t least, int64_t most, int *out);
// Whether it is given, as "help": a list of names is asked for.
bool options_ask_for_help(const struct option_value *value);

// Writes the names of a list whose bits are set, as "a, b or c", `last` being "or"; cut where they
// do not fit.
void options_join_names(const char *const *names, unsigned bits, const char *last, char *text,
                        size_t size);

// The table as help text on stdout.
void options_print(const struct option_spec *options, int option_count);

// Prints text on stdout, broken between words before column 79, every line indented.
void options_print_wrapped(const char *text, int indent);

#endif
