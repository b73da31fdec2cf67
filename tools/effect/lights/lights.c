// SPDX-License-Identifier: BSD-3-Clause
// Path i (from 0) comes to bounce j once there are (i + 1) / rho^j paths: floor(N rho^j) of N paths
// do. Sorted by that number, the virtual lights of ever more paths stand in one list, of which the
// first ones, however many, are those of fewer paths.
#include "tools/effect/lights/lights.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/effect/lights/select.h"
#include "tools/effect/lights/walk.h"

// A path that was walked so far.
struct path {
    struct walk_particle particle;
    double power; // rho^j of its next bounce
    bool ended;
};

// Lights of paths that `count` lights are chosen from: so many for each, while there are fewer than
// MAX_GATHERED of them, and while rays are tested against fewer than MAX_TESTS triangles (about 15
// ns each).
enum { GATHERED_PER_LIGHT = 16, MAX_GATHERED = 1 << 21, MAX_TESTS = 1 << 29 };

// The least part of the lights, by its power, that what emits gets.
static const double LEAST_SOURCE = 0.125;

struct gathered {
    struct walk walk;
    double rho;
    struct path *paths;
    struct virtual_light *lights;
    int64_t path_count, path_room, count, room;
};

// ---- all virtual lights of up to N paths --------------------------------------------------------

// Returns the list with room for one more of `size` bytes; NULL: there is no memory.
static void *make_room(void *list, int64_t count, int64_t *room, size_t size)
{
    if (count < *room)
        return list;
    const int64_t wanted = *room > 0 ? 2 * *room : 256;
    void *larger = realloc(list, (size_t)wanted * size);
    if (larger)
        *room = wanted;
    return larger;
}

static enum weft_result add_light(struct gathered *all, const struct walk_particle *particle,
                                  double paths)
{
    if (all->count == MAX_GATHERED)
        return WEFT_ERR_LIMIT;
    struct virtual_light *lights = make_room(all->lights, all->count, &all->room, sizeof *lights);
    if (!lights)
        return WEFT_ERR_MEMORY;
    all->lights = lights;
    struct virtual_light *added = &all->lights[all->count++];
    *added = (struct virtual_light){.paths = paths, .bounce = particle->bounce};
    added->light.falloff = SCENE_FALLOFF_RADIANCE;
    added->light.shadowed = true;
    for (int i = 0; i < 3; i++) {
        added->light.position[i] = particle->position[i];
        added->light.normal[i] = particle->normal[i];
        added->light.intensity[i] = particle->intensity[i];
    }
    return WEFT_OK;
}

// Sends a path on to all bounces that it comes to with so many paths.
static enum weft_result go_on(struct gathered *all, int64_t at, double most)
{
    struct path *path = &all->paths[at];
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && !path->ended && (double)(at + 1) / path->power <= most) {
        const double paths = (double)(at + 1) / path->power;
        path->ended = !walk_on(&all->walk, &path->particle);
        path->power *= all->rho;
        if (!path->ended)
            res = add_light(all, &path->particle, paths);
    }
    return res;
}

// Afterwards all virtual lights of up to so many paths are there, in no order.
static enum weft_result gather(struct gathered *all, double most)
{
    enum weft_result res = WEFT_OK;
    for (int64_t i = 0; i < all->path_count && res == WEFT_OK; i++)
        res = go_on(all, i, most);
    while ((double)(all->path_count + 1) <= most && res == WEFT_OK) {
        struct path *paths = make_room(all->paths, all->path_count, &all->path_room, sizeof *paths);
        if (!paths)
            return WEFT_ERR_MEMORY;
        all->paths = paths;
        const int64_t at = all->path_count++;
        struct path *path = &all->paths[at];
        *path = (struct path){.power = all->rho, .ended = all->rho == 0.0};
        walk_start(&all->walk, (uint64_t)at, &path->particle);
        res = add_light(all, &path->particle, (double)(at + 1));
        if (res == WEFT_OK)
            res = go_on(all, at, most);
    }
    return res;
}

