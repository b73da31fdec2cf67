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
        weft_pattern_search(params->device, params->device_count, passes, moves);
    weft_pattern_place(params->device, params->device_count, passes, (const uint8_t(*)[2])moves,
                       out);
    out->discrepancy =
        weft_discrepancy_find(weft_discrepancy_params(.points = (const double(*)[2])out->position,
                                                      .count = out->count),
                              events)
            .value;
    for (int i = 0; i < out->count; i++)
        for (int axis = 0; axis < 2; axis++)
            out->mean[axis] += out->position[i][axis] / out->count;
    res = WEFT_OK;
fail:
    return res;
}
