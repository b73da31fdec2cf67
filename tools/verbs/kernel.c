// SPDX-License-Identifier: BSD-3-Clause
// weft kernel: what a kernel is and does to a signal, as text, JSON and plot.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/draw/plot.h"
#include "tools/common/report.h"
#include "tools/kernel/facts.h"
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
                     "kernels, derivatives and spectra as a picture (needs gnuplot)",
                     plot_endings,
                     .group = OPTION_PICTURES,
                     .brief = "kernel, slope and spectrum as a picture"},
    [KERNEL_JSON] = OPTIONS_JSON("everything, with the curves that --plot draws"),
    [KERNEL_QUIET] = OPTIONS_QUIET,
    [KERNEL_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *taylor_json(const struct kernel_facts *f)
{
    json_t *list = json_array();
    for (int n = 0; n < KERNEL_TAYLOR_ORDERS; n++)
        json_array_append_new(list, json_numbers(f->taylor[n], KERNEL_TAYLOR_POSITIONS));
    return json_pack("{s:o,s:o}", "t",
                     json_numbers(kernel_taylor_positions, KERNEL_TAYLOR_POSITIONS), "a", list);
}

static json_t *response_json(const struct kernel_facts *f)
{
    json_t *list = json_array();
    for (int i = 0; i < KERNEL_FREQUENCIES; i++)
        json_array_append_new(
            list, json_pack("{s:o,s:o,s:o}", "frequency", json_number(kernel_frequencies[i]), "re",
                            json_number(f->response[i].re), "im", json_number(f->response[i].im)));
    return list;
}

static json_t *metrics_json(const struct kernel_facts *f)
{
    if (f->kernel.info->derivation) // they say nothing there
        return json_null();
    json_t *list = json_array();
    for (int d = 0; d < KERNEL_DIMS; d++)
        json_array_append_new(list, json_pack("{s:i,s:o,s:o}", "dims", d + 1, "smoothing",
                                              json_number(f->metrics[d].smoothing), "postaliasing",
                                              json_number(f->metrics[d].postaliasing)));
    return list;
}

static json_t *kernel_json(const struct kernel_facts *f)
{
    const struct weft_kernel *k = &f->kernel;
    const struct weft_analysis_order *o = &f->order;
    json_t *params = json_object();
    for (int p = 0; p < WEFT_KERNEL_PARAMS && k->info->params[p].name; p++)
        json_object_set_new(params, k->info->params[p].name, json_number(k->param[p]));
    json_t *root =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:i,s:i,s:i,s:s,s:b,s:b,s:b,s:b,s:i}", "kernel",
                  json_text(f->name), "description", json_text(k->info->description), "citation",
                  k->info->citation ? json_text(k->info->citation) : json_null(), "parameters",
                  params, "support", json_number(k->support), "taps", k->width, "degree",
                  k->info->degree, "continuity", k->continuity, "symmetry", f->symmetry, "radial",
                  k->radial, "interpolating", k->interpolating, "unit_sum", f->unit_sum,
                  "needs_prefilter", kernel_needs_prefilter(f), "derivative", k->info->derivation);
    json_object_set_new(root, "prefiltered", json_boolean(k->prefiltered));
    json_object_set_new(root, "order",
                        json_pack("{s:i,s:o,s:o,s:i,s:o,s:i,s:o}", "order", o->order, "constant",
                                  json_number(o->constant), "largest", json_number(o->largest),
                                  "prefiltered", o->prefiltered, "prefiltered_constant",
                                  json_number(o->prefiltered_constant), "interpolator",
                                  f->interpolator.order, "interpolator_constant",
                                  json_number(f->interpolator.constant)));
    json_object_set_new(root, "moments", json_numbers(f->moment, KERNEL_MOMENTS));
    json_object_set_new(root, "taylor", taylor_json(f));
    json_object_set_new(root, "response", response_json(f));
    json_object_set_new(root, "marschner_lobb", metrics_json(f));
    json_object_set_new(root, "overshoot",
                        json_pack("{s:o,s:o,s:o}", "above", json_number(f->overshoot.above),
                                  "below", json_number(f->overshoot.below), "gain",
                                  json_number(f->gain)));
    kernel_set_curves(root, k);
    return root;
}

