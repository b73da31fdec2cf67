// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/shadow_view.h"

#include <math.h>

#include "tools/scene/vector.h"

// Widest fitted face, in tangents; nearest near plane, to the diagonal.
static const double WIDEST = 4.0, NEAR = 0x1p-10;

// Corners of a box, and where its edges go through a plane.
enum { MAX_POINTS = 8 + 12 };

bool scene_light_is_flat(const struct scene_point_light *light)
{
    return light->normal[0] != 0.0 || light->normal[1] != 0.0 || light->normal[2] != 0.0;
}

// ---- what is to be seen -------------------------------------------------------------------------

// Corners of the part of a caster's box that lies before the light, relative to its eye.
static int find_points(const struct scene_caster *caster, const double eye[3],
                       const double normal[3], double out[MAX_POINTS][3])
{
    double corner[8][3], side[8];
    int count = 0;
    for (int i = 0; i < 8; i++) {
        double modelled[3];
        for (int axis = 0; axis < 3; axis++)
            modelled[axis] = i >> axis & 1 ? caster->extent->high[axis] : caster->extent->low[axis];
        scene_transform(caster->model, modelled, corner[i]);
        for (int axis = 0; axis < 3; axis++)
            corner[i][axis] -= eye[axis];
        side[i] = normal ? scene_dot(normal, corner[i]) : 1.0;
        for (int axis = 0; axis < 3 && side[i] > 0.0; axis++)
            out[count][axis] = corner[i][axis];
        count += side[i] > 0.0;
    }
    for (int i = 0; i < 8; i++)
        for (int axis = 0; axis < 3; axis++) {
            const int j = i | 1 << axis;
            if (j == i || (side[i] > 0.0) == (side[j] > 0.0))
                continue;
            const double share = side[i] / (side[i] - side[j]);
            for (int k = 0; k < 3; k++)
                out[count][k] = corner[i][k] + share * (corner[j][k] - corner[i][k]);
            count++;
        }
    return count;
}

// right and up for a forward of length 1.
static void complete_axes(double axis[3][3])
{
    const double *forward = axis[2];
    int least = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(forward[i]) < fabs(forward[least]))
            least = i;
    const double other[3] = {least == 0, least == 1, least == 2};
    scene_cross(forward, other, axis[0]);
    scene_normalise(axis[0]);
    scene_cross(axis[0], forward, axis[1]);
}

// Sets forward to the mean direction of all that is to be seen. false: there is nothing.
static bool find_forward(const struct scene_caster *caster, int count, const double *normal,
                         struct scene_shadow_view *view)
{
    double *forward = view->axis[2];
    bool any = false;
    for (int i = 0; i < 3; i++)
        forward[i] = 0.0;
    for (int i = 0; i < count; i++) {
        double point[MAX_POINTS][3];
        const int points = find_points(&caster[i], view->eye, normal, point);
        for (int k = 0; k < points; k++) {
            scene_normalise(point[k]);
            for (int axis = 0; axis < 3; axis++)
                forward[axis] += point[k][axis];
        }
        any = any || points > 0;
    }
    return any;
}

// Widens the window to a direction. false: it is too far aside.
static bool see(struct scene_shadow_view *view, const double point[3], double high[2])
{
    const double depth = scene_dot(view->axis[2], point);
    if (depth <= 0.0)
        return false;
    for (int i = 0; i < 2; i++) {
        const double tangent = scene_dot(view->axis[i], point) / depth;
        view->low[i] = fmin(view->low[i], tangent);
        high[i] = fmax(high[i], tangent);
        if (!(high[i] - view->low[i] <= WIDEST))
            return false;
    }
    view->near_distance = fmin(view->near_distance, depth);
    return true;
}

static bool fit(const struct scene_caster *caster, int count, const double *normal, int size,
                struct scene_shadow_view *view)
{
    double high[2] = {-INFINITY, -INFINITY};
    view->low[0] = view->low[1] = view->near_distance = INFINITY;
    for (int i = 0; i < count; i++) {
        double point[MAX_POINTS][3];
        const int points = find_points(&caster[i], view->eye, normal, point);
        for (int k = 0; k < points; k++)
            if (!see(view, point[k], high))
                return false;
    }
    // A texel around it, and some width for what has none.
    for (int i = 0; i < 2; i++) {
        const double texel = fmax((high[i] - view->low[i]) / size, 1e-6);
        view->low[i] -= texel;
        view->extent[i] = high[i] - view->low[i] + texel;
    }
    return true;
}

void scene_shadow_eye(const struct scene_point_light *light, double diagonal, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = light->position[i] + SCENE_SHADOW_HEIGHT * diagonal * light->normal[i];
}

