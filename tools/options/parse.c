// SPDX-License-Identifier: BSD-3-Clause
// The words are getopt_long's to take apart; what is said of wrong ones is ours.
#include "tools/options/options.h"

#include <ctype.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"

const char *const options_json_endings[] = {".json", NULL};

// What getopt_long returns for the option of a place in the table; letters are themselves.
enum { FIRST_LONG = 256, MAX_OPTIONS = 96, MAX_NAMES = 160, FORM_TEXT = 320 };

static int find_long(const struct option_parse *parse, const char *name, size_t length)
{
    for (int i = 0; i < parse->option_count; i++)
        if (strlen(parse->options[i].name) == length &&
            memcmp(parse->options[i].name, name, length) == 0)
            return i;
    return -1;
}

// What options are called elsewhere.
static const struct {
    const char *name, *option;
} option_aliases[] = {
    {"filter", "kernel"},
    {"interpolation", "kernel"},
    {"interp", "kernel"},
    {"method", "kernel"},
    {"out", "output"},
    {"resize", "size"},
    {"width", "size"},
    {"height", "size"},
    {"resolution", "size"},
    {"colormap", "colour-map"},
    {"cmap", "colour-map"},
    {"palette", "colour-map"},
    {"tolerance", "max-error"},
    {"png", "preview"},
    {"dry-run", "explain"},
    {"check", "verify"},
    {"silent", "quiet"},
    {"debug", "verbose"},
    {"percent", "size"},
    {"field", "grid"},
    {"channel", "channels"},
    {"variable", "grid"},
    {"attribute", "grid"},
    {"slice", "at"},
    {"z", "at"},
    {"y", "at"},
    {"x", "at"},
    {"position", "at"},
    {"normal", "axis"},
    {"orientation", "axis"},
    {"start", "frames"},
    {"precision", "type"},
    {"depth", "type"},
    {"jobs", "threads"},
    {"cores", "threads"},
    {"device", "engine"},
    {"backend", "engine"},
    {"gpu", "engine"},
    {"edge", "boundary"},
    {"wrap", "boundary"},
    {"border", "boundary"},
    {"virtual-pixel", "boundary"},
    {"colour", "colour-map"},
    {"color", "colour-map"},
    {"color-map", "colour-map"},
    {"vmin", "range"},
    {"vmax", "range"},
    {"clim", "range"},
};
enum { OPTION_ALIASES = sizeof option_aliases / sizeof *option_aliases };

// The option of this verb that the first `length` bytes of name are near to; NULL: none.
static const char *suggest_option(const struct option_parse *parse, const char *name, size_t length)
{
    const char *names[MAX_NAMES] = {NULL}, *meant[MAX_NAMES];
    int count = 0;
    for (int i = 0; i < parse->option_count && count < MAX_NAMES - 1; i++, count++)
        names[count] = meant[count] = parse->options[i].name;
    for (int i = 0; i < OPTION_ALIASES && count < MAX_NAMES - 1; i++) {
        const char *option = option_aliases[i].option;
        if (find_long(parse, option, strlen(option)) < 0)
            continue;
        names[count] = option_aliases[i].name;
        meant[count++] = option;
    }
    const char *found = weft_closest_find(name, length, names);
    for (int i = 0; found && i < count; i++)
        if (names[i] == found)
            return meant[i];
    return NULL;
}

// The names that start so, as "--space or --split"; how many there are.
static int list_starts(const struct option_parse *parse, const char *name, size_t length,
                       char *text, size_t size)
{
    int count = 0;
    *text = 0;
    for (int i = 0; i < parse->option_count; i++) {
        if (strncmp(parse->options[i].name, name, length) != 0)
            continue;
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "%s--%s", count++ ? ", " : "", parse->options[i].name);
    }
    return count;
}

static void report_unknown(const struct option_parse *parse, const char *arg)
{
    const char *name = arg + (arg[1] == '-' ? 2 : 1);
    const size_t length = strcspn(name, "=");
    char starts[256];
    if (arg[1] == '-' && list_starts(parse, name, length, starts, sizeof starts) > 1) {
        report_error("'%s' may be any of %s", arg, starts);
        return;
    }
    const char *meant =
        arg[1] == '-' || strlen(arg) > 2 ? suggest_option(parse, name, length) : NULL;
    if (meant)
        report_error("unknown option '%s'; did you mean --%s? (weft help %s lists them)", arg,
                     meant, parse->verb);
    else
        report_error("unknown option '%s' (weft help %s lists them)", arg, parse->verb);
}

static bool looks_like_option(const char *text)
{
    return text[0] == '-' && text[1] && !isdigit((unsigned char)text[1]) && text[1] != '.';
}

// "-x" is a value where the option's form, "x|-x|y", has it.
static bool is_in_form(const struct option_spec *spec, const char *text)
{
    const size_t length = strlen(text);
    for (const char *at = spec->value; at; at = strchr(at, '|') ? strchr(at, '|') + 1 : NULL)
        if (strcspn(at, "|") == length && strncmp(at, text, length) == 0)
            return true;
    return false;
}

