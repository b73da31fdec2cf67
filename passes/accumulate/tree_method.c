// SPDX-License-Identifier: BSD-3-Clause
// Trees as a method of accumulators: frames become images on a stack of parts.
//
// The bound. In codes, unit = (high - low) / largest code:
// - A frame becomes codes: not at all where it is of as many bits and stands for 0 to 1; otherwise
//   to the nearest, by 1/2 and by what single precision costs (codes_error).
// - Nodes: see make_codes in tree/stack.c, which has the rounding of results and what shares are
//   off by.
// - The result, low + code * unit, is rounded to a float: half a unit in the last place.
// In floats everything is relative to the largest magnitude of all frames: codes that become floats
// are rounded twice, large integers once; nodes: make_floats. Products that are too small for
// floats lose 2^-126 each, 33 of them a node and 26 nodes above a leaf: below 2^-116 together.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/frame.h"
#include "passes/accumulate/tree/images.h"
#include "passes/accumulate/values.h"

struct method {
    struct weft_tree_stack stack;
    int image[WEFT_TREE_MAX_PARTS]; // of each part
    struct weft_tree_images *images;
    struct weft_value_range range;
    double largest; // magnitude of all frames, of floats
    char *result;   // groups of the mean of the frames so far
    bool has_result;
    void *packed;    // a row of a group, where images are in memory
    uint64_t passes; // of images that are no more
    int most;
};

static const double half_ulp = 0x1p-24;

// ---- bounds -------------------------------------------------------------------------------------

static bool has_codes(const struct weft_accumulator_params *p)
{
    return p->bits != 32;
}

// Shares are such that sums of codes fit into 32 bits.
static struct weft_tree_shape shape_of(const struct weft_accumulator_params *p)
{
    struct weft_tree_shape shape = {.branching = p->branching, .rounding = p->rounding};
    memcpy(shape.level_branching, p->level_branching, sizeof shape.level_branching);
    if (has_codes(p)) {
        shape.largest_code = p->bits == 8 ? UINT8_MAX : UINT16_MAX;
        shape.largest_denominator = (uint32_t)(UINT64_C(0x100000000) / (shape.largest_code + 1));
    }
    return shape;
}

// Of a frame in GL's terms: its largest code, 0 for floats. Codes as floats take a rounding of the
// factor and one of the product, t has range->error, and t one + 1/2 two more.
static double codes_error(const struct weft_accumulator_params *p,
                          const struct weft_value_range *range, uint32_t source)
{
    const double one = p->bits == 8 ? UINT8_MAX : UINT16_MAX;
    const bool finer = source && (uint32_t)one % source == 0;
    if (range->whole && finer)
        return 0.0;
    const double place = range->error + half_ulp * (2.0 * range->extent / range->size + 3.0);
    return 0.5 + one * place;
}

static double floats_error(enum weft_plane_type type)
{
    switch (type) {
    case WEFT_PLANE_UNORM8:
    case WEFT_PLANE_UNORM16:
        return 2.0 * half_ulp;
    case WEFT_PLANE_UINT:
        return half_ulp;
    default:
        return 0.0;
    }
}

static uint32_t code_of_type(enum weft_plane_type type)
{
    return type == WEFT_PLANE_UNORM8 ? UINT8_MAX : type == WEFT_PLANE_UNORM16 ? UINT16_MAX : 0;
}

static enum weft_plane_type type_of_format(GLenum format)
{
    return format == GL_R8 || format == GL_RGBA8     ? WEFT_PLANE_UNORM8
           : format == GL_R16 || format == GL_RGBA16 ? WEFT_PLANE_UNORM16
                                                     : WEFT_PLANE_FLOAT;
}

static double type_error(const struct weft_accumulator_params *p,
                         const struct weft_value_range *range, enum weft_plane_type type)
{
    return has_codes(p) ? codes_error(p, range, code_of_type(type)) : floats_error(type);
}

static double bound_of(const struct weft_accumulator_params *p,
                       const struct weft_value_range *range, const struct weft_tree_part *part,
                       double largest)
{
    const double one = p->bits == 8 ? UINT8_MAX : UINT16_MAX;
    const double slack = 1.0 + 0x1p-20; // of what is counted in doubles here
    if (!has_codes(p))
        return part->error * largest * slack + 0x1p-116;
    return (part->error * range->size / one + half_ulp * range->extent) * slack + 0x1p-149;
}

