// SPDX-License-Identifier: BSD-3-Clause
// NRRD, NIfTI and raw files: every sample's value, where it lies, and what is refused. Files are
// written here, byte by byte; values are compared with the numbers that were written, rounded once.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <zlib.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/support/vdb_files.h"

enum { NX = 11, NY = 9, NZ = 10, COUNT = NX * NY * NZ };

// Of all types: ends of their ranges, and what no float holds.
static long double number_at(enum weft_sample_type type, int i)
{
    static const long double ends[WEFT_SAMPLE_TYPE_COUNT][2] = {
        {0, 255},         {-128, 127},
        {0, 65535},       {-32768, 32767},
        {0, 4294967295u}, {-2147483648.0L, 2147483647},
        {0, UINT64_MAX},  {INT64_MIN, INT64_MAX},
        {-1e38L, 0.1f},   {-1e300L, 0.1}};
    if (i % 7 < 2)
        return ends[type][i % 7];
    if (type >= WEFT_SAMPLE_FLOAT)
        return type == WEFT_SAMPLE_FLOAT ? (float)(i / 3.0) : i / 3.0;
    return i % 128;
}

static size_t put_number(enum weft_sample_type type, long double value, bool swapped,
                         unsigned char *out)
{
    const size_t size = weft_sample_sizes[type];
    const float single = (float)value;
    const double wide = (double)value;
    uint64_t bits = value < 0 ? (uint64_t)(int64_t)value : (uint64_t)value;
    if (type == WEFT_SAMPLE_DOUBLE)
        memcpy(&bits, &wide, sizeof bits);
    if (type == WEFT_SAMPLE_FLOAT)
        memcpy(&bits, &single, sizeof single);
    for (size_t i = 0; i < size; i++)
        out[swapped ? size - 1 - i : i] = (unsigned char)(bits >> 8 * i);
    return size;
}

// Samples of a volume, `sets` times; to be freed.
static unsigned char *make_samples(enum weft_sample_type type, bool swapped, int sets, size_t *size)
{
    unsigned char *data = malloc((size_t)COUNT * 8 * (size_t)sets);
    assert_non_null(data);
    *size = 0;
    for (int i = 0; i < COUNT * sets; i++)
        *size += put_number(type, number_at(type, i), swapped, data + *size);
    return data;
}

static void write_two(const char *name, const void *head, size_t head_size, const void *data,
                      size_t size)
{
    unsigned char *all = malloc(head_size + size + 1);
    assert_non_null(all);
    memcpy(all, head, head_size);
    if (size)
        memcpy(all + head_size, data, size);
    write_whole(file_path(name), all, head_size + size);
    free(all);
}

static unsigned char *gzip(const void *data, size_t size, size_t *out_size)
{
    z_stream stream = {.next_in = (Bytef *)(uintptr_t)data, .avail_in = (uInt)size};
    assert_int_equal(deflateInit2(&stream, 9, Z_DEFLATED, 31, 9, Z_DEFAULT_STRATEGY), Z_OK);
    const size_t room = deflateBound(&stream, (uLong)size);
    unsigned char *out = malloc(room);
    assert_non_null(out);
    stream.next_out = out;
    stream.avail_out = (uInt)room;
    assert_int_equal(deflate(&stream, Z_FINISH), Z_STREAM_END);
    *out_size = stream.total_out;
    deflateEnd(&stream);
    return out;
}

static weft_volume *open_with(struct weft_volume_open_params params)
{
    weft_volume *volume = NULL;
    params.log = &test_log;
    if (weft_volume_open(&params, &volume) != WEFT_OK)
        fail_msg("%s", last_error.message);
    return volume;
}

static weft_volume *open_name(const char *name)
{
    return open_with((struct weft_volume_open_params){.path = file_path(name)});
}

static enum weft_result refuse(const char *name, const char *grid)
{
    weft_volume *volume = NULL;
    *last_error.message = 0;
    const enum weft_result res = weft_volume_open(
        weft_volume_open_params(.path = file_path(name), .grid = grid, .log = &test_log), &volume);
    weft_volume_destroy(&volume);
    return res;
}

static void assert_refused(const char *name, enum weft_result result, const char *message)
{
    assert_int_equal(refuse(name, NULL), result);
    if (!strstr(last_error.message, message))
        fail_msg("'%s' lacks '%s'", last_error.message, message);
}

// Of sample i of the file; the expected value is what `expected` tells, rounded to a float.
typedef long double (*expected_value)(int i, const void *priv);

static int nearest(int at, int size)
{
    return at < size ? at : size - 1;
}

