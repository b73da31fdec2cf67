// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void analysis(void)
{
    struct weft_kernel good = named("bspline3i");
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        weft_analysis_taylor(&good, ints[i], 0.3);
        weft_analysis_moment(&good, ints[i]);
        weft_analysis_metrics(&good, ints[i]);
    }
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        weft_analysis_taylor(&good, 1, numbers[i]);
        weft_analysis_response(&good, numbers[i]);
    }
    TRUE(isnan(weft_analysis_response(&good, 1e300).re));
    TRUE(isnan(weft_analysis_response(&good, 1e6).re));
    TRUE(isfinite(weft_analysis_response(&good, WEFT_ANALYSIS_MAX_FREQUENCY).re));
    EACH_BAD_KERNEL(0, {
        weft_analysis_taylor(&kernel, 0, 0.0);
        weft_analysis_moment(&kernel, 0);
        weft_analysis_response(&kernel, 0.5);
        weft_analysis_metrics(&kernel, 2);
    })
    const struct weft_kernel none = {0};
    TRUE(isnan(weft_analysis_order(&none).constant));
    TRUE(isnan(weft_analysis_overshoot(&none).above));
    TRUE(isnan(weft_analysis_gain(&none)));
    TRUE(isnan(weft_analysis_curvature(&none)));
    TRUE(isnan(weft_analysis_slope(&none)));
    for (int k = 1; k < 6; k++) {
        const struct weft_kernel kernel = bad_kernel(k);
        weft_analysis_order(&kernel);
        weft_analysis_overshoot(&kernel);
        weft_analysis_gain(&kernel);
        weft_analysis_curvature(&kernel);
        weft_analysis_slope(&kernel);
    }
}

static void texts(void)
{
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        TRUE(weft_result_text((enum weft_result)bad_enums[i])[0]);
        TRUE(weft_target_name((enum weft_target_format)bad_enums[i])[0]);
        TRUE(weft_target_bits((enum weft_target_format)bad_enums[i]) == 0);
        TRUE(weft_target_one((enum weft_target_format)bad_enums[i]) == 0);
        TRUE(weft_stability_verdict_text((enum weft_stability_verdict)bad_enums[i])[0]);
        TRUE(weft_layout_name((enum weft_layout)bad_enums[i])[0]);
        TRUE(weft_source_format_name((enum weft_source_format)bad_enums[i])[0]);
        TRUE(weft_source_format_bytes((enum weft_source_format)bad_enums[i]) == 0);
        TRUE(isnan(weft_source_format_error((enum weft_source_format)bad_enums[i])));
    }
    TRUE(weft_version()[0]);
    char text[] = "\x1b[31m\xff\n";
    TRUE(weft_text_clean(text, false) == text);
    TRUE(weft_text_skip_mark("\xef\xbb")[0]);
}

static void find(void)
{
    TRUE(!weft_kernel_find("") && !weft_signal_find("") && !weft_profile_find(""));
    static const char *const names[] = {"linear", NULL};
    TRUE(!weft_closest_find("", SIZE_MAX, names) && !weft_closest_find("lin", 0, names));
    char text[8];
    TRUE(weft_closest_explain("lin", 3, names, text, 0) == text);
    TRUE(strlen(weft_closest_explain("lin", 3, names, text, sizeof text)) == sizeof text - 1);
    TRUE(!weft_stability_find("") && !weft_colour_map_find(""));
}

static void statistics(void)
{
    struct weft_statistics none = WEFT_STATISTICS_NONE;
    const float values[] = {NAN, INFINITY, -INFINITY};
    TRUE(weft_statistics_magnitude(&none) == 0.0);
    weft_statistics_add(&none, values, 0);
    weft_statistics_add(&none, values, WEFT_COUNT(values));
    weft_statistics_add_differences(&none, values, WEFT_COUNT(values), 0);
    weft_statistics_add_differences(&none, values, 0, SIZE_MAX);
    const struct weft_statistics_plane plane = {values, 3, 1, 0};
    TRUE(weft_statistics_plane_difference(&plane, 1, 0, SIZE_MAX) == 0.0);
    TRUE(weft_statistics_plane_difference(&plane, 4, 5, 0) == 0.0);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        TRUE(weft_statistics_plane_difference(&plane, ints[i], 0, 1) == 0.0);
    weft_statistics_join(&none, &(struct weft_statistics)WEFT_STATISTICS_NONE);
    TRUE(isnan(none.minimum) && none.not_finite == 3 && none.difference[0] == 0.0);
}

