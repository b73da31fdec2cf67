// SPDX-License-Identifier: BSD-3-Clause
#include "filter/analysis/error.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "filter/kernels/kernel_nd.h"

const char *const weft_error_lookup_names[] = {"nearest", "linear", NULL};
const char *const weft_error_convention_names[] = {"eq4", "wscg2003", NULL};

// The tensor product makes everything about a location a product of what is in one column per axis,
// so no tile is ever stored: texels are products too, quantised where they are used. The loops run
// over columns a <= b <= c, the innermost over many c at once.

enum { TAPS = WEFT_KERNEL_MAX_WIDTH, MAX_LOCATIONS = 4096, MAX_SAMPLES = 65536, MAX_THREADS = 256 };
enum { BLOCK = 128 }; // columns of the innermost axis at a time: their sums stay in the L1 cache

// One axis at one location: the weights as they are, and the two texels that a lookup reads for
// each, in order, with their shares 1 - fraction and fraction. A fraction of 0 is one texel.
struct column {
    double fraction, exact[TAPS], texel[2][TAPS];
    int location, count; // the first location that looks like this and how many do
};

// Errors are positive; a bin is an exponent and the 13 leading bits behind it.
enum { BIN_BITS = 13, MIN_EXPONENT = -48, MAX_EXPONENT = 16 };
enum { BINS = (MAX_EXPONENT - MIN_EXPONENT) << BIN_BITS };

struct partial {
    double sum, squares, signed_sum, signed_min, signed_max, maximum, single;
    int at[3];
};

struct job {
    struct weft_error_kernel_params p;
    int taps;            // per axis
    int distinct, slabs; // columns; the parts of the work: columns of the first axis, in 1D one
    bool linear;         // some fraction is not 0
    struct column *columns, unused_axis;
    // The columns again, an array along the innermost axis for each tap.
    double *exact[TAPS], *texel[2][TAPS], *share[2];
    double *storage;
    struct partial *partials; // one per slab: sums do not depend on threads
    atomic_int next;
    atomic_bool cancelled;
};

struct worker {
    struct job *job;
    uint64_t *histogram;
    pthread_t thread;
    bool started, reports;
};

static double clean(double x)
{
    return x + 0.0; // -0 and 0 are the same column
}

// ---- columns ----

// The texel k of the tile of tap j, or of the row that tiles make.
static double tile_texel(const struct job *job, int64_t k, int j)
{
    const int64_t m = job->p.samples;
    if (job->p.convention == WEFT_ERROR_WSCG2003) {
        const int64_t last = (int64_t)job->taps * m - 1, texel = k + j * m;
        const int64_t clamped = texel < 0 ? 0 : texel > last ? last : texel;
        const double end = job->taps;
        const double x = last > 0 ? end * (double)clamped / (double)last : 0.0;
        return weft_kernel_weight(&job->p.kernel, x);
    }
    const int64_t clamped = k < 0 ? 0 : k >= m ? m - 1 : k;
    const double u = ((double)clamped + 0.5) / (double)m;
    return weft_kernel_weight(&job->p.kernel, u + (weft_kernel_offset(&job->p.kernel) - j));
}

static double exact_weight(const struct job *job, double u, int j)
{
    const double shift =
        job->p.convention == WEFT_ERROR_WSCG2003 ? j : weft_kernel_offset(&job->p.kernel) - j;
    return weft_kernel_weight(&job->p.kernel, u + shift);
}

// In integers, so that a location between texels is exactly there: u M = (2 i + 1) M / (2 L).
static void fill_column(const struct job *job, int location, struct column *out)
{
    const int64_t l = job->p.locations, m = job->p.samples;
    const bool linear = job->p.lookup == WEFT_ERROR_LINEAR;
    const int64_t scaled = (2 * (int64_t)location + 1) * m - (linear ? l : 0);
    const int64_t texel = scaled < 0 ? -1 : scaled / (2 * l);
    const int64_t rest = linear ? scaled - texel * 2 * l : 0;
    *out = (struct column){.location = location, .count = 1};
    out->fraction = (double)rest / (double)(2 * l);
    for (int j = 0; j < job->taps; j++) {
        out->exact[j] = clean(exact_weight(job, (location + 0.5) / (double)l, j));
        out->texel[0][j] = clean(tile_texel(job, texel, j));
        out->texel[1][j] = rest ? clean(tile_texel(job, texel + 1, j)) : out->texel[0][j];
    }
}

