// SPDX-License-Identifier: BSD-3-Clause
// The charts of `weft chart`, drawn by gnuplot.
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"
#include "tools/options/kernels.h"
#include "tools/draw/plot.h"

// Pixels. The first chart's axes lie where labels can be placed by arithmetic.
enum { WIDTH = 1280, RIGHT = 960 };

// Fused methods are cold colours, the darker the more bits; passes are warm ones.
static const struct {
    const char *name, *colour;
    int mark; // of gnuplot
} families[CHART_FAMILIES] = {
    [CHART_FUSED + WEFT_SOURCE_FLOAT] = {"fused, 32f source", "#08306b", 7},
    [CHART_FUSED + WEFT_SOURCE_HALF] = {"fused, 16f source", "#2171d5", 7},
    [CHART_FUSED + WEFT_SOURCE_UNORM16] = {"fused, unorm16 source", "#62b5f0", 7},
    [CHART_FUSED + WEFT_SOURCE_UNORM8] = {"fused, unorm8 source", "#00a8a0", 7},
    [CHART_SEPARABLE] = {"separable", "#2e8b22", 13},
    [CHART_HARDWARE] = {"hardware filtering", "#8a9a00", 11},
    [CHART_CPU + WEFT_SUMS_FLOAT] = {"CPU engine, float sums", "#c2185b", 15},
    [CHART_CPU + WEFT_SUMS_DOUBLE] = {"CPU engine, double sums", "#6a0f3d", 15},
    [CHART_PASSES + WEFT_TECHNIQUE_PLAIN] = {"passes, plain", "#e8a000", 5},
    [CHART_PASSES + WEFT_TECHNIQUE_DOT4] = {"passes, dot4", "#d9480f", 5},
    [CHART_PASSES + WEFT_TECHNIQUE_SPLIT_PRECISION] = {"passes, split precision", "#d6339a", 5},
    [CHART_PASSES + WEFT_TECHNIQUE_HIERARCHICAL] = {"passes, hierarchical", "#7048c8", 5},
    [CHART_PASSES + WEFT_TECHNIQUE_LOG] = {"passes, log", "#8a5a2b", 5},
    [CHART_PEER] = {"peer", "#000000", 9},
};
static const int peer_marks[] = {9, 11, 3, 1, 2, 8, 10, 12};
static const char *const kernel_colours[] = {"#888888", "#2171d5", "#2e8b22", "#d9480f", "#d6339a",
                                             "#7048c8", "#e8a000", "#00a8a0", "#8a5a2b", "#08306b"};
enum {
    PEER_MARKS = sizeof peer_marks / sizeof *peer_marks,
    KERNEL_COLOURS = sizeof kernel_colours / sizeof *kernel_colours
};

// ---- the first chart ----------------------------------------------------------------------------

struct methods_plot {
    FILE *s;
    const struct chart_job *job;
    const struct chart *chart;
    struct chart_range x, y;
};

// Where errors of 0 are drawn: below all others.
static double shown_error(const struct methods_plot *plot, const struct chart_point *p)
{
    return p->max_error > plot->y.low ? p->max_error : plot->y.low * 1.2;
}

static void find_ranges(struct methods_plot *plot)
{
    plot->x = plot->y = (struct chart_range){DBL_MAX, DBL_MIN};
    for (size_t i = 0; i < plot->chart->count; i++) {
        chart_extend_range(&plot->x, 1e3 * plot->chart->point[i].seconds);
        chart_extend_range(&plot->y, plot->chart->point[i].max_error);
    }
    const double most = plot->y.high;
    for (size_t i = 0; i < plot->chart->count; i++) // bounds far above all errors are cut
        if (plot->chart->point[i].bound > 0.0)
            chart_extend_range(&plot->y, fmin(plot->chart->point[i].bound, 30.0 * most));
    if (plot->y.low > plot->y.high)
        plot->y = (struct chart_range){1e-9, 1.0};
    plot->x = (struct chart_range){plot->x.low / 1.6, plot->x.high * 1.6};
    plot->y = (struct chart_range){plot->y.low / 3.0, plot->y.high * 2.0};
}

