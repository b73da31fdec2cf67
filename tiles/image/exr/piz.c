// SPDX-License-Identifier: BSD-3-Clause
// OpenEXRCore packs within a file that is written, and unpacks within one that is read. Here they
// are a header in memory, of one block: pipelines are handed its lines, and hand over bytes.
#include "tiles/image/exr/piz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

struct weft_piz {
    size_t line_bytes;
    exr_context_t writer, reader;
    unsigned char *header; // as writer made it and reader took it
    size_t header_size;
    exr_chunk_info_t block; // of all lines
    exr_encode_pipeline_t encode;
    exr_decode_pipeline_t decode;
    const void *given; // what a pipeline is to work on
    size_t given_size;
};

size_t weft_chunk_line_bytes(const struct weft_chunk_shape *shape)
{
    size_t words = 0;
    for (size_t c = 0; c < shape->channel_count; c++)
        words += shape->words[c];
    return 2 * words * shape->width;
}

static enum weft_result result_of(exr_result_t code)
{
    return code == EXR_ERR_SUCCESS         ? WEFT_OK
           : code == EXR_ERR_OUT_OF_MEMORY ? WEFT_ERR_MEMORY
                                           : WEFT_ERR_WRITE;
}

// ---- a header in memory -------------------------------------------------------------------------

static void ignore_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    (void)message;
}

static int64_t put_header(exr_const_context_t exr, void *priv, const void *data, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct weft_piz *piz = priv;
    const size_t end = (size_t)(offset + size);
    unsigned char *larger = end > piz->header_size ? realloc(piz->header, end) : piz->header;
    if (!larger) {
        error(exr, EXR_ERR_OUT_OF_MEMORY, "out of memory");
        return -1;
    }
    piz->header = larger;
    piz->header_size = end > piz->header_size ? end : piz->header_size;
    memcpy(piz->header + offset, data, size);
    return (int64_t)size;
}

static int64_t get_header(exr_const_context_t exr, void *priv, void *data, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    const struct weft_piz *piz = priv;
    const size_t left = offset < piz->header_size ? piz->header_size - (size_t)offset : 0;
    const size_t got = size < left ? (size_t)size : left;
    (void)exr;
    (void)error;
    if (got)
        memcpy(data, piz->header + offset, got);
    return (int64_t)got;
}

static exr_result_t write_header(struct weft_piz *piz, const struct weft_chunk_shape *shape)
{
    int part;
    exr_context_t exr = piz->writer;
    exr_result_t rv = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!rv)
        rv = exr_initialize_required_attr_simple(exr, part, (int32_t)shape->width, shape->lines,
                                                 EXR_COMPRESSION_PIZ);
    for (size_t c = 0; !rv && c < shape->channel_count; c++) {
        char name[24]; // the format has channels by name
        snprintf(name, sizeof name, "%05zu", c);
        rv = exr_add_channel(exr, part, name,
                             shape->words[c] == 1 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return rv ? rv : exr_write_header(exr);
}

static exr_result_t open_both(struct weft_piz *piz, const struct weft_chunk_shape *shape)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = ignore_message;
    init.alloc_fn = malloc;
    init.free_fn = free;
    init.user_data = piz;
    init.write_fn = put_header;
    init.read_fn = get_header;
    exr_result_t rv = exr_start_write(&piz->writer, "piz", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!rv)
        rv = write_header(piz, shape);
    return rv ? rv : exr_start_read(&piz->reader, "piz", &init);
}

// ---- pipelines ----------------------------------------------------------------------------------

static exr_result_t take_lines(exr_encode_pipeline_t *encode)
{
    const struct weft_piz *piz = encode->encoding_user_data;
    memcpy(encode->packed_buffer, piz->given, piz->given_size);
    encode->packed_bytes = piz->given_size;
    return EXR_ERR_SUCCESS;
}

static exr_result_t take_packed(exr_decode_pipeline_t *decode)
{
    const struct weft_piz *piz = decode->decoding_user_data;
    decode->packed_buffer = (void *)piz->given; // borrowed: its packed_alloc_size is 0
    return EXR_ERR_SUCCESS;
}

