// SPDX-License-Identifier: BSD-3-Clause
// What holds for every verb, for help and manual pages.
#include "tools/program/help.h"

const char help_summary[] =
    "reconstruction filtering of volumes and images, on OpenGL and the CPU";

const char *const help_group_names[VERB_GROUPS] = {
    [VERB_VOLUMES] = "volumes",
    [VERB_IMAGES] = "images",
    [VERB_FRAMES] = "frames and scenes",
    [VERB_METHODS] = "kernels and methods",
};

const struct help_entry help_exit_codes[] = {
    {"0", "done"},
    {"1",
     "failed: out of memory, a GL error, no gnuplot for a plot, nothing within --max-error, a "
     "verification beyond its bound; weft antialias: pixels without their samples' weight; weft "
     "validate: invalid; weft stability: a case fails"},
    {"2", "wrong usage: options, names, geometry"},
    {"3", "unreadable or refused input: missing, damaged, unsupported, over a limit; frames left "
          "out by --skip-bad"},
    {"4", "output not written"},
    {"5", "no usable GL context"},
    {NULL, NULL},
};

const struct help_entry help_environment[] = {
    {"WEFT_LIBEXEC", "folder of the reader programs (weft-read-vdb and its siblings)"},
    {"XDG_CACHE_HOME", "where weft calibrate keeps its numbers (default ~/.cache)"},
    {"LP_NUM_THREADS", "threads of Mesa's software renderer; the results are the same"},
    {"WEFT_THREADS", "threads of all else, at most (default: all processors); likewise"},
    {NULL, NULL},
};

const char *const help_rules[] = {
    "Outputs: the ending of a name tells the format; - is standard output, where nothing else goes "
    "then: texts go to stderr. An output appears whole or not at all.",
    "A signal ends weft at once, and by that signal.",
    NULL,
};
