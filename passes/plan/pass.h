// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/pass.h - rendering passes as data: what planner, range simulator, emulator and GL
// read. A pass adds one sum of products to a target, or combines targets. Everything on unorm
// targets is arithmetic of integers, so that any two ways of running a list of passes agree in
// every bit:
//
//   T        the target's code for 1.0 (255, 65535); sources are codes s from 0 to T as well
//   q        what a tile stores at the sample position nearest to the tap's fraction, as it is in
//            memory: signs, of negated tiles too, are the group's
//   e        extra_bits: one code of the target is 2^e inside a pass
//   product  sign s q 2^shift 2^e / divisor
//   n        the sum of a pass's products and its bias
//
// With `exact_inside`, n is rounded once, halves away from zero; else each product is, and the sum
// saturates at +-range T 2^e after each group of taps (where dot_width is 3, after R, G and B of a
// group too). Then the target y of T codes becomes, by the pass's part,
//   whole    y + ((n + 2^(e-1)) >> e)       (e = 0: y + n)
//   high     y + (n >> e)
//   low      y + (n & (2^e - 1))
// clamped to [0, T]. With `subtract`, n is made with all signs turned, that of the bias too, and
// whole passes take it away, high ones take (n + 2^e - 1) >> e away, and low ones add (-n) & (2^e -
// 1), so that low parts never fall (Hadwiger, Hauser and Moeller, WSCG 2003, section 3.1, with
// floors).
//
// A combining pass stores floor((sum numerator y + bias + denominator / 2) / denominator), clamped
// to [0, T], of up to 16 targets; where products are rounded inside, each is rounded to 2^-e codes
// first, halves away from zero, and the denominator is 2^e then.
//
// On half and float targets the same sums are taken in single precision of floats: a source is a
// number in [0, 1], a weight is q / divisor with its sign and shift, nothing is clamped.
//
// With the logarithmic technique (section 3.3), sources and tiles hold codes of logarithms, and
// a product is sign log_table[s + q] (0 where s or q is T), the table being in units of 2^-e codes.
#ifndef WEFT_PASSES_PLAN_PASS_H
#define WEFT_PASSES_PLAN_PASS_H

#include "profile.h"
#include "../../tiles/kernel/kernel_tiles.h"

WEFT_BEGIN_DECLS

// Targets that one pass combines, and groups of taps that one pass adds, at most.
enum { WEFT_PASS_MAX_INPUTS = 16, WEFT_PASS_MAX_GROUPS = 16 };

// What one fetch of the source and one of a tile texture give: one tap, or four (dot4). Component c
// of arrays is R, G, B or A; without dot4 component 0 alone counts.
struct weft_tap_group {
    int offset[3]; // component c reads the sample at first tap + offset + pattern[c]
    int tile[4];   // number in the tile set; -1: weight 0
    int sign[4];   // +1, -1 (0 with tile -1)
    int shift[4];  // brings tiles of different scales to the pass's divisor
};

// What a pass does: it adds products of taps to a target, or combines targets.
enum weft_pass_kind { WEFT_PASS_TAPS, WEFT_PASS_COMBINE };
// Which part of its sum a pass stores, as above.
enum weft_pass_part { WEFT_PASS_WHOLE, WEFT_PASS_HIGH, WEFT_PASS_LOW };
// NULL-ended, in the order of the enums: "taps", "combine"; "whole", "high", "low".
WEFT_API extern const char *const weft_pass_kind_names[];
WEFT_API extern const char *const weft_pass_part_names[];

// One rendering pass. The kind tells which group of members counts.
struct weft_pass {
    enum weft_pass_kind kind;
    int target;  // slot that it writes
    bool clears; // starts from `initial`, whatever the slot held
    int initial; // codes (taps)
    // Taps.
    enum weft_pass_part part;
    bool subtract;                // n is made with all signs turned, and taken away
    bool reads_target;            // ping-pong: n may have either sign; else blending, and n is >= 0
    int bias;                     // in 2^-e codes (taps), in units of 1 / denominator (combine)
    int divisor;                  // of the pass's products, >= 1
    int group_first, group_count; // its groups in the list's, up to WEFT_PASS_MAX_GROUPS
    // Combine. A slot that is read is free afterwards, unless it is the target.
    int input_count;
    int input[WEFT_PASS_MAX_INPUTS];     // slots
    int numerator[WEFT_PASS_MAX_INPUTS]; // either sign
    int denominator;                     // >= 1
};

// Passes in the order in which they run, and what they share. Plans make and own lists
// (weft_pass_plan_get_info); what a list of one's own points to is borrowed during calls.
// Thread-safety: read-only use from any thread.
struct weft_pass_list {
    const weft_kernel_tiles *tiles; // required
    enum weft_target_format target; // of every slot
    int dims;                       // 1 to 3, as the tiles'
    bool dot4;                      // four taps a group, from a source interleaved with `pattern`
    int dot_width;                  // 4, 3: as in struct weft_profile
    int pattern[4][3];              // offsets of R, G, B, A; {0} without dot4
    bool exact_inside;
    int extra_bits;    // e
    double range;      // INFINITY: never saturates
    int slot_count;    // targets alive at once
    int scratch_count; // further textures that ping-pong and combining need
    int group_count, pass_count;
    const struct weft_tap_group *groups;
    const struct weft_pass *passes;
    int result; // slot of the result
    // value = (y / T - bias) / scale; half and float: (y - bias) / scale.
    double result_scale, result_bias;
    // Logarithmic products: 2 T + 1 entries; NULL: none. A source or weight x > 0 is stored as the
    // code round(-log2(x) (T - 1) / log_octaves), 0 and what is less than 2^-log_octaves as T.
    const uint32_t *log_table;
    double log_octaves;
};

// Checks that a list is one: numbers are in their ranges, tiles and slots exist, and no pass reads
// a slot that holds nothing. Ranges of sums are weft_range_simulate's. Returns WEFT_ERR_ARGUMENT,
// with the pass and the number in the log, or WEFT_ERR_MEMORY. Thread-safe.
WEFT_API enum weft_result weft_pass_list_check(const struct weft_log *log,
                                               const struct weft_pass_list *list);

WEFT_END_DECLS
#endif
