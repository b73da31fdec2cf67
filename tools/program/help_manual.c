// SPDX-License-Identifier: BSD-3-Clause
// Manual pages in the macros of man(7).
#include "tools/program/help.h"

#include <stdio.h>
#include <string.h>

enum { FORM_TEXT = 320 };

// Text in which nothing is a request or an escape of roff.
static void put(const char *text)
{
    if (*text == '.' || *text == '\'')
        fputs("\\&", stdout);
    for (; *text; text++) {
        if (*text == '\\')
            fputs("\\e", stdout);
        else if (*text == '-')
            fputs("\\-", stdout);
        else
            putchar(*text);
    }
}

static void put_line(const char *text)
{
    put(text);
    putchar('\n');
}

static void put_paragraph(const char *text)
{
    puts(".PP");
    put_line(text);
}

static void put_entries(const char *title, const struct help_entry *entries)
{
    printf(".SH %s\n", title);
    for (; entries->name; entries++) {
        printf(".TP\n.B ");
        put_line(entries->name);
        put_line(entries->text);
    }
}

static void put_option(const struct option_spec *spec)
{
    char value[FORM_TEXT];
    options_format_value(spec, value, sizeof value);
    fputs(".TP\n", stdout);
    if (spec->letter)
        printf("\\fB\\-%c\\fR, ", spec->letter);
    fputs("\\fB", stdout);
    put("--");
    put(spec->name);
    fputs("\\fR", stdout);
    if (*value) {
        fputs(spec->optional ? "[=\\fI" : " \\fI", stdout);
        put(value);
        fputs(spec->optional ? "\\fR]" : "\\fR", stdout);
    }
    putchar('\n');
    put_line(spec->help);
}

static void put_options(const struct verb *verb)
{
    puts(".SH OPTIONS");
    for (int group = 0; group < OPTION_GROUPS; group++) {
        bool titled = false;
        for (int i = 0; i < verb->option_count; i++) {
            if ((int)verb->options[i].group != group)
                continue;
            if (!titled)
                printf(".SS %s\n", option_group_names[group]);
            titled = true;
            put_option(&verb->options[i]);
        }
    }
}

static void put_examples(const char *const *examples)
{
    puts(".SH EXAMPLES");
    for (; *examples; examples++) {
        puts(".PP\n.EX");
        put_line(*examples);
        puts(".EE");
    }
}

static void put_head(const char *title, const char *name, const char *summary)
{
    printf(".TH %s 1 \"\" \"weft %s\" \"weft manual\"\n.SH NAME\n%s \\- ", title, weft_version(),
           name);
    put_line(summary);
}

static void put_see_also(const struct verb *but)
{
    puts(".SH SEE ALSO");
    if (but)
        printf(".BR weft (1)%s\n", help_verbs[0] ? "," : "");
    for (int i = 0; help_verbs[i]; i++)
        if (help_verbs[i] != but)
            printf(".BR weft\\-%s (1)%s\n", help_verbs[i]->name,
                   help_verbs[i + 1] && !(help_verbs[i + 1] == but && !help_verbs[i + 2]) ? ","
                                                                                          : "");
}

static void print_verb(const struct verb *verb)
{
    char title[64] = "WEFT\\-", name[64];
    for (size_t i = 0, at = strlen(title); verb->name[i]; i++, at++) {
        title[at] = (char)(verb->name[i] - 'a' + 'A');
        title[at + 1] = 0;
    }
    snprintf(name, sizeof name, "weft\\-%s", verb->name);
    put_head(title, name, verb->summary);
    printf(".SH SYNOPSIS\n.B weft %s\n", verb->name);
    put_line(verb->usage);
    puts(".SH DESCRIPTION");
    put_line(verb->description);
    for (int i = 0; verb->epilogue && verb->epilogue[i]; i++)
        put_paragraph(verb->epilogue[i]);
    put_options(verb);
    if (verb->examples)
        put_examples(verb->examples);
    put_entries("EXIT STATUS", help_exit_codes);
    put_entries("ENVIRONMENT", help_environment);
    put_see_also(verb);
}

static void print_weft(void)
{
    put_head("WEFT", "weft", help_summary);
    puts(".SH SYNOPSIS\n.B weft\n.I VERB\n[operands] [options]\n.SH DESCRIPTION");
    put_line("Each verb has a page of its own, and weft VERB --help tells its main options.");
    for (int group = 0; group < VERB_GROUPS; group++) {
        printf(".SS %s\n", help_group_names[group]);
        for (int i = 0; help_verbs[i]; i++) {
            if ((int)help_verbs[i]->group != group)
                continue;
            printf(".TP\n.BR weft\\-%s (1)\n", help_verbs[i]->name);
            put_line(help_verbs[i]->summary);
        }
    }
    puts(".SH NOTES");
    for (int i = 0; help_rules[i]; i++)
        put_paragraph(help_rules[i]);
    put_entries("EXIT STATUS", help_exit_codes);
    put_entries("ENVIRONMENT", help_environment);
    put_see_also(NULL);
}

void help_print_manual(const struct verb *verb)
{
    if (verb)
        print_verb(verb);
    else
        print_weft();
}
