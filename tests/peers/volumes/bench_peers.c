// SPDX-License-Identifier: BSD-3-Clause
// Planar cuts by other libraries and by weft, measured in the same run: same voxels, same plane,
// their own kernels, speed beside error.
//   bench_peers [VOLUME.vdb|SIGNAL[:N]] [--plane oblique|axis] [--size WxH] [--runs N]
//               [--threads N] [--context auto|osmesa|egl] [--csv FILE] [--outputs value|all]
// Default: marschner-lobb:256, oblique, 1024x1024, 11 runs, all cores. What Debian's packages
// python3-vtk9, libteem-dev, libnanovdb-dev and python3-scipy bring is measured; what is not
// installed is named and left out.
//
// How: every peer, and weft for each kernel and engine, is a program of its own (peer.h) that loads
// the voxels into the form it likes best, and then runs when told to. Turns alternate (a peer,
// weft, the next peer, weft, ...), so that what slows the machine down slows both; ratios are taken
// pair by pair, with weft's CPU engine of the precision that the peer has, and medians printed.
// Nothing of the set-up is timed: reading voxels, laying them out, SciPy's coordinates. The first
// turn warms up.
//   ms, Mpixel/s   a whole run. weft's plans, compiles and runs a plane of a resident volume; below
//                  it stands the run of a plan that was compiled before.
//   max, RMS error |pixel - reference| in the voxels' unit, the reference being the
//   double-precision
//                  one of the peer's own kernel, at all pixels (at most 2^20, else at random) whose
//                  taps lie inside the box
//   peak MB        resident memory of the program while it ran: code, voxels and all
//   whole, again   how much faster weft is with the same taps: its whole run, or the run alone of a
//                  plan that was compiled before
// --outputs all: the value, the gradient and the Hessian of every pixel, by those that make them.
// --csv writes technique,label,seconds,bytes,max_error,rms_error. Exit code: 0, 1 (a run failed; a
// peer that is not installed is no failure), 2 (usage), 130 (interrupted).
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/peers/volumes/child.h"
#include "tests/peers/volumes/peer.h"

enum {
    MAX_RUNS = 99,
    WEFT_CATMULL_ROM_GL = 0,
    WEFT_CATMULL_ROM_HARDWARE,
    WEFT_CATMULL_ROM,
    WEFT_CATMULL_ROM_DOUBLE,
    WEFT_BSPLINE_GL,
    WEFT_BSPLINE_HARDWARE,
    WEFT_BSPLINE,
    WEFT_BSPLINE_DOUBLE,
    FIRST_PEER
};

struct peer {
    const char *label;
    enum cut_reference reference;
    int weft;            // the row that has the same taps
    const char *program; // in the build folder, or in the source folder if it ends in .py
    const char *argument;
    const char *how; // of weft: gl, hardware, or the CPU engine's sums
    bool runs;
    struct child child;
    int count; // of seconds, and of those with all ready
    double seconds[MAX_RUNS * 8], again[MAX_RUNS * 8];
    double whole_ratio[MAX_RUNS], again_ratio[MAX_RUNS];
    struct cut_error error;
    uint64_t bytes;
};

#define WEFT(text, kernel, engine, exact)                                                          \
    {                                                                                              \
        .label = text, .program = "peer_weft", .argument = kernel, .how = engine,                  \
        .reference = exact                                                                         \
    }

