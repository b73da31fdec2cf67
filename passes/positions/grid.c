// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/grid.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"

// A block's positions are within 2 * 255 steps of its first: with these, 62 bits hold them.
enum { FRACTION_BITS = 40, MAX_STEP = 2048, COARSE_FRACTION_BITS = 31 };

// ---- small vectors ------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static bool all_finite(const double v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

// Scaled to length 1, which is returned; by hypot, since squares overflow where lengths do not.
static double normalise(const double v[3], double out[3])
{
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    for (int a = 0; a < 3; a++)
        out[a] = v[a] / length;
    return length;
}

// The sine of the angle between two vectors; NaN where one has no length.
static double sine(const double u[3], const double v[3])
{
    double unit_u[3], unit_v[3], normal[3];
    normalise(u, unit_u);
    normalise(v, unit_v);
    cross(unit_u, unit_v, normal);
    return sqrt(dot(normal, normal));
}

bool weft_affine_invert(const double m[3][4], double out[3][4])
{
    double row[3][3];
    for (int r = 0; r < 3; r++)
        memcpy(row[r], m[r], sizeof row[r]);
    double cofactor[3][3];
    for (int r = 0; r < 3; r++)
        cross(row[(r + 1) % 3], row[(r + 2) % 3], cofactor[r]);
    double determinant = dot(row[0], cofactor[0]);
    if (determinant == 0.0 || !isfinite(1.0 / determinant))
        return false;
    for (int r = 0; r < 3; r++) {
        out[r][3] = 0.0;
        for (int c = 0; c < 3; c++) {
            out[r][c] = cofactor[c][r] / determinant;
            out[r][3] -= out[r][c] * m[c][3];
        }
    }
    return true;
}

static void transform(const double m[3][4], const double v[3], bool point, double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = dot(m[r], v) + (point ? m[r][3] : 0.0);
}

// ---- requests -----------------------------------------------------------------------------------

