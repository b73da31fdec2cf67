// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/annotation.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"

enum { INK = 40, PALE = 100, TICKS = 12, LEAST_TEXT = 11, LEAST_EMS = 26, LABEL = 32 };

// Where everything is, in pixels; an em is the height of the texts.
struct layout {
    const struct annotation *a;
    marks *list;
    int em, line, tick, thin; // line: from one base line to the next; thin: how thick lines are
    int32_t left, right, top, bottom, width, height; // width, height: of the picture
    int32_t legend_height;
};

// ---- round numbers ------------------------------------------------------------------------------

// 1, 2 or 5 times a power of 10, at least `least`.
static double round_up(double least)
{
    const double power = pow(10.0, floor(log10(least)));
    for (int i = 0; i < 3; i++)
        if (power * (double[]){1.0, 2.0, 5.0}[i] >= least * (1.0 - 1e-9))
            return power * (double[]){1.0, 2.0, 5.0}[i];
    return 10.0 * power;
}

struct ticks {
    int count;
    double value[TICKS];
    char label[TICKS][LABEL];
};

// As many digits as tell neighbours apart.
static void format(double value, double step, double largest, char out[LABEL])
{
    const int decimals = (int)fmax(0.0, -floor(log10(step) + 1e-9));
    if (fabs(value) < 1e-9 * step)
        value = 0.0;
    if (decimals <= 5 && largest < 1e6)
        snprintf(out, LABEL, "%.*f", decimals, value);
    else
        snprintf(out, LABEL, "%.*g", (int)fmin(9.0, 1.0 + fmax(0.0, ceil(log10(largest / step)))),
                 value);
}

// Round values from one number to another, `most` at most.
static void find_ticks(double from, double to, int most, struct ticks *out)
{
    const double low = fmin(from, to), high = fmax(from, to), span = high - low;
    const double largest = fmax(fabs(low), fabs(high));
    out->count = 0;
    most = most < 1 ? 1 : most > TICKS - 1 ? TICKS - 1 : most;
    if (!(span > 1e-12 * largest) || !isfinite(span)) {
        if (isfinite(low))
            snprintf(out->label[out->count], LABEL, "%.4g", low);
        out->value[0] = low;
        out->count = isfinite(low) ? 1 : 0;
        return;
    }
    const double step = round_up(span / most);
    for (double k = ceil(low / step - 1e-6); k * step <= high + 1e-6 * step && out->count < TICKS;
         k++) {
        out->value[out->count] = k * step;
        format(k * step, step, largest, out->label[out->count++]);
    }
}

static int widest(const struct layout *l, const struct ticks *ticks)
{
    int most = 0;
    for (int i = 0; i < ticks->count; i++) {
        const int width = marks_text_width(l->list, l->em, ticks->label[i]);
        most = width > most ? width : most;
    }
    return most;
}

// ---- texts --------------------------------------------------------------------------------------

// Cut where it is too long, with dots behind it.
static void put_cut(const struct layout *l, int32_t y, int size, uint8_t grey, const char *text)
{
    char cut[ANNOTATION_TEXT + 4];
    const int32_t room = l->width + l->right - l->em / 2;
    size_t length = strlen(text);
    snprintf(cut, sizeof cut, "%s", text);
    for (int width; length && (width = marks_text_width(l->list, size, cut)) > room;) {
        const size_t fits = length * (size_t)(room > 0 ? room : 0) / (size_t)width + 4;
        length = fits < length ? fits : length;
        while (--length && (text[length] & 0xc0) == 0x80) // within a character
            ;
        snprintf(cut, sizeof cut, "%.*s...", (int)length, text);
    }
    marks_add_text(l->list, l->left, y, size, grey, cut);
}

static void put_centred(const struct layout *l, int32_t x, int32_t y, uint8_t grey,
                        const char *text)
{
    marks_add_text(l->list, x - marks_text_width(l->list, l->em, text) / 2, y, l->em, grey, text);
}

// ---- edges --------------------------------------------------------------------------------------

static double place(const struct annotation_axis *axis, double value, int32_t pixels)
{
    return axis->end == axis->start ? 0.5 * pixels
                                    : pixels * (value - axis->start) / (axis->end - axis->start);
}

static void find_across(const struct layout *l, struct ticks *out)
{
    int most = l->width / (5 * l->em);
    do // until labels have room between them
        find_ticks(l->a->across.start, l->a->across.end, most, out);
    while (--most > 0 && (widest(l, out) + l->em) * out->count > l->width);
}

