// SPDX-License-Identifier: BSD-3-Clause
// EXR files written and read: each compression, with one thread and with all, beside OpenEXR's C++
// library with as many in its pool, in turns; medians, in MB of raw values a second.
// Usage: bench_image [--bench] [--runs N] [--size WxH] [IMAGE.exr]
// An image is resampled to the size, linearly; without one there is one channel of waves. Without
// --bench a small one is written and read once. OpenEXR reads from both files what was written.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tests/support/exr_peer.h"
#include "weft.h"

enum { MAX_RUNS = 31, CHANNELS = 4 };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "bench_image: error: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, compare);
    return values[count / 2];
}

// ---- the image ----------------------------------------------------------------------------------

struct picture {
    struct weft_image image, source;
    struct weft_image_channel channels[CHANNELS];
};

// Between the source's pixels, or of waves.
static float value_at(const struct picture *p, size_t c, int x, int y)
{
    const struct weft_image *from = &p->source;
    if (!from->channel_count)
        return sinf(0.01f * (float)(x + 31 * (int)c)) * cosf(0.013f * (float)y) + 1.5f;
    const float *plane = from->channels[c % from->channel_count].plane;
    const double fx = (double)x * (from->width - 1) / p->image.width;
    const double fy = (double)y * (from->height - 1) / p->image.height;
    const float *at = plane + (size_t)fy * (size_t)from->width + (size_t)fx;
    const float tx = (float)(fx - floor(fx)), ty = (float)(fy - floor(fy));
    const float *below = at + from->width;
    return (1.0f - ty) * ((1.0f - tx) * at[0] + tx * at[1]) +
           ty * ((1.0f - tx) * below[0] + tx * below[1]);
}

static bool make(struct picture *p, const char *path, int width, int height)
{
    static const char *const names[CHANNELS] = {"A", "B", "G", "R"};
    const struct weft_image_load_params load = {.path = path, .log = &log_to_stderr};
    if (path && weft_image_load(&load, &p->source) != WEFT_OK)
        return false;
    p->image = (struct weft_image){.width = width, .height = height, .channels = p->channels};
    p->image.channel_count = path ? p->source.channel_count : 1;
    if (p->image.channel_count > CHANNELS)
        p->image.channel_count = CHANNELS;
    for (size_t c = 0; c < p->image.channel_count; c++) {
        float *plane = malloc(sizeof *plane * (size_t)width * (size_t)height);
        if (!plane)
            return false;
        p->channels[c] = (struct weft_image_channel){.plane = plane};
        snprintf(p->channels[c].name, sizeof p->channels[c].name, "%s", names[c]);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++)
                *plane++ = value_at(p, c, x, y);
    }
    return true;
}

static void clear(struct picture *p)
{
    for (size_t c = 0; c < p->image.channel_count; c++)
        free(p->channels[c].plane);
    weft_image_clear(&p->source);
}

// ---- ways ---------------------------------------------------------------------------------------

struct bench {
    struct picture picture;
    char folder[64], own[96], peers[96];
    int runs, threads;
};

static double save(const struct bench *b, int threads)
{
    const struct weft_image_save_params params = {
        .path = b->own, .threads = threads, .log = &log_to_stderr};
    const double start = weft_now_seconds();
    const enum weft_result res = weft_image_save(&b->picture.image, &params);
    return res == WEFT_OK ? weft_now_seconds() - start : -1.0;
}

static double load(const struct bench *b, int threads)
{
    const struct weft_image_load_params params = {
        .path = b->own, .threads = threads, .log = &log_to_stderr};
    struct weft_image image;
    const double start = weft_now_seconds();
    const enum weft_result res = weft_image_load(&params, &image);
    const double seconds = weft_now_seconds() - start;
    weft_image_clear(&image);
    return res == WEFT_OK ? seconds : -1.0;
}

enum way {
    SAVE_ONE,
    SAVE_ALL,
    PEER_SAVES,
    PEER_SAVES_ALL,
    LOAD_ONE,
    LOAD_ALL,
    PEER_LOADS,
    PEER_LOADS_ALL,
    WAYS
};

static double run(const struct bench *b, enum way way)
{
    char why[400] = "";
    double seconds = -1.0;
    switch (way) {
    case SAVE_ONE:
    case SAVE_ALL:
        return save(b, way == SAVE_ONE ? 1 : b->threads);
    case LOAD_ONE:
    case LOAD_ALL:
        return load(b, way == LOAD_ONE ? 1 : b->threads);
    case PEER_SAVES:
    case PEER_SAVES_ALL:
        seconds = exr_peer_write_seconds(b->peers, &b->picture.image,
                                         way == PEER_SAVES ? 0 : b->threads, why, sizeof why);
        break;
    default:
        seconds =
            exr_peer_read_seconds(b->own, way == PEER_LOADS ? 0 : b->threads, why, sizeof why);
    }
    if (seconds < 0)
        fprintf(stderr, "bench_image: OpenEXR: %s\n", why);
    return seconds;
}

