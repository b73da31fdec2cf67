// SPDX-License-Identifier: BSD-3-Clause
// OpenEXRCore writes the file, and packs PIZ. Its own writing of chunks is not used: 3.1 stores one
// whose packed form is as long as the raw lines packed, and every reader takes it for raw; and its
// ZIP is several times slower than libdeflate's. Several threads pack, and each chunk that is ready
// is written once those before it are.
#include "tiles/image/exr/write.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "tiles/image/exr/chunk.h"
#include "tiles/image/exr/header.h"
#include "tiles/image/exr/lines.h"
#include "tiles/output/order.h"

enum {
    WORTH_A_THREAD = 64 << 10, // bytes
    SLOTS_PER_THREAD = 2,
    WINDOW = 512 << 20, // bytes of chunks that are under way, but for one of each thread
};

struct part {
    const struct weft_image *image;
    const struct weft_image_channel **sorted; // the format has channels by name
    const struct weft_image_channel **levels; // those of each level likewise, behind one another
    unsigned char *words;                     // of their values
    struct weft_chunk_shape shape;            // of the largest block: of whole lines, or a tile
    int level_count;
    size_t chunk_bytes, chunk_count;
};

// A block of lines, or a tile of a level.
struct block {
    const struct weft_image *image; // the level
    int level;
    size_t column, row; // of blocks
    size_t x, y, width, lines;
};

struct writer {
    struct part *parts;
    size_t count;
    int threads;
    struct weft_output_file *file;
    const struct weft_image_save_params *params;
    struct weft_image_save_report *report;
    exr_context_t exr;
    int stream_errno;  // of the writes that OpenEXRCore asked for
    char message[200]; // OpenEXRCore's first
    size_t chunks_done, chunks_all;
};

static enum weft_result fail_memory(const struct writer *w)
{
    weft_error(w->file->log, "cannot write %s: out of memory", w->file->path);
    return WEFT_ERR_MEMORY;
}

// ---- OpenEXRCore --------------------------------------------------------------------------------

// The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold the context's
// lock.
static _Thread_local struct writer *current;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message);
}

// In any thread: what went wrong is told later, in the caller's.
static int64_t write_bytes(exr_const_context_t exr, void *priv, const void *data, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct writer *w = priv;
    if (!w->stream_errno && !weft_output_file_put(w->file, offset, data, size))
        w->stream_errno = errno;
    if (!w->stream_errno)
        return (int64_t)size;
    error(exr, EXR_ERR_WRITE_IO, "write failed");
    return -1;
}

static enum weft_result result_of(struct writer *w, exr_result_t code)
{
    if (code == EXR_ERR_SUCCESS)
        return WEFT_OK;
    if (w->stream_errno) {
        errno = w->stream_errno;
        return weft_output_file_fail(w->file);
    }
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return fail_memory(w);
    weft_error(w->file->log, "cannot write %s: %s", w->file->path,
               w->message[0] ? w->message : exr_get_default_error_message(code));
    return WEFT_ERR_WRITE;
}

static exr_result_t start(struct writer *w)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.alloc_fn = malloc;
    init.free_fn = free;
    init.user_data = w;
    init.write_fn = write_bytes;
    exr_result_t rv = exr_start_write(&w->exr, w->file->path, EXR_WRITE_FILE_DIRECTLY, &init);
    for (size_t p = 0; !rv && p < w->count; p++)
        rv = weft_image_header_add(w->exr, w->parts[p].image, w->parts[p].sorted);
    return rv ? rv : exr_write_header(w->exr);
}

// ---- chunks -------------------------------------------------------------------------------------

// What one thread works with, and what its chunks lost.
struct lane {
    weft_chunk_packer *packer;
    size_t width; // that it is for
    struct weft_half_losses losses;
};

// A chunk, from when it is gathered until it is written.
struct slot {
    unsigned char *raw, *packed;
    struct weft_chunk chunk;
};

