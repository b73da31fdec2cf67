// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/tile_error.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_axes.h"
#include "filter/check.h"
#include "filter/kernels/kernel_nd.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "tests/support/texture.h"

// What the sampler returns for one tile, at a grid of resampling positions. Pixel (x, y) is
// position (x, y % locations, y / locations) + 1/2 over locations; placement is gain and bias from
// tile positions to texture coordinates.
static const char lookup_shader[] = "#if DIMS == 1\n"
                                    "uniform sampler1D tile;\n"
                                    "#elif DIMS == 2\n"
                                    "uniform sampler2D tile;\n"
                                    "#else\n"
                                    "uniform sampler3D tile;\n"
                                    "#endif\n"
                                    "uniform int locations;\n"
                                    "uniform vec2 placement;\n"
                                    "uniform bvec3 mirrored;\n"
                                    "\n"
                                    "out float value;\n"
                                    "\n"
                                    "void main()\n"
                                    "{\n"
                                    "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
                                    "    ivec3 i = ivec3(p.x, p.y % locations, p.y / locations);\n"
                                    "    vec3 s = (vec3(i) + 0.5) / float(locations);\n"
                                    "    s = s * placement.x + placement.y;\n"
                                    "    s = mix(s, 1.0 - s, mirrored);\n"
                                    "#if DIMS == 1\n"
                                    "    value = texture(tile, s.x).r;\n"
                                    "#elif DIMS == 2\n"
                                    "    value = texture(tile, s.xy).r;\n"
                                    "#else\n"
                                    "    value = texture(tile, s).r;\n"
                                    "#endif\n"
                                    "}\n";

enum { MAX_LOCATIONS = 4096, MAX_POSITIONS = 1 << 24 };

enum way { MEASURED, IDEAL, EIGHT_BIT, WAYS };

// Two texels of one axis and where the position lies between them.
struct lookup {
    int texel[2];
    double share; // of the second one
    int share_256;
};

// Weights and errors at all positions, [z][y][x].
struct survey {
    struct weft_tile_error_params p;
    const struct weft_kernel_tiles_info *info;
    size_t positions;
    double gain, bias;                       // from tile positions to texture coordinates
    double *exact[3][WEFT_KERNEL_MAX_WIDTH]; // of one axis, by tap: h, h' and h''
    double *weight[WAYS], *magnitude[WAYS], *sum[WAYS];
    double *storage;
    struct lookup *lookups[WAYS][2]; // of one axis at all locations, plain and mirrored
    double single[WAYS], difference[WAYS];
};

// ---- set-up -------------------------------------------------------------------------------------

static enum weft_result check(struct survey *s)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(s->p.log, s->p.tiles);
    weft_require_enum(s->p.log, s->p.lookup, WEFT_ERROR_LINEAR);
    s->info = weft_kernel_tiles_get_info(s->p.tiles);
    if (weft_kernel_is_radial(&s->info->kernel, s->info->dims)) {
        weft_error(s->p.log, "tile error: %s is radial, in %dD its weights are no products",
                   s->info->kernel.info->name, s->info->dims);
        res = WEFT_ERR_UNSUPPORTED;
        goto fail;
    }
    if (!s->p.locations)
        s->p.locations = s->info->dims > 2 ? 32 : 256;
    weft_require(s->p.log, s->p.locations > 0 && s->p.locations <= MAX_LOCATIONS);
    s->positions = 1;
    for (int a = 0; a < s->info->dims; a++)
        s->positions *= (size_t)s->p.locations;
    if (s->positions > MAX_POSITIONS) {
        weft_error(s->p.log, "tile error: %zu positions, over the limit of %d", s->positions,
                   MAX_POSITIONS);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

static double fraction(const struct survey *s, int i)
{
    return (i + 0.5) / s->p.locations;
}

static void fill_exact(struct survey *s)
{
    for (int times = 0; times < 3; times++) {
        struct weft_kernel kernel;
        if (weft_kernel_derive_times(NULL, &s->info->kernel, times, &kernel) != WEFT_OK)
            continue; // no set has it, either
        for (int t = 0; t < s->info->width; t++)
            for (int i = 0; i < s->p.locations; i++)
                s->exact[times][t][i] =
                    weft_kernel_weight(&kernel, fraction(s, i) + (weft_kernel_offset(&kernel) - t));
    }
}

// ---- where samplers look ------------------------------------------------------------------------

static int clamped(const struct survey *s, int texel)
{
    return texel < 0 ? 0 : texel >= s->info->samples ? s->info->samples - 1 : texel;
}

// In floats, as the shader forms it.
static float coordinate(const struct survey *s, int i, bool mirrored)
{
    float at = ((float)i + 0.5f) / (float)s->p.locations;
    at = at * (float)s->gain;
    at = at + (float)s->bias;
    return mirrored ? 1.0f - at : at;
}

static struct lookup ideal_lookup(const struct survey *s, int i, bool mirrored)
{
    const double at = (double)coordinate(s, i, mirrored) * s->info->samples;
    if (s->p.lookup == WEFT_ERROR_NEAREST) {
        const int texel = clamped(s, (int)floor(at));
        return (struct lookup){{texel, texel}, 0.0, 0};
    }
    const double below = floor(at - 0.5);
    return (struct lookup){
        {clamped(s, (int)below), clamped(s, (int)below + 1)}, at - 0.5 - below, 0};
}

static struct lookup eight_bit_lookup(const struct survey *s, int i, bool mirrored)
{
    const float at = coordinate(s, i, mirrored) * (float)s->info->samples;
    const int fixed = (int)lrintf(at * 256.0f) - 128;
    const int below = fixed >> 8; // floor
    return (struct lookup){{clamped(s, below), clamped(s, below + 1)}, 0.0, fixed & 255};
}

static bool models_differ(const struct survey *s)
{
    return s->info->format == WEFT_TILE_UNORM && s->info->bits == 8 &&
           s->p.lookup == WEFT_ERROR_LINEAR;
}

static void fill_lookups(struct survey *s)
{
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        for (int i = 0; i < s->p.locations; i++) {
            s->lookups[IDEAL][mirrored][i] = ideal_lookup(s, i, mirrored);
            s->lookups[EIGHT_BIT][mirrored][i] = eight_bit_lookup(s, i, mirrored);
        }
    }
}

