// SPDX-License-Identifier: BSD-3-Clause
// JSON to plans. Every number has its range here: what comes out can be computed with as it is.
#include "tools/plan_json/plan_json.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/options/kernels.h"
#include "tools/common/report.h"

enum {
    MAX_PASSES = 65536,
    MAX_SLOTS = 256,
    MAX_SPLITS = 4096,
    MAX_SHIFT = 16,
    MAX_OFFSET = 64,
    MAX_BITS = 24,
    MAX_FACTOR = 1 << 30,
};
static const uint64_t default_memory = UINT64_C(1) << 30;

// ---- values -------------------------------------------------------------------------------------

// The first tile of each part that a tap has; -1: none.
struct tap_tiles {
    int first[3];
};

// The first thing that is wrong ends it: every reader after that returns something in range.
struct reader {
    const char *path;
    char at[96]; // "passes[3]."
    uint64_t memory_bytes;
    enum weft_result res;
    struct plan_file *out;
    struct tap_tiles *taps; // width^dims
    int *next;              // the next piece of each tile; -1: none
};

static bool good(const struct reader *r)
{
    return r->res == WEFT_OK;
}

// In file terms: names and parameters that the library refuses are the file's fault.
static void fail(struct reader *r, enum weft_result res)
{
    if (good(r))
        r->res = res == WEFT_ERR_ARGUMENT ? WEFT_ERR_FORMAT : res;
}

__attribute__((format(printf, 3, 4))) static void refuse(struct reader *r, const char *key,
                                                         const char *format, ...)
{
    char text[256];
    if (!good(r))
        return;
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    report_error("%s: %s%s %s", r->path, r->at, key, text);
    r->res = WEFT_ERR_FORMAT;
}

static void locate(struct reader *r, const char *format, int a, int b)
{
    snprintf(r->at, sizeof r->at, format, a, b);
}

static const json_t *member(struct reader *r, const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        refuse(r, key, "is missing");
    return good(r) ? value : NULL;
}

static int check_integer(struct reader *r, const json_t *value, const char *key, int low, int high)
{
    if (json_is_integer(value) && json_integer_value(value) >= low &&
        json_integer_value(value) <= high)
        return (int)json_integer_value(value);
    refuse(r, key, "is not a whole number from %d to %d", low, high);
    return low;
}

static int read_integer(struct reader *r, const json_t *object, const char *key, int low, int high)
{
    const json_t *value = member(r, object, key);
    return value ? check_integer(r, value, key, low, high) : low;
}

// null stands for `none`, where that is allowed (not NULL).
static double read_number(struct reader *r, const json_t *object, const char *key, double low,
                          double high, const double *none)
{
    const json_t *value = member(r, object, key);
    if (!value || (none && json_is_null(value)))
        return none ? *none : low;
    const double number = json_number_value(value);
    if (json_is_number(value) && number >= low && number <= high)
        return number;
    refuse(r, key, "is not a number from %g to %g%s", low, high, none ? ", or null" : "");
    return low;
}

static bool read_flag(struct reader *r, const json_t *object, const char *key)
{
    const json_t *value = member(r, object, key);
    if (value && !json_is_boolean(value))
        refuse(r, key, "is neither true nor false");
    return json_is_true(value);
}

// Where it is in the list of words.
static int read_word(struct reader *r, const json_t *object, const char *key,
                     const char *const *words)
{
    const json_t *value = member(r, object, key);
    char list[160] = "";
    for (int i = 0; words[i]; i++) {
        if (value && json_is_string(value) && strcmp(json_string_value(value), words[i]) == 0)
            return i;
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
    }
    refuse(r, key, "is not one of: %s", list);
    return 0;
}

static const char *read_text(struct reader *r, const json_t *object, const char *key, size_t size)
{
    const json_t *value = member(r, object, key);
    if (value && json_is_string(value) && json_string_length(value) < size)
        return json_string_value(value);
    refuse(r, key, "is not a text of at most %zu bytes", size - 1);
    return "";
}

