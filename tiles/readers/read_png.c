// SPDX-License-Identifier: BSD-3-Clause
// weft-read-png: PNG images for libweft, see wire.h. Codes are handed over as they are stored, in
// 8 or 16 bits; nothing is done about gamma, profiles and alpha.
#include <errno.h>
#include <inttypes.h>
#include <malloc.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <png.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"

enum {
    SIDE_LIMIT = (1 << 29) - 1,
    RATIO_LIMIT = 10000,      // declared bytes per stored byte, as weft-read-exr has it
    CHUNK_LIMIT = 8 << 20,    // bytes of one chunk that is not pixels, unpacked
    CHUNKS_LIMIT = 1000,      // of those that are kept
    BUFFER_BYTES = 256 << 10, // of the file
    CHANNELS = 4,
};
#define RATIO_FLOOR_BYTES (UINT64_C(1) << 30)

struct reader {
    struct weft_server *server;
    png_structp png;
    png_infop info;
    uint64_t file_bytes, at; // how far the file was read
    unsigned char *buffer;
    size_t first, held; // bytes in it that libpng has not had yet
    char message[256];  // what libpng said at the end
    size_t refused;     // bytes of an allocation that failed, else 0
    png_bytep *rows;
    struct weft_attribute_list attributes;
    uint8_t cicp[4];
};

// ---- libpng's calls -----------------------------------------------------------------------------

static void fail(png_structp png, png_const_charp message)
{
    struct reader *r = png_get_error_ptr(png);
    snprintf(r->message, sizeof r->message, "%s", message);
    png_longjmp(png, 1);
}