// All voxels of all bricks, those beyond the box, too.
static void assert_values(weft_volume *volume, const int size[3], int first, int step,
                          expected_value expected, const void *priv)
{
    struct weft_brick_list list;
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    assert_true(info->clamp_to_edge);
    assert_int_equal(weft_volume_find(volume, &everywhere, &list), WEFT_OK);
    assert_int_equal(list.brick_count, info->bricks);
    float *values = malloc(list.brick_count * 2048);
    assert_non_null(values);
    assert_int_equal(
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values),
        WEFT_OK);
    size_t seen = 0;
    for (size_t b = 0; b < list.brick_count; b++)
        for (int v = 0; v < 512; v++, seen++) {
            const int32_t *o = list.brick_origin[b];
            const int x = nearest(o[0] + (v & 7), size[0]);
            const int y = nearest(o[1] + (v >> 3 & 7), size[1]);
            const int z = nearest(o[2] + (v >> 6), size[2]);
            const int i = first + step * ((z * size[1] + y) * size[0] + x);
            const float want = (float)expected(i, priv), got = values[b * 512 + (size_t)v];
            if (!(got == want))
                fail_msg("(%d, %d, %d) is %.9g, not %.9g", x, y, z, got, want);
        }
    assert_int_equal(seen, list.brick_count * 512);
    assert_true(seen > 0);
    free(values);
    weft_brick_list_clear(&list);
}

static long double of_type(int i, const void *priv)
{
    return number_at(*(const enum weft_sample_type *)priv, i);
}

static const int whole_size[3] = {NX, NY, NZ};

// ---- NRRD ---------------------------------------------------------------------------------------

static const char *const nrrd_types[WEFT_SAMPLE_TYPE_COUNT] = {
    "uint8", "signed char", "ushort", "short", "unsigned int",
    "int",   "uint64",      "int64",  "float", "double"};

static void write_nrrd(const char *name, const char *fields, const void *data, size_t size)
{
    char head[2048];
    const int length = snprintf(head, sizeof head, "NRRD0005\n%s\n", fields);
    write_two(name, head, (size_t)length, data, size);
}

static void write_typed(const char *name, enum weft_sample_type type, const char *encoding,
                        const char *more, const void *data, size_t size)
{
    char fields[1024];
    snprintf(fields, sizeof fields, "type: %s\ndimension: 3\nsizes: %d %d %d\nencoding: %s\n%s",
             nrrd_types[type], NX, NY, NZ, encoding, more);
    write_nrrd(name, fields, data, size);
}

static void check_typed(const char *name, enum weft_sample_type type)
{
    weft_volume *volume = open_name(name);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    assert_int_equal(info->format, WEFT_VOLUME_NRRD);
    assert_string_equal(info->type, weft_sample_type_names[type]);
    assert_int_equal(info->components, 1);
    assert_int_equal(info->active_voxels, COUNT);
    assert_values(volume, whole_size, 0, 1, of_type, &type);
    uint64_t rounded = 0, infinite = 0;
    double largest = 0;
    for (int i = 0; i < COUNT; i++) {
        const long double value = number_at(type, i);
        const double lack = (double)fabsl(value - (float)value);
        rounded += type < WEFT_SAMPLE_FLOAT && lack > 0;
        largest = type < WEFT_SAMPLE_FLOAT && lack > largest ? lack : largest;
        infinite += type == WEFT_SAMPLE_DOUBLE && isinf((float)value);
    }
    assert_int_equal(info->values_rounded, rounded);
    assert_true(info->largest_rounding == largest);
    assert_int_equal(info->values_infinite, infinite);
    assert_int_equal(info->rounded, type == WEFT_SAMPLE_DOUBLE);
    weft_volume_destroy(&volume);
}

static void test_types(void **state)
{
    (void)state;
    for (int t = 0; t < WEFT_SAMPLE_TYPE_COUNT; t++) {
        const enum weft_sample_type type = (enum weft_sample_type)t;
        size_t size, packed_size;
        unsigned char *little = make_samples(type, false, 1, &size);
        write_typed("raw.nrrd", type, "raw", "endian: little\n", little, size);
        check_typed("raw.nrrd", type);
        unsigned char *packed = gzip(little, size, &packed_size);
        write_typed("gzip.nrrd", type, "gzip", "endian: little\n", packed, packed_size);
        check_typed("gzip.nrrd", type);
        free(packed);
        free(little);
        unsigned char *big = make_samples(type, true, 1, &size);
        write_typed("big.nrrd", type, "raw", "endian: big\n", big, size);
        check_typed("big.nrrd", type);
        free(big);
    }
}

