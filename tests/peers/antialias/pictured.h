// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/antialias/pictured.h - a scene whose pictures a bench or a figure draws by ways of
// anti-aliasing.
#ifndef WEFT_TESTS_PEERS_ANTIALIAS_PICTURED_H
#define WEFT_TESTS_PEERS_ANTIALIAS_PICTURED_H

#include "tools/antialias/drawer.h"
#include "tools/render/drawing.h"

enum { PICTURED_CHANNELS = 4, PICTURED_COLOURS = 3 };

// A scene on a context. All zero: none.
struct pictured {
    weft_context *context; // borrowed
    int size[2];
    struct scene scene;
    scene_drawing *drawing;
};

extern const struct weft_log pictured_log; // warnings and errors, to stderr

// Makes the scene of a name and prepares its picture. flat: every triangle has one colour of its
// own, lit from a direction, without shadows, so that coverage is exact where it is known. To be
// cleared in any case. false, after a line: it failed.
bool pictured_create(weft_context *context, const char *name, bool flat, const int size[2],
                     struct pictured *out);
void pictured_clear(struct pictured *pictured);

// Makes what draws its pictures: of `how` size, background, context and log are filled in.
antialias_drawer *pictured_make_drawer(const struct pictured *pictured,
                                       struct antialias_params how);

// Draws a picture and returns the seconds that it took; below 0, after a line: it failed. planes:
// 4, rows upwards.
double pictured_draw(const struct pictured *pictured, antialias_drawer *drawer,
                     float *const planes[4]);

// 4 planes of the picture's size, to be freed by pictured_free; false, after a line: no memory.
bool pictured_allocate(const struct pictured *pictured, float *planes[4]);
void pictured_free(float *planes[4]);

// The exact picture of a flat scene by a box, [y][x][4], rows upwards; to be freed. NULL, after a
// line: it failed.
double *pictured_make_exact(const struct pictured *pictured);

// How far a picture is from it, over R, G and B. A NaN counts as INFINITY.
struct pictured_error {
    double largest, rms;
};
struct pictured_error pictured_compare(const struct pictured *pictured, float *const planes[4],
                                       const double *exact);

// Sorts the values; returns their median.
double pictured_median(double *values, int count);

#endif
