// SPDX-License-Identifier: BSD-3-Clause
// weft kernel: what a kernel is and does to a signal, as text, JSON and plot.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/draw/kernel_curve.h"
#include "tools/options/kernels.h"
#include "tools/draw/plot.h"
#include "tools/common/report.h"
#include "tools/verbs/verb.h"

enum { KERNEL_LIST, KERNEL_PLOT, KERNEL_JSON, KERNEL_QUIET, KERNEL_VERBOSE, KERNEL_OPTION_COUNT };

static const struct option_spec options[KERNEL_OPTION_COUNT] = {
    [KERNEL_LIST] = {.name = "list",
                     'l',
                     OPTION_FLAG,
                     NULL,
                     "list the kernels: parameters and their ranges, taps, orders (with --json: "
                     "as JSON)",
                     .group = OPTION_REPORTS,
                     .brief = "all kernels, a line each"},
    [KERNEL_PLOT] = {.name = "plot",
                     'p',
                     OPTION_OUTPUT,
                     PLOT_VALUE,
                     "kernel, derivative and spectrum as a picture (needs gnuplot)",
                     plot_endings,
                     .group = OPTION_PICTURES,
                     .brief = "kernel, slope and spectrum as a picture"},
    [KERNEL_JSON] = OPTIONS_JSON("everything, with the curves that --plot draws"),
    [KERNEL_QUIET] = OPTIONS_QUIET,
    [KERNEL_VERBOSE] = OPTIONS_VERBOSE,
};

enum { MOMENTS = 6, TAYLOR_ORDERS = 5, TAYLOR_POSITIONS = 4, FREQUENCIES = 9, DIMS = 3 };

static const double taylor_positions[TAYLOR_POSITIONS] = {0.0, 0.25, 0.5, 0.75};
static const double frequencies[FREQUENCIES] = {0.0, 0.125, 0.25, 0.375, 0.5, 0.75, 1.0, 1.5, 2.0};

struct facts {
    struct weft_kernel kernel;
    char name[KERNELS_TEXT];
    const char *symmetry; // "even", "odd" or "none"
    bool unit_sum;
    struct weft_analysis_order order;
    struct weft_analysis_order interpolator; // with weft's prefilter; order 0 where there is none
    double moment[MOMENTS];
    double taylor[TAYLOR_ORDERS][TAYLOR_POSITIONS];
    struct weft_analysis_response response[FREQUENCIES];
    struct weft_analysis_metrics metrics[DIMS];
    struct weft_analysis_overshoot overshoot;
    double gain;
};

// From positions where no kernel jumps.
static const char *find_symmetry(const struct weft_kernel *kernel)
{
    bool even = true, odd = true;
    for (int i = 0; i < 997; i++) {
        double x = kernel->support * (i + 0.5) / 997, tolerance = 1e-12;
        double a = weft_kernel_weight(kernel, x), b = weft_kernel_weight(kernel, -x);
        even &= fabs(a - b) <= tolerance;
        odd &= fabs(a + b) <= tolerance;
    }
    return even ? "even" : odd ? "odd" : "none";
}

static void gather(struct facts *f)
{
    const struct weft_kernel *kernel = &f->kernel;
    weft_kernel_format(kernel, f->name, sizeof f->name);
    f->symmetry = find_symmetry(kernel);
    f->order = weft_analysis_order(kernel);
    struct weft_kernel own = *kernel;
    if (kernel->info->derivation == 0 && weft_kernel_make_prefiltered(NULL, &own) == WEFT_OK)
        f->interpolator = weft_analysis_order(&own);
    // A table's record cannot know.
    f->unit_sum = kernel->unit_sum ||
                  (kernel->info->derivation == 0 && !kernel->radial && f->order.order > 0);
    for (int n = 0; n < MOMENTS; n++)
        f->moment[n] = weft_analysis_moment(kernel, n);
    for (int n = 0; n < TAYLOR_ORDERS; n++)
        for (int i = 0; i < TAYLOR_POSITIONS; i++)
            f->taylor[n][i] = weft_analysis_taylor(kernel, n, taylor_positions[i]);
    for (int i = 0; i < FREQUENCIES; i++)
        f->response[i] = weft_analysis_response(kernel, frequencies[i]);
    for (int d = 0; d < DIMS; d++)
        f->metrics[d] = weft_analysis_metrics(kernel, d + 1);
    f->overshoot = weft_analysis_overshoot(kernel);
    f->gain = weft_analysis_gain(kernel);
}

