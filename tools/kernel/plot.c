// SPDX-License-Identifier: BSD-3-Clause
// The curves of `weft kernel`: lists of points, and a plot of one kernel or of several.
#include <math.h>

#include "tools/draw/kernel_curve.h"
#include "tools/draw/plot.h"
#include "tools/kernel/facts.h"

// ---- curves -------------------------------------------------------------------------------------

// What --plot draws; --json lists every fourth point.
enum { CURVE_STEPS = 1200, SPECTRUM_STEPS = 800, LIST_STEP = 4 };
static const double spectrum_end = 4.0;

static double curve_position(const struct kernel_curve *curve, int i)
{
    return curve->end * (2.0 * i / CURVE_STEPS - 1.0);
}

static double spectrum_position(int i)
{
    return spectrum_end * i / SPECTRUM_STEPS;
}

void kernel_set_curves(json_t *root, const struct weft_kernel *kernel)
{
    json_t *x = json_array(), *h = json_array(), *slope = json_array();
    struct kernel_curve curve;
    kernel_curve_init(kernel, &curve);
    for (int i = 0; i <= CURVE_STEPS; i += LIST_STEP) {
        double at = curve_position(&curve, i);
        json_array_append_new(x, json_number(at));
        json_array_append_new(h, json_number(kernel_curve_value(&curve, at)));
        json_array_append_new(slope, json_number(kernel_curve_slope(&curve, at)));
    }
    json_t *frequency = json_array(), *gain = json_array();
    for (int i = 0; i <= SPECTRUM_STEPS; i += LIST_STEP) {
        double at = spectrum_position(i);
        json_array_append_new(frequency, json_number(at));
        json_array_append_new(gain,
                              json_number(kernel_magnitude(weft_analysis_response(kernel, at))));
    }
    json_object_set_new(root, "curve",
                        json_pack("{s:o,s:o,s:o}", "x", x, "value", h, "derivative", slope));
    json_object_set_new(root, "spectrum",
                        json_pack("{s:o,s:o}", "frequency", frequency, "magnitude", gain));
}

// ---- plot ---------------------------------------------------------------------------------------

struct drawing {
    FILE *script;
    const struct kernel_facts *const *facts;
    int count;
    struct kernel_curve curve[KERNEL_MOST];
    double end; // half-width shown, of the widest
    bool slopes, all_cardinal;
};

static void init(struct drawing *d, const struct kernel_facts *const *facts, int count)
{
    *d = (struct drawing){.facts = facts, .count = count, .all_cardinal = true};
    double compact = 4.5; // of several the long tails of cardinal splines are not shown
    for (int k = 0; k < count; k++) {
        kernel_curve_init(&facts[k]->kernel, &d->curve[k]);
        d->end = fmax(d->end, d->curve[k].end);
        compact = fmax(compact, facts[k]->kernel.prefiltered ? 0.0 : d->curve[k].end);
        d->slopes = d->slopes || d->curve[k].has_slope;
        d->all_cardinal = d->all_cardinal && facts[k]->kernel.prefiltered;
    }
    if (count > 1)
        d->end = fmin(d->end, compact);
}

// A panel's curves, each with its name in the legend; a single kernel's is `line`.
static void write_plot(const struct drawing *d, int line, bool slopes)
{
    const char *separator = "plot ";
    for (int k = 0; k < d->count; k++) {
        if (slopes && !d->curve[k].has_slope)
            continue;
        fprintf(d->script, "%s'-' with lines lt %d title ", separator, d->count > 1 ? k + 1 : line);
        plot_quote(d->script, d->facts[k]->name);
        separator = ", ";
    }
    putc('\n', d->script);
}

static void write_curves(const struct drawing *d, int line,
                         double (*f)(const struct kernel_curve *, double))
{
    const bool slopes = f == kernel_curve_slope;
    write_plot(d, line, slopes);
    for (int k = 0; k < d->count; k++) {
        if (slopes && !d->curve[k].has_slope)
            continue;
        for (int i = 0; i <= CURVE_STEPS; i++) {
            const double x = d->end * (2.0 * i / CURVE_STEPS - 1.0);
            fprintf(d->script, "%.9g %.9g\n", x, f(&d->curve[k], x));
        }
        fputs("e\n", d->script);
    }
}

static void write_spectra(const struct drawing *d, double lowest)
{
    write_plot(d, 3, false);
    for (int k = 0; k < d->count; k++) {
        for (int i = 0; i <= SPECTRUM_STEPS; i++) {
            const double f = spectrum_position(i);
            fprintf(d->script, "%.9g %.9g\n", f,
                    fmax(lowest, kernel_decibel(weft_analysis_response(&d->facts[k]->kernel, f))));
        }
        fputs("e\n", d->script);
    }
}

static void write_head(const struct drawing *d)
{
    FILE *s = d->script;
    char title[400];
    if (d->count > 1)
        snprintf(title, sizeof title, "%d reconstruction kernels", d->count);
    else
        snprintf(title, sizeof title, "%.250s: %s", d->facts[0]->name,
                 d->facts[0]->kernel.info->description);
    fprintf(s, "set multiplot layout %d,1 title ", d->slopes ? 3 : 2);
    plot_quote(s, title);
    // Kernels are near 0 at the right, so that the legend covers none.
    fprintf(s,
            " font ',14'\n%s\nset lmargin 10\nset rmargin 3\nset xzeroaxis lc '#808080'\n"
            "set xlabel 'x (sample distances)'\nset xrange [%g:%g]\nset offsets 0,0,graph 0.06,"
            "graph 0.06\nset xtics %g\nset ylabel '%s'\n",
            d->count > 1 ? "set key right top Right samplen 2" : "unset key", -d->end, d->end,
            d->end > 4.5 ? 2.0 : 1.0, d->all_cardinal ? "cardinal spline" : "h(x)");
}

static void write_all(const struct drawing *d)
{
    FILE *s = d->script;
    write_head(d);
    write_curves(d, 1, kernel_curve_value);
    fputs("unset key\n", s); // it is told
    if (d->slopes) {
        fprintf(s, "set ylabel \"%s\"\n", d->all_cardinal ? "its slope" : "h'(x)");
        write_curves(d, 2, kernel_curve_slope);
    }
    fprintf(s,
            "unset offsets\nset xlabel 'f (cycles per sample distance)'\nset ylabel '|H(f)| (dB)'\n"
            "set xrange [0:%g]\nset xtics 0.5\nset yrange [-100:*]\nset ytics 20\n"
            "set arrow from first 0.5, graph 0 to first 0.5, graph 1 nohead dt 2 lc '#808080'\n"
            "set label 'Nyquist' at first 0.53, graph 0.92 tc '#606060'\n",
            spectrum_end);
    write_spectra(d, -120.0);
    fputs("unset multiplot\n", s);
}

enum exit_code kernel_draw(const struct kernel_facts *const *facts, int count, const char *path)
{
    struct drawing d;
    struct plot plot;
    init(&d, facts, count);
    const enum exit_code code = plot_begin(path, 900, d.slopes ? 1050 : 750, &plot);
    if (code != EXIT_CODE_DONE)
        return code;
    d.script = plot.script;
    write_all(&d);
    return plot_finish(&plot);
}
