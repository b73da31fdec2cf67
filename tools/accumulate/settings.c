// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/settings.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

// Options that decide what is accumulated.
static const struct {
    enum accumulate_option option;
    const char *name, *otherwise; // its value where it is not given; NULL: a flag
} deciding[] = {
    {ACCUMULATE_ADDING + ACCUMULATION_METHOD, "--method", "auto"},
    {ACCUMULATE_ADDING + ACCUMULATION_MAX_ERROR, "--max-error", "none"},
    {ACCUMULATE_ADDING + ACCUMULATION_BRANCHING, "--branching", "none"},
    {ACCUMULATE_ADDING + ACCUMULATION_ROUNDING, "--rounding", "none"},
    {ACCUMULATE_ADDING + ACCUMULATION_BITS, "--bits", "none"},
    {ACCUMULATE_ADDING + ACCUMULATION_SOURCE_RANGE, "--source-range", "none"},
    {ACCUMULATE_NONFINITE, "--nonfinite", "error"},
    {ACCUMULATE_ADDING + ACCUMULATION_BATCH, "--batch", "1"},
    {ACCUMULATE_TRANSFER, "--transfer", "auto"},
    {ACCUMULATE_PART, "--part", "0"},
    {ACCUMULATE_AVERAGE_ALL, "--average-all", NULL},
};
// Options that are of frames to be read.
static const struct {
    enum accumulate_option option;
    const char *name;
} of_frames[] = {
    {ACCUMULATE_FRAMES, "--frames"},     {ACCUMULATE_WEIGHTS, "--weights"},
    {ACCUMULATE_UNTIL, "--until"},       {ACCUMULATE_EVERY, "--every"},
    {ACCUMULATE_SKIP_BAD, "--skip-bad"},
};
enum {
    DECIDING = sizeof deciding / sizeof *deciding,
    OF_FRAMES = sizeof of_frames / sizeof *of_frames
};
_Static_assert(DECIDING + 2 <= SETTINGS_MOST, "there is room for all");

static const char kept_name[] = "what is kept of frames", kept_mean[] = "their mean",
                  kept_variance[] = "their mean and variance", shape_name[] = "the frames' shape",
                  flag_given[] = "given";

// ---- words --------------------------------------------------------------------------------------

// What the frames have in common.
static char *describe_shape(const struct accumulate_job *job)
{
    const struct weft_image *image = &job->image;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fprintf(out, "%s, %" PRId32 " x %" PRId32 " pixels at (%" PRId32 ", %" PRId32 "), channels",
            weft_image_file_kind_names[job->kind], image->width, image->height, image->x, image->y);
    for (size_t c = 0; c < image->channel_count; c++)
        fprintf(out, " %s", image->channels[c].name);
    if (report_close(out))
        return text;
    free(text);
    return NULL;
}

static const char *value_of(const struct accumulate_job *job, int i)
{
    const struct option_value *value = &job->option[deciding[i].option];
    if (!deciding[i].otherwise)
        return value->given ? flag_given : "not given";
    return value->given ? value->text : deciding[i].otherwise;
}

bool settings_make(const struct accumulate_job *job, struct settings *out)
{
    *out = (struct settings){.count = DECIDING + 2, .shape = describe_shape(job)};
    for (int i = 0; i < DECIDING; i++)
        out->setting[i] = (struct state_setting){deciding[i].name, value_of(job, i)};
    out->setting[DECIDING] =
        (struct state_setting){kept_name, job->keeps_variance ? kept_variance : kept_mean};
    out->setting[DECIDING + 1] = (struct state_setting){shape_name, out->shape};
    return out->shape != NULL;
}

void settings_clear(struct settings *settings)
{
    free(settings->shape);
}

// ---- comparing ----------------------------------------------------------------------------------

const char *settings_find(const struct state_content *content, const char *name)
{
    for (size_t i = 0; i < content->setting_count; i++)
        if (strcmp(content->settings[i].name, name) == 0)
            return content->settings[i].value;
    return "nothing";
}

const struct state_setting *settings_find_other(const struct state_content *a,
                                                const struct state_content *b)
{
    for (size_t i = 0; i < b->setting_count; i++)
        if (strcmp(settings_find(a, b->settings[i].name), b->settings[i].value) != 0)
            return &b->settings[i];
    return NULL;
}

enum weft_result settings_compare(const struct accumulate_job *job, const char *path,
                                  const struct state_content *content)
{
    struct settings now;
    enum weft_result res = WEFT_ERR_MEMORY;
    if (settings_make(job, &now)) {
        const struct state_content as_content = {.setting_count = now.count,
                                                 .settings = now.setting};
        const struct state_setting *other = settings_find_other(content, &as_content);
        res = other ? WEFT_ERR_ARGUMENT : WEFT_OK;
        if (other)
            report_error("%s: %s: %s when it was saved, and %s now: other arguments need another "
                         "state",
                         path, other->name, settings_find(content, other->name), other->value);
    }
    settings_clear(&now);
    return res;
}