static enum weft_result set_up(const struct weft_tile_error_params *params, struct survey *s)
{
    *s = (struct survey){.p = *params, .gain = 1.0};
    enum weft_result res = check(s);
    if (res != WEFT_OK)
        return res;
    const double m = s->info->samples;
    if (s->info->placement == WEFT_TILE_ENDS) {
        s->gain = (m - 1.0) / m;
        s->bias = 0.5 / m;
    }
    const size_t row = (size_t)s->p.locations;
    s->storage = calloc(3 * WAYS * s->positions + 3 * (size_t)s->info->width * row, sizeof(double));
    struct lookup *lookups = calloc(4 * row, sizeof *lookups);
    s->lookups[IDEAL][0] = lookups; // owns them
    if (!s->storage || !lookups) {
        weft_error(s->p.log, "tile error: not enough memory for %zu positions", s->positions);
        return WEFT_ERR_MEMORY;
    }
    double *next = s->storage;
    for (int w = 0; w < WAYS; w++) {
        s->weight[w] = next;
        s->magnitude[w] = next + s->positions;
        s->sum[w] = next + 2 * s->positions;
        next += 3 * s->positions;
    }
    if (!models_differ(s))
        s->weight[EIGHT_BIT] = s->weight[IDEAL];
    for (int t = 0; t < s->info->width; t++) {
        for (int times = 0; times < 3; times++)
            s->exact[times][t] = next + (3 * (size_t)t + (size_t)times) * row;
    }
    s->lookups[IDEAL][1] = lookups + row;
    s->lookups[EIGHT_BIT][0] = lookups + 2 * row;
    s->lookups[EIGHT_BIT][1] = lookups + 3 * row;
    fill_exact(s);
    fill_lookups(s);
    return WEFT_OK;
}

// ---- models of samplers -------------------------------------------------------------------------

static double load(const struct survey *s, const struct weft_kernel_tile *tile, const int at[3])
{
    const size_t m = (size_t)s->info->samples;
    const size_t i = ((size_t)at[2] * m + (size_t)at[1]) * m + (size_t)at[0];
    switch (s->info->format) {
    case WEFT_TILE_UNORM:
        return ((const uint16_t *)tile->data)[i];
    case WEFT_TILE_SNORM:
        return ((const int16_t *)tile->data)[i];
    case WEFT_TILE_HALF:
    case WEFT_TILE_FLOAT:
        break;
    }
    return (double)((const float *)tile->data)[i];
}

static double mix(double a, double b, const struct lookup *axis, bool eight_bit)
{
    if (!eight_bit)
        return a + axis->share * (b - a);
    return a + ((((int)b - (int)a) * axis->share_256 + 128) >> 8);
}

// Interpolates along axis 0 first, as the recursion ends there.
static double filter(const struct survey *s, const struct weft_kernel_tile *tile,
                     const struct lookup *const axis[3], int dims, int at[3], bool eight_bit)
{
    if (dims == 0)
        return load(s, tile, at);
    const struct lookup *l = axis[dims - 1];
    at[dims - 1] = l->texel[0];
    const double a = filter(s, tile, axis, dims - 1, at, eight_bit);
    if (l->texel[0] == l->texel[1])
        return a;
    at[dims - 1] = l->texel[1];
    return mix(a, filter(s, tile, axis, dims - 1, at, eight_bit), l, eight_bit);
}

