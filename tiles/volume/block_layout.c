// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/block_layout.h"

#include <float.h>
#include <math.h>
#include <string.h>

const char *const weft_layout_names[] = {"auto", "interleaved", "aligned", "plain", NULL};
const char *const weft_source_format_names[] = {"32f", "16f", "unorm16", "unorm8", NULL};

const char *weft_layout_name(enum weft_layout layout)
{
    return weft_name(weft_layout_names, (unsigned)layout);
}

int weft_layout_row_fetches(enum weft_layout kind, int width)
{
    switch (kind) {
    case WEFT_LAYOUT_INTERLEAVED:
        return (width + 3) / 4;
    case WEFT_LAYOUT_ALIGNED:
        return (width + 3 + 3) / 4; // the row may begin at any of a texel's four samples
    default:
        return width;
    }
}

void weft_block_layout_init(struct weft_block_layout *layout, enum weft_layout kind,
                            enum weft_source_format format, const int taps[3], const int starts[3])
{
    // Aligned rows begin at the cell's own start, whose samples are multiples of four apart.
    int starts_x = kind == WEFT_LAYOUT_ALIGNED ? WEFT_BRICK_SIZE : starts[0];
    int samples = kind == WEFT_LAYOUT_PLAIN ? 1 : 4;
    *layout = (struct weft_block_layout){
        .kind = kind,
        .format = format,
        .taps = {taps[0], taps[1], taps[2]},
        .span = {starts_x + taps[0] - 1, starts[1] + taps[1] - 1, starts[2] + taps[2] - 1},
        .texel_bytes = (size_t)(samples * weft_source_format_bytes(format)),
    };
    int fetches = weft_layout_row_fetches(kind, taps[0]);
    switch (kind) {
    case WEFT_LAYOUT_INTERLEAVED:
        layout->row_texels = starts_x + 4 * (fetches - 1);
        break;
    case WEFT_LAYOUT_ALIGNED:
        layout->row_texels = (WEFT_BRICK_SIZE - 1) / 4 + fetches;
        break;
    default:
        layout->row_texels = layout->span[0];
    }
    layout->block_texels =
        (size_t)layout->row_texels * (size_t)layout->span[1] * (size_t)layout->span[2];
}

size_t weft_block_layout_offset(const struct weft_block_layout *layout, const int start[3])
{
    int x = layout->kind == WEFT_LAYOUT_ALIGNED ? start[0] / 4 : start[0];
    return ((size_t)start[2] * (size_t)layout->span[1] + (size_t)start[1]) *
               (size_t)layout->row_texels +
           (size_t)x;
}

// ---- formats ------------------------------------------------------------------------------------

static const struct {
    int bytes;
    double error;
} formats[WEFT_SOURCE_FORMATS] = {
    [WEFT_SOURCE_FLOAT] = {4, 0.0},
    // Halves in [1/2, 1] are 2^-11 apart, and 1 stands for half the width. Mapped in single
    // precision: 2^-23 more, in all.
    [WEFT_SOURCE_HALF] = {2, 0x1p-13 + 0x1p-23},
    [WEFT_SOURCE_UNORM16] = {2, 0.5 / 65535 + 0x1p-23},
    [WEFT_SOURCE_UNORM8] = {1, 0.5 / 255 + 0x1p-23},
};

const char *weft_source_format_name(enum weft_source_format format)
{
    return weft_name(weft_source_format_names, (unsigned)format);
}

int weft_source_format_bytes(enum weft_source_format format)
{
    return (size_t)format < WEFT_COUNT(formats) ? formats[format].bytes : 0;
}

double weft_source_format_error(enum weft_source_format format)
{
    return (size_t)format < WEFT_COUNT(formats) ? formats[format].error : (double)NAN;
}

bool weft_source_format_holds(enum weft_source_format format, const struct weft_source_range *range)
{
    const double most = 1e37; // so that widths and sums of a range are single precision too
    return format == WEFT_SOURCE_FLOAT || (range->high - range->low >= FLT_MIN &&
                                           fabs(range->low) <= most && fabs(range->high) <= most);
}

