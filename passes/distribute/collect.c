// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Every one of them goes up to rank 0 and down again, so that no rank runs ahead by more than one
// letter.

// Rank 0: waits for plain letters of all; the first result that is not WEFT_OK.
static enum weft_result hear_all(struct weft_ranks *ranks, enum weft_step step)
{
    enum weft_result res = WEFT_OK;
    for (int r = 1; r < ranks->info.size; r++) {
        struct weft_incoming in;
        if (!weft_ranks_await_up(ranks, r, step, &in))
            return WEFT_RANKS_LOST;
        free(in.data);
        res = res == WEFT_OK ? (enum weft_result)in.head.code : res;
    }
    return res;
}

// ---- share --------------------------------------------------------------------------------------

// All are asked first whether they are there: then none has a letter yet that it has not read.
static enum weft_result share_from(struct weft_ranks *ranks, const void *data, size_t size)
{
    const struct weft_head head = {.size = size};
    enum weft_result res = hear_all(ranks, WEFT_STEP_SHARE);
    if (res != WEFT_OK)
        return res;
    for (int r = 1; r < ranks->info.size; r++)
        weft_ranks_send_down(ranks, r, WEFT_STEP_SHARE, &head, data);
    res = weft_ranks_await_sent(ranks) ? hear_all(ranks, WEFT_STEP_SHARE) : WEFT_RANKS_LOST;
    return weft_ranks_conclude(ranks, WEFT_STEP_SHARE, res, -1);
}

static enum weft_result share_to(struct weft_ranks *ranks, void **data, size_t *size)
{
    struct weft_incoming in;
    struct weft_head head = {0};
    weft_ranks_send_up(ranks, WEFT_STEP_SHARE, &head, NULL);
    if (!weft_ranks_await_down(ranks, WEFT_STEP_SHARE, &in))
        return WEFT_RANKS_LOST;
    head.code = in.lost ? WEFT_ERR_MEMORY : WEFT_OK;
    weft_ranks_send_up(ranks, WEFT_STEP_SHARE, &head, NULL);
    const enum weft_result res = weft_ranks_hear(ranks, WEFT_STEP_SHARE, NULL);
    if (res == WEFT_OK) {
        *data = in.data;
        *size = (size_t)in.head.size;
    } else {
        free(in.data);
    }
    return res;
}

enum weft_result weft_ranks_share(weft_ranks *ranks, void **data, size_t *size)
{
    if (!ranks->together)
        return WEFT_OK;
    const enum weft_result res =
        ranks->info.rank == 0 ? share_from(ranks, *data, *size) : share_to(ranks, data, size);
    if (res == WEFT_ERR_MEMORY)
        weft_error(ranks->params.log, "out of memory: what rank 0 gives to all");
    return res;
}

// ---- gather -------------------------------------------------------------------------------------

static enum weft_result copy_own(const void *data, size_t size, struct weft_ranks_part *out)
{
    *out = (struct weft_ranks_part){.data = size > 0 ? malloc(size) : NULL, .size = size};
    if (size == 0)
        return WEFT_OK;
    if (!out->data)
        return WEFT_ERR_MEMORY;
    memcpy(out->data, data, size);
    return WEFT_OK;
}

static enum weft_result gather_others(struct weft_ranks *ranks, struct weft_ranks_part *parts)
{
    enum weft_result res = WEFT_OK;
    for (int r = 1; r < ranks->info.size; r++) {
        struct weft_incoming in;
        if (!weft_ranks_await_up(ranks, r, WEFT_STEP_GATHER, &in))
            return WEFT_RANKS_LOST;
        parts[r] = (struct weft_ranks_part){.data = in.data, .size = (size_t)in.head.size};
        res = in.lost ? WEFT_ERR_MEMORY : res;
    }
    return res;
}

