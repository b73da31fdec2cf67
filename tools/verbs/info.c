// SPDX-License-Identifier: BSD-3-Clause
// weft info: the grids of a VDB, NRRD, NIfTI or raw file, the channels of an EXR file, the codes of
// a PNG file.
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/json.h"
#include "tools/common/report.h"
#include "tools/volumes/raw.h"
#include "tools/verbs/verb.h"

enum { LINE = 1024 }; // of a message

enum info_option { INFO_RAW, INFO_JSON, INFO_QUIET, INFO_VERBOSE, INFO_OPTION_COUNT };

static const struct option_spec options[INFO_OPTION_COUNT] = {
    [INFO_RAW] = RAW_OPTION,
    [INFO_JSON] = OPTIONS_JSON("the same"),
    [INFO_QUIET] = OPTIONS_QUIET,
    [INFO_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- volumes ------------------------------------------------------------------------------------

// Lengths of the transform's columns: the distance between neighbouring voxels along each index
// axis.
static void voxel_spacing(const struct weft_volume_info *info, double out[3])
{
    for (int c = 0; c < 3; c++) {
        const double(*m)[4] = info->index_to_world;
        out[c] = sqrt(m[0][c] * m[0][c] + m[1][c] * m[1][c] + m[2][c] * m[2][c]);
    }
}

// Not a kind of grid that weft does not slice, but one that cannot be read.
static bool is_damaged(const struct weft_volume_info *info)
{
    return info->result != WEFT_OK && info->result != WEFT_ERR_UNSUPPORTED;
}

// Not even its header can be read.
static bool is_unknown(const struct weft_volume_info *info)
{
    return is_damaged(info) && isnan(info->index_to_world[0][0]) && !info->metadata_count;
}

static void active_size(const struct weft_volume_info *info, int32_t out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = info->empty ? 0 : info->active_max[c] - info->active_min[c] + 1;
}

// null: not told by the file, or not affine.
static json_t *if_counted(const struct weft_volume_info *info, json_t *value)
{
    if (info->counted)
        return value;
    json_decref(value);
    return json_null();
}

// Whether the world's axes run along the grid's, in any order and direction.
static bool is_aligned(const struct weft_volume_info *info)
{
    int along = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            along += info->index_to_world[r][c] != 0.0;
    return along == 3;
}

// The cells of the active voxels in world space; false where they are not known.
static bool find_world_box(const struct weft_volume_info *info, double low[3], double high[3],
                           double size[3])
{
    bool finite = info->counted && !info->empty;
    weft_slice_active_box(info, WEFT_SPACE_WORLD, low, high);
    for (int a = 0; a < 3; a++) {
        size[a] = high[a] - low[a];
        finite = finite && isfinite(low[a]) && isfinite(size[a]);
    }
    return finite;
}

static void set_world_box(json_t *root, const struct weft_volume_info *info)
{
    double low[3], high[3], size[3];
    json_t *box = json_null();
    if (find_world_box(info, low, high, size))
        box = json_pack("{s:o,s:o,s:o,s:b}", "min", json_numbers(low, 3), "max",
                        json_numbers(high, 3), "size", json_numbers(size, 3), "encloses",
                        !is_aligned(info));
    json_object_set_new(root, "world_box", box);
}

static json_t *grid_json(const struct weft_volume_info *info)
{
    double spacing[3];
    int32_t size[3];
    voxel_spacing(info, spacing);
    active_size(info, size);
    json_t *transform = json_array();
    for (int r = 0; r < 3; r++)
        json_array_append_new(transform, json_numbers(info->index_to_world[r], 4));
    json_t *root = json_pack(
        "{s:o,s:o,s:i,s:o,s:b,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}",
        "name", json_text(info->name), "type", json_text(info->type), "components",
        info->components, "class", json_text(info->grid_class), "supported", info->supported,
        "problem", *info->problem ? json_text(info->problem) : json_null(), "empty",
        if_counted(info, json_boolean(info->empty)), "active_min",
        if_counted(info, json_counts(info->active_min, 3)), "active_max",
        if_counted(info, json_counts(info->active_max, 3)), "size",
        if_counted(info, json_counts(size, 3)), "active_voxels",
        if_counted(info, json_count(info->active_voxels)), "bricks", json_count(info->bricks),
        "memory_bytes", json_count(info->memory_bytes), "voxel_size", json_numbers(spacing, 3),
        "index_to_world", transform, "background", json_number(info->background), "values_rounded",
        json_count(info->values_rounded), "largest_rounding", json_number(info->largest_rounding),
        "values_infinite", json_count(info->values_infinite), "values_tiny",
        json_count(info->values_tiny), "metadata",
        json_metadata(info->metadata, info->metadata_count));
    set_world_box(root, info);
    return root;
}

static void print_metadata(const struct weft_metadata *metadata, size_t count)
{
    for (size_t i = 0; i < count; i++)
        report_line("  %s%s = %s", i ? "               " : "metadata       ", metadata[i].key,
                    metadata[i].value);
}

static void print_active(const struct weft_volume_info *info)
{
    int32_t size[3];
    active_size(info, size);
    if (!info->counted)
        puts("  active voxels  unknown");
    else if (info->empty)
        puts("  active voxels  none");
    else
        printf("  active voxels  %llu\n"
               "  active box     (%d, %d, %d) to (%d, %d, %d): %d x %d x %d\n",
               (unsigned long long)info->active_voxels, info->active_min[0], info->active_min[1],
               info->active_min[2], info->active_max[0], info->active_max[1], info->active_max[2],
               size[0], size[1], size[2]);
}

static void print_transform(const struct weft_volume_info *info)
{
    double spacing[3];
    voxel_spacing(info, spacing);
    if (isnan(info->index_to_world[0][0]))
        return;
    printf("  voxel size     %.9g x %.9g x %.9g\n", spacing[0], spacing[1], spacing[2]);
    for (int r = 0; r < 3; r++)
        printf("  %s%c = %.9g i + %.9g j + %.9g k + %.9g\n",
               r ? "               " : "world          ", "xyz"[r], info -> index_to_world[r][0],
               info -> index_to_world[r][1], info -> index_to_world[r][2],
               info -> index_to_world[r][3]);
}

// That of cells, where that of voxels' centres is the active box.
static void print_world_box(const struct weft_volume_info *info)
{
    double low[3], high[3], size[3];
    if (!find_world_box(info, low, high, size))
        return;
    printf("  world box      (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g): %.6g x %.6g x %.6g%s\n",
           low[0], low[1], low[2], high[0], high[1], high[2], size[0], size[1], size[2],
           is_aligned(info) ? "" : ", around the grid, whose axes are not the world's");
}

static void print_grid(const struct weft_volume_info *info)
{
    report_line("grid '%s': %s%s, %s", info->name, info->type,
                info->components == 3 ? ", 3 components" : "", info->grid_class);
    if (!info->supported)
        report_line("  %s %s", is_damaged(info) ? "not readable  " : "not for slices",
                    info->problem);
    print_active(info);
    if (info->supported)
        printf("  bricks         %llu of 8 x 8 x 8, %llu bytes in memory\n",
               (unsigned long long)info->bricks, (unsigned long long)info->memory_bytes);
    if (info->supported && info->clamp_to_edge)
        puts("  outside        the nearest voxel");
    else if (info->supported)
        printf("  background     %.9g\n", info->background);
    if (info->values_rounded)
        printf("  not in floats  %llu integers, off by up to %g\n",
               (unsigned long long)info->values_rounded, info->largest_rounding);
    if (info->values_infinite + info->values_tiny)
        printf("  not in floats  %llu values too large, %llu too small\n",
               (unsigned long long)info->values_infinite, (unsigned long long)info->values_tiny);
    print_world_box(info);
    print_transform(info);
    print_metadata(info->metadata, info->metadata_count);
}

// A file without grids is a VDB file.
static enum weft_volume_format list_format(const struct weft_volume_list *list)
{
    return list->count ? list->grids[0].format : WEFT_VOLUME_VDB;
}

static const char *format_title(const struct weft_volume_list *list)
{
    static const char *const titles[WEFT_VOLUME_FORMAT_COUNT] = {"", "OpenVDB", "NRRD", "NIfTI",
                                                                 "samples without a header"};
    return titles[list_format(list)];
}

static enum weft_result print_grids(const char *path, const struct weft_volume_list *list,
                                    bool json)
{
    json_t *grids = json ? json_array() : NULL;
    if (!json)
        report_line("%s: %s, %zu grid%s", path, format_title(list), list->count,
                    list->count == 1 ? "" : "s");
    for (size_t i = 0; i < list->count; i++)
        if (json)
            json_array_append_new(grids, grid_json(&list->grids[i]));
        else
            print_grid(&list->grids[i]);
    if (!json)
        return WEFT_OK;
    return json_print(json_pack("{s:s,s:o}", "format", weft_volume_format_names[list_format(list)],
                                "grids", grids));
}

static void keep_error(void *priv, enum weft_log_level level, const char *message)
{
    if (level != WEFT_LOG_ERROR)
        report_log()->write(report_log()->priv, level, message);
    else if (!*(char *)priv)
        snprintf(priv, LINE, "%s", message);
}

// The list tells what the file's headers claim; bricks and background come with the grid's tree. A
// reader of its own for each, so that what one grid does to its reader is not the others' end.
static void look_into(const char *path, const struct weft_raw_layout *raw,
                      struct weft_volume_info *info)
{
    char line[LINE] = "", start[LINE];
    const struct weft_log log = {keep_error, line};
    const struct weft_volume_open_params params = {
        .path = path, .grid = info->name, .raw = raw, .log = &log};
    weft_volume *volume = NULL;
    const enum weft_result res = weft_volume_open(&params, &volume);
    if (res == WEFT_OK) {
        struct weft_volume_info whole = *weft_volume_get_info(volume);
        whole.metadata = info->metadata;
        whole.metadata_count = info->metadata_count;
        *info = whole;
    } else {
        snprintf(start, sizeof start, "%.400s: grid '%s': ", path, info->name);
        const size_t length = strlen(weft_text_clean(start, false));
        const char *reason = strncmp(line, start, length) ? line : line + length;
        snprintf(info->problem, sizeof info->problem, "%s",
                 *reason ? reason : weft_result_text(res));
        info->result = res;
        info->supported = false;
    }
    weft_volume_destroy(&volume);
}

// An error where no grid can be read, warnings where some can.
static enum weft_result report_damage(const char *path, const struct weft_volume_list *list,
                                      size_t damaged)
{
    for (size_t i = 0; damaged && i < list->count; i++) {
        const struct weft_volume_info *info = &list->grids[i];
        if (!is_damaged(info))
            continue;
        if (damaged == list->count) {
            report_error("%s: %s '%s' cannot be read: %s", path,
                         damaged == 1 ? "grid" : "no grid can be read;", info->name, info->problem);
            return info->result;
        }
        report_warning("%s: grid '%s' cannot be read: %s", path, info->name, info->problem);
    }
    return WEFT_OK;
}

static enum weft_result inform_volume(const char *path, const struct weft_raw_layout *raw,
                                      bool json)
{
    struct weft_volume_list list = {0};
    struct weft_volume_open_params params = {.path = path, .raw = raw, .log = report_log()};
    enum weft_result res = weft_volume_list_load(&params, &list);
    if (res != WEFT_OK)
        return res;
    for (size_t i = 0; i < list.count; i++)
        if (list.grids[i].supported)
            look_into(path, raw, &list.grids[i]);
    size_t damaged = 0, unknown = 0;
    for (size_t i = 0; i < list.count; i++) {
        damaged += is_damaged(&list.grids[i]);
        unknown += is_unknown(&list.grids[i]);
    }
    if (list.count == 0 || unknown < list.count)
        res = print_grids(path, &list, json);
    if (res == WEFT_OK)
        res = report_damage(path, &list, damaged);
    weft_volume_list_clear(&list);
    return res;
}

// ---- EXR and TIFF -------------------------------------------------------------------------------

static const char *storage_name(const struct weft_image *image)
{
    return image->deep ? (image->tiled ? "deep tiled" : "deep scanline")
           : image->levels == WEFT_IMAGE_LEVELS_MIP ? "tiled with mip levels"
           : image->levels == WEFT_IMAGE_LEVELS_RIP ? "tiled with rip levels"
           : image->tiled                           ? "tiled"
                                                    : "scanline";
}

static json_t *channel_json(const struct weft_image_channel *channel)
{
    json_t *one = json_pack("{s:o,s:s}", "name", json_text(channel->name), "type",
                            weft_pixel_type_names[channel->type]);
    if (channel->sampling[0] != 1 || channel->sampling[1] != 1)
        json_object_set_new(one, "sampling", json_counts(channel->sampling, 2));
    return one;
}

static json_t *image_json(const struct weft_image *image)
{
    json_t *channels = json_array();
    for (size_t i = 0; i < image->channel_count; i++)
        json_array_append_new(channels, channel_json(&image->channels[i]));
    return json_pack("{s:o,s:i,s:i,s:i,s:i,s:o,s:o,s:s,s:b,s:b,s:o,s:o}", "name",
                     json_text(image->name), "x", image->x, "y", image->y, "width", image->width,
                     "height", image->height, "display_min", json_counts(image->display_min, 2),
                     "display_max", json_counts(image->display_max, 2), "compression",
                     weft_image_compression_names[image->compression], "tiled", image->tiled,
                     "deep", image->deep, "channels", channels, "metadata", json_attributes(image));
}

// Of one part directly, as of the first of several, which are all in a list.
static json_t *images_json(const struct weft_image_list *list)
{
    const bool tiff = list->images[0].kind == WEFT_IMAGE_FILE_TIFF;
    json_t *root = json_pack("{s:s}", "format", tiff ? "tiff" : "exr");
    json_object_update_new(root, image_json(&list->images[0]));
    json_t *parts = list->count > 1 ? json_array() : NULL;
    for (size_t p = 0; parts && p < list->count; p++)
        json_array_append_new(parts, image_json(&list->images[p]));
    if (parts)
        json_object_set_new(root, "parts", parts);
    return root;
}

// Long values are cut; --json has them whole.
static void print_attributes(const struct weft_image *image)
{
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        char text[200], rest[40] = "";
        if (weft_image_attribute_format(a, text, sizeof text) >= sizeof text)
            snprintf(rest, sizeof rest, "... (%zu bytes)", a->size);
        report_line("  %s%s = %s%s", i ? "               " : "attributes     ", a->name, text,
                    rest);
    }
}

static void print_channel(const struct weft_image_channel *channel, bool first)
{
    char sampling[60] = "";
    if (channel->sampling[0] != 1 || channel->sampling[1] != 1)
        snprintf(sampling, sizeof sampling, ", subsampled %d x %d", channel->sampling[0],
                 channel->sampling[1]);
    report_line("  %s%s (%s%s)", first ? "channels       " : "               ", channel->name,
                weft_pixel_type_names[channel->type], sampling);
}

static void print_image(const char *title, const struct weft_image *image)
{
    report_line("%s%d x %d pixels, %zu channel%s, %s, %s compression", title, image->width,
                image->height, image->channel_count, image->channel_count == 1 ? "" : "s",
                storage_name(image), weft_image_compression_names[image->compression]);
    for (size_t i = 0; i < image->channel_count; i++)
        print_channel(&image->channels[i], i == 0);
    printf("  data window    (%d, %d) to (%lld, %lld)\n", image->x, image->y,
           (long long)image->x + image->width - 1, (long long)image->y + image->height - 1);
    printf("  display window (%d, %d) to (%d, %d)\n", image->display_min[0], image->display_min[1],
           image->display_max[0], image->display_max[1]);
    print_attributes(image);
}

static void print_images(const char *path, const struct weft_image_list *list)
{
    char title[4200];
    snprintf(title, sizeof title, "%s: OpenEXR, ", path);
    if (list->count == 1) {
        print_image(title, &list->images[0]);
        return;
    }
    report_line("%s%zu parts", title, list->count);
    for (size_t p = 0; p < list->count; p++) {
        snprintf(title, sizeof title, "part %zu '%s': ", p, list->images[p].name);
        print_image(title, &list->images[p]);
    }
}

static enum weft_result inform_image(const char *path, bool json)
{
    struct weft_image_list list = {0};
    const struct weft_image_load_params params = {.path = path, .log = report_log()};
    enum weft_result res = weft_image_list_load(&params, &list);
    if (res != WEFT_OK)
        return res;
    if (json)
        res = json_print(images_json(&list));
    else
        print_images(path, &list);
    weft_image_list_clear(&list);
    return res;
}

// ---- PNG ----------------------------------------------------------------------------------------

static const char *only_name(void *priv, int64_t i)
{
    (void)i;
    return priv;
}

static json_t *png_json(const struct weft_image_frame *frame)
{
    const struct weft_code_info *png = &frame->codes;
    const int32_t cicp[] = {png->cicp[0], png->cicp[1], png->cicp[2], png->cicp[3]};
    const bool points = cicp[0] || cicp[1] || cicp[2] || cicp[3];
    json_t *channels = json_array();
    for (size_t c = 0; c < frame->image.channel_count; c++)
        json_array_append_new(channels, json_text(frame->image.channels[c].name));
    return json_pack("{s:s,s:i,s:i,s:o,s:i,s:b,s:b,s:b,s:b,s:b,s:o,s:o}", "format", "png", "width",
                     frame->image.width, "height", frame->image.height, "channels", channels,
                     "bits", png->bits, "palette", png->palette, "alpha", png->alpha, "interlaced",
                     png->interlaced, "srgb", png->srgb, "icc", png->icc, "gamma",
                     png->gamma > 0.0 ? json_number(png->gamma) : json_null(), "cicp",
                     points ? json_counts(cicp, 4) : json_null());
}

static void print_png(const char *path, const struct weft_image_frame *frame)
{
    const struct weft_code_info *png = &frame->codes;
    const uint8_t *cicp = png->cicp;
    report_line("%s: PNG, %d x %d pixels, %d bits%s%s", path, frame->image.width,
                frame->image.height, png->bits, png->palette ? ", palette" : "",
                png->interlaced ? ", interlaced" : "");
    for (size_t c = 0; c < frame->image.channel_count; c++)
        report_line("  %s%s", c ? "               " : "channels       ",
                    frame->image.channels[c].name);
    if (png->gamma > 0.0)
        printf("  gamma          %.9g%s\n", png->gamma, png->srgb ? " (sRGB)" : "");
    if (png->icc)
        puts("  profile        ICC, which weft does not apply");
    if (cicp[0] || cicp[1] || cicp[2] || cicp[3])
        printf("  cICP           primaries %d, transfer %d, matrix %d, range %d\n", cicp[0],
               cicp[1], cicp[2], cicp[3]);
}

static enum weft_result inform_png(const char *path, bool json)
{
    weft_image_sequence *sequence = NULL;
    const struct weft_image_frame *frame = NULL;
    enum weft_result res = weft_image_sequence_create(
        weft_image_sequence_params(.count = 1, .name = only_name, .priv = (void *)(uintptr_t)path,
                                   .info_only = true, .log = report_log()),
        &sequence);
    if (res == WEFT_OK)
        res = weft_image_sequence_next(sequence, &frame);
    if (res == WEFT_OK && frame->result != WEFT_OK) {
        res = frame->result;
        report_error("%s", frame->message);
    } else if (res == WEFT_OK && json) {
        res = json_print(png_json(frame));
    } else if (res == WEFT_OK) {
        print_png(path, frame);
    }
    weft_image_sequence_destroy(&sequence);
    return res;
}

// ---- which of them ------------------------------------------------------------------------------

// Reads up to size bytes; -1 with an error line.
static ssize_t read_start(const char *path, unsigned char *bytes, size_t size)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    ssize_t count = fd < 0 ? -1 : read(fd, bytes, size);
    if (count < 0)
        report_error("%s cannot be read: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    return count;
}

static enum weft_result inform(const char *path, const struct option_value *raw_option, bool json)
{
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw;
    enum weft_image_file_kind kind;
    unsigned char start[8] = {0};
    enum weft_result res = raw_read(raw_option, &layout, &raw);
    if (res != WEFT_OK || raw)
        return res != WEFT_OK ? res : inform_volume(path, raw, json);
    ssize_t count = read_start(path, start, sizeof start);
    if (count < 0)
        return WEFT_ERR_OPEN;
    if (count == 0) {
        report_error("%s is empty: 0 bytes", path);
        return WEFT_ERR_FORMAT;
    }
    if (weft_volume_recognise(start, (size_t)count) != WEFT_VOLUME_MEMORY)
        return inform_volume(path, NULL, json);
    if (weft_image_recognise(start, (size_t)count, &kind))
        return kind == WEFT_IMAGE_FILE_PNG ? inform_png(path, json) : inform_image(path, json);
    report_error("%s is neither a VDB, an NRRD, a NIfTI, an EXR, a PNG nor a TIFF file: it starts "
                 "with bytes %02x %02x %02x %02x",
                 path, start[0], start[1], start[2], start[3]);
    return WEFT_ERR_FORMAT;
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[INFO_QUIET].given, values[INFO_VERBOSE].given);
    if (!operand) {
        report_error("no file given: weft info FILE (see weft help info)");
        return EXIT_CODE_USAGE;
    }
    return report_finish(inform(operand, &values[INFO_RAW], values[INFO_JSON].given));
}

const struct verb verb_info = {
    .name = "info",
    .group = VERB_VOLUMES,
    .summary = "what is in a VDB, NRRD, NIfTI, EXR, PNG or TIFF file",
    .usage = "FILE [--raw LAYOUT] [--json]",
    .description = "Lists the grids of a VDB, NRRD, NIfTI or raw file (type, components, class, "
                   "active box, transform, memory, metadata), the channels, windows and attributes "
                   "of each part of an EXR file, "
                   "or the size, bits and colour space of a PNG file. What a file is is told by "
                   "its content, not by its name.",
    .options = options,
    .option_count = INFO_OPTION_COUNT,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
