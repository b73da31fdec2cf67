// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_attribute.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

// ---- headers ------------------------------------------------------------------------------------

static const char *take_text(const unsigned char *header, size_t size, size_t *at)
{
    const char *text = (const char *)header + *at;
    const char *end = memchr(text, '\0', size - *at);
    if (!end || end - text > WEFT_ATTRIBUTE_NAME_MAX)
        return NULL;
    *at += (size_t)(end - text) + 1;
    return text;
}

static uint32_t load32(const void *data)
{
    const unsigned char *b = data;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

enum weft_attribute_step weft_attribute_next(const unsigned char *header, size_t size, size_t *at,
                                             struct weft_image_attribute *out)
{
    out->name = take_text(header, size, at);
    if (!out->name)
        return WEFT_ATTRIBUTE_BROKEN;
    if (!*out->name)
        return WEFT_ATTRIBUTE_END;
    out->type = take_text(header, size, at);
    if (!out->type || !*out->type || size - *at < 4)
        return WEFT_ATTRIBUTE_BROKEN;
    out->size = load32(header + *at);
    *at += 4;
    if (out->size > size - *at || out->size > INT32_MAX)
        return WEFT_ATTRIBUTE_BROKEN;
    out->data = header + *at;
    *at += out->size;
    return WEFT_ATTRIBUTE_TAKEN;
}

bool weft_attribute_is_structure(const char *name)
{
    static const char *const names[] = {"channels",      "chunkCount", "compression", "dataWindow",
                                        "displayWindow", "lineOrder",  "name",        "tiles",
                                        "type",          "version"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++)
        if (!strcmp(name, names[i]))
            return true;
    return false;
}

// ---- headers that are made ----------------------------------------------------------------------

bool weft_attribute_float(const struct weft_image_attribute *a, float *out)
{
    if (!a || strcmp(a->type, "float") || a->size != 4)
        return false;
    const uint32_t bits = load32(a->data);
    memcpy(out, &bits, sizeof *out);
    return true;
}

static const struct {
    const char *name, *keyword;
} png_names[] = {{"comments", "Description"},
                 {"owner", "Copyright"},
                 {"artist", "Author"},
                 {"capDate", "Creation Time"}};

const char *weft_attribute_png_name(const char *name)
{
    for (size_t i = 0; i < WEFT_COUNT(png_names); i++)
        if (!strcmp(name, png_names[i].name))
            return png_names[i].keyword;
    return name;
}

const char *weft_attribute_of_png(const char *keyword)
{
    for (size_t i = 0; i < WEFT_COUNT(png_names); i++)
        if (!strcmp(keyword, png_names[i].keyword))
            return png_names[i].name;
    return keyword;
}

static void append(struct weft_attribute_list *list, const void *data, size_t size)
{
    if (list->failed)
        return;
    if (list->room - list->size < size) {
        const size_t room = 2 * (list->size + size) + 256;
        unsigned char *more = realloc(list->data, room);
        list->failed = !more;
        if (!more)
            return;
        list->data = more;
        list->room = room;
    }
    if (size)
        memcpy(list->data + list->size, data, size);
    list->size += size;
}

static bool is_there(const struct weft_attribute_list *list, const char *name)
{
    struct weft_image_attribute attribute;
    for (size_t at = 0; at < list->size;)
        if (weft_attribute_next(list->data, list->size, &at, &attribute) != WEFT_ATTRIBUTE_TAKEN ||
            !strcmp(attribute.name, name))
            return true;
    return false;
}

void weft_attribute_add(struct weft_attribute_list *list, const char *name, const char *type,
                        const void *data, size_t size)
{
    const size_t length = strlen(name);
    const unsigned char bytes[4] = {(unsigned char)size, (unsigned char)(size >> 8),
                                    (unsigned char)(size >> 16), (unsigned char)(size >> 24)};
    if (!length || length > WEFT_ATTRIBUTE_NAME_MAX || size > INT32_MAX || list->failed ||
        (weft_attribute_is_structure(name) && strcmp(name, "name")) || is_there(list, name))
        return;
    append(list, name, length + 1);
    append(list, type, strlen(type) + 1);
    append(list, bytes, sizeof bytes);
    append(list, data, size);
}

void weft_attribute_add_float(struct weft_attribute_list *list, const char *name, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const unsigned char bytes[4] = {(unsigned char)bits, (unsigned char)(bits >> 8),
                                    (unsigned char)(bits >> 16), (unsigned char)(bits >> 24)};
    weft_attribute_add(list, name, "float", bytes, sizeof bytes);
}

bool weft_attribute_end(struct weft_attribute_list *list)
{
    append(list, "", 1);
    return !list->failed;
}

// ---- in words -----------------------------------------------------------------------------------

// What was formatted so far; `length` goes on counting where the room ends.
struct words {
    char *text;
    size_t size, length;
};

static void put(struct words *w, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++, w->length++) {
        const unsigned char c = (unsigned char)text[i];
        if (w->length + 1 < w->size)
            w->text[w->length] = (char)(c == '\n' || c == '\t'  ? ' '
                                        : c < 0x20 || c == 0x7f ? '?'
                                                                : c);
    }
}

