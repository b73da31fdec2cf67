// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/context.h - a headless GL context, OSMesa's or EGL's, one in the share group of a
// caller's, or the caller's own, behind one interface (docs/contexts.md).
// GL 3.3 is required (texture buffers, integer shaders, float render targets), core or
// compatibility profile; more is used where present.
#ifndef WEFT_PASSES_GL_CONTEXT_H
#define WEFT_PASSES_GL_CONTEXT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Where contexts come from.
enum weft_context_kind {
    WEFT_CONTEXT_AUTO,   // a hardware EGL device, else OSMesa, else software EGL
    WEFT_CONTEXT_OSMESA, // llvmpipe through OSMesa
    WEFT_CONTEXT_EGL,    // a hardware EGL device if there is one, else the surfaceless platform
};
WEFT_API extern const char *const weft_context_kind_names[]; // "auto", "osmesa", "egl"; NULL-ended

// Finds a kind by its name. Returns WEFT_ERR_ARGUMENT, with the list of names in the log (may be
// NULL); *out is then as it was.
WEFT_API enum weft_result weft_context_kind_parse(const struct weft_log *log, const char *text,
                                                  enum weft_context_kind *out);

// A function of OpenGL, to be cast to its own type.
typedef void (*weft_gl_function)(void);

// A context that the caller has made with whatever there is (GLFW, SDL, GLX, Qt, EGL, ...), for
// weft to use. It must outlive weft's, and nobody else may use it during a call. GL's state is at
// the end of a call what it was at its beginning, but for the content of objects that are given to
// weft, and for what only lives because it is current (a program that is deleted while in use
// ends). passes/gl/native/state.h lists what is kept and changed. Errors of GL that are pending are
// told to the log, and lost. Calls are refused (WEFT_ERR_GL) while a query of samples or primitives
// or transform feedback has begun; conditional rendering must be none of a caller's, too.
struct weft_context_caller {
    // Finds functions of GL by name ("glDrawElements"), those of the core, too; required. The
    // context is current.
    weft_gl_function (*get_proc_address)(void *priv, const char *name);
    // Makes it current in the calling thread, at the beginning of every call that uses the context;
    // false: it cannot be, and the call returns WEFT_ERR_GL. Default NULL: it always is current
    // then, which is looked at.
    bool (*make_current)(void *priv);
    // Called at the end of each of these calls, to make current what was so before, or nothing.
    // Default NULL: the context stays current.
    void (*release)(void *priv);
    void *priv; // of the three
};

struct weft_context_params {
    enum weft_context_kind kind; // default auto; EGL or auto with egl_display, auto with caller
    // An EGLDisplay of the caller's, initialised, on which the context is made, with its
    // surfaceless contexts (EGL_KHR_surfaceless_context); it must outlive weft's context (default
    // NULL: weft's own display).
    void *egl_display;
    // An EGLContext of that display, of OpenGL, whose textures, buffers and programs the context
    // shares: names of textures that the one makes are good in the other (default NULL: none).
    // What that context has drawn is waited for where it is current in the thread that calls weft;
    // otherwise the caller calls glFinish before. What weft has drawn is done when its calls
    // return; GL wants textures bound anew to see it.
    void *egl_share;
    // The caller's own context (default: all NULL, none).
    struct weft_context_caller caller;
    const struct weft_log *log; // may be NULL; borrowed for the context's life
};
#define WEFT_CONTEXT_DEFAULTS
#define weft_context_params(...) (&(struct weft_context_params){WEFT_CONTEXT_DEFAULTS __VA_ARGS__})

// A native context with its functions, and the programs that were linked for it.
// Thread-safety: one thread at a time, with all that is compiled for it. Calls make the context
// current in the calling thread, callbacks included; when they return, what the caller had current
// there of EGL or OSMesa is so again. Of other window systems (GLX, WGL, CGL) the caller has to
// make it current again; or gives its context to weft, as `caller`.
typedef struct weft_context weft_context;

// Creates a context of the first allowed kind that works. libOSMesa and libEGL are loaded when a
// context is first made. Where the environment has variables that choose Mesa's drivers, or limits
// the address space, a child process (fork) tries each kind first, as such drivers may end the
// process. With egl_display or caller nothing else is tried. On failure *out is NULL. Returns
// WEFT_ERR_ARGUMENT (kind; egl_share without egl_display, both with caller; no get_proc_address),
// WEFT_ERR_MEMORY, or WEFT_ERR_CONTEXT when none of the allowed kinds works; the log says why for
// each tried: of a caller's context, which version of GL it has or what it lacks.
WEFT_API enum weft_result weft_context_create(const struct weft_context_params *params,
                                              weft_context **out);

// A context in the making. Loading a software renderer takes tens of milliseconds of processor time
// in which a volume can be opened, planned and read. Thread-safety: one thread at a time.
typedef struct weft_context_making weft_context_making;

// Begins to create a context in a thread of its own, which blocks all signals; where a child
// process has to try first, or something of the caller's is used, it is created when it is awaited.
// params->log is borrowed likewise, and is called by weft_context_await only. On failure *out is
// NULL. Returns WEFT_ERR_ARGUMENT (kind) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_context_begin(const struct weft_context_params *params,
                                             weft_context_making **out);
// Waits for what was begun, and leaves NULL behind. Messages and results are those of
// weft_context_create.
WEFT_API enum weft_result weft_context_await(weft_context_making **making, weft_context **out);
// Waits, too, and destroys the context. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_context_abandon(weft_context_making **making);

// Ends what was linked and created in it, too: compiled plans are destroyed before. A caller's own
// context stays, without what weft made in it. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_context_destroy(weft_context **context);

// What a context is, and its limits. What needs more than those is refused with WEFT_ERR_LIMIT,
// with both numbers in the log, by whatever plans or compiles for the context.
struct weft_context_info {
    const char *platform;                    // "OSMesa", "EGL surfaceless", "EGL device", "EGL
                                             // display", "EGL share group", "caller's"
    const char *vendor, *renderer, *version; // GL's own words
    bool hardware;                           // not a software rasterizer
    int max_target_size;                     // pixels along a side of a render target
    int64_t max_buffer_texels;               // in one texture buffer
};
// Valid while the context lives.
WEFT_API const struct weft_context_info *weft_context_get_info(const weft_context *context);

// ---- drawing of one's own -----------------------------------------------------------------------

// Calls `call` with the context current, for objects of one's own: meshes, programs, shadow maps.
// Textures and framebuffers made there can be given to weft and are drawn with in callbacks
// (passes/accumulate/accumulate.h). It finds GL's default state, may change any of it but
// not the objects of others, and calls nothing of weft with this context but
// weft_context_find_function. Returns what `call` returned, or WEFT_ERR_GL: the context cannot be
// made current, or an error of GL is pending afterwards, which the log tells.
WEFT_API enum weft_result weft_context_call(weft_context *context,
                                            enum weft_result (*call)(void *priv), void *priv);

// Finds a function by its name ("glDrawElements"), for loaders such as glad's. The context is
// current: inside weft_context_call, or a callback. NULL where there is none; some drivers return
// functions for names that they do not know.
WEFT_API weft_gl_function weft_context_find_function(const weft_context *context, const char *name);

WEFT_END_DECLS
#endif
