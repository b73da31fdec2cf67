// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/tree/stack.h"

#include <math.h>

#include "filter/check.h"

enum { DEFAULT_BRANCHING = 4 };

// Weights of one node are brought to integers of so many bits: their sums have 4 more, and times a
// denominator of 24 bits fit into 128.
enum { SHARE_BITS = 96, VALUE_BITS = 126 };

// Of a float's rounding, relatively.
static const double half_ulp = 0x1p-24;

// ---- weights ------------------------------------------------------------------------------------

static int bits_of(unsigned __int128 value)
{
    const uint64_t high = (uint64_t)(value >> 64), low = (uint64_t)value;
    return high ? 128 - __builtin_clzll(high) : low ? 64 - __builtin_clzll(low) : 0;
}

struct weft_tree_weight weft_tree_weight_from(double weight)
{
    int exponent;
    const uint64_t value = (uint64_t)ldexp(frexp(weight, &exponent), 53);
    const int zeros = __builtin_ctzll(value);
    return (struct weft_tree_weight){value >> zeros, exponent - 53 + zeros};
}

static unsigned __int128 shifted(unsigned __int128 value, int left)
{
    return left >= 0 ? value << left : left > -128 ? value >> -left : 0;
}

struct weft_tree_weight weft_tree_weight_add(struct weft_tree_weight a, struct weft_tree_weight b)
{
    const int top_a = bits_of(a.value) + a.exponent, top_b = bits_of(b.value) + b.exponent;
    const int top = top_a > top_b ? top_a : top_b;
    int exponent = a.exponent < b.exponent ? a.exponent : b.exponent;
    if (exponent < top - VALUE_BITS)
        exponent = top - VALUE_BITS;
    return (struct weft_tree_weight){shifted(a.value, a.exponent - exponent) +
                                         shifted(b.value, b.exponent - exponent),
                                     exponent};
}

// ---- shares -------------------------------------------------------------------------------------

// Of one node: integers in the ratio of the weights.
struct shares {
    int count;
    unsigned __int128 value[WEFT_TREE_MAX_INPUTS], total;
    double exact[WEFT_TREE_MAX_INPUTS]; // the weights by their sum
    bool cut;                           // bits were lost: the ratio is not the weights' own
};

static struct shares make_shares(const struct weft_tree_part *inputs, int count)
{
    struct shares s = {.count = count};
    int lowest = inputs[0].weight.exponent, top = lowest;
    for (int k = 0; k < count; k++) {
        const struct weft_tree_weight *w = &inputs[k].weight;
        lowest = w->exponent < lowest ? w->exponent : lowest;
        top = bits_of(w->value) + w->exponent > top ? bits_of(w->value) + w->exponent : top;
    }
    if (lowest < top - SHARE_BITS)
        lowest = top - SHARE_BITS;
    for (int k = 0; k < count; k++) {
        const struct weft_tree_weight *w = &inputs[k].weight;
        const int left = w->exponent - lowest;
        s.value[k] = shifted(w->value, left);
        s.cut = s.cut || (left < 0 && shifted(s.value[k], -left) != w->value);
        s.total += s.value[k];
    }
    for (int k = 0; k < count; k++)
        s.exact[k] = ldexp((double)inputs[k].weight.value, inputs[k].weight.exponent - lowest) /
                     (double)s.total;
    return s;
}

static unsigned __int128 common_divisor(unsigned __int128 a, unsigned __int128 b)
{
    while (b >> 64) {
        const unsigned __int128 rest = a % b;
        a = b;
        b = rest;
    }
    if (b == 0)
        return a;
    uint64_t high = (uint64_t)b, low = (uint64_t)(a % b);
    while (low) {
        const uint64_t rest = high % low;
        high = low;
        low = rest;
    }
    return high;
}

