// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

int callers_lines, callers_complaints;

static void count_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    callers_lines += level <= WEFT_LOG_WARNING && message[0];
}

const struct weft_log logger = {.write = count_line};

void expect(bool good, int line, const char *what)
{
    if (good)
        return;
    callers_complaints++;
    fprintf(stderr, "    line %d: %s\n", line, what);
}

void judge(enum weft_result res, bool refused, int line, const char *what)
{
    expect(res == WEFT_OK || callers_lines > 0, line, what);
    expect(res != WEFT_OK || !refused, line, what);
    callers_lines = 0;
}

static double half(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return x >= -1.0 && x < 1.0 ? 0.25 : 0.0;
}

struct weft_kernel named(const char *text)
{
    struct weft_kernel kernel;
    if (weft_kernel_parse(NULL, text, &kernel) != WEFT_OK)
        exit(1);
    return kernel;
}

struct weft_kernel bad_kernel(int i)
{
    static struct weft_kernel_info records[BAD_KERNELS];
    struct weft_kernel_info good = {
        .name = "own", .weight = half, .radius = 1.0, .degree = -1, .continuity = -1};
    struct weft_kernel kernel = named("catmull-rom");
    struct weft_kernel_info *info = &records[i];
    *info = good;
    if (i >= 7)
        kernel = (struct weft_kernel){.info = info, .support = 1.0, .width = 2, .continuity = -1};
    switch (i) {
    case 0:
        return (struct weft_kernel){0};
    case 1:
        kernel.width = 99;
        break;
    case 2:
        kernel.width = INT_MAX;
        break;
    case 3:
        kernel.width = INT_MIN;
        break;
    case 4:
        kernel.support = NAN;
        break;
    case 5:
        kernel.support = 1e300;
        break;
    case 6:
        kernel.order = -7;
        break;
    case 7:
        *info = (struct weft_kernel_info){0};
        break;
    case 8:
        info->weight = NULL;
        break;
    case 9:
        info->name = NULL;
        break;
    case 10:
        kernel.unit_sum = true;
        break; // the sum is 1/2
    case 11:
        kernel.interpolating = true;
        break;
    case 12:
        info->degree = 1000000;
        break;
    case 13:
        info->derivation = 7;
        break;
    default:
        kernel.prefiltered = true;
    }
    return kernel;
}

weft_kernel_tiles *tiles(void)
{
    weft_kernel_tiles *set = NULL;
    const struct weft_kernel_tiles_params *p =
        weft_kernel_tiles_params(.kernel = named("catmull-rom"), .samples = 4, .log = &logger);
    if (weft_kernel_tiles_create(p, &set) != WEFT_OK)
        exit(1);
    return set;
}

const float voxels[4 * 4 * 4] = {1.0f, 2.0f, 3.0f};

weft_volume *volume(void)
{
    weft_volume *v = NULL;
    const struct weft_volume_params *p =
        weft_volume_params(.size = {4, 4, 4}, .data = voxels, .log = &logger);
    if (weft_volume_create(p, &v) != WEFT_OK)
        exit(1);
    return v;
}

weft_pass_plan *plan(int dims)
{
    weft_pass_plan *made = NULL;
    const struct weft_pass_plan_params *p =
        weft_pass_plan_params(.kernel = named("linear"), .dims = dims, .samples = 8,
                              .log = &logger);
    if (weft_pass_plan_create(p, &made) != WEFT_OK)
        exit(1);
    return made;
}

weft_context *open_context(void)
{
    weft_context *context = NULL;
    if (weft_context_create(&(struct weft_context_params){0}, &context) != WEFT_OK)
        exit(CALLERS_SKIPPED);
    weft_context_get_info(context);
    weft_context_find_function(context, NULL);
    weft_context_call(context, NULL, NULL);
    return context;
}
