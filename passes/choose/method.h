// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/method.h - methods of computing a slice: everything that decides what it costs and
// how wrong it is, as one value, planned and run by the same calls whatever is behind it. A method
// runs on one of three engines: the fused pass of passes/slice/slice.h, which convolves in single
// precision from a source of one of four formats; the same one axis after the other
// (passes/separable/separable.h), for slices along the volume's axes; or the passes of a plan
// (passes/plan/plan.h) on a target of limited precision.
#ifndef WEFT_PASSES_CHOOSE_METHOD_H
#define WEFT_PASSES_CHOOSE_METHOD_H

#include "../fused/work.h"
#include "../plan/work.h"
#include "../separable/work.h"
#include "../slice/multipass.h"

WEFT_BEGIN_DECLS

enum weft_engine { WEFT_ENGINE_FUSED, WEFT_ENGINE_SEPARABLE, WEFT_ENGINE_MULTIPASS };
// NULL-ended, in the order of the enum: "fused", "separable", "passes".
WEFT_API extern const char *const weft_engine_names[];

struct weft_method {
    enum weft_engine engine;
    // Fused: how samples lie and are stored, and how weights are looked up.
    enum weft_layout layout; // not AUTO in lists
    enum weft_source_format source;
    enum weft_lookup lookup;
    int samples; // M of sampled tiles (linear and nearest look-up, passes)
    // Passes.
    struct weft_profile profile;
    enum weft_technique technique;
    int bits; // of kernel tiles; 0: float or half, as the target
};

// "fused interleaved 32f polynomial", "fused plain unorm8 nearest M=64", "separable",
// "passes unorm8 dot4 M=32 8 bits". Returns what snprintf returns.
WEFT_API int weft_method_format(const struct weft_method *method, char *text, size_t size);

// All methods that are worth a look, each once: fused ones of every layout and format with
// polynomial tiles, and sampled ones of M = 16 to 512 by either look-up (where those can save
// anything: with the fastest layout); separable; passes on fp32, fp16, unorm16 and unorm8 with each
// technique and M = 16 to 64 (in 3D; a tile of M = 512 has 2^27 weights there), and dot4 where it
// can be. *out is to be freed. Returns WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_method_list(const struct weft_log *log, struct weft_method **out,
                                           size_t *count);

struct weft_method_params {
    struct weft_method method;
    // kernel, geometry, space, memory, savings to do without, smooth_error, progress, log; what the
    // method decides (layout, source, lookup, samples, range) is taken from there
    struct weft_slice_params slice;
    struct weft_slice_statistics statistics; // of the voxels in reach (weft_footprint_statistics)
};

// What a run does: what every engine does, and the work of the one that it runs on as its room
// describes it, of a plan or before there is one. passes/choose/cost.h weighs it.
struct weft_work {
    enum weft_engine engine;
    double pixels; // of the result
    double voxels; // read, of bricks; 0 for images
    union {
        struct weft_fused_work fused;         // WEFT_ENGINE_FUSED
        struct weft_separable_work separable; // WEFT_ENGINE_SEPARABLE
        struct {
            struct weft_pass_work plan;
            double samples; // mapped and laid out, in the boxes of all rectangles
        } passes;           // WEFT_ENGINE_MULTIPASS
    } of;
};

typedef struct weft_method_plan weft_method_plan; // Thread-safety: read-only once made.

struct weft_method_plan_info {
    struct weft_method method;
    char name[96]; // weft_method_format
    const struct weft_slice_plan_info *slice;
    const struct weft_pass_plan_info *passes; // NULL but for passes
    double bound; // of |result - exact|, in the volume's values: E2 and E3, and the source's codes
    double e1;    // leading term of E1 for a signal that changes as its samples do: see
                  // weft_method_e1
    uint64_t bytes; // voxels, layouts, tiles and targets while running
    double fetches; // per pixel, at most
    // Cells that turn out constant or smooth are not known before and count in full.
    struct weft_work work;
};

// Returns what weft_slice_plan_create and weft_pass_plan_create return, or WEFT_ERR_UNSUPPORTED
// (with a reason in the log at debug level: separable for a slice that is not along the axes, a
// unorm source or target with voxels that are not finite).
WEFT_API enum weft_result weft_method_plan_create(weft_volume *volume,
                                                  const struct weft_method_params *params,
                                                  weft_method_plan **out);
WEFT_API void weft_method_plan_destroy(weft_method_plan **plan); // accepts &NULL
WEFT_API const struct weft_method_plan_info *
weft_method_plan_get_info(const weft_method_plan *plan);
// For weft_slice_verify; the method's own. NULL but for passes: their plan.
WEFT_API const weft_slice_plan *weft_method_plan_get_slice(const weft_method_plan *plan);
WEFT_API const weft_pass_plan *weft_method_plan_get_passes(const weft_method_plan *plan);

struct weft_method_report {
    double seconds; // the whole run: reading voxels, layout, upload, passes, reading back
    struct weft_slice_report slice;
};

// As weft_slice_run.
WEFT_API enum weft_result weft_method_run(weft_context *context, const weft_method_plan *plan,
                                          weft_volume *volume, float *pixels,
                                          const struct weft_progress *progress,
                                          struct weft_method_report *report);

WEFT_END_DECLS
#endif
