// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/multipass/job.h"

// Pixels that go through a pass together: loops over them are inside, and what they touch is small.
enum { CHUNK = 2048 };

struct emulator {
    const struct weft_multipass_job *job;
    const struct weft_multipass *m; // the job's
    const struct weft_pass_list *passes;
    const struct weft_progress *progress;
    int channels;
    size_t first, count; // the chunk's pixels
    // The slots' values, channel by channel.
    int32_t *codes;
    float *floats;
    uint64_t clamps;
    int64_t largest_clamp;
    // Of the chunk: places of samples and weights, and what is there.
    uint32_t sample_at[CHUNK], weight_at[CHUNK];
    int32_t samples[CHUNK], weights[CHUNK], sums[CHUNK];
    float float_samples[CHUNK], float_weights[CHUNK], float_sums[CHUNK];
};

static size_t slot_start(const struct emulator *e, int slot, int channel)
{
    return ((size_t)slot * (size_t)e->channels + (size_t)channel) * e->job->pixels + e->first;
}

static int32_t *slot_codes(const struct emulator *e, int slot, int channel)
{
    return e->codes + slot_start(e, slot, channel);
}

static float *slot_floats(const struct emulator *e, int slot, int channel)
{
    return e->floats + slot_start(e, slot, channel);
}

// ---- fetches ------------------------------------------------------------------------------------

static void locate(struct emulator *e, int group)
{
    const struct weft_job_group *g = &e->m->groups[group];
    const struct weft_job_entry *entries = e->job->entries + e->first;
    const uint32_t offset = (uint32_t)e->job->source_offset[group];
    for (size_t i = 0; i < e->count; i++)
        e->sample_at[i] = entries[i].texel + offset;
    for (size_t i = 0; i < e->count; i++)
        e->weight_at[i] = (uint32_t)weft_job_tile_texel(e->m, g, entries[i].position);
}

static void fetch(const struct weft_job_values *values, int component, const uint32_t *at,
                  size_t count, int32_t *out)
{
    const size_t n = (size_t)values->components, c = (size_t)component;
    const uint8_t *bytes = values->data;
    const uint16_t *words = values->data;
    if (values->type == WEFT_VALUE_UINT8)
        for (size_t i = 0; i < count; i++)
            out[i] = bytes[at[i] * n + c];
    else
        for (size_t i = 0; i < count; i++)
            out[i] = words[at[i] * n + c];
}

static void fetch_floats(const struct weft_job_values *values, int component, const uint32_t *at,
                         size_t count, float *out)
{
    const size_t n = (size_t)values->components, c = (size_t)component;
    const float *in = values->data;
    for (size_t i = 0; i < count; i++)
        out[i] = in[at[i] * n + c];
}

// ---- sums of integers, passes/plan/pass.h -------------------------------------------------------

static void add_logarithms(struct emulator *e, int32_t factor)
{
    const int one = e->m->one;
    for (size_t i = 0; i < e->count; i++) {
        const int32_t s = e->samples[i], q = e->weights[i];
        if (s != one && q != one)
            e->sums[i] += factor * (int32_t)e->passes->log_table[s + q];
    }
}

static void add_products(struct emulator *e, const struct weft_pass *pass, int32_t factor)
{
    if (e->passes->log_table) {
        add_logarithms(e, factor);
    } else if (e->passes->exact_inside) {
        for (size_t i = 0; i < e->count; i++)
            e->sums[i] += e->samples[i] * e->weights[i] * factor;
    } else {
        for (size_t i = 0; i < e->count; i++)
            e->sums[i] +=
                weft_divide_nearest(e->samples[i] * e->weights[i] * factor, pass->divisor);
    }
}

static void saturate(struct emulator *e)
{
    const int limit = e->m->limit;
    for (size_t i = 0; limit < INT_MAX && i < e->count; i++)
        e->sums[i] = e->sums[i] < -limit ? -limit : e->sums[i] > limit ? limit : e->sums[i];
}

static void add_group(struct emulator *e, const struct weft_pass *pass, int group, int channel)
{
    const int tap_count = e->passes->dot4 ? 4 : 1;
    for (int c = 0; c < tap_count; c++) {
        const int factor = weft_multipass_factor(e->m, pass, &e->passes->groups[group], c);
        if (factor) {
            fetch(&e->job->source, e->passes->dot4 ? c : channel, e->sample_at, e->count,
                  e->samples);
            fetch(&e->m->tiles, c, e->weight_at, e->count, e->weights);
            add_products(e, pass, factor);
        }
        if (c == 2 && e->passes->dot_width == 3)
            saturate(e);
    }
    saturate(e);
}