// An array of `least` to `most` entries; NULL: it is not.
static const json_t *read_array(struct reader *r, const json_t *object, const char *key, int least,
                                int most, int *count)
{
    const json_t *value = member(r, object, key);
    const size_t size = json_array_size(value);
    *count = 0;
    if (!value || !json_is_array(value) || size < (size_t)least || size > (size_t)most) {
        refuse(r, key, "is not a list of %d to %d entries", least, most);
        return NULL;
    }
    *count = (int)size;
    return value;
}

static void check_integers(struct reader *r, const json_t *array, const char *key, int count,
                           int low, int high, int *out)
{
    if (json_array_size(array) != (size_t)count)
        refuse(r, key, "is not a list of %d whole numbers", count);
    for (int i = 0; i < count && good(r); i++)
        out[i] = check_integer(r, json_array_get(array, (size_t)i), key, low, high);
}

// ---- profile and tiles --------------------------------------------------------------------------

// A profile is its name; what else is said of it is compared with that later.
static void read_profile(struct reader *r, const json_t *root)
{
    const json_t *from = member(r, root, "profile");
    locate(r, "profile.", 0, 0);
    const char *name = read_text(r, from, "name", sizeof r->out->profile.name);
    if (good(r))
        fail(r, weft_profile_parse(report_log(), name, &r->out->profile));
    locate(r, "", 0, 0);
}

static void read_name(struct reader *r, const json_t *from, struct weft_tile_name *name)
{
    const int dims = r->out->list.dims;
    *name = (struct weft_tile_name){0};
    check_integers(r, member(r, from, "tap"), "tap", dims, 0, WEFT_KERNEL_MAX_WIDTH - 1, name->tap);
    name->part = (enum weft_tile_part)read_word(r, from, "part", weft_tile_part_names);
    name->piece = read_integer(r, from, "piece", 0, MAX_SPLITS);
}

static int tap_number(const struct reader *r, const int tap[3])
{
    const int width = weft_kernel_tiles_get_info(r->out->tiles)->width;
    int number = 0;
    for (int a = r->out->list.dims - 1; a >= 0; a--) {
        if (tap[a] >= width)
            return -1;
        number = number * width + tap[a];
    }
    return number;
}

static int find_tile(struct reader *r, const struct weft_tile_name *name)
{
    char text[WEFT_TILE_NAME_TEXT];
    const int number = tap_number(r, name->tap);
    int tile = number < 0 ? -1 : r->taps[number].first[name->part];
    for (int piece = 0; piece < name->piece && tile >= 0; piece++)
        tile = r->next[tile];
    if (tile < 0)
        refuse(r, "tap", "and part and piece %s are no tile of the set",
               weft_tile_name_format(name, r->out->list.dims, text));
    return tile;
}

// Appends a tile to those that its tap and part have.
static void enter_tile(struct reader *r, int tile)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(r->out->tiles, tile);
    int *link = &r->taps[tap_number(r, t->tap)].first[t->part];
    while (*link >= 0)
        link = &r->next[*link];
    *link = tile;
    r->next[tile] = -1;
}

static void index_tiles(struct reader *r, int split_count)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(r->out->tiles);
    int taps = 1;
    for (int a = 0; a < info->dims; a++)
        taps *= info->width;
    r->taps = malloc((size_t)taps * sizeof *r->taps);
    r->next = malloc(((size_t)info->tile_count + (size_t)split_count + 1) * sizeof *r->next);
    if (!r->taps || !r->next) {
        report_error("out of memory for an index of %d tiles", info->tile_count);
        fail(r, WEFT_ERR_MEMORY);
        return;
    }
    for (int i = 0; i < taps; i++)
        for (int part = 0; part < 3; part++)
            r->taps[i].first[part] = -1;
    for (int i = 0; i < info->tile_count; i++)
        enter_tile(r, i);
}

