// SPDX-License-Identifier: BSD-3-Clause
#include "tests/tools/effect/path_tracer.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "filter/threads.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static double normalise(double v[3])
{
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return length;
}

// ---- random numbers -----------------------------------------------------------------------------

// xorshift64* (Vigna 2016), started through SplitMix64.
struct random {
    uint64_t state;
};

static struct random seed_random(uint64_t seed, uint64_t stream)
{
    uint64_t z = seed + (stream + 1) * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    z ^= z >> 31;
    return (struct random){z ? z : 1};
}

static double draw(struct random *random)
{
    random->state ^= random->state >> 12;
    random->state ^= random->state << 25;
    random->state ^= random->state >> 27;
    return (double)(random->state * UINT64_C(0x2545f4914f6cdd1d) >> 11) * 0x1p-53;
}

// ---- rays ---------------------------------------------------------------------------------------

// A triangle as rays want it, and what it emits.
struct traced_face {
    double corner[3], u[3], v[3], normal[3];
    double emission[3], power, end; // power in units of pi; end: with those of all before it
    bool single_sided;
};

static void make_face(const struct scene_triangles *triangles, size_t t, struct traced_face *out)
{
    const struct scene_triangle *triangle = &triangles->list[t];
    const struct scene_material *material = &triangles->scene->materials[triangle->material];
    *out = (struct traced_face){.single_sided = material->single_sided};
    subtract(triangle->corner[1], triangle->corner[0], out->u);
    subtract(triangle->corner[2], triangle->corner[0], out->v);
    cross(out->u, out->v, out->normal);
    normalise(out->normal);
    for (int i = 0; i < 3; i++) {
        out->corner[i] = triangle->corner[0][i];
        out->emission[i] = material->emission[i];
        out->power += material->emission[i] * triangle->area / 3.0;
    }
}

void tracer_make(const struct scene *scene, double time, struct tracer *out)
{
    *out = (struct tracer){0};
    assert_int_equal(scene_triangles_make(scene, time, &out->triangles), WEFT_OK);
    out->faces = calloc(out->triangles.count, sizeof *out->faces);
    assert_non_null(out->faces);
    for (size_t t = 0; t < out->triangles.count; t++) {
        make_face(&out->triangles, t, &out->faces[t]);
        out->power += out->faces[t].power;
        out->faces[t].end = out->power;
    }
}

void tracer_clear(struct tracer *tracer)
{
    scene_triangles_clear(&tracer->triangles);
    free(tracer->faces);
    *tracer = (struct tracer){0};
}

// Moeller and Trumbore, Journal of Graphics Tools 2(1), 1997. Returns the distance; INFINITY: none.
static double meet(const struct traced_face *face, const double from[3], const double along[3],
                   double *b, double *c)
{
    double p[3], q[3], s[3];
    cross(along, face->v, p);
    const double determinant = dot(face->u, p);
    // Positive where the ray comes from the front.
    if (determinant == 0.0 || (face->single_sided && determinant < 0.0))
        return INFINITY;
    subtract(from, face->corner, s);
    *b = dot(s, p) / determinant;
    if (!(*b >= 0.0 && *b <= 1.0))
        return INFINITY;
    cross(s, face->u, q);
    *c = dot(along, q) / determinant;
    const double distance = dot(face->v, q) / determinant;
    return *c >= 0.0 && *b + *c <= 1.0 && distance > 0.0 ? distance : INFINITY;
}

static bool find_hit(const struct tracer *tracer, const double from[3], const double along[3],
                     size_t leave_out, struct scene_hit *out)
{
    out->distance = INFINITY;
    for (size_t t = 0; t < tracer->triangles.count; t++) {
        double b = 0.0, c = 0.0;
        if (t == leave_out)
            continue;
        const double distance = meet(&tracer->faces[t], from, along, &b, &c);
        if (distance < out->distance)
            *out = (struct scene_hit){
                t, distance, {1.0 - b - c, b, c}, dot(along, tracer->faces[t].normal) > 0.0};
    }
    return out->distance < INFINITY;
}