// One part on its way.
struct flow {
    struct writer *writer;
    size_t part;
    struct weft_order order;
    struct lane *lanes;
    struct slot *slots;
    uint64_t raw;                     // chunks that are stored as they are
    exr_result_t written;             // of writing them
    struct weft_image_packed *packed; // where they go if they are not written
    size_t packed_room;
    atomic_size_t different; // 1 more than the index of a chunk that does not unpack; 0: none
    bool cancelled;
};

static bool report_step(struct writer *w, size_t done)
{
    const struct weft_progress *progress = w->params->progress;
    return !progress || progress->report(progress->priv,
                                         (double)(w->chunks_done + done) / (double)w->chunks_all);
}

static bool ask(void *priv, size_t taken)
{
    struct flow *flow = priv;
    flow->cancelled = !report_step(flow->writer, taken);
    return !flow->cancelled;
}

static const struct weft_image *level_of(const struct part *part, int level)
{
    return level ? &part->image->mips[level - 1] : part->image;
}

static size_t blocks_across(const struct part *part, const struct weft_image *image)
{
    return ((size_t)image->width - 1) / part->shape.width + 1;
}

static size_t blocks_of(const struct part *part, const struct weft_image *image)
{
    const size_t lines = (size_t)part->shape.lines;
    return blocks_across(part, image) * (((size_t)image->height - 1) / lines + 1);
}

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Level after level, row after row.
static struct block block_of(const struct part *part, size_t i)
{
    struct block b = {.image = part->image};
    for (size_t count; i >= (count = blocks_of(part, b.image)); i -= count)
        b.image = level_of(part, ++b.level);
    const size_t across = blocks_across(part, b.image), lines = (size_t)part->shape.lines;
    b.column = i % across;
    b.row = i / across;
    b.x = b.column * part->shape.width;
    b.y = b.row * lines;
    b.width = smaller(part->shape.width, (size_t)b.image->width - b.x);
    b.lines = smaller(lines, (size_t)b.image->height - b.y);
    return b;
}

// Those at the right of levels are narrower.
static bool fit_packer(const struct part *part, struct lane *lane, size_t width)
{
    struct weft_chunk_shape shape = part->shape;
    if (lane->packer && lane->width == width)
        return true;
    weft_chunk_packer_destroy(&lane->packer);
    shape.width = lane->width = width;
    return weft_chunk_packer_create(part->image->compression, &shape, &lane->packer) == WEFT_OK;
}

static bool make_chunk(void *priv, int thread, size_t i, size_t s)
{
    struct flow *flow = priv;
    const struct part *part = &flow->writer->parts[flow->part];
    struct lane *lane = &flow->lanes[thread];
    struct slot *slot = &flow->slots[s];
    const struct block b = block_of(part, i);
    const struct weft_lines lines = {(size_t)b.image->width, b.x, b.y, b.width, b.lines};
    if (!fit_packer(part, lane, b.width))
        return false;
    weft_lines_gather(part->levels + (size_t)b.level * part->shape.channel_count,
                      part->shape.channel_count, &lines, slot->raw, &lane->losses);
    const enum weft_result res =
        weft_chunk_pack(lane->packer, slot->raw, (int)b.lines, slot->packed, &slot->chunk);
    if (res == WEFT_ERR_WRITE)
        atomic_store(&flow->different, i + 1);
    return res == WEFT_OK;
}

static exr_result_t write_chunk(struct writer *w, size_t p, size_t i, const void *data, size_t size)
{
    const struct part *part = &w->parts[p];
    const struct block b = block_of(part, i);
    if (part->image->tiled)
        return exr_write_tile_chunk(w->exr, (int)p, (int)b.column, (int)b.row, b.level, b.level,
                                    data, size);
    return exr_write_scanline_chunk(w->exr, (int)p, part->image->y + (int)b.y, data, size);
}

static bool take_chunk(void *priv, size_t i, size_t s)
{
    struct flow *flow = priv;
    struct writer *w = flow->writer, *outer = current;
    const struct weft_chunk *chunk = &flow->slots[s].chunk;
    current = w;
    flow->raw += !chunk->packed;
    flow->written = write_chunk(w, flow->part, i, chunk->data, chunk->size);
    current = outer;
    return flow->written == EXR_ERR_SUCCESS;
}

