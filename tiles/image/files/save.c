// SPDX-License-Identifier: BSD-3-Clause
// Images that are to be saved: what a file can hold of them.
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/codes/write.h"
#include "tiles/image/exr/chunk.h"
#include "tiles/image/exr/write.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_impl.h"

// What the C++ library accepts in a window.
enum { COORDINATE_LIMIT = INT_MAX / 2 };

// ---- checks ------------------------------------------------------------------------------------

static bool window_fits(const struct weft_image *image)
{
    int64_t x1 = (int64_t)image->x + image->width - 1, y1 = (int64_t)image->y + image->height - 1;
    return image->x > -COORDINATE_LIMIT && image->y > -COORDINATE_LIMIT && x1 < COORDINATE_LIMIT &&
           y1 < COORDINATE_LIMIT;
}

static bool display_fits(const struct weft_image *image)
{
    for (int a = 0; a < 2; a++)
        if (image->display_min[a] > image->display_max[a] ||
            image->display_min[a] <= -COORDINATE_LIMIT || image->display_max[a] >= COORDINATE_LIMIT)
            return false;
    return true;
}

static bool is_whole(const struct weft_image_channel *channel)
{
    return channel->sampling[0] <= 1 && channel->sampling[1] <= 1 &&
           (channel->type == WEFT_PIXEL_UINT ? channel->integers != NULL : channel->plane != NULL);
}

static bool is_name(const char *name, size_t size)
{
    return *name && memchr(name, '\0', size);
}

// Readers take these for granted.
static bool has_its_type(const struct weft_image_attribute *a)
{
    if (!strcmp(a->name, "pixelAspectRatio") || !strcmp(a->name, "screenWindowWidth"))
        return !strcmp(a->type, "float") && a->size == 4;
    return strcmp(a->name, "screenWindowCenter") || (!strcmp(a->type, "v2f") && a->size == 8);
}

static enum weft_result check_attributes(const struct weft_image *image, const struct weft_log *log)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, image->attribute_count == 0 || image->attributes != NULL);
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        weft_require(log, a->name && a->type && (a->data || a->size == 0));
        weft_require(log, is_name(a->name, WEFT_ATTRIBUTE_NAME_MAX + 1));
        weft_require(log, is_name(a->type, WEFT_ATTRIBUTE_NAME_MAX + 1));
        weft_require(log, a->size <= INT32_MAX);
        weft_require(log, has_its_type(a));
    }
    res = WEFT_OK;
fail:
    return res;
}

// That each mip level is as large as it has to be, and has what the image has.
static bool check_levels(const struct weft_image *image, const struct weft_log *log)
{
    const bool mips = image->tiled && image->levels == WEFT_IMAGE_LEVELS_MIP && image->mips;
    const int count = mips ? weft_image_level_count(image->width, image->height) : 1;
    for (int l = 1; l < count; l++) {
        const struct weft_image *level = &image->mips[l - 1];
        const int32_t width = weft_image_level_size(image->width, l);
        const int32_t height = weft_image_level_size(image->height, l);
        bool whole = level->width == width && level->height == height &&
                     level->channel_count == image->channel_count;
        for (size_t c = 0; whole && c < image->channel_count; c++)
            whole =
                level->channels[c].type == image->channels[c].type && is_whole(&level->channels[c]);
        if (whole)
            continue;
        weft_error(
            log, "mip level %d is %d x %d pixels of %zu channels, and is to be %d x %d of %zu", l,
            level->width, level->height, level->channel_count, width, height, image->channel_count);
        return false;
    }
    return true;
}