static struct peer peers[] = {
    WEFT("weft catmull-rom gl", "catmull-rom", "gl", CUT_CATMULL_ROM),
    WEFT("weft catmull-rom hardware", "catmull-rom", "hardware", CUT_CATMULL_ROM),
    WEFT("weft catmull-rom cpu", "catmull-rom", "float", CUT_CATMULL_ROM),
    WEFT("weft catmull-rom cpu double", "catmull-rom", "double", CUT_CATMULL_ROM),
    WEFT("weft bspline gl", "bspline", "gl", CUT_BSPLINE),
    WEFT("weft bspline hardware", "bspline", "hardware", CUT_BSPLINE),
    WEFT("weft bspline cpu", "bspline", "float", CUT_BSPLINE),
    WEFT("weft bspline cpu double", "bspline", "double", CUT_BSPLINE),
    {.label = "VTK vtkImageReslice cubic", .program = "peer_vtk.py", .weft = WEFT_CATMULL_ROM},
    {.label = "Teem gage BCCubic 0 0.5", .program = "peer_teem", .weft = WEFT_CATMULL_ROM_DOUBLE},
    {.label = "NanoVDB tri-cubic sampler", .program = "peer_nanovdb", .weft = WEFT_CATMULL_ROM},
    {.label = "NanoVDB tri-cubic sampler -ffast-math",
     .program = "peer_nanovdb_fast",
     .weft = WEFT_CATMULL_ROM},
    {.label = "SciPy map_coordinates bspline",
     .program = "peer_scipy.py",
     .argument = "samples",
     .reference = CUT_BSPLINE,
     .weft = WEFT_BSPLINE_DOUBLE},
    {.label = "SciPy map_coordinates prefiltered before",
     .program = "peer_scipy.py",
     .argument = "coefficients",
     .reference = CUT_SPLINE,
     .weft = WEFT_BSPLINE_DOUBLE},
    {.label = "SciPy map_coordinates with prefilter",
     .program = "peer_scipy.py",
     .argument = "spline",
     .reference = CUT_SPLINE,
     .weft = WEFT_BSPLINE_DOUBLE},
};

enum { PEERS = sizeof peers / sizeof peers[0] };

struct options {
    const char *source, *csv, *context;
    bool all; // outputs
    enum cut_plane plane;
    int width, height, runs, threads;
};

// Not restarted system calls: a wait for a peer ends, and then everything does.
static volatile sig_atomic_t stopped;

static void stop(int number)
{
    (void)number;
    stopped = 1;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = stop};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
}

// Whether it makes derivatives.
static bool derives(const struct peer *peer)
{
    return strcmp(peer->program, "peer_teem") == 0 ||
           (strcmp(peer->program, "peer_weft") == 0 && strcmp(peer->how, "hardware") != 0);
}

static bool start(struct peer *peer, const struct cut *cut, const struct options *options)
{
    char path[1024];
    const size_t length = strlen(peer->program);
    const bool python = length > 3 && strcmp(peer->program + length - 3, ".py") == 0;
    char *argv[7];
    int argc = 0;
    if (python) {
        argv[argc++] = (char *)WEFT_PEERS_PYTHON;
        argv[argc++] = (char *)"-B";
    }
    snprintf(path, sizeof path, "%s/%s", python ? WEFT_PEERS_SOURCE : WEFT_PEERS_BINARY,
             peer->program);
    argv[argc++] = path;
    if (peer->argument)
        argv[argc++] = (char *)peer->argument;
    if (peer->how) {
        argv[argc++] = (char *)peer->how;
        argv[argc++] = (char *)options->context;
    }
    argv[argc] = NULL;
    peer->runs = child_start(&peer->child, argv, cut, options->threads);
    return peer->runs;
}

static bool run_once(struct peer *peer, bool warm_up)
{
    if (stopped || !peer->runs)
        return false;
    double *seconds = peer->seconds + peer->count, *again = peer->again + peer->count;
    peer->runs = child_run(&peer->child, seconds, again);
    peer->count += peer->runs && !warm_up;
    return peer->runs;
}

static void take_turn(int turn)
{
    for (int i = FIRST_PEER; i < (int)PEERS && !stopped; i++) {
        struct peer *peer = &peers[i], *weft = &peers[peer->weft];
        if (!run_once(peer, false) || !run_once(weft, false))
            continue;
        peer->whole_ratio[turn] = peer->seconds[turn] / weft->seconds[weft->count - 1];
        peer->again_ratio[turn] = peer->seconds[turn] / weft->again[weft->count - 1];
    }
    for (int i = 0; i < FIRST_PEER; i++) // also where no peer is there
        run_once(&peers[i], false);
}