static void errors(void)
{
    struct weft_error_kernel out;
    struct weft_error_kernel_params good = {
        .kernel = named("linear"), .dims = 1, .samples = 8, .locations = 16, .log = &logger};
#define CALL weft_error_kernel_compute(&p, &out)
    KERNELS_REFUSED(good, 0, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    SURVIVED(weft_error_kernel_compute(&good, &out));
    good.threads = INT_MIN;
    SURVIVED(weft_error_kernel_compute(&good, &out));
    SET_REFUSED(good, locations, INT_MAX, CALL);
    SET_REFUSED(good, locations, -1, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, lookup, CALL);
    BAD_ENUM(good, convention, CALL);
#undef CALL
    EACH_BAD_KERNEL(0, if (k < 6 || k == 7) weft_error_e1(&kernel, 2, 1.0))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        if (ints[i] < 1 || ints[i] > 3)
            TRUE(isnan(weft_error_e1(&good.kernel, ints[i], 1.0)));
    }
}

static void bounds(void)
{
    const struct weft_bound_terms good = {.relative = 1e-6, .e2 = 1e-3, .rounded_gain = 1.0};
    const struct weft_bound_values read = {.low = -1.0, .high = 1.0};
    TRUE(weft_bound_compute(&good, &read).total > 0.0);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_bound_terms terms = good;
        struct weft_bound_values values = read;
        terms.e2 = values.beyond = numbers[n];
        weft_bound_compute(&terms, &read);
        weft_bound_compute(&good, &values);
    }
}

static void kernels(void)
{
    struct weft_kernel out;
    double weights[WEFT_KERNEL_MAX_WEIGHTS], fraction;
    char text[64];
    int64_t first[3];
    EACH_BAD_KERNEL(0, {
        struct weft_kernel copy = kernel;
        REFUSED(weft_kernel_check(&logger, &kernel));
        REFUSED(weft_kernel_normalise(&logger, &copy));
        REFUSED(weft_kernel_make_radial(&logger, &copy));
        REFUSED(weft_kernel_make_prefiltered(&logger, &copy));
        REFUSED(weft_kernel_derive(&logger, &kernel, &out));
        weft_kernel_format(&kernel, text, sizeof text);
        weft_kernel_weight(&kernel, 0.3);
        weft_kernel_derivative(&kernel, 0.3);
        weft_kernel_first_tap(&kernel, 0.3, &fraction);
        weft_kernel_offset(&kernel);
        weft_kernel_weights(&kernel, 0.3, weights);
        weft_kernel_is_radial(&kernel, 3);
        weft_kernel_weights_nd(&kernel, 3, (double[3]){0}, weights, first);
        weft_kernel_radial_sums(&kernel, 2);
    })
    struct weft_kernel good = named("catmull-rom");
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        weft_kernel_weight(&good, numbers[n]);
        weft_kernel_derivative(&good, numbers[n]);
        weft_kernel_first_tap(&good, numbers[n], &fraction);
        weft_kernel_weights(&good, numbers[n], weights);
    }
    const double *const axis[3] = {weights, weights, weights};
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        if (ints[i] < 1 || ints[i] > 3) {
            TRUE(weft_kernel_combine(&good, ints[i], axis, weights + 16) == 0);
            TRUE(weft_kernel_weights_nd(&good, ints[i], (double[3]){0}, weights, first) == 0);
            TRUE(isnan(weft_kernel_radial_sums(&good, ints[i]).least));
        }
        weft_kernel_is_radial(&good, ints[i]);
    }
    weft_kernel_format(&good, text, 0);
    TRUE(weft_kernel_translate("catrom", text, 0) && !weft_kernel_translate("", text, 16));
    TRUE(weft_kernel_translate("catrom", text, 4) && strcmp(text, "cat") == 0);
    TRUE(weft_kernel_aliases[0].name);
    REFUSED(weft_kernel_parse(&logger, "", &out));
    REFUSED(weft_kernel_parse(&logger, "cubic:nan", &out));
}

// A user's own record: the error names the member.
static char last_line[1024];

static void keep_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    (void)level;
    callers_lines++;
    snprintf(last_line, sizeof last_line, "%s", message);
}

