// SPDX-License-Identifier: BSD-3-Clause
// Types of the channels of `weft resample`, and planes of them.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

static struct weft_image_channel *source_channel(const struct resample_job *job,
                                                 const struct resample_group *group)
{
    return &job->image.channels[job->source[group->channel[0]]];
}

static struct weft_image_channel *result_channel(const struct resample_job *job,
                                                 const struct resample_group *group)
{
    return &job->result.channels[group->channel[0]];
}

uint64_t resample_count_rounded(const struct resample_job *job, size_t i, int first, int end)
{
    const struct weft_image_channel *channel = &job->image.channels[i];
    const size_t width = (size_t)job->image.width;
    uint64_t rounded = 0;
    for (size_t k = (size_t)first * width; channel->integers && k < (size_t)end * width; k++)
        rounded += (double)channel->plane[k] != (double)channel->integers[k];
    return rounded;
}

static void warn_of_group(const struct resample_job *job, const struct resample_group *group)
{
    for (int c = 0; c < group->count; c++) {
        const struct weft_image_channel *from =
            &job->image.channels[job->source[group->channel[c]]];
        const uint64_t rounded = group->rounded[c];
        if (rounded && !group->exact)
            report_warning("%s: %llu of its integers are no floats and are rounded before they "
                           "are filtered; --kernel nearest, without passes, keeps them",
                           from->name, (unsigned long long)rounded);
        else if (rounded && result_channel(job, group)->type != WEFT_PIXEL_UINT)
            report_warning("%s: %llu of its integers are no floats and are rounded", from->name,
                           (unsigned long long)rounded);
    }
}

void resample_warn_of_rounding(const struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++)
        warn_of_group(job, &job->group[g]);
}

// uint is kept where it is exact; filtered it has fractions.
static enum weft_pixel_type result_type(const struct resample_job *job, bool exact,
                                        enum weft_pixel_type from)
{
    const struct option_value *type = &job->option[RESAMPLE_TYPE];
    if (type->given)
        return (enum weft_pixel_type)type->integer[0];
    return from == WEFT_PIXEL_UINT && !exact ? WEFT_PIXEL_FLOAT : from;
}

void resample_set_types(struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++) {
        struct resample_group *group = &job->group[g];
        group->exact = job->separable && source_channel(job, group)->type == WEFT_PIXEL_UINT &&
                       weft_resample_moves(&job->kernel);
        for (int c = 0; c < group->count; c++) {
            struct weft_image_channel *channel = &job->result.channels[group->channel[c]];
            channel->type = result_type(job, group->exact, channel->type);
        }
    }
}

enum weft_result resample_allocate(struct resample_job *job)
{
    const size_t pixels = (size_t)job->result.width * (size_t)job->result.height;
    for (size_t g = 0; g < job->group_count; g++) {
        for (int c = 0; c < job->group[g].count; c++) {
            struct weft_image_channel *channel = &job->result.channels[job->group[g].channel[c]];
            const bool integers = channel->type == WEFT_PIXEL_UINT || job->group[g].exact;
            channel->plane = malloc(pixels * sizeof *channel->plane);
            channel->integers = integers ? malloc(pixels * sizeof *channel->integers) : NULL;
            if (channel->plane && (channel->integers || !integers))
                continue;
            report_error("out of memory: %zu bytes for %zu channels of %d x %d pixels",
                         pixels * sizeof(float) * job->result.channel_count,
                         job->result.channel_count, job->result.width, job->result.height);
            return WEFT_ERR_MEMORY;
        }
    }
    return WEFT_OK;
}

// ---- rounding to integers -----------------------------------------------------------------------

uint64_t resample_round_plane(const float *plane, size_t count, uint32_t *out)
{
    uint64_t lost = 0;
    for (size_t i = 0; i < count; i++) {
        const double whole = nearbyint((double)plane[i]);
        const bool fits = whole >= 0.0 && whole <= UINT32_MAX;
        lost += !fits;
        out[i] = fits ? (uint32_t)whole : whole > 0.0 ? UINT32_MAX : 0;
    }
    return lost;
}

void resample_round_integers(struct resample_job *job)
{
    const size_t count = (size_t)job->result.width * (size_t)job->result.height;
    for (size_t g = 0; g < job->group_count; g++) {
        for (int c = 0; c < job->group[g].count; c++) {
            struct weft_image_channel *channel = &job->result.channels[job->group[g].channel[c]];
            if (channel->type != WEFT_PIXEL_UINT || job->group[g].exact)
                continue;
            const uint64_t lost =
                channel->plane ? resample_round_plane(channel->plane, count, channel->integers)
                               : job->divided.lost[job->group[g].channel[c]];
            if (lost)
                report_warning("%s: %llu values are negative, too large or not finite: as uint "
                               "they become 0 or %u",
                               channel->name, (unsigned long long)lost, UINT32_MAX);
        }
    }
}
