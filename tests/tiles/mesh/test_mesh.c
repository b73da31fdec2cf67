// SPDX-License-Identifier: BSD-3-Clause
// Meshes of files against what was written into them.
#include "tiles/mesh/mesh.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/files.h"
#include "tests/tiles/mesh/meshes.h"

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

// ---- OBJ ----------------------------------------------------------------------------------------

static const char cube_vertices[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                    "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";

static const struct weft_mesh_material *material_of(const struct weft_mesh *mesh, size_t part)
{
    return &mesh->materials[mesh->parts[part].material];
}

static void assert_vector(const float *actual, double x, double y, double z, double tolerance)
{
    assert_near(actual[0], x, tolerance, "x");
    assert_near(actual[1], y, tolerance, "y");
    assert_near(actual[2], z, tolerance, "z");
}

static double volume_of(const struct weft_mesh *mesh)
{
    double volume = 0.0;
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        const float *a = mesh->vertices[mesh->indices[i]].position,
                    *b = mesh->vertices[mesh->indices[i + 1]].position,
                    *c = mesh->vertices[mesh->indices[i + 2]].position;
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0])) /
                  6.0;
    }
    return volume;
}

// Names with spaces (of objects assimp takes the first word), indices from the end, a line that
// goes on, comments, space in front, two materials, and no line feed at the end.
static void test_obj(void **state)
{
    (void)state;
    char text[1200];
    snprintf(text, sizeof text,
             "# a cube\nmtllib cube.mtl\n  o my cube\n%susemtl red\nf 4 3 2 1 # below\n"
             "\tf -4 -3 -2 -1\r\nusemtl two words\nf 1 2 \\\n6 5\nf 2 3 7 6\nl 1 2 3\np 4\n"
             "f 3 4 8 7\nf 4 1 5 8",
             cube_vertices);
    write_text("cube.obj", text);
    write_text("cube.mtl", "newmtl red\n Kd 0.5 0.25 1\nKe 2 0 0\nmap_Kd x.png\n"
                           "newmtl two words\nKd 0 3 0");
    struct weft_mesh mesh = load_good("cube.obj");
    assert_int_equal(mesh.vertex_count, 8);
    assert_int_equal(mesh.index_count, 36);
    assert_int_equal(mesh.part_count, 2);
    assert_int_equal(mesh.material_count, 2);
    assert_int_equal(mesh.parts[0].index_count, 12);
    assert_string_equal(mesh.parts[0].name, "my");
    assert_string_equal(mesh.parts[1].name, "my");
    assert_string_equal(material_of(&mesh, 0)->name, "red");
    assert_vector(material_of(&mesh, 0)->reflectance, 0.5, 0.25, 1.0, 1e-7);
    assert_vector(material_of(&mesh, 0)->emission, 2.0, 0.0, 0.0, 1e-7);
    assert_string_equal(material_of(&mesh, 1)->name, "two words");
    assert_vector(material_of(&mesh, 1)->reflectance, 0.0, 1.0, 0.0, 1e-7);
    assert_vector(mesh.low, 0, 0, 0, 0);
    assert_vector(mesh.high, 1, 1, 1, 0);
    assert_near(volume_of(&mesh), 1.0, 1e-12, "volume");
    assert_string_equal(mesh.dropped, "2 lines, 1 point, 1 texture");
    assert_string_equal(test_warning, "");
    // Each corner has three right angles, whatever the diagonals: 1, 1, 1 from the middle.
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        const struct weft_mesh_vertex *v = &mesh.vertices[i];
        const double n = 1.0 / sqrt(3.0);
        assert_vector(v->normal, v->position[0] > 0.5f ? n : -n, v->position[1] > 0.5f ? n : -n,
                      v->position[2] > 0.5f ? n : -n, 1e-6);
        assert_vector(v->colour, 1, 1, 1, 0);
    }
    weft_mesh_clear(&mesh);
}

