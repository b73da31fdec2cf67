// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/lights/walk.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/common/random.h"
#include "tools/render/lamps.h"
#include "tools/scene/vector.h"

// ---- numbers ------------------------------------------------------------------------------------

static const uint8_t PRIMES[] = {2,  3,  5,  7,   11,  13,  17,  19,  23,  29, 31,
                                 37, 41, 43, 47,  53,  59,  61,  67,  71,  73, 79,
                                 83, 89, 97, 101, 103, 107, 109, 113, 127, 131};
enum { PRIME_COUNT = sizeof PRIMES / sizeof PRIMES[0] };

// A coordinate of the sequence's point. Few paths come to where bases are above 131, fewer than a
// base has digits: they would lie on lines, so that they take random numbers instead.
static double find_number(const struct walk *walk, uint64_t index, int dimension)
{
    if (dimension >= PRIME_COUNT)
        return random_unit_at(walk->seed + (uint64_t)dimension * UINT64_C(0xd1342543de82ef95),
                              index);
    const double shift = walk->seed ? random_unit_at(walk->seed, (uint64_t)dimension) : 0.0;
    const double sum = weft_jitter_radical_inverse(PRIMES[dimension], index + 1) + shift;
    return sum < 1.0 ? sum : sum - 1.0;
}

double walk_offset(const struct walk *walk)
{
    return walk->seed ? random_unit_at(walk->seed, PRIME_COUNT) : 0.5;
}

// ---- what emits ---------------------------------------------------------------------------------

// A triangle that emits, or a lamp that is not seen.
struct walk_source {
    size_t triangle; // SIZE_MAX: the lamp
    const struct scene_light *lamp;
    double intensity[3]; // radiance * area; of points as they are
    double power;        // in units of pi, mean of R, G and B
    double end;          // of all power, what it and those before it have
};

// Appends what has power.
static void add_source(struct walk *walk, size_t triangle, const struct scene_light *lamp,
                       const double radiance[3], double area)
{
    struct walk_source source = {.triangle = triangle, .lamp = lamp};
    const bool point = lamp && lamp->shape == SCENE_LIGHT_POINT;
    for (int i = 0; i < 3; i++) {
        source.intensity[i] = radiance[i] * area;
        source.power += source.intensity[i] / 3.0 * (point ? 4.0 : 1.0);
    }
    if (!(source.power > 0.0))
        return;
    walk->sources[walk->source_count++] = source;
    walk->source_area += point ? 0.0 : area;
}

