// SPDX-License-Identifier: BSD-3-Clause
// Completion by the shells: verbs, options, and what may be their values. Grids are asked of the
// file that stands on the command line, everything else is known here.
#include "tools/program/help.h"

#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"

enum { FORM_TEXT = 320 };

// One of the shells' ways of saying it.
struct shell {
    const char *name;
    void (*begin)(void);
    void (*verb)(const struct verb *verb);
    void (*end)(void);
};

// A few words of what an option does, with nothing that quotes mean.
static void put_description(const struct option_spec *spec)
{
    const char *text = spec->brief ? spec->brief : spec->help;
    for (int i = 0; text[i] && i < 60; i++)
        putchar(strchr("'\"[]:`$\\", text[i]) ? ' ' : text[i]);
}

static void put_kernels(void)
{
    for (int i = 0; weft_kernel_list[i]; i++)
        printf("%s%s", i ? " " : "", weft_kernel_list[i]->name);
}

static void put_profiles(void)
{
    for (int i = 0; weft_profile_list[i]; i++)
        printf("%s%s", i ? " " : "", weft_profile_list[i]->name);
}

static void put_maps(void)
{
    for (int i = 0; weft_colour_map_list[i]; i++)
        printf("%s%s", i ? " " : "", weft_colour_map_list[i]->name);
}

static bool is_file(const struct option_spec *spec)
{
    return spec->type == OPTION_OUTPUT || spec->names & OPTION_NAMES_FILE;
}

static void put_choices(const struct option_spec *spec)
{
    for (int i = 0; spec->choices[i] && (!spec->choice_count || i < spec->choice_count); i++)
        printf("%s%s", i ? " " : "", spec->choices[i]);
}

// The words that may be a value; false: it is none of a list.
static bool put_words(const struct option_spec *spec)
{
    if (spec->type == OPTION_CHOICE)
        put_choices(spec);
    else if (spec->names & OPTION_NAMES_KERNEL)
        put_kernels();
    else if (spec->names & OPTION_NAMES_PROFILE)
        put_profiles();
    else if (spec->names & OPTION_NAMES_MAP)
        put_maps();
    else
        return false;
    return true;
}

static bool has_words(const struct option_spec *spec)
{
    return spec->type == OPTION_CHOICE ||
           spec->names & (OPTION_NAMES_KERNEL | OPTION_NAMES_PROFILE | OPTION_NAMES_MAP);
}

// ---- bash ---------------------------------------------------------------------------------------