// ---- text ---------------------------------------------------------------------------------------

static void print_radial(const struct weft_kernel *k)
{
    puts("  radial           yes: the weight is h of the distance in 2D and 3D, not a product;\n"
         "                   orders, moments and all below them are those in 1D");
    for (int dims = 2; dims <= 3; dims++) {
        struct weft_kernel_sums sums = weft_kernel_radial_sums(k, dims);
        printf("  sums in %dD       %.6g to %.6g%s\n", dims, kernel_tidy(sums.least) + 0.0,
               kernel_tidy(sums.largest) + 0.0,
               sums.least * sums.largest > 0.0 ? "" : ": +unit cannot divide by them");
    }
}

static void print_head(const struct kernel_facts *f)
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

static void print_order(const struct kernel_facts *f)
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
    else if (kernel_needs_prefilter(f) && f->interpolator.order)
        printf("  prefilter        needed: \"%si\" interpolates, order %d, RMS error %.5g T^%d "
               "|f^(%d)|;\n                   the least by any prefilter (least squares) is %.5g\n",
               f->kernel.info->name, f->interpolator.order, f->interpolator.constant,
               f->interpolator.order, f->interpolator.order, o->prefiltered_constant);
    else if (kernel_needs_prefilter(f))
        printf("  prefilter        weft has none: one could raise the order to %d, RMS error %.5g "
               "T^%d |f^(%d)| at least\n",
               o->prefiltered, o->prefiltered_constant, o->prefiltered, o->prefiltered);
    else
        printf("  prefilter        not needed: %s\n",
               f->kernel.interpolating ? "it interpolates" : "it would not raise the order");
}

static void print_values(const struct kernel_facts *f)
{
    const struct weft_kernel *k = &f->kernel;
    const bool whole = f->symmetry[0] == 'n', slope = k->info->derivative != NULL;
    printf("\n  %8s  %13s%s\n", "x", "h(x)", slope ? "          h'(x)" : "");
    int last = (int)floor(4.0 * k->support);
    for (int i = whole ? -last : 0; i <= last; i++) {
        printf("  %8g  %13.9f", 0.25 * i, kernel_tidy(weft_kernel_weight(k, 0.25 * i)) + 0.0);
        if (slope)
            printf("  %13.9f", kernel_tidy(weft_kernel_derivative(k, 0.25 * i)) + 0.0);
        puts("");
    }
}

static void print_moments(const struct kernel_facts *f)
{
    puts("\n  moments: integral of x^n h(x)");
    for (int n = 0; n < KERNEL_MOMENTS; n++)
        printf("  %8d  %13.9f\n", n, kernel_tidy(f->moment[n]));
    puts("\n  Taylor coefficients a_n(t) = sum_k (k - t)^n h(t - k) / n!");
    printf("  %8s", "n");
    for (int i = 0; i < KERNEL_TAYLOR_POSITIONS; i++)
        printf("    t = %-7g", kernel_taylor_positions[i]);
    puts("");
    for (int n = 0; n < KERNEL_TAYLOR_ORDERS; n++) {
        printf("  %8d", n);
        for (int i = 0; i < KERNEL_TAYLOR_POSITIONS; i++)
            printf("  %13.9f", kernel_tidy(f->taylor[n][i]));
        puts("");
    }
}

static void print_spectrum(const struct kernel_facts *f)
{
    puts("\n  frequency response, f in cycles per sample distance");
    printf("  %8s  %13s  %13s\n", "f", "|H(f)|", "dB");
    for (int i = 0; i < KERNEL_FREQUENCIES; i++)
        printf("  %8g  %13.9f  %13.2f\n", kernel_frequencies[i],
               kernel_tidy(kernel_magnitude(f->response[i])), kernel_decibel(f->response[i]));
}