static enum weft_result check_geometry(const struct weft_log *log,
                                       const struct weft_slice_geometry *g)
{
    if (g->width < 1 || g->height < 1 || g->width > WEFT_SLICE_MAX_SIZE ||
        g->height > WEFT_SLICE_MAX_SIZE) {
        weft_error(log, "a slice of %d x %d pixels: each side must be 1 to %d", g->width, g->height,
                   WEFT_SLICE_MAX_SIZE);
        return WEFT_ERR_ARGUMENT;
    }
    if ((int64_t)g->width * g->height > WEFT_SLICE_MAX_PIXELS) {
        weft_error(log, "a slice of %d x %d pixels: there must be at most %lld in all", g->width,
                   g->height, (long long)WEFT_SLICE_MAX_PIXELS);
        return WEFT_ERR_ARGUMENT;
    }
    if (!all_finite(g->origin) || !all_finite(g->u) || !all_finite(g->v)) {
        weft_error(log,
                   "the slice's geometry is not finite: origin (%g, %g, %g), u (%g, %g, %g), "
                   "v (%g, %g, %g)",
                   g->origin[0], g->origin[1], g->origin[2], g->u[0], g->u[1], g->u[2], g->v[0],
                   g->v[1], g->v[2]);
        return WEFT_ERR_ARGUMENT;
    }
    if (!(sine(g->u, g->v) > 1e-9)) {
        weft_error(log,
                   "the edge vectors u (%g, %g, %g) and v (%g, %g, %g) span no plane: zero or "
                   "parallel",
                   g->u[0], g->u[1], g->u[2], g->v[0], g->v[1], g->v[2]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// Every corner within the index limit, with room for any kernel.
static enum weft_result check_range(const struct weft_log *log, const struct weft_slice_geometry *g)
{
    const double limit = WEFT_INDEX_LIMIT - 64.0;
    for (int corner = 0; corner < 4; corner++) {
        for (int a = 0; a < 3; a++) {
            double at = g->origin[a] + (corner & 1 ? g->u[a] : 0) + (corner & 2 ? g->v[a] : 0);
            if (!(fabs(at) <= limit)) {
                weft_error(log,
                           "the slice reaches index coordinate %g along %c; the limit is +-%.0f",
                           at, "xyz"[a], limit);
                return WEFT_ERR_LIMIT;
            }
        }
    }
    return WEFT_OK;
}

static void set_steps(struct weft_slice_grid *grid)
{
    const struct weft_slice_geometry *g = &grid->index;
    double longest = 0.0;
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, fmax(fabs(g->u[a]) / g->width, fabs(g->v[a]) / g->height));
    grid->fraction_bits = longest <= MAX_STEP ? FRACTION_BITS : COARSE_FRACTION_BITS;
    for (int a = 0; a < 3; a++) {
        // A step is used only where there is a second pixel; it then fits, by check_range.
        double du = g->width > 1 ? g->u[a] / g->width : 0.0;
        double dv = g->height > 1 ? g->v[a] / g->height : 0.0;
        grid->du[a] = llround(ldexp(du, grid->fraction_bits));
        grid->dv[a] = llround(ldexp(dv, grid->fraction_bits));
    }
}

enum weft_result weft_slice_grid_create(const struct weft_log *log,
                                        const struct weft_slice_geometry *g, enum weft_space space,
                                        int taps, const struct weft_volume_info *info,
                                        struct weft_slice_grid *out)
{
    enum weft_result res = check_geometry(log, g);
    if (res != WEFT_OK)
        return res;
    *out = (struct weft_slice_grid){.index = *g};
    if (space == WEFT_SPACE_WORLD) {
        double inverse[3][4];
        if (!weft_affine_invert(info->index_to_world, inverse)) {
            weft_error(log, "grid %s has a transform without an inverse", info->name);
            return WEFT_ERR_FORMAT;
        }
        transform(inverse, g->origin, true, out->index.origin);
        transform(inverse, g->u, false, out->index.u);
        transform(inverse, g->v, false, out->index.v);
        if (!(sine(out->index.u, out->index.v) > 1e-12)) {
            weft_error(log,
                       "grid %s has a transform that leaves no plane of the slice: edges (%g, %g, "
                       "%g) and (%g, %g, %g) in index space",
                       info->name, out->index.u[0], out->index.u[1], out->index.u[2],
                       out->index.v[0], out->index.v[1], out->index.v[2]);
            return WEFT_ERR_FORMAT;
        }
    }
    res = check_range(log, &out->index);
    if (res != WEFT_OK)
        return res;
    out->tap_shift = taps % 2 ? 0.5 : 0.0;
    out->tap_offset = taps % 2 ? (taps - 1) / 2 : taps / 2 - 1;
    set_steps(out);
    return WEFT_OK;
}

// ---- positions ----------------------------------------------------------------------------------

// From the origin to a pixel: a product before its quotient, so that whole ratios are exact.
static void offset_of(const struct weft_slice_grid *grid, int x, int y, double offset[3])
{
    const struct weft_slice_geometry *g = &grid->index;
    for (int a = 0; a < 3; a++)
        offset[a] = (x + 0.5) * g->u[a] / g->width + (y + 0.5) * g->v[a] / g->height;
}

void weft_slice_grid_position(const struct weft_slice_grid *grid, int x, int y,
                              const double moved[3], double position[3])
{
    offset_of(grid, x, y, position);
    for (int a = 0; a < 3; a++) {
        const double at = grid->index.origin[a] + position[a], whole = floor(at);
        const double rest = (at - whole) + (moved ? moved[a] : 0.0);
        const double units = floor(ldexp(rest, WEFT_GRID_WORD_FRACTION_BITS) + 0.5);
        position[a] = whole + ldexp(units, -WEFT_GRID_WORD_FRACTION_BITS);
    }
}

double weft_slice_grid_margin(const struct weft_slice_grid *grid, const double position[3])
{
    const double largest = fmax(fabs(position[0]), fmax(fabs(position[1]), fabs(position[2])));
    return ldexp(512.0, -grid->fraction_bits - 1) + 0x1p-50 * largest;
}

void weft_slice_grid_block(const struct weft_slice_grid *grid, int bx, int by,
                           struct weft_slice_block *out)
{
    const double half_unit = ldexp(0.5, -WEFT_GRID_WORD_FRACTION_BITS);
    double offset[3];
    offset_of(grid, bx * WEFT_GRID_BLOCK, by * WEFT_GRID_BLOCK, offset);
    for (int a = 0; a < 3; a++) {
        const double origin = grid->index.origin[a];
        out->base[a] = (int32_t)(8.0 * floor((origin + offset[a]) / 8.0));
        // The difference is exact where both are large.
        const double at = (origin - out->base[a]) + offset[a] + grid->tap_shift + half_unit;
        out->position[a] = (int64_t)floor(ldexp(at, grid->fraction_bits) + 0.5);
    }
}

void weft_slice_grid_pixel(const struct weft_slice_grid *grid, const struct weft_slice_block *block,
                           int x, int y, int32_t whole[3], double fraction[3])
{
    const int low_bits = grid->fraction_bits - WEFT_GRID_WORD_FRACTION_BITS;
    const int dx = x % WEFT_GRID_BLOCK, dy = y % WEFT_GRID_BLOCK;
    for (int a = 0; a < 3; a++) {
        const int64_t at = block->position[a] + dx * grid->du[a] + dy * grid->dv[a];
        const int64_t units = at >> low_bits, one = INT64_C(1) << WEFT_GRID_WORD_FRACTION_BITS;
        whole[a] = (int32_t)(block->base[a] + (units >> WEFT_GRID_WORD_FRACTION_BITS));
        fraction[a] = (double)(units & (one - 1)) / (double)one;
    }
}

static void set_slab(const double normal[3], const double point[3], double low, double high,
                     double reach, struct weft_slab *slab)
{
    double at = dot(normal, point);
    // Taps lie up to `reach` voxels away along each axis; a little more covers all rounding.
    double margin = (reach + 1e-3) * (fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]));
    memcpy(slab->normal, normal, sizeof slab->normal);
    slab->lower = at + low - margin;
    slab->upper = at + high + margin;
}

