// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/fixed.h"
#include "filter/fixed.h"
#include "passes/accumulate/tree/tree.h"

enum { PIXELS = 64, MAX_FRAMES = 1024 };

static uint32_t weights[WEFT_TREE_MAX_LEAVES];

static uint64_t random_state;

// SplitMix64 (Steele, Lea, Flood 2014); its upper bits.
static uint32_t next_random(uint32_t below)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    z ^= z >> 31;
    return (uint32_t)((z >> 32) * below >> 32);
}

static weft_tree *make_tree(struct weft_tree_params params)
{
    weft_tree *tree = NULL;
    params.log = &log_to_stderr;
    assert_int_equal(weft_tree_create(&params, &tree), WEFT_OK);
    assert_non_null(tree);
    return tree;
}

// ---- schedules ----------------------------------------------------------------------------------

static uint64_t common_divisor(uint64_t a, uint64_t b)
{
    return b ? common_divisor(b, a % b) : a;
}

// What a schedule does, followed step by step: the leaves in every slot, and of each leaf the nodes
// above it and what it counts there, a fraction in lowest terms. All numbers are below 2^31, so
// products before reduction fit.
struct walk {
    const struct weft_tree_info *info;
    int alive, most_alive, leaves, nodes;
    uint32_t largest_denominator;
    int first[256], count[256]; // leaves by slot; count 0: nothing to be read
};

static int depth[WEFT_TREE_MAX_LEAVES];
static uint64_t share[WEFT_TREE_MAX_LEAVES][2];

static void walk_leaf(struct walk *w, const struct weft_tree_step *step)
{
    assert_int_equal(step->leaf, w->leaves);
    assert_int_equal(step->slot, w->alive);
    assert_true(step->slot < w->info->stack_size);
    assert_int_equal(step->input_count, 0);
    assert_null(step->numerator);
    assert_int_equal(w->count[step->slot], 0);
    w->first[step->slot] = w->leaves++;
    w->count[step->slot] = 1;
    w->alive++;
    depth[step->leaf] = 0;
    share[step->leaf][0] = share[step->leaf][1] = 1;
}

static void scale_share(int leaf, uint32_t numerator, uint32_t denominator)
{
    const uint64_t a = share[leaf][0] * numerator, b = share[leaf][1] * denominator;
    const uint64_t divisor = common_divisor(a, b);
    share[leaf][0] = a / divisor;
    share[leaf][1] = b / divisor;
    depth[leaf]++;
}

static void walk_node(struct walk *w, const struct weft_tree_step *step)
{
    uint64_t sum = 0, divisor = 0;
    int leaves = 0;
    assert_int_equal(step->leaf, -1);
    assert_in_range(step->input_count, 2, w->info->largest_input_count);
    assert_int_equal(step->slot + step->input_count, w->alive);
    for (int k = 0; k < step->input_count; k++) {
        const int slot = step->slot + k, first = w->first[slot];
        assert_true(step->numerator[k] > 0 && w->count[slot] > 0);
        assert_int_equal(first, w->first[step->slot] + leaves);
        for (int i = first; i < first + w->count[slot]; i++)
            scale_share(i, step->numerator[k], step->denominator);
        sum += step->numerator[k];
        divisor = common_divisor(divisor, step->numerator[k]);
        leaves += w->count[slot];
        w->count[slot] = 0;
    }
    assert_int_equal(sum, step->denominator);
    assert_int_equal(divisor, 1);
    w->count[step->slot] = leaves;
    w->alive = step->slot + 1;
    w->nodes++;
    if (step->denominator > w->largest_denominator)
        w->largest_denominator = step->denominator;
}

