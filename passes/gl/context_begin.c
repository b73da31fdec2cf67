// SPDX-License-Identifier: BSD-3-Clause
// Contexts that a thread makes while its caller does something else.
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/gl/context_backend.h"

enum { MESSAGES = 16, MESSAGE_BYTES = 1024 };

struct weft_context_making {
    struct weft_context_params params; // the caller's
    bool threaded;                     // else it is made when it is waited for
    pthread_t thread;
    // Of the thread, until it is joined.
    weft_context *context;
    enum weft_result result;
    size_t message_count;
    struct {
        enum weft_log_level level;
        char text[MESSAGE_BYTES];
    } messages[MESSAGES];
};

static void keep_message(void *priv, enum weft_log_level level, const char *message)
{
    weft_context_making *m = priv;
    if (m->message_count == MESSAGES)
        return;
    m->messages[m->message_count].level = level;
    snprintf(m->messages[m->message_count++].text, MESSAGE_BYTES, "%s", message);
}

static void *make(void *priv)
{
    weft_context_making *m = priv;
    const struct weft_log log = {keep_message, m};
    const struct weft_context_params params = {.kind = m->params.kind, .log = &log};
    m->result = weft_context_create(&params, &m->context);
    if (m->context)
        m->context->log = m->params.log;
    return NULL;
}

// Signals are for the caller's threads.
static bool start_thread(weft_context_making *m)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const bool started = pthread_create(&m->thread, NULL, make, m) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

enum weft_result weft_context_begin(const struct weft_context_params *params,
                                    weft_context_making **out)
{
    *out = NULL;
    char reason[200];
    weft_context_making *m = NULL;
    enum weft_result res = weft_context_check(params);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_MEMORY;
    m = calloc(1, sizeof *m);
    if (!m) {
        weft_error(params->log, "not enough memory to make a GL context");
        goto fail;
    }
    m->params = *params;
    // A trial forks, which is nothing to do while other threads hold the loader's locks; what is a
    // caller's is used in the caller's thread.
    m->threaded = !params->egl_display && !params->caller.get_proc_address &&
                  !weft_context_trial_reason(reason, sizeof reason) && start_thread(m);
    *out = m;
    res = WEFT_OK;
fail:
    return res;
}

static void finish(weft_context_making *m)
{
    if (m->threaded)
        pthread_join(m->thread, NULL);
}

enum weft_result weft_context_await(weft_context_making **making, weft_context **out)
{
    weft_context_making *m = *making;
    *making = NULL;
    finish(m);
    if (!m->threaded)
        m->result = weft_context_create(&m->params, &m->context);
    const struct weft_log *log = m->params.log;
    for (size_t i = 0; log && log->write && i < m->message_count; i++)
        log->write(log->priv, m->messages[i].level, m->messages[i].text);
    *out = m->context;
    const enum weft_result res = m->result;
    free(m);
    return res;
}

void weft_context_abandon(weft_context_making **making)
{
    if (!making || !*making)
        return;
    finish(*making);
    weft_context_destroy(&(*making)->context);
    free(*making);
    *making = NULL;
}
