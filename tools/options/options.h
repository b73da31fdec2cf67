// SPDX-License-Identifier: BSD-3-Clause
// tools/options/options.h - one table of options for each verb, which feeds parsing, help, manual
// pages and completion. Written as getopt_long has it: `--name value`, `--name=value`, any
// unambiguous start of a name, and `-n value`, `-nvalue` or several flags as `-qv` where the
// options have letters. An option given twice is an error, so that nothing is ignored in silence;
// flags may be repeated. So are two outputs, or an output and --json, for standard output. A value
// that starts with '-' and is not a number is taken only as `--name=value`. `--` ends the options.
#ifndef WEFT_TOOLS_OPTIONS_OPTIONS_H
#define WEFT_TOOLS_OPTIONS_OPTIONS_H

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
    OPTION_PIXELS,  // N (both) or WxH -> integer[2]
    OPTION_VOXELS,  // N (all three alike) or NxNxN -> integer[3]
    OPTION_INDEX,   // I,J,K -> integer[3]
    OPTION_OUTPUT,  // a file's name, "-" for standard output (text is then /dev/stdout); the ending
                    // is one of the list or there is none -> integer[0], its place, or -1
};

// Under what help lists an option, in this order.
enum option_group {
    OPTION_TASK,      // what the verb does, and what only it has
    OPTION_FILES,     // inputs and outputs, and how they are read and written
    OPTION_GEOMETRY,  // planes, sizes, frames, regions
    OPTION_FILTER,    // the kernel, and what is around it
    OPTION_METHOD,    // engines, passes and accuracy
    OPTION_PICTURES,  // previews and plots
    OPTION_RESOURCES, // memory, threads, ranks
    OPTION_REPORTS,   // what is told
    OPTION_GROUPS
};
extern const char *const option_group_names[OPTION_GROUPS]; // titles

// What may be a file's name, for completion; bits of what OPTION_TEXT and operands take.
enum option_names {
    OPTION_NAMES_FILE = 1,    // any file
    OPTION_NAMES_KERNEL = 2,  // kernels
    OPTION_NAMES_PROFILE = 4, // target profiles
    OPTION_NAMES_GRID = 8,    // grids of the volume that is the first operand
    OPTION_NAMES_MAP = 16,    // colour maps
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
    enum option_group group;
    const char *brief; // a line of the short help, at most 48 characters; NULL: --help=all has it
    unsigned names;    // enum option_names, for completion
    bool optional;     // the value may be left out: `--name` or `--name=value`
};

struct option_value {
    bool given;
    const char *text;   // as written, for messages; NULL unless given
    int64_t integer[3]; // within +-2^62
    double number[3];   // finite
};

// ---- options that several verbs have, by the same names and letters -----------------------------

extern const char *const options_json_endings[];
// --json, or --json=FILE. `what`: "times and errors", say.
#define OPTIONS_JSON(what)                                                                         \
    {                                                                                              \
        .name = "json", 0, OPTION_OUTPUT, "FILE",                                                  \
        "print " what " as JSON, or write it to FILE; docs/json.md has the shape",                 \
        options_json_endings, .group = OPTION_REPORTS, .brief = "the report as JSON",              \
        .optional = true                                                                           \
    }
#define OPTIONS_NO_CLOBBER                                                                         \
    {                                                                                              \
        .name = "no-clobber", 0, OPTION_FLAG, NULL, "refuse to replace an output",                 \
        .group = OPTION_FILES                                                                      \
    }
#define OPTIONS_THREADS                                                                            \
    {                                                                                              \
        .name = "threads", 'j', OPTION_NUMBER, "N",                                                \
        "threads of the CPU engine and of files, at most (default: one for each processor); "      \
        "the result is the same",                                                                  \
        .group = OPTION_RESOURCES                                                                  \
    }
#define OPTIONS_QUIET                                                                              \
    {                                                                                              \
        .name = "quiet", 'q', OPTION_FLAG, NULL, "only errors, and what was asked for",            \
        .group = OPTION_REPORTS                                                                    \
    }
#define OPTIONS_VERBOSE                                                                            \
    {                                                                                              \
        .name = "verbose", 'v', OPTION_FLAG, NULL, "say what is done", .group = OPTION_REPORTS     \
    }

// ---- parsing ------------------------------------------------------------------------------------

enum option_help { OPTION_HELP_NONE, OPTION_HELP_BRIEF, OPTION_HELP_ALL };

// Fills values[option_count] and positional[positional_max]. Returns false after one error line.
struct option_parse {
    const char *verb; // for messages
    const struct option_spec *options;
    int option_count;
    struct option_value *values;
    const char **positional;
    int positional_max;
    int positional_count;  // out
    enum option_help help; // out: -h, --help or --help=all is there, and nothing else is looked at
    bool writes_stdout;    // out: one of the outputs is standard output
};
bool options_parse(struct option_parse *parse, int argc, char **argv);

// Reads a value as it is written into *value, by the option's type. Returns false after an error
// line. values.c
bool options_read_value(const struct option_parse *parse, const struct option_spec *spec,
                        const char *text, struct option_value *value);

// Writes how help and messages name the value ("OUT.exr", "on|off"), whole or cut.
void options_format_value(const struct option_spec *spec, char *text, size_t size);

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

// ---- help ---------------------------------------------------------------------------------------

// The options that have a brief line, a line each, on stdout. Returns how many others there are.
int options_print_brief(const struct option_spec *options, int option_count);
// The whole table by groups.
void options_print_all(const struct option_spec *options, int option_count);

// Prints text on stdout, broken between words before column 79, every line indented.
void options_print_wrapped(const char *text, int indent);

#endif