static bool report_missing(const struct option_spec *spec)
{
    char form[FORM_TEXT];
    options_format_value(spec, form, sizeof form);
    report_error("--%s needs a value: --%s %s", spec->name, spec->name, form);
    return false;
}

// text: NULL where the value is left out.
static bool take_option(struct option_parse *parse, int index, const char *text)
{
    const struct option_spec *spec = &parse->options[index];
    struct option_value *value = &parse->values[index];
    if (spec->type == OPTION_FLAG) {
        value->given = true;
        return true;
    }
    if (value->given) {
        report_error("--%s is given twice", spec->name);
        return false;
    }
    value->given = true;
    if (text && !options_read_value(parse, spec, text, value))
        return false;
    if (spec->optional && paths_is_stdout(value->text))
        value->text = NULL; // as if it were left out
    return true;
}

// The first operand too many, and the word before it (NULL: behind "--"). It is told last: what
// options say may be why.
struct surplus {
    const char *text, *before;
};

// The dashes that text processors make of '-'.
static bool starts_with_foreign_dash(const char *text)
{
    static const char *const dashes[] = {"\u2010", "\u2011", "\u2012",
                                         "\u2013", "\u2014", "\u2212"};
    for (size_t i = 0; i < sizeof dashes / sizeof *dashes; i++)
        if (strncmp(text, dashes[i], strlen(dashes[i])) == 0)
            return true;
    return false;
}

static bool take_operand(struct option_parse *parse, const char *text, const char *before,
                         struct surplus *surplus)
{
    if (before && starts_with_foreign_dash(text)) {
        report_error("'%s' starts with a dash that is not '-' (behind -- or ./ it is a file)",
                     text);
        return false;
    }
    if (parse->positional_count < parse->positional_max)
        parse->positional[parse->positional_count++] = text;
    else if (!surplus->text)
        *surplus = (struct surplus){text, before};
    return true;
}

// Whether two names differ in digits at one place, which *start and *length tell, of b.
static bool differ_by_number(const char *a, const char *b, size_t *start, size_t *length)
{
    size_t first = 0, same = strlen(a), end = strlen(b);
    if (same != end || strcmp(a, b) == 0)
        return false;
    while (a[first] == b[first])
        first++;
    while (end > first && a[end - 1] == b[end - 1])
        end--;
    for (size_t i = first; i < end; i++)
        if (!isdigit((unsigned char)a[i]) || !isdigit((unsigned char)b[i]))
            return false;
    while (first && isdigit((unsigned char)b[first - 1]))
        first--;
    while (isdigit((unsigned char)b[end]))
        end++;
    *start = first;
    *length = end - first;
    return true;
}

// The first output that is not given and has this ending; NULL: none.
static const struct option_spec *find_output(const struct option_parse *parse, const char *ending)
{
    for (int i = 0; i < parse->option_count; i++) {
        const struct option_spec *spec = &parse->options[i];
        if (spec->type != OPTION_OUTPUT || spec->optional || parse->values[i].given)
            continue;
        for (int e = 0; spec->choices[e]; e++)
            if (strcasecmp(spec->choices[e], ending) == 0)
                return spec;
    }
    return NULL;
}

static void report_surplus(const struct option_parse *parse, const struct surplus *surplus)
{
    const char *text = surplus->text, *before = surplus->before;
    const char *last =
        parse->positional_count ? parse->positional[parse->positional_count - 1] : "";
    const int index = before && strncmp(before, "--", 2) == 0
                          ? find_long(parse, before + 2, strlen(before + 2))
                          : -1;
    const struct option_spec *output = find_output(parse, paths_ending(text));
    size_t start, length;
    if (index >= 0 && parse->options[index].optional)
        report_error("one argument too many: '%s'; did you mean %s=%s?", text, before, text);
    else if (find_long(parse, "frames", 6) >= 0 && differ_by_number(last, text, &start, &length))
        report_error("one argument too many: '%s'; a sequence is one name with its number as "
                     "%%0%zud: %.*s%%0%zud%s, and --frames",
                     text, length, (int)start, text, length, text + start + length);
    else if (output)
        report_error("one argument too many: '%s'; did you mean --%s %s?", text, output->name,
                     text);
    else
        report_error("one argument too many: '%s' (see weft help %s)", text, parse->verb);
}

// Two tables for getopt_long.
struct tables {
    char letters[2 * MAX_OPTIONS + 8];
    struct option names[MAX_OPTIONS + 2];
};

