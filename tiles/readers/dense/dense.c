// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/dense/dense.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "filter/check.h"

#define WIDE(x) ((unsigned long long)(x))

void weft_dense_clear(struct weft_dense *dense)
{
    free(dense->memory);
    if (dense->owns_fd && dense->fd >= 0)
        close(dense->fd);
    *dense = (struct weft_dense){.fd = -1};
}

// ---- what headers tell --------------------------------------------------------------------------

void weft_dense_note(struct weft_dense *dense, const char *key, const char *format, ...)
{
    struct weft_metadata *entry = &dense->metadata[dense->metadata_count];
    va_list args;
    if (dense->metadata_count == WEFT_DENSE_METADATA)
        return;
    va_start(args, format);
    const int length = vsnprintf(entry->value, sizeof entry->value, format, args);
    va_end(args);
    if (length <= 0)
        return;
    if ((size_t)length >= sizeof entry->value)
        memcpy(entry->value + sizeof entry->value - 4, "...", 4);
    snprintf(entry->key, sizeof entry->key, "%s", key);
    dense->metadata_count++;
}

enum weft_result weft_dense_count_bytes(struct weft_server *server, const struct weft_dense *dense,
                                        uint64_t *bytes)
{
    const uint64_t most = UINT64_C(1) << 62;
    *bytes = weft_sample_sizes[dense->type];
    for (int i = 0; i < 3 + dense->other_count; i++) {
        const uint64_t size = i < 3 ? dense->space[i].size : dense->other[i - 3].size;
        if (size < 1 || size > WEFT_INDEX_LIMIT)
            return weft_server_fail(server, WEFT_ERR_FORMAT,
                                    "an axis of %llu samples; 1 to %d are possible", WIDE(size),
                                    WEFT_INDEX_LIMIT);
        if (size > most / *bytes)
            return weft_server_fail(server, WEFT_ERR_LIMIT,
                                    "%llu times %llu bytes of samples; the limit is %llu",
                                    WIDE(size), WIDE(*bytes), WIDE(most));
        *bytes *= size;
    }
    return WEFT_OK;
}

void weft_dense_pack(enum weft_sample_type type, struct weft_dense_axis *const *axis, int count)
{
    int64_t stride = (int64_t)weft_sample_sizes[type];
    for (int i = 0; i < count; i++) {
        axis[i]->stride = stride;
        if (__builtin_mul_overflow(stride, (int64_t)axis[i]->size, &stride))
            return; // weft_dense_count_bytes refuses them
    }
}

enum weft_result weft_dense_lie_in_file(struct weft_server *server, struct weft_dense *dense,
                                        int fd, uint64_t start)
{
    uint64_t bytes;
    struct stat st;
    enum weft_result res = weft_dense_count_bytes(server, dense, &bytes);
    if (res != WEFT_OK)
        return res;
    if (fstat(fd, &st))
        return weft_server_fail(server, WEFT_ERR_OPEN, "cannot read the samples: %s",
                                strerror(errno));
    const uint64_t size = (uint64_t)st.st_size;
    if (start > size || bytes > size - start)
        return weft_server_fail(server, WEFT_ERR_FORMAT,
                                "the header tells of %llu bytes of samples from byte %llu on; the "
                                "file ends after %llu",
                                WIDE(bytes), WIDE(start), WIDE(size));
    dense->fd = fd;
    dense->start = start;
    return WEFT_OK;
}

enum weft_result weft_dense_allocate(struct weft_server *server, struct weft_dense *dense,
                                     uint64_t stored_bytes, uint64_t ratio)
{
    uint64_t bytes;
    const uint64_t least = UINT64_C(1) << 16, limit = server->limits.memory_bytes;
    enum weft_result res = weft_dense_count_bytes(server, dense, &bytes);
    if (res != WEFT_OK)
        return res;
    if (bytes > least && bytes / ratio > stored_bytes)
        return weft_server_fail(server, WEFT_ERR_FORMAT,
                                "the header tells of %llu bytes of samples, which the %llu bytes "
                                "that are stored cannot hold",
                                WIDE(bytes), WIDE(stored_bytes));
    dense->memory = bytes < limit ? calloc(1, bytes) : NULL;
    if (!dense->memory)
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "%llu bytes of samples; the memory limit is %llu bytes",
                                WIDE(bytes), WIDE(limit));
    return WEFT_OK;
}

