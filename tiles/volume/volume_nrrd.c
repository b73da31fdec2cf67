// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/volume_nrrd.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/output/output_file.h"
#include "tiles/volume/volume_impl.h"

enum { HEADER = 1 << 16, STRIP_BYTES = 32 << 20 };

struct job {
    const struct weft_nrrd_save_params *params;
    const struct weft_log *log;
    const struct weft_volume_info *info; // of the first component
    int components;
    int32_t first[3];   // voxel of the box
    uint64_t size[3];   // of it
    uint64_t row_bytes; // of the file
    struct weft_output_file file;
    char *header;
    size_t header_bytes;
    // A strip of 8 layers and some rows, of all components.
    int32_t rows;
    double *strip;
    unsigned char *packed;
    uint64_t rounded, clamped;
};

// ---- the header ---------------------------------------------------------------------------------

static void add(struct job *job, const char *format, ...) __attribute__((format(printf, 2, 3)));

// What does not fit is left out line by line, and only metadata can be as long.
static void add(struct job *job, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int length =
        vsnprintf(job->header + job->header_bytes, HEADER - job->header_bytes, format, args);
    va_end(args);
    if (length > 0 && (size_t)length < HEADER - job->header_bytes)
        job->header_bytes += (size_t)length;
}

static const char *find_note(const struct weft_volume_info *info, const char *key)
{
    for (size_t i = 0; i < info->metadata_count; i++)
        if (!strcmp(info->metadata[i].key, key))
            return info->metadata[i].value;
    return NULL;
}

// Names of three-dimensional spaces.
static bool is_space(const char *text)
{
    static const char *const names[] = {"right-anterior-superior", "left-anterior-superior",
                                        "left-posterior-superior", "scanner-xyz",
                                        "3D-right-handed",         "3D-left-handed"};
    for (size_t i = 0; text && i < WEFT_COUNT(names); i++)
        if (!strcmp(text, names[i]))
            return true;
    return false;
}

// What the header has fields for, what is true of another file, and what OpenVDB counts.
static bool is_own(const char *key)
{
    static const char *const own[] = {
        "encoding", "space",        "space units", "measurement frame",
        "kinds",    "units",        "labels",      "centers",
        "content",  "class",        "name",        "is_saved_as_half_float",
        "scale",    "sample units", "old range"};
    for (size_t i = 0; i < WEFT_COUNT(own); i++)
        if (!strcmp(key, own[i]))
            return true;
    return !strncmp(key, "file_", 5) || strstr(key, ":=") || strchr(key, '\n') || !*key;
}

static void add_text(struct job *job, const char *key, const char *between, const char *value)
{
    char line[512];
    size_t used = 0;
    for (; *value && used < sizeof line - 3; value++) {
        if (*value == '\n' || *value == '\\')
            line[used++] = '\\';
        line[used++] = *value == '\n' ? 'n' : *value;
    }
    line[used] = 0;
    add(job, "%s%s%s\n", key, between, line);
}

static void add_units(struct job *job, const char *units)
{
    char word[3][32];
    const int count = units ? sscanf(units, "%31s %31s %31s", word[0], word[1], word[2]) : 0;
    if (count == 1 || count == 3)
        add(job, "space units: \"%s\" \"%s\" \"%s\"\n", word[0], word[count == 3 ? 1 : 0],
            word[count == 3 ? 2 : 0]);
}

static void add_place(struct job *job)
{
    const double(*m)[4] = job->info->index_to_world;
    const char *space = find_note(job->info, "space"), *none = job->components > 1 ? " none" : "";
    const char *frame = find_note(job->info, "measurement frame");
    if (is_space(space))
        add(job, "space: %s\n", space);
    else
        add(job, "space dimension: 3\n");
    add(job, "sizes:%s %llu %llu %llu\n", job->components > 1 ? " 3" : "",
        (unsigned long long)job->size[0], (unsigned long long)job->size[1],
        (unsigned long long)job->size[2]);
    add(job, "space directions:%s", none);
    for (int c = 0; c < 3; c++)
        add(job, " (%.17g,%.17g,%.17g)", m[0][c], m[1][c], m[2][c]);
    add(job, "\nkinds:%s domain domain domain\n", job->components > 1 ? " vector" : "");
    add(job, "space origin: (");
    for (int r = 0; r < 3; r++) {
        double at = m[r][3];
        for (int c = 0; c < 3; c++)
            at += job->first[c] ? m[r][c] * job->first[c] : 0.0;
        add(job, "%s%.17g", r ? "," : "", at);
    }
    add(job, ")\n");
    add_units(job, find_note(job->info, "space units"));
    if (frame)
        add(job, "measurement frame: %s\n", frame);
}

