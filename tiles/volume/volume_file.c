// SPDX-License-Identifier: BSD-3-Clause
// Volumes in files. What a reader hands over is checked again here, since a damaged file may
// have taken the reader over.
#include "tiles/volume/volume.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiles/process/client.h"
#include "tiles/process/foreign.h"
#include "tiles/volume/region.h"
#include "tiles/volume/volume_impl.h"
#include "tiles/volume/volume_wire.h"

struct file {
    weft_reader *reader;
    enum weft_volume_format format;
    uint64_t output_bytes; // limit of one answer
};

// Who reads files of a format.
static const char *const programs[WEFT_VOLUME_FORMAT_COUNT] = {
    [WEFT_VOLUME_VDB] = "weft-read-vdb",
    [WEFT_VOLUME_NRRD] = "weft-read-nrrd",
    [WEFT_VOLUME_NIFTI] = "weft-read-nifti",
    [WEFT_VOLUME_RAW] = "weft-read-nrrd",
};

static enum weft_result contradiction(const struct weft_log *log, enum weft_volume_format format,
                                      const char *what)
{
    weft_error(log, "%s contradicts itself: %s", programs[format], what);
    return WEFT_ERR_FORMAT;
}

// ---- descriptions -------------------------------------------------------------------------------

static bool terminated(const char *text, size_t size)
{
    return memchr(text, 0, size) != NULL;
}

static bool one_of(const char *text, const char *const *list)
{
    for (; *list; list++)
        if (!strcmp(text, *list))
            return true;
    return false;
}

// A bool of any other bit pattern must not even be looked at.
static bool bools_valid(const unsigned char *info)
{
    return info[offsetof(struct weft_volume_info, supported)] <= 1 &&
           info[offsetof(struct weft_volume_info, empty)] <= 1 &&
           info[offsetof(struct weft_volume_info, counted)] <= 1 &&
           info[offsetof(struct weft_volume_info, rounded)] <= 1 &&
           info[offsetof(struct weft_volume_info, clamp_to_edge)] <= 1;
}

static bool box_valid(const struct weft_volume_info *info)
{
    for (int i = 0; i < 3; i++)
        if (info->active_min[i] > info->active_max[i] || info->active_min[i] < -WEFT_INDEX_LIMIT ||
            info->active_max[i] > WEFT_INDEX_LIMIT)
            return false;
    return true;
}

// Voxels of dense files fill a box that begins at 0, in a list, too.
static bool dense_valid(const struct weft_volume_info *info)
{
    uint64_t voxels = 1, bricks = 1;
    for (int i = 0; i < 3; i++) {
        if (info->active_min[i] != 0 || info->active_max[i] < 0 ||
            info->active_max[i] >= WEFT_INDEX_LIMIT)
            return false;
        voxels *= (uint64_t)info->active_max[i] + 1;
        bricks *= (uint64_t)info->active_max[i] / WEFT_BRICK_SIZE + 1;
    }
    return info->supported && info->counted && info->clamp_to_edge &&
           info->active_voxels == voxels && (info->bricks == 0 || info->bricks == bricks);
}

static bool info_valid(const struct weft_volume_info *info, enum weft_volume_format format)
{
    static const char *const types[] = {"float", "double", "half", "int32", "bool", NULL};
    static const char *const vectors[] = {"vec3s", "vec3d", "vec3h", "vec3i", NULL};
    const bool vdb = format == WEFT_VOLUME_VDB;
    bool sliceable = weft_transform_valid(info->index_to_world) &&
                     one_of(info->type, !vdb                    ? weft_sample_type_names
                                        : info->components == 3 ? vectors
                                                                : types);
    return (vdb ? !info->clamp_to_edge : dense_valid(info)) &&
           terminated(info->name, sizeof info->name) && terminated(info->type, sizeof info->type) &&
           terminated(info->grid_class, sizeof info->grid_class) &&
           terminated(info->problem, sizeof info->problem) && (!info->supported || sliceable) &&
           (info->components == 1 || info->components == 3) && info->component >= 0 &&
           info->component < info->components && info->supported == (info->result == WEFT_OK) &&
           info->empty == !info->active_voxels &&
           info->bricks <= UINT64_MAX / (WEFT_BRICK_VOXELS * sizeof(float)) &&
           info->memory_bytes == info->bricks * WEFT_BRICK_VOXELS * sizeof(float) &&
           info->largest_rounding >= 0 && info->largest_rounding <= (vdb ? 64 : 0x1p39);
}

