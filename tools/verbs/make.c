// SPDX-License-Identifier: BSD-3-Clause
// weft make: test signals as VDB volumes.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/verbs/verb.h"

enum make_option {
    MAKE_OUTPUT,
    MAKE_SIZE,
    MAKE_VOXEL,
    MAKE_OFFSET,
    MAKE_JSON,
    MAKE_NO_CLOBBER,
    MAKE_QUIET,
    MAKE_VERBOSE,
    MAKE_OPTION_COUNT
};

enum { BAND_VOXELS = 3 }; // half-width of the narrow band, OpenVDB's default
enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };
// Of voxels. Building, handing over and writing hold about four times that for a while.
static const uint64_t max_bytes = UINT64_C(2) << 30;

static const char *const volume_endings[] = {".vdb", ".nrrd", NULL};
static const struct option_spec options[MAKE_OPTION_COUNT] = {
    [MAKE_OUTPUT] = {.name = "output",
                     'o',
                     OPTION_OUTPUT,
                     "OUT.vdb|.nrrd",
                     "the volume (required), as VDB, or the box of its voxels as NRRD",
                     volume_endings,
                     .group = OPTION_FILES,
                     .brief = "the volume"},
    [MAKE_SIZE] = {.name = "size",
                   0,
                   OPTION_VOXELS,
                   "N|NxNxN",
                   "voxels along the edges of the sampled cube (default: the signal's own)",
                   .group = OPTION_GEOMETRY,
                   .brief = "voxels along each axis"},
    [MAKE_VOXEL] = {.name = "voxel",
                    0,
                    OPTION_SPACING,
                    "S|SX,SY,SZ",
                    "distance between voxels in world units (default 1); world = voxel * index",
                    .group = OPTION_GEOMETRY,
                    .brief = "their size in the world"},
    [MAKE_OFFSET] = {.name = "offset",
                     0,
                     OPTION_INDEX,
                     "I,J,K",
                     "index of the first voxel (default 0,0,0); it moves the volume in the world, "
                     "too",
                     .group = OPTION_GEOMETRY},
    [MAKE_JSON] = OPTIONS_JSON("what was made, its file and times"),
    [MAKE_NO_CLOBBER] = OPTIONS_NO_CLOBBER,
    [MAKE_QUIET] = OPTIONS_QUIET,
    [MAKE_VERBOSE] = OPTIONS_VERBOSE,
};

struct make_job {
    const struct weft_signal_info *signal;
    int64_t size[3], offset[3];
    double voxel[3];
    float background;

    size_t count, capacity; // bricks
    int32_t (*origin)[3];
    float *values;
    const struct weft_progress *progress;
    double done, total;    // of the progress, in bricks looked at
    double start, seconds; // of sampling
};

enum { MAX_NAMES = 32 };

static enum weft_result unknown_signal(const char *name)
{
    const char *names[MAX_NAMES + 1] = {NULL};
    char explanation[512];
    for (int i = 0; i < MAX_NAMES && weft_signal_list[i]; i++)
        names[i] = weft_signal_list[i]->name;
    weft_closest_explain(name ? name : "", name ? strlen(name) : 0, names, explanation,
                         sizeof explanation);
    if (name)
        report_error("no signal '%s'%s", name, explanation);
    else
        report_error("no signal given%s", explanation);
    return WEFT_ERR_ARGUMENT;
}

static void print_signals(void)
{
    puts("signals, each over the cube [-1, 1]^3, sampled at voxel centres:");
    for (int i = 0; weft_signal_list[i]; i++) {
        const struct weft_signal_info *signal = weft_signal_list[i];
        printf("  %-15s %s, %d^3%s%s%s\n", signal->name, signal->description, signal->default_size,
               signal->citation ? " (" : "", signal->citation ? signal->citation : "",
               signal->citation ? ")" : "");
    }
}

// ---- what was asked for -------------------------------------------------------------------------

