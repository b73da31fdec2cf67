// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/antialias/povray.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>

// Rays go through eye + forward + x right + y up, x and y in [-1/2, 1/2]: POV-Ray takes the three
// as they are, so that nothing is said of its hand.
static void write_camera(FILE *out, const struct weft_camera *camera, const int size[2])
{
    struct weft_camera_matrices m;
    if (weft_camera_compute(&pictured_log, camera, weft_camera_frame(.size = {size[0], size[1]}),
                            &m) != WEFT_OK)
        return;
    const double high = 2.0 * tan(camera->fovy_degrees * M_PI / 360.0);
    const double wide = high * size[0] / size[1];
    const double *v = m.view; // rows: right, up, back
    fprintf(out,
            "camera { perspective location <%.17g,%.17g,%.17g>\n direction <%.17g,%.17g,%.17g>\n "
            "right <%.17g,%.17g,%.17g>\n up <%.17g,%.17g,%.17g> }\n",
            camera->eye[0], camera->eye[1], camera->eye[2], -v[2], -v[6], -v[10], wide * v[0],
            wide * v[4], wide * v[8], high * v[1], high * v[5], high * v[9]);
}

static void write_colour(FILE *out, const float colour[3])
{
    fprintf(out, "texture { pigment { rgb <%.9g,%.9g,%.9g> } finish { f } }\n", (double)colour[0],
            (double)colour[1], (double)colour[2]);
}

static void write_mesh(FILE *out, const struct scene *s)
{
    fprintf(out, "mesh2 {\n vertex_vectors { %zu", s->vertex_count);
    for (size_t i = 0; i < s->vertex_count; i++)
        fprintf(out, ",\n <%.9g,%.9g,%.9g>", (double)s->vertices[i].position[0],
                (double)s->vertices[i].position[1], (double)s->vertices[i].position[2]);
    fprintf(out, " }\n texture_list { %zu,\n", s->index_count / 3);
    for (size_t i = 0; i < s->index_count; i += 3)
        write_colour(out, s->vertices[s->indices[i]].colour);
    fprintf(out, " }\n face_indices { %zu", s->index_count / 3);
    for (size_t i = 0; i < s->index_count; i += 3)
        fprintf(out, ",\n <%u,%u,%u>,%zu", s->indices[i], s->indices[i + 1], s->indices[i + 2],
                i / 3);
    fprintf(out, " }\n}\n");
}

bool povray_write(const struct pictured *pictured, const char *path)
{
    const struct scene *s = &pictured->scene;
    FILE *out = fopen(path, "w");
    if (!out) {
        perror(path);
        return false;
    }
    fprintf(out, "#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 1 }\n"
                 "#declare f = finish { ambient 0 diffuse 0 emission 1 };\n");
    fprintf(out, "background { rgb <%.17g,%.17g,%.17g> }\n", s->background[0], s->background[1],
            s->background[2]);
    write_camera(out, &s->camera, pictured->size);
    write_mesh(out, s);
    const bool good = !ferror(out);
    return !fclose(out) && good;
}

bool povray_read(const struct pictured *pictured, const char *path, float *const planes[4])
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    const int width = pictured->size[0], height = pictured->size[1];
    if (!png_image_begin_read_from_file(&png, path)) {
        fprintf(stderr, "%s: %s\n", path, png.message);
        return false;
    }
    png.format = PNG_FORMAT_LINEAR_Y | PNG_FORMAT_FLAG_COLOR;
    uint16_t *values = malloc(PNG_IMAGE_SIZE(png));
    const bool good = values && (int)png.width == width && (int)png.height == height &&
                      png_image_finish_read(&png, NULL, values, 0, NULL);
    for (int i = 0; good && i < width * height; i++) {
        const int up = (height - 1 - i / width) * width + i % width;
        for (int c = 0; c < PICTURED_COLOURS; c++)
            planes[c][up] = (float)values[PICTURED_COLOURS * i + c] / 65535.0f;
        planes[3][up] = 1.0f;
    }
    if (!good)
        fprintf(stderr, "%s: not a PNG of %d x %d pixels that can be read\n", path, width, height);
    free(values);
    png_image_free(&png);
    return good;
}