static bool metadata_valid(const struct weft_volume_info *info)
{
    for (size_t i = 0; i < info->metadata_count; i++)
        if (!terminated(info->metadata[i].key, sizeof info->metadata[i].key) ||
            !terminated(info->metadata[i].value, sizeof info->metadata[i].value))
            return false;
    return true;
}

static void clean_texts(struct weft_volume_info *info)
{
    weft_text_clean(info->name, false);
    weft_text_clean(info->type, false);
    weft_text_clean(info->grid_class, false);
    weft_text_clean(info->problem, false);
    for (size_t i = 0; i < info->metadata_count; i++) {
        weft_text_clean(info->metadata[i].key, false);
        weft_text_clean(info->metadata[i].value, true);
    }
}

// The next grid of a payload, with its metadata copied.
static enum weft_result take_grid(const struct weft_log *log, enum weft_volume_format format,
                                  const struct weft_payload *payload, size_t *at,
                                  struct weft_volume_info *out)
{
    const unsigned char *data = (const unsigned char *)payload->data + *at;
    size_t left = payload->size - *at, bytes;
    struct weft_volume_info info;
    if (left < sizeof(struct weft_wire_grid) || !bools_valid(data))
        return contradiction(log, format, "a grid's description");
    memcpy(&info, data, sizeof info);
    left -= sizeof(struct weft_wire_grid);
    info.metadata = NULL;
    if (!weft_size_mul(info.metadata_count, sizeof *info.metadata, &bytes) || bytes > left ||
        !info_valid(&info, format))
        return contradiction(log, format, "a grid's description");
    info.format = format;
    info.metadata = malloc(bytes + 1);
    if (!info.metadata) {
        weft_error(log, "not enough memory for %zu metadata entries", info.metadata_count);
        return WEFT_ERR_MEMORY;
    }
    memcpy(info.metadata, data + sizeof(struct weft_wire_grid), bytes);
    if (!metadata_valid(&info)) {
        free(info.metadata);
        return contradiction(log, format, "a grid's metadata");
    }
    clean_texts(&info);
    *at += sizeof(struct weft_wire_grid) + bytes;
    *out = info;
    return WEFT_OK;
}

// With a layout, if there is one, of which the default spacing is filled in.
static struct weft_volume_open_params complete_params(const struct weft_volume_open_params *params,
                                                      struct weft_raw_layout *raw)
{
    struct weft_volume_open_params out = *params;
    *raw = params->raw ? *params->raw : (struct weft_raw_layout){0};
    if (raw->spacing[0] == 0.0 && raw->spacing[1] == 0.0 && raw->spacing[2] == 0.0)
        raw->spacing[0] = raw->spacing[1] = raw->spacing[2] = 1.0;
    out.raw = params->raw ? raw : NULL;
    return out;
}

static bool layout_valid(const struct weft_raw_layout *raw)
{
    for (int i = 0; i < 3; i++)
        if (raw->size[i] < 1 || raw->size[i] > WEFT_INDEX_LIMIT || !isfinite(raw->spacing[i]) ||
            raw->spacing[i] == 0.0 || !isfinite(raw->origin[i]))
            return false;
    return raw->type < WEFT_SAMPLE_TYPE_COUNT;
}

// An empty file is what its name or a layout says; the reader finds that it has nothing.
static enum weft_result recognise(const struct weft_volume_open_params *params, int fd,
                                  enum weft_volume_format *out)
{
    unsigned char start[8] = {0};
    const ssize_t size = pread(fd, start, sizeof start, 0);
    *out = params->raw ? WEFT_VOLUME_RAW
           : size > 0  ? weft_volume_recognise(start, (size_t)size)
                       : WEFT_VOLUME_VDB;
    if (*out != WEFT_VOLUME_MEMORY)
        return WEFT_OK;
    const char *name = weft_foreign_name(start, (size_t)(size > 0 ? size : 0));
    if (name)
        weft_error(params->log, "%s is %s, not a volume (a VDB, NRRD or NIfTI file)", params->path,
                   name);
    else
        weft_error(params->log,
                   "%s: neither a VDB, an NRRD nor a NIfTI file: it starts with bytes %02x %02x "
                   "%02x %02x (samples without a header need a layout)",
                   params->path, start[0], start[1], start[2], start[3]);
    return WEFT_ERR_FORMAT;
}