// Without OpenGL there are only the rows of the CPU engine.
static bool must_run(int i)
{
    return i < FIRST_PEER && strcmp(peers[i].how, "gl") != 0 &&
           strcmp(peers[i].how, "hardware") != 0;
}

// Starts all, runs each once and measures its error. false: weft itself failed.
static bool prepare(struct cut *cut, const struct options *options)
{
    const size_t count = (size_t)cut->width * (size_t)cut->height;
    float *pixels = malloc(count * sizeof *pixels);
    bool ok = pixels != NULL;
    for (int i = 0; ok && i < (int)PEERS && !stopped; i++) {
        struct peer *peer = &peers[i];
        if (options->all && !derives(peer)) {
            snprintf(peer->child.text, sizeof peer->child.text, "it makes no derivatives");
            continue;
        }
        if (start(peer, cut, options) && run_once(peer, true)) {
            peer->runs = child_pixels(&peer->child, pixels, count);
            ok = !peer->runs || cut_compare(cut, peer->reference, pixels, &peer->error);
        }
        if (!peer->runs && !stopped)
            fprintf(stderr, "%s: %s: %s\n", must_run(i) ? "failed" : "skipped", peer->label,
                    peer->child.text);
        ok = ok && (!must_run(i) || peer->runs);
    }
    free(pixels);
    return ok && !stopped;
}

// ---- results ------------------------------------------------------------------------------------

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

static void print_heading(const struct cut *cut, const struct options *options)
{
    printf("%s: %d x %d x %d voxels up to %g, %s plane, %d x %d pixels, %d threads, medians of %d "
           "turns,\nerrors at %zu pixels\n",
           cut->name, cut->size[0], cut->size[1], cut->size[2], cut->largest,
           options->plane == CUT_AXIS ? "axis" : "oblique", cut->width, cut->height,
           options->threads, options->runs, cut->checked_count);
    const char *last = "";
    for (int i = 0; i < (int)PEERS; i++) {
        const char *text = peers[i].child.text;
        if (!peers[i].runs || strcmp(last, text) == 0)
            continue;
        printf("%s%s", *last ? "; " : "", text);
        last = text;
    }
    printf("\n%-41s %-12s %8s %8s %9s %9s %7s %7s %7s\n", "", "kernel", "ms", "Mpixel/s",
           "max error", "RMS error", "peak MB", "whole", "again");
}

static void print_row(const struct cut *cut, struct peer *peer, const char *label, double seconds)
{
    printf("%-41s %-12s %8.2f %8.2f %9.2e %9.2e %7.1f", label, cut_reference_name(peer->reference),
           1e3 * seconds, 1e-6 * cut->width * cut->height / seconds, peer->error.maximum,
           peer->error.rms, 1e-6 * (double)peer->bytes);
}

// `seconds` are left sorted, hence the middle ones are the medians afterwards too.
static void print_table(const struct cut *cut, const struct options *options)
{
    print_heading(cut, options);
    for (int i = 0; i < (int)PEERS; i++) {
        struct peer *peer = &peers[i];
        if (!peer->runs) {
            printf("%-41s skipped: %s\n", peer->label, peer->child.text);
            continue;
        }
        print_row(cut, peer, peer->label, median(peer->seconds, peer->count));
        if (i >= FIRST_PEER) {
            printf(" %7.2f %7.2f\n", median(peer->whole_ratio, options->runs),
                   median(peer->again_ratio, options->runs));
        } else {
            printf("\n");
            print_row(cut, peer, "  planned and compiled before", median(peer->again, peer->count));
            printf("\n");
        }
    }
}