// Behind those before it.
static bool keep_chunk(void *priv, size_t i, size_t s)
{
    struct flow *flow = priv;
    const struct weft_chunk *chunk = &flow->slots[s].chunk;
    struct weft_image_packed *out = flow->packed;
    const uint32_t size = (uint32_t)chunk->size;
    const size_t needed = out->size + sizeof size + chunk->size;
    (void)i;
    if (needed > flow->packed_room) {
        const size_t room = needed + needed / 2;
        void *data = realloc(out->data, room);
        if (!data)
            return false;
        out->data = data;
        flow->packed_room = room;
    }
    memcpy((char *)out->data + out->size, &size, sizeof size);
    memcpy((char *)out->data + out->size + sizeof size, chunk->data, chunk->size);
    out->size = needed;
    flow->raw += !chunk->packed;
    return true;
}

static enum weft_result result_of_flow(const struct flow *flow, bool whole)
{
    struct writer *w = flow->writer;
    const struct part *part = &w->parts[flow->part];
    const size_t different = atomic_load(&flow->different);
    if (whole)
        return WEFT_OK;
    if (flow->cancelled)
        return WEFT_ERR_CANCELLED;
    if (flow->written != EXR_ERR_SUCCESS)
        return result_of(w, flow->written);
    if (!different)
        return fail_memory(w);
    const struct block b = block_of(part, different - 1);
    weft_error(w->file->log,
               "cannot write %s: lines %zu to %zu, packed, do not unpack to what they were",
               w->file->path, b.y, b.y + b.lines - 1);
    return WEFT_ERR_WRITE;
}

static bool make_room(struct flow *flow)
{
    const struct part *part = &flow->writer->parts[flow->part];
    const bool packs = part->image->compression != WEFT_IMAGE_NONE;
    flow->lanes = calloc((size_t)flow->order.threads, sizeof *flow->lanes);
    flow->slots = calloc(flow->order.slots, sizeof *flow->slots);
    bool whole = flow->lanes && flow->slots;
    for (int t = 0; whole && t < flow->order.threads; t++)
        whole = fit_packer(part, &flow->lanes[t], part->shape.width);
    for (size_t s = 0; whole && s < flow->order.slots; s++) {
        struct slot *slot = &flow->slots[s];
        slot->raw = malloc(part->chunk_bytes);
        slot->packed = packs ? malloc(part->chunk_bytes + WEFT_CHUNK_SLACK) : NULL;
        whole = slot->raw && (slot->packed || !packs);
    }
    return whole;
}

static void drop_room(struct flow *flow)
{
    for (int t = 0; flow->lanes && t < flow->order.threads; t++)
        weft_chunk_packer_destroy(&flow->lanes[t].packer);
    for (size_t s = 0; flow->slots && s < flow->order.slots; s++) {
        free(flow->slots[s].raw);
        free(flow->slots[s].packed);
    }
    free(flow->lanes);
    free(flow->slots);
}

static void add_losses(const struct flow *flow, struct weft_image_save_report *report)
{
    for (int t = 0; t < flow->order.threads; t++) {
        report->overflows += flow->lanes[t].losses.overflows;
        report->rounding = fmax(report->rounding, flow->lanes[t].losses.rounding);
    }
}

// So many that they are worth their start, and that what they hold stays small.
static int choose_threads(const struct writer *w, const struct part *part)
{
    const size_t bytes = part->chunk_bytes * part->chunk_count;
    const size_t chunk = part->chunk_bytes ? part->chunk_bytes : 1;
    size_t threads = (size_t)w->threads;
    threads = threads < part->chunk_count ? threads : part->chunk_count;
    threads = threads < 1 + bytes / WORTH_A_THREAD ? threads : 1 + bytes / WORTH_A_THREAD;
    // A thread holds two slots of two, and up to about six that PIZ is packed and unpacked with.
    threads = threads < 1 + WINDOW / chunk / 10 ? threads : 1 + WINDOW / chunk / 10;
    return (int)threads;
}