void weft_slice_grid_region(const struct weft_slice_grid *grid, int taps, struct weft_region *out)
{
    const struct weft_slice_geometry *g = &grid->index;
    double reach = 0.5 * taps + 1.0;
    *out = (struct weft_region){.slab_count = 3};
    for (int a = 0; a < 3; a++) {
        double low = fmin(0.0, g->u[a]) + fmin(0.0, g->v[a]);
        double high = fmax(0.0, g->u[a]) + fmax(0.0, g->v[a]);
        out->min[a] = (int32_t)floor(g->origin[a] + low - reach);
        out->max[a] = (int32_t)ceil(g->origin[a] + high + reach);
    }
    // The plane, and its two directions by vectors that are dual to the edges' directions: dual .
    // edge is 0 to the edge's length across the slice.
    double u[3], v[3], normal[3], dual_u[3], dual_v[3];
    const double length_u = normalise(g->u, u), length_v = normalise(g->v, v);
    cross(u, v, normal);
    double square = dot(normal, normal), length = sqrt(square);
    cross(v, normal, dual_u);
    cross(normal, u, dual_v);
    for (int a = 0; a < 3; a++) {
        normal[a] /= length;
        dual_u[a] /= square;
        dual_v[a] /= square;
    }
    set_slab(normal, g->origin, 0.0, 0.0, reach, &out->slab[0]);
    set_slab(dual_u, g->origin, 0.0, length_u, reach, &out->slab[1]);
    set_slab(dual_v, g->origin, 0.0, length_v, reach, &out->slab[2]);
}

// ---- cells --------------------------------------------------------------------------------------

// Whole steps of a coordinate from cell to cell, without a division for each: as lines are drawn
// (Bresenham 1965). After `left` steps the coordinate is in another cell, `slack` past the
// boundary.
struct stepper {
    bool rises;
    int shift;           // a cell is 2^shift long
    int64_t length;      // of a step; 0: it never leaves its cell
    int64_t whole, rest; // 2^shift / length, and what that leaves
    double reciprocal;   // of the length
    int64_t left, slack;
};

static struct stepper make_stepper(int64_t step, int shift)
{
    struct stepper s = {.rises = step > 0, .shift = shift, .length = step < 0 ? -step : step};
    if (s.length == 0)
        return s;
    s.whole = (INT64_C(1) << shift) / s.length;
    s.rest = (INT64_C(1) << shift) % s.length;
    s.reciprocal = 1.0 / (double)s.length;
    return s;
}

static void start_stepper(struct stepper *s, int64_t at)
{
    const int64_t cell = INT64_C(1) << s->shift, in_cell = at & (cell - 1);
    const int64_t distance = s->rises ? cell - in_cell : in_cell + 1;
    s->left = INT64_MAX;
    if (s->length == 0)
        return;
    // The quotient rounded up. A double's is off by one at most.
    s->left = (int64_t)((double)distance * s->reciprocal);
    while (s->left * s->length < distance)
        s->left++;
    while ((s->left - 1) * s->length >= distance)
        s->left--;
    s->slack = s->left * s->length - distance;
}

