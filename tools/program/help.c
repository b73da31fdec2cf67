// SPDX-License-Identifier: BSD-3-Clause
#include "tools/program/help.h"

#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"

const struct verb *const help_verbs[] = {
    &verb_slice,    &verb_probe,    &verb_lattice,   &verb_convert,    &verb_make,      &verb_info,
    &verb_resample, &verb_effect,   &verb_antialias, &verb_accumulate, &verb_kernel,    &verb_table,
    &verb_plan,     &verb_validate, &verb_chart,     &verb_stability,  &verb_calibrate, NULL,
};
enum { VERB_COUNT = sizeof help_verbs / sizeof *help_verbs - 1 };

const struct verb *help_find_verb(const char *name)
{
    for (int i = 0; help_verbs[i]; i++)
        if (strcmp(help_verbs[i]->name, name) == 0)
            return help_verbs[i];
    return NULL;
}

static void print_verbs(enum verb_group group)
{
    printf("\n%s:\n", help_group_names[group]);
    for (int i = 0; help_verbs[i]; i++)
        if (help_verbs[i]->group == group)
            printf("  %-10s %s\n", help_verbs[i]->name, help_verbs[i]->summary);
}

static void print_entries(const char *title, const struct help_entry *entries)
{
    printf("\n%s:\n", title);
    for (; entries->name; entries++) {
        printf("  %s\n", entries->name);
        options_print_wrapped(entries->text, 6);
    }
}

void help_print(bool all)
{
    printf("weft - %s\n\nusage: weft VERB ...\n", help_summary);
    for (int group = 0; group < VERB_GROUPS; group++)
        print_verbs((enum verb_group)group);
    puts("\nweft help VERB, weft VERB --help   what a verb does, and its main options\n"
         "weft VERB --help=all               all of them\n"
         "weft help all                      exit codes, outputs, environment\n"
         "weft version                       versions, back ends and engines");
    if (!all)
        return;
    print_entries("exit codes", help_exit_codes);
    print_entries("environment", help_environment);
    for (int i = 0; help_rules[i]; i++) {
        putchar('\n');
        options_print_wrapped(help_rules[i], 0);
    }
}

// At most `most` of them.
static void print_examples(const struct verb *verb, int most)
{
    if (!verb->examples)
        return;
    putchar('\n');
    for (int i = 0; i < most && verb->examples[i]; i++)
        printf("  %s\n", verb->examples[i]);
}

static void print_usage(const struct verb *verb)
{
    char text[256];
    snprintf(text, sizeof text, "usage: weft %s %s", verb->name, verb->usage);
    options_print_wrapped(text, 0);
    putchar('\n');
}

static void print_brief(const struct verb *verb)
{
    print_usage(verb);
    options_print_wrapped(verb->description, 0);
    putchar('\n');
    const int others = options_print_brief(verb->options, verb->option_count);
    print_examples(verb, 2);
    printf("\nweft %s --help=all tells all of it", verb->name);
    if (others)
        printf(", and %d more options", others);
    puts("");
}

static void print_all(const struct verb *verb)
{
    print_usage(verb);
    options_print_wrapped(verb->description, 0);
    options_print_all(verb->options, verb->option_count);
    for (int i = 0; verb->epilogue && verb->epilogue[i]; i++) {
        putchar('\n');
        options_print_wrapped(verb->epilogue[i], 0);
    }
    print_examples(verb, 100);
    if (verb->print_catalogue) {
        putchar('\n');
        verb->print_catalogue();
    }
}

void help_print_verb(const struct verb *verb, bool all)
{
    if (all)
        print_all(verb);
    else
        print_brief(verb);
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
    const char *names[VERB_COUNT + VERB_ALIASES + 3] = {"help", "version"};
    int count = 2;
    for (int i = 0; help_verbs[i]; i++)
        names[count++] = help_verbs[i]->name;
    for (int i = 0; i < VERB_ALIASES; i++)
        names[count++] = verb_aliases[i].name;
    const char *found = weft_closest_find(name, strlen(name), names);
    for (int i = 0; found && i < VERB_ALIASES; i++)
        if (found == verb_aliases[i].name)
            return verb_aliases[i].verb;
    return found;
}

void help_report_unknown_verb(const char *name)
{
    char names[256] = "";
    for (int i = 0; help_verbs[i]; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s, ", help_verbs[i]->name);
    }
    const char *meant = suggest_verb(name);
    if (name[0] == '-' && name[1])
        report_error("'%s' stands before the verb: it is weft VERB [options], as in weft slice "
                     "VOLUME -o OUT.exr; there are: %shelp",
                     name, names);
    else if (strpbrk(name, "./"))
        report_error("'%s' is no verb: it is weft VERB FILE, as in weft info %s; there are: %shelp",
                     name, name, names);
    else if (!*name)
        report_error("no verb given; there are: %shelp (see weft --help)", names);
    else if (meant)
        report_error("unknown verb '%s'; did you mean %s? There are: %shelp", name, meant, names);
    else
        report_error("unknown verb '%s'; there are: %shelp", name, names);
}