void weft_source_range_mapping(enum weft_source_format format,
                               const struct weft_source_range *range, double *scale, double *offset)
{
    double width = range->high - range->low;
    *scale = format == WEFT_SOURCE_HALF ? 0.5 * width : width;
    *offset = format == WEFT_SOURCE_HALF ? range->low + 0.5 * width : range->low;
}

static float clamped(float value, float least)
{
    return value < least ? least : value > 1.0f ? 1.0f : value; // NaN stays
}

static void encode_unorm8(const float *values, int count, float scale, float offset, void *out)
{
    uint8_t *q = out;
    for (int i = 0; i < count; i++)
        q[i] = (uint8_t)(int)(clamped((values[i] - offset) * scale, 0.0f) * 255.0f + 0.5f);
}

static void encode_unorm16(const float *values, int count, float scale, float offset, void *out)
{
    uint16_t *q = out;
    for (int i = 0; i < count; i++)
        q[i] = (uint16_t)(int)(clamped((values[i] - offset) * scale, 0.0f) * 65535.0f + 0.5f);
}

// To nearest even, of |x| <= 1 or NaN. Adding a number whose last bit weighs as much as a half's
// rounds subnormals.
static uint16_t half_from(float x)
{
    union {
        float f;
        uint32_t u;
    } v = {.f = x}, small;
    uint32_t sign = v.u >> 16 & 0x8000u, magnitude = v.u & 0x7fffffffu;
    if (magnitude > 0x7f800000u)
        return (uint16_t)(sign | 0x7e00u);
    if (magnitude < 0x38800000u) {
        small.u = magnitude;
        small.f += 0.5f;
        return (uint16_t)(sign | (small.u - 0x3f000000u));
    }
    magnitude += 0xfffu + (magnitude >> 13 & 1u);
    return (uint16_t)(sign | ((magnitude - 0x38000000u) >> 13));
}

static void encode_half(const float *values, int count, float scale, float offset, void *out)
{
    uint16_t *q = out;
    for (int i = 0; i < count; i++)
        q[i] = half_from(clamped((values[i] - offset) * scale, -1.0f));
}

static void encode(const struct weft_block_layout *layout, const struct weft_source_range *range,
                   const float *values, int count, void *out)
{
    double scale, offset;
    if (layout->format == WEFT_SOURCE_FLOAT) {
        memcpy(out, values, (size_t)count * sizeof *values);
        return;
    }
    weft_source_range_mapping(layout->format, range, &scale, &offset);
    float reciprocal = scale > 0.0 ? (float)(1.0 / scale) : 0.0f, from = (float)offset;
    if (layout->format == WEFT_SOURCE_HALF)
        encode_half(values, count, reciprocal, from, out);
    else if (layout->format == WEFT_SOURCE_UNORM16)
        encode_unorm16(values, count, reciprocal, from, out);
    else
        encode_unorm8(values, count, reciprocal, from, out);
}

// Texel i is samples i to i + 3. Moves of a size that is known are one instruction each.
static void interleave(const char *code, size_t sample, size_t count, char *out)
{
    if (sample == 4)
        for (size_t i = 0; i < count; i++)
            memcpy(out + 16 * i, code + 4 * i, 16);
    else if (sample == 2)
        for (size_t i = 0; i < count; i++)
            memcpy(out + 8 * i, code + 2 * i, 8);
    else
        for (size_t i = 0; i < count; i++)
            memcpy(out + 4 * i, code + i, 4);
}

void weft_block_layout_write(const struct weft_block_layout *layout,
                             const struct weft_source_range *range, const float *voxels,
                             void *texels)
{
    enum { MAX_ROW = 64 };
    float row[MAX_ROW] = {0}; // zeros past the span
    size_t sample = (size_t)weft_source_format_bytes(layout->format);
    char *out = texels, *code = (char *)row;
    size_t rows = (size_t)layout->span[1] * (size_t)layout->span[2];
    size_t span = (size_t)layout->span[0], row_texels = (size_t)layout->row_texels;
    for (size_t r = 0; r < rows; r++, voxels += span) {
        encode(layout, range, voxels, layout->span[0], row);
        if (layout->kind == WEFT_LAYOUT_INTERLEAVED) {
            interleave(code, sample, row_texels, out);
            out += row_texels * 4 * sample;
        } else {
            memcpy(out, row, row_texels * layout->texel_bytes);
            out += row_texels * layout->texel_bytes;
        }
    }
}

