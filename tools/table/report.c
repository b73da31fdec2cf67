// SPDX-License-Identifier: BSD-3-Clause
// What `weft table` tells: the paper's layout, a line for each cell, JSON, and plots.
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "tools/common/cells.h"
#include "tools/common/json.h"
#include "tools/draw/plot.h"
#include "tools/table/job.h"

static const enum cells_format cells_formats[] = {
    [TABLE_TEXT] = CELLS_TEXT,
    [TABLE_MARKDOWN] = CELLS_MARKDOWN,
    [TABLE_CSV] = CELLS_CSV,
    [TABLE_LATEX] = CELLS_LATEX,
};

static const char *lookup_label(enum weft_error_lookup lookup)
{
    return lookup == WEFT_ERROR_LINEAR ? "lin" : "box";
}

static const char *convention_name(const struct table_job *job)
{
    return weft_error_convention_names[job->convention];
}

static const char *rounding_name(const struct table_job *job)
{
    return weft_fixed_rounding_names[job->rounding];
}

static bool is_target(const struct table_job *job)
{
    return job->option[TABLE_TARGET_ERROR].given;
}

static const char *kernel_name(const struct table_job *job, const struct table_cell *cell)
{
    return job->kernel[cell->kernel].text;
}

static int locations_of(const struct table_job *job, const struct table_cell *cell)
{
    return table_locations(job, cell->dims);
}

static double factor_of(const struct table_job *job, const struct table_cell *cell)
{
    return job->kernel[cell->kernel].scaled[cell->dims - 1].factor;
}

static double bytes_of(const struct table_job *job, const struct table_cell *cell)
{
    double texels =
        pow(job->kernel[cell->kernel].kernel.width, cell->dims) * pow(cell->samples, cell->dims);
    return ceil(texels * cell->bits / 8.0);
}

// ---- notes --------------------------------------------------------------------------------------