static double to_pixels(double value, struct chart_range range, double pixels)
{
    return pixels * log(value / range.low) / log(range.high / range.low);
}

// The error as parts of the range of the voxels, in bits, on the right.
static void set_bits_axis(const struct methods_plot *plot)
{
    const double width = plot->job->statistics.voxel_high - plot->job->statistics.voxel_low;
    if (!(width > 0.0))
        return;
    fprintf(plot->s,
            "set logscale y2\nset y2range [%.9g:%.9g]\nset ytics nomirror\nset y2label 'of the "
            "range of the voxels, bits' offset 0.5\nset y2tics (",
            plot->y.low, plot->y.high);
    for (int bits = 0; bits <= 40; bits += 4)
        fprintf(plot->s, "%s'%d' %.9g", bits ? ", " : "", bits, ldexp(width, -bits));
    fputs(")\n", plot->s);
}

static void set_frame(const struct methods_plot *plot)
{
    FILE *s = plot->s;
    char title[2 * KERNELS_TEXT], others[CHART_TEXT] = "";
    const struct weft_slice_geometry *g = &plot->job->geometry;
    for (int k = 1; k < plot->chart->kernel_count; k++)
        snprintf(others, sizeof others, " (grey: other kernels, fused)");
    snprintf(title, sizeof title, "%s, %s, %d x %d pixels, %s%s", chart_source_name(plot->job),
             plot->job->plane, g->width, g->height, plot->chart->kernel[0].text, others);
    fprintf(s,
            "set logscale xy\nset lmargin at screen %.5f\nset rmargin at screen %.5f\nset bmargin "
            "at screen %.5f\nset tmargin at screen %.5f\n",
            (double)CHART_LEFT / WIDTH, (double)RIGHT / WIDTH, (double)CHART_BOTTOM / CHART_HEIGHT,
            (double)CHART_TOP / CHART_HEIGHT);
    chart_put_label(s, (double)CHART_LEFT / WIDTH, (CHART_TOP + 50.0) / CHART_HEIGHT,
                    "left font 'sans,15'",
                    "Time against error: every method of computing one slice");
    chart_put_label(s, (double)CHART_LEFT / WIDTH, (CHART_TOP + 25.0) / CHART_HEIGHT,
                    "left font 'sans,12'", title);
    chart_set_axis(s, "x", plot->x);
    chart_set_axis(s, "y", plot->y);
    fputs("set format x '%g'\nset format y '%g'\nset xlabel 'time of a slice, ms (voxels in memory "
          "to pixels in memory)'\nset ylabel 'largest error against double precision'\n",
          s);
    set_bits_axis(plot);
    fprintf(s, "set key at screen %.5f,%.5f left top Left reverse samplen 1.2 spacing 1.25\n",
            (RIGHT + 75.0) / WIDTH, (double)CHART_TOP / CHART_HEIGHT);
    chart_put_caption(
        s, plot->job, WIDTH, CHART_HEIGHT,
        "Hollow: kernel weights from sampled tiles. Lines upward: to the bound that the plan "
        "promised. Step line: nothing measured is faster and as accurate, within a thousandth.");
}

static bool is_other_kernel(const struct chart_point *p)
{
    return p->kernel > 0;
}

static bool is_sampled(const struct chart_point *p)
{
    return p->family < CHART_SEPARABLE && p->method.lookup != WEFT_LOOKUP_POLYNOMIAL;
}

// A group of points that look alike: a family, or what of it looks its weights up in sampled tiles,
// or the kernels beside the first.
struct group {
    enum chart_family family;
    bool sampled, other;
    const char *technique; // of peers
};

static bool is_in(const struct group *group, const struct chart_point *p)
{
    return p->family == group->family && is_sampled(p) == group->sampled &&
           is_other_kernel(p) == group->other &&
           (!group->technique || strcmp(group->technique, p->technique) == 0);
}

// Writes the points of a group as block $bN; false if there are none.
static bool write_block(const struct methods_plot *plot, const struct group *group, int number)
{
    bool any = false;
    for (size_t i = 0; i < plot->chart->count; i++) {
        const struct chart_point *p = &plot->chart->point[i];
        if (!is_in(group, p))
            continue;
        if (!any)
            fprintf(plot->s, "$b%d << EOD\n", number);
        any = true;
        const double error = shown_error(plot, p);
        fprintf(plot->s, "%.9g %.9g %.9g\n", 1e3 * p->seconds, error,
                p->bound > error ? p->bound : error);
    }
    if (any)
        fputs("EOD\n", plot->s);
    return any;
}