static void count_part(struct writer *w, const struct part *part, uint64_t raw)
{
    w->report->raw += raw;
    w->report->chunks += part->chunk_count;
    w->chunks_done += part->chunk_count;
    w->report->values +=
        (uint64_t)part->image->width * (uint64_t)part->image->height * part->image->channel_count;
}

// packed NULL: they are written.
static enum weft_result make_part(struct writer *w, size_t p, struct weft_image_packed *packed)
{
    const struct part *part = &w->parts[p];
    const int threads = choose_threads(w, part);
    struct flow flow = {
        .writer = w,
        .part = p,
        .order = {.threads = threads,
                  .count = part->chunk_count,
                  .slots = threads > 1 ? SLOTS_PER_THREAD * (size_t)threads : 1,
                  .make = make_chunk,
                  .take = packed ? keep_chunk : take_chunk,
                  .ask = ask},
        .packed = packed,
    };
    flow.order.priv = &flow;
    const bool room = make_room(&flow);
    const enum weft_result res =
        room ? result_of_flow(&flow, weft_order_run(&flow.order)) : fail_memory(w);
    if (room)
        add_losses(&flow, w->report);
    drop_room(&flow);
    count_part(w, part, flow.raw);
    return res;
}

// ---- chunks that come packed --------------------------------------------------------------------

static enum weft_result refuse_packed(const struct writer *w, int line)
{
    weft_error(w->file->log, "cannot write %s: what came packed at line %d is no block of lines",
               w->file->path, line);
    return WEFT_ERR_ARGUMENT;
}

// The next block of some, which begins at a line. Nothing is trusted but that its lines unpack.
static enum weft_result next_packed(const struct writer *w, int line, size_t raw_bytes,
                                    struct weft_bytes *left, struct weft_bytes *out)
{
    enum weft_result res = WEFT_OK;
    uint32_t size = 0;
    if (!left->size)
        res = w->params->packed(w->params->packed_priv, line, left);
    if (res != WEFT_OK)
        return res;
    if (left->size >= sizeof size)
        memcpy(&size, left->data, sizeof size);
    if (!size || size > raw_bytes || size > left->size - sizeof size)
        return refuse_packed(w, line);
    *out = (struct weft_bytes){(const char *)left->data + sizeof size, size};
    left->data = (const char *)out->data + size;
    left->size -= sizeof size + size;
    return WEFT_OK;
}

static enum weft_result write_packed(struct writer *w)
{
    const struct part *part = &w->parts[0];
    struct weft_bytes left = {NULL, 0};
    enum weft_result res = WEFT_OK;
    uint64_t raw = 0;
    for (size_t i = 0; res == WEFT_OK && i < part->chunk_count; i++) {
        const struct block b = block_of(part, i);
        const int line = (int)b.y;
        const size_t bytes = weft_chunk_line_bytes(&part->shape) * b.lines;
        struct weft_bytes chunk;
        res = report_step(w, i) ? next_packed(w, line, bytes, &left, &chunk) : WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = result_of(w, write_chunk(w, 0, i, chunk.data, chunk.size));
        raw += res == WEFT_OK && chunk.size == bytes;
    }
    if (res == WEFT_OK && left.size)
        res = refuse_packed(w, part->image->height);
    count_part(w, part, raw);
    return res;
}

// ---- parts --------------------------------------------------------------------------------------

static int compare_names(const void *a, const void *b)
{
    const struct weft_image_channel *const *p = a, *const *q = b;
    return strcmp((*p)->name, (*q)->name);
}

// The channels of each level in the order of the first one's.
static void sort_channels(const struct weft_image *image, struct part *out)
{
    const size_t count = image->channel_count;
    for (size_t c = 0; c < count; c++)
        out->sorted[c] = &image->channels[c];
    qsort(out->sorted, count, sizeof *out->sorted, compare_names);
    for (size_t c = 0; c < count; c++)
        out->words[c] = out->sorted[c]->type == WEFT_PIXEL_HALF ? 1 : 2;
    for (int l = 0; l < out->level_count; l++)
        for (size_t c = 0; c < count; c++)
            out->levels[(size_t)l * count + c] =
                &level_of(out, l)->channels[out->sorted[c] - image->channels];
}

