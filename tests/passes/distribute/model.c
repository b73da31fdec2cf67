// SPDX-License-Identifier: BSD-3-Clause
#include "tests/passes/distribute/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROOM = 64 };

struct rank {
    double ready;   // when it begins its next item, or has ended its last
    int64_t next;   // its own next item, of static schedules
    int64_t held;   // item that it was given, pulled; -1: none
    double held_at; // when it comes
    double last;    // seconds of its last item
    double waiting; // since when it has a result that has no room; < 0: it has none
    double bytes;   // of that
    int results;    // on their way or come, not taken
    struct {
        double arrival, bytes;
    } result[MOST_ROOM];
    double busy, taking, sent;
    int64_t items;
};

struct work {
    const struct model *model;
    int room;
    int64_t count;
    const double *seconds, *bytes;
    const int64_t *order; // of pulled items; NULL: as they are
    int64_t pulled;
    double answered; // until when rank 0 is kept by answers
    struct rank *rank;
};

static bool pulls(const struct work *w)
{
    return w->model->schedule == WEFT_SCHEDULE_PULL;
}

static bool has_item(const struct work *w, int rank)
{
    const struct rank *r = &w->rank[rank];
    return pulls(w) ? r->held >= 0 || w->pulled < w->count : r->next < w->count;
}

// ---- results ------------------------------------------------------------------------------------

static void send(struct work *w, int rank, double when, double bytes)
{
    struct rank *r = &w->rank[rank];
    const struct model_machine *m = &w->model->machine;
    r->result[r->results].arrival = when + m->latency + bytes * m->byte_seconds;
    r->result[r->results++].bytes = bytes;
    r->sent += bytes;
}

// The rank whose result comes first; -1: none is on its way.
static int find_first(const struct work *w)
{
    int found = -1;
    for (int r = 1; r < w->model->processors; r++)
        if (w->rank[r].results &&
            (found < 0 || w->rank[r].result[0].arrival < w->rank[found].result[0].arrival))
            found = r;
    return found;
}

// Rank 0 takes it, once it has come and rank 0 is ready; whom it belongs to may send the next one.
static void take(struct work *w, int rank)
{
    struct rank *zero = &w->rank[0], *r = &w->rank[rank];
    const struct model_machine *m = &w->model->machine;
    const double seconds = m->take + r->result[0].bytes * m->take_byte;
    zero->ready = fmax(zero->ready, r->result[0].arrival) + seconds;
    zero->taking += seconds;
    memmove(r->result, r->result + 1, (size_t)--r->results * sizeof *r->result);
    if (r->waiting >= 0.0) {
        r->ready = fmax(r->waiting, zero->ready + m->latency);
        r->waiting = -1.0;
        send(w, rank, r->ready, r->bytes);
    }
}

// ---- items --------------------------------------------------------------------------------------

// Of rank 0, which asks itself; *when: it is asked, then the answer is there.
static int64_t ask(struct work *w, int rank, double *when)
{
    const struct model_machine *m = &w->model->machine;
    if (rank > 0) {
        w->answered = fmax(w->answered, *when + m->latency) + m->answer;
        *when = w->answered + m->latency;
    }
    const int64_t at = w->pulled++;
    return w->order ? w->order[at] : at;
}

static void ask_next(struct work *w, int rank)
{
    struct rank *r = &w->rank[rank];
    r->held_at = r->ready;
    r->held = ask(w, rank, &r->held_at);
}

static int64_t begin_item(struct work *w, int rank)
{
    struct rank *r = &w->rank[rank];
    int64_t item = r->next;
    if (!pulls(w)) {
        r->next += w->model->processors;
        return item;
    }
    item = r->held;
    r->ready = fmax(r->ready, r->held_at);
    r->held = -1;
    if (rank > 0 && r->items > 0 && r->last < w->model->machine.ahead && w->pulled < w->count)
        ask_next(w, rank);
    return item;
}

