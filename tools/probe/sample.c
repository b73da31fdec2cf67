// SPDX-License-Identifier: BSD-3-Clause
// The volume, and its values at the points.
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/ending.h"
#include "tools/common/report.h"
#include "tools/probe/job.h"

enum { CHUNK = 8192 };

// ---- threads ------------------------------------------------------------------------------------

struct parallel {
    atomic_size_t next;
    size_t count;
    void (*part)(void *priv, size_t i);
    void *priv;
};

static void *work(void *priv)
{
    struct parallel *p = priv;
    for (size_t i; (i = atomic_fetch_add(&p->next, 1)) < p->count;)
        p->part(p->priv, i);
    return NULL;
}

void probe_parallel(int threads, size_t count, void (*part)(void *priv, size_t i), void *priv)
{
    enum { MOST = 64 };
    struct parallel p = {.count = count, .part = part, .priv = priv};
    pthread_t thread[MOST];
    int started = 0;
    while (started < MOST && started + 1 < threads && (size_t)started + 1 < count &&
           ending_start_thread(&thread[started], work, &p))
        started++;
    work(&p);
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
}

// ---- channels -----------------------------------------------------------------------------------

struct channels {
    struct probe_job *job;
    const float *derivatives;
    int component;
};

static void compute_chunk(void *priv, size_t chunk)
{
    const struct channels *c = priv;
    struct probe_job *job = c->job;
    const struct weft_quantities *q = &job->quantities;
    const size_t all = job->table.count, from = chunk * CHUNK;
    const size_t count = from + CHUNK < all ? CHUNK : all - from;
    const float *derivative[WEFT_DERIVATIVES];
    float *channel[WEFT_QUANTITY_CHANNELS];
    for (int d = 0; d < q->derivative_count; d++)
        derivative[d] = c->derivatives + (size_t)d * all + from;
    for (int i = 0; i < q->channel_count; i++)
        channel[i] = job->channels + (size_t)(c->component * q->channel_count + i) * all + from;
    weft_quantities_compute_planes(q, &job->transform, count, derivative, channel);
}

static enum weft_result allocate(struct probe_job *job, float **derivatives)
{
    const size_t count = job->table.count + !job->table.count;
    *derivatives = calloc((size_t)job->quantities.derivative_count * count, sizeof **derivatives);
    if (!job->channels)
        job->channels = calloc((size_t)job->channel_count * count, sizeof *job->channels);
    if (*derivatives && job->channels)
        return WEFT_OK;
    report_error("not enough memory for %d channels of %zu points", job->channel_count,
                 job->table.count);
    return WEFT_ERR_MEMORY;
}

// "Y" of component X of a grid of vectors is "X", other channels "X.gradient.Y".
static void name_channels(struct probe_job *job)
{
    const struct weft_quantities *q = &job->quantities;
    job->channel_count = job->components * q->channel_count;
    for (int i = 0; i < job->channel_count; i++) {
        const char *name = q->channel[i % q->channel_count];
        const char component = "XYZ"[i / q->channel_count % 3];
        if (job->components == 1)
            snprintf(job->channel[i], sizeof job->channel[i], "%s", name);
        else if (strcmp(name, "Y") == 0)
            snprintf(job->channel[i], sizeof job->channel[i], "%c", component);
        else
            snprintf(job->channel[i], sizeof job->channel[i], "%c.%s", component, name);
    }
}

// ---- volumes ------------------------------------------------------------------------------------

static enum weft_result open_component(struct probe_job *job, int component, weft_volume **out)
{
    if (component == 0)
        return weft_volume_await(&job->opening, out);
    return weft_volume_open(weft_volume_open_params(.path = job->input, .raw = job->raw,
                                                    .grid = job->option[PROBE_GRID].text,
                                                    .component = component, .log = report_log()),
                            out);
}

