// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/method.h - methods of computing a slice: everything that decides what it costs and
// how wrong it is, as one value, planned and run by the same calls whatever is behind it. A method
// is one of four algorithms: the fused pass of passes/slice/slice.h over all taps at once; the
// same one axis after the other (passes/separable/separable.h), for slices along the volume's axes;
// the passes of a plan (passes/plan/plan.h) on a target of limited precision; or filtering by the
// texture sampler (passes/hardware/hardware.h). The first two run on either engine
// (passes/cpu/cpu.h): on OpenGL in single precision, the fused one from a source of one of four
// formats; on the CPU from floats, with sums in single or double precision.
#ifndef WEFT_PASSES_CHOOSE_METHOD_H
#define WEFT_PASSES_CHOOSE_METHOD_H

#include "../fused/work.h"
#include "../hardware/work.h"
#include "../plan/work.h"
#include "../separable/work.h"
#include "../slice/multipass.h"

WEFT_BEGIN_DECLS

// How a method filters. Default: fused.
enum weft_algorithm {
    WEFT_ALGORITHM_FUSED,     // passes/fused/fused.h
    WEFT_ALGORITHM_SEPARABLE, // passes/separable/separable.h
    WEFT_ALGORITHM_MULTIPASS, // passes/multipass/multipass.h
    WEFT_ALGORITHM_HARDWARE,  // passes/hardware/hardware.h
};
// NULL-ended, in the order of the enum: "fused", "separable", "passes", "hardware".
WEFT_API extern const char *const weft_algorithm_names[];

// A method as a value that owns nothing. All zero: the fused pass on OpenGL over floats with exact
// weights, in the layout that memory allows. Algorithm and engine tell which of the other members
// count.
struct weft_method {
    enum weft_algorithm algorithm;
    enum weft_engine engine;        // that runs it (default OpenGL; passes, hardware: no other)
    enum weft_sums sums;            // on the CPU engine (default float)
    enum weft_layout layout;        // fused on OpenGL: how samples lie (default auto;
                                    // weft_method_list has none of that)
    enum weft_source_format source; // likewise, and hardware: how samples are stored (default
                                    // float)
    enum weft_lookup lookup; // fused on OpenGL: how weights are looked up (default polynomial)
    int samples; // likewise with linear or nearest look-up, and passes: M of the tiles (default 0:
                 // as in struct weft_slice_params and struct weft_pass_plan_params)
    struct weft_profile profile;   // passes: the target (default, name empty: unorm8)
    enum weft_technique technique; // passes (default plain)
    int bits; // passes: of the kernel's tiles (default 0: as in struct weft_pass_plan_params); 0
              // also on half and float targets, whose tiles are of the target's format
};

// Writes a method in words: "fused interleaved 32f polynomial", "fused plain unorm8 nearest M=64",
// "separable", "fused cpu double", "separable cpu float", "passes unorm8 dot4 M=32 8 bits",
// "hardware 16f". Cut to size, NUL-terminated where size > 0.
// Returns what snprintf returns.
WEFT_API int weft_method_format(const struct weft_method *method, char *text, size_t size);

// Lists all methods that are worth a look, each once: on OpenGL fused ones of every layout and
// format with polynomial tiles, and in the fastest layout those with sampled tiles of M = 16 to 512
// by either look-up; hardware filtering of every format; separable; passes on fp32, fp16, unorm16
// and unorm8, plain and dot4 with M = 16 to 64 (a 3D tile of M = 512 has 2^27 weights), the other
// techniques of unorm targets with M = 32; on the CPU engine fused and separable ones in both sums.
// Whether a request can be run by them is for weft_method_plan_create to say. The caller frees
// *out, which is NULL on failure. Returns WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_method_list(const struct weft_log *log, struct weft_method **out,
                                           size_t *count);

// A method of a request.
struct weft_method_params {
    struct weft_method method;
    // The request: kernel, geometry (required), space, footprint, memory_bytes, without,
    // smooth_error, clamp_to_samples, limits of the GL, progress, log. Leave engine, sums, source,
    // lookup, samples, low and high 0: the method and the statistics decide them, and the layout.
    struct weft_slice_params slice;
    // Of the voxels in reach, from weft_footprint_statistics (required): the range that sources and
    // passes map to [0, 1], and what the bound is for.
    struct weft_slice_statistics statistics;
    // Hardware: what is to run it has a sampler of the method's source at least as good (default,
    // max_size 0: weft_sampler_assume).
    struct weft_sampler sampler;
};
#define WEFT_METHOD_DEFAULTS
#define weft_method_params(...) (&(struct weft_method_params){WEFT_METHOD_DEFAULTS __VA_ARGS__})

