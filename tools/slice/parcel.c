// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/parcel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/slice/stages.h"

// What stands first, and what behind it: texts come last, so that numbers are aligned.
enum { PIXELS, ATTRIBUTES, MESSAGES, JSON, PACKED, SECTIONS };
struct head {
    uint64_t head_bytes, bytes[SECTIONS];
    enum parcel_kind kind;
    struct weft_slice_geometry geometry;
    struct weft_slice_report report;
    struct weft_verify_report error;
    struct weft_bound bound;
    struct weft_image_save_report packing;
    double error_bound;
    double open_seconds, plan_seconds, context_seconds, verify_seconds;
    double elapsed; // since the slice was begun
    int attribute_count;
    bool by_passes, made, annotated;
    struct annotation annotation; // without a map
    char problem[sizeof((struct slice_job *)0)->problem];
};

// ---- writing ------------------------------------------------------------------------------------

enum weft_result parcel_pack_lines(const struct slice_job *job, int width, int height,
                                   const float *pixels, struct weft_image_packed *out)
{
    const struct option_value *o = job->setup->option;
    struct weft_image_channel channel = {.name = "Y",
                                         .type = (enum weft_pixel_type)o[SLICE_TYPE].integer[0],
                                         .plane = (float *)(uintptr_t)pixels};
    const struct weft_image image = {
        .width = width,
        .height = height,
        .compression = (enum weft_image_compression)o[SLICE_COMPRESSION].integer[0],
        .channel_count = 1,
        .channels = &channel,
    };
    return weft_image_pack(&image, job->setup->engine.cpu.threads, report_log(), out);
}

static enum weft_result join_sections(struct head *head, const void *const section[SECTIONS],
                                      void **data, size_t *size)
{
    head->head_bytes = sizeof *head;
    *size = sizeof *head;
    for (int i = 0; i < SECTIONS; i++)
        *size += head->bytes[i];
    char *at = *data = malloc(*size);
    if (!at) {
        report_error("out of memory: %zu bytes for what rank 0 is told", *size);
        return WEFT_ERR_MEMORY;
    }
    memcpy(at, head, sizeof *head);
    at += sizeof *head;
    for (int i = 0; i < SECTIONS; at += head->bytes[i++])
        if (head->bytes[i])
            memcpy(at, section[i], head->bytes[i]);
    return WEFT_OK;
}

static struct head head_of(const struct slice_job *job)
{
    return (struct head){
        .geometry = job->geometry,
        .report = job->report,
        .error = job->error,
        .bound = job->bound,
        .error_bound = job->error_bound,
        .open_seconds = job->open_seconds,
        .plan_seconds = job->plan_seconds,
        .context_seconds = job->context_seconds,
        .verify_seconds = job->verify_seconds,
        .elapsed = report_now_seconds() - job->start,
        .attribute_count = (int)job->attribute_count,
        .by_passes = job->by_passes,
        .made = job->made,
        .annotated = job->annotated,
        .annotation = job->annotation,
    };
}

enum weft_result parcel_write_region(const struct slice_job *job, size_t pixel_count,
                                     const float *pixels, const struct weft_image_packed *packed,
                                     void **data, size_t *size)
{
    struct head head = head_of(job);
    const void *const section[SECTIONS] = {[PACKED] = packed->data, [PIXELS] = pixels};
    head.attribute_count = 0;
    head.packing = packed->report;
    head.bytes[PACKED] = packed->size;
    head.bytes[PIXELS] = pixels ? pixel_count * sizeof *pixels : 0;
    return join_sections(&head, section, data, size);
}

enum weft_result parcel_write_slice(struct slice_job *job, enum parcel_kind kind, void **data,
                                    size_t *size)
{
    struct weft_image_packed packed = {.data = NULL};
    struct head head = head_of(job);
    const size_t pixels = (size_t)job->geometry.width * (size_t)job->geometry.height;
    const bool made = kind == PARCEL_MADE && job->made;
    const bool sends = made && slice_needs_pixels(job);
    enum weft_result res = WEFT_OK;
    head.kind = kind;
    snprintf(head.problem, sizeof head.problem, "%s", job->problem);
    char *json = job->json ? json_dumps(job->json, 0) : NULL;
    if (job->json && !json)
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK && made && slice_writes_lines(job))
        res =
            parcel_pack_lines(job, job->geometry.width, job->geometry.height, job->pixels, &packed);
    const void *const section[SECTIONS] = {[ATTRIBUTES] = job->attributes,
                                           [JSON] = json,
                                           [MESSAGES] = &job->held,
                                           [PACKED] = packed.data,
                                           [PIXELS] = job->pixels};
    head.packing = packed.report;
    head.bytes[ATTRIBUTES] = job->attribute_count * sizeof *job->attributes;
    head.bytes[JSON] = json ? strlen(json) + 1 : 0;
    head.bytes[MESSAGES] = job->held.count ? sizeof job->held : 0;
    head.bytes[PACKED] = packed.size;
    head.bytes[PIXELS] = sends ? pixels * sizeof *job->pixels : 0;
    if (res == WEFT_OK)
        res = join_sections(&head, section, data, size);
    weft_image_packed_clear(&packed);
    free(json);
    return res;
}