// Every leaf counts weight / total exactly, and the bound is half its mean depth.
static void check_shares(const struct weft_tree_info *info, const uint32_t *weight)
{
    uint64_t total = 0;
    double bound = 0.0;
    int deepest = 0;
    for (int i = 0; i < info->leaf_count; i++)
        total += weight ? weight[i] : 1;
    assert_int_equal(info->total_weight, total);
    for (int i = 0; i < info->leaf_count; i++) {
        const uint64_t w = weight ? weight[i] : 1;
        assert_int_equal(share[i][0] * total, share[i][1] * w);
        bound += 0.5 * (double)w / (double)total * depth[i];
        deepest = depth[i] > deepest ? depth[i] : deepest;
    }
    assert_int_equal(deepest, info->levels);
    assert_int_equal(depth[0], info->levels);
    assert_near(info->error_bound_lsb, bound, 1e-9, "bound");
    assert_true(info->error_bound_lsb <= 0.5 * info->levels + 1e-9);
}

static void check_tree(const struct weft_tree_params *params)
{
    weft_tree *tree = make_tree(*params);
    const struct weft_tree_info *info = weft_tree_get_info(tree);
    struct walk w = {.info = info, .largest_denominator = 1};
    assert_true(info->stack_size <= 256);
    for (int i = 0; i < info->step_count; i++) {
        if (info->steps[i].leaf >= 0)
            walk_leaf(&w, &info->steps[i]);
        else
            walk_node(&w, &info->steps[i]);
        w.most_alive = w.alive > w.most_alive ? w.alive : w.most_alive;
    }
    assert_int_equal(w.alive, 1);
    assert_int_equal(w.count[0], params->leaf_count);
    assert_int_equal(w.leaves, params->leaf_count);
    assert_int_equal(info->leaf_count, params->leaf_count);
    assert_int_equal(w.nodes, info->node_count);
    assert_true(info->node_count < params->leaf_count);
    assert_true(info->step_count < 2 * params->leaf_count);
    assert_int_equal(w.most_alive, info->stack_size);
    assert_int_equal(w.largest_denominator, info->largest_denominator);
    check_shares(info, params->weight);
    weft_tree_destroy(&tree);
    assert_null(tree);
}

static void test_any_leaf_count(void **state)
{
    static const int branchings[] = {2, 3, 4, 8, 16};
    (void)state;
    for (size_t b = 0; b < WEFT_COUNT(branchings); b++)
        for (int n = 1; n <= 200; n++)
            check_tree(&(struct weft_tree_params){.leaf_count = n, .branching = branchings[b]});
    for (size_t b = 0; b < WEFT_COUNT(branchings); b++)
        for (int n = WEFT_TREE_MAX_LEAVES - 1; n <= WEFT_TREE_MAX_LEAVES; n++)
            check_tree(&(struct weft_tree_params){.leaf_count = n, .branching = branchings[b]});
}

// Section 3.3, and that no N between needs more.
static void test_stack_size(void **state)
{
    static const int branchings[] = {2, 3, 4, 16};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(branchings); i++) {
        const int b = branchings[i];
        for (int levels = 0, n = 1; n <= 4096; levels++, n *= b) {
            weft_tree *tree = make_tree((struct weft_tree_params){.leaf_count = n, .branching = b});
            const struct weft_tree_info *info = weft_tree_get_info(tree);
            assert_int_equal(info->levels, levels);
            assert_int_equal(info->stack_size, (b - 1) * levels + 1);
            assert_int_equal(info->node_count, (n - 1) / (b - 1));
            assert_int_equal(info->largest_denominator, levels ? b : 1);
            assert_int_equal(info->largest_input_count, levels ? b : 1);
            assert_near(info->error_bound_lsb, 0.5 * levels, 1e-12, "bound of a complete tree");
            weft_tree_destroy(&tree);
        }
        for (int levels = 1, whole = b, n = 2; n <= 300; n++) {
            if (n > whole) {
                levels++;
                whole *= b;
            }
            weft_tree *tree = make_tree((struct weft_tree_params){.leaf_count = n, .branching = b});
            assert_true(weft_tree_get_info(tree)->stack_size <= (b - 1) * levels + 1);
            weft_tree_destroy(&tree);
        }
    }
}

