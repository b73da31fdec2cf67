// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/options.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"

enum { MAX_CHOICES = 16, MAX_CHOICES_TEXT = 256 };

// How the types that are lists of numbers are written.
static const struct list_form {
    char separator;
    bool integer;
    int count;
    bool single; // one number may stand for all
    const char *text;
} list_forms[] = {
    [OPTION_NUMBER] = {',', false, 1, false, "one finite number"},
    [OPTION_POINT] = {',', false, 3, false, "three finite numbers X,Y,Z"},
    [OPTION_RANGE] = {',', false, 2, false, "two finite numbers LO,HI"},
    [OPTION_SPACING] = {',', false, 3, true, "one finite number or three, SX,SY,SZ"},
    [OPTION_PIXELS] = {'x', true, 2, false, "two whole numbers, as 1024x768"},
    [OPTION_VOXELS] = {'x', true, 3, true, "one whole number or three, as 64x64x32"},
    [OPTION_INDEX] = {',', true, 3, false, "three whole numbers I,J,K"},
};

static bool parse_integer(const char *text, char **end, int64_t *out)
{
    errno = 0;
    *out = strtoll(text, end, 10);
    return *end != text && errno == 0 && *out <= INT64_C(1) << 62 && *out >= -(INT64_C(1) << 62);
}

static bool parse_number(const char *text, char **end, double *out)
{
    *out = strtod(text, end);
    return *end != text && isfinite(*out);
}

static bool parse_list(const struct list_form *form, const char *text, struct option_value *value)
{
    int count = 0;
    for (const char *at = text;; count++) {
        char *end;
        if (count == form->count || isspace((unsigned char)*at))
            return false;
        if (form->integer ? !parse_integer(at, &end, &value->integer[count])
                          : !parse_number(at, &end, &value->number[count]))
            return false;
        if (*end == 0) {
            count++;
            break;
        }
        if (*end != form->separator)
            return false;
        at = end + 1;
    }
    if (form->single && count == 1) {
        for (int i = 1; i < form->count; i++) {
            value->integer[i] = value->integer[0];
            value->number[i] = value->number[0];
        }
        return true;
    }
    return count == form->count;
}

// "1..2" is not "1." and ".2".
static bool parse_span(const char *text, struct option_value *value)
{
    const char *dots = strstr(text, "..");
    char first[64], *end;
    const size_t length = dots ? (size_t)(dots - text) : strlen(text);
    if (length >= sizeof first || isspace((unsigned char)*text))
        return false;
    memcpy(first, text, length);
    first[length] = 0;
    if (!parse_number(first, &end, &value->number[0]) || *end)
        return false;
    value->integer[0] = dots != NULL;
    value->number[1] = value->number[0];
    return !dots || (!isspace((unsigned char)dots[2]) &&
                     parse_number(dots + 2, &end, &value->number[1]) && !*end);
}

static bool parse_bytes(const char *text, int64_t *out)
{
    char *end;
    if (!isdigit((unsigned char)*text) || !parse_integer(text, &end, out))
        return false;
    int shift = 0;
    switch (*end) {
    case 'K':
    case 'k':
        shift = 10;
        break;
    case 'M':
    case 'm':
        shift = 20;
        break;
    case 'G':
    case 'g':
        shift = 30;
        break;
    }
    if (end[shift != 0] != 0 || *out < 1 || *out > (INT64_C(1) << 62) >> shift)
        return false;
    *out <<= shift;
    return true;
}

static bool is_choice(const struct option_spec *spec, int index)
{
    return spec->choices[index] && (!spec->choice_count || index < spec->choice_count);
}

static const char *list_choices(const struct option_spec *spec, const char *separator,
                                char words[MAX_CHOICES_TEXT])
{
    *words = '\0';
    for (int i = 0; is_choice(spec, i); i++) {
        const size_t used = strlen(words);
        snprintf(words + used, MAX_CHOICES_TEXT - used, "%s%s", i ? separator : "",
                 spec->choices[i]);
    }
    return words;
}

static bool parse_choice(const struct option_spec *spec, const char *text,
                         struct option_value *value)
{
    char words[MAX_CHOICES_TEXT];
    const char *names[MAX_CHOICES + 1] = {NULL};
    for (int i = 0; i < MAX_CHOICES && is_choice(spec, i); i++) {
        names[i] = spec->choices[i];
        value->integer[0] = i;
        if (strcmp(names[i], text) == 0)
            return true;
    }
    const char *meant = weft_closest_find(text, strlen(text), names);
    report_error("--%s: '%s' is not one of: %s%s%s%s", spec->name, text,
                 list_choices(spec, ", ", words), meant ? "; did you mean " : "",
                 meant ? meant : "", meant ? "?" : "");
    return false;
}

// How help and messages write the value.
static const char *value_form(const struct option_spec *spec, char words[MAX_CHOICES_TEXT])
{
    return spec->type == OPTION_CHOICE ? list_choices(spec, "|", words) : spec->value;
}