static int compare_content(const struct column *a, const struct column *b)
{
    return memcmp(a, b, offsetof(struct column, location));
}

// Sums of magnitudes do not tell a column from its mirror image.
static void mirror_if_less(const struct job *job, struct column *column)
{
    struct column mirrored = {.location = column->location, .count = column->count};
    const int far = column->fraction > 0.0 ? 1 : 0;
    mirrored.fraction = far ? 1.0 - column->fraction : 0.0;
    for (int j = 0; j < job->taps; j++) {
        const int k = job->taps - 1 - j;
        mirrored.exact[j] = column->exact[k];
        mirrored.texel[0][j] = column->texel[far][k];
        mirrored.texel[1][j] = column->texel[0][k];
    }
    if (compare_content(&mirrored, column) < 0)
        *column = mirrored;
}

static int by_content(const void *a, const void *b)
{
    const struct column *x = a, *y = b;
    const int order = compare_content(x, y);
    return order ? order : x->location - y->location;
}

static int by_location(const void *a, const void *b)
{
    return ((const struct column *)a)->location - ((const struct column *)b)->location;
}

static void fill_columns(struct job *job)
{
    const int locations = job->p.locations;
    struct column *c = job->columns;
    for (int i = 0; i < locations; i++) {
        fill_column(job, i, &c[i]);
        mirror_if_less(job, &c[i]);
    }
    qsort(c, (size_t)locations, sizeof *c, by_content);
    int distinct = 1;
    for (int i = 1; i < locations; i++) {
        if (compare_content(&c[i], &c[distinct - 1]) == 0)
            c[distinct - 1].count++;
        else
            c[distinct++] = c[i];
    }
    qsort(c, (size_t)distinct, sizeof *c, by_location);
    job->distinct = distinct;
    job->slabs = job->p.dims > 1 ? distinct : 1;
}

static bool transpose_columns(struct job *job)
{
    const size_t n = (size_t)job->distinct;
    double *row = job->storage = calloc((size_t)(3 * job->taps + 2) * n, sizeof *row);
    if (!row)
        return false;
    job->share[0] = row;
    job->share[1] = row + n;
    row += 2 * n;
    for (int k = 0; k < job->taps; k++, row += 3 * n) {
        job->exact[k] = row;
        job->texel[0][k] = row + n;
        job->texel[1][k] = row + 2 * n;
    }
    for (size_t i = 0; i < n; i++) {
        const struct column *c = &job->columns[i];
        job->linear |= c->fraction > 0.0;
        job->share[0][i] = 1.0 - c->fraction;
        job->share[1][i] = c->fraction;
        for (int k = 0; k < job->taps; k++) {
            job->exact[k][i] = c->exact[k];
            job->texel[0][k][i] = c->texel[0][k];
            job->texel[1][k][i] = c->texel[1][k];
        }
    }
    return true;
}

// ---- a row of locations ----

// Products over all axes but the innermost: exact weights and the up to four texels of each, as
// unorm.
struct plane {
    int size, texels;
    double share[4], exact[TAPS * TAPS], texel[4][TAPS * TAPS];
};

static void fill_plane(const struct job *job, const struct column *a, const struct column *b,
                       struct plane *out)
{
    const double one = (double)weft_fixed_one(job->p.bits);
    const int na = job->p.dims > 1 ? job->taps : 1, nb = job->p.dims > 2 ? job->taps : 1;
    out->size = na * nb;
    out->texels = 0;
    for (int i = 0; i < na; i++)
        for (int j = 0; j < nb; j++)
            out->exact[i * nb + j] = a->exact[i] * b->exact[j];
    for (int p = 0; p <= (a->fraction > 0.0); p++) {
        for (int q = 0; q <= (b->fraction > 0.0); q++) {
            double *texel = out->texel[out->texels];
            for (int i = 0; i < na; i++)
                for (int j = 0; j < nb; j++)
                    texel[i * nb + j] = one * a->texel[p][i] * b->texel[q][j];
            out->share[out->texels++] =
                (p ? a->fraction : 1.0 - a->fraction) * (q ? b->fraction : 1.0 - b->fraction);
        }
    }
}

struct sums {
    double magnitude[BLOCK], value[BLOCK], single[BLOCK];
};

#define INLINE static inline __attribute__((always_inline))

// Truncation goes through int, which SSE2 has: below 2^31 as |weight| < 128.
INLINE double quantise(double x, double bias, bool plain)
{
    return (double)(int)(x + (plain ? bias : copysign(bias, x)));
}