static void test_text(void **state)
{
    (void)state;
    char *text = malloc(COUNT * 40);
    assert_non_null(text);
    for (enum weft_sample_type type = 0; type < WEFT_SAMPLE_TYPE_COUNT; type++) {
        if (type == WEFT_SAMPLE_UINT64 || type == WEFT_SAMPLE_INT64)
            continue; // Teem reads them through doubles
        char *to = text;
        for (int i = 0; i < COUNT; i++)
            to +=
                sprintf(to, type >= WEFT_SAMPLE_FLOAT ? "%.17Lg\n" : "%.0Lf ", number_at(type, i));
        write_typed("text.nrrd", type, "ascii", "", text, (size_t)(to - text));
        check_typed("text.nrrd", type);
    }
    size_t size;
    const enum weft_sample_type type = WEFT_SAMPLE_UINT16;
    unsigned char *data = make_samples(type, false, 1, &size);
    for (size_t i = 0; i < size; i++)
        sprintf(text + 2 * i, "%02x", data[i]);
    write_typed("hex.nrrd", type, "hex", "endian: little\n", text, 2 * size);
    check_typed("hex.nrrd", type);
    free(data);
    free(text);
}

static void assert_transform(const char *name, const double expected[3][4])
{
    weft_volume *volume = open_name(name);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (fabs(info->index_to_world[r][c] - expected[r][c]) > 1e-15)
                fail_msg("%s: [%d][%d] is %.17g, not %.17g", name, r, c, info->index_to_world[r][c],
                         expected[r][c]);
    weft_volume_destroy(&volume);
}

static const char *metadata_of(const struct weft_volume_info *info, const char *key)
{
    for (size_t i = 0; i < info->metadata_count; i++)
        if (!strcmp(info->metadata[i].key, key))
            return info->metadata[i].value;
    return "";
}

static void test_orientation(void **state)
{
    (void)state;
    static const struct {
        const char *fields;
        double transform[3][4];
    } cases[] = {
        {"dimension: 3\nsizes: 2 3 4\nspace: left-posterior-superior\n"
         "space directions: (0.5,0.25,0) (-0.25,0.5,0) (0,0,-2)\nspace origin: (10,20,30)\n",
         {{0.5, -0.25, 0, 10}, {0.25, 0.5, 0, 20}, {0, 0, -2, 30}}},
        {"dimension: 3\nsizes: 2 3 4\nspacings: 0.5 2 3\n",
         {{0.5, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 3, 0}}},
        {"dimension: 3\nsizes: 2 3 4\naxis mins: 1 2 3\naxis maxs: 5 8 11\n"
         "centers: node node cell\n", // 24 samples: 4, 3, and 2 apart
         {{4, 0, 0, 1}, {0, 3, 0, 2}, {0, 0, 2, 4}}},
        {"dimension: 3\nsizes: 2 3 4\n", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
        {"dimension: 2\nsizes: 4 6\nspacings: 2 3\n", {{2, 0, 0, 0}, {0, 3, 0, 0}, {0, 0, 1, 0}}},
        {"dimension: 2\nsizes: 4 6\nspace dimension: 3\nspace directions: (0,2,0) (0,0,3)\n"
         "space origin: (1,2,3)\n",
         {{0, 0, 1, 1}, {2, 0, 0, 2}, {0, 3, 0, 3}}},
    };
    unsigned char data[24] = {0};
    char fields[512];
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        snprintf(fields, sizeof fields, "type: uint8\nencoding: raw\n%s", cases[i].fields);
        write_nrrd("place.nrrd", fields, data, sizeof data);
        assert_transform("place.nrrd", cases[i].transform);
    }
    write_nrrd("notes.nrrd",
               "type: uint8\ndimension: 3\nsizes: 2 3 4\nencoding: raw\nspace: RAS\n"
               "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace units: \"mm\" \"mm\" \"mm\"\n"
               "measurement frame: (1,0,0) (0,0,1) (0,1,0)\ncontent: a head\nwho:=nobody\n",
               data, sizeof data);
    weft_volume *volume = open_name("notes.nrrd");
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    assert_string_equal(info->name, "notes");
    assert_string_equal(metadata_of(info, "space"), "right-anterior-superior");
    assert_string_equal(metadata_of(info, "space units"), "mm mm mm");
    assert_string_equal(metadata_of(info, "measurement frame"), "(1,0,0) (0,0,1) (0,1,0)");
    assert_string_equal(metadata_of(info, "content"), "a head");
    assert_string_equal(metadata_of(info, "who"), "nobody");
    weft_volume_destroy(&volume);
}

