// SPDX-License-Identifier: BSD-3-Clause
// Path i (from 0) comes to bounce j once there are (i + 1) / rho^j paths: floor(N rho^j) of N paths
// do. Sorted by that number, the virtual lights of ever more paths stand in one list, of which any
// first M are those of some N, which need not be an integer: so M can be asked for.
#include "tools/effect/lights.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/effect/walk.h"

// A virtual light, and with how many paths it appears.
struct image {
    double paths;
    int bounce; // of two with the same number, the earlier bounce is first
    struct scene_point_light light;
};

// A path that was walked so far.
struct path {
    struct walk_particle particle;
    double power; // rho^j of its next bounce
    bool ended;
};

struct gathered {
    struct walk walk;
    double rho;
    struct path *paths;
    struct image *images;
    int64_t path_count, path_room, count, room;
};

// ---- all virtual lights of up to N paths --------------------------------------------------------

// Room for one more of `size` bytes.
static bool make_room(void **list, int64_t count, int64_t *room, size_t size)
{
    if (count < *room)
        return true;
    const int64_t wanted = *room > 0 ? 2 * *room : 256;
    void *larger = realloc(*list, (size_t)wanted * size);
    if (!larger)
        return false;
    *list = larger;
    *room = wanted;
    return true;
}

static enum weft_result add_image(struct gathered *all, const struct walk_particle *particle,
                                  double paths)
{
    if (all->count == 2 * (int64_t)EFFECT_MAX_LIGHTS)
        return WEFT_ERR_LIMIT;
    if (!make_room((void **)&all->images, all->count, &all->room, sizeof *all->images))
        return WEFT_ERR_MEMORY;
    struct image *image = &all->images[all->count++];
    *image = (struct image){.paths = paths, .bounce = particle->bounce};
    image->light.falloff = SCENE_FALLOFF_RADIANCE;
    image->light.shadowed = true;
    for (int i = 0; i < 3; i++) {
        image->light.position[i] = particle->position[i];
        image->light.normal[i] = particle->normal[i];
        image->light.intensity[i] = particle->intensity[i];
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
            res = add_image(all, &path->particle, paths);
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
        if (!make_room((void **)&all->paths, all->path_count, &all->path_room, sizeof *all->paths))
            return WEFT_ERR_MEMORY;
        const int64_t at = all->path_count++;
        struct path *path = &all->paths[at];
        *path = (struct path){.power = all->rho, .ended = all->rho == 0.0};
        walk_start(&all->walk, (uint64_t)at, &path->particle);
        res = add_image(all, &path->particle, (double)(at + 1));
        if (res == WEFT_OK)
            res = go_on(all, at, most);
    }
    return res;
}

static int compare(const void *a, const void *b)
{
    const struct image *first = a, *second = b;
    if (first->paths != second->paths)
        return first->paths < second->paths ? -1 : 1;
    return first->bounce - second->bounce;
}

// ---- as many as were asked for ------------------------------------------------------------------

// Paths that come to a bounce where `last` is the last light: those that ended before count, too.
static int64_t count_paths(double power, int bounce, const struct image *last)
{
    int64_t count = (int64_t)(last->paths * power) + 1;
    while (count > 0 &&
           compare(&(struct image){.paths = (double)count / power, .bounce = bounce}, last) > 0)
        count--;
    return count;
}

// Each bounce is the mean over its paths, the picture the mean over all lights.
static enum weft_result fill(const struct gathered *all, const struct image *last, int64_t count,
                             double clamp, struct effect_virtual_lights *out)
{
    out->light = calloc((size_t)count, sizeof *out->light);
    int64_t *paths = NULL;
    for (int64_t i = 0; i < count; i++)
        out->bounces = all->images[i].bounce > out->bounces ? all->images[i].bounce : out->bounces;
    paths = calloc((size_t)out->bounces + 1, sizeof *paths);
    if (!out->light || !paths) {
        free(paths);
        return WEFT_ERR_MEMORY;
    }
    double power = 1.0;
    for (int bounce = 0; bounce <= out->bounces; bounce++, power *= all->rho)
        paths[bounce] = count_paths(power, bounce, last);
    out->count = count;
    out->paths = paths[0];
    out->mean_reflectance = all->rho;
    const double area = walk_area(&all->walk.triangles);
    out->most = isnan(clamp) ? (area > 0.0 ? M_PI * (double)count / area : 0.0) : clamp;
    for (int64_t i = 0; i < count; i++) {
        out->light[i] = all->images[i].light;
        out->light[i].most = out->most;
        for (int k = 0; k < 3; k++)
            out->light[i].intensity[k] *= (double)count / (double)paths[all->images[i].bounce];
    }
    free(paths);
    return WEFT_OK;
}

static enum weft_result make_of_paths(struct gathered *all, const struct effect_lights_params *p,
                                      struct effect_virtual_lights *out)
{
    // Powers of rho are rounded: what comes to a whole number of paths is not to be left out.
    const struct image last = {.paths = (double)p->count * (1.0 + 1e-9), .bounce = INT32_MAX};
    enum weft_result res = gather(all, last.paths);
    if (res == WEFT_OK && all->count > EFFECT_MAX_LIGHTS)
        res = WEFT_ERR_LIMIT;
    if (res != WEFT_OK)
        return res;
    qsort(all->images, (size_t)all->count, sizeof *all->images, compare);
    return fill(all, &last, all->count, p->clamp, out);
}

static enum weft_result make_count(struct gathered *all, const struct effect_lights_params *p,
                                   struct effect_virtual_lights *out)
{
    enum weft_result res = WEFT_OK;
    for (double paths = (double)p->count * (1.0 - all->rho) + 1.0;
         all->count < p->count && res == WEFT_OK; paths *= 1.0625)
        res = gather(all, paths);
    if (res != WEFT_OK)
        return res;
    qsort(all->images, (size_t)all->count, sizeof *all->images, compare);
    return fill(all, &all->images[p->count - 1], p->count, p->clamp, out);
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
fail:
    complain(params, res, all.rho);
    free(all.paths);
    free(all.images);
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
