// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/context.h - a headless GL context: OSMesa or EGL behind one interface.
// GL 3.3 core is required (texture buffers, integer shaders, float render targets); more is used
// where present.
#ifndef WEFT_PASSES_GL_CONTEXT_H
#define WEFT_PASSES_GL_CONTEXT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

enum weft_context_kind {
    WEFT_CONTEXT_AUTO,   // a hardware EGL device, else OSMesa, else software EGL
    WEFT_CONTEXT_OSMESA, // llvmpipe through OSMesa
    WEFT_CONTEXT_EGL,    // a hardware EGL device if there is one, else the surfaceless platform
};

struct weft_context_params {
    enum weft_context_kind kind;
    const struct weft_log *log; // borrowed for the context's life
};

struct weft_context_info {
    const char *platform; // "OSMesa", "EGL surfaceless", "EGL device"
    const char *vendor, *renderer, *version;
    bool hardware;             // not a software rasterizer
    int max_target_size;       // pixels along a side of a render target
    int64_t max_buffer_texels; // in one texture buffer
};

// Thread-safety: one thread at a time. Calls make the context current in the calling thread, callbacks
// included; when they return, what the caller had current there of EGL or OSMesa is so again (of
// other window systems, the caller has to make it current again).
// libOSMesa and libEGL are loaded when a context is first made. Where the environment has variables
// that choose Mesa's drivers, or limits the address space, a child process (fork) tries each kind
// first, as such drivers may end the process.
typedef struct weft_context weft_context;

// Returns WEFT_ERR_CONTEXT when none of the allowed kinds works; the log says why for each tried.
WEFT_API enum weft_result weft_context_create(const struct weft_context_params *params,
                                              weft_context **out);
WEFT_API void weft_context_destroy(weft_context **context); // accepts &NULL, leaves NULL behind
WEFT_API const struct weft_context_info *weft_context_get_info(const weft_context *context);

// "auto", "osmesa", "egl". Returns WEFT_ERR_ARGUMENT, with the list in the log.
WEFT_API enum weft_result weft_context_kind_parse(const struct weft_log *log, const char *text,
                                                  enum weft_context_kind *out);

WEFT_END_DECLS
#endif