// A leaf is its number, a node its numerators over its denominator.
static void print_steps(const struct weft_tree_info *info, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < info->step_count; i++) {
        const struct weft_tree_step *step = &info->steps[i];
        if (step->leaf >= 0)
            used += (size_t)snprintf(text + used, size - used, "%d ", step->leaf);
        for (int k = 0; k < step->input_count; k++)
            used += (size_t)snprintf(text + used, size - used, "%c%u", k ? '+' : '(',
                                     step->numerator[k]);
        if (step->leaf < 0)
            used += (size_t)snprintf(text + used, size - used, ")/%u ", step->denominator);
        assert_true(used < size);
    }
    if (used > 0)
        text[used - 1] = '\0';
}

static void test_shapes(void **state)
{
    static const uint32_t large[] = {0x40000000, 0x20000000, 0x10000000, 0x08000000};
    static const uint32_t uneven[] = {1, 2, 3, 4, 5};
    static const struct {
        struct weft_tree_params params;
        const char *steps;
        int levels, stack_size;
        double bound;
    } cases[] = {
        {{.leaf_count = 1}, "0", 0, 1, 0.0},
        {{.leaf_count = 2}, "0 1 (1+1)/2", 1, 2, 0.5},
        {{.leaf_count = 5}, "0 1 2 3 (1+1+1+1)/4 4 (4+1)/5", 2, 4, 0.9},
        {{.leaf_count = 3, .branching = 2}, "0 1 (1+1)/2 2 (2+1)/3", 2, 2, 5.0 / 6},
        {{.leaf_count = 8, .level_branching = {2, 4}},
         "0 1 (1+1)/2 2 3 (1+1)/2 4 5 (1+1)/2 6 7 (1+1)/2 (1+1+1+1)/4",
         2,
         5,
         1.0},
        {{.leaf_count = 8, .level_branching = {4, 2}},
         "0 1 2 3 (1+1+1+1)/4 4 5 6 7 (1+1+1+1)/4 (1+1)/2",
         2,
         5,
         1.0},
        {{.leaf_count = 8, .level_branching = {4, 2, 16, 16}, .branching = 3},
         "0 1 2 3 (1+1+1+1)/4 4 5 6 7 (1+1+1+1)/4 (1+1)/2",
         2,
         5,
         1.0},
        {{.leaf_count = 7, .level_branching = {4, 2}},
         "0 1 2 3 (1+1+1+1)/4 4 5 6 (1+1+1)/3 (4+3)/7",
         2,
         4,
         1.0},
        {{.leaf_count = 10, .level_branching = {3, 3, 2}},
         "0 1 2 (1+1+1)/3 3 4 5 (1+1+1)/3 6 7 8 (1+1+1)/3 (1+1+1)/3 9 (9+1)/10",
         3,
         5,
         1.4},
        // Groups scaled by 2^j, j = 0 to 3.
        {{.leaf_count = 4, .weight = large}, "0 1 2 3 (8+4+2+1)/15", 1, 4, 0.5},
        {{.leaf_count = 4, .weight = large, .branching = 2},
         "0 1 (2+1)/3 2 3 (2+1)/3 (4+1)/5",
         2,
         3,
         1.0},
        {{.leaf_count = 5, .weight = uneven, .branching = 3},
         "0 1 2 (1+2+3)/6 3 4 (4+5)/9 (2+3)/5",
         2,
         3,
         1.0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        char text[512];
        weft_tree *tree = make_tree(cases[i].params);
        const struct weft_tree_info *info = weft_tree_get_info(tree);
        print_steps(info, text, sizeof text);
        assert_string_equal(text, cases[i].steps);
        assert_int_equal(info->levels, cases[i].levels);
        assert_int_equal(info->stack_size, cases[i].stack_size);
        assert_near(info->error_bound_lsb, cases[i].bound, 1e-12, text);
        weft_tree_destroy(&tree);
        check_tree(&cases[i].params);
    }
}

static void test_level_lists(void **state)
{
    static const int lists[][WEFT_TREE_MAX_LEVELS] = {
        {2, 4},     {4, 2}, {3, 3, 2},
        {2, 16, 3}, {5},    {2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(lists); i++) {
        int product = 1, stack_size = 1;
        for (int l = 0; l < WEFT_TREE_MAX_LEVELS && lists[i][l]; l++) {
            product *= lists[i][l];
            stack_size += lists[i][l] - 1;
        }
        struct weft_tree_params params = {.leaf_count = product};
        memcpy(params.level_branching, lists[i], sizeof lists[i]);
        weft_tree *tree = make_tree(params);
        assert_int_equal(weft_tree_get_info(tree)->stack_size, stack_size);
        weft_tree_destroy(&tree);
        check_tree(&params);
        for (params.leaf_count = 1; params.leaf_count < product && params.leaf_count <= 100;
             params.leaf_count++)
            check_tree(&params);
    }
}

// ---- weights ------------------------------------------------------------------------------------

static uint32_t rising(int i, int n)
{
    (void)n;
    return (uint32_t)i + 1;
}

static uint32_t one_heavy(int i, int n)
{
    return i == n / 2 ? WEFT_TREE_MAX_TOTAL_WEIGHT - (uint32_t)(n - 1) : 1;
}

static uint32_t all_heavy(int i, int n)
{
    return (uint32_t)(WEFT_TREE_MAX_TOTAL_WEIGHT / n) - (uint32_t)(i % 7);
}

static uint32_t binomial(int i, int n)
{
    double value = 1.0;
    for (int k = 1; k <= i; k++)
        value = value * (n - k) / k;
    return (uint32_t)fmin(fmax(value, 1.0), 1e6);
}

static uint32_t any(int i, int n)
{
    (void)i;
    return 1 + next_random(WEFT_TREE_MAX_TOTAL_WEIGHT / (uint32_t)n);
}

static uint32_t (*const weight_lists[])(int i, int n) = {rising, one_heavy, all_heavy, binomial,
                                                         any};

static void fill_weights(size_t list, int n)
{
    for (int i = 0; i < n; i++)
        weights[i] = weight_lists[list](i, n);
}

static void test_weights(void **state)
{
    static const int counts[] = {1, 2, 3, 5, 16, 17, 100, 256, 1000, WEFT_TREE_MAX_LEAVES};
    (void)state;
    random_state = 1;
    for (size_t list = 0; list < WEFT_COUNT(weight_lists); list++) {
        for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
            if (counts[c] > 1000 &&
                (weight_lists[list] == rising || weight_lists[list] == binomial))
                continue; // more than 2^31
            fill_weights(list, counts[c]);
            for (int b = 2; b <= WEFT_TREE_MAX_INPUTS; b += 7)
                check_tree(&(struct weft_tree_params){
                    .leaf_count = counts[c], .weight = weights, .branching = b});
        }
    }
}

static void test_leaf_error(void **state)
{
    static const uint32_t weight[] = {1, 2, 5};
    static const double error[] = {1.0, 0.25, 2.0};
    (void)state;
    weft_tree *tree = make_tree((struct weft_tree_params){
        .leaf_count = 3, .branching = 2, .weight = weight, .leaf_error_lsb = error});
    // (0 1) are 3 of 8: two roundings above them, one above leaf 2.
    assert_near(weft_tree_get_info(tree)->error_bound_lsb,
                (1.0 + 2 * 0.25 + 5 * 2.0) / 8 + 0.5 + 0.5 * 3 / 8, 1e-12, "bound");
    weft_tree_destroy(&tree);
    tree = make_tree((struct weft_tree_params){.leaf_count = 1, .leaf_error_lsb = error});
    assert_true(weft_tree_get_info(tree)->error_bound_lsb == 1.0);
    weft_tree_destroy(&tree);
}

// ---- codes --------------------------------------------------------------------------------------

static void test_combine(void **state)
{
    static const struct {
        int input_count;
        uint32_t numerator[4], denominator;
        uint16_t codes[4], result;
    } cases[] = {
        {2, {1, 1}, 2, {0, 1}, 1},
        {2, {1, 1}, 2, {254, 255}, 255},
        {2, {1, 2}, 3, {1, 0}, 0},
        {2, {1, 2}, 3, {0, 1}, 1},
        {4, {1, 1, 1, 1}, 4, {0, 0, 0, 1}, 0},
        {4, {1, 1, 1, 1}, 4, {0, 0, 1, 1}, 1},
        {4, {8, 4, 2, 1}, 15, {255, 0, 0, 0}, 136},
        {2, {0x7ffffffe, 1}, 0x7fffffff, {65535, 65535}, 65535},
        {2, {0x7ffffffe, 1}, 0x7fffffff, {65534, 65535}, 65534},
        {2, {0x40000000, 0x3fffffff}, 0x7fffffff, {1, 0}, 1},
        {2, {0x3fffffff, 0x40000000}, 0x7fffffff, {1, 0}, 0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        uint16_t spread[12] = {0};
        const struct weft_tree_step node = {.leaf = -1,
                                            .input_count = cases[i].input_count,
                                            .numerator = cases[i].numerator,
                                            .denominator = cases[i].denominator,
                                            .add = cases[i].denominator / 2};
        assert_int_equal(weft_tree_combine(&node, cases[i].codes, 1), cases[i].result);
        for (int k = 0; k < node.input_count; k++)
            spread[3 * k] = cases[i].codes[k];
        assert_int_equal(weft_tree_combine(&node, spread, 3), cases[i].result);
    }
}

// Frames in memory, handed out in order.
static uint16_t frames[MAX_FRAMES][PIXELS];

struct handed_out {
    int next, stop_at; // fails at that leaf; -1: never
};

static enum weft_result hand_out(void *priv, int leaf, size_t count, uint16_t *codes)
{
    struct handed_out *h = priv;
    assert_int_equal(leaf, h->next++);
    if (leaf == h->stop_at)
        return WEFT_ERR_CANCELLED;
    memcpy(codes, frames[leaf], count * sizeof *codes);
    return WEFT_OK;
}

static void run_frames(const weft_tree *tree, uint16_t *out)
{
    struct handed_out h = {.stop_at = -1};
    const struct weft_tree_source source = {hand_out, &h};
    assert_int_equal(weft_tree_run_codes(tree, &source, PIXELS, out), WEFT_OK);
    assert_int_equal(h.next, weft_tree_get_info(tree)->leaf_count);
}

static void fill_random(int frame_count, uint32_t codes)
{
    for (int i = 0; i < frame_count; i++)
        for (int x = 0; x < PIXELS; x++)
            frames[i][x] = (uint16_t)next_random(codes);
}

// In codes, from the exact average: sums are below 2^31 * 2^16.
static double signed_error(const struct weft_tree_info *info, const uint32_t *weight, int x,
                           uint16_t result)
{
    int64_t sum = 0;
    for (int i = 0; i < info->leaf_count; i++)
        sum += (int64_t)(weight ? weight[i] : 1) * frames[i][x];
    return (double)(result * (int64_t)info->total_weight - sum) / (double)info->total_weight;
}

static void test_equal_frames(void **state)
{
    static const uint16_t constants[] = {0, 1, 77, 254, 255, 65535};
    static const int counts[] = {1, 2, 3, 7, 30, 256, 1000};
    (void)state;
    random_state = 2;
    for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
        for (size_t list = 0; list <= WEFT_COUNT(weight_lists); list++) {
            const bool equal = list == WEFT_COUNT(weight_lists);
            if (!equal)
                fill_weights(list, counts[c]);
            weft_tree *tree = make_tree((struct weft_tree_params){
                .leaf_count = counts[c],
                .weight = equal ? NULL : weights,
                .branching = 2 + (int)(c + list) % (WEFT_TREE_MAX_INPUTS - 1)});
            for (int i = 0; i < counts[c]; i++)
                for (int x = 0; x < PIXELS; x++)
                    frames[i][x] = constants[(size_t)x % WEFT_COUNT(constants)];
            uint16_t out[PIXELS];
            run_frames(tree, out);
            assert_memory_equal(out, frames[0], sizeof out);
            weft_tree_destroy(&tree);
        }
    }
}

static void check_error(struct weft_tree_params params, uint32_t codes)
{
    weft_tree *tree = make_tree(params);
    const struct weft_tree_info *info = weft_tree_get_info(tree);
    uint16_t out[PIXELS];
    fill_random(params.leaf_count, codes);
    run_frames(tree, out);
    for (int x = 0; x < PIXELS; x++) {
        const double error = fabs(signed_error(info, params.weight, x, out[x]));
        if (!(error <= info->error_bound_lsb + 1e-9))
            fail_msg("%d leaves by %d: error %g, bound %g", params.leaf_count, params.branching,
                     error, info->error_bound_lsb);
    }
    weft_tree_destroy(&tree);
}

// Frames of all ranges: of few codes, where halves abound, to 16 bits.
static void test_error_within_bound(void **state)
{
    static const uint32_t ranges[] = {2, 3, 256, 65536};
    static const int counts[] = {2, 3, 5, 31, 64, 200, 256, 1000};
    (void)state;
    random_state = 3;
    for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
        for (size_t r = 0; r < WEFT_COUNT(ranges); r++) {
            for (int b = 2; b <= WEFT_TREE_MAX_INPUTS; b++) {
                struct weft_tree_params params = {.leaf_count = counts[c],
                                                  .branching = b,
                                                  .rounding = b % WEFT_TREE_ROUNDING_COUNT};
                check_error(params, ranges[r]);
                fill_weights((size_t)b % WEFT_COUNT(weight_lists), counts[c]);
                params.weight = weights;
                check_error(params, ranges[r]);
            }
        }
    }
}

