// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static enum weft_result make_tiles(const struct weft_kernel_tiles_params *p)
{
    weft_kernel_tiles *set = NULL;
    const enum weft_result res = weft_kernel_tiles_create(p, &set);
    weft_kernel_tiles_destroy(&set);
    return res;
}

static void tile_sets(void)
{
    struct weft_kernel_tiles_params good = {
        .kernel = named("linear"), .samples = 4, .log = &logger, .memory_bytes = 1 << 24};
#define CALL make_tiles(&p)
    KERNELS_REFUSED(good, 0, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    for (int a = 0; a < 3; a++)
        ANY_INT(good, derivative.along[a], CALL);
    ANY_NUMBER(good, max_scale, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, placement, CALL);
    BAD_ENUM(good, signs, CALL);
    BAD_ENUM(good, scaling, CALL);
#undef CALL
    weft_kernel_tiles_destroy(NULL);
    weft_kernel_tiles *none = NULL;
    weft_kernel_tiles_destroy(&none);
}

static void tile_questions(void)
{
    weft_kernel_tiles *set = tiles();
    const int origin[3] = {0};
    weft_kernel_tiles_get_info(set);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int bad = ints[i], at[3] = {bad, bad, bad};
        if (bad >= 0 && bad < 4)
            continue;
        TRUE(!weft_kernel_tiles_get(set, bad) || bad == 1);
        TRUE(weft_kernel_tiles_find(set, at, WEFT_TILE_WHOLE) == -1);
        TRUE(weft_kernel_tiles_find(set, origin, (enum weft_tile_part)bad) == -1);
        TRUE(isnan(weft_kernel_tiles_position(set, bad)));
        TRUE(isnan(weft_kernel_tiles_value(set, bad, origin)));
        TRUE(isnan(weft_kernel_tiles_value(set, 0, at)));
        TRUE(weft_kernel_tiles_integer(set, bad, origin) == 0);
        TRUE(weft_kernel_tiles_integer(set, 0, at) == 0);
        TRUE(isnan(weft_kernel_tiles_exact(set, at, origin)));
        TRUE(isnan(weft_kernel_tiles_exact(set, origin, at)));
        REFUSED(weft_kernel_tiles_split(set, bad, NAN));
    }
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_kernel_tiles_split(set, 0, numbers[n]));
    weft_kernel_tiles_destroy(&set);
}

static enum weft_result make_volume(const struct weft_volume_params *p)
{
    weft_volume *v = NULL;
    const enum weft_result res = weft_volume_create(p, &v);
    weft_volume_destroy(&v);
    return res;
}

static enum weft_result make_bricks(const struct weft_volume_bricks_params *p)
{
    weft_volume *v = NULL;
    const enum weft_result res = weft_volume_create_bricks(p, &v);
    weft_volume_destroy(&v);
    return res;
}

static void volumes(void)
{
    struct weft_volume_params good = {.size = {4, 4, 4}, .data = voxels, .log = &logger};
    for (int a = 0; a < 3; a++) {
        SET_REFUSED(good, size[a], 0, make_volume(&p));
        SET_REFUSED(good, size[a], INT_MIN, make_volume(&p));
        SET_REFUSED(good, size[a], INT_MAX, make_volume(&p));
        ANY_INT(good, origin[a], make_volume(&p));
        ANY_NUMBER(good, index_to_world[a][a], make_volume(&p));
    }
    ANY_NUMBER(good, background, make_volume(&p));

    static const float values[512];
    static int32_t origins[2][3];
    static struct weft_volume_tile tile[1];
    struct weft_volume_bricks_params bricks = {.brick_count = 1,
                                               .brick_origin = (const int32_t(*)[3])origins,
                                               .brick_values = values,
                                               .tile_count = 0,
                                               .tiles = tile,
                                               .log = &logger};
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        origins[0][0] = ints[i];
        SURVIVED(make_bricks(&bricks));
        tile[0] = (struct weft_volume_tile){.size = ints[i]};
        struct weft_volume_bricks_params p = {.tile_count = 1, .tiles = tile, .log = &logger};
        SURVIVED(make_bricks(&p));
        tile[0] = (struct weft_volume_tile){.size = 128, .origin = {ints[i], 0, 0}};
        SURVIVED(make_bricks(&p));
    }
    origins[0][0] = 3; // no multiple of 8
    REFUSED(make_bricks(&bricks));
    ANY_NUMBER(bricks, index_to_world[0][1], make_bricks(&p));
    weft_volume_destroy(NULL);
}

