// SPDX-License-Identifier: BSD-3-Clause
// Cuts turned and mirrored within their plane.
#include <math.h>
#include <stdbool.h>

#include "filter/check.h"
#include "passes/positions/geometry.h"

// Cosines below this are those of right angles.
#define SQUARE 1e-9

// A direction and the edges in world space: lengths, and cosines between any two.
struct sides {
    double length[2]; // of u and v
    double cosine;    // of the angle between them
    double up[2];     // of those between them and the direction
};

// Of length 1; the length that it had.
static double to_world(const struct weft_volume_info *info, enum weft_space space,
                       const double edge[3], double out[3])
{
    for (int r = 0; r < 3; r++) {
        const double *m = info->index_to_world[r];
        out[r] =
            space == WEFT_SPACE_WORLD ? edge[r] : m[0] * edge[0] + m[1] * edge[1] + m[2] * edge[2];
    }
    const double length = hypot(hypot(out[0], out[1]), out[2]);
    for (int r = 0; r < 3; r++)
        out[r] /= length;
    return length;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static enum weft_result find_sides(const struct weft_log *log, const weft_volume *volume,
                                   enum weft_space space, const double up[3],
                                   const struct weft_slice_geometry *g, struct sides *out)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    double u[3], v[3], w[3];
    out->length[0] = to_world(info, space, g->u, u);
    out->length[1] = to_world(info, space, g->v, v);
    const double length = to_world(info, space, up, w);
    out->cosine = dot(u, v);
    out->up[0] = dot(u, w);
    out->up[1] = dot(v, w);
    if (!(length > 0.0 && isfinite(length))) {
        weft_error(log, "(%g, %g, %g) is no direction: its length is %g", up[0], up[1], up[2],
                   length);
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < 2; i++)
        if (!(out->length[i] > 0.0 && isfinite(out->length[i])))
            return WEFT_ERR_FORMAT;
    return fabs(out->cosine) < 1.0 - SQUARE ? WEFT_OK : WEFT_ERR_FORMAT;
}

// As edges of the picture, 0 - x being no -0.
static void negate(double edge[3])
{
    for (int i = 0; i < 3; i++)
        edge[i] = 0.0 - edge[i];
}

static void move(double origin[3], const double edge[3], double times)
{
    for (int i = 0; i < 3; i++)
        origin[i] += times * edge[i];
}

void weft_slice_mirror(bool columns, bool rows, struct weft_slice_geometry *g)
{
    if (columns) {
        move(g->origin, g->u, 1.0);
        negate(g->u);
    }
    if (rows) {
        move(g->origin, g->v, 1.0);
        negate(g->v);
    }
}

// Edge 0 or 1 becomes the columns; `along`: up runs with it, and so against the rows' order.
static void take_edge(int edge, bool along, struct weft_slice_geometry *g)
{
    if (edge == 0) {
        const struct weft_slice_geometry was = *g;
        for (int i = 0; i < 3; i++) {
            g->u[i] = was.v[i];
            g->v[i] = was.u[i];
        }
        g->width = was.height;
        g->height = was.width;
    }
    weft_slice_mirror(false, along, g);
}

// p times one edge and q times the other, both of length 1, in the plane's space.
static void combine(const struct weft_slice_geometry *g, const struct sides *s, double p, double q,
                    double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = p * g->u[i] / s->length[0] + q * g->v[i] / s->length[1];
}

// What a direction p, q reaches of the picture, from its least to its greatest.
static void find_extent(const struct sides *s, double p, double q, double *low, double *high)
{
    const double u = s->length[0] * (p + s->cosine * q), v = s->length[1] * (s->cosine * p + q);
    *low = fmin(0.0, u) + fmin(0.0, v);
    *high = fmax(0.0, u) + fmax(0.0, v);
}

// The rectangle that holds the picture and whose columns run against p, q: with a direction square
// to it, which is of edges that are not square to each other.
static void take_rectangle(const struct sides *s, double p, double q, struct weft_slice_geometry *g)
{
    double right[2] = {-(s->cosine * p + q), p + s->cosine * q};
    double length = sqrt(p * p + 2.0 * s->cosine * p * q + q * q);
    p /= length;
    q /= length;
    length =
        sqrt(right[0] * right[0] + 2.0 * s->cosine * right[0] * right[1] + right[1] * right[1]);
    if (right[fabs(right[1]) > fabs(right[0])] < 0.0)
        length = -length;
    double low[2], high[2], r[3], d[3];
    right[0] /= length;
    right[1] /= length;
    find_extent(s, right[0], right[1], &low[0], &high[0]);
    find_extent(s, p, q, &low[1], &high[1]);
    combine(g, s, right[0], right[1], r);
    combine(g, s, p, q, d);
    move(g->origin, r, low[0]);
    move(g->origin, d, high[1]);
    for (int i = 0; i < 3; i++) {
        g->u[i] = 0.0 + (high[0] - low[0]) * r[i]; // no -0
        g->v[i] = 0.0 + (low[1] - high[1]) * d[i];
    }
    g->width = g->height = 0;
}

enum weft_result weft_slice_turn(const struct weft_log *log, const weft_volume *volume,
                                 enum weft_space space, const double up[3], bool whole,
                                 struct weft_slice_geometry *geometry)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct sides s;
    weft_require_enum(log, space, WEFT_SPACE_INDEX);
    res = find_sides(log, volume, space, up, geometry, &s);
    if (res == WEFT_ERR_FORMAT)
        weft_error(log, "the edge vectors u and v span no plane");
    if (res != WEFT_OK)
        return res;
    // Of the projection onto the plane.
    const double square = 1.0 - s.cosine * s.cosine;
    const double p = (s.up[0] - s.cosine * s.up[1]) / square;
    const double q = (s.up[1] - s.cosine * s.up[0]) / square;
    if (fabs(p) < SQUARE && fabs(q) < SQUARE) {
        weft_error(log, "(%g, %g, %g) is square to the plane: it cannot point up in the picture",
                   up[0], up[1], up[2]);
        return WEFT_ERR_ARGUMENT;
    }
    const bool along_edge = fabs(p) < SQUARE || fabs(q) < SQUARE;
    const int edge = along_edge ? fabs(p) < SQUARE : fabs(s.up[1]) >= fabs(s.up[0]);
    if (along_edge || !whole)
        take_edge(edge, (along_edge ? edge ? q : p : s.up[edge]) > 0.0, geometry);
    else
        take_rectangle(&s, p, q, geometry);
fail:
    return res;
}