static exr_result_t start_pipelines(struct weft_piz *piz)
{
    exr_result_t rv = exr_write_scanline_chunk_info(piz->writer, 0, 0, &piz->block);
    if (!rv)
        rv = exr_encoding_initialize(piz->writer, 0, &piz->block, &piz->encode);
    if (!rv)
        rv = exr_encoding_choose_default_routines(piz->writer, 0, &piz->encode);
    piz->encode.encoding_user_data = piz;
    piz->encode.convert_and_pack_fn = take_lines;
    piz->encode.yield_until_ready_fn = NULL;
    piz->encode.write_fn = NULL;
    if (!rv)
        rv = exr_decoding_initialize(piz->reader, 0, &piz->block, &piz->decode);
    if (!rv)
        rv = exr_decoding_choose_default_routines(piz->reader, 0, &piz->decode);
    piz->decode.decoding_user_data = piz;
    piz->decode.read_fn = take_packed;
    piz->decode.unpack_and_convert_fn = NULL;
    return rv;
}

// Of the block's first lines.
static exr_chunk_info_t info_of(const struct weft_piz *piz, int lines, size_t packed)
{
    exr_chunk_info_t info = piz->block;
    info.height = lines;
    info.packed_size = packed;
    info.unpacked_size = piz->line_bytes * (size_t)lines;
    return info;
}

// ---- all ----------------------------------------------------------------------------------------

void weft_piz_destroy(weft_piz **piz)
{
    weft_piz *p = *piz;
    if (!p)
        return;
    if (p->encode.context)
        exr_encoding_destroy(p->writer, &p->encode);
    if (p->decode.context)
        exr_decoding_destroy(p->reader, &p->decode);
    if (p->reader)
        exr_finish(&p->reader);
    if (p->writer)
        exr_finish(&p->writer);
    free(p->header);
    free(p);
    *piz = NULL;
}

enum weft_result weft_piz_create(const struct weft_chunk_shape *shape, weft_piz **out)
{
    weft_piz *p = *out = calloc(1, sizeof *p);
    if (!p)
        return WEFT_ERR_MEMORY;
    p->line_bytes = weft_chunk_line_bytes(shape);
    exr_result_t rv = open_both(p, shape);
    if (!rv)
        rv = start_pipelines(p);
    if (rv)
        weft_piz_destroy(out);
    return result_of(rv);
}

enum weft_result weft_piz_pack(weft_piz *p, const void *raw, int lines, void *out, size_t *size)
{
    const exr_chunk_info_t info = info_of(p, lines, 0);
    exr_result_t rv = exr_encoding_update(p->writer, 0, &info, &p->encode);
    for (int c = 0; !rv && c < p->encode.channel_count; c++) {
        exr_coding_channel_info_t *channel = &p->encode.channels[c];
        channel->encode_from_ptr = raw; // take_lines knows where they are
        channel->user_bytes_per_element = channel->bytes_per_element;
        channel->user_data_type = channel->data_type;
    }
    p->given = raw;
    p->given_size = p->line_bytes * (size_t)lines;
    if (!rv)
        rv = exr_encoding_run(p->writer, 0, &p->encode);
    *size = rv ? 0 : p->encode.compressed_bytes;
    if (!rv && *size < p->given_size)
        memcpy(out, p->encode.compressed_buffer, *size);
    return result_of(rv);
}

enum weft_result weft_piz_check(weft_piz *p, const void *packed, size_t size, const void *raw,
                                int lines)
{
    const exr_chunk_info_t info = info_of(p, lines, size);
    exr_result_t rv = exr_decoding_update(p->reader, 0, &info, &p->decode);
    p->given = packed;
    p->given_size = size;
    if (!rv)
        rv = exr_decoding_run(p->reader, 0, &p->decode);
    p->decode.packed_buffer = NULL;
    if (!rv && memcmp(p->decode.unpacked_buffer, raw, p->line_bytes * (size_t)lines) != 0)
        return WEFT_ERR_WRITE;
    return result_of(rv);
}