static void split_tiles(struct reader *r, const json_t *from)
{
    static const double middle = (double)NAN;
    int count;
    const json_t *splits = read_array(r, from, "splits", 0, MAX_SPLITS, &count);
    if (good(r))
        index_tiles(r, count);
    r->out->params.splits = r->out->splits = calloc((size_t)count + 1, sizeof *r->out->splits);
    if (!r->out->splits)
        fail(r, WEFT_ERR_MEMORY);
    for (int i = 0; i < count && good(r); i++) {
        const json_t *split = json_array_get(splits, (size_t)i);
        struct weft_tile_name name;
        locate(r, "tile_set.splits[%d].", i, 0);
        read_name(r, split, &name);
        const double threshold = read_number(r, split, "threshold", -1e6, 1e6, &middle);
        const int tile = good(r) ? find_tile(r, &name) : -1;
        if (tile < 0)
            return;
        fail(r, weft_kernel_tiles_split(r->out->tiles, tile, threshold));
        r->out->splits[i] = (struct weft_pass_plan_split){name, threshold};
        r->out->params.split_count = (size_t)i + 1;
        if (good(r))
            enter_tile(r, weft_kernel_tiles_get_info(r->out->tiles)->tile_count - 1);
    }
}

static void read_tile_params(struct reader *r, const json_t *root, const json_t *from,
                             struct weft_kernel_tiles_params *p)
{
    static const double unlimited = 0.0;
    p->dims = r->out->list.dims;
    p->samples = read_integer(r, root, "resolution", 1, WEFT_TILES_MAX_SAMPLES);
    const char *along = read_text(r, root, "derivative", WEFT_DERIVATIVE_TEXT);
    if (good(r) && weft_derivative_parse(NULL, along, &p->derivative) != WEFT_OK)
        refuse(r, "derivative", "is not one of: none, x, y, z, xx, xy, xz, yy, yz, zz");
    locate(r, "tile_set.", 0, 0);
    p->format = (enum weft_tile_format)read_word(r, from, "format", weft_tile_format_names);
    p->bits = read_integer(r, from, "bits", 0, 32);
    p->rounding = (enum weft_tile_rounding)read_word(r, from, "rounding", weft_tile_rounding_names);
    p->placement =
        (enum weft_tile_placement)read_word(r, from, "placement", weft_tile_placement_names);
    p->signs = (enum weft_tile_signs)read_word(r, from, "signs", weft_tile_signs_names);
    p->scaling = (enum weft_tile_scaling)read_word(r, from, "scaling", weft_tile_scaling_names);
    p->exact_scale = read_flag(r, from, "exact_scale");
    p->max_scale = read_number(r, from, "max_scale", 0.0, 1e9, &unlimited);
    p->store_all = !read_flag(r, from, "mirror");
    p->normalise = read_flag(r, from, "normalise");
    p->memory_bytes = r->memory_bytes;
    p->log = report_log();
}

// A plan for unorm targets has unorm tiles (or floats, as logarithms), one for the others those.
static void check_tile_format(struct reader *r, enum weft_tile_format format, bool logarithms)
{
    const enum weft_target_format target = r->out->list.target;
    const bool real = target == WEFT_TARGET_HALF || target == WEFT_TARGET_FLOAT;
    const bool real_tiles = format == WEFT_TILE_HALF || format == WEFT_TILE_FLOAT;
    if (format == WEFT_TILE_SNORM || (real && logarithms) || (real_tiles != (real || logarithms)))
        refuse(r, "format", "is not what a %s target%s takes", weft_target_name(target),
               logarithms ? " with logarithms" : "");
}

static void read_tile_set(struct reader *r, const json_t *root)
{
    struct weft_kernel_tiles_params params = {0};
    const json_t *from = member(r, root, "tile_set");
    const char *kernel = read_text(r, root, "kernel", KERNELS_TEXT);
    weft_kernel_file *none = NULL;
    if (strncmp(kernel, "table:", 6) == 0)
        refuse(r, "kernel", "is a table in a file; a plan that is read names none");
    read_tile_params(r, root, from, &params);
    check_tile_format(r, params.format, r->out->log_table);
    if (good(r))
        fail(r, kernels_load(kernel, &params.kernel, &none));
    if (good(r))
        fail(r, weft_kernel_tiles_create(&params, &r->out->tiles));
    if (good(r))
        split_tiles(r, from);
    r->out->params.kernel = params.kernel;
    r->out->params.samples = params.samples;
    r->out->params.derivative = params.derivative;
    r->out->params.round_singly = params.rounding == WEFT_TILE_NEAREST;
    locate(r, "", 0, 0);
}

// ---- targets ------------------------------------------------------------------------------------

