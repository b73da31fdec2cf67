// SPDX-License-Identifier: BSD-3-Clause
// weft kernel and weft table as their users see them, and what they refuse.
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

static double element(const json_t *array, size_t index)
{
    const json_t *value = json_array_get(array, index);
    if (!json_is_number(value))
        fail_msg("no number %zu", index);
    return json_number_value(value);
}

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    if (!value)
        fail_msg("no text %s", key);
    return value;
}

static bool flag(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_boolean(value))
        fail_msg("no flag %s", key);
    return json_is_true(value);
}

static void write_text(const char *path, const char *content)
{
    command_write_file(path, content, strlen(content));
}

static bool has_gnuplot(void)
{
    static int known = -1;
    if (known < 0) {
        known = system("gnuplot --version >/dev/null 2>&1") == 0;
        if (!known)
            print_message("no gnuplot here: plots are not tested\n");
    }
    return known;
}

// ---- weft kernel --------------------------------------------------------------------------------

static void list_has_every_kernel(void **state)
{
    (void)state;
    const char *out = command_succeeds("kernel", "--list");
    for (int i = 0; weft_kernel_list[i]; i++)
        if (!strstr(out, weft_kernel_list[i]->name))
            fail_msg("no %s", weft_kernel_list[i]->name);
    assert_non_null(strstr(out, "table:FILE"));
    json_t *root = parse(command_succeeds("kernel", "--list", "--json"));
    const json_t *list = json_object_get(root, "kernels");
    size_t count = 0, prefiltered = 0;
    for (; weft_kernel_list[count]; count++) {
        const json_t *entry = json_array_get(list, count + prefiltered);
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[count], NULL, &kernel), WEFT_OK);
        assert_string_equal(text(entry, "name"), weft_kernel_list[count]->name);
        assert_true(number(entry, "taps") == kernel.width);
        assert_true(number(entry, "order") == kernel.order);
        assert_int_equal(flag(entry, "interpolating"), kernel.interpolating);
        const json_t *next = json_array_get(list, count + prefiltered + 1);
        prefiltered += next && flag(next, "prefiltered");
    }
    assert_int_equal(prefiltered, 8); // bspline, bspline2 to bspline7, omoms
    count += prefiltered;
    assert_int_equal(json_array_size(list), count);
    json_decref(root);
}

// Writes the row that docs/kernels.md has of an entry of the list: of a derivative its place in a
// table of names and orders.
static void write_row(const json_t *entry, const char *page, char *row, size_t size)
{
    const char *name = text(entry, "name");
    const double order = number(entry, "order");
    if (number(entry, "derivative") > 0) {
        snprintf(row, size, "| `%s` (%g) |", name, order);
        return;
    }
    struct weft_kernel kernel;
    char whole[64], other[64];
    assert_int_equal(weft_kernel_parse(NULL, name, &kernel), WEFT_OK);
    weft_kernel_format(&kernel, whole, sizeof whole);
    snprintf(other, sizeof other, "yes: `%si`", name);
    const bool done = flag(entry, "prefiltered"), through = flag(entry, "interpolating");
    const char *prefilter = "no";
    if (done)
        prefilter = "has it";
    else if (!through && number(entry, "order_prefiltered") > order)
        prefilter = strstr(page, other) ? other : "yes; weft has none";
    snprintf(row, size, "\n| `%s` | %g | %g | %g | %s | %s | %s |", whole, number(entry, "taps"),
             number(entry, "support"), order,
             done      ? "yes, prefiltered"
             : through ? "yes"
                       : "no: blurs",
             prefilter, flag(entry, "unit_sum") ? "yes" : "no");
}

static void page_has_every_kernel(void **state)
{
    (void)state;
    size_t size;
    char *page = command_read_file(WEFT_SOURCE_DIR "/docs/kernels.md", &size);
    json_t *root = parse(command_succeeds("kernel", "--list", "--json"));
    const json_t *list = json_object_get(root, "kernels");
    for (size_t i = 0; i < json_array_size(list); i++) {
        char row[200];
        write_row(json_array_get(list, i), page, row, sizeof row);
        if (!strstr(page, row))
            fail_msg("docs/kernels.md lacks %s: sh tools/figures.sh kernel-page", row);
    }
    assert_true(json_array_size(list) > 80);
    json_decref(root);
    free(page);
}

