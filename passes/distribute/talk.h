// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/talk.h - messages of any size between ranks, over a transport (not installed).
// A message goes as its head, with its bytes if they are few, then its bytes in pieces. Messages to
// one rank are sent one after the other; those to different ranks do not wait for each other.
// Thread-safety: one thread, the one that talks, makes and moves; others may post.
#ifndef WEFT_PASSES_DISTRIBUTE_TALK_H
#define WEFT_PASSES_DISTRIBUTE_TALK_H

#include <pthread.h>

#include "passes/distribute/transport.h"

enum weft_message_kind {
    WEFT_MESSAGE_UP,      // to rank 0, of what all do together; code: what that is
    WEFT_MESSAGE_DOWN,    // from rank 0, likewise
    WEFT_MESSAGE_ASK,     // for an item
    WEFT_MESSAGE_RESULT,  // of an item
    WEFT_MESSAGE_CONTROL, // an item, or that results were taken, or that work ends
    WEFT_MESSAGE_ALIVE,   // to the next rank; item: the process, bytes: the node
    WEFT_MESSAGE_BYE,     // to rank 0: the body has ended
    WEFT_MESSAGE_END,     // from rank 0: all bodies have ended
    WEFT_MESSAGE_LAST,    // to the next rank: nothing follows
    WEFT_MESSAGE_KINDS
};

struct weft_head {
    int32_t kind, code;
    int64_t item;
    uint64_t size;     // bytes that follow
    uint64_t value[2]; // as the kind has them
};

enum { WEFT_FEW_BYTES = 192, WEFT_PIECES_UNDER_WAY = 4 };

// What is sent first of a message.
struct weft_first {
    struct weft_head head;
    char bytes[WEFT_FEW_BYTES];
};

// A message to be sent: where it lies is the sender's. Members are set by weft_talk_post.
struct weft_outgoing {
    bool busy; // waits or is under way; under the lock
    int to;
    struct weft_first first;
    const char *data; // what does not fit there: stays until it is not busy
    void *owned;      // freed once it was sent; may be NULL
    size_t begun;     // bytes of data
    bool begun_first;
    int pieces; // under way
    void *request[WEFT_PIECES_UNDER_WAY];
    struct weft_outgoing *next;
};

// A message that has come; bytes are allocated, and NULL where there are none or `lost` says that
// there was no memory for them.
struct weft_incoming {
    struct weft_head head;
    char *data;
    size_t filled;
    bool open, lost;
};

struct weft_messages {
    struct weft_outgoing *first, *last;
};

struct weft_talk {
    const struct weft_transport *transport;
    // Gets each message that has come, with the lock; in->data is taken over by setting it NULL,
    // else freed.
    void (*deliver)(void *priv, int from, struct weft_incoming *in);
    void *priv;
    pthread_mutex_t *lock;       // borrowed
    struct weft_messages posted; // under the lock
    bool stirred; // likewise: a message that is no sign of life was posted or came; reset by who
                  // looks

    // Of the thread that talks.
    struct weft_incoming *in;  // [size]
    struct weft_messages *out; // [size]
    int to_send;               // messages there
    int open;                  // messages that have come in part
    char *scratch;             // for pieces that there is no memory for
    int watched;               // a rank
    bool heard;                // something came of it; reset by who looks
    char fault[160];           // why the job must end: what could not be sent, or else; else empty
};

// Returns WEFT_ERR_MEMORY; what was made then is freed by weft_talk_clear.
enum weft_result weft_talk_init(struct weft_talk *talk, const struct weft_transport *transport);
void weft_talk_clear(struct weft_talk *talk); // what is under way is given up

// Puts a message at the end of those to a rank; with the lock. head->size bytes of data are
// borrowed until it is not busy any more, unless they are few; `owned` is taken over.
void weft_talk_post(struct weft_talk *talk, struct weft_outgoing *message, int to,
                    const struct weft_head *head, const void *data, void *owned);

// Sends and takes what goes without waiting; without the lock. Returns whether anything moved.
bool weft_talk_move(struct weft_talk *talk);
// Whether a message is under way, to this rank or from it.
bool weft_talk_is_under_way(const struct weft_talk *talk);
// Whether all that was posted was sent; with the lock.
bool weft_talk_is_done(const struct weft_talk *talk);

#endif
