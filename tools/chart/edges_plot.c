// SPDX-License-Identifier: BSD-3-Clause
// The chart of `weft chart --antialias`, drawn by gnuplot: error over time and over bytes.
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "tools/chart/chart.h"

static const struct {
    const char *name, *colour;
    int mark; // of gnuplot; the one before it is hollow
} families[ANTIALIAS_WAY_COUNT] = {
    [ANTIALIAS_NONE] = {"one sample", "#404040", 15},
    [ANTIALIAS_MSAA] = {"MSAA", "#d9480f", 5},
    [ANTIALIAS_ACAA] = {"accumulative (ACAA)", "#2171d5", 7},
    [ANTIALIAS_ADAPTIVE] = {"adaptive", "#c2185b", 9},
    [ANTIALIAS_SUPERSAMPLE] = {"supersampling", "#2e8b22", 13},
};

enum panel { OVER_TIME, OVER_BYTES, PANELS };

struct edges_plot {
    FILE *s;
    const struct chart_edges *edges;
    struct chart_range x[PANELS], error;
};

static double x_of(const struct chart_edges_point *p, enum panel panel)
{
    return panel == OVER_TIME ? 1e3 * p->seconds : (double)p->bytes / 0x1p20;
}

static void find_ranges(struct edges_plot *plot)
{
    for (int i = 0; i < PANELS; i++)
        plot->x[i] = (struct chart_range){DBL_MAX, DBL_MIN};
    plot->error = (struct chart_range){DBL_MAX, DBL_MIN};
    for (size_t i = 0; i < plot->edges->points; i++) {
        const struct chart_edges_point *p = &plot->edges->point[i];
        if (*p->reason)
            continue;
        for (int x = 0; x < PANELS; x++)
            chart_extend_range(&plot->x[x], x_of(p, (enum panel)x));
        chart_extend_range(&plot->error, p->rms_error);
        chart_extend_range(&plot->error, p->max_error);
    }
    if (plot->error.low > plot->error.high) // all of it without an error
        plot->error = (struct chart_range){1e-6, 1.0};
    for (int i = 0; i < PANELS; i++)
        plot->x[i] = (struct chart_range){plot->x[i].low / 1.6, plot->x[i].high * 1.6};
    plot->error = (struct chart_range){plot->error.low / 1.6, plot->error.high * 1.3};
}

static double shown(const struct edges_plot *plot, double error)
{
    return fmax(error, 1.2 * plot->error.low);
}

// ---- labels -------------------------------------------------------------------------------------

static double to_pixels(double value, struct chart_range range, double pixels)
{
    return pixels * log(value / range.low) / log(range.high / range.low);
}

// What colour and mark do not tell: samples, the kernel.
static void shorten(const struct chart_edges_point *p, char out[CHART_TEXT])
{
    const int side = (int)lround(sqrt(p->way.samples));
    const char *visible = p->way.mark == WEFT_MARK_VISIBLE ? " visible" : "";
    const char *space = p->filter ? " " : "";
    const char *kernel = p->filter ? chart_edges_filters[p->filter] : "";
    if (p->way.way == ANTIALIAS_NONE)
        snprintf(out, CHART_TEXT, "1");
    else if (p->way.way == ANTIALIAS_ADAPTIVE || p->way.way == ANTIALIAS_SUPERSAMPLE)
        snprintf(out, CHART_TEXT, "%d x %d%s%s%s", side, side, visible, space, kernel);
    else
        snprintf(out, CHART_TEXT, "%d%s%s", p->way.samples, space, kernel);
}

static void write_label(FILE *s, const struct chart_label *label, double left, const char *colour)
{
    const double x = (left + label->at_x) / CHART_PANELS_WIDTH,
                 y = (CHART_BOTTOM + label->at_y) / CHART_HEIGHT;
    if (hypot(label->at_x - label->x, label->at_y - label->y) > 16.0)
        fprintf(
            s, "set arrow from screen %.5f,%.5f to screen %.5f,%.5f nohead lc '#a0a0a0' lw 0.7\n",
            (left + label->x) / CHART_PANELS_WIDTH, (CHART_BOTTOM + label->y) / CHART_HEIGHT, x, y);
    char style[64];
    snprintf(style, sizeof style, "%s font 'sans,10' tc '%s' front",
             label->side > 0   ? "left"
             : label->side < 0 ? "right"
                               : "center",
             colour);
    chart_put_label(s, x, y, style, label->text);
}

static void write_labels(const struct edges_plot *plot, enum panel panel)
{
    const double left = CHART_LEFT + (int)panel * (CHART_PANEL + CHART_PANEL_GAP);
    const double height = CHART_TOP - 20.0 - CHART_BOTTOM;
    struct chart_label labels[CHART_EDGES_POINTS];
    double points[CHART_EDGES_POINTS][2];
    const char *colours[CHART_EDGES_POINTS];
    int count = 0;
    for (size_t i = 0; i < plot->edges->points; i++) {
        const struct chart_edges_point *p = &plot->edges->point[i];
        if (*p->reason)
            continue;
        points[count][0] = to_pixels(x_of(p, panel), plot->x[panel], CHART_PANEL);
        points[count][1] = to_pixels(shown(plot, p->rms_error), plot->error, height);
        labels[count] = (struct chart_label){.x = points[count][0], .y = points[count][1]};
        colours[count] = families[p->way.way].colour;
        shorten(p, labels[count++].text);
    }
    chart_labels_place(labels, count, (const double(*)[2])points, (size_t)count, CHART_PANEL,
                       height);
    for (int i = 0; i < count; i++)
        write_label(plot->s, &labels[i], left, colours[i]);
}

