// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/distribute/polygons.h - what the paper's pictures would cost, by a model: polygons
// of 50 pixels that move a little from frame to frame, at random places or in clusters. A region
// takes a time of its own, one for each polygon that reaches into it, and one for each of their
// pixels there. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_DISTRIBUTE_POLYGONS_H
#define WEFT_TESTS_PASSES_DISTRIBUTE_POLYGONS_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "filter/rectangle.h"

struct polygon {
    double x, y, along, down; // lower corner in the first frame, and what it moves by a frame
};
struct polygons {
    int count;
    double side;                   // pixels of each, a square
    double region, polygon, pixel; // seconds
    struct polygon *polygon_list;
};

static inline double polygons_random(uint64_t *seed)
{
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    return (double)(*seed >> 11) * 0x1p-53;
}

// clusters 0: anywhere in size x size pixels; else each lies around one of so many points, with a
// deviation of `spread` pixels. Motion: up to a pixel a frame.
static inline struct polygons polygons_make(int count, int size, int clusters, double spread,
                                            uint64_t seed)
{
    struct polygons p = {count, sqrt(50.0), 20e-6,
                         20e-6, 1e-6,       malloc((size_t)count * sizeof *p.polygon_list)};
    double middle[16][2] = {{0.0}};
    assert_non_null(p.polygon_list);
    for (int i = 0; i < clusters; i++)
        for (int axis = 0; axis < 2; axis++)
            middle[i][axis] = size * (0.1 + 0.8 * polygons_random(&seed));
    for (int i = 0; i < count; i++) {
        double place[2];
        for (int axis = 0; axis < 2; axis++) {
            // Three uniform numbers are near enough to a normal one.
            const double normal = 2.0 * (polygons_random(&seed) + polygons_random(&seed) +
                                         polygons_random(&seed) - 1.5);
            place[axis] = clusters ? middle[i % clusters][axis] + spread * normal
                                   : size * polygons_random(&seed);
        }
        p.polygon_list[i] = (struct polygon){place[0] - p.side / 2.0, place[1] - p.side / 2.0,
                                             2.0 * polygons_random(&seed) - 1.0,
                                             2.0 * polygons_random(&seed) - 1.0};
    }
    return p;
}

static inline double polygons_overlap(double at, double side, int32_t from, int32_t length)
{
    return fmax(0.0, fmin(at + side, (double)from + length) - fmax(at, from));
}

// struct model's cost.
static inline double polygons_cost(const void *priv, int frame, const struct weft_rectangle *r)
{
    const struct polygons *p = priv;
    double seconds = p->region;
    for (int i = 0; i < p->count; i++) {
        const struct polygon *q = &p->polygon_list[i];
        const double across = polygons_overlap(q->x + frame * q->along, p->side, r->x, r->width);
        const double down = polygons_overlap(q->y + frame * q->down, p->side, r->y, r->height);
        if (across > 0.0 && down > 0.0)
            seconds += p->polygon + p->pixel * across * down;
    }
    return seconds;
}

#endif