static void make_header(struct job *job)
{
    const char *content = find_note(job->info, "content");
    const char *units = find_note(job->info, "sample units");
    add(job, "NRRD0005\ntype: %s\ndimension: %d\n", weft_sample_type_names[job->params->type],
        job->components > 1 ? 4 : 3);
    add_place(job);
    add(job, "endian: little\nencoding: raw\n");
    if (content)
        add_text(job, "content", ": ", content);
    if (units)
        add_text(job, "sample units", ": ", units);
    for (size_t i = 0; i < job->info->metadata_count; i++) {
        const struct weft_metadata *entry = &job->info->metadata[i];
        const size_t room = HEADER - job->header_bytes;
        if (!is_own(entry->key) && room > sizeof *entry * 3)
            add_text(job, entry->key, ":=", entry->value);
    }
    add(job, "\n");
}

// ---- samples ------------------------------------------------------------------------------------

// Adds the voxels of a volume to a component of the strip, whose first row and layer these are.
static enum weft_result add_volume(struct job *job, weft_volume *volume, int component, int32_t y,
                                   int32_t z)
{
    const int32_t end[3] = {(int32_t)job->size[0], job->rows, WEFT_BRICK_SIZE};
    struct weft_region region = {{job->first[0], y, z},
                                 {job->first[0] + end[0] - 1, y + end[1] - 1, z + end[2] - 1},
                                 0,
                                 {{{0}, 0, 0}}};
    struct weft_brick_list list = {0};
    weft_brick_store *store = NULL;
    float *values = NULL, brick[WEFT_BRICK_VOXELS];
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    enum weft_result res = weft_volume_find(volume, &region, &list);
    if (res != WEFT_OK)
        return res;
    values = malloc(list.brick_count * sizeof brick + 1);
    if (!values) {
        weft_error(job->log, "not enough memory for %zu bricks", list.brick_count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    res =
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values);
    if (res == WEFT_OK)
        res = weft_brick_store_create(job->log, list.brick_count, info->background, &store);
    if (res == WEFT_OK)
        res = weft_brick_store_add_list(store, &list, values);
    if (res != WEFT_OK)
        goto fail;
    for (int32_t bz = z & ~7; bz < z + end[2]; bz += WEFT_BRICK_SIZE)
        for (int32_t by = y & ~7; by < y + end[1]; by += WEFT_BRICK_SIZE)
            for (int32_t bx = job->first[0] & ~7; bx < job->first[0] + end[0];
                 bx += WEFT_BRICK_SIZE) {
                weft_brick_store_copy(store, (const int32_t[3]){bx, by, bz}, brick);
                for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
                    const int32_t at[3] = {bx + (v & 7) - job->first[0], by + (v >> 3 & 7) - y,
                                           bz + (v >> 6) - z};
                    if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= end[0] || at[1] >= end[1] ||
                        at[2] >= end[2])
                        continue;
                    const size_t row = (size_t)at[2] * (size_t)end[1] + (size_t)at[1];
                    job->strip[(row * (size_t)end[0] + (size_t)at[0]) * (size_t)job->components +
                               (size_t)component] += (double)brick[v];
                }
            }
fail:
    weft_brick_store_destroy(&store);
    weft_brick_list_clear(&list);
    free(values);
    return res;
}