// Texture coordinates, normals of any length, colours in sRGB, weights.
static void test_obj_attributes(void **state)
{
    (void)state;
    write_text("a.obj",
               "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nvt 0.25 0.75\nvt 1 0\nvt 0 1 0.5\n"
               "vn 0 0 -3\nvn 3 0 4\ng first group\nf 1/1/1 2/2/2 3/3/1\n");
    struct weft_mesh mesh = load_good("a.obj");
    assert_int_equal(mesh.vertex_count, 3);
    assert_string_equal(mesh.parts[0].name, "first group");
    assert_vector(mesh.vertices[0].normal, 0, 0, -1, 1e-7);
    assert_vector(mesh.vertices[1].normal, 0.6, 0, 0.8, 1e-7);
    assert_near(mesh.vertices[0].uv[0], 0.25, 1e-7, "u");
    assert_near(mesh.vertices[0].uv[1], 0.75, 1e-7, "v");
    assert_near(mesh.vertices[1].uv[0], 1.0, 1e-7, "u");
    // IEC 61966-2-1: 0.5 stands for 0.21404114.
    assert_vector(mesh.vertices[0].colour, 1.0, 0.21404114, 0.0, 1e-6);
    assert_vector(mesh.vertices[1].colour, 0.0, 0.0, 0.0, 0.0);
    assert_vector(mesh.vertices[2].colour, 1.0, 1.0, 1.0, 0.0);
    assert_vector(mesh.materials[0].reflectance, 0.7, 0.7, 0.7, 1e-7);
    weft_mesh_clear(&mesh);

    write_text("b.obj", "v 2 4 6 2\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
    mesh = load_good("b.obj");
    assert_vector(mesh.vertices[0].position, 1, 2, 3, 0);
    assert_string_equal(mesh.parts[0].name, "part 1");
    weft_mesh_clear(&mesh);
}

static void test_obj_without_materials(void **state)
{
    (void)state;
    write_text("a.obj", "mtllib nowhere.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gone\nf 1 2 3\n");
    struct weft_mesh mesh = load_good("a.obj");
    assert_non_null(strstr(test_warning, "'nowhere.mtl', which is not there"));
    assert_string_equal(mesh.materials[0].name, "gone");
    assert_vector(mesh.materials[0].reflectance, 0.7, 0.7, 0.7, 1e-7);
    weft_mesh_clear(&mesh);
    // In a folder below; a material that the library lacks has assimp's grey.
    assert_int_equal(mkdir(test_path("below"), 0700), 0);
    write_text("below/b.mtl", "newmtl there\nKd 0 0.5 0\n");
    write_text("a.obj", "mtllib below/b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl there\nf 1 2 3\n"
                        "usemtl gone\nf 3 2 1\n");
    mesh = load_good("a.obj");
    assert_vector(material_of(&mesh, 0)->reflectance, 0.0, 0.5, 0.0, 1e-7);
    assert_vector(material_of(&mesh, 1)->reflectance, 0.6, 0.6, 0.6, 1e-7);
    assert_string_equal(test_warning, "");
    weft_mesh_clear(&mesh);
    remove(test_path("below/b.mtl"));
}

// A concave polygon keeps its area, and nothing lies outside of it.
static void test_obj_concave(void **state)
{
    (void)state;
    write_text("l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n");
    struct weft_mesh mesh = load_good("l.obj");
    double area = 0.0;
    assert_int_equal(mesh.index_count, 12);
    for (size_t i = 0; i < mesh.index_count; i += 3) {
        const float *a = mesh.vertices[mesh.indices[i]].position,
                    *b = mesh.vertices[mesh.indices[i + 1]].position,
                    *c = mesh.vertices[mesh.indices[i + 2]].position;
        const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(twice > 0.0);
        area += twice / 2.0;
        const float x = (a[0] + b[0] + c[0]) / 3.0f, y = (a[1] + b[1] + c[1]) / 3.0f;
        assert_true(x < 1.0f || y < 1.0f);
    }
    assert_near(area, 3.0, 1e-12, "area");
    weft_mesh_clear(&mesh);
}

// Polygons around a point, of 3 to 60 corners at any distance, in planes of any direction: all
// triangles are turned as the polygon is, and have its area together.
static void test_obj_polygons(void **state)
{
    (void)state;
    enum { COUNT = 58 };
    double areas[COUNT], normals[COUNT][3];
    char *text = malloc(1 << 20), *at = text;
    uint64_t random = 1;
    assert_non_null(text);
    for (int k = 0; k < COUNT; k++) {
        const int corners = k + 3;
        const double a = 0.7 * k, b = 1.3 * k, pi = 3.14159265358979323846;
        const double u[3] = {cos(a), sin(a), 0}, v[3] = {-sin(a) * cos(b), cos(a) * cos(b), sin(b)};
        double x[64], y[64];
        areas[k] = 0.0;
        for (int c = 0; c < 3; c++)
            normals[k][c] = u[(c + 1) % 3] * v[(c + 2) % 3] - u[(c + 2) % 3] * v[(c + 1) % 3];
        at += sprintf(at, "g polygon %d\n", k);
        for (int i = 0; i < corners; i++) {
            random = random * UINT64_C(6364136223846793005) + 1442695040888963407u;
            const double r = 0.1 + (double)(random >> 40) / (1 << 24), t = 2.0 * pi * i / corners;
            x[i] = r * cos(t);
            y[i] = r * sin(t);
            at += sprintf(at, "v %.9g %.9g %.9g\n", x[i] * u[0] + y[i] * v[0],
                          x[i] * u[1] + y[i] * v[1], x[i] * u[2] + y[i] * v[2]);
        }
        at += sprintf(at, "f");
        for (int i = 0; i < corners; i++) {
            const int n = (i + 1) % corners;
            areas[k] += (x[i] * y[n] - x[n] * y[i]) / 2.0;
            at += sprintf(at, " %d", i - corners);
        }
        at += sprintf(at, "\n");
    }
    test_write_file(test_path("a.obj"), text, (size_t)(at - text));
    free(text);
    struct weft_mesh mesh = load_good("a.obj");
    assert_int_equal(mesh.part_count, COUNT);
    for (int k = 0; k < COUNT; k++) {
        const struct weft_mesh_part *part = &mesh.parts[k];
        double area = 0.0;
        assert_int_equal(part->index_count, 3 * (k + 1));
        for (uint32_t i = 0; i < part->index_count; i += 3) {
            const uint32_t *index = mesh.indices + part->first_index + i;
            const float *p = mesh.vertices[index[0]].position,
                        *q = mesh.vertices[index[1]].position,
                        *r = mesh.vertices[index[2]].position;
            double twice = 0.0;
            for (int c = 0; c < 3; c++) {
                const int d = (c + 1) % 3, e = (c + 2) % 3;
                twice +=
                    normals[k][c] * (((double)q[d] - (double)p[d]) * ((double)r[e] - (double)p[e]) -
                                     ((double)q[e] - (double)p[e]) * ((double)r[d] - (double)p[d]));
            }
            assert_true(twice > -1e-6); // positions are rounded to float
            area += twice / 2.0;
        }
        assert_near(area, areas[k], 1e-5, "area");
    }
    weft_mesh_clear(&mesh);
}

// ---- PLY ----------------------------------------------------------------------------------------

// A square of two colours, whose first coordinate is 1e-33-like bytes: a line feed comes first.
static const char ply_header[] = "ply\nformat %s 1.0\ncomment TextureFile a.png\nelement vertex 4\n"
                                 "comment between\nproperty %s x\nproperty float y\n"
                                 "property float z\nproperty uchar red\nproperty uchar green\n"
                                 "property uchar blue\nproperty short other\nelement face 2\n"
                                 "property list uchar int vertex_indices\nelement edge 1\n"
                                 "property int vertex1\nproperty int vertex2\nend_header\n";

static size_t put(char *out, size_t at, const void *data, size_t size, bool big)
{
    for (size_t i = 0; i < size; i++)
        out[at + i] = ((const char *)data)[big ? size - 1 - i : i];
    return at + size;
}

static size_t ply_bytes(char *out, size_t room, bool big, float first)
{
    static const float xy[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const unsigned char colours[4][3] = {
        {255, 0, 0}, {0, 188, 0}, {0, 0, 0}, {255, 255, 255}};
    static const int edge[2] = {0, 2};
    const short other = -7;
    size_t at = (size_t)snprintf(out, room, ply_header,
                                 big ? "binary_big_endian" : "binary_little_endian", "float");
    for (int i = 0; i < 4; i++) {
        const float p[3] = {i ? xy[i][0] : first, xy[i][1], 0.0f};
        for (int c = 0; c < 3; c++)
            at = put(out, at, &p[c], 4, big);
        memcpy(out + at, colours[i], 3);
        at = put(out, at + 3, &other, 2, big);
    }
    for (int f = 0; f < 2; f++) {
        static const int corners[2][4] = {{0, 1, 2, -1}, {0, 2, 3, -1}};
        out[at++] = 3;
        for (int i = 0; i < 3; i++)
            at = put(out, at, &corners[f][i], 4, big);
    }
    for (int i = 0; i < 2; i++)
        at = put(out, at, &edge[i], 4, big);
    return at;
}

static void check_square(const char *name, double first)
{
    struct weft_mesh mesh = load_good(name);
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.index_count, 6);
    assert_int_equal(mesh.part_count, 1);
    assert_vector(mesh.vertices[0].position, first, 0, 0, 1e-30);
    assert_vector(mesh.vertices[2].position, 1, 1, 0, 0);
    assert_vector(mesh.vertices[0].colour, 1, 0, 0, 1e-6);
    // ((188 / 255 + 0.055) / 1.055)^2.4
    assert_vector(mesh.vertices[1].colour, 0, pow((188.0 / 255.0 + 0.055) / 1.055, 2.4), 0, 1e-6);
    for (int i = 0; i < 4; i++)
        assert_vector(mesh.vertices[i].normal, 0, 0, 1, 1e-7);
    assert_vector(mesh.materials[0].reflectance, 0.7, 0.7, 0.7, 1e-7);
    weft_mesh_clear(&mesh);
}

static void test_ply(void **state)
{
    (void)state;
    char data[2000];
    size_t size;
    const float small = 1e-33f;
    uint32_t feed = 0x0a0a0a0a;
    float first;
    for (int big = 0; big < 2; big++)
        for (int feeds = 0; feeds < 2; feeds++) {
            memcpy(&first, feeds ? (const void *)&feed : (const void *)&small, 4);
            size = ply_bytes(data, sizeof data, big, first);
            test_write_file(test_path("a.PLY"), data, size);
            check_square("a.PLY", (double)first);
        }
    size = (size_t)snprintf(data, sizeof data, ply_header, "ascii", "double");
    snprintf(data + size, sizeof data - size,
             "0 0 0 255 0 0 1\n1 0 0 0 188 0 1\n1 1 0 0 0 0 1\n0 1 0 255 255 255 1\n"
             "3 0 1 2\n3 0 2 3\n0 2");
    write_text("a.ply", data);
    check_square("a.ply", 0.0);
}

static void test_ply_attributes(void **state)
{
    (void)state;
    write_text("a.ply", "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\n"
                        "property float y\r\nproperty float z\r\nproperty float nx\r\n"
                        "property float ny\r\nproperty float nz\r\nproperty float s\r\n"
                        "property float t\r\nelement face 2\r\n"
                        "property list int int vertex_indices\r\nend_header\r\n"
                        "0 0 0 1 0 0 0 0\r\n1 0 0 1 0 0 1 0\r\n0 1 0 1 0 0 0 1\r\n"
                        "1 1 0 1 0 0 1 1\r\n4 0 1 3 2\r\n2 0 1\r\n");
    struct weft_mesh mesh = load_good("a.ply");
    double area = 0.0;
    assert_int_equal(mesh.index_count, 6);
    for (int t = 0; t < 6; t += 3) {
        const float *a = mesh.vertices[mesh.indices[t]].position,
                    *b = mesh.vertices[mesh.indices[t + 1]].position,
                    *c = mesh.vertices[mesh.indices[t + 2]].position;
        area += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }
    assert_near(area, 2.0, 0, "twice the area");
    for (int i = 0; i < 6; i++) {
        const struct weft_mesh_vertex *v = &mesh.vertices[mesh.indices[i]];
        assert_vector(v->normal, 1, 0, 0, 0);
        assert_near(v->uv[0], v->position[0], 0, "u");
        assert_near(v->uv[1], v->position[1], 0, "v");
    }
    assert_string_equal(mesh.dropped, "1 line");
    weft_mesh_clear(&mesh);
}

// ---- glTF ---------------------------------------------------------------------------------------

// Moved, doubled in size; below it once more, mirrored.
static const char gltf_nodes[] =
    "{\"mesh\":0,\"translation\":[1,2,3],\"scale\":[2,2,2],\"children\":[1]},"
    "{\"mesh\":0,\"name\":\"below\",\"matrix\":[-1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1]}";

static void check_triangles(const char *name)
{
    struct weft_mesh mesh = load_good(name);
    static const float expected[6][3] = {{1, 2, 3},  {3, 2, 3},  {1, 4, 3},
                                         {11, 2, 3}, {11, 4, 3}, {9, 2, 3}};
    assert_int_equal(mesh.index_count, 6);
    for (int i = 0; i < 6; i++) {
        const struct weft_mesh_vertex *v = &mesh.vertices[mesh.indices[i]];
        assert_vector(v->position, expected[i][0], expected[i][1], expected[i][2], 1e-6);
        assert_vector(v->normal, 0, 0, 1, 1e-7);
    }
    assert_int_equal(mesh.part_count, 2);
    assert_string_equal(mesh.parts[0].name, "part 1");
    assert_string_equal(mesh.parts[1].name, "below");
    assert_int_equal(mesh.material_count, 1);
    assert_string_equal(mesh.materials[0].name, "clay");
    assert_vector(mesh.materials[0].reflectance, 0.5, 0.25, 0.125, 1e-7);
    assert_vector(mesh.materials[0].emission, 1, 0.5, 0, 1e-6);
    assert_string_equal(mesh.dropped, "1 emissive strength");
    weft_mesh_clear(&mesh);
}

static void test_gltf(void **state)
{
    (void)state;
    char text[4096], buffer[400], bytes[GLTF_BYTES], glb[4096];
    gltf_bytes(bytes);
    test_write_file(test_path("a b.bin"), bytes, sizeof bytes);
    gltf_text(gltf_nodes, "{\"byteLength\":44,\"uri\":\"a%20b.bin\"}", text, sizeof text);
    write_text("file.gltf", text);
    check_triangles("file.gltf");
    data_buffer(buffer, sizeof buffer);
    gltf_text(gltf_nodes, buffer, text, sizeof text);
    write_text("data.gltf", text);
    check_triangles("data.gltf");
    test_write_file(test_path("a.glb"), glb, glb_bytes(gltf_nodes, glb, sizeof glb));
    check_triangles("a.glb");
}

// Interleaved, colours of bytes that stand for fractions; another one sparse; and what is left out.
static void test_gltf_accessors(void **state)
{
    (void)state;
    unsigned char data[3 * 24 + 4 + 12] = {0};
    for (int i = 0; i < 3; i++) {
        const float uv[2] = {1, 0};
        memcpy(data + 24 * i, gltf_positions + 3 * i, 12);
        memcpy(data + 24 * i + 12, uv, 8);
        memcpy(data + 24 * i + 20, "\xff\x33\0\xff", 4);
    }
    data[72] = 2; // the third vertex
    const float there[3] = {0, 0, 7};
    memcpy(data + 76, there, sizeof there);
    char text[200], all[4096];
    base64((const char *)data, sizeof data, text);
    snprintf(
        all, sizeof all,
        GLTF_START
        "\"nodes\":[{\"mesh\":0,\"name\":\"a\",\"camera\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,"
        "\"COLOR_0\":2}},{\"attributes\":{\"POSITION\":3}},{\"mode\":3,\"attributes\":{"
        "\"POSITION\":0}},"
        "{\"mode\":0,\"attributes\":{\"POSITION\":0}}]}],\"cameras\":[{\"type\":\"perspective\","
        "\"perspective\":{\"yfov\":1,\"znear\":1}}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC2\"},{\"bufferView\":0,\"byteOffset\":20,"
        "\"componentType\":5121,\"normalized\":true,\"count\":3,\"type\":\"VEC4\"},"
        "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5121},"
        "\"values\":{\"bufferView\":2}}}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":72,\"byteStride\":24},"
        "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":1},"
        "{\"buffer\":0,\"byteOffset\":76,\"byteLength\":12}],"
        "\"buffers\":[{\"byteLength\":88,\"uri\":\"data:;base64,%s\"}]}",
        text);
    write_text("a.gltf", all);
    struct weft_mesh mesh = load_good("a.gltf");
    assert_int_equal(mesh.part_count, 2);
    assert_vector(mesh.vertices[mesh.indices[2]].position, 0, 1, 0, 0);
    assert_vector(mesh.vertices[mesh.indices[4]].position, 0, 0, 0, 0);
    assert_vector(mesh.vertices[mesh.indices[5]].position, 0, 0, 7, 0);
    assert_vector(mesh.vertices[mesh.indices[1]].position, 1, 0, 0, 0);
    assert_vector(mesh.vertices[0].colour, 1, 0.2, 0, 1e-6); // linear as it is
    assert_near(mesh.vertices[0].uv[0], 1.0, 1e-7, "u");
    assert_near(mesh.vertices[0].uv[1], 1.0, 1e-7, "v"); // up
    assert_vector(mesh.materials[0].reflectance, 1, 1, 1, 0);
    assert_string_equal(mesh.dropped, "2 lines, 3 points, 1 camera");
    weft_mesh_clear(&mesh);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_data_files),
        IN_FOLDER(test_obj),
        IN_FOLDER(test_obj_attributes),
        IN_FOLDER(test_obj_without_materials),
        IN_FOLDER(test_obj_concave),
        IN_FOLDER(test_obj_polygons),
        IN_FOLDER(test_ply),
        IN_FOLDER(test_ply_attributes),
        IN_FOLDER(test_gltf),
        IN_FOLDER(test_gltf_accessors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