__attribute__((format(printf, 2, 3))) static void print(struct words *w, const char *format, ...)
{
    char text[80];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    put(w, text, strlen(text));
}

// Types that are lists of numbers of one kind: i: int32, f: float, d: double.
static const struct number_type {
    const char *name;
    char kind;
    size_t count;
} number_types[] = {
    {"int", 'i', 1},     {"float", 'f', 1}, {"double", 'd', 1},
    {"box2i", 'i', 4},   {"box2f", 'f', 4}, {"chromaticities", 'f', 8},
    {"keycode", 'i', 7}, {"m33f", 'f', 9},  {"m33d", 'd', 9},
    {"m44f", 'f', 16},   {"m44d", 'd', 16}, {"v2i", 'i', 2},
    {"v2f", 'f', 2},     {"v2d", 'd', 2},   {"v3i", 'i', 3},
    {"v3f", 'f', 3},     {"v3d", 'd', 3},   {"floatvector", 'f', 0},
};

static void put_number(struct words *w, char kind, const unsigned char *data)
{
    const uint32_t low = load32(data);
    float single;
    double real;
    if (kind == 'i') {
        print(w, "%" PRId32, (int32_t)low);
    } else if (kind == 'f') {
        memcpy(&single, &low, sizeof single);
        print(w, "%.9g", (double)single);
    } else {
        const uint64_t bits = low | (uint64_t)load32(data + 4) << 32;
        memcpy(&real, &bits, sizeof real);
        print(w, "%.17g", real);
    }
}

static bool put_numbers(struct words *w, const struct weft_image_attribute *a)
{
    for (size_t t = 0; t < WEFT_COUNT(number_types); t++) {
        const struct number_type *type = &number_types[t];
        const size_t bytes = type->kind == 'd' ? 8 : 4, count = a->size / bytes;
        if (strcmp(a->type, type->name))
            continue;
        if (a->size % bytes || (type->count && count != type->count))
            return false;
        for (size_t i = 0; i < count; i++) {
            if (i)
                put(w, " ", 1);
            put_number(w, type->kind, (const unsigned char *)a->data + i * bytes);
        }
        return true;
    }
    return false;
}

static bool put_strings(struct words *w, const struct weft_image_attribute *a)
{
    const unsigned char *data = a->data;
    for (size_t at = 0; at < a->size;) {
        if (a->size - at < 4 || load32(data + at) > a->size - at - 4)
            return false;
        const size_t length = load32(data + at);
        if (at)
            put(w, ", ", 2);
        put(w, (const char *)data + at + 4, length);
        at += 4 + length;
    }
    return true;
}

// Binary-coded decimals, as SMPTE 12M has them; the flags above them are not shown.
static void put_timecode(struct words *w, uint32_t t)
{
    print(w, "%x%x:%x%x:%x%x:%x%x", t >> 28 & 3, t >> 24 & 15, t >> 20 & 7, t >> 16 & 15,
          t >> 12 & 7, t >> 8 & 15, t >> 4 & 3, t & 15);
}

static bool put_known(struct words *w, const struct weft_image_attribute *a)
{
    static const char *const envmap[] = {"latitude-longitude", "cube"};
    const unsigned char *data = a->data;
    if (!strcmp(a->type, "string"))
        put(w, a->data, a->size);
    else if (!strcmp(a->type, "stringvector"))
        return put_strings(w, a);
    else if (!strcmp(a->type, "envmap") && a->size == 1 && data[0] < WEFT_COUNT(envmap))
        print(w, "%s", envmap[data[0]]);
    else if (!strcmp(a->type, "rational") && a->size == 8)
        print(w, "%" PRId32 "/%" PRIu32, (int32_t)load32(data), load32(data + 4));
    else if (!strcmp(a->type, "timecode") && a->size == 8)
        put_timecode(w, load32(data));
    else if (!strcmp(a->type, "preview") && a->size >= 8)
        print(w, "%" PRIu32 " x %" PRIu32 " pixels", load32(data), load32(data + 4));
    else
        return put_numbers(w, a);
    return true;
}

size_t weft_image_attribute_format(const struct weft_image_attribute *attribute, char *text,
                                   size_t size)
{
    struct words w = {text, size, 0};
    if (!put_known(&w, attribute)) {
        w.length = 0;
        print(&w, "(%zu bytes of type ", attribute->size);
        put(&w, attribute->type, strlen(attribute->type));
        put(&w, ")", 1);
    }
    if (size)
        text[w.length < size ? w.length : size - 1] = '\0';
    return w.length;
}

const struct weft_image_attribute *weft_image_find(const struct weft_image *image, const char *name)
{
    for (size_t i = 0; i < image->attribute_count; i++)
        if (!strcmp(image->attributes[i].name, name))
            return &image->attributes[i];
    return NULL;
}