static void do_item(struct work *w, int rank)
{
    struct rank *r = &w->rank[rank];
    const int64_t item = begin_item(w, rank);
    r->ready += w->seconds[item];
    r->last = w->seconds[item];
    r->busy += r->last;
    r->items++;
    if (rank == 0) {
        const double seconds =
            w->model->machine.take + w->bytes[item] * w->model->machine.take_byte;
        r->ready += seconds;
        r->taking += seconds;
    } else if (r->results < w->room) {
        send(w, rank, r->ready, w->bytes[item]);
    } else {
        r->waiting = r->ready;
        r->bytes = w->bytes[item];
    }
}

// When it has an item to begin with, or asks for one: in this order rank 0 answers.
static double goes_on(const struct rank *r)
{
    return r->held >= 0 ? fmax(r->ready, r->held_at) : r->ready;
}

// The rank that goes on first; -1: all have ended, or wait for room.
static int find_ready(const struct work *w)
{
    int found = -1;
    for (int r = 0; r < w->model->processors; r++)
        if (w->rank[r].waiting < 0.0 && has_item(w, r) &&
            (found < 0 || goes_on(&w->rank[r]) < goes_on(&w->rank[found])))
            found = r;
    return found;
}

// Returns the seconds from the first beginning to the last end.
static double simulate(struct work *w)
{
    const int count = w->model->processors;
    w->pulled = 0, w->answered = 0.0;
    for (int r = 0; r < count; r++)
        w->rank[r] = (struct rank){.next = r, .held = -1, .waiting = -1.0};
    for (;;) {
        const int ready = find_ready(w), first = find_first(w);
        const bool may_take = first >= 0 && (ready == 0 || !has_item(w, 0));
        const double begins =
            may_take ? fmax(w->rank[first].result[0].arrival, w->rank[0].ready) : 0.0;
        if (may_take && (ready < 0 || begins <= goes_on(&w->rank[ready])))
            take(w, first);
        else if (ready >= 0 && pulls(w) && w->rank[ready].held < 0)
            ask_next(w, ready);
        else if (ready >= 0)
            do_item(w, ready);
        else
            break;
    }
    // All tell rank 0 what they did, which tells all that it is over.
    double end = w->rank[0].ready;
    for (int r = 1; r < count; r++)
        end = fmax(end, w->rank[r].ready + w->model->machine.latency);
    return count > 1 ? end + (count - 1) * w->model->machine.answer + w->model->machine.latency
                     : end;
}

// ---- frames -------------------------------------------------------------------------------------

static void add_work(struct work *w, struct model_result *out)
{
    const int count = w->model->processors;
    double sum = 0.0, largest = 0.0;
    for (int64_t i = 0; i < w->count; i++) {
        sum += w->seconds[i];
        largest = fmax(largest, w->seconds[i]);
    }
    out->load.seconds += simulate(w);
    for (int r = 0; r < count; r++) {
        out->load.rank[r].busy += w->rank[r].busy;
        out->load.rank[r].taking += w->rank[r].taking;
        out->load.rank[r].items += w->rank[r].items;
        out->load.rank[r].bytes += (uint64_t)w->rank[r].sent;
    }
    out->work += sum;
    out->largest = fmax(out->largest, largest);
    out->bound += sum / count + (1.0 - 1.0 / count) * largest;
    out->lower += fmax(sum / count, largest);
    out->items = w->count;
}

static int compare(const void *a, const void *b, void *seconds)
{
    const int64_t i = *(const int64_t *)a, k = *(const int64_t *)b;
    const double *s = seconds;
    return s[i] != s[k] ? (s[i] > s[k] ? -1 : 1) : (i > k) - (i < k);
}

struct frames {
    weft_regions *regions;
    double *seconds, *bytes; // [frames of a work][regions]
    int64_t *order;
};

static void measure(const struct model *m, int frame, int64_t at, struct frames *f)
{
    for (int64_t i = 0; i < weft_regions_count(f->regions); i++) {
        const struct weft_rectangle region = weft_regions_get(f->regions, i);
        f->seconds[at + i] = m->cost(m->priv, frame, &region);
        f->bytes[at + i] = m->bytes * region.width * region.height;
    }
}