static void print_note(const struct table_job *job, FILE *out, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static void print_note(const struct table_job *job, FILE *out, const char *format, ...)
{
    char line[512];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    cells_print_note(cells_formats[job->format], line, out);
}

static void print_title(const struct table_job *job, FILE *out)
{
    char grids[64] = "", scale[64] = "";
    for (int d = 0; d < job->dim_count; d++) {
        size_t used = strlen(grids);
        snprintf(grids + used, sizeof grids - used, "%s%d", d ? " and " : "",
                 table_locations(job, job->dims[d]));
        used = strlen(grids);
        if (job->dims[d] > 1)
            snprintf(grids + used, sizeof grids - used, "^%d", job->dims[d]);
    }
    if (job->option[TABLE_SCALE].given)
        snprintf(scale, sizeof scale, ", scale %.32s", job->option[TABLE_SCALE].text);
    if (is_target(job))
        print_note(job, out,
                   "smallest M with eps_h <= %g, convention %s, quantised by %s%s, %s "
                   "locations",
                   job->option[TABLE_TARGET_ERROR].number[0], convention_name(job),
                   job->rounding == WEFT_FIXED_ROUND ? "rounding" : "truncation", scale, grids);
    else
        print_note(job, out, "%.0f eps_h, convention %s: %d bits, quantised by %s%s, %s locations",
                   job->cell[0].error.scale, convention_name(job), job->bits[0],
                   job->rounding == WEFT_FIXED_ROUND ? "rounding" : "truncation", scale, grids);
    if (job->format == TABLE_TEXT)
        fputs("\n", out);
}

static bool has_kaiser(const struct table_job *job)
{
    for (int k = 0; k < job->kernel_count; k++)
        if (strcmp(job->kernel[k].text, "kaiser-sinc:2,5.36") == 0)
            return true;
    return false;
}

static void print_footnotes(const struct table_job *job, FILE *out)
{
    bool first = true;
    if (job->convention != WEFT_ERROR_WSCG2003)
        return;
    if (job->format == TABLE_TEXT || job->format == TABLE_MARKDOWN)
        fputs("\n", out);
    if (has_kaiser(job))
        print_note(job, out,
                   "kaiser-sinc:2,5.36 gives the rows that the paper calls \"Blackman "
                   "sinc (window width 4)\"");
    for (int i = 0; i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        if (isnan(c->published))
            continue;
        if (first)
            print_note(job, out, "%s not reproduced; the paper prints:",
                       job->format == TABLE_MARKDOWN ? "(1)" : "*");
        first = false;
        print_note(job, out, "%s%s, %dD, M = %d, %s: %.4f",
                   job->format == TABLE_MARKDOWN ? "- " : "  ", kernel_name(job, c), c->dims,
                   c->samples, lookup_label(c->lookup), c->published);
    }
}

// ---- the paper's layout: kernels and resolutions down, dimensions and look-ups across ----------

static bool fill_grid(const struct table_job *job, struct cells *cells)
{
    const int across = job->dim_count * job->lookup_count;
    bool good = cells_create(cells, job->kernel_count * job->sample_count + 1, across + 2);
    cells->text_columns = 1;
    good = good && cells_set(cells, 0, 0, "kernel") && cells_set(cells, 0, 1, "M");
    for (int i = 0; good && i < across; i++)
        good = cells_set(cells, 0, i + 2, "%dD %s", job->cell[i].dims,
                         lookup_label(job->cell[i].lookup));
    for (int i = 0; good && i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        const int row = i / across + 1, column = i % across + 2;
        const char *mark = isnan(c->published) ? "" : job->format == TABLE_MARKDOWN ? " (1)" : "*";
        if (column == 2)
            good = cells_set(cells, row, 0, "%s", kernel_name(job, c)) &&
                   cells_set(cells, row, 1, "%d", c->samples);
        good = good &&
               cells_set(cells, row, column, "%#.6g%s", c->error.scale * c->error.maximum, mark);
    }
    return good;
}

// ---- a line for each cell -----------------------------------------------------------------------

// In the order of the columns.
static const char *const statistic_names[] = {
    "mean", "rms", "median", "p90", "p99", "signed_min", "signed_max", "signed_mean", "single"};
enum { STATISTICS = sizeof statistic_names / sizeof *statistic_names };

static void get_statistics(const struct weft_error_kernel *e, double out[STATISTICS])
{
    const double values[STATISTICS] = {e->mean,          e->rms,           e->median,
                                       e->percentile_90, e->percentile_99, e->signed_min,
                                       e->signed_max,    e->signed_mean,   e->single};
    memcpy(out, values, sizeof values);
}

static void format_position(const struct table_cell *cell, const char *separator, char *out,
                            size_t size)
{
    *out = 0;
    for (int d = 0; d < cell->dims; d++) {
        size_t used = strlen(out);
        snprintf(out + used, size - used, "%s%.9g", d ? separator : "", cell->error.position[d]);
    }
}

// For people: scaled, six digits.
static bool fill_statistics(const struct table_job *job, struct cells *cells)
{
    bool good = cells_create(cells, job->cell_count + 1, STATISTICS + 6);
    cells->text_columns = 1;
    static const char *const heads[] = {"kernel", "dims", "M", "look-up", "maximum"};
    for (int i = 0; good && i < 5; i++)
        good = cells_set(cells, 0, i, "%s", heads[i]);
    for (int i = 0; good && i < STATISTICS; i++)
        good = cells_set(cells, 0, 5 + i, "%s", statistic_names[i]);
    good = good && cells_set(cells, 0, STATISTICS + 5, "position");
    for (int i = 0; good && i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        double values[STATISTICS];
        char position[64];
        get_statistics(&c->error, values);
        format_position(c, ",", position, sizeof position);
        good = cells_set(cells, i + 1, 0, "%s", kernel_name(job, c)) &&
               cells_set(cells, i + 1, 1, "%d", c->dims) &&
               cells_set(cells, i + 1, 2, "%d", c->samples) &&
               cells_set(cells, i + 1, 3, "%s", lookup_label(c->lookup)) &&
               cells_set(cells, i + 1, 4, "%#.6g", c->error.scale * c->error.maximum);
        for (int s = 0; good && s < STATISTICS; s++)
            good = cells_set(cells, i + 1, 5 + s, "%.6g", c->error.scale * values[s]);
        good = good && cells_set(cells, i + 1, STATISTICS + 5, "%s", position);
    }
    return good;
}

// For programs: 17 digits, errors as they are and, where the paper has them so, scaled.
static bool fill_csv(const struct table_job *job, struct cells *cells)
{
    static const char *const heads[] = {"kernel",    "dims",     "samples", "lookup",
                                        "bits",      "rounding", "scale",   "convention",
                                        "locations", "error",    "scaled",  "published"};
    enum { HEADS = sizeof heads / sizeof *heads };
    const bool more = job->option[TABLE_STATISTICS].given;
    bool good = cells_create(cells, job->cell_count + 1, more ? HEADS + STATISTICS + 1 : HEADS);
    for (int i = 0; good && i < HEADS; i++)
        good = cells_set(cells, 0, i, "%s", heads[i]);
    for (int i = 0; good && more && i < STATISTICS; i++)
        good = cells_set(cells, 0, HEADS + i, "%s", statistic_names[i]);
    if (good && more)
        good = cells_set(cells, 0, HEADS + STATISTICS, "position");
    for (int i = 0; good && i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        const int row = i + 1;
        double values[STATISTICS];
        char position[96];
        get_statistics(&c->error, values);
        format_position(c, " ", position, sizeof position);
        good = cells_set(cells, row, 0, "%s", kernel_name(job, c)) &&
               cells_set(cells, row, 1, "%d", c->dims) &&
               cells_set(cells, row, 2, "%d", c->samples) &&
               cells_set(cells, row, 3, "%s", weft_error_lookup_names[c->lookup]) &&
               cells_set(cells, row, 4, "%d", c->bits) &&
               cells_set(cells, row, 5, "%s", rounding_name(job)) &&
               cells_set(cells, row, 6, "%.17g", factor_of(job, c)) &&
               cells_set(cells, row, 7, "%s", convention_name(job)) &&
               cells_set(cells, row, 8, "%d", locations_of(job, c)) &&
               cells_set(cells, row, 9, "%.17g", c->error.maximum) &&
               cells_set(cells, row, 10, "%.17g", c->error.scale * c->error.maximum);
        if (good && !isnan(c->published))
            good = cells_set(cells, row, 11, "%.4f", c->published);
        for (int s = 0; good && more && s < STATISTICS; s++)
            good = cells_set(cells, row, HEADS + s, "%.17g", values[s]);
        if (good && more)
            good = cells_set(cells, row, HEADS + STATISTICS, "%s", position);
    }
    return good;
}

// ---- resolutions for a target -------------------------------------------------------------------

static bool fill_target(const struct table_job *job, struct cells *cells)
{
    static const char *const heads[] = {"kernel", "dims",  "look-up", "bits",
                                        "M",      "eps_h", "bytes",   "least memory"};
    static const char *const keys[] = {"kernel",  "dims",  "lookup", "bits",
                                       "samples", "error", "bytes",  "least"};
    const bool csv = job->format == TABLE_CSV;
    bool good = cells_create(cells, job->cell_count + 1, 8);
    cells->text_columns = 1;
    for (int i = 0; good && i < 8; i++)
        good = cells_set(cells, 0, i, "%s", csv ? keys[i] : heads[i]);
    for (int i = 0; good && i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        const int row = i + 1;
        good = cells_set(cells, row, 0, "%s", kernel_name(job, c)) &&
               cells_set(cells, row, 1, "%d", c->dims) &&
               cells_set(cells, row, 2, "%s",
                         csv ? weft_error_lookup_names[c->lookup] : lookup_label(c->lookup)) &&
               cells_set(cells, row, 3, "%d", c->bits);
        if (good && c->missed) {
            good = csv || cells_set(cells, row, 4, "> %d", c->samples);
            continue;
        }
        good = good && cells_set(cells, row, 4, "%d", c->samples) &&
               cells_set(cells, row, 5, csv ? "%.17g" : "%#.6g", c->error.maximum) &&
               cells_set(cells, row, 6, "%.0f", bytes_of(job, c)) &&
               cells_set(cells, row, 7, "%s",
                         csv        ? (c->least ? "1" : "0")
                         : c->least ? "*"
                                    : "");
    }
    return good;
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *target_json(const struct table_job *job, const struct table_cell *c)
{
    return json_pack("{s:o,s:i,s:s,s:i,s:b,s:o,s:o,s:o,s:b}", "kernel",
                     json_text(kernel_name(job, c)), "dims", c->dims, "lookup",
                     weft_error_lookup_names[c->lookup], "bits", c->bits, "reached", !c->missed,
                     "samples", c->missed ? json_null() : json_integer(c->samples), "eps_h",
                     c->missed ? json_null() : json_number(c->error.maximum), "tile_bytes",
                     c->missed ? json_null() : json_number(bytes_of(job, c)), "least", c->least);
}

static json_t *cell_json(const struct table_job *job, const struct table_cell *c)
{
    json_t *object = json_pack(
        "{s:o,s:i,s:i,s:s,s:i,s:i,s:o,s:o,s:o}", "kernel", json_text(kernel_name(job, c)), "dims",
        c->dims, "samples", c->samples, "lookup", weft_error_lookup_names[c->lookup], "bits",
        c->bits, "locations", locations_of(job, c), "scale", json_number(factor_of(job, c)),
        "eps_h", json_number(c->error.maximum), "scaled",
        json_number(c->error.scale * c->error.maximum));
    if (!isnan(c->published))
        json_object_set_new(object, "published", json_number(c->published));
    if (!job->option[TABLE_STATISTICS].given)
        return object;
    double values[STATISTICS];
    get_statistics(&c->error, values);
    for (int s = 0; s < STATISTICS; s++)
        json_object_set_new(object, statistic_names[s], json_number(values[s]));
    json_object_set_new(object, "position", json_numbers(c->error.position, c->dims));
    return object;
}

enum weft_result table_print_json(const struct table_job *job)
{
    json_t *root =
        json_pack("{s:s,s:s}", "convention", convention_name(job), "rounding", rounding_name(job));
    json_t *list = json_array();
    for (int i = 0; i < job->cell_count; i++)
        json_array_append_new(list, (is_target(job) ? target_json : cell_json)(job, &job->cell[i]));
    if (is_target(job))
        json_object_set_new(root, "target_error",
                            json_number(job->option[TABLE_TARGET_ERROR].number[0]));
    else
        json_object_set_new(root, "factor", json_number(job->cell[0].error.scale));
    json_object_set_new(root, "cells", list);
    json_report_to(job->option[TABLE_OUTPUT].text);
    return json_print(root);
}

enum weft_result table_print(const struct table_job *job, FILE *out)
{
    struct cells cells;
    bool (*fill)(const struct table_job *, struct cells *) = is_target(job) ? fill_target
                                                             : job->format == TABLE_CSV ? fill_csv
                                                             : job->option[TABLE_STATISTICS].given
                                                                 ? fill_statistics
                                                                 : fill_grid;
    enum weft_result res = WEFT_OK;
    if (fill(job, &cells)) {
        if (job->format != TABLE_CSV)
            print_title(job, out);
        cells_print(&cells, cells_formats[job->format], out);
        if (job->format != TABLE_CSV)
            print_footnotes(job, out);
    } else {
        report_error("out of memory for the table");
        res = WEFT_ERR_MEMORY;
    }
    cells_destroy(&cells);
    return res;
}

// ---- plot ---------------------------------------------------------------------------------------

static void write_line(FILE *script, const struct table_job *job, int kernel, int dims,
                       enum weft_error_lookup lookup)
{
    for (int i = 0; i < job->cell_count; i++) {
        const struct table_cell *c = &job->cell[i];
        if (c->kernel == kernel && c->dims == dims && c->lookup == lookup)
            fprintf(script, "%d %.9g\n", c->samples, c->error.scale * c->error.maximum);
    }
    fputs("e\n", script);
}

static void draw_dims(FILE *s, const struct table_job *job, int dims)
{
    fprintf(s, "set title '%dD, %d%s locations'\nplot ", dims, table_locations(job, dims),
            dims == 1   ? ""
            : dims == 2 ? "^2"
                        : "^3");
    for (int k = 0; k < job->kernel_count; k++) {
        for (int l = 0; l < job->lookup_count; l++) {
            char title[200];
            snprintf(title, sizeof title, "%.150s, %s", job->kernel[k].text,
                     lookup_label(job->lookup[l]));
            fprintf(s, "%s'-' with linespoints lc %d dt %d pt %d ps 0.9 title ", k + l ? ", " : "",
                    k % 8 + 1, job->lookup[l] == WEFT_ERROR_LINEAR ? 2 : 1,
                    job->lookup[l] == WEFT_ERROR_LINEAR ? 6 : 7);
            plot_quote(s, title);
        }
    }
    fputs("\n", s);
    for (int k = 0; k < job->kernel_count; k++)
        for (int l = 0; l < job->lookup_count; l++)
            write_line(s, job, k, dims, job->lookup[l]);
}

// Neighbouring marks of a logarithmic axis that lies within a decade.
static void set_error_tics(FILE *s, const struct table_job *job)
{
    double low = INFINITY, high = 0.0;
    for (int i = 0; i < job->cell_count; i++) {
        const double value = job->cell[i].error.scale * job->cell[i].error.maximum;
        low = value > 0.0 ? fmin(low, value) : low;
        high = fmax(high, value);
    }
    if (!(high > 0.0))
        low = high = 1.0;
    fprintf(s, "set yrange [%.9g:%.9g]\n", low / 1.25, high * 1.25);
    if (high / low > 1000.0)
        return;
    static const double steps[] = {1.0, 2.0, 5.0};
    const char *separator = "set ytics (";
    for (int e = (int)floor(log10(low)) - 1; e <= (int)floor(log10(high)) + 1; e++)
        for (int i = 0; i < 3; i++, separator = ", ")
            fprintf(s, "%s%g", separator, steps[i] * pow(10.0, e));
    fputs(")\n", s);
}

static void set_sample_tics(FILE *s, const struct table_job *job)
{
    int low = job->samples[0], high = job->samples[0];
    for (int i = 1; i < job->sample_count; i++) {
        low = job->samples[i] < low ? job->samples[i] : low;
        high = job->samples[i] > high ? job->samples[i] : high;
    }
    fprintf(s, "set xrange [%.9g:%.9g]\nset xtics (", low / 1.25, high * 1.25);
    for (int i = 0; i < job->sample_count; i++)
        fprintf(s, "%s%d", i ? ", " : "", job->samples[i]);
    fputs(")\n", s);
}

enum exit_code table_draw(const struct table_job *job, const char *path)
{
    struct plot plot;
    const int lines = job->kernel_count * job->lookup_count;
    enum exit_code code =
        plot_begin(path, job->dim_count > 1 ? 560 * job->dim_count : 760, 500 + 21 * lines, &plot);
    if (code != EXIT_CODE_DONE)
        return code;
    FILE *s = plot.script;
    fprintf(
        s,
        "set multiplot layout 1,%d\nset logscale xy\nset key below maxcols 1 height 1.5 samplen 5\n"
        "set xlabel 'M, samples per unit and axis'\n"
        "set ylabel '%.0f eps_h (%d bits, %s, convention %s)'\n",
        job->dim_count, job->cell[0].error.scale, job->bits[0],
        job->rounding == WEFT_FIXED_ROUND ? "rounded" : "truncated", convention_name(job));
    set_sample_tics(s, job);
    set_error_tics(s, job);
    for (int d = 0; d < job->dim_count; d++)
        draw_dims(s, job, job->dims[d]);
    fputs("unset multiplot\n", s);
    return plot_finish(&plot);
}
