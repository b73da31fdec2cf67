// SPDX-License-Identifier: BSD-3-Clause
// What an unknown kernel's name was meant to be.
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_NAMES = 256, NAME_SIZE = 32 };

struct names {
    const char *list[MAX_NAMES];
    char prefiltered[MAX_NAMES / 8][NAME_SIZE]; // "bspline3i"
    size_t count;
};

static void add(struct names *names, const char *name)
{
    if (names->count + 1 < MAX_NAMES)
        names->list[names->count++] = name;
}

// The catalogue comes first: of names equally near it wins.
static void collect(struct names *names)
{
    size_t prefiltered = 0;
    *names = (struct names){.count = 0};
    for (size_t i = 0; weft_kernel_list[i]; i++)
        add(names, weft_kernel_list[i]->name);
    for (size_t i = 0; weft_kernel_list[i] && prefiltered < WEFT_COUNT(names->prefiltered); i++) {
        const struct weft_kernel_info *info = weft_kernel_list[i];
        if (info->primitive || weft_kernel_check_prefilter(NULL, info) != WEFT_OK)
            continue;
        char *name = names->prefiltered[prefiltered++];
        snprintf(name, NAME_SIZE, "%si", info->name);
        add(names, name);
    }
    for (size_t i = 0; weft_kernel_aliases[i].name; i++)
        add(names, weft_kernel_aliases[i].name);
}

static const struct weft_kernel_alias *alias_of(const char *name)
{
    return weft_kernel_find_alias(name, strlen(name));
}

// What stands behind a slip of the finger stays; another program's parameters are not ours.
static void write_meaning(const char *name, const char *rest, char *out, size_t size)
{
    const struct weft_kernel_alias *alias = weft_kernel_find(name) ? NULL : alias_of(name);
    if (!alias)
        snprintf(out, size, "%s%.*s", name, NAME_SIZE, rest);
    else
        snprintf(out, size, "%s%.*s", alias->taken ? alias->kernel : alias->sentence,
                 alias->taken && *rest == '+' ? NAME_SIZE : 0, rest);
}

// "blackman-harris3" is a name with its radius.
static size_t without_digits(const char *text, size_t length)
{
    while (length > 1 && text[length - 1] >= '0' && text[length - 1] <= '9')
        length--;
    return length;
}

static bool suggest(const char *text, char *out, size_t size)
{
    struct names names;
    const size_t length = strcspn(text, ":+");
    collect(&names);
    const char *name = weft_closest_find(text, length, names.list);
    if (!name)
        name = weft_closest_find(text, without_digits(text, length), names.list);
    if (name)
        write_meaning(name, text + length, out, size);
    return name != NULL;
}

bool weft_kernel_suggest(const char *text, char *out, size_t size)
{
    const size_t prefix = weft_kernel_derivative_prefix(text);
    snprintf(out, size, "%.*s", (int)prefix, text);
    return suggest(text + prefix, out + prefix, size - prefix);
}