static int compare(const void *a, const void *b)
{
    const struct virtual_light *first = a, *second = b;
    if (first->paths != second->paths)
        return first->paths < second->paths ? -1 : 1;
    return first->bounce - second->bounce;
}

// ---- all of N paths -----------------------------------------------------------------------------

// Paths that come to a bounce where `last` is the last light: those that ended before count, too.
static int64_t count_paths(double power, int bounce, const struct virtual_light *last)
{
    int64_t count = (int64_t)(last->paths * power) + 1;
    while (count > 0 &&
           compare(&(struct virtual_light){.paths = (double)count / power, .bounce = bounce},
                   last) > 0)
        count--;
    return count;
}

// Makes the sum of all lights the picture: each bounce is the mean over its paths. `most` is N.
static enum weft_result share_out(struct gathered *all, double most,
                                  struct effect_virtual_lights *out)
{
    const struct virtual_light last = {.paths = most, .bounce = INT32_MAX};
    for (int64_t i = 0; i < all->count; i++)
        out->bounces = out->bounces < all->lights[i].bounce ? all->lights[i].bounce : out->bounces;
    int64_t *paths = calloc((size_t)out->bounces + 1, sizeof *paths);
    if (!paths)
        return WEFT_ERR_MEMORY;
    double power = 1.0;
    for (int bounce = 0; bounce <= out->bounces; bounce++, power *= all->rho)
        paths[bounce] = count_paths(power, bounce, &last);
    for (int64_t i = 0; i < all->count; i++)
        for (int k = 0; k < 3; k++)
            all->lights[i].light.intensity[k] /= (double)paths[all->lights[i].bounce];
    out->paths = paths[0];
    free(paths);
    return WEFT_OK;
}

static enum weft_result make_of_paths(struct gathered *all, const struct effect_lights_params *p,
                                      struct effect_virtual_lights *out)
{
    // Powers of rho are rounded: what comes to a whole number of paths is not to be left out.
    const double most = (double)p->count * (1.0 + 1e-9);
    enum weft_result res = gather(all, most);
    if (res == WEFT_OK && all->count > EFFECT_MAX_LIGHTS)
        res = WEFT_ERR_LIMIT;
    if (res == WEFT_OK)
        res = share_out(all, most, out);
    if (res != WEFT_OK)
        return res;
    out->count = all->count;
    out->light = calloc((size_t)out->count, sizeof *out->light);
    if (!out->light)
        return WEFT_ERR_MEMORY;
    qsort(all->lights, (size_t)all->count, sizeof *all->lights, compare);
    for (int64_t i = 0; i < out->count; i++) {
        out->light[i] = all->lights[i].light;
        for (int k = 0; k < 3; k++)
            out->light[i].intensity[k] *= (double)out->count;
    }
    return WEFT_OK;
}

// ---- as many as were asked for ------------------------------------------------------------------

static int64_t count_candidates(const struct gathered *all, int64_t count)
{
    const double tests = (double)count * ((double)all->walk.triangles.count + 1.0);
    double each = fmin(GATHERED_PER_LIGHT, floor(MAX_TESTS / tests));
    each = fmin(each, floor((double)MAX_GATHERED / 2.0 / (double)count));
    return (int64_t)fmax(each, 1.0) * count;
}

// Lights are chosen by what they give, mean of R, G and B. For the same error per light, what comes
// from a small area needs fewer lights, as those stand closer: by the square root of the areas.
static void weigh(struct gathered *all)
{
    const double area = walk_area(&all->walk.triangles);
    const double share = area > 0.0 ? sqrt(all->walk.source_area / area) : 1.0;
    for (int64_t i = 0; i < all->count; i++) {
        struct virtual_light *light = &all->lights[i];
        const double *rgb = light->light.intensity;
        light->weight = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        if (light->bounce == 0)
            light->weight *= fmin(fmax(share, LEAST_SOURCE), 1.0);
    }
}