static void position(const struct survey *s, size_t n, int at[3])
{
    const size_t l = (size_t)s->p.locations;
    at[0] = (int)(n % l);
    at[1] = (int)(n / l % l);
    at[2] = (int)(n / l / l);
}

static void add_modelled(struct survey *s, const struct weft_kernel_tile *tile, enum way way)
{
    const double unit = (tile->negated ? -1.0 : 1.0) / (s->info->one * tile->scale);
    for (size_t n = 0; n < s->positions; n++) {
        const struct lookup *axis[3];
        int i[3], at[3] = {0};
        position(s, n, i);
        for (int a = 0; a < s->info->dims; a++)
            axis[a] = &s->lookups[way][tile->mirrored[a]][i[a]];
        s->weight[way][n] += unit * filter(s, tile, axis, s->info->dims, at, way == EIGHT_BIT);
    }
}

// ---- what GL looks up ---------------------------------------------------------------------------

struct target {
    weft_context *context;
    const GladGLContext *gl;
    struct weft_gl_target positions; // a texel each
    GLuint program;
    float *pixels;
};

static enum weft_result create_target(const struct survey *s, struct target *t)
{
    const int width = s->p.locations, height = (int)(s->positions / (size_t)width);
    const int limit = weft_context_get_info(t->context)->max_target_size;
    if (height > limit) {
        weft_error(s->p.log, "tile error: %d rows of positions, over the target's %d", height,
                   limit);
        return WEFT_ERR_LIMIT;
    }
    t->pixels = malloc(s->positions * sizeof *t->pixels);
    if (!t->pixels) {
        weft_error(s->p.log, "tile error: not enough memory for %zu pixels", s->positions);
        return WEFT_ERR_MEMORY;
    }
    char defines[32];
    snprintf(defines, sizeof defines, "#define DIMS %d\n", s->info->dims);
    enum weft_result res = weft_program_get(t->context, "tile lookup", defines,
                                            weft_shader_full_target, lookup_shader, &t->program);
    if (res != WEFT_OK)
        return res;
    return weft_gl_target_create(s->p.log, t->gl, GL_R32F, width, height, &t->positions);
}

static void destroy_target(struct target *t)
{
    weft_gl_target_destroy(t->gl, &t->positions);
    free(t->pixels);
}

static enum weft_result draw(const struct survey *s, const struct target *t,
                             const struct weft_kernel_tile *tile,
                             const struct weft_tile_texture *texture)
{
    const GladGLContext *gl = t->gl;
    gl->UseProgram(t->program);
    weft_gl_bind_texture(gl, t->program, 0, "tile", texture->target, texture->texture);
    gl->Uniform1i(weft_gl_location(gl, t->program, "locations"), s->p.locations);
    gl->Uniform2f(weft_gl_location(gl, t->program, "placement"), (float)s->gain, (float)s->bias);
    gl->Uniform3i(weft_gl_location(gl, t->program, "mirrored"), tile->mirrored[0],
                  tile->mirrored[1], tile->mirrored[2]);
    const struct weft_gl_pixels out = {
        .width = t->positions.width,
        .height = t->positions.height,
        .type = GL_FLOAT,
        .data = t->pixels,
    };
    weft_gl_target_bind(gl, &t->positions, out.width, out.height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    return weft_gl_target_read(s->p.log, gl, &t->positions, &out);
}

static enum weft_result add_measured(struct survey *s, const struct target *t, int index)
{
    const struct weft_kernel_tile *tile = weft_kernel_tiles_get(s->p.tiles, index);
    struct weft_tile_texture texture;
    enum weft_result res =
        weft_tile_texture_create(s->p.log, t->gl, s->p.tiles, index, s->p.lookup, 0, &texture);
    if (res != WEFT_OK)
        return res;
    res = draw(s, t, tile, &texture);
    for (size_t n = 0; res == WEFT_OK && n < s->positions; n++)
        s->weight[MEASURED][n] += texture.factor * (double)t->pixels[n];
    weft_tile_texture_destroy(t->gl, &texture);
    return res;
}

// ---- errors -------------------------------------------------------------------------------------

// Takes the weights of one tap in, and clears them.
static void close_tap(struct survey *s, const int tap[3])
{
    for (size_t n = 0; n < s->positions; n++) {
        int at[3];
        double exact = 1.0;
        position(s, n, at);
        for (int a = 0; a < s->info->dims; a++)
            exact *= s->exact[s->info->derivative.along[a]][tap[a]][at[a]];
        for (int w = 0; w < WAYS; w++) {
            const double e = s->weight[w][n] - exact;
            s->magnitude[w][n] += fabs(e);
            s->sum[w][n] += e;
            s->single[w] = fmax(s->single[w], fabs(e));
            s->difference[w] =
                fmax(s->difference[w], fabs(s->weight[MEASURED][n] - s->weight[w][n]));
        }
        for (int w = 0; w < WAYS; w++)
            s->weight[w][n] = 0.0;
    }
}

static enum weft_result survey_tap(struct survey *s, const struct target *t, const int tap[3])
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < s->info->tile_count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(s->p.tiles, i);
        if (memcmp(tile->tap, tap, sizeof tile->tap) != 0)
            continue;
        add_modelled(s, tile, IDEAL);
        if (models_differ(s))
            add_modelled(s, tile, EIGHT_BIT);
        if (t)
            res = add_measured(s, t, i);
    }
    close_tap(s, tap);
    return res;
}

