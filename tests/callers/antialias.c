// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void patterns(void)
{
    static const double device[2][2] = {{0.25, -0.25}, {-0.25, 0.25}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_pattern_params good = {
        .device = device, .device_count = 2, .count = 4, .log = &logger};
    static struct weft_pattern pattern;
#define CALL weft_pattern_create(&p, &pattern)
    SET_REFUSED(good, device, NULL, CALL);
    SET_REFUSED(good, device, beyond, CALL);
    SET_REFUSED(good, device_count, 0, CALL);
    SET_REFUSED(good, device_count, INT_MIN, CALL);
    SET_REFUSED(good, device_count, 3, CALL);
    SET_REFUSED(good, device_count, INT_MAX, CALL);
    ANY_INT(good, count, CALL);
#undef CALL
    REFUSED(weft_pattern_create(&(struct weft_pattern_params){.log = &logger}, &pattern));
}

static void spreads(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_spread_params good = {.position = points, .count = 2, .log = &logger};
    struct weft_spread s;
#define CALL weft_spread_create(&p, &s)
#define CALL_AND_CLEAR (CALL == WEFT_OK ? weft_spread_clear(&s), WEFT_OK : WEFT_ERR_ARGUMENT)
    SET_REFUSED(good, position, NULL, CALL);
    SET_REFUSED(good, position, beyond, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT_MAX, CALL);
    SET_REFUSED(good, bits, 31, CALL);
    SET_REFUSED(good, bits, INT_MIN, CALL);
    ANY_NUMBER(good, filter_width, CALL_AND_CLEAR);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, filter, bad_kernel(i), CALL);
#undef CALL_AND_CLEAR
#undef CALL
    weft_spread_clear(NULL);
}

static void antialias_bytes(void)
{
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        TRUE(weft_antialias_format_bytes((enum weft_antialias_format)bad_enums[i]) == 0);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int n = ints[i];
        TRUE(weft_bytes_multisample(n, n, n, n, n) == 0 || n > 0);
        TRUE(weft_bytes_accumulative(n, n, n, n, n) == 0 || n > 0);
        TRUE(weft_bytes_adaptive(n, n, n, n, n, n) == 0 || n > 0);
    }
}

static enum weft_result draw_nothing(void *priv, const struct weft_antialias_pass *pass)
{
    (void)priv;
    (void)pass;
    return WEFT_OK;
}

static void multisampling(void)
{
    static double at[WEFT_PATTERN_MAX][2];
    weft_context *context = open_context();
    struct weft_msaa_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_msaa *msaa = NULL;
    float out[16];
    callers_lines = 0;
#define CALL weft_msaa_create(&p, &msaa)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, samples, -1, CALL);
    SET_REFUSED(good, samples, INT_MAX, CALL);
    SET_REFUSED(good, depth_bits, 16, CALL);
    SET_REFUSED(good, range, (double)NAN, CALL);
    SET_REFUSED(good, range, -1.0, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, resolve, CALL);
#undef CALL
    TRUE(weft_msaa_create(&good, &msaa) == WEFT_OK);
    REFUSED(weft_msaa_read(msaa, 0, out, 0));
    REFUSED(weft_msaa_run(msaa, NULL));
    REFUSED(weft_msaa_run(msaa, &(struct weft_antialias_drawing){.draw = NULL}));
    REFUSED(weft_msaa_run(
        msaa, &(struct weft_antialias_drawing){.draw = draw_nothing, .part = {0, -1, 1, 1}}));
    SURVIVED(weft_msaa_run(msaa, &(struct weft_antialias_drawing){.draw = draw_nothing}));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        SURVIVED(weft_msaa_read(msaa, ints[i], out, 0));
        TRUE(weft_msaa_positions(context, ints[i], at) >= 0);
        TRUE(weft_msaa_positions(NULL, ints[i], at) == 0);
    }
    struct weft_msaa_report report;
    weft_msaa_get_report(msaa, &report);
    TRUE(report.samples == 4);
    weft_msaa_destroy(&msaa);
    weft_msaa_destroy(&msaa);
    weft_msaa_destroy(NULL);
    weft_context_destroy(&context);
}

static void accumulative_room(weft_acaa *acaa, bool has)
{
    struct weft_acaa_room room;
    weft_acaa_get_room(acaa, &room);
    TRUE(has ? room.range >= 1.0 && room.weight == 1.0 : room.range == 0.0);
    TRUE(weft_acaa_set_room(acaa, &room) == WEFT_OK);
    if (!has)
        return;
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){0.0, 1.0}));
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){room.range, (double)NAN}));
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){1e300, 1e300}));
}

