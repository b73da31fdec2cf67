// SPDX-License-Identifier: BSD-3-Clause
// What the frames of `weft accumulate` have in common: windows, and channels, of which those that
// hold no colour are copied.
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/parts.h"
#include "tools/common/report.h"

// ---- channels that hold no colour ---------------------------------------------------------------

// Parts of names, between dots, that say so; case and '_' do not matter.
static const char *const data_names[] = {
    "z",          "zback",         "depth",       "zdepth", "id",          "ids",
    "objectid",   "materialid",    "primitiveid", "primid", "instanceid",  "assetid",
    "indexob",    "indexma",       "facing",      "motion", "motionvec",   "motionvector",
    "motionvecs", "motionvectors", "velocity",    "vector", "vectors",     "mv",
    "mvec",       "forward",       "backward",    "flow",   "opticalflow", NULL};

static bool same_word(const char *name, size_t length, const char *word)
{
    for (size_t i = 0; i < length; i++)
        if (name[i] != '_' && (!*word || tolower((unsigned char)name[i]) != *word++))
            return false;
    return !*word;
}

static bool begins_with(const char *name, size_t length, const char *word)
{
    const size_t size = strlen(word);
    return length >= size && strncasecmp(name, word, size) == 0;
}

static bool is_data_word(const char *name, size_t length)
{
    for (int i = 0; data_names[i]; i++)
        if (same_word(name, length, data_names[i]))
            return true;
    return begins_with(name, length, "crypto");
}

size_t accumulate_find_channel(const struct weft_image *image, const char *name)
{
    size_t c = 0;
    while (c < image->channel_count && strcmp(image->channels[c].name, name) != 0)
        c++;
    return c;
}

// The length of a name's layer with its dot.
static size_t layer_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot ? (size_t)(dot - name) + 1 : 0;
}

// Whether there is another channel in the same layer.
static size_t find_beside(const struct weft_image *image, size_t channel, const char *last)
{
    char name[600];
    const char *of = image->channels[channel].name;
    snprintf(name, sizeof name, "%.*s%s", (int)layer_length(of), of, last);
    return accumulate_find_channel(image, name);
}

// Layers that a Cryptomatte manifest of the file names: "cryptomatte/1234567/name".
static bool is_cryptomatte(const struct weft_image *image, const char *name)
{
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        const size_t length = strlen(a->name);
        if (strncmp(a->name, "cryptomatte/", 12) == 0 && strcmp(a->type, "string") == 0 &&
            length > 5 && strcmp(a->name + length - 5, "/name") == 0 && a->size > 0 &&
            strncmp(name, a->data, a->size) == 0)
            return true;
    }
    return false;
}

bool accumulate_is_data(const struct weft_image *image, size_t channel)
{
    const char *name = image->channels[channel].name, *last = name + layer_length(name);
    if (image->channels[channel].type == WEFT_PIXEL_UINT || is_cryptomatte(image, name))
        return true;
    const size_t none = image->channel_count;
    const bool coordinate = same_word(last, strlen(last), "z") &&
                            find_beside(image, channel, "X") < none &&
                            find_beside(image, channel, "Y") < none;
    for (const char *at = name; at < last;) {
        const size_t length = strcspn(at, ".");
        if (is_data_word(at, length))
            return true;
        if (same_word(at, length, "mist")) // a share of the pixel, as Blender has it
            return false;
        at += length + 1;
    }
    return !coordinate && is_data_word(last, strlen(last));
}

// ---- the first frame ----------------------------------------------------------------------------

// Attributes with all that they point to, in one allocation; as struct weft_image owns them.
static bool copy_attributes(const struct weft_image *from, struct weft_image *to)
{
    size_t bytes = from->attribute_count * sizeof *from->attributes;
    for (size_t i = 0; i < from->attribute_count; i++)
        bytes += strlen(from->attributes[i].name) + strlen(from->attributes[i].type) + 2 +
                 from->attributes[i].size;
    to->attributes = malloc(bytes + 1);
    char *at = (char *)(to->attributes + from->attribute_count);
    for (size_t i = 0; to->attributes && i < from->attribute_count; i++) {
        const struct weft_image_attribute *a = &from->attributes[i];
        to->attributes[i] = (struct weft_image_attribute){.size = a->size};
        to->attributes[i].name = strcpy(at, a->name);
        at += strlen(a->name) + 1;
        to->attributes[i].type = strcpy(at, a->type);
        at += strlen(a->type) + 1;
        to->attributes[i].data = memcpy(at, a->data, a->size);
        at += a->size;
    }
    return to->attributes != NULL;
}