static void read_log_table(struct reader *r, const json_t *from)
{
    struct weft_pass_list *list = &r->out->list;
    const json_t *value = member(r, from, "log_table");
    if (!value || json_is_null(value))
        return;
    const int bits = weft_target_bits(list->target), size = 2 * weft_target_one(list->target) + 1;
    if (!bits || json_array_size(value) != (size_t)size) {
        refuse(r, "log_table", "is not a list of %d entries", bits ? size : 0);
        return;
    }
    list->log_octaves = read_number(r, from, "log_octaves", 1.0 / 64, 64.0, NULL);
    list->log_table = r->out->log_table = calloc((size_t)size, sizeof *r->out->log_table);
    if (!list->log_table) {
        report_error("out of memory for %d logarithms", size);
        fail(r, WEFT_ERR_MEMORY);
    }
    for (int i = 0; i < size && good(r); i++)
        r->out->log_table[i] = (uint32_t)check_integer(r, json_array_get(value, (size_t)i),
                                                       "log_table", 0, MAX_FACTOR);
}

static void read_pattern(struct reader *r, const json_t *from)
{
    struct weft_pass_list *list = &r->out->list;
    int count;
    const json_t *pattern =
        read_array(r, from, "pattern", list->dot4 ? 4 : 0, list->dot4 ? 4 : 0, &count);
    for (int c = 0; c < count && good(r); c++)
        check_integers(r, json_array_get(pattern, (size_t)c), "pattern", list->dims, -MAX_OFFSET,
                       MAX_OFFSET, list->pattern[c]);
}

// Of sums inside, by profile and technique (split precision: at most).
static int extra_bits_of(const struct reader *r)
{
    enum { SPLIT_BITS = 8, LOG_BITS = 8 };
    const struct weft_profile *p = &r->out->profile;
    if (p->internal_bits)
        return p->internal_bits - weft_target_bits(p->target);
    return r->out->params.technique == WEFT_TECHNIQUE_SPLIT_PRECISION ? SPLIT_BITS
           : r->out->params.technique == WEFT_TECHNIQUE_LOG           ? LOG_BITS
                                                                      : 0;
}

static void read_targets(struct reader *r, const json_t *root)
{
    static const double never = (double)INFINITY;
    struct weft_pass_list *list = &r->out->list;
    const json_t *from = member(r, root, "targets");
    locate(r, "targets.", 0, 0);
    list->target = (enum weft_target_format)read_word(r, from, "target", weft_target_names);
    if (list->target != r->out->profile.target)
        refuse(r, "target", "is not the profile's, %s", weft_target_name(r->out->profile.target));
    const struct weft_profile *profile = &r->out->profile;
    const bool split = r->out->params.technique == WEFT_TECHNIQUE_SPLIT_PRECISION;
    const int extra = extra_bits_of(r);
    list->dot4 = read_flag(r, from, "dot4");
    list->dot_width = read_integer(r, from, "dot_width", 1, 4);
    read_pattern(r, from);
    list->exact_inside = read_flag(r, from, "exact_inside");
    list->extra_bits = read_integer(r, from, "extra_bits", 0, MAX_BITS);
    list->range = read_number(r, from, "range", 1.0, 1024.0, &never);
    list->slot_count = read_integer(r, from, "slots", 1, MAX_SLOTS);
    list->scratch_count = read_integer(r, from, "scratch", 0, MAX_SLOTS);
    if (list->exact_inside != (profile->internal_bits == 0))
        refuse(r, "exact_inside", "is %s, with %d bits inside",
               list->exact_inside ? "true" : "false", profile->internal_bits);
    if (list->dot_width != profile->dot_width)
        refuse(r, "dot_width", "is %d, not %d", list->dot_width, profile->dot_width);
    if (list->range != profile->internal_range)
        refuse(r, "range", "is %g, not %g", list->range, profile->internal_range);
    if (split ? list->extra_bits > extra : list->extra_bits != extra)
        refuse(r, "extra_bits", "is %d, not %s%d", list->extra_bits, split ? "up to " : "", extra);
    list->result = read_integer(r, from, "result", 0, list->slot_count - 1);
    list->result_scale = read_number(r, from, "result_scale", 1e-9, 1e9, NULL);
    list->result_bias = read_number(r, from, "result_bias", -1e9, 1e9, NULL);
    read_log_table(r, from);
    locate(r, "", 0, 0);
}

