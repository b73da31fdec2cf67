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

// uint is kept where it is exact; filtered it has fractions. Light of 8 bits is within halves, that
// of 16 is not.
static enum weft_pixel_type result_type(const struct resample_job *job, bool exact,
                                        enum weft_pixel_type from)
{
    const struct option_value *type = &job->option[RESAMPLE_TYPE];
    if (type->given)
        return (enum weft_pixel_type)type->integer[0];
    if (from == WEFT_PIXEL_UINT && !exact)
        from = WEFT_PIXEL_FLOAT;
    switch (job->kind) {
    case WEFT_IMAGE_FILE_PNG:
        return from == WEFT_PIXEL_UNORM16 ? from : WEFT_PIXEL_UNORM8;
    case WEFT_IMAGE_FILE_TIFF:
        return from;
    default:
        return from == WEFT_PIXEL_UNORM8    ? WEFT_PIXEL_HALF
               : from == WEFT_PIXEL_UNORM16 ? WEFT_PIXEL_FLOAT
                                            : from;
    }
}

// A TIFF file has one type.
static void unite_types(struct resample_job *job)
{
    bool same = true;
    for (size_t c = 1; c < job->result.channel_count; c++)
        same = same && job->result.channels[c].type == job->result.channels[0].type;
    for (size_t c = 0; !same && c < job->result.channel_count; c++)
        job->result.channels[c].type = WEFT_PIXEL_FLOAT;
}

// Area averages of a smaller image, and a border's value, are no integers.
static bool moves_integers(const struct resample_job *job)
{
    const bool smaller = job->map[0].from > job->map[0].to || job->map[1].from > job->map[1].to;
    return weft_resample_moves(&job->kernel) && job->boundary != WEFT_BOUNDARY_BORDER &&
           (resample_is_unstretched(job) || job->kernel.info->moves || !smaller);
}

// As the input has them; mip levels are made anew, and come in tiles.
static void set_tiles(struct resample_job *job)
{
    const struct weft_image *in = &job->image;
    struct weft_image *out = &job->result;
    const bool exr = job->kind == WEFT_IMAGE_FILE_EXR;
    const bool mip = exr && (job->option[RESAMPLE_MIP].given ||
                             (in->tiled && in->levels != WEFT_IMAGE_LEVELS_ONE));
    out->tiled = (in->tiled || mip) && job->kind != WEFT_IMAGE_FILE_PNG;
    for (int a = 0; a < 2; a++)
        out->tile[a] = in->tiled ? in->tile[a] : 0;
    out->levels = mip ? WEFT_IMAGE_LEVELS_MIP : WEFT_IMAGE_LEVELS_ONE;
}

void resample_set_types(struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++) {
        struct resample_group *group = &job->group[g];
        group->exact = job->separable && source_channel(job, group)->type == WEFT_PIXEL_UINT &&
                       moves_integers(job);
        for (int c = 0; c < group->count; c++) {
            struct weft_image_channel *channel = &job->result.channels[group->channel[c]];
            channel->type = result_type(job, group->exact, channel->type);
        }
    }
    if (job->kind == WEFT_IMAGE_FILE_TIFF)
        unite_types(job);
    set_tiles(job);
}

// ---- kinds of files -----------------------------------------------------------------------------

static enum weft_result check_type(const struct resample_job *job)
{
    const struct option_value *type = &job->option[RESAMPLE_TYPE];
    const char *kind = weft_image_file_kind_names[job->kind];
    const bool code = type->given && (enum weft_pixel_type)type->integer[0] >= WEFT_PIXEL_UNORM8;
    if (!type->given || job->kind == WEFT_IMAGE_FILE_TIFF ||
        code == (job->kind == WEFT_IMAGE_FILE_PNG))
        return WEFT_OK;
    report_error("--type %s: a file of %s has channels of %s", type->text, kind,
                 code ? "float, half or uint" : "unorm8 or unorm16");
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_compression(const struct resample_job *job)
{
    const struct option_value *given = &job->option[RESAMPLE_COMPRESSION];
    const enum weft_image_compression asked = (unsigned)given->integer[0];
    if (!given->given || job->kind == WEFT_IMAGE_FILE_EXR ||
        (job->kind == WEFT_IMAGE_FILE_TIFF &&
         (asked == WEFT_IMAGE_ZIP || asked == WEFT_IMAGE_RLE || asked == WEFT_IMAGE_NONE)))
        return WEFT_OK;
    report_error("--compression %s: %s", given->text,
                 job->kind == WEFT_IMAGE_FILE_PNG ? "PNG has one of its own"
                                                  : "TIFF is written as zip, rle or none");
    return WEFT_ERR_ARGUMENT;
}

enum weft_result resample_choose_kind(struct resample_job *job)
{
    const struct option_value *output = &job->option[RESAMPLE_OUTPUT];
    // Devices have names without an ending, and are given EXR.
    if (output->given && !weft_image_file_kind_find(output->text, &job->kind))
        job->kind = WEFT_IMAGE_FILE_EXR;
    if (job->option[RESAMPLE_MIP].given && job->kind != WEFT_IMAGE_FILE_EXR) {
        report_error("--mip: a %s file has no levels", weft_image_file_kind_names[job->kind]);
        return WEFT_ERR_ARGUMENT;
    }
    const enum weft_result res = check_type(job);
    return res == WEFT_OK ? check_compression(job) : res;
}

enum weft_result resample_check_parts(const struct resample_job *job, size_t count)
{
    if (count < 2 || job->kind != WEFT_IMAGE_FILE_PNG)
        return WEFT_OK;
    report_error("%s has %zu parts, and a PNG file one: --part says which", job->input, count);
    return WEFT_ERR_ARGUMENT;
}

struct weft_transfer resample_transfer(const struct resample_job *job)
{
    static const enum weft_curve curves[] = {WEFT_CURVE_AUTO, WEFT_CURVE_SRGB, WEFT_CURVE_LINEAR};
    const struct option_value *asked = &job->option[RESAMPLE_TRANSFER];
    return (struct weft_transfer){.curve = curves[asked->given ? asked->integer[0] : 0]};
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