// n of every pixel. The bias is there from the start, so that it saturates with the sum.
static void sum_up(struct emulator *e, const struct weft_pass *pass, int channel)
{
    const bool divides = e->passes->exact_inside && !e->passes->log_table;
    const int32_t bias = pass->subtract ? -pass->bias : pass->bias;
    for (size_t i = 0; i < e->count; i++)
        e->sums[i] = bias * (divides ? pass->divisor : 1);
    for (int g = pass->group_first; g < pass->group_first + pass->group_count; g++) {
        locate(e, g);
        add_group(e, pass, g, channel);
    }
    for (size_t i = 0; divides && i < e->count; i++)
        e->sums[i] = weft_divide_nearest(e->sums[i], pass->divisor);
}

// From n to what the target changes by.
static void take_part(struct emulator *e, const struct weft_pass *pass)
{
    const int bits = e->passes->extra_bits;
    const int32_t mask = (1 << bits) - 1;
    const int32_t rounds = pass->part == WEFT_PASS_WHOLE ? (1 << bits) / 2
                           : pass->subtract              ? mask
                                                         : 0;
    const bool turned = pass->subtract;
    for (size_t i = 0; i < e->count; i++) {
        const int32_t n = e->sums[i];
        if (pass->part == WEFT_PASS_LOW)
            e->sums[i] = (turned ? -n : n) & mask;
        else
            e->sums[i] = (n + rounds) >> bits;
    }
}

static int32_t clamped(struct emulator *e, int32_t code)
{
    const int32_t inside = code < 0 ? 0 : code > e->m->one ? e->m->one : code;
    const int64_t clamp = llabs((int64_t)code - inside);
    e->clamps += clamp > 0;
    e->largest_clamp = clamp > e->largest_clamp ? clamp : e->largest_clamp;
    return inside;
}

static void store(struct emulator *e, const struct weft_pass *pass, int channel)
{
    int32_t *slot = slot_codes(e, pass->target, channel);
    const bool falls = pass->subtract && pass->part != WEFT_PASS_LOW;
    for (size_t i = 0; i < e->count; i++) {
        const int32_t y = pass->clears ? pass->initial : slot[i];
        // What is blended is a code itself.
        const int32_t n =
            pass->reads_target || e->sums[i] >= 0 ? e->sums[i] : clamped(e, e->sums[i]);
        slot[i] = clamped(e, falls ? y - n : y + n);
    }
}

static void combine(struct emulator *e, const struct weft_pass *pass, int channel)
{
    const bool rounds = !e->passes->exact_inside;
    const int32_t denominator = rounds ? 1 << e->passes->extra_bits : pass->denominator;
    const int32_t bias = weft_multipass_bias(e->m, pass);
    for (size_t i = 0; i < e->count; i++)
        e->sums[i] = bias;
    for (int k = 0; k < pass->input_count; k++) {
        const int32_t *in = slot_codes(e, pass->input[k], channel);
        const int32_t numerator = weft_multipass_numerator(e->m, pass, k);
        for (size_t i = 0; i < e->count; i++)
            e->sums[i] += rounds ? weft_divide_nearest(numerator * in[i], pass->denominator)
                                 : numerator * in[i];
    }
    int32_t *out = slot_codes(e, pass->target, channel);
    for (size_t i = 0; i < e->count; i++) {
        const int32_t below = e->sums[i] % denominator < 0;
        out[i] = clamped(e, e->sums[i] / denominator - below);
    }
}

// ---- sums of floats -----------------------------------------------------------------------------

// Products and sums in loops of their own: nothing is contracted to a fused multiplication.
static void add_float_products(struct emulator *e, float weight)
{
    float *product = e->float_samples;
    for (size_t i = 0; i < e->count; i++)
        product[i] *= e->float_weights[i];
    for (size_t i = 0; i < e->count; i++)
        product[i] *= weight;
    for (size_t i = 0; i < e->count; i++)
        e->float_sums[i] += product[i];
}

static void sum_up_floats(struct emulator *e, const struct weft_pass *pass, int channel)
{
    const int tap_count = e->passes->dot4 ? 4 : 1;
    for (size_t i = 0; i < e->count; i++)
        e->float_sums[i] = (float)(pass->subtract ? -pass->bias : pass->bias);
    for (int g = pass->group_first; g < pass->group_first + pass->group_count; g++) {
        locate(e, g);
        for (int c = 0; c < tap_count; c++) {
            fetch_floats(&e->job->source, e->passes->dot4 ? c : channel, e->sample_at, e->count,
                         e->float_samples);
            fetch_floats(&e->m->tiles, c, e->weight_at, e->count, e->float_weights);
            const int factor = weft_multipass_factor(e->m, pass, &e->passes->groups[g], c);
            add_float_products(e, weft_multipass_weight(pass, factor));
        }
    }
}

static float stored(const struct emulator *e, float x)
{
    return e->passes->target == WEFT_TARGET_HALF ? weft_half_truncate(x) : x;
}

static void store_floats(struct emulator *e, const struct weft_pass *pass, int channel)
{
    float *slot = slot_floats(e, pass->target, channel);
    for (size_t i = 0; i < e->count; i++) {
        const float y = pass->clears ? (float)pass->initial : slot[i];
        slot[i] = stored(e, pass->subtract ? y - e->float_sums[i] : y + e->float_sums[i]);
    }
}