// Marschner and Lobb's metrics in 1D and 3D and a_n(t) by hand; order constants of Blu and Unser.
static void json_tells_known_values(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double s1, p1, s3, p3;
        int order;
        bool interpolating, prefilter;
    } cases[] = {
        {"nearest", .226305, .226305, .536863, .536863, 1, true, false},
        {"linear", .366784, .033451, .746104, .042401, 2, true, false},
        {"bspline", .523540, .002905, .891837, .001991, 2, false, true},
        {"mitchell", .340448, .021929, .713088, .029580, 2, false, true},
        {"catmull-rom", .223952, .038238, .532624, .072546, 3, true, false},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        json_t *root = parse(command_succeeds("kernel", cases[i].name, "--json"));
        const json_t *metrics = json_object_get(root, "marschner_lobb");
        const json_t *one = json_array_get(metrics, 0), *three = json_array_get(metrics, 2);
        assert_true(fabs(number(one, "smoothing") - cases[i].s1) < 1e-6);
        assert_true(fabs(number(one, "postaliasing") - cases[i].p1) < 1e-6);
        assert_true(fabs(number(three, "smoothing") - cases[i].s3) < 1e-6);
        assert_true(fabs(number(three, "postaliasing") - cases[i].p3) < 1e-6);
        assert_true(number(json_object_get(root, "order"), "order") == cases[i].order);
        assert_int_equal(flag(root, "interpolating"), cases[i].interpolating);
        assert_int_equal(flag(root, "needs_prefilter"), cases[i].prefilter);
        assert_true(flag(root, "unit_sum"));
        assert_true(fabs(element(json_object_get(root, "moments"), 0) - 1) < 1e-12);
        const json_t *curve = json_object_get(root, "curve");
        assert_int_equal(json_array_size(json_object_get(curve, "x")),
                         json_array_size(json_object_get(curve, "value")));
        json_decref(root);
    }
    json_t *root = parse(command_succeeds("kernel", "bspline", "--json"));
    assert_true(fabs(number(json_object_get(root, "order"), "prefiltered_constant") - 9.0924e-4) <
                1e-8);
    const json_t *a = json_object_get(json_object_get(root, "taylor"), "a");
    assert_true(fabs(element(json_array_get(a, 2), 1) - 1.0 / 6) < 1e-12);
    assert_true(fabs(element(json_array_get(a, 4), 2) - 13.0 / 1152) < 1e-12);
    json_decref(root);
}

static void text_tells_parameters(void **state)
{
    (void)state;
    const char *out = command_succeeds("kernel", "kaiser-sinc:2,5.36+unit");
    assert_non_null(strstr(out, "kaiser-sinc:2,5.36+unit: "));
    assert_non_null(strstr(out, "unit sum         yes: divided"));
    assert_non_null(strstr(out, "parameter"));
    assert_non_null(strstr(command_succeeds("kernel", "lanczos"), "no: NAME+unit"));
    assert_non_null(strstr(command_succeeds("kernel", "d-bspline"), "derivative 1"));
    for (int i = 0; weft_kernel_list[i]; i++)
        command_succeeds("kernel", weft_kernel_list[i]->name, "-q");
}

static void radial_kernels(void **state)
{
    (void)state;
    const char *out = command_succeeds("kernel", "catmull-rom+radial");
    assert_non_null(strstr(out, "radial           yes"));
    assert_non_null(strstr(out, "unit sum         no: +radial+unit"));
    assert_non_null(strstr(out, "sums in 3D       -0.12807 to 0.0569446: +unit cannot"));
    json_t *root = parse(command_succeeds("kernel", "linear+unit+radial", "--json"));
    assert_string_equal(text(root, "kernel"), "linear+radial+unit");
    assert_true(flag(root, "radial") && flag(root, "unit_sum"));
    json_decref(root);
    command_fails(3, "bspline is radial", "table", "--kernels", "bspline+radial", "--dims", "2");
    command_fails(3, "is radial", "table", "--kernels", "catmull-rom+radial", "--scale", "full",
                  "--dims", "3");
}

static void kernels_from_files(void **state)
{
    (void)state;
    write_text("tent.txt", "support 1 half\n1 0.5 0\n");
    json_t *root = parse(command_succeeds("kernel", "table:tent.txt", "--json"));
    assert_string_equal(text(root, "kernel"), "table:tent.txt");
    assert_true(number(root, "taps") == 2 && flag(root, "unit_sum"));
    assert_true(number(json_object_get(root, "order"), "order") == 2);
    json_decref(root);
    write_text("lean.txt", "whole support 1\n0 0.25 1 1 0\n");
    assert_non_null(strstr(command_succeeds("kernel", "table:lean.txt"), "symmetry         none"));
    // A comma or a semicolon separates; a comma in a file name is kept where a semicolon is there.
    write_text("a,b.txt", "support 1 half\n1 0.5 0\n");
    const char *out = command_succeeds("table", "--kernels", "table:a,b.txt;linear", "--dims", "1",
                                       "--resolutions", "8", "--format", "csv");
    double from_file = 0, from_name = 1;
    assert_int_equal(sscanf(strstr(out, "\n\"table:a,b.txt\",1,8,nearest,"),
                            "\n\"table:a,b.txt\",1,8,nearest,8,nearest,1,eq4,1024,%lf", &from_file),
                     1);
    assert_int_equal(sscanf(strstr(out, "\nlinear,1,8,nearest,"),
                            "\nlinear,1,8,nearest,8,nearest,1,eq4,1024,%lf", &from_name),
                     1);
    assert_true(from_file == from_name && from_file > 0);
    unlink("tent.txt");
    unlink("lean.txt");
    unlink("a,b.txt");
}

