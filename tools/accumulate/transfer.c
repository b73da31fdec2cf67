// SPDX-License-Identifier: BSD-3-Clause
// Frames as light with associated alpha: what EXR files have, and what codes of PNG and TIFF files
// stand for.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"

// ---- curves -------------------------------------------------------------------------------------

static bool is_code(const struct weft_plane *plane)
{
    return plane->type == WEFT_PLANE_UNORM8 || plane->type == WEFT_PLANE_UNORM16;
}

static enum weft_result curve_of_codes(struct accumulate_job *job,
                                       const struct weft_image_frame *frame,
                                       struct weft_transfer *out)
{
    const struct weft_code_info *codes = &frame->codes;
    const bool points = codes->cicp[0] || codes->cicp[1] || codes->cicp[2] || codes->cicp[3];
    if (!weft_transfer_find(codes, out)) {
        report_error("%s has the transfer function %d of H.273 (cICP), which weft does not know: "
                     "--transfer must say what its codes are",
                     frame->name, codes->cicp[1]);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (!points && codes->icc && !job->decoder.told_profile) {
        report_warning("%s has an ICC profile, which is not applied: its codes are taken for %s "
                       "(--transfer says otherwise)",
                       frame->name,
                       codes->gamma > 0.0 && !codes->srgb ? "a power of light" : "sRGB");
        job->decoder.told_profile = true;
    }
    return WEFT_OK;
}

static enum weft_result choose_curve(struct accumulate_job *job,
                                     const struct weft_image_frame *frame,
                                     struct weft_transfer *out)
{
    *out = job->request.transfer;
    if (out->curve != WEFT_CURVE_AUTO)
        return WEFT_OK;
    if (is_code(&frame->plane[0]))
        return curve_of_codes(job, frame, out);
    out->curve = WEFT_CURVE_LINEAR;
    return WEFT_OK;
}

const char *accumulate_transfer_text(const struct weft_transfer *transfer,
                                     char text[ACCUMULATE_TEXT])
{
    snprintf(text, ACCUMULATE_TEXT, "%s",
             transfer->curve == WEFT_CURVE_SRGB ? "sRGB" : "linear light");
    if (transfer->curve == WEFT_CURVE_POWER)
        snprintf(text, ACCUMULATE_TEXT, "code ^ %.5g", transfer->exponent);
    return text;
}

// ---- planes -------------------------------------------------------------------------------------

static enum weft_result make_room(struct accumulate_job *job)
{
    struct accumulate_decoder *d = &job->decoder;
    const size_t width = (size_t)job->image.width, pixels = width * (size_t)job->image.height;
    if (!d->decoded)
        d->decoded = malloc((size_t)job->averaged_count * pixels * sizeof *d->decoded);
    if (!d->alpha)
        d->alpha = malloc(width * sizeof *d->alpha);
    if (!d->table)
        d->table = malloc(65536 * sizeof *d->table);
    if (d->decoded && d->alpha && d->table)
        return WEFT_OK;
    report_error("out of memory for a frame of %d x %d pixels", job->image.width,
                 job->image.height);
    return WEFT_ERR_MEMORY;
}

// Each rounded once.
static void fill_table(struct accumulate_decoder *d, const struct weft_transfer *transfer, int bits)
{
    const int largest = (1 << bits) - 1;
    if (d->table_bits == bits && d->table_of.curve == transfer->curve &&
        d->table_of.exponent == transfer->exponent)
        return;
    for (int i = 0; i <= largest; i++)
        d->table[i] = (float)weft_transfer_light(transfer, (double)i / largest);
    d->table_of = *transfer;
    d->table_bits = bits;
}

static void decode_codes(const float *table, const struct weft_plane *plane, int32_t y,
                         int32_t width, const float *alpha, float *out)
{
    const size_t step = plane->step ? plane->step : 1;
    const uint8_t *bytes = weft_plane_line(plane, y, width);
    const uint16_t *words = weft_plane_line(plane, y, width);
    for (int32_t x = 0; x < width && plane->type == WEFT_PLANE_UNORM8; x++)
        out[x] = table[bytes[(size_t)x * step]];
    for (int32_t x = 0; x < width && plane->type == WEFT_PLANE_UNORM16; x++)
        out[x] = table[words[(size_t)x * step]];
    for (int32_t x = 0; x < width && alpha; x++)
        out[x] *= alpha[x];
}

// Files whose colours are multiplied by alpha are so after they were coded, where they are no
// light.
static void decode_associated(const struct weft_transfer *transfer, const struct weft_plane *plane,
                              int32_t y, int32_t width, const float *alpha, float *out)
{
    weft_plane_row(plane, y, width, out, 1);
    for (int32_t x = 0; x < width; x++) {
        const double a = alpha && alpha[x] > 0.0f && isfinite(alpha[x]) ? (double)alpha[x] : 1.0;
        out[x] = (float)(a * weft_transfer_light(transfer, (double)out[x] / a));
    }
}

// Light as it is, to be multiplied.
static void decode_light(const struct weft_plane *plane, int32_t y, int32_t width,
                         const float *alpha, float *out)
{
    weft_plane_row(plane, y, width, out, 1);
    for (int32_t x = 0; x < width; x++)
        out[x] *= alpha[x];
}

// `associates`: colours are multiplied by alpha here, not in the file.
static void decode_plane(struct accumulate_job *job, const struct weft_transfer *transfer,
                         const struct weft_plane *plane, const struct weft_plane *alpha,
                         bool associates, float *out)
{
    struct accumulate_decoder *d = &job->decoder;
    const int32_t width = job->image.width;
    if (is_code(plane))
        fill_table(d, transfer, plane->type == WEFT_PLANE_UNORM8 ? 8 : 16);
    for (int32_t y = 0; y < job->image.height; y++, out += width) {
        if (alpha)
            weft_plane_row(alpha, y, width, d->alpha, 1);
        if (is_code(plane) && (associates || !alpha))
            decode_codes(d->table, plane, y, width, alpha ? d->alpha : NULL, out);
        else if (associates)
            decode_light(plane, y, width, d->alpha, out);
        else
            decode_associated(transfer, plane, y, width, alpha ? d->alpha : NULL, out);
    }
}

enum weft_result accumulate_decode(struct accumulate_job *job, const struct weft_image_frame *frame)
{
    const size_t pixels = (size_t)job->image.width * (size_t)job->image.height;
    struct weft_transfer transfer;
    enum weft_result res = choose_curve(job, frame, &transfer);
    const bool linear = transfer.curve == WEFT_CURVE_LINEAR;
    job->transfer = transfer;
    for (size_t c = 0; res == WEFT_OK && c < job->image.channel_count; c++) {
        const struct accumulate_channel *channel = &job->channel[c];
        if (channel->averaged < 0)
            continue;
        const size_t at = accumulate_find_channel(&frame->image, job->image.channels[c].name);
        const bool associates =
            frame->codes.alpha && !frame->codes.associated && channel->alpha_of >= 0;
        struct weft_plane *out = &job->plane[channel->averaged];
        *out = frame->plane[at];
        if (channel->alpha || channel->data || (linear && !associates))
            continue;
        res = make_room(job);
        if (res != WEFT_OK)
            break;
        float *decoded = job->decoder.decoded + (size_t)channel->averaged * pixels;
        const struct weft_plane *alpha = NULL;
        if (channel->alpha_of >= 0)
            alpha = &frame->plane[accumulate_find_channel(
                &frame->image, job->image.channels[channel->alpha_of].name)];
        decode_plane(job, &transfer, &frame->plane[at], alpha, associates, decoded);
        *out = (struct weft_plane){.values = decoded};
    }
    return res;
}

void accumulate_clear_decoder(struct accumulate_decoder *d)
{
    free(d->table);
    free(d->decoded);
    free(d->alpha);
}
