// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/tree/images.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/half.h"
#include "filter/threads.h"

enum { CHUNK = 1024 }; // values that are made at once

// ---- images -------------------------------------------------------------------------------------

static enum weft_result no_memory(const struct weft_tree_images_params *p)
{
    weft_error(p->log, "tree: not enough memory for an image of %d x %d pixels", p->width,
               p->height);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_tree_images_create(const struct weft_tree_images_params *params,
                                         struct weft_tree_images **out)
{
    struct weft_tree_images *images = calloc(1, sizeof *images);
    *out = images;
    if (!images)
        return no_memory(params);
    images->params = *params;
    images->one = params->bits == 8 ? UINT8_MAX : params->bits == 16 ? UINT16_MAX : 0;
    images->texel_size = WEFT_TREE_GROUP * (size_t)params->bits / 8;
    enum weft_result res = WEFT_OK;
    if (!weft_size_mul((size_t)params->width * (size_t)params->height, images->texel_size,
                       &images->group_size))
        res = no_memory(params);
    if (res == WEFT_OK && params->context)
        res = weft_tree_gl_create(images);
    if (res != WEFT_OK)
        weft_tree_images_destroy(out);
    return res;
}

static void destroy_image(struct weft_tree_images *images, struct weft_tree_image *image)
{
    for (int g = 0; image->targets && g < images->params.groups; g++)
        weft_gl_target_destroy(&images->params.context->gl, &image->targets[g]);
    free(image->targets);
    free(image->texels);
    *image = (struct weft_tree_image){0};
}

void weft_tree_images_destroy(struct weft_tree_images **images)
{
    if (!images || !*images)
        return;
    for (int i = 0; i < (*images)->alive; i++)
        destroy_image(*images, &(*images)->image[i]);
    if ((*images)->params.context)
        weft_tree_gl_destroy(*images);
    free(*images);
    *images = NULL;
}

static enum weft_result make_targets(struct weft_tree_images *images, struct weft_tree_image *image)
{
    const struct weft_tree_images_params *p = &images->params;
    const GLenum format = p->bits == 8 ? GL_RGBA8 : p->bits == 16 ? GL_RGBA16 : GL_RGBA32F;
    enum weft_result res = WEFT_OK;
    image->targets = calloc((size_t)p->groups, sizeof *image->targets);
    if (!image->targets)
        return no_memory(p);
    for (int g = 0; res == WEFT_OK && g < p->groups; g++)
        res = weft_gl_target_create(p->log, &p->context->gl, format, p->width, p->height,
                                    &image->targets[g]);
    return res;
}

static enum weft_result make_image(struct weft_tree_images *images, struct weft_tree_image *image)
{
    size_t size;
    if (images->params.context)
        return make_targets(images, image);
    if (weft_size_mul(images->group_size, (size_t)images->params.groups, &size))
        image->texels = malloc(size);
    return image->texels ? WEFT_OK : no_memory(&images->params);
}

enum weft_result weft_tree_images_take(struct weft_tree_images *images, int *out)
{
    enum weft_result res = WEFT_OK;
    int i = 0;
    while (i < images->alive && images->image[i].used)
        i++;
    if (i == images->alive) {
        res = make_image(images, &images->image[i]);
        if (res != WEFT_OK) {
            destroy_image(images, &images->image[i]);
            return res;
        }
        images->alive++;
    }
    if (images->alive > images->most)
        images->most = images->alive;
    images->image[i].used = true;
    *out = i;
    return WEFT_OK;
}

void weft_tree_images_give(struct weft_tree_images *images, int image)
{
    images->image[image].used = false;
}

static char *texels_of(const struct weft_tree_images *images, int image, int group)
{
    return (char *)images->image[image].texels + (size_t)group * images->group_size;
}

// ---- nodes in memory ----------------------------------------------------------------------------

struct node_work {
    const struct weft_tree_images *images;
    const int *inputs;
    const struct weft_tree_node *node;
    int out;
};

// Sums are below 2^32: see largest_denominator.
static void combine_codes(const uint32_t *sums, uint32_t denominator, void *out, bool bytes,
                          size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (bytes)
            ((uint8_t *)out)[i] = (uint8_t)(sums[i] / denominator);
        else
            ((uint16_t *)out)[i] = (uint16_t)(sums[i] / denominator);
    }
}

static void add_codes(uint32_t factor, const void *in, bool bytes, uint32_t *sums, size_t count)
{
    if (bytes)
        for (size_t i = 0; i < count; i++)
            sums[i] += factor * ((const uint8_t *)in)[i];
    else
        for (size_t i = 0; i < count; i++)
            sums[i] += factor * ((const uint16_t *)in)[i];
}

// What is too small for a normal number is 0, as it is to Mesa's software renderer.
static inline float flushed(float v)
{
    return fabsf(v) < FLT_MIN ? copysignf(0.0f, v) : v;
}

// Products and their sums are rounded apart.
static void add_floats(float factor, const float *in, bool first, float *sums, size_t count)
{
    if (first)
        for (size_t i = 0; i < count; i++)
            sums[i] = flushed(in[i] * factor);
    else
        for (size_t i = 0; i < count; i++)
            sums[i] = flushed(sums[i] + flushed(in[i] * factor));
}

