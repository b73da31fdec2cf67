// SPDX-License-Identifier: BSD-3-Clause
// Files of keyframes.
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"
#include "tools/scene/arguments.h"
#include "tools/scene/build.h"

enum { MAX_LINE = 4096, MAX_NAMES = 1024 };

// The lines of one name.
struct track {
    char name[SCENE_NAME];
    struct scene_path path;
    int room;
};
struct reader {
    const struct weft_log *log;
    const char *file; // its name
    int line;         // its number
    const struct scene *scene;
    struct track *track;
    int count;
};

static enum weft_result complain(const struct reader *r, enum weft_result result, const char *what)
{
    log_error(r->log, "%.200s, line %d: %s", r->file, r->line, what);
    return result;
}

// ---- lines --------------------------------------------------------------------------------------

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

// Up to a blank; within double quotes blanks belong to it.
static bool read_name(const char **at, char out[SCENE_NAME])
{
    const bool quoted = **at == '"';
    const char *start = *at + quoted;
    const size_t length = quoted ? strcspn(start, "\"") : strcspn(start, " \t\r\n");
    if (length == 0 || length >= SCENE_NAME || (quoted && start[length] != '"'))
        return false;
    memcpy(out, start, length);
    out[length] = '\0';
    *at = skip_blanks(start + length + quoted);
    return true;
}

// `count` numbers with commas between them.
static bool read_numbers(const char **at, double *out, int count)
{
    for (int i = 0; i < count; i++) {
        if (i > 0 && *(*at)++ != ',')
            return false;
        if (!scene_read_number(at, &out[i]) || fabs(out[i]) > 1e30)
            return false;
    }
    const bool ended = **at == '\0' || strchr(" \t\r\n", **at);
    *at = skip_blanks(*at);
    return ended;
}

// [AXIS_X,AXIS_Y,AXIS_Z,DEGREES]
static enum weft_result read_rotation(const struct reader *r, const char **at, double out[4])
{
    double turn[4];
    if (**at == '\0')
        return WEFT_OK;
    if (!read_numbers(at, turn, 4))
        return complain(r, WEFT_ERR_FORMAT,
                        "the rotation behind the position is not AXIS_X,AXIS_Y,AXIS_Z,DEGREES");
    const double length = sqrt(scene_dot(turn, turn));
    if (turn[3] != 0.0 && !(length > 0.0 && isfinite(length)))
        return complain(r, WEFT_ERR_FORMAT, "the rotation's axis has no length");
    if (turn[3] != 0.0)
        scene_rotation(turn, turn[3], out);
    return WEFT_OK;
}

// What stands behind a name.
static enum weft_result read_key(const struct reader *r, const char *at, bool is_camera,
                                 struct scene_key *out)
{
    *out = (struct scene_key){.rotation = {0.0, 0.0, 0.0, 1.0}, .scale = 1.0};
    if (!read_numbers(&at, &out->time, 1))
        return complain(r, WEFT_ERR_FORMAT, "no time behind the name");
    if (!read_numbers(&at, out->position, 3))
        return complain(r, WEFT_ERR_FORMAT, "no position X,Y,Z behind the time");
    const enum weft_result res = read_rotation(r, &at, out->rotation);
    if (res != WEFT_OK || *at == '\0')
        return res;
    if (is_camera)
        return complain(r, WEFT_ERR_FORMAT, "a camera has no scale behind its rotation");
    if (!read_numbers(&at, &out->scale, 1) || !(out->scale > 0.0))
        return complain(r, WEFT_ERR_FORMAT,
                        "the scale behind the rotation must be a number above 0");
    return *at == '\0' ? WEFT_OK : complain(r, WEFT_ERR_FORMAT, "more behind the scale");
}

// ---- tracks -------------------------------------------------------------------------------------

static bool has_object(const struct scene *scene, const char *name)
{
    for (int i = 0; i < scene->object_count; i++)
        if (strcmp(scene->objects[i].name, name) == 0)
            return true;
    return false;
}

static struct track *find_track(const struct reader *r, const char *name)
{
    for (int i = 0; i < r->count; i++)
        if (strcmp(r->track[i].name, name) == 0)
            return &r->track[i];
    return NULL;
}

static enum weft_result complain_name(const struct reader *r, const char *name)
{
    char list[400] = "";
    for (int i = 0; i < r->scene->object_count; i++) {
        const size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%s", i ? ", " : "",
                 r->scene->objects[i].name);
    }
    log_error(r->log, "%.200s, line %d: %s is no object of the scene: there are %s, and camera",
              r->file, r->line, name, list);
    return WEFT_ERR_ARGUMENT;
}

// The track of a name, a new one where there is none yet.
static enum weft_result take_track(struct reader *r, const char *name, struct track **out)
{
    *out = find_track(r, name);
    if (*out)
        return WEFT_OK;
    if (strcmp(name, "*") != 0 && strcmp(name, "camera") != 0 && !has_object(r->scene, name))
        return complain_name(r, name);
    if (r->count == MAX_NAMES)
        return complain(r, WEFT_ERR_LIMIT, "more than 1024 names");
    struct track *list = realloc(r->track, ((size_t)r->count + 1) * sizeof *list);
    if (!list)
        return complain(r, WEFT_ERR_MEMORY, "out of memory");
    r->track = list;
    *out = &list[r->count++];
    **out = (struct track){0};
    scene_set_name((*out)->name, name);
    return WEFT_OK;
}