static void accumulative_run(weft_acaa *acaa)
{
    float out[16];
    REFUSED(weft_acaa_read(acaa, 0, out, 0));
    REFUSED(weft_acaa_read_weight(acaa, out, 0));
    REFUSED(weft_acaa_run(acaa, NULL, NULL));
    REFUSED(weft_acaa_run(acaa, &(struct weft_antialias_drawing){.draw = NULL}, NULL));
    REFUSED(weft_acaa_run(
        acaa, &(struct weft_antialias_drawing){.draw = draw_nothing, .part = {1, 0, 4, 1}}, NULL));
    TRUE(weft_acaa_run(acaa, &(struct weft_antialias_drawing){.draw = draw_nothing}, NULL) ==
         WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(weft_acaa_read(acaa, ints[i], out, 0));
    REFUSED(weft_acaa_read(acaa, 0, NULL, 0));
    REFUSED(weft_acaa_read(acaa, 0, out, 3));
    REFUSED(weft_acaa_read_weight(acaa, NULL, 0));
    REFUSED(weft_acaa_read_weight(acaa, out, 3));
    TRUE(weft_acaa_read_weight(acaa, out, 0) == WEFT_OK && out[15] == 1.0f);
}

static void accumulative(void)
{
    weft_context *context = open_context();
    struct weft_acaa_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_acaa *acaa = NULL;
    callers_lines = 0;
#define CALL weft_acaa_create(&p, &acaa)
#define CALL_AND_DESTROY (CALL == WEFT_OK ? weft_acaa_destroy(&acaa), WEFT_OK : WEFT_ERR_LIMIT)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, samples, -1, CALL);
    SET_REFUSED(good, samples, INT_MAX, CALL);
    SET_REFUSED(good, depth_bits, 16, CALL);
    SET_REFUSED(good, range, (double)NAN, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    ANY_NUMBER(good, range, CALL_AND_DESTROY);
    ANY_NUMBER(good, filter_width, CALL_AND_DESTROY);
    BAD_ENUM(good, form, CALL);
    BAD_ENUM(good, coincident, CALL);
    BAD_ENUM(good, sums, CALL);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, filter, bad_kernel(i), CALL);
#undef CALL_AND_DESTROY
#undef CALL
    for (int f = WEFT_ACAA_AUTO; f < WEFT_ACAA_FORM_COUNT; f += WEFT_ACAA_JITTER) {
        good.form = (enum weft_acaa_form)f;
        TRUE(weft_acaa_create(&good, &acaa) == WEFT_OK);
        accumulative_run(acaa);
        accumulative_room(acaa, f != WEFT_ACAA_JITTER);
        struct weft_acaa_report report;
        weft_acaa_get_report(acaa, &report);
        TRUE(report.samples == 4);
        weft_acaa_destroy(&acaa);
    }
    weft_acaa_destroy(&acaa);
    weft_acaa_destroy(NULL);
    weft_context_destroy(&context);
}

static void marks_run(weft_marker *marker)
{
    float out[16];
    struct weft_marks marks;
    REFUSED(weft_marker_read(marker, 0, out, 0));
    REFUSED(weft_marker_run(marker, NULL, &marks));
    REFUSED(weft_marker_run(marker, &(struct weft_antialias_drawing){.draw = NULL}, &marks));
    TRUE(weft_marker_run(marker, &(struct weft_antialias_drawing){.draw = draw_nothing}, &marks) ==
         WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        SURVIVED(weft_marker_read(marker, ints[i], out, 0));
        TRUE(weft_marks_dilate(&marks, ints[i]) ==
             (ints[i] < 0 || ints[i] > WEFT_MARKS_MAX_RADIUS ? WEFT_ERR_ARGUMENT : WEFT_OK));
    }
    REFUSED(weft_marker_read(marker, 0, NULL, 0));
    REFUSED(weft_marker_read(marker, 0, out, 3));
    TRUE(weft_marker_bytes(marker) > 0 && weft_marker_bytes(NULL) == 0);
    weft_marks_clear(&marks);
    weft_marks_clear(&marks);
    weft_marks_clear(NULL);
    TRUE(weft_marks_dilate(&marks, 1) == WEFT_ERR_ARGUMENT);
    TRUE(weft_marks_dilate(NULL, 1) == WEFT_ERR_ARGUMENT);
}

static void marking(void)
{
    weft_context *context = open_context();
    struct weft_marker_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_marker *marker = NULL;
    callers_lines = 0;
#define CALL weft_marker_create(&p, &marker)
#define CALL_AND_DESTROY (CALL == WEFT_OK ? weft_marker_destroy(&marker), WEFT_OK : WEFT_ERR_LIMIT)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, contrast, (double)NAN, CALL);
    SET_REFUSED(good, contrast, -1.0, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    ANY_NUMBER(good, max_share, CALL_AND_DESTROY);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, mark, CALL);
#undef CALL_AND_DESTROY
#undef CALL
    TRUE(weft_marker_create(&good, &marker) == WEFT_OK);
    marks_run(marker);
    weft_marker_destroy(&marker);
    weft_marker_destroy(&marker);
    weft_marker_destroy(NULL);
    weft_context_destroy(&context);
}

static void run_supersample(weft_supersample *s)
{
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    struct weft_marks marks = {.width = 4, .height = 4, .marked = calloc(16, 1)};
    float out[16];
    REFUSED(weft_supersample_read(s, 0, out, 0));
    REFUSED(weft_supersample_run(s, NULL, NULL, NULL));
    REFUSED(weft_supersample_run(s, &(struct weft_antialias_drawing){.draw = NULL}, NULL, NULL));
    REFUSED(weft_supersample_run(s, &drawing, &(struct weft_marks){0}, NULL));
    REFUSED(weft_supersample_run(s, &drawing, &(struct weft_marks){.width = 4, .height = 4}, NULL));
    SURVIVED(weft_supersample_run(s, &drawing, &marks, NULL));
    SURVIVED(weft_supersample_run(s, &drawing, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(weft_supersample_read(s, ints[i], out, 0));
    weft_marks_clear(&marks);
}

static void supersampling(void)
{
    static const double outside[1][2] = {{0.0, 2.0}}, none[1][2] = {{(double)NAN, 0.0}};
    weft_context *context = open_context();
    struct weft_supersample_params good = {
        .width = 4, .height = 4, .count = 4, .context = context, .log = &logger};
    weft_supersample *s = NULL;
    struct weft_kernel kernel;
    callers_lines = 0;
#define CALL weft_supersample_create(&p, &s)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, count, -1, CALL);
    SET_REFUSED(good, count, 15, CALL);
    SET_REFUSED(good, count, INT_MAX, CALL);
    SET_REFUSED(good, filter_width, (double)NAN, CALL);
    SET_REFUSED(good, filter_width, 1e6, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    BAD_ENUM(good, store, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, method, CALL);
    good.count = 1;
    SET_REFUSED(good, position, outside, CALL);
    SET_REFUSED(good, position, none, CALL);
    TRUE(weft_kernel_parse(&logger, "mitchell", &kernel) == WEFT_OK);
    good.count = 4;
    good.filter = kernel;
    SET_REFUSED(good, method, WEFT_ACCUMULATE_TREE, CALL);
    good.count = 1;
#undef CALL
    TRUE(weft_supersample_create(&good, &s) == WEFT_OK);
    run_supersample(s);
    struct weft_supersample_report report;
    weft_supersample_get_report(s, &report);
    TRUE(report.samples == 1);
    weft_supersample_destroy(&s);
    weft_supersample_destroy(&s);
    weft_supersample_destroy(NULL);
    weft_context_destroy(&context);
}

const struct caller_case callers_antialias[] = {
    {patterns, {F(pattern_create)}},
    {spreads, {F(spread_create), F(spread_clear)}},
    {antialias_bytes,
     {F(antialias_format_bytes), F(bytes_multisample), F(bytes_accumulative), F(bytes_adaptive)}},
    {multisampling,
     {F(msaa_create), F(msaa_destroy), F(msaa_run), F(msaa_read), F(msaa_get_report),
      F(msaa_positions)}},
    {accumulative,
     {F(acaa_create), F(acaa_destroy), F(acaa_run), F(acaa_read), F(acaa_read_weight),
      F(acaa_get_room), F(acaa_set_room), F(acaa_get_report)}},
    {marking,
     {F(marker_create), F(marker_destroy), F(marker_run), F(marker_read), F(marker_bytes),
      F(marks_clear), F(marks_dilate)}},
    {supersampling,
     {F(supersample_create), F(supersample_destroy), F(supersample_run), F(supersample_read),
      F(supersample_get_report)}},
    {0},
};
