// SPDX-License-Identifier: BSD-3-Clause
// tools/common/cells.h - tables of short texts, printed for people or for programs.
#ifndef WEFT_TOOLS_COMMON_CELLS_H
#define WEFT_TOOLS_COMMON_CELLS_H

#include <stdbool.h>
#include <stdio.h>

enum cells_format { CELLS_TEXT, CELLS_MARKDOWN, CELLS_CSV, CELLS_LATEX };

enum { CELLS_MAX_COLUMNS = 32 };

struct cells {
    int columns;      // up to CELLS_MAX_COLUMNS
    int text_columns; // the first ones are aligned to the left
    int rows;         // the first is the heading
    char **cell;      // [rows * columns]
};

// A grid of empty cells; false if there is no memory for it.
bool cells_create(struct cells *cells, int rows, int columns);
void cells_destroy(struct cells *cells);

// Formats a cell; false if there is no memory for it.
bool cells_set(struct cells *cells, int row, int column, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

// CSV by RFC 4180 but with plain line ends; LaTeX as one tabular.
void cells_print(const struct cells *cells, enum cells_format format, FILE *out);

// A line of text beside a table, as the format writes such things; CSV has no place for it.
void cells_print_note(enum cells_format format, const char *text, FILE *out);

#endif