static enum weft_result add_key(const struct reader *r, struct track *track,
                                const struct scene_key *key)
{
    struct scene_path *path = &track->path;
    if (path->count == SCENE_MAX_KEYS)
        return complain(r, WEFT_ERR_LIMIT, "more than 4096 keys of one name");
    if (path->count > 0 && !(key->time > path->keys[path->count - 1].time))
        return complain(r, WEFT_ERR_FORMAT, "the time is not later than that of the key before");
    if (path->count == track->room) {
        const int room = track->room ? 2 * track->room : 16;
        struct scene_key *keys = realloc(path->keys, (size_t)room * sizeof *keys);
        if (!keys)
            return complain(r, WEFT_ERR_MEMORY, "out of memory");
        path->keys = keys;
        track->room = room;
    }
    path->keys[path->count++] = *key;
    return WEFT_OK;
}

// Ends a line where its comment starts; # within quotes starts none.
static void cut_comment(char *line)
{
    bool quoted = false;
    for (; *line && (*line != '#' || quoted); line++)
        quoted ^= *line == '"';
    *line = '\0';
}

static enum weft_result read_line(struct reader *r, char *line)
{
    cut_comment(line);
    const char *at = skip_blanks(r->line == 1 ? weft_text_skip_mark(line) : line);
    char name[SCENE_NAME];
    struct track *track;
    struct scene_key key;
    if (*at == '\0')
        return WEFT_OK;
    if (!read_name(&at, name))
        return complain(r, WEFT_ERR_FORMAT, "no name of 1 to 63 bytes, or a quote that stays open");
    enum weft_result res = take_track(r, name, &track);
    if (res == WEFT_OK)
        res = read_key(r, at, strcmp(name, "camera") == 0, &key);
    return res == WEFT_OK ? add_key(r, track, &key) : res;
}

static enum weft_result read_lines(struct reader *r, FILE *in)
{
    char line[MAX_LINE + 2];
    while (fgets(line, sizeof line, in)) {
        const size_t length = strlen(line);
        r->line++;
        if ((length == 0 || line[length - 1] != '\n') && !feof(in))
            return complain(r, WEFT_ERR_FORMAT, "a NUL byte, or more than 4096 bytes");
        const enum weft_result res = read_line(r, line);
        if (res != WEFT_OK)
            return res;
    }
    if (ferror(in)) {
        log_error(r->log, "%.200s: %s", r->file, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    if (r->count == 0)
        return complain(r, WEFT_ERR_FORMAT, "the file ends without a key");
    return WEFT_OK;
}

// ---- the scene ----------------------------------------------------------------------------------

// A copy for one object. false: there was no memory.
static bool copy_path(const struct scene_path *from, struct scene_path *to)
{
    *to = (struct scene_path){.keys = calloc((size_t)from->count, sizeof *to->keys)};
    if (!to->keys)
        return false;
    memcpy(to->keys, from->keys, (size_t)from->count * sizeof *to->keys);
    to->count = from->count;
    return true;
}

static void replace_path(struct scene_path *path, struct scene_path *by)
{
    if (by->count > 0) {
        free(path->keys);
        *path = *by;
        *by = (struct scene_path){0};
    }
}

// Gives paths to the objects, those of * to whom no line names. All copies are made before any is
// put in its place.
static enum weft_result put_paths(const struct reader *r, struct scene *scene)
{
    const size_t count = (size_t)scene->object_count;
    struct scene_path *path = calloc(count + 1, sizeof *path), camera = {0};
    const struct track *all = find_track(r, "*"), *moved = find_track(r, "camera");
    bool good = path && (!moved || copy_path(&moved->path, &camera));
    for (size_t i = 0; i < count && good; i++) {
        const struct track *named = find_track(r, scene->objects[i].name);
        const struct track *track = named ? named : all;
        good = !track || copy_path(&track->path, &path[i]);
    }
    for (size_t i = 0; i < count && good; i++)
        replace_path(&scene->objects[i].path, &path[i]);
    if (good)
        replace_path(&scene->camera_path, &camera);
    else
        log_error(r->log, "%.200s: out of memory for the paths", r->file);
    for (size_t i = 0; i < count && path; i++)
        free(path[i].keys);
    free(path);
    free(camera.keys);
    return good ? WEFT_OK : WEFT_ERR_MEMORY;
}

enum weft_result scene_read_keys(const struct weft_log *log, const char *path, struct scene *scene)
{
    struct reader reader = {.log = log, .file = path, .scene = scene};
    FILE *in = fopen(path, "re");
    if (!in) {
        log_error(log, "%.200s: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    enum weft_result res = read_lines(&reader, in);
    fclose(in);
    if (res == WEFT_OK)
        res = put_paths(&reader, scene);
    if (res == WEFT_OK)
        scene_find_box(scene);
    for (int i = 0; i < reader.count; i++)
        free(reader.track[i].path.keys);
    free(reader.track);
    return res;
}