static bool copy_image(const struct weft_image *from, struct weft_image *to)
{
    *to = *from;
    to->channels = calloc(from->channel_count, sizeof *to->channels);
    const bool whole = copy_attributes(from, to) && to->channels;
    if (!to->channels)
        to->channel_count = 0;
    for (size_t c = 0; whole && c < from->channel_count; c++) {
        to->channels[c] = from->channels[c];
        to->channels[c].plane = NULL;
        to->channels[c].integers = NULL;
    }
    return whole;
}

static enum weft_result take_over(struct accumulate_job *job, const struct weft_image_frame *frame)
{
    const size_t count = frame->image.channel_count;
    const bool all = job->option[ACCUMULATE_AVERAGE_ALL].given;
    job->kind = frame->kind;
    job->reference = job->joins ? job->first : job->sequence[frame->index];
    job->channel = calloc(count, sizeof *job->channel);
    job->plane = calloc(count, sizeof *job->plane);
    if (!copy_image(&frame->image, &job->image) || !job->channel || !job->plane) {
        report_error("out of memory for %zu channels and the attributes of %s", count, frame->name);
        return WEFT_ERR_MEMORY;
    }
    for (size_t c = 0; c < count; c++) {
        struct accumulate_channel *channel = &job->channel[c];
        const char *name = job->image.channels[c].name;
        const size_t alpha = find_beside(&job->image, c, "A");
        channel->alpha = strcmp(name + layer_length(name), "A") == 0;
        channel->alpha_of = alpha < count && !channel->alpha ? (int)alpha : -1;
        channel->data = accumulate_is_data(&job->image, c);
        channel->averaged = all || !channel->data ? job->averaged_count++ : -1;
        channel->widest = job->image.channels[c].type;
    }
    return WEFT_OK;
}

static enum weft_result check_channels(const struct accumulate_job *job)
{
    const char *path = job->frame[job->reference].path;
    if (job->averaged_count == 0)
        report_error("%s: no channel of %zu holds colour, so that there is nothing to average "
                     "(--average-all averages all)",
                     path, job->image.channel_count);
    else if (job->averaged_count > WEFT_ACCUMULATE_MAX_CHANNELS)
        report_error("%s has %d channels to average, at most %d can be", path, job->averaged_count,
                     WEFT_ACCUMULATE_MAX_CHANNELS);
    else
        return WEFT_OK;
    return WEFT_ERR_UNSUPPORTED;
}

// Told once, where a reader of the result would miss it.
static void tell_copied(const struct accumulate_job *job)
{
    char names[ACCUMULATE_TEXT] = "";
    int count = 0;
    for (size_t c = 0; c < job->image.channel_count; c++) {
        const size_t used = strlen(names);
        if (job->channel[c].averaged >= 0)
            continue;
        if (used + strlen(job->image.channels[c].name) + 8 < sizeof names)
            snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "",
                     job->image.channels[c].name);
        else if (strcmp(names + used - 3, "...") != 0)
            snprintf(names + used, sizeof names - used, ", ...");
        count++;
    }
    if (count)
        report_tell("copied from the first frame, not averaged: %d channel%s that hold%s no colour,"
                    " %s (--average-all averages all)",
                    count, count > 1 ? "s" : "", count > 1 ? "" : "s", names);
}

static void warn_of_parts(const struct accumulate_job *job)
{
    if (job->image.part_count > 1 && !job->option[ACCUMULATE_PART].given)
        report_warning("%s has %d parts, of which the first, '%s', is averaged (--part says which)",
                       job->frame[job->reference].path, job->image.part_count, job->image.name);
}

static const char *name_of(void *priv, int64_t i)
{
    const struct accumulate_job *job = priv;
    return job->joins ? job->substitute : job->frame[job->sequence[i]].path;
}