// ---- weft table: numbers ------------------------------------------------------------------------

// 255 eps_h by eq. 4 of Hadwiger, Hauser and Moeller, "Quality Issues of Hardware-Accelerated
// High-Quality Filtering on PC Graphics Hardware" (WSCG 2003), from an independent brute-force
// calculation with six significant digits.
struct reference {
    int dims, samples;
    double bspline[2], catmull_rom[2], blackman[2]; // box, lin
};
static const struct reference plain[] = {
    {2, 16, {18.7940, 13.2924}, {41.5478, 16.7507}, {34.0436, 10.8304}},
    {2, 32, {11.2295, 8.29239}, {21.8420, 7.75128}, {19.0200, 5.33863}},
    {2, 64, {8.13762, 4.82148}, {12.9523, 5.46320}, {11.3554, 4.65550}},
    {2, 128, {6.35383, 4.87170}, {9.26111, 5.67027}, {7.73430, 4.53421}},
    {2, 256, {5.87064, 5.06577}, {7.74719, 5.91264}, {6.20425, 4.58555}},
    {2, 512, {5.83264, 4.95764}, {6.72206, 5.55799}, {5.36876, 4.34126}},
    {3, 16, {27.1512, 21.2672}, {66.6172, 24.5001}, {43.0182, 15.9776}},
    {3, 32, {19.0513, 14.3167}, {40.2265, 19.0043}, {26.4641, 10.5560}},
    {3, 64, {15.8662, 12.3536}, {30.9758, 18.4411}, {17.6446, 10.8734}},
    {3, 128, {14.3937, 12.1622}, {25.2560, 20.8342}, {14.1773, 10.3482}},
};

// Table 1 of the paper as printed; the third kernel's rows are titled "Blackman sinc".
static const struct reference printed[] = {
    {2, 16, {11.2351, 5.5803}, {25.3076, 15.0835}, {26.3035, 15.4278}},
    {2, 32, {6.1619, 3.9219}, {14.4100, 10.8905}, {14.3229, 10.7960}},
    {2, 64, {3.8838, 3.3165}, {8.7091, 8.3325}, {8.8159, 8.3062}},
    {2, 128, {2.8293, 2.5841}, {6.0308, 7.1140}, {6.0954, 7.2064}},
    {2, 256, {2.3145, 2.2676}, {4.9057, 6.7169}, {4.9426, 6.6606}},
    {2, 512, {2.0867, 2.0867}, {4.3535, 6.3613}, {4.3151, 6.3229}},
    {3, 16, {12.3400, 7.2346}, {32.6554, 19.1470}, {34.0124, 20.0338}},
    {3, 32, {7.1811, 5.4758}, {17.8089, 14.3186}, {17.9082, 14.7748}},
    {3, 64, {5.0478, 7.0751}, {11.2476, 11.9767}, {11.4056, 12.0028}},
    {3, 128, {4.4375, 4.1687}, {8.1039, 10.5024}, {8.1723, 10.6158}},
};

// NAN where there is none.
static double find_reference(const struct reference *list, size_t count, const json_t *cell)
{
    const char *kernel = text(cell, "kernel");
    const int lookup = !strcmp(text(cell, "lookup"), "linear");
    for (size_t i = 0; i < count; i++) {
        if (list[i].dims != number(cell, "dims") || list[i].samples != number(cell, "samples"))
            continue;
        return (!strcmp(kernel, "bspline")       ? list[i].bspline
                : !strcmp(kernel, "catmull-rom") ? list[i].catmull_rom
                                                 : list[i].blackman)[lookup];
    }
    return NAN;
}

static void default_has_72_cells(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("table", "--locations", "16", "--format", "json"));
    const json_t *cells = json_object_get(root, "cells");
    int named = 0;
    assert_int_equal(json_array_size(cells), 72);
    for (size_t i = 0; i < 72; i++)
        named += !isnan(find_reference(plain, COUNT(plain), json_array_get(cells, i)));
    assert_int_equal(named, 60);
    json_decref(root);
}