// Leaf i has as many as i has bits set: every node of two rounds a half up, up to 4 codes.
static void test_bound_is_reached(void **state)
{
    (void)state;
    for (int levels = 1; levels <= 10; levels++) {
        uint16_t out[PIXELS];
        weft_tree *tree =
            make_tree((struct weft_tree_params){.leaf_count = 1 << levels, .branching = 2});
        const struct weft_tree_info *info = weft_tree_get_info(tree);
        for (int i = 0; i < info->leaf_count; i++)
            for (int x = 0; x < PIXELS; x++)
                frames[i][x] = (uint16_t)__builtin_popcount((unsigned)i);
        run_frames(tree, out);
        assert_int_equal(out[0], levels);
        assert_true(signed_error(info, NULL, 0, out[0]) == 0.5 * levels);
        assert_true(info->error_bound_lsb == 0.5 * levels);
        weft_tree_destroy(&tree);
    }
}

// The mean error on random codes, which tree.h states. Of 64 * 32 results that each scatter by less
// than 0.4 codes, the mean scatters by less than 0.009.
static void check_bias(const struct weft_tree_params *params, double expected)
{
    enum { REPEATS = 32 };
    double sum = 0.0;
    weft_tree *tree = make_tree(*params);
    const struct weft_tree_info *info = weft_tree_get_info(tree);
    assert_near(info->bias_lsb, expected, 1e-12, "bias");
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        uint16_t out[PIXELS];
        fill_random(params->leaf_count, 256);
        run_frames(tree, out);
        for (int x = 0; x < PIXELS; x++)
            sum += signed_error(info, NULL, x, out[x]);
    }
    assert_near(sum / (REPEATS * PIXELS), info->bias_lsb, 0.03, "mean error");
    weft_tree_destroy(&tree);
}

