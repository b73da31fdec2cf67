// SPDX-License-Identifier: BSD-3-Clause
// The voxels in reach of a slice, measured by all ranks that share its regions.
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/stages.h"

enum { BANDS = 8 }; // of a rank

struct measuring {
    weft_footprint *footprint;
    int width, height, bands;
    struct weft_slice_statistics sum; // on rank 0
};

static enum weft_result measure_band(void *priv, int64_t item, void **data, size_t *size)
{
    struct measuring *m = priv;
    const int from = (int)(item * m->height / m->bands),
              to = (int)((item + 1) * m->height / m->bands);
    const struct weft_rectangle band = {0, from, m->width, to - from};
    struct weft_slice_statistics *out = malloc(sizeof *out);
    if (!out)
        return WEFT_ERR_MEMORY;
    *data = out;
    *size = sizeof *out;
    return weft_footprint_part_statistics(m->footprint, &band, NULL, out);
}

static enum weft_result take_band(void *priv, int64_t item, const void *data, size_t size)
{
    struct measuring *m = priv;
    struct weft_slice_statistics one;
    (void)item;
    if (size != sizeof one)
        return WEFT_ERR_FORMAT;
    memcpy(&one, data, size);
    m->sum = weft_slice_statistics_join(&m->sum, &one);
    return WEFT_OK;
}

static enum weft_result measure_together(weft_footprint *footprint,
                                         struct weft_slice_statistics *out)
{
    const struct weft_slice_geometry *g = &weft_footprint_get_info(footprint)->geometry;
    const int most = BANDS * ranks_size();
    struct measuring m = {.footprint = footprint,
                          .width = g->width,
                          .height = g->height,
                          .bands = g->height < most ? g->height : most};
    const enum weft_result res = ranks_agree(
        weft_ranks_do_items(ranks_get(),
                            &(struct weft_items){.count = m.bands,
                                                 .schedule = WEFT_SCHEDULE_STATIC,
                                                 .run = measure_band,
                                                 .take = take_band,
                                                 .priv = &m,
                                                 .progress = report_progress("measuring")},
                            NULL));
    *out = m.sum;
    return res;
}

// What counts around prefiltered kernels' taps is measured for all pixels together.
enum weft_result slice_measure(struct slice_job *job, enum weft_result before,
                               weft_footprint *footprint, struct weft_slice_statistics *out)
{
    const struct weft_progress *progress = report_progress("measuring");
    const struct slice_divided *divided = &job->setup->divided;
    if (!divided->is || divided->frames)
        return before == WEFT_OK ? weft_footprint_statistics(footprint, progress, out) : before;
    enum weft_result res = ranks_agree(before);
    if (res != WEFT_OK)
        return res;
    if (!weft_footprint_get_info(footprint)->kernel.prefiltered)
        res = measure_together(footprint, out);
    else if (ranks_tells())
        res = weft_footprint_statistics(footprint, progress, out);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_share(out, sizeof *out);
    if (res == WEFT_OK &&
        !(ranks_tells() && weft_footprint_get_info(footprint)->kernel.prefiltered))
        weft_footprint_set_statistics(footprint, out);
    return res;
}
