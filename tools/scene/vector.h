// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/vector.h - vectors, quaternions (x, y, z, w) and matrices (16 numbers, column by
// column) in double. Pure.
#ifndef WEFT_TOOLS_SCENE_VECTOR_H
#define WEFT_TOOLS_SCENE_VECTOR_H

double scene_dot(const double a[3], const double b[3]);
void scene_cross(const double a[3], const double b[3], double out[3]);
double scene_length(const double v[3]);
// Makes it of length 1 and returns its length; what has none stays.
double scene_normalise(double v[3]);
// The unit quaternion of a turn about an axis of any length above 0.
void scene_rotation(const double axis[3], double degrees, double out[4]);
// A vector turned by a unit quaternion.
void scene_rotate(const double q[4], const double v[3], double out[3]);
// matrix * (v, 1), of matrices whose last row is 0 0 0 1; in place, too.
void scene_transform(const double matrix[16], const double v[3], double out[3]);
// a * b; out is neither.
void scene_multiply(const double a[16], const double b[16], double out[16]);

#endif
