// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static enum weft_result make_accum_buffer(const struct weft_accum_buffer_params *p)
{
    weft_accum_buffer *buffer = NULL;
    const enum weft_result res = weft_accum_buffer_create(p, &buffer);
    weft_accum_buffer_destroy(&buffer);
    return res;
}

static void accum_buffers(void)
{
    struct weft_accum_buffer_params good = {
        .width = 2, .height = 2, .channel_count = 1, .log = &logger};
    const float values[4] = {0.0f, 1.0f, NAN, INFINITY};
    const struct weft_plane plane = {.values = values}, none = {.values = NULL};
    float out[4];
    weft_accum_buffer *buffer = NULL;
    for (int i = -1; i <= 0; i++) {
        SET_REFUSED(good, width, i, make_accum_buffer(&p));
        SET_REFUSED(good, height, i, make_accum_buffer(&p));
        SET_REFUSED(good, channel_count, i, make_accum_buffer(&p));
    }
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        if (ints[i] != 0)
            SET_REFUSED(good, bits, ints[i], make_accum_buffer(&p));
    BAD_ENUM(good, rounding, make_accum_buffer(&p));
    BAD_ENUM(good, cpu.instructions, make_accum_buffer(&p));
    SET_REFUSED(good, cpu.threads, -1, make_accum_buffer(&p));
    TRUE(weft_accum_buffer_create(&good, &buffer) == WEFT_OK);
    for (size_t i = 0; i < 5; i++) {
        REFUSED(weft_accum_buffer_load(buffer, &plane, numbers[i]));
        REFUSED(weft_accum_buffer_accum(buffer, &plane, numbers[i]));
        REFUSED(weft_accum_buffer_add(buffer, numbers[i]));
        REFUSED(weft_accum_buffer_mult(buffer, numbers[i]));
    }
    REFUSED(weft_accum_buffer_load(buffer, &none, 1.0));
    TRUE(weft_accum_buffer_load(buffer, &plane, 1e12) == WEFT_OK);
    TRUE(weft_accum_buffer_accum(buffer, &plane, -1e12) == WEFT_OK);
    REFUSED(weft_accum_buffer_return(buffer, NAN, 0, out, 0));
    REFUSED(weft_accum_buffer_return(buffer, 1.0, 1, out, 0));
    REFUSED(weft_accum_buffer_return(buffer, 1.0, 0, out, 1));
    REFUSED(weft_accum_buffer_read(buffer, 1.0, INFINITY, 0, out, 0));
    REFUSED(weft_accum_buffer_read(buffer, 1.0, 0.0, -1, out, 0));
    TRUE(weft_accum_buffer_read(buffer, 1.0, 0.0, 0, out, 0) == WEFT_OK);
    weft_accum_buffer_destroy(&buffer);
    weft_accum_buffer_destroy(NULL);
}

static enum weft_result make_jitter(const struct weft_jitter_params *p)
{
    struct weft_jitter set;
    const enum weft_result res = weft_jitter_create(p, &set);
    TRUE((res == WEFT_OK) == (set.points != NULL));
    weft_jitter_clear(&set);
    return res;
}

static void jitters(void)
{
    struct weft_jitter_params good = {.info = weft_jitter_find("grid"), .log = &logger};
    const struct weft_jitter_info *info, none = {0};
    int count;
    SET_REFUSED(good, info, NULL, make_jitter(&p));
    SET_REFUSED(good, info, &none, make_jitter(&p));
    BAD_ENUM(good, shape, make_jitter(&p));
    ANY_INT(good, count, make_jitter(&p));
    ANY_NUMBER(good, size, make_jitter(&p));
    SET_REFUSED(good, count, -1, make_jitter(&p));
    SET_REFUSED(good, count, INT_MAX, make_jitter(&p));
    weft_jitter_clear(NULL);
    TRUE(weft_jitter_find(NULL) == NULL && weft_jitter_find("") == NULL);
    REFUSED(weft_jitter_parse(&logger, "", &info, &count));
    REFUSED(weft_jitter_parse(&logger, ":", &info, &count));
    REFUSED(weft_jitter_parse(&logger, "grid:99999999999999999999", &info, &count));
    REFUSED(weft_jitter_parse(&logger, "grid:1\n", &info, &count));
    TRUE(isnan(weft_jitter_radical_inverse(0, 0)) && isnan(weft_jitter_radical_inverse(1, 5)));
    TRUE(weft_jitter_radical_inverse(1u << 26, UINT64_MAX) < 1.0);
}