// What an EXR file can hold.
static enum weft_result check_exr(const struct weft_image *image, const struct weft_log *log)
{
    for (size_t c = 0; c < image->channel_count; c++) {
        const struct weft_image_channel *channel = &image->channels[c];
        if (channel->type <= WEFT_PIXEL_UINT)
            continue;
        weft_error(log, "channel %s is of type %s, which EXR files do not have", channel->name,
                   weft_pixel_type_names[channel->type]);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (!check_levels(image, log))
        return WEFT_ERR_ARGUMENT;
    if (weft_image_is_writable(image->compression))
        return WEFT_OK;
    weft_error(log, "compression %s is read, but not written",
               weft_image_compression_names[image->compression]);
    return WEFT_ERR_UNSUPPORTED;
}

// `planes`: whether channels need their values.
static enum weft_result check_image(const struct weft_image *image, bool planes,
                                    enum weft_image_file_kind kind, const struct weft_log *log)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, image->width > 0 && image->height > 0);
    weft_require(log, image->first_row == 0 && (!image->rows || image->rows == image->height));
    weft_require(log, window_fits(image));
    weft_require(log, display_fits(image));
    weft_require(log, image->channel_count > 0 && image->channel_count <= INT16_MAX);
    weft_require(log, image->channels != NULL);
    weft_require(log, memchr(image->name, '\0', sizeof image->name));
    weft_require(log, (unsigned)image->compression < WEFT_IMAGE_COMPRESSION_COUNT);
    weft_require(log, !image->tiled || (image->tile[0] >= 0 && image->tile[1] >= 0));
    for (size_t c = 0; c < image->channel_count; c++) {
        const struct weft_image_channel *channel = &image->channels[c];
        weft_require(log, (unsigned)channel->type < WEFT_PIXEL_TYPE_COUNT);
        weft_require(log, !planes || is_whole(channel));
        weft_require(log, is_name(channel->name, sizeof channel->name));
    }
    weft_require(log, (unsigned)image->transfer.curve < WEFT_CURVE_COUNT);
    res = check_attributes(image, log);
    if (res == WEFT_OK && kind == WEFT_IMAGE_FILE_EXR)
        res = check_exr(image, log);
fail:
    return res;
}

// ---- names that must differ ---------------------------------------------------------------------

static int compare_texts(const void *a, const void *b)
{
    const char *const *p = a, *const *q = b;
    return strcmp(*p, *q);
}