static void records(void)
{
    static const struct weft_log keep = {.write = keep_line};
    static const char *const members[BAD_KERNELS] = {
        [8] = "weight", [9] = "name", [12] = "degree", [13] = "derivation"};
    struct weft_kernel out;
    for (int i = 7; i < BAD_KERNELS; i++) {
        struct weft_kernel_info info = *bad_kernel(i).info;
        info.unit_sum = i == 10;
        info.interpolating = i == 11;
        if (i < 14)
            REFUSED(weft_kernel_create(&keep, &info, NULL, &out));
        TRUE(!members[i] || strstr(last_line, members[i]));
        TRUE(i != 10 || strstr(last_line, "unit_sum"));
        TRUE(i != 11 || strstr(last_line, "interpolating"));
    }
    const struct weft_kernel_info *cubic = weft_kernel_find("cubic");
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_kernel_create(&keep, cubic, (double[2]){numbers[n], numbers[n]}, &out));
    struct weft_kernel_info own = *bad_kernel(14).info;
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        own.radius = numbers[n];
        if (!(own.radius > 0.0 && own.radius < 1.0))
            REFUSED(weft_kernel_create(&keep, &own, NULL, &out));
    }
}

static void tables(void)
{
    static const double samples[4] = {1.0, 0.5, 0.25, 0.0};
    struct weft_kernel_table out;
    struct weft_kernel_table_params good = {
        .samples = samples, .count = 4, .support = 1.0, .log = &logger};
#define CALL weft_kernel_table_init(&p, &out)
    ANY_NUMBER(good, support, CALL);
    BAD_ENUM(good, between, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, SIZE_MAX, CALL);
#undef CALL
}

static void prefilters(void)
{
    struct weft_prefilter good, out;
    struct weft_prefilter_axis axis;
    double values[WEFT_PREFILTER_MAX_WEIGHTS] = {0};
    const struct weft_kernel spline = named("bspline3i");
    TRUE(weft_prefilter_compute(&logger, &spline, &good) == WEFT_OK);
    EACH_BAD_KERNEL(0, {
        if (k == 0 || k >= 7)
            REFUSED(weft_prefilter_compute(&logger, &kernel, &out));
        weft_prefilter_weights(&good, &kernel, 4, 0.3, values);
    })
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_prefilter bad = good;
        bad.poles = ints[i];
        weft_prefilter_line(&bad, values, 8, 1, 0.0, NAN);
        weft_prefilter_overlap(&bad, 1e-9);
        weft_prefilter_taps(&bad, 4, values);
        weft_prefilter_weights(&bad, &spline, 4, 0.3, values);
        weft_prefilter_axis_set(&bad, &spline, 4, 0.3, INT64_MIN, INT64_MAX, &axis);
        weft_prefilter_axis_set(&good, &spline, ints[i], 0.3, ints[i], 7, &axis);
        if (ints[i] < 0 || ints[i] > WEFT_PREFILTER_MAX_OVERLAP) {
            weft_prefilter_taps(&good, ints[i], values);
            TRUE(weft_prefilter_weights(&good, &spline, ints[i], 0.3, values) == 0);
        }
    }
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const int overlap = weft_prefilter_overlap(&good, numbers[n]);
        TRUE(overlap >= 0 && overlap <= WEFT_PREFILTER_MAX_OVERLAP);
        weft_prefilter_weights(&good, &spline, 4, numbers[n], values);
    }
    weft_prefilter_line(&good, values, 0, PTRDIFF_MIN, NAN, NAN);
    EACH_BAD_KERNEL(0, if (k < 6 || k == 7) weft_prefilter_error(&kernel, 3, 0x1p-28))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_prefilter_error(&spline, ints[i], NAN);
    EACH_BAD_KERNEL(0, if (k < 6 || k == 7) weft_prefilter_error_axes(&kernel, 1, 0x1p-28))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_prefilter_error_axes((const struct weft_kernel[3]){spline, spline, spline}, ints[i],
                                  NAN);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_prefilter_error_join(
            (const struct weft_prefilter_error[3]){[1] = {.beyond = NAN, .gain = NAN}}, ints[i]);
    TRUE(!weft_prefilter_is_missing(NAN, NAN, NAN, true));
}

static double one(void *priv, const int64_t index[3])
{
    (void)priv;
    (void)index;
    return 1.0;
}