static void be_silent(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static png_voidp allocate(png_structp png, png_alloc_size_t size)
{
    struct reader *r = png_get_mem_ptr(png);
    void *memory = malloc(size);
    if (!memory)
        r->refused = size;
    return memory;
}

static void release(png_structp png, png_voidp memory)
{
    (void)png;
    free(memory);
}

static void fill_buffer(struct reader *r)
{
    ssize_t n;
    do
        n = pread(r->server->input_fd, r->buffer, BUFFER_BYTES, (off_t)r->at);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        png_error(r->png, strerror(errno));
    if (n == 0)
        png_error(r->png, "it is cut short");
    r->at += (uint64_t)n;
    r->first = 0;
    r->held = (size_t)n;
}

static void read_bytes(png_structp png, png_bytep out, size_t size)
{
    struct reader *r = png_get_io_ptr(png);
    while (size) {
        if (!r->held)
            fill_buffer(r);
        const size_t n = size < r->held ? size : r->held;
        memcpy(out, r->buffer + r->first, n);
        r->first += n;
        r->held -= n;
        out += n;
        size -= n;
    }
}

// libpng 1.6.39 does not know cICP.
static int take_unknown(png_structp png, png_unknown_chunkp chunk)
{
    struct reader *r = png_get_user_chunk_ptr(png);
    if (!memcmp(chunk->name, "cICP", 4) && chunk->size == sizeof r->cicp)
        memcpy(r->cicp, chunk->data, sizeof r->cicp);
    return 1;
}

// ---- the header ---------------------------------------------------------------------------------

struct header {
    png_uint_32 width, height;
    int bits, colour, interlace;
    bool transparent; // a tRNS chunk
    size_t row_bytes, bytes;
    int channels;
};

static enum weft_result begin(struct reader *r)
{
    struct stat st;
    if (fstat(r->server->input_fd, &st))
        return weft_server_fail(r->server, WEFT_ERR_OPEN, "%s", strerror(errno));
    r->file_bytes = (uint64_t)st.st_size;
    r->png =
        png_create_read_struct_2(PNG_LIBPNG_VER_STRING, r, fail, be_silent, r, allocate, release);
    r->info = r->png ? png_create_info_struct(r->png) : NULL;
    if (!r->info)
        return weft_server_fail(r->server, WEFT_ERR_LIMIT,
                                "there is no room to begin within the memory limit of %" PRIu64
                                " bytes",
                                r->server->limits.memory_bytes);
    return WEFT_OK;
}

static void set_limits(struct reader *r)
{
    png_set_read_fn(r->png, r, read_bytes);
    png_set_user_limits(r->png, SIDE_LIMIT, SIDE_LIMIT);
    png_set_chunk_malloc_max(r->png, CHUNK_LIMIT);
    png_set_chunk_cache_max(r->png, CHUNKS_LIMIT);
    png_set_read_user_chunk_fn(r->png, r, take_unknown);
}

// What the codes are to become: channels of 8 or 16 bits.
static void set_transforms(struct reader *r, const struct header *h)
{
    if (h->colour == PNG_COLOR_TYPE_PALETTE)
        png_set_palette_to_rgb(r->png);
    else if (h->colour == PNG_COLOR_TYPE_GRAY && h->bits < 8)
        png_set_expand_gray_1_2_4_to_8(r->png);
    if (h->transparent)
        png_set_tRNS_to_alpha(r->png);
    if (h->bits == 16 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
        png_set_swap(r->png);
    png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
}

static void read_header(struct reader *r, struct header *h)
{
    set_limits(r);
    png_read_info(r->png, r->info);
    png_get_IHDR(r->png, r->info, &h->width, &h->height, &h->bits, &h->colour, &h->interlace, NULL,
                 NULL);
    h->transparent = png_get_valid(r->png, r->info, PNG_INFO_tRNS) != 0;
    set_transforms(r, h);
    h->channels = png_get_channels(r->png, r->info);
    h->row_bytes = png_get_rowbytes(r->png, r->info);
    const size_t value = h->bits == 16 ? 2 : 1;
    if (h->channels < 1 || h->channels > CHANNELS ||
        h->row_bytes != (size_t)h->width * (size_t)h->channels * value)
        png_error(r->png, "its channels are not what its header says");
}

static enum weft_result check_amount(struct reader *r, struct header *h)
{
    struct weft_server *s = r->server;
    if (!weft_size_mul(h->row_bytes, h->height, &h->bytes))
        h->bytes = SIZE_MAX;
    if (h->bytes > s->limits.output_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRIu32 " x %" PRIu32 " pixels of %d channels are %zu bytes, "
                                "the output limit is %" PRIu64,
                                h->width, h->height, h->channels, h->bytes, s->limits.output_bytes);
    if (h->bytes > RATIO_FLOOR_BYTES && h->bytes / RATIO_LIMIT > r->file_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%zu bytes are declared in a file of %" PRIu64
                                " bytes, the limit is %d times as many",
                                h->bytes, r->file_bytes, RATIO_LIMIT);
    return WEFT_OK;
}

// ---- the answer ---------------------------------------------------------------------------------

// What EXR has attributes for.
static void take_density(struct reader *r, struct weft_attribute_list *out)
{
    png_uint_32 across, down;
    int unit;
    if (!png_get_pHYs(r->png, r->info, &across, &down, &unit) || !across || !down)
        return;
    if (across != down)
        weft_attribute_add_float(out, "pixelAspectRatio", (float)((double)down / (double)across));
    if (unit == PNG_RESOLUTION_METER)
        weft_attribute_add_float(out, "xDensity", (float)(across * 0.0254));
}

static void take_texts(struct reader *r, struct weft_attribute_list *out)
{
    png_textp text = NULL;
    const int count = png_get_text(r->png, r->info, &text, NULL);
    for (int i = 0; i < count; i++)
        weft_attribute_add(out, weft_attribute_of_png(text[i].key), "string", text[i].text,
                           text[i].text ? strlen(text[i].text) : 0);
}

static void take_profile(struct reader *r, struct weft_attribute_list *out)
{
    png_charp name;
    png_bytep profile;
    png_uint_32 size = 0;
    int compression;
    if (png_get_iCCP(r->png, r->info, &name, &compression, &profile, &size) && size)
        weft_attribute_add(out, WEFT_ATTRIBUTE_ICC, "icc", profile, size);
}

static void make_info(const struct header *h, uint64_t header_bytes, char *out)
{
    static const char *const grey[] = {"Y", "A"}, *const colours[] = {"R", "G", "B", "A"};
    const struct weft_wire_image image = {
        .width = (int32_t)h->width,
        .height = (int32_t)h->height,
        .display_max = {(int32_t)h->width - 1, (int32_t)h->height - 1},
        .part_count = 1,
        .channel_count = (uint64_t)h->channels,
        .header_bytes = header_bytes};
    memcpy(out, &image, sizeof image);
    out += sizeof image;
    for (int c = 0; c < h->channels; c++) {
        struct weft_wire_channel channel = {
            .type = h->bits == 16 ? WEFT_PIXEL_UNORM16 : WEFT_PIXEL_UNORM8, .sampling = {1, 1}};
        snprintf(channel.name, sizeof channel.name, "%s", h->channels < 3 ? grey[c] : colours[c]);
        memcpy(out, &channel, sizeof channel);
        out += sizeof channel;
    }
}

static struct weft_wire_frame make_frame(const struct reader *r, const struct header *h)
{
    int intent;
    png_fixed_point gamma = 0;
    struct weft_wire_frame frame = {.bits = (uint32_t)h->bits};
    const bool flags[] = {h->colour == PNG_COLOR_TYPE_PALETTE,
                          h->transparent || (h->colour & PNG_COLOR_MASK_ALPHA) != 0,
                          h->interlace != PNG_INTERLACE_NONE,
                          png_get_sRGB(r->png, r->info, &intent) != 0,
                          png_get_valid(r->png, r->info, PNG_INFO_iCCP) != 0};
    for (unsigned i = 0; i < WEFT_COUNT(flags); i++)
        frame.flags |= (uint32_t)flags[i] << i;
    if (png_get_gAMA_fixed(r->png, r->info, &gamma))
        frame.gamma = gamma / 100000.0;
    memcpy(frame.cicp, r->cicp, sizeof frame.cicp);
    return frame;
}

// The codes' place; NULL where there is no room.
static char *begin_answer(struct reader *r, const struct header *h, size_t bytes)
{
    struct weft_attribute_list *list = &r->attributes;
    struct weft_wire_frame frame = make_frame(r, h);
    size_t offset = 0;
    take_density(r, list);
    take_texts(r, list);
    take_profile(r, list);
    if (!weft_attribute_end(list)) {
        weft_server_fail(r->server, WEFT_ERR_LIMIT,
                         "its texts do not fit in the memory limit of %" PRIu64 " bytes",
                         r->server->limits.memory_bytes);
        return NULL;
    }
    const size_t channels = (size_t)h->channels * sizeof(struct weft_wire_channel);
    frame.info_bytes = sizeof(struct weft_wire_image) + channels + list->size;
    weft_wire_align(sizeof frame + frame.info_bytes, &offset);
    frame.planes_offset = offset;
    char *payload = weft_server_map(r->server, offset + bytes);
    if (!payload)
        return NULL;
    memcpy(payload, &frame, sizeof frame);
    make_info(h, list->size, payload + sizeof frame);
    memcpy(payload + sizeof frame + frame.info_bytes - list->size, list->data, list->size);
    return payload + offset;
}

// Up to the file's end, so that a file that is cut is refused whatever it lacks.
static void read_codes(struct reader *r, const struct header *h, char *codes)
{
    r->rows = png_malloc(r->png, (png_alloc_size_t)h->height * sizeof *r->rows);
    for (png_uint_32 y = 0; y < h->height; y++)
        r->rows[y] = (png_bytep)codes + (size_t)y * h->row_bytes;
    png_read_image(r->png, r->rows);
    png_read_end(r->png, NULL);
}

static enum weft_result answer_frame(struct reader *r)
{
    struct header header = {0};
    const bool info_only = r->server->request->info_only;
    enum weft_result res = begin(r);
    if (res != WEFT_OK)
        return res;
    if (setjmp(png_jmpbuf(r->png))) {
        if (r->refused)
            return weft_server_fail(r->server, WEFT_ERR_LIMIT,
                                    "another %zu bytes do not fit in the memory limit of %" PRIu64
                                    " bytes",
                                    r->refused, r->server->limits.memory_bytes);
        return weft_server_fail(r->server, WEFT_ERR_FORMAT, "%s", r->message);
    }
    read_header(r, &header);
    if (!info_only) {
        res = check_amount(r, &header);
        if (res != WEFT_OK)
            return res;
    }
    char *codes = begin_answer(r, &header, info_only ? 0 : header.bytes);
    if (codes && !info_only)
        read_codes(r, &header, codes);
    return (enum weft_result)r->server->answer.result;
}

static enum weft_result handle(struct weft_server *server)
{
    struct reader *r = server->priv;
    unsigned char *buffer = r->buffer;
    if (server->request->op != WEFT_WIRE_IMAGE_FRAME)
        return weft_server_fail(server, WEFT_ERR_READER, "weft-read-png: unknown request %" PRIu32,
                                server->request->op);
    if (server->request->part)
        return weft_server_fail(server, WEFT_ERR_ARGUMENT,
                                "there is no part %" PRIu32 ": a PNG file has one, 0",
                                server->request->part);
    if (!buffer && !(buffer = malloc(BUFFER_BYTES)))
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "%d bytes do not fit in the memory limit of %" PRIu64 " bytes",
                                BUFFER_BYTES, server->limits.memory_bytes);
    *r = (struct reader){.server = server, .buffer = buffer};
    const enum weft_result res = answer_frame(r);
    free(r->rows);
    free(r->attributes.data);
    png_destroy_read_struct(&r->png, &r->info, NULL);
    return res;
}

int main(int argc, char **argv)
{
    struct reader reader = {0};
    mallopt(M_ARENA_MAX, 1); // address space is limited
    return weft_server_run(argc, argv, handle, &reader);
}
