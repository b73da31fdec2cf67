// SPDX-License-Identifier: BSD-3-Clause
#include "passes/verify/verifier.h"

#include <float.h>
#include <math.h>

static const double DEFAULT_SECONDS = 10.0, LEAST_PIXELS = 64.0;

// Relative errors below this need no second look.
static const double CLOSE = 1e-6;

// ---- the rule -----------------------------------------------------------------------------------

// |value - reference|; INFINITY where one of them is finite and the other is not, NAN where neither
// is.
static double error_of(double value, double reference)
{
    const bool beyond = isfinite(reference) && fabs(reference) > (double)FLT_MAX;
    const double nearest = beyond ? copysign((double)FLT_MAX, reference) : reference;
    if (isfinite(value) && isfinite(reference))
        return fabs(value - nearest);
    const bool overflows = beyond && isinf(value) && (value > 0.0) == (reference > 0.0);
    return isfinite(value) == isfinite(reference) || overflows ? (double)NAN : (double)INFINITY;
}

// Of an error above 0.
static double ratio(double error, double to)
{
    return isinf(error) ? error : error / to;
}

void weft_verify_add(struct weft_verify_report *r, int x, int y, int channel, double value,
                     const struct weft_reference_value *reference)
{
    const double error = error_of(value, reference->value);
    if (isnan(error))
        return;
    const bool first = r->values_compared == 0 && r->not_finite_mismatches == 0;
    if (isinf(error)) {
        r->not_finite_mismatches++;
    } else {
        r->values_compared++;
        r->squares += error * error;
        r->rms = sqrt(r->squares / (double)r->values_compared);
        r->magnitude = fmax(r->magnitude, reference->magnitude);
    }
    const double own = r->bound_relative * reference->magnitude + r->bound_absolute;
    r->bound = r->bound_relative * r->magnitude + r->bound_absolute;
    if (isnan(own))
        r->share = own;
    else if (isinf(error) || error > r->share * own)
        r->share = ratio(error, own);
    if (isinf(error) || error > r->relative_maximum * reference->magnitude)
        r->relative_maximum = ratio(error, reference->magnitude);
    if (!(error > r->maximum) && !first)
        return;
    r->maximum = error;
    r->at_x = x;
    r->at_y = y;
    r->at_channel = channel;
    r->at_value = value;
    r->at_reference = reference->value;
}

// Whether what is at the first place is told rather than what is at the second.
static bool comes_first(const struct weft_verify_report *a, const struct weft_verify_report *b)
{
    if (a->maximum != b->maximum)
        return a->maximum > b->maximum;
    return a->at_y != b->at_y ? a->at_y < b->at_y : a->at_x < b->at_x;
}

void weft_verify_join(struct weft_verify_report *sum, const struct weft_verify_report *other)
{
    const struct weft_verify_report a = *sum, *b = other;
    const bool any = a.values_compared || a.not_finite_mismatches;
    if (!a.pixels_total) {
        *sum = *other;
        return;
    }
    if ((b->values_compared || b->not_finite_mismatches) && (!any || comes_first(b, &a)))
        *sum = *b;
    sum->pixels_total = a.pixels_total + b->pixels_total;
    sum->pixels_checked = a.pixels_checked + b->pixels_checked;
    sum->values_compared = a.values_compared + b->values_compared;
    sum->not_finite_mismatches = a.not_finite_mismatches + b->not_finite_mismatches;
    sum->squares = a.squares + b->squares;
    sum->rms = sum->values_compared ? sqrt(sum->squares / (double)sum->values_compared) : 0.0;
    sum->relative_maximum = fmax(a.relative_maximum, b->relative_maximum);
    sum->magnitude = fmax(a.magnitude, b->magnitude);
    sum->bound = sum->bound_relative * sum->magnitude + sum->bound_absolute;
    sum->share = isnan(a.share) || isnan(b->share) ? (double)NAN : fmax(a.share, b->share);
}

// ---- one value ----------------------------------------------------------------------------------

struct run {
    const struct weft_verifier *v;
    double share; // of the pixels that are checked
    struct weft_verify_report report;
};

static bool is_close(double value, const struct weft_reference_value *reference)
{
    const double error = error_of(value, reference->value);
    return isnan(error) || (!isinf(error) && error <= CLOSE * reference->magnitude);
}

static bool is_closer(double value, double than, double reference)
{
    const double error = error_of(value, reference), other = error_of(value, than);
    return (isnan(error) ? 0.0 : error) < (isnan(other) ? 0.0 : other);
}

