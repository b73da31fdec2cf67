// SPDX-License-Identifier: BSD-3-Clause
// Exact pictures: triangles onto the screen, into rows and cells, what is seen there, filtered.
#include "tools/scene/exact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"
#include "tools/scene/exact_parts.h"
#include "tools/scene/vector.h"

// A face that comes to a cell.
struct arrival {
    double nearest; // depth in the cell
    int face;
};

struct picture {
    const struct scene_exact_params *params;
    struct exact_filter filter;
    struct exact_face *face;
    int face_count;
    double brightest; // |component| of all colours
    // Faces of rows from -radius on: row_face[row_first[row]] and on.
    size_t *row_first;
    int *row_face;
    // Of one row: faces of cells from -radius on, and how far each of the row's faces goes.
    size_t *cell_first;
    int *cell_face;
    size_t cell_room;
    int (*range)[2];
    struct arrival *arrival; // room for all faces of a row
    struct exact_cell cell;
    double *out;
};

// ---- faces --------------------------------------------------------------------------------------

static enum weft_result check_colours(const struct scene_exact_params *params)
{
    const struct scene *scene = params->scene;
    for (int o = 0; o < scene->object_count; o++) {
        const struct scene_object *object = &scene->objects[o];
        const struct scene_material *material = &scene->materials[object->material];
        bool plain = material->unlit && material->pattern == SCENE_PLAIN;
        for (uint32_t i = 0; i < object->index_count && plain; i++) {
            const uint32_t *first = &scene->indices[object->first_index + i - i % 3];
            plain = memcmp(scene->vertices[first[i % 3]].colour, scene->vertices[*first].colour,
                           sizeof scene->vertices->colour) == 0;
        }
        if (object->index_count && !plain) {
            log_error(params->log,
                      "exact pictures need unlit materials of one colour a triangle: %s of %s is "
                      "none",
                      material->name, object->name);
            return WEFT_ERR_UNSUPPORTED;
        }
    }
    return WEFT_OK;
}

// How far inside of a plane of the frustum a point is: near and far, and the picture's sides, which
// are left `wide` times as wide, with room for what filters reach.
static double inside(const double clip[4], int plane, const double wide[2])
{
    const double sign = plane % 2 ? -1.0 : 1.0;
    if (plane < 2)
        return clip[3] + sign * clip[2];
    return wide[plane / 2 - 1] * clip[3] + sign * clip[plane / 2 - 1];
}

// Sutherland and Hodgman, "Reentrant polygon clipping", 1974. Returns how many corners are left.
static int clip_plane(double (*corner)[4], int count, int plane, const double wide[2])
{
    double whole[EXACT_FACE_CORNERS][4];
    int kept = 0;
    memcpy(whole, corner, (size_t)count * sizeof *whole);
    for (int i = 0; i < count; i++) {
        const double *a = whole[i], *b = whole[(i + 1) % count];
        const double from = inside(a, plane, wide), to = inside(b, plane, wide);
        if (from >= 0.0)
            memcpy(corner[kept++], a, sizeof *corner);
        if ((from < 0.0) == (to < 0.0))
            continue;
        for (int k = 0; k < 4; k++)
            corner[kept][k] = a[k] + from / (from - to) * (b[k] - a[k]);
        kept++;
    }
    return kept;
}

// The plane of depths through three points in clip coordinates whose x and y are in pixels times w.
// Returns twice their area times all w: less than 0 of backs.
static double find_plane(const double pixel[3][4], double out[3])
{
    double way[3][3], v[3][3], all;
    for (int i = 0; i < 3; i++) {
        v[i][0] = pixel[i][0];
        v[i][1] = pixel[i][1];
        v[i][2] = pixel[i][3];
    }
    for (int i = 0; i < 3; i++)
        scene_cross(v[(i + 1) % 3], v[(i + 2) % 3], way[i]);
    all = scene_dot(v[0], way[0]);
    for (int k = 0; k < 3; k++)
        out[k] =
            (pixel[0][2] * way[0][k] + pixel[1][2] * way[1][k] + pixel[2][2] * way[2][k]) / all;
    return all;
}