static void volume_files(void)
{
    weft_volume *out = NULL, *v = volume();
    struct weft_volume_list list = {0};
    const struct weft_volume_open_params missing = {.path = "/nonexistent", .log = &logger};
    const struct weft_volume_save_params nowhere = {.path = "/nonexistent/x.vdb", .log = &logger};
    REFUSED(weft_volume_open(&missing, &out));
    weft_volume_opening *opening = NULL;
    const struct weft_volume_open_params nameless = {.log = &logger};
    REFUSED(weft_volume_begin(&nameless, &opening));
    TRUE(weft_volume_begin(&missing, &opening) == WEFT_OK);
    REFUSED(weft_volume_await(&opening, &out));
    TRUE(weft_volume_begin(&missing, &opening) == WEFT_OK);
    weft_volume_abandon(&opening);
    weft_volume_abandon(&opening);
    weft_volume_abandon(NULL);
    REFUSED(weft_volume_list_load(&missing, &list));
    REFUSED(weft_volume_save(v, &nowhere));
    REFUSED(weft_volume_save_nrrd(
        weft_nrrd_save_params(.path = "/nonexistent/x.nrrd", .volume = {v}, .log = &logger)));
    REFUSED(weft_volume_save_nrrd(weft_nrrd_save_params(.volume = {v}, .log = &logger)));
    REFUSED(weft_volume_save_nrrd(weft_nrrd_save_params(.path = "x", .log = &logger)));
    REFUSED(weft_volume_save_nrrd(
        weft_nrrd_save_params(.path = "x", .volume = {v}, .components = 2, .log = &logger)));
    TRUE(weft_volume_recognise("NRRD", 4) == WEFT_VOLUME_NRRD);
    TRUE(weft_volume_recognise("", 0) == WEFT_VOLUME_MEMORY);
    const struct weft_volume_open_params no_layout = {
        .path = "/nonexistent", .raw = &(struct weft_raw_layout){.skip = 0}, .log = &logger};
    REFUSED(weft_volume_open(&no_layout, &out));
    weft_volume_list_clear(&list);
    weft_volume_list_clear(NULL);
    REFUSED(weft_file_save(&logger, "/nonexistent/x", false, "", 0));
    REFUSED(weft_file_save(&logger, "", false, NULL, 0));
    REFUSED(weft_file_save_parts(&logger, "/nonexistent/x", false, NULL, 0));
    REFUSED(weft_file_save_parts(&logger, "x", false, NULL, 1));
    REFUSED(weft_file_save_parts(&logger, "x", false, &(struct weft_bytes){NULL, 1}, 1));
    weft_unfinished_discard();
    weft_volume_get_info(v);
    weft_volume_destroy(&v);
}

static enum weft_result prefilter_volume(weft_volume *v, const struct weft_kernel *kernel)
{
    weft_volume *out = NULL;
    const enum weft_result res = weft_volume_prefilter(&logger, v, kernel, &out);
    weft_volume_destroy(&out);
    return res;
}

static enum weft_result find_bricks(weft_volume *v, const struct weft_region *region)
{
    struct weft_brick_list list = {0};
    const enum weft_result res = weft_volume_find(v, region, &list);
    weft_brick_list_clear(&list);
    return res;
}

static void volume_voxels(void)
{
    weft_volume *v = volume();
    float values[2 * 512];
    EACH_BAD_KERNEL(0, REFUSED(prefilter_volume(v, &kernel)))
    struct weft_region good = {.min = {0, 0, 0}, .max = {3, 3, 3}};
#define CALL find_bricks(v, &p)
    SET_REFUSED(good, slab_count, 99, CALL);
    SET_REFUSED(good, slab_count, -1, CALL);
    SET_REFUSED(good, slab_count, INT_MAX, CALL);
    ANY_INT(good, min[0], CALL);
    ANY_INT(good, max[1], CALL);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_region p = good;
        p.slab_count = 1;
        p.slab[0] = (struct weft_slab){.normal = {numbers[n], 0, 0}, .upper = numbers[n]};
        SURVIVED(CALL);
    }
#undef CALL
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int32_t origin[1][3] = {{ints[i], 0, 0}};
        SURVIVED(weft_volume_read(v, 1, origin, values));
    }
    SURVIVED(weft_volume_read(v, 0, NULL, NULL));
    weft_brick_list_clear(NULL);
    weft_volume_destroy(&v);
}

static void images(void)
{
    static float plane[4];
    struct weft_image out = {0};
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    const struct weft_image_save_params null_device = {.path = "/dev/null", .log = &logger};
    const struct weft_image_load_params missing = {.path = "/nonexistent", .log = &logger};
    struct weft_image good = {.width = 2, .height = 2, .channel_count = 1, .channels = &channel};
#define CALL weft_image_save(&p, &null_device)
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, width, INT_MIN, CALL);
    SET_REFUSED(good, height, -1, CALL);
    SET_REFUSED(good, channel_count, 0, CALL);
    SET_REFUSED(good, compression, (enum weft_image_compression)99, CALL);
    ANY_INT(good, x, CALL);
    ANY_INT(good, y, CALL);
    ANY_INT(good, display_max[0], CALL);
    ANY_INT(good, display_min[1], CALL);
