// SPDX-License-Identifier: BSD-3-Clause
// `weft resample` under a map: what is asked for, where the result lies, and the runs.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// ---- options ------------------------------------------------------------------------------------

static const enum resample_option map_options[] = {RESAMPLE_MATRIX, RESAMPLE_ROTATE,
                                                   RESAMPLE_PERSPECTIVE, RESAMPLE_POSITIONS};
static const char *const map_names[] = {"--matrix", "--rotate", "--perspective", "--positions"};
enum { MAPS = sizeof map_options / sizeof *map_options };

// Which map is asked for; MAPS: none.
static int find_map(const struct resample_job *job)
{
    int which = 0;
    while (which < MAPS && !job->option[map_options[which]].given)
        which++;
    return which;
}

bool resample_is_warp(const struct resample_job *job)
{
    return find_map(job) < MAPS;
}

// Numbers with commas between them.
static enum weft_result read_numbers(const struct option_value *value, const char *name, int count,
                                     double *out)
{
    const char *at = value->text;
    bool good = true;
    for (int i = 0; good && i < count; i++) {
        char *end;
        good = strchr("+-.0123456789", *at) != NULL && *at;
        out[i] = good ? strtod(at, &end) : 0.0;
        good = good && end != at && isfinite(out[i]) && *end == (i + 1 < count ? ',' : '\0');
        at = good ? end + 1 : at;
    }
    if (good)
        return WEFT_OK;
    report_error("%s %s: %d numbers with commas between them are needed", name, value->text, count);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_map(struct resample_job *job, int which)
{
    const struct option_value *value = &job->option[map_options[which]];
    double six[6];
    enum weft_result res = WEFT_OK;
    switch (map_options[which]) {
    case RESAMPLE_MATRIX:
        res = read_numbers(value, map_names[which], 6, six);
        if (res == WEFT_OK)
            weft_warp_matrix_affine(six, job->warp.matrix);
        return res;
    case RESAMPLE_PERSPECTIVE:
        return read_numbers(value, map_names[which], 9, job->warp.matrix);
    default:
        return res;
    }
}

// Options that say what a map does not have.
static enum weft_result check_conflicts(const struct resample_job *job, int which)
{
    const struct option_value *o = job->option;
    const char *passes = resample_passes_option(job), *bad = NULL;
    for (int other = which + 1; other < MAPS && !bad; other++)
        bad = o[map_options[other]].given ? map_names[other] : NULL;
    bad = o[RESAMPLE_EMULATE].given     ? "--emulate"
          : o[RESAMPLE_MAX_ERROR].given ? "--max-error"
          : passes                      ? passes
                                        : bad;
    if (map_options[which] == RESAMPLE_POSITIONS && o[RESAMPLE_SIZE].given)
        bad = "--size";
    if (!bad)
        return WEFT_OK;
    report_error("%s does not go with %s", bad, map_names[which]);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result resample_read_warp(struct resample_job *job)
{
    const int which = find_map(job);
    if (which == MAPS)
        return WEFT_OK;
    enum weft_result res = check_conflicts(job, which);
    if (res != WEFT_OK)
        return res;
    if (job->divided.is) {
        report_error("a warp (%s) is not divided; run it without mpirun and options of ranks",
                     map_names[which]);
        return WEFT_ERR_UNSUPPORTED;
    }
    job->warp.is = true;
    // Positions are formed on the CPU anyway.
    if (job->engine.automatic)
        job->engine.engine = WEFT_ENGINE_CPU;
    job->engine.automatic = false;
    return read_map(job, which);
}

// ---- windows ------------------------------------------------------------------------------------

static const float *plane_named(const struct weft_image *image, const char *name)
{
    for (size_t i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0)
            return image->channels[i].plane;
    return NULL;
}

static enum weft_result load_positions(struct resample_job *job)
{
    const char *path = job->option[RESAMPLE_POSITIONS].text;
    struct weft_image *image = &job->warp.positions;
    const struct weft_image_load_params params = {
        .path = path, .threads = job->engine.cpu.threads, .log = report_log()};
    const enum weft_result res = weft_image_load(&params, image);
    if (res != WEFT_OK)
        return res;
    job->warp.position[0] = plane_named(image, "X");
    job->warp.position[1] = plane_named(image, "Y");
    if (job->warp.position[0] && job->warp.position[1])
        return WEFT_OK;
    report_error("%s: channels X and Y are needed, the points of the image that pixels show", path);
    return WEFT_ERR_ARGUMENT;
}

static void copy_windows(const struct weft_image *from, struct weft_image *to)
{
    to->x = from->x;
    to->y = from->y;
    to->width = from->width;
    to->height = from->height;
    for (int a = 0; a < 2; a++) {
        to->display_min[a] = from->display_min[a];
        to->display_max[a] = from->display_max[a];
    }
}

// The display window's centre of the input goes to the one of the result.
static void set_rotation(struct resample_job *job)
{
    const struct weft_image *in = &job->image, *out = &job->result;
    double from[2], to[2];
    for (int a = 0; a < 2; a++) {
        from[a] = 0.5 * ((double)in->display_min[a] + in->display_max[a] + 1.0);
        to[a] = 0.5 * ((double)out->display_min[a] + out->display_max[a] + 1.0);
    }
    weft_warp_matrix_rotate(job->option[RESAMPLE_ROTATE].number[0], from, job->warp.matrix);
    for (int a = 0; a < 2; a++)
        job->warp.matrix[3 * a + 2] += to[a] - from[a];
}

enum weft_result resample_set_warp_windows(struct resample_job *job)
{
    const bool sized = job->option[RESAMPLE_SIZE].given;
    enum weft_result res = sized ? resample_choose_size(job) : WEFT_OK;
    const int64_t size[2] = {job->map[0].to, job->map[1].to};
    if (res == WEFT_OK && job->option[RESAMPLE_POSITIONS].given)
        res = load_positions(job);
    if (res != WEFT_OK)
        return res;
    copy_windows(job->warp.position[0] ? &job->warp.positions : &job->image, &job->result);
    if (sized) {
        struct weft_image *out = &job->result;
        for (int a = 0; a < 2; a++)
            out->display_max[a] = (int32_t)(out->display_min[a] + size[a] - 1);
        out->x = out->display_min[0];
        out->y = out->display_min[1];
        out->width = (int32_t)size[0];
        out->height = (int32_t)size[1];
    }
    // Pixels keep their shape.
    for (int a = 0; a < 2; a++)
        job->map[a] = (struct weft_window_map){.from = 1, .to = 1};
    if (job->option[RESAMPLE_ROTATE].given)
        set_rotation(job);
    return WEFT_OK;
}

// ---- groups -------------------------------------------------------------------------------------

// Where the name within its layer begins: "left.R" -> "R".
static const char *in_layer(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot ? dot + 1 : name;
}

static bool is_colour(const char *name)
{
    const char *colour = in_layer(name);
    return strlen(colour) == 1 && strchr("RGBA", *colour);
}

static bool is_same_layer(const char *a, const char *b)
{
    const size_t size = (size_t)(in_layer(a) - a);
    return size == (size_t)(in_layer(b) - b) && memcmp(a, b, size) == 0;
}

enum weft_result resample_make_warp_groups(struct resample_job *job)
{
    const struct weft_image *image = &job->result;
    for (size_t i = 0; i < image->channel_count; i++) {
        const char *name = image->channels[i].name;
        struct resample_group *found = NULL;
        for (size_t g = 0; is_colour(name) && !found && g < job->group_count; g++) {
            const char *first = image->channels[job->group[g].channel[0]].name;
            if (is_colour(first) && is_same_layer(first, name) &&
                job->group[g].count < RESAMPLE_MAX_TOGETHER)
                found = &job->group[g];
        }
        if (!found)
            found = &job->group[job->group_count++];
        found->channel[found->count++] = i;
    }
    return WEFT_OK;
}

// ---- plans and runs -----------------------------------------------------------------------------

enum weft_result resample_plan_warp(struct resample_job *job)
{
    const double start = report_now_seconds();
    const struct weft_image *in = &job->image, *out = &job->result;
    struct resample_warp *w = &job->warp;
    struct weft_warp_params params =
        *weft_warp_params(.kernel = job->kernel, .size = {in->width, in->height},
                          .width = out->width, .height = out->height, .boundary = job->boundary,
                          .unstretched = resample_is_unstretched(job),
                          .clamp = job->option[RESAMPLE_CLAMP].given, .engine = job->engine.engine,
                          .sums = job->engine.sums, .log = report_log());
    params.map = (struct weft_warp_map){
        .kind = w->position[0] ? WEFT_WARP_POSITIONS : WEFT_WARP_MATRIX,
        .position = {w->position[0], w->position[1]},
        .source_corner = {in->x, in->y},
        .result_corner = {out->x, out->y},
    };
    memcpy(params.map.matrix, w->matrix, sizeof w->matrix);
    // All zero is what no option is.
    const double zero[9] = {0.0};
    if (!w->position[0] && memcmp(w->matrix, zero, sizeof zero) == 0) {
        report_error("%s: a matrix of zeros has no inverse", map_names[find_map(job)]);
        return WEFT_ERR_ARGUMENT;
    }
    const enum weft_result res = weft_warp_plan_create(&params, &w->plan);
    for (size_t g = 0; g < job->group_count; g++)
        job->group[g].warp = w->plan;
    job->plan_seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result run_group(struct resample_job *job, struct resample_group *group)
{
    struct weft_warp_run_params params = {
        .source = group->source, .progress = report_progress("warping"), .log = report_log()};
    struct weft_resample_report report;
    for (int c = 0; c < group->count; c++)
        params.plane[c] = job->result.channels[group->channel[c]].plane;
    const enum weft_result res = weft_warp_run(job->warp.compiled, &params, &report);
    if (res != WEFT_OK)
        return res;
    weft_resample_work_add(&job->work, &report.work);
    group->minimum = report.pixels.minimum;
    group->maximum = report.pixels.maximum;
    group->not_finite = report.pixels.not_finite;
    group->bound = resample_group_bound(group, weft_statistics_magnitude(&report.pixels));
    return WEFT_OK;
}

static enum weft_result verify_group(struct resample_job *job, struct resample_group *group)
{
    struct error_image_part part;
    struct weft_resample_verify_params params = {
        .source = group->source,
        .how = resample_verify_how(job, group, report_progress("verifying"), &part),
        .log = report_log()};
    for (int c = 0; c < group->count; c++)
        params.plane[c] = job->result.channels[group->channel[c]].plane;
    return weft_warp_verify(job->warp.plan, &params, &group->error);
}

enum weft_result resample_compute_warp(struct resample_job *job)
{
    const struct weft_resample_compile_params compile = {.context = job->context,
                                                         .cpu = job->engine.cpu};
    enum weft_result res = weft_warp_compile(job->warp.plan, &compile, &job->warp.compiled);
    if (res == WEFT_OK)
        res = resample_create_errors(job);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        res = run_group(job, &job->group[g]);
    const double start = report_now_seconds();
    for (size_t g = 0; job->option[RESAMPLE_VERIFY].given && res == WEFT_OK && g < job->group_count;
         g++)
        res = verify_group(job, &job->group[g]);
    job->verify_seconds = report_now_seconds() - start;
    return res;
}

void resample_clear_warp(struct resample_warp *warp)
{
    weft_warp_compiled_destroy(&warp->compiled);
    weft_warp_plan_destroy(&warp->plan);
    weft_image_clear(&warp->positions);
}

// ---- words --------------------------------------------------------------------------------------

void resample_warp_text(const struct resample_job *job, char *text, size_t size)
{
    const int which = find_map(job);
    snprintf(text, size, "%s %s", map_names[which] + 2, job->option[map_options[which]].text);
}

json_t *resample_warp_json(const struct resample_job *job)
{
    const struct weft_warp_info *info = weft_warp_plan_get_info(job->warp.plan);
    json_t *inverse = json_array(), *scale = json_array(), *taps = json_array();
    for (int i = 0; i < 9; i++)
        json_array_append_new(inverse, json_number(info->inverse[i]));
    for (int a = 0; a < 2; a++) {
        json_array_append_new(scale, json_number(info->scale[a]));
        json_array_append_new(taps, json_integer(info->taps[a]));
    }
    return json_pack("{s:s,s:o,s:o,s:o,s:s,s:o}", "map", weft_warp_method_names[info->method],
                     "inverse", inverse, "scale", scale, "taps", taps, "boundary",
                     weft_boundary_names[info->boundary], "relative_bound",
                     json_number(info->bound.relative));
}
