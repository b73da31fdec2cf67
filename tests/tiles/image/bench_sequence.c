// SPDX-License-Identifier: BSD-3-Clause
// Reading many files: as a sequence, by a process for each file, and by the libraries alone in one
// process. Run as a test it reads few small files. With --bench: frames a second of 1024 x 1024
// RGBA, the median of several runs in turns, and the memory of all processes.
//   bench_sequence --bench [FRAMES] [READERS]
#include <ctype.h>
#include <dirent.h>
#include <math.h>
#include <png.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openexr.h>

#include "filter/check.h"
#include "filter/half.h"
#include "filter/threads.h"
#include "tiles/image/sequence.h"

enum { CHANNELS = 4, FILES = 6, MAX_RUNS = 15, MAX_THREADS = 8 };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "bench_sequence: error: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

// ---- files --------------------------------------------------------------------------------------

enum kind { ZIP, PIZ, PNG8, PNG16, KINDS };
static const char *const kind_names[] = {"EXR half zip", "EXR half piz", "PNG 8", "PNG 16"};

struct bench {
    char folder[64], path[KINDS][FILES][96];
    int side, frames, threads;
};

// A rendered picture: smooth, with noise of a path tracer's size.
static float value_at(int x, int y, int c, int file)
{
    uint32_t h =
        (uint32_t)(x * 73856093) ^ (uint32_t)(y * 19349663) ^ (uint32_t)((c + 4 * file) * 83492791);
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    const float noise = (float)((h ^ h >> 15) & 0xffff) / 65536.0f - 0.5f;
    const float smooth = 0.5f + 0.4f * sinf(0.011f * (float)(x + 17 * c)) * cosf(0.007f * (float)y);
    return c == 3 ? 1.0f : smooth + 0.05f * noise;
}

static bool write_exr(const struct bench *b, enum kind kind, int file)
{
    static const char *const names[CHANNELS] = {"A", "B", "G", "R"};
    struct weft_image_channel channels[CHANNELS];
    const size_t pixels = (size_t)b->side * (size_t)b->side;
    struct weft_image image = {.width = b->side,
                               .height = b->side,
                               .compression = kind == ZIP ? WEFT_IMAGE_ZIP : WEFT_IMAGE_PIZ,
                               .channel_count = CHANNELS,
                               .channels = channels};
    float *planes = malloc(CHANNELS * pixels * sizeof *planes);
    for (int c = 0; planes && c < CHANNELS; c++) {
        float *plane = planes + (size_t)c * pixels;
        channels[c] = (struct weft_image_channel){.type = WEFT_PIXEL_HALF, .plane = plane};
        snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
        for (int i = 0; i < b->side * b->side; i++)
            plane[i] = value_at(i % b->side, i / b->side, 3 - c, file);
    }
    const struct weft_image_save_params params = {.path = b->path[kind][file],
                                                  .log = &log_to_stderr};
    const bool good = planes && weft_image_save(&image, &params) == WEFT_OK;
    free(planes);
    return good;
}

