// SPDX-License-Identifier: BSD-3-Clause
// VDB files, brick by brick.
#include "tiles/volume/volume_writer.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiles/output/output_file.h"
#include "tiles/process/client.h"
#include "tiles/volume/volume_impl.h"
#include "tiles/volume/volume_wire.h"

struct weft_volume_writer {
    const struct weft_log *log;
    struct weft_output_file file; // fd -1: none was created
    weft_reader *process;
    bool asked; // a lot has no answer yet
    enum weft_result failed;
    int grid_count;
    int components[WEFT_VOLUME_WRITER_GRIDS];
};

// ---- what is written ----------------------------------------------------------------------------

static enum weft_result check_grid(const struct weft_log *log,
                                   const struct weft_volume_writer_params *params, int i)
{
    const struct weft_wire_volume *none = NULL;
    const struct weft_volume_grid *grid = &params->grid[i];
    const char *name = grid->name ? grid->name : "density";
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, grid->components == 0 || grid->components == 1 || grid->components == 3);
    weft_require(log, grid->metadata_count == 0 || grid->metadata != NULL);
    weft_require(log, strlen(name) < sizeof none->name);
    weft_require(log, !grid->grid_class || strlen(grid->grid_class) < sizeof none->grid_class);
    weft_require(log, !grid->vector_type || strlen(grid->vector_type) < sizeof none->vector_type);
    for (int other = 0; other < i; other++) {
        const char *before = params->grid[other].name;
        if (strcmp(before ? before : "density", name) == 0) {
            weft_error(log, "two grids of one file would have the name '%s'", name);
            goto fail;
        }
    }
    res = WEFT_OK;
fail:
    return res;
}

static bool all_zero(const double m[3][4])
{
    for (int i = 0; i < 12; i++)
        if (m[i / 4][i % 4] != 0.0)
            return false;
    return true;
}

static enum weft_result make_head(const struct weft_log *log, const struct weft_volume_grid *grid,
                                  struct weft_wire_volume *out)
{
    *out = (struct weft_wire_volume){.metadata_count = grid->metadata_count,
                                     .components = grid->components == 3 ? 3 : 1,
                                     .background = grid->background,
                                     .boxed = grid->boxed};
    snprintf(out->name, sizeof out->name, "%s", grid->name ? grid->name : "density");
    snprintf(out->grid_class, sizeof out->grid_class, "%s",
             grid->grid_class ? grid->grid_class : "fog volume");
    snprintf(out->vector_type, sizeof out->vector_type, "%s",
             grid->vector_type ? grid->vector_type : "invariant");
    memcpy(out->box_min, grid->box_min, sizeof out->box_min);
    memcpy(out->box_max, grid->box_max, sizeof out->box_max);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            out->index_to_world[r][c] =
                all_zero(grid->index_to_world) ? r == c : grid->index_to_world[r][c];
    if (weft_transform_valid(out->index_to_world))
        return WEFT_OK;
    weft_error(log, "grid '%s': its transform is singular or not finite", out->name);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result begin(weft_volume_writer *writer,
                              const struct weft_volume_writer_params *params)
{
    struct weft_wire_volume head[WEFT_VOLUME_WRITER_GRIDS];
    struct iovec parts[2 * WEFT_VOLUME_WRITER_GRIDS];
    const struct weft_wire_request request = {.op = WEFT_WIRE_WRITE_BEGIN};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    int count = 0;
    for (int i = 0; i < params->grid_count; i++) {
        const struct weft_volume_grid *grid = &params->grid[i];
        const enum weft_result res = make_head(params->log, grid, &head[i]);
        if (res != WEFT_OK)
            return res;
        writer->components[i] = (int)head[i].components;
        parts[count++] = (struct iovec){&head[i], sizeof head[i]};
        parts[count++] = (struct iovec){(void *)(uintptr_t)grid->metadata,
                                        grid->metadata_count * sizeof *grid->metadata};
    }
    const enum weft_result res =
        weft_reader_call_parts(writer->process, &request, parts, count, &answer, &payload);
    weft_payload_release(&payload);
    return res;
}

enum weft_result weft_volume_writer_create(const struct weft_volume_writer_params *params,
                                           weft_volume_writer **out)
{
    *out = NULL;
    const struct weft_log *log = params->log;
    weft_volume_writer *writer = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, params->path != NULL);
    weft_require(log, params->grid_count >= 1 && params->grid_count <= WEFT_VOLUME_WRITER_GRIDS);
    weft_require(log, params->grid != NULL);
    for (int i = 0; i < params->grid_count; i++) {
        res = check_grid(log, params, i);
        if (res != WEFT_OK)
            return res;
    }
    res = WEFT_ERR_MEMORY;
    writer = calloc(1, sizeof *writer);
    if (!writer) {
        weft_error(log, "%s: not enough memory to write a volume", params->path);
        goto fail;
    }
    writer->log = log;
    writer->file.fd = -1;
    writer->grid_count = params->grid_count;
    res = weft_output_file_create(log, params->path, params->no_clobber, &writer->file);
    if (res != WEFT_OK)
        writer->file.fd = -1;
    if (res == WEFT_OK)
        res = weft_reader_start(log, "weft-write-vdb", params->path, writer->file.fd,
                                &params->limits, &writer->process);
    if (res == WEFT_OK)
        res = begin(writer, params);
    if (res != WEFT_OK)
        goto fail;
    *out = writer;
    return WEFT_OK;
fail:
    weft_volume_writer_discard(&writer);
    return res;
}

// ---- lots ---------------------------------------------------------------------------------------

