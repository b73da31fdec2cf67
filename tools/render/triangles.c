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

// A buffer that shaders read as texels.
static void upload_texels(const GladGLContext *gl, const void *data, size_t bytes, GLenum format,
                          GLuint *buffer, GLuint *texture)
{
    gl->GenBuffers(1, buffer);
    gl->BindBuffer(GL_TEXTURE_BUFFER, *buffer);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, data, GL_STATIC_DRAW);
    gl->GenTextures(1, texture);
    gl->BindTexture(GL_TEXTURE_BUFFER, *texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, format, *buffer);
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
    upload_texels(gl, plane, count * sizeof *plane, GL_RGBA32F, &out->planes, &out->plane_texture);
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

static void upload_lines(const GladGLContext *gl, const struct scene *scene,
                         const struct scene_edges *edges, struct scene_buffers *out)
{
    const size_t objects = (size_t)scene->object_count;
    const size_t bytes = edges->line_first[objects] * sizeof *edges->line;
    gl->GenVertexArrays(1, &out->line_array);
    gl->BindVertexArray(out->line_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, out->vertices);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(struct weft_mesh_vertex),
                            (const void *)offsetof(struct weft_mesh_vertex, position));
    gl->EnableVertexAttribArray(0);
    gl->GenBuffers(1, &out->lines);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out->lines);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   (GLsizeiptr)(bytes + edges->fold_first[objects] * sizeof *edges->line), NULL,
                   GL_DYNAMIC_DRAW);
    gl->BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, (GLsizeiptr)bytes, edges->line);
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

void scene_buffers_add_edges(const GladGLContext *gl, const struct scene *scene,
                             const uint32_t *surface, const struct scene_edges *edges,
                             struct scene_buffers *out)
{
    upload_texels(gl, surface, scene->index_count / 3 * sizeof *surface, GL_R32UI, &out->surfaces,
                  &out->surface_texture);
    if (edges)
        upload_lines(gl, scene, edges, out);
}

void scene_buffers_end(const GladGLContext *gl, struct scene_buffers *buffers)
{
    gl->DeleteVertexArrays(2, (GLuint[]){buffers->vertex_array, buffers->line_array});
    gl->DeleteBuffers(5, (GLuint[]){buffers->vertices, buffers->indices, buffers->planes,
                                    buffers->surfaces, buffers->lines});
    gl->DeleteTextures(2, (GLuint[]){buffers->plane_texture, buffers->surface_texture});
    *buffers = (struct scene_buffers){.vertices = 0};
}