// Of a derivative of the signal neither says anything.
static void print_quality(const struct kernel_facts *f)
{
    if (f->kernel.info->derivation == 0) {
        puts("\n  Marschner and Lobb 1994");
        printf("  %8s  %13s  %13s\n", "dims", "smoothing", "post-aliasing");
        for (int d = 0; d < (f->kernel.radial ? 1 : KERNEL_DIMS); d++)
            printf("  %8d  %13.6f  %13.6f\n", d + 1, f->metrics[d].smoothing,
                   f->metrics[d].postaliasing);
        printf("\n  a unit step overshoots by %.5g, undershoots by %.5g",
               kernel_tidy(f->overshoot.above), kernel_tidy(f->overshoot.below));
    }
    printf("\n  largest sum of |weights| %.6g\n", f->gain);
}

static void print_text(const struct kernel_facts *f)
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

// One kernel's facts are the document, those of several a list in it.
static enum weft_result print_json(const struct kernel_facts *const *facts, int count)
{
    if (count == 1)
        return json_print(kernel_json(facts[0]));
    json_t *list = json_array();
    for (int k = 0; k < count; k++)
        json_array_append_new(list, kernel_json(facts[k]));
    return json_print(json_pack("{s:o}", "kernels", list));
}

static enum weft_result print(const struct kernel_facts *const *facts, int count, bool json)
{
    if (json)
        return print_json(facts, count);
    if (count == 1)
        print_text(facts[0]);
    else
        kernel_compare(facts, count);
    return WEFT_OK;
}

struct subject {
    struct kernel_facts facts;
    weft_kernel_file *file;
};

static int describe(const char *const *name, int count, const struct option_value *o)
{
    const struct kernel_facts *facts[KERNEL_MOST];
    struct subject *subject = calloc((size_t)count, sizeof *subject);
    if (!subject)
        return report_finish(WEFT_ERR_MEMORY);
    enum weft_result res = WEFT_OK;
    enum exit_code code = EXIT_CODE_DONE;
    for (int k = 0; k < count && res == WEFT_OK; k++) {
        facts[k] = &subject[k].facts;
        res = kernels_load(name[k], &subject[k].facts.kernel, &subject[k].file);
    }
    if (res == WEFT_OK && o[KERNEL_PLOT].given)
        code = plot_check("--plot", o[KERNEL_PLOT].text, "--json");
    for (int k = 0; k < count && res == WEFT_OK && code == EXIT_CODE_DONE; k++)
        kernel_facts_gather(&subject[k].facts);
    if (res == WEFT_OK && code == EXIT_CODE_DONE && o[KERNEL_PLOT].given)
        code = kernel_draw(facts, count, o[KERNEL_PLOT].text);
    if (res == WEFT_OK && code == EXIT_CODE_DONE)
        res = print(facts, count, o[KERNEL_JSON].given);
    for (int k = 0; k < count; k++)
        weft_kernel_file_destroy(&subject[k].file);
    free(subject);
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
    int count = 0;
    while (operands[count])
        count++;
    if (count > KERNEL_MOST) {
        report_error("%d kernels: at most %d are compared", count, KERNEL_MOST);
        return EXIT_CODE_USAGE;
    }
    return describe(operands, count, values);
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
    "weft kernel mitchell catmull-rom bspline3 --plot three.pdf",
    NULL,
};

const struct verb verb_kernel = {
    .name = "kernel",
    .group = VERB_METHODS,
    .summary = "what a reconstruction kernel is and does to a signal",
    .usage = "NAME... [--plot " PLOT_VALUE "] [--json] | --list",
    .description = "Prints values, support, moments, Taylor coefficients, order of approximation, "
                   "frequency response, smoothing, post-aliasing and overshoot of a kernel; of "
                   "several, up to 8, what tells them apart, side by side.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = KERNEL_OPTION_COUNT,
    .many = true,
    .operand_names = OPTION_NAMES_KERNEL,
    .run = run,
};
