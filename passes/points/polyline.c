// SPDX-License-Identifier: BSD-3-Clause
// Straightened slices: where their pixels lie.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/points/points.h"

// ---- small vectors ------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// By hypot, since squares overflow where lengths do not.
static double length_of(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

// out = a + s b
static void add(const double a[3], double s, const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] + s * b[i];
}

// To length 1; false where there is no direction.
static bool normalise(double v[3])
{
    const double length = length_of(v);
    if (!(length > 1e-12) || !isfinite(length))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

// v mirrored at the plane through 0 that is square to n.
static void reflect(const double v[3], const double n[3], double out[3])
{
    const double square = dot(n, n);
    add(v, square > 0.0 ? -2.0 * dot(n, v) / square : 0.0, n, out);
}

// ---- the line -----------------------------------------------------------------------------------

// Where a segment ends along the line, and what is known at its ends.
struct joint {
    double at;         // along the line
    double tangent[3]; // of length 1
    double across[3];  // likewise, square to it
};

// The length of the segment that ends at point i, and its direction; NAN: none.
static double segment_of(const struct weft_polyline *line, size_t i, double direction[3])
{
    add(line->point[i], -1.0, line->point[i - 1], direction);
    const double length = length_of(direction);
    if (!(length > 0.0) || !isfinite(length))
        return (double)NAN;
    for (int a = 0; a < 3; a++)
        direction[a] /= length;
    return length;
}

double weft_polyline_length(const struct weft_polyline *line)
{
    double sum = 0.0, direction[3];
    if (line->count < 2 || !line->point)
        return (double)NAN;
    for (size_t i = 1; i < line->count; i++)
        sum += segment_of(line, i, direction);
    return isfinite(sum) ? sum : (double)NAN;
}

// Where a line turns straight back, the direction it came from counts.
static void set_tangents(const struct weft_polyline *line, struct joint *joints)
{
    double last[3], next[3];
    segment_of(line, 1, last);
    joints[0].at = 0.0;
    memcpy(joints[0].tangent, last, sizeof last);
    for (size_t i = 1; i < line->count; i++) {
        joints[i].at = joints[i - 1].at + segment_of(line, i, last);
        memcpy(joints[i].tangent, last, sizeof last);
        if (i + 1 == line->count)
            break;
        segment_of(line, i + 1, next);
        add(last, 1.0, next, joints[i].tangent);
        if (!normalise(joints[i].tangent))
            memcpy(joints[i].tangent, last, sizeof last);
    }
}

// false: `up` runs along the line.
static bool set_first(const struct weft_polyline *line, struct joint *first)
{
    double up[3];
    memcpy(up, line->up, sizeof up);
    if (up[0] == 0.0 && up[1] == 0.0 && up[2] == 0.0) {
        int axis = 0;
        for (int a = 1; a < 3; a++)
            axis = fabs(first->tangent[a]) < fabs(first->tangent[axis]) ? a : axis;
        up[axis] = 1.0;
    }
    if (!isfinite(length_of(up)) || length_of(up) == 0.0)
        return false;
    const double scale = 1.0 / length_of(up);
    for (int a = 0; a < 3; a++)
        up[a] *= scale;
    add(up, -dot(up, first->tangent), first->tangent, first->across);
    return length_of(first->across) > 1e-9 && normalise(first->across);
}

// Wang et al., table I: from joint to joint by two reflections.
static void turn(const double from[3], const double to[3], const struct joint *a, struct joint *b)
{
    double along[3], across[3], tangent[3], between[3];
    add(to, -1.0, from, along);
    normalise(along);
    reflect(a->across, along, across);
    reflect(a->tangent, along, tangent);
    add(b->tangent, -1.0, tangent, between);
    reflect(across, between, b->across);
    // Against what roundings add up to.
    add(b->across, -dot(b->across, b->tangent), b->tangent, b->across);
    if (!normalise(b->across))
        memcpy(b->across, a->across, sizeof b->across);
}

static void place_column(const struct weft_polyline *line, const struct joint *from, size_t segment,
                         double at, double centre[3], double across[3])
{
    const struct joint *to = from + 1;
    const double t = (at - from->at) / (to->at - from->at);
    double direction[3];
    add(line->point[segment], -1.0, line->point[segment - 1], direction);
    add(line->point[segment - 1], t, direction, centre);
    for (int a = 0; a < 3; a++)
        across[a] = (1.0 - t) * from->across[a] + t * to->across[a];
    if (!normalise(across))
        memcpy(across, from->across, 3 * sizeof *across);
}

static void place_pixels(const struct weft_polyline *line, const struct joint *joints, int width,
                         int height, double (*position)[3])
{
    const double length = joints[line->count - 1].at;
    size_t segment = 1;
    for (int x = 0; x < width; x++) {
        const double at = (x + 0.5) / width * length;
        double centre[3], across[3];
        while (segment + 1 < line->count && joints[segment].at < at)
            segment++;
        place_column(line, &joints[segment - 1], segment, at, centre, across);
        for (int y = 0; y < height; y++)
            add(centre, ((y + 0.5) / height - 0.5) * line->across, across,
                position[(size_t)y * (size_t)width + (size_t)x]);
    }
}

static enum weft_result check(const struct weft_log *log, const struct weft_polyline *line,
                              int width, int height)
{
    if (!isfinite(weft_polyline_length(line))) {
        weft_error(log,
                   "a line of %zu points: there must be 2 or more, finite, and neighbours apart",
                   line->count);
        return WEFT_ERR_ARGUMENT;
    }
    if (!(line->across > 0.0) || !isfinite(line->across)) {
        weft_error(log, "%g across a line: it must be above 0 and finite", line->across);
        return WEFT_ERR_ARGUMENT;
    }
    if (width < 1 || height < 1 || width > WEFT_SLICE_MAX_SIZE || height > WEFT_SLICE_MAX_SIZE ||
        (int64_t)width * height > WEFT_SLICE_MAX_PIXELS) {
        weft_error(log,
                   "a straightened slice of %d x %d pixels: each side must be 1 to %d, and "
                   "there must be at most %lld in all",
                   width, height, WEFT_SLICE_MAX_SIZE, (long long)WEFT_SLICE_MAX_PIXELS);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result weft_polyline_positions(const struct weft_log *log,
                                         const struct weft_polyline *line, int width, int height,
                                         double (*position)[3])
{
    const enum weft_result res = check(log, line, width, height);
    if (res != WEFT_OK)
        return res;
    struct joint *joints = calloc(line->count, sizeof *joints);
    if (!joints) {
        weft_error(log, "not enough memory for a line of %zu points", line->count);
        return WEFT_ERR_MEMORY;
    }
    set_tangents(line, joints);
    if (!set_first(line, joints)) {
        weft_error(log, "up (%g, %g, %g) is not finite, or runs along the line's first segment",
                   line->up[0], line->up[1], line->up[2]);
        free(joints);
        return WEFT_ERR_ARGUMENT;
    }
    for (size_t i = 1; i < line->count; i++)
        turn(line->point[i - 1], line->point[i], &joints[i - 1], &joints[i]);
    place_pixels(line, joints, width, height, position);
    free(joints);
    return WEFT_OK;
}
