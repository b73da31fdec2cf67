// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/exact_parts.h - what exact pictures are made of; inside of tools/scene/exact*.c.
//
// The picture is cut into cells, one a pixel. What is seen in a cell is a list of convex pieces,
// each of one face (a triangle as it is seen) or of the background. A face that comes to a cell is
// clipped to each piece, and the common part is cut along the line where both are equally far away,
// which is straight, as depth / w is linear on the screen; so faces may come in any order, and
// through one another.
#ifndef WEFT_TOOLS_SCENE_EXACT_PARTS_H
#define WEFT_TOOLS_SCENE_EXACT_PARTS_H

#include "tools/scene/exact.h"

// ---- faces --------------------------------------------------------------------------------------

enum { EXACT_FACE_CORNERS = 3 + 6 };

// A triangle on the screen, cut off by the frustum's planes. Places are in pixels from the lower
// left corner of the picture.
struct exact_face {
    int count; // of corners, counterclockwise
    double corner[EXACT_FACE_CORNERS][2];
    // Inside, x edge[0] + y edge[1] + edge[2] >= 0. Faces that share an edge have the same numbers
    // for it, with opposite signs.
    double edge[EXACT_FACE_CORNERS][3];
    double plane[3]; // depth, in normalised device coordinates, is x p[0] + y p[1] + p[2]
    double nearest;  // depth
    double colour[4];
};

// ---- cells --------------------------------------------------------------------------------------

// Corners of a piece; those with more than EXACT_SPLIT are cut in two, so that there is always room
// for what cutting adds.
enum { EXACT_SPLIT = 12, EXACT_CORNERS = EXACT_SPLIT + EXACT_FACE_CORNERS + 3 };

struct exact_piece {
    int face; // -1: the background
    int part; // of the cell that it lies in: row * parts + column
    int count;
    double corner[EXACT_CORNERS][2]; // from the cell's lower left corner, counterclockwise
    double farthest;                 // depth
};

// What is seen in a cell. All zero: nothing, with no memory; `piece` is owned.
struct exact_cell {
    const struct exact_face *faces; // borrowed
    int at[2];                      // its lower left corner, in pixels
    struct exact_piece *piece;
    int count, room;
    bool full; // memory ran out: the list is not to be used
};

// Makes it the background, cut into parts x parts at cut[0] = 0 to cut[parts] = 1.
void exact_cell_begin(struct exact_cell *cell, const int at[2], const double *cut, int parts);
// The least depth that a face can have in the cell.
double exact_cell_nearest(const struct exact_cell *cell, int face);
// Shows a face where it is nearer than what is there; of two in one place, but for rounding, the
// one with the lower number. nearest: as above. Returns whether anything that is there is
// as far away, so that faces that are no nearer than this one can matter.
bool exact_cell_show(struct exact_cell *cell, int face, double nearest);
void exact_cell_end(struct exact_cell *cell);

// ---- filters ------------------------------------------------------------------------------------

enum { EXACT_MAX_RADIUS = 8, EXACT_MAX_PARTS = 64, EXACT_MAX_DEGREE = 31 };

// A pixel's filter as polynomials. Cells are cut into parts where the filter of a pixel, this or a
// neighbour's, has a corner; in each part it is one Chebyshev series along each axis.
struct exact_filter {
    int radius;                             // pixels that a cell counts in, to each side
    int parts;                              // along an axis
    double cut[EXACT_MAX_PARTS + 1];        // 0 to 1
    int degree;                             // of the series
    double (*series)[EXACT_MAX_DEGREE + 1]; // [axis][part][2 radius + 1], owned
    double (*whole)[EXACT_MAX_DEGREE + 2];  // integrals of those of axis 0
    double *share; // integral of each series over its part, in the same order; owned
    double node[EXACT_MAX_DEGREE + 1],
        weight[EXACT_MAX_DEGREE + 1]; // Gauss and Legendre's, of 0..1
    double error;                     // of the integral of filter times a picture of values up to 1
};

// Finds the filter of the params. Returns as scene_exact_draw does.
enum weft_result exact_filter_make(const struct scene_exact_params *params,
                                   struct exact_filter *out);
void exact_filter_clear(struct exact_filter *filter);
// Adds the integrals of all pixels' filters over a piece of a cell to sum[y][x], x and y from
// -radius to radius: of the pixel that lies so many cells further right and up.
void exact_filter_add(const struct exact_filter *filter, const struct exact_piece *piece,
                      double *sum);

#endif
