// SPDX-License-Identifier: BSD-3-Clause
// passes/cpu/cpu.h - the two engines that methods run on, and how the one without OpenGL runs.
// The CPU engine filters with all cores and the widest vectors that the machine has. For one set of
// instructions its results are the same bytes whatever the number of threads; from one set to
// another they differ by roundings, within a plan's bound.
// Plain values and pure functions, thread-safe.
#ifndef WEFT_PASSES_CPU_CPU_H
#define WEFT_PASSES_CPU_CPU_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// What runs a method. Default: OpenGL.
enum weft_engine {
    WEFT_ENGINE_GL,  // programs of a context (passes/gl/context.h), on a GPU or in software
    WEFT_ENGINE_CPU, // threads and vectors, without OpenGL
};
// NULL-ended, in the order of the enum: "gl", "cpu".
WEFT_API extern const char *const weft_engine_names[];

// What products of weights and values are made and added up in. Default: float.
enum weft_sums {
    WEFT_SUMS_FLOAT,  // single precision
    WEFT_SUMS_DOUBLE, // double precision, rounded to a float once; of the CPU engine alone
};
// NULL-ended, in the order of the enum: "float", "double".
WEFT_API extern const char *const weft_sums_names[];

// Sets of instructions that the CPU engine is compiled for. Default: the best one that runs here.
enum weft_instruction_set {
    WEFT_INSTRUCTIONS_AUTO,   // weft_instruction_set_best
    WEFT_INSTRUCTIONS_PLAIN,  // what the compiler makes of C: the only one of other processors
    WEFT_INSTRUCTIONS_SSE2,   // x86-64: vectors of 4 floats
    WEFT_INSTRUCTIONS_AVX2,   // AVX2 and FMA: vectors of 8, products and sums rounded once
    WEFT_INSTRUCTIONS_AVX512, // AVX-512 F, DQ, BW and VL: vectors of 16
};
// NULL-ended, in the order of the enum: "auto", "plain", "sse2", "avx2", "avx512".
WEFT_API extern const char *const weft_instruction_set_names[];

// Returns the best set that the processor and the operating system run; never AUTO.
WEFT_API enum weft_instruction_set weft_instruction_set_best(void);
// Returns whether a set runs here: AUTO and PLAIN always do, values that are no set never.
WEFT_API bool weft_instruction_set_runs(enum weft_instruction_set set);

// How the CPU engine runs. All zero: as fast as it can.
struct weft_cpu {
    int threads; // at once, 1 to WEFT_CPU_MAX_THREADS (default: as many as weft_cpu_threads)
    enum weft_instruction_set instructions; // default auto
};
enum { WEFT_CPU_MAX_THREADS = 1024 };

// Returns how many threads run at once here: processors that the calling thread may use, 1 to
// WEFT_CPU_MAX_THREADS, and at most $WEFT_THREADS where that is set.
WEFT_API int weft_cpu_threads(void);

// Fills in the defaults. Returns WEFT_ERR_ARGUMENT (threads, no such set) or WEFT_ERR_UNSUPPORTED
// (a set that does not run here: the log names the best that does); *out is then as it was.
WEFT_API enum weft_result weft_cpu_resolve(const struct weft_log *log, const struct weft_cpu *cpu,
                                           struct weft_cpu *out);

WEFT_END_DECLS
#endif
