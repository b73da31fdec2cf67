// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_records.h - the records behind weft_kernel_list, one file per family (not
// installed).
#ifndef WEFT_FILTER_KERNELS_KERNEL_RECORDS_H
#define WEFT_FILTER_KERNELS_KERNEL_RECORDS_H

#include "filter/kernels/kernel.h"

WEFT_BEGIN_DECLS

// A kernel with n derivatives is an array of n + 1 records, the kernel first. A family is a
// function family(kernel, x, n) for the n-th derivative; this makes functions family_n of it for
// records.
#define WEFT_KERNEL_NTH(family, n)                                                                 \
    static double family##_##n(const struct weft_kernel *kernel, double x)                         \
    {                                                                                              \
        return family(kernel, x, n);                                                               \
    }

#define WEFT_KERNEL_UNWRAP(...) __VA_ARGS__
#define WEFT_KERNEL_LOWER(value, n) ((value) - (n) < -1 ? -1 : (value) - (n))

// The record itself: `own` is a parenthesised list of members, the rest is shared with derivatives.
#define WEFT_KERNEL_RECORD(text, family, its_degree, its_continuity, own, ...)                     \
    {                                                                                              \
        .name = text, .weight = family##_0, .derivative = (its_degree) ? family##_1 : NULL,        \
        .degree = its_degree, .continuity = its_continuity, WEFT_KERNEL_UNWRAP own, __VA_ARGS__    \
    }

#define WEFT_KERNEL_D(self, text, family, its_degree, its_continuity, its_order, ...)              \
    {                                                                                              \
        .name = "d-" text, .description = "first derivative of " text, .weight = family##_1,       \
        .derivative = (its_degree) != 1 ? family##_2 : NULL, .primitive = &(self)[0],              \
        .derivation = 1, .degree = WEFT_KERNEL_LOWER(its_degree, 1),                               \
        .continuity = WEFT_KERNEL_LOWER(its_continuity, 1), .order = its_order, __VA_ARGS__        \
    }

#define WEFT_KERNEL_DD(self, text, family, third, its_degree, its_continuity, its_order, ...)      \
    {                                                                                              \
        .name = "dd-" text, .description = "second derivative of " text, .weight = family##_2,     \
        .derivative = third, .primitive = &(self)[0], .derivation = 2,                             \
        .degree = WEFT_KERNEL_LOWER(its_degree, 2),                                                \
        .continuity = WEFT_KERNEL_LOWER(its_continuity, 2), .order = its_order, __VA_ARGS__        \
    }

// kernel_list.c: the record of a name that need not end there; NULL if there is none.
const struct weft_kernel_info *weft_kernel_find_word(const char *name, size_t length);
// Whether such a text is a name, capitals, '_' and ' ' aside; and the length of the "d-" or "dd-"
// in front of one.
bool weft_kernel_names_alike(const char *name, const char *text, size_t length);
size_t weft_kernel_derivative_prefix(const char *text);
bool weft_kernel_is_listed(const struct weft_kernel_info *info);
size_t weft_kernel_param_count(const struct weft_kernel_info *info);
// What a record is, or is the derivative of.
const struct weft_kernel_info *weft_kernel_primitive(const struct weft_kernel_info *info);
// Names of the catalogue, with a comma between them: `prefiltered` ones alone, with their "i", or
// all that are no derivatives.
void weft_kernel_list_names(bool prefiltered, char *text, size_t size);
// WEFT_ERR_ARGUMENT, with the names of those that have one, for records without a prefilter.
enum weft_result weft_kernel_check_prefilter(const struct weft_log *log,
                                             const struct weft_kernel_info *info);

// kernel_text.c: what stands behind a kernel's name, "+radial" and "+unit", alone or in either
// order; false for any other text. They are applied in the order that weft_kernel_make_radial asks
// for.
struct weft_kernel_flags {
    bool radial, unit;
};
bool weft_kernel_read_flags(const char *text, struct weft_kernel_flags *flags);
enum weft_result weft_kernel_apply_flags(const struct weft_log *log, struct weft_kernel_flags flags,
                                         struct weft_kernel *kernel);
// kernel_suggest.c: what a kernel's text whose name is unknown may have meant, for "did you mean";
// false where nothing is near.
bool weft_kernel_suggest(const char *text, char *out, size_t size);

// kernel_alias.c: the alias that a text, which need not end there, is; NULL: it is none.
const struct weft_kernel_alias *weft_kernel_find_alias(const char *text, size_t length);

// kernel_check.c: whether a record's members make sense; else the log names the member.
bool weft_kernel_check_info(const struct weft_log *log, const struct weft_kernel_info *info);
// Logs what is wrong with a record, behind its name; false.
bool weft_kernel_complain(const struct weft_log *log, const struct weft_kernel_info *info,
                          const char *format, ...) __attribute__((format(printf, 3, 4)));
// kernel_claims.c: whether what a record says of its functions is so, beyond what weft_kernel_check
// looks at: for records that users make, once. `primitive` is the kernel of the record's, where it
// has one.
bool weft_kernel_check_claims(const struct weft_log *log, const struct weft_kernel *kernel,
                              const struct weft_kernel *primitive);
enum { WEFT_KERNEL_MAX_DEGREE = 64 };
// What functions that return numbers ask, so that no width leaves an array: NAN, or no weights, for
// a kernel that fails. Those with a result ask weft_kernel_check.
static inline bool weft_kernel_usable(const struct weft_kernel *kernel)
{
    return kernel->info && kernel->info->weight && kernel->width >= 1 &&
           kernel->width <= WEFT_KERNEL_MAX_WIDTH && kernel->support <= kernel->width;
}

// kernel_weights.c: h(x), for kernels that interpolate exactly 1 at 0 and 0 at other integers,
// whatever the record's formula rounds there.
double weft_kernel_value(const struct weft_kernel *kernel, double x);
// fraction + shift, never rounded up onto the next knot, where the kernel may jump.
double weft_kernel_argument(double fraction, double shift);

// kernel_bspline.c
extern const struct weft_kernel_info weft_kernel_nearest[1], weft_kernel_area[1];
extern const struct weft_kernel_info weft_kernel_linear[2];
extern const struct weft_kernel_info weft_kernel_bspline[3];
extern const struct weft_kernel_info weft_kernel_bspline0[1], weft_kernel_bspline1[2],
    weft_kernel_bspline2[3], weft_kernel_bspline3[3], weft_kernel_bspline4[3],
    weft_kernel_bspline5[3], weft_kernel_bspline6[3], weft_kernel_bspline7[3];

// kernel_cubic.c
extern const struct weft_kernel_info weft_kernel_cubic[3], weft_kernel_catmull_rom[3],
    weft_kernel_mitchell[3], weft_kernel_notch[3], weft_kernel_cardinal[3];

// kernel_pieces.c
extern const struct weft_kernel_info weft_kernel_omoms[2], weft_kernel_lagrange3[2],
    weft_kernel_lagrange5[2], weft_kernel_keys6[3];

// kernel_sinc.c
extern const struct weft_kernel_info weft_kernel_hann[3], weft_kernel_hamming[3],
    weft_kernel_blackman[3], weft_kernel_lanczos[3], weft_kernel_kaiser[3],
    weft_kernel_gauss_sinc[3], weft_kernel_welch[3], weft_kernel_rect[3], weft_kernel_gaussian[3];

WEFT_END_DECLS
#endif
