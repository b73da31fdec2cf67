// SPDX-License-Identifier: BSD-3-Clause
// Texts beside points: each takes, of places around its point, the one that covers least.
#include <math.h>
#include <string.h>

#include "tools/chart/chart.h"

// Of the plots' font at size 11, in pixels; wide enough for any text of that length.
static const double CHARACTER = 8.0, LINE = 17.0;
static const double POINT = 5.0; // half the edge of a mark

struct box {
    double left, right, bottom, top;
};

static struct box text_box(const struct chart_label *label)
{
    const double width = CHARACTER * (double)strlen(label->text);
    const double left = label->side > 0   ? label->at_x
                        : label->side < 0 ? label->at_x - width
                                          : label->at_x - 0.5 * width;
    return (struct box){left, left + width, label->at_y - 0.5 * LINE, label->at_y + 0.5 * LINE};
}

static double overlap(const struct box *a, const struct box *b)
{
    const double width = fmin(a->right, b->right) - fmax(a->left, b->left);
    const double height = fmin(a->top, b->top) - fmax(a->bottom, b->bottom);
    return width > 0.0 && height > 0.0 ? width * height : 0.0;
}

static struct box point_box(double x, double y)
{
    return (struct box){x - POINT, x + POINT, y - POINT, y + POINT};
}

// How much of the line from point to text lies over another text, in pixels.
static double line_overlap(const struct chart_label *label, const struct box *text)
{
    enum { STEPS = 24 };
    int inside = 0;
    for (int i = 1; i < STEPS; i++) {
        const double t = (double)i / STEPS;
        const double x = label->x + t * (label->at_x - label->x);
        const double y = label->y + t * (label->at_y - label->y);
        inside += x > text->left && x < text->right && y > text->bottom && y < text->top;
    }
    return hypot(label->at_x - label->x, label->at_y - label->y) * inside / STEPS;
}

// The place's cost; labels before this one have theirs.
static double cost_of(const struct chart_label *label, const struct chart_label *placed, int count,
                      const double (*points)[2], size_t point_count, double width, double height)
{
    const struct box own = text_box(label);
    double cost = hypot(label->at_x - label->x, label->at_y - label->y);
    if (own.left < 2.0 || own.right > width - 2.0 || own.bottom < 2.0 || own.top > height - 2.0)
        cost += 1e6;
    for (int i = 0; i < count; i++) {
        const struct box other = text_box(&placed[i]);
        cost += 100.0 * overlap(&own, &other) + 20.0 * line_overlap(label, &other) +
                20.0 * line_overlap(&placed[i], &own);
    }
    for (size_t i = 0; i < point_count; i++) {
        const struct box point = point_box(points[i][0], points[i][1]);
        cost += 10.0 * overlap(&own, &point);
    }
    return cost;
}

void chart_labels_place(struct chart_label *label, int count, const double (*points)[2],
                        size_t point_count, double width, double height)
{
    enum { DIRECTIONS = 24, RINGS = 12 };
    for (int i = 0; i < count; i++) {
        struct chart_label best = label[i];
        double best_cost = INFINITY;
        for (int place = 0; place < DIRECTIONS * RINGS; place++) {
            struct chart_label at = label[i];
            const double angle = 2.0 * M_PI * (place % DIRECTIONS) / DIRECTIONS;
            const double radius = 12.0 + 16.0 * (place / DIRECTIONS);
            at.at_x = at.x + radius * cos(angle);
            at.at_y = at.y + radius * sin(angle);
            at.side = cos(angle) > 0.2 ? 1 : cos(angle) < -0.2 ? -1 : 0;
            const double cost = cost_of(&at, label, i, points, point_count, width, height);
            if (cost < best_cost) {
                best = at;
                best_cost = cost;
            }
        }
        label[i] = best;
    }
}
