// SPDX-License-Identifier: BSD-3-Clause
// Meshes that are damaged or mean harm: one line each, and nothing left behind.
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/resource.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/files.h"
#include "tests/tiles/mesh/meshes.h"

static enum weft_result load(const char *path, struct weft_limits limits, struct weft_mesh *mesh)
{
    test_forget();
    *test_warning = '\0';
    memset(mesh, 0xee, sizeof *mesh);
    return weft_mesh_load(weft_mesh_params(.path = path, .limits = limits, .log = &mesh_log), mesh);
}

// One line, which names the file and has a text in it; nothing is left.
static void assert_bad(const char *name, enum weft_result result, const char *text)
{
    static const struct weft_mesh none;
    struct weft_mesh mesh;
    const struct weft_limits limits = {.cpu_seconds = 20, .wall_seconds = 30};
    const enum weft_result res = load(test_path(name), limits, &mesh);
    if (res != result || test_errors != 1 || !strstr(test_message, name) ||
        !strstr(test_message, text))
        fail_msg("%s: %s instead of %s, %d lines, '%s' lacks '%s'", name, weft_result_text(res),
                 weft_result_text(result), test_errors, test_message, text);
    assert_null(strchr(test_message, '\n'));
    assert_memory_equal(&mesh, &none, sizeof mesh);
    assert_int_equal(count_children(), 0);
}

struct bad {
    const char *text;
    enum weft_result result;
    const char *message;
};

// ---- OBJ ----------------------------------------------------------------------------------------