static void test_bias(void **state)
{
    static const struct {
        int branching, leaves, levels;
    } cases[] = {{2, 256, 8}, {3, 243, 5}, {4, 256, 4}, {16, 256, 2}};
    (void)state;
    random_state = 4;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const double b = cases[i].branching, half = cases[i].branching % 2 ? 0.0 : 1 / (2 * b);
        struct weft_tree_params params = {.leaf_count = cases[i].leaves,
                                          .branching = cases[i].branching};
        check_bias(&params, half * cases[i].levels);
        params.rounding = WEFT_TREE_UNBIASED;
        check_bias(&params, half);
        params.rounding = WEFT_TREE_TRUNCATE;
        check_bias(&params, -(b - 1) / (2 * b) * cases[i].levels);
    }
}

// ---- blending -----------------------------------------------------------------------------------

// N equal frames added by blending, each times alpha = 1 / N (section 2), all in 8 bits.
static int64_t blend(int64_t code, int frame_count, enum weft_fixed_rounding rounding)
{
    const int64_t alpha = fixed_quantise(1.0 / frame_count, 8, rounding);
    int64_t target = 0;
    for (int i = 0; i < frame_count; i++)
        target = fixed_clamp(target + fixed_multiply(code, alpha, 8, rounding), 8);
    return target;
}