static bool write_png(const struct bench *b, enum kind kind, int file)
{
    const bool wide = kind == PNG16;
    png_image image = {.version = PNG_IMAGE_VERSION};
    image.width = image.height = (png_uint_32)b->side;
    const size_t count = (size_t)b->side * (size_t)b->side * CHANNELS;
    unsigned char *codes = malloc(count * 2);
    FILE *f = fopen(b->path[kind][file], "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    if (!codes || !f || setjmp(png_jmpbuf(png)))
        return false;
    for (size_t i = 0; i < count; i++) {
        const int p = (int)(i / CHANNELS);
        const float v = value_at(p % b->side, p / b->side, (int)(i % CHANNELS), file);
        const int code = (int)lrintf(fminf(fmaxf(v, 0.0f), 1.0f) * (wide ? 65535.0f : 255.0f));
        if (wide) {
            codes[2 * i] = (unsigned char)(code >> 8);
            codes[2 * i + 1] = (unsigned char)code;
        } else {
            codes[i] = (unsigned char)code;
        }
    }
    png_init_io(png, f);
    png_set_IHDR(png, info, image.width, image.height, wide ? 16 : 8, PNG_COLOR_TYPE_RGB_ALPHA,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    png_write_info(png, info);
    for (int y = 0; y < b->side; y++)
        png_write_row(png, codes + (size_t)y * (size_t)b->side * CHANNELS * (wide ? 2 : 1));
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    free(codes);
    return fclose(f) == 0;
}

static bool write_files(struct bench *b)
{
    snprintf(b->folder, sizeof b->folder, "/tmp/weft-bench-XXXXXX");
    if (!mkdtemp(b->folder))
        return false;
    for (int k = 0; k < KINDS; k++)
        for (int i = 0; i < FILES; i++) {
            snprintf(b->path[k][i], sizeof b->path[k][i], "%s/%d-%d", b->folder, k, i);
            if (!(k < PNG8 ? write_exr(b, k, i) : write_png(b, k, i)))
                return false;
        }
    return true;
}

static void remove_files(const struct bench *b)
{
    for (int k = 0; k < KINDS; k++)
        for (int i = 0; i < FILES; i++)
            remove(b->path[k][i]);
    rmdir(b->folder);
}

// ---- the libraries alone ------------------------------------------------------------------------

static bool plain_exr(const char *path, uint16_t *planes)
{
    exr_context_t exr = NULL;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_attr_box2i_t box;
    int32_t lines = 0;
    if (exr_start_read(&exr, path, &init))
        return false;
    exr_get_data_window(exr, 0, &box);
    exr_get_scanlines_per_chunk(exr, 0, &lines);
    const size_t width = (size_t)(box.max.x - box.min.x + 1);
    const size_t height = (size_t)(box.max.y - box.min.y + 1);
    exr_result_t rv = 0;
    for (int y = box.min.y; !rv && y <= box.max.y; y += lines) {
        exr_chunk_info_t chunk;
        rv = exr_read_scanline_chunk_info(exr, 0, y, &chunk);
        if (!rv)
            rv = y == box.min.y ? exr_decoding_initialize(exr, 0, &chunk, &decode)
                                : exr_decoding_update(exr, 0, &chunk, &decode);
        for (int c = 0; !rv && c < decode.channel_count; c++) {
            exr_coding_channel_info_t *channel = &decode.channels[c];
            uint16_t *to = planes + (size_t)c * width * height + (size_t)(y - box.min.y) * width;
            channel->decode_to_ptr = (uint8_t *)to;
            channel->user_pixel_stride = channel->user_bytes_per_element = 2;
            channel->user_line_stride = (int32_t)(2 * width);
            channel->user_data_type = EXR_PIXEL_HALF;
        }
        if (!rv && y == box.min.y)
            rv = exr_decoding_choose_default_routines(exr, 0, &decode);
        if (!rv)
            rv = exr_decoding_run(exr, 0, &decode);
    }
    exr_decoding_destroy(exr, &decode);
    exr_finish(&exr);
    return !rv;
}

static bool plain_png(const char *path, unsigned char *codes)
{
    FILE *f = fopen(path, "rb");
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    if (!f || setjmp(png_jmpbuf(png)))
        return false;
    png_init_io(png, f);
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) == 16)
        png_set_swap(png);
    png_read_update_info(png, info);
    const size_t row = png_get_rowbytes(png, info);
    for (png_uint_32 y = 0; y < png_get_image_height(png, info); y++)
        png_read_row(png, codes + y * row, NULL);
    png_read_end(png, NULL);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(f);
    return true;
}

struct plain {
    const struct bench *b;
    enum kind kind;
    void *memory[MAX_THREADS];
};

static bool plain_part(void *priv, int thread, size_t i)
{
    const struct plain *p = priv;
    const char *path = p->b->path[p->kind][i % FILES];
    return p->kind < PNG8 ? plain_exr(path, p->memory[thread]) : plain_png(path, p->memory[thread]);
}

static bool run_plain(const struct bench *b, enum kind kind, int threads)
{
    struct plain p = {.b = b, .kind = kind};
    const size_t bytes = (size_t)b->side * (size_t)b->side * CHANNELS * 2;
    for (int t = 0; t < threads; t++)
        p.memory[t] = malloc(bytes);
    const bool good = weft_threads_run(threads, (size_t)b->frames, plain_part, &p);
    for (int t = 0; t < threads; t++)
        free(p.memory[t]);
    return good;
}

// ---- weft ---------------------------------------------------------------------------------------

struct names {
    const struct bench *b;
    enum kind kind;
};

static const char *name_of(void *priv, int64_t i)
{
    const struct names *names = priv;
    return names->b->path[names->kind][i % FILES];
}

// Reads a status line of a process, "VmHWM" in KiB.
static long status_of(int pid, const char *key)
{
    char path[64], line[256];
    long value = 0;
    snprintf(path, sizeof path, "/proc/%d/status", pid);
    FILE *f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, key, strlen(key)))
            value = atol(line + strlen(key) + 1);
    if (f)
        fclose(f);
    return value;
}