// ---- adopting -----------------------------------------------------------------------------------

static enum weft_result check_given(const struct accumulate_job *job,
                                    const struct state_content *content)
{
    for (int i = 0; i < DECIDING; i++) {
        if (!job->option[deciding[i].option].given)
            continue;
        report_error("%s: the frames of states are accumulated already, with %s %s",
                     deciding[i].name, deciding[i].name, settings_find(content, deciding[i].name));
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < OF_FRAMES; i++) {
        if (!job->option[of_frames[i].option].given)
            continue;
        report_error("%s is of frames, and these are states", of_frames[i].name);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// As if they were given: by the parser that they came from.
static enum weft_result parse(struct accumulate_job *job, const struct state_content *content)
{
    struct option_value values[ACCUMULATE_OPTION_COUNT] = {{.given = false}};
    const char *positional[1];
    char text[DECIDING][ACCUMULATE_TEXT], *argv[DECIDING];
    int argc = 0;
    for (int i = 0; i < DECIDING; i++) {
        const char *value = settings_find(content, deciding[i].name);
        argv[argc] = text[argc];
        if (!deciding[i].otherwise && strcmp(value, flag_given) == 0)
            snprintf(text[argc++], sizeof text[0], "%s", deciding[i].name);
        else if (deciding[i].otherwise && strcmp(value, deciding[i].otherwise) != 0)
            snprintf(text[argc++], sizeof text[0], "%s=%s", deciding[i].name, value);
    }
    struct option_parse parse = {
        .verb = "accumulate",
        .options = job->spec,
        .option_count = ACCUMULATE_OPTION_COUNT,
        .values = values,
        .positional = positional,
    };
    if (!options_parse(&parse, argc, argv))
        return WEFT_ERR_FORMAT;
    for (int i = 0; i < DECIDING; i++) {
        struct option_value *to = &job->adopted[deciding[i].option];
        *to = values[deciding[i].option];
        if (to->given && deciding[i].otherwise) // its text is in our array
            to->text = settings_find(content, deciding[i].name);
    }
    return WEFT_OK;
}

enum weft_result settings_adopt(struct accumulate_job *job, const struct state_content *content)
{
    enum weft_result res = check_given(job, content);
    memcpy(job->adopted, job->option, sizeof job->adopted);
    if (res == WEFT_OK)
        res = parse(job, content);
    job->option = job->adopted;
    job->keeps_variance = strcmp(settings_find(content, kept_name), kept_variance) == 0;
    if (res == WEFT_OK && job->option[ACCUMULATE_STDERR].given && !job->keeps_variance) {
        report_error("--stderr: %s keeps the mean of its frames alone: accumulate them with "
                     "--stderr, too",
                     job->operands[0]);
        res = WEFT_ERR_ARGUMENT;
    }
    return res;
}

// ---- carried ------------------------------------------------------------------------------------

struct carried {
    double exponent;
    uint32_t curve, type_count; // that many bytes follow
    char weights[KERNELS_TEXT];
};

struct weft_bytes settings_save_carried(const struct accumulate_job *job)
{
    const size_t count = job->image.channel_count, size = sizeof(struct carried) + count;
    unsigned char *bytes = calloc(1, size);
    struct carried carried = {job->transfer.exponent, job->transfer.curve, (uint32_t)count, ""};
    if (!bytes)
        return (struct weft_bytes){NULL, 0};
    snprintf(carried.weights, sizeof carried.weights, "%s", job->weights.text);
    memcpy(bytes, &carried, sizeof carried);
    for (size_t c = 0; c < count; c++)
        bytes[sizeof carried + c] = (unsigned char)job->channel[c].widest;
    return (struct weft_bytes){bytes, size};
}

enum weft_result settings_load_carried(struct accumulate_job *job, const char *path,
                                       const struct weft_bytes *carried, bool add)
{
    const unsigned char *bytes = carried->data;
    const size_t count = job->image.channel_count;
    struct carried c = {.curve = 0};
    if (carried->size == sizeof c + count)
        memcpy(&c, bytes, sizeof c);
    bool whole = carried->size == sizeof c + count && c.type_count == count &&
                 c.curve <= WEFT_CURVE_POWER && memchr(c.weights, 0, sizeof c.weights);
    for (size_t i = 0; whole && i < count; i++) {
        const enum weft_pixel_type type = bytes[sizeof c + i];
        struct accumulate_channel *channel = &job->channel[i];
        whole = type <= WEFT_PIXEL_UINT;
        channel->widest = add ? accumulate_wider(channel->widest, type) : type;
    }
    if (!whole) {
        report_error("%s: the state is damaged: what it carries of frames", path);
        return WEFT_ERR_FORMAT;
    }
    job->transfer = (struct weft_transfer){c.curve, c.exponent};
    if (job->joins && !add)
        snprintf(job->weights.text, sizeof job->weights.text, "%s", c.weights);
    return WEFT_OK;
}