static bool write_csv(const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file)
        goto fail;
    fprintf(file, "technique,label,seconds,bytes,max_error,rms_error\n");
    for (int i = 0; i < (int)PEERS; i++)
        if (peers[i].runs)
            fprintf(file, "%s,%s,%.6g,%llu,%.6g,%.6g\n", i < FIRST_PEER ? "weft" : "peer",
                    peers[i].label, median(peers[i].seconds, peers[i].count),
                    (unsigned long long)peers[i].bytes, peers[i].error.maximum, peers[i].error.rms);
    const bool written = !ferror(file);
    if (fclose(file) == 0 && written)
        return true;
fail:
    fprintf(stderr, "bench_peers: %s: %s\n", path, strerror(errno));
    return false;
}

static int run(const struct options *options)
{
    struct cut cut;
    bool ok = cut_make(&cut, options->source, options->plane, options->width, options->height);
    ok = ok && prepare(&cut, options);
    for (int turn = 0; ok && turn < options->runs && !stopped; turn++)
        take_turn(turn);
    for (int i = 0; i < (int)PEERS; i++)
        if (peers[i].runs)
            peers[i].bytes = child_peak_bytes(&peers[i].child);
    for (int i = 0; i < FIRST_PEER; i++)
        ok = ok && (peers[i].runs || !must_run(i));
    ok = ok && !stopped;
    if (ok) {
        print_table(&cut, options);
        ok = !options->csv || write_csv(options->csv);
    }
    for (int i = 0; i < (int)PEERS; i++) {
        ok = ok && (peers[i].error.not_finite == 0 || !peers[i].runs);
        child_stop(&peers[i].child, stopped || !ok);
    }
    cut_clear(&cut);
    return stopped ? 130 : ok ? 0 : 1;
}

// ---- options ------------------------------------------------------------------------------------

static bool parse_number(const char *text, int max, int *out)
{
    char *end;
    long value = strtol(text, &end, 10);
    *out = (int)value;
    return *text && !*end && value >= 1 && value <= max;
}

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0;
    if (strcmp(name, "--plane") == 0) {
        o->plane = strcmp(value, "axis") == 0 ? CUT_AXIS : CUT_OBLIQUE;
        return o->plane == CUT_AXIS || strcmp(value, "oblique") == 0;
    }
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->width, &o->height, &used) == 2 && !value[used] &&
               o->width >= 1 && o->height >= 1 && o->width <= 16384 && o->height <= 16384;
    if (strcmp(name, "--runs") == 0)
        return parse_number(value, MAX_RUNS, &o->runs);
    if (strcmp(name, "--threads") == 0)
        return parse_number(value, PEER_MAX_THREADS, &o->threads);
    if (strcmp(name, "--outputs") == 0) {
        o->all = strcmp(value, "all") == 0;
        setenv("WEFT_PEER_OUTPUTS", value, 1);
        return o->all || strcmp(value, "value") == 0;
    }
    if (strcmp(name, "--context") == 0)
        o->context = value;
    else if (strcmp(name, "--csv") == 0)
        o->csv = value;
    else
        return false;
    return true;
}

static bool parse(int argc, char **argv, struct options *o)
{
    bool named = false;
    for (int i = 1; i < argc; i++) {
        if (argv[i][0] != '-' && !named) {
            o->source = argv[i];
            named = true;
        } else if (i + 1 >= argc || !parse_option(argv[i], argv[i + 1], o)) {
            return false;
        } else {
            i++;
        }
    }
    return true;
}

int main(int argc, char **argv)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    struct options options = {.source = "marschner-lobb:256",
                              .context = "auto",
                              .width = 1024,
                              .height = 1024,
                              .runs = 11,
                              .threads = cores > PEER_MAX_THREADS ? PEER_MAX_THREADS : (int)cores};
    if (!parse(argc, argv, &options)) {
        fprintf(stderr, "usage: bench_peers [VOLUME.vdb|SIGNAL[:N]] [--plane oblique|axis] "
                        "[--size WxH] [--runs N]\n                   [--threads N] "
                        "[--context auto|osmesa|egl] [--csv FILE]\n"
                        "                   [--outputs value|all]\n");
        return 2;
    }
    catch_signals();
    return run(&options);
}
