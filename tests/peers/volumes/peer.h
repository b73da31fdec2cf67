// SPDX-License-Identifier: BSD-3-Clause
// tests/peers/volumes/peer.h - what the programs that run a peer share (C and C++; peer.py is
// the same for Python). bench_peers starts each and talks to it in lines:
//   in  "job FD sx sy sz width height threads  ox oy oz  ux uy uz  vx vy vz"
//   out "ready VERSION", or "skip REASON" and the end
//   in  "run"     out "SECONDS", or "SECONDS AGAIN", AGAIN with all ready that a first run makes
//   in  "pixels"  out width * height floats, raw
// and closes its end when done. FD is an open file of sx * sy * sz floats, x fastest; pixel (x, y)
// lies at o + x u + y v in index space. Everything before "ready" is set-up and not timed. With
// WEFT_PEER_OUTPUTS=all in the environment a run makes the value, the gradient and the Hessian of
// every pixel, 10 planes, of which "pixels" are the first.
#ifndef WEFT_TESTS_PEERS_PEER_H
#define WEFT_TESTS_PEERS_PEER_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { PEER_MAX_THREADS = 64 };

struct peer_job {
    int size[3], width, height, threads, outputs; // 1 or 10
    double origin[3], du[3], dv[3];
    float *box, *pixels; // owned, [output][y][x]; a peer that keeps the voxels in its own form
                         // frees the box
};

// Ends the program so that the peer's row in the table says why.
static inline void peer_skip(const char *reason)
{
    printf("skip %s\n", reason);
    fflush(stdout);
    exit(77);
}

static inline void peer_read_box(int fd, void *to, size_t bytes)
{
    for (size_t done = 0; done < bytes;) {
        ssize_t got = pread(fd, (char *)to + done, bytes - done, (off_t)done);
        if (got <= 0)
            peer_skip("the voxels cannot be read");
        done += (size_t)got;
    }
}

static inline void peer_load(struct peer_job *job)
{
    char line[1024];
    int fd = -1;
    if (!fgets(line, sizeof line, stdin))
        exit(1);
    int fields =
        sscanf(line, "job %d %d %d %d %d %d %d %lf %lf %lf %lf %lf %lf %lf %lf %lf", &fd,
               &job->size[0], &job->size[1], &job->size[2], &job->width, &job->height,
               &job->threads, &job->origin[0], &job->origin[1], &job->origin[2], &job->du[0],
               &job->du[1], &job->du[2], &job->dv[0], &job->dv[1], &job->dv[2]);
    if (fields != 16 || job->threads < 1 || job->threads > PEER_MAX_THREADS)
        peer_skip("bad job");
    size_t voxels = (size_t)job->size[0] * (size_t)job->size[1] * (size_t)job->size[2];
    job->box = (float *)malloc(voxels * sizeof(float));
    const char *outputs = getenv("WEFT_PEER_OUTPUTS");
    job->outputs = outputs && strcmp(outputs, "all") == 0 ? 10 : 1;
    job->pixels = (float *)calloc((size_t)job->outputs * (size_t)job->width * (size_t)job->height,
                                  sizeof(float));
    if (!job->box || !job->pixels)
        peer_skip("out of memory");
    peer_read_box(fd, job->box, voxels * sizeof(float));
}

static inline double peer_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline double peer_time(void (*run)(void *priv), void *priv)
{
    const double start = peer_seconds();
    run(priv);
    return peer_seconds() - start;
}

// Answers until the other end closes. Both fill job->pixels; `again` is NULL where there is none.
static inline int peer_serve(struct peer_job *job, const char *version, void (*run)(void *priv),
                             void (*again)(void *priv), void *priv)
{
    char line[64];
    printf("ready %s\n", version);
    fflush(stdout);
    while (fgets(line, sizeof line, stdin)) {
        if (strcmp(line, "run\n") == 0) {
            printf("%.9f", peer_time(run, priv));
            if (again)
                printf(" %.9f", peer_time(again, priv));
            printf("\n");
        } else if (strcmp(line, "pixels\n") == 0) {
            fwrite(job->pixels, sizeof(float), (size_t)job->width * (size_t)job->height, stdout);
        }
        fflush(stdout);
    }
    free(job->box);
    free(job->pixels);
    return 0;
}

// One row by one thread; rows y, y + threads, ... go to the same one.
typedef void (*peer_row_fn)(void *priv, int thread, int y);

struct peer_worker {
    const struct peer_job *job;
    peer_row_fn row;
    void *priv;
    int thread;
};

static inline void *peer_work(void *priv)
{
    const struct peer_worker *worker = (const struct peer_worker *)priv;
    for (int y = worker->thread; y < worker->job->height; y += worker->job->threads)
        worker->row(worker->priv, worker->thread, y);
    return NULL;
}

static inline void peer_rows(const struct peer_job *job, peer_row_fn row, void *priv)
{
    pthread_t thread[PEER_MAX_THREADS];
    struct peer_worker worker[PEER_MAX_THREADS];
    for (int i = 0; i < job->threads; i++) {
        worker[i].job = job;
        worker[i].row = row;
        worker[i].priv = priv;
        worker[i].thread = i;
        if (pthread_create(&thread[i], NULL, peer_work, &worker[i]) != 0)
            abort();
    }
    for (int i = 0; i < job->threads; i++)
        pthread_join(thread[i], NULL);
}

#endif