enum weft_result weft_ranks_gather(weft_ranks *ranks, const void *data, size_t size,
                                   struct weft_ranks_part *parts)
{
    if (ranks->info.rank != 0) {
        weft_ranks_send_up(ranks, WEFT_STEP_GATHER, &(struct weft_head){.size = size}, data);
        return weft_ranks_hear(ranks, WEFT_STEP_GATHER, NULL);
    }
    for (int r = 0; r < ranks->info.size; r++)
        parts[r] = (struct weft_ranks_part){0};
    const enum weft_result own = copy_own(data, size, &parts[0]);
    enum weft_result res = gather_others(ranks, parts);
    res = weft_ranks_conclude(ranks, WEFT_STEP_GATHER, res == WEFT_OK ? own : res, -1);
    if (res != WEFT_OK)
        weft_ranks_free_parts(ranks->info.size, parts);
    if (res == WEFT_ERR_MEMORY)
        weft_error(ranks->params.log, "out of memory: what rank 0 gathers of all");
    return res;
}

void weft_ranks_free_parts(int count, struct weft_ranks_part *parts)
{
    for (int i = 0; i < count; i++) {
        free(parts[i].data);
        parts[i] = (struct weft_ranks_part){0};
    }
}

// ---- agree --------------------------------------------------------------------------------------

static enum weft_result judge(struct weft_ranks *ranks, enum weft_result own, char *line,
                              size_t size, int *failed)
{
    enum weft_result res = own;
    bool has_line = own != WEFT_OK && line[0];
    *failed = own == WEFT_OK ? -1 : 0;
    for (int r = 1; r < ranks->info.size; r++) {
        struct weft_incoming in;
        if (!weft_ranks_await_up(ranks, r, WEFT_STEP_AGREE, &in))
            return WEFT_RANKS_LOST;
        if (in.head.code != WEFT_OK && (res == WEFT_OK || (!has_line && in.data))) {
            res = (enum weft_result)in.head.code;
            *failed = r;
            has_line = in.data;
            (void)snprintf(line, size, "%.*s", (int)in.head.size, in.data ? in.data : "");
        }
        free(in.data);
    }
    return res;
}

enum weft_result weft_ranks_agree(weft_ranks *ranks, enum weft_result result, char *line,
                                  size_t size, int *failed)
{
    int first = result == WEFT_OK ? -1 : 0;
    enum weft_result res = result;
    if (ranks->info.rank == 0) {
        res = judge(ranks, result, line, size, &first);
        res = weft_ranks_conclude(ranks, WEFT_STEP_AGREE, res, first);
    } else {
        const size_t length = result == WEFT_OK ? 0 : strnlen(line, size);
        const struct weft_head head = {.code = (int32_t)result, .size = length};
        weft_ranks_send_up(ranks, WEFT_STEP_AGREE, &head, line);
        res = weft_ranks_hear(ranks, WEFT_STEP_AGREE, &first);
    }
    if (failed)
        *failed = first;
    return res;
}

// ---- compare ------------------------------------------------------------------------------------

static enum weft_result compare_all(struct weft_ranks *ranks, const char *what, const char *text)
{
    enum weft_result res = WEFT_OK;
    for (int r = 1; r < ranks->info.size; r++) {
        struct weft_incoming in;
        if (!weft_ranks_await_up(ranks, r, WEFT_STEP_COMPARE, &in))
            return WEFT_RANKS_LOST;
        const size_t size = (size_t)in.head.size;
        const bool same =
            !in.lost && size == strlen(text) && memcmp(in.data ? in.data : "", text, size) == 0;
        if (!same && res == WEFT_OK)
            weft_error(ranks->params.log,
                       "%s of rank %d on %s is '%.*s', of rank 0 on %s it is '%s'", what, r,
                       ranks->hosts[r], (int)(in.data ? size : 0), in.data ? in.data : "",
                       ranks->info.host, text);
        free(in.data);
        res = same ? res : WEFT_ERR_UNSUPPORTED;
    }
    return res;
}

enum weft_result weft_ranks_compare(weft_ranks *ranks, const char *what, const char *text)
{
    if (ranks->info.rank == 0)
        return weft_ranks_conclude(ranks, WEFT_STEP_COMPARE, compare_all(ranks, what, text), -1);
    const struct weft_head head = {.size = strlen(text)};
    weft_ranks_send_up(ranks, WEFT_STEP_COMPARE, &head, text);
    return weft_ranks_hear(ranks, WEFT_STEP_COMPARE, NULL);
}