// "svg or png" for messages.
static void list_endings(const struct option_spec *spec, char *out, size_t size)
{
    *out = 0;
    for (int i = 0; spec->choices[i]; i++) {
        size_t used = strlen(out);
        snprintf(out + used, size - used, "%s%s",
                 !i                     ? ""
                 : spec->choices[i + 1] ? ", "
                                        : " or ",
                 spec->choices[i]);
    }
}

// -1: it is not one of them.
static int find_ending(const struct option_spec *spec, const char *ending)
{
    for (int i = 0; spec->choices[i]; i++)
        if (strcasecmp(spec->choices[i], ending) == 0)
            return i;
    return -1;
}

// What is no file has a name of its own, which tells no format.
static bool parse_output(const struct option_parse *parse, const struct option_spec *spec,
                         struct option_value *value)
{
    if (strcmp(value->text, "-") == 0)
        value->text = "/dev/stdout";
    const char *ending = paths_ending(value->text);
    value->integer[0] = find_ending(spec, ending);
    if (value->integer[0] >= 0 || !*ending || paths_is_special(value->text))
        return true;
    char endings[64], other[64] = "";
    list_endings(spec, endings, sizeof endings);
    for (int i = 0; i < parse->option_count && !*other; i++) {
        const struct option_spec *that = &parse->options[i];
        if (that->type == OPTION_OUTPUT && find_ending(that, ending) >= 0)
            snprintf(other, sizeof other, " (--%s writes %s)", that->name, ending);
    }
    report_error("--%s %s: the name must end in %s%s", spec->name, value->text, endings, other);
    return false;
}

static bool parse_value(const struct option_parse *parse, const struct option_spec *spec,
                        const char *text, struct option_value *value)
{
    value->given = true;
    value->text = text;
    switch (spec->type) {
    case OPTION_FLAG:
        return true;
    case OPTION_TEXT:
    case OPTION_OUTPUT:
        if (*text)
            return spec->type == OPTION_TEXT || parse_output(parse, spec, value);
        report_error("--%s: the value is empty", spec->name);
        return false;
    case OPTION_CHOICE:
        return parse_choice(spec, text, value);
    case OPTION_BYTES:
        if (parse_bytes(text, &value->integer[0]))
            return true;
        report_error("--%s: '%s' is not a number of bytes from 1 to 4611686018427387904, as "
                     "1048576, 1024K, 512M or 2G",
                     spec->name, text);
        return false;
    case OPTION_SPAN:
        if (parse_span(text, value))
            return true;
        report_error("--%s: '%s' is neither one finite number nor two, as A..B", spec->name, text);
        return false;
    default:
        if (parse_list(&list_forms[spec->type], text, value))
            return true;
        report_error("--%s: '%s' is not %s", spec->name, text, list_forms[spec->type].text);
        return false;
    }
}

// -1: there is none.
static int find_option(const struct option_parse *parse, const char *arg, size_t name_size)
{
    for (int i = 0; i < parse->option_count; i++) {
        const struct option_spec *spec = &parse->options[i];
        if (arg[1] == '-'
                ? strlen(spec->name) == name_size && memcmp(spec->name, arg + 2, name_size) == 0
                : spec->letter && spec->letter == arg[1] && arg[2] == 0)
            return i;
    }
    return -1;
}

// What options are called elsewhere.
static const struct {
    const char *name, *option;
} option_aliases[] = {
    {"filter", "kernel"},       {"interpolation", "kernel"}, {"interp", "kernel"},
    {"method", "kernel"},       {"out", "output"},           {"resize", "size"},
    {"width", "size"},          {"height", "size"},          {"resolution", "size"},
    {"colormap", "colour-map"}, {"cmap", "colour-map"},      {"palette", "colour-map"},
    {"tolerance", "max-error"}, {"png", "preview"},          {"dry-run", "explain"},
    {"check", "verify"},        {"silent", "quiet"},         {"debug", "verbose"},
};
enum { OPTION_ALIASES = sizeof option_aliases / sizeof *option_aliases, MAX_NAMES = 128 };

