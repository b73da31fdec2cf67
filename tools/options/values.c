// SPDX-License-Identifier: BSD-3-Clause
#include "tools/options/options.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/hint.h"
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
    [OPTION_POINT] = {',', false, 3, false, "three finite numbers X,Y,Z, as 1,2,3"},
    [OPTION_RANGE] = {',', false, 2, false, "two finite numbers LO,HI, as 0,1"},
    [OPTION_SPACING] = {',', false, 3, true, "one finite number or three, SX,SY,SZ"},
    [OPTION_PIXELS] = {'x', true, 2, true, "one whole number or two, as 512 or 1024x768"},
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

// What choices are called elsewhere.
static const char *const choice_aliases[][2] = {
    {"gpu", "gl"},         {"opengl", "gl"},      {"average", "mean"},  {"avg", "mean"},
    {"mip", "max"},        {"maximum", "max"},    {"minimum", "min"},   {"voxel", "index"},
    {"voxels", "index"},   {"physical", "world"}, {"deflate", "zip"},   {"fp16", "half"},
    {"float16", "half"},   {"fp32", "float"},     {"float32", "float"}, {"repeat", "wrap"},
    {"reflect", "mirror"}, {"yes", "on"},         {"true", "on"},       {"no", "off"},
    {"false", "off"},      {"short", "int16"},    {"uchar", "uint8"},   {"byte", "uint8"},
    {"ushort", "uint16"},  {"int", "int32"},      {"uint", "uint32"},
};

// names: the choices, then NULL.
static const char *suggest_choice(const char *text, const char *const *names)
{
    for (size_t i = 0; i < sizeof choice_aliases / sizeof *choice_aliases; i++)
        for (int n = 0; names[n] && strcasecmp(choice_aliases[i][0], text) == 0; n++)
            if (strcmp(names[n], choice_aliases[i][1]) == 0)
                return names[n];
    return weft_closest_find(text, strlen(text), names);
}

static bool parse_choice(const struct option_spec *spec, const char *text,
                         struct option_value *value)
{
    char words[MAX_CHOICES_TEXT];
    const char *names[MAX_CHOICES + 1] = {NULL};
    for (int i = 0; i < MAX_CHOICES && is_choice(spec, i); i++) {
        names[i] = spec->choices[i];
        value->integer[0] = i;
        if (strcasecmp(names[i], text) == 0)
            return true;
    }
    const char *meant = suggest_choice(text, names);
    report_error("--%s: '%s' is not one of: %s%s%s%s", spec->name, text,
                 list_choices(spec, ", ", words), meant ? "; did you mean " : "",
                 meant ? meant : "", meant ? "?" : "");
    return false;
}

void options_format_value(const struct option_spec *spec, char *text, size_t size)
{
    char words[MAX_CHOICES_TEXT];
    const char *form = spec->type == OPTION_CHOICE ? list_choices(spec, "|", words) : spec->value;
    snprintf(text, size, "%s", form ? form : "");
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

bool options_read_value(const struct option_parse *parse, const struct option_spec *spec,
                        const char *text, struct option_value *value)
{
    char hint[HINT_TEXT];
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
        report_error("--%s: '%s' is neither one finite number nor two, as A..B%s", spec->name, text,
                     hint_number(text, hint));
        return false;
    default:
        if (parse_list(&list_forms[spec->type], text, value))
            return true;
        report_error("--%s: '%s' is not %s%s", spec->name, text, list_forms[spec->type].text,
                     spec->type == OPTION_NUMBER ? hint_number(text, hint) : "");
        return false;
    }
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