bool tracer_sees(const struct tracer *tracer, const double from[3], size_t from_triangle,
                 const double to[3], size_t to_triangle)
{
    double along[3], b, c;
    subtract(to, from, along);
    for (size_t t = 0; t < tracer->triangles.count; t++)
        if (t != from_triangle && t != to_triangle &&
            meet(&tracer->faces[t], from, along, &b, &c) < 1.0)
            return false;
    return true;
}

// ---- light --------------------------------------------------------------------------------------

static size_t choose_face(const struct tracer *tracer, double number)
{
    size_t low = 0, high = tracer->triangles.count - 1;
    const double at = number * tracer->power;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (at < tracer->faces[middle].end)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

// Density, over solid angle, of a direction as light chooses it that meets a face.
static double find_density(const struct tracer *tracer, size_t t, double cosine, double square)
{
    return tracer->faces[t].power / tracer->power / tracer->triangles.list[t].area * square /
           cosine;
}

// Adds `scale` times the light of one point of a source, weighted by the balance heuristic.
static void add_source(const struct tracer *tracer, const double point[3], const double normal[3],
                       size_t triangle, struct random *random, const double scale[3], double sum[3])
{
    const size_t t = choose_face(tracer, draw(random));
    const struct traced_face *face = &tracer->faces[t];
    const double root = sqrt(draw(random)), other = draw(random);
    double to[3], along[3];
    for (int i = 0; i < 3; i++)
        to[i] = face->corner[i] + root * (1.0 - other) * face->u[i] + root * other * face->v[i];
    subtract(to, point, along);
    const double square = dot(along, along), length = sqrt(square);
    const double here = dot(along, normal) / length, there = -dot(along, face->normal) / length;
    if (t == triangle || !(here > 0.0 && there > 0.0) ||
        !tracer_sees(tracer, point, triangle, to, t))
        return;
    const double density = find_density(tracer, t, there, square);
    const double weight = density / (density + here / M_PI);
    for (int i = 0; i < 3; i++)
        sum[i] += scale[i] * weight * here / density * face->emission[i];
}

static void find_direction(const double normal[3], struct random *random, double out[3])
{
    const double u = draw(random), phi = 2.0 * M_PI * draw(random);
    double a[3] = {0.0, 0.0, 0.0}, b[3];
    a[fabs(normal[0]) < 0.5 ? 0 : 1] = 1.0;
    cross(normal, a, b);
    normalise(b);
    cross(b, normal, a);
    for (int i = 0; i < 3; i++)
        out[i] = sqrt(u) * (cos(phi) * a[i] + sin(phi) * b[i]) + sqrt(1.0 - u) * normal[i];
}

// One path: an estimate of the irradiance.
static void trace_path(const struct tracer *tracer, const double start[3], const double side[3],
                       size_t triangle, int bounces, struct random *random, double sum[3])
{
    double point[3], normal[3], scale[3] = {1.0, 1.0, 1.0};
    for (int i = 0; i < 3; i++) {
        point[i] = start[i];
        normal[i] = side[i];
        sum[i] = 0.0;
    }
    for (int bounce = 0;; bounce++) {
        add_source(tracer, point, normal, triangle, random, scale, sum);
        double along[3], reflectance[3];
        find_direction(normal, random, along);
        struct scene_hit hit;
        if (!find_hit(tracer, point, along, triangle, &hit))
            return;
        const struct traced_face *face = &tracer->faces[hit.triangle];
        const double there = -dot(along, face->normal), here = dot(along, normal);
        if (there > 0.0 && face->power > 0.0) {
            const double other =
                find_density(tracer, hit.triangle, there, hit.distance * hit.distance);
            const double weight = here / M_PI / (here / M_PI + other);
            for (int i = 0; i < 3; i++)
                sum[i] += scale[i] * weight * M_PI * face->emission[i];
        }
        if (bounce == bounces)
            return;
        scene_triangle_reflectance(&tracer->triangles, hit.triangle, hit.weight, reflectance);
        double most = 0.0;
        for (int i = 0; i < 3; i++) {
            scale[i] *= reflectance[i];
            most = fmax(most, scale[i]);
        }
        const double survival = bounce < 2 ? 1.0 : fmin(most, 1.0);
        if (!(most > 0.0) || draw(random) >= survival)
            return;
        for (int i = 0; i < 3; i++)
            scale[i] /= survival;
        scene_triangle_point(&tracer->triangles.list[hit.triangle], hit.weight, point);
        for (int i = 0; i < 3; i++)
            normal[i] = hit.back ? -face->normal[i] : face->normal[i];
        triangle = hit.triangle;
    }
}

struct traced tracer_irradiance(const struct tracer *tracer, const double point[3],
                                const double normal[3], size_t triangle, int bounces, int samples,
                                uint64_t seed)
{
    struct random random = seed_random(seed, 0);
    double sum[3] = {0.0}, squares[3] = {0.0};
    for (int s = 0; s < samples; s++) {
        double one[3];
        trace_path(tracer, point, normal, triangle, bounces, &random, one);
        for (int i = 0; i < 3; i++) {
            sum[i] += one[i];
            squares[i] += one[i] * one[i];
        }
    }
    struct traced out;
    for (int i = 0; i < 3; i++) {
        out.mean[i] = sum[i] / samples;
        out.error[i] =
            sqrt(fmax(squares[i] / samples - out.mean[i] * out.mean[i], 0.0) / (samples - 1));
    }
    return out;
}

// ---- pictures -----------------------------------------------------------------------------------

// Distance from a point to a triangle: to its plane where it falls inside, else to the nearest
// side.
static double find_distance(const struct traced_face *face, const double point[3])
{
    double from[3], inside[3];
    subtract(point, face->corner, from);
    const double height = dot(from, face->normal);
    double b, c;
    for (int i = 0; i < 3; i++)
        inside[i] = -face->normal[i] * (height < 0.0 ? -1.0 : 1.0);
    struct traced_face both = *face;
    both.single_sided = false;
    if (height != 0.0 && meet(&both, point, inside, &b, &c) < INFINITY)
        return fabs(height);
    double nearest = INFINITY;
    for (int k = 0; k < 3; k++) {
        double side[3], to[3];
        for (int i = 0; i < 3; i++) {
            const double first = k == 2 ? face->u[i] : 0.0;
            const double last = k == 0 ? face->u[i] : face->v[i];
            side[i] = last - first;
            to[i] = from[i] - first;
        }
        const double t = fmin(fmax(dot(to, side) / dot(side, side), 0.0), 1.0);
        for (int i = 0; i < 3; i++)
            to[i] -= t * side[i];
        nearest = fmin(nearest, sqrt(dot(to, to)));
    }
    return nearest;
}

static double find_clearance(const struct tracer *tracer, size_t triangle, const double point[3])
{
    double nearest = INFINITY;
    for (size_t t = 0; t < tracer->triangles.count; t++) {
        double from[3];
        subtract(point, tracer->faces[t].corner, from);
        const double size = sqrt(tracer->triangles.list[t].area);
        const bool coplanar =
            fabs(dot(from, tracer->faces[t].normal)) < 1e-6 * size &&
            fabs(dot(tracer->faces[t].normal, tracer->faces[triangle].normal)) > 1.0 - 1e-9;
        if (t != triangle && !coplanar)
            nearest = fmin(nearest, find_distance(&tracer->faces[t], point));
    }
    return nearest;
}

struct picture {
    const struct tracer *tracer;
    const struct weft_camera *camera;
    const int *size;
    int samples;
    uint64_t seed;
    struct traced_pixel *out;
};

// From the camera's eye through a pixel's centre.
static void aim(const struct picture *job, int x, int y, double along[3])
{
    const struct weft_camera *camera = job->camera;
    double forward[3], right[3], up[3];
    subtract(camera->target, camera->eye, forward);
    normalise(forward);
    cross(forward, camera->up, right);
    normalise(right);
    cross(right, forward, up);
    const double top = tan(camera->fovy_degrees * M_PI / 360.0);
    const double aspect =
        camera->aspect > 0.0 ? camera->aspect : (double)job->size[0] / job->size[1];
    const double u = (2.0 * (x + 0.5) / job->size[0] - 1.0) * top * aspect;
    const double v = (2.0 * (y + 0.5) / job->size[1] - 1.0) * top;
    for (int i = 0; i < 3; i++)
        along[i] = forward[i] + u * right[i] + v * up[i];
}

static void look(const struct picture *job, int x, int y, struct traced_pixel *out)
{
    const struct tracer *tracer = job->tracer;
    double along[3];
    struct scene_hit hit;
    *out = (struct traced_pixel){.triangle = SIZE_MAX, .clearance = INFINITY};
    for (int i = 0; i < 3; i++)
        out->radiance.mean[i] = out->radiance.error[i] = NAN;
    aim(job, x, y, along);
    if (!find_hit(tracer, job->camera->eye, along, SIZE_MAX, &hit))
        return;
    const struct traced_face *face = &tracer->faces[hit.triangle];
    out->triangle = hit.triangle;
    scene_triangle_point(&tracer->triangles.list[hit.triangle], hit.weight, out->point);
    scene_triangle_reflectance(&tracer->triangles, hit.triangle, hit.weight, out->reflectance);
    for (int i = 0; i < 3; i++) {
        out->normal[i] = hit.back ? -face->normal[i] : face->normal[i];
        out->emission[i] = hit.back ? 0.0 : face->emission[i];
    }
    out->clearance = find_clearance(tracer, hit.triangle, out->point);
}

static bool trace_row(void *priv, int thread, size_t y)
{
    const struct picture *job = priv;
    (void)thread;
    for (int x = 0; x < job->size[0]; x++) {
        const size_t at = y * (size_t)job->size[0] + (size_t)x;
        struct traced_pixel *pixel = &job->out[at];
        look(job, x, (int)y, pixel);
        if (job->samples == 0 || pixel->triangle == SIZE_MAX)
            continue;
        pixel->radiance =
            tracer_irradiance(job->tracer, pixel->point, pixel->normal, pixel->triangle,
                              TRACED_ALL_BOUNCES, job->samples, seed_random(job->seed, at).state);
        for (int i = 0; i < 3; i++) {
            const double thrown = pixel->reflectance[i] / M_PI;
            pixel->radiance.mean[i] = pixel->emission[i] + thrown * pixel->radiance.mean[i];
            pixel->radiance.error[i] *= thrown;
        }
    }
    return true;
}

void tracer_picture(const struct tracer *tracer, const struct weft_camera *camera,
                    const int size[2], int samples, uint64_t seed, int threads,
                    struct traced_pixel *out)
{
    struct picture job = {tracer, camera, size, samples, seed, out};
    assert_true(weft_threads_run(threads, (size_t)size[1], trace_row, &job));
}

// ---- Lambert's formula --------------------------------------------------------------------------

double lambert_irradiance(const double (*corner)[3], int count, const double point[3],
                          const double normal[3])
{
    double sum = 0.0;
    for (int k = 0; k < count; k++) {
        double a[3], b[3], edge[3];
        subtract(corner[k], point, a);
        subtract(corner[(k + 1) % count], point, b);
        normalise(a);
        normalise(b);
        cross(a, b, edge);
        const double sine = normalise(edge);
        sum += atan2(sine, dot(a, b)) * dot(edge, normal);
    }
    return sum / 2.0;
}