static enum weft_result start(const struct weft_volume_open_params *params,
                              enum weft_volume_format *format, weft_reader **reader)
{
    *reader = NULL;
    const struct weft_log *log = params->log;
    struct weft_limits limits;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct stat stat;
    int fd = -1;
    weft_require(log, params->path != NULL);
    weft_require(log, !params->raw || layout_valid(params->raw));
    res = WEFT_ERR_OPEN;
    // Without waiting for somebody to write to a named pipe.
    fd = open(params->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &stat)) {
        weft_error(log, "cannot open %s: %s", params->path, strerror(errno));
        goto fail;
    }
    if (!S_ISREG(stat.st_mode)) {
        weft_error(log, "%s is %s", params->path,
                   S_ISDIR(stat.st_mode) ? "a folder" : "not a regular file");
        goto fail;
    }
    res = recognise(params, fd, format);
    if (res != WEFT_OK)
        goto fail;
    // Nodes of few voxels and tiles that compress well take some 100 times their bytes in the file.
    // Of samples that are encoded the reader compares what they take with what is stored.
    limits = *format == WEFT_VOLUME_VDB
                 ? weft_reader_limits(&params->limits, (uint64_t)stat.st_size)
                 : params->limits;
    res = weft_reader_start(log, programs[*format], params->path, fd, &limits, reader);
fail:
    if (fd >= 0)
        close(fd);
    return res;
}

// ---- bricks -------------------------------------------------------------------------------------

static bool origin_valid(const int32_t origin[3], int32_t size)
{
    for (int i = 0; i < 3; i++)
        if (origin[i] % size || origin[i] < -WEFT_INDEX_LIMIT || origin[i] >= WEFT_INDEX_LIMIT)
            return false;
    return true;
}

static bool list_valid(const struct weft_brick_list *list, const struct weft_region *region)
{
    for (size_t i = 0; i < list->brick_count; i++)
        if (!origin_valid(list->brick_origin[i], WEFT_BRICK_SIZE) ||
            !weft_region_meets(region, list->brick_origin[i], WEFT_BRICK_SIZE) ||
            (i && weft_compare_origins(list->brick_origin[i - 1], list->brick_origin[i]) >= 0))
            return false;
    for (size_t i = 0; i < list->tile_count; i++) {
        const struct weft_volume_tile *tile = &list->tiles[i];
        if ((tile->size != 8 && tile->size != 128 && tile->size != 4096) ||
            !origin_valid(tile->origin, tile->size) ||
            !weft_region_meets(region, tile->origin, tile->size) ||
            (i && weft_compare_origins(list->tiles[i - 1].origin, tile->origin) >= 0))
            return false;
    }
    return true;
}

static enum weft_result take_list(const weft_volume *volume, const struct weft_region *region,
                                  const struct weft_wire_answer *answer,
                                  const struct weft_payload *payload, struct weft_brick_list *out)
{
    struct weft_brick_list list = {0};
    uint64_t bricks = answer->count[0], tiles = answer->count[1];
    if (bricks > payload->size / sizeof *list.brick_origin ||
        tiles > payload->size / sizeof *list.tiles ||
        payload->size != bricks * sizeof *list.brick_origin + tiles * sizeof *list.tiles ||
        bricks > volume->info.bricks)
        return contradiction(volume->log, volume->info.format, "the number of bricks");
    size_t brick_bytes = (size_t)bricks * sizeof *list.brick_origin;
    list.brick_origin = malloc(brick_bytes + 1);
    list.tiles = malloc(payload->size - brick_bytes + 1);
    if (!list.brick_origin || !list.tiles) {
        weft_error(volume->log, "not enough memory for a list of %zu bricks", (size_t)bricks);
        weft_brick_list_clear(&list);
        return WEFT_ERR_MEMORY;
    }
    if (payload->size) {
        memcpy(list.brick_origin, payload->data, brick_bytes);
        memcpy(list.tiles, (const char *)payload->data + brick_bytes, payload->size - brick_bytes);
    }
    list.brick_count = (size_t)bricks;
    list.tile_count = (size_t)tiles;
    if (!list_valid(&list, region)) {
        weft_brick_list_clear(&list);
        return contradiction(volume->log, volume->info.format, "a list of bricks");
    }
    *out = list;
    return WEFT_OK;
}

