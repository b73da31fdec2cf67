// SPDX-License-Identifier: BSD-3-Clause
// The chart of `weft chart --accumulate`, drawn by gnuplot: time against error with the largest
// number of frames, and error over the number of frames.
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"
#include "tools/draw/plot.h"

static const struct {
    const char *name, *colour;
    int mark; // of gnuplot
} families[CHART_FRAMES_FAMILIES] = {
    [CHART_EXACT] = {"exact, on the CPU", "#c2185b", 15},
    [CHART_FLOAT] = {"float target", "#08306b", 13},
    [CHART_BUFFER] = {"accumulation buffer", "#8a5a2b", 9},
    [CHART_BLEND] = {"blending", "#d9480f", 5},
    [CHART_TREE_8] = {"tree, 8 bits", "#00a8a0", 7},
    [CHART_TREE_16] = {"tree, 16 bits", "#62b5f0", 7},
    [CHART_TREE_32] = {"tree, floats", "#2171d5", 7},
};

// What the second panel shows: errors of these are far apart.
static const struct curve {
    const char *name, *label, *colour;
    int mark;
} curves[] = {
    {"exact", "exact", "#c2185b", 15},
    {"float target", "float", "#08306b", 13},
    {"buffer, 16 bits", "buffer 16 bits", "#8a5a2b", 9},
    {"blending, 8 bits", "blend 8 bits", "#d9480f", 5},
    {"blending, half floats", "blend half", "#e8a000", 5},
    {"tree of 2, 8 bits", "tree 2, 8 bits", "#004f4b", 7},
    {"tree of 4, 8 bits", "tree 4, 8 bits", "#00a8a0", 7},
    {"tree of 16, 8 bits", "tree 16, 8 bits", "#7fd6d2", 7},
    {"tree of 4, 16 bits", "tree 4, 16 bits", "#62b5f0", 7},
};

enum { CURVES = sizeof curves / sizeof *curves };

// Errors in codes of 8 bits; where there is none, at the lower end.
struct frames_plot {
    FILE *s;
    const struct chart_job *job;
    struct chart_range time, error, frames;
};

static double shown(const struct frames_plot *plot, double error)
{
    return fmax(255.0 * error, 1.2 * plot->error.low);
}

static bool is_last(const struct chart_frames *f, const struct chart_frames_point *p)
{
    return p->frames == f->count[f->counts - 1];
}

static void find_ranges(struct frames_plot *plot)
{
    const struct chart_frames *f = &plot->job->frames;
    plot->time = plot->error = plot->frames = (struct chart_range){DBL_MAX, DBL_MIN};
    for (size_t i = 0; i < f->points; i++) {
        const struct chart_frames_point *p = &f->point[i];
        if (*p->reason)
            continue;
        chart_extend_range(&plot->error, 255.0 * fmax(p->max_error, 1e-9));
        chart_extend_range(&plot->error, 255.0 * p->bound);
        chart_extend_range(&plot->frames, (double)p->frames);
        if (is_last(f, p))
            chart_extend_range(&plot->time, 1e3 * p->seconds / (double)p->frames);
    }
    if (plot->time.low > plot->time.high) // interrupted before that many frames
        plot->time = (struct chart_range){1e-2, 1.0};
    plot->time = (struct chart_range){plot->time.low / 1.6, plot->time.high * 1.9};
    plot->error = (struct chart_range){plot->error.low / 2.0, plot->error.high * 2.0};
    plot->frames = (struct chart_range){plot->frames.low / 1.2, plot->frames.high * 1.2};
}

// ---- time against error -------------------------------------------------------------------------

// What the colour does not tell: a tree's branching, a target's bits.
static void write_mark(const struct chart_frames_point *p, char out[CHART_TEXT])
{
    if (p->method.method == WEFT_ACCUMULATE_TREE)
        snprintf(out, CHART_TEXT, "%d%s", p->method.branching,
                 p->method.rounding == WEFT_TREE_UNBIASED ? "u" : "");
    else if (p->method.bits == WEFT_ACCUMULATE_HALF)
        snprintf(out, CHART_TEXT, "half");
    else if (p->method.bits)
        snprintf(out, CHART_TEXT, "%d bits", p->method.bits);
    else
        snprintf(out, CHART_TEXT, "%s", weft_accumulate_method_names[p->method.method]);
}

// Block $fN: ms a frame, error, bound and mark; false if there are none.
static bool write_family(const struct frames_plot *plot, int family)
{
    const struct chart_frames *f = &plot->job->frames;
    bool any = false;
    for (size_t i = 0; i < f->points; i++) {
        const struct chart_frames_point *p = &f->point[i];
        char mark[CHART_TEXT];
        if (*p->reason || (int)p->family != family || !is_last(f, p))
            continue;
        if (!any)
            fprintf(plot->s, "$f%d << EOD\n", family);
        any = true;
        write_mark(p, mark);
        fprintf(plot->s, "%.9g %.9g %.9g \"%s\"\n", 1e3 * p->seconds / (double)p->frames,
                shown(plot, p->max_error), shown(plot, p->bound), mark);
    }
    if (any)
        fputs("EOD\n", plot->s);
    return any;
}

