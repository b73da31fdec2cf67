// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/ranks.h"

#include <stdlib.h>
#include <string.h>

static weft_ranks *all;
static struct weft_ranks_info info = {.size = 1};

weft_ranks *ranks_get(void)
{
    return all;
}

void ranks_set(weft_ranks *ranks)
{
    all = ranks;
    info = (struct weft_ranks_info){.size = 1};
    if (ranks)
        weft_ranks_get_info(ranks, &info);
    if (info.rank)
        report_mute();
}

int ranks_rank(void)
{
    return info.rank;
}

int ranks_size(void)
{
    return info.size;
}

bool ranks_tells(void)
{
    return info.rank == 0;
}

int ranks_threads(void)
{
    return info.size > 1 ? weft_cpu_threads() : 0;
}

// Another rank's error names it, and the part that it was at. "": it has none of its own.
static void write_own_line(char line[REPORT_LINE])
{
    const char *error = report_get_error(), *part = report_get_part();
    line[0] = 0;
    if (error[0])
        snprintf(line, REPORT_LINE, "rank %d (%s): %s%s%s", info.rank, info.host, part,
                 part[0] ? ": " : "", error);
}

static void tell_failed(int rank, const char *line, const char *otherwise)
{
    report_set_part(NULL, NULL);
    if (line[0])
        report_error("%s", line);
    else
        report_error("rank %d: %s", rank, otherwise);
}

enum weft_result ranks_agree(enum weft_result result)
{
    static char told[REPORT_LINE];
    char line[REPORT_LINE] = "";
    int failed = -1;
    if (info.size == 1)
        return result;
    if (result != WEFT_OK)
        write_own_line(line);
    const enum weft_result agreed = weft_ranks_agree(all, result, line, sizeof line, &failed);
    // A failure that comes through several agreements is told once.
    if (info.rank == 0 && failed > 0 && (!line[0] || strcmp(line, told) != 0)) {
        tell_failed(failed, line, weft_result_text(agreed));
        memcpy(told, line, sizeof told);
    }
    return agreed;
}

struct last_word {
    int code;
    char line[REPORT_LINE];
};

int ranks_end(int code)
{
    struct last_word mine = {.code = code};
    struct weft_ranks_part *parts = calloc((size_t)info.size, sizeof *parts);
    if (!parts)
        return report_finish(WEFT_ERR_MEMORY);
    if (code != EXIT_CODE_DONE)
        write_own_line(mine.line);
    const enum weft_result res = weft_ranks_gather(all, &mine, sizeof mine, parts);
    for (int i = 1; res == WEFT_OK && info.rank == 0 && code == EXIT_CODE_DONE && i < info.size;
         i++) {
        const struct last_word *word = parts[i].data;
        code = word->code;
        if (code != EXIT_CODE_DONE)
            tell_failed(i, word->line, "failed");
    }
    weft_ranks_free_parts(info.size, parts);
    free(parts);
    return info.rank ? EXIT_CODE_DONE : code;
}

// What the library tells of a difference is an error or a warning, as is asked for.
static enum weft_result compare(const char *what, const char *text, bool mixed)
{
    static struct report_held held;
    report_hold(&held);
    const enum weft_result res = weft_ranks_compare(all, what, text);
    report_hold(NULL);
    for (int i = 0; i < held.count; i++) {
        if (mixed)
            report_warning("%s", held.line[i]);
        else
            report_error("%s (--mixed lets ranks differ)", held.line[i]);
    }
    held.count = 0;
    return mixed && res == WEFT_ERR_UNSUPPORTED ? WEFT_OK : res;
}

enum weft_result ranks_check_alike(const weft_context *context, bool mixed)
{
    if (info.size == 1)
        return WEFT_OK;
    const char *set = weft_instruction_set_names[weft_instruction_set_best()];
    enum weft_result res = compare("version of weft", weft_version(), mixed);
    if (res == WEFT_OK)
        res = compare("set of instructions", set, mixed);
    if (res == WEFT_OK)
        res =
            compare("renderer", context ? weft_context_get_info(context)->renderer : "CPU", mixed);
    return res;
}

enum weft_result ranks_share(void *data, size_t size)
{
    void *shared = data;
    size_t shared_size = size;
    if (info.size == 1)
        return WEFT_OK;
    const enum weft_result res = weft_ranks_share(all, &shared, &shared_size);
    if (res == WEFT_OK && info.rank) {
        memcpy(data, shared, size);
        free(shared);
    }
    return res;
}