static void begin_bash(void)
{
    puts("# bash completion for weft; made by weft help --completion bash\n"
         "_weft_grids() {\n"
         "    local word\n"
         "    for word in \"${COMP_WORDS[@]:2}\"; do\n"
         "        [ -f \"$word\" ] || continue\n"
         "        weft info \"$word\" --json 2>/dev/null |\n"
         "            sed -n 's/^      \"name\": \"\\(.*\\)\",$/\\1/p'\n"
         "        return\n"
         "    done\n"
         "}\n"
         "_weft() {\n"
         "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} words= names=\n"
         "    COMPREPLY=()\n"
         "    if [ \"$cur\" = = ]; then cur=; fi\n"
         "    if [ \"$prev\" = = ]; then prev=${COMP_WORDS[COMP_CWORD-2]}; fi");
    fputs("    local verbs='", stdout);
    for (int i = 0; help_verbs[i]; i++)
        printf("%s ", help_verbs[i]->name);
    puts("help version'\n"
         "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "        COMPREPLY=($(compgen -W \"$verbs --help --version\" -- \"$cur\"))\n"
         "        return\n"
         "    fi\n"
         "    case ${COMP_WORDS[1]} in\n"
         "    help) COMPREPLY=($(compgen -W \"$verbs\" -- \"$cur\")); return ;;");
}

static void put_bash_names(const struct option_spec *spec)
{
    if (spec->letter)
        printf("-%c|", spec->letter);
    printf("--%s", spec->name);
}

static void put_bash_value(const struct option_spec *spec)
{
    if (!has_words(spec) && !is_file(spec) && !(spec->names & OPTION_NAMES_GRID))
        return;
    fputs("        ", stdout);
    put_bash_names(spec);
    if (has_words(spec)) {
        fputs(") words='", stdout);
        put_words(spec);
        puts("' ;;");
    } else {
        puts(is_file(spec) ? ") COMPREPLY=($(compgen -f -- \"$cur\")); return ;;"
                           : ") words=$(_weft_grids) ;;");
    }
}

// What takes a value and is of no list is not completed.
static void put_bash_others(const struct verb *verb)
{
    bool any = false;
    for (int i = 0; i < verb->option_count; i++) {
        const struct option_spec *spec = &verb->options[i];
        if (spec->type == OPTION_FLAG || spec->optional || has_words(spec) || is_file(spec) ||
            spec->names & OPTION_NAMES_GRID)
            continue;
        fputs(any ? "|" : "        ", stdout);
        put_bash_names(spec);
        any = true;
    }
    if (any)
        puts(") return ;;");
}

static void put_bash_verb(const struct verb *verb)
{
    printf("    %s)\n        names='", verb->name);
    for (int i = 0; i < verb->option_count; i++)
        printf("--%s ", verb->options[i].name);
    puts("--help'\n        case $prev in");
    for (int i = 0; i < verb->option_count; i++)
        if (!verb->options[i].optional)
            put_bash_value(&verb->options[i]);
    put_bash_others(verb);
    if (verb->operand_names & OPTION_NAMES_KERNEL) {
        fputs("        *) [ \"${cur#-}\" != \"$cur\" ] || words='", stdout);
        put_kernels();
        puts("' ;;");
    }
    puts("        esac ;;");
}

static void end_bash(void)
{
    puts("    esac\n"
         "    if [ -n \"$words\" ]; then\n"
         "        COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
         "    elif [ \"${cur#-}\" != \"$cur\" ]; then\n"
         "        COMPREPLY=($(compgen -W \"$names\" -- \"$cur\"))\n"
         "    else\n"
         "        COMPREPLY=($(compgen -f -- \"$cur\"))\n"
         "    fi\n"
         "}\n"
         "complete -o filenames -F _weft weft");
}

// ---- zsh ----------------------------------------------------------------------------------------

static void begin_zsh(void)
{
    puts("#compdef weft\n"
         "# zsh completion for weft; made by weft help --completion zsh\n"
         "_weft_grids() {\n"
         "    local word\n"
         "    for word in ${(Q)words[2,-1]}; do\n"
         "        [[ -f $word ]] || continue\n"
         "        compadd -- ${(f)\"$(weft info $word --json 2>/dev/null |\n"
         "            sed -n 's/^      \"name\": \"\\(.*\\)\",$/\\1/p')\"}\n"
         "        return\n"
         "    done\n"
         "}\n"
         "_weft() {\n"
         "    local -a verbs\n"
         "    verbs=(");
    for (int i = 0; help_verbs[i]; i++) {
        printf("        '%s:", help_verbs[i]->name);
        for (const char *at = help_verbs[i]->summary; *at; at++)
            putchar(strchr("':`$\\", *at) ? ' ' : *at);
        puts("'");
    }
    puts("        'help:what a verb does' 'version:versions, back ends and engines')\n"
         "    if (( CURRENT == 2 )); then\n"
         "        _describe verb verbs\n"
         "        return\n"
         "    fi\n"
         "    local verb=$words[2]\n"
         "    shift words\n"
         "    (( CURRENT-- ))\n"
         "    case $verb in\n"
         "    help) _describe verb verbs ;;");
}

static void put_zsh_action(const struct option_spec *spec)
{
    if (spec->type == OPTION_FLAG)
        return;
    printf("%svalue:", spec->optional ? "::" : ":");
    if (has_words(spec)) {
        putchar('(');
        put_words(spec);
        putchar(')');
    } else {
        fputs(is_file(spec)                     ? "_files"
              : spec->names & OPTION_NAMES_GRID ? "_weft_grids"
                                                : " ",
              stdout);
    }
}

static void put_zsh_option(const struct option_spec *spec)
{
    const bool value = spec->type != OPTION_FLAG;
    if (spec->letter) {
        printf("            '-%c%s[", spec->letter, value ? "+" : "");
        put_description(spec);
        putchar(']');
        put_zsh_action(spec);
        puts("' \\");
    }
    printf("            '--%s%s[", spec->name, spec->optional ? "=-" : value ? "=" : "");
    put_description(spec);
    putchar(']');
    put_zsh_action(spec);
    puts("' \\");
}

static void put_zsh_verb(const struct verb *verb)
{
    printf("    %s)\n        _arguments -s -S \\\n", verb->name);
    for (int i = 0; i < verb->option_count; i++)
        put_zsh_option(&verb->options[i]);
    fputs("            '--help=-[what it does]::all:(all)' '*:operand:", stdout);
    if (verb->operand_names & OPTION_NAMES_KERNEL) {
        putchar('(');
        put_kernels();
        putchar(')');
    } else {
        fputs("_files", stdout);
    }
    puts("' ;;");
}

static void end_zsh(void)
{
    puts("    esac\n"
         "}\n"
         "_weft \"$@\"");
}

// ---- fish ---------------------------------------------------------------------------------------

static void begin_fish(void)
{
    puts("# fish completion for weft; made by weft help --completion fish\n"
         "function __weft_grids\n"
         "    for word in (commandline -opc)[3..-1]\n"
         "        test -f \"$word\"; or continue\n"
         "        weft info \"$word\" --json 2>/dev/null |\n"
         "            sed -n 's/^      \"name\": \"\\(.*\\)\",$/\\1/p'\n"
         "        return\n"
         "    end\n"
         "end\n"
         "complete -c weft -n __fish_use_subcommand -f -a help -d 'what a verb does'\n"
         "complete -c weft -n __fish_use_subcommand -f -a version -d 'versions and back ends'");
}

static void put_fish_option(const char *verb, const struct option_spec *spec)
{
    printf("complete -c weft -n '__fish_seen_subcommand_from %s' -l %s", verb, spec->name);
    if (spec->letter)
        printf(" -s %c", spec->letter);
    if (has_words(spec)) {
        fputs(" -x -a '", stdout);
        put_words(spec);
        putchar('\'');
    } else if (spec->names & OPTION_NAMES_GRID) {
        fputs(" -x -a '(__weft_grids)'", stdout);
    } else if (is_file(spec)) {
        fputs(spec->optional ? "" : " -r -F", stdout);
    } else if (spec->type != OPTION_FLAG) {
        fputs(" -x", stdout);
    }
    fputs(" -d '", stdout);
    put_description(spec);
    puts("'");
}

static void put_fish_verb(const struct verb *verb)
{
    printf("complete -c weft -n __fish_use_subcommand -f -a %s -d '", verb->name);
    for (const char *at = verb->summary; *at; at++)
        putchar(*at == '\'' ? ' ' : *at);
    puts("'");
    for (int i = 0; i < verb->option_count; i++)
        put_fish_option(verb->name, &verb->options[i]);
    if (verb->operand_names & OPTION_NAMES_KERNEL) {
        printf("complete -c weft -n '__fish_seen_subcommand_from %s' -f -a '", verb->name);
        put_kernels();
        puts("'");
    }
}

static void end_fish(void)
{
}

bool help_print_completion(const char *name)
{
    static const struct shell shells[] = {{"bash", begin_bash, put_bash_verb, end_bash},
                                          {"zsh", begin_zsh, put_zsh_verb, end_zsh},
                                          {"fish", begin_fish, put_fish_verb, end_fish}};
    for (size_t i = 0; i < sizeof shells / sizeof *shells; i++) {
        if (strcmp(shells[i].name, name) != 0)
            continue;
        shells[i].begin();
        for (int v = 0; help_verbs[v]; v++)
            shells[i].verb(help_verbs[v]);
        shells[i].end();
        return true;
    }
    report_error("weft help --completion %s: it is bash, zsh or fish", name);
    return false;
}