// The line through two corners, inside to the left; the same numbers from either end.
static void find_edge(const double a[2], const double b[2], double out[3])
{
    const bool turned = a[0] > b[0] || (a[0] == b[0] && a[1] > b[1]);
    const double *from = turned ? b : a, *to = turned ? a : b;
    const double x = to[0] - from[0], y = to[1] - from[1], length = hypot(x, y);
    const double sign = turned ? -1.0 : 1.0;
    out[0] = length > 0.0 ? -sign * y / length : 0.0;
    out[1] = length > 0.0 ? sign * x / length : 0.0;
    out[2] = -(out[0] * from[0] + out[1] * from[1]);
}

// The face of corners in clip coordinates. false: there is nothing to be seen of it.
static bool make_face(const struct picture *p, double corner[EXACT_FACE_CORNERS][4],
                      const struct scene_material *material, struct exact_face *out)
{
    const int *size = p->params->size;
    double wide[2], pixel[3][4];
    for (int axis = 0; axis < 2; axis++)
        wide[axis] = 1.0 + 4.0 * (p->filter.radius + 1) / size[axis];
    for (int i = 0; i < 3; i++) {
        memcpy(pixel[i], corner[i], sizeof *pixel);
        for (int axis = 0; axis < 2; axis++)
            pixel[i][axis] = 0.5 * size[axis] * (corner[i][axis] + corner[i][3]);
    }
    const double all = find_plane((const double(*)[4])pixel, out->plane);
    int count = 3;
    for (int plane = 0; plane < 6 && count; plane++)
        count = clip_plane(corner, count, plane, wide);
    if (count == 0 || !isfinite(out->plane[0] + out->plane[1] + out->plane[2]) ||
        (all < 0.0 && material->single_sided))
        return false;
    out->count = count;
    out->nearest = INFINITY;
    for (int i = 0; i < count; i++) {
        const double *from = corner[all < 0.0 ? count - 1 - i : i];
        for (int axis = 0; axis < 2; axis++)
            out->corner[i][axis] = 0.5 * size[axis] * (from[axis] / from[3] + 1.0);
        out->nearest = fmin(out->nearest, from[2] / from[3]);
    }
    for (int i = 0; i < count; i++)
        find_edge(out->corner[i], out->corner[(i + 1) % count], out->edge[i]);
    // Of backs emission does not show.
    for (int k = 0; k < 3 && all > 0.0; k++)
        out->colour[k] += material->emission[k];
    return true;
}

static void add_faces(struct picture *p, const struct scene_object *object, const double matrix[16])
{
    const struct scene *scene = p->params->scene;
    const struct scene_material *material = &scene->materials[object->material];
    for (uint32_t t = 0; t + 2 < object->index_count; t += 3) {
        const uint32_t *index = &scene->indices[object->first_index + t];
        struct exact_face *face = &p->face[p->face_count];
        double corner[EXACT_FACE_CORNERS][4];
        for (int i = 0; i < 3; i++) {
            const float *v = scene->vertices[index[i]].position;
            for (int k = 0; k < 4; k++)
                corner[i][k] =
                    matrix[k] * v[0] + matrix[4 + k] * v[1] + matrix[8 + k] * v[2] + matrix[12 + k];
        }
        for (int k = 0; k < 3; k++)
            face->colour[k] = (double)material->reflectance[k] * scene->vertices[*index].colour[k];
        face->colour[3] = 1.0;
        p->face_count += make_face(p, corner, material, face);
    }
}

static enum weft_result make_faces(struct picture *p)
{
    const struct scene *scene = p->params->scene;
    struct weft_camera camera;
    struct weft_camera_matrices matrices;
    struct weft_camera_frame frame = {.size = {p->params->size[0], p->params->size[1]}};
    scene_camera_at(scene, p->params->time, &camera);
    const enum weft_result res = weft_camera_compute(p->params->log, &camera, &frame, &matrices);
    if (res != WEFT_OK)
        return res;
    p->face = calloc(scene->index_count / 3 + 1, sizeof *p->face);
    if (!p->face)
        return WEFT_ERR_MEMORY;
    for (int o = 0; o < scene->object_count; o++) {
        double model[16], matrix[16];
        scene_path_at(&scene->objects[o].path, p->params->time, model);
        scene_multiply(matrices.clip, model, matrix);
        add_faces(p, &scene->objects[o], matrix);
    }
    for (int k = 0; k < 4; k++)
        p->brightest = fmax(p->brightest, fabs(scene->background[k]));
    for (int i = 0; i < p->face_count; i++)
        for (int k = 0; k < 4; k++)
            p->brightest = fmax(p->brightest, fabs(p->face[i].colour[k]));
    return WEFT_OK;
}

