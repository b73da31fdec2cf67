// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/image/image.h"

static void interpolate(const uint8_t (*point)[3], int count, double t, uint8_t rgb[3])
{
    double position = (t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t) * (count - 1);
    int i = (int)position;
    if (i > count - 2)
        i = count - 2;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)lrint(point[i][c] + (position - i) * (point[i + 1][c] - point[i][c]));
}

static void grey(double t, uint8_t rgb[3])
{
    memset(rgb, (int)lrint(255.0 * fmin(fmax(t, 0.0), 1.0)), 3);
}

// Every 17th of the 256 published colours; between them linear, within 3/255 of the original.
static void viridis(double t, uint8_t rgb[3])
{
    static const uint8_t point[][3] = {
        {68, 1, 84},    {72, 26, 108},  {71, 47, 125},  {65, 68, 135},
        {57, 86, 140},  {49, 104, 142}, {42, 120, 142}, {35, 136, 142},
        {31, 152, 139}, {34, 168, 132}, {53, 183, 121}, {84, 197, 104},
        {122, 209, 81}, {165, 219, 54}, {210, 226, 27}, {253, 231, 37},
    };
    interpolate(point, WEFT_COUNT(point), t, rgb);
}

static void cool_warm(double t, uint8_t rgb[3])
{
    static const uint8_t point[][3] = {
        {59, 76, 192},   {77, 104, 215},  {98, 130, 234},  {119, 154, 247}, {141, 176, 254},
        {163, 194, 255}, {184, 208, 249}, {204, 217, 238}, {221, 221, 221}, {236, 211, 197},
        {245, 196, 173}, {247, 177, 148}, {244, 154, 123}, {236, 127, 99},  {222, 96, 77},
        {203, 62, 56},   {180, 4, 38},
    };
    interpolate(point, WEFT_COUNT(point), t, rgb);
}

static const struct weft_colour_map map_grey = {
    .name = "grey",
    .citation = "linear from black to white",
    .colour = grey,
};
static const struct weft_colour_map map_viridis = {
    .name = "viridis",
    .citation = "van der Walt and Smith 2015, mpl colormaps (CC0)",
    .colour = viridis,
};
static const struct weft_colour_map map_cool_warm = {
    .name = "cool-warm",
    .citation = "Moreland 2009, Diverging Color Maps for Scientific Visualization",
    .colour = cool_warm,
};

const struct weft_colour_map *const weft_colour_map_list[] = {&map_grey, &map_viridis,
                                                              &map_cool_warm, NULL};

const struct weft_colour_map *weft_colour_map_find(const char *name)
{
    for (size_t i = 0; name && weft_colour_map_list[i]; i++)
        if (!strcmp(name, weft_colour_map_list[i]->name))
            return weft_colour_map_list[i];
    return NULL;
}
