// SPDX-License-Identifier: BSD-3-Clause
#include "tools/scene/vector.h"

#include <math.h>

double scene_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void scene_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double scene_length(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

double scene_normalise(double v[3])
{
    const double length = sqrt(scene_dot(v, v));
    for (int i = 0; i < 3 && length > 0.0; i++)
        v[i] /= length;
    return length;
}

void scene_rotation(const double axis[3], double degrees, double out[4])
{
    double unit[3] = {axis[0], axis[1], axis[2]};
    scene_normalise(unit);
    const double half = degrees * M_PI / 360.0;
    for (int i = 0; i < 3; i++)
        out[i] = sin(half) * unit[i];
    out[3] = cos(half);
}

void scene_rotate(const double q[4], const double v[3], double out[3])
{
    // v + 2 w (q x v) + 2 q x (q x v)
    double once[3], twice[3];
    scene_cross(q, v, once);
    scene_cross(q, once, twice);
    for (int i = 0; i < 3; i++)
        out[i] = v[i] + 2.0 * (q[3] * once[i] + twice[i]);
}

void scene_transform(const double m[16], const double v[3], double out[3])
{
    double sum[3];
    for (int i = 0; i < 3; i++)
        sum[i] = m[i] * v[0] + m[4 + i] * v[1] + m[8 + i] * v[2] + m[12 + i];
    for (int i = 0; i < 3; i++)
        out[i] = sum[i];
}

void scene_multiply(const double a[16], const double b[16], double out[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + row] * b[4 * column + k];
            out[4 * column + row] = sum;
        }
}