void scene_shadow_view_find(const struct scene_point_light *light,
                            const struct scene_caster *caster, int count, double diagonal, int size,
                            struct scene_shadow_view *out)
{
    const double *normal = scene_light_is_flat(light) ? light->normal : NULL;
    *out = (struct scene_shadow_view){.kind = SCENE_SHADOW_NONE};
    scene_shadow_eye(light, diagonal, out->eye);
    if (!find_forward(caster, count, normal, out))
        return;
    if (scene_normalise(out->axis[2]) > 0.0) {
        complete_axes(out->axis);
        out->kind = SCENE_SHADOW_FITTED;
        // Half, so that casters are well inside.
        if (fit(caster, count, normal, size, out)) {
            out->near_distance = fmax(0.5 * out->near_distance, NEAR * diagonal);
            return;
        }
    }
    out->kind = normal ? SCENE_SHADOW_HALF_CUBE : SCENE_SHADOW_CUBE;
    out->near_distance = NEAR * diagonal;
    for (int i = 0; i < 3; i++)
        out->axis[2][i] = normal ? normal[i] : (double)(i == 2);
    complete_axes(out->axis);
}

// ---- faces --------------------------------------------------------------------------------------

// Clip coordinates' rows as sums of the axes' distances from the eye: x = to_x . (right, up,
// forward), and so on.
static void make_face(const struct scene_shadow_view *view, const double x[3], const double y[3],
                      const double w[3], struct scene_shadow_face *out)
{
    const double *const sum[4] = {x, y, w, w};
    for (int row = 0; row < 4; row++) {
        double at_eye = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            double v = 0.0;
            for (int k = 0; k < 3; k++)
                v += sum[row][k] * view->axis[k][axis];
            out->clip[4 * axis + row] = v;
            at_eye += v * view->eye[axis];
        }
        out->clip[12 + row] = -at_eye - (row == 2 ? 2.0 * view->near_distance : 0.0);
    }
    double turn[3];
    scene_cross(x, y, turn);
    // right x up = -forward is how OpenGL looks.
    double frame[3];
    scene_cross(view->axis[0], view->axis[1], frame);
    out->mirrored = scene_dot(turn, w) * scene_dot(frame, view->axis[2]) > 0.0;
}

static void make_fitted(const struct scene_shadow_view *view, struct scene_shadow_face *out)
{
    double row[2][3] = {{0.0}};
    for (int i = 0; i < 2; i++) {
        row[i][i] = 2.0 / view->extent[i];
        row[i][2] = -(2.0 * view->low[i] + view->extent[i]) / view->extent[i];
    }
    make_face(view, row[0], row[1], (double[]){0.0, 0.0, 1.0}, out);
}

// A face at a side: its axis is right or up, its x the other one of these, its y forward.
static void make_side(const struct scene_shadow_view *view, int number, bool below, bool half,
                      struct scene_shadow_face *out)
{
    double x[3] = {0.0}, y[3] = {0.0, 0.0, half ? 2.0 : 1.0}, w[3] = {0.0};
    w[number] = below ? -1.0 : 1.0;
    x[1 - number] = 1.0;
    for (int i = 0; i < 3 && half; i++)
        y[i] -= w[i];
    make_face(view, x, y, w, out);
}

int scene_shadow_view_faces(const struct scene_shadow_view *view,
                            struct scene_shadow_face out[SCENE_SHADOW_FACES], int *layers)
{
    static const double right[3] = {1.0, 0.0, 0.0}, up[3] = {0.0, 1.0, 0.0};
    const bool half = view->kind == SCENE_SHADOW_HALF_CUBE;
    int count = 0;
    for (int i = 0; i < SCENE_SHADOW_FACES; i++)
        out[i] = (struct scene_shadow_face){.layer = 0};
    *layers = 0;
    if (view->kind == SCENE_SHADOW_NONE)
        return 0;
    *layers = 1;
    if (view->kind == SCENE_SHADOW_FITTED) {
        make_fitted(view, &out[0]);
        return 1;
    }
    make_face(view, right, up, (double[]){0.0, 0.0, 1.0}, &out[count++]);
    if (!half) {
        make_face(view, right, up, (double[]){0.0, 0.0, -1.0}, &out[count]);
        out[count++].layer = (*layers)++;
    }
    for (int side = 0; side < 4; side++) {
        const int number = side / 2;
        const bool below = side % 2;
        make_side(view, number, below, half, &out[count]);
        out[count].half = half;
        out[count].lower = half && !below;
        *layers += !half || !below;
        out[count++].layer = *layers - 1;
    }
    return count;
}