// ---- reading ------------------------------------------------------------------------------------

static enum weft_result split(const void *data, size_t size, struct head *head,
                              const char *section[SECTIONS])
{
    const char *at = data;
    size_t left = size;
    bool whole = size >= sizeof *head;
    if (whole)
        memcpy(head, data, sizeof *head);
    whole =
        whole && head->head_bytes == sizeof *head && head->attribute_count >= 0 &&
        head->attribute_count <= SLICE_ATTRIBUTES &&
        head->bytes[MESSAGES] <= sizeof(struct report_held) &&
        head->bytes[ATTRIBUTES] == (uint64_t)head->attribute_count * sizeof(struct weft_metadata);
    at += sizeof *head;
    left -= whole ? sizeof *head : 0;
    for (int i = 0; whole && i < SECTIONS; i++) {
        section[i] = head->bytes[i] ? at : NULL;
        whole = head->bytes[i] <= left;
        at += whole ? head->bytes[i] : 0;
        left -= whole ? head->bytes[i] : 0;
    }
    if (whole && !left)
        return WEFT_OK;
    report_error("what a rank made is not what this version of weft makes (%zu bytes)", size);
    return WEFT_ERR_FORMAT;
}

static void add_packing(const struct weft_image_save_report *one,
                        struct weft_image_save_report *sum)
{
    sum->overflows += one->overflows;
    sum->rounding = fmax(sum->rounding, one->rounding);
}

// Seconds and counts add up; what is held at once is that of the rank that holds most.
enum weft_result parcel_read_region(const void *data, size_t size, struct slice_job *job,
                                    bool known, struct parcel_region *out)
{
    struct head head;
    const char *section[SECTIONS] = {NULL};
    const enum weft_result res = split(data, size, &head, section);
    if (res != WEFT_OK)
        return res;
    out->packed = (struct weft_bytes){section[PACKED], head.bytes[PACKED]};
    out->pixels = (const float *)(const void *)section[PIXELS];
    add_packing(&head.packing, &job->packing);
    if (!known) {
        job->report = head.report;
        job->error = head.error;
        return WEFT_OK;
    }
    weft_slice_report_add(&job->report, &head.report);
    weft_verify_join(&job->error, &head.error);
    return WEFT_OK;
}

static bool copy_section(const struct head *head, const char *section, int which, void **out)
{
    *out = head->bytes[which] ? malloc(head->bytes[which]) : NULL;
    if (*out)
        memcpy(*out, section, head->bytes[which]);
    return *out || !head->bytes[which];
}

static bool take_bands(const struct head *head, const char *packed, struct slice_job *job)
{
    void *data;
    if (!head->bytes[PACKED])
        return true;
    job->bands = calloc(1, sizeof *job->bands);
    if (!job->bands || !copy_section(head, packed, PACKED, &data))
        return false;
    job->bands[0] = (struct weft_bytes){data, head->bytes[PACKED]};
    job->band_count = 1;
    job->packing = head->packing;
    return true;
}

static void take_head(const struct head *head, struct slice_job *job)
{
    job->geometry = head->geometry;
    job->report = head->report;
    job->error = head->error;
    job->bound = head->bound;
    job->error_bound = head->error_bound;
    job->open_seconds = head->open_seconds;
    job->plan_seconds = head->plan_seconds;
    job->context_seconds = head->context_seconds;
    job->verify_seconds = head->verify_seconds;
    job->start = report_now_seconds() - head->elapsed;
    job->by_passes = head->by_passes;
    job->made = head->made;
    job->annotated = head->annotated;
    job->annotation = head->annotation;
    job->annotation.colour_map = NULL;
    memcpy(job->problem, head->problem, sizeof job->problem);
}

enum weft_result parcel_read_slice(const void *data, size_t size, struct slice_job *job,
                                   enum parcel_kind *kind)
{
    struct head head;
    const char *section[SECTIONS] = {NULL};
    void *pixels = NULL;
    const enum weft_result res = split(data, size, &head, section);
    if (res != WEFT_OK)
        return res;
    *kind = head.kind;
    take_head(&head, job);
    if (section[JSON])
        job->json = json_loads(section[JSON], 0, NULL);
    if (section[MESSAGES])
        memcpy(&job->held, section[MESSAGES], sizeof job->held);
    if (section[ATTRIBUTES])
        memcpy(job->attributes, section[ATTRIBUTES], head.bytes[ATTRIBUTES]);
    job->attribute_count = (size_t)head.attribute_count;
    const bool enough = copy_section(&head, section[PIXELS], PIXELS, &pixels) &&
                        take_bands(&head, section[PACKED], job) && (!section[JSON] || job->json);
    job->pixels = pixels;
    if (enough)
        return WEFT_OK;
    report_error("out of memory: %zu bytes for what a rank made", size);
    return WEFT_ERR_MEMORY;
}