// Those that are named are found in the first frame.
static enum weft_result find_part(struct accumulate_job *job)
{
    const struct option_value *part = &job->option[ACCUMULATE_PART];
    const char *path = name_of(job, 0);
    struct weft_image_list list = {0};
    size_t found = 0;
    if (!part->given || parts_number(part->text) >= 0) {
        job->request.part = part->given ? parts_number(part->text) : 0;
        return WEFT_OK;
    }
    enum weft_result res =
        weft_image_list_load(weft_image_load_params(.path = path, .log = report_log()), &list);
    if (res == WEFT_OK)
        res = parts_find(path, &list, part->text, &found);
    job->request.part = (int)found;
    weft_image_list_clear(&list);
    return res;
}

enum weft_result accumulate_look(struct accumulate_job *job)
{
    const struct weft_image_frame *frame = NULL;
    weft_image_sequence *sequence = NULL;
    char why[sizeof frame->message] = ""; // of the first
    enum weft_result res = find_part(job);
    if (res == WEFT_OK)
        res = weft_image_sequence_create(
            weft_image_sequence_params(.count = job->joins ? 1 : job->counting, .name = name_of,
                                       .priv = job, .readers = 1, .info_only = true,
                                       .part = job->request.part, .log = report_log()),
            &sequence);
    while (res == WEFT_OK) {
        res = weft_image_sequence_next(sequence, &frame);
        if (res != WEFT_OK || !frame || frame->result == WEFT_OK)
            break;
        if (!*why)
            snprintf(why, sizeof why, "%s", frame->message);
        if (job->option[ACCUMULATE_SKIP_BAD].given)
            continue;
        report_error("%s", frame->message);
        res = frame->result;
    }
    if (res == WEFT_OK && !frame) {
        report_error("none of %lld frames can be read: %s", (long long)job->counting, why);
        res = WEFT_ERR_FORMAT;
    }
    if (res == WEFT_OK)
        res = take_over(job, frame);
    weft_image_sequence_destroy(&sequence);
    if (res == WEFT_OK)
        res = check_channels(job);
    if (res == WEFT_OK) {
        warn_of_parts(job);
        tell_copied(job);
    }
    return res;
}

// ---- the others ---------------------------------------------------------------------------------

