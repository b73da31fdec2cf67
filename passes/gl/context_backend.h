// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/context_backend.h - what OSMesa and EGL each provide (not installed).
#ifndef WEFT_PASSES_GL_CONTEXT_BACKEND_H
#define WEFT_PASSES_GL_CONTEXT_BACKEND_H

#include "passes/gl/context.h"
#include "passes/gl/gl.h"
#include "passes/gl/sampler.h"

// A library that is opened while the program runs, and the functions wanted of it; both lists are
// NULL-ended.
struct weft_library {
    const char *const *names; // tried in order
    const char *const *functions;
};

// Loads it, for good, and fills a struct of one pointer for each function, in order.
bool weft_library_load(const struct weft_library *library, void *functions, char *why,
                       size_t why_size);
// Whether it is in this process already, whoever loaded it; fills `functions` unless that is NULL.
bool weft_library_loaded(const struct weft_library *library, void *functions);

// What a caller has current in the calling thread; no context: nothing.
struct weft_egl_current {
    void *display, *draw, *read, *context;
    unsigned api;
};
struct weft_osmesa_current {
    void *context, *buffer;
    int type, width, height;
};

struct weft_context_backend {
    const char *platform;
    const struct weft_library *library; // loaded by `create`
    // Creates a core context of at least GL 3.3 in *native. On failure the reason goes to `why`.
    bool (*create)(void **native, char *why, size_t why_size);
    void (*destroy)(void *native);
    bool (*make_current)(void *native);
    void (*release)(void *native); // leaves no context current
    GLADapiproc (*function)(void *native, const char *name);
    bool hardware_only; // a software renderer from it is refused
};

extern const struct weft_context_backend weft_backend_osmesa;
extern const struct weft_context_backend weft_backend_egl_device;
extern const struct weft_context_backend weft_backend_egl_surfaceless;

// Takes what is current in the calling thread away and says what that was; and gives it back. Both
// libraries are asked: their Mesas share one slot for the current context. Neither loads a library.
void weft_egl_take(struct weft_egl_current *out);
void weft_egl_give_back(const struct weft_egl_current *current);
void weft_osmesa_take(struct weft_osmesa_current *out);
void weft_osmesa_give_back(const struct weft_osmesa_current *current);

// Programs once linked stay, as linking takes longer than drawing; from so many on the oldest that
// nobody holds gives way to a new one.
enum { WEFT_PROGRAM_CACHE = 64 };
struct weft_cached_program {
    char *key; // what it was made from
    GLuint program;
    int holders;
};

struct weft_context {
    struct weft_context_info info;
    GladGLContext gl;
    const struct weft_context_backend *backend;
    void *native;
    struct weft_egl_current callers_egl; // while weft's own context is current
    struct weft_osmesa_current callers_osmesa;
    struct weft_cached_program *programs;
    size_t program_count, next_program;
    int programs_linked;                               // so far
    struct weft_sampler samplers[WEFT_SOURCE_FORMATS]; // measured so far; {0}: not yet
    const struct weft_log *log;
};

// Makes the context current; WEFT_ERR_GL when it cannot be. Leaving makes the caller's current
// again.
enum weft_result weft_context_enter(weft_context *context);
void weft_context_leave(weft_context *context);

// Creates the native context and the function table of context->backend, reads its info and binds a
// vertex array for good. On failure nothing is left and the reason is in `why`.
bool weft_context_start(struct weft_context *context, char *why, size_t why_size);
void weft_context_stop(struct weft_context *context); // ends the native context

// Drivers that the environment asks for, or that get too little memory, may end the process when a
// context is made or a shader compiled. Where that is to be feared (variables that Mesa reads, a
// limit of the address space, and a library that is not in use yet), this starts and draws in a
// child first. Returns false, with the reason in `why`, where the child fails or dies.
bool weft_context_trial(const struct weft_context_backend *backend, char *why, size_t why_size);
// What is to be feared, for messages; false: nothing.
bool weft_context_trial_reason(char *text, size_t size);

#endif