// In lowest terms.
static void reduce(struct shares *s)
{
    unsigned __int128 divisor = s->value[0];
    for (int k = 1; k < s->count && divisor != 1; k++)
        if (s->value[k] != divisor)
            divisor = common_divisor(s->value[k], divisor);
    if (divisor == 1)
        return;
    for (int k = 0; k < s->count; k++)
        s->value[k] /= divisor;
    s->total /= divisor;
}

// Shares of `denominator` by the largest remainder: whole units first, and what is left of them to
// those that are owed the most, the first ones where they are owed as much.
static void round_to(struct shares *s, uint32_t denominator)
{
    unsigned __int128 owed[WEFT_TREE_MAX_INPUTS];
    const unsigned __int128 total = s->total;
    uint32_t left = denominator;
    for (int k = 0; k < s->count; k++) {
        owed[k] = s->value[k] * denominator % total;
        s->value[k] = s->value[k] * denominator / total;
        left -= (uint32_t)s->value[k];
    }
    for (; left > 0; left--) {
        int largest = 0;
        for (int k = 1; k < s->count; k++)
            if (owed[k] > owed[largest])
                largest = k;
        s->value[largest]++;
        owed[largest] = 0;
    }
    s->total = denominator;
}

// ---- nodes --------------------------------------------------------------------------------------

static uint32_t added(enum weft_tree_rounding rounding, uint32_t denominator, int64_t node)
{
    if (rounding == WEFT_TREE_TRUNCATE)
        return 0;
    const bool halves_go_down = rounding == WEFT_TREE_UNBIASED && node % 2 == 1;
    return (denominator - (halves_go_down ? 1 : 0)) / 2;
}

// The largest of |rounded - exact|, and over all remainders, equally likely, the mean of it with
// its sign. A remainder r becomes -r / D, or 1 - r / D where r + add reaches D, which `add` of
// them do.
static double rounding_error(const struct weft_tree_node *node, enum weft_tree_rounding rounding)
{
    const double d = node->denominator;
    return rounding == WEFT_TREE_TRUNCATE ? (d - 1.0) / d : d > 1.0 ? 0.5 : 0.0;
}

static double rounding_bias(const struct weft_tree_node *node)
{
    const double d = node->denominator;
    return (node->add - (d - 1.0) / 2.0) / d;
}

// Largest remainders only where the weights' own ratio has larger integers. Returns whether the
// numerators are just that ratio.
static bool choose_codes(const struct weft_tree_shape *shape, int64_t index, struct shares *s,
                         struct weft_tree_node *node)
{
    const bool fits = s->total <= shape->largest_denominator;
    if (!fits) {
        round_to(s, shape->largest_denominator);
        reduce(s);
    }
    for (int k = 0; k < s->count; k++)
        node->numerator[k] = (uint32_t)s->value[k];
    node->denominator = (uint32_t)s->total;
    node->add = added(shape->rounding, node->denominator, index);
    return fits && !s->cut;
}

// The node rounds by rounding_error. A share that is off by d adds d times an input: as all shares
// add up to 1, together at most sum |d| / 2 times the largest code.
static void make_codes(const struct weft_tree_shape *shape, const struct weft_tree_part *inputs,
                       int64_t index, struct shares *s, struct weft_tree_node *node,
                       struct weft_tree_part *out)
{
    const bool same = choose_codes(shape, index, s, node);
    out->error = rounding_error(node, shape->rounding);
    out->bias = rounding_bias(node);
    for (int k = 0; k < s->count; k++) {
        const double share = (double)node->numerator[k] / node->denominator;
        const double ratio = same ? 1.0 : share > 0.0 ? share / s->exact[k] : 0.0;
        const double change = same ? 0.0 : fabs(share - s->exact[k]);
        out->error += share * inputs[k].error + 0.5 * change * shape->largest_code;
        out->bias += share * inputs[k].bias;
        out->least = fmin(out->least, inputs[k].least * ratio);
        out->most = fmax(out->most, inputs[k].most * ratio);
    }
}

