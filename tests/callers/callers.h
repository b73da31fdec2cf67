// SPDX-License-Identifier: BSD-3-Clause
// tests/callers/callers.h - what the cases of test_callers share: each calls public functions with
// values that their header does not allow, in a child of its own.
#ifndef WEFT_TESTS_CALLERS_CALLERS_H
#define WEFT_TESTS_CALLERS_CALLERS_H

#include <float.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/check.h"
#include "weft.h"

// Exit codes of a child.
enum { CALLERS_COMPLAINTS = 3, CALLERS_SKIPPED = 4 };

// A case, and the functions that it calls, NULL-ended.
struct caller_case {
    void (*run)(void);
    const char *functions[20];
};
#define F(name) "weft_" #name

// Ended by a case without run.
extern const struct caller_case callers_filter[];
extern const struct caller_case callers_tiles[];
extern const struct caller_case callers_plans[];
extern const struct caller_case callers_engines[];
extern const struct caller_case callers_slices[];
extern const struct caller_case callers_images[];
extern const struct caller_case callers_warps[];
extern const struct caller_case callers_accumulate[];
extern const struct caller_case callers_antialias[];
extern const struct caller_case callers_ranks[];
extern const struct caller_case callers_lattice[];
extern const struct caller_case callers_simple[];

// Messages of warnings and errors since the last judgement, and what was found wrong in this child.
extern int callers_lines, callers_complaints;
extern const struct weft_log logger; // counts them

void expect(bool good, int line, const char *what);
#define TRUE(condition) expect(condition, __LINE__, #condition)

// A result that is an error has a line in the log; `refused`: it must be one.
void judge(enum weft_result res, bool refused, int line, const char *what);
#define REFUSED(call) judge(call, true, __LINE__, #call " is refused with a line")
#define SURVIVED(call) judge(call, false, __LINE__, #call " has a line where it fails")

static const int bad_enums[] = {-1, 99, INT_MAX, INT_MIN};
static const int ints[] = {INT_MIN, -1, 0, 1, 99, 1 << 20, INT_MAX};
static const double numbers[] = {NAN,  INFINITY, -INFINITY, DBL_MAX, -1e300,
                                 1e12, 0.0,      -1.0,      1e-300};

// A copy of `base`, p, has each bad value in turn in a member.
#define BAD_ENUM(base, member, call)                                                               \
    for (size_t at_ = 0; at_ < WEFT_COUNT(bad_enums); at_++) {                                     \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))bad_enums[at_];                                           \
        REFUSED(call);                                                                             \
    }
#define ANY_INT(base, member, call)                                                                \
    for (size_t at_ = 0; at_ < WEFT_COUNT(ints); at_++) {                                          \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))ints[at_];                                                \
        SURVIVED(call);                                                                            \
    }
#define ANY_NUMBER(base, member, call)                                                             \
    for (size_t at_ = 0; at_ < WEFT_COUNT(numbers); at_++) {                                       \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))numbers[at_];                                             \
        SURVIVED(call);                                                                            \
    }
#define SET_REFUSED(base, member, value, call)                                                     \
    do {                                                                                           \
        __typeof__(base) p = base;                                                                 \
        p.member = (value);                                                                        \
        REFUSED(call);                                                                             \
    } while (0)

// A kernel by its name.
struct weft_kernel named(const char *text);
// Kernels that are none. The first is all zero: where a header says so, that asks for the default.
enum { BAD_KERNELS = 15 };
struct weft_kernel bad_kernel(int i);

#define EACH_BAD_KERNEL(first, call)                                                               \
    for (int k = first; k < BAD_KERNELS; k++) {                                                    \
        const struct weft_kernel kernel = bad_kernel(k);                                           \
        call;                                                                                      \
    }
#define KERNELS_REFUSED(base, first, call)                                                         \
    EACH_BAD_KERNEL(first, __typeof__(base) p = base; p.kernel = kernel; REFUSED(call))

// A set of tiles, a volume of 4 x 4 x 4 voxels, and a plan of passes; the caller's.
extern const float voxels[4 * 4 * 4];
weft_kernel_tiles *tiles(void);
weft_volume *volume(void);
weft_pass_plan *plan(int dims);
// A GL context; without any the child ends, and its case is skipped.
weft_context *open_context(void);

#endif