static double file_size(const char *path)
{
    FILE *file = fopen(path, "rb");
    long size = 0;
    if (file && fseek(file, 0, SEEK_END) == 0)
        size = ftell(file);
    if (file)
        fclose(file);
    return 1e-6 * (double)size;
}

// One type and compression; false where something failed, or a file does not hold what it should.
static bool measure(struct bench *b, enum weft_pixel_type type,
                    enum weft_image_compression compression)
{
    struct weft_image *image = &b->picture.image;
    double seconds[WAYS][MAX_RUNS];
    char why[400];
    image->compression = compression;
    for (size_t c = 0; c < image->channel_count; c++)
        image->channels[c].type = type;
    for (int i = -1; i < b->runs; i++) { // the first one warms up
        for (int way = 0; way < WAYS; way++) {
            const double taken = run(b, (enum way)way);
            if (taken < 0.0)
                return false;
            if (i >= 0)
                seconds[way][i] = taken;
        }
    }
    const double mb = 1e-6 * (type == WEFT_PIXEL_HALF ? 2.0 : 4.0) * (double)image->width *
                      (double)image->height * (double)image->channel_count;
    printf("%-5s %-4s", weft_pixel_type_names[type], weft_image_compression_names[compression]);
    for (int way = 0; way < WAYS; way++)
        printf(" %6.0f%s", mb / median(seconds[way], b->runs), way == WAYS / 2 - 1 ? " |" : "");
    printf(" | %.1f of %.1f MB, OpenEXR %.1f\n", file_size(b->own), mb, file_size(b->peers));
    for (int i = 0; i < 2; i++) {
        if (!exr_peer_agrees(i ? b->peers : b->own, image, why, sizeof why)) {
            fprintf(stderr, "bench_image: %s: %s\n", i ? b->peers : b->own, why);
            return false;
        }
    }
    return true;
}

static bool measure_all(struct bench *b)
{
    static const enum weft_image_compression compressions[] = {
        WEFT_IMAGE_NONE, WEFT_IMAGE_RLE, WEFT_IMAGE_ZIPS, WEFT_IMAGE_ZIP, WEFT_IMAGE_PIZ};
    bool good = true;
    printf("%d x %d, %zu channels, %d threads; MB/s of raw values, median of %d\n"
           "           weft writes   OpenEXR writes |   weft reads    OpenEXR reads\n"
           "                1    all      1    all  |      1    all      1    all\n",
           b->picture.image.width, b->picture.image.height, b->picture.image.channel_count,
           b->threads, b->runs);
    for (size_t c = 0; good && c < WEFT_COUNT(compressions); c++)
        good = measure(b, WEFT_PIXEL_HALF, compressions[c]);
    for (size_t c = 0; good && c < WEFT_COUNT(compressions); c++)
        good = measure(b, WEFT_PIXEL_FLOAT, compressions[c]);
    return good;
}

int main(int argc, char **argv)
{
    struct bench b = {.runs = 1, .threads = weft_threads_available()};
    int width = 150, height = 110;
    const char *path = NULL;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--bench")) {
            b.runs = 5;
            width = height = 2048;
        } else if (!strcmp(argv[i], "--runs") && i + 1 < argc) {
            b.runs = atoi(argv[++i]);
        } else if (!strcmp(argv[i], "--size") && i + 1 < argc) {
            if (sscanf(argv[++i], "%dx%d", &width, &height) != 2)
                return 2;
        } else {
            path = argv[i];
        }
    }
    if (b.runs < 1 || b.runs > MAX_RUNS || width < 1 || height < 1)
        return 2;
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 0);
    snprintf(b.folder, sizeof b.folder, "/tmp/bench_image.XXXXXX");
    if (!mkdtemp(b.folder))
        return 1;
    snprintf(b.own, sizeof b.own, "%s/own.exr", b.folder);
    snprintf(b.peers, sizeof b.peers, "%s/peer.exr", b.folder);
    const bool good = make(&b.picture, path, width, height) && measure_all(&b);
    unlink(b.own);
    unlink(b.peers);
    rmdir(b.folder);
    clear(&b.picture);
    return good ? 0 : 1;
}
