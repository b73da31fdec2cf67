// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/exr_unzip.h"

#include <stdlib.h>

#include <libdeflate.h>

// ZIP has a block's bytes of even index first, each as its difference to the one before, plus 128,
// over both halves. The first byte of the second half follows the last of the first, which is the
// sum of all before it: with it, both halves are summed up at once.
static void join(const unsigned char *restrict split, size_t size, unsigned char *restrict out)
{
    const size_t half = (size + 1) / 2, pairs = size / 2;
    const unsigned char *restrict second = split + half;
    unsigned sum = 0;
    for (size_t i = 0; i < half; i++)
        sum += split[i];
    unsigned even = 128, odd = sum - 128 * (unsigned)(half - 1);
    for (size_t i = 0; i < pairs; i++) {
        even += split[i] - 128u;
        odd += second[i] - 128u;
        out[2 * i] = (unsigned char)even;
        out[2 * i + 1] = (unsigned char)odd;
    }
    if (size & 1)
        out[size - 1] = (unsigned char)(even + split[half - 1] - 128u);
}

static bool make_room(struct weft_exr_unzip *unzip, size_t size)
{
    if (unzip->size >= size)
        return true;
    free(unzip->split);
    unzip->split = malloc(size);
    unzip->size = unzip->split ? size : 0;
    return unzip->split != NULL;
}

// Blocks that are as long as their lines are these lines themselves.
static exr_result_t decompress(exr_decode_pipeline_t *decode)
{
    struct weft_exr_unzip *unzip = decode->decoding_user_data;
    const size_t packed = decode->chunk.packed_size, size = decode->chunk.unpacked_size;
    size_t got = 0;
    if (packed == size || size == 0 || !decode->unpacked_buffer || !make_room(unzip, size) ||
        libdeflate_zlib_decompress(unzip->decompressor, decode->packed_buffer, packed, unzip->split,
                                   size, &got) != LIBDEFLATE_SUCCESS ||
        got != size)
        return unzip->default_fn(decode);
    join(unzip->split, size, decode->unpacked_buffer);
    return EXR_ERR_SUCCESS;
}

void weft_exr_unzip_install(struct weft_exr_unzip *unzip, exr_decode_pipeline_t *decode)
{
    if (!unzip->decompressor)
        unzip->decompressor = libdeflate_alloc_decompressor();
    if (!unzip->decompressor || !decode->decompress_fn)
        return;
    unzip->default_fn = decode->decompress_fn;
    decode->decoding_user_data = unzip;
    decode->decompress_fn = decompress;
}

void weft_exr_unzip_clear(struct weft_exr_unzip *unzip)
{
    libdeflate_free_decompressor(unzip->decompressor);
    free(unzip->split);
    *unzip = (struct weft_exr_unzip){0};
}