static void test_other_axes(void **state)
{
    (void)state;
    static const struct {
        const char *fields;
        int components, grids, first, step; // of the second grid or component
    } cases[] = {
        {"dimension: 4\nsizes: 3 11 9 10\nkinds: vector domain domain domain\n", 3, 1, 1, 3},
        {"dimension: 4\nsizes: 3 11 9 10\n", 3, 1, 1, 3},
        {"dimension: 4\nsizes: 11 9 10 3\nkinds: domain domain domain vector\n", 3, 1, COUNT, 1},
        {"dimension: 4\nsizes: 11 9 10 3\nkinds: space space space time\n", 1, 3, COUNT, 1},
        {"dimension: 4\nsizes: 11 9 10 3\n", 1, 3, COUNT, 1},
        {"dimension: 4\nsizes: 2 11 9 10\nkinds: complex domain domain domain\n", 1, 2, 1, 2},
        {"dimension: 4\nsizes: 11 9 10 2\nspace: RAS\n"
         "space directions: (1,0,0) (0,1,0) (0,0,1) none\n",
         1, 2, COUNT, 1},
    };
    const enum weft_sample_type type = WEFT_SAMPLE_INT16;
    size_t size;
    unsigned char *data = make_samples(type, false, 3, &size);
    char fields[512];
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const int sets = cases[i].components * cases[i].grids;
        snprintf(fields, sizeof fields, "type: short\nencoding: raw\nendian: little\n%s",
                 cases[i].fields);
        write_nrrd("axes.nrrd", fields, data, size / 3 * (size_t)sets);
        struct weft_volume_list list;
        assert_int_equal(
            weft_volume_list_load(
                weft_volume_open_params(.path = file_path("axes.nrrd"), .log = &test_log), &list),
            WEFT_OK);
        assert_int_equal(list.count, cases[i].grids);
        assert_int_equal(list.grids[0].components, cases[i].components);
        const bool grids = list.count > 1;
        assert_string_equal(list.grids[grids].name, grids ? "axes[1]" : "axes");
        weft_volume_list_clear(&list);
        weft_volume *volume = open_with((struct weft_volume_open_params){
            .path = file_path("axes.nrrd"), .grid = grids ? "axes[1]" : NULL, .component = !grids});
        assert_values(volume, whole_size, cases[i].first, cases[i].step, of_type, &type);
        weft_volume_destroy(&volume);
    }
    assert_int_equal(refuse("axes.nrrd", "axes[2]"), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last_error.message, "no grid 'axes[2]'"));
    free(data);
}

static void test_detached(void **state)
{
    (void)state;
    const enum weft_sample_type type = WEFT_SAMPLE_INT16;
    size_t size;
    unsigned char *data = make_samples(type, false, 1, &size);
    write_two("bytes.raw", "skipped line\nxyz", 16, data, size);
    write_typed("one.nhdr", type, "raw",
                "endian: little\nline skip: 1\nbyte skip: 3\ndata file: bytes.raw\n", NULL, 0);
    check_typed("one.nhdr", type);
    write_typed("end.nhdr", type, "raw", "endian: little\nbyte skip: -1\ndatafile: bytes.raw\n",
                NULL, 0);
    check_typed("end.nhdr", type);
    char list[512] = "endian: little\ndata file: LIST\n", name[32];
    for (int z = 0; z < NZ; z++) {
        snprintf(name, sizeof name, "z%02d.raw", z + 1);
        write_two(name, "", 0, data + (size_t)z * size / NZ, size / NZ);
        strcat(strcat(list, name), "\n");
    }
    write_typed("list.nhdr", type, "raw", list, NULL, 0);
    check_typed("list.nhdr", type);
    write_typed("numbers.nhdr", type, "raw", "endian: little\ndata file: z%02d.raw 1 10 1\n", NULL,
                0);
    check_typed("numbers.nhdr", type);
    static const char *const outside[] = {"/etc/passwd", "../secret", "link", "LIST\n/etc/passwd"};
    assert_int_equal(symlink("/etc/passwd", file_path("link")), 0);
    for (size_t i = 0; i < WEFT_COUNT(outside); i++) {
        char more[128];
        snprintf(more, sizeof more, "endian: little\ndata file: %s\n", outside[i]);
        write_typed("out.nhdr", type, "raw", more, NULL, 0);
        assert_refused("out.nhdr", WEFT_ERR_FORMAT, "which leads out of its folder");
    }
    write_typed("out.nhdr", type, "raw", "endian: little\ndata file: missing.raw\n", NULL, 0);
    assert_refused("out.nhdr", WEFT_ERR_OPEN, "missing.raw");
    write_typed("out.nhdr", type, "raw", "endian: little\ndata file: %s%d.raw 1 2 1\n", NULL, 0);
    assert_refused("out.nhdr", WEFT_ERR_FORMAT, "NAME%d FIRST LAST STEP");
    free(data);
}

