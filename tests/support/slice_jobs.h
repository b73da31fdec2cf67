// SPDX-License-Identifier: BSD-3-Clause
// tests/support/slice_jobs.h - random slices of random volumes, seeded, for tests and benches of
// methods. A job that cannot be made ends the program.
#ifndef WEFT_TESTS_SUPPORT_SLICE_JOBS_H
#define WEFT_TESTS_SUPPORT_SLICE_JOBS_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"
#include "weft.h"

enum { SIDE = 40, VOXELS = SIDE * SIDE * SIDE };

struct random {
    uint64_t state;
};

static inline double uniform(struct random *r) // splitmix64, in [0, 1)
{
    uint64_t h = r->state += UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((h ^ h >> 31) >> 11) * 0x1p-53;
}

static inline int below(struct random *r, int n)
{
    return (int)(uniform(r) * n);
}

static inline void job_must(bool condition, const char *what)
{
    if (condition)
        return;
    fprintf(stderr, "a random job has no %s\n", what);
    exit(1);
}

// Smooth in one half, noise in a corner, constant in the rest; somewhere in the reals.
static inline weft_volume *random_volume(struct random *r)
{
    float *data = malloc(VOXELS * sizeof *data);
    job_must(data, "memory");
    const double scale = ldexp(1.0, below(r, 21) - 10), offset = scale * 4.0 * (uniform(r) - 0.5);
    for (int i = 0; i < VOXELS; i++) {
        const int x = i % SIDE, y = i / SIDE % SIDE, z = i / (SIDE * SIDE);
        double value = 0.25;
        if (x < SIDE / 2)
            value = 0.5 + 0.2 * sin(0.11 * x + 0.07 * y) + 0.2 * cos(0.09 * z - 0.05 * x);
        else if (y < SIDE / 2 && z < SIDE / 2)
            value = uniform(r);
        data[i] = (float)(offset + scale * value);
    }
    weft_volume *volume = NULL;
    const struct weft_volume_params *params =
        weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data,
                           .background = uniform(r) < 0.5 ? NAN : (float)offset);
    job_must(weft_volume_create(params, &volume) == WEFT_OK, "volume");
    free(data);
    return volume;
}

// Oblique, turned about an axis, or along the axes; on the lattice at times.
static inline struct weft_slice_geometry random_plane(struct random *r)
{
    struct weft_slice_geometry g = {.width = 8 + below(r, 90), .height = 8 + below(r, 70)};
    const int kind = below(r, 3), axis = below(r, 3), p = (axis + 1) % 3, q = (axis + 2) % 3;
    for (int a = 0; a < 3; a++) {
        g.u[a] = kind == 0 ? SIDE * (uniform(r) - 0.5) : 0.0;
        g.v[a] = kind == 0 ? SIDE * (uniform(r) - 0.5) : 0.0;
    }
    if (kind > 0) {
        g.u[p] = SIDE * (0.2 + uniform(r));
        g.v[q] = SIDE * (0.2 + uniform(r));
    }
    if (kind == 1) {
        g.u[q] = 0.3 * g.v[q];
        g.v[p] = -0.4 * g.u[p];
    }
    for (int a = 0; a < 3; a++)
        g.origin[a] = SIDE * uniform(r) - 0.5 * (g.u[a] + g.v[a]);
    if (below(r, 2))
        g.origin[axis] = floor(g.origin[axis]);
    return g;
}

static const char *const job_kernels[] = {
    "catmull-rom", "bspline3",       "linear",    "bspline3i", "nearest",   "mitchell",
    "bspline2",    "lanczos:3+unit", "lanczos:2", "keys6",     "d-bspline", "blackman-sinc:2"};

struct job {
    weft_volume *volume;
    struct weft_method_params params;
};

// Pixels: 8 to 98 x 78, times `magnification` along each side.
static inline void set_job(struct random *r, int magnification, struct job *job)
{
    struct weft_slice_geometry plane = random_plane(r);
    plane.width *= magnification;
    plane.height *= magnification;
    *job = (struct job){.volume = random_volume(r)};
    job->params.slice = (struct weft_slice_params){.space = WEFT_SPACE_INDEX, .geometry = plane};
    const char *kernel = job_kernels[below(r, (int)WEFT_COUNT(job_kernels))];
    weft_slice_plan *plan = NULL;
    job_must(weft_kernel_parse(NULL, kernel, &job->params.slice.kernel) == WEFT_OK, "kernel");
    job_must(weft_slice_plan_create(job->volume, &job->params.slice, &plan) == WEFT_OK, "plan");
    job_must(weft_footprint_statistics(weft_slice_plan_get_footprint(plan), NULL,
                                       &job->params.statistics) == WEFT_OK,
             "measure");
    weft_slice_plan_destroy(&plan);
}

// From 3 to 17 bits of the voxels' range.
static inline double random_budget(struct random *r, const struct weft_slice_statistics *statistics)
{
    return 0.5 * (statistics->high - statistics->low) * exp2(-3.0 - 14.0 * uniform(r));
}

#endif
