// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/pattern/pattern.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/pattern/search.h"
#include "passes/jitter/discrepancy_impl.h"
#include "passes/jitter/points.h"

static bool check(const struct weft_pattern_params *p)
{
    if (p->device_count < 1 || p->device_count > WEFT_PATTERN_MAX_DEVICE || p->count < 1 ||
        p->count > WEFT_PATTERN_MAX || p->count % p->device_count != 0) {
        weft_error(p->log,
                   "%d samples of a pixel with %d of the device: they must be a multiple to %d, of "
                   "1 to %d",
                   p->count, p->device_count, WEFT_PATTERN_MAX, WEFT_PATTERN_MAX_DEVICE);
        return false;
    }
    if (!weft_points_check(p->log, p->device, p->device_count))
        return false;
    for (int i = 0; i < p->device_count; i++)
        if (!(fabs(p->device[i][0]) <= 0.5 && fabs(p->device[i][1]) <= 0.5)) {
            weft_error(p->log, "sample %d of the device's %d at (%g, %g) is not in its pixel",
                       i + 1, p->device_count, p->device[i][0], p->device[i][1]);
            return false;
        }
    return true;
}

// Four samples of Direct3D, of llvmpipe and of most devices, in 256ths of a pixel about its middle,
// in any order.
static const double standard[4][2] = {{-32, -96}, {96, -32}, {-96, 32}, {32, 96}};

// What longer searches find for them, which tests do again.
static const struct moves {
    int starts, tries, passes;
    uint8_t move[16][2];
} moves_of_standard[] = {
    {40, 2000, 2, {{34, 154}, {223, 101}}},
    {8, 8000, 4, {{4, 61}, {138, 65}, {251, 201}, {122, 184}}},
    {8,
     40000,
     16,
     {{201, 221},
      {244, 211},
      {14, 202},
      {51, 205},
      {181, 247},
      {239, 253},
      {18, 236},
      {52, 238},
      {29, 142},
      {134, 207},
      {22, 14},
      {102, 237},
      {212, 52},
      {241, 148},
      {18, 49},
      {46, 46}}},
};

// Whether the device has the standard samples, with rows that count down (sign 1) or up (-1).
static bool is_standard(const struct weft_pattern_params *p, int sign)
{
    int found = 0;
    for (int i = 0; p->device_count == 4 && i < 4; i++)
        for (int j = 0; j < 4; j++)
            found += p->device[i][0] * WEFT_PATTERN_PARTS == standard[j][0] &&
                     p->device[i][1] * WEFT_PATTERN_PARTS == sign * standard[j][1];
    return found == 4;
}

static bool find_in_table(const struct weft_pattern_params *p, int passes, uint8_t (*moves)[2])
{
    const int sign = is_standard(p, 1) ? 1 : -1;
    if (sign < 0 && !is_standard(p, -1))
        return false;
    for (size_t i = 0; i < WEFT_COUNT(moves_of_standard); i++) {
        const struct moves *m = &moves_of_standard[i];
        for (int pass = 0; m->passes == passes && pass < passes; pass++) {
            moves[pass][0] = m->move[pass][0];
            moves[pass][1] = (uint8_t)(sign * m->move[pass][1]);
        }
        if (m->passes == passes)
            return true;
    }
    return false;
}

static void find_moves(const struct weft_pattern_params *p, int passes, uint8_t (*moves)[2])
{
    enum { WORK = 1 << 18 };
    const struct weft_pattern_search search = {
        .device = p->device,
        .device_count = p->device_count,
        .passes = passes,
        .starts = 1,
        .tries = WORK / (p->count * p->count),
    };
    if (!find_in_table(p, passes, moves))
        weft_pattern_search(&search, moves);
}

enum weft_result weft_pattern_create(const struct weft_pattern_params *params,
                                     struct weft_pattern *out)
{
    const struct weft_log *log = params ? params->log : NULL;
    struct weft_discrepancy_event events[WEFT_PATTERN_MAX];
    uint8_t moves[WEFT_PATTERN_MAX][2] = {{0, 0}};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    memset(out, 0, sizeof *out);
    weft_require(log, params && params->device);
    if (!check(params))
        goto fail;
    const int passes = params->count / params->device_count;
    if (passes > 1)
        find_moves(params, passes, moves);
    weft_pattern_place(params->device, params->device_count, passes, (const uint8_t(*)[2])moves,
                       out);
    out->discrepancy =
        weft_discrepancy_find(weft_discrepancy_params(.points = (const double(*)[2])out->position,
                                                      .count = out->count),
                              events, INFINITY)
            .value;
    for (int i = 0; i < out->count; i++)
        for (int axis = 0; axis < 2; axis++)
            out->mean[axis] += out->position[i][axis] / out->count;
    res = WEFT_OK;
fail:
    return res;
}
