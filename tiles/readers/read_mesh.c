// SPDX-License-Identifier: BSD-3-Clause
// weft-read-mesh: triangles of OBJ, PLY and glTF files, by assimp.
#include "tiles/process/server.h"

static enum weft_result handle(struct weft_server *server)
{
    return weft_server_fail(server, WEFT_ERR_UNSUPPORTED, "meshes cannot be read yet");
}

int main(int argc, char **argv)
{
    return weft_server_run(argc, argv, handle, NULL);
}