static void write_time_panel(const struct frames_plot *plot)
{
    FILE *s = plot->s;
    bool has[CHART_FRAMES_FAMILIES];
    for (int i = 0; i < CHART_FRAMES_FAMILIES; i++)
        has[i] = write_family(plot, i);
    chart_set_panel(s, 0);
    chart_set_axis(s, "x", plot->time);
    chart_set_axis(s, "y", plot->error);
    fprintf(s,
            "set xlabel 'time of a frame, ms (of %" PRId64 ", from memory to memory)'\nset ylabel "
            "'largest error, codes of 8 bits'\nplot ",
            plot->job->frames.count[plot->job->frames.counts - 1]);
    for (int i = 0; i < CHART_FRAMES_FAMILIES; i++)
        if (has[i])
            fprintf(s,
                    "$f%d using 1:2:2:3 with yerrorbars notitle lc '#90%s' lw 0.8 ps 0, "
                    "$f%d using 1:2 with points notitle lc '%s' lw 1.4 pt %d ps 1.3, "
                    "$f%d using 1:2:4 with labels notitle left offset 0.7,-0.4 font 'sans,9' tc "
                    "'%s', ",
                    i, families[i].colour + 1, i, families[i].colour, families[i].mark, i,
                    families[i].colour);
    fputs("1/0 notitle\n", s);
}

// ---- error over the number of frames ------------------------------------------------------------

static bool write_curve(const struct frames_plot *plot, int number)
{
    const struct chart_frames *f = &plot->job->frames;
    bool any = false;
    for (size_t i = 0; i < f->points; i++) {
        const struct chart_frames_point *p = &f->point[i];
        if (*p->reason || strcmp(p->label, curves[number].label) != 0)
            continue;
        if (!any)
            fprintf(plot->s, "$c%d << EOD\n", number);
        any = true;
        fprintf(plot->s, "%" PRId64 " %.9g %.9g\n", p->frames, shown(plot, p->max_error),
                shown(plot, p->bound));
    }
    if (any)
        fputs("EOD\n", plot->s);
    return any;
}

static void set_frames_tics(const struct frames_plot *plot)
{
    const struct chart_frames *f = &plot->job->frames;
    fputs("set xtics (", plot->s);
    for (int i = 0; i < f->counts; i++)
        fprintf(plot->s, "%s%" PRId64, i ? ", " : "", f->count[i]);
    fputs(")\n", plot->s);
}

static void write_key(const struct frames_plot *plot, const bool *has)
{
    FILE *s = plot->s;
    for (int i = 0; i < CHART_FRAMES_FAMILIES; i++)
        fprintf(s, "1/0 with points lc '%s' lw 1.4 pt %d ps 1.3 title '%s', ", families[i].colour,
                families[i].mark, families[i].name);
    fputs("1/0 with lines lc '#ffffff' title ' ', ", s);
    for (int i = 0; i < CURVES; i++)
        if (has[i])
            fprintf(s, "1/0 with linespoints lc '%s' lw 1.6 pt %d ps 0.9 title '%s', ",
                    curves[i].colour, curves[i].mark, curves[i].name);
    fputs("1/0 with lines lc '#404040' lw 1 dt 2 title 'its bound'\n", s);
}

static void write_count_panel(const struct frames_plot *plot)
{
    FILE *s = plot->s;
    bool has[CURVES];
    for (int i = 0; i < CURVES; i++)
        has[i] = write_curve(plot, i);
    chart_set_panel(s, 1);
    chart_set_axis(s, "x", plot->frames);
    set_frames_tics(plot);
    fputs("set xlabel 'number of frames'\nunset ylabel\n", s);
    fprintf(s, "set key at screen %.5f,%.5f left top Left reverse samplen 2.5 spacing 1.25\nplot ",
            (double)(CHART_LEFT + 2 * CHART_PANEL + CHART_PANEL_GAP + 20) / CHART_PANELS_WIDTH,
            (double)CHART_TOP / CHART_HEIGHT);
    for (int i = 0; i < CURVES; i++)
        if (has[i])
            fprintf(s,
                    "$c%d using 1:3 with lines notitle lc '%s' lw 1 dt 2, "
                    "$c%d using 1:2 with linespoints notitle lc '%s' lw 1.6 pt %d ps 0.9, ",
                    i, curves[i].colour, i, curves[i].colour, curves[i].mark);
    write_key(plot, has);
}

// ---- the chart ----------------------------------------------------------------------------------

static enum weft_result write(FILE *s, const struct chart_job *job)
{
    struct frames_plot plot = {.s = s, .job = job};
    const struct chart_frames *f = &job->frames;
    const double left = (double)CHART_LEFT / CHART_PANELS_WIDTH;
    char title[CHART_REASON];
    find_ranges(&plot);
    snprintf(title, sizeof title, "noise on a ramp, 8-bit RGBA, %d x %d pixels", f->width,
             f->height);
    chart_put_label(s, left, (CHART_TOP + 50.0) / CHART_HEIGHT, "left font 'sans,15'",
                    "Averages of frames: time against error by every method, and error over the "
                    "number of frames");
    chart_put_label(s, left, (CHART_TOP + 25.0) / CHART_HEIGHT, "left font 'sans,12'", title);
    chart_put_caption(s, job, CHART_PANELS_WIDTH, CHART_HEIGHT,
                      "Lines upward, and dashed ones: to the bound that is proven. Numbers at "
                      "trees: inputs of a node, u: unbiased rounding.");
    fputs("set multiplot\nset logscale xy\nset format x '%g'\nset format y '%g'\nset key off\nset "
          "errorbars 0.5\n",
          s);
    write_time_panel(&plot);
    fputs("unset label\n", s);
    write_count_panel(&plot);
    fputs("unset multiplot\n", s);
    return WEFT_OK;
}

enum exit_code chart_frames_draw(const struct chart_job *job, const char *path, bool keep_script)
{
    return chart_draw_script(job, path, CHART_PANELS_WIDTH, CHART_HEIGHT, write, keep_script);
}