// ---- passes -------------------------------------------------------------------------------------

// A tap is applied to its own sample, or what the tiles say is not what is computed.
static void check_sample(struct reader *r, const struct weft_tap_group *group, int component)
{
    const struct weft_pass_list *list = &r->out->list;
    const struct weft_tile_name name =
        weft_tile_name_of(r->out->tiles, group->tile[component], false);
    char text[WEFT_TILE_NAME_TEXT];
    for (int a = 0; a < list->dims; a++)
        if (group->offset[a] + list->pattern[component][a] != name.tap[a])
            refuse(r, "offset", "is not where tap %s has its sample",
                   weft_tile_name_format(&name, list->dims, text));
}

static void read_tap(struct reader *r, const json_t *from, struct weft_tap_group *group,
                     int component)
{
    struct weft_tile_name name;
    group->tile[component] = -1;
    if (json_is_null(from))
        return;
    read_name(r, from, &name);
    group->sign[component] = read_integer(r, from, "sign", -1, 1);
    group->shift[component] = read_integer(r, from, "shift", 0, MAX_SHIFT);
    if (good(r) && group->shift[component] && r->out->list.log_table)
        refuse(r, "shift", "is %d, not 0, of a logarithm", group->shift[component]);
    if (good(r) && group->sign[component] == 0)
        refuse(r, "sign", "is neither 1 nor -1");
    if (good(r))
        group->tile[component] = find_tile(r, &name);
    if (good(r))
        check_sample(r, group, component);
}

static void read_group(struct reader *r, const json_t *from, struct weft_tap_group *group)
{
    const struct weft_pass_list *list = &r->out->list;
    const int components = list->dot4 ? 4 : 1;
    int count;
    *group = (struct weft_tap_group){.tile = {-1, -1, -1, -1}};
    check_integers(r, member(r, from, "offset"), "offset", list->dims, -MAX_OFFSET, MAX_OFFSET,
                   group->offset);
    const json_t *taps = read_array(r, from, "taps", components, components, &count);
    for (int c = 0; c < count && good(r); c++)
        read_tap(r, json_array_get(taps, (size_t)c), group, c);
}

static void read_taps(struct reader *r, const json_t *from, int number, struct weft_pass *pass)
{
    struct weft_pass_list *list = &r->out->list;
    const int most = r->out->profile.taps_per_pass;
    pass->initial = read_integer(r, from, "initial", 0, 65535);
    pass->part = (enum weft_pass_part)read_word(r, from, "part", weft_pass_part_names);
    pass->subtract = read_flag(r, from, "subtract");
    pass->reads_target = read_flag(r, from, "ping_pong");
    pass->bias = read_integer(r, from, "bias", -MAX_FACTOR, MAX_FACTOR);
    pass->divisor = read_integer(r, from, "divisor", 1, INT_MAX);
    if (pass->initial && !pass->clears)
        refuse(r, "initial", "is %d, not 0, of a pass that clears nothing", pass->initial);
    pass->group_first = list->group_count;
    if (pass->reads_target && !r->out->profile.ping_pong)
        refuse(r, "ping_pong", "is true, but the profile has none");
    const json_t *groups = read_array(r, from, "groups", 0, most, &pass->group_count);
    for (int i = 0; i < pass->group_count && good(r); i++) {
        locate(r, "passes[%d].groups[%d].", number, i);
        read_group(r, json_array_get(groups, (size_t)i), &r->out->groups[list->group_count++]);
    }
}

static void read_inputs(struct reader *r, const json_t *from, int number, struct weft_pass *pass)
{
    const int last = r->out->list.slot_count - 1;
    pass->bias = read_integer(r, from, "bias", -MAX_FACTOR, MAX_FACTOR);
    pass->denominator = read_integer(r, from, "denominator", 1, INT_MAX);
    if (!pass->clears)
        refuse(r, "clears", "is false, not true, of a pass that combines");
    const json_t *inputs =
        read_array(r, from, "inputs", 1, WEFT_PASS_MAX_INPUTS, &pass->input_count);
    for (int i = 0; i < pass->input_count && good(r); i++) {
        const json_t *input = json_array_get(inputs, (size_t)i);
        locate(r, "passes[%d].inputs[%d].", number, i);
        pass->input[i] = read_integer(r, input, "slot", 0, last);
        pass->numerator[i] = read_integer(r, input, "numerator", -MAX_FACTOR, MAX_FACTOR);
    }
}

