// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/antialias/triangles.h - an application for tests of anti-aliasing: it draws
// triangles with colours and surfaces, in clip coordinates of their own.
#ifndef WEFT_TESTS_PASSES_ANTIALIAS_TRIANGLES_H
#define WEFT_TESTS_PASSES_ANTIALIAS_TRIANGLES_H

#include "passes/antialias/drawing/drawing.h"
#include "passes/gl/context_backend.h"

// Three are a triangle.
struct triangle_vertex {
    float position[4]; // clip coordinates
    float colour[4];
    uint32_t surface;
};

enum { TRIANGLES_PROGRAMS = 64 };

// Members before `context` may be changed between pictures.
struct triangles {
    int first, count; // vertices that are drawn; count 0: all
    // Fragment shaders' texts by stage; NULL: triangles_flat. They may read
    //     flat in vec4 flat_colour; in vec4 smooth_colour; flat in uint surface;
    const char *fragment[WEFT_STAGE_COUNT];
    // A statement of the vertex shader of a stage, behind gl_Position's ("" or NULL: none): with
    // one, that stage has a vertex shader of its own.
    const char *moved[WEFT_STAGE_COUNT];
    // Called before and after the draw of each pass; may be NULL.
    void (*before)(const GladGLContext *gl, const struct weft_antialias_pass *pass);
    void (*after)(const GladGLContext *gl, const struct weft_antialias_pass *pass);
    enum weft_result result; // of the callback
    int calls[WEFT_STAGE_COUNT];

    weft_context *context;
    int vertices;
    GLuint vertex_array, buffer, vertex_shader;
    struct {
        char *key;
        GLuint program;
    } program[TRIANGLES_PROGRAMS];
    int programs;
};

// Fragment shaders: flat_colour, or smooth_colour as WEFT_AT has it, and surface.
extern const char triangles_flat[], triangles_smooth[];

// Uploads them; the test fails where that does.
void triangles_create(weft_context *context, const struct triangle_vertex *vertices, int count,
                      struct triangles *out);
void triangles_destroy(struct triangles *triangles);

// The callback, and it with its triangles.
enum weft_result triangles_draw(void *triangles, const struct weft_antialias_pass *pass);
#define triangles_drawing(t) (&(struct weft_antialias_drawing){.draw = triangles_draw, .priv = (t)})

// Vertices of a flat triangle: corners in pixels of a picture of width x height, y upwards, depth
// 0 to 1 at all three.
void triangle_at(const int size[2], const double corner[3][2], double depth, const float colour[4],
                 uint32_t surface, struct triangle_vertex out[3]);

#endif