static int32_t brick_start(int32_t voxel)
{
    return voxel & ~(WEFT_BRICK_SIZE - 1);
}

// The part of a box that lies in the brick at `origin`: from[a] to to[a], exclusive, box-relative.
static void clip_to_brick(const int32_t min[3], const int size[3], const int32_t origin[3],
                          int from[3], int to[3])
{
    for (int a = 0; a < 3; a++) {
        from[a] = origin[a] < min[a] ? 0 : origin[a] - min[a];
        to[a] = origin[a] + WEFT_BRICK_SIZE - min[a];
        if (to[a] > size[a])
            to[a] = size[a];
    }
}

// By what is remembered, if anything may be.
static struct weft_found_brick find_brick(const weft_brick_store *store, const int32_t origin[3],
                                          struct weft_brick_memo *memo)
{
    const uint32_t x = (uint32_t)(origin[0] >> 3), y = (uint32_t)(origin[1] >> 3),
                   z = (uint32_t)(origin[2] >> 3);
    const uint32_t place = (x + 9 * y + 83 * z) % WEFT_BRICK_MEMO;
    struct weft_found_brick found, *known = memo ? &memo->brick[place] : NULL;
    if (known && known->valid && memcmp(known->origin, origin, sizeof known->origin) == 0)
        return *known;
    found.valid = true;
    memcpy(found.origin, origin, sizeof found.origin);
    found.kind = weft_brick_store_find(store, origin, &found.values, &found.constant);
    if (known)
        *known = found;
    return found;
}

// A few floats: of what sizes there are the compiler makes a move or two of each.
static inline void copy_few(float *out, const float *in, int count)
{
    switch (count) {
#define FEW(n)                                                                                     \
    case n:                                                                                        \
        memcpy(out, in, n * sizeof *out);                                                          \
        return;
        FEW(1)
        FEW(2) FEW(3) FEW(4) FEW(5) FEW(6) FEW(7) FEW(8)
#undef FEW
            default : return;
    }
}

static void copy_brick(const weft_brick_store *store, const struct weft_found_brick *brick,
                       const int32_t min[3], const int size[3], const int pitch[3], float *out)
{
    float scratch[WEFT_BRICK_VOXELS];
    const int32_t *origin = brick->origin;
    const float *values = brick->values;
    int from[3], to[3];
    clip_to_brick(min, size, origin, from, to);
    if (brick->kind == WEFT_BRICK_EDGE) {
        weft_brick_store_copy(store, origin, scratch);
        values = scratch;
    }
    for (int z = from[2]; z < to[2]; z++) {
        for (int y = from[1]; y < to[1]; y++) {
            float *row = out + (z * pitch[1] + y) * pitch[0];
            if (brick->kind == WEFT_BRICK_CONSTANT) {
                for (int x = from[0]; x < to[0]; x++)
                    row[x] = brick->constant;
                continue;
            }
            int32_t line = ((min[2] + z - origin[2]) * WEFT_BRICK_SIZE + min[1] + y - origin[1]) *
                               WEFT_BRICK_SIZE +
                           min[0] + from[0] - origin[0];
            copy_few(row + from[0], values + line, to[0] - from[0]);
        }
    }
}

void weft_brick_store_copy_box(const weft_brick_store *store, const int32_t min[3],
                               const int size[3], const int pitch[3], struct weft_brick_memo *memo,
                               float *out)
{
    int32_t at[3];
    for (at[2] = brick_start(min[2]); at[2] < min[2] + size[2]; at[2] += WEFT_BRICK_SIZE)
        for (at[1] = brick_start(min[1]); at[1] < min[1] + size[1]; at[1] += WEFT_BRICK_SIZE)
            for (at[0] = brick_start(min[0]); at[0] < min[0] + size[0]; at[0] += WEFT_BRICK_SIZE) {
                const struct weft_found_brick brick = find_brick(store, at, memo);
                copy_brick(store, &brick, min, size, pitch, out);
            }
}

