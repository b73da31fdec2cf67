// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/cells.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "weft.h"

bool cells_create(struct cells *cells, int rows, int columns)
{
    *cells = (struct cells){.rows = rows, .columns = columns};
    cells->cell = calloc((size_t)rows * (size_t)columns, sizeof *cells->cell);
    return cells->cell;
}

void cells_destroy(struct cells *cells)
{
    for (int i = 0; cells->cell && i < cells->rows * cells->columns; i++)
        free(cells->cell[i]);
    free(cells->cell);
    *cells = (struct cells){0};
}

bool cells_set(struct cells *cells, int row, int column, const char *format, ...)
{
    char **cell = &cells->cell[row * cells->columns + column];
    va_list args;
    free(*cell);
    va_start(args, format);
    int length = vasprintf(cell, format, args);
    va_end(args);
    if (length < 0)
        *cell = NULL;
    else
        weft_text_clean(*cell, false);
    return length >= 0;
}

static const char *get(const struct cells *cells, int row, int column)
{
    const char *text = cells->cell[row * cells->columns + column];
    return text ? text : "";
}

static int column_width(const struct cells *cells, int column)
{
    int width = 0;
    for (int row = 0; row < cells->rows; row++) {
        int length = (int)strlen(get(cells, row, column));
        width = length > width ? length : width;
    }
    return width;
}

static void print_text(const struct cells *cells, FILE *out)
{
    int width[CELLS_MAX_COLUMNS];
    for (int column = 0; column < cells->columns; column++)
        width[column] = column_width(cells, column) * (column < cells->text_columns ? -1 : 1);
    for (int row = 0; row < cells->rows; row++) {
        for (int column = 0; column < cells->columns; column++)
            fprintf(out, "%s%*s", column ? "  " : "", width[column], get(cells, row, column));
        putc('\n', out);
    }
}

static void print_escaped(const char *text, const char *special, FILE *out)
{
    for (; *text; text++) {
        if (strchr(special, *text))
            putc('\\', out);
        putc(*text, out);
    }
}

static void print_markdown(const struct cells *cells, FILE *out)
{
    for (int row = 0; row < cells->rows; row++) {
        for (int column = 0; column < cells->columns; column++) {
            fputs("| ", out);
            print_escaped(get(cells, row, column), "|*_", out);
            putc(' ', out);
        }
        fputs("|\n", out);
        for (int column = 0; row == 0 && column < cells->columns; column++)
            fputs(column < cells->text_columns ? "|---" : "|---:", out);
        if (row == 0)
            fputs("|\n", out);
    }
}

static void print_csv(const struct cells *cells, FILE *out)
{
    for (int row = 0; row < cells->rows; row++) {
        for (int column = 0; column < cells->columns; column++) {
            const char *text = get(cells, row, column);
            const char *quote = strpbrk(text, ",\"\n\r") ? "\"" : "";
            fprintf(out, "%s%s", column ? "," : "", quote);
            for (; *text; text++)
                fprintf(out, "%s%c", *text == '"' ? "\"" : "", *text);
            fputs(quote, out);
        }
        putc('\n', out);
    }
}

static void print_tex(const char *text, FILE *out)
{
    for (; *text; text++) {
        if (*text == '\\' || *text == '^' || *text == '~')
            fprintf(out, "\\char%d{}", *text);
        else
            print_escaped((char[]){*text, 0}, "#$%&_{}", out);
    }
}

static void print_latex(const struct cells *cells, FILE *out)
{
    fputs("\\begin{tabular}{", out);
    for (int column = 0; column < cells->columns; column++)
        putc(column < cells->text_columns ? 'l' : 'r', out);
    fputs("}\n\\hline\n", out);
    for (int row = 0; row < cells->rows; row++) {
        for (int column = 0; column < cells->columns; column++) {
            fputs(column ? " & " : "", out);
            print_tex(get(cells, row, column), out);
        }
        fprintf(out, " \\\\\n%s", row == 0 ? "\\hline\n" : "");
    }
    fputs("\\hline\n\\end{tabular}\n", out);
}

void cells_print(const struct cells *cells, enum cells_format format, FILE *out)
{
    static void (*const print[])(const struct cells *, FILE *) = {
        [CELLS_TEXT] = print_text,
        [CELLS_MARKDOWN] = print_markdown,
        [CELLS_CSV] = print_csv,
        [CELLS_LATEX] = print_latex,
    };
    print[format](cells, out);
}

void cells_print_note(enum cells_format format, const char *text, FILE *out)
{
    if (format == CELLS_LATEX)
        fprintf(out, "%% %s\n", text);
    if (format == CELLS_MARKDOWN) {
        print_escaped(text, "*_", out);
        fputs("\n\n", out);
    }
    if (format == CELLS_TEXT)
        fprintf(out, "%s\n", text);
}
