// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/pool.h"

#include <stdio.h>
#include <string.h>

enum {
    GUESS = 1 << 20,  // bytes of an answer, before the first one
    SLACK = 64 << 10, // headers differ a little from file to file
    PAGE = 4096,
    MOST_ASKED = 8, // questions about one file: another program, another size, a fresh process
};

static void keep_message(void *priv, enum weft_log_level level, const char *message)
{
    struct weft_job *job = priv;
    if (level == WEFT_LOG_ERROR)
        snprintf(job->message, sizeof job->message, "%s", message);
}

// ---- places -------------------------------------------------------------------------------------

struct place {
    int stream, room;
    bool start;        // a process, before
    size_t room_bytes; // that the room is to have
    uint64_t total;    // bytes of all rooms then
};

// Whether the process can go on with this job.
static bool is_fit(const struct weft_pool *pool, int i, const struct weft_job *job)
{
    const struct weft_stream *s = &pool->stream[i];
    return s->reader && !strcmp(s->program, job->program) && s->asked < WEFT_POOL_FILES &&
           !(job->alone && s->asked);
}

// A free room that is large enough, or else the smallest free one; -1: none is free.
static int choose_room(const struct weft_pool *pool, int i, size_t size)
{
    const struct weft_room *room = pool->stream[i].room;
    int best = -1;
    for (int r = 0; r < WEFT_WIRE_ROOMS; r++) {
        if (pool->taken[i][r])
            continue;
        if (room[r].known && room[r].size >= size)
            return r;
        if (best < 0 || room[r].size < room[best].size)
            best = r;
    }
    return best;
}

// The stream with the fewest questions, one whose process can go on rather than one that is to be
// started. -1: none.
static int choose_stream(const struct weft_pool *pool, const struct weft_job *job)
{
    int best = -1, least = 0;
    for (int i = 0; i < pool->readers; i++) {
        const bool fit = is_fit(pool, i, job);
        const int pending = pool->count[i], weight = 2 * pending + !fit;
        if (pool->closed[i] || (!fit && pending) || choose_room(pool, i, 0) < 0)
            continue;
        if (best < 0 || weight < least) {
            best = i;
            least = weight;
        }
    }
    return best;
}

static uint64_t room_bytes(const struct weft_pool *pool)
{
    uint64_t sum = 0;
    for (int i = 0; i < pool->readers; i++)
        for (int r = 0; r < WEFT_WIRE_ROOMS; r++)
            sum += pool->stream[i].room[r].size;
    return sum;
}

static bool find_place(const struct weft_pool *pool, const struct weft_job *job, bool urgent,
                       struct place *out)
{
    size_t size = job->need ? job->need : pool->usual;
    if (!size && !urgent)
        return false;
    size = size ? size : GUESS;
    const int i = choose_stream(pool, job);
    if (i < 0)
        return false;
    const int r = choose_room(pool, i, size);
    const struct weft_room *room = &pool->stream[i].room[r];
    const bool start = !is_fit(pool, i, job), keeps = !start && room->known && room->size >= size;
    *out = (struct place){.stream = i, .room = r, .start = start, .total = room_bytes(pool)};
    out->room_bytes = keeps ? room->size : (size + SLACK + PAGE - 1) / PAGE * PAGE;
    out->total += out->room_bytes - room->size;
    return urgent || out->total <= pool->memory_bytes;
}

bool weft_pool_has_place(const struct weft_pool *pool, const struct weft_job *job, bool urgent)
{
    struct place place;
    return find_place(pool, job, urgent, &place);
}

// Processes that have nothing to do give their memory back.
static void trim(struct weft_pool *pool)
{
    for (int i = 0; i < pool->readers; i++) {
        bool idle = !pool->count[i];
        for (int r = 0; r < WEFT_WIRE_ROOMS; r++)
            idle &= !pool->taken[i][r];
        if (idle)
            weft_stream_clear(&pool->stream[i]);
    }
}

static bool others_run(const struct weft_pool *pool, int i)
{
    for (int k = 0; k < pool->readers; k++)
        if (k != i && pool->stream[k].reader)
            return true;
    return false;
}

// Where descriptors or processes run out, those that run are enough.
static enum weft_result start_process(struct weft_pool *pool, int i, const char *program)
{
    const bool spare = others_run(pool, i);
    const enum weft_result res = weft_stream_start(&pool->stream[i], spare ? NULL : pool->log,
                                                   program, &pool->limits, WEFT_POOL_FILES);
    pool->process[i] = ++pool->started;
    if (res == WEFT_OK || !spare)
        return res;
    pool->closed[i] = true;
    return WEFT_OK;
}

