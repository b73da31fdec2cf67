// SPDX-License-Identifier: BSD-3-Clause
// Volumes in memory, as VDB files.
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiles/output/output_file.h"
#include "tiles/process/client.h"
#include "tiles/volume/volume_impl.h"
#include "tiles/volume/volume_wire.h"

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

static enum weft_result send_volume(const weft_volume *volume, weft_reader *writer, uint64_t *size)
{
    const struct weft_volume_info *info = &volume->info;
    const struct weft_volume_memory *m = weft_volume_in_memory(volume);
    struct weft_wire_volume head = {.brick_count = m->brick_count,
                                    .tile_count = m->tile_count,
                                    .background = info->clamp_to_edge ? 0 : info->background,
                                    .boxed = info->clamp_to_edge};
    memcpy(head.name, info->name, sizeof head.name);
    memcpy(head.grid_class, info->grid_class, sizeof head.grid_class);
    memcpy(head.index_to_world, info->index_to_world, sizeof head.index_to_world);
    memcpy(head.box_min, info->active_min, sizeof head.box_min);
    memcpy(head.box_max, info->active_max, sizeof head.box_max);
    struct iovec parts[] = {{&head, sizeof head},
                            {m->brick_origin, m->brick_count * sizeof *m->brick_origin},
                            {m->tiles, m->tile_count * sizeof *m->tiles},
                            {m->values, m->brick_count * WEFT_BRICK_VOXELS * sizeof *m->values}};
    struct weft_wire_request request = {.op = WEFT_WIRE_WRITE};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res =
        weft_reader_call_parts(writer, &request, parts, WEFT_COUNT(parts), &answer, &payload);
    weft_payload_release(&payload);
    *size = answer.count[0];
    return res;
}

enum weft_result weft_volume_save(const weft_volume *volume,
                                  const struct weft_volume_save_params *params)
{
    const struct weft_log *log = params->log;
    struct weft_output_file file = {.fd = -1};
    weft_reader *writer = NULL;
    bool created = false;
    uint64_t size = 0;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, params->path != NULL);
    weft_require(log, weft_volume_in_memory(volume) != NULL);
    res = weft_output_file_create(log, params->path, params->no_clobber, &file);
    if (res)
        goto fail;
    created = true;
    res = weft_reader_start(log, "weft-write-vdb", params->path, file.fd, &params->limits, &writer);
    if (!res)
        res = send_volume(volume, writer, &size);
    if (!res)
        res = check_written(log, &file, size);
    if (res)
        goto fail;
    created = false;
    res = weft_output_file_commit(&file);
fail:
    weft_reader_stop(&writer);
    if (created)
        weft_output_file_discard(&file);
    return res;
}
