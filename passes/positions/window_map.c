// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/window_map.h"

#include <math.h>

#include "filter/check.h"

static int64_t divide_down(int64_t a, int64_t b)
{
    return a / b - (a % b != 0 && a < 0);
}

static bool is_near(int64_t a)
{
    return a >= -WEFT_WINDOW_MAX && a <= WEFT_WINDOW_MAX;
}

// Products then stay below 2^63.
static bool is_map(const struct weft_window_map *m)
{
    return m->from >= 1 && m->to >= 1 && is_near(m->from) && is_near(m->to) && is_near(m->pixel) &&
           is_near(m->sample);
}

struct weft_window_map weft_window_map_plain(int samples, int pixels)
{
    return (struct weft_window_map){.from = samples, .to = pixels};
}

static enum weft_result check_scale(const struct weft_log *log, struct weft_window data,
                                    struct weft_window display, int64_t to)
{
    const bool near = is_near(data.first) && is_near(data.end) && is_near(display.first) &&
                      is_near(display.end) && is_near(to);
    if (near && data.first < data.end && display.first < display.end && to >= 1)
        return WEFT_OK;
    weft_error(log,
               "windows from %lld to %lld and from %lld to %lld, scaled to %lld pixels: ends must "
               "rise, and all be within %d of 0",
               (long long)data.first, (long long)data.end, (long long)display.first,
               (long long)display.end, (long long)to, WEFT_WINDOW_MAX);
    return WEFT_ERR_ARGUMENT;
}

// EXR's limit, exclusive.
static enum weft_result check_windows(const struct weft_log *log, struct weft_window data,
                                      struct weft_window display)
{
    const int64_t limit = INT32_MAX / 2;
    const int64_t low = data.first < display.first ? data.first : display.first;
    const int64_t high = data.end > display.end ? data.end : display.end;
    if (low > -limit && high < limit)
        return WEFT_OK;
    weft_error(log, "the windows, enlarged, reach from %lld to %lld: the limit is +-%lld",
               (long long)low, (long long)high, (long long)limit);
    return WEFT_ERR_LIMIT;
}

enum weft_result weft_window_map_scale(const struct weft_log *log, struct weft_window data,
                                       struct weft_window display, int64_t to,
                                       struct weft_window *new_data,
                                       struct weft_window *new_display, struct weft_window_map *out)
{
    *out = (struct weft_window_map){0};
    *new_data = *new_display = (struct weft_window){0};
    const enum weft_result res = check_scale(log, data, display, to);
    if (res != WEFT_OK)
        return res;
    const int64_t from = display.end - display.first, first = data.first - display.first;
    const int64_t edge = divide_down(2 * display.first * to + from, 2 * from);
    new_display->first = edge;
    new_display->end = edge + to;
    new_data->first = edge + divide_down(first * to, from);
    new_data->end = edge - divide_down(-(data.end - display.first) * to, from);
    *out = (struct weft_window_map){
        .from = from, .to = to, .pixel = new_data->first - edge, .sample = -first};
    return check_windows(log, *new_data, *new_display);
}

// Twice `to` times the distance of a pixel's centre from the first sample's lower edge.
static bool find_place(const struct weft_window_map *m, int pixel, int64_t *out)
{
    if (!is_map(m) || !is_near(pixel))
        return false;
    const int64_t inside = (2 * (pixel + m->pixel) + 1) * m->from, start = 2 * m->sample * m->to;
    return !__builtin_add_overflow(inside, start, out);
}

double weft_window_map_position(const struct weft_window_map *map, int pixel, int shift)
{
    int64_t place;
    if (!find_place(map, pixel, &place) || !is_near(shift) ||
        __builtin_add_overflow(place, (2 * (int64_t)shift - 1) * map->to, &place))
        return NAN;
    return (double)place / (double)(2 * map->to);
}

void weft_window_map_positions(const struct weft_window_map *map, int first, int count, int shift,
                               double *at)
{
    for (int i = 0; i < count; i++)
        at[i] = weft_window_map_position(map, first + i, shift);
}

int64_t weft_window_map_square(const struct weft_window_map *map, int pixel)
{
    int64_t place;
    return find_place(map, pixel, &place) ? divide_down(place, 2 * map->to) : INT64_MIN;
}
