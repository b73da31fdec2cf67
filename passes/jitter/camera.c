// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/camera.h"

#include <math.h>

#include "filter/check.h"

// ---- vectors
// --------------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

// Divides by the length, which it returns.
static double normalise(double v[3])
{
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return length;
}

static void multiply(const double a[16], const double b[16], double out[16])
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int i = 0; i < 4; i++)
                sum += a[4 * i + row] * b[4 * column + i];
            out[4 * column + row] = sum;
        }
}

// ---- checks
// ---------------------------------------------------------------------------------------

static bool complain(const struct weft_log *log, const char *what, double value, const char *range)
{
    weft_error(log, "camera: %s is %g: %s", what, value, range);
    return false;
}

static bool check_lens(const struct weft_log *log, const struct weft_camera *c)
{
    if (!(c->fovy_degrees > 0.0 && c->fovy_degrees < 180.0))
        return complain(log, "fovy", c->fovy_degrees, "it must lie between 0 and 180 degrees");
    if (!(c->aspect == 0.0 || (c->aspect >= 1e-6 && c->aspect <= 1e6)))
        return complain(log, "aspect", c->aspect, "it must be in 1e-6 to 1e6, or 0");
    if (!(c->near_distance > 0.0 && isfinite(c->near_distance)))
        return complain(log, "near_distance", c->near_distance, "it must be above 0");
    if (!(c->far_distance > c->near_distance && isfinite(c->far_distance)))
        return complain(log, "far_distance", c->far_distance, "it must be beyond near_distance");
    return true;
}

static bool check_frame(const struct weft_log *log, const struct weft_camera_frame *f)
{
    for (int axis = 0; axis < 2; axis++) {
        if (f->size[axis] < 1)
            return complain(log, "the picture's size in pixels", f->size[axis],
                            "it must be above 0");
        if (!isfinite(f->move[axis]))
            return complain(log, "move", f->move[axis], "it must be finite");
        if (!isfinite(f->lens[axis]))
            return complain(log, "lens", f->lens[axis], "it must be finite");
    }
    if ((f->lens[0] != 0.0 || f->lens[1] != 0.0) && !(f->focus > 0.0 && isfinite(f->focus)))
        return complain(log, "focus", f->focus, "it must be above 0");
    return true;
}

// Right, up and backwards, as the eye sees them.
static bool find_axes(const struct weft_log *log, const struct weft_camera *c, double right[3],
                      double up[3], double back[3])
{
    double asked[3];
    for (int i = 0; i < 3; i++) {
        const double sum = c->eye[i] + c->target[i] + c->up[i];
        if (!isfinite(sum))
            return complain(log, "a sum of coordinates of eye, target and up", sum,
                            "they must be finite");
        back[i] = c->eye[i] - c->target[i];
        asked[i] = c->up[i];
    }
    const double distance = normalise(back);
    if (!(distance > 0.0 && isfinite(distance)))
        return complain(log, "the distance from eye to target", distance, "it must be above 0");
    const double length = normalise(asked);
    if (!(length > 0.0 && isfinite(length)))
        return complain(log, "the length of up", length, "it must be above 0");
    cross(asked, back, right);
    const double sine = normalise(right);
    if (!(sine > 1e-9))
        return complain(log, "the sine between up and the direction of sight", sine,
                        "it must be above 1e-9");
    cross(back, right, up);
    return true;
}

// ---- matrices
// -------------------------------------------------------------------------------------

static double find_aspect(const struct weft_camera *c, const int size[2])
{
    return c->aspect == 0.0 ? (double)size[0] / size[1] : c->aspect;
}

static double find_tangent(const struct weft_camera *c)
{
    return tan(c->fovy_degrees * M_PI / 360.0);
}

// OpenGL's frustum, about which (r + l) / (r - l) is 2 dx / (r - l), as it is written here: what
// cancels in r + l is not there.
static void project(const struct weft_camera *c, const struct weft_camera_frame *f, double m[16])
{
    const double n = c->near_distance, far = c->far_distance, top = n * find_tangent(c);
    const double half[2] = {top * find_aspect(c, f->size), top};
    for (int i = 0; i < 16; i++)
        m[i] = 0.0;
    for (int axis = 0; axis < 2; axis++) {
        const double e = f->lens[axis], sheared = e == 0.0 ? 0.0 : e * n / f->focus;
        m[5 * axis] = n / half[axis];
        m[8 + axis] = -2.0 * f->move[axis] / f->size[axis] - sheared / half[axis];
    }
    m[10] = -(far + n) / (far - n);
    m[11] = -1.0;
    m[14] = -2.0 * far * n / (far - n);
}

static void look(const struct weft_camera *c, const struct weft_camera_frame *f,
                 const double axes[3][3], double m[16])
{
    for (int row = 0; row < 3; row++) {
        for (int i = 0; i < 3; i++)
            m[4 * i + row] = axes[row][i];
        m[4 * row + 3] = 0.0;
        m[12 + row] = -dot(axes[row], c->eye) - (row < 2 ? f->lens[row] : 0.0);
    }
    m[15] = 1.0;
}

static void round_all(const double from[16], float to[16])
{
    for (int i = 0; i < 16; i++)
        to[i] = (float)from[i];
}

enum weft_result weft_camera_compute(const struct weft_log *log, const struct weft_camera *camera,
                                     const struct weft_camera_frame *frame,
                                     struct weft_camera_matrices *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    double axes[3][3];
    for (int i = 0; i < 16; i++) {
        out->projection[i] = out->view[i] = out->clip[i] = NAN;
        out->projection_float[i] = out->view_float[i] = out->clip_float[i] = NAN;
    }
    weft_require(log, camera && frame);
    if (!check_lens(log, camera) || !check_frame(log, frame) ||
        !find_axes(log, camera, axes[0], axes[1], axes[2]))
        goto fail;
    project(camera, frame, out->projection);
    look(camera, frame, axes, out->view);
    multiply(out->projection, out->view, out->clip);
    round_all(out->projection, out->projection_float);
    round_all(out->view, out->view_float);
    round_all(out->clip, out->clip_float);
    res = WEFT_OK;
fail:
    return res;
}

void weft_camera_move_to(const double sample[2], double move[2])
{
    const double x = sample[0], y = sample[1];
    move[0] = -x;
    move[1] = y;
}

double weft_camera_circle(const struct weft_camera *camera, const int size[2], double aperture,
                          double focus, double depth)
{
    if (!check_lens(NULL, camera) || size[0] < 1 || size[1] < 1)
        return NAN;
    if (!(aperture >= 0.0) || !(focus > 0.0) || !(depth > 0.0))
        return NAN;
    const double across = size[0] / find_aspect(camera, size), along = size[1];
    return aperture * fabs(1.0 / focus - 1.0 / depth) * fmax(across, along) /
           (2.0 * find_tangent(camera));
}
