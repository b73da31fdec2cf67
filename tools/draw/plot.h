// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/plot.h - plots by gnuplot, run as a child with the script on its standard input.
#ifndef WEFT_TOOLS_DRAW_PLOT_H
#define WEFT_TOOLS_DRAW_PLOT_H

#include <stdio.h>

#include "tools/common/report.h"

extern const char *const plot_endings[];    // ".svg", ".png", ".pdf", ".eps"; NULL-ended
#define PLOT_VALUE "OUT.svg|.png|.pdf|.eps" // in help

struct plot {
    const char *path; // its ending tells the format; without one, as /dev/stdout, it is SVG
    FILE *script;     // what gnuplot is to read: write commands and inline data here
};

// Before long work: the ending is known, gnuplot is there, the file could be written. `option`
// named the file, as "--plot"; `otherwise` says how the data can be had without gnuplot. All three:
// after an error line where not EXIT_CODE_DONE.
enum exit_code plot_check(const char *option, const char *path, const char *otherwise);

// Opens the script, with the terminal set to an image of that size in pixels, 96 an inch.
enum exit_code plot_begin(const char *path, int width, int height, struct plot *out);

// Runs gnuplot and puts the image in place, whole or not at all; releases everything.
enum exit_code plot_finish(struct plot *plot);

// Writes text in gnuplot's single quotes.
void plot_quote(FILE *script, const char *text);

// For plots whose data has a value without gnuplot: whether that runs here, and the script so far,
// with the name of the image in it, as a file for gnuplot to read. All is kept for plot_finish.
bool plot_can_draw(void);
enum exit_code plot_save_script(struct plot *plot, const char *script_path);

// Instead of plot_finish: draws nothing.
void plot_discard(struct plot *plot);

#endif