static void append_group(FILE *plots, FILE *bounds, const struct group *group, int number, int mark,
                         bool named)
{
    const char *colour = group->other ? "#909090" : families[group->family].colour;
    fprintf(bounds, "$b%d using 1:2:2:3 with yerrorbars notitle lc '#90%s' lw 0.8 ps 0, ", number,
            colour + 1); // see-through
    fprintf(plots, "$b%d using 1:2 with points lc '%s' lw 1.4 pt %d ps %s ", number, colour,
            group->sampled || group->other ? 6 : mark, group->sampled ? "1.0" : "1.3");
    if (named) {
        fputs("title ", plots);
        plot_quote(plots, group->technique ? group->technique : families[group->family].name);
    } else {
        fputs("notitle", plots);
    }
    fputs(", ", plots);
}

// Data blocks go to the script at once; what plots them is gathered, bounds to be drawn first.
static void write_groups(const struct methods_plot *plot, FILE *plots, FILE *bounds)
{
    int number = 0;
    for (int f = 0; f < CHART_PEER; f++) {
        for (int look = 0; look < 3; look++) {
            const struct group group = {
                .family = (enum chart_family)f, .sampled = look == 1, .other = look == 2};
            if (write_block(plot, &group, ++number))
                append_group(plots, bounds, &group, number, families[f].mark, look == 0);
        }
    }
    int peers = 0;
    for (size_t i = 0; i < plot->chart->count; i++) {
        const struct chart_point *p = &plot->chart->point[i];
        const struct group group = {.family = CHART_PEER, .technique = p->technique};
        bool first = p->family == CHART_PEER;
        for (size_t j = 0; j < i && first; j++)
            first = !is_in(&group, &plot->chart->point[j]);
        if (first && write_block(plot, &group, ++number))
            append_group(plots, bounds, &group, number, peer_marks[peers++ % PEER_MARKS], true);
    }
}