// Waits for the answer about the lot before.
static enum weft_result settle(weft_volume_writer *writer)
{
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    if (writer->asked && writer->failed == WEFT_OK)
        writer->failed = weft_reader_answer(writer->process, &answer, &payload);
    weft_payload_release(&payload);
    writer->asked = false;
    return writer->failed;
}

static enum weft_result check_place(const struct weft_log *log, const int32_t origin[3],
                                    int32_t size)
{
    bool good = size == 8 || size == 128 || size == 4096;
    for (int a = 0; good && a < 3; a++)
        good = origin[a] % size == 0 && origin[a] >= -WEFT_INDEX_LIMIT &&
               origin[a] <= WEFT_INDEX_LIMIT - size;
    if (good)
        return WEFT_OK;
    weft_error(log, "no brick or tile of %d voxels a side begins at (%d, %d, %d)", size, origin[0],
               origin[1], origin[2]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_lot(const weft_volume_writer *writer,
                                  const struct weft_volume_lot *lot)
{
    const struct weft_log *log = writer->log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    size_t bytes;
    weft_require(log, lot->grid >= 0 && lot->grid < writer->grid_count);
    weft_require(log, lot->brick_count == 0 || (lot->brick_origin && lot->values));
    weft_require(log, lot->tile_count == 0 || lot->tiles);
    weft_require(log, lot->tile_count == 0 || writer->components[lot->grid] == 1);
    weft_require(log,
                 weft_size_mul(lot->brick_count, 3 * WEFT_BRICK_VOXELS * sizeof(float), &bytes));
    weft_require(log, weft_size_mul(lot->tile_count, sizeof *lot->tiles, &bytes));
    res = WEFT_OK;
    for (size_t i = 0; res == WEFT_OK && i < lot->brick_count; i++)
        res = check_place(log, lot->brick_origin[i], WEFT_BRICK_SIZE);
    for (size_t i = 0; res == WEFT_OK && i < lot->tile_count; i++)
        res = check_place(log, lot->tiles[i].origin, lot->tiles[i].size);
fail:
    return res;
}

enum weft_result weft_volume_writer_add(weft_volume_writer *writer,
                                        const struct weft_volume_lot *lot)
{
    enum weft_result res = check_lot(writer, lot);
    if (res == WEFT_OK)
        res = settle(writer);
    if (res != WEFT_OK)
        return writer->failed = res;
    const size_t block = WEFT_BRICK_VOXELS * sizeof(float);
    struct weft_wire_lot head = {lot->brick_count, lot->tile_count};
    const struct iovec parts[] = {
        {&head, sizeof head},
        {(void *)(uintptr_t)lot->brick_origin, lot->brick_count * sizeof *lot->brick_origin},
        {(void *)(uintptr_t)lot->tiles, lot->tile_count * sizeof *lot->tiles},
        {(void *)(uintptr_t)lot->values,
         lot->brick_count * (size_t)writer->components[lot->grid] * block}};
    const struct weft_wire_request request = {.op = WEFT_WIRE_WRITE_ADD,
                                              .part = (uint32_t)lot->grid};
    writer->failed = weft_reader_ask(writer->process, &request, parts, WEFT_COUNT(parts));
    writer->asked = writer->failed == WEFT_OK;
    return writer->failed;
}

// ---- the end ------------------------------------------------------------------------------------

// The writer is believed as little as a reader: the file begins as one, and has the size told.
static enum weft_result check_written(const struct weft_log *log,
                                      const struct weft_output_file *file, uint64_t told)
{
    static const char magic[8] = {' ', 'B', 'D', 'V'};
    char start[sizeof magic] = "";
    struct stat st;
    if (fstat(file->fd, &st) || pread(file->fd, start, sizeof start, 0) < 0) {
        weft_error(log, "cannot write %s: %s", file->path, strerror(errno));
        return WEFT_ERR_WRITE;
    }
    if ((uint64_t)st.st_size == told && told > sizeof magic && !memcmp(start, magic, sizeof magic))
        return WEFT_OK;
    weft_error(
        log,
        "cannot write %s: weft-write-vdb tells of %llu bytes of a VDB file, and left %llu of %s",
        file->path, (unsigned long long)told, (unsigned long long)st.st_size,
        memcmp(start, magic, sizeof magic) ? "none" : "one");
    return WEFT_ERR_WRITE;
}

enum weft_result weft_volume_writer_finish(weft_volume_writer **writer, uint64_t *bytes)
{
    weft_volume_writer *w = *writer;
    const struct weft_wire_request request = {.op = WEFT_WIRE_WRITE};
    struct weft_wire_answer answer = {0};
    struct weft_payload payload = {0};
    enum weft_result res = settle(w);
    if (res == WEFT_OK)
        res = weft_reader_call(w->process, &request, NULL, &answer, &payload);
    weft_payload_release(&payload);
    if (res == WEFT_OK)
        res = check_written(w->log, &w->file, answer.count[0]);
    weft_reader_stop(&w->process);
    if (res == WEFT_OK) {
        res = weft_output_file_commit(&w->file);
        w->file.fd = -1;
    }
    if (bytes)
        *bytes = res == WEFT_OK ? answer.count[0] : 0;
    weft_volume_writer_discard(writer);
    return res;
}

void weft_volume_writer_discard(weft_volume_writer **writer)
{
    if (!writer || !*writer)
        return;
    weft_reader_stop(&(*writer)->process);
    if ((*writer)->file.fd >= 0)
        weft_output_file_discard(&(*writer)->file);
    free(*writer);
    *writer = NULL;
}
