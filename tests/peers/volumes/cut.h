// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/volumes/cut.h - what all peers compute: a plane through a dense box of voxels, and what
// the exact answers are.
#ifndef WEFT_TESTS_PEERS_CUT_H
#define WEFT_TESTS_PEERS_CUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum cut_plane { CUT_OBLIQUE, CUT_AXIS };

// Which exact answer a peer's pixels are compared with.
enum cut_reference {
    CUT_CATMULL_ROM,
    CUT_BSPLINE, // of the samples: smooths
    CUT_SPLINE,  // the cubic spline through the samples, mirrored at the faces
    CUT_REFERENCES
};

struct cut {
    char name[256];
    int size[3], width, height;        // voxels, pixels
    double origin[3], du[3], dv[3];    // pixel (x, y) at origin + x du + y dv, index space
    float *box;                        // [z][y][x]
    int box_fd;                        // the same as a file in memory, which children inherit
    double largest;                    // |voxel|
    double *reference[CUT_REFERENCES]; // one per checked pixel; made when needed
    uint32_t *checked;                 // pixels y * width + x whose taps are all inside the box
    size_t checked_count;
};

// `source` is a VDB file's path (its first scalar grid's active box) or SIGNAL[:N]. The plane goes
// through the middle; at its ends it stays 1/15 of the box away from the faces.
bool cut_make(struct cut *cut, const char *source, enum cut_plane plane, int width, int height);
void cut_clear(struct cut *cut);

struct cut_error {
    double maximum, rms; // |pixel - reference|
    size_t not_finite;   // pixels
};

// Compares; makes the reference when it is asked for the first time (seconds).
bool cut_compare(struct cut *cut, enum cut_reference reference, const float *pixels,
                 struct cut_error *out);

const char *cut_reference_name(enum cut_reference reference);

#endif
