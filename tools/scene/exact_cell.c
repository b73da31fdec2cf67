// SPDX-License-Identifier: BSD-3-Clause
// What is seen in a cell: convex pieces, cut by faces' edges and by lines of equal depth.
#include <math.h>
#include <stdlib.h>

#include "tools/scene/exact_parts.h"

// Depths that differ by less are the same: rounding of planes. Areas, in pixels, that are dropped.
static const double SAME_DEPTH = 1e-13, NO_AREA = 1e-17;

// ---- polygons -----------------------------------------------------------------------------------

static double find_area(const struct exact_piece *p)
{
    double doubled = 0.0;
    for (int i = 1; i + 1 < p->count; i++) {
        const double *o = p->corner[0], *a = p->corner[i], *b = p->corner[i + 1];
        doubled += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    }
    return 0.5 * doubled;
}

static void add_corner(struct exact_piece *p, double x, double y)
{
    p->corner[p->count][0] = x;
    p->corner[p->count++][1] = y;
}

// Cuts a piece by values of a linear function at its corners: where it is 0 or more, and where it
// is 0 or less.
static void cut(const struct exact_piece *p, const double *value, struct exact_piece *above,
                struct exact_piece *below)
{
    above->count = below->count = 0;
    for (int i = 0; i < p->count; i++) {
        const int next = i + 1 < p->count ? i + 1 : 0;
        const double *a = p->corner[i], *b = p->corner[next];
        if (value[i] >= 0.0)
            add_corner(above, a[0], a[1]);
        if (value[i] <= 0.0)
            add_corner(below, a[0], a[1]);
        if ((value[i] > 0.0 && value[next] < 0.0) || (value[i] < 0.0 && value[next] > 0.0)) {
            const double share = value[i] / (value[i] - value[next]);
            const double x = a[0] + share * (b[0] - a[0]), y = a[1] + share * (b[1] - a[1]);
            add_corner(above, x, y);
            add_corner(below, x, y);
        }
    }
}

// The least and the largest value of a linear function, and all of them, at a piece's corners.
static void find_values(const struct exact_piece *p, const double line[3], double *value,
                        double *least, double *most)
{
    *least = INFINITY;
    *most = -INFINITY;
    for (int i = 0; i < p->count; i++) {
        value[i] = line[0] * p->corner[i][0] + line[1] * p->corner[i][1] + line[2];
        *least = fmin(*least, value[i]);
        *most = fmax(*most, value[i]);
    }
}

// A linear function of pixels as one of places in a cell.
static void move_to(const struct exact_cell *cell, const double line[3], double out[3])
{
    out[0] = line[0];
    out[1] = line[1];
    out[2] = line[0] * cell->at[0] + line[1] * cell->at[1] + line[2];
}

// ---- lists --------------------------------------------------------------------------------------

static double find_farthest(const struct exact_cell *cell, const struct exact_piece *p)
{
    double line[3], value[EXACT_CORNERS], least, most;
    if (p->face < 0)
        return INFINITY;
    move_to(cell, cell->faces[p->face].plane, line);
    find_values(p, line, value, &least, &most);
    return most;
}

static void put(struct exact_cell *cell, const struct exact_piece *p)
{
    if (!(find_area(p) > NO_AREA))
        return;
    if (cell->count == cell->room) {
        const int room = cell->room ? 2 * cell->room : 64;
        struct exact_piece *grown = realloc(cell->piece, (size_t)room * sizeof *grown);
        if (!grown) {
            cell->full = true;
            return;
        }
        cell->piece = grown;
        cell->room = room;
    }
    cell->piece[cell->count] = *p;
    cell->piece[cell->count++].farthest = find_farthest(cell, p);
}

// One with many corners as two.
static void put_parted(struct exact_cell *cell, const struct exact_piece *p)
{
    if (p->count <= EXACT_SPLIT) {
        put(cell, p);
        return;
    }
    struct exact_piece half = {.face = p->face, .part = p->part};
    const int middle = p->count / 2;
    for (int i = 0; i <= middle; i++)
        add_corner(&half, p->corner[i][0], p->corner[i][1]);
    put(cell, &half);
    half.count = 0;
    for (int i = middle; i <= p->count; i++)
        add_corner(&half, p->corner[i % p->count][0], p->corner[i % p->count][1]);
    put(cell, &half);
}