static enum weft_result make_count(struct gathered *all, const struct effect_lights_params *p,
                                   struct effect_virtual_lights *out)
{
    enum weft_result res = WEFT_OK;
    const int64_t wanted = count_candidates(all, p->count);
    double paths = floor((double)wanted * (1.0 - all->rho)) + 1.0;
    for (; res == WEFT_OK && all->count < wanted; paths = floor(paths * 1.125) + 1.0)
        res = gather(all, paths);
    if (res == WEFT_OK)
        res = share_out(all, (double)all->path_count, out);
    if (res != WEFT_OK)
        return res;
    out->count = p->count;
    out->light = calloc((size_t)out->count, sizeof *out->light);
    if (!out->light)
        return WEFT_ERR_MEMORY;
    weigh(all);
    select_find_places(all->lights, all->count);
    select_lights(all->lights, all->count, walk_offset(&all->walk), p->count, out->light);
    return WEFT_OK;
}

// ---- the whole ----------------------------------------------------------------------------------

static bool check(const struct effect_lights_params *p)
{
    if (p->count < 1 || p->count > EFFECT_MAX_LIGHTS) {
        log_error(p->log, "radiosity: %lld %s: it must be 1 to %d", (long long)p->count,
                  p->paths ? "paths" : "virtual lights", EFFECT_MAX_LIGHTS);
        return false;
    }
    if (!(isnan(p->clamp) || (p->clamp >= 0.0 && isfinite(p->clamp)))) {
        log_error(p->log, "radiosity: the clamp is %g: it must be 0 or more", p->clamp);
        return false;
    }
    return true;
}

static void clamp(const struct gathered *all, double asked, struct effect_virtual_lights *out)
{
    const double area = walk_area(&all->walk.triangles);
    const double patch = area > 0.0 ? M_PI * (double)out->count / (4.0 * area) : 0.0;
    out->mean_reflectance = all->rho;
    out->most = isnan(asked) ? patch : asked;
    for (int64_t i = 0; i < out->count; i++)
        out->light[i].most = out->most;
}

static void complain(const struct effect_lights_params *p, enum weft_result res, double rho)
{
    if (res == WEFT_ERR_MEMORY)
        log_error(p->log, "radiosity: no memory for %lld %s", (long long)p->count,
                  p->paths ? "paths" : "virtual lights");
    if (res == WEFT_ERR_LIMIT)
        log_error(p->log,
                  "radiosity: %lld paths, at a mean reflectance of %g, make more than %d virtual "
                  "lights",
                  (long long)p->count, rho, EFFECT_MAX_LIGHTS);
}

enum weft_result effect_lights_make(const struct effect_lights_params *params,
                                    struct effect_virtual_lights *out)
{
    struct gathered all = {0};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct effect_virtual_lights){0};
    if (!check(params))
        goto fail;
    res = walk_make(params->log, params->scene, params->time, params->seed, &all.walk);
    if (res != WEFT_OK)
        goto fail;
    all.rho = walk_mean_reflectance(&all.walk.triangles);
    if (!(all.rho < 1.0)) {
        log_error(params->log, "radiosity: everything reflects all light: no path ends");
        res = WEFT_ERR_ARGUMENT;
        goto fail;
    }
    res = params->paths ? make_of_paths(&all, params, out) : make_count(&all, params, out);
    if (res == WEFT_OK)
        clamp(&all, params->clamp, out);
fail:
    complain(params, res, all.rho);
    free(all.paths);
    free(all.lights);
    walk_clear(&all.walk);
    if (res != WEFT_OK)
        effect_lights_clear(out);
    return res;
}

void effect_lights_clear(struct effect_virtual_lights *lights)
{
    if (!lights)
        return;
    free(lights->light);
    *lights = (struct effect_virtual_lights){0};
}
