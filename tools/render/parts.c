// SPDX-License-Identifier: BSD-3-Clause
// What of a scene can reach a part of the picture. Triangles and lines whose boxes on the picture
// are away from it are left out; the others are drawn in their order, with the same numbers, so
// that the part's pixels are the same.
//
// Boxes are in pixels, found in double. OpenGL's clip coordinates are sums of four products of
// floats, off by less than 2^-20 of the sum of the products' magnitudes: each quotient of what they
// may be is within the box, and where the last one may be 0 or less there is none: such triangles
// are always drawn.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/frame.h"
#include "tools/scene/vector.h"

// Pixels that passes move a picture by, and that lines and points are wider than their middle.
enum { MARGIN = 4 };

// ---- boxes --------------------------------------------------------------------------------------

static void widen(double value, double box[2])
{
    box[0] = fmin(box[0], value);
    box[1] = fmax(box[1], value);
}

// Returns false where there is none.
static bool add_vertex(const double clip[16], const float at[3], const int size[2],
                       double box[2][2])
{
    double value[4], off[4];
    for (int row = 0; row < 4; row++) {
        value[row] = clip[12 + row];
        off[row] = fabs(clip[12 + row]);
        for (int axis = 0; axis < 3; axis++) {
            const double product = clip[4 * axis + row] * (double)at[axis];
            value[row] += product;
            off[row] += fabs(product);
        }
        off[row] *= 0x1p-20;
    }
    const double least = value[3] - off[3], most = value[3] + off[3];
    if (!(least > 0.0))
        return false;
    for (int axis = 0; axis < 2; axis++)
        for (int sign = -1; sign <= 1; sign += 2) {
            const double moved = value[axis] + sign * off[axis];
            widen((moved / least + 1.0) * 0.5 * size[axis], box[axis]);
            widen((moved / most + 1.0) * 0.5 * size[axis], box[axis]);
        }
    return true;
}

// Of `corners` vertices each: lowest x and y, highest x and y.
static void find_boxes(const scene_drawing *drawing, int object, const uint32_t *vertex,
                       size_t count, size_t corners, float (*out)[4])
{
    double clip[16];
    scene_multiply(drawing->camera, drawing->model[object], clip);
    for (size_t i = 0; i < count; i++) {
        double box[2][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
        bool bounded = true;
        for (size_t k = 0; k < corners && bounded; k++) {
            const uint32_t number = vertex[i * corners + k];
            bounded = add_vertex(clip, drawing->scene->vertices[number].position,
                                 drawing->frame.camera.size, box);
        }
        for (int axis = 0; axis < 2; axis++) {
            out[i][axis] = bounded ? (float)box[axis][0] : -INFINITY;
            out[i][2 + axis] = bounded ? (float)box[axis][1] : INFINITY;
        }
    }
}

static bool reaches(const float box[4], const struct weft_rectangle *part)
{
    return box[2] >= (float)(part->x - MARGIN) && box[3] >= (float)(part->y - MARGIN) &&
           box[0] <= (float)(part->x + part->width + MARGIN) &&
           box[1] <= (float)(part->y + part->height + MARGIN);
}

// ---- room ---------------------------------------------------------------------------------------

void scene_parts_end(scene_drawing *drawing)
{
    struct scene_parts *p = &drawing->parts;
    const GladGLContext *gl = &drawing->gl;
    gl->DeleteBuffers(4, p->buffer);
    gl->DeleteTextures(2, p->texture);
    free(p->box);
    free(p->index);
    free(p->plane);
    free(p->surface);
    free(p->first);
    free(p->line);
    free(p->line_box);
    free(p->line_first);
    *p = (struct scene_parts){.box = NULL};
}

static bool make_triangles(scene_drawing *drawing, struct scene_parts *p)
{
    const GladGLContext *gl = &drawing->gl;
    const size_t count = drawing->scene->index_count / 3 + 1,
                 objects = (size_t)drawing->scene->object_count + 1;
    if (p->box)
        return true;
    p->box = malloc(count * sizeof *p->box);
    p->index = malloc(3 * count * sizeof *p->index);
    p->plane = malloc(2 * count * sizeof *p->plane);
    p->surface = malloc(2 * count * sizeof *p->surface);
    p->first = calloc(objects, sizeof *p->first);
    if (!p->box || !p->index || !p->plane || !p->surface || !p->first) {
        scene_parts_end(drawing);
        return false;
    }
    // All of them lie behind those that are listed.
    gl->BindBuffer(GL_TEXTURE_BUFFER, drawing->buffers.planes);
    gl->GetBufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)((count - 1) * sizeof *p->plane),
                         p->plane + count);
    gl->BindBuffer(GL_TEXTURE_BUFFER, drawing->buffers.surfaces);
    gl->GetBufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)((count - 1) * sizeof *p->surface),
                         p->surface + count);
    gl->GenBuffers(4, p->buffer);
    gl->GenTextures(2, p->texture);
    return true;
}

static bool make_lines(scene_drawing *drawing, struct scene_parts *p)
{
    const size_t objects = (size_t)drawing->scene->object_count,
                 count =
                     drawing->edges.line_first[objects] + drawing->edges.fold_first[objects] + 1;
    if (p->line_first)
        return true;
    p->line = malloc(count * sizeof *p->line);
    p->line_box = malloc(count * sizeof *p->line_box);
    p->line_first = calloc(objects + 1, sizeof *p->line_first);
    if (p->line && p->line_box && p->line_first)
        return true;
    scene_parts_end(drawing);
    return false;
}

