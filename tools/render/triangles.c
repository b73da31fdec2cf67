// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/triangles.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/scene/vector.h"

void scene_extent_find(const struct scene *scene, const struct scene_object *object,
                       struct scene_extent *out)
{
    for (int axis = 0; axis < 3; axis++) {
        out->low[axis] = INFINITY;
        out->high[axis] = -INFINITY;
    }
    for (uint32_t i = 0; i < object->index_count; i++) {
        const float *p = scene->vertices[scene->indices[object->first_index + i]].position;
        for (int axis = 0; axis < 3; axis++) {
            out->low[axis] = fmin(out->low[axis], p[axis]);
            out->high[axis] = fmax(out->high[axis], p[axis]);
        }
    }
}

static void find_plane(const struct scene *scene, size_t first, float out[4])
{
    const struct weft_mesh_vertex *corner[3];
    double side[2][3], normal[3], least = 1.0;
    for (int i = 0; i < 3; i++)
        corner[i] = &scene->vertices[scene->indices[first + (size_t)i]];
    for (int i = 0; i < 3; i++) {
        side[0][i] = (double)corner[1]->position[i] - corner[0]->position[i];
        side[1][i] = (double)corner[2]->position[i] - corner[0]->position[i];
    }
    scene_cross(side[0], side[1], normal);
    const bool has_area = scene_normalise(normal) > 0.0;
    for (int i = 0; i < 3; i++) {
        const float *n = corner[i]->normal;
        const double cosine = fabs(normal[0] * n[0] + normal[1] * n[1] + normal[2] * n[2]);
        least = fmin(least, cosine);
        out[i] = (float)normal[i];
    }
    const double angle = 2.0 * acos(least);
    out[3] = has_area && angle > 1e-3 ? (float)fmin(tan(fmin(angle, 1.0)), 1.0) : 0.0f;
}

static void upload_planes(const GladGLContext *gl, const float (*plane)[4], size_t count,
                          struct scene_buffers *out)
{
    gl->GenBuffers(1, &out->planes);
    gl->BindBuffer(GL_TEXTURE_BUFFER, out->planes);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)(count * sizeof *plane), plane, GL_STATIC_DRAW);
    gl->GenTextures(1, &out->plane_texture);
    gl->BindTexture(GL_TEXTURE_BUFFER, out->plane_texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, out->planes);
}

static enum weft_result make_planes(const GladGLContext *gl, const struct scene *scene,
                                    struct scene_buffers *out)
{
    const size_t count = scene->index_count / 3;
    float(*plane)[4] = calloc(count + 1, sizeof *plane);
    if (!plane)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < count; i++)
        find_plane(scene, 3 * i, plane[i]);
    upload_planes(gl, (const float(*)[4])plane, count, out);
    free(plane);
    return WEFT_OK;
}

static void upload_triangles(const GladGLContext *gl, const struct scene *scene,
                             struct scene_buffers *out)
{
    static const struct {
        GLint count;
        size_t offset;
    } part[] = {
        {3, offsetof(struct weft_mesh_vertex, position)},
        {3, offsetof(struct weft_mesh_vertex, normal)},
        {2, offsetof(struct weft_mesh_vertex, uv)},
        {3, offsetof(struct weft_mesh_vertex, colour)},
    };
    gl->GenVertexArrays(1, &out->vertex_array);
    gl->BindVertexArray(out->vertex_array);
    gl->GenBuffers(1, &out->vertices);
    gl->BindBuffer(GL_ARRAY_BUFFER, out->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(scene->vertex_count * sizeof *scene->vertices),
                   scene->vertices, GL_STATIC_DRAW);
    gl->GenBuffers(1, &out->indices);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out->indices);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   (GLsizeiptr)(scene->index_count * sizeof *scene->indices), scene->indices,
                   GL_STATIC_DRAW);
    for (GLuint i = 0; i < 4; i++) {
        gl->VertexAttribPointer(i, part[i].count, GL_FLOAT, GL_FALSE,
                                sizeof(struct weft_mesh_vertex), (const void *)part[i].offset);
        gl->EnableVertexAttribArray(i);
    }
}

// ---- making and ending --------------------------------------------------------------------------

enum weft_result scene_buffers_make(const GladGLContext *gl, const struct weft_log *log,
                                    const struct scene *scene, int64_t most,
                                    struct scene_buffers *out)
{
    const size_t count = scene->index_count / 3;
    if ((uint64_t)count > (uint64_t)most) {
        log_error(log, "%zu triangles are more than the %lld texels of a buffer of OpenGL here",
                  count, (long long)most);
        return WEFT_ERR_LIMIT;
    }
    const enum weft_result res = make_planes(gl, scene, out);
    if (res == WEFT_OK)
        upload_triangles(gl, scene, out);
    return res;
}

void scene_buffers_end(const GladGLContext *gl, struct scene_buffers *buffers)
{
    gl->DeleteVertexArrays(1, &buffers->vertex_array);
    gl->DeleteBuffers(3, (GLuint[]){buffers->vertices, buffers->indices, buffers->planes});
    gl->DeleteTextures(1, &buffers->plane_texture);
    *buffers = (struct scene_buffers){.vertices = 0};
}
