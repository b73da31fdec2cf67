// SPDX-License-Identifier: BSD-3-Clause
// The options of `weft effect`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"
#include "tools/methods/jitter_sets.h"
#include "tools/options/saved.h"
#include "tools/ranks/ranks.h"

static bool is_given(const struct effect_job *job, enum effect_option option)
{
    return job->option[option].given;
}

bool effect_job_help(const struct effect_job *job)
{
    if (options_ask_for_help(&job->option[ASK_SCENE]))
        scene_options_print_scenes();
    else if (options_ask_for_help(&job->option[ASK_JITTER]))
        jitter_sets_print();
    else if (options_ask_for_help(&job->option[ASK_FILTER]))
        kernels_print();
    else
        return false;
    return true;
}

// ---- what contradicts what ----------------------------------------------------------------------

// Options of effects that must be named: of one of them.
static const struct {
    enum effect_option option;
    const char *name;
    unsigned effects;
} effect_options[] = {
    {ASK_WEIGHTS, "--weights", EFFECT_FADE},
    {ASK_AT, "--fade", EFFECT_FADE},
    {ASK_SHUTTER, "--shutter", EFFECT_MOTION_BLUR},
    {ASK_JITTER, "--jitter", EFFECT_ANTIALIAS | EFFECT_DOF | EFFECT_SOFT_SHADOW},
    {ASK_CENTRE, "--centre", EFFECT_ANTIALIAS | EFFECT_DOF | EFFECT_SOFT_SHADOW},
    {ASK_FILTER, "--kernel", EFFECT_ANTIALIAS},
    {ASK_FILTER_WIDTH, "--kernel-width", EFFECT_ANTIALIAS},
    {ASK_APERTURE, "--aperture", EFFECT_DOF},
    {ASK_FOCUS, "--focus", EFFECT_DOF},
    {ASK_LIGHT_SIZE, "--light-size", EFFECT_SOFT_SHADOW | EFFECT_RADIOSITY},
    {ASK_PATHS, "--paths", EFFECT_RADIOSITY},
    {ASK_CLAMP, "--light-clamp", EFFECT_RADIOSITY},
};

// An option of effects that were not named.
static bool has_foreign_option(const struct effect_job *job)
{
    for (size_t i = 0; i < sizeof effect_options / sizeof *effect_options; i++) {
        char names[EFFECT_TEXT];
        if (!is_given(job, effect_options[i].option) ||
            (effect_options[i].effects & job->params.effects))
            continue;
        options_join_names(effect_names, effect_options[i].effects, "or", names, sizeof names);
        report_error("%s is of %s: name it with the others, as %s+%s", effect_options[i].name,
                     names, job->operands[0],
                     effect_names[__builtin_ctz(effect_options[i].effects)]);
        return true;
    }
    return false;
}

static const char *output_conflict(const struct effect_job *job)
{
    const bool mean = is_given(job, ASK_OUTPUT), error = is_given(job, ASK_STDERR),
               preview = is_given(job, ASK_PREVIEW);
    if (is_given(job, ASK_QUIET) && is_given(job, ASK_VERBOSE))
        return "-q and -v exclude each other";
    const struct preview_options how = effect_job_preview(job);
    if (!preview && is_given(job, ASK_RANGE))
        return "--range needs --preview OUT.png";
    if (preview_conflict(&how, preview))
        return preview_conflict(&how, preview);
    if (!mean && is_given(job, ASK_TYPE))
        return "--type needs -o OUT.exr";
    if (!mean && !error && is_given(job, ASK_COMPRESSION))
        return "--compression needs -o OUT.exr or --stderr OUT.exr";
    for (int i = 0; i < 2; i++) {
        const struct option_value *output = &job->option[i ? ASK_STDERR : ASK_OUTPUT];
        if (saved_conflict(&job->option[ASK_COMPRESSION], output))
            return saved_conflict(&job->option[ASK_COMPRESSION], output);
    }
    if (!mean && !error && !preview && !is_given(job, ASK_EXPLAIN) && !is_given(job, ASK_JSON))
        return "nothing to do: give -o OUT.exr, --stderr OUT.exr, --preview OUT.png, --json or "
               "--explain";
    return NULL;
}

