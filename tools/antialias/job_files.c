// SPDX-License-Identifier: BSD-3-Clause
// The files of `weft antialias`: their names, and what is written.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/attributes.h"
#include "tools/common/numbered.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"

static const struct {
    enum antialias_option option;
    const char *name;
} outputs[] = {{ASK_OUTPUT, "-o"}, {ASK_PREVIEW, "--preview"}, {ASK_WEIGHT_MAP, "--weight-map"}};
enum { OUTPUTS = sizeof outputs / sizeof *outputs };

const char *const antialias_map_endings[] = {".exr", ".png", NULL};

// ---- names --------------------------------------------------------------------------------------

enum weft_result antialias_job_name(const struct antialias_job *job, enum antialias_option output,
                                    int frame, char **out)
{
    const struct option_value *o = &job->option[output];
    *out = NULL;
    if (!o->given)
        return WEFT_OK;
    *out = job->option[ASK_FRAMES].given && numbered_is(o->text) ? numbered_format(o->text, frame)
                                                                 : strdup(o->text);
    if (*out)
        return WEFT_OK;
    report_error("out of memory for the name of picture %d", frame);
    return WEFT_ERR_MEMORY;
}

// Names of several pictures have a number.
static enum weft_result check_numbered(const struct antialias_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < OUTPUTS && res == WEFT_OK; i++) {
        const struct option_value *o = &job->option[outputs[i].option];
        char name[32];
        snprintf(name, sizeof name, "%s ", outputs[i].name);
        if (o->given && job->frames > 1)
            res = numbered_check(name, o->text, true);
    }
    return res;
}

// Moves the names of a picture into the list, and looks at them alone.
static enum weft_result check_frame(const struct antialias_job *job, int frame,
                                    struct numbered_file *list, size_t *count)
{
    const struct option_value *o = job->option;
    const char *const input[] = {o[ASK_SCENES + SCENE_OPTION_KEYFRAMES].text, job->scene_name};
    struct paths_output output[OUTPUTS];
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < OUTPUTS && res == WEFT_OK; i++) {
        char *name;
        res = antialias_job_name(job, outputs[i].option, frame, &name);
        output[i] = (struct paths_output){outputs[i].name, name};
        if (name)
            list[(*count)++] = (struct numbered_file){.path = name, .frame = frame};
    }
    if (res == WEFT_OK)
        res = paths_check_distinct(output, OUTPUTS, input, 2);
    for (int i = 0; i < OUTPUTS && res == WEFT_OK && !o[ASK_EXPLAIN].given; i++)
        if (output[i].path)
            res = paths_check_output(output[i].path, o[ASK_NO_CLOBBER].given);
    return res;
}

enum weft_result antialias_job_check_outputs(struct antialias_job *job)
{
    enum weft_result res = check_numbered(job);
    if (res != WEFT_OK)
        return res;
    struct numbered_file *list = calloc(OUTPUTS * (size_t)job->frames, sizeof *list);
    if (!list) {
        report_error("out of memory for the names of %d pictures", job->frames);
        return WEFT_ERR_MEMORY;
    }
    size_t count = 0;
    for (int frame = 0; frame < job->frames && res == WEFT_OK; frame++)
        res = check_frame(job, frame, list, &count);
    if (res == WEFT_OK)
        res = numbered_check_files(list, count);
    for (size_t i = 0; i < count; i++)
        free(list[i].path);
    free(list);
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static enum weft_result save_picture(struct antialias_job *job, const char *path, int frame)
{
    const struct option_value *o = job->option;
    struct picture *picture = &job->picture;
    for (int c = 0; c < PICTURE_CHANNELS; c++)
        picture->channel[c].type = (enum weft_pixel_type)o[ASK_TYPE].integer[0];
    picture->image.compression = (enum weft_image_compression)o[ASK_COMPRESSION].integer[0];
    picture_set_attributes(picture, antialias_job_attributes(job, NULL, frame, picture->text));
    return saved_write(&picture->image, path, o[ASK_NO_CLOBBER].given, 0, &picture->saved);
}

static enum weft_result save_preview(struct antialias_job *job, const char *path)
{
    struct preview_options options = antialias_job_preview(job);
    char title[ANNOTATION_TEXT], caption[ANNOTATION_TEXT];
    struct annotation annotation;
    options.preview = path;
    snprintf(title, sizeof title, "%.300s", paths_base_name(job->scene_name));
    snprintf(caption, sizeof caption, "%s, %d sample%s, %d x %d pixels",
             antialias_way_names[job->params.way], job->report.samples,
             job->report.samples == 1 ? "" : "s", job->params.size[0], job->params.size[1]);
    if (preview_annotate(&options, title, caption, &annotation))
        options.annotation = &annotation;
    return picture_save_preview(&job->picture, &options, 0, job->preview_range);
}

// Weights of 0 to 2 as codes: what is whole is mid grey.
static enum weft_result save_map_png(const struct antialias_job *job, const char *path)
{
    report_stage("writing", path);
    return weft_preview_save(
        weft_preview_params(.path = path, .no_clobber = job->option[ASK_NO_CLOBBER].given,
                            .width = job->params.size[0], .height = job->params.size[1],
                            .plane = job->weight, .low = 0.0f, .high = 2.0f, .log = report_log()),
        NULL);
}

static enum weft_result save_map_exr(struct antialias_job *job, const char *path, int frame)
{
    const int *size = job->params.size;
    struct weft_image_channel channel = {.name = "weight", .plane = job->weight};
    struct weft_metadata text[PICTURE_ATTRIBUTES];
    struct weft_image_attribute attribute[PICTURE_ATTRIBUTES];
    const size_t count =
        antialias_job_attributes(job, "weight of each pixel as a share of the whole", frame, text);
    attributes_of_texts(text, count, attribute);
    const struct weft_image image = {
        .width = size[0],
        .height = size[1],
        .display_max = {size[0] - 1, size[1] - 1},
        .channel_count = 1,
        .channels = &channel,
        .compression = (enum weft_image_compression)job->option[ASK_COMPRESSION].integer[0],
        .attribute_count = count,
        .attributes = attribute};
    return saved_write(&image, path, job->option[ASK_NO_CLOBBER].given, 0, &job->weight_saved);
}

static enum weft_result save(struct antialias_job *job, enum antialias_option option, int frame,
                             const char *path)
{
    if (option == ASK_OUTPUT)
        return save_picture(job, path, frame);
    if (option == ASK_PREVIEW)
        return save_preview(job, path);
    return job->option[ASK_WEIGHT_MAP].integer[0] == 1 ? save_map_png(job, path)
                                                       : save_map_exr(job, path, frame);
}

enum weft_result antialias_job_save(struct antialias_job *job, int frame)
{
    const double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < OUTPUTS && res == WEFT_OK; i++) {
        char *path;
        res = antialias_job_name(job, outputs[i].option, frame, &path);
        if (path)
            res = save(job, outputs[i].option, frame, path);
        if (path && res == WEFT_OK)
            json_add_output(path);
        free(path);
    }
    job->seconds.write += report_now_seconds() - start;
    return res;
}