// A header's claim and what there is stand in one line.
static void test_lies(void **state)
{
    (void)state;
    static const struct {
        const char *fields, *message;
        enum weft_result result;
    } cases[] = {
        {"type: uint8\ndimension: 3\nsizes: 100 100 100\nencoding: raw\n",
         "tells of 1000000 bytes of samples from byte 68 on", WEFT_ERR_FORMAT},
        {"type: double\ndimension: 3\nsizes: 1000000000 1000000000 1\nencoding: raw\n"
         "endian: little\n",
         "1000000000 times 8000000000 bytes of samples; the limit", WEFT_ERR_LIMIT},
        {"type: double\ndimension: 3\nsizes: 1000000 1000000 1000\nencoding: gzip\n"
         "endian: little\n",
         "8000000000000000 bytes of samples, which the", WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 3\nsizes: 4294967296 1 1\nencoding: raw\n",
         "an axis of 4294967296 samples", WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 3\nsizes: 100000 1000 1\nencoding: ascii\n", "cannot hold",
         WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspacings: 1 0 1\n", "",
         WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace dimension: 3\n"
         "space directions: (1,0,0) (2,0,0) (0,0,1)\n",
         "the transform is singular", WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 1\nsizes: 8\nencoding: raw\n", "neither a picture nor a volume",
         WEFT_ERR_UNSUPPORTED},
        {"type: block\nblock size: 3\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nendian: little\n",
         "block", WEFT_ERR_UNSUPPORTED},
        {"type: uint8\ndimension: 3\nsizes: 2 2\nencoding: raw\n", "Teem says", WEFT_ERR_FORMAT},
        {"type: uint8\ndimension: 3\nencoding: raw\n", "Teem says", WEFT_ERR_FORMAT},
    };
    unsigned char data[64] = {0};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        write_nrrd("lie.nrrd", cases[i].fields, data, sizeof data);
        assert_refused("lie.nrrd", cases[i].result, cases[i].message);
    }
    write_whole(file_path("lie.nrrd"), "NRRD0004\ntype: uint8", 20);
    assert_refused("lie.nrrd", WEFT_ERR_FORMAT, "cut short?");
    write_whole(file_path("lie.nrrd"), "what is this?", 13);
    assert_refused("lie.nrrd", WEFT_ERR_FORMAT, "neither a VDB");
    // 64 MiB of zeros in some 64 KiB: believable, and over the limit that is asked for.
    const size_t zeros = (size_t)64 << 20;
    void *big = calloc(1, zeros);
    size_t size;
    assert_non_null(big);
    unsigned char *packed = gzip(big, zeros, &size);
    write_nrrd("bomb.nrrd", "type: uint8\ndimension: 3\nsizes: 1024 1024 64\nencoding: gzip\n",
               packed, size);
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_open(weft_volume_open_params(.path = file_path("bomb.nrrd"),
                                                              .limits = {.memory_bytes = 48 << 20},
                                                              .log = &test_log),
                                      &volume),
                     WEFT_ERR_LIMIT);
    assert_non_null(strstr(last_error.message, "67108864 bytes of samples; the memory limit is"));
    free(packed);
    free(big);
}

// ---- NIfTI --------------------------------------------------------------------------------------

static const int nifti_codes[WEFT_SAMPLE_TYPE_COUNT] = {2, 256, 512, 4, 768, 8, 1280, 1024, 16, 64};

// A header is a field at a time, at its place in nifti1.h or nifti2.h.
struct nifti {
    unsigned char bytes[544];
    bool second, swapped;
};

static void put(struct nifti *n, size_t at, size_t size, const void *value)
{
    for (size_t i = 0; i < size; i++)
        n->bytes[at + (n->swapped ? size - 1 - i : i)] = ((const unsigned char *)value)[i];
}

static void put_integer(struct nifti *n, size_t at, size_t size, int64_t value)
{
    put(n, at, size, &value);
}

// A float of the first version, a double of the second.
static void put_real(struct nifti *n, size_t at, double value)
{
    const float single = (float)value;
    put(n, at, n->second ? 8 : 4, n->second ? (const void *)&value : (const void *)&single);
}