// With unit roundoff u = 2^-24 and b inputs y, in shares s of which factors are within u: a product
// rounds once, and its sum with the others b - 1 times, so that the result is within
// ((1 + u)^(b + 1) - 1) sum s |y| of sum s y. The inputs' magnitude is at most that of all leaves,
// and what the inputs themselves are off by.
static void make_floats(const struct weft_tree_part *inputs, const struct shares *s,
                        struct weft_tree_node *node, struct weft_tree_part *out)
{
    double error = 0.0;
    for (int k = 0; k < s->count; k++) {
        node->factor[k] = (float)s->exact[k];
        const double ratio = node->factor[k] > 0.0f ? (double)node->factor[k] / s->exact[k] : 0.0;
        error += s->exact[k] * inputs[k].error;
        out->least = fmin(out->least, inputs[k].least * ratio);
        out->most = fmax(out->most, inputs[k].most * ratio);
    }
    const double growth = expm1((s->count + 1) * log1p(half_ulp));
    out->error = error + growth * (1.0 + error);
}

// ---- stacks -------------------------------------------------------------------------------------

static bool is_branching(int inputs)
{
    return inputs >= 2 && inputs <= WEFT_TREE_MAX_INPUTS;
}

static bool is_list(const int *factors)
{
    int count = 0;
    while (count < WEFT_TREE_MAX_LEVELS && is_branching(factors[count]))
        count++;
    while (count < WEFT_TREE_MAX_LEVELS && factors[count] == 0)
        count++;
    return count == WEFT_TREE_MAX_LEVELS;
}

enum weft_result weft_tree_shape_check(const struct weft_log *log, struct weft_tree_shape *shape)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (shape->branching == 0)
        shape->branching = DEFAULT_BRANCHING;
    weft_require_enum(log, shape->rounding, WEFT_TREE_ROUNDING_COUNT - 1);
    if (!is_branching(shape->branching) || !is_list(shape->level_branching)) {
        weft_error(log,
                   "tree: branching (%d) and the factors of level_branching are from 2 to %d, and "
                   "a list ends with its first 0",
                   shape->branching, WEFT_TREE_MAX_INPUTS);
        goto fail;
    }
    res = WEFT_OK;
fail:
    return res;
}

int64_t weft_tree_shape_capacity(const struct weft_tree_shape *shape)
{
    int64_t product = 1;
    if (shape->level_branching[0] == 0)
        return INT64_MAX;
    for (int l = 0; l < WEFT_TREE_MAX_LEVELS && shape->level_branching[l]; l++)
        if (__builtin_mul_overflow(product, shape->level_branching[l], &product))
            return INT64_MAX;
    return product;
}

static int branching_of(const struct weft_tree_shape *shape, int level)
{
    return shape->level_branching[0] == 0 ? shape->branching
           : level < WEFT_TREE_MAX_LEVELS ? shape->level_branching[level]
                                          : 0;
}

void weft_tree_stack_push(struct weft_tree_stack *stack, struct weft_tree_weight weight,
                          double error)
{
    stack->part[stack->count++] =
        (struct weft_tree_part){.weight = weight, .error = error, .least = 1.0, .most = 1.0};
    stack->leaves++;
    if (stack->count > stack->most)
        stack->most = stack->count;
}

// A complete part of each level, from the leaves up; then as many of each as the mixed-radix number
// `count` has, the highest first.
void weft_tree_stack_fill(struct weft_tree_stack *stack, int64_t count, double error)
{
    struct weft_tree_part complete[WEFT_TREE_MAX_DEPTH];
    int64_t span[WEFT_TREE_MAX_DEPTH] = {1};
    int level = 0;
    weft_tree_stack_push(stack, weft_tree_weight_from(1.0), error);
    for (;; level++) {
        const int inputs = branching_of(&stack->shape, level);
        struct weft_tree_node node;
        complete[level] = stack->part[0];
        if (inputs == 0 || span[level] > count / inputs)
            break;
        span[level + 1] = span[level] * inputs;
        for (int k = 1; k < inputs; k++)
            stack->part[k] = complete[level];
        stack->count = inputs;
        weft_tree_stack_combine(stack, inputs, &node);
    }
    stack->count = 0;
    stack->leaves = count;
    for (; level >= 0; count -= count / span[level] * span[level], level--) {
        stack->nodes[level] = stack->leaves / span[level];
        for (int64_t k = 0; k < count / span[level]; k++)
            stack->part[stack->count++] = complete[level];
    }
}

