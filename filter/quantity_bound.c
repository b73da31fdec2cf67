// SPDX-License-Identifier: BSD-3-Clause
// How far quantities may be off. With a gradient that is off by a vector no longer than d and a
// Hessian that is off by a matrix of norm e:
// - |g| is off by d at most; n turns by an angle of asin(d / |g|) at most, and there is no bound
//   where d reaches |g|;
// - curvatures are the eigenvalues of a symmetric 2 x 2 matrix, -H / |g| in the plane square to n,
//   and no farther off than the norm of what that matrix is off by (Weyl). Turned back by the
//   rotation that takes n to where it is, t becomes cos t + sin n for the tangent t that turns, so
//   that t H t is off by sin^2 (nHn - tHt) + 2 sin cos tHn, and its product with the other one by
//   (cos - 1) tHs + sin nHs.
#include <math.h>
#include <string.h>

#include "filter/quantity_impl.h"

struct errors {
    double g[3], h[6], laplacian; // of each entry, in world space
    double d, e;                  // lengths of g's, and of the Hessian's as a vector of 9
};

static struct errors errors_of(const struct weft_quantity_terms *terms, const double *error)
{
    struct errors out = {.d = 0.0};
    const double *first = error + terms->first[1], *second = error + terms->first[2];
    for (int r = 0; r < 3 && terms->first[1] >= 0; r++) {
        for (int i = 0; i < 3; i++)
            out.g[r] += fabs(terms->g[r][i]) * first[i];
        out.d = hypot(out.d, out.g[r]);
    }
    for (int r = 0; r < 6 && terms->first[2] >= 0; r++) {
        const double twice = r == 0 || r == 3 || r == 5 ? 1.0 : sqrt(2.0);
        for (int i = 0; i < 6; i++)
            out.h[r] += fabs(terms->h[r][i]) * second[i];
        out.e = hypot(out.e, twice * out.h[r]);
        out.laplacian += fabs(terms->h[0][r] + terms->h[3][r] + terms->h[5][r]) * second[r];
    }
    return out;
}

// What is needed of the point itself, which is computed as its channels are.
struct point {
    double magnitude, normal[3], hessian[6], mean, gaussian;
};

static struct point point_of(const struct weft_quantity_transform *transform,
                             const struct weft_quantity_terms *terms, const double *derivative)
{
    static const enum weft_quantity needed[] = {
        WEFT_QUANTITY_GRADIENT_MAGNITUDE, WEFT_QUANTITY_NORMAL, WEFT_QUANTITY_HESSIAN,
        WEFT_QUANTITY_MEAN_CURVATURE, WEFT_QUANTITY_GAUSSIAN_CURVATURE};
    struct weft_quantities all;
    double own[9] = {0.0}, c[12];
    weft_quantities_create(NULL, needed, 5, &all);
    for (int i = 0; i < 3 && terms->first[1] >= 0; i++)
        own[i] = derivative[terms->first[1] + i];
    for (int i = 0; i < 6 && terms->first[2] >= 0; i++)
        own[3 + i] = derivative[terms->first[2] + i];
    weft_quantities_compute(&all, transform, own, c);
    return (struct point){
        c[0], {c[1], c[2], c[3]}, {c[4], c[5], c[6], c[7], c[8], c[9]}, c[10], c[11]};
}

// Of every curvature.
static double curvature_bound(const struct point *p, const struct errors *off)
{
    const double *n = p->normal, *h = p->hessian, sine = off->d / p->magnitude;
    const double hn[3] = {h[0] * n[0] + h[1] * n[1] + h[2] * n[2],
                          h[1] * n[0] + h[3] * n[1] + h[4] * n[2],
                          h[2] * n[0] + h[4] * n[1] + h[5] * n[2]};
    const double along = hn[0] * n[0] + hn[1] * n[1] + hn[2] * n[2];
    const double across =
        sqrt(fmax(hn[0] * hn[0] + hn[1] * hn[1] + hn[2] * hn[2] - along * along, 0.0));
    const double apart = sqrt(fmax(p->mean * p->mean - p->gaussian, 0.0));
    const double within = (fabs(p->mean) + apart) * p->magnitude; // norm of H in the plane
    const double turned = sine * (sine * (fabs(along) + 2.0 * within) + 3.0 * across);
    return (off->e + turned + within * sine) / (p->magnitude - off->d);
}

// Of each component: as the normal turns, or as its own numerator and the length change.
static double normal_bound(const struct point *p, const struct errors *off, int axis)
{
    const double sine = off->d / p->magnitude;
    const double turns = sqrt(2.0 * (1.0 - sqrt(1.0 - sine * sine)));
    const double own = (off->g[axis] + fabs(p->normal[axis]) * off->d) / (p->magnitude - off->d);
    return fmin(turns, own);
}

// Of a product of both curvatures.
static double product_bound(const struct point *p, double each)
{
    const double apart = sqrt(fmax(p->mean * p->mean - p->gaussian, 0.0));
    return each * (2.0 * fmax(fabs(p->mean), apart) + each);
}

void weft_quantities_bound(const struct weft_quantities *list,
                           const struct weft_quantity_transform *transform,
                           const double *derivative, const double *error, double *bound)
{
    const struct weft_quantity_terms terms = weft_quantity_terms_of(list, transform);
    const struct errors off = errors_of(&terms, error);
    const struct point p = point_of(transform, &terms, derivative);
    const bool turns = p.magnitude > off.d; // not NAN, either
    const double curvature = turns ? curvature_bound(&p, &off) : (double)INFINITY;
    const double curved[4] = {curvature, turns ? product_bound(&p, curvature) : (double)INFINITY,
                              curvature, curvature};
    double normal[3];
    for (int i = 0; i < 3; i++)
        normal[i] = turns ? normal_bound(&p, &off, i) : (double)INFINITY;
    const double *const of[WEFT_QUANTITY_COUNT] = {terms.first[0] < 0 ? NULL
                                                                      : error + terms.first[0],
                                                   off.g,
                                                   &off.d,
                                                   normal,
                                                   off.h,
                                                   &off.laplacian,
                                                   curved,
                                                   curved + 1,
                                                   curved + 2};
    for (int i = 0; i < list->count; i++) {
        const int count = weft_quantity_channels(list->quantity[i]);
        memcpy(bound, of[list->quantity[i]], (size_t)count * sizeof *bound);
        bound += count;
    }
}
