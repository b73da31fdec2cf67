// SPDX-License-Identifier: BSD-3-Clause
// In the place of weft-write-vdb: says that all is well, whatever it leaves. WEFT_LIE: the bytes
// that it tells of, and those that it writes; "vdb" before them: begun as a VDB file.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tiles/process/server.h"
#include "tiles/volume/volume_wire.h"

static enum weft_result handle(struct weft_server *server)
{
    static const char magic[8] = {' ', 'B', 'D', 'V'}, zeros[1000];
    const char *lie = getenv("WEFT_LIE");
    bool begun = strncmp(lie, "vdb ", 4) == 0;
    char *end;
    server->answer.count[0] = strtoull(lie + (begun ? 4 : 0), &end, 10);
    size_t size = strtoull(end, NULL, 10);
    if (pwrite(server->input_fd, zeros, size, 0) < 0 ||
        (begun && pwrite(server->input_fd, magic, sizeof magic, 0) < 0))
        return WEFT_ERR_WRITE;
    return WEFT_OK;
}

int main(int argc, char **argv)
{
    return weft_server_run(argc, argv, handle, NULL);
}