// All bricks of a dense file's box are there: those in reach of the region are found without its
// reader. What lies beyond a face is in reach of the bricks at that face.
static enum weft_result find_dense(weft_volume *volume, const struct weft_region *region,
                                   struct weft_brick_list *out)
{
    const struct weft_volume_info *info = &volume->info;
    struct weft_brick_list list = {0};
    int32_t first[3], last[3], at[3];
    size_t most = 1;
    bool fits = true;
    for (int i = 0; i < 3; i++) {
        const int32_t end = info->active_max[i];
        first[i] = (region->min[i] < 0 ? 0 : region->min[i] > end ? end : region->min[i]) & ~7;
        last[i] = (region->max[i] > end ? end : region->max[i] < 0 ? 0 : region->max[i]) & ~7;
        fits = fits && (last[i] < first[i] ||
                        weft_size_mul(most, (size_t)(last[i] - first[i]) / 8 + 1, &most));
    }
    list.brick_origin = fits && most <= SIZE_MAX / sizeof *list.brick_origin
                            ? malloc(most * sizeof *list.brick_origin)
                            : NULL;
    list.tiles = malloc(1);
    if (!list.brick_origin || !list.tiles) {
        weft_error(volume->log, "not enough memory for a list of %zu bricks", most);
        weft_brick_list_clear(&list);
        return WEFT_ERR_MEMORY;
    }
    for (at[2] = first[2]; at[2] <= last[2]; at[2] += WEFT_BRICK_SIZE)
        for (at[1] = first[1]; at[1] <= last[1]; at[1] += WEFT_BRICK_SIZE)
            for (at[0] = first[0]; at[0] <= last[0]; at[0] += WEFT_BRICK_SIZE)
                if (weft_volume_brick_meets(info, region, at))
                    memcpy(list.brick_origin[list.brick_count++], at, sizeof at);
    *out = list;
    return WEFT_OK;
}

static enum weft_result find(weft_volume *volume, const struct weft_region *region,
                             struct weft_brick_list *out)
{
    const struct file *file = volume->data;
    if (volume->info.clamp_to_edge)
        return find_dense(volume, region, out);
    struct weft_wire_request request = {.op = WEFT_WIRE_FIND, .payload_bytes = sizeof *region};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res = weft_reader_call(file->reader, &request, region, &answer, &payload);
    if (!res)
        res = take_list(volume, region, &answer, &payload, out);
    weft_payload_release(&payload);
    return res;
}

static enum weft_result read_batch(weft_volume *volume, size_t count,
                                   const int32_t (*brick_origin)[3], float *values)
{
    const struct file *file = volume->data;
    size_t bytes = count * WEFT_BRICK_VOXELS * sizeof *values;
    struct weft_wire_request request = {.op = WEFT_WIRE_READ,
                                        .payload_bytes = count * sizeof *brick_origin};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res =
        weft_reader_call(file->reader, &request, brick_origin, &answer, &payload);
    if (!res && payload.size != bytes)
        res = contradiction(volume->log, volume->info.format, "the number of voxels");
    if (!res)
        memcpy(values, payload.data, bytes);
    weft_payload_release(&payload);
    return res;
}

// In batches: shared memory comes on top of the caller's, and one answer is limited.
static enum weft_result read_bricks(weft_volume *volume, size_t count,
                                    const int32_t (*brick_origin)[3], float *values)
{
    const struct file *file = volume->data;
    size_t batch = 16384;
    uint64_t fits = file->output_bytes / (WEFT_BRICK_VOXELS * sizeof *values);
    enum weft_result res = WEFT_OK;
    if (file->output_bytes && fits < batch)
        batch = fits ? (size_t)fits : 1;
    for (size_t done = 0; done < count && !res; done += batch) {
        size_t n = count - done < batch ? count - done : batch;
        res = read_batch(volume, n, brick_origin + done, values + done * WEFT_BRICK_VOXELS);
    }
    return res;
}