void exact_cell_begin(struct exact_cell *cell, const int at[2], const double *border, int parts)
{
    cell->at[0] = at[0];
    cell->at[1] = at[1];
    cell->count = 0;
    for (int y = 0; y < parts; y++)
        for (int x = 0; x < parts; x++) {
            struct exact_piece p = {.face = -1, .part = y * parts + x};
            add_corner(&p, border[x], border[y]);
            add_corner(&p, border[x + 1], border[y]);
            add_corner(&p, border[x + 1], border[y + 1]);
            add_corner(&p, border[x], border[y + 1]);
            put(cell, &p);
        }
}

void exact_cell_end(struct exact_cell *cell)
{
    free(cell->piece);
    *cell = (struct exact_cell){.count = 0};
}

double exact_cell_nearest(const struct exact_cell *cell, int face)
{
    const struct exact_face *f = &cell->faces[face];
    double line[3];
    move_to(cell, f->plane, line);
    return fmax(f->nearest, line[2] + fmin(line[0], 0.0) + fmin(line[1], 0.0));
}

// ---- faces --------------------------------------------------------------------------------------

// A piece that meets a face: what is outside of the face, and what they have in common.
struct meeting {
    struct exact_piece outside[EXACT_FACE_CORNERS], common;
    int count; // of those outside
};

// false: they have nothing in common.
static bool meet(const struct exact_cell *cell, const struct exact_piece *piece,
                 const struct exact_face *face, struct meeting *out)
{
    double line[3], value[EXACT_CORNERS], least, most;
    out->common = *piece;
    out->count = 0;
    for (int i = 0; i < face->count; i++) {
        move_to(cell, face->edge[i], line);
        find_values(&out->common, line, value, &least, &most);
        if (!(most > 0.0))
            return false;
        if (least >= 0.0)
            continue;
        struct exact_piece inside = {.face = piece->face, .part = piece->part};
        struct exact_piece *outside = &out->outside[out->count++];
        outside->face = piece->face;
        outside->part = piece->part;
        cut(&out->common, value, &inside, outside);
        out->common = inside;
    }
    return find_area(&out->common) > NO_AREA;
}

// What a face gains of what it has in common with a piece, and what the piece keeps of that (no
// corners: nothing). false: it gains nothing.
static bool divide(const struct exact_cell *cell, struct exact_piece *common, int face,
                   struct exact_piece *kept)
{
    kept->count = 0;
    kept->face = common->face;
    kept->part = common->part;
    if (common->face < 0) {
        common->face = face;
        return true;
    }
    // How much nearer the face is.
    double nearer[3], line[3], value[EXACT_CORNERS], least, most;
    for (int i = 0; i < 3; i++)
        nearer[i] = cell->faces[common->face].plane[i] - cell->faces[face].plane[i];
    move_to(cell, nearer, line);
    line[2] += face < common->face ? SAME_DEPTH : -SAME_DEPTH;
    find_values(common, line, value, &least, &most);
    if (!(most > 0.0))
        return false;
    if (least < 0.0) {
        struct exact_piece gained = {.part = common->part};
        cut(common, value, &gained, kept);
        if (!(find_area(&gained) > NO_AREA))
            return false;
        *common = gained;
    }
    common->face = face;
    return true;
}

bool exact_cell_show(struct exact_cell *cell, int face, double nearest)
{
    const int count = cell->count; // those that are new are the face's, or not in common with it
    bool any = false;
    for (int i = 0; i < count && !cell->full; i++) {
        struct meeting meeting;
        struct exact_piece kept;
        if (nearest > cell->piece[i].farthest + SAME_DEPTH)
            continue;
        any = true;
        if (!meet(cell, &cell->piece[i], &cell->faces[face], &meeting) ||
            !divide(cell, &meeting.common, face, &kept))
            continue;
        cell->piece[i].count = 0;
        put_parted(cell, &meeting.common);
        if (kept.count)
            put_parted(cell, &kept);
        for (int k = 0; k < meeting.count; k++)
            put_parted(cell, &meeting.outside[k]);
    }
    // Without those that were divided.
    int left = 0;
    for (int i = 0; i < cell->count; i++)
        if (cell->piece[i].count)
            cell->piece[left++] = cell->piece[i];
    cell->count = left;
    return any;
}
