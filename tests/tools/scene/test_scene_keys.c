// SPDX-License-Identifier: BSD-3-Clause
// Files of keyframes: what good ones mean, and one line for every way to write a bad one.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "tools/scene/build.h"

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static void make(const char *name, struct scene *out)
{
    const struct scene_params params = {.name = name, .size = {64, 64}, .log = &log_to_stderr};
    assert_int_equal(scene_make(&params, out), WEFT_OK);
}

// Writes the bytes into a file, reads it, and removes it.
static enum weft_result read_bytes(struct scene *scene, const char *bytes, size_t length)
{
    char path[] = "/tmp/weft_keys_XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, bytes, length), (ssize_t)length);
    close(file);
    last = (struct message){0};
    const enum weft_result res = scene_read_keys(&remember_log, path, scene);
    unlink(path);
    return res;
}

static enum weft_result read_text(struct scene *scene, const char *text)
{
    return read_bytes(scene, text, strlen(text));
}

static const struct scene_object *find_object(const struct scene *scene, const char *name)
{
    for (int i = 0; i < scene->object_count; i++)
        if (strcmp(scene->objects[i].name, name) == 0)
            return &scene->objects[i];
    fail_msg("no object %s", name);
    return NULL;
}

static void test_names_times_positions_rotations_scales(void **state)
{
    (void)state;
    struct scene s;
    make("plane", &s);
    assert_int_equal(read_text(&s, "\xef\xbb\xbf# a comment\n"
                                   "\n"
                                   "  \"ball 1\" 0 1,2,3\r\n"
                                   "ground -1.5 0,0,0 # rests\n"
                                   "\"ball 1\"\t0.5 -1e1,.5,+3  0,0,2,90\n"
                                   "camera 0 0,0,1 1,0,0,0\n"
                                   "\"ball 1\" 1 0,0,0 1,0,0,180 2.5"),
                     WEFT_OK);
    assert_int_equal(last.count, 0);
    const struct scene_path *path = &find_object(&s, "ball 1")->path;
    assert_int_equal(path->count, 3);
    const struct scene_key expected[3] = {
        {0.0, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0, 1.0}, 1.0},
        {0.5, {-10.0, 0.5, 3.0}, {0.0, 0.0, M_SQRT1_2, M_SQRT1_2}, 1.0},
        {1.0, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}, 2.5}};
    for (int i = 0; i < 3; i++) {
        const struct scene_key *key = &path->keys[i];
        assert_near(key->time, expected[i].time, 0.0, "a time");
        assert_near(key->scale, expected[i].scale, 0.0, "a scale");
        for (int k = 0; k < 3; k++)
            assert_near(key->position[k], expected[i].position[k], 0.0, "a position");
        for (int k = 0; k < 4; k++)
            assert_near(key->rotation[k], expected[i].rotation[k], 1e-15, "a rotation");
    }
    assert_int_equal(find_object(&s, "ground")->path.count, 1);
    assert_int_equal(find_object(&s, "ball 2")->path.count, 0);
    assert_int_equal(s.camera_path.count, 1);
    scene_clear(&s);
}

// A star stands for those that are not named, and paths are replaced.
static void test_star_and_replacing(void **state)
{
    (void)state;
    struct scene s;
    make("moving", &s);
    const int rest = find_object(&s, "ball")->path.count;
    assert_int_equal(rest, 9);
    assert_int_equal(read_text(&s, "cross 0 1,1,1\ncross 1 2,2,2\n"), WEFT_OK);
    assert_int_equal(find_object(&s, "cross")->path.count, 2);
    assert_int_equal(find_object(&s, "ball")->path.count, rest);
    assert_int_equal(find_object(&s, "post")->path.count, 0);
    assert_int_equal(read_text(&s, "* 0 7,0,0\nbar 0 0,9,0\nbar 1 0,9,0\n"), WEFT_OK);
    int ran = 0;
    for (int i = 0; i < s.object_count; i++, ran++) {
        const bool named = strcmp(s.objects[i].name, "bar") == 0;
        assert_int_equal(s.objects[i].path.count, named ? 2 : 1);
        assert_near(s.objects[i].path.keys[0].position[named], named ? 9.0 : 7.0, 0.0, "a place");
    }
    assert_int_equal(ran, 5);
    assert_int_equal(s.camera_path.count, 0);
    scene_clear(&s);
}

// The box is that of the whole way.
static void test_box_follows(void **state)
{
    (void)state;
    struct scene s;
    make("cube", &s);
    assert_int_equal(read_text(&s, "cube 0 -2,0,0\ncube 1 5,1,0 0,0,1,0 2\n"), WEFT_OK);
    const double low[3] = {-2.0, 0.0, 0.0}, high[3] = {7.0, 3.0, 2.0};
    for (int i = 0; i < 3; i++) {
        assert_near(s.low[i], low[i], 1e-12, "low");
        assert_near(s.high[i], high[i], 1e-12, "high");
    }
    scene_clear(&s);
}