static enum weft_result check_axis(const struct make_job *job, const struct option_value *values,
                                   int axis)
{
    const int64_t limit = WEFT_INDEX_LIMIT - 2 * WEFT_BRICK_SIZE;
    if (job->size[axis] < 1 || job->size[axis] > limit) {
        report_error("--size %s: each edge must be from 1 to %lld voxels", values[MAKE_SIZE].text,
                     (long long)limit);
        return WEFT_ERR_ARGUMENT;
    }
    if (job->offset[axis] < -limit || job->offset[axis] > limit - job->size[axis]) {
        report_error("--offset %s: with %lld voxels, indices must lie within +-%lld",
                     values[MAKE_OFFSET].text, (long long)job->size[axis], (long long)limit);
        return WEFT_ERR_ARGUMENT;
    }
    if (!(job->voxel[axis] > 0)) {
        report_error("--voxel %s: distances must be greater than 0", values[MAKE_VOXEL].text);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// A narrow band of distances is one only if a voxel is as long on every side.
static enum weft_result check_level_set(struct make_job *job)
{
    for (int c = 1; c < 3; c++) {
        if (job->size[c] != job->size[0] || job->voxel[c] != job->voxel[0]) {
            report_error("%s is a level set: its size and its voxel need one number for all axes",
                         job->signal->name);
            return WEFT_ERR_ARGUMENT;
        }
    }
    job->background = (float)(BAND_VOXELS * job->voxel[0]);
    if (isnormal(job->background) && isfinite((float)((double)job->size[0] * job->voxel[0])))
        return WEFT_OK;
    report_error("--voxel %g: distances do not fit in single precision", job->voxel[0]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_options(struct make_job *job, const char *name,
                                     const struct option_value *values)
{
    job->signal = name ? weft_signal_find(name) : NULL;
    if (!job->signal)
        return unknown_signal(name);
    if (!values[MAKE_OUTPUT].given) {
        report_error("no output given: weft make %s -o OUT.vdb", name);
        return WEFT_ERR_ARGUMENT;
    }
    for (int c = 0; c < 3; c++) {
        job->size[c] =
            values[MAKE_SIZE].given ? values[MAKE_SIZE].integer[c] : job->signal->default_size;
        job->voxel[c] = values[MAKE_VOXEL].given ? values[MAKE_VOXEL].number[c] : 1;
        job->offset[c] = values[MAKE_OFFSET].integer[c];
        enum weft_result res = check_axis(job, values, c);
        if (res != WEFT_OK)
            return res;
    }
    if (job->signal->level_set) {
        enum weft_result res = check_level_set(job);
        if (res != WEFT_OK)
            return res;
    }
    return paths_check_output(values[MAKE_OUTPUT].text, values[MAKE_NO_CLOBBER].given);
}

// ---- bricks -------------------------------------------------------------------------------------

static enum weft_result too_large(const struct make_job *job, double bytes)
{
    report_error("%lld x %lld x %lld voxels of %s take %.0f bytes or more, over the limit of %llu",
                 (long long)job->size[0], (long long)job->size[1], (long long)job->size[2],
                 job->signal->name, bytes, (unsigned long long)max_bytes);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result reserve_brick(struct make_job *job)
{
    if (job->count < job->capacity)
        return WEFT_OK;
    size_t capacity = job->capacity ? 2 * job->capacity : 64;
    if (job->count >= max_bytes / BRICK_BYTES)
        return too_large(job, (double)(job->count + 1) * BRICK_BYTES);
    void *origin = realloc(job->origin, capacity * sizeof *job->origin);
    if (origin)
        job->origin = origin;
    void *values = realloc(job->values, capacity * BRICK_BYTES);
    if (values)
        job->values = values;
    if (!origin || !values) {
        report_error("out of memory: %zu bytes for %zu bricks", capacity * BRICK_BYTES, capacity);
        return WEFT_ERR_MEMORY;
    }
    job->capacity = capacity;
    return WEFT_OK;
}

// The signal's coordinate of voxel i (an index within the cube). A lattice signal keeps its own
// lattice, laid middle voxel on middle voxel.
static double coordinate(const struct make_job *job, int axis, double i)
{
    double n = (double)job->size[axis];
    if (job->signal->lattice) {
        i += floor(job->signal->default_size / 2) - floor(n / 2);
        n = job->signal->default_size;
    }
    return -1.0 + (2.0 * i + 1.0) / n;
}

static double signal_value(const struct make_job *job, const double index[3])
{
    double position[3];
    for (int c = 0; c < 3; c++)
        position[c] = coordinate(job, c, index[c] - (double)job->offset[c]);
    return job->signal->value(position);
}

// Voxel edges per unit of the signal's coordinates, for level sets: their cube is 2 units wide.
static double voxels_per_unit(const struct make_job *job)
{
    return 0.5 * (double)job->size[0];
}

static float voxel_value(const struct make_job *job, const int64_t index[3])
{
    const double at[3] = {(double)index[0], (double)index[1], (double)index[2]};
    if (job->signal->level_set) {
        double distance = signal_value(job, at) * voxels_per_unit(job) * job->voxel[0];
        return fmaxf(-job->background, fminf(job->background, (float)distance));
    }
    for (int c = 0; c < 3; c++)
        if (index[c] < job->offset[c] || index[c] >= job->offset[c] + job->size[c])
            return job->background;
    return (float)signal_value(job, at);
}

// Appends the brick at `origin` if it holds more than background (and inside, for level sets).
static enum weft_result add_brick(struct make_job *job, const int64_t origin[3])
{
    enum weft_result res = reserve_brick(job);
    if (res != WEFT_OK)
        return res;
    float *out = job->values + job->count * WEFT_BRICK_VOXELS;
    bool wanted = false;
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++) {
        const int64_t index[3] = {origin[0] + i % 8, origin[1] + i / 8 % 8, origin[2] + i / 64};
        out[i] = voxel_value(job, index);
        wanted |=
            job->signal->level_set ? fabsf(out[i]) < job->background : out[i] != job->background;
    }
    if (!wanted)
        return WEFT_OK;
    for (int c = 0; c < 3; c++)
        job->origin[job->count][c] = (int32_t)origin[c];
    job->count++;
    return WEFT_OK;
}

static enum weft_result step(struct make_job *job, double bricks)
{
    job->done += bricks;
    return job->progress->report(job->progress->priv, fmin(1, job->done / job->total))
               ? WEFT_OK
               : WEFT_ERR_CANCELLED;
}

static int64_t brick_floor(int64_t index)
{
    return index & ~(int64_t)(WEFT_BRICK_SIZE - 1);
}

static enum weft_result build_dense(struct make_job *job)
{
    int64_t first[3], end[3], bricks[3];
    for (int c = 0; c < 3; c++) {
        first[c] = brick_floor(job->offset[c]);
        end[c] = job->offset[c] + job->size[c];
        bricks[c] = (end[c] - first[c] + WEFT_BRICK_SIZE - 1) / WEFT_BRICK_SIZE;
    }
    job->total = (double)bricks[0] * (double)bricks[1] * (double)bricks[2];
    if (job->total * BRICK_BYTES > (double)max_bytes)
        return too_large(job, job->total * BRICK_BYTES);
    enum weft_result res = WEFT_OK;
    int64_t at[3];
    for (at[2] = first[2]; at[2] < end[2] && res == WEFT_OK; at[2] += WEFT_BRICK_SIZE)
        for (at[1] = first[1]; at[1] < end[1] && res == WEFT_OK; at[1] += WEFT_BRICK_SIZE) {
            for (at[0] = first[0]; at[0] < end[0] && res == WEFT_OK; at[0] += WEFT_BRICK_SIZE)
                res = add_brick(job, at);
            if (res == WEFT_OK)
                res = step(job, (double)bricks[0]);
        }
    return res;
}

// Descends into the octants of a cube that can hold part of the band: a distance changes by at most
// 1 per unit of length, so no voxel of the cube is nearer to the surface than its centre is, less
// half of the cube's diagonal.
static enum weft_result descend(struct make_job *job, const int64_t origin[3], int64_t size)
{
    double centre[3], half = 0.5 * (double)(size - 1);
    for (int c = 0; c < 3; c++)
        centre[c] = (double)origin[c] + half;
    double distance = fabs(signal_value(job, centre)) * voxels_per_unit(job);
    double edge = (double)size / WEFT_BRICK_SIZE;
    if (distance - sqrt(3.0) * half > BAND_VOXELS + 1e-6)
        return step(job, edge * edge * edge);
    enum weft_result res = WEFT_OK;
    if (size == WEFT_BRICK_SIZE) {
        res = add_brick(job, origin);
        return res == WEFT_OK ? step(job, 1) : res;
    }
    for (int octant = 0; octant < 8 && res == WEFT_OK; octant++) {
        int64_t child[3];
        for (int c = 0; c < 3; c++)
            child[c] = origin[c] + (octant >> c & 1) * (size / 2);
        res = descend(job, child, size / 2);
    }
    return res;
}

// The band may reach past the sampled cube when that is only a few voxels wide.
static enum weft_result build_level_set(struct make_job *job)
{
    const int64_t margin = 2 * WEFT_BRICK_SIZE;
    int64_t root[3], size = WEFT_BRICK_SIZE;
    for (int c = 0; c < 3; c++)
        root[c] = brick_floor(job->offset[c] - margin);
    while (size < job->size[0] + 2 * margin)
        size *= 2;
    double edge = (double)size / WEFT_BRICK_SIZE;
    job->total = edge * edge * edge;
    return descend(job, root, size);
}

static enum weft_result build_volume(struct make_job *job, weft_volume **out)
{
    job->progress = report_progress("sampling");
    enum weft_result res = job->signal->level_set ? build_level_set(job) : build_dense(job);
    if (res != WEFT_OK)
        return res;
    struct weft_volume_bricks_params params = {
        .brick_count = job->count,
        .brick_origin = (const int32_t(*)[3])job->origin,
        .brick_values = job->values,
        .background = job->background,
        .name = job->signal->name,
        .grid_class = job->signal->level_set ? "level set" : "fog volume",
        .log = report_log(),
    };
    for (int c = 0; c < 3; c++)
        params.index_to_world[c][c] = job->voxel[c];
    return weft_volume_create_bricks(&params, out);
}

// ---- the verb -----------------------------------------------------------------------------------

// There is no input to refuse here: whatever keeps the writer from writing is an output not
// written.
static enum weft_result save_volume(weft_volume *volume, const struct option_value *values)
{
    const struct weft_nrrd_save_params *nrrd =
        weft_nrrd_save_params(.path = values[MAKE_OUTPUT].text,
                              .no_clobber = values[MAKE_NO_CLOBBER].given, .volume = {volume},
                              .log = report_log());
    const struct weft_volume_save_params params = {
        .path = values[MAKE_OUTPUT].text,
        .no_clobber = values[MAKE_NO_CLOBBER].given,
        .log = report_log(),
    };
    report_stage("writing", params.path);
    const bool is_nrrd = values[MAKE_OUTPUT].integer[0] == 1;
    enum weft_result res = is_nrrd ? weft_volume_save_nrrd(nrrd) : weft_volume_save(volume, &params);
    if (res == WEFT_OK || res == WEFT_ERR_MEMORY || res == WEFT_ERR_CANCELLED)
        return res;
    return WEFT_ERR_WRITE;
}

static enum weft_result print_json(const struct make_job *job, const weft_volume *volume)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    const struct run_stage sampling = {"sampling", job->seconds};
    json_t *root =
        json_pack("{s:s,s:[i,i,i],s:o,s:o,s:o,s:o}", "signal", job->signal->name, "size",
                  (int)job->size[0], (int)job->size[1], (int)job->size[2], "voxel",
                  json_numbers(job->voxel, 3), "bricks", json_count(job->count), "active_min",
                  json_counts(info->active_min, 3), "active_max", json_counts(info->active_max, 3));
    json_object_set_new(root, "bytes", run_report_bytes("voxels", job->count * BRICK_BYTES));
    json_object_set_new(root, "seconds",
                        run_report_seconds(&sampling, 1, report_now_seconds() - job->start));
    return json_print(root);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[MAKE_QUIET].given, values[MAKE_VERBOSE].given);
    if (operand && strcmp(operand, "help") == 0) {
        print_signals();
        return report_finish(WEFT_OK);
    }
    struct make_job job = {.start = report_now_seconds()};
    weft_volume *volume = NULL;
    enum weft_result res = read_options(&job, operand, values);
    if (res == WEFT_OK)
        res = build_volume(&job, &volume);
    job.seconds = report_now_seconds() - job.start;
    free(job.origin);
    free(job.values);
    if (res == WEFT_OK)
        res = save_volume(volume, values);
    if (res == WEFT_OK && values[MAKE_JSON].given)
        res = print_json(&job, volume);
    if (res == WEFT_OK)
        report_note("%s: %zu bricks, %llu bytes of voxels", values[MAKE_OUTPUT].text, job.count,
                    (unsigned long long)job.count * BRICK_BYTES);
    weft_volume_destroy(&volume);
    return report_finish(res);
}

static const char *const epilogue[] = {
    "World position = voxel * index: voxel (0, 0, 0) sits at the world's origin. Outside "
    "the cube the background holds: 0, or for the sphere, a level set in world units, 3 voxels.",
    NULL,
};

const struct verb verb_make = {
    .name = "make",
    .group = VERB_VOLUMES,
    .summary = "a test signal as a VDB or NRRD volume",
    .usage = "SIGNAL -o OUT.vdb|.nrrd [--size N|NxNxN] [--voxel S|SX,SY,SZ] [--offset I,J,K] [options]",
    .description = "Samples an analytic signal and writes it as a float grid, named after the "
                   "signal. The sphere is a narrow-band level set, built without visiting the "
                   "voxels away from its surface.",
    .epilogue = epilogue,
    .print_catalogue = print_signals,
    .options = options,
    .option_count = MAKE_OPTION_COUNT,
    .run = run,
};