static int compare_seconds(const void *a, const void *b)
{
    const struct chart_point *x = *(const struct chart_point *const *)a;
    const struct chart_point *y = *(const struct chart_point *const *)b;
    return (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

// The front by time; the corners of the step line are what its points leave possible.
static void write_front(const struct methods_plot *plot, const struct chart_point **sorted)
{
    size_t count = 0;
    for (size_t i = 0; i < plot->chart->count; i++)
        if (plot->chart->point[i].front)
            sorted[count++] = &plot->chart->point[i];
    qsort(sorted, count, sizeof *sorted, compare_seconds);
    fputs("$front << EOD\n", plot->s);
    for (size_t i = 0; i < count; i++) {
        const double error = shown_error(plot, sorted[i]);
        if (i == 0)
            fprintf(plot->s, "%.9g %.9g\n", 1e3 * sorted[i]->seconds, plot->y.high);
        fprintf(plot->s, "%.9g %.9g\n", 1e3 * sorted[i]->seconds, error);
        if (i + 1 == count)
            fprintf(plot->s, "%.9g %.9g\n", plot->x.high, error);
    }
    fputs("EOD\n", plot->s);
}

// Colours tell method and technique; the label tells the rest.
static void shorten(const struct chart_point *p, const struct chart *chart, char out[CHART_TEXT])
{
    const struct weft_method *w = &p->method;
    const bool cpu = p->family >= CHART_CPU && p->family < CHART_PASSES;
    if (is_other_kernel(p))
        snprintf(out, CHART_TEXT, "%s %s", chart->kernel[p->kernel].text,
                 cpu ? "cpu" : weft_source_format_name(w->source));
    else if (p->family == CHART_PEER || p->family == CHART_SEPARABLE ||
             p->family == CHART_HARDWARE || cpu)
        snprintf(out, CHART_TEXT, "%s", p->label);
    else if (p->family < CHART_SEPARABLE && w->lookup == WEFT_LOOKUP_POLYNOMIAL)
        snprintf(out, CHART_TEXT, "%s %s", weft_layout_name(w->layout),
                 weft_source_format_name(w->source));
    else if (p->family < CHART_SEPARABLE)
        snprintf(out, CHART_TEXT, "%s %s, M=%d %s", weft_layout_name(w->layout),
                 weft_source_format_name(w->source), w->samples, weft_lookup_names[w->lookup]);
    else
        snprintf(out, CHART_TEXT, "%s", p->label + strlen("passes "));
}

// The front, peers, and other kernels in single precision.
static bool has_label(const struct chart_point *p)
{
    return p->front || p->family == CHART_PEER ||
           (is_other_kernel(p) && p->method.source == WEFT_SOURCE_FLOAT);
}

static void write_label(const struct methods_plot *plot, const struct chart_label *label,
                        const struct chart_point *p)
{
    const double x = (CHART_LEFT + label->at_x) / WIDTH,
                 y = (CHART_BOTTOM + label->at_y) / CHART_HEIGHT;
    if (hypot(label->at_x - label->x, label->at_y - label->y) > 16.0)
        fprintf(plot->s,
                "set arrow from screen %.5f,%.5f to screen %.5f,%.5f nohead lc '#808080' lw 0.7\n",
                (CHART_LEFT + label->x) / WIDTH, (CHART_BOTTOM + label->y) / CHART_HEIGHT, x, y);
    char style[64];
    snprintf(style, sizeof style, "%s font 'sans,11' tc '%s' front boxed",
             label->side > 0   ? "left"
             : label->side < 0 ? "right"
                               : "center",
             is_other_kernel(p) ? "#707070" : families[p->family].colour);
    chart_put_label(plot->s, x, y, style, label->text);
}

static enum weft_result write_labels(const struct methods_plot *plot)
{
    const struct chart *chart = plot->chart;
    const double width = RIGHT - CHART_LEFT, height = CHART_TOP - CHART_BOTTOM;
    double(*points)[2] = calloc(chart->count, sizeof *points);
    struct chart_label *labels = calloc(chart->count, sizeof *labels);
    const struct chart_point **of = calloc(chart->count, sizeof *of);
    int count = 0;
    enum weft_result res = points && labels && of ? WEFT_OK : WEFT_ERR_MEMORY;
    for (size_t i = 0; i < chart->count && res == WEFT_OK; i++) {
        const struct chart_point *p = &chart->point[i];
        points[i][0] = to_pixels(1e3 * p->seconds, plot->x, width);
        points[i][1] = to_pixels(shown_error(plot, p), plot->y, height);
        if (!has_label(p))
            continue;
        of[count] = p;
        labels[count] = (struct chart_label){.x = points[i][0], .y = points[i][1]};
        shorten(p, chart, labels[count++].text);
    }
    if (res == WEFT_OK)
        chart_labels_place(labels, count, (const double(*)[2])points, chart->count, width, height);
    for (int i = 0; i < count; i++)
        write_label(plot, &labels[i], of[i]);
    free(points);
    free(labels);
    free(of);
    return res;
}

static enum weft_result write_methods(FILE *s, const struct chart_job *job)
{
    struct methods_plot plot = {.s = s, .job = job, .chart = &job->methods};
    char *plots = NULL, *bounds = NULL;
    size_t plots_size, bounds_size;
    FILE *plots_out = open_memstream(&plots, &plots_size);
    FILE *bounds_out = open_memstream(&bounds, &bounds_size);
    const struct chart_point **sorted = calloc(plot.chart->count, sizeof *sorted);
    enum weft_result res = plots_out && bounds_out && sorted ? WEFT_OK : WEFT_ERR_MEMORY;
    find_ranges(&plot);
    if (res == WEFT_OK) {
        set_frame(&plot);
        res = write_labels(&plot);
        write_groups(&plot, plots_out, bounds_out);
        write_front(&plot, sorted);
    }
    if (plots_out && !report_close(plots_out))
        res = WEFT_ERR_MEMORY;
    if (bounds_out && !report_close(bounds_out))
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        fprintf(s,
                "set errorbars 0.5\nset style textbox opaque noborder margins 0.2,0.2\nplot "
                "%s$front using 1:2 with steps lc '#404040' lw 1.2 dt 2 "
                "title 'Pareto front', %s 1/0 notitle\n",
                bounds, plots);
    free(plots);
    free(bounds);
    free(sorted);
    return res;
}

// ---- the second chart ---------------------------------------------------------------------------

// Bits of looks: formats of the source hardly change the time.
enum { TRUTH_LOOKS = 4, OVER_TIME = 1 | 8, OVER_SAMPLES = 15 };

// By how the signal's samples are held and summed, in the order of the methods measured.
static int look_of(const struct chart_point *p)
{
    return p->family >= CHART_PASSES                 ? 3
           : p->method.source == WEFT_SOURCE_FLOAT   ? 0
           : p->method.source == WEFT_SOURCE_UNORM16 ? 1
                                                     : 2;
}

static const struct {
    const char *name;
    int mark, dash;
} looks[TRUTH_LOOKS] = {
    {"fused, 32f source", 7, 1},
    {"fused, unorm16 source", 6, 4},
    {"fused, unorm8 source", 4, 2},
    {"passes, unorm8 dot4 M=32", 2, 3},
};

// Blocks $kK_L: voxels, ms and RMS of kernel K in look L over the sizes; false if there are none.
static bool write_truth_block(FILE *s, const struct chart *chart, int kernel, int look)
{
    bool any = false;
    for (size_t i = 0; i < chart->count; i++) {
        const struct chart_point *p = &chart->point[i];
        if (p->kernel != kernel || look_of(p) != look)
            continue;
        if (!any)
            fprintf(s, "$k%d_%d << EOD\n", kernel, look);
        any = true;
        fprintf(s, "%d %.9g %.9g\n", p->voxels, 1e3 * p->seconds, p->rms_error);
    }
    if (any)
        fputs("EOD\n", s);
    return any;
}

static void append_truth(FILE *s, const struct chart *chart, int column, const unsigned *has,
                         unsigned wanted)
{
    fputs("plot ", s);
    for (int k = 0; k < chart->kernel_count; k++)
        for (int l = 0; l < TRUTH_LOOKS; l++)
            if (has[k] & wanted & 1u << l)
                fprintf(s,
                        "$k%d_%d using %d:3 with linespoints lc '%s' lw 1.5 dt %d pt %d ps 1 "
                        "notitle, ",
                        k, l, column, kernel_colours[k % KERNEL_COLOURS], looks[l].dash,
                        looks[l].mark);
}

static void append_truth_key(FILE *s, const struct chart *chart)
{
    for (int k = 0; k < chart->kernel_count; k++) {
        fprintf(s, "1/0 with lines lc '%s' lw 4 title ", kernel_colours[k % KERNEL_COLOURS]);
        plot_quote(s, chart->kernel[k].text);
        fputs(", ", s);
    }
    for (int l = 0; l < TRUTH_LOOKS; l++)
        fprintf(s, "1/0 with linespoints lc '#404040' lw 1.5 dt %d pt %d ps 1 title '%s', ",
                looks[l].dash, looks[l].mark, looks[l].name);
}

static void find_truth_ranges(const struct chart *chart, struct chart_range *time,
                              struct chart_range *error, struct chart_range *voxels)
{
    *time = *error = *voxels = (struct chart_range){DBL_MAX, DBL_MIN};
    for (size_t i = 0; i < chart->count; i++) {
        chart_extend_range(time, 1e3 * chart->point[i].seconds);
        chart_extend_range(error, chart->point[i].rms_error);
        chart_extend_range(voxels, chart->point[i].voxels);
    }
    if (error->low > error->high)
        *error = (struct chart_range){1e-9, 1.0};
    *time = (struct chart_range){time->low / 1.3, time->high * 1.3};
    *error = (struct chart_range){error->low / 1.5, error->high * 1.5};
    *voxels = (struct chart_range){voxels->low / 1.1, voxels->high * 1.1};
}

static void set_voxel_tics(FILE *s, const struct chart *chart)
{
    fputs("set xtics (", s);
    int last = 0;
    for (size_t i = 0; i < chart->count; i++) {
        if (chart->point[i].voxels <= last)
            continue;
        fprintf(s, "%s'%d^3' %d", last ? ", " : "", chart->point[i].voxels, chart->point[i].voxels);
        last = chart->point[i].voxels;
    }
    fputs(")\n", s);
}

// For comparison, the RMS error of one rounding to 8 bits; signals are 0 to 1, but for distances.
static void put_eight_bits(FILE *s, const struct chart_job *job, bool named)
{
    const double error = 1.0 / 255.0 / sqrt(12.0);
    if (job->signal->level_set)
        return;
    fprintf(s, "set arrow from graph 0,first %.9g to graph 1,first %.9g nohead lc '#a0a0a0' dt 3\n",
            error, error);
    if (named)
        fprintf(s,
                "set label 'one rounding to 8 bits' at graph 0.02,first %.9g offset 0,0.5 font "
                "'sans,10' tc '#808080'\n",
                error);
}

static enum weft_result write_truth(FILE *s, const struct chart_job *job)
{
    const struct chart *chart = &job->truth;
    struct chart_range time, error, voxels;
    unsigned has[CHART_MAX_KERNELS] = {0};
    char title[CHART_REASON];
    const struct option_value *size = &job->option[CHART_SIZE];
    find_truth_ranges(chart, &time, &error, &voxels);
    for (int k = 0; k < chart->kernel_count; k++)
        for (int l = 0; l < TRUTH_LOOKS; l++)
            has[k] |= (unsigned)write_truth_block(s, chart, k, l) << l;
    const double left = (double)CHART_LEFT / CHART_PANELS_WIDTH;
    snprintf(title, sizeof title, "%s, oblique slice, %s pixels, lines over the number of samples",
             job->signal->name,
             size->given                      ? size->text
             : job->option[CHART_QUICK].given ? "256 x 256"
                                              : "512 x 512");
    chart_put_label(
        s, left, (CHART_TOP + 50.0) / CHART_HEIGHT, "left font 'sans,15'",
        "Kernels against the signal itself: what better kernels, more samples and more bits "
        "are worth");
    chart_put_label(s, left, (CHART_TOP + 25.0) / CHART_HEIGHT, "left font 'sans,12'", title);
    chart_put_caption(
        s, job, CHART_PANELS_WIDTH, CHART_HEIGHT,
        "RMS of the total error, the kernel's own included, over all pixels. Where a dashed "
        "line leaves the solid one, bits limit; where they lie together, kernel and "
        "sampling do, and more bits do not pay.");
    fputs("set multiplot\nset logscale xy\nset format y '%g'\nset key off\n", s);
    chart_set_axis(s, "y", error);
    put_eight_bits(s, job, false);
    chart_set_panel(s, 0);
    chart_set_axis(s, "x", time);
    fputs("set xlabel 'time of a slice, ms'\nset ylabel 'RMS error against the signal'\n", s);
    append_truth(s, chart, 2, has, OVER_TIME);
    fputs("1/0\nunset label\nunset arrow\n", s);
    chart_set_panel(s, 1);
    put_eight_bits(s, job, true);
    chart_set_axis(s, "x", voxels);
    set_voxel_tics(s, chart);
    fputs("set xlabel 'samples of the signal'\nunset ylabel\n", s);
    fprintf(s, "set key at screen %.5f,%.5f left top Left reverse samplen 3 spacing 1.25\n",
            (double)(CHART_LEFT + 2 * CHART_PANEL + CHART_PANEL_GAP + 20) / CHART_PANELS_WIDTH,
            (double)CHART_TOP / CHART_HEIGHT);
    append_truth(s, chart, 1, has, OVER_SAMPLES);
    append_truth_key(s, chart);
    fputs("1/0 notitle\nunset multiplot\n", s);
    return WEFT_OK;
}

enum exit_code chart_draw(const struct chart_job *job, const struct chart *chart, const char *path,
                          bool keep_script)
{
    const bool methods = chart == &job->methods;
    return chart_draw_script(job, path, methods ? WIDTH : CHART_PANELS_WIDTH, CHART_HEIGHT,
                             methods ? write_methods : write_truth, keep_script);
}
