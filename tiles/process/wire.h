// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/wire.h - messages between libweft and its reader programs (not installed).
// The room tiles/process starts programs that read and write files, and carries questions and
// answers; what these say of volumes and images stands in volume_wire.h, image_wire.h and
// mesh_wire.h.
// One SOCK_SEQPACKET socket pair per reader, descriptor 3 in the reader. The caller sends a request
// with a memfd for the answer's payload (and, for WRITE, one with the request's payload); the
// reader fills it and answers. A request for a FRAME comes with a file of its own, and its answer
// lies in memory that both keep mapped, a room: fresh memory costs a quarter of decoding. Several
// such requests may wait in the socket, and are answered in their order. The reader ends when the
// socket closes, whatever it is doing. Both ends are built together; a version that differs is
// refused.
#ifndef WEFT_TILES_PROCESS_WIRE_H
#define WEFT_TILES_PROCESS_WIRE_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

enum { WEFT_WIRE_MAGIC = 0x77656674, WEFT_WIRE_VERSION = 13, WEFT_WIRE_FD = 3 };

// Rooms of a reader, and requests that wait, at most.
enum { WEFT_WIRE_ROOMS = 4 };

enum weft_wire_op {
    WEFT_WIRE_LIST, // volumes: all grids; payload of a struct weft_raw_layout where `raw` is set.
                    // -> struct weft_wire_grid, its metadata; again for each grid
    WEFT_WIRE_OPEN, // volumes: payload of the layout, where `raw` is set, and the grid's name and a
                    // NUL (none = the first supported one). -> one struct weft_wire_grid, metadata
    WEFT_WIRE_FIND, // VDB: payload of a struct weft_region. -> brick origins, then tiles (counts in
                    // the answer)
    WEFT_WIRE_READ, // volumes: payload of brick origins. -> count * 512 floats
    WEFT_WIRE_WRITE_BEGIN,  // VDB writer: payload of struct weft_wire_volume and its metadata, for
                            // each grid. -> nothing
    WEFT_WIRE_WRITE_ADD,    // VDB writer: `part` is the grid; payload of struct weft_wire_lot etc.
                            // -> nothing
    WEFT_WIRE_WRITE,        // VDB writer: -> nothing; the file is written, count[0] bytes of it
    WEFT_WIRE_IMAGE_INFO,   // EXR: `part`.  -> struct weft_wire_image, channels, the part's header
    WEFT_WIRE_IMAGE_PIXELS, // EXR: `part`, rows. -> planes of float or, for uint channels,
                            // uint32_t, in the order of the channels, of count[1] rows from row
                            // count[0] of the data window on: those asked for, and what is packed
                            // with them
    WEFT_WIRE_IMAGE_FRAME,  // EXR, PNG, TIFF: `part`, of another file where one is attached. -> in
                            // the room, or in the payload, as image_wire.h says
    WEFT_WIRE_IMAGE_WRITE,  // TIFF writer: payload as image_wire.h says -> nothing; the file is
                            // written, count[0] bytes of it
    WEFT_WIRE_MESH, // OBJ, PLY, glTF: `part` is one of weft_mesh_kind. -> as mesh_wire.h says
};

// Descriptors that come with a request, in this order.
enum weft_wire_attached {
    WEFT_WIRE_ATTACHED_ANSWER = 1,  // memfd for the answer's payload
    WEFT_WIRE_ATTACHED_PAYLOAD = 2, // memfd with the request's
    WEFT_WIRE_ATTACHED_FILE = 4,    // read-only; the one before is closed
    WEFT_WIRE_ATTACHED_ROOM = 8,    // memfd of room_bytes, of fixed size; becomes room `room`
    WEFT_WIRE_ATTACHED_COUNT = 4
};

// Why a FRAME has no payload although nothing is wrong.
enum weft_wire_verdict {
    WEFT_WIRE_GIVEN,
    WEFT_WIRE_NO_ROOM,       // it needs a room of count[0] bytes
    WEFT_WIRE_OTHER_PROGRAM, // weft-read-dwa reads what weft-read-exr does not, and the reverse
    WEFT_WIRE_VERDICT_COUNT
};

struct weft_wire_request {
    uint32_t magic, version;
    uint32_t op;
    uint32_t rest, component; // OPEN: as in struct weft_volume_open_params
    uint32_t raw;             // LIST, OPEN: 1: the payload begins with a struct weft_raw_layout
    uint32_t part;            // of an image, from 0
    uint32_t threads;         // IMAGE_PIXELS, _FRAME: that decode at once, at most
    uint32_t attached;        // of enum weft_wire_attached
    uint32_t room;            // FRAME: where the answer goes, below WEFT_WIRE_ROOMS
    uint32_t info_only;       // FRAME: 1: without planes
    uint32_t first_row, rows; // IMAGE_PIXELS: of the data window; rows 0: all
    uint64_t room_bytes;      // that the room has
    uint64_t payload_bytes;   // in the request's payload memfd, 0 = none
};

struct weft_wire_answer {
    uint32_t magic, version;
    int32_t result;         // enum weft_result; payload and counts are valid only with WEFT_OK
    uint32_t verdict;       // enum weft_wire_verdict
    uint64_t payload_bytes; // size of the answer's payload memfd, or of what lies in the room
    uint64_t count[2];      // as the op says
    char message[512];      // one line for the log, why it failed
};

WEFT_END_DECLS
#endif