static void discrepancies(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_discrepancy_params good = {.points = points, .count = 2, .log = &logger};
    struct weft_discrepancy d;
#define CALL weft_discrepancy_compute(&p, &d)
    SET_REFUSED(good, points, NULL, CALL);
    BAD_ENUM(good, shape, CALL);
    ANY_NUMBER(good, size, CALL);
    const int counts[] = {INT_MIN, -1, 0, WEFT_DISCREPANCY_MAX + 1, INT_MAX};
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        SET_REFUSED(good, count, counts[i], CALL);
    struct weft_discrepancy_params far = good;
    far.points = beyond;
    SURVIVED(weft_discrepancy_compute(&far, &d));
#undef CALL
}

static void edges(void)
{
    struct weft_edge_value v;
    const double normal[2] = {0.6, 0.8};
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        const double n[2] = {numbers[i], 1.0}, share = weft_edge_square(normal, numbers[i]);
        TRUE(isnan(numbers[i]) ? isnan(share) : share >= 0.0 && share <= 1.0);
        const double disc = weft_edge_disc(numbers[i]);
        TRUE(isnan(numbers[i]) ? isnan(disc) : disc >= 0.0 && disc <= 1.0);
        weft_edge_square(n, 0.1);
        const struct weft_kernel kernel = named("mitchell");
        SURVIVED(weft_edge_kernel(&logger, &kernel, 0.0, n, 0.1, &v));
        SURVIVED(weft_edge_kernel(&logger, &kernel, 0.0, normal, numbers[i], &v));
        SURVIVED(weft_edge_kernel(&logger, &kernel, numbers[i], normal, 0.1, &v));
    }
    for (int i = 0; i < BAD_KERNELS; i++) {
        const struct weft_kernel kernel = bad_kernel(i);
        REFUSED(weft_edge_kernel(&logger, &kernel, 0.0, normal, 0.1, &v));
    }
}

static void frame_weights(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_weights_kernel_params good = {.points = points, .count = 2, .log = &logger};
    double weights[2];
#define CALL weft_weights_kernel(&p, weights, NULL)
    SET_REFUSED(good, points, NULL, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT_MIN, CALL);
    ANY_NUMBER(good, width, CALL);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, kernel, bad_kernel(i), CALL);
#undef CALL
    good.points = beyond;
    SURVIVED(weft_weights_kernel(&good, weights, NULL));
    REFUSED(weft_weights_even(&logger, 0, weights, NULL));
    REFUSED(weft_weights_even(&logger, INT_MIN, weights, NULL));
    REFUSED(weft_weights_even(&logger, 2, NULL, NULL));
    REFUSED(weft_weights_normalise(&logger, INT_MIN, weights, NULL));
    REFUSED(weft_weights_normalise(&logger, 2, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        struct weft_weights_report report;
        weights[0] = numbers[i];
        weights[1] = -1.0;
        SURVIVED(weft_weights_normalise(&logger, 2, weights, &report));
    }
}

static void shutters(void)
{
    struct weft_shutter good = WEFT_SHUTTER_BOX, out;
    double weights[3];
#define CALL weft_shutter_weights(&logger, &p, 3, NULL, weights, NULL)
    BAD_ENUM(good, shape, CALL);
    ANY_NUMBER(good, open, CALL);
    ANY_NUMBER(good, close, CALL);
    good.shape = WEFT_SHUTTER_GAUSS;
    ANY_NUMBER(good, sigma, CALL);
#undef CALL
    good = (struct weft_shutter)WEFT_SHUTTER_TENT;
    REFUSED(weft_shutter_weights(&logger, &good, 0, NULL, weights, NULL));
    REFUSED(weft_shutter_weights(&logger, &good, INT_MIN, NULL, weights, NULL));
    REFUSED(weft_shutter_parse(&logger, "", &out));
    REFUSED(weft_shutter_parse(&logger, ":", &out));
    REFUSED(weft_shutter_parse(&logger, "gauss:1e999", &out));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        TRUE(isnan(weft_shutter_light(&good, numbers[i])) == isnan(numbers[i]));
        TRUE(isnan(weft_shutter_share(&good, numbers[i])) == isnan(numbers[i]));
        TRUE(weft_frames_for_motion(numbers[i]) == -1 || weft_frames_for_motion(numbers[i]) >= 1);
        TRUE(weft_frames_for_circle(numbers[i]) == -1 || weft_frames_for_circle(numbers[i]) >= 1);
        const int64_t frames = weft_frames_for_penumbra(numbers[i], numbers[i]);
        TRUE(frames == -1 || frames >= 1);
    }
}

