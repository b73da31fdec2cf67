// SPDX-License-Identifier: BSD-3-Clause
// Paths by keyframes.
#include <math.h>

#include "tools/scene/build.h"

// ---- vectors and quaternions --------------------------------------------------------------------

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

// ---- between keys -------------------------------------------------------------------------------

// Shoemake's slerp, equation 4, along the shorter arc. Close to each other both weights become
// those of a line, whose error there is below rounding.
static void turn_between(const double a[4], const double b[4], double share, double out[4])
{
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    cosine = fmin(fabs(cosine), 1.0);
    const double angle = acos(cosine), sine = sin(angle);
    double from = 1.0 - share, to = share;
    if (sine > 1e-7) {
        from = sin(from * angle) / sine;
        to = sin(to * angle) / sine;
    }
    double length = 0.0;
    for (int i = 0; i < 4; i++) {
        out[i] = from * a[i] + sign * to * b[i];
        length += out[i] * out[i];
    }
    for (int i = 0; i < 4; i++)
        out[i] /= sqrt(length);
}

static struct scene_key key_between(const struct scene_key *a, const struct scene_key *b,
                                    double time)
{
    const double share = (time - a->time) / (b->time - a->time);
    struct scene_key key = {.time = time};
    for (int i = 0; i < 3; i++)
        key.position[i] = (1.0 - share) * a->position[i] + share * b->position[i];
    key.scale = (1.0 - share) * a->scale + share * b->scale;
    turn_between(a->rotation, b->rotation, share, key.rotation);
    return key;
}

struct scene_key scene_path_key(const struct scene_path *path, double time)
{
    if (path->count == 0)
        return (struct scene_key){.time = time, .rotation = {0.0, 0.0, 0.0, 1.0}, .scale = 1.0};
    int after = 0, end = path->count; // the first key that is later
    while (after < end) {
        const int middle = (after + end) / 2;
        if (path->keys[middle].time > time)
            end = middle;
        else
            after = middle + 1;
    }
    if (after > 0 && after < path->count)
        return key_between(&path->keys[after - 1], &path->keys[after], time);
    struct scene_key rest = path->keys[after ? after - 1 : 0];
    rest.time = time;
    return rest;
}

void scene_path_at(const struct scene_path *path, double time, double matrix[16])
{
    const struct scene_key key = scene_path_key(path, time);
    for (int column = 0; column < 3; column++) {
        const double unit[3] = {column == 0, column == 1, column == 2};
        double turned[3];
        scene_rotate(key.rotation, unit, turned);
        for (int i = 0; i < 3; i++)
            matrix[4 * column + i] = key.scale * turned[i];
        matrix[4 * column + 3] = 0.0;
        matrix[12 + column] = key.position[column];
    }
    matrix[15] = 1.0;
}
