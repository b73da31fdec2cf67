// SPDX-License-Identifier: BSD-3-Clause
// In the place of weft-read-png: the letter behind a file's signature says how it misbehaves.
#include <string.h>
#include <unistd.h>

#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"

struct payload {
    struct weft_wire_frame frame;
    struct weft_wire_image image;
    struct weft_wire_channel channel;
    char attributes;
};

// A grey image of 2 x 2 pixels: 1, 2, 3, 4.
static void make_good(struct payload *p, char *codes)
{
    memset(p, 0, sizeof *p);
    p->frame = (struct weft_wire_frame){.info_bytes = offsetof(struct payload, attributes) + 1 -
                                                      offsetof(struct payload, image),
                                        .bits = 8};
    p->image = (struct weft_wire_image){.width = 2,
                                        .height = 2,
                                        .display_max = {1, 1},
                                        .part_count = 1,
                                        .channel_count = 1,
                                        .header_bytes = 1};
    p->channel =
        (struct weft_wire_channel){.name = "Y", .type = WEFT_PIXEL_UNORM8, .sampling = {1, 1}};
    memcpy(codes, "\1\2\3\4", 4);
}

static void lie(struct weft_server *server, char how, struct payload *p)
{
    switch (how) {
    case 'a':
        p->frame.planes_offset += 64;
        break;
    case 'b':
        p->frame.planes_offset = UINT64_MAX - 63;
        break;
    case 'c':
        p->frame.info_bytes = UINT64_MAX;
        break;
    case 'd':
        p->image.channel_count = INT16_MAX;
        break;
    case 'e':
        p->image.width = INT32_MAX;
        break;
    case 'f':
        p->frame.bits = 3;
        break;
    case 'g':
        p->channel.type = 99;
        break;
    case 'h':
        memset(p->channel.name, 'x', sizeof p->channel.name);
        break;
    case 'i':
        server->answer.payload_bytes = UINT64_MAX;
        break;
    case 'j':
        server->answer.verdict = WEFT_WIRE_NO_ROOM;
        server->answer.count[0] = 1;
        break;
    case 'k':
        server->answer.verdict = WEFT_WIRE_NO_ROOM;
        server->answer.count[0] = UINT64_MAX;
        break;
    case 'l':
        server->answer.verdict = WEFT_WIRE_OTHER_PROGRAM;
        break;
    case 'm':
        server->answer.verdict = 77;
        break;
    case 'n':
        memset(server->answer.message, 'x', sizeof server->answer.message);
        break;
    case 'o':
        server->answer.result = 12345;
        break;
    case 'p':
        _exit(9);
    case 'q':
        __builtin_trap();
    case 'r':
        pause();
        break;
    case 's':
        p->frame.gamma = __builtin_nan("");
        break;
    case 't': // more than it has
        server->answer.payload_bytes = server->request->room_bytes + 1;
        break;
    }
}

static enum weft_result handle(struct weft_server *server)
{
    int *files = server->priv;
    char start[9], codes[4];
    struct payload payload;
    size_t offset = 0;
    if (pread(server->input_fd, start, sizeof start, 0) != (ssize_t)sizeof start)
        return WEFT_ERR_FORMAT;
    const int before = (*files)++;
    if (start[8] == 'z' && before) // only in the first place, whatever was there before
        _exit(8);
    make_good(&payload, codes);
    weft_wire_align(sizeof payload.frame + payload.frame.info_bytes, &offset);
    payload.frame.planes_offset = offset;
    char *room = weft_server_map(server, offset + sizeof codes);
    if (!room)
        return WEFT_OK;
    lie(server, start[8], &payload);
    memcpy(room, &payload, offset < sizeof payload ? offset : sizeof payload);
    memcpy(room + offset, codes, sizeof codes);
    return WEFT_OK;
}

int main(int argc, char **argv)
{
    int files = 0;
    return weft_server_run(argc, argv, handle, &files);
}