#undef CALL
    memset(channel.name, 'x', sizeof channel.name); // without an end
    SURVIVED(weft_image_save(&good, &null_device));
    memset(channel.name, 0, sizeof channel.name);
    SURVIVED(weft_image_save(&good, &null_device));
    REFUSED(weft_image_load(&missing, &out));
    weft_image_clear(&out);
    weft_image_clear(NULL);
    struct weft_image_list list;
    REFUSED(weft_image_list_load(&missing, &list));
    weft_image_list_clear(&list);
    weft_image_list_clear(NULL);
    REFUSED(weft_image_save_parts(&good, 0, &null_device, NULL));
    REFUSED(weft_image_save_parts(NULL, 1, &null_device, NULL));
    struct weft_image_packed packed;
    REFUSED(weft_image_pack(&good, 1, &logger, &packed)); // a channel without a name
    REFUSED(weft_image_pack(&good, -1, &logger, &packed));
    strcpy(channel.name, "Y");
    REFUSED(weft_image_pack(&(struct weft_image){.width = 2}, 1, &logger, &packed));
    TRUE(weft_image_pack(&good, 1, &logger, &packed) == WEFT_OK && packed.size > 4);
    weft_image_packed_clear(&packed);
    weft_image_packed_clear(&packed);
    TRUE(weft_image_block_lines(WEFT_IMAGE_ZIP) == 16);
    TRUE(weft_image_block_lines((enum weft_image_compression)99) == 1);
    const struct weft_image_attribute odd = {"a", "v2f", plane, 3};
    char text[4];
    TRUE(weft_image_attribute_format(&odd, text, sizeof text) > sizeof text);
    TRUE(weft_image_find(&good, "a") == NULL);
    TRUE(!weft_image_is_writable((enum weft_image_compression)99));
    TRUE(!weft_image_is_writable((enum weft_image_compression) - 1));
    enum weft_image_file_kind kind = WEFT_IMAGE_FILE_EXR;
    TRUE(weft_image_file_kind_find("a.b/c.TiFf", &kind) && kind == WEFT_IMAGE_FILE_TIFF);
    TRUE(!weft_image_file_kind_find("", &kind) && !weft_image_file_kind_find("png", &kind));
    TRUE(!weft_image_recognise("II*", 3, &kind) && !weft_image_recognise(NULL, 0, &kind));
    TRUE(weft_image_level_count(1, 1) == 1 && weft_image_level_count(INT32_MAX, 1) == 31);
    TRUE(weft_image_level_size(7, 1) == 3 && weft_image_level_size(7, 99) == 1);
    const struct weft_transfer none = {.curve = (enum weft_curve)99};
    TRUE(weft_transfer_light(&none, 2.0) == 2.0 && weft_transfer_code(&none, 2.0) == 2.0);
    const struct weft_code_info points = {.cicp = {1, 99, 0, 1}};
    struct weft_transfer found;
    TRUE(!weft_transfer_find(&points, &found) && found.curve == WEFT_CURVE_SRGB);
}

static const char *missing_name(void *priv, int64_t i)
{
    (void)priv;
    return i ? "/nonexistent" : NULL;
}

static void sequences(void)
{
    weft_image_sequence *sequence = NULL;
    const struct weft_image_frame *frame = NULL;
    struct weft_image_sequence_params good = {.count = 2, .name = missing_name, .log = &logger};
#define CALL weft_image_sequence_create(&p, &sequence)
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT64_MIN, CALL);
    SET_REFUSED(good, name, NULL, CALL);
    SET_REFUSED(good, readers, -1, CALL);
    SET_REFUSED(good, readers, INT_MAX, CALL);
    SET_REFUSED(good, part, -1, CALL);
    TRUE(sequence == NULL);
#undef CALL
    TRUE(weft_image_sequence_create(&good, &sequence) == WEFT_OK);
    TRUE(weft_image_sequence_next(sequence, &frame) == WEFT_OK);
    TRUE(frame->index == 1);
    TRUE(frame->result == WEFT_ERR_OPEN);
    TRUE(strstr(frame->message, "/nonexistent") != NULL);
    for (int i = 0; i < 2; i++) {
        TRUE(weft_image_sequence_next(sequence, &frame) == WEFT_OK);
        TRUE(frame == NULL);
    }
    REFUSED(weft_image_sequence_extend(sequence, 0));
    REFUSED(weft_image_sequence_extend(sequence, INT64_MIN));
    REFUSED(weft_image_sequence_extend(sequence, INT64_MAX));
    weft_image_sequence_destroy(&sequence);
    weft_image_sequence_destroy(&sequence);
    weft_image_sequence_destroy(NULL);
}