// Section 3.4: 256 images blend to black, or rounded to black and white; the tree gives them back.
static void test_blending_fails(void **state)
{
    uint16_t out[PIXELS];
    (void)state;
    weft_tree *tree = make_tree((struct weft_tree_params){.leaf_count = 256, .branching = 2});
    for (int code = 0; code < 256; code++) {
        assert_int_equal(blend(code, 256, WEFT_FIXED_TRUNCATE), 0);
        assert_int_equal(blend(code, 256, WEFT_FIXED_ROUND), code < 128 ? 0 : 255);
        frames[0][code % PIXELS] = (uint16_t)code;
        if (code % PIXELS < PIXELS - 1)
            continue;
        for (int i = 1; i < 256; i++)
            memcpy(frames[i], frames[0], sizeof frames[i]);
        run_frames(tree, out);
        assert_memory_equal(out, frames[0], sizeof out);
    }
    random_state = 5;
    fill_random(256, 256);
    run_frames(tree, out);
    for (int x = 0; x < PIXELS; x++)
        assert_true(fabs(signed_error(weft_tree_get_info(tree), NULL, x, out[x])) <= 4.0);
    weft_tree_destroy(&tree);
}

// ---- errors -------------------------------------------------------------------------------------

static void test_refused(void **state)
{
    static const uint32_t zero[] = {1, 0, 1}, heavy[] = {0x40000000, 0x3fffffff, 1},
                          huge[] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    static const double negative[] = {0.0, -0.5}, nan[] = {NAN}, infinite[] = {INFINITY};
    static const struct {
        struct weft_tree_params params;
        enum weft_result result;
        const char *text[2]; // in the message
    } cases[] = {
        {{.leaf_count = 0}, WEFT_ERR_ARGUMENT, {"leaf_count > 0", ""}},
        {{.leaf_count = -1}, WEFT_ERR_ARGUMENT, {"leaf_count > 0", ""}},
        {{.leaf_count = 65537}, WEFT_ERR_LIMIT, {"65537", "65536"}},
        {{.leaf_count = 3, .weight = zero}, WEFT_ERR_ARGUMENT, {"leaf 1", "weight 0"}},
        {{.leaf_count = 3, .weight = heavy}, WEFT_ERR_LIMIT, {"2147483648", "2147483647"}},
        {{.leaf_count = 3, .weight = huge}, WEFT_ERR_LIMIT, {"12884901885", "2147483647"}},
        {{.leaf_count = 2, .leaf_error_lsb = negative}, WEFT_ERR_ARGUMENT, {"leaf 1", "-0.5"}},
        {{.leaf_count = 1, .leaf_error_lsb = nan}, WEFT_ERR_ARGUMENT, {"leaf 0", "nan"}},
        {{.leaf_count = 1, .leaf_error_lsb = infinite}, WEFT_ERR_ARGUMENT, {"leaf 0", "inf"}},
        {{.leaf_count = 4, .branching = 1}, WEFT_ERR_ARGUMENT, {"branching", ""}},
        {{.leaf_count = 4, .branching = 17}, WEFT_ERR_ARGUMENT, {"branching", ""}},
        {{.leaf_count = 4, .branching = -2}, WEFT_ERR_ARGUMENT, {"branching", ""}},
        {{.leaf_count = 2, .level_branching = {1}}, WEFT_ERR_ARGUMENT, {"level_branching", ""}},
        {{.leaf_count = 2, .level_branching = {2, 17}}, WEFT_ERR_ARGUMENT, {"level_branching", ""}},
        {{.leaf_count = 2, .level_branching = {2, 0, 2}},
         WEFT_ERR_ARGUMENT,
         {"level_branching", ""}},
        {{.leaf_count = 9, .level_branching = {2, 4}}, WEFT_ERR_ARGUMENT, {"9 leaves", "to 8"}},
        {{.leaf_count = 9, .rounding = 3}, WEFT_ERR_ARGUMENT, {"rounding is 3", ""}},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_tree_params params = cases[i].params;
        weft_tree *tree = (weft_tree *)&params;
        params.log = &log;
        assert_int_equal(weft_tree_create(&params, &tree), cases[i].result);
        assert_null(tree);
        assert_int_equal(message.count, 1);
        for (int t = 0; t < 2; t++)
            if (!strstr(message.text, cases[i].text[t]))
                fail_msg("no \"%s\" in: %s", cases[i].text[t], message.text);
        params.log = NULL;
        assert_int_equal(weft_tree_create(&params, &tree), cases[i].result);
        weft_tree_destroy(&tree);
    }
}