static void test_bad_lines(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        enum weft_result result;
        const char *line, *says;
    } cases[] = {
        {"", WEFT_ERR_FORMAT, "line 0", "without a key"},
        {"# nothing\n\n", WEFT_ERR_FORMAT, "line 2", "without a key"},
        {"cube 0 0,0,0\nsphere 0 0,0,0\n", WEFT_ERR_ARGUMENT, "line 2", "there are cube, and"},
        {"cu\x1b[1mbe 0 0,0,0\n", WEFT_ERR_ARGUMENT, "line 1", "cu?[1mbe is no object"},
        {"\"cube 0 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "quote"},
        {"\"\" 0 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no name"},
        {"\n\ncube\n", WEFT_ERR_FORMAT, "line 3", "no time"},
        {"cube x 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube nan 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube inf 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube 0x1 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube 1e999 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube 1e31 0,0,0\n", WEFT_ERR_FORMAT, "line 1", "no time"},
        {"cube 0\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1,2\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1,2,3,4\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1, 2,3\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1,2,3e\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1;2;3\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 1,2,-1e31\n", WEFT_ERR_FORMAT, "line 1", "no position"},
        {"cube 0 0,0,0 1,0,0\n", WEFT_ERR_FORMAT, "line 1", "rotation"},
        {"cube 0 0,0,0 90\n", WEFT_ERR_FORMAT, "line 1", "rotation"},
        {"cube 0 0,0,0 0,0,0,90\n", WEFT_ERR_FORMAT, "line 1", "axis has no length"},
        {"cube 0 0,0,0 0,0,1,90 0\n", WEFT_ERR_FORMAT, "line 1", "scale"},
        {"cube 0 0,0,0 0,0,1,90 -2\n", WEFT_ERR_FORMAT, "line 1", "scale"},
        {"cube 0 0,0,0 0,0,1,90 two\n", WEFT_ERR_FORMAT, "line 1", "scale"},
        {"cube 0 0,0,0 0,0,1,90 2 3\n", WEFT_ERR_FORMAT, "line 1", "more"},
        {"camera 0 0,0,0 0,0,1,90 2\n", WEFT_ERR_FORMAT, "line 1", "camera"},
        {"cube 0 0,0,0\ncube 0 1,0,0\n", WEFT_ERR_FORMAT, "line 2", "not later"},
        {"cube 0.5 0,0,0\ncamera 0.2 0,0,0\ncube 0.4 1,0,0\n", WEFT_ERR_FORMAT, "line 3",
         "not later"},
    };
    struct scene s;
    make("cube", &s);
    assert_int_equal(read_text(&s, "cube 0 3,0,0\ncamera 0 0,0,1\n"), WEFT_OK);
    struct scene before = s;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const enum weft_result res = read_text(&s, cases[i].text);
        if (res != cases[i].result || last.count != 1 || !strstr(last.text, cases[i].line) ||
            !strstr(last.text, cases[i].says))
            fail_msg("case %zu: result %d, %d lines, %s", i, res, last.count, last.text);
        assert_memory_equal(&s, &before, sizeof s);
        assert_near(s.objects[0].path.keys[0].position[0], 3.0, 0.0, "the path that was there");
    }
    scene_clear(&s);
}

static void test_limits_of_lines_and_keys(void **state)
{
    (void)state;
    struct scene s;
    make("cube", &s);
    // A line of 5,000 bytes, and one with a NUL byte.
    char *text = calloc(1, 5002);
    assert_non_null(text);
    memset(text, ' ', 5000);
    memcpy(text, "cube 0 0,0,0", 12);
    text[5000] = '\n';
    assert_int_equal(read_text(&s, text), WEFT_ERR_FORMAT);
    assert_non_null(strstr(last.text, "4096"));
    free(text);
    assert_int_equal(read_bytes(&s, "cube 0 0,0,0\0\ncube 1 0,0,0\n", 27), WEFT_ERR_FORMAT);
    assert_non_null(strstr(last.text, "NUL"));
    // As many keys as there may be, and one more.
    const size_t room = (SCENE_MAX_KEYS + 1) * 24;
    text = calloc(1, room);
    assert_non_null(text);
    size_t length = 0;
    for (int i = 0; i < SCENE_MAX_KEYS; i++)
        length += (size_t)snprintf(text + length, room - length, "cube %d %d,0,0\n", i, i);
    assert_int_equal(read_text(&s, text), WEFT_OK);
    assert_int_equal(s.objects[0].path.count, SCENE_MAX_KEYS);
    snprintf(text + length, room - length, "cube %d 0,0,0\n", SCENE_MAX_KEYS);
    assert_int_equal(read_text(&s, text), WEFT_ERR_LIMIT);
    assert_non_null(strstr(last.text, "4097"));
    assert_int_equal(s.objects[0].path.count, SCENE_MAX_KEYS);
    free(text);
    scene_clear(&s);
}

static void test_files_that_cannot_be_read(void **state)
{
    (void)state;
    struct scene s;
    make("cube", &s);
    last = (struct message){0};
    assert_int_equal(scene_read_keys(&remember_log, "/nowhere/keys", &s), WEFT_ERR_OPEN);
    assert_int_equal(last.count, 1);
    assert_non_null(strstr(last.text, "/nowhere/keys: No such file"));
    last = (struct message){0};
    assert_int_equal(scene_read_keys(&remember_log, "/tmp", &s), WEFT_ERR_OPEN);
    assert_int_equal(last.count, 1);
    assert_int_equal(scene_read_keys(NULL, "/nowhere/keys", &s), WEFT_ERR_OPEN);
    scene_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names_times_positions_rotations_scales),
        cmocka_unit_test(test_star_and_replacing),
        cmocka_unit_test(test_box_follows),
        cmocka_unit_test(test_bad_lines),
        cmocka_unit_test(test_limits_of_lines_and_keys),
        cmocka_unit_test(test_files_that_cannot_be_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