static void reference(void)
{
    struct weft_kernel good = named("linear");
    EACH_BAD_KERNEL(0, weft_reference_compute(&kernel, 3, (double[3]){0}, one, NULL))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_reference_compute(&good, ints[i], (double[3]){NAN, INFINITY, 1e300}, one, NULL);
    TRUE(isnan(weft_reference_compute(&good, 0, NULL, one, NULL).value));
    EACH_BAD_KERNEL(0, weft_reference_compute_axes((struct weft_kernel[3]){good, kernel, kernel}, 3,
                                                   (double[3]){0}, one, NULL))
    const struct weft_kernel axes[3] = {good, good, good};
    TRUE(isnan(weft_reference_compute_axes(axes, 0, NULL, one, NULL).value));
    double room[64];
    const double scale[3] = {2.0, 1.0, 1.5}, none[3] = {0.5, NAN, 1.0};
    EACH_BAD_KERNEL(0, TRUE(isnan(weft_reference_compute_stretched(&kernel, scale, 2,
                                                                   (double[2]){0}, room, one, NULL)
                                      .value)))
    TRUE(isnan(weft_reference_compute_stretched(&good, scale, 4, NULL, room, one, NULL).value));
    TRUE(isnan(
        weft_reference_compute_stretched(&good, none, 1, (double[1]){0}, room, one, NULL).value));
}

static void rectangles(void)
{
    static const struct weft_rectangle bad[] = {
        {-1, 0, 2, 2},      {0, 0, 5, 2},      {0, 0, 2, 9},       {3, 0, 2, 2},
        {0, 0, 0, 2},       {1, 1, 0, 0},      {0, 0, INT_MIN, 1}, {INT_MAX, 0, INT_MAX, 1},
        {0, INT_MIN, 1, 1}, {0, 0, 1, INT_MAX}};
    const struct weft_rectangle none = {0}, some = {1, 2, 3, 4};
    struct weft_rectangle out;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        REFUSED(weft_rectangle_within(&logger, &bad[i], 4, 8, &out));
    TRUE(weft_rectangle_within(&logger, &none, 4, 8, &out) == WEFT_OK && out.width == 4 &&
         out.height == 8);
    out = weft_rectangle_common(&some, &out);
    TRUE(memcmp(&out, &some, sizeof out) == 0);
    out = weft_rectangle_common(&some, &(struct weft_rectangle){4, 2, 1, 1});
    TRUE(memcmp(&out, &none, sizeof out) == 0);
}

static void boundaries(void)
{
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        TRUE(weft_boundary_index((enum weft_boundary)bad_enums[i], 0, 4) == -1);
    for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++) {
        const enum weft_boundary boundary = (enum weft_boundary)b;
        TRUE(weft_boundary_index(boundary, 0, 0) == -1);
        TRUE(weft_boundary_index(boundary, 0, INT64_MAX) == -1);
        TRUE(weft_boundary_index(boundary, INT64_MIN, 7) < 7);
        TRUE(weft_boundary_index(boundary, INT64_MAX, 7) < 7);
    }
}

static void stretches(void)
{
    double weights[64];
    const struct weft_kernel good = named("catmull-rom"), radial = named("catmull-rom+radial");
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        const bool fits = numbers[i] >= 1.0 && numbers[i] <= WEFT_STRETCH_MAX;
        TRUE((weft_stretch_width(&good, numbers[i]) == 0) == !fits);
        const double scale = weft_stretch_scale(&good, numbers[i]);
        TRUE(scale >= 1.0 && scale <= WEFT_STRETCH_MAX);
        weft_stretch_weights(&good, 2.0, numbers[i], weights);
    }
    TRUE(weft_stretch_width(&radial, 2.0) == 0 &&
         weft_stretch_weights(&radial, 2.0, 0.0, NULL) == 0);
    EACH_BAD_KERNEL(0, TRUE(weft_stretch_width(&kernel, 2.0) == 0);
                    weft_stretch_weights(&kernel, 2.0, 0.5, weights))
}