// The uppermost parts of the level of the uppermost one.
static int count_on_top(const struct weft_tree_stack *stack)
{
    int count = 1;
    while (count < stack->count &&
           stack->part[stack->count - 1 - count].level == stack->part[stack->count - 1].level)
        count++;
    return count;
}

int weft_tree_stack_ready(const struct weft_tree_stack *stack)
{
    const int count = count_on_top(stack);
    const int wanted = branching_of(&stack->shape, stack->part[stack->count - 1].level);
    return count == wanted ? count : 0;
}

int weft_tree_stack_carry(struct weft_tree_stack *stack)
{
    if (stack->count <= 1)
        return 0;
    const int count = count_on_top(stack);
    if (count > 1)
        return count;
    stack->part[stack->count - 1].level = stack->part[stack->count - 2].level;
    return count_on_top(stack);
}

void weft_tree_stack_combine(struct weft_tree_stack *stack, int count, struct weft_tree_node *out)
{
    struct weft_tree_part *inputs = &stack->part[stack->count - count];
    const int level = inputs->level + 1;
    const int64_t index = stack->nodes[level]++;
    struct shares shares = make_shares(inputs, count);
    struct weft_tree_part part = {.weight = inputs[0].weight, .level = level, .least = INFINITY};
    *out = (struct weft_tree_node){.input_count = count};
    for (int k = 1; k < count; k++)
        part.weight = weft_tree_weight_add(part.weight, inputs[k].weight);
    if (stack->shape.largest_denominator > 0) {
        reduce(&shares);
        make_codes(&stack->shape, inputs, index, &shares, out, &part);
    } else {
        make_floats(inputs, &shares, out, &part);
    }
    inputs[0] = part;
    stack->count -= count - 1;
}

static bool is_weight(const struct weft_tree_weight *w)
{
    return w->value > 0 && bits_of(w->value) <= VALUE_BITS + 1 && w->exponent > -2000 &&
           w->exponent < 2000;
}

// Between frames all parts are complete, fewer than a node on each level: the digits of the number
// of leaves.
bool weft_tree_stack_is_sound(const struct weft_tree_stack *stack)
{
    int64_t left = stack->leaves, span = 1;
    int i = stack->count - 1;
    if (stack->count < 0 || left < 0 || stack->most < stack->count ||
        stack->most > WEFT_TREE_MAX_PARTS)
        return false;
    for (int level = 0; level < WEFT_TREE_MAX_DEPTH && left > 0; level++) {
        const int inputs = branching_of(&stack->shape, level), most = inputs ? inputs - 1 : 1;
        for (int k = 0; i >= 0 && stack->part[i].level == level; i--, k++) {
            left -= span;
            if (k == most || left < 0 || !is_weight(&stack->part[i].weight))
                return false;
        }
        if (inputs == 0 || __builtin_mul_overflow(span, inputs, &span))
            break;
    }
    for (int level = 0; level < WEFT_TREE_MAX_DEPTH; level++)
        if (stack->nodes[level] < 0 || stack->nodes[level] > stack->leaves)
            return false;
    return left == 0 && i < 0;
}

struct weft_tree_part weft_tree_stack_preview(const struct weft_tree_stack *stack)
{
    struct weft_tree_stack copy = *stack;
    struct weft_tree_node node;
    for (int count = 0; (count = weft_tree_stack_carry(&copy)) > 0;)
        weft_tree_stack_combine(&copy, count, &node);
    return copy.part[0];
}