// Of the 3D cells, the two that differ most in tiles: test_error has all of them.
static int count_as_eq4(const char *dims, const char *resolutions)
{
    json_t *root = parse(command_succeeds("table", "--format", "json", "--dims", dims,
                                          "--resolutions", resolutions));
    const json_t *cells = json_object_get(root, "cells");
    int compared = 0;
    assert_true(number(root, "factor") == 255);
    for (size_t i = 0; i < json_array_size(cells); i++) {
        const json_t *cell = json_array_get(cells, i);
        const double expected = find_reference(plain, COUNT(plain), cell);
        const double scaled = number(cell, "scaled");
        assert_true(fabs(scaled - 255 * number(cell, "eps_h")) < 1e-12 * scaled);
        assert_null(json_object_get(cell, "published"));
        if (isnan(expected))
            continue;
        compared++;
        if (!(fabs(scaled / expected - 1) <= 5e-6))
            fail_msg("%s %gD M %g: %.6g instead of %.6g", text(cell, "kernel"),
                     number(cell, "dims"), number(cell, "samples"), scaled, expected);
    }
    json_decref(root);
    return compared;
}

static void default_is_eq4(void **state)
{
    (void)state;
    assert_int_equal(count_as_eq4("2", "16,32,64,128,256,512"), 36);
    assert_int_equal(count_as_eq4("3", "16,128"), 12);
}

static int count_agreeing(const char *dims, const char *resolutions, int *marked)
{
    json_t *root = parse(command_succeeds("table", "--convention", "wscg2003", "--format", "json",
                                          "--dims", dims, "--resolutions", resolutions));
    const json_t *cells = json_object_get(root, "cells");
    int agreeing = 0;
    assert_true(number(root, "factor") == 256);
    for (size_t i = 0; i < json_array_size(cells); i++) {
        const json_t *cell = json_array_get(cells, i);
        const double expected = find_reference(printed, COUNT(printed), cell);
        const bool agrees = fabs(number(cell, "scaled") / expected - 1) < 1e-4;
        const json_t *mark = json_object_get(cell, "published");
        assert_int_equal(agrees, mark == NULL);
        if (mark)
            assert_true(json_number_value(mark) == expected);
        agreeing += agrees;
        *marked += !agrees;
    }
    json_decref(root);
    return agreeing;
}

// test_error has the other 12 cells: 53 of 60 agree.
static void wscg2003_gives_43_of_48(void **state)
{
    (void)state;
    int marked = 0;
    const int flat = count_agreeing("2", "16,32,64,128,256,512", &marked);
    assert_int_equal(flat + count_agreeing("3", "16,64", &marked), 43);
    assert_int_equal(marked, 5);
    const char *out =
        command_succeeds("table", "--convention=wscg2003", "--dims", "2", "--resolutions", "64");
    assert_non_null(strstr(out, "3.18343*"));
    assert_non_null(strstr(out, "bspline, 2D, M = 64, lin: 3.3165"));
    assert_non_null(strstr(out, "Blackman sinc"));
    // Nothing is marked that the paper does not have.
    out = command_succeeds("table", "--convention=wscg2003", "--dims", "2", "--resolutions", "64",
                           "--bits", "10");
    assert_null(strstr(out, "*"));
}

static void scale_full_uses_all_bits(void **state)
{
    (void)state;
    double error[3];
    static const char *const scales[] = {"--scale=1", "--scale=power-of-two", "--scale=full"};
    for (size_t i = 0; i < 3; i++) {
        // The largest weight in 2D is 4/9: scales 2 and 2.25.
        json_t *root = parse(command_succeeds("table", "--kernels", "bspline", "--dims", "2",
                                              "--resolutions", "4096", "--lookup", "linear",
                                              "--format", "json", "--locations", "128", scales[i]));
        const json_t *cell = json_array_get(json_object_get(root, "cells"), 0);
        error[i] = number(cell, "eps_h");
        assert_true(fabs(number(cell, "scale") - (i == 0 ? 1 : i == 1 ? 2 : 2.25)) < 1e-12);
        json_decref(root);
    }
    assert_true(error[1] < 0.75 * error[0] && error[2] < error[0]);
}

static void statistics_are_consistent(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds(
        "table", "--kernels", "mitchell,kaiser-sinc:2,5.36", "--dims", "1,2", "--resolutions",
        "16,64", "--statistics", "--format", "json", "--locations", "64", "--rounding", "truncated"));
    const json_t *cells = json_object_get(root, "cells");
    assert_int_equal(json_array_size(cells), 16);
    assert_string_equal(text(root, "rounding"), "truncated");
    assert_string_equal(text(json_array_get(cells, 15), "kernel"), "kaiser-sinc:2,5.36");
    for (size_t i = 0; i < 16; i++) {
        const json_t *c = json_array_get(cells, i);
        assert_true(number(c, "mean") <= number(c, "rms"));
        assert_true(number(c, "median") <= number(c, "p90"));
        assert_true(number(c, "p90") <= number(c, "p99"));
        assert_true(number(c, "p99") <= number(c, "eps_h") * 1.001);
        assert_true(number(c, "signed_min") <= number(c, "signed_mean"));
        assert_true(number(c, "signed_mean") <= number(c, "signed_max"));
        assert_true(number(c, "single") <= number(c, "eps_h"));
        const json_t *position = json_object_get(c, "position");
        assert_int_equal(json_array_size(position), (size_t)number(c, "dims"));
        assert_true(element(position, 0) > 0 && element(position, 0) < 1);
    }
    json_decref(root);
    assert_non_null(
        strstr(command_succeeds("table", "--dims", "1", "--resolutions", "8", "--statistics"),
               "signed_max"));
}

