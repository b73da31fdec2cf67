// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_header.h"

#include <algorithm>
#include <cstdio>

namespace weft
{

namespace
{

// ---- metadata -----------------------------------------------------------------------------------

enum class Number { boolean, int32, int64, float32, float64 };

// OpenVDB's types of numbers, in rows of `columns`; a text has no fixed size, and is not here.
struct NumberType {
    const char *name;
    Number number;
    int rows, columns; // of a scalar both are 0
};

constexpr NumberType number_types[] = {
    {"bool", Number::boolean, 0, 0},   {"int32", Number::int32, 0, 0},
    {"int64", Number::int64, 0, 0},    {"float", Number::float32, 0, 0},
    {"double", Number::float64, 0, 0}, {"vec2i", Number::int32, 1, 2},
    {"vec3i", Number::int32, 1, 3},    {"vec4i", Number::int32, 1, 4},
    {"vec2s", Number::float32, 1, 2},  {"vec3s", Number::float32, 1, 3},
    {"vec4s", Number::float32, 1, 4},  {"vec2d", Number::float64, 1, 2},
    {"vec3d", Number::float64, 1, 3},  {"vec4d", Number::float64, 1, 4},
    {"mat4s", Number::float32, 4, 4},  {"mat4d", Number::float64, 4, 4},
};

const NumberType *find_type(const std::string &name)
{
    for (const NumberType &type : number_types)
        if (name == type.name)
            return &type;
    return nullptr;
}

size_t size_of(Number number)
{
    return number == Number::boolean                              ? 1
           : number == Number::int32 || number == Number::float32 ? 4
                                                                  : 8;
}

void check_size(const MetadataEntry &entry)
{
    const NumberType *type = find_type(entry.type);
    if (!type)
        return;
    const size_t count = type->rows ? static_cast<size_t>(type->rows * type->columns) : 1;
    if (entry.value.size() != count * size_of(type->number))
        fail(WEFT_ERR_FORMAT, "metadata '%.64s' of the type %.32s has %zu bytes", entry.key.c_str(),
             entry.type.c_str(), entry.value.size());
}

template <class T> T value_at(const std::string &bytes, size_t index)
{
    T value;
    memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
    return value;
}

// Matrices have six digits behind the point, all others six in all.
std::string number_text(const std::string &bytes, size_t index, const NumberType &type)
{
    const char *format = type.rows > 1 ? "%f" : "%g";
    char text[400];
    switch (type.number) {
    case Number::boolean:
        return bytes[index] ? "true" : "false";
    case Number::int32:
        return std::to_string(value_at<int32_t>(bytes, index));
    case Number::int64:
        return std::to_string(value_at<int64_t>(bytes, index));
    case Number::float32:
        snprintf(text, sizeof text, format, static_cast<double>(value_at<float>(bytes, index)));
        return text;
    default:
        snprintf(text, sizeof text, format, value_at<double>(bytes, index));
        return text;
    }
}

std::string row_text(const std::string &bytes, int row, const NumberType &type)
{
    std::string text = "[";
    for (int i = 0; i < type.columns; i++)
        text +=
            (i ? ", " : "") + number_text(bytes, static_cast<size_t>(row * type.columns + i), type);
    return text + "]";
}

// The last entry of a key holds, and has the type of those before.
std::vector<MetadataEntry> sort_entries(std::vector<MetadataEntry> entries)
{
    std::stable_sort(entries.begin(), entries.end(),
                     [](const MetadataEntry &a, const MetadataEntry &b) { return a.key < b.key; });
    std::vector<MetadataEntry> sorted;
    for (MetadataEntry &entry : entries) {
        if (entry.key.empty())
            fail(WEFT_ERR_FORMAT, "metadata without a name");
        if (sorted.empty() || sorted.back().key != entry.key) {
            sorted.push_back(std::move(entry));
            continue;
        }
        if (sorted.back().type != entry.type)
            fail(WEFT_ERR_FORMAT, "metadata '%.64s' is of two types, %.32s and %.32s",
                 entry.key.c_str(), sorted.back().type.c_str(), entry.type.c_str());
        sorted.back().value = std::move(entry.value);
    }
    return sorted;
}

// ---- transforms ---------------------------------------------------------------------------------

using Matrix = double[3][4];

void set_scale(const double scale[3], Matrix m)
{
    for (int i = 0; i < 3; i++)
        m[i][i] = scale[i];
}

void set_translation(const double translation[3], Matrix m)
{
    for (int i = 0; i < 3; i++)
        m[i][3] = translation[i];
}

// 16 numbers: the images of i, j and k, and of the origin, a row each.
void read_affine(Cursor &cursor, Matrix m)
{
    double rows[4][4];
    cursor.get(rows, sizeof rows);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            m[r][c] = rows[c][r];
}

// What follows is derived from these: the voxel size, and inverses.
void read_scale(Cursor &cursor, Matrix m)
{
    double scale[3];
    cursor.get(scale, sizeof scale);
    cursor.skip(4 * sizeof scale);
    set_scale(scale, m);
}

void read_translation(Cursor &cursor, Matrix m)
{
    double translation[3];
    const double ones[3] = {1, 1, 1};
    cursor.get(translation, sizeof translation);
    set_scale(ones, m);
    set_translation(translation, m);
}

void read_scale_translation(Cursor &cursor, Matrix m)
{
    double translation[3];
    cursor.get(translation, sizeof translation);
    read_scale(cursor, m);
    set_translation(translation, m);
}

constexpr struct {
    const char *name;
    void (*read)(Cursor &cursor, Matrix m);
} maps[] = {
    {"AffineMap", read_affine},
    {"UnitaryMap", read_affine},
    {"ScaleMap", read_scale},
    {"UniformScaleMap", read_scale},
    {"TranslationMap", read_translation},
    {"ScaleTranslateMap", read_scale_translation},
    {"UniformScaleTranslateMap", read_scale_translation},
};

} // namespace

GridHeader read_header(const Mapping &file, const GridEntry &grid)
{
    GridHeader header;
    std::vector<MetadataEntry> entries;
    Cursor cursor(file, grid.starts, grid.ends);
    header.compression = cursor.get<uint32_t>();
    for (uint32_t count = cursor.get<uint32_t>(); count; count--) {
        MetadataEntry entry;
        entry.key = cursor.get_string();
        entry.type = cursor.get_string();
        entry.value = cursor.get_string();
        check_size(entry);
        if (entry.type == "__delayedload")
            header.delayed = std::move(entry.value);
        else
            entries.push_back(std::move(entry));
    }
    header.metadata = sort_entries(std::move(entries));
    header.transform = cursor.at();
    return header;
}

std::string metadata_text(const MetadataEntry &entry)
{
    if (entry.type == "string")
        return entry.value;
    const NumberType *type = find_type(entry.type);
    if (!type)
        return entry.value.empty() ? "" : "<binary data>";
    if (!type->rows)
        return number_text(entry.value, 0, *type);
    std::string text;
    for (int row = 0; row < type->rows; row++)
        text += (row ? ",\n " : "") + row_text(entry.value, row, *type);
    return type->rows > 1 ? "[" + text + "]" : text;
}

const MetadataEntry *find_metadata(const GridHeader &header, const char *key, const char *type)
{
    for (const MetadataEntry &entry : header.metadata)
        if (entry.key == key && entry.type == type)
            return &entry;
    return nullptr;
}

Transform read_transform(const Mapping &file, const GridEntry &grid, const GridHeader &header)
{
    Transform transform = {};
    Cursor cursor(file, header.transform, grid.ends);
    const std::string name = cursor.get_string();
    if (name == "NonlinearFrustumMap")
        return transform;
    transform.affine = true;
    for (const auto &map : maps) {
        if (name != map.name)
            continue;
        map.read(cursor, transform.index_to_world);
        transform.ends = cursor.at();
        return transform;
    }
    fail(WEFT_ERR_FORMAT, "the transform is of an unknown kind, '%.64s'", name.c_str());
}

} // namespace weft
