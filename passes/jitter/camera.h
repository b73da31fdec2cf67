// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/camera.h - matrices of a perspective camera for one frame of an accumulation: moved
// by a part of a pixel, and seen from a point of a lens that keeps a plane in focus. After
// accFrustum and accPerspective of the OpenGL Programming Guide (Silicon Graphics, 1993).
//
// Matrices are OpenGL's: 16 numbers in columns, m[4 * column + row], times column vectors; the eye
// looks along -z, x to the right and y up; clip coordinates of what is visible are in [-w, w].
//
// Which way things move. Pixels count as OpenGL counts them: x to the right, y up, from the lower
// left corner; images in files have their rows downwards.
//
//      frame drawn with move = (+1/4, +1/4)       the sample that a pixel takes then
//      +-------------------+                      +-------------------+
//      |              ^    |  everything in the   |                   |  lies at -move from
//      |   picture   /     |  picture is 1/4      |         +         |  the pixel's centre (+):
//      |            o      |  pixel further right |     x             |  left and below
//      |                   |  and further up      |                   |
//      +-------------------+                      +-------------------+
//
// So a sample at (x, y) of a set, y down the rows, is drawn by the move (-x, +y):
// weft_camera_move_to. For weights by kernels (weft_weights_kernel) and for sets that are not
// symmetrical the sign matters. A lens offset moves the eye: with the eye to the right, what lies
// beyond the plane in focus moves right, what lies before it moves left.
//
// Everything is pure, allocates nothing, and may be called from any thread.
#ifndef WEFT_PASSES_JITTER_CAMERA_H
#define WEFT_PASSES_JITTER_CAMERA_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// A camera. Lengths are in the scene's unit.
struct weft_camera {
    double fovy_degrees;             // angle from the lower to the upper edge, in (0, 180)
    double aspect;                   // width / height of what is seen; 0: of the picture in pixels
    double near_distance;            // to the near plane, > 0
    double far_distance;             // to the far plane, > near_distance
    double eye[3], target[3], up[3]; // the middle of the lens; a point it looks at; not along that
};
// Initialiser members: along -z from (0, 0, 0), up y, 45 degrees, 1 to 100.
#define WEFT_CAMERA_DEFAULTS                                                                       \
    .fovy_degrees = 45.0, .near_distance = 1.0, .far_distance = 100.0, .target = {0.0, 0.0, -1.0}, \
    .up = {0.0, 1.0, 0.0},
#define weft_camera(...) (&(struct weft_camera){WEFT_CAMERA_DEFAULTS __VA_ARGS__})

// What one frame of it is. All zero but `size`: the camera as it stands.
struct weft_camera_frame {
    int size[2];    // of the picture in pixels, each > 0 (required)
    double move[2]; // pixels that the picture moves, right and up (default 0)
    double lens[2]; // place on the lens that is looked through, right and up of its middle, in the
                    // scene's unit (default 0)
    double focus;   // distance, along the direction of sight, of the plane that stays where it is;
                    // > 0; needed where `lens` is not 0, or else left alone
};
#define WEFT_CAMERA_FRAME_DEFAULTS
#define weft_camera_frame(...) (&(struct weft_camera_frame){WEFT_CAMERA_FRAME_DEFAULTS __VA_ARGS__})

// Matrices of a frame: position in clip space = projection * view * position.
struct weft_camera_matrices {
    double projection[16]; // off-axis frustum
    double view[16];       // look-at, with the eye at its place on the lens
    double clip[16];       // projection * view
    // The same, each number rounded once.
    float projection_float[16], view_float[16], clip_float[16];
};

// Computes the matrices. With l = -r and b = -t the frustum's edges on the near plane (t = near
// tan(fovy / 2), r = t aspect), W and H the picture's size, e the place on the lens:
//   dx = -(move_x (r - l) / W + e_x near / focus), dy likewise with t - b and H,
// the projection is that of the frustum (l + dx, r + dx, b + dy, t + dy, near, far), and the view
// has the eye e further right and up. Points at the distance `focus` are where they are without e;
// others move e near (1 / focus - 1 / depth) W / (r - l) pixels; all move `move` pixels besides.
// On failure *out is all NAN. Returns WEFT_ERR_ARGUMENT; the log says which member is wrong and
// how: what is above, numbers that are not finite, a target at the eye, an up that is 0 or along
// the direction of sight.
WEFT_API enum weft_result weft_camera_compute(const struct weft_log *log,
                                              const struct weft_camera *camera,
                                              const struct weft_camera_frame *frame,
                                              struct weft_camera_matrices *out);

// Writes the move that draws a sample at `sample` (x to the right, y down the rows, in pixels from
// the pixel's centre): (-x, +y).
WEFT_API void weft_camera_move_to(const double sample[2], double move[2]);

// Returns the diameter, in pixels, of the circle of confusion of a point at `depth` (> 0, along the
// direction of sight) through a lens of diameter `aperture` (>= 0) that is focused at `focus`
// (> 0):
//   c = aperture |1 / focus - 1 / depth| H / (2 tan(fovy / 2)),
// the thin lens's, as wide as the shear above makes it. Where pixels are not square it is an
// ellipse: the larger of its diameters, with W / aspect in place of H. Depth and focus may be
// infinite. NAN where a figure is not in its range.
WEFT_API double weft_camera_circle(const struct weft_camera *camera, const int size[2],
                                   double aperture, double focus, double depth);

WEFT_END_DECLS
#endif