// Sorts.
static enum weft_result check_twins(const struct weft_log *log, const char *what,
                                    const char **names, size_t count)
{
    qsort(names, count, sizeof *names, compare_texts);
    for (size_t i = 1; i < count; i++) {
        if (strcmp(names[i - 1], names[i]))
            continue;
        weft_error(log, "two %s are named \"%s\"", what, names[i]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result check_names(const struct weft_image *parts, size_t count,
                                    const struct weft_log *log)
{
    size_t most = count;
    for (size_t p = 0; p < count; p++) {
        most = parts[p].channel_count > most ? parts[p].channel_count : most;
        most = parts[p].attribute_count > most ? parts[p].attribute_count : most;
    }
    const char **names = calloc(most, sizeof *names);
    if (!names) {
        weft_error(log, "out of memory for %zu names", most);
        return WEFT_ERR_MEMORY;
    }
    for (size_t p = 0; p < count; p++)
        names[p] = parts[p].name;
    enum weft_result res = check_twins(log, "parts", names, count);
    for (size_t p = 0; res == WEFT_OK && p < count; p++) {
        for (size_t c = 0; c < parts[p].channel_count; c++)
            names[c] = parts[p].channels[c].name;
        res = check_twins(log, "channels", names, parts[p].channel_count);
        for (size_t i = 0; res == WEFT_OK && i < parts[p].attribute_count; i++)
            names[i] = parts[p].attributes[i].name;
        if (res == WEFT_OK)
            res = check_twins(log, "attributes", names, parts[p].attribute_count);
    }
    free(names);
    return res;
}

// What the C++ library wants to be the same in all parts.
static enum weft_result check_shared(const struct weft_image *a, const struct weft_image *b,
                                     const struct weft_log *log)
{
    static const char *const shared[] = {"pixelAspectRatio", "timeCode", "chromaticities"};
    const char *what = NULL;
    if (memcmp(a->display_min, b->display_min, sizeof a->display_min) ||
        memcmp(a->display_max, b->display_max, sizeof a->display_max))
        what = "display window";
    for (size_t i = 0; !what && i < WEFT_COUNT(shared); i++) {
        const struct weft_image_attribute *x = weft_image_find(a, shared[i]);
        const struct weft_image_attribute *y = weft_image_find(b, shared[i]);
        if (x && y && (x->size != y->size || (x->size && memcmp(x->data, y->data, x->size))))
            what = shared[i];
    }
    if (!what)
        return WEFT_OK;
    weft_error(log, "parts \"%s\" and \"%s\" differ in their %s, which the format has for all",
               a->name, b->name, what);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_parts(const struct weft_image *parts, size_t count,
                                    const struct weft_image_save_params *params)
{
    const struct weft_log *log = params->log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, params->threads >= 0 && params->threads <= WEFT_IMAGE_MAX_THREADS);
    weft_require(log, parts != NULL);
    weft_require(log, count > 0 && count <= INT16_MAX);
    weft_require(log, count == 1 || !params->packed);
    weft_require(log, (unsigned)params->kind < WEFT_IMAGE_FILE_KIND_COUNT);
    weft_require(log, params->kind == WEFT_IMAGE_FILE_EXR || !params->packed);
    weft_require(log, !params->packed || !parts->tiled);
    weft_require(log, params->kind != WEFT_IMAGE_FILE_PNG || count == 1);
    res = WEFT_OK;
    for (size_t p = 0; res == WEFT_OK && p < count; p++)
        res = check_image(&parts[p], !params->packed || params->verify, params->kind, log);
    if (params->kind != WEFT_IMAGE_FILE_EXR)
        return res;
    for (size_t p = 1; res == WEFT_OK && p < count; p++)
        res = check_shared(&parts[0], &parts[p], log);
    return res == WEFT_OK ? check_names(parts, count, log) : res;
fail:
    return res;
}

// ---- saving -------------------------------------------------------------------------------------

enum weft_result weft_image_save_parts(const struct weft_image *parts, size_t count,
                                       const struct weft_image_save_params *params,
                                       struct weft_image_save_report *report)
{
    struct weft_output_file file = {.fd = -1, .stream = -1};
    struct weft_image_save_report own = {0};
    const int threads = params->threads ? params->threads : weft_threads_available();
    enum weft_result res = check_parts(parts, count, params);
    if (res == WEFT_OK)
        res = weft_output_file_create(params->log, params->path, params->no_clobber, &file);
    if (res == WEFT_OK)
        res = params->kind == WEFT_IMAGE_FILE_EXR
                  ? weft_image_write(parts, count, threads, params, &file, &own)
                  : weft_codes_write(parts, count, threads, params, &file, &own);
    if (res == WEFT_OK && params->verify)
        res = weft_image_verify(parts, count, file.fd, params, &own);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&file);
    weft_output_file_discard(&file);
    if (report)
        *report = own;
    return res;
}

enum weft_result weft_image_save(const struct weft_image *image,
                                 const struct weft_image_save_params *params)
{
    return weft_image_save_parts(image, 1, params, NULL);
}

int weft_image_block_lines(enum weft_image_compression compression)
{
    return weft_chunk_lines(compression);
}

enum weft_result weft_image_pack(const struct weft_image *image, int threads,
                                 const struct weft_log *log, struct weft_image_packed *out)
{
    const struct weft_image_save_params params = {.threads = threads, .log = log};
    *out = (struct weft_image_packed){.data = NULL};
    enum weft_result res = check_parts(image, 1, &params);
    if (res == WEFT_OK)
        res = weft_image_pack_lines(image, threads ? threads : weft_threads_available(), log, out);
    if (res != WEFT_OK)
        weft_image_packed_clear(out);
    return res;
}

void weft_image_packed_clear(struct weft_image_packed *packed)
{
    free(packed->data);
    *packed = (struct weft_image_packed){.data = NULL};
}