static double expect(const struct weft_accumulator_params *p, int64_t frames)
{
    const struct weft_value_range range = weft_value_range_of(p);
    struct weft_tree_stack stack = {.shape = shape_of(p)};
    if (weft_tree_shape_check(NULL, &stack.shape) != WEFT_OK ||
        frames > weft_tree_shape_capacity(&stack.shape) || frames < 1)
        return INFINITY;
    weft_tree_stack_fill(
        &stack, frames, type_error(p, &range, has_codes(p) ? WEFT_PLANE_FLOAT : WEFT_PLANE_UNORM8));
    const struct weft_tree_part part = weft_tree_stack_preview(&stack);
    return bound_of(p, &range, &part, range.extent);
}

// ---- accumulators -------------------------------------------------------------------------------

static enum weft_result check_params(const struct weft_accumulator_params *p)
{
    if (p->bits != 8 && p->bits != 16 && p->bits != 32) {
        weft_error(p->log, "accumulate: trees have 8, 16 or 32 bits, not half floats");
        return WEFT_ERR_ARGUMENT;
    }
    if (has_codes(p) && p->nonfinite == WEFT_NONFINITE_PROPAGATE) {
        weft_error(p->log, "accumulate: trees of %d bits hold no NaN: nonfinite is %s", p->bits,
                   weft_accumulate_nonfinite_names[p->nonfinite]);
        return WEFT_ERR_ARGUMENT;
    }
    if (!p->context && !p->emulate) {
        weft_error(p->log, "accumulate: trees need a context, or emulate");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static bool on_gl(const weft_accumulator *a)
{
    return !a->params.emulate;
}

static enum weft_result enter(const weft_accumulator *a)
{
    return on_gl(a) ? weft_context_enter(a->params.context) : WEFT_OK;
}

static void leave(const weft_accumulator *a)
{
    if (on_gl(a))
        weft_context_leave(a->params.context);
}

static enum weft_result make_images(weft_accumulator *a, struct method *m)
{
    const struct weft_accumulator_params *p = &a->params;
    enum weft_result res = enter(a);
    if (res != WEFT_OK)
        return res;
    res = weft_tree_images_create(
        &(struct weft_tree_images_params){
            .width = p->width,
            .height = p->height,
            .groups = weft_frame_groups(a),
            .bits = p->bits,
            .ranged = !m->range.whole,
            .low = m->range.low,
            .scale = m->range.scale,
            .threads = p->cpu.threads,
            .context = on_gl(a) ? p->context : NULL,
            .log = p->log,
        },
        &m->images);
    leave(a);
    return res;
}

static enum weft_result no_memory(const weft_accumulator *a)
{
    weft_error(a->params.log, "accumulate: not enough memory for a tree");
    return WEFT_ERR_MEMORY;
}

// Frames that will count, where they are known.
static int64_t count_leaves(const weft_accumulator *a)
{
    int64_t count = 0;
    for (int64_t i = 0; a->weight && i < a->params.frame_count; i++)
        count += a->weight[i] != 0.0;
    return count;
}

static enum weft_result create(weft_accumulator *a)
{
    const struct weft_accumulator_params *p = &a->params;
    struct weft_tree_shape shape = shape_of(p);
    enum weft_result res = check_params(p);
    if (res == WEFT_OK)
        res = weft_tree_shape_check(p->log, &shape);
    if (res != WEFT_OK)
        return res;
    if (count_leaves(a) > weft_tree_shape_capacity(&shape)) {
        weft_error(p->log,
                   "accumulate: %" PRId64 " frames, but the branching factors multiply to %" PRId64,
                   count_leaves(a), weft_tree_shape_capacity(&shape));
        return WEFT_ERR_ARGUMENT;
    }
    struct method *m = calloc(1, sizeof *m);
    a->own = m;
    if (!m)
        return no_memory(a);
    m->stack.shape = shape;
    m->range = weft_value_range_of(p);
    m->packed = malloc((size_t)p->width * WEFT_FRAME_GROUP * sizeof(float));
    return m->packed ? make_images(a, m) : no_memory(a);
}

static void destroy_images(weft_accumulator *a)
{
    struct method *m = a->own;
    if (!m->images || enter(a) != WEFT_OK)
        return;
    m->passes = m->images->passes;
    m->most = m->images->most;
    weft_tree_images_destroy(&m->images);
    leave(a);
}

static void destroy(weft_accumulator *a)
{
    struct method *m = a->own;
    if (!m)
        return;
    destroy_images(a);
    free(m->packed);
    free(m->result);
    free(m);
    a->own = NULL;
}

// ---- frames -------------------------------------------------------------------------------------

// Frames that are drawn go straight into the image where values are codes, or floats, as they are.
static bool draws_into_images(const weft_accumulator *a, const struct weft_frame *frame)
{
    const struct method *m = a->own;
    return frame->draw && !a->scan && a->params.frame_bits == a->params.bits &&
           (m->range.whole || !has_codes(&a->params));
}

// What was uploaded as it has to be changes places with the image; the rest is drawn.
static enum weft_result load_textures(weft_accumulator *a, const struct weft_frame *frame,
                                      int image, double *error)
{
    struct method *m = a->own;
    const struct weft_gl_target *textures = NULL;
    enum weft_result res = weft_frame_textures(a, frame, &textures);
    for (int g = 0; res == WEFT_OK && g < weft_frame_groups(a); g++) {
        struct weft_gl_target *target = &m->images->image[image].targets[g];
        const bool same = frame->plane && textures[g].format == target->format &&
                          (m->range.whole || !has_codes(&a->params));
        *error =
            fmax(*error, type_error(&a->params, &m->range, type_of_format(textures[g].format)));
        if (same)
            weft_frame_swap(a, g, target);
        else
            res = weft_tree_images_load(m->images, image, g, &textures[g]);
    }
    return res;
}

static void load_planes(weft_accumulator *a, const struct weft_plane *planes, int image,
                        double *error)
{
    struct method *m = a->own;
    const struct weft_accumulator_params *p = &a->params;
    for (int g = 0; g < weft_frame_groups(a); g++) {
        const struct weft_plane *first = planes + g * WEFT_FRAME_GROUP;
        const int rest = p->channel_count - g * WEFT_FRAME_GROUP;
        const int count = rest < WEFT_FRAME_GROUP ? rest : WEFT_FRAME_GROUP;
        const enum weft_plane_type type = weft_frame_common_type(first, count);
        *error = fmax(*error, type_error(p, &m->range, type));
        for (int32_t y = 0; y < p->height; y++) {
            weft_frame_pack_row(first, count, type, y, p->width, m->packed);
            weft_tree_images_load_row(m->images, image, g, y, type, m->packed);
        }
    }
}

// What is on GL is not looked at: its magnitude is taken to be that of the range.
static enum weft_result check_frame(weft_accumulator *a, const struct weft_frame *frame,
                                    double *largest)
{
    const struct method *m = a->own;
    const int64_t capacity = weft_tree_shape_capacity(&m->stack.shape);
    *largest = m->range.extent;
    if (m->stack.leaves >= capacity) {
        weft_error(a->params.log,
                   "accumulate: one frame more than the branching factors' product, %" PRId64,
                   capacity);
        return WEFT_ERR_LIMIT;
    }
    const struct weft_value_limits range = {a->params.low, a->params.high};
    return frame->plane
               ? weft_frame_check(a, frame->plane, has_codes(&a->params) ? &range : NULL, largest)
               : WEFT_OK;
}

// Floats that were integers were rounded once more.
static double plane_error(const weft_accumulator *a, const struct weft_plane *planes)
{
    double error = 0.0;
    for (int c = 0; planes && !has_codes(&a->params) && c < a->params.channel_count; c++)
        error = fmax(error, floats_error(planes[c].type));
    return error;
}

static enum weft_result load(weft_accumulator *a, const struct weft_frame *frame, int image,
                             double *error)
{
    struct method *m = a->own;
    const struct weft_plane *planes = frame->plane;
    *error = plane_error(a, planes);
    if (on_gl(a) && draws_into_images(a, frame))
        return weft_frame_draw(a, frame, &m->images->image[image].targets[0]);
    if (on_gl(a))
        return load_textures(a, frame, image, error);
    const enum weft_result res = weft_frame_planes(a, frame, &planes);
    if (res == WEFT_OK)
        load_planes(a, planes, image, error);
    return res;
}

// Replaces the uppermost parts by a node, in their images' place: from `image`, as many as there
// are parts before it.
static enum weft_result combine(weft_accumulator *a, struct weft_tree_stack *stack, int *image,
                                int count)
{
    struct method *m = a->own;
    struct weft_tree_node node;
    const int first = stack->count - count;
    int out;
    const enum weft_result res = weft_tree_images_take(m->images, &out);
    if (res != WEFT_OK)
        return res;
    weft_tree_stack_combine(stack, count, &node);
    const enum weft_result drawn = weft_tree_images_combine(m->images, image + first, &node, out);
    for (int k = 0; k < count; k++)
        weft_tree_images_give(m->images, image[first + k]);
    image[first] = out;
    return drawn;
}

static enum weft_result push(weft_accumulator *a, int image, double weight, double error)
{
    struct method *m = a->own;
    enum weft_result res = WEFT_OK;
    int count;
    m->image[m->stack.count] = image;
    weft_tree_stack_push(&m->stack, weft_tree_weight_from(weight), error);
    while (res == WEFT_OK && (count = weft_tree_stack_ready(&m->stack)) > 0)
        res = combine(a, &m->stack, m->image, count);
    return res;
}

static enum weft_result add_entered(weft_accumulator *a, const struct weft_frame *frame,
                                    double weight, double largest)
{
    struct method *m = a->own;
    double error = 0.0;
    int image;
    enum weft_result res = weft_tree_images_take(m->images, &image);
    if (res != WEFT_OK)
        return res;
    res = load(a, frame, image, &error);
    if (res != WEFT_OK) {
        weft_tree_images_give(m->images, image);
        return res;
    }
    m->has_result = false;
    m->largest = fmax(m->largest, largest);
    return push(a, image, weight, error);
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    double largest;
    enum weft_result res = check_frame(a, frame, &largest);
    if (res == WEFT_OK)
        res = enter(a);
    if (res != WEFT_OK)
        return res;
    res = add_entered(a, frame, weight, largest);
    leave(a);
    return res;
}

// ---- results ------------------------------------------------------------------------------------

// Carries up a copy of the stack. Images of the stack itself are only read; those of the copy's own
// nodes are given back, and the result is good until another is taken.
static enum weft_result carry_up(weft_accumulator *a, int *out)
{
    struct method *m = a->own;
    struct weft_tree_stack copy = m->stack;
    int image[WEFT_TREE_MAX_PARTS], count;
    bool kept[WEFT_TREE_MAX_IMAGES] = {false};
    enum weft_result res = WEFT_OK;
    memcpy(image, m->image, sizeof image);
    for (int i = 0; i < m->stack.count; i++)
        kept[m->image[i]] = true;
    while (res == WEFT_OK && (count = weft_tree_stack_carry(&copy)) > 0) {
        res = combine(a, &copy, image, count);
        for (int i = 0; i < m->stack.count; i++)
            m->images->image[m->image[i]].used = true;
    }
    for (int i = 0; i < m->images->alive; i++)
        if (!kept[i])
            weft_tree_images_give(m->images, i);
    *out = image[0];
    return res;
}

static enum weft_result read_result(weft_accumulator *a)
{
    struct method *m = a->own;
    int image;
    enum weft_result res = carry_up(a, &image);
    for (int g = 0; res == WEFT_OK && g < weft_frame_groups(a); g++)
        res = weft_tree_images_read(m->images, image, g,
                                    m->result + (size_t)g * m->images->group_size);
    return res;
}

static enum weft_result make_result(weft_accumulator *a)
{
    struct method *m = a->own;
    size_t size;
    if (m->has_result)
        return WEFT_OK;
    if (!m->result && weft_size_mul(m->images->group_size, (size_t)weft_frame_groups(a), &size))
        m->result = malloc(size);
    if (!m->result)
        return no_memory(a);
    enum weft_result res = enter(a);
    if (res != WEFT_OK)
        return res;
    res = read_result(a);
    leave(a);
    m->has_result = res == WEFT_OK;
    return res;
}

static float value_of(const weft_accumulator *a, size_t i)
{
    const struct method *m = a->own;
    const struct weft_accumulator_params *p = &a->params;
    if (!has_codes(p))
        return ((const float *)m->result)[i];
    const double code =
        p->bits == 8 ? ((const uint8_t *)m->result)[i] : ((const uint16_t *)m->result)[i];
    return (float)(p->low + code * m->range.size / m->stack.shape.largest_code);
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const size_t width = (size_t)a->params.width, height = (size_t)a->params.height;
    const size_t first = (size_t)(channel / WEFT_FRAME_GROUP) * width * height * WEFT_FRAME_GROUP +
                         (size_t)(channel % WEFT_FRAME_GROUP);
    const enum weft_result res = make_result(a);
    for (size_t y = 0; res == WEFT_OK && y < height; y++)
        for (size_t x = 0; x < width; x++)
            out[y * stride + x] = value_of(a, first + (y * width + x) * WEFT_FRAME_GROUP);
    return res;
}

static enum weft_result finish(weft_accumulator *a)
{
    const enum weft_result res = make_result(a);
    if (res == WEFT_OK)
        destroy_images(a);
    return res;
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    const struct weft_accumulator_params *p = &a->params;
    const struct weft_tree_images *images = m->images;
    const int groups = weft_frame_groups(a);
    const size_t group_size =
        (size_t)p->width * (size_t)p->height * WEFT_FRAME_GROUP * (size_t)p->bits / 8;
    out->passes = images ? images->passes : m->passes;
    out->textures = on_gl(a) ? groups * (images ? images->most : m->most) : 0;
    out->bytes += (uint64_t)((images ? images->alive : 0) + (m->result ? 1 : 0)) *
                  (uint64_t)groups * group_size;
    if (a->counted == 0) {
        out->bound = p->frame_count ? expect(p, p->frame_count) : INFINITY;
        return;
    }
    const struct weft_tree_part part = weft_tree_stack_preview(&m->stack);
    out->bound = bound_of(p, &m->range, &part, m->largest);
    out->weight_change = fmax(part.most - 1.0, 1.0 - part.least);
    out->bias = has_codes(p) ? part.bias * m->range.size / m->stack.shape.largest_code : 0.0;
}

// ---- states -------------------------------------------------------------------------------------

#define EACH_PART_MEMBER(call, state, part)                                                        \
    do {                                                                                           \
        call(state, &(part)->weight.value, sizeof(part)->weight.value);                            \
        call(state, &(part)->weight.exponent, sizeof(part)->weight.exponent);                      \
        call(state, &(part)->level, sizeof(part)->level);                                          \
        call(state, &(part)->error, sizeof(part)->error);                                          \
        call(state, &(part)->bias, sizeof(part)->bias);                                            \
        call(state, &(part)->least, sizeof(part)->least);                                          \
        call(state, &(part)->most, sizeof(part)->most);                                            \
    } while (0)

#define EACH_MEMBER(call, state, m)                                                                \
    do {                                                                                           \
        call(state, &(m)->largest, sizeof(m)->largest);                                            \
        call(state, &(m)->stack.count, sizeof(m)->stack.count);                                    \
        call(state, &(m)->stack.most, sizeof(m)->stack.most);                                      \
        call(state, &(m)->stack.leaves, sizeof(m)->stack.leaves);                                  \
        call(state, (m)->stack.nodes, sizeof(m)->stack.nodes);                                     \
    } while (0)

// A group of texels on its way.
static enum weft_result make_texels(const weft_accumulator *a, void **out)
{
    const struct method *m = a->own;
    *out = malloc(m->images->group_size);
    return *out ? WEFT_OK : no_memory(a);
}

static enum weft_result save_images(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    void *texels;
    enum weft_result res = make_texels(a, &texels);
    for (int i = 0; res == WEFT_OK && i < m->stack.count; i++)
        for (int g = 0; res == WEFT_OK && g < weft_frame_groups(a); g++) {
            res = weft_tree_images_read(m->images, m->image[i], g, texels);
            weft_state_put(state, texels, m->images->group_size);
        }
    free(texels);
    return res;
}

static enum weft_result save(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    EACH_MEMBER(weft_state_put, state, m);
    for (int i = 0; i < m->stack.count; i++)
        EACH_PART_MEMBER(weft_state_put, state, &m->stack.part[i]);
    enum weft_result res = enter(a);
    if (res != WEFT_OK)
        return res;
    res = save_images(a, state);
    leave(a);
    return res;
}

static enum weft_result load_images(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    void *texels;
    enum weft_result res = make_texels(a, &texels);
    for (int i = 0; res == WEFT_OK && i < m->stack.count; i++) {
        res = weft_tree_images_take(m->images, &m->image[i]);
        for (int g = 0; res == WEFT_OK && g < weft_frame_groups(a); g++)
            if (weft_state_take(state, texels, m->images->group_size))
                res = weft_tree_images_write(m->images, m->image[i], g, texels);
    }
    free(texels);
    return res;
}

static enum weft_result load_state(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    EACH_MEMBER(weft_state_take, state, m);
    const bool sound = m->stack.count >= 0 && m->stack.count <= WEFT_TREE_MAX_PARTS;
    for (int i = 0; sound && i < m->stack.count; i++)
        EACH_PART_MEMBER(weft_state_take, state, &m->stack.part[i]);
    if (state->failed)
        return WEFT_OK;
    if (!sound || m->stack.leaves != a->counted || !weft_tree_stack_is_sound(&m->stack)) {
        weft_error(a->params.log, "accumulate: the state is damaged: its stack cannot be");
        return WEFT_ERR_FORMAT;
    }
    enum weft_result res = enter(a);
    if (res != WEFT_OK)
        return res;
    res = load_images(a, state);
    leave(a);
    return res;
}

const struct weft_accumulate_way weft_accumulate_tree = {
    .method = WEFT_ACCUMULATE_TREE,
    .negative = false,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .finish = finish,
    .expect = expect,
    .report = report,
    .save = save,
    .load = load_state,
};