static enum weft_result set_volume(struct probe_job *job, const weft_volume *volume)
{
    job->volume = *weft_volume_get_info(volume);
    job->volume.metadata = NULL; // the volume's
    job->volume.metadata_count = 0;
    job->components = job->volume.components > 1 ? job->volume.components : 1;
    name_channels(job);
    const bool world = job->option[PROBE_SPACE].integer[0] == WEFT_SPACE_WORLD;
    return weft_quantity_transform_create(
        report_log(), world ? (const double(*)[4])job->volume.index_to_world : NULL,
        &job->transform);
}

static void add_report(struct probe_job *job, int component, const struct weft_points_report *r)
{
    struct weft_points_report *sum = &job->report;
    if (component == 0) {
        *sum = *r;
        return;
    }
    sum->sort_seconds += r->sort_seconds;
    sum->read_seconds += r->read_seconds;
    sum->pass_seconds += r->pass_seconds;
    sum->bricks_read += r->bricks_read;
    sum->not_finite += r->not_finite;
    sum->exact_points += r->exact_points;
    sum->peak_bytes = sum->peak_bytes > r->peak_bytes ? sum->peak_bytes : r->peak_bytes;
}

static enum weft_result verify(struct probe_job *job, weft_points *points, int component,
                               const struct weft_points_run_params *run,
                               const struct weft_points_report *report)
{
    struct weft_verify_report own[WEFT_DERIVATIVES];
    if (!job->option[PROBE_VERIFY].given)
        return WEFT_OK;
    const enum weft_result res = weft_points_verify(
        points, run, report, weft_verify_params(.progress = report_progress("verifying")), own);
    for (int d = 0; res == WEFT_OK && d < job->quantities.derivative_count; d++) {
        if (component == 0)
            job->error[d] = own[d];
        else
            weft_verify_join(&job->error[d], &own[d]);
    }
    return res;
}

static enum weft_result run_component(struct probe_job *job, weft_volume *volume, int component)
{
    const struct option_value *o = job->option;
    weft_points *points = NULL;
    float *derivatives = NULL;
    struct weft_points_report report;
    struct weft_points_params params = {
        .volume = volume,
        .kernel = job->kernel,
        .space = (enum weft_space)o[PROBE_SPACE].integer[0],
        .derivative = job->quantities.derivative,
        .derivative_count = job->quantities.derivative_count,
        .sums = (enum weft_sums)o[PROBE_SUMS].integer[0],
        .cpu.threads = job->threads,
        .memory_bytes = (uint64_t)o[PROBE_MEMORY].integer[0],
        .log = report_log(),
    };
    enum weft_result res = weft_points_create(&params, &points);
    if (res == WEFT_OK && component == 0)
        job->info = *weft_points_get_info(points);
    if (res == WEFT_OK && !o[PROBE_EXPLAIN].given)
        res = allocate(job, &derivatives);
    struct weft_points_run_params run = {.count = job->table.count,
                                         .position = (const double(*)[3])job->table.position,
                                         .out = derivatives,
                                         .measure = o[PROBE_VERIFY].given,
                                         .progress = report_progress("sampling")};
    if (res == WEFT_OK && derivatives)
        res = weft_points_run(points, &run, &report);
    if (res == WEFT_OK && derivatives) {
        struct channels channels = {job, derivatives, component};
        add_report(job, component, &report);
        probe_parallel(job->threads, (job->table.count + CHUNK - 1) / CHUNK, compute_chunk,
                       &channels);
        res = verify(job, points, component, &run, &report);
    }
    weft_points_destroy(&points);
    free(derivatives);
    return res;
}

enum weft_result probe_sample(struct probe_job *job)
{
    enum weft_result res = WEFT_OK;
    job->components = 1;
    for (int c = 0; res == WEFT_OK && c < job->components; c++) {
        weft_volume *volume = NULL;
        report_stage("reading", job->input);
        res = open_component(job, c, &volume);
        if (res == WEFT_OK && c == 0)
            res = set_volume(job, volume);
        if (res == WEFT_OK)
            res = run_component(job, volume, c);
        weft_volume_destroy(&volume);
        if (job->option[PROBE_EXPLAIN].given)
            break;
    }
    return res;
}