static void cameras(void)
{
    struct weft_camera good = {WEFT_CAMERA_DEFAULTS};
    struct weft_camera_frame frame = {.size = {4, 3}, .lens = {0.1, 0.0}, .focus = 2.0};
    struct weft_camera_matrices m;
#define CALL weft_camera_compute(&logger, &p, &frame, &m)
    ANY_NUMBER(good, fovy_degrees, CALL);
    ANY_NUMBER(good, aspect, CALL);
    ANY_NUMBER(good, near_distance, CALL);
    ANY_NUMBER(good, far_distance, CALL);
    ANY_NUMBER(good, eye[1], CALL);
    ANY_NUMBER(good, target[2], CALL);
    ANY_NUMBER(good, up[0], CALL);
    SET_REFUSED(good, up[1], 0.0, CALL);
#undef CALL
#define CALL weft_camera_compute(&logger, &good, &p, &m)
    ANY_INT(frame, size[0], CALL);
    ANY_NUMBER(frame, move[0], CALL);
    ANY_NUMBER(frame, lens[1], CALL);
    ANY_NUMBER(frame, focus, CALL);
    SET_REFUSED(frame, size[1], 0, CALL);
    SET_REFUSED(frame, focus, 0.0, CALL);
#undef CALL
    TRUE(isnan(weft_camera_circle(&good, frame.size, -1.0, 2.0, 3.0)));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        const double sample[2] = {numbers[i], numbers[i]};
        double move[2];
        weft_camera_move_to(sample, move);
        weft_camera_circle(&good, frame.size, 1.0, 2.0, numbers[i]);
    }
}

static enum weft_result make_accumulator(const struct weft_accumulator_params *p)
{
    weft_accumulator *a = NULL;
    const enum weft_result res = weft_accumulator_create(p, &a);
    weft_accumulator_destroy(&a);
    return res;
}

static const struct weft_accumulator_params usual_accumulator = {.width = 2,
                                                                 .height = 2,
                                                                 .channel_count = 1,
                                                                 .method = WEFT_ACCUMULATE_EXACT,
                                                                 .keep = WEFT_KEEP_VARIANCE,
                                                                 .log = &logger};

static void accumulators(void)
{
    struct weft_accumulator_params good = usual_accumulator;
    static const double weights[2] = {1.0, -1.0};
#define CALL make_accumulator(&p)
    for (int i = -1; i <= 0; i++) {
        SET_REFUSED(good, width, i, CALL);
        SET_REFUSED(good, height, i, CALL);
        SET_REFUSED(good, channel_count, i, CALL);
    }
    BAD_ENUM(good, method, CALL);
    BAD_ENUM(good, nonfinite, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, cpu.instructions, CALL);
    SET_REFUSED(good, frame_count, -1, CALL);
    SET_REFUSED(good, frame_count, INT64_MAX, CALL);
    SET_REFUSED(good, weight, weights, CALL); // of how many frames?
    SET_REFUSED(good, keep, 4, CALL);
    SET_REFUSED(good, batch, -1, CALL);
    SET_REFUSED(good, cpu.threads, -1, CALL);
    for (int method = 0; method < WEFT_ACCUMULATE_METHOD_COUNT; method++) {
        struct weft_accumulator_params emulated = good;
        emulated.method = (enum weft_accumulate_method)method;
        emulated.emulate = true;
        TRUE(make_accumulator(&emulated) == WEFT_OK);
        ANY_INT(emulated, branching, CALL);
        ANY_INT(emulated, level_branching[0], CALL);
        ANY_INT(emulated, level_branching[WEFT_TREE_MAX_LEVELS - 1], CALL);
        ANY_INT(emulated, bits, CALL);
        ANY_INT(emulated, frame_bits, CALL);
        ANY_NUMBER(emulated, low, CALL);
        ANY_NUMBER(emulated, high, CALL);
        ANY_NUMBER(emulated, max_error, CALL);
        emulated.frame_count = 2;
        SET_REFUSED(emulated, weight, weights, CALL); // adds up to 0
        emulated.emulate = false;
        emulated.weight = NULL;
        const bool on_gl = method == WEFT_ACCUMULATE_TREE || method == WEFT_ACCUMULATE_BLEND ||
                           method == WEFT_ACCUMULATE_FLOAT;
        TRUE((make_accumulator(&emulated) != WEFT_OK) == on_gl); // there is no context
        callers_lines = 0;
    }
#undef CALL
}