static bool needs_prefilter(const struct facts *f)
{
    return f->kernel.info->derivation == 0 && !f->kernel.radial && !f->kernel.interpolating &&
           !f->kernel.prefiltered && f->order.prefiltered > f->order.order;
}

static double magnitude(struct weft_analysis_response h)
{
    return hypot(h.re, h.im);
}

// The integrals are good to about 1e-12: what is below is zero.
static double decibel(struct weft_analysis_response h)
{
    return magnitude(h) > 1e-12 ? 20.0 * log10(magnitude(h)) : -INFINITY;
}

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

static void set_curves(json_t *root, const struct weft_kernel *kernel)
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
        json_array_append_new(gain, json_number(magnitude(weft_analysis_response(kernel, at))));
    }
    json_object_set_new(root, "curve",
                        json_pack("{s:o,s:o,s:o}", "x", x, "value", h, "derivative", slope));
    json_object_set_new(root, "spectrum",
                        json_pack("{s:o,s:o}", "frequency", frequency, "magnitude", gain));
}

// ---- plot ---------------------------------------------------------------------------------------

static void write_curve(FILE *script, const struct kernel_curve *curve,
                        double (*f)(const struct kernel_curve *, double))
{
    for (int i = 0; i <= CURVE_STEPS; i++) {
        double x = curve_position(curve, i);
        fprintf(script, "%.9g %.9g\n", x, f(curve, x));
    }
    fputs("e\n", script);
}

static void write_spectrum(FILE *script, const struct weft_kernel *kernel, double lowest)
{
    for (int i = 0; i <= SPECTRUM_STEPS; i++) {
        double f = spectrum_position(i);
        fprintf(script, "%.9g %.9g\n", f, fmax(lowest, decibel(weft_analysis_response(kernel, f))));
    }
    fputs("e\n", script);
}