static size_t header_size(const struct nifti *n)
{
    return n->second ? 544 : 352;
}

static struct nifti make_nifti(bool second, bool swapped, enum weft_sample_type type,
                               const int dim[8])
{
    struct nifti n = {.second = second, .swapped = swapped};
    put_integer(&n, 0, 4, second ? 540 : 348);
    memcpy(n.bytes + (second ? 4 : 344), second ? "n+2\0\r\n\032\n" : "n+1", second ? 8 : 4);
    put_integer(&n, second ? 12 : 70, 2, nifti_codes[type]);
    put_integer(&n, second ? 14 : 72, 2, (int64_t)weft_sample_sizes[type] * 8);
    for (size_t i = 0; i < 8; i++) {
        put_integer(&n, second ? 16 + 8 * i : 40 + 2 * i, second ? 8 : 2, dim[i]);
        put_real(&n, second ? 104 + 8 * i : 76 + 4 * i, i ? 1.0 + (double)i : 1.0);
    }
    if (second)
        put_integer(&n, 168, 8, 544);
    else
        put_real(&n, 108, 352);
    return n;
}

static const int nifti_dim[8] = {3, NX, NY, NZ, 1, 1, 1, 1};

static void test_nifti_types(void **state)
{
    (void)state;
    for (enum weft_sample_type type = 0; type < WEFT_SAMPLE_TYPE_COUNT; type++)
        for (int kind = 0; kind < 4; kind++) {
            const struct nifti n = make_nifti(kind / 2, kind % 2, type, nifti_dim);
            size_t size, packed_size;
            unsigned char *data = make_samples(type, kind % 2, 1, &size);
            write_two("v.nii", n.bytes, header_size(&n), data, size);
            free(data);
            if (kind == 3) { // gzipped, which its name need not tell
                unsigned char *plain = read_whole(file_path("v.nii"), &size);
                unsigned char *packed = gzip(plain, size, &packed_size);
                write_whole(file_path("v.nii"), packed, packed_size);
                free(packed);
                free(plain);
            }
            weft_volume *volume = open_name("v.nii");
            const struct weft_volume_info *info = weft_volume_get_info(volume);
            assert_int_equal(info->format, WEFT_VOLUME_NIFTI);
            assert_string_equal(info->type, weft_sample_type_names[type]);
            assert_string_equal(info->name, "v");
            assert_true(info->index_to_world[1][1] == 3.0);
            assert_values(volume, whole_size, 0, 1, of_type, &type);
            weft_volume_destroy(&volume);
        }
}

static long double scaled(int i, const void *priv)
{
    const double *scale = priv;
    return scale[0] * (double)number_at(WEFT_SAMPLE_INT16, i) + scale[1];
}

static void test_nifti_scale(void **state)
{
    (void)state;
    const double scale[2] = {(float)0.075407, (float)3100.7617};
    struct nifti n = make_nifti(false, false, WEFT_SAMPLE_INT16, nifti_dim);
    put_real(&n, 112, scale[0]);
    put_real(&n, 116, scale[1]);
    put_integer(&n, 252, 2, 1); // qform: half a turn about y
    put_real(&n, 260, 1.0);
    put_real(&n, 268, 5.0);
    size_t size;
    unsigned char *data = make_samples(WEFT_SAMPLE_INT16, false, 1, &size);
    write_two("scaled.nii", n.bytes, 352, data, size);
    weft_volume *volume = open_name("scaled.nii");
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    assert_true(info->rounded);
    assert_values(volume, whole_size, 0, 1, scaled, scale);
    weft_volume_destroy(&volume);
    const double half_turn[3][4] = {{-2, 0, 0, 5}, {0, 3, 0, 0}, {0, 0, -4, 0}};
    assert_transform("scaled.nii", half_turn);
    put_integer(&n, 254, 2, 2); // sform comes first
    const double affine[3][4] = {{1, 0.5, 0, -3}, {0, 2, 0.25, 4}, {0, 0, 3, 5}};
    for (size_t r = 0; r < 3; r++)
        for (size_t c = 0; c < 4; c++)
            put_real(&n, 280 + 16 * r + 4 * c, affine[r][c]);
    write_two("scaled.nii", n.bytes, 352, data, size);
    assert_transform("scaled.nii", affine);
    // A pair: the header with another magic, samples beside it.
    memcpy(n.bytes + 344, "ni1", 4);
    put_real(&n, 108, 0);
    write_whole(file_path("pair.hdr"), n.bytes, 348);
    assert_refused("pair.hdr", WEFT_ERR_OPEN, "pair.img.gz");
    write_whole(file_path("pair.img"), data, size);
    volume = open_name("pair.hdr");
    assert_values(volume, whole_size, 0, 1, scaled, scale);
    weft_volume_destroy(&volume);
    free(data);
}

