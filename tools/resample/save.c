// SPDX-License-Identifier: BSD-3-Clause
// The file of `weft resample`: attributes, compression, what is not kept.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/resample/job.h"

// A profile says what codes stand for; light has none.
static size_t drop_profile(struct weft_image_attribute *list, size_t count)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (strcmp(list[i].type, "icc"))
            list[kept++] = list[i];
    return kept;
}

// What the result's codes stand for: as the input's, or as --transfer has it.
static void choose_codes(struct resample_job *job)
{
    const struct weft_image *in = &job->image;
    const struct weft_transfer asked = resample_transfer(job);
    const bool codes =
        in->channels[0].type == WEFT_PIXEL_UNORM8 || in->channels[0].type == WEFT_PIXEL_UNORM16;
    job->result.codes = in->codes;
    job->result.transfer = codes ? in->transfer : asked;
    if (codes && asked.curve == WEFT_CURVE_SRGB) { // whatever the file says
        job->result.codes.srgb = false;
        job->result.codes.gamma = 0.0;
        memset(job->result.codes.cicp, 0, sizeof job->result.codes.cicp);
    }
}

// The input's attributes, corrected, then our own.
static enum weft_result make_attributes(struct resample_job *job)
{
    const struct weft_image *in = &job->image;
    const double scale[2] = {(double)job->map[0].to / (double)job->map[0].from,
                             (double)job->map[1].to / (double)job->map[1].from};
    struct weft_image_attribute *list =
        calloc(in->attribute_count + 1 + RESAMPLE_ATTRIBUTES, sizeof *list);
    job->texts = calloc(RESAMPLE_ATTRIBUTES, sizeof *job->texts);
    job->result.attributes = list;
    if (!list || !job->texts) {
        report_error("out of memory for %zu attributes", in->attribute_count);
        return WEFT_ERR_MEMORY;
    }
    size_t kept = attributes_scaled(in, scale, list, job->corrected);
    if (job->kind == WEFT_IMAGE_FILE_EXR)
        kept = drop_profile(list, kept);
    const size_t own = resample_attributes(job, job->texts);
    attributes_of_texts(job->texts, own, list + kept);
    job->result.attribute_count = kept + own;
    memcpy(job->result.name, in->name, sizeof in->name);
    return WEFT_OK;
}

static bool is_kept(const struct resample_job *job)
{
    const enum weft_image_compression from = job->image.compression;
    return job->kind == WEFT_IMAGE_FILE_EXR ? weft_image_is_writable(from)
                                            : from == WEFT_IMAGE_ZIP || from == WEFT_IMAGE_RLE ||
                                                  from == WEFT_IMAGE_NONE || from == WEFT_IMAGE_LZW;
}

void resample_choose_compression(struct resample_job *job)
{
    const struct option_value *given = &job->option[RESAMPLE_COMPRESSION];
    job->result.compression = given->given   ? (unsigned)given->integer[0]
                              : is_kept(job) ? job->image.compression
                                             : WEFT_IMAGE_ZIP;
}

__attribute__((format(printf, 3, 4))) static void add_loss(char *text, size_t size,
                                                           const char *format, ...)
{
    const size_t used = strlen(text);
    va_list args;
    va_start(args, format);
    snprintf(text + used, size - used, "%s", used ? "; " : "");
    vsnprintf(text + strlen(text), size - strlen(text), format, args);
    va_end(args);
}

static bool has_windows(const struct weft_image *image)
{
    return image->x != image->display_min[0] || image->y != image->display_min[1] ||
           image->x + image->width - 1 != image->display_max[0] ||
           image->y + image->height - 1 != image->display_max[1];
}

// All that the file cannot keep, in one line.
static void warn_of_losses(const struct resample_job *jobs, size_t count)
{
    char text[900] = "";
    for (size_t i = 0; i < count; i++) {
        const struct weft_image *in = &jobs[i].image;
        const char *part = count > 1 ? in->name : "", *space = count > 1 ? " of " : "";
        if (!jobs[i].option[RESAMPLE_COMPRESSION].given && !is_kept(&jobs[i]) &&
            in->kind == jobs->kind)
            add_loss(text, sizeof text, "compression %s%s%.64s (zip is written)",
                     weft_image_compression_names[in->compression], space, part);
        if (jobs->kind == WEFT_IMAGE_FILE_EXR && weft_image_find(in, "ICCProfile"))
            add_loss(text, sizeof text, "the ICC profile%s%.64s", space, part);
        if (jobs->kind != WEFT_IMAGE_FILE_EXR && has_windows(&jobs[i].result))
            add_loss(text, sizeof text, "the display window%s%.64s (the data window is written)",
                     space, part);
        if (in->tiled && in->levels == WEFT_IMAGE_LEVELS_RIP && jobs->kind == WEFT_IMAGE_FILE_EXR)
            add_loss(text, sizeof text, "rip levels%s%.64s (mip levels are written)", space, part);
    }
    if (*text)
        report_warning("%s: not kept: %s", jobs->input, text);
}

// What ranks packed, part after part.
static enum weft_result give_band(void *priv, int line, struct weft_bytes *out)
{
    struct resample_divided *d = priv;
    (void)line;
    if (d->bands_given < d->band_count)
        *out = d->bands[d->bands_given++];
    return WEFT_OK;
}

// Parts of an EXR file have names that differ; those of a TIFF file may have none.
static void name_part(const struct weft_image *before, size_t i, size_t count,
                      struct resample_job *job)
{
    char *name = job->result.name;
    bool is_new = *name != '\0';
    for (size_t k = 0; is_new && k < i; k++)
        is_new = strcmp(before[k].name, name) != 0;
    if (!is_new && count > 1 && job->kind == WEFT_IMAGE_FILE_EXR &&
        job->image.kind != WEFT_IMAGE_FILE_EXR)
        snprintf(name, sizeof job->result.name, "part %d", job->part);
}

enum weft_result resample_save(struct resample_job *jobs, size_t count)
{
    const struct weft_image_save_params params = {
        .path = jobs->option[RESAMPLE_OUTPUT].text,
        .kind = jobs->kind,
        .no_clobber = jobs->option[RESAMPLE_NO_CLOBBER].given,
        .verify = jobs->option[RESAMPLE_VERIFY].given,
        .threads = jobs->engine.cpu.threads,
        .packed = jobs->divided.bands ? give_band : NULL,
        .packed_priv = &jobs->divided,
        .progress = report_writing(jobs->option[RESAMPLE_OUTPUT].text),
        .log = report_log(),
    };
    struct weft_image *parts = calloc(count, sizeof *parts);
    enum weft_result res = parts ? WEFT_OK : WEFT_ERR_MEMORY;
    for (size_t i = 0; res == WEFT_OK && i < count; i++) {
        resample_choose_compression(&jobs[i]);
        resample_round_integers(&jobs[i]);
        choose_codes(&jobs[i]);
        res = resample_make_mips(&jobs[i]);
        if (res != WEFT_OK)
            break;
        res = make_attributes(&jobs[i]);
        name_part(parts, i, count, &jobs[i]);
        parts[i] = jobs[i].result; // borrowed
    }
    if (res == WEFT_OK) {
        warn_of_losses(jobs, count);
        res = weft_image_save_parts(parts, count, &params, &jobs->saved);
        jobs->saved.overflows += jobs->divided.packing.overflows;
        jobs->saved.rounding = fmax(jobs->saved.rounding, jobs->divided.packing.rounding);
    }
    if (res == WEFT_OK)
        saved_warn(params.path, &jobs->saved);
    free(parts);
    return res;
}
