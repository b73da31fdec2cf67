// SPDX-License-Identifier: BSD-3-Clause
// Types of the channels of `weft resample`, and unsigned integers that are moved, not filtered.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// Where one tap of weight 1 meets every position: nearest, by whatever name.
static bool takes_one_sample(const struct weft_kernel *kernel)
{
    return kernel->width == 1 && kernel->unit_sum && !kernel->radial && !kernel->prefiltered &&
           kernel->info->derivation == 0;
}

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

// Without planes, as in an image that only informs, 0.
static uint64_t count_rounded(const struct resample_job *job,
                              const struct weft_image_channel *channel)
{
    const size_t count = (size_t)job->image.width * (size_t)job->image.height;
    uint64_t rounded = 0;
    for (size_t i = 0; channel->integers && i < count; i++)
        rounded += (double)channel->plane[i] != (double)channel->integers[i];
    return rounded;
}

static void warn_of_rounding(const struct resample_job *job, const struct resample_group *group)
{
    for (int c = 0; c < group->count; c++) {
        const struct weft_image_channel *from =
            &job->image.channels[job->source[group->channel[c]]];
        const uint64_t rounded = from->type == WEFT_PIXEL_UINT ? count_rounded(job, from) : 0;
        if (rounded && !group->exact)
            report_warning("%s: %llu of its integers are no floats and are rounded before they "
                           "are filtered; --kernel nearest, without passes, keeps them",
                           from->name, (unsigned long long)rounded);
        else if (rounded && result_channel(job, group)->type != WEFT_PIXEL_UINT)
            report_warning("%s: %llu of its integers are no floats and are rounded", from->name,
                           (unsigned long long)rounded);
    }
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
                       takes_one_sample(&job->kernel);
        for (int c = 0; c < group->count; c++) {
            struct weft_image_channel *channel = &job->result.channels[group->channel[c]];
            channel->type = result_type(job, group->exact, channel->type);
        }
        warn_of_rounding(job, group);
    }
}

bool resample_needs_gl(const struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++)
        if (!job->group[g].exact)
            return !job->option[RESAMPLE_EMULATE].given;
    return false;
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

// ---- moving integers ----------------------------------------------------------------------------

static void set_extremes(const uint32_t *values, size_t count, double *low, double *high)
{
    uint32_t least = UINT32_MAX, most = 0;
    for (size_t i = 0; i < count; i++) {
        least = values[i] < least ? values[i] : least;
        most = values[i] > most ? values[i] : most;
    }
    *low = least;
    *high = most;
}

void resample_exact_range(const struct resample_job *job, struct resample_group *group)
{
    set_extremes(source_channel(job, group)->integers,
                 (size_t)job->image.width * (size_t)job->image.height, &group->low, &group->high);
    group->sample_low = group->low;
    group->sample_high = group->high;
}

static int clamp(int64_t i, int size)
{
    return i < 0 ? 0 : i >= size ? size - 1 : (int)i;
}

// The columns or rows that the kernel takes; NULL: out of memory.
static int *find_samples(const struct resample_job *job, int axis)
{
    const int count = axis ? job->result.height : job->result.width;
    const int size = axis ? job->image.height : job->image.width;
    int *out = malloc((size_t)count * sizeof *out);
    double fraction;
    for (int i = 0; out && i < count; i++)
        out[i] = clamp(weft_kernel_first_tap(&job->kernel,
                                             resample_position(&job->place[axis], i, 0), &fraction),
                       size);
    return out;
}

static void move(const struct resample_job *job, struct resample_group *group, const int *columns,
                 const int *rows)
{
    const size_t width = (size_t)job->result.width, from_width = (size_t)job->image.width;
    const uint32_t *from = source_channel(job, group)->integers;
    struct weft_image_channel *to = result_channel(job, group);
    for (size_t y = 0; y < (size_t)job->result.height; y++)
        for (size_t x = 0; x < width; x++) {
            const uint32_t value = from[(size_t)rows[y] * from_width + (size_t)columns[x]];
            to->integers[y * width + x] = value;
            to->plane[y * width + x] = (float)value;
        }
    set_extremes(to->integers, width * (size_t)job->result.height, &group->minimum,
                 &group->maximum);
}

// The pixel of the input in whose square a pixel's centre lies, in whole numbers; of two that meet
// there, the later one.
static int square_at(const struct resample_place *p, int pixel, int size)
{
    const int64_t edge = (2 * (pixel + p->pixel) + 1) * p->from + 2 * p->sample * p->to;
    const int64_t unit = 2 * p->to;
    return clamp(edge / unit - (edge % unit < 0), size);
}

// Integers against integers: a float would hide their last bits.
static void verify(const struct resample_job *job, struct resample_group *group)
{
    const struct weft_image *in = &job->image, *out = &job->result;
    const uint32_t *from = source_channel(job, group)->integers;
    const uint32_t *to = result_channel(job, group)->integers;
    struct weft_multipass_error *error = &group->error;
    double squares = 0.0;
    for (int y = 0; y < out->height; y++) {
        const size_t row = (size_t)square_at(&job->place[1], y, in->height) * (size_t)in->width;
        for (int x = 0; x < out->width; x++) {
            const size_t at = (size_t)y * (size_t)out->width + (size_t)x;
            const size_t source = row + (size_t)square_at(&job->place[0], x, in->width);
            const double difference = fabs((double)to[at] - (double)from[source]);
            squares += difference * difference;
            if (difference <= error->maximum)
                continue;
            error->maximum = difference;
            error->at_x = x;
            error->at_y = y;
        }
    }
    error->rms = sqrt(squares / ((double)out->width * out->height));
}

enum weft_result resample_exact_run(struct resample_job *job)
{
    int *columns = find_samples(job, 0), *rows = find_samples(job, 1);
    const bool done = columns && rows;
    for (size_t g = 0; done && g < job->group_count; g++) {
        if (!job->group[g].exact)
            continue;
        move(job, &job->group[g], columns, rows);
        if (job->option[RESAMPLE_VERIFY].given)
            verify(job, &job->group[g]);
    }
    free(columns);
    free(rows);
    if (!done)
        report_error("out of memory for the positions of %d x %d pixels", job->result.width,
                     job->result.height);
    return done ? WEFT_OK : WEFT_ERR_MEMORY;
}

// ---- rounding to integers -----------------------------------------------------------------------

// To nearest, halves up to even; returns how many are none: NaN, negative or too large ones.
static uint64_t round_plane(struct weft_image_channel *channel, size_t count)
{
    uint64_t lost = 0;
    for (size_t i = 0; i < count; i++) {
        const double whole = nearbyint((double)channel->plane[i]);
        const bool fits = whole >= 0.0 && whole <= UINT32_MAX;
        lost += !fits;
        channel->integers[i] = fits ? (uint32_t)whole : whole > 0.0 ? UINT32_MAX : 0;
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
            const uint64_t lost = round_plane(channel, count);
            if (lost)
                report_warning("%s: %llu values are negative, too large or not finite: as uint "
                               "they become 0 or %u",
                               channel->name, (unsigned long long)lost, UINT32_MAX);
        }
    }
}