// ---- rows ---------------------------------------------------------------------------------------

static int count_rows(const struct picture *p, int axis)
{
    return p->params->size[axis] + 2 * p->filter.radius;
}

// Rows, or columns, that lie between two places. false: none of those that count.
static bool find_range(const struct picture *p, int axis, double low, double high, int range[2])
{
    const int radius = p->filter.radius, last = p->params->size[axis] + radius - 1;
    if (high < -radius || low > last + 1)
        return false;
    range[0] = (int)floor(fmax(low, -radius));
    range[1] = (int)fmin(floor(high), last);
    return range[0] <= range[1];
}

static bool find_rows(const struct picture *p, const struct exact_face *face, int range[2])
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < face->count; i++) {
        low = fmin(low, face->corner[i][1]);
        high = fmax(high, face->corner[i][1]);
    }
    return find_range(p, 1, low, high, range);
}

// The columns that a face has between two heights: of its corners there, and of where its edges
// pass them.
static bool find_columns(const struct picture *p, const struct exact_face *face, int row,
                         int range[2])
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < face->count; i++) {
        const double *a = face->corner[i], *b = face->corner[(i + 1) % face->count];
        if (a[1] >= row && a[1] <= row + 1) {
            low = fmin(low, a[0]);
            high = fmax(high, a[0]);
        }
        for (int side = row; side <= row + 1; side++) {
            if ((a[1] < side) == (b[1] < side))
                continue;
            const double x = a[0] + (side - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            low = fmin(low, x);
            high = fmax(high, x);
        }
    }
    return low <= high && find_range(p, 0, low, high, range);
}

// Turns counts, each at its place + 1, into where each begins.
static void add_up(size_t *first, int count)
{
    first[0] = 0;
    for (int i = 0; i < count; i++)
        first[i + 1] += first[i];
}

// Which faces each row has, in their order; and room for what one row takes.
static enum weft_result make_rows(struct picture *p)
{
    const int rows = count_rows(p, 1), columns = count_rows(p, 0), radius = p->filter.radius;
    int range[2];
    size_t most = 0;
    p->row_first = calloc((size_t)rows + 2, sizeof *p->row_first);
    p->cell_first = calloc((size_t)columns + 2, sizeof *p->cell_first);
    if (!p->row_first || !p->cell_first)
        return WEFT_ERR_MEMORY;
    size_t *first = p->row_first;
    for (int i = 0; i < p->face_count; i++)
        if (find_rows(p, &p->face[i], range))
            for (int y = range[0]; y <= range[1]; y++)
                first[y + radius + 2]++;
    for (int y = 0; y < rows; y++)
        most = first[y + 2] > most ? first[y + 2] : most;
    add_up(first + 1, rows);
    p->row_face = calloc(first[rows + 1] + 1, sizeof *p->row_face);
    p->range = calloc(most + 1, sizeof *p->range);
    p->arrival = calloc(most + 1, sizeof *p->arrival);
    if (!p->row_face || !p->range || !p->arrival)
        return WEFT_ERR_MEMORY;
    for (int i = 0; i < p->face_count; i++)
        if (find_rows(p, &p->face[i], range))
            for (int y = range[0]; y <= range[1]; y++)
                p->row_face[first[y + radius + 1]++] = i;
    return WEFT_OK;
}

// Which faces each cell of a row has.
static enum weft_result make_cells(struct picture *p, int row)
{
    const int columns = count_rows(p, 0), radius = p->filter.radius;
    const size_t begin = p->row_first[row + radius], end = p->row_first[row + radius + 1];
    size_t *first = p->cell_first;
    memset(first, 0, ((size_t)columns + 2) * sizeof *first);
    for (size_t i = begin; i < end; i++) {
        int *range = p->range[i - begin];
        if (!find_columns(p, &p->face[p->row_face[i]], row, range))
            range[1] = range[0] - 1;
        for (int x = range[0]; x <= range[1]; x++)
            first[x + radius + 2]++;
    }
    add_up(first + 1, columns);
    if (first[columns + 1] > p->cell_room) {
        free(p->cell_face);
        p->cell_room = 2 * first[columns + 1];
        p->cell_face = calloc(p->cell_room, sizeof *p->cell_face);
    }
    if (!p->cell_face && p->cell_room)
        return WEFT_ERR_MEMORY;
    for (size_t i = begin; i < end; i++)
        for (int x = p->range[i - begin][0]; x <= p->range[i - begin][1]; x++)
            p->cell_face[first[x + radius + 1]++] = p->row_face[i];
    return WEFT_OK;
}