// ---- points -------------------------------------------------------------------------------------

// Block $pP_F_W: x, RMS and largest error of a family's points by the box, or by wider filters;
// false if there are none.
static bool write_block(const struct edges_plot *plot, enum panel panel, int family, bool wide)
{
    bool any = false;
    for (size_t i = 0; i < plot->edges->points; i++) {
        const struct chart_edges_point *p = &plot->edges->point[i];
        if (*p->reason || (int)p->way.way != family || (p->filter > 0) != wide)
            continue;
        if (!any)
            fprintf(plot->s, "$p%d_%d_%d << EOD\n", (int)panel, family, wide);
        any = true;
        fprintf(plot->s, "%.9g %.9g %.9g\n", x_of(p, panel), shown(plot, p->rms_error),
                shown(plot, p->max_error));
    }
    if (any)
        fputs("EOD\n", plot->s);
    return any;
}

static void write_points(const struct edges_plot *plot, enum panel panel)
{
    bool has[ANTIALIAS_WAY_COUNT][2];
    for (int f = 0; f < ANTIALIAS_WAY_COUNT; f++)
        for (int wide = 0; wide < 2; wide++)
            has[f][wide] = write_block(plot, panel, f, wide);
    fputs("plot ", plot->s);
    for (int f = 0; f < ANTIALIAS_WAY_COUNT; f++)
        for (int wide = 0; wide < 2; wide++)
            if (has[f][wide])
                fprintf(plot->s,
                        "$p%d_%d_%d using 1:2:2:3 with yerrorbars notitle lc '#c0%s' lw 0.7 ps 0, "
                        "$p%d_%d_%d using 1:2 with points notitle lc '%s' lw 1.4 pt %d ps 1.2, ",
                        (int)panel, f, wide, families[f].colour + 1, (int)panel, f, wide,
                        families[f].colour, families[f].mark - wide);
}

static void write_key(FILE *s)
{
    for (int i = 0; i < ANTIALIAS_WAY_COUNT; i++)
        fprintf(s, "1/0 with points lc '%s' lw 1.4 pt %d ps 1.2 title '%s', ", families[i].colour,
                families[i].mark, families[i].name);
    fputs("1/0 with points lc '#404040' lw 1.4 pt 6 ps 1.2 title 'hollow: wider filters', "
          "1/0 with lines lc '#b0b0b0' lw 1 title 'to the largest error'\n",
          s);
}

// ---- the chart ----------------------------------------------------------------------------------

static void write_panel(const struct edges_plot *plot, enum panel panel)
{
    FILE *s = plot->s;
    write_labels(plot, panel);
    chart_set_panel(s, (int)panel);
    chart_set_axis(s, "x", plot->x[panel]);
    chart_set_axis(s, "y", plot->error);
    if (panel == OVER_TIME) {
        fputs("set xlabel 'time of a picture, ms'\nset ylabel 'RMS error against exact coverage, "
              "of values from 0 to 1'\n",
              s);
        write_points(plot, panel);
        fputs("1/0 notitle\nunset label\nunset arrow\n", s);
        return;
    }
    fputs("set xlabel 'memory of all targets and sums, MiB'\nunset ylabel\n", s);
    fprintf(s, "set key at screen %.5f,%.5f left top Left reverse samplen 1.5 spacing 1.25\n",
            (double)(CHART_LEFT + 2 * CHART_PANEL + CHART_PANEL_GAP + 20) / CHART_PANELS_WIDTH,
            (double)CHART_TOP / CHART_HEIGHT);
    write_points(plot, panel);
    write_key(s);
}

static enum weft_result write(FILE *s, const struct chart_job *job)
{
    struct edges_plot plot = {.s = s, .edges = &job->edges};
    const double left = (double)CHART_LEFT / CHART_PANELS_WIDTH;
    char title[CHART_REASON];
    find_ranges(&plot);
    snprintf(title, sizeof title, "%s, %d x %d pixels", plot.edges->scene, plot.edges->width,
             plot.edges->height);
    chart_put_label(s, left, (CHART_TOP + 50.0) / CHART_HEIGHT, "left font 'sans,15'",
                    "Anti-aliasing: error against exact coverage, over time and over memory");
    chart_put_label(s, left, (CHART_TOP + 25.0) / CHART_HEIGHT, "left font 'sans,12'", title);
    chart_put_caption(s, job, CHART_PANELS_WIDTH, CHART_HEIGHT,
                      "Numbers: samples of a pixel. Each way is compared with the exact integral "
                      "by its own filter; the filters differ in sharpness, not in error alone.");
    fputs("set multiplot\nset logscale xy\nset format x '%g'\nset format y '%g'\nset key off\nset "
          "errorbars 0\n",
          s);
    write_panel(&plot, OVER_TIME);
    write_panel(&plot, OVER_BYTES);
    fputs("unset multiplot\n", s);
    return WEFT_OK;
}

enum exit_code chart_edges_draw(const struct chart_job *job, const char *path, bool keep_script)
{
    return chart_draw_script(job, path, CHART_PANELS_WIDTH, CHART_HEIGHT, write, keep_script);
}
