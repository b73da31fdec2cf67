// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/polygon.h"

#include <math.h>
#include <string.h>

struct ring {
    double at[WEFT_MESH_CORNERS][2]; // counterclockwise
    int before[WEFT_MESH_CORNERS], after[WEFT_MESH_CORNERS];
    int left, first;
};

// Seen along the axis that its normal (M. E. Newell's sums) is next to.
static void flatten(const float (*corners)[3], int count, struct ring *ring)
{
    double normal[3] = {0};
    int axis = 2;
    for (int i = 0; i < count; i++) {
        const float *a = corners[i], *b = corners[(i + 1) % count];
        for (int c = 0; c < 3; c++) {
            const int u = (c + 1) % 3, v = (c + 2) % 3;
            normal[c] += ((double)a[u] - (double)b[u]) * ((double)a[v] + (double)b[v]);
        }
    }
    for (int c = 0; c < 3; c++)
        if (fabs(normal[c]) > fabs(normal[axis]))
            axis = c;
    // Across the normal u and v are at right angles in this order; from behind, in the other one.
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < count; i++) {
        ring->at[i][0] = (double)corners[i][normal[axis] < 0.0 ? v : u];
        ring->at[i][1] = (double)corners[i][normal[axis] < 0.0 ? u : v];
        ring->before[i] = (i + count - 1) % count;
        ring->after[i] = (i + 1) % count;
    }
    ring->left = count;
    ring->first = 0;
}

// Twice the area, positive to the left.
static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double turn_at(const struct ring *ring, int i)
{
    return turn(ring->at[ring->before[i]], ring->at[i], ring->at[ring->after[i]]);
}

static bool same(const double a[2], const double b[2])
{
    return a[0] == b[0] && a[1] == b[1];
}

// Whether no corner of what is left lies in the triangle, or on its cut. Corners in the same place
// as the triangle's do not count: they join a hole to its outline.
static bool is_ear(const struct ring *ring, int i)
{
    const double *a = ring->at[ring->before[i]], *b = ring->at[i], *c = ring->at[ring->after[i]];
    if (!(turn(a, b, c) > 0.0))
        return false;
    for (int k = ring->after[ring->after[i]]; k != ring->before[i]; k = ring->after[k]) {
        const double *p = ring->at[k];
        if (!same(p, a) && !same(p, b) && !same(p, c) && turn(a, b, p) >= 0.0 &&
            turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0)
            return false;
    }
    return true;
}

// Where there is no ear the polygon crosses itself, or is flat: what turns the most right way then.
static int find_ear(const struct ring *ring)
{
    int best = ring->first;
    for (int i = ring->first, n = 0; n < ring->left; n++, i = ring->after[i]) {
        if (is_ear(ring, i))
            return i;
        if (turn_at(ring, i) > turn_at(ring, best))
            best = i;
    }
    for (int i = ring->first, n = 0; n < ring->left; n++, i = ring->after[i])
        if (turn_at(ring, i) == 0.0)
            return i;
    return best;
}

void weft_mesh_cut(const float (*corners)[3], int count, int (*triangles)[3])
{
    struct ring ring;
    flatten(corners, count, &ring);
    for (int t = 0; ring.left > 3; t++, ring.left--) {
        const int ear = find_ear(&ring), before = ring.before[ear], after = ring.after[ear];
        memcpy(triangles[t], (int[3]){before, ear, after}, sizeof triangles[t]);
        ring.after[before] = after;
        ring.before[after] = before;
        ring.first = after; // cuts do not all meet in one corner
    }
    const int last = ring.first;
    memcpy(triangles[count - 3], (int[3]){ring.before[last], last, ring.after[last]},
           sizeof triangles[0]);
}