static enum weft_result fail_kind(const struct accumulate_job *job,
                                  const struct weft_image_frame *frame)
{
    report_error("%s is %s, and %s is %s: all frames must be of one kind, as %s", frame->name,
                 weft_image_file_kind_names[frame->kind], job->frame[job->reference].path,
                 weft_image_file_kind_names[job->kind],
                 "EXR is linear light with associated alpha, and PNG is neither");
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result match_windows(const struct accumulate_job *job,
                                      const struct weft_image_frame *frame)
{
    const struct weft_image *a = &job->image, *b = &frame->image;
    const char *first = job->frame[job->reference].path;
    if (a->width != b->width || a->height != b->height)
        report_error("%s has %d x %d pixels, and %s %d x %d", frame->name, b->width, b->height,
                     first, a->width, a->height);
    else if (a->x != b->x || a->y != b->y)
        report_error("%s has a data window from (%d, %d), and %s from (%d, %d)", frame->name, b->x,
                     b->y, first, a->x, a->y);
    else if (memcmp(a->display_min, b->display_min, sizeof a->display_min) != 0 ||
             memcmp(a->display_max, b->display_max, sizeof a->display_max) != 0)
        report_error("%s has the display window (%d, %d) to (%d, %d), and %s (%d, %d) to (%d, %d)",
                     frame->name, b->display_min[0], b->display_min[1], b->display_max[0],
                     b->display_max[1], first, a->display_min[0], a->display_min[1],
                     a->display_max[0], a->display_max[1]);
    else
        return WEFT_OK;
    return WEFT_ERR_FORMAT;
}

// Integers among others are floats.
enum weft_pixel_type accumulate_wider(enum weft_pixel_type a, enum weft_pixel_type b)
{
    return a == b ? a : WEFT_PIXEL_FLOAT;
}

// Names in the same order, as the format sorts them.
static enum weft_result match_channels(const struct accumulate_job *job,
                                       const struct weft_image_frame *frame)
{
    const struct weft_image *a = &job->image, *b = &frame->image;
    const char *first = job->frame[job->reference].path;
    for (size_t c = 0; c < a->channel_count; c++) {
        if (accumulate_find_channel(b, a->channels[c].name) < b->channel_count)
            continue;
        report_error("%s has no channel %s, which %s has", frame->name, a->channels[c].name, first);
        return WEFT_ERR_FORMAT;
    }
    for (size_t c = 0; c < b->channel_count; c++) {
        if (accumulate_find_channel(a, b->channels[c].name) < a->channel_count)
            continue;
        report_error("%s has a channel %s, which %s does not have", frame->name,
                     b->channels[c].name, first);
        return WEFT_ERR_FORMAT;
    }
    return WEFT_OK;
}

enum weft_result accumulate_match(const struct accumulate_job *job,
                                  const struct weft_image_frame *frame)
{
    if (frame->kind != job->kind)
        return fail_kind(job, frame);
    const enum weft_result res = match_windows(job, frame);
    return res == WEFT_OK ? match_channels(job, frame) : res;
}

void accumulate_widen(struct accumulate_job *job, const struct weft_image *image)
{
    for (size_t c = 0; c < job->image.channel_count; c++) {
        const size_t at = accumulate_find_channel(image, job->image.channels[c].name);
        job->channel[c].widest = accumulate_wider(job->channel[c].widest, image->channels[at].type);
    }
}

// Rows of integers as they are; their nearest floats are in the plane.
static void copy_integers(const struct weft_plane *from, const struct weft_image *image,
                          uint32_t *out)
{
    for (int32_t y = 0; y < image->height; y++) {
        const uint32_t *row = weft_plane_line(from, y, image->width);
        for (int32_t x = 0; x < image->width; x++)
            *out++ = row[(size_t)x * (from->step ? from->step : 1)];
    }
}

enum weft_result accumulate_copy(struct accumulate_job *job, const struct weft_image_frame *frame)
{
    const size_t width = (size_t)job->image.width, pixels = width * (size_t)job->image.height;
    for (size_t c = 0; c < job->image.channel_count; c++) {
        struct weft_image_channel *channel = &job->image.channels[c];
        const size_t at = accumulate_find_channel(&frame->image, channel->name);
        const struct weft_plane *plane = &frame->plane[at];
        if (job->channel[c].averaged >= 0 || channel->plane)
            continue;
        channel->type = frame->image.channels[at].type;
        channel->plane = malloc(pixels * sizeof *channel->plane);
        channel->integers =
            channel->type == WEFT_PIXEL_UINT ? malloc(pixels * sizeof *channel->integers) : NULL;
        if (!channel->plane || (channel->type == WEFT_PIXEL_UINT && !channel->integers)) {
            report_error("out of memory for channel %s", channel->name);
            return WEFT_ERR_MEMORY;
        }
        for (int32_t y = 0; y < job->image.height; y++)
            weft_plane_row(plane, y, job->image.width, channel->plane + (size_t)y * width, 1);
        if (channel->integers)
            copy_integers(plane, &job->image, channel->integers);
    }
    return WEFT_OK;
}

static const char *name_of_first(void *priv, int64_t i)
{
    const struct accumulate_job *job = priv;
    (void)i;
    return job->joins ? job->substitute : job->frame[job->first].path;
}

enum weft_result accumulate_copy_again(struct accumulate_job *job)
{
    const struct weft_image_frame *frame = NULL;
    weft_image_sequence *sequence = NULL;
    if (job->averaged_count == (int)job->image.channel_count)
        return WEFT_OK;
    enum weft_result res = weft_image_sequence_create(
        weft_image_sequence_params(.count = 1, .name = name_of_first, .priv = job, .readers = 1,
                                   .part = job->request.part, .log = report_log()),
        &sequence);
    if (res == WEFT_OK)
        res = weft_image_sequence_next(sequence, &frame);
    if (res == WEFT_OK && frame->result != WEFT_OK) {
        report_error("%s", frame->message);
        res = frame->result;
    }
    if (res == WEFT_OK)
        res = accumulate_match(job, frame);
    if (res == WEFT_OK)
        res = accumulate_copy(job, frame);
    weft_image_sequence_destroy(&sequence);
    return res;
}