static void test_nifti_axes(void **state)
{
    (void)state;
    const enum weft_sample_type type = WEFT_SAMPLE_UINT8;
    const int vector[8] = {5, NX, NY, NZ, 1, 3, 1, 1}, times[8] = {4, NX, NY, NZ, 3, 1, 1, 1};
    size_t size;
    unsigned char *data = make_samples(type, false, 3, &size);
    struct nifti n = make_nifti(false, false, type, vector);
    put_integer(&n, 68, 2, 1007);
    write_two("vector.nii", n.bytes, 352, data, size);
    weft_volume *volume = open_with(
        (struct weft_volume_open_params){.path = file_path("vector.nii"), .component = 2});
    assert_int_equal(weft_volume_get_info(volume)->components, 3);
    assert_values(volume, whole_size, 2 * COUNT, 1, of_type, &type);
    weft_volume_destroy(&volume);
    n = make_nifti(false, false, type, times);
    write_two("times.nii", n.bytes, 352, data, size);
    volume = open_with(
        (struct weft_volume_open_params){.path = file_path("times.nii"), .grid = "times[2]"});
    assert_values(volume, whole_size, 2 * COUNT, 1, of_type, &type);
    weft_volume_destroy(&volume);
    n = make_nifti(false, false, type, nifti_dim);
    put_integer(&n, 70, 2, 128); // RGB
    put_integer(&n, 72, 2, 24);
    write_two("colours.nii", n.bytes, 352, data, size);
    volume = open_with(
        (struct weft_volume_open_params){.path = file_path("colours.nii"), .component = 1});
    assert_values(volume, whole_size, 1, 3, of_type, &type);
    weft_volume_destroy(&volume);
    n = make_nifti(true, false, type, (const int[8]){3, 30000, 30000, 30000, 1, 1, 1, 1});
    write_two("lie.nii", n.bytes, 544, data, size);
    assert_refused("lie.nii", WEFT_ERR_FORMAT, "27000000000000 bytes of samples from byte 544");
    write_whole(file_path("lie.nii"), n.bytes, 300);
    assert_refused("lie.nii", WEFT_ERR_FORMAT, "not a NIfTI header");
    free(data);
}

// ---- raw ----------------------------------------------------------------------------------------

static void test_raw(void **state)
{
    (void)state;
    for (enum weft_sample_type type = 0; type < WEFT_SAMPLE_TYPE_COUNT; type++) {
        size_t size;
        unsigned char *data = make_samples(type, type % 2, 1, &size);
        write_two("plain.raw", "12345", 5, data, size);
        free(data);
        const struct weft_raw_layout *layout =
            weft_raw_layout(.size = {NX, NY, NZ}, .type = type, .big_endian = type % 2, .skip = 5,
                            .spacing = {1, -2, 3}, .origin = {4, 5, 6});
        weft_volume *volume = NULL;
        weft_volume_opening *opening = NULL;
        struct weft_volume_open_params params = {
            .path = file_path("plain.raw"), .raw = layout, .log = &test_log};
        assert_int_equal(weft_volume_begin(&params, &opening), WEFT_OK);
        assert_int_equal(weft_volume_await(&opening, &volume), WEFT_OK);
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        assert_int_equal(info->format, WEFT_VOLUME_RAW);
        assert_true(info->index_to_world[1][1] == -2.0 && info->index_to_world[2][3] == 6.0);
        assert_values(volume, whole_size, 0, 1, of_type, &type);
        weft_volume_destroy(&volume);
    }
    weft_volume *volume = NULL;
    struct weft_raw_layout layout =
        *weft_raw_layout(.size = {NX, NY, NZ + 1}, .type = WEFT_SAMPLE_DOUBLE);
    const struct weft_volume_open_params params = {
        .path = file_path("plain.raw"), .raw = &layout, .log = &test_log};
    assert_int_equal(weft_volume_open(&params, &volume), WEFT_ERR_FORMAT);
    assert_non_null(strstr(last_error.message, "8712 bytes of samples"));
    layout.spacing[0] = 0.0; // of one axis; of all it is the default
    layout.spacing[1] = layout.spacing[2] = 1.0;
    assert_int_equal(weft_volume_open(&params, &volume), WEFT_ERR_ARGUMENT);
}