static const char *plan_conflict(const struct effect_job *job)
{
    if (is_given(job, ASK_WEIGHTS) && is_given(job, ASK_AT))
        return "--weights and --fade exclude each other";
    if (is_given(job, ASK_PATHS) && is_given(job, ASK_FRAMES))
        return "--paths and --frames exclude each other: paths, or the virtual lights on them, are "
               "counted";
    if (is_given(job, ASK_CENTRE) && !is_given(job, ASK_JITTER))
        return "--centre needs --jitter SET: the set that is taken without is centred";
    return NULL;
}

static enum weft_result check_conflicts(const struct effect_job *job)
{
    const char *conflict = output_conflict(job);
    if (!conflict && has_foreign_option(job))
        return WEFT_ERR_ARGUMENT;
    if (!conflict)
        conflict = plan_conflict(job);
    if (conflict)
        report_error("%s", conflict);
    return conflict ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

// ---- single options -----------------------------------------------------------------------------

static enum weft_result read_whole(const char *text, const char *name, int64_t most, int64_t *out)
{
    char *end;
    const double n = strtod(text, &end);
    if (end != text && !*end && n >= 1.0 && n <= (double)most && n == floor(n)) {
        *out = (int64_t)n;
        return WEFT_OK;
    }
    report_error("--%s %s: not a whole number from 1 to %lld%s", name, text, (long long)most,
                 strcmp(name, "frames") == 0 ? ", or auto" : "");
    return WEFT_ERR_ARGUMENT;
}

// A number of points that it names stands for as many frames.
static enum weft_result read_jitter(struct effect_job *job)
{
    const struct option_value *o = &job->option[ASK_JITTER];
    struct effect_params *p = &job->params;
    int count = 0;
    if (!o->given)
        return WEFT_OK;
    const enum weft_result res = weft_jitter_parse(report_log(), o->text, &p->jitter, &count);
    if (res != WEFT_OK || count == 0)
        return res;
    if (p->frames && p->frames != count) {
        report_error("--jitter %s has %d points, for %lld frames: each frame has one", o->text,
                     count, (long long)p->frames);
        return WEFT_ERR_ARGUMENT;
    }
    p->frames = count;
    return WEFT_OK;
}

static enum weft_result read_frames(struct effect_job *job)
{
    const struct option_value *o = job->option;
    struct effect_params *p = &job->params;
    enum weft_result res = WEFT_OK;
    p->paths = o[ASK_PATHS].given;
    if (p->paths)
        res = read_whole(o[ASK_PATHS].text, "paths", EFFECT_MAX_FRAMES, &p->frames);
    else if (o[ASK_FRAMES].given && strcmp(o[ASK_FRAMES].text, "auto") != 0)
        res = read_whole(o[ASK_FRAMES].text, "frames", EFFECT_MAX_FRAMES, &p->frames);
    return res;
}

// NAN: by the lights and the scene.
static enum weft_result read_clamp(const struct option_value *o, double *out)
{
    char *end;
    *out = NAN;
    if (!o->given || strcmp(o->text, "auto") == 0)
        return WEFT_OK;
    *out = 0.0;
    if (strcmp(o->text, "off") == 0)
        return WEFT_OK;
    *out = strtod(o->text, &end);
    if (end != o->text && !*end && *out > 0.0 && isfinite(*out))
        return WEFT_OK;
    report_error("--light-clamp %s: not auto, off, or a factor above 0, in 1 / (unit of the "
                 "scene)^2",
                 o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_lens_and_lamps(struct effect_job *job)
{
    const struct option_value *o = job->option;
    enum weft_result res = options_read_number(
        &o[ASK_APERTURE], "aperture", 0.0, HUGE_VAL,
        "a lens's diameter is 0 or more, in the unit of the scene", &job->params.aperture);
    if (res == WEFT_OK)
        res =
            options_read_number(&o[ASK_FOCUS], "focus", 0x1p-1022, HUGE_VAL,
                                "the distance of what is in focus is above 0", &job->params.focus);
    // Lamps are changed once there are scenes.
    double ignored;
    if (res == WEFT_OK)
        res = options_read_number(&o[ASK_LIGHT_SIZE], "light-size", 0x1p-1022, HUGE_VAL,
                                  "the longer side, or diameter, of a lamp is above 0", &ignored);
    return res;
}

// ---- scenes of a fade ---------------------------------------------------------------------------

// The first name of a list: up to the next semicolon where there is one in all of it, else to the
// next comma that no digit follows ("polygons:4000,50,plane" are two).
static size_t name_length(const char *list, bool semicolons)
{
    size_t length = strcspn(list, semicolons ? ";" : ",");
    while (!semicolons && list[length] && list[length + 1] >= '0' && list[length + 1] <= '9')
        length += 1 + strcspn(list + length + 1, ",");
    return length;
}

static enum weft_result fail_scenes(const struct effect_job *job)
{
    report_error("out of memory for %d scenes", job->scene_count);
    return WEFT_ERR_MEMORY;
}

static enum weft_result add_scene(struct effect_job *job, const char *name, size_t length)
{
    struct effect_scene *grown =
        realloc(job->scene, (size_t)(job->scene_count + 1) * sizeof *job->scene);
    if (!grown)
        return fail_scenes(job);
    job->scene = grown;
    job->scene[job->scene_count++] = (struct effect_scene){.name = strndup(name, length)};
    return job->scene[job->scene_count - 1].name ? WEFT_OK : fail_scenes(job);
}

// The scene that shows an effect, of several that which asks for most.
static enum weft_result add_default(struct effect_job *job)
{
    static const unsigned order[] = {EFFECT_FADE,        EFFECT_RADIOSITY, EFFECT_MOTION_BLUR,
                                     EFFECT_SOFT_SHADOW, EFFECT_DOF,       EFFECT_ANTIALIAS};
    int i = 0;
    while (!(job->params.effects & order[i]))
        i++;
    enum weft_result res = WEFT_OK;
    const char *const *names = scene_find_default(effect_names[__builtin_ctz(order[i])]);
    for (; *names && res == WEFT_OK; names++)
        res = add_scene(job, *names, strlen(*names));
    return res;
}

static enum weft_result read_scenes(struct effect_job *job)
{
    const struct option_value *o = &job->option[ASK_SCENE];
    const bool fade = job->params.effects & EFFECT_FADE;
    enum weft_result res = WEFT_OK;
    if (!o->given)
        return add_default(job);
    if (!fade) // a comma may be part of a file's name
        return add_scene(job, o->text, strlen(o->text));
    for (const char *at = o->text; res == WEFT_OK;) {
        const size_t length = name_length(at, strchr(o->text, ';') != NULL);
        if (job->scene_count == EFFECT_MAX_SCENES || length == 0) {
            report_error("--scene %s: %s", o->text,
                         length ? "too many scenes, there are 16 at most" : "an empty name");
            return WEFT_ERR_ARGUMENT;
        }
        res = add_scene(job, at, length);
        at += length;
        if (!*at++)
            break;
    }
    if (res == WEFT_OK && job->scene_count < 2) {
        report_error("--scene %s: a fade needs two scenes or more, as cube,plane", o->text);
        res = WEFT_ERR_ARGUMENT;
    }
    return res;
}

// Numbers that are separated by commas, one a scene.
static enum weft_result read_weights(struct effect_job *job)
{
    const struct option_value *o = &job->option[ASK_WEIGHTS];
    int count = 0;
    double total = 0.0;
    for (const char *at = o->text; o->given;) {
        char *end;
        const double weight = strtod(at, &end);
        if (end == at || (*end && *end != ',') || !isfinite(weight)) {
            report_error("--weights %s: not numbers with commas between them, as 1,0.5", o->text);
            return WEFT_ERR_ARGUMENT;
        }
        total += weight;
        if (count < EFFECT_MAX_SCENES)
            job->params.fade[count] = weight;
        count++;
        at = end + 1;
        if (!*end)
            break;
    }
    if (!o->given || (count == job->scene_count && total > 0.0))
        return WEFT_OK;
    if (count != job->scene_count)
        report_error("--weights %s: %d weights for %d scenes", o->text, count, job->scene_count);
    else
        report_error("--weights %s: they add up to %g, which must be above 0", o->text, total);
    return WEFT_ERR_ARGUMENT;
}

// A place on the way from the first scene to the last: the two around share it.
static enum weft_result read_place(struct effect_job *job)
{
    const struct option_value *o = &job->option[ASK_AT];
    double t = 0.0;
    const enum weft_result res =
        options_read_number(o, "fade", 0.0, 1.0, "not from 0, the first scene, to 1, the last", &t);
    if (!o->given || res != WEFT_OK)
        return res;
    const double at = t * (job->scene_count - 1);
    for (int i = 0; i < job->scene_count; i++)
        job->params.fade[i] = fmax(0.0, 1.0 - fabs(at - i));
    return WEFT_OK;
}

// ---- all ----------------------------------------------------------------------------------------

static enum weft_result read_params(struct effect_job *job)
{
    const struct option_value *o = job->option;
    struct effect_params *p = &job->params;
    enum weft_result res = scene_options_read(&o[ASK_SCENES], &job->request);
    p->seed = job->request.seed;
    memcpy(p->size, job->request.size, sizeof p->size);
    memcpy(p->time, job->request.time, sizeof p->time);
    if (res == WEFT_OK)
        res = read_frames(job);
    if (res == WEFT_OK && o[ASK_SHUTTER].given)
        res = weft_shutter_parse(report_log(), o[ASK_SHUTTER].text, &p->shutter);
    if (res == WEFT_OK)
        res = read_jitter(job);
    p->centre = o[ASK_CENTRE].integer[0] == 0; // "on" is the first and the default
    if (res == WEFT_OK)
        res = kernels_read_filter(&o[ASK_FILTER], &o[ASK_FILTER_WIDTH], &job->filter,
                                  &job->filter_file, &p->filter_width);
    p->filter = job->filter;
    if (res == WEFT_OK)
        res = read_lens_and_lamps(job);
    if (res == WEFT_OK)
        res = read_clamp(&o[ASK_CLAMP], &p->clamp);
    return res;
}

static enum weft_result read_ranks(struct effect_job *job)
{
    struct effect_divided *d = &job->divided;
    const enum weft_result res = rank_options_read(&job->option[ASK_RANKS], &d->request);
    d->is = (ranks_size() > 1 || d->request.given) && !is_given(job, ASK_EXPLAIN);
    if (!job->how.threads)
        job->how.threads = ranks_threads();
    return res == WEFT_OK && d->is ? rank_frames_check(&d->request, job->how.method) : res;
}

enum weft_result effect_job_read_options(struct effect_job *job)
{
    const struct option_value *o = job->option;
    const struct preview_options preview = effect_job_preview(job);
    const struct weft_colour_map *no_map;
    const unsigned uses =
        ACCUMULATION_DRAWS_FRAMES | (o[ASK_STDERR].given ? ACCUMULATION_TELLS_ERROR : 0);
    job->params = *effect_params(.log = report_log());
    if (!job->operands[0]) {
        report_error("no effect given: weft effect NAME[+NAME...] -o OUT.exr (see weft help "
                     "effect)");
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = effect_parse(report_log(), job->operands[0], &job->params.effects);
    if (res == WEFT_OK)
        res = check_conflicts(job);
    if (res == WEFT_OK)
        res = accumulation_read(&o[ASK_ADDING], uses, &job->how);
    if (res == WEFT_OK)
        res = read_ranks(job);
    if (res == WEFT_OK)
        res = read_params(job);
    if (res == WEFT_OK)
        res = read_scenes(job);
    if (res == WEFT_OK)
        res = read_weights(job);
    if (res == WEFT_OK)
        res = read_place(job);
    return res == WEFT_OK ? preview_check(&preview, &no_map) : res;
}
