// SPDX-License-Identifier: BSD-3-Clause
#include "tools/options/options.h"

#include <stdio.h>
#include <string.h>

enum { COLUMNS = 79, BRIEF_COLUMN = 30, FORM_TEXT = 320 };

const char *const option_group_names[OPTION_GROUPS] = {
    [OPTION_TASK] = "what is done",
    [OPTION_FILES] = "files",
    [OPTION_GEOMETRY] = "planes, sizes and frames",
    [OPTION_FILTER] = "filter",
    [OPTION_METHOD] = "method and accuracy",
    [OPTION_PICTURES] = "previews and plots",
    [OPTION_RESOURCES] = "memory, threads and ranks",
    [OPTION_REPORTS] = "reports",
};

void options_print_wrapped(const char *text, int indent)
{
    int column = 0;
    while (*text) {
        size_t size = strcspn(text, " ");
        if (column && column + 1 + (int)size > COLUMNS) {
            putchar('\n');
            column = 0;
        }
        column += printf("%*s%.*s", column ? 1 : indent, "", (int)size, text);
        text += size + strspn(text + size, " ");
    }
    putchar('\n');
}

// "  -o, --output OUT.exr"
static void format_option(const struct option_spec *spec, char *out, size_t size)
{
    char letter[5] = "    ", value[FORM_TEXT - 64];
    if (spec->letter)
        snprintf(letter, sizeof letter, "-%c, ", spec->letter);
    options_format_value(spec, value, sizeof value);
    snprintf(out, size, "  %s--%s%s%s%s", letter, spec->name,
             !*value          ? ""
             : spec->optional ? "[="
                              : " ",
             value, spec->optional ? "]" : "");
}

// The form is cut where the text begins, at a place where it is still understood.
static void print_brief(const struct option_spec *spec)
{
    char form[FORM_TEXT];
    format_option(spec, form, sizeof form);
    const size_t least = strlen("  -x, --") + strlen(spec->name);
    if (strlen(form) > BRIEF_COLUMN - 2) {
        char *cut = form + BRIEF_COLUMN - 2;
        while (cut > form + least && !strchr("|, [", *cut))
            cut--;
        strcpy(cut > form + least ? cut : form + least, cut > form + least + 1 ? "..." : "");
    }
    printf("%-*s %s\n", BRIEF_COLUMN, form, spec->brief);
}

int options_print_brief(const struct option_spec *options, int option_count)
{
    int others = 0;
    for (int group = 0; group < OPTION_GROUPS; group++)
        for (int i = 0; i < option_count; i++) {
            if ((int)options[i].group != group)
                continue;
            if (options[i].brief)
                print_brief(&options[i]);
            else
                others++;
        }
    return others;
}

static void print_group(const struct option_spec *options, int option_count, int group)
{
    bool titled = false;
    for (int i = 0; i < option_count; i++) {
        char form[FORM_TEXT];
        if ((int)options[i].group != group)
            continue;
        if (!titled)
            printf("\n%s:\n", option_group_names[group]);
        titled = true;
        format_option(&options[i], form, sizeof form);
        puts(form);
        options_print_wrapped(options[i].help, 10);
    }
}

void options_print_all(const struct option_spec *options, int option_count)
{
    for (int group = 0; group < OPTION_GROUPS; group++)
        print_group(options, option_count, group);
}