// What a run does, in counts, known from a plan or estimated before there is one. Each one's own
// counts stand in its room's work.h; weft_cost_of turns them into seconds.
struct weft_work {
    enum weft_algorithm algorithm; // and engine: which member of `of` counts
    enum weft_engine engine;
    enum weft_sums sums; // on the CPU engine
    int threads;         // likewise (default 0: as many as the model was measured with)
    double pixels;       // of the result
    double voxels;       // that are read from bricks; 0 for images
    union {
        struct weft_fused_work fused;         // WEFT_ALGORITHM_FUSED on OpenGL
        struct weft_fused_cpu_work fused_cpu; // WEFT_ALGORITHM_FUSED on the CPU
        struct weft_separable_work separable; // WEFT_ALGORITHM_SEPARABLE on either
        struct {
            struct weft_pass_work plan;
            double samples; // that are mapped and laid out, in the boxes of all rectangles
        } passes;           // WEFT_ALGORITHM_MULTIPASS
        struct weft_hardware_work hardware; // WEFT_ALGORITHM_HARDWARE
    } of;
};

// A method, planned. Thread-safety: read-only once made; running it as of its footprint.
typedef struct weft_method_plan weft_method_plan;

// What a planned method is. It belongs to the plan and lives as long.
struct weft_method_plan_info {
    struct weft_method method; // with the bits of tiles that the plan chose
    char name[96];             // weft_method_format
    const struct weft_slice_plan_info *slice;
    const struct weft_pass_plan_info *passes;       // NULL but for passes
    const struct weft_hardware_plan_info *hardware; // NULL but for hardware
    double bound; // of |result - exact|, in the volume's values, for the statistics' voxels: E2,
                  // E3 and the source's codes (weft_bound_compute)
    // Leading term of E1, the kernel's own error, which no method changes, for a signal whose
    // derivatives are as large as its samples' differences (weft_error_e1). NAN for kernels of
    // order 0 or above WEFT_STATISTICS_DIFFERENCES.
    double e1;
    uint64_t bytes; // that a run needs: voxels, layouts, tiles and targets
    double fetches; // per pixel, at most
    // Cells that turn out constant or smooth only when voxels are read count in full.
    struct weft_work work;
};

// Plans a method; *out is NULL on failure. The volume is borrowed for the plan's life. Returns
// WEFT_ERR_ARGUMENT for values that an enum does not have, WEFT_ERR_UNSUPPORTED where the method
// does not apply (double sums on OpenGL; passes and hardware on the CPU engine; a slice that is not
// along the volume's axes for separable; clamp_to_samples, or a kernel without a pair, for
// hardware; voxels that are not finite for a unorm source, or negative for the technique log; a
// half source whose range is too wide: the log has the reason at debug level), and what
// weft_slice_plan_create, weft_pass_plan_create and weft_hardware_plan_create return.
WEFT_API enum weft_result weft_method_plan_create(weft_volume *volume,
                                                  const struct weft_method_params *params,
                                                  weft_method_plan **out);
WEFT_API void weft_method_plan_destroy(weft_method_plan **plan); // accepts &NULL
WEFT_API const struct weft_method_plan_info *
weft_method_plan_get_info(const weft_method_plan *plan);
// The plans that the method is made of, to be looked at and verified (weft_slice_verify). They
// belong to the method's plan. That of passes is NULL for other algorithms.
WEFT_API const weft_slice_plan *weft_method_plan_get_slice(const weft_method_plan *plan);
WEFT_API const weft_pass_plan *weft_method_plan_get_passes(const weft_method_plan *plan);

// What a run took.
struct weft_method_report {
    double seconds; // of all of it: compiling, reading voxels, layout, upload, passes, reading back
    struct weft_slice_report slice;
};

// Where a method runs, and where its pixels go. Borrowed until the call returns.
struct weft_method_run_params {
    weft_context *context; // of methods on OpenGL (required); NULL: passes run on the CPU, in the
                           // same integers. Others leave it alone
    struct weft_cpu cpu;   // how methods on the CPU engine run (default: as fast as they can)
    float *pixels;         // width * height, row after row (required)
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_METHOD_RUN_DEFAULTS
#define weft_method_run_params(...)                                                                \
    (&(struct weft_method_run_params){WEFT_METHOD_RUN_DEFAULTS __VA_ARGS__})

// Compiles a planned method, runs it once and gives up what was compiled. Pixels are written in
// part where the run fails; report may be NULL. Returns what weft_slice_run_once returns.
WEFT_API enum weft_result weft_method_run(const weft_method_plan *plan,
                                          const struct weft_method_run_params *params,
                                          struct weft_method_report *report);

WEFT_END_DECLS
#endif