// ---- lists --------------------------------------------------------------------------------------

static void upload(const GladGLContext *gl, GLenum target, GLuint buffer, const void *data,
                   size_t bytes)
{
    gl->BindBuffer(target, buffer);
    gl->BufferData(target, (GLsizeiptr)bytes, data, GL_STREAM_DRAW);
}

static void upload_texels(const GladGLContext *gl, const struct scene_parts *p, int i,
                          GLenum format, const void *data, size_t bytes)
{
    upload(gl, GL_TEXTURE_BUFFER, p->buffer[i], data, bytes);
    gl->BindTexture(GL_TEXTURE_BUFFER, p->texture[i]);
    gl->TexBuffer(GL_TEXTURE_BUFFER, format, p->buffer[i]);
}

static void list_triangles(scene_drawing *drawing, struct scene_parts *p)
{
    const struct scene *scene = drawing->scene;
    const size_t all = scene->index_count / 3 + 1;
    size_t count = 0;
    for (int i = 0; i < scene->object_count; i++) {
        const size_t first = scene->objects[i].first_index / 3,
                     end = first + scene->objects[i].index_count / 3;
        p->first[i] = count;
        if (!p->boxed)
            find_boxes(drawing, i, scene->indices + 3 * first, end - first, 3, p->box + first);
        for (size_t k = first; k < end; k++) {
            if (!reaches(p->box[k], &p->of))
                continue;
            memcpy(&p->index[3 * count], &scene->indices[3 * k], 3 * sizeof *p->index);
            memcpy(p->plane[count], p->plane[all + k], sizeof *p->plane);
            p->surface[count++] = p->surface[all + k];
        }
    }
    p->first[scene->object_count] = count;
    p->boxed = true;
    upload_texels(&drawing->gl, p, 0, GL_RGBA32F, p->plane, count * sizeof *p->plane);
    upload_texels(&drawing->gl, p, 1, GL_R32UI, p->surface, count * sizeof *p->surface);
    // The vertex array that is bound has these indices from now on.
    upload(&drawing->gl, GL_ELEMENT_ARRAY_BUFFER, p->buffer[2], p->index,
           3 * count * sizeof *p->index);
}

static size_t list_some(scene_drawing *drawing, int object, const struct scene_line *line,
                        size_t count, float (*box)[4], size_t at)
{
    struct scene_parts *p = &drawing->parts;
    if (!p->lines_boxed)
        find_boxes(drawing, object, line->vertex, count, 2, box);
    for (size_t k = 0; k < count; k++)
        if (reaches(box[k], &p->lines_of))
            p->line[at++] = line[k];
    return at;
}

// Those of an object that are always drawn, then those of its silhouette.
static void list_lines(scene_drawing *drawing, struct scene_parts *p)
{
    const size_t *first = drawing->edges.line_first, *folds = drawing->silhouette_first;
    const size_t lines = first[drawing->scene->object_count];
    size_t count = 0;
    for (int i = 0; i < drawing->scene->object_count; i++) {
        p->line_first[i] = count;
        count = list_some(drawing, i, drawing->edges.line + first[i], first[i + 1] - first[i],
                          p->line_box + first[i], count);
        count = list_some(drawing, i, drawing->silhouette + folds[i], folds[i + 1] - folds[i],
                          p->line_box + lines + folds[i], count);
    }
    p->line_first[drawing->scene->object_count] = count;
    p->lines_boxed = true;
    upload(&drawing->gl, GL_ELEMENT_ARRAY_BUFFER, p->buffer[3], p->line, count * sizeof *p->line);
}

static bool is_listed(const struct weft_rectangle *a, const struct weft_rectangle *b)
{
    return a->x == b->x && a->y == b->y && a->width == b->width && a->height == b->height;
}

// Of the picture, without the rim that the pass has around it.
static struct weft_rectangle find_part(const scene_drawing *drawing,
                                       const struct weft_antialias_pass *pass)
{
    const int *size = drawing->frame.camera.size;
    return (struct weft_rectangle){pass->part.x - (pass->width - size[0]) / 2,
                                   pass->part.y - (pass->height - size[1]) / 2, pass->part.width,
                                   pass->part.height};
}

const struct scene_parts *scene_parts_list(scene_drawing *drawing,
                                           const struct weft_antialias_pass *pass)
{
    struct scene_parts *p = &drawing->parts;
    const bool lines = pass->stage > WEFT_STAGE_COLOUR && !drawing->by_triangle;
    if ((pass->part.width == pass->width && pass->part.height == pass->height) ||
        !make_triangles(drawing, p) || (lines && !make_lines(drawing, p)))
        return NULL;
    const struct weft_rectangle part = find_part(drawing, pass);
    struct weft_rectangle *of = lines ? &p->lines_of : &p->of;
    bool *listed = lines ? &p->lines_listed : &p->listed;
    if (*listed && is_listed(of, &part)) {
        drawing->gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, p->buffer[lines ? 3 : 2]);
        return p;
    }
    *of = part;
    *listed = true;
    if (lines)
        list_lines(drawing, p);
    else
        list_triangles(drawing, p);
    return p;
}

void scene_parts_forget(scene_drawing *drawing)
{
    struct scene_parts *p = &drawing->parts;
    p->boxed = p->listed = p->lines_boxed = p->lines_listed = false;
}