// The kernel sees to it that no way leads out of the folder: neither an absolute name, nor "..",
// nor a link. Nobody is waited for who writes to a named pipe.
int weft_dense_open_beside(struct weft_server *server, const char *name)
{
    const char *slash = strrchr(server->path, '/');
    char *path = slash ? strndup(server->path, (size_t)(slash - server->path + 1)) : strdup(".");
    const int folder = path ? open(path, O_PATH | O_DIRECTORY | O_CLOEXEC) : -1;
    struct open_how how = {.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
                           .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
    struct stat st;
    int fd = folder >= 0 ? (int)syscall(SYS_openat2, folder, name, &how, sizeof how) : -1;
    if (fd < 0 && (errno == EXDEV || errno == ELOOP))
        weft_server_fail(server, WEFT_ERR_FORMAT,
                         "it names the file '%.200s', which leads out of its folder", name);
    else if (fd < 0 || fstat(fd, &st))
        weft_server_fail(server, WEFT_ERR_OPEN,
                         "it names the file '%.200s', which cannot be opened: %s", name,
                         strerror(errno));
    else if (!S_ISREG(st.st_mode))
        weft_server_fail(server, WEFT_ERR_FORMAT,
                         "it names the file '%.200s', which is not a plain file", name);
    if (server->answer.result && fd >= 0) {
        close(fd);
        fd = -1;
    }
    if (folder >= 0)
        close(folder);
    free(path);
    return fd;
}

// ---- grids --------------------------------------------------------------------------------------

static const struct weft_dense_axis *vector_axis(const struct weft_dense *dense)
{
    for (int i = 0; i < dense->other_count; i++)
        if (dense->other[i].components)
            return &dense->other[i];
    return NULL;
}

// Bytes from the first sample of all to the open grid's.
static int64_t grid_offset(const struct weft_dense *dense)
{
    uint64_t number = dense->grid;
    int64_t offset = 0;
    for (int i = 0; i < dense->other_count; i++) {
        const struct weft_dense_axis *axis = &dense->other[i];
        if (axis->components) {
            offset += dense->component * axis->stride;
            continue;
        }
        offset += (int64_t)(number % axis->size) * axis->stride;
        number /= axis->size;
    }
    return offset;
}

// "folder/brain.nii.gz" is "brain".
static void set_stem(struct weft_dense *dense, const char *path)
{
    static const char *const endings[] = {".gz", ".nrrd", ".nhdr", ".nii", ".hdr", ".img", ".raw"};
    const char *slash = strrchr(path, '/');
    snprintf(dense->stem, sizeof dense->stem, "%s", slash ? slash + 1 : path);
    for (size_t i = 0; i < WEFT_COUNT(endings); i++) {
        char *end = dense->stem + strlen(dense->stem);
        const size_t length = strlen(endings[i]);
        if ((size_t)(end - dense->stem) > length && !strcmp(end - length, endings[i]))
            end[-(ptrdiff_t)length] = 0;
    }
    weft_text_clean(dense->stem, false);
}

static void name_grid(const struct weft_dense *dense, uint64_t grid, char *out, size_t size)
{
    if (dense->grid_count == 1)
        snprintf(out, size, "%s", dense->stem);
    else
        snprintf(out, size, "%s[%llu]", dense->stem, WIDE(grid));
}

static enum weft_result count_grids(struct weft_server *server, struct weft_dense *dense)
{
    dense->grid_count = 1;
    for (int i = 0; i < dense->other_count; i++) {
        if (dense->other[i].components)
            continue;
        if (dense->other[i].size > WEFT_DENSE_GRIDS / dense->grid_count)
            return weft_server_fail(
                server, WEFT_ERR_LIMIT, "%llu times %llu grids of samples; the limit is %d",
                WIDE(dense->grid_count), WIDE(dense->other[i].size), WEFT_DENSE_GRIDS);
        dense->grid_count *= dense->other[i].size;
    }
    return WEFT_OK;
}

static enum weft_result check_transform(struct weft_server *server, const double m[3][4])
{
    double norm[3], det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                          m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    bool finite = isfinite(m[0][3]) && isfinite(m[1][3]) && isfinite(m[2][3]) && isfinite(det);
    for (int c = 0; c < 3; c++)
        norm[c] = hypot(hypot(m[0][c], m[1][c]), m[2][c]);
    if (finite && fabs(det) / norm[0] / norm[1] / norm[2] > 1e-12)
        return WEFT_OK;
    return weft_server_fail(server, WEFT_ERR_FORMAT,
                            "the transform is %s: (%g %g %g %g) (%g %g %g %g) (%g %g %g %g)",
                            finite ? "singular" : "not finite", m[0][0], m[0][1], m[0][2], m[0][3],
                            m[1][0], m[1][1], m[1][2], m[1][3], m[2][0], m[2][1], m[2][2], m[2][3]);
}

static struct weft_volume_info describe(const struct weft_dense *dense, uint64_t grid)
{
    struct weft_volume_info info;
    memset(&info, 0, sizeof info);
    name_grid(dense, grid, info.name, sizeof info.name);
    snprintf(info.type, sizeof info.type, "%s", weft_sample_type_names[dense->type]);
    strcpy(info.grid_class, "unknown");
    info.components = vector_axis(dense) ? 3 : 1;
    info.supported = info.counted = info.clamp_to_edge = true;
    info.rounded =
        dense->type == WEFT_SAMPLE_DOUBLE || dense->slope != 1.0 || dense->intercept != 0.0;
    info.background = NAN;
    info.active_voxels = 1;
    memcpy(info.index_to_world, dense->index_to_world, sizeof info.index_to_world);
    for (int i = 0; i < 3; i++) {
        info.active_max[i] = (int32_t)(dense->space[i].size - 1);
        info.active_voxels *= dense->space[i].size;
    }
    info.metadata_count = dense->metadata_count;
    return info;
}

static bool append_grid(struct weft_server *server, const struct weft_dense *dense,
                        const struct weft_volume_info *info)
{
    struct weft_wire_grid wire;
    memset(&wire, 0, sizeof wire);
    memcpy(&wire.info, info, sizeof *info);
    return weft_server_append(server, &wire, sizeof wire) &&
           weft_server_append(server, dense->metadata,
                              dense->metadata_count * sizeof *dense->metadata);
}

static enum weft_result list_grids(struct weft_server *server, const struct weft_dense *dense)
{
    for (uint64_t g = 0; g < dense->grid_count; g++) {
        const struct weft_volume_info info = describe(dense, g);
        if (!append_grid(server, dense, &info))
            return (enum weft_result)server->answer.result;
    }
    server->answer.count[0] = dense->grid_count;
    return WEFT_OK;
}

// ---- samples ------------------------------------------------------------------------------------

// Samples of a row, from voxel x on, in memory or read into room for them.
static const unsigned char *fetch_row(const struct weft_dense *dense, int32_t x, int32_t y,
                                      int32_t z, size_t count, unsigned char *room)
{
    const int64_t at = grid_offset(dense) + x * dense->space[0].stride +
                       y * dense->space[1].stride + z * dense->space[2].stride;
    if (dense->memory)
        return dense->memory + at;
    const size_t size =
        (count - 1) * (size_t)dense->space[0].stride + weft_sample_sizes[dense->type];
    for (size_t done = 0; done < size;) {
        const ssize_t n =
            pread(dense->fd, room + done, size - done, (off_t)dense->start + at + (off_t)done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return NULL;
        done += (size_t)n;
    }
    return room;
}

static enum weft_result fail_read(struct weft_server *server)
{
    return weft_server_fail(server, WEFT_ERR_OPEN, "the samples cannot be read: %s",
                            errno ? strerror(errno) : "the file has become shorter");
}

// Samples that are read at once of a row.
enum { PIECE = 1 << 14 };

static unsigned char *make_room(struct weft_server *server, const struct weft_dense *dense,
                                size_t count)
{
    const size_t size = count * (size_t)dense->space[0].stride + sizeof(double);
    unsigned char *room = dense->memory || size > server->limits.memory_bytes ? NULL : malloc(size);
    if (!room && !dense->memory)
        weft_server_fail(server, WEFT_ERR_LIMIT, "no memory for %zu bytes of a row of samples",
                         size);
    return room;
}

// Of small integers and of floats there is nothing to count.
static enum weft_result count_values(struct weft_server *server, const struct weft_dense *dense,
                                     struct weft_volume_info *info)
{
    const bool small = dense->type < WEFT_SAMPLE_UINT32 || dense->type == WEFT_SAMPLE_FLOAT;
    const size_t width = dense->space[0].size < PIECE ? (size_t)dense->space[0].size : PIECE;
    if (small && !info->rounded)
        return WEFT_OK;
    unsigned char *room = make_room(server, dense, width);
    for (int32_t z = 0; z <= info->active_max[2] && !server->answer.result; z++)
        for (int32_t y = 0; y <= info->active_max[1] && !server->answer.result; y++)
            for (int32_t x = 0; x <= info->active_max[0]; x += (int32_t)width) {
                const size_t left = (size_t)(info->active_max[0] - x) + 1;
                const size_t count = left < width ? left : width;
                errno = 0;
                const unsigned char *row = fetch_row(dense, x, y, z, count, room);
                if (!row) {
                    fail_read(server);
                    break;
                }
                weft_dense_count_values(dense, row, dense->space[0].stride, count, info);
            }
    free(room);
    return (enum weft_result)server->answer.result;
}

static bool names_grid(const struct weft_dense *dense, uint64_t grid, const char *name)
{
    char own[256];
    name_grid(dense, grid, own, sizeof own);
    return !strcmp(own, name) || (grid == 0 && !strcmp(dense->stem, name));
}

static enum weft_result open_grid(struct weft_server *server, struct weft_dense *dense,
                                  const char *name)
{
    uint64_t grid = 0;
    while (name && grid < dense->grid_count && !names_grid(dense, grid, name))
        grid++;
    if (grid == dense->grid_count)
        return weft_server_fail(
            server, WEFT_ERR_ARGUMENT, "no grid '%.64s'; the file has '%s%s' %s'%s%s%.0llu%s'",
            name, dense->stem, dense->grid_count > 1 ? "[0]" : "",
            dense->grid_count > 1 ? "to " : "", dense->grid_count > 1 ? dense->stem : "",
            dense->grid_count > 1 ? "[" : "", WIDE(dense->grid_count - 1),
            dense->grid_count > 1 ? "]" : "");
    struct weft_volume_info info = describe(dense, grid);
    info.component = (int)server->request->component;
    if (info.component < 0 || info.component >= info.components)
        return weft_server_fail(server, WEFT_ERR_ARGUMENT,
                                "grid '%.100s': no component %d: a grid of %s has %d", info.name,
                                info.component, info.type, info.components);
    dense->grid = grid;
    dense->component = info.component;
    dense->rest = server->request->rest;
    dense->open = true;
    info.bricks = 1;
    for (int i = 0; i < 3; i++)
        info.bricks *= (uint64_t)info.active_max[i] / WEFT_BRICK_SIZE + 1;
    info.memory_bytes = info.bricks * WEFT_BRICK_VOXELS * sizeof(float);
    if (count_values(server, dense, &info) != WEFT_OK)
        return (enum weft_result)server->answer.result;
    server->answer.count[0] = 1;
    return append_grid(server, dense, &info) ? WEFT_OK : (enum weft_result)server->answer.result;
}

// ---- bricks -------------------------------------------------------------------------------------

static int32_t clamped(int32_t at, const struct weft_dense_axis *axis)
{
    return at < (int32_t)axis->size ? at : (int32_t)axis->size - 1;
}

// One row of voxels of `run` bricks that lie side by side along x; the last voxel holds on beyond
// the box.
static bool read_row(const struct weft_dense *dense, const int32_t origin[3], int y, int z,
                     size_t run, unsigned char *room, float *row)
{
    const size_t left = (size_t)dense->space[0].size - (size_t)origin[0];
    const size_t want = run * WEFT_BRICK_SIZE, count = left < want ? left : want;
    const unsigned char *from =
        fetch_row(dense, origin[0], clamped(origin[1] + y, &dense->space[1]),
                  clamped(origin[2] + z, &dense->space[2]), count, room);
    if (!from)
        return false;
    weft_dense_convert(dense, from, dense->space[0].stride, count, row);
    for (size_t i = count; i < want; i++)
        row[i] = row[count - 1];
    return true;
}

static bool read_run(const struct weft_dense *dense, const int32_t origin[3], size_t run,
                     unsigned char *room, float *row, float *out)
{
    for (int line = 0; line < WEFT_BRICK_SIZE * WEFT_BRICK_SIZE; line++) {
        if (!read_row(dense, origin, line % WEFT_BRICK_SIZE, line / WEFT_BRICK_SIZE, run, room,
                      row))
            return false;
        for (size_t b = 0; b < run; b++)
            memcpy(out + b * WEFT_BRICK_VOXELS + line * WEFT_BRICK_SIZE, row + b * WEFT_BRICK_SIZE,
                   WEFT_BRICK_SIZE * sizeof *out);
    }
    return true;
}

static bool is_brick(const struct weft_dense *dense, const int32_t origin[3])
{
    for (int i = 0; i < 3; i++)
        if (origin[i] < 0 || origin[i] % WEFT_BRICK_SIZE ||
            (uint64_t)origin[i] >= dense->space[i].size)
            return false;
    return true;
}

// Bricks in a row that follow the first one, up to RUN.
enum { RUN = 128 };

static size_t run_length(const int32_t (*origin)[3], size_t count)
{
    size_t run = 1;
    while (run < count && run < RUN && origin[run][1] == origin[0][1] &&
           origin[run][2] == origin[0][2] &&
           origin[run][0] == origin[0][0] + (int32_t)run * WEFT_BRICK_SIZE)
        run++;
    return run;
}

static enum weft_result read_bricks(struct weft_server *server, const struct weft_dense *dense)
{
    const int32_t(*origin)[3] = server->request_payload;
    const size_t count = server->request->payload_bytes / sizeof *origin;
    unsigned char *room = make_room(server, dense, RUN * WEFT_BRICK_SIZE);
    float *row = malloc(RUN * WEFT_BRICK_SIZE * sizeof *row);
    float *out = server->answer.result || !count
                     ? NULL
                     : weft_server_map(server, count * WEFT_BRICK_VOXELS * sizeof *out);
    if (!row)
        weft_server_fail(server, WEFT_ERR_LIMIT, "no memory for a row of voxels");
    for (size_t done = 0; done < count && !server->answer.result;) {
        for (size_t i = done; i < count && i < done + RUN; i++)
            if (!is_brick(dense, origin[i]))
                weft_server_fail(server, WEFT_ERR_ARGUMENT, "no brick at (%d, %d, %d)",
                                 origin[i][0], origin[i][1], origin[i][2]);
        const size_t run = run_length(origin + done, count - done);
        errno = 0;
        if (!server->answer.result &&
            !read_run(dense, origin[done], run, room, row, out + done * WEFT_BRICK_VOXELS))
            fail_read(server);
        done += run;
    }
    server->answer.count[0] = count;
    free(room);
    free(row);
    return (enum weft_result)server->answer.result;
}

// ---- requests -----------------------------------------------------------------------------------

static enum weft_result prepare(struct weft_server *server, struct weft_dense *dense,
                                weft_dense_read_header read_header)
{
    if (dense->ready)
        return WEFT_OK;
    weft_dense_clear(dense);
    dense->slope = 1.0;
    enum weft_result res = read_header(server, dense);
    if (res == WEFT_OK)
        res = count_grids(server, dense);
    if (res == WEFT_OK)
        res = check_transform(server, dense->index_to_world);
    set_stem(dense, server->path);
    dense->ready = res == WEFT_OK;
    return res;
}

enum weft_result weft_dense_handle(struct weft_server *server, struct weft_dense *dense,
                                   weft_dense_read_header read_header)
{
    const struct weft_wire_request *request = server->request;
    const size_t skip = request->raw ? sizeof(struct weft_raw_layout) : 0;
    const char *name =
        request->payload_bytes > skip ? (const char *)server->request_payload + skip : NULL;
    if (request->payload_bytes < skip || (request->op == WEFT_WIRE_READ && !dense->open))
        return weft_server_fail(server, WEFT_ERR_READER, "a request that is not complete");
    if (request->op == WEFT_WIRE_READ)
        return read_bricks(server, dense);
    if (request->op != WEFT_WIRE_LIST && request->op != WEFT_WIRE_OPEN)
        return weft_server_fail(server, WEFT_ERR_READER, "an unknown request: %u", request->op);
    const enum weft_result res =
        prepare(server, dense, request->raw ? weft_dense_read_raw : read_header);
    if (res != WEFT_OK)
        return res;
    return request->op == WEFT_WIRE_LIST ? list_grids(server, dense)
                                         : open_grid(server, dense, name);
}

// ---- raw ----------------------------------------------------------------------------------------

enum weft_result weft_dense_read_raw(struct weft_server *server, struct weft_dense *dense)
{
    static const uint16_t one = 1;
    struct weft_raw_layout layout;
    memcpy(&layout, server->request_payload, sizeof layout);
    const bool little = *(const unsigned char *)&one == 1;
    struct weft_dense_axis *axis[3];
    if (layout.type >= WEFT_SAMPLE_TYPE_COUNT)
        return weft_server_fail(server, WEFT_ERR_READER, "samples of an unknown type");
    dense->type = layout.type;
    dense->swapped = layout.big_endian == little;
    for (int i = 0; i < 3; i++) {
        dense->space[i].size = (uint64_t)layout.size[i];
        dense->index_to_world[i][i] = layout.spacing[i];
        dense->index_to_world[i][3] = layout.origin[i];
        axis[i] = &dense->space[i];
    }
    weft_dense_pack(dense->type, axis, 3);
    return weft_dense_lie_in_file(server, dense, server->input_fd, layout.skip);
}