static void find_down(const struct layout *l, struct ticks *out)
{
    find_ticks(l->a->down.start, l->a->down.end, l->height / (3 * l->em), out);
}

static void draw_across(const struct layout *l)
{
    const int32_t edge = l->top + l->height;
    struct ticks ticks;
    if (!l->a->across.name[0])
        return;
    find_across(l, &ticks);
    for (int i = 0; i < ticks.count; i++) {
        const int32_t x =
            l->left + (int32_t)lrint(place(&l->a->across, ticks.value[i], l->width)) - l->thin / 2;
        marks_add_rectangle(l->list, x, edge + l->thin, l->thin, l->tick, INK);
        put_centred(l, x, edge + l->tick + l->line, INK, ticks.label[i]);
    }
    put_centred(l, l->left + l->width / 2, edge + l->tick + 2 * l->line, INK, l->a->across.name);
}

static void draw_down(const struct layout *l)
{
    struct ticks ticks;
    if (!l->a->down.name[0])
        return;
    find_down(l, &ticks);
    const int32_t end = l->left - l->thin - l->tick - l->em / 3;
    for (int i = 0; i < ticks.count; i++) {
        const int32_t y =
            l->top + (int32_t)lrint(place(&l->a->down, ticks.value[i], l->height)) - l->thin / 2;
        marks_add_rectangle(l->list, l->left - l->thin - l->tick, y, l->tick, l->thin, INK);
        marks_add_text(l->list, end - marks_text_width(l->list, l->em, ticks.label[i]),
                       y + (int32_t)(0.36 * l->em), l->em, INK, ticks.label[i]);
    }
    marks_add_text(l->list, l->em / 2, l->top + l->height / 2 + (int32_t)(0.36 * l->em), l->em, INK,
                   l->a->down.name);
}

// Around the picture, which need not end where white begins.
static void draw_border(const struct layout *l)
{
    const int32_t x = l->left - l->thin, y = l->top - l->thin;
    const int32_t width = l->width + 2 * l->thin, height = l->height + 2 * l->thin;
    marks_add_rectangle(l->list, x, y, width, l->thin, INK);
    marks_add_rectangle(l->list, x, y + height - l->thin, width, l->thin, INK);
    marks_add_rectangle(l->list, x, y, l->thin, height, INK);
    marks_add_rectangle(l->list, x + width - l->thin, y, l->thin, height, INK);
}

// A round length of at most a quarter of the picture, on a line of its own.
static void draw_scale(const struct layout *l)
{
    char text[LABEL + sizeof l->a->unit + 1], number[LABEL];
    if (!(l->a->length > 0.0) || !isfinite(l->a->length))
        return;
    double size = round_up(l->a->length / 10.0);
    size = 2.0 * size <= l->a->length / 4.0 ? 2.0 * size : size;
    const int32_t bar = (int32_t)lrint(size / l->a->length * l->width), x = l->left,
                  y = l->top + l->height + l->bottom - (int32_t)(0.9 * l->em);
    format(size, size, size, number);
    snprintf(text, sizeof text, "%s %s", number, l->a->unit);
    marks_add_rectangle(l->list, x, y - l->thin, bar, 2 * l->thin, INK);
    marks_add_rectangle(l->list, x, y - l->em / 3, 2 * l->thin, 2 * (l->em / 3), INK);
    marks_add_rectangle(l->list, x + bar - 2 * l->thin, y - l->em / 3, 2 * l->thin, 2 * (l->em / 3),
                        INK);
    marks_add_text(l->list, x + bar + l->em / 2, y + (int32_t)(0.36 * l->em), l->em, INK, text);
}

// ---- the legend ---------------------------------------------------------------------------------

static void find_legend(const struct layout *l, struct ticks *out)
{
    find_ticks(l->a->low, l->a->high, l->legend_height / (2 * l->em), out);
}