static void set_shape(const struct weft_image *image, struct part *out)
{
    int32_t tile[2] = {image->width, weft_chunk_lines(image->compression)};
    if (image->tiled) {
        weft_image_tile_size(image, tile);
        tile[0] = tile[0] < image->width ? tile[0] : image->width;
        tile[1] = tile[1] < image->height ? tile[1] : image->height;
    }
    out->shape = (struct weft_chunk_shape){.width = (size_t)tile[0],
                                           .channel_count = image->channel_count,
                                           .words = out->words,
                                           .lines = tile[1]};
    // At most 2^15 channels of 2^31 pixels in a line.
    out->chunk_bytes = weft_chunk_line_bytes(&out->shape) * (size_t)tile[1];
    for (int l = 0; l < out->level_count; l++)
        out->chunk_count += blocks_of(out, level_of(out, l));
}

static enum weft_result set_part(struct writer *w, const struct weft_image *image, struct part *out)
{
    const size_t count = image->channel_count;
    *out = (struct part){.image = image, .level_count = weft_image_levels_of(image)};
    out->sorted = calloc(count, sizeof *out->sorted);
    out->levels = calloc(count * (size_t)out->level_count, sizeof *out->levels);
    out->words = malloc(count);
    if (!out->sorted || !out->levels || !out->words)
        return fail_memory(w);
    sort_channels(image, out);
    set_shape(image, out);
    w->chunks_all += out->chunk_count;
    if (out->chunk_bytes <= INT32_MAX)
        return WEFT_OK;
    weft_error(w->file->log, "cannot write %s: %d lines are %zu bytes, the limit is %d",
               w->file->path, out->shape.lines, out->chunk_bytes, INT32_MAX);
    return WEFT_ERR_LIMIT;
}

static enum weft_result write_file(struct writer *w)
{
    struct writer *outer = current; // of a progress callback that saves, too
    current = w;
    enum weft_result res = result_of(w, start(w));
    for (size_t p = 0; res == WEFT_OK && p < w->count; p++)
        res = w->params->packed ? write_packed(w) : make_part(w, p, NULL);
    if (w->exr) {
        const exr_result_t finished = exr_finish(&w->exr);
        res = res == WEFT_OK ? result_of(w, finished) : res;
    }
    current = outer;
    return res;
}

static enum weft_result set_parts(struct writer *w, const struct weft_image *parts)
{
    w->parts = calloc(w->count, sizeof *w->parts);
    enum weft_result res = w->parts ? WEFT_OK : fail_memory(w);
    for (size_t p = 0; res == WEFT_OK && p < w->count; p++)
        res = set_part(w, &parts[p], &w->parts[p]);
    return res;
}

static void free_parts(struct writer *w)
{
    for (size_t p = 0; w->parts && p < w->count; p++) {
        free(w->parts[p].sorted);
        free(w->parts[p].levels);
        free(w->parts[p].words);
    }
    free(w->parts);
}

enum weft_result weft_image_write(const struct weft_image *parts, size_t count, int threads,
                                  const struct weft_image_save_params *params,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report)
{
    struct writer w = {
        .count = count, .threads = threads, .file = file, .params = params, .report = report};
    enum weft_result res = set_parts(&w, parts);
    if (res == WEFT_OK)
        res = write_file(&w);
    if (res == WEFT_OK && !report_step(&w, 0))
        res = WEFT_ERR_CANCELLED;
    free_parts(&w);
    return res;
}

enum weft_result weft_image_pack_lines(const struct weft_image *image, int threads,
                                       const struct weft_log *log, struct weft_image_packed *out)
{
    static const struct weft_image_save_params none;
    char what[] = "lines that are packed";
    struct weft_output_file file = {.path = what, .log = log, .fd = -1, .stream = -1};
    struct writer w = {
        .count = 1, .threads = threads, .file = &file, .params = &none, .report = &out->report};
    enum weft_result res = set_parts(&w, image);
    if (res == WEFT_OK)
        res = make_part(&w, 0, out);
    free_parts(&w);
    return res;
}
