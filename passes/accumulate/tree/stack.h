// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/tree/stack.h - the logic of accumulation trees without a pixel: a stack of
// parts, of which the uppermost ones become a node whenever a level's branching factor is reached
// (not installed). Known and unknown N give the same tree: what is left at the end is carried up,
// level by level, as weft_tree_create's comment has it. weft_tree_create records what it does;
// accumulators do it with images.
//
// Weights are sums of doubles without a rounding, so that shares whose ratios are integers are
// found to be so: 0.1 + 0.1 + 0.1 counts just three times as much as 0.1.
#ifndef WEFT_PASSES_ACCUMULATE_TREE_STACK_H
#define WEFT_PASSES_ACCUMULATE_TREE_STACK_H

#include "passes/accumulate/tree/tree.h"

WEFT_BEGIN_DECLS

enum {
    // Below a level whose nodes are not all complete the factors' product is below 2^24, so 6
    // levels of 16 inputs, or 24 of 2, and then one more: no stack has more than 7 * 15 + 1 parts.
    WEFT_TREE_MAX_PARTS = 106,
    WEFT_TREE_MAX_DEPTH = 26, // levels of nodes, the uppermost one by carrying up
};

// value * 2^exponent; value < 2^127. Sums are exact as long as all bits fit; what does not is less
// than 2^-74 of the sum.
struct weft_tree_weight {
    unsigned __int128 value;
    int exponent;
};
struct weft_tree_weight weft_tree_weight_from(double weight); // finite, > 0
struct weft_tree_weight weft_tree_weight_add(struct weft_tree_weight a, struct weft_tree_weight b);

// A leaf or a node that no node has taken yet.
struct weft_tree_part {
    struct weft_tree_weight weight; // of all leaves below it
    int level;                      // nodes above its leaves, carrying counted
    // Of |its value - weighted mean of its leaves|: in codes, or of floats as a part of the largest
    // magnitude of all leaves.
    double error;
    double bias; // expected value of that difference, over random codes
    // The least and the largest w' / w of its leaves: what they count by the nodes' shares, and by
    // their weights.
    double least, most;
};

// What a node does with its inputs. For codes: floor((sum numerator y + add) / denominator).
struct weft_tree_node {
    int input_count;
    uint32_t numerator[WEFT_TREE_MAX_INPUTS]; // 0 where the share is below half a unit
    uint32_t denominator, add;
    float factor[WEFT_TREE_MAX_INPUTS]; // for floats: sum factor y
};

// Of a stack's shape; it stays as it is.
struct weft_tree_shape {
    int branching;                             // of all levels, 2 to WEFT_TREE_MAX_INPUTS
    int level_branching[WEFT_TREE_MAX_LEVELS]; // instead, up to the first 0, if there is one
    enum weft_tree_rounding rounding;
    // Denominators are at most that; what needs larger ones becomes it by the largest remainder. 0:
    // floats, without a limit.
    uint32_t largest_denominator;
    uint32_t largest_code; // what a share that is off by so much costs at most; floats: 0
};

struct weft_tree_stack {
    struct weft_tree_shape shape;
    int count, most;                    // of parts, now and at most so far
    int64_t leaves;                     // that were pushed
    int64_t nodes[WEFT_TREE_MAX_DEPTH]; // of each level, so far
    struct weft_tree_part part[WEFT_TREE_MAX_PARTS];
};

// Fills in the default of `branching`. Returns WEFT_ERR_ARGUMENT: factors are from 2 to
// WEFT_TREE_MAX_INPUTS, and a list has nothing but 0 after its first 0.
enum weft_result weft_tree_shape_check(const struct weft_log *log, struct weft_tree_shape *shape);
// The most leaves: the list's product, INT64_MAX where there is no list (or one that has more).
int64_t weft_tree_shape_capacity(const struct weft_tree_shape *shape);

// Puts a leaf on top. error: as of a part.
void weft_tree_stack_push(struct weft_tree_stack *stack, struct weft_tree_weight weight,
                          double error);
// Puts `count` leaves of the same weight onto an empty stack, with all nodes that are complete
// then: the same parts as one after another, but for biases where halves go up and down.
void weft_tree_stack_fill(struct weft_tree_stack *stack, int64_t count, double error);
// How many of the uppermost parts are a complete node; 0: another leaf is wanted. It is asked until
// it says 0 after each leaf.
int weft_tree_stack_ready(const struct weft_tree_stack *stack);
// After the last leaf: how many of the uppermost parts are the next node; 0: one part is left, the
// result. Parts that are alone on their level are carried up to the next one that is not empty.
int weft_tree_stack_carry(struct weft_tree_stack *stack);
// Replaces the uppermost `count` parts by a node of theirs.
void weft_tree_stack_combine(struct weft_tree_stack *stack, int count, struct weft_tree_node *out);

// Whether a stack that was read from elsewhere is one that pushing could have left: its functions
// rely on that. `count` is at most WEFT_TREE_MAX_PARTS.
bool weft_tree_stack_is_sound(const struct weft_tree_stack *stack);

// Carries up all of a copy, whose nodes nobody draws: what the result of the leaves so far would
// be. There is a leaf.
struct weft_tree_part weft_tree_stack_preview(const struct weft_tree_stack *stack);

WEFT_END_DECLS
#endif
