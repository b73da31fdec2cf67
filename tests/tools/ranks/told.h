// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/ranks/told.h - what is said on stderr, kept. Include after cmocka.h.
#ifndef WEFT_TESTS_TOOLS_RANKS_TOLD_H
#define WEFT_TESTS_TOOLS_RANKS_TOLD_H

#include <stdio.h>
#include <unistd.h>

#include "tools/common/report.h"

struct told {
    FILE *file;
    int saved;
};

// From now on it is kept, with an error line of its own.
static inline struct told told_begin(void)
{
    struct told told = {tmpfile(), dup(STDERR_FILENO)};
    assert_true(told.file && told.saved >= 0);
    report_set_part("", "");
    report_set_part(NULL, NULL);
    dup2(fileno(told.file), STDERR_FILENO);
    return told;
}

// What was said until now.
static inline void told_end(struct told told, char *out, size_t size)
{
    fflush(stderr);
    dup2(told.saved, STDERR_FILENO);
    close(told.saved);
    rewind(told.file);
    out[fread(out, 1, size - 1, told.file)] = 0;
    fclose(told.file);
}

#endif
