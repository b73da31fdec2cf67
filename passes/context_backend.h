// SPDX-License-Identifier: BSD-3-Clause
// passes/context_backend.h - what OSMesa and EGL each provide (not installed).
#ifndef WEFT_PASSES_CONTEXT_BACKEND_H
#define WEFT_PASSES_CONTEXT_BACKEND_H

#include "passes/context.h"
#include "tiles/gl.h"

struct weft_context_backend {
    const char *platform;
    // Creates a core context of at least GL 3.3 in *native. On failure the reason goes to `why`.
    bool (*create)(void **native, char *why, size_t why_size);
    void (*destroy)(void *native);
    bool (*make_current)(void *native);
    void (*release)(void *native); // leaves no context current
    GLADapiproc (*function)(const char *name);
    bool hardware_only; // a software renderer from it is refused
};

extern const struct weft_context_backend weft_backend_osmesa;
extern const struct weft_context_backend weft_backend_egl_device;
extern const struct weft_context_backend weft_backend_egl_surfaceless;

// Programs once linked stay for the context's life: a slice needs two, compiling takes longer than
// drawing. The oldest gives way.
enum { WEFT_PROGRAM_CACHE = 64 };
struct weft_cached_program {
    char *key; // what it was made from
    GLuint program;
};

struct weft_context {
    struct weft_context_info info;
    GladGLContext gl;
    const struct weft_context_backend *backend;
    void *native;
    struct weft_cached_program programs[WEFT_PROGRAM_CACHE];
    size_t next_program;
    const struct weft_log *log;
};

// Makes the context current; WEFT_ERR_GL when it cannot be.
enum weft_result weft_context_enter(weft_context *context);
void weft_context_leave(weft_context *context);

#endif
