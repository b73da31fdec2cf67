// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/state_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "tools/common/report.h"

enum { FORMAT = 1, BYTE_ORDER_MARK = 0x01020304, ALIGNMENT = 8 };
static const char magic[8] = {'W', 'E', 'F', 'T', 'M', 'E', 'A', 'N'};

enum part { SETTINGS, FRAMES, FIRST, CARRIED, SUMS, PARTS };

// What is checked by itself, and what the checksum is of.
struct mark {
    char magic[sizeof magic];
    uint32_t format, order;
    uint64_t size, checksum;
};
struct header {
    char version[32];
    uint64_t sizes[PARTS];
};
struct frame_record {
    int64_t size, changed_ns;
    double weight;
    uint32_t name_length, problem_length; // without the NULs that end them
};

static size_t padding(size_t size)
{
    return (ALIGNMENT - size % ALIGNMENT) % ALIGNMENT;
}

// ---- files --------------------------------------------------------------------------------------

bool state_file_is(const char *path)
{
    char start[sizeof magic];
    struct stat st;
    if (stat(path, &st) != 0 || !S_ISREG(st.st_mode))
        return false;
    FILE *file = fopen(path, "rbe");
    const bool is =
        file && fread(start, sizeof start, 1, file) == 1 && memcmp(start, magic, sizeof magic) == 0;
    if (file)
        fclose(file);
    return is;
}

struct state_stamp state_file_stamp(const char *path)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return (struct state_stamp){.size = -1};
    return (struct state_stamp){st.st_size,
                                st.st_mtim.tv_sec * INT64_C(1000000000) + st.st_mtim.tv_nsec};
}

bool state_file_same_stamp(const struct state_stamp *a, const struct state_stamp *b)
{
    return a->size == b->size && a->changed_ns == b->changed_ns;
}

// ---- writing ------------------------------------------------------------------------------------

static void put_settings(FILE *out, const struct state_content *content)
{
    fwrite(content->folder, strlen(content->folder) + 1, 1, out);
    for (size_t i = 0; i < content->setting_count; i++) {
        const struct state_setting *s = &content->settings[i];
        fwrite(s->name, strlen(s->name) + 1, 1, out);
        fwrite(s->value, strlen(s->value) + 1, 1, out);
    }
}

static void put_frames(FILE *out, const struct state_content *content)
{
    static const char zero[ALIGNMENT];
    for (size_t i = 0; i < content->frame_count; i++) {
        const struct state_frame *f = &content->frames[i];
        const size_t name = strlen(f->name), problem = strlen(f->problem);
        const struct frame_record record = {f->stamp.size, f->stamp.changed_ns, f->weight,
                                            (uint32_t)name, (uint32_t)problem};
        fwrite(&record, sizeof record, 1, out);
        fwrite(f->name, name + 1, 1, out);
        fwrite(f->problem, problem + 1, 1, out);
        fwrite(zero, padding(name + problem + 2), 1, out);
    }
}

// A list as bytes, to be freed; no data where memory ran out.
static struct weft_bytes make_bytes(const struct state_content *content,
                                    void (*put)(FILE *out, const struct state_content *content))
{
    char *data = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&data, &size);
    if (!out)
        return (struct weft_bytes){NULL, 0};
    put(out, content);
    if (report_close(out))
        return (struct weft_bytes){data, size};
    free(data);
    return (struct weft_bytes){NULL, 0};
}

static enum weft_result write_parts(const char *path, const struct weft_bytes part[PARTS])
{
    static const char zero[ALIGNMENT];
    struct mark mark = {.format = FORMAT, .order = BYTE_ORDER_MARK, .size = sizeof mark};
    struct header header = {{0}, {0}};
    struct weft_bytes piece[2 + 2 * PARTS] = {{&mark, sizeof mark}, {&header, sizeof header}};
    XXH3_state_t *hash = XXH3_createState();
    if (!hash)
        return WEFT_ERR_MEMORY;
    memcpy(mark.magic, magic, sizeof magic);
    snprintf(header.version, sizeof header.version, "%s", weft_version());
    for (int i = 0; i < PARTS; i++) {
        header.sizes[i] = part[i].size;
        piece[2 + 2 * i] = part[i];
        piece[3 + 2 * i] = (struct weft_bytes){zero, padding(part[i].size)};
    }
    XXH3_64bits_reset(hash);
    for (int i = 1; i < 2 + 2 * PARTS; i++) {
        mark.size += piece[i].size;
        XXH3_64bits_update(hash, piece[i].data, piece[i].size);
    }
    mark.checksum = XXH3_64bits_digest(hash);
    XXH3_freeState(hash);
    return weft_file_save_parts(report_log(), path, false, piece, 2 + 2 * PARTS);
}