// The option of this verb that the first `length` bytes of name are near to; NULL: none.
static const char *suggest_option(const struct option_parse *parse, const char *name, size_t length)
{
    const char *names[MAX_NAMES] = {NULL}, *meant[MAX_NAMES];
    int count = 0;
    for (int i = 0; i < parse->option_count && count < MAX_NAMES - 1; i++, count++)
        names[count] = meant[count] = parse->options[i].name;
    for (int i = 0; i < OPTION_ALIASES && count < MAX_NAMES - 1; i++) {
        const char *option = option_aliases[i].option;
        char dashed[64];
        snprintf(dashed, sizeof dashed, "--%s", option);
        if (find_option(parse, dashed, strlen(option)) < 0)
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

static void report_unknown_option(const struct option_parse *parse, const char *arg, size_t size)
{
    const char *meant = arg[1] == '-'     ? suggest_option(parse, arg + 2, size)
                        : strlen(arg) > 2 ? suggest_option(parse, arg + 1, strcspn(arg + 1, "="))
                                          : NULL;
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

// The option at argv[*at]; moves *at onto its value if it takes the next argument.
static bool parse_option(struct option_parse *parse, int argc, char **argv, int *at)
{
    const char *arg = argv[*at], *text = NULL;
    const char *equals = arg[1] == '-' ? strchr(arg, '=') : NULL;
    size_t size = arg[1] == '-' ? (equals ? (size_t)(equals - arg) : strlen(arg)) - 2 : 0;
    int index = find_option(parse, arg, size);
    if (index < 0) {
        report_unknown_option(parse, arg, size);
        return false;
    }
    const struct option_spec *spec = &parse->options[index];
    if (spec->type == OPTION_FLAG) {
        if (equals)
            report_error("--%s takes no value", spec->name);
        parse->values[index].given = true;
        return !equals;
    }
    if (parse->values[index].given) {
        report_error("--%s is given twice", spec->name);
        return false;
    }
    if (equals)
        text = equals + 1;
    else if (*at + 1 < argc && !looks_like_option(argv[*at + 1]))
        text = argv[++*at];
    if (!text) {
        char words[MAX_CHOICES_TEXT];
        report_error("--%s needs a value: --%s %s", spec->name, spec->name,
                     value_form(spec, words));
        return false;
    }
    return parse_value(parse, spec, text, &parse->values[index]);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return true;
    return false;
}

// What is on standard output must be one thing.
static bool check_stdout(struct option_parse *parse)
{
    const char *first = NULL;
    for (int i = 0; i < parse->option_count; i++) {
        const struct option_spec *spec = &parse->options[i];
        const struct option_value *value = &parse->values[i];
        bool output = spec->type == OPTION_OUTPUT && paths_is_stdout(value->text);
        bool json = spec->type == OPTION_FLAG && strcmp(spec->name, "json") == 0;
        if (!value->given || !(output || json))
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

bool options_parse(struct option_parse *parse, int argc, char **argv)
{
    parse->positional_count = 0;
    parse->help = asks_for_help(argc, argv);
    if (parse->help)
        return true;
    bool options_ended = false;
    for (int i = 0; i < argc; i++) {
        if (!options_ended && strcmp(argv[i], "--") == 0) {
            options_ended = true;
        } else if (!options_ended && argv[i][0] == '-' && argv[i][1]) {
            if (!parse_option(parse, argc, argv, &i))
                return false;
        } else if (parse->positional_count == parse->positional_max) {
            report_error("one argument too many: '%s' (see weft help %s)", argv[i], parse->verb);
            return false;
        } else {
            parse->positional[parse->positional_count++] = argv[i];
        }
    }
    return check_stdout(parse);
}

enum weft_result options_read_number(const struct option_value *value, const char *name, double low,
                                     double high, const char *what, double *out)
{
    if (!value->given)
        return WEFT_OK;
    if (value->number[0] >= low && value->number[0] <= high) {
        *out = value->number[0];
        return WEFT_OK;
    }
    report_error("--%s %s: %s", name, value->text, what);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result options_read_whole(const struct option_value *value, const char *name,
                                    int64_t least, int64_t most, int *out)
{
    const double n = value->number[0];
    if (!value->given)
        return WEFT_OK;
    if (n >= (double)least && n <= (double)most && n == floor(n)) {
        *out = (int)n;
        return WEFT_OK;
    }
    report_error("--%s %s: not a whole number from %lld to %lld", name, value->text,
                 (long long)least, (long long)most);
    return WEFT_ERR_ARGUMENT;
}

bool options_ask_for_help(const struct option_value *value)
{
    return value->given && strcmp(value->text, "help") == 0;
}

void options_join_names(const char *const *names, unsigned bits, const char *last, char *text,
                        size_t size)
{
    *text = 0;
    for (int i = 0; bits >> i; i++) {
        const size_t used = strlen(text);
        const unsigned later = bits >> i >> 1;
        if (bits >> i & 1 && later && !(later & (later - 1)))
            snprintf(text + used, size - used, "%s %s ", names[i], last);
        else if (bits >> i & 1)
            snprintf(text + used, size - used, "%s%s", names[i], later ? ", " : "");
    }
}

void options_print_wrapped(const char *text, int indent)
{
    int column = 0;
    while (*text) {
        size_t size = strcspn(text, " ");
        if (column && column + 1 + (int)size > 79) {
            putchar('\n');
            column = 0;
        }
        column += printf("%*s%.*s", column ? 1 : indent, "", (int)size, text);
        text += size + strspn(text + size, " ");
    }
    putchar('\n');
}

void options_print(const struct option_spec *options, int option_count)
{
    for (int i = 0; i < option_count; i++) {
        const struct option_spec *spec = &options[i];
        char letter[4] = "   ", words[MAX_CHOICES_TEXT];
        const char *value = value_form(spec, words);
        if (spec->letter)
            snprintf(letter, sizeof letter, "-%c,", spec->letter);
        printf("  %s --%s%s%s\n", letter, spec->name, value ? " " : "", value ? value : "");
        options_print_wrapped(spec->help, 10);
    }
}