static void clear(void *data)
{
    struct file *file = data;
    weft_reader_stop(&file->reader);
}

static const struct weft_volume_backend backend = {
    .data_bytes = sizeof(struct file), .find = find, .read = read_bricks, .clear = clear};

// ---- opening and listing ------------------------------------------------------------------------

static void warn_of_values(const struct weft_volume_open_params *params,
                           const struct weft_volume_info *info)
{
    const char *path = params->path, *name = info->name;
    if (info->values_rounded)
        weft_warn(params->log,
                  "%s: grid '%s': %llu integers are changed by up to %g, since no float holds them",
                  path, name, (unsigned long long)info->values_rounded, info->largest_rounding);
    if (info->values_infinite)
        weft_warn(params->log,
                  "%s: grid '%s': %llu values are beyond the range of floats (3.4e38): infinite",
                  path, name, (unsigned long long)info->values_infinite);
    if (info->values_tiny)
        weft_warn(params->log,
                  "%s: grid '%s': %llu values are under 1.2e-38: floats lose their bits, or are 0",
                  path, name, (unsigned long long)info->values_tiny);
}

// A volume that is being opened: asked, and not answered yet. What could not even be asked is
// opened when it is awaited, so that it fails there.
struct weft_volume_opening {
    struct weft_volume_open_params params; // with texts and a layout of its own
    struct weft_raw_layout raw;
    weft_volume *volume; // NULL: not asked
};

// Starts the reader, and asks it.
static enum weft_result ask(const struct weft_volume_open_params *asked, weft_volume **out)
{
    struct weft_raw_layout raw;
    const struct weft_volume_open_params complete = complete_params(asked, &raw);
    const struct weft_volume_open_params *params = &complete;
    const struct iovec parts[] = {
        {&raw, params->raw ? sizeof raw : 0},
        {(void *)(uintptr_t)params->grid, params->grid ? strlen(params->grid) + 1 : 0}};
    const struct weft_wire_request request = {.op = WEFT_WIRE_OPEN,
                                              .rest = params->rest,
                                              .raw = params->raw != NULL,
                                              .component = (uint32_t)params->component};
    weft_volume *volume = NULL;
    struct file *file;
    enum weft_result res = weft_volume_make(params->log, &backend, &volume);
    if (res != WEFT_OK)
        return res;
    file = volume->data;
    file->output_bytes = params->limits.output_bytes;
    res = start(params, &file->format, &file->reader);
    if (res == WEFT_OK)
        res = weft_reader_ask(file->reader, &request, parts, WEFT_COUNT(parts));
    if (res == WEFT_OK)
        *out = volume;
    else
        weft_volume_destroy(&volume);
    return res;
}

// Takes the answer.
static enum weft_result finish(const struct weft_volume_open_params *params, weft_volume *volume)
{
    const struct file *file = volume->data;
    struct weft_wire_answer answer;
    struct weft_payload payload;
    size_t at = 0;
    enum weft_result res = weft_reader_answer(file->reader, &answer, &payload);
    if (res == WEFT_OK)
        res = take_grid(params->log, file->format, &payload, &at, &volume->info);
    if (res == WEFT_OK &&
        (at != payload.size || !volume->info.supported || !box_valid(&volume->info) ||
         volume->info.component != params->component ||
         (volume->info.clamp_to_edge && !volume->info.bricks)))
        res = contradiction(params->log, file->format, "the opened grid");
    if (res == WEFT_OK && !params->rest)
        warn_of_values(params, &volume->info);
    weft_payload_release(&payload);
    return res;
}

enum weft_result weft_volume_open(const struct weft_volume_open_params *params, weft_volume **out)
{
    *out = NULL;
    weft_volume *volume = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);
    weft_require(params->log, params->component >= 0 && params->component <= 2);
    res = ask(params, &volume);
    if (res == WEFT_OK)
        res = finish(params, volume);
    if (res == WEFT_OK)
        *out = volume;
    else
        weft_volume_destroy(&volume);
fail:
    return res;
}

