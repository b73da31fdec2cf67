// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void simple_slices(void)
{
    static float pixels[64 * 64];
    weft_volume *v = volume();
    struct weft_slice_file_params good = {.width = 8, .height = 8, .log = &logger};
    struct weft_slice_file_params plane = {
        .u = {1, 0, 0}, .v = {0, 1, 0}, .width = 8, .log = &logger};
#define CALL weft_slice_volume(v, &p, pixels)
    BAD_ENUM(good, space, CALL);
    BAD_ENUM(good, cpu.instructions, CALL);
    SET_REFUSED(good, kernel, "", CALL);
    SET_REFUSED(good, grid, "density", CALL);
    SET_REFUSED(good, axis, (char)-1, CALL);
    SET_REFUSED(good, width, INT_MIN, CALL);
    SET_REFUSED(good, height, INT_MAX, CALL);
    SET_REFUSED(good, cpu.threads, INT_MAX, CALL);
    ANY_INT(good, memory_bytes, CALL);
    for (int a = 0; a < 3; a++) {
        ANY_NUMBER(plane, origin[a], CALL);
        ANY_NUMBER(plane, u[a], CALL);
        ANY_NUMBER(plane, v[a], CALL);
    }
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        SURVIVED(weft_slice_volume(
            v, &(struct weft_slice_file_params){.at = &numbers[i], .width = 8, .log = &logger},
            pixels));
#undef CALL
#define CALL weft_slice_file("/nowhere/at/all.vdb", &p, pixels)
    SET_REFUSED(good, kernel, "linear", CALL);
    SET_REFUSED(good, grid, "", CALL);
#undef CALL
    REFUSED(weft_slice_file(NULL, &good, pixels));
    REFUSED(weft_slice_volume(NULL, &good, pixels));
    REFUSED(weft_slice_volume(v, &good, NULL));
    weft_volume_destroy(&v);
}

static void simple_points(void)
{
    weft_volume *v = volume();
    struct weft_sample_params good = {.log = &logger};
    double position[WEFT_COUNT(numbers)][3];
    float value[WEFT_COUNT(numbers)], gradient[WEFT_COUNT(numbers)][3];
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        position[i][0] = position[i][1] = position[i][2] = numbers[i];
#define CALL weft_sample(v, &p, WEFT_COUNT(numbers), position, value, gradient)
    BAD_ENUM(good, space, CALL);
    BAD_ENUM(good, cpu.instructions, CALL);
    SET_REFUSED(good, kernel, "no kernel", CALL);
    SET_REFUSED(good, kernel, "nearest", CALL);
    SET_REFUSED(good, grid, "density", CALL);
    SET_REFUSED(good, cpu.threads, INT_MIN, CALL);
    SURVIVED(weft_sample(v, &good, WEFT_COUNT(numbers), position, value, gradient));
    TRUE(isnan(value[0]) && isnan(gradient[0][2]));
#undef CALL
    REFUSED(weft_sample(NULL, &good, 1, position, value, NULL));
    REFUSED(weft_sample(v, &good, 1, NULL, value, NULL));
    REFUSED(weft_sample(v, &good, 1, position, NULL, NULL));
    // Refused for its memory before a position is read.
    REFUSED(weft_sample(v, &good, SIZE_MAX, position, value, gradient));
    REFUSED(weft_sample_file("/nowhere/at/all.vdb", &good, 1, position, value, NULL));
    REFUSED(weft_sample_file(NULL, &good, 1, position, value, NULL));
    weft_volume_destroy(&v);
}

const struct caller_case callers_simple[] = {
    {simple_slices, {F(slice_file), F(slice_volume)}},
    {simple_points, {F(sample), F(sample_file)}},
    {NULL, {NULL}},
};
