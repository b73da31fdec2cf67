// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/signal.h"

#include <math.h>
#include <string.h>

static double length(const double p[3])
{
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

static const double ml_frequency = 6.0, ml_alpha = 0.25;

static double marschner_lobb(const double p[3])
{
    const double r = sqrt(p[0] * p[0] + p[1] * p[1]);
    const double wave = cos(2.0 * M_PI * ml_frequency * cos(M_PI_2 * r));
    return (1.0 - sin(M_PI_2 * p[2]) + ml_alpha * (1.0 + wave)) / (2.0 * (1.0 + ml_alpha));
}

static void marschner_lobb_gradient(const double p[3], double gradient[3])
{
    const double r = sqrt(p[0] * p[0] + p[1] * p[1]), rate = 2.0 * M_PI * ml_frequency;
    const double by_r = ml_alpha * sin(rate * cos(M_PI_2 * r)) * rate * M_PI_2 * sin(M_PI_2 * r);
    const double scale = 1.0 / (2.0 * (1.0 + ml_alpha));
    gradient[0] = r > 0.0 ? scale * by_r * p[0] / r : 0.0;
    gradient[1] = r > 0.0 ? scale * by_r * p[1] / r : 0.0;
    gradient[2] = -scale * M_PI_2 * cos(M_PI_2 * p[2]);
}

static double sphere(const double p[3])
{
    return length(p) - 0.75;
}

static void sphere_gradient(const double p[3], double gradient[3])
{
    const double r = length(p);
    for (int d = 0; d < 3; d++)
        gradient[d] = r > 0.0 ? p[d] / r : 0.0;
}

// The phase k |x|^2 turns 2 k x / (2 pi) times per unit along x. At x = 1 that is the Nyquist rate
// n / 4 of n voxels over [-1, 1] for k = pi n / 4.
enum { CHIRP_SIZE = 128 };
static const double chirp_rate = M_PI * CHIRP_SIZE / 4.0;

static double chirp(const double p[3])
{
    const double r = length(p);
    return 0.5 + 0.5 * cos(chirp_rate * r * r);
}

static void chirp_gradient(const double p[3], double gradient[3])
{
    const double r = length(p);
    for (int d = 0; d < 3; d++)
        gradient[d] = -chirp_rate * p[d] * sin(chirp_rate * r * r);
}

static double ramp(const double p[3])
{
    return (p[0] + 2.0 * p[1] + 3.0 * p[2] + 6.0) / 12.0;
}

static void ramp_gradient(const double p[3], double gradient[3])
{
    (void)p;
    for (int d = 0; d < 3; d++)
        gradient[d] = (d + 1) / 12.0;
}

static double constant(const double p[3])
{
    (void)p;
    return 1.0;
}

static void constant_gradient(const double p[3], double gradient[3])
{
    (void)p;
    for (int d = 0; d < 3; d++)
        gradient[d] = 0.0;
}

enum { IMPULSE_SIZE = 64 };

// Voxel n/2 of an even n spans [0, 2/n).
static double impulse(const double p[3])
{
    for (int d = 0; d < 3; d++)
        if (!(p[d] >= 0.0 && p[d] < 2.0 / IMPULSE_SIZE))
            return 0.0;
    return 1.0;
}

const struct weft_signal_info *const weft_signal_list[] = {
    &(const struct weft_signal_info){
        .name = "marschner-lobb",
        .description = "frequency-modulated shells, just below the Nyquist rate at 40 voxels",
        .citation = "Marschner and Lobb, Visualization 1994",
        .value = marschner_lobb,
        .gradient = marschner_lobb_gradient,
        .default_size = 128,
    },
    &(const struct weft_signal_info){
        .name = "sphere",
        .description = "signed distance to a sphere of radius 0.75",
        .value = sphere,
        .gradient = sphere_gradient,
        .default_size = 128,
        .level_set = true,
    },
    &(const struct weft_signal_info){
        .name = "chirp",
        .description = "rings whose frequency grows to the Nyquist rate at the faces",
        .value = chirp,
        .gradient = chirp_gradient,
        .default_size = CHIRP_SIZE,
    },
    &(const struct weft_signal_info){
        .name = "ramp",
        .description = "linear along (1, 2, 3)",
        .value = ramp,
        .gradient = ramp_gradient,
        .default_size = 64,
    },
    &(const struct weft_signal_info){
        .name = "constant",
        .description = "1 everywhere",
        .value = constant,
        .gradient = constant_gradient,
        .default_size = 64,
    },
    &(const struct weft_signal_info){
        .name = "impulse",
        .description = "1 at the middle voxel, 0 elsewhere",
        .value = impulse,
        .default_size = IMPULSE_SIZE,
        .lattice = true,
    },
    NULL,
};

const struct weft_signal_info *weft_signal_find(const char *name)
{
    for (size_t i = 0; name && weft_signal_list[i]; i++)
        if (!strcmp(weft_signal_list[i]->name, name))
            return weft_signal_list[i];
    return NULL;
}
