// SPDX-License-Identifier: BSD-3-Clause
// Mip levels of the result of `weft resample`: each by the kernel, stretched, over the whole
// result.
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// What makes the levels of a job.
struct maker {
    struct resample_job *job;
    struct weft_kernel kernel;
    weft_resample_source **source; // of each channel; NULL of integers that are moved
};

// Prefiltered and radial kernels are not stretched; single samples stay single samples.
static struct weft_kernel choose_kernel(const struct resample_job *job)
{
    const struct weft_kernel *own = &job->kernel;
    struct weft_kernel kernel = *own;
    if (own->prefiltered || weft_kernel_is_radial(own, 2))
        weft_kernel_create(NULL, weft_kernel_find("catmull-rom"), NULL, &kernel);
    return kernel;
}

static bool is_moved(const struct maker *m, size_t channel)
{
    return m->job->result.channels[channel].type == WEFT_PIXEL_UINT;
}

static enum weft_result make_sources(struct maker *m)
{
    const struct weft_image *image = &m->job->result;
    enum weft_result res = WEFT_OK;
    m->source = calloc(image->channel_count, sizeof *m->source);
    if (!m->source)
        return WEFT_ERR_MEMORY;
    for (size_t c = 0; res == WEFT_OK && c < image->channel_count; c++)
        if (!is_moved(m, c))
            res = weft_resample_source_create(
                weft_resample_source_params(.kernel = m->kernel, .width = image->width,
                                            .height = image->height,
                                            .plane = {image->channels[c].plane},
                                            .threads = m->job->engine.cpu.threads,
                                            .log = report_log()),
                &m->source[c]);
    return res;
}

static enum weft_result make_level(const struct weft_image *image, int level,
                                   struct weft_image *out)
{
    *out = (struct weft_image){.width = weft_image_level_size(image->width, level),
                               .height = weft_image_level_size(image->height, level)};
    const size_t pixels = (size_t)out->width * (size_t)out->height;
    out->channels = calloc(image->channel_count, sizeof *out->channels);
    if (!out->channels)
        return WEFT_ERR_MEMORY;
    for (; out->channel_count < image->channel_count; out->channel_count++) {
        struct weft_image_channel *to = &out->channels[out->channel_count];
        const struct weft_image_channel *from = &image->channels[out->channel_count];
        *to = *from;
        to->plane = malloc(pixels * sizeof *to->plane);
        to->integers = from->type == WEFT_PIXEL_UINT ? malloc(pixels * sizeof *to->integers) : NULL;
        if (!to->plane || (from->type == WEFT_PIXEL_UINT && !to->integers)) {
            out->channel_count++;
            return WEFT_ERR_MEMORY;
        }
    }
    return WEFT_OK;
}

static enum weft_result plan_level(const struct maker *m, const struct weft_kernel *kernel,
                                   const struct weft_image *level, weft_resample_plan **out)
{
    const struct weft_image *image = &m->job->result;
    return weft_resample_plan_create(
        weft_resample_params(.kernel = *kernel, .size = {image->width, image->height},
                             .width = level->width, .height = level->height,
                             .map = {weft_window_map_plain(image->width, level->width),
                                     weft_window_map_plain(image->height, level->height)},
                             .engine = WEFT_ENGINE_CPU, .log = report_log()),
        out);
}

static enum weft_result filter_channels(const struct maker *m, const struct weft_image *level)
{
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    enum weft_result res = plan_level(m, &m->kernel, level, &plan);
    if (res == WEFT_OK)
        res = weft_resample_compile(plan, weft_resample_compile_params(.cpu = m->job->engine.cpu),
                                    &compiled);
    for (size_t c = 0; res == WEFT_OK && c < level->channel_count; c++)
        if (!is_moved(m, c))
            res = weft_resample_run(compiled,
                                    weft_resample_run_params(.source = m->source[c],
                                                             .plane = {level->channels[c].plane},
                                                             .log = report_log()),
                                    NULL);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    return res;
}

// Integers, which have no fractions.
static enum weft_result move_channels(const struct maker *m, const struct weft_image *level)
{
    const struct weft_image *image = &m->job->result;
    struct weft_kernel nearest;
    weft_resample_plan *plan = NULL;
    enum weft_result res = WEFT_OK;
    weft_kernel_create(NULL, weft_kernel_find("nearest"), NULL, &nearest);
    for (size_t c = 0; res == WEFT_OK && c < level->channel_count; c++) {
        const struct weft_resample_integers from = {
            .width = image->width, .height = image->height, .plane = image->channels[c].integers};
        if (!is_moved(m, c))
            continue;
        if (!plan)
            res = plan_level(m, &nearest, level, &plan);
        if (res == WEFT_OK)
            res = weft_resample_move(plan, &from, NULL, level->channels[c].integers, 0);
    }
    weft_resample_plan_destroy(&plan);
    return res;
}

enum weft_result resample_make_mips(struct resample_job *job)
{
    struct weft_image *image = &job->result;
    struct maker m = {.job = job, .kernel = choose_kernel(job)};
    const int count = weft_image_level_count(image->width, image->height) - 1;
    if (image->levels != WEFT_IMAGE_LEVELS_MIP)
        return WEFT_OK;
    job->mips = calloc((size_t)count + 1, sizeof *job->mips);
    enum weft_result res = job->mips ? make_sources(&m) : WEFT_ERR_MEMORY;
    for (int l = 0; res == WEFT_OK && l < count; l++) {
        res = make_level(image, l + 1, &job->mips[job->mip_count++]);
        if (res == WEFT_OK)
            res = filter_channels(&m, &job->mips[l]);
        if (res == WEFT_OK)
            res = move_channels(&m, &job->mips[l]);
    }
    image->mips = job->mips;
    if (res == WEFT_ERR_MEMORY)
        report_error("out of memory for %d mip levels", count);
    for (size_t c = 0; m.source && c < image->channel_count; c++)
        weft_resample_source_destroy(&m.source[c]);
    free(m.source);
    return res;
}

void resample_clear_mips(struct resample_job *job)
{
    for (int l = 0; l < job->mip_count; l++)
        weft_image_clear(&job->mips[l]);
    free(job->mips);
}
