// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/profile.h - target profiles: what a piece of hardware may do in one rendering pass.
// A profile is data. The old ones (geforce3, radeon8500; Hadwiger, Hauser and Moeller, WSCG 2003,
// sections 1 and 3.1) are reproduced by rounding in the shader, in integers, so that a result is
// the same on every GL. Fraction bits inside a pass refine the target's codes: with a target of m
// bits and b bits inside, 1.0 is (2^m - 1) 2^(b - m) inside, and both the split into stored and
// lost bits (section 3.1) and the way back are shifts.
#ifndef WEFT_PASSES_PLAN_PROFILE_H
#define WEFT_PASSES_PLAN_PROFILE_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// What a render target stores. Default: 8 bits.
enum weft_target_format {
    WEFT_TARGET_UNORM8,  // codes 0 to 255 of [0, 1]
    WEFT_TARGET_UNORM16, // codes 0 to 65535
    WEFT_TARGET_HALF,    // 16-bit floats
    WEFT_TARGET_FLOAT,   // 32-bit floats
};
// NULL-ended, in the order of the enum: "unorm8", "unorm16", "half", "float".
WEFT_API extern const char *const weft_target_names[];

// One profile: a plain value that owns nothing. No member has a default: start from one of the list
// or from weft_profile_parse.
struct weft_profile {
    char name[64];        // "radeon8500"; of a user's own as it was written
    char description[96]; // one line
    enum weft_target_format target;
    // Fraction bits of products and sums inside a pass, from those of the target to 24 (unorm
    // targets). 0: sums of a pass are exact and rounded once when they are stored (unorm), or in
    // the shader's single precision (half and float).
    int internal_bits;
    double internal_range; // sums inside saturate at +-this, at least 1; INFINITY: never
    int taps_per_pass;     // pairs of a source and a tile texture in one pass, 1 to 16
    int dot_width;         // components of one dot product: 4, 3 (RGB, and alpha apart) or 1 (none)
    int max_scale;         // results are multiplied by powers of two up to this; 0: by any factor
    bool ping_pong;        // a pass can read what the one before wrote; else it can only blend
};

// The profiles that weft knows, NULL-ended: fp32, fp16, unorm16, unorm8 (modern shaders, that
// target), geforce3 (9 bits inside, range [-1, 1], 4 textures, RGB dot product and alpha apart),
// radeon8500 (12 bits inside, range
// [-8, 8], 6 textures, dot4, factors up to x8). The old ones have 8-bit targets and blend.
WEFT_API extern const struct weft_profile *const weft_profile_list[];
// Finds one of them by its name. Returns NULL if there is none. Thread-safe, as all below.
WEFT_API const struct weft_profile *weft_profile_find(const char *name);

// Checks that a profile is one, as every call does to which one is handed; those that were filled
// by hand may fail. Returns WEFT_ERR_ARGUMENT; the log names the member that is out of its range.
WEFT_API enum weft_result weft_profile_check(const struct weft_log *log,
                                             const struct weft_profile *profile);

// Return the bits of a target's components, 8 or 16, 0 for half and float; the code that stands for
// 1.0, 2^bits - 1; and the target's name, "unknown" for values that are no format.
WEFT_API int weft_target_bits(enum weft_target_format target);
WEFT_API int weft_target_one(enum weft_target_format target);
WEFT_API const char *weft_target_name(enum weft_target_format target);

// Reads a profile as users write it: "NAME", "NAME,key=value,..." or "key=value,..." (then from
// unorm8 on); keys: target (unorm8, unorm16, half, float), internal-bits, range, taps, dot,
// max-scale, ping-pong (yes, no). An unknown name is logged with the list of names, an unknown key
// with the list of keys, a value out of its range with that range. Returns WEFT_ERR_ARGUMENT.
WEFT_API enum weft_result weft_profile_parse(const struct weft_log *log, const char *text,
                                             struct weft_profile *out);

WEFT_END_DECLS
#endif
