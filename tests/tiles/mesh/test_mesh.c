// SPDX-License-Identifier: BSD-3-Clause
// Meshes of files against what was written into them.
#include "tiles/mesh/mesh.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/files.h"

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, test_enter_folder, test_leave_folder)

// ---- files of the data folder -------------------------------------------------------------------

// What an OBJ file without other polygons than its lines say has.
struct obj_counts {
    size_t triangles;
    double low[3], high[3];
};

static struct obj_counts count_obj(const char *path)
{
    struct obj_counts counts = {
        0, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    char *text = test_read_file(path, NULL), *save = NULL;
    for (char *line = strtok_r(text, "\n", &save); line; line = strtok_r(NULL, "\n", &save)) {
        double p[3];
        char *words = NULL;
        if (sscanf(line, "v %lf %lf %lf", &p[0], &p[1], &p[2]) == 3)
            for (int c = 0; c < 3; c++) {
                counts.low[c] = fmin(counts.low[c], p[c]);
                counts.high[c] = fmax(counts.high[c], p[c]);
            }
        if (strncmp(line, "f ", 2))
            continue;
        size_t corners = 0;
        for (char *word = strtok_r(line + 2, " \r", &words); word;
             word = strtok_r(NULL, " \r", &words))
            corners++;
        counts.triangles += corners - 2;
    }
    free(text);
    return counts;
}

static void test_data_files(void **state)
{
    (void)state;
    static const char *const names[] = {"spot", "suzanne", "teapot"};
    int read = 0;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        char path[600];
        struct weft_mesh mesh;
        snprintf(path, sizeof path, "%s/mesh/%s.obj", WEFT_TEST_DATA, names[i]);
        if (access(path, R_OK)) {
            print_message("[  SKIPPED ] %s is not here\n", path);
            continue;
        }
        const struct obj_counts counts = count_obj(path);
        assert_int_equal(weft_mesh_load(weft_mesh_params(.path = path, .log = &test_log), &mesh),
                         WEFT_OK);
        assert_int_equal(mesh.index_count, 3 * counts.triangles);
        for (int c = 0; c < 3; c++) {
            assert_near(mesh.low[c], counts.low[c], 1e-6, "low");
            assert_near(mesh.high[c], counts.high[c], 1e-6, "high");
        }
        weft_mesh_clear(&mesh);
        assert_null(mesh.memory);
        read++;
    }
    if (!read)
        skip();
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_data_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