#define V "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void test_obj(void **state)
{
    (void)state;
    static const struct bad cases[] = {
        {V "f 1 2 4\n", WEFT_ERR_FORMAT, "face 1 has the index 4 of 3 vertices"},
        {V "f 1 2 -4\n", WEFT_ERR_FORMAT, "face 1 has the index -4 of 3 vertices"},
        {V "f 0 1 2\n", WEFT_ERR_FORMAT, "face 1 has the index 0 of 3 vertices"},
        {V "f 1 2 99999999999999999999\n", WEFT_ERR_FORMAT, "of 3 vertices"},
        {V "f 1/1 2/1 3/1\n", WEFT_ERR_FORMAT, "the index 1 of 0 texture coordinates"},
        {V "f 1//1 2//1 3//1\n", WEFT_ERR_FORMAT, "the index 1 of 0 normals"},
        {V "vn 0 0 1\nf 1//1 2//1 3//2\n", WEFT_ERR_FORMAT, "the index 2 of 1 normals"},
        {V "vt 0 0\nf 1/1 2/1 3/-2\n", WEFT_ERR_FORMAT, "the index -2 of 1 texture"},
        {V "vn 0 0 1\nf 1//1 2 3\n", WEFT_ERR_FORMAT, "not all corners"},
        {V "f 1 2 3x\n", WEFT_ERR_FORMAT, "a corner '3x'"},
        {V "f 1 2 3/\n", WEFT_ERR_FORMAT, "a corner '3/'"},
        {V "f 1 2 3/ 4\n", WEFT_ERR_FORMAT, "a corner '3/'"},
        {V "f 1 2 3//\n", WEFT_ERR_FORMAT, "a corner '3//'"},
        {V "f 1/1/1/1 2 3\n", WEFT_ERR_FORMAT, "a corner '1/1/1/1'"},
        {V "f 1 2\n", WEFT_ERR_FORMAT, "2 corners"},
        {V "f\n", WEFT_ERR_FORMAT, "0 corners"},
        {V, WEFT_ERR_FORMAT, "no triangles"},
        {V "l 1 2\np 3\n", WEFT_ERR_FORMAT, "no triangles, but 1 line, 1 point"},
        {"v nan 0 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT,
         "'v nan 0 0' has a number that is not finite"},
        {"v 0 inf 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'v 0 inf 0' has"},
        {"v 0 0 1e38\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "lies at (0, 0, 1e+38)"},
        {"v 0 0 -1e999\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "lies at ("},
        {"v 0 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "vertex 1 has 2 numbers"},
        {"v 0 0 0 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "homogeneous"},
        {"v 1 2 3 4 5 6 7 8 9\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "vertex 1 has 9 numbers"},
        {"vt nan 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'vt nan 0'"},
        {"vn 0 0 nan\n" V "f 1//1 2//1 3//1\n", WEFT_ERR_FORMAT, "'vn 0 0 nan'"},
        {"vt 1\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "number of components"},
        {"v 0 0 0 1 1 1\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "1 of 4 vertices have a colour"},
        {"vn 0 0\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "as a real number"},
        {"mtllib ../a.mtl\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'../a.mtl', which leads out"},
        {"mtllib /etc/passwd\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'/etc/passwd', which leads out"},
        {"mtllib link.mtl\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'link.mtl', which leads out"},
        {"mtllib proc/self/environ\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "which leads out"},
        {"mtllib pipe\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'pipe', which is not a plain file"},
        {"mtllib .\n" V "f 1 2 3\n", WEFT_ERR_FORMAT, "'.', which is not a plain file"},
        {"mtllib bad.mtl\nusemtl a\n" V "f 1 2 3\n", WEFT_ERR_FORMAT,
         "the material 'a' has a colour that is not finite"},
        {"\x89PNG\r\n\x1a\n123456789abcdef\n", WEFT_ERR_FORMAT, "no triangles"},
        {"v 0 0 0\\", WEFT_ERR_FORMAT, "too small"},
        {"\n", WEFT_ERR_FORMAT, "too small"},
    };
    assert_int_equal(symlink("/etc/passwd", test_path("link.mtl")), 0);
    assert_int_equal(symlink("/proc", test_path("proc")), 0);
    assert_int_equal(mkfifo(test_path("pipe"), 0600), 0);
    write_text("bad.mtl", "newmtl a\nKd nan 0 0\n");
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        write_text("a.obj", cases[i].text);
        assert_bad("a.obj", cases[i].result, cases[i].message);
    }
}

// ---- PLY ----------------------------------------------------------------------------------------

#define PLY "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define V3 "element vertex 3\n" XYZ
#define F1 "element face 1\nproperty list uchar int vertex_indices\n"
#define END "end_header\n"
#define P3 "0 0 0\n1 0 0\n0 1 0\n"

static void test_ply(void **state)
{
    (void)state;
    static const struct bad cases[] = {
        {PLY V3 F1 END P3 "3 0 1 3\n", WEFT_ERR_FORMAT,
         "face 0 of 'part 1' has the index 3 of 3 vertices"},
        {PLY V3 F1 END P3 "3 0 1 -1\n", WEFT_ERR_FORMAT, "has the index 4294967295 of 3 vertices"},
        {PLY V3 F1 END P3 "3 0 1\n", WEFT_ERR_FORMAT, "Unable to parse property"},
        {PLY V3 F1 END P3 "4000000000 0 1 2\n", WEFT_ERR_LIMIT, "do not fit in memory"},
        {PLY V3 F1 END P3 "-1 0 1 2\n", WEFT_ERR_FORMAT, "no triangles"},
        {PLY V3 F1 END P3 "2 0 1\n", WEFT_ERR_FORMAT, "no triangles"},
        {PLY V3 F1 END P3 "5000 0 1 2\n", WEFT_ERR_FORMAT, "Unable to parse property"},
        {PLY V3 F1 END P3, WEFT_ERR_FORMAT, "3 lines of data instead of 4"},
        {PLY V3 F1 END "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", WEFT_ERR_FORMAT, "lies at ("},
        {PLY V3 F1 END "0 0 0\ninf 0 0\n0 1 0\n3 0 1 2\n", WEFT_ERR_FORMAT,
         "vertex 1 of 'part 1' lies at (inf"},
        {PLY V3 F1 END "0 1e38 0\n1 0 0\n0 1 0\n3 0 1 2\n", WEFT_ERR_FORMAT,
         "lies at (0, 1e+38, 0)"},
        {PLY V3 END P3, WEFT_ERR_FORMAT, "no triangles, but 3 points"},
        {PLY V3 "element tristrips 1\nproperty list int int vertex_indices\n" END P3 "3 0 1 2\n",
         WEFT_ERR_UNSUPPORTED, "strips"},
        {PLY "element vertex 4000000000\n" XYZ F1 END P3, WEFT_ERR_FORMAT, "instead of 4000000001"},
        {PLY "element vertex 2000000000\n" XYZ F1 END P3, WEFT_ERR_FORMAT, "instead of 2000000001"},
        {PLY V3 "element face 4000000000\nproperty list uchar int vertex_indices\n" END P3
                "3 0 1 2",
         WEFT_ERR_FORMAT, "instead of 4000000003"},
        {PLY V3 "element x 9223372036854775807\n" F1 END P3 "3 0 1 9\n", WEFT_ERR_LIMIT,
         "more than can be read"},
        {PLY V3 "element x 99999999999999999999\n" END, WEFT_ERR_LIMIT, "more than can be read"},
        {PLY V3 "element vertex 9\n" XYZ F1 END P3, WEFT_ERR_FORMAT, "2 elements 'vertex'"},
        {PLY V3 F1 V3 END P3 "3 0 1 2\n", WEFT_ERR_FORMAT, "2 elements 'vertex'"},
        {PLY F1 END "3 0 0 0\n", WEFT_ERR_FORMAT, "0 elements 'vertex'"},
        {PLY F1 V3 END "3 0 1 2\n" P3, WEFT_ERR_FORMAT, "declared before faces"},
        {PLY "element\n" END, WEFT_ERR_FORMAT, "'element' has no name and number"},
        {PLY V3 F1, WEFT_ERR_FORMAT, "its header has no end"},
        {"ply\n" V3 F1 END P3 "3 0 1 2\n", WEFT_ERR_FORMAT, "Missing format"},
        {"ply\nformat ebcdic 1.0\n" V3 F1 END P3, WEFT_ERR_FORMAT, "Unknown file format"},
        {"solid cube\n", WEFT_ERR_FORMAT, "starts with 'ply'"},
        {"ply", WEFT_ERR_FORMAT, "starts with 'ply'"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        write_text("a.ply", cases[i].text);
        assert_bad("a.ply", cases[i].result, cases[i].message);
    }
}

// ---- glTF ---------------------------------------------------------------------------------------

#define NODES "\"nodes\":[{\"mesh\":0}],"
#define MESHES "\"meshes\":[" GLTF_MESH "],\"materials\":[{}],"
#define BIN "\"buffers\":[{\"byteLength\":44,\"uri\":\"a.bin\"}]}"
#define ALL(nodes, meshes, accessors, buffers) GLTF_START nodes meshes accessors "," buffers
#define URI(name)                                                                                  \
    ALL(NODES, MESHES, GLTF_ACCESSORS, "\"buffers\":[{\"byteLength\":44,\"uri\":\"" name "\"}]}")
#define ACCESSORS(first, views) "\"accessors\":[" first "],\"bufferViews\":[" views "]"
#define FIRST(more)                                                                                \
    "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"" more "}"
#define INDICES "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}"
#define VIEWS "{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}"

static void test_gltf(void **state)
{
    (void)state;
    static const struct bad cases[] = {
        {URI("gone.bin"), WEFT_ERR_FORMAT, "'gone.bin', which is not there"},
        {URI("../a.bin"), WEFT_ERR_FORMAT, "'../a.bin', which leads out"},
        {URI("%2e%2e/a.bin"), WEFT_ERR_FORMAT, "'../a.bin', which leads out"},
        {URI("/etc/passwd"), WEFT_ERR_FORMAT, "'/etc/passwd', which leads out"},
        {URI("file:///etc/passwd"), WEFT_ERR_FORMAT, "'file:///etc/passwd', which is not there"},
        {URI("http://example.org/a.bin"), WEFT_ERR_FORMAT, "a.bin', which is not there"},
        {URI("link.bin"), WEFT_ERR_FORMAT, "'link.bin', which leads out"},
        {URI("pipe"), WEFT_ERR_FORMAT, "'pipe', which is not a plain file"},
        {URI("."), WEFT_ERR_FORMAT, "which is not a plain file"},
        {URI(""), WEFT_ERR_FORMAT, "which is not there"},
        {URI("short.bin"), WEFT_ERR_FORMAT, "exceeds size of actual data"},
        {URI("data:;base64,AAAA"), WEFT_ERR_FORMAT, "expected 44 bytes"},
        {URI("data:;base64,A*AA"), WEFT_ERR_FORMAT, "expected 44 bytes"},
        {URI("data:text/plain,abc"), WEFT_ERR_FORMAT, "expected 44 bytes"},
        {URI("nan.bin"), WEFT_ERR_FORMAT, "vertex 1 of 'part 1' lies at (nan"},
        {URI("large.bin"), WEFT_ERR_FORMAT, "lies at (1e+38, 0, 0)"},
        {URI("index.bin"), WEFT_ERR_FORMAT, "out-of-range indices"},
        {ALL(NODES, MESHES, GLTF_ACCESSORS, "\"buffers\":[{\"byteLength\":44}]}"), WEFT_ERR_FORMAT,
         "missing the \"uri\""},
        {ALL("\"nodes\":[{\"mesh\":0,\"children\":[0]}],", MESHES, GLTF_ACCESSORS, BIN),
         WEFT_ERR_FORMAT, "recursive reference to itself"},
        {ALL("\"nodes\":[{\"children\":[7]}],", MESHES, GLTF_ACCESSORS, BIN), WEFT_ERR_FORMAT,
         "index 7 is out of bounds (1) for \"nodes\""},
        {ALL("\"nodes\":[{\"mesh\":1}],", MESHES, GLTF_ACCESSORS, BIN), WEFT_ERR_FORMAT,
         "index 1 is out of bounds (1) for \"meshes\""},
        {ALL("\"nodes\":[{\"mesh\":-1}],", MESHES, GLTF_ACCESSORS, BIN), WEFT_ERR_FORMAT,
         "was not of type"},
        {ALL("\"nodes\":[{\"mesh\":0,\"scale\":[1e30,1,1],\"children\":[1]},"
             "{\"mesh\":0,\"scale\":[1e30,1,1]}],",
             MESHES, GLTF_ACCESSORS, BIN),
         WEFT_ERR_FORMAT, "lies at (inf, 0, 0)"},
        {ALL("\"nodes\":[{\"mesh\":0,\"scale\":[1e38,1,1]}],", MESHES, GLTF_ACCESSORS, BIN),
         WEFT_ERR_FORMAT, "lies at (1e+38, 0, 0)"},
        {ALL("\"nodes\":[{}],", MESHES, GLTF_ACCESSORS, BIN), WEFT_ERR_FORMAT, "no triangles"},
        {ALL(NODES, "\"meshes\":[{\"primitives\":[{\"mode\":3,\"attributes\":{\"POSITION\":0}}]}],",
             GLTF_ACCESSORS, BIN),
         WEFT_ERR_FORMAT, "no triangles, but 2 lines"},
        {ALL(NODES, "\"meshes\":[{\"primitives\":[{\"attributes\":{}}]}],", GLTF_ACCESSORS, BIN),
         WEFT_ERR_FORMAT, "no faces"},
        {ALL(NODES, MESHES, ACCESSORS(FIRST(",\"byteOffset\":4") "," INDICES, VIEWS), BIN),
         WEFT_ERR_FORMAT, "do not lie in the 36 bytes of bufferViews[0]"},
        {ALL(NODES, MESHES,
             ACCESSORS(FIRST(",\"byteOffset\":9223372036854775807") "," INDICES, VIEWS), BIN),
         WEFT_ERR_FORMAT, "bytes from 9223372036854775807 on do not lie"},
        {ALL(NODES, MESHES,
             ACCESSORS(FIRST("") "," INDICES, "{\"buffer\":0,\"byteOffset\":40,\"byteLength\":36},"
                                              "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}"),
             BIN),
         WEFT_ERR_FORMAT, "offset/length (40/36) is out of range"},
        {ALL(NODES, MESHES, ACCESSORS(FIRST(""), VIEWS), BIN), WEFT_ERR_FORMAT,
         "index 1 is out of bounds (1) for \"accessors\""},
        {ALL(NODES, MESHES, ACCESSORS(INDICES "," INDICES, VIEWS), BIN), WEFT_ERR_UNSUPPORTED,
         "accessors[0], of POSITION, has 1 components of type 5123"},
        {ALL(NODES, MESHES, ACCESSORS(FIRST("") "," FIRST(""), VIEWS), BIN), WEFT_ERR_UNSUPPORTED,
         "accessors[1], of indices, has 3 components of type 5126"},
        {"{\"asset\":{\"version\":\"2.0\"},\"asset\":{\"version\":\"2.0\"}}", WEFT_ERR_FORMAT,
         "duplicate"},
        {"{\"asset\":{\"version\":\"1.0\"}}", WEFT_ERR_UNSUPPORTED, "glTF '1.0'"},
        {"{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"
         "}",
         WEFT_ERR_UNSUPPORTED, "'KHR_draco_mesh_compression'"},
        {"{}", WEFT_ERR_UNSUPPORTED, "glTF ''"},
        {"[]", WEFT_ERR_UNSUPPORTED, "glTF ''"},
        {"glTF\2", WEFT_ERR_FORMAT, "line 1"},
        {"{\"asset\":", WEFT_ERR_FORMAT, "line 1"},
    };
    char bytes[GLTF_BYTES];
    const float nan = NAN, large = 1e38f;
    const unsigned short three = 3;
    gltf_bytes(bytes);
    test_write_file(test_path("a.bin"), bytes, sizeof bytes);
    test_write_file(test_path("short.bin"), bytes, 9);
    memcpy(bytes + 12, &nan, 4);
    test_write_file(test_path("nan.bin"), bytes, sizeof bytes);
    memcpy(bytes + 12, &large, 4);
    test_write_file(test_path("large.bin"), bytes, sizeof bytes);
    gltf_bytes(bytes);
    memcpy(bytes + 38, &three, 2);
    test_write_file(test_path("index.bin"), bytes, sizeof bytes);
    assert_int_equal(symlink("/etc/passwd", test_path("link.bin")), 0);
    assert_int_equal(mkfifo(test_path("pipe"), 0600), 0);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        write_text("a.gltf", cases[i].text);
        assert_bad("a.gltf", cases[i].result, cases[i].message);
    }
    write_text("a.gltf", URI("a.bin")); // the same, without a fault
    struct weft_mesh mesh = load_good("a.gltf");
    weft_mesh_clear(&mesh);
}

// Nodes below nodes, brackets in brackets.
static void test_deep(void **state)
{
    (void)state;
    for (int count = 900; count < 200000; count *= 200) {
        char *text = malloc((size_t)count * 64 + 4096), *at = text, buffer[400];
        assert_non_null(text);
        data_buffer(buffer, sizeof buffer);
        at += sprintf(at, GLTF_START "\"nodes\":[");
        for (int i = 0; i < count; i++)
            at += sprintf(at, "{\"children\":[%d]},", i + 1);
        sprintf(at, "{\"mesh\":0}]," MESHES GLTF_ACCESSORS ",\"buffers\":[%s]}", buffer);
        write_text("a.gltf", text);
        if (count == 900) {
            struct weft_mesh mesh = load_good("a.gltf");
            weft_mesh_clear(&mesh);
        } else {
            assert_bad("a.gltf", WEFT_ERR_READER, "was killed by signal"); // assimp calls itself
        }
        memset(text, '[', (size_t)count * 64);
        text[(size_t)count * 64] = '\0';
        write_text("a.gltf", text);
        assert_bad("a.gltf", WEFT_ERR_FORMAT, "maximum parsing depth");
        free(text);
    }
}

static void test_glb(void **state)
{
    (void)state;
    static const struct {
        size_t at;
        uint32_t word;
        enum weft_result result;
        const char *message;
    } cases[] = {{0, 0x46546c68, WEFT_ERR_FORMAT, "starts with 'glTF'"},
                 {4, 1, WEFT_ERR_FORMAT, "Unsupported binary glTF version"},
                 {8, 12, WEFT_ERR_FORMAT, "out of range"},
                 {12, 0xffffffff, WEFT_ERR_FORMAT, "its header says 4294967295 bytes of JSON"},
                 {16, 0, WEFT_ERR_FORMAT, "JSON chunk missing"}};
    char data[4096];
    const size_t size = glb_bytes("{\"mesh\":0}", data, sizeof data);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        uint32_t old;
        memcpy(&old, data + cases[i].at, 4);
        memcpy(data + cases[i].at, &cases[i].word, 4);
        test_write_file(test_path("a.glb"), data, size);
        assert_bad("a.glb", cases[i].result, cases[i].message);
        memcpy(data + cases[i].at, &old, 4);
    }
    const uint32_t much = 0x7fffffff;
    memcpy(data + size - 44 - 8, &much, 4);
    test_write_file(test_path("a.glb"), data, size);
    assert_bad("a.glb", WEFT_ERR_FORMAT, "exceeds size of actual data");
}

// ---- what is no file of a mesh ------------------------------------------------------------------

static void test_paths(void **state)
{
    (void)state;
    struct weft_mesh mesh;
    const struct weft_limits none = {0};
    assert_int_equal(mkdir(test_path("folder.obj"), 0700), 0);
    assert_int_equal(mkfifo(test_path("pipe.ply"), 0600), 0);
    write_text("empty.obj", "");
    write_text("a.stl", "solid");
    write_text("obj", "");
    assert_bad("folder.obj", WEFT_ERR_OPEN, "Is a directory");
    assert_bad("pipe.ply", WEFT_ERR_OPEN, "not a regular file");
    assert_bad("gone.glb", WEFT_ERR_OPEN, "No such file");
    assert_bad("empty.obj", WEFT_ERR_FORMAT, "the file is empty");
    assert_bad("a.stl", WEFT_ERR_ARGUMENT, "a mesh ends in");
    assert_bad("obj", WEFT_ERR_ARGUMENT, "a mesh ends in");
    assert_int_equal(load(NULL, none, &mesh), WEFT_ERR_ARGUMENT);
    setenv("WEFT_LIBEXEC", "/nonexistent", 1);
    write_text("a.obj", V "f 1 2 3\n");
    assert_int_equal(load(test_path("a.obj"), none, &mesh), WEFT_ERR_READER);
    assert_non_null(strstr(test_message, "weft-read-mesh is not in /nonexistent"));
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
}

// ---- limits -------------------------------------------------------------------------------------

static void test_limits(void **state)
{
    (void)state;
    struct weft_mesh mesh;
    const size_t lines = 300000;
    char *text = malloc(lines * 24), *at = text;
    assert_non_null(text);
    at += sprintf(at, V);
    for (size_t i = 0; i < lines; i++)
        at += sprintf(at, "f 1 2 3\n");
    write_text("a.obj", text);
    assert_int_equal(load(test_path("a.obj"), (struct weft_limits){.output_bytes = 1 << 20}, &mesh),
                     WEFT_ERR_LIMIT);
    assert_non_null(strstr(test_message, "output limit"));
    assert_int_equal(test_errors, 1);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_int_equal(
        load(test_path("a.obj"), (struct weft_limits){.memory_bytes = 48 << 20}, &mesh),
        WEFT_ERR_LIMIT);
    assert_non_null(strstr(test_message, "50331648"));
#endif
    // One polygon of all corners.
    at = text + sprintf(text, V "f");
    for (size_t i = 0; i < lines; i++)
        at += sprintf(at, " 1 2 3");
    write_text("a.obj", text);
    assert_bad("a.obj", WEFT_ERR_LIMIT, "900000 corners: 4096 is the limit");
    at = text + sprintf(text, V);
    for (int i = 0; i < 70000; i++)
        at += sprintf(at, "g %d\nf 1 2 3\n", i);
    write_text("a.obj", text);
    assert_bad("a.obj", WEFT_ERR_LIMIT, "65537 parts");
    free(text);
}

// ---- a reader that lies -------------------------------------------------------------------------

static void test_liars(void **state)
{
    (void)state;
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR "/liars", 1);
    for (const char *how = "abcdefghijklmnopqrstuvwxyz12"; *how; how++) {
        struct weft_mesh mesh;
        char name[16];
        snprintf(name, sizeof name, "%c.obj", *how);
        write_text(name, (const char[]){*how, '\0'});
        const enum weft_result res =
            load(test_path(name), (struct weft_limits){.wall_seconds = 1}, &mesh);
        if (res != (*how == 'y' ? WEFT_ERR_LIMIT : WEFT_ERR_READER) || test_errors != 1 ||
            mesh.memory || !strstr(test_message, name))
            fail_msg("%c: %s, '%s'", *how, weft_result_text(res), test_message);
        assert_int_equal(count_children(), 0);
    }
    write_text("0.obj", "0"); // the truth
    struct weft_mesh mesh = load_good("0.obj");
    assert_string_equal(mesh.parts[0].name, "a?b");
    weft_mesh_clear(&mesh);
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
}

// ---- damage -------------------------------------------------------------------------------------

static uint64_t random_state = 1;

static uint64_t next_random(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

struct outcomes {
    int good, bad;
};

// A mesh that is valid, or one line.
static void meet(const char *name, struct outcomes *outcomes)
{
    struct weft_mesh mesh;
    const struct weft_limits limits = {
        .memory_bytes = 512 << 20, .output_bytes = 64 << 20, .cpu_seconds = 10, .wall_seconds = 30};
    const enum weft_result res = load(test_path(name), limits, &mesh);
    if (res == WEFT_OK) {
        assert_string_equal(test_message, "");
        assert_valid(&mesh);
        outcomes->good++;
    } else {
        // Some take assimp down, which is one line, too.
        if ((res != WEFT_ERR_READER && res != WEFT_ERR_FORMAT && res != WEFT_ERR_UNSUPPORTED &&
             res != WEFT_ERR_LIMIT) ||
            test_errors != 1 || !strstr(test_message, name) || mesh.memory)
            fail_msg("%s: %s, %d lines, '%s'", name, weft_result_text(res), test_errors,
                     test_message);
        outcomes->bad++;
    }
    weft_mesh_clear(&mesh);
}

static void mutate(const char *name, const char *source, size_t size, int count)
{
    static const uint32_t words[] = {0,          1,          0x7fffffff, 0x80000000,
                                     0xffffffff, 0x7fc00000, 0x7e967699};
    static const char *const texts[] = {"nan", "-1", "1e38", "99999999999", "[",
                                        "\"",  "\n", "/",    "{}"};
    struct outcomes outcomes = {0, 0};
    char *data = malloc(size + 16);
    assert_non_null(data);
    for (size_t length = 1; length < size; length += 64) {
        test_write_file(test_path(name), source, length);
        meet(name, &outcomes);
    }
    for (int i = 0; i < count; i++) {
        memcpy(data, source, size);
        for (int n = 1 + (int)(next_random() % 3); n > 0; n--) {
            const size_t at = next_random() % size;
            const char *text = texts[next_random() % WEFT_COUNT(texts)];
            switch (next_random() % 4) {
            case 0:
                data[at] ^= (char)(1u << next_random() % 8);
                break;
            case 1:
                data[at] = (char)next_random();
                break;
            case 2:
                memcpy(data + at, &words[next_random() % WEFT_COUNT(words)], 4);
                break;
            default:
                memcpy(data + at, text, strlen(text));
            }
        }
        test_write_file(test_path(name), data, size);
        meet(name, &outcomes);
    }
    print_message("%s: %d read, %d refused\n", name, outcomes.good, outcomes.bad);
    assert_true(outcomes.bad > 0);
    free(data);
}

static void test_damage(void **state)
{
    (void)state;
    const char *setting = getenv("WEFT_MUTATIONS");
    const int count = setting ? atoi(setting) : 20;
    const int fds = test_count_entries("/proc/self/fd");
    static const char obj[] =
        "mtllib a.mtl\no box\n" V "v 0 0 1\nvt 0 0\nvn 0 0 1\nusemtl a\n"
        "f 1/1/1 2/1/1 3/1/1\nf 1 3 4 2\nf -1 -2 -3\ng other\nf 1//1 2//1 4//1\n";
    static const char ply[] =
        PLY V3 "property uchar red\nproperty uchar green\n"
               "property uchar blue\n" F1 END "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2\n";
    char binary[400], text[4096], buffer[400];
    const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const int face[3] = {0, 1, 2};
    size_t size = (size_t)sprintf(binary, "ply\nformat binary_little_endian 1.0\n" V3 F1 END);
    memcpy(binary + size, xyz, sizeof xyz);
    binary[size + sizeof xyz] = 3;
    memcpy(binary + size + sizeof xyz + 1, face, sizeof face);
    size += sizeof xyz + 1 + sizeof face;
    write_text("a.mtl", "newmtl a\nKd 1 1 1\n");
    mutate("a.obj", obj, strlen(obj), count);
    mutate("a.ply", ply, strlen(ply), count);
    mutate("b.ply", binary, size, count);
    data_buffer(buffer, sizeof buffer);
    gltf_text("{\"mesh\":0,\"children\":[1]},{\"mesh\":0,\"scale\":[1,2,3]}", buffer, text,
              sizeof text);
    mutate("a.gltf", text, strlen(text), count);
    size = glb_bytes("{\"mesh\":0,\"children\":[1]},{\"mesh\":0}", text, sizeof text);
    mutate("a.glb", text, size, count);
    assert_int_equal(test_count_entries("/proc/self/fd"), fds);
    assert_int_equal(count_children(), 0);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_obj),    IN_FOLDER(test_ply),   IN_FOLDER(test_gltf),
        IN_FOLDER(test_deep),   IN_FOLDER(test_glb),   IN_FOLDER(test_paths),
        IN_FOLDER(test_limits), IN_FOLDER(test_liars), IN_FOLDER(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