static const double least[WEFT_SAMPLE_FLOAT] = {0, -128, 0, -32768, 0, -0x1p31, 0, -0x1p63};
// The largest doubles that are none too large.
static const double most[WEFT_SAMPLE_FLOAT] = {
    255, 127, 65535, 32767, 4294967295.0, 2147483647.0, 0x1.fffffffffffffp63, 0x1.fffffffffffffp62};

static uint64_t integer_bits(struct job *job, double value)
{
    const enum weft_sample_type type = job->params->type;
    const double whole = nearbyint(value);
    const double inside = isnan(whole)          ? 0.0
                          : whole < least[type] ? least[type]
                          : whole > most[type]  ? most[type]
                                                : whole;
    job->clamped += inside != whole;
    job->rounded += inside == whole && whole != value;
    return inside < 0.0 ? (uint64_t)(int64_t)inside : (uint64_t)inside;
}

static void pack(struct job *job, const double *from, size_t count, unsigned char *out)
{
    const enum weft_sample_type type = job->params->type;
    const size_t size = weft_sample_sizes[type];
    for (size_t i = 0; i < count; i++, out += size) {
        const float single = (float)from[i];
        uint32_t low;
        uint64_t bits;
        memcpy(&low, &single, sizeof low);
        memcpy(&bits, &from[i], sizeof bits);
        bits = type == WEFT_SAMPLE_DOUBLE  ? bits
               : type == WEFT_SAMPLE_FLOAT ? low
                                           : integer_bits(job, from[i]);
        for (size_t b = 0; b < size; b++)
            out[b] = (unsigned char)(bits >> 8 * b);
    }
}

// Layers beyond the box are not written.
static enum weft_result write_strip(struct job *job, int32_t y, int32_t z)
{
    const size_t row = (size_t)job->size[0] * (size_t)job->components;
    const size_t layer = (size_t)job->rows * row;
    const int64_t end = job->first[2] + (int64_t)job->size[2];
    enum weft_result res = WEFT_OK;
    memset(job->strip, 0, WEFT_BRICK_SIZE * layer * sizeof *job->strip);
    for (int c = 0; c < job->components && res == WEFT_OK; c++) {
        res = add_volume(job, job->params->volume[c], c, y, z);
        if (res == WEFT_OK && job->params->rest[c])
            res = add_volume(job, job->params->rest[c], c, y, z);
    }
    for (int32_t k = 0; k < WEFT_BRICK_SIZE && z + k < end && res == WEFT_OK; k++) {
        const uint64_t first =
            (uint64_t)(z + k - job->first[2]) * job->size[1] + (uint64_t)(y - job->first[1]);
        pack(job, job->strip + (size_t)k * layer, layer, job->packed);
        res = weft_output_file_write(&job->file, job->header_bytes + first * job->row_bytes,
                                     job->packed, (size_t)job->rows * job->row_bytes);
    }
    return res;
}

// Strips begin where bricks do, so that each is read once.
static enum weft_result write_samples(struct job *job, int32_t most_rows)
{
    const int64_t end[3] = {0, job->first[1] + (int64_t)job->size[1],
                            job->first[2] + (int64_t)job->size[2]};
    enum weft_result res = WEFT_OK;
    for (int64_t z = job->first[2]; z < end[2] && res == WEFT_OK; z = (z & ~7) + 8)
        for (int64_t y = job->first[1]; y < end[1] && res == WEFT_OK; y += job->rows) {
            const int64_t to = (y & ~7) + most_rows;
            job->rows = (int32_t)((to < end[1] ? to : end[1]) - y);
            res = write_strip(job, (int32_t)y, (int32_t)z);
        }
    return res;
}

// ---- the call -----------------------------------------------------------------------------------

static bool same_box(const struct weft_volume_info *a, const struct weft_volume_info *b)
{
    return !memcmp(a->active_min, b->active_min, sizeof a->active_min) &&
           !memcmp(a->active_max, b->active_max, sizeof a->active_max);
}