// The dearest first, by the frame before.
static void sort(struct frames *f)
{
    const int64_t count = weft_regions_count(f->regions);
    for (int64_t i = 0; i < count; i++)
        f->order[i] = i;
    qsort_r(f->order, (size_t)count, sizeof *f->order, compare, f->seconds);
}

static bool run_frames(const struct model *m, struct work *w, struct frames *f,
                       struct model_result *out)
{
    const int64_t count = weft_regions_count(f->regions);
    for (int frame = 0; frame < m->frames; frame++) {
        if (m->schedule == WEFT_SCHEDULE_PULL && frame > 0 && !m->one_work) {
            sort(f);
            w->order = f->order;
        }
        measure(m, frame, m->one_work ? frame * count : 0, f);
        if (!m->one_work)
            add_work(w, out);
        if (m->schedule == WEFT_SCHEDULE_DYNAMIC &&
            weft_regions_balance(f->regions, f->seconds, m->keep) != WEFT_OK)
            return false;
    }
    if (m->one_work)
        add_work(w, out);
    return true;
}

bool model_run(const struct model *model, struct model_result *out)
{
    struct frames f = {.regions = NULL};
    struct weft_regions_params params = model->params;
    *out = (struct model_result){.work = 0.0};
    params.ranks = params.ranks ? params.ranks : model->processors;
    bool good = weft_load_create(model->processors, &out->load) == WEFT_OK &&
                weft_regions_create(&params, &f.regions) == WEFT_OK;
    const int64_t works = model->one_work ? model->frames : 1;
    const size_t count = good ? (size_t)(weft_regions_count(f.regions) * works) : 0;
    f.seconds = malloc(count * sizeof *f.seconds + 1);
    f.bytes = malloc(count * sizeof *f.bytes + 1);
    f.order = malloc(count * sizeof *f.order + 1);
    struct work w = {.model = model,
                     .room = model->machine.room ? model->machine.room : MOST_ROOM,
                     .count = (int64_t)count,
                     .seconds = f.seconds,
                     .bytes = f.bytes,
                     .rank = malloc((size_t)model->processors * sizeof *w.rank)};
    good = good && f.seconds && f.bytes && f.order && w.rank && w.room <= MOST_ROOM &&
           run_frames(model, &w, &f, out);
    if (good) {
        struct weft_load_figures figures;
        weft_load_compute(&out->load, &figures);
        out->idle_share = figures.idle_share;
        out->imbalance = figures.imbalance;
        out->completion =
            model->machine.start + out->load.seconds + model->frames * model->machine.frame;
    } else {
        weft_load_clear(&out->load);
    }
    weft_regions_destroy(&f.regions);
    free(f.seconds), free(f.bytes), free(f.order), free(w.rank);
    return good;
}

// ---- measured costs -----------------------------------------------------------------------------

// How much of cell `i` of `count` over `length` is between a and b, 0 to 1.
static double share(double a, double b, int i, int count, double length)
{
    const double cell = length / count;
    return fmax(0.0, fmin(b, (i + 1) * cell) - fmax(a, i * cell)) / cell;
}

double model_grid_cost(const void *priv, int frame, const struct weft_rectangle *r)
{
    const struct model_grid *g = priv;
    const double *seconds = g->seconds + (int64_t)frame * g->rows * g->columns;
    const int first[2] = {(int)((double)r->x * g->columns / g->width),
                          (int)((double)r->y * g->rows / g->height)};
    double sum = g->fixed;
    for (int y = first[1]; y < g->rows; y++) {
        const double down = share(r->y, (double)r->y + r->height, y, g->rows, g->height);
        if (down == 0.0 && y > first[1])
            break;
        for (int x = first[0]; x < g->columns; x++) {
            const double across = share(r->x, (double)r->x + r->width, x, g->columns, g->width);
            if (across == 0.0 && x > first[0])
                break;
            sum += fmax(0.0, seconds[y * g->columns + x] - g->fixed) * across * down;
        }
    }
    return sum;
}