static void combine_floats(struct emulator *e, const struct weft_pass *pass, int channel)
{
    for (size_t i = 0; i < e->count; i++)
        e->float_sums[i] = (float)((double)pass->bias / pass->denominator);
    for (int k = 0; k < pass->input_count; k++) {
        const float *in = slot_floats(e, pass->input[k], channel);
        const float weight = (float)((double)pass->numerator[k] / pass->denominator);
        for (size_t i = 0; i < e->count; i++)
            e->float_samples[i] = in[i] * weight;
        for (size_t i = 0; i < e->count; i++)
            e->float_sums[i] += e->float_samples[i];
    }
    float *out = slot_floats(e, pass->target, channel);
    for (size_t i = 0; i < e->count; i++)
        out[i] = stored(e, e->float_sums[i]);
}

// ---- running ------------------------------------------------------------------------------------

static void run_chunk(struct emulator *e, const struct weft_pass *pass, int channel)
{
    if (e->m->floats && pass->kind == WEFT_PASS_COMBINE) {
        combine_floats(e, pass, channel);
    } else if (e->m->floats) {
        sum_up_floats(e, pass, channel);
        store_floats(e, pass, channel);
    } else if (pass->kind == WEFT_PASS_COMBINE) {
        combine(e, pass, channel);
    } else {
        sum_up(e, pass, channel);
        take_part(e, pass);
        store(e, pass, channel);
    }
}

static enum weft_result run_passes(struct emulator *e)
{
    for (int p = 0; p < e->passes->pass_count; p++) {
        if (!weft_job_go_on(e->progress, (double)p / e->passes->pass_count))
            return WEFT_ERR_CANCELLED;
        for (e->first = 0; e->first < e->job->pixels; e->first += CHUNK) {
            const size_t left = e->job->pixels - e->first;
            e->count = left < CHUNK ? left : CHUNK;
            for (int c = 0; c < e->channels; c++)
                run_chunk(e, &e->passes->passes[p], c);
        }
    }
    e->first = 0;
    return WEFT_OK;
}

static enum weft_result create_slots(struct emulator *e, struct weft_multipass_report *report)
{
    size_t values, bytes = 0;
    const size_t planes = (size_t)e->passes->slot_count * (size_t)e->channels;
    if (weft_size_mul(planes, e->job->pixels, &values) && weft_size_mul(values, 4, &bytes)) {
        if (e->m->floats)
            e->floats = calloc(values, sizeof *e->floats);
        else
            e->codes = calloc(values, sizeof *e->codes);
    }
    if (!e->floats && !e->codes) {
        weft_error(e->job->log, "emulation: not enough memory for %d targets of %zu pixels",
                   e->passes->slot_count, e->job->pixels);
        return WEFT_ERR_MEMORY;
    }
    report->target_bytes = bytes;
    return WEFT_OK;
}

// The result slot as GL hands it back: channels interleaved, in the target's own type.
static enum weft_result finish(const struct emulator *e, struct weft_multipass_report *report)
{
    const size_t channels = (size_t)e->channels;
    const size_t count = e->job->pixels;
    void *result = malloc(count * channels * sizeof(float));
    if (!result) {
        weft_error(e->job->log, "emulation: not enough memory for %zu pixels", count);
        return WEFT_ERR_MEMORY;
    }
    for (int c = 0; c < e->channels; c++) {
        for (size_t i = 0; i < count; i++) {
            const size_t to = i * channels + (size_t)c;
            if (e->m->floats)
                ((float *)result)[to] = slot_floats(e, e->passes->result, c)[i];
            else if (e->m->one <= 0xff)
                ((uint8_t *)result)[to] = (uint8_t)slot_codes(e, e->passes->result, c)[i];
            else
                ((uint16_t *)result)[to] = (uint16_t)slot_codes(e, e->passes->result, c)[i];
        }
    }
    weft_multipass_job_finish(e->job, result, report);
    free(result);
    report->clamps = e->clamps;
    report->largest_clamp = (double)e->largest_clamp;
    return WEFT_OK;
}

enum weft_result weft_multipass_cpu_run(const struct weft_multipass_job *job,
                                        struct weft_multipass_report *report)
{
    const struct weft_multipass *m = job->compiled;
    const double start = weft_now_seconds();
    struct emulator *e = calloc(1, sizeof *e);
    if (!e) {
        weft_error(job->log, "emulation: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    e->job = job;
    e->m = m;
    e->passes = m->passes;
    e->progress = job->params->progress;
    e->channels = m->work.channels;
    enum weft_result res = create_slots(e, report);
    if (res == WEFT_OK)
        res = run_passes(e);
    report->pass_seconds = weft_now_seconds() - start;
    if (res == WEFT_OK)
        res = finish(e, report);
    free(e->codes);
    free(e->floats);
    free(e);
    return res;
}
