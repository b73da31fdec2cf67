// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/tree.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

enum { DEFAULT_BRANCHING = 4 };

const char *const weft_tree_rounding_names[] = {"nearest", "unbiased", "truncate", NULL};

struct weft_tree {
    struct weft_tree_info info;
    const struct weft_log *log;
    struct weft_tree_step *steps;
    uint32_t *numerators; // of all nodes
};

struct builder {
    const struct weft_tree_params *params;
    weft_tree *tree;
    int levels;
    int span[WEFT_TREE_MAX_LEVELS + 1]; // leaves below a node of each level, cut away or not
    int top;                            // slots in use
    uint32_t *next_numerator;
};

// A leaf or a node, with all that is below it.
struct part {
    uint32_t weight;
    double error_lsb;
};

// ---- checks -------------------------------------------------------------------------------------

static bool is_branching(int inputs)
{
    return inputs >= 2 && inputs <= WEFT_TREE_MAX_INPUTS;
}

// Factors up to the first 0, then nothing but 0.
static bool is_list(const int *factors)
{
    int count = 0;
    while (count < WEFT_TREE_MAX_LEVELS && is_branching(factors[count]))
        count++;
    while (count < WEFT_TREE_MAX_LEVELS && factors[count] == 0)
        count++;
    return count == WEFT_TREE_MAX_LEVELS;
}

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

// Every factor is 2 or more: 16 levels reach the largest N.
static enum weft_result choose_levels(const struct weft_tree_params *p, struct builder *b)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const bool listed = p->level_branching[0] != 0;
    const int branching = p->branching ? p->branching : DEFAULT_BRANCHING;
    int level = 0;
    weft_require(p->log, is_branching(branching));
    weft_require(p->log, is_list(p->level_branching));
    for (b->span[0] = 1; b->span[level] < p->leaf_count; level++) {
        const int factor = listed ? p->level_branching[level] : branching;
        if (factor == 0) {
            weft_error(p->log, "tree: %d leaves, but the branching factors multiply to %d",
                       p->leaf_count, b->span[level]);
            goto fail;
        }
        b->span[level + 1] = b->span[level] * factor;
    }
    b->levels = level;
    res = WEFT_OK;
fail:
    return res;
}

// ---- the schedule -------------------------------------------------------------------------------

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
    while (b) {
        const uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

static struct part add_leaf(struct builder *b, int leaf)
{
    const struct weft_tree_params *p = b->params;
    struct weft_tree_info *info = &b->tree->info;
    b->tree->steps[info->step_count++] = (struct weft_tree_step){.leaf = leaf, .slot = b->top++};
    if (b->top > info->stack_size)
        info->stack_size = b->top;
    return (struct part){
        .weight = p->weight ? p->weight[leaf] : 1,
        .error_lsb = p->leaf_error_lsb ? p->leaf_error_lsb[leaf] : 0.0,
    };
}

// The share of input k is its weight by all of the node's: a leaf's path is a telescoping product.
static struct weft_tree_step make_node(struct builder *b, const struct part *inputs, int count)
{
    uint32_t divisor = 0;
    struct weft_tree_step node = {
        .leaf = -1, .slot = b->top - count, .input_count = count, .numerator = b->next_numerator};
    for (int k = 0; k < count; k++)
        divisor = common_divisor(inputs[k].weight, divisor);
    for (int k = 0; k < count; k++) {
        *b->next_numerator = inputs[k].weight / divisor;
        node.denominator += *b->next_numerator++;
    }
    return node;
}

static struct part add_node(struct builder *b, const struct part *inputs, int count)
{
    struct weft_tree_info *info = &b->tree->info;
    const struct weft_tree_step node = make_node(b, inputs, count);
    struct part part = {.error_lsb = 0.5};
    for (int k = 0; k < count; k++) {
        part.weight += inputs[k].weight;
        part.error_lsb += inputs[k].error_lsb * node.numerator[k] / node.denominator;
    }
    b->tree->steps[info->step_count++] = node;
    info->node_count++;
    b->top = node.slot + 1;
    if (count > info->largest_input_count)
        info->largest_input_count = count;
    if (node.denominator > info->largest_denominator)
        info->largest_denominator = node.denominator;
    return part;
}

// As deep as there are levels.
static struct part add_part(struct builder *b, int level, int first_leaf)
{
    if (level == 0)
        return add_leaf(b, first_leaf);
    struct part inputs[WEFT_TREE_MAX_INPUTS];
    const int step = b->span[level - 1], whole = first_leaf + b->span[level];
    const int end = whole < b->params->leaf_count ? whole : b->params->leaf_count;
    int count = 0;
    for (int leaf = first_leaf; leaf < end; leaf += step)
        inputs[count++] = add_part(b, level - 1, leaf);
    return count == 1 ? inputs[0] : add_node(b, inputs, count);
}

static void build(struct builder *b)
{
    weft_tree *tree = b->tree;
    tree->info.leaf_count = b->params->leaf_count;
    tree->info.levels = b->levels;
    tree->info.steps = tree->steps;
    tree->info.largest_input_count = 1;
    tree->info.largest_denominator = 1;
    b->next_numerator = tree->numerators;
    const struct part root = add_part(b, b->levels, 0);
    tree->info.total_weight = root.weight;
    tree->info.error_bound_lsb = root.error_lsb;
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
    struct builder b = {.params = params};
    *out = NULL;
    enum weft_result res = check_leaf_count(params);
    if (res == WEFT_OK)
        res = check_leaves(params);
    if (res == WEFT_OK)
        res = choose_levels(params, &b);
    if (res == WEFT_OK)
        res = allocate(params, &b.tree);
    if (res != WEFT_OK)
        goto fail;
    build(&b);
    *out = b.tree;
    return WEFT_OK;
fail:
    weft_tree_destroy(&b.tree);
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