static void accumulations(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    const struct weft_plane plane = {.values = values}, empty = {.values = NULL};
    struct weft_plane unknown = plane;
    const struct weft_frame frame = {.plane = &plane}, none = {.plane = NULL};
    struct weft_accumulator_report report;
    weft_accumulator *a = NULL;
    float out[4];
    TRUE(weft_accumulator_create(&usual_accumulator, &a) == WEFT_OK);
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0)); // no frame
    REFUSED(weft_accumulator_finish(a));
    REFUSED(weft_accumulator_add(a, NULL, 1.0));
    REFUSED(weft_accumulator_add(a, &none, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &empty}, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane, .texture = 1}, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.texture = 1}, 1.0));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        unknown.type = (enum weft_plane_type)bad_enums[i];
        REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &unknown}, 1.0));
    }
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        SURVIVED(weft_accumulator_add(a, &frame, numbers[i]));
    TRUE(weft_accumulator_add(a, &frame, 1.0) == WEFT_OK);
    TRUE(weft_accumulator_add(a, &frame, 5.0) == WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        REFUSED(weft_accumulator_current(a, (enum weft_accumulated)bad_enums[i], 0, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MINIMUM, 0, out, 0)); // is not kept
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, -1, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 1, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 1));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, NULL, 0));
    REFUSED(weft_accumulator_current_texture(a, WEFT_ACCUMULATED_MEAN, 0, 1, NULL));
    REFUSED(weft_accumulator_current_texture(a, WEFT_ACCUMULATED_MEAN, 0, 1, // no context
                                             &(struct weft_texture){.name = 1}));
    TRUE(weft_accumulator_finish(a) == WEFT_OK && weft_accumulator_finish(a) == WEFT_OK);
    REFUSED(weft_accumulator_add(a, &frame, 1.0));
    TRUE(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0) == WEFT_OK);
    weft_accumulator_get_report(a, &report);
    TRUE(report.method == WEFT_ACCUMULATE_EXACT && report.counted >= 2);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(NULL);
}

static void accumulator_judgements(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    const struct weft_plane plane = {.values = values};
    struct weft_until good = {.absolute = 1.0};
    struct weft_accumulator_params plain = usual_accumulator;
    struct weft_convergence found;
    weft_accumulator *a = NULL;
    TRUE(weft_accumulator_create(&plain, &a) == WEFT_OK);
    REFUSED(weft_accumulator_judge(a, &good, &found)); // no frame
    TRUE(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0) == WEFT_OK);
#define CALL weft_accumulator_judge(a, &p, &found)
    SET_REFUSED(good, absolute, 0.0, CALL);
    ANY_NUMBER(good, absolute, CALL);
    ANY_NUMBER(good, relative, CALL);
    ANY_NUMBER(good, share, CALL);
    SET_REFUSED(good, share, 1.5, CALL);
    SET_REFUSED(good, least, 1, CALL);
    SET_REFUSED(good, least, INT64_MIN, CALL);
    ANY_INT(good, radius, CALL);
#undef CALL
    weft_accumulator_destroy(&a);
    plain.keep = 0;
    TRUE(weft_accumulator_create(&plain, &a) == WEFT_OK);
    TRUE(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0) == WEFT_OK);
    REFUSED(weft_accumulator_judge(a, &good, &found));
    weft_accumulator_destroy(&a);
}

