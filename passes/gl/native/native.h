// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/native/native.h - what OSMesa, EGL and callers each provide of contexts (not
// installed).
#ifndef WEFT_PASSES_GL_NATIVE_NATIVE_H
#define WEFT_PASSES_GL_NATIVE_NATIVE_H

#include <stdbool.h>
#include <stddef.h>

#include <glad/gl.h>

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

// What a context is made of that is a caller's own; all NULL: nothing.
struct weft_native_request {
    void *display, *share; // of EGL
    const void *caller;    // struct weft_context_caller
};

struct weft_context_backend {
    const char *platform;
    const struct weft_library *library; // loaded by `create`; NULL: none is
    // Creates a core context of at least GL 3.3 in *native. On failure the reason goes to `why`.
    bool (*create)(const struct weft_native_request *request, void **native, char *why,
                   size_t why_size);
    void (*destroy)(void *native);
    bool (*make_current)(void *native);
    void (*release)(void *native); // leaves no context current, or what the caller wants to be
    GLADapiproc (*function)(void *native, const char *name);
    bool hardware_only; // a software renderer from it is refused
    bool outlived;      // objects live on when the native context ends
    bool callers;       // the context is a caller's: its state is kept, and what else is current
};

extern const struct weft_context_backend weft_backend_osmesa;
extern const struct weft_context_backend weft_backend_egl_device;
extern const struct weft_context_backend weft_backend_egl_surfaceless;
extern const struct weft_context_backend weft_backend_egl_display; // a caller's
extern const struct weft_context_backend weft_backend_egl_share;   // and its objects

// Takes what is current in the calling thread away and says what that was; and gives it back. Both
// libraries are asked: their Mesas share one slot for the current context. Neither loads a library.
// What was drawn in the context `awaited` (NULL: in none), if that is the one taken away, is done
// then.
void weft_egl_take(const void *awaited, struct weft_egl_current *out);
void weft_egl_give_back(const struct weft_egl_current *current);
void weft_osmesa_take(struct weft_osmesa_current *out);
void weft_osmesa_give_back(const struct weft_osmesa_current *current);

#endif
