// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/tree/tree.h - accumulation trees: weighted averages of any number of images in
// targets of few bits (Lagae, Suykens, Dutre, "A Hardware Accelerated Alternative for the
// Accumulation Buffer", report CW 369, K.U.Leuven 2003, sections 3.2 to 3.5). Leaves are frames, or
// groups of passes; a node replaces its inputs by their weighted average. Where the leaves are sums
// scaled by 2^j, give them the weights 2^(J - j): their sum without the scales is
// total_weight / 2^J times the result.
// Cost is linear: one pass a leaf and one a node, fewer than 2 N in all. Memory is logarithmic.
//
// Leaf i is the i-th of a complete tree whose nodes all have as many inputs as their level's
// branching factor; leaves from N on have zero weight, and what consists of them is cut away. What
// is left with one input is no node: its input stands in its place. So all N work, and every node
// has 2 inputs or more.
#ifndef WEFT_PASSES_ACCUMULATE_TREE_TREE_H
#define WEFT_PASSES_ACCUMULATE_TREE_TREE_H

#include "../../../filter/base.h"

WEFT_BEGIN_DECLS

// Limits of all trees.
enum {
    WEFT_TREE_MAX_LEAVES = 1 << 16,
    WEFT_TREE_MAX_INPUTS = 16,               // of a node
    WEFT_TREE_MAX_LEVELS = 16,               // of nodes
    WEFT_TREE_MAX_TOTAL_WEIGHT = 0x7fffffff, // below 2^31
};

// How a node's average becomes a code. Default: to nearest.
enum weft_tree_rounding {
    WEFT_TREE_NEAREST,  // halves go up: equal inputs come back, but even factors make a bias
    WEFT_TREE_UNBIASED, // halves go up at every other node of a level, beginning with its first,
                        // and down at those between
    WEFT_TREE_TRUNCATE, // down: what hardware of few bits does (section 3.4)
    WEFT_TREE_ROUNDING_COUNT
};
// NULL-ended, in the order of the enum: "nearest", "unbiased", "truncate".
WEFT_API extern const char *const weft_tree_rounding_names[];

// The leaves and the shape of a tree. What is pointed to is borrowed until weft_tree_create
// returns, but for the log.
struct weft_tree_params {
    int leaf_count;         // N, 1 to WEFT_TREE_MAX_LEAVES (required)
    const uint32_t *weight; // of each leaf, > 0 (default NULL: all equal)
    int branching;          // inputs of a node, 2 to WEFT_TREE_MAX_INPUTS (default 4)
    // Instead of `branching`: the factor of each level from the leaves up, each 2 to
    // WEFT_TREE_MAX_INPUTS; 0 ends the list. Their product must reach N; levels that N does not
    // need stay empty.
    int level_branching[WEFT_TREE_MAX_LEVELS];
    enum weft_tree_rounding rounding; // of nodes (default: to nearest)
    const double *leaf_error_lsb;     // bound of what each leaf is wrong by (default NULL: 0)
    const struct weft_log *log;       // borrowed for the tree's life
};
#define WEFT_TREE_DEFAULTS
#define weft_tree_params(...) (&(struct weft_tree_params){WEFT_TREE_DEFAULTS __VA_ARGS__})

// One pass. Slots are a stack of targets: a leaf is put on top, a node takes its inputs, which are
// the uppermost slots, and leaves its result in the first one of them. As no pass reads what it
// writes, a node draws into one more target, the scratch, and either copies from there (the paper's
// colour buffer) or lets scratch and slot change places. The last step leaves the result in slot 0.
struct weft_tree_step {
    int leaf;        // to be put into `slot`: 0, 1 ... N - 1 in order; -1: a node
    int slot;        // written
    int input_count; // of a node: slots slot ... slot + input_count - 1; 0 for a leaf
    // Input k counts numerator[k] / denominator, the weight of all leaves below it by that below
    // the node, in lowest terms over the node: the numerators are > 0, add up to the denominator
    // and have no common divisor. The product of these along its path is what a leaf counts:
    // weight / total_weight, exactly. For floats a node is sum_k numerator[k] / denominator * y_k;
    // for codes see weft_tree_combine. A leaf has NULL and 0.
    const uint32_t *numerator;
    uint32_t denominator;
    // What weft_tree_combine rounds with: half the denominator to nearest, half of what is one less
    // where halves go down, 0 to truncate.
    uint32_t add;
};

