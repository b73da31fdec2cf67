// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/load_report.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/draw/plot.h"

static int64_t count_items(const struct weft_load *load)
{
    int64_t items = 0;
    for (int i = 0; i < load->ranks; i++)
        items += load->rank[i].items;
    return items;
}

// Clocks of ranks are read at different moments: what is left may be a little less than nothing.
static double find_idle(const struct weft_load *load, int rank)
{
    return fmax(load->seconds - load->rank[rank].busy - load->rank[rank].taking, 0.0);
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *json_of_rank(const struct weft_load *load, int rank)
{
    const struct weft_rank_load *r = &load->rank[rank];
    return json_pack("{s:i, s:o, s:i, s:f, s:f, s:f, s:I, s:o}", "rank", rank, "host",
                     json_text(r->host), "threads", r->threads, "busy", r->busy, "idle",
                     find_idle(load, rank), "taking", r->taking, "items", (json_int_t)r->items,
                     "bytes", run_report_bytes("sent", r->bytes));
}

static void add_items(const struct weft_items_report *work, json_t *root)
{
    json_t *seconds = json_array(), *rank = json_array();
    for (int64_t i = 0; i < work->count; i++) {
        json_array_append_new(seconds, json_number(work->item_seconds[i]));
        json_array_append_new(rank, json_integer(work->item_rank[i]));
    }
    json_object_set_new(root, "item_seconds", seconds);
    json_object_set_new(root, "item_rank", rank);
}

json_t *load_report_json(const struct weft_items_report *work, bool items)
{
    const struct weft_load *load = &work->load;
    if (!load->ranks)
        return NULL;
    struct weft_load_figures figures;
    weft_load_compute(load, &figures);
    json_t *each = json_array();
    for (int i = 0; i < load->ranks; i++)
        json_array_append_new(each, json_of_rank(load, i));
    json_t *root = json_pack(
        "{s:i, s:s, s:I, s:o, s:o, s:o, s:o}", "count", load->ranks, "schedule",
        weft_schedule_names[work->schedule], "items", (json_int_t)count_items(load), "seconds",
        run_report_total_seconds(load->seconds), "idle_share", json_number(figures.idle_share),
        "imbalance", json_number(figures.imbalance), "each", each);
    if (root && items)
        add_items(work, root);
    return root;
}

// ---- text ---------------------------------------------------------------------------------------

// "2 ranks of 1 thread", "2 ranks of 1 to 4 threads".
static void describe_ranks(const struct weft_load *load, char *out, size_t size)
{
    int least = load->rank[0].threads, most = least;
    char range[32] = "";
    for (int i = 1; i < load->ranks; i++) {
        const int threads = load->rank[i].threads;
        least = threads < least ? threads : least;
        most = threads > most ? threads : most;
    }
    if (least < most)
        snprintf(range, sizeof range, "%d to ", least);
    snprintf(out, size, "%d rank%s of %s%d thread%s", load->ranks, load->ranks == 1 ? "" : "s",
             range, most, most == 1 ? "" : "s");
}

static void print_rank(const struct weft_load *load, int rank)
{
    const struct weft_rank_load *r = &load->rank[rank];
    report_note("rank %d (%s): %" PRId64 " items, busy %.3g s, taking %.3g s, idle %.3g s, %" PRIu64
                " bytes sent",
                rank, r->host, r->items, r->busy, r->taking, find_idle(load, rank), r->bytes);
}

void load_report_print(const struct weft_items_report *work)
{
    const struct weft_load *load = &work->load;
    if (!load->ranks)
        return;
    struct weft_load_figures figures;
    weft_load_compute(load, &figures);
    char ranks[64];
    describe_ranks(load, ranks, sizeof ranks);
    void (*tell)(const char *, ...) = load->ranks > 1 ? report_tell : report_note;
    tell("%s, %s: %" PRId64 " items in %.3g s, idle %.1f %%, busiest / mean %.2f", ranks,
         weft_schedule_names[work->schedule], count_items(load), load->seconds,
         100.0 * figures.idle_share, figures.imbalance);
    for (int i = 0; i < load->ranks; i++)
        print_rank(load, i);
}

// ---- chart --------------------------------------------------------------------------------------

enum { WIDTH = 960, HEIGHT = 480, MOST_LABELS = 24, LEAST_PLACES = 6 };

// A failure that is told has the exit code of its result.
static enum weft_result result_of(enum exit_code code)
{
    return code == EXIT_CODE_DONE     ? WEFT_OK
           : code == EXIT_CODE_USAGE  ? WEFT_ERR_ARGUMENT
           : code == EXIT_CODE_OUTPUT ? WEFT_ERR_WRITE
                                      : WEFT_ERR_MEMORY;
}

enum weft_result load_report_check_plot(const char *path)
{
    return result_of(plot_check("--load-chart", path, "--json"));
}

static int count_hosts(const struct weft_load *load)
{
    int hosts = 0;
    for (int i = 0; i < load->ranks; i++) {
        int j = 0;
        while (strcmp(load->rank[j].host, load->rank[i].host) != 0)
            j++;
        hosts += j == i;
    }
    return hosts;
}

static void write_title(FILE *s, const struct weft_items_report *work, double mean)
{
    const struct weft_load *load = &work->load;
    struct weft_load_figures figures;
    weft_load_compute(load, &figures);
    char ranks[64], title[256];
    describe_ranks(load, ranks, sizeof ranks);
    snprintf(title, sizeof title, "%s, %s: %" PRId64 " items in %.3g s", ranks,
             weft_schedule_names[work->schedule], count_items(load), load->seconds);
    fputs("set label 1 ", s);
    plot_quote(s, title);
    fputs(" at graph 0,1.11 left font 'sans,15'\n", s);
    snprintf(title, sizeof title,
             "busy on average %.3g s; idle %.1f %% (1 - busy / all); busiest / mean %.2f", mean,
             100.0 * figures.idle_share, figures.imbalance);
    fputs("set label 2 ", s);
    plot_quote(s, title);
    fputs(" at graph 0,1.045 left\n", s);
}

// Few ranks have bars no wider than a sixth of the chart; of many not every one has its number.
static void write_axes(FILE *s, const struct weft_load *load)
{
    const int places = load->ranks < LEAST_PLACES ? LEAST_PLACES : load->ranks;
    const double middle = 0.5 * (load->ranks - 1);
    int step = 1;
    for (int i = 0; load->ranks > step * MOST_LABELS; i++) // 1, 2, 5, 10...
        step = i % 3 == 1 ? step / 2 * 5 : step * 2;
    fprintf(s, "set xrange [%.9g:%.9g]\nset yrange [0:%.9g]\nset format y '%%g'\n",
            middle - 0.5 * places, middle + 0.5 * places,
            load->seconds > 0.0 ? 1.02 * load->seconds : 1.0);
    fputs("set xtics out nomirror (", s);
    for (int i = 0; i < load->ranks; i += step)
        fprintf(s, "%s%d", i ? ", " : "", i);
    fputs(")\nset grid noxtics\nset ylabel 'seconds'\nset xlabel ", s);
    const int hosts = count_hosts(load);
    char label[128];
    if (hosts == 1)
        snprintf(label, sizeof label, "rank (all on %s)", load->rank[0].host);
    else
        snprintf(label, sizeof label, "rank (on %d nodes)", hosts);
    plot_quote(s, label);
    putc('\n', s);
}

// The end of each part: of what is busy, of what takes results, of all.
static void write_bars(FILE *s, const struct weft_load *load)
{
    fputs("$load << EOD\n", s);
    for (int i = 0; i < load->ranks; i++) {
        const struct weft_rank_load *r = &load->rank[i];
        const double taken = r->busy + r->taking;
        fprintf(s, "%d %.9g %.9g %.9g\n", i, r->busy, taken, taken + find_idle(load, i));
    }
    fputs("EOD\n", s);
}

static void write_chart(FILE *s, const struct weft_items_report *work)
{
    const struct weft_load *load = &work->load;
    struct weft_load_figures figures;
    weft_load_compute(load, &figures);
    write_bars(s, load);
    write_title(s, work, figures.mean_busy);
    write_axes(s, load);
    fprintf(s,
            "set tmargin 5\nset rmargin 20\nset key at graph 1.02,1 left top Left reverse samplen "
            "1.5 spacing 1.3\nset style fill solid 1 noborder\nset boxwidth %g\n"
            "plot $load using 1:4 with boxes lc '#d9d9d9' title 'idle', "
            "$load using 1:3 with boxes lc '#e8a000' title 'taking results', "
            "$load using 1:2 with boxes lc '#2171d5' title 'busy', "
            "%.9g with lines lc '#08306b' lw 1.5 dt 2 title 'busy on average'\n",
            load->ranks > 4 * MOST_LABELS ? 1.0 : 0.8, figures.mean_busy);
}

enum weft_result load_report_plot(const struct weft_items_report *work, const char *path)
{
    struct plot plot;
    enum exit_code code = plot_begin(path, WIDTH, HEIGHT, &plot);
    if (code != EXIT_CODE_DONE)
        return result_of(code);
    write_chart(plot.script, work);
    return result_of(plot_finish(&plot));
}