static enum weft_result measure(struct job *job, int32_t *rows)
{
    const uint64_t sample = weft_sample_sizes[job->params->type] * (uint64_t)job->components;
    double bytes = (double)sample;
    for (int i = 0; i < 3; i++) {
        job->first[i] = job->info->active_min[i];
        job->size[i] = (uint64_t)((int64_t)job->info->active_max[i] - job->first[i] + 1);
        bytes *= (double)job->size[i];
    }
    if (bytes > (double)WEFT_NRRD_MOST_BYTES) {
        weft_error(job->log, "%s: %llu x %llu x %llu voxels have %.4g bytes; the limit is %llu",
                   job->params->path, (unsigned long long)job->size[0],
                   (unsigned long long)job->size[1], (unsigned long long)job->size[2], bytes,
                   (unsigned long long)WEFT_NRRD_MOST_BYTES);
        return WEFT_ERR_LIMIT;
    }
    job->row_bytes = sample * job->size[0];
    // Whole bricks, at least 8 rows.
    const uint64_t of_row =
        WEFT_BRICK_SIZE * sizeof(double) * (uint64_t)job->components * job->size[0];
    const uint64_t fit = STRIP_BYTES / of_row / WEFT_BRICK_SIZE * WEFT_BRICK_SIZE;
    const uint64_t need = (job->size[1] + 2 * WEFT_BRICK_SIZE) / WEFT_BRICK_SIZE * WEFT_BRICK_SIZE;
    *rows = (int32_t)(fit < WEFT_BRICK_SIZE ? WEFT_BRICK_SIZE : fit < need ? fit : need);
    job->strip = malloc((size_t)*rows * of_row);
    job->packed = malloc((size_t)*rows * job->row_bytes);
    job->header = malloc(HEADER);
    if (job->strip && job->packed && job->header)
        return WEFT_OK;
    weft_error(job->log, "not enough memory for %d rows of %llu voxels", *rows,
               (unsigned long long)job->size[0]);
    return WEFT_ERR_MEMORY;
}

static enum weft_result check(struct job *job)
{
    const struct weft_log *log = job->log;
    const struct weft_nrrd_save_params *params = job->params;
    weft_require(log, params->path != NULL);
    weft_require(log, job->components == 1 || job->components == 3);
    weft_require(log, params->type < WEFT_SAMPLE_TYPE_COUNT);
    for (int c = 0; c < job->components; c++) {
        weft_require(log, params->volume[c] != NULL);
        const struct weft_volume_info *info = weft_volume_get_info(params->volume[c]);
        job->info = c ? job->info : info;
        weft_require(log, !info->empty && same_box(info, job->info));
    }
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

static void warn(const struct job *job)
{
    const char *type = weft_sample_type_names[job->params->type];
    if (job->rounded)
        weft_warn(job->log, "%s: %llu values are rounded to integers (%s)", job->params->path,
                  (unsigned long long)job->rounded, type);
    if (job->clamped)
        weft_warn(job->log, "%s: %llu values are none of %s, and the nearest one or 0 instead",
                  job->params->path, (unsigned long long)job->clamped, type);
}

enum weft_result weft_volume_save_nrrd(const struct weft_nrrd_save_params *params)
{
    struct job job = {.params = params,
                      .log = params->log,
                      .components = params->components ? params->components : 1,
                      .file = {.fd = -1}};
    int32_t rows = 0;
    bool created = false;
    enum weft_result res = check(&job);
    if (res == WEFT_OK)
        res = measure(&job, &rows);
    if (res != WEFT_OK)
        goto fail;
    make_header(&job);
    res = weft_output_file_create(job.log, params->path, params->no_clobber, &job.file);
    if (res != WEFT_OK)
        goto fail;
    created = true;
    res = weft_output_file_write(&job.file, 0, job.header, job.header_bytes);
    if (res == WEFT_OK)
        res = write_samples(&job, rows);
    if (res != WEFT_OK)
        goto fail;
    created = false;
    res = weft_output_file_commit(&job.file);
    if (res == WEFT_OK)
        warn(&job);
fail:
    if (created)
        weft_output_file_discard(&job.file);
    free(job.strip);
    free(job.packed);
    free(job.header);
    return res;
}