static void previews(void)
{
    static const float plane[4];
    struct weft_preview_params good = {
        .path = "/dev/null", .width = 2, .height = 2, .plane = plane, .log = &logger};
#define CALL weft_preview_save(&p, NULL)
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    ANY_NUMBER(good, low, CALL);
    ANY_NUMBER(good, high, CALL);
    struct weft_preview_frame frame = {.left = -1};
    SET_REFUSED(good, frame, &frame, CALL);
    frame = (struct weft_preview_frame){.right = INT32_MAX};
    SET_REFUSED(good, frame, &frame, CALL);
#undef CALL
    struct weft_colour_preview_params colours = {.path = "/dev/null",
                                                 .width = 2,
                                                 .height = 2,
                                                 .red = plane,
                                                 .green = plane,
                                                 .blue = plane,
                                                 .log = &logger};
#define CALL weft_colour_preview_save(&p)
    SET_REFUSED(colours, width, 0, CALL);
    SET_REFUSED(colours, height, INT_MIN, CALL);
    SET_REFUSED(colours, blue, NULL, CALL);
    SET_REFUSED(colours, threads, -1, CALL);
    ANY_NUMBER(colours, low, CALL);
    ANY_NUMBER(colours, high, CALL);
    frame = (struct weft_preview_frame){.bottom = INT32_MAX - 1};
    SET_REFUSED(colours, frame, &frame, CALL);
#undef CALL
}

static void planes(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    float row[2];
    struct weft_plane plane = {.values = values};
    TRUE(weft_plane_line(&plane, 1, 2) == values + 2);
    for (size_t i = 0; i < sizeof bad_enums / sizeof *bad_enums; i++) {
        plane.type = (enum weft_plane_type)bad_enums[i];
        TRUE(weft_plane_type_size(plane.type) == 0);
        weft_plane_row(&plane, 0, 2, row, 1);
    }
}

static void kernel_files(void)
{
    struct weft_kernel kernel;
    weft_kernel_file *file = NULL;
    REFUSED(weft_kernel_load(&logger, "table:/nonexistent", &kernel, &file));
    REFUSED(weft_kernel_load(&logger, "table:", &kernel, &file));
    weft_kernel_file_destroy(&file);
    weft_kernel_file_destroy(NULL);
}

static void meshes(void)
{
    struct weft_mesh mesh;
    const struct weft_mesh_params none = {.log = &logger},
                                  missing = {"/nowhere/a.obj", .log = &logger};
    REFUSED(weft_mesh_load(&none, &mesh));
    TRUE(!mesh.memory);
    REFUSED(weft_mesh_load(&missing, &mesh));
    TRUE(!mesh.memory);
    weft_mesh_clear(&mesh);
    weft_mesh_clear(NULL);
}

const struct caller_case callers_tiles[] = {
    {tile_sets, {F(kernel_tiles_create), F(kernel_tiles_destroy)}},
    {tile_questions,
     {F(kernel_tiles_get_info), F(kernel_tiles_get), F(kernel_tiles_find), F(kernel_tiles_position),
      F(kernel_tiles_value), F(kernel_tiles_integer), F(kernel_tiles_exact),
      F(kernel_tiles_split)}},
    {volumes, {F(volume_create), F(volume_create_bricks), F(volume_destroy)}},
    {volume_files,
     {F(volume_open), F(volume_begin), F(volume_await), F(volume_abandon), F(file_save),
      F(file_save_parts), F(unfinished_discard), F(volume_list_load), F(volume_list_clear),
      F(volume_save), F(volume_get_info), F(volume_recognise), F(volume_save_nrrd)}},
    {volume_voxels, {F(volume_prefilter), F(volume_find), F(volume_read), F(brick_list_clear)}},
    {images,
     {F(image_save), F(image_load), F(image_clear), F(image_attribute_format), F(image_find),
      F(image_is_writable), F(image_list_clear), F(image_list_load), F(image_save_parts),
      F(image_pack), F(image_packed_clear), F(image_block_lines), F(image_file_kind_find),
      F(image_recognise), F(image_level_count), F(image_level_size), F(transfer_light),
      F(transfer_code), F(transfer_find)}},
    {sequences,
     {F(image_sequence_create), F(image_sequence_destroy), F(image_sequence_next),
      F(image_sequence_extend)}},
    {previews, {F(preview_save), F(colour_preview_save)}},
    {planes, {F(plane_line), F(plane_row), F(plane_type_size)}},
    {kernel_files, {F(kernel_load), F(kernel_file_destroy)}},
    {meshes, {F(mesh_load), F(mesh_clear)}},
    {0},
};