// ---- weft table: formats ------------------------------------------------------------------------

// Of one CSV line, quotes respected; moves *at behind it.
static int count_columns(const char **at)
{
    int columns = 1;
    bool quoted = false;
    for (; **at && (quoted || **at != '\n'); (*at)++) {
        quoted ^= **at == '"';
        columns += !quoted && **at == ',';
    }
    *at += **at == '\n';
    return columns;
}

static void formats_parse(void **state)
{
    (void)state;
#define SMALL "table", "--dims", "1,2", "--resolutions", "4,8", "--kernels", "linear;cubic:0,0.5"
    static const char *const more[] = {"-q", "--statistics"};
    for (size_t i = 0; i < 2; i++) {
        const char *csv = command_succeeds(SMALL, "--format", "csv", more[i]);
        assert_int_equal(strncmp(csv, "kernel,dims,samples,lookup,bits,", 32), 0);
        int lines = 0;
        const int columns = i ? 22 : 12;
        for (; *csv; lines++)
            assert_int_equal(count_columns(&csv), columns);
        assert_int_equal(lines, 17);
        json_decref(parse(command_succeeds(SMALL, "--format", "json", more[i])));
    }
    const char *markdown = command_succeeds(SMALL, "-f", "markdown");
    assert_non_null(strstr(markdown, "| kernel | M | 1D box | 1D lin | 2D box | 2D lin |\n|---|"));
    assert_non_null(strstr(markdown, "| cubic:0,0.5 | 8 | "));
    const char *latex = command_succeeds(SMALL, "-f", "latex");
    assert_non_null(strstr(latex, "\\begin{tabular}{lrrrrr}"));
    assert_non_null(strstr(latex, "\\end{tabular}\n"));
    const char *shown = command_succeeds(SMALL);
    assert_non_null(strstr(shown, "255 eps_h"));
    char *kept = strdup(shown);
    assert_string_equal(command_succeeds(SMALL, "-o", "t.txt"), "");
    size_t size;
    char *saved = command_read_file("t.txt", &size);
    saved[size] = 0;
    assert_string_equal(saved, kept);
    free(saved);
    free(kept);
    unlink("t.txt");
#undef SMALL
}

static void target_error_is_met(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("table", "--target-error", "0.03", "--kernels", "bspline",
                                          "--dims", "1,2", "--format", "json"));
    const json_t *cells = json_object_get(root, "cells");
    int reached = 0, least = 0;
    assert_int_equal(json_array_size(cells), 20);
    for (size_t i = 0; i < 20; i++) {
        const json_t *c = json_array_get(cells, i);
        least += flag(c, "least");
        if (!flag(c, "reached"))
            continue;
        reached++;
        char samples[64], bits[32], dims[32];
        const int m = (int)number(c, "samples");
        snprintf(samples, sizeof samples, m > 1 ? "%d,%d" : "%d", m, m - 1);
        snprintf(bits, sizeof bits, "%g", number(c, "bits"));
        snprintf(dims, sizeof dims, "%g", number(c, "dims"));
        json_t *check = parse(command_succeeds("table", "--kernels", "bspline", "--format", "json",
                                               "--dims", dims, "--bits", bits, "--resolutions",
                                               samples, "--lookup", text(c, "lookup")));
        const json_t *both = json_object_get(check, "cells");
        assert_true(number(json_array_get(both, 0), "eps_h") == number(c, "eps_h"));
        assert_true(number(c, "eps_h") <= 0.03);
        if (m > 1)
            assert_true(number(json_array_get(both, 1), "eps_h") > 0.03);
        json_decref(check);
    }
    assert_true(reached >= 12);
    assert_int_equal(least, 4);
    json_decref(root);
    const char *out = command_succeeds("table", "--target-error", "1e-9", "--kernels", "linear",
                                       "--dims", "1", "--resolutions", "16", "--bits", "8");
    assert_non_null(strstr(out, "> 16"));
}

// ---- several kernels ----------------------------------------------------------------------------

// The numbers of a table's row.
static void assert_row(const char *table, const char *name, const double *expected, int count,
                       double tolerance)
{
    const char *at = strstr(table, name);
    assert_non_null(at);
    at += strlen(name);
    for (int i = 0; i < count; i++) {
        char *end;
        assert_true(fabs(strtod(at, &end) - expected[i]) <= tolerance);
        at = end;
    }
}

