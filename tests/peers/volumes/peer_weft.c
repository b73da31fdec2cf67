// SPDX-License-Identifier: BSD-3-Clause
// weft itself, run as the peers are: peer_weft KERNEL gl|hardware|float|double CONTEXT: by OpenGL,
// by its texture sampler, or the CPU engine with these sums. The volume is resident, but for the
// sampler, whose texture stays with a compiled plan; a run plans a plane, compiles the plan and
// runs it, and its PART is running one that was compiled before.
#include "weft.h"

#include "tests/peers/volumes/peer.h"

struct state {
    struct peer_job job;
    weft_context *context;
    weft_volume *volume;
    weft_resident *resident;
    struct weft_slice_params params;
    struct weft_cpu cpu;
    weft_slice_plan *plan;
    bool by_sampler;
    weft_hardware_plan *hardware; // NULL but by the sampler
    weft_slice *slice;
};

static void to_stderr(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "peer_weft: %s\n", message);
}

static const struct weft_log console = {to_stderr, NULL};

static const struct weft_derivative all[10] = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}},
                                               {{2, 0, 0}}, {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}},
                                               {{0, 1, 1}}, {{0, 0, 2}}};

static void destroy_plans(struct state *s)
{
    weft_slice_destroy(&s->slice);
    weft_hardware_plan_destroy(&s->hardware);
    weft_slice_plan_destroy(&s->plan);
}

static enum weft_result plan_hardware(struct state *s)
{
    struct weft_hardware_params params = {.slice = s->plan, .log = &console};
    if (!s->by_sampler)
        return WEFT_OK;
    const enum weft_result res =
        weft_sampler_measure(s->context, WEFT_SOURCE_FLOAT, &params.sampler);
    return res == WEFT_OK ? weft_hardware_plan_create(&params, &s->hardware) : res;
}

static void run_new(void *priv)
{
    struct state *s = priv;
    destroy_plans(s);
    if (weft_slice_plan_create(s->volume, &s->params, &s->plan) != WEFT_OK ||
        plan_hardware(s) != WEFT_OK ||
        weft_slice_compile(s->plan,
                           weft_slice_compile_params(.context = s->context, .cpu = s->cpu,
                                                     .hardware = s->hardware),
                           &s->slice) != WEFT_OK ||
        weft_slice_run(s->slice, weft_slice_run_params(.pixels = s->job.pixels), NULL) != WEFT_OK)
        exit(1);
}

static void run_compiled(void *priv)
{
    struct state *s = priv;
    if (weft_slice_run(s->slice, weft_slice_run_params(.pixels = s->job.pixels), NULL) != WEFT_OK)
        exit(1);
}

static struct weft_slice_geometry geometry(const struct peer_job *job)
{
    struct weft_slice_geometry g = {.width = job->width, .height = job->height};
    for (int a = 0; a < 3; a++) {
        g.u[a] = job->width * job->du[a];
        g.v[a] = job->height * job->dv[a];
        g.origin[a] = job->origin[a] - 0.5 * job->du[a] - 0.5 * job->dv[a];
    }
    return g;
}

static enum weft_result create_context(struct state *s, const char *kind)
{
    struct weft_context_params params = {.log = &console};
    enum weft_result res = weft_context_kind_parse(&console, kind, &params.kind);
    if (res == WEFT_OK)
        res = weft_context_create(&params, &s->context);
    if (res != WEFT_OK)
        return res;
    const struct weft_context_info *info = weft_context_get_info(s->context);
    s->params.max_target_size = info->max_target_size;
    s->params.max_buffer_texels = info->max_buffer_texels;
    return res;
}

static enum weft_result prepare(struct state *s, const char *kernel, const char *how,
                                const char *kind)
{
    s->by_sampler = strcmp(how, "hardware") == 0;
    const bool gl = strcmp(how, "gl") == 0 || s->by_sampler;
    s->params = (struct weft_slice_params){
        .space = WEFT_SPACE_INDEX,
        .geometry = geometry(&s->job),
        .engine = gl ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU,
        .sums = strcmp(how, "double") == 0 ? WEFT_SUMS_DOUBLE : WEFT_SUMS_FLOAT,
        .log = &console,
    };
    if (s->job.outputs > 1) {
        s->params.derivative = all;
        s->params.derivative_count = s->job.outputs;
    }
    if (s->by_sampler)
        s->params.without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE;
    s->cpu.threads = s->job.threads;
    enum weft_result res = gl ? create_context(s, kind) : WEFT_OK;
    if (res == WEFT_OK)
        res = weft_kernel_parse(&console, kernel, &s->params.kernel);
    if (res == WEFT_OK)
        res = weft_volume_create(
            weft_volume_params(.size = {s->job.size[0], s->job.size[1], s->job.size[2]},
                               .data = s->job.box, .log = &console),
            &s->volume);
    if (res == WEFT_OK && !s->by_sampler)
        res =
            weft_resident_create(weft_resident_params(.volume = s->volume, .context = s->context,
                                                      .kernel = s->params.kernel, .log = &console),
                                 &s->resident);
    s->params.resident = s->resident;
    return res;
}

static void print_version(const struct state *s, char *out, size_t size)
{
    if (!s->context) {
        snprintf(out, size, "weft %s on the CPU, %s", weft_version(),
                 weft_instruction_set_names[weft_instruction_set_best()]);
        return;
    }
    const struct weft_context_info *info = weft_context_get_info(s->context);
    snprintf(out, size, "weft %s on %s, %s", weft_version(), info->platform, info->renderer);
}

int main(int argc, char **argv)
{
    static struct state s;
    char threads[16], version[512];
    if (argc != 4)
        return 2;
    peer_load(&s.job);
    // llvmpipe's threads; a hardware context takes no notice.
    snprintf(threads, sizeof threads, "%d", s.job.threads);
    setenv("LP_NUM_THREADS", threads, 1);
    enum weft_result res = prepare(&s, argv[1], argv[2], argv[3]);
    if (res != WEFT_OK)
        peer_skip(weft_result_text(res));
    free(s.job.box);
    s.job.box = NULL;
    print_version(&s, version, sizeof version);
    int code = peer_serve(&s.job, version, run_new, run_compiled, &s);
    destroy_plans(&s);
    weft_resident_destroy(&s.resident);
    weft_volume_destroy(&s.volume);
    weft_context_destroy(&s.context);
    return code;
}