// What floats lack of integers and doubles: both together are exact.
static void test_rest(void **state)
{
    (void)state;
    static const enum weft_sample_type types[] = {WEFT_SAMPLE_INT64, WEFT_SAMPLE_UINT32,
                                                  WEFT_SAMPLE_INT32};
    for (size_t t = 0; t < WEFT_COUNT(types); t++) {
        size_t size;
        unsigned char *data = make_samples(types[t], false, 1, &size);
        write_whole(file_path("rest.raw"), data, size);
        free(data);
        float values[2][512];
        for (int rest = 0; rest < 2; rest++) {
            weft_volume *volume = open_with((struct weft_volume_open_params){
                .path = file_path("rest.raw"),
                .raw = weft_raw_layout(.size = {NX, NY, NZ}, .type = types[t]),
                .rest = rest});
            const int32_t origin[1][3] = {{0, 0, 0}};
            assert_int_equal(weft_volume_read(volume, 1, origin, values[rest]), WEFT_OK);
            weft_volume_destroy(&volume);
        }
        for (int x = 0; x < 8; x++)
            assert_true((long double)values[0][x] + values[1][x] == number_at(types[t], x));
    }
}

// ---- data ---------------------------------------------------------------------------------------

static float voxel(const char *path, const char *grid, int x, int y, int z)
{
    weft_volume *volume = open_with((struct weft_volume_open_params){.path = path, .grid = grid});
    float values[512];
    const int32_t origin[1][3] = {{x & ~7, y & ~7, z & ~7}};
    assert_int_equal(weft_volume_read(volume, 1, origin, values), WEFT_OK);
    weft_volume_destroy(&volume);
    return values[(z & 7) << 6 | (y & 7) << 3 | (x & 7)];
}

struct ball {
    const unsigned char *data;
};

static long double of_ball(int i, const void *priv)
{
    const unsigned char *at = ((const struct ball *)priv)->data + 2 * i;
    return (int16_t)(at[0] | at[1] << 8);
}

// The ball in all encodings is the raw file's; the anatomy is stored from the highest byte on.
static void test_data(void **state)
{
    (void)state;
    static const char *const balls[] = {".nrrd", "_gz.nrrd", "_bz2.nrrd", ".nhdr",
                                        "_byteskip_minus_one.nhdr"};
    size_t size;
    char path[512];
    unsigned char *data = read_whole(WEFT_TEST_DATA "/nrrd/BallBinary30x30x30.raw", &size);
    if (!data)
        skip();
    const struct ball ball = {data};
    for (size_t i = 0; i < WEFT_COUNT(balls); i++) {
        snprintf(path, sizeof path, WEFT_TEST_DATA "/nrrd/BallBinary30x30x30%s", balls[i]);
        weft_volume *volume = open_with((struct weft_volume_open_params){.path = path});
        assert_values(volume, (const int[3]){30, 30, 30}, 0, 1, of_ball, &ball);
        weft_volume_destroy(&volume);
    }
    free(data);
    data = read_whole(WEFT_TEST_DATA "/nifti/anatomical.nii", &size);
    assert_non_null(data);
    const size_t at = 352 + 2 * (size_t)((12 * 41 + 20) * 33 + 16); // its vox_offset; 33 x 41 x 25
    assert_true(voxel(WEFT_TEST_DATA "/nifti/anatomical.nii", NULL, 16, 20, 12) ==
                (float)(int16_t)(data[at] << 8 | data[at + 1]));
    free(data);
    data = read_whole(WEFT_TEST_DATA "/nifti/functional.nii", &size);
    assert_non_null(data);
    float scale[2];
    memcpy(scale, data + 112, sizeof scale);
    const size_t there = 352 + 2 * (size_t)(((3 * 3 + 1) * 21 + 10) * 17 + 8);
    const double expected =
        (double)scale[0] * (int16_t)(data[there] | data[there + 1] << 8) + (double)scale[1];
    assert_true(voxel(WEFT_TEST_DATA "/nifti/functional.nii", "functional[3]", 8, 10, 1) ==
                (float)expected);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types),       cmocka_unit_test(test_text),
        cmocka_unit_test(test_orientation), cmocka_unit_test(test_other_axes),
        cmocka_unit_test(test_detached),    cmocka_unit_test(test_lies),
        cmocka_unit_test(test_nifti_types), cmocka_unit_test(test_nifti_scale),
        cmocka_unit_test(test_nifti_axes),  cmocka_unit_test(test_raw),
        cmocka_unit_test(test_rest),        cmocka_unit_test(test_data),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