static void quantities(void)
{
    struct weft_quantities list;
    struct weft_quantity_transform transform;
    enum weft_quantity all[WEFT_QUANTITY_COUNT + 1];
    double derivative[WEFT_DERIVATIVES], error[WEFT_DERIVATIVES], channel[WEFT_QUANTITY_CHANNELS];
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        all[0] = (enum weft_quantity)bad_enums[i];
        REFUSED(weft_quantities_create(&logger, all, 1, &list));
        TRUE(list.count == 0 && list.channel_count == 0);
    }
    for (int q = 0; q <= WEFT_QUANTITY_COUNT; q++)
        all[q] = (enum weft_quantity)(q % WEFT_QUANTITY_COUNT);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        if (ints[i] != 1)
            REFUSED(weft_quantities_create(&logger, all, ints[i], &list));
    REFUSED(weft_quantities_create(&logger, NULL, 1, &list));
    REFUSED(weft_quantities_parse(&logger, "", &list));
    REFUSED(weft_quantities_parse(&logger, ",,,,,,,,,,,,,,,,,,,,,,,,", &list));
    REFUSED(weft_quantity_transform_create(&logger, (double[3][4]){{0.0}}, &transform));
    TRUE(transform.inverse[0][0] == 0.0);
    TRUE(weft_quantities_create(&logger, all, WEFT_QUANTITY_COUNT, &list) == WEFT_OK);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        double m[3][4] = {{1.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}};
        m[n % 3][(n + 1) % 3] = numbers[n];
        for (int i = 0; i < WEFT_DERIVATIVES; i++)
            derivative[i] = error[i] = numbers[n];
        if (weft_quantity_transform_create(&logger, m, &transform) != WEFT_OK) {
            TRUE(callers_lines == 1);
            callers_lines = 0;
            continue;
        }
        weft_quantities_compute(&list, &transform, derivative, channel);
        weft_quantities_bound(&list, &transform, derivative, error, channel);
        TRUE(isinf(channel[5]));
    }
    weft_quantities_compute_planes(&list, &transform, 0, NULL, NULL);
}

static void derivatives(void)
{
    struct weft_derivative out;
    char text[WEFT_DERIVATIVE_TEXT];
    static const char *const bad[] = {"", "xxx", "w", "X", "x ", "nonenonenonenonenonenone"};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        REFUSED(weft_derivative_parse(&logger, bad[i], &out));
        TRUE(weft_derivative_order(&out) == 0);
    }
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const struct weft_derivative d = {{1, ints[i], 0}}, e = {{2, 2, ints[i]}};
        const bool good = ints[i] == 0 || ints[i] == 1;
        TRUE((weft_derivative_order(&d) >= 0) == good && weft_derivative_order(&e) == -1);
        TRUE((strcmp(weft_derivative_format(&d, text), "unknown") == 0) == !good);
    }
}

const struct caller_case callers_filter[] = {
    {analysis,
     {F(analysis_taylor), F(analysis_moment), F(analysis_order), F(analysis_response),
      F(analysis_metrics), F(analysis_overshoot), F(analysis_gain), F(analysis_curvature),
      F(analysis_slope)}},
    {texts,
     {F(result_text), F(version), F(text_clean), F(text_skip_mark), F(target_name), F(target_bits),
      F(target_one), F(stability_verdict_text), F(layout_name), F(source_format_name),
      F(source_format_bytes), F(source_format_error)}},
    {find,
     {F(closest_find), F(closest_explain), F(kernel_find), F(signal_find), F(profile_find), F(stability_find),
      F(colour_map_find)}},
    {statistics,
     {F(statistics_add), F(statistics_add_differences), F(statistics_magnitude), F(statistics_join),
      F(statistics_plane_difference)}},
    {errors, {F(error_kernel_compute), F(error_e1)}},
    {bounds, {F(bound_compute)}},
    {boundaries, {F(boundary_index)}},
    {derivatives, {F(derivative_order), F(derivative_format), F(derivative_parse)}},
    {quantities,
     {F(quantities_create), F(quantities_parse), F(quantity_transform_create),
      F(quantities_compute), F(quantities_bound), F(quantities_compute_planes)}},
    {stretches, {F(stretch_scale), F(stretch_width), F(stretch_weights)}},
    {kernels,
     {F(kernel_check), F(kernel_normalise), F(kernel_make_radial), F(kernel_make_prefiltered),
      F(kernel_derive), F(kernel_format), F(kernel_weight), F(kernel_derivative),
      F(kernel_first_tap), F(kernel_offset), F(kernel_weights), F(kernel_is_radial),
      F(kernel_weights_nd), F(kernel_radial_sums), F(kernel_combine), F(kernel_parse),
      F(kernel_translate)}},
    {records, {F(kernel_create)}},
    {tables, {F(kernel_table_init)}},
    {prefilters,
     {F(prefilter_compute), F(prefilter_line), F(prefilter_overlap), F(prefilter_taps),
      F(prefilter_is_missing), F(prefilter_error), F(prefilter_error_axes), F(prefilter_error_join),
      F(prefilter_axis_set), F(prefilter_weights)}},
    {reference, {F(reference_compute), F(reference_compute_axes), F(reference_compute_stretched)}},
    {rectangles, {F(rectangle_within), F(rectangle_common)}},
    {0},
};
