// SPDX-License-Identifier: BSD-3-Clause
#include "tools/program/command.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/ending.h"
#include "tools/common/report.h"
#include "tools/ranks/guard.h"
#include "tools/ranks/ranks.h"
#include "tools/verbs/verb.h"

static const struct verb *const verbs[] = {&verb_slice,     &verb_probe,      &verb_info,
                                           &verb_convert,   &verb_make,       &verb_resample,
                                           &verb_lattice,   &verb_accumulate, &verb_effect,
                                           &verb_antialias, &verb_kernel,     &verb_table,
                                           &verb_plan,      &verb_validate,   &verb_stability,
                                           &verb_chart,     &verb_calibrate,  NULL};
enum { VERB_COUNT = sizeof verbs / sizeof *verbs - 1 };

static const struct verb *find_verb(const char *name)
{
    for (int i = 0; verbs[i]; i++)
        if (strcmp(verbs[i]->name, name) == 0)
            return verbs[i];
    return NULL;
}

static void print_help(void)
{
    puts("weft - reconstruction filtering of volumes on OpenGL, without a window\n\n"
         "usage: weft VERB ...\n");
    for (int i = 0; verbs[i]; i++)
        printf("  weft %-10s %s\n", verbs[i]->name, verbs[i]->summary);
    puts("\n  weft help VERB | weft VERB --help    what a verb does, and its options\n"
         "  weft --version\n\n"
         "exit codes:\n"
         "  0  done\n"
         "  1  failed: out of memory, a GL error, no gnuplot for a plot,\n"
         "     nothing within --max-error;\n"
         "     weft antialias: pixels without their samples' weight;\n"
         "     weft validate: invalid; weft stability: a case fails\n"
         "  2  wrong usage: options, names, geometry\n"
         "  3  unreadable or refused input: missing, damaged, unsupported, over a limit;\n"
         "     frames left out by --skip-bad\n"
         "  4  output not written\n"
         "  5  no usable GL context\n"
         "a signal ends weft at once, and by that signal\n\n"
         "outputs: the ending of a name tells the format; - is standard output, where nothing\n"
         "else goes then: texts go to stderr\n\n"
         "environment:\n"
         "  WEFT_LIBEXEC    folder of the reader programs (weft-read-vdb and its siblings)\n"
         "  XDG_CACHE_HOME  where weft calibrate keeps its numbers (default ~/.cache)\n"
         "  LP_NUM_THREADS  threads of Mesa's software renderer; the results are the same\n"
         "  WEFT_THREADS    threads of all else, at most (default: all processors); likewise");
}

static void print_verb_help(const struct verb *verb)
{
    printf("usage: weft %s %s\n\n", verb->name, verb->usage);
    options_print_wrapped(verb->description, 0);
    puts("\noptions:");
    options_print(verb->options, verb->option_count);
    for (int i = 0; verb->epilogue && verb->epilogue[i]; i++) {
        putchar('\n');
        options_print_wrapped(verb->epilogue[i], 0);
    }
    if (verb->print_catalogue) {
        putchar('\n');
        verb->print_catalogue();
    }
}

// What verbs are called elsewhere.
static const struct {
    const char *name, *verb;
} verb_aliases[] = {
    {"cut", "slice"},       {"reslice", "slice"},    {"resize", "resample"},
    {"scale", "resample"},  {"upscale", "resample"}, {"transform", "lattice"},
    {"grid", "lattice"},    {"generate", "make"},    {"create", "make"},
    {"print", "info"},      {"show", "info"},        {"check", "validate"},
    {"verify", "validate"}, {"bench", "chart"},      {"benchmark", "chart"},
    {"plot", "chart"},      {"test", "stability"},   {"average", "accumulate"},
    {"mean", "accumulate"}, {"merge", "accumulate"}, {"stack", "accumulate"},
    {"blur", "effect"},     {"render", "effect"},    {"effects", "effect"},
    {"aa", "antialias"},    {"smooth", "antialias"}, {"supersample", "antialias"},
};
enum { VERB_ALIASES = sizeof verb_aliases / sizeof *verb_aliases };

static const char *suggest_verb(const char *name)
{
    const char *names[VERB_COUNT + VERB_ALIASES + 2] = {"help"};
    int count = 1;
    for (int i = 0; verbs[i]; i++)
        names[count++] = verbs[i]->name;
    for (int i = 0; i < VERB_ALIASES; i++)
        names[count++] = verb_aliases[i].name;
    const char *found = weft_closest_find(name, strlen(name), names);
    for (int i = 0; found && i < VERB_ALIASES; i++)
        if (found == verb_aliases[i].name)
            return verb_aliases[i].verb;
    return found;
}

// "": none was given.
static int unknown_verb(const char *name)
{
    char names[256] = "";
    for (int i = 0; verbs[i]; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s, ", verbs[i]->name);
    }
    const char *meant = suggest_verb(name);
    if (!*name)
        report_error("no verb given; there are: %shelp (see weft --help)", names);
    else if (meant)
        report_error("unknown verb '%s'; did you mean %s? There are: %shelp", name, meant, names);
    else
        report_error("unknown verb '%s'; there are: %shelp", name, names);
    return EXIT_CODE_USAGE;
}

// A signal ends a rank because someone sent it.
static void clean_up(void)
{
    report_end();
    guard_farewell();
}

void command_catch_signals(void)
{
    ending_start(clean_up);
}

// Operands have room for all arguments and a NULL.
static int run_with(const struct verb *verb, int argc, char **argv, const char **operands)
{
    struct option_value values[VERB_MAX_OPTIONS] = {0};
    struct option_parse parse = {
        .verb = verb->name,
        .options = verb->options,
        .option_count = verb->option_count,
        .values = values,
        .positional = operands,
        .positional_max = verb->many ? argc : 1,
    };
    if (!options_parse(&parse, argc, argv))
        return EXIT_CODE_USAGE;
    if (parse.help) {
        print_verb_help(verb);
        return report_finish(WEFT_OK);
    }
    if (parse.writes_stdout)
        report_keep_stdout();
    command_catch_signals();
    const int code = verb->run(operands, values);
    ending_finish();
    return code;
}

static int run_verb(const struct verb *verb, int argc, char **argv)
{
    const char **operands = calloc((size_t)argc + 2, sizeof *operands);
    if (!operands)
        return report_finish(WEFT_ERR_MEMORY);
    const int code = run_with(verb, argc, argv, operands);
    free(operands);
    return code;
}

void command_fill_streams(void)
{
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY) != fd)
            _exit(EXIT_CODE_FAILED);
}

bool command_distributes(int argc, char **argv)
{
    const struct verb *verb = argc > 1 ? find_verb(argv[1]) : NULL;
    return verb && verb->distributes;
}

int command_main(int argc, char **argv)
{
    if (!ranks_tells() && !command_distributes(argc, argv))
        return EXIT_CODE_DONE;
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "--version") == 0) {
        printf("weft %s\n", weft_version());
        return report_finish(WEFT_OK);
    }
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 ||
        (strcmp(name, "help") == 0 && (argc == 2 || strcmp(argv[2], "help") == 0))) {
        print_help();
        return report_finish(WEFT_OK);
    }
    bool help = strcmp(name, "help") == 0;
    const struct verb *verb = find_verb(help ? argv[2] : name);
    if (!verb)
        return unknown_verb(help ? argv[2] : name);
    if (help) {
        print_verb_help(verb);
        return report_finish(WEFT_OK);
    }
    return run_verb(verb, argc - 2, argv + 2);
}
