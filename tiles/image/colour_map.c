// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "tiles/image/colour_tables.h"
#include "tiles/image/image.h"

// Linear between the published colours, which are met at i / (count - 1).
static void interpolate(const uint32_t *colour, int count, double t, uint8_t rgb[3])
{
    const double position = fmin(fmax(t, 0.0), 1.0) * (count - 1);
    const int i = position < count - 1 ? (int)position : count - 2;
    for (int c = 0; c < 3; c++) {
        const int shift = 16 - 8 * c, from = (int)(colour[i] >> shift & 255),
                  to = (int)(colour[i + 1] >> shift & 255);
        rgb[c] = (uint8_t)lrint(from + (position - i) * (to - from));
    }
}

static void grey(double t, uint8_t rgb[3])
{
    memset(rgb, (int)lrint(255.0 * fmin(fmax(t, 0.0), 1.0)), 3);
}

static void viridis(double t, uint8_t rgb[3])
{
    interpolate(weft_colours_viridis, WEFT_COLOURS, t, rgb);
}

static void magma(double t, uint8_t rgb[3])
{
    interpolate(weft_colours_magma, WEFT_COLOURS, t, rgb);
}

static void cividis(double t, uint8_t rgb[3])
{
    interpolate(weft_colours_cividis, WEFT_COLOURS, t, rgb);
}

static void turbo(double t, uint8_t rgb[3])
{
    interpolate(weft_colours_turbo, WEFT_COLOURS, t, rgb);
}

static void cool_warm(double t, uint8_t rgb[3])
{
    interpolate(weft_colours_cool_warm, WEFT_COLOURS_COOL_WARM, t, rgb);
}

static const struct weft_colour_map map_grey = {
    .name = "grey",
    .alias = "gray",
    .citation = "linear from black to white",
    .colour = grey,
};
static const struct weft_colour_map map_viridis = {
    .name = "viridis",
    .citation = "uniform; Smith and van der Walt 2015 (CC0)",
    .colour = viridis,
};
static const struct weft_colour_map map_magma = {
    .name = "magma",
    .citation = "uniform, from black; Smith and van der Walt 2015 (CC0)",
    .colour = magma,
};
static const struct weft_colour_map map_cividis = {
    .name = "cividis",
    .citation = "uniform, alike for the colour-blind; Nunez and others 2018 (CC0)",
    .colour = cividis,
};
static const struct weft_colour_map map_cool_warm = {
    .name = "cool-warm",
    .alias = "coolwarm",
    .citation = "diverging; Moreland 2009, Diverging Color Maps for Scientific Visualization",
    .colour = cool_warm,
};
static const struct weft_colour_map map_turbo = {
    .name = "turbo",
    .citation = "a rainbow without its false edges; Mikhailov 2019 (Google, Apache-2.0)",
    .colour = turbo,
};

const struct weft_colour_map *const weft_colour_map_list[] = {
    &map_grey, &map_viridis, &map_magma, &map_cividis, &map_cool_warm, &map_turbo, NULL};

const struct weft_colour_map *weft_colour_map_find(const char *name)
{
    for (size_t i = 0; name && weft_colour_map_list[i]; i++) {
        const struct weft_colour_map *map = weft_colour_map_list[i];
        if (!strcmp(name, map->name) || (map->alias && !strcmp(name, map->alias)))
            return map;
    }
    return NULL;
}
