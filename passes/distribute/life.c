// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/life.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

// Between signs. Of a longer time between two looks this much counts as silence: this process was
// not awake then.
static const double period = 0.1, longest_look = 0.25;

void weft_life_init(struct weft_life *life, struct weft_talk *talk, double now)
{
    const int rank = talk->transport->rank, size = talk->transport->size;
    talk->watched = (rank + size - 1) % size;
    *life = (struct weft_life){
        .talk = talk,
        .next = (rank + 1) % size,
        .looked = now,
        .told = now - period,
    };
}

void weft_life_hear(struct weft_life *life, int from, const struct weft_incoming *in)
{
    if (from != life->talk->watched)
        return;
    if (in->head.kind == WEFT_MESSAGE_LAST)
        life->ended = true;
    if (in->head.kind == WEFT_MESSAGE_ALIVE && in->data && in->head.size < sizeof life->host) {
        life->process = (long)in->head.item;
        memcpy(life->host, in->data, (size_t)in->head.size);
        life->host[in->head.size] = '\0';
    }
}

static void tell(struct weft_life *life)
{
    const char *host = life->talk->transport->host;
    size_t length = host ? strlen(host) : 0;
    if (length >= sizeof life->host)
        length = sizeof life->host - 1;
    const struct weft_head head = {
        .kind = WEFT_MESSAGE_ALIVE, .item = (int64_t)getpid(), .size = length};
    weft_talk_post(life->talk, &life->message, life->next, &head, host, NULL);
}

bool weft_life_step(struct weft_life *life, double now, double timeout, bool silent)
{
    if (!silent && !life->message.busy && now - life->told >= period) {
        life->told = now;
        tell(life);
    }
    const double passed = now - life->looked;
    life->looked = now;
    life->silence = life->talk->heard ? 0.0 : life->silence + fmin(passed, longest_look);
    life->talk->heard = false;
    return !life->ended && life->silence > timeout;
}