// Part i of the work: CHUNK values, of all groups one after another.
static bool combine_chunk(void *priv, int thread, size_t i)
{
    (void)thread;
    const struct node_work *s = priv;
    const struct weft_tree_images *images = s->images;
    const struct weft_tree_node *node = s->node;
    const size_t value = images->texel_size / WEFT_TREE_GROUP;
    const size_t all = images->group_size * (size_t)images->params.groups;
    const size_t first = i * CHUNK * value, rest = (all - first) / value;
    const size_t count = rest < CHUNK ? rest : CHUNK;
    char *out = (char *)images->image[s->out].texels + first;
    uint32_t sums[CHUNK];
    for (size_t x = 0; x < count; x++)
        sums[x] = node->add;
    for (int k = 0; k < node->input_count; k++) {
        const char *in = (const char *)images->image[s->inputs[k]].texels + first;
        if (images->one)
            add_codes(node->numerator[k], in, images->params.bits == 8, sums, count);
        else
            add_floats(node->factor[k], (const float *)in, k == 0, (float *)out, count);
    }
    if (images->one)
        combine_codes(sums, node->denominator, out, images->params.bits == 8, count);
    return true;
}

enum weft_result weft_tree_images_combine(struct weft_tree_images *images, const int *inputs,
                                          const struct weft_tree_node *node, int out)
{
    if (images->params.context)
        return weft_tree_gl_combine(images, inputs, node, out);
    struct node_work s = {images, inputs, node, out};
    const size_t values =
        images->group_size * (size_t)images->params.groups / (images->texel_size / WEFT_TREE_GROUP);
    weft_threads_run(images->params.threads, (values + CHUNK - 1) / CHUNK, combine_chunk, &s);
    images->passes += (uint64_t)images->params.groups;
    return WEFT_OK;
}

// ---- frames in memory ---------------------------------------------------------------------------

// What tree_leaf.glsl does.
static float loaded(const struct weft_tree_images *images, float v)
{
    const struct weft_tree_images_params *p = &images->params;
    const float one = (float)images->one;
    if (!images->one)
        return v;
    if (p->ranged) {
        v = v - p->low;
        v = v * p->scale;
    }
    v = v * one;
    v = floorf(v + 0.5f);
    return v > 0.0f ? v < one ? v : one : 0.0f;
}

static float value_of(enum weft_plane_type type, const void *texels, size_t i)
{
    switch (type) {
    case WEFT_PLANE_HALF:
        return weft_half_to_float(((const uint16_t *)texels)[i]);
    case WEFT_PLANE_UNORM8:
        return (float)((const uint8_t *)texels)[i] * (float)(1.0 / UINT8_MAX);
    case WEFT_PLANE_UNORM16:
        return (float)((const uint16_t *)texels)[i] * (float)(1.0 / UINT16_MAX);
    default:
        return ((const float *)texels)[i];
    }
}

void weft_tree_images_load_row(struct weft_tree_images *images, int image, int group, int32_t y,
                               enum weft_plane_type type, const void *texels)
{
    const struct weft_tree_images_params *p = &images->params;
    const size_t count = (size_t)p->width * WEFT_TREE_GROUP;
    void *row = texels_of(images, image, group) + (size_t)y * (size_t)p->width * images->texel_size;
    const bool same = type == (p->bits == 8    ? WEFT_PLANE_UNORM8
                               : p->bits == 16 ? WEFT_PLANE_UNORM16
                                               : WEFT_PLANE_FLOAT);
    if (same && !(images->one && p->ranged)) {
        memcpy(row, texels, (size_t)p->width * images->texel_size);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const float v = loaded(images, value_of(type, texels, i));
        if (p->bits == 8)
            ((uint8_t *)row)[i] = (uint8_t)v;
        else if (p->bits == 16)
            ((uint16_t *)row)[i] = (uint16_t)v;
        else
            ((float *)row)[i] = v;
    }
}

enum weft_result weft_tree_images_load(struct weft_tree_images *images, int image, int group,
                                       const struct weft_gl_target *texture)
{
    return weft_tree_gl_load(images, &images->image[image].targets[group], texture);
}

// ---- as they are --------------------------------------------------------------------------------

static GLenum texel_type(const struct weft_tree_images *images)
{
    return images->params.bits == 8    ? GL_UNSIGNED_BYTE
           : images->params.bits == 16 ? GL_UNSIGNED_SHORT
                                       : GL_FLOAT;
}

enum weft_result weft_tree_images_read(struct weft_tree_images *images, int image, int group,
                                       void *out)
{
    const struct weft_tree_images_params *p = &images->params;
    if (p->context)
        return weft_gl_target_read(
            p->log, &p->context->gl, &images->image[image].targets[group],
            &(struct weft_gl_pixels){
                .width = p->width, .height = p->height, .type = texel_type(images), .data = out});
    memcpy(out, texels_of(images, image, group), images->group_size);
    return WEFT_OK;
}

enum weft_result weft_tree_images_write(struct weft_tree_images *images, int image, int group,
                                        const void *texels)
{
    const struct weft_tree_images_params *p = &images->params;
    if (!p->context) {
        memcpy(texels_of(images, image, group), texels, images->group_size);
        return WEFT_OK;
    }
    const GladGLContext *gl = &p->context->gl;
    gl->BindTexture(GL_TEXTURE_2D, images->image[image].targets[group].texture);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, p->width, p->height, GL_RGBA, texel_type(images),
                      texels);
    return weft_gl_check(p->log, gl, "writing a tree's image");
}