static enum weft_result ask(struct weft_pool *pool, struct weft_job *job, int fd,
                            const struct place *place)
{
    const int i = place->stream;
    struct weft_wire_request request = {
        .part = job->part,
        .threads = place->room_bytes > pool->memory_bytes ? (uint32_t)pool->readers : 1,
        .room = (uint32_t)place->room,
        .room_bytes = place->room_bytes,
        .info_only = job->info_only};
    const enum weft_result res =
        weft_stream_ask(&pool->stream[i], pool->log, &request, fd, job->path);
    if (res != WEFT_OK)
        return res;
    pool->asked[i][pool->count[i]++] = job;
    pool->taken[i][place->room] = true;
    job->state = WEFT_JOB_PLACED;
    job->other_program = false;
    job->asked++;
    job->stream = i;
    job->room = place->room;
    job->process = pool->process[i];
    return WEFT_OK;
}

enum weft_result weft_pool_place(struct weft_pool *pool, struct weft_job *job, int fd, bool urgent)
{
    struct place place;
    if (find_place(pool, job, urgent, &place) && place.total > pool->memory_bytes)
        trim(pool);
    while (find_place(pool, job, urgent, &place)) {
        if (!place.start)
            return ask(pool, job, fd, &place);
        const enum weft_result res = start_process(pool, place.stream, job->program);
        if (res != WEFT_OK)
            return res;
    }
    return WEFT_OK;
}

// ---- answers ------------------------------------------------------------------------------------

void weft_pool_release(struct weft_pool *pool, struct weft_job *job)
{
    pool->taken[job->stream][job->room] = false;
    job->data = NULL;
}

static void try_again(struct weft_pool *pool, struct weft_job *job)
{
    weft_pool_release(pool, job);
    job->state = WEFT_JOB_NEW;
    job->message[0] = '\0';
}

static void give_up(struct weft_pool *pool, struct weft_job *job, enum weft_result why)
{
    weft_pool_release(pool, job);
    job->state = WEFT_JOB_FAILED;
    job->result = why;
}

// What became of it may be the doing of files before.
static void blame(struct weft_pool *pool, struct weft_job *job, enum weft_result why)
{
    if (job->first) {
        give_up(pool, job, why);
    } else {
        try_again(pool, job);
        job->alone = true;
    }
}

// What it was still to do is for others.
static void end_process(struct weft_pool *pool, int i)
{
    weft_stream_stop(&pool->stream[i]);
    for (int k = 0; k < pool->count[i]; k++)
        try_again(pool, pool->asked[i][k]);
    pool->count[i] = 0;
}

void weft_pool_refuse(struct weft_pool *pool, struct weft_job *job)
{
    if (pool->process[job->stream] == job->process)
        end_process(pool, job->stream);
    snprintf(job->message, sizeof job->message, "%.800s: the answer of %s contradicts itself",
             job->path, job->program);
    blame(pool, job, WEFT_ERR_READER);
}

static void take_given(struct weft_pool *pool, struct weft_job *job,
                       const struct weft_wire_answer *answer)
{
    const struct weft_room *room = &pool->stream[job->stream].room[job->room];
    const bool needs = answer->verdict == WEFT_WIRE_NO_ROOM;
    const uint64_t size = needs ? answer->count[0] : answer->payload_bytes;
    if (answer->verdict == WEFT_WIRE_OTHER_PROGRAM && job->asked < MOST_ASKED) {
        try_again(pool, job);
        job->other_program = true;
    } else if (needs && size > room->size && job->asked < MOST_ASKED) {
        try_again(pool, job);
        pool->usual = job->need = size;
    } else if (answer->verdict == WEFT_WIRE_GIVEN && size <= room->size) {
        job->state = WEFT_JOB_GIVEN;
        job->data = room->data;
        pool->usual = job->size = size;
    } else {
        weft_pool_refuse(pool, job);
    }
}

static void take_answer(struct weft_pool *pool, int i)
{
    struct weft_stream *stream = &pool->stream[i];
    struct weft_job *job = pool->asked[i][0];
    const struct weft_log log = {keep_message, job};
    struct weft_wire_answer answer;
    memmove(pool->asked[i], pool->asked[i] + 1, (size_t)--pool->count[i] * sizeof job);
    job->first = stream->answered == 0;
    const enum weft_result res = weft_stream_answer(stream, &log, &answer);
    if (!stream->reader)
        end_process(pool, i);
    if (res == WEFT_OK)
        take_given(pool, job, &answer);
    else if (!stream->reader || res == WEFT_ERR_LIMIT || res == WEFT_ERR_MEMORY)
        blame(pool, job, res);
    else
        give_up(pool, job, res);
}

void weft_pool_wait(struct weft_pool *pool, double seconds)
{
    bool ready[WEFT_POOL_STREAMS];
    if (!weft_streams_wait(pool->stream, pool->readers, seconds, ready))
        return;
    for (int i = 0; i < pool->readers; i++)
        if (ready[i] && pool->count[i])
            take_answer(pool, i);
}

void weft_pool_clear(struct weft_pool *pool)
{
    for (int i = 0; i < pool->readers; i++)
        weft_stream_clear(&pool->stream[i]);
}