// Entry i of the plane by tap k of the columns from `start` on: what the lookups give, as unorm.
INLINE void look_up(const struct job *job, const struct plane *plane, int i, int k, int start,
                    int count, double bias, bool plain, bool linear, double *restrict value)
{
    const double *restrict near = job->texel[0][k] + start, *restrict far =
                                                                job->texel[1][k] + start;
    const double *restrict share = job->share[0] + start, *restrict rest = job->share[1] + start;
    for (int c = 0; c < count; c++)
        value[c] = 0.0;
    for (int t = 0; t < plane->texels; t++) {
        const double texel = plane->texel[t][i], part = plane->share[t];
        for (int c = 0; c < count; c++)
            value[c] += linear ? part * (share[c] * quantise(texel * near[c], bias, plain) +
                                         rest[c] * quantise(texel * far[c], bias, plain))
                               : part * quantise(texel * near[c], bias, plain);
    }
}

INLINE void add_weights(const struct job *job, const struct plane *plane, int start, int count,
                        bool plain, bool linear, struct sums *restrict sums)
{
    const double lsb = 1.0 / (double)weft_fixed_one(job->p.bits);
    const double bias = job->p.rounding == WEFT_FIXED_ROUND ? 0.5 : 0.0;
    const bool again = plain && job->p.lookup == WEFT_ERROR_LINEAR;
    double value[BLOCK];
    for (int i = 0; i < plane->size; i++) {
        for (int k = 0; k < job->taps; k++) {
            const double *restrict exact = job->exact[k] + start, scale = plane->exact[i];
            look_up(job, plane, i, k, start, count, bias, plain, linear, value);
            for (int c = 0; again && c < count; c++)
                value[c] = quantise(value[c], bias, true);
            for (int c = 0; c < count; c++) {
                const double e = value[c] * lsb - scale * exact[c], size = fabs(e);
                sums->value[c] += e;
                sums->magnitude[c] += size;
                sums->single[c] = size > sums->single[c] ? size : sums->single[c];
            }
        }
    }
}

// The last two arguments are constants where this is inlined.
static void compute_row(const struct job *job, const struct plane *plane, int start, int count,
                        struct sums *sums)
{
    memset(sums, 0, sizeof *sums);
    if (job->p.convention == WEFT_ERROR_WSCG2003 && job->linear)
        add_weights(job, plane, start, count, true, true, sums);
    else if (job->p.convention == WEFT_ERROR_WSCG2003)
        add_weights(job, plane, start, count, true, false, sums);
    else if (job->linear)
        add_weights(job, plane, start, count, false, true, sums);
    else
        add_weights(job, plane, start, count, false, false, sums);
}

// ---- all locations ----

static int bin_of(double error)
{
    uint64_t bits;
    memcpy(&bits, &error, sizeof bits);
    const int64_t base = (int64_t)(1023 + MIN_EXPONENT) << BIN_BITS;
    const int64_t bin = (int64_t)(bits >> (52 - BIN_BITS)) - base;
    return bin < 0 ? 0 : bin >= BINS ? BINS - 1 : (int)bin;
}

static double bin_middle(int bin)
{
    const int exponent = MIN_EXPONENT + (bin >> BIN_BITS);
    const double leading = (bin & ((1 << BIN_BITS) - 1)) + 0.5;
    return bin == 0 ? 0.0 : ldexp(1.0 + ldexp(leading, -BIN_BITS), exponent);
}

// How many orders of the axes give these columns, of those the loops visit one.
static int permutations(int dims, int a, int b, int c)
{
    if (dims < 3)
        return dims < 2 || a == c ? 1 : 2;
    return a == b && b == c ? 1 : a == b || b == c ? 3 : 6;
}

static void note(struct partial *partial, const struct sums *sums, int i, double count,
                 const int at[3])
{
    partial->sum += count * sums->magnitude[i];
    partial->squares += count * sums->magnitude[i] * sums->magnitude[i];
    partial->signed_sum += count * sums->value[i];
    partial->signed_min = fmin(partial->signed_min, sums->value[i]);
    partial->signed_max = fmax(partial->signed_max, sums->value[i]);
    partial->single = fmax(partial->single, sums->single[i]);
    if (sums->magnitude[i] > partial->maximum) {
        partial->maximum = sums->magnitude[i];
        memcpy(partial->at, at, sizeof partial->at);
    }
}