// Where a reference is not close, engines may have its position rounded the other way, onto the
// other side of a cell's border: then the largest |sample| on either side counts, and where the
// kernel jumps, or what counts is not finite, the side that comes closer.
static enum weft_result look_around(const struct weft_verifier *v, int channel, int x, int y,
                                    const double position[3], double value,
                                    struct weft_reference_value *best)
{
    const bool jumps = v->jumps || isinf(error_of(value, best->value));
    if (!v->margin || (v->far && !jumps))
        return WEFT_OK;
    const double margin = v->margin(v->priv, position);
    for (int corner = 0; corner < 8; corner++) {
        double moved[3], at[3];
        struct weft_reference_value other;
        for (int a = 0; a < 3; a++)
            moved[a] = corner >> a & 1 ? margin : -margin;
        v->position(v->priv, x, y, moved, at);
        const enum weft_result res = v->refer(v->priv, channel, at, isfinite(value), &other);
        if (res != WEFT_OK)
            return res;
        best->magnitude = fmax(best->magnitude, other.magnitude);
        if (jumps && is_closer(value, best->value, other.value))
            best->value = other.value;
    }
    return WEFT_OK;
}

static enum weft_result check_pixel(struct run *run, int x, int y)
{
    const struct weft_verifier *v = run->v;
    double position[3];
    v->position(v->priv, x, y, NULL, position);
    for (int a = 0; a < 3; a++) {
        if (isfinite(position[a]))
            continue;
        weft_error(v->log, "verifying: pixel (%d, %d) lies at %g along %c", x, y, position[a],
                   "xyz"[a]);
        return WEFT_ERR_ARGUMENT;
    }
    run->report.pixels_checked++;
    for (int c = 0; c < v->channels; c++) {
        const double value = v->pixel(v->priv, c, x, y);
        struct weft_reference_value reference;
        enum weft_result res = v->refer(v->priv, c, position, isfinite(value), &reference);
        if (res == WEFT_OK && !is_close(value, &reference))
            res = look_around(v, c, x, y, position, value, &reference);
        if (res != WEFT_OK)
            return res;
        weft_verify_add(&run->report, x, y, c, value, &reference);
        if (v->how.tell)
            v->how.tell(v->how.tell_priv, x, y, v->first_channel + c, value, reference.value);
    }
    return WEFT_OK;
}

// ---- all ----------------------------------------------------------------------------------------

// A fixed number in [0, 1) for every pixel.
static double pixel_number(uint64_t seed, int x, int y)
{
    uint64_t h = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
    h += UINT64_C(0x9e3779b97f4a7c15) * (seed + 1);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    h ^= h >> 31;
    return (double)(h >> 11) * 0x1p-53;
}

// As measured on one core of 2020: volumes and images, 4 to 512 taps.
double weft_verifier_seconds(const struct weft_kernel *kernel, int dims)
{
    return 3e-7 + 2.5e-8 * pow(kernel->width, dims);
}

static double share_of(const struct weft_verifier *v, double total)
{
    const double limit = v->how.max_seconds > 0.0 ? v->how.max_seconds : DEFAULT_SECONDS;
    const double all = v->seconds * v->channels * total;
    return fmax(limit / all, LEAST_PIXELS / total);
}

static bool report(const struct run *run, double fraction)
{
    const struct weft_progress *progress = run->v->how.progress;
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

static enum weft_result go_on(const struct run *run, double fraction)
{
    if (report(run, fraction))
        return WEFT_OK;
    weft_note(run->v->log, "verifying was cancelled after %llu of %llu pixels",
              (unsigned long long)run->report.pixels_checked,
              (unsigned long long)run->report.pixels_total);
    return WEFT_ERR_CANCELLED;
}

static enum weft_result check_part(struct run *run, int index, int count)
{
    const struct weft_verifier *v = run->v;
    struct weft_rectangle part = v->pixels;
    enum weft_result res = v->enter ? v->enter(v->priv, index, &part) : WEFT_OK;
    for (int y = part.y; res == WEFT_OK && y < part.y + part.height; y++) {
        res = go_on(run, (index + (double)(y - part.y) / part.height) / count);
        for (int x = part.x; res == WEFT_OK && x < part.x + part.width; x++)
            if (run->share >= 1.0 || pixel_number(v->how.seed, x, y) < run->share)
                res = check_pixel(run, x, y);
    }
    return res;
}

enum weft_result weft_verifier_run(const struct weft_verifier *v, struct weft_verify_report *out)
{
    const uint64_t total = (uint64_t)v->width * (uint64_t)v->height;
    struct run run = {
        .v = v,
        .share = share_of(v, (double)total),
        .report = {.pixels_total = (uint64_t)v->pixels.width * (uint64_t)v->pixels.height,
                   .bound_relative = v->bound_relative,
                   .bound_absolute = v->bound_absolute,
                   .bound = v->bound_absolute},
    };
    const int count = v->enter ? v->part_count : 1;
    enum weft_result res = WEFT_OK;
    *out = (struct weft_verify_report){0};
    for (int i = 0; res == WEFT_OK && i < count; i++)
        res = check_part(&run, i, count);
    if (res != WEFT_OK)
        return res;
    report(&run, 1.0);
    *out = run.report;
    return WEFT_OK;
}