// Where the rows of a brick's voxels are; a constant one has one row.
struct rows {
    const float *at;
    int pitch[2]; // floats from row to row, and from slice to slice
};

enum { NEIGHBOURS = 3 };

// The 27 bricks around an origin. false: one is partly outside a clamp box.
static bool find_rows(const weft_brick_store *store, const int32_t origin[3],
                      float constants[NEIGHBOURS * NEIGHBOURS * NEIGHBOURS][WEFT_BRICK_SIZE],
                      struct rows rows[NEIGHBOURS * NEIGHBOURS * NEIGHBOURS])
{
    for (int n = 0; n < NEIGHBOURS * NEIGHBOURS * NEIGHBOURS; n++) {
        const int32_t at[3] = {origin[0] + (n % 3 - 1) * WEFT_BRICK_SIZE,
                               origin[1] + (n / 3 % 3 - 1) * WEFT_BRICK_SIZE,
                               origin[2] + (n / 9 - 1) * WEFT_BRICK_SIZE};
        const float *values;
        float constant;
        const enum weft_brick_kind kind = weft_brick_store_find(store, at, &values, &constant);
        if (kind == WEFT_BRICK_EDGE)
            return false;
        if (kind == WEFT_BRICK_VALUES) {
            rows[n] = (struct rows){values, {WEFT_BRICK_SIZE, WEFT_BRICK_SIZE * WEFT_BRICK_SIZE}};
            continue;
        }
        for (int i = 0; i < WEFT_BRICK_SIZE; i++)
            constants[n][i] = constant;
        rows[n] = (struct rows){constants[n], {0, 0}};
    }
    return true;
}

// Row (y, z) of a brick, which voxel i of the block's axis is in: counted from brick 0's first.
static const float *row_of(const struct rows *rows, int y, int z)
{
    return rows->at + (y & 7) * rows->pitch[0] + (z & 7) * rows->pitch[1];
}

void weft_brick_store_copy_block(const weft_brick_store *store, const int32_t origin[3], int before,
                                 int after, float *out)
{
    float constants[NEIGHBOURS * NEIGHBOURS * NEIGHBOURS][WEFT_BRICK_SIZE];
    struct rows rows[NEIGHBOURS * NEIGHBOURS * NEIGHBOURS];
    const int size = before + WEFT_BRICK_SIZE + after, first = WEFT_BRICK_SIZE - before;
    if (!find_rows(store, origin, constants, rows)) {
        const int32_t min[3] = {origin[0] - before, origin[1] - before, origin[2] - before};
        const int sizes[3] = {size, size, size};
        weft_brick_store_copy_box(store, min, sizes, sizes, NULL, out);
        return;
    }
    for (int z = first; z < first + size; z++) {
        for (int y = first; y < first + size; y++, out += size) {
            const struct rows *line = &rows[z / 8 * 9 + y / 8 * 3];
            const float *left = row_of(&line[0], y, z) + first, *right = row_of(&line[2], y, z);
            for (int x = 0; x < before; x++)
                out[x] = left[x];
            memcpy(out + before, row_of(&line[1], y, z), WEFT_BRICK_SIZE * sizeof *out);
            for (int x = 0; x < after; x++)
                out[before + WEFT_BRICK_SIZE + x] = right[x];
        }
    }
}

bool weft_brick_store_box_constant(const weft_brick_store *store, const int32_t min[3],
                                   const int32_t max[3], float *constant)
{
    bool first = true;
    int32_t at[3];
    for (at[2] = brick_start(min[2]); at[2] <= max[2]; at[2] += WEFT_BRICK_SIZE) {
        for (at[1] = brick_start(min[1]); at[1] <= max[1]; at[1] += WEFT_BRICK_SIZE) {
            for (at[0] = brick_start(min[0]); at[0] <= max[0]; at[0] += WEFT_BRICK_SIZE) {
                const float *values;
                float value;
                if (weft_brick_store_find(store, at, &values, &value) != WEFT_BRICK_CONSTANT)
                    return false;
                // Bits, so that NaN equals itself and -0 stays apart from 0.
                if (!first && memcmp(&value, constant, sizeof value) != 0)
                    return false;
                *constant = value;
                first = false;
            }
        }
    }
    return true;
}