// Columns a and b of the leading axes (those there are), all columns from them on of the innermost.
static void compute_rows(const struct job *job, int a, int b, uint64_t *histogram,
                         struct partial *partial)
{
    const int dims = job->p.dims;
    const struct column *first = dims > 1 ? &job->columns[a] : &job->unused_axis;
    const struct column *second = dims > 2 ? &job->columns[b] : &job->unused_axis;
    struct plane plane;
    struct sums sums;
    fill_plane(job, first, second, &plane);
    for (int start = b; start < job->distinct; start += BLOCK) {
        const int left = job->distinct - start, count = left < BLOCK ? left : BLOCK;
        compute_row(job, &plane, start, count, &sums);
        for (int i = 0; i < count; i++) {
            const int c = start + i, at[3] = {dims > 1 ? a : c, dims > 2 ? b : c, c};
            const int64_t equal = (int64_t)permutations(dims, a, b, c) * first->count *
                                  second->count * job->columns[c].count;
            histogram[bin_of(sums.magnitude[i])] += (uint64_t)equal;
            note(partial, &sums, i, (double)equal, at);
        }
    }
}

static void compute_slab(struct job *job, int a, uint64_t *histogram)
{
    struct partial partial = {.signed_min = INFINITY, .signed_max = -INFINITY, .maximum = -1.0};
    const int end = job->p.dims > 2 ? job->distinct : a + 1;
    for (int b = a; b < end; b++)
        compute_rows(job, a, b, histogram, &partial);
    job->partials[a] = partial;
}

// The slabs of one a shrink like (n - a)^(dims - 1).
static void report(struct worker *worker, int a)
{
    struct job *job = worker->job;
    const struct weft_progress *progress = job->p.progress;
    const double left = 1.0 - (double)a / job->slabs;
    if (worker->reports && progress && progress->report &&
        !progress->report(progress->priv, 1.0 - pow(left, job->p.dims)))
        atomic_store(&job->cancelled, true);
}

static void *work(void *priv)
{
    struct worker *worker = priv;
    struct job *job = worker->job;
    for (;;) {
        const int a = atomic_fetch_add(&job->next, 1);
        if (a >= job->slabs || atomic_load(&job->cancelled))
            return NULL;
        report(worker, a);
        compute_slab(job, a, worker->histogram);
    }
}

// A thread that cannot be started leaves its work to the others.
static void run_workers(struct worker *workers, int count)
{
    for (int i = 1; i < count; i++)
        workers[i].started = pthread_create(&workers[i].thread, NULL, work, &workers[i]) == 0;
    work(&workers[0]);
    for (int i = 1; i < count; i++) {
        if (workers[i].started)
            pthread_join(workers[i].thread, NULL);
        for (int bin = 0; bin < BINS; bin++)
            workers[0].histogram[bin] += workers[i].histogram[bin];
    }
}

// ---- results ----

static double percentile(const uint64_t *histogram, double locations, double share, double maximum)
{
    double below = 0.0;
    for (int bin = 0; bin < BINS; bin++) {
        below += (double)histogram[bin];
        if (below >= share * locations)
            return fmin(bin_middle(bin), maximum);
    }
    return maximum;
}

static void collect(const struct job *job, const uint64_t *histogram, struct weft_error_kernel *out)
{
    struct partial all = job->partials[0];
    for (int a = 1; a < job->slabs; a++) {
        const struct partial *p = &job->partials[a];
        all.sum += p->sum;
        all.squares += p->squares;
        all.signed_sum += p->signed_sum;
        all.signed_min = fmin(all.signed_min, p->signed_min);
        all.signed_max = fmax(all.signed_max, p->signed_max);
        all.single = fmax(all.single, p->single);
        if (p->maximum > all.maximum) {
            all.maximum = p->maximum;
            memcpy(all.at, p->at, sizeof all.at);
        }
    }
    const double locations = pow(job->p.locations, job->p.dims);
    *out = (struct weft_error_kernel){
        .maximum = all.maximum,
        .mean = all.sum / locations,
        .rms = sqrt(all.squares / locations),
        .median = percentile(histogram, locations, 0.5, all.maximum),
        .percentile_90 = percentile(histogram, locations, 0.9, all.maximum),
        .percentile_99 = percentile(histogram, locations, 0.99, all.maximum),
        .signed_min = all.signed_min,
        .signed_max = all.signed_max,
        .signed_mean = all.signed_sum / locations,
        .single = all.single,
        .scale = (double)weft_fixed_one(job->p.bits) +
                 (job->p.convention == WEFT_ERROR_WSCG2003 ? 1.0 : 0.0),
    };
    for (int d = 0; d < job->p.dims; d++)
        out->position[d] = (job->columns[all.at[d]].location + 0.5) / job->p.locations;
}

