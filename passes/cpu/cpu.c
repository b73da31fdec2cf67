// SPDX-License-Identifier: BSD-3-Clause
#include "passes/cpu/cpu.h"

#include "filter/check.h"
#include "filter/threads.h"

const char *const weft_engine_names[] = {"gl", "cpu", NULL};
const char *const weft_sums_names[] = {"float", "double", NULL};
const char *const weft_instruction_set_names[] = {"auto", "plain", "sse2", "avx2", "avx512", NULL};

bool weft_instruction_set_runs(enum weft_instruction_set set)
{
    switch (set) {
    case WEFT_INSTRUCTIONS_AUTO:
    case WEFT_INSTRUCTIONS_PLAIN:
        return true;
#if defined(__x86_64__)
    case WEFT_INSTRUCTIONS_SSE2:
        return __builtin_cpu_supports("sse2");
    case WEFT_INSTRUCTIONS_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case WEFT_INSTRUCTIONS_AVX512:
        return weft_instruction_set_runs(WEFT_INSTRUCTIONS_AVX2) &&
               __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#endif
    default:
        return false;
    }
}

enum weft_instruction_set weft_instruction_set_best(void)
{
    enum weft_instruction_set best = WEFT_INSTRUCTIONS_AVX512;
    while (!weft_instruction_set_runs(best))
        best--;
    return best;
}

int weft_cpu_threads(void)
{
    const int count = weft_threads_available();
    return count < WEFT_CPU_MAX_THREADS ? count : WEFT_CPU_MAX_THREADS;
}

enum weft_result weft_cpu_resolve(const struct weft_log *log, const struct weft_cpu *cpu,
                                  struct weft_cpu *out)
{
    const enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(log, cpu->instructions, WEFT_INSTRUCTIONS_AVX512);
    weft_require(log, cpu->threads >= 0 && cpu->threads <= WEFT_CPU_MAX_THREADS);
    if (!weft_instruction_set_runs(cpu->instructions)) {
        weft_error(log, "this machine does not run %s instructions; the best that it runs are %s",
                   weft_instruction_set_names[cpu->instructions],
                   weft_instruction_set_names[weft_instruction_set_best()]);
        return WEFT_ERR_UNSUPPORTED;
    }
    *out = (struct weft_cpu){
        .threads = cpu->threads ? cpu->threads : weft_cpu_threads(),
        .instructions = cpu->instructions ? cpu->instructions : weft_instruction_set_best(),
    };
    return WEFT_OK;
fail:
    return res;
}
