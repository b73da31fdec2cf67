// SPDX-License-Identifier: BSD-3-Clause
// Marks in memory: shading edges by contrast, the marks that count most, and marks made wider.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/marks/marks_impl.h"

enum { COMPONENTS = 4 };

// ---- contrast -----------------------------------------------------------------------------------

// What is not finite differs from all but its own kind by infinity: no NAN comes out.
static float difference(float a, float b)
{
    if (a == b || (isnan(a) && isnan(b)))
        return 0.0f;
    const float d = fabsf(a - b);
    return isnan(d) ? INFINITY : d;
}

static float largest_difference(const float *a, const float *b)
{
    float largest = 0.0f;
    for (int c = 0; c < COMPONENTS; c++)
        largest = fmaxf(largest, difference(a[c], b[c]));
    return largest;
}

static void note_pair(float *a, float *b, float d)
{
    *a = fmaxf(*a, d);
    *b = fmaxf(*b, d);
}

// Each pair of neighbours once: to the right, and three in the row above.
static void note_rows(int32_t width, const float *row, const float *above, float *out,
                      float *out_above)
{
    for (int32_t x = 0; x < width; x++) {
        const float *own = row + (ptrdiff_t)x * COMPONENTS;
        if (x + 1 < width)
            note_pair(&out[x], &out[x + 1], largest_difference(own, own + COMPONENTS));
        for (int32_t n = x - 1; above && n <= x + 1; n++)
            if (n >= 0 && n < width)
                note_pair(&out[x], &out_above[n],
                          largest_difference(own, above + (ptrdiff_t)n * COMPONENTS));
    }
}

// Of each pixel of `seen`: the largest |difference| of a component to one of its 3 x 3 neighbours.
// Those of what is marked have them all, but where the picture ends.
static enum weft_result find_differences(const weft_marker *marker, float *out)
{
    const int32_t width = marker->seen.width, height = marker->seen.height;
    const size_t floats = (size_t)width * COMPONENTS;
    float *rows = malloc(2 * floats * sizeof *rows);
    if (!rows)
        return WEFT_ERR_MEMORY;
    memset(out, 0, (size_t)width * (size_t)height * sizeof *out);
    weft_marker_row(marker, 0, rows);
    for (int32_t y = 0; y < height; y++) {
        const float *row = rows + (size_t)(y & 1) * floats;
        float *const above = y + 1 < height ? rows + (size_t)(~y & 1) * floats : NULL;
        float *const line = out + (size_t)y * (size_t)width;
        if (above)
            weft_marker_row(marker, y + 1, above);
        note_rows(width, row, above, line, above ? line + width : NULL);
    }
    free(rows);
    return WEFT_OK;
}

// ---- the marks that count most ------------------------------------------------------------------

struct candidate {
    float difference;
    size_t pixel;
};

static int compare(const void *left, const void *right)
{
    const struct candidate *a = left, *b = right;
    if (a->difference != b->difference)
        return a->difference > b->difference ? -1 : 1;
    return a->pixel < b->pixel ? -1 : 1;
}

// A left pixel whose edge has the contrast D, at a place of which nothing is known, shows one of
// both sides. Where either side has a share of a, evenly distributed from 0 to 1, that is off by
// D min(a, 1 - a), whose mean square is D^2 / 12.
static enum weft_result leave_out(const float *differences, int64_t most, struct weft_marks *marks)
{
    const size_t pixels = weft_part_pixels(&marks->part);
    struct candidate *list = malloc((size_t)marks->count * sizeof *list);
    size_t count = 0;
    double squares = 0.0;
    if (!list)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < pixels; i++)
        if (marks->marked[i])
            list[count++] = (struct candidate){differences[i], i};
    qsort(list, count, sizeof *list, compare);
    for (size_t i = (size_t)most; i < count; i++) {
        marks->marked[list[i].pixel] = 0;
        squares += (double)list[i].difference * (double)list[i].difference;
    }
    free(list);
    marks->left = (int64_t)count - most;
    marks->count = most;
    marks->left_error = sqrt(squares / 12.0 / (double)pixels);
    return WEFT_OK;
}

static void mark_contrasts(const weft_marker *marker, const float *differences,
                           struct weft_marks *marks)
{
    const struct weft_rectangle *found = &marker->found, *seen = &marker->seen;
    for (int32_t y = 0; y < found->height; y++) {
        uint8_t *row = &marks->marked[(size_t)y * (size_t)found->width];
        const float *line = differences + (size_t)(found->y - seen->y + y) * (size_t)seen->width +
                            (found->x - seen->x);
        for (int32_t x = 0; x < found->width; x++)
            if (!row[x] && (double)line[x] > marker->params.contrast) {
                row[x] = 1;
                marks->by_contrast += weft_marker_counts(marker, x, y);
            }
    }
    marks->count += marks->by_contrast;
}

enum weft_result weft_marks_choose(const weft_marker *marker, struct weft_marks *marks)
{
    const struct weft_marker_params *p = &marker->params;
    const size_t pixels = weft_part_pixels(&marker->seen);
    const int64_t most =
        p->max_share > 0.0 ? (int64_t)floor(p->max_share * (double)pixels) : (int64_t)pixels;
    marks->by_edges = marks->count;
    if (!(p->contrast > 0.0) && marks->count <= most)
        return WEFT_OK;
    float *differences = malloc(pixels * sizeof *differences);
    const enum weft_result res =
        differences ? find_differences(marker, differences) : WEFT_ERR_MEMORY;
    if (res == WEFT_OK && p->contrast > 0.0)
        mark_contrasts(marker, differences, marks);
    const enum weft_result chosen =
        res == WEFT_OK && marks->count > most ? leave_out(differences, most, marks) : res;
    free(differences);
    return chosen;
}

// ---- wider marks --------------------------------------------------------------------------------

// Along one line of `count` marks, `step` bytes apart: out[i] is 1 where one of in[i - radius] to
// in[i + radius] is.
static void widen(const uint8_t *in, uint8_t *out, int32_t count, size_t step, int radius)
{
    int32_t last = -1 - radius; // the last mark up to i + radius, or none within reach
    for (int32_t i = 0; i < radius && i < count; i++)
        last = in[(size_t)i * step] ? i : last;
    for (int32_t i = 0; i < count; i++) {
        if (i + radius < count && in[(size_t)(i + radius) * step])
            last = i + radius;
        out[(size_t)i * step] = last >= i - radius;
    }
}

enum weft_result weft_marks_dilate(struct weft_marks *marks, int radius)
{
    if (!marks || !marks->marked || radius < 0 || radius > WEFT_MARKS_MAX_RADIUS)
        return WEFT_ERR_ARGUMENT;
    const struct weft_rectangle part = weft_marks_part(marks);
    const size_t width = (size_t)part.width, height = (size_t)part.height;
    if (radius == 0)
        return WEFT_OK;
    uint8_t *across = malloc(width * height);
    if (!across)
        return WEFT_ERR_MEMORY;
    for (size_t y = 0; y < height; y++)
        widen(marks->marked + y * width, across + y * width, part.width, 1, radius);
    for (size_t x = 0; x < width; x++)
        widen(across + x, marks->marked + x, part.height, width, radius);
    free(across);
    marks->count = 0;
    for (size_t i = 0; i < width * height; i++)
        marks->count += marks->marked[i];
    return WEFT_OK;
}

void weft_marks_clear(struct weft_marks *marks)
{
    if (!marks)
        return;
    free(marks->marked);
    *marks = (struct weft_marks){0};
}