// What a tree is. It belongs to the tree and lives as long.
struct weft_tree_info {
    int leaf_count, node_count; // node_count < N
    int levels;                 // nodes above leaf 0, above other leaves as many or fewer
    // Slots alive at once, the scratch not counted: 1 plus the sum of (factor - 1) over the levels
    // if N is the product of the factors, so (b - 1) log_b N + 1 for N = b^levels (section 3.3);
    // for other N as many or fewer.
    int stack_size;
    int largest_input_count; // of the nodes; 1 if there are none
    uint32_t total_weight;
    // Of the nodes; 1 if there are none. The sums of weft_tree_combine stay below
    // largest_denominator * (largest code + 1).
    uint32_t largest_denominator;
    // Of |result - exact average|: a node adds 1/2 to the average of its inputs' bounds, or where
    // it truncates 1 - 1 / denominator. As edges sum to one, a rounding counts by the share of the
    // leaves below it. Of nodes that round to nearest that is all together half the weighted mean
    // number of nodes above a leaf, plus the weighted mean of leaf_error_lsb; without the latter at
    // most levels / 2, just that for complete trees, and (log2 N) / 2 for complete binary ones
    // (section 3.4), which reach it.
    double error_bound_lsb;
    // Not all of it is noise: the expected result - exact average over random codes. Halves that go
    // up add 1 / (2 b) for each level of nodes with an even number b of equal inputs, so that 256
    // frames come out 2 codes too bright with b = 2, 1/2 with 4, 1/16 with 16; unbiased, only a
    // level's odd node is left, that is 1 / (2 b) in all for complete trees. Truncating takes
    // (b - 1) / (2 b) a level.
    double bias_lsb;
    int step_count;                     // leaf_count + node_count < 2 N
    const struct weft_tree_step *steps; // in postfix order
};

// A schedule of passes. Thread-safety: read-only once made.
typedef struct weft_tree weft_tree;

// Makes the schedule for N leaves; nothing is drawn. On failure *out is NULL. Returns
// WEFT_ERR_ARGUMENT (a range, or level_branching's product below N), WEFT_ERR_LIMIT (leaves or the
// sum of weights; both numbers in the log) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_tree_create(const struct weft_tree_params *params, weft_tree **out);
WEFT_API void weft_tree_destroy(weft_tree **tree); // accepts &NULL, leaves NULL behind
WEFT_API const struct weft_tree_info *weft_tree_get_info(const weft_tree *tree);

// Returns a node's result in integers, input k being codes[k * stride]: floor((sum_k numerator[k]
// y_k + add) / denominator). Equal codes come back unchanged. node must not be a leaf.
static inline uint16_t weft_tree_combine(const struct weft_tree_step *node, const uint16_t *codes,
                                         size_t stride)
{
    uint64_t sum = node->add;
    for (int k = 0; k < node->input_count; k++)
        sum += (uint64_t)node->numerator[k] * codes[(size_t)k * stride];
    return (uint16_t)(sum / node->denominator);
}

// Where the leaves' codes come from. `fill` writes `count` codes of a leaf, and is called once for
// each leaf, in order, in the calling thread. Anything but WEFT_OK ends the run, which returns it.
struct weft_tree_source {
    enum weft_result (*fill)(void *priv, int leaf, size_t count, uint16_t *codes);
    void *priv;
};

// Runs the schedule on `count` pixels in the CPU, by weft_tree_combine, with stack_size arrays of
// that many codes: what GL runs are compared with. out[count] is written at the end, on success.
// Returns WEFT_ERR_ARGUMENT (nothing to do or to fill), WEFT_ERR_MEMORY or what `fill` returned.
WEFT_API enum weft_result weft_tree_run_codes(const weft_tree *tree,
                                              const struct weft_tree_source *source, size_t count,
                                              uint16_t *out);

WEFT_END_DECLS
#endif