enum weft_result state_file_write(const char *path, const struct state_content *content)
{
    const struct weft_bytes settings = make_bytes(content, put_settings);
    const struct weft_bytes frames = make_bytes(content, put_frames);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (settings.data && frames.data)
        res = write_parts(path, (struct weft_bytes[]){[SETTINGS] = settings,
                                                      [FRAMES] = frames,
                                                      [FIRST] = content->first,
                                                      [CARRIED] = content->carried,
                                                      [SUMS] = content->sums});
    if (res == WEFT_ERR_MEMORY)
        report_error("%s: out of memory for a state of %zu frames", path, content->frame_count);
    free((void *)settings.data);
    free((void *)frames.data);
    return res;
}

// ---- reading ------------------------------------------------------------------------------------

static enum weft_result damaged(const char *path, const char *why)
{
    report_error("%s: the state is damaged: %s", path, why);
    return WEFT_ERR_FORMAT;
}

// What must be right before the rest is worth a look; size: of the file.
static enum weft_result check_mark(const char *path, const struct mark *mark, uint64_t size)
{
    if (size < sizeof mark->magic || memcmp(mark->magic, magic, sizeof magic) != 0) {
        report_error("%s: no state of weft accumulate", path);
        return WEFT_ERR_FORMAT;
    }
    if (size < sizeof *mark + sizeof(struct header)) {
        report_error("%s: the state is cut: only %" PRIu64 " bytes are there", path, size);
        return WEFT_ERR_FORMAT;
    }
    if (mark->order != BYTE_ORDER_MARK) {
        report_error("%s: the state is of a machine with another byte order", path);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (mark->format != FORMAT) {
        report_error("%s: the state is of format %" PRIu32 ", from a newer weft: this is %s, which "
                     "reads format %d",
                     path, mark->format, weft_version(), FORMAT);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (mark->size > size) {
        report_error("%s: the state is cut: %" PRIu64 " of its %" PRIu64 " bytes are there", path,
                     size, mark->size);
        return WEFT_ERR_FORMAT;
    }
    return mark->size == size ? WEFT_OK : damaged(path, "more bytes are there than it tells");
}

// Where the parts are, within `size` bytes behind the mark.
static enum weft_result find_parts(const char *path, const char *bytes, size_t size,
                                   struct weft_bytes part[PARTS])
{
    struct header header;
    memcpy(&header, bytes, sizeof header);
    header.version[sizeof header.version - 1] = 0;
    if (strcmp(header.version, weft_version()) != 0) {
        report_error("%s: the state is of weft %s: this is %s, whose result may be another", path,
                     header.version, weft_version());
        return WEFT_ERR_UNSUPPORTED;
    }
    size_t at = sizeof header;
    for (int i = 0; i < PARTS; i++) {
        if (header.sizes[i] > size - at || padding(header.sizes[i]) > size - at - header.sizes[i])
            return damaged(path, "a part is beyond its end");
        part[i] = (struct weft_bytes){bytes + at, header.sizes[i]};
        at += header.sizes[i] + padding(header.sizes[i]);
    }
    return at == size ? WEFT_OK : damaged(path, "its parts are not all of it");
}

// The strings of a part, of which each is ended; 0 where the last one is not.
static size_t count_strings(const struct weft_bytes *part)
{
    const char *text = part->data;
    size_t count = 0;
    for (size_t i = 0; i < part->size; i++)
        count += text[i] == 0;
    return part->size && text[part->size - 1] ? 0 : count;
}

static enum weft_result take_settings(const char *path, const struct weft_bytes *part,
                                      struct state_file *out)
{
    const size_t strings = count_strings(part);
    if (strings % 2 != 1)
        return damaged(path, "a setting is not whole");
    const size_t count = (strings - 1) / 2;
    out->settings = calloc(count + 1, sizeof *out->settings);
    if (!out->settings)
        return WEFT_ERR_MEMORY;
    out->content.folder = part->data;
    const char *text = out->content.folder + strlen(out->content.folder) + 1;
    for (size_t i = 0; i < count; i++) {
        out->settings[i].name = text;
        out->settings[i].value = text + strlen(text) + 1;
        text = out->settings[i].value + strlen(out->settings[i].value) + 1;
    }
    out->content.settings = out->settings;
    out->content.setting_count = count;
    return WEFT_OK;
}

// One frame at *at, which moves on; false where it is not whole.
static bool take_frame(const struct weft_bytes *part, size_t *at, struct state_frame *out)
{
    struct frame_record r;
    if (part->size - *at < sizeof r)
        return false;
    memcpy(&r, (const char *)part->data + *at, sizeof r);
    *at += sizeof r;
    const size_t length = (size_t)r.name_length + r.problem_length + 2;
    const char *name = (const char *)part->data + *at, *problem = name + r.name_length + 1;
    if (part->size - *at < length + padding(length) ||
        strnlen(name, r.name_length + 1) != r.name_length ||
        strnlen(problem, r.problem_length + 1) != r.problem_length)
        return false;
    *at += length + padding(length);
    *out = (struct state_frame){name, {r.size, r.changed_ns}, r.weight, problem};
    return true;
}

static enum weft_result take_frames(const char *path, const struct weft_bytes *part,
                                    struct state_file *out)
{
    const size_t most = part->size / sizeof(struct frame_record);
    out->frames = calloc(most + 1, sizeof *out->frames);
    if (!out->frames)
        return WEFT_ERR_MEMORY;
    size_t count = 0;
    for (size_t at = 0; at < part->size; count++)
        if (!take_frame(part, &at, &out->frames[count]))
            return damaged(path, "a frame is not whole");
    out->content.frames = out->frames;
    out->content.frame_count = count;
    return WEFT_OK;
}

static enum weft_result read_bytes(const char *path, FILE *file, size_t size, char **out)
{
    *out = malloc(size + 1);
    if (!*out)
        return WEFT_ERR_MEMORY;
    if (fread(*out, 1, size, file) == size)
        return WEFT_OK;
    report_error("cannot read %s: %s", path, ferror(file) ? strerror(errno) : "it became shorter");
    return WEFT_ERR_OPEN;
}

// Of an open file of `size` bytes.
static enum weft_result read_open(const char *path, FILE *file, uint64_t size,
                                  struct state_file *out)
{
    struct mark mark = {{0}, 0, 0, 0, 0};
    struct weft_bytes part[PARTS];
    if (fread(&mark, 1, sizeof mark, file) < sizeof mark && ferror(file)) {
        report_error("cannot read %s: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    enum weft_result res = check_mark(path, &mark, size);
    const size_t rest = (size_t)size - sizeof mark;
    if (res == WEFT_OK)
        res = read_bytes(path, file, rest, &out->bytes);
    if (res == WEFT_OK && XXH3_64bits(out->bytes, rest) != mark.checksum)
        res = damaged(path, "its checksum is another one");
    if (res == WEFT_OK)
        res = find_parts(path, out->bytes, rest, part);
    if (res == WEFT_OK)
        res = take_settings(path, &part[SETTINGS], out);
    if (res == WEFT_OK)
        res = take_frames(path, &part[FRAMES], out);
    if (res == WEFT_OK) {
        out->content.first = part[FIRST];
        out->content.carried = part[CARRIED];
        out->content.sums = part[SUMS];
    }
    return res;
}

enum weft_result state_file_read(const char *path, struct state_file *out)
{
    *out = (struct state_file){.bytes = NULL};
    struct stat st;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    FILE *file = fd >= 0 && fstat(fd, &st) == 0 ? fdopen(fd, "rb") : NULL;
    if (!file) {
        report_error("cannot read %s: %s", path, strerror(errno));
        if (fd >= 0)
            close(fd);
        return WEFT_ERR_OPEN;
    }
    enum weft_result res = WEFT_ERR_OPEN;
    if (S_ISREG(st.st_mode))
        res = read_open(path, file, (uint64_t)st.st_size, out);
    else
        report_error("%s: a state must be a file", path);
    fclose(file);
    if (res == WEFT_ERR_MEMORY)
        report_error("%s: out of memory for a state of %jd bytes", path, (intmax_t)st.st_size);
    if (res != WEFT_OK)
        state_file_clear(out);
    return res;
}

void state_file_clear(struct state_file *file)
{
    free(file->bytes);
    free(file->settings);
    free(file->frames);
    *file = (struct state_file){.bytes = NULL};
}
