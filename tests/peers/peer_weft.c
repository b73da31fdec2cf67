// SPDX-License-Identifier: BSD-3-Clause
// weft itself, run as the peers are: peer_weft KERNEL CONTEXT. The volume is in memory and the plan
// made before; a run is weft_slice_run, from voxels to pixels, and its PART the rendering passes.
#include "weft.h"

#include "tests/peers/peer.h"

struct state {
    struct peer_job job;
    weft_context *context;
    weft_volume *volume;
    weft_slice_plan *plan;
};

static void to_stderr(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "peer_weft: %s\n", message);
}

static const struct weft_log console = {to_stderr, NULL};

static double run(void *priv)
{
    struct state *s = priv;
    struct weft_slice_report report;
    if (weft_slice_run_once(s->plan, weft_slice_compile_params(.context = s->context),
                            weft_slice_run_params(.pixels = s->job.pixels), &report) != WEFT_OK)
        exit(1);
    return report.pass_seconds;
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

static enum weft_result prepare(struct state *s, const char *kernel, const char *kind)
{
    struct weft_context_params context = {.log = &console};
    struct weft_slice_params slice = {
        .space = WEFT_SPACE_INDEX, .geometry = geometry(&s->job), .log = &console};
    enum weft_result res = weft_context_kind_parse(&console, kind, &context.kind);
    if (res == WEFT_OK)
        res = weft_kernel_parse(&console, kernel, &slice.kernel);
    if (res == WEFT_OK)
        res = weft_context_create(&context, &s->context);
    if (res == WEFT_OK)
        res = weft_volume_create(
            weft_volume_params(.size = {s->job.size[0], s->job.size[1], s->job.size[2]},
                               .data = s->job.box, .log = &console),
            &s->volume);
    if (res == WEFT_OK) {
        const struct weft_context_info *info = weft_context_get_info(s->context);
        slice.max_target_size = info->max_target_size;
        slice.max_buffer_texels = info->max_buffer_texels;
        res = weft_slice_plan_create(s->volume, &slice, &s->plan);
    }
    return res;
}

int main(int argc, char **argv)
{
    static struct state s;
    char threads[16], version[512];
    if (argc != 3)
        return 2;
    peer_load(&s.job);
    // llvmpipe's threads; a hardware context takes no notice.
    snprintf(threads, sizeof threads, "%d", s.job.threads);
    setenv("LP_NUM_THREADS", threads, 1);
    enum weft_result res = prepare(&s, argv[1], argv[2]);
    if (res != WEFT_OK)
        peer_skip(weft_result_text(res));
    free(s.job.box);
    s.job.box = NULL;
    const struct weft_context_info *info = weft_context_get_info(s.context);
    snprintf(version, sizeof version, "weft %s on %s, %s, %s layout", weft_version(),
             info->platform, info->renderer,
             weft_layout_name(weft_slice_plan_get_info(s.plan)->layout));
    int code = peer_serve(&s.job, version, run, &s);
    weft_slice_plan_destroy(&s.plan);
    weft_volume_destroy(&s.volume);
    weft_context_destroy(&s.context);
    return code;
}