static void draw_legend(const struct layout *l)
{
    const int32_t x = l->left + l->width + l->em, bar = l->em + l->em / 4;
    struct ticks ticks;
    if (!l->a->colour_map)
        return;
    const struct annotation_axis axis = {.start = l->a->high, .end = l->a->low};
    find_legend(l, &ticks);
    marks_add_rectangle(l->list, x - l->thin, l->top - l->thin, bar + 2 * l->thin,
                        l->legend_height + 2 * l->thin, INK);
    marks_add_ramp(l->list, x, l->top, bar, l->legend_height, l->a->colour_map);
    for (int i = 0; i < ticks.count; i++) {
        const int32_t y =
            l->top + (int32_t)lrint(place(&axis, ticks.value[i], l->legend_height)) - l->thin / 2;
        marks_add_rectangle(l->list, x + bar, y, l->tick, l->thin, INK);
        marks_add_text(l->list, x + bar + l->tick + l->em / 3, y + (int32_t)(0.36 * l->em), l->em,
                       INK, ticks.label[i]);
    }
    // Below the numbers along the picture's lower edge.
    const int lines = l->a->across.name[0] ? 2 : 1;
    marks_add_text(l->list, x - l->thin, l->top + l->legend_height + lines * l->line + l->tick,
                   l->em, INK, l->a->quantity);
}

// ---- all ----------------------------------------------------------------------------------------

static void set_margins(struct layout *l)
{
    const struct annotation *a = l->a;
    struct ticks ticks;
    l->left = l->right = l->em;
    l->top = l->em / 2 + (a->title[0] ? (int32_t)(1.5 * l->line) : 0) +
             (a->caption[0] ? l->line : 0) + l->em / 2;
    l->bottom = a->across.name[0] ? l->tick + 2 * l->line + l->em / 2 : l->em;
    if (a->down.name[0]) {
        find_down(l, &ticks);
        l->left = l->em / 2 + marks_text_width(l->list, l->em, a->down.name) + l->em +
                  widest(l, &ticks) + l->em / 3 + l->tick + l->thin;
    }
    if (a->across.name[0]) {
        find_across(l, &ticks);
        l->right += widest(l, &ticks) / 2;
    }
    l->legend_height = l->height > 6 * l->em ? l->height : 6 * l->em;
    if (a->colour_map) {
        find_legend(l, &ticks);
        const int32_t labels = l->em + l->em / 4 + l->tick + l->em / 3 + widest(l, &ticks),
                      name = marks_text_width(l->list, l->em, a->quantity);
        const int lines = a->across.name[0] ? 3 : 2;
        const int32_t below = l->legend_height - l->height + lines * l->line + l->tick;
        l->right = l->em + (labels > name ? labels : name) + l->em;
        l->bottom = l->bottom > below ? l->bottom : below;
    }
    l->bottom += a->length > 0.0 ? l->line : 0;
    // Small pictures leave room for a title, the same for all of one size.
    const int32_t lacking = LEAST_EMS * l->em - l->left - l->width - l->right;
    l->right += lacking > 0 ? lacking : 0;
}

static void draw_texts(const struct layout *l)
{
    int32_t y = l->em / 2 + l->line;
    if (l->a->title[0])
        put_cut(l, y, (int)lrint(1.2 * l->em), INK, l->a->title);
    y += l->a->title[0] ? (int32_t)(1.3 * l->line) : 0;
    if (l->a->caption[0])
        put_cut(l, y, l->em, PALE, l->a->caption);
}

enum weft_result annotation_create(const struct annotation *annotation, int32_t width,
                                   int32_t height, marks **list, struct weft_preview_frame *frame)
{
    const enum weft_result res = marks_create(list);
    if (res != WEFT_OK)
        return res;
    const int em = (int)lrint(sqrt((double)width * height) / 60.0);
    struct layout l = {.a = annotation, .list = *list, .width = width, .height = height};
    l.em = em > LEAST_TEXT ? em : LEAST_TEXT;
    l.line = (int)lrint(1.35 * l.em);
    l.tick = l.em / 3;
    l.thin = 1 + l.em / 24;
    set_margins(&l);
    marks_set_width(l.list, l.left + l.width + l.right);
    draw_border(&l);
    draw_across(&l);
    draw_down(&l);
    draw_legend(&l);
    draw_scale(&l);
    draw_texts(&l);
    *frame = (struct weft_preview_frame){.left = l.left,
                                         .right = l.right,
                                         .top = l.top,
                                         .bottom = l.bottom,
                                         .draw = marks_draw,
                                         .priv = l.list};
    if (marks_are_whole(l.list))
        return WEFT_OK;
    marks_destroy(list);
    report_error("out of memory for what is around a picture of %d x %d pixels", width, height);
    return WEFT_ERR_MEMORY;
}
