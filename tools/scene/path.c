// SPDX-License-Identifier: BSD-3-Clause
// Paths by keyframes.
#include <math.h>

#include "tools/scene/build.h"

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