static void test_runs_refused(void **state)
{
    uint16_t out[PIXELS] = {7};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct handed_out h = {.stop_at = 3};
    const struct weft_tree_source source = {hand_out, &h}, none = {NULL, NULL};
    weft_tree *tree = NULL;
    (void)state;
    assert_int_equal(
        weft_tree_create(&(struct weft_tree_params){.leaf_count = 9, .log = &log}, &tree), WEFT_OK);
    assert_int_equal(weft_tree_run_codes(tree, NULL, PIXELS, out), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_tree_run_codes(tree, &none, PIXELS, out), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_tree_run_codes(tree, &source, 0, out), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_tree_run_codes(tree, &source, PIXELS, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 4);
    // Bytes that overflow, and bytes that nobody has.
    assert_int_equal(weft_tree_run_codes(tree, &source, SIZE_MAX / 2, out), WEFT_ERR_MEMORY);
    assert_int_equal(weft_tree_run_codes(tree, &source, SIZE_MAX / 32, out), WEFT_ERR_MEMORY);
    assert_int_equal(message.count, 6);
    assert_int_equal(h.next, 0);
    assert_int_equal(weft_tree_run_codes(tree, &source, PIXELS, out), WEFT_ERR_CANCELLED);
    assert_int_equal(h.next, 4);
    assert_int_equal(message.count, 6);
    assert_int_equal(out[0], 7);
    weft_tree_destroy(&tree);
    weft_tree_destroy(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_leaf_count),
        cmocka_unit_test(test_stack_size),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_level_lists),
        cmocka_unit_test(test_weights),
        cmocka_unit_test(test_leaf_error),
        cmocka_unit_test(test_combine),
        cmocka_unit_test(test_equal_frames),
        cmocka_unit_test(test_error_within_bound),
        cmocka_unit_test(test_bound_is_reached),
        cmocka_unit_test(test_bias),
        cmocka_unit_test(test_blending_fails),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_runs_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