static enum weft_result gather(const struct weft_log *log, const struct scene *scene,
                               struct walk *walk)
{
    for (size_t t = 0; t < walk->triangles.count; t++) {
        const struct scene_triangle *triangle = &walk->triangles.list[t];
        const float *emission = scene->materials[triangle->material].emission;
        add_source(walk, t, NULL, (const double[3]){emission[0], emission[1], emission[2]},
                   triangle->area);
    }
    for (int l = 0; l < scene->light_count; l++) {
        const struct scene_light *lamp = &scene->lights[l];
        if (lamp->falloff != SCENE_FALLOFF_RADIANCE) {
            log_error(log, "radiosity: lamp %d of the scene does not fall off with distance",
                      l + 1);
            return WEFT_ERR_ARGUMENT;
        }
        if (!lamp->seen)
            add_source(walk, SIZE_MAX, lamp, lamp->radiance,
                       lamp->shape == SCENE_LIGHT_POINT ? 1.0 : scene_lamp_area(lamp));
    }
    if (walk->source_count == 0) {
        log_error(log,
                  "radiosity: nothing emits: the scene has no lamp and no material with emission");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result walk_make(const struct weft_log *log, const struct scene *scene, double time,
                           uint64_t seed, struct walk *out)
{
    *out = (struct walk){.seed = seed};
    enum weft_result res = scene_triangles_make(scene, time, &out->triangles);
    if (res != WEFT_OK)
        goto fail;
    res = WEFT_ERR_MEMORY;
    out->sources = calloc(out->triangles.count + SCENE_MAX_LIGHTS, sizeof *out->sources);
    if (!out->sources)
        goto fail;
    res = gather(log, scene, out);
    if (res != WEFT_OK)
        goto fail;
    double sum = 0.0;
    for (int s = 0; s < out->source_count; s++)
        out->sources[s].end = sum += out->sources[s].power;
    return WEFT_OK;
fail:
    walk_clear(out);
    return res;
}

void walk_clear(struct walk *walk)
{
    if (!walk)
        return;
    scene_triangles_clear(&walk->triangles);
    free(walk->sources);
    *walk = (struct walk){0};
}

// ---- the way ------------------------------------------------------------------------------------

// The source whose share of the power has `number` in it; that becomes its place within the share,
// in [0, 1): one coordinate does for the choice and for a place.
static const struct walk_source *choose_source(const struct walk *walk, double *number)
{
    const double at = *number * walk->sources[walk->source_count - 1].end;
    int low = 0, high = walk->source_count - 1;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (at < walk->sources[middle].end)
            high = middle;
        else
            low = middle + 1;
    }
    const struct walk_source *source = &walk->sources[low];
    const double from = low > 0 ? walk->sources[low - 1].end : 0.0;
    *number = fmin(fmax((at - from) / (source->end - from), 0.0), 0x1.fffffffffffffp-1);
    return source;
}

// Of triangles: areas go to areas alike (Turk, Graphics Gems, 1990).
static void start_on_triangle(const struct walk *walk, size_t at, double u, double v,
                              struct walk_particle *out)
{
    const struct scene_triangle *triangle = &walk->triangles.list[at];
    const double root = sqrt(u);
    scene_triangle_point(triangle, (const double[3]){1.0 - root, root * (1.0 - v), root * v},
                         out->position);
    for (int i = 0; i < 3; i++)
        out->normal[i] = triangle->normal[i];
}

static void start_on_lamp(const struct scene_light *lamp, double u, double v,
                          struct walk_particle *out)
{
    double place[2] = {u - 0.5, v - 0.5};
    if (lamp->shape == SCENE_LIGHT_DISC) {
        place[0] = sqrt(u) / 2.0 * cos(2.0 * M_PI * v);
        place[1] = sqrt(u) / 2.0 * sin(2.0 * M_PI * v);
    }
    struct scene_point_light light;
    scene_lamp_at(lamp, place, &light);
    for (int i = 0; i < 3; i++) {
        out->position[i] = light.position[i];
        out->normal[i] = light.normal[i];
    }
}

void walk_start(const struct walk *walk, uint64_t index, struct walk_particle *out)
{
    double u = find_number(walk, index, 0);
    const double v = find_number(walk, index, 1);
    const struct walk_source *source = choose_source(walk, &u);
    *out = (struct walk_particle){.index = index, .triangle = source->triangle};
    if (source->lamp)
        start_on_lamp(source->lamp, u, v, out);
    else
        start_on_triangle(walk, source->triangle, u, v, out);
    const double share = source->power / walk->sources[walk->source_count - 1].end;
    for (int i = 0; i < 3; i++)
        out->intensity[i] = source->intensity[i] / share;
}

// A direction to all sides alike, or as the cosine with the normal: theta = asin sqrt(u), phi = 2
// pi v (Keller 1997).
static void find_direction(const double normal[3], bool point, double u, double v, double out[3])
{
    const double height = point ? 1.0 - 2.0 * u : sqrt(1.0 - u);
    const double across = point ? sqrt(fmax(1.0 - height * height, 0.0)) : sqrt(u);
    const double x = across * cos(2.0 * M_PI * v), y = across * sin(2.0 * M_PI * v);
    const double z[3] = {point ? 0.0 : normal[0], point ? 0.0 : normal[1], point ? 1.0 : normal[2]};
    double a[3] = {0.0, 0.0, 0.0}, b[3];
    a[fabs(z[0]) < 0.6 ? 0 : 1] = 1.0;
    scene_cross(z, a, b);
    scene_normalise(b);
    scene_cross(b, z, a);
    for (int i = 0; i < 3; i++)
        out[i] = x * a[i] + y * b[i] + height * z[i];
}

bool walk_on(const struct walk *walk, struct walk_particle *particle)
{
    const double *n = particle->normal;
    const bool point = n[0] == 0.0 && n[1] == 0.0 && n[2] == 0.0;
    const int dimension = 2 + 2 * particle->bounce;
    double direction[3], reflectance[3];
    find_direction(n, point, find_number(walk, particle->index, dimension),
                   find_number(walk, particle->index, dimension + 1), direction);
    struct scene_hit hit;
    if (!scene_triangles_hit(&walk->triangles, particle->position, direction, particle->triangle,
                             INFINITY, &hit))
        return false;
    const struct scene_triangle *triangle = &walk->triangles.list[hit.triangle];
    scene_triangle_reflectance(&walk->triangles, hit.triangle, hit.weight, reflectance);
    scene_triangle_point(triangle, hit.weight, particle->position);
    double left = 0.0;
    for (int i = 0; i < 3; i++) {
        // The power, pi times the intensity or 4 pi times a point's, leaves again as the cosine.
        particle->intensity[i] *= reflectance[i] * (point ? 4.0 : 1.0);
        left += particle->intensity[i];
        particle->normal[i] = hit.back ? -triangle->normal[i] : triangle->normal[i];
    }
    particle->triangle = hit.triangle;
    particle->bounce++;
    return left > 0.0;
}

// ---- of all triangles ---------------------------------------------------------------------------

double walk_area(const struct scene_triangles *triangles)
{
    double sum = 0.0;
    for (size_t t = 0; t < triangles->count; t++)
        sum += triangles->list[t].area;
    return sum;
}

// Colours are linear over a triangle, so that their mean is that of the corners; a pattern's is
// that of one square of each kind.
static double find_mean(const struct scene_triangles *triangles,
                        const struct scene_triangle *triangle)
{
    const struct scene *scene = triangles->scene;
    const struct scene_material *material = &scene->materials[triangle->material];
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            sum += material->reflectance[i] * scene->vertices[triangle->vertex[k]].colour[i] / 9.0;
    const double kept = material->pattern == SCENE_CHECKER ? (1.0 + 0.25) / 2.0 : 1.0;
    return material->unlit ? 0.0 : fmin(fmax(sum * kept, 0.0), 1.0);
}

double walk_mean_reflectance(const struct scene_triangles *triangles)
{
    double sum = 0.0;
    for (size_t t = 0; t < triangles->count; t++)
        sum += find_mean(triangles, &triangles->list[t]) * triangles->list[t].area;
    return triangles->count > 0 ? sum / walk_area(triangles) : 0.0;
}
