// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/antialias/samples.h - what each sample of a multisampled picture shows, fetched one
// by one: the reference of accumulative anti-aliasing, of one pass or several. And random scenes.
#ifndef WEFT_TESTS_PASSES_ANTIALIAS_SAMPLES_H
#define WEFT_TESTS_PASSES_ANTIALIAS_SAMPLES_H

#include "tests/passes/antialias/triangles.h"

struct samples {
    int width, height, count; // with the rim
    float *value;             // [y][x][sample][4], rows upwards; 0 where nothing is drawn
};

// Draws stage colour by an own target of floats and reads each sample. `place` as of a pass.
void samples_read(struct triangles *triangles, int width, int height, int count, int depth_bits,
                  const double place[16], struct samples *out);
void samples_free(struct samples *samples);
static inline const float *samples_at(const struct samples *s, int x, int y, int i)
{
    return s->value +
           4 * (((size_t)y * (size_t)s->width + (size_t)x) * (size_t)s->count + (size_t)i);
}

// Triangles of a picture of so many pixels: large, small, thin, touching their predecessor along an
// edge, and cutting through one another; the same ones for the same seed. Colours are opaque, and
// the three vertices' own, each up to `range`.
void samples_scene(uint32_t seed, const int size[2], int triangles, float range,
                   struct triangle_vertex *out);

#endif
