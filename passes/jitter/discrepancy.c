// SPDX-License-Identifier: BSD-3-Clause
// The worst edges of a set of points.
//
// Let F be the share of the points and A the share of the area on one side of an edge. With the
// edge's direction fixed, F jumps at points and A only grows with the distance: F - A is largest
// where the edge touches a point, from its far side, so that the point is inside, and A - F where
// it touches a point that is outside. So edges through a point p are enough.
//
// Let the edge turn about p. F stays as it is until the edge meets another point, and A changes at
// the rate (l^2 - m^2) / 2, l and m being the lengths of the chord on both sides of p: A is
// stationary where p halves the chord. So these edges through p are enough:
// - those through another point, where F jumps; points on the edge count as inside for F - A and as
//   outside for A - F, for both are limits of edges that lie a little aside;
// - the one whose chord p halves. Of the square: its ends e and 2p - e are where the square's rim
//   meets the rim mirrored at p; these are two opposite corners of the rectangle that both squares
//   share, whose half sides are 1/2 - |x| and 1/2 - |y|; so the normal is (sign(x) (1/2 - |y|),
//   sign(y) (1/2 - |x|)). Where x or y is 0 there are more such edges, next to each other and of
//   the same A, and this is one of them. Of the disc: the edge across the radius through p. Outside
//   the shape no chord is halved.
// The edges through p are met in the order of their directions, so that each costs a step: n^2 log
// n in all.
#include "passes/jitter/discrepancy.h"

#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/jitter/discrepancy_impl.h"
#include "passes/jitter/edge.h"
#include "passes/jitter/points.h"

// Edges whose directions differ by less count as one, since rounding separates points that lie on a
// line: an edge that wide, at most the diagonal long, covers 4e-12 more than the line.
static const double same_direction = 2e-12;

struct search {
    const struct weft_discrepancy_params *params;
    double size;
    struct weft_discrepancy_event *events; // as many as there are points
    struct weft_discrepancy worst;
};

static int compare(const void *a, const void *b)
{
    const double x = ((const struct weft_discrepancy_event *)a)->direction;
    const double y = ((const struct weft_discrepancy_event *)b)->direction;
    return (x > y) - (x < y);
}

static double find_area(const struct search *s, const double normal[2], double distance)
{
    return s->params->shape == WEFT_JITTER_DISC ? weft_edge_disc(distance / s->size)
                                                : weft_edge_square(normal, distance / s->size);
}

// An edge through p whose right side, of the normal (sin, -cos) of the direction, has the points
// p . normal > distance. `left` points are on its left, `on` points on it.
static void judge(struct search *s, const double p[2], double direction, int left, int on)
{
    const double n = s->params->count;
    const double normal[2] = {sin(direction), -cos(direction)};
    const double distance = p[0] * normal[0] + p[1] * normal[1];
    const double area = find_area(s, normal, distance);
    const double more = (left + on) / n - area, less = area - left / n;
    if (!(fmax(more, less) > s->worst.value))
        return;
    s->worst = (struct weft_discrepancy){
        .value = fmax(more, less),
        .angle = direction - M_PI_2,
        .distance = distance,
        .share = more > less ? (left + on) / n : left / n,
        .area = area,
    };
}

// The direction of the edge whose chord p halves.
static double find_stationary(const struct search *s, const double p[2])
{
    if (s->params->shape == WEFT_JITTER_DISC)
        return atan2(p[0], -p[1]);
    const double half = 0.5 * s->size;
    const double normal[2] = {copysign(half - fabs(p[1]), p[0]), copysign(half - fabs(p[0]), p[1])};
    return atan2(normal[0], -normal[1]);
}

// Into [-same_direction, pi - same_direction), so that directions about 0 stay together.
static double fold(double direction, int *ahead)
{
    *ahead = direction >= -same_direction && direction < M_PI - same_direction;
    if (direction < -same_direction)
        return direction + M_PI;
    return *ahead ? direction : direction - M_PI;
}

// Sorts the edges through p and other points; returns how many points do not lie at p itself.
static int collect(struct search *s, const double p[2])
{
    int count = 0;
    for (int i = 0; i < s->params->count; i++) {
        const double x = s->params->points[i][0] - p[0], y = s->params->points[i][1] - p[1];
        if (x == 0.0 && y == 0.0)
            continue;
        struct weft_discrepancy_event *event = &s->events[count++];
        event->direction = fold(atan2(y, x), &event->ahead);
    }
    qsort(s->events, (size_t)count, sizeof *s->events, compare);
    return count;
}

static void turn_about(struct search *s, const double p[2])
{
    const int count = collect(s, p), here = s->params->count - count;
    int left = 0, unused;
    for (int i = 0; i < count; i++)
        left += s->events[i].ahead;
    double stationary = fold(find_stationary(s, p), &unused);
    for (int i = 0; i < count;) {
        const double direction = s->events[i].direction;
        if (stationary <= direction) {
            judge(s, p, stationary, left, here);
            stationary = INFINITY;
        }
        int end = i, ahead = 0;
        for (; end < count && s->events[end].direction - direction <= same_direction; end++)
            ahead += s->events[end].ahead;
        left -= ahead;
        judge(s, p, direction, left, here + end - i);
        left += end - i - ahead;
        i = end;
    }
    if (stationary < INFINITY)
        judge(s, p, stationary, left, here);
}

struct weft_discrepancy weft_discrepancy_find(const struct weft_discrepancy_params *params,
                                              struct weft_discrepancy_event *events, double enough)
{
    struct search s = {
        .params = params, .size = params->size == 0.0 ? 1.0 : params->size, .events = events};
    for (int i = 0; i < params->count && s.worst.value < enough; i++)
        turn_about(&s, params->points[i]);
    return s.worst;
}

enum weft_result weft_discrepancy_compute(const struct weft_discrepancy_params *params,
                                          struct weft_discrepancy *out)
{
    const struct weft_log *log = params ? params->log : NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_discrepancy_event *events = NULL;
    *out = (struct weft_discrepancy){NAN, NAN, NAN, NAN, NAN};
    weft_require(log, params && params->points);
    weft_require_enum(log, params->shape, WEFT_JITTER_SHAPE_COUNT - 1);
    if (params->size != 0.0 && !(params->size >= 0x1p-100 && params->size <= 0x1p100)) {
        weft_error(log, "the size of a set of samples is %g: it must be in 2^-100 to 2^100",
                   params->size);
        goto fail;
    }
    if (params->count < 1 || params->count > WEFT_DISCREPANCY_MAX) {
        weft_error(log, "the discrepancy of %d samples: 1 to %d are looked at", params->count,
                   WEFT_DISCREPANCY_MAX);
        goto fail;
    }
    if (!weft_points_check(params->log, params->points, params->count))
        goto fail;
    events = malloc((size_t)params->count * sizeof *events);
    if (!events) {
        weft_error(log, "no memory for %d samples", params->count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    *out = weft_discrepancy_find(params, events, INFINITY);
    res = WEFT_OK;
fail:
    free(events);
    return res;
}