// Each as it is alone, in the order in which they are named; the table has their facts.
static void kernels_are_compared(void **state)
{
    (void)state;
    static const char *const names[] = {"mitchell", "bspline3i", "kaiser-sinc:2,5.36"};
    command_succeeds("kernel", names[0], names[1], names[2], "--json=all.json");
    json_t *all = json_load_file("all.json", 0, NULL); // longer than what is kept of outputs
    assert_non_null(all);
    json_t *list = json_object_get(all, "kernels");
    assert_int_equal(json_array_size(list), 3);
    for (size_t k = 0; k < COUNT(names); k++) {
        json_t *alone = parse(command_succeeds("kernel", names[k], "--json"));
        const char *key;
        json_t *value;
        json_object_foreach(json_array_get(list, k), key, value)
            assert_true(json_equal(value, json_object_get(alone, key)));
        assert_string_equal(text(json_array_get(list, k), "kernel"), names[k]);
        json_decref(alone);
    }
    json_decref(all);
    unlink("all.json");
    const char *out = command_succeeds("kernel", "nearest", "linear", "d-bspline");
    assert_row(out, "taps per axis", (double[]){1, 2, 4}, 3, 0.0);
    assert_row(out, "order", (double[]){1, 2, 2}, 3, 0.0);
    // sinc(0.25) and its square: 20 log10(2 sqrt(2) / pi)
    assert_row(out, "|H(0.25)|, dB", (double[]){-0.912, -1.824}, 2, 0.005);
}

// ---- plots --------------------------------------------------------------------------------------

static void assert_starts(const char *path, const char *start, size_t start_size)
{
    size_t size;
    char *data = command_read_file(path, &size);
    assert_true(size > 2000);
    assert_memory_equal(data, start, start_size);
    free(data);
    unlink(path);
}

// The curve of an interpolating B-spline is its cardinal spline: 1 at 0, of integral 1, with
// negative lobes (the B-spline itself is 2/3 at 0 and has none) and the slope that goes with it.
static void curves_are_of_samples(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("kernel", "bspline3i", "--json"));
    const json_t *curve = json_object_get(root, "curve"), *x = json_object_get(curve, "x"),
                 *value = json_object_get(curve, "value"),
                 *slope = json_object_get(curve, "derivative");
    const size_t count = json_array_size(x), middle = count / 2;
    const double step = element(x, 1) - element(x, 0);
    double sum = 0.0, least = 0.0;
    assert_true(count > 100 && count % 2 == 1 && element(x, count - 1) > 6.0);
    assert_true(element(x, middle) == 0.0 && fabs(element(value, middle) - 1.0) < 1e-9);
    for (size_t i = 0; i < count; i++) {
        sum += step * element(value, i);
        least = fmin(least, element(value, i));
        // The third derivative is at most 24 (of the B-spline 6, and coefficients of at most
        // sqrt(3)).
        if (i > 0 && i + 1 < count)
            assert_true(fabs((element(value, i + 1) - element(value, i - 1)) / (2.0 * step) -
                             element(slope, i)) < 24.0 / 6.0 * step * step);
    }
    assert_true(fabs(sum - 1.0) < 2e-3); // what lies beyond the ends, where it is below 10^-3
    assert_true(least < -0.1);
    json_decref(root);
}

static void plots_are_pictures(void **state)
{
    (void)state;
    if (!has_gnuplot())
        skip();
    static const char png[] = "\x89PNG\r\n\x1a\n", svg[] = "<?xml";
    const int before = command_folder_size();
    command_succeeds("kernel", "lanczos:3", "--plot", "it's a plot.png");
    assert_starts("it's a plot.png", png, 8);
    command_succeeds("kernel", "linear", "--plot", "k.svg");
    assert_starts("k.svg", svg, 5);
    command_succeeds("kernel", "linear", "d-mitchell", "bspline7i", "--plot", "k.svg");
    assert_starts("k.svg", svg, 5);
    command_succeeds("kernel", "linear", "--plot", "k.pdf");
    assert_starts("k.pdf", "%PDF-", 5);
    command_succeeds("kernel", "linear", "--plot", "k.EPS");
    assert_starts("k.EPS", "%!PS-Adobe", 10);
    static const char *const names[] = {"nearest", "d-mitchell", "dd-keys6", "rect-sinc:8+unit"};
    for (size_t i = 0; i < COUNT(names); i++) {
        command_succeeds("kernel", names[i], "-p", "k.svg");
        assert_starts("k.svg", svg, 5);
    }
    command_succeeds("table", "--dims", "1,2", "--resolutions", "4,8,16", "--plot", "t.png");
    assert_starts("t.png", png, 8);
    command_succeeds("table", "--dims", "1", "--resolutions", "4", "-p", "t.svg", "-o", "t.txt",
                     "--kernels", "nearest");
    assert_starts("t.svg", svg, 5);
    unlink("t.txt");
    assert_int_equal(command_folder_size(), before);
}