static enum exit_code draw(const struct facts *f, const char *path)
{
    const struct weft_kernel *kernel = &f->kernel;
    struct kernel_curve curve;
    struct plot plot;
    kernel_curve_init(kernel, &curve);
    const bool slope = curve.has_slope;
    enum exit_code code = plot_begin(path, 900, slope ? 1050 : 750, &plot);
    if (code != EXIT_CODE_DONE)
        return code;
    FILE *s = plot.script;
    char title[400];
    snprintf(title, sizeof title, "%.250s: %s", f->name, kernel->info->description);
    fprintf(s, "set multiplot layout %d,1 title ", slope ? 3 : 2);
    plot_quote(s, title);
    fprintf(s,
            " font ',14'\nunset key\nset lmargin 10\nset rmargin 3\nset xzeroaxis lc '#808080'\n"
            "set xlabel 'x (sample distances)'\nset xrange [%g:%g]\nset offsets 0,0,graph 0.06,"
            "graph 0.06\nset xtics %g\nset ylabel '%s'\nplot '-' with lines lt 1\n",
            -curve.end, curve.end, curve.end > 4.5 ? 2.0 : 1.0,
            kernel->prefiltered ? "cardinal spline" : "h(x)");
    write_curve(s, &curve, kernel_curve_value);
    if (slope) {
        fprintf(s, "set ylabel \"%s\"\nplot '-' with lines lt 2\n",
                kernel->prefiltered ? "its slope" : "h'(x)");
        write_curve(s, &curve, kernel_curve_slope);
    }
    fprintf(s,
            "unset offsets\nset xlabel 'f (cycles per sample distance)'\nset ylabel '|H(f)| (dB)'\n"
            "set xrange [0:%g]\nset xtics 0.5\nset yrange [-100:*]\nset ytics 20\n"
            "set arrow from first 0.5, graph 0 to first 0.5, graph 1 nohead dt 2 lc '#808080'\n"
            "set label 'Nyquist' at first 0.53, graph 0.92 tc '#606060'\n"
            "plot '-' with lines lt 3\n",
            spectrum_end);
    write_spectrum(s, kernel, -120.0);
    fputs("unset multiplot\n", s);
    return plot_finish(&plot);
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *taylor_json(const struct facts *f)
{
    json_t *list = json_array();
    for (int n = 0; n < TAYLOR_ORDERS; n++)
        json_array_append_new(list, json_numbers(f->taylor[n], TAYLOR_POSITIONS));
    return json_pack("{s:o,s:o}", "t", json_numbers(taylor_positions, TAYLOR_POSITIONS), "a", list);
}

static json_t *response_json(const struct facts *f)
{
    json_t *list = json_array();
    for (int i = 0; i < FREQUENCIES; i++)
        json_array_append_new(
            list, json_pack("{s:o,s:o,s:o}", "frequency", json_number(frequencies[i]), "re",
                            json_number(f->response[i].re), "im", json_number(f->response[i].im)));
    return list;
}

static json_t *metrics_json(const struct facts *f)
{
    if (f->kernel.info->derivation) // they say nothing there
        return json_null();
    json_t *list = json_array();
    for (int d = 0; d < DIMS; d++)
        json_array_append_new(list, json_pack("{s:i,s:o,s:o}", "dims", d + 1, "smoothing",
                                              json_number(f->metrics[d].smoothing), "postaliasing",
                                              json_number(f->metrics[d].postaliasing)));
    return list;
}

static enum weft_result print_json(const struct facts *f)
{
    const struct weft_kernel *k = &f->kernel;
    const struct weft_analysis_order *o = &f->order;
    json_t *params = json_object();
    for (int p = 0; p < WEFT_KERNEL_PARAMS && k->info->params[p].name; p++)
        json_object_set_new(params, k->info->params[p].name, json_number(k->param[p]));
    json_t *root = json_pack(
        "{s:s,s:o,s:o,s:o,s:o,s:o,s:i,s:i,s:i,s:s,s:b,s:b,s:b,s:b,s:i}", "weft", weft_version(),
        "kernel", json_text(f->name), "description", json_text(k->info->description), "citation",
        k->info->citation ? json_text(k->info->citation) : json_null(), "parameters", params,
        "support", json_number(k->support), "taps", k->width, "degree", k->info->degree,
        "continuity", k->continuity, "symmetry", f->symmetry, "radial", k->radial, "interpolating",
        k->interpolating, "unit_sum", f->unit_sum, "needs_prefilter", needs_prefilter(f),
        "derivative", k->info->derivation);
    json_object_set_new(root, "prefiltered", json_boolean(k->prefiltered));
    json_object_set_new(root, "order",
                        json_pack("{s:i,s:o,s:o,s:i,s:o,s:i,s:o}", "order", o->order, "constant",
                                  json_number(o->constant), "largest", json_number(o->largest),
                                  "prefiltered", o->prefiltered, "prefiltered_constant",
                                  json_number(o->prefiltered_constant), "interpolator",
                                  f->interpolator.order, "interpolator_constant",
                                  json_number(f->interpolator.constant)));
    json_object_set_new(root, "moments", json_numbers(f->moment, MOMENTS));
    json_object_set_new(root, "taylor", taylor_json(f));
    json_object_set_new(root, "response", response_json(f));
    json_object_set_new(root, "marschner_lobb", metrics_json(f));
    json_object_set_new(root, "overshoot",
                        json_pack("{s:o,s:o,s:o}", "above", json_number(f->overshoot.above),
                                  "below", json_number(f->overshoot.below), "gain",
                                  json_number(f->gain)));
    set_curves(root, k);
    return json_print(root);
}

// ---- text ---------------------------------------------------------------------------------------

// What rounding leaves of a zero.
static double tidy(double x)
{
    return fabs(x) < 1e-13 ? 0.0 : x;
}

static void print_radial(const struct weft_kernel *k)
{
    puts("  radial           yes: the weight is h of the distance in 2D and 3D, not a product;\n"
         "                   orders, moments and all below them are those in 1D");
    for (int dims = 2; dims <= 3; dims++) {
        struct weft_kernel_sums sums = weft_kernel_radial_sums(k, dims);
        printf("  sums in %dD       %.6g to %.6g%s\n", dims, tidy(sums.least) + 0.0,
               tidy(sums.largest) + 0.0,
               sums.least * sums.largest > 0.0 ? "" : ": +unit cannot divide by them");
    }
}

static void print_head(const struct facts *f)
{
    const struct weft_kernel *k = &f->kernel;
    printf("%s: %s", f->name, k->info->description);
    if (k->info->citation)
        printf(" (%s)", k->info->citation);
    puts("");
    if (k->radial)
        print_radial(k);
    for (int p = 0; p < WEFT_KERNEL_PARAMS && k->info->params[p].name; p++)
        printf("  parameter        %s = %g in [%g, %g], default %g\n", k->info->params[p].name,
               k->param[p], k->info->params[p].min, k->info->params[p].max,
               k->info->params[p].initial);
    printf("  support          [%g, %g), %d tap%s per axis\n", -k->support, k->support, k->width,
           k->width == 1 ? "" : "s");
    printf("  symmetry         %s\n", f->symmetry);
    if (k->info->degree >= 0)
        printf("  form             piecewise polynomials of degree %d\n", k->info->degree);
    if (k->continuity < 0)
        puts("  continuity       it jumps");
    else
        printf("  continuity       C%d\n", k->continuity);
    if (k->info->derivation)
        printf("  reconstructs     derivative %d of the signal\n", k->info->derivation);
    printf("  interpolating    %s\n", k->interpolating ? "yes" : "no");
    if (k->info->derivation)
        puts("  unit sum         no: the weights of a derivative add up to 0");
    else
        printf("  unit sum         %s\n", k->normalised ? "yes: divided by their sum (+unit)"
                                          : k->radial   ? "no: +radial+unit divides by the sum"
                                          : f->unit_sum ? "yes"
                                                        : "no: NAME+unit divides by the sum");
}

static void print_order(const struct facts *f)
{
    const struct weft_analysis_order *o = &f->order;
    printf("  order            %d", o->order);
    if (o->order)
        printf(": RMS error %.5g T^%d |f^(%d)| at sample distance T, at most %.5g", o->constant,
               o->order, o->order + f->kernel.info->derivation, o->largest);
    puts("");
    if (f->kernel.info->derivation)
        return;
    if (f->kernel.prefiltered)
        puts(
            "  prefilter        applied: it interpolates; h is the weight of coefficients, order,\n"
            "                   moments, response and overshoot are those for samples");
    else if (needs_prefilter(f) && f->interpolator.order)
        printf("  prefilter        needed: \"%si\" interpolates, order %d, RMS error %.5g T^%d "
               "|f^(%d)|;\n                   the least by any prefilter (least squares) is %.5g\n",
               f->kernel.info->name, f->interpolator.order, f->interpolator.constant,
               f->interpolator.order, f->interpolator.order, o->prefiltered_constant);
    else if (needs_prefilter(f))
        printf("  prefilter        weft has none: one could raise the order to %d, RMS error %.5g "
               "T^%d |f^(%d)| at least\n",
               o->prefiltered, o->prefiltered_constant, o->prefiltered, o->prefiltered);
    else
        printf("  prefilter        not needed: %s\n",
               f->kernel.interpolating ? "it interpolates" : "it would not raise the order");
}

static void print_values(const struct facts *f)
{
    const struct weft_kernel *k = &f->kernel;
    const bool whole = f->symmetry[0] == 'n', slope = k->info->derivative != NULL;
    printf("\n  %8s  %13s%s\n", "x", "h(x)", slope ? "          h'(x)" : "");
    int last = (int)floor(4.0 * k->support);
    for (int i = whole ? -last : 0; i <= last; i++) {
        printf("  %8g  %13.9f", 0.25 * i, tidy(weft_kernel_weight(k, 0.25 * i)) + 0.0);
        if (slope)
            printf("  %13.9f", tidy(weft_kernel_derivative(k, 0.25 * i)) + 0.0);
        puts("");
    }
}

static void print_moments(const struct facts *f)
{
    puts("\n  moments: integral of x^n h(x)");
    for (int n = 0; n < MOMENTS; n++)
        printf("  %8d  %13.9f\n", n, tidy(f->moment[n]));
    puts("\n  Taylor coefficients a_n(t) = sum_k (k - t)^n h(t - k) / n!");
    printf("  %8s", "n");
    for (int i = 0; i < TAYLOR_POSITIONS; i++)
        printf("    t = %-7g", taylor_positions[i]);
    puts("");
    for (int n = 0; n < TAYLOR_ORDERS; n++) {
        printf("  %8d", n);
        for (int i = 0; i < TAYLOR_POSITIONS; i++)
            printf("  %13.9f", tidy(f->taylor[n][i]));
        puts("");
    }
}

static void print_spectrum(const struct facts *f)
{
    puts("\n  frequency response, f in cycles per sample distance");
    printf("  %8s  %13s  %13s\n", "f", "|H(f)|", "dB");
    for (int i = 0; i < FREQUENCIES; i++)
        printf("  %8g  %13.9f  %13.2f\n", frequencies[i], tidy(magnitude(f->response[i])),
               decibel(f->response[i]));
}

// Of a derivative of the signal neither says anything.
static void print_quality(const struct facts *f)
{
    if (f->kernel.info->derivation == 0) {
        puts("\n  Marschner and Lobb 1994");
        printf("  %8s  %13s  %13s\n", "dims", "smoothing", "post-aliasing");
        for (int d = 0; d < (f->kernel.radial ? 1 : DIMS); d++)
            printf("  %8d  %13.6f  %13.6f\n", d + 1, f->metrics[d].smoothing,
                   f->metrics[d].postaliasing);
        printf("\n  a unit step overshoots by %.5g, undershoots by %.5g", tidy(f->overshoot.above),
               tidy(f->overshoot.below));
    }
    printf("\n  largest sum of |weights| %.6g\n", f->gain);
}

static void print_text(const struct facts *f)
{
    print_head(f);
    print_order(f);
    print_values(f);
    print_moments(f);
    print_spectrum(f);
    print_quality(f);
}

// ---- the verb -----------------------------------------------------------------------------------

static int list(bool json)
{
    if (json)
        return report_finish(json_print(kernels_json()));
    kernels_print();
    return report_finish(WEFT_OK);
}

static int describe(const char *name, const struct option_value *o)
{
    weft_kernel_file *file = NULL;
    struct facts *f = calloc(1, sizeof *f);
    if (!f)
        return report_finish(WEFT_ERR_MEMORY);
    enum weft_result res = kernels_load(name, &f->kernel, &file);
    enum exit_code code = EXIT_CODE_DONE;
    if (res == WEFT_OK && o[KERNEL_PLOT].given)
        code = plot_check("--plot", o[KERNEL_PLOT].text, "--json");
    if (res == WEFT_OK && code == EXIT_CODE_DONE) {
        gather(f);
        if (o[KERNEL_PLOT].given)
            code = draw(f, o[KERNEL_PLOT].text);
    }
    if (res == WEFT_OK && code == EXIT_CODE_DONE) {
        if (o[KERNEL_JSON].given)
            res = print_json(f);
        else
            print_text(f);
    }
    weft_kernel_file_destroy(&file);
    free(f);
    return code != EXIT_CODE_DONE ? (int)code : report_finish(res);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[KERNEL_QUIET].given, values[KERNEL_VERBOSE].given);
    if (values[KERNEL_LIST].given && (operand || values[KERNEL_PLOT].given)) {
        report_error("--list takes neither a kernel nor --plot");
        return EXIT_CODE_USAGE;
    }
    if (values[KERNEL_LIST].given)
        return list(values[KERNEL_JSON].given);
    if (!operand) {
        report_error("no kernel given: weft kernel NAME (weft kernel --list lists them)");
        return EXIT_CODE_USAGE;
    }
    return describe(operand, values);
}

static const char *const epilogue[] = {
    "NAME is as in weft slice --kernel: NAME, NAME:p, NAME:p,q, any of them with +unit, +radial or "
    "+radial+unit behind it, or table:FILE.",
    "An order N with constant c means an error of c T^N |f^(N)| at sample distance T. The analysis "
    "takes kernels to be smooth between half integers: of table:FILE, which need not be, expect "
    "fewer digits.",
    NULL,
};

static const char *const examples[] = {
    "weft kernel kaiser-sinc:3,5 --plot kaiser.svg",
    NULL,
};

const struct verb verb_kernel = {
    .name = "kernel",
    .group = VERB_METHODS,
    .summary = "what a reconstruction kernel is and does to a signal",
    .usage = "NAME [--plot " PLOT_VALUE "] [--json] | --list",
    .description = "Prints values, support, moments, Taylor coefficients, order of approximation, "
                   "frequency response, smoothing, post-aliasing and overshoot of a kernel.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = KERNEL_OPTION_COUNT,
    .run = run,
};