static enum weft_result survey_taps(struct survey *s, const struct target *t)
{
    const int w = s->info->width, dims = s->info->dims;
    enum weft_result res = WEFT_OK;
    for (int z = 0; z < (dims > 2 ? w : 1); z++)
        for (int y = 0; y < (dims > 1 ? w : 1); y++)
            for (int x = 0; res == WEFT_OK && x < w; x++)
                res = survey_tap(s, t, (int[3]){x, y, z});
    return res;
}

static struct weft_tile_error_figures figures(const struct survey *s, enum way w)
{
    struct weft_tile_error_figures f = {
        .single = s->single[w], .signed_min = INFINITY, .signed_max = -INFINITY};
    for (size_t n = 0; n < s->positions; n++) {
        f.maximum = fmax(f.maximum, s->magnitude[w][n]);
        f.mean += s->magnitude[w][n] / (double)s->positions;
        f.signed_min = fmin(f.signed_min, s->sum[w][n]);
        f.signed_max = fmax(f.signed_max, s->sum[w][n]);
    }
    return f;
}

// Whether (i + 1/2) / L, from tile positions to texels, is an integer, or half way between 256ths
// of a texel where those count; in integers. Coordinates without rounding go one way for certain.
static int count_borders(const struct survey *s)
{
    const int64_t l = s->p.locations, m = s->info->samples;
    const bool nearest = s->p.lookup == WEFT_ERROR_NEAREST;
    const bool ends = s->info->placement == WEFT_TILE_ENDS, exact = !ends && (l & (l - 1)) == 0;
    int count = 0;
    for (int64_t i = 0; (nearest || (models_differ(s) && !exact)) && i < l; i++) {
        const int64_t at = ends ? (2 * i + 1) * (m - 1) + l : (2 * i + 1) * m;
        count += nearest ? at % (2 * l) == 0 : at * 512 % (4 * l) == 2 * l;
    }
    return count;
}

static void report(const struct survey *s, bool measured, struct weft_tile_error *out)
{
    const struct weft_tile_error_figures none = {NAN, NAN, NAN, NAN, NAN};
    *out = (struct weft_tile_error){
        .measured = measured ? figures(s, MEASURED) : none,
        .ideal = figures(s, IDEAL),
        .eight_bit = figures(s, EIGHT_BIT),
        .difference_ideal = measured ? s->difference[IDEAL] : (double)NAN,
        .difference_eight_bit = measured ? s->difference[EIGHT_BIT] : (double)NAN,
        .borders = count_borders(s),
    };
}

static void tear_down(struct survey *s)
{
    free(s->storage);
    free(s->lookups[IDEAL][0]);
}

enum weft_result weft_tile_error_model(const struct weft_tile_error_params *params,
                                       struct weft_tile_error *out)
{
    struct survey s;
    *out = (struct weft_tile_error){.borders = 0};
    enum weft_result res = set_up(params, &s);
    if (res == WEFT_OK)
        res = survey_taps(&s, NULL);
    if (res == WEFT_OK)
        report(&s, false, out);
    tear_down(&s);
    return res;
}

enum weft_result weft_tile_error_measure(weft_context *context,
                                         const struct weft_tile_error_params *params,
                                         struct weft_tile_error *out)
{
    struct survey s;
    struct target t = {.context = context, .gl = &context->gl};
    *out = (struct weft_tile_error){.borders = 0};
    enum weft_result res = set_up(params, &s);
    if (res != WEFT_OK)
        goto fail;
    res = weft_context_enter(context);
    if (res != WEFT_OK)
        goto fail;
    res = create_target(&s, &t);
    if (res == WEFT_OK)
        res = survey_taps(&s, &t);
    destroy_target(&t);
    weft_context_leave(context);
    if (res == WEFT_OK)
        report(&s, true, out);
fail:
    tear_down(&s);
    return res;
}
