// SPDX-License-Identifier: BSD-3-Clause
#include "tools/program/version.h"

#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"
#include "weft.h"

// Of the program, which is linked anew for each (cmake/version.cmake); "" where none is known.
extern const char weft_commit[];

static void put(const char *name, const char *text)
{
    if (*text)
        printf("%-10s %s\n", name, text);
}

// The CPU engine's sets of instructions that run here, the best one first.
static void put_engines(void)
{
    char text[256] = "gl, cpu";
    const char *before = " (";
    for (int set = WEFT_INSTRUCTIONS_AVX512; set > WEFT_INSTRUCTIONS_AUTO; set--) {
        if (!weft_instruction_set_runs((enum weft_instruction_set)set))
            continue;
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s", before, weft_instruction_set_names[set]);
        before = ", ";
    }
    strcat(text, ")");
    put("engines", text);
}

static void print(void)
{
    printf("weft %s\n", weft_version());
    put("commit", weft_commit);
    put("compiler", BUILT_BY);
    put("libraries", BUILT_WITH);
    put("readers", BUILT_READERS);
    put("contexts", BUILT_CONTEXTS);
    put_engines();
    put("ranks", *BUILT_RANKS ? BUILT_RANKS : "none");
}

void version_print_help(void)
{
    puts("usage: weft version\n\n"
         "Prints weft's version on the first line and, below it, the commit, the compiler, the\n"
         "libraries, the kinds of contexts and the MPIs that it was built with, and the engines.");
}

int version_run(char **words)
{
    if (!words[0]) {
        print();
    } else if (strcmp(words[0], "--help") == 0 || strcmp(words[0], "-h") == 0) {
        version_print_help();
    } else {
        report_error("weft version takes no options and no operands, and '%s' is one", words[0]);
        return EXIT_CODE_USAGE;
    }
    return report_finish(WEFT_OK);
}
