// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/context_backend.h - contexts, whatever provides them (not installed).
#ifndef WEFT_PASSES_GL_CONTEXT_BACKEND_H
#define WEFT_PASSES_GL_CONTEXT_BACKEND_H

#include "passes/gl/context.h"
#include "passes/gl/gl.h"
#include "passes/gl/native/native.h"
#include "passes/gl/native/state.h"
#include "passes/gl/sampler.h"

extern const struct weft_context_backend weft_backend_caller; // request->caller

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
    struct weft_context_caller caller;
    struct weft_native_request request; // of display and share, and the above
    void *native;
    GLuint vertex_array;                 // bound while the context is current
    struct weft_gl_state *state;         // of a caller's context, while weft uses it; else NULL
    struct weft_egl_current callers_egl; // while weft's own context is current
    struct weft_osmesa_current callers_osmesa;
    struct weft_cached_program *programs;
    size_t program_count, next_program;
    int programs_linked;                               // so far
    struct weft_sampler samplers[WEFT_SOURCE_FORMATS]; // measured so far; {0}: not yet
    const struct weft_log *log;
};

// Whether params are what they may be. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_context_check(const struct weft_context_params *params);

// Makes the context current; WEFT_ERR_GL when it cannot be. Leaving makes the caller's current
// again.
enum weft_result weft_context_enter(weft_context *context);
void weft_context_leave(weft_context *context);

// Creates the native context of context->backend and request and the function table, reads its info
// and makes a vertex array. On failure nothing is left and the reason is in `why`.
bool weft_context_start(struct weft_context *context, char *why, size_t why_size);
// Ends the native context; where objects outlive it, programs and vertex array before.
void weft_context_stop(struct weft_context *context);

// Drivers that the environment asks for, or that get too little memory, may end the process when a
// context is made or a shader compiled. Where that is to be feared (variables that Mesa reads, a
// limit of the address space, and a library that is not in use yet), this starts and draws in a
// child first. Returns false, with the reason in `why`, where the child fails or dies.
bool weft_context_trial(const struct weft_context_backend *backend, char *why, size_t why_size);
// What is to be feared, for messages; false: nothing.
bool weft_context_trial_reason(char *text, size_t size);

#endif