static void read_pass(struct reader *r, const json_t *from, int number, struct weft_pass *pass)
{
    locate(r, "passes[%d].", number, 0);
    pass->kind = (enum weft_pass_kind)read_word(r, from, "kind", weft_pass_kind_names);
    pass->target = read_integer(r, from, "slot", 0, r->out->list.slot_count - 1);
    pass->clears = read_flag(r, from, "clears");
    if (pass->kind == WEFT_PASS_TAPS)
        read_taps(r, from, number, pass);
    else
        read_inputs(r, from, number, pass);
}

static void read_passes(struct reader *r, const json_t *root)
{
    struct weft_pass_list *list = &r->out->list;
    size_t groups = 0;
    const json_t *passes = read_array(r, root, "passes", 1, MAX_PASSES, &list->pass_count);
    for (int i = 0; i < list->pass_count; i++)
        groups += json_array_size(json_object_get(json_array_get(passes, (size_t)i), "groups"));
    if (!good(r))
        return;
    list->groups = r->out->groups = calloc(groups + 1, sizeof *r->out->groups);
    list->passes = r->out->passes = calloc((size_t)list->pass_count, sizeof *r->out->passes);
    if (!list->groups || !list->passes) {
        report_error("out of memory for %d passes", list->pass_count);
        fail(r, WEFT_ERR_MEMORY);
    }
    for (int i = 0; i < list->pass_count && good(r); i++)
        read_pass(r, json_array_get(passes, (size_t)i), i, &r->out->passes[i]);
}

// ---- the plan -----------------------------------------------------------------------------------

static void read_plan(struct reader *r, const json_t *root)
{
    static const char *const formats[] = {"weft-plan", NULL};
    struct plan_file *out = r->out;
    if (!json_is_object(root))
        refuse(r, "", "is JSON, but no plan");
    read_word(r, root, "format", formats);
    read_integer(r, root, "version", 1, 1);
    out->params.dims = out->list.dims = read_integer(r, root, "dims", 2, 3);
    out->params.technique =
        (enum weft_technique)read_word(r, root, "technique", weft_technique_names);
    out->params.order = (enum weft_order)read_word(r, root, "order", weft_order_names);
    out->params.channels = read_integer(r, root, "channels", 1, 4);
    out->params.bits = read_integer(r, root, "bits", 4, 16);
    out->params.memory_bytes = r->memory_bytes;
    out->params.log = report_log();
    out->worst_case = (enum weft_worst_case)read_word(r, root, "worst_case", weft_worst_case_names);
    if (good(r))
        read_profile(r, root);
    if (good(r))
        read_targets(r, root);
    if (good(r))
        read_tile_set(r, root);
    if (good(r))
        read_passes(r, root);
    out->list.tiles = out->tiles;
    out->params.profile = out->profile;
    out->params.worst_case = out->worst_case;
}

enum weft_result plan_file_load(const char *path, uint64_t memory_bytes, struct plan_file *out)
{
    *out = (struct plan_file){0};
    json_t *root = NULL;
    struct reader r = {.path = strcmp(path, "-") == 0 ? "standard input" : path,
                       .memory_bytes = memory_bytes ? memory_bytes : default_memory,
                       .out = out};
    r.res = plan_json_load(path, r.memory_bytes, &root);
    if (good(&r))
        read_plan(&r, root);
    out->root = root;
    free(r.taps);
    free(r.next);
    if (!good(&r))
        plan_file_clear(out);
    return r.res;
}

void plan_file_clear(struct plan_file *file)
{
    weft_kernel_tiles_destroy(&file->tiles);
    json_decref(file->root);
    free(file->splits);
    free(file->groups);
    free(file->passes);
    free(file->log_table);
    *file = (struct plan_file){0};
}
