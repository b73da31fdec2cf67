// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/antialias/povray.h - a flat scene for POV-Ray 3.7, and its picture back.
#ifndef WEFT_TESTS_PEERS_ANTIALIAS_POVRAY_H
#define WEFT_TESTS_PEERS_ANTIALIAS_POVRAY_H

#include "tests/peers/antialias/pictured.h"

// Writes the triangles of a flat scene as a mesh2 with the same camera, colours and background,
// linear (to be traced with File_Gamma=1). false, after a line: it failed.
bool povray_write(const struct pictured *pictured, const char *path);

// Reads a PNG of that size into linear planes, rows upwards, as POV-Ray wrote it with File_Gamma=1
// and 16 bits. false, after a line: it failed.
bool povray_read(const struct pictured *pictured, const char *path, float *const planes[4]);

#endif