// Defaults filled in and everything checked.
static enum weft_result prepare(const struct weft_error_kernel_params *params, struct job *job)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_log *log = params->log;
    struct weft_error_kernel_params *p = &job->p;
    *p = *params;
    p->dims = p->dims ? p->dims : 2;
    p->samples = p->samples ? p->samples : 64;
    p->bits = p->bits ? p->bits : 8;
    p->locations = p->locations ? p->locations : p->dims > 2 ? 256 : 1024;
    p->threads = p->threads ? p->threads : (int)sysconf(_SC_NPROCESSORS_ONLN);
    p->threads = p->threads < 1 ? 1 : p->threads > MAX_THREADS ? MAX_THREADS : p->threads;
    if (weft_kernel_check(log, &p->kernel) != WEFT_OK)
        return res;
    weft_require(log, p->dims >= 1 && p->dims <= 3);
    weft_require(log, p->samples >= 1 && p->samples <= MAX_SAMPLES);
    weft_require(log, p->bits >= 1 && p->bits <= WEFT_FIXED_MAX_BITS);
    weft_require(log, p->locations >= 1 && p->locations <= MAX_LOCATIONS);
    weft_require(log, p->rounding == WEFT_FIXED_ROUND || p->rounding == WEFT_FIXED_TRUNCATE);
    weft_require(log, p->lookup == WEFT_ERROR_NEAREST || p->lookup == WEFT_ERROR_LINEAR);
    weft_require(log, p->convention == WEFT_ERROR_EQ4 || p->convention == WEFT_ERROR_WSCG2003);
    job->taps = p->kernel.width;
    if (weft_kernel_is_radial(&p->kernel, p->dims)) {
        weft_error(log,
                   "kernel error: %s is radial, in %dD its weights are no products of each axis' "
                   "(weft_kernel_tiles_exact has them)",
                   p->kernel.info->name, p->dims);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (p->convention == WEFT_ERROR_WSCG2003) {
        if (p->kernel.support != floor(p->kernel.support)) {
            weft_error(log, "convention wscg2003 needs a whole half-width, that of %s is %g",
                       p->kernel.info->name, p->kernel.support);
            return WEFT_ERR_UNSUPPORTED;
        }
        job->taps = (int)p->kernel.support;
    }
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_error_kernel_compute(const struct weft_error_kernel_params *params,
                                           struct weft_error_kernel *out)
{
    *out = (struct weft_error_kernel){0};
    struct job job = {.unused_axis = {.exact = {1.0}, .texel = {{1.0}, {1.0}}, .count = 1}};
    struct worker *workers = NULL;
    uint64_t *histograms = NULL;
    enum weft_result res = prepare(params, &job);
    if (res)
        return res;
    const size_t threads = (size_t)job.p.threads;
    res = WEFT_ERR_MEMORY;
    job.columns = calloc((size_t)job.p.locations, sizeof *job.columns);
    job.partials = calloc((size_t)job.p.locations, sizeof *job.partials);
    workers = calloc(threads, sizeof *workers);
    histograms = calloc(threads * BINS, sizeof *histograms);
    if (!job.columns || !job.partials || !workers || !histograms)
        goto no_memory;
    fill_columns(&job);
    if (!transpose_columns(&job))
        goto no_memory;
    for (size_t i = 0; i < threads; i++)
        workers[i] =
            (struct worker){.job = &job, .histogram = histograms + i * BINS, .reports = !i};
    run_workers(workers, job.p.threads);
    res = WEFT_ERR_CANCELLED;
    if (atomic_load(&job.cancelled))
        goto fail;
    collect(&job, histograms, out);
    res = WEFT_OK;
    goto fail;
no_memory:
    weft_error(params->log, "kernel error: no memory for %zu threads", threads);
fail:
    free(job.storage);
    free(histograms);
    free(workers);
    free(job.partials);
    free(job.columns);
    return res;
}

double weft_error_e1(const struct weft_kernel *kernel, int dims, double derivative_bound)
{
    if (dims < 1 || dims > 3 || weft_kernel_is_radial(kernel, dims))
        return NAN;
    return dims * weft_analysis_order(kernel).largest * derivative_bound;
}