// Highest resident memory of this process and its children, added up: what they share counts twice.
static long all_memory(long *own)
{
    *own = status_of(getpid(), "VmHWM");
    long sum = *own;
    DIR *folder = opendir("/proc");
    for (struct dirent *e; folder && (e = readdir(folder));)
        if (isdigit((unsigned char)*e->d_name) &&
            status_of(atoi(e->d_name), "PPid") == (long)getpid())
            sum += status_of(atoi(e->d_name), "VmHWM");
    if (folder)
        closedir(folder);
    return sum;
}

static bool run_sequence(const struct bench *b, enum kind kind, int readers, long *memory)
{
    struct names names = {b, kind};
    weft_image_sequence *sequence = NULL;
    const struct weft_image_frame *frame = NULL;
    enum weft_result res = weft_image_sequence_create(
        weft_image_sequence_params(.count = b->frames, .name = name_of, .priv = &names,
                                   .readers = readers, .log = &log_to_stderr),
        &sequence);
    int count = 0;
    long own;
    while (res == WEFT_OK && (res = weft_image_sequence_next(sequence, &frame)) == WEFT_OK &&
           frame) {
        if (frame->result != WEFT_OK)
            res = frame->result;
        if (++count == b->frames && memory)
            *memory = all_memory(&own);
    }
    weft_image_sequence_destroy(&sequence);
    return res == WEFT_OK && count == b->frames;
}

// As before there were sequences: EXR files alone.
static bool run_processes(const struct bench *b, enum kind kind, int threads)
{
    for (int i = 0; i < b->frames; i++) {
        struct weft_image image;
        const struct weft_image_load_params params = {
            .path = b->path[kind][i % FILES], .threads = threads, .log = &log_to_stderr};
        if (weft_image_load(&params, &image) != WEFT_OK)
            return false;
        weft_image_clear(&image);
    }
    return true;
}

// ---- comparing ----------------------------------------------------------------------------------

enum way { SEQUENCE_ONE, SEQUENCE_ALL, PLAIN_ONE, PLAIN_ALL, PROCESS_ONE, PROCESS_ALL, WAYS };
static const char *const way_names[] = {
    "sequence, 1 reader",         "sequence, all readers",     "library alone, 1 thread",
    "library alone, all threads", "process a frame, 1 thread", "process a frame, all threads"};

static bool applies(enum kind kind, enum way way)
{
    return kind < PNG8 || way < PROCESS_ONE;
}

static bool run(const struct bench *b, enum kind kind, enum way way, long *memory)
{
    const int threads =
        way == SEQUENCE_ALL || way == PLAIN_ALL || way == PROCESS_ALL ? b->threads : 1;
    switch (way) {
    case SEQUENCE_ONE:
    case SEQUENCE_ALL:
        return run_sequence(b, kind, threads, memory);
    case PLAIN_ONE:
    case PLAIN_ALL:
        return run_plain(b, kind, threads);
    default:
        return run_processes(b, kind, threads);
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool measure(const struct bench *b, enum kind kind, int runs)
{
    double seconds[WAYS][MAX_RUNS];
    long memory = 0;
    for (int r = 0; r < runs; r++)
        for (int w = 0; w < WAYS; w++) {
            if (!applies(kind, w))
                continue;
            const double start = weft_now_seconds();
            if (!run(b, kind, w, &memory)) {
                fprintf(stderr, "bench_sequence: %s: %s failed\n", kind_names[kind], way_names[w]);
                return false;
            }
            seconds[w][r] = weft_now_seconds() - start;
        }
    for (int w = 0; w < WAYS; w++)
        if (applies(kind, w)) {
            qsort(seconds[w], (size_t)runs, sizeof seconds[w][0], compare);
            printf("%-14s %-30s %8.1f frames/s\n", kind_names[kind], way_names[w],
                   b->frames / seconds[w][runs / 2]);
        }
    printf("%-14s peak memory of all processes, sequence with all readers, sum: %ld MiB\n",
           kind_names[kind], memory >> 10);
    return true;
}

int main(int argc, char **argv)
{
    const bool bench = argc > 1 && !strcmp(argv[1], "--bench");
    struct bench b = {.side = bench ? 1024 : 64, .frames = bench ? 40 : 8, .threads = 2};
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    if (bench && argc > 2)
        b.frames = atoi(argv[2]);
    b.threads = bench && argc > 3 ? atoi(argv[3]) : weft_threads_available();
    if (b.threads > MAX_THREADS)
        b.threads = MAX_THREADS;
    if (b.frames < 1 || b.threads < 1 || !write_files(&b)) {
        fprintf(stderr, "bench_sequence: no files\n");
        return 1;
    }
    bool good = true;
    for (int k = 0; good && k < KINDS; k++)
        good = measure(&b, k, bench ? 3 : 1);
    remove_files(&b);
    return good ? 0 : 1;
}