static void accumulator_states(void)
{
    weft_accumulator *a = NULL, *b = NULL;
    struct weft_accumulator_params buffer = usual_accumulator;
    static const unsigned char nonsense[200];
    void *state = NULL;
    size_t size = 0;
    buffer.method = WEFT_ACCUMULATE_BUFFER;
    TRUE(weft_accumulator_create(&usual_accumulator, &a) == WEFT_OK);
    TRUE(weft_accumulator_create(&buffer, &b) == WEFT_OK);
    REFUSED(weft_accumulator_join(a, a));
    REFUSED(weft_accumulator_join(a, b));
    REFUSED(weft_accumulator_join(b, a));
    REFUSED(weft_accumulator_join(a, NULL));
    REFUSED(weft_accumulator_load(a, NULL, 0));
    REFUSED(weft_accumulator_load(a, nonsense, 0));
    REFUSED(weft_accumulator_load(a, nonsense, sizeof nonsense));
    TRUE(weft_accumulator_save(a, &state, &size) == WEFT_OK);
    REFUSED(weft_accumulator_load(b, state, size));
    TRUE(weft_accumulator_load(a, state, size) == WEFT_OK);
    free(state);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&b);
}

static enum weft_result make_tree(const struct weft_tree_params *p)
{
    weft_tree *tree = NULL;
    const enum weft_result res = weft_tree_create(p, &tree);
    weft_tree_destroy(&tree);
    return res;
}

static void trees(void)
{
    struct weft_tree_params good = {.leaf_count = 3, .log = &logger};
    const struct weft_tree_source nothing = {.fill = NULL};
    uint16_t code;
    weft_tree *tree = NULL;
    ANY_INT(good, leaf_count, make_tree(&p));
    ANY_INT(good, branching, make_tree(&p));
    ANY_INT(good, level_branching[0], make_tree(&p));
    ANY_INT(good, level_branching[15], make_tree(&p));
    static const uint32_t weights[3] = {0, UINT32_MAX, UINT32_MAX};
    SET_REFUSED(good, weight, weights, make_tree(&p));
    static const double errors_lsb[3] = {NAN, INFINITY, -1.0};
    SURVIVED(make_tree(
        &(struct weft_tree_params){.leaf_count = 3, .leaf_error_lsb = errors_lsb, .log = &logger}));
    TRUE(weft_tree_create(&good, &tree) == WEFT_OK);
    TRUE(weft_tree_get_info(tree)->leaf_count == 3);
    REFUSED(weft_tree_run_codes(tree, &nothing, 1, &code));
    weft_tree_destroy(&tree);
    weft_tree_destroy(NULL);
}

const struct caller_case callers_accumulate[] = {
    {accum_buffers,
     {F(accum_buffer_create), F(accum_buffer_destroy), F(accum_buffer_load), F(accum_buffer_accum),
      F(accum_buffer_add), F(accum_buffer_mult), F(accum_buffer_return), F(accum_buffer_read)}},
    {accumulators, {F(accumulator_create), F(accumulator_destroy)}},
    {accumulations,
     {F(accumulator_add), F(accumulator_current), F(accumulator_current_texture),
      F(accumulator_finish), F(accumulator_get_report)}},
    {accumulator_judgements, {F(accumulator_judge)}},
    {accumulator_states, {F(accumulator_save), F(accumulator_load), F(accumulator_join)}},
    {trees, {F(tree_create), F(tree_destroy), F(tree_get_info), F(tree_run_codes)}},
    {jitters,
     {F(jitter_create), F(jitter_clear), F(jitter_find), F(jitter_parse),
      F(jitter_radical_inverse)}},
    {discrepancies, {F(discrepancy_compute)}},
    {edges, {F(edge_square), F(edge_disc), F(edge_kernel)}},
    {frame_weights, {F(weights_even), F(weights_normalise), F(weights_kernel)}},
    {shutters,
     {F(shutter_parse), F(shutter_light), F(shutter_share), F(shutter_weights),
      F(frames_for_motion), F(frames_for_circle), F(frames_for_penumbra)}},
    {cameras, {F(camera_compute), F(camera_move_to), F(camera_circle)}},
    {0},
};
