// SPDX-License-Identifier: BSD-3-Clause
#include "filter/closest.h"

#include <stdio.h>
#include <string.h>

enum { MAX_LENGTH = 63, LEAST_BEGINNING = 3 };

static int fold(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A' + 'a';
    return c == '_' || c == ' ' ? '-' : (unsigned char)c;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

// Both at most MAX_LENGTH long. Three rows of the table are enough: swaps look two back.
static int distance(const char *a, int a_length, const char *b, int b_length)
{
    int rows[3][MAX_LENGTH + 1];
    for (int j = 0; j <= b_length; j++)
        rows[0][j] = j;
    for (int i = 1; i <= a_length; i++) {
        int *row = rows[i % 3];
        const int *above = rows[(i + 2) % 3], *above_that = rows[(i + 1) % 3];
        row[0] = i;
        for (int j = 1; j <= b_length; j++) {
            const int x = fold(a[i - 1]), y = fold(b[j - 1]);
            row[j] = least(above[j - 1] + (x != y), least(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && x == fold(b[j - 2]) && y == fold(a[i - 2]))
                row[j] = least(row[j], above_that[j - 2] + 1);
        }
    }
    return rows[a_length % 3][b_length];
}

static bool begins(const char *text, int length, const char *name)
{
    return length >= LEAST_BEGINNING && distance(text, length, name, length) == 0;
}

const char *weft_closest_find(const char *text, size_t length, const char *const *names)
{
    const char *best = NULL;
    int best_distance = MAX_LENGTH + 1;
    if (length > MAX_LENGTH)
        return NULL;
    for (size_t i = 0; names[i]; i++) {
        const size_t name_length = strlen(names[i]);
        if (name_length > MAX_LENGTH)
            continue;
        int d = distance(text, (int)length, names[i], (int)name_length);
        // An exact beginning is as good as one wrong letter.
        if (d > 1 && length < name_length && begins(text, (int)length, names[i]))
            d = 1;
        const int allowed = name_length < 3 ? 0 : name_length < 6 ? 1 : (int)(name_length / 3);
        if (d <= allowed && d < best_distance) {
            best = names[i];
            best_distance = d;
        }
    }
    return best;
}

const char *weft_closest_explain(const char *text, size_t length, const char *const *names,
                                 char *out, size_t size)
{
    const char *meant = weft_closest_find(text, length, names);
    size_t used = (size_t)snprintf(out, size, "%s%s%s", meant ? "; did you mean " : "; there are ",
                                   meant ? meant : "", meant ? "? There are " : "");
    for (size_t i = 0; names[i] && used < size; i++)
        used += (size_t)snprintf(out + used, size - used, "%s%s", i ? ", " : "", names[i]);
    return out;
}
