// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/exr_maker.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static int64_t write_at(exr_const_context_t exr, void *priv, const void *data, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t error)
{
    FILE *f = priv;
    (void)exr;
    (void)error;
    if (fseek(f, (long)offset, SEEK_SET) || fwrite(data, 1, size, f) != size)
        return -1;
    return (int64_t)size;
}

static exr_result_t set_header(exr_context_t exr, int part, const struct exr_recipe *r)
{
    exr_attr_box2i_t window = {0};
    exr_attr_v2f_t centre = {0};
    window.min.x = r->x;
    window.min.y = r->y;
    window.max.x = r->x + r->width - 1;
    window.max.y = r->y + r->height - 1;
    int sampling = r->sampling ? r->sampling : 1;
    exr_result_t rv = exr_initialize_required_attr(exr, part, &window, &window, 1.0f, &centre, 1.0f,
                                                   EXR_LINEORDER_RANDOM_Y, r->compression);
    if (!rv && (r->storage == EXR_STORAGE_TILED || r->storage == EXR_STORAGE_DEEP_TILED))
        rv = exr_set_tile_descriptor(exr, part, (uint32_t)r->tile_width, (uint32_t)r->tile_height,
                                     EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    if (!rv)
        rv = exr_add_channel(exr, part, "V", r->type, EXR_PERCEPTUALLY_LOGARITHMIC, sampling,
                             sampling);
    return rv;
}

static exr_result_t encode(exr_context_t exr, int part, const struct exr_recipe *r,
                           const exr_chunk_info_t *chunk, int x, int y)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t rv = exr_encoding_initialize(exr, part, chunk, &pipe);
    if (rv)
        return rv;
    int bytes = r->type == EXR_PIXEL_HALF ? 2 : 4;
    exr_coding_channel_info_t *channel = &pipe.channels[0];
    channel->encode_from_ptr =
        (const uint8_t *)r->pixels + ((size_t)y * (size_t)r->width + (size_t)x) * (size_t)bytes;
    channel->user_pixel_stride = bytes;
    channel->user_line_stride = bytes * r->width;
    channel->user_bytes_per_element = (int16_t)bytes;
    channel->user_data_type = (uint16_t)r->type;
    rv = exr_encoding_choose_default_routines(exr, part, &pipe);
    if (!rv)
        rv = exr_encoding_run(exr, part, &pipe);
    exr_encoding_destroy(exr, &pipe);
    return rv;
}

static exr_result_t write_lines(exr_context_t exr, int part, const struct exr_recipe *r)
{
    int32_t lines = 1;
    exr_result_t rv = exr_get_scanlines_per_chunk(exr, part, &lines);
    int count = (r->height + lines - 1) / lines;
    for (int i = 0; !rv && i < count; i++) {
        int y = lines * (r->order == EXR_LINEORDER_DECREASING_Y ? count - 1 - i : i);
        exr_chunk_info_t chunk;
        rv = exr_write_scanline_chunk_info(exr, part, r->y + y, &chunk);
        if (!rv)
            rv = encode(exr, part, r, &chunk, 0, y);
    }
    return rv;
}

static exr_result_t write_tiles(exr_context_t exr, int part, const struct exr_recipe *r)
{
    int columns = (r->width + r->tile_width - 1) / r->tile_width;
    int rows = (r->height + r->tile_height - 1) / r->tile_height;
    exr_result_t rv = EXR_ERR_SUCCESS;
    for (int i = 0; !rv && i < columns * rows; i++) {
        // Any order will do for random; 7 is prime to the counts in use.
        int tile = r->order == EXR_LINEORDER_RANDOM_Y ? i * 7 % (columns * rows) : i;
        int tx = tile % columns, ty = tile / columns;
        if (r->order == EXR_LINEORDER_DECREASING_Y)
            ty = rows - 1 - ty;
        exr_chunk_info_t chunk;
        rv = exr_write_tile_chunk_info(exr, part, tx, ty, 0, 0, &chunk);
        if (!rv)
            rv = encode(exr, part, r, &chunk, tx * r->tile_width, ty * r->tile_height);
    }
    return rv;
}

static exr_result_t write_file(exr_context_t exr, const struct exr_recipe *r)
{
    static const char *const name[] = {"first", "second"};
    int parts = r->parts ? r->parts : 1;
    exr_result_t rv = EXR_ERR_SUCCESS;
    for (int part = 0; !rv && part < parts; part++) {
        int index;
        rv = exr_add_part(exr, parts > 1 ? name[part] : NULL, r->storage, &index);
        if (!rv)
            rv = set_header(exr, part, r);
    }
    if (!rv)
        rv = exr_write_header(exr);
    bool flat = r->storage == EXR_STORAGE_SCANLINE || r->storage == EXR_STORAGE_TILED;
    for (int part = 0; !rv && flat && r->sampling <= 1 && part < parts; part++) {
        struct exr_recipe other = *r;
        if (part)
            other.pixels = (const uint8_t *)r->pixels + 4;
        rv = r->storage == EXR_STORAGE_TILED ? write_tiles(exr, part, &other)
                                             : write_lines(exr, part, &other);
    }
    return rv;
}

// OpenEXRCore 3.1 writes lines and tiles out of order only if the header says random.
static bool patch_order(FILE *f, exr_lineorder_t order)
{
    static const char marker[] = "lineOrder\0lineOrder\0\1\0\0";
    char head[4096];
    rewind(f);
    size_t size = fread(head, 1, sizeof head, f);
    const char *found = memmem(head, size, marker, sizeof marker);
    return found && !fseek(f, found - head + (long)sizeof marker, SEEK_SET) &&
           fputc((int)order, f) != EOF;
}

exr_result_t exr_make(const struct exr_recipe *r)
{
    FILE *f = fopen(r->path, "w+b");
    if (!f)
        return EXR_ERR_FILE_ACCESS;
    exr_context_t exr = NULL;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.user_data = f;
    init.write_fn = write_at;
    exr_result_t rv = exr_start_write(&exr, r->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (!rv)
        rv = write_file(exr, r);
    exr_finish(&exr);
    if (!rv && r->parts <= 1 && !patch_order(f, r->order))
        rv = EXR_ERR_WRITE_IO;
    if (fclose(f))
        rv = EXR_ERR_WRITE_IO;
    return rv;
}