static void no_gnuplot(void **state)
{
    (void)state;
    command_environment("PATH=/nonexistent");
    command_fails(1, "--format csv", "table", "--dims", "1", "--plot", "a.png");
    command_environment("PATH=/nonexistent");
    command_fails(1, "gnuplot", "kernel", "linear", "--plot", "a.svg");
}

// ---- bad input ----------------------------------------------------------------------------------

static void bad_kernels(void **state)
{
    (void)state;
    static const struct {
        const char *name, *message;
    } cases[] = {
        {"catmul-rom", "did you mean catmull-rom?"},
        {"gargoyle", "there are nearest, area, linear, "},
        {"", "no kernel ''"},
        {"lanczos:0", "not in ["},
        {"lanczos:-3", "not in ["},
        {"lanczos:1000000", "1e+06 is not in ["},
        {"lanczos:nan", "not a finite number"},
        {"lanczos:", "not a finite number"},
        {"lanczos:2,3", "takes 1 parameter,"},
        {"cubic:0,0.5,1", "parameters"},
        {"cubic:x", "not a finite number"},
        {"kaiser-sinc:2,-1", "not in ["},
        {"linear+units", "no kernel"},
        {"d-bspline+unit", "add up to 0"},
        {"d-bspline+radial", "cannot be radial"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        command_fails(2, cases[i].message, "kernel", cases[i].name);
        command_fails(2, *cases[i].name ? cases[i].message : "", "slice", "ml.vdb", "--kernel",
                      cases[i].name, "-o", "a.exr");
        if (strchr(cases[i].name, ',') == NULL)
            command_fails(2, *cases[i].name ? cases[i].message : "", "table", "--dims", "1",
                          "--kernels", cases[i].name);
    }
    command_fails(2, "no kernel given", "kernel");
    command_fails(2, "--list", "kernel", "linear", "--list");
    command_fails(2, "--list", "kernel", "--list", "--plot", "a.png");
    command_fails(2, "at most 8", "kernel", "linear", "linear", "linear", "linear", "linear",
                  "linear", "linear", "linear", "nearest");
    command_fails(2, "no kernel 'liner'", "kernel", "nearest", "liner");
}

static void bad_kernel_files(void **state)
{
    (void)state;
    static const struct {
        const char *content, *suffix, *message;
    } cases[] = {
        {"", "", "fewer than 2 samples"},
        {"support 1 1", "", "fewer than 2 samples"},
        {"1 0.5 0", "", "no support"},
        {"support 1 one two", "", "'one'"},
        {"support 1\n1 nan 0", "", "'nan'"},
        {"support 1\n1 inf 0", "", "'inf'"},
        {"support 0\n1 0", "", "half-width"},
        {"support 1e6\n1 0", "", "half-width"},
        {"support 1 0 0", "+unit", "add up to 0"},
        {"support 1 whole -1 0 1", "+unit", "add up to 0"},
        {"support 2 1 -0.5 0", "+unit", "cannot be divided"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        char name[64];
        write_text("bad.txt", cases[i].content);
        snprintf(name, sizeof name, "table:bad.txt%s", cases[i].suffix);
        command_fails(3, cases[i].message, "kernel", name);
        command_fails(3, cases[i].message, "slice", "ml.vdb", "--kernel", name, "-o", "a.exr");
        command_fails(3, cases[i].message, "table", "--kernels", name);
    }
    unlink("bad.txt");
    command_fails(3, "missing.txt", "kernel", "table:missing.txt");
    command_fails(3, "not a regular file", "kernel", "table:.");
    command_fails(3, "", "kernel", "table:");
}

static void bad_table_options(void **state)
{
    (void)state;
    static const struct {
        const char *option, *message;
    } cases[] = {
        {"--resolutions=0", "from 1 to 65536"},
        {"--resolutions=65537", "from 1 to 65536"},
        {"--resolutions=99999999999999999999", "from 1 to 65536"},
        {"--resolutions=16,,32", "whole numbers"},
        {"--resolutions=16,", "whole numbers"},
        {"--resolutions=,", "whole numbers"},
        {"--resolutions=-16", "whole numbers"},
        {"--resolutions=16;32", "whole numbers"},
        {"--resolutions=16 32", "whole numbers"},
        {"--resolutions=1e3", "whole numbers"},
        {"--resolutions=junk", "whole numbers"},
        {"--resolutions=", "empty"},
        {"--resolutions=16,16", "twice"},
        {"--dims=4", "from 1 to 3"},
        {"--dims=0", "from 1 to 3"},
        {"--dims=2D", "whole numbers"},
        {"--bits=0", "from 1 to 24"},
        {"--bits=25", "from 1 to 24"},
        {"--bits=8,10", "more than 1"},
        {"--rounding=up", "nearest, truncated"},
        {"--lookup=cubic", "nearest, linear, both"},
        {"--convention=paper", "eq4, wscg2003"},
        {"--format=html", "text, markdown, csv, json, latex"},
        {"--locations=0", "from 1 to 4096"},
        {"--locations=4097", "from 1 to 4096"},
        {"--locations=1,2", "more than 1"},
        {"--scale=0", "above 0"},
        {"--scale=-1", "above 0"},
        {"--scale=nan", "above 0"},
        {"--scale=2x", "above 0"},
        {"--scale=1000", "texels hold up to 1"},
        {"--target-error=0", "above 0"},
        {"--target-error=-1", "above 0"},
        {"--target-error=small", "finite number"},
        {"--kernels=,", "name is missing"},
        {"--kernels=;", "name is missing"},
        {"--kernels=linear,,bspline", "name is missing"},
        {"--kernels=linear; ;bspline", "name is missing"},
        {"--kernels=linear bspline", "no kernel"},
        {"--kernels=linear,junk", "no kernel 'junk'"},
        {"--plot=a.gif", ".pdf or .eps"},
        {"--plot=.png", ".pdf or .eps"},
        {"--junk", "unknown option"},
        {"bspline", "--kernels bspline"},
    };
    for (size_t i = 0; i < COUNT(cases); i++)
        command_fails(2, cases[i].message, "table", cases[i].option);
    command_fails(2, "excludes", "table", "--target-error", "1", "--statistics");
    command_fails(2, "(--plot writes .png)", "table", "-o", "a.png", "--plot", "./a.png");
    command_fails(4, "nowhere", "table", "-o", "nowhere/a.txt");
    command_fails(4, "folder", "table", "-o", ".");
    if (has_gnuplot())
        command_fails(4, "nowhere", "kernel", "linear", "--plot", "nowhere/a.png");
    command_fails(3, "half-width", "table", "--convention", "wscg2003", "--kernels", "bspline2");
}

static void an_interrupt_leaves_nothing(void **state)
{
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM};
    for (size_t i = 0; i < 2; i++) {
        const int before = command_folder_size();
        assert_int_equal(command_interrupt(0.5, signals[i],
                                           (const char *[]){"weft", "table", "--dims", "3",
                                                            "--locations", "2048", "-o", "t.txt", NULL}),
                         128 + signals[i]);
        assert_int_equal(command_folder_size(), before);
    }
    assert_int_equal(command_interrupt(0.5, SIGINT,
                                       (const char *[]){"weft", "table", "--dims", "3", "--locations",
                                                        "2048", "--target-error", "0.001", NULL}),
                     128 + SIGINT);
}

static void outputs_replace_what_is_there(void **state)
{
    (void)state;
    write_text("old.txt", "old");
    assert_int_equal(chmod("old.txt", 0640), 0);
    assert_int_equal(symlink("old.txt", "link.txt"), 0);
    command_succeeds("table", "--dims", "1", "--resolutions", "4", "-o", "link.txt");
    struct stat status;
    assert_int_equal(lstat("link.txt", &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_int_equal(stat("old.txt", &status), 0);
    assert_true(status.st_size > 100 && (status.st_mode & 0777) == 0640);
    unlink("link.txt");
    unlink("old.txt");
    if (access("/dev/full", W_OK) == 0)
        command_fails(4, "/dev/full", "table", "--dims", "1", "--resolutions", "4", "-o",
                      "/dev/full");
    assert_non_null(
        strstr(command_succeeds("table", "--dims", "1", "--resolutions", "4", "-o", "/dev/stdout"),
               "eps_h"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(list_has_every_kernel),
        cmocka_unit_test(page_has_every_kernel),
        cmocka_unit_test(json_tells_known_values),
        cmocka_unit_test(text_tells_parameters),
        cmocka_unit_test(radial_kernels),
        cmocka_unit_test(kernels_from_files),
        cmocka_unit_test(default_has_72_cells),
        cmocka_unit_test(default_is_eq4),
        cmocka_unit_test(wscg2003_gives_43_of_48),
        cmocka_unit_test(scale_full_uses_all_bits),
        cmocka_unit_test(statistics_are_consistent),
        cmocka_unit_test(formats_parse),
        cmocka_unit_test(target_error_is_met),
        cmocka_unit_test(curves_are_of_samples),
        cmocka_unit_test(kernels_are_compared),
        cmocka_unit_test(plots_are_pictures),
        cmocka_unit_test(no_gnuplot),
        cmocka_unit_test(bad_kernels),
        cmocka_unit_test(bad_kernel_files),
        cmocka_unit_test(bad_table_options),
        cmocka_unit_test(an_interrupt_leaves_nothing),
        cmocka_unit_test(outputs_replace_what_is_there),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
