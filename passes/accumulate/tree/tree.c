// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/tree/tree.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/accumulate/tree/stack.h"

const char *const weft_tree_rounding_names[] = {"nearest", "unbiased", "truncate", NULL};

struct weft_tree {
    struct weft_tree_info info;
    const struct weft_log *log;
    struct weft_tree_step *steps;
    uint32_t *numerators; // of all nodes
    size_t numerator_count;
};

// ---- checks -------------------------------------------------------------------------------------

static enum weft_result check_leaf_count(const struct weft_tree_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->leaf_count > 0);
    if (p->leaf_count > WEFT_TREE_MAX_LEAVES) {
        weft_error(p->log, "tree: %d leaves, the limit is %d", p->leaf_count, WEFT_TREE_MAX_LEAVES);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

static enum weft_result check_leaves(const struct weft_tree_params *p)
{
    uint64_t total = 0;
    for (int i = 0; i < p->leaf_count; i++) {
        const double error = p->leaf_error_lsb ? p->leaf_error_lsb[i] : 0.0;
        const uint32_t weight = p->weight ? p->weight[i] : 1;
        if (weight == 0 || !(error >= 0.0 && isfinite(error))) {
            weft_error(p->log, "tree: leaf %d has weight %" PRIu32 " and an error of %g", i, weight,
                       error);
            return WEFT_ERR_ARGUMENT;
        }
        total += weight;
    }
    if (total > WEFT_TREE_MAX_TOTAL_WEIGHT) {
        weft_error(p->log, "tree: the weights add up to %" PRIu64 ", the limit is %d", total,
                   WEFT_TREE_MAX_TOTAL_WEIGHT);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static enum weft_result check_shape(const struct weft_tree_params *p, struct weft_tree_shape *shape)
{
    const enum weft_result res = weft_tree_shape_check(p->log, shape);
    if (res != WEFT_OK || p->leaf_count <= weft_tree_shape_capacity(shape))
        return res;
    weft_error(p->log, "tree: %d leaves, but the branching factors multiply to %" PRId64,
               p->leaf_count, weft_tree_shape_capacity(shape));
    return WEFT_ERR_ARGUMENT;
}

// ---- the schedule -------------------------------------------------------------------------------

// Records what a stack does; a part's slot is its place on it.
static void add_leaf(weft_tree *tree, struct weft_tree_stack *stack,
                     const struct weft_tree_params *p, int leaf)
{
    tree->steps[tree->info.step_count++] =
        (struct weft_tree_step){.leaf = leaf, .slot = stack->count};
    weft_tree_stack_push(stack, weft_tree_weight_from(p->weight ? p->weight[leaf] : 1),
                         p->leaf_error_lsb ? p->leaf_error_lsb[leaf] : 0.0);
}

static void add_node(weft_tree *tree, struct weft_tree_stack *stack, int count)
{
    struct weft_tree_info *info = &tree->info;
    uint32_t *numerators = tree->numerators + tree->numerator_count;
    struct weft_tree_node node;
    weft_tree_stack_combine(stack, count, &node);
    memcpy(numerators, node.numerator, (size_t)count * sizeof *numerators);
    tree->numerator_count += (size_t)count;
    tree->steps[info->step_count++] = (struct weft_tree_step){.leaf = -1,
                                                              .slot = stack->count - 1,
                                                              .input_count = count,
                                                              .numerator = numerators,
                                                              .denominator = node.denominator,
                                                              .add = node.add};
    info->node_count++;
    if (count > info->largest_input_count)
        info->largest_input_count = count;
    if (node.denominator > info->largest_denominator)
        info->largest_denominator = node.denominator;
}

static void build(weft_tree *tree, const struct weft_tree_params *p,
                  const struct weft_tree_shape *shape)
{
    struct weft_tree_stack stack = {.shape = *shape};
    struct weft_tree_info *info = &tree->info;
    int count;
    info->leaf_count = p->leaf_count;
    info->steps = tree->steps;
    info->largest_input_count = 1;
    info->largest_denominator = 1;
    for (int leaf = 0; leaf < p->leaf_count; leaf++) {
        add_leaf(tree, &stack, p, leaf);
        info->total_weight += p->weight ? p->weight[leaf] : 1;
        while ((count = weft_tree_stack_ready(&stack)) > 0)
            add_node(tree, &stack, count);
    }
    while ((count = weft_tree_stack_carry(&stack)) > 0)
        add_node(tree, &stack, count);
    info->levels = stack.part[0].level;
    info->stack_size = stack.most;
    info->error_bound_lsb = stack.part[0].error;
    info->bias_lsb = stack.part[0].bias;
}

// ---- trees --------------------------------------------------------------------------------------

static enum weft_result allocate(const struct weft_tree_params *p, weft_tree **out)
{
    // All but the root are somebody's input.
    const size_t steps = 2 * (size_t)p->leaf_count;
    weft_tree *tree = calloc(1, sizeof *tree);
    if (tree) {
        tree->log = p->log;
        tree->steps = calloc(steps, sizeof *tree->steps);
        tree->numerators = calloc(steps, sizeof *tree->numerators);
    }
    *out = tree;
    if (tree && tree->steps && tree->numerators)
        return WEFT_OK;
    weft_error(p->log, "tree: not enough memory for %d leaves", p->leaf_count);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_tree_create(const struct weft_tree_params *params, weft_tree **out)
{
    struct weft_tree_shape shape = {.branching = params->branching,
                                    .rounding = params->rounding,
                                    .largest_denominator = WEFT_TREE_MAX_TOTAL_WEIGHT,
                                    .largest_code = UINT16_MAX};
    memcpy(shape.level_branching, params->level_branching, sizeof shape.level_branching);
    *out = NULL;
    enum weft_result res = check_leaf_count(params);
    if (res == WEFT_OK)
        res = check_leaves(params);
    if (res == WEFT_OK)
        res = check_shape(params, &shape);
    if (res == WEFT_OK)
        res = allocate(params, out);
    if (res == WEFT_OK)
        build(*out, params, &shape);
    else
        weft_tree_destroy(out);
    return res;
}

void weft_tree_destroy(weft_tree **tree)
{
    if (!tree || !*tree)
        return;
    free((*tree)->steps);
    free((*tree)->numerators);
    free(*tree);
    *tree = NULL;
}

const struct weft_tree_info *weft_tree_get_info(const weft_tree *tree)
{
    return &tree->info;
}

// ---- in integers on the CPU ---------------------------------------------------------------------

static enum weft_result run_step(const struct weft_tree_step *step,
                                 const struct weft_tree_source *source, size_t count,
                                 uint16_t *slots)
{
    uint16_t *codes = slots + (size_t)step->slot * count;
    if (step->leaf >= 0)
        return source->fill(source->priv, step->leaf, count, codes);
    for (size_t i = 0; i < count; i++)
        codes[i] = weft_tree_combine(step, codes + i, count);
    return WEFT_OK;
}

enum weft_result weft_tree_run_codes(const weft_tree *tree, const struct weft_tree_source *source,
                                     size_t count, uint16_t *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_tree_info *info = &tree->info;
    uint16_t *slots = NULL;
    size_t bytes;
    weft_require(tree->log, source && source->fill && count > 0 && out);
    if (weft_size_mul(count, (size_t)info->stack_size * sizeof *slots, &bytes))
        slots = malloc(bytes);
    if (!slots) {
        weft_error(tree->log, "tree: not enough memory for %d arrays of %zu codes",
                   info->stack_size, count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < info->step_count; i++)
        res = run_step(&info->steps[i], source, count, slots);
    if (res == WEFT_OK)
        memcpy(out, slots, count * sizeof *out);
fail:
    free(slots);
    return res;
}
