// SPDX-License-Identifier: BSD-3-Clause
#include "tools/program/command.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/ending.h"
#include "tools/common/json.h"
#include "tools/common/numbered.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/standard_input.h"
#include "tools/program/help.h"
#include "tools/program/version.h"
#include "tools/ranks/guard.h"
#include "tools/ranks/ranks.h"

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

static bool is_given(const struct verb *verb, const struct option_value *values, const char *name)
{
    for (int i = 0; i < verb->option_count; i++)
        if (strcmp(verb->options[i].name, name) == 0)
            return values[i].given;
    return false;
}

// What documents tell of files: operands and options that name inputs, and outputs. Those of
// numbered names are added where they are written.
static void name_files(const struct verb *verb, const char *const *operands,
                       const struct option_value *values)
{
    const bool writes = !is_given(verb, values, "explain");
    for (int i = 0; operands[i]; i++) {
        if (verb->writes_last && i && !operands[i + 1])
            json_add_output(operands[i]);
        else if (verb->operand_names & OPTION_NAMES_FILE)
            json_add_input(operands[i]);
    }
    for (int i = 0; i < verb->option_count; i++) {
        const struct option_spec *spec = &verb->options[i];
        const char *text = values[i].text;
        if (!text || spec->optional)
            continue;
        if (spec->type == OPTION_TEXT && spec->names & OPTION_NAMES_FILE)
            json_add_input(text);
        else if (spec->type == OPTION_OUTPUT && writes && !numbered_is(text))
            json_add_output(text);
    }
}

// --threads is of all that the process does, and of the programs that it starts.
static enum weft_result limit_threads(const struct verb *verb, const struct option_value *values)
{
    char text[16];
    int threads = 0;
    for (int i = 0; i < verb->option_count; i++)
        if (strcmp(verb->options[i].name, "threads") == 0 &&
            options_read_whole(&values[i], "threads", 1, WEFT_CPU_MAX_THREADS, &threads) != WEFT_OK)
            return WEFT_ERR_ARGUMENT;
    snprintf(text, sizeof text, "%d", threads);
    return threads && setenv("WEFT_THREADS", text, 1) != 0 ? WEFT_ERR_MEMORY : WEFT_OK;
}

// The file of --json=FILE: no other file of the command line, and one that could be written.
static enum weft_result check_report(const struct verb *verb, const char *const *operands,
                                     const struct option_value *values)
{
    struct paths_output output[VERB_MAX_OPTIONS];
    char names[VERB_MAX_OPTIONS][40];
    const char *path = NULL, *input[VERB_MAX_OPTIONS];
    int outputs = 0, inputs = 0;
    for (int i = 0; i < verb->option_count; i++) {
        const struct option_spec *spec = &verb->options[i];
        if (spec->optional)
            path = values[i].text;
        snprintf(names[i], sizeof names[i], "--%s", spec->name);
        if (values[i].text && spec->type == OPTION_OUTPUT)
            output[outputs++] = (struct paths_output){names[i], values[i].text};
        else if (values[i].text && spec->type == OPTION_TEXT)
            input[inputs++] = values[i].text;
    }
    json_set_report(verb->name, path);
    if (!path)
        return WEFT_OK;
    enum weft_result res = paths_check_distinct(output, outputs, input, inputs);
    for (int i = 0; operands[i] && res == WEFT_OK; i++)
        res = paths_check_distinct(output, outputs, &operands[i], 1);
    return res == WEFT_OK ? paths_check_output(path, false) : res;
}

// "-" becomes a name that can be opened.
static enum weft_result take_stdin(const struct verb *verb, const char **operands)
{
    static const char *const name = "/dev/stdin";
    const char **at = operands;
    while (*at && strcmp(*at, "-") != 0)
        at++;
    if (!verb->reads_stdin || !*at)
        return WEFT_OK;
    *at = name;
    return standard_input_take();
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
        help_print_verb(verb, parse.help == OPTION_HELP_ALL);
        return report_finish(WEFT_OK);
    }
    if (parse.writes_stdout)
        report_keep_stdout();
    command_catch_signals();
    enum weft_result res = check_report(verb, operands, values);
    if (res == WEFT_OK)
        res = limit_threads(verb, values);
    if (res == WEFT_OK)
        res = take_stdin(verb, operands);
    if (res != WEFT_OK)
        return report_finish(res);
    name_files(verb, operands, values);
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
    const struct verb *verb = argc > 1 ? help_find_verb(argv[1]) : NULL;
    return verb && verb->distributes;
}

static bool is_any(const char *word, const char *a, const char *b, const char *c)
{
    return strcmp(word, a) == 0 || strcmp(word, b) == 0 || strcmp(word, c) == 0;
}

// "weft help", with what stands behind it; words end with NULL.
static int run_help(char **words)
{
    const char *name = words[0] ? words[0] : "help";
    const bool manual = strcmp(name, "--man") == 0;
    if (strcmp(name, "--completion") == 0)
        return help_print_completion(words[1] ? words[1] : "") ? report_finish(WEFT_OK)
                                                               : EXIT_CODE_USAGE;
    const char *of = manual ? words[1] : name;
    const struct verb *verb = of ? help_find_verb(of) : NULL;
    const bool all = is_any(name, "all", "--all", "--help=all");
    if (of && strcmp(of, "version") == 0) {
        version_print_help();
        return report_finish(WEFT_OK);
    }
    if (of && !verb && !all && !is_any(of, "help", "--help", "-h")) {
        help_report_unknown_verb(of);
        return EXIT_CODE_USAGE;
    }
    if (manual)
        help_print_manual(verb);
    else if (verb)
        help_print_verb(verb, words[1] && is_any(words[1], "all", "--all", "--help=all"));
    else
        help_print(all);
    return report_finish(WEFT_OK);
}

int command_main(int argc, char **argv)
{
    if (!ranks_tells() && !command_distributes(argc, argv))
        return EXIT_CODE_DONE;
    const char *name = argc > 1 ? argv[1] : "";
    if (is_any(name, "--version", "version", "-V"))
        return version_run(argv + 2);
    if (is_any(name, "--help", "help", "-h"))
        return run_help(argv + 2);
    if (strcmp(name, "--help=all") == 0)
        return run_help(argv + 1);
    const struct verb *verb = help_find_verb(name);
    if (verb)
        return run_verb(verb, argc - 2, argv + 2);
    help_report_unknown_verb(name);
    return EXIT_CODE_USAGE;
}