enum weft_result weft_volume_begin(const struct weft_volume_open_params *params,
                                   weft_volume_opening **out)
{
    *out = NULL;
    weft_volume_opening *opening = NULL;
    struct weft_volume_open_params quiet = *params;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);
    weft_require(params->log, params->component >= 0 && params->component <= 2);
    res = WEFT_ERR_MEMORY;
    opening = calloc(1, sizeof *opening);
    if (!opening)
        goto fail;
    opening->params = *params;
    opening->params.path = strdup(params->path);
    opening->params.grid = params->grid ? strdup(params->grid) : NULL;
    if (params->raw) {
        opening->raw = *params->raw;
        opening->params.raw = &opening->raw;
    }
    if (!opening->params.path || (params->grid && !opening->params.grid))
        goto fail;
    quiet.log = NULL;
    ask(&quiet, &opening->volume);
    *out = opening;
    return WEFT_OK;
fail:
    if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "not enough memory to open %s", params->path);
    weft_volume_abandon(&opening);
    return res;
}

enum weft_result weft_volume_await(weft_volume_opening **opening, weft_volume **out)
{
    const struct weft_volume_open_params *params = &(*opening)->params;
    weft_volume *volume = (*opening)->volume;
    enum weft_result res;
    *out = NULL;
    if (volume) {
        const struct file *file = volume->data;
        volume->log = params->log;
        weft_reader_set_log(file->reader, params->log);
        res = finish(params, volume);
        if (res == WEFT_OK) {
            *out = volume;
            (*opening)->volume = NULL;
        }
    } else {
        res = weft_volume_open(params, out);
    }
    weft_volume_abandon(opening);
    return res;
}

void weft_volume_abandon(weft_volume_opening **opening)
{
    if (!opening || !*opening)
        return;
    weft_volume_destroy(&(*opening)->volume);
    free((void *)(uintptr_t)(*opening)->params.path);
    free((void *)(uintptr_t)(*opening)->params.grid);
    free(*opening);
    *opening = NULL;
}

// Claims of the file's writer, nobody's fault if they make no sense.
static void mend_claims(struct weft_volume_info *info)
{
    if (box_valid(info))
        return;
    info->counted = false;
    info->empty = true;
    info->active_voxels = 0;
    memset(info->active_min, 0, sizeof info->active_min);
    memset(info->active_max, 0, sizeof info->active_max);
}

enum weft_result weft_volume_list_load(const struct weft_volume_open_params *params,
                                       struct weft_volume_list *out)
{
    *out = (struct weft_volume_list){0};
    weft_reader *reader = NULL;
    enum weft_volume_format format = WEFT_VOLUME_MEMORY;
    struct weft_volume_list list = {0};
    struct weft_wire_request request = {.op = WEFT_WIRE_LIST, .raw = params->raw != NULL};
    struct weft_raw_layout raw;
    const struct weft_volume_open_params complete = complete_params(params, &raw);
    const struct iovec layout = {&raw, params->raw ? sizeof raw : 0};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    size_t at = 0;
    enum weft_result res = start(&complete, &format, &reader);
    if (!res)
        res = weft_reader_call_parts(reader, &request, &layout, 1, &answer, &payload);
    if (res)
        goto fail;
    if (answer.count[0] > payload.size / sizeof(struct weft_wire_grid)) {
        res = contradiction(params->log, format, "the number of grids");
        goto fail;
    }
    res = WEFT_ERR_MEMORY;
    list.grids = calloc((size_t)answer.count[0] + 1, sizeof *list.grids);
    if (!list.grids)
        goto fail;
    for (res = WEFT_OK; !res && list.count < answer.count[0];) {
        res = take_grid(params->log, format, &payload, &at, &list.grids[list.count]);
        if (!res)
            mend_claims(&list.grids[list.count++]);
    }
    if (!res && at != payload.size)
        res = contradiction(params->log, format, "the size of the list");
    if (res)
        goto fail;
    *out = list;
    list = (struct weft_volume_list){0};
fail:
    weft_payload_release(&payload);
    weft_volume_list_clear(&list);
    weft_reader_stop(&reader);
    return res;
}

void weft_volume_list_clear(struct weft_volume_list *list)
{
    if (!list)
        return;
    for (size_t i = 0; i < list->count; i++)
        free(list->grids[i].metadata);
    free(list->grids);
    *list = (struct weft_volume_list){0};
}