// Makes `count` steps, `left` at most; returns how many cells farther the coordinate is then.
static int32_t make_steps(struct stepper *s, int64_t count)
{
    s->left -= count;
    if (s->left > 0)
        return 0;
    const int32_t cells = 1 + (int32_t)(s->slack >> s->shift);
    s->slack &= (INT64_C(1) << s->shift) - 1;
    const bool more = s->rest > s->slack;
    s->left = s->whole + more;
    s->slack += more ? s->length - s->rest : -s->rest;
    return s->rises ? cells : -cells;
}

// Where in its cell, 0 to 7, a coordinate lies.
static int place_in_cell(const struct weft_slice_grid *grid, int64_t at)
{
    return (int)(at >> grid->fraction_bits) & (WEFT_BRICK_SIZE - 1);
}

// One row of one block: pixels x0 to x1, exclusive; `at` is the position of x0.
static bool walk_row(const struct weft_slice_grid *grid, struct stepper steppers[3],
                     const int32_t base[3], int64_t at[3], int x0, int x1, int y,
                     weft_span_visitor visit, void *priv)
{
    struct weft_span run = {.x = x0, .y = y};
    for (int a = 0; a < 3; a++) {
        start_stepper(&steppers[a], at[a]);
        run.cell.at[a] = (base[a] >> 3) + (int32_t)(at[a] >> (grid->fraction_bits + 3));
    }
    while (run.x < x1) {
        int64_t count = x1 - run.x;
        for (int a = 0; a < 3; a++)
            count = steppers[a].left < count ? steppers[a].left : count;
        for (int a = 0; a < 3; a++) {
            const int from = place_in_cell(grid, at[a]);
            const int to = place_in_cell(grid, at[a] + (count - 1) * grid->du[a]);
            run.low[a] = (uint8_t)(from < to ? from : to);
            run.high[a] = (uint8_t)(from < to ? to : from);
            at[a] += count * grid->du[a];
        }
        run.count = (int)count;
        if (!visit(priv, &run))
            return false;
        run.x += run.count;
        for (int a = 0; a < 3; a++)
            run.cell.at[a] += make_steps(&steppers[a], count);
    }
    return true;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

// The first blocks of a row of them, which many rows of pixels begin at.
struct block_row {
    int by, first, count; // by < 0: none yet
    struct weft_slice_block at[16];
};

static struct weft_slice_block find_block(const struct weft_slice_grid *grid, struct block_row *row,
                                          int bx, int by)
{
    struct weft_slice_block other;
    for (int i = 0; by != row->by && i < row->count; i++)
        weft_slice_grid_block(grid, row->first + i, by, &row->at[i]);
    row->by = by;
    if (bx - row->first < row->count)
        return row->at[bx - row->first];
    weft_slice_grid_block(grid, bx, by, &other);
    return other;
}

bool weft_slice_grid_walk(const struct weft_slice_grid *grid, int x, int y, int width, int height,
                          weft_span_visitor visit, void *priv)
{
    struct block_row blocks = {.by = -1, .first = x / WEFT_GRID_BLOCK};
    struct stepper steppers[3];
    blocks.count =
        smaller((x + width - 1) / WEFT_GRID_BLOCK - blocks.first + 1, (int)WEFT_COUNT(blocks.at));
    for (int a = 0; a < 3; a++)
        steppers[a] = make_stepper(grid->du[a], grid->fraction_bits + 3);
    for (int row = y; row < y + height; row++) {
        for (int from = x, to; from < x + width; from = to) {
            const int bx = from / WEFT_GRID_BLOCK, by = row / WEFT_GRID_BLOCK;
            struct weft_slice_block block = find_block(grid, &blocks, bx, by);
            to = smaller((bx + 1) * WEFT_GRID_BLOCK, x + width);
            for (int a = 0; a < 3; a++)
                block.position[a] += (from - bx * WEFT_GRID_BLOCK) * grid->du[a] +
                                     (row - by * WEFT_GRID_BLOCK) * grid->dv[a];
            if (!walk_row(grid, steppers, block.base, block.position, from, to, row, visit, priv))
                return false;
        }
    }
    return true;
}
