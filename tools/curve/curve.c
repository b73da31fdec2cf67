// SPDX-License-Identifier: BSD-3-Clause
#include "tools/curve/curve.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

enum { MAX_POINTS = 1 << 20, LONGER_SIDE = 1024 };

void curve_clear(struct curve *curve)
{
    free(curve->position);
    *curve = (struct curve){0};
}

static enum weft_result allocate(struct curve *curve)
{
    const size_t count = (size_t)curve->width * (size_t)curve->height;
    curve->position = calloc(count, sizeof *curve->position);
    if (curve->position)
        return WEFT_OK;
    report_error("out of memory: %zu bytes for %d x %d positions", count * sizeof *curve->position,
                 curve->width, curve->height);
    return WEFT_ERR_MEMORY;
}

// ---- images -------------------------------------------------------------------------------------

static enum weft_result find_channels(const char *path, const struct weft_image *image,
                                      const float *plane[3])
{
    static const char *const names[] = {"X", "Y", "Z"};
    for (int a = 0; a < 3; a++) {
        plane[a] = NULL;
        for (size_t i = 0; i < image->channel_count; i++)
            if (strcmp(image->channels[i].name, names[a]) == 0)
                plane[a] = image->channels[i].plane;
        if (!plane[a]) {
            report_error("%s: no channel %s: positions are in channels X, Y and Z", path, names[a]);
            return WEFT_ERR_FORMAT;
        }
    }
    return WEFT_OK;
}

static enum weft_result take_positions(const char *path, const struct weft_image *image, int width,
                                       int height, struct curve *out)
{
    const float *plane[3];
    if ((width && width != image->width) || (height && height != image->height)) {
        report_error("%s has %d x %d positions, and --size asks for %d x %d pixels", path,
                     image->width, image->height, width, height);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = find_channels(path, image, plane);
    if (res != WEFT_OK)
        return res;
    out->width = image->width;
    out->height = image->height;
    res = allocate(out);
    if (res != WEFT_OK)
        return res;
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
        for (int a = 0; a < 3; a++)
            out->position[i][a] = (double)plane[a][i];
    return WEFT_OK;
}

enum weft_result curve_load_positions(const char *path, int threads, int width, int height,
                                      struct curve *out)
{
    struct weft_image image;
    *out = (struct curve){0};
    report_stage("reading", path);
    enum weft_result res = weft_image_load(
        weft_image_load_params(.path = path, .threads = threads, .log = report_log()), &image);
    if (res != WEFT_OK)
        return res;
    res = take_positions(path, &image, width, height, out);
    weft_image_clear(&image);
    if (res != WEFT_OK)
        curve_clear(out);
    return res;
}

// ---- lines --------------------------------------------------------------------------------------

struct points {
    double (*point)[3];
    size_t count, room;
};

static enum weft_result add_point(const char *path, struct points *points, const double p[3])
{
    if (points->count == MAX_POINTS) {
        report_error("%s has more than %d points", path, MAX_POINTS);
        return WEFT_ERR_LIMIT;
    }
    if (points->count == points->room) {
        const size_t room = 2 * points->room + 64;
        void *grown = realloc(points->point, room * sizeof *points->point);
        if (!grown)
            return WEFT_ERR_MEMORY;
        points->point = grown;
        points->room = room;
    }
    memcpy(points->point[points->count++], p, sizeof *points->point);
    return WEFT_OK;
}

// Three numbers with commas or blanks between them, and nothing else.
static bool read_point(const char *at, double out[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        out[i] = strtod(at, &end);
        if (end == at || !isfinite(out[i]))
            return false;
        end += strspn(end, " \t");
        at = i < 2 && *end == ',' ? end + 1 : end;
    }
    return !at[strspn(at, " \t\r\n")];
}

static enum weft_result read_points(const char *path, FILE *in, struct points *points)
{
    char *line = NULL;
    size_t room = 0;
    enum weft_result res = WEFT_OK;
    for (long long n = 1; res == WEFT_OK && getline(&line, &room, in) >= 0; n++) {
        const char *at = line + strspn(line, " \t");
        double p[3];
        if (!at[strspn(at, "\r\n")] || *at == '#')
            continue;
        if (read_point(at, p)) {
            res = add_point(path, points, p);
        } else {
            report_error("%s, line %lld: not a point: X,Y,Z, all finite", path, n);
            res = WEFT_ERR_FORMAT;
        }
    }
    free(line);
    if (res == WEFT_OK && ferror(in)) {
        report_error("%s cannot be read: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    return res;
}

// Square pixels, as far as a side has one.
static void choose_size(double length, double across, int width, int height, struct curve *out)
{
    const double ratio = across / length;
    if (!width && !height)
        *(ratio > 1.0 ? &height : &width) = LONGER_SIDE;
    const double other = width ? width * ratio : height / ratio;
    const double side = fmin(fmax(round(other), 1.0), WEFT_SLICE_MAX_SIZE);
    out->width = width ? width : (int)side;
    out->height = height ? height : (int)side;
}

static enum weft_result place_pixels(const char *path, const struct points *points, double across,
                                     int width, int height, struct curve *out)
{
    const struct weft_polyline line = {
        .count = points->count, .point = (const double(*)[3])points->point, .across = across};
    if (points->count < 2) {
        report_error("%s has %zu point%s: a line takes 2 or more", path, points->count,
                     points->count == 1 ? "" : "s");
        return WEFT_ERR_FORMAT;
    }
    out->length = weft_polyline_length(&line);
    if (!(out->length > 0.0)) {
        report_error("%s is no line: neighbouring points must be apart", path);
        return WEFT_ERR_FORMAT;
    }
    choose_size(out->length, across, width, height, out);
    const enum weft_result res = allocate(out);
    return res == WEFT_OK ? weft_polyline_positions(report_log(), &line, out->width, out->height,
                                                    out->position)
                          : res;
}

enum weft_result curve_load_line(const char *path, double across, int width, int height,
                                 struct curve *out)
{
    struct points points = {NULL, 0, 0};
    FILE *in = fopen(path, "re");
    *out = (struct curve){0};
    if (!in) {
        report_error("%s cannot be opened: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    enum weft_result res = read_points(path, in, &points);
    fclose(in);
    if (res == WEFT_OK)
        res = place_pixels(path, &points, across, width, height, out);
    free(points.point);
    if (res != WEFT_OK)
        curve_clear(out);
    return res;
}