// ---- cells --------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const struct arrival *x = a, *y = b;
    if (x->nearest != y->nearest)
        return x->nearest < y->nearest ? -1 : 1;
    return (x->face > y->face) - (x->face < y->face);
}

// Nearest first, so that what is hidden cuts nothing.
static void show_faces(struct picture *p, const int at[2])
{
    const size_t begin = p->cell_first[at[0] + p->filter.radius];
    const size_t count = p->cell_first[at[0] + p->filter.radius + 1] - begin;
    exact_cell_begin(&p->cell, at, p->filter.cut, p->filter.parts);
    for (size_t i = 0; i < count; i++) {
        p->arrival[i].face = p->cell_face[begin + i];
        p->arrival[i].nearest = exact_cell_nearest(&p->cell, p->arrival[i].face);
    }
    if (count > 1)
        qsort(p->arrival, count, sizeof *p->arrival, compare);
    for (size_t i = 0; i < count && !p->cell.full; i++)
        if (!exact_cell_show(&p->cell, p->arrival[i].face, p->arrival[i].nearest))
            return;
}

// What a piece gives to the pixels around its cell.
static void add_piece(struct picture *p, const int at[2], const struct exact_piece *piece)
{
    enum { SIDE = 2 * EXACT_MAX_RADIUS + 1 };
    const int radius = p->filter.radius, side = 2 * radius + 1, *size = p->params->size;
    const double *colour =
        piece->face < 0 ? p->params->scene->background : p->face[piece->face].colour;
    double share[SIDE * SIDE];
    memset(share, 0, (size_t)(side * side) * sizeof *share);
    exact_filter_add(&p->filter, piece, share);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            const int to[2] = {at[0] + x - radius, at[1] + y - radius};
            if (to[0] < 0 || to[1] < 0 || to[0] >= size[0] || to[1] >= size[1])
                continue;
            double *out = &p->out[4 * ((size_t)to[1] * (size_t)size[0] + (size_t)to[0])];
            for (int k = 0; k < 4; k++)
                out[k] += share[y * side + x] * colour[k];
        }
}

static enum weft_result draw_row(struct picture *p, int row)
{
    const enum weft_result res = make_cells(p, row);
    if (res != WEFT_OK)
        return res;
    for (int x = -p->filter.radius; x < p->params->size[0] + p->filter.radius; x++) {
        const int at[2] = {x, row};
        show_faces(p, at);
        if (p->cell.full)
            return WEFT_ERR_MEMORY;
        for (int i = 0; i < p->cell.count; i++)
            add_piece(p, at, &p->cell.piece[i]);
    }
    return WEFT_OK;
}

static enum weft_result draw(struct picture *p)
{
    const struct weft_progress *progress = p->params->progress;
    const int radius = p->filter.radius, rows = count_rows(p, 1);
    p->cell.faces = p->face;
    enum weft_result res = make_rows(p);
    for (int row = 0; row < rows && res == WEFT_OK; row++) {
        if (progress && progress->report && !progress->report(progress->priv, (double)row / rows))
            return WEFT_ERR_CANCELLED;
        res = draw_row(p, row - radius);
    }
    return res;
}

enum weft_result scene_exact_draw(const struct scene_exact_params *params, double *out,
                                  double *error)
{
    struct picture p = {.params = params, .out = out};
    *error = NAN;
    memset(out, 0, 4 * (size_t)params->size[0] * (size_t)params->size[1] * sizeof *out);
    enum weft_result res = check_colours(params);
    if (res == WEFT_OK)
        res = exact_filter_make(params, &p.filter);
    if (res == WEFT_OK)
        res = make_faces(&p);
    if (res == WEFT_OK)
        res = draw(&p);
    if (res == WEFT_OK)
        *error = p.brightest * p.filter.error;
    if (res == WEFT_ERR_MEMORY)
        log_error(params->log, "out of memory for an exact picture of %d x %d pixels",
                  params->size[0], params->size[1]);
    exact_filter_clear(&p.filter);
    exact_cell_end(&p.cell);
    free(p.face);
    free(p.row_first);
    free(p.row_face);
    free(p.cell_first);
    free(p.cell_face);
    free(p.range);
    free(p.arrival);
    return res;
}