static void make_tables(const struct option_parse *parse, struct tables *out)
{
    char *letter = out->letters + sprintf(out->letters, "-:h"); // operands in order; no messages
    *out->names = (struct option){"help", optional_argument, NULL, 'h'};
    for (int i = 0; i < parse->option_count; i++) {
        const struct option_spec *spec = &parse->options[i];
        const bool flag = spec->type == OPTION_FLAG;
        out->names[i + 1] = (struct option){spec->name,
                                            flag             ? no_argument
                                            : spec->optional ? optional_argument
                                                             : required_argument,
                                            NULL, FIRST_LONG + i};
        if (spec->letter)
            letter += sprintf(letter, "%c%s", spec->letter,
                              flag             ? ""
                              : spec->optional ? "::"
                                               : ":");
    }
    out->names[parse->option_count + 1] = (struct option){0};
}

// The place in the table of what getopt_long returned; -1: it is none of ours.
static int find_code(const struct option_parse *parse, int code)
{
    if (code >= FIRST_LONG)
        return code - FIRST_LONG;
    for (int i = 0; i < parse->option_count; i++)
        if (code && parse->options[i].letter == code)
            return i;
    return -1;
}

// "-preview" would be -p with a value.
static bool is_name_with_one_dash(const struct option_parse *parse, const char *arg)
{
    return arg[0] == '-' && arg[1] != '-' && strlen(arg) > 2 &&
           find_long(parse, arg + 1, strcspn(arg + 1, "=")) >= 0;
}

static bool take_help(struct option_parse *parse, const char *text)
{
    if (text && strcmp(text, "all") != 0) {
        report_error("--help=%s: it is --help, or --help=all", text);
        return false;
    }
    parse->help = text ? OPTION_HELP_ALL : OPTION_HELP_BRIEF;
    return true;
}

// What getopt_long found at argv[at].
static bool take_code(struct option_parse *parse, char **argv, int at, int code,
                      struct surplus *surplus)
{
    if (code == 1)
        return take_operand(parse, optarg, argv[at - 1], surplus);
    if (code == 'h')
        return take_help(parse, optarg);
    if (code == '?' && optopt >= FIRST_LONG) {
        report_error("--%s takes no value", parse->options[optopt - FIRST_LONG].name);
        return false;
    }
    const int index = find_code(parse, code == ':' ? optopt : code);
    if (code == '?' || index < 0) {
        report_unknown(parse, argv[at]);
        return false;
    }
    const bool next_word = optarg && optarg == argv[optind - 1];
    if (code == ':' ||
        (next_word && looks_like_option(optarg) && !is_in_form(&parse->options[index], optarg)))
        return report_missing(&parse->options[index]);
    return take_option(parse, index, optarg);
}

// What is on standard output must be one thing.
static bool check_stdout(struct option_parse *parse)
{
    const char *first = NULL;
    for (int i = 0; i < parse->option_count; i++) {
        const struct option_spec *spec = &parse->options[i];
        const struct option_value *value = &parse->values[i];
        const bool output = spec->type == OPTION_OUTPUT && paths_is_stdout(value->text);
        const bool report = spec->optional && !value->text;
        if (!value->given || !(output || report))
            continue;
        parse->writes_stdout = parse->writes_stdout || output;
        if (first && parse->writes_stdout) {
            report_error("--%s and --%s both go to standard output", first, spec->name);
            return false;
        }
        first = spec->name;
    }
    return true;
}

// words: argv after a word that is nobody's.
static bool parse_words(struct option_parse *parse, int count, char **words)
{
    struct tables tables;
    struct surplus surplus = {NULL, NULL};
    make_tables(parse, &tables);
    optind = 0; // anew
    for (int at = 1;; at = optind) {
        // Several letters of one word leave optind where it is.
        if (at < count && is_name_with_one_dash(parse, words[at])) {
            report_unknown(parse, words[at]);
            return false;
        }
        const int code = getopt_long(count, words, tables.letters, tables.names, NULL);
        if (code < 0)
            break;
        if (!take_code(parse, words, at, code, &surplus))
            return false;
        if (parse->help)
            return true;
    }
    for (int i = optind; i < count; i++)
        if (!take_operand(parse, words[i], NULL, &surplus))
            return false;
    if (surplus.text) {
        report_surplus(parse, &surplus);
        return false;
    }
    return check_stdout(parse);
}

static enum option_help asks_for_help(int argc, char **argv)
{
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return OPTION_HELP_BRIEF;
        if (strcmp(argv[i], "--help=all") == 0)
            return OPTION_HELP_ALL;
    }
    return OPTION_HELP_NONE;
}

bool options_parse(struct option_parse *parse, int argc, char **argv)
{
    static char nobody[] = "weft";
    parse->positional_count = 0;
    parse->help = asks_for_help(argc, argv);
    if (parse->help)
        return true;
    char **words = calloc((size_t)argc + 2, sizeof *words);
    if (!words) {
        report_error("out of memory for %d arguments", argc);
        return false;
    }
    words[0] = nobody;
    for (int i = 0; i < argc; i++)
        words[i + 1] = argv[i];
    opterr = 0;
    const bool parsed = parse_words(parse, argc + 1, words);
    free(words);
    return parsed;
}
